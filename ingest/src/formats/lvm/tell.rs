//! What headers state and samples do not bear out, gathered over all segments.

use super::block::Held;
use super::header::{Header, number};
use super::layout::Layout;
use super::start::Start;
use crate::error::shown;
use crate::finding::places::Places;
use crate::finding::{Finding, FindingKind, Severity};
use crate::watch::rounded;

/// What was odd about headers, segment by segment.
#[derive(Debug, Default)]
pub(super) struct Odd {
    /// Fewer samples than stated, more than stated.
    fewer: Places,
    missing: usize,
    more: Places,
    /// Steps of X that are not those stated.
    steps: Places,
    /// Lines of names with another number of channels than stated.
    pub channels: Places,
    /// Rows at the end of a segment that hold nothing for a channel.
    shorter: Places,
    dropped: usize,
    /// Rows with an X where the first rows have none.
    pub ignored_x: Places,
    /// The decimal sign is not the one stated.
    pub decimal: Places,
    starts: Starts,
}

/// Starts of segments without X, and the samples between them.
#[derive(Debug, Default)]
struct Starts {
    last: Option<(Start, usize)>,
    step: f64,
    seconds: f64,
    rows: usize,
    segments: usize,
}

/// A part of a step by which the stated one may be off before it is told, and what a stamp of six decimals leaves open, in s.
const STEP_PART: f64 = 1e-3;
const PRINT_S: f64 = 1.5e-6;

/// Whether a stated step leads away from `steps` steps of which `mean` is the mean: by a part of each, or by a whole one in all.
fn is_off(stated: f64, mean: f64, steps: usize) -> bool {
    let (off, all) = ((stated - mean).abs(), (stated - mean).abs() * steps as f64);
    all > PRINT_S && (off > STEP_PART * mean.abs() || all > mean.abs())
}

impl Odd {
    /// A segment has ended. `line` is that of its names, `row` its last sample.
    pub fn segment(&mut self, held: &[Held], header: &Header, layout: &Layout, line: usize, row: usize) {
        let channels = layout.channels.len();
        let mut told_step = None;
        for held in held {
            let Some(channel) = layout.channels.get(held.channel) else { continue };
            let name = || shown(held.name);
            if held.dropped > 0 && held.is_first {
                self.dropped += held.dropped;
                self.shorter.add_said(row, line, || format!("{}, {} rows", name(), held.dropped));
            }
            let stated = header.of_channel("Samples", channel.column, held.channel, channels, true);
            let stated = stated.filter(|_| header.is_stated).and_then(number);
            if let Some(stated) = stated {
                let rows = held.rows as f64;
                let words = || format!("{}: {stated} stated, {} counted", name(), held.rows);
                if stated > rows {
                    // Stated numbers beyond what a file can hold are told as they are, and not added.
                    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
                    let missing = (stated - rows) as usize;
                    self.missing = self.missing.saturating_add(missing);
                    self.fewer.add_said(row, line, words);
                } else if stated < rows {
                    self.more.add_said(row, line, words);
                }
            }
            if let Some((mean, steps)) = held.mean_step
                && layout.is_time
                && let Some(step) = channel.step.map(|step| step * layout.unit_s)
                && told_step != Some((step, mean))
                && is_off(step, mean, steps)
            {
                told_step = Some((step, mean));
                let by = rounded(100.0 * (step - mean).abs() / mean.abs());
                let less = if step < mean { "less" } else { "more" };
                let words = || format!("{}: {step} s stated, {} s the mean of X, {by} % {less}", name(), rounded(mean));
                self.steps.add_said(row, line, words);
            }
        }
    }

    /// A segment without X has ended: when it began, its samples, and its step in s.
    pub fn implicit(&mut self, start: Option<Start>, rows: usize, step: f64) {
        let starts = &mut self.starts;
        if let (Some(start), Some((last, rows))) = (start, starts.last)
            && start.is_comparable(last)
        {
            let seconds = start.since(last.second) - last.fraction;
            if seconds > 0.0 {
                starts.seconds += seconds;
                starts.rows += rows;
                starts.segments += 1;
            }
        }
        if step.is_finite() && starts.step == 0.0 {
            starts.step = step;
        }
        starts.last = start.map(|start| (start, rows));
    }

    /// All of it as findings.
    pub fn finish(self, file: &str) -> Vec<Finding> {
        let mut findings = Vec::new();
        let mut tell = |places: Places, kind, severity, text: String| {
            if places.count() > 0 {
                findings.push(places.finding(kind, severity, file, None, text));
            }
        };
        let Self { fewer, more, steps, channels, shorter, ignored_x, decimal, starts, .. } = self;
        let text = format!(
            "{} fewer than `Samples` states {}: what is missing was never written, or the file was cut",
            if self.missing == 1 { "1 sample".to_owned() } else { format!("{} samples", self.missing) },
            fewer.listed()
        );
        tell(fewer, FindingKind::CountMismatch, Severity::Lost, text);
        let text = format!("more samples than `Samples` states {}; all are read", more.listed());
        tell(more, FindingKind::CountMismatch, Severity::Note, text);
        let text = format!("`Delta_X` is not the step of X {}; X counts", steps.listed());
        tell(steps, FindingKind::StepMismatch, Severity::Note, text);
        if starts.rows > 0 {
            let mean = starts.seconds / starts.rows as f64;
            if is_off(starts.step, mean, starts.rows) {
                let mut places = Places::default();
                places.add_worded(0, 0, String::new);
                let text = format!(
                    "`Delta_X` is {} s, but the starts of {} consecutive segments make {} s a sample, {} % off: it is rounded, or there are pauses between segments",
                    starts.step,
                    starts.segments + 1,
                    rounded(mean),
                    rounded(100.0 * (starts.step - mean).abs() / mean.abs())
                );
                tell(places, FindingKind::StepMismatch, Severity::Note, text);
            }
        }
        let text = format!("names and numbers of channels differ {}", channels.listed());
        tell(channels, FindingKind::HeaderMismatch, Severity::Note, text);
        let count = self.dropped;
        let text = format!(
            "{count} rows at the end of segments hold nothing for a channel that is shorter than others {}; they are no samples of it",
            shorter.listed()
        );
        if shorter.count() > 0 {
            let mut finding = shorter.finding(FindingKind::EmptyCell, Severity::Note, file, None, text);
            finding.count = count;
            findings.push(finding);
        }
        let mut tell = |places: Places, kind, severity, text: String| {
            if places.count() > 0 {
                findings.push(places.finding(kind, severity, file, None, text));
            }
        };
        let text = format!(
            "{} with a value where X would stand and the first rows have none {}; it is not used",
            ignored_x.counted("row", "rows"),
            ignored_x.listed()
        );
        tell(ignored_x, FindingKind::HeaderMismatch, Severity::Note, text);
        let text = format!("the decimal sign is not the one that the header states {}", decimal.listed());
        tell(decimal, FindingKind::HeaderMismatch, Severity::Note, text);
        findings
    }
}
