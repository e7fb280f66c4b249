//! What is measured in a picture, and with what scale: from places in px to values with units.

use nalgebra::Vector2;

use super::diameter::{Diameter, EdgeUse, diameter};
use super::lens::Lens;
use super::picture::{Picture, Place};
use super::scale::perspective::{Perspective, error_if_ignored_m};
use super::scale::{Length, Scale, as_seen};
use super::silhouette::Sought;

/// Where no distance is known, the error is told for so many radii: that of a body that fills a seventh of the view.
const TYPICAL_RADII: f64 = 15.0;

const MM: f64 = 1e-3;

/// Camera, scale and where the body is.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Setup {
    /// What is sought.
    pub sought: Sought,
    /// The scale; `None`: lengths stay in px.
    pub scale: Option<Scale>,
    /// The lens, if it is calibrated.
    pub lens: Option<Lens>,
    /// From the camera's centre to the plane of the axis.
    pub distance: Option<Length>,
    /// How far the plane of the scale lies before that of the axis, towards the camera, and its standard uncertainty, in m.
    pub offset_m: Option<(f64, f64)>,
}

/// What is measured.
#[derive(Debug, Clone, PartialEq)]
pub enum Task {
    /// The largest width of a round body across its axis.
    Diameter(Setup),
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
    /// What was looked at, to be drawn on the picture.
    pub marks: Marks,
    /// The error of the first value for want of a distance, at a typical one, in m.
    pub ignored_m: Option<f64>,
}

/// Places and lines on the picture.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Marks {
    /// Places of edges, and what becomes of them.
    pub edges: Vec<(Place, EdgeUse)>,
    /// What was measured: a width.
    pub lines: Vec<[Place; 2]>,
    /// The axis.
    pub axes: Vec<[Place; 2]>,
    /// What it is, in words.
    pub label: String,
}

impl Task {
    /// Its word in manifests and on the command line.
    pub fn id(&self) -> &'static str {
        match self {
            Self::Diameter(_) => "diameter",
        }
    }

    /// The values that it gives, each with its unit.
    pub fn columns(&self) -> Vec<(String, &'static str)> {
        match self {
            Self::Diameter(setup) => vec![
                ("diameter".to_owned(), if setup.scale.is_some() { "mm" } else { "px" }),
                ("tilt".to_owned(), "deg"),
                ("blur".to_owned(), "px"),
            ],
        }
    }

    /// Measures a picture.
    ///
    /// # Errors
    /// Why it cannot be measured, in words.
    pub fn measure(&self, picture: &Picture) -> Result<Reading, String> {
        match self {
            Self::Diameter(setup) => setup.diameter(picture),
        }
    }

    /// What all its readings lack, in words.
    pub fn warnings(&self, readings: &[&Reading]) -> Vec<String> {
        let Self::Diameter(setup) = self;
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

    fn diameter(&self, picture: &Picture) -> Result<Reading, String> {
        let found = diameter(picture, self.sought, &|place| self.straight(place)).map_err(|why| why.to_string())?;
        let centre = self.lens.map_or_else(
            || Place::new(0.5 * (picture.width() as f64 - 1.0), 0.5 * (picture.height() as f64 - 1.0)),
            |lens| lens.centre_px,
        );
        let (value, ignored_m) = match (self.scale, self.distance()) {
            (None, _) => (Value { value: found.width_px, std: found.std_px }, None),
            (Some(scale), None) => {
                let length = scale.length(found.width_px, found.std_px);
                let radius = 0.5 * length.metre;
                let ignored = error_if_ignored_m(radius, TYPICAL_RADII * radius, self.offset_m.map_or(0.0, |o| o.0));
                (Value { value: length.metre / MM, std: length.std / MM }, ignored)
            }
            (Some(scale), Some(distance)) => {
                let (offset_m, offset_std_m) = self.offset_m.unwrap_or((0.0, 0.0));
                let perspective = Perspective {
                    distance_m: distance.metre,
                    distance_std_m: distance.std,
                    offset_m,
                    offset_std_m,
                    scale,
                };
                let (edges, stds) = across(&found, centre);
                let round = perspective.cylinder(edges, stds).map_err(|why| why.to_string())?;
                (Value { value: 2.0 * round.radius_m / MM, std: 2.0 * round.std_m / MM }, None)
            }
        };
        let tilt = (-found.axis.x).atan2(found.axis.y).to_degrees();
        let span = found.edges[0].iter().chain(&found.edges[1]).map(|(p, _)| (p - found.ends[0]).dot(&found.axis));
        let (from, to) = span.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(v), b.max(v)));
        let unit = if self.scale.is_some() { "mm" } else { "px" };
        let middle = 0.5 * (found.ends[0] + found.ends[1]);
        let seen = |place: Place| as_seen(self.lens.as_ref(), place);
        let marks = Marks {
            edges: found.edges.iter().flatten().map(|(place, used)| (seen(*place), *used)).collect(),
            lines: vec![found.ends.map(seen)],
            axes: vec![[middle + found.axis * from, middle + found.axis * to].map(seen)],
            label: format!("{:.3} ± {:.3} {unit}", value.value, 1.96 * value.std),
        };
        let values = vec![
            value,
            Value { value: tilt, std: found.axis_std_rad.to_degrees() },
            Value { value: found.blur_px, std: f64::NAN },
        ];
        Ok(Reading { values, notes: found.flags.iter().map(ToString::to_string).collect(), marks, ignored_m })
    }
}

/// Where the two edges lie across the axis from the principal point, in px. What the correction for blur added belongs to both.
fn across(found: &Diameter, centre: Place) -> ([f64; 2], [f64; 2]) {
    let line: Vector2<f64> = found.ends[1] - found.ends[0];
    let way = line / line.norm();
    let at = |i: usize| (found.ends[i] - centre).dot(&way);
    let wider = 0.5 * (found.width_px - line.norm());
    let std = found.std_px / std::f64::consts::SQRT_2;
    ([at(0) - wider, at(1) + wider], [std; 2])
}
