//! From a session's manifest and its logs to channels in SI units.
//!
//! ```text
//! log bytes -> TextLog -> rows of the run -> unit or calibration -> gauge -> tare -> derived -> Run
//! ```
//!
//! Nothing is repaired: what is no number, or what a calibration refuses, is a hole (NaN) in the channel and a [`Finding`] with
//! its place. A session is refused as unusable only where no sample of a required channel survives.

use std::collections::BTreeMap;

use crate::digest;
use crate::error::{IngestError, Place, shown, suggestion};
use crate::finding::{self, Finding, FindingKind, LineMap, Severity, Span, clock_findings, forward_samples};
use crate::formats::csv::{self, Cells, TextColumn, TextLog};
use crate::manifest::{
    ChannelSpec, ClockSpec, ColumnRef, DerivedRule, DerivedSpec, FileDigest, Instrument, PressureReference, ReadBeside,
    Rig, RunSpec, SessionManifest,
};
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

/// One run: channels of equal length.
#[derive(Debug, Clone, PartialEq)]
pub struct Run {
    /// Its id.
    pub id: String,
    /// Its log.
    pub file: String,
    /// Time of each sample in s, if there is a clock; NaN where the stamp is no number or goes back.
    pub seconds: Option<Vec<f64>>,
    /// Channels by id.
    pub channels: BTreeMap<String, Channel>,
    /// Line of the log of each sample.
    pub lines: LineMap,
    /// Samples.
    pub samples: usize,
}

/// One channel.
#[derive(Debug, Clone, PartialEq)]
pub struct Channel {
    /// The unit it is shown in.
    pub unit: Unit,
    /// Samples in SI units; NaN is a hole.
    pub values_si: Vec<f64>,
    /// Standard uncertainty of one sample in SI units, where an instrument declares one.
    pub std_si: Option<f64>,
    /// Asked of a regulator, not measured.
    pub commanded: bool,
    /// A pressure against vacuum, not yet against the atmosphere.
    absolute: bool,
}

impl Session {
    /// Reads the logs of a session.
    ///
    /// # Errors
    /// [`IngestError::Malformed`] where the manifest and the logs do not fit together (a column, a unit, an instrument);
    /// [`IngestError::Unusable`] where no sample of a required channel is a number.
    pub fn load(manifest: SessionManifest, rig: Option<Rig>, beside: ReadBeside) -> Result<Self, IngestError> {
        let mut logs: BTreeMap<&str, (String, TextLog)> = BTreeMap::new();
        let mut files = Vec::new();
        for run in &manifest.runs {
            if !logs.contains_key(run.file.as_str()) {
                let (full, bytes) = beside(&run.file)?;
                files.push(FileDigest { name: run.file.clone(), sha256: digest::sha256(&bytes) });
                logs.insert(&run.file, (full.clone(), csv::read(&full, &bytes, &manifest.reader)?));
            }
        }
        let mut findings = Vec::new();
        let mut runs = Vec::new();
        let reader = Reader { manifest: &manifest, rig: rig.as_ref() };
        for spec in &manifest.runs {
            // Every run's file was read above.
            let Some((full, log)) = logs.get(spec.file.as_str()) else { continue };
            runs.push(reader.run(spec, full, log, &mut findings)?);
        }
        for (name, (_, log)) in &logs {
            findings.extend(log.findings.iter().map(|finding| reader.of_log(name, finding)));
        }
        let session = Self { manifest, rig, runs, files, findings };
        session.check_units()?;
        session.check_usable()?;
        Ok(session)
    }

