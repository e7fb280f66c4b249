//! The pass over the lines of a log: a fast path for lines that are numbers and nothing else, and a careful one for every other line.

use super::cells::{Facts, Kind, facts, filled, kind};
use super::numbers;
use super::sniff::{Found, check_line};
use super::source::{BadLines, Ending, Source, Window};
use super::tally::Tally;
use super::text::{Cell, Record, after_line_end, as_text, check_utf8, split, trim};
use super::unusable;
use crate::IngestError;
use crate::finding::places::{cut_line, no_line_end, quoted};
use crate::finding::{FindingKind, LineMap, Severity};
use crate::limits::{LINE_BYTES_MAX, LOG_CELLS_MAX};
use crate::raw::RawFile;
use crate::recording::{Builder, ClockUnit};

/// What a pass has read.
#[derive(Debug)]
pub(super) struct Rows {
    /// One per column; empty for a column of text.
    pub numbers: Vec<Builder>,
    /// One per column; empty for a column of numbers, and for text that is not kept.
    pub texts: Vec<Vec<String>>,
    pub lines: LineMap,
    pub tally: Tally,
    /// Lines before the table.
    pub metadata: Vec<String>,
    /// Lines that are not UTF-8.
    pub bad: BadLines,
    pub ending: Ending,
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

/// What a pass is to do.
#[derive(Debug, Clone, Copy)]
pub(super) struct Task<'a> {
    pub raw: &'a RawFile<'a>,
    pub found: &'a Found,
    /// Which columns are text.
    pub is_text: &'a [bool],
    /// Which columns are kept.
    pub keep: &'a [bool],
    /// Which columns seem to be clocks.
    pub clocks: &'a [Option<ClockUnit>],
    /// Bytes read at once.
    pub chunk: usize,
}

/// Lines of text that are a trailer unless data follow: what stands on them, without line ends.
#[derive(Debug, Default)]
struct Pending {
    bytes: Vec<u8>,
    /// Where in `bytes` each ends, and its number.
    lines: Vec<(usize, usize)>,
}

/// Lines of text in a row, and their bytes: beyond this they are no trailer of a log, and would only fill memory.
const PENDING_MAX: usize = 1 << 20;
const PENDING_BYTES_MAX: usize = 16 << 20;

/// Lines before the table that are kept, and their bytes. There are only more of them where they are skipped as asked.
const METADATA_LINES_MAX: usize = 100_000;
const METADATA_BYTES_MAX: usize = 16 << 20;

struct Reader<'a> {
    task: Task<'a>,
    usual: usize,
    numbers: Vec<Builder>,
    texts: Vec<Vec<String>>,
    lines: LineMap,
    tally: Tally,
    bad: BadLines,
    balance: Vec<i64>,
    pending: Pending,
    cells: Vec<Cell>,
    reserved: bool,
}

pub(super) fn read(task: Task) -> Result<Rows, IngestError> {
    let Task { raw, found, is_text, keep, clocks, chunk } = task;
    let (columns, usual) = (found.layout.columns, found.layout.cells_per_line);
    let mut source = Source::open(raw, chunk)?;
    let mut bad = BadLines::default();
    let metadata = head(&mut source, found, &mut bad)?;
    let mut reader = Reader {
        task,
        usual,
        numbers: keep
            .iter()
            .zip(is_text)
            .zip(clocks)
            .map(|((keep, is_text), clock)| {
                let keep = *keep && !is_text;
                clock.map_or_else(|| Builder::new(keep), |unit| Builder::clock(keep, unit))
            })
            .collect(),
        texts: vec![Vec::new(); columns],
        lines: LineMap::default(),
        tally: Tally::default(),
        bad,
        balance: vec![0; columns],
        pending: Pending::default(),
        cells: Vec::new(),
        reserved: false,
    };
    let (delimiter, decimal) = (found.layout.delimiter, found.layout.decimal.byte());
    // Numbers and an ASCII delimiter are UTF-8.
    let is_plain = !is_text.contains(&true) && delimiter.is_ascii();
    let mut row = vec![0.0; usual];
    let mut line = found.layout.data_line;
    let mut since_check = 0;
    let mut fast_rows = 0_i64;
    loop {
        let window = source.window();
        let bytes = window.bytes;
        // A carriage return in the last bytes may be the beginning of a line end of three.
        let decided = if window.ended { bytes.len() } else { bytes.len().saturating_sub(2) };
        let mut at = 0;
        while at < bytes.len() {
            if since_check == 0 {
                since_check = 1 << 8;
                reader.check_size(line)?;
                reader.reserve(source.offset() + at as u64, source.expected_length());
            }
            since_check -= 1;
            if is_plain
                && let Some(next) = fast_line(bytes, at, delimiter, decimal, &mut row)
                && next <= decided
                && next - at <= LINE_BYTES_MAX
            {
                if !reader.pending.lines.is_empty() {
                    reader.settle()?;
                }
                for (column, value) in reader.numbers.iter_mut().zip(&row) {
                    column.push(*value);
                }
                for column in reader.numbers.iter_mut().skip(usual) {
                    column.push(f64::NAN);
                }
                reader.lines.push(line);
                fast_rows += 1;
                at = next;
                line += 1;
            } else if let Some(record) = reader.careful_line(window, at, line)? {
                at = record.next;
                line += record.lines;
            } else {
                break;
            }
        }
        if window.ended {
            break;
        }
        source.consume(at);
        source.fill()?;
    }
    for balance in reader.balance.iter_mut().take(usual) {
        *balance -= fast_rows;
    }
    reader.trailer();
    reader.check_size(line)?;
    let Reader { numbers, texts, lines, tally, bad, balance, .. } = reader;
    Ok(Rows { numbers, texts, lines, tally, metadata, bad, ending: source.ending(), balance })
}

