//! Which rows of a prediction meet which samples of a measurement.

use pneuval_ingest::finding::median_step;
use pneuval_ingest::manifest::{Abscissa, ImportedModel, Matching, TrajectoryRule};

use super::{Path, Sample};
use crate::response::rounding_s;
use crate::results::RunMeetingRecord;

/// A measured step longer than so many usual ones is a gap.
const GAP_STEPS: f64 = 5.0;

/// A place on a measured path.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Place {
    /// Line of the log; of two samples, that of the first.
    pub line: usize,
    /// Pressures and components.
    pub row: Vec<f64>,
}

/// A row of the prediction and the place that it meets.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Pair {
    pub row: usize,
    /// Time in s, or share of the arc length.
    pub at: f64,
    pub place: Place,
}

/// What of a run meets.
pub(super) struct RunMet {
    pub pairs: Vec<Pair>,
    pub record: RunMeetingRecord,
}

fn blank(run: &str) -> RunMeetingRecord {
    RunMeetingRecord {
        run: run.to_owned(),
        n_matched: 0,
        n_available: 0,
        overlap: 0.0,
        met_twice: 0,
        n_outside: 0,
        n_in_gaps: 0,
        n_at_doubled_stamps: 0,
        gap_s: None,
        measured_s: None,
        predicted_s: None,
        measured_length_si: None,
        predicted_length_si: None,
    }
}

/// First and last, in order or not.
fn ends(values: &[f64]) -> Option<(f64, f64)> {
    Some((*values.first()?, *values.last()?))
}

/// At equal time: the stamps of a prediction, which rise, against those of a run, which never go back.
pub(super) fn at_time(path: &Path, predicted_s: &[f64], rule: &TrajectoryRule) -> RunMet {
    let stamps: Vec<f64> = path.samples.iter().map(|sample| sample.seconds).collect();
    let whole: Vec<&Sample> = path.samples.iter().filter(|s| s.is_whole() && s.seconds.is_finite()).collect();
    let mut record = RunMeetingRecord { predicted_s: ends(predicted_s), measured_s: ends(&stamps), ..blank(&path.run) };
    let pairs = match rule.matching {
        Matching::Nearest { within_s } => nearest(&whole, stamps.len(), predicted_s, within_s, &mut record),
        Matching::Interpolate => interpolated(&whole, &stamps, predicted_s, rule.gap_s, &mut record),
    };
    record.n_matched = pairs.len();
    RunMet { pairs, record }
}

/// Each stamp of the shorter series with the nearest of the longer one, the first of two that are as near. `samples` counts holes too:
/// what was lost shortens no series.
fn nearest(
    whole: &[&Sample],
    samples: usize,
    predicted_s: &[f64],
    within_s: f64,
    record: &mut RunMeetingRecord,
) -> Vec<Pair> {
    let measured_s: Vec<f64> = whole.iter().map(|sample| sample.seconds).collect();
    let is_prediction_shorter = predicted_s.len() <= samples;
    let (short, long) =
        if is_prediction_shorter { (predicted_s, &measured_s[..]) } else { (&measured_s[..], predicted_s) };
    let mut pairs = Vec::new();
    let mut met = vec![false; long.len()];
    for (i, stamp) in short.iter().enumerate() {
        let Some(j) = nearest_to(long, *stamp).filter(|j| (long[*j] - stamp).abs() <= within_s) else { continue };
        record.met_twice += usize::from(met[j]);
        met[j] = true;
        let (row, sample) = if is_prediction_shorter { (i, whole[j]) } else { (j, whole[i]) };
        let place = Place { line: sample.line, row: sample.row() };
        pairs.push(Pair { row, at: predicted_s[row], place });
    }
    record.n_available = predicted_s.len().min(samples);
    record.n_outside = record.n_available - pairs.len();
    record.overlap = share_of(pairs.len() as f64, record.n_available as f64);
    pairs
}

/// The nearest of stamps that never go back, the first of those that are as near.
fn nearest_to(stamps: &[f64], stamp: f64) -> Option<usize> {
    let after = stamps.partition_point(|s| *s < stamp);
    let first_of = |i: usize| stamps.partition_point(|s| *s < stamps[i]);
    let before = after.checked_sub(1).map(first_of);
    let distance = |i: &usize| (stamps[*i] - stamp).abs();
    before.into_iter().chain((after < stamps.len()).then_some(after)).min_by(|a, b| distance(a).total_cmp(&distance(b)))
}

/// The measurement on straight lines between its samples, at the stamps of the prediction.
fn interpolated(
    whole: &[&Sample],
    stamps: &[f64],
    predicted_s: &[f64],
    gap_s: Option<f64>,
    record: &mut RunMeetingRecord,
) -> Vec<Pair> {
    let gap_s = gap_s.or_else(|| median_step(stamps).map(|step| GAP_STEPS * step));
    record.gap_s = gap_s;
    record.n_available = predicted_s.len();
    let is_gap = |step: f64, at: f64| gap_s.is_none_or(|gap| step > gap + rounding_s(at));
    let mut pairs = Vec::new();
    for (row, &stamp) in predicted_s.iter().enumerate() {
        let after = whole.partition_point(|sample| sample.seconds <= stamp);
        let left = after.checked_sub(1).map(|i| whole[i]);
        let before_left = after.checked_sub(2).map(|i| whole[i]);
        let place = match (left, whole.get(after)) {
            (Some(left), _) if left.seconds.total_cmp(&stamp).is_eq() => {
                if before_left.is_some_and(|other| other.seconds.total_cmp(&stamp).is_eq()) {
                    record.n_at_doubled_stamps += 1;
                    continue;
                }
                Place { line: left.line, row: left.row() }
            }
            (Some(left), Some(right)) => {
                if is_gap(right.seconds - left.seconds, stamp) {
                    record.n_in_gaps += 1;
                    continue;
                }
                between(left, right, (stamp - left.seconds) / (right.seconds - left.seconds))
            }
            _ => {
                record.n_outside += 1;
                continue;
            }
        };
        pairs.push(Pair { row, at: stamp, place });
    }
    // The time in which there are both, of the shorter one's.
    let span = |ends: Option<(f64, f64)>| ends.map_or(0.0, |(first, last)| last - first);
    let (first, last) = record.predicted_s.unwrap_or_default();
    let both: f64 = whole
        .windows(2)
        .filter(|pair| !is_gap(pair[1].seconds - pair[0].seconds, pair[1].seconds))
        .map(|pair| (pair[1].seconds.min(last) - pair[0].seconds.max(first)).max(0.0))
        .sum();
    record.overlap = share_of(both, span(record.predicted_s).min(span(record.measured_s)));
    pairs
}

