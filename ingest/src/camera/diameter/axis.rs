//! The axis of a round body: the line on which the middles between its sides lie.
//!
//! Middles are taken across a guess of the axis, which is turned until they go straight on along it: then, and only then, both sides are
//! mirror images. How much their slope changes with the turn depends on the body: by -1 of a cylinder, hardly of a ball, the other way of
//! what bulges more.

use nalgebra::Vector2;

use super::outline::{common, opposite, wide_part};
use crate::camera::curve::Curve;
use crate::camera::picture::Place;
use crate::camera::silhouette::Axis;

/// The degree of the curves that tell which part is wide.
const DEGREE: usize = 4;

/// Middles that stray from a curve of such a degree are none: of a tilted body they lie on one as long as they are taken along rows.
const DEGREE_MIDDLE: usize = 2;

/// Turns at most; the axis is found where the middles go over by so little, as a slope.
const ROUNDS: usize = 12;
const STRAIGHT: f64 = 1e-6;
const TURN_MAX: f64 = 0.2;

/// Where their slope changes by less than this share of the turn, the body is too round to tell its axis.
const GAIN_MIN: f64 = 0.01;

/// Two sides, as places along the axis and across.
pub(super) type Sides = [Vec<(f64, f64)>; 2];

/// An axis: places along it and across it, from a place on it or beside.
#[derive(Clone, Copy)]
pub(super) struct Frame {
    origin: Place,
    pub along: Vector2<f64>,
    pub across: Vector2<f64>,
}

impl Frame {
    /// About the middle of all places, as the axis lies roughly.
    fn upright(places: &[Vec<Place>; 2], axis: Axis) -> Self {
        let n = (places[0].len() + places[1].len()) as f64;
        let origin = places.iter().flatten().sum::<Place>() / n;
        let (along, across) = match axis {
            Axis::Vertical => (Vector2::new(0.0, 1.0), Vector2::new(1.0, 0.0)),
            Axis::Horizontal => (Vector2::new(1.0, 0.0), Vector2::new(0.0, 1.0)),
        };
        Self { origin, along, across }
    }

    /// Turned by so many rad, from along towards across.
    fn turned(self, by: f64) -> Self {
        let (sin, cos) = by.sin_cos();
        Self { along: self.along * cos + self.across * sin, across: self.across * cos - self.along * sin, ..self }
    }

    /// Places along it and across.
    pub fn of(&self, places: &[Vec<Place>; 2]) -> Sides {
        places
            .each_ref()
            .map(|side| side.iter().map(|p| (self.along_of(*p), self.across.dot(&(p - self.origin)))).collect())
    }

    /// How far along it a place lies.
    pub fn along_of(&self, place: Place) -> f64 {
        self.along.dot(&(place - self.origin))
    }

    /// The place that lies so far along it and across.
    pub fn place(&self, along: f64, across: f64) -> Place {
        self.origin + self.along * along + self.across * across
    }
}

/// What the sides say of their axis.
pub(super) struct Found {
    pub frame: Frame,
    /// The part of it along which the body is wide.
    pub wide: (f64, f64),
    /// By how much the slope of the middles changes with a turn.
    pub gain: f64,
}

/// The axis of two sides; `None` of too few edges.
pub(super) fn axis(places: &[Vec<Place>; 2], roughly: Axis) -> Option<Found> {
    let upright = Frame::upright(places, roughly);
    let mut frame = upright;
    let mut sides = frame.of(places);
    let whole = common(&sides)?;
    let wide = wide_part(&[Curve::fit(&sides[0], whole, DEGREE)?, Curve::fit(&sides[1], whole, DEGREE)?]);
    // What is no part of the outlines stays so, however they are turned.
    let paired = middles(&sides, wide);
    // A body that is nearly round hardly shows how it is turned: secants find what single steps creep up to.
    let (mut turn, mut last, mut gain): (f64, Option<(f64, f64)>, f64) = (0.0, None, -1.0);
    for _ in 0..ROUNDS {
        let slope = middle_slope(&sides, &paired)?;
        if slope.abs() < STRAIGHT {
            break;
        }
        if let Some((before, then)) = last {
            gain = (slope - then) / (turn - before);
            if gain.abs() < GAIN_MIN {
                break;
            }
        }
        last = Some((turn, slope));
        turn += (-slope / gain).clamp(-TURN_MAX, TURN_MAX);
        frame = upright.turned(turn);
        sides = frame.of(places);
    }
    Some(Found { frame, wide, gain })
}

/// Edges of the left side in a part whose middles lie on one line, as far as most do.
fn middles(points: &[Vec<(f64, f64)>; 2], (from, to): (f64, f64)) -> Vec<usize> {
    let inside = |i: &usize| (from..=to).contains(&points[0][*i].0);
    let mut opposite = opposite(points);
    let mut of = |i: usize| opposite(i).map(|(v, a, b)| (i, (v, f64::midpoint(a, b))));
    let all: Vec<(usize, (f64, f64))> = (0..points[0].len()).filter(inside).filter_map(&mut of).collect();
    let middles: Vec<(f64, f64)> = all.iter().map(|(_, m)| *m).collect();
    match Curve::fit(&middles, (from, to), DEGREE_MIDDLE) {
        Some(curve) => all.iter().zip(&curve.used).filter(|(_, used)| **used).map(|((i, _), _)| *i).collect(),
        None => all.into_iter().map(|(i, _)| i).collect(),
    }
}

/// The slope of the straight line through the middles between both sides.
fn middle_slope(points: &[Vec<(f64, f64)>; 2], left: &[usize]) -> Option<f64> {
    let mut opposite = opposite(points);
    let mut of = |i: &usize| opposite(*i).map(|(v, a, b)| (v, f64::midpoint(a, b)));
    let middles: Vec<(f64, f64)> = left.iter().filter_map(&mut of).collect();
    let n = middles.len() as f64;
    let (mean_v, mean_u) = middles.iter().fold((0.0, 0.0), |(a, b), (v, u)| (a + v / n, b + u / n));
    let sums = middles.iter().map(|(v, u)| ((v - mean_v).powi(2), (v - mean_v) * (u - mean_u)));
    let (vv, vu) = sums.fold((0.0, 0.0), |(a, b), (c, d)| (a + c, b + d));
    (vv > 0.0).then(|| vu / vv)
}
