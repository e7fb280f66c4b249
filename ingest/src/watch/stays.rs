//! Where a channel stays on one value for unusually long: the end of what a sensor can show, or a sensor that stopped.
//!
//! A stretch of equal numbers means nothing by itself. A command holds its plateaus, a converter shows none of the noise below its step,
//! a gauge reads zero until something touches it. What is told is a stretch that is far longer than any on other values, in a channel
//! whose noise is otherwise seen from sample to sample, right up to where the stretch begins: a hand that moves a tracker shakes, and then
//! puts it down.

use super::block::{At, LONG, Zigzags, long_runs, wobble};

/// Shorter stretches are nothing, however lively the channel.
const LENGTH_MIN: u64 = LONG as u64;

/// A stretch is unusual from this many times the longest one elsewhere, rounded up to a power of two.
const LONGER: u64 = 4;

/// Values whose stretches are remembered: those with the longest.
const LEVELS_MAX: usize = 12;

/// Powers of two of lengths from [`LENGTH_MIN`] on.
const OCTAVES: usize = 28;

/// Stretches remembered of each value, the longest.
pub(super) const KEPT_MAX: usize = 8;

/// Values within the range on which a sensor may stop now and then.
const STOPS_MAX: usize = 3;

/// A channel whose noise is seen goes to and fro at least so often, and at least one time in so many it comes back to another value.
const LOOSE_MIN: u64 = 20;
const LOOSE_SHARE: u64 = 6;

/// ... and has more steps in its range than states of a valve.
const STEPS_MIN: f64 = 16.0;

/// A channel that holds each value for some samples may be a slow sensor in a fast log, or a command. So many values nobody commands.
const HELD_MIN: u64 = 500;

/// A value with which a log begins is a rest if it is that near to zero, in shares of the largest value; those are rests too that are that
/// near to it, in shares of the range.
const REST_SHARE: f64 = 0.05;

/// A stretch on zero is no end of a range if what is next to it is further away than this share of the range.
const APART_SHARE: f64 = 0.25;

/// Numbers before a stretch in which its noise is looked for.
const EDGE: usize = 16;

/// There it wobbles at least so much, in shares of what is usual and in steps of the grid.
const EDGE_SHARE: f64 = 0.2;
const EDGE_STEPS: f64 = 0.75;

/// Equal numbers in a row.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Run {
    value: f64,
    /// Numbers.
    count: u64,
    /// Its first and last sample; holes may lie between.
    first: usize,
    last: usize,
    /// The values on both sides; NaN where there is none.
    before: f64,
    after: f64,
    /// How much the numbers before it wobble.
    edge: f64,
}

/// An end of the range of a channel.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum End {
    /// Its smallest value.
    Smallest,
    /// Its largest value.
    Largest,
}

/// A value on which a channel stays for unusually long, while it varies elsewhere.
#[derive(Debug, Clone, PartialEq)]
pub struct Stay {
    /// The value.
    pub value: f64,
    /// The end of the range that it is; `None` within the range, and for a zero that nothing leads to.
    pub end: Option<End>,
    /// Samples in stretches that are unusually long.
    pub samples: usize,
    /// Such stretches.
    pub stretches: usize,
    /// First and last sample of the longest of them, in their order: at most 8.
    pub longest: Vec<(usize, usize)>,
}

/// A value and its stretches.
#[derive(Debug, Clone)]
struct Level {
    value: f64,
    longest: u64,
    /// The most that the numbers before one of its stretches wobble.
    edge: f64,
    /// Stretches and their numbers, by powers of two of the length.
    counts: [u32; OCTAVES],
    numbers: [u64; OCTAVES],
    kept: Vec<Run>,
}

impl Level {
    fn new(run: Run) -> Self {
        let mut level = Self {
            value: run.value,
            longest: 0,
            edge: 0.0,
            counts: [0; OCTAVES],
            numbers: [0; OCTAVES],
            kept: Vec::new(),
        };
        level.add(run);
        level
    }

    fn add(&mut self, run: Run) {
        self.longest = self.longest.max(run.count);
        self.edge = self.edge.max(run.edge);
        let octave = octave(run.count);
        self.counts[octave] = self.counts[octave].saturating_add(1);
        self.numbers[octave] += run.count;
        if self.kept.len() < KEPT_MAX {
            self.kept.push(run);
        } else if let Some(shortest) = self.kept.iter_mut().min_by_key(|kept| (kept.count, usize::MAX - kept.first))
            && shortest.count < run.count
        {
            *shortest = run;
        }
    }

