//! Intervals of the largest and of the mean size of values that are known with errors.

use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg64Mcg;
use statrs::function::erf::erf;

use super::coverage::{Variance, Z95};
use super::errors::Errors;
use crate::metrics::Interval;

/// Draws from which the simultaneous factor is taken: it is known to about 1 %.
const DRAWS: usize = 4000;

/// Values that may be the largest, so many standard uncertainties around it.
const REACH: f64 = 4.0;

/// Draws of all factors for all candidates; beyond it they are taken as independent, which is wider.
const DRAWN_MAX: usize = 100_000_000;

/// Values, one a point, and by how much each factor moves each of them.
#[derive(Debug, Clone, PartialEq)]
pub struct Moved {
    /// Values.
    pub values: Vec<f64>,
    /// Of each factor, by how much it moves every value.
    pub by: Vec<Vec<f64>>,
}

impl Moved {
    fn variance(&self, point: usize, errors: &Errors) -> Variance {
        errors.variance(self.by.iter().map(|by| by[point]))
    }

    /// The largest in size, and its interval.
    ///
    /// The interval holds all values that may be the largest at once: with c the 95 % quantile of the largest of their errors, each
    /// over its standard uncertainty, it reaches from the largest of |v| - c u to the largest of |v| + c u. It is conservative.
    /// Values that are no rival to the largest are not asked, so that one that stands out has the interval it would have alone.
    pub fn largest(&self, errors: &Errors) -> Option<(Interval, usize)> {
        let size = |i: usize| self.values[i].abs();
        let top = (0..self.values.len()).max_by(|&a, &b| size(a).total_cmp(&size(b)))?;
        let std: Vec<f64> = (0..self.values.len()).map(|i| self.variance(i, errors).half_width() / Z95).collect();
        let floor = (0..self.values.len()).map(|i| size(i) - REACH * std[i]).fold(0.0, f64::max);
        let rivals: Vec<usize> = (0..self.values.len()).filter(|&i| size(i) + REACH * std[i] >= floor).collect();
        let factor = self.simultaneous(&rivals);
        let lower = rivals.iter().map(|&i| size(i) - factor * std[i]).fold(0.0, f64::max);
        let upper = rivals.iter().map(|&i| size(i) + factor * std[i]).fold(size(top), f64::max);
        Some((Interval { value: size(top), lower: lower.min(size(top)), upper }, top))
    }

    /// How many standard uncertainties hold all of some values at once in 95 %: from draws of their errors with fixed seed.
    fn simultaneous(&self, points: &[usize]) -> f64 {
        let std = |i: usize| self.by.iter().map(|by| by[i] * by[i]).sum::<f64>().sqrt();
        let uncertain: Vec<(usize, f64)> = points.iter().map(|&i| (i, std(i))).filter(|(_, s)| *s > 0.0).collect();
        match uncertain.len() {
            0 | 1 => return Z95,
            n if n * self.by.len() * DRAWS > DRAWN_MAX => return independent(n),
            _ => {}
        }
        let mut generator = Pcg64Mcg::new(0x5eed);
        let mut largest = Vec::with_capacity(DRAWS);
        let mut errors = vec![0.0; uncertain.len()];
        for _ in 0..DRAWS {
            errors.fill(0.0);
            for by in &self.by {
                let z: f64 = StandardNormal.sample(&mut generator);
                for (error, (i, std)) in errors.iter_mut().zip(&uncertain) {
                    *error += z * by[*i] / std;
                }
            }
            largest.push(errors.iter().fold(0.0, |most: f64, e| most.max(e.abs())));
        }
        largest.sort_by(f64::total_cmp);
        largest[DRAWS * 95 / 100].max(Z95)
    }

    /// The mean size, its interval, and by how much each factor moves it.
    ///
    /// A value near zero adds its size whichever way its error goes: the mean size is then seen too large by
    /// `E|v + d| - |v|` (the folded normal distribution), by which the lower end is lowered, and its error counts as far as its
    /// sign is known, erf(|v|/√2 u).
    pub fn mean_size(&self, errors: &Errors) -> (Interval, Vec<f64>) {
        let n = self.values.len() as f64;
        let mut signs = Vec::with_capacity(self.values.len());
        let mut added = 0.0;
        for (i, value) in self.values.iter().enumerate() {
            let std = self.variance(i, errors).total().sqrt();
            if std <= 0.0 {
                signs.push(value.signum());
                continue;
            }
            let size = value.abs();
            let known = erf(size / (std::f64::consts::SQRT_2 * std));
            let folded = std * (2.0 / std::f64::consts::PI).sqrt() * (-0.5 * (size / std).powi(2)).exp() + size * known;
            added += (folded - size).max(0.0);
            signs.push(value.signum() * known);
        }
        let value = self.values.iter().map(|v| v.abs()).sum::<f64>() / n;
        let moved: Vec<f64> =
            self.by.iter().map(|by| by.iter().zip(&signs).map(|(by, sign)| by * sign).sum::<f64>() / n).collect();
        let half = errors.variance(moved.iter().copied()).half_width();
        (Interval { value, lower: (value - half - added / n).max(0.0), upper: value + half }, moved)
    }
}

/// The factor for so many independent values (Šidák).
fn independent(n: usize) -> f64 {
    use statrs::distribution::{ContinuousCDF, Normal};
    Normal::standard().inverse_cdf(0.5 + 0.5 * 0.95_f64.powf(1.0 / n as f64))
}

/// The interval of a number that each factor moves by so much.
pub fn linear(value: f64, moved: &[f64], errors: &Errors) -> Interval {
    let half = errors.variance(moved.iter().copied()).half_width();
    Interval { value, lower: value - half, upper: value + half }
}
