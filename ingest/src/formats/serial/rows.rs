//! Delimited lines that a terminal stamped, or whose header has lost its line end.

use super::prefix::strip;
use super::{LOOKED_AT, Terminal};
use crate::IngestError;
use crate::finding::places::{as_text, told};
use crate::finding::{Finding, FindingKind, Severity};
use crate::formats::csv::{self, CellKind, CsvOptions, Decimal, cell_kind, unit_in_name};
use crate::formats::lines::{Line, Lines, cells, trim};
use crate::formats::sheet::{OddLines, Sheet};
use crate::raw::RawFile;
use crate::recording::{Cells, Keep, Recording};

/// Whether most lines begin with a terminal's stamp and hold numbers behind it.
pub(super) fn is_stamped(lines: &[&[u8]]) -> bool {
    let lines = lines.get(..LOOKED_AT).unwrap_or(lines);
    let stamped = lines.iter().filter(|line| {
        let stripped = strip(line);
        let is_number = |b: &u8| b.is_ascii_digit() || matches!(b, b'+' | b'-' | b'.');
        stripped.stamp.is_some() && stripped.rest.first().is_some_and(is_number)
    });
    let count = stamped.count();
    count > 1 && count * 2 > lines.len()
}

/// Names and a first sample on one line: `time,p,flex0.00,1.2,3`.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Glue {
    /// Index among the lines looked at.
    pub at: usize,
    delimiter: u8,
    names: Vec<String>,
    /// The cells of the sample; `None` for the first where the name may end in a digit of its own.
    first: Vec<Option<Vec<u8>>>,
}

impl Glue {
    /// Looks for such a line among the first lines.
    pub fn find(lines: &[&[u8]]) -> Option<Self> {
        let candidates = [
            (b',', Decimal::Point),
            (b';', Decimal::Point),
            (b'\t', Decimal::Point),
            (b'|', Decimal::Point),
            (b' ', Decimal::Point),
            (b';', Decimal::Comma),
            (b'\t', Decimal::Comma),
            (b'|', Decimal::Comma),
            (b' ', Decimal::Comma),
        ];
        (0..lines.len().min(20)).find_map(|at| {
            candidates.into_iter().find_map(|(delimiter, decimal)| Self::of(lines, at, delimiter, decimal))
        })
    }

    fn of(lines: &[&[u8]], at: usize, delimiter: u8, decimal: Decimal) -> Option<Self> {
        let mut parts = Vec::new();
        cells(strip(lines.get(at)?).rest, delimiter, &mut parts);
        // 2 n - 1 cells: the last name and the first number share one.
        if parts.len() < 3 || parts.len().is_multiple_of(2) {
            return None;
        }
        let count = parts.len().div_ceil(2);
        let is_number = |cell: &[u8]| matches!(cell_kind(cell, decimal), CellKind::Number(_) | CellKind::Hole);
        let is_name =
            |cell: &[u8]| cell_kind(cell, decimal) == CellKind::Text && !cell.first().is_some_and(u8::is_ascii_digit);
        let names = parts.get(..count - 1)?;
        let numbers = parts.get(count..)?;
        let glued = parts.get(count - 1)?;
        if !names.iter().all(|cell| is_name(cell)) || !numbers.iter().all(|cell| is_number(cell)) {
            return None;
        }
        let (name, number) = split(glued, decimal)?;
        // The lines behind it hold as many numbers as there are names.
        let behind = lines.get(at + 1..)?;
        let behind = behind.get(..behind.len().min(8))?;
        let is_sample = |line: &&&[u8]| {
            let mut own = Vec::new();
            cells(strip(line).rest, delimiter, &mut own);
            own.len() == count && own.iter().all(|cell| is_number(cell))
        };
        let samples = behind.iter().filter(is_sample).count();
        if samples == 0 || samples * 2 < behind.len() {
            return None;
        }
        let mut all: Vec<String> = names.iter().map(|name| as_text(name)).collect();
        all.push(as_text(name));
        let first = std::iter::once(number.map(<[u8]>::to_vec)).chain(numbers.iter().map(|n| Some(n.to_vec())));
        Some(Self { at, delimiter, names: all, first: first.collect() })
    }

    /// The names as a line of their own.
    fn header(&self) -> String {
        let delimiter = if self.delimiter == b' ' { "  ".to_owned() } else { char::from(self.delimiter).to_string() };
        self.names.join(&delimiter)
    }
}

