//! A movement: its path with that of each prediction, a plain number over time, and how far apart the two are.

use pneuval_ingest::units::Unit;

use super::readings::{self, Said};
use super::{Group, axis, spread, to_scale, unit_name};
use crate::format;
use crate::metrics::Metric;
use crate::report::chart::{Chart, Ground, Ink, Key, Layer};
use crate::report::group::measurement_title;
use crate::report::scene::Shape;
use crate::results::{Against, Comparison, Point, PointStatus};
use crate::series::{Curve, Trace};

/// Runs of one figure whose lines can still be told apart.
const RUNS_MAX: usize = 9;

/// Stretches of a movement of which the worst point is told.
const STRETCHES: usize = 40;

/// Neighbours of an error curve that are drawn as their least and largest.
const DRAWN_MAX: usize = 2_000;

/// Where a value at a place of a movement is drawn.
type Drawn<'a> = &'a dyn Fn(f64, &[f64]) -> Option<(f64, f64)>;

/// A line, and whether it was measured.
type Traced = (bool, Vec<(f64, f64)>);

/// The errors of some runs, which are one.
type RunErrors<'a> = (&'a [String], Vec<(f64, f64)>);

impl Group<'_> {
    /// Whether it is compared at equal time or arc length.
    pub(super) fn is_movement(&self) -> bool {
        self.comparisons.first().is_some_and(|c| c.against != Against::Pressure)
    }

    /// The figures of a movement, two for each form: the end of the name, and the figure.
    pub(super) fn movements(&self) -> Vec<(String, (Chart, String))> {
        let mut figures = Vec::new();
        for (c, curve) in self.comparisons.iter().zip(&self.curves) {
            let traces = curve.map(|curve: &Curve| curve.traces.as_slice()).unwrap_or_default();
            figures.push((format!("_response_{}", c.form), shown(c, traces)));
            if c.points.iter().any(|p| p.residual.is_some()) {
                figures.push((format!("_residuals_{}", c.form), errors(c)));
            }
        }
        figures
    }
}

/// What a movement is compared at, as an axis.
fn abscissa(c: &Comparison) -> (&'static str, f64) {
    match c.against {
        Against::Time => ("Time / s", 1.0),
        Against::ArcLength | Against::Pressure => ("Share of arc length / %", 100.0),
    }
}

/// What is subtracted from stamps, so that an axis has numbers that one can read: whole seconds.
fn start_of(c: &Comparison, places: impl Iterator<Item = f64>) -> f64 {
    let first = places.fold(f64::INFINITY, f64::min);
    // Stamps that count from 1970 differ in their last digits only.
    if c.against == Against::Time && first.is_finite() && first.abs() > 1e5 { first.floor() } else { 0.0 }
}

/// The title of an axis whose stamps count from a later start.
fn from_start(title: &str, start: f64) -> String {
    if start == 0.0 { title.to_owned() } else { format!("{title}, from {} s", format::fixed(start, 0)) }
}

/// The paths in their widest plane, or a plain number over time.
fn shown(c: &Comparison, traces: &[Trace]) -> (Chart, String) {
    let unit = c.quantity.unit();
    if c.quantity.is_position() { path(c, traces, unit) } else { over_time(c, traces, unit) }
}

/// The measured lines and the predicted one; of what nothing predicts, the points.
fn lines(c: &Comparison, traces: &[Trace], at: Drawn) -> Vec<Traced> {
    if traces.is_empty() {
        let measured = c.points.iter().filter_map(|p| at(p.at?, p.measured.as_deref()?)).collect();
        return vec![(true, measured)];
    }
    let line = |trace: &Trace| trace.points.iter().filter_map(|p| at(p.share, &p.values)).collect();
    traces.iter().enumerate().map(|(i, trace)| (i > 0, line(trace))).collect()
}

