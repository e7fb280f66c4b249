//! What was read, stored: Parquet tables that DuckDB, pandas and polars open, and a `session.json` that says what they hold.
//!
//! | file | holds |
//! |---|---|
//! | `parquet.rs` | the tables; the only module that sees polars |
//! | `names.rs` | names of columns and files |
//! | `record.rs` | `session.json` |
//! | `mod.rs` | which files are read again, and how the store changes |
//!
//! A store can be rebuilt from the raw files at any time and is never edited. It changes by renaming whole files into place,
//! `session.json` last; the same raw files and manifests give the same bytes.

mod names;
mod parquet;
mod record;

use std::collections::BTreeSet;
use std::fs;
use std::io::Write as _;
use std::path::{Path, PathBuf};

pub use names::{TIME, column_name, file_name, unique_name};
pub use parquet::{Columns, Series, read_parquet, read_parquet_metadata, write_cells, write_parquet, write_table};
pub use record::{StoredChannel, StoredFile, StoredRun, StoredSession, StoredTable};

use crate::IngestError;
use crate::finding::rate_hz;
use crate::limits;
use crate::manifest::{FileDigest, LogFile, Rig, SessionManifest};
use crate::raw::RawFile;
use crate::session::{Bases, FileRuns, OpenBeside, Run, Stream, open_files, unusable_file};

/// The name of the record in a store.
pub const RECORD: &str = "session.json";

/// What storing a session did.
#[derive(Debug, Clone, PartialEq)]
pub struct Stored {
    /// The record, as it stands in the store.
    pub record: StoredSession,
    /// Files that were read.
    pub read: Vec<String>,
    /// Files that were stored already and have not changed.
    pub unchanged: Vec<String>,
}

/// Reads the files of a session that the store does not hold yet, and stores them; one file is in memory at a time.
///
/// A file is read again if its bytes, the manifest, the rig or the version of this program have changed, or if what the store holds
/// of it is damaged; and a file of a device, if its stamps stand on the time base of a file beside it that is now another.
///
/// # Errors
/// As [`crate::session::Session::load`], with nothing stored; [`IngestError::Write`] where the store cannot be written.
pub fn ingest(
    manifest: &SessionManifest,
    rig: Option<&Rig>,
    open: OpenBeside,
    root: &Path,
) -> Result<Stored, IngestError> {
    let raws = open_files(manifest, open)?;
    fs::create_dir_all(root).map_err(|source| IngestError::write(root, source))?;
    let stored = store(manifest, rig, &raws, root);
    if stored.is_err() {
        // A store that was made for nothing goes again; one that holds anything stays.
        let _ = fs::remove_dir(root);
    }
    stored
}

/// Stores the files of a session in a folder that is there.
fn store(
    manifest: &SessionManifest,
    rig: Option<&Rig>,
    raws: &[(FileDigest, RawFile)],
    root: &Path,
) -> Result<Stored, IngestError> {
    let stored = StoredSession::read(&root.join(RECORD));
    let before = stored.as_ref().filter(|before| before.is_of(manifest, rig));
    let staging =
        tempfile::Builder::new().prefix(".new-").tempdir_in(root).map_err(|source| IngestError::write(root, source))?;
    let mut names = BTreeSet::new();
    let (mut files, mut read, mut unchanged) = (Vec::new(), Vec::new(), Vec::new());
    let mut unusable = None;
    let views = manifest.views();
    let mut bases = Bases::new(manifest);
    for (log, (digest, raw)) in manifest.logs().into_iter().zip(raws) {
        let kept = before.and_then(|before| before.file(digest)).filter(|file| file.is_whole(root));
        if let Some(file) = kept.filter(|file| is_on_base(file, &bases) && has_free_names(file, &names)) {
            names.extend(file.tables().map(|table| table.file.clone()));
            for (number, table) in stamped(file) {
                bases.know(number, table.counts_from.as_deref(), file.title(table));
            }
            unchanged.push(digest.name.clone());
            files.push(file.clone());
            continue;
        }
        read.push(digest.name.clone());
        match FileRuns::read(&views, rig, log, raw) {
            Ok(mut runs) => {
                for (number, run, told) in &mut runs.runs {
                    bases.align(*number, run, told)?;
                }
                files.push(write_file(log, (digest, raw.len()), runs, staging.path(), &mut names)?);
            }
            // One log that cannot be used does not take the others with it.
            Err(error @ IngestError::Unusable { .. }) => {
                files.push(StoredFile::unusable(log, digest, raw.len(), unusable_file(&digest.name, &error)));
                unusable.get_or_insert(error);
            }
            Err(error) => return Err(error),
        }
    }
    if let Some(error) = unusable.filter(|_| files.iter().all(|file| file.runs.is_empty())) {
        return Err(error);
    }
    let record = StoredSession::new(manifest, rig, files);
    replace(root, staging.path(), stored.as_ref(), &record)?;
    Ok(Stored { record, read, unchanged })
}

/// Tables with a stamp, each with the number of its run.
fn stamped(file: &StoredFile) -> impl Iterator<Item = (usize, &StoredTable)> {
    let tables = file.runs.iter().flat_map(|run| run.tables.iter().map(|table| (run.number, table)));
    tables.filter(|(_, table)| table.from_s.is_some())
}

/// Whether the stamps stored of a file stand on the time bases of its runs.
fn is_on_base(file: &StoredFile, bases: &Bases) -> bool {
    stamped(file).all(|(number, table)| bases.agrees(number, table.counts_from.as_deref(), table.shift_s))
}

