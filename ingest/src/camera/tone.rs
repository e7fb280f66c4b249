//! Tone curves: from what a picture stores to the light that fell on it.
//!
//! Cameras store brightness through a curve, most of them that of sRGB (IEC 61966-2-1), with both from 0 to 1:
//!
//! ```text
//! stored = 12.92 light                       light ≤ 0.0031308
//! stored = 1.055 light^(1/2.4) - 0.055       above
//! ```
//!
//! A pixel that an edge crosses holds a mixture of the *light* of both sides. Half of the way between two stored brightnesses is less than
//! half of the light, so that an edge which is looked for there lies too far on its dark side: a dark body looks thinner, a dark imprint
//! smaller. For a step blurred by σ px (standard deviation) between lights A and B:
//!
//! ```text
//! I(t) = A + (B - A) Φ(t/σ)         shift = σ Φ⁻¹((light(half of the stored way) - A)/(B - A))
//! ```
//!
//! Between stored 40 and 200 of 255 that is 0.526 σ towards the dark side:
//!
//! ```
//! use pneuval_ingest::camera::tone::{Tone, shift_if_ignored};
//! let shift = shift_if_ignored(Tone::Srgb, (40.0, 200.0), 1.5);
//! assert!((shift + 0.7890).abs() < 5e-4);
//! ```
//!
//! An edge that is fitted (see [`super::edge`]) moves by 0.94 to 1 of that: a bent step is not the step that is fitted. What cameras do beside the curve (sharpening, contrast curves of their own) is not known here: raw pictures are free of it.

use statrs::distribution::{ContinuousCDF, Normal};

use super::picture::{Picture, Pixels};

/// Where the two pieces of sRGB's curve meet, in light and as stored, and their constants.
const SRGB_LIGHT: f64 = 0.003_130_8;
const SRGB_STORED: f64 = 0.040_45;
const SRGB_SLOPE: f64 = 12.92;
const SRGB_POWER: f64 = 2.4;
const SRGB_OFFSET: f64 = 0.055;

/// Brightness at full scale, in steps of 8 bits.
const FULL: f64 = 255.0;

/// How a camera stores light.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Tone {
    /// As it is: raw and scientific cameras.
    #[default]
    Linear,
    /// By the curve of sRGB: JPEGs and PNGs of photo cameras and telephones, as far as they keep to it.
    Srgb,
    /// stored = light^(1/γ), both from 0 to 1: what the `gamma` setting of industrial cameras does. γ above 0.
    Gamma(f64),
}

impl Tone {
    /// Whether it is a curve: an exponent above 0 that is known.
    pub fn is_sound(self) -> bool {
        match self {
            Self::Linear | Self::Srgb => true,
            Self::Gamma(gamma) => gamma > 0.0 && gamma.is_finite(),
        }
    }

    /// The light of a stored brightness, both from 0 to 1; beyond them, that at the end. Not a number of a curve that is none.
    pub fn decoded(self, stored: f64) -> f64 {
        let stored = stored.clamp(0.0, 1.0);
        match self {
            _ if !self.is_sound() => f64::NAN,
            Self::Linear => stored,
            Self::Srgb if stored <= SRGB_STORED => stored / SRGB_SLOPE,
            Self::Srgb => ((stored + SRGB_OFFSET) / (1.0 + SRGB_OFFSET)).powf(SRGB_POWER),
            Self::Gamma(gamma) => stored.powf(gamma),
        }
    }

    /// The stored brightness of a light, both from 0 to 1; beyond them, that at the end. Not a number of a curve that is none.
    pub fn encoded(self, light: f64) -> f64 {
        let light = light.clamp(0.0, 1.0);
        match self {
            _ if !self.is_sound() => f64::NAN,
            Self::Linear => light,
            Self::Srgb if light <= SRGB_LIGHT => SRGB_SLOPE * light,
            Self::Srgb => (1.0 + SRGB_OFFSET) * light.powf(1.0 / SRGB_POWER) - SRGB_OFFSET,
            Self::Gamma(gamma) => light.powf(1.0 / gamma),
        }
    }

