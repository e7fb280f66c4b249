//! The two outlines of a finger along its centreline, and its end.

use nalgebra::Vector2;

use super::path::Path;
use crate::camera::curve::{Curve, DEGREE_MAX as CURVE_DEGREE_MAX, median};
use crate::camera::diameter::EdgeUse;
use crate::camera::edge::{Blur, Edge};
use crate::camera::picture::{Picture, Place};

/// Stations along the centreline are so many px apart.
const STATION_PX: f64 = 1.5;

/// An edge is odd where it lies farther from the middle of its neighbours than so many of their deviations, and px.
const NEIGHBOURS: usize = 9;
const ODD_STDS: f64 = 4.0;
const ODD_PX: f64 = 1.0;

/// Blur in px that is looked for.
const BLUR_PX: (f64, f64) = (0.5, 10.0);

/// A step of brightness from either end is as good as the end.
const END_STEP: f32 = 0.5;

/// The end is looked at over this share of half the width to both sides, by a curve of this degree.
const END_SHARE: f64 = 0.55;
const END_DEGREE: usize = 4;
const END_ROUNDS: usize = 4;

/// A side is wavy where it strays so many times as much as the other, and so many px.
const WAVY: f64 = 3.0;
const WAVY_PX: f64 = 0.3;

/// The width between waves is told by this share of all widths, the smallest ones, without the very smallest.
const BETWEEN: (f64, f64) = (0.02, 0.3);

/// Shoulders of a mount are looked for on so many lines to each side, from and to so many halves of the width.
const SHOULDER_LINES: usize = 10;
const SHOULDER: (f64, f64) = (1.25, 1.6);

/// Half the width over the radius of an end that is flat, and of one that is round.
const ROUND: (f64, f64) = (0.25, 0.75);

/// An edge of less than this share of the others' height is none.
const HEIGHT_SHARE: f64 = 0.4;

/// Brightness of a finger, and how it is looked at.
pub(super) struct Looked<'a> {
    pub picture: &'a Picture,
    pub blur: Blur,
    pub is_dark: bool,
    pub blur_px: f64,
    /// Brightness within and without, beside the edges, in steps; zeros as long as that is not known.
    pub levels: (f64, f64),
}

/// Both edges at stations along a centreline.
#[derive(Debug, Clone, Default)]
pub(super) struct Sides {
    /// Where along it.
    pub stations: Vec<f64>,
    /// How far the edges lie to either side of it, in px; NaN where there is none.
    pub edges: [Vec<f64>; 2],
    /// Share of edges beside brightness that is as high or as low as can be.
    pub clipped: f64,
}

/// The end of a finger: from a place of the centreline on it goes straight.
#[derive(Debug, Clone, Copy)]
pub(super) struct End {
    /// Where that begins: half a width before a round end, at a flat one.
    pub s: f64,
    /// From there to the tip, in px.
    pub ahead: f64,
    /// Standard uncertainty of that.
    pub std_px: f64,
}

fn tangent(angle: f64) -> Vector2<f64> {
    Vector2::new(angle.cos(), angle.sin())
}

