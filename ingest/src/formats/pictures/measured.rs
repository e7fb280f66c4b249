//! What became of pictures, as columns and findings of their log.

use std::collections::BTreeMap;

use crate::camera::photograph::Photograph;
use crate::camera::picture::Picture;
use crate::camera::task::{Marks, Reading, Task};
use crate::finding::{Finding, FindingKind, LineMap, Severity};
use crate::formats::csv::Decimal;
use crate::recording::{Cells, Column, Keep, Table};

/// What became of a picture.
pub(super) struct Row {
    name: String,
    size: Option<(usize, usize)>,
    reading: Result<Option<Reading>, (FindingKind, String)>,
    /// As it is shown, where it is.
    pub photograph: Option<Photograph>,
}

impl Row {
    /// Of a picture, or of why it is none; `shown`: its number in the log, if it is to be shown.
    pub fn new(name: &str, opened: Result<Picture, String>, task: Option<&Task>, shown: Option<usize>) -> Self {
        let picture = match opened {
            Ok(picture) => picture,
            Err(why) => {
                let reading = Err((FindingKind::BrokenPicture, why));
                return Self { name: name.to_owned(), size: None, reading, photograph: None };
            }
        };
        let mut found = task.map(|task| task.measure(&picture)).transpose();
        let photograph = shown.and_then(|sample| {
            let reading = found.as_ref().map_err(String::as_str);
            reading.map(Option::as_ref).transpose().map(|reading| Photograph::new(name, sample, &picture, reading))
        });
        // Thousands of edges of thousands of pictures are not kept for nothing.
        if let Ok(Some(reading)) = &mut found {
            reading.marks = Marks::default();
            reading.profile = None;
        }
        let reading = found.map_err(|why| (FindingKind::NotMeasured, why));
        Self { name: name.to_owned(), size: Some((picture.width(), picture.height())), reading, photograph }
    }

    fn reading(&self) -> Option<&Reading> {
        self.reading.as_ref().ok()?.as_ref()
    }
}

/// Pictures that could not be decoded, or not measured.
pub(super) fn broken(file: &str, rows: &[Row]) -> Vec<Finding> {
    let of = |kind: FindingKind| {
        let why = |row: &Row| match &row.reading {
            Err((of, why)) if *of == kind => Some(format!("{}: {why}", row.name)),
            _ => None,
        };
        told_of(file, kind, Severity::Excluded, &rows.iter().filter_map(why).collect::<Vec<_>>())
    };
    [FindingKind::BrokenPicture, FindingKind::NotMeasured].into_iter().filter_map(of).collect()
}

/// Adds the columns of what was measured, and says what there is to know of it.
pub(super) fn add(sheet: &mut Sheet, file: &str, rows: &[Row], task: Option<&Task>) -> Vec<Finding> {
    sheet.add("width", None, None, |i| rows[i].size.map_or(f64::NAN, |(w, _)| w as f64));
    sheet.add("height", None, None, |i| rows[i].size.map_or(f64::NAN, |(_, h)| h as f64));
    let Some(task) = task else { return vec![] };
    for (k, (name, unit)) in task.columns().into_iter().enumerate() {
        let of = |i: usize| rows[i].reading().map(|r| r.values[k]);
        // One number for the channel: the largest, of which nobody can say that it is too small.
        let largest = (0..rows.len()).filter_map(of).map(|v| v.std).filter(|s| s.is_finite()).fold(f64::NAN, f64::max);
        let std = Some(largest).filter(|s| s.is_finite());
        sheet.add(&name, Some(unit), std, |i| of(i).map_or(f64::NAN, |v| v.value));
        sheet.add(&format!("{name}_std"), Some(unit), None, |i| of(i).map_or(f64::NAN, |v| v.std));
    }
    let mut findings: Vec<Finding> = noted(file, rows).into_iter().collect();
    let readings: Vec<&Reading> = rows.iter().filter_map(Row::reading).collect();
    findings.extend(task.warnings(&readings).into_iter().map(|text| Finding {
        kind: FindingKind::PictureScale,
        severity: Severity::Note,
        file: file.to_owned(),
        channel: None,
        spans: vec![],
        count: rows.len(),
        text,
    }));
    findings
}

/// What is worth knowing of pictures, once for all of which the same is.
fn noted(file: &str, rows: &[Row]) -> Option<Finding> {
    // Notes, with the first picture that has them and how many have.
    let mut alike: BTreeMap<String, (usize, usize)> = BTreeMap::new();
    for (i, row) in rows.iter().enumerate() {
        let notes = row.reading().map_or(String::new(), |reading| reading.notes.join("; "));
        if !notes.is_empty() {
            alike.entry(notes).or_insert((i, 0)).1 += 1;
        }
    }
    let count = alike.values().map(|(_, count)| count).sum();
    let mut alike: Vec<(String, (usize, usize))> = alike.into_iter().collect();
    alike.sort_by_key(|(_, (first, _))| *first);
    let told = |(notes, (first, count)): &(String, (usize, usize))| match count {
        1 => format!("{}: {notes}", rows[*first].name),
        _ => format!("{count} of {} pictures, {} the first: {notes}", rows.len(), rows[*first].name),
    };
    let told: Vec<String> = alike.iter().map(told).collect();
    told_of(file, FindingKind::PictureQuality, Severity::Note, &told).map(|finding| Finding { count, ..finding })
}

/// A finding about some of the pictures.
pub(super) fn told_of(file: &str, kind: FindingKind, severity: Severity, such: &[String]) -> Option<Finding> {
    (!such.is_empty()).then(|| Finding {
        kind,
        severity,
        file: file.to_owned(),
        channel: None,
        spans: vec![],
        count: such.len(),
        text: listed(such),
    })
}

/// The first few of many.
fn listed(texts: &[String]) -> String {
    const SHOWN: usize = 4;
    let more = if texts.len() > SHOWN { format!(" and {} more", texts.len() - SHOWN) } else { String::new() };
    format!("{}{more}", texts[..texts.len().min(SHOWN)].join("; "))
}

/// A table that is being made.
pub(super) struct Sheet<'k> {
    name: String,
    rows: usize,
    keep: Keep<'k>,
    columns: Vec<Column>,
}

impl<'k> Sheet<'k> {
    pub fn new(name: &str, rows: usize, keep: Keep<'k>) -> Self {
        Self { name: name.to_owned(), rows, keep, columns: vec![] }
    }

    /// Adds a column.
    pub fn add(&mut self, name: &str, unit: Option<&str>, std: Option<f64>, of: impl Fn(usize) -> f64) {
        let mut column = Column::new(name, unit, Cells::Numbers((0..self.rows).map(of).collect()));
        column.std = std;
        if !self.keep.keeps(&self.name, name, self.columns.len() + 1) {
            column.cells = Cells::NotKept;
        }
        self.columns.push(column);
    }

    /// Adds a column of times, in s, and says which it is: a table that is kept keeps its clock.
    pub fn add_stamps(&mut self, name: &str, of: impl Fn(usize) -> f64) -> usize {
        let mut column = Column::new(name, Some("s"), Cells::Numbers((0..self.rows).map(of).collect()));
        if !self.keep.wants(&self.name) {
            column.cells = Cells::NotKept;
        }
        self.columns.push(column);
        self.columns.len() - 1
    }

    pub fn finish(self, schema: Option<String>, clock: Option<usize>) -> Table {
        Table {
            name: self.name,
            schema,
            columns: self.columns,
            rows: self.rows,
            lines: LineMap::default(),
            clock,
            decimal: Decimal::Point,
        }
    }
}