fn layers(c: &Comparison, lines: &[Traced]) -> (Vec<Layer>, Vec<Key>) {
    let (mut layers, mut legend) = (Vec::new(), vec![Key::line("measured", Ink::Measured)]);
    let runs = lines.iter().filter(|(is_measured, _)| *is_measured).count();
    for (_, line) in lines.iter().filter(|(is_measured, _)| *is_measured).take(RUNS_MAX) {
        layers.push(Layer::Trail { points: line.clone(), ink: Ink::Measured });
    }
    if runs > 1 {
        let shown =
            if runs > RUNS_MAX { format!("the first {RUNS_MAX} of {runs} runs") } else { format!("{runs} runs") };
        legend[0].text = format!("measured, {shown}");
    }
    for (_, line) in lines.iter().filter(|(is_measured, _)| !is_measured) {
        layers.push(Layer::Trail { points: line.clone(), ink: Ink::Form(0) });
        legend.push(Key::line(c.title.clone(), Ink::Form(0)));
    }
    // Where a path begins cannot be seen from the path.
    let starts: Vec<(bool, (f64, f64))> = lines.iter().filter_map(|(m, line)| Some((*m, *line.first()?))).collect();
    if c.quantity.is_position() {
        for (is_measured, (x, y)) in starts {
            let (ink, shape) = if is_measured { (Ink::Measured, Shape::Disc) } else { (Ink::Form(0), Shape::Square) };
            layers.push(Layer::Marks { points: vec![(x, y, String::new())], ink, shape });
        }
        legend.push(Key::mark("where a path begins", Ink::Measured, Shape::Disc));
    }
    (layers, legend)
}

fn path(c: &Comparison, traces: &[Trace], unit: Unit) -> (Chart, String) {
    let measured = c.points.iter().filter_map(|p| p.measured.as_deref());
    let drawn = traces.iter().skip(1).flat_map(|t| &t.points).map(|p| p.values.as_slice());
    let all: Vec<&[f64]> = measured.chain(drawn).collect();
    let [i, j] = widest(&all, c.quantity.components.len());
    let at = |_: f64, values: &[f64]| Some((unit.from_si(*values.get(i)?), unit.from_si(*values.get(j)?)));
    let lines = lines(c, traces, &at);
    let (Some(a), Some(b)) = (c.quantity.components.get(i), c.quantity.components.get(j)) else {
        return (Chart::default(), String::new());
    };
    let every = || lines.iter().flat_map(|(_, line)| line);
    let (x, y) = to_scale(spread(every().map(|p| p.0), 0.06), spread(every().map(|p| p.1), 0.06));
    let (mut layers, legend) = layers(c, &lines);
    let place = |values: Option<&[f64]>| values.and_then(|values| at(0.0, values));
    let worst = worst_of_stretches(c);
    let ends = worst.iter().filter_map(|p| Some([place(p.measured.as_deref())?, place(p.predicted.as_deref())?]));
    layers.push(Layer::Vectors { ends: ends.collect(), ink: Ink::Form(1) });
    let said = worst.iter().filter_map(|p| {
        let at = place(p.measured.as_deref())?;
        Some(Said { at, lines: words(c, p, unit), weight: p.residual.map_or(0.0, f64::abs) })
    });
    let readings = readings::places(said.collect());
    let rest: Vec<&str> =
        c.quantity.components.iter().filter(|name| *name != a && *name != b).map(String::as_str).collect();
    let rest = if rest.is_empty() {
        String::new()
    } else {
        format!(" ({}, which varies least, is not shown)", rest.join(", "))
    };
    let chart = Chart {
        title: format!("{}: path", measurement_title(c)),
        x_title: axis(a, unit),
        y_title: axis(b, unit),
        x,
        y,
        layers,
        legend,
        readings,
        ..Chart::default()
    };
    let arrows = if worst.is_empty() {
        ""
    } else {
        " Arrows lead from measured to predicted, where the error is largest nearby."
    };
    let caption = format!(
        "{}: {b} over {a}{rest}, measured and {}, to scale.{arrows}{}",
        c.quantity.title,
        predicted_name(c),
        circumstances(c)
    );
    (chart, caption)
}

