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

/// Whether figures are drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Drawing {
    /// Every figure.
    Figures,
    /// None: pages hold tables only.
    None,
}

/// Draws an evaluation and writes it to a folder, replacing an earlier report of this program.
///
/// Everything is written to a temporary folder beside `out` and moved into place at the end, so a reader never sees half of
/// it, and an error leaves `out` as it was. Returns the results as stored.
///
/// # Errors
/// [`AnalysisError::Foreign`] if `out` holds anything this program did not write; otherwise what drawing or writing says.
pub fn publish(out: &Path, evaluation: Evaluation, drawing: Drawing) -> Result<Results, AnalysisError> {
    // A link is followed, and a folder that is somebody's working directory has a name.
    let resolved =
        if out.exists() { Some(out.canonicalize().map_err(|source| IngestError::write(out, source))?) } else { None };
    let out = resolved.as_deref().unwrap_or(out);
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
    let results = write_into(&new, evaluation, drawing)?;
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

fn write_into(new: &Path, evaluation: Evaluation, drawing: Drawing) -> Result<Results, AnalysisError> {
    let Evaluation { mut results, curves } = evaluation;
    let folder = new.join(FOLDER);
    let figures_folder = folder.join(FIGURES);
    fs::create_dir_all(&folder).map_err(|source| IngestError::write(&folder, source))?;
    write_parquet(&folder.join(SERIES), &series::to_columns(&curves))?;
    results.files.clear();
    let series_path = folder.join(SERIES);
    let bytes = fs::read(&series_path).map_err(|source| IngestError::read(&series_path, source))?;
    results.files.insert(SERIES.to_owned(), digest::sha256(&bytes));
    let figures = match drawing {
        Drawing::Figures => report::figures(&results, &curves)?,
        Drawing::None => vec![],
    };
    // An empty folder would be none of the report's files.
    if !figures.is_empty() {
        fs::create_dir(&figures_folder).map_err(|source| IngestError::write(&figures_folder, source))?;
    }
    for figure in &figures {
        let name = format!("{FIGURES}/{}.png", figure.name);
        write(&folder.join(&name), &figure.png)?;
        results.files.insert(name, digest::sha256(&figure.png));
    }
    let json = to_json(&results)?;
    // What cannot be read back (a number that is not finite becomes null) must not be left for `gate` to find.
    parse(&folder.join(RESULTS), json.as_bytes())?;
    write(&folder.join(RESULTS), json.as_bytes())?;
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
    let missing = || problem(path, "no results.json here".into(), "name a folder that `pneuval validate` wrote");
    let named = path.canonicalize().map_err(|_| missing())?;
    let folder = if named.is_file() && named.file_name().is_some_and(|name| name == RESULTS) {
        named.parent().map(Path::to_owned).unwrap_or_default()
    } else {
        let inside = [named.join(FOLDER), named];
        inside.into_iter().find(|folder| folder.join(RESULTS).is_file()).ok_or_else(missing)?
    };
    let file = folder.join(RESULTS);
    let bytes = limits::read(&file, limits::RESULTS_BYTES_MAX)?;
    let results = parse(&file, &bytes)?;
    for (name, digest) in &results.files {
        let stored = folder.join(name);
        if digest::sha256(&limits::read(&stored, limits::RESULTS_BYTES_MAX)?) != *digest {
            return Err(problem(
                &stored,
                "its SHA-256 is not the one in results.json".into(),
                "run `pneuval validate` again",
            ));
        }
    }
    let series_path = folder.join(SERIES);
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
    let results: Results = serde_json::from_value(value)
        .map_err(|error| problem(file, format!("not results of this schema: {error}"), next))?;
    results.check().map_err(|what| problem(file, what, next))?;
    Ok(results)
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
    let known = earlier_report(&out.join(FOLDER).join(RESULTS));
    match stranger(out, out, known.as_ref().unwrap_or(&BTreeSet::new()))? {
        None => Ok(()),
        Some(name) if known.is_some() => Err(foreign(format!("`{name}`, which is not part of the report"))),
        Some(name) => Err(foreign(format!("`{name}`, and no results of this program"))),
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
