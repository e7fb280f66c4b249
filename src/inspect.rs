//! `pneuval inspect`: what a raw file holds.

use std::fmt::Write as _;
use std::path::Path;

use serde::Serialize;

use pneuval_ingest::finding::Finding;
use pneuval_ingest::formats::Options;
use pneuval_ingest::inspect::{self, Inspection};
use pneuval_ingest::limits;
use pneuval_ingest::raw::RawFile;
use pneuval_ingest::recording::{Column, Table};

use crate::cli::Inspect;
use crate::exit::{self, Failure, Outcome};
use crate::{output, table};

/// A file, for `--json`.
#[derive(Serialize)]
struct FileTold<'a> {
    file: &'a str,
    format: &'static str,
    bytes: u64,
    sha256: &'a str,
    origin: Option<&'a str>,
    reasons: &'a [String],
    metadata: &'a [String],
    tables: Vec<TableTold<'a>>,
    findings: &'a [Finding],
    session: &'a str,
}

#[derive(Serialize)]
struct TableTold<'a> {
    name: &'a str,
    schema: Option<&'a str>,
    samples: usize,
    clock: Option<&'a str>,
    from_s: Option<f64>,
    to_s: Option<f64>,
    rate_hz: Option<f64>,
    columns: Vec<ColumnTold<'a>>,
}

#[derive(Serialize)]
struct ColumnTold<'a> {
    name: String,
    unit: Option<&'a str>,
    samples: usize,
    holes: usize,
    min: Option<f64>,
    max: Option<f64>,
}

pub fn run(arguments: &Inspect) -> Result<Outcome, Failure> {
    let mut outcome = Outcome::Expected;
    let (mut all, mut failures) = (Vec::new(), Vec::new());
    for path in &arguments.files {
        // One file that cannot be looked at does not hide the others.
        let inspection = match look_at(path) {
            Ok(inspection) => inspection,
            Err(failure) => {
                failures.push(failure);
                continue;
            }
        };
        if inspection.is_lossy() {
            outcome = Outcome::Open;
        }
        if arguments.json {
            all.push(inspection);
        } else {
            output::print(&text(&inspection))?;
        }
    }
    if arguments.json {
        output::print_json(&all.iter().map(told).collect::<Vec<_>>())?;
    }
    exit::worst(outcome, failures)
}

/// Looks at one file; a session.toml beside it would call it by its last name.
fn look_at(path: &Path) -> Result<Inspection, Failure> {
    let raw = RawFile::open(path, &path.display().to_string(), limits::LOG_BYTES_MAX)?;
    let name = path.file_name().map_or_else(|| path.display().to_string(), |name| name.to_string_lossy().into_owned());
    Ok(inspect::inspect(&raw, &name, &Options::default())?)
}

fn told(inspection: &Inspection) -> FileTold<'_> {
    let recording = &inspection.recording;
    FileTold {
        file: &inspection.file,
        format: recording.format,
        bytes: inspection.bytes,
        sha256: &inspection.sha256,
        origin: recording.origin.as_deref(),
        reasons: &recording.reasons,
        metadata: &recording.metadata,
        tables: recording.tables.iter().map(table_told).collect(),
        findings: &inspection.findings,
        session: &inspection.session,
    }
}

fn table_told(table: &Table) -> TableTold<'_> {
    let time = table.time();
    let clock = time.and_then(|column| column.clock.as_ref());
    let column_told = |column| {
        let Column { name, unit, summary, .. }: &Column = column;
        ColumnTold {
            name: table.full_name(name),
            unit: unit.as_deref(),
            samples: table.rows,
            holes: summary.holes,
            min: summary.range.map(|(min, _)| min),
            max: summary.range.map(|(_, max)| max),
        }
    };
    TableTold {
        name: &table.name,
        schema: table.schema.as_deref(),
        samples: table.rows,
        clock: time.map(|column| column.name.as_str()),
        from_s: clock.and_then(|clock| Some(clock.span?.0)),
        to_s: clock.and_then(|clock| Some(clock.span?.1)),
        rate_hz: clock.and_then(|clock| clock.rate_hz),
        columns: table.columns.iter().map(column_told).collect(),
    }
}

