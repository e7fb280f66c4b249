//! Many edges of like blur: one step from a guess, by equations that are solved once for each place of a guess in its pixel.
//!
//! The least squares of [`Blur::edge`] are linear in the brightness of the line: for a given blur, length and place of the guess the
//! unknowns are weighted sums of it. Guesses are rounded to a sixteenth of a pixel, and the blur to two hundredths of itself, so that a few
//! dozen sets of weights serve thousands of edges. Neither moves the result: the step is taken from the rounded guess, and what a blur
//! that is off by a hundredth does to a line is odd about the edge, a shift is even.

use super::{Blur, Edge, STEP_BLURS, UNKNOWNS, cholesky, substitute};

/// Places of a guess in its pixel.
const PHASES: usize = 16;

/// Blurs are rounded to powers of this.
const RATIO: f64 = 1.02;

/// Unknowns without that of the blur.
const N: usize = UNKNOWNS - 1;

/// Equations that are solved, by blur and by place in the pixel.
#[derive(Debug, Default)]
pub struct Kernels {
    blurs: Vec<(i32, [Option<Box<Kernel>>; PHASES])>,
}

/// A line of pixels to be read for an edge.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Window {
    /// The first px.
    pub from: usize,
    /// How many.
    pub length: usize,
    bin: i32,
    phase: usize,
}

/// The equations of one blur and place, solved.
#[derive(Debug)]
struct Kernel {
    blur_px: f64,
    /// The guess, in px from the line's first pixel.
    guess: f64,
    /// What each pixel adds to the unknowns.
    weights: Vec<[f64; N]>,
    /// Left sides of the normal equations.
    normal: [[f64; N]; N],
    /// Variance of what moves the edge, for noise of one step and a height of one blur.
    moved_variance: f64,
}

impl Kernels {
    /// Which pixels of a row to read for an edge near a guess; `None` where they would reach beyond its beginning.
    pub fn window(guess: f64, blur_px: f64) -> Option<Window> {
        let bin = (blur_px.ln() / RATIO.ln()).round();
        let sixteenths = (guess * PHASES as f64).round();
        // Blurs of a picture lie between a hundredth and thousands of px, and places below 2^40 px.
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        let (bin, sixteenths) = match (bin.abs() < 1e6, (0.0..1e12).contains(&sixteenths)) {
            (true, true) => (bin as i32, sixteenths as usize),
            _ => return None,
        };
        let side = side(RATIO.powi(bin));
        let from = (sixteenths / PHASES).checked_sub(side)?;
        Some(Window { from, length: 2 * side + 2, bin, phase: sixteenths % PHASES })
    }

    /// The edge of the line of a window, one step from its guess. `None` where the line shows none.
    pub fn edge(&mut self, blur: &Blur, window: Window, line: &[f32]) -> Option<Edge> {
        let known = self.blurs.iter().position(|(bin, _)| *bin == window.bin);
        let at = known.unwrap_or_else(|| {
            self.blurs.push((window.bin, std::array::from_fn(|_| None)));
            self.blurs.len() - 1
        });
        let slot = &mut self.blurs[at].1[window.phase];
        if slot.is_none() {
            *slot = Some(Box::new(Kernel::new(blur, window)?));
        }
        slot.as_ref()?.edge(line)
    }
}

/// How many px a line reaches to either side.
fn side(blur_px: f64) -> usize {
    // Between 2 and some thousand.
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
    let px = Blur::reach_px(blur_px).min(1e4) as usize;
    px
}

