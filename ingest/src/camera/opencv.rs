//! Calibrations of others: `FileStorage` files of `OpenCV` in YAML, `camera_info` files of ROS, and plain lists of numbers in YAML.
//!
//! What is read is a camera matrix (`camera_matrix`, `cameraMatrix`, `M1`, `K`, .. or `fx`, `fy`, `cx`, `cy`), coefficients k1 k2 p1 p2 k3
//! (`distortion_coefficients`, `dist_coeffs`, `D1`, `D`, .. or each by its name) and the picture's size. What [`Lens`] cannot
//! say is refused by name: the rational, thin prism and tilted models where their coefficients are not nought, fisheyes, skew.
//! Names are compared without case and underscores.

mod write;

use std::fmt;

use nalgebra::Vector2;
use saphyr_parser::{Event, Parser};

use super::lens::Lens;
use super::picture::Place;

pub use write::write;

/// A calibration is a page: longer text is none.
const BYTES_MAX: usize = 4 << 20;

/// Names on a level.
const NAMES_MAX: usize = 1000;

/// Levels of nesting.
const NESTING_MAX: usize = 16;

/// A camera matrix, and the coefficients that go with it, the likeliest first.
const NAMES: [(&str, &[&str]); 10] = [
    (
        "cameramatrix",
        &["distortioncoefficients", "distcoeffs", "distcoefs", "distortioncoeffs", "distortion", "dist", "d"],
    ),
    ("cameramatrix1", &["distcoeffs1", "distortioncoefficients1", "d1"]),
    ("cameramatrix2", &["distcoeffs2", "distortioncoefficients2", "d2"]),
    ("m1", &["d1", "distcoeffs1"]),
    ("m2", &["d2", "distcoeffs2"]),
    ("k1", &["d1", "distcoeffs1"]),
    ("k2", &["d2", "distcoeffs2"]),
    ("intrinsicmatrix", &["distortioncoefficients", "distcoeffs", "distortion"]),
    ("mtx", &["dist", "distcoeffs"]),
    ("k", &["d", "distortion", "dist", "distcoeffs"]),
];

/// The coefficients in `OpenCV`'s order, and the model that brings them.
const COEFFICIENTS: [(&str, &str); 14] = [
    ("k1", ""),
    ("k2", ""),
    ("p1", ""),
    ("p2", ""),
    ("k3", ""),
    ("k4", "rational"),
    ("k5", "rational"),
    ("k6", "rational"),
    ("s1", "thin prism"),
    ("s2", "thin prism"),
    ("s3", "thin prism"),
    ("s4", "thin prism"),
    ("taux", "tilted sensor"),
    ("tauy", "tilted sensor"),
];

/// Numbers of coefficients that `OpenCV` writes.
const COUNTS: [usize; 6] = [0, 4, 5, 8, 12, 14];

/// Names of models whose coefficients are those of [`Lens`].
const KNOWN: [&str; 8] = ["plumbbob", "rationalpolynomial", "radtan", "brownconrady", "pinhole", "opencv", "none", ""];

/// Names of fisheyes.
const FISHEYES: [&str; 5] = ["fisheye", "equidistant", "equi", "kannalabrandt", "omnidirectional"];

/// A lens as it was read.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Calibrated {
    /// The lens. Its uncertainty is not in the file.
    pub lens: Lens,
    /// Width and height of the pictures it is for, in px, where the file says it.
    pub size_px: Option<(usize, usize)>,
}

