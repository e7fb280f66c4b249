//! The findings of a time channel: stamps that are missing, go back, stand twice or leave gaps.

use super::{Finding, FindingKind, LineMap, Severity};
use crate::watch::{ClockWatch, Places, Steps, Teller, samples, stamp};

/// The median of the steps that go forward, in s. Steps to and from stamps that are not finite do not count, nor do equal stamps.
///
/// ```
/// use pneuval_ingest::finding::median_step;
/// assert_eq!(median_step(&[0.0, 0.25, 0.5, 0.5, 2.0]), Some(0.25));
/// assert_eq!(median_step(&[1.0]), None);
/// ```
pub fn median_step(seconds: &[f64]) -> Option<f64> {
    let mut steps: Vec<f64> =
        seconds.windows(2).map(|pair| pair[1] - pair[0]).filter(|s| s.is_finite() && *s > 0.0).collect();
    if steps.is_empty() {
        return None;
    }
    let middle = steps.len() / 2;
    let even = steps.len().is_multiple_of(2);
    let (below, upper, _) = steps.select_nth_unstable_by(middle, f64::total_cmp);
    let upper = *upper;
    let lower = if even { below.iter().copied().fold(f64::NEG_INFINITY, f64::max) } else { upper };
    Some(f64::midpoint(lower, upper))
}

/// Samples per second where none are missing, in Hz: one over the mean of the steps that are no gaps. Samples without a stamp and those
/// that go back do not count.
///
/// ```
/// use pneuval_ingest::finding::rate_hz;
/// assert_eq!(rate_hz(&[0.0, 0.5, 1.0, 7.0]), Some(2.0));
/// // 120 Hz in whole milliseconds.
/// assert_eq!(rate_hz(&[0.0, 0.008, 0.017, 0.025]), Some(120.0));
/// assert_eq!(rate_hz(&[1.0]), None);
/// ```
pub fn rate_hz(seconds: &[f64]) -> Option<f64> {
    let mut watch = ClockWatch::default();
    watch.block(seconds);
    watch.finish().rate_hz
}

/// The findings of a time channel in s, in this order:
///
/// - samples without a finite stamp: excluded;
/// - time that goes back: excluded are the fewest samples without which time never goes back, the later ones where there is a choice;
/// - steps back that look like a counter which began anew: noted;
/// - equal stamps in a row: noted;
/// - gaps between the samples that remain: noted. The first step of a file counts as any other;
/// - steps between them that differ much from each other: noted.
///
/// `lines` is `None` for files without lines. A clock that never goes back is read in one pass and nothing of it is copied.
///
/// ```
/// use pneuval_ingest::finding::{FindingKind, clock_findings};
/// let findings = clock_findings("r.csv", "t", &[0.0, 0.01, 0.02, 0.5, 0.51], None);
/// assert_eq!(findings[0].kind, FindingKind::Gap);
/// assert_eq!(findings[0].text, "`t`: a gap where the usual step is 10 ms: 480 ms from 0.02 s to 0.5 s, samples 2 to 3");
/// ```
pub fn clock_findings(file: &str, channel: &str, seconds: &[f64], lines: Option<&LineMap>) -> Vec<Finding> {
    let without_lines = LineMap::default();
    let lines = lines.unwrap_or(&without_lines);
    let mut watch = ClockWatch::default();
    watch.block(seconds);
    let watched = watch.finish();
    if watched.back_count == 0 {
        return watched.findings(file, channel, lines);
    }
    let tell = Teller { file, column: channel, lines };
    let forward = forward_samples(seconds);
    let mut back = Places::default();
    let mut steps = Steps::default();
    let mut kept = forward.iter().copied().peekable();
    for sample in (0..seconds.len()).filter(|i| seconds[*i].is_finite()) {
        if kept.next_if_eq(&sample).is_some() {
            steps.push(sample, seconds[sample]);
        } else {
            back.push(sample);
        }
    }
    let mut findings: Vec<Finding> = watched.holes_told(&tell).into_iter().collect();
    let first = back.first.first().map_or(0, |(first, _)| *first);
    // The nearest sample before it that counts; a run of samples may have gone back together.
    let before = forward[..forward.partition_point(|i| *i < first)].last().copied();
    let jump = match before.filter(|b| seconds[*b] > seconds[first]) {
        Some(before) => format!("from {} s back to {} s", stamp(seconds[before]), stamp(seconds[first])),
        None => format!("{} s stands before a smaller stamp", stamp(seconds[first])),
    };
    let text = format!("time goes back, first {jump}; {} left out: {}", samples(back.count), back.named(lines));
    findings.push(tell.places(FindingKind::TimeReversed, Severity::Excluded, &back, &text));
    findings.extend(watched.wrap_told(&tell));
    let span = forward.first().copied().zip(forward.last().copied());
    findings.extend(steps.finish(watched.whole_ms).findings(&tell, span));
    findings
}

