//! From a session's manifest and its logs to channels in SI units.
//!
//! ```text
//! raw file -> Recording -> rows of the run -> unit or calibration -> gauge -> tare -> against its command -> derived -> Run
//! ```
//!
//! Nothing is repaired: what is no number, or what a calibration refuses, is a hole (NaN) in the channel and a [`Finding`] with
//! its place. A session is refused as unusable only where no sample of a required channel survives.
//!
//! Files are read one after the other, each with the columns that the session asks for and no others; [`Session::load`] keeps the
//! runs of all of them, [`FileRuns::read`] gives those of one.

mod bases;
mod derive;
mod follow;
mod log;
mod reader;
mod tell;

use std::collections::BTreeMap;

pub(crate) use bases::Bases;
use log::{Log, columns_asked};
use reader::Reader;

use crate::camera::photograph::Photograph;
use crate::error::{IngestError, Place};
use crate::finding::{self, Finding, FindingKind, LineMap, Severity};
use crate::formats;
use crate::formats::stamps::Epoch;
use crate::manifest::{
    Abscissa, Clocks, FileDigest, LogFile, PointRule, ResponseSpec, Rig, SessionManifest, SyncSpec, Views,
};
use crate::raw::RawFile;
use crate::recording::Keep;
use crate::units::{Dimension, Unit};

/// A session with its data.
#[derive(Debug, Clone, PartialEq)]
pub struct Session {
    /// What the user wrote.
    pub manifest: SessionManifest,
    /// The rig, if channels name instruments.
    pub rig: Option<Rig>,
    /// Its runs, in the order of the manifest.
    pub runs: Vec<Run>,
    /// Every log read, with its digest.
    pub files: Vec<FileDigest>,
    /// What a reader should know, in the order of runs.
    pub findings: Vec<Finding>,
}

/// One run: channels, each on the clock of its stream.
#[derive(Debug, Clone, PartialEq)]
pub struct Run {
    /// Its id.
    pub id: String,
    /// Its logs, as far as they could be used: its `file`, then those of devices.
    pub files: Vec<String>,
    /// Clocks: one for each table of a log that a channel comes from.
    pub streams: Vec<Stream>,
    /// Channels by id.
    pub channels: BTreeMap<String, Channel>,
    /// Some of its pictures, in the order of its logs.
    pub photographs: Vec<Photograph>,
}

/// Samples that share a clock.
#[derive(Debug, Clone, PartialEq)]
pub struct Stream {
    /// The device that logged it; `None`: it is of the run's `file`.
    pub device: Option<String>,
    /// The table of the log: a topic, or empty.
    pub name: String,
    /// Time of each sample in s, if there is a clock; NaN where the stamp is no number or goes back.
    pub seconds: Option<Vec<f64>>,
    /// The instant from which `seconds` count; `None`: from a zero that only the device knows.
    pub epoch: Option<Epoch>,
    /// What was added to the stamps of the file, in s, so that they count from there.
    pub shift_s: f64,
    /// Line of the log of each sample; empty for files without lines.
    pub lines: LineMap,
    /// Samples.
    pub samples: usize,
}

/// One channel.
#[derive(Debug, Clone, PartialEq)]
pub struct Channel {
    /// Index of its stream.
    pub stream: usize,
    /// The unit it is shown in.
    pub unit: Unit,
    /// Samples in SI units; NaN is a hole.
    pub values_si: Vec<f64>,
    /// Standard uncertainty of one sample in SI units, where an instrument declares one.
    pub std_si: Option<f64>,
    /// Asked of a regulator, not measured.
    pub commanded: bool,
}

impl Run {
    /// Samples of all streams.
    pub fn samples(&self) -> usize {
        self.streams.iter().map(|stream| stream.samples).sum()
    }

