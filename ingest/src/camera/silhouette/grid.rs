//! Brightness on a grid of pixels, and masks on it: what is thin is taken off, what is enclosed is shut, parts are told apart, and how deep
//! each place lies in its part.
//!
//! `imageproc` has the like for pictures of any depth; on a grid of ten thousand places each of these is one or two passes here, which
//! is what the time of a whole measurement asks for.

use super::super::picture::Picture;

/// A step along a row or column and one across both, in units of [`depths`] (Borgefors' 3-4).
const STRAIGHT: u32 = 3;
const ACROSS: u32 = 4;

/// Brightness at every so many px of a part of a picture.
pub(in crate::camera) struct Grid {
    pub step: usize,
    pub origin: (usize, usize),
    pub width: usize,
    pub height: usize,
    pub values: Vec<f32>,
}

impl Grid {
    /// `None` where that is too small.
    pub fn of(picture: &Picture, [left, top, across, down]: [usize; 4], step: usize) -> Option<Self> {
        let (width, height) = (across / step, down / step);
        if width < 4 || height < 4 {
            return None;
        }
        let origin = (left + step / 2, top + step / 2);
        let rows = (0..height).map(|y| origin.1 + y * step);
        let values = rows.flat_map(|y| (0..width).map(move |x| picture.luma(origin.0 + x * step, y))).collect();
        Some(Self { step, origin, width, height, values })
    }

    /// The first and last row and column.
    pub fn border(&self) -> impl Iterator<Item = usize> + Clone {
        let (w, h) = (self.width, self.height);
        let rows = (0..w).chain((h - 1) * w..h * w);
        rows.chain((1..h - 1).flat_map(move |y| [y * w, y * w + w - 1]))
    }
}

/// A mask without what is thinner than three places one way (opened by a cross). Beyond the grid everything goes on as at its border.
pub(in crate::camera) fn opened(mask: &[bool], width: usize) -> Vec<bool> {
    let eroded = crossed(mask, width, |all| all.iter().all(|v| *v));
    crossed(&eroded, width, |all| all.iter().any(|v| *v))
}

/// Each place of a mask by itself and its four neighbours.
fn crossed(mask: &[bool], width: usize, of: impl Fn([bool; 5]) -> bool) -> Vec<bool> {
    let rows: Vec<&[bool]> = mask.chunks_exact(width).collect();
    let mut out = Vec::with_capacity(mask.len());
    for (y, row) in rows.iter().enumerate() {
        let above = rows[y.saturating_sub(1)];
        let below = rows[(y + 1).min(rows.len() - 1)];
        for x in 0..width {
            let (left, right) = (row[x.saturating_sub(1)], row[(x + 1).min(width - 1)]);
            out.push(of([row[x], left, right, above[x], below[x]]));
        }
    }
    out
}

/// A mask with what it encloses: everything that no way around leads to from the border.
pub(in crate::camera) fn without_holes(grid: &Grid, mask: &[bool]) -> Vec<bool> {
    let mut is_around = vec![false; mask.len()];
    let mut open = Vec::new();
    for i in grid.border() {
        flood(grid, i, &mut open, |k| {
            let is_new = !mask[k] && !is_around[k];
            is_around[k] |= is_new;
            is_new
        });
    }
    is_around.into_iter().map(|around| !around).collect()
}

/// Parts of a mask that hang together by rows and columns, numbered from 1, and how many there are.
pub(in crate::camera) fn parts(grid: &Grid, mask: &[bool]) -> (Vec<u32>, u32) {
    let mut labels = vec![0; mask.len()];
    let (mut open, mut count) = (Vec::new(), 0);
    for i in 0..mask.len() {
        if mask[i] && labels[i] == 0 {
            count += 1;
            flood(grid, i, &mut open, |k| {
                let is_new = mask[k] && labels[k] == 0;
                if is_new {
                    labels[k] = count;
                }
                is_new
            });
        }
    }
    (labels, count)
}

/// Visits all places that hang together with one, as long as `visit` says that a place is one of them, and new.
fn flood(grid: &Grid, from: usize, open: &mut Vec<usize>, mut visit: impl FnMut(usize) -> bool) {
    let (width, places) = (grid.width, grid.width * grid.height);
    let mut ask = |k: usize, open: &mut Vec<usize>| {
        if visit(k) {
            open.push(k);
        }
    };
    ask(from, open);
    while let Some(k) = open.pop() {
        let x = k % width;
        if x > 0 {
            ask(k - 1, open);
        }
        if x + 1 < width {
            ask(k + 1, open);
        }
        if k >= width {
            ask(k - width, open);
        }
        if k + width < places {
            ask(k + width, open);
        }
    }
}