/// Why a calibration cannot be read.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum OpenCvError {
    /// No YAML.
    Syntax {
        /// The line, from 1.
        line: usize,
        /// What is wrong.
        what: String,
    },
    /// Another format.
    Format {
        /// Its name.
        name: &'static str,
    },
    /// A name that is not there.
    Missing {
        /// What is looked for.
        what: &'static str,
    },
    /// Several cameras.
    Several {
        /// Their matrices, as the file names them.
        names: Vec<String>,
    },
    /// No such camera.
    NoCamera {
        /// The name asked for.
        wanted: String,
        /// Those that are there.
        names: Vec<String>,
    },
    /// A name that stands twice.
    Twice {
        /// The line, from 1.
        line: usize,
        /// The name.
        name: String,
    },
    /// Something that is no finite number.
    Number {
        /// The line, from 1.
        line: usize,
        /// The name.
        name: String,
        /// What stands there.
        found: String,
    },
    /// Another number of values.
    Count {
        /// The line, from 1.
        line: usize,
        /// The name.
        name: String,
        /// How many are expected.
        expected: &'static str,
        /// How many there are.
        found: usize,
    },
    /// A matrix that is none of a camera.
    Matrix {
        /// The line, from 1.
        line: usize,
        /// What is wrong.
        what: String,
    },
    /// A model with more than k1, k2, p1, p2, k3.
    Model {
        /// The line, from 1.
        line: usize,
        /// Its name.
        model: String,
        /// The coefficient that is not nought, and its value.
        coefficient: Option<(&'static str, f64)>,
    },
    /// A fisheye.
    Fisheye {
        /// The line, from 1.
        line: usize,
    },
}

impl fmt::Display for OpenCvError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let refit = "calibrate again with k1, k2, p1, p2, k3 only";
        match self {
            Self::Syntax { line, what } => write!(f, "line {line}: no YAML: {what}"),
            Self::Format { name } => write!(f, "{name} is not read: write the calibration as YAML (`.yml`)"),
            Self::Missing { what } => write!(f, "no {what}"),
            Self::Several { names } => write!(f, "several cameras ({}): say which", names.join(", ")),
            Self::NoCamera { wanted, names } => {
                write!(
                    f,
                    "no camera matrix {wanted:?}; there are: {}",
                    if names.is_empty() { "none".to_owned() } else { names.join(", ") }
                )
            }
            Self::Twice { line, name } => write!(f, "line {line}: {name} stands twice"),
            Self::Number { line, name, found } => {
                write!(f, "line {line}: {name}: expected a finite number, found {found:?}")
            }
            Self::Count { line, name, expected, found } => {
                write!(f, "line {line}: {name}: expected {expected} numbers, found {found}")
            }
            Self::Matrix { line, what } => write!(f, "line {line}: no camera matrix: {what}"),
            Self::Model { line, model, coefficient: Some((name, value)) } => {
                write!(f, "line {line}: the {model} model ({name} = {value}) is not supported: {refit}")
            }
            Self::Model { line, model, coefficient: None } => {
                write!(f, "line {line}: the distortion model {model:?} is not supported: {refit}")
            }
            Self::Fisheye { line } => write!(f, "line {line}: the fisheye model is not supported: {refit}"),
        }
    }
}

impl std::error::Error for OpenCvError {}

/// What stands behind a name.
#[derive(Debug, Clone, PartialEq)]
enum Value {
    Scalar(String),
    /// Any depth of lists is one list: numpy writes a matrix as rows.
    List(Vec<(usize, String)>),
    Map(Vec<Entry>),
}

#[derive(Debug, Clone, PartialEq)]
struct Entry {
    name: String,
    line: usize,
    value: Value,
}

