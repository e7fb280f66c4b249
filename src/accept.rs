//! `pneuval accept`: a baseline, recorded on purpose.

use pneuval_analysis::baseline::{self, Baseline};
use pneuval_analysis::folder;

use crate::cli::Accept;
use crate::exit::{Failure, Outcome};
use crate::output;

pub fn run(arguments: &Accept) -> Result<Outcome, Failure> {
    if arguments.because.trim().is_empty() {
        return Err(Failure::Flag {
            flag: "--because",
            found: "is empty".to_owned(),
            expected: "why these results are the ones that later ones are held against".to_owned(),
            next: "write it in a sentence".to_owned(),
        });
    }
    let (_, evaluation) = folder::load(&arguments.results)?;
    let results = evaluation.results;
    let path = &arguments.baseline;
    let moved = if path.exists() {
        // Metrics that are defined anew have nothing to be held against: that is a reason to accept, too.
        match Baseline::read(path)?.moves(&results) {
            Ok(moves) => baseline::text(&moves),
            Err(why) => format!("{why}\n"),
        }
    } else {
        format!("{} comparisons, none before\n", results.comparisons.len())
    };
    Baseline::of(&results, &arguments.because).write(path)?;
    output::print(&format!("{moved}Accepted: {}\n", path.display()))?;
    Ok(Outcome::Expected)
}
