//! The results folder on disk: written whole or not at all, read back checked.
//!
//! ```text
//! OUT/index.html, OUT/<actuator>.html      pages
//! OUT/results/results.json                 every number, with the digests of the files below
//! OUT/results/results.schema.json          its JSON Schema
//! OUT/results/series.parquet               curves
//! OUT/results/figures/*.png                figures
//! ```

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

use pneuval_ingest::store::{read_parquet, write_parquet};
use pneuval_ingest::{IngestError, digest, limits};

use crate::AnalysisError;
use crate::compare::Evaluation;
use crate::report;
use crate::results::{Results, SCHEMA_VERSION};
use crate::series;

const RESULTS: &str = "results.json";
const SCHEMA: &str = "results.schema.json";
const SERIES: &str = "series.parquet";
const FIGURES: &str = "figures";
/// The results folder inside a report.
const FOLDER: &str = "results";

/// Draws an evaluation and writes it to a folder, replacing an earlier report of this program.
///
/// Everything is written to a temporary folder beside `out` and moved into place at the end, so a reader never sees half of
/// it, and an error leaves `out` as it was. Returns the results as stored.
///
/// # Errors
/// [`AnalysisError::Foreign`] if `out` holds anything this program did not write; otherwise what drawing or writing says.
pub fn publish(out: &Path, evaluation: Evaluation) -> Result<Results, AnalysisError> {
    check_replaceable(out)?;
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
    let results = write_into(&new, evaluation)?;
    if out.exists() {
        let old = temporary.path().join("old");
        fs::rename(out, &old).map_err(|source| IngestError::write(out, source))?;
        if let Err(source) = fs::rename(&new, out) {
            // Put the earlier report back; if that fails too, the first error is the one to tell.
            let _ = fs::rename(&old, out);
            return Err(IngestError::write(out, source).into());
        }
    } else {
        fs::rename(&new, out).map_err(|source| IngestError::write(out, source))?;
    }
    Ok(results)
}

fn write_into(new: &Path, evaluation: Evaluation) -> Result<Results, AnalysisError> {
    let Evaluation { mut results, curves } = evaluation;
    let folder = new.join(FOLDER);
    let figures_folder = folder.join(FIGURES);
    fs::create_dir_all(&figures_folder).map_err(|source| IngestError::write(&figures_folder, source))?;
    write_parquet(&folder.join(SERIES), &series::to_columns(&curves))?;
    results.files.clear();
    let series_path = folder.join(SERIES);
    let bytes = fs::read(&series_path).map_err(|source| IngestError::read(&series_path, source))?;
    results.files.insert(SERIES.to_owned(), digest::sha256(&bytes));
    let figures = report::figures(&results, &curves)?;
    for figure in &figures {
        let name = format!("{FIGURES}/{}.png", figure.name);
        write(&folder.join(&name), &figure.png)?;
        results.files.insert(name, digest::sha256(&figure.png));
    }
    write(&folder.join(RESULTS), to_json(&results)?.as_bytes())?;
    write(&folder.join(SCHEMA), schema_json()?.as_bytes())?;
    for page in report::pages(&results, &figures)? {
        write(&new.join(&page.name), page.html.as_bytes())?;
    }
    Ok(results)
}

fn write(path: &Path, bytes: &[u8]) -> Result<(), AnalysisError> {
    fs::write(path, bytes).map_err(|source| IngestError::write(path, source).into())
}

/// The text of `results.json`.
///
/// # Errors
/// [`AnalysisError::Results`] if a number cannot be written, which the types rule out.
pub fn to_json(results: &Results) -> Result<String, AnalysisError> {
    pretty(results, RESULTS)
}

/// The text of `results.schema.json`.
///
/// # Errors
/// As [`to_json`].
pub fn schema_json() -> Result<String, AnalysisError> {
    pretty(&Results::schema(), SCHEMA)
}

fn pretty(value: &impl serde::Serialize, name: &str) -> Result<String, AnalysisError> {
    match serde_json::to_string_pretty(value) {
        Ok(text) => Ok(text + "\n"),
        Err(error) => Err(problem(Path::new(name), error.to_string(), "report this as a bug")),
    }
}

fn problem(path: &Path, problem: String, next: &str) -> AnalysisError {
    AnalysisError::Results { path: path.to_owned(), problem, next: next.to_owned() }
}

