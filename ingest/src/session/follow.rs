//! A measured channel against the command that it follows: where the command stands, a difference is told and nothing is changed.

mod hint;

use std::collections::BTreeMap;

use hint::{Between, Plateau};

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
mod tests;