fn between(left: &Sample, right: &Sample, share: f64) -> Place {
    let row = left.row().iter().zip(right.row()).map(|(a, b)| a + share * (b - a)).collect();
    Place { line: left.line, row }
}

/// A share of a whole, which may be nothing.
fn share_of(part: f64, whole: f64) -> f64 {
    if whole > 0.0 { (part / whole).min(1.0) } else { 0.0 }
}

/// At equal arc length: the rows of a prediction, by the share of its path that lies before them, against the same share of a run's.
pub(super) fn at_arc_length(path: &Path, model: &ImportedModel, has_stamps: bool, rule: &TrajectoryRule) -> RunMet {
    let whole: Vec<&Sample> = path.samples.iter().filter(|sample| sample.is_whole()).collect();
    let rows = model.path();
    let predicted: Vec<&[f64]> = rows.iter().map(|&row| model.values_si[row].as_slice()).collect();
    let measured: Vec<&[f64]> = whole.iter().map(|sample| sample.measured.as_slice()).collect();
    let (along_predicted, along_measured) = (lengths(&predicted), lengths(&measured));
    let (predicted_length, measured_length) = (total(&along_predicted), total(&along_measured));
    let mut record = RunMeetingRecord {
        n_available: predicted.len(),
        measured_length_si: Some(measured_length),
        predicted_length_si: Some(predicted_length),
        predicted_s: if has_stamps { ends(model.over.rising()) } else { None },
        ..blank(&path.run)
    };
    let stamps: Vec<f64> = whole.iter().map(|sample| sample.seconds).collect();
    // Without a clock nobody knows of a gap.
    let gap_s = rule.gap_s.or_else(|| median_step(&stamps).map(|step| GAP_STEPS * step));
    record.gap_s = gap_s;
    record.measured_s = ends(&stamps).filter(|(first, last)| first.is_finite() && last.is_finite());
    let mut pairs = Vec::new();
    if measured_length > 0.0 && predicted_length > 0.0 && (measured_length + predicted_length).is_finite() {
        for (&row, along) in rows.iter().zip(&along_predicted) {
            let share = along / predicted_length;
            let wanted = share * measured_length;
            // The end of the path is its last sample, whatever rounding does.
            let after = along_measured.partition_point(|s| *s <= wanted).min(whole.len() - 1).max(1);
            let (left, right) = (whole[after - 1], whole[after]);
            let step = along_measured[after] - along_measured[after - 1];
            let inside = if step > 0.0 { ((wanted - along_measured[after - 1]) / step).clamp(0.0, 1.0) } else { 1.0 };
            let is_sample = inside.total_cmp(&0.0).is_eq() || inside.total_cmp(&1.0).is_eq();
            let time = right.seconds - left.seconds;
            if !is_sample && gap_s.is_some_and(|gap| time > gap + rounding_s(right.seconds)) {
                record.n_in_gaps += 1;
                continue;
            }
            pairs.push(Pair { row, at: share, place: between(left, right, inside) });
        }
    } else {
        record.n_outside = predicted.len();
    }
    record.n_matched = pairs.len();
    record.overlap = share_of(pairs.len() as f64, predicted.len() as f64);
    RunMet { pairs, record }
}

/// The way from the first position to each.
fn lengths(positions: &[&[f64]]) -> Vec<f64> {
    let mut along = 0.0;
    let mut lengths = Vec::with_capacity(positions.len());
    for (i, here) in positions.iter().enumerate() {
        if let Some(before) = i.checked_sub(1).map(|before| positions[before]) {
            along += here.iter().zip(before).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt();
        }
        lengths.push(along);
    }
    lengths
}

fn total(lengths: &[f64]) -> f64 {
    lengths.last().copied().unwrap_or(0.0)
}

/// The share of a path that lies before each of its positions; 0 on a path without length.
pub(super) fn shares(positions: &[&[f64]]) -> Vec<f64> {
    let lengths = lengths(positions);
    let total = total(&lengths);
    lengths.into_iter().map(|along| if total > 0.0 { along / total } else { 0.0 }).collect()
}

/// Where samples stand: their time, or their share of the path.
pub(super) fn abscissae(samples: &[&Sample], at: Abscissa) -> Vec<f64> {
    match at {
        Abscissa::ArcLength => shares(&samples.iter().map(|sample| sample.measured.as_slice()).collect::<Vec<_>>()),
        Abscissa::Time | Abscissa::Pressure => samples.iter().map(|sample| sample.seconds).collect(),
    }
}
