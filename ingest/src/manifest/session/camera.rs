//! How pictures become numbers: `camera` of a reader.

use std::ops::Range;

use serde::Deserialize;
use toml::Spanned;

use crate::camera::area::SoughtArea;
use crate::camera::bending::SoughtBending;
use crate::camera::bending::markers::{COUNT, SoughtMarkers, has_chroma};
use crate::camera::lens::Lens;
use crate::camera::picture::Place;
use crate::camera::scale::{Length, Scale};
use crate::camera::silhouette::{Axis, Sought};
use crate::camera::task::{Sense, Setup, Task, What};
use crate::camera::tone::Tone;
use crate::document::{Amount, Document, finite, parse_unit};
use crate::error::{IngestError, shown};
use crate::formats::pictures::PictureOptions;
use crate::formats::pictures::names::Pattern;
use crate::units::Dimension;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(in crate::manifest) struct RawCamera {
    measure: Spanned<Measure>,
    scale: Option<RawLength>,
    distance: Option<RawLength>,
    offset: Option<RawLength>,
    lens: Option<RawLens>,
    axis: Option<RawAxis>,
    body: Option<RawBody>,
    region: Option<Spanned<[usize; 4]>>,
    tone: Option<Spanned<RawTone>>,
    root: Option<Spanned<[f64; 2]>>,
    heading: Option<Amount>,
    markers: Option<RawMarkers>,
    sense: Option<RawSense>,
    paint: Option<Spanned<[f64; 3]>>,
    specks: Option<Spanned<f64>>,
    holes: Option<RawHoles>,
    names: Option<Spanned<String>>,
    topic: Option<Spanned<String>>,
    fps: Option<Spanned<f64>>,
    start: Option<Amount>,
}

#[derive(Clone, Copy, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum Measure {
    Diameter,
    Angle,
    Area,
}

/// Which way a bend counts as positive.
#[derive(Clone, Copy, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum RawSense {
    Clockwise,
    Counterclockwise,
}

/// Whether what is not painted within counts.
#[derive(Clone, Copy, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum RawHoles {
    Out,
    In,
}

/// Markers along the centreline of a finger.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawMarkers {
    colour: Spanned<[f64; 3]>,
    count: Spanned<usize>,
}

/// How a camera stores light: a word, or an exponent.
#[derive(Deserialize)]
#[serde(untagged, deny_unknown_fields)]
enum RawTone {
    Word(String),
    Gamma { gamma: f64 },
}

#[derive(Clone, Copy, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum RawAxis {
    Vertical,
    Horizontal,
}

#[derive(Clone, Copy, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum RawBody {
    Dark,
    Bright,
}

/// A length with its standard uncertainty in the same unit.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawLength {
    value: Spanned<f64>,
    unit: Spanned<String>,
    std: Option<Spanned<f64>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawLens {
    focal: Spanned<[f64; 2]>,
    centre: [f64; 2],
    #[serde(default)]
    radial: Vec<f64>,
    #[serde(default)]
    tangential: [f64; 2],
}

impl RawLength {
    /// Value and standard uncertainty in m.
    fn signed(&self, document: &Document) -> Result<(f64, f64), IngestError> {
        let unit = parse_unit(document, &self.unit)?;
        if unit.dimension != Dimension::Length {
            let found = format!("unit `{}`", unit.symbol);
            return Err(document.malformed(self.unit.span(), "a unit of length", found, "correct the unit"));
        }
        let std = match &self.std {
            None => 0.0,
            Some(std) if *std.get_ref() >= 0.0 && std.get_ref().is_finite() => *std.get_ref(),
            Some(std) => {
                let found = std.get_ref().to_string();
                return Err(document.malformed(std.span(), "a standard uncertainty >= 0", found, "correct it"));
            }
        };
        Ok((unit.to_si(finite(document, &self.value)?), unit.to_si(std)))
    }

    fn above_zero(&self, document: &Document) -> Result<(f64, f64), IngestError> {
        let (metre, std) = self.signed(document)?;
        if metre > 0.0 && std < metre {
            return Ok((metre, std));
        }
        let found =
            format!("{} with a std of {}", self.value.get_ref(), self.std.as_ref().map_or(0.0, |s| *s.get_ref()));
        Err(document.malformed(self.value.span(), "a length > 0 that is larger than its `std`", found, "correct it"))
    }
}

