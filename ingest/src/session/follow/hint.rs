//! What would explain that a channel is not what was commanded. It is told where one explanation fits every plateau and no other does;
//! it says "as if", and changes no number.
//!
//! | explanation | what is measured where c is commanded |
//! |---|---|
//! | another unit, a power of ten, the other sign | f c, with an f that has a name |
//! | an offset: a zero that slipped, an absolute pressure | c + d |
//! | a share: a leak, from some moment on | r c |

use crate::manifest::{ChannelSpec, PressureReference};
use crate::units::{Dimension, Unit};

/// How far what is measured may be from what is explained, in shares of it.
const NEAR: f64 = 0.02;

/// How much an offset may differ from plateau to plateau, and what may be there before anything happened, in shares of it.
const SAME: f64 = 0.25;

/// Commands tell an offset from a factor if they differ by this share of the largest.
const APART: f64 = 0.5;

/// Of fewer samples nobody can say that something lasts.
const LASTING_MIN: usize = 5;

/// Units that are taken for one another.
const CONFUSED: [&str; 16] =
    ["Pa", "kPa", "MPa", "bar", "mbar", "psi", "mm", "cm", "m", "in", "deg", "rad", "N", "mN", "V", "mV"];

/// The atmosphere where nobody states it, in Pa: as low and as high as it gets near sea level.
const ATMOSPHERE_PA: (f64, f64) = (87e3, 108.5e3);

/// What was measured at one command, in SI units.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Plateau {
    command: f64,
    /// Median and quartiles of what was measured.
    middle: f64,
    low: f64,
    high: f64,
    samples: usize,
}

impl Plateau {
    /// From finite values; `None` if there are none.
    pub fn new(command: f64, mut values: Vec<f64>) -> Option<Self> {
        values.sort_unstable_by(f64::total_cmp);
        let last = values.len().checked_sub(1)?;
        let at = |quarters: usize| values[last * quarters / 4];
        Some(Self { command, middle: at(2), low: at(1), high: at(3), samples: values.len() })
    }

    fn offset(&self) -> f64 {
        self.middle - self.command
    }

    /// Whether the median is as expected, and half of the samples are within the wider tolerance: a drift is no plateau.
    fn is(&self, expected: f64, (middle, wide): (f64, f64)) -> bool {
        let is_wide = |value: f64| (value - expected).abs() <= wide.max(middle);
        (self.middle - expected).abs() <= middle && is_wide(self.low) && is_wide(self.high)
    }
}

/// A factor and what it would come from.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Factor {
    /// Measured over commanded.
    pub ratio: f64,
    /// What is as if: `it were in psi`.
    pub words: String,
}

/// An explanation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Hint {
    /// A factor that has a name, by its index.
    Factor(usize),
    /// The same is added to every command, in SI units.
    Offset { si: f64, is_from_moment: bool },
    /// The same share of every command is measured; of a single command that may be an offset as well.
    Share { ratio: f64, is_from_moment: bool, is_single: bool },
}

/// The one explanation that fits plateaus `before` the first disagreement and `since` then. Where it `lasts`, it may be one that
/// begins at that moment. `within` is the difference that is none, in SI units.
pub(super) fn explain(
    before: &[Plateau],
    since: &[Plateau],
    within: f64,
    factors: &[Factor],
    lasts: bool,
) -> Option<Hint> {
    let all = Plateaus::new(before.iter().chain(since), within)?;
    if let Some(factor) = all.factor(factors) {
        return Some(Hint::Factor(factor));
    }
    let since = Plateaus::new(since, within)?;
    // A zero slips between a plateau at zero and the next: only among commands that are not zero a share is no offset.
    let not_zero = || since.all.iter().copied().filter(|plateau| plateau.command.abs() > within);
    let is_share = matches!(
        Plateaus::new(not_zero(), within).and_then(|plateaus| plateaus.lasting()),
        Some(Hint::Share { is_single: false, .. })
    );
    match all.lasting() {
        Some(Hint::Offset { si, .. }) => return Some(Hint::Offset { si, is_from_moment: false }),
        Some(Hint::Share { ratio, is_single: false, .. }) if is_share => {
            return Some(Hint::Share { ratio, is_from_moment: false, is_single: false });
        }
        _ => {}
    }
    since.lasting().filter(|hint| {
        let expected = |command: f64| match hint {
            Hint::Share { ratio, .. } => ratio * command,
            Hint::Offset { si, .. } => command + si,
            Hint::Factor(_) => f64::NAN,
        };
        // Until then it followed, where the difference would have shown: what drifts has no such moment.
        let change = |plateau: &Plateau| (expected(plateau.command) - plateau.command).abs();
        let until: Vec<&Plateau> = before.iter().filter(|plateau| change(plateau) > within).collect();
        let most = until.iter().max_by(|a, b| change(a).total_cmp(&change(b)));
        let followed = most.is_some_and(|plateau| plateau.offset().abs() <= SAME * change(plateau));
        let are_many = |plateaus: &[&Plateau]| plateaus.iter().map(|p| p.samples).sum::<usize>() >= LASTING_MIN;
        lasts && followed && are_many(&until) && are_many(&since.all)
    })
}

