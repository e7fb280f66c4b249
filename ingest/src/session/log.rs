//! The recording of a file on its way into runs: which rows, which column, and its numbers, copied only where they are needed twice.

use std::collections::HashMap;

use super::reader::Reader;
use crate::camera::photograph::Photograph;
use crate::error::{IngestError, shown, suggestion};
use crate::finding::{self, Finding, FindingKind, LineMap, Severity, Span};
use crate::formats::csv::parse_number;
use crate::manifest::{ClockSpec, RunSpec, SessionManifest};
use crate::recording::{Cells, Column, ColumnRef, Keep, Recording, Table, full_name};

/// A column of a recording: index of its table, index in it.
pub(super) type ColumnId = (usize, usize);

/// The recording of one file.
pub(super) struct Log<'a> {
    /// As the manifest names it.
    pub file: &'a str,
    pub recording: Recording,
    /// How often the numbers of a column are still asked for; empty where several runs share the file.
    asked: HashMap<ColumnId, usize>,
}

/// Samples of a run in one table.
#[derive(Debug, Clone)]
pub(super) struct Part {
    pub table: usize,
    rows: Rows,
    pub lines: LineMap,
}

#[derive(Debug, Clone)]
enum Rows {
    All(usize),
    Some(Vec<usize>),
}

impl Part {
    /// Number of samples.
    pub fn samples(&self) -> usize {
        match &self.rows {
            Rows::All(count) => *count,
            Rows::Some(rows) => rows.len(),
        }
    }

    /// The rows of the table, in order.
    pub fn rows(&self) -> Box<dyn Iterator<Item = usize> + '_> {
        match &self.rows {
            Rows::All(count) => Box::new(0..*count),
            Rows::Some(rows) => Box::new(rows.iter().copied()),
        }
    }

    /// Where a sample stands, for sentences.
    pub fn place(&self, sample: usize) -> String {
        self.lines.place(sample)
    }

    /// Stretches of samples, for a finding.
    pub fn spans(&self, samples: impl IntoIterator<Item = usize>) -> Vec<Span> {
        let mut spans = Vec::new();
        for sample in samples {
            finding::extend(&mut spans, self.lines.span(sample, sample));
        }
        spans
    }
}

/// Names that a person reads through.
const NAMES_MAX: usize = 40;

/// The columns that the runs of a session ask for.
pub(super) fn columns_asked(manifest: &SessionManifest) -> Vec<ColumnRef> {
    let mut columns: Vec<ColumnRef> = manifest.channels.iter().map(|channel| channel.column.clone()).collect();
    columns.extend(manifest.clock_column().cloned());
    if let Some(ClockSpec::Stamp(stamp, _)) = &manifest.clock {
        let names = manifest.channels.iter().filter_map(|channel| match &channel.column {
            ColumnRef::Name(name) => Some(name),
            ColumnRef::Number(_) => None,
        });
        // Where the topic ends and the field begins only the file knows: a name too many asks for nothing.
        let topics = names.flat_map(|name| name.match_indices('.').map(move |(at, _)| &name[..at]));
        columns.extend(
            topics.flat_map(|topic| stamp.names().iter().map(move |stamp| ColumnRef::Name(full_name(topic, stamp)))),
        );
    }
    columns.extend(manifest.runs.iter().filter_map(|run| Some(run.rows.as_ref()?.0.clone())));
    columns
}

impl<'a> Log<'a> {
    /// A file's recording.
    pub fn new(file: &'a str, recording: Recording) -> Self {
        Self { file, recording, asked: HashMap::new() }
    }

    /// Says how often the numbers of each column will be asked for in all: the last time they are moved, not copied.
    pub fn expect(&mut self, columns: impl IntoIterator<Item = ColumnId>) {
        for id in columns {
            *self.asked.entry(id).or_insert(0) += 1;
        }
    }

