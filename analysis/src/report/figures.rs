//! Which figures a result has: response, residuals against bound, parity.

use std::ops::Range;

use pneuval_ingest::units::{Dimension, Unit};

use super::chart::{Chart, Ink, Key, Layer, Shape, WIDTH_PX};
use super::group::{by_measurement, measurement_title};
use crate::AnalysisError;
use crate::format;
use crate::gate::{limit_text, metric_text};
use crate::metrics::Metric;
use crate::results::{Comparison, Point, PointStatus, Results};
use crate::series::Curve;

/// A drawn figure.
#[derive(Debug, Clone, PartialEq)]
pub struct Figure {
    /// File name without ending, such as `internal-support_outer-diameter_response`.
    pub name: String,
    /// The actuator whose page shows it.
    pub actuator: String,
    /// What it shows, for the caption and for readers who cannot see it.
    pub caption: String,
    /// Width and height on a page, half the pixels of the file.
    pub size: (u32, u32),
    /// The PNG file.
    pub png: Vec<u8>,
}

/// Comparisons of one quantity of one actuator, in the order of the results.
struct Group<'a> {
    comparisons: Vec<&'a Comparison>,
    curves: Vec<Option<&'a Curve>>,
}

/// Where the column of values ends in a figure of residuals by form, in half axes.
const VALUES_TO: f64 = 1.43;

/// A figure before it is drawn.
struct Plan {
    name: String,
    actuator: String,
    caption: String,
    chart: Chart,
}

/// Every figure of the results, in the order in which pages show them.
///
/// # Errors
/// [`AnalysisError::Figure`] with the figure's name.
pub fn figures(results: &Results, curves: &[Curve]) -> Result<Vec<Figure>, AnalysisError> {
    let plans = plans(results, curves);
    // A figure costs as much as everything else together, and none depends on another.
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    let share = plans.len().div_ceil(threads).max(1);
    std::thread::scope(|scope| {
        let drawn: Vec<_> =
            plans.chunks(share).map(|chunk| scope.spawn(|| chunk.iter().map(draw).collect::<Vec<_>>())).collect();
        drawn
            .into_iter()
            .flat_map(|thread| thread.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic)))
            .collect()
    })
}

fn draw(plan: &Plan) -> Result<Figure, AnalysisError> {
    let figure = || plan.name.clone();
    let size = (WIDTH_PX / 2, plan.chart.height_px() / 2);
    let png = plan.chart.draw().map_err(|message| AnalysisError::Figure { figure: figure(), message })?;
    Ok(Figure { name: figure(), actuator: plan.actuator.clone(), caption: plan.caption.clone(), size, png })
}

fn plans(results: &Results, curves: &[Curve]) -> Vec<Plan> {
    let mut plans = Vec::new();
    for actuator in &results.actuators {
        let mut plan = |name: String, (chart, caption): (Chart, String)| {
            plans.push(Plan { name, actuator: actuator.id.clone(), caption, chart });
        };
        let groups = groups(results, curves, &actuator.id);
        for group in &groups {
            let Some(first) = group.comparisons.first() else { continue };
            // Ids hold no underscore, so names cannot meet.
            let name = format!("{}_{}", first.dataset, first.quantity.id);
            plan(format!("{name}_response"), group.response());
            plan(format!("{name}_residuals"), group.residuals());
        }
        let mut units: Vec<Unit> = Vec::new();
        for unit in groups.iter().filter_map(Group::unit) {
            if !units.contains(&unit) {
                units.push(unit);
                let same: Vec<&Group> = groups.iter().filter(|g| g.unit() == Some(unit)).collect();
                let symbol = if unit.symbol == "%" { "percent" } else { unit.symbol };
                let name = format!("{}_parity_{symbol}", actuator.id);
                plan(name, parity(&same, unit));
            }
        }
    }
    plans
}

fn groups<'a>(results: &'a Results, curves: &'a [Curve], actuator: &str) -> Vec<Group<'a>> {
    let curve_of = |c: &&Comparison| curves.iter().find(|curve| curve.comparison == c.id);
    by_measurement(results.comparisons.iter().filter(|c| c.actuator == actuator))
        .into_iter()
        .map(|comparisons| Group { curves: comparisons.iter().map(curve_of).collect(), comparisons })
        .collect()
}

/// The smallest range holding all values, widened by a share of itself on either side.
fn spread(values: impl Iterator<Item = f64>, margin: f64) -> Range<f64> {
    let finite = values.filter(|v| v.is_finite());
    let (low, high) = finite.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(v), b.max(v)));
    if low > high {
        return 0.0..1.0;
    }
    // A range much narrower than its values' digits cannot be divided into ticks.
    let size = low.abs().max(high.abs());
    let width = if high - low > 1e-9 * size { high - low } else { size.max(1.0) };
    low - margin * width..high + margin * width
}

