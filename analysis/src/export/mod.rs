//! Measured and predicted values side by side, as files for other programs.
//!
//! ```text
//! OUT/pneuval_export.json           what was written: columns, units, where each comes from, digests
//! OUT/<session>/<run>.mcap          a run: a topic for each clock
//! OUT/<session>/<run>[.<stream>].csv|parquet    a run: a table for each clock
//! OUT/<session>/points.csv|parquet  the points that are compared
//! OUT/<dataset>/<quantity>.csv|parquet          a printed table
//! ```
//!
//! Numbers are in the units in which they are shown, the same in every format; a hole stays a hole. Predictions stand at the moments of
//! the pressures that they are made from.
//!
//! | file | holds |
//! |---|---|
//! | `table.rs` | a table, its columns and their names |
//! | `samples.rs` | a run: channels, and what every comparison predicts at each sample |
//! | `points.rs` | the points of responses |
//! | `bag.rs` | a run as topics |
//! | `record.rs` | what was written |

mod bag;
mod points;
mod record;
mod samples;
mod table;

use std::borrow::Cow;
use std::collections::{BTreeMap, BTreeSet};
use std::fs::{self, File};
use std::io::{BufWriter, Write as _};
use std::path::{Path, PathBuf};

use pneuval_ingest::IngestError;
use pneuval_ingest::formats::csv::{self, Decimal};
use pneuval_ingest::manifest::ComparisonSpec;
use pneuval_ingest::raw::RawFile;
use pneuval_ingest::session::Session;
use pneuval_ingest::store::{file_name, write_cells};

pub use record::{ColumnRecord, DataRecord, ExportRecord, FileRecord, LeftOut, TableRecord};
pub use table::Origin;

use crate::AnalysisError;
use crate::compare::{Posed, Sides, side_by_side};
use crate::place::{self, Kind};
use crate::records;
use crate::response::Response;
use crate::results::{FitRecord, MovementAlignmentRecord};
use crate::study::{Data, NO_FORM, Study};
use bag::Bag;
use samples::Samples;
use table::Table;

/// What stands in every file of a session that a program wrote.
pub const SYNTHETIC: &str = "SYNTHETIC: written by a program, not by an instrument";

/// How tables are written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Format {
    /// Messages of ROS 2 with their stamps: what Foxglove and PlotJuggler draw over time.
    Mcap,
    /// A row of names, a row of units, decimal points; an empty cell is a hole.
    Csv,
    /// With units among the file's metadata; null is a hole.
    Parquet,
}

impl Format {
    /// Its word on the command line, and the extension of its files.
    pub fn id(self) -> &'static str {
        match self {
            Self::Mcap => "mcap",
            Self::Csv => "csv",
            Self::Parquet => "parquet",
        }
    }
}

/// What an export holds, by its record.
const EXPORT: Kind = Kind { name: "export", record: record::NAME, files: record::files_of };

/// Writes sessions and published datasets to a folder, which appears whole or not at all; an earlier export there is replaced.
///
/// A form that cannot be calibrated on the data is left out and listed, and so is what a format cannot hold.
///
/// # Errors
/// [`AnalysisError::Foreign`] if `out` holds anything but an earlier export; [`AnalysisError::NothingExported`] if nothing of the data
/// fits into the format; [`AnalysisError`] for a comparison that cannot be posed, as in [`crate::compare::validate`]; what the system
/// says.
pub fn publish(out: &Path, studies: &[Study], format: Format) -> Result<ExportRecord, AnalysisError> {
    place::publish(out, &EXPORT, |new| {
        fs::create_dir_all(new).map_err(|source| IngestError::write(new, source))?;
        let mut data = Vec::with_capacity(studies.len());
        for study in studies {
            data.push(Export::of(study, format)?.write(new)?);
        }
        let record = ExportRecord::new(format.id(), data);
        if record.data.iter().all(|data| data.files.is_empty()) {
            let mut reasons: BTreeMap<&str, Vec<&str>> = BTreeMap::new();
            for left in record.data.iter().flat_map(|data| &data.left_out) {
                reasons.entry(&left.why).or_default().push(&left.what);
            }
            let found: Vec<String> = reasons.iter().map(|(why, what)| format!("{}: {why}", what.join(", "))).collect();
            return Err(AnalysisError::NothingExported { format: format.id(), found: found.join("; ") });
        }
        let path = new.join(record::NAME);
        let text = record.to_json().map_err(|source| IngestError::write(&path, source.into()))?;
        fs::write(&path, text).map_err(|source| IngestError::write(&path, source))?;
        Ok(record)
    })
}