    /// The channels of a response measure what it says they do.
    fn check_units(&self) -> Result<(), IngestError> {
        for response in &self.manifest.responses {
            let pressures = response.pressure.iter().map(|(channel, _)| (channel, Dimension::Pressure));
            let measured = response.measured.iter().map(|channel| (channel, response.quantity.unit.dimension));
            for (id, dimension) in pressures.chain(measured) {
                let Some(channel) = self.runs.iter().find_map(|run| run.channels.get(id)) else { continue };
                if channel.unit.dimension != dimension {
                    return Err(IngestError::Malformed {
                        place: Place::new(
                            &self.manifest.file,
                            Some(response.line),
                            Some(format!("response `{}`", response.quantity.id)),
                        ),
                        expected: format!("channel `{id}` as {}", dimension.name()),
                        found: format!("unit `{}`", channel.unit.symbol),
                        next: "correct the unit of the channel or of the quantity, or name an instrument".to_owned(),
                    });
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

    /// Samples of required channels that were read, and those of them that are holes.
    pub fn samples(&self) -> (usize, usize) {
        let required = self.manifest.required();
        let channels = self.runs.iter().flat_map(|run| run.channels.iter());
        let mut counts = (0, 0);
        for (_, channel) in channels.filter(|(id, _)| required.contains(&id.as_str())) {
            counts.0 += channel.values_si.len();
            counts.1 += channel.values_si.iter().filter(|v| !v.is_finite()).count();
        }
        counts
    }
}

/// What every run of a session is read with.
struct Reader<'a> {
    manifest: &'a SessionManifest,
    rig: Option<&'a Rig>,
}

/// The rows of a log that belong to a run.
struct Rows<'a> {
    file: &'a str,
    log: &'a TextLog,
    rows: Vec<usize>,
    lines: LineMap,
}

impl Rows<'_> {
    /// The numbers of a column, at the rows of the run. A column that is mostly text is read all the same, if it was asked for:
    /// what is no number in it is a hole, and a finding.
    fn numbers(&self, column: &TextColumn, run: &str, findings: &mut Vec<Finding>) -> Vec<f64> {
        let cells = match &column.cells {
            Cells::Numbers(values) => return self.rows.iter().map(|&row| values[row]).collect(),
            Cells::Text(cells) => cells,
        };
        let parse = |row: usize| {
            let number = csv::parse_number(cells[row].trim().as_bytes(), self.log.layout.decimal);
            number.filter(|v| v.is_finite()).unwrap_or(f64::NAN)
        };
        let values: Vec<f64> = self.rows.iter().map(|&row| parse(row)).collect();
        let holes: Vec<usize> = (0..values.len()).filter(|&i| values[i].is_nan()).collect();
        if !holes.is_empty() {
            let named = |&i: &usize| format!("line {}: {}", self.lines.line_of(i), shown(&cells[self.rows[i]]));
            let first: Vec<String> = holes.iter().take(5).map(named).collect();
            findings.push(Finding {
                kind: FindingKind::NonNumericCell,
                severity: Severity::Excluded,
                file: self.file.to_owned(),
                channel: Some(column.name.clone()),
                spans: self.spans(&holes),
                count: holes.len(),
                text: format!(
                    "column {} of run {run}: {} of {} cells are not numbers ({}); left as holes",
                    shown(&column.name),
                    holes.len(),
                    values.len(),
                    first.join(", ")
                ),
            });
        }
        values
    }

    /// Stretches of samples, for a finding.
    fn spans(&self, samples: &[usize]) -> Vec<Span> {
        let mut spans = Vec::new();
        for &sample in samples {
            let line = self.lines.line_of(sample);
            let span = Span { first_sample: sample, last_sample: sample, first_line: line, last_line: line };
            finding::extend(&mut spans, span);
        }
        spans
    }
}

impl Reader<'_> {
    fn run(&self, spec: &RunSpec, file: &str, log: &TextLog, findings: &mut Vec<Finding>) -> Result<Run, IngestError> {
        let rows = self.rows(spec, file, log)?;
        let rows = Rows { file: &spec.file, ..rows };
        let seconds = self.seconds(&spec.file, &rows, findings)?;
        let mut channels = BTreeMap::new();
        for channel in &self.manifest.channels {
            let mut read = self.channel(channel, spec, &rows, findings)?;
            if read.absolute {
                self.to_gauge(channel, spec, &mut read)?;
            }
            if let Some((value, unit)) = spec.zero.get(&channel.id) {
                self.zero(channel, spec, &mut read, (*value, *unit), findings)?;
            }
            if let Some(samples) = channel.tare_samples {
                self.tare(channel, samples, spec, &mut read, findings)?;
            }
            channels.insert(channel.id.clone(), read);
        }
        for derived in &self.manifest.derived {
            let channel = self.derive(derived, &channels)?;
            channels.insert(derived.id.clone(), channel);
        }
        let samples = rows.rows.len();
        Ok(Run { id: spec.id.clone(), file: spec.file.clone(), seconds, channels, lines: rows.lines, samples })
    }

