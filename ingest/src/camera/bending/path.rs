//! A plane curve by its tangent: what a bending finger's centreline is.
//!
//! ```text
//! θ(s) = Σ a_k u^k, u = 2 s/L - 1        c(s) = c₀ + o n₀ + ∫ (cos θ, sin θ) ds
//! ```
//!
//! A degree of 1 is an arc of constant curvature. Beyond the part that was seen the curvature stays as it is at its end. Unknown are o,
//! the shift across the beginning, and the `a_k`; they are found by Gauss and Newton's steps from how far points lie beside the curve.

use nalgebra::{DMatrix, DVector, Vector2};

use crate::camera::curve::together;
use crate::camera::picture::Place;

/// The tangent is a polynomial of this degree at most.
pub(super) const DEGREE_MAX: usize = 5;

/// Steps of the integrals over the part that was seen, and over as much again beyond each end, as a share.
const STEPS: usize = 160;
const BEYOND: f64 = 0.3;

/// Steps of a fit.
const ROUNDS: usize = 12;

/// A fit has settled where the curve moves by so little, in px.
const SETTLED_PX: f64 = 1e-7;

/// Points farther beside the curve than so many standard deviations of the others are no part of it.
const FAR_STDS: f64 = 4.5;

/// A curve.
#[derive(Debug, Clone)]
pub(super) struct Path {
    start: Place,
    length: f64,
    /// The tangent's polynomial.
    pub angles: Vec<f64>,
    /// Of o and the angles.
    covariance: DMatrix<f64>,
    /// The same of points that stray by one px each.
    per_point: DMatrix<f64>,
    /// Standard deviation of the points about it, in px.
    pub left: f64,
    /// By how much neighbouring points stray together.
    pub together: f64,
    /// Sum of squares that is left, and of how many points.
    pub squares: (f64, usize),
    table: Table,
}

/// Places along the curve, and how they move with each unknown.
#[derive(Debug, Clone, Default)]
struct Table {
    step: f64,
    from: f64,
    places: Vec<Place>,
    /// ∫ u^k n ds from the beginning, by place and k.
    moves: Vec<Vec<Vector2<f64>>>,
}

fn tangent(angle: f64) -> Vector2<f64> {
    Vector2::new(angle.cos(), angle.sin())
}

fn normal(angle: f64) -> Vector2<f64> {
    Vector2::new(-angle.sin(), angle.cos())
}

impl Path {
    /// A curve with this tangent, from a place.
    pub fn new(start: Place, length: f64, angles: Vec<f64>) -> Self {
        let unknowns = angles.len() + 1;
        let mut path = Self {
            start,
            length,
            angles,
            covariance: DMatrix::zeros(unknowns, unknowns),
            per_point: DMatrix::zeros(unknowns, unknowns),
            left: 0.0,
            together: 1.0,
            squares: (0.0, 0),
            table: Table::default(),
        };
        path.tabulate();
        path
    }

    /// Of a polygon: the tangent fitted to its sides.
    pub fn of_polygon(places: &[Place], degree: usize) -> Option<Self> {
        let sides: Vec<Vector2<f64>> = places.windows(2).map(|w| w[1] - w[0]).collect();
        let length: f64 = sides.iter().map(Vector2::norm).sum();
        let degree = degree.min(sides.len().checked_sub(1)?);
        let (mut s, mut last) = (0.0, f64::NAN);
        let mut rows = Vec::new();
        for side in &sides {
            let mut angle = side.y.atan2(side.x);
            if last.is_finite() {
                angle = last + wrapped(angle - last);
            }
            last = angle;
            rows.push((2.0 * (s + 0.5 * side.norm()) / length - 1.0, angle, side.norm()));
            s += side.norm();
        }
        let matrix = DMatrix::from_fn(rows.len(), degree + 1, |i, k| rows[i].2 * power(rows[i].0, k));
        let right = DVector::from_fn(rows.len(), |i, _| rows[i].2 * rows[i].1);
        let solved = matrix.svd(true, true).solve(&right, 1e-10).ok()?;
        (length > 0.0).then(|| Self::new(places[0], length, solved.iter().copied().collect()))
    }

    /// The length of the part that was seen, in px.
    pub fn length(&self) -> f64 {
        self.length
    }

    /// Of the tangent's polynomial.
    pub fn degree(&self) -> usize {
        self.angles.len() - 1
    }

    /// 1, u, u², ... at a place of the curve, and on as a straight line beyond what was seen.
    fn basis(&self, s: f64, k: usize) -> f64 {
        let u = 2.0 * s / self.length - 1.0;
        let end = u.clamp(-1.0, 1.0);
        power(end, k) + if k > 0 { k as f64 * power(end, k - 1) * (u - end) } else { 0.0 }
    }

