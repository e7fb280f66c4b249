//! What `pneuval fit` is told.

use std::path::PathBuf;

use clap::{Args, Subcommand};

/// Fit constants to measured values, and say what the values know of each: standard errors, intervals, correlations, what they cannot tell
/// apart.
#[derive(Args)]
#[command(
    after_help = "Examples:\n  pneuval fit expression 'b1*(1-exp(-b2*x))' data.csv --start \"b1=250, b2=0.0005\"\n\nExit codes: 0 a minimum that determines every parameter, 2 what you wrote is wrong, 3 no such minimum, 4 the file cannot be used."
)]
pub struct Fit {
    #[command(subcommand)]
    pub what: Fitted,
}

/// What is fitted.
#[derive(Subcommand)]
pub enum Fitted {
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

/// How hard a minimum is looked for, and how sure intervals are.
#[derive(Args)]
pub struct SearchArguments {
    /// Starts to try: the given one, then others round it
    #[arg(long, default_value_t = 49, value_parser = clap::value_parser!(u32).range(1..=10_000))]
    pub starts: u32,
    /// Confidence of the intervals
    #[arg(long, default_value_t = 0.95, value_parser = confidence)]
    pub confidence: f64,
}

/// A confidence: above 0.5 and below 1.
fn confidence(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value > 0.5 && value < 1.0 => Ok(value),
        _ => Err("expected a number between 0.5 and 1, such as 0.95".to_owned()),
    }
}
