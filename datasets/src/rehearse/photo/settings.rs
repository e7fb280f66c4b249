//! What becomes of the light: blur, fall-off, colours, tone, noise, depth.

use super::NoPhotograph;

/// Light of red, green and blue, as a share of what is as bright as can be told, in linear light.
pub type Rgb = [f32; 3];

/// Light, lens and sensor.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings {
    /// Standard deviation of the lens's blur; a pixel's own width comes beside it.
    pub blur_px: f64,
    /// Standard deviation of a pixel's noise, in steps of 8 bits, after the tone curve.
    pub noise: f64,
    /// How the light falls off.
    pub light: Light,
    /// What lies behind.
    pub background: Rgb,
    /// The object: body, finger, paint, marks.
    pub object: Rgb,
    /// How much brighter the shine on it is, as a share of the light that it lacks; 0 is none.
    pub glare: f64,
    /// Whether a cable hangs into the picture beside the object.
    pub clutter: bool,
    /// Whether it has colours; else it is grey.
    pub is_colour: bool,
    /// Bits.
    pub depth: Depth,
    /// The tone curve.
    pub tone: Tone,
}

/// Light over the picture: 1 + slope · (u, v) - `fall_off` (u² + v²), where u and v are -1 and 1 at the borders.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Light {
    /// To the right and down.
    pub slope: [f64; 2],
    /// From the middle outwards.
    pub fall_off: f64,
}

/// Bits of a sample.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Depth {
    /// 256 steps.
    Eight,
    /// 65 536 steps.
    Sixteen,
}

/// From light to numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Tone {
    /// As raw pictures are.
    Linear,
    /// As most JPEGs are: IEC 61966-2-1.
    Srgb,
}

impl Default for Settings {
    /// A dark object before a bright ground, a good lens, an 8-bit grey sensor.
    fn default() -> Self {
        Self {
            blur_px: 1.2,
            noise: 1.5,
            light: Light::default(),
            background: [0.76; 3],
            object: [0.2; 3],
            glare: 0.0,
            clutter: false,
            is_colour: false,
            depth: Depth::Eight,
            tone: Tone::Linear,
        }
    }
}

/// More blur than this is no picture any more.
const BLUR_PX_MAX: f64 = 50.0;

impl Settings {
    /// # Errors
    /// For numbers that nothing has.
    pub(super) fn checked(&self) -> Result<&Self, NoPhotograph> {
        let Self { blur_px, noise, light, background, object, glare, .. } = self;
        let shares = background.iter().chain(object).all(|share| (0.0..=1.0).contains(share));
        if !shares || !(0.0..=1.0).contains(glare) {
            return Err(NoPhotograph::Number("colours and glare: expected shares from 0 to 1"));
        }
        if !(0.0..=BLUR_PX_MAX).contains(blur_px) || !(0.0..=255.0).contains(noise) {
            return Err(NoPhotograph::Number("expected a blur of 0 to 50 px, and noise of 0 to 255 steps"));
        }
        if !light.slope.iter().chain([&light.fall_off]).all(|share| share.abs() <= 1.0) {
            return Err(NoPhotograph::Number("the light: expected slopes and a fall-off of at most 1"));
        }
        Ok(self)
    }
}

impl Tone {
    /// Of linear light from 0 to 1.
    pub fn of(self, light: f64) -> f64 {
        match self {
            Self::Linear => light,
            Self::Srgb if light <= 0.003_130_8 => 12.92 * light,
            Self::Srgb => 1.055 * light.powf(1.0 / 2.4) - 0.055,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tone_is_that_of_the_standard_and_numbers_that_nothing_has_are_refused() {
        // IEC 61966-2-1: half of the steps are a fifth of the light.
        assert!((Tone::Srgb.of(0.214_041) - 0.5).abs() < 1e-5);
        assert!((Tone::Srgb.of(1.0) - 1.0).abs() < 1e-12 && Tone::Srgb.of(0.0).abs() < 1e-12);
        let good = Settings::default();
        assert!(good.checked().is_ok());
        for bad in [
            Settings { blur_px: f64::NAN, ..good },
            Settings { blur_px: -1.0, ..good },
            Settings { noise: f64::INFINITY, ..good },
            Settings { object: [f32::NAN; 3], ..good },
            Settings { glare: 2.0, ..good },
            Settings { light: Light { slope: [0.0, f64::NAN], fall_off: 0.0 }, ..good },
        ] {
            assert!(bad.checked().is_err(), "{bad:?}");
        }
    }
}
