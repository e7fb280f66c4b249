//! A shape that stands out and fills an ellipse.

use nalgebra::{Matrix2, SymmetricEigen, Vector2};

use super::super::super::picture::{Picture, Place};
use super::DiscError;

/// The longer side of the reduced picture in which shapes are looked for, in px.
const LONGER_PX: usize = 900;

/// Pixels of a shape, at least, and as a share of the largest to count beside it.
const PIXELS_MIN: usize = 60;
const BESIDE: f64 = 0.25;

/// Share of a shape's pixels that the ellipse of the same moments must hold, and its axes' ratio.
const FILLS: f64 = 0.96;
const AXES_MIN: f64 = 0.25;

/// Steps of brightness by which a shape stands out, at least.
const STANDS_OUT: f64 = 5.0;

/// Levels of brightness.
const LEVELS: usize = 256;

/// An ellipse of the same moments as a shape.
#[derive(Debug, Clone, Copy)]
pub(super) struct Shape {
    pub centre: Place,
    /// Symmetric; its eigenvalues are the semi-axes.
    pub matrix: Matrix2<f64>,
    pub is_bright: bool,
    pixels: f64,
}

/// A part of a picture, reduced and smoothed a little.
struct Part {
    left: usize,
    top: usize,
    factor: usize,
    width: usize,
    height: usize,
    luma: Vec<u8>,
}

/// The one shape in a part of a picture that is an ellipse.
pub(super) fn find(picture: &Picture, part: Option<[Place; 2]>) -> Result<Shape, DiscError> {
    let part = Part::of(picture, part).ok_or(DiscError::Region)?;
    let mut found: Vec<Shape> = vec![];
    let mut at_border = false;
    for threshold in part.thresholds() {
        for is_bright in [true, false] {
            for shape in part.shapes(threshold, is_bright) {
                match shape {
                    Some(shape) => found.push(shape),
                    None => at_border = true,
                }
            }
        }
    }
    // The outermost outline of several about one middle.
    found.sort_by(|a, b| b.pixels.total_cmp(&a.pixels));
    let Some(largest) = found.first() else {
        return Err(if at_border { DiscError::Border } else { DiscError::NoDisc });
    };
    let reach = largest.matrix.norm();
    let beside = |other: &&Shape| {
        other.pixels > BESIDE * largest.pixels
            && (other.centre - largest.centre).norm() > reach / std::f64::consts::SQRT_2
    };
    match found.iter().find(beside) {
        Some(other) => Err(DiscError::Several { one: largest.centre, other: other.centre }),
        None => Ok(*largest),
    }
}

impl Part {
    fn of(picture: &Picture, part: Option<[Place; 2]>) -> Option<Self> {
        let (right, bottom) = ((picture.width() - 1) as f64, (picture.height() - 1) as f64);
        let [a, b] = part.unwrap_or([Place::zeros(), Place::new(right, bottom)]);
        if !(a + b).iter().all(|v| v.is_finite()) {
            return None;
        }
        let clamp = |v: f64, most: f64| v.round().clamp(0.0, most);
        // Within the picture.
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        let range = |a: f64, b: f64, most: f64| (clamp(a.min(b), most) as usize, clamp(a.max(b), most) as usize + 1);
        let ((left, x1), (top, y1)) = (range(a.x, b.x, right), range(a.y, b.y, bottom));
        let factor = (x1 - left).max(y1 - top).div_ceil(LONGER_PX).max(1);
        let (width, height) = ((x1 - left) / factor, (y1 - top) / factor);
        if width < 8 || height < 8 {
            return None;
        }
        let mut sums = vec![0.0_f32; width * height];
        let mut row = vec![0.0; width * factor];
        for y in 0..height * factor {
            picture.luma_row(top + y, left, &mut row);
            for (to, from) in sums[y / factor * width..].iter_mut().zip(row.chunks_exact(factor)) {
                *to += from.iter().sum::<f32>();
            }
        }
        // Means of three by three, so that noise does not fray an outline.
        let at = |x: usize, y: usize| sums[y.min(height - 1) * width + x.min(width - 1)];
        let share = 1.0 / (9 * factor * factor) as f32;
        let mean = |i: usize| {
            let (x, y) = (i % width, i / width);
            let columns = [x.saturating_sub(1), x, x + 1];
            let sum: f32 =
                [y.saturating_sub(1), y, y + 1].iter().map(|y| columns.iter().map(|x| at(*x, *y)).sum::<f32>()).sum();
            // Brightness is a number of eight bits.
            #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
            let level = (sum * share).round().clamp(0.0, 255.0) as u8;
            level
        };
        Some(Self { left, top, factor, width, height, luma: (0..width * height).map(mean).collect() })
    }

