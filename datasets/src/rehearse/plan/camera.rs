//! `[device.camera]`: a device that takes photographs.

use serde::Deserialize;
use toml::Spanned;

use pneuval_ingest::IngestError;
use pneuval_ingest::document::{Amount, Document};
use pneuval_ingest::units::Dimension;

/// Pictures that are rendered are small: a side in px, at least and at most.
const SIDE_PX: std::ops::RangeInclusive<usize> = 64..=4000;

/// A camera of a plan.
#[derive(Debug, Clone, PartialEq)]
pub struct PlanCamera {
    /// The channel whose value is seen; it stands in no file.
    pub channel: String,
    /// When pictures are taken.
    pub moments: Moments,
    /// What is seen.
    pub object: PlanObject,
    /// Width and height of a picture, in px.
    pub size_px: [usize; 2],
    /// Of a px in the object's plane, as it is declared, and how uncertain that is, in m.
    pub scale_m: (f64, f64),
    /// From the camera to the object, as it is declared, and how uncertain that is, in m.
    pub distance_m: (f64, f64),
    /// Standard deviation of the lens's blur.
    pub blur_px: f64,
    /// Standard deviation of a pixel's noise, in steps of 8 bits.
    pub noise: f64,
    /// The camera is what it is said to be, and everything stands upright.
    pub is_flawless: bool,
}

/// When pictures are taken.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Moments {
    /// One while each state stands; what is logged with it is noted in its name.
    Stations,
    /// As many in a second as the device's rate says.
    Film,
}

/// What is seen. Lengths in m.
#[derive(Debug, Clone, PartialEq)]
pub enum PlanObject {
    /// A barrel whose largest diameter is the value, on a rod.
    Barrel {
        /// Between its ends.
        length_m: f64,
        /// Diameter of its ends, which are clamped.
        ends_m: f64,
        /// Diameter of the rod.
        rod_m: f64,
        /// Length of the plate at its lower end.
        foot_m: f64,
    },
    /// A finger whose angle is the value, bent as an arc.
    Finger {
        /// From mount to tip.
        length_m: f64,
        /// Across.
        width_m: f64,
        /// Waves on its outer side, and their height.
        waves: (usize, f64),
    },
    /// Paint on paper whose area is the value.
    Imprint {
        /// Holes in it.
        holes: usize,
        /// By how much the paper shows through at most, as a share.
        uneven: f64,
    },
}

impl PlanObject {
    /// What the reader of the pictures calls it, and its column.
    pub fn measure(&self) -> &'static str {
        match self {
            Self::Barrel { .. } => "diameter",
            Self::Finger { .. } => "angle",
            Self::Imprint { .. } => "area",
        }
    }

    /// The column's unit.
    pub fn symbol(&self) -> &'static str {
        match self {
            Self::Barrel { .. } => "mm",
            Self::Finger { .. } => "deg",
            Self::Imprint { .. } => "mm2",
        }
    }

    /// What is measured.
    pub fn dimension(&self) -> Dimension {
        match self {
            Self::Barrel { .. } => Dimension::Length,
            Self::Finger { .. } => Dimension::Angle,
            Self::Imprint { .. } => Dimension::Area,
        }
    }
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawCamera {
    channel: Spanned<String>,
    moments: Moments,
    object: RawObject,
    size: Spanned<[usize; 2]>,
    scale: Amount,
    scale_std: Option<Amount>,
    distance: Amount,
    distance_std: Option<Amount>,
    /// In px.
    blur: Spanned<f64>,
    /// In steps of 8 bits.
    noise: Spanned<f64>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
enum RawObject {
    Barrel { length: Amount, ends: Amount, rod: Amount, foot: Option<Amount> },
    Finger { length: Amount, width: Amount, waves: Option<usize>, wave_height: Option<Amount> },
    Imprint { holes: Spanned<usize>, uneven: Amount },
}

/// More holes are no imprint.
const HOLES_MAX: usize = 20;

impl RawCamera {
    pub fn checked(&self, document: &Document) -> Result<PlanCamera, IngestError> {
        let length = |amount: &Amount| amount.checked(document, Dimension::Length);
        let or_none = |amount: &Option<Amount>| {
            amount.as_ref().map_or(Ok(0.0), |amount| amount.not_negative(document, Dimension::Length))
        };
        let up_to = |number: &Spanned<f64>, most: f64| {
            if (0.0..=most).contains(number.get_ref()) {
                return Ok(*number.get_ref());
            }
            let found = number.get_ref().to_string();
            Err(document.malformed(number.span(), format!("0 to {most}"), found, "correct it"))
        };
        if !self.size.get_ref().iter().all(|side| SIDE_PX.contains(side)) {
            let [width, height] = self.size.get_ref();
            let expected = format!("width and height of {} to {} px", SIDE_PX.start(), SIDE_PX.end());
            return Err(document.malformed(self.size.span(), expected, format!("{width} x {height}"), "correct it"));
        }
        let object = match &self.object {
            RawObject::Barrel { length: long, ends, rod, foot } => PlanObject::Barrel {
                length_m: length(long)?,
                ends_m: length(ends)?,
                rod_m: length(rod)?,
                foot_m: or_none(foot)?,
            },
            RawObject::Finger { length: long, width, waves, wave_height } => PlanObject::Finger {
                length_m: length(long)?,
                width_m: length(width)?,
                waves: (waves.unwrap_or(0), or_none(wave_height)?),
            },
            RawObject::Imprint { holes, uneven } => {
                if *holes.get_ref() > HOLES_MAX {
                    let found = holes.get_ref().to_string();
                    return Err(document.malformed(holes.span(), format!("at most {HOLES_MAX}"), found, "correct it"));
                }
                PlanObject::Imprint { holes: *holes.get_ref(), uneven: super::raw::share(document, uneven)? }
            }
        };
        Ok(PlanCamera {
            channel: self.channel.get_ref().clone(),
            moments: self.moments,
            object,
            size_px: *self.size.get_ref(),
            scale_m: (length(&self.scale)?, or_none(&self.scale_std)?),
            distance_m: (length(&self.distance)?, or_none(&self.distance_std)?),
            blur_px: up_to(&self.blur, 20.0)?,
            noise: up_to(&self.noise, 50.0)?,
            is_flawless: false,
        })
    }
}
