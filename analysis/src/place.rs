//! A folder that appears whole or not at all, and only over an earlier one of its kind.

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

use pneuval_ingest::{IngestError, limits};

use crate::AnalysisError;

/// What kind of folder is written.
pub(crate) struct Kind {
    /// Its name in messages: `report`.
    pub name: &'static str,
    /// The file in it that says what it holds, as JSON.
    pub record: &'static str,
    /// The files that such a record names, itself included, relative to the folder; `None` if it is none of this program.
    pub files: fn(&serde_json::Value) -> Option<BTreeSet<String>>,
}

/// Writes a folder beside `out` and moves it into place at the end, so a reader never sees half of it, and an error leaves `out` as it
/// was.
///
/// # Errors
/// [`AnalysisError::Foreign`] if `out` holds anything but an earlier folder of this kind; otherwise what `write` says, or the system.
pub(crate) fn publish<T>(
    out: &Path,
    kind: &Kind,
    write: impl FnOnce(&Path) -> Result<T, AnalysisError>,
) -> Result<T, AnalysisError> {
    // A link is followed, and a folder that is somebody's working directory has a name.
    let resolved =
        if out.exists() { Some(out.canonicalize().map_err(|source| IngestError::write(out, source))?) } else { None };
    let out = resolved.as_deref().unwrap_or(out);
    check_replaceable(out, kind)?;
    let parent = match out.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    };
    fs::create_dir_all(parent).map_err(|source| IngestError::write(parent, source))?;
    let temporary = tempfile::Builder::new()
        .prefix(".pneuval-")
        .tempdir_in(parent)
        .map_err(|source| IngestError::write(parent, source))?;
    let new = temporary.path().join("new");
    let written = write(&new)?;
    if out.exists() {
        let old = temporary.path().join("old");
        fs::rename(out, &old).map_err(|source| IngestError::write(out, source))?;
        if let Err(source) = fs::rename(&new, out) {
            // Put the earlier folder back; if that fails too, the first error is the one to tell.
            let _ = fs::rename(&old, out);
            return Err(IngestError::write(out, source).into());
        }
    } else {
        fs::rename(&new, out).map_err(|source| IngestError::write(out, source))?;
    }
    Ok(written)
}

/// A folder may be replaced if it is absent, empty, or holds nothing but an earlier one of its kind.
fn check_replaceable(out: &Path, kind: &Kind) -> Result<(), AnalysisError> {
    let foreign = |found: String| AnalysisError::Foreign { path: out.to_owned(), kind: kind.name, found };
    if !out.exists() {
        return Ok(());
    }
    if !out.is_dir() {
        return Err(foreign("a file".to_owned()));
    }
    let known = earlier(&out.join(kind.record), kind);
    match stranger(out, out, known.as_ref().unwrap_or(&BTreeSet::new()))? {
        None => Ok(()),
        Some(name) if known.is_some() => Err(foreign(format!("`{name}`, which is not part of the {}", kind.name))),
        Some(name) => Err(foreign(format!("`{name}`, and no {} of this program", kind.name))),
    }
}

/// The files of an earlier folder of a kind, by its record of whatever layout.
fn earlier(record: &Path, kind: &Kind) -> Option<BTreeSet<String>> {
    let bytes = limits::read(record, limits::RESULTS_BYTES_MAX).ok()?;
    let record: serde_json::Value = serde_json::from_slice(&bytes).ok()?;
    if !record.get("program")?.as_str()?.starts_with("pneuval ") {
        return None;
    }
    (kind.files)(&record)
}

/// The first file or empty folder below `root` that is not known.
fn stranger(root: &Path, folder: &Path, known: &BTreeSet<String>) -> Result<Option<String>, AnalysisError> {
    let entries = fs::read_dir(folder).map_err(|source| IngestError::read(folder, source))?;
    let mut empty = true;
    for entry in entries {
        empty = false;
        let entry = entry.map_err(|source| IngestError::read(folder, source))?;
        let path = entry.path();
        let kind = entry.file_type().map_err(|source| IngestError::read(&path, source))?;
        let name = path.strip_prefix(root).unwrap_or(&path).to_string_lossy().replace('\\', "/");
        // Only folders that known files lie in are looked into.
        let inside = kind.is_dir() && known.iter().any(|file| file.starts_with(&format!("{name}/")));
        let found = if inside { stranger(root, &path, known)? } else { (!known.contains(&name)).then_some(name) };
        if found.is_some() {
            return Ok(found);
        }
    }
    let name = folder.strip_prefix(root).unwrap_or(folder).to_string_lossy().into_owned();
    Ok((empty && folder != root).then_some(name))
}
