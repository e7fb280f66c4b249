//! Shapes on paper, and the area that several of them cover together, less holes: by Green's theorem along their outlines.
//!
//! ```text
//! A = ½ ∮ (x dy - y dx)   over the parts of each outline that bound the whole
//! ```
//!
//! A part of a shape's outline bounds the whole where it lies in no other shape and in no hole; one of a hole, where it lies in a shape
//! and in no other hole, and counts the other way round. Where that changes, the crossing is found by bisection.

use std::f64::consts::TAU;

use nalgebra::Vector2;

/// Steps of an outline, and halvings at a crossing.
const STEPS: usize = 4000;
const HALVINGS: usize = 50;

/// A shape whose every outline point is seen from its middle.
#[derive(Debug, Clone, PartialEq)]
pub enum Shape {
    /// An ellipse.
    Ellipse {
        /// Its middle, in m.
        middle_m: [f64; 2],
        /// Half axes, in m.
        half_m: [f64; 2],
        /// By how much the first is turned from x towards y, in rad.
        turn_rad: f64,
    },
    /// A rectangle with round corners.
    Rectangle {
        /// Its middle, in m.
        middle_m: [f64; 2],
        /// Half of its sides, in m.
        half_m: [f64; 2],
        /// Radius of its corners, in m.
        corner_m: f64,
        /// By how much it is turned from x towards y, in rad.
        turn_rad: f64,
    },
    /// A blot: r = r₀ (1 + Σ aₖ cos(k φ + φₖ)), k from 2 on.
    Blot {
        /// Its middle, in m.
        middle_m: [f64; 2],
        /// r₀, in m.
        radius_m: f64,
        /// aₖ and φₖ.
        waves: Vec<[f64; 2]>,
    },
}

impl Shape {
    /// A disc.
    pub fn disc(middle_m: [f64; 2], radius_m: f64) -> Self {
        Self::Ellipse { middle_m, half_m: [radius_m; 2], turn_rad: 0.0 }
    }

    fn middle(&self) -> Vector2<f64> {
        let (Self::Ellipse { middle_m, .. } | Self::Rectangle { middle_m, .. } | Self::Blot { middle_m, .. }) = self;
        Vector2::from(*middle_m)
    }

    /// From the middle to the outline in a direction, in m.
    fn radius(&self, direction: f64) -> f64 {
        match self {
            Self::Ellipse { half_m: [a, b], turn_rad, .. } => {
                let (sin, cos) = (direction - turn_rad).sin_cos();
                1.0 / (cos / a).hypot(sin / b)
            }
            Self::Rectangle { half_m: [a, b], corner_m, turn_rad, .. } => {
                let (sin, cos) = (direction - turn_rad).sin_cos();
                let (x, y) = (cos.abs(), sin.abs());
                let straight = (a / x).min(b / y);
                let corner = corner_m.min(*a).min(*b);
                let (cx, cy) = (a - corner, b - corner);
                if straight * x <= cx || straight * y <= cy {
                    return straight;
                }
                // |r (x, y) - (cx, cy)| = corner, the farther one.
                let along = x * cx + y * cy;
                along + (along * along - cx * cx - cy * cy + corner * corner).max(0.0).sqrt()
            }
            Self::Blot { radius_m, waves, .. } => {
                let wave = |(k, [a, phase]): (usize, &[f64; 2])| a * ((k + 2) as f64 * direction + phase).cos();
                radius_m * (1.0 + waves.iter().enumerate().map(wave).sum::<f64>())
            }
        }
    }

    /// Whether it is a shape at all: the outline is in front of the middle everywhere.
    pub(super) fn is_sound(&self) -> bool {
        let sides = match self {
            Self::Ellipse { half_m, turn_rad, .. } => half_m.iter().all(|side| *side > 0.0) && turn_rad.is_finite(),
            Self::Rectangle { half_m, corner_m, turn_rad, .. } => {
                half_m.iter().all(|side| *side > 0.0) && *corner_m >= 0.0 && turn_rad.is_finite()
            }
            Self::Blot { radius_m, waves, .. } => {
                *radius_m > 0.0 && waves.iter().map(|[a, _]| a.abs()).sum::<f64>() < 1.0
            }
        };
        let is_length = |direction: usize| {
            let radius = self.radius(direction as f64);
            radius.is_finite() && radius > 0.0
        };
        sides && self.middle().iter().all(|x| x.is_finite()) && (0..7).all(is_length)
    }

    /// A point of the outline, by its direction from the middle.
    pub(super) fn at(&self, direction: f64) -> Vector2<f64> {
        let (sin, cos) = direction.sin_cos();
        self.middle() + self.radius(direction) * Vector2::new(cos, sin)
    }

    fn contains(&self, point: Vector2<f64>) -> bool {
        let from = point - self.middle();
        from.norm() < self.radius(from.y.atan2(from.x))
    }
}

