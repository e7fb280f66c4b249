//! Transposed logs: one line per quantity, its name first, then its samples from left to right.
//!
//! Such lines are as long as the log, so they are read cell by cell and never held whole.

mod write;

use super::csv::{self, CellKind, Decimal, cell_kind};
use super::lines::{Decoder, cells, head_lines};
use crate::IngestError;
use crate::error::{Place, shown};
use crate::finding::places::{ByKind, Places, as_text, cell_finding, told};
use crate::finding::{Finding, FindingKind, LineMap, Severity};
use crate::limits::{LOG_CELLS_MAX, LOG_COLUMNS_MAX};
use crate::raw::RawFile;
use crate::recording::{Builder, Cells, Column, Keep, Recording, Table};
use crate::units::Unit;

pub use write::write;

/// A cell: longer ones are no samples.
const CELL_BYTES_MAX: usize = 1 << 16;

/// Samples on the first line from which on it can be no line of another kind of log.
const SAMPLES_SURE: usize = 64;

/// Delimiters and decimal signs, in the order in which they are tried.
const CANDIDATES: [(u8, Decimal); 7] = [
    (b'\t', Decimal::Point),
    (b';', Decimal::Point),
    (b',', Decimal::Point),
    (b'|', Decimal::Point),
    (b'\t', Decimal::Comma),
    (b';', Decimal::Comma),
    (b'|', Decimal::Comma),
];

/// Whether a text is a transposed log, by its first bytes: every line is a name and then numbers, the same number of them, and one of
/// them is a time that never goes back.
pub fn looks_like(head: &[u8], is_whole: bool) -> bool {
    layout(head, is_whole).is_some()
}

/// The delimiter and decimal sign of a transposed log.
fn layout(head: &[u8], is_whole: bool) -> Option<(u8, Decimal)> {
    let mut lines = head_lines(head, true);
    let is_cut = !is_whole && !head.ends_with(b"\n") && !head.ends_with(b"\r");
    let cut = if is_cut { lines.pop() } else { None };
    CANDIDATES.into_iter().find(|(delimiter, decimal)| {
        let mut parts = Vec::new();
        let mut rows: Vec<(String, usize)> = Vec::new();
        let mut has_clock = false;
        for line in &lines {
            cells(line, *delimiter, &mut parts);
            let Some((name, samples, is_forward)) = row(&parts, *decimal) else {
                // A line of two words, such as an operator, is metadata.
                if parts.len() > 2 {
                    return false;
                }
                continue;
            };
            has_clock |= is_forward && is_time_name(&name);
            if rows.iter().any(|(known, _)| *known == name) {
                return false;
            }
            rows.push((name, samples));
        }
        // The first line alone may be longer than what is looked at.
        if let (Some(cut), true) = (cut, rows.is_empty()) {
            cells(cut, *delimiter, &mut parts);
            parts.pop();
            return row(&parts, *decimal).is_some_and(|(_, samples, _)| samples >= SAMPLES_SURE);
        }
        let samples = rows.iter().map(|(_, samples)| *samples).max().unwrap_or(0);
        let is_sure = samples >= SAMPLES_SURE && samples > 4 * rows.len();
        let is_even = rows.iter().filter(|(_, n)| *n == samples).count() * 2 >= rows.len();
        (is_sure || (has_clock && rows.len() > 1 && samples > 2)) && is_even
    })
}

/// Name, number of samples and whether they never go back, of a line that is a name, perhaps a unit, and then mostly numbers.
fn row(parts: &[&[u8]], decimal: Decimal) -> Option<(String, usize, bool)> {
    let (name, rest) = parts.split_first()?;
    let name = as_text(name);
    if !name.chars().next().is_some_and(|c| c.is_alphabetic() || c == '_') {
        return None;
    }
    let rest = if is_unit(rest.first()?) { rest.get(1..)? } else { rest };
    let numbers: Vec<f64> = rest
        .iter()
        .filter_map(|cell| match cell_kind(cell, decimal) {
            CellKind::Number(number) => Some(number),
            _ => None,
        })
        .collect();
    let is_row = rest.len() > 1 && numbers.len() * 2 > rest.len();
    is_row.then(|| (name, rest.len(), numbers.is_sorted()))
}

