//! What can be said of a column without keeping it: numbers go by once, in blocks, in bounded memory.
//!
//! [`Watch`] looks at the numbers of any column, [`ClockWatch`] at the stamps of one that is a clock. What they say does not depend on
//! how the numbers are cut into blocks. A finding is told where clean logs give none: noise, ramps, plateaus that a converter cannot tell
//! apart, commands, counters and resting gauges are not odd.

mod block;
mod clock;
mod grid;
mod sketch;
mod stays;
mod wrap;

pub use clock::{ClockSummary, ClockWatch, Places, Step, StepSummary};
pub(crate) use clock::{Steps, Teller, samples, stamp};
pub use stays::{End, Stay};
pub use wrap::Wrap;

use crate::finding::{Finding, FindingKind, LineMap, Severity};
use block::{At, BLOCK, LONG, Runs, Scan, Zigzags, scan, wobble, zigzags};
use clock::listed;
use grid::Grid;
use sketch::Sketch;
use stays::{Channel, Stays};

/// A column that covers fewer steps of its grid than this is told.
const STEPS_FEW: f64 = 50.0;

/// ... unless it is a switch, which has one step only.
const STEPS_MIN: f64 = 1.5;

/// Measured values go to and fro between steps at least so often, and at least every so many stretches, of which at least one in so many
/// lasts for a single sample: commands and states do neither.
const ZIGZAGS_MIN: u64 = 10;
const ZIGZAGS_SHARE: u64 = 5;
const SINGLES_SHARE: u64 = 10;

/// The mean size of a second difference of noise whose standard deviation is 1.
const WOBBLE_OF_NOISE: f64 = 1.954_41;

/// ... and most steps are no longer than one of the grid, or than this share of the range: settings in a table are in any order.
const NEAR_STEPS: f64 = 1.5;
const NEAR_SHARE: f64 = 0.25;

/// Looks at the numbers of a column as they go by.
///
/// ```
/// use pneuval_ingest::watch::Watch;
/// let mut watch = Watch::default();
/// watch.block(&[1.0, f64::NAN]);
/// watch.block(&[3.0]);
/// let summary = watch.finish();
/// assert_eq!((summary.samples, summary.holes, summary.range, summary.mean), (3, 1, Some((1.0, 3.0)), Some(2.0)));
/// ```
#[derive(Debug, Clone, Default)]
pub struct Watch {
    /// Numbers that wait until a block is full; empty as long as blocks come full.
    waiting: Vec<f64>,
    seen: Seen,
}

/// What is remembered of the blocks that went by.
#[derive(Debug, Clone, Default)]
struct Seen {
    samples: usize,
    numbers: u64,
    range: Option<(f64, f64)>,
    mean: f64,
    stays: Stays,
    blocks: usize,
    nature: Nature,
}

/// What a column is like from number to number. The first blocks are looked at whole, of later ones a part: a channel does not change its
/// nature from one millisecond to the next.
#[derive(Debug, Clone)]
struct Nature {
    /// Runs of equal numbers, those of them that are a single number, and the longest of the short ones.
    runs: u64,
    singles: u64,
    short: usize,
    zigzags: Zigzags,
    grid: Grid,
    /// The wobble of parts that wobble, and how many do not.
    wobbles: Sketch,
    still: u64,
}

impl Default for Nature {
    fn default() -> Self {
        Self {
            runs: 0,
            singles: 0,
            short: 1,
            zigzags: Zigzags::default(),
            grid: Grid::default(),
            wobbles: Sketch::coarse(),
            still: 0,
        }
    }
}

/// Blocks that are looked at whole, and how many parts later ones have.
const WHOLE_BLOCKS: usize = 16;
const PARTS: usize = 16;
const PART: usize = BLOCK / PARTS;

/// What can be said of the numbers of a column.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Summary {
    /// Cells.
    pub samples: usize,
    /// Cells without a finite number.
    pub holes: usize,
    /// The smallest and the largest number, if there is one.
    pub range: Option<(f64, f64)>,
    /// The mean of the numbers; `None` also where they are too large to be added.
    pub mean: Option<f64>,
    /// The step of the grid on which the numbers stand, that of the converter or of print; `None` if they stand on none, or if there are
    /// too few different ones to say.
    pub quantum: Option<f64>,
    /// The standard deviation of the noise from sample to sample: the median of those of blocks. Bends of a signal that is sampled coarsely
    /// count as noise; 0 for a column that is still or straight half of the time.
    pub noise: Option<f64>,
    /// Whether the numbers go to and fro between neighbouring steps of their grid, as those of sensors do and commands do not.
    pub flickers: bool,
    /// Values on which the column stays for unusually long, while it varies elsewhere.
    pub stays: Vec<Stay>,
}

