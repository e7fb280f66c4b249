//! The channels of a run over time, each in a panel, with what was found in them.

use std::ops::Range;

use pneuval_ingest::finding::FindingKind;
use pneuval_ingest::units::{Dimension, Unit};

use super::readings::{self, Said};
use super::{axis, spread};
use crate::format;
use crate::logs::Log;
use crate::report::chart::{Chart, Ground, Ink, Key, Layer};
use crate::results::{DatasetRecord, MarkRecord, RunRecord, SessionRecord};

/// Height of a panel in px.
const PANEL_PX: f64 = 140.0;

/// More for the one that has the axis of time.
const AXIS_PX: f64 = 38.0;

/// Places of a panel whose values can be read, beside the findings.
const PLACES: usize = 6;

/// Runs in the order in which a reader should see them: those with the gravest findings first.
pub(super) fn runs_by_findings(session: &SessionRecord) -> Vec<&RunRecord> {
    let mut runs: Vec<&RunRecord> = session.runs.iter().collect();
    // Stable: else as they were made.
    runs.sort_by_key(|run| {
        run.marks.iter().map(|mark| mark.severity).min().map_or((1, None), |worst| (0, Some(worst)))
    });
    runs
}

/// The panels of a run, and what they show; none where nothing of it has a time.
pub(super) fn panels(dataset: &DatasetRecord, run: &RunRecord, logs: &[&Log]) -> Option<(Vec<Chart>, String)> {
    let session = dataset.session.as_ref()?;
    let unit_of = |id: &str| session.channels.iter().find(|c| c.id == id).and_then(|c| Unit::parse(&c.unit));
    // A line has two ends.
    let is_line = |log: &&Log| log.points.iter().filter(|p| is_drawable(p)).count() > 1;
    let lines = logs.iter().copied().filter(is_line);
    let shown: Vec<(&Log, Unit)> = lines.filter_map(|log| Some((log, unit_of(&log.channel)?))).collect();
    let times = shown.iter().flat_map(|(log, _)| log.points.iter().filter(|p| is_drawable(p)).map(|p| p.0));
    let time = spread(times, 0.01);
    let last = shown.len().checked_sub(1)?;
    let mut panels = Vec::new();
    for (i, (log, unit)) in shown.iter().enumerate() {
        panels.push(Chart {
            title: format!("{}, {}: channels over time", dataset.id, run.id),
            x_title: if i == last { "Time / s".to_owned() } else { String::new() },
            height_px: if i == last { PANEL_PX + AXIS_PX } else { PANEL_PX },
            ..panel(log, *unit, run, &time)
        });
    }
    if let Some(first) = panels.first_mut() {
        first.legend = legend(run);
    }
    let n = session.runs.len();
    let of = if n > 1 { format!("{}, one of {n} runs,", run.id) } else { run.id.clone() };
    let clocks = match run.clocks {
        0 | 1 => "on one clock from its first stamp on".to_owned(),
        n => format!("on {n} clocks, each from its own first stamp on: how they lie to one another is not known"),
    };
    let flagged = match run.marks.len() {
        0 => "no finding has a place in it".to_owned(),
        1 => "what a finding is about is shaded".to_owned(),
        n => format!("what {n} findings are about is shaded"),
    };
    let left_out = match run.channels_left_out {
        0 => String::new(),
        1 => " One more channel is not drawn.".to_owned(),
        n => format!(" {n} more channels are not drawn."),
    };
    let beyond = shown.iter().flat_map(|(log, _)| &log.points).filter(|p| p.1.is_finite() && !is_drawable(p)).count();
    let beyond = if beyond > 0 {
        format!(" Beyond any axis, and not drawn: {beyond} of the values kept.")
    } else {
        String::new()
    };
    let caption = format!(
        "Channels of {of} {clocks}; lowest and highest of each stretch of samples; {flagged}.{left_out}{beyond}"
    );
    Some((panels, caption))
}

/// What a sensor could say: beyond it an axis would show nothing else, or could not be divided.
fn is_drawable(point: &(f64, f64)) -> bool {
    point.0.abs() < 1e15 && point.1.abs() < 1e60
}

