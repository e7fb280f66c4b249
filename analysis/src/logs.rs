//! `logs.parquet`: the channels of runs over time, thinned so that no extreme is lost, and where findings are in them.
//!
//! Of each stretch of samples the lowest and the highest are kept, in their order: a spike of one sample is as high after thinning as
//! before. A stretch without a number is a hole, and the line is broken there.

use std::collections::BTreeMap;

use pneuval_ingest::finding::{self, Finding};
use pneuval_ingest::manifest::{ChannelSpec, ColumnRef};
use pneuval_ingest::session::{Channel, Run, Session};
use pneuval_ingest::store::{Columns, Series};
use pneuval_ingest::units::Dimension;

use crate::align::AlignedRun;
use crate::results::{DatasetRecord, MarkRecord, Severity};
use crate::study::{Data, Study};

/// A channel of a run.
#[derive(Debug, Clone, PartialEq)]
pub struct Log {
    /// The session.
    pub dataset: String,
    /// The run.
    pub run: String,
    /// The channel.
    pub channel: String,
    /// Seconds since the first stamp of the run, and the value in SI units; NaN where the line is broken.
    pub points: Vec<(f64, f64)>,
}

/// Stretches of a channel, each of which leaves two points.
const STRETCHES: usize = 300;

/// Points of all channels together: of many sessions each has fewer.
const POINTS_MAX: usize = 120_000;

/// A channel keeps so many stretches, however many there are.
const STRETCHES_MIN: usize = 24;

/// Channels of a run that are kept: those that responses read or findings are about, pressures first.
const CHANNELS_MAX: usize = 6;

/// The logs of a session, and the places of its findings in them.
pub(crate) fn keep(study: &Study, dataset: &mut DatasetRecord, logs: &mut Vec<Log>) {
    let Data::Session(session) = &study.input.data else { return };
    let Some(record) = &mut dataset.session else { return };
    for aligned in &study.alignment.runs {
        let Some(record) = record.runs.iter_mut().find(|record| record.id == aligned.run.id) else { continue };
        let starts = starts(aligned);
        let findings = session.findings.iter().chain(&study.alignment.findings);
        record.marks = findings.flat_map(|finding| marks(finding, session, aligned, &starts)).collect();
        let is_read =
            |id: &str| session.manifest.responses.iter().any(|spec| spec.channels().any(|channel| channel == id));
        let is_flagged =
            |id: &str| record.marks.iter().any(|mark| matches!(mark.channels.as_slice(), [one] if one == id));
        let is_kept = |(id, _): &(&String, &Channel)| is_read(id) || is_flagged(id);
        let mut channels: Vec<(&String, &Channel)> = aligned.run.channels.iter().filter(is_kept).collect();
        // Pressures first, then what findings are about.
        channels.sort_by_key(|(id, channel)| {
            (channel.unit.dimension != Dimension::Pressure, !is_flagged(id), channel.commanded)
        });
        let timed = channels.into_iter().filter_map(|(id, channel)| {
            let start = starts.get(channel.stream).copied().flatten()?;
            Some((id, channel, aligned.seconds(channel.stream)?, start))
        });
        let timed: Vec<_> = timed.collect();
        record.channels_left_out = timed.len().saturating_sub(CHANNELS_MAX);
        let mut groups: Vec<Option<usize>> = Vec::new();
        for (id, channel, seconds, start) in timed.into_iter().take(CHANNELS_MAX) {
            let group = aligned.group(channel.stream);
            if !groups.contains(&group) {
                groups.push(group);
            }
            let samples: Vec<(f64, f64)> =
                seconds.iter().zip(&channel.values_si).map(|(t, v)| (t - start, *v)).collect();
            let points = thinned(&samples, STRETCHES);
            let (dataset, run) = (study.id.to_owned(), aligned.run.id.clone());
            logs.push(Log { dataset, run, channel: id.clone(), points });
        }
        record.clocks = groups.len();
    }
}

/// Thinner where there are many: what all of them keep stays within what a report may weigh.
pub(crate) fn thin(logs: &mut [Log]) {
    let stretches = (POINTS_MAX / 2 / logs.len().max(1)).max(STRETCHES_MIN);
    if stretches < STRETCHES {
        for log in logs {
            log.points = thinned(&log.points, stretches);
        }
    }
}

