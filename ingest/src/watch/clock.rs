//! What can be said of a clock whose stamps go by once.

use super::sketch::Sketch;
use super::wrap::{self, Wrap};
use crate::error::shown;
use crate::finding::{Finding, FindingKind, LineMap, SPANS_MAX, Severity, Span};

/// A step is a gap if it is longer than this many median steps.
const GAP_STEPS: f64 = 5.0;

/// ... and longer than this, in s: at kHz rates a computer's clock moves a stamp by about a millisecond while no sample is missing.
const GAP_S_MIN: f64 = 1e-3;

/// Steps jitter if nine in ten of them differ by more than this many median steps.
const JITTER_STEPS: f64 = 0.5;

/// ... and by more than this, in s, where stamps are whole milliseconds: one more or less is not the clock's fault.
const JITTER_MS_STAMPS_S_MIN: f64 = 1.5e-3;

/// Of fewer steps nobody can say what nine in ten of them do.
const JITTER_STEPS_MIN: u64 = 20;

/// Long steps that are remembered.
const LONGEST_MAX: usize = 128;

/// Places named in a sentence; the spans hold more.
const NAMED_MAX: usize = 3;

/// A sample and its stamp in s.
pub(super) type Stamp = (usize, f64);

/// Samples of which something is said.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Places {
    /// Samples, all of them.
    pub count: usize,
    /// Runs of neighbouring samples, all of them.
    pub runs: usize,
    /// First and last sample of the first runs: at most [`SPANS_MAX`].
    pub first: Vec<(usize, usize)>,
    last: Option<usize>,
}

impl Places {
    /// Adds a sample behind all the others.
    pub(crate) fn push(&mut self, sample: usize) {
        self.count += 1;
        if self.last.is_some_and(|last| last + 1 == sample) {
            // The run that goes on may be one that is only counted.
            if self.runs == self.first.len()
                && let Some((_, last)) = self.first.last_mut()
            {
                *last = sample;
            }
        } else {
            self.runs += 1;
            if self.first.len() < SPANS_MAX {
                self.first.push((sample, sample));
            }
        }
        self.last = Some(sample);
    }

    /// The first runs in words: `sample 3 (line 5), samples 7 to 9 (lines 9 to 11)`.
    pub(crate) fn named(&self, lines: &LineMap) -> String {
        let runs = self.first.iter().map(|(first, last)| lines.between(*first, *last));
        listed(runs, self.runs, ", ")
    }

    pub(crate) fn spans(&self, lines: &LineMap) -> Vec<Span> {
        let mut spans = Vec::new();
        for (first, last) in &self.first {
            lines.extend(&mut spans, *first, *last);
        }
        spans
    }
}

/// The first few of a list, and how many more there are.
pub(crate) fn listed(items: impl Iterator<Item = String>, count: usize, between: &str) -> String {
    let mut named: Vec<String> = items.take(NAMED_MAX).collect();
    if count > named.len() {
        named.push(format!("and {} more", count - named.len()));
    }
    named.join(between)
}

/// A column of a file of which something is said.
pub(crate) struct Teller<'a> {
    pub file: &'a str,
    pub column: &'a str,
    pub lines: &'a LineMap,
}

impl Teller<'_> {
    pub fn tell(&self, kind: FindingKind, severity: Severity, count: usize, spans: Vec<Span>, text: &str) -> Finding {
        Finding {
            kind,
            severity,
            file: self.file.to_owned(),
            channel: Some(self.column.to_owned()),
            spans,
            count,
            text: format!("{}: {text}", shown(self.column)),
        }
    }

    pub fn places(&self, kind: FindingKind, severity: Severity, places: &Places, text: &str) -> Finding {
        self.tell(kind, severity, places.count, places.spans(self.lines), text)
    }
}

/// A step of time between two neighbouring samples that have a stamp.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Step {
    /// The samples before and after it.
    pub samples: (usize, usize),
    /// Their stamps, in s.
    pub seconds: (f64, f64),
}

impl Step {
    fn length_s(&self) -> f64 {
        self.seconds.1 - self.seconds.0
    }
}

/// Steps of a clock that never goes back: what is fed here in order is measured, counted and forgotten.
#[derive(Debug, Clone)]
pub(crate) struct Steps {
    last: Option<Stamp>,
    lengths: Sketch,
    /// Their sum, in s.
    total_s: f64,
    equal: Places,
    /// The longest steps so far and some that were among them; up to twice [`LONGEST_MAX`].
    longest: Vec<Step>,
    /// No step up to this length can be among the longest any more.
    floor_s: f64,
}

