//! What a raw file holds, looked at in little memory: `pneuval inspect`.

use crate::IngestError;
use crate::draft;
use crate::finding::{Finding, Severity};
use crate::formats::{self, Options};
use crate::raw::RawFile;
use crate::recording::{ColumnRef, Keep, Recording, Table};

/// A log up to this size is read again for its words.
const WORDS_BYTES_MAX: u64 = 64 << 20;

/// A raw file, looked at.
#[derive(Debug, Clone, PartialEq)]
pub struct Inspection {
    /// As the user named it.
    pub file: String,
    /// Its length.
    pub bytes: u64,
    /// Its SHA-256.
    pub sha256: String,
    /// What it holds: summaries of columns, and of short logs the words; its findings are below.
    pub recording: Recording,
    /// All findings: of the file, of its clocks, of its columns.
    pub findings: Vec<Finding>,
    /// How a session.toml would name it.
    pub session: String,
}

impl Inspection {
    /// Whether the instrument had data that are not in the file any more.
    pub fn is_lossy(&self) -> bool {
        self.findings.iter().any(|finding| finding.severity == Severity::Lost)
    }
}

/// The columns of words.
fn words_of(table: &Table) -> impl Iterator<Item = ColumnRef> {
    let text = table.columns.iter().filter(|column| column.summary.samples == 0);
    text.map(|column| ColumnRef::Name(table.full_name(&column.name)))
}

/// Looks at a raw file; `name` is what a session.toml beside it would call it.
///
/// # Errors
/// As [`formats::read`].
pub fn inspect(raw: &RawFile, name: &str, options: &Options) -> Result<Inspection, IngestError> {
    let mut recording = formats::read(raw, options, Keep::Nothing)?;
    // Words may be stamps, and only all of them together tell in which order day and month stand.
    let words: Vec<ColumnRef> =
        recording.tables.iter().filter(|table| table.clock.is_none()).flat_map(words_of).collect();
    if !words.is_empty() && raw.len() <= WORDS_BYTES_MAX {
        recording = formats::read(raw, options, Keep::Only(&words))?;
    }
    let mut findings = std::mem::take(&mut recording.findings);
    for table in &recording.tables {
        let time = table.time();
        for column in &table.columns {
            let name = table.full_name(&column.name);
            match &column.clock {
                Some(clock) if time.is_some_and(|time| std::ptr::eq(time, column)) => {
                    findings.extend(clock.findings(raw.name(), &name, &table.lines));
                }
                // Other stamps of the same samples say nothing new.
                Some(clock) if clock.is_forward() => {}
                _ => findings.extend(column.summary.findings(raw.name(), &name, &table.lines)),
            }
        }
    }
    Ok(Inspection {
        file: raw.name().to_owned(),
        bytes: raw.len(),
        sha256: raw.sha256()?,
        session: draft::block(name, &recording),
        recording,
        findings,
    })
}
