//! One corner, fitted.
//!
//! First where all edges nearby point (Förstner and Gülch, 1987): every slope of brightness g at x says g·(x - p) = 0. Then least squares
//! of what a lens makes of four squares,
//!
//! ```text
//! I(p + d) = (m + c erf(n₁·d / √2σ) erf(n₂·d / √2σ)) (1 + t·d)
//! ```
//!
//! n₁, n₂ across the two edges, σ the blur, m and c the middle and half the contrast, t the slope of the light. Weights fall to nought at
//! the rim of the window, so that no pixel comes or goes as p moves. The covariance is that of these weights for white noise of the size that is left
//! over. As the squares and the window look the same turned by half, whatever the model misses of blur does not move p.

use nalgebra::{Matrix2, SMatrix, SVector, Vector2};
use statrs::function::erf::erf;

use super::super::picture::{Picture, Place};
use super::Corner;

/// The window's radius: a share of the distance to the nearest edges, in px at least and at most.
const WINDOW: f64 = 0.5;
const WINDOW_MIN_PX: f64 = 2.5;
const WINDOW_MAX_PX: f64 = 20.0;

/// Steps of the first and of the second part, at most, and the length of the last one, in px.
const STEPS_FIRST: usize = 20;
const STEPS_SECOND: usize = 60;
const FOUND_PX: f64 = 5e-4;

/// How far a corner may move from where its neighbourhood has it, in px of the reduced picture, and as a share of the window.
const MOVED_REDUCED_PX: f64 = 1.5;
const MOVED: f64 = 0.6;

/// Contrast, in steps, and blur as a share of the window: beyond, the model says nothing.
const CONTRAST_MIN: f64 = 1.5;
const BLUR_MAX: f64 = 0.8;

/// Place, directions of two edges, logarithm of the blur, middle, half contrast, slope of the light.
const UNKNOWNS: usize = 9;

type Unknowns = SVector<f64, UNKNOWNS>;
type Normal = SMatrix<f64, UNKNOWNS, UNKNOWNS>;

/// The corner near a place and the radius of its window; its neighbours along a row and along a column, as far as there are.
pub(super) fn fit(
    picture: &Picture,
    near: Place,
    along: [Option<Place>; 2],
    across: [Option<Place>; 2],
    factor: f64,
) -> Option<(Corner, f64)> {
    let mut to_edges = f64::MAX;
    for u in along.iter().flatten() {
        for v in across.iter().flatten() {
            to_edges = to_edges.min((u.x * v.y - u.y * v.x).abs() / u.norm().max(v.norm()));
        }
    }
    let radius = (WINDOW * to_edges).min(WINDOW_MAX_PX);
    let step = |of: [Option<Place>; 2]| match of {
        [Some(a), Some(b)] => Some(b - a),
        [a, b] => a.or(b),
    };
    let (u, v) = (step(along)?, step(across)?);
    let is_inside = |at: Place| {
        let (x, y) = ((picture.width() - 1) as f64, (picture.height() - 1) as f64);
        at.x >= radius && at.y >= radius && at.x <= x - radius && at.y <= y - radius
    };
    if radius < WINDOW_MIN_PX || !is_inside(near) {
        return None;
    }
    let reach = (MOVED_REDUCED_PX * factor.max(1.0)).min(MOVED * radius).max(1.0);
    let sound = |at: &Place| (at - near).norm() < reach && is_inside(*at);
    let first = by_slopes(picture, near, radius).filter(sound).unwrap_or(near);
    let fitted = Model::new(picture, first, radius, u, v)?.fitted(picture, radius)?;
    sound(&fitted.at).then_some((fitted, radius))
}

/// A pixel and its weight, one in the middle of the window and nought at its rim.
fn pixels(at: Place, radius: f64) -> impl Iterator<Item = (usize, usize, Vector2<f64>, f64)> {
    // The window lies in the picture.
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
    let range =
        move |middle: f64| (middle - radius).max(0.0).ceil() as usize..=(middle + radius).max(0.0).floor() as usize;
    range(at.y).flat_map(move |y| {
        range(at.x).filter_map(move |x| {
            let d = Vector2::new(x as f64, y as f64) - at;
            let share = d.norm_squared() / (radius * radius);
            (share < 1.0).then_some((x, y, d, (1.0 - share) * (1.0 - share)))
        })
    })
}

