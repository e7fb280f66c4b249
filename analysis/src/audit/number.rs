//! Numbers with units, row by row.

use pneuval_models::expression::{Algebra, Function, Operation};

use super::dimension::Dimension;

/// A number or a column, in SI units.
#[derive(Debug, Clone, PartialEq)]
pub struct Rows {
    /// One value per row; a single one goes with every row.
    pub values: Vec<f64>,
    /// What it measures.
    pub dimension: Dimension,
}

impl Rows {
    /// A value in a row.
    pub fn at(&self, row: usize) -> f64 {
        let only = self.values.first().copied().unwrap_or(f64::NAN);
        if self.values.len() == 1 { only } else { self.values.get(row).copied().unwrap_or(f64::NAN) }
    }
}

/// Arithmetic with units: sums and functions refuse what does not fit, in words.
pub struct WithUnits;

impl Algebra for WithUnits {
    type Value = Rows;
    type Error = String;

    fn constant(&self, value: f64) -> Rows {
        Rows { values: vec![value], dimension: Dimension::NONE }
    }

    fn apply(&self, operation: Operation, arguments: &[&Rows]) -> Result<Rows, String> {
        let [a, rest @ ..] = arguments else { return Err("nothing to compute".to_owned()) };
        let b = rest.first().copied().unwrap_or(a);
        let rows = arguments.iter().map(|value| value.values.len()).max().unwrap_or(1);
        if arguments.iter().any(|value| value.values.len() != rows && value.values.len() != 1) {
            let lengths: Vec<String> = arguments.iter().map(|value| value.values.len().to_string()).collect();
            return Err(format!("columns of different lengths: {}", lengths.join(" and ")));
        }
        let two = |of: &dyn Fn(f64, f64) -> f64| (0..rows).map(|row| of(a.at(row), b.at(row))).collect::<Vec<f64>>();
        let one = |of: &dyn Fn(f64) -> f64| a.values.iter().map(|v| of(*v)).collect::<Vec<f64>>();
        let same = |what: &str| {
            if a.dimension.same(b.dimension) {
                Ok(a.dimension)
            } else {
                Err(format!("{what} {} and {}", a.dimension.symbol(), b.dimension.symbol()))
            }
        };
        let (values, dimension) = match operation {
            Operation::Negate => (one(&|x| -x), a.dimension),
            Operation::Add => (two(&|x, y| x + y), same("a sum of")?),
            Operation::Subtract => (two(&|x, y| x - y), same("a difference of")?),
            Operation::Multiply => (two(&|x, y| x * y), a.dimension.times(b.dimension)),
            Operation::Divide => (two(&|x, y| x / y), a.dimension.over(b.dimension)),
            Operation::Power => {
                if !b.dimension.is_none() {
                    return Err(format!("a power of {}", b.dimension.symbol()));
                }
                let dimension = match b.values.as_slice() {
                    _ if a.dimension.is_none() => Dimension::NONE,
                    [exponent] => a.dimension.power(*exponent),
                    _ => return Err(format!("powers of {} that differ from row to row", a.dimension.symbol())),
                };
                (two(&f64::powf), dimension)
            }
            Operation::Call(function) => return call(function, arguments, a, rows),
        };
        Ok(Rows { values, dimension })
    }
}

fn call(function: Function, arguments: &[&Rows], a: &Rows, rows: usize) -> Result<Rows, String> {
    if function.is_over_rows() {
        if let Some(other) = arguments.iter().find(|other| !other.dimension.same(a.dimension)) {
            return Err(format!("{} of {} and {}", function.name(), a.dimension.symbol(), other.dimension.symbol()));
        }
        // Of several arguments row by row, of one over its rows.
        let over: Vec<Vec<f64>> = if arguments.len() > 1 {
            (0..rows).map(|row| arguments.iter().map(|value| value.at(row)).collect()).collect()
        } else {
            vec![a.values.clone()]
        };
        let dimension = if function == Function::Count { Dimension::NONE } else { a.dimension };
        return Ok(Rows { values: over.iter().map(|values| reduce(function, values)).collect(), dimension });
    }
    let dimension = match function {
        Function::Abs => a.dimension,
        Function::Sqrt => a.dimension.power(0.5),
        _ if a.dimension.is_none() => Dimension::NONE,
        _ => return Err(format!("{} of {}", function.name(), a.dimension.symbol())),
    };
    Ok(Rows { values: a.values.iter().map(|v| function.at(*v)).collect(), dimension })
}

fn reduce(function: Function, values: &[f64]) -> f64 {
    let n = values.len() as f64;
    // A comparison loses a NaN, which must not get lost.
    let extreme = |of: fn(f64, f64) -> f64| {
        let pick = |a: f64, b: f64| if a.is_nan() || b.is_nan() { f64::NAN } else { of(a, b) };
        values.iter().copied().reduce(pick).unwrap_or(f64::NAN)
    };
    match function {
        Function::Min => extreme(f64::min),
        Function::Max => extreme(f64::max),
        Function::Mean => values.iter().sum::<f64>() / n,
        Function::Sum => values.iter().sum(),
        Function::Rms => (values.iter().map(|v| v * v).sum::<f64>() / n).sqrt(),
        Function::Count => n,
        // No other function is over rows.
        _ => f64::NAN,
    }
}

/// A number with at most so many significant digits, for formulas with numbers.
pub fn significant(value: f64, digits: usize) -> String {
    if value == 0.0 || !value.is_finite() {
        return format!("{value}");
    }
    let text = format!("{value:.*e}", digits.saturating_sub(1));
    let (mantissa, exponent) = text.split_once('e').unwrap_or((&text, "0"));
    let exponent: i32 = exponent.parse().unwrap_or(0);
    if (-5..7).contains(&exponent) {
        let decimals = i32::try_from(digits).unwrap_or(6) - 1 - exponent;
        let text = format!("{value:.*}", usize::try_from(decimals).unwrap_or(0));
        return if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text };
    }
    let mantissa = if mantissa.contains('.') { mantissa.trim_end_matches('0').trim_end_matches('.') } else { mantissa };
    format!("{mantissa}e{exponent}")
}
