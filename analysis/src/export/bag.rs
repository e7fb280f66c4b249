//! A run as a bag: a topic for each clock, messages with their stamps, units and meanings in the definitions and in a metadata record.
//!
//! Names are such that every reader takes them: a topic is letters, digits and `_`, for a `-` ends the name of a topic where Foxglove
//! asks for one; a field is lower-case letters, digits and `_`, as ROS has it. A message type for each session and clock: readers that
//! open several files ask that a type be one and the same.

use std::collections::{BTreeMap, BTreeSet};
use std::fs::File;
use std::io::BufWriter;
use std::path::Path;

use pneuval_ingest::IngestError;
use pneuval_ingest::finding::LineMap;
use pneuval_ingest::formats::csv::Decimal;
use pneuval_ingest::formats::mcap::{self, WriteOptions, definition, field_name};
use pneuval_ingest::formats::stamps::origin_second;
use pneuval_ingest::recording::{self, Cells};
use pneuval_ingest::store::unique_name;

use super::record::{ColumnRecord, LeftOut, TableRecord};
use super::samples::Samples;
use super::table::Table;
use super::{AnalysisError, SYNTHETIC};

/// The metadata record of this program.
const RECORD: &str = "pneuval";

/// The package of the message types.
const PACKAGE: &str = "pneuval_msgs/msg";

/// The column of the stamps.
const STAMP: &str = "header.stamp";

/// Fields that mean something else to a writer or reader of bags.
const RESERVED: [&str; 5] = [mcap::LOG_TIME, mcap::PUBLISH_TIME, "header", "stamp", "timestamp"];

/// Seconds of a stamp end here: `int32`, in 2038.
const SECOND_MAX: f64 = i32::MAX as f64;

/// A run on its way into a bag.
pub(super) struct Bag {
    /// What its stamps are, in words.
    pub time: String,
    /// What its stamps count from, in s since 1970.
    origin_s: u64,
    topics: Vec<Topic>,
    is_synthetic: bool,
}

struct Topic {
    name: String,
    schema: String,
    stream: String,
    table: Table,
    /// Rows that can be messages; `None` for all.
    kept: Option<Vec<usize>>,
}

impl Bag {
    /// `file` is its name, and `taken` the topics of the session's other bags.
    pub fn new(
        session: &str,
        file: &str,
        samples: Vec<Samples>,
        is_synthetic: bool,
        taken: &mut BTreeSet<String>,
    ) -> Self {
        let (origin_s, time) = origin(&samples);
        let stem = file.rsplit_once('.').map_or(file, |(stem, _)| stem);
        let run = token(stem, "run");
        let mut types = BTreeSet::new();
        let topics = samples.into_iter().map(|Samples { stream, table, .. }| {
            let inside = if stream.is_empty() { String::new() } else { format!("/{}", token(&stream, "stream")) };
            // A date in front of a type's name is none that ROS allows.
            let schema = format!("{}{}", camel(session), camel(&stream));
            let starts = schema.starts_with(|c: char| c.is_ascii_alphabetic());
            let schema = if starts { schema } else { format!("S{schema}") };
            Topic {
                name: unique_name(&format!("/{run}{inside}"), taken),
                schema: format!("{PACKAGE}/{}", unique_name(&schema, &mut types).replace('_', "N")),
                stream,
                kept: kept(&table, origin_s),
                table,
            }
        });
        Self { time, origin_s, topics: topics.collect(), is_synthetic }
    }

    /// Samples that are no messages, and why.
    pub fn left_out(&self, of: &str) -> Vec<LeftOut> {
        let left = |topic: &Topic| {
            let (kept, rows) = (topic.kept.as_ref()?.len(), topic.table.rows());
            let what = format!("{} of {rows} samples of {} of {of}", rows - kept, topic.name);
            let why = "their stamps do not count, or lie outside of what a message can hold (1970 to 2038)";
            Some(LeftOut::new(what, why.to_owned()))
        };
        self.topics.iter().filter_map(left).collect()
    }

    /// Writes it, with words about it.
    pub fn write(self, path: &Path, words: Vec<(String, String)>) -> Result<Vec<TableRecord>, AnalysisError> {
        let mut metadata: BTreeMap<String, String> = words.into_iter().collect();
        let (mut tables, mut definitions, mut records) = (Vec::new(), Vec::new(), Vec::new());
        for topic in self.topics {
            let mut taken: BTreeSet<String> = RESERVED.map(str::to_owned).into();
            let mut columns: Vec<ColumnRecord> = topic.table.columns.iter().map(ColumnRecord::of).collect();
            for column in &mut columns {
                column.name = unique_name(&field_name(&column.name), &mut taken);
                metadata.insert(format!("{}.{}", topic.name, column.name), column.to_json());
            }
            let meanings: Vec<String> = columns.iter().map(ColumnRecord::to_words).collect();
            let fields: Vec<_> =
                columns.iter().zip(&meanings).map(|(c, words)| (c.name.as_str(), words.as_str())).collect();
            let comments: &[&str] = if self.is_synthetic { &[SYNTHETIC] } else { &[] };
            definitions.push((topic.schema.clone(), definition(comments, &fields)));
            let names = columns.iter().map(|column| column.name.clone()).collect();
            let stream = Some(topic.stream.clone()).filter(|stream| !stream.is_empty());
            let rows = topic.kept.as_ref().map_or(topic.table.rows(), Vec::len);
            records.push(TableRecord { topic: Some(topic.name.clone()), stream, rows, columns });
            tables.push(topic.into_table(names, self.is_synthetic));
        }
        let metadata = vec![(RECORD.to_owned(), metadata)];
        let options = WriteOptions { origin_s: self.origin_s, definitions, metadata, ..WriteOptions::default() };
        let failed = |source| IngestError::write(path, source);
        let mut out = BufWriter::new(File::create(path).map_err(failed)?);
        mcap::write(&mut out, &tables, &options)?;
        let file = out.into_inner().map_err(|error| failed(error.into_error()))?;
        file.sync_all().map_err(failed)?;
        Ok(records)
    }
}