/// Reads the lens of a calibration; `camera` is the name of its matrix (`M2`) where there are several.
///
/// # Errors
/// Why it cannot be read, with the line.
pub fn read(text: &str, camera: Option<&str>) -> Result<Calibrated, OpenCvError> {
    let entries = entries(text)?;
    let named = |name: &str| entries.iter().find(|entry| plain(&entry.name) == name);
    fisheye_or_unknown(&entries)?;
    let matrices: Vec<(&Entry, &[&str])> = entries
        .iter()
        .filter(|entry| !matches!(entry.value, Value::Scalar(_)))
        .filter_map(|entry| NAMES.iter().find(|(name, _)| *name == plain(&entry.name)).map(|(_, with)| (entry, *with)))
        .collect();
    let names = || matrices.iter().map(|(entry, _)| entry.name.clone()).collect();
    let chosen = match camera {
        Some(wanted) => {
            let found = matrices.iter().find(|(entry, _)| plain(&entry.name) == plain(wanted));
            Some(found.ok_or_else(|| OpenCvError::NoCamera { wanted: wanted.to_owned(), names: names() })?)
        }
        None if matrices.len() > 1 => return Err(OpenCvError::Several { names: names() }),
        None => matrices.first(),
    };
    let ([fx, fy, cx, cy], of_matrix) = match chosen {
        Some((entry, with)) => (intrinsics(entry)?, *with),
        None => match named("fx") {
            Some(_) => (by_name(&entries)?, NAMES[0].1),
            None => {
                return Err(OpenCvError::Missing {
                    what: "camera matrix (`camera_matrix`, `M1`, `K`, or `fx`, `fy`, `cx`, `cy`)",
                });
            }
        },
    };
    let listed = of_matrix.iter().find_map(|name| named(name).filter(|entry| !matches!(entry.value, Value::Scalar(_))));
    let (radial, tangential) = match listed {
        Some(entry) => coefficients(&numbers(entry)?, |found| OpenCvError::Count {
            line: entry.line,
            name: entry.name.clone(),
            expected: "4, 5, 8, 12 or 14",
            found,
        })?,
        None => coefficients_by_name(&entries)?,
    };
    let lens = Lens { focal_px: Vector2::new(fx, fy), centre_px: Place::new(cx, cy), radial, tangential };
    Ok(Calibrated { lens, size_px: size(&entries)? })
}

/// A name without case and underscores.
fn plain(name: &str) -> String {
    name.chars().filter(|c| !matches!(c, '_' | '-' | ' ')).flat_map(char::to_lowercase).collect()
}

/// The names of the file's uppermost level and what stands behind them.
fn entries(text: &str) -> Result<Vec<Entry>, OpenCvError> {
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let first = text.trim_start();
    for (sign, name) in [("<", "XML"), ("{", "JSON")] {
        if first.starts_with(sign) {
            return Err(OpenCvError::Format { name });
        }
    }
    if text.len() > BYTES_MAX {
        return Err(OpenCvError::Syntax { line: 1, what: format!("more than {BYTES_MAX} bytes") });
    }
    // OpenCV writes `%YAML:1.0`, which is no directive of YAML; a comment of the same length keeps the lines.
    let owned = text.strip_prefix("%YAML:").map(|rest| format!("#YAML:{rest}"));
    let mut open: Vec<(Value, usize)> = vec![];
    // The name that waits for its value, by level.
    let mut waiting: Vec<Option<(String, usize)>> = vec![];
    for event in Parser::new_from_str(owned.as_deref().unwrap_or(text)) {
        let (event, span) =
            event.map_err(|e| OpenCvError::Syntax { line: e.marker().line(), what: e.info().to_owned() })?;
        let line = span.start.line();
        let wrong = |what: &str| OpenCvError::Syntax { line, what: what.to_owned() };
        let (value, at) = match event {
            Event::Scalar(scalar, ..) => (Value::Scalar(scalar.into_owned()), line),
            Event::SequenceStart(..) | Event::MappingStart(..) => {
                if open.len() >= NESTING_MAX {
                    return Err(wrong("too many levels"));
                }
                let is_map = matches!(event, Event::MappingStart(..));
                open.push((if is_map { Value::Map(vec![]) } else { Value::List(vec![]) }, line));
                waiting.push(None);
                continue;
            }
            Event::SequenceEnd | Event::MappingEnd => {
                waiting.pop();
                match open.pop() {
                    Some(closed) => closed,
                    None => continue,
                }
            }
            Event::Alias(_) => return Err(wrong("references are not read")),
            _ => continue,
        };
        let Some((parent, _)) = open.last_mut() else {
            return match value {
                Value::Map(entries) => Ok(entries),
                _ => Err(wrong("expected names and values")),
            };
        };
        match (parent, value) {
            (Value::List(all), Value::Scalar(scalar)) => all.push((at, scalar)),
            (Value::List(all), Value::List(more)) => all.extend(more),
            // What is listed with names is no matrix: it stays an odd number.
            (Value::List(all), Value::Map(_)) => all.push((at, "names and values".to_owned())),
            (Value::Map(entries), value) => {
                let Some(name) = waiting.last_mut() else { continue };
                match (name.take(), value) {
                    (Some((key, line)), value) => {
                        if entries.iter().any(|entry| entry.name == key) {
                            return Err(OpenCvError::Twice { line, name: key });
                        }
                        if entries.len() >= NAMES_MAX {
                            return Err(wrong("too many names"));
                        }
                        entries.push(Entry { name: key, line, value });
                    }
                    (None, Value::Scalar(key)) => *name = Some((key, at)),
                    (None, _) => return Err(wrong("expected a name")),
                }
            }
            (Value::Scalar(_), _) => {}
        }
    }
    Err(OpenCvError::Missing { what: "text" })
}

