//! Flags and arguments.

use std::path::PathBuf;

use clap::builder::TypedValueParser as _;
use clap::{Args, Parser, Subcommand, ValueEnum};

use crate::fit::Fit;
use crate::measure::Measure;

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
    /// Look at the logs in a folder and write a first session.toml
    Init(Init),
    /// Say what a raw file holds: channels, units, rates, damage
    Inspect(Inspect),
    /// Read the raw files of sessions into Parquet tables
    Ingest(Ingest),
    /// Measure in photographs: diameters, angles, areas, scales, lenses; with overlays
    Measure(Measure),
    /// Write measured and predicted values for other programs: MCAP, CSV, Parquet
    Export(Export),
    /// Judge stored results again; the exit code is the verdict
    Gate(Gate),
    /// Record results as the baseline that later ones are held against
    Accept(Accept),
    /// Draw the report again from stored numbers
    Report(Report),
    /// Print what the models predict over pressure
    Predict(Predict),
    /// Recompute what the papers say, or what your manuscript says, from its own numbers
    Audit(Audit),
    /// Fit constants to measured values: any formula, materials, actuators
    Fit(Fit),
    /// Write a raw session with known truth and, on demand, known faults
    Rehearse(Rehearse),
    /// Hold the program to its statistical promises, at length
    Selftest(Selftest),
    /// List the model catalogue: equations, sources, misprints, check values
    Models(Models),
    /// List the material laws: energies, stresses, constants, check values; and the papers' constants in them
    Materials(Materials),
    /// Print what a shell needs to complete commands and flags
    Completions(Completions),
    /// Write man pages: one for the program, one for each command
    Man(Man),
}

/// Recompute what the papers say, or what your manuscript says, from its own printed numbers.
///
/// A claims file lists statements, the numbers they rest on as printed, and formulas; the outcome is computed: reproduced,
/// reproduced-by-rounding, contradicted, not-checkable. Without FILES the claims of the five embedded papers are audited.
#[derive(Args)]
#[command(
    after_help = "Examples:\n  pneuval audit\n  pneuval audit --paper dual-chamber-finger --out audit\n  pneuval audit claims.toml --json                     your manuscript, before a reviewer does\n\nExit codes: 0 every outcome is as expected, 1 some is not (a statement is contradicted that the file does not say is), 2 the file is wrong."
)]
pub struct Audit {
    /// Claims files; the embedded papers where there is none
    pub files: Vec<PathBuf>,
    /// One paper only
    #[arg(long, value_name = "ID")]
    pub paper: Option<String>,
    /// Write a page and audit.json into this folder
    #[arg(long, value_name = "FOLDER")]
    pub out: Option<PathBuf>,
    /// Print JSON
    #[arg(long)]
    pub json: bool,
}

/// Print what a shell needs to complete commands and flags.
#[derive(Args)]
#[command(
    after_help = "Examples:\n  pneuval completions bash > ~/.local/share/bash-completion/completions/pneuval\n  pneuval completions zsh > ~/.zfunc/_pneuval\n  pneuval completions fish > ~/.config/fish/completions/pneuval.fish"
)]
pub struct Completions {
    /// The shell
    pub shell: clap_complete::Shell,
}

/// Write man pages: one for the program, one for each command.
#[derive(Args)]
#[command(after_help = "Example:\n  pneuval man --out ~/.local/share/man/man1 && man pneuval-validate")]
pub struct Man {
    /// Folder for the pages; pages of these names there are replaced
    #[arg(long, value_name = "FOLDER", default_value = "man")]
    pub out: PathBuf,
}

/// Compare every prediction with its measurement, judge it, write a report.
///
/// Reads the datasets below each PATH, or the embedded papers if none is given. Actuators and bounds are looked up in the
/// dataset's folder, its parents, then among the embedded ones.
// Flags of a command line.
#[allow(clippy::struct_excessive_bools)]
#[derive(Args)]
#[command(
    after_help = "Examples:\n  pneuval validate                         the embedded papers\n  pneuval validate datasets --out report   a folder of datasets\n  pneuval validate mine --bounds lab.toml --json\n  pneuval validate monday --no-report      between two runs at the rig"
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
    /// Write pages without figures: faster, for many comparisons
    #[arg(long, conflicts_with = "every_figure")]
    pub no_figures: bool,
    #[command(flatten)]
    pub drawn: Drawn,
    /// Write no folder at all: every number computed and judged, for the table and the exit code
    #[arg(long, conflicts_with_all = ["out", "no_figures", "every_figure", "one_file", "report_only"])]
    pub no_report: bool,
    /// Exit 0 whatever the verdicts; page one says so
    #[arg(long)]
    pub report_only: bool,
    #[command(flatten)]
    pub told: Told,
}

