//! Counters that begin anew: what a step back in time looks like.

use super::clock::Step;

/// How many usual steps a clock may be before and behind the place where it begins anew.
const NEAR_STEPS: f64 = 20.0;

/// A wrap every few steps could be anything.
const STEPS_MIN: f64 = 2.0 * NEAR_STEPS;

/// A clock that begins anew.
struct Known {
    /// What is counted until it does, in `unit`.
    value: u64,
    unit: &'static str,
    unit_s: f64,
    /// What it begins anew with, in `unit`; a signed counter ends half way and begins as far below 0.
    from: i64,
    looks_like: &'static str,
}

const fn known(value: u64, unit: &'static str, unit_s: f64, from: i64, looks_like: &'static str) -> Known {
    Known { value, unit, unit_s, from, looks_like }
}

const HALF: i64 = -(1 << 31);

/// The clocks that are known to begin anew.
const KNOWN: [Known; 13] = [
    known(86_400, "s", 1.0, 0, "tells the time of day and begins anew at midnight"),
    known(1 << 16, "us", 1e-6, 0, "counts 16 bits of microseconds"),
    known(1 << 16, "ms", 1e-3, 0, "counts 16 bits of milliseconds"),
    known(1 << 16, "s", 1.0, 0, "counts 16 bits"),
    known(1 << 31, "us", 1e-6, 0, "counts 31 bits of microseconds"),
    known(1 << 31, "ms", 1e-3, 0, "counts 31 bits of milliseconds"),
    known(1 << 31, "s", 1.0, 0, "counts 31 bits"),
    known(1 << 32, "us", 1e-6, 0, "counts 32 bits of microseconds"),
    known(1 << 32, "ms", 1e-3, 0, "counts 32 bits of milliseconds"),
    known(1 << 32, "s", 1.0, 0, "counts 32 bits"),
    known(1 << 32, "us", 1e-6, HALF, "counts 32 bits of microseconds with a sign"),
    known(1 << 32, "ms", 1e-3, HALF, "counts 32 bits of milliseconds with a sign"),
    known(1 << 32, "s", 1.0, HALF, "counts 32 bits with a sign"),
];

impl Known {
    fn value_s(&self) -> f64 {
        self.value as f64 * self.unit_s
    }

    /// Whether a step back from one stamp to the next is this clock's, which is before its end and behind its beginning by less than
    /// `near_s`.
    fn explains(&self, (before, next): (f64, f64), near_s: f64) -> bool {
        let from = self.from as f64 * self.unit_s;
        let left = from + self.value_s() - before;
        let gone = next - from;
        // Conversion to seconds may put the last tick a rounding error behind the end.
        let rounding = -1e-12 * self.value_s();
        (rounding..near_s).contains(&left) && (rounding..near_s).contains(&gone)
    }
}

/// A counter that began anew, by the look of it.
#[derive(Debug, Clone, PartialEq)]
pub struct Wrap {
    /// What it counts until it begins anew, in `unit`.
    pub value: u64,
    /// The unit it counts in; `s` where one tick is taken as one second.
    pub unit: &'static str,
    /// What it looks like, in words.
    pub looks_like: &'static str,
    /// How often it began anew.
    pub count: usize,
    /// The first of these steps.
    pub first: Vec<Step>,
}

/// How many steps back look like which clock, roughly: what is usual is known in the end only.
#[derive(Debug, Clone, Default)]
pub(super) struct Tally([u32; KNOWN.len()]);

impl Tally {
    pub fn add(&mut self, before: f64, next: f64) {
        for (count, known) in self.0.iter_mut().zip(&KNOWN) {
            *count = count.saturating_add(u32::from(known.explains((before, next), 0.1 * known.value_s())));
        }
    }

    /// The clock that explains most of the first steps back, if one explains any.
    pub fn judge(&self, backs: &[Step], back_count: usize, usual_s: f64) -> Option<Wrap> {
        let candidates = KNOWN.iter().zip(self.0).filter(|(known, _)| known.value_s() >= STEPS_MIN * usual_s);
        let (known, roughly, first) = candidates
            .map(|(known, roughly)| {
                let explained = |step: &&Step| known.explains(step.seconds, NEAR_STEPS * usual_s);
                (known, roughly, backs.iter().filter(explained).copied().collect::<Vec<Step>>())
            })
            .rev()
            .max_by_key(|(_, _, first)| first.len())
            .filter(|(_, _, first)| !first.is_empty())?;
        let count = if back_count > backs.len() { first.len().max(roughly as usize) } else { first.len() };
        Some(Wrap { value: known.value, unit: known.unit, looks_like: known.looks_like, count, first })
    }
}
