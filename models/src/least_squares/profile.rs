//! Profile likelihood: how far a parameter can go while the others make the best of it.

use nalgebra::{DMatrix, DVector};

use super::{Minimum, Problem, minimise};
use crate::ModelError;

/// Where an interval ends.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Limit {
    /// Here the sum of squares reaches its limit.
    At(f64),
    /// Here the model, or what is physical, ends before the sum of squares reaches its limit.
    Edge(f64),
    /// Nowhere within a factor of a million: the data set no limit on this side.
    Open,
}

/// An interval of a parameter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ProfileInterval {
    /// Its lower end.
    pub lower: Limit,
    /// Its upper end.
    pub upper: Limit,
}

impl ProfileInterval {
    /// Whether a value lies inside; an open side reaches everywhere.
    pub fn contains(&self, value: f64) -> bool {
        let above = match self.lower {
            Limit::At(end) | Limit::Edge(end) => value >= end,
            Limit::Open => true,
        };
        let below = match self.upper {
            Limit::At(end) | Limit::Edge(end) => value <= end,
            Limit::Open => true,
        };
        above && below
    }
}

/// The values of one parameter at which the sum of squares, least over all others, is at most `(1 + rise)` of the least.
///
/// With `rise = t² / (n - p)`, t the quantile of Student's distribution, it is an interval of that confidence; of a linear
/// problem the same as `estimate ± t × standard error` (Bates and Watts 1988, Nonlinear Regression Analysis, section 6.1).
/// `first` is how far to look first, the standard error say.
pub fn profile(problem: &dyn Problem, minimum: &Minimum, which: usize, rise: f64, first: f64) -> ProfileInterval {
    let side = |sign: f64| one_side(problem, minimum, which, rise, sign * first.abs());
    ProfileInterval { lower: side(-1.0), upper: side(1.0) }
}

/// The sum of squares with a parameter held, least over the others, and where they are then.
///
/// # Errors
/// As [`minimise`].
pub(super) fn held(
    problem: &dyn Problem,
    which: usize,
    value: f64,
    start: &[f64],
) -> Result<(f64, Vec<f64>), ModelError> {
    let held = Held { problem, which, value };
    if start.is_empty() {
        return Ok((held.residuals(start)?.norm_squared(), vec![]));
    }
    let minimum = minimise(&held, start)?;
    Ok((minimum.sum_of_squares(), minimum.parameters))
}

fn one_side(problem: &dyn Problem, minimum: &Minimum, which: usize, rise: f64, first: f64) -> Limit {
    const DOUBLINGS_MAX: i32 = 60;
    const REFINEMENTS: usize = 60;
    const FAR: f64 = 1e6;
    let centre = minimum.parameters[which];
    let least = minimum.sum_of_squares();
    // Square roots rise nearly straight, which makes the search short: 0 at the minimum, 1 at the limit.
    let height = |sum: f64| ((sum - least).max(0.0) / (rise * least).max(f64::MIN_POSITIVE)).sqrt();
    let others = |all: &[f64]| -> Vec<f64> {
        all.iter().enumerate().filter(|(i, _)| *i != which).map(|(_, value)| *value).collect()
    };
    let mut inside = (centre, 0.0, others(&minimum.parameters));
    let mut step = if first == 0.0 || !first.is_finite() { 1e-3 * centre.abs().max(1e-300) } else { first };
    let mut outside = None;
    let mut edge = None;
    let reach = FAR * centre.abs().max(first.abs());
    for _ in 0..DOUBLINGS_MAX {
        let value = inside.0 + step;
        if (value - centre).abs() > reach {
            return Limit::Open;
        }
        match held(problem, which, value, &inside.2) {
            Ok((sum, at)) if height(sum) < 1.0 => {
                inside = (value, height(sum), at);
                // Where it hardly rises, further.
                step *= if inside.1 > 0.5 { 1.0 } else { 2.0 };
            }
            Ok((sum, _)) => {
                outside = Some((value, height(sum)));
                break;
            }
            Err(_) => {
                edge = Some(value);
                break;
            }
        }
    }
    if let Some(mut beyond) = edge {
        // Halve the way to where the model ends; the limit may lie before it.
        for _ in 0..REFINEMENTS {
            let value = 0.5 * (inside.0 + beyond);
            if (beyond - inside.0).abs() <= 1e-6 * (beyond - centre).abs() {
                break;
            }
            match held(problem, which, value, &inside.2) {
                Ok((sum, at)) if height(sum) < 1.0 => inside = (value, height(sum), at),
                Ok((sum, _)) => {
                    outside = Some((value, height(sum)));
                    break;
                }
                Err(_) => beyond = value,
            }
        }
        if outside.is_none() {
            return Limit::Edge(inside.0);
        }
    }
    let Some(mut outside) = outside else { return Limit::Open };
    for i in 0..REFINEMENTS {
        let width = outside.0 - inside.0;
        if width.abs() <= 1e-9 * (outside.0 - centre).abs() {
            break;
        }
        // A straight line between the heights, kept off the ends; every third time the middle, so that neither end stays for ever.
        let share = ((1.0 - inside.1) / (outside.1 - inside.1)).clamp(0.05, 0.95);
        let share = if i % 3 == 2 || !share.is_finite() { 0.5 } else { share };
        let value = inside.0 + share * width;
        match held(problem, which, value, &inside.2) {
            Ok((sum, at)) if height(sum) < 1.0 => inside = (value, height(sum), at),
            Ok((sum, _)) => outside = (value, height(sum)),
            // No minimum between two: what is known is the inner one.
            Err(_) => return Limit::Edge(inside.0),
        }
        if (outside.1 - inside.1).abs() < 1e-6 {
            break;
        }
    }
    let share = (1.0 - inside.1) / (outside.1 - inside.1);
    Limit::At(if share.is_finite() { inside.0 + share * (outside.0 - inside.0) } else { inside.0 })
}

/// A problem with one parameter held.
struct Held<'a> {
    problem: &'a dyn Problem,
    which: usize,
    value: f64,
}

impl Held<'_> {
    fn all(&self, others: &[f64]) -> Vec<f64> {
        let mut all = others.to_vec();
        all.insert(self.which, self.value);
        all
    }
}

impl Problem for Held<'_> {
    fn parameters(&self) -> usize {
        self.problem.parameters() - 1
    }

    fn residuals(&self, at: &[f64]) -> Result<DVector<f64>, ModelError> {
        self.problem.residuals(&self.all(at))
    }

    fn jacobian(&self, at: &[f64]) -> Result<DMatrix<f64>, ModelError> {
        Ok(self.problem.jacobian(&self.all(at))?.remove_column(self.which))
    }
}
