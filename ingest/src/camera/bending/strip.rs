//! Where the finger is, coarsely: a strip on a grid, from its root to its tip, with the middle of its parts.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use super::{BendingRefusal, SoughtBending};
use crate::camera::curve::median;
use crate::camera::picture::{Picture, Place};
use crate::camera::silhouette::grid::{Grid, depths, parts, without_holes};
use crate::camera::silhouette::mask;

/// The shorter side of the grid has about so many points.
const GRID: usize = 190;

/// A finger is so many steps of the grid wide, at least.
const RADIUS_MIN: f64 = 1.6;

/// Another part whose circle is larger than this share of the finger's is another body.
const OTHER_SHARE: f64 = 0.6;

/// What is shut in it is no glare where its circle is larger than this share of the finger's.
const GREATEST_HOLE: f64 = 0.7;

/// A finger is so many times as long as wide.
const LONG: f64 = 2.0;

/// What is so many times as wide as the finger, before it begins, is its mount.
const MOUNT: f64 = 1.4;

/// Costs of a step along and across, as integers: their ratio is √2 within a hundredth.
const ALONG: u32 = 5;
const ACROSS: u32 = 7;

/// A finger on the grid.
#[derive(Debug)]
pub(super) struct Strip {
    /// Whether it is darker than what is around.
    pub is_dark: bool,
    /// A step of the grid, in px.
    pub step: f64,
    /// Half its width, in px.
    pub half_px: f64,
    /// The middle of its parts, from the root to the tip, without those at the ends and those of a mount.
    pub middles: Vec<Place>,
    /// Where a mount ends that is wider than the finger.
    pub mount: Option<Place>,
    /// How many times as wide as farther on it is where it begins.
    pub wider: f64,
}

/// Finds the finger.
pub(super) fn strip(picture: &Picture, sought: &SoughtBending) -> Result<Strip, BendingRefusal> {
    let (w, h) = (picture.width(), picture.height());
    let [left, top, across, down] = sought.body.region.unwrap_or([0, 0, w, h]);
    let region = [left.min(w), top.min(h), across.min(w - left.min(w)), down.min(h - top.min(h))];
    let step = (region[2].min(region[3]) / GRID).max(1);
    let grid = Grid::of(picture, region, step).ok_or(BendingRefusal::NoBody)?;
    let (mask, is_dark) = mask(&grid, sought.body.is_dark).map_err(BendingRefusal::Body)?;
    let whole = without_holes(&grid, &mask);
    let depth = depths(&grid, &whole);
    let (labels, count) = parts(&grid, &whole);
    let mut deepest = vec![(0.0, 0); count as usize + 1];
    for (i, (label, d)) in labels.iter().zip(&depth).enumerate().filter(|(_, (label, _))| **label > 0) {
        let best: &mut (f64, usize) = &mut deepest[*label as usize];
        if *d > best.0 {
            *best = (*d, i);
        }
    }
    // The finger is the part with the most places; a frame of the picture, or a table, is deeper than long.
    let mut sizes = vec![0_usize; count as usize + 1];
    for label in &labels {
        sizes[*label as usize] += 1;
    }
    let part = (1..sizes.len()).max_by_key(|&l| sizes[l]).ok_or(BendingRefusal::NoBody)?;
    let radius = deepest[part].0;
    if radius < RADIUS_MIN {
        return Err(BendingRefusal::NoBody);
    }
    let is_other = |l: &usize| *l != part && deepest[*l].0 > OTHER_SHARE * radius && sizes[*l] * 4 > sizes[part];
    if (1..sizes.len()).any(|l| is_other(&l)) {
        return Err(BendingRefusal::SeveralBodies);
    }
    let is_part = |i: usize| labels[i] as usize == part;
    // What was shut and is as wide as the finger is no glare: the finger closes a ring.
    let holes: Vec<bool> = (0..mask.len()).map(|i| is_part(i) && !mask[i]).collect();
    let open: Vec<bool> = (0..mask.len()).map(|i| is_part(i) && mask[i]).collect();
    let deepest = |mask: &[bool]| depths(&grid, mask).into_iter().fold(0.0, f64::max);
    if deepest(&holes) > GREATEST_HOLE * deepest(&open) {
        return Err(BendingRefusal::Ring);
    }
    let place = |i: usize| {
        let at = |k: usize, origin: usize| (origin + k * step) as f64;
        Place::new(at(i % grid.width, grid.origin.0), at(i / grid.width, grid.origin.1))
    };
    let at_border: Vec<usize> = grid.border().filter(|&i| is_part(i)).collect();
    let wide = 2.0 * radius * step as f64;
    let apart = |a: usize, b: usize| (place(a) - place(b)).norm();
    let from = match sought.root {
        None if at_border.is_empty() => return Err(BendingRefusal::NoRoot),
        None => {
            if at_border.iter().any(|&i| apart(i, at_border[0]) > 4.0 * wide) {
                return Err(BendingRefusal::TwoExits);
            }
            at_border.clone()
        }
        Some(root) => {
            // Of its two ends the one that is nearer to the root.
            let any = (0..mask.len()).find(|&i| is_part(i)).ok_or(BendingRefusal::NoBody)?;
            let one = farthest(&ways(&grid, &is_part, &[any])).0;
            let other = farthest(&ways(&grid, &is_part, &[one])).0;
            let near = |i: usize| (place(i) - root).norm();
            let end = if near(one) < near(other) { one } else { other };
            if near(end) > 6.0 * wide {
                return Err(BendingRefusal::FarRoot { px: near(end) });
            }
            vec![end]
        }
    };
    let way = ways(&grid, &is_part, &from);
    let (tip, length) = farthest(&way);
    if at_border.iter().any(|&i| apart(i, tip) < wide) && sought.root.is_some() {
        return Err(BendingRefusal::TwoExits);
    }
    // A mount is deeper than the finger: half the finger's width is that of its outer half.
    let half = half_width(&way, length).max(1.0);
    if f64::from(length) / f64::from(ALONG) < LONG * 2.0 * half {
        return Err(BendingRefusal::Short);
    }
    // Parts of half a width each; those within half a width of either end are round, or cut.
    let part_length = (half * f64::from(ALONG)).max(2.0 * f64::from(ALONG));
    // Hundreds at most.
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
    let bins = (f64::from(length) / part_length) as usize;
    let mut sums = vec![(Place::zeros(), 0.0); bins + 1];
    for (i, d) in way.iter().enumerate().filter(|(_, d)| **d < u32::MAX) {
        // As above.
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        let bin = (f64::from(*d) / part_length) as usize;
        sums[bin].0 += place(i);
        sums[bin].1 += 1.0;
    }
    let inner: Vec<(Place, f64)> =
        sums[1..bins.max(1)].iter().filter(|s| s.1 > 0.0).map(|(sum, n)| (sum / *n, *n)).collect();
    // Parts are equally long: what they hold tells how wide they are.
    let usual = median(inner[inner.len() / 2..].iter().map(|part| part.1).collect());
    let of_mount = inner.iter().take_while(|part| part.1 > MOUNT * usual).count();
    // The last part of a mount may be half of the finger.
    let of_finger = if of_mount > 0 { &inner[(of_mount + 1).min(inner.len())..] } else { &inner[..] };
    let mount = (of_mount > 0 && of_mount + 1 < inner.len()).then(|| (inner[of_mount - 1].0 + inner[of_mount].0) * 0.5);
    let middles: Vec<Place> = of_finger.iter().map(|part| part.0).collect();
    if middles.len() < 4 {
        return Err(BendingRefusal::Short);
    }
    let first = median(of_finger[..of_finger.len().div_ceil(4)].iter().map(|part| part.1).collect());
    let cells: f64 = of_finger.iter().map(|part| part.1).sum();
    let along = middles.windows(2).map(|p| (p[1] - p[0]).norm()).sum::<f64>() / (middles.len() - 1) as f64;
    let half_px = 0.5 * cells / middles.len() as f64 * (step * step) as f64 / along;
    Ok(Strip { is_dark, step: step as f64, half_px, middles, mount, wider: first / usual })
}

