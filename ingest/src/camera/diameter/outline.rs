//! Two outlines in the frame of the axis: the part that counts, the side opposite, where they are farthest apart.

use super::Width;
use crate::camera::curve::Curve;

/// The part of the body about its widest place over which edges are taken, as a share of its largest width.
const WIDE_SHARE: f64 = 0.8;

/// Between edges that lie farther apart along the axis nobody knows the outline, in px.
const GAP_PX: f64 = 12.0;

/// Places along the axis at which the largest width is looked for.
const PLACES: usize = 200;

/// For edges of the left side, in order: where they lie along the axis and across, and the right side there, on the line through the two
/// nearest edges.
pub(super) fn opposite(points: &[Vec<(f64, f64)>; 2]) -> impl FnMut(usize) -> Option<(f64, f64, f64)> {
    let [left, right] = points;
    let mut behind = 0;
    move |i: usize| {
        let &(v, u) = left.get(i)?;
        // Turned rows are nearly in order: it goes back where they are not.
        while behind > 0 && right[behind - 1].0 >= v {
            behind -= 1;
        }
        while right.get(behind)?.0 < v {
            behind += 1;
        }
        let (a, b) = (right.get(behind.checked_sub(1)?)?, right.get(behind)?);
        let part = (v - a.0) / (b.0 - a.0);
        let is_near = b.0 - a.0 < GAP_PX && part.is_finite();
        is_near.then_some((v, u, a.1 + part * (b.1 - a.1)))
    }
}

/// The part of the axis along which both sides have edges.
pub(super) fn common(points: &[Vec<(f64, f64)>; 2]) -> Option<(f64, f64)> {
    let ends = |side: &Vec<(f64, f64)>| {
        side.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), (v, _)| (a.min(*v), b.max(*v)))
    };
    let ((a, b), (c, d)) = (ends(&points[0]), ends(&points[1]));
    (a.max(c) < b.min(d)).then_some((a.max(c), b.min(d)))
}

/// The part about the widest place where the body is nearly as wide.
pub(super) fn wide_part(curves: &[Curve; 2]) -> (f64, f64) {
    part_above(curves, curves[0].range(), WIDE_SHARE)
}

/// The part of a range about the widest place where the body is wider than a share of that.
pub(super) fn part_above(curves: &[Curve; 2], (from, to): (f64, f64), share: f64) -> (f64, f64) {
    let at = |i: usize| from + (to - from) * i as f64 / PLACES as f64;
    let widths: Vec<f64> = (0..=PLACES).map(|i| curves[1].at(at(i)) - curves[0].at(at(i))).collect();
    let top = (0..=PLACES).max_by(|a, b| widths[*a].total_cmp(&widths[*b])).unwrap_or(0);
    let is_wide = |i: &usize| widths[*i] > share * widths[top];
    let first = (0..=top).rev().take_while(is_wide).last().unwrap_or(top);
    let last = (top..=PLACES).take_while(is_wide).last().unwrap_or(top);
    (at(first), at(last))
}

/// Where a smooth function is largest.
pub(super) fn largest(of: &dyn Fn(f64) -> f64, (from, to): (f64, f64)) -> f64 {
    let step = (to - from) / PLACES as f64;
    let at = |i: usize| from + step * i as f64;
    let top = (0..=PLACES).max_by(|a, b| of(at(*a)).total_cmp(&of(at(*b)))).unwrap_or(0);
    if top == 0 || top == PLACES {
        return at(top);
    }
    // The top of a parabola through three places.
    let (a, b, c) = (of(at(top - 1)), of(at(top)), of(at(top + 1)));
    let bend = a - 2.0 * b + c;
    if bend < 0.0 { at(top) + 0.5 * step * (a - c) / bend } else { at(top) }
}

/// Widths all along: between the edges of the left side and the line through the nearest two of the right.
pub(super) fn profile(points: &[Vec<(f64, f64)>; 2], origin: f64, std_px: f64) -> Vec<Width> {
    let mut opposite = opposite(points);
    let width = |(v, a, b): (f64, f64, f64)| Width { along_px: v - origin, width_px: b - a, std_px };
    (0..points[0].len()).filter_map(|i| opposite(i).map(width)).collect()
}