    /// The light of a stored value of 8 bits, 0 to 255.
    pub fn linear(self, stored: u8) -> f64 {
        FULL * self.decoded(f64::from(stored) / FULL)
    }

    /// The light of a stored value of 16 bits, 0 to 255.
    pub fn linear_of_16(self, stored: u16) -> f64 {
        FULL * self.decoded(f64::from(stored) / f64::from(u16::MAX))
    }

    /// That in 16 bits.
    fn of_16(self, share: f64) -> u16 {
        // Between 0 and 65535; not a number becomes 0.
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        let value = (self.decoded(share) * f64::from(u16::MAX)).round() as u16;
        value
    }
}

/// The picture in light, with 16 bits. What the light scattered within a step of the stored brightness is no longer known: where the
/// curve is steep (sRGB at full scale), a step of 8 bits is 2.3 steps of light. `None` of a curve that is none.
pub fn lit(picture: &Picture, tone: Tone) -> Option<Picture> {
    if !tone.is_sound() {
        return None;
    }
    let of_8 = |all: &[u8]| -> Vec<u16> {
        let table: [u16; 256] = std::array::from_fn(|i| tone.of_16(i as f64 / FULL));
        all.iter().map(|v| table[usize::from(*v)]).collect()
    };
    let of_16 = |all: &[u16]| -> Vec<u16> {
        let table: Vec<u16> = (0..=u16::MAX).map(|i| tone.of_16(f64::from(i) / f64::from(u16::MAX))).collect();
        all.iter().map(|v| table[usize::from(*v)]).collect()
    };
    let pixels = match picture.pixels() {
        Pixels::Gray8(all) => Pixels::Gray16(of_8(all)),
        Pixels::Gray16(all) => Pixels::Gray16(of_16(all)),
        Pixels::Rgb8(all) => Pixels::Rgb16(of_8(all)),
        Pixels::Rgb16(all) => Pixels::Rgb16(of_16(all)),
    };
    Picture::new(picture.width(), picture.height(), pixels)
}

/// By how many px an edge is found away from where it is, if a tone is taken for linear: from the first of two stored brightnesses (0 to
/// 255) towards the second, of a step that is blurred by so many px. Not a number of levels that are the same.
pub fn shift_if_ignored(tone: Tone, levels: (f64, f64), blur_px: f64) -> f64 {
    let light = |stored: f64| tone.decoded(stored / FULL);
    let (a, b) = (light(levels.0), light(levels.1));
    let share = (light(f64::midpoint(levels.0, levels.1)) - a) / (b - a);
    // Of a share that is none, or of levels that are the same, there is no place.
    if share > 0.0 && share < 1.0 { blur_px * Normal::standard().inverse_cdf(share) } else { f64::NAN }
}

#[cfg(test)]
mod tests {
    use super::super::edge::Blur;
    use super::*;

    #[test]
    fn the_curve_goes_both_ways_and_has_the_values_of_the_standard() {
        for tone in [Tone::Linear, Tone::Srgb, Tone::Gamma(2.2), Tone::Gamma(0.45)] {
            for i in 0..=1000 {
                let light = f64::from(i) / 1000.0;
                assert!((tone.decoded(tone.encoded(light)) - light).abs() < 1e-6, "{tone:?} {light}");
            }
            assert!(tone.linear(0).abs() < 1e-12 && (tone.linear(255) - 255.0).abs() < 1e-9, "{tone:?}");
            assert!((tone.linear(77) - tone.linear_of_16(77 * 257)).abs() < 1e-9);
        }
        // Stored 188 is half of the light: 187.5 by the formula.
        assert!((Tone::Srgb.encoded(0.5) * 255.0 - 187.516).abs() < 1e-3);
        assert!((Tone::Srgb.linear(10) - 10.0 / 12.92).abs() < 1e-9);
        // The pieces meet as well as the standard has them.
        assert!((Tone::Srgb.encoded(SRGB_LIGHT) - SRGB_STORED).abs() < 1e-6);
        assert!(Tone::Gamma(0.0).linear(7).is_nan() && !Tone::Gamma(f64::NAN).is_sound());
    }

