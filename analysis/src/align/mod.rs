//! The streams of a run on one time: by events that several devices recorded, by declaration, or not at all.
//!
//! ```text
//! Session --> per run: events --> pairs --> clock fits --> stamps on the reference clock --.
//!                      lags of motions behind pressures --> told, shifted if declared -----'--> AlignedRun
//! ```
//!
//! | file | holds |
//! |---|---|
//! | `events.rs` | when something happened, as one channel saw it; which events of two channels are one |
//! | `clock.rs` | one clock set on another, with uncertainties |
//! | `lag.rs` | the lag of a motion behind a pressure |
//! | `mod.rs` | what that makes of a session |
//!
//! Where events set the clocks on each other, or one clock is declared, a lag that remains is that of rig and specimen: it is reported
//! and kept. Where neither is so, offset of the clocks and lag of the specimen cannot be told apart: their sum is reported as total lag
//! and nothing is shifted, unless the session says which of the two it is.

mod clock;
mod events;
mod lag;

use std::borrow::Cow;
use std::collections::BTreeMap;

use pneuval_ingest::IngestError;
use pneuval_ingest::error::Place;
use pneuval_ingest::finding::{Finding, FindingKind, Severity};
use pneuval_ingest::formats::stamps::Epoch;
use pneuval_ingest::manifest::{Clocks, LagMeaning, PointRule, ResponseSpec, SessionManifest, SyncSpec};
use pneuval_ingest::session::{Run, Session, Stream};

pub use clock::{ClockFit, Estimate, half_width_of_sum};
pub use events::{Event, Events, events, matched};
pub use lag::{CORRELATION_MIN, LAG_MAX_S, Lag, Signal, lag};

use crate::format;

/// No clock of a lab is off by more than this: ceramic resonators are by half of it.
const DRIFT_MAX: f64 = 0.01;

/// Beyond this a drift is worth a word: quartz clocks are off by a tenth of it.
const DRIFT_USUAL: f64 = 1e-3;

/// A lag this many standard uncertainties, and this share of a sampling step, from that of the other runs, or below zero, is unusual.
const UNUSUAL_STDS: f64 = 3.0;
const UNUSUAL_STEPS: f64 = 0.1;

/// Where a motion leads, windows are cut by so many times the lead.
const LEAD_TIMES: f64 = 2.0;

/// Standard uncertainties by which a lag may be longer than it was found.
const LAG_STDS: f64 = 2.0;

/// What happened to the clocks of a session.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Alignment<'a> {
    /// Its runs, in order.
    pub runs: Vec<AlignedRun<'a>>,
    /// What a reader should know.
    pub findings: Vec<Finding>,
}

/// A run whose streams stand on one time, as far as that is known.
#[derive(Debug, Clone, PartialEq)]
pub struct AlignedRun<'a> {
    /// The run, with the stamps as its devices wrote them.
    pub run: &'a Run,
    /// Per stream, its stamps on the clock of its group.
    seconds: Vec<Option<Cow<'a, [f64]>>>,
    /// Per stream, the instant from which those stamps count.
    epochs: Vec<Option<Epoch>>,
    /// Per stream: those of one group may be set against each other.
    groups: Vec<usize>,
    /// Per stream: how far from that time its stamps may lie.
    slack: Vec<ClockSlack>,
    /// Clocks that events say something of.
    pub clocks: Vec<StreamClock>,
    /// Lags of motions behind pressures.
    pub lags: Vec<RunLag>,
}

/// What events say of the clock of a stream.
#[derive(Debug, Clone, PartialEq)]
pub struct StreamClock {
    /// The stream.
    pub stream: usize,
    /// The stream of the reference clock.
    pub reference: usize,
    /// Events that each of the two saw, the reference first.
    pub found: (usize, usize),
    /// The first stamp of the run on the reference clock, in s.
    pub start_s: f64,
    /// The fit, or why there is none.
    pub fit: Result<ClockFit, String>,
}

/// The lag of a motion in one run.
#[derive(Debug, Clone, PartialEq)]
pub struct RunLag {
    /// The quantity of the response.
    pub quantity: String,
    /// The channel of the pressure.
    pub pressure: String,
    /// The channel of the motion.
    pub channel: String,
    /// Its stream.
    pub stream: usize,
    /// What it is.
    pub meaning: Meaning,
    /// The lag, or why there is none.
    pub found: Result<Lag, String>,
}

