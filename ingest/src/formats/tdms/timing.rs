//! When the values of a channel were taken: what waveforms say about it.

use super::channel::{is_clock, number, seconds_in};
use super::value::{Properties, Timestamp, Value};

/// The time axis of a waveform.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Timing {
    /// When it began, if that is known as a date.
    pub start: Option<Timestamp>,
    /// The first place on the axis, in s where it is time.
    pub offset: f64,
    /// From one place to the next; `None` where no axis is stated.
    pub increment: Option<f64>,
    /// What is drawn along the axis, and its unit if it has one, where it is not time.
    pub other: Option<(String, Option<String>)>,
}

/// Properties that make a time axis.
pub(super) const TIMING: [&str; 5] =
    ["wf_start_time", "wf_start_offset", "wf_increment", "wf_xname", "wf_xunit_string"];

impl Timing {
    pub fn of(properties: &Properties) -> Self {
        let start = match properties.get("wf_start_time") {
            // The beginning of the count stands for no date.
            Some(Value::Time(stamp)) if stamp.seconds != 0 => Some(*stamp),
            _ => None,
        };
        let text = |name| {
            let text = properties.get(name).and_then(Value::text).map(str::trim).filter(|text| !text.is_empty());
            text.map(|text| text.chars().take(NAME_CHARACTERS_MAX).collect::<String>())
        };
        let (name, unit) = (text("wf_xname"), text("wf_xunit_string"));
        // Seconds in one of its unit; `None` for what is no time.
        let seconds = match (&unit, &name) {
            (Some(unit), _) => seconds_in(unit),
            // A name alone: `Frequency` is no time, and what began at a date is.
            (None, Some(name)) if start.is_none() && !is_clock(name) => None,
            (None, _) => Some(1.0),
        };
        let scaled = |name| number(properties, name).map(|number| number * seconds.unwrap_or(1.0));
        let increment = scaled("wf_increment").filter(|step| step.is_finite() && *step != 0.0);
        let offset = scaled("wf_start_offset").filter(|offset| offset.is_finite()).unwrap_or(0.0);
        let other = seconds.is_none().then(|| (name.unwrap_or_else(|| "x".to_owned()), unit));
        Self { start, offset, increment, other }
    }

    /// Whether only the beginning is another.
    fn is_of_one_kind_with(&self, other: &Self) -> bool {
        self.increment == other.increment && self.other == other.other && self.start.is_some() == other.start.is_some()
    }

    /// Where the axis begins, in s since an origin or on its own count.
    pub fn begin(&self, origin: Option<i64>) -> f64 {
        match (&self.start, origin) {
            (Some(start), Some(origin)) if self.other.is_none() => start.since(origin) + self.offset,
            _ => self.offset,
        }
    }
}

/// Characters of the name of an axis, and of its unit.
const NAME_CHARACTERS_MAX: usize = 256;

/// Two stamps less than this part of a step apart are the same: cards state beginnings of which no stamp could tell more.
const PART_OF_STEP: f64 = 1e-6;

/// The time axes of a channel, each from the sample on at which it was stated.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Timings {
    axes: Vec<(u64, Timing)>,
}

impl Timings {
    pub fn new(timing: Timing) -> Self {
        Self { axes: vec![(0, timing)] }
    }

    /// The axis from a sample on.
    pub fn set(&mut self, sample: u64, timing: Timing) {
        match self.axes.last_mut() {
            Some((_, last)) if *last == timing => {}
            Some((at, last)) if *at == sample => *last = timing,
            _ => self.axes.push((sample, timing)),
        }
    }

    /// The axes of so many samples. One that was stated behind the last sample holds for all of them, as does one before which there was
    /// none.
    pub fn finish(mut self, samples: u64) -> Axes {
        if let Some((at, _)) = self.axes.last()
            && *at >= samples
            && let Some((_, last)) = self.axes.pop()
        {
            self.axes = vec![(0, last)];
        }
        let first = self.axes.iter().position(|(_, timing)| timing.increment.is_some());
        self.axes.drain(..first.unwrap_or(self.axes.len()));
        if let Some((at, _)) = self.axes.first_mut() {
            *at = 0;
        }
        // A logger that states anew where its time stands anyway changes nothing.
        self.axes.dedup_by(|later, earlier| later.1 == earlier.1 || goes_on(earlier, later));
        Axes(self.axes)
    }
}

/// Whether the later axis of a channel stamps its samples as the earlier one would.
// Samples beyond 2^53 are more than any file holds.
#[allow(clippy::cast_precision_loss)]
fn goes_on((from, earlier): &(u64, Timing), (at, later): &(u64, Timing)) -> bool {
    let second = earlier.start.map(|start| start.seconds);
    let step = earlier.increment.unwrap_or(0.0);
    let due = earlier.begin(second) + (at - from) as f64 * step;
    earlier.is_of_one_kind_with(later) && (due - later.begin(second)).abs() <= PART_OF_STEP * step.abs()
}

/// The time axes of all samples of a channel; none where none is stated.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Axes(Vec<(u64, Timing)>);

impl Axes {
    pub fn is_none(&self) -> bool {
        self.0.is_empty()
    }

    /// Whether samples at equal places were taken at equal times, as far as stamps can tell.
    pub fn is_alike(&self, other: &Self) -> bool {
        let alike = |((at, a), (at_b, b)): (&(u64, Timing), &(u64, Timing))| {
            let second = a.start.or(b.start).map(|start| start.seconds);
            let apart = (a.begin(second) - b.begin(second)).abs();
            at == at_b && a.is_of_one_kind_with(b) && apart <= PART_OF_STEP * a.increment.unwrap_or(0.0).abs()
        };
        self.0.len() == other.0.len() && self.0.iter().zip(&other.0).all(alike)
    }

    /// The first of them.
    pub fn first(&self) -> Option<&Timing> {
        self.0.first().map(|(_, timing)| timing)
    }

    /// The samples at which another one begins.
    pub fn changes(&self) -> impl Iterator<Item = u64> {
        self.0.iter().skip(1).map(|(at, _)| *at)
    }

    /// Runs of samples: how many, where the first stands on the axis, and the step.
    pub fn runs(&self, samples: u64, origin: Option<i64>) -> impl Iterator<Item = (u64, f64, f64)> {
        let ends = self.0.iter().skip(1).map(|(at, _)| *at).chain([samples]);
        self.0.iter().zip(ends).map(move |((at, timing), end)| {
            let count = end.min(samples).saturating_sub(*at);
            (count, timing.begin(origin), timing.increment.unwrap_or(0.0))
        })
    }
}
