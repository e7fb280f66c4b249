//! The measured quantity over pressure, with every form; a position as a path in its plane.

use pneuval_ingest::manifest::HoldOut;
use pneuval_ingest::units::Unit;

use super::{Group, axis, empty, spread};
use crate::format;
use crate::prediction::SETS_MAX;
use crate::report::chart::{Chart, Ink, Key, Layer, Shape};
use crate::report::group::measurement_title;
use crate::results::{Comparison, Point};
use crate::series::Curve;
use crate::verdict::Basis;

/// Room above and below the measurement, in measured spans, in which predictions are still shown.
const ABOVE: f64 = 0.5;
const BELOW: f64 = 0.25;

impl Group<'_> {
    /// The response figures: the end of the name, and the figure. One; under conditions, one per form that predicts anything.
    pub(super) fn responses(&self) -> Vec<(String, (Chart, String))> {
        let Some((_, first, _)) = self.by_points().next() else { return vec![] };
        if first.quantity.is_position() {
            return self.path().into_iter().map(|figure| (String::new(), figure)).collect();
        }
        let mut sets: Vec<&[f64]> = first.points.iter().map(|p| p.conditions_si.as_slice()).collect();
        sets.sort_by(|a, b| a.partial_cmp(b).unwrap_or(std::cmp::Ordering::Equal));
        sets.dedup();
        if first.conditions.is_empty() || sets.len() > SETS_MAX {
            return vec![(String::new(), self.response())];
        }
        let predicts = |c: &&Comparison| c.points.iter().any(|p| p.predicted.is_some());
        let forms: Vec<(&Comparison, Option<&Curve>)> =
            self.by_points().map(|(_, c, curve)| (c, curve)).filter(|(c, _)| predicts(c)).collect();
        forms.iter().map(|(c, curve)| (format!("_{}", c.form), self.by_condition(c, *curve))).collect()
    }

    /// What stands under a figure of measured values.
    fn bars_told(&self) -> &'static str {
        match self.comparisons.first().map(|c| c.basis) {
            Some(Basis::Session) => "Bars: the interval of a measured value, where repeats or instruments give one.",
            _ => "No error bars: no measurement uncertainty is published.",
        }
    }

    /// What lines are that join predictions of different fits; nothing where there are none.
    fn joined_fits_told(&self) -> String {
        let titles: Vec<&str> =
            self.by_points().filter(|(_, c, _)| each_by_others(c)).map(|(_, c, _)| c.title.as_str()).collect();
        if titles.is_empty() {
            return String::new();
        }
        format!(
            "{}: each pressure is predicted by a fit to the others, so the line joins different fits. ",
            titles.join("; ")
        )
    }

    /// The intervals of measured values of a session.
    fn bars(&self, unit: Unit, full: f64, ink: impl Fn(&Point) -> Ink) -> Vec<Layer> {
        if self.comparisons.first().is_none_or(|c| c.basis != Basis::Session) {
            return vec![];
        }
        let span = |p: &Point| {
            let (value, half) = (p.measured_scalar()?, *p.measured_half_width.as_ref()?.first()?);
            let x = full * p.pressure_share;
            let ends = (unit.from_si(value - half), unit.from_si(value + half));
            (half > 0.0).then(|| Layer::Bars { spans: vec![(x, ends.0, ends.1)], ink: ink(p) })
        };
        self.points().iter().filter_map(span).collect()
    }

    fn response(&self) -> (Chart, String) {
        let (Some((_, first, _)), Some(unit)) = (self.by_points().next(), self.unit()) else {
            return (empty(), String::new());
        };
        let (x_title, full) = self.pressure_axis();
        let measured = self.measured(unit);
        let values = self.by_points().filter_map(|(_, _, curve)| curve).flat_map(|c| &c.traces);
        let values: Vec<f64> =
            values.flat_map(|t| &t.points).flat_map(|p| &p.values).map(|v| unit.from_si(*v)).collect();
        let y = value_range(&measured, &values);
        // Printed columns in front: dashes over a line stay visible, a line over dashes hides them.
        let (mut layers, mut front) = (Vec::new(), Vec::new());
        let crowded = self.is_crowded();
        let disc = if crowded { Shape::Dot } else { Shape::Disc };
        let mut legend =
            vec![Key { text: "measured".into(), ink: Ink::Measured, shape: Some(disc), line: None, band: false }];
        for (i, comparison, curve) in self.by_points() {
            let (ink, shape) = (Ink::Form(i), Shape::of_form(i));
            let published = comparison.kind == "published";
            // Under conditions, which change from point to point, nothing lies between the points.
            let line: Vec<(f64, f64)> = curve
                .iter()
                .filter(|_| comparison.conditions.is_empty())
                .flat_map(|c| &c.traces)
                .flat_map(|t| &t.points)
                .filter_map(|p| p.values.first().map(|v| (full * p.share, unit.from_si(*v))))
                .collect();
            let points: Vec<(f64, f64, String)> = comparison
                .points
                .iter()
                .filter_map(|p| p.predicted_scalar().map(|v| (full * p.pressure_share, v)))
                .map(|(x, v)| (x, unit.from_si(v), format::quantity(v, unit, 1)))
                .collect();
            if comparison.kind == "none" {
                continue;
            }
            let shape = (!crowded).then_some(shape);
            legend.push(Key {
                text: legend_text(comparison, points.is_empty()),
                ink,
                shape,
                line: Some(published),
                band: false,
            });
            let target = if published { &mut front } else { &mut layers };
            if line.len() > 1 {
                target.push(Layer::Line { points: line, ink, dashed: published });
            }
            if let Some(shape) = shape {
                target.push(Layer::Marks { points, ink, shape });
            }
        }
        layers.append(&mut front);
        layers.extend(self.bars(unit, full, |_| Ink::Measured));
        let points = measured.iter().map(|(share, v)| (full * share, *v, String::new())).collect();
        let marks = Layer::Marks { points, ink: Ink::Measured, shape: disc };
        if crowded {
            // A cloud of measured points must not hide the lines.
            layers.insert(0, marks);
        } else {
            layers.push(marks);
        }
        let title = format!("{} over pressure", measurement_title(first));
        let caption = format!(
            "{}: measured, and every form. Arrows mark predictions beyond the axis. {}{}",
            first.quantity.title,
            self.joined_fits_told(),
            self.bars_told()
        );
        let chart = Chart {
            title,
            x_title,
            y_title: axis(&first.quantity.title, unit),
            x: self.pressure_range(full, 0.04),
            x_labelled_to: None,
            y,
            rows: vec![],
            layers,
            legend,
        };
        (chart, caption)
    }

    /// One form under several conditions: a colour per set of conditions, marks measured, lines predicted.
    fn by_condition(&self, comparison: &Comparison, curve: Option<&Curve>) -> (Chart, String) {
        let unit = comparison.quantity.unit();
        let (x_title, full) = self.pressure_axis();
        let mut sets: Vec<&[f64]> = Vec::new();
        for point in &comparison.points {
            if !sets.contains(&point.conditions_si.as_slice()) {
                sets.push(&point.conditions_si);
            }
        }
        let traces = curve.map(|c| c.traces.as_slice()).unwrap_or_default();
        let values: Vec<f64> =
            traces.iter().flat_map(|t| &t.points).flat_map(|p| &p.values).map(|v| unit.from_si(*v)).collect();
        let measured = self.measured(unit);
        let y = value_range(&measured, &values);
        let (mut layers, mut front, mut legend) = (Vec::new(), Vec::new(), Vec::new());
        let any_measured = !measured.is_empty();
        let one_pressure = comparison.points.windows(2).all(|p| p[0].pressures_gauge_pa == p[1].pressures_gauge_pa);
        for (i, set) in sets.iter().enumerate() {
            let ink = Ink::Form(i);
            let here = || comparison.points.iter().filter(|p| p.conditions_si == *set);
            let mark = |x: f64, v: f64| (full * x, unit.from_si(v), format::quantity(v, unit, 1));
            let line: Vec<(f64, f64)> = traces
                .get(i)
                .into_iter()
                .flat_map(|t| &t.points)
                .filter_map(|p| p.values.first().map(|v| (full * p.share, unit.from_si(*v))))
                .collect();
            // Through one pressure a constant line would show a dependence that is neither computed nor measured.
            let constant = line.windows(2).all(|pair| pair[0].1.to_bits() == pair[1].1.to_bits());
            if line.len() > 1 && !(one_pressure && constant) {
                layers.push(Layer::Line { points: line, ink, dashed: false });
            } else {
                for (x, v, _) in here().filter_map(|p| p.predicted_scalar().map(|v| mark(p.pressure_share, v))) {
                    let dash = vec![(x - 0.025 * full, v), (x + 0.025 * full, v)];
                    layers.push(Layer::Line { points: dash, ink, dashed: false });
                }
            }
            let points = here().filter_map(|p| p.measured_scalar().map(|m| mark(p.pressure_share, m))).collect();
            let shape = Shape::of_form(i);
            front.push(Layer::Marks { points, ink, shape });
            let words: Vec<String> = comparison.conditions.iter().zip(*set).map(|(c, v)| c.text(*v)).collect();
            let shape = any_measured.then_some(shape);
            legend.push(Key { text: words.join(", "), ink, shape, line: Some(false), band: false });
        }
        layers.extend(self.bars(unit, full, |p| {
            Ink::Form(sets.iter().position(|set| *set == p.conditions_si.as_slice()).unwrap_or(0))
        }));
        layers.append(&mut front);
        let marks = if any_measured { "Marks: measured. " } else { "" };
        let caption = format!(
            "{}, {}. {marks}Lines: predicted (a dash where there is one pressure only{}). {}",
            comparison.quantity.title,
            comparison.title,
            if each_by_others(comparison) {
                "; each pressure by a fit to the others: lines join different fits"
            } else {
                ""
            },
            self.bars_told()
        );
        let chart = Chart {
            title: format!("{} over pressure: {}", measurement_title(comparison), comparison.title),
            x_title,
            y_title: axis(&comparison.quantity.title, unit),
            x: self.pressure_range(full, 0.04),
            x_labelled_to: None,
            y,
            rows: vec![],
            layers,
            legend,
        };
        (chart, caption)
    }

    /// A position in the plane of its first two components: the measured path and every form's.
    fn path(&self) -> Option<(Chart, String)> {
        let (_, first, _) = self.by_points().next()?;
        let unit = self.unit()?;
        let [a, b, rest @ ..] = first.quantity.components.as_slice() else { return None };
        let at = |values: &[f64]| Some((unit.from_si(*values.first()?), unit.from_si(*values.get(1)?)));
        let measured: Vec<(f64, f64)> =
            first.points.iter().filter_map(|p| p.measured.as_deref().and_then(at)).collect();
        let (mut layers, mut all) = (Vec::new(), measured.clone());
        let crowded = self.is_crowded();
        let disc = if crowded { Shape::Dot } else { Shape::Disc };
        let mut legend =
            vec![Key { text: "measured".into(), ink: Ink::Measured, shape: Some(disc), line: None, band: false }];
        for (i, comparison, curve) in self.by_points().filter(|(_, c, _)| c.kind != "none") {
            let (ink, shape) = (Ink::Form(i), Shape::of_form(i));
            let published = comparison.kind == "published";
            let points: Vec<(f64, f64)> =
                comparison.points.iter().filter_map(|p| p.predicted.as_deref().and_then(at)).collect();
            let text = legend_text(comparison, points.is_empty());
            legend.push(Key { text, ink, shape: Some(shape), line: Some(published), band: false });
            // Under conditions, which change from point to point, the path is the one through the points.
            let lines: Vec<Vec<(f64, f64)>> = if comparison.conditions.is_empty() {
                let traces = curve.iter().flat_map(|c| &c.traces);
                traces.map(|trace| trace.points.iter().filter_map(|p| at(&p.values)).collect()).collect()
            } else {
                vec![points.clone()]
            };
            for line in lines.into_iter().filter(|line| line.len() > 1) {
                layers.push(Layer::Line { points: line, ink, dashed: published });
            }
            if !crowded {
                let marks = points.iter().map(|(x, y)| (*x, *y, String::new())).collect();
                layers.push(Layer::Marks { points: marks, ink, shape });
            }
            all.extend(points);
        }
        let points = measured.iter().map(|(x, y)| (*x, *y, String::new())).collect();
        layers.push(Layer::Marks { points, ink: Ink::Measured, shape: disc });
        let more = if rest.is_empty() { String::new() } else { format!("; {} is not shown", rest.join(", ")) };
        let chart = Chart {
            title: format!("{}: path", measurement_title(first)),
            x_title: axis(a, unit),
            y_title: axis(b, unit),
            x: spread(all.iter().map(|p| p.0), 0.08),
            x_labelled_to: None,
            y: spread(all.iter().map(|p| p.1), 0.08),
            rows: vec![],
            layers,
            legend,
        };
        let caption = format!(
            "{}: {b} over {a}, measured and predicted as the pressure rises{more}. {}The axes have different scales.",
            first.quantity.title,
            self.joined_fits_told()
        );
        Some((chart, caption))
    }
}