/// What a lag is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Meaning {
    /// That of rig and specimen: the clocks agree.
    Physical,
    /// That of clocks, rig and specimen in sum.
    Total,
    /// That of the clock: stamps were shifted by it.
    Clock,
}

impl Meaning {
    /// Its word in results.
    pub fn id(self) -> &'static str {
        match self {
            Self::Physical => "physical",
            Self::Total => "total",
            Self::Clock => "clock",
        }
    }
}

/// How a motion may be read against a pressure.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Reach {
    /// Both stand on one time, up to so much either way.
    Known(Slack),
    /// The motion is up to so much late, in s, by its clock or by the specimen.
    Late(f64),
    /// Not at all.
    Apart,
}

/// How far two streams that stand on one time may still be off, either way.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Slack {
    /// At an instant of their time, in s, by each of the two clocks.
    clocks: [ClockSlack; 2],
    /// Because the motion comes before its pressure, in s.
    pub leads_s: f64,
}

/// How far a clock may be off.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
struct ClockSlack {
    /// Where it is known, in s.
    middle_s: f64,
    /// There, in s.
    half_s: f64,
    /// More in every second from there.
    per_s: f64,
}

impl Slack {
    /// In s, at an instant of the reference.
    pub fn at(&self, seconds: f64) -> f64 {
        let of = |clock: &ClockSlack| clock.half_s + clock.per_s * (seconds - clock.middle_s).abs();
        of(&self.clocks[0]).hypot(of(&self.clocks[1])).max(self.leads_s)
    }
}

impl<'a> AlignedRun<'a> {
    /// The stamps of a stream in s, on the reference clock where that is known.
    pub fn seconds(&self, stream: usize) -> Option<&[f64]> {
        self.seconds.get(stream)?.as_deref()
    }

    /// The instant from which they count; `None`: from a zero that only the device knows.
    pub fn epoch(&self, stream: usize) -> Option<Epoch> {
        self.epochs.get(stream).copied().flatten()
    }

    /// Streams of one group may be set against each other.
    pub fn group(&self, stream: usize) -> Option<usize> {
        self.groups.get(stream).copied()
    }

    /// How what a response measures on a stream may be read against the pressures on another.
    pub fn reach(&self, spec: &ResponseSpec, state: usize, stream: usize) -> Reach {
        let of_it = |lag: &&RunLag| lag.quantity == spec.quantity.id && lag.stream == stream;
        let lag = self.lags.iter().find(of_it);
        if self.groups.get(state) == self.groups.get(stream) {
            // A motion before its pressure: one of the two stamps is not what it is said to be, by that much, and where a clock drifts by twice
            // as much at an end.
            let leads = lag.filter(|lag| lag.meaning == Meaning::Physical).and_then(|lag| lag.found.as_ref().ok());
            let leads = leads.filter(|lag| lag.leads_clearly());
            let leads_s = leads.map_or(0.0, |lag| LEAD_TIMES * (LAG_STDS * lag.std_s - lag.value_s));
            let clock = |stream: usize| self.slack.get(stream).copied().unwrap_or_default();
            return Reach::Known(Slack { clocks: [clock(state), clock(stream)], leads_s });
        }
        match lag.map(|lag| &lag.found) {
            // What leads is no specimen's doing.
            Some(Ok(lag)) if !lag.leads() => Reach::Late(lag.value_s.max(0.0) + LAG_STDS * lag.std_s),
            _ => Reach::Apart,
        }
    }

    /// The run with the stamps of its devices; those with dates on one base.
    fn new(manifest: &SessionManifest, run: &'a Run) -> Self {
        let is_one = manifest.clocks == Clocks::One;
        let across = |spec: &ResponseSpec| run.stream_of(spec.channels()).is_none();
        let base = run.streams.iter().find_map(|stream| stream.epoch);
        // What is not set against each other stays as it stands; one clock was set on one base when it was read.
        let base = base.filter(|_| !is_one && manifest.responses.iter().any(across));
        let (mut seconds, mut epochs) = (Vec::new(), Vec::new());
        for stream in &run.streams {
            // Whole seconds between two dates: nothing is guessed.
            let since = stream.epoch.zip(base).and_then(|(epoch, base)| epoch.since(base)).filter(|since| *since != 0);
            seconds.push(stream.seconds.as_deref().map(|seconds| match since {
                Some(since) => Cow::Owned(seconds.iter().map(|t| t + since as f64).collect()),
                None => Cow::Borrowed(seconds),
            }));
            epochs.push(if since.is_some() { base } else { stream.epoch });
        }
        let groups = (0..run.streams.len()).map(|i| if is_one { 0 } else { i }).collect();
        let slack = vec![ClockSlack::default(); run.streams.len()];
        Self { run, seconds, epochs, groups, slack, clocks: vec![], lags: vec![] }
    }

