//! A picture in memory: brightness at pixels and between them.
//!
//! The centre of the first pixel is (0, 0), x to the right, y down, in px. Brightness is in steps of 8 bits, 0 to 255, whatever the depth; of
//! a colour picture it is luma (ITU-R BT.601), as JPEG stores it.

use nalgebra::Vector2;

/// A place in a picture, in px.
pub type Place = Vector2<f64>;

/// Weights of red, green and blue in the brightness.
const LUMA: [f32; 3] = [0.299, 0.587, 0.114];

/// From 16 bits to steps of 8.
const STEPS_OF_16: f32 = 257.0;

/// A picture, row by row.
#[derive(Debug, Clone, PartialEq)]
pub struct Picture {
    width: usize,
    height: usize,
    pixels: Pixels,
}

/// Pixels as they were decoded.
#[derive(Debug, Clone, PartialEq)]
pub enum Pixels {
    /// Grey, 8 bits.
    Gray8(Vec<u8>),
    /// Grey, 16 bits.
    Gray16(Vec<u16>),
    /// Red, green, blue, 8 bits each.
    Rgb8(Vec<u8>),
    /// Red, green, blue, 16 bits each.
    Rgb16(Vec<u16>),
}

impl Picture {
    /// `None` if the pixels are not as many as that, or none.
    pub fn new(width: usize, height: usize, pixels: Pixels) -> Option<Self> {
        let samples = match &pixels {
            Pixels::Gray8(all) => all.len(),
            Pixels::Gray16(all) => all.len(),
            Pixels::Rgb8(all) => all.len() / 3 * usize::from(all.len() % 3 == 0),
            Pixels::Rgb16(all) => all.len() / 3 * usize::from(all.len() % 3 == 0),
        };
        (samples > 0 && width.checked_mul(height) == Some(samples)).then_some(Self { width, height, pixels })
    }

    /// In px.
    pub fn width(&self) -> usize {
        self.width
    }

    /// In px.
    pub fn height(&self) -> usize {
        self.height
    }

    /// The pixels as they were decoded.
    pub fn pixels(&self) -> &Pixels {
        &self.pixels
    }

    /// Whether it has colours.
    pub fn is_colour(&self) -> bool {
        matches!(self.pixels, Pixels::Rgb8(_) | Pixels::Rgb16(_))
    }

    /// Brightness of a pixel, 0 to 255. Pixels beyond the border are those at it.
    pub fn luma(&self, x: usize, y: usize) -> f32 {
        let i = y.min(self.height - 1) * self.width + x.min(self.width - 1);
        match &self.pixels {
            Pixels::Gray8(all) => f32::from(all[i]),
            Pixels::Gray16(all) => f32::from(all[i]) / STEPS_OF_16,
            Pixels::Rgb8(all) => weighed(|c| f32::from(all[3 * i + c])),
            Pixels::Rgb16(all) => weighed(|c| f32::from(all[3 * i + c])) / STEPS_OF_16,
        }
    }

    /// Red, green, blue of a pixel, 0 to 255; of a grey one, all the same.
    pub fn rgb(&self, x: usize, y: usize) -> [f32; 3] {
        let i = y.min(self.height - 1) * self.width + x.min(self.width - 1);
        match &self.pixels {
            Pixels::Gray8(all) => [f32::from(all[i]); 3],
            Pixels::Gray16(all) => [f32::from(all[i]) / STEPS_OF_16; 3],
            Pixels::Rgb8(all) => [0, 1, 2].map(|c| f32::from(all[3 * i + c])),
            Pixels::Rgb16(all) => [0, 1, 2].map(|c| f32::from(all[3 * i + c]) / STEPS_OF_16),
        }
    }

    /// Brightness of the pixels of a row from `x` on.
    pub fn luma_row(&self, y: usize, x: usize, into: &mut [f32]) {
        let i = y.min(self.height - 1) * self.width;
        let last = self.width - 1;
        let whole = x + into.len() <= self.width;
        match &self.pixels {
            Pixels::Gray8(all) if whole => {
                into.iter_mut().zip(&all[i + x..]).for_each(|(to, from)| *to = f32::from(*from));
            }
            Pixels::Rgb8(all) if whole => {
                let from = all[3 * (i + x)..].chunks_exact(3);
                into.iter_mut().zip(from).for_each(|(to, rgb)| *to = weighed(|c| f32::from(rgb[c])));
            }
            _ => into.iter_mut().enumerate().for_each(|(k, to)| *to = self.luma((x + k).min(last), y)),
        }
    }

