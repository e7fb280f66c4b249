//! Which part of a picture is the body: a coarse outline, from which edges are looked for.
//!
//! ```text
//! grid of pixels --> light of the background (a surface of second order) --> threshold by Otsu --> specks off, holes shut
//!                --> the part with the largest circle in it that is free on both sides --> its rows
//! ```
//!
//! Everything here is good to one step of the grid. What is thin beside the body (a mount, a cable) or reaches from border to border (a
//! table, a frame) is no body.

pub(super) mod grid;

use std::fmt;

use image::GrayImage;
use imageproc::contrast::otsu_level;

use super::picture::Picture;
use grid::{Grid, depths, opened, parts, without_holes};

/// The shorter side of the grid has about so many points; of the coarsest, and of the finest that is tried.
const GRID: (usize, usize) = (50, 540);

/// The coarsest step of the grid, in px.
const STEP_MAX: usize = 24;

/// A body has a circle of so many steps in it, at least; a finer grid is tried below the second.
const RADIUS_MIN: f64 = 2.0;
const RADIUS_GOOD: f64 = 4.0;

/// Another part whose circle is larger than this share of the body's is another body.
const OTHER_SHARE: f64 = 0.5;

/// Levels that are nearer to each other, in steps of brightness, or in standard deviations of the background, are one.
const CONTRAST_MIN: f64 = 6.0;
const CONTRAST_NOISES: f64 = 4.0;

/// Pixels within this share of the largest circle of an edge say nothing of the axis: a mount is thinner.
const THIN_SHARE: f64 = 0.35;

/// A body whose spread along and across differ by less than this share has no axis of its own.
const ROUND_SHARE: f64 = 0.1;

/// One that reaches out of the picture may be wider than it is long by such a share, as far as it is seen.
const UNSURE_SHARE: f64 = 0.25;

/// A body that stands on a mount may be wider than it is long by such a share.
const MOUNTED_SHARE: f64 = 0.35;

/// A mount is thinner than this share of the body, and does not become so many times as thick over so many lines of the grid.
const MOUNT_SHARE: f64 = 0.6;
const MOUNT_GROWTH: f64 = 1.12;
const MOUNT_LINES: usize = 2;

/// One of so many places tells the light: a prime, so that they lie everywhere.
const SURFACE_STEP: usize = 7;

/// How the axis of a body lies.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Axis {
    /// More up and down than across: widths are measured along rows.
    Vertical,
    /// More across: along columns.
    Horizontal,
}

impl Axis {
    fn other(self) -> Self {
        match self {
            Self::Vertical => Self::Horizontal,
            Self::Horizontal => Self::Vertical,
        }
    }
}

/// What is sought.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Sought {
    /// How the axis lies; `None`: as the longer side of the body.
    pub axis: Option<Axis>,
    /// Whether the body is darker than what is around; `None`: what lies at the border is around.
    pub is_dark: Option<bool>,
    /// Where it is looked for: left, top, width, height, in px; `None`: everywhere.
    pub region: Option<[usize; 4]>,
}

/// Why there is no body, or no measurement.
#[derive(Debug, Clone, PartialEq)]
pub enum Refusal {
    /// Brightness has no two levels.
    NoContrast {
        /// How far apart they are, in steps of brightness.
        steps: f64,
    },
    /// Nothing is large enough and free on both sides.
    NoBody,
    /// Two or more of like size.
    SeveralBodies {
        /// The radius of the second one's circle over the first one's.
        share: f64,
    },
    /// The body reaches out of the picture where it would be measured.
    Border,
    /// The picture is as bright, or as dark, as it can be beside the edges.
    Saturated {
        /// The share of edges where it is so.
        share: f64,
    },
    /// Too few edges were found.
    FewEdges {
        /// Found.
        found: usize,
        /// Looked for.
        of: usize,
    },
}