/// Half the width of the outer half of a strip, in steps: the median of how many places lie as far on the way.
fn half_width(way: &[u32], length: u32) -> f64 {
    let fine = 2 * ALONG;
    let mut counts = vec![0.0; (length / fine) as usize + 1];
    for d in way.iter().filter(|d| **d < u32::MAX) {
        counts[(d / fine) as usize] += 1.0;
    }
    let outer = counts.len() / 2..counts.len() - counts.len() / 10;
    // Places of two steps of the way, on both sides.
    median(counts[outer].to_vec()) / 4.0
}

/// The shortest way within a part from some of its places to every other, in units of [`ALONG`] a step.
fn ways(grid: &Grid, is_part: &dyn Fn(usize) -> bool, from: &[usize]) -> Vec<u32> {
    let (w, h) = (grid.width, grid.height);
    let mut way = vec![u32::MAX; w * h];
    let mut open = BinaryHeap::new();
    for &i in from {
        way[i] = 0;
        open.push(Reverse((0, i)));
    }
    while let Some(Reverse((d, i))) = open.pop() {
        if d > way[i] {
            continue;
        }
        let (x, y) = (i % w, i / w);
        for (dx, dy) in [(0, 1), (1, 0), (1, 2), (2, 1), (0, 0), (0, 2), (2, 0), (2, 2)] {
            let (Some(nx), Some(ny)) = ((x + dx).checked_sub(1), (y + dy).checked_sub(1)) else { continue };
            if nx >= w || ny >= h {
                continue;
            }
            let next = ny * w + nx;
            let cost = d + if dx == 1 || dy == 1 { ALONG } else { ACROSS };
            if is_part(next) && cost < way[next] {
                way[next] = cost;
                open.push(Reverse((cost, next)));
            }
        }
    }
    way
}

fn farthest(way: &[u32]) -> (usize, u32) {
    let known = way.iter().enumerate().filter(|(_, d)| **d < u32::MAX);
    known.max_by_key(|(_, d)| **d).map_or((0, 0), |(i, d)| (i, *d))
}
