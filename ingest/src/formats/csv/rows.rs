//! The pass over the lines of data: a fast path for lines that are numbers and nothing else, and a careful one for every other line.

use super::cells::{Facts, Kind, facts, filled, kind};
use super::numbers;
use super::sniff::{Found, check_line};
use super::tally::{Tally, quoted};
use super::text::{Cell, Record, after_line_end, split, trim};
use super::unusable;
use crate::IngestError;
use crate::finding::{FindingKind, LineMap, Severity};
use crate::limits::{LINE_BYTES_MAX, LOG_CELLS_MAX};

/// What a pass has read.
#[derive(Debug)]
pub(super) struct Rows {
    /// One per column; empty for a column of text.
    pub numbers: Vec<Vec<f64>>,
    /// One per column; empty for a column of numbers.
    pub texts: Vec<Vec<String>>,
    pub lines: LineMap,
    pub tally: Tally,
    /// Per column: cells that are text less cells that are numbers.
    balance: Vec<i64>,
}

impl Rows {
    /// Which columns turned out to be text; `None` if it is as was taken from the first lines.
    pub fn other_kinds(&self, is_text: &[bool]) -> Option<Vec<bool>> {
        let text: Vec<bool> = self.balance.iter().map(|b| *b > 0).collect();
        (text != is_text).then_some(text)
    }
}

/// A line of text that is a trailer unless data follow.
struct Pending {
    start: usize,
    line: usize,
}

/// Lines of text in a row: beyond this they are no trailer of a log, and would only fill memory.
const PENDING_MAX: usize = 1 << 20;

struct Reader<'a> {
    file: &'a str,
    bytes: &'a [u8],
    found: &'a Found,
    is_text: &'a [bool],
    usual: usize,
    out: Rows,
    pending: Vec<Pending>,
    cells: Vec<Cell>,
    reserved: bool,
}

pub(super) fn read(file: &str, bytes: &[u8], found: &Found, is_text: &[bool]) -> Result<Rows, IngestError> {
    let (columns, usual) = (found.layout.columns, found.layout.cells_per_line);
    let mut reader = Reader {
        file,
        bytes,
        found,
        is_text,
        usual,
        out: Rows {
            numbers: vec![Vec::new(); columns],
            texts: vec![Vec::new(); columns],
            lines: LineMap::default(),
            tally: Tally::default(),
            balance: vec![0; columns],
        },
        pending: Vec::new(),
        cells: Vec::new(),
        reserved: false,
    };
    let all_numbers = !is_text.contains(&true);
    let (delimiter, decimal) = (found.layout.delimiter, found.layout.decimal.byte());
    let mut row = vec![0.0; usual];
    let (mut at, mut line) = (found.data_at, found.layout.data_line);
    let mut since_check = 0;
    let mut fast_rows = 0_i64;
    while at < bytes.len() {
        if since_check == 0 {
            since_check = 1 << 8;
            reader.check_size(line)?;
            reader.reserve(at);
        }
        since_check -= 1;
        if all_numbers && let Some(next) = fast_line(bytes, at, delimiter, decimal, &mut row) {
            if next - at > LINE_BYTES_MAX {
                check_line(file, Record { start: at, end: next, next, lines: 1 }, line)?;
            }
            if !reader.pending.is_empty() {
                reader.settle()?;
            }
            for (column, value) in reader.out.numbers.iter_mut().zip(&row) {
                column.push(*value);
            }
            for column in reader.out.numbers.iter_mut().skip(usual) {
                column.push(f64::NAN);
            }
            reader.out.lines.push(line);
            fast_rows += 1;
            at = next;
            line += 1;
        } else {
            let record = reader.careful_line(at, line)?;
            at = record.next;
            line += record.lines;
        }
    }
    for balance in reader.out.balance.iter_mut().take(usual) {
        *balance -= fast_rows;
    }
    reader.trailer();
    reader.check_size(line)?;
    Ok(reader.out)
}

