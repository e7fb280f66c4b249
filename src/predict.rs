//! `pneuval predict`: what the models say over pressure.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::Path;

use serde::Serialize;

use pneuval_analysis::{format, prediction};
use pneuval_ingest::document::{Origin, Value};
use pneuval_ingest::error::suggestion;
use pneuval_ingest::manifest::Actuator;
use pneuval_ingest::number;
use pneuval_ingest::units::{Dimension, Unit};
use pneuval_models::catalogue::{self, Entry, Parameter};

use crate::cli::Predict;
use crate::exit::{Failure, Outcome};
use crate::{output, table};

/// One quantity: pressures down, forms across.
#[derive(Serialize)]
struct Block {
    actuator: String,
    quantity: &'static str,
    si_unit: &'static str,
    chambers: &'static [&'static str],
    pressures_gauge_pa: Vec<Vec<f64>>,
    forms: Vec<Form>,
}

#[derive(Serialize)]
struct Form {
    form: &'static str,
    kind: &'static str,
    /// Which component, for a quantity of several.
    component: Option<&'static str>,
    predicted_si: Vec<Option<f64>>,
    /// Why a value is missing, for the first pressure where it is.
    no_solution: Option<String>,
    rests_on: Vec<String>,
    /// What `--with` gave that the form takes.
    with: Vec<String>,
}

/// `held_angle = 30 deg` of `--with`: a condition or a parameter.
pub struct Given {
    pub name: String,
    pub si: f64,
    pub unit: Unit,
}

pub fn run(arguments: &Predict) -> Result<Outcome, Failure> {
    let mut actuator = pneuval_datasets::find_actuator(&arguments.actuator, Path::new("."))?;
    let entries = select(arguments, &actuator)?;
    let asked = arguments.at.iter().map(|text| pressures(text)).collect::<Result<Vec<_>, Failure>>()?;
    let given = arguments.with.iter().map(|text| given(text)).collect::<Result<Vec<_>, Failure>>()?;
    check_given(&given, &entries)?;
    // What is given takes the place of what the file says, and nothing rests on the file's value any more.
    for g in &given {
        let value = Value {
            si: g.si,
            std_si: None,
            unit: g.unit,
            origin: Origin::Published,
            place: None,
            fitted_on: vec![],
            line: 0,
        };
        actuator.values.insert(g.name.clone(), value);
    }
    let mut blocks: Vec<Block> = Vec::new();
    for entry in entries {
        if blocks.last().is_none_or(|b| b.quantity != entry.quantity) {
            blocks.push(Block {
                actuator: actuator.id.clone(),
                quantity: entry.quantity,
                si_unit: entry.quantity_si_unit,
                chambers: entry.chambers,
                pressures_gauge_pa: points(arguments, &asked, entry, &actuator)?,
                forms: vec![],
            });
        }
        if let Some(block) = blocks.last_mut() {
            block.forms.extend(predict(entry, &actuator, &block.pressures_gauge_pa, &given)?);
        }
    }
    if arguments.json {
        output::print_json(&blocks)?;
    } else {
        output::print(&blocks.iter().map(text).collect::<String>())?;
    }
    Ok(Outcome::Expected)
}

/// The catalogue entries the flags ask for.
fn select(arguments: &Predict, actuator: &Actuator) -> Result<Vec<&'static Entry>, Failure> {
    let of_type: Vec<&'static Entry> = catalogue::entries().filter(|e| e.actuator == actuator.kind).collect();
    if of_type.is_empty() {
        let mut known: Vec<&str> = catalogue::entries().map(|e| e.actuator).collect();
        known.dedup();
        return Err(flag("type of the actuator", &actuator.kind, &known));
    }
    let known: Vec<&str> = of_type.iter().map(|e| e.quantity).collect();
    let mut chosen = of_type;
    if let Some(quantity) = &arguments.quantity {
        chosen.retain(|e| e.quantity == quantity);
        if chosen.is_empty() {
            return Err(flag("--quantity", quantity, &known));
        }
    }
    if let Some(form) = &arguments.form {
        let known: Vec<&str> = chosen.iter().map(|e| e.form).collect();
        chosen.retain(|e| e.form == form);
        if chosen.is_empty() {
            return Err(flag("--form", form, &known));
        }
    }
    Ok(chosen)
}

fn flag(flag: &'static str, found: &str, known: &[&str]) -> Failure {
    let mut known = known.to_vec();
    known.dedup();
    Failure::Flag {
        flag,
        found: format!("`{found}`"),
        expected: known.join(", "),
        next: suggestion(found, known.iter().copied()),
    }
}

