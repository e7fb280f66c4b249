//! An edge along a line of pixels: where brightness goes half of its way, to a few hundredths of a pixel.
//!
//! ```text
//! I(t) = a + b Φ((t - x)/σ) + g (t - x)
//! ```
//!
//! Φ the normal distribution (blur of lens and pixel), a and b the levels, g the slope of the light, x the edge. Least squares with Gauss
//! and Newton's steps: for white noise that is all the line says. Its normal equations are built once for one or several steps, from a table of Φ and its slope.

mod kernels;

use std::sync::LazyLock;

use statrs::distribution::{Continuous, ContinuousCDF, Normal};

pub use kernels::{Kernels, Window};

/// Entries of the table for one standard deviation, and how many deviations it reaches.
const FINE: usize = 64;
const REACH: usize = 8;

/// Standard deviations of blur that a line should reach to either side of its edge, and px beyond.
const SIDE_BLURS: f64 = 4.5;
const SIDE_PX: f64 = 2.0;

/// A step is cut to so many standard deviations of the blur.
const STEP_BLURS: f64 = 1.5;

/// A step that is smaller than this share of the blur is the last: what it leaves is its square.
pub(super) const SETTLED_BLURS: f64 = 0.15;

/// Pivots below this share of their diagonal are nought: the line does not tell the parameters apart.
const SINGULAR: f64 = 1e-10;

/// Unknowns of the fit: level, height, slope, and what moves the edge and the blur.
const UNKNOWNS: usize = 5;

/// (Φ, φ) in steps of 1/[`FINE`].
static TABLE: LazyLock<Vec<(f64, f64)>> = LazyLock::new(|| {
    let normal = Normal::standard();
    let at = |i: usize| i as f64 / FINE as f64 - REACH as f64;
    (0..=2 * REACH * FINE + 1).map(|i| (normal.cdf(at(i)), normal.pdf(at(i)))).collect()
});

/// Φ and its slope, tabulated.
#[derive(Debug, Clone, Copy)]
pub struct Blur {
    table: &'static [(f64, f64)],
}

/// What a line says of its edge.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Edge {
    /// Where it is, in px from the line's first pixel.
    pub at: f64,
    /// Standard uncertainty for noise of one step of brightness (white), in px.
    pub std_per_step: f64,
    /// Brightness before and behind it.
    pub levels: (f64, f64),
    /// By how much the blur should be wider, in px; 0 where that is not asked.
    pub blur_step: f64,
    /// How much that counts: one over its variance for noise of one step.
    pub blur_weight: f64,
    /// Sum of squares that is left, and what it has of degrees of freedom.
    pub left: (f64, usize),
}

impl Default for Blur {
    fn default() -> Self {
        Self::new()
    }
}

impl Blur {
    /// The table.
    pub fn new() -> Self {
        Self { table: TABLE.as_slice() }
    }

    /// Φ and φ at so many standard deviations.
    fn at(&self, z: f64) -> (f64, f64) {
        let place = (z + REACH as f64) * FINE as f64;
        if place <= 0.0 {
            return (0.0, 0.0);
        }
        if place >= (2 * REACH * FINE) as f64 {
            return (1.0, 0.0);
        }
        // Above zero and below the length of the table.
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        let i = place as usize;
        let part = place - i as f64;
        let ((a, b), (c, d)) = (self.table[i], self.table[i + 1]);
        (a + part * (c - a), b + part * (d - b))
    }

    /// How far a line should reach to either side of an edge of this blur, in px.
    pub fn reach_px(blur_px: f64) -> f64 {
        SIDE_BLURS * blur_px + SIDE_PX
    }

    /// The edge of a line of pixels near a guess, for a blur of so many px; `with_blur` asks how much wider it should be; after so many steps at most. `None` where
    /// the line shows none.
    pub fn edge(&self, line: &[f32], guess: f64, blur_px: f64, with_blur: bool, steps: usize) -> Option<Edge> {
        let step = |x: f64| {
            if with_blur {
                self.step::<UNKNOWNS>(line, x, blur_px)
            } else {
                self.step::<{ UNKNOWNS - 1 }>(line, x, blur_px)
            }
        };
        let mut found = step(guess)?;
        let mut last = guess;
        for _ in 1..steps.max(1) {
            if (found.at - last).abs() < SETTLED_BLURS * blur_px {
                break;
            }
            last = found.at;
            found = step(last)?;
        }
        Some(found)
    }

    /// One step for the first N unknowns.
    fn step<const N: usize>(&self, line: &[f32], x: f64, blur_px: f64) -> Option<Edge> {
        if line.len() <= N + 1 || !x.is_finite() {
            return None;
        }
        let inverse = 1.0 / blur_px;
        // From the middle of the brightness, so that squares keep their digits.
        let origin = f64::from(line[0]);
        let mut normal = [[0.0; N]; N];
        let mut right = [0.0; N];
        let mut squares = 0.0;
        for (i, value) in line.iter().enumerate() {
            let z = (i as f64 - x) * inverse;
            let (below, slope) = self.at(z);
            let value = f64::from(*value) - origin;
            let all = [1.0, below, z, slope, z * slope];
            let basis: [f64; N] = std::array::from_fn(|k| all[k]);
            for row in 0..N {
                for column in 0..=row {
                    normal[row][column] += basis[row] * basis[column];
                }
                right[row] += basis[row] * value;
            }
            squares += value * value;
        }
        let (solved, moved_variance, blur_variance) = solve(&normal, &right)?;
        let height = solved[1];
        if height.abs() < 1e-6 {
            return None;
        }
        // What is left, by the normal equations; not below what rounding leaves of nothing.
        let explained: f64 = solved.iter().zip(&right).map(|(s, r)| s * r).sum();
        let left = (squares - explained).max(0.0);
        // The line is a + b Φ + ... - b/σ φ dx - b/σ z φ dσ.
        let limit = STEP_BLURS * blur_px;
        let step = (-solved[3] * blur_px / height).clamp(-limit, limit);
        let at = x + step;
        let blur_step = solved.get(4).map_or(0.0, |by| -by * blur_px / height);
        let scale = (blur_px / height).powi(2);
        let inside = at.is_finite() && at > 0.0 && at < (line.len() - 1) as f64;
        inside.then_some(Edge {
            at,
            std_per_step: (scale * moved_variance).sqrt(),
            levels: (origin + solved[0], origin + solved[0] + height),
            blur_step,
            blur_weight: if blur_variance > 0.0 { 1.0 / (scale * blur_variance) } else { 0.0 },
            left: (left, line.len() - N),
        })
    }
}