    fn find(&self, column: &ColumnRef) -> Option<ColumnId> {
        let keep = Keep::Only(std::slice::from_ref(column));
        self.recording.tables.iter().enumerate().find_map(|(t, table)| {
            let i = (0..table.columns.len()).find(|&i| keep.keeps(&table.name, &table.columns[i].name, i + 1))?;
            Some((t, i))
        })
    }

    /// A column by name or number; `line` is where the manifest asks for it.
    pub fn column(&self, column: &ColumnRef, reader: &Reader, line: usize) -> Result<ColumnId, IngestError> {
        let tables = &self.recording.tables;
        // Of several tables a name is that of one column, as `inspect` shows it.
        if let (ColumnRef::Name(name), [table]) = (column, tables.as_slice())
            && table.column(&format!("{name} (2)")).is_some()
        {
            let expected = "a column whose name stands once in the log";
            let next = "name it by its number, or as `… (2)`".to_owned();
            return Err(reader.malformed(line, expected, &format!("{} twice", shown(name)), next));
        }
        self.find(column).ok_or_else(|| match column {
            ColumnRef::Number(number) => {
                let columns = tables.first().map_or(0, |table| table.columns.len());
                let (found, next) = if tables.len() > 1 {
                    (format!("column {number} of {}, which has several tables", self.file), "name it as `inspect` does")
                } else {
                    (format!("column {number} of {columns}"), "count from 1")
                };
                reader.malformed(line, "a column of the log", &found, next.to_owned())
            }
            ColumnRef::Name(name) => {
                let known: Vec<String> = tables.iter().flat_map(full_names).collect();
                let known: Vec<&str> = known.iter().map(String::as_str).collect();
                let next = self.next(name, &known);
                // The names stand in one place, if they can be read through at all.
                let expected = if known.len() > NAMES_MAX || next.starts_with("use one of") {
                    "a column of the log".to_owned()
                } else {
                    format!("a column of the log: {}", known.join(", "))
                };
                reader.malformed(line, &expected, &shown(name), next)
            }
        })
    }

    /// What to write instead of a column that is not there.
    fn next(&self, name: &str, known: &[&str]) -> String {
        // A topic may be there while its messages are not understood: the reason is among the findings.
        let is_of = |finding: &&Finding| {
            let topic = finding.channel.as_deref().filter(|topic| !topic.is_empty());
            finding.kind == FindingKind::UnreadTopic
                && topic.and_then(|topic| name.strip_prefix(topic)).is_some_and(|rest| rest.starts_with('.'))
        };
        if let Some(finding) = self.recording.findings.iter().find(is_of) {
            return finding.text.clone();
        }
        let next = suggestion(name, known.iter().copied());
        if known.len() > NAMES_MAX && next.starts_with("use one of") {
            let first = known.get(..NAMES_MAX).unwrap_or(known).join(", ");
            return format!("use one of: {first}, … ({} in all; `pneuval inspect` lists them)", known.len());
        }
        next
    }

    /// The table of an id.
    pub fn table(&self, table: usize) -> &Table {
        &self.recording.tables[table]
    }

    /// The column of an id.
    pub fn at(&self, (table, column): ColumnId) -> &Column {
        &self.recording.tables[table].columns[column]
    }

    /// Its pictures that are shown, as far as a run has them.
    pub fn photographs(&self, parts: &[Part]) -> Vec<Photograph> {
        let is_of = |shown: &&Photograph| {
            let has =
                |part: &Part| self.table(part.table).name == shown.table && part.rows().any(|row| row == shown.sample);
            parts.iter().any(has)
        };
        self.recording.photographs.iter().filter(is_of).cloned().collect()
    }

