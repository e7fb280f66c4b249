//! Which figures a result has: response, residuals against bound, parity; errors that a paper only states; logs over time.

mod movement;
mod parity;
mod readings;
mod residuals;
mod response;
mod stated;

use std::ops::Range;

use pneuval_ingest::units::{Dimension, Unit};

use super::chart::{ASPECT, Chart, Key, file, stacked};
use super::group::by_measurement;
use super::scene::{Scene, png, svg};
use crate::AnalysisError;
use crate::format;
use crate::results::{Comparison, Point, PointStatus, Results};
use crate::series::Curve;
use crate::verdict::Verdict;

/// A drawn figure.
#[derive(Debug, Clone, PartialEq)]
pub struct Figure {
    /// File name without ending, such as `internal-support_outer-diameter_response`.
    pub name: String,
    /// The actuator whose page shows it.
    pub actuator: String,
    /// Its title.
    pub title: String,
    /// What it shows, for the caption and for readers who cannot see it.
    pub caption: String,
    /// The plot as an `svg` element.
    pub svg: String,
    /// Its legend: an `svg` element each, and what it stands for.
    pub legend: Vec<(String, String)>,
    /// The PNG file, if files are drawn.
    pub png: Option<Vec<u8>>,
}

/// What is drawn of a figure.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Files {
    /// The page alone.
    None,
    /// PNG files, too.
    Png,
}

/// Comparisons of one quantity of one dataset, in the order of the results.
struct Group<'a> {
    comparisons: Vec<&'a Comparison>,
    curves: Vec<Option<&'a Curve>>,
    /// The data were written by a program.
    synthetic: bool,
}

/// A figure before it is drawn.
struct Plan {
    name: String,
    actuator: String,
    caption: String,
    panels: Vec<Chart>,
}

/// More marks than this would hide one another: they become dots, and predictions lines without marks.
const MARKS_MAX: usize = 60;

/// Every figure of the results, in the order in which pages show them.
///
/// # Errors
/// [`AnalysisError::Figure`] with the figure's name.
pub fn figures(results: &Results, curves: &[Curve], files: Files) -> Result<Vec<Figure>, AnalysisError> {
    let plans = plans(results, curves);
    // Files cost as much as everything else together, and none depends on another.
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    let share = plans.len().div_ceil(threads).max(1);
    std::thread::scope(|scope| {
        let drawn: Vec<_> = plans
            .chunks(share)
            .map(|chunk| scope.spawn(move || chunk.iter().map(|plan| draw(plan, files)).collect::<Vec<_>>()))
            .collect();
        drawn
            .into_iter()
            .flat_map(|thread| thread.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic)))
            .collect()
    })
}

fn draw(plan: &Plan, files: Files) -> Result<Figure, AnalysisError> {
    let failed = |message| AnalysisError::Figure { figure: plan.name.clone(), message };
    let scene: Scene = stacked(&plan.panels).map_err(failed)?;
    let title = plan.panels.first().map_or(String::new(), |panel| panel.title.clone());
    // Panels that share a key show it once.
    let mut legend: Vec<Key> = Vec::new();
    for key in plan.panels.iter().flat_map(|panel| &panel.legend) {
        if !legend.contains(key) {
            legend.push(key.clone());
        }
    }
    let svg = svg(&scene, &plan.caption);
    let png = match files {
        Files::None => None,
        Files::Png => {
            let texts = [
                ("Title", title.clone()),
                ("Description", plan.caption.clone()),
                ("Software", concat!("pneuval ", env!("CARGO_PKG_VERSION")).to_owned()),
            ];
            Some(png(&file(&title, scene, &legend), &texts).map_err(failed)?)
        }
    };
    Ok(Figure {
        name: plan.name.clone(),
        actuator: plan.actuator.clone(),
        title,
        caption: plan.caption.clone(),
        svg,
        legend: legend.into_iter().map(|key| (key.swatch(), key.text)).collect(),
        png,
    })
}

fn plans(results: &Results, curves: &[Curve]) -> Vec<Plan> {
    let mut plans = Vec::new();
    for actuator in &results.actuators {
        let mut plan = |name: String, synthetic: bool, (mut chart, mut caption): (Chart, String)| {
            if chart.reaches_beyond() {
                caption.push_str(" Arrows at the edge mark what lies beyond the axes.");
            }
            if synthetic {
                // In front, where no length of the title can cut it off.
                chart.title = format!("Synthetic: {}", chart.title);
            }
            plans.push(Plan { name, actuator: actuator.id.clone(), caption, panels: vec![chart] });
        };
        let groups = groups(results, curves, &actuator.id);
        for group in &groups {
            let Some(first) = group.comparisons.first() else { continue };
            // Ids hold no underscore, so names cannot meet.
            let name = format!("{}_{}", first.dataset, first.quantity.id);
            if group.is_movement() {
                for (suffix, figure) in group.movements() {
                    plan(format!("{name}{suffix}"), group.synthetic, figure);
                }
                continue;
            }
            for (suffix, figure) in group.responses() {
                plan(format!("{name}_response{suffix}"), group.synthetic, figure);
            }
            if group.judges_points() {
                plan(format!("{name}_residuals"), group.synthetic, group.residuals());
            }
            if let Some(figure) = group.stated() {
                plan(format!("{name}_stated"), group.synthetic, figure);
            }
        }
        let mut units: Vec<Unit> = Vec::new();
        let comparable: Vec<&Group> =
            groups.iter().filter(|g| g.judges_points() && !g.is_position() && !g.is_movement()).collect();
        for unit in comparable.iter().filter_map(|g| g.unit()) {
            if !units.contains(&unit) {
                units.push(unit);
                let same: Vec<&Group> = comparable.iter().copied().filter(|g| g.unit() == Some(unit)).collect();
                let symbol = match unit.symbol {
                    "%" => "percent".to_owned(),
                    other => other.replace(['/', ' ', '(', ')'], "-"),
                };
                let name = format!("{}_parity_{symbol}", actuator.id);
                plan(name, same.iter().any(|g| g.synthetic), parity::parity(&same, unit));
            }
        }
    }
    plans
}