impl Default for Steps {
    fn default() -> Self {
        let lengths = Sketch::fine();
        Self { last: None, lengths, total_s: 0.0, equal: Places::default(), longest: Vec::new(), floor_s: 0.0 }
    }
}

impl Steps {
    /// The next sample, whose stamp is not before that of the last one.
    #[inline]
    pub fn push(&mut self, sample: usize, stamp: f64) {
        if let Some(before) = self.last {
            let length = stamp - before.1;
            if length > 0.0 {
                self.lengths.add(length);
                self.total_s += length;
                if length > self.floor_s {
                    self.remember(before, (sample, stamp));
                }
            } else {
                self.equal.push(sample);
            }
        }
        self.last = Some((sample, stamp));
    }

    fn remember(&mut self, from: Stamp, to: Stamp) {
        self.longest.push(Step { samples: (from.0, to.0), seconds: (from.1, to.1) });
        if self.longest.len() == 2 * LONGEST_MAX {
            self.cut();
        }
    }

    /// Keeps the longest; of equal ones the first.
    fn cut(&mut self) {
        self.longest.sort_by(|a, b| b.length_s().total_cmp(&a.length_s()).then(a.samples.cmp(&b.samples)));
        self.longest.truncate(LONGEST_MAX);
        if let (Some(shortest), LONGEST_MAX) = (self.longest.last(), self.longest.len()) {
            self.floor_s = shortest.length_s();
        }
    }

    /// `whole_ms`: whether all stamps are whole milliseconds.
    pub fn finish(mut self, whole_ms: bool) -> StepSummary {
        let sorted = self.lengths.sorted();
        let Some(usual_s) = self.lengths.median() else {
            return StepSummary { equal: self.equal, ..StepSummary::default() };
        };
        let gap_s = (GAP_STEPS * usual_s).max(GAP_S_MIN);
        self.cut();
        let mut gaps = self.longest;
        gaps.retain(|step| step.length_s() > gap_s);
        gaps.sort_by_key(|step| step.samples);
        // Those that are remembered are exact, beyond them the bins have to do.
        let gap_count = if gaps.len() < LONGEST_MAX {
            gaps.len()
        } else {
            gaps.len().max(usize::try_from(sorted.above(gap_s)).unwrap_or(usize::MAX))
        };
        let ordinary = self.lengths.count().saturating_sub(gap_count as u64);
        let spread_s = (ordinary >= JITTER_STEPS_MIN)
            .then(|| Some((sorted.ranked(ordinary / 20)?, sorted.ranked(ordinary - 1 - ordinary / 20)?)))
            .flatten();
        let jitters = spread_s.is_some_and(|(few, most)| {
            let spread = most - few;
            spread > JITTER_STEPS * usual_s && (spread > JITTER_MS_STAMPS_S_MIN || !whole_ms)
        });
        // Stamps of whole milliseconds take steps of 8 and 9 ms at 120 Hz: their mean is the rate, their median is not.
        let gaps_s: f64 = gaps.iter().map(Step::length_s).sum();
        let rate_hz = if gap_count == gaps.len() {
            (ordinary as f64 + self.equal.count as f64) / (self.total_s - gaps_s)
        } else {
            usual_s.recip()
        };
        let rate_hz = Some(rate_hz).filter(|rate| rate.is_finite() && *rate > 0.0);
        StepSummary { usual_s: Some(usual_s), rate_hz, spread_s, jitters, equal: self.equal, gap_count, gaps }
    }
}

/// What can be said of the steps of a clock that never goes back.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct StepSummary {
    /// The median step, in s, good to 0.02 %.
    pub usual_s: Option<f64>,
    /// Samples per second where none are missing, in Hz: one over the mean of the steps that are no gaps.
    pub rate_hz: Option<f64>,
    /// All but one in twenty steps are at least and at most so long, in s; gaps apart.
    pub spread_s: Option<(f64, f64)>,
    /// Whether that is much.
    pub jitters: bool,
    /// Samples with the stamp of the one before.
    pub equal: Places,
    /// Steps much longer than usual.
    pub gap_count: usize,
    /// The longest of them, in their order: at most 128.
    pub gaps: Vec<Step>,
}

