//! A log's columns as the channels of a run.

use std::collections::BTreeMap;

use super::log::{ColumnId, Log, Part};
use super::{Channel, Run, Stream, tell};
use crate::error::{IngestError, Place, shown, suggestion};
use crate::finding::{Finding, FindingKind, Severity, clock_findings, leave_forward};
use crate::formats::stamps::Epoch;
use crate::manifest::{
    ChannelSpec, ClockSpec, ColumnRef, Instrument, PressureReference, Rig, RunSpec, SessionManifest,
};
use crate::recording::{Column, OUR_DAYS};
use crate::units::{Dimension, Unit};

/// What every run of a session is read with.
pub(super) struct Reader<'a> {
    pub manifest: &'a SessionManifest,
    pub rig: Option<&'a Rig>,
}

/// Where the numbers of a channel stand.
#[derive(Clone, Copy)]
struct Source<'a> {
    run: &'a RunSpec,
    part: &'a Part,
    id: ColumnId,
}

/// Stamps in s, and the instant from which they count, if that is known.
type Stamps = (Vec<f64>, Option<Epoch>);

/// The clock of a table.
struct Clock {
    column: ColumnId,
    /// The unit that the session declares.
    unit: Option<Unit>,
    /// What is added where a counter starts anew, in s.
    wrap_s: Option<f64>,
    /// Where the session asks for it.
    line: usize,
}

