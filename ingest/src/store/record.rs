//! `session.json`: what the tables of a store hold, where it comes from, and what was found on the way.

use std::path::Path;

use serde::{Deserialize, Serialize};

use crate::finding::Finding;
use crate::limits;
use crate::manifest::{FileDigest, LogFile, Rig, SessionManifest};
use crate::raw::RawFile;
use crate::session::stream_title;

/// The version of `session.json`.
const LAYOUT: u32 = 2;

/// The version of this program: another one may read files otherwise.
const VERSION: &str = env!("CARGO_PKG_VERSION");

/// A stored session.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StoredSession {
    /// The version of this layout.
    pub layout: u32,
    /// The version of the program that wrote it.
    pub pneuval: String,
    /// The session's id.
    pub session: String,
    /// The actuator it was taken on.
    pub actuator: String,
    /// Written by a program, not by a rig.
    pub synthetic: bool,
    /// SHA-256 of `session.toml`.
    pub manifest_sha256: String,
    /// SHA-256 of `rig.toml`, if channels name instruments.
    pub rig_sha256: Option<String>,
    /// Raw files, in the order in which runs name them.
    pub files: Vec<StoredFile>,
}

/// What is stored of a raw file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StoredFile {
    /// Its name in the manifest.
    pub name: String,
    /// The device that wrote it; `None`: it is the `file` of its runs.
    #[serde(default)]
    pub device: Option<String>,
    /// Its SHA-256.
    pub sha256: String,
    /// Its length.
    pub bytes: u64,
    /// The instant from which its stamps count, where they are absolute.
    pub origin: Option<String>,
    /// Its runs; none where it cannot be used.
    pub runs: Vec<StoredRun>,
    /// What is odd about it.
    pub findings: Vec<Finding>,
}

/// A run.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StoredRun {
    /// Its id.
    pub id: String,
    /// Its place among the runs of the manifest, from 0.
    pub number: usize,
    /// A table for each clock.
    pub tables: Vec<StoredTable>,
}

/// A Parquet table: samples that share a clock.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StoredTable {
    /// Its file in the store.
    pub file: String,
    /// The SHA-256 of that file.
    pub sha256: String,
    /// The topic it comes from; empty where the raw file holds one table only.
    pub stream: String,
    /// Samples: rows of the table.
    pub samples: usize,
    /// The first stamp in s; `None` without a clock.
    pub from_s: Option<f64>,
    /// The last stamp in s.
    pub to_s: Option<f64>,
    /// The instant from which the stamps count, where it is known; `None` without a clock, and for a zero that only the device knows.
    #[serde(default)]
    pub counts_from: Option<String>,
    /// What was added to the stamps of the file, in s, so that all of the run count from there.
    #[serde(default)]
    pub shift_s: f64,
    /// The usual rate in Hz.
    pub rate_hz: Option<f64>,
    /// Its channels, each a column.
    pub channels: Vec<StoredChannel>,
}

/// A channel: a column of a table, in SI units; null is a hole.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StoredChannel {
    /// Its id in the manifest.
    pub id: String,
    /// Its column.
    pub column: String,
    /// The unit of the column.
    pub si_unit: String,
    /// The unit it is shown in.
    pub unit: String,
    /// Standard uncertainty of one sample in SI units, where an instrument declares one.
    pub std_si: Option<f64>,
    /// Asked of a regulator, not measured.
    pub commanded: bool,
    /// Samples that are holes.
    pub holes: usize,
}

impl StoredSession {
    /// The record of what was stored.
    pub(super) fn new(manifest: &SessionManifest, rig: Option<&Rig>, files: Vec<StoredFile>) -> Self {
        Self {
            layout: LAYOUT,
            pneuval: VERSION.to_owned(),
            session: manifest.id.clone(),
            actuator: manifest.actuator.clone(),
            synthetic: manifest.synthetic,
            manifest_sha256: manifest.sha256.clone(),
            rig_sha256: rig.map(|rig| rig.sha256.clone()),
            files,
        }
    }

    /// A record that was stored; `None` if there is none that this program understands: then the store is built anew.
    pub fn read(path: &Path) -> Option<Self> {
        let bytes = limits::read(path, limits::RESULTS_BYTES_MAX).ok()?;
        serde_json::from_slice(&bytes).ok()
    }

    /// Whether it was stored for these manifests, by this version.
    pub(super) fn is_of(&self, manifest: &SessionManifest, rig: Option<&Rig>) -> bool {
        let mine = Self::new(manifest, rig, vec![]);
        let theirs = Self { files: vec![], ..self.clone() };
        mine == theirs
    }

    /// What is stored of a file with these bytes.
    pub(super) fn file(&self, digest: &FileDigest) -> Option<&StoredFile> {
        self.files.iter().find(|file| file.name == digest.name && file.sha256 == digest.sha256)
    }

    /// As it stands in the store.
    ///
    /// # Errors
    /// None that is known: strings, numbers and lists of them always have a JSON.
    pub fn to_json(&self) -> serde_json::Result<String> {
        Ok(serde_json::to_string_pretty(self)? + "\n")
    }

    /// All findings, in the order of files.
    pub fn findings(&self) -> impl Iterator<Item = &Finding> {
        self.files.iter().flat_map(|file| &file.findings)
    }
}

impl StoredFile {
    /// What is stored of a file that cannot be used: the reason.
    pub(super) fn unusable(log: LogFile, digest: &FileDigest, bytes: u64, finding: Finding) -> Self {
        let FileDigest { name, sha256 } = digest.clone();
        let device = log.device.map(str::to_owned);
        Self { name, device, sha256, bytes, origin: None, runs: vec![], findings: vec![finding] }
    }

    /// What a table of it is called in sentences.
    pub(super) fn title(&self, table: &StoredTable) -> String {
        stream_title(self.device.as_deref(), &table.stream)
    }

    /// The tables of its runs.
    pub fn tables(&self) -> impl Iterator<Item = &StoredTable> {
        self.runs.iter().flat_map(|run| &run.tables)
    }

    /// Whether its tables are there, byte for byte.
    pub(super) fn is_whole(&self, root: &Path) -> bool {
        self.tables().all(|table| {
            let raw = RawFile::open(&root.join(&table.file), &table.file, u64::MAX);
            raw.and_then(|raw| raw.sha256()).is_ok_and(|sha256| sha256 == table.sha256)
        })
    }
}