/// Whether no file before it has got a name of its tables meanwhile.
fn has_free_names(file: &StoredFile, names: &BTreeSet<String>) -> bool {
    file.tables().all(|table| !names.iter().any(|taken| taken.eq_ignore_ascii_case(&table.file)))
}

/// Writes the tables of a file's runs into a folder.
fn write_file(
    log: LogFile,
    (digest, bytes): (&FileDigest, u64),
    read: FileRuns,
    folder: &Path,
    names: &mut BTreeSet<String>,
) -> Result<StoredFile, IngestError> {
    let FileRuns { runs: of_file, findings: of_rest, origin } = read;
    let (mut runs, mut findings) = (Vec::new(), Vec::new());
    for (number, run, mut told) in of_file {
        findings.append(&mut told);
        let mut tables = Vec::new();
        for (stream, clock) in run.streams.iter().enumerate() {
            tables.push(write_stream(&run, stream, clock, folder, names)?);
        }
        runs.push(StoredRun { id: run.id, number, tables });
    }
    findings.extend(of_rest);
    let FileDigest { name, sha256 } = digest.clone();
    Ok(StoredFile { name, device: log.device.map(str::to_owned), sha256, bytes, origin, runs, findings })
}

fn write_stream(
    run: &Run,
    stream: usize,
    clock: &Stream,
    folder: &Path,
    names: &mut BTreeSet<String>,
) -> Result<StoredTable, IngestError> {
    let channels: Vec<_> = run.channels.iter().filter(|(_, channel)| channel.stream == stream).collect();
    let mut columns: Vec<(String, &[f64])> = Vec::with_capacity(channels.len() + 1);
    columns.extend(clock.seconds.as_deref().map(|seconds| (TIME.to_owned(), seconds)));
    let mut taken = BTreeSet::from([TIME.to_owned()]);
    let mut stored = Vec::with_capacity(channels.len());
    for (id, channel) in channels {
        let si = channel.unit.dimension.si_symbol();
        let column = unique_name(&column_name(id, si), &mut taken);
        stored.push(StoredChannel {
            id: id.clone(),
            column: column.clone(),
            si_unit: si.to_owned(),
            unit: channel.unit.symbol.to_owned(),
            std_si: channel.std_si,
            commanded: channel.commanded,
            holes: channel.values_si.iter().filter(|v| v.is_nan()).count(),
        });
        columns.push((column, &channel.values_si));
    }
    let device = clock.device.as_deref().unwrap_or_default();
    let file = file_name(&run.id, &[device, &clock.name], "parquet", names);
    let path = folder.join(&file);
    write_table(&path, &columns)?;
    let sha256 = RawFile::open(&path, &file, u64::MAX)?.sha256()?;
    let stamps = clock.seconds.as_deref().unwrap_or_default();
    let first = stamps.iter().copied().find(|t| t.is_finite());
    let last = stamps.iter().copied().rfind(|t| t.is_finite());
    Ok(StoredTable {
        file,
        sha256,
        stream: clock.name.clone(),
        samples: clock.samples,
        from_s: first,
        to_s: last,
        counts_from: clock.epoch.map(|epoch| epoch.to_string()),
        shift_s: clock.shift_s,
        rate_hz: rate_hz(stamps),
        channels: stored,
    })
}

/// Moves new tables into place, then the record, then removes the tables that the record before it names and this one does not. A
/// folder given with `--store` may hold tables of somebody else: they stay.
fn replace(
    root: &Path,
    staging: &Path,
    before: Option<&StoredSession>,
    record: &StoredSession,
) -> Result<(), IngestError> {
    let tables = |of: &StoredSession| -> BTreeSet<String> {
        of.files.iter().flat_map(StoredFile::tables).map(|table| table.file.clone()).collect()
    };
    let named = tables(record);
    let rename = |from: &Path, to: &Path| fs::rename(from, to).map_err(|source| IngestError::write(to, source));
    for entry in entries(staging)? {
        if let Some(name) = entry.file_name() {
            rename(&entry, &root.join(name))?;
        }
    }
    let path = root.join(RECORD);
    let text = record.to_json().map_err(|source| IngestError::write(&path, source.into()))?;
    let same = limits::read(&path, limits::RESULTS_BYTES_MAX).is_ok_and(|bytes| bytes == text.as_bytes());
    if !same {
        let new = staging.join(RECORD);
        let written = fs::File::create(&new).and_then(|mut file| {
            file.write_all(text.as_bytes())?;
            file.sync_all()
        });
        written.map_err(|source| IngestError::write(&new, source))?;
        rename(&new, &path)?;
    }
    let gone = before.map(tables).unwrap_or_default();
    // A record is a file that anybody can write: what it names elsewhere is not the store's.
    let is_here = |name: &&String| Path::new(name).file_name().is_some_and(|last| last == name.as_str());
    for name in gone.difference(&named).filter(is_here) {
        let path = root.join(name);
        match fs::remove_file(&path) {
            Err(source) if source.kind() != std::io::ErrorKind::NotFound => {
                return Err(IngestError::write(&path, source));
            }
            _ => {}
        }
    }
    Ok(())
}

fn entries(folder: &Path) -> Result<Vec<PathBuf>, IngestError> {
    let failed = |source| IngestError::read(folder, source);
    let mut paths = Vec::new();
    for entry in fs::read_dir(folder).map_err(failed)? {
        paths.push(entry.map_err(failed)?.path());
    }
    paths.sort();
    Ok(paths)
}
