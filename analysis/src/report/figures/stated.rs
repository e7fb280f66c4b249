//! Errors that a paper states without their data: one row per number, against its bound.

use super::{Group, unit_name};
use crate::metrics::{Measure, Metric};
use crate::report::chart::{Chart, Ink, Key, Layer, Shape};
use crate::report::group::measurement_title;
use crate::report::view::stated_text;
use crate::results::MetricRecord;

/// Where the column of values ends, in axes.
const VALUES_TO: f64 = 1.3;

/// A stated number: its name, value, bound, all in the unit shown.
struct Row {
    name: String,
    value: f64,
    text: String,
    bound: Option<f64>,
    form: usize,
}

impl Group<'_> {
    /// The figure of stated errors; `None` if there are none in the quantity's unit.
    pub(super) fn stated(&self) -> Option<(Chart, String)> {
        let first = *self.comparisons.iter().find(|c| c.metrics_printed)?;
        let unit = self.unit()?;
        let mut rows = Vec::new();
        for (form, c) in self.comparisons.iter().enumerate().filter(|(_, c)| c.metrics_printed) {
            for metric in Metric::ALL.into_iter().filter(|m| !m.is_ratio()) {
                let Some(Measure::Known(value)) = c.metric(metric).map(MetricRecord::measure) else { continue };
                let bound = c.judgements.iter().find(|j| j.bound.metric == metric).map(|j| unit.from_si(j.bound.max));
                rows.push(Row {
                    name: format!("{}: {}", c.title, metric.title()),
                    value: unit.from_si(value.value),
                    text: stated_text(metric, value.value, Some(value.upper), unit),
                    bound,
                    form,
                });
            }
        }
        let largest = rows.iter().map(|r| r.value.abs().max(r.bound.unwrap_or(0.0))).fold(0.0, f64::max);
        if rows.is_empty() || largest <= 0.0 {
            return None;
        }
        let (reach, n) = (1.15 * largest, rows.len() as f64);
        let mut layers = Vec::new();
        let middle = |i: usize| n - i as f64 - 0.5;
        for (i, row) in rows.iter().enumerate() {
            if let Some(bound) = row.bound {
                layers.push(Layer::Band(0.0..bound, middle(i) - 0.44..middle(i) + 0.44));
            }
        }
        layers.push(Layer::Reference(vec![(0.0, 0.0), (0.0, n)]));
        for (i, row) in rows.iter().enumerate() {
            let points = vec![(row.value.abs(), middle(i), String::new())];
            layers.push(Layer::Marks { points, ink: Ink::Form(row.form), shape: Shape::of_form(row.form) });
            layers.push(Layer::Words { at: (VALUES_TO * reach, middle(i)), text: row.text.clone(), muted: false });
        }
        let band = rows.iter().any(|r| r.bound.is_some());
        let key = Key { text: "within its bound".into(), ink: Ink::Measured, shape: None, line: None, band: true };
        let chart = Chart {
            title: format!("{}: errors as stated", measurement_title(first)),
            x_title: format!("Stated error / {}", unit_name(unit)),
            y_title: String::new(),
            x: -0.02 * reach..(VALUES_TO + 0.02) * reach,
            x_labelled_to: Some(reach),
            y: 0.0..n,
            rows: rows.into_iter().map(|r| r.name).collect(),
            layers,
            legend: if band { vec![key] } else { vec![] },
        };
        let caption = format!(
            "{}: errors that the paper states without the data behind them, so nobody can compute them again.",
            first.quantity.title
        );
        Some((chart, caption))
    }
}