    /// Direction of the tangent, in rad from x towards y.
    pub fn angle(&self, s: f64) -> f64 {
        self.angles.iter().enumerate().map(|(k, a)| a * self.basis(s, k)).sum()
    }

    /// Standard uncertainty of how much the tangent turns between two places.
    pub fn turn_std(&self, from: f64, to: f64) -> f64 {
        let g = DVector::from_fn(self.angles.len() + 1, |i, _| {
            if i == 0 { 0.0 } else { self.basis(to, i - 1) - self.basis(from, i - 1) }
        });
        (g.transpose() * &self.covariance * &g)[(0, 0)].max(0.0).sqrt()
    }

    /// Standard uncertainty of the tangent itself.
    pub fn angle_std(&self, s: f64) -> f64 {
        let g = DVector::from_fn(self.angles.len() + 1, |i, _| if i == 0 { 0.0 } else { self.basis(s, i - 1) });
        (g.transpose() * &self.covariance * &g)[(0, 0)].max(0.0).sqrt()
    }

    /// Curvature in 1/px, and its standard uncertainty.
    pub fn curvature(&self, s: f64) -> (f64, f64) {
        let u = (2.0 * s / self.length - 1.0).clamp(-1.0, 1.0);
        let of = |k: usize| if k > 0 { k as f64 * power(u, k - 1) * 2.0 / self.length } else { 0.0 };
        let value = self.angles.iter().enumerate().map(|(k, a)| a * of(k)).sum();
        let g = DVector::from_fn(self.angles.len() + 1, |i, _| if i == 0 { 0.0 } else { of(i - 1) });
        (value, (g.transpose() * &self.covariance * &g)[(0, 0)].max(0.0).sqrt())
    }

    /// Where it is.
    pub fn at(&self, s: f64) -> Place {
        let (i, part) = self.table.locate(s);
        let (a, b) = (self.table.places[i], self.table.places[i + 1]);
        // On the arc between two entries, not on its chord.
        let (before, behind) = (self.angle(self.table.s(i)), self.angle(self.table.s(i + 1)));
        let h = self.table.step;
        let (p, q) = (part, 1.0 - part);
        a * (q * q * (1.0 + 2.0 * p)) + b * (p * p * (3.0 - 2.0 * p)) + tangent(before) * (h * p * q * q)
            - tangent(behind) * (h * p * p * q)
    }

    /// How far a place moves across the curve with each unknown.
    fn moves(&self, s: f64) -> DVector<f64> {
        let across = normal(self.angle(s));
        let (i, part) = self.table.locate(s);
        let first = normal(self.angle(0.0));
        DVector::from_fn(self.angles.len() + 1, |k, _| {
            if k == 0 {
                first.dot(&across)
            } else {
                let (a, b) = (self.table.moves[i][k - 1], self.table.moves[i + 1][k - 1]);
                (a + (b - a) * part).dot(&across)
            }
        })
    }

    /// Standard uncertainty, across the curve, of a place so far ahead on the tangent at another, in px.
    pub fn across_std(&self, s: f64, ahead: f64) -> f64 {
        let turns = DVector::from_fn(self.angles.len() + 1, |i, _| if i == 0 { 0.0 } else { self.basis(s, i - 1) });
        let g = self.moves(s) + turns * ahead;
        (g.transpose() * &self.covariance * &g)[(0, 0)].max(0.0).sqrt()
    }

    /// The place of the curve that is nearest to another, near a guess.
    pub fn nearest(&self, place: Place, near: f64) -> f64 {
        let mut s = near;
        for _ in 0..20 {
            let apart = place - self.at(s);
            let angle = self.angle(s);
            let bend = 1.0 - self.curvature(s).0 * apart.dot(&normal(angle));
            let step = apart.dot(&tangent(angle)) / if bend > 0.2 { bend } else { 1.0 };
            s = (s + step).clamp(-BEYOND * self.length, (1.0 + BEYOND) * self.length);
            if step.abs() < 1e-9 {
                break;
            }
        }
        s
    }

    /// The same from anywhere on the curve.
    pub fn nearest_of_all(&self, place: Place) -> f64 {
        let apart = |i: &usize| (self.table.places[*i] - place).norm();
        let best = (0..self.table.places.len()).min_by(|a, b| apart(a).total_cmp(&apart(b))).unwrap_or(0);
        self.nearest(place, self.table.s(best))
    }

