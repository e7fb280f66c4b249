//! A table while it is read row by row: what is put where, what is odd about it, and how large it may grow.

use super::csv::{self, CellKind, Decimal, cell_kind};
use super::lines::{Line, trim};
use crate::IngestError;
use crate::error::Place;
use crate::finding::places::{ByKind, as_text, cell_finding, cut_line, line_finding, no_line_end, told};
use crate::finding::{Finding, FindingKind, LineMap, Severity};
use crate::limits::{LOG_CELLS_MAX, LOG_COLUMNS_MAX};
use crate::recording::{Builder, Cells, ClockUnit, Column, Keep, Table};

/// A table that grows.
pub(crate) struct Sheet<'a> {
    file: &'a str,
    name: String,
    keep: Keep<'a>,
    columns: Vec<Making>,
    lines: LineMap,
}

struct Making {
    name: String,
    unit: Option<String>,
    numbers: Builder,
    /// The words of a column of text, and whether they are kept.
    text: Option<(Vec<String>, bool)>,
    /// What a row holds where nothing is put.
    fill: f64,
    /// What the row that is being filled holds.
    number: f64,
    word: String,
    is_put: bool,
    /// Whether a row without it is told.
    is_expected: bool,
    odd: ByKind,
}

/// Lines that are odd, while a text is read.
#[derive(Default)]
pub(crate) struct OddLines {
    kinds: ByKind,
    told: Vec<Finding>,
}

impl OddLines {
    /// A line, quoted as it stands; `row` is the sample on it or the next one.
    pub fn add(&mut self, kind: FindingKind, row: usize, line: Line) {
        self.kinds.entry(kind).or_default().add(row, line.number, trim(line.bytes));
    }

    /// A finding that has its sentence already.
    pub fn tell(&mut self, finding: Finding) {
        self.told.push(finding);
    }

    /// Checks that a line holds as many cells as usual, and tells where not: of too many cells nobody knows which is the one too many,
    /// and where the file ends within the line, the last cell may be cut. Whether anything is left.
    pub fn fit(&mut self, file: &str, cells: &mut Vec<&[u8]>, usual: usize, row: usize, line: Line) -> bool {
        let (held, number) = (cells.len(), line.number);
        if line.is_ended && held != usual {
            self.kinds.entry(FindingKind::RaggedLine).or_default().add_said(row, number, || format!("{held} cells"));
            if held > usual {
                cells.clear();
            }
        } else if !line.is_ended && held < usual {
            let is_cut = !matches!(line.bytes.last(), Some(b',' | b';' | b'\t' | b'|'));
            if is_cut {
                cells.pop();
            }
            let text = cut_line(number, held, usual, is_cut);
            self.told.push(told(FindingKind::Truncated, Severity::Lost, file, row, number, text));
            return !cells.is_empty();
        } else if !line.is_ended {
            self.told.push(told(FindingKind::NoLineEnd, Severity::Note, file, row, number, no_line_end(number)));
        }
        true
    }

    /// All of them as findings.
    pub fn finish(self, file: &str, usual: usize) -> Vec<Finding> {
        let kinds = self.kinds.into_iter().map(|(kind, places)| line_finding(kind, places, file, usual));
        self.told.into_iter().chain(kinds).collect()
    }
}

impl<'a> Sheet<'a> {
    /// An empty table of a file.
    pub fn new(file: &'a str, name: &str, keep: Keep<'a>) -> Self {
        Self { file, name: name.to_owned(), keep, columns: Vec::new(), lines: LineMap::default() }
    }

    /// Adds a column of numbers; rows before it are holes. Where it is `expected`, a row that holds nothing for it is told.
    pub fn numbers(&mut self, name: &str, unit: Option<&str>, is_expected: bool) -> Result<usize, IngestError> {
        self.column((name, unit), unit == Some("s"), is_expected, Some(f64::NAN))
    }

    /// Adds a column of stamps, whose unit may be said later: they are kept with whatever they are the clock of.
    pub fn stamps(&mut self, name: &str, unit: Option<&str>) -> Result<usize, IngestError> {
        self.column((name, unit), true, true, Some(f64::NAN))
    }

    /// Says that the numbers of a column are seconds since the recording's origin.
    pub fn date(&mut self, column: usize) {
        if let Some(making) = self.columns.get_mut(column) {
            making.numbers.date();
        }
    }

    /// Adds a column of text that holds stamps: it is kept with whatever it is the clock of.
    pub fn written_stamps(&mut self, name: &str) -> Result<usize, IngestError> {
        self.column((name, None), true, false, None)
    }

    /// Adds a column of marks: rows without one, those before it too, hold 0.
    pub fn marks(&mut self, name: &str) -> Result<usize, IngestError> {
        self.column((name, None), false, false, Some(0.0))
    }

    /// Adds a column of text.
    pub fn text(&mut self, name: &str) -> Result<usize, IngestError> {
        self.column((name, None), false, false, None)
    }

