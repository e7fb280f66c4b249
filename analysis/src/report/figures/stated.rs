//! Errors that a paper states without their data: one row per number, against its bound.

use super::{Group, unit_name};
use crate::metrics::{Measure, Metric};
use crate::report::chart::{Chart, Ground, Ink, Key, Layer, Row, strip};
use crate::report::group::measurement_title;
use crate::report::scene::Shape;
use crate::report::view::stated_text;
use crate::results::MetricRecord;

/// A stated number: its row, value and bound in the unit shown, and its form.
struct Stated {
    row: Row,
    value: f64,
    bound: Option<f64>,
    form: usize,
}

impl Group<'_> {
    /// The figure of stated errors; `None` if there are none in the quantity's unit.
    pub(super) fn stated(&self) -> Option<(Chart, String)> {
        let first = *self.comparisons.iter().find(|c| c.metrics_printed)?;
        let unit = self.unit()?;
        let mut all = Vec::new();
        for (form, c) in self.comparisons.iter().enumerate().filter(|(_, c)| c.metrics_printed) {
            for metric in Metric::ALL.into_iter().filter(|m| !m.is_ratio()) {
                let Some(Measure::Known(value)) = c.metric(metric).map(MetricRecord::measure) else { continue };
                let bound = c.judgements.iter().find(|j| j.bound.metric == metric).map(|j| unit.from_si(j.bound.max));
                all.push(Stated {
                    row: Row {
                        name: format!("{}: {}", c.title, metric.title()),
                        value: stated_text(metric, value.value, Some(value.upper), unit),
                        is_muted: false,
                    },
                    value: unit.from_si(value.value),
                    bound,
                    form,
                });
            }
        }
        let largest = all.iter().map(|r| r.value.abs().max(r.bound.unwrap_or(0.0))).fold(0.0, f64::max);
        if all.is_empty() || largest <= 0.0 {
            return None;
        }
        let (reach, n) = (1.15 * largest, all.len());
        let mut layers = Vec::new();
        for (i, bound) in all.iter().enumerate().filter_map(|(i, stated)| Some((i, stated.bound?))) {
            layers.push(Layer::Band { x: 0.0..bound, y: strip(n, i), ground: Ground::Bound });
        }
        layers.push(Layer::Reference(vec![(0.0, 0.0), (0.0, n as f64)]));
        for (i, stated) in all.iter().enumerate() {
            let strip = strip(n, i);
            let points = vec![(stated.value.abs(), 0.5 * (strip.start + strip.end), String::new())];
            layers.push(Layer::Marks { points, ink: Ink::Form(stated.form), shape: Shape::of_form(stated.form) });
        }
        let any_bound = all.iter().any(|stated| stated.bound.is_some());
        let chart = Chart {
            title: format!("{}: errors as stated", measurement_title(first)),
            x_title: format!("Stated error / {}", unit_name(unit)),
            x: -0.02 * reach..1.02 * reach,
            y: 0.0..n as f64,
            rows: all.into_iter().map(|stated| stated.row).collect(),
            layers,
            legend: if any_bound { vec![Key::band("within its bound", Ground::Bound)] } else { vec![] },
            ..Chart::default()
        };
        let caption = format!(
            "{}: errors that the paper states without the data behind them, so nobody can compute them again.",
            first.quantity.title
        );
        Some((chart, caption))
    }
}
