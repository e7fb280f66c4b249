//! `pneuval rehearse`: a raw session with known truth, and on demand with known faults.

use std::fs;
use std::path::{Path, PathBuf};

use serde::Serialize;

use pneuval_datasets::rehearse::plan::{ProgrammeKind, Truth};
use pneuval_datasets::rehearse::{Asked, Bag, FAULTS, Rehearsal, Request, Written};
use pneuval_ingest::IngestError;
use pneuval_ingest::error::suggestion;
use pneuval_ingest::formats::{Format, mcap};

use crate::cli::{BagCompression, BagEncoding, Clocks, Rehearse, RehearsedFormat, Shape};
use crate::exit::{Failure, Outcome};
use crate::{output, table};

/// What was written, for `--json`.
#[derive(Serialize)]
struct Told {
    folder: PathBuf,
    seed: u64,
    files: usize,
    bytes: usize,
    sessions: Vec<Written>,
    /// The pressure moves all the time.
    is_moving: bool,
}

pub fn run(arguments: &Rehearse) -> Result<Outcome, Failure> {
    if arguments.faults {
        output::print(&listing())?;
        return Ok(Outcome::Expected);
    }
    let Some(plan) = &arguments.actuator else {
        return Err(Failure::Flag {
            flag: "ACTUATOR",
            found: "nothing".to_owned(),
            expected: "the id of a rehearsal, or a plan of your own".to_owned(),
            next: suggestion("", pneuval_datasets::rehearsals()),
        });
    };
    let plan = &if arguments.photographs { format!("{plan}-photographs") } else { plan.clone() };
    if arguments.plan {
        output::print(&pneuval_datasets::rehearse::plan_text(plan, Path::new("."))?)?;
        return Ok(Outcome::Expected);
    }
    let request = request(arguments)?;
    let rehearsal = Rehearsal::find(plan, Path::new("."), request)?;
    let folder = arguments.out.clone().unwrap_or_else(|| PathBuf::from(format!("rehearsed-{}", rehearsal.id())));
    let told = write(&rehearsal, &folder, arguments.seed)?;
    if arguments.json {
        output::print_json(&told)?;
    } else {
        output::print(&text(&told))?;
    }
    Ok(Outcome::Expected)
}

/// Every fault, with what it does.
fn listing() -> String {
    let mut rows = table::plain(&["fault", "what happens"], &[]);
    for (name, _, what) in FAULTS {
        rows.add_row([name, what]);
    }
    table::fit(&mut rows);
    format!("{}\n", rows.trim_fmt())
}

fn request(arguments: &Rehearse) -> Result<Request, Failure> {
    Ok(Request {
        seed: arguments.seed,
        repeats: usize::from(arguments.repeats),
        specimens: usize::from(arguments.specimens),
        ideal: arguments.ideal,
        format: arguments.format.map(|format| match format {
            RehearsedFormat::Csv => Format::Csv,
            RehearsedFormat::Serial => Format::Serial,
            RehearsedFormat::Lvm => Format::Lvm,
            RehearsedFormat::Tdms => Format::Tdms,
            RehearsedFormat::Mcap => Format::Mcap,
        }),
        bag: Bag {
            encoding: match arguments.encoding {
                BagEncoding::Cdr => mcap::Encoding::Cdr,
                BagEncoding::Json => mcap::Encoding::Json,
                BagEncoding::Protobuf => mcap::Encoding::Protobuf,
            },
            compression: match arguments.compression {
                BagCompression::Zstd => mcap::Compression::Zstd,
                BagCompression::Lz4 => mcap::Compression::Lz4,
                BagCompression::None => mcap::Compression::None,
            },
        },
        own_clocks: arguments.clocks == Clocks::Own,
        programme: arguments.programme.map(|shape| match shape {
            Shape::Steps => ProgrammeKind::Steps,
            Shape::Ramp => ProgrammeKind::Ramp,
            Shape::Sine => ProgrammeKind::Sine,
            Shape::Cycles => ProgrammeKind::Cycles,
        }),
        sitting: arguments.sitting.clone(),
        truths: arguments.truth.iter().map(|text| truth(text)).collect::<Result<_, _>>()?,
        faults: arguments.fault.iter().map(|text| fault(text)).collect::<Result<_, _>>()?,
    })
}

/// `bending-angle = linear`: `published`, a table `*.csv`, or a form.
fn truth(text: &str) -> Result<(String, Truth), Failure> {
    let Some((quantity, what)) = text.split_once('=') else {
        return Err(Failure::Flag {
            flag: "--truth",
            found: format!("`{text}`"),
            expected: "QUANTITY = published, QUANTITY = FORM or QUANTITY = FILE.csv".to_owned(),
            next: "write `bending-angle = linear` for instance".to_owned(),
        });
    };
    let what = what.trim();
    let is_table = Path::new(what).extension().is_some_and(|ending| ending.eq_ignore_ascii_case("csv"));
    let truth = match what {
        "published" => Truth::Published,
        _ if is_table => Truth::File(what.to_owned()),
        form => Truth::Form(form.to_owned()),
    };
    Ok((quantity.trim().to_owned(), truth))
}

