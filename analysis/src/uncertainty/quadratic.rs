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
//! The interval is all θ = |e|/√n along the seen direction of e for which T is no surprise on either side, 2.5 % each. The
//! distribution of T is that of Jensen and Solomon (1972): (T/κ1)^h is normal with h = 1 - κ1 κ3/(3 κ2²). Far above the errors
//! this is the usual interval; down among them it ends at zero, where an interval around the seen value never would.

use super::coverage::{Z95, coverage_factor, normal_cdf};
use super::errors::Errors;
use crate::metrics::Interval;

/// Halvings of the bracket: below the rounding of what they bracket.
const HALVINGS: u32 = 60;

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
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let seen = dot(residuals, residuals);
    let length = seen.sqrt();
    let m = directions.len();
    let gram: Vec<Vec<f64>> = (0..m).map(|i| (0..m).map(|j| dot(&directions[i], &directions[j])).collect()).collect();
    // Along the residuals; where there are none, along the largest error.
    let along: Vec<f64> = if length > 0.0 {
        directions.iter().map(|d| dot(residuals, d) / length).collect()
    } else {
        (0..m).map(|i| gram[i][i].sqrt()).collect()
    };
    let moved: Vec<f64> = along.iter().map(|by| by / points.sqrt()).collect();
    let trace = |power: u32| -> f64 {
        match power {
            1 => (0..m).map(|i| gram[i][i]).sum(),
            2 => gram.iter().flatten().map(|g| g * g).sum(),
            _ => (0..m).map(|i| (0..m).map(|j| gram[i][j] * dot(&gram[j], &gram[i])).sum::<f64>()).sum(),
        }
    };
    let (type_a, type_b) = errors.variances(along.iter().copied());
    // Where the errors have nothing along the residuals, their sizes say who makes them.
    let (type_a, type_b) =
        if type_a + type_b > 0.0 { (type_a, type_b) } else { errors.variances((0..m).map(|i| gram[i][i].sqrt())) };
    let wider = coverage_factor(type_a, type_b, errors.repeats) / Z95;
    let (tr1, tr2, tr3) = (trace(1), trace(2), trace(3));
    let (quadratic, cubic) = (dot(&along, &along), {
        let through: Vec<f64> = gram.iter().map(|row| dot(row, &along)).collect();
        dot(&along, &through)
    });
    let (noise, _) = errors.variances((0..m).map(|i| gram[i][i].sqrt()));
    let corrected = ((seen - noise).max(0.0) / points).sqrt();
    let uncorrected = (seen / points).sqrt();
    if tr1 <= 0.0 {
        let interval = Interval { value: uncorrected, lower: uncorrected, upper: uncorrected };
        return RootMeanSquare { interval, uncorrected, moved };
    }
    let w2 = wider * wider;
    // The probability that no more than `total` is seen where the true residuals have this square.
    let below = |square: f64, total: f64| {
        let k1 = square + w2 * tr1;
        let k2 = 4.0 * square * w2 * quadratic + 2.0 * w2 * w2 * tr2;
        let k3 = 24.0 * square * w2 * w2 * cubic + 8.0 * w2 * w2 * w2 * tr3;
        // Wider errors than the seen ones would also add more to what is seen.
        let total = total + (w2 - 1.0) * tr1;
        if k2 <= 0.0 {
            return f64::from(u8::from(total >= k1));
        }
        let h = 1.0 - k1 * k3 / (3.0 * k2 * k2);
        let spread = k2.sqrt() / k1;
        if h.abs() < 1e-4 {
            return normal_cdf(((total / k1).ln() + 0.5 * spread * spread) / spread);
        }
        let middle = 1.0 + 0.5 * h * (h - 1.0) * spread * spread;
        let at = ((total / k1).powf(h) - middle) / (h.abs() * spread);
        normal_cdf(if h > 0.0 { at } else { -at })
    };
    // The square at which the probability falls to `p`; it falls with the square.
    let square_at = |p: f64, total: f64| {
        if below(0.0, total) <= p {
            return 0.0;
        }
        let step = tr1 * w2 + total;
        let (mut low, mut high) = (0.0, step);
        while below(high, total) > p && high.is_finite() {
            high *= 2.0;
        }
        for _ in 0..HALVINGS {
            let middle = 0.5 * (low + high);
            if below(middle, total) > p {
                low = middle;
            } else {
                high = middle;
            }
        }
        0.5 * (low + high)
    };
    let lower = (square_at(0.975, seen) / points).sqrt();
    // Less than the errors alone would show is luck, not knowledge.
    let upper = (square_at(0.025, seen.max(tr1)) / points).sqrt();
    let interval = Interval { value: corrected, lower: lower.min(corrected), upper: upper.max(corrected) };
    RootMeanSquare { interval, uncorrected, moved }
}
