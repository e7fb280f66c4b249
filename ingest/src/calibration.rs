//! From what an instrument puts out to what it measures.
//!
//! | kind | y of x | refused |
//! |---|---|---|
//! | line | slope x + offset | nothing |
//! | polynomial | c0 + c1 x + c2 x² + … | nothing |
//! | table | straight lines between points | outside the first and last point |
//! | divider and line | gain (supply - x)/x + offset | x <= 0 and x >= supply |
//!
//! x is in the instrument's input unit, y in its output unit. A declared valid range of x is respected besides; what is refused
//! is no number, and whoever calibrates a channel counts and lists it.
//!
//! The divider: a sensor of resistance Rs in series with a resistor R on a supply U, x the voltage across R. Then
//! Rs / R = (U - x)/x, and the sensor's reading is linear in Rs. Source: fruit-finger, Eq. 16 and 17: Rs = (5 - u) 22/u kΩ,
//! θ = (5 - u) 70.74/u - 109.3 deg, 0 < u < 5 V. u is the voltage across the 22 kΩ resistor, whatever the text says.
//!
//! # Check value
//! fruit-finger's flex sensor: 1.9645 V -> 0.0058 deg, 1.2195 V -> 109.9969 deg, 1.5 V -> 55.76 deg; 0 V and 5 V are refused.
//! ```
//! use pneuval_ingest::calibration::Calibration;
//! let flex = Calibration::Divider { supply: 5.0, gain: 70.74, offset: -109.3 };
//! for (volts, degrees) in [(1.9645, 0.0058), (1.2195, 109.9969), (1.5, 55.76)] {
//!     assert!((flex.apply(volts).unwrap() - degrees).abs() < 5e-5);
//! }
//! assert_eq!((flex.apply(0.0), flex.apply(5.0), flex.apply(-0.1)), (None, None, None));
//! ```

use std::fmt;

/// A calibration, in the instrument's own units.
#[derive(Debug, Clone, PartialEq)]
pub enum Calibration {
    /// `slope x + offset`.
    Line {
        /// Output units per input unit.
        slope: f64,
        /// Output at zero input.
        offset: f64,
    },
    /// `c0 + c1 x + c2 x² + …`.
    Polynomial {
        /// From the constant upwards.
        coefficients: Vec<f64>,
    },
    /// Straight lines between points of rising input.
    Table {
        /// Input and output.
        points: Vec<(f64, f64)>,
    },
    /// `gain (supply - x)/x + offset`.
    Divider {
        /// Supply, in input units.
        supply: f64,
        /// Output units per sensor resistance over resistor.
        gain: f64,
        /// Output at a sensor resistance of zero.
        offset: f64,
    },
}

impl Calibration {
    /// The output of an input; `None` where the calibration does not hold, or the result is not finite.
    pub fn apply(&self, x: f64) -> Option<f64> {
        let y = match self {
            Self::Line { slope, offset } => slope * x + offset,
            Self::Polynomial { coefficients } => coefficients.iter().rev().fold(0.0, |sum, c| sum * x + c),
            Self::Table { points } => interpolate(points, x)?,
            Self::Divider { supply, gain, offset } => {
                if !(x > 0.0 && x < *supply) {
                    return None;
                }
                gain * (supply - x) / x + offset
            }
        };
        y.is_finite().then_some(y)
    }
}

/// The straight line between the two points around `x`; `None` outside.
pub fn interpolate(points: &[(f64, f64)], x: f64) -> Option<f64> {
    let (first, last) = (points.first()?.0, points.last()?.0);
    // A positive condition, so that NaN is refused too.
    let inside = x >= first && x <= last;
    let i = inside.then(|| points.partition_point(|p| p.0 < x).max(1)).filter(|i| *i < points.len())?;
    let ((x0, y0), (x1, y1)) = (points[i - 1], points[i]);
    // Exact at both ends.
    Some(if x.to_bits() == x1.to_bits() { y1 } else { y0 + (y1 - y0) * ((x - x0) / (x1 - x0)) })
}

impl fmt::Display for Calibration {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Line { slope, offset } => write!(f, "y = {slope} x + {offset}"),
            Self::Polynomial { coefficients } => {
                f.write_str("y = ")?;
                for (k, c) in coefficients.iter().enumerate() {
                    match k {
                        0 => write!(f, "{c}")?,
                        1 => write!(f, " + {c} x")?,
                        _ => write!(f, " + {c} x^{k}")?,
                    }
                }
                Ok(())
            }
            Self::Table { points } => write!(f, "straight lines between {} points", points.len()),
            Self::Divider { supply, gain, offset } => write!(f, "y = {gain} ({supply} - x)/x + {offset}"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table() -> Calibration {
        Calibration::Table { points: vec![(0.0, 1.0), (1.0, 3.0), (4.0, 0.0)] }
    }

    #[test]
    fn a_table_is_exact_at_its_points_and_refuses_what_lies_outside() {
        for (x, y) in [(0.0, 1.0), (0.5, 2.0), (1.0, 3.0), (2.5, 1.5), (4.0, 0.0)] {
            assert_eq!(table().apply(x), Some(y), "{x}");
        }
        for x in [-1e-9, 4.000_001, f64::NAN, f64::INFINITY] {
            assert_eq!(table().apply(x), None, "{x}");
        }
    }

    #[test]
    fn a_polynomial_of_two_coefficients_is_the_line() {
        let line = Calibration::Line { slope: 13.337_56, offset: -47.489_80 };
        let polynomial = Calibration::Polynomial { coefficients: vec![-47.489_80, 13.337_56] };
        for x in [-1.0, 0.0, 3.427] {
            assert_eq!(line.apply(x), polynomial.apply(x));
        }
    }

    #[test]
    fn the_divider_refuses_its_ends_and_beyond() {
        let flex = Calibration::Divider { supply: 5.0, gain: 70.74, offset: -109.3 };
        for volts in [0.0, 5.0, -0.1, 5.1, f64::NAN] {
            assert_eq!(flex.apply(volts), None, "{volts}");
        }
        assert!(flex.apply(4.999).unwrap() < -109.0 && flex.apply(1e-3).unwrap() > 1e5);
    }
}