    /// The rows of the log that belong to the run.
    fn rows<'l>(&self, spec: &RunSpec, file: &'l str, log: &'l TextLog) -> Result<Rows<'l>, IngestError> {
        let rows: Vec<usize> = match &spec.rows {
            None => (0..log.rows).collect(),
            Some((column, wanted)) => {
                let column = self.column(column, log, spec.line)?;
                let rows: Vec<usize> = match &column.cells {
                    Cells::Text(cells) => (0..log.rows).filter(|&row| cells[row] == *wanted).collect(),
                    Cells::Numbers(values) => {
                        let wanted = wanted.parse::<f64>().unwrap_or(f64::NAN);
                        let equal = |value: f64| value.total_cmp(&wanted).is_eq() && !value.is_nan();
                        (0..log.rows).filter(|&row| equal(values[row])).collect()
                    }
                };
                if rows.is_empty() {
                    let mut seen: Vec<&str> = match &column.cells {
                        Cells::Text(cells) => cells.iter().map(String::as_str).collect(),
                        Cells::Numbers(_) => vec![],
                    };
                    seen.sort_unstable();
                    seen.dedup();
                    let expected = format!("a text of column `{}` of {file}", column.name);
                    return Err(self.malformed(spec.line, &expected, &shown(wanted), suggestion(wanted, seen)));
                }
                rows
            }
        };
        let mut lines = LineMap::default();
        for &row in &rows {
            lines.push(log.line_of(row));
        }
        Ok(Rows { file, log, rows, lines })
    }