/// Refuses a file that says of itself that its model is another one.
fn fisheye_or_unknown(entries: &[Entry]) -> Result<(), OpenCvError> {
    for entry in entries {
        let Value::Scalar(said) = &entry.value else { continue };
        let (name, said) = (plain(&entry.name), plain(said));
        let is_model =
            matches!(name.as_str(), "distortionmodel" | "cameramodel" | "model" | "modeltype" | "cameratype");
        let is_flag = matches!(name.as_str(), "fisheyemodel" | "fisheye" | "usefisheye" | "isfisheye");
        let no = matches!(said.as_str(), "0" | "false" | "no" | "off" | "");
        if (is_flag && !no) || (is_model && FISHEYES.iter().any(|fisheye| said.contains(fisheye))) {
            return Err(OpenCvError::Fisheye { line: entry.line });
        }
        if name == "distortionmodel" && !KNOWN.contains(&said.as_str()) {
            return Err(OpenCvError::Model { line: entry.line, model: said, coefficient: None });
        }
    }
    Ok(())
}

fn number(line: usize, name: &str, text: &str) -> Result<f64, OpenCvError> {
    let value = text.trim().parse::<f64>().ok().filter(|v| v.is_finite());
    value.ok_or_else(|| OpenCvError::Number { line, name: name.to_owned(), found: text.chars().take(40).collect() })
}

/// The numbers of a list, or of the `data` of a matrix, with their lines.
fn numbers(entry: &Entry) -> Result<Vec<(usize, f64)>, OpenCvError> {
    let list = match &entry.value {
        Value::List(list) => list,
        Value::Map(of) => match of.iter().find(|inner| inner.name == "data").map(|inner| &inner.value) {
            Some(Value::List(list)) => list,
            _ => {
                return Err(OpenCvError::Matrix {
                    line: entry.line,
                    what: format!("{} has no list `data`", entry.name),
                });
            }
        },
        Value::Scalar(text) => return Ok(vec![(entry.line, number(entry.line, &entry.name, text)?)]),
    };
    list.iter().map(|(line, text)| Ok((*line, number(*line, &entry.name, text)?))).collect()
}

fn intrinsics(entry: &Entry) -> Result<[f64; 4], OpenCvError> {
    let all = numbers(entry)?;
    let values: Vec<f64> = all.iter().map(|(_, value)| *value).collect();
    let [fx, skew, cx, a, fy, cy, b, c, one] = values[..] else {
        return Err(OpenCvError::Count {
            line: entry.line,
            name: entry.name.clone(),
            expected: "9",
            found: values.len(),
        });
    };
    let wrong = |what: String| Err(OpenCvError::Matrix { line: entry.line, what });
    let is_nought = |v: f64| v == 0.0;
    if ![a, b, c].into_iter().all(is_nought) || !is_nought(one - 1.0) {
        return wrong("expected fx 0 cx, 0 fy cy, 0 0 1".to_owned());
    }
    if !is_nought(skew) {
        return wrong(format!("its axes are skew ({skew} px), which is not supported"));
    }
    focal([fx, fy, cx, cy], entry.line)
}

