//! Sentences of a dataset with placeholders, filled in from computed and printed numbers.

use std::collections::BTreeMap;

use minijinja::{Environment, UndefinedBehavior, context};

use pneuval_ingest::manifest::ComparisonSpec;
use pneuval_ingest::units::Unit;

use crate::AnalysisError;
use crate::format;
use crate::response::Response;
use crate::results::Comparison;
use crate::study::Study;

/// The remark of a comparison with its placeholders filled in.
///
/// # Errors
/// [`AnalysisError::Remark`] for a placeholder that stands for nothing.
pub fn remark(
    study: &Study,
    spec: &ComparisonSpec,
    response: &Response,
    comparison: &Comparison,
) -> Result<Option<String>, AnalysisError> {
    let Some(template) = &spec.remark else { return Ok(None) };
    let unit = response.quantity.unit;
    let value = |values: &Option<Vec<f64>>, missing: &str| match values.as_deref() {
        None => missing.to_owned(),
        Some([one]) => format::quantity(*one, unit, 2),
        Some(many) => {
            let numbers: Vec<String> = many.iter().map(|v| format::fixed(unit.from_si(*v), 2)).collect();
            format::with_unit(&format!("({})", numbers.join(", ")), unit)
        }
    };
    let points = &comparison.points;
    let predicted: Vec<String> = points.iter().map(|p| value(&p.predicted, "no prediction")).collect();
    let measured: Vec<String> = points.iter().map(|p| value(&p.measured, "no value")).collect();
    let printed: BTreeMap<String, Vec<String>> = response.texts.iter().cloned().collect();
    let mut fit = BTreeMap::new();
    if let Some(record) = &comparison.fit {
        for parameter in &record.parameters {
            let text = Unit::parse(&parameter.unit).map_or_else(
                || format::significant(parameter.value_si, 3),
                |unit| format::with_unit(&format::significant(unit.from_si(parameter.value_si), 3), unit),
            );
            fit.insert(parameter.name.clone(), text);
        }
        fit.insert("rmse".to_owned(), format::with_unit(&format::significant(unit.from_si(record.rmse_si), 2), unit));
    }
    // A fit that the data refused has no parameters; its remark is no mistake.
    if let (Some(spec), None) = (&spec.fit, &comparison.fit) {
        let names = spec.parameters.iter().map(String::as_str).chain(["rmse"]);
        fit.extend(names.map(|name| (name.to_owned(), "no value".to_owned())));
    }
    let inputs = &study.input.actuator.values;
    let inputs: BTreeMap<String, String> = inputs
        .iter()
        .map(|(name, v)| (name.clone(), format::with_unit(&format::short(v.unit.from_si(v.si)), v.unit)))
        .collect();
    let mut environment = Environment::new();
    environment.set_undefined_behavior(UndefinedBehavior::Strict);
    // Placeholders cost a few units each; a loop would not be one.
    environment.set_fuel(Some(10_000));
    let text = environment.render_str(template, context! { predicted, measured, printed, fit, inputs });
    text.map(Some).map_err(|error| AnalysisError::Remark {
        file: study.input.file.clone(),
        line: spec.line,
        message: error.detail().map_or_else(|| error.kind().to_string(), str::to_owned),
    })
}
