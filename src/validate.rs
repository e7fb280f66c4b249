//! `pneuval validate`: find, compare, judge, write, tell.

use std::path::Path;

use pneuval_analysis::bounds::Bounds;
use pneuval_analysis::compare::{self, BoundsScope, Input};
use pneuval_analysis::folder::{self, Drawing};
use pneuval_analysis::results::SourceFile;
use pneuval_analysis::study::Data;
use pneuval_datasets::{Found, FoundData};
use pneuval_ingest::{digest, limits};

use crate::cli::Validate;
use crate::exit::{self, Failure, Outcome};
use crate::{output, table};

pub fn run(arguments: &Validate) -> Result<Outcome, Failure> {
    let named = arguments.bounds.as_deref().map(named_bounds).transpose()?;
    let found = pneuval_datasets::find(&arguments.paths)?;
    let inputs = found.into_iter().map(|f| input(f, named.as_ref())).collect::<Result<Vec<Input>, Failure>>()?;
    let evaluation = compare::validate(&inputs, arguments.report_only)?;
    let drawing = if arguments.no_figures { Drawing::None } else { Drawing::Figures };
    let results = folder::publish(&arguments.out, evaluation, drawing)?;
    output::tell_findings(&results);
    if arguments.json {
        output::print_json_text(&folder::to_json(&results)?)?;
    } else {
        let index = arguments.out.join("index.html");
        output::print(&format!("{}Report: {}\n", table::render(&results), index.display()))?;
    }
    Ok(exit::of_results(&results))
}

/// A bounds file the user named: it must be there.
pub fn named_bounds(path: &Path) -> Result<(Bounds, SourceFile), Failure> {
    let bytes = limits::read(path, limits::WRITTEN_BYTES_MAX)?;
    let bounds = Bounds::read(&path.display().to_string(), &bytes)?;
    // Only the name: a path of this machine has no place in the results.
    let name = path.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned());
    Ok((bounds, SourceFile { path: name, sha256: digest::sha256(&bytes) }))
}

fn input(found: Found, named: Option<&(Bounds, SourceFile)>) -> Result<Input, Failure> {
    let bounds_scope = match (named, &found.bounds) {
        (None, Some(located)) if located.relative == "bounds.toml" => BoundsScope::Own,
        (None, Some(located)) if located.embedded => BoundsScope::Embedded,
        _ => BoundsScope::Shared,
    };
    let (bounds, bounds_source) = match (named, &found.bounds) {
        (Some((bounds, source)), _) => (bounds.clone(), Some(source.clone())),
        (None, Some(located)) => {
            let source = SourceFile { path: located.relative.clone(), sha256: digest::sha256(&located.bytes) };
            (Bounds::read(&located.file, &located.bytes)?, Some(source))
        }
        (None, None) => (Bounds::default(), None),
    };
    Ok(Input {
        file: found.file,
        data: match found.data {
            FoundData::Published(dataset) => Data::Published(dataset),
            FoundData::Session(session) => Data::Session(session),
        },
        actuator: found.actuator,
        actuator_path: found.actuator_file,
        bounds,
        bounds_source,
        bounds_scope,
    })
}