/// Reads stored results: `path` is a report, its `results` folder, or `results.json`.
///
/// # Errors
/// [`AnalysisError::Results`] if there are none, they are of another schema, or a stored file is not the one they name.
pub fn load(path: &Path) -> Result<(PathBuf, Evaluation), AnalysisError> {
    let candidates = [path.join(FOLDER), path.to_owned(), path.parent().map(Path::to_owned).unwrap_or_default()];
    let Some(folder) = candidates.into_iter().find(|folder| folder.join(RESULTS).is_file()) else {
        return Err(problem(path, "no results.json here".into(), "name a folder that `pneuval validate` wrote"));
    };
    let file = folder.join(RESULTS);
    let bytes = limits::read(&file, limits::RESULTS_BYTES_MAX)?;
    let results = parse(&file, &bytes)?;
    let series_path = folder.join(SERIES);
    let bytes = limits::read(&series_path, limits::RESULTS_BYTES_MAX)?;
    if results.files.get(SERIES) != Some(&digest::sha256(&bytes)) {
        return Err(problem(
            &series_path,
            "its SHA-256 is not the one in results.json".into(),
            "run `pneuval validate` again",
        ));
    }
    let curves = series::from_columns(&read_parquet(&series_path)?).ok_or_else(|| {
        problem(&series_path, "its columns are not those of curves".into(), "run `pneuval validate` again")
    })?;
    Ok((folder, Evaluation { results, curves }))
}

fn parse(file: &Path, bytes: &[u8]) -> Result<Results, AnalysisError> {
    let next = "run `pneuval validate` again";
    let value: serde_json::Value =
        serde_json::from_slice(bytes).map_err(|error| problem(file, format!("not JSON: {error}"), next))?;
    let version = value.get("schema_version").and_then(serde_json::Value::as_u64);
    if version != Some(u64::from(SCHEMA_VERSION)) {
        let found = version.map_or("none".to_owned(), |v| v.to_string());
        let text = format!("schema_version {SCHEMA_VERSION} expected, found {found}");
        return Err(problem(file, text, "use the program version that wrote it, or validate again"));
    }
    serde_json::from_value(value).map_err(|error| problem(file, format!("not results of this schema: {error}"), next))
}

/// A folder may be replaced if it is absent, empty, or holds nothing but an earlier report.
fn check_replaceable(out: &Path) -> Result<(), AnalysisError> {
    let foreign = |found: String| AnalysisError::Foreign { path: out.to_owned(), found };
    if !out.exists() {
        return Ok(());
    }
    if !out.is_dir() {
        return Err(foreign("a file".to_owned()));
    }
    let mut files = BTreeSet::new();
    list(out, out, &mut files)?;
    if files.is_empty() {
        return Ok(());
    }
    let known = earlier_report(&out.join(FOLDER).join(RESULTS));
    let Some(known) = known else {
        let first = files.first().cloned().unwrap_or_default();
        return Err(foreign(format!("`{first}`, and no results of this program")));
    };
    match files.difference(&known).next() {
        None => Ok(()),
        Some(stranger) => Err(foreign(format!("`{stranger}`, which is not part of the report"))),
    }
}

/// The files of an earlier report, from its `results.json` of whatever schema; `None` if that is not a report of this program.
fn earlier_report(stored: &Path) -> Option<BTreeSet<String>> {
    let bytes = limits::read(stored, limits::RESULTS_BYTES_MAX).ok()?;
    let results: serde_json::Value = serde_json::from_slice(&bytes).ok()?;
    if !results.get("program")?.as_str()?.starts_with("pneuval ") {
        return None;
    }
    let inside = |name: &str| format!("{FOLDER}/{name}");
    let mut known: BTreeSet<String> = results.get("files")?.as_object()?.keys().map(|name| inside(name)).collect();
    known.extend([inside(RESULTS), inside(SCHEMA), "index.html".to_owned()]);
    let ids = results.get("actuators")?.as_array()?.iter().filter_map(|a| a.get("id")?.as_str());
    known.extend(ids.map(|id| format!("{id}.html")));
    Some(known)
}

/// Files below a folder, relative to `root`, with forward slashes.
fn list(root: &Path, folder: &Path, files: &mut BTreeSet<String>) -> Result<(), AnalysisError> {
    let entries = fs::read_dir(folder).map_err(|source| IngestError::read(folder, source))?;
    for entry in entries {
        let entry = entry.map_err(|source| IngestError::read(folder, source))?;
        let path = entry.path();
        let kind = entry.file_type().map_err(|source| IngestError::read(&path, source))?;
        if kind.is_dir() {
            list(root, &path, files)?;
        } else {
            let relative = path.strip_prefix(root).unwrap_or(&path);
            files.insert(relative.to_string_lossy().replace('\\', "/"));
        }
    }
    Ok(())
}
