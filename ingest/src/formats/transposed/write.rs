//! Writing what [`read`](super::read) reads.

use std::fmt::Write as _;

use crate::recording::{Cells, Column};

/// Columns as one line each, parted by `;`, the unit in brackets behind the name.
///
/// ```
/// use pneuval_ingest::formats::transposed::write;
/// use pneuval_ingest::recording::{Cells, Column};
/// let p = Column::new("p", Some("kPa"), Cells::Numbers(vec![0.0, 1.5, f64::NAN]));
/// assert_eq!(write(&[p]), "p (kPa);0.0;1.5;NaN\n");
/// ```
pub fn write(columns: &[Column]) -> String {
    let mut out = String::new();
    for column in columns {
        out.push_str(&column.name);
        if let Some(unit) = &column.unit {
            // Writing to a string does not fail.
            let _ = write!(out, " ({unit})");
        }
        match &column.cells {
            Cells::Numbers(numbers) => numbers.iter().for_each(|number| {
                let _ = write!(out, ";{number:?}");
            }),
            Cells::Text(words) => words.iter().for_each(|word| {
                let _ = write!(out, ";{word}");
            }),
            Cells::NotKept => {}
        }
        out.push('\n');
    }
    out
}
