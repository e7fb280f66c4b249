//! The equations of scales. Each is evaluated in doubles and in an order of operations that gives the same last digit as others do.

use super::Unsupported;
use super::stated::Stated;
use super::strain::Strain;
use super::thermistor::Thermistor;

/// A checked equation: no input makes it fail.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Equation {
    Linear(Linear),
    Polynomial(Polynomial),
    Table(Table),
    Thermistor(Thermistor),
    Strain(Strain),
}

impl Equation {
    /// The equation of a scale. `left` is how many numbers tables and polynomials may still have.
    pub(super) fn of(stated: &Stated, left: &mut usize) -> Result<Self, Unsupported> {
        match stated.kind {
            "Linear" => Linear::of(stated).map(Self::Linear),
            "Polynomial" => Polynomial::of(stated, left).map(Self::Polynomial),
            "Table" => Table::of(stated, left).map(Self::Table),
            "Thermistor" => Thermistor::of(stated).map(Self::Thermistor),
            "Strain" => Strain::of(stated).map(Self::Strain),
            _ => Err(stated.unsupported("has no equation")),
        }
    }

    /// Adds what it gives of `values` to `out`.
    pub(super) fn apply(&self, values: &[f64], out: &mut Vec<f64>) {
        match self {
            Self::Linear(linear) => linear.apply(values, out),
            Self::Polynomial(polynomial) => polynomial.apply(values, out),
            Self::Table(table) => table.apply(values, out),
            Self::Thermistor(thermistor) => thermistor.apply(values, out),
            Self::Strain(strain) => strain.apply(values, out),
        }
    }
}

/// A straight line.
///
/// ```text
/// y = m x + b
/// ```
///
/// | symbol | property      | unit            |
/// |--------|---------------|-----------------|
/// | m      | `Slope`       | of y per unit x |
/// | b      | `Y_Intercept` | of y            |
///
/// Product and sum are rounded one after the other.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Linear {
    slope: f64,
    intercept: f64,
}

impl Linear {
    fn of(stated: &Stated) -> Result<Self, Unsupported> {
        Ok(Self { slope: stated.number("Slope")?, intercept: stated.number("Y_Intercept")? })
    }

    fn apply(self, values: &[f64], out: &mut Vec<f64>) {
        out.extend(values.iter().map(|x| x * self.slope + self.intercept));
    }
}

/// A polynomial.
///
/// ```text
/// y = c0 + c1 x + c2 x² + ..
/// ```
///
/// | symbol | property                              | unit              |
/// |--------|---------------------------------------|-------------------|
/// | ci     | `Coefficients[i]`                     | of y per unit x^i |
/// |        | `Coefficients_Size`, 4 where absent   |                   |
///
/// Without a coefficient y is 0. Evaluated from the highest power down (Horner), which starts with `c + 0 x` as numpy's does: what is
/// infinite gives NaN also where there is only c0.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Polynomial {
    /// From c0 up.
    coefficients: Vec<f64>,
}

/// Values that go through a polynomial side by side.
const LANES: usize = 8;

impl Polynomial {
    fn of(stated: &Stated, left: &mut usize) -> Result<Self, Unsupported> {
        let count = stated.count_or_none("Coefficients_Size")?.unwrap_or(4);
        Ok(Self { coefficients: stated.numbers("Coefficients", count, left)? })
    }

    fn apply(&self, values: &[f64], out: &mut Vec<f64>) {
        let Some((highest, lower)) = self.coefficients.split_last() else {
            out.extend(values.iter().map(|_| 0.0));
            return;
        };
        let (blocks, rest) = values.as_chunks::<LANES>();
        for x in blocks {
            // Several values side by side for each coefficient: this is what vectorises.
            let mut y = x.map(|x| highest + x * 0.0);
            for coefficient in lower.iter().rev() {
                for (y, x) in y.iter_mut().zip(x) {
                    *y = coefficient + *y * x;
                }
            }
            out.extend_from_slice(&y);
        }
        out.extend(rest.iter().map(|x| lower.iter().rev().fold(highest + x * 0.0, |y, c| c + y * x)));
    }
}

/// Straight lines between points.
///
/// ```text
/// y = yi + (x - xi) (yi+1 - yi) / (xi+1 - xi)      xi <= x < xi+1
/// ```
///
/// | symbol | property                                     | unit |
/// |--------|----------------------------------------------|------|
/// | xi     | `Pre_Scaled_Values[i]`, `.._Size`            | of x |
/// | yi     | `Scaled_Values[i]`, `.._Size`                | of y |
///
/// Before the first point and beyond the last y is that of this point. The xi go up, or all go down. The difference quotient is
/// rounded before it is multiplied.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Table {
    /// Going up.
    x: Vec<f64>,
    y: Vec<f64>,
    /// From each point to the next.
    slopes: Vec<f64>,
}

impl Table {
    fn of(stated: &Stated, left: &mut usize) -> Result<Self, Unsupported> {
        let (count, scaled) = (stated.count("Pre_Scaled_Values_Size")?, stated.count("Scaled_Values_Size")?);
        if count != scaled {
            return Err(stated.unsupported(&format!("has {count} values to scale and {scaled} that are scaled")));
        }
        if count == 0 {
            return Err(stated.unsupported("has no points"));
        }
        let mut x = stated.numbers("Pre_Scaled_Values", count, left)?;
        let mut y = stated.numbers("Scaled_Values", count, left)?;
        if x.first() > x.last() {
            x.reverse();
            y.reverse();
        }
        if !x.is_sorted_by(|a, b| a < b) {
            return Err(stated.unsupported("has values to scale that neither all go up nor all go down"));
        }
        let slopes = x.windows(2).zip(y.windows(2)).map(|(x, y)| (y[1] - y[0]) / (x[1] - x[0])).collect();
        Ok(Self { x, y, slopes })
    }

    fn apply(&self, values: &[f64], out: &mut Vec<f64>) {
        let (x, y) = (&self.x[..], &self.y[..]);
        // Neighbours often lie between the same points.
        let mut at = 0;
        out.extend(values.iter().map(|&value| {
            if value.is_nan() {
                return f64::NAN;
            }
            let is_here = x[at] <= value && x.get(at + 1).is_none_or(|next| value < *next);
            if !is_here {
                // Before the first point it is that of the first.
                let Some(found) = x.partition_point(|x| *x <= value).checked_sub(1) else {
                    at = 0;
                    return y[0];
                };
                at = found;
            }
            match self.slopes.get(at) {
                Some(slope) if value > x[at] => slope * (value - x[at]) + y[at],
                // On a point, or beyond the last.
                _ => y[at],
            }
        }));
    }
}