impl Watch {
    /// The next numbers; what is not finite is a hole.
    pub fn block(&mut self, values: &[f64]) {
        let mut values = values;
        if !self.waiting.is_empty() {
            let (now, later) = values.split_at(values.len().min(BLOCK - self.waiting.len()));
            self.waiting.extend_from_slice(now);
            values = later;
            if self.waiting.len() == BLOCK {
                self.seen.block(&self.waiting);
                self.waiting.clear();
            }
        }
        let (blocks, rest) = values.as_chunks::<BLOCK>();
        for block in blocks {
            self.seen.block(block);
        }
        self.waiting.extend_from_slice(rest);
    }

    /// Numbers so far.
    pub fn samples(&self) -> usize {
        self.seen.samples + self.waiting.len()
    }

    /// What can be said of them.
    pub fn finish(mut self) -> Summary {
        self.seen.block(&self.waiting);
        self.seen.finish()
    }
}

impl Seen {
    fn block(&mut self, values: &[f64]) {
        let first = self.samples;
        self.samples += values.len();
        let whole = scan(values);
        if whole.finite {
            return self.numbers(values, &whole, At::From(first));
        }
        let (samples, numbers): (Vec<usize>, Vec<f64>) =
            (first..).zip(values.iter().copied()).filter(|(_, v)| v.is_finite()).unzip();
        self.numbers(&numbers, &scan(&numbers), At::Listed(&samples));
    }

    /// The finite numbers of a block.
    fn numbers(&mut self, values: &[f64], seen: &Scan, at: At) {
        if values.is_empty() {
            return;
        }
        let count = values.len() as u64;
        self.numbers += count;
        let (min, max) = self.range.unwrap_or((seen.min, seen.max));
        self.range = Some((min.min(seen.min), max.max(seen.max)));
        self.mean += (seen.sum / count as f64 - self.mean) * (count as f64 / self.numbers as f64);
        self.stays.block(values, at);
        let block = self.blocks;
        self.blocks += 1;
        if block < WHOLE_BLOCKS {
            self.nature.look::<{ BLOCK + 1 }>(values);
        } else {
            // Another part each time, or what repeats with the blocks would never show.
            let from = (block * 5 % PARTS) * PART;
            self.nature.look::<{ PART + 1 }>(values.get(from..).unwrap_or_default());
        }
    }

    fn finish(self) -> Summary {
        let Nature { runs, singles, short, zigzags, ref grid, .. } = self.nature;
        let quantum = grid.step();
        let noise = self.nature.noise();
        let span = self.range.map_or(0.0, |(min, max)| max - min);
        let near = (NEAR_SHARE * span).max(NEAR_STEPS * quantum.unwrap_or(0.0));
        let restless = singles >= (runs / SINGLES_SHARE).max(1);
        let stays = self.range.map_or_else(Vec::new, |range| {
            let short = short as u64;
            let wobble = noise.unwrap_or(0.0) * WOBBLE_OF_NOISE;
            self.stays.judge(&Channel { wobble, range, numbers: self.numbers, zigzags, short, quantum, runs, restless })
        });
        Summary {
            samples: self.samples,
            holes: self.samples - usize::try_from(self.numbers).unwrap_or(self.samples),
            range: self.range,
            mean: Some(self.mean).filter(|mean| self.numbers > 0 && mean.is_finite()),
            quantum,
            noise,
            flickers: zigzags.all >= ZIGZAGS_MIN.max(runs / ZIGZAGS_SHARE) && restless && grid.follows(near),
            stays,
        }
    }
}

impl Nature {
    /// Looks at the first numbers, fewer than `SIZE`.
    fn look<const SIZE: usize>(&mut self, values: &[f64]) {
        let values = &values[..values.len().min(SIZE - 1)];
        match wobble(values) {
            Some(mean) if mean > 0.0 => self.wobbles.add(mean),
            Some(_) => self.still += 1,
            None => {}
        }
        let runs = Runs::<SIZE>::new(values);
        self.runs += runs.values().len() as u64;
        self.singles += runs.lengths().map(|length| u64::from(length == 1)).sum::<u64>();
        self.short = runs.lengths().filter(|length| *length < LONG).fold(self.short, usize::max);
        let zigzags = zigzags(runs.values());
        self.zigzags.all += zigzags.all;
        self.zigzags.loose += zigzags.loose;
        self.grid.probe(runs.values());
    }

