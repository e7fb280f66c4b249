//! A line of a gauge: values with their units, marks, and what else stands beside them.

use super::is_stamp;
use crate::formats::csv::{Decimal, parse_number};
use crate::formats::lines::{cells, trim};
use crate::units::Unit;

/// Units of force as gauges write them, case not counted, and of what they are taken for.
const FORCE_UNITS: [&str; 16] =
    ["n", "mn", "kn", "kgf", "gf", "lbf", "ozf", "klbf", "cn", "dan", "kg", "g", "lb", "oz", "lbs", "nm"];

/// Words of a gauge whose range is exceeded.
const OVERLOAD: [&str; 8] = ["ol", "o.l", "o.l.", "over", "ovl", "ovld", "overload", "of"];

#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Value<'b> {
    /// `None` where the gauge has none to show.
    pub number: Option<f64>,
    /// As written; empty where there is no number.
    pub unit: &'b [u8],
    pub text: &'b [u8],
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Item<'b> {
    Value(Value<'b>),
    /// A bare number or a stamp.
    Plain(&'b [u8]),
}

/// What an item is, whatever it holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Shape {
    Value,
    Number,
    Word,
}

/// A line of a gauge.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct Reading<'b> {
    pub items: Vec<Item<'b>>,
    pub is_peak: bool,
    /// Tension, or else compression, where a letter says it.
    pub is_tension: Option<bool>,
}

impl<'b> Reading<'b> {
    pub fn values(&self) -> impl Iterator<Item = &Value<'b>> {
        self.items.iter().filter_map(|item| match item {
            Item::Value(value) => Some(value),
            Item::Plain(_) => None,
        })
    }
}

pub(super) fn shape_of(reading: &Reading) -> Vec<Shape> {
    let shape = |item: &Item| match item {
        Item::Value(_) => Shape::Value,
        Item::Plain(cell) if is_stamp(cell) => Shape::Word,
        Item::Plain(_) => Shape::Number,
    };
    reading.items.iter().map(shape).collect()
}

fn is_any(word: &[u8], known: &[&str]) -> bool {
    known.iter().any(|known| word.eq_ignore_ascii_case(known.as_bytes()))
}

/// Whether a word is a unit of force.
pub(super) fn is_force_unit(word: &[u8]) -> bool {
    is_any(word, &FORCE_UNITS)
}

fn is_unit(word: &[u8]) -> bool {
    is_force_unit(word)
        || std::str::from_utf8(word)
            .is_ok_and(|word| word.chars().next().is_some_and(char::is_alphabetic) && Unit::parse_loose(word).is_some())
}

/// Takes a line apart; `None` if anything in it is not understood, or no value is in it.
pub(super) fn reading(line: &[u8], delimiter: u8, decimal: Decimal) -> Option<Reading<'_>> {
    // Longer lines are no readings.
    if line.len() > 400 {
        return None;
    }
    let mut parts = Vec::new();
    if delimiter == b' ' {
        parts.push(trim(line));
    } else {
        cells(line, delimiter, &mut parts);
    }
    let mut out = Reading::default();
    for part in parts {
        // An empty cell has no place: which column is missing would be open.
        if part.is_empty() {
            return None;
        }
        if is_stamp(part) {
            out.items.push(Item::Plain(part));
            continue;
        }
        words(part, decimal, &mut out)?;
    }
    let has_value = out.values().next().is_some();
    has_value.then_some(out)
}

