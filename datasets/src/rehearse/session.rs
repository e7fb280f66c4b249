//! One session: its runs on the bench, faults, files, `session.toml`, `truth.json`.

use std::path::Path;

use pneuval_ingest::IngestError;
use pneuval_ingest::digest;
use pneuval_ingest::error::suggestion;
use pneuval_ingest::finding::FindingKind;
use pneuval_ingest::formats::Format;

use super::bench::{Bench, DeviceLog, Leak, RunLog, RunSetting};
use super::faults::{Asked, Fault, FaultRecord, Layout, Target, line_number, spoil_bytes, spoil_log};
use super::files::{LogFile, column_of};
use super::manifests::{RunFiles, SessionText, follows};
use super::photographs::{self, Shooting};
use super::plan::{Channel, Device, PlanCamera, Shows};
use super::random::Normal;
use super::record::{FileRecord, PictureRecord, RunRecord, TruthRecord, points};
use super::states::Group;
use super::{Prepared, Rehearsal, Sink, Written};

/// The share of the pressure that a leak costs, and the share of the run after which it begins.
const LEAK: (f64, f64) = (0.15, 0.4);

/// Numbers that are logged in one run: far more than a lab logs in a day, and what memory holds.
const RUN_NUMBERS_MAX: f64 = 1e8;

/// Pictures of one run.
const PICTURES_MAX: usize = 2000;

/// A session that is written.
pub(super) struct Session<'a> {
    pub rehearsal: &'a Rehearsal,
    pub bench: Bench<'a>,
    pub prepared: &'a Prepared,
    /// Its id.
    pub id: &'a str,
    /// Its folder, with a `/` behind it, or nothing.
    pub folder: &'a str,
    /// Which specimen, from zero, and what it makes of every deflection.
    pub specimen: usize,
    pub factor: f64,
}

/// A fault on its way into files.
struct Hit {
    fault: Fault,
    target: Target,
    record: FaultRecord,
}

/// What has been written so far.
struct Progress {
    record: TruthRecord,
    runs: Vec<RunFiles>,
    /// The files of the first run.
    files: Vec<LogFile>,
    samples: usize,
    run_s: f64,
}