    fn signal(&self, id: &str) -> Option<(usize, Signal<'_>)> {
        let channel = self.run.channels.get(id)?;
        let seconds = self.seconds(channel.stream)?;
        Some((channel.stream, Signal { seconds, values: &channel.values_si }))
    }

    /// Sets streams on the reference clock by the events of a session.
    fn synchronise(&mut self, syncs: &[SyncSpec]) {
        let mut of_streams: BTreeMap<usize, (usize, Paired)> = BTreeMap::new();
        for sync in syncs {
            let Some(((reference, on_reference), others)) =
                sync.channels.split_first().and_then(|(first, others)| Some((self.signal(first)?, others)))
            else {
                continue;
            };
            let ours = events(on_reference.seconds, on_reference.values, sync.event);
            for id in others {
                let Some((stream, signal)) = self.signal(id) else { continue };
                let (_, paired) = of_streams.entry(stream).or_insert_with(|| (reference, Paired::default()));
                let theirs = events(signal.seconds, signal.values, sync.event);
                match (&ours, &theirs) {
                    (Ok(ours), Ok(theirs)) => paired.add(ours, theirs, sync),
                    (Err(why), _) => paired.refused.push(format!("`{}`: {why}", sync.channels[0])),
                    (_, Err(why)) => paired.refused.push(format!("`{id}`: {why}")),
                }
            }
        }
        for (stream, (reference, paired)) in of_streams {
            let start_s = self.seconds(reference).and_then(|all| all.iter().copied().find(|t| t.is_finite()));
            let fit = ClockFit::of(&paired.pairs).ok_or_else(|| paired.refused.join("; "));
            if let Ok(fit) = &fit {
                // A straight line is farthest off at an end.
                let ends = self.seconds(stream).and_then(ends).into_iter().flat_map(|(first, last)| [first, last]);
                self.slack[stream] = ClockSlack {
                    middle_s: fit.on_reference(fit.middle_s),
                    half_s: ends.map(|stamp| fit.offset_at(stamp).half_width).fold(0.0, f64::max),
                    // One event says nothing of what the clock gains: no more than any clock does.
                    per_s: if fit.drift.is_some() { 0.0 } else { DRIFT_MAX },
                };
                if let Some(Some(seconds)) = self.seconds.get_mut(stream) {
                    seconds.to_mut().iter_mut().for_each(|t| *t = fit.on_reference(*t));
                }
                self.join(stream, reference);
            }
            self.clocks.push(StreamClock {
                stream,
                reference,
                found: paired.found,
                start_s: start_s.unwrap_or(0.0),
                fit,
            });
        }
    }

