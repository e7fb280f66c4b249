//! `pneuval init`: look at the logs in a folder, and write a first description of them.

use std::fs::{self, OpenOptions};
use std::io::{ErrorKind, Write as _};
use std::path::{Path, PathBuf};

use serde::Serialize;

use pneuval_ingest::draft::{self, Draft};
use pneuval_ingest::formats::{self, Format, Options};
use pneuval_ingest::raw::RawFile;
use pneuval_ingest::recording::{Keep, Recording};
use pneuval_ingest::{IngestError, limits, manifest};

use crate::cli::Init;
use crate::exit::{Failure, Outcome};
use crate::output;

/// A log and its file name.
type Named = (String, Recording);

/// Endings of files that may be logs.
const ENDINGS: [&str; 9] = ["csv", "tsv", "txt", "log", "dat", "lvm", "tdms", "mcap", "mha"];

/// What was done, for the terminal and `--json`.
#[derive(Serialize)]
struct Told {
    written: Vec<String>,
    kept: Vec<String>,
    logs: Vec<String>,
    left_out: Vec<String>,
    guesses: Vec<String>,
}

pub fn run(arguments: &Init) -> Result<Outcome, Failure> {
    let folder = &arguments.folder;
    let session = folder.join("session.toml");
    // A link that leads nowhere is there too.
    if fs::symlink_metadata(&session).is_ok() {
        return Err(Failure::Flag {
            flag: "FOLDER",
            found: format!("{}, which is there already", session.display()),
            expected: "a folder without session.toml".to_owned(),
            next: "edit it, or move it away to have it written anew".to_owned(),
        });
    }
    if let Some(id) = arguments.actuator.as_ref().filter(|id| !manifest::is_id(id)) {
        return Err(Failure::Flag {
            flag: "--actuator",
            found: format!("`{id}`"),
            expected: "an id of lower-case letters, digits, `-` and `.`".to_owned(),
            next: "rename it".to_owned(),
        });
    }
    let (logs, mut left_out) = logs(folder)?;
    let (chosen, others) = of_one_layout(logs);
    left_out.extend(others.iter().map(|name| {
        format!("{name}: laid out differently, so a [[device]] of this session, or a session of a folder of its own")
    }));
    let actuator = arguments.actuator.as_deref();
    // One that nobody describes yet gets a draft; one that is malformed is told by `validate`.
    let described = actuator.and_then(|id| pneuval_datasets::find_actuator(id, folder).ok());
    let chambers: Vec<&String> = described.iter().flat_map(|actuator| actuator.chambers.keys()).collect();
    let chamber = if let [only] = chambers[..] { Some(only.as_str()) } else { None };
    let drafted = draft::draft(&id_of(folder)?, &chosen, actuator, chamber);
    let Some(mut drafted) = drafted else {
        return Err(Failure::Flag {
            flag: "FOLDER",
            found: format!("{} with no log of two columns of numbers beside the time", folder.display()),
            expected: format!("logs ending in {}", ENDINGS.join(", ")),
            next: left_out.first().cloned().unwrap_or_else(|| "name the folder that holds the logs".to_owned()),
        });
    };
    let (written, kept) = write(folder, &drafted)?;
    if kept.iter().any(|name| name == "rig.toml") {
        drafted.guesses.push(
            "rig.toml is yours: let `rig` of session.toml be its id, and `instrument` name its instruments".to_owned(),
        );
    }
    let told = Told {
        written,
        kept,
        logs: chosen.into_iter().map(|(name, _)| name).collect(),
        left_out,
        guesses: drafted.guesses,
    };
    if arguments.json {
        output::print_json(&told)?;
    } else {
        output::print(&text(&told, arguments))?;
    }
    Ok(Outcome::Expected)
}

/// The logs of a folder in the order of their names, and what could not be read.
fn logs(folder: &Path) -> Result<(Vec<Named>, Vec<String>), Failure> {
    let failed = |source| IngestError::read(folder, source);
    let mut paths: Vec<PathBuf> = Vec::new();
    for entry in fs::read_dir(folder).map_err(failed)? {
        let path = entry.map_err(failed)?.path();
        let ending = path.extension().map(|e| e.to_string_lossy().to_lowercase()).unwrap_or_default();
        if ENDINGS.contains(&ending.as_str()) && path.is_file() || is_bag(&path) {
            paths.push(path);
        }
    }
    paths.sort();
    let (mut logs, mut left_out) = (Vec::new(), Vec::new());
    for path in paths {
        let Some(name) = path.file_name().and_then(|name| name.to_str()).map(str::to_owned) else {
            left_out
                .push(format!("{}: its name is not UTF-8, and no manifest could name it; rename it", path.display()));
            continue;
        };
        match recording(&path, &name) {
            Ok(log) => logs.push((name, log)),
            Err(error) => left_out.push(error.to_string().lines().map(str::trim).collect::<Vec<_>>().join("; ")),
        }
    }
    Ok((logs, left_out))
}