/// Plateaus that should have one explanation.
struct Plateaus<'a> {
    all: Vec<&'a Plateau>,
    within: f64,
    /// That of the largest command, which says most.
    largest: &'a Plateau,
}

impl<'a> Plateaus<'a> {
    fn new(all: impl IntoIterator<Item = &'a Plateau>, within: f64) -> Option<Self> {
        let all: Vec<&Plateau> = all.into_iter().collect();
        let largest = all.iter().copied().max_by(|a, b| a.command.abs().total_cmp(&b.command.abs()))?;
        Some(Self { all, within, largest })
    }

    /// How far the median may be from what is explained, and how far its noise may reach. At small commands a share of them is less than
    /// any sensor keeps: there it is what the user lets pass, or that share of the largest command, whichever is less.
    fn tolerance(&self, command: f64) -> (f64, f64) {
        ((NEAR * command.abs()).max(self.within.min(NEAR * self.largest.command.abs())), self.within)
    }

    /// Whether there is anything to explain where it shows most.
    fn disagree(&self) -> bool {
        self.largest.offset().abs() > self.within
    }

    /// The only factor that fits.
    fn factor(&self, factors: &[Factor]) -> Option<usize> {
        let fits = |&i: &usize| {
            let ratio = factors[i].ratio;
            self.all.iter().all(|p| {
                let (middle, wide) = self.tolerance(p.command);
                p.is(ratio * p.command, (ratio.abs() * middle, ratio.abs() * wide))
            })
        };
        let mut fitting = (0..factors.len()).filter(fits);
        fitting.next().filter(|_| fitting.next().is_none() && self.disagree())
    }

    /// An offset or a share, whichever alone fits; a share also where both do.
    fn lasting(&self) -> Option<Hint> {
        let offset = self.largest.offset();
        let may_be_offset = self.all.iter().all(|p| p.is(p.command + offset, self.tolerance(p.command)));
        match (self.offset(), self.share()) {
            (Some(si), None) => Some(Hint::Offset { si, is_from_moment: true }),
            (_, Some(ratio)) => Some(Hint::Share { ratio, is_from_moment: true, is_single: may_be_offset }),
            (None, None) => None,
        }
    }

    /// What is added to every command.
    fn offset(&self) -> Option<f64> {
        let ends = |values: &mut dyn Iterator<Item = f64>| {
            values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| (low.min(value), high.max(value)))
        };
        let (least, most) = ends(&mut self.all.iter().map(|p| p.command));
        let (low, high) = ends(&mut self.all.iter().map(|p| p.offset()));
        let (lowest, highest) = ends(&mut self.all.iter().flat_map(|p| [p.low - p.command, p.high - p.command]));
        let middle = f64::midpoint(low, high);
        // What drifts is no offset.
        let spread = self.within.min(SAME * middle.abs());
        // A factor would show between commands; at zero there is none to show.
        let size = self.largest.command.abs();
        let is_told_apart = size <= self.within || most - least >= APART * size;
        let noise = if size <= self.within { spread } else { 2.0 * spread };
        let is_one = high - low <= spread && highest - lowest <= noise;
        (is_told_apart && is_one && middle.abs() > self.within).then_some(middle)
    }

    /// What share of every command is measured, if that is neither all of it nor the other sign.
    fn share(&self) -> Option<f64> {
        let ratio = self.largest.middle / self.largest.command;
        let is_share = self.disagree() && ratio >= -NEAR && (ratio - 1.0).abs() > 2.0 * NEAR;
        let fits = |p: &&Plateau| p.is(ratio * p.command, self.tolerance(p.command));
        (is_share && self.largest.command.abs() > self.within && self.all.iter().all(fits)).then_some(ratio)
    }
}