    /// The stream that channels share; `None` if they do not, or there is no such channel.
    pub fn stream_of<'a>(&self, channels: impl IntoIterator<Item = &'a str>) -> Option<&Stream> {
        let mut streams = channels.into_iter().map(|id| self.channels.get(id).map(|channel| channel.stream));
        let first = streams.next()??;
        streams.all(|stream| stream == Some(first)).then(|| self.streams.get(first))?
    }

    /// Adds what another file holds of the same run.
    fn absorb(&mut self, other: Self) {
        let streams = self.streams.len();
        self.files.extend(other.files);
        self.streams.extend(other.streams);
        self.photographs.extend(other.photographs);
        self.channels.extend(other.channels.into_iter().map(|(id, mut channel)| {
            channel.stream += streams;
            (id, channel)
        }));
    }
}

impl Stream {
    /// What it is called in sentences: its device and its topic.
    pub fn title(&self) -> String {
        stream_title(self.device.as_deref(), &self.name)
    }
}

pub(crate) fn stream_title(device: Option<&str>, topic: &str) -> String {
    match (device, topic) {
        (None, "") => "`file`".to_owned(),
        (None, topic) => topic.to_owned(),
        (Some(device), "") => device.to_owned(),
        (Some(device), topic) => format!("{device} {topic}"),
    }
}

/// Opens a file that a session names.
pub type OpenBeside<'a> = &'a dyn Fn(&str) -> Result<RawFile<'static>, IngestError>;

/// What one file of a session gives.
#[derive(Debug, Clone, PartialEq)]
pub struct FileRuns {
    /// Runs, each with its place in the manifest and its findings.
    pub runs: Vec<(usize, Run, Vec<Finding>)>,
    /// Findings of the file.
    pub findings: Vec<Finding>,
    /// The origin of its stamps, where they are absolute.
    pub origin: Option<String>,
}

impl FileRuns {
    /// Reads the runs of one file.
    ///
    /// # Errors
    /// As [`Session::load`], for this file.
    pub fn read(views: &Views, rig: Option<&Rig>, of: LogFile, raw: &RawFile) -> Result<Self, IngestError> {
        let (file, manifest) = (of.name, views.of(of));
        let reader = Reader { manifest, rig };
        let columns = columns_asked(manifest);
        let recording = formats::read(raw, &manifest.reader, Keep::Only(&columns))?;
        let specs: Vec<_> = manifest.runs.iter().enumerate().filter(|(_, spec)| spec.file == file).collect();
        let mut log = Log::new(file, recording);
        let of_values = reader.of_values(&log);
        // A sole run of the whole file leaves nothing, and shares nothing.
        let sole = specs.len() == 1 && specs.iter().all(|(_, spec)| spec.rows.is_none());
        let mut claimed: BTreeMap<usize, Vec<Option<&str>>> = BTreeMap::new();
        let mut runs = Vec::new();
        for (i, spec) in specs {
            let parts = reader.parts(spec, &log)?;
            for part in parts.iter().filter(|_| !sole) {
                let rows = log.table(part.table).rows;
                reader.claim(spec, &log, part, claimed.entry(part.table).or_insert_with(|| vec![None; rows]))?;
            }
            if sole {
                log.expect(reader.columns_of(&parts, &log)?);
            }
            let mut findings = Vec::new();
            let mut run = reader.run(spec, &mut log, &parts, &mut findings)?;
            run.streams.iter_mut().for_each(|stream| stream.device = of.device.map(str::to_owned));
            run.photographs = log.photographs(&parts);
            runs.push((i, run, findings));
        }
        let mut findings: Vec<Finding> =
            claimed.iter().filter_map(|(table, claimed)| unclaimed(&log, *table, claimed)).collect();
        findings.extend(log.recording.findings.iter().map(|finding| reader.of_log(file, finding)));
        findings.extend(of_values);
        Ok(Self { runs, findings, origin: log.recording.origin })
    }
}