/// Name and number of `flex0.00`; no number where the name may end in a digit: `p20.00` is `p` and 20.00, or `p2` and 0.00.
fn split(glued: &[u8], decimal: Decimal) -> Option<(&[u8], Option<&[u8]>)> {
    let is_number = |text: &[u8]| matches!(cell_kind(text, decimal), CellKind::Number(_));
    // The longest number at the end.
    let longest = (1..glued.len()).find(|at| glued.get(*at..).is_some_and(is_number))?;
    let (name, number) = glued.split_at_checked(longest)?;
    // `-0.5` begins in one place only; else `1.5` of `21.5` is a number as well, but programs write no `01.5` and no `.5`.
    let digits = number.iter().take_while(|b| b.is_ascii_digit()).count();
    let is_in_word = name.last().is_some_and(|b| b.is_ascii_alphanumeric() || *b == b'_' || *b >= 0x80);
    let is_open = is_in_word && (1..digits).any(|at| number.get(at) != Some(&b'0') || at + 1 == digits);
    let is_name = name.first().is_some_and(|b| b.is_ascii_alphabetic() || *b == b'_' || *b >= 0x80);
    is_name.then_some((name, (!is_open).then_some(number)))
}

/// Reads such a log: the layout is that of the first lines without what the terminal wrote and with the header set free.
pub(super) fn read(raw: &RawFile, head: &[u8], is_whole: bool, keep: Keep) -> Result<Recording, IngestError> {
    let file = raw.name();
    let mut numbered = Vec::new();
    {
        let head_file = RawFile::of_bytes(file, head);
        let mut lines = Lines::of(&head_file)?;
        while let Some(line) = lines.next()? {
            if line.is_ended || is_whole {
                numbered.push((line.number, line.bytes.to_vec()));
            }
        }
    }
    let filled: Vec<&(usize, Vec<u8>)> = numbered.iter().filter(|(_, line)| !line.trim_ascii().is_empty()).collect();
    let bare: Vec<&[u8]> = filled.iter().map(|(_, line)| line.as_slice()).collect();
    let glue = Glue::find(&bare);
    let glue_line = glue.as_ref().and_then(|glue| filled.get(glue.at)).map(|(number, _)| *number);
    let mut text = Vec::new();
    for (number, line) in &numbered {
        match &glue {
            Some(glue) if Some(*number) == glue_line => text.extend_from_slice(glue.header().as_bytes()),
            _ => text.extend_from_slice(strip(line).rest),
        }
        text.push(b'\n');
    }
    let options = CsvOptions { delimiter: glue.as_ref().map(|glue| glue.delimiter), ..CsvOptions::default() };
    let log = csv::read(file, &text, &options)?;
    let layout = &log.layout;
    let stamped = numbered.iter().filter(|(_, line)| strip(line).stamp.is_some()).count();

    let mut sheet = Sheet::new(file, "", keep);
    let terminal = if stamped * 2 > filled.len() { Some(Terminal::add(&mut sheet)?) } else { None };
    let mut columns = Vec::with_capacity(log.columns.len());
    for column in &log.columns {
        let unit = column.unit.as_deref().or_else(|| unit_in_name(&column.name));
        columns.push(match &column.cells {
            Cells::Text(_) => sheet.text(&column.name)?,
            Cells::Numbers(_) | Cells::NotKept => sheet.numbers(&column.name, unit, true)?,
        });
    }
    let header = layout.names_line.and_then(|line| numbered.iter().find(|(number, _)| *number == line));
    let header = match (&glue, header) {
        (Some(glue), _) => glue.header().into_bytes(),
        (None, Some((_, line))) => strip(line).rest.to_vec(),
        (None, None) => Vec::new(),
    };
    let mut reading = Reading {
        file,
        delimiter: layout.delimiter,
        decimal: layout.decimal,
        usual: layout.cells_per_line,
        header,
        columns,
        sheet,
        terminal,
        odd: OddLines::default(),
        pending: Vec::new(),
        glue: Vec::new(),
    };
    let begin = glue_line.unwrap_or(layout.data_line);
    let mut lines = Lines::of(raw)?;
    while let Some(line) = lines.next()? {
        if line.number < begin || line.bytes.trim_ascii().is_empty() {
            continue;
        }
        match &glue {
            Some(glue) if Some(line.number) == glue_line => reading.glued(glue, line)?,
            _ => reading.line(line)?,
        }
    }
    let end = lines.end_findings(reading.sheet.lines());
    let mut recording = reading.finish(end);
    recording.reasons = layout.reasons.clone();
    if recording.tables.first().is_some_and(|t| t.column(Terminal::NAME).is_some()) {
        recording.reasons.push("most lines begin with a terminal's stamp: column `terminal_time`".to_owned());
    }
    recording.metadata = log.metadata;
    Ok(recording)
}

/// Lines without a sample that may be a trailer: beyond this they are none.
const PENDING_MAX: usize = 1000;

struct Reading<'a> {
    file: &'a str,
    delimiter: u8,
    decimal: Decimal,
    usual: usize,
    header: Vec<u8>,
    columns: Vec<usize>,
    sheet: Sheet<'a>,
    terminal: Option<Terminal>,
    odd: OddLines,
    pending: Vec<(usize, Vec<u8>)>,
    glue: Vec<Finding>,
}