/// How a report is drawn.
#[derive(Args)]
pub struct Drawn {
    /// Draw the figures of every session, as files too, however many there are
    #[arg(long)]
    pub every_figure: bool,
    /// Put photographs into the pages, so that each page is one file that can be sent alone
    #[arg(long)]
    pub one_file: bool,
}

/// How the results are told on standard output.
#[derive(Args)]
pub struct Told {
    /// Print the results as CI servers and people read them, instead of the table
    #[arg(long, value_enum, default_value_t = ToldFormat::Table)]
    pub format: ToldFormat,
    /// As --format json
    #[arg(long, conflicts_with = "format")]
    pub json: bool,
}

/// What results are printed as.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum ToldFormat {
    /// Rows, reasons, the decision
    Table,
    /// results.json
    Json,
    /// XML of `JUnit`, as Jenkins and GitLab read it
    Junit,
    /// For a pull request, or the summary of a job
    Markdown,
    /// Annotations of GitHub Actions
    Github,
}

/// Look at the logs in a folder and write a first session.toml, with rig.toml, actuator.toml and bounds.toml to fill in.
///
/// Delimiter, header, units and clock are found out; what is guessed is marked GUESS. Only the actuator's id must be filled in.
#[derive(Args)]
#[command(after_help = "Examples:\n  pneuval init monday\n  pneuval init monday --actuator my-finger")]
pub struct Init {
    /// The folder with the logs
    pub folder: PathBuf,
    /// The actuator's id, embedded or of your own
    #[arg(long, value_name = "ID")]
    pub actuator: Option<String>,
    /// Print what was done as JSON
    #[arg(long)]
    pub json: bool,
}

/// Say what a raw file holds: channels, units, rates, gaps, damage; and how a session.toml would name it.
///
/// The format is found out from the bytes. Nothing is written, and large files are looked at in little memory.
#[derive(Args)]
#[command(
    after_help = "Examples:\n  pneuval inspect run-1.csv\n  pneuval inspect bag/ --json\n\nExit codes: 0 all was read, 3 data are lost (a cut file, a wrong checksum), 4 the file cannot be used."
)]
pub struct Inspect {
    /// Raw files, or folders of a ROS 2 bag
    #[arg(required = true)]
    pub files: Vec<PathBuf>,
    /// Print JSON
    #[arg(long)]
    pub json: bool,
}

/// Read the raw files of sessions into Parquet tables, and tell what is odd about them.
///
/// A table holds the samples that share a clock: `time_s` and the channels, in SI units. session.json beside them says what they are,
/// where they come from and what was found. Only files that have changed are read again.
#[derive(Args)]
#[command(
    after_help = "Examples:\n  pneuval ingest monday\n  pneuval ingest lab --store /data/store\n\nThe store is <session>/.pneuval, or the user's cache where that cannot be written.\nExit codes: 0 all was read, 3 data are lost or too many samples excluded, 4 no file can be used."
)]
pub struct Ingest {
    /// Sessions, or folders of them
    #[arg(required = true)]
    pub paths: Vec<PathBuf>,
    /// Store below this folder, one folder for each session
    #[arg(long, value_name = "FOLDER")]
    pub store: Option<PathBuf>,
    /// Print what is stored as JSON
    #[arg(long)]
    pub json: bool,
}

/// Write measured and predicted values for other programs: MCAP for Foxglove and PlotJuggler, CSV, Parquet.
///
/// Of a session, every run with its channels and, at each sample, what every model of `validate` predicts at that pressure; and the points
/// that are compared. Of a published dataset, its printed tables. Numbers are in the units they are shown in, which the files state.
#[derive(Args)]
#[command(
    after_help = "Examples:\n  pneuval export monday --out for-foxglove\n  pneuval export lab --out tables --format parquet --json\n  pneuval export --out papers --format csv                the embedded papers\n\nExit codes: 0 all was written, 2 what you wrote is wrong, 3 data are lost or too many samples excluded, 4 a log cannot be used."
)]
pub struct Export {
    /// Sessions, datasets, or folders of them; the embedded papers where there is none
    pub paths: Vec<PathBuf>,
    /// Folder for the files; an earlier export there is replaced
    #[arg(long, value_name = "FOLDER")]
    pub out: PathBuf,
    /// How they are written
    #[arg(long, value_enum, default_value_t = ExportFormat::Mcap)]
    pub format: ExportFormat,
    /// Print what was written as JSON: files, topics, columns, units, digests
    #[arg(long)]
    pub json: bool,
}

/// What files an export holds.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum ExportFormat {
    /// Messages over time, for Foxglove and PlotJuggler
    Mcap,
    /// A row of names, a row of units
    Csv,
    /// For pandas, DuckDB, polars
    Parquet,
}

