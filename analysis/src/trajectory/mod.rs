//! Movements: where a measured path meets a predicted one, and a prediction moved onto a measurement.
//!
//! ```text
//! Movement (a path per run), a table of rows --> meet() --> points where the two meet, and how much of them does
//! Response, Prediction ----------------------> align() --> the same prediction, turned and shifted
//! ```
//!
//! Nothing is shifted in time, nothing is interpolated across a gap or between two samples of one instant, and nothing is compared beyond
//! the ends of either. Runs are never merged: each meets the prediction on its own.

mod align;
mod matching;

pub(crate) use align::align;

use pneuval_ingest::manifest::{Abscissa, ImportedModel, Matching, Over};
use pneuval_ingest::number::Printed;

use crate::prediction::Predicted;
use crate::response::{IntervalKind, Movement, Repeat, Response, ResponsePoint};
use crate::results::{MeetingRecord, RunMeetingRecord};
use crate::series::{CurvePoint, Trace};
use crate::uncertainty::coverage::Z95;
use matching::{Place, RunMet};

/// The movement of one run.
#[derive(Debug, Clone, PartialEq)]
pub struct Path {
    /// The run.
    pub run: String,
    /// Its samples, in the order of the log.
    pub samples: Vec<Sample>,
}

/// A measured sample of a movement.
#[derive(Debug, Clone, PartialEq)]
pub struct Sample {
    /// Line of the log.
    pub line: usize,
    /// Its stamp; not a number where there is no clock.
    pub seconds: f64,
    /// Gauge pressure per chamber, in Pa; may be none.
    pub pressures: Vec<f64>,
    /// The value of each component; one that is no number makes it a hole.
    pub measured: Vec<f64>,
}

impl Sample {
    fn is_whole(&self) -> bool {
        self.measured.iter().chain(&self.pressures).all(|v| v.is_finite())
    }

    /// Pressures and components together.
    fn row(&self) -> Vec<f64> {
        self.pressures.iter().chain(&self.measured).copied().collect()
    }
}

/// Where a movement meets its prediction.
pub(crate) struct Met {
    /// The response with the points where it does.
    pub response: Response,
    /// The prediction at each of them.
    pub at: Vec<Predicted>,
    /// How much of it does.
    pub record: MeetingRecord,
}

/// Where the movements of a response meet the rows of a table. `None` for a response that is compared at pressures.
pub(crate) fn meet(response: &Response, model: &ImportedModel) -> Option<Met> {
    let movement = response.movement.as_ref()?;
    let (mut points, mut at, mut runs) = (Vec::new(), Vec::new(), Vec::new());
    let rule = movement.rule;
    for (index, path) in movement.paths.iter().enumerate() {
        let RunMet { pairs, record } = match (rule.at, &model.over) {
            (Abscissa::Time, over) => matching::at_time(path, over.rising(), &rule),
            (_, over) => matching::at_arc_length(path, model, matches!(over, Over::Time { .. }), &rule),
        };
        for pair in pairs {
            points.push(point(movement, index, pair.at, &pair.place));
            at.push(Predicted::Value(row_of(model, pair.row)));
        }
        runs.push(record);
    }
    let record = MeetingRecord {
        within_s: match rule.matching {
            Matching::Nearest { within_s } => Some(within_s),
            Matching::Interpolate => None,
        },
        overlap: runs.iter().map(|run: &RunMeetingRecord| run.overlap).min_by(f64::total_cmp).unwrap_or(0.0),
        overlap_min: rule.overlap_min,
        runs,
    };
    Some(Met { response: Response { points, ..response.clone() }, at, record })
}

/// The samples of a movement as points: what is shown where nothing predicts it.
pub(crate) fn samples(response: &Response, limit: usize) -> Option<Response> {
    let movement = response.movement.as_ref()?;
    let mut points = Vec::new();
    for (index, path) in movement.paths.iter().enumerate() {
        let whole: Vec<&Sample> = path.samples.iter().filter(|sample| sample.is_whole()).collect();
        let places = matching::abscissae(&whole, movement.rule.at);
        points.extend(
            whole
                .iter()
                .zip(places)
                .map(|(sample, at)| point(movement, index, at, &Place { line: sample.line, row: sample.row() })),
        );
    }
    // As many as are shown of any other response.
    let step = points.len().div_ceil(limit).max(1);
    let points = points.into_iter().step_by(step).collect();
    Some(Response { points, ..response.clone() })
}