/// A comparison that is posed, and the response that it is about.
struct Compared<'a> {
    /// Index among the responses of the study.
    response: usize,
    spec: &'a ComparisonSpec,
    posed: Posed<'a>,
    /// The response with the points that are compared: of a movement, those at which this form meets it.
    points: Cow<'a, Response>,
    alignment: Option<MovementAlignmentRecord>,
}

impl Compared<'_> {
    /// Its name in legends.
    fn title(&self) -> &str {
        self.spec.title.as_deref().unwrap_or(&self.posed.prediction.title)
    }

    /// What it was fitted to and rests on: a calibrated form is no validation.
    fn note(&self) -> Option<String> {
        let fitted = self.posed.fit.as_ref().map(|fit: &FitRecord| {
            let parameters: Vec<&str> = fit.parameters.iter().map(|p| p.name.as_str()).collect();
            let hold_out = fit.hold_out.as_ref().map_or(String::new(), |words| format!(" ({words})"));
            format!("{} fitted to {}{hold_out}", parameters.join(", "), fit.fitted_on.join(", "))
        });
        let rests_on = &self.posed.prediction.rests_on;
        let rests_on = (!rests_on.is_empty()).then(|| format!("rests on {}", rests_on.join(", ")));
        let unit = self.points.quantity.unit;
        let aligned = self.alignment.as_ref().map(|alignment| alignment.text(unit));
        let words: Vec<String> = fitted.into_iter().chain(rests_on).chain(aligned).collect();
        (!words.is_empty()).then(|| words.join("; "))
    }
}

/// A dataset or session on its way into files.
struct Export<'a> {
    study: &'a Study<'a>,
    format: Format,
    compared: Vec<Compared<'a>>,
    left_out: Vec<LeftOut>,
    files: Vec<FileRecord>,
    names: BTreeSet<String>,
}

impl<'a> Export<'a> {
    /// Poses every comparison. What the data themselves refuse is left out; what is wrong in a file of the user's is an error.
    fn of(study: &'a Study<'a>, format: Format) -> Result<Self, AnalysisError> {
        let (mut compared, mut left_out) = (Vec::new(), Vec::new());
        for spec in study.comparisons.iter().filter(|spec| spec.form != NO_FORM) {
            let Some(response) = study.responses.iter().position(|r| r.quantity.id == spec.quantity) else { continue };
            let refused = match side_by_side(study, spec, &study.responses[response]) {
                Ok(Sides { posed: Posed { refused: Some(error), .. }, .. })
                | Err(
                    error @ (AnalysisError::Fit { .. } | AnalysisError::HoldOut { .. } | AnalysisError::Model { .. }),
                ) => error,
                Ok(mut sides) => {
                    let alignment = sides.align(spec.align, None);
                    let Sides { response: points, posed, .. } = sides;
                    compared.push(Compared { response, spec, posed, points, alignment });
                    continue;
                }
                Err(error) => return Err(error),
            };
            let words: Vec<String> = refused.to_string().lines().map(|line| line.trim().to_owned()).collect();
            left_out.push(LeftOut::new(form_of(spec), words.join("; ")));
        }
        Ok(Self { study, format, compared, left_out, files: Vec::new(), names: BTreeSet::new() })
    }