/// Judge stored results again; the exit code is the verdict.
#[derive(Args)]
#[command(
    after_help = "Examples:\n  pneuval gate report\n  pneuval gate report --bounds stricter.toml\n  pneuval gate report --baseline baseline.json\n  pneuval gate report --format github                     in a job of GitHub Actions"
)]
pub struct Gate {
    /// A report, its results folder, or results.json
    pub results: PathBuf,
    /// Bounds to judge by, instead of the stored ones
    #[arg(long, value_name = "FILE")]
    pub bounds: Option<PathBuf>,
    /// Say what moved since a baseline that `accept` wrote, or since a report; exit 1 if something became worse than intervals explain
    #[arg(long, value_name = "FILE")]
    pub baseline: Option<PathBuf>,
    #[command(flatten)]
    pub told: Told,
}

/// Record results as the baseline that later ones are held against.
///
/// On purpose, and with a reason, which stays in the file beside those of earlier ones.
#[derive(Args)]
#[command(
    after_help = "Example:\n  pneuval accept report --baseline baseline.json --because \"hoop stretch kept\"\n  pneuval gate later --baseline baseline.json"
)]
pub struct Accept {
    /// A report, its results folder, or results.json
    pub results: PathBuf,
    /// The file that is written
    #[arg(long, value_name = "FILE")]
    pub baseline: PathBuf,
    /// Why, for who asks in a year
    #[arg(long, value_name = "TEXT")]
    pub because: String,
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
    #[command(flatten)]
    pub drawn: Drawn,
    /// Print results.json instead of the folder's name
    #[arg(long)]
    pub json: bool,
}

/// Print what the models predict over pressure.
#[derive(Args)]
#[command(
    after_help = "Examples:\n  pneuval predict internal-support\n  pneuval predict dual-chamber-finger --quantity tip-angle --form printed\n  pneuval predict dual-chamber-finger --quantity total-angle --at \"40 kPa, 50 kPa\"\n  pneuval predict fruit-finger --quantity tip-force --with \"held_angle = 30 deg\"\n  pneuval predict fruit-finger --quantity bending-angle --with \"finger_length = 46.7 mm\""
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
    /// A condition, or a parameter in place of the actuator file's, with unit; may be repeated
    #[arg(long, value_name = "NAME = VALUE", allow_hyphen_values = true)]
    pub with: Vec<String>,
    /// Steps from zero to full pressure
    #[arg(long, default_value_t = 10, value_parser = clap::value_parser!(u32).range(1..=100_000), conflicts_with = "at")]
    pub steps: u32,
    /// Print JSON, in SI units
    #[arg(long)]
    pub json: bool,
}

/// Write a raw session with known truth and, on demand, known faults.
///
/// Pressure programme, regulator, specimen, instruments and clocks are those of a plan: an embedded one for each of the five types, or
/// your own rehearsal.toml. What is written is what a rig would have written, with session.toml, rig.toml, actuator.toml and bounds.toml
/// to validate it, and truth.json, which says what really happened. The same seed gives the same bytes.
// Flags of a command line.
#[allow(clippy::struct_excessive_bools)]
#[derive(Args)]
#[command(
    after_help = "Examples:\n  pneuval rehearse internal-support --out monday && pneuval validate monday\n  pneuval rehearse fruit-finger --format tdms --seed 7\n  pneuval rehearse internal-support --truth \"outer-diameter = mine.csv\"\n  pneuval rehearse pdms-wall --fault gap --fault flatline@force\n  pneuval rehearse internal-support --photographs\n  pneuval rehearse --faults\n  pneuval rehearse wave-finger --plan > mine.toml && pneuval rehearse mine.toml"
)]
pub struct Rehearse {
    /// A plan: the id of an embedded one or of `rehearsals/ID.toml` here or above, or a file
    pub actuator: Option<String>,
    /// Folder that is written: a new or an empty one. Default: `rehearsed-` and the plan's id
    #[arg(long, value_name = "FOLDER")]
    pub out: Option<PathBuf>,
    /// What the random numbers come from
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
    /// Runs of each programme
    #[arg(long, default_value_t = 3, value_parser = clap::value_parser!(u16).range(1..=1000))]
    pub repeats: u16,
    /// Specimens, each with a session of its own
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u16).range(1..=10_000))]
    pub specimens: u16,
    /// No noise, lag, creep, hysteresis: what is logged is the truth
    #[arg(long)]
    pub ideal: bool,
    /// Photographs in place of logs: the plan `ACTUATOR-photographs`
    #[arg(long)]
    pub photographs: bool,
    /// The format of every device, in place of the plan's
    #[arg(long)]
    pub format: Option<RehearsedFormat>,
    /// How messages of a bag are encoded
    #[arg(long, default_value = "cdr")]
    pub encoding: BagEncoding,
    /// How chunks of a bag are compressed
    #[arg(long, default_value = "zstd")]
    pub compression: BagCompression,
    /// Whether all devices share a clock or have the plan's own, with offset and drift
    #[arg(long, default_value = "one")]
    pub clocks: Clocks,
    /// The shape of the pressure programme, in place of the plan's
    #[arg(long)]
    pub programme: Option<Shape>,
    /// One sitting of the plan only
    #[arg(long, value_name = "ID")]
    pub sitting: Option<String>,
    /// What really happens: published, a form of `pneuval models`, or a table; may be repeated
    #[arg(long, value_name = "QUANTITY = WHAT")]
    pub truth: Vec<String>,
    /// What goes wrong, in the second run unless said otherwise; may be repeated
    #[arg(long, value_name = "NAME[@CHANNEL][:RUN]")]
    pub fault: Vec<String>,
    /// Print the plan, to begin one of your own with
    #[arg(long)]
    pub plan: bool,
    /// List the faults
    #[arg(long, exclusive = true)]
    pub faults: bool,
    /// Print what was written as JSON
    #[arg(long)]
    pub json: bool,
}

