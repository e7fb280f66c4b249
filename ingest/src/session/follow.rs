//! A measured channel against the command that it follows: where the command stands, a difference is told and nothing is changed.

use std::collections::BTreeMap;

use super::hint::{self, Between, Plateau};
use super::reader::Reader;
use super::{Channel, Stream};
use crate::error::IngestError;
use crate::finding::{Finding, FindingKind, Severity, Span};
use crate::manifest::{ChannelSpec, Follows, RunSpec};
use crate::units::Unit;
use crate::watch::{Places, samples, stamp};

/// A command stands while it moves by no more than this share of `within`.
const STILL_SHARE: f64 = 0.01;

/// What rounding adds to a difference or a time, in shares of it: a difference of `within` in print is one of `within`.
const ROUNDING: f64 = 1e-9;

/// More plateaus than these nobody commands: they are compared, and no explanation is looked for.
const PLATEAUS_MAX: usize = 4096;

/// A command, what was measured, and when: samples of one clock, in SI units.
#[derive(Debug, Clone, Copy)]
struct Pair<'a> {
    command: &'a [f64],
    measured: &'a [f64],
    seconds: Option<&'a [f64]>,
}

/// First and last of some samples.
type Stretch = (usize, usize);

/// What became of the comparison.
#[derive(Debug, Default)]
struct Compared {
    /// Samples at which the command stands.
    standing: usize,
    /// Those of them at which something was measured.
    compared: usize,
    /// Those of them that disagree.
    apart: Places,
    /// The largest difference.
    largest: f64,
    /// Compared samples by command, in order; the one in which the first disagreement lies ends there, and another begins. Empty if
    /// there are too many.
    plateaus: Vec<Stretch>,
}

impl Pair<'_> {
    /// The stamp of a sample; 0 without a clock.
    fn time(&self, sample: usize) -> f64 {
        self.seconds.map_or(0.0, |seconds| seconds[sample])
    }

    /// Compares where the command has stood for `after_s`. Samples without a command, or without a stamp that counts, are not compared;
    /// a command that is the same on both sides of them has stood.
    fn compare(&self, within: f64, after_s: f64) -> Compared {
        let mut all = Compared::default();
        let (still, largest, settled) = (within * STILL_SHARE, within * (1.0 + ROUNDING), after_s * (1.0 - ROUNDING));
        // The command with which a stretch begins, and when: a ramp leaves it, however slow.
        let mut stands: Option<(f64, f64)> = None;
        let mut open: Option<Stretch> = None;
        let mut is_regular = true;
        for (sample, (&command, &measured)) in self.command.iter().zip(self.measured).enumerate() {
            let time = self.time(sample);
            if !command.is_finite() || !time.is_finite() {
                continue;
            }
            let since = match stands {
                Some((level, since)) if (command - level).abs() <= still => since,
                _ => {
                    stands = Some((command, time));
                    all.plateaus.extend(open.take());
                    time
                }
            };
            if time - since < settled {
                continue;
            }
            all.standing += 1;
            if !measured.is_finite() {
                continue;
            }
            all.compared += 1;
            let apart = (measured - command).abs();
            if apart > largest {
                if all.apart.count == 0 {
                    all.plateaus.extend(open.take());
                }
                all.largest = all.largest.max(apart);
                all.apart.push(sample);
            }
            open = Some((open.map_or(sample, |(first, _)| first), sample));
            if all.plateaus.len() == PLATEAUS_MAX {
                is_regular = false;
                all.plateaus.clear();
            }
        }
        all.plateaus.extend(open);
        if !is_regular {
            all.plateaus.clear();
        }
        all
    }

    /// What was measured at one command.
    fn plateau(&self, &(first, last): &Stretch) -> Option<Plateau> {
        let counts = |i: usize| self.command[i].is_finite() && self.time(i).is_finite() && self.measured[i].is_finite();
        let values = (first..=last).filter(|&i| counts(i)).map(|i| self.measured[i]);
        Plateau::new(self.command[first], values.collect())
    }

    /// The one explanation that fits every plateau, in words.
    fn explanation(&self, all: &Compared, follows: &Follows, between: &Between, from: &str) -> Option<String> {
        let (moment, _) = *all.apart.first.first()?;
        let (_, end) = *all.plateaus.last()?;
        let split = all.plateaus.partition_point(|(first, _)| *first < moment);
        let (before, since) = all.plateaus.split_at(split);
        let before: Vec<Plateau> = before.iter().filter_map(|stretch| self.plateau(stretch)).collect();
        let since: Vec<Plateau> = since.iter().filter_map(|stretch| self.plateau(stretch)).collect();
        let known = between.factors();
        // What happens at the very end may be over a moment later.
        let lasts = self.time(end) - self.time(moment) >= follows.after_s;
        let hint = hint::explain(&before, &since, follows.within_si(), &known, lasts)?;
        Some(between.words(&hint, &known, from))
    }
}

