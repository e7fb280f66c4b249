//! Photographs as a log: a folder of pictures, or one, each a sample of what is measured in it.
//!
//! One row per picture, in the order of their names, with numbers first. Its columns are the numbers that the names hold (by a pattern), a
//! time where `fps` gives one, and what the task measures: each value with a column of its standard uncertainty. A picture that cannot be
//! decoded or measured is a row of holes, and a finding with the reason; the others go on. Pictures are measured in parallel, and the result does not depend
//! on it.
//!
//! | file | holds |
//! |---|---|
//! | `names.rs` | numbers in file names |

pub mod names;

use std::cmp::Ordering;
use std::io::Read;

use rayon::prelude::*;

use crate::IngestError;
use crate::camera::decode::{decode, is_picture};
use crate::camera::picture::Picture;
use crate::camera::task::{Reading, Task};
use crate::error::Place;
use crate::finding::{Finding, FindingKind, LineMap, Severity};
use crate::formats::csv::Decimal;
use crate::limits::PICTURE_BYTES_MAX;
use crate::raw::RawFile;
use crate::recording::{Cells, Column, Keep, Recording, Table};
use names::Pattern;

/// What is known of a folder of pictures.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct PictureOptions {
    /// What is measured; `None`: only what is there is told.
    pub task: Option<Task>,
    /// How they are named.
    pub names: Option<Pattern>,
    /// Pictures in a second, and the time of the first in s: gives each its time.
    pub film: Option<(f64, f64)>,
}

/// The name of the column of times that a rate gives.
pub const TIME: &str = "time";

/// What became of a picture.
struct Row {
    size: Option<(usize, usize)>,
    reading: Result<Option<Reading>, (FindingKind, String)>,
}

/// Whether a file, or the first one of a folder that is no bag, is a picture.
///
/// # Errors
/// [`IngestError::Read`].
pub fn looks_like(raw: &RawFile) -> Result<bool, IngestError> {
    let head = |part: &RawFile| part.head(16).map(|head| is_picture(&head));
    match raw.parts() {
        None => head(raw),
        Some(parts) => Ok(parts.iter().any(|part| has_name_of_picture(part.file_name()))),
    }
}

/// Whether a file is named as a picture.
pub fn has_name_of_picture(name: &str) -> bool {
    let extension = std::path::Path::new(name).extension().and_then(|e| e.to_str()).unwrap_or_default();
    ["png", "jpg", "jpeg", "tif", "tiff"].iter().any(|known| extension.eq_ignore_ascii_case(known))
}

/// The pictures of a file or folder, in order.
pub fn pictures<'r, 'a>(raw: &'r RawFile<'a>) -> Vec<&'r RawFile<'a>> {
    let mut all: Vec<&RawFile> = match raw.parts() {
        None => vec![raw],
        Some(parts) => parts.iter().filter(|part| has_name_of_picture(part.file_name())).collect(),
    };
    all.sort_by(|a, b| by_number(a.file_name(), b.file_name()));
    all
}

/// Names in the order of the numbers in them: `p2` before `p10`.
fn by_number(a: &str, b: &str) -> Ordering {
    let (mut x, mut y) = (a.as_bytes(), b.as_bytes());
    while let (Some(p), Some(q)) = (x.first(), y.first()) {
        if p.is_ascii_digit() && q.is_ascii_digit() {
            let digits = |of: &[u8]| of.iter().take_while(|c| c.is_ascii_digit()).count();
            let (m, n) = (digits(x), digits(y));
            let without_zeros = |of: &[u8]| of.iter().take_while(|c| **c == b'0').count();
            let (u, v) = (&x[without_zeros(&x[..m])..m], &y[without_zeros(&y[..n])..n]);
            let order = u.len().cmp(&v.len()).then_with(|| u.cmp(v));
            if order != Ordering::Equal {
                return order;
            }
            (x, y) = (&x[m..], &y[n..]);
        } else if p == q {
            (x, y) = (&x[1..], &y[1..]);
        } else {
            return p.cmp(q);
        }
    }
    x.len().cmp(&y.len()).then_with(|| a.cmp(b))
}

