//! Flags and arguments.

use std::path::PathBuf;

use clap::{Args, Parser, Subcommand};

const EXIT_CODES: &str = "\
Exit codes:
  0  every verdict is as expected
  1  some verdict differs from the expected one
  2  what you wrote is wrong: a flag, a TOML file, a published table
  3  inconclusive, unjudged, or nothing but calibration
  4  what the instrument wrote cannot be used

Example:
  pneuval validate datasets --out report";

/// Model-vs-experiment validation of soft pneumatic actuators.
#[derive(Parser)]
#[command(name = "pneuval", version, arg_required_else_help = true, after_help = EXIT_CODES)]
pub struct Cli {
    #[command(subcommand)]
    pub command: Command,
}

#[derive(Subcommand)]
pub enum Command {
    /// Compare every prediction with its measurement, judge it, write a report
    Validate(Validate),
    /// Judge stored results again; the exit code is the verdict
    Gate(Gate),
    /// Draw the report again from stored numbers
    Report(Report),
    /// Print what the models predict over pressure
    Predict(Predict),
    /// List the model catalogue: equations, sources, misprints, check values
    Models(Models),
}

/// Compare every prediction with its measurement, judge it, write a report.
///
/// Reads the datasets below each PATH, or the embedded papers if none is given. Actuators and bounds are looked up in the
/// dataset's folder, its parents, then among the embedded ones.
#[derive(Args)]
#[command(
    after_help = "Examples:\n  pneuval validate                         the embedded papers\n  pneuval validate datasets --out report   a folder of datasets\n  pneuval validate mine --bounds lab.toml --json"
)]
pub struct Validate {
    /// Datasets, or folders of them
    pub paths: Vec<PathBuf>,
    /// Folder for the report; an earlier report there is replaced
    #[arg(long, value_name = "FOLDER", default_value = "report")]
    pub out: PathBuf,
    /// Bounds to judge by, instead of those found beside the data
    #[arg(long, value_name = "FILE")]
    pub bounds: Option<PathBuf>,
    /// Exit 0 whatever the verdicts; page one says so
    #[arg(long)]
    pub report_only: bool,
    /// Print results.json instead of the table
    #[arg(long)]
    pub json: bool,
}

/// Judge stored results again; the exit code is the verdict.
#[derive(Args)]
#[command(after_help = "Examples:\n  pneuval gate report\n  pneuval gate report --bounds stricter.toml")]
pub struct Gate {
    /// A report, its results folder, or results.json
    pub results: PathBuf,
    /// Bounds to judge by, instead of the stored ones
    #[arg(long, value_name = "FILE")]
    pub bounds: Option<PathBuf>,
    /// Print the judged results as JSON instead of the table
    #[arg(long)]
    pub json: bool,
}

/// Draw the report again from stored numbers; nothing is computed anew.
#[derive(Args)]
#[command(after_help = "Example:\n  pneuval report report --out again")]
pub struct Report {
    /// A report, its results folder, or results.json
    pub results: PathBuf,
    /// Folder for the report; by default the one that was read
    #[arg(long, value_name = "FOLDER")]
    pub out: Option<PathBuf>,
    /// Print results.json instead of the folder's name
    #[arg(long)]
    pub json: bool,
}

/// Print what the models predict over pressure.
#[derive(Args)]
#[command(
    after_help = "Examples:\n  pneuval predict internal-support\n  pneuval predict dual-chamber-finger --quantity tip-angle --form printed\n  pneuval predict dual-chamber-finger --quantity total-angle --at \"40 kPa, 50 kPa\""
)]
pub struct Predict {
    /// Actuator id: embedded, or of an actuator.toml here or above
    pub actuator: String,
    /// One quantity only
    #[arg(long)]
    pub quantity: Option<String>,
    /// One form only
    #[arg(long)]
    pub form: Option<String>,
    /// Gauge pressures with unit, one per chamber; may be repeated. Default: zero to full pressure
    #[arg(long, value_name = "PRESSURE", allow_hyphen_values = true)]
    pub at: Vec<String>,
    /// Steps from zero to full pressure
    #[arg(long, default_value_t = 10, value_parser = clap::value_parser!(u32).range(1..=100_000), conflicts_with = "at")]
    pub steps: u32,
    /// Print JSON, in SI units
    #[arg(long)]
    pub json: bool,
}

/// List the model catalogue: equations, sources, misprints, check values.
#[derive(Args)]
#[command(after_help = "Examples:\n  pneuval models\n  pneuval models internal-support --json")]
pub struct Models {
    /// One actuator type only
    pub actuator: Option<String>,
    /// Print JSON
    #[arg(long)]
    pub json: bool,
}