/// Formats that any device can be given.
#[derive(Clone, Copy, ValueEnum)]
pub enum RehearsedFormat {
    Csv,
    Serial,
    Lvm,
    Tdms,
    Mcap,
}

/// Encodings of messages.
#[derive(Clone, Copy, ValueEnum)]
pub enum BagEncoding {
    Cdr,
    Json,
    Protobuf,
}

/// Compressions of chunks.
#[derive(Clone, Copy, ValueEnum)]
pub enum BagCompression {
    Zstd,
    Lz4,
    None,
}

/// Whose clocks devices have.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Clocks {
    One,
    Own,
}

/// Shapes of a pressure programme.
#[derive(Clone, Copy, ValueEnum)]
pub enum Shape {
    Steps,
    Ramp,
    Sine,
    Cycles,
}

/// Hold the program to its statistical promises, at length.
///
/// Sessions are rehearsed with many seeds, read and analysed as any session is; what is promised is compared with what really happened.
#[derive(Args)]
#[command(
    after_help = "Examples:\n  pneuval selftest lag\n  pneuval selftest lag --seeds 100 --json\n\nExit codes: 0 every promise holds, 1 some do not."
)]
pub struct Selftest {
    #[command(subcommand)]
    pub promise: Promise,
}

/// What is promised.
#[derive(Subcommand)]
pub enum Promise {
    /// 95 % intervals of metrics: whether they hold the truth, with few repeats and with many
    Coverage(SelftestCoverage),
    /// Clocks by sync events, and the lag between pressure and motion with and without them
    Lag(SelftestLag),
}

/// 95 % intervals of metrics: whether they hold the truth, with few repeats and with many.
#[derive(Args)]
pub struct SelftestCoverage {
    /// Sessions of so many repeats only: 2, 3, 5 or 10
    #[arg(long, value_name = "N", value_parser = clap::builder::PossibleValuesParser::new(["2", "3", "5", "10"]).map(|n| n.parse::<usize>().unwrap_or_default()))]
    pub repeats: Option<usize>,
    /// Sessions of each kind, each with a seed of its own
    #[arg(long, default_value_t = 1000, value_parser = clap::value_parser!(u32).range(10..=100_000))]
    pub seeds: u32,
    /// Print JSON, in SI units
    #[arg(long)]
    pub json: bool,
}

/// Clocks by sync events, and the lag between pressure and motion with and without them.
#[derive(Args)]
pub struct SelftestLag {
    /// Sessions of each kind, each with a seed of its own
    #[arg(long, default_value_t = 1000, value_parser = clap::value_parser!(u32).range(10..=100_000))]
    pub seeds: u32,
    /// Print JSON, in SI units
    #[arg(long)]
    pub json: bool,
}

/// List the model catalogue: equations, sources, misprints, check values.
#[derive(Args)]
#[command(
    after_help = "Examples:\n  pneuval models\n  pneuval models internal-support --json\n\nJSON: an array of forms; after them, with \"unevaluable\": true, the printed equations that cannot be evaluated\n(actuator, equations, source, why)."
)]
pub struct Models {
    /// One actuator type only
    pub actuator: Option<String>,
    /// Print JSON
    #[arg(long)]
    pub json: bool,
}

/// List the material laws: energies, stresses, constants, check values; and the papers' constants in them.
#[derive(Args)]
#[command(after_help = "Examples:\n  pneuval materials\n  pneuval materials yeoh --json")]
pub struct Materials {
    /// One law only
    pub law: Option<String>,
    /// Print JSON, in SI units
    #[arg(long)]
    pub json: bool,
}