impl Group<'_> {
    fn unit(&self) -> Option<Unit> {
        self.comparisons.first().map(|c| c.quantity.unit())
    }

    /// Points with a measured value, in the unit shown: the same for every comparison of the group.
    fn measured(&self, unit: Unit) -> Vec<(f64, f64)> {
        let points = self.comparisons.first().map(|c| c.points.as_slice()).unwrap_or_default();
        points.iter().filter_map(|p| p.measured.map(|m| (p.pressure_share, unit.from_si(m)))).collect()
    }

    /// The horizontal axis: gauge pressure of the one chamber, or the share of full pressure of several.
    fn pressure_axis(&self) -> (String, f64) {
        let Some(first) = self.comparisons.first() else { return (String::new(), 1.0) };
        let chambers = first.chambers.len();
        let full: Vec<f64> =
            (0..chambers).map(|i| first.points.iter().map(|p| p.pressures_gauge_pa[i]).fold(0.0, f64::max)).collect();
        let unit = Dimension::Pressure.display_unit();
        if let [full] = full.as_slice() {
            // A table with nothing but the reference still has an axis.
            let full = if *full > 0.0 { unit.from_si(*full) } else { 1.0 };
            (format!("Gauge pressure / {}", unit.printed()), full)
        } else {
            (format!("Share of full gauge pressure ({}) / %", format::pressures(&full, &first.chambers)), 100.0)
        }
    }

    /// Where the pressure axis starts: at zero, or at the deepest vacuum.
    fn lowest_share(&self) -> f64 {
        let points = self.comparisons.iter().flat_map(|c| &c.points);
        points.map(|p| p.pressure_share).fold(0.0, f64::min)
    }

    fn response(&self) -> (Chart, String) {
        let (Some(first), Some(unit)) = (self.comparisons.first(), self.unit()) else {
            return (empty(), String::new());
        };
        let (x_title, full) = self.pressure_axis();
        let measured = self.measured(unit);
        let (low, high) =
            measured.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), (_, v)| (a.min(*v), b.max(*v)));
        // Predictions may leave the axes; half the measured range above the measurement keeps it readable.
        let start = measured.len() < 2;
        let floor = if start { 0.0_f64.min(low) } else { low };
        let span = (high - floor).abs().max(f64::MIN_POSITIVE);
        let values = self.curves.iter().flatten().flat_map(|c| c.points.iter().map(|p| unit.from_si(p.value)));
        let limits = floor - 0.25 * span..high + 0.5 * span;
        let shown = values.filter(|v| limits.contains(v)).chain([floor, high]);
        let y = spread(shown, 0.06);
        // Printed columns in front: dashes over a line stay visible, a line over dashes hides them.
        let (mut layers, mut front) = (Vec::new(), Vec::new());
        let mut legend = vec![Key {
            text: "measured".into(),
            ink: Ink::Measured,
            shape: Some(Shape::Disc),
            line: None,
            band: false,
        }];
        for (i, (comparison, curve)) in self.comparisons.iter().zip(&self.curves).enumerate() {
            let (ink, shape) = (Ink::Form(i), Shape::of_form(i));
            let published = comparison.kind == "published";
            let line: Vec<(f64, f64)> =
                curve.iter().flat_map(|c| c.points.iter().map(|p| (full * p.share, unit.from_si(p.value)))).collect();
            let points: Vec<(f64, f64, String)> = comparison
                .points
                .iter()
                .filter_map(|p| p.predicted.map(|v| (full * p.pressure_share, v)))
                .map(|(x, v)| (x, unit.from_si(v), format::quantity(v, unit, 1)))
                .collect();
            let missing = comparison.n_without_prediction > 0;
            let text = match (points.is_empty(), missing) {
                (true, _) => format!("{}: no prediction", comparison.title),
                (false, true) => {
                    format!("{}: no prediction at {} points", comparison.title, comparison.n_without_prediction)
                }
                (false, false) => comparison.title.clone(),
            };
            legend.push(Key { text, ink, shape: Some(shape), line: Some(published), band: false });
            let target = if published { &mut front } else { &mut layers };
            if line.len() > 1 {
                target.push(Layer::Line { points: line, ink, dashed: published });
            }
            target.push(Layer::Marks { points, ink, shape });
        }
        layers.append(&mut front);
        let points = measured.iter().map(|(share, v)| (full * share, *v, String::new())).collect();
        layers.push(Layer::Marks { points, ink: Ink::Measured, shape: Shape::Disc });
        let title = format!("{} over pressure", measurement_title(first));
        let caption = format!(
            "{}: measured, and every form. Arrows mark predictions beyond the axis. No error bars: no measurement uncertainty is published.",
            first.quantity.title
        );
        let chart = Chart {
            title,
            x_title,
            y_title: axis(&first.quantity.title, unit),
            x: (self.lowest_share() - 0.02) * full..1.04 * full,
            y,
            rows: vec![],
            layers,
            legend,
        };
        (chart, caption)
    }

    fn residuals(&self) -> (Chart, String) {
        let many = self.comparisons.iter().any(|c| c.n_used + c.n_without_prediction > 1);
        if many { self.residuals_over_pressure() } else { self.residuals_by_form() }
    }

    /// A bound in terms of the residual of a comparison: its limit on |e|, in the unit shown.
    fn residual_bound(comparison: &Comparison, unit: Unit) -> Option<f64> {
        comparison.judgements.iter().find_map(|j| match j.bound.metric {
            Metric::MaxAbsError => Some(unit.from_si(j.bound.max)),
            Metric::RelativeToPredictedMax => {
                let p = used_point(comparison)?.predicted?;
                (comparison.n_used == 1).then(|| unit.from_si(j.bound.max * p.abs()))
            }
            Metric::RelativeToMeasuredMax => {
                let m = used_point(comparison)?.measured?;
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
        let (Some(first), Some(unit)) = (self.comparisons.first(), self.unit()) else {
            return (empty(), String::new());
        };
        let (x_title, full) = self.pressure_axis();
        let reach = self.residual_reach(unit);
        let x = (self.lowest_share() - 0.02) * full..1.08 * full;
        let mut layers = Vec::new();
        let mut legend = Vec::new();
        let bounds: Vec<f64> = self.comparisons.iter().filter_map(|c| Self::residual_bound(c, unit)).collect();
        let common = bounds.first().filter(|b| bounds.iter().all(|other| other.to_bits() == b.to_bits()));
        if let Some(bound) = common {
            layers.push(Layer::Band(x.clone(), -bound..*bound));
            let text = format!("bound: |e| at most {}", format::with_unit(&format::short(*bound), unit));
            legend.push(Key { text, ink: Ink::Measured, shape: None, line: None, band: true });
        }
        layers.push(Layer::Reference(vec![(x.start, 0.0), (x.end, 0.0)]));
        let mut front = Vec::new();
        for (i, comparison) in self.comparisons.iter().enumerate() {
            let (ink, shape) = (Ink::Form(i), Shape::of_form(i));
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
            if line.len() > 1 {
                target.push(Layer::Line { points: line, ink, dashed: published });
            }
            target.push(Layer::Marks { points, ink, shape });
        }
        layers.append(&mut front);
        let chart = Chart {
            title: format!("{}: residual over pressure", measurement_title(first)),
            x_title,
            y_title: format!("Predicted − measured / {}", unit_name(unit)),
            x,
            y: -reach..reach,
            rows: vec![],
            layers,
            legend,
        };
        let caption = format!(
            "{}: predicted minus measured, positive where the model is too high, against the bound on the largest error. Arrows mark residuals beyond the axis, with their value.",
            first.quantity.title
        );
        (chart, caption)
    }

    fn residuals_by_form(&self) -> (Chart, String) {
        let (Some(first), Some(unit)) = (self.comparisons.first(), self.unit()) else {
            return (empty(), String::new());
        };
        let reach = self.residual_reach(unit);
        let n = self.comparisons.len() as f64;
        let mut layers = Vec::new();
        for (i, comparison) in self.comparisons.iter().enumerate() {
            let top = n - i as f64;
            if let Some(bound) = Self::residual_bound(comparison, unit) {
                layers.push(Layer::Band(-bound..bound, top - 0.94..top - 0.06));
            }
        }
        layers.push(Layer::Reference(vec![(0.0, 0.0), (0.0, n)]));
        for (i, comparison) in self.comparisons.iter().enumerate() {
            let middle = n - i as f64 - 0.5;
            let residual = comparison.points.iter().filter(|p| p.status == PointStatus::Used).find_map(|p| p.residual);
            let text = match residual {
                Some(r) => {
                    let points = vec![(unit.from_si(r), middle, String::new())];
                    layers.push(Layer::Marks { points, ink: Ink::Form(i), shape: Shape::of_form(i) });
                    metric_text(Metric::Bias, r, unit)
                }
                None => "no prediction".to_owned(),
            };
            // Values stand in a column of their own, to the right of where a mark can be.
            layers.push(Layer::Words { at: (VALUES_TO * reach, middle), text, muted: residual.is_none() });
        }
        let bound_text = self.comparisons.iter().find_map(|c| c.deciding()).map_or("bound".to_owned(), |j| {
            format!("bound: {} at most {}", j.bound.metric.title(), limit_text(j.bound.metric, j.bound.max, unit))
        });
        let legend = vec![Key { text: bound_text, ink: Ink::Measured, shape: None, line: None, band: true }];
        let asked = first.points.iter().find(|p| p.status != PointStatus::ZeroReference && p.measured.is_some());
        let pressure = asked.map(|p| format::pressures(&p.pressures_gauge_pa, &first.chambers));
        let measured = asked.and_then(|p| p.measured).map(|m| format::quantity(m, unit, 0));
        let place = format!("{} measured at {}", measured.unwrap_or_default(), pressure.unwrap_or_default());
        let chart = Chart {
            title: format!("{}: residual by form, {place}", measurement_title(first)),
            x_title: format!("Predicted − measured / {}", unit_name(unit)),
            y_title: String::new(),
            x: -reach..(VALUES_TO + 0.02) * reach,
            y: 0.0..n,
            rows: self.comparisons.iter().map(|c| c.title.clone()).collect(),
            layers,
            legend,
        };
        let caption = format!(
            "{}: predicted minus measured at the one printed point, against each form's bound. Arrows mark residuals beyond the axis.",
            first.quantity.title
        );
        (chart, caption)
    }
}

/// Predicted against measured, for every quantity of one unit.
fn parity(groups: &[&Group], unit: Unit) -> (Chart, String) {
    let measured: Vec<f64> = groups.iter().flat_map(|g| g.measured(unit)).map(|(_, v)| v).collect();
    // Several quantities start at their common zero; one is shown around its own values.
    let zero = (groups.len() > 1).then_some(0.0);
    let range = spread(measured.iter().copied().chain(zero), if measured.len() > 1 { 0.12 } else { 0.5 });
    let mut layers = vec![Layer::Reference(vec![(range.start, range.start), (range.end, range.end)])];
    let line =
        Key { text: "predicted = measured".into(), ink: Ink::Measured, shape: None, line: Some(false), band: false };
    let mut legend = vec![line];
    // One quantity: a look per form, as in its other figures. Several: a look per kind of form, or the legend would be longer
    // than the figure.
    let mut looks: Vec<&str> = Vec::new();
    let mut front = Vec::new();
    for comparison in groups.iter().flat_map(|g| &g.comparisons) {
        let name = if groups.len() == 1 { comparison.title.as_str() } else { comparison.kind.as_str() };
        let i = looks.iter().position(|look| *look == name).unwrap_or_else(|| {
            looks.push(name);
            looks.len() - 1
        });
        let points: Vec<(f64, f64, String)> = comparison
            .points
            .iter()
            .filter(|p| p.status == PointStatus::Used)
            .filter_map(|p| p.measured.zip(p.predicted))
            .map(|(m, p)| (unit.from_si(m), unit.from_si(p), format::quantity(p, unit, 1)))
            .collect();
        let (ink, shape) = (Ink::Form(i), Shape::of_form(i));
        let key = Key { text: name.to_owned(), ink, shape: Some(shape), line: None, band: false };
        if !points.is_empty() && !legend.contains(&key) {
            legend.push(key);
        }
        let target = if comparison.kind == "published" { &mut front } else { &mut layers };
        target.push(Layer::Marks { points, ink, shape });
    }
    layers.append(&mut front);
    let titles: Vec<&str> =
        groups.iter().filter_map(|g| g.comparisons.first()).map(|c| c.quantity.title.as_str()).collect();
    let chart = Chart {
        title: "Predicted against measured".to_owned(),
        x_title: format!("Measured / {}", unit_name(unit)),
        y_title: format!("Predicted / {}", unit_name(unit)),
        x: range.clone(),
        y: range,
        rows: vec![],
        layers,
        legend,
    };
    let caption = format!(
        "{}: a perfect prediction lies on the line. Arrows mark predictions beyond the axis, with their value.",
        titles.join(", ")
    );
    (chart, caption)
}

/// The first point in the metrics.
fn used_point(comparison: &Comparison) -> Option<&Point> {
    comparison.points.iter().find(|p| p.status == PointStatus::Used)
}

fn axis(title: &str, unit: Unit) -> String {
    format!("{title} / {}", unit_name(unit))
}

fn unit_name(unit: Unit) -> &'static str {
    if unit.printed().is_empty() { "1" } else { unit.printed() }
}

fn empty() -> Chart {
    Chart {
        title: String::new(),
        x_title: String::new(),
        y_title: String::new(),
        x: 0.0..1.0,
        y: 0.0..1.0,
        rows: vec![],
        layers: vec![],
        legend: vec![],
    }
}
