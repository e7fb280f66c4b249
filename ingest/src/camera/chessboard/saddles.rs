//! Saddles of brightness in a reduced picture.

use nalgebra::{Matrix2, SymmetricEigen, Vector2};

use super::super::picture::{Picture, Place};

/// Blur before brightness is differentiated twice, in px of the reduced picture.
const BLUR_PX: f64 = 1.5;

/// Weaker saddles are noise, in steps² of brightness per px⁴: squares that differ by about six steps.
const WEAKEST: f32 = 0.2;

/// Saddles kept, the strongest.
const SADDLES_MAX: usize = 4000;

/// Radius and points of the ring that must cross four edges, in px of the reduced picture.
const RING_PX: f64 = 3.0;
const RING: usize = 16;

/// Brightness at the other side of a corner is the same: least correlation.
const ALIKE_MIN: f64 = 0.4;

/// Brightness of the ring must span so many steps.
const SPAN_MIN: f64 = 4.0;

/// A saddle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Saddle {
    /// In px of the whole picture.
    pub at: Place,
    /// Second derivatives of brightness, per px² of the reduced picture.
    pub bends: Matrix2<f64>,
    /// The two edges, of unit length.
    pub edges: [Vector2<f64>; 2],
}

impl Saddle {
    fn new(at: Place, bends: Matrix2<f64>) -> Option<Self> {
        let eigen = SymmetricEigen::new(bends);
        let (i, j) = if eigen.eigenvalues[0] > eigen.eigenvalues[1] { (0, 1) } else { (1, 0) };
        let (up, down) = (eigen.eigenvalues[i], -eigen.eigenvalues[j]);
        let (a, b) = (eigen.eigenvectors.column(i) * down.sqrt(), eigen.eigenvectors.column(j) * up.sqrt());
        let edges = [(a + b).normalize(), (a - b).normalize()];
        (up > 0.0 && down > 0.0).then_some(Self { at, bends, edges })
    }

    /// Whether brightness between two directions is above that of the corner.
    pub fn is_bright(&self, a: Vector2<f64>, b: Vector2<f64>) -> bool {
        (self.bends * a).dot(&b) > 0.0
    }

    /// How well a direction, of any length, lies along an edge: cosine of the angle to the nearer one.
    pub fn along(&self, direction: Vector2<f64>) -> f64 {
        let length = direction.norm();
        self.edges.iter().map(|edge| edge.dot(&direction).abs() / length).fold(0.0, f64::max)
    }
}

/// A grey picture of floats.
struct Grey {
    width: usize,
    height: usize,
    luma: Vec<f32>,
}

impl Grey {
    /// Means over squares of `factor` px.
    fn reduced(picture: &Picture, factor: usize) -> Self {
        let (width, height) = (picture.width() / factor, picture.height() / factor);
        let mut luma = vec![0.0; width * height];
        let mut row = vec![0.0; picture.width()];
        let share = 1.0 / (factor * factor) as f32;
        for (y, into) in luma.chunks_exact_mut(width.max(1)).enumerate() {
            for k in 0..factor {
                picture.luma_row(y * factor + k, 0, &mut row);
                for (to, from) in into.iter_mut().zip(row.chunks_exact(factor)) {
                    *to += from.iter().sum::<f32>() * share;
                }
            }
        }
        Self { width, height, luma }
    }

    /// Blurred: along rows and then columns; beyond the border, the pixel at it.
    fn blurred(&self, blur_px: f64) -> Self {
        let reach = (3.0 * blur_px).ceil();
        // A few px.
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        let reach = reach as usize;
        let weight = |i: usize| (-0.5 * ((i as f64 - reach as f64) / blur_px).powi(2)).exp();
        let sum: f64 = (0..=2 * reach).map(weight).sum();
        #[allow(clippy::cast_possible_truncation)]
        let weights: Vec<f32> = (0..=2 * reach).map(|i| (weight(i) / sum) as f32).collect();
        let (w, h) = (self.width, self.height);
        let mut rows = vec![0.0; w * h];
        let mut padded = vec![0.0; w + 2 * reach];
        for (from, to) in self.luma.chunks_exact(w).zip(rows.chunks_exact_mut(w)) {
            for (i, value) in padded.iter_mut().enumerate() {
                *value = from[i.saturating_sub(reach).min(w - 1)];
            }
            for (x, to) in to.iter_mut().enumerate() {
                *to = weights.iter().zip(&padded[x..]).map(|(a, b)| a * b).sum();
            }
        }
        let mut luma = vec![0.0; w * h];
        for (y, to) in luma.chunks_exact_mut(w).enumerate() {
            for (k, weight) in weights.iter().enumerate() {
                let from = &rows[(y + k).saturating_sub(reach).min(h - 1) * w..][..w];
                to.iter_mut().zip(from).for_each(|(to, from)| *to += weight * from);
            }
        }
        Self { width: w, height: h, luma }
    }

