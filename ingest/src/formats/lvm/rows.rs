//! The one pass over a file: headers, special blocks and rows, the rows that are numbers and nothing else on a fast path.

mod sample;
mod segment;

use std::collections::HashMap;

use super::block::{Block, Names, Row};
use super::clock::Clock;
use super::header::{
    END_OF_HEADER, END_SPECIAL, Header, Parting, START_SPECIAL, Stated, X_VALUE, behind, cells, in_words, is_title,
    parting, segment_key, without_end,
};
use super::layout::{LOOKED_BYTES, Looked};
use super::start::Start;
use super::tell::Odd;
use crate::IngestError;
use crate::error::{Place, shown};
use crate::finding::places::{as_text, no_line_end, quoted};
use crate::finding::{FindingKind, Severity};
use crate::formats::csv::rows::fast_line;
use crate::formats::csv::source::{BadLines, Ending, Source, Window};
use crate::formats::csv::tally::Tally;
use crate::formats::csv::text::check_utf8;
use crate::formats::csv::{CellKind, Decimal, cell_kind};
use crate::limits::{LINE_BYTES_MAX, LOG_CELLS_MAX};
use crate::raw::RawFile;
use crate::recording::Keep;

/// Lines that are no rows and are kept as metadata, and their bytes.
const METADATA_LINES_MAX: usize = 10_000;
const METADATA_BYTES_MAX: usize = 1 << 20;

/// Sentences about the layout that are kept: segments could each have some of their own.
const REASONS_MAX: usize = 40;

/// Bytes of the beginning from which the separator is told.
const HEAD_BYTES: usize = 1 << 16;

/// Where in a file a line stands.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum State {
    /// In the header of the file.
    File,
    /// Behind a header, before the names of a segment.
    Between,
    /// In the header of a segment.
    Segment,
    /// Among rows.
    Rows,
}

/// What a pass has read.
pub(super) struct Read<'a> {
    pub blocks: Vec<Block<'a>>,
    pub decimal: Decimal,
    pub tally: Tally,
    pub odd: Odd,
    pub clock: Clock,
    pub metadata: Vec<String>,
    pub reasons: Vec<String>,
    pub bad: BadLines,
    pub ending: Ending,
    /// Cells of a row, for sentences.
    pub usual: usize,
}

struct Reader<'a> {
    raw: &'a RawFile<'a>,
    keep: Keep<'a>,
    separator: u8,
    decimal: Decimal,
    is_decimal_found: bool,
    state: State,
    is_special: bool,
    file: Header,
    header: Header,
    /// Keys of this header.
    own: Vec<&'static str>,
    blocks: Vec<Block<'a>>,
    of_signature: HashMap<String, usize>,
    /// The block of the segment whose rows are read.
    current: usize,
    /// Cells of all blocks but the current one, and the columns of all.
    other_cells: usize,
    names: Names,
    /// Rows under this header, and those before the first blank line among them.
    at: usize,
    parted: Option<usize>,
    /// Of a segment without X: when it began, and its step in s.
    start: Option<Start>,
    /// Cells that are read on the fast path, and whether an empty one stands before them.
    fast: Option<(usize, bool)>,
    clock: Clock,
    odd: Odd,
    tally: Tally,
    bad: BadLines,
    metadata: Vec<String>,
    metadata_bytes: usize,
    left_out: usize,
    reasons: Vec<String>,
    reserved: bool,
    values: Vec<f64>,
    kinds: Vec<CellKind>,
}

/// A line and what follows it.
#[derive(Clone, Copy)]
struct Line<'b> {
    bytes: &'b [u8],
    is_ended: bool,
    number: usize,
    behind: Window<'b>,
}

