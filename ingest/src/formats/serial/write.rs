//! Writing what [`read`](super::read) reads.

use std::fmt::Write as _;

use crate::recording::{Cells, Column};

/// How a serial log is written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct WriteOptions {
    /// Between key and value: `=` or `:`.
    pub sign: char,
    /// Between pairs.
    pub separator: &'static str,
    /// Whether units are glued to the numbers.
    pub units: bool,
}

/// Columns as lines of keys and values; a hole is a key that is missing.
///
/// ```
/// use pneuval_ingest::formats::serial::{WriteOptions, write};
/// use pneuval_ingest::recording::{Cells, Column};
/// let t = Column::new("t", Some("ms"), Cells::Numbers(vec![0.0, 10.0]));
/// let p = Column::new("p", Some("kPa"), Cells::Numbers(vec![1.5, f64::NAN]));
/// let options = WriteOptions { sign: '=', separator: " ", units: true };
/// assert_eq!(write(&[t, p], options), "t=0ms p=1.5kPa\nt=10ms\n");
/// ```
pub fn write(columns: &[Column], options: WriteOptions) -> String {
    let rows = columns.iter().map(|c| c.cells.len()).max().unwrap_or(0);
    let mut out = String::new();
    for row in 0..rows {
        let mut separator = "";
        for column in columns {
            let value = match &column.cells {
                Cells::Numbers(numbers) => numbers.get(row).filter(|n| n.is_finite()).map(ToString::to_string),
                Cells::Text(words) => words.get(row).filter(|word| !word.is_empty()).cloned(),
                Cells::NotKept => None,
            };
            let Some(value) = value else { continue };
            let unit = column.unit.as_deref().filter(|_| options.units).unwrap_or_default();
            // Writing to a string does not fail.
            let _ = write!(out, "{separator}{}{}{value}{unit}", column.name, options.sign);
            separator = options.separator;
        }
        out.push('\n');
    }
    out
}