fn focal(intrinsics: [f64; 4], line: usize) -> Result<[f64; 4], OpenCvError> {
    let [fx, fy, ..] = intrinsics;
    if fx > 0.0 && fy > 0.0 {
        return Ok(intrinsics);
    }
    Err(OpenCvError::Matrix { line, what: format!("focal lengths must be above 0 px, found {fx} and {fy}") })
}

/// A number that stands alone behind its name.
fn alone(entries: &[Entry], name: &str) -> Result<Option<(usize, f64)>, OpenCvError> {
    let found = entries.iter().find(|entry| plain(&entry.name) == name);
    let Some((Entry { line, value: Value::Scalar(text), .. }, entry)) = found.map(|e| (e, e)) else { return Ok(None) };
    Ok(Some((*line, number(*line, &entry.name, text)?)))
}

fn by_name(entries: &[Entry]) -> Result<[f64; 4], OpenCvError> {
    let mut all = [0.0; 4];
    let mut at = 1;
    for (value, name) in all.iter_mut().zip(["fx", "fy", "cx", "cy"]) {
        let missing = OpenCvError::Missing {
            what: "focal lengths and principal point: all of `fx`, `fy`, `cx`, `cy` are needed",
        };
        (at, *value) = alone(entries, name)?.ok_or(missing)?;
    }
    focal(all, at)
}

fn coefficients_by_name(entries: &[Entry]) -> Result<([f64; 3], [f64; 2]), OpenCvError> {
    let mut all = vec![];
    let mut any = false;
    for (name, _) in COEFFICIENTS {
        let found = alone(entries, name)?;
        any |= found.is_some();
        all.push(found.unwrap_or((1, 0.0)));
    }
    if !any {
        let what = "distortion coefficients (`distortion_coefficients`, `dist_coeffs`, `D1`, or `k1`, `k2`, ..); of a lens without, a list of four noughts";
        return Err(OpenCvError::Missing { what });
    }
    coefficients(&all, |found| OpenCvError::Count { line: 1, name: "k1".to_owned(), expected: "14", found })
}

fn coefficients(
    all: &[(usize, f64)],
    count: impl Fn(usize) -> OpenCvError,
) -> Result<([f64; 3], [f64; 2]), OpenCvError> {
    if !COUNTS.contains(&all.len()) {
        return Err(count(all.len()));
    }
    for ((line, value), (name, model)) in all.iter().zip(COEFFICIENTS).skip(5) {
        if *value != 0.0 {
            return Err(OpenCvError::Model { line: *line, model: model.to_owned(), coefficient: Some((name, *value)) });
        }
    }
    let of = |i: usize| all.get(i).map_or(0.0, |(_, value)| *value);
    Ok(([of(0), of(1), of(4)], [of(2), of(3)]))
}

fn size(entries: &[Entry]) -> Result<Option<(usize, usize)>, OpenCvError> {
    let of = |names: [&str; 2]| -> Result<Option<usize>, OpenCvError> {
        for name in names {
            if let Some((line, value)) = alone(entries, name)? {
                // Whole, and below what a picture has.
                #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
                return if (1.0..1e6).contains(&value) && value.fract() == 0.0 {
                    Ok(Some(value as usize))
                } else {
                    Err(OpenCvError::Number { line, name: name.to_owned(), found: value.to_string() })
                };
            }
        }
        Ok(None)
    };
    Ok(of(["imagewidth", "width"])?.zip(of(["imageheight", "height"])?))
}

#[cfg(test)]
mod tests {
    use super::*;

    const OF_OPENCV: &str = "%YAML:1.0\n---\ncalibration_time: \"Mon\"\nimage_width: 640\nimage_height: 480\ncamera_matrix: !!opencv-matrix\n   rows: 3\n   cols: 3\n   dt: d\n   data: [ 5.1e+02, 0., 3.1e+02, 0.,\n       5.2e+02, 2.4e+02, 0., 0., 1. ]\ndistortion_coefficients: !!opencv-matrix\n   rows: 5\n   cols: 1\n   dt: d\n   data: [ -2.6e-01, -4.7e-02, 1.8e-03, -3.0e-04, 2.5e-01 ]\navg_reprojection_error: 0.2\n";

