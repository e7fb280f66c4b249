//! Which figures a result has: cross-section, response, residuals against bound, parity; errors that a paper only states; logs over time.

mod logs;
mod movement;
mod parity;
mod readings;
mod residuals;
mod response;
mod section;
mod stated;

use std::ops::Range;
use std::sync::atomic::{AtomicUsize, Ordering};

use pneuval_ingest::units::{Dimension, Unit};

use super::chart::{ASPECT, Chart, Key, file, stacked};
use super::group::by_measurement;
use super::scene::{Scene, png, svg};
use crate::AnalysisError;
use crate::format;
use crate::logs::Log;
use crate::results::{ActuatorRecord, Comparison, Point, PointStatus, Results};
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

/// Hears how much of how much is done, from any thread.
pub type Told<'a> = dyn Fn(usize, usize) + Sync + 'a;

/// Which figures become files beside the pages.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Files {
    /// None.
    None,
    /// At most 32, and on pages the figures of at most twelve datasets and twelve runs of an actuator.
    Some,
    /// Every figure there is, on pages and as files.
    Every,
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
    content: Content,
    /// What all sessions together show comes before what one shows.
    rank: usize,
}

enum Content {
    /// Charts above one another.
    Panels(Vec<Chart>),
    /// What is no chart.
    Drawing { title: String, scene: Scene, legend: Vec<Key> },
}

/// Datasets of an actuator that are shown in detail, unless every one is asked for: those that a reader needs most.
pub const DATASETS_MAX: usize = 12;

/// Runs of an actuator that are drawn over time, unless every one is asked for.
pub const RUNS_MAX: usize = 12;

/// Figures that become files, unless every one is asked for.
pub const FILES_MAX: usize = 32;

/// More marks than this would hide one another: they become dots, and predictions lines without marks.
const MARKS_MAX: usize = 60;

/// Every figure of the results that is drawn, in the order in which pages show them. After each, `told` hears how many are done of how
/// many.
///
/// # Errors
/// [`AnalysisError::Figure`] with the figure's name.
pub fn figures(
    results: &Results,
    curves: &[Curve],
    logs: &[Log],
    files: Files,
    told: &Told,
) -> Result<Vec<Figure>, AnalysisError> {
    let plans = plans(results, curves, logs, files == Files::Every);
    let mut ranks: Vec<usize> = plans.iter().map(|plan| plan.rank).collect();
    ranks.sort_unstable();
    let last = match files {
        Files::None => None,
        Files::Every => Some(usize::MAX),
        Files::Some => Some(ranks.get(FILES_MAX).map_or(usize::MAX, |next| next.saturating_sub(1))),
    };
    let is_file = |plan: &Plan| last.is_some_and(|last| plan.rank <= last);
    // Files cost as much as everything else together, and none depends on another.
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    let share = plans.len().div_ceil(threads).max(1);
    let (done, all) = (AtomicUsize::new(0), plans.len());
    let drawn = |plan: &Plan| {
        let figure = draw(plan, is_file(plan));
        told(done.fetch_add(1, Ordering::Relaxed) + 1, all);
        figure
    };
    let drawn = &drawn;
    std::thread::scope(|scope| {
        let threads: Vec<_> =
            plans.chunks(share).map(|chunk| scope.spawn(move || chunk.iter().map(drawn).collect::<Vec<_>>())).collect();
        threads
            .into_iter()
            .flat_map(|thread| thread.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic)))
            .collect()
    })
}