/// Columns of a table that are listed: arrays may have thousands.
const COLUMNS_SHOWN: usize = 64;

/// Lines of metadata and reasons that are shown.
const LINES_SHOWN: usize = 12;

fn text(inspection: &Inspection) -> String {
    let recording = &inspection.recording;
    let mut out = format!(
        "{}: {}, {}, SHA-256 {}\n",
        inspection.file,
        recording.format,
        table::bytes(inspection.bytes),
        inspection.sha256.get(..12).unwrap_or_default()
    );
    // Writing to a String cannot fail.
    if let Some(origin) = &recording.origin {
        let _ = writeln!(out, "  stamps count from {origin}");
    }
    listed(&mut out, &recording.reasons);
    listed(&mut out, &recording.metadata);
    for table in &recording.tables {
        out += "\n";
        out += &table_text(table);
    }
    if !inspection.findings.is_empty() {
        let _ = writeln!(out, "\nFindings");
        for finding in &inspection.findings {
            let _ = writeln!(out, "  {}: {}", finding.severity.id(), finding.text);
        }
    }
    let _ = writeln!(out, "\nIn a session.toml");
    for line in inspection.session.lines() {
        let _ = writeln!(out, "{}", if line.is_empty() { String::new() } else { format!("  {line}") });
    }
    out
}

fn listed(out: &mut String, lines: &[String]) {
    for line in lines.iter().take(LINES_SHOWN) {
        let _ = writeln!(out, "  {}", table::cut(line));
    }
    if lines.len() > LINES_SHOWN {
        let _ = writeln!(out, "  … and {} more lines", lines.len() - LINES_SHOWN);
    }
}

fn table_text(table: &Table) -> String {
    let mut out = String::new();
    if !table.name.is_empty() {
        let _ = write!(out, "{}", table.name);
        let _ = writeln!(out, "{}", table.schema.as_ref().map_or(String::new(), |schema| format!(" ({schema})")));
    }
    let _ = write!(out, "  {} {}", table.rows, if table.rows == 1 { "sample" } else { "samples" });
    let time = table.time();
    if let Some((column, clock)) = time.and_then(|column| Some((column, column.clock.as_ref()?))) {
        // A clock that began anew ends before it begins: a finding tells how.
        let forward = clock.span.filter(|(first, last)| last >= first);
        let span = forward.map_or(String::new(), |(a, b)| format!(" over {}", table::seconds(b - a)));
        let rate = clock.rate_hz.map_or(String::new(), |rate| format!(", {}", table::hertz(rate)));
        let _ = write!(out, "{span}{rate} by {}", column.name);
    }
    out += "\n";
    let mut rows = table::plain(&["  column", "unit", "min", "max", "holes"], &[2, 3, 4]);
    for column in table.columns.iter().take(COLUMNS_SHOWN) {
        rows.add_row(column_row(column, table.rows));
    }
    table::fit(&mut rows);
    out += &rows.trim_fmt();
    out += "\n";
    if table.columns.len() > COLUMNS_SHOWN {
        let _ = writeln!(out, "  … and {} more columns", table.columns.len() - COLUMNS_SHOWN);
    }
    out
}

fn column_row(column: &Column, rows: usize) -> Vec<String> {
    let number = |value: Option<f64>| value.map_or("–".to_owned(), table::number);
    let Column { name, unit, summary, .. } = column;
    let holes = match (summary.samples, rows) {
        (_, 0) => "–".to_owned(),
        (0, _) => "text".to_owned(),
        _ => summary.holes.to_string(),
    };
    vec![
        format!("  {}", table::cut(name)),
        unit.clone().unwrap_or_else(|| "–".to_owned()),
        number(summary.range.map(|(min, _)| min)),
        number(summary.range.map(|(_, max)| max)),
        holes,
    ]
}
