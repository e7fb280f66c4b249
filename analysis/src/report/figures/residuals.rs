//! Predicted minus measured, against the bound.

use pneuval_ingest::units::Unit;

use super::{Group, empty, unit_name, used_point};
use crate::format;
use crate::gate::{limit_text, metric_text};
use crate::metrics::Metric;
use crate::report::chart::{Chart, Ink, Key, Layer, Shape};
use crate::report::group::measurement_title;
use crate::results::{Comparison, Point, PointStatus};

/// Where the column of values ends in a figure of residuals by form, in half axes.
const VALUES_TO: f64 = 1.43;

impl Group<'_> {
    pub(super) fn residuals(&self) -> (Chart, String) {
        let many = self.by_points().any(|(_, c, _)| c.n_used + c.n_without_prediction > 1);
        if many { self.residuals_over_pressure() } else { self.residuals_by_form() }
    }

    /// A bound in terms of the residual of a comparison: its limit on |e|, in the unit shown.
    fn residual_bound(comparison: &Comparison, unit: Unit) -> Option<f64> {
        comparison.judgements.iter().find_map(|j| match j.bound.metric {
            Metric::MaxAbsError => Some(unit.from_si(j.bound.max)),
            Metric::RelativeToPredictedMax => {
                let p = used_point(comparison)?.predicted_scalar()?;
                (comparison.n_used == 1).then(|| unit.from_si(j.bound.max * p.abs()))
            }
            Metric::RelativeToMeasuredMax => {
                let m = used_point(comparison)?.measured_scalar()?;
                (comparison.n_used == 1).then(|| unit.from_si(j.bound.max * m.abs()))
            }
            _ => None,
        })
    }

    /// Half the residual axis: the widest bound, and every residual up to twice as large. What lies beyond is an arrow.
    fn residual_reach(&self, unit: Unit) -> f64 {
        let bound = self.comparisons.iter().filter_map(|c| Self::residual_bound(c, unit)).fold(0.0, f64::max);
        let limit = if bound > 0.0 { 2.0 * bound } else { f64::INFINITY };
        let largest = self
            .comparisons
            .iter()
            .flat_map(|c| c.points.iter())
            .filter(|p| p.status == PointStatus::Used)
            .filter_map(|p| p.residual)
            .map(|r| unit.from_si(r).abs())
            .filter(|r| *r <= limit)
            .fold(bound, f64::max);
        if largest > 0.0 { 1.3 * largest.min(1e300) } else { 1.0 }
    }

    fn residuals_over_pressure(&self) -> (Chart, String) {
        let (Some(first), Some(unit)) = (self.by_points().next().map(|(_, c, _)| c), self.unit()) else {
            return (empty(), String::new());
        };
        let (x_title, full) = self.pressure_axis();
        let position = self.is_position();
        let reach = self.residual_reach(unit);
        let x = self.pressure_range(full, 0.08);
        let mut layers = Vec::new();
        let mut legend = Vec::new();
        let bounds: Vec<f64> = self.comparisons.iter().filter_map(|c| Self::residual_bound(c, unit)).collect();
        let common = bounds.first().filter(|b| bounds.iter().all(|other| other.to_bits() == b.to_bits()));
        if let Some(bound) = common {
            layers.push(Layer::Band(x.clone(), if position { 0.0 } else { -bound }..*bound));
            let text = format!("bound: |e| at most {}", format::with_unit(&format::short(*bound), unit));
            legend.push(Key { text, ink: Ink::Measured, shape: None, line: None, band: true });
        }
        layers.push(Layer::Reference(vec![(x.start, 0.0), (x.end, 0.0)]));
        let mut front = Vec::new();
        let crowded = self.is_crowded();
        for (i, comparison, _) in self.by_points() {
            let ink = Ink::Form(i);
            let shape = if crowded { Shape::Dot } else { Shape::of_form(i) };
            let points: Vec<(f64, f64, String)> = comparison
                .points
                .iter()
                .filter(|p| p.status == PointStatus::Used)
                .filter_map(|p| p.residual.map(|r| (full * p.pressure_share, r)))
                .map(|(x, r)| (x, unit.from_si(r), format::quantity(r, unit, 1)))
                .collect();
            let line: Vec<(f64, f64)> = points.iter().map(|(x, r, _)| (*x, *r)).collect();
            let published = comparison.kind == "published";
            let text = if points.is_empty() {
                format!("{}: no prediction", comparison.title)
            } else {
                comparison.title.clone()
            };
            legend.push(Key { text, ink, shape: Some(shape), line: Some(published), band: false });
            let target = if published { &mut front } else { &mut layers };
            // Under several conditions neighbouring pressures are no neighbours.
            if line.len() > 1 && !crowded && comparison.conditions.is_empty() {
                target.push(Layer::Line { points: line, ink, dashed: published });
            }
            target.push(Layer::Marks { points, ink, shape });
        }
        layers.append(&mut front);
        let chart = Chart {
            title: format!("{}: residual over pressure", measurement_title(first)),
            x_title,
            y_title: if position {
                format!("Distance of predicted from measured / {}", unit_name(unit))
            } else {
                format!("Predicted − measured / {}", unit_name(unit))
            },
            x,
            x_labelled_to: None,
            y: if position { -0.04 * reach..reach } else { -reach..reach },
            rows: vec![],
            layers,
            legend,
        };
        let what = if position {
            "how far the predicted point lies from the measured one"
        } else {
            "predicted minus measured, positive where the model is too high"
        };
        let against = if bounds.is_empty() { "" } else { ", against the bound on the largest error" };
        let caption = format!(
            "{}: {what}{against}. Arrows mark residuals beyond the axis, with their value.",
            first.quantity.title
        );
        (chart, caption)
    }

    fn residuals_by_form(&self) -> (Chart, String) {
        let (Some(first), Some(unit)) = (self.by_points().next().map(|(_, c, _)| c), self.unit()) else {
            return (empty(), String::new());
        };
        let reach = self.residual_reach(unit);
        let forms: Vec<&Comparison> = self.by_points().map(|(_, c, _)| c).collect();
        let n = forms.len() as f64;
        let mut layers = Vec::new();
        for (i, comparison) in forms.iter().enumerate() {
            let top = n - i as f64;
            if let Some(bound) = Self::residual_bound(comparison, unit) {
                layers.push(Layer::Band(-bound..bound, top - 0.94..top - 0.06));
            }
        }
        layers.push(Layer::Reference(vec![(0.0, 0.0), (0.0, n)]));
        for (i, comparison) in forms.iter().enumerate() {
            let middle = n - i as f64 - 0.5;
            let residual = comparison.points.iter().filter(|p| p.status == PointStatus::Used).find_map(|p| p.residual);
            let text = match residual {
                Some(r) => {
                    // To the right the values stand, so a residual beyond the axis is marked at its end; to the left the chart
                    // draws an arrow itself.
                    let r_shown = unit.from_si(r);
                    let (x, shape) =
                        if r_shown > reach { (reach, Shape::Beyond) } else { (r_shown, Shape::of_form(i)) };
                    let points = vec![(x, middle, String::new())];
                    layers.push(Layer::Marks { points, ink: Ink::Form(i), shape });
                    metric_text(Metric::Bias, r, unit)
                }
                None => "no prediction".to_owned(),
            };
            // Values stand in a column of their own, to the right of where a mark can be.
            layers.push(Layer::Words { at: (VALUES_TO * reach, middle), text, muted: residual.is_none() });
        }
        let bound_text = forms.iter().find_map(|c| c.deciding()).map_or("bound".to_owned(), |j| {
            format!("bound: {} at most {}", j.bound.metric.title(), limit_text(j.bound.metric, j.bound.max, unit))
        });
        let legend = vec![Key { text: bound_text, ink: Ink::Measured, shape: None, line: None, band: true }];
        let asked = first.points.iter().find(|p| p.status != PointStatus::ZeroReference && p.measured.is_some());
        let pressure = asked.map(|p| format::pressures(&p.pressures_gauge_pa, &first.chambers));
        let measured = asked.and_then(Point::measured_scalar).map(|m| format::quantity(m, unit, 0));
        let (measured, pressure) = (measured.unwrap_or_default(), pressure.unwrap_or_default());
        let chart = Chart {
            title: format!("{}: residual at {pressure}", measurement_title(first)),
            x_title: format!("Predicted − measured / {}", unit_name(unit)),
            y_title: String::new(),
            x: -reach..(VALUES_TO + 0.02) * reach,
            x_labelled_to: Some(reach),
            y: 0.0..n,
            rows: forms.iter().map(|c| c.title.clone()).collect(),
            layers,
            legend,
        };
        let caption = format!(
            "{}: predicted minus the {measured} measured at {pressure}, against each form's bound. Arrows mark residuals beyond the axis.",
            first.quantity.title
        );
        (chart, caption)
    }
}