impl fmt::Display for Refusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoContrast { steps } => {
                write!(
                    f,
                    "no body: brightness has no two levels, they lie {steps:.1} of 255 steps apart; light the body from behind"
                )
            }
            Self::NoBody => write!(
                f,
                "no body: nothing large stands free of the border on both sides; name the `region` it lies in"
            ),
            Self::SeveralBodies { share } => write!(
                f,
                "several bodies: the second is {:.0} % as thick as the first; name the `region` of the one to measure",
                100.0 * share
            ),
            Self::Border => write!(
                f,
                "the body touches the border where it is widest: more of it may lie outside; if that is along its axis, say which `axis` it has"
            ),
            Self::Saturated { share } => write!(
                f,
                "saturated: at {:.0} % of the edges the picture is as bright or as dark as it can be, so that nobody knows where half of the \
                 way is; expose less, or more",
                100.0 * share
            ),
            Self::FewEdges { found, of } => {
                write!(f, "edges were found in {found} of {of} lines only: blurred, covered or without contrast")
            }
        }
    }
}

/// A body, row by row of a grid; rows are columns of the picture where its axis is horizontal.
#[derive(Debug, Clone, PartialEq)]
pub struct Body {
    /// How its axis lies.
    pub axis: Axis,
    /// Whether that was guessed: it is about as long as it is wide.
    pub axis_is_guessed: bool,
    /// Whether it is darker than what is around.
    pub is_dark: bool,
    /// The distance of rows, in px.
    pub step: usize,
    /// Rows, each with where the body begins and ends in it, in px: up to one step off.
    pub rows: Vec<Row>,
    /// First and last px across which rows were looked for.
    pub lines: (usize, usize),
    /// Which of the rows goes through the largest circle in it.
    pub deepest: usize,
    /// The radius of the largest circle in it, in px.
    pub radius: f64,
}

/// A row of a body.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Row {
    /// Where it lies, in px.
    pub at: usize,
    /// First and last px of the body.
    pub span: (usize, usize),
    /// Whether it is free of the border on both sides.
    pub is_free: bool,
}

/// The body of a picture.
///
/// # Errors
/// Why there is none.
pub fn body(picture: &Picture, sought: Sought) -> Result<Body, Refusal> {
    let (w, h) = (picture.width(), picture.height());
    let [left, top, across, down] = sought.region.unwrap_or([0, 0, w, h]);
    let (left, top) = (left.min(w), top.min(h));
    let region = [left, top, across.min(w - left), down.min(h - top)];
    let shorter = region[2].min(region[3]);
    let mut step = (shorter / GRID.0).clamp(1, STEP_MAX);
    loop {
        let found = on_grid(picture, sought, region, step);
        // A finer one also shows a mount that is hardly longer than a step.
        let is_clear = |body: &Body| body.radius >= RADIUS_GOOD * step as f64 && !body.axis_is_guessed;
        let is_good = found.as_ref().is_ok_and(is_clear);
        let finer = step / 2;
        if is_good || finer == 0 || shorter / finer > GRID.1 {
            return found;
        }
        step = finer;
    }
}