/// The samples that [`clock_findings`] leaves in: those with a finite stamp, without which time would never go back.
pub fn forward_samples(seconds: &[f64]) -> Vec<usize> {
    let finite: Vec<usize> = (0..seconds.len()).filter(|i| seconds[*i].is_finite()).collect();
    longest_forward(seconds, &finite)
}

/// Turns the stamps of the samples that [`clock_findings`] leaves out into NaN. Where time never goes back nothing is copied.
///
/// ```
/// use pneuval_ingest::finding::leave_forward;
/// let mut seconds = [0.0, 1.0, f64::INFINITY, 0.5, 2.0];
/// leave_forward(&mut seconds);
/// assert!(seconds[2].is_nan() && seconds[3].is_nan());
/// assert_eq!([seconds[0], seconds[1], seconds[4]], [0.0, 1.0, 2.0]);
/// ```
pub fn leave_forward(seconds: &mut [f64]) {
    for stamp in seconds.iter_mut().filter(|t| !t.is_finite()) {
        *stamp = f64::NAN;
    }
    let mut latest = f64::NEG_INFINITY;
    let goes_back = seconds.iter().filter(|t| t.is_finite()).any(|t| {
        let back = *t < latest;
        latest = *t;
        back
    });
    if goes_back {
        let mut kept = forward_samples(seconds).into_iter().peekable();
        for (sample, stamp) in seconds.iter_mut().enumerate() {
            if kept.next_if_eq(&sample).is_none() {
                *stamp = f64::NAN;
            }
        }
    }
}

/// Adds what a counter lost when it began anew: behind every step back of more than half of `wrap_s` all stamps, in s, grow by
/// `wrap_s`. Gives the samples with which it began anew.
///
/// A stamp from before the wrap that was written behind it, which is a step forward of more than half of `wrap_s`, is left before the
/// wrap: [`clock_findings`] then tells that time goes back. A gap of more than half of `wrap_s` is therefore not seen as one. Stamps
/// that are not finite are passed over; a `wrap_s` that is not a positive number changes nothing.
///
/// ```
/// use pneuval_ingest::finding::unwrap;
/// let mut seconds = [86_399.5, f64::NAN, 0.25, 1.0];
/// assert_eq!(unwrap(&mut seconds, 86_400.0), [2]);
/// assert_eq!([seconds[0], seconds[2], seconds[3]], [86_399.5, 86_400.25, 86_401.0]);
/// ```
pub fn unwrap(seconds: &mut [f64], wrap_s: f64) -> Vec<usize> {
    let mut wrapped = Vec::new();
    if wrap_s.is_nan() || wrap_s <= 0.0 || wrap_s.is_infinite() {
        return wrapped;
    }
    let mut wraps = 0_u32;
    let mut before: Option<f64> = None;
    for (sample, stamp) in seconds.iter_mut().enumerate().filter(|(_, t)| t.is_finite()) {
        let step = *stamp - before.unwrap_or(*stamp);
        before = Some(*stamp);
        if step < -0.5 * wrap_s {
            wraps = wraps.saturating_add(1);
            wrapped.push(sample);
        } else if step > 0.5 * wrap_s {
            wraps = wraps.saturating_sub(1);
        }
        *stamp += f64::from(wraps) * wrap_s;
    }
    wrapped
}