/// Goes past the lines before the data; gives those before the table.
fn head(source: &mut Source, found: &Found, bad: &mut BadLines) -> Result<Vec<String>, IngestError> {
    let (mut metadata, mut metadata_bytes) = (Vec::new(), 0);
    let mut line = 1;
    while source.offset() < found.data_at {
        let window = source.window();
        let Some((end, next)) = window.line(0).filter(|(_, next)| *next > 0) else {
            if window.ended {
                break;
            }
            source.fill()?;
            continue;
        };
        // A header may run into the data.
        let rest = usize::try_from(found.data_at - source.offset()).unwrap_or(usize::MAX);
        let text = &window.bytes[..end.min(rest)];
        check_utf8(text, line, bad);
        metadata_bytes += text.len();
        if line <= found.metadata_lines && metadata.len() < METADATA_LINES_MAX && metadata_bytes <= METADATA_BYTES_MAX {
            metadata.push(as_text(text));
        }
        source.consume(next.min(rest));
        line += 1;
    }
    Ok(metadata)
}

/// A line of exactly as many finite numbers as `row` holds, with its line end; where the next one begins. `None` for every other line,
/// which is left to the careful path.
#[inline]
pub(in crate::formats) fn fast_line(
    bytes: &[u8],
    start: usize,
    delimiter: u8,
    decimal: u8,
    row: &mut [f64],
) -> Option<usize> {
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
        let cells = self.lines.rows().saturating_mul(self.task.found.layout.columns);
        // A cell costs a byte of the file; many more cells than bytes are holes under a header far too wide.
        let bytes = usize::try_from(self.task.raw.len()).unwrap_or(usize::MAX);
        let limit = LOG_CELLS_MAX.min(bytes.saturating_mul(4).saturating_add(1 << 20));
        if cells <= limit {
            return Ok(());
        }
        let expected = format!("at most {limit} cells, rows times columns");
        let next = "split the log, or correct a header that names far more columns than there are";
        Err(unusable(self.task.raw.name(), Some(line), &expected, format!("{cells} so far"), next))
    }

    /// Asks once, after some lines, for the memory that as many bytes on all other lines would need.
    fn reserve(&mut self, at: u64, length: u64) {
        let rows = self.lines.rows();
        let read = at.saturating_sub(self.task.found.data_at);
        if self.reserved || rows == 0 || read == 0 {
            return;
        }
        self.reserved = true;
        let rest = u128::from(length.saturating_sub(at));
        let expected = usize::try_from(rest * rows as u128 / u128::from(read)).unwrap_or(usize::MAX);
        let expected = expected.saturating_add(expected / 64).min(LOG_CELLS_MAX / self.task.found.layout.columns);
        for column in &mut self.numbers {
            column.reserve(expected);
        }
    }

    /// Reads a line, whatever it is; `None` if that cannot be said yet.
    fn careful_line(&mut self, window: Window, at: usize, line: usize) -> Result<Option<Record>, IngestError> {
        let Found { layout, comments, .. } = self.task.found;
        let mut cells = std::mem::take(&mut self.cells);
        let Some(record) = split(window, at, layout.delimiter, &mut cells) else {
            self.cells = cells;
            return Ok(None);
        };
        check_line(self.task.raw.name(), record, line)?;
        let blank = filled(&cells) == 0;
        cells.truncate(self.held(&cells));
        let raw = &window.bytes[record.start..record.end];
        check_utf8(raw, line, &mut self.bad);
        let next_row = self.lines.rows();
        if !blank && comments.mark(raw).is_some() {
            let raw = trim(raw);
            if self.is_header(raw) {
                self.tally.line(FindingKind::RepeatedHeader, next_row, line, || quoted(raw));
            } else {
                self.tally.line(FindingKind::CommentLine, next_row, line, || quoted(raw));
            }
        } else if !blank {
            let facts = facts(window.bytes, &cells, layout.decimal, self.task.is_text);
            if self.is_sample(facts, cells.len()) {
                self.settle()?;
                self.sample(window.bytes, record, &mut cells, line);
            } else {
                self.postpone(raw, line)?;
            }
        }
        self.cells = cells;
        Ok(Some(record))
    }

    /// Keeps a line of text until it is known whether data follow.
    fn postpone(&mut self, raw: &[u8], line: usize) -> Result<(), IngestError> {
        let Pending { bytes, lines } = &mut self.pending;
        if lines.len() == PENDING_MAX || bytes.len() + raw.len() > PENDING_BYTES_MAX {
            let found = format!("{} lines in a row that are text", lines.len() + 1);
            let expected = "samples among the lines";
            return Err(unusable(self.task.raw.name(), Some(line), expected, found, "split the log"));
        }
        bytes.extend_from_slice(raw);
        lines.push((bytes.len(), line));
        Ok(())
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
        if self.pending.lines.is_empty() {
            return Ok(());
        }
        let Pending { bytes, lines } = std::mem::take(&mut self.pending);
        let (mut cells, mut start) = (Vec::new(), 0);
        for (end, line) in lines {
            let window = Window::whole(&bytes[..end]);
            let record = split(window, start, self.task.found.layout.delimiter, &mut cells);
            // Its line end stands in the file.
            let record = record.unwrap_or(Record { start, end, next: end, lines: 1 }).ended();
            cells.truncate(self.held(&cells));
            let raw = trim(&bytes[start..end]);
            let row = self.lines.rows();
            if self.is_header(raw) {
                self.tally.line(FindingKind::RepeatedHeader, row, line, || quoted(raw));
            } else if cells.len() == self.usual {
                // A sample whose channels all failed: it keeps its place, or the samples behind it would move.
                self.check_size(line)?;
                self.sample(&bytes, record, &mut cells, line);
            } else {
                self.tally.line(FindingKind::SkippedLine, row, line, || quoted(raw));
            }
            start = end;
        }
        Ok(())
    }

    fn trailer(&mut self) {
        let Pending { bytes, lines } = std::mem::take(&mut self.pending);
        let row = self.lines.rows();
        let mut start = 0;
        for (end, line) in lines {
            let raw = trim(&bytes[start..end]);
            let kind = if self.is_header(raw) { FindingKind::RepeatedHeader } else { FindingKind::Trailer };
            self.tally.line(kind, row, line, || quoted(raw));
            start = end;
        }
    }

    fn is_header(&self, line: &[u8]) -> bool {
        self.task.found.header.iter().any(|header| header == line)
    }

    /// Takes a sample, holes where there is no number.
    fn sample(&mut self, bytes: &[u8], record: Record, cells: &mut Vec<Cell>, line: usize) {
        let row = self.lines.rows();
        let layout = &self.task.found.layout;
        let held = if record.is_ended() { cells.len() } else { filled(cells) };
        if !record.is_ended() {
            if held < self.usual {
                let raw = &bytes[record.start..record.end];
                // Unless a delimiter closes it, the last cell may be cut too: `12.5` of `12.53`.
                let cut = raw.last() != Some(&layout.delimiter);
                let kept = if cut { held.saturating_sub(1) } else { held };
                cells.truncate(kept);
                let text = cut_line(line, held, self.usual, cut);
                self.tally.tell(self.task.raw.name(), FindingKind::Truncated, Severity::Lost, &[(row, line)], text);
                if kept == 0 {
                    return;
                }
            } else {
                let text = no_line_end(line);
                self.tally.tell(self.task.raw.name(), FindingKind::NoLineEnd, Severity::Note, &[(row, line)], text);
            }
        } else if held != self.usual && held != layout.columns {
            self.tally.line(FindingKind::RaggedLine, row, line, || format!("{held} cells"));
        }
        // Which of too many cells is the one too many, nobody knows: a decimal comma between commas shifts all that follow.
        let shifted = record.is_ended() && held > self.usual && held != layout.columns;
        if shifted {
            cells.clear();
        }
        for (column, is_text) in self.task.is_text.iter().enumerate() {
            let cell = cells.get(column);
            let written = cell.map_or(&[][..], |c| c.of(bytes));
            let kind = kind(written, layout.decimal);
            match kind {
                Kind::Number(_) => self.balance[column] -= 1,
                Kind::Text => self.balance[column] += 1,
                Kind::Empty | Kind::Hole => {}
            }
            if *is_text {
                if self.task.keep[column] {
                    self.texts[column].push(cell.map(|c| c.text(bytes)).unwrap_or_default());
                }
                continue;
            }
            let mut hole = |found| self.tally.cell(found, column, row, line, written);
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
            self.numbers[column].push(number);
        }
        self.lines.push(line);
    }
}
