//! `pneuval measure`: lengths from photographs.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::io::{IsTerminal as _, Write as _};
use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering};

use rayon::prelude::*;
use serde::Serialize;

use pneuval_analysis::report::overlay;
use pneuval_ingest::camera::lens::Lens;
use pneuval_ingest::camera::opencv;
use pneuval_ingest::camera::scale::{Length, Scale};
use pneuval_ingest::camera::silhouette::{Axis, Sought};
use pneuval_ingest::camera::task::{Reading, Setup, Task};
use pneuval_ingest::error::Place;
use pneuval_ingest::formats::pictures::names::Pattern;
use pneuval_ingest::formats::pictures::{open, pictures};
use pneuval_ingest::limits::LOG_BYTES_MAX;
use pneuval_ingest::raw::RawFile;
use pneuval_ingest::units::{Dimension, Unit};
use pneuval_ingest::{IngestError, limits};

use crate::cli::{AxisArgument, BodyArgument, Measure, MeasureDiameter, Measured};
use crate::exit::{Failure, Outcome};
use crate::{output, table};

/// What became of a picture, for `--json`.
#[derive(Serialize)]
struct Told {
    file: String,
    names: Vec<Named>,
    values: Vec<ValueTold>,
    notes: Vec<String>,
    refused: Option<String>,
}

#[derive(Serialize)]
struct Named {
    name: String,
    unit: Option<String>,
    value: Option<f64>,
}

#[derive(Serialize)]
struct ValueTold {
    name: String,
    unit: &'static str,
    value: f64,
    std: Option<f64>,
}

/// Pictures side by side, told while they are measured.
struct Progress {
    done: AtomicUsize,
    of: usize,
    shown: bool,
}

pub fn run(arguments: &Measure) -> Result<Outcome, Failure> {
    let Measured::Diameter(arguments) = &arguments.what;
    diameters(arguments)
}

fn diameters(arguments: &MeasureDiameter) -> Result<Outcome, Failure> {
    let task = Task::Diameter(setup(arguments)?);
    let pattern = arguments.names.as_deref().map(names).transpose()?;
    let raws: Vec<RawFile> = arguments.pictures.iter().map(|path| opened(path)).collect::<Result<_, _>>()?;
    let all: Vec<&RawFile> = raws.iter().flat_map(|raw| pictures(raw)).collect();
    let names = overlay_names(&all);
    if let Some(out) = &arguments.out {
        check_out(out, &arguments.pictures)?;
        std::fs::create_dir_all(out).map_err(|source| IngestError::read(out, source))?;
    }
    let progress = Progress { done: AtomicUsize::new(0), of: all.len(), shown: std::io::stderr().is_terminal() };
    let one = |(raw, name): (&&RawFile, &String)| {
        let found = measured(raw, &task, arguments.out.as_ref().map(|out| out.join(name)).as_deref());
        progress.step();
        found
    };
    let found: Vec<Result<Reading, String>> = all.par_iter().zip(&names).map(one).collect::<Result<_, Failure>>()?;
    progress.end();
    let told: Vec<Told> =
        all.iter().zip(&found).map(|(raw, found)| told(raw, found, &task, pattern.as_ref())).collect();
    if arguments.json {
        output::print_json(&told)?;
    } else {
        output::print(&text(&told, &task))?;
    }
    let readings: Vec<&Reading> = found.iter().flatten().collect();
    task.warnings(&readings).iter().for_each(|warning| output::tell(&format!("note: {warning}")));
    if readings.is_empty() {
        return Err(IngestError::Unusable {
            place: Place::new(&arguments.pictures[0].display().to_string(), None, None),
            expected: "a picture of a body, to be measured".to_owned(),
            found: told.first().and_then(|told| told.refused.clone()).unwrap_or_else(|| "none".to_owned()),
            next: "the reasons stand beside each picture".to_owned(),
        }
        .into());
    }
    let is_lossy = found.iter().any(Result::is_err) || told.iter().any(|t| t.names.iter().any(|n| n.value.is_none()));
    Ok(if is_lossy { Outcome::Open } else { Outcome::Expected })
}