/// Reads a file.
pub(super) fn read<'a>(raw: &'a RawFile<'a>, keep: Keep<'a>, chunk: usize) -> Result<Read<'a>, IngestError> {
    let mut source = Source::open(raw, chunk)?;
    source.hold(HEAD_BYTES)?;
    let head = source.window().bytes;
    let mut reader = Reader::new(raw, keep, parting(head.get(..HEAD_BYTES).unwrap_or(head)))?;
    let mut line = 1;
    let mut since_check = 0;
    let mut row: Vec<f64> = Vec::new();
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
            if let Some((count, is_blank)) = reader.fast.filter(|_| !reader.is_special) {
                row.resize(count, f64::NAN);
                if let Some(next) = reader.fast_line(bytes, at, is_blank, &mut row)
                    && next <= decided
                    && next - at <= LINE_BYTES_MAX
                {
                    reader.plain(&row, line);
                    at = next;
                    line += 1;
                    continue;
                }
            }
            let Some((end, next)) = window.line(at) else { break };
            let behind = Window { bytes: bytes.get(next..).unwrap_or_default(), ended: window.ended };
            let this =
                Line { bytes: bytes.get(at..end).unwrap_or_default(), is_ended: next > end, number: line, behind };
            if !reader.line(this)? {
                break;
            }
            at = next;
            line += usize::from(this.is_ended);
        }
        if window.ended {
            break;
        }
        source.consume(at);
        source.fill()?;
    }
    reader.check_size(line)?;
    reader.finish(line, source)
}

impl<'a> Reader<'a> {
    fn new(raw: &'a RawFile<'a>, keep: Keep<'a>, parting: Option<Parting>) -> Result<Self, IngestError> {
        let mut reasons = Vec::new();
        let separator = parting.map_or(b'\t', |parting| parting.separator);
        let word = separator_word(separator);
        match parting.map(|parting| parting.stated) {
            None => reasons.push("nothing tells how cells are parted: taken for tabs".to_owned()),
            Some(Stated::Byte(byte)) if byte == separator => {
                reasons.push(format!("cells are parted by {word}, as stated"));
            }
            Some(Stated::Byte(byte)) => {
                let stated = separator_word(byte);
                reasons.push(format!("cells are parted by {word}, as behind `X_Value`; `Separator` states {stated}"));
            }
            Some(Stated::Nothing) => {
                reasons.push(format!("`Separator` is not stated: by the bytes cells are parted by {word}"));
            }
            Some(Stated::Other) => {
                reasons.push(format!("`Separator` is none that is known: by the bytes cells are parted by {word}"));
            }
        }
        if separator.is_ascii_alphanumeric() || matches!(separator, b'.' | b'+' | b'-' | b'_' | b'*' | b'\0') {
            let expected = "cells parted by a character that numbers and names do not hold".to_owned();
            let next = "write the file with tabs between its cells".to_owned();
            let place = Place::new(raw.name(), None, None);
            return Err(IngestError::Unusable { place, expected, found: word, next });
        }
        Ok(Self {
            raw,
            keep,
            separator,
            decimal: Decimal::Point,
            is_decimal_found: false,
            state: State::File,
            is_special: false,
            file: Header::default(),
            header: Header::default(),
            own: Vec::new(),
            blocks: Vec::new(),
            of_signature: HashMap::new(),
            current: 0,
            other_cells: 0,
            names: Names::default(),
            at: 0,
            parted: None,
            start: None,
            fast: None,
            clock: Clock::new(),
            odd: Odd::default(),
            tally: Tally::default(),
            bad: BadLines::default(),
            metadata: Vec::new(),
            metadata_bytes: 0,
            left_out: 0,
            reasons,
            reserved: false,
            values: Vec::new(),
            kinds: Vec::new(),
        })
    }

    fn unusable(&self, line: usize, expected: &str, found: String, next: &str) -> IngestError {
        IngestError::Unusable {
            place: Place::new(self.raw.name(), Some(line), None),
            expected: expected.to_owned(),
            found,
            next: next.to_owned(),
        }
    }

    fn check_size(&self, line: usize) -> Result<(), IngestError> {
        let cells = self.other_cells.saturating_add(self.blocks.get(self.current).map_or(0, Block::cells));
        // A cell costs a byte of the file; many more cells than bytes are holes under names far too many.
        let bytes = usize::try_from(self.raw.len()).unwrap_or(usize::MAX);
        let limit = LOG_CELLS_MAX.min(bytes.saturating_mul(4).saturating_add(1 << 20));
        if cells <= limit {
            return Ok(());
        }
        let expected = format!("at most {limit} cells, rows times columns");
        let next = "split the log, or correct a header that names far more channels than there are";
        Err(self.unusable(line, &expected, format!("{cells} so far"), next))
    }

