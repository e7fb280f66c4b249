//! Lines cut at the frame, and thinned to what can be seen.

use std::ops::Range;

use crate::report::scene::Px;

/// The pieces of a line that lie inside a rectangle, cut at its sides.
pub fn pieces(points: &[(f64, f64)], x: &Range<f64>, y: &Range<f64>) -> Vec<Vec<(f64, f64)>> {
    let mut pieces: Vec<Vec<(f64, f64)>> = Vec::new();
    for pair in points.windows(2) {
        let Some((a, b)) = clip(pair[0], pair[1], x, y) else { continue };
        match pieces.last_mut() {
            Some(piece) if piece.last() == Some(&a) => piece.push(b),
            _ => pieces.push(vec![a, b]),
        }
    }
    pieces
}

/// The part of a segment inside a rectangle (Liang and Barsky, 1984).
fn clip(a: (f64, f64), b: (f64, f64), x: &Range<f64>, y: &Range<f64>) -> Option<((f64, f64), (f64, f64))> {
    let (dx, dy) = (b.0 - a.0, b.1 - a.1);
    let (mut enter, mut leave) = (0.0_f64, 1.0_f64);
    for (step, room) in [(-dx, a.0 - x.start), (dx, x.end - a.0), (-dy, a.1 - y.start), (dy, y.end - a.1)] {
        if step == 0.0 {
            if room < 0.0 {
                return None;
            }
        } else if step < 0.0 {
            enter = enter.max(room / step);
        } else {
            leave = leave.min(room / step);
        }
    }
    let at = |s: f64| (a.0 + s * dx, a.1 + s * dy);
    // The ends are kept to the bit, so that neighbouring segments join.
    let start = if enter > 0.0 { at(enter) } else { a };
    let end = if leave < 1.0 { at(leave) } else { b };
    (enter <= leave).then_some((start, end))
}

/// So far from a line, in px, nobody sees whether a place is on it.
const UNSEEN_PX: f64 = 0.12;

/// A line without the places that lie on it anyway (Douglas and Peucker, 1973): none that is left out is farther from what is left than
/// can be seen.
pub fn thinned(points: &[Px]) -> Vec<Px> {
    if points.len() < 3 {
        return points.to_vec();
    }
    let mut keep = vec![false; points.len()];
    let last = points.len() - 1;
    (keep[0], keep[last]) = (true, true);
    let mut stretches = vec![(0, last)];
    while let Some((from, to)) = stretches.pop() {
        let distance = |i: usize| from_segment(points[i], points[from], points[to]);
        let farthest = (from + 1..to).max_by(|a, b| distance(*a).total_cmp(&distance(*b)));
        if let Some(i) = farthest.filter(|i| distance(*i) > UNSEEN_PX) {
            keep[i] = true;
            stretches.extend([(from, i), (i, to)]);
        }
    }
    points.iter().zip(keep).filter(|(_, keep)| *keep).map(|(p, _)| *p).collect()
}

/// How far a place is from a segment.
fn from_segment(p: Px, a: Px, b: Px) -> f64 {
    let (dx, dy) = (b.0 - a.0, b.1 - a.1);
    let square = dx * dx + dy * dy;
    let share = if square > 0.0 { (((p.0 - a.0) * dx + (p.1 - a.1) * dy) / square).clamp(0.0, 1.0) } else { 0.0 };
    (p.0 - a.0 - share * dx).hypot(p.1 - a.1 - share * dy)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn segments_are_cut_at_the_frame() {
        let (x, y) = (0.0..10.0, 0.0..10.0);
        assert_eq!(clip((-5.0, 5.0), (5.0, 5.0), &x, &y), Some(((0.0, 5.0), (5.0, 5.0))));
        assert_eq!(clip((1.0, 1.0), (2.0, 2.0), &x, &y), Some(((1.0, 1.0), (2.0, 2.0))));
        assert_eq!(clip((5.0, 5.0), (5.0, 25.0), &x, &y), Some(((5.0, 5.0), (5.0, 10.0))));
        assert_eq!(clip((-1.0, -1.0), (-2.0, 5.0), &x, &y), None);
    }

    #[test]
    fn a_thinned_line_is_nowhere_farther_off_than_can_be_seen_and_keeps_its_peaks() {
        let line: Vec<Px> = (0..2000).map(|i| (0.3 * f64::from(i), 100.0 * (f64::from(i) * 0.004).sin())).collect();
        let mut spiked = line.clone();
        spiked[700].1 += 5.0;
        let thin = thinned(&spiked);
        assert!(thin.len() < 120 && thin.contains(&spiked[700]), "{}", thin.len());
        for p in &spiked {
            let nearest = thin.windows(2).map(|s| from_segment(*p, s[0], s[1])).fold(f64::INFINITY, f64::min);
            assert!(nearest <= UNSEEN_PX);
        }
    }
}