impl Looked<'_> {
    /// Brightness along a straight line, px by px, as far as the picture goes; `None` where it does not begin in it.
    fn line(&self, from: Place, way: Vector2<f64>, length: usize) -> Option<Vec<f32>> {
        let (w, h) = (self.picture.width() as f64 - 1.0, self.picture.height() as f64 - 1.0);
        let inside = |p: Place| p.x >= 0.0 && p.y >= 0.0 && p.x <= w && p.y <= h;
        // Brightness is held in single precision.
        #[allow(clippy::cast_possible_truncation)]
        let at = |place: Place| self.picture.between(place) as f32;
        let places = (0..length).map(|i| from + way * i as f64).take_while(|place| inside(*place));
        inside(from).then(|| places.map(at).collect())
    }

    /// The edge on a line outwards, first the steepest place of the right sense within a window, then a fit there.
    fn edge(
        &self,
        from: Place,
        way: Vector2<f64>,
        guess: f64,
        reach: f64,
        with_blur: bool,
    ) -> Option<(f64, Edge, bool)> {
        let side = Blur::reach_px(self.blur_px);
        let start = guess - reach - side;
        // Windows are some dozen px.
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        let length = (2.0 * (reach + side)).clamp(4.0, 4096.0) as usize + 1;
        let line = self.line(from + way * start, way, length)?;
        let length = line.len();
        let mut at = guess - start;
        if length < 8 {
            return None;
        }
        if reach > 0.75 {
            // Outwards a dark finger ends where it becomes brighter.
            let rises =
                |i: usize| (line[i + 4] + line[i + 3] - line[i] - line[i + 1]) * if self.is_dark { 1.0 } else { -1.0 };
            let near = |i: &usize| (*i as f64 + 2.0 - at).abs() <= reach;
            let top = (0..length - 4).filter(near).max_by(|a, b| rises(*a).total_cmp(&rises(*b)))?;
            if rises(top) <= 0.0 {
                return None;
            }
            at = top as f64 + 2.0;
        }
        // What is far from the edge says little of it, and may be another one.
        let (first, last) = ((at - side).max(0.0), (at + side).min(length as f64 - 1.0));
        // Between nought and the length.
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        let (first, last) = (first as usize, last as usize);
        let part = &line[first..=last];
        let edge = self.blur.edge(part, at - first as f64, self.blur_px, with_blur, 3)?;
        let height = (edge.levels.1 - edge.levels.0) * if self.is_dark { 1.0 } else { -1.0 };
        let rises = height > HEIGHT_SHARE * (self.levels.1 - self.levels.0).abs();
        let clipped = part.iter().filter(|v| **v <= END_STEP || **v >= 255.0 - END_STEP).count() * 3 > part.len();
        rises.then_some((start + first as f64 + edge.at, edge, clipped))
    }

    /// Edges at stations from one place of the centreline to another. `before`: those of an earlier look; else they are looked for about
    /// half the width, within a reach.
    pub fn sides(
        &mut self,
        path: &Path,
        (from, to): (f64, f64),
        half_px: f64,
        reach: f64,
        before: Option<&Sides>,
    ) -> Sides {
        // Some hundred.
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        let count = ((to - from) / STATION_PX).max(1.0) as usize + 1;
        let stations: Vec<f64> =
            (0..count).map(|i| from + (to - from) * i as f64 / (count - 1).max(1) as f64).collect();
        let mut found = Sides { edges: [vec![f64::NAN; count], vec![f64::NAN; count]], ..Sides::default() };
        let guesses = before.map(|before| before.guesses(&stations));
        let (mut wider, mut weights, mut clipped, mut seen) = (0.0, 0.0, 0.0, 0.0);
        let mut levels = [vec![], vec![]];
        for (i, s) in stations.iter().enumerate() {
            let (middle, angle) = (path.at(*s), path.angle(*s));
            let out = Vector2::new(-angle.sin(), angle.cos());
            for (side, way) in [out, -out].into_iter().enumerate() {
                let guess = guesses.as_ref().map_or(half_px, |g| g[side][i]);
                // Every eighth says how wide the blur is.
                let with_blur = i % 8 == 0;
                let Some((at, edge, is_clipped)) = self.edge(middle, way, guess, reach, with_blur) else { continue };
                if with_blur && edge.blur_step.abs() < self.blur_px {
                    wider += edge.blur_weight * edge.blur_step;
                    weights += edge.blur_weight;
                }
                seen += 1.0;
                clipped += f64::from(u8::from(is_clipped));
                levels[0].push(edge.levels.0.min(edge.levels.1));
                levels[1].push(edge.levels.0.max(edge.levels.1));
                found.edges[side][i] = at;
            }
        }
        if weights > 0.0 {
            self.blur_px = (self.blur_px + wider / weights).clamp(BLUR_PX.0, BLUR_PX.1);
        }
        let [low, high] = levels.map(median);
        self.levels = if self.is_dark { (low, high) } else { (high, low) };
        for side in &mut found.edges {
            drop_odd(side);
        }
        found.stations = stations;
        found.clipped = clipped / f64::max(seen, 1.0);
        found
    }

    /// The end of the finger, whose tip lies near a place of the centreline; and its edge.
    pub fn end(&mut self, path: &Path, near: f64, half_px: f64, reach: f64) -> Option<(End, Vec<Place>)> {
        let mut s = near - half_px;
        let mut expected = half_px;
        let mut found = None;
        for round in 0..END_ROUNDS {
            let (middle, way) = (path.at(s), tangent(path.angle(s)));
            let across = Vector2::new(-way.y, way.x);
            let wide = END_SHARE * half_px;
            // Some dozen.
            #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
            let lines = (2.0 * wide).max(6.0) as usize;
            let window = if round == 0 { reach } else { 0.15 * half_px + 2.0 };
            let mut points = Vec::new();
            for k in 0..=lines {
                let o = wide * (2.0 * k as f64 / lines as f64 - 1.0);
                if let Some((a, ..)) = self.edge(middle + across * o, way, expected, window, false) {
                    points.push((o, a));
                }
            }
            let curve = Curve::fit(&points, (-wide, wide), END_DEGREE)?;
            if curve.n() * 2 < lines {
                return None;
            }
            let (_, second) = curve.derivatives(0.0);
            // Blur moves the half level of a round end inwards.
            let shift = -0.5 * self.blur_px * self.blur_px * second;
            let ahead = curve.at(0.0) + shift;
            let std_px = curve.std_at(0.0, &points).hypot(0.5 * shift);
            let edge = points.iter().map(|(o, a)| middle + across * *o + way * *a).collect();
            found = Some((End { s, ahead, std_px }, edge));
            // A half circle begins half a width before the tip, a flat end with it: what is nearly the one or the other is it.
            let round = -second * half_px;
            expected = half_px * ((round - ROUND.0) / (ROUND.1 - ROUND.0)).clamp(0.0, 1.0);
            s += ahead - expected;
        }
        found
    }
}