/// Per stream, the first stamp of all streams that can be set against it.
fn starts(aligned: &AlignedRun) -> Vec<Option<f64>> {
    let first = |stream: usize| {
        let finite = aligned.seconds(stream)?.iter().copied().filter(|t| t.is_finite());
        finite.min_by(f64::total_cmp)
    };
    let firsts: Vec<Option<f64>> = (0..aligned.run.streams.len()).map(first).collect();
    let mut of_groups: BTreeMap<Option<usize>, f64> = BTreeMap::new();
    for (stream, first) in firsts.iter().enumerate() {
        if let Some(first) = first {
            of_groups.entry(aligned.group(stream)).and_modify(|t| *t = t.min(*first)).or_insert(*first);
        }
    }
    (0..firsts.len()).map(|stream| of_groups.get(&aligned.group(stream)).copied()).collect()
}

/// Where a finding is in a run, in time.
fn marks(finding: &Finding, session: &Session, aligned: &AlignedRun, starts: &[Option<f64>]) -> Vec<MarkRecord> {
    let Some(stream) = stream_of(finding, aligned.run) else { return vec![] };
    let (Some(seconds), Some(start)) = (aligned.seconds(stream), starts.get(stream).copied().flatten()) else {
        return vec![];
    };
    let channels = channels_of(finding, session, aligned.run, stream);
    let mark = |span: &finding::Span| {
        // A sample without a stamp lies between its neighbours, or at the end that it has none beyond.
        let before = seconds.get(..=span.first_sample)?.iter().rev().find(|t| t.is_finite());
        let after = seconds.get(span.last_sample..)?.iter().find(|t| t.is_finite());
        let (from, to) = (before.or(after)?, after.or(before)?);
        Some(MarkRecord {
            kind: finding.kind.id().to_owned(),
            severity: match finding.severity {
                finding::Severity::Note => Severity::Note,
                finding::Severity::Excluded => Severity::Excluded,
                finding::Severity::Lost => Severity::Lost,
            },
            channels: channels.clone(),
            from_s: from.min(*to) - start,
            to_s: to.max(*from) - start,
        })
    };
    finding.spans.iter().filter_map(mark).collect()
}

/// The channel that a finding names by its id or its column, else all of the stream.
fn channels_of(finding: &Finding, session: &Session, run: &Run, stream: usize) -> Vec<String> {
    let is_named = |spec: &&ChannelSpec| matches!((&finding.channel, &spec.column), (Some(name), ColumnRef::Name(column)) if name == column);
    if let Some(id) = finding.channel.as_ref().filter(|id| run.channels.contains_key(*id)) {
        return vec![id.clone()];
    }
    let here = |id: &&str| run.channels.get(*id).is_some_and(|channel| channel.stream == stream);
    let specs = session.manifest.channels.iter().filter(is_named);
    let named: Vec<&str> = specs.map(|spec| spec.id.as_str()).filter(here).collect();
    let all = || run.channels.keys().map(String::as_str).filter(here).collect();
    let chosen: Vec<&str> = if named.is_empty() { all() } else { named };
    chosen.into_iter().map(str::to_owned).collect()
}

/// The stream that a finding is about, if that is certain.
fn stream_of(finding: &Finding, run: &Run) -> Option<usize> {
    let place = run.files.iter().position(|file| *file == finding.file)?;
    if let Some(channel) = finding.channel.as_ref().and_then(|id| run.channels.get(id)) {
        return Some(channel.stream);
    }
    let mut devices: Vec<Option<&str>> = run.streams.iter().map(|stream| stream.device.as_deref()).collect();
    devices.dedup();
    let device = if run.files.len() == 1 { None } else { Some(*devices.get(place)?) };
    let mut of_file = run.streams.iter().enumerate().filter(|(_, s)| device.is_none_or(|d| s.device.as_deref() == d));
    // Of several tables of one file nobody knows which is meant.
    let (stream, _) = of_file.next()?;
    of_file.next().is_none().then_some(stream)
}

/// The lowest and the highest of each of so many stretches, in their order; what is no number breaks the line.
pub fn thinned(samples: &[(f64, f64)], stretches: usize) -> Vec<(f64, f64)> {
    let is_number = |p: &&(f64, f64)| p.0.is_finite() && p.1.is_finite();
    let hole = (f64::NAN, f64::NAN);
    if samples.len() <= 2 * stretches {
        return samples.iter().map(|p| if is_number(&p) { *p } else { hole }).collect();
    }
    let mut kept: Vec<(f64, f64)> = Vec::new();
    for stretch in samples.chunks(samples.len().div_ceil(stretches.max(1))) {
        let by = |a: &&(f64, f64), b: &&(f64, f64)| a.1.total_cmp(&b.1);
        let low = stretch.iter().filter(is_number).min_by(by);
        let high = stretch.iter().filter(is_number).max_by(by);
        match (low, high) {
            (Some(low), Some(high)) if low.0 <= high.0 => kept.extend([*low, *high]),
            (Some(low), Some(high)) => kept.extend([*high, *low]),
            _ => kept.push(hole),
        }
    }
    kept
}