    /// The picture so many times smaller, in 8 bits: each px the mean of those that it stands for. What is left over at the right and at the
    /// bottom is cut off.
    #[must_use]
    pub fn smaller(&self, by: usize) -> Self {
        let by = by.clamp(1, self.width.min(self.height));
        let (width, height) = (self.width / by, self.height / by);
        let mut pixels = Vec::with_capacity(width * height * if self.is_colour() { 3 } else { 1 });
        let n = (by * by) as f32;
        // Means of brightness between 0 and 255.
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        let byte = |sum: f32| (sum / n).round().clamp(0.0, 255.0) as u8;
        for i in 0..width * height {
            let (x, y) = (i % width * by, i / width * by);
            let all = (0..by * by).map(|k| (x + k % by, y + k / by));
            if self.is_colour() {
                let mut sum = [0.0_f32; 3];
                all.for_each(|(x, y)| sum.iter_mut().zip(self.rgb(x, y)).for_each(|(s, v)| *s += v));
                pixels.extend(sum.map(byte));
            } else {
                pixels.push(byte(all.map(|(x, y)| self.luma(x, y)).sum()));
            }
        }
        let pixels = if self.is_colour() { Pixels::Rgb8(pixels) } else { Pixels::Gray8(pixels) };
        Self { width, height, pixels }
    }

    /// Brightness between pixels, on planes through four of them (bilinear).
    pub fn between(&self, at: Place) -> f64 {
        let clamp = |v: f64, n: usize| v.clamp(0.0, (n - 1) as f64);
        let (x, y) = (clamp(at.x, self.width), clamp(at.y, self.height));
        // Not negative and below the width: nothing is cut off but the fraction.
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        let (left, top) = (x as usize, y as usize);
        let (fx, fy) = (x.fract(), y.fract());
        let of = |x, y| f64::from(self.luma(x, y));
        let row = |y| of(left, y) * (1.0 - fx) + of(left + 1, y) * fx;
        row(top) * (1.0 - fy) + row(top + 1) * fy
    }
}

fn weighed(of: impl Fn(usize) -> f32) -> f32 {
    LUMA[0] * of(0) + LUMA[1] * of(1) + LUMA[2] * of(2)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_depth_is_brightness_in_steps_of_eight_bits() {
        let picture = |pixels| Picture::new(2, 1, pixels).unwrap();
        let same = |a: f32, b: f32| assert!((a - b).abs() < 1e-3, "{a} {b}");
        same(picture(Pixels::Gray8(vec![0, 200])).luma(1, 0), 200.0);
        same(picture(Pixels::Gray16(vec![0, 200 * 257])).luma(1, 0), 200.0);
        same(picture(Pixels::Rgb8(vec![0, 0, 0, 255, 0, 0])).luma(1, 0), 0.299 * 255.0);
        same(picture(Pixels::Rgb16(vec![0, 0, 0, 0, 0, 65535])).luma(1, 0), 0.114 * 255.0);
        let grey = picture(Pixels::Gray8(vec![10, 20]));
        assert!((grey.between(Place::new(0.25, 0.0)) - 12.5).abs() < 1e-9);
        // At the border and beyond it, that of the border.
        assert!((grey.between(Place::new(7.0, -3.0)) - 20.0).abs() < 1e-9);
        let mut row = [0.0; 3];
        grey.luma_row(0, 0, &mut row);
        assert!(row.iter().zip([10.0, 20.0, 20.0]).all(|(a, b)| (a - b).abs() < 1e-6));
        assert!(
            Picture::new(2, 2, Pixels::Gray8(vec![0; 3])).is_none()
                && Picture::new(0, 0, Pixels::Rgb8(vec![])).is_none()
        );
    }
}
