//! Values of properties and the instants among them.

use std::collections::BTreeMap;
use std::fmt;

use crate::formats::stamps::rfc3339_second;

/// Seconds from 1904-01-01 00:00 UTC, from which LabVIEW counts, to 1970-01-01 00:00 UTC.
const S_1904_TO_1970: i64 = 2_082_844_800;

/// Units of 2^-64 s in a second.
const FRACTIONS: f64 = (1_u128 << 64) as f64;

/// An instant as LabVIEW stores it: whole seconds since 1904-01-01 00:00 UTC, and units of 2^-64 s.
///
/// ```
/// use pneuval_ingest::formats::tdms::Timestamp;
/// let stamp = Timestamp { seconds: 3_428_524_800, fraction: 1 << 63 };
/// assert_eq!(stamp.to_string(), "2012-08-23T00:00:00.5Z");
/// assert_eq!(stamp.since(3_428_524_799), 1.5);
/// // The smallest fraction that the file can hold is not lost.
/// assert_eq!(Timestamp { seconds: 0, fraction: 1 }.since(0), 2.0_f64.powi(-64));
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Timestamp {
    /// Whole seconds since 1904-01-01 00:00 UTC, rounded down.
    pub seconds: i64,
    /// What is left, in units of 2^-64 s.
    pub fraction: u64,
}

impl Timestamp {
    /// Seconds since a whole second of the same count, correctly rounded.
    pub fn since(self, origin_seconds: i64) -> f64 {
        let seconds = i128::from(self.seconds) - i128::from(origin_seconds);
        // Beyond 2^62 s the fraction is far below the last digit of a double, and the sum would not fit.
        if seconds.unsigned_abs() >= 1 << 62 {
            return seconds as f64;
        }
        ((seconds << 64) + i128::from(self.fraction)) as f64 / FRACTIONS
    }

    /// As RFC 3339, UTC, to the microsecond below: for sentences.
    pub fn rounded(self) -> String {
        let micros = (u128::from(self.fraction) * 1_000_000) >> 64;
        let second = self.second();
        let second = second.strip_suffix('Z').unwrap_or(&second);
        if micros == 0 { format!("{second}Z") } else { format!("{second}.{micros:06}Z") }
    }

    /// Its whole second as RFC 3339, UTC.
    pub fn second(self) -> String {
        rfc3339_second(self.seconds.saturating_sub(S_1904_TO_1970), true)
    }
}

impl fmt::Display for Timestamp {
    /// RFC 3339, UTC, with as many decimals as are needed to tell it from its neighbours: at most 19.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let second = self.second();
        let second = second.strip_suffix('Z').unwrap_or(&second);
        if self.fraction == 0 {
            return write!(f, "{second}Z");
        }
        // Digits are added until they stand for this fraction and no other. Nineteen are finer than its unit.
        let fraction = u128::from(self.fraction);
        let (mut digits, mut power) = (0_u128, 1_u128);
        for places in 1..=19 {
            power *= 10;
            digits = (fraction * power + (1 << 63)) >> 64;
            let back = ((digits << 64) + power / 2) / power;
            if back == fraction && digits < power {
                return write!(f, "{second}.{digits:0places$}Z");
            }
        }
        write!(f, "{second}.{:019}Z", digits.min(power - 1))
    }
}

/// The value of a property.
#[derive(Debug, Clone, PartialEq)]
pub enum Value {
    /// A signed integer of any width.
    Int(i64),
    /// An unsigned integer of any width.
    Uint(u64),
    /// A single.
    Single(f32),
    /// A double.
    Double(f64),
    /// A complex number of any width.
    Complex(f64, f64),
    /// Text.
    Text(String),
    /// Yes or no.
    Bool(bool),
    /// An instant.
    Time(Timestamp),
    /// Nothing.
    Void,
}

impl Value {
    /// As a number, where it is a real one.
    pub fn number(&self) -> Option<f64> {
        match self {
            Self::Int(value) => Some(*value as f64),
            Self::Uint(value) => Some(*value as f64),
            Self::Single(value) => Some(f64::from(*value)),
            Self::Double(value) => Some(*value),
            Self::Complex(..) | Self::Text(_) | Self::Bool(_) | Self::Time(_) | Self::Void => None,
        }
    }

    /// As a text.
    pub fn text(&self) -> Option<&str> {
        match self {
            Self::Text(text) => Some(text),
            _ => None,
        }
    }
}

impl fmt::Display for Value {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Int(value) => value.fmt(f),
            Self::Uint(value) => value.fmt(f),
            Self::Single(value) => value.fmt(f),
            Self::Double(value) => value.fmt(f),
            Self::Complex(re, im) => write!(f, "{re}{im:+}i"),
            Self::Text(text) => text.fmt(f),
            Self::Bool(value) => value.fmt(f),
            Self::Time(stamp) => stamp.fmt(f),
            Self::Void => Ok(()),
        }
    }
}

/// Properties of a file, a group or a channel, by name.
pub type Properties = BTreeMap<String, Value>;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn digits_tell_an_instant_from_its_neighbours_and_no_more() {
        let shown = |fraction| Timestamp { seconds: S_1904_TO_1970, fraction }.to_string();
        assert_eq!(shown(0), "1970-01-01T00:00:00Z");
        assert_eq!(shown(1 << 62), "1970-01-01T00:00:00.25Z");
        assert_eq!(shown(1), "1970-01-01T00:00:00.0000000000000000001Z");
        assert!(shown(u64::MAX).starts_with("1970-01-01T00:00:00.99999999999999999"));
        // A tenth, as it is stored, is shown as one only if it is the nearest fraction.
        assert_eq!(shown(1_844_674_407_370_955_162), "1970-01-01T00:00:00.1Z");
        assert_ne!(shown(1_844_674_407_370_955_163), "1970-01-01T00:00:00.1Z");
    }

    #[test]
    fn seconds_since_an_origin_are_rounded_once() {
        let stamp = Timestamp { seconds: i64::MAX, fraction: u64::MAX };
        assert!((stamp.since(i64::MIN) - 2.0_f64.powi(64)).abs() < 1e4);
        let tenth = Timestamp { seconds: 7, fraction: 1_844_674_407_370_955_162 };
        assert_eq!(tenth.since(7).to_bits(), 0.1_f64.to_bits());
        assert_eq!(Timestamp { seconds: -1, fraction: 1 << 63 }.since(0).to_bits(), (-0.5_f64).to_bits());
    }
}
