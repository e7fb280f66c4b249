//! Photographs of a barrel on a rod, seen by a camera at a distance.

use image::{DynamicImage, GrayImage, ImageFormat, Luma};

/// A barrel, its lengths in mm.
pub struct Photo {
    pub diameter: f64,
    pub length: f64,
    /// From the camera's centre to the axis.
    pub distance: f64,
    pub mm_per_px: f64,
    pub size: (u32, u32),
    pub noise: f64,
    pub seed: u64,
}

impl Default for Photo {
    fn default() -> Self {
        Self { diameter: 40.0, length: 30.0, distance: 300.0, mm_per_px: 0.1, size: (640, 420), noise: 3.0, seed: 1 }
    }
}

/// Uniform between 0 and 1, from a seed (Steele, Lea and Flood's mix).
fn uniform(state: &mut u64) -> f64 {
    *state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let mut z = *state;
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    f64::from(u32::try_from((z ^ (z >> 31)) >> 32).unwrap()) / f64::from(u32::MAX)
}

/// The normal distribution, to 1e-7 (Abramowitz and Stegun, 26.2.17).
fn below(z: f64) -> f64 {
    let t = 1.0 / (1.0 + 0.231_641_9 * z.abs());
    let sum =
        t * (0.319_381_53 + t * (-0.356_563_782 + t * (1.781_477_937 + t * (-1.821_255_978 + t * 1.330_274_429))));
    let tail = 0.398_942_28 * (-0.5 * z * z).exp() * sum;
    if z > 0.0 { 1.0 - tail } else { tail }
}

impl Photo {
    /// Lines of sight touch a round body before its middle: it looks wider.
    fn apparent(&self, radius: f64) -> f64 {
        radius / (1.0 - (radius / self.distance).powi(2)).sqrt()
    }

    pub fn image(&self) -> DynamicImage {
        const BLUR: f64 = 1.7;
        let (w, h) = self.size;
        let mut state = self.seed;
        let (cx, cy) = (0.5 * f64::from(w - 1) + uniform(&mut state), 0.5 * f64::from(h) + uniform(&mut state));
        let length = self.length / self.mm_per_px;
        let radius = |v: f64| 0.5 * self.diameter * (0.8 + 0.2 * (1.0 - (2.0 * v / self.length).powi(2)));
        let image = GrayImage::from_fn(w, h, |x, y| {
            let (u, v) = (f64::from(x) - cx, f64::from(y) - cy);
            let mm = (v * self.mm_per_px).clamp(-0.5 * self.length, 0.5 * self.length);
            let half = self.apparent(radius(mm)) / self.mm_per_px;
            let slope = -0.8 * 0.5 * self.diameter * mm / (0.5 * self.length).powi(2) * 0.5;
            let side = (half - u.abs()) / slope.hypot(1.0);
            let rod = (0.3 * half - u.abs()).min(if v > 0.0 { 1e4 } else { -1e4 });
            let inside = side.min(0.5 * length - v.abs()).max(rod) / BLUR;
            let body = if inside.abs() > 6.0 { f64::from(u8::from(inside > 0.0)) } else { below(inside) };
            let noise: f64 = (0..4).map(|_| uniform(&mut state)).sum::<f64>() - 2.0;
            // Four even numbers vary by a third together.
            let value = 195.0 - 140.0 * body + self.noise * 3.0_f64.sqrt() * noise;
            #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
            Luma([value.round().clamp(0.0, 255.0) as u8])
        });
        DynamicImage::ImageLuma8(image)
    }

    /// As a file.
    pub fn bytes(&self, format: ImageFormat) -> Vec<u8> {
        let mut bytes = std::io::Cursor::new(Vec::new());
        self.image().write_to(&mut bytes, format).unwrap();
        bytes.into_inner()
    }
}