/// How far each place of a mask lies from what is not in it, in steps of the grid, within 8 %; what is beyond the grid is not in it.
pub(in crate::camera) fn depths(grid: &Grid, mask: &[bool]) -> Vec<f64> {
    // With a frame of nought, so that no place has to ask whether it has neighbours.
    let wide = grid.width + 2;
    let mut all = vec![0_u32; wide * (grid.height + 2)];
    for (row, to) in mask.chunks_exact(grid.width).zip(all.chunks_exact_mut(wide).skip(1)) {
        to[1..=grid.width].iter_mut().zip(row).for_each(|(to, is)| *to = if *is { u32::MAX / 2 } else { 0 });
    }
    let places = |y: usize| y * wide + 1..y * wide + 1 + grid.width;
    for i in (1..=grid.height).flat_map(places) {
        if all[i] > 0 {
            let straight = all[i - 1].min(all[i - wide]) + STRAIGHT;
            let across = all[i - wide - 1].min(all[i - wide + 1]) + ACROSS;
            all[i] = straight.min(across);
        }
    }
    for i in (1..=grid.height).rev().flat_map(|y| places(y).rev()) {
        if all[i] > 0 {
            let straight = all[i + 1].min(all[i + wide]) + STRAIGHT;
            let across = all[i + wide + 1].min(all[i + wide - 1]) + ACROSS;
            all[i] = all[i].min(straight).min(across);
        }
    }
    let rows = all.chunks_exact(wide).skip(1).take(grid.height);
    rows.flat_map(|row| row[1..=grid.width].iter().map(|d| f64::from(*d) / f64::from(STRAIGHT))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grid(text: &str) -> (Grid, Vec<bool>) {
        let rows: Vec<&str> = text.split_whitespace().collect();
        let (width, height) = (rows[0].len(), rows.len());
        let mask: Vec<bool> = rows.concat().chars().map(|c| c == '#').collect();
        (Grid { step: 1, origin: (0, 0), width, height, values: vec![0.0; width * height] }, mask)
    }

    fn drawn(grid: &Grid, mask: &[bool]) -> String {
        let rows = mask.chunks_exact(grid.width);
        rows.map(|row| row.iter().map(|b| if *b { '#' } else { '.' }).collect::<String>()).collect::<Vec<_>>().join(" ")
    }

    #[test]
    fn thin_things_go_and_thick_ones_stay() {
        let (g, mask) = grid("......... .###..... .###.#### .###..... ......... ......... ........#");
        // The line of one place goes; corners of a square do, as a cross cannot reach them; at the border all goes on.
        assert_eq!(
            drawn(&g, &opened(&mask, g.width)),
            "......... ..#...... .###..... ..#...... ......... ......... ........."
        );
        let (g, mask) = grid("###.. ###.. ###..");
        assert_eq!(drawn(&g, &opened(&mask, g.width)), "###.. ###.. ###..");
    }

    #[test]
    fn what_is_enclosed_is_shut_and_parts_are_numbered() {
        let (g, mask) = grid("....... .####.. .#..#.. .#.##.. .###..# ......#");
        assert_eq!(drawn(&g, &without_holes(&g, &mask)), "....... .####.. .####.. .####.. .###..# ......#");
        let (labels, count) = parts(&g, &mask);
        assert_eq!((count, labels[8], labels[34], labels[41], labels[0]), (2, 1, 2, 2, 0));
        // Across corners nothing hangs together.
        let (g, mask) = grid("#... .#.. ..#. ...#");
        assert_eq!(parts(&g, &mask).1, 4);
    }

    #[test]
    fn depths_are_those_of_a_disc_within_their_share() {
        let g = Grid { step: 1, origin: (0, 0), width: 61, height: 61, values: vec![] };
        let from = |i: usize| ((i % 61) as f64 - 30.0).hypot((i / 61) as f64 - 30.0);
        let mask: Vec<bool> = (0..61 * 61).map(|i| from(i) < 25.0).collect();
        let found = depths(&g, &mask);
        for i in (0..61 * 61).filter(|i| mask[*i]) {
            assert!((found[i] - (25.0 - from(i))).abs() < 0.08 * 25.0 + 1.0, "{i} {} {}", found[i], 25.0 - from(i));
        }
        // A strip that fills the grid is as deep as it is far to the border.
        assert_eq!(depths(&Grid { width: 5, height: 3, ..g }, &[true; 15])[7].to_bits(), 2.0_f64.to_bits());
    }
}
