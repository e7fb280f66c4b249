//! Results on standard output: for people, and for CI servers.

use std::path::Path;

use pneuval_analysis::results::Results;
use pneuval_analysis::{ci, folder};

use crate::cli::{Told, ToldFormat};
use crate::exit::Failure;
use crate::{output, table};

/// Prints results as they are asked for; a table says where the report lies.
pub fn print(results: &Results, told: &Told, report: Option<&Path>) -> Result<(), Failure> {
    let format = if told.json { ToldFormat::Json } else { told.format };
    match format {
        ToldFormat::Table => {
            let report = report.map_or(String::new(), |path| format!("Report: {}\n", path.display()));
            output::print(&(table::render(results) + &report))?;
        }
        ToldFormat::Json => output::print_json_text(&folder::to_json(results)?)?,
        ToldFormat::Junit => output::print(&ci::junit(results)?)?,
        ToldFormat::Markdown => output::print(&ci::markdown(results))?,
        ToldFormat::Github => output::print(&ci::annotations(results))?,
    }
    Ok(())
}
