//! Writing what [`read`](super::read) reads: for rehearsals and for export.
//!
//! Numbers have the shortest digits that read back as them, unless fewer are asked for.

use std::io::Write;

use super::start::Start;
use crate::IngestError;
use crate::error::{Place, shown};
use crate::formats::csv::Decimal;
use crate::formats::stamps::rfc3339_second;
use crate::recording::{Cells, Column, Table};

pub use super::layout::XColumns;

/// How a measurement file is written.
#[derive(Debug, Clone, PartialEq)]
pub struct WriteOptions {
    /// Between cells: an ASCII character that is part of no number.
    pub separator: u8,
    /// The decimal sign; not the separator.
    pub decimal: Decimal,
    /// Which columns of X there are.
    pub x_columns: XColumns,
    /// Whether each segment has a header (`Multi_Headings`); without, all rows follow one header.
    pub has_headers: bool,
    /// Rows of a segment; all of them where absent. Without headers it is what `Samples` states, as LabVIEW states its first packet.
    pub segment_rows: Option<usize>,
    /// The whole second that X counts from, `2026-11-22T09:13:00`; no date and time are written where absent.
    pub origin: Option<String>,
    /// Who measured.
    pub operator: String,
    /// Decimals of numbers; as many as give the same number back where absent.
    pub digits: Option<usize>,
}

impl Default for WriteOptions {
    fn default() -> Self {
        Self {
            separator: b'\t',
            decimal: Decimal::Point,
            x_columns: XColumns::One,
            has_headers: true,
            segment_rows: None,
            origin: None,
            operator: "pneuval".to_owned(),
            digits: None,
        }
    }
}

/// Part of a step by which the stamps of a clock may leave an even one, where X is not written.
const UNEVEN_PART: f64 = 1e-6;

/// Writes tables as one file, lines ended by CR LF. A table's clock is its X, all its other columns of numbers are channels, and a column
/// of text `Comment` of the first table stands behind them. Holes are `NaN`; a table that is shorter than others is empty at its end.
///
/// With headers, a segment states its own start: the origin plus whole seconds, so that X begins near 0 again and no digit is lost.
///
/// ```
/// use pneuval_ingest::finding::LineMap;
/// use pneuval_ingest::formats::{csv::Decimal, lvm};
/// use pneuval_ingest::{raw::RawFile, recording::{Cells, Column, Keep, Table}};
/// let columns = vec![
///     Column::new("X_Value", Some("s"), Cells::Numbers(vec![0.0, 0.1])),
///     Column::new("p", Some("kPa"), Cells::Numbers(vec![1.5, f64::NAN])),
/// ];
/// let (lines, decimal) = (LineMap::default(), Decimal::Point);
/// let table = Table { name: String::new(), schema: None, columns, rows: 2, lines, clock: Some(0), decimal };
/// let mut bytes = Vec::new();
/// lvm::write(&mut bytes, &[table], &lvm::WriteOptions::default())?;
/// let read = lvm::read(&RawFile::of_bytes("run.lvm", &bytes), Keep::All)?;
/// assert_eq!(read.tables[0].columns[1].cells.numbers().map(|p| p[0]), Some(1.5));
/// # Ok::<(), pneuval_ingest::IngestError>(())
/// ```
///
/// # Errors
/// [`IngestError::Malformed`] for what the layout cannot say: an uneven clock without a column of X, more than one clock under one, no
/// channel, names or words that hold the separator, infinite numbers. [`IngestError::Write`] if it cannot be written.
pub fn write(out: &mut impl Write, tables: &[Table], options: &WriteOptions) -> Result<(), IngestError> {
    let sheet = Sheet::new(tables, options)?;
    sheet.write(out).map_err(|source| IngestError::write("the measurement file".as_ref(), source))
}

fn wrong(table: &str, expected: &str, found: String) -> IngestError {
    IngestError::Malformed {
        place: Place::new(if table.is_empty() { "the table" } else { table }, None, None),
        expected: expected.to_owned(),
        found,
        next: "write it with other options, or correct the table that is to be written".to_owned(),
    }
}

/// A channel, and the clock it belongs to.
struct Channel<'t> {
    name: &'t str,
    unit: &'t str,
    x: &'t [f64],
    y: &'t [f64],
    /// First stamp and step, of an even clock.
    even: (f64, f64),
}

