//! Writing what [`read`](super::read) reads.

use std::fmt::Write as _;

/// What tells the time of a gauge's values.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Clock<'a> {
    /// A rate in Hz, stated above them.
    Rate(f64),
    /// Seconds before each of them.
    Seconds(&'a [f64]),
}

/// Values as a gauge writes them, rounded to some decimals, and their unit; what is not finite as an overload.
///
/// ```
/// use pneuval_ingest::formats::gauge::{Clock, write};
/// let text = write(&[1.5, -0.25, f64::NAN], "N", 2, Clock::Rate(100.0));
/// assert_eq!(text, "Sampling rate: 100 Hz\n1.50 N\n-0.25 N\nOL N\n");
/// ```
pub fn write(values: &[f64], unit: &str, decimals: usize, clock: Clock) -> String {
    let mut out = String::new();
    // Writing to a string does not fail.
    if let Clock::Rate(rate_hz) = clock {
        let _ = writeln!(out, "Sampling rate: {rate_hz} Hz");
    }
    for (row, value) in values.iter().enumerate() {
        if let Clock::Seconds(seconds) = clock {
            let _ = write!(out, "{}\t", seconds.get(row).copied().unwrap_or(f64::NAN));
        }
        let _ = if value.is_finite() { writeln!(out, "{value:.decimals$} {unit}") } else { writeln!(out, "OL {unit}") };
    }
    out
}