/// The same on a grid of so many px.
fn on_grid(picture: &Picture, sought: Sought, region: [usize; 4], step: usize) -> Result<Body, Refusal> {
    let grid = Grid::of(picture, region, step).ok_or(Refusal::NoBody)?;
    let (mask, is_dark) = mask(&grid, sought.is_dark)?;
    let mask = without_holes(&grid, &mask);
    let depths = depths(&grid, &mask);
    let (labels, parts) = parts(&grid, &mask);
    let (free_rows, free_columns) = (free(&grid, &mask, false), free(&grid, &mask, true));
    // The deepest place of each part, where it is free on both sides.
    let mut deepest: Vec<(f64, usize)> = vec![(0.0, 0); parts as usize + 1];
    for (i, (label, depth)) in labels.iter().zip(&depths).enumerate().filter(|(_, (label, _))| **label > 0) {
        let allowed = match sought.axis {
            Some(Axis::Vertical) => free_rows[i],
            Some(Axis::Horizontal) => free_columns[i],
            None => free_rows[i] || free_columns[i],
        };
        let best = &mut deepest[*label as usize];
        if allowed && *depth > best.0 {
            *best = (*depth, i);
        }
    }
    let (part, &(radius, _)) =
        deepest.iter().enumerate().max_by(|a, b| a.1.0.total_cmp(&b.1.0)).ok_or(Refusal::NoBody)?;
    if radius < RADIUS_MIN {
        return Err(Refusal::NoBody);
    }
    let second = deepest.iter().enumerate().filter(|(i, _)| *i != part).map(|(_, d)| d.0).fold(0.0, f64::max);
    if second > OTHER_SHARE * radius {
        return Err(Refusal::SeveralBodies { share: second / radius });
    }
    let is_part = |i: usize| labels[i] as usize == part;
    let is_thick = |i: &usize| is_part(*i) && depths[*i] > THIN_SHARE * radius;
    let thick: Vec<usize> = (0..labels.len()).filter(is_thick).collect();
    let (along, across) = spread(&grid, &thick);
    let longer = if along >= across { Axis::Vertical } else { Axis::Horizontal };
    let apart = (along - across).abs() / along.max(across);
    let place = deepest[part].1;
    let is_cut_along = |axis: Axis| is_at_border(&grid, axis, &is_part);
    let mounted = match (is_cut_along(Axis::Vertical), is_cut_along(Axis::Horizontal)) {
        (true, false) => Some(Axis::Vertical),
        (false, true) => Some(Axis::Horizontal),
        _ => None,
    };
    // A mount stands along the axis; what touches a long body from the side is a hose.
    let mounted = mounted.filter(|axis| is_mounted(&grid, *axis, &is_part, place));
    let (axis, axis_is_guessed) = match (sought.axis, free_rows[place], free_columns[place]) {
        (Some(axis), ..) => (axis, false),
        (None, true, true) if apart < ROUND_SHARE => (mounted.unwrap_or(Axis::Vertical), true),
        (None, true, true) if apart < MOUNTED_SHARE => {
            (mounted.unwrap_or(longer), mounted.unwrap_or(longer) != longer || is_cut_along(longer.other()))
        }
        (None, true, true) => (longer, false),
        // Out of the picture one way: on a mount, or cut. On a mount the axis goes that way; cut, the other way is across, unless the longer
        // side says otherwise.
        (None, rows_are_free, _) => {
            let axis = if rows_are_free { Axis::Vertical } else { Axis::Horizontal };
            let is_cut = axis != longer && !is_mounted(&grid, axis, &is_part, place);
            if is_cut && apart > UNSURE_SHARE {
                return Err(Refusal::Border);
            }
            (axis, is_cut)
        }
    };
    let lines = match axis {
        Axis::Vertical => (region[1], region[1] + region[3] - 1),
        Axis::Horizontal => (region[0], region[0] + region[2] - 1),
    };
    let (rows, deepest) = rows(&grid, axis, &|x, y| is_part(y * grid.width + x), deepest[part].1);
    Ok(Body {
        axis,
        axis_is_guessed,
        is_dark,
        step: grid.step,
        rows,
        lines,
        deepest,
        radius: radius * grid.step as f64,
    })
}

/// Where the body is, and whether it is the darker one.
pub(super) fn mask(grid: &Grid, is_dark: Option<bool>) -> Result<(Vec<bool>, bool), Refusal> {
    // In the light as it falls, and then without its slopes.
    let (body, _) = halves(&grid.values, grid, is_dark)?;
    let even = surface(grid, &body);
    let even = even.as_deref().unwrap_or(&grid.values);
    let (body, is_dark) = halves(even, grid, is_dark)?;
    let (mut inside, mut outside) = (Mean::default(), Mean::default());
    even.iter().zip(&body).for_each(|(v, b)| if *b { inside.add(*v) } else { outside.add(*v) });
    let contrast = (inside.mean() - outside.mean()).abs();
    if contrast <= CONTRAST_MIN || contrast.is_nan() {
        return Err(Refusal::NoContrast { steps: contrast });
    }
    // A cut through one level of noise lies 1.6 of its deviations between the means of its halves.
    if contrast < CONTRAST_NOISES * outside.std() {
        return Err(Refusal::NoBody);
    }
    Ok((opened(&body, grid.width), is_dark))
}