    /// Writes its files into a folder of its own.
    fn write(mut self, root: &Path) -> Result<DataRecord, AnalysisError> {
        match &self.study.input.data {
            Data::Session(session) => self.session(session, root)?,
            Data::Published(_) if self.format == Format::Mcap => {
                let why = "printed tables have no time, which MCAP needs; --format csv and --format parquet hold them";
                self.left_out.push(LeftOut::new(self.study.id.to_owned(), why.to_owned()));
            }
            Data::Published(_) => {
                for response in 0..self.study.responses.len() {
                    let table = points::of_print(&self, response);
                    let name = self.study.responses[response].quantity.id.clone();
                    self.table(root, &name, "", &table, None)?;
                }
            }
        }
        let dataset = records::dataset(self.study);
        Ok(DataRecord {
            id: self.study.id.to_owned(),
            kind: if dataset.session.is_some() { "session" } else { "published" },
            title: dataset.title,
            actuator: self.study.input.actuator.id.clone(),
            synthetic: dataset.session.as_ref().is_some_and(|session| session.synthetic),
            too_many_excluded: dataset.session.is_some_and(|s| s.excluded_share() > s.excluded_share_max),
            sources: dataset.sources,
            files: self.files,
            left_out: self.left_out,
        })
    }

    fn session(&mut self, session: &Session, root: &Path) -> Result<(), AnalysisError> {
        // The table of points keeps its name, whatever runs are called.
        let has_points = !self.study.responses.is_empty();
        if has_points && self.format != Format::Mcap {
            let table = points::of_session(self);
            self.table(root, "points", "", &table, None)?;
        } else if has_points {
            let why = "a point is no moment, and MCAP holds moments; --format csv and --format parquet hold points";
            self.left_out.push(LeftOut::new(format!("points of {}", self.study.id), why.to_owned()));
        }
        let mut topics = BTreeSet::new();
        for aligned in &self.study.alignment.runs {
            let run = aligned.run;
            let (samples, told) = samples::of_run(self, session, aligned);
            for left in told {
                self.leave_out(left);
            }
            if self.format == Format::Mcap {
                self.bag(root, &run.id, samples, &mut topics)?;
            } else {
                for Samples { stream, origin, table, .. } in &samples {
                    self.table(root, &run.id, stream, table, Some((run.id.as_str(), origin.as_deref())))?;
                }
            }
        }
        Ok(())
    }

    /// What is left out of every run is told once.
    fn leave_out(&mut self, left: LeftOut) {
        if !self.left_out.contains(&left) {
            self.left_out.push(left);
        }
    }

    /// Writes a table as a file of its own; `run` is its run and the origin of its stamps.
    fn table(
        &mut self,
        root: &Path,
        name: &str,
        stream: &str,
        table: &Table,
        run: Option<(&str, Option<&str>)>,
    ) -> Result<(), AnalysisError> {
        let file = file_name(name, &[stream], self.format.id(), &mut self.names);
        let path = self.path(root, &file)?;
        let record = TableRecord {
            topic: None,
            stream: Some(stream.to_owned()).filter(|stream| !stream.is_empty()),
            rows: table.rows(),
            columns: table.columns.iter().map(ColumnRecord::of).collect(),
        };
        match self.format {
            Format::Parquet => {
                let columns: Vec<_> = table.columns.iter().map(|c| (c.name.as_str(), &c.cells)).collect();
                let mut words = self.words(run.map(|(run, _)| run));
                words.extend(record.columns.iter().map(|c| (format!("column.{}", c.name), c.to_json())));
                let words: Vec<_> = words.into_iter().map(|(key, value)| (format!("pneuval.{key}"), value)).collect();
                write_cells(&path, &columns, &words)?;
            }
            Format::Csv | Format::Mcap => write_text(&path, table, self.is_synthetic())?,
        }
        self.written(&path, &file, run.map(|(run, _)| run), vec![record])
    }

