//! The sentences of what was found while a log became channels.

use std::collections::BTreeSet;

use super::log::Part;
use super::{Channel, Session};
use crate::finding::{self, Finding, FindingKind, Severity};
use crate::manifest::{ChannelSpec, Instrument, ResponseSpec, RunSpec};
use crate::units::Unit;
use crate::watch::rounded;

/// The finding of samples that a calibration refuses.
pub(super) fn refusal(
    spec: &ChannelSpec,
    run: &RunSpec,
    instrument: &Instrument,
    logged: Unit,
    refused: &[(usize, f64)],
    part: &Part,
) -> Finding {
    let first: Vec<String> =
        refused.iter().take(5).map(|(i, raw)| format!("{raw} {} at {}", logged.symbol, part.place(*i))).collect();
    let more = if refused.len() > 5 { ", …" } else { "" };
    Finding {
        kind: FindingKind::OutOfCalibration,
        severity: Severity::Excluded,
        file: run.file.clone(),
        channel: Some(spec.id.clone()),
        spans: part.spans(refused.iter().map(|(i, _)| *i)),
        count: refused.len(),
        text: format!(
            "channel `{}` of run {}: {} of {} samples lie where {} is not calibrated: {}{more}",
            spec.id,
            run.id,
            refused.len(),
            part.samples(),
            instrument.title,
            first.join(", ")
        ),
    }
}

/// Samples that are no number in a file without lines: there it is the file that says so, and no cell that could be quoted. What is no
/// number in a text was told by its reader.
pub(super) fn no_value(spec: &ChannelSpec, run: &RunSpec, values: &[f64], part: &Part) -> Option<Finding> {
    if part.lines.rows() > 0 {
        return None;
    }
    let holes: Vec<usize> = (0..values.len()).filter(|&i| values[i].is_nan()).collect();
    let first = *holes.first()?;
    Some(Finding {
        kind: FindingKind::NoValue,
        severity: Severity::Excluded,
        file: run.file.clone(),
        channel: Some(spec.id.clone()),
        spans: part.spans(holes.iter().copied()),
        count: holes.len(),
        text: format!(
            "channel `{}` of run {}: {} of {} samples hold no number, the first at {}; left as holes",
            spec.id,
            run.id,
            holes.len(),
            values.len(),
            part.place(first)
        ),
    })
}

/// Samples at or beyond what an instrument can show.
pub(super) fn beyond_range(
    spec: &ChannelSpec,
    run: &RunSpec,
    instrument: &Instrument,
    values_si: &[f64],
    part: &Part,
) -> Option<Finding> {
    let (min, max) = instrument.range?;
    let (low, high) = (instrument.output.to_si(min), instrument.output.to_si(max));
    let outside: Vec<usize> = (0..values_si.len()).filter(|&i| values_si[i] < low || values_si[i] > high).collect();
    let first = *outside.first()?;
    Some(Finding {
        kind: FindingKind::OutOfRange,
        severity: Severity::Note,
        file: run.file.clone(),
        channel: Some(spec.id.clone()),
        spans: part.spans(outside.iter().copied()),
        count: outside.len(),
        text: format!(
            "channel `{}` of run {}: {} samples lie beyond the range of {}, {min} to {max} {}, the first at {}",
            spec.id,
            run.id,
            outside.len(),
            instrument.title,
            instrument.output.symbol,
            part.place(first)
        ),
    })
}

/// Pressures and measured channels of responses that have one value in every sample of every run: a note, for a single state may be
/// all that was asked for. From few samples nothing can be told.
pub(super) fn constant(session: &Session) -> Vec<Finding> {
    let of_response = |r: &ResponseSpec| -> Vec<String> {
        let pressures = r.pressure.iter().map(|(channel, _)| channel.clone());
        pressures.chain(r.measured.iter().cloned()).collect()
    };
    let needed: BTreeSet<String> = session.manifest.responses.iter().flat_map(of_response).collect();
    needed.iter().filter_map(|id| constant_channel(session, id)).collect()
}