impl StepSummary {
    pub(crate) fn findings(&self, tell: &Teller, span: Option<(usize, usize)>) -> Vec<Finding> {
        let mut findings = Vec::new();
        if self.equal.count > 0 {
            let (count, places) = (samples(self.equal.count), self.equal.named(tell.lines));
            let text = format!("{count} with the stamp of the one before: {places}");
            findings.push(tell.places(FindingKind::DuplicateStamp, Severity::Note, &self.equal, &text));
        }
        let Some(usual) = self.usual_s else { return findings };
        if self.gap_count > 0 {
            let named = self.gaps.iter().map(|gap| {
                let (length, (from, to)) = (milliseconds(gap.length_s()), gap.seconds);
                let at = tell.lines.between(gap.samples.0, gap.samples.1);
                format!("{length} ms from {} s to {} s, {at}", stamp(from), stamp(to))
            });
            let what = if self.gap_count == 1 { "a gap".to_owned() } else { format!("{} gaps", self.gap_count) };
            let named = listed(named, self.gap_count, "; ");
            let text = format!("{what} where the usual step is {} ms: {named}", milliseconds(usual));
            // Two gaps in a row share a sample and still are two.
            let spans = self.gaps.iter().take(SPANS_MAX).map(|gap| tell.lines.span(gap.samples.0, gap.samples.1));
            findings.push(tell.tell(FindingKind::Gap, Severity::Note, self.gap_count, spans.collect(), &text));
        }
        if let (true, Some((few, most)), Some((first, last))) = (self.jitters, self.spread_s, span) {
            let text = format!(
                "steps of time differ: nine in ten are between {} ms and {} ms long, the usual one {} ms",
                milliseconds(few),
                milliseconds(most),
                milliseconds(usual)
            );
            let spans = vec![tell.lines.span(first, last)];
            findings.push(tell.tell(FindingKind::Jitter, Severity::Note, last - first + 1, spans, &text));
        }
        findings
    }
}

/// Looks at stamps in s as they go by.
#[derive(Debug, Clone)]
pub struct ClockWatch {
    samples: usize,
    holes: Places,
    first: Option<Stamp>,
    /// The last stamp, and the one before it that counts. The last one is not among the steps yet: if the next one goes back behind it,
    /// but not behind the one before, then the last one was the wild one.
    last: Option<Stamp>,
    before: Option<Stamp>,
    back: usize,
    backs: Vec<Step>,
    wraps: wrap::Tally,
    whole_ms: bool,
    steps: Steps,
}

impl Default for ClockWatch {
    fn default() -> Self {
        Self {
            samples: 0,
            holes: Places::default(),
            first: None,
            last: None,
            before: None,
            back: 0,
            backs: Vec::new(),
            wraps: wrap::Tally::default(),
            whole_ms: true,
            steps: Steps::default(),
        }
    }
}

/// What can be said of a clock.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct ClockSummary {
    /// Stamps.
    pub samples: usize,
    /// The first and the last finite stamp, in s.
    pub span: Option<(f64, f64)>,
    /// Their samples.
    pub span_samples: Option<(usize, usize)>,
    /// Samples per second where none are missing, in Hz.
    pub rate_hz: Option<f64>,
    /// Samples without a finite stamp.
    pub holes: Places,
    /// Steps that go back.
    pub back_count: usize,
    /// The first of them: at most [`SPANS_MAX`].
    pub backs: Vec<Step>,
    /// A counter that began anew, if steps that go back look like one.
    pub wrap: Option<Wrap>,
    /// Whether all stamps are whole milliseconds.
    pub whole_ms: bool,
    /// The steps that go forward.
    pub steps: StepSummary,
}

impl ClockWatch {
    /// The next stamps; what is not finite is a hole.
    pub fn block(&mut self, seconds: &[f64]) {
        for stamp in seconds {
            let sample = self.samples;
            self.samples += 1;
            if stamp.is_finite() {
                self.stamp((sample, *stamp));
            } else {
                self.holes.push(sample);
            }
        }
    }

    #[inline]
    fn stamp(&mut self, next: Stamp) {
        self.whole_ms = self.whole_ms && is_whole_ms(next.1);
        match self.last {
            None => self.first = Some(next),
            Some(last) if next.1 >= last.1 => {
                self.steps.push(last.0, last.1);
                self.before = Some(last);
            }
            Some(last) => self.went_back(last, next),
        }
        self.last = Some(next);
    }

    #[cold]
    fn went_back(&mut self, last: Stamp, next: Stamp) {
        self.back += 1;
        if self.backs.len() < SPANS_MAX {
            self.backs.push(Step { samples: (last.0, next.0), seconds: (last.1, next.1) });
        }
        self.wraps.add(last.1, next.1);
        if self.before.is_none_or(|before| next.1 < before.1) {
            // Time begins anew behind it: the steps so far stand, and no step leads here.
            self.steps.push(last.0, last.1);
            self.steps.last = None;
            self.before = None;
        }
    }