/// Where the edges nearby meet.
fn by_slopes(picture: &Picture, near: Place, radius: f64) -> Option<Place> {
    let mut at = near;
    for _ in 0..STEPS_FIRST {
        let (mut normal, mut right) = (Matrix2::zeros(), Vector2::zeros());
        for (x, y, d, weight) in pixels(at, radius) {
            let luma = |x: usize, y: usize| f64::from(picture.luma(x, y));
            let across = luma(x + 1, y) - luma(x.saturating_sub(1), y);
            let down = luma(x, y + 1) - luma(x, y.saturating_sub(1));
            let slope = Vector2::new(across, down);
            normal += slope * slope.transpose() * weight;
            right += slope * (slope.dot(&d) * weight);
        }
        let step = normal.try_inverse()? * right;
        at += step;
        if !(step.norm() < radius && (at - near).norm() < radius) {
            return None;
        }
        if step.norm() < FOUND_PX {
            break;
        }
    }
    Some(at)
}

#[derive(Debug, Clone, Copy)]
struct Model {
    at: Place,
    /// Directions of the edges' normals, in rad.
    angles: [f64; 2],
    ln_blur: f64,
    middle: f64,
    half: f64,
    light: Vector2<f64>,
}

impl Model {
    fn new(picture: &Picture, at: Place, radius: f64, u: Vector2<f64>, v: Vector2<f64>) -> Option<Self> {
        let (n1, n2) = (Vector2::new(-u.y, u.x).normalize(), Vector2::new(-v.y, v.x).normalize());
        let (mut sum, mut of_contrast, mut weights) = (0.0, 0.0, 0.0);
        for (x, y, d, weight) in pixels(at, radius) {
            let luma = f64::from(picture.luma(x, y));
            sum += weight * luma;
            of_contrast += weight * luma * (n1.dot(&d) * n2.dot(&d)).signum();
            weights += weight;
        }
        let angle = |n: Vector2<f64>| n.y.atan2(n.x);
        (weights > 0.0).then_some(Self {
            at,
            angles: [angle(n1), angle(n2)],
            ln_blur: (0.15 * radius).clamp(0.7, 2.0).ln(),
            middle: sum / weights,
            half: of_contrast / weights,
            light: Vector2::zeros(),
        })
    }

    fn moved(&self, by: &Unknowns) -> Self {
        Self {
            at: self.at + Vector2::new(by[0], by[1]),
            angles: [self.angles[0] + by[2], self.angles[1] + by[3]],
            ln_blur: self.ln_blur + by[4],
            middle: self.middle + by[5],
            half: self.half + by[6],
            light: self.light + Vector2::new(by[7], by[8]),
        }
    }

    /// Brightness at a distance from the corner, and its derivatives.
    fn brightness(&self, d: Vector2<f64>) -> (f64, Unknowns) {
        let per_blur = std::f64::consts::FRAC_1_SQRT_2 * (-self.ln_blur).exp();
        let side = |angle: f64| {
            let (sin, cos) = angle.sin_cos();
            let z = (cos * d.x + sin * d.y) * per_blur;
            // erf, its slope by z, z by d, z by the angle.
            let slope = std::f64::consts::FRAC_2_SQRT_PI * (-z * z).exp();
            (erf(z), slope, z, Vector2::new(cos, sin) * per_blur, (cos * d.y - sin * d.x) * per_blur)
        };
        let ((e1, s1, z1, n1, a1), (e2, s2, z2, n2, a2)) = (side(self.angles[0]), side(self.angles[1]));
        let light = 1.0 + self.light.dot(&d);
        let squares = self.middle + self.half * e1 * e2;
        let (by1, by2) = (self.half * light * s1 * e2, self.half * light * e1 * s2);
        let by_d = n1 * by1 + n2 * by2 + self.light * squares;
        let derivative = Unknowns::from([
            -by_d.x,
            -by_d.y,
            by1 * a1,
            by2 * a2,
            -by1 * z1 - by2 * z2,
            light,
            light * e1 * e2,
            squares * d.x,
            squares * d.y,
        ]);
        (squares * light, derivative)
    }