fn is_unit(cell: &[u8]) -> bool {
    let cell = as_text(cell);
    cell != "1" && Unit::parse_loose(&cell).is_some()
}

fn is_time_name(name: &str) -> bool {
    let name = name.to_lowercase();
    let word: String = name.chars().take_while(|c| c.is_alphabetic()).collect();
    matches!(
        word.as_str(),
        "t" | "time"
            | "times"
            | "timestamp"
            | "stamp"
            | "zeit"
            | "temps"
            | "tempo"
            | "tiempo"
            | "elapsed"
            | "seconds"
            | "sec"
            | "ms"
            | "millis"
    )
}

/// One quantity while its line is read.
struct Quantity {
    name: String,
    unit: Option<String>,
    line: usize,
    numbers: Builder,
    /// Kept only while the line has held no number.
    words: Option<Vec<String>>,
    odd: ByKind,
    keep: bool,
    count: usize,
}

/// Reads a transposed log as a recording of one table.
///
/// # Errors
/// [`IngestError::Unusable`] if there is no line of numbers, and for sizes beyond [`crate::limits`]; [`IngestError::Read`].
pub fn read(raw: &RawFile, keep: Keep) -> Result<Recording, IngestError> {
    let file = raw.name();
    let head = super::text_head(raw)?;
    let Some((delimiter, decimal)) = layout(&head.bytes, head.is_whole) else {
        return Err(unusable(file, None, "lines of a name and numbers", "none".to_owned()));
    };
    let mut reading = Reading { file, keep, decimal, quantities: Vec::new(), metadata: Vec::new(), line: 1, cells: 0 };
    let mut current: Option<Quantity> = None;
    let mut first: Option<Vec<u8>> = None;
    let (mut cell, mut last) = (Vec::new(), b'\n');
    let mut zeros = 0_usize;
    let mut decoder = Decoder::of(raw.reader()?);
    let mut block = Vec::new();
    loop {
        block.clear();
        if !decoder.more(&mut block).map_err(|source| raw.failed(source))? {
            break;
        }
        for byte in &block {
            // What a power cut leaves at the end is no cell.
            if *byte == 0 {
                zeros += 1;
                continue;
            }
            let held = if zeros == 0 { 0 } else { cell.len().saturating_add(std::mem::take(&mut zeros)) };
            if held > CELL_BYTES_MAX {
                return Err(unusable(file, Some(reading.line), "cells of samples", "a longer one".to_owned()));
            }
            cell.resize(held.max(cell.len()), 0);
            let is_end = matches!(byte, b'\n' | b'\r');
            if *byte == delimiter || is_end {
                if !(is_end && first.is_none() && cell.is_empty()) {
                    reading.cell(&mut first, &mut current, &cell, is_end)?;
                }
                cell.clear();
                if is_end {
                    reading.end_line(&mut first, &mut current, true);
                    // CR LF and CR CR LF are one line end.
                    let is_new = *byte == b'\r' || last != b'\r';
                    reading.line += usize::from(is_new && !(*byte == b'\r' && last == b'\r'));
                }
            } else {
                if cell.len() >= CELL_BYTES_MAX {
                    return Err(unusable(file, Some(reading.line), "cells of samples", "a longer one".to_owned()));
                }
                cell.push(*byte);
            }
            last = *byte;
        }
    }
    let is_cut = first.is_some() || !cell.is_empty();
    if is_cut {
        reading.cell(&mut first, &mut current, &cell, true)?;
        reading.end_line(&mut first, &mut current, false);
    }
    let mut recording = reading.finish(delimiter)?;
    if zeros > 0 {
        let text = format!(
            "the file ends in {zeros} zero bytes, as after a power cut while it was written; what they stand for is lost"
        );
        let rows = recording.tables.first().map_or(0, |table| table.rows);
        recording.findings.push(told(FindingKind::Truncated, Severity::Lost, file, rows, 0, text));
    }
    Ok(recording)
}

