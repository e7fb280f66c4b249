//! A printed number and what its digits leave open.

/// A number as printed, in SI units.
///
/// `33.44` mm stands for anything that rounds to it: 33.435 to 33.445 mm. That half unit of the last digit is all that is
/// known about a published value; it is a rounding interval, not a measurement uncertainty.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Printed {
    /// The value in SI units; may be NaN where `NaN` is printed.
    pub si: f64,
    /// Half a unit of the last printed digit, in SI units.
    pub half_width_si: f64,
}

/// The value of a decimal number and half a unit of its last digit; `None` if the text is not a number.
///
/// Accepts sign, digits with an optional point, and an exponent; and `NaN`, which is passed on to be judged, never to pass.
/// Infinities are refused.
///
/// ```
/// use pneuval_ingest::number::parse;
/// assert_eq!(parse("33.44"), Some((33.44, 0.005)));
/// assert_eq!(parse("230"), Some((230.0, 0.5)));
/// assert_eq!(parse("1.5e3"), Some((1500.0, 50.0)));
/// assert_eq!(parse("12,5"), None);
/// ```
pub fn parse(text: &str) -> Option<(f64, f64)> {
    if matches!(text, "NaN" | "nan") {
        return Some((f64::NAN, 0.0));
    }
    let unsigned = text.strip_prefix(['+', '-']).unwrap_or(text);
    let (mantissa, exponent) = match unsigned.split_once(['e', 'E']) {
        Some((mantissa, exponent)) => (mantissa, exponent.parse::<i32>().ok()?),
        None => (unsigned, 0),
    };
    let (whole, fraction) = mantissa.split_once('.').unwrap_or((mantissa, ""));
    let digits = |s: &str| s.bytes().all(|b| b.is_ascii_digit());
    if (whole.is_empty() && fraction.is_empty()) || !digits(whole) || !digits(fraction) {
        return None;
    }
    let value: f64 = text.parse().ok().filter(|v: &f64| v.is_finite())?;
    let last_digit = i32::try_from(fraction.len()).ok().map(|n| exponent.saturating_sub(n))?;
    // Through text, so that half of 0.01 is the double nearest to 0.005.
    let half_width = format!("5e{}", last_digit.saturating_sub(1)).parse().ok().filter(|h: &f64| h.is_finite())?;
    Some((value, half_width))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_not_a_number_is_refused() {
        for text in ["", ".", "-", "1e", "0x10", "1_000", "inf", "1e999", "0e400", "1.2.3", "12 ", "３"] {
            assert_eq!(parse(text), None, "{text:?}");
        }
    }

    #[test]
    fn digits_after_the_point_are_the_resolution() {
        assert_eq!(parse("-0.50"), Some((-0.5, 0.005)));
        assert_eq!(parse(".5"), Some((0.5, 0.05)));
        assert_eq!(parse("5."), Some((5.0, 0.5)));
        assert!(parse("NaN").unwrap().0.is_nan());
    }
}