    /// Writes a run as a bag.
    fn bag(
        &mut self,
        root: &Path,
        run: &str,
        samples: Vec<Samples>,
        topics: &mut BTreeSet<String>,
    ) -> Result<(), AnalysisError> {
        let (clocked, states): (Vec<_>, Vec<_>) = samples.into_iter().partition(|samples| samples.has_clock);
        for Samples { stream, .. } in states {
            let of = if stream.is_empty() { String::new() } else { format!("{stream} of ") };
            let why =
                "it has no clock: its samples are states, not moments; --format csv and --format parquet hold them";
            self.left_out.push(LeftOut::new(format!("{of}run {run} of {}", self.study.id), why.to_owned()));
        }
        if clocked.is_empty() {
            return Ok(());
        }
        let file = file_name(run, &[], self.format.id(), &mut self.names);
        let path = self.path(root, &file)?;
        let bag = Bag::new(self.study.id, &file, clocked, self.is_synthetic(), topics);
        let mut words = self.words(Some(run));
        words.push(("time".to_owned(), bag.time.clone()));
        for left in bag.left_out(&format!("run {run} of {}", self.study.id)) {
            self.leave_out(left);
        }
        let records = bag.write(&path, words)?;
        self.written(&path, &file, Some(run), records)
    }

    fn is_synthetic(&self) -> bool {
        matches!(&self.study.input.data, Data::Session(session) if session.manifest.synthetic)
    }

    /// What a file says of itself.
    fn words(&self, run: Option<&str>) -> Vec<(String, String)> {
        let mut words = vec![
            ("program", record::PROGRAM.to_owned()),
            ("data", self.study.id.to_owned()),
            ("actuator", self.study.input.actuator.id.clone()),
            ("synthetic", self.is_synthetic().to_string()),
        ];
        words.extend(self.is_synthetic().then(|| ("warning", SYNTHETIC.to_owned())));
        words.extend(run.map(|run| ("run", run.to_owned())));
        words.into_iter().map(|(key, value)| (key.to_owned(), value)).collect()
    }

    fn path(&self, root: &Path, file: &str) -> Result<PathBuf, AnalysisError> {
        let folder = root.join(self.study.id);
        fs::create_dir_all(&folder).map_err(|source| IngestError::write(&folder, source))?;
        Ok(folder.join(file))
    }

    fn written(
        &mut self,
        path: &Path,
        file: &str,
        run: Option<&str>,
        tables: Vec<TableRecord>,
    ) -> Result<(), AnalysisError> {
        let raw = RawFile::open(path, file, u64::MAX)?;
        let (bytes, sha256) = (raw.len(), raw.sha256()?);
        let file = format!("{}/{file}", self.study.id);
        self.files.push(FileRecord { file, bytes, sha256, run: run.map(str::to_owned), tables });
        Ok(())
    }
}

/// What a comparison is called in lists.
fn form_of(spec: &ComparisonSpec) -> String {
    format!("{} of {}", spec.form, spec.quantity)
}

/// Writes a table as delimited text.
fn write_text(path: &Path, table: &Table, is_synthetic: bool) -> Result<(), IngestError> {
    let failed = |source| IngestError::write(path, source);
    let file = File::create(path).map_err(failed)?;
    let mut out = BufWriter::new(file);
    if is_synthetic {
        writeln!(out, "# {SYNTHETIC}").map_err(failed)?;
    }
    let heads: Vec<_> = table.columns.iter().map(|c| (c.name.as_str(), c.unit_symbol())).collect();
    let cells: Vec<_> = table.columns.iter().map(|c| &c.cells).collect();
    // A row of units that says nothing would be taken for a sample.
    let units = heads.iter().any(|(_, unit)| unit.is_some());
    let options = csv::WriteOptions { delimiter: b',', decimal: Decimal::Point, names: true, units, empty_holes: true };
    csv::lines(&heads, &cells, options, |line| out.write_all(line.as_bytes())).map_err(failed)?;
    let file = out.into_inner().map_err(|error| failed(error.into_error()))?;
    file.sync_all().map_err(failed)
}
