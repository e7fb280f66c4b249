//! What a cell of a log is: a number, nothing, a word for no value, or text.

use super::numbers::{self, Decimal};
use super::text::Cell;

/// What the cells of a line are. Only columns of numbers count where columns are known.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Facts {
    pub numbers: usize,
    pub texts: usize,
    /// Tokens that say that there is no value.
    pub holes: usize,
    pub first_is_number: bool,
    /// Text that holds a character by which columns are usually parted.
    pub odd: usize,
}

/// What a cell is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Kind {
    Number(f64),
    Empty,
    /// The instrument says that it has no value.
    Hole,
    Text,
}

/// Words by which instruments and programs say that there is no value.
const NO_VALUE: [&str; 22] = [
    "nan",
    "-nan",
    "+nan",
    "nan(ind)",
    "-nan(ind)",
    "inf",
    "+inf",
    "-inf",
    "infinity",
    "-infinity",
    "-",
    "--",
    "---",
    "n/a",
    "na",
    "#n/a",
    "null",
    "none",
    "1.#qnan",
    "1.#inf",
    "-1.#inf",
    "-1.#ind",
];

/// Words by which instruments and programs say that a value is wrong. They are text in a column of numbers, and told as such; in a
/// first sample they must not be taken for the names of the columns.
pub(super) const WRONG_VALUE: [&str; 14] = [
    "err", "error", "ol", "o.l", "ovl", "ovld", "overload", "overflow", "fault", "invalid", "#value!", "#div/0!",
    "#num!", "#ref!",
];

pub(crate) fn kind(cell: &[u8], decimal: Decimal) -> Kind {
    match numbers::parse(cell, decimal) {
        Some(number) if number.is_finite() => Kind::Number(number),
        None if cell.is_empty() => Kind::Empty,
        None if NO_VALUE.iter().any(|word| cell.eq_ignore_ascii_case(word.as_bytes())) => Kind::Hole,
        // Also a number too large for an f64.
        _ => Kind::Text,
    }
}

pub(super) fn facts(bytes: &[u8], cells: &[Cell], decimal: Decimal, is_text: &[bool]) -> Facts {
    let mut facts = Facts::default();
    let mut first = true;
    for (column, cell) in cells.iter().enumerate() {
        if is_text.get(column) == Some(&true) {
            continue;
        }
        let kind = kind(cell.of(bytes), decimal);
        match kind {
            Kind::Number(_) => facts.numbers += 1,
            Kind::Empty => continue,
            Kind::Hole => facts.holes += 1,
            Kind::Text => {
                facts.texts += 1;
                facts.odd += usize::from(cell.of(bytes).iter().any(|b| matches!(b, b'\t' | b';' | b'|')));
            }
        }
        facts.first_is_number |= first && matches!(kind, Kind::Number(_));
        first = false;
    }
    facts
}

/// Cells without the empty ones at the end, which a delimiter before the line end makes.
pub(super) fn filled(cells: &[Cell]) -> usize {
    cells.iter().rposition(|c| c.end > c.start || c.quoted).map_or(0, |last| last + 1)
}