    fn at(&self, x: usize, y: usize) -> f32 {
        self.luma[y * self.width + x]
    }

    /// Second derivatives; not at the border.
    fn bends(&self, x: usize, y: usize) -> [f32; 3] {
        let i = y * self.width + x;
        let of = |i: usize| self.luma[i];
        let (up, down, middle) = (i - self.width, i + self.width, of(i));
        let xx = of(i - 1) + of(i + 1) - 2.0 * middle;
        let yy = of(up) + of(down) - 2.0 * middle;
        let xy = (of(down + 1) + of(up - 1) - of(down - 1) - of(up + 1)) / 4.0;
        [xx, xy, yy]
    }

    fn between(&self, at: Vector2<f64>) -> f64 {
        let (x, y) = (at.x.clamp(0.0, (self.width - 2) as f64), at.y.clamp(0.0, (self.height - 2) as f64));
        // Not negative, and below the size.
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        let (i, j) = (x as usize, y as usize);
        let (a, b) = (x - i as f64, y - j as f64);
        let row = |j| f64::from(self.at(i, j)) * (1.0 - a) + f64::from(self.at(i + 1, j)) * a;
        row(j) * (1.0 - b) + row(j + 1) * b
    }

    /// Whether a ring about a place goes through four edges, and is the same at opposite sides.
    fn is_corner(&self, at: Vector2<f64>) -> bool {
        let ring: [f64; RING] = std::array::from_fn(|i| {
            let (sin, cos) = (std::f64::consts::TAU * i as f64 / RING as f64).sin_cos();
            self.between(at + Vector2::new(cos, sin) * RING_PX)
        });
        let (low, high) = ring.iter().fold((f64::MAX, f64::MIN), |(l, h), v| (l.min(*v), h.max(*v)));
        let middle = f64::midpoint(low, high);
        let crossings = (0..RING).filter(|i| (ring[*i] > middle) != (ring[(i + 1) % RING] > middle)).count();
        let squares: f64 = ring.iter().map(|v| (v - middle).powi(2)).sum();
        let opposite: f64 = (0..RING).map(|i| (ring[i] - middle) * (ring[(i + RING / 2) % RING] - middle)).sum();
        high - low > SPAN_MIN && crossings == 4 && opposite > ALIKE_MIN * squares
    }
}

/// Saddles of the picture reduced by a factor, the strongest first.
pub(super) fn saddles(picture: &Picture, factor: usize) -> Vec<Saddle> {
    const AWAY: usize = 2;
    let reduced = Grey::reduced(picture, factor);
    let (width, height) = (reduced.width, reduced.height);
    if width.min(height) < 4 * AWAY {
        return vec![];
    }
    let grey = reduced.blurred(BLUR_PX);
    let mut strengths = vec![0.0_f32; width * height];
    for y in 1..height - 1 {
        for x in 1..width - 1 {
            let [xx, xy, yy] = grey.bends(x, y);
            strengths[y * width + x] = xy * xy - xx * yy;
        }
    }
    let mut found: Vec<(f32, usize, usize)> = vec![];
    for y in AWAY..height - AWAY {
        for x in AWAY..width - AWAY {
            let own = strengths[y * width + x];
            if own < WEAKEST {
                continue;
            }
            // Of equal ones the first.
            let is_largest = (y - AWAY..=y + AWAY).all(|j| {
                (x - AWAY..=x + AWAY).all(|i| {
                    let other = strengths[j * width + i];
                    other < own || (other <= own && (j, i) >= (y, x))
                })
            });
            if is_largest {
                found.push((own, x, y));
            }
        }
    }
    found.sort_by(|a, b| b.0.total_cmp(&a.0).then((a.2, a.1).cmp(&(b.2, b.1))));
    let of = |(_, x, y): &(f32, usize, usize)| {
        let [xx, xy, yy] = grey.bends(*x, *y).map(f64::from);
        let bends = Matrix2::new(xx, xy, xy, yy);
        let (i, w) = (y * width + x, width);
        let slope = Vector2::new(
            f64::from(grey.luma[i + 1] - grey.luma[i - 1]),
            f64::from(grey.luma[i + w] - grey.luma[i - w]),
        ) / 2.0;
        // The saddle lies where the slope vanishes, next to the pixel.
        let by = bends.try_inverse()? * -slope;
        let at = Vector2::new(*x as f64, *y as f64) + by.map(|v| v.clamp(-1.0, 1.0));
        let whole = at * factor as f64 + Vector2::repeat((factor - 1) as f64 / 2.0);
        grey.is_corner(at).then(|| Saddle::new(whole, bends)).flatten()
    };
    found.iter().filter_map(of).take(SADDLES_MAX).collect()
}
