//! Numbers with twice the digits of a double.

use std::convert::Infallible;

use super::two_float::TwoFloat;
use super::{Algebra, Function, Operation};

/// The algebra of numbers with 32 digits: where residuals are a billionth of what is measured, those of a double are mostly rounding.
#[derive(Debug, Clone, Copy, Default)]
pub struct Precise;

impl Algebra for Precise {
    type Value = TwoFloat;
    type Error = Infallible;

    fn constant(&self, value: f64) -> TwoFloat {
        decimal(value)
    }

    fn apply(&self, operation: Operation, arguments: &[&TwoFloat]) -> Result<TwoFloat, Infallible> {
        let nan = TwoFloat::from(f64::NAN);
        let of = |k: usize| arguments.get(k).map_or(nan, |value| **value);
        let (a, b) = (of(0), of(1));
        Ok(match operation {
            Operation::Negate => -a,
            Operation::Add => a + b,
            Operation::Subtract => a - b,
            Operation::Multiply => a * b,
            Operation::Divide => a / b,
            Operation::Power => power(a, b),
            Operation::Call(function) => match function {
                Function::Exp => a.exp(),
                Function::Ln => a.ln(),
                Function::Log10 => a.ln() / decimal(10.0).ln(),
                Function::Sqrt => a.sqrt(),
                Function::Abs | Function::Rms => a.abs(),
                Function::Sin => a.sin_cos().0,
                Function::Cos => a.sin_cos().1,
                Function::Tan => {
                    let (sin, cos) = a.sin_cos();
                    sin / cos
                }
                Function::Atan => a.atan(),
                // Nobody fits these to sixteen digits.
                Function::Asin | Function::Acos | Function::Sinh | Function::Cosh | Function::Tanh => {
                    TwoFloat::from(function.at(f64::from(a)))
                }
                Function::Min => extreme(arguments, f64::lt),
                Function::Max => extreme(arguments, f64::gt),
                Function::Mean | Function::Sum => a,
                Function::Count => TwoFloat::from(1.0),
            },
        })
    }
}

fn extreme(arguments: &[&TwoFloat], before: fn(&f64, &f64) -> bool) -> TwoFloat {
    let first = arguments.first().map_or(TwoFloat::from(f64::NAN), |value| **value);
    let chosen = |best: TwoFloat, value: &&TwoFloat| {
        let difference = f64::from(**value - best);
        if difference.is_nan() || before(&difference, &0.0) { **value } else { best }
    };
    arguments.iter().fold(first, chosen)
}

fn power(base: TwoFloat, exponent: TwoFloat) -> TwoFloat {
    const WHOLE_MAX: f64 = 1024.0;
    let whole = f64::from(exponent);
    if f64::from(exponent - TwoFloat::from(whole)) == 0.0 && whole.fract() == 0.0 && whole.abs() <= WHOLE_MAX {
        // Whole and below 1024.
        #[expect(clippy::cast_possible_truncation)]
        return base.powi(whole as i32);
    }
    (exponent * base.ln()).exp()
}

/// The decimal number that a double was written as: the shortest that is read as the same double, with twice its digits.
///
/// ```
/// use pneuval_models::expression::decimal;
/// // A tenth, not the double next to it: ten of them are one.
/// assert_eq!(f64::from(decimal(0.1) * decimal(10.0) - decimal(1.0)), 0.0);
/// assert_eq!(f64::from(decimal(-2.5e-3)), -2.5e-3);
/// ```
pub fn decimal(value: f64) -> TwoFloat {
    const EXACT_POWER_MAX: i32 = 22;
    const HALF: i64 = 1 << 26;
    let text = format!("{value:e}");
    let exact = || {
        let (mantissa, exponent) = text.split_once('e')?;
        let (whole, fraction) = mantissa.split_once('.').unwrap_or((mantissa, ""));
        // At most 17 digits, so the whole number is below 2^63; its two halves are exact doubles.
        let digits: i64 = format!("{whole}{fraction}").parse().ok()?;
        let power = exponent.parse::<i32>().ok()? - i32::try_from(fraction.len()).ok()?;
        let digits = TwoFloat::sum((digits / HALF) as f64 * HALF as f64, (digits % HALF) as f64);
        let ten = TwoFloat::from(10.0_f64.powi(power.abs().min(EXACT_POWER_MAX)));
        match power {
            0 => Some(digits),
            1..=22 => Some(digits * ten),
            -22..=-1 => Some(digits / ten),
            // Beyond it powers of ten are no doubles: the double itself has to do.
            _ => None,
        }
    };
    exact().unwrap_or_else(|| TwoFloat::from(value))
}
