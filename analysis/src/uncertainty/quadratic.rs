//! The interval of a root mean square whose values are known with errors.
//!
//! With e the true residuals, d what the errors add (covariance Σ, all factors together) and T = |e + d|² what is seen over n points,
//!
//! ```text
//! E T = |e|² + tr Σ,  κ2 = 4 eᵀΣe + 2 tr Σ²,  κ3 = 24 eᵀΣ²e + 8 tr Σ³
//! ```
//!
//! Noise makes an RMSE too large, whatever the model: the corrected value is `√(max(0, T - tr Σ')/n)`, Σ' the part of the repeats. What
//! instruments and inputs add may lie either way, and is the interval's concern.
//!
//! The interval is all θ = |e|/√n for which T is no surprise on either side, 2.5 % each. Residuals of one length lie many ways; taken are
//! those that the seen ones x make most likely (hybrid resampling, Chuang and Lai 2000), all of one family,
//!
//! ```text
//! e(λ) = (1 + λ Σ)⁻¹ x
//! ```
//!
//! so that an error along one direction, a share of the response say, moves e along it: the slope of T there is that at e(λ), not at
//! x. Where T hardly depends on such a direction it says little of it: no e(λ) beyond 1.96 standard uncertainties of x is taken for the upper
//! end. The distribution of T is Pearson's (1959): a χ² of ν = 8 κ2³/κ3² degrees of freedom, moved and stretched to κ1 and κ2. Far above
//! the errors this is the usual interval; down among them it ends at zero, where an interval around the seen value never would.

use nalgebra::{DMatrix, SymmetricEigen};
use statrs::distribution::{ChiSquared, ContinuousCDF};

use super::coverage::{Z95, normal_cdf};
use super::errors::Errors;
use crate::metrics::Interval;

/// Halvings of the bracket: below the rounding of what they bracket.
const HALVINGS: u32 = 80;

/// Degrees of freedom from which a χ² is a normal distribution, to 0.0002 of a probability.
const NORMAL_FROM: f64 = 1e6;

/// What few repeats do not show of an error that moves every value by itself, as a share of the mean variance: no direction is known exactly.
const OWN_SHARE: f64 = 1e-3;

/// A root mean square with its interval.
#[derive(Debug, Clone, PartialEq)]
pub struct RootMeanSquare {
    /// Corrected for the errors, with the 95 % interval.
    pub interval: Interval,
    /// As seen.
    pub uncorrected: f64,
    /// By how much each factor moves it, one standard uncertainty each.
    pub moved: Vec<f64>,
}

