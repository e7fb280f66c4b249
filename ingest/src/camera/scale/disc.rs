//! A disc or coin of known diameter: the ellipse of its edge.
//!
//! First a shape that is darker or brighter than what lies around it, without holes, and fills an ellipse (`shape.rs`). Then its
//! edge along lines across it, to sub-pixel ([`edge`](super::super::edge)), and least squares of
//!
//! ```text
//! x(t) = c + M (cos t, sin t),   M symmetric
//! ```
//!
//! whose eigenvalues are the semi-axes: smooth where they are equal. Lines that disagree (a glint, a thing that touches it) are left out.
//!
//! Blur draws a curved edge inwards: half of the brightness lies σ²/(2ρ) inside of an edge with a radius of curvature ρ (first
//! order of σ/ρ; the same for a dark disc on bright and a bright one on dark). A radius seems smaller by σ²/(2R), a diameter by
//! σ²/R; each place is put right before the fit, σ being the blur of its own edge.
//!
//! A tilted disc shows its diameter along the longer axis and its cosine along the other. The tilt shifts the scale along the
//! shorter axis only; to the first order in diameter over distance perspective changes neither. Rims that are bevelled and
//! shadows are not seen: they are the diameter's own uncertainty.

mod shape;

use std::fmt;

use nalgebra::{Matrix2, Matrix5, SymmetricEigen, Vector2, Vector5};

use super::super::edge::Blur;
use super::super::lens::Lens;
use super::super::picture::{Picture, Place};
use super::{Length, Scale, ScaleError, as_seen, straight};

/// Lines across the edge: one in so many px, at least and at most.
const APART_PX: f64 = 1.5;
const LINES: (f64, f64) = (48.0, 720.0);

/// Steps with the edge only roughly known, and with it known.
const ROUGH: usize = 3;
const FINE: usize = 5;

/// How far the edge is looked for at first, as a share of the radius, and at least, in px.
const ROUGH_SHARE: f64 = 0.08;
const ROUGH_PX: f64 = 4.0;

/// Blur at first, and within which it must lie, in px.
const BLUR_PX: f64 = 1.2;
const BLURS_PX: (f64, f64) = (0.4, 12.0);

/// Lines further off than so many standard deviations are left out; the deviation is not smaller than this, in px.
const OFF: f64 = 4.0;
const DEVIATION_MIN_PX: f64 = 0.01;

/// Share of the lines that must agree, and their deviation, in px and as a share of the radius.
const AGREE_MIN: f64 = 0.6;
const DEVIATION_PX: f64 = 0.5;
const DEVIATION_SHARE: f64 = 0.01;

/// The steps of brightness at the edge, at least.
const CONTRAST_MIN: f64 = 6.0;

/// A radius of fewer px, or an axis shorter than this share of the other, is no measure.
const RADIUS_MIN_PX: f64 = 5.0;
const AXES_MIN: f64 = 0.3;

/// The share of the correction for blur that is not known.
const CORRECTION_STD: f64 = 0.1;

/// Axes whose difference is below so many standard uncertainties may be equal.
const EQUAL: f64 = 2.0;

/// A disc in a picture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Disc {
    /// Its middle, in px (of a straightened picture where the lens is given).
    pub centre: Place,
    /// Its diameter, in px: the longer axis, or the mean of both where they may be equal.
    pub diameter_px: f64,
    /// Standard uncertainty, in px: the scatter of the edge, with what neighbouring lines have in common, a share of the correction for
    /// blur, and the difference of axes that may be equal.
    pub std_px: f64,
    /// Longer and shorter semi-axis, in px.
    pub semi_axes_px: [f64; 2],
    /// Direction of the longer one, in rad from x towards y, within ± π/2.
    pub direction_rad: f64,
    /// Tilt by the ratio of the axes, in rad; 0 where they may be equal.
    pub tilt_rad: f64,
    /// The tilt is not larger than this (one-sided 97.5 %), in rad.
    pub tilt_rad_max: f64,
    /// Blur of its edge, in px.
    pub blur_px: f64,
    /// By how much the correction for blur made the diameter larger, in px.
    pub correction_px: f64,
    /// Lines across the edge that agree, and all.
    pub lines: (usize, usize),
    /// Whether it is brighter than what lies around it.
    pub is_bright: bool,
}

