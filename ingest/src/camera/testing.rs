//! Pictures of shapes for tests: coverage by points, blurred as a lens does.

use statrs::distribution::{ContinuousCDF, Normal};

/// Shares of pixels that lie in a shape, 8 by 8 points each near its outline, blurred by a normal distribution.
pub(super) fn shares((w, h): (usize, usize), is_in: &dyn Fn(f64, f64) -> bool, blur: f64) -> Vec<f64> {
    let part = |i: usize| {
        let (x, y) = ((i % w) as f64, (i / w) as f64);
        let corners =
            [(-0.5, -0.5), (0.5, -0.5), (-0.5, 0.5), (0.5, 0.5), (0.0, 0.0)].map(|(a, b)| is_in(x + a, y + b));
        if corners.iter().all(|c| *c == corners[0]) {
            return f64::from(u8::from(corners[0]));
        }
        let at = |k: usize| (k as f64 + 0.5) / 8.0 - 0.5;
        (0..64).filter(|k| is_in(x + at(k % 8), y + at(k / 8))).count() as f64 / 64.0
    };
    let sharp: Vec<f64> = (0..w * h).map(part).collect();
    // The share of the normal distribution in each pixel; along rows, then along columns.
    let normal = Normal::new(0.0, blur).unwrap();
    let weights: Vec<f64> =
        (-12..=12).map(|k| normal.cdf(f64::from(k) + 0.5) - normal.cdf(f64::from(k) - 0.5)).collect();
    let at = |of: &[f64], along: usize, length: usize, start: usize, i: usize| -> f64 {
        let value =
            |(k, weight): (usize, &f64)| weight * of[start + (i + k).saturating_sub(12).min(length - 1) * along];
        weights.iter().enumerate().map(value).sum()
    };
    let rows: Vec<f64> = (0..w * h).map(|i| at(&sharp, 1, w, i / w * w, i % w)).collect();
    (0..w * h).map(|i| at(&rows, w, h, i % w, i / w)).collect()
}