/// The values of a row of a table, with their 95 % intervals.
fn row_of(model: &ImportedModel, row: usize) -> Vec<Printed> {
    let std = |i: usize| model.std_si.as_ref().map_or(0.0, |std| std[row][i]);
    let value = |(i, si): (usize, &f64)| Printed { si: *si, half_width_si: Z95 * std(i) };
    model.values_si[row].iter().enumerate().map(value).collect()
}

/// A place on the movement of a run, by the index of its path.
fn point(movement: &Movement, path: usize, at: f64, place: &Place) -> ResponsePoint {
    let chambers = place.row.len() - movement.std_si.len();
    let (pressures, measured) = place.row.split_at(chambers);
    let value = |(si, std): (&f64, &Option<f64>)| Printed { si: *si, half_width_si: Z95 * std.unwrap_or(0.0) };
    ResponsePoint {
        line: place.line,
        runs: movement.paths.get(path).map(|path| path.run.clone()).into_iter().collect(),
        pressures_gauge_pa: pressures.to_vec(),
        at: Some(at),
        conditions: vec![],
        measured: Some(measured.iter().zip(&movement.std_si).map(value).collect()),
        // One sample of one run: it has no scatter.
        interval: if movement.std_si.iter().all(Option::is_some) {
            IntervalKind::Instrument
        } else {
            IntervalKind::Unknown
        },
        branch: None,
        is_apart: false,
        repeats: vec![Repeat {
            index: path,
            measured: measured.to_vec(),
            pressures_gauge_pa: pressures.to_vec(),
            conditions: vec![],
        }],
    }
}

/// Samples of a drawn path, components of all of them counted.
const DRAWN_MAX: usize = 4_000;

/// The whole paths, for figures: that of the prediction, then that of each run.
pub(crate) fn traces(movement: &Movement, model: &ImportedModel) -> Vec<Trace> {
    let values: Vec<Vec<f64>> = model.path().into_iter().map(|row| model.values_si[row].clone()).collect();
    let places = match movement.rule.at {
        // Stamps rise.
        Abscissa::Time => model.over.rising().to_vec(),
        _ => matching::shares(&values.iter().map(Vec::as_slice).collect::<Vec<_>>()),
    };
    let mut traces = vec![drawn(&places, &values)];
    for path in &movement.paths {
        let whole: Vec<&Sample> = path.samples.iter().filter(|sample| sample.is_whole()).collect();
        let places = matching::abscissae(&whole, movement.rule.at);
        traces.push(drawn(&places, &whole.iter().map(|sample| sample.measured.clone()).collect::<Vec<_>>()));
    }
    traces
}

/// A path thinned: of so many neighbours the first, and the least and the largest of each component.
fn drawn(places: &[f64], values: &[Vec<f64>]) -> Trace {
    let width = values.first().map_or(1, Vec::len);
    let most = DRAWN_MAX / width;
    let group = if values.len() > most { values.len().div_ceil(most / (1 + 2 * width)) } else { 1 };
    let mut kept: Vec<usize> = Vec::new();
    for start in (0..values.len()).step_by(group) {
        let here = start..(start + group).min(values.len());
        let mut some = vec![start];
        for component in 0..width {
            let value = |row: &usize| values.get(*row).and_then(|row| row.get(component)).copied().unwrap_or(f64::NAN);
            let by = |a: &usize, b: &usize| value(a).total_cmp(&value(b));
            some.extend(here.clone().min_by(by));
            some.extend(here.clone().max_by(by));
        }
        some.sort_unstable();
        some.dedup();
        kept.extend(some);
    }
    // The end of a path is seen.
    kept.extend(values.len().checked_sub(1).filter(|last| kept.last() != Some(last)));
    let point = |i: usize| CurvePoint { share: places[i], values: values[i].clone() };
    Trace { points: kept.into_iter().map(point).collect() }
}
