//! `pneuval models`: the catalogue, its check values computed on the spot.

use std::fmt::Write as _;

use serde::Serialize;

use pneuval_ingest::error::suggestion;
use pneuval_models::catalogue::{self, Entry};

use crate::cli::Models;
use crate::exit::{Failure, Outcome};
use crate::output;

#[derive(Serialize)]
struct Row {
    actuator: &'static str,
    quantity: &'static str,
    form: &'static str,
    kind: &'static str,
    title: &'static str,
    equation: &'static str,
    source: &'static str,
    range: &'static str,
    misprints: &'static [&'static str],
    chambers: &'static [&'static str],
    parameters: Vec<ParameterRow>,
    checks: Vec<CheckRow>,
}

#[derive(Serialize)]
struct ParameterRow {
    name: &'static str,
    si_unit: &'static str,
    meaning: &'static str,
}

#[derive(Serialize)]
struct CheckRow {
    statement: &'static str,
    expected: f64,
    tolerance: f64,
    unit: &'static str,
    computed: Option<f64>,
    holds: bool,
}

pub fn run(arguments: &Models) -> Result<Outcome, Failure> {
    let wanted = |entry: &&Entry| arguments.actuator.as_ref().is_none_or(|actuator| entry.actuator == actuator);
    let rows: Vec<Row> = catalogue::entries().filter(wanted).map(row).collect();
    if rows.is_empty() {
        let word = arguments.actuator.clone().unwrap_or_default();
        let mut known: Vec<&str> = catalogue::entries().map(|e| e.actuator).collect();
        known.dedup();
        return Err(Failure::Flag {
            flag: "ACTUATOR",
            next: suggestion(&word, known.iter().copied()),
            expected: known.join(", "),
            found: word,
        });
    }
    if arguments.json {
        output::print_json(&rows)?;
    } else {
        output::print(&text(&rows))?;
    }
    Ok(Outcome::Expected)
}

fn row(entry: &'static Entry) -> Row {
    let check = |check: &catalogue::Check| {
        let computed = (check.compute)().ok();
        let holds = computed.is_some_and(|value| (value - check.expected).abs() <= check.tolerance);
        CheckRow {
            statement: check.statement,
            expected: check.expected,
            tolerance: check.tolerance,
            unit: check.unit,
            computed,
            holds,
        }
    };
    let parameter = |p: &catalogue::Parameter| ParameterRow { name: p.name, si_unit: p.si_unit, meaning: p.meaning };
    Row {
        actuator: entry.actuator,
        quantity: entry.quantity,
        form: entry.form,
        kind: entry.kind.name(),
        title: entry.title,
        equation: entry.equation,
        source: entry.source,
        range: entry.range,
        misprints: entry.misprints,
        chambers: entry.chambers,
        parameters: entry.parameters.iter().map(parameter).collect(),
        checks: entry.checks.iter().map(check).collect(),
    }
}

fn text(rows: &[Row]) -> String {
    let mut out = String::new();
    for row in rows {
        // Writing to a String cannot fail.
        let _ = writeln!(out, "{} / {} / {}  ({})", row.actuator, row.quantity, row.form, row.kind);
        let _ = writeln!(out, "  equation  {}", row.equation);
        let _ = writeln!(out, "  source    {}", row.source);
        let _ = writeln!(out, "  range     {}", row.range);
        for misprint in row.misprints {
            let label = if row.kind == "printed" { "misprint" } else { "note" };
            let _ = writeln!(out, "  {label:<9} {misprint}");
        }
        let names: Vec<&str> = row.parameters.iter().map(|p| p.name).collect();
        let _ = writeln!(out, "  inputs    {}", names.join(", "));
        for check in &row.checks {
            let computed = check.computed.map_or("no value".to_owned(), |value| format!("{value}"));
            let mark = if check.holds { "holds" } else { "FAILS" };
            let _ = writeln!(
                out,
                "  check     {}: {} ± {:e} {}; computed {computed}: {mark}",
                check.statement, check.expected, check.tolerance, check.unit
            );
        }
        out.push('\n');
    }
    out
}