fn over_time(c: &Comparison, traces: &[Trace], unit: Unit) -> (Chart, String) {
    let (x_title, scale) = abscissa(c);
    let places = c.points.iter().filter_map(|p| p.at).chain(traces.iter().flat_map(|t| &t.points).map(|p| p.share));
    let start = start_of(c, places);
    let at = |place: f64, values: &[f64]| Some((scale * (place - start), unit.from_si(*values.first()?)));
    let lines = lines(c, traces, &at);
    let every = || lines.iter().flat_map(|(_, line)| line);
    let (x, y) = (spread(every().map(|p| p.0), 0.02), spread(every().map(|p| p.1), 0.06));
    let (layers, legend) = layers(c, &lines);
    let said = worst_of_stretches(c).into_iter().filter_map(|p| {
        let at = at(p.at?, p.measured.as_deref()?)?;
        Some(Said { at, lines: words(c, p, unit), weight: p.residual.map_or(0.0, f64::abs) })
    });
    let readings = readings::columns(said.collect(), x.end - x.start);
    let chart = Chart {
        title: measurement_title(c),
        x_title: from_start(x_title, start),
        y_title: axis(&c.quantity.title, unit),
        x,
        y,
        layers,
        legend,
        readings,
        ..Chart::default()
    };
    (chart, format!("{}, measured and {}.{}", c.quantity.title, predicted_name(c), circumstances(c)))
}

/// Of every stretch of a movement the point of the largest error.
fn worst_of_stretches(c: &Comparison) -> Vec<&Point> {
    let used: Vec<&Point> = c.points.iter().filter(|p| p.status == PointStatus::Used && p.residual.is_some()).collect();
    let size = |p: &Point| p.residual.map_or(0.0, f64::abs);
    let stretches = used.chunks(used.len().div_ceil(STRETCHES).max(1));
    stretches.filter_map(|points| points.iter().copied().max_by(|a, b| size(a).total_cmp(&size(b)))).collect()
}

/// A point of a movement in words.
fn words(c: &Comparison, p: &Point, unit: Unit) -> Vec<String> {
    let run = if p.runs.is_empty() { String::new() } else { format!(", run {}", p.runs.join(", ")) };
    let head = [readings::heading(c, p) + &run, readings::measured(c, p, unit), readings::predicted(c, p, unit)];
    let name = if c.quantity.is_position() { "apart" } else { "error" };
    let residual = readings::residual(c, p, unit).and_then(|text| Some(text.split_once(": ")?.1.to_owned()));
    head.into_iter().chain(residual.map(|text| format!("{name} {text}"))).collect()
}

fn predicted_name(c: &Comparison) -> String {
    if c.kind == "none" { "not predicted".to_owned() } else { format!("predicted by {}", c.title) }
}

/// How much of it met, and how the prediction was moved, as sentences.
fn circumstances(c: &Comparison) -> String {
    let met = c.meeting.as_ref().map(crate::results::MeetingRecord::text);
    let moved = c.alignment.as_ref().map(|alignment| format!("Shown {}", alignment.text(c.quantity.unit())));
    let sentences: Vec<String> = met.into_iter().chain(moved).map(|text| format!(" {text}.")).collect();
    sentences.concat()
}