/// The half of the brightness that is the body, by Otsu's threshold, and whether it is the darker one.
fn halves(values: &[f32], grid: &Grid, is_dark: Option<bool>) -> Result<(Vec<bool>, bool), Refusal> {
    let (low, high) = values.iter().fold((f32::INFINITY, f32::NEG_INFINITY), |(l, h), v| (l.min(*v), h.max(*v)));
    if f64::from(high - low) <= CONTRAST_MIN || !(high - low).is_finite() {
        return Err(Refusal::NoContrast { steps: f64::from(high - low).max(0.0) });
    }
    let scale = 255.0 / (high - low);
    // Between 0 and 255 by construction.
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
    let levels: Vec<u8> = values.iter().map(|v| ((v - low) * scale) as u8).collect();
    // Images are counted in 32 bits; grids are far smaller.
    let size = |n: usize| u32::try_from(n).unwrap_or(0);
    let image = GrayImage::from_raw(size(grid.width), size(grid.height), levels).unwrap_or_default();
    let limit = otsu_level(&image);
    let levels = image.as_raw();
    let is_dark = is_dark.unwrap_or_else(|| {
        let dark = grid.border().filter(|&i| levels[i] <= limit).count();
        2 * dark < grid.border().count()
    });
    Ok((levels.iter().map(|level| (*level <= limit) == is_dark).collect(), is_dark))
}

/// Mean and standard deviation.
#[derive(Default)]
struct Mean {
    n: f64,
    sum: f64,
    squares: f64,
}

impl Mean {
    fn add(&mut self, value: f32) {
        let value = f64::from(value);
        self.n += 1.0;
        self.sum += value;
        self.squares += value * value;
    }

    fn mean(&self) -> f64 {
        self.sum / self.n.max(1.0)
    }

    fn std(&self) -> f64 {
        (self.squares / self.n.max(1.0) - self.mean().powi(2)).max(0.0).sqrt()
    }
}

/// Brightness over the light of the background, which is a surface of second order over the grid; `None` where that cannot be told.
fn surface(grid: &Grid, body: &[bool]) -> Option<Vec<f32>> {
    let centred = |k: usize, n: usize| 2.0 * k as f64 / n as f64 - 1.0;
    let (mut normal, mut right) = (nalgebra::Matrix6::zeros(), nalgebra::Vector6::zeros());
    // A smooth surface is told by some thousand places.
    for i in (0..grid.values.len()).step_by(SURFACE_STEP).filter(|&i| !body[i]) {
        let (x, y) = (centred(i % grid.width, grid.width), centred(i / grid.width, grid.height));
        let t = nalgebra::Vector6::new(1.0, x, y, x * x, x * y, y * y);
        normal += t * t.transpose();
        right += t * f64::from(grid.values[i]);
    }
    let c = normal.cholesky()?.solve(&right);
    let mut light = Vec::with_capacity(grid.values.len());
    for row in 0..grid.height {
        let y = centred(row, grid.height);
        let (constant, slope) = (c[0] + y * (c[2] + y * c[5]), c[1] + y * c[4]);
        light.extend((0..grid.width).map(|k| {
            let x = centred(k, grid.width);
            constant + x * (slope + x * c[3])
        }));
    }
    let mean = light.iter().sum::<f64>() / light.len() as f64;
    let lowest = light.iter().copied().fold(f64::INFINITY, f64::min);
    // A light that goes out somewhere is none. Brightness itself is held in single precision.
    #[allow(clippy::cast_possible_truncation)]
    (mean > 0.0 && lowest > 0.1 * mean)
        .then(|| grid.values.iter().zip(&light).map(|(v, l)| v / (l / mean) as f32).collect())
}

/// Pixels of the body whose run along the row, or the column, ends before the border on both sides.
fn free(grid: &Grid, mask: &[bool], columns: bool) -> Vec<bool> {
    let (lines, length) = if columns { (grid.width, grid.height) } else { (grid.height, grid.width) };
    let at = |line: usize, i: usize| if columns { i * grid.width + line } else { line * grid.width + i };
    let mut free = vec![false; mask.len()];
    for line in 0..lines {
        let mut i = 0;
        while i < length {
            let from = i;
            while i < length && mask[at(line, i)] {
                i += 1;
            }
            if from > 0 && i < length {
                (from..i).for_each(|k| free[at(line, k)] = true);
            }
            i += 1;
        }
    }
    free
}