/// `40 kPa` or `40 kPa, 50 kPa`: gauge pressures in Pa.
pub fn pressures(text: &str) -> Result<Vec<f64>, Failure> {
    let wrong = |next: String| Failure::Flag {
        flag: "--at",
        found: format!("`{text}`"),
        expected: "gauge pressures with unit, one per chamber, such as \"40 kPa, 50 kPa\"".to_owned(),
        next,
    };
    text.split(',')
        .map(|part| {
            let part = part.trim();
            let (value, symbol) =
                amount(part).ok_or_else(|| wrong(format!("`{part}` does not start with a number")))?;
            match Unit::parse(symbol) {
                Some(unit) if unit.dimension == Dimension::Pressure => Ok(unit.to_si(value)),
                Some(_) => Err(wrong(format!("`{symbol}` is not a pressure"))),
                None if symbol.is_empty() => Err(wrong(format!("write `{part} kPa`, say"))),
                None => Err(wrong(format!("unit `{symbol}`: {}", Unit::suggestion(symbol)))),
            }
        })
        .collect()
}

/// A number and what stands behind it. The longest beginning that is a number is the number: `1e3 Pa` has an exponent, `1 Pa` has
/// none.
pub fn amount(text: &str) -> Option<(f64, &str)> {
    let ends = text.char_indices().map(|(i, _)| i).chain([text.len()]).rev();
    ends.map(|i| text.split_at(i)).find_map(|(digits, symbol)| {
        let value = number::parse(digits.trim_end()).map(|(value, _)| value)?;
        value.is_finite().then_some((value, symbol.trim()))
    })
}

/// A condition or a parameter in SI units, with the unit it was written in.
pub fn given(text: &str) -> Result<Given, Failure> {
    let wrong = |next: String| Failure::Flag {
        flag: "--with",
        found: format!("`{text}`"),
        expected: "a condition or a parameter with unit, such as \"held_angle = 30 deg\"".to_owned(),
        next,
    };
    let (name, value) = text.split_once('=').ok_or_else(|| wrong("write NAME = VALUE".to_owned()))?;
    let value = value.trim();
    let (value, symbol) = amount(value).ok_or_else(|| wrong(format!("`{value}` does not start with a number")))?;
    if symbol.is_empty() {
        return Err(wrong("write the unit behind the number".to_owned()));
    }
    let unit = Unit::parse(symbol).ok_or_else(|| wrong(format!("unit `{symbol}`: {}", Unit::suggestion(symbol))))?;
    Ok(Given { name: name.trim().to_owned(), si: unit.to_si(value), unit })
}

/// Everything given is a condition or a parameter of some form, in its unit, and given once.
fn check_given(given: &[Given], entries: &[&Entry]) -> Result<(), Failure> {
    let conditions = entries.iter().flat_map(|e| e.conditions);
    let mut known: Vec<&Parameter> = Vec::new();
    for parameter in conditions.chain(entries.iter().flat_map(|e| e.parameters)) {
        if known.iter().all(|k| k.name != parameter.name) {
            known.push(parameter);
        }
    }
    for (i, Given { name, unit, .. }) in given.iter().enumerate() {
        let Some(parameter) = known.iter().find(|p| p.name == name) else {
            return Err(flag("--with", name, &known.iter().map(|p| p.name).collect::<Vec<_>>()));
        };
        let wrong = |found: String, expected: String, next: &str| {
            Err(Failure::Flag { flag: "--with", found, expected, next: next.to_owned() })
        };
        if unit.dimension.si_symbol() != parameter.si_unit {
            let expected = format!("{}, in a unit of {}", parameter.meaning, parameter.si_unit);
            return wrong(format!("`{name}` in `{}`", unit.symbol), expected, "correct the unit");
        }
        if given[..i].iter().any(|other| other.name == *name) {
            return wrong(format!("`{name}` twice"), "every condition and parameter once".to_owned(), "remove one");
        }
    }
    Ok(())
}

/// The pressures of a quantity: those asked for, or steps from zero to full.
fn points(
    arguments: &Predict,
    asked: &[Vec<f64>],
    entry: &Entry,
    actuator: &Actuator,
) -> Result<Vec<Vec<f64>>, Failure> {
    if !asked.is_empty() {
        if let Some(wrong) = asked.iter().find(|p| p.len() != entry.chambers.len()) {
            return Err(Failure::Flag {
                flag: "--at",
                found: format!("{} pressure(s)", wrong.len()),
                expected: format!("{} for {}: {}", entry.chambers.len(), entry.quantity, entry.chambers.join(", ")),
                next: "choose one quantity with --quantity, and give one pressure per chamber".to_owned(),
            });
        }
        return Ok(asked.to_vec());
    }
    let full = entry.chambers.iter().map(|chamber| {
        actuator.chambers.get(*chamber).map(|c| c.pressure_gauge_max.si).ok_or_else(|| Failure::Flag {
            flag: "chamber",
            found: format!("`{chamber}` is not in {}", actuator.file),
            expected: format!("[chamber.{chamber}] with pressure_gauge_max"),
            next: "add it, or give the pressures with --at".to_owned(),
        })
    });
    let full = full.collect::<Result<Vec<f64>, Failure>>()?;
    let steps = f64::from(arguments.steps);
    Ok((0..=arguments.steps).map(|i| full.iter().map(|p| p * f64::from(i) / steps).collect()).collect())
}