/// The root mean square over `n` points of residuals, one or more components a point; `directions` are the factors of `errors`, each
/// over the same components.
pub fn root_mean_square(residuals: &[f64], n: usize, directions: &[Vec<f64>], errors: &Errors) -> RootMeanSquare {
    let points = n as f64;
    let seen = dot(residuals, residuals);
    let length = seen.sqrt();
    let squares = || directions.iter().map(|d| dot(d, d));
    // Along the residuals; where there are none, along the largest error.
    let along: Vec<f64> = if length > 0.0 {
        directions.iter().map(|d| dot(residuals, d) / length).collect()
    } else {
        squares().map(f64::sqrt).collect()
    };
    let moved: Vec<f64> = along.iter().map(|by| by / points.sqrt()).collect();
    let of_sizes = errors.variance(squares().map(f64::sqrt));
    let corrected = ((seen - of_sizes.type_a()).max(0.0) / points).sqrt();
    let uncorrected = (seen / points).sqrt();
    if of_sizes.total() <= 0.0 {
        let interval = Interval { value: uncorrected, lower: uncorrected, upper: uncorrected };
        return RootMeanSquare { interval, uncorrected, moved };
    }
    // Where the errors have nothing along the residuals, their sizes say who makes them.
    let of_along = errors.variance(along.iter().copied());
    let wider = if of_along.total() > 0.0 { of_along.factor() } else { of_sizes.factor() } / Z95;
    let spread = Spread::new(residuals, directions, wider * wider);
    let excess = (wider * wider - 1.0) * of_sizes.total();
    // Wider errors than the seen ones would also add more to what is seen.
    let lower = spread.length_at(0.975, seen + excess) / points.sqrt();
    // Less than the errors alone would show is luck, not knowledge.
    let upper = if seen < of_sizes.total() {
        spread.length_at(0.025, of_sizes.total() + excess)
    } else {
        spread.length_at(0.025, seen + excess).min(spread.length_within())
    };
    let upper = upper / points.sqrt();
    let interval = Interval { value: corrected, lower: lower.min(corrected), upper: upper.max(corrected) };
    RootMeanSquare { interval, uncorrected, moved }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// The seen residuals along the principal axes of the errors.
struct Spread {
    /// The variance along an axis, and the residuals' part along it.
    axes: Vec<(f64, f64)>,
    /// The square of what lies along none.
    beside: f64,
    /// The variance that any direction has at least, in the family alone.
    own: f64,
    /// The traces of Σ, Σ², Σ³.
    traces: [f64; 3],
}

impl Spread {
    fn new(residuals: &[f64], directions: &[Vec<f64>], scale: f64) -> Self {
        let m = directions.len();
        let gram = DMatrix::from_fn(m, m, |i, j| dot(&directions[i], &directions[j]));
        let eigen = SymmetricEigen::new(gram);
        let largest = eigen.eigenvalues.max();
        let by: Vec<f64> = directions.iter().map(|d| dot(d, residuals)).collect();
        // An axis is the sum of the directions by an eigenvector of their products, over the root of its eigenvalue.
        let axis = |k: usize| {
            let value = eigen.eigenvalues[k];
            let part = eigen.eigenvectors.column(k).iter().zip(&by).map(|(q, by)| q * by).sum::<f64>() / value.sqrt();
            (scale * value, part)
        };
        let mut axes: Vec<(f64, f64)> =
            (0..m).filter(|&k| eigen.eigenvalues[k] > m as f64 * f64::EPSILON * largest).map(axis).collect();
        axes.sort_by(|a, b| b.0.total_cmp(&a.0));
        // Residuals that have nothing along the first axis may have had.
        if let Some((variance, part)) = axes.first_mut() {
            *part = part.signum() * part.abs().max(1e-9 * variance.sqrt());
        }
        let beside = dot(residuals, residuals) - axes.iter().map(|(_, x)| x * x).sum::<f64>();
        let trace = |power: i32| axes.iter().map(|(s, _)| s.powi(power)).sum::<f64>();
        let traces = [trace(1), trace(2), trace(3)];
        let own = OWN_SHARE * traces[0] / residuals.len().max(1) as f64;
        Self { axes, beside: beside.max(0.0), own, traces }
    }

    /// e(λ): its square, and its squares weighted by Σ and Σ².
    fn at(&self, lambda: f64) -> [f64; 3] {
        let left = 1.0 / (1.0 + lambda * self.own);
        let mut sums = [self.beside * left * left, 0.0, 0.0];
        for (variance, part) in &self.axes {
            let e = part / (1.0 + lambda * (variance + self.own));
            sums[0] += e * e;
            sums[1] += variance * e * e;
            sums[2] += variance * variance * e * e;
        }
        sums
    }

    /// The probability that no more than `total` is seen where the residuals are e(λ).
    fn below(&self, lambda: f64, total: f64) -> f64 {
        let [square, linear, quadratic] = self.at(lambda);
        let k1 = square + self.traces[0];
        let k2 = 4.0 * linear + 2.0 * self.traces[1];
        let k3 = 24.0 * quadratic + 8.0 * self.traces[2];
        let freedom = 8.0 * k2.powi(3) / (k3 * k3);
        let at = freedom + (total - k1) * (2.0 * freedom / k2).sqrt();
        match ChiSquared::new(freedom) {
            Ok(chi) if freedom < NORMAL_FROM => chi.cdf(at.max(0.0)),
            _ => normal_cdf((total - k1) / k2.sqrt()),
        }
    }

    /// |e(λ)| where that probability is `p`; it rises with λ, as |e| falls.
    fn length_at(&self, p: f64, total: f64) -> f64 {
        let reaches = |lambda: f64| self.below(lambda, total) >= p;
        if reaches(0.0) {
            return self.length_from(self.least(), 0.0, &reaches);
        }
        let mut high = -self.least();
        while !reaches(high) {
            high *= 4.0;
            if high * self.own > 1e9 {
                return 0.0;
            }
        }
        self.length_from(0.0, high, &reaches)
    }

    /// The largest |e(λ)| that is within 1.96 standard uncertainties of what is seen.
    fn length_within(&self) -> f64 {
        let is_within = |lambda: f64| {
            let [square, linear, _] = self.at(lambda);
            lambda * lambda * (linear + self.own * square) <= Z95 * Z95
        };
        self.length_from(self.least(), 0.0, &is_within)
    }

    /// -1 over the largest variance: from there on |e(λ)| falls from infinity.
    fn least(&self) -> f64 {
        self.axes.first().map_or(-1.0, |(variance, _)| -1.0 / (variance + self.own))
    }

    /// |e(λ)| at the first λ from `low`, where it does not hold, to `high`, where it does.
    fn length_from(&self, mut low: f64, mut high: f64, holds: &dyn Fn(f64) -> bool) -> f64 {
        for _ in 0..HALVINGS {
            let middle = 0.5 * (low + high);
            if holds(middle) {
                high = middle;
            } else {
                low = middle;
            }
        }
        self.at(high)[0].sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::uncertainty::errors::{Cause, Source};
    use rand_distr::{Distribution, StandardNormal};
    use rand_pcg::Pcg64Mcg;

    /// How often the interval holds |e|/√n, and its mean width, where `directions` move e.
    fn covered(e: &[f64], directions: &[Vec<f64>]) -> (f64, f64) {
        let mut errors = Errors::default();
        let zeros = || vec![0.0; e.len()];
        errors.add(Source::new("gauge", Cause::Instrument), directions.iter().map(|d| (zeros(), d.clone())));
        let mut generator = Pcg64Mcg::new(11);
        let (mut inside, mut width, trials) = (0, 0.0, 4000);
        let truth = (dot(e, e) / e.len() as f64).sqrt();
        for _ in 0..trials {
            let mut seen = e.to_vec();
            for direction in directions {
                let z: f64 = StandardNormal.sample(&mut generator);
                seen.iter_mut().zip(direction).for_each(|(x, d)| *x += z * d);
            }
            let Interval { lower, upper, .. } = root_mean_square(&seen, e.len(), directions, &errors).interval;
            inside += u32::from(lower <= truth && truth <= upper);
            width += upper - lower;
        }
        (f64::from(inside) / f64::from(trials), width / f64::from(trials))
    }

    fn own(n: usize, size: f64) -> Vec<Vec<f64>> {
        (0..n).map(|i| (0..n).map(|j| if i == j { size } else { 0.0 }).collect()).collect()
    }

    #[test]
    fn the_interval_holds_the_truth_far_above_the_errors_among_them_and_where_one_moves_all_points_sideways() {
        let far: Vec<f64> = (0..12).map(|i| 10.0 + f64::from(i)).collect();
        let (share, width) = covered(&far, &own(12, 1.0));
        assert!((0.94..0.96).contains(&share), "far: {share}");
        // The usual one: 2 · 1.96 u, u = 1/√n.
        assert!((width / (2.0 * Z95 / 12.0_f64.sqrt()) - 1.0).abs() < 0.02, "{width}");
        let (share, _) = covered(&[0.0; 12], &own(12, 1.0));
        assert!((0.96..=1.0).contains(&share), "a model that is right: {share}");
        let near: Vec<f64> = (0..12).map(|i| if i % 2 == 0 { 1.0 } else { -0.7 }).collect();
        let (share, _) = covered(&near, &own(12, 1.0));
        assert!((0.93..0.98).contains(&share), "near: {share}");
        // Errors share a direction that is square to the residuals, or nearly.
        let across: Vec<f64> = (0..12).map(|i| if i % 2 == 0 { 4.0 } else { -4.0 }).collect();
        for lean in [0.0, 0.3, 1.0] {
            let e: Vec<f64> = across.iter().map(|e| e + lean).collect();
            let mut directions = own(12, 0.05);
            directions.push(vec![0.4; 12]);
            let (share, _) = covered(&e, &directions);
            assert!((0.93..1.0).contains(&share), "{lean}: {share}");
        }
    }

    #[test]
    fn without_errors_it_is_the_value_and_without_residuals_it_begins_at_zero() {
        let none = root_mean_square(&[3.0, -4.0], 2, &[], &Errors::default());
        let value = 12.5_f64.sqrt();
        assert_eq!(none.interval, Interval { value, lower: value, upper: value });
        let mut errors = Errors::default();
        errors.add(Source::new("gauge", Cause::Instrument), [(vec![0.0; 2], vec![1.0, 1.0])]);
        let found = root_mean_square(&[0.0, 0.0], 2, &[vec![1.0, 1.0]], &errors).interval;
        assert!(found.lower <= 0.0 && found.value <= 0.0 && (1.0..4.0).contains(&found.upper), "{found:?}");
    }
}