/// Why there is no disc.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum DiscError {
    /// A part of the picture that is none.
    Region,
    /// Nothing round.
    NoDisc,
    /// What is round touches the border.
    Border,
    /// Several.
    Several {
        /// The middle of the first, in px.
        one: Place,
        /// The middle of the second, in px.
        other: Place,
    },
    /// An edge that is no ellipse.
    Unclear {
        /// The middle, in px.
        at: Place,
        /// Lines that agree.
        agree: usize,
        /// All lines.
        of: usize,
    },
    /// The lens is not known there.
    Lens {
        /// Where, in px.
        at: Place,
    },
}

impl fmt::Display for DiscError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let of = "give the part of the picture that holds the disc alone";
        match self {
            Self::Region => write!(f, "the part of the picture to look at is empty or smaller than a disc"),
            Self::NoDisc => {
                write!(f, "no disc: nothing round stands out from what lies around it; {of}, on an even ground")
            }
            Self::Border => {
                write!(f, "no whole disc: what is round touches the border; {of}, with some ground around it")
            }
            Self::Several { one, other } => write!(
                f,
                "more than one disc, near ({:.0}, {:.0}) and ({:.0}, {:.0}) px; {of}",
                one.x, one.y, other.x, other.y
            ),
            Self::Unclear { at, agree, of } => {
                write!(
                    f,
                    "the edge of the disc near ({:.0}, {:.0}) px is no ellipse: {agree} of {of} places agree",
                    at.x, at.y
                )
            }
            Self::Lens { at } => write!(f, "the lens is not known at ({:.0}, {:.0}) px", at.x, at.y),
        }
    }
}

impl std::error::Error for DiscError {}

impl Disc {
    /// The scale, for a diameter.
    ///
    /// # Errors
    /// If the diameter is none.
    pub fn scale(&self, diameter: Length) -> Result<Scale, ScaleError> {
        Ok(Scale::of(diameter.checked()?, self.diameter_px, self.std_px))
    }
}

/// Finds the one disc in a part of a picture (two corners of it; `None`: all of it).
///
/// # Errors
/// Why there is none.
pub fn find(picture: &Picture, part: Option<[Place; 2]>, lens: Option<&Lens>) -> Result<Disc, DiscError> {
    let shape = shape::find(picture, part)?;
    let ellipse = straightened(&shape, lens)?;
    let looked = Looked { picture, lens, is_bright: shape.is_bright, blur: Blur::new() };
    looked.fit(ellipse)
}

/// Middle and matrix.
#[derive(Debug, Clone, Copy)]
struct Ellipse {
    centre: Place,
    matrix: Matrix2<f64>,
}

impl Ellipse {
    /// A point, the outward normal there, and the radius of curvature.
    fn at(&self, angle: f64) -> (Place, Vector2<f64>, f64) {
        let (sin, cos) = angle.sin_cos();
        let (out, along) = (self.matrix * Vector2::new(cos, sin), self.matrix * Vector2::new(-sin, cos));
        let speed = along.norm();
        let area = out.x * along.y - out.y * along.x;
        let normal = Vector2::new(along.y, -along.x) / speed * area.signum();
        (self.centre + out, normal, speed.powi(3) / area.abs())
    }

    fn moved(&self, by: &Vector5<f64>) -> Self {
        let matrix = self.matrix + Matrix2::new(by[2], by[3], by[3], by[4]);
        Self { centre: self.centre + Vector2::new(by[0], by[1]), matrix }
    }

    /// How far the edge moves along its normal for each number.
    fn derivative(angle: f64, normal: Vector2<f64>) -> Vector5<f64> {
        let (sin, cos) = angle.sin_cos();
        Vector5::new(normal.x, normal.y, normal.x * cos, normal.x * sin + normal.y * cos, normal.y * sin)
    }

    /// Longer and shorter semi-axis with their directions.
    fn axes(&self) -> [(f64, Vector2<f64>); 2] {
        let eigen = SymmetricEigen::new(self.matrix);
        let of = |i: usize| (eigen.eigenvalues[i], eigen.eigenvectors.column(i).into_owned());
        if eigen.eigenvalues[0] >= eigen.eigenvalues[1] { [of(0), of(1)] } else { [of(1), of(0)] }
    }
}