/// The values of a form, one [`Form`] per component.
fn predict(
    entry: &'static Entry,
    actuator: &Actuator,
    pressures: &[Vec<f64>],
    given: &[Given],
) -> Result<Vec<Form>, Failure> {
    let (mut inputs, rests_on) = prediction::inputs(entry, actuator)?;
    let mut missing = Vec::new();
    for parameter in entry.conditions {
        match given.iter().find(|g| g.name == parameter.name) {
            Some(g) => inputs.set(parameter.name, g.si),
            None => missing.push(parameter.name),
        }
    }
    let values: Vec<Result<Vec<f64>, String>> = if missing.is_empty() {
        let model = prediction::build(entry, &inputs, actuator)?;
        pressures.iter().map(|p| model.predict(p).map_err(|error| error.to_string())).collect()
    } else {
        let why = format!("needs {}: give it with --with \"{} = …\"", missing.join(", "), missing[0]);
        pressures.iter().map(|_| Err(why.clone())).collect()
    };
    let takes = |g: &&Given| entry.conditions.iter().chain(entry.parameters).any(|p| p.name == g.name);
    let words = |g: &Given| format!("{} = {} {}", g.name, format::short(g.unit.from_si(g.si)), g.unit.symbol);
    let with: Vec<String> = given.iter().filter(takes).map(words).collect();
    let no_solution = values.iter().find_map(|v| v.as_ref().err().cloned());
    let components = if entry.components.is_empty() { vec![None] } else { entry.components.iter().map(Some).collect() };
    let of = |(index, component): (usize, Option<&&'static str>)| Form {
        form: entry.form,
        kind: entry.kind.name(),
        component: component.copied(),
        predicted_si: values.iter().map(|v| v.as_ref().ok().and_then(|v| v.get(index).copied())).collect(),
        no_solution: no_solution.clone(),
        rests_on: rests_on.clone(),
        with: with.clone(),
    };
    Ok(components.into_iter().enumerate().map(of).collect())
}

fn text(block: &Block) -> String {
    let unit = Unit::parse(block.si_unit).map_or(Dimension::Ratio, |u| u.dimension).display_unit();
    let kilopascal = Dimension::Pressure.display_unit();
    let mut headers: Vec<String> = block.chambers.iter().map(|c| format!("{c} / kPa")).collect();
    headers.extend(block.forms.iter().map(|f| f.component.map_or(f.form.to_owned(), |c| format!("{} {c}", f.form))));
    let right: Vec<usize> = (0..headers.len()).collect();
    let mut rows = table::plain(&headers, &right);
    for (i, pressures) in block.pressures_gauge_pa.iter().enumerate() {
        let mut cells: Vec<String> = pressures.iter().map(|p| format::short(kilopascal.from_si(*p))).collect();
        cells.extend(block.forms.iter().map(|f| {
            f.predicted_si[i]
                .map_or("no solution".to_owned(), |v| format::fixed(unit.from_si(v), format::error_decimals(unit)))
        }));
        rows.add_row(cells);
    }
    let mut out = format!("{} {} / {}\n{rows}\n", block.actuator, block.quantity, unit.symbol);
    let mut reasons: BTreeMap<&str, &str> = BTreeMap::new();
    for form in &block.forms {
        if let Some(why) = &form.no_solution {
            reasons.insert(form.form, why);
        }
        // Said once, although a form of several components has a column for each.
        let first = block.forms.iter().find(|f| f.form == form.form).is_some_and(|f| f.component == form.component);
        let said = |what: &str, list: &[String]| (!list.is_empty()).then(|| format!("{what} {}", list.join(", ")));
        let said: Vec<String> =
            [said("with", &form.with), said("rests on", &form.rests_on)].into_iter().flatten().collect();
        if first && !said.is_empty() {
            // Writing to a String cannot fail.
            let _ = writeln!(out, "{}: {}", form.form, said.join("; "));
        }
    }
    for (form, why) in reasons {
        let _ = writeln!(out, "{form}: {why}");
    }
    out + "\n"
}
