//! Exit codes, all in one place.
//!
//! | code | meaning |
//! |---|---|
//! | 0 | every verdict is as expected |
//! | 1 | some verdict differs from the expected one, and nothing else |
//! | 2 | what the user wrote is wrong: flags, TOML, a published table, a named file that is missing |
//! | 3 | inconclusive, unjudged, nothing but calibration, or data lost |
//! | 4 | what the instrument wrote cannot be used |

use std::process::ExitCode;

use thiserror::Error;

use pneuval_analysis::AnalysisError;
use pneuval_analysis::fit::expression::ExpressionError;
use pneuval_analysis::results::{Decision, Results};
use pneuval_datasets::DatasetError;
use pneuval_ingest::IngestError;
use pneuval_models::ModelError;

use crate::output;

/// How a command ended that could do its work.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Outcome {
    /// Done, or every verdict as expected.
    Expected,
    /// Some verdict differs.
    Differs,
    /// Something is open.
    Open,
}

/// Why a command could not do its work: the user's to mend, exit 2, or what an instrument wrote, exit 4.
#[derive(Debug, Error)]
pub enum Failure {
    /// A dataset, actuator or path.
    #[error(transparent)]
    Dataset(#[from] DatasetError),
    /// A comparison, a results folder, a figure.
    #[error(transparent)]
    Analysis(#[from] AnalysisError),
    /// A file.
    #[error(transparent)]
    Ingest(#[from] IngestError),
    /// A formula that cannot be fitted.
    #[error(transparent)]
    Expression(#[from] ExpressionError),
    /// A form that cannot be fitted.
    #[error(
        "form `{form}`\n  expected: parameters that the readings determine\n  found:    {source}\n  next:     fit fewer parameters, start nearer (the actuator file), or look at the readings with `pneuval validate`"
    )]
    Fit {
        /// The form.
        form: String,
        /// What the model or the search says.
        source: ModelError,
    },
    /// A flag's value.
    #[error("{flag} {found}\n  expected: {expected}\n  next:     {next}")]
    Flag {
        /// The flag or argument.
        flag: &'static str,
        /// What was given.
        found: String,
        /// What is asked for.
        expected: String,
        /// What to do.
        next: String,
    },
    /// Standard output refused the result.
    #[error("standard output: {0}")]
    Output(#[from] std::io::Error),
}

impl Failure {
    fn code(&self) -> u8 {
        match self {
            Self::Ingest(IngestError::Unusable { .. })
            | Self::Dataset(DatasetError::Ingest(IngestError::Unusable { .. }))
            | Self::Analysis(AnalysisError::Ingest(IngestError::Unusable { .. })) => 4,
            // The data leave it open.
            Self::Fit { .. } | Self::Expression(ExpressionError::NoMinimum { .. }) => 3,
            _ => 2,
        }
    }
}

/// The outcome that results stand for.
pub fn of_results(results: &Results) -> Outcome {
    match results.decision() {
        _ if results.report_only => Outcome::Expected,
        Decision::AsExpected => Outcome::Expected,
        Decision::Unexpected => Outcome::Differs,
        Decision::Open => Outcome::Open,
    }
}

/// What remains of several failures: all but the worst are told here, and that one is the command's. What the user can mend comes first.
pub fn worst(outcome: Outcome, mut failures: Vec<Failure>) -> Result<Outcome, Failure> {
    failures.sort_by_key(Failure::code);
    let mut failures = failures.into_iter();
    let Some(worst) = failures.next() else { return Ok(outcome) };
    failures.for_each(|failure| output::tell(&format!("error: {failure}")));
    Err(worst)
}

/// Tells a failure on standard error, and gives the exit code.
pub fn finish(outcome: Result<Outcome, Failure>) -> ExitCode {
    match outcome {
        Ok(Outcome::Expected) => ExitCode::SUCCESS,
        Ok(Outcome::Differs) => ExitCode::from(1),
        Ok(Outcome::Open) => ExitCode::from(3),
        Err(failure) => {
            output::tell(&format!("error: {failure}"));
            ExitCode::from(failure.code())
        }
    }
}
