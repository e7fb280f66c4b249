//! What `pneuval fit` is told.

use std::path::PathBuf;

use clap::{Args, Subcommand, ValueEnum};

/// Fit constants to measured values, and say what the values know of each: standard errors, intervals, correlations, what they cannot tell
/// apart.
#[derive(Args)]
#[command(
    after_help = "Examples:\n  pneuval fit material --uniaxial strip.csv --length \"33 mm\" --width \"6 mm\" --thickness \"3 mm\"\n  pneuval fit expression 'b1*(1-exp(-b2*x))' data.csv --start \"b1=250, b2=0.0005\"\n\nExit codes: 0 a minimum that determines every parameter, 2 what you wrote is wrong, 3 no such minimum, 4 the file cannot be used."
)]
pub struct Fit {
    #[command(subcommand)]
    pub what: Fitted,
}

/// What is fitted.
#[derive(Subcommand)]
pub enum Fitted {
    /// Laws of rubber to tests of strips and sheets
    Material(FitMaterial),
    /// Unknown inputs of an actuator's model to its measured response
    Actuator(FitActuator),
    /// Any formula to the columns of a table
    Expression(FitExpression),
}

/// Any formula to the columns of a table: exact derivatives, many starts, intervals from profiles.
///
/// Names in the formula are columns, or parameters with a start value. `y = ...` names the response; without it the response is `y`, or the
/// first column of a file without names. Files of NIST's Statistical Reference Datasets bring their starts, and what is found is told
/// beside what is certified.
#[derive(Args)]
#[command(
    after_help = "Examples:\n  pneuval fit expression 'b1*(1-exp(-b2*x))' Misra1a.dat --start 1\n  pneuval fit expression 'angle = a*pressure + b*pressure^2' log.csv --start \"a=1, b=0\"\n  pneuval fit expression 'F = k*x' pull.csv --columns x,F --start k=2"
)]
pub struct FitExpression {
    /// The formula: + - * / ^ (or **), exp ln log10 sqrt sin cos tan atan ..., pi
    pub formula: String,
    /// A table: delimited text, LabVIEW, TDMS, MCAP; or a file of NIST's reference datasets
    pub file: PathBuf,
    /// Start values, `a=1, b=0.5`; for a NIST file `1` or `2`, its own
    #[arg(long, value_name = "VALUES", allow_hyphen_values = true)]
    pub start: Option<String>,
    /// Names for the columns from the left, where the file has none or others
    #[arg(long, value_name = "NAMES")]
    pub columns: Option<String>,
    /// The response: a column, or a formula of columns
    #[arg(long, value_name = "FORMULA")]
    pub response: Option<String>,
    /// A column of standard uncertainties: residuals are divided by them
    #[arg(long, value_name = "COLUMN")]
    pub std: Option<String>,
    #[command(flatten)]
    pub search: SearchArguments,
    /// Print JSON
    #[arg(long)]
    pub json: bool,
}

/// Laws of rubber to tests of strips and sheets: which law, which constants, how sure, how far they can be trusted.
///
/// A test is force over displacement of a strip of known size, or stress over strain or stretch: columns are known by their names and units,
/// the strip's size by the file's own words or the flags. Engineering and true values are told apart by name. Several tests, and several load
/// cases, are fitted together. What is odd about a test (slack, slippage, several loadings, a unit) is told, and nothing is corrected.
#[derive(Args)]
#[command(
    after_help = "Examples:\n  pneuval fit material --uniaxial Dragon-Skin-20.csv\n  pneuval fit material --uniaxial UT.txt --planar PS.txt --equibiaxial ET.txt --columns \"stress/MPa, stretch\"\n  pneuval fit material --uniaxial strip-1.csv --uniaxial strip-2.csv --length \"33 mm\" --area \"18 mm2\" --law yeoh-2 --write material.toml\n\nExit codes: 0 every law asked for is a material that the data determine, 2 what you wrote is wrong, 3 some law is not, 4 a file cannot be used."
)]
pub struct FitMaterial {
    /// A test in tension or pressure along one axis; may be repeated
    #[arg(long, value_name = "FILE", required_unless_present_any = ["planar", "equibiaxial"])]
    pub uniaxial: Vec<PathBuf>,
    /// A test of a wide sheet held at its width (pure shear); may be repeated
    #[arg(long, value_name = "FILE")]
    pub planar: Vec<PathBuf>,
    /// A test pulled equally along two axes; may be repeated
    #[arg(long, value_name = "FILE")]
    pub equibiaxial: Vec<PathBuf>,
    /// Laws to fit, all where none is named; may be repeated. `eq-28` is wave-finger's straight line
    #[arg(long, value_name = "LAW")]
    pub law: Vec<String>,
    /// Names and units of the columns from the left, `-` for one that is not used
    #[arg(long, value_name = "NAMES")]
    pub columns: Option<String>,
    /// Length at rest of the strips
    #[arg(long, value_name = "LENGTH")]
    pub length: Option<String>,
    /// Width at rest of the strips
    #[arg(long, value_name = "LENGTH", requires = "thickness", conflicts_with = "area")]
    pub width: Option<String>,
    /// Thickness at rest of the strips
    #[arg(long, value_name = "LENGTH", requires = "width")]
    pub thickness: Option<String>,
    /// Section at rest of the strips, in place of width and thickness
    #[arg(long, value_name = "AREA")]
    pub area: Option<String>,
    /// Turn the sign of forces and stresses
    #[arg(long)]
    pub negate: bool,
    /// Which loading of several, from 1; the last where nothing is said
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    pub loading: Option<u16>,
    /// Leave out stretches below this
    #[arg(long, value_name = "STRETCH")]
    pub stretch_min: Option<f64>,
    /// Leave out stretches above this
    #[arg(long, value_name = "STRETCH")]
    pub stretch_max: Option<f64>,
    /// How residuals are weighted
    #[arg(long, value_enum, default_value_t = WeightArgument::Samples)]
    pub weight: WeightArgument,
    /// Confidence of the intervals
    #[arg(long, default_value_t = 0.95, value_parser = confidence)]
    pub confidence: f64,
    /// Write the constants of the one law named as a material of an actuator file
    #[arg(long, value_name = "FILE", requires = "law")]
    pub write: Option<PathBuf>,
    /// Print JSON, in SI units
    #[arg(long)]
    pub json: bool,
}