/// The shape's ellipse as a pinhole would have seen it: by places of its outline, which a lens bends little.
fn straightened(shape: &shape::Shape, lens: Option<&Lens>) -> Result<Ellipse, DiscError> {
    const POINTS: usize = 32;
    let seen = Ellipse { centre: shape.centre, matrix: shape.matrix };
    let to = |at: Place| straight(lens, at).map_err(|_| DiscError::Lens { at });
    let mut ellipse = seen;
    if lens.is_none() {
        return Ok(ellipse);
    }
    let angle_of = |i: usize| std::f64::consts::TAU * i as f64 / POINTS as f64;
    let outline: Vec<Place> = (0..POINTS).map(|i| to(seen.at(angle_of(i)).0)).collect::<Result<_, _>>()?;
    // The even parts of the outline over the angle are those of an ellipse.
    let mean = |of: &dyn Fn(usize) -> f64| -> Vector2<f64> {
        outline.iter().enumerate().map(|(i, p)| p * of(i)).sum::<Vector2<f64>>() / POINTS as f64
    };
    ellipse.centre = mean(&|_| 1.0);
    let (x, y) = (mean(&|i| 2.0 * angle_of(i).cos()), mean(&|i| 2.0 * angle_of(i).sin()));
    // Any matrix is a symmetric one behind a turn, which only shifts t.
    let square = Matrix2::from_columns(&[x, y]);
    let eigen = SymmetricEigen::new(square * square.transpose());
    let roots = Matrix2::from_diagonal(&eigen.eigenvalues.map(|v| v.max(0.0).sqrt()));
    ellipse.matrix = eigen.eigenvectors * roots * eigen.eigenvectors.transpose();
    Ok(ellipse)
}

struct Looked<'p> {
    picture: &'p Picture,
    lens: Option<&'p Lens>,
    is_bright: bool,
    blur: Blur,
}

/// Where the edge lies along the normal of an ellipse.
#[derive(Debug, Clone, Copy)]
struct Seen {
    angle: f64,
    normal: Vector2<f64>,
    /// Outwards, in px.
    off: f64,
    /// Radius of curvature, in px.
    bend: f64,
}

struct Fitted {
    ellipse: Ellipse,
    /// Inverse of the normal equations.
    inverse: Matrix5<f64>,
    /// By line: what is left over, if it is used.
    left: Vec<Option<f64>>,
    step_px: f64,
}