/// The longest choice of samples whose stamps never go back, in order; where several are equally long, the one with the earlier
/// samples: what goes back is left out, not what it goes back behind.
///
/// Patience sorting from the end: `tops[k]` is the largest stamp with which a choice of `k + 1` samples can begin.
fn longest_forward(seconds: &[f64], finite: &[usize]) -> Vec<usize> {
    if finite.windows(2).all(|pair| seconds[pair[0]] <= seconds[pair[1]]) {
        return finite.to_vec();
    }
    let mut tops: Vec<usize> = Vec::new();
    let mut next: Vec<Option<usize>> = vec![None; finite.len()];
    for at in (0..finite.len()).rev() {
        let stamp = seconds[finite[at]];
        let length = tops.partition_point(|top| seconds[finite[*top]] >= stamp);
        next[at] = length.checked_sub(1).map(|shorter| tops[shorter]);
        if length == tops.len() {
            tops.push(at);
        } else {
            tops[length] = at;
        }
    }
    let mut chosen = Vec::with_capacity(tops.len());
    let mut at = tops.last().copied();
    while let Some(current) = at {
        chosen.push(finite[current]);
        at = next[current];
    }
    chosen
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::finding::SPANS_MAX;

    type Found = (FindingKind, Severity, usize, Vec<(usize, usize)>);

    fn found(seconds: &[f64]) -> Vec<Found> {
        clock_findings("r.csv", "t", seconds, None)
            .into_iter()
            .map(|f| (f.kind, f.severity, f.count, f.spans.iter().map(|s| (s.first_sample, s.last_sample)).collect()))
            .collect()
    }

    #[test]
    fn an_even_clock_has_no_finding() {
        assert_eq!(found(&[0.0, 0.01, 0.02, 0.0305, 0.04]), []);
        assert_eq!(found(&[]), []);
        assert_eq!(found(&[3.0]), []);
    }

    #[test]
    fn a_gap_in_the_first_step_is_found() {
        let seconds = [0.0, 0.273, 0.283, 0.293, 0.303];
        assert_eq!(found(&seconds), [(FindingKind::Gap, Severity::Note, 1, vec![(0, 1)])]);
        let mut lines = LineMap::default();
        (0..5).for_each(|row| lines.push(row + 1));
        let findings = clock_findings("r.csv", "t", &seconds, Some(&lines));
        assert_eq!(
            findings[0].text,
            "`t`: a gap where the usual step is 10 ms: 273 ms from 0 s to 0.273 s, samples 0 to 1 (lines 1 to 2)"
        );
    }

    #[test]
    fn jitter_below_a_millisecond_is_no_gap() {
        assert_eq!(found(&[0.0, 0.0001, 0.0002, 0.0011, 0.0012]), []);
        assert_eq!(found(&[0.0, 0.0001, 0.0002, 0.0013, 0.0014]).len(), 1);
    }

    #[test]
    fn what_goes_back_is_excluded_and_named() {
        let all = found(&[0.0, 1.0, 2.0, 1.5, 3.0]);
        assert_eq!(all, [(FindingKind::TimeReversed, Severity::Excluded, 1, vec![(3, 3)])]);
        let text = &clock_findings("r.csv", "t", &[0.0, 1.0, 2.0, 1.5, 3.0], None)[0].text;
        assert_eq!(text, "`t`: time goes back, first from 2 s back to 1.5 s; 1 sample left out: sample 3");
        // One wild stamp does not cost every sample behind it.
        let wild = found(&[0.0, 1.0, 99.0, 2.0, 3.0, 4.0]);
        assert_eq!(wild, [(FindingKind::TimeReversed, Severity::Excluded, 1, vec![(2, 2)])]);
        // A clock that starts anew: the shorter part is left out.
        let anew = found(&[0.0, 1.0, 2.0, 3.0, 0.0, 1.0]);
        assert_eq!(anew, [(FindingKind::TimeReversed, Severity::Excluded, 2, vec![(4, 5)])]);
    }

    #[test]
    fn equal_stamps_are_noted_and_missing_ones_excluded() {
        let nan = f64::NAN;
        assert_eq!(
            found(&[0.0, nan, 1.0, 1.0, 1.0, f64::INFINITY, 2.0]),
            [
                (FindingKind::NoStamp, Severity::Excluded, 2, vec![(1, 1), (5, 5)]),
                (FindingKind::DuplicateStamp, Severity::Note, 2, vec![(3, 4)]),
            ]
        );
    }

    #[test]
    fn spans_are_capped_and_the_count_is_not() {
        // Every second stamp goes back.
        let seconds: Vec<f64> = (0..100).map(|i| if i % 2 == 0 { f64::from(i) } else { f64::NAN }).collect();
        let all = found(&seconds);
        assert_eq!((all[0].2, all[0].3.len()), (50, SPANS_MAX));
    }

    #[test]
    fn the_median_is_of_steps_forward() {
        assert_eq!(median_step(&[0.0, 1.0, 4.0]), Some(2.0));
        assert_eq!(median_step(&[0.0, f64::NAN, 4.0]), None);
    }
}