impl Session {
    /// Reads the logs of a session.
    ///
    /// # Errors
    /// [`IngestError::Malformed`] where the manifest and the logs do not fit together (a column, a unit, an instrument);
    /// [`IngestError::Unusable`] where no sample of a required channel is a number.
    pub fn load(manifest: SessionManifest, rig: Option<Rig>, open: OpenBeside) -> Result<Self, IngestError> {
        let raws = open_files(&manifest, open)?;
        let (mut lost, mut of_files) = (Vec::new(), Vec::new());
        let mut runs: Vec<(usize, Run, Vec<Finding>)> = Vec::new();
        let mut unusable = Vec::new();
        let views = manifest.views();
        let mut bases = Bases::new(&manifest);
        for (log, (_, raw)) in manifest.logs().into_iter().zip(&raws) {
            match FileRuns::read(&views, rig.as_ref(), log, raw) {
                Ok(mut read) => {
                    for (number, run, told) in &mut read.runs {
                        bases.align(*number, run, told)?;
                    }
                    runs.append(&mut read.runs);
                    of_files.append(&mut read.findings);
                }
                // One log that cannot be used does not take the others with it: it is lost, and told.
                Err(error @ IngestError::Unusable { .. }) => {
                    lost.push(unusable_file(log.name, &error));
                    unusable.push((log.device.map(str::to_owned), error));
                }
                Err(error) => return Err(error),
            }
        }
        // Of one run the `file` stays first.
        runs.sort_by_key(|(i, ..)| *i);
        let mut findings = lost;
        let mut whole: Vec<(usize, Run)> = Vec::new();
        for (i, run, mut told) in runs {
            findings.append(&mut told);
            match whole.last_mut().filter(|(last, _)| *last == i) {
                Some((_, before)) => before.absorb(run),
                None => whole.push((i, run)),
            }
        }
        let runs = whole.into_iter().map(|(_, run)| run).collect();
        findings.append(&mut of_files);
        let files = raws.into_iter().map(|(file, _)| file).collect();
        let mut session = Self { manifest, rig, runs, files, findings };
        // What a response needs and no file gives: the reason is that of the first file that should.
        let none_has = |id: &str| session.runs.iter().all(|run| !run.channels.contains_key(id));
        let missing = session.manifest.required().into_iter().find(|id| none_has(id));
        let device = missing.and_then(|id| session.manifest.device_of(id));
        let is_cause = |(of, _): &(Option<String>, IngestError)| of.as_deref() == device;
        if (missing.is_some() || session.runs.is_empty())
            && let Some(cause) = unusable.iter().position(is_cause)
        {
            return Err(unusable.swap_remove(cause).1);
        }
        session.check_responses()?;
        session.check_syncs()?;
        session.check_usable()?;
        let constant = tell::constant(&session);
        session.findings.extend(constant);
        Ok(session)
    }

    /// The channels of a response measure what it says they do, on one clock, if it needs one.
    fn check_responses(&self) -> Result<(), IngestError> {
        for response in &self.manifest.responses {
            let refused = |expected: String, found: String, next: &str| IngestError::Malformed {
                place: Place::new(
                    &self.manifest.file,
                    Some(response.line),
                    Some(format!("response `{}`", response.quantity.id)),
                ),
                expected,
                found,
                next: next.to_owned(),
            };
            let pressures = response.pressure.iter().map(|(channel, _)| (channel, Dimension::Pressure));
            let measured = response.measured.iter().map(|channel| (channel, response.quantity.unit.dimension));
            for (id, dimension) in pressures.chain(measured) {
                let Some(channel) = self.runs.iter().find_map(|run| run.channels.get(id)) else { continue };
                if channel.unit.dimension != dimension {
                    let next = "correct the unit of the channel or of the quantity, or name an instrument";
                    let expected = format!("channel `{id}` as {}", dimension.name());
                    return Err(refused(expected, format!("unit `{}`", channel.unit.symbol), next));
                }
            }
            for run in &self.runs {
                // A run may lack the channels of a file that cannot be used: the response does without the run.
                if response.channels().all(|id| run.channels.contains_key(id))
                    && let Some((expected, found, next)) = clash(&self.manifest, response, run)
                {
                    return Err(refused(expected.to_owned(), found, next));
                }
            }
        }
        Ok(())
    }

