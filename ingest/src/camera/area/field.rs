//! The share of paint in every pixel, and which pixels hang together.

use image::{GrayImage, Luma};
use imageproc::region_labelling::{Connectivity, connected_components};
use nalgebra::Vector3;

use super::super::picture::Picture;
use super::AreaRefusal;
use super::colour::{BESIDE, Colours, beside};

/// A region is at least so many px wide and high.
pub(super) const LEAST: usize = 16;

/// Shares of paint over a region.
pub(super) struct Field {
    pub origin: (usize, usize),
    pub width: usize,
    pub height: usize,
    /// 0: paper, 1: paint as the most of it is.
    pub shares: Vec<f32>,
    /// What is more than half painted.
    pub mask: Vec<bool>,
    /// Pixels of another colour.
    pub others: usize,
    /// Whether they count.
    pub others_count: bool,
}

impl Field {
    pub fn of(
        picture: &Picture,
        [left, top, width, height]: [usize; 4],
        colours: &Colours,
        is_named: bool,
    ) -> Result<Self, AreaRefusal> {
        let paint = colours.paint;
        let per = 1.0 / paint.norm_squared();
        let limit = BESIDE * paint.norm();
        let (mut shares, mut others) = (Vec::with_capacity(width * height), 0);
        for y in 0..height {
            for (x, light) in (0..width).zip(colours.row(y)) {
                let rgb = picture.rgb(left + x, top + y);
                let over = Vector3::from_fn(|k, _| f64::from(rgb[k]) / light[k] - 1.0);
                let share = over.dot(&paint) * per;
                // Mixtures with paper lie on the line; what lies beside it is another colour, and counts unless the paint was named.
                let is_beside = share > 0.3 && beside(&over, &paint) > limit * share.max(0.5);
                others += usize::from(is_beside);
                // Shares are of the order of one: single precision holds them to a millionth.
                #[allow(clippy::cast_possible_truncation)]
                shares.push(if is_beside && is_named { 0.0 } else { share as f32 });
            }
        }
        let mask = shares.iter().map(|share| *share > 0.5).collect();
        let field = Self { origin: (left, top), width, height, shares, mask, others, others_count: !is_named };
        if field.mask.iter().any(|m| *m) { Ok(field) } else { Err(AreaRefusal::NoPaint) }
    }

    /// Parts of a mask (from 1), those that touch across corners being one, with their pixels.
    pub fn parts(&self, mask: &[bool], by_corners: bool) -> (Vec<u32>, Vec<usize>) {
        let pixels = mask.iter().map(|m| if *m { 255 } else { 0 }).collect();
        // Pictures are counted in 32 bits.
        let size = |n: usize| u32::try_from(n).unwrap_or(0);
        let image = GrayImage::from_raw(size(self.width), size(self.height), pixels).unwrap_or_default();
        let connectivity = if by_corners { Connectivity::Eight } else { Connectivity::Four };
        let labels = connected_components(&image, connectivity, Luma([0])).into_raw();
        let mut counts = vec![0; labels.iter().copied().max().unwrap_or(0) as usize + 1];
        for label in &labels {
            counts[*label as usize] += 1;
        }
        (labels, counts)
    }

    /// The first and last row and column.
    pub fn border(&self) -> impl Iterator<Item = usize> + '_ {
        let (w, h) = (self.width, self.height);
        (0..w).chain((h - 1) * w..h * w).chain((0..h).flat_map(move |y| [y * w, y * w + w - 1]))
    }

    /// For every pixel the mark of the nearest one of some within so many px (nought: none), by way of an octagon.
    pub fn near(&self, marks: &[u32], reach: usize) -> Vec<u32> {
        let mut near = marks.to_vec();
        let mut front: Vec<usize> = (0..near.len()).filter(|&i| near[i] > 0).collect();
        for step in 0..reach {
            let mut next = Vec::new();
            for &i in &front {
                let (x, y) = (i % self.width, i / self.width);
                let (left, right) = (x > 0, x + 1 < self.width);
                let (above, below) = (y > 0, y + 1 < self.height);
                let mut ask = |is: bool, k: usize| {
                    if is && near[k] == 0 {
                        near[k] = near[i];
                        next.push(k);
                    }
                };
                ask(left, i.wrapping_sub(1));
                ask(right, i + 1);
                ask(above, i.wrapping_sub(self.width));
                ask(below, i + self.width);
                // Every second step goes across, too.
                if step % 2 == 1 {
                    ask(left && above, i.wrapping_sub(self.width + 1));
                    ask(right && above, i.wrapping_sub(self.width).wrapping_add(1));
                    ask(left && below, (i + self.width).wrapping_sub(1));
                    ask(right && below, i + self.width + 1);
                }
            }
            front = next;
        }
        near
    }
}