/// Names of overlays: those of the pictures, with a number before those that several have.
fn overlay_names(all: &[&RawFile]) -> Vec<String> {
    let name = |raw: &RawFile| format!("{}-measured.png", raw.file_name());
    let mut counts: BTreeMap<&str, usize> = BTreeMap::new();
    for raw in all {
        *counts.entry(raw.file_name()).or_default() += 1;
    }
    let is_shared = |raw: &RawFile| counts.get(raw.file_name()).is_some_and(|count| *count > 1);
    all.iter()
        .enumerate()
        .map(|(i, raw)| if is_shared(raw) { format!("{}-{}", i + 1, name(raw)) } else { name(raw) })
        .collect()
}

/// Overlays do not lie among the pictures: there they would be measured the next time.
fn check_out(out: &Path, pictures: &[std::path::PathBuf]) -> Result<(), Failure> {
    let real = |path: &Path| std::fs::canonicalize(path).unwrap_or_else(|_| path.to_owned());
    match pictures.iter().find(|path| path.is_dir() && real(path) == real(out)) {
        None => Ok(()),
        Some(path) => Err(Failure::Flag {
            flag: "--out",
            found: format!("`{}`, the folder of the pictures", path.display()),
            expected: "another folder: what is drawn would be measured as a picture the next time".to_owned(),
            next: "name a folder beside it".to_owned(),
        }),
    }
}

fn opened(path: &Path) -> Result<RawFile<'static>, Failure> {
    Ok(RawFile::open(path, &path.display().to_string(), LOG_BYTES_MAX)?)
}

/// Measures a picture, and draws what was measured.
fn measured(raw: &RawFile, task: &Task, out: Option<&Path>) -> Result<Result<Reading, String>, Failure> {
    let picture = match open(raw)? {
        Ok(picture) => picture,
        Err(why) => return Ok(Err(why)),
    };
    let found = task.measure(&picture);
    if let (Ok(reading), Some(path)) = (&found, out) {
        let png = overlay(&picture, &reading.marks, usize::MAX)
            .map_err(|why| IngestError::read(path, std::io::Error::other(why)))?;
        std::fs::write(path, png).map_err(|source| IngestError::read(path, source))?;
    }
    Ok(found)
}

