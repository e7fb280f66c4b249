//! `pneuval fit actuator`.

use std::fmt::Write as _;
use std::path::Path;

use pneuval_analysis::bounds::Bounds;
use pneuval_analysis::fit::actuator::{ActuatorFit, Errors, FileValue, LeaveOut, Reading, Task, fit, readings};
use pneuval_analysis::fit::estimate::Identified;
use pneuval_analysis::prediction::inputs;
use pneuval_analysis::study::{BoundsScope, Data, Input, Study, suits};
use pneuval_datasets::Found;
use pneuval_ingest::IngestError;
use pneuval_ingest::error::suggestion;
use pneuval_ingest::manifest::{Actuator, Quantity};
use pneuval_ingest::units::{Dimension, Unit};
use pneuval_models::catalogue::{self, Entry};

use super::arguments::FitActuator;
use super::material::toml_text;
use super::words;
use crate::exit::{Failure, Outcome};
use crate::predict::amount;
use crate::validate::data_of;
use crate::{output, table};

pub fn run(arguments: &FitActuator) -> Result<Outcome, Failure> {
    let inputs_found: Vec<Input> = found(arguments)?.into_iter().map(input).collect();
    let studies = inputs_found.iter().map(Study::of).collect::<Result<Vec<_>, _>>()?;
    // At least one: a path without data is an error before this.
    let Some(first) = studies.first() else { return Ok(Outcome::Open) };
    let actuator = &first.input.actuator;
    if let Some(other) = studies.iter().find(|study| study.input.actuator.sha256 != actuator.sha256) {
        return Err(flag(
            "PATHS",
            &other.input.actuator.id,
            format!("data of one actuator, {}", actuator.id),
            "fit one actuator at a time",
        ));
    }
    let (entry, quantity) = chosen(arguments, &studies, actuator)?;
    let mut all: Vec<Reading> = Vec::new();
    let mut conditions = None;
    for study in &studies {
        let Some(response) = study.response(&quantity.id) else { continue };
        if !suits(entry, response) {
            let expected = format!("a response of {}, chambers {}", entry.quantity_si_unit, entry.chambers.join(", "));
            return Err(flag(
                "--form",
                entry.form,
                expected,
                "the form does not predict what was measured: choose another",
            ));
        }
        let is_column = response.columns.iter().any(|column| column.form == arguments.to);
        if arguments.to != "measured" && !is_column {
            let known = || response.columns.iter().map(|column| column.form.as_str()).chain(["measured"]);
            let next = suggestion(&arguments.to, known());
            return Err(flag("--to", &arguments.to, known().collect::<Vec<_>>().join(", "), &next));
        }
        all.extend(readings(study.id, response, &arguments.to, specimen(study)));
        conditions = conditions.or(Some(response.conditions.as_slice()));
    }
    choose(&mut all, arguments)?;
    let (values, _) = inputs(entry, actuator)?;
    for name in &arguments.parameters {
        if !entry.parameters.iter().any(|p| p.name == name) {
            let known = || entry.parameters.iter().map(|p| p.name);
            return Err(flag("--parameters", name, known().collect::<Vec<_>>().join(", "), &suggestion(name, known())));
        }
    }
    let task = Task {
        actuator,
        entry,
        inputs: values,
        conditions: conditions.unwrap_or_default(),
        quantity,
        parameters: arguments.parameters.clone(),
        readings: all,
        priors: !arguments.no_priors,
        starts: arguments.search.starts(9),
        confidence: arguments.search.confidence,
    };
    let fitted = fit(&task).map_err(|source| Failure::Fit { form: entry.form.to_owned(), source })?;
    if let Some(path) = &arguments.write {
        write(path, actuator, &fitted)?;
    }
    if arguments.json {
        output::print_json(&fitted)?;
    } else {
        output::print(&text(&fitted, quantity))?;
    }
    let determined = |identified| !matches!(identified, Identified::Not | Identified::Unknown);
    Ok(if fitted.estimates.parameters.iter().all(|p| determined(p.identified)) {
        Outcome::Expected
    } else {
        Outcome::Open
    })
}

