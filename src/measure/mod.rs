//! `pneuval measure`: lengths, angles and areas from photographs; scales and lenses for them.

mod arguments;
mod drawn;
mod lens;
mod scale;
mod words;

use std::fmt::Write as _;
use std::io::{IsTerminal as _, Write as _};
use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering};

use rayon::prelude::*;
use serde::Serialize;

use pneuval_ingest::IngestError;
use pneuval_ingest::camera::task::{Reading, Task};
use pneuval_ingest::error::Place;
use pneuval_ingest::formats::pictures::names::Pattern;
use pneuval_ingest::formats::pictures::{open, pictures};
use pneuval_ingest::limits::LOG_BYTES_MAX;
use pneuval_ingest::raw::RawFile;

use crate::exit::{Failure, Outcome};
use crate::{output, table};

pub use arguments::Measure;
use arguments::{Job, Measured};

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
    match &arguments.what {
        Measured::Diameter(asked) => values(&asked.job, &words::diameter(asked)?),
        Measured::Angle(asked) => values(&asked.job, &words::angle(asked)?),
        Measured::Area(asked) => values(&asked.job, &words::area(asked)?),
        Measured::Scale(arguments) => scale::run(arguments),
        Measured::Lens(arguments) => lens::run(arguments),
    }
}

/// Measures pictures side by side, tells the values, draws what was measured.
fn values(job: &Job, task: &Task) -> Result<Outcome, Failure> {
    let pattern = job.names.as_deref().map(words::names).transpose()?;
    let raws: Vec<RawFile> = job.pictures.iter().map(|path| opened(path)).collect::<Result<_, _>>()?;
    let all: Vec<&RawFile> = raws.iter().flat_map(|raw| pictures(raw)).collect();
    let names = drawn::names(&all);
    if let Some(out) = &job.out {
        drawn::check_out(out, &job.pictures)?;
        std::fs::create_dir_all(out).map_err(|source| IngestError::write(out, source))?;
    }
    let progress = Progress::new(all.len());
    let one = |(raw, name): (&&RawFile, &String)| {
        let found = measured(raw, task, job.out.as_ref().map(|out| out.join(name)).as_deref());
        progress.step();
        found
    };
    let found: Vec<Result<Reading, String>> = all.par_iter().zip(&names).map(one).collect::<Result<_, Failure>>()?;
    progress.end();
    let told: Vec<Told> = all.iter().zip(&found).map(|(raw, found)| told(raw, found, task, pattern.as_ref())).collect();
    if job.json {
        output::print_json(&told)?;
    } else {
        output::print(&text(&told, task))?;
    }
    let readings: Vec<&Reading> = found.iter().flatten().collect();
    task.warnings(&readings).iter().for_each(|warning| output::tell(&format!("note: {warning}")));
    if readings.is_empty() {
        return Err(IngestError::Unusable {
            place: Place::new(&job.pictures[0].display().to_string(), None, None),
            expected: "a picture of a body, to be measured".to_owned(),
            found: told.first().and_then(|told| told.refused.clone()).unwrap_or_else(|| "none".to_owned()),
            next: "the reasons stand beside each picture".to_owned(),
        }
        .into());
    }
    let is_lossy = found.iter().any(Result::is_err) || told.iter().any(|t| t.names.iter().any(|n| n.value.is_none()));
    Ok(if is_lossy { Outcome::Open } else { Outcome::Expected })
}

fn opened(path: &Path) -> Result<RawFile<'static>, Failure> {
    Ok(RawFile::open(path, &path.display().to_string(), LOG_BYTES_MAX)?)
}

/// Measures a picture, and writes what was measured to files of such a name.
fn measured(raw: &RawFile, task: &Task, out: Option<&Path>) -> Result<Result<Reading, String>, Failure> {
    let picture = match open(raw)? {
        Ok(picture) => picture,
        Err(why) => return Ok(Err(why)),
    };
    let found = task.measure(&picture);
    if let (Ok(reading), Some(path)) = (&found, out) {
        drawn::write(&picture, reading, path)?;
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

impl Progress {
    fn new(of: usize) -> Self {
        Self { done: AtomicUsize::new(0), of, shown: std::io::stderr().is_terminal() }
    }

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
