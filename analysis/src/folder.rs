//! The results folder on disk: written whole or not at all, read back checked.
//!
//! ```text
//! OUT/index.html, OUT/<actuator>.html      pages
//! OUT/results/results.json                 every number, with the digests of the files below
//! OUT/results/results.schema.json          its JSON Schema
//! OUT/results/series.parquet               curves
//! OUT/results/logs.parquet                 channels of runs over time, thinned
//! OUT/results/points.csv, points.parquet   every point that is compared
//! OUT/results/junit.xml, summary.md        the decision for CI servers and pull requests
//! OUT/results/figures/*.png                figures
//! OUT/results/photographs/*.jpg            photographs with what was measured in them
//! ```

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

use pneuval_ingest::store::{Columns, read_parquet, write_parquet};
use pneuval_ingest::{IngestError, digest, limits};

use crate::AnalysisError;
use crate::ci;
use crate::compare::Evaluation;
use crate::logs;
use crate::photographs::{self, PHOTOGRAPHS, Shown};
use crate::place::{self, Kind};
use crate::report;
use crate::report::Told;
use crate::results::{Results, SCHEMA_VERSION};
use crate::series;

const RESULTS: &str = "results.json";
const SCHEMA: &str = "results.schema.json";
const SERIES: &str = "series.parquet";
const LOGS: &str = "logs.parquet";
const POINTS_CSV: &str = "points.csv";
const POINTS_PARQUET: &str = "points.parquet";
const JUNIT: &str = "junit.xml";
const SUMMARY: &str = "summary.md";
const FIGURES: &str = "figures";
/// The results folder inside a report.
const FOLDER: &str = "results";

/// Which figures are drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Figures {
    /// None: pages hold tables only.
    None,
    /// Those that a reader needs most, where there are many.
    Some,
    /// Every one.
    Every,
}

/// How a report is drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Drawing {
    /// Which figures.
    pub figures: Figures,
    /// Each page holds its photographs, too: it can be sent alone.
    pub one_file: bool,
}

/// Draws an evaluation and writes it to a folder, replacing an earlier report of this program.
///
/// It appears whole or not at all. Returns the results as stored. `told` hears of every figure that is drawn.
///
/// # Errors
/// [`AnalysisError::Foreign`] if `out` holds anything this program did not write; otherwise what drawing or writing says.
pub fn publish(out: &Path, evaluation: Evaluation, drawing: Drawing, told: &Told) -> Result<Results, AnalysisError> {
    place::publish(out, &REPORT, |new| write_into(new, evaluation, drawing, told))
}

/// The results of an evaluation as [`publish`] would store them, checked as there, without a file written: its list of files is empty.
///
/// # Errors
/// [`AnalysisError::Results`] if they could not be read back.
pub fn unpublished(evaluation: Evaluation) -> Result<Results, AnalysisError> {
    let mut results = evaluation.results;
    results.files.clear();
    photographs::forget(&mut results);
    readable_json(Path::new(RESULTS), &results)?;
    Ok(results)
}

fn write_into(new: &Path, evaluation: Evaluation, drawing: Drawing, told: &Told) -> Result<Results, AnalysisError> {
    let Evaluation { mut results, curves, logs, photographs } = evaluation;
    let folder = new.join(FOLDER);
    let figures_folder = folder.join(FIGURES);
    fs::create_dir_all(&folder).map_err(|source| IngestError::write(&folder, source))?;
    results.files.clear();
    let points = ci::points(&results);
    let mut stored = |name: &str, columns: Columns| -> Result<(), AnalysisError> {
        let path = folder.join(name);
        write_parquet(&path, &columns)?;
        let bytes = fs::read(&path).map_err(|source| IngestError::read(&path, source))?;
        results.files.insert(name.to_owned(), digest::sha256(&bytes));
        Ok(())
    };
    stored(SERIES, series::to_columns(&curves))?;
    stored(LOGS, logs::to_columns(&logs))?;
    stored(POINTS_PARQUET, points)?;
    let figures = match drawing.figures {
        Figures::None => vec![],
        Figures::Some => report::figures(&results, &curves, &logs, report::Files::Some, told)?,
        Figures::Every => report::figures(&results, &curves, &logs, report::Files::Every, told)?,
    };
    // An empty folder would be none of the report's files.
    if figures.iter().any(|figure| figure.png.is_some()) {
        fs::create_dir(&figures_folder).map_err(|source| IngestError::write(&figures_folder, source))?;
    }
    for (figure, png) in figures.iter().filter_map(|figure| Some((figure, figure.png.as_ref()?))) {
        let name = format!("{FIGURES}/{}.png", figure.name);
        write(&folder.join(&name), png)?;
        results.files.insert(name, digest::sha256(png));
    }
    let photographs = match drawing.figures {
        Figures::None => BTreeMap::new(),
        Figures::Some | Figures::Every => photographs::drawn(photographs)?,
    };
    if photographs.is_empty() {
        photographs::forget(&mut results);
    } else {
        let inside = folder.join(PHOTOGRAPHS);
        fs::create_dir(&inside).map_err(|source| IngestError::write(&inside, source))?;
    }
    for (name, jpeg) in &photographs {
        write(&folder.join(name), jpeg)?;
        results.files.insert(name.clone(), digest::sha256(jpeg));
    }
    for (name, bytes) in [
        (POINTS_CSV, ci::points_csv(&results)?),
        (JUNIT, ci::junit(&results, &[])?.into_bytes()),
        (SUMMARY, ci::markdown(&results, &[]).into_bytes()),
    ] {
        write(&folder.join(name), &bytes)?;
        results.files.insert(name.to_owned(), digest::sha256(&bytes));
    }
    let json = readable_json(&folder.join(RESULTS), &results)?;
    write(&folder.join(RESULTS), json.as_bytes())?;
    write(&folder.join(SCHEMA), schema_json()?.as_bytes())?;
    let within = if drawing.one_file { Some(&photographs) } else { None };
    for page in report::pages(&results, &figures, within, drawing.figures == Figures::Every)? {
        write(&new.join(&page.name), page.html.as_bytes())?;
    }
    Ok(results)
}