fn constant_channel(session: &Session, id: &str) -> Option<Finding> {
    const SAMPLES_MIN: usize = 3;
    let runs = || session.runs.iter().filter_map(|run| Some((run, run.channels.get(id)?)));
    let mut values = runs().flat_map(|(_, channel)| &channel.values_si).copied().filter(|v| v.is_finite());
    let first = values.next()?;
    let mut count = 1;
    for value in values {
        // Minus zero is zero.
        if (value + 0.0).to_bits() != (first + 0.0).to_bits() {
            return None;
        }
        count += 1;
    }
    let (run, channel) = runs().next()?;
    (count >= SAMPLES_MIN).then(|| Finding {
        kind: FindingKind::Constant,
        severity: Severity::Note,
        file: run.files.first().cloned().unwrap_or_default(),
        channel: Some(id.to_owned()),
        spans: vec![],
        count,
        text: format!(
            "channel `{id}` is {} {} in all {count} samples of the session: did the sensor stop, or is it another column?",
            rounded(channel.unit.from_si(first)),
            channel.unit.symbol
        ),
    })
}

/// The finding of numbers that are not finite in SI.
pub(super) fn overflow(spec: &ChannelSpec, run: &RunSpec, beyond: &[usize], part: &Part) -> Finding {
    let first = beyond.first().map_or_else(String::new, |&i| part.place(i));
    Finding {
        kind: FindingKind::Overflow,
        severity: Severity::Excluded,
        file: run.file.clone(),
        channel: Some(spec.id.clone()),
        spans: part.spans(beyond.iter().copied()),
        count: beyond.len(),
        text: format!(
            "channel `{}` of run {}: {} numbers are too large for SI units, the first at {first}",
            spec.id,
            run.id,
            beyond.len()
        ),
    }
}

/// Takes the mean of the first samples as zero, and says so; without a number among them the whole channel is holes.
pub(super) fn tare(
    spec: &ChannelSpec,
    samples: usize,
    run: &RunSpec,
    channel: &mut Channel,
    findings: &mut Vec<Finding>,
) {
    let first: Vec<f64> = channel.values_si.iter().copied().take(samples).filter(|v| v.is_finite()).collect();
    let zero = first.iter().sum::<f64>() / first.len() as f64;
    channel.values_si.iter_mut().for_each(|v| *v -= zero);
    let name = format!("channel `{}` of run {}", spec.id, run.id);
    let (severity, count, text) = if first.is_empty() {
        let text = format!("{name}: none of its first {samples} samples is a number, so it has no zero");
        (Severity::Excluded, channel.values_si.len(), text)
    } else {
        let at = channel.unit.from_si(zero);
        let text =
            format!("{name}: zero is the mean of its first {} samples, {at} {}", first.len(), channel.unit.symbol);
        (Severity::Note, first.len(), text)
    };
    findings.push(Finding {
        kind: FindingKind::Tared,
        severity,
        file: run.file.clone(),
        channel: Some(spec.id.clone()),
        spans: vec![],
        count,
        text,
    });
}

/// Adds a counter's period behind every place where it started anew, as the session says it does; and says so.
pub(super) fn unwrapped(run: &RunSpec, clock: &str, part: &Part, stamps: &mut [f64], wrap_s: f64) -> Option<Finding> {
    let wraps = finding::unwrap(stamps, wrap_s);
    let first = *wraps.first()?;
    Some(Finding {
        kind: FindingKind::ClockWrap,
        severity: Severity::Note,
        file: run.file.clone(),
        channel: Some(clock.to_owned()),
        spans: part.spans(wraps.iter().copied()),
        count: wraps.len(),
        text: format!(
            "clock `{clock}` of run {}: starts anew {} times, the first at {}; {wrap_s} s are added each time, as session.toml says",
            run.id,
            wraps.len(),
            part.place(first)
        ),
    })
}
