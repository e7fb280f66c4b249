//! The diameter of a round body, seen from near.

use nalgebra::Vector2;

use super::{MM, Marks, Profile, Reading, Setup, TYPICAL_RADII, Value, srgb_px};
use crate::camera::diameter::{Diameter, Width};
use crate::camera::picture::{Picture, Place};
use crate::camera::scale::as_seen;
use crate::camera::scale::perspective::{Perspective, error_if_ignored_m};

impl Setup {
    /// The values of a width: its edges' tangents where the distance is known.
    pub(super) fn round(&self, picture: &Picture, found: &Diameter) -> Result<Reading, String> {
        let centre = self.lens.map_or_else(
            || Place::new(0.5 * (picture.width() as f64 - 1.0), 0.5 * (picture.height() as f64 - 1.0)),
            |lens| lens.centre_px,
        );
        let middle_px = beside(found, centre);
        let value = self.width(middle_px, found.width_px, found.std_px)?;
        let ignored_m = if self.scale.is_some() && self.distance().is_none() {
            let radius = 0.5 * value.value * MM;
            error_if_ignored_m(radius, TYPICAL_RADII * radius, self.offset_m.map_or(0.0, |o| o.0))
        } else {
            None
        };
        let point = |at: &Width| {
            let there = self.width(middle_px, at.width_px, at.std_px)?;
            Ok((self.length(at.along_px, 0.0).value, there))
        };
        let points = found.profile.iter().map(point).collect::<Result<_, String>>()?;
        let tilt = (-found.axis.x).atan2(found.axis.y).to_degrees();
        let span = found.edges[0].iter().chain(&found.edges[1]).map(|(p, _)| (p - found.ends[0]).dot(&found.axis));
        let (from, to) = span.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(v), b.max(v)));
        let unit = if self.scale.is_some() { "mm" } else { "px" };
        let middle = 0.5 * (found.ends[0] + found.ends[1]);
        let seen = |place: Place| as_seen(self.lens.as_ref(), place);
        let marks = Marks {
            edges: found.edges.iter().flatten().map(|(place, used)| (seen(*place), *used)).collect(),
            lines: vec![found.ends.map(seen)],
            axes: vec![[middle + found.axis * from, middle + found.axis * to].map(seen).to_vec()],
            label: format!("{:.3} ± {:.3} {unit}", value.value, 1.96 * value.std),
        };
        let values = vec![
            value,
            Value { value: tilt, std: found.axis_std_rad.to_degrees() },
            Value { value: found.blur_px, std: f64::NAN },
        ];
        let profile = Some(Profile { name: ("width", unit), along_unit: unit, points });
        Ok(Reading {
            values,
            profile,
            notes: found.flags.iter().map(ToString::to_string).collect(),
            marks,
            ignored_m,
            srgb_px: srgb_px(found.levels, found.blur_px),
        })
    }

    /// A width in px about a place that lies so far from the principal point, across the axis: in mm where there is a scale, by the tangents
    /// of a round body where the distance is known.
    fn width(&self, middle_px: f64, width_px: f64, std_px: f64) -> Result<Value, String> {
        let (Some(scale), Some(distance)) = (self.scale, self.distance()) else {
            return Ok(self.scale.map_or(Value { value: width_px, std: std_px }, |scale| {
                let length = scale.length(width_px, std_px);
                Value { value: length.metre / MM, std: length.std / MM }
            }));
        };
        let (offset_m, offset_std_m) = self.offset_m.unwrap_or((0.0, 0.0));
        let perspective =
            Perspective { distance_m: distance.metre, distance_std_m: distance.std, offset_m, offset_std_m, scale };
        let edges = [middle_px - 0.5 * width_px, middle_px + 0.5 * width_px];
        let std = std_px / std::f64::consts::SQRT_2;
        let round = perspective.cylinder(edges, [std; 2]).map_err(|why| why.to_string())?;
        Ok(Value { value: 2.0 * round.radius_m / MM, std: 2.0 * round.std_m / MM })
    }
}

/// How far the middle of the width lies from the principal point across the axis, in px.
fn beside(found: &Diameter, centre: Place) -> f64 {
    let line: Vector2<f64> = found.ends[1] - found.ends[0];
    (0.5 * (found.ends[0] + found.ends[1]) - centre).dot(&line) / line.norm()
}
