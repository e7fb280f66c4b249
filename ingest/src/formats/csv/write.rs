//! Writing what [`read`](super::read) reads, every number with the shortest digits that read back as it.

use std::fmt::Write as _;

use super::numbers::Decimal;
use crate::recording::{Cells, Column};
use crate::units::Unit;

/// How a log is written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct WriteOptions {
    /// Between cells.
    pub delimiter: u8,
    /// The decimal sign; not the delimiter.
    pub decimal: Decimal,
    /// Whether a row of names comes first.
    pub names: bool,
    /// Whether a row of units follows it.
    pub units: bool,
    /// Whether a hole is an empty cell instead of `NaN`.
    pub empty_holes: bool,
}

/// Columns as text, lines ended by LF. Holes are written as `NaN` unless they are to be empty; shorter columns are filled up with them,
/// or with nothing.
///
/// ```
/// use pneuval_ingest::formats::csv::{Decimal, WriteOptions, write};
/// use pneuval_ingest::recording::{Cells, Column};
/// let cells = Cells::Numbers(vec![1.5, f64::NAN]);
/// let column = Column::new("p", Some("kPa"), cells);
/// let options = WriteOptions { delimiter: b';', decimal: Decimal::Comma, names: true, units: true, empty_holes: false };
/// assert_eq!(write(&[column], options), "p\nkPa\n1,5\nNaN\n");
/// ```
pub fn write(columns: &[Column], options: WriteOptions) -> String {
    let mut text = String::new();
    let heads: Vec<(&str, Option<&str>)> = columns.iter().map(|c| (c.name.as_str(), c.unit.as_deref())).collect();
    let cells: Vec<&Cells> = columns.iter().map(|c| &c.cells).collect();
    lines(&heads, &cells, options, |line| {
        text.push_str(line);
        Ok::<(), std::convert::Infallible>(())
    })
    .unwrap_or_else(|never| match never {});
    text
}

/// The same, line by line: names with units, and their cells.
///
/// # Errors
/// What `put` says of a line.
pub fn lines<E>(
    heads: &[(&str, Option<&str>)],
    columns: &[&Cells],
    options: WriteOptions,
    mut put: impl FnMut(&str) -> Result<(), E>,
) -> Result<(), E> {
    let mut line = Line { text: String::new(), delimiter: char::from(options.delimiter) };
    if options.names {
        for (name, _) in heads {
            line.cell(|text| quoted(text, name, options));
        }
        line.end(&mut put)?;
    }
    if options.units {
        for (_, unit) in heads {
            line.cell(|text| quoted(text, unit.unwrap_or_default(), options));
        }
        line.end(&mut put)?;
    }
    let rows = columns.iter().map(|cells| cells.len()).max().unwrap_or(0);
    for row in 0..rows {
        for cells in columns {
            line.cell(|text| match cells {
                Cells::Numbers(numbers) => {
                    let value = numbers.get(row).copied().unwrap_or(f64::NAN);
                    // A line of nothing would be no row.
                    if !(value.is_nan() && options.empty_holes && columns.len() > 1) {
                        number(text, value, options.decimal);
                    }
                }
                Cells::Text(words) => quoted(text, words.get(row).map_or("", String::as_str), options),
                Cells::NotKept => quoted(text, "", options),
            });
        }
        line.end(&mut put)?;
    }
    Ok(())
}

/// A line that is being made.
struct Line {
    text: String,
    delimiter: char,
}

impl Line {
    fn cell(&mut self, write: impl FnOnce(&mut String)) {
        write(&mut self.text);
        self.text.push(self.delimiter);
    }

    fn end<E>(&mut self, put: &mut impl FnMut(&str) -> Result<(), E>) -> Result<(), E> {
        // The mark behind the last cell.
        self.text.pop();
        self.text.push('\n');
        let done = put(&self.text);
        self.text.clear();
        done
    }
}

fn number(out: &mut String, value: f64, decimal: Decimal) {
    let from = out.len();
    // Debug, unlike Display, writes very large and very small numbers with an exponent. Writing to a String cannot fail.
    let _ = write!(out, "{value:?}");
    if decimal == Decimal::Comma
        && let Some(at) = out[from..].find('.')
    {
        out.replace_range(from + at..=from + at, ",");
    }
}

/// Quoted where the reader would otherwise take it apart, or for something else.
fn quoted(out: &mut String, text: &str, options: WriteOptions) {
    let delimiter = char::from(options.delimiter);
    let special = |c: char| c == delimiter || matches!(c, '"' | '\n' | '\r' | '\t' | '\0');
    // A lone unit `%` needs none: a mark before a delimiter is a cell.
    let mark = text.starts_with(['#', '%', '/']) && Unit::parse(text).is_none_or(|_| options.delimiter == b' ');
    let plain = !text.is_empty() && !text.contains(special) && text.trim() == text && !mark;
    if plain {
        out.push_str(text);
    } else {
        out.extend(["\"", &text.replace('"', "\"\""), "\""]);
    }
}