impl Session<'_> {
    /// Writes it.
    pub fn write(&self, sink: Sink) -> Result<Written, IngestError> {
        let Self { rehearsal, bench, prepared, id, folder, .. } = self;
        let (plan, sitting, request) = (bench.plan, bench.sitting, &rehearsal.request);
        let ids = run_ids(&prepared.groups, request.repeats);
        let asked = self.asked(&ids)?;
        let mut progress = Progress {
            record: TruthRecord::new(plan, id, request.seed, self.factor),
            runs: vec![],
            files: vec![],
            samples: 0,
            run_s: 0.0,
        };
        let groups = (0..request.repeats).flat_map(|_| &prepared.groups);
        for (run, group) in ids.iter().zip(groups) {
            let here: Vec<&Asked> = asked.iter().filter(|asked| asked.run.as_ref() == Some(run)).collect();
            self.run(run, group, &here, &mut progress, sink)?;
        }
        let serial = format!("rehearsed-{}", self.specimen + 1);
        let note = rehearsal.note();
        let text = SessionText {
            plan,
            sitting,
            id,
            serial: &serial,
            note: &note,
            devices: &progress.files,
            runs: &progress.runs,
            has_one_clock: !request.own_clocks,
        };
        sink(&format!("{folder}session.toml"), text.write().as_bytes())?;
        let mut json = serde_json::to_string_pretty(&progress.record)
            .map_err(|source| IngestError::write(Path::new("truth.json"), source.into()))?;
        json.push('\n');
        sink(&format!("{folder}truth.json"), json.as_bytes())?;
        Ok(Written {
            id: (*id).to_owned(),
            folder: folder.trim_end_matches('/').to_owned(),
            runs: progress.runs.len(),
            samples: progress.samples,
            run_s: progress.run_s,
            faults: progress.record.faults,
        })
    }

    /// Runs once, and writes the files.
    fn run(
        &self,
        run: &str,
        group: &Group,
        asked: &[&Asked],
        progress: &mut Progress,
        sink: Sink,
    ) -> Result<(), IngestError> {
        let (plan, sitting) = (self.bench.plan, self.bench.sitting);
        let mut hand = Normal::new(self.bench.seed, &format!("{} {run} triggers", self.id));
        let timeline = sitting.programme.timeline(&group.states, &mut hand);
        progress.run_s = progress.run_s.max(timeline.end_s);
        let leak = asked.iter().find(|asked| asked.fault == Fault::Leak).map(|asked| self.leak(asked, timeline.end_s));
        self.check_size(timeline.end_s)?;
        // Of several walls each is a specimen of its own; the others do not tire it.
        let cycles = progress.runs.len() / self.prepared.groups.len() * sitting.programme.cycles;
        let setting = RunSetting {
            id: run,
            sitting: self.id,
            factor: self.factor,
            cycles_before: plan.specimen.cycles_before + cycles as u64,
            leak: leak.transpose()?,
        };
        let mut log = self.bench.run(&timeline, &setting);
        let mut hits = Vec::new();
        for asked in asked {
            hits.push(self.hit_log(asked, run, &mut log.devices)?);
        }
        let files = LogFile::of_run(plan, &log.devices);
        // Two logs of the same bytes would be one log: of an ideal rehearsal only this tells runs apart.
        let note = format!("{}; {run}", self.rehearsal.note());
        let (mut names, mut records, mut pictures) = (Vec::new(), Vec::new(), Vec::new());
        for file in &files {
            let name = file.name(run, files.len() == 1);
            if let Some(camera) = plan.devices[file.devices[0]].camera.as_ref() {
                let records_before = pictures.len();
                self.photographs(camera, file, &log, &name, &mut pictures, sink)?;
                let taken = &pictures[records_before..];
                progress.samples += taken.len();
                records.push(FileRecord {
                    name: name.clone(),
                    format: file.format.id(),
                    sha256: photographs::folder_sha256(taken),
                    samples: vec![(file.device.clone(), taken.len())],
                });
                names.push(name);
                continue;
            }
            let mut bytes = file.bytes(&note, self.rehearsal.request.bag)?;
            for hit in hits.iter_mut().filter(|hit| file.devices.contains(&hit.target.device)) {
                self.hit_file(hit, file, &name, &mut bytes);
            }
            sink(&format!("{}{name}", self.folder), &bytes)?;
            progress.samples += file.tables.iter().map(|table| table.rows).sum::<usize>();
            let samples = file.devices.iter().zip(&file.tables);
            let samples = samples.map(|(device, table)| (plan.devices[*device].id.clone(), table.rows)).collect();
            let sha256 = digest::sha256(&bytes);
            records.push(FileRecord { name: name.clone(), format: file.format.id(), sha256, samples });
            names.push(name);
        }
        progress.record.faults.extend(hits.into_iter().map(|hit| hit.record));
        let points = points(sitting, &log);
        progress.record.runs.push(RunRecord {
            id: run.to_owned(),
            files: records,
            triggers_s: timeline.triggers_s,
            points,
            pictures,
        });
        progress.runs.push(RunFiles { id: run.to_owned(), files: names });
        if progress.files.is_empty() {
            progress.files = files;
        }
        Ok(())
    }

    /// Takes the photographs of a run.
    fn photographs(
        &self,
        camera: &PlanCamera,
        file: &LogFile,
        log: &RunLog,
        folder: &str,
        pictures: &mut Vec<PictureRecord>,
        sink: Sink,
    ) -> Result<(), IngestError> {
        let (plan, device) = (self.bench.plan, file.devices[0]);
        let refused = |found: &str| {
            let (item, line) = (format!("camera `{}`", plan.devices[device].id), Some(plan.devices[device].line));
            let next = "correct the camera or the programme";
            self.rehearsal.malformed(line, &item, "pictures that can be rendered", found, next)
        };
        let Some(seen) = log.devices.iter().find(|log| log.device == device) else { return Ok(()) };
        let purpose = format!("{} {folder}", self.id);
        let shooting = Shooting::new(plan, camera, seen, self.bench.seed, &purpose);
        let rows = shooting.rows(&log.points, &self.bench.sitting.programme);
        if !(1..=PICTURES_MAX).contains(&rows.len()) {
            return Err(refused(&format!("{} pictures in a run, where 1 to {PICTURES_MAX} are taken", rows.len())));
        }
        for (index, row) in rows.iter().enumerate() {
            let (bytes, record) = shooting.take(*row, index, rows.len()).map_err(|why| refused(&why))?;
            sink(&format!("{}{folder}/{}", self.folder, record.name), &bytes)?;
            pictures.push(record);
        }
        Ok(())
    }

    /// A session that no memory holds is refused before it is made.
    fn check_size(&self, end_s: f64) -> Result<(), IngestError> {
        let plan = self.bench.plan;
        let numbers = |device: &Device| device.rate_hz * end_s * (2.0 + self.bench.channels_of(device).count() as f64);
        let numbers: f64 = plan.devices.iter().filter(|device| self.bench.logs(device)).map(numbers).sum();
        // The steps of the simulation are at least 200 in a second.
        if numbers.max(200.0 * end_s) <= RUN_NUMBERS_MAX {
            return Ok(());
        }
        let item = format!("programme of `{}`", self.bench.sitting.id);
        let expected = format!("runs of at most {RUN_NUMBERS_MAX:e} numbers");
        let found = format!("{end_s} s with {numbers:e} numbers");
        let next = "shorten holds or cycles, or lower the rates";
        Err(self.rehearsal.malformed(None, &item, &expected, &found, next))
    }

    /// The leak that a fault asks for.
    fn leak(&self, asked: &Asked, end_s: f64) -> Result<Leak, IngestError> {
        let target = self.target(asked)?;
        let shows = target.channel.map(|channel| &self.bench.plan.channels[channel].shows);
        let chamber = match shows {
            Some(Shows::Pressure(id)) => self.bench.sitting.programme.chambers.iter().position(|known| known == id),
            _ => None,
        };
        Ok(Leak { chamber: chamber.unwrap_or(0), from_s: LEAK.1 * end_s, share: LEAK.0 })
    }

    /// What a fault hits.
    fn target(&self, asked: &Asked) -> Result<Target, IngestError> {
        let found = asked.fault.target(asked.channel.as_deref(), &self.bench);
        let target = found.map_err(|found| self.nothing_to_hit(asked, &found))?;
        if self.bench.plan.devices[target.device].camera.is_some() {
            return Err(self.nothing_to_hit(asked, "a camera: faults are those of logs"));
        }
        Ok(target)
    }

    /// Whether a fault has something to hit in this session.
    pub fn can_carry(&self, asked: &Asked) -> Result<(), IngestError> {
        self.target(asked).map(|_| ())
    }

    fn nothing_to_hit(&self, asked: &Asked, found: &str) -> IngestError {
        let item = format!("fault `{}`", asked.name);
        let next = "name another channel, NAME@CHANNEL, another fault, or another --format";
        self.rehearsal.malformed(None, &item, "something that it can hit", found, next)
    }

    /// The faults that are asked for, each with its run.
    fn asked(&self, runs: &[String]) -> Result<Vec<Asked>, IngestError> {
        let with_run = |asked: &Asked| {
            let mut asked = asked.clone();
            if let Some(run) = asked.run.as_ref().filter(|run| !runs.contains(run)) {
                let next = suggestion(run, runs.iter().map(String::as_str));
                let item = format!("fault `{}`", asked.name);
                return Err(self.rehearsal.malformed(None, &item, "a run of the session", &format!("`{run}`"), &next));
            }
            asked.run = asked.run.or_else(|| runs.get(1).or(runs.first()).cloned());
            Ok(asked)
        };
        // What has nothing to hit here hits another sitting: that one of them can carry it was checked.
        let here = self.rehearsal.request.faults.iter().filter(|asked| self.can_carry(asked).is_ok());
        let all: Vec<Asked> = here.map(with_run).collect::<Result<_, _>>()?;
        for (index, asked) in all.iter().enumerate() {
            let target = self.target(asked)?;
            for other in &all[..index] {
                if other.run == asked.run && self.target(other)?.device == target.device {
                    let device = &self.bench.plan.devices[target.device].id;
                    let found = format!("`{}` and `{}` on `{device}`", other.name, asked.name);
                    let next = "put one of them into another run, NAME:RUN, or on another device, NAME@CHANNEL";
                    let item = format!("fault `{}`", asked.name);
                    return Err(self.rehearsal.malformed(None, &item, "one fault a device and run", &found, next));
                }
            }
        }
        Ok(all)
    }

    /// A fault of what is logged; one of bytes is only aimed.
    fn hit_log(&self, asked: &Asked, run: &str, logs: &mut [DeviceLog]) -> Result<Hit, IngestError> {
        let plan = self.bench.plan;
        let wrong = |found: &str| self.nothing_to_hit(asked, found);
        let target = self.target(asked)?;
        let device = &plan.devices[target.device];
        let channel = target.channel.map(|channel| &plan.channels[channel]);
        let Some(log) = logs.iter_mut().find(|log| log.device == target.device) else {
            return Err(wrong("a device that logs nothing"));
        };
        let rows = log.stamps_s.len();
        let mut noise = Normal::new(self.bench.seed, &format!("{run} fault {}", asked.name));
        let hit = spoil_log(asked.fault, &target, plan, log, &mut noise).map_err(|found| wrong(&found))?;
        let samples = match asked.fault {
            // As the regulator loses the pressure.
            Fault::Leak => (log.true_s.partition_point(|t| *t < LEAK.1 * log.true_s[rows - 1]) + 1, rows),
            _ => hit.unwrap_or((1, rows)),
        };
        // Whether any reading leaves the range of its instrument only the readings say.
        let is_beyond = channel.is_some_and(|channel| self.is_beyond(channel, target.channel, log));
        let follows = channel.is_some_and(|channel| follows(plan, channel).is_some());
        let expected = asked.fault.expected(device.format, follows, is_beyond).map_err(wrong)?;
        let record = FaultRecord {
            fault: asked.name,
            run: run.to_owned(),
            file: String::new(),
            device: device.id.clone(),
            channel: channel.map(|channel| channel.id.clone()),
            samples,
            lines: None,
            expected: expected.into_iter().map(FindingKind::id).collect(),
        };
        Ok(Hit { fault: asked.fault, target, record })
    }

    /// Whether a logged number of a channel lies beyond the range of its instrument, or where that is calibrated.
    fn is_beyond(&self, channel: &Channel, index: Option<usize>, log: &DeviceLog) -> bool {
        let instrument = channel.instrument.as_ref().and_then(|id| self.bench.rig.instruments.get(id));
        let column = log.columns.iter().find(|column| Some(column.channel) == index);
        let (Some(instrument), Some(column)) = (instrument, column) else { return false };
        column.values.iter().filter(|value| value.is_finite()).any(|value| {
            let measured = match &instrument.calibration {
                None => Some(instrument.output.from_si(instrument.input.to_si(*value))),
                Some(calibration) => calibration.apply(*value),
            };
            let valid = instrument.valid.is_none_or(|(min, max)| (min..=max).contains(value));
            let inside = |measured: f64| instrument.range.is_none_or(|(min, max)| (min..=max).contains(&measured));
            !valid || measured.is_none_or(|measured| !inside(measured))
        })
    }

    /// A fault of bytes, and where each fault lies in a file.
    fn hit_file(&self, hit: &mut Hit, file: &LogFile, name: &str, bytes: &mut Vec<u8>) {
        name.clone_into(&mut hit.record.file);
        let Some(index) = file.devices.iter().position(|device| *device == hit.target.device) else { return };
        let table = &file.tables[index];
        let channel = hit.target.channel.map(|channel| &self.bench.plan.channels[channel]);
        let column = channel.map(|channel| column_of(file.format, &channel.shows, &channel.id));
        let column = column
            .as_deref()
            .and_then(|name| Some((table.columns.iter().position(|column| column.name == name)?, name)));
        let layout = Layout { format: file.format, rows: table.rows, column };
        if let Some(samples) = spoil_bytes(hit.fault, &layout, bytes) {
            hit.record.samples = samples;
        }
        let has_lines = !matches!(file.format, Format::Mcap | Format::Tdms);
        if hit.fault == Fault::FlippedBit && !has_lines {
            // A chunk holds all channels.
            hit.record.channel = None;
        }
        if hit.fault == Fault::Truncated && has_lines {
            let line = bytes.iter().filter(|byte| **byte == b'\n').count() + 1;
            hit.record.lines = Some((line, line));
        } else if has_lines {
            let (first, last) = hit.record.samples;
            // A trailer is the line behind the last sample.
            let behind = usize::from(hit.fault == Fault::Trailer);
            let line = |sample: usize| line_number(bytes, table.rows + behind, sample - 1 + behind);
            hit.record.lines = line(first).zip(line(last));
        }
        // As findings count them.
        let (first, last) = hit.record.samples;
        hit.record.samples = (first - 1, last - 1);
    }
}

/// Ids of runs: every group once, then again.
fn run_ids(groups: &[Group], repeats: usize) -> Vec<String> {
    let id = |repeat: usize, group: &Group| match group.name.as_str() {
        "" => format!("run-{repeat}"),
        name => format!("{name}-{repeat}"),
    };
    (1..=repeats).flat_map(|repeat| groups.iter().map(move |group| id(repeat, group))).collect()
}