    fn tabulate(&mut self) {
        let step = self.length / STEPS as f64;
        let beyond = (BEYOND * STEPS as f64).ceil();
        // Some hundred.
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        let before = beyond as usize;
        let count = STEPS + 2 * before + 1;
        let from = -beyond * step;
        let s = |i: usize| from + step * i as f64;
        let degree = self.angles.len();
        let mut places = vec![Place::zeros(); count];
        let mut moves = vec![vec![Vector2::zeros(); degree]; count];
        // By Simpson's rule, both ways from the beginning.
        let part = |a: f64, b: f64| {
            let middle = f64::midpoint(a, b);
            let at = |v: f64| self.angle(v);
            let (ta, tm, tb) = (at(a), at(middle), at(b));
            let place = (tangent(ta) + tangent(tm) * 4.0 + tangent(tb)) * ((b - a) / 6.0);
            let of = |k: usize| {
                let sum = normal(ta) * self.basis(a, k)
                    + normal(tm) * (4.0 * self.basis(middle, k))
                    + normal(tb) * self.basis(b, k);
                sum * ((b - a) / 6.0)
            };
            (place, (0..degree).map(of).collect::<Vec<_>>())
        };
        places[before] = self.start;
        for i in before + 1..count {
            let (place, of) = part(s(i - 1), s(i));
            places[i] = places[i - 1] + place;
            moves[i] = moves[i - 1].iter().zip(of).map(|(a, b)| a + b).collect();
        }
        for i in (0..before).rev() {
            let (place, of) = part(s(i), s(i + 1));
            places[i] = places[i + 1] - place;
            moves[i] = moves[i + 1].iter().zip(of).map(|(a, b)| a - b).collect();
        }
        self.table = Table { step, from, places, moves };
    }

    /// The curve of a degree through points, each with where on this curve it lies about. `None` if they are too few.
    pub fn fitted(&self, points: &[(f64, Place)], degree: usize) -> Option<Self> {
        self.fitted_within(points, degree, FAR_STDS)
    }

    /// The same where none of the points may be left out.
    pub fn fitted_to_all(&self, points: &[(f64, Place)], degree: usize) -> Option<Self> {
        self.fitted_within(points, degree, f64::INFINITY)
    }

    /// The same curve where its points are known no better than so many px.
    pub fn known_to(mut self, least_px: f64) -> Self {
        if self.left < least_px {
            self.covariance = &self.per_point * (least_px * least_px);
        }
        self
    }

    fn fitted_within(&self, points: &[(f64, Place)], degree: usize, far_stds: f64) -> Option<Self> {
        let mut angles = self.angles.clone();
        angles.resize(degree + 1, 0.0);
        if degree + 1 < self.angles.len() {
            angles = self.lower(degree)?;
        }
        let mut path = Self::new(self.start, self.length, angles);
        let unknowns = degree + 2;
        let mut used = vec![true; points.len()];
        let mut feet: Vec<f64> = points.iter().map(|(s, place)| path.nearest(*place, *s)).collect();
        let mut last = DMatrix::zeros(unknowns, unknowns);
        for round in 0..ROUNDS {
            let beside = |path: &Self, i: usize, s: f64| (points[i].1 - path.at(s)).dot(&normal(path.angle(s)));
            let (mut matrix, mut right) = (DMatrix::zeros(unknowns, unknowns), DVector::zeros(unknowns));
            let chosen: Vec<usize> = (0..points.len()).filter(|i| used[*i]).collect();
            if chosen.len() < unknowns {
                return None;
            }
            for &i in &chosen {
                let row = path.moves(feet[i]);
                right += &row * beside(&path, i, feet[i]);
                matrix += &row * row.transpose();
            }
            let inverse = matrix.cholesky()?.inverse();
            let step = &inverse * right;
            last = inverse;
            let across = normal(path.angle(0.0));
            let moved = path.angles.iter().zip(step.iter().skip(1)).map(|(a, d)| a + d).collect();
            path = Self::new(path.start + across * step[0], self.length, moved);
            feet = points.iter().zip(&feet).map(|((_, place), s)| path.nearest(*place, *s)).collect();
            let left: Vec<f64> = (0..points.len()).map(|i| beside(&path, i, feet[i])).collect();
            let of_used: Vec<f64> = chosen.iter().map(|&i| left[i]).collect();
            let freedom = chosen.len().saturating_sub(unknowns);
            let squares: f64 = of_used.iter().map(|r| r * r).sum();
            path.squares = (squares, chosen.len());
            path.left = if freedom > 0 { (squares / freedom as f64).sqrt() } else { 0.0 };
            path.together = together(&of_used);
            let usual = 1.482_6 * crate::camera::curve::median(of_used.iter().map(|r| r.abs()).collect());
            let far = far_stds * (usual + 1e-6);
            let next: Vec<bool> = left.iter().map(|r| freedom == 0 || r.abs() <= far).collect();
            let is_settled =
                step.iter().skip(1).map(|d| d.abs() * self.length).fold(step[0].abs(), f64::max) < SETTLED_PX;
            if is_settled && next == used && round > 0 {
                break;
            }
            // Points that come and go late would keep it from settling.
            if round < ROUNDS / 2 {
                used = next;
            }
        }
        path.covariance = &last * (path.left * path.left * path.together);
        path.per_point = last;
        let sound = path.angles.iter().all(|a| a.is_finite()) && path.start.iter().all(|v| v.is_finite());
        sound.then_some(path)
    }