impl Topic {
    /// As a table whose columns are the fields of its messages.
    fn into_table(self, names: Vec<String>, is_synthetic: bool) -> recording::Table {
        let Self { name, schema, table, kept, .. } = self;
        let rows = kept.as_ref().map_or(table.rows(), Vec::len);
        let column = |name: String, unit: Option<&str>, cells| recording::Column {
            name,
            unit: unit.map(str::to_owned),
            cells,
            summary: recording::Column::new("", None, Cells::NotKept).summary,
            clock: None,
            is_dated: false,
            std: None,
        };
        let mut columns = Vec::with_capacity(names.len() + 2);
        for (name, own) in names.into_iter().zip(table.columns) {
            let cells = match (own.cells, &kept) {
                (Cells::Numbers(values), Some(kept)) => Cells::Numbers(kept.iter().map(|&row| values[row]).collect()),
                (cells, _) => cells,
            };
            if columns.is_empty() {
                columns.push(column(STAMP.to_owned(), Some("s"), cells.clone()));
            }
            columns.push(column(name, None, cells));
        }
        if is_synthetic {
            // The one word of a header: every message says what it is.
            columns.push(column("header.frame_id".to_owned(), None, Cells::Text(vec!["SYNTHETIC".to_owned(); rows])));
        }
        let (schema, lines, decimal) = (Some(schema), LineMap::default(), Decimal::Point);
        recording::Table { name, schema, columns, rows, lines, clock: Some(0), decimal }
    }
}

/// What the stamps of a run count from, in s since 1970, and in words.
fn origin(samples: &[Samples]) -> (u64, String) {
    let dated = samples.iter().find_map(|s| Some((s.origin.as_deref()?, origin_second(s.origin.as_deref()?)?)));
    if let Some((text, (second, is_utc))) = dated {
        let zone = if is_utc { "" } else { ", by a clock whose zone is not stated, taken as UTC" };
        return match u64::try_from(second) {
            Ok(second) => (second, format!("stamps count from {text}{zone}")),
            Err(_) => {
                (0, format!("the log dates its stamps from {text}, before 1970; they count from 1970-01-01T00:00:00Z"))
            }
        };
    }
    let times = samples.iter().filter_map(|s| s.table.columns.first()?.cells.numbers()).flatten();
    let earliest = times.copied().filter(|t| t.is_finite()).fold(0.0, f64::min);
    // A clock that begins far below zero is none.
    let shift = (-earliest).ceil().min(SECOND_MAX);
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
    let shift = shift as u64;
    let zero = match shift {
        0 => "time_s 0 is 1970-01-01T00:00:00Z".to_owned(),
        shift => format!("time_s 0 is {shift} s after 1970-01-01T00:00:00Z, so that no stamp is negative"),
    };
    (shift, format!("no date is known: {zero}"))
}

/// The rows whose stamps a message can hold; `None` for all of them.
fn kept(table: &Table, origin_s: u64) -> Option<Vec<usize>> {
    let times = table.columns.first()?.cells.numbers()?;
    let is_kept = |t: f64| (0.0..=SECOND_MAX).contains(&(t + origin_s as f64));
    let kept: Vec<usize> = (0..times.len()).filter(|&row| is_kept(times[row])).collect();
    (kept.len() < times.len()).then_some(kept)
}

/// Letters, digits and single underscores, a letter first.
fn token(text: &str, what: &str) -> String {
    let signs: String = text.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '_' }).collect();
    let words: Vec<&str> = signs.split('_').filter(|word| !word.is_empty()).collect();
    let word = words.join("_");
    match word.chars().next() {
        None => what.to_owned(),
        Some(first) if first.is_ascii_alphabetic() => word,
        Some(_) => format!("{what}_{word}"),
    }
}

/// Words set together, each with a capital.
fn camel(text: &str) -> String {
    let words = text.split(|c: char| !c.is_ascii_alphanumeric());
    words
        .map(|word| {
            let (first, rest) = word.split_at(word.len().min(1));
            first.to_ascii_uppercase() + rest
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_such_as_every_reader_takes() {
        for (text, expected) in
            [("run-1", "run_1"), ("/rig/p", "rig_p"), ("2026-05-04", "run_2026_05_04"), ("--", "run"), ("a__B", "a_B")]
        {
            assert_eq!(token(text, "run"), expected);
        }
        assert_eq!((camel("monday-2.run"), camel("/rig pose")), ("Monday2Run".to_owned(), "RigPose".to_owned()));
    }
}
