//! Writing what [`read`](super::read) reads, every number with the shortest digits that read back as it.

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
}

/// Columns as text, lines ended by LF. Holes are written as `NaN`; shorter columns are filled up with them, or with nothing.
///
/// ```
/// use pneuval_ingest::formats::csv::{Decimal, WriteOptions, write};
/// use pneuval_ingest::recording::{Cells, Column};
/// let cells = Cells::Numbers(vec![1.5, f64::NAN]);
/// let column = Column::new("p", Some("kPa"), cells);
/// let options = WriteOptions { delimiter: b';', decimal: Decimal::Comma, names: true, units: true };
/// assert_eq!(write(&[column], options), "p\nkPa\n1,5\nNaN\n");
/// ```
pub fn write(columns: &[Column], options: WriteOptions) -> String {
    let mut out = String::new();
    if options.names {
        line(&mut out, options, columns.iter().map(|c| quoted(&c.name, options)));
    }
    if options.units {
        line(&mut out, options, columns.iter().map(|c| quoted(c.unit.as_deref().unwrap_or_default(), options)));
    }
    let rows = columns.iter().map(|c| c.cells.len()).max().unwrap_or(0);
    for row in 0..rows {
        let cell = |column: &Column| match &column.cells {
            Cells::Numbers(numbers) => number(numbers.get(row).copied().unwrap_or(f64::NAN), options.decimal),
            Cells::Text(text) => quoted(text.get(row).map_or("", String::as_str), options),
            Cells::NotKept => quoted("", options),
        };
        line(&mut out, options, columns.iter().map(cell));
    }
    out
}

fn line(out: &mut String, options: WriteOptions, cells: impl Iterator<Item = String>) {
    for (i, cell) in cells.enumerate() {
        if i > 0 {
            out.push(char::from(options.delimiter));
        }
        out.push_str(&cell);
    }
    out.push('\n');
}

fn number(value: f64, decimal: Decimal) -> String {
    // Debug, unlike Display, writes very large and very small numbers with an exponent.
    let text = format!("{value:?}");
    if decimal == Decimal::Comma { text.replace('.', ",") } else { text }
}

/// Quoted where the reader would otherwise take it apart, or for something else.
fn quoted(text: &str, options: WriteOptions) -> String {
    let delimiter = char::from(options.delimiter);
    let special = |c: char| c == delimiter || matches!(c, '"' | '\n' | '\r' | '\t' | '\0');
    // A lone unit `%` needs none: a mark before a delimiter is a cell.
    let mark = text.starts_with(['#', '%', '/']) && Unit::parse(text).is_none_or(|_| options.delimiter == b' ');
    let plain = !text.is_empty() && !text.contains(special) && text.trim() == text && !mark;
    if plain { text.to_owned() } else { format!("\"{}\"", text.replace('"', "\"\"")) }
}
