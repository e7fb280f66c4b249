//! Decimal numbers in cells, correctly rounded and independent of any locale.
//!
//! Eight digits are read at a time. A mantissa up to 2^53 with a power of ten up to 22 needs one multiplication or division of
//! exact values, which IEEE 754 rounds correctly (Clinger 1990, "How to read floating point numbers accurately"); everything
//! longer goes to the standard library, whose conversion is correctly rounded for any length.

/// The sign between whole and fraction.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Decimal {
    /// `1.5`
    Point,
    /// `1,5`
    Comma,
}

impl Decimal {
    /// As a byte.
    pub fn byte(self) -> u8 {
        match self {
            Self::Point => b'.',
            Self::Comma => b',',
        }
    }
}

/// Exactly representable powers of ten.
const POWERS: [f64; 23] = [
    1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15, 1e16, 1e17, 1e18, 1e19, 1e20,
    1e21, 1e22,
];

/// Powers of ten by which a mantissa moves when digits follow.
const SHIFTS: [u64; 8] = [1, 10, 100, 1_000, 10_000, 100_000, 1_000_000, 10_000_000];

/// Largest mantissa that an `f64` holds exactly, whatever its last digit.
const MANTISSA_MAX: u64 = 1 << 53;

/// As many digits always fit in a `u64`.
const DIGITS_MAX: usize = 19;

/// The number that fills a cell; `None` if the cell is anything else.
///
/// Accepted: a sign, digits, a decimal sign anywhere among them, and an exponent after `e`, `E`, `d` or `D` (Fortran, MATLAB).
/// Not accepted: thousands separators, the other decimal sign, hexadecimal, infinities and NaN. The value may be infinite where the
/// written number exceeds `f64`.
///
/// ```
/// use pneuval_ingest::formats::csv::{Decimal, parse_number};
/// assert_eq!(parse_number(b"-12.50", Decimal::Point), Some(-12.5));
/// assert_eq!(parse_number(b"1,5D-3", Decimal::Comma), Some(0.0015));
/// assert_eq!(parse_number(b"1,234.5", Decimal::Point), None);
/// assert_eq!(parse_number(b"nan", Decimal::Point), None);
/// ```
pub fn parse(cell: &[u8], decimal: Decimal) -> Option<f64> {
    scan(cell, 0, decimal.byte()).filter(|(_, end)| *end == cell.len()).map(|(value, _)| value)
}

/// The number that begins at `start`, and where it ends.
#[inline]
pub(in crate::formats) fn scan(bytes: &[u8], start: usize, decimal: u8) -> Option<(f64, usize)> {
    let first = *bytes.get(start)?;
    let negative = first == b'-';
    let mut at = start + usize::from(negative || first == b'+');

    let mut mantissa = 0;
    let whole = digits(bytes, at, &mut mantissa);
    let mut count = whole - at;
    at = whole;
    let mut exponent: i64 = 0;
    if bytes.get(at) == Some(&decimal) {
        let fraction = digits(bytes, at + 1, &mut mantissa);
        let places = fraction - at - 1;
        count += places;
        // Places of one file fit in an i64.
        exponent = -i64::try_from(places).ok()?;
        at = fraction;
    }
    if count == 0 {
        return None;
    }
    if let Some(b'e' | b'E' | b'd' | b'D') = bytes.get(at) {
        let (written, end) = scan_exponent(bytes, at + 1)?;
        exponent += written;
        at = end;
    }
    let value = match usize::try_from(exponent.unsigned_abs()).ok().and_then(|power| POWERS.get(power)) {
        Some(power) if count <= DIGITS_MAX && mantissa <= MANTISSA_MAX => {
            let mantissa = mantissa as f64;
            let size = if exponent < 0 { mantissa / power } else { mantissa * power };
            f64::from_bits(size.to_bits() | (u64::from(negative) << 63))
        }
        _ => long(bytes.get(start..at)?)?,
    };
    Some((value, at))
}

/// Reads digits into the mantissa, which wraps where there are more than [`DIGITS_MAX`]; returns where they end.
#[inline]
fn digits(bytes: &[u8], mut at: usize, mantissa: &mut u64) -> usize {
    while let Some(chunk) = bytes.get(at..).and_then(|rest| rest.first_chunk::<8>()) {
        let chunk = u64::from_le_bytes(*chunk);
        let count = leading_digits(chunk);
        if count == 8 {
            *mantissa = mantissa.wrapping_mul(100_000_000).wrapping_add(eight_digits(chunk));
            at += 8;
            continue;
        }
        if count > 0 {
            // The digits move to the end; zero bytes before them count as zeros.
            let value = eight_digits(chunk << (64 - 8 * count));
            *mantissa = mantissa.wrapping_mul(SHIFTS[count]).wrapping_add(value);
        }
        return at + count;
    }
    while let Some(digit) = bytes.get(at).filter(|b| b.is_ascii_digit()) {
        *mantissa = mantissa.wrapping_mul(10).wrapping_add(u64::from(digit - b'0'));
        at += 1;
    }
    at
}

/// How many of eight bytes, lowest first, are digits before the first that is not.
#[inline]
fn leading_digits(chunk: u64) -> usize {
    const HIGH: u64 = 0xf0f0_f0f0_f0f0_f0f0;
    const ZEROS: u64 = 0x3030_3030_3030_3030;
    // A digit is 0x30..=0x39: its high half is 3, also after adding 6. A carry out of a byte reaches only bytes behind it.
    let other = ((chunk & HIGH) ^ ZEROS) | ((chunk.wrapping_add(0x0606_0606_0606_0606) & HIGH) ^ ZEROS);
    (other.trailing_zeros() / 8) as usize
}