    /// Stretches of at least a length, which is a power of two, and their numbers.
    fn from(&self, length: u64) -> (usize, usize) {
        let from = octave(length);
        let stretches = self.counts[from..].iter().map(|n| *n as usize).sum();
        let numbers = self.numbers[from..].iter().sum::<u64>();
        (stretches, usize::try_from(numbers).unwrap_or(usize::MAX))
    }
}

/// How much the last numbers wobble of those of the block before and those of this one.
fn edge(history: &[f64], values: &[f64]) -> f64 {
    let here = &values[values.len().saturating_sub(EDGE)..];
    let there = &history[history.len().saturating_sub(EDGE - here.len())..];
    wobble(&[there, here].concat()).unwrap_or(0.0)
}

/// The power of two of a length, from [`LENGTH_MIN`] on.
fn octave(length: u64) -> usize {
    ((length.max(LENGTH_MIN).ilog2() - LENGTH_MIN.ilog2()) as usize).min(OCTAVES - 1)
}

/// Collects the stretches of a channel.
#[derive(Debug, Clone, Default)]
pub(super) struct Stays {
    levels: Vec<Level>,
    /// As many values have longer runs as are remembered: no shorter run can be unusual, nor be the measure of what is.
    floor: u64,
    /// The run that may go on in the next block.
    open: Option<Run>,
    /// The last numbers of the block before.
    history: Vec<f64>,
    /// The run with which the column begins, if it is a long one.
    first: Option<Run>,
}

/// What is known of a channel besides its stretches.
pub(super) struct Channel {
    pub range: (f64, f64),
    pub numbers: u64,
    pub zigzags: Zigzags,
    /// The longest of the short runs that were seen.
    pub short: u64,
    pub quantum: Option<f64>,
    /// Runs that were seen, and whether many of them are a single number.
    pub runs: u64,
    pub restless: bool,
    /// How much it usually wobbles.
    pub wobble: f64,
}

impl Stays {
    /// Numbers of a block, which belong to the samples `at`.
    #[expect(clippy::float_cmp)]
    pub fn block(&mut self, values: &[f64], at: At) {
        let open = self.open.map_or(f64::NAN, |run| run.value);
        let on = values.iter().take_while(|value| **value == open).count();
        if let Some(run) = &mut self.open
            && on > 0
        {
            run.count += on as u64;
            run.last = at.sample(on - 1);
        }
        let history = std::mem::take(&mut self.history);
        if let (Some(next), Some(last)) = (values.get(on), values.last()) {
            if let Some(open) = self.open.take() {
                self.run(Run { after: *next, ..open });
            }
            let run = |from: usize, to: usize| Run {
                value: values[from],
                count: (to - from) as u64,
                first: at.sample(from),
                last: at.sample(to - 1),
                before: from.checked_sub(1).map_or(open, |i| values[i]),
                after: values.get(to).copied().unwrap_or(f64::NAN),
                edge: edge(&history, &values[..from]),
            };
            // The last run may go on in the next block.
            let end = values.len() - values[on..].iter().rev().take_while(|value| *value == last).count();
            let floor = self.floor;
            long_runs(&values[on..end], |from, to| {
                if (to - from) as u64 > floor {
                    self.run(run(on + from, on + to));
                }
            });
            self.open = Some(run(end, values.len()));
        }
        self.history = history;
        self.history.extend_from_slice(&values[values.len().saturating_sub(EDGE)..]);
        self.history.drain(..self.history.len().saturating_sub(EDGE));
    }

    /// The next run that is over.
    #[expect(clippy::float_cmp)]
    fn run(&mut self, run: Run) {
        if run.count < LENGTH_MIN {
            return;
        }
        if run.before.is_nan() {
            self.first = Some(run);
        }
        if run.count <= self.floor {
            return;
        }
        if let Some(level) = self.levels.iter_mut().find(|level| level.value == run.value) {
            level.add(run);
        } else if self.levels.len() < LEVELS_MAX {
            self.levels.push(Level::new(run));
        } else if let Some(least) = self.levels.iter_mut().min_by_key(|level| level.longest)
            && least.longest < run.count
        {
            *least = Level::new(run);
        }
        if self.levels.len() == LEVELS_MAX {
            self.floor = self.levels.iter().map(|level| level.longest).min().unwrap_or(0);
        }
    }