/// The text of `results.json`, read back: what cannot be (a number that is not finite becomes null) must not be left for `gate` to find.
fn readable_json(path: &Path, results: &Results) -> Result<String, AnalysisError> {
    let json = to_json(results)?;
    parse(path, json.as_bytes())?;
    Ok(json)
}

fn write(path: &Path, bytes: &[u8]) -> Result<(), AnalysisError> {
    fs::write(path, bytes).map_err(|source| IngestError::write(path, source).into())
}

/// The text of `results.json`.
///
/// # Errors
/// [`AnalysisError::Results`] if a number cannot be written, which the types rule out.
pub fn to_json(results: &Results) -> Result<String, AnalysisError> {
    let Results { schema_version, program, metric_definitions, report_only, actuators, comparisons, findings, files } =
        results;
    let failed = |error: serde_json::Error| problem(Path::new(RESULTS), error.to_string(), "report this as a bug");
    let members = [
        ("schema_version", serde_json::to_string(schema_version)),
        ("program", serde_json::to_string(program)),
        ("metric_definitions", serde_json::to_string(metric_definitions)),
        ("report_only", serde_json::to_string(report_only)),
        ("actuators", lines(actuators)),
        ("comparisons", lines(comparisons)),
        ("findings", lines(findings)),
        ("files", serde_json::to_string_pretty(files).map(|text| text.replace('\n', "\n  "))),
    ];
    let member = |(key, text): (&str, serde_json::Result<String>)| text.map(|text| format!("  \"{key}\": {text}"));
    let members = members.into_iter().map(member).collect::<Result<Vec<_>, _>>().map_err(failed)?;
    Ok(format!("{{\n{}\n}}\n", members.join(",\n")))
}

/// A list with one line for each member: short where there are many, and a difference is where it belongs.
fn lines(list: &[impl serde::Serialize]) -> serde_json::Result<String> {
    let members = list.iter().map(serde_json::to_string).collect::<serde_json::Result<Vec<_>>>()?;
    Ok(if members.is_empty() { "[]".to_owned() } else { format!("[\n    {}\n  ]", members.join(",\n    ")) })
}

/// The text of `results.schema.json`.
///
/// # Errors
/// As [`to_json`].
pub fn schema_json() -> Result<String, AnalysisError> {
    match serde_json::to_string_pretty(&Results::schema()) {
        Ok(text) => Ok(text + "\n"),
        Err(error) => Err(problem(Path::new(SCHEMA), error.to_string(), "report this as a bug")),
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
    let logs_path = folder.join(LOGS);
    let logs = logs::from_columns(&read_parquet(&logs_path)?).ok_or_else(|| {
        problem(&logs_path, "its columns are not those of logs".into(), "run `pneuval validate` again")
    })?;
    let mut photographs = BTreeMap::new();
    for record in photographs::records(&results) {
        // Files that results name are checked above; what they do not name is not theirs.
        if !results.files.contains_key(&record.path) {
            let text = format!("it names the photograph `{}`, which is not among its files", record.path);
            return Err(problem(&file, text, "run `pneuval validate` again"));
        }
        let bytes = limits::read(&folder.join(&record.path), limits::RESULTS_BYTES_MAX)?;
        photographs.insert(record.path.clone(), Shown::Drawn(bytes));
    }
    Ok((folder, Evaluation { results, curves, logs, photographs }))
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

/// What a report holds, by its `results.json`.
const REPORT: Kind = Kind { name: "report", record: "results/results.json", files: files_of };

/// The files of an earlier report, from its results of whatever schema.
fn files_of(results: &serde_json::Value) -> Option<BTreeSet<String>> {
    let inside = |name: &str| format!("{FOLDER}/{name}");
    let mut known: BTreeSet<String> = results.get("files")?.as_object()?.keys().map(|name| inside(name)).collect();
    known.extend([inside(RESULTS), inside(SCHEMA), "index.html".to_owned()]);
    let ids = results.get("actuators")?.as_array()?.iter().filter_map(|a| a.get("id")?.as_str());
    known.extend(ids.map(|id| format!("{id}.html")));
    Some(known)
}
