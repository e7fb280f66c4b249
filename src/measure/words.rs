//! Lengths, places and files of a command line.

use std::path::Path;

use pneuval_ingest::camera::area::SoughtArea;
use pneuval_ingest::camera::bending::SoughtBending;
use pneuval_ingest::camera::bending::markers::{SoughtMarkers, has_chroma};
use pneuval_ingest::camera::lens::Lens;
use pneuval_ingest::camera::opencv;
use pneuval_ingest::camera::picture::Place;
use pneuval_ingest::camera::scale::{Length, Scale};
use pneuval_ingest::camera::silhouette::{Axis, Sought};
use pneuval_ingest::camera::task::{Sense, Setup, Task, What};
use pneuval_ingest::camera::tone::Tone;
use pneuval_ingest::formats::pictures::names::Pattern;
use pneuval_ingest::limits;
use pneuval_ingest::units::{Dimension, Unit};

use super::arguments::{AxisArgument, BodyArgument, Camera, MeasureAngle, MeasureArea, MeasureDiameter, SenseArgument};
use crate::exit::Failure;

/// What is asked of a diameter.
pub fn diameter(asked: &MeasureDiameter) -> Result<Task, Failure> {
    let axis = asked.axis.map(|axis| match axis {
        AxisArgument::Vertical => Axis::Vertical,
        AxisArgument::Horizontal => Axis::Horizontal,
    });
    let what = What::Diameter(Sought { axis, ..sought(&asked.camera, asked.body)? });
    Ok(Task { what, setup: setup(&asked.camera)? })
}

/// What is asked of a bent finger.
pub fn angle(asked: &MeasureAngle) -> Result<Task, Failure> {
    if let Some(heading) = asked.heading.filter(|heading| !heading.is_finite()) {
        return Err(Failure::Flag {
            flag: "--heading",
            found: format!("`{heading}`"),
            expected: "degrees from the right, downwards".to_owned(),
            next: "write it as 90 for a finger that hangs down".to_owned(),
        });
    }
    let root = asked.root.as_deref().map(|root| place("--root", root)).transpose()?;
    let heading_rad = asked.heading.map(f64::to_radians);
    let body = sought(&asked.camera, asked.body)?;
    let sense = match asked.sense {
        SenseArgument::Clockwise => Sense::Clockwise,
        SenseArgument::Counterclockwise => Sense::Counterclockwise,
    };
    // clap sees to it that all three stand together.
    let what = match (&asked.markers, asked.count, root) {
        (Some(text), Some(count), Some(root)) => {
            let colour = markers(text)?;
            What::Markers(
                SoughtMarkers { colour, count: usize::from(count), root, region: body.region, heading_rad },
                sense,
            )
        }
        _ => What::Angle(SoughtBending { body, root, heading_rad }, sense),
    };
    Ok(Task { what, setup: setup(&asked.camera)? })
}

/// A colour that is told from grey.
fn markers(text: &str) -> Result<[f64; 3], Failure> {
    let rgb = colour("--markers", text)?;
    has_chroma(rgb).then_some(rgb).ok_or_else(|| Failure::Flag {
        flag: "--markers",
        found: format!("`{text}`, a grey"),
        expected: "a colour: markers are told by what they have beyond grey".to_owned(),
        next: "take red, green and blue from the middle of a marker, as 220,40,30".to_owned(),
    })
}

/// What is asked of an imprint.
pub fn area(asked: &MeasureArea) -> Result<Task, Failure> {
    if !(asked.specks >= 0.0 && asked.specks.is_finite()) {
        return Err(Failure::Flag {
            flag: "--specks",
            found: format!("`{}`", asked.specks),
            expected: "an area in px², zero or more".to_owned(),
            next: "write it as 30".to_owned(),
        });
    }
    let sought = SoughtArea {
        region: sought(&asked.camera, None)?.region,
        paint: asked.paint.as_deref().map(|text| colour("--paint", text)).transpose()?,
        least_px2: asked.specks,
        fill_holes: asked.fill_holes,
    };
    Ok(Task { what: What::Area(sought), setup: setup(&asked.camera)? })
}

fn sought(camera: &Camera, body: Option<BodyArgument>) -> Result<Sought, Failure> {
    Ok(Sought {
        axis: None,
        is_dark: body.map(|body| matches!(body, BodyArgument::Dark)),
        region: camera.region.as_deref().map(region).transpose()?,
    })
}

/// Camera, scale and tone.
fn setup(camera: &Camera) -> Result<Setup, Failure> {
    let above = |flag, text: &Option<String>| text.as_deref().map(|text| above_zero(flag, text)).transpose();
    Ok(Setup {
        scale: above("--scale", &camera.scale)?.map(|l| Scale { metre_per_px: l.metre, std: l.std }),
        lens: camera.lens.as_deref().map(lens).transpose()?,
        distance: above("--distance", &camera.distance)?,
        offset_m: camera.offset.as_deref().map(|text| length("--offset", text)).transpose()?,
        tone: camera.tone.as_deref().map(tone).transpose()?,
    })
}