    /// The lag of each motion of a response that stands on another stream than the pressures.
    fn lags_of(&mut self, spec: &ResponseSpec, declared: LagMeaning) {
        if !matches!(spec.points, PointRule::Plateaus { .. })
            || !spec.channels().all(|id| self.run.channels.contains_key(id))
        {
            return;
        }
        let mut seen = Vec::new();
        for id in &spec.measured {
            let Some((stream, motion)) = self.signal(id) else { continue };
            let others = spec.pressure.iter().filter_map(|(id, _)| Some((id, self.signal(id)?)));
            let others: Vec<_> = others.filter(|(_, (state, _))| *state != stream).collect();
            if others.is_empty() || seen.contains(&stream) {
                continue;
            }
            seen.push(stream);
            // Events were declared and give no clock, on either side: what a lag says instead nobody asked for.
            let is_refused = others.iter().any(|(_, (state, _))| self.refused(stream, *state).is_some());
            if is_refused && declared == LagMeaning::Unsaid {
                continue;
            }
            // Of several chambers, the one whose pressure the motion follows most.
            let mut best: Option<(&String, usize, Result<Lag, String>)> = None;
            for (pressure, (state, signal)) in others {
                let found = lag(signal, motion);
                let size = |found: &Result<Lag, String>| found.as_ref().map_or(0.0, |lag| lag.correlation.abs());
                if best.as_ref().is_none_or(|(.., known)| size(&found) > size(known)) {
                    best = Some((pressure, state, found));
                }
            }
            let Some((pressure, state, found)) = best else { continue };
            let is_known = self.groups[state] == self.groups[stream];
            // The clocks are known as well as the events say, and so is what is left between them.
            let clocks = self.clock_std_s(stream).hypot(self.clock_std_s(state));
            let found = found.map(|lag| Lag { std_s: lag.std_s.hypot(clocks), ..lag });
            let meaning = match declared {
                _ if is_known => Meaning::Physical,
                LagMeaning::Unsaid => Meaning::Total,
                LagMeaning::Physical => Meaning::Physical,
                LagMeaning::Clock => Meaning::Clock,
            };
            let lag = RunLag {
                quantity: spec.quantity.id.clone(),
                pressure: pressure.clone(),
                channel: id.clone(),
                stream,
                meaning,
                found,
            };
            match (&lag.found, meaning) {
                (Ok(found), Meaning::Clock) => {
                    let by = found.value_s;
                    if let Some(Some(seconds)) = self.seconds.get_mut(stream) {
                        seconds.to_mut().iter_mut().for_each(|t| *t -= by);
                    }
                    self.join(stream, state);
                    self.slack[stream] = ClockSlack { half_s: LAG_STDS * found.std_s, ..ClockSlack::default() };
                }
                // Declared: the clocks agree, whatever is found.
                (_, Meaning::Physical) => self.join(stream, state),
                _ => {}
            }
            self.lags.push(lag);
        }
    }

    /// Why events give no clock to one of two streams that they should set on each other.
    fn refused(&self, stream: usize, state: usize) -> Option<&String> {
        let is_of = |clock: &&StreamClock| clock.stream == stream || clock.stream == state;
        self.clocks.iter().filter(is_of).find_map(|clock| clock.fit.as_ref().err())
    }

    /// How sure the clock of a stream is in the middle of its stamps, in s; of the reference, or without events, there is nothing to say.
    fn clock_std_s(&self, stream: usize) -> f64 {
        let fit = self.clocks.iter().find(|clock| clock.stream == stream).and_then(|clock| clock.fit.as_ref().ok());
        // On the reference by now: back to its own clock.
        let middle = self.seconds(stream).and_then(ends).map(|(first, last)| f64::midpoint(first, last));
        fit.zip(middle).map_or(0.0, |(fit, middle)| fit.offset_at(middle - fit.offset.value).std)
    }

    fn join(&mut self, stream: usize, state: usize) {
        self.groups[stream] = self.groups[state];
        self.epochs[stream] = self.epochs[state];
    }
}

/// The first and the last stamp that count.
fn ends(seconds: &[f64]) -> Option<(f64, f64)> {
    let mut stamps = seconds.iter().copied().filter(|t| t.is_finite());
    let first = stamps.next()?;
    Some((first, stamps.next_back().unwrap_or(first)))
}

impl Lag {
    /// Whether the motion comes before the pressure, beyond what the lag leaves open.
    pub fn leads(&self) -> bool {
        self.value_s + LAG_STDS * self.std_s < 0.0
    }

    /// Whether it does so beyond doubt: then it is told, and heeded.
    fn leads_clearly(&self) -> bool {
        self.value_s + UNUSUAL_STDS * self.std_s + UNUSUAL_STEPS * self.step_s < 0.0
    }

    /// `0.350 s ± 0.002 s`, with twice the standard uncertainty.
    pub fn text(&self) -> String {
        format!("{:.4} s ± {:.4} s", self.value_s, LAG_STDS * self.std_s)
    }
}

/// A lag that was found in a run.
type FoundLag<'r> = (&'r AlignedRun<'r>, &'r RunLag, Lag);

/// Events of a stream, paired with those of the reference.
#[derive(Default)]
struct Paired {
    pairs: Vec<(Event, Event, f64)>,
    found: (usize, usize),
    refused: Vec<String>,
}

impl Paired {
    fn add(&mut self, ours: &Events, theirs: &Events, sync: &SyncSpec) {
        self.found.0 += ours.found.len() + ours.in_gaps;
        self.found.1 += theirs.found.len() + theirs.in_gaps;
        match matched(&ours.found, &theirs.found, DRIFT_MAX) {
            Ok(pairs) => {
                // Two recordings of one event are really apart by so much, each time anew.
                self.pairs.extend(pairs.into_iter().map(|(r, d)| (ours.found[r], theirs.found[d], sync.std_s)));
            }
            Err(why) => self.refused.push(format!("{} of `{}`: {why}", sync_name(sync), sync.channels.join("`, `"))),
        }
    }
}