    /// The values on which the channel stays for unusually long.
    pub fn judge(mut self, channel: &Channel) -> Vec<Stay> {
        if let Some(open) = self.open.take() {
            self.run(open);
        }
        let Zigzags { all, loose } = channel.zigzags;
        let (min, max) = channel.range;
        let states = channel.quantum.is_some_and(|quantum| max - min < STEPS_MIN * quantum);
        let command = !channel.restless && channel.runs < HELD_MIN;
        if states || command || loose < LOOSE_MIN || loose.saturating_mul(LOOSE_SHARE) < all {
            return vec![];
        }
        let mut ends: Vec<&Level> = Vec::new();
        let mut within: Vec<&Level> = Vec::new();
        let edge_min = (EDGE_SHARE * channel.wobble).max(EDGE_STEPS * channel.quantum.unwrap_or(0.0));
        let sudden = |level: &&Level| level.edge > edge_min && !self.is_rest(level.value, channel.range);
        for level in self.levels.iter().filter(sudden) {
            if end(level, channel.range).is_some() { ends.push(level) } else { within.push(level) }
        }
        within.sort_by(|a, b| b.longest.cmp(&a.longest).then(a.value.total_cmp(&b.value)));
        within.truncate(STOPS_MAX);
        // A sensor stops now and then on several values; a staircase rests on several values most of the time.
        let now_and_then = self.unusual(&[ends.clone(), within.clone()].concat(), channel);
        let samples: usize = now_and_then.iter().map(|stay| stay.samples).sum();
        if (samples as u64).saturating_mul(5) <= channel.numbers {
            return now_and_then;
        }
        let at_the_ends = self.unusual(&ends, channel);
        if !at_the_ends.is_empty() {
            return at_the_ends;
        }
        within.truncate(1);
        self.unusual(&within, channel)
    }

    /// Those of some levels that have stretches far longer than all other levels have.
    #[expect(clippy::float_cmp)]
    fn unusual(&self, of: &[&Level], channel: &Channel) -> Vec<Stay> {
        let range = channel.range;
        let others = self.levels.iter().filter(|level| {
            let asked = of.iter().any(|other| other.value == level.value);
            // Zero before anything happens says nothing about how long the channel stays on a value that it measures.
            let untouched = level.value == 0.0 && self.is_rest(level.value, range);
            !asked && !untouched
        });
        let elsewhere = others.map(|level| level.longest).max().unwrap_or(0).max(channel.short);
        let length = (LONGER * elsewhere).next_power_of_two().max(LENGTH_MIN);
        let mut stays: Vec<Stay> = of
            .iter()
            .filter(|level| level.longest >= length)
            .map(|level| {
                let (stretches, samples) = level.from(length);
                let mut longest: Vec<(usize, usize)> =
                    level.kept.iter().filter(|run| run.count >= length).map(|run| (run.first, run.last)).collect();
                longest.sort_unstable();
                Stay { value: level.value, end: end(level, range), samples, stretches, longest }
            })
            .collect();
        stays.sort_by(|a, b| a.longest.cmp(&b.longest));
        stays
    }

    /// Whether a value is one on which the channel rests before anything happens.
    fn is_rest(&self, value: f64, (min, max): (f64, f64)) -> bool {
        self.first.is_some_and(|first| {
            first.value.abs() <= REST_SHARE * min.abs().max(max.abs())
                && (value - first.value).abs() <= REST_SHARE * (max - min)
        })
    }
}

/// The end of the range that a level is. Zero is the reading of a sensor that nothing reaches any more, if nothing leads there.
#[expect(clippy::float_cmp)]
fn end(level: &Level, (min, max): (f64, f64)) -> Option<End> {
    let apart = |value: f64| value.is_nan() || value.abs() > APART_SHARE * (max - min);
    if level.value == 0.0 && level.kept.iter().all(|run| apart(run.before) && apart(run.after)) {
        None
    } else if level.value == max {
        Some(End::Largest)
    } else if level.value == min {
        Some(End::Smallest)
    } else {
        None
    }
}