    /// Brightness alone.
    fn plain(&self, d: Vector2<f64>) -> f64 {
        let per_blur = std::f64::consts::FRAC_1_SQRT_2 * (-self.ln_blur).exp();
        let side = |angle: f64| erf((angle.cos() * d.x + angle.sin() * d.y) * per_blur);
        let squares = self.middle + self.half * side(self.angles[0]) * side(self.angles[1]);
        squares * (1.0 + self.light.dot(&d))
    }

    /// Sum of weighed squares.
    fn squares(&self, picture: &Picture, radius: f64) -> f64 {
        let of = |(x, y, d, weight): (usize, usize, Vector2<f64>, f64)| {
            weight * (self.plain(d) - f64::from(picture.luma(x, y))).powi(2)
        };
        pixels(self.at, radius).map(of).sum()
    }

    /// Levenberg and Marquardt's steps.
    fn fitted(self, picture: &Picture, radius: f64) -> Option<Corner> {
        let (mut model, mut damping) = (self, 1e-3);
        let mut squares = model.squares(picture, radius);
        for _ in 0..STEPS_SECOND {
            let sums = model.sums(picture, radius);
            let damped = sums.normal + Normal::from_diagonal(&(sums.normal.diagonal() * damping));
            let step = damped.cholesky()?.solve(&sums.right);
            let next = model.moved(&step);
            let less = next.squares(picture, radius);
            let is_last = Vector2::new(step[0], step[1]).norm() < FOUND_PX;
            // The window moves with the corner: the sum may rise by a trace.
            if less <= squares * (1.0 + 1e-9) || (is_last && damping < 1.0) {
                (model, squares, damping) = (next, less, (damping * 0.1).max(1e-9));
                if is_last {
                    return model.corner(picture, radius);
                }
            } else {
                damping *= 10.0;
                if damping > 1e6 {
                    return model.corner(picture, radius);
                }
            }
        }
        None
    }

    fn sums(&self, picture: &Picture, radius: f64) -> Sums {
        let mut sums = Sums { normal: Normal::zeros(), right: Unknowns::zeros() };
        for (x, y, d, weight) in pixels(self.at, radius) {
            let (brightness, by) = self.brightness(d);
            sums.normal.ger(weight, &by, &by, 1.0);
            sums.right.axpy(weight * (f64::from(picture.luma(x, y)) - brightness), &by, 1.0);
        }
        sums
    }

    fn corner(&self, picture: &Picture, radius: f64) -> Option<Corner> {
        let inverse = self.sums(picture, radius).normal.cholesky()?.inverse();
        let (mut of_noise, mut weights) = (Normal::zeros(), 0.0);
        for (_, _, d, weight) in pixels(self.at, radius) {
            let (_, by) = self.brightness(d);
            of_noise.ger(weight * weight, &by, &by, 1.0);
            weights += weight;
        }
        // Of weighed squares the fit takes its unknowns' share.
        let freedom = weights - (inverse * of_noise).trace();
        let variance = self.squares(picture, radius) / freedom;
        let covariance = inverse * of_noise * inverse * variance;
        let std_px = [covariance[(0, 0)].sqrt(), covariance[(1, 1)].sqrt()];
        let sound = freedom > 1.0
            && self.half.abs() > CONTRAST_MIN
            && self.ln_blur.exp() < BLUR_MAX * radius
            && std_px.iter().all(|std| std.is_finite() && *std < 0.5);
        sound.then_some(Corner { at: self.at, std_px })
    }
}

struct Sums {
    normal: Normal,
    right: Unknowns,
}