fn panel(log: &Log, unit: Unit, run: &RunRecord, time: &Range<f64>) -> Chart {
    let ink = if unit.dimension == Dimension::Pressure { Ink::Form(0) } else { Ink::Measured };
    let y = spread(log.points.iter().filter(|p| is_drawable(p)).map(|p| unit.from_si(p.1)), 0.08);
    let mine = || run.marks.iter().filter(|mark| mark.channels.contains(&log.channel));
    let mut layers: Vec<Layer> = Vec::new();
    for mark in mine() {
        layers.push(Layer::Band { x: mark.from_s..mark.to_s, y: y.clone(), ground: Ground::Flag });
    }
    // Nothing was measured in a gap, and no line leads across it.
    let gaps: Vec<&MarkRecord> = mine().filter(|mark| mark.kind == FindingKind::Gap.id()).collect();
    let joins = |a: &(f64, f64), b: &(f64, f64)| {
        is_drawable(a) && is_drawable(b) && !gaps.iter().any(|gap| a.0 <= gap.from_s && gap.to_s <= b.0)
    };
    for piece in log.points.chunk_by(joins).filter(|piece| piece.iter().all(is_drawable)) {
        let points = piece.iter().map(|(t, v)| (*t, unit.from_si(*v))).collect();
        layers.push(Layer::Trail { points, ink });
    }
    let middle = 0.5 * (y.start + y.end);
    let told = |mark: &MarkRecord| Said {
        at: (0.5 * (mark.from_s + mark.to_s), middle),
        lines: vec![
            format!("{}: {}", log.channel, mark.kind.replace('-', " ")),
            if mark.to_s > mark.from_s {
                format!("{} to {} s", format::fixed(mark.from_s, 3), format::fixed(mark.to_s, 3))
            } else {
                format!("at {} s", format::fixed(mark.from_s, 3))
            },
        ],
        weight: f64::INFINITY,
    };
    let said = mine().map(told).chain(values(log, unit)).collect();
    Chart {
        y_title: axis(&log.channel, unit),
        x: time.clone(),
        y,
        layers,
        readings: readings::columns(said, time.end - time.start),
        ..Chart::default()
    }
}

/// The value farthest from the mean of each of some stretches of a log.
fn values(log: &Log, unit: Unit) -> impl Iterator<Item = Said> {
    let numbers: Vec<(f64, f64)> = log.points.iter().filter(|p| is_drawable(p)).copied().collect();
    let mean = numbers.iter().map(|p| p.1).sum::<f64>() / numbers.len().max(1) as f64;
    let stretch = numbers.len().div_ceil(PLACES).max(1);
    let far = move |p: &(f64, f64)| (p.1 - mean).abs();
    let farthest = |some: &[(f64, f64)]| some.iter().max_by(|a, b| far(a).total_cmp(&far(b))).copied();
    let chosen: Vec<(f64, f64)> = numbers.chunks(stretch).filter_map(farthest).collect();
    chosen.into_iter().map(move |(t, v)| Said {
        at: (t, unit.from_si(v)),
        lines: vec![
            format!("{} s", format::fixed(t, 3)),
            format!("{}: {}", log.channel, format::with_unit(&format::significant(unit.from_si(v), 5), unit)),
        ],
        weight: far(&(t, v)),
    })
}

/// What is shaded, each kind of finding once.
fn legend(run: &RunRecord) -> Vec<Key> {
    let mut kinds: Vec<(&str, usize)> = Vec::new();
    for mark in &run.marks {
        match kinds.iter_mut().find(|(kind, _)| *kind == mark.kind) {
            Some((_, n)) => *n += 1,
            None => kinds.push((&mark.kind, 1)),
        }
    }
    let text = |(kind, n): (&str, usize)| {
        let times = if n > 1 { format!(", {n} places") } else { String::new() };
        Key::band(format!("finding: {}{times}", kind.replace('-', " ")), Ground::Flag)
    };
    kinds.into_iter().map(text).collect()
}
