//! A log's columns as the channels of a run.

use std::collections::BTreeMap;

use super::{Channel, Run};
use crate::error::{IngestError, Place, shown, suggestion};
use crate::finding::{self, Finding, FindingKind, LineMap, Severity, Span, clock_findings, forward_samples};
use crate::formats::csv::{self, TextLog};
use crate::manifest::{
    ChannelSpec, ClockSpec, ColumnRef, FileDigest, Instrument, PressureReference, Rig, RunSpec, SessionManifest,
};
use crate::recording::{Cells, Column};
use crate::units::{Dimension, Unit};

/// What every run of a session is read with.
pub(super) struct Reader<'a> {
    pub manifest: &'a SessionManifest,
    pub rig: Option<&'a Rig>,
}

/// The rows of a log that belong to a run.
pub(super) struct Rows<'a> {
    file: &'a str,
    log: &'a TextLog,
    rows: Vec<usize>,
    lines: LineMap,
}

impl Rows<'_> {
    /// The numbers of a column, at the rows of the run. A column that is mostly text is read all the same, if it was asked for:
    /// what is no number in it is a hole, and a finding.
    fn numbers(&self, column: &Column, run: &str, findings: &mut Vec<Finding>) -> Vec<f64> {
        let cells = match &column.cells {
            Cells::Numbers(values) => return self.rows.iter().map(|&row| values[row]).collect(),
            Cells::Text(cells) => cells,
            Cells::NotKept => return vec![],
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
    /// Two logs of the same bytes are one log: they are no repeats.
    pub fn check_files_differ(&self, files: &[FileDigest]) -> Result<(), IngestError> {
        for (i, file) in files.iter().enumerate() {
            let Some(other) = files[..i].iter().find(|other| other.sha256 == file.sha256) else { continue };
            let line = self.manifest.runs.iter().find(|run| run.file == file.name).map_or(1, |run| run.line);
            let found = format!("{}, byte for byte {}", shown(&file.name), shown(&other.name));
            return Err(self.malformed(line, "a log of its own", &found, "remove the run, or name its log".to_owned()));
        }
        Ok(())
    }

    /// Every row belongs to one run: twice the same row is no repeat.
    pub fn claim<'r>(
        &self,
        spec: &'r RunSpec,
        rows: &Rows,
        claimed: &mut [Option<&'r str>],
    ) -> Result<(), IngestError> {
        for &row in &rows.rows {
            if let Some(other) = claimed[row] {
                let found = format!("line {} in run {other} too", rows.log.line_of(row));
                let next = "correct `rows` or `file`: the same row twice is no repeat".to_owned();
                return Err(self.malformed(spec.line, "rows of its own", &found, next));
            }
            claimed[row] = Some(&spec.id);
        }
        Ok(())
    }

    /// A run of a log.
    pub fn run(&self, spec: &RunSpec, rows: Rows, findings: &mut Vec<Finding>) -> Result<Run, IngestError> {
        let seconds = self.seconds(spec, &rows, findings)?;
        let mut channels = BTreeMap::new();
        for channel in &self.manifest.channels {
            let mut read = self.channel(channel, spec, &rows, findings)?;
            if channel.reference == Some(PressureReference::Absolute) {
                self.to_gauge(channel, spec, &mut read)?;
            }
            if let Some((value, unit)) = spec.zero.get(&channel.id) {
                self.zero(channel, spec, &mut read, (*value, *unit), findings)?;
            }
            if let Some(samples) = channel.tare_samples {
                tare(channel, samples, spec, &mut read, findings);
            }
            channels.insert(channel.id.clone(), read);
        }
        for derived in &self.manifest.derived {
            let channel = self.derive(derived, spec, &channels, seconds.as_deref(), &rows.lines, findings)?;
            channels.insert(derived.id.clone(), channel);
        }
        let samples = rows.rows.len();
        Ok(Run { id: spec.id.clone(), file: spec.file.clone(), seconds, channels, lines: rows.lines, samples })
    }

    /// The rows of the log that belong to the run.
    pub fn rows<'l>(&self, spec: &'l RunSpec, log: &'l TextLog) -> Result<Rows<'l>, IngestError> {
        let file = spec.file.as_str();
        let rows: Vec<usize> = match &spec.rows {
            None => (0..log.rows).collect(),
            Some((column, wanted)) => {
                let column = self.column(column, log, spec.line)?;
                let rows: Vec<usize> = match &column.cells {
                    Cells::Text(cells) => (0..log.rows).filter(|&row| cells[row] == *wanted).collect(),
                    Cells::Numbers(values) => {
                        let wanted =
                            csv::parse_number(wanted.trim().as_bytes(), log.layout.decimal).unwrap_or(f64::NAN);
                        let equal = |value: f64| value.total_cmp(&wanted).is_eq() && !value.is_nan();
                        (0..log.rows).filter(|&row| equal(values[row])).collect()
                    }
                    Cells::NotKept => vec![],
                };
                if rows.is_empty() {
                    let mut seen: Vec<&str> = match &column.cells {
                        Cells::Text(cells) => cells.iter().map(String::as_str).collect(),
                        Cells::Numbers(_) | Cells::NotKept => vec![],
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
    fn column<'l>(&self, column: &ColumnRef, log: &'l TextLog, line: usize) -> Result<&'l Column, IngestError> {
        match column {
            ColumnRef::Number(number) => log.columns.get(number - 1).ok_or_else(|| {
                let found = format!("column {number} of {}", log.columns.len());
                self.malformed(line, "a column of the log", &found, "count from 1".to_owned())
            }),
            ColumnRef::Name(name) if log.columns.iter().any(|c| c.name == format!("{name} (2)")) => {
                let expected = "a column whose name stands once in the log";
                let next = "name it by its number, or as `… (2)`".to_owned();
                Err(self.malformed(line, expected, &format!("{} twice", shown(name)), next))
            }
            ColumnRef::Name(name) => log.columns.iter().find(|c| c.name == *name).ok_or_else(|| {
                let known: Vec<&str> = log.columns.iter().map(|c| c.name.as_str()).collect();
                let expected = format!("a column of the log: {}", known.join(", "));
                self.malformed(line, &expected, &shown(name), suggestion(name, known))
            }),
        }
    }

    fn seconds(
        &self,
        run: &RunSpec,
        rows: &Rows,
        findings: &mut Vec<Finding>,
    ) -> Result<Option<Vec<f64>>, IngestError> {
        match &self.manifest.clock {
            None => Ok(None),
            Some(ClockSpec::Rate(rate)) => Ok(Some((0..rows.rows.len()).map(|i| i as f64 / rate).collect())),
            Some(ClockSpec::Column { column, unit, line }) => {
                let column = self.column(column, rows.log, *line)?;
                let unit = self.unit(*unit, column, *line)?;
                self.check(unit, Dimension::Time, *line)?;
                let stamps: Vec<f64> =
                    rows.numbers(column, &run.id, findings).into_iter().map(|t| unit.to_si(t)).collect();
                let mut odd = clock_findings(&run.file, &column.name, &stamps, Some(&rows.lines));
                if self.manifest.runs.iter().filter(|r| r.file == run.file).count() > 1 {
                    for finding in &mut odd {
                        finding.text = format!("run {}: {}", run.id, finding.text);
                    }
                }
                findings.append(&mut odd);
                let mut seconds = vec![f64::NAN; stamps.len()];
                for i in forward_samples(&stamps) {
                    seconds[i] = stamps[i];
                }
                Ok(Some(seconds))
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
        run: &RunSpec,
        rows: &Rows,
        findings: &mut Vec<Finding>,
    ) -> Result<Channel, IngestError> {
        let column = self.column(&spec.column, rows.log, spec.line)?;
        let instrument = spec.instrument.as_deref().map(|id| self.instrument(id, spec)).transpose()?;
        let logged = self.logged_unit(spec, instrument, column, run, findings)?;
        let raw = rows.numbers(column, &run.id, findings);
        let (unit, values_si, std_si) = match instrument {
            None => {
                let mut values: Vec<f64> = raw.iter().map(|v| logged.to_si(*v)).collect();
                let beyond: Vec<usize> =
                    (0..raw.len()).filter(|&i| raw[i].is_finite() && !values[i].is_finite()).collect();
                if !beyond.is_empty() {
                    for &i in &beyond {
                        values[i] = f64::NAN;
                    }
                    findings.push(overflow(spec, run, &beyond, rows));
                }
                (logged, values, None)
            }
            Some(instrument) => {
                self.check(logged, instrument.input.dimension, spec.line)?;
                let calibrated = calibrate(instrument, logged, &raw);
                let refused: Vec<usize> =
                    (0..raw.len()).filter(|&i| raw[i].is_finite() && calibrated[i].is_nan()).collect();
                if !refused.is_empty() {
                    findings.push(refusal(spec, run, instrument, logged, &raw, &refused, rows));
                }
                findings.extend(beyond_range(spec, run, instrument, &calibrated, rows));
                (instrument.output, calibrated, instrument.uncertainty().map(|u| instrument.output.to_si(u)))
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
        Ok(Channel { unit, values_si, std_si, commanded: spec.commanded })
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
        let needed = |column: &str| {
            let by_name = |c: &&ChannelSpec| c.column == ColumnRef::Name(column.to_owned());
            let numbered = self.manifest.channels.iter().any(|c| matches!(c.column, ColumnRef::Number(_)));
            numbered || self.manifest.channels.iter().filter(by_name).any(|c| required.contains(&c.id.as_str()))
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

    pub fn malformed(&self, line: usize, expected: &str, found: &str, next: String) -> IngestError {
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
            y.map(|y| instrument.output.to_si(y)).filter(|si| si.is_finite()).unwrap_or(f64::NAN)
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

/// The finding of numbers that are not finite in SI.
fn overflow(spec: &ChannelSpec, run: &RunSpec, beyond: &[usize], rows: &Rows) -> Finding {
    let first = beyond.first().map_or(0, |&i| rows.lines.line_of(i));
    Finding {
        kind: FindingKind::Overflow,
        severity: Severity::Excluded,
        file: run.file.clone(),
        channel: Some(spec.id.clone()),
        spans: rows.spans(beyond),
        count: beyond.len(),
        text: format!(
            "channel `{}` of run {}: {} numbers are too large for SI units, the first at line {first}",
            spec.id,
            run.id,
            beyond.len()
        ),
    }
}

/// Takes the mean of the first samples as zero, and says so; without a number among them the whole channel is holes.
fn tare(spec: &ChannelSpec, samples: usize, run: &RunSpec, channel: &mut Channel, findings: &mut Vec<Finding>) {
    let first: Vec<f64> = channel.values_si.iter().copied().take(samples).filter(|v| v.is_finite()).collect();
    let zero = first.iter().sum::<f64>() / first.len() as f64;
    channel.values_si.iter_mut().for_each(|v| *v -= zero);
    let name = format!("channel `{}` of run {}", spec.id, run.id);
    let (severity, count, text) = if first.is_empty() {
        let text = format!("{name}: none of its first {samples} samples is a number, so it has no zero");
        (Severity::Excluded, channel.values_si.len(), text)
    } else {
        let at = channel.unit.from_si(zero);
        let text =
            format!("{name}: zero is the mean of its first {} samples, {at} {}", first.len(), channel.unit.symbol);
        (Severity::Note, first.len(), text)
    };
    findings.push(Finding {
        kind: FindingKind::Tared,
        severity,
        file: run.file.clone(),
        channel: Some(spec.id.clone()),
        spans: vec![],
        count,
        text,
    });
}