impl Looked<'_> {
    fn fit(&self, start: Ellipse) -> Result<Disc, DiscError> {
        let radius = start.matrix.determinant().abs().sqrt();
        let circumference = std::f64::consts::TAU * radius / APART_PX;
        // Within its limits.
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        let n = circumference.clamp(LINES.0, LINES.1) as usize;
        let unclear = |agree: usize| DiscError::Unclear { at: start.centre, agree, of: n };
        let mut ellipse = start;
        let mut blur_px = BLUR_PX;
        for i in 0..ROUGH {
            let reach = (ROUGH_SHARE * radius).max(ROUGH_PX) / f64::from(1 << i);
            let seen: Vec<Option<Seen>> =
                self.lines(&ellipse, n, |line, reach| self.steepest(line, reach), reach.max(2.5));
            ellipse = fitted(&ellipse, &seen).ok_or(unclear(0))?.ellipse;
        }
        let mut last = None;
        for _ in 0..FINE {
            let reach = Blur::reach_px(blur_px).ceil().min(0.6 * radius);
            let mut wider = (0.0, 0.0);
            let find = |line: &[f32], reach: f64| {
                let edge = self.blur.edge(line, reach, blur_px, true, 4)?;
                let height = edge.levels.1 - edge.levels.0;
                let is_edge = (height < 0.0) == self.is_bright && height.abs() > CONTRAST_MIN;
                is_edge.then_some((edge.at - reach, edge.blur_step, edge.blur_weight))
            };
            let seen = self.lines_with(&ellipse, n, find, reach, |step, weight| {
                // One wild line must not decide.
                wider = (wider.0 + step.clamp(-0.5, 0.5) * blur_px * weight, wider.1 + weight * blur_px);
            });
            if wider.1 > 0.0 {
                blur_px = (blur_px + wider.0 / wider.1).clamp(BLURS_PX.0, BLURS_PX.1);
            }
            let right = |seen: &Seen| Seen { off: seen.off + blur_px * blur_px / (2.0 * seen.bend), ..*seen };
            let seen: Vec<Option<Seen>> = seen.iter().map(|seen| seen.as_ref().map(right)).collect();
            let found = fitted(&ellipse, &seen).ok_or(unclear(0))?;
            ellipse = found.ellipse;
            last = Some(found);
        }
        self.disc(&last.ok_or(unclear(0))?, blur_px, n)
    }

    /// Brightness along normals, every px from so far inside to so far outside.
    fn lines(
        &self,
        ellipse: &Ellipse,
        n: usize,
        find: impl Fn(&[f32], f64) -> Option<f64>,
        reach: f64,
    ) -> Vec<Option<Seen>> {
        self.lines_with(ellipse, n, |line, reach| Some((find(line, reach)?, 0.0, 0.0)), reach.ceil(), |_, _| {})
    }

    fn lines_with(
        &self,
        ellipse: &Ellipse,
        n: usize,
        find: impl Fn(&[f32], f64) -> Option<(f64, f64, f64)>,
        reach: f64,
        mut blur: impl FnMut(f64, f64),
    ) -> Vec<Option<Seen>> {
        let reach = reach.floor().max(2.0);
        // A few px.
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        let samples = 2 * reach as usize + 1;
        let (right, bottom) = ((self.picture.width() - 1) as f64, (self.picture.height() - 1) as f64);
        let mut line = vec![0.0; samples];
        let one = |i: usize| {
            let angle = std::f64::consts::TAU * i as f64 / n as f64;
            let (at, normal, bend) = ellipse.at(angle);
            for (k, value) in line.iter_mut().enumerate() {
                let place = as_seen(self.lens, at + normal * (k as f64 - reach));
                let is_inside = (0.0..=right).contains(&place.x) && (0.0..=bottom).contains(&place.y);
                if !is_inside {
                    return None;
                }
                // Brightness is a number of eight bits.
                #[allow(clippy::cast_possible_truncation)]
                let luma = self.picture.between(place) as f32;
                *value = luma;
            }
            let (off, step, weight) = find(&line, reach)?;
            blur(step, weight);
            Some(Seen { angle, normal, off, bend })
        };
        (0..n).map(one).collect()
    }

    /// The steepest place of the right sign.
    fn steepest(&self, line: &[f32], reach: f64) -> Option<f64> {
        let sign = if self.is_bright { -1.0 } else { 1.0 };
        let slopes = line.windows(3).map(|w| sign * (w[2] - w[0])).enumerate();
        let (i, slope) = slopes.max_by(|a, b| a.1.total_cmp(&b.1))?;
        (f64::from(slope) > CONTRAST_MIN / 3.0).then_some(i as f64 + 1.0 - reach)
    }

    fn disc(&self, fit: &Fitted, blur_px: f64, n: usize) -> Result<Disc, DiscError> {
        let used: Vec<f64> = fit.left.iter().flatten().copied().collect();
        let unclear = DiscError::Unclear { at: fit.ellipse.centre, agree: used.len(), of: n };
        let [(a, along), (b, across)] = fit.ellipse.axes();
        let deviation = (used.iter().map(|r| r * r).sum::<f64>() / used.len().saturating_sub(5).max(1) as f64).sqrt();
        let sound = used.len() as f64 > AGREE_MIN * n as f64
            && b > RADIUS_MIN_PX
            && b > AXES_MIN * a
            && deviation < DEVIATION_PX.max(DEVIATION_SHARE * b)
            && fit.step_px < 0.05
            && blur_px < 0.5 * b;
        if !sound {
            return Err(unclear);
        }
        let covariance = fit.inverse * (deviation * deviation * common(&fit.left));
        let of_axis = |u: Vector2<f64>| Vector5::new(0.0, 0.0, u.x * u.x, 2.0 * u.x * u.y, u.y * u.y);
        let std_of = |by: Vector5<f64>| by.dot(&(covariance * by)).max(0.0).sqrt();
        let (by_a, by_b) = (of_axis(along), of_axis(across));
        let apart_std = std_of(by_a - by_b);
        let correction_px = blur_px * blur_px * 2.0 / (a + b);
        let may_be_equal = a - b < EQUAL * apart_std;
        let (diameter_px, of_edge) = if may_be_equal {
            // The longer axis is at most so much longer than their mean.
            (a + b, std_of(by_a + by_b).hypot((a - b) / 3.0_f64.sqrt()))
        } else {
            (2.0 * a, 2.0 * std_of(by_a))
        };
        let ratio = |less: f64| ((b - less * apart_std) / a).clamp(0.0, 1.0).acos();
        let disc = Disc {
            centre: fit.ellipse.centre,
            diameter_px,
            std_px: of_edge.hypot(CORRECTION_STD * correction_px),
            semi_axes_px: [a, b],
            direction_rad: if along.x == 0.0 { std::f64::consts::FRAC_PI_2 } else { (along.y / along.x).atan() },
            tilt_rad: if may_be_equal { 0.0 } else { ratio(0.0) },
            tilt_rad_max: ratio(1.96),
            blur_px,
            correction_px,
            lines: (used.len(), n),
            is_bright: self.is_bright,
        };
        disc.std_px.is_finite().then_some(disc).ok_or(unclear)
    }
}