impl Looked<'_> {
    /// Where a finger leaves a mount that is wider: the shoulders on both sides, and how well that is known, in px.
    pub fn shoulders(&self, path: &Path, near: f64, half_px: f64, reach: f64) -> Option<(f64, f64)> {
        let back = reach + half_px;
        let (middle, way) = (path.at(near), tangent(path.angle(near)));
        let across = Vector2::new(-way.y, way.x);
        let mut points = Vec::new();
        let mut sides = [0; 2];
        for k in 0..SHOULDER_LINES {
            let o = half_px * (SHOULDER.0 + (SHOULDER.1 - SHOULDER.0) * k as f64 / (SHOULDER_LINES - 1) as f64);
            for (side, sign) in [(0, 1.0), (1, -1.0)] {
                let from = middle + across * (sign * o) - way * back;
                if let Some((a, ..)) = self.edge(from, way, back, reach, false) {
                    points.push((sign * o, a - back));
                    sides[side] += 1;
                }
            }
        }
        if sides.iter().any(|n| 2 * n < SHOULDER_LINES) {
            return None;
        }
        let curve = Curve::fit(&points, (-SHOULDER.1 * half_px, SHOULDER.1 * half_px), 1)?;
        Some((path.nearest(middle + way * curve.at(0.0), near + curve.at(0.0)), curve.std_at(0.0, &points)))
    }
}

impl Sides {
    /// Where edges are to be expected at other stations: the middle of those around.
    fn guesses(&self, stations: &[f64]) -> [Vec<f64>; 2] {
        let usual = [0, 1].map(|k| median(self.edges[k].iter().copied().filter(|e| e.is_finite()).collect()));
        [0, 1].map(|k: usize| {
            let of = |s: &f64| {
                let i = self.stations.partition_point(|t| t < s);
                let around = i.saturating_sub(2)..(i + 3).min(self.stations.len());
                let here: Vec<f64> = self.edges[k][around].iter().copied().filter(|e| e.is_finite()).collect();
                if here.is_empty() { usual[k] } else { median(here) }
            };
            stations.iter().map(of).collect()
        })
    }