struct Reading<'a> {
    file: &'a str,
    keep: Keep<'a>,
    decimal: Decimal,
    quantities: Vec<Quantity>,
    metadata: Vec<String>,
    line: usize,
    cells: usize,
}

impl Reading<'_> {
    /// A cell of the line that is being read.
    fn cell(
        &mut self,
        first: &mut Option<Vec<u8>>,
        current: &mut Option<Quantity>,
        cell: &[u8],
        is_last: bool,
    ) -> Result<(), IngestError> {
        let cell = super::lines::trim(cell);
        let cell = cell.strip_prefix(b"\"").and_then(|c| c.strip_suffix(b"\"")).unwrap_or(cell);
        if first.is_none() {
            *first = Some(cell.to_vec());
            return Ok(());
        }
        if current.is_none() {
            let name = first.as_deref().map(as_text).unwrap_or_default();
            let name = self.unique(&if name.is_empty() { format!("line {}", self.line) } else { name });
            let number = self.quantities.len() + 1;
            let keep = self.keep.keeps("", &name, number);
            let mut quantity = Quantity {
                unit: csv::unit_in_name(&name).map(str::to_owned),
                name,
                line: self.line,
                numbers: Builder::new(keep),
                words: Some(Vec::new()),
                odd: ByKind::new(),
                keep,
                count: 0,
            };
            let is_unit_cell = is_unit(cell);
            if is_unit_cell {
                let unit = as_text(cell);
                let inside = unit.trim_matches(['(', ')', '[', ']']).trim().to_owned();
                quantity.unit = Some(inside);
            }
            // What is kept can be looked at later.
            if let (false, Some(unit)) = (keep, csv::clock_unit(&quantity.name, quantity.unit.as_deref())) {
                quantity.numbers = Builder::clock(keep, unit);
            }
            *current = Some(quantity);
            if is_unit_cell {
                return Ok(());
            }
        }
        // A delimiter at the end of the line opens no cell.
        if is_last && cell.is_empty() {
            return Ok(());
        }
        let Some(quantity) = current else { return Ok(()) };
        self.cells += 1;
        if self.cells > LOG_CELLS_MAX {
            let expected = format!("at most {LOG_CELLS_MAX} cells");
            return Err(unusable(self.file, Some(self.line), &expected, "more".to_owned()));
        }
        let row = quantity.count;
        quantity.count += 1;
        let kind = match cell_kind(cell, self.decimal) {
            CellKind::Number(number) => {
                quantity.words = None;
                quantity.numbers.push(number);
                return Ok(());
            }
            CellKind::Empty => FindingKind::EmptyCell,
            CellKind::Hole => FindingKind::NoValue,
            CellKind::Text => FindingKind::NonNumericCell,
        };
        quantity.numbers.push(f64::NAN);
        quantity.odd.entry(kind).or_default().add(row, self.line, cell);
        if let Some(words) = &mut quantity.words {
            words.push(as_text(cell));
        }
        Ok(())
    }

    fn unique(&self, name: &str) -> String {
        let taken = |name: &String| self.quantities.iter().any(|q| q.name == *name);
        let mut unique = name.to_owned();
        let mut copy = 1;
        while taken(&unique) {
            copy += 1;
            unique = format!("{name} ({copy})");
        }
        unique
    }

    fn end_line(&mut self, first: &mut Option<Vec<u8>>, current: &mut Option<Quantity>, is_ended: bool) {
        let name = first.take();
        let Some(mut quantity) = current.take() else {
            self.metadata.extend(name.map(|name| as_text(&name)).filter(|name| !name.is_empty()));
            return;
        };
        match &quantity.words {
            // One word or none behind a name: an operator, a date.
            Some(words) if words.len() < 2 => {
                let line = [&[quantity.name.clone()][..], words].concat().join(": ");
                self.metadata.push(line);
            }
            _ => {
                if !is_ended {
                    let mut places = Places::default();
                    places.add(quantity.count.saturating_sub(1), self.line, &[]);
                    quantity.odd.insert(FindingKind::NoLineEnd, places);
                }
                self.quantities.push(quantity);
            }
        }
    }

    fn finish(self, delimiter: u8) -> Result<Recording, IngestError> {
        let Self { file, quantities, metadata, .. } = self;
        if quantities.is_empty() {
            return Err(unusable(file, None, "lines of a name and numbers", "none".to_owned()));
        }
        if quantities.len() > LOG_COLUMNS_MAX {
            let expected = format!("at most {LOG_COLUMNS_MAX} quantities");
            return Err(unusable(file, None, &expected, quantities.len().to_string()));
        }
        let rows = quantities.iter().map(|q| q.count).max().unwrap_or(0);
        if rows.saturating_mul(quantities.len()) > LOG_CELLS_MAX {
            let expected = format!("at most {LOG_CELLS_MAX} cells, quantities times samples");
            return Err(unusable(file, None, &expected, format!("{} times {rows}", quantities.len())));
        }
        let reasons = vec![format!(
            "one line per quantity, from left to right, parted by {}: each is a name and then numbers",
            if delimiter == b'\t' { "tabs".to_owned() } else { format!("`{}`", char::from(delimiter)) }
        )];
        let (mut findings, mut columns) = (Vec::new(), Vec::new());
        for mut quantity in quantities {
            let name = quantity.name;
            let missing = rows - quantity.count;
            let is_cut = quantity.odd.remove(&FindingKind::NoLineEnd).is_some();
            if missing > 0 || is_cut {
                findings.push(short(file, &name, quantity.line, quantity.count, rows, is_cut));
            }
            for _ in 0..missing {
                quantity.numbers.push(f64::NAN);
            }
            columns.push(if let Some(mut words) = quantity.words {
                words.resize(rows, String::new());
                let cells = if quantity.keep { Cells::Text(words) } else { Cells::NotKept };
                Column::new(&name, quantity.unit.as_deref(), cells)
            } else {
                for (kind, places) in quantity.odd {
                    findings.push(cell_finding(kind, places, file, &name));
                }
                quantity.numbers.finish(name, quantity.unit)
            });
        }
        let table = Table {
            name: String::new(),
            schema: None,
            columns,
            rows,
            lines: LineMap::default(),
            clock: None,
            decimal: Decimal::Point,
        };
        Ok(Recording {
            format: "transposed text",
            tables: vec![table],
            findings,
            reasons,
            metadata,
            origin: None,
            photographs: vec![],
        })
    }
}