fn draw(plan: &Plan, is_file: bool) -> Result<Figure, AnalysisError> {
    let failed = |message| AnalysisError::Figure { figure: plan.name.clone(), message };
    let (title, scene, legend) = match &plan.content {
        Content::Drawing { title, scene, legend } => (title.clone(), scene.clone(), legend.clone()),
        Content::Panels(panels) => {
            // Panels that share a key show it once.
            let mut legend: Vec<Key> = Vec::new();
            for key in panels.iter().flat_map(|panel| &panel.legend) {
                if !legend.contains(key) {
                    legend.push(key.clone());
                }
            }
            let title = panels.first().map_or(String::new(), |panel| panel.title.clone());
            (title, stacked(panels).map_err(failed)?, legend)
        }
    };
    let svg = svg(&scene, &plan.caption);
    let png = if is_file {
        let texts = [
            ("Title", title.clone()),
            ("Description", plan.caption.clone()),
            ("Software", concat!("pneuval ", env!("CARGO_PKG_VERSION")).to_owned()),
        ];
        Some(png(&file(&title, scene, &legend), &texts).map_err(failed)?)
    } else {
        None
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

fn plans(results: &Results, curves: &[Curve], logs: &[Log], every: bool) -> Vec<Plan> {
    let mut plans = Vec::new();
    for actuator in &results.actuators {
        plans.extend(section::section(actuator).map(|section| Plan {
            name: format!("{}_section", actuator.id),
            actuator: actuator.id.clone(),
            caption: section.caption,
            content: Content::Drawing {
                title: "Cross-section, to scale".to_owned(),
                scene: section.scene,
                legend: section.legend,
            },
            rank: 0,
        }));
        let order = by_urgency(results, actuator);
        let rank_of = |dataset: &str| 1 + order.iter().position(|id| *id == dataset).unwrap_or(order.len());
        let is_drawn = |dataset: &str| every || rank_of(dataset) <= DATASETS_MAX;
        let mut plan = |name: String, rank: usize, synthetic: bool, (panels, mut caption): (Vec<Chart>, String)| {
            if panels.iter().any(Chart::reaches_beyond) {
                caption.push_str(" Arrows at the edge mark what lies beyond the axes.");
            }
            let mut panels = panels;
            if let Some(first) = panels.first_mut().filter(|_| synthetic) {
                // In front, where no length of the title can cut it off.
                first.title = format!("Synthetic: {}", first.title);
            }
            plans.push(Plan { name, actuator: actuator.id.clone(), caption, content: Content::Panels(panels), rank });
        };
        let one = |(chart, caption): (Chart, String)| (vec![chart], caption);
        let groups = groups(results, curves, &actuator.id);
        for group in &groups {
            let Some(first) = group.comparisons.first() else { continue };
            if !is_drawn(&first.dataset) {
                continue;
            }
            let rank = rank_of(&first.dataset);
            // Ids hold no underscore, so names cannot meet.
            let name = format!("{}_{}", first.dataset, first.quantity.id);
            if group.is_movement() {
                for (suffix, figure) in group.movements() {
                    plan(format!("{name}{suffix}"), rank, group.synthetic, one(figure));
                }
                continue;
            }
            for (suffix, figure) in group.responses() {
                plan(format!("{name}_response{suffix}"), rank, group.synthetic, one(figure));
            }
            if group.judges_points() {
                plan(format!("{name}_residuals"), rank, group.synthetic, one(group.residuals()));
            }
            if let Some(figure) = group.stated() {
                plan(format!("{name}_stated"), rank, group.synthetic, one(figure));
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
                plan(name, 0, same.iter().any(|g| g.synthetic), one(parity::parity(&same, unit)));
            }
        }
        let sittings = actuator.datasets.iter().filter(|dataset| is_drawn(&dataset.id));
        let sittings = sittings.filter_map(|dataset| Some((dataset, dataset.session.as_ref()?)));
        let n = sittings.clone().count();
        let runs_max = if every { usize::MAX } else { (RUNS_MAX / n.max(1)).max(1) };
        for (dataset, session) in sittings {
            for run in logs::runs_by_findings(session).into_iter().take(runs_max) {
                let here = |log: &&Log| log.dataset == dataset.id && log.run == run.id;
                let here: Vec<&Log> = logs.iter().filter(here).collect();
                if let Some(figure) = logs::panels(dataset, run, &here) {
                    let rank = rank_of(&dataset.id) + order.len();
                    plan(format!("{}_{}_log", dataset.id, run.id), rank, session.synthetic, figure);
                }
            }
        }
    }
    plans
}

/// Datasets of an actuator, those first that a reader needs most.
pub fn by_urgency<'a>(results: &'a Results, actuator: &ActuatorRecord) -> Vec<&'a str> {
    let mine = results.comparisons.iter().filter(|c| c.actuator == actuator.id);
    let mut all: Vec<(&str, (u8, f64))> = mine.map(|c| (c.dataset.as_str(), c.urgency())).collect();
    // Stable: else as they were read.
    all.sort_by(|(_, a), (_, b)| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)));
    let mut order: Vec<&str> = Vec::new();
    for (dataset, _) in all {
        if !order.contains(&dataset) {
            order.push(dataset);
        }
    }
    order
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