    /// Levels that part bright from dark (Otsu, 1979): over all, and again within either side.
    fn thresholds(&self) -> Vec<usize> {
        let mut histogram = [0.0; LEVELS];
        self.luma.iter().for_each(|level| histogram[usize::from(*level)] += 1.0);
        let Some(first) = otsu(&histogram, 0..LEVELS) else { return vec![] };
        let again = [otsu(&histogram, 0..first), otsu(&histogram, first..LEVELS)];
        std::iter::once(first).chain(again.into_iter().flatten()).collect()
    }

    /// Ellipses among the shapes on one side of a level; `None` for a large shape at the border.
    fn shapes(&self, threshold: usize, is_bright: bool) -> Vec<Option<Shape>> {
        let n = self.luma.len();
        let is_on = |i: usize| (usize::from(self.luma[i]) >= threshold) == is_bright;
        let mut label = vec![0_u32; n];
        let mut shapes = vec![];
        let mut next = 0;
        let mut stack = vec![];
        for first in 0..n {
            if !is_on(first) || label[first] != 0 {
                continue;
            }
            next += 1;
            label[first] = next;
            stack.push(first);
            let (mut count, mut bounds) = (0, [usize::MAX, usize::MAX, 0, 0]);
            while let Some(i) = stack.pop() {
                let (x, y) = (i % self.width, i / self.width);
                bounds = [bounds[0].min(x), bounds[1].min(y), bounds[2].max(x), bounds[3].max(y)];
                count += 1;
                for beside in self.beside(x, y) {
                    if is_on(beside) && label[beside] == 0 {
                        label[beside] = next;
                        stack.push(beside);
                    }
                }
            }
            let [x0, y0, x1, y1] = bounds;
            let is_at_border = x0 == 0 || y0 == 0 || x1 + 1 == self.width || y1 + 1 == self.height;
            if is_at_border {
                // The ground itself touches all four sides.
                let all = x0 == 0 && y0 == 0 && x1 + 1 == self.width && y1 + 1 == self.height;
                if !all && count > PIXELS_MIN {
                    shapes.push(None);
                }
            } else if count > PIXELS_MIN {
                shapes.extend(self.ellipse(&label, next, bounds, is_bright).map(Some));
            }
        }
        shapes
    }

    fn beside(&self, x: usize, y: usize) -> impl Iterator<Item = usize> + use<> {
        let (w, h) = (self.width, self.height);
        let i = y * w + x;
        [(x > 0).then(|| i - 1), (x + 1 < w).then_some(i + 1), (y > 0).then(|| i - w), (y + 1 < h).then_some(i + w)]
            .into_iter()
            .flatten()
    }