/// The picture of a file.
///
/// # Errors
/// [`IngestError::Read`]; why it is none, in words.
pub fn open(raw: &RawFile) -> Result<Result<Picture, String>, IngestError> {
    if raw.len() > PICTURE_BYTES_MAX {
        return Ok(Err(format!("{} bytes are more than the {PICTURE_BYTES_MAX} that are read", raw.len())));
    }
    let mut bytes = Vec::new();
    raw.reader()?.read_to_end(&mut bytes).map_err(|source| raw.failed(source))?;
    Ok(decode(&bytes).map_err(|broken| broken.to_string()))
}

/// Reads pictures as a recording of one table.
///
/// # Errors
/// [`IngestError::Unusable`] if there is none; [`IngestError::Read`].
pub fn read(raw: &RawFile, options: &PictureOptions, keep: Keep) -> Result<Recording, IngestError> {
    let pictures = pictures(raw);
    if pictures.is_empty() {
        return Err(IngestError::Unusable {
            place: Place::new(raw.name(), None, None),
            expected: "pictures: .png, .jpg, .tif".to_owned(),
            found: "none in the folder".to_owned(),
            next: "name the folder that holds them".to_owned(),
        });
    }
    let rows: Vec<Row> =
        pictures.par_iter().map(|raw| row(raw, options.task.as_ref())).collect::<Result<_, IngestError>>()?;
    let mut findings = Vec::new();
    for kind in [FindingKind::BrokenPicture, FindingKind::NotMeasured] {
        let such: Vec<(usize, String)> = rows
            .iter()
            .zip(&pictures)
            .enumerate()
            .filter_map(|(i, (row, raw))| match &row.reading {
                Err((of, why)) if *of == kind => Some((i, format!("{}: {why}", raw.file_name()))),
                _ => None,
            })
            .collect();
        findings.extend(told_of(raw.name(), kind, Severity::Excluded, &such));
    }
    let mut table = Sheet { rows: rows.len(), keep, columns: vec![] };
    if let Some(pattern) = &options.names {
        let read: Vec<Option<Vec<f64>>> = pictures.iter().map(|raw| pattern.read(raw.file_name())).collect();
        let such: Vec<(usize, String)> = (0..read.len())
            .filter(|&i| read[i].is_none())
            .map(|i| (i, format!("{} is not named as {}", pictures[i].file_name(), pattern.text())))
            .collect();
        findings.extend(told_of(raw.name(), FindingKind::UnreadName, Severity::Excluded, &such));
        for (k, field) in pattern.fields().enumerate() {
            let of = |i: usize| read[i].as_ref().and_then(|all| all.get(k)).copied().unwrap_or(f64::NAN);
            table.add(&field.name, field.unit.as_deref(), None, of);
        }
    }
    let clock = options.film.map(|(fps, start_s)| {
        table.add(TIME, Some("s"), None, |i| start_s + i as f64 / fps);
        table.columns.len() - 1
    });
    table.add("width", None, None, |i| rows[i].size.map_or(f64::NAN, |(w, _)| w as f64));
    table.add("height", None, None, |i| rows[i].size.map_or(f64::NAN, |(_, h)| h as f64));
    if let Some(task) = &options.task {
        for (k, (name, unit)) in task.columns().into_iter().enumerate() {
            let of = |i: usize| rows[i].reading.as_ref().ok().and_then(|r| r.as_ref()).map(|r| r.values[k]);
            // One number for the channel: the largest, of which nobody can say that it is too small.
            let largest =
                (0..rows.len()).filter_map(of).map(|v| v.std).filter(|s| s.is_finite()).fold(f64::NAN, f64::max);
            table.add(&name, Some(unit), Some(largest).filter(|s| s.is_finite()), |i| {
                of(i).map_or(f64::NAN, |v| v.value)
            });
            table.add(&format!("{name}_std"), Some(unit), None, |i| of(i).map_or(f64::NAN, |v| v.std));
        }
        let such: Vec<(usize, String)> = rows
            .iter()
            .zip(&pictures)
            .enumerate()
            .filter_map(|(i, (row, raw))| {
                let notes = row.reading.as_ref().ok()?.as_ref()?.notes.join("; ");
                (!notes.is_empty()).then(|| (i, format!("{}: {notes}", raw.file_name())))
            })
            .collect();
        findings.extend(told_of(raw.name(), FindingKind::PictureQuality, Severity::Note, &such));
        let readings: Vec<&Reading> = rows.iter().filter_map(|row| row.reading.as_ref().ok()?.as_ref()).collect();
        let warnings = task.warnings(&readings);
        findings.extend(warnings.into_iter().map(|text| Finding {
            kind: FindingKind::PictureScale,
            severity: Severity::Note,
            file: raw.name().to_owned(),
            channel: None,
            spans: vec![],
            count: rows.len(),
            text,
        }));
    }
    let rows = rows.len();
    let reasons = vec![format!("{rows} pictures, in the order of the numbers in their names")];
    Ok(Recording {
        format: "pictures",
        tables: vec![Table {
            name: String::new(),
            schema: None,
            columns: table.columns,
            rows,
            lines: LineMap::default(),
            clock,
            decimal: Decimal::Point,
        }],
        findings,
        reasons,
        metadata: vec![],
        origin: None,
    })
}