/// Unknown inputs of an actuator's model to its measured response: constants of its material, dimensions nobody printed.
///
/// Readings of every run are fitted together; values of the actuator file start the search, and those with a `std` pull on it as priors.
/// Intervals are those of the profile likelihood. What was fitted predicts nothing by that: each pressure, run and specimen is also predicted
/// by a fit to the others. `--write` writes the actuator file with the new values, which say `calibrated` and on which runs, so that
/// `validate` calls those runs calibration.
#[derive(Args)]
#[command(
    after_help = "Examples:\n  pneuval fit actuator internal-support --form consistent --to published-fea --parameters C10,C20\n  pneuval fit actuator monday --form consistent --parameters C10,C20 --write monday/actuator.toml\n  pneuval fit actuator internal-support --form consistent --to published-fea --parameters C10,C20 --pressure-max \"30 kPa\"\n\nExit codes: 0 every parameter is determined, 2 what you wrote is wrong, 3 some parameter is not, 4 a log cannot be used."
)]
pub struct FitActuator {
    /// Sessions or datasets of one actuator, or folders of them; or the id of an embedded paper
    #[arg(required = true)]
    pub paths: Vec<PathBuf>,
    /// The inputs to fit, as the actuator file names them, separated by commas
    #[arg(long, value_name = "NAMES", value_delimiter = ',', required = true)]
    pub parameters: Vec<String>,
    /// The quantity, where several are measured
    #[arg(long)]
    pub quantity: Option<String>,
    /// The form of the model, as `pneuval models` lists it
    #[arg(long)]
    pub form: Option<String>,
    /// What is fitted: `measured`, or a printed column of a paper
    #[arg(long, value_name = "COLUMN", default_value = "measured")]
    pub to: String,
    /// Runs that the fit sees, separated by commas; the others are predicted
    #[arg(long, value_name = "RUNS", value_delimiter = ',')]
    pub runs: Vec<String>,
    /// Pressures above this are kept from the fit and predicted
    #[arg(long, value_name = "PRESSURE")]
    pub pressure_max: Option<String>,
    /// Let standard uncertainties of the actuator file not pull
    #[arg(long)]
    pub no_priors: bool,
    /// Write the actuator file with the fitted values
    #[arg(long, value_name = "FILE")]
    pub write: Option<PathBuf>,
    #[command(flatten)]
    pub search: SearchArguments,
    /// Print JSON, in SI units
    #[arg(long)]
    pub json: bool,
}

/// How residuals are weighted.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum WeightArgument {
    /// Every sample alike, in nominal stress
    Samples,
    /// Every test alike, however many samples it has
    Tests,
    /// Over the measured stress
    Relative,
}

/// How hard a minimum is looked for, and how sure intervals are.
#[derive(Args)]
pub struct SearchArguments {
    /// Starts to try: the given one, then others round it; 49 for an expression, 9 for an actuator where nothing is said
    #[arg(long, value_parser = clap::value_parser!(u32).range(1..=10_000))]
    pub starts: Option<u32>,
    /// Confidence of the intervals
    #[arg(long, default_value_t = 0.95, value_parser = confidence)]
    pub confidence: f64,
}

impl SearchArguments {
    /// The number of starts.
    pub fn starts(&self, usual: u32) -> usize {
        usize::try_from(self.starts.unwrap_or(usual)).unwrap_or(usize::MAX)
    }
}

/// A confidence: above 0.5 and below 1.
fn confidence(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value > 0.5 && value < 1.0 => Ok(value),
        _ => Err("expected a number between 0.5 and 1, such as 0.95".to_owned()),
    }
}
