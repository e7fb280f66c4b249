//! From shares to areas: what lies well within counts whole, the rim by its share.

use nalgebra::{Matrix3, Vector2, Vector3};

use super::super::picture::Place;
use super::colour::Colours;
use super::field::Field;
use super::{AreaRefusal, Imprint, Note, Part, SoughtArea};

/// The rim reaches so many standard deviations of the blur to either side of half a share, and px beyond; and that within bounds.
const REACH_BLURS: f64 = 3.5;
const REACH_PX: f64 = 1.5;
const REACH: (f64, f64) = (3.0, 30.0);

/// Levels of paint and paper are told by blocks of so many px, and so many blocks around.
const BLOCK: usize = 16;
const AROUND: usize = 3;

/// Blocks so far away, in blocks, count e^-½.
const NEAR: f64 = 1.0;

/// A plane takes so many blocks; with fewer a mean does.
const PLANE_BLOCKS: usize = 8;

/// Part of what a plane adds to the mean of the blocks around that is left open.
const OPEN: f64 = 0.5;

/// A level takes so many px.
const LEVEL_PX: f64 = 12.0;

/// All along the rim so much remains: pixels are not alike, and paint does not end at a line. Standard uncertainty in px.
const RIM_PX: f64 = 0.02;

/// What is worth a note: uneven paint, blur in px, share of another colour.
const UNEVEN: f64 = 0.3;
const BLURRED_PX: f64 = 5.0;
const OTHER: f64 = 0.02;

/// Sums of a block: weight, sum of shares, sum of their squares.
#[derive(Clone, Copy, Default)]
struct Sum {
    n: f64,
    sum: f64,
}

/// Levels by blocks.
struct Levels {
    across: usize,
    down: usize,
    blocks: Vec<Sum>,
}

/// A level near a block: a plane, and the standard uncertainty of it.
#[derive(Clone, Copy)]
struct Plane {
    at: [f64; 3],
    std: f64,
}

impl Levels {
    fn of(field: &Field, is: impl Fn(usize) -> bool) -> Self {
        let (across, down) = (field.width.div_ceil(BLOCK), field.height.div_ceil(BLOCK));
        let mut blocks = vec![Sum::default(); across * down];
        for i in (0..field.shares.len()).filter(|&i| is(i)) {
            let block = &mut blocks[i / field.width / BLOCK * across + i % field.width / BLOCK];
            block.n += 1.0;
            block.sum += f64::from(field.shares[i]);
        }
        Self { across, down, blocks }
    }

    fn mean(&self) -> Option<f64> {
        let (n, sum) = self.blocks.iter().fold((0.0, 0.0), |(n, sum), b| (n + b.n, sum + b.sum));
        (n > 0.0).then(|| sum / n)
    }

    /// The level about a block, of noise of one pixel.
    fn near(&self, bx: usize, by: usize, noise: f64) -> Option<Plane> {
        let (mut n, mut sum, mut used) = (0.0, 0.0, Vec::new());
        for y in by.saturating_sub(AROUND)..(by + AROUND + 1).min(self.down) {
            for x in bx.saturating_sub(AROUND)..(bx + AROUND + 1).min(self.across) {
                let block = self.blocks[y * self.across + x];
                if block.n > 0.0 {
                    let (dx, dy) = (x as f64 - bx as f64, y as f64 - by as f64);
                    // Near ones count more: paint differs from place to place.
                    let weight = block.n * (-0.5 * (dx * dx + dy * dy) / (NEAR * NEAR)).exp();
                    used.push((dx, dy, block.sum / block.n, weight));
                    n += block.n;
                    sum += block.sum;
                }
            }
        }
        if n < LEVEL_PX {
            return None;
        }
        let mean = Plane { at: [sum / n, 0.0, 0.0], std: noise / n.sqrt() };
        if used.len() < PLANE_BLOCKS {
            return Some(mean);
        }
        let (mut normal, mut right) = (Matrix3::zeros(), Vector3::zeros());
        for (dx, dy, level, weight) in &used {
            let t = Vector3::new(1.0, *dx, *dy);
            normal += t * t.transpose() * *weight;
            right += t * (*weight * level);
        }
        let Some(inverse) = normal.try_inverse() else { return Some(mean) };
        let at = inverse * right;
        let weights: f64 = used.iter().map(|u| u.3).sum();
        let squares: f64 =
            used.iter().map(|(dx, dy, l, w)| w * (at.dot(&Vector3::new(1.0, *dx, *dy)) - l).powi(2)).sum();
        // Blocks stray about the plane; a plane through one-sided blocks knows less at their end.
        let scatter = (squares / weights * used.len() as f64 / (used.len() - 3) as f64).sqrt();
        let lever = (inverse[(0, 0)] * weights).max(1.0).sqrt();
        // Whether a plane goes on to the rim as it does within, nobody knows: part of what it adds to the mean nearby stays open.
        let nearby = used.iter().map(|u| u.2 * u.3).sum::<f64>() / weights;
        let open = OPEN * (at[0] - nearby).abs();
        let std = (scatter / (used.len() as f64).sqrt()).hypot(noise / n.sqrt()) * lever;
        Some(Plane { at: at.into(), std: std.hypot(open) })
    }
}