    /// What can be said of them.
    pub fn finish(mut self) -> ClockSummary {
        if let Some(last) = self.last {
            self.steps.push(last.0, last.1);
        }
        let whole_ms = self.whole_ms && self.first.is_some();
        let steps = self.steps.finish(whole_ms);
        ClockSummary {
            samples: self.samples,
            span: self.first.zip(self.last).map(|(first, last)| (first.1, last.1)),
            span_samples: self.first.zip(self.last).map(|(first, last)| (first.0, last.0)),
            rate_hz: steps.rate_hz,
            holes: self.holes,
            back_count: self.back,
            wrap: steps.usual_s.and_then(|usual| self.wraps.judge(&self.backs, self.back, usual)),
            backs: self.backs,
            whole_ms,
            steps,
        }
    }
}

/// Whether a stamp is a whole number of milliseconds; stamps since 1970 are good to a quarter of a microsecond.
fn is_whole_ms(seconds: f64) -> bool {
    /// A double as large as this has no fraction: adding and taking it away again rounds, faster than `round`.
    const ROUNDS: f64 = 1.5 * (1_u64 << 52) as f64;
    let ms = seconds * 1e3;
    (ms - ((ms + ROUNDS) - ROUNDS)).abs() < 1e-3
}

impl ClockSummary {
    /// Whether these are the stamps of a clock: they go forward, but for a few.
    pub fn is_forward(&self) -> bool {
        self.span.is_some_and(|(first, last)| last > first || self.wrap.is_some())
            && self.back_count * 20 <= self.samples
    }

    /// What is odd about the clock, as findings of a column of a file: the same as
    /// [`clock_findings`](crate::finding::clock_findings) tells of all stamps, but where time goes back. Which samples are to be left
    /// out cannot be said of stamps that go by once: counted and named are the steps back, and the steps forward are those between
    /// neighbouring stamps.
    pub fn findings(&self, file: &str, column: &str, lines: &LineMap) -> Vec<Finding> {
        let tell = Teller { file, column, lines };
        let mut findings = Vec::new();
        findings.extend(self.holes_told(&tell));
        if let Some(first) = self.backs.first() {
            let times = if self.back_count == 1 { "once".to_owned() } else { format!("{} times", self.back_count) };
            let named = self.backs.iter().map(|back| lines.between(back.samples.1, back.samples.1));
            let text = format!(
                "time goes back {times}, first from {} s back to {} s: {}",
                stamp(first.seconds.0),
                stamp(first.seconds.1),
                listed(named, self.back_count, ", ")
            );
            let spans = self.backs.iter().map(|back| lines.span(back.samples.1, back.samples.1)).collect();
            findings.push(tell.tell(FindingKind::TimeReversed, Severity::Excluded, self.back_count, spans, &text));
        }
        findings.extend(self.wrap_told(&tell));
        findings.extend(self.steps.findings(&tell, self.span_samples));
        findings
    }

    pub(crate) fn holes_told(&self, tell: &Teller) -> Option<Finding> {
        let places = &self.holes;
        let text = format!("{} without a time stamp: {}", samples(places.count), places.named(tell.lines));
        (places.count > 0).then(|| tell.places(FindingKind::NoStamp, Severity::Excluded, places, &text))
    }

    pub(crate) fn wrap_told(&self, tell: &Teller) -> Option<Finding> {
        let wrap = self.wrap.as_ref()?;
        let times = if wrap.count == 1 { "once".to_owned() } else { format!("{} times", wrap.count) };
        let first = wrap.first.first()?;
        let named = wrap.first.iter().map(|step| tell.lines.between(step.samples.1, step.samples.1));
        let text = format!(
            "the clock looks like one that {}: it begins anew {times}, first behind {} s with {} s: {}; if that is so, write \
             `wrap = {{ value = {}, unit = \"{}\" }}` under `[clock]` in session.toml",
            wrap.looks_like,
            stamp(first.seconds.0),
            stamp(first.seconds.1),
            listed(named, wrap.count, ", "),
            wrap.value,
            wrap.unit
        );
        let spans = wrap.first.iter().map(|step| tell.lines.span(step.samples.0, step.samples.1)).collect();
        Some(tell.tell(FindingKind::ClockWrap, Severity::Note, wrap.count, spans, &text))
    }
}

/// Seconds as milliseconds to the microsecond, without zeros at the end.
pub(crate) fn milliseconds(seconds: f64) -> String {
    let text = format!("{:.3}", seconds * 1e3);
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

pub(crate) fn samples(count: usize) -> String {
    if count == 1 { "1 sample".to_owned() } else { format!("{count} samples") }
}

/// A stamp without the digits that conversion to seconds adds.
pub(crate) fn stamp(seconds: f64) -> String {
    let text = format!("{seconds:.6}");
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}