/// Channels side by side.
struct Sheet<'t> {
    channels: Vec<Channel<'t>>,
    comments: &'t [String],
    rows: usize,
    origin: Option<Start>,
    options: &'t WriteOptions,
}

impl<'t> Sheet<'t> {
    fn new(tables: &'t [Table], options: &'t WriteOptions) -> Result<Self, IngestError> {
        let separator = options.separator;
        let of_number =
            |b: u8| b.is_ascii_alphanumeric() || matches!(b, b'.' | b'+' | b'-' | b'_' | b'*' | b'"' | b' ');
        if !separator.is_ascii() || (separator != b'\t' && separator.is_ascii_control()) || of_number(separator) {
            let expected = "a separator that numbers, names and lines do not hold";
            return Err(wrong("", expected, shown(&char::from(separator).to_string())));
        }
        if separator == options.decimal.byte() {
            return Err(wrong("", "a separator that is not the decimal sign", "the comma for both".to_owned()));
        }
        if options.x_columns != XColumns::Multi && tables.len() != 1 {
            let expected = format!("one table where X_Columns is {}", options.x_columns.word());
            return Err(wrong("", &expected, format!("{} tables", tables.len())));
        }
        if options.segment_rows == Some(0) {
            return Err(wrong("", "segments of at least one row", "0 rows".to_owned()));
        }
        let origin = options.origin.as_deref().map(|text| {
            let start = text.split_once('T').and_then(|(date, time)| Start::of(date, time));
            start
                .filter(|start| start.fraction == 0.0 && !start.is_open)
                .ok_or_else(|| wrong("", "an origin to the second, as `2026-11-22T09:13:00`", shown(text)))
        });
        let mut sheet = Self { channels: Vec::new(), comments: &[], rows: 0, origin: origin.transpose()?, options };
        sheet.word("", &options.operator, "an operator")?;
        for (index, table) in tables.iter().enumerate() {
            sheet.add(table, index == 0)?;
        }
        if sheet.channels.is_empty() {
            return Err(wrong("", "a channel", "none".to_owned()));
        }
        Ok(sheet)
    }

    /// Whether a word can stand in a cell and be read back.
    fn word(&self, table: &str, text: &str, what: &str) -> Result<(), IngestError> {
        let separator = char::from(self.options.separator);
        let is_quoted = text.starts_with('"') && text.ends_with('"');
        let trimmed = text.trim_matches([' ', '\t']);
        if trimmed != text || is_quoted || text.contains([separator, '\n', '\r', '\0']) {
            let expected = format!("{what} without separators, line ends, and blanks or quotes around it");
            return Err(wrong(table, &expected, shown(text)));
        }
        Ok(())
    }

