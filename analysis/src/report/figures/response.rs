//! The measured quantity over pressure, with every form; a position as a path in its plane.

use pneuval_ingest::manifest::HoldOut;
use pneuval_ingest::units::Unit;

use super::readings::{self, Said};
use super::{Group, axis, spread, to_scale};
use crate::format;
use crate::prediction::SETS_MAX;
use crate::report::chart::{Chart, Ink, Key, Layer, Reading};
use crate::report::group::measurement_title;
use crate::report::scene::Shape;
use crate::response::Branch;
use crate::results::{Comparison, Point, PointStatus};
use crate::series::Curve;
use crate::verdict::Basis;

/// Room above and below the measurement, in measured spans, in which predictions are still shown.
const ABOVE: f64 = 0.5;
const BELOW: f64 = 0.25;

/// A path so many times as long as wide would be a line on axes of one scale.
const SLENDER: f64 = 6.0;

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
            return (Chart::default(), String::new());
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
        let has_loop = !crowded && self.has_loop();
        let mut legend = vec![Key::mark(if has_loop { "measured, loading" } else { "measured" }, Ink::Measured, disc)];
        if has_loop {
            legend.push(Key::mark("measured, unloading", Ink::Measured, Shape::Ring));
        }
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
                band: None,
            });
            let target = if published { &mut front } else { &mut layers };
            if line.len() > 1 {
                target.push(Layer::Line { points: line, ink, is_dashed: published });
            }
            if let Some(shape) = shape {
                target.push(Layer::Marks { points, ink, shape });
            }
        }
        layers.append(&mut front);
        layers.extend(self.bars(unit, full, |_| Ink::Measured));
        if has_loop {
            layers.extend(self.loops(unit, full));
        }
        let is_down = |p: &&Point| has_loop && p.branch == Some(Branch::Unloading);
        let mark = |p: &Point| Some((full * p.pressure_share, unit.from_si(p.measured_scalar()?), String::new()));
        let (down, up): (Vec<&Point>, Vec<&Point>) = self.points().iter().partition(is_down);
        let points = down.into_iter().filter_map(mark).collect();
        layers.push(Layer::Marks { points, ink: Ink::Measured, shape: Shape::Ring });
        let points = up.into_iter().filter_map(mark).collect();
        let marks = Layer::Marks { points, ink: Ink::Measured, shape: disc };
        if crowded {
            // A cloud of measured points must not hide the lines.
            layers.insert(0, marks);
        } else {
            layers.push(marks);
        }
        let title = format!("{} over pressure", measurement_title(first));
        let caption = format!(
            "{}: measured, and every form. {}{}",
            first.quantity.title,
            self.joined_fits_told(),
            self.bars_told()
        );
        let chart = Chart {
            title,
            x_title,
            y_title: axis(&first.quantity.title, unit),
            x: self.pressure_range(full, 0.04),
            y,
            layers,
            legend,
            readings: self.said(unit, full, &self.forms()),
            ..Chart::default()
        };
        (chart, caption)
    }

    /// Forms that are compared point by point.
    fn forms(&self) -> Vec<&Comparison> {
        self.by_points().map(|(_, c, _)| c).filter(|c| c.kind != "none").collect()
    }

    /// The measured value and those of some forms at every pressure.
    fn said(&self, unit: Unit, full: f64, forms: &[&Comparison]) -> Vec<Reading> {
        let Some((_, first, _)) = self.by_points().next() else { return vec![] };
        let said = self.points().iter().enumerate().map(|(i, p)| {
            let here = || forms.iter().filter_map(|c| Some((*c, c.points.get(i)?)));
            let head = [readings::heading(first, p), readings::measured(first, p, unit)];
            let weight = here().filter_map(|(_, p)| p.residual).map(f64::abs).fold(0.0, f64::max);
            let lines = head.into_iter().chain(here().map(|(c, p)| readings::predicted(c, p, unit))).collect();
            Said { at: (full * p.pressure_share, 0.0), lines, weight }
        });
        let range = self.pressure_range(full, 0.04);
        readings::columns(said.collect(), range.end - range.start)
    }

    /// Whether the pressure went up and down.
    fn has_loop(&self) -> bool {
        let any = |branch| self.points().iter().any(|p| p.branch == Some(branch) && p.measured.is_some());
        any(Branch::Loading) && any(Branch::Unloading)
    }

    /// The measured loop: a line for each way of the pressure.
    fn loops(&self, unit: Unit, full: f64) -> Vec<Layer> {
        let way = |branch: Branch| {
            let on_it = self.points().iter().filter(|p| p.branch == Some(branch));
            let place = |p: &Point| Some((full * p.pressure_share, unit.from_si(p.measured_scalar()?)));
            let mut points: Vec<(f64, f64)> = on_it.filter_map(place).collect();
            points.sort_by(|a, b| a.0.total_cmp(&b.0));
            points
        };
        let (up, mut down) = (way(Branch::Loading), way(Branch::Unloading));
        // The way down begins where the way up ends.
        down.extend(up.last());
        [up, down].map(|points| Layer::Trail { points, ink: Ink::Measured }).into()
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
                layers.push(Layer::Line { points: line, ink, is_dashed: false });
            } else {
                for (x, v, _) in here().filter_map(|p| p.predicted_scalar().map(|v| mark(p.pressure_share, v))) {
                    let dash = vec![(x - 0.025 * full, v), (x + 0.025 * full, v)];
                    layers.push(Layer::Line { points: dash, ink, is_dashed: false });
                }
            }
            let points = here().filter_map(|p| p.measured_scalar().map(|m| mark(p.pressure_share, m))).collect();
            let shape = Shape::of_form(i);
            front.push(Layer::Marks { points, ink, shape });
            let words: Vec<String> = comparison.conditions.iter().zip(*set).map(|(c, v)| c.text(*v)).collect();
            let shape = any_measured.then_some(shape);
            legend.push(Key { text: words.join(", "), ink, shape, line: Some(false), band: None });
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
            y,
            layers,
            legend,
            readings: self.said(unit, full, &[comparison]),
            ..Chart::default()
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
        let mut legend = vec![Key::mark("measured", Ink::Measured, disc)];
        for (i, comparison, curve) in self.by_points().filter(|(_, c, _)| c.kind != "none") {
            let (ink, shape) = (Ink::Form(i), Shape::of_form(i));
            let published = comparison.kind == "published";
            let points: Vec<(f64, f64)> =
                comparison.points.iter().filter_map(|p| p.predicted.as_deref().and_then(at)).collect();
            let text = legend_text(comparison, points.is_empty());
            legend.push(Key { text, ink, shape: Some(shape), line: Some(published), band: None });
            // Under conditions, which change from point to point, the path is the one through the points.
            let lines: Vec<Vec<(f64, f64)>> = if comparison.conditions.is_empty() {
                let traces = curve.iter().flat_map(|c| &c.traces);
                traces.map(|trace| trace.points.iter().filter_map(|p| at(&p.values)).collect()).collect()
            } else {
                vec![points.clone()]
            };
            for line in lines.into_iter().filter(|line| line.len() > 1) {
                layers.push(Layer::Line { points: line, ink, is_dashed: published });
            }
            if !crowded {
                let ends =
                    comparison.points.iter().filter(|p| p.status == PointStatus::Used).filter_map(|p| {
                        Some([p.measured.as_deref().and_then(at)?, p.predicted.as_deref().and_then(at)?])
                    });
                layers.push(Layer::Vectors { ends: ends.collect(), ink });
                let marks = points.iter().map(|(x, y)| (*x, *y, String::new())).collect();
                layers.push(Layer::Marks { points: marks, ink, shape });
            }
            all.extend(points);
        }
        let said = first.points.iter().enumerate().filter_map(|(i, p)| {
            let here = || self.forms().into_iter().filter_map(move |c| Some((c, c.points.get(i)?)));
            let head = [readings::heading(first, p), readings::measured(first, p, unit)];
            let distance = |(c, p): (&Comparison, &Point)| {
                let apart = readings::residual(c, p, unit).map(|text| format!("{text} away"));
                apart.unwrap_or_else(|| readings::predicted(c, p, unit))
            };
            let weight = here().filter_map(|(_, p)| p.residual).map(f64::abs).fold(0.0, f64::max);
            let lines = head.into_iter().chain(here().map(distance)).collect();
            Some(Said { at: p.measured.as_deref().and_then(at)?, lines, weight })
        });
        let readings = readings::places(said.collect());
        let points = measured.iter().map(|(x, y)| (*x, *y, String::new())).collect();
        layers.push(Layer::Marks { points, ink: Ink::Measured, shape: disc });
        let more = if rest.is_empty() { String::new() } else { format!("; {} is not shown", rest.join(", ")) };
        let (x, y) = (spread(all.iter().map(|p| p.0), 0.08), spread(all.iter().map(|p| p.1), 0.08));
        let slender = ((x.end - x.start) / (y.end - y.start)).ln().abs() > SLENDER.ln();
        let (x, y) = if slender { (x, y) } else { to_scale(x, y) };
        let scales = if slender { "The axes have different scales." } else { "The axes have the same scale." };
        let chart = Chart {
            title: format!("{}: path", measurement_title(first)),
            x_title: axis(a, unit),
            y_title: axis(b, unit),
            x,
            y,
            layers,
            legend,
            readings,
            ..Chart::default()
        };
        let caption = format!(
            "{}: {b} over {a}, measured and predicted as the pressure rises{more}; arrows lead from measured to predicted. {}{scales}",
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
