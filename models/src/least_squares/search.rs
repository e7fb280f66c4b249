//! The lowest of the minima that many starts lead to.

use super::{Minimum, Problem, minimise};
use crate::ModelError;

/// What a search found.
#[derive(Debug, Clone)]
pub struct Search {
    /// The lowest minimum.
    pub best: Minimum,
    /// What the given start itself led to.
    pub given: Result<Minimum, ModelError>,
    /// How many starts there were, the given one included.
    pub starts: usize,
    /// How many of them led to a minimum.
    pub settled: usize,
    /// How many of them led to the lowest sum of squares.
    pub at_best: usize,
}

/// Two sums of squares that differ by less than this share are one minimum.
const SAME_SHARE: f64 = 1e-6;

/// The lowest minimum from a start, and from others round it.
///
/// `linear` names parameters in which the residuals are linear: from every start they are solved for first (variable projection at
/// the start, Golub and Pereyra 1973, doi:10.1137/0710036), so that only the others have to be guessed. Those are varied by factors up
/// to 2, 10 and 100 on a Halton sequence: the same starts every time. Of minima of the same height, that of the given start stays.
///
/// # Errors
/// As [`minimise`] says of the given start, if no start leads to a minimum.
pub fn search(problem: &dyn Problem, start: &[f64], linear: &[usize], starts: usize) -> Result<Search, ModelError> {
    let given = minimise(problem, start);
    let nonlinear: Vec<usize> = (0..start.len()).filter(|i| !linear.contains(i)).collect();
    let mut minima: Vec<Minimum> = given.iter().cloned().collect();
    let mut tried = 1;
    for i in 0..starts.saturating_sub(1) {
        let mut varied = start.to_vec();
        for (k, &parameter) in nonlinear.iter().enumerate() {
            // The first is the given start with its linear parameters solved for.
            let factor_max: f64 = [1.0, 2.0, 10.0, 100.0][if i == 0 { 0 } else { 1 + (i - 1) % 3 }];
            let share = 2.0 * halton(i, k) - 1.0;
            varied[parameter] = if start[parameter] == 0.0 {
                share * (factor_max - 1.0)
            } else {
                start[parameter] * factor_max.powf(share)
            };
        }
        tried += 1;
        if let Some(solved) = solve_linear(problem, &varied, linear)
            && let Ok(minimum) = minimise(problem, &solved)
        {
            minima.push(minimum);
        }
        // Without anything to guess there is one start.
        if nonlinear.is_empty() {
            break;
        }
    }
    let determined = |minimum: &&Minimum| minimum.statistics().is_ok();
    let sums: Vec<f64> = minima.iter().map(Minimum::sum_of_squares).collect();
    // What the data determine comes before what they do not: a flat valley at infinity is no answer while there is one.
    let lowest = |of: &mut dyn Iterator<Item = &Minimum>| of.map(Minimum::sum_of_squares).min_by(f64::total_cmp);
    let target = lowest(&mut minima.iter().filter(determined)).or_else(|| lowest(&mut minima.iter()));
    let Some(target) = target else {
        // A parameter without influence, or two that do the same, are the better reason.
        if let (Ok(residuals), Ok(jacobian)) = (problem.residuals(start), problem.jacobian(start))
            && residuals.len() >= start.len()
        {
            Minimum { parameters: start.to_vec(), residuals, jacobian, iterations: 0 }.statistics()?;
        }
        // Nothing settled, so the given start did not.
        return Err(given.err().unwrap_or(ModelError::NotConverged { method: "Levenberg-Marquardt", iterations: 0 }));
    };
    let same = |sum: f64| sum <= target + SAME_SHARE * target.abs() + f64::MIN_POSITIVE;
    let settled = minima.len();
    let at_best = sums.iter().filter(|sum| same(**sum)).count();
    // The first of the lowest: the given start stands first.
    let best = minima.iter().find(|m| same(m.sum_of_squares()) && m.statistics().is_ok());
    let Some(best) = best.or_else(|| minima.iter().find(|m| same(m.sum_of_squares()))).cloned() else {
        return Err(ModelError::NotConverged { method: "Levenberg-Marquardt", iterations: 0 });
    };
    Ok(Search { best, given, starts: tried, settled, at_best })
}

/// The start with the linear parameters that suit the others best; `None` where the model has no value, or they are not determined.
fn solve_linear(problem: &dyn Problem, start: &[f64], linear: &[usize]) -> Option<Vec<f64>> {
    let mut solved = start.to_vec();
    if linear.is_empty() {
        return Some(solved);
    }
    let residuals = problem.residuals(start).ok()?;
    let design = problem.jacobian(start).ok()?.select_columns(linear);
    if !(residuals.iter().all(|r| r.is_finite()) && design.iter().all(|d| d.is_finite())) {
        return None;
    }
    let step = design.svd(true, true).solve(&-residuals, 1e-12).ok()?;
    for (&parameter, step) in linear.iter().zip(step.iter()) {
        solved[parameter] += step;
    }
    Some(solved)
}

/// Halton's sequence in a dimension: evenly spread, and the same every time.
pub(crate) fn halton(index: usize, dimension: usize) -> f64 {
    const PRIMES: [usize; 12] = [2, 3, 5, 7, 11, 13, 17, 19, 23, 29, 31, 37];
    let base = PRIMES[dimension % PRIMES.len()];
    // The first terms of neighbouring bases resemble one another.
    let mut rest = index + 20;
    let (mut share, mut value) = (1.0, 0.0);
    while rest > 0 {
        share /= base as f64;
        value += share * (rest % base) as f64;
        rest /= base;
    }
    value
}
