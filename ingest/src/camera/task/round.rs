//! The diameter of a round body, seen from near.

use nalgebra::Vector2;

use super::{MM, Marks, Reading, Setup, TYPICAL_RADII, Value};
use crate::camera::diameter::Diameter;
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
                let (edges, stds) = across(found, centre);
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
            axes: vec![[middle + found.axis * from, middle + found.axis * to].map(seen).to_vec()],
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