    /// The channels of a sync event stand on clocks of their own, in every run.
    fn check_syncs(&self) -> Result<(), IngestError> {
        for sync in &self.manifest.syncs {
            let refused = |expected: &str, found: String, next: &str| IngestError::Malformed {
                place: Place::new(&self.manifest.file, Some(sync.line), Some("key `channels` of [[sync]]".to_owned())),
                expected: expected.to_owned(),
                found,
                next: next.to_owned(),
            };
            let reference = |run: &Run, sync: &SyncSpec| Some(run.channels.get(sync.channels.first()?)?.stream);
            for run in &self.runs {
                let first = self.manifest.syncs.iter().find_map(|sync| reference(run, sync));
                if let (Some(first), Some(here)) = (first, reference(run, sync))
                    && first != here
                {
                    let found = format!("that of {}", run.streams[here].title());
                    let expected =
                        format!("the reference clock of the other [[sync]], that of {}", run.streams[first].title());
                    return Err(refused(&expected, found, "name a channel of that clock: all are set on one"));
                }
                let streams: Vec<(&String, usize)> =
                    sync.channels.iter().filter_map(|id| Some((id, run.channels.get(id)?.stream))).collect();
                for (i, (id, stream)) in streams.iter().enumerate() {
                    let Some(clock) = run.streams.get(*stream) else { continue };
                    if let Some((other, _)) = streams[..i].iter().find(|(_, other)| other == stream) {
                        let found = format!("`{other}` and `{id}`, both of {} in run {}", clock.title(), run.id);
                        let next = "keep one of each clock: one clock needs no events to agree with itself";
                        return Err(refused("channels of several clocks", found, next));
                    }
                    if clock.seconds.is_none() {
                        let found = format!("none in {}, of which `{id}` is", clock.title());
                        let next = "add `clock` to the device, or [clock] for the runs' `file`";
                        return Err(refused("a clock, to set against the others", found, next));
                    }
                }
            }
        }
        Ok(())
    }

    /// Every required channel has a sample that is a number.
    fn check_usable(&self) -> Result<(), IngestError> {
        for id in self.manifest.required() {
            let channels = || self.runs.iter().filter_map(|run| run.channels.get(id));
            if channels().any(|channel| channel.values_si.iter().any(|v| v.is_finite())) {
                continue;
            }
            let samples: usize = channels().map(|channel| channel.values_si.len()).sum();
            let files: Vec<&str> = self.files.iter().map(|f| f.name.as_str()).collect();
            return Err(IngestError::Unusable {
                place: Place::new(&files.join(", "), None, Some(format!("channel `{id}`"))),
                expected: "at least one sample that is a number".to_owned(),
                found: format!("none of {samples}"),
                next: "check the column, its unit and its calibration; the findings say what was refused".to_owned(),
            });
        }
        Ok(())
    }

    /// Lines of the logs that hold no sample and should have.
    pub fn lines_skipped(&self) -> usize {
        let skipped = |f: &&Finding| f.kind == FindingKind::SkippedLine && f.severity == Severity::Excluded;
        self.findings.iter().filter(skipped).map(|f| f.count).sum()
    }
}