    fn truth() -> Lens {
        Lens {
            focal_px: Vector2::new(510.0, 520.0),
            centre_px: Place::new(310.0, 240.0),
            radial: [-0.26, -0.047, 0.25],
            tangential: [0.0018, -0.0003],
        }
    }

    #[test]
    fn every_way_of_writing_a_lens_gives_it() {
        let ros = "image_width: 640\nimage_height: 480\ncamera_name: left\ncamera_matrix:\n  rows: 3\n  cols: 3\n  data: [510, 0, 310, 0, 520, 240, 0, 0, 1]\ndistortion_model: plumb_bob\ndistortion_coefficients:\n  rows: 1\n  cols: 5\n  data: [-0.26, -0.047, 0.0018, -0.0003, 0.25]\nrectification_matrix:\n  rows: 3\n  cols: 3\n  data: [1, 0, 0, 0, 1, 0, 0, 0, 1]\n";
        let numpy = "width: 640\nheight: 480\ncameraMatrix:\n- [510.0, 0.0, 310.0]\n- [0.0, 520.0, 240.0]\n- [0.0, 0.0, 1.0]\ndist_coeffs:\n- [-0.26, -0.047, 0.0018, -0.0003, 0.25]\n";
        let message = "width: 640\nheight: 480\ndistortion_model: rational_polynomial\nd: [-0.26, -0.047, 0.0018, -0.0003, 0.25, 0.0, 0.0, 0.0]\nk: [510, 0, 310, 0, 520, 240, 0, 0, 1]\n";
        let names = "image_width: 640\nimage_height: 480\nfx: 510\nfy: 520\ncx: 310\ncy: 240\nk1: -0.26\nk2: -0.047\np1: 0.0018\np2: -0.0003\nk3: 0.25\n";
        for text in [OF_OPENCV, ros, numpy, message, names] {
            let read = read(text, None).unwrap_or_else(|e| panic!("{e}: {text}"));
            assert_eq!(read, Calibrated { lens: truth(), size_px: Some((640, 480)) }, "{text}");
        }
        let older = OF_OPENCV.replace("camera_matrix", "Camera_Matrix").replace("distortion_c", "Distortion_C");
        assert_eq!(read(&older, None).unwrap().lens, truth());
        let four = "K: [510, 0, 310, 0, 520, 240, 0, 0, 1]\nD: [0.1, 0.2, 0.3, 0.4]\n";
        let lens = read(four, None).unwrap().lens;
        assert_eq!((lens.radial, lens.tangential), ([0.1, 0.2, 0.0], [0.3, 0.4]));
        let none = "K: [510, 0, 310, 0, 520, 240, 0, 0, 1]\nD: []\n";
        assert_eq!(
            read(none, None).unwrap(),
            Calibrated { lens: Lens { radial: [0.0; 3], tangential: [0.0; 2], ..truth() }, size_px: None }
        );
    }

    /// As the sample `intrinsics.yml` of `OpenCV`: two cameras, fourteen coefficients.
    const STEREO: &str = "%YAML:1.0\n---\nM1: !!opencv-matrix\n   rows: 3\n   cols: 3\n   dt: d\n   data: [ 510., 0., 310., 0.,\n       520., 240., 0., 0., 1. ]\nD1: !!opencv-matrix\n   rows: 14\n   cols: 1\n   dt: d\n   data: [ -5.5e-02, 7.8e-02, 0., 0.,\n       -1.4e-01, 0., 0., -1.4e-01, 0., 0.,\n       0., 0., 0., 0. ]\nM2: !!opencv-matrix\n   rows: 3\n   cols: 3\n   dt: d\n   data: [ 511., 0., 327., 0.,\n       511., 261., 0., 0., 1. ]\nD2: !!opencv-matrix\n   rows: 14\n   cols: 1\n   dt: d\n   data: [ -8.1e-02, 2.1e-01, 0., 0., -2.3e-01, 0., 0., 0., 0., 0., 0., 0., 0., 0. ]\n";