fn sync_name(sync: &SyncSpec) -> &'static str {
    use pneuval_ingest::manifest::SyncEvent as E;
    match sync.event {
        E::Edges => "edges",
        E::Steps => "steps",
        E::Tap => "taps",
    }
}

impl<'a> Alignment<'a> {
    /// The runs of a session on one time each.
    ///
    /// # Errors
    /// At a response whose pressure and motion cannot be set against each other in any run, with the reason: [`IngestError::Unusable`] if
    /// declared events are not in the logs, [`IngestError::Malformed`] if nothing declares how the clocks lie.
    pub fn of(session: &'a Session) -> Result<Self, IngestError> {
        let manifest = &session.manifest;
        let mut alignment = Self::default();
        for run in &session.runs {
            let mut aligned = AlignedRun::new(manifest, run);
            aligned.synchronise(&manifest.syncs);
            alignment.tell_clocks(manifest, &aligned);
            for spec in &manifest.responses {
                aligned.lags_of(spec, manifest.lag);
            }
            alignment.runs.push(aligned);
        }
        for spec in &manifest.responses {
            alignment.check(manifest, spec)?;
            alignment.tell_lags(manifest, spec);
        }
        Ok(alignment)
    }

    fn tell(&mut self, kind: FindingKind, severity: Severity, file: String, count: usize, text: String) {
        self.findings.push(Finding { kind, severity, file, channel: None, spans: vec![], count, text });
    }

    /// What is odd about the clocks of a run.
    fn tell_clocks(&mut self, manifest: &SessionManifest, aligned: &AlignedRun) {
        let run = aligned.run;
        for clock in &aligned.clocks {
            let (stream, reference) = (&run.streams[clock.stream], &run.streams[clock.reference]);
            let here = format!("run {}: the clock of {} on that of {}", run.id, stream.title(), reference.title());
            let fit = match &clock.fit {
                Ok(fit) => fit,
                Err(why) => {
                    let text = format!("{here}: the declared events do not set it: {why}");
                    self.tell(FindingKind::SyncMismatch, Severity::Note, file_of(manifest, run, stream), 1, text);
                    continue;
                }
            };
            if fit.drift.is_none() {
                let text = format!(
                    "{here}: one event, at {:.3} s; the offset is known there, and what the clock gains is not: record an event at both ends",
                    fit.on_reference(fit.middle_s)
                );
                self.tell(FindingKind::DriftUnknown, Severity::Note, file_of(manifest, run, stream), 1, text);
            }
            if let Some(drift) = fit.drift.filter(|drift| drift.value.abs() - drift.half_width > DRIFT_USUAL) {
                let text = format!(
                    "{here}: it {} {:.0} ppm (± {:.0} ppm), where a quartz clock is off by some 10 to 100. Are its stamps in the unit they are \
                     declared in, and are these recordings of the same events?",
                    if drift.value < 0.0 { "gains" } else { "loses" },
                    1e6 * drift.value.abs(),
                    1e6 * drift.half_width
                );
                self.tell(FindingKind::SyncMismatch, Severity::Note, file_of(manifest, run, stream), fit.events, text);
            }
            if fit.inflation > 1.0 {
                let text = format!(
                    "{here}: {} events differ by {} (root mean square), {} times as much as they are uncertain; offset and drift are that less \
                     sure. Are they recordings of the same events?",
                    fit.events,
                    seconds_text(fit.residual_s),
                    format::significant(fit.inflation, 3)
                );
                self.tell(FindingKind::SyncMismatch, Severity::Note, file_of(manifest, run, stream), fit.events, text);
            }
        }
    }