    /// Asks once, after some rows of the first segment, for the memory that as many bytes on all other lines would need.
    fn reserve(&mut self, at: u64, length: u64) {
        let Some(block) = self.blocks.get_mut(self.current).filter(|_| !self.reserved && self.state == State::Rows)
        else {
            return;
        };
        let rows = block.rows();
        if rows < 1 << 7 {
            return;
        }
        self.reserved = true;
        let rest = u128::from(length.saturating_sub(at));
        let expected = usize::try_from(rest * rows as u128 / u128::from(at.max(1))).unwrap_or(usize::MAX);
        block.reserve(expected.saturating_add(expected / 64).min(LOG_CELLS_MAX / block.columns().max(1)));
    }

    /// A row of numbers and nothing else.
    #[inline]
    fn fast_line(&self, bytes: &[u8], at: usize, is_blank: bool, row: &mut [f64]) -> Option<usize> {
        if !is_blank {
            return fast_line(bytes, at, self.separator, self.decimal.byte(), row);
        }
        if bytes.get(at) != Some(&self.separator) {
            return None;
        }
        fast_line(bytes, at + 1, self.separator, self.decimal.byte(), row.get_mut(1..)?)
    }

    #[inline]
    fn plain(&mut self, values: &[f64], line: usize) {
        if let Some(block) = self.blocks.get_mut(self.current) {
            block.push(Row { values, careful: None, at: self.at, line, comment: "", cut: None }, &mut self.names);
            self.at += 1;
        }
    }

    /// Reads a line, whatever it is; whether that could be done with what is in memory.
    fn line(&mut self, line: Line) -> Result<bool, IngestError> {
        let bytes = line.bytes;
        if bytes.len() > LINE_BYTES_MAX && !self.is_special {
            let expected = format!("lines of at most {LINE_BYTES_MAX} bytes");
            let next = "is this a text log? Its line ends may be missing";
            return Err(self.unusable(line.number, &expected, "a longer one".to_owned(), next));
        }
        if self.is_special || bytes.starts_with(START_SPECIAL) {
            self.is_special = !bytes.starts_with(END_SPECIAL);
            check_utf8(bytes, line.number, &mut self.bad);
            self.note(as_text(without_end(bytes, self.separator)));
            return Ok(true);
        }
        if behind(bytes, X_VALUE).is_some() && (self.state != State::Rows || is_names(bytes, self.separator)) {
            // Without its end the last name may be cut.
            if !line.is_ended {
                return Ok(true);
            }
            let Some(looked) = Looked::new(line.behind, self.separator) else { return Ok(false) };
            if self.state == State::Rows {
                let row = self.rows();
                self.tally.line(FindingKind::RepeatedHeader, row, line.number, || quoted(bytes));
                self.end_segment();
            }
            check_utf8(bytes, line.number, &mut self.bad);
            let names = cells(bytes, self.separator).collect();
            self.begin_segment(Some(names), &looked, line.number)?;
            return Ok(true);
        }
        let is_blank = without_end(bytes, self.separator).is_empty();
        match self.state {
            State::Rows if is_header(bytes) => {
                self.end_segment();
                self.header_line(bytes);
            }
            State::Rows => {
                let separators = bytes.iter().filter(|b| **b == self.separator).count();
                let usual = self.blocks.get(self.current).map_or(0, |block| block.layout.cells);
                // One separator alone stands between segments.
                if !is_blank || (separators > 1 && separators + 1 >= usual) {
                    self.sample(line);
                } else {
                    self.parted.get_or_insert(self.at);
                    if !line.is_ended && !bytes.is_empty() {
                        // Where X would stand in the next row, perhaps.
                        let place = [(self.rows(), line.number)];
                        let text = no_line_end(line.number);
                        self.tally.tell(self.raw.name(), FindingKind::NoLineEnd, Severity::Note, &place, text);
                    }
                }
                return Ok(true);
            }
            State::Between if !is_blank && self.is_row(bytes) => {
                // No more than is looked at: a file may begin a segment on every other line.
                let behind = line.behind.bytes;
                let whole = [bytes, b"\n", behind.get(..LOOKED_BYTES).unwrap_or(behind)].concat();
                let window = Window { bytes: &whole, ended: line.behind.ended };
                let Some(looked) = Looked::new(window, self.separator) else { return Ok(false) };
                self.begin_segment(None, &looked, line.number)?;
                self.sample(line);
                return Ok(true);
            }
            _ if is_blank => {}
            _ => self.header_line(bytes),
        }
        check_utf8(bytes, line.number, &mut self.bad);
        Ok(true)
    }

