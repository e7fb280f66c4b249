//! `pneuval materials`: the hyperelastic laws, and what the papers' constants say in them.

use std::fmt::Write as _;
use std::path::Path;

use serde::Serialize;

use pneuval_analysis::format;
use pneuval_ingest::document::Value;
use pneuval_ingest::error::suggestion;
use pneuval_ingest::manifest::{Actuator, Material};
use pneuval_ingest::units::Dimension;
use pneuval_models::ModelError;
use pneuval_models::catalogue::{LAWS, LawEntry, Parameter, find_law};
use pneuval_models::materials::{EndReason, Hyperelastic, LoadCase, StableEnd};

use crate::cli::Materials;
use crate::exit::{Failure, Outcome};
use crate::models::CheckRow;
use crate::{output, table};

/// Stretches at which the papers' materials are compared.
const STRETCHES: [f64; 2] = [1.5, 2.0];
/// Stability is looked for between these stretches.
const STRETCH_MIN: f64 = 0.25;
const STRETCH_MAX: f64 = 4.0;

#[derive(Serialize)]
struct Listing {
    laws: Vec<LawRow>,
    materials: Vec<MaterialRow>,
}

#[derive(Serialize)]
struct LawRow {
    law: &'static str,
    title: &'static str,
    energy: &'static str,
    nominal_stress: Vec<FormulaRow>,
    shear_modulus: &'static str,
    range: &'static str,
    constants: Vec<ConstantRow>,
    source: &'static str,
    checks: Vec<CheckRow>,
}

#[derive(Serialize)]
struct FormulaRow {
    load_case: &'static str,
    formula: &'static str,
}

#[derive(Serialize)]
struct ConstantRow {
    name: &'static str,
    si_unit: &'static str,
    required: bool,
    meaning: &'static str,
}

/// A material of a paper.
#[derive(Serialize)]
struct MaterialRow {
    actuator: String,
    material: String,
    file: String,
    law: &'static str,
    constants: Vec<ValueRow>,
    shear_modulus_pa: Option<f64>,
    load_cases: Vec<CaseRow>,
    /// Why the constants are no material of this law.
    refused: Option<String>,
}

#[derive(Serialize)]
struct ValueRow {
    name: String,
    value_si: f64,
    si_unit: &'static str,
    written: String,
    source: &'static str,
    place: Option<String>,
}

#[derive(Serialize)]
struct CaseRow {
    load_case: &'static str,
    nominal_stress: Vec<StressRow>,
    stable_from: EndRow,
    stable_to: EndRow,
}

#[derive(Serialize)]
struct StressRow {
    stretch: f64,
    nominal_stress_pa: Option<f64>,
}

#[derive(Serialize)]
struct EndRow {
    stretch: f64,
    why: &'static str,
}

pub fn run(arguments: &Materials) -> Result<Outcome, Failure> {
    let chosen = match &arguments.law {
        None => LAWS.iter().collect(),
        Some(id) => vec![find_law(id).ok_or_else(|| unknown_law(id))?],
    };
    let listing = Listing { laws: chosen.iter().map(|law| law_row(law)).collect(), materials: materials(&chosen)? };
    if arguments.json {
        output::print_json(&listing)?;
    } else {
        output::print(&text(&listing))?;
    }
    Ok(Outcome::Expected)
}

fn unknown_law(id: &str) -> Failure {
    let known: Vec<&str> = LAWS.iter().map(|law| law.id).collect();
    Failure::Flag {
        flag: "LAW",
        found: format!("`{id}`"),
        expected: known.join(", "),
        next: suggestion(id, known.iter().copied()),
    }
}