impl Plane {
    fn level(&self, x: f64, y: f64) -> f64 {
        self.at[0] + self.at[1] * x + self.at[2] * y
    }
}

pub(super) fn measured(
    field: &Field,
    colours: &Colours,
    sought: SoughtArea,
    straight: &dyn Fn(Place) -> Option<Place>,
) -> Result<Imprint, AreaRefusal> {
    let w = field.width;
    let mut mask = field.mask.clone();
    if sought.fill_holes {
        let around: Vec<bool> = mask.iter().map(|m| !m).collect();
        let (labels, _) = field.parts(&around, false);
        let mut outside = vec![false; labels.iter().copied().max().unwrap_or(0) as usize + 1];
        field.border().for_each(|i| outside[labels[i] as usize] = true);
        (0..mask.len()).for_each(|i| mask[i] |= labels[i] > 0 && !outside[labels[i] as usize]);
    }
    let (labels, counts) = field.parts(&mask, true);
    let is_large = |label: u32| label > 0 && counts[label as usize] as f64 >= sought.least_px2;
    if !(1..counts.len()).any(|l| counts[l] as f64 >= sought.least_px2) {
        return Err(AreaRefusal::NoPaint);
    }
    if field.border().any(|i| is_large(labels[i])) {
        return Err(AreaRefusal::Border);
    }
    let is_rim = |i: usize| {
        let (x, y) = (i % w, i / w);
        let other = |k: usize| mask[k] != mask[i];
        (x > 0 && other(i - 1))
            || (x + 1 < w && other(i + 1))
            || (y > 0 && other(i - w))
            || (y + 1 < field.height && other(i + w))
    };
    // The length of the rim: sides of pixels, which lie on it in steps, and so are longer than it by 4/π in the mean.
    let sides = |i: usize| {
        usize::from(i % w + 1 < w && mask[i] != mask[i + 1])
            + usize::from(i / w + 1 < field.height && mask[i] != mask[i + w])
    };
    let rim_px = (0..mask.len()).map(sides).sum::<usize>() as f64 * std::f64::consts::FRAC_PI_4;
    let share = |i: usize| f64::from(field.shares[i]);
    // Of a blurred step two standard deviations lie between Φ(-1) and Φ(1).
    let rim_marks: Vec<u32> = (0..mask.len()).map(|i| u32::from(is_rim(i))).collect();
    let wide = field.near(&rim_marks, 12);
    let between = (0..mask.len()).filter(|&i| wide[i] > 0 && (0.158_655..0.841_345).contains(&share(i))).count() as f64;
    let blur_px = 0.5 * between / rim_px.max(1.0);
    let reach = (REACH_BLURS * blur_px + REACH_PX).clamp(REACH.0, REACH.1);
    // Between 3 and 30.
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
    let reach = reach.ceil() as usize;
    let is_near_rim = field.near(&rim_marks, reach);
    // The part, or speck, that a pixel of the rim belongs to.
    let owner = field.near(&labels, reach + 1);
    let inside = Levels::of(field, |i| mask[i] && is_near_rim[i] == 0 && field.mask[i]);
    let outside = Levels::of(field, |i| !mask[i] && is_near_rim[i] == 0);
    let noise = colours.std;
    let (whole, none) = (inside.mean().unwrap_or(1.0), outside.mean().unwrap_or(0.0));
    let of_block = |levels: &Levels, otherwise: f64| -> Vec<Plane> {
        let all = (0..levels.blocks.len()).map(|b| levels.near(b % levels.across, b / levels.across, noise));
        all.map(|plane| plane.unwrap_or(Plane { at: [otherwise, 0.0, 0.0], std: 0.05 })).collect()
    };
    let (paint, paper) = (of_block(&inside, whole), of_block(&outside, none));
    let weights = weights(field, straight);
    let mut sums: Vec<Sums> = vec![Sums::default(); counts.len()];
    // Sums over the rim by block, for what its levels leave open.
    let mut of_blocks = vec![(0.0, 0.0); paint.len()];
    let mut variance = 0.0;
    for i in 0..mask.len() {
        let label = owner[i];
        if label == 0 {
            continue;
        }
        let (x, y) = (i % w, i / w);
        let block = y / BLOCK * inside.across + x / BLOCK;
        let weight = weights[block];
        let part = if is_near_rim[i] == 0 {
            if mask[i] { 1.0 } else { 0.0 }
        } else {
            let (dx, dy) = ((x % BLOCK) as f64 / BLOCK as f64 - 0.5, (y % BLOCK) as f64 / BLOCK as f64 - 0.5);
            let (low, high) = (paper[block].level(dx, dy), paint[block].level(dx, dy));
            let height = (high - low).max(0.2 * whole);
            let part = ((share(i) - low) / height).clamp(-0.5, 1.5);
            if is_large(label) {
                of_blocks[block].0 += weight * part * paint[block].std / height;
                of_blocks[block].1 += weight * (1.0 - part) * paper[block].std / height;
                variance += (weight * noise / height).powi(2);
            }
            part
        };
        let sum = &mut sums[label as usize];
        sum.area += weight * part;
        sum.at += Vector2::new(x as f64, y as f64) * weight * part;
    }
    let chosen = (1..counts.len()).filter(|&l| counts[l] as f64 >= sought.least_px2);
    let origin = Place::new(field.origin.0 as f64, field.origin.1 as f64);
    let mut parts: Vec<Part> = chosen
        .map(|l| Part { area_px2: sums[l].area, centre: origin + sums[l].at / sums[l].area })
        .filter(|part| part.area_px2 > 0.0)
        .collect();
    parts.sort_by(|a, b| b.area_px2.total_cmp(&a.area_px2));
    let area_px2: f64 = parts.iter().map(|part| part.area_px2).sum();
    let small: Vec<usize> = (1..counts.len()).filter(|&l| (counts[l] as f64) < sought.least_px2).collect();
    let specks = (small.iter().map(|&l| sums[l].area.max(0.0)).sum(), small.len());
    // Levels of blocks rest on their neighbours' pixels too: blocks that share them err together.
    let together = (2 * AROUND + 1) as f64;
    let of_levels: f64 = of_blocks.iter().map(|(a, b)| (a * a + b * b) * together).sum();
    let std_px2 = (variance + of_levels + (RIM_PX * rim_px).powi(2)).sqrt();
    let uneven = {
        let blocks: Vec<f64> = inside.blocks.iter().filter(|b| b.n > LEVEL_PX).map(|b| b.sum / b.n).collect();
        let n = blocks.len().max(1) as f64;
        let mean = blocks.iter().sum::<f64>() / n;
        (blocks.iter().map(|b| (b - mean).powi(2)).sum::<f64>() / n).sqrt() / mean.abs().max(1e-9)
    };
    let mut notes = Vec::new();
    if specks.1 > 0 {
        notes.push(Note::Specks(specks.1, specks.0));
    }
    if uneven > UNEVEN {
        notes.push(Note::Uneven(uneven));
    }
    if blur_px > BLURRED_PX {
        notes.push(Note::Blurred(blur_px));
    }
    let others = field.others as f64 / area_px2.max(1.0);
    if others > OTHER {
        notes.push(if field.others_count { Note::OtherColourCounts(others) } else { Note::OtherColour(others) });
    }
    let outline = (0..mask.len())
        .filter(|&i| mask[i] && is_large(labels[i]) && is_rim(i))
        .map(|i| origin + Vector2::new((i % w) as f64, (i / w) as f64))
        .collect();
    Ok(Imprint {
        area_px2,
        std_px2,
        parts,
        holes: if sought.fill_holes {
            (0.0, 0)
        } else {
            holes(field, &labels, &is_large, &paint, &paper, reach, inside.across)
        },
        specks,
        rim_px,
        blur_px,
        colours: colours.told(),
        noise,
        outline,
        notes,
    })
}