    /// Whether one side is so much rougher than the other that the other alone tells how the finger bends: which one is smooth.
    pub fn smooth_side(&self) -> Option<usize> {
        let rough = |side: &Vec<f64>| {
            let points: Vec<(f64, f64)> = self.stations.iter().copied().zip(side.iter().copied()).collect();
            let range = (*self.stations.first()?, *self.stations.last()?);
            Some(Curve::fit(&points, range, CURVE_DEGREE_MAX)?.left)
        };
        let (a, b) = (rough(&self.edges[0])?, rough(&self.edges[1])?);
        match (a > WAVY * b && a > WAVY_PX, b > WAVY * a && b > WAVY_PX) {
            (true, _) => Some(1),
            (_, true) => Some(0),
            _ => None,
        }
    }

    /// The middles between two edges, each with its station; of a finger that is wavy on one side, half of the width between the waves from
    /// the smooth side.
    pub fn middles(&self, path: &Path) -> Vec<(f64, Place)> {
        let (smooth, half) = (self.smooth_side(), self.half_px());
        let both = self.stations.iter().zip(self.edges[0].iter().zip(&self.edges[1]));
        both.filter(|(_, (a, b))| a.is_finite() && b.is_finite())
            .map(|(s, (a, b))| {
                let beside = match smooth {
                    None => 0.5 * (a - b),
                    Some(0) => a - half,
                    Some(_) => half - b,
                };
                let angle = path.angle(*s);
                (*s, path.at(*s) + Vector2::new(-angle.sin(), angle.cos()) * beside)
            })
            .collect()
    }

    /// Edges as places, for drawing.
    pub fn places(&self, path: &Path) -> Vec<(Place, EdgeUse)> {
        let mut all = Vec::new();
        for (i, s) in self.stations.iter().enumerate() {
            let angle = path.angle(*s);
            let out = Vector2::new(-angle.sin(), angle.cos());
            for (side, sign) in [(0, 1.0), (1, -1.0)] {
                let at = self.edges[side][i];
                if at.is_finite() {
                    all.push((path.at(*s) + out * (sign * at), EdgeUse::Used));
                }
            }
        }
        all
    }

    /// Half the width where both edges are: in the middle of all, or, of a finger that is wavy on one side, between the waves.
    pub fn half_px(&self) -> f64 {
        let both = self.edges[0].iter().zip(&self.edges[1]).map(|(a, b)| 0.5 * (a + b));
        let mut all: Vec<f64> = both.filter(|v| v.is_finite()).collect();
        if self.smooth_side().is_none() || all.is_empty() {
            return median(all);
        }
        all.sort_by(f64::total_cmp);
        // A trough is a parabola, or flat, or sharp: so are sorted widths over their ranks.
        let count = all.len() as f64;
        let ranked = all.iter().enumerate().map(|(i, half)| ((i as f64 + 0.5) / count, *half));
        let lowest: Vec<(f64, f64)> = ranked.filter(|(rank, _)| (BETWEEN.0..=BETWEEN.1).contains(rank)).collect();
        Curve::fit(&lowest, (0.0, BETWEEN.1), 2).map_or(all[0], |curve| curve.at(0.0))
    }
}

/// Edges that lie apart from their neighbours are none.
fn drop_odd(edges: &mut [f64]) {
    let before = edges.to_vec();
    let around = |i: usize| -> Vec<f64> {
        let range = i.saturating_sub(NEIGHBOURS)..(i + NEIGHBOURS + 1).min(before.len());
        before[range].iter().copied().filter(|e| e.is_finite()).collect()
    };
    for (i, edge) in edges.iter_mut().enumerate().filter(|(_, e)| e.is_finite()) {
        let here = around(i);
        let middle = median(here.clone());
        let spread = 1.482_6 * median(here.iter().map(|e| (e - middle).abs()).collect());
        if here.len() < 3 || (*edge - middle).abs() > (ODD_STDS * spread).max(ODD_PX) {
            *edge = f64::NAN;
        }
    }
}