impl Reader<'_> {
    /// The samples of a run in each table of the log that a channel comes from, tables in the order in which channels name them.
    pub fn parts(&self, spec: &RunSpec, log: &Log) -> Result<Vec<Part>, IngestError> {
        let mut parts: Vec<Part> = Vec::new();
        for channel in &self.manifest.channels {
            let (table, _) = log.column(&channel.column, self, channel.line)?;
            if parts.iter().all(|part| part.table != table) {
                parts.push(log.part(spec, table, self)?);
            }
        }
        Ok(parts)
    }

    /// The column of every time that a run asks for numbers: of a channel, or of the clock of a part.
    pub fn columns_of(&self, parts: &[Part], log: &Log) -> Result<Vec<ColumnId>, IngestError> {
        let mut columns = Vec::new();
        for channel in &self.manifest.channels {
            columns.push(log.column(&channel.column, self, channel.line)?);
        }
        for part in parts {
            columns.extend(self.clock(log, part.table)?.map(|clock| clock.column));
        }
        Ok(columns)
    }

    /// Every row belongs to one run: twice the same row is no repeat.
    pub fn claim<'r>(
        &self,
        spec: &'r RunSpec,
        log: &Log,
        part: &Part,
        claimed: &mut [Option<&'r str>],
    ) -> Result<(), IngestError> {
        for row in part.rows() {
            if let Some(other) = claimed[row] {
                let line = log.table(part.table).lines.line_of(row);
                let found = if line > 0 {
                    format!("line {line} in run {other} too")
                } else {
                    format!("all of it in run {other} too")
                };
                let next = "correct `rows` or `file`: the same row twice is no repeat".to_owned();
                return Err(self.malformed(spec.line, "rows of its own", &found, next));
            }
            claimed[row] = Some(&spec.id);
        }
        Ok(())
    }

    /// A run of a log.
    pub fn run(
        &self,
        spec: &RunSpec,
        log: &mut Log,
        parts: &[Part],
        findings: &mut Vec<Finding>,
    ) -> Result<Run, IngestError> {
        let mut streams = Vec::with_capacity(parts.len());
        for part in parts {
            let (seconds, epoch) = self.seconds(spec, log, part, findings)?.unzip();
            let (name, lines) = (log.table(part.table).name.clone(), part.lines.clone());
            let epoch = epoch.flatten();
            streams.push(Stream { device: None, name, seconds, epoch, shift_s: 0.0, lines, samples: part.samples() });
        }
        let mut channels = BTreeMap::new();
        for channel in &self.manifest.channels {
            let id = log.column(&channel.column, self, channel.line)?;
            // `parts` has one for the table of every channel.
            let Some(stream) = parts.iter().position(|part| part.table == id.0) else { continue };
            let source = Source { run: spec, part: &parts[stream], id };
            let mut read = self.channel(channel, &source, log, findings)?;
            read.stream = stream;
            if channel.reference == Some(PressureReference::Absolute) {
                self.to_gauge(channel, spec, &mut read)?;
            }
            if let Some((value, unit)) = spec.zero.get(&channel.id) {
                self.zero(channel, spec, &mut read, (*value, *unit), findings)?;
            }
            if let Some(samples) = channel.tare_samples {
                tell::tare(channel, samples, spec, &mut read, findings);
            }
            channels.insert(channel.id.clone(), read);
        }
        self.follow(spec, &channels, &streams, findings)?;
        for derived in &self.manifest.derived {
            let channel = self.derive(derived, spec, &channels, &streams, findings)?;
            channels.insert(derived.id.clone(), channel);
        }
        Ok(Run { id: spec.id.clone(), files: vec![spec.file.clone()], streams, channels, photographs: vec![] })
    }

    /// Time of the samples of a part, by the clock of the session, or else by the file's own.
    fn seconds(
        &self,
        run: &RunSpec,
        log: &mut Log,
        part: &Part,
        findings: &mut Vec<Finding>,
    ) -> Result<Option<Stamps>, IngestError> {
        if let Some(ClockSpec::Rate(rate)) = &self.manifest.clock {
            return Ok(Some(((0..part.samples()).map(|i| i as f64 / rate).collect(), None)));
        }
        let Some(Clock { column: id, unit, wrap_s, line }) = self.clock(log, part.table)? else { return Ok(None) };
        let unit = self.unit(unit, log.at(id), line)?;
        self.check(unit, Dimension::Time, line)?;
        let name = log.table(id.0).full_name(&log.at(id).name);
        let is_dated = log.at(id).is_dated;
        let mut stamps = log.numbers(id, part, &run.id, findings);
        for stamp in &mut stamps {
            *stamp = unit.to_si(*stamp);
        }
        let lines = Some(&part.lines);
        if let Some(wrap_s) = wrap_s {
            findings.extend(tell::unwrapped(run, &name, part, &mut stamps, wrap_s));
        }
        let mut odd = clock_findings(&run.file, &name, &stamps, lines);
        if self.manifest.runs.iter().filter(|r| r.file == run.file).count() > 1 {
            for finding in &mut odd {
                finding.text = format!("run {}: {}", run.id, finding.text);
            }
        }
        findings.append(&mut odd);
        leave_forward(&mut stamps);
        let epoch = if is_dated {
            log.recording.origin.as_deref().and_then(Epoch::parse)
        } else {
            let first = stamps.iter().copied().find(|stamp| stamp.is_finite());
            first.filter(|first| OUR_DAYS.contains(first)).map(|_| Epoch::UNIX)
        };
        Ok(Some((stamps, epoch)))
    }

    /// The column that is the clock of a table: what the session says, or else the file's own.
    fn clock(&self, log: &Log, table: usize) -> Result<Option<Clock>, IngestError> {
        let here = log.table(table);
        let own = here.clock.map(|column| Clock { column: (table, column), unit: None, wrap_s: None, line: 1 });
        match &self.manifest.clock {
            None => Ok(own),
            Some(ClockSpec::Rate(_)) => Ok(None),
            Some(ClockSpec::Column { column, unit, wrap_s, line }) => {
                let column = log.column(column, self, *line)?;
                // A column of one topic is no clock of another: that keeps its own.
                let named = Clock { column, unit: *unit, wrap_s: *wrap_s, line: *line };
                Ok(if column.0 == table { Some(named) } else { own })
            }
            Some(ClockSpec::Stamp(stamp, line)) => {
                let column = stamp.column(here).and_then(|name| here.columns.iter().position(|c| c.name == name));
                let Some(column) = column else {
                    let expected = format!("`{}` in {}", stamp.names().join("` or `"), shown(&here.name));
                    let next = "take another `stamp`, or name a `column`".to_owned();
                    return Err(self.malformed(*line, &expected, "no such field", next));
                };
                Ok(Some(Clock { column: (table, column), unit: None, wrap_s: None, line: *line }))
            }
        }
    }

    /// The unit of a column: the manifest's, else the file's.
    fn unit(&self, declared: Option<Unit>, column: &Column, line: usize) -> Result<Unit, IngestError> {
        if let Some(unit) = declared {
            return Ok(unit);
        }
        let Some(text) = &column.unit else {
            let expected = format!("the unit of column `{}`, which the log does not say", column.name);
            return Err(self.malformed(line, &expected, "nothing", "add `unit`".to_owned()));
        };
        Unit::parse(text).ok_or_else(|| {
            let expected = format!("a known unit of column `{}` in the log", column.name);
            let next = format!("{}; or add `unit`", Unit::suggestion(text));
            self.malformed(line, &expected, &shown(text), next)
        })
    }

    pub fn check(&self, unit: Unit, dimension: Dimension, line: usize) -> Result<(), IngestError> {
        if unit.dimension == dimension {
            return Ok(());
        }
        let found = format!("unit `{}`", unit.symbol);
        Err(self.malformed(line, dimension.name(), &found, "correct the unit or the column".to_owned()))
    }

    fn channel(
        &self,
        spec: &ChannelSpec,
        source: &Source,
        log: &mut Log,
        findings: &mut Vec<Finding>,
    ) -> Result<Channel, IngestError> {
        let Source { run, part, id } = *source;
        let instrument = spec.instrument.as_deref().map(|id| self.instrument(id, spec)).transpose()?;
        let logged = self.logged_unit(spec, instrument, log.at(id), run, findings)?;
        let mut values = log.numbers(id, part, &run.id, findings);
        findings.extend(tell::no_value(spec, run, &values, part));
        let (unit, std_si) = match instrument {
            None => {
                let beyond = to_si(logged, &mut values);
                if !beyond.is_empty() {
                    findings.push(tell::overflow(spec, run, &beyond, part));
                }
                (logged, log.at(id).std.map(|std| logged.to_si(std) - logged.to_si(0.0)))
            }
            Some(instrument) => {
                self.check(logged, instrument.input.dimension, spec.line)?;
                let refused = calibrate(instrument, logged, &mut values);
                if !refused.is_empty() {
                    findings.push(tell::refusal(spec, run, instrument, logged, &refused, part));
                }
                findings.extend(tell::beyond_range(spec, run, instrument, &values, part));
                (instrument.output, instrument.uncertainty().map(|u| instrument.output.to_si(u)))
            }
        };
        if unit.dimension == Dimension::Pressure && spec.reference.is_none() {
            let expected = "`reference`: a pressure is gauge or absolute";
            let next = "add reference = \"gauge\", or \"absolute\" with the run's `atmosphere`";
            return Err(self.malformed(spec.line, expected, "nothing", next.to_owned()));
        }
        if spec.reference == Some(PressureReference::Absolute) {
            self.check(unit, Dimension::Pressure, spec.line)?;
        }
        Ok(Channel { stream: 0, unit, values_si: values, std_si, commanded: spec.commanded })
    }

    /// The unit of what is logged: the channel's own, else the file's where it is of the instrument's kind, else the instrument's.
    /// Where the file says another, that is told: one of them is wrong, and the user's word counts.
    fn logged_unit(
        &self,
        spec: &ChannelSpec,
        instrument: Option<&Instrument>,
        column: &Column,
        run: &RunSpec,
        findings: &mut Vec<Finding>,
    ) -> Result<Unit, IngestError> {
        let in_file = column.unit.as_deref().and_then(Unit::parse_loose).map(|(unit, _)| unit);
        if let (None, Some(instrument), Some(unit)) = (spec.unit, instrument, in_file)
            && unit.dimension == instrument.input.dimension
        {
            return Ok(unit);
        }
        let logged = self.unit(spec.unit.or(instrument.map(|i| i.input)), column, spec.line)?;
        if let Some(unit) = in_file.filter(|unit| *unit != logged) {
            let who = if spec.unit.is_some() { "session.toml" } else { "the instrument" };
            findings.push(Finding {
                kind: FindingKind::UnitMismatch,
                severity: Severity::Note,
                file: run.file.clone(),
                channel: Some(spec.id.clone()),
                spans: vec![],
                count: 1,
                text: format!(
                    "channel `{}` of run {}: {} says {}, the log says {}; {} is taken",
                    spec.id, run.id, who, logged.symbol, unit.symbol, logged.symbol
                ),
            });
        }
        Ok(logged)
    }

    fn instrument(&self, id: &str, spec: &ChannelSpec) -> Result<&Instrument, IngestError> {
        let instruments = self.rig.map(|rig| &rig.instruments);
        instruments.and_then(|all| all.get(id)).ok_or_else(|| {
            let known: Vec<&str> = instruments.into_iter().flat_map(|all| all.keys().map(String::as_str)).collect();
            let file = self.rig.map_or("the rig", |rig| rig.file.as_str());
            self.malformed(spec.line, &format!("an instrument of {file}"), &shown(id), suggestion(id, known))
        })
    }

    fn to_gauge(&self, spec: &ChannelSpec, run: &RunSpec, channel: &mut Channel) -> Result<(), IngestError> {
        let Some(atmosphere) = run.atmosphere_pa else {
            let expected = format!("`atmosphere`, because channel `{}` is absolute", spec.id);
            let next = "add atmosphere = { value = …, unit = \"kPa\" } to the run".to_owned();
            return Err(self.malformed(run.line, &expected, "nothing", next));
        };
        channel.values_si.iter_mut().for_each(|p| *p -= atmosphere);
        Ok(())
    }

    /// Subtracts what the run says the channel read at zero, and says so.
    fn zero(
        &self,
        spec: &ChannelSpec,
        run: &RunSpec,
        channel: &mut Channel,
        (value, unit): (f64, Unit),
        findings: &mut Vec<Finding>,
    ) -> Result<(), IngestError> {
        self.check(unit, channel.unit.dimension, run.line)?;
        if spec.reference == Some(PressureReference::Absolute) {
            let expected = format!("no zero for `{}`, which is absolute: the atmosphere is its zero", spec.id);
            return Err(self.malformed(run.line, &expected, "`zero`", "remove it, or correct `atmosphere`".to_owned()));
        }
        channel.values_si.iter_mut().for_each(|v| *v -= unit.to_si(value));
        findings.push(Finding {
            kind: FindingKind::Tared,
            severity: Severity::Note,
            file: run.file.clone(),
            channel: Some(spec.id.clone()),
            spans: vec![],
            count: channel.values_si.len(),
            text: format!("channel `{}` of run {}: set to zero at {value} {}", spec.id, run.id, unit.symbol),
        });
        Ok(())
    }

    /// A finding of the log, as one of the session: what lies in a column that nothing needs is worth knowing, and no loss.
    pub fn of_log(&self, file: &str, finding: &Finding) -> Finding {
        let mut finding = finding.clone();
        file.clone_into(&mut finding.file);
        let required = self.manifest.required();
        // A finding names a column, or a topic with all its fields.
        let needed = |named: &str| {
            let is_named = |c: &&ChannelSpec| match &c.column {
                ColumnRef::Number(_) => true,
                ColumnRef::Name(name) => {
                    name.strip_prefix(named).is_some_and(|rest| rest.is_empty() || rest.starts_with('.'))
                }
            };
            self.manifest.channels.iter().filter(is_named).any(|c| required.contains(&c.id.as_str()))
        };
        match (finding.severity, finding.channel.as_deref()) {
            (Severity::Excluded, Some(column)) if !needed(column) => finding.severity = Severity::Note,
            // Nothing where a number is needed is a sample less, as text is.
            (Severity::Note, Some(column)) if finding.kind == FindingKind::EmptyCell && needed(column) => {
                finding.severity = Severity::Excluded;
            }
            _ => {}
        }
        finding
    }

    /// What is odd about the numbers of the columns that channels come from.
    pub fn of_values(&self, log: &Log) -> Vec<Finding> {
        let mut ids: Vec<ColumnId> = Vec::new();
        for channel in &self.manifest.channels {
            // A column that is not there is an error of the run that asks for it.
            ids.extend(log.column(&channel.column, self, channel.line).ok().filter(|id| !ids.contains(id)));
        }
        let findings = |id: ColumnId| {
            let table = log.table(id.0);
            log.at(id).summary.findings(log.file, &table.full_name(&log.at(id).name), &table.lines)
        };
        ids.into_iter().flat_map(findings).collect()
    }

    pub fn malformed(&self, line: usize, expected: &str, found: &str, next: String) -> IngestError {
        IngestError::Malformed {
            place: Place::new(&self.manifest.file, Some(line), None),
            expected: expected.to_owned(),
            found: found.to_owned(),
            next,
        }
    }
}