const COLUMNS: [&str; 5] = ["dataset", "run", "channel", "at_s", "value_si"];

/// Logs as columns: session, run, channel, seconds since the first stamp of the run, value in SI units; both are absent where a line
/// is broken.
pub fn to_columns(logs: &[Log]) -> Columns {
    let mut words: [Vec<String>; 3] = Default::default();
    let mut numbers: [Vec<Option<f64>>; 2] = Default::default();
    for log in logs {
        for (t, value) in &log.points {
            for (column, word) in words.iter_mut().zip([&log.dataset, &log.run, &log.channel]) {
                column.push(word.clone());
            }
            for (column, number) in numbers.iter_mut().zip([t, value]) {
                column.push(Some(*number).filter(|n| n.is_finite()));
            }
        }
    }
    let names = COLUMNS.iter().map(|name| (*name).to_owned());
    names.zip(words.map(Series::Text).into_iter().chain(numbers.map(Series::Number))).collect()
}

/// The logs of stored columns; `None` if they are not what [`to_columns`] writes.
pub fn from_columns(columns: &Columns) -> Option<Vec<Log>> {
    if !columns.iter().map(|(name, _)| name.as_str()).eq(COLUMNS) {
        return None;
    }
    let [(_, Series::Text(datasets)), (_, Series::Text(runs)), (_, Series::Text(channels)), times, values] =
        columns.as_slice()
    else {
        return None;
    };
    let (Series::Number(times), Series::Number(values)) = (&times.1, &values.1) else { return None };
    let mut logs: Vec<Log> = Vec::new();
    for (row, ((dataset, run), channel)) in datasets.iter().zip(runs).zip(channels).enumerate() {
        let is_same = |log: &Log| log.dataset == *dataset && log.run == *run && log.channel == *channel;
        if !logs.last().is_some_and(is_same) {
            let (dataset, run, channel) = (dataset.clone(), run.clone(), channel.clone());
            logs.push(Log { dataset, run, channel, points: vec![] });
        }
        let number = |column: &[Option<f64>]| column.get(row).map(|n| n.unwrap_or(f64::NAN));
        logs.last_mut()?.points.push((number(times)?, number(values)?));
    }
    Some(logs)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_spike_is_lost_and_holes_stay_holes() {
        let mut samples: Vec<(f64, f64)> = (0..600_000).map(|i| (f64::from(i), (f64::from(i) * 1e-4).sin())).collect();
        samples[123_457].1 = 9.0;
        samples[400_001].1 = -7.0;
        for sample in &mut samples[500_000..510_000] {
            sample.1 = f64::NAN;
        }
        for stretches in [STRETCHES, STRETCHES_MIN, 1] {
            let thin = thinned(&samples, stretches);
            assert!(thin.len() <= 2 * stretches);
            assert!(thin.contains(&(123_457.0, 9.0)) && thin.contains(&(400_001.0, -7.0)));
            assert!(thin.iter().filter(|p| p.0.is_finite()).map(|p| p.0).is_sorted());
            assert_eq!(thin.iter().any(|p| p.1.is_nan()), stretches == STRETCHES);
        }
        // Thinned twice as thinned once: extremes stay.
        assert!(thinned(&thinned(&samples, 300), 30).contains(&(123_457.0, 9.0)));
    }

    #[test]
    fn logs_come_back_as_they_were() {
        let log = |run: &str, points: Vec<(f64, f64)>| Log {
            dataset: "monday".into(),
            run: run.into(),
            channel: "pressure".into(),
            points,
        };
        let logs = vec![log("1", vec![(0.0, 1.0), (1.0, 2.0)]), log("2", vec![(0.0, -1.0)])];
        assert_eq!(from_columns(&to_columns(&logs)), Some(logs));
        let broken = vec![log("1", vec![(0.0, 1.0), (f64::NAN, f64::NAN), (2.0, 1.0)])];
        let back = from_columns(&to_columns(&broken)).unwrap();
        assert!(back[0].points[1].1.is_nan() && back[0].points.len() == 3);
        assert_eq!(from_columns(&vec![]), None);
    }
}