impl RawCamera {
    pub fn options(&self, document: &Document) -> Result<PictureOptions, IngestError> {
        let scale = self.scale.as_ref().map(|scale| scale.above_zero(document)).transpose()?;
        let distance = self.distance.as_ref().map(|distance| distance.above_zero(document)).transpose()?;
        let offset_m = self.offset.as_ref().map(|offset| offset.signed(document)).transpose()?;
        let setup = Setup {
            scale: scale.map(|(metre_per_px, std)| Scale { metre_per_px, std }),
            lens: self.lens.as_ref().map(|lens| lens.checked(document)).transpose()?,
            distance: distance.map(|(metre, std)| Length { metre, std }),
            offset_m,
            tone: self.tone.as_ref().map(|tone| tone.get_ref().checked(tone.span(), document)).transpose()?,
        };
        let what = self.what(document)?;
        let names = |text: &Spanned<String>| {
            Pattern::parse(text.get_ref()).map_err(|why| {
                let expected = "names with numbers in braces: \"p{pressure:kPa}.png\"";
                document.malformed(text.span(), expected, format!("{}: {why}", shown(text.get_ref())), "correct it")
            })
        };
        let film = match (&self.fps, &self.start) {
            (None, None) => None,
            (None, Some(start)) => {
                return Err(document.malformed(
                    start.span(),
                    "`fps` beside `start`",
                    "no `fps`",
                    "add it, or remove `start`",
                ));
            }
            (Some(fps), start) => {
                if !(*fps.get_ref() > 0.0 && fps.get_ref().is_finite()) {
                    let found = fps.get_ref().to_string();
                    return Err(document.malformed(fps.span(), "pictures in a second, > 0", found, "correct it"));
                }
                let start = start.as_ref().map(|start| start.signed(document, Dimension::Time)).transpose()?;
                Some((*fps.get_ref(), start.unwrap_or(0.0)))
            }
        };
        if let Some(topic) = &self.topic {
            for (key, span) in
                [("names", self.names.as_ref().map(Spanned::span)), ("fps", self.fps.as_ref().map(Spanned::span))]
            {
                if let Some(span) = span {
                    return Err(document.malformed(
                        span,
                        "no `names` and no `fps` beside `topic`: messages have stamps of their own",
                        format!("`{key}`"),
                        "remove it, or `topic`",
                    ));
                }
            }
            if topic.get_ref().is_empty() {
                return Err(document.malformed(
                    topic.span(),
                    "the name of a topic",
                    "none",
                    "name it as `inspect` does",
                ));
            }
        }
        Ok(PictureOptions {
            topic: self.topic.as_ref().map(|topic| topic.get_ref().clone()),
            task: Some(Task { what, setup }),
            names: self.names.as_ref().map(names).transpose()?,
            film,
        })
    }
}

impl RawCamera {
    /// What is measured, and where.
    fn what(&self, document: &Document) -> Result<What, IngestError> {
        let measure = *self.measure.get_ref();
        self.only_its_keys(document, measure)?;
        let sought = Sought {
            axis: self.axis.map(|axis| match axis {
                RawAxis::Vertical => Axis::Vertical,
                RawAxis::Horizontal => Axis::Horizontal,
            }),
            is_dark: self.body.map(|body| matches!(body, RawBody::Dark)),
            region: self.region.as_ref().map(|region| *region.get_ref()),
        };
        Ok(match measure {
            Measure::Diameter => What::Diameter(sought),
            Measure::Angle => {
                let root = self.root.as_ref().map(|root| {
                    let [x, y] = *root.get_ref();
                    let expected = "a place in px: x to the right, y down";
                    let wrong = || document.malformed(root.span(), expected, format!("[{x}, {y}]"), "correct it");
                    (x.is_finite() && y.is_finite()).then_some(Place::new(x, y)).ok_or_else(wrong)
                });
                let heading = self.heading.as_ref().map(|heading| heading.signed(document, Dimension::Angle));
                let sense = match self.sense {
                    Some(RawSense::Counterclockwise) => Sense::Counterclockwise,
                    Some(RawSense::Clockwise) | None => Sense::Clockwise,
                };
                let (root, heading_rad) = (root.transpose()?, heading.transpose()?);
                match &self.markers {
                    None => What::Angle(SoughtBending { body: sought, root, heading_rad }, sense),
                    Some(raw) => What::Markers(raw.checked(document, root, heading_rad, sought.region)?, sense),
                }
            }
            Measure::Area => {
                let usual = SoughtArea::default();
                let within = |numbers: &[f64], most: f64| numbers.iter().all(|v| (0.0..=most).contains(v));
                if let Some(paint) = self.paint.as_ref().filter(|paint| !within(paint.get_ref(), 255.0)) {
                    let found = format!("{:?}", paint.get_ref());
                    return Err(document.malformed(paint.span(), "red, green and blue, 0 to 255", found, "correct it"));
                }
                if let Some(specks) = self.specks.as_ref().filter(|specks| !within(&[*specks.get_ref()], 1e9)) {
                    let found = specks.get_ref().to_string();
                    return Err(document.malformed(specks.span(), "an area in px², >= 0", found, "correct it"));
                }
                What::Area(SoughtArea {
                    region: sought.region,
                    paint: self.paint.as_ref().map(|paint| *paint.get_ref()),
                    least_px2: self.specks.as_ref().map_or(usual.least_px2, |specks| *specks.get_ref()),
                    fill_holes: matches!(self.holes, Some(RawHoles::In)),
                })
            }
        })
    }