    /// A response can be read in one run at least; runs in which it cannot are lost, and told.
    fn check(&mut self, manifest: &SessionManifest, spec: &ResponseSpec) -> Result<(), IngestError> {
        let mut apart: Vec<(String, String, String, String)> = Vec::new();
        // Declared events that are not in the logs keep it from being read in every run.
        let mut is_refused = true;
        let mut readable = 0;
        for aligned in &self.runs {
            let run = aligned.run;
            if !spec.channels().all(|id| run.channels.contains_key(id)) {
                continue;
            }
            let Some(state) = spec.state_channels().find_map(|id| Some(run.channels.get(id)?.stream)) else { continue };
            let why = spec.measured.iter().find_map(|id| {
                let stream = run.channels.get(id)?.stream;
                let is_apart = aligned.reach(spec, state, stream) == Reach::Apart;
                (is_apart && stream != state).then(|| (id, stream, aligned.why_apart(spec, stream, state)))
            });
            match why {
                // A total lag below zero is found, told, and read at no point.
                Some((_, _, None)) | None => readable += 1,
                Some((id, stream, Some(why))) => {
                    let pressure = spec.pressure.first().map_or("", |(id, _)| id);
                    let of = |stream: usize| run.streams[stream].title();
                    let names = format!("`{pressure}` from {}, `{id}` from {}", of(state), of(stream));
                    is_refused &= aligned.refused(stream, state).is_some();
                    apart.push((run.id.clone(), names, why, file_of(manifest, run, &run.streams[stream])));
                }
            }
        }
        let Some((run, names, why, _)) = apart.first() else { return Ok(()) };
        let place = || Place::new(&manifest.file, Some(spec.line), Some(format!("response `{}`", spec.quantity.id)));
        if readable == 0 && is_refused {
            // What was declared is not what was recorded.
            return Err(IngestError::Unusable {
                place: place(),
                expected: "events of [[sync]] that the devices of a run recorded".to_owned(),
                found: format!("{names}; run {run}: {why}"),
                next: "record the events again, name other channels or another `event` in [[sync]], or remove it and say lag = \"physical\" if \
                       the clocks agree"
                    .to_owned(),
            });
        }
        if readable == 0 {
            return Err(IngestError::Malformed {
                place: place(),
                expected: "channels that share one clock, or clocks that can be set against each other".to_owned(),
                found: format!("{names}; run {run}: {why}"),
                next: "add clocks = \"one\" if one clock stamped them all, [[sync]] for events that both recorded, or lag = \"physical\" if the \
                       clocks agree"
                    .to_owned(),
            });
        }
        for (run, names, why, file) in apart {
            let text = format!(
                "{}, run {run}: {names} cannot be set against each other: {why}. Nothing is read there",
                spec.quantity.id
            );
            self.tell(FindingKind::ClockUnaligned, Severity::Lost, file, 1, text);
        }
        Ok(())
    }

    /// What is odd about the lags of a response, table by table.
    fn tell_lags(&mut self, manifest: &SessionManifest, spec: &ResponseSpec) {
        let mut of_tables: BTreeMap<(String, &str), Vec<FoundLag>> = BTreeMap::new();
        for aligned in &self.runs {
            for of_run in aligned.lags.iter().filter(|of_run| of_run.quantity == spec.quantity.id) {
                if let Ok(found) = of_run.found {
                    let table = aligned.run.streams[of_run.stream].title();
                    of_tables.entry((table, of_run.meaning.id())).or_default().push((aligned, of_run, found));
                }
            }
        }
        let mut told = Vec::new();
        for ((table, _), lags) in of_tables {
            let Some((first, of_run, _)) = lags.first() else { continue };
            let names = format!("{}: `{}` of {table} behind `{}`", spec.quantity.id, of_run.channel, of_run.pressure);
            let each: Vec<String> =
                lags.iter().map(|(run, _, lag)| format!("{} in run {}", lag.text(), run.run.id)).collect();
            let file = file_of(manifest, first.run, &first.run.streams[of_run.stream]);
            let n = lags.len();
            match of_run.meaning {
                Meaning::Total => {
                    let leading: Vec<&str> =
                        lags.iter().filter(|(.., lag)| lag.leads()).map(|(run, ..)| run.run.id.as_str()).collect();
                    let (severity, then) = if leading.is_empty() {
                        let then = "a plateau is read only where its window lies in it either way. [[sync]] tells the two apart, or `lag` which \
                                    of them it is";
                        (Severity::Note, then.to_owned())
                    } else {
                        let then = format!(
                            "in {} the motion leads the pressure, which no specimen does: a clock is off, and nothing is read there; declare \
                             [[sync]], or lag = \"clock\" to shift the stamps by it",
                            leading.join(", ")
                        );
                        (Severity::Lost, then)
                    };
                    let text = format!(
                        "{names}: total lag {}. It is that of the clocks and that of the specimen in sum; nothing is shifted, and {then}",
                        list(&each)
                    );
                    told.push((FindingKind::TotalLag, severity, file, n, text));
                }
                Meaning::Clock => {
                    let text = format!(
                        "{names}: the stamps are moved back by the lag, declared to be the clock's: {}",
                        list(&each)
                    );
                    told.push((FindingKind::ClockShift, Severity::Note, file, n, text));
                }
                Meaning::Physical => {}
            }
            if of_run.meaning != Meaning::Clock
                && let Some(text) = unusual(&lags)
            {
                let (aligned, of_run, _) = lags[text.0];
                let file = file_of(manifest, aligned.run, &aligned.run.streams[of_run.stream]);
                told.push((FindingKind::UnusualLag, Severity::Note, file, text.1, format!("{names}: {}", text.2)));
            }
        }
        for (kind, severity, file, count, text) in told {
            self.tell(kind, severity, file, count, text);
        }
    }
}