fn flag(flag: &'static str, found: &str, expected: String, next: &str) -> Failure {
    Failure::Flag { flag, found: format!("`{found}`"), expected, next: next.to_owned() }
}

/// The data of the paths; a path that is none may be the id of an embedded paper.
fn found(arguments: &FitActuator) -> Result<Vec<Found>, Failure> {
    if let [id] = arguments.paths.as_slice()
        && !id.exists()
        && let Some(id) = id.to_str().filter(|id| pneuval_datasets::embedded_datasets().any(|known| known == *id))
    {
        return Ok(pneuval_datasets::find(&[])?.into_iter().filter(|found| found.data.id() == id).collect());
    }
    Ok(pneuval_datasets::find(&arguments.paths)?)
}

fn input(found: Found) -> Input {
    Input {
        file: found.file,
        data: data_of(found.data),
        actuator: found.actuator,
        actuator_path: found.actuator_file,
        bounds: Bounds::default(),
        bounds_source: None,
        bounds_scope: BoundsScope::Shared,
    }
}

/// The specimen of a session, if it says which.
fn specimen<'a>(study: &'a Study) -> Option<&'a str> {
    match &study.input.data {
        Data::Session(session) => Some(session.manifest.specimen.as_ref()?.serial.as_str()),
        Data::Published(_) => None,
    }
}

/// The form and the quantity: as said, or the only ones there are.
fn chosen<'a>(
    arguments: &FitActuator,
    studies: &'a [Study],
    actuator: &Actuator,
) -> Result<(&'static Entry, &'a Quantity), Failure> {
    let quantities: Vec<&Quantity> = studies.iter().flat_map(|s| &s.responses).map(|r| &r.quantity).collect();
    let is_meant = |id: &str| arguments.quantity.as_deref().is_none_or(|asked| asked == id);
    let forms: Vec<&'static Entry> = catalogue::entries()
        .filter(|entry| entry.actuator == actuator.kind && is_meant(entry.quantity))
        .filter(|entry| quantities.iter().any(|quantity| quantity.id == entry.quantity))
        .filter(|entry| {
            arguments.parameters.iter().all(|name| entry.parameters.iter().any(|p| p.name == name))
                || arguments.form.is_some()
        })
        .filter(|entry| arguments.form.as_deref().is_none_or(|asked| asked == entry.form))
        .collect();
    let known: Vec<String> = catalogue::entries()
        .filter(|entry| entry.actuator == actuator.kind)
        .map(|entry| format!("{} {}", entry.quantity, entry.form))
        .collect();
    let wrong = |found: &str, next: &str| flag("--form", found, format!("one of: {}", known.join("; ")), next);
    match forms.as_slice() {
        [entry] => {
            let quantity = quantities.into_iter().find(|quantity| quantity.id == entry.quantity);
            // It was chosen for having one.
            quantity.map(|quantity| (*entry, quantity)).ok_or_else(|| wrong(entry.quantity, "measure it"))
        }
        [] => Err(wrong(
            arguments.form.as_deref().unwrap_or("none"),
            "no form of that name predicts a measured quantity from these parameters: correct --form, --quantity or --parameters",
        )),
        several => {
            let names: Vec<String> = several.iter().map(|e| format!("{} {}", e.quantity, e.form)).collect();
            Err(wrong(&names.join("; "), "several would do: name one with --form and --quantity"))
        }
    }
}

/// Keeps readings from the fit, as asked.
fn choose(readings: &mut [Reading], arguments: &FitActuator) -> Result<(), Failure> {
    for run in &arguments.runs {
        let known: Vec<&str> = readings.iter().map(|r| r.run.as_str()).collect();
        if !known.iter().any(|label| names(label, run)) {
            let mut known: Vec<&str> = known;
            known.dedup();
            return Err(flag("--runs", run, known.join(", "), "name runs that were read"));
        }
    }
    let limit = match &arguments.pressure_max {
        None => f64::INFINITY,
        Some(text) => {
            let unit = amount(text.trim()).and_then(|(value, symbol)| {
                Unit::parse(symbol).filter(|unit| unit.dimension == Dimension::Pressure).map(|unit| unit.to_si(value))
            });
            unit.ok_or_else(|| {
                flag("--pressure-max", text, "a gauge pressure with unit, such as 30 kPa".to_owned(), "write one")
            })?
        }
    };
    for reading in readings {
        let in_runs = arguments.runs.is_empty() || arguments.runs.iter().any(|run| names(&reading.run, run));
        // What conversion leaves of a limit is the limit.
        reading.fitted = in_runs && reading.pressures_gauge_pa.iter().all(|p| *p <= limit * (1.0 + 1e-9));
    }
    Ok(())
}