/// Solves symmetric equations, of which the lower half is given: the unknowns, and the variances of what moves the edge and the blur.
fn solve<const N: usize>(normal: &[[f64; N]; N], right: &[f64; N]) -> Option<([f64; N], f64, f64)> {
    let lower = cholesky(normal)?;
    let unit = |which: usize| substitute(&lower, &std::array::from_fn(|i| f64::from(u8::from(i == which))))[which];
    Some((substitute(&lower, right), unit(3), if N == UNKNOWNS { unit(4) } else { 0.0 }))
}

/// The lower factor of symmetric equations, of which the lower half is given.
fn cholesky<const N: usize>(normal: &[[f64; N]; N]) -> Option<[[f64; N]; N]> {
    let mut lower = [[0.0; N]; N];
    for i in 0..N {
        for j in 0..=i {
            let known: f64 = lower[i].iter().zip(&lower[j]).take(j).map(|(a, b)| a * b).sum();
            let sum = normal[i][j] - known;
            if i == j {
                if sum <= SINGULAR * normal[i][i] {
                    return None;
                }
                lower[i][i] = sum.sqrt();
            } else {
                lower[i][j] = sum / lower[j][j];
            }
        }
    }
    Some(lower)
}

/// The unknowns of one right side, by the lower factor.
fn substitute<const N: usize>(lower: &[[f64; N]; N], right: &[f64; N]) -> [f64; N] {
    let mut x = [0.0; N];
    for i in 0..N {
        let sum: f64 = (0..i).map(|k| lower[i][k] * x[k]).sum();
        x[i] = (right[i] - sum) / lower[i][i];
    }
    for i in (0..N).rev() {
        let sum: f64 = (i + 1..N).map(|k| lower[k][i] * x[k]).sum();
        x[i] = (x[i] - sum) / lower[i][i];
    }
    x
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand_distr::{Distribution, StandardNormal};
    use rand_pcg::Pcg64Mcg;

    /// Pixels of an edge, each the mean over its width, in a light that falls off.
    fn line(at: f64, blur: f64, levels: (f64, f64), slope: f64) -> Vec<f32> {
        let normal = Normal::new(0.0, blur).unwrap();
        let part = |i: f64| (0..20).map(|k| normal.cdf(i - 0.475 + 0.05 * f64::from(k) - at)).sum::<f64>() / 20.0;
        let of = |i: i32| levels.0 + (levels.1 - levels.0) * part(f64::from(i)) + slope * (f64::from(i) - at);
        #[allow(clippy::cast_possible_truncation)]
        (0..24).map(|i| of(i) as f32).collect()
    }

    #[test]
    fn an_edge_without_noise_is_found_to_a_thousandth_wherever_it_lies_in_its_pixel() {
        let blur = Blur::new();
        for k in 0..10 {
            let at = 11.2 + 0.1 * f64::from(k);
            for levels in [(190.0, 50.0), (20.0, 90.0)] {
                let line = line(at, 1.6, levels, 0.05);
                // A pixel's own width is a part of the blur.
                let wide = 1.6_f64.hypot(1.0 / 12.0_f64.sqrt());
                let found = blur.edge(&line, at + 1.3, wide, true, 6).unwrap();
                assert!((found.at - at).abs() < 1e-3, "{at}: {found:?}");
                assert!(found.blur_step.abs() < 5e-3 && (found.levels.0 - levels.0).abs() < 0.5, "{found:?}");
                // Taken for sharper than it is, it says so.
                let sharper = blur.edge(&line, at, 1.3, true, 4).unwrap();
                assert!(sharper.blur_step > 0.2 && (sharper.at - at).abs() < 5e-3, "{sharper:?}");
            }
        }
        assert!(blur.edge(&[100.0; 24], 12.0, 1.5, false, 3).is_none());
        assert!(blur.edge(&[0.0, 1.0], 0.5, 1.5, false, 3).is_none());
    }

    #[test]
    fn the_scatter_is_the_stated_one() {
        let blur = Blur::new();
        let mut generator = Pcg64Mcg::new(3);
        let clean = line(12.3, 1.8, (180.0, 60.0), 0.0);
        let (mut squares, mut stated, n) = (0.0, 0.0, 4000);
        for _ in 0..n {
            let noisy: Vec<f32> = clean
                .iter()
                .map(|v| {
                    let z: f32 = StandardNormal.sample(&mut generator);
                    v + 3.0 * z
                })
                .collect();
            let found = blur.edge(&noisy, 12.0, 1.82, false, 3).unwrap();
            squares += (found.at - 12.3).powi(2);
            stated += (3.0 * found.std_per_step).powi(2);
        }
        let share: f64 = squares / stated;
        assert!((share - 1.0).abs() < 0.08, "{share}");
    }
}
