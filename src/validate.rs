//! `pneuval validate`: find, compare, judge, write, tell.

use std::path::Path;

use pneuval_analysis::bounds::Bounds;
use pneuval_analysis::compare;
use pneuval_analysis::folder::{self, Drawing, Figures};
use pneuval_analysis::results::SourceFile;
use pneuval_analysis::study::{BoundsScope, Data, Input};
use pneuval_datasets::{Found, FoundData, Located};
use pneuval_ingest::{digest, limits};

use crate::cli::Validate;
use crate::exit::{self, Failure, Outcome};
use crate::progress::Progress;
use crate::{output, told};

pub fn run(arguments: &Validate) -> Result<Outcome, Failure> {
    let named = arguments.bounds.as_deref().map(named_bounds).transpose()?;
    let described = pneuval_datasets::describe(&arguments.paths)?;
    // Bounds are written by people as manifests are: they are read before any log.
    let judged = described
        .iter()
        .map(|described| judged(described.bounds.as_ref(), named.as_ref()))
        .collect::<Result<Vec<Judged>, Failure>>()?;
    let reading = Progress::of("reading", "datasets", described.len());
    let found = pneuval_datasets::load(described, &mut || reading.step())?;
    drop(reading);
    let inputs: Vec<Input> = found.into_iter().zip(judged).map(|(found, judged)| input(found, judged)).collect();
    let comparing = Progress::of("comparing", "datasets", inputs.len());
    let evaluation = compare::validate(&inputs, arguments.report_only, &mut || comparing.step())?;
    drop(comparing);
    let results = if arguments.no_report {
        folder::unpublished(evaluation)?
    } else {
        let figures = match (arguments.no_figures, arguments.drawn.every_figure) {
            (true, _) => Figures::None,
            (false, false) => Figures::Some,
            (false, true) => Figures::Every,
        };
        let drawing = Drawing { figures, one_file: arguments.drawn.one_file };
        let bar = Progress::of("drawing", "figures", 0);
        folder::publish(&arguments.out, evaluation, drawing, &|done, all| bar.at(done, all))?
    };
    output::tell_findings(&results);
    let index = arguments.out.join("index.html");
    told::print(&results, None, &arguments.told, Some(index.as_path()).filter(|_| !arguments.no_report))?;
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

/// Bounds, where they come from and what they reach.
type Judged = (Bounds, Option<SourceFile>, BoundsScope);

fn judged(located: Option<&Located>, named: Option<&(Bounds, SourceFile)>) -> Result<Judged, Failure> {
    if let Some((bounds, source)) = named {
        return Ok((bounds.clone(), Some(source.clone()), BoundsScope::Shared));
    }
    let Some(located) = located else { return Ok((Bounds::default(), None, BoundsScope::Shared)) };
    let scope = match located {
        located if located.relative == "bounds.toml" => BoundsScope::Own,
        located if located.embedded => BoundsScope::Embedded,
        _ => BoundsScope::Shared,
    };
    let source = SourceFile { path: located.relative.clone(), sha256: digest::sha256(&located.bytes) };
    Ok((Bounds::read(&located.file, &located.bytes)?, Some(source), scope))
}

/// What was found, as what is compared.
pub fn data_of(found: FoundData) -> Data {
    match found {
        FoundData::Published(dataset) => Data::Published(dataset),
        FoundData::Session(session) => Data::Session(session),
    }
}

fn input(found: Found, (bounds, bounds_source, bounds_scope): Judged) -> Input {
    Input {
        file: found.file,
        data: data_of(found.data),
        actuator: found.actuator,
        actuator_path: found.actuator_file,
        bounds,
        bounds_source,
        bounds_scope,
    }
}