/// Tells of a line with fewer samples than the longest, or one that the end of the file may have cut.
fn short(file: &str, name: &str, line: usize, count: usize, rows: usize, is_cut: bool) -> Finding {
    let mut places = Places::default();
    places.add(count.min(rows.saturating_sub(1)), line, &[]);
    let column = shown(name);
    let missing = rows - count;
    let (kind, severity, text) = match (is_cut, missing) {
        (true, 0) => (
            FindingKind::NoLineEnd,
            Severity::Note,
            format!("line {line}, the last, has no line end: its last number may be cut, or nothing is missing"),
        ),
        (true, _) => (
            FindingKind::Truncated,
            Severity::Lost,
            format!(
                "the file ends within line {line}, column {column}: {count} of {rows} samples are there, the last of them may be cut; what followed is lost"
            ),
        ),
        (false, _) => (
            FindingKind::RaggedLine,
            Severity::Excluded,
            format!(
                "line {line}, column {column}, holds {count} samples, the longest {rows}; the {missing} missing at its end are holes"
            ),
        ),
    };
    let mut finding = places.finding(kind, severity, file, Some(name), text);
    finding.count = missing.max(1);
    finding
}

fn unusable(file: &str, line: Option<usize>, expected: &str, found: String) -> IngestError {
    IngestError::Unusable {
        place: Place::new(file, line, None),
        expected: expected.to_owned(),
        found,
        next: "is this the file you meant? A log of one line per quantity begins each line with its name".to_owned(),
    }
}