    fn column(
        &mut self,
        (name, unit): (&str, Option<&str>),
        is_stamp: bool,
        is_expected: bool,
        fill: Option<f64>,
    ) -> Result<usize, IngestError> {
        let number = self.columns.len() + 1;
        if number > LOG_COLUMNS_MAX {
            return Err(self.too_many("columns", LOG_COLUMNS_MAX, number));
        }
        let mut unique = name.to_owned();
        let mut copy = 1;
        while self.columns.iter().any(|c| c.name == unique) {
            copy += 1;
            unique = format!("{name} ({copy})");
        }
        let keep = self.keep.keeps(&self.name, &unique, number) || (is_stamp && self.keep.wants(&self.name));
        // What is kept can be looked at later.
        let seems = || fill.filter(|fill| fill.is_nan() && !keep).and_then(|_| csv::clock_unit(name, unit));
        let clock = if unit == Some("s") { Some(ClockUnit::Seconds(1.0)) } else { seems() };
        let mut numbers = clock.map_or_else(|| Builder::new(keep), |unit| Builder::clock(keep, unit));
        let mut text = fill.is_none().then(|| (Vec::new(), keep));
        let fill = fill.unwrap_or(f64::NAN);
        for _ in 0..self.lines.rows() {
            match &mut text {
                None => numbers.push(fill),
                Some((words, true)) => words.push(String::new()),
                Some((_, false)) => {}
            }
        }
        self.columns.push(Making {
            name: unique,
            unit: unit.map(str::to_owned),
            numbers,
            text,
            number: fill,
            fill,
            word: String::new(),
            is_put: false,
            is_expected,
            odd: ByKind::new(),
        });
        Ok(number - 1)
    }

    /// Rows so far.
    pub fn rows(&self) -> usize {
        self.lines.rows()
    }

    /// Which line each row stands on.
    pub fn lines(&self) -> &LineMap {
        &self.lines
    }

    /// Gives a column its unit.
    pub fn set_unit(&mut self, column: usize, unit: &str) {
        if let Some(column) = self.columns.get_mut(column) {
            column.unit = Some(unit.to_owned());
        }
    }

    /// Gives a column its unit unless it has one.
    pub fn set_unit_if_none(&mut self, column: usize, unit: Option<&str>) {
        if let (Some(column), Some(unit)) = (self.columns.get_mut(column), unit)
            && column.unit.is_none()
        {
            column.unit = Some(unit.to_owned());
        }
    }

    /// The number of a column in the row that is being filled.
    pub fn get(&self, column: usize) -> f64 {
        self.columns.get(column).map_or(f64::NAN, |c| c.number)
    }

    /// A number of the row that is being filled.
    pub fn put(&mut self, column: usize, value: f64) {
        if let Some(column) = self.columns.get_mut(column) {
            column.number = value;
            column.is_put = true;
        }
    }

    /// A cell of the row that is being filled: a number, a word of a column of text, or a hole that is told.
    pub fn cell(&mut self, column: usize, cell: &[u8], decimal: Decimal, line: usize) {
        let row = self.lines.rows();
        let Some(column) = self.columns.get_mut(column) else { return };
        column.is_put = true;
        if let Some((_, keep)) = &column.text {
            if *keep {
                column.word = as_text(cell);
            }
            return;
        }
        let kind = match cell_kind(cell, decimal) {
            CellKind::Number(number) => {
                column.number = number;
                return;
            }
            CellKind::Empty => FindingKind::EmptyCell,
            CellKind::Hole => FindingKind::NoValue,
            CellKind::Text => FindingKind::NonNumericCell,
        };
        column.odd.entry(kind).or_default().add(row, line, cell);
    }

    /// A hole of the row that is being filled, told with what stands there.
    pub fn hole(&mut self, column: usize, kind: FindingKind, line: usize, quote: &[u8]) {
        let row = self.lines.rows();
        if let Some(column) = self.columns.get_mut(column) {
            column.number = f64::NAN;
            column.is_put = true;
            column.odd.entry(kind).or_default().add(row, line, quote);
        }
    }

    /// Ends the row, which stands on a line. What was not put is a hole; it is told where `is_told`, if it was expected.
    pub fn end_row(&mut self, line: usize, is_told: bool) -> Result<(), IngestError> {
        let row = self.lines.rows();
        let cells = row.saturating_mul(self.columns.len());
        if cells >= LOG_CELLS_MAX {
            return Err(self.too_many("cells, rows times columns", LOG_CELLS_MAX, cells));
        }
        for column in &mut self.columns {
            if !column.is_put && column.is_expected && is_told {
                column.odd.entry(FindingKind::EmptyCell).or_default().add(row, line, &[]);
            }
            match &mut column.text {
                None => column.numbers.push(column.number),
                Some((words, true)) => words.push(std::mem::take(&mut column.word)),
                Some((_, false)) => {}
            }
            column.number = column.fill;
            column.is_put = false;
        }
        self.lines.push(line);
        Ok(())
    }

    fn too_many(&self, what: &str, limit: usize, found: usize) -> IngestError {
        IngestError::Unusable {
            place: Place::new(self.file, None, None),
            expected: format!("at most {limit} {what}"),
            found: found.to_string(),
            next: "is this a log of channels? Split it".to_owned(),
        }
    }

    /// The table and what is odd about its cells, column by column.
    pub fn finish(self) -> (Table, Vec<Finding>) {
        let mut findings = Vec::new();
        let mut columns = Vec::with_capacity(self.columns.len());
        let rows = self.lines.rows();
        for making in self.columns {
            let channel = crate::recording::full_name(&self.name, &making.name);
            for (kind, places) in making.odd {
                findings.push(cell_finding(kind, places, self.file, &channel));
            }
            columns.push(match making.text {
                None => making.numbers.finish(making.name, making.unit),
                Some((words, keep)) => {
                    let cells = if keep { Cells::Text(words) } else { Cells::NotKept };
                    Column::new(&making.name, making.unit.as_deref(), cells)
                }
            });
        }
        let table = Table {
            name: self.name,
            schema: None,
            columns,
            rows,
            lines: self.lines,
            clock: None,
            decimal: Decimal::Point,
        };
        (table, findings)
    }
}