impl Kernel {
    fn new(blur: &Blur, window: Window) -> Option<Self> {
        let blur_px = RATIO.powi(window.bin);
        let guess = side(blur_px) as f64 + window.phase as f64 / PHASES as f64;
        let basis = |i: usize| {
            let z = (i as f64 - guess) / blur_px;
            let (below, slope) = blur.at(z);
            [1.0, below, z, slope]
        };
        let mut normal = [[0.0; N]; N];
        for i in 0..window.length {
            let b = basis(i);
            normal.iter_mut().zip(b).for_each(|(row, x)| row.iter_mut().zip(b).for_each(|(n, y)| *n += x * y));
        }
        let lower = cholesky(&normal)?;
        let weights = (0..window.length).map(|i| substitute(&lower, &basis(i))).collect();
        let unit = std::array::from_fn(|i| f64::from(u8::from(i == N - 1)));
        let moved_variance = substitute(&lower, &unit)[N - 1];
        Some(Self { blur_px, guess, weights, normal, moved_variance })
    }

    fn edge(&self, line: &[f32]) -> Option<Edge> {
        // From one of its values, so that squares keep their digits.
        let origin = f64::from(*line.first()?);
        let (mut solved, mut squares) = ([0.0; N], 0.0);
        for (value, weights) in line.iter().zip(&self.weights) {
            let value = f64::from(*value) - origin;
            solved.iter_mut().zip(weights).for_each(|(sum, w)| *sum += w * value);
            squares += value * value;
        }
        let height = solved[1];
        if height.abs() < 1e-6 {
            return None;
        }
        let row = |i: usize| solved.iter().zip(&self.normal[i]).map(|(s, n)| s * n).sum::<f64>();
        let explained: f64 = (0..N).map(|i| solved[i] * row(i)).sum();
        let limit = STEP_BLURS * self.blur_px;
        let at = self.guess + (-solved[N - 1] * self.blur_px / height).clamp(-limit, limit);
        let inside = at.is_finite() && at > 0.0 && at < (line.len() - 1) as f64;
        inside.then_some(Edge {
            at,
            std_per_step: (self.blur_px / height).abs() * self.moved_variance.sqrt(),
            levels: (origin + solved[0], origin + solved[0] + height),
            blur_step: 0.0,
            blur_weight: 0.0,
            left: ((squares - explained).max(0.0), line.len().saturating_sub(N)),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand_distr::{Distribution, StandardNormal};
    use rand_pcg::Pcg64Mcg;
    use statrs::distribution::{ContinuousCDF, Normal};

    #[test]
    fn one_step_is_that_of_the_whole_fit_wherever_the_guess_lies() {
        let (blur, mut kernels) = (Blur::new(), Kernels::default());
        let mut generator = Pcg64Mcg::new(5);
        for k in 0..200 {
            let (at, width) = (60.0 + 0.37 * f64::from(k), 1.1 + 0.013 * f64::from(k));
            let normal = Normal::new(at, width).unwrap();
            let row: Vec<f32> = (0..220)
                .map(|i| {
                    let z: f64 = StandardNormal.sample(&mut generator);
                    // Brightness is held in single precision.
                    #[allow(clippy::cast_possible_truncation)]
                    let value = (180.0 - 120.0 * normal.cdf(f64::from(i)) + 2.0 * z) as f32;
                    value
                })
                .collect();
            let window = Kernels::window(at + 0.3, width).unwrap();
            let line = &row[window.from..][..window.length];
            let fast = kernels.edge(&blur, window, line).unwrap();
            let whole = blur.edge(line, at + 0.3 - window.from as f64, width, false, 1).unwrap();
            let std = 2.0 * whole.std_per_step;
            assert!((fast.at - whole.at).abs() < 0.1 * std, "{k}: {fast:?} {whole:?}");
            assert!((fast.std_per_step / whole.std_per_step - 1.0).abs() < 0.03, "{k}: {fast:?} {whole:?}");
            assert!(
                (fast.left.0 / whole.left.0 - 1.0).abs() < 0.15 && fast.left.1 == whole.left.1,
                "{fast:?} {whole:?}"
            );
        }
        assert!(Kernels::window(3.0, 2.0).is_none() && Kernels::window(f64::NAN, 2.0).is_none());
        let window = Kernels::window(60.0, 1.5).unwrap();
        assert!(kernels.edge(&blur, window, &vec![7.0; window.length]).is_none());
        assert!(kernels.edge(&blur, window, &[]).is_none());
    }
}