/// A line of exactly as many finite numbers as `row` holds, with its line end; where the next one begins. `None` for every other line,
/// which is left to the careful path.
#[inline]
fn fast_line(bytes: &[u8], start: usize, delimiter: u8, decimal: u8, row: &mut [f64]) -> Option<usize> {
    let mut at = start;
    let count = row.len();
    for (i, value) in row.iter_mut().enumerate() {
        while bytes.get(at) == Some(&b' ') {
            at += 1;
        }
        let (number, end) = numbers::scan(bytes, at, decimal)?;
        if !number.is_finite() {
            return None;
        }
        *value = number;
        at = end;
        if delimiter != b' ' {
            while bytes.get(at) == Some(&b' ') {
                at += 1;
            }
        }
        let last = i + 1 == count;
        match bytes.get(at) {
            Some(b) if *b == delimiter && !last => at += 1,
            Some(b'\n') if last => return Some(at + 1),
            Some(b'\r') if last => return Some(after_line_end(bytes, at)),
            // A delimiter at the end of the line opens no column.
            Some(b) if *b == delimiter && matches!(bytes.get(at + 1), Some(b'\n' | b'\r')) => {
                return Some(after_line_end(bytes, at + 1));
            }
            _ => return None,
        }
    }
    None
}

impl Reader<'_> {
    fn check_size(&self, line: usize) -> Result<(), IngestError> {
        let cells = self.out.lines.rows().saturating_mul(self.found.layout.columns);
        // A cell costs a byte of the file; many more cells than bytes are holes under a header far too wide.
        let limit = LOG_CELLS_MAX.min(self.bytes.len().saturating_mul(4).saturating_add(1 << 20));
        if cells <= limit {
            return Ok(());
        }
        let expected = format!("at most {limit} cells, rows times columns");
        let next = "split the log, or correct a header that names far more columns than there are";
        Err(unusable(self.file, Some(line), &expected, format!("{cells} so far"), next))
    }

    /// Asks once, after some lines, for the memory that as many bytes on all other lines would need.
    fn reserve(&mut self, at: usize) {
        let rows = self.out.lines.rows();
        let read = at - self.found.data_at;
        if self.reserved || rows == 0 || read == 0 {
            return;
        }
        self.reserved = true;
        let rest = (self.bytes.len() - at) as u128;
        let expected = usize::try_from(rest * rows as u128 / read as u128).unwrap_or(usize::MAX);
        let expected = (expected + expected / 64).min(LOG_CELLS_MAX / self.found.layout.columns);
        for (column, is_text) in self.out.numbers.iter_mut().zip(self.is_text) {
            if !is_text {
                column.reserve(expected);
            }
        }
    }

    fn careful_line(&mut self, at: usize, line: usize) -> Result<Record, IngestError> {
        let Found { layout, comments, .. } = self.found;
        let mut cells = std::mem::take(&mut self.cells);
        let record = split(self.bytes, at, layout.delimiter, &mut cells);
        check_line(self.file, record, line)?;
        let blank = filled(&cells) == 0;
        cells.truncate(self.held(&cells));
        let raw = &self.bytes[record.start..record.end];
        let next_row = self.out.lines.rows();
        if !blank && comments.mark(raw).is_some() {
            let raw = trim(raw);
            if self.is_header(raw) {
                self.out.tally.line(FindingKind::RepeatedHeader, next_row, line, || quoted(raw));
            } else {
                self.out.tally.line(FindingKind::CommentLine, next_row, line, || quoted(raw));
            }
        } else if !blank {
            let facts = facts(self.bytes, &cells, layout.decimal, self.is_text);
            if self.is_sample(facts, cells.len()) {
                self.settle()?;
                self.sample(record, &mut cells, line);
            } else {
                if self.pending.len() == PENDING_MAX {
                    let expected = "samples among the lines";
                    let found = format!("{PENDING_MAX} lines in a row that are text");
                    return Err(unusable(self.file, Some(line), expected, found, "split the log"));
                }
                self.pending.push(Pending { start: record.start, line });
            }
        }
        self.cells = cells;
        Ok(record)
    }

    /// Whether a line that is neither blank nor a comment is a sample. One with fewer or more cells than usual is one if it begins with
    /// a number.
    fn is_sample(&self, facts: Facts, cells: usize) -> bool {
        if cells == self.usual {
            return facts.numbers > 0 || (facts.holes > 0 && facts.texts == 0);
        }
        facts.first_is_number
    }

    /// Cells that a line holds. An empty one beyond the usual number is what a delimiter at the end of the line makes.
    fn held(&self, cells: &[Cell]) -> usize {
        if cells.len() >= self.usual { filled(cells).max(self.usual) } else { cells.len() }
    }

    /// Data follow after lines of text, so these are no trailer.
    fn settle(&mut self) -> Result<(), IngestError> {
        if self.pending.is_empty() {
            return Ok(());
        }
        let mut cells = Vec::new();
        for Pending { start, line } in std::mem::take(&mut self.pending) {
            let record = split(self.bytes, start, self.found.layout.delimiter, &mut cells);
            cells.truncate(self.held(&cells));
            let raw = trim(&self.bytes[record.start..record.end]);
            let row = self.out.lines.rows();
            if self.is_header(raw) {
                self.out.tally.line(FindingKind::RepeatedHeader, row, line, || quoted(raw));
            } else if cells.len() == self.usual {
                // A sample whose channels all failed: it keeps its place, or the samples behind it would move.
                self.check_size(line)?;
                self.sample(record, &mut cells, line);
            } else {
                self.out.tally.line(FindingKind::SkippedLine, row, line, || quoted(raw));
            }
        }
        Ok(())
    }

    fn trailer(&mut self) {
        let row = self.out.lines.rows();
        let mut cells = Vec::new();
        for Pending { start, line } in std::mem::take(&mut self.pending) {
            let record = split(self.bytes, start, self.found.layout.delimiter, &mut cells);
            let raw = trim(&self.bytes[record.start..record.end]);
            let kind = if self.is_header(raw) { FindingKind::RepeatedHeader } else { FindingKind::Trailer };
            self.out.tally.line(kind, row, line, || quoted(raw));
        }
    }

    fn is_header(&self, line: &[u8]) -> bool {
        self.found.header.iter().any(|header| header == line)
    }

    /// Takes a sample, holes where there is no number.
    fn sample(&mut self, record: Record, cells: &mut Vec<Cell>, line: usize) {
        let row = self.out.lines.rows();
        let layout = &self.found.layout;
        let held = if record.is_ended() { cells.len() } else { filled(cells) };
        if !record.is_ended() {
            if held < self.usual {
                let raw = &self.bytes[record.start..record.end];
                // Unless a delimiter closes it, the last cell may be cut too: `12.5` of `12.53`.
                let cut = raw.last() != Some(&layout.delimiter);
                let kept = if cut { held.saturating_sub(1) } else { held };
                cells.truncate(kept);
                let cell = if cut { "; the last of them may be cut and is a hole" } else { "" };
                let text = format!(
                    "the file ends within line {line}: {held} of {} cells are there{cell}; what followed is lost",
                    self.usual
                );
                self.out.tally.tell(self.file, FindingKind::Truncated, Severity::Lost, &[(row, line)], text);
                if kept == 0 {
                    return;
                }
            } else {
                let text = format!(
                    "line {line}, the last, has no line end: its last number may be cut, or nothing is missing"
                );
                self.out.tally.tell(self.file, FindingKind::NoLineEnd, Severity::Note, &[(row, line)], text);
            }
        } else if held != self.usual && held != layout.columns {
            self.out.tally.line(FindingKind::RaggedLine, row, line, || format!("{held} cells"));
        }
        // Which of too many cells is the one too many, nobody knows: a decimal comma between commas shifts all that follow.
        let shifted = record.is_ended() && held > self.usual && held != layout.columns;
        if shifted {
            cells.clear();
        }
        for (column, is_text) in self.is_text.iter().enumerate() {
            let cell = cells.get(column);
            let bytes = cell.map_or(&[][..], |c| c.of(self.bytes));
            let kind = kind(bytes, layout.decimal);
            match kind {
                Kind::Number(_) => self.out.balance[column] -= 1,
                Kind::Text => self.out.balance[column] += 1,
                Kind::Empty | Kind::Hole => {}
            }
            if *is_text {
                self.out.texts[column].push(cell.map(|c| c.text(self.bytes)).unwrap_or_default());
                continue;
            }
            let mut hole = |found| self.out.tally.cell(found, column, row, line, bytes);
            let number = match kind {
                Kind::Number(number) => number,
                Kind::Text => {
                    hole(FindingKind::NonNumericCell);
                    f64::NAN
                }
                Kind::Hole => {
                    hole(FindingKind::NoValue);
                    f64::NAN
                }
                Kind::Empty => {
                    // A column that only the header knows is told once, with the header.
                    if column < self.usual && !shifted {
                        hole(FindingKind::EmptyCell);
                    }
                    f64::NAN
                }
            };
            self.out.numbers[column].push(number);
        }
        self.out.lines.push(line);
    }
}
