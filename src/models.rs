//! `pneuval models`: the catalogue, its check values computed on the spot.

use std::fmt::Write as _;

use serde::Serialize;

use pneuval_ingest::error::suggestion;
use pneuval_models::catalogue::{self, Check, Entry, Unevaluable};

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
    /// Names of the components; empty for a scalar.
    components: &'static [&'static str],
    parameters: Vec<ParameterRow>,
    /// Inputs beside the pressure at each point of a table.
    conditions: Vec<ParameterRow>,
    checks: Vec<CheckRow>,
}

/// Printed equations without a form, in the same list: `unevaluable` is true there and absent elsewhere.
#[derive(Serialize)]
struct UnevaluableRow {
    unevaluable: bool,
    actuator: &'static str,
    equations: &'static str,
    source: &'static str,
    why: &'static [&'static str],
    /// Empty, so that whoever goes through the checks of all rows may do so.
    checks: [CheckRow; 0],
}

/// A row of the list: forms first, then what cannot be evaluated.
#[derive(Serialize)]
#[serde(untagged)]
enum Listed<'a> {
    Form(&'a Row),
    Unevaluable(UnevaluableRow),
}

#[derive(Serialize)]
struct ParameterRow {
    name: &'static str,
    si_unit: &'static str,
    meaning: &'static str,
}

/// A check value and what it comes out as here and now.
#[derive(Serialize)]
pub struct CheckRow {
    pub statement: &'static str,
    pub expected: f64,
    pub tolerance: f64,
    pub unit: &'static str,
    pub computed: Option<f64>,
    pub holds: bool,
}

impl CheckRow {
    pub fn of(check: &Check) -> Self {
        let computed = (check.compute)().ok();
        Self {
            statement: check.statement,
            expected: check.expected,
            tolerance: check.tolerance,
            unit: check.unit,
            computed,
            holds: computed.is_some_and(|value| (value - check.expected).abs() <= check.tolerance),
        }
    }

    /// Whether it holds, in a word.
    pub fn mark(&self) -> &'static str {
        if self.holds { "holds" } else { "FAILS" }
    }
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
    let wanted = |u: &&Unevaluable| arguments.actuator.as_ref().is_none_or(|actuator| u.actuator == actuator);
    let unevaluable = catalogue::unevaluable().iter().filter(wanted);
    if arguments.json {
        let unevaluable = unevaluable.map(UnevaluableRow::of).map(Listed::Unevaluable);
        let listed: Vec<Listed> = rows.iter().map(Listed::Form).chain(unevaluable).collect();
        output::print_json(&listed)?;
    } else {
        let unevaluable: String = unevaluable.map(reasons).collect();
        output::print(&(text(&rows) + &unevaluable))?;
    }
    Ok(Outcome::Expected)
}

impl UnevaluableRow {
    fn of(of: &Unevaluable) -> Self {
        let Unevaluable { actuator, equations, source, why, .. } = *of;
        Self { unevaluable: true, actuator, equations, source, why, checks: [] }
    }
}

fn row(entry: &'static Entry) -> Row {
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
        components: entry.components,
        parameters: entry.parameters.iter().map(parameter).collect(),
        conditions: entry.conditions.iter().map(parameter).collect(),
        checks: entry.checks.iter().map(CheckRow::of).collect(),
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
        for (label, names) in [
            ("values", row.components.to_vec()),
            ("inputs", row.parameters.iter().map(|p| p.name).collect()),
            ("per point", row.conditions.iter().map(|p| p.name).collect()),
        ] {
            if !names.is_empty() {
                let _ = writeln!(out, "  {label:<9} {}", names.join(", "));
            }
        }
        for check in &row.checks {
            let computed = check.computed.map_or("no value".to_owned(), |value| format!("{value}"));
            let _ = writeln!(
                out,
                "  check     {}: {} ± {:e} {}; computed {computed}: {}",
                check.statement,
                check.expected,
                check.tolerance,
                check.unit,
                check.mark()
            );
        }
        out.push('\n');
    }
    out
}

/// Printed equations without a form, and why.
fn reasons(unevaluable: &Unevaluable) -> String {
    let mut out = format!("{} / {}  (not evaluable)\n", unevaluable.actuator, unevaluable.equations);
    // Writing to a String cannot fail.
    let _ = writeln!(out, "  source    {}", unevaluable.source);
    for why in unevaluable.why {
        let _ = writeln!(out, "  why       {why}");
    }
    out + "\n"
}