fn told(raw: &RawFile, found: &Result<Reading, String>, task: &Task, pattern: Option<&Pattern>) -> Told {
    let named = |pattern: &Pattern| -> Vec<Named> {
        let read = pattern.read(raw.file_name());
        let of = |(i, field): (usize, &pneuval_ingest::formats::pictures::names::Field)| Named {
            name: field.name.clone(),
            unit: field.unit.clone(),
            value: read.as_ref().and_then(|all| all.get(i)).copied(),
        };
        pattern.fields().enumerate().map(of).collect()
    };
    let values =
        found.as_ref().map_or(vec![], |reading| {
            let columns = task.columns().into_iter().zip(&reading.values);
            let of = |((name, unit), value): ((String, &'static str), &pneuval_ingest::camera::task::Value)| {
                ValueTold { name, unit, value: value.value, std: Some(value.std).filter(|s| s.is_finite()) }
            };
            columns.map(of).collect()
        });
    Told {
        file: raw.name().to_owned(),
        names: pattern.map(named).unwrap_or_default(),
        values,
        notes: found.as_ref().map_or(vec![], |reading| reading.notes.clone()),
        refused: found.as_ref().err().cloned(),
    }
}

fn text(all: &[Told], task: &Task) -> String {
    let mut headers = vec!["picture".to_owned()];
    if let Some(first) = all.first() {
        let head = |n: &Named| n.unit.as_ref().map_or(n.name.clone(), |unit| format!("{} ({unit})", n.name));
        headers.extend(first.names.iter().map(head));
    }
    for (name, unit) in task.columns() {
        headers.push(format!("{name} ({unit})"));
    }
    let headers: Vec<&str> = headers.iter().map(String::as_str).chain(["notes"]).collect();
    let numbers: Vec<usize> = (1..headers.len() - 1).collect();
    let mut table = table::plain(&headers, &numbers);
    for told in all {
        let mut row = vec![told.file.clone()];
        row.extend(told.names.iter().map(|n| n.value.map_or("–".to_owned(), |v| v.to_string())));
        let value = |v: &ValueTold| match v.std {
            Some(std) => format!("{:.3} ± {:.3}", v.value, 1.96 * std),
            None => format!("{:.2}", v.value),
        };
        row.extend(told.values.iter().map(value));
        row.resize(headers.len() - 1, "–".to_owned());
        row.push(told.refused.clone().unwrap_or_else(|| told.notes.join("; ")));
        table.add_row(row);
    }
    table::fit(&mut table);
    let mut out = String::new();
    // Writing to a String cannot fail.
    let _ = writeln!(out, "{}", table.trim_fmt());
    let lost = all.iter().filter(|told| told.refused.is_some()).count();
    let _ = writeln!(out, "{} of {} pictures measured; ± is the 95 % interval", all.len() - lost, all.len());
    out
}

fn setup(arguments: &MeasureDiameter) -> Result<Setup, Failure> {
    let length = |flag: &'static str, text: &Option<String>| text.as_deref().map(|t| length(flag, t)).transpose();
    let above = |flag: &'static str, text: &Option<String>| -> Result<Option<Length>, Failure> {
        match length(flag, text)? {
            Some((metre, std)) if metre > 0.0 && std < metre => Ok(Some(Length { metre, std })),
            Some(_) => {
                Err(bad(flag, text.as_deref().unwrap_or_default(), "a length above zero and above its uncertainty"))
            }
            None => Ok(None),
        }
    };
    Ok(Setup {
        sought: Sought {
            axis: arguments.axis.map(|axis| match axis {
                AxisArgument::Vertical => Axis::Vertical,
                AxisArgument::Horizontal => Axis::Horizontal,
            }),
            is_dark: arguments.body.map(|body| matches!(body, BodyArgument::Dark)),
            region: arguments.region.as_deref().map(region).transpose()?,
        },
        scale: above("--scale", &arguments.scale)?.map(|l| Scale { metre_per_px: l.metre, std: l.std }),
        lens: arguments.lens.as_deref().map(lens).transpose()?,
        distance: above("--distance", &arguments.distance)?,
        offset_m: length("--offset", &arguments.offset)?,
    })
}

/// `300,0,450,140`
fn region(text: &str) -> Result<[usize; 4], Failure> {
    let numbers: Option<Vec<usize>> = text.split(',').map(|n| n.trim().parse().ok()).collect();
    numbers.and_then(|n| n.try_into().ok()).ok_or_else(|| Failure::Flag {
        flag: "--region",
        found: format!("`{text}`"),
        expected: "left, top, width and height in px".to_owned(),
        next: "write it as 300,0,450,140".to_owned(),
    })
}

fn lens(path: &Path) -> Result<Lens, Failure> {
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

fn names(text: &str) -> Result<Pattern, Failure> {
    Pattern::parse(text).map_err(|why| Failure::Flag {
        flag: "--names",
        found: format!("`{text}`: {why}"),
        expected: "names with numbers in braces".to_owned(),
        next: "write it as 'p{pressure:kPa}_{n}.png'".to_owned(),
    })
}

impl Progress {
    fn step(&self) {
        let done = self.done.fetch_add(1, Ordering::Relaxed) + 1;
        if self.shown {
            // Nobody waits for a progress that cannot be written.
            let _ = write!(std::io::stderr(), "\r{done} of {} pictures", self.of);
        }
    }

    fn end(&self) {
        if self.shown {
            let _ = write!(std::io::stderr(), "\r{:40}\r", "");
        }
    }
}