    /// The samples of a run in a table.
    pub fn part(&self, spec: &RunSpec, table: usize, reader: &Reader) -> Result<Part, IngestError> {
        let Table { rows, lines, decimal, .. } = &self.recording.tables[table];
        let Some((column, wanted)) = &spec.rows else {
            return Ok(Part { table, rows: Rows::All(*rows), lines: lines.clone() });
        };
        let id = self.column(column, reader, spec.line)?;
        if id.0 != table {
            let found = format!("{}, whose channels come from several tables", shown(self.file));
            let next = "remove `rows`, or take channels of that table only".to_owned();
            return Err(reader.malformed(spec.line, "`rows` for a file of one table", &found, next));
        }
        let column = self.at(id);
        let chosen: Vec<usize> = match &column.cells {
            Cells::Text(cells) => (0..*rows).filter(|&row| cells[row] == *wanted).collect(),
            Cells::Numbers(values) => {
                let wanted = parse_number(wanted.trim().as_bytes(), *decimal).unwrap_or(f64::NAN);
                let equal = |value: f64| value.total_cmp(&wanted).is_eq() && !value.is_nan();
                (0..*rows).filter(|&row| equal(values[row])).collect()
            }
            Cells::NotKept => vec![],
        };
        if chosen.is_empty() {
            let mut seen: Vec<&str> = column.cells.text().unwrap_or_default().iter().map(String::as_str).collect();
            seen.sort_unstable();
            seen.dedup();
            let expected = format!("a text of column `{}` of {}", column.name, self.file);
            return Err(reader.malformed(spec.line, &expected, &shown(wanted), suggestion(wanted, seen)));
        }
        let mut chosen_lines = LineMap::default();
        if lines.rows() > 0 {
            for &row in &chosen {
                chosen_lines.push(lines.line_of(row));
            }
        }
        Ok(Part { table, rows: Rows::Some(chosen), lines: chosen_lines })
    }

    /// The numbers of a column at the samples of a part: moved out of the recording where nothing else asks for them. A column that is
    /// mostly text is read all the same, if it was asked for: what is no number in it is a hole, and a finding.
    pub fn numbers(&mut self, id: ColumnId, part: &Part, run: &str, findings: &mut Vec<Finding>) -> Vec<f64> {
        let is_last = self.asked.get_mut(&id).is_some_and(|left| {
            *left -= 1;
            *left == 0
        });
        let table = &mut self.recording.tables[id.0];
        let column = &mut table.columns[id.1];
        match (&mut column.cells, &part.rows) {
            (Cells::Numbers(values), Rows::All(_)) if is_last => return std::mem::take(values),
            (Cells::Numbers(values), Rows::All(_)) => return values.clone(),
            (Cells::Numbers(values), Rows::Some(rows)) => return rows.iter().map(|&row| values[row]).collect(),
            (Cells::NotKept, _) => return vec![f64::NAN; part.samples()],
            (Cells::Text(_), _) => {}
        }
        let cells = column.cells.text().unwrap_or_default();
        let parse = |row: usize| {
            let number = parse_number(cells[row].trim().as_bytes(), table.decimal);
            number.filter(|v| v.is_finite()).unwrap_or(f64::NAN)
        };
        let rows: Vec<usize> = part.rows().collect();
        let values: Vec<f64> = rows.iter().map(|&row| parse(row)).collect();
        let holes: Vec<usize> = (0..values.len()).filter(|&i| values[i].is_nan()).collect();
        if !holes.is_empty() {
            let named = |&i: &usize| format!("{}: {}", part.place(i), shown(&cells[rows[i]]));
            let first: Vec<String> = holes.iter().take(5).map(named).collect();
            findings.push(Finding {
                kind: FindingKind::NonNumericCell,
                severity: Severity::Excluded,
                file: self.file.to_owned(),
                channel: Some(column.name.clone()),
                spans: part.spans(holes.iter().copied()),
                count: holes.len(),
                text: format!(
                    "column {} of run {run}: {} of {} cells are not numbers ({}); left as holes",
                    shown(&column.name),
                    holes.len(),
                    values.len(),
                    first.join(", ")
                ),
            });
        }
        values
    }
}

/// What manifests call the columns of a table.
fn full_names(table: &Table) -> impl Iterator<Item = String> + '_ {
    table.columns.iter().map(|column| table.full_name(&column.name))
}