/// A channel and its command, with the units that they are shown in.
pub(super) struct Between<'a> {
    pub measured: (&'a ChannelSpec, Unit),
    pub command: (&'a ChannelSpec, Unit),
    /// The atmosphere of the run, if it is stated.
    pub atmosphere_pa: Option<f64>,
}

impl Between<'_> {
    /// Factors that have a name.
    pub fn factors(&self) -> Vec<Factor> {
        let ((_, unit), (command, of_command)) = (self.measured, self.command);
        let mut factors = vec![Factor { ratio: -1.0, words: "it had the other sign".to_owned() }];
        let alike = |a: f64, b: f64| (a / b - 1.0).abs() <= 1e-9;
        let others: Vec<Unit> = CONFUSED.iter().filter_map(|symbol| Unit::parse(symbol)).collect();
        let others = || others.iter().filter(|other| other.dimension == unit.dimension);
        // A number in a smaller unit is larger, and is read as if it were in the unit that is stated.
        let of_measured = others().map(|other| (unit.factor / other.factor, format!("it were in {}", other.symbol)));
        let of_command = others()
            .map(|other| (other.factor / of_command.factor, format!("`{}` were in {}", command.id, other.symbol)));
        for (ratio, words) in of_measured.chain(of_command).filter(|(ratio, _)| !alike(*ratio, 1.0)) {
            match factors.iter_mut().find(|known| alike(known.ratio, ratio)) {
                Some(known) => known.words = format!("{}, or {words}", known.words),
                None => factors.push(Factor { ratio, words }),
            }
        }
        for power in [10.0, 100.0, 1000.0] {
            for (ratio, size) in [(power, "large"), (1.0 / power, "small")] {
                if !factors.iter().any(|known| alike(known.ratio, ratio)) {
                    factors.push(Factor { ratio, words: format!("it were {power} times too {size}") });
                }
            }
        }
        factors
    }

    /// A hint in words; `moment` is when the first sample disagrees.
    pub fn words(&self, hint: &Hint, factors: &[Factor], moment: &str) -> String {
        let (_, unit) = self.measured;
        let from = |is_from_moment: bool| if is_from_moment { format!("from {moment} on ") } else { String::new() };
        match *hint {
            Hint::Factor(i) => format!("as if {}", factors[i].words),
            Hint::Offset { si, is_from_moment } => {
                if let Some(words) = self.other_reference(si).filter(|_| !is_from_moment) {
                    return format!("as if {words}");
                }
                let verb = if si > 0.0 { "added to" } else { "taken from" };
                let about = amount(si.abs(), unit, 2);
                format!("{}as if about {about} were {verb} it: a zero that slipped?", from(is_from_moment))
            }
            Hint::Share { ratio, is_from_moment, is_single } => {
                let percent = (100.0 * (1.0 - ratio).abs()).round();
                let on = if is_from_moment { from(true) } else { "throughout ".to_owned() };
                let is = if ratio < 1.0 { "short of" } else { "over" };
                let may_leak = is_from_moment && ratio < 1.0 && unit.dimension == Dimension::Pressure;
                let question = match (may_leak, is_single) {
                    (true, true) => ": a leak, or a zero that slipped?",
                    (true, false) => ": a leak?",
                    (false, true) => ": a zero that slipped?",
                    (false, false) => "",
                };
                format!("{on}about {percent} % {is} the command{question}")
            }
        }
    }

    /// Whether an offset is about the atmosphere of the run, or one that may be.
    fn is_atmosphere(&self, offset_si: f64) -> bool {
        let size = offset_si.abs();
        let (_, unit) = self.measured;
        let (low, high) = match self.atmosphere_pa {
            Some(stated) => (stated * (1.0 - NEAR), stated * (1.0 + NEAR)),
            None => ATMOSPHERE_PA,
        };
        unit.dimension == Dimension::Pressure && (low..=high).contains(&size)
    }

    /// Which of two pressures, an atmosphere apart, would be against another zero than the session says.
    fn other_reference(&self, offset_si: f64) -> Option<String> {
        let ((measured, _), (command, _)) = (self.measured, self.command);
        let is_more = offset_si > 0.0;
        let word = |spec: &ChannelSpec, is_more: bool| match (spec.reference, is_more) {
            (Some(PressureReference::Gauge), true) => Some("an absolute pressure"),
            (Some(PressureReference::Absolute), false) => Some("a gauge pressure"),
            _ => None,
        };
        let of_measured = word(measured, is_more).map(|word| format!("it were {word}"));
        let of_command = word(command, !is_more).map(|word| format!("`{}` were {word}", command.id));
        let said: Vec<String> = of_measured.into_iter().chain(of_command).collect();
        (self.is_atmosphere(offset_si) && !said.is_empty()).then(|| said.join(", or "))
    }
}

/// A value in a unit, with at most so many digits.
pub(super) fn amount(value_si: f64, unit: Unit, digits: usize) -> String {
    let value = unit.from_si(value_si);
    let value = format!("{value:.0$e}", digits - 1).parse().unwrap_or(value) + 0.0;
    if unit == Unit::ONE { value.to_string() } else { format!("{value} {}", unit.symbol) }
}
