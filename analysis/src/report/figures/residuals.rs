//! Predicted minus measured, against the bound.

use pneuval_ingest::units::Unit;

use super::readings::{self, Said};
use super::{Group, unit_name, used_point};
use crate::format;
use crate::gate::{limit_text, metric_text};
use crate::metrics::Metric;
use crate::report::chart::{Chart, Ground, Ink, Key, Layer, Reading, Row, strip};
use crate::report::group::measurement_title;
use crate::report::scene::Shape;
use crate::results::{Comparison, Point, PointStatus};
use crate::verdict::Basis;

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

    /// Half the residual axis: the widest bound, and every residual up to twice as large or three times as large as three quarters of
    /// them are. What lies beyond is an arrow.
    fn residual_reach(&self, unit: Unit) -> f64 {
        let bound = self.comparisons.iter().filter_map(|c| Self::residual_bound(c, unit)).fold(0.0, f64::max);
        let used = self.comparisons.iter().flat_map(|c| &c.points).filter(|p| p.status == PointStatus::Used);
        let mut sizes: Vec<f64> = used.filter_map(|p| p.residual).map(|r| unit.from_si(r).abs()).collect();
        sizes.sort_by(f64::total_cmp);
        let most = sizes.get(sizes.len().saturating_sub(1) * 3 / 4).copied().unwrap_or(0.0);
        let limit = if bound > 0.0 { (2.0 * bound).max(3.0 * most) } else { f64::INFINITY };
        let largest = sizes.into_iter().filter(|size| *size <= limit).fold(bound, f64::max);
        if largest > 0.0 { 1.3 * largest.min(1e300) } else { 1.0 }
    }

    fn residuals_over_pressure(&self) -> (Chart, String) {
        let (Some(first), Some(unit)) = (self.by_points().next().map(|(_, c, _)| c), self.unit()) else {
            return (Chart::default(), String::new());
        };
        let (x_title, full) = self.pressure_axis();
        let position = self.is_position();
        let reach = self.residual_reach(unit);
        let x = self.pressure_range(full, 0.08);
        let x_size = x.end - x.start;
        let mut layers = Vec::new();
        let mut legend = Vec::new();
        let bounds: Vec<f64> = self.comparisons.iter().filter_map(|c| Self::residual_bound(c, unit)).collect();
        let common = bounds.first().filter(|b| bounds.iter().all(|other| other.to_bits() == b.to_bits()));
        if let Some(bound) = common {
            let y = if position { 0.0 } else { -bound }..*bound;
            layers.push(Layer::Band { x: x.clone(), y, ground: Ground::Bound });
            let text = format!("bound: |e| at most {}", format::with_unit(&format::short(*bound), unit));
            legend.push(Key::band(text, Ground::Bound));
        }
        layers.push(Layer::Reference(vec![(x.start, 0.0), (x.end, 0.0)]));
        let mut front = Vec::new();
        let crowded = self.is_crowded();
        let mut has_bars = false;
        let n = self.by_points().count();
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
            legend.push(Key { text, ink, shape: Some(shape), line: Some(published), band: None });
            // Intervals of forms beside one another, or they would hide one another.
            let aside = 0.004 * (x.end - x.start) * (i as f64 - 0.5 * (n as f64 - 1.0));
            let used = || comparison.points.iter().filter(|p| p.status == PointStatus::Used);
            let bars = used().filter_map(|p| {
                let (low, high) = p.residual_lower.zip(p.residual_upper).filter(|(low, high)| low < high)?;
                Some((full * p.pressure_share + aside, unit.from_si(low), unit.from_si(high)))
            });
            let bars: Vec<(f64, f64, f64)> = if crowded { vec![] } else { bars.collect() };
            has_bars |= !bars.is_empty();
            let target = if published { &mut front } else { &mut layers };
            // Under several conditions neighbouring pressures are no neighbours.
            if line.len() > 1 && !crowded && comparison.conditions.is_empty() {
                target.push(Layer::Line { points: line, ink, is_dashed: published });
            }
            target.push(Layer::Bars { spans: bars, ink });
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
            y: if position { -0.04 * reach..reach } else { -reach..reach },
            layers,
            legend,
            readings: self.said_of_residuals(unit, full, x_size),
            ..Chart::default()
        };
        let what = if position {
            "how far the predicted point lies from the measured one"
        } else {
            "predicted minus measured, positive where the model is too high"
        };
        let against = if bounds.is_empty() { "" } else { ", against the bound on the largest error" };
        let bars = match (has_bars, first.basis) {
            (false, _) => "",
            (true, Basis::Session) => " Bars: the 95 % interval of each residual by itself.",
            (true, _) => " Bars: what the printed digits leave open.",
        };
        let caption = format!("{}: {what}{against}.{bars}", first.quantity.title);
        (chart, caption)
    }

    /// Every residual at a pressure, with its interval.
    fn said_of_residuals(&self, unit: Unit, full: f64, x_size: f64) -> Vec<Reading> {
        let forms: Vec<&Comparison> = self.by_points().map(|(_, c, _)| c).collect();
        let said = self.points().iter().enumerate().filter_map(|(i, p)| {
            let of = |c: &&Comparison| {
                let point = c.points.get(i).filter(|p| p.status == PointStatus::Used)?;
                Some((readings::residual(c, point, unit)?, point.residual?.abs()))
            };
            let known: Vec<(String, f64)> = forms.iter().filter_map(of).collect();
            let weight = known.iter().map(|k| k.1).fold(0.0, f64::max);
            let heading = readings::heading(forms.first()?, p);
            let lines = std::iter::once(heading).chain(known.iter().map(|k| k.0.clone())).collect();
            (!known.is_empty()).then_some(Said { at: (full * p.pressure_share, 0.0), lines, weight })
        });
        readings::columns(said.collect(), x_size)
    }

    fn residuals_by_form(&self) -> (Chart, String) {
        let (Some(first), Some(unit)) = (self.by_points().next().map(|(_, c, _)| c), self.unit()) else {
            return (Chart::default(), String::new());
        };
        let reach = self.residual_reach(unit);
        let forms: Vec<&Comparison> = self.by_points().map(|(_, c, _)| c).collect();
        let n = forms.len();
        let (mut layers, mut rows) = (Vec::new(), Vec::new());
        for (i, comparison) in forms.iter().enumerate() {
            if let Some(bound) = Self::residual_bound(comparison, unit) {
                layers.push(Layer::Band { x: -bound..bound, y: strip(n, i), ground: Ground::Bound });
            }
        }
        layers.push(Layer::Reference(vec![(0.0, 0.0), (0.0, n as f64)]));
        for (i, comparison) in forms.iter().enumerate() {
            let middle = 0.5 * (strip(n, i).start + strip(n, i).end);
            let point = comparison.points.iter().find(|p| p.status == PointStatus::Used && p.residual.is_some());
            let residual = point.and_then(|p| p.residual);
            let ends = point.and_then(|p| p.residual_lower.zip(p.residual_upper)).filter(|(low, high)| low < high);
            if let Some((low, high)) = ends {
                let spans = vec![(middle, unit.from_si(low), unit.from_si(high))];
                layers.push(Layer::Spans { spans, ink: Ink::Form(i) });
            }
            let value = residual.map(|r| {
                // The value stands above: an arrow at the end of the axis needs none of its own.
                let points = vec![(unit.from_si(r), middle, String::new())];
                layers.push(Layer::Marks { points, ink: Ink::Form(i), shape: Shape::of_form(i) });
                let text = metric_text(Metric::Bias, r, unit);
                ends.map_or(text.clone(), |(low, high)| {
                    let number = |si: f64| format::fixed(unit.from_si(si), format::error_decimals(unit));
                    format!("{text} ({} to {})", number(low), number(high))
                })
            });
            rows.push(Row {
                name: comparison.title.clone(),
                is_muted: value.is_none(),
                value: value.unwrap_or_else(|| "no prediction".to_owned()),
            });
        }
        let bound_text = forms.iter().find_map(|c| c.deciding()).map_or("bound".to_owned(), |j| {
            format!("bound: {} at most {}", j.bound.metric.title(), limit_text(j.bound.metric, j.bound.max, unit))
        });
        let legend = vec![Key::band(bound_text, Ground::Bound)];
        let asked = first.points.iter().find(|p| p.status != PointStatus::ZeroReference && p.measured.is_some());
        let pressure = asked.map(|p| format::pressures(&p.pressures_gauge_pa, &first.chambers));
        let measured = asked.and_then(Point::measured_scalar).map(|m| format::quantity(m, unit, 0));
        let (measured, pressure) = (measured.unwrap_or_default(), pressure.unwrap_or_default());
        let chart = Chart {
            title: format!("{}: residual at {pressure}", measurement_title(first)),
            x_title: format!("Predicted − measured / {}", unit_name(unit)),
            y_title: String::new(),
            x: -reach..reach,
            y: 0.0..n as f64,
            rows,
            layers,
            legend,
            ..Chart::default()
        };
        let caption = format!(
            "{}: predicted minus the {measured} measured at {pressure}, against each form's bound.",
            first.quantity.title
        );
        (chart, caption)
    }
}