/// Whether a folder is a bag of ROS 2.
fn is_bag(folder: &Path) -> bool {
    folder.join("metadata.yaml").is_file()
}

/// A log, looked at: of text every cell, which may name runs; of bags and streams, which may be large, the summaries.
fn recording(path: &Path, name: &str) -> Result<Recording, IngestError> {
    let raw = RawFile::open(path, name, limits::LOG_BYTES_MAX)?;
    let options = Options::default();
    let is_large = matches!(formats::detect(&raw)?, Format::Mcap | Format::Tdms);
    let keep = if is_large { Keep::Nothing } else { Keep::All };
    formats::read(&raw, &options, keep)
}

/// The largest group of logs that share a layout, and the names of the others. Of equal groups the one with more rows: a log
/// beside the table of a model; then the first.
fn of_one_layout(logs: Vec<Named>) -> (Vec<Named>, Vec<String>) {
    let columns = |log: &Recording| -> Vec<(String, Option<String>, bool)> {
        let all = log.tables.iter().flat_map(|table| table.columns.iter().map(move |column| (table, column)));
        all.map(|(t, c)| (t.full_name(&c.name), c.unit.clone(), c.summary.samples > 0)).collect()
    };
    let rows = |log: &Recording| log.tables.iter().map(|table| table.rows).sum::<usize>();
    let alike = |a: &Recording, b: &Recording| columns(a) == columns(b);
    let size = |i: usize| {
        let group = logs.iter().filter(|(_, log)| alike(log, &logs[i].1));
        group.fold((0_usize, 0_usize), |(files, total), (_, log)| (files + 1, total + rows(log)))
    };
    // The first of equal size: max_by_key takes the last.
    let Some(best) = (0..logs.len()).rev().max_by_key(|&i| size(i)) else { return (vec![], vec![]) };
    let layout = columns(&logs[best].1);
    let (chosen, others): (Vec<_>, Vec<_>) = logs.into_iter().partition(|(_, log)| columns(log) == layout);
    (chosen, others.into_iter().map(|(name, _)| name).collect())
}

/// An id from the folder's name.
fn id_of(folder: &Path) -> Result<String, Failure> {
    let real = folder.canonicalize().map_err(|source| IngestError::read(folder, source))?;
    let name = real.file_name().map(|name| name.to_string_lossy().to_lowercase()).unwrap_or_default();
    let id: String = name.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '-' }).collect();
    let id = id.trim_matches('-').to_owned();
    Ok(if manifest::is_id(&id) { id } else { "session".to_owned() })
}

/// Writes what is not there yet: the files written, and those that were left as they are.
fn write(folder: &Path, drafted: &Draft) -> Result<(Vec<String>, Vec<String>), Failure> {
    let (mut written, mut kept) = (Vec::new(), Vec::new());
    let files = [
        ("session.toml", &drafted.session),
        ("actuator.toml", &drafted.actuator),
        ("rig.toml", &drafted.rig),
        ("bounds.toml", &drafted.bounds),
    ];
    for (name, text) in files {
        let path = folder.join(name);
        // Created anew or not at all: through a link it would be written outside the folder.
        match OpenOptions::new().write(true).create_new(true).open(&path) {
            Err(error) if error.kind() == ErrorKind::AlreadyExists => kept.push(name.to_owned()),
            opened => {
                opened
                    .and_then(|mut file| file.write_all(text.as_bytes()))
                    .map_err(|source| IngestError::write(&path, source))?;
                written.push(name.to_owned());
            }
        }
    }
    Ok((written, kept))
}

fn text(told: &Told, arguments: &Init) -> String {
    let mut lines = vec![format!("Read:    {}", told.logs.join(", "))];
    lines.extend(told.left_out.iter().map(|text| format!("Not used: {text}")));
    lines.push(format!("Written: {}", told.written.join(", ")));
    if !told.kept.is_empty() {
        lines.push(format!("Kept:    {}", told.kept.join(", ")));
    }
    lines.extend(told.guesses.iter().map(|guess| format!("Guess:   {guess}")));
    let folder = arguments.folder.display();
    let first =
        if arguments.actuator.is_some() { "check the guesses" } else { "fill in `actuator` and check the guesses" };
    lines.push(format!("Next:    {first} in {folder}/session.toml, then `pneuval validate {folder}`"));
    lines.join("\n") + "\n"
}
