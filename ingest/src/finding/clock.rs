//! The findings of a time channel: stamps that are missing, go back, stand twice or leave gaps.

use super::{Finding, FindingKind, LineMap, SPANS_MAX, Severity, Span, extend};
use crate::error::shown;

/// A step is a gap if it is longer than this many median steps.
const GAP_STEPS: f64 = 5.0;

/// ... and longer than this, in s: at kHz rates a computer's clock moves a stamp by about a millisecond while no sample is missing.
const GAP_S_MIN: f64 = 1e-3;

/// Places named in a sentence; the spans hold more.
const NAMED_MAX: usize = 3;

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

/// The usual sample rate in Hz: one over [`median_step`].
///
/// ```
/// use pneuval_ingest::finding::median_rate_hz;
/// assert_eq!(median_rate_hz(&[0.0, 0.5, 1.0, 7.0]), Some(2.0));
/// ```
pub fn median_rate_hz(seconds: &[f64]) -> Option<f64> {
    median_step(seconds).map(f64::recip)
}

/// The findings of a time channel in s, in this order:
///
/// - samples without a finite stamp: excluded;
/// - time that goes back: excluded are the fewest samples without which time never goes back, the later ones where there is a choice;
/// - equal stamps in a row: noted;
/// - gaps between the samples that remain: noted. The first step of a file counts as any other.
///
/// `lines` is `None` for files without lines.
pub fn clock_findings(file: &str, channel: &str, seconds: &[f64], lines: Option<&LineMap>) -> Vec<Finding> {
    let clock = Clock { file, channel, seconds, lines };
    let mut findings = Vec::new();
    let finite: Vec<usize> = (0..seconds.len()).filter(|i| seconds[*i].is_finite()).collect();
    if finite.len() < seconds.len() {
        let holes: Vec<usize> = (0..seconds.len()).filter(|i| !seconds[*i].is_finite()).collect();
        let text = format!("{} without a time stamp: {}", samples(holes.len()), clock.listed(&holes));
        findings.push(clock.excluded(FindingKind::NoStamp, &holes, &text));
    }
    let forward = longest_forward(seconds, &finite);
    if forward.len() < finite.len() {
        let mut kept = forward.iter().copied().peekable();
        let back: Vec<usize> = finite.iter().copied().filter(|i| kept.next_if_eq(i).is_none()).collect();
        let first = back.first().copied().unwrap_or(0);
        // The nearest sample before it that counts; a run of samples may have gone back together.
        let before = forward[..forward.partition_point(|i| *i < first)].last().copied();
        let jump = match before.filter(|b| seconds[*b] > seconds[first]) {
            Some(before) => format!("from {} s back to {} s", stamp(seconds[before]), stamp(seconds[first])),
            None => format!("{} s stands before a smaller stamp", stamp(seconds[first])),
        };
        let text = format!("time goes back, first {jump}; {} left out: {}", samples(back.len()), clock.listed(&back));
        findings.push(clock.excluded(FindingKind::TimeReversed, &back, &text));
    }
    // Exactly equal is what is meant: the logger wrote the same stamp twice.
    #[expect(clippy::float_cmp)]
    let equal: Vec<usize> = forward.windows(2).filter(|p| seconds[p[0]] == seconds[p[1]]).map(|p| p[1]).collect();
    if !equal.is_empty() {
        let text = format!("{} with the stamp of the one before: {}", samples(equal.len()), clock.listed(&equal));
        findings.push(clock.finding(FindingKind::DuplicateStamp, Severity::Note, &equal, &text));
    }
    findings.extend(clock.gaps(&forward));
    findings
}

/// The samples that [`clock_findings`] leaves in: those with a finite stamp, without which time would never go back.
pub fn forward_samples(seconds: &[f64]) -> Vec<usize> {
    let finite: Vec<usize> = (0..seconds.len()).filter(|i| seconds[*i].is_finite()).collect();
    longest_forward(seconds, &finite)
}

/// A time channel with what its findings name.
struct Clock<'a> {
    file: &'a str,
    channel: &'a str,
    seconds: &'a [f64],
    lines: Option<&'a LineMap>,
}