/// By how much neighbours that deviate together raise the variance of what they fit: one and twice the sum of their correlations, up
/// to the first that is none.
fn common(left: &[Option<f64>]) -> f64 {
    let n = left.len();
    let product = |lag: usize| {
        let both = (0..n).filter_map(|i| Some(left[i]? * left[(i + lag) % n]?));
        let (sum, count) = both.fold((0.0, 0), |(sum, count), v| (sum + v, count + 1));
        sum / f64::from(count.max(1))
    };
    let own = product(0);
    if own <= 0.0 {
        return 1.0;
    }
    // Noise alone correlates by 1/√n.
    let floor = 1.0 / (n as f64).sqrt();
    1.0 + 2.0 * (1..n / 8).map(|lag| product(lag) / own).take_while(|share| *share > floor).sum::<f64>()
}

/// One step of least squares, lines that disagree left out.
fn fitted(ellipse: &Ellipse, seen: &[Option<Seen>]) -> Option<Fitted> {
    let mut is_used: Vec<bool> = seen.iter().map(Option::is_some).collect();
    let mut result = None;
    for _ in 0..20 {
        let (mut normal, mut right) = (Matrix5::zeros(), Vector5::zeros());
        for line in seen.iter().zip(&is_used).filter(|(_, used)| **used).filter_map(|(line, _)| *line) {
            let by = Ellipse::derivative(line.angle, line.normal);
            normal += by * by.transpose();
            right += by * line.off;
        }
        let inverse = normal.cholesky()?.inverse();
        let step = inverse * right;
        let left: Vec<Option<f64>> = seen
            .iter()
            .map(|line| line.map(|line| line.off - Ellipse::derivative(line.angle, line.normal).dot(&step)))
            .collect();
        let mut sizes: Vec<f64> = left.iter().flatten().map(|r| r.abs()).collect();
        if sizes.len() < 12 {
            return None;
        }
        sizes.sort_by(f64::total_cmp);
        // Of normal deviations, half are below 0.6745 of the standard one.
        let limit = OFF * (sizes[sizes.len() / 2] / 0.6745).max(DEVIATION_MIN_PX);
        let now: Vec<bool> = left.iter().map(|r| r.is_some_and(|r| r.abs() < limit)).collect();
        let moved = ellipse.moved(&step);
        let same = now == is_used;
        is_used = now;
        let kept = left.iter().zip(&is_used).map(|(r, used)| r.filter(|_| *used)).collect();
        result = Some(Fitted { ellipse: moved, inverse, left: kept, step_px: step.norm() });
        if same {
            break;
        }
    }
    result.filter(|fit| fit.ellipse.matrix.determinant() > 0.0 && fit.ellipse.matrix.trace() > 0.0)
}

#[cfg(test)]
mod tests;