fn row(raw: &RawFile, task: Option<&Task>) -> Result<Row, IngestError> {
    Ok(match open(raw)? {
        Err(why) => Row { size: None, reading: Err((FindingKind::BrokenPicture, why)) },
        Ok(picture) => Row {
            size: Some((picture.width(), picture.height())),
            reading: task.map(|task| task.measure(&picture)).transpose().map_err(|why| (FindingKind::NotMeasured, why)),
        },
    })
}

/// A finding about some of the pictures.
fn told_of(file: &str, kind: FindingKind, severity: Severity, such: &[(usize, String)]) -> Option<Finding> {
    let texts: Vec<String> = such.iter().map(|(_, text)| text.clone()).collect();
    (!such.is_empty()).then(|| Finding {
        kind,
        severity,
        file: file.to_owned(),
        channel: None,
        spans: vec![],
        count: such.len(),
        text: listed(&texts),
    })
}

/// The first few of many.
fn listed(texts: &[String]) -> String {
    const SHOWN: usize = 4;
    let more = if texts.len() > SHOWN { format!(" and {} more", texts.len() - SHOWN) } else { String::new() };
    format!("{}{more}", texts[..texts.len().min(SHOWN)].join("; "))
}

/// Columns that are being made.
struct Sheet<'k> {
    rows: usize,
    keep: Keep<'k>,
    columns: Vec<Column>,
}

impl Sheet<'_> {
    fn add(&mut self, name: &str, unit: Option<&str>, std: Option<f64>, of: impl Fn(usize) -> f64) {
        let mut column = Column::new(name, unit, Cells::Numbers((0..self.rows).map(of).collect()));
        column.std = std;
        // A table that is kept keeps its clock.
        let is_clock = name == TIME && self.keep.wants("");
        if !is_clock && !self.keep.keeps("", name, self.columns.len() + 1) {
            column.cells = Cells::NotKept;
        }
        self.columns.push(column);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_go_by_their_numbers() {
        let mut names = ["p10.png", "p2.png", "p02b.png", "p2.5.png", "a1.png", "p1_10.png", "p1_9.png"];
        names.sort_by(|a, b| by_number(a, b));
        assert_eq!(names, ["a1.png", "p1_9.png", "p1_10.png", "p2.5.png", "p2.png", "p02b.png", "p10.png"]);
    }
}