/// The error along the movement, against the bound on the largest.
fn errors(c: &Comparison) -> (Chart, String) {
    let unit = c.quantity.unit();
    let is_position = c.quantity.is_position();
    let (x_title, scale) = abscissa(c);
    let start = start_of(c, c.points.iter().filter_map(|p| p.at));
    let used = c.points.iter().filter(|p| p.status == PointStatus::Used);
    let mut runs: Vec<RunErrors> = Vec::new();
    for point in used {
        let Some((at, residual)) = point.at.zip(point.residual) else { continue };
        let place = (scale * (at - start), unit.from_si(residual));
        match runs.last_mut().filter(|(run, _)| *run == point.runs.as_slice()) {
            Some((_, line)) => line.push(place),
            None => runs.push((&point.runs, vec![place])),
        }
    }
    let every = || runs.iter().flat_map(|(_, line)| line);
    let bound = c.judgements.iter().find(|j| j.bound.metric == Metric::MaxAbsError).map(|j| unit.from_si(j.bound.max));
    let largest = every().map(|p| p.1.abs()).fold(0.0, f64::max);
    // A bound far beyond every error would flatten them; its value still stands in the legend.
    let reach = 1.1 * bound.filter(|bound| *bound < 5.0 * largest).map_or(largest, |bound| bound.max(largest));
    let reach = if reach > 0.0 && reach.is_finite() { reach } else { 1.0 };
    let x = spread(every().map(|p| p.0), 0.02);
    let (mut layers, mut legend) = (Vec::new(), Vec::new());
    if let Some(bound) = bound {
        let y = if is_position { 0.0 } else { -bound }..bound;
        layers.push(Layer::Band { x: x.clone(), y, ground: Ground::Bound });
        let text = format!("bound: |e| at most {}", format::with_unit(&format::short(bound), unit));
        legend.push(Key::band(text, Ground::Bound));
    }
    layers.push(Layer::Reference(vec![(x.start, 0.0), (x.end, 0.0)]));
    for (i, (run, line)) in runs.iter().take(RUNS_MAX).enumerate() {
        let text = if runs.len() > 1 { format!("{}, run {}", c.title, run.join(", ")) } else { c.title.clone() };
        legend.push(Key::line(text, Ink::Form(i)));
        layers.push(Layer::Trail { points: thinned(line), ink: Ink::Form(i) });
    }
    let what = if is_position {
        "how far the predicted position lies from the measured one"
    } else {
        "predicted minus measured, positive where the model is too high"
    };
    let said = worst_of_stretches(c).into_iter().filter_map(|p| {
        let at = (scale * (p.at? - start), unit.from_si(p.residual?));
        Some(Said { at, lines: words(c, p, unit), weight: p.residual?.abs() })
    });
    let readings = readings::columns(said.collect(), x.end - x.start);
    let chart = Chart {
        title: format!("{}: error", measurement_title(c)),
        x_title: from_start(x_title, start),
        y_title: if is_position {
            format!("Distance of predicted from measured / {}", unit_name(unit))
        } else {
            format!("Predicted − measured / {}", unit_name(unit))
        },
        x,
        y: if is_position { -0.04 * reach..reach } else { -reach..reach },
        layers,
        legend,
        readings,
        ..Chart::default()
    };
    let more =
        if runs.len() > RUNS_MAX { format!(" The first {RUNS_MAX} of {} runs.", runs.len()) } else { String::new() };
    (chart, format!("{}: {what}.{more}{}", c.quantity.title, circumstances(c)))
}

/// The two components of the widest ranges, in their order.
fn widest(all: &[&[f64]], width: usize) -> [usize; 2] {
    let range = |i: usize| {
        let values = all.iter().filter_map(|values| values.get(i)).copied();
        let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(v), b.max(v)));
        high - low
    };
    let mut order: Vec<usize> = (0..width).collect();
    order.sort_by(|a, b| range(*b).total_cmp(&range(*a)));
    let mut two = [order.first().copied().unwrap_or(0), order.get(1).copied().unwrap_or(1)];
    two.sort_unstable();
    two
}

/// A line thinned: of so many neighbours the first, the lowest and the highest.
fn thinned(line: &[(f64, f64)]) -> Vec<(f64, f64)> {
    if line.len() <= DRAWN_MAX {
        return line.to_vec();
    }
    let mut kept = Vec::new();
    for group in line.chunks(line.len().div_ceil(DRAWN_MAX / 3)) {
        let by = |a: &&(f64, f64), b: &&(f64, f64)| a.1.total_cmp(&b.1);
        let mut some: Vec<(f64, f64)> =
            [group.first(), group.iter().min_by(by), group.iter().max_by(by)].into_iter().flatten().copied().collect();
        some.sort_by(|a, b| a.0.total_cmp(&b.0));
        some.dedup();
        kept.extend(some);
    }
    kept.extend(line.last());
    kept
}