/// Sums over a part.
#[derive(Clone, Copy, Default)]
struct Sums {
    area: f64,
    at: Vector2<f64>,
}

/// How large a pixel of each block is in a straightened picture.
fn weights(field: &Field, straight: &dyn Fn(Place) -> Option<Place>) -> Vec<f64> {
    let across = field.width.div_ceil(BLOCK);
    let half = 0.5 * BLOCK as f64;
    let one = |b: usize| {
        let middle = Place::new(
            field.origin.0 as f64 + (b % across * BLOCK) as f64 + half,
            field.origin.1 as f64 + (b / across * BLOCK) as f64 + half,
        );
        let way = |x: f64, y: f64| {
            let step = Vector2::new(x, y) * half;
            Some((straight(middle + step)? - straight(middle - step)?) / (2.0 * half))
        };
        let (Some(x), Some(y)) = (way(1.0, 0.0), way(0.0, 1.0)) else { return f64::NAN };
        x.x * y.y - x.y * y.x
    };
    (0..across * field.height.div_ceil(BLOCK)).map(one).collect()
}

/// What is not painted within large parts: px², and how many such places.
fn holes(
    field: &Field,
    labels: &[u32],
    is_large: &dyn Fn(u32) -> bool,
    paint: &[Plane],
    paper: &[Plane],
    reach: usize,
    across: usize,
) -> (f64, usize) {
    let around: Vec<bool> = labels.iter().map(|label| !is_large(*label)).collect();
    let (of_paper, counts) = field.parts(&around, false);
    let mut is_outside = vec![false; counts.len()];
    is_outside[0] = true;
    field.border().for_each(|i| is_outside[of_paper[i] as usize] = true);
    let marks: Vec<u32> = of_paper.iter().map(|l| if is_outside[*l as usize] { 0 } else { *l }).collect();
    let count = is_outside.iter().filter(|out| !**out).count();
    if count == 0 {
        return (0.0, 0);
    }
    let near = field.near(&marks, reach);
    let w = field.width;
    let unpainted = |i: usize| {
        let (x, y) = (i % w, i / w);
        let block = y / BLOCK * across + x / BLOCK;
        let (dx, dy) = ((x % BLOCK) as f64 / BLOCK as f64 - 0.5, (y % BLOCK) as f64 / BLOCK as f64 - 0.5);
        let (low, high) = (paper[block].level(dx, dy), paint[block].level(dx, dy));
        1.0 - ((f64::from(field.shares[i]) - low) / (high - low).max(0.2)).clamp(-0.5, 1.5)
    };
    // Within reach of a hole there may be the rim of the whole, too: what is nearer to the outside is not the hole's.
    let outer: Vec<u32> = of_paper.iter().map(|l| u32::from(*l > 0 && is_outside[*l as usize])).collect();
    let far = field.near(&outer, reach);
    let area = (0..near.len()).filter(|&i| near[i] > 0 && (far[i] == 0 || marks[i] > 0)).map(unpainted).sum();
    (area, count)
}
