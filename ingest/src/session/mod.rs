//! From a session's manifest and its logs to channels in SI units.
//!
//! ```text
//! log bytes -> TextLog -> rows of the run -> unit or calibration -> gauge -> tare -> derived -> Run
//! ```
//!
//! Nothing is repaired: what is no number, or what a calibration refuses, is a hole (NaN) in the channel and a [`Finding`] with
//! its place. A session is refused as unusable only where no sample of a required channel survives.

mod derive;
mod reader;

use std::collections::BTreeMap;

use reader::Reader;

use crate::digest;
use crate::error::{IngestError, Place};
use crate::finding::{self, Finding, FindingKind, LineMap, Severity, Span};
use crate::formats::csv::{self, TextLog};
use crate::manifest::{FileDigest, ReadBeside, Rig, SessionManifest};
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
}

impl Session {
    /// Reads the logs of a session.
    ///
    /// # Errors
    /// [`IngestError::Malformed`] where the manifest and the logs do not fit together (a column, a unit, an instrument);
    /// [`IngestError::Unusable`] where no sample of a required channel is a number.
    pub fn load(manifest: SessionManifest, rig: Option<Rig>, beside: ReadBeside) -> Result<Self, IngestError> {
        let mut logs: BTreeMap<&str, TextLog> = BTreeMap::new();
        let (mut files, mut findings, mut runs): (Vec<FileDigest>, Vec<Finding>, Vec<Run>) = Default::default();
        let mut unusable = None;
        for run in &manifest.runs {
            if files.iter().any(|f| f.name == run.file) {
                continue;
            }
            let (full, bytes) = beside(&run.file)?;
            files.push(FileDigest { name: run.file.clone(), sha256: digest::sha256(&bytes) });
            match csv::read(&full, &bytes, &manifest.reader) {
                Ok(log) => {
                    logs.insert(&run.file, log);
                }
                // One log that cannot be used does not take the others with it: it is lost, and told.
                Err(error @ IngestError::Unusable { .. }) => {
                    findings.push(lost(&run.file, &error));
                    unusable.get_or_insert(error);
                }
                Err(error) => return Err(error),
            }
        }
        let reader = Reader { manifest: &manifest, rig: rig.as_ref() };
        reader.check_files_differ(&files)?;
        let mut claims: BTreeMap<&str, Vec<Option<&str>>> = BTreeMap::new();
        for spec in &manifest.runs {
            let Some(log) = logs.get(spec.file.as_str()) else { continue };
            let rows = reader.rows(spec, log)?;
            let claimed = claims.entry(&spec.file).or_insert_with(|| vec![None; log.rows]);
            reader.claim(spec, &rows, claimed)?;
            runs.push(reader.run(spec, rows, &mut findings)?);
        }
        for (file, claimed) in &claims {
            findings.extend(unclaimed(file, &logs[file], claimed));
        }
        for (name, log) in &logs {
            findings.extend(log.findings.iter().map(|finding| reader.of_log(name, finding)));
        }
        let session = Self { manifest, rig, runs, files, findings };
        if let Some(error) = unusable.filter(|_| session.runs.is_empty()) {
            return Err(error);
        }
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

    /// Lines of the logs that hold no sample and should have.
    pub fn lines_skipped(&self) -> usize {
        let skipped = |f: &&Finding| f.kind == FindingKind::SkippedLine && f.severity == Severity::Excluded;
        self.findings.iter().filter(skipped).map(|f| f.count).sum()
    }
}

/// Rows of a log that belong to no run.
fn unclaimed(file: &str, log: &TextLog, claimed: &[Option<&str>]) -> Option<Finding> {
    let rows: Vec<usize> = (0..claimed.len()).filter(|&row| claimed[row].is_none()).collect();
    let first = *rows.first()?;
    let mut spans = Vec::new();
    for &row in &rows {
        let line = log.line_of(row);
        finding::extend(&mut spans, Span { first_sample: row, last_sample: row, first_line: line, last_line: line });
    }
    Some(Finding {
        kind: FindingKind::UnclaimedRows,
        severity: Severity::Note,
        file: file.to_owned(),
        channel: None,
        spans,
        count: rows.len(),
        text: format!("{} of {} rows belong to no run, the first at line {}", rows.len(), log.rows, log.line_of(first)),
    })
}

/// The finding of a log that cannot be used.
fn lost(file: &str, error: &IngestError) -> Finding {
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