/// Converts in place; samples whose numbers are too large for SI units become holes and are returned.
fn to_si(logged: Unit, values: &mut [f64]) -> Vec<usize> {
    let mut beyond = Vec::new();
    for (i, value) in values.iter_mut().enumerate() {
        let raw = *value;
        *value = logged.to_si(raw);
        if raw.is_finite() && !value.is_finite() {
            *value = f64::NAN;
            beyond.push(i);
        }
    }
    beyond
}

/// Logged values through an instrument, in SI units; NaN where it refuses, and those samples with what was logged.
fn calibrate(instrument: &Instrument, logged: Unit, values: &mut [f64]) -> Vec<(usize, f64)> {
    let mut refused = Vec::new();
    for (i, value) in values.iter_mut().enumerate() {
        let raw = *value;
        let x = instrument.input.from_si(logged.to_si(raw));
        let valid = instrument.valid.is_none_or(|(min, max)| x >= min && x <= max);
        let y = match &instrument.calibration {
            _ if !valid => None,
            None => Some(instrument.output.from_si(instrument.input.to_si(x))),
            Some(calibration) => calibration.apply(x),
        };
        *value = y.map(|y| instrument.output.to_si(y)).filter(|si| si.is_finite()).unwrap_or(f64::NAN);
        if raw.is_finite() && value.is_nan() {
            refused.push((i, raw));
        }
    }
    refused
}