/// Whether a part reaches one of the borders that an axis goes through.
fn is_at_border(grid: &Grid, axis: Axis, is_part: &dyn Fn(usize) -> bool) -> bool {
    let last = grid.height - 1;
    match axis {
        Axis::Vertical => (0..grid.width).any(|x| is_part(x) || is_part(last * grid.width + x)),
        Axis::Horizontal => (0..grid.height).any(|y| is_part(y * grid.width) || is_part((y + 1) * grid.width - 1)),
    }
}

/// Whether a part reaches the border along an axis by a mount: something thin that does not widen there.
fn is_mounted(grid: &Grid, axis: Axis, is_part: &dyn Fn(usize) -> bool, deepest: usize) -> bool {
    let (lines, length) = match axis {
        Axis::Vertical => (grid.height, grid.width),
        Axis::Horizontal => (grid.width, grid.height),
    };
    let count = |line: usize| {
        let at = |i: usize| match axis {
            Axis::Vertical => line * grid.width + i,
            Axis::Horizontal => i * grid.width + line,
        };
        (0..length).filter(|&i| is_part(at(i))).count()
    };
    let middle = match axis {
        Axis::Vertical => deepest / grid.width,
        Axis::Horizontal => deepest % grid.width,
    };
    let width = count(middle) as f64;
    let is_thin = |line: usize, behind: usize| {
        let (here, there) = (count(line) as f64, count(behind) as f64);
        here < MOUNT_SHARE * width && there < MOUNT_GROWTH * here + 1.0
    };
    let reach = MOUNT_LINES.min(lines / 4);
    [(0, reach), (lines - 1, lines - 1 - reach)]
        .into_iter()
        .all(|(line, behind)| count(line) == 0 || is_thin(line, behind))
}

/// How far places spread down and across.
fn spread(grid: &Grid, places: &[usize]) -> (f64, f64) {
    let (mut down, mut across) = (Mean::default(), Mean::default());
    for i in places {
        // Grids have a few hundred lines.
        #[allow(clippy::cast_possible_truncation)]
        let of = |k: usize| k as f32;
        down.add(of(i / grid.width));
        across.add(of(i % grid.width));
    }
    (down.std(), across.std())
}

/// The rows of a part, and which of them is the deepest: from the deepest place up and down, as long as a run overlaps the one before.
fn rows(grid: &Grid, axis: Axis, is_part: &dyn Fn(usize, usize) -> bool, deepest: usize) -> (Vec<Row>, usize) {
    let (x, y) = (deepest % grid.width, deepest / grid.width);
    let (line, place, lines, length) = match axis {
        Axis::Vertical => (y, x, grid.height, grid.width),
        Axis::Horizontal => (x, y, grid.width, grid.height),
    };
    let is_body = |line: usize, i: usize| match axis {
        Axis::Vertical => is_part(i, line),
        Axis::Horizontal => is_part(line, i),
    };
    let (first, across) = match axis {
        Axis::Vertical => (grid.origin.1, grid.origin.0),
        Axis::Horizontal => (grid.origin.0, grid.origin.1),
    };
    // The longest run of a line that overlaps another.
    let run = |line: usize, near: (usize, usize)| {
        let mut best: Option<(usize, usize)> = None;
        let mut i = 0;
        while i < length {
            let from = i;
            while i < length && is_body(line, i) {
                i += 1;
            }
            let overlaps = i > from && from <= near.1 && i > near.0;
            if overlaps && best.is_none_or(|(a, b)| i - 1 - from > b - a) {
                best = Some((from, i - 1));
            }
            i += 1;
        }
        best
    };
    let mut found: Vec<(usize, (usize, usize))> = Vec::new();
    let mut near = (place, place);
    for l in (0..=line).rev() {
        let Some(span) = run(l, near) else { break };
        found.push((l, span));
        near = span;
    }
    found.reverse();
    let middle = found.len().saturating_sub(1);
    let mut near = found.last().map_or((place, place), |(_, span)| *span);
    for l in line + 1..lines {
        let Some(span) = run(l, near) else { break };
        found.push((l, span));
        near = span;
    }
    let row = |(l, (from, to)): (usize, (usize, usize))| Row {
        at: first + l * grid.step,
        span: (across + from * grid.step, across + to * grid.step),
        is_free: from > 0 && to + 1 < length,
    };
    (found.into_iter().map(row).collect(), middle)
}