impl Reading<'_> {
    fn glued(&mut self, glue: &Glue, line: Line) -> Result<(), IngestError> {
        if let Some(terminal) = &mut self.terminal {
            terminal.put(&mut self.sheet, strip(line.bytes).stamp, line.number);
        }
        for (column, cell) in self.columns.iter().zip(&glue.first) {
            match cell {
                Some(cell) => self.sheet.cell(*column, cell, self.decimal, line.number),
                None => self.sheet.hole(*column, FindingKind::HeaderGlued, line.number, &[]),
            }
        }
        let what = if glue.first.iter().all(Option::is_some) {
            "both are read"
        } else {
            "the names are read and the sample too, but for its first number: which of its digits belong to the name is open, so it \
             is a hole"
        };
        let text = format!(
            "line {} holds the names and the first sample, the line end between them is missing: {what}",
            line.number
        );
        let row = self.sheet.rows();
        self.glue.push(told(FindingKind::HeaderGlued, Severity::Note, self.file, row, line.number, text));
        self.sheet.end_row(line.number, false)
    }

    fn line(&mut self, line: Line) -> Result<(), IngestError> {
        let stripped = strip(line.bytes);
        let row = self.sheet.rows();
        if !self.header.is_empty() && stripped.rest == self.header.as_slice() {
            self.odd.add(FindingKind::RepeatedHeader, row, line);
            return Ok(());
        }
        let mut parts = Vec::with_capacity(self.usual);
        cells(stripped.rest, self.delimiter, &mut parts);
        let kind = |cell: &&[u8]| cell_kind(cell, self.decimal);
        let numbers = parts.iter().map(kind).filter(|k| matches!(k, CellKind::Number(_) | CellKind::Hole)).count();
        let first_is_number = parts.first().is_some_and(|cell| matches!(kind(cell), CellKind::Number(_)));
        let is_sample = if parts.len() == self.usual { numbers > 0 } else { first_is_number };
        if !is_sample {
            let text = trim(line.bytes);
            if self.pending.len() >= PENDING_MAX {
                self.settle();
            }
            self.pending.push((line.number, text.get(..400).unwrap_or(text).to_vec()));
            return Ok(());
        }
        self.settle();
        if !self.odd.fit(self.file, &mut parts, self.usual, row, line) {
            return Ok(());
        }
        if let Some(terminal) = &mut self.terminal {
            terminal.put(&mut self.sheet, stripped.stamp, line.number);
        }
        for (column, cell) in self.columns.iter().zip(&parts) {
            self.sheet.cell(*column, cell, self.decimal, line.number);
        }
        self.sheet.end_row(line.number, false)
    }

    /// Samples follow after lines of text, so these are no trailer.
    fn settle(&mut self) {
        let row = self.sheet.rows();
        for (number, bytes) in std::mem::take(&mut self.pending) {
            let line = Line { bytes: &bytes, number, is_ended: true };
            self.odd.add(FindingKind::SkippedLine, row, line);
        }
    }

    fn finish(mut self, end: Vec<Finding>) -> Recording {
        let file = self.file;
        let row = self.sheet.rows();
        for (number, bytes) in std::mem::take(&mut self.pending) {
            let line = Line { bytes: &bytes, number, is_ended: true };
            self.odd.add(FindingKind::Trailer, row, line);
        }
        let mut findings = self.glue;
        findings.extend(self.odd.finish(file, self.usual));
        findings.extend(end);
        if let Some(terminal) = &self.terminal {
            findings.extend(terminal.findings(file, &self.sheet));
        }
        let origin = self.terminal.as_ref().and_then(Terminal::origin);
        let (table, mut cells) = self.sheet.finish();
        // The glued number is told with its line.
        cells.retain(|f| f.kind != FindingKind::HeaderGlued);
        findings.extend(cells);
        Recording {
            format: "serial log",
            tables: vec![table],
            findings,
            reasons: Vec::new(),
            metadata: Vec::new(),
            origin,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_glued_number_is_told_from_its_name_or_left_open() {
        let of = |text: &'static str, decimal| {
            let (name, number) = split(text.as_bytes(), decimal).unwrap();
            (std::str::from_utf8(name).unwrap(), number.map(|n| std::str::from_utf8(n).unwrap()))
        };
        assert_eq!(of("flex0.00", Decimal::Point), ("flex", Some("0.00")));
        assert_eq!(of("flex-12.5", Decimal::Point), ("flex", Some("-12.5")));
        assert_eq!(of("p0,1", Decimal::Comma), ("p", Some("0,1")));
        assert_eq!(of("p (kPa)12.5", Decimal::Point), ("p (kPa)", Some("12.5")));
        assert_eq!(of("p20.00", Decimal::Point), ("p", None));
        assert_eq!(of("p7", Decimal::Point), ("p", Some("7")));
    }
}