fn fault(text: &str) -> Result<Asked, Failure> {
    text.parse().map_err(|next| Failure::Flag {
        flag: "--fault",
        found: format!("`{text}`"),
        expected: "NAME, NAME@CHANNEL or NAME@CHANNEL:RUN; `pneuval rehearse --faults` lists the names".to_owned(),
        next,
    })
}

/// Writes everything to a temporary folder and moves it into place: all of it or nothing.
fn write(rehearsal: &Rehearsal, folder: &Path, seed: u64) -> Result<Told, Failure> {
    // A link is followed, also one to a folder that is not there yet.
    let is_link = fs::symlink_metadata(folder).is_ok_and(|metadata| metadata.is_symlink());
    let is_there = folder.exists();
    let is_free = if is_there { fs::read_dir(folder).is_ok_and(|mut e| e.next().is_none()) } else { !is_link };
    if !is_free {
        return Err(Failure::Flag {
            flag: "--out",
            found: format!("{}, which holds something already, or is no folder", folder.display()),
            expected: "a new folder, or an empty one".to_owned(),
            next: "name another, or move it away".to_owned(),
        });
    }
    let failed = |path: &Path, source| IngestError::write(path, source);
    // An empty folder is filled; a new one is moved into place. Whatever fails before leaves nothing.
    let parent = if is_there {
        folder
    } else {
        // The nearest folder that is there.
        let mut above = folder.ancestors().skip(1).filter(|above| above.is_dir());
        above.next().unwrap_or(Path::new("."))
    };
    let staging = tempfile::Builder::new().prefix(".pneuval-").tempdir_in(parent).map_err(|s| failed(parent, s))?;
    let new = staging.path().join("new");
    fs::create_dir(&new).map_err(|source| failed(&new, source))?;
    let (mut files, mut bytes) = (0, 0);
    let written = rehearsal.write(&mut |name, content| {
        let path = new.join(name);
        if let Some(parent) = path.parent().filter(|parent| !parent.is_dir()) {
            fs::create_dir_all(parent).map_err(|source| failed(parent, source))?;
        }
        files += 1;
        bytes += content.len();
        fs::write(&path, content).map_err(|source| failed(&path, source))
    })?;
    if is_there {
        for entry in fs::read_dir(&new).map_err(|source| failed(&new, source))? {
            let entry = entry.map_err(|source| failed(&new, source))?;
            let to = folder.join(entry.file_name());
            fs::rename(entry.path(), &to).map_err(|source| failed(&to, source))?;
        }
    } else {
        if let Some(above) = folder.parent().filter(|above| !above.as_os_str().is_empty()) {
            fs::create_dir_all(above).map_err(|source| failed(above, source))?;
        }
        fs::rename(&new, folder).map_err(|source| failed(folder, source))?;
    }
    Ok(Told { folder: folder.to_owned(), seed, files, bytes, sessions: written, is_moving: rehearsal.is_moving() })
}

fn text(told: &Told) -> String {
    /// Sessions that a person reads through.
    const SHOWN: usize = 20;
    let mut rows = table::plain(&["session", "folder", "runs", "of", "samples"], &[2, 3, 4]);
    for session in told.sessions.iter().take(SHOWN) {
        let folder = if session.folder.is_empty() { "." } else { &session.folder };
        rows.add_row([
            session.id.clone(),
            folder.to_owned(),
            session.runs.to_string(),
            format!("{:.1} s", session.run_s),
            session.samples.to_string(),
        ]);
    }
    table::fit(&mut rows);
    let folder = told.folder.display();
    let mut lines = vec![rows.trim_fmt()];
    if told.sessions.len() > SHOWN {
        lines.push(format!("… and {} more", told.sessions.len() - SHOWN));
    }
    for fault in told.sessions.iter().flat_map(|session| &session.faults) {
        let what = if fault.expected.is_empty() {
            "nothing in the file shows it".to_owned()
        } else {
            format!("should be found as {}", fault.expected.join(" or "))
        };
        let (first, last) = fault.samples;
        lines.push(format!("Fault: {} in {}, samples {first} to {last}; {what}", fault.fault, fault.file));
    }
    let mebibytes = told.bytes as f64 / f64::from(1 << 20);
    lines.push(format!(
        "\nSYNTHETIC, seed {}: {} files, {mebibytes:.1} MiB in {folder}; truth.json says what really happened",
        told.seed, told.files
    ));
    // A pressure that never stands has no plateaus, and one clock's samples have no partners on another.
    let next = if told.is_moving { "ingest" } else { "validate" };
    lines.push(format!("Next: pneuval {next} {folder}"));
    lines.join("\n") + "\n"
}
