//! What is measured in a picture, and with what scale: from places in px to values with units.
//!
//! | file | holds |
//! |---|---|
//! | `round.rs` | the diameter of a round body, seen from near |
//! | `flat.rs` | what lies in one plane: a bent finger, an imprint |

mod flat;
mod round;

use std::borrow::Cow;

use super::area::{Imprint, SoughtArea, area};
use super::bending::markers::{SoughtMarkers, markers};
use super::bending::{Bending, SoughtBending, bending};
use super::diameter::{EdgeUse, diameter};
use super::lens::Lens;
use super::picture::{Picture, Place};
use super::scale::{Length, Scale};
use super::silhouette::Sought;
use super::tone::{Tone, lit, shift_if_ignored};

/// Where no distance is known, the error is told for so many radii: that of a body that fills a seventh of the view.
const TYPICAL_RADII: f64 = 15.0;

/// Less than that is not worth telling, in px.
const TOLD_PX: f64 = 0.01;

const MM: f64 = 1e-3;

/// By how many px an edge between two levels lies on its dark side if the camera stores light by sRGB. Not a number where levels are none.
fn srgb_px(levels: (f64, f64), blur_px: f64) -> f64 {
    shift_if_ignored(Tone::Srgb, levels, blur_px).abs()
}

/// Camera, scale and tone.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Setup {
    /// The scale; `None`: lengths stay in px.
    pub scale: Option<Scale>,
    /// The lens, if it is calibrated.
    pub lens: Option<Lens>,
    /// From the camera's centre to the plane of what is measured: of a round body, of its axis.
    pub distance: Option<Length>,
    /// How far the plane of the scale lies before that plane, towards the camera, and its standard uncertainty, in m.
    pub offset_m: Option<(f64, f64)>,
    /// How the camera stores light; `None`: nobody said, it is taken as it is.
    pub tone: Option<Tone>,
}

/// What is measured.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum What {
    /// The largest width of a round body across its axis.
    Diameter(Sought),
    /// The angle by which a finger bends, and its tip.
    Angle(SoughtBending, Sense),
    /// The same by markers along its centreline.
    Markers(SoughtMarkers, Sense),
    /// The area of an imprint.
    Area(SoughtArea),
}

/// Which way a bend counts as positive, as one looks at the picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Sense {
    /// From x (to the right) towards y (down).
    #[default]
    Clockwise,
    /// The other way.
    Counterclockwise,
}

/// What is measured, and how the camera sees it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Task {
    /// What.
    pub what: What,
    /// With what camera.
    pub setup: Setup,
}

/// A value with its standard uncertainty, in the unit of its column.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Value {
    /// The value.
    pub value: f64,
    /// Standard uncertainty.
    pub std: f64,
}

/// What a picture says.
#[derive(Debug, Clone, PartialEq)]
pub struct Reading {
    /// Values, as [`Task::columns`] has them.
    pub values: Vec<Value>,
    /// What is worth knowing of them.
    pub notes: Vec<String>,
    /// What changes along the body: its width, or the curvature of a finger. An imprint has none.
    pub profile: Option<Profile>,
    /// What was looked at, to be drawn on the picture.
    pub marks: Marks,
    /// The error of the first value for want of a distance, at a typical one, in m.
    pub ignored_m: Option<f64>,
    /// By how many px edges would lie on their dark side if the camera stored light by sRGB.
    pub srgb_px: f64,
}

/// A quantity all along a body.
#[derive(Debug, Clone, PartialEq)]
pub struct Profile {
    /// What it is, and its unit.
    pub name: (&'static str, &'static str),
    /// The unit of places along the body: of a round one from its widest place on, of a finger from its root.
    pub along_unit: &'static str,
    /// Places, and what is there.
    pub points: Vec<(f64, Value)>,
}

/// Places and lines on the picture.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Marks {
    /// Places of edges, and what becomes of them.
    pub edges: Vec<(Place, EdgeUse)>,
    /// What was measured: a width.
    pub lines: Vec<[Place; 2]>,
    /// The axis, or a centreline.
    pub axes: Vec<Vec<Place>>,
    /// What it is, in words.
    pub label: String,
}