    fn noise(&self) -> Option<f64> {
        // Parts that do not wobble are the least of all.
        let middle = u64::midpoint(self.still, self.wobbles.count());
        match middle.checked_sub(self.still) {
            None => Some(0.0),
            Some(rank) => self.wobbles.sorted().ranked(rank).map(|wobble| wobble / WOBBLE_OF_NOISE),
        }
    }
}

impl Summary {
    /// The one value that the column has throughout, if it has.
    ///
    /// ```
    /// use pneuval_ingest::recording::{Cells, Column};
    /// let column = Column::new("variance", None, Cells::Numbers(vec![0.25, f64::NAN, 0.25]));
    /// assert_eq!(column.summary.constant(), Some(0.25));
    /// ```
    #[expect(clippy::float_cmp)]
    pub fn constant(&self) -> Option<f64> {
        self.range.filter(|(min, max)| min == max && self.samples > self.holes + 1).map(|(min, _)| min)
    }

    /// How many steps of its grid the column covers.
    pub fn steps(&self) -> Option<f64> {
        let (quantum, (min, max)) = self.quantum.zip(self.range)?;
        Some(((max - min) / quantum).round())
    }

    /// What is odd about the numbers, as findings of a column of a file, in this order; all are notes:
    ///
    /// - the column stays at an end of its range for far longer than on any other value, while its noise is seen elsewhere;
    /// - the same within its range;
    /// - it covers few steps of its grid.
    pub fn findings(&self, file: &str, column: &str, lines: &LineMap) -> Vec<Finding> {
        let tell = Teller { file, column, lines };
        let of = |end: bool| self.stays.iter().filter(|stay| stay.end.is_some() == end).collect::<Vec<&Stay>>();
        let saturated = stayed(&tell, FindingKind::Saturated, &of(true), "does the range of the sensor end there?");
        let flat = stayed(&tell, FindingKind::Flatline, &of(false), "did the sensor stop?");
        let mut findings: Vec<Finding> = saturated.into_iter().chain(flat).collect();
        if let (Some(steps), Some(quantum), Some((min, max))) = (self.steps(), self.quantum, self.range)
            && self.flickers
            && (STEPS_MIN..STEPS_FEW).contains(&steps)
        {
            let step = rounded(quantum);
            let text = format!(
                "moves in steps of {step} and covers {steps} of them, from {min} to {max}: what is less is not seen"
            );
            let spans = vec![lines.span(0, self.samples.saturating_sub(1))];
            let count = self.samples - self.holes;
            findings.push(tell.tell(FindingKind::Quantised, Severity::Note, count, spans, &text));
        }
        findings
    }
}

/// Values on which a column stays, as one finding.
fn stayed(tell: &Teller, kind: FindingKind, stays: &[&Stay], question: &str) -> Option<Finding> {
    let named: Vec<String> = stays
        .iter()
        .map(|stay| {
            let end = match stay.end {
                Some(End::Largest) => ", its largest value,",
                Some(End::Smallest) => ", its smallest value,",
                None => "",
            };
            let at = stay.longest.iter().map(|(first, last)| tell.lines.between(*first, *last));
            let at = listed(at, stay.stretches, ", ");
            format!("stays at exactly {}{end} for {}: {at}", stay.value, samples(stay.samples))
        })
        .collect();
    let mut spans: Vec<_> = stays.iter().flat_map(|stay| stay.longest.iter().copied()).collect();
    spans.sort_unstable();
    let spans = spans.into_iter().map(|(first, last)| tell.lines.span(first, last)).collect();
    let count = stays.iter().map(|stay| stay.samples).sum();
    let text = format!("{}; elsewhere it varies from sample to sample: {question}", named.join("; it "));
    (!stays.is_empty()).then(|| tell.tell(kind, Severity::Note, count, spans, &text))
}

/// A number to four digits.
pub(crate) fn rounded(value: f64) -> f64 {
    format!("{value:.3e}").parse().unwrap_or(value)
}
