//! `pneuval gate`: judge stored results again.

use pneuval_analysis::baseline::Baseline;
use pneuval_analysis::{folder, gate};

use crate::cli::Gate;
use crate::exit::{self, Failure, Outcome};
use crate::validate::named_bounds;
use crate::{output, told};

pub fn run(arguments: &Gate) -> Result<Outcome, Failure> {
    let named = arguments.bounds.as_deref().map(named_bounds).transpose()?;
    let (_, evaluation) = folder::load(&arguments.results)?;
    let mut results = evaluation.results;
    // Whoever asks the gate wants its verdict, also of a run that was only to report.
    results.report_only = false;
    gate::rejudge(&mut results, named.as_ref().map(|(bounds, _)| bounds))?;
    output::tell_findings(&results);
    let moves = match &arguments.baseline {
        Some(path) => Some(Baseline::read(path)?.moves(&results)?),
        None => None,
    };
    told::print(&results, moves.as_deref(), &arguments.told, None)?;
    if moves.iter().flatten().any(|m| m.counts) {
        return Ok(Outcome::Differs);
    }
    Ok(exit::of_results(&results))
}
