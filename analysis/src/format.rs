//! Numbers as text: the same digits on pages, in figures and on the terminal.

use pneuval_ingest::units::{Dimension, Unit};

/// Text of files and users as it can be shown anywhere: control characters and marks that turn the direction of writing are visible escapes,
/// line breaks are kept.
pub fn visible(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        if (c.is_control() && c != '\n') || is_direction(c) {
            out.extend(c.escape_unicode());
        } else {
            out.push(c);
        }
    }
    out
}

/// Marks that turn the direction of the writing (Unicode's UAX 9).
fn is_direction(c: char) -> bool {
    matches!(c, '\u{061c}' | '\u{200e}' | '\u{200f}' | '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}')
}

/// A number with a fixed count of decimals and a true minus sign; a non-finite one is named.
pub fn fixed(value: f64, decimals: usize) -> String {
    if value.is_nan() {
        return "not a number".to_owned();
    }
    if value.is_infinite() {
        return "infinite".to_owned();
    }
    let text = format!("{value:.decimals$}");
    match text.strip_prefix('-') {
        // A rounded zero has no sign.
        Some(digits) if digits.bytes().all(|b| b == b'0' || b == b'.') => digits.to_owned(),
        Some(digits) => format!("\u{2212}{digits}"),
        None => text,
    }
}

/// A number with its unit set beside it.
pub fn with_unit(text: &str, unit: Unit) -> String {
    match unit.printed() {
        "" => text.to_owned(),
        "°" => format!("{text}°"),
        printed => format!("{text} {printed}"),
    }
}

/// An SI value in a unit, with decimals that suit it.
pub fn quantity(value_si: f64, unit: Unit, decimals: usize) -> String {
    with_unit(&fixed(unit.from_si(value_si), decimals), unit)
}

/// Decimals at which errors and predictions are shown: four in mm, deg and N, and as fine as that in every other unit.
pub fn error_decimals(unit: Unit) -> usize {
    let usual = unit.dimension.display_unit().factor;
    // Powers of ten between the units, at most a few.
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
    let decimals = (4.0 + (unit.factor / usual).log10().round()).clamp(0.0, 9.0) as usize;
    decimals
}

/// A share as percent, three decimals.
pub fn percent(share: f64) -> String {
    format!("{} %", fixed(100.0 * share, 3))
}

/// Gauge pressures in kPa, joined: `40 kPa` or `tip 40, root 50 kPa`.
pub fn pressures(pressures_gauge_pa: &[f64], chambers: &[String]) -> String {
    let unit = Dimension::Pressure.display_unit();
    let number = |p: &f64| short(unit.from_si(*p));
    match pressures_gauge_pa {
        [one] => with_unit(&number(one), unit),
        many => {
            let named: Vec<String> = many.iter().zip(chambers).map(|(p, c)| format!("{c} {}", number(p))).collect();
            with_unit(&named.join(", "), unit)
        }
    }
}

/// A number with at most six significant digits and no trailing zeros.
pub fn short(value: f64) -> String {
    significant(value, 6)
}

/// A number with at most so many significant digits and no trailing zeros.
pub fn significant(value: f64, digits: usize) -> String {
    if value == 0.0 || !value.is_finite() {
        return fixed(value, 0);
    }
    // The exponent of a finite non-zero double is within ±324, and nobody asks for more digits than a double has.
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
    let decimals = (digits as f64 - 1.0 - value.abs().log10().floor()).clamp(0.0, 12.0) as usize;
    let text = fixed(value, decimals);
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_read_as_they_should() {
        assert_eq!(visible("a\u{1b}[1m\nb\u{202e}c"), "a\\u{1b}[1m\nb\\u{202e}c");
        assert_eq!(fixed(-0.000_01, 2), "0.00");
        assert_eq!(fixed(-1.5, 1), "\u{2212}1.5");
        assert_eq!(fixed(f64::NAN, 1), "not a number");
        assert_eq!(short(0.1 + 0.2), "0.3");
        assert_eq!(short(123_456_789.0), "123456789");
        assert_eq!(percent(0.028_11), "2.811 %");
        assert_eq!(pressures(&[40e3], &["tip".to_owned()]), "40 kPa");
        assert_eq!(pressures(&[40e3, 50e3], &["tip".to_owned(), "root".to_owned()]), "tip 40, root 50 kPa");
        assert_eq!(quantity(std::f64::consts::PI, Unit::parse("deg").unwrap(), 1), "180.0°");
    }
}
