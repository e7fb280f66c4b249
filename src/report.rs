//! `pneuval report`: draw again from stored numbers.

use std::path::Path;

use pneuval_analysis::folder::{self, Drawing, Figures};

use crate::cli::Report;
use crate::exit::{Failure, Outcome};
use crate::output;
use crate::progress::Progress;

pub fn run(arguments: &Report) -> Result<Outcome, Failure> {
    let (results_folder, evaluation) = folder::load(&arguments.results)?;
    // The results folder lies in the report's.
    let out = arguments.out.as_deref().or_else(|| results_folder.parent()).unwrap_or(Path::new("report"));
    let figures = if arguments.drawn.every_figure { Figures::Every } else { Figures::Some };
    let drawing = Drawing { figures, one_file: arguments.drawn.one_file };
    let bar = Progress::of("drawing", "figures", 0);
    let results = folder::publish(out, evaluation, drawing, &|done, all| bar.at(done, all))?;
    drop(bar);
    if arguments.json {
        output::print_json_text(&folder::to_json(&results)?)?;
    } else {
        output::print(&format!("Report: {}\n", out.join("index.html").display()))?;
    }
    Ok(Outcome::Expected)
}