/// The value of eight digits, first digit in the lowest byte: pairs, then fours, then all.
#[inline]
fn eight_digits(chunk: u64) -> u64 {
    let pairs = (chunk & 0x0f0f_0f0f_0f0f_0f0f).wrapping_mul(10 * 256 + 1) >> 8;
    let fours = (pairs & 0x00ff_00ff_00ff_00ff).wrapping_mul(100 * 65_536 + 1) >> 16;
    (fours & 0x0000_ffff_0000_ffff).wrapping_mul(10_000 * 4_294_967_296 + 1) >> 32
}

/// An exponent with its sign. One beyond any `f64` stays beyond it without overflow.
fn scan_exponent(bytes: &[u8], mut at: usize) -> Option<(i64, usize)> {
    let negative = bytes.get(at) == Some(&b'-');
    if let Some(b'+' | b'-') = bytes.get(at) {
        at += 1;
    }
    let first = at;
    let mut value: i64 = 0;
    while let Some(digit) = bytes.get(at).filter(|b| b.is_ascii_digit()) {
        value = (value * 10 + i64::from(digit - b'0')).min(1 << 40);
        at += 1;
    }
    (at > first).then_some((if negative { -value } else { value }, at))
}

/// A number with too many digits, or too large a power of ten, for exact arithmetic.
#[cold]
fn long(number: &[u8]) -> Option<f64> {
    let text = std::str::from_utf8(number).ok()?;
    if number.iter().any(|b| matches!(b, b',' | b'd' | b'D')) {
        // Only signs, digits, one decimal sign and an exponent stand here.
        return text.replace(',', ".").replace(['d', 'D'], "e").parse().ok();
    }
    text.parse().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn point(text: &str) -> Option<f64> {
        parse(text.as_bytes(), Decimal::Point)
    }

    #[test]
    fn what_is_a_number_and_what_is_not() {
        for (text, value) in [
            ("0", 0.0_f64),
            ("+7", 7.0),
            (".5", 0.5),
            ("5.", 5.0),
            ("-.5e1", -5.0),
            ("1E+3", 1e3),
            ("1d-3", 1e-3),
            ("2.5D2", 250.0),
            ("12345678", 12_345_678.0),
            ("123456789.12345678", 123_456_789.123_456_78),
        ] {
            assert_eq!(point(text).map(f64::to_bits), Some(value.to_bits()), "{text}");
        }
        for text in [
            "", "+", "-", ".", "e5", "1e", "1e+", "1.2.3", "1,5", "1 000", "1_000", "1'000", "0x10", "nan", "inf",
            "12a", "--1", "1e5.0", "−1", "½", " 1",
        ] {
            assert_eq!(point(text), None, "{text}");
        }
        assert_eq!(parse(b"1,5", Decimal::Comma), Some(1.5));
        assert_eq!(parse(b"1.234,5", Decimal::Comma), None);
        assert_eq!(parse(b"1.5", Decimal::Comma), None);
        assert_eq!(point("-0.0").map(f64::to_bits), Some((-0.0_f64).to_bits()));
        assert_eq!(point("1e999"), Some(f64::INFINITY));
        assert_eq!(point("1e-999"), Some(0.0));
        assert_eq!(point("0e99999999999999999999"), Some(0.0));
    }

    #[test]
    fn hard_cases_are_correctly_rounded() {
        // The standard library is correctly rounded, and tested for it elsewhere.
        for text in [
            "9007199254740993",
            "9007199254740992.5",
            "0.1e-400",
            "2.2250738585072011e-308",
            "4.9406564584124654e-324",
            "1.7976931348623157e308",
            "179769313486231580793e289",
            "0.000000000000000000000000000000000000000000000000000000000012345",
            "100000000000000000000000000000000000000000000000000000000000000000",
            "0.30000000000000004",
            "6.02214076e23",
            "8.5e22",
            "7450580596923828125e-27",
            "3.518437208883201171875e13",
        ] {
            let expected: f64 = text.parse().unwrap();
            assert_eq!(point(text).map(f64::to_bits), Some(expected.to_bits()), "{text}");
            let comma = text.replace('.', ",").replace('e', "d");
            let read = parse(comma.as_bytes(), Decimal::Comma);
            assert_eq!(read.map(f64::to_bits), Some(expected.to_bits()), "{comma}");
        }
    }

    #[test]
    fn a_hundred_thousand_numbers_as_the_standard_library_reads_them() {
        let mut state = 0x9e37_79b9_7f4a_7c15_u64;
        let mut next = || {
            state ^= state << 13;
            state ^= state >> 7;
            state ^= state << 17;
            state
        };
        for _ in 0..50_000 {
            let value = f64::from_bits(next());
            let places = usize::try_from(next() % 20).unwrap();
            let size = (next() % 1_000_000_000) as f64 / 977.0;
            for text in [format!("{value:e}"), format!("{size:.places$}")] {
                if value.is_nan() || value.is_infinite() {
                    continue;
                }
                let expected: f64 = text.parse().unwrap();
                assert_eq!(point(&text).map(f64::to_bits), Some(expected.to_bits()), "{text}");
                // The same number with other bytes behind it.
                let behind = format!("{text};987654321");
                assert_eq!(scan(behind.as_bytes(), 0, b'.').map(|(_, end)| end), Some(text.len()), "{behind}");
            }
        }
    }
}