/// Why the channels of a response cannot be set against each other in a run: expected, found, next.
fn clash(
    manifest: &SessionManifest,
    response: &ResponseSpec,
    run: &Run,
) -> Option<(&'static str, String, &'static str)> {
    let stream = |id: &str| run.streams.get(run.channels.get(id)?.stream);
    let named = |ids: &mut dyn Iterator<Item = &str>| {
        let name = |id: &str| format!("`{id}` from {}", stream(id).map_or_else(String::new, Stream::title));
        ids.map(name).collect::<Vec<_>>().join(", ")
    };
    let all = || named(&mut response.channels());
    let is_one = run.stream_of(response.channels()).is_some();
    match (&response.points, manifest.clocks) {
        (PointRule::Trajectory(_), _) if !is_one => {
            let next = "log them together: samples of two tables have no partners";
            return Some(("channels of one table", all(), next));
        }
        (PointRule::Samples { .. }, Clocks::Unsaid) if !is_one => {
            let next = "say from = \"plateaus\" in `points`, and declare how the clocks lie to each other: [[sync]] for events that both \
                        recorded, or clocks = \"one\" if one clock stamped them all";
            return Some(("channels that share one clock", all(), next));
        }
        (PointRule::Samples { .. }, Clocks::One) if !is_one => {
            let next = "say from = \"plateaus\" in `points`: the mean over a plateau needs no partners";
            return Some(("channels of one table: samples of two have no partners", all(), next));
        }
        (rule, _) if rule.is_timed() && run.stream_of(response.state_channels()).is_none() => {
            let next = "log them together, or make a response for each";
            let found = named(&mut response.state_channels());
            return Some(("pressures and conditions of one table, on which plateaus are found", found, next));
        }
        _ => {}
    }
    let bare = response.channels().filter_map(stream).find(|stream| stream.seconds.is_none());
    let (needs_clock, what_for) = match &response.points {
        PointRule::Samples { .. } => (false, ""),
        PointRule::Plateaus { .. } => (true, "a clock, to find plateaus by"),
        PointRule::Windows { .. } => (true, "a clock, to find windows by"),
        PointRule::Trajectory(rule) => (rule.at == Abscissa::Time, "a clock, to compare at equal time by"),
    };
    let bare = bare.filter(|_| needs_clock)?;
    let found = if is_one { "none".to_owned() } else { format!("none in {}", bare.title()) };
    let next = match bare.device {
        None => "add [clock] with `column` and `unit`, or with `rate`",
        Some(_) => "add `clock` to the device, with `column` and `unit`, or with `rate`",
    };
    Some((what_for, found, next))
}

/// Opens every file of a session, each with its digest. Two logs of the same bytes are one log: they are no repeats.
///
/// # Errors
/// As `open`; [`IngestError::Malformed`] at the run that names the second of two equal files.
pub fn open_files(
    manifest: &SessionManifest,
    open: OpenBeside,
) -> Result<Vec<(FileDigest, RawFile<'static>)>, IngestError> {
    let mut files: Vec<(FileDigest, RawFile)> = Vec::new();
    let logs = manifest.logs();
    for log in &logs {
        let raw = open(log.name)?;
        files.push((FileDigest { name: log.name.to_owned(), sha256: raw.sha256()? }, raw));
    }
    for (i, (log, (file, _))) in logs.iter().zip(&files).enumerate() {
        let Some((other, _)) = files[..i].iter().find(|(other, _)| other.sha256 == file.sha256) else { continue };
        let found = format!("{}, byte for byte {}", crate::error::shown(&file.name), crate::error::shown(&other.name));
        let next = "remove the run, or name its log".to_owned();
        return Err(Reader { manifest, rig: None }.malformed(log.line, "a log of its own", &found, next));
    }
    Ok(files)
}

/// Rows of a table that belong to no run.
fn unclaimed(log: &Log, table: usize, claimed: &[Option<&str>]) -> Option<Finding> {
    let rows: Vec<usize> = (0..claimed.len()).filter(|&row| claimed[row].is_none()).collect();
    let first = *rows.first()?;
    let lines = &log.table(table).lines;
    let mut spans = Vec::new();
    for &row in &rows {
        finding::extend(&mut spans, lines.span(row, row));
    }
    Some(Finding {
        kind: FindingKind::UnclaimedRows,
        severity: Severity::Note,
        file: log.file.to_owned(),
        channel: None,
        spans,
        count: rows.len(),
        text: format!("{} of {} rows belong to no run, the first at {}", rows.len(), claimed.len(), lines.place(first)),
    })
}

/// The finding of a log that cannot be used.
pub fn unusable_file(file: &str, error: &IngestError) -> Finding {
    let words: Vec<String> = error.to_string().lines().map(|line| line.trim().to_owned()).collect();
    Finding {
        kind: FindingKind::UnusableFile,
        severity: Severity::Lost,
        file: file.to_owned(),
        channel: None,
        spans: vec![],
        count: 1,
        text: format!("the log cannot be used: {}", words.join("; ")),
    }
}