    /// Whether a line behind a header that named no channels is a row.
    fn is_row(&self, line: &[u8]) -> bool {
        let decimals = [Decimal::Point, Decimal::Comma];
        let mut cells = cells(line, self.separator);
        let first = cells.next().unwrap_or_default();
        let is_number = |cell: &[u8]| decimals.iter().any(|d| matches!(cell_kind(cell, *d), CellKind::Number(_)));
        is_number(first) || (first.is_empty() && cells.next().is_some_and(is_number))
    }

    /// A line of a header, or of free text in it.
    fn header_line(&mut self, line: &[u8]) {
        if is_title(line) {
            // A file may stand behind another: nothing that was stated for the one holds for the other.
            self.file = Header::default();
            self.header = Header::default();
            self.own.clear();
            self.is_decimal_found = false;
            self.state = State::File;
            return;
        }
        if line.starts_with(END_OF_HEADER) {
            self.state = State::Between;
            return;
        }
        let of_segment = segment_key(line).is_some_and(|key| !matches!(key, "Date" | "Time" | "Notes"));
        match self.state {
            State::File if !of_segment => {
                self.file.file_line(line, self.separator);
            }
            State::Segment => {
                self.header.segment_line(line, self.separator, &mut self.own);
            }
            _ if segment_key(line).is_some() => {
                self.header = self.header.next();
                self.own.clear();
                self.header.segment_line(line, self.separator, &mut self.own);
                self.state = State::Segment;
            }
            _ => {}
        }
        self.note(in_words(line, self.separator));
    }

    fn note(&mut self, text: String) {
        self.metadata_bytes += text.len();
        if self.metadata.len() < METADATA_LINES_MAX && self.metadata_bytes <= METADATA_BYTES_MAX {
            self.metadata.push(text);
        } else {
            self.left_out += 1;
        }
    }

    fn reason(&mut self, reason: String) {
        if self.reasons.len() < REASONS_MAX && !self.reasons.contains(&reason) {
            self.reasons.push(reason);
        }
    }

    /// Samples so far of the table that rows go to.
    fn rows(&self) -> usize {
        self.blocks.get(self.current).map_or(0, Block::rows)
    }

    fn finish(mut self, line: usize, source: Source) -> Result<Read<'a>, IngestError> {
        let file = self.raw.name();
        if self.blocks.is_empty() {
            let place = if self.is_special { "a special block" } else { "its header" };
            let found = format!("the file ends within {place}, before any channel is named");
            let next = "was the file cut? Copy it again";
            return Err(self.unusable(line, "a line `X_Value` with the names of the channels", found, next));
        }
        let place = (self.rows(), line);
        let mut tell = |text: &str| {
            let text = format!("the file ends within {text}; what followed is lost");
            self.tally.tell(file, FindingKind::Truncated, Severity::Lost, &[place], text);
        };
        if self.is_special {
            tell("a special block");
        } else if self.state == State::Segment || (self.state == State::Between && self.header.is_stated) {
            tell("the header of a segment");
        } else if self.state == State::File {
            tell("a header");
        }
        let usual = self.blocks.get(self.current).map_or(0, |block| block.layout.cells);
        if self.state == State::Rows {
            self.end_segment();
        }
        if self.left_out > 0 {
            self.metadata.push(format!("({} more lines of headers)", self.left_out));
        }
        let Self { blocks, decimal, tally, odd, clock, metadata, reasons, bad, .. } = self;
        Ok(Read { blocks, decimal, tally, odd, clock, metadata, reasons, bad, ending: source.ending(), usual })
    }
}

/// Whether a line among rows begins a header.
fn is_header(line: &[u8]) -> bool {
    line.starts_with(END_OF_HEADER) || is_title(line) || segment_key(line).is_some()
}

/// Whether a line that begins as the names do among rows is one: a row does not begin with a word.
fn is_names(line: &[u8], separator: u8) -> bool {
    behind(line, X_VALUE).is_some_and(|rest| rest.first().is_none_or(|b| *b == separator))
}

fn separator_word(byte: u8) -> String {
    match byte {
        b'\t' => "tabs".to_owned(),
        b',' => "commas".to_owned(),
        b';' => "semicolons".to_owned(),
        b' ' => "blanks".to_owned(),
        byte => shown(&char::from(byte).to_string()),
    }
}
