//! How pictures become numbers: `camera` of a reader.

use serde::Deserialize;
use toml::Spanned;

use crate::camera::lens::Lens;
use crate::camera::picture::Place;
use crate::camera::scale::{Length, Scale};
use crate::camera::silhouette::{Axis, Sought};
use crate::camera::task::{Setup, Task};
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
    names: Option<Spanned<String>>,
    topic: Option<Spanned<String>>,
    fps: Option<Spanned<f64>>,
    start: Option<Amount>,
}

#[derive(Clone, Copy, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum Measure {
    Diameter,
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
            sought: Sought {
                axis: self.axis.map(|axis| match axis {
                    RawAxis::Vertical => Axis::Vertical,
                    RawAxis::Horizontal => Axis::Horizontal,
                }),
                is_dark: self.body.map(|body| matches!(body, RawBody::Dark)),
                region: self.region.as_ref().map(|region| *region.get_ref()),
            },
            scale: scale.map(|(metre_per_px, std)| Scale { metre_per_px, std }),
            lens: self.lens.as_ref().map(|lens| lens.checked(document)).transpose()?,
            distance: distance.map(|(metre, std)| Length { metre, std }),
            offset_m,
        };
        let Measure::Diameter = self.measure.get_ref();
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
            task: Some(Task::Diameter(setup)),
            names: self.names.as_ref().map(names).transpose()?,
            film,
        })
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