/// Whether a label `dataset/quantity run` is of a run.
fn names(label: &str, run: &str) -> bool {
    label == run || label.strip_suffix(run).is_some_and(|rest| rest.ends_with(' '))
}

fn text(fitted: &ActuatorFit, quantity: &Quantity) -> String {
    let unit = quantity.unit;
    let shown = |si: f64| format!("{} {}", table::number(unit.from_si(si)), unit.symbol);
    let errors = |errors: &Errors| match (errors.rmse, errors.max_abs) {
        (Some(rmse), Some(max)) => {
            format!("RMSE {}, max |e| {}, n {}/{}", shown(rmse), shown(max), errors.n_used, errors.n_available)
        }
        _ => format!("no prediction, n 0/{}", errors.n_available),
    };
    let mut out = format!("{} / {} / {}\n", fitted.actuator, fitted.quantity, fitted.form);
    // Writing to a String cannot fail, here and below.
    let _ = writeln!(out, "fitted on {}\n", fitted.fitted_on.join(", "));
    let units: Vec<(&str, &'static str, f64)> =
        fitted.file.iter().map(|v| (v.name.as_str(), v.unit, v.unit_si)).collect();
    out += &words::estimates(&fitted.estimates, &units);
    out += &file(fitted);
    let _ = writeln!(out, "\nin sample     {} (how well it fits, not how well it predicts)", errors(&fitted.in_sample));
    if let Some(held_out) = &fitted.held_out {
        let _ = writeln!(out, "kept from it  {}", errors(held_out));
        for reading in fitted.readings.iter().filter(|r| !r.fitted) {
            let pressures: Vec<String> = reading.pressures_gauge_pa.iter().map(|p| table::number(1e-3 * p)).collect();
            let list = |values: &[f64]| values.iter().map(|v| shown(*v)).collect::<Vec<_>>().join(", ");
            let predicted = reading.predicted.as_deref().map_or("no prediction".to_owned(), list);
            let _ = writeln!(
                out,
                "              {} kPa: predicted {predicted}, there {}",
                pressures.join(", "),
                list(&reading.measured)
            );
        }
    }
    for left_out in &fitted.left_out {
        let _ = writeln!(out, "\neach {} predicted by a fit to the others: {}", left_out.by, errors(&left_out.errors));
        out += &groups(fitted, left_out, &units, &shown);
    }
    if fitted.left_out.is_empty() {
        out += "\nnothing can be left out: one pressure, one run\n";
    }
    out
}

/// Left-out groups with their errors and the parameters of the fit to the others.
fn groups(fitted: &ActuatorFit, left_out: &LeaveOut, units: words::Units, shown: &dyn Fn(f64) -> String) -> String {
    let names: Vec<&str> = fitted.estimates.parameters.iter().map(|p| p.name.as_str()).collect();
    let headers: Vec<&str> = ["left out", "n", "RMSE", "max |e|"].into_iter().chain(names.iter().copied()).collect();
    let right: Vec<usize> = (1..headers.len()).collect();
    let mut rows = table::plain(&headers, &right);
    for group in &left_out.groups {
        let number = |value: Option<f64>| value.map_or("–".to_owned(), shown);
        let mut row = vec![
            group.group.clone(),
            format!("{}/{}", group.errors.n_used, group.errors.n_available),
            number(group.errors.rmse),
            number(group.errors.max_abs),
        ];
        match &group.parameters {
            Some(values) => row.extend(names.iter().zip(values).map(|(name, value)| {
                let unit = units.iter().find(|u| u.0 == *name);
                unit.map_or(table::number(*value), |u| format!("{} {}", table::number(value / u.2), u.1))
            })),
            None => row.push(group.why.clone().unwrap_or_default()),
        }
        rows.add_row(row);
    }
    table::fit(&mut rows);
    format!("{}\n", rows.trim_fmt())
}

/// What the actuator file says, against the fit.
fn file(fitted: &ActuatorFit) -> String {
    let mut out = String::new();
    for value in &fitted.file {
        let FileValue { name, unit, unit_si, value, origin, .. } = value;
        let away = fitted.file.iter().find(|v| v.name == *name).and_then(|v| v.standard_errors_away);
        let inside = fitted.file.iter().find(|v| v.name == *name).and_then(|v| v.in_interval);
        let told = match (inside, away) {
            (Some(true), Some(away)) => {
                format!("inside the interval, {} standard errors from the fit", table::number(round(away.abs())))
            }
            (Some(false), Some(away)) => {
                format!("outside the interval, {} standard errors from the fit", table::number(round(away.abs())))
            }
            _ => "nothing says how far that is from the fit".to_owned(),
        };
        let _ = writeln!(out, "in the file   {name} = {} {unit}, {origin}: {told}", table::number(value / unit_si));
    }
    let jointly = &fitted.file_jointly;
    let names: Vec<String> =
        fitted.file.iter().map(|v| format!("{} = {} {}", v.name, table::number(v.value / v.unit_si), v.unit)).collect();
    if names.is_empty() {
        return out;
    }
    let told = match (jointly.probability, jointly.sum_of_squares, &jointly.refused) {
        (_, _, Some(why)) => {
            format!("outside any credible interval: with them the model has no value at what was measured ({why})")
        }
        (Some(p), _, _) if p < 1e-4 => format!(
            "outside any credible interval: if they were right, readings as far from them would come by chance once in {} times (F test)",
            table::number(round(1.0 / p.max(1e-300)))
        ),
        (Some(p), _, _) => format!(
            "if they were right, readings as far from them would come by chance with probability {} (F test)",
            table::number(round(p))
        ),
        _ => "no scatter to judge by".to_owned(),
    };
    let _ = writeln!(out, "together      {}: {told}", names.join(", "));
    out
}

/// Three digits are enough to read.
fn round(value: f64) -> f64 {
    format!("{value:.2e}").parse().unwrap_or(value)
}

/// The actuator file with the fitted values in the place of its own.
fn write(path: &Path, actuator: &Actuator, fitted: &ActuatorFit) -> Result<(), Failure> {
    let text = pneuval_datasets::actuator_text(actuator)?;
    let mut lines: Vec<String> = text.lines().map(str::to_owned).collect();
    for estimate in &fitted.estimates.parameters {
        let Some(value) = actuator.values.get(&estimate.name) else { continue };
        let line = lines.get_mut(value.line - 1);
        // Of several materials the constants are `<material>_<constant>`; the key in the file is the last part.
        let key = line
            .as_ref()
            .and_then(|line| line.split_once('='))
            .map(|(key, rest)| (key.trim_end().to_owned(), rest.trim_start().starts_with('{')));
        let (Some(line), Some((key, true))) = (line, key) else {
            return Err(flag(
                "--write",
                &estimate.name,
                format!("`{} = {{ value = …, unit = … }}` on one line of {}", estimate.name, actuator.file),
                "write the value on one line",
            ));
        };
        let factor = value.unit.factor;
        let std = estimate.std.map_or(String::new(), |std| format!(", std = {}", number(std / factor)));
        let runs: Vec<String> = fitted.fitted_on.iter().map(|run| toml_text(run)).collect();
        *line = format!(
            "{key} = {{ value = {}, unit = \"{}\"{std}, source = \"calibrated\", place = {}, fitted_on = [{}] }}",
            number(estimate.value / factor),
            value.unit.symbol,
            toml_text(&format!("pneuval fit actuator, form {}, {}", fitted.form, fitted.quantity)),
            runs.join(", ")
        );
    }
    std::fs::write(path, lines.join("\n") + "\n").map_err(|source| IngestError::write(path, source))?;
    output::tell(&format!("wrote {}", path.display()));
    Ok(())
}

/// A number as TOML has it, with a point.
fn number(value: f64) -> String {
    let text = format!("{value:?}");
    if text.contains(['.', 'e']) { text } else { format!("{text}.0") }
}