impl Reader<'_> {
    /// Compares every channel that follows a command with it.
    pub fn follow(
        &self,
        run: &RunSpec,
        channels: &BTreeMap<String, Channel>,
        streams: &[Stream],
        findings: &mut Vec<Finding>,
    ) -> Result<(), IngestError> {
        for spec in &self.manifest.channels {
            let Some(follows) = &spec.follows else { continue };
            let Some(ordered) = self.manifest.channels.iter().find(|other| other.id == follows.channel) else {
                continue;
            };
            // The manifest's reader lets a channel follow no other than one of its own.
            let (Some(measured), Some(command)) = (channels.get(&spec.id), channels.get(&ordered.id)) else { continue };
            let stream = self.comparable(spec, follows, (measured, command), streams)?;
            let pair =
                Pair { command: &command.values_si, measured: &measured.values_si, seconds: stream.seconds.as_deref() };
            let told = Told { spec, follows, run, unit: measured.unit, stream };
            let between = Between {
                measured: (spec, measured.unit),
                command: (ordered, command.unit),
                atmosphere_pa: run.atmosphere_pa,
            };
            let all = pair.compare(follows.within_si(), follows.after_s);
            if all.compared == 0 {
                findings.push(told.not_compared(&all));
            } else if let Some(&first) = all.apart.first.first() {
                let hint = pair.explanation(&all, follows, &between, &told.moment(first.0));
                findings.push(told.mismatch(&all, &pair, first, hint));
            }
        }
        Ok(())
    }

    /// The stream that a channel shares with its command, if the two can be compared.
    fn comparable<'a>(
        &self,
        spec: &ChannelSpec,
        follows: &Follows,
        (measured, command): (&Channel, &Channel),
        streams: &'a [Stream],
    ) -> Result<&'a Stream, IngestError> {
        let refused = |expected: &str, found: &str, next: &str| {
            Err(self.malformed(follows.line, expected, found, next.to_owned()))
        };
        let dimension = measured.unit.dimension;
        if command.unit.dimension != dimension {
            let expected = format!("`{}` as {}, which `{}` is", follows.channel, dimension.name(), spec.id);
            let next = "correct the unit of one of them, or name an instrument";
            return refused(&expected, &format!("unit `{}`", command.unit.symbol), next);
        }
        let (_, within) = follows.within;
        if within.dimension != dimension {
            let expected = format!("`within` as {}", dimension.name());
            return refused(&expected, &format!("unit `{}`", within.symbol), "correct the unit");
        }
        if command.stream != measured.stream {
            let name = |id: &str, stream: usize| format!("`{id}` from {}", streams[stream].name);
            let found = [name(&spec.id, measured.stream), name(&follows.channel, command.stream)].join(", ");
            return refused("channels that share one clock", &found, "follow a channel of the same table");
        }
        let stream = &streams[measured.stream];
        if stream.seconds.is_none() && follows.after_s > 0.0 {
            let expected = format!("a clock, to know how long `{}` has stood", follows.channel);
            let next = "add [clock] with `column` and `unit`, or with `rate`; where every line is a steady state, say after = { value = 0, unit = \"s\" }";
            return refused(&expected, "none", next);
        }
        Ok(stream)
    }
}

/// What the findings of one channel of a run have in common.
struct Told<'a> {
    spec: &'a ChannelSpec,
    follows: &'a Follows,
    run: &'a RunSpec,
    unit: Unit,
    stream: &'a Stream,
}