/// `srgb`, `linear`, or an exponent.
fn tone(text: &str) -> Result<Tone, Failure> {
    let tone = match text {
        "linear" => Some(Tone::Linear),
        "srgb" => Some(Tone::Srgb),
        _ => text.parse().ok().map(Tone::Gamma),
    };
    tone.filter(|tone| tone.is_sound()).ok_or_else(|| Failure::Flag {
        flag: "--tone",
        found: format!("`{text}`"),
        expected: "linear, srgb, or an exponent above 0".to_owned(),
        next: "write it as srgb, or 2.2".to_owned(),
    })
}

/// `170,40,45`
fn colour(flag: &'static str, text: &str) -> Result<[f64; 3], Failure> {
    let numbers: Option<Vec<f64>> = text.split(',').map(|n| n.trim().parse().ok()).collect();
    let within = |rgb: &[f64; 3]| rgb.iter().all(|v| (0.0..=255.0).contains(v));
    numbers.and_then(|n| n.try_into().ok()).filter(within).ok_or_else(|| Failure::Flag {
        flag,
        found: format!("`{text}`"),
        expected: "red, green and blue, 0 to 255".to_owned(),
        next: "write it as 170,40,45".to_owned(),
    })
}

/// A length above zero and above its standard uncertainty.
pub fn above_zero(flag: &'static str, text: &str) -> Result<Length, Failure> {
    let (metre, std) = length(flag, text)?;
    let expected = "a length above zero and above its uncertainty";
    (metre > 0.0 && std < metre).then_some(Length { metre, std }).ok_or_else(|| bad(flag, text, expected))
}

/// `120,400`: a place in px.
pub fn place(flag: &'static str, text: &str) -> Result<Place, Failure> {
    let numbers: Option<Vec<f64>> = text.split(',').map(|n| n.trim().parse().ok()).collect();
    match numbers.as_deref() {
        Some([x, y]) if x.is_finite() && y.is_finite() => Ok(Place::new(*x, *y)),
        _ => Err(Failure::Flag {
            flag,
            found: format!("`{text}`"),
            expected: "a place in px: x to the right, y down, from the middle of the first pixel".to_owned(),
            next: "write it as 120,400".to_owned(),
        }),
    }
}

/// `9x6`: inner corners in a row, and rows.
pub fn corners(text: &str) -> Result<(usize, usize), Failure> {
    let pair = text.split_once(['x', '×']).and_then(|(a, b)| Some((a.trim().parse().ok()?, b.trim().parse().ok()?)));
    pair.ok_or_else(|| Failure::Flag {
        flag: "--corners",
        found: format!("`{text}`"),
        expected: "inner corners in a row and rows of them: a board of 10 by 7 squares has 9x6".to_owned(),
        next: "write it as 9x6".to_owned(),
    })
}

/// `300,0,450,140`
pub fn region(text: &str) -> Result<[usize; 4], Failure> {
    let numbers: Option<Vec<usize>> = text.split(',').map(|n| n.trim().parse().ok()).collect();
    numbers.and_then(|n| n.try_into().ok()).ok_or_else(|| Failure::Flag {
        flag: "--region",
        found: format!("`{text}`"),
        expected: "left, top, width and height in px".to_owned(),
        next: "write it as 300,0,450,140".to_owned(),
    })
}

pub fn lens(path: &Path) -> Result<Lens, Failure> {
    let bytes = limits::read(path, limits::WRITTEN_BYTES_MAX)?;
    let text = String::from_utf8_lossy(&bytes);
    let calibrated = opencv::read(&text, None).map_err(|why| Failure::Flag {
        flag: "--lens",
        found: format!("{}: {why}", path.display()),
        expected: "a calibration as OpenCV or ROS writes it in YAML".to_owned(),
        next: "correct the file, or calibrate again".to_owned(),
    })?;
    Ok(calibrated.lens)
}

fn bad(flag: &'static str, found: &str, expected: &str) -> Failure {
    Failure::Flag {
        flag,
        found: format!("`{found}`"),
        expected: expected.to_owned(),
        next: "write it as 300mm, or 300mm+-1 with its standard uncertainty".to_owned(),
    }
}

/// `300mm`, `300 mm ± 1`, `300mm+-1`: value and standard uncertainty in m.
fn length(flag: &'static str, text: &str) -> Result<(f64, f64), Failure> {
    let expected = "a number, a unit of length, and its standard uncertainty in the same unit behind `+-`";
    let refused = || bad(flag, text, expected);
    let (value, std) = match text.split_once("+-").or_else(|| text.split_once('±')) {
        Some((value, std)) => (value, std.trim().parse::<f64>().map_err(|_| refused())?),
        None => (text, 0.0),
    };
    let value = value.trim();
    let split = value.find(|c: char| c.is_alphabetic() || c == 'µ').ok_or_else(refused)?;
    let number: f64 = value[..split].trim().parse().map_err(|_| refused())?;
    let unit =
        Unit::parse(value[split..].trim()).filter(|unit| unit.dimension == Dimension::Length).ok_or_else(refused)?;
    let sound = number.is_finite() && std.is_finite() && std >= 0.0;
    sound.then(|| (unit.to_si(number), unit.to_si(std))).ok_or_else(refused)
}

pub fn names(text: &str) -> Result<Pattern, Failure> {
    Pattern::parse(text).map_err(|why| Failure::Flag {
        flag: "--names",
        found: format!("`{text}`: {why}"),
        expected: "names with numbers in braces".to_owned(),
        next: "write it as 'p{pressure:kPa}_{n}.png'".to_owned(),
    })
}