    /// The ellipse of a shape, its holes filled; `None` if it is none. The shape is not at the border.
    fn ellipse(&self, label: &[u32], own: u32, [x0, y0, x1, y1]: [usize; 4], is_bright: bool) -> Option<Shape> {
        // What can be reached from around it is outside.
        let (w, h) = (x1 - x0 + 3, y1 - y0 + 3);
        let is_shape = |i: usize| label[(y0 + i / w - 1) * self.width + x0 + i % w - 1] == own;
        let mut is_outside = vec![false; w * h];
        let mut stack = vec![0];
        is_outside[0] = true;
        while let Some(i) = stack.pop() {
            let (x, y) = (i % w, i / w);
            let beside = [
                (x > 0).then(|| i - 1),
                (x + 1 < w).then_some(i + 1),
                (y > 0).then(|| i - w),
                (y + 1 < h).then_some(i + w),
            ];
            for next in beside.into_iter().flatten() {
                if !is_outside[next] && !is_shape(next) {
                    is_outside[next] = true;
                    stack.push(next);
                }
            }
        }
        // Around the shape lies more than itself: what it stands out from.
        let mut means = [(0.0, 0.0); 2];
        for i in 0..w * h {
            if is_shape(i) || is_outside[i] {
                let (sum, count) = &mut means[usize::from(is_outside[i])];
                *sum += f64::from(self.luma[(y0 + i / w - 1) * self.width + x0 + i % w - 1]);
                *count += 1.0;
            }
        }
        let [own, around] = means.map(|(sum, count)| sum / count);
        if (own - around).abs() < STANDS_OUT {
            return None;
        }
        let inside: Vec<Vector2<f64>> = (0..w * h)
            .filter(|i| !is_outside[*i])
            .map(|i| Vector2::new((x0 + i % w) as f64 - 1.0, (y0 + i / w) as f64 - 1.0))
            .collect();
        let n = inside.len() as f64;
        let centre = inside.iter().sum::<Vector2<f64>>() / n;
        let spread = inside.iter().map(|p| (p - centre) * (p - centre).transpose()).sum::<Matrix2<f64>>() / n;
        let inverse = spread.try_inverse()?;
        let within = inside.iter().filter(|p| (*p - centre).dot(&(inverse * (*p - centre))) <= 4.0).count() as f64;
        let eigen = SymmetricEigen::new(spread);
        // Of a filled ellipse, the variance along an axis is a quarter of its square.
        let axes = eigen.eigenvalues.map(|v| 2.0 * v.max(0.0).sqrt());
        let area = std::f64::consts::PI * axes.x * axes.y;
        // A small shape is frayed by its pixels.
        let rim = 0.5 * std::f64::consts::TAU * axes.mean() / area;
        let fills = within / n > FILLS - rim && (n / area - 1.0).abs() < 1.0 - FILLS + rim;
        if !fills || axes.min() < AXES_MIN * axes.max() {
            return None;
        }
        let f = self.factor as f64;
        let whole = Vector2::new(self.left as f64, self.top as f64) + centre * f + Vector2::repeat((f - 1.0) / 2.0);
        let matrix = eigen.eigenvectors * Matrix2::from_diagonal(&axes) * eigen.eigenvectors.transpose() * f;
        Some(Shape { centre: whole, matrix, is_bright, pixels: n })
    }
}

/// The level for which the classes below it and from it on are furthest apart.
fn otsu(histogram: &[f64; LEVELS], range: std::ops::Range<usize>) -> Option<usize> {
    let of = |range: std::ops::Range<usize>| -> (f64, f64) {
        range.map(|i| (histogram[i], histogram[i] * i as f64)).fold((0.0, 0.0), |a, b| (a.0 + b.0, a.1 + b.1))
    };
    let all = of(range.clone());
    let mut below = (0.0, 0.0);
    let mut best: Option<(f64, usize, usize)> = None;
    for level in range {
        // Levels between two classes are as good as one another: the middle of them.
        if below.0 > 0.0 && below.0 < all.0 {
            let (a, b) = (below.1 / below.0, (all.1 - below.1) / (all.0 - below.0));
            let apart = below.0 * (all.0 - below.0) * (a - b) * (a - b);
            match &mut best {
                Some((most, _, last)) if apart <= *most && apart >= *most * (1.0 - 1e-12) => *last = level,
                Some((most, ..)) if apart <= *most => {}
                _ => best = Some((apart, level, level)),
            }
        }
        below = (below.0 + histogram[level], below.1 + histogram[level] * level as f64);
    }
    best.map(|(_, first, last)| usize::midpoint(first, last))
}