impl Told<'_> {
    fn finding(&self, kind: FindingKind, spans: Vec<Span>, count: usize, text: &str) -> Finding {
        Finding {
            kind,
            severity: Severity::Note,
            file: self.run.file.clone(),
            channel: Some(self.spec.id.clone()),
            spans,
            count,
            text: format!("channel `{}` of run {}: {text}", self.spec.id, self.run.id),
        }
    }

    /// A sample's time, or its place where there is no clock.
    fn moment(&self, sample: usize) -> String {
        match &self.stream.seconds {
            Some(seconds) => format!("{} s", stamp(seconds[sample])),
            None => self.stream.lines.place(sample),
        }
    }

    /// `` `command` has stood for 2 s``.
    fn stood(&self) -> String {
        format!("`{}` has stood for {} s", self.follows.channel, stamp(self.follows.after_s))
    }

    fn mismatch(&self, all: &Compared, pair: &Pair, (first, last): Stretch, hint: Option<String>) -> Finding {
        let Self { follows, unit, stream, .. } = self;
        let (within, written) = follows.within;
        let of = samples(all.apart.count);
        let is = if all.apart.count == 1 { "is" } else { "are" };
        let (stood, it) = if follows.after_s > 0.0 {
            (format!(" where {}", self.stood()), "it".to_owned())
        } else {
            (String::new(), format!("`{}`", follows.channel))
        };
        let time = match (&stream.seconds, first == last) {
            (None, _) => String::new(),
            (Some(_), true) => format!(", at {}", self.moment(first)),
            (Some(_), false) => format!(", {} to {}", self.moment(first), self.moment(last)),
        };
        let text = format!(
            "{of} of {} compared{stood} {is} more than {within} {} from {it}; the first, {}{time}: {} commanded, {} measured; largest difference {}{}",
            all.compared,
            written.symbol,
            stream.lines.between(first, last),
            hint::amount(pair.command[first], *unit, 6),
            hint::amount(pair.measured[first], *unit, 6),
            hint::amount(all.largest, *unit, 6),
            hint.map(|hint| format!("; {hint}")).unwrap_or_default(),
        );
        self.finding(FindingKind::CommandMismatch, all.apart.spans(&stream.lines), all.apart.count, &text)
    }

    /// Silence would read as agreement.
    fn not_compared(&self, all: &Compared) -> Finding {
        let command = &self.follows.channel;
        let samples = samples(self.stream.samples);
        let why = match (all.standing, self.follows.after_s > 0.0) {
            (0, true) => format!("at none of them {}; a shorter `after` or a larger `within` may do", self.stood()),
            (0, false) => format!("none of them has a number in `{command}`"),
            (standing, true) => format!("it has no number at the {standing} where {}", self.stood()),
            (standing, false) => format!("it has no number at the {standing} where `{command}` has one"),
        };
        self.finding(
            FindingKind::NotCompared,
            vec![],
            self.stream.samples,
            &format!("{samples}, none compared with `{command}`: {why}"),
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::manifest::{ColumnRef, PressureReference};

    const KPA: f64 = 1e3;
    const RATE: f64 = 10.0;

    /// A log at 10 Hz in which each command, in kPa, stands for 5 s, and what is measured at a time and a command.
    struct Log {
        command: Vec<f64>,
        measured: Vec<f64>,
        seconds: Vec<f64>,
    }

    impl Log {
        fn new(commands: &[f64], measured: impl Fn(f64, f64) -> f64) -> Self {
            let command: Vec<f64> = commands.iter().flat_map(|c| [c * KPA; 50]).collect();
            let seconds: Vec<f64> = (0..command.len()).map(|i| i as f64 / RATE).collect();
            let measured = command.iter().zip(&seconds).map(|(c, t)| KPA * measured(*t, c / KPA)).collect();
            Self { command, measured, seconds }
        }

        fn pair(&self) -> Pair<'_> {
            Pair { command: &self.command, measured: &self.measured, seconds: Some(&self.seconds) }
        }

        fn compared(&self) -> Compared {
            self.pair().compare(KPA, 2.0)
        }

        /// The hint between two gauge pressures in kPa.
        fn hint(&self) -> Option<String> {
            hint_in(&self.pair(), 2.0, ("kPa", PressureReference::Gauge), ("kPa", PressureReference::Gauge))
        }
    }

    fn channel(id: &str, reference: PressureReference) -> ChannelSpec {
        ChannelSpec {
            id: id.to_owned(),
            device: None,
            column: ColumnRef::Number(1),
            unit: None,
            instrument: None,
            reference: Some(reference),
            commanded: false,
            tare_samples: None,
            follows: None,
            line: 1,
        }
    }

    fn hint_in(
        pair: &Pair,
        after_s: f64,
        measured: (&str, PressureReference),
        command: (&str, PressureReference),
    ) -> Option<String> {
        let unit = |symbol: &str| Unit::parse(symbol).unwrap();
        let follows = Follows { channel: "command".to_owned(), within: (1.0, unit("kPa")), after_s, line: 1 };
        let (of_measured, of_command) = (channel("pressure", measured.1), channel("command", command.1));
        let between = Between {
            measured: (&of_measured, unit(measured.0)),
            command: (&of_command, unit(command.0)),
            atmosphere_pa: None,
        };
        let all = pair.compare(KPA, after_s);
        let moment = all.apart.first.first().map(|(first, _)| format!("{} s", stamp(pair.time(*first))));
        pair.explanation(&all, &follows, &between, &moment?)
    }

    /// Deterministic noise between -1 and 1.
    fn noise(t: f64) -> f64 {
        (t * 7919.0).sin()
    }

    const STEPS: [f64; 6] = [0.0, 20.0, 40.0, 50.0, 30.0, 0.0];

    #[test]
    fn what_meets_its_command_is_compared_where_the_command_stands_and_nothing_is_told() {
        // Behind every step the pressure needs 1.5 s.
        let log = Log::new(&STEPS, |t, c| if t % 5.0 < 1.5 { 0.0 } else { c + 0.4 * noise(t) });
        let all = log.compared();
        // 5 s at 10 Hz without the first 2 s, six times.
        assert_eq!((all.standing, all.compared, all.apart.count), (180, 180, 0));
        assert_eq!(log.hint(), None);
    }

    #[test]
    fn a_ramp_is_not_compared_however_slow() {
        let command: Vec<f64> = (0..600).map(|i| f64::from(i) * 0.01 * KPA).collect();
        let measured = vec![0.0; 600];
        let seconds: Vec<f64> = (0..600).map(|i| f64::from(i) / RATE).collect();
        let pair = Pair { command: &command, measured: &measured, seconds: Some(&seconds) };
        // 0.01 kPa a sample: the command leaves a hundredth of 1 kPa behind two samples.
        assert_eq!(pair.compare(KPA, 2.0).standing, 0);
        // A converter's step within that hundredth is no ramp.
        let command: Vec<f64> = (0..600).map(|i| (50.0 + 0.009 * f64::from(i % 2)) * KPA).collect();
        let all = Pair { command: &command, ..pair }.compare(KPA, 2.0);
        assert_eq!((all.standing, all.apart.count), (580, 580));
    }

    #[test]
    fn a_difference_of_just_what_is_allowed_is_none() {
        for (measured, apart) in [(51.1, 0), (49.1, 0), (51.100_001, 1), (49.099_999, 1)] {
            let pair = Pair { command: &[50.1 * KPA], measured: &[measured * KPA], seconds: None };
            assert_eq!(pair.compare(KPA, 0.0).apart.count, apart, "{measured}");
        }
    }

    #[test]
    fn the_command_has_stood_long_enough_at_just_that_time() {
        // 10.3 s and 2 s are no binary numbers.
        let seconds: Vec<f64> = (0..30).map(|i| (103.0 + f64::from(i)) / RATE).collect();
        let (command, measured) = (vec![0.0; 30], vec![5.0 * KPA; 30]);
        let all = Pair { command: &command, measured: &measured, seconds: Some(&seconds) }.compare(KPA, 2.0);
        assert_eq!((all.standing, all.apart.first.clone()), (10, vec![(20, 29)]));
    }

    #[test]
    fn holes_are_neither_agreement_nor_disagreement() {
        let mut log = Log::new(&[50.0], |_, _| 10.0);
        log.measured[30] = f64::NAN;
        log.command[35] = f64::NAN;
        log.seconds[40] = f64::NAN;
        log.measured[41] = f64::INFINITY;
        let all = log.compared();
        assert_eq!((all.standing, all.compared, all.apart.count), (28, 26, 26));
        assert_eq!(all.apart.first, [(20, 29), (31, 34), (36, 39), (42, 49)]);
        // A channel without a number agrees with nothing.
        let log = Log::new(&[50.0], |_, _| f64::NAN);
        assert_eq!((log.compared().standing, log.compared().compared), (30, 0));
        // A hole in the command does not hide that it has moved.
        let mut log = Log::new(&[50.0, 20.0], |_, _| 50.0);
        log.command[45..55].fill(f64::NAN);
        assert_eq!(log.compared().apart.first, [(75, 99)]);
    }

    #[test]
    fn a_log_in_another_unit_is_seen_as_such() {
        let psi = Unit::parse("psi").unwrap().factor / KPA;
        let gauge = PressureReference::Gauge;
        let hint = |factor: f64, measured: &str, command: &str| {
            let log = Log::new(&STEPS, |t, c| (c + 0.2 * noise(t)) * factor);
            hint_in(&log.pair(), 2.0, (measured, gauge), (command, gauge))
        };
        assert_eq!(hint(1.0 / psi, "kPa", "kPa").unwrap(), "as if it were in psi");
        // The one in kPa is said to be in psi: 6.89 times too much.
        assert_eq!(hint(psi, "psi", "kPa").unwrap(), "as if it were in kPa, or `command` were in psi");
        assert_eq!(hint(psi, "kPa", "kPa").unwrap(), "as if `command` were in psi");
        assert_eq!(hint(0.01, "kPa", "bar").unwrap(), "as if it were in bar, or `command` were in kPa");
        assert_eq!(hint(1000.0, "kPa", "kPa").unwrap(), "as if it were in Pa, or `command` were in MPa");
        assert_eq!(hint(0.001, "kPa", "kPa").unwrap(), "as if it were in MPa, or `command` were in Pa");
        assert_eq!(hint(-1.0, "kPa", "kPa").unwrap(), "as if it had the other sign");
    }

    #[test]
    fn a_factor_is_told_only_if_every_plateau_has_it() {
        let psi = KPA / Unit::parse("psi").unwrap().factor;
        // One plateau of six is right, or wrong in another way.
        for odd in [1.0, 0.5, 0.2] {
            let log = Log::new(&STEPS, |t, c| c * if (10.0..15.0).contains(&t) { odd } else { psi });
            assert!(log.compared().apart.count > 0);
            assert_eq!(log.hint(), None, "{odd}");
        }
        // It need not be far from it.
        let log = Log::new(&STEPS, |t, c| c * if (10.0..15.0).contains(&t) { 0.17 } else { psi });
        assert_eq!(log.hint().unwrap(), "throughout about 85 % short of the command");
        // A factor near one that has a name, but not that near.
        let log = Log::new(&STEPS, |_, c| c * psi * 1.03);
        assert_eq!(log.hint().unwrap(), "throughout about 85 % short of the command");
        let log = Log::new(&STEPS, |_, c| c * psi * 1.015);
        assert_eq!(log.hint().unwrap(), "as if it were in psi");
        // A reading where nothing is commanded comes from no unit.
        let log = Log::new(&STEPS, |_, c| c * psi + 0.9);
        assert_eq!(log.hint().unwrap(), "throughout about 84 % short of the command");
        let log = Log::new(&STEPS, |_, c| c * psi + 1.1);
        assert_eq!(log.hint(), None);
    }

    #[test]
    fn an_offset_is_told_apart_from_a_factor_by_several_commands() {
        let log = Log::new(&STEPS, |t, c| c + 2.5 + 0.2 * noise(t));
        assert_eq!(log.hint().unwrap(), "as if about 2.5 kPa were added to it: a zero that slipped?");
        // 50 kPa and 40 measured: a fifth is missing, or 10 kPa.
        let log = Log::new(&[50.0], |_, _| 40.0);
        assert_eq!(log.hint(), None);
        let log = Log::new(&[50.0, 50.2, 49.8], |_, c| c - 10.0);
        assert_eq!(log.hint(), None);
        // From a moment on, which is no moment of a step.
        let log = Log::new(&STEPS, |t, c| c - if t < 12.8 { 0.0 } else { 3.0 });
        assert_eq!(log.hint().unwrap(), "from 12.8 s on as if about 3 kPa were taken from it: a zero that slipped?");
        // It drifts: no one offset.
        let log = Log::new(&STEPS, |t, c| c + 0.3 * t);
        assert!(log.compared().apart.count > 0);
        assert_eq!(log.hint(), None);
    }

    #[test]
    fn an_atmosphere_too_much_is_that_of_the_other_zero() {
        use PressureReference::{Absolute, Gauge};
        let hint = |offset: f64, measured, command| {
            let log = Log::new(&STEPS, |t, c| c + offset + 0.1 * noise(t));
            hint_in(&log.pair(), 2.0, ("kPa", measured), ("kPa", command)).unwrap()
        };
        assert_eq!(hint(101.3, Gauge, Gauge), "as if it were an absolute pressure");
        assert_eq!(
            hint(-101.3, Absolute, Gauge),
            "as if it were a gauge pressure, or `command` were an absolute pressure"
        );
        assert_eq!(hint(-99.0, Gauge, Gauge), "as if `command` were an absolute pressure");
        // No other zero gives this.
        assert_eq!(hint(101.3, Absolute, Gauge), "as if about 100 kPa were added to it: a zero that slipped?");
        assert_eq!(hint(60.0, Gauge, Gauge), "as if about 60 kPa were added to it: a zero that slipped?");
        // Nothing but zero was commanded.
        let log = Log::new(&[0.0], |_, _| 101.3);
        assert_eq!(log.hint().unwrap(), "as if it were an absolute pressure");
    }

    #[test]
    fn a_share_that_is_lost_from_some_moment_on_may_be_a_leak() {
        let log = Log::new(&STEPS, |t, c| c * if t < 12.3 { 1.0 } else { 0.85 } + 0.2 * noise(t));
        assert_eq!(log.compared().apart.first[0].0, 123);
        assert_eq!(log.hint().unwrap(), "from 12.3 s on about 15 % short of the command: a leak?");
        // One command only: what is lost may as well be an offset.
        let log = Log::new(&[0.0, 50.0], |t, c| if t < 7.5 { c } else { 0.85 * c });
        assert_eq!(
            log.hint().unwrap(),
            "from 7.5 s on about 15 % short of the command: a leak, or a zero that slipped?"
        );
        // It comes back: no moment from which on.
        let log = Log::new(&STEPS, |t, c| c * if (12.3..18.0).contains(&t) { 0.85 } else { 1.0 });
        assert!(log.compared().apart.count > 0);
        assert_eq!(log.hint(), None);
        // At the very end it is not known whether it stays.
        let log = Log::new(&[0.0, 50.0, 40.0], |t, c| if t < 13.5 { c } else { 0.85 * c });
        assert_eq!((log.compared().apart.count, log.hint()), (15, None));
        // Slower and slower: at no two commands the same share.
        let log = Log::new(&STEPS, |t, c| c * (1.0 - 0.012 * (t - 8.0).max(0.0)));
        assert!(log.compared().apart.count > 0);
        assert_eq!(log.hint(), None);
        // More than was asked for leaks nowhere.
        let log = Log::new(&STEPS, |t, c| c * if t < 12.3 { 1.0 } else { 1.2 });
        assert_eq!(log.hint().unwrap(), "from 12.3 s on about 20 % over the command");
    }

    #[test]
    fn single_samples_that_disagree_have_no_explanation() {
        let log = Log::new(&STEPS, |t, c| if (t * RATE).round() % 7.0 == 0.0 { -c } else { c });
        assert!(log.compared().apart.count > 10);
        assert_eq!(log.hint(), None);
    }

    #[test]
    fn lines_that_are_steady_states_need_no_clock() {
        let command: Vec<f64> = (0..8).map(|i| f64::from(i) * 10.0 * KPA).collect();
        let measured: Vec<f64> = command.iter().map(|c| -c).collect();
        let pair = Pair { command: &command, measured: &measured, seconds: None };
        let all = pair.compare(KPA, 0.0);
        assert_eq!((all.compared, all.apart.first.clone()), (8, vec![(1, 7)]));
        let gauge = PressureReference::Gauge;
        assert_eq!(hint_in(&pair, 0.0, ("kPa", gauge), ("kPa", gauge)).unwrap(), "as if it had the other sign");
    }

    #[test]
    fn of_more_commands_than_anybody_gives_no_explanation_is_sought() {
        let command: Vec<f64> = (0..10_000).map(|i| f64::from(i) * 10.0 * KPA).collect();
        let measured: Vec<f64> = command.iter().map(|c| -c).collect();
        let all = Pair { command: &command, measured: &measured, seconds: None }.compare(KPA, 0.0);
        assert_eq!((all.apart.count, all.plateaus.len()), (9_999, 0));
    }
}