/// What shapes cover together, less holes, in m².
pub fn area_m2(shapes: &[Shape], holes: &[Shape]) -> f64 {
    // What is there twice would have no outline of its own.
    let once = |all: &[Shape]| -> Vec<Shape> {
        (0..all.len()).filter(|i| !all[..*i].contains(&all[*i])).map(|i| all[i].clone()).collect()
    };
    let (shapes, holes) = (once(shapes), once(holes));
    let among = |all: &[Shape], point, but: Option<usize>| {
        all.iter().enumerate().any(|(i, shape)| Some(i) != but && shape.contains(point))
    };
    let of_shapes = shapes
        .iter()
        .enumerate()
        .map(|(i, shape)| along(shape, &|point| !among(&shapes, point, Some(i)) && !among(&holes, point, None)));
    let of_holes = holes
        .iter()
        .enumerate()
        .map(|(i, hole)| -along(hole, &|point| among(&shapes, point, None) && !among(&holes, point, Some(i))));
    of_shapes.chain(of_holes).sum()
}

/// ½ ∮ (x dy - y dx) over the part of an outline that bounds.
fn along(shape: &Shape, bounds: &dyn Fn(Vector2<f64>) -> bool) -> f64 {
    let step = TAU / STEPS as f64;
    let is_bound = |direction: f64| bounds(shape.at(direction));
    let mut sum = 0.0;
    let (mut from, mut was) = (0.0, is_bound(0.0));
    for i in 1..=STEPS {
        let to = i as f64 * step;
        let is = is_bound(to);
        if was == is {
            sum += if is { between(shape, from, to) } else { 0.0 };
        } else {
            let (mut low, mut high) = (from, to);
            for _ in 0..HALVINGS {
                let middle = 0.5 * (low + high);
                if is_bound(middle) == was { low = middle } else { high = middle }
            }
            sum += if is { between(shape, high, to) } else { between(shape, from, low) };
        }
        (from, was) = (to, is);
    }
    sum
}

/// Between two directions: the triangle of the origin, and a sixth of the corrections of Simpson's rule.
fn between(shape: &Shape, from: f64, to: f64) -> f64 {
    let (a, m, b) = (shape.at(from), shape.at(0.5 * (from + to)), shape.at(to));
    // ½ ∫ p × p' of the parabola through three points.
    0.5 * a.perp(&b) + (2.0 / 3.0) * (m - a).perp(&(b - m))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    #[test]
    fn areas_are_those_of_closed_forms() {
        let close = |area: f64, truth: f64| assert!((area / truth - 1.0).abs() < 1e-9, "{area} {truth}");
        let disc = |x, r| Shape::disc([x, 0.003], r);
        close(area_m2(&[disc(0.2, 0.01)], &[]), PI * 1e-4);
        let ellipse = Shape::Ellipse { middle_m: [0.3, -0.1], half_m: [0.02, 0.01], turn_rad: 0.7 };
        close(area_m2(std::slice::from_ref(&ellipse), &[]), PI * 2e-4);
        // r₀² π (1 + Σ a²/2).
        let blot = Shape::Blot { middle_m: [0.0; 2], radius_m: 0.01, waves: vec![[0.1, 0.3], [0.05, 1.0]] };
        close(area_m2(&[blot], &[]), PI * 1e-4 * (1.0 + 0.5 * (0.01 + 0.0025)));
        // Twice the same is once.
        close(area_m2(&[disc(0.0, 0.01), disc(0.0, 0.01)], &[]), PI * 1e-4);
        // Two discs as far apart as their radius: 2 π r² - r² (2π/3 - √3/2).
        let lens = 2.0 * PI / 3.0 - 0.75_f64.sqrt();
        close(area_m2(&[disc(0.0, 0.01), disc(0.01, 0.01)], &[]), 1e-4 * (2.0 * PI - lens));
        // One as a hole in the other, and one inside.
        close(area_m2(&[disc(0.0, 0.01)], &[disc(0.01, 0.01)]), 1e-4 * (PI - lens));
        close(area_m2(&[disc(0.0, 0.01)], &[disc(0.002, 0.005)]), PI * 0.75e-4);
        close(area_m2(&[disc(0.0, 0.01)], &[disc(0.1, 0.01)]), PI * 1e-4);
        assert!(area_m2(&[disc(0.0, 0.01)], &[disc(0.0, 0.02)]).abs() < 1e-15);
    }

    #[test]
    fn a_rectangle_with_round_corners_has_its_area_but_for_its_kinks() {
        let area = |corner_m| {
            area_m2(&[Shape::Rectangle { middle_m: [0.01; 2], half_m: [0.02, 0.01], corner_m, turn_rad: 0.3 }], &[])
        };
        for corner in [0.0, 0.002, 0.01] {
            let truth = 8e-4 - (4.0 - PI) * corner * corner;
            assert!((area(corner) / truth - 1.0).abs() < 1e-6, "{corner}: {} {truth}", area(corner));
        }
    }

    #[test]
    fn what_is_no_shape_is_known() {
        assert!(Shape::disc([0.0; 2], 0.01).is_sound());
        for bad in [
            Shape::disc([0.0; 2], 0.0),
            Shape::disc([f64::NAN, 0.0], 0.01),
            Shape::Blot { middle_m: [0.0; 2], radius_m: 0.01, waves: vec![[0.7, 0.0], [0.4, 0.0]] },
            Shape::Rectangle { middle_m: [0.0; 2], half_m: [0.01, f64::NAN], corner_m: 0.0, turn_rad: 0.0 },
        ] {
            assert!(!bad.is_sound(), "{bad:?}");
        }
    }
}
