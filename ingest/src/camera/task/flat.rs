//! What lies in one plane parallel to the picture: a bent finger, an imprint.

use nalgebra::Vector2;

use super::{Bending, EdgeUse, Imprint, MM, Marks, Profile, Reading, Sense, Setup, Value, srgb_px};
use crate::camera::bending::direction;
use crate::camera::scale::Scale;

/// Beyond so many lengths of the finger its bend has no radius worth a number.
const STRAIGHT_LENGTHS: f64 = 1000.0;

impl Setup {
    /// The scale in the plane of what is measured, which lies by the offset behind that of the scale.
    fn plane(&self) -> Option<Scale> {
        let scale = self.scale?;
        let (Some((offset, offset_std)), Some(distance)) = (self.offset_m, self.distance()) else { return Some(scale) };
        let before = distance.metre - offset;
        let factor = distance.metre / before;
        // d ln(Z/(Z - h)): by h, and by Z.
        let of_offset = offset_std / before;
        let of_distance = distance.std * (1.0 / distance.metre - 1.0 / before);
        let metre_per_px = scale.metre_per_px * factor;
        let std = metre_per_px * (scale.std / scale.metre_per_px).hypot(of_offset).hypot(of_distance);
        Some(Scale { metre_per_px, std })
    }

    /// A length in px, with its standard uncertainty, in mm where there is a scale.
    pub(super) fn length(&self, px: f64, std_px: f64) -> Value {
        self.plane().map_or(Value { value: px, std: std_px }, |scale| {
            let length = scale.length(px, std_px);
            Value { value: length.metre / MM, std: length.std / MM }
        })
    }

    /// The values of a bent finger. The tip counts from the root, along the heading (or the axis of the picture that is nearest to it) and
    /// across, to the side to which a positive angle bends.
    pub(super) fn bent(&self, found: &Bending, sense: Sense) -> Reading {
        let sign = match sense {
            Sense::Clockwise => 1.0,
            Sense::Counterclockwise => -1.0,
        };
        let quarter = std::f64::consts::FRAC_PI_2;
        let heading = found.named_heading_rad.unwrap_or_else(|| (found.heading_rad / quarter).round() * quarter);
        let along = direction(heading);
        let across = Vector2::new(-along.y, along.x) * sign;
        let apart = found.tip - found.root;
        // Along the finger's end and across it, as seen along the root.
        let turned = found.heading_rad + found.angle_rad - heading;
        let [of_end, beside] = found.tip_std_px;
        let std_along = (of_end * turned.cos()).hypot(beside * turned.sin()).hypot(found.root_std_px);
        let std_across = (of_end * turned.sin()).hypot(beside * turned.cos());
        let (length, length_std) = found.length_px;
        let bend = found.arc.per_px;
        let radius = if bend.abs() * length * STRAIGHT_LENGTHS > 1.0 { 1.0 / bend.abs() } else { f64::NAN };
        let unit = if self.scale.is_some() { "mm" } else { "px" };
        let angle = Value { value: sign * found.angle_rad.to_degrees(), std: found.angle_std_rad.to_degrees() };
        let (tip_along, tip_across) =
            (self.length(apart.dot(&along), std_along), self.length(apart.dot(&across), std_across));
        let marks = Marks {
            edges: found.edges.clone(),
            lines: vec![],
            axes: vec![found.centreline.clone()],
            label: format!(
                "{:.2} ± {:.2}°, tip {:.2}, {:.2} {unit}",
                angle.value,
                1.96 * angle.std,
                tip_along.value,
                tip_across.value
            ),
        };
        let mm_per_px = self.plane().map_or(1.0, |scale| scale.metre_per_px / MM);
        let points = found.curvature.iter().map(|at| {
            let value = Value { value: sign * at.per_px / mm_per_px, std: at.std_per_px / mm_per_px };
            (at.along_px * mm_per_px, value)
        });
        let per = if self.scale.is_some() { "1/mm" } else { "1/px" };
        let profile = Some(Profile { name: ("curvature", per), along_unit: unit, points: points.collect() });
        let mut values = vec![
            angle,
            tip_along,
            tip_across,
            self.length(length, length_std.hypot(found.root_std_px)),
            self.length(radius, radius * radius * found.arc.std_per_px),
            Value { std: f64::NAN, ..self.length(found.arc.rms_px, 0.0) },
        ];
        // Markers have none.
        if found.blur_px.is_finite() {
            values.push(Value { value: found.blur_px, std: f64::NAN });
        }
        Reading {
            values,
            profile,
            notes: found.flags.iter().map(ToString::to_string).collect(),
            marks,
            ignored_m: None,
            srgb_px: srgb_px(found.levels, found.blur_px),
        }
    }

    /// The values of an imprint.
    pub(super) fn imprint(&self, found: &Imprint) -> Result<Reading, String> {
        let square = |px2: f64, std_px2: f64| {
            self.plane().map_or(Value { value: px2, std: std_px2 }, |scale| {
                let (side, share) = (scale.metre_per_px / MM, scale.std / scale.metre_per_px);
                // Both sides of a square are off together.
                Value { value: px2 * side * side, std: side * side * std_px2.hypot(2.0 * share * px2) }
            })
        };
        let area = square(found.area_px2, found.std_px2);
        if !area.value.is_finite() {
            return Err(
                "the lens is not known there: its model folds; calibrate with corners near the border".to_owned()
            );
        }
        let unit = if self.scale.is_some() { "mm²" } else { "px²" };
        let marks = Marks {
            edges: found.outline.iter().map(|place| (*place, EdgeUse::Used)).collect(),
            label: format!("{:.2} ± {:.2} {unit}", area.value, 1.96 * area.std),
            ..Marks::default()
        };
        // Of the colour in which paper and paint differ most.
        let levels = (0..3).map(|c| (found.colours[0][c], found.colours[1][c]));
        let most = levels.max_by(|a, b| (a.0 - a.1).abs().total_cmp(&(b.0 - b.1).abs())).unwrap_or_default();
        let srgb_px = srgb_px(most, found.blur_px);
        let values = vec![
            area,
            Value { std: f64::NAN, ..square(found.holes.0, 0.0) },
            Value { std: f64::NAN, ..self.length(found.rim_px, 0.0) },
            Value { value: found.blur_px, std: f64::NAN },
        ];
        Ok(Reading {
            values,
            profile: None,
            notes: found.notes.iter().map(ToString::to_string).collect(),
            marks,
            ignored_m: None,
            srgb_px,
        })
    }
}