    /// A column of the log by name or number.
    fn column<'l>(&self, column: &ColumnRef, log: &'l TextLog, line: usize) -> Result<&'l TextColumn, IngestError> {
        match column {
            ColumnRef::Number(number) => log.columns.get(number - 1).ok_or_else(|| {
                let found = format!("column {number} of {}", log.columns.len());
                self.malformed(line, "a column of the log", &found, "count from 1".to_owned())
            }),
            ColumnRef::Name(name) => log.columns.iter().find(|c| c.name == *name).ok_or_else(|| {
                let known: Vec<&str> = log.columns.iter().map(|c| c.name.as_str()).collect();
                let expected = format!("a column of the log: {}", known.join(", "));
                self.malformed(line, &expected, &shown(name), suggestion(name, known))
            }),
        }
    }

    fn seconds(&self, file: &str, rows: &Rows, findings: &mut Vec<Finding>) -> Result<Option<Vec<f64>>, IngestError> {
        match &self.manifest.clock {
            None => Ok(None),
            Some(ClockSpec::Rate(rate)) => Ok(Some((0..rows.rows.len()).map(|i| i as f64 / rate).collect())),
            Some(ClockSpec::Column { column, unit, line }) => {
                let column = self.column(column, rows.log, *line)?;
                let unit = self.unit(*unit, column, *line)?;
                self.check(unit, Dimension::Time, *line)?;
                let stamps: Vec<f64> =
                    rows.numbers(column, file, findings).into_iter().map(|t| unit.to_si(t)).collect();
                findings.extend(clock_findings(file, &column.name, &stamps, Some(&rows.lines)));
                let mut seconds = vec![f64::NAN; stamps.len()];
                for i in forward_samples(&stamps) {
                    seconds[i] = stamps[i];
                }
                Ok(Some(seconds))
            }
        }
    }

    /// The unit of a column: the manifest's, else the file's.
    fn unit(&self, declared: Option<Unit>, column: &TextColumn, line: usize) -> Result<Unit, IngestError> {
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

    fn check(&self, unit: Unit, dimension: Dimension, line: usize) -> Result<(), IngestError> {
        if unit.dimension == dimension {
            return Ok(());
        }
        let found = format!("unit `{}`", unit.symbol);
        Err(self.malformed(line, dimension.name(), &found, "correct the unit or the column".to_owned()))
    }

    fn channel(
        &self,
        spec: &ChannelSpec,
        run: &RunSpec,
        rows: &Rows,
        findings: &mut Vec<Finding>,
    ) -> Result<Channel, IngestError> {
        let column = self.column(&spec.column, rows.log, spec.line)?;
        let instrument = spec.instrument.as_deref().map(|id| self.instrument(id, spec)).transpose()?;
        let declared = spec.unit.or(instrument.map(|i| i.input));
        let logged = self.unit(declared, column, spec.line)?;
        let raw = rows.numbers(column, &run.id, findings);
        let (unit, values_si, std_si) = match instrument {
            None => (logged, raw.into_iter().map(|v| logged.to_si(v)).collect::<Vec<_>>(), None),
            Some(instrument) => {
                self.check(logged, instrument.input.dimension, spec.line)?;
                let calibrated = calibrate(instrument, logged, &raw);
                let refused: Vec<usize> =
                    (0..raw.len()).filter(|&i| raw[i].is_finite() && calibrated[i].is_nan()).collect();
                if !refused.is_empty() {
                    findings.push(refusal(spec, run, instrument, logged, &raw, &refused, rows));
                }
                findings.extend(beyond_range(spec, run, instrument, &calibrated, rows));
                (instrument.output, calibrated, instrument.std.map(|std| instrument.output.to_si(std)))
            }
        };
        if unit.dimension == Dimension::Pressure && spec.reference.is_none() {
            let expected = "`reference`: a pressure is gauge or absolute";
            let next = "add reference = \"gauge\", or \"absolute\" with the run's `atmosphere`";
            return Err(self.malformed(spec.line, expected, "nothing", next.to_owned()));
        }
        let absolute = spec.reference == Some(PressureReference::Absolute);
        if absolute {
            self.check(unit, Dimension::Pressure, spec.line)?;
        }
        Ok(Channel { unit, values_si, std_si, commanded: spec.commanded, absolute })
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
        channel.absolute = false;
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

    /// Takes the mean of the first samples as zero, and says so.
    fn tare(
        &self,
        spec: &ChannelSpec,
        samples: usize,
        run: &RunSpec,
        channel: &mut Channel,
        findings: &mut Vec<Finding>,
    ) -> Result<(), IngestError> {
        let first: Vec<f64> = channel.values_si.iter().copied().take(samples).filter(|v| v.is_finite()).collect();
        if first.is_empty() {
            let expected = format!("a number among the first {samples} samples of channel `{}`", spec.id);
            let next = "tare over more samples, or not at all".to_owned();
            return Err(self.malformed(spec.line, &expected, "none", next));
        }
        let zero = first.iter().sum::<f64>() / first.len() as f64;
        channel.values_si.iter_mut().for_each(|v| *v -= zero);
        findings.push(Finding {
            kind: FindingKind::Tared,
            severity: Severity::Note,
            file: run.file.clone(),
            channel: Some(spec.id.clone()),
            spans: vec![],
            count: first.len(),
            text: format!(
                "channel `{}` of run {}: zero is the mean of its first {} samples, {} {}",
                spec.id,
                run.id,
                first.len(),
                channel.unit.from_si(zero),
                channel.unit.symbol
            ),
        });
        Ok(())
    }

    fn derive(&self, spec: &DerivedSpec, channels: &BTreeMap<String, Channel>) -> Result<Channel, IngestError> {
        // The manifest's reader lets a derived channel name only channels above it.
        let from: Vec<&Channel> = spec.from.iter().filter_map(|id| channels.get(id)).collect();
        let alike = from.windows(2).all(|pair| pair[0].unit.dimension == pair[1].unit.dimension);
        let dimensions: Vec<Dimension> = from.iter().map(|c| c.unit.dimension).collect();
        let dimension = match (spec.rule, dimensions.as_slice()) {
            (DerivedRule::Difference, [one, _]) if alike => *one,
            (DerivedRule::Product, [Dimension::Pressure, Dimension::Area] | [Dimension::Area, Dimension::Pressure]) => {
                Dimension::Force
            }
            (DerivedRule::Displacement | DerivedRule::TransmitterDistance, [Dimension::Length, ..]) if alike => {
                Dimension::Length
            }
            _ => {
                let expected = match spec.rule {
                    DerivedRule::Difference => "two channels of one kind",
                    DerivedRule::Product => "a pressure and an area",
                    DerivedRule::Displacement | DerivedRule::TransmitterDistance => "lengths",
                };
                let found: Vec<&str> = dimensions.iter().map(|d| d.name()).collect();
                return Err(self.malformed(spec.line, expected, &found.join(", "), "name other channels".to_owned()));
            }
        };
        self.check(spec.unit, dimension, spec.line)?;
        let samples = from.iter().map(|c| c.values_si.len()).min().unwrap_or(0);
        let at = |i: usize| -> Vec<f64> { from.iter().map(|c| c.values_si[i]).collect() };
        let origin = (0..samples).map(at).find(|r| r.iter().all(|v| v.is_finite()));
        let norm = |r: &[f64]| r.iter().map(|v| v * v).sum::<f64>().sqrt();
        let value = |r: Vec<f64>| match (spec.rule, &origin) {
            (DerivedRule::Difference, _) => r[0] - r[1],
            (DerivedRule::Product, _) => r[0] * r[1],
            (DerivedRule::Displacement, Some(origin)) => {
                norm(&r.iter().zip(origin).map(|(a, b)| a - b).collect::<Vec<_>>())
            }
            (DerivedRule::TransmitterDistance, Some(origin)) => norm(&r) - norm(origin),
            _ => f64::NAN,
        };
        Ok(Channel {
            unit: spec.unit,
            values_si: (0..samples).map(|i| value(at(i))).collect(),
            std_si: None,
            commanded: from.iter().any(|c| c.commanded),
            absolute: false,
        })
    }

    /// A finding of the log, as one of the session: what lies in a column that nothing needs is worth knowing, and no loss.
    fn of_log(&self, file: &str, finding: &Finding) -> Finding {
        let mut finding = finding.clone();
        file.clone_into(&mut finding.file);
        let required = self.manifest.required();
        let needed = |column: &str| {
            let by_name = |c: &&ChannelSpec| c.column == ColumnRef::Name(column.to_owned());
            let numbered = self.manifest.channels.iter().any(|c| matches!(c.column, ColumnRef::Number(_)));
            numbered || self.manifest.channels.iter().filter(by_name).any(|c| required.contains(&c.id.as_str()))
        };
        if finding.severity == Severity::Excluded && finding.channel.as_deref().is_some_and(|c| !needed(c)) {
            finding.severity = Severity::Note;
        }
        finding
    }

    fn malformed(&self, line: usize, expected: &str, found: &str, next: String) -> IngestError {
        IngestError::Malformed {
            place: Place::new(&self.manifest.file, Some(line), None),
            expected: expected.to_owned(),
            found: found.to_owned(),
            next,
        }
    }
}

/// Logged values through an instrument, in SI units; NaN where it refuses.
fn calibrate(instrument: &Instrument, logged: Unit, raw: &[f64]) -> Vec<f64> {
    raw.iter()
        .map(|&value| {
            let x = instrument.input.from_si(logged.to_si(value));
            if instrument.valid.is_some_and(|(min, max)| !(x >= min && x <= max)) {
                return f64::NAN;
            }
            let y = match &instrument.calibration {
                None => Some(instrument.output.from_si(instrument.input.to_si(x))),
                Some(calibration) => calibration.apply(x),
            };
            y.map_or(f64::NAN, |y| instrument.output.to_si(y))
        })
        .collect()
}

/// The finding of samples that a calibration refuses.
fn refusal(
    spec: &ChannelSpec,
    run: &RunSpec,
    instrument: &Instrument,
    logged: Unit,
    raw: &[f64],
    refused: &[usize],
    rows: &Rows,
) -> Finding {
    let first: Vec<String> = refused
        .iter()
        .take(5)
        .map(|&i| format!("{} {} at line {}", raw[i], logged.symbol, rows.lines.line_of(i)))
        .collect();
    let more = if refused.len() > 5 { ", …" } else { "" };
    Finding {
        kind: FindingKind::OutOfCalibration,
        severity: Severity::Excluded,
        file: run.file.clone(),
        channel: Some(spec.id.clone()),
        spans: rows.spans(refused),
        count: refused.len(),
        text: format!(
            "channel `{}` of run {}: {} of {} samples lie where {} is not calibrated: {}{more}",
            spec.id,
            run.id,
            refused.len(),
            raw.len(),
            instrument.title,
            first.join(", ")
        ),
    }
}

/// Samples at or beyond what an instrument can show.
fn beyond_range(
    spec: &ChannelSpec,
    run: &RunSpec,
    instrument: &Instrument,
    values_si: &[f64],
    rows: &Rows,
) -> Option<Finding> {
    let (min, max) = instrument.range?;
    let (low, high) = (instrument.output.to_si(min), instrument.output.to_si(max));
    let outside: Vec<usize> = (0..values_si.len()).filter(|&i| values_si[i] < low || values_si[i] > high).collect();
    let first = *outside.first()?;
    Some(Finding {
        kind: FindingKind::OutOfRange,
        severity: Severity::Note,
        file: run.file.clone(),
        channel: Some(spec.id.clone()),
        spans: rows.spans(&outside),
        count: outside.len(),
        text: format!(
            "channel `{}` of run {}: {} samples lie beyond the range of {}, {min} to {max} {}, the first at line {}",
            spec.id,
            run.id,
            outside.len(),
            instrument.title,
            instrument.output.symbol,
            rows.lines.line_of(first)
        ),
    })
}