impl Clock<'_> {
    fn line(&self, sample: usize) -> usize {
        self.lines.map_or(0, |lines| lines.line_of(sample))
    }

    fn finding(&self, kind: FindingKind, severity: Severity, samples: &[usize], text: &str) -> Finding {
        let mut spans = Vec::new();
        for sample in samples {
            let line = self.line(*sample);
            extend(&mut spans, Span { first_sample: *sample, last_sample: *sample, first_line: line, last_line: line });
        }
        Finding {
            kind,
            severity,
            file: self.file.to_owned(),
            channel: Some(self.channel.to_owned()),
            spans,
            count: samples.len(),
            text: format!("{}: {text}", shown(self.channel)),
        }
    }

    fn excluded(&self, kind: FindingKind, samples: &[usize], text: &str) -> Finding {
        self.finding(kind, Severity::Excluded, samples, text)
    }

    /// The first runs of samples: `sample 3 (line 5), samples 7 to 9 (lines 9 to 11)`.
    fn listed(&self, samples: &[usize]) -> String {
        let runs: Vec<&[usize]> = samples.chunk_by(|a, b| a + 1 == *b).collect();
        let mut named: Vec<String> = runs
            .iter()
            .take(NAMED_MAX)
            .filter_map(|run| Some((*run.first()?, *run.last()?)))
            .map(|(first, last)| self.between(first, last))
            .collect();
        if runs.len() > NAMED_MAX {
            named.push(format!("and {} more", runs.len() - NAMED_MAX));
        }
        named.join(", ")
    }

    fn between(&self, first: usize, last: usize) -> String {
        let (a, b) = (self.line(first), self.line(last));
        match (first == last, a == 0) {
            (true, true) => format!("sample {first}"),
            (true, false) => format!("sample {first} (line {a})"),
            (false, true) => format!("samples {first} to {last}"),
            (false, false) => format!("samples {first} to {last} (lines {a} to {b})"),
        }
    }

    fn gaps(&self, forward: &[usize]) -> Option<Finding> {
        let stamps: Vec<f64> = forward.iter().map(|i| self.seconds[*i]).collect();
        let usual = median_step(&stamps)?;
        let long = (GAP_STEPS * usual).max(GAP_S_MIN);
        let gaps: Vec<(usize, usize)> = forward
            .windows(2)
            .map(|pair| (pair[0], pair[1]))
            .filter(|(a, b)| self.seconds[*b] - self.seconds[*a] > long)
            .collect();
        if gaps.is_empty() {
            return None;
        }
        let mut named: Vec<String> = gaps
            .iter()
            .take(NAMED_MAX)
            .map(|(a, b)| {
                let (from, to) = (self.seconds[*a], self.seconds[*b]);
                let length = milliseconds(to - from);
                format!("{length} ms from {} s to {} s, {}", stamp(from), stamp(to), self.between(*a, *b))
            })
            .collect();
        if gaps.len() > NAMED_MAX {
            named.push(format!("and {} more", gaps.len() - NAMED_MAX));
        }
        let what = if gaps.len() == 1 { "a gap".to_owned() } else { format!("{} gaps", gaps.len()) };
        let text = format!("{what} where the usual step is {} ms: {}", milliseconds(usual), named.join("; "));
        let mut finding = self.finding(FindingKind::Gap, Severity::Note, &[], &text);
        finding.count = gaps.len();
        // Two gaps in a row share a sample and still are two.
        finding.spans = gaps
            .iter()
            .take(SPANS_MAX)
            .map(|(a, b)| Span {
                first_sample: *a,
                last_sample: *b,
                first_line: self.line(*a),
                last_line: self.line(*b),
            })
            .collect();
        Some(finding)
    }
}

/// Seconds as milliseconds to the microsecond, without zeros at the end.
fn milliseconds(seconds: f64) -> String {
    let text = format!("{:.3}", seconds * 1e3);
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

fn samples(count: usize) -> String {
    if count == 1 { "1 sample".to_owned() } else { format!("{count} samples") }
}

/// A stamp without the digits that conversion to seconds adds.
fn stamp(seconds: f64) -> String {
    let text = format!("{seconds:.6}");
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
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
        assert_eq!(median_rate_hz(&[0.0, 0.0, 0.0, 0.5, 0.5]), Some(2.0));
    }
}