    /// The angles of a lower degree that come nearest.
    fn lower(&self, degree: usize) -> Option<Vec<f64>> {
        let places: Vec<f64> = (0..=40).map(|i| self.length * f64::from(i) / 40.0).collect();
        let matrix = DMatrix::from_fn(places.len(), degree + 1, |i, k| self.basis(places[i], k));
        let right = DVector::from_fn(places.len(), |i, _| self.angle(places[i]));
        Some(matrix.svd(true, true).solve(&right, 1e-12).ok()?.iter().copied().collect())
    }
}

impl Table {
    fn s(&self, i: usize) -> f64 {
        self.from + self.step * i as f64
    }

    /// The entry before a place, and how far behind it, as a share of a step.
    fn locate(&self, s: f64) -> (usize, f64) {
        let place = ((s - self.from) / self.step).clamp(0.0, (self.places.len() - 1) as f64);
        // Within the table by what stands before; NaN becomes the first.
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        let i = (place as usize).min(self.places.len() - 2);
        (i, place - i as f64)
    }
}

fn power(u: f64, k: usize) -> f64 {
    (0..k).fold(1.0, |p, _| p * u)
}

/// An angle within ± π.
pub(super) fn wrapped(angle: f64) -> f64 {
    let turn = std::f64::consts::TAU;
    angle - turn * (angle / turn).round()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_arc_and_a_clothoid_are_found_from_points_on_them() {
        for angles in [vec![0.3, 0.9], vec![0.3, 0.9, 0.4]] {
            let truth = Path::new(Place::new(50.0, 80.0), 400.0, angles.clone());
            // A quarter of a turn and more; beside it by nothing.
            let points: Vec<(f64, Place)> =
                (0..=200).map(|i| (2.0 * f64::from(i), truth.at(2.0 * f64::from(i)))).collect();
            let polygon: Vec<Place> = points.iter().step_by(20).map(|p| p.1).collect();
            let start = Path::of_polygon(&polygon, DEGREE_MAX).unwrap();
            let found = start.fitted(&points, angles.len() - 1).unwrap();
            let ends = [found.nearest_of_all(points[0].1), found.nearest_of_all(points[200].1)];
            let turn = found.angle(ends[1]) - found.angle(ends[0]);
            let expected = truth.angle(400.0) - truth.angle(0.0);
            assert!((turn - expected).abs() < 1e-5, "{turn} {expected}");
            assert!(found.left < 1e-4 && (ends[1] - ends[0] - 400.0).abs() < 1e-3, "{} {ends:?}", found.left);
            let (middle, at) = (found.curvature(0.5 * (ends[0] + ends[1])).0, truth.curvature(200.0).0);
            assert!((middle / at - 1.0).abs() < 1e-3, "{middle} {at}");
        }
    }

    #[test]
    fn an_arc_is_where_geometry_puts_it() {
        // Half a turn of a radius of 100 px.
        let half = std::f64::consts::FRAC_PI_2;
        let arc = Path::new(Place::zeros(), 100.0 * std::f64::consts::PI, vec![half, half]);
        let end = arc.at(arc.length());
        assert!((end - Place::new(0.0, 200.0)).norm() < 1e-6, "{end}");
        assert!((arc.at(0.5 * arc.length()) - Place::new(100.0, 100.0)).norm() < 1e-6);
        assert!((arc.curvature(70.0).0 - 0.01).abs() < 1e-12);
        assert!((arc.nearest(Place::new(150.0, 100.0), 120.0) - 50.0 * std::f64::consts::PI).abs() < 1e-6);
        // Beyond its end it goes on at its curvature.
        assert!((arc.angle(1.1 * arc.length()) - 1.1 * std::f64::consts::PI).abs() < 1e-12);
    }
}