fn law_row(law: &LawEntry) -> LawRow {
    let formula = |(case, formula): (LoadCase, &'static str)| FormulaRow { load_case: case.name(), formula };
    let constant =
        |required| move |p: &Parameter| ConstantRow { name: p.name, si_unit: p.si_unit, required, meaning: p.meaning };
    LawRow {
        law: law.id,
        title: law.title,
        energy: law.energy,
        nominal_stress: LoadCase::ALL.into_iter().zip(law.nominal_stress).map(formula).collect(),
        shear_modulus: law.shear_modulus,
        range: law.range,
        constants: law.required.iter().map(constant(true)).chain(law.optional.iter().map(constant(false))).collect(),
        source: law.source,
        checks: law.checks.iter().map(CheckRow::of).collect(),
    }
}

/// The embedded actuators' materials of the chosen laws.
fn materials(chosen: &[&LawEntry]) -> Result<Vec<MaterialRow>, Failure> {
    let mut rows = Vec::new();
    for id in pneuval_datasets::embedded_actuators() {
        let actuator = pneuval_datasets::find_actuator(id, Path::new("."))?;
        for (id, material) in &actuator.materials {
            let law = chosen.iter().find(|law| law.id == material.law);
            rows.extend(law.map(|law| material_row(&actuator, id, material, law)));
        }
    }
    Ok(rows)
}

/// A material of an actuator, with all its constants: also those that its law does not take.
fn material_row(actuator: &Actuator, id: &str, material: &Material, law: &LawEntry) -> MaterialRow {
    let constant = |(name, key): (&String, &String)| actuator.values.get(key).map(|value| value_row(name, value));
    let constants: Vec<ValueRow> = material.constants.iter().filter_map(constant).collect();
    let mut row = MaterialRow {
        actuator: actuator.id.clone(),
        material: id.to_owned(),
        file: actuator.file.clone(),
        law: law.id,
        shear_modulus_pa: None,
        load_cases: vec![],
        refused: None,
        constants,
    };
    let built = law.build(&|name| row.constants.iter().find(|c| c.name == name).map(|c| c.value_si));
    match built.and_then(|built| {
        let cases = LoadCase::ALL.into_iter().map(|case| case_row(built.as_ref(), case));
        Ok((built.shear_modulus_pa(), cases.collect::<Result<Vec<CaseRow>, ModelError>>()?))
    }) {
        Ok((modulus, cases)) => (row.shear_modulus_pa, row.load_cases) = (Some(modulus), cases),
        Err(error) => row.refused = Some(error.to_string()),
    }
    row
}

fn value_row(name: &str, value: &Value) -> ValueRow {
    ValueRow {
        name: name.to_owned(),
        value_si: value.si,
        si_unit: value.unit.dimension.si_symbol(),
        written: format::with_unit(&format::short(value.unit.from_si(value.si)), value.unit),
        source: value.origin.name(),
        place: value.place.clone(),
    }
}

fn case_row(law: &dyn Hyperelastic, case: LoadCase) -> Result<CaseRow, ModelError> {
    let range = law.stable_range(case, STRETCH_MIN, STRETCH_MAX)?;
    let stress = |stretch| StressRow { stretch, nominal_stress_pa: law.nominal_stress_pa(case, stretch).ok() };
    Ok(CaseRow {
        load_case: case.name(),
        nominal_stress: STRETCHES.into_iter().map(stress).collect(),
        stable_from: end_row(range.min),
        stable_to: end_row(range.max),
    })
}

fn end_row(end: StableEnd) -> EndRow {
    let why = match end.why {
        EndReason::AsFarAsAsked => "at-least",
        EndReason::Unstable => "unstable",
        EndReason::OutOfDomain => "law-ends",
    };
    EndRow { stretch: end.stretch, why }
}

const CASES: &str = "\
l: stretch, length over undeformed length. Nominal stress: force per undeformed area. Incompressible.

";

fn text(listing: &Listing) -> String {
    let mut out = format!("{CASES}{}\n\n", invariants().trim_fmt());
    for law in &listing.laws {
        // Writing to a String cannot fail.
        let _ = writeln!(out, "{}: {}\n{}\n", law.law, law.title, law_table(law).trim_fmt());
    }
    if listing.materials.is_empty() {
        return out + "No embedded paper gives constants of this law.\n";
    }
    // Writing to a String cannot fail.
    let _ = writeln!(
        out,
        "Materials of the papers\nStable: the stress rises with the stretch; looked for from {STRETCH_MIN} to {STRETCH_MAX}.\n"
    );
    for material in &listing.materials {
        out += &material_text(material);
    }
    out
}

/// What I1 and I2 are in each load case.
fn invariants() -> comfy_table::Table {
    let mut rows = table::plain(&["load case", "principal stretches", "I1-3", "I2-3"], &[]);
    rows.add_row(["uniaxial", "l, l^-1/2, l^-1/2", "l^2 + 2/l - 3", "2l + 1/l^2 - 3"]);
    rows.add_row(["planar", "l, 1, 1/l", "l^2 + 1/l^2 - 2", "l^2 + 1/l^2 - 2"]);
    rows.add_row(["equibiaxial", "l, l, l^-2", "2l^2 + 1/l^4 - 3", "l^4 + 2/l^2 - 3"]);
    rows
}

fn law_table(law: &LawRow) -> comfy_table::Table {
    let mut rows = table::plain(&["energy", law.energy], &[]);
    indent(&mut rows);
    let mut row = |label: &str, text: &str| {
        rows.add_row([label, text]);
    };
    row("modulus", &format!("initial shear modulus = {}", law.shear_modulus));
    for (i, stress) in law.nominal_stress.iter().enumerate() {
        row(if i == 0 { "stress" } else { "" }, &format!("{:<11}  {}", stress.load_case, stress.formula));
    }
    let width = law.constants.iter().map(|c| c.name.len()).max().unwrap_or(0);
    for (i, c) in law.constants.iter().enumerate() {
        let need = if c.required { "required" } else { "optional" };
        row(
            if i == 0 { "constants" } else { "" },
            &format!("{:width$}  {:<2}  {need}  {}", c.name, c.si_unit, c.meaning),
        );
    }
    row("range", law.range);
    row("source", law.source);
    for (i, check) in law.checks.iter().enumerate() {
        let number = |value| format::significant(value, 10);
        let computed = check.computed.map_or("no value".to_owned(), number);
        let expected = format!("{} {}", number(check.expected), check.unit);
        row(
            if i == 0 { "checks" } else { "" },
            &format!("{} = {}; computed {computed}: {}", check.statement, expected.trim_end(), check.mark()),
        );
    }
    table::fit(&mut rows);
    rows
}

/// Sets a table in from the line above it.
fn indent(rows: &mut comfy_table::Table) {
    if let Some(first) = rows.column_mut(0) {
        first.set_padding((2, 2));
    }
}

fn material_text(material: &MaterialRow) -> String {
    let mut out = format!("{}, {}: {} ({})\n", material.actuator, material.material, material.law, material.file);
    let mut constants = table::plain(&["constant", "value", "source", "place"], &[1]);
    for c in &material.constants {
        constants.add_row([c.name.as_str(), &c.written, c.source, c.place.as_deref().unwrap_or("")]);
    }
    indent(&mut constants);
    table::fit(&mut constants);
    // Writing to a String cannot fail.
    let _ = writeln!(out, "{}", constants.trim_fmt());
    if let Some(why) = &material.refused {
        let _ = writeln!(out, "  no material of this law: {why}");
    }
    if let Some(modulus) = material.shear_modulus_pa {
        let kilopascal = Dimension::Pressure.display_unit();
        let _ = writeln!(out, "  initial shear modulus: {}", format::quantity(modulus, kilopascal, 1));
        let at = |stretch: &f64| format!("stress at {stretch:?} / kPa");
        let headers: Vec<String> = ["load case".to_owned()]
            .into_iter()
            .chain(STRETCHES.iter().map(at))
            .chain(["stability".to_owned()])
            .collect();
        let mut cases = table::plain(&headers, &[1, 2]);
        for case in &material.load_cases {
            let stress = |s: &StressRow| {
                s.nominal_stress_pa.map_or("no value".to_owned(), |pa| format::fixed(kilopascal.from_si(pa), 1))
            };
            let mut cells = vec![case.load_case.to_owned()];
            cells.extend(case.nominal_stress.iter().map(stress));
            cells.push(stability(case));
            cases.add_row(cells);
        }
        indent(&mut cases);
        let _ = writeln!(out, "{}", cases.trim_fmt());
    }
    out + "\n"
}

/// Where the stress of a load case rises, in words.
fn stability(case: &CaseRow) -> String {
    let (min, max) = (&case.stable_from, &case.stable_to);
    let number = |stretch| format::significant(stretch, 4);
    let above = match max.why {
        "at-least" => format!("stable up to {} at least", number(max.stretch)),
        "unstable" => format!("unstable from {}", number(max.stretch)),
        _ => format!("stable up to {}, where the law ends", number(max.stretch)),
    };
    match min.why {
        "at-least" => above,
        _ => format!("{above}, and below {}", number(min.stretch)),
    }
}