    /// A key that says nothing of what is measured is a mistake.
    fn only_its_keys(&self, document: &Document, measure: Measure) -> Result<(), IngestError> {
        let of_angle = [
            ("root", self.root.is_some()),
            ("heading", self.heading.is_some()),
            ("sense", self.sense.is_some()),
            ("markers", self.markers.is_some()),
        ];
        let of_area =
            [("paint", self.paint.is_some()), ("specks", self.specks.is_some()), ("holes", self.holes.is_some())];
        let of_diameter = [("axis", self.axis.is_some())];
        let of_body = [("body", self.body.is_some())];
        let strange: Vec<(&str, bool)> = match measure {
            Measure::Diameter => [&of_angle[..], &of_area].concat(),
            // Markers are told by their colour, not by brightness.
            Measure::Angle if self.markers.is_some() => [&of_area[..], &of_diameter, &of_body].concat(),
            Measure::Angle => [&of_area[..], &of_diameter].concat(),
            Measure::Area => [&of_angle[..], &of_diameter, &of_body].concat(),
        };
        match strange.iter().find(|(_, is)| *is) {
            None => Ok(()),
            Some((key, _)) => {
                let word = measure.word();
                Err(document.malformed(
                    self.measure.span(),
                    format!(
                        "keys of measure = \"{word}\"{}",
                        if self.markers.is_some() { " by `markers`" } else { "" }
                    ),
                    format!("`{key}`"),
                    "remove it, or measure something else",
                ))
            }
        }
    }
}

impl Measure {
    fn word(self) -> &'static str {
        match self {
            Self::Diameter => "diameter",
            Self::Angle => "angle",
            Self::Area => "area",
        }
    }
}

impl RawMarkers {
    fn checked(
        &self,
        document: &Document,
        root: Option<Place>,
        heading_rad: Option<f64>,
        region: Option<[usize; 4]>,
    ) -> Result<SoughtMarkers, IngestError> {
        let (colour, count) = (*self.colour.get_ref(), *self.count.get_ref());
        if !(colour.iter().all(|v| (0.0..=255.0).contains(v)) && has_chroma(colour)) {
            let expected = "red, green and blue of the markers, 0 to 255, that differ: grey tells no marker";
            return Err(document.malformed(self.colour.span(), expected, format!("{colour:?}"), "correct it"));
        }
        if !(COUNT.0..=COUNT.1).contains(&count) {
            let expected = format!("{} to {} markers", COUNT.0, COUNT.1);
            return Err(document.malformed(self.count.span(), expected, count.to_string(), "correct it"));
        }
        let root = root.ok_or_else(|| {
            let expected = "`root` beside `markers`: the place of the first of them, in px";
            document.malformed(self.colour.span(), expected, "none", "add it")
        })?;
        Ok(SoughtMarkers { colour, count, root, region, heading_rad })
    }
}

impl RawTone {
    fn checked(&self, span: Range<usize>, document: &Document) -> Result<Tone, IngestError> {
        let expected = "\"linear\", \"srgb\", or { gamma = 2.2 } with an exponent > 0";
        let (tone, found) = match self {
            Self::Word(word) if word == "linear" => return Ok(Tone::Linear),
            Self::Word(word) if word == "srgb" => return Ok(Tone::Srgb),
            Self::Word(word) => (None, shown(word)),
            Self::Gamma { gamma } => (Some(Tone::Gamma(*gamma)), gamma.to_string()),
        };
        tone.filter(|tone| tone.is_sound()).ok_or_else(|| document.malformed(span, expected, found, "correct it"))
    }
}

impl RawLens {
    fn checked(&self, document: &Document) -> Result<Lens, IngestError> {
        let [fx, fy] = *self.focal.get_ref();
        let numbers =
            [fx, fy].iter().chain(&self.centre).chain(&self.radial).chain(&self.tangential).all(|v| v.is_finite());
        if !(numbers && fx > 0.0 && fy > 0.0 && self.radial.len() <= 3) {
            let expected =
                "focal lengths in px > 0, a centre, `radial` of up to three and `tangential` of two finite numbers";
            return Err(document.malformed(
                self.focal.span(),
                expected,
                "others",
                "correct it, or print it by `pneuval measure lens`",
            ));
        }
        let radial = |i: usize| self.radial.get(i).copied().unwrap_or(0.0);
        Ok(Lens {
            focal_px: nalgebra::Vector2::new(fx, fy),
            centre_px: Place::new(self.centre[0], self.centre[1]),
            radial: [radial(0), radial(1), radial(2)],
            tangential: self.tangential,
        })
    }
}