    fn add(&mut self, table: &'t Table, is_first: bool) -> Result<(), IngestError> {
        let clock = table.clock.and_then(|clock| table.columns.get(clock)).or_else(|| table.column("X_Value"));
        let numbers = |column: &'t Column| match &column.cells {
            Cells::Numbers(numbers) if numbers.len() != table.rows => {
                Err(wrong(&table.name, &format!("{} numbers in every column", table.rows), numbers.len().to_string()))
            }
            Cells::Numbers(numbers) if numbers.iter().any(|number| number.is_infinite()) => Err(wrong(
                &table.name,
                "finite numbers and holes",
                format!("an infinite one in {}", shown(&column.name)),
            )),
            Cells::Numbers(numbers) => Ok(Some(&numbers[..])),
            Cells::Text(_) | Cells::NotKept => Ok(None),
        };
        let x = match clock {
            Some(clock) => numbers(clock)?,
            None => None,
        };
        let x = x.ok_or_else(|| wrong(&table.name, "a clock", "none that is kept".to_owned()))?;
        let even = (x.first().copied().unwrap_or(0.0), mean_step(x));
        if self.options.x_columns == XColumns::No {
            let off = |(i, stamp): (usize, &f64)| {
                let leaves = (stamp - (even.0 + i as f64 * even.1)).abs();
                // NaN, a stamp that is missing, is uneven too.
                leaves.is_nan() || leaves > UNEVEN_PART * even.1.abs()
            };
            if let Some((row, _)) = x.iter().enumerate().find(|row| off(*row)) {
                let expected = "an even clock where X_Columns is No";
                return Err(wrong(&table.name, expected, format!("an uneven one, first in row {row}")));
            }
        }
        self.rows = self.rows.max(table.rows);
        for column in &table.columns {
            if clock.is_some_and(|clock| std::ptr::eq(clock, column)) {
                continue;
            }
            if let Some(y) = numbers(column)? {
                self.word(&table.name, &column.name, "a name")?;
                if ["", "x_value", "comment"].contains(&column.name.to_lowercase().as_str()) {
                    return Err(wrong(&table.name, "a name of its own for every channel", shown(&column.name)));
                }
                let unit = column.unit.as_deref().unwrap_or_default();
                self.word(&table.name, unit, "a unit")?;
                self.channels.push(Channel { name: &column.name, unit, x, y, even });
            } else if let Some(words) = column.cells.text().filter(|_| column.name == super::COMMENT && is_first) {
                for text in words {
                    self.word(&table.name, text, "a comment")?;
                }
                self.comments = words;
            } else {
                let expected = "columns of numbers, and one of text `Comment` in the first table";
                return Err(wrong(&table.name, expected, shown(&column.name)));
            }
        }
        Ok(())
    }

    fn write(&self, out: &mut impl Write) -> std::io::Result<()> {
        let WriteOptions { x_columns, has_headers, segment_rows, .. } = *self.options;
        self.head(out)?;
        let rows = segment_rows.filter(|_| has_headers).unwrap_or(self.rows).max(1);
        let mut start = 0_i64;
        for first in (0..self.rows.max(1)).step_by(rows) {
            let last = (first + rows).min(self.rows);
            if self.origin.is_some() && first > 0 {
                let stamps = self.channels.iter().filter_map(|channel| channel.x.get(first));
                let earliest = stamps.copied().filter(|stamp| stamp.is_finite()).fold(f64::INFINITY, f64::min);
                // Seconds of a run are far fewer than an i64 holds; beyond, the conversion ends at its ends.
                #[expect(clippy::cast_possible_truncation)]
                let second = earliest.floor() as i64;
                if earliest.is_finite() && second.abs() < 1 << 40 {
                    start = start.max(second);
                }
            }
            let samples = |channel: &Channel| {
                let stated = if has_headers { last } else { segment_rows.unwrap_or(last).min(last) };
                channel.y.len().min(stated).saturating_sub(first)
            };
            self.segment_head(out, first, start, samples)?;
            for row in first..last {
                self.row(out, row, start, x_columns)?;
            }
            if last < self.rows {
                self.line(out, &[String::new(), String::new()])?;
            }
        }
        Ok(())
    }

    fn line(&self, out: &mut impl Write, cells: &[String]) -> std::io::Result<()> {
        for (i, cell) in cells.iter().enumerate() {
            if i > 0 {
                out.write_all(&[self.options.separator])?;
            }
            out.write_all(cell.as_bytes())?;
        }
        out.write_all(b"\r\n")
    }

    fn head(&self, out: &mut impl Write) -> std::io::Result<()> {
        let options = self.options;
        let separator = match options.separator {
            b'\t' => "Tab".to_owned(),
            b',' => "Comma".to_owned(),
            byte => char::from(byte).to_string(),
        };
        let decimal = char::from(options.decimal.byte()).to_string();
        let mut lines = vec![
            ("LabVIEW Measurement", String::new()),
            ("Writer_Version", "2".to_owned()),
            ("Reader_Version", "2".to_owned()),
            ("Separator", separator),
            ("Decimal_Separator", decimal),
            ("Multi_Headings", if options.has_headers { "Yes" } else { "No" }.to_owned()),
            ("X_Columns", options.x_columns.word().to_owned()),
            ("Time_Pref", "Relative".to_owned()),
            ("Operator", options.operator.clone()),
        ];
        if let Some((date, time)) = self.start(0) {
            lines.extend([("Date", date), ("Time", time)]);
        }
        lines.extend([("***End_of_Header***", String::new()), ("", String::new())]);
        for (key, value) in lines {
            self.line(out, &[key.to_owned(), value])?;
        }
        Ok(())
    }

    /// Date and time so many seconds after the origin.
    fn start(&self, seconds: i64) -> Option<(String, String)> {
        let text = rfc3339_second(self.origin?.second + seconds, false);
        let (date, time) = text.split_once('T')?;
        let decimal = char::from(self.options.decimal.byte());
        Some((date.replace('-', "/"), format!("{time}{decimal}0000000")))
    }

    /// One value for each channel, above its numbers, and the cell of the comments.
    fn per_channel(&self, key: &str, value: impl Fn(&Channel) -> String, x: &str) -> Vec<String> {
        let mut cells = vec![key.to_owned()];
        for (index, channel) in self.channels.iter().enumerate() {
            if index > 0 && self.options.x_columns == XColumns::Multi {
                cells.push(x.to_owned());
            }
            cells.push(value(channel));
        }
        cells.push(String::new());
        cells
    }

    fn segment_head(
        &self,
        out: &mut impl Write,
        first: usize,
        start: i64,
        samples: impl Fn(&Channel) -> usize,
    ) -> std::io::Result<()> {
        let mut channels = self.per_channel("Channels", |_| String::new(), "");
        if let Some(count) = channels.get_mut(1) {
            *count = self.channels.len().to_string();
        }
        self.line(out, &channels)?;
        self.line(out, &self.per_channel("Samples", |channel| samples(channel).to_string(), ""))?;
        if let Some((date, time)) = self.start(start) {
            self.line(out, &self.per_channel("Date", |_| date.clone(), ""))?;
            self.line(out, &self.per_channel("Time", |_| time.clone(), ""))?;
        }
        self.line(out, &self.per_channel("Y_Unit_Label", |channel| channel.unit.to_owned(), ""))?;
        self.line(out, &self.per_channel("X_Dimension", |_| "Time".to_owned(), ""))?;
        let x0 = |channel: &Channel| {
            let given = channel.x.get(first).copied().filter(|x| x.is_finite()).unwrap_or(0.0);
            let even = channel.even.0 + first as f64 * channel.even.1;
            let x = if self.options.x_columns == XColumns::No { even } else { given };
            self.number(x - start as f64, None)
        };
        self.line(out, &self.per_channel("X0", x0, ""))?;
        self.line(out, &self.per_channel("Delta_X", |channel| self.number(channel.even.1, None), ""))?;
        self.line(out, &self.per_channel("***End_of_Header***", |_| String::new(), ""))?;
        let mut names = self.per_channel("X_Value", |channel| channel.name.to_owned(), "X_Value");
        if let Some(last) = names.last_mut() {
            super::COMMENT.clone_into(last);
        }
        self.line(out, &names)
    }

    fn row(&self, out: &mut impl Write, row: usize, start: i64, x_columns: XColumns) -> std::io::Result<()> {
        let digits = self.options.digits;
        let x = |channel: &Channel| channel.x.get(row).map_or(String::new(), |x| self.number(x - start as f64, digits));
        let mut cells = Vec::with_capacity(2 * self.channels.len() + 1);
        for (index, channel) in self.channels.iter().enumerate() {
            match x_columns {
                XColumns::No if index == 0 => cells.push(String::new()),
                XColumns::One if index == 0 => cells.push(x(channel)),
                XColumns::Multi => cells.push(x(channel)),
                XColumns::No | XColumns::One => {}
            }
            cells.push(channel.y.get(row).map_or(String::new(), |y| self.number(*y, digits)));
        }
        cells.extend(self.comments.get(row).filter(|comment| !comment.is_empty()).cloned());
        self.line(out, &cells)
    }

    fn number(&self, value: f64, digits: Option<usize>) -> String {
        if value.is_nan() {
            return "NaN".to_owned();
        }
        // Debug, unlike Display, writes very large and very small numbers with an exponent.
        let text = digits.map_or_else(|| format!("{value:?}"), |digits| format!("{value:.digits$}"));
        if self.options.decimal == Decimal::Comma { text.replace('.', ",") } else { text }
    }
}

/// The mean step of stamps, or 1 where there is none.
fn mean_step(x: &[f64]) -> f64 {
    let first = x.iter().position(|stamp| stamp.is_finite());
    let last = x.iter().rposition(|stamp| stamp.is_finite());
    let step = first.zip(last).filter(|(first, last)| first < last).map(|(first, last)| {
        let ends = x.get(last).zip(x.get(first)).map_or(0.0, |(last, first)| last - first);
        ends / (last - first) as f64
    });
    step.filter(|step| step.is_finite() && *step != 0.0).unwrap_or(1.0)
}
