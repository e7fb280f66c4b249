//! Edges along the rows of a picture.

use crate::camera::curve::median;
use crate::camera::edge::{Blur, Edge, Kernels};
use crate::camera::picture::{Picture, Place};
use crate::camera::silhouette::Axis;

/// A step of brightness from either end is as good as the end.
const END_STEP: f32 = 0.5;

/// An edge beside which so much of the line lies at an end of the brightness is saturated.
const CLIPPED_SHARE: f64 = 0.6;

/// A guess is good within this share of the blur; there are so many at most.
const GOOD_BLURS: f64 = 0.4;
const STEPS_MAX: usize = 5;

/// The picture as rows across the axis.
pub(super) struct Rows<'a> {
    picture: &'a Picture,
    axis: Axis,
}

impl Rows<'_> {
    pub fn length(&self) -> usize {
        match self.axis {
            Axis::Vertical => self.picture.width(),
            Axis::Horizontal => self.picture.height(),
        }
    }

    pub fn count(&self) -> usize {
        match self.axis {
            Axis::Vertical => self.picture.height(),
            Axis::Horizontal => self.picture.width(),
        }
    }

    fn read(&self, row: usize, from: usize, into: &mut [f32]) {
        match self.axis {
            Axis::Vertical => self.picture.luma_row(row, from, into),
            Axis::Horizontal => {
                into.iter_mut().enumerate().for_each(|(i, value)| *value = self.picture.luma(row, from + i));
            }
        }
    }

    pub fn place(&self, row: f64, at: f64) -> Place {
        match self.axis {
            Axis::Vertical => Place::new(at, row),
            Axis::Horizontal => Place::new(row, at),
        }
    }
}

/// An edge on a row.
#[derive(Debug, Clone, Copy)]
pub(super) struct Found {
    /// The row it lies on.
    pub row: f64,
    /// Where on it, in px.
    pub at: f64,
    /// What its line says.
    pub edge: Edge,
    /// Whether brightness beside it is at an end of its range.
    pub is_clipped: bool,
    /// Like its neighbours.
    pub is_sound: bool,
}

/// Looks for edges along rows.
pub(super) struct Seeker<'a> {
    pub rows: Rows<'a>,
    blur: Blur,
    kernels: Kernels,
    line: Vec<f32>,
}

impl<'a> Seeker<'a> {
    pub fn new(picture: &'a Picture, axis: Axis) -> Self {
        let rows = Rows { picture, axis };
        Self { rows, blur: Blur::new(), kernels: Kernels::default(), line: Vec::new() }
    }

    /// The edge of a row near a place, of an outline that goes over so many px a row there: one step away, or some where the outline was not
    /// that good a guess.
    pub fn near(&mut self, row: usize, guess: f64, slope: f64, blur_px: f64) -> Option<Found> {
        let seen_px = blur_px * slope.mul_add(slope, 1.0).sqrt();
        let mut guess = guess;
        for step in 1.. {
            let window = Kernels::window(guess, seen_px)?;
            if window.from + window.length > self.rows.length() {
                return None;
            }
            self.line.resize(window.length, 0.0);
            self.rows.read(row, window.from, &mut self.line);
            let edge = self.kernels.edge(&self.blur, window, &self.line)?;
            let at = window.from as f64 + edge.at;
            if (at - guess).abs() < GOOD_BLURS * seen_px {
                return Some(self.found(row, window.from, edge));
            }
            if step == STEPS_MAX {
                return None;
            }
            guess = at;
        }
        None
    }

    /// The edge of a row near a place, and by how much its blur should be wider, after so many steps.
    pub fn edge(&mut self, row: usize, guess: f64, slope: f64, blur_px: f64, steps: usize) -> Option<Found> {
        let seen_px = blur_px * slope.mul_add(slope, 1.0).sqrt();
        let reach = Blur::reach_px(seen_px);
        let from = whole(guess - reach)?;
        let length = whole(2.0 * reach)? + 1;
        if from + length > self.rows.length() {
            return None;
        }
        self.line.resize(length, 0.0);
        self.rows.read(row, from, &mut self.line);
        let edge = self.blur.edge(&self.line, guess - from as f64, seen_px, true, steps)?;
        Some(self.found(row, from, edge))
    }

    /// What the line at hand says.
    fn found(&self, row: usize, from: usize, edge: Edge) -> Found {
        let clipped = self.line.iter().filter(|v| **v <= END_STEP || **v >= 255.0 - END_STEP).count();
        let is_clipped = clipped as f64 > CLIPPED_SHARE * 0.5 * self.line.len() as f64;
        Found { row: row as f64, at: from as f64 + edge.at, edge, is_clipped, is_sound: true }
    }

    /// Where a row crosses half of its way near a place that is a step of the grid off, and how wide that crossing is.
    pub fn crossing(&mut self, row: usize, near: usize, step: usize) -> Option<(f64, f64)> {
        const SMOOTH: usize = 5;
        let side = 2 * step + 12;
        let from = near.checked_sub(side)?;
        let length = 2 * side + 1;
        if from + length > self.rows.length() {
            return None;
        }
        self.line.resize(length, 0.0);
        self.rows.read(row, from, &mut self.line);
        let smooth: Vec<f64> =
            self.line.windows(SMOOTH).map(|w| w.iter().map(|v| f64::from(*v)).sum::<f64>() / SMOOTH as f64).collect();
        // The steepest place, over the width of the smoothing.
        let steep = |i: usize| (smooth[i + SMOOTH] - smooth[i]).abs();
        let top = (0..smooth.len() - SMOOTH).max_by(|a, b| steep(*a).total_cmp(&steep(*b)))?;
        let levels = (median(smooth[..=top.saturating_sub(SMOOTH)].to_vec()), {
            median(smooth[(top + 2 * SMOOTH).min(smooth.len() - 1)..].to_vec())
        });
        let share = |i: usize| (smooth[i] - levels.0) / (levels.1 - levels.0);
        let cross = |level: f64, way: Vec<usize>| {
            let i = way.into_iter().find(|&i| (share(i) > level) != (share(i + 1) > level))?;
            Some(i as f64 + (level - share(i)) / (share(i + 1) - share(i)))
        };
        let middle = top + SMOOTH / 2;
        let last = smooth.len() - 1;
        let half = cross(0.5, (top..(top + SMOOTH + 1).min(last)).collect())?;
        let quarter = cross(0.25, (0..middle.min(last)).rev().collect());
        let three = cross(0.75, (middle..last).collect());
        let width = quarter.zip(three).map_or(f64::NAN, |(a, b)| (b - a).abs());
        let at = from as f64 + half + (SMOOTH / 2) as f64;
        at.is_finite().then_some((at, width))
    }
}

/// A number of px; `None` below zero.
fn whole(px: f64) -> Option<usize> {
    // Pictures have far fewer px than 2⁵².
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
    (0.0..1e9).contains(&px).then_some(px as usize)
}