    #[test]
    fn of_two_cameras_one_is_named_and_a_rational_model_is_refused_with_its_line() {
        let several = read(STEREO, None).unwrap_err();
        assert_eq!(several, OpenCvError::Several { names: vec!["M1".into(), "M2".into()] });
        let rational = read(STEREO, Some("M1")).unwrap_err();
        let coefficient = Some(("k6", -0.14));
        assert_eq!(rational, OpenCvError::Model { line: 14, model: "rational".into(), coefficient });
        assert!(rational.to_string().starts_with("line 14: the rational model (k6 = -0.14)"), "{rational}");
        let second = read(STEREO, Some("m2")).unwrap().lens;
        assert_eq!((second.focal_px.x, second.radial), (511.0, [-0.081, 0.21, -0.23]));
        let none = read(STEREO, Some("M3")).unwrap_err();
        assert!(matches!(&none, OpenCvError::NoCamera { names, .. } if names.len() == 2), "{none}");
        for (at, name, model) in [(9, "s2", "thin prism"), (12, "taux", "tilted sensor")] {
            let mut coefficients = ["0"; 14];
            coefficients[at] = "0.5";
            let text = format!("K: [510, 0, 310, 0, 520, 240, 0, 0, 1]\nD: [{}]\n", coefficients.join(", "));
            let expected = OpenCvError::Model { line: 2, model: model.into(), coefficient: Some((name, 0.5)) };
            assert_eq!(read(&text, None), Err(expected));
        }
    }

    #[test]
    fn what_is_wrong_is_told_with_its_line() {
        let told = |text: &str| read(text, None).unwrap_err().to_string();
        let with = |from: &str, to: &str| told(&OF_OPENCV.replace(from, to));
        assert!(with("5.2e+02", "abc").starts_with("line 11: camera_matrix: expected a finite number, found \"abc\""));
        assert!(with("5.2e+02", ".Nan").starts_with("line 11: "));
        assert!(with("5.1e+02", "-5").starts_with("line 6: no camera matrix: focal lengths"));
        assert!(
            with("[ 5.1e+02, 0.,", "[ 5.1e+02, 0.3,").contains("line 6: no camera matrix: its axes are skew (0.3 px)")
        );
        assert!(with(", 1. ]", " ]").starts_with("line 6: camera_matrix: expected 9 numbers, found 8"));
        assert!(
            with(", 2.5e-01 ]", ", 1, 2 ]")
                .starts_with("line 12: distortion_coefficients: expected 4, 5, 8, 12 or 14 numbers, found 6")
        );
        assert!(with("avg_rep", "image_width: 3\navg_rep").starts_with("line 17: image_width stands twice"));
        assert!(with("image_width: 640", "image_width: 6.5").contains("imagewidth"));
        assert!(with("avg_rep", "fisheye_model: 1\navg_rep").starts_with("line 17: the fisheye model"));
        assert!(with("avg_rep", "distortion_model: equidistant\navg_rep").starts_with("line 17: the fisheye model"));
        assert!(with("avg_rep", "distortion_model: fov\navg_rep").contains("\"fov\" is not supported"));
        assert!(with("distortion_coefficients", "lens").starts_with("no distortion coefficients"));
        assert!(with("camera_matrix", "lens").starts_with("no camera matrix"));
        assert!(with("camera_matrix: !!opencv-matrix", "camera_matrix: [ !!").starts_with("line "));
        assert!(told("<?xml version=\"1.0\"?><opencv_storage/>").starts_with("XML is not read"));
        assert!(told("{\"K\": []}").starts_with("JSON is not read"));
        assert_eq!(told(""), "no text");
        assert!(told("- 1\n- 2\n").contains("expected names and values"));
        assert!(told("a: &b 1\nc: *b\n").starts_with("line 2: no YAML: references"));
        assert!(told(&format!("a: {}", "[".repeat(500))).contains("line 1"));
    }
}
