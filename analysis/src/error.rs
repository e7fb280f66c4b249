//! Errors of this crate.

use std::path::PathBuf;

use thiserror::Error;

use pneuval_ingest::IngestError;
use pneuval_models::ModelError;

/// Errors of analysis.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum AnalysisError {
    /// A file is not what it should be.
    #[error(transparent)]
    Ingest(#[from] IngestError),
    /// A comparison names a form that neither the table, the actuator file nor the catalogue has.
    #[error(
        "{file}:{line}: key `form`\n  expected: a printed column, an imported model or a catalogue form of `{quantity}`\n  found:    `{form}`\n  next:     {next}"
    )]
    UnknownForm {
        /// The dataset.
        file: String,
        /// Its line.
        line: usize,
        /// The quantity compared.
        quantity: String,
        /// The form named.
        form: String,
        /// What to do.
        next: String,
    },
    /// A fit names a parameter that the form does not have.
    #[error("{file}:{line}: key `fit`\n  expected: parameters of `{form}`\n  found:    `{name}`\n  next:     {next}")]
    UnknownParameter {
        /// The dataset.
        file: String,
        /// Its line.
        line: usize,
        /// The form.
        form: String,
        /// The parameter named.
        name: String,
        /// What to do.
        next: String,
    },
    /// The actuator file lacks an input of a model, or holds it in another unit.
    #[error("{file}: key `{name}`\n  expected: {expected}\n  found:    {found}\n  next:     correct the actuator file")]
    Input {
        /// The actuator file.
        file: String,
        /// The value's name.
        name: String,
        /// What the model needs.
        expected: String,
        /// What is there.
        found: String,
    },
    /// A form does not predict what is measured: another unit, other chambers, components or conditions.
    #[error(
        "{file}:{line}: key `form`, `{form}` of `{quantity}`\n  expected: {expected}\n  found:    {found}\n  next:     declare the measurement as the model has it, or compare another form"
    )]
    Mismatch {
        /// The dataset.
        file: String,
        /// Its line.
        line: usize,
        /// The quantity.
        quantity: String,
        /// The form.
        form: String,
        /// What the model has.
        expected: String,
        /// What was measured.
        found: String,
    },
    /// A dataset states a metric that there is none of.
    #[error("{file}:{line}: key `metrics`\n  expected: a metric\n  found:    `{name}`\n  next:     {next}")]
    UnknownMetric {
        /// The dataset.
        file: String,
        /// Its line.
        line: usize,
        /// The metric named.
        name: String,
        /// What to do.
        next: String,
    },
    /// A material names a law that there is none of.
    #[error("{file}:{line}: key `law`\n  expected: a hyperelastic law\n  found:    `{law}`\n  next:     {next}")]
    UnknownLaw {
        /// The actuator file.
        file: String,
        /// Its line.
        line: usize,
        /// The law named.
        law: String,
        /// What to do.
        next: String,
    },
    /// A law refuses a material's constants.
    #[error(
        "{file}:{line}: key `law`\n  expected: the constants of `{law}`\n  found:    {source}\n  next:     correct the material's constants; `pneuval materials {law}` lists them"
    )]
    Law {
        /// The actuator file.
        file: String,
        /// Its line.
        line: usize,
        /// The law.
        law: String,
        /// What it says.
        source: ModelError,
    },
    /// A response of a session has too many points to be a set of steady states.
    #[error(
        "{file}:{line}: the response `{quantity}`\n  expected: at most {limit} points\n  found:    {points}\n  next:     {next}"
    )]
    TooManyPoints {
        /// The session.
        file: String,
        /// Its line.
        line: usize,
        /// The quantity.
        quantity: String,
        /// How many.
        points: usize,
        /// How many there may be.
        limit: usize,
        /// What to do.
        next: &'static str,
    },
    /// Two datasets bring different files of one actuator.
    #[error(
        "{file}: key `id`\n  expected: one file per actuator in a run\n  found:    `{id}`, which {other} describes differently\n  next:     give it another id, or validate the datasets one by one"
    )]
    ActuatorConflict {
        /// The actuator.
        id: String,
        /// The second file.
        file: String,
        /// The first.
        other: String,
    },
    /// A model refuses its inputs.
    #[error("{file}: the form `{form}` of `{quantity}` refuses its inputs: {source}")]
    Model {
        /// The actuator file.
        file: String,
        /// The quantity.
        quantity: String,
        /// The form.
        form: String,
        /// What the model says.
        source: ModelError,
    },
    /// A calibration did not succeed.
    #[error(
        "{file}:{line}: the fit of `{form}` failed: {source}\n  next:     fit fewer parameters, others, or to other values"
    )]
    Fit {
        /// The dataset.
        file: String,
        /// Its line.
        line: usize,
        /// The form fitted.
        form: String,
        /// What least squares says.
        source: ModelError,
    },
    /// Holding points out of a fit leaves nothing to fit, or nothing to judge.
    #[error(
        "{file}:{line}: key `hold_out`\n  expected: pressures to fit and pressures to judge `{form}` on: two or more beside zero, at most {limit}\n  found:    not that\n  next:     measure at more pressures, or fit without `hold_out`"
    )]
    HoldOut {
        /// The dataset.
        file: String,
        /// Its line.
        line: usize,
        /// The form fitted.
        form: String,
        /// The largest number of pressures.
        limit: usize,
    },
    /// A remark's placeholder cannot be filled in.
    #[error(
        "{file}:{line}: key `remark`\n  expected: placeholders predicted[i], measured[i], printed.<column>[i], fit.<parameter>, inputs.<name>\n  found:    {message}\n  next:     correct the placeholder"
    )]
    Remark {
        /// The dataset.
        file: String,
        /// Its line.
        line: usize,
        /// What the template engine says.
        message: String,
    },
    /// A stored results folder cannot be used.
    #[error("{}: {problem}\n  next:     {next}", path.display())]
    Results {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        problem: String,
        /// What to do.
        next: String,
    },
    /// The output folder holds something that this program did not write.
    #[error("{}: not written over\n  expected: no folder, an empty one, or an earlier {kind}\n  found:    {found}\n  next:     choose another --out, or move it away", path.display())]
    Foreign {
        /// The folder.
        path: PathBuf,
        /// What was to be written: a report, an export.
        kind: &'static str,
        /// What is in it.
        found: String,
    },
    /// Nothing of the data fits into the format that was asked for.
    #[error(
        "--format {format}: nothing to write\n  expected: a session with a clock\n  found:    {found}\n  next:     add --format csv or --format parquet"
    )]
    NothingExported {
        /// The format.
        format: &'static str,
        /// What there is, and why it is left out.
        found: String,
    },
    /// A figure could not be drawn.
    #[error("figure {figure}: {message}")]
    Figure {
        /// The figure.
        figure: String,
        /// What the plotting library says.
        message: String,
    },
    /// A page could not be filled in.
    #[error("page {page}: {message}")]
    Page {
        /// The page.
        page: String,
        /// What the template engine says.
        message: String,
    },
}
