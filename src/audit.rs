//! `pneuval audit`: printed claims, recomputed.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::Path;

use pneuval_analysis::audit::{Audited, Claims, Outcome as Came, audit};
use pneuval_analysis::prediction::inputs;
use pneuval_analysis::report::audit_page;
use pneuval_ingest::error::suggestion;
use pneuval_ingest::{IngestError, limits};
use pneuval_models::catalogue;

use crate::cli::Audit;
use crate::exit::{Failure, Outcome};
use crate::paint::{self, Tone};
use crate::{output, predict};

pub fn run(arguments: &Audit) -> Result<Outcome, Failure> {
    let mut claims: Vec<Claims> = Vec::new();
    if arguments.files.is_empty() {
        for (file, bytes) in pneuval_datasets::embedded_claims() {
            claims.push(Claims::read(&file, bytes)?);
        }
    }
    for path in &arguments.files {
        let bytes = limits::read(path, limits::WRITTEN_BYTES_MAX)?;
        claims.push(Claims::read(&path.display().to_string(), &bytes)?);
    }
    if let Some(paper) = &arguments.paper {
        let known: Vec<String> = claims.iter().map(|claims| claims.id.clone()).collect();
        claims.retain(|claims| claims.id == *paper);
        if claims.is_empty() {
            return Err(Failure::Flag {
                flag: "--paper",
                found: format!("`{paper}`"),
                expected: known.join(", "),
                next: suggestion(paper, known.iter().map(String::as_str)),
            });
        }
    }
    let audited: Vec<Audited> = claims.iter().map(|claims| audit(claims, &model)).collect();
    if let Some(folder) = &arguments.out {
        write(folder, &audited)?;
    }
    if arguments.json {
        output::print_json(&audited)?;
    } else {
        output::print_painted(&text(&audited))?;
    }
    let as_expected = audited.iter().flat_map(|paper| &paper.claims).all(|claim| claim.as_expected);
    Ok(if as_expected { Outcome::Expected } else { Outcome::Differs })
}

/// What a model of the catalogue says, inputs from the actuator's file.
fn model(path: &[String; 3], at: &[String], with: &BTreeMap<String, String>) -> Result<Vec<f64>, String> {
    let [actuator, quantity, form] = path;
    let first_line = |failure: Failure| failure.to_string().lines().collect::<Vec<_>>().join("; ");
    let described = pneuval_datasets::find_actuator(actuator, Path::new(".")).map_err(|e| first_line(e.into()))?;
    let entry = catalogue::entries()
        .find(|entry| entry.actuator == described.kind && entry.quantity == *quantity && entry.form == *form)
        .ok_or_else(|| format!("no model {} is known", path.join("/")))?;
    let (mut values, _) = inputs(entry, &described).map_err(|e| first_line(e.into()))?;
    for (name, value) in with {
        let given = predict::given(&format!("{name} = {value}")).map_err(first_line)?;
        let known = entry.parameters.iter().chain(entry.conditions).find(|p| p.name == *name);
        let parameter = known.ok_or_else(|| format!("the model has no input `{name}`"))?;
        if given.unit.dimension.si_symbol() != parameter.si_unit {
            return Err(format!("`{name}` is in `{}`, not in a unit of {}", given.unit.symbol, parameter.si_unit));
        }
        values.set(name.as_str(), given.si);
    }
    let model = entry.build(&values).map_err(|e| e.to_string())?;
    let one = |text: &String| -> Result<f64, String> {
        let predicted = model.predict(&predict::pressures(text).map_err(first_line)?).map_err(|e| e.to_string())?;
        predicted.first().copied().ok_or_else(|| "no value".to_owned())
    };
    at.iter().map(one).collect()
}

/// The page and the numbers.
fn write(folder: &Path, audited: &[Audited]) -> Result<(), Failure> {
    let failed = |source| IngestError::write(folder, source);
    std::fs::create_dir_all(folder).map_err(failed)?;
    let page = audit_page(audited)?;
    let json = serde_json::to_string_pretty(audited).map_err(|e| failed(e.into()))?;
    std::fs::write(folder.join(&page.name), page.html).map_err(failed)?;
    std::fs::write(folder.join("audit.json"), json + "\n").map_err(failed)?;
    output::tell(&format!("wrote {}", folder.join(&page.name).display()));
    Ok(())
}

fn text(audited: &[Audited]) -> String {
    let visible = pneuval_analysis::format::visible;
    let mut out = String::new();
    for paper in audited {
        // Writing to a String cannot fail, here and below.
        let _ = writeln!(out, "{}", visible(&format!("{}: {}", paper.paper, paper.title)));
        for claim in &paper.claims {
            let tone = match claim.outcome {
                Came::Reproduced | Came::ReproducedByRounding => Tone::Good,
                Came::Contradicted => Tone::Bad,
                Came::NotCheckable => Tone::Open,
            };
            let outcome = paint::painted(tone, claim.outcome.id());
            let expected = if claim.as_expected { "" } else { ", not as expected" };
            let _ = writeln!(
                out,
                "  {outcome}{expected}  {}",
                visible(&format!("{}: {} ({})", claim.id, claim.statement, claim.place))
            );
            for line in &claim.recomputation {
                let _ = writeln!(out, "      {}", visible(line));
            }
            for reading in &claim.readings {
                let _ = writeln!(out, "      {}", visible(&format!("- {}: {}", reading.name, reading.outcome.id())));
                for line in &reading.recomputation {
                    let _ = writeln!(out, "          {}", visible(line));
                }
            }
        }
        let counts = [Came::Reproduced, Came::ReproducedByRounding, Came::Contradicted, Came::NotCheckable]
            .map(|outcome| format!("{} {}", paper.count(outcome), outcome.id()));
        let _ = writeln!(out, "  {} claims: {}\n", paper.claims.len(), counts.join(", "));
    }
    out
}