impl AlignedRun<'_> {
    /// Why a motion cannot be read against its pressure; `None` where a lag is known.
    fn why_apart(&self, spec: &ResponseSpec, stream: usize, state: usize) -> Option<String> {
        let of_it = |lag: &&RunLag| lag.quantity == spec.quantity.id && lag.stream == stream;
        let refused = self.refused(stream, state);
        match self.lags.iter().find(of_it).map(|lag| &lag.found) {
            Some(Ok(_)) if refused.is_none() => None,
            Some(Err(why)) => Some(refused.map_or_else(|| why.clone(), |refused| format!("{refused}; {why}"))),
            _ => Some(refused.cloned().unwrap_or_else(|| "one of them has no stamps".to_owned())),
        }
    }
}

/// Runs whose lag is far from that of the others, or that lead: the first of them, how many, and words.
fn unusual(lags: &[FoundLag]) -> Option<(usize, usize, String)> {
    let mut values: Vec<f64> = lags.iter().map(|(.., lag)| lag.value_s).collect();
    values.sort_by(f64::total_cmp);
    let middle = f64::midpoint(values[(values.len() - 1) / 2], values[values.len() / 2]);
    let of_others = lags.iter().map(|(.., lag)| lag.std_s).fold(f64::INFINITY, f64::min);
    let is_far = |lag: &Lag, from: f64| {
        (lag.value_s - from).abs() > UNUSUAL_STDS * lag.std_s.hypot(of_others) + UNUSUAL_STEPS * lag.step_s
    };
    let leads = |(_, of_run, lag): &FoundLag| of_run.meaning == Meaning::Physical && lag.leads_clearly();
    let is_odd = |found: &FoundLag| is_far(&found.2, middle) || leads(found);
    let odd: Vec<usize> = (0..lags.len()).filter(|&i| is_odd(&lags[i])).collect();
    let each: Vec<String> = odd.iter().map(|&i| format!("{} in run {}", lags[i].2.text(), lags[i].0.run.id)).collect();
    let first = *odd.first()?;
    let usual = if lags.len() > 1 {
        format!(", where the middle of {} runs is {middle:.4} s", lags.len())
    } else {
        String::new()
    };
    let why = if lags.iter().any(leads) {
        "No motion precedes its pressure: the clocks are not what the session says of them, or the pressure is smoothed by its instrument. \
         What is measured is read only where its window lies in the plateau either way"
    } else {
        "Is a clock off, or was a channel delayed?"
    };
    Some((first, odd.len(), format!("a lag of {}{usual}. {why}", list(&each))))
}

/// The first of many.
fn list(texts: &[String]) -> String {
    const SHOWN: usize = 4;
    let more = if texts.len() > SHOWN { format!(" and {} more", texts.len() - SHOWN) } else { String::new() };
    format!("{}{more}", texts[..texts.len().min(SHOWN)].join(", "))
}

fn seconds_text(seconds: f64) -> String {
    format!("{} ms", format::significant(1e3 * seconds, 3))
}

/// The file of a stream.
fn file_of(manifest: &SessionManifest, run: &Run, stream: &Stream) -> String {
    let spec = manifest.runs.iter().find(|spec| spec.id == run.id);
    let file = spec.and_then(|spec| stream.device.as_ref().map_or(Some(&spec.file), |device| spec.files.get(device)));
    file.cloned().unwrap_or_default()
}
