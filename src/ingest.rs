//! `pneuval ingest`: the raw files of sessions into Parquet tables.

use std::path::{Path, PathBuf};

use serde::Serialize;

use pneuval_datasets::Described;
use pneuval_ingest::finding::Severity;
use pneuval_ingest::manifest::{Rig, SessionManifest};
use pneuval_ingest::store::{self, Stored, StoredFile, StoredSession, StoredTable};
use pneuval_ingest::{IngestError, digest};

use crate::cli::Ingest;
use crate::exit::{Failure, Outcome};
use crate::{output, table};

/// What was stored, for `--json`.
#[derive(Serialize)]
struct Told {
    store: PathBuf,
    read: Vec<String>,
    unchanged: Vec<String>,
    record: StoredSession,
}

/// A session with its manifest and rig.
type Sitting<'a> = (&'a Described, (&'a SessionManifest, Option<&'a Rig>));

pub fn run(arguments: &Ingest) -> Result<Outcome, Failure> {
    let described = pneuval_datasets::describe(&arguments.paths)?;
    let sessions: Vec<Sitting> = described.iter().filter_map(|found| Some((found, found.session()?))).collect();
    if sessions.is_empty() {
        return Err(Failure::Flag {
            flag: "PATHS",
            found: "published datasets only".to_owned(),
            expected: "a session.toml, here or below".to_owned(),
            next: "`pneuval init` writes a first one from the logs in a folder".to_owned(),
        });
    }
    let mut outcome = Outcome::Expected;
    let mut all = Vec::new();
    for (described, (manifest, rig)) in sessions {
        let (root, stored) = stored((described, (manifest, rig)), arguments.store.as_deref())?;
        for finding in stored.record.findings() {
            output::tell(&format!("{}: {}, {}: {}", finding.severity.id(), manifest.id, finding.file, finding.text));
        }
        if is_open(manifest, &stored.record) {
            outcome = Outcome::Open;
        }
        if arguments.json {
            let Stored { record, read, unchanged } = stored;
            all.push(Told { store: root, read, unchanged, record });
        } else {
            output::print(&text(&root, &stored))?;
        }
    }
    if arguments.json {
        output::print_json(&all)?;
    }
    Ok(outcome)
}

/// Stores a session where it was asked for, or beside the session, or where that cannot be written in the user's cache.
fn stored((described, (manifest, rig)): Sitting, asked: Option<&Path>) -> Result<(PathBuf, Stored), Failure> {
    let open = |name: &str| described.open_log(name);
    let to = |root: PathBuf| -> Result<(PathBuf, Stored), IngestError> {
        let stored = store::ingest(manifest, rig, &open, &root)?;
        Ok((root, stored))
    };
    if let Some(folder) = asked {
        return Ok(to(folder.join(described.id()))?);
    }
    let folder = described.folder().ok_or_else(|| no_place(described.id()))?;
    match to(folder.join(".pneuval")) {
        Err(IngestError::Write { source, .. }) if is_read_only(&source) => {
            let cache = cache(folder, described.id()).ok_or_else(|| no_place(described.id()))?;
            output::tell(&format!("note: {}: {source}; stored in {} instead", folder.display(), cache.display()));
            Ok(to(cache)?)
        }
        stored => Ok(stored?),
    }
}

fn is_read_only(error: &std::io::Error) -> bool {
    matches!(error.kind(), std::io::ErrorKind::PermissionDenied | std::io::ErrorKind::ReadOnlyFilesystem)
}

/// A session's folder in the user's cache: its id and what tells it from another of the same id.
fn cache(folder: &Path, id: &str) -> Option<PathBuf> {
    let variable = |name: &str| std::env::var_os(name).map(PathBuf::from).filter(|path| path.is_absolute());
    let root = variable("XDG_CACHE_HOME")
        .or_else(|| Some(variable("HOME")?.join(".cache")))
        .or_else(|| variable("LOCALAPPDATA"))?;
    let real = folder.canonicalize().ok()?;
    let digest = digest::sha256(real.to_string_lossy().as_bytes());
    Some(root.join("pneuval").join(format!("{id}-{}", digest.get(..12)?)))
}

fn no_place(id: &str) -> IngestError {
    let source = std::io::Error::other("neither the session's folder nor a cache of the user's; name one with --store");
    IngestError::write(Path::new(id), source)
}

/// Whether data are lost, or more samples excluded than the session allows.
fn is_open(manifest: &SessionManifest, record: &StoredSession) -> bool {
    let lost = record.findings().any(|finding| finding.severity == Severity::Lost);
    let required = manifest.required();
    let channels =
        || record.files.iter().flat_map(StoredFile::tables).flat_map(|t| t.channels.iter().map(move |c| (t, c)));
    let excluded = required.iter().any(|id| {
        let of_id = || channels().filter(|(_, channel)| channel.id == **id);
        let samples: usize = of_id().map(|(table, _)| table.samples).sum();
        let holes: usize = of_id().map(|(_, channel)| channel.holes).sum();
        holes as f64 > manifest.excluded_share_max * samples as f64
    });
    lost || excluded
}

fn text(root: &Path, stored: &Stored) -> String {
    let mut rows =
        table::plain(&["run", "topic", "samples", "from", "to", "rate", "channels (SI units)", "table"], &[2, 3, 4, 5]);
    let mut runs: Vec<_> = stored.record.files.iter().flat_map(|file| &file.runs).collect();
    runs.sort_by_key(|run| run.number);
    for run in runs {
        for table in &run.tables {
            rows.add_row(row(&run.id, table));
        }
    }
    table::fit(&mut rows);
    let count = |files: &[String], what: &str| format!("{} {what}", files.len());
    format!(
        "{}\n\n{}: {}, {}; stored in {}\n",
        rows.trim_fmt(),
        stored.record.session,
        count(&stored.read, if stored.read.len() == 1 { "file read" } else { "files read" }),
        count(&stored.unchanged, "unchanged"),
        root.display()
    )
}

fn row(run: &str, table: &StoredTable) -> Vec<String> {
    let seconds = |t: Option<f64>| t.map_or("–".to_owned(), |t| format!("{t:.3} s"));
    let channels: Vec<&str> = table.channels.iter().map(|channel| channel.column.as_str()).collect();
    vec![
        run.to_owned(),
        if table.stream.is_empty() { "–".to_owned() } else { table.stream.clone() },
        table.samples.to_string(),
        seconds(table.from_s),
        seconds(table.to_s),
        table.rate_hz.map_or("–".to_owned(), table::hertz),
        channels.join(", "),
        table.file.clone(),
    ]
}