    #[test]
    fn a_picture_in_light_has_every_value_by_the_curve() {
        let stored: Vec<u8> = (0..=255).collect();
        let grey = Picture::new(256, 1, Pixels::Gray8(stored)).unwrap();
        let light = lit(&grey, Tone::Srgb).unwrap();
        for i in 0..=255_u8 {
            // To half a step of 16 bits.
            assert!((f64::from(light.luma(usize::from(i), 0)) - Tone::Srgb.linear(i)).abs() < 2.1e-3);
        }
        let colours = Picture::new(1, 1, Pixels::Rgb16(vec![0, 30_000, 65_535])).unwrap();
        let light = lit(&colours, Tone::Gamma(2.0)).unwrap().rgb(0, 0);
        let expected = [0.0, 255.0 * (30_000.0_f32 / 65_535.0).powi(2), 255.0];
        assert!(light.iter().zip(expected).all(|(a, b)| (a - b).abs() < 3e-3), "{light:?}");
        assert_eq!(lit(&grey, Tone::Gamma(-1.0)), None);
    }

    /// A step from one stored level to another at `at`, each px the mean of the light over its width, stored by a tone.
    fn step(tone: Tone, at: f64, blur: f64, levels: (f64, f64)) -> Vec<f32> {
        let normal = Normal::new(0.0, blur).unwrap();
        let (a, b) = (tone.decoded(levels.0 / FULL), tone.decoded(levels.1 / FULL));
        let of = |i: f64| {
            let part = (0..20).map(|k| normal.cdf(i - 0.475 + 0.05 * f64::from(k) - at)).sum::<f64>() / 20.0;
            FULL * tone.encoded(a + (b - a) * part)
        };
        #[allow(clippy::cast_possible_truncation)]
        (0..30).map(|i| of(f64::from(i)) as f32).collect()
    }

    #[test]
    fn an_edge_in_a_stored_picture_is_found_as_far_off_as_the_formula_says() {
        let blur = Blur::new();
        for tone in [Tone::Srgb, Tone::Gamma(2.2), Tone::Gamma(1.5)] {
            for levels in [(40.0, 200.0), (200.0, 40.0), (100.0, 200.0), (20.0, 240.0), (150.0, 180.0)] {
                for px in [1.0, 1.5, 2.5] {
                    let line = step(tone, 14.3, px, levels);
                    let wide = f64::hypot(px, 1.0 / 12.0_f64.sqrt());
                    let found = blur.edge(&line, 14.3, wide, true, 6).unwrap().at - 14.3;
                    let said = shift_if_ignored(tone, levels, wide);
                    // A fitted step is not quite the half level of a bent one: 6 % of the shift, at most.
                    assert!((found - said).abs() < 0.07 * said.abs() + 1e-3, "{tone:?} {levels:?}: {found} {said}");
                    // In light it is where it is.
                    let light: Vec<f32> = line.iter().map(|v| lit_of(tone, *v)).collect();
                    let there = blur.edge(&light, 14.3, wide, true, 6).unwrap().at - 14.3;
                    assert!(there.abs() < 2e-3, "{there}");
                }
            }
        }
        assert!(shift_if_ignored(Tone::Linear, (40.0, 200.0), 2.0).abs() < 1e-9);
        assert!(shift_if_ignored(Tone::Srgb, (90.0, 90.0), 2.0).is_nan());
        assert!(shift_if_ignored(Tone::Gamma(-2.0), (40.0, 200.0), 2.0).is_nan());
    }

    #[allow(clippy::cast_possible_truncation)]
    fn lit_of(tone: Tone, stored: f32) -> f32 {
        (FULL * tone.decoded(f64::from(stored) / FULL)) as f32
    }
}