fn groups<'a>(results: &'a Results, curves: &'a [Curve], actuator: &str) -> Vec<Group<'a>> {
    let curve_of = |c: &&Comparison| curves.iter().find(|curve| curve.comparison == c.id);
    let datasets = || results.actuators.iter().flat_map(|a| &a.datasets);
    by_measurement(results.comparisons.iter().filter(|c| c.actuator == actuator))
        .into_iter()
        .map(|comparisons| Group {
            curves: comparisons.iter().map(curve_of).collect(),
            synthetic: comparisons.first().is_some_and(|c| {
                let session = datasets().find(|d| d.id == c.dataset).and_then(|d| d.session.as_ref());
                session.is_some_and(|s| s.synthetic)
            }),
            comparisons,
        })
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

/// Two ranges widened so that a unit is as long on both axes.
fn to_scale(x: Range<f64>, y: Range<f64>) -> (Range<f64>, Range<f64>) {
    let (width, height) = (x.end - x.start, y.end - y.start);
    let widened = |range: Range<f64>, to: f64| {
        let more = 0.5 * (to - (range.end - range.start));
        range.start - more..range.end + more
    };
    if width < ASPECT * height { (widened(x, ASPECT * height), y) } else { (x, widened(y, width / ASPECT)) }
}

impl Group<'_> {
    fn unit(&self) -> Option<Unit> {
        self.comparisons.first().map(|c| c.quantity.unit())
    }

    fn is_position(&self) -> bool {
        self.comparisons.first().is_some_and(|c| c.quantity.is_position())
    }

    /// Comparisons made point by point, each with its place in the list of forms.
    fn by_points(&self) -> impl Iterator<Item = (usize, &Comparison, Option<&Curve>)> {
        let all = self.comparisons.iter().zip(&self.curves).enumerate();
        all.filter(|(_, (c, _))| !c.points.is_empty()).map(|(i, (c, curve))| (i, *c, *curve))
    }

    /// Whether any point has a residual, or should have one.
    fn judges_points(&self) -> bool {
        // What was fitted to these very points has no residual worth drawing.
        let judged = |c: &Comparison| c.verdict != Verdict::Calibration;
        self.by_points().any(|(_, c, _)| judged(c) && c.n_used + c.n_without_prediction > 0)
    }

    /// The points of the first comparison: pressures, conditions and measured values are the same for every other.
    fn points(&self) -> &[Point] {
        self.by_points().next().map(|(_, c, _)| c.points.as_slice()).unwrap_or_default()
    }

    /// Points with a measured value, in the unit shown.
    fn measured(&self, unit: Unit) -> Vec<(f64, f64)> {
        let points = self.points().iter();
        points.filter_map(|p| p.measured_scalar().map(|m| (p.pressure_share, unit.from_si(m)))).collect()
    }

    /// The horizontal axis: gauge pressure of the one chamber, or the share of full pressure of several.
    fn pressure_axis(&self) -> (String, f64) {
        let Some(first) = self.comparisons.first() else { return (String::new(), 1.0) };
        let chambers = first.chambers.len();
        let full: Vec<f64> = (0..chambers)
            .map(|i| self.points().iter().map(|p| p.pressures_gauge_pa[i].abs()).fold(0.0, f64::max))
            .collect();
        let unit = Dimension::Pressure.display_unit();
        if let [full] = full.as_slice() {
            // A table with nothing but the reference still has an axis.
            let full = if *full > 0.0 { unit.from_si(*full) } else { 1.0 };
            (format!("Gauge pressure / {}", unit.printed()), full)
        } else {
            (format!("Share of full gauge pressure ({}) / %", format::pressures(&full, &first.chambers)), 100.0)
        }
    }

    /// The range of the pressure axis whose full scale is `full`: zero, the deepest vacuum and the highest pressure lie in it,
    /// with a margin of so many hundredths beyond the highest.
    fn pressure_range(&self, full: f64, margin: f64) -> Range<f64> {
        let shares = || self.points().iter().map(|p| p.pressure_share);
        let (low, high) = (shares().fold(0.0, f64::min), shares().fold(0.0, f64::max));
        let (low, high) = if high > low { (low, high) } else { (0.0, 1.0) };
        (low - 0.02) * full..(high + margin) * full
    }

    /// Whether marks would hide one another.
    fn is_crowded(&self) -> bool {
        self.points().len() > MARKS_MAX
    }
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