/// Takes a cell apart at its blanks.
fn words<'b>(part: &'b [u8], decimal: Decimal, out: &mut Reading<'b>) -> Option<()> {
    let is_blank = |b: &u8| matches!(b, b' ' | b'\t');
    let skip = |mut at: usize| {
        while part.get(at).is_some_and(is_blank) {
            at += 1;
        }
        at
    };
    let end_of = |from: usize| {
        let length = part.get(from..).unwrap_or_default().iter().position(is_blank);
        length.map_or(part.len(), |length| from + length)
    };
    let mut at = 0;
    while at < part.len() {
        // `-   0.039`: some gauges keep the sign at the left of the field.
        let is_sign = |at: usize| matches!(part.get(at), Some(b'+' | b'-')) && part.get(at + 1).is_some_and(is_blank);
        let is_apart = out.items.is_empty()
            && is_sign(at)
            && part.get(skip(at + 1)).is_some_and(|b| b.is_ascii_digit() || matches!(b, b'.' | b','));
        let is_negative = is_apart && part.get(at) == Some(&b'-');
        if is_apart {
            at = skip(at + 1);
        }
        let end = end_of(at);
        let word = part.get(at..end)?;
        // A date, a time and AM or PM are one stamp.
        let ends = [end_of(skip(end_of(skip(end)))), end_of(skip(end)), end];
        if let Some(end) = ends.into_iter().find(|end| !is_apart && part.get(at..*end).is_some_and(is_stamp)) {
            out.items.push(Item::Plain(part.get(at..end)?));
            at = skip(end);
            continue;
        }
        let next_at = skip(end);
        let next = part.get(next_at..end_of(next_at)).unwrap_or_default();
        let bare = word.strip_suffix(b":").unwrap_or(word);
        if parse_number(word, decimal).is_some_and(f64::is_finite) {
            if is_unit(next) {
                let number = parse_number(word, decimal).map(|number| if is_negative { -number } else { number });
                out.items.push(Item::Value(Value { number, unit: next, text: word }));
                at = skip(end_of(next_at));
                continue;
            }
            if is_apart {
                return None;
            }
            out.items.push(Item::Plain(word));
        } else if let Some((number, unit)) = glued(word, decimal) {
            let number = if is_negative { -number } else { number };
            out.items.push(Item::Value(Value { number: Some(number), unit, text: word }));
        } else if is_missing(word) {
            out.items.push(Item::Value(Value { number: None, unit: b"", text: word }));
            if is_unit(next) {
                at = skip(end_of(next_at));
                continue;
            }
        } else if is_any(bare, &["p", "pk", "peak", "pk+", "pk-", "max", "peak+", "peak-"]) && !out.is_peak {
            out.is_peak = true;
        } else if is_any(bare, &["t", "tens", "tension"]) && out.is_tension.is_none() {
            out.is_tension = Some(true);
        } else if is_any(bare, &["c", "comp", "compression"]) && out.is_tension.is_none() {
            out.is_tension = Some(false);
        } else {
            return None;
        }
        at = next_at;
    }
    Some(())
}

/// `OL`, `-OL`, `----`, `--.--`.
fn is_missing(word: &[u8]) -> bool {
    let is_dashes = word.len() > 1 && word.starts_with(b"-") && word.iter().all(|b| matches!(b, b'-' | b'.' | b'_'));
    let bare = word.strip_prefix(b"+").or_else(|| word.strip_prefix(b"-")).unwrap_or(word);
    is_dashes || is_any(bare, &OVERLOAD)
}

/// `12.34N`: the number and the unit behind it.
fn glued(word: &[u8], decimal: Decimal) -> Option<(f64, &[u8])> {
    let at = word.iter().rposition(|b| b.is_ascii_digit() || matches!(b, b'.' | b','))? + 1;
    let (number, unit) = word.split_at_checked(at)?;
    let number = parse_number(number, decimal).filter(|n| n.is_finite())?;
    is_unit(unit).then_some((number, unit))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Numbers with units, peak, tension.
    type Told = (Vec<(Option<f64>, String)>, bool, Option<bool>);

    fn of(line: &str) -> Option<Told> {
        let decimal = if line.contains(',') { Decimal::Comma } else { Decimal::Point };
        let reading = reading(line.as_bytes(), b' ', decimal)?;
        let values = reading.values().map(|v| (v.number, String::from_utf8(v.unit.to_vec()).unwrap())).collect();
        Some((values, reading.is_peak, reading.is_tension))
    }

    #[test]
    fn lines_as_gauges_write_them() {
        let one = |number: f64, unit: &str| vec![(Some(number), unit.to_owned())];
        for (line, told) in [
            ("12.34 N", (one(12.34, "N"), false, None)),
            ("-0.56 lbF", (one(-0.56, "lbF"), false, None)),
            ("+1,2kgf", (one(1.2, "kgf"), false, None)),
            ("-   0.039 N", (one(-0.039, "N"), false, None)),
            ("+ 1.5N PEAK", (one(1.5, "N"), true, None)),
            ("   0.000 N  ", (one(0.0, "N"), false, None)),
            ("12.34N T", (one(12.34, "N"), false, Some(true))),
            ("12.34N C", (one(12.34, "N"), false, Some(false))),
            ("PEAK: 23.4 N", (one(23.4, "N"), true, None)),
            ("23.4 N PK", (one(23.4, "N"), true, None)),
            ("OL N", (vec![(None, String::new())], false, None)),
            ("----", (vec![(None, String::new())], false, None)),
            ("17 12.34 N", (one(12.34, "N"), false, None)),
            ("11/22/2026 9:13:00 AM 12.34 N", (one(12.34, "N"), false, None)),
            ("12.34 N 5.0 mm", (vec![(Some(12.34), "N".to_owned()), (Some(5.0), "mm".to_owned())], false, None)),
        ] {
            assert_eq!(of(line), Some(told), "{line}");
        }
        for line in
            ["12.34", "", "N", "- 12.34", "- N", "- -1 N", "1 - 2 N", "12.34 parsec", "time 12.34 N", "1 2 3", "a,b,c"]
        {
            assert_eq!(of(line), None, "{line}");
        }
    }
}