/// Whether each pressure's prediction comes from a fit to the other pressures.
fn each_by_others(comparison: &Comparison) -> bool {
    let held_out = comparison.fit.as_ref().and_then(|fit| fit.hold_out.as_deref());
    held_out.is_some() && held_out == HoldOut::OnePressure.label()
}

/// The vertical range: every measured value, and predictions that are not far from them. Where nothing is measured, the
/// predictions alone.
fn value_range(measured: &[(f64, f64)], predicted: &[f64]) -> std::ops::Range<f64> {
    let (low, high) = measured.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), (_, v)| (a.min(*v), b.max(*v)));
    if low > high {
        return spread(predicted.iter().copied().chain([0.0]), 0.06);
    }
    // Predictions may leave the axes; half the measured range above the measurement keeps it readable.
    let floor = if measured.len() < 2 { 0.0_f64.min(low) } else { low };
    let span = (high - floor).abs().max(f64::MIN_POSITIVE);
    let limits = floor - BELOW * span..high + ABOVE * span;
    spread(predicted.iter().copied().filter(|v| limits.contains(v)).chain([floor, high]), 0.06)
}

fn legend_text(comparison: &Comparison, no_prediction: bool) -> String {
    match (no_prediction, comparison.n_without_prediction) {
        (true, _) => format!("{}: no prediction", comparison.title),
        (false, 0) => comparison.title.clone(),
        (false, 1) => format!("{}: no prediction at 1 point", comparison.title),
        (false, missing) => format!("{}: no prediction at {missing} points", comparison.title),
    }
}
