//! Results on standard output: for people, and for CI servers.

use std::path::Path;

use pneuval_analysis::baseline::Move;
use pneuval_analysis::format::visible;
use pneuval_analysis::results::Results;
use pneuval_analysis::{baseline, ci, folder};
use serde::Serialize;

use crate::cli::{Told, ToldFormat};
use crate::exit::Failure;
use crate::{output, table};

/// Results and what moved, as JSON.
#[derive(Serialize)]
struct Since<'a> {
    moves: &'a [Move],
    results: &'a Results,
}

/// Prints results as they are asked for; a table says where the report lies.
pub fn print(results: &Results, moves: Option<&[Move]>, told: &Told, report: Option<&Path>) -> Result<(), Failure> {
    let format = if told.json { ToldFormat::Json } else { told.format };
    match format {
        ToldFormat::Table => {
            let report = report.map_or(String::new(), |path| format!("Report: {}\n", path.display()));
            let since = moves.map_or(String::new(), baseline::text);
            output::print_painted(&(table::render(results) + &visible(&(since + &report))))?;
        }
        ToldFormat::Json => match moves {
            Some(moves) => output::print_json(&Since { moves, results })?,
            None => output::print_json_text(&folder::to_json(results)?)?,
        },
        ToldFormat::Junit => output::print(&ci::junit(results, moves.unwrap_or_default())?)?,
        ToldFormat::Markdown => output::print(&ci::markdown(results, moves.unwrap_or_default()))?,
        ToldFormat::Github => output::print(&ci::annotations(results, moves.unwrap_or_default()))?,
    }
    Ok(())
}