impl Task {
    /// Its word in manifests and on the command line.
    pub fn id(&self) -> &'static str {
        match self.what {
            What::Diameter(_) => "diameter",
            What::Angle(..) | What::Markers(..) => "angle",
            What::Area(_) => "area",
        }
    }

    /// The values that it gives, each with its unit.
    pub fn columns(&self) -> Vec<(String, &'static str)> {
        let is_scaled = self.setup.scale.is_some();
        let length = if is_scaled { "mm" } else { "px" };
        let columns: &[(&str, &'static str)] = match self.what {
            What::Diameter(_) => &[("diameter", length), ("tilt", "deg"), ("blur", "px")],
            What::Angle(..) => &[
                ("angle", "deg"),
                ("tip_along", length),
                ("tip_across", length),
                ("length", length),
                ("bend_radius", length),
                ("arc_deviation", length),
                ("blur", "px"),
            ],
            What::Markers(..) => &[
                ("angle", "deg"),
                ("tip_along", length),
                ("tip_across", length),
                ("length", length),
                ("bend_radius", length),
                ("arc_deviation", length),
            ],
            What::Area(_) => {
                let square = if is_scaled { "mm2" } else { "px2" };
                &[("area", square), ("holes", square), ("rim", length), ("blur", "px")]
            }
        };
        columns.iter().map(|(name, unit)| ((*name).to_owned(), *unit)).collect()
    }

    /// Measures a picture.
    ///
    /// # Errors
    /// Why it cannot be measured, in words.
    pub fn measure(&self, picture: &Picture) -> Result<Reading, String> {
        let setup = &self.setup;
        let picture: Cow<Picture> = match setup.tone.unwrap_or_default() {
            Tone::Linear => Cow::Borrowed(picture),
            tone => Cow::Owned(lit(picture, tone).ok_or("the tone curve has no exponent above 0")?),
        };
        let picture = &picture;
        let straight = |place: Place| setup.straight(place);
        match self.what {
            What::Diameter(sought) => {
                let found = diameter(picture, sought, &straight).map_err(|why| why.to_string())?;
                setup.round(picture, &found)
            }
            What::Angle(sought, sense) => {
                let found = bending(picture, sought, &straight).map_err(|why| why.to_string())?;
                Ok(setup.bent(&found, sense))
            }
            What::Markers(sought, sense) => {
                let found = markers(picture, sought, &straight).map_err(|why| why.to_string())?;
                Ok(setup.bent(&found, sense))
            }
            What::Area(sought) => {
                let found = area(picture, sought, &straight).map_err(|why| why.to_string())?;
                setup.imprint(&found)
            }
        }
    }

    /// What all its readings lack, in words.
    pub fn warnings(&self, readings: &[&Reading]) -> Vec<String> {
        let setup = &self.setup;
        let mut warnings = Vec::new();
        if setup.scale.is_none() {
            warnings
                .push("no scale is given: lengths are in px, and no quantity of a length can be compared".to_owned());
        }
        let largest = readings.iter().filter_map(|reading| reading.ignored_m).fold(f64::NAN, f64::max);
        if largest.is_finite() {
            warnings.push(format!(
                "no distance of the camera is given: a round body looks wider than it is, by {:.3} mm of the widest if the camera stood {TYPICAL_RADII} \
                 radii away; give `distance`, and `offset` if the scale does not lie in the plane of the axis",
                largest / MM
            ));
        }
        let shift_px = readings.iter().map(|reading| reading.srgb_px).fold(f64::NAN, f64::max);
        if setup.tone.is_none() && shift_px > TOLD_PX {
            let in_mm = setup.scale.map(|scale| format!(" ({:.3} mm)", shift_px * scale.metre_per_px / MM));
            warnings.push(format!(
                "no `tone` is given: brightness was taken as light. If the camera stores it by the curve of sRGB, as photo cameras and telephones \
                 do, edges lie up to {shift_px:.2} px{} too far on their dark side; say `srgb` or `linear`",
                in_mm.unwrap_or_default()
            ));
        }
        let is_flat = !matches!(self.what, What::Diameter(_));
        if is_flat && setup.offset_m.is_some() && setup.distance().is_none() {
            warnings.push(
                "the scale does not lie in the plane of what is measured, and no distance of the camera is given: the scale was taken as it is; \
                 give `distance`"
                    .to_owned(),
            );
        }
        warnings
    }
}

impl Setup {
    fn straight(&self, place: Place) -> Option<Place> {
        self.lens.as_ref().map_or(Some(place), |lens| lens.straight(place))
    }

    /// The distance that was given, or that follows of lens and scale.
    fn distance(&self) -> Option<Length> {
        let of_lens = || {
            let (lens, scale) = (self.lens?, self.scale?);
            let focal = lens.focal_px.mean();
            // Of the plane of the scale; that of the axis lies behind it.
            let (offset, std) = self.offset_m.unwrap_or((0.0, 0.0));
            Some(Length { metre: scale.metre_per_px * focal + offset, std: (scale.std * focal).hypot(std) })
        };
        self.distance.or_else(of_lens)
    }
}
