//! Response and prediction to comparison and verdict: the whole analysis of published datasets.

use std::collections::{BTreeMap, BTreeSet};

use minijinja::{Environment, UndefinedBehavior, context};

use pneuval_ingest::error::suggestion;
use pneuval_ingest::manifest::{Actuator, ComparisonSpec, FitSpec, PublishedDataset, PublishedTable};
use pneuval_ingest::number::Printed;
use pneuval_ingest::units::Unit;
use pneuval_models::ModelError;
use pneuval_models::catalogue::{self, Entry};
use pneuval_models::least_squares::Fit;

use crate::AnalysisError;
use crate::bounds::Bounds;
use crate::fit::calibrate;
use crate::format;
use crate::gate::{judge_comparison, notes, strangers};
use crate::metrics::{self, Interval, Metric, Pair};
use crate::prediction::{Predicted, Prediction, build, full_pressures, inputs, share};
use crate::response::{Response, ResponsePoint};
use crate::results::{
    ActuatorRecord, Comparison, DatasetRecord, FindingRecord, FitRecord, FittedParameter, InputRecord, ListingRecord,
    MetricRecord, Point, PointStatus, QuantityRecord, Results, SCHEMA_VERSION, SourceFile, StatedRecord,
};
use crate::series::Curve;
use crate::verdict::{Basis, Verdict};

/// A dataset with all that its comparisons need.
pub struct Input {
    /// `dataset.toml` as the user named it.
    pub file: String,
    /// The dataset.
    pub dataset: PublishedDataset,
    /// Its actuator.
    pub actuator: Actuator,
    /// The actuator file, relative to the dataset's folder.
    pub actuator_path: String,
    /// The bounds that apply, if any were found.
    pub bounds: Bounds,
    /// The bounds file, relative to the dataset's folder, with its digest.
    pub bounds_source: Option<SourceFile>,
    /// Whose bounds they are.
    pub bounds_scope: BoundsScope,
}

/// Whose bounds apply to a dataset: what a row that meets no comparison means.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BoundsScope {
    /// They lie beside the dataset: such a row is a mistake.
    Own,
    /// They lie above it, or were named: such a row may be meant for a dataset that is not here, and is told.
    Shared,
    /// They are the embedded ones: such a row is for the embedded papers.
    Embedded,
}

/// What `validate` computes: the numbers, and the curves behind the figures.
#[derive(Debug, Clone, PartialEq)]
pub struct Evaluation {
    /// The content of `results.json`.
    pub results: Results,
    /// The content of `series.parquet`.
    pub curves: Vec<Curve>,
}

/// Compares every prediction of every dataset with its measurement and judges it.
///
/// # Errors
/// [`AnalysisError`] for a comparison that cannot be posed: an unknown form, an input missing or in a wrong unit, a bound
/// beside the dataset that meets no comparison. A model without a solution is no error but a failed comparison.
pub fn validate(inputs: &[Input], report_only: bool) -> Result<Evaluation, AnalysisError> {
    let mut actuators: BTreeMap<String, ActuatorRecord> = BTreeMap::new();
    let mut comparisons = Vec::new();
    let mut curves = Vec::new();
    for input in inputs {
        for spec in &input.dataset.comparisons {
            let (comparison, curve) = compare(input, spec)?;
            curves.push(curve);
            comparisons.push(comparison);
        }
        if input.bounds_scope == BoundsScope::Own
            && let Some(error) = input.bounds.unused(&input.actuator.id, &posed(&input.dataset))
        {
            return Err(error.into());
        }
        let same = |other: &&Input| other.actuator.id == input.actuator.id;
        if let Some(other) = inputs.iter().find(same).filter(|o| o.actuator.sha256 != input.actuator.sha256) {
            return Err(AnalysisError::ActuatorConflict {
                id: input.actuator.id.clone(),
                file: input.actuator.file.clone(),
                other: other.actuator.file.clone(),
            });
        }
        let record = actuators.entry(input.actuator.id.clone()).or_insert_with(|| actuator_record(&input.actuator));
        record.datasets.push(dataset_record(input));
    }
    let results = Results {
        schema_version: SCHEMA_VERSION,
        program: concat!("pneuval ", env!("CARGO_PKG_VERSION")).to_owned(),
        metric_definitions: metrics::DEFINITIONS_VERSION,
        report_only,
        actuators: actuators.into_values().collect(),
        comparisons,
        findings: unused_bounds(inputs),
        files: BTreeMap::new(),
    };
    Ok(Evaluation { results, curves })
}

/// The comparisons of a dataset: quantity and form.
fn posed(dataset: &PublishedDataset) -> Vec<(String, String)> {
    dataset.comparisons.iter().map(|s| (s.quantity.clone(), s.form.clone())).collect()
}

/// Rows of bounds that judged nothing in the whole run.
fn unused_bounds(inputs: &[Input]) -> Vec<FindingRecord> {
    let mut texts = BTreeSet::new();
    for input in inputs.iter().filter(|input| input.bounds_scope != BoundsScope::Embedded) {
        let same = inputs.iter().filter(|other| other.actuator.id == input.actuator.id);
        let all: Vec<(String, String)> = same.flat_map(|other| posed(&other.dataset)).collect();
        texts.extend(input.bounds.unused_rows(&input.actuator.id, &all));
        let here: Vec<&str> = inputs.iter().map(|other| other.actuator.id.as_str()).collect();
        texts.extend(strangers(&input.bounds, &here));
    }
    texts.extend(inputs.iter().flat_map(|input| uncompared(&input.dataset)));
    notes(texts)
}

/// Tables and printed predictions that no comparison uses.
fn uncompared(dataset: &PublishedDataset) -> Vec<String> {
    let mut texts = Vec::new();
    for table in &dataset.tables {
        let compared = |form: &str| {
            let mut specs = dataset.comparisons.iter().filter(|s| s.quantity == table.quantity.id);
            specs.any(|s| s.form == form || s.fit.as_ref().is_some_and(|fit| fit.to == form))
        };
        if !dataset.comparisons.iter().any(|s| s.quantity == table.quantity.id) {
            texts.push(format!("table {} of {} is compared with nothing", table.file, dataset.id));
            continue;
        }
        let forms = table.predicted.iter().filter(|p| !compared(&p.form));
        texts.extend(
            forms.map(|p| format!("{} of table {} of {} is compared with nothing", p.form, table.file, dataset.id)),
        );
    }
    texts
}

fn compare(input: &Input, spec: &ComparisonSpec) -> Result<(Comparison, Curve), AnalysisError> {
    let Some(table) = input.dataset.table(&spec.quantity) else {
        // The dataset's reader refuses a comparison without its table.
        return Err(unknown_form(input, spec, []));
    };
    let response = Response::from(table);
    let (prediction, fit) = predict(input, spec, table, &response)?;
    let points = points(&response, &prediction);
    let bounds = input.bounds.of(&input.actuator.id, &spec.quantity, &spec.form, table.quantity.unit.dimension)?;
    let id = format!("{}/{}/{}", input.dataset.id, spec.quantity, spec.form);
    let n_without_prediction = points.iter().filter(|p| p.status == PointStatus::NoPrediction).count();
    let metrics = measure_all(&points, n_without_prediction);
    let mut comparison = Comparison {
        id: id.clone(),
        actuator: input.actuator.id.clone(),
        dataset: input.dataset.id.clone(),
        quantity: QuantityRecord {
            id: table.quantity.id.clone(),
            title: table.quantity.title.clone(),
            si_unit: table.quantity.unit.dimension.si_symbol().to_owned(),
            display_unit: table.quantity.unit.symbol.to_owned(),
        },
        form: prediction.form.clone(),
        title: spec.title.clone().unwrap_or_else(|| prediction.title.clone()),
        kind: prediction.kind.clone(),
        source: prediction.source.clone(),
        measured_source: format!("{}; {}", table.place, table.method),
        equation: prediction.equation.clone(),
        misprints: prediction.misprints.clone(),
        rests_on: prediction.rests_on.clone(),
        fit,
        basis: Basis::PublishedPoint,
        chambers: response.chambers.clone(),
        n_available: points.iter().filter(|p| p.status != PointStatus::HoleInPrint).count(),
        n_used: points.iter().filter(|p| p.status == PointStatus::Used).count(),
        n_without_prediction,
        points,
        metrics,
        judgements: vec![],
        verdict: Verdict::Unjudged,
        counted: true,
        sentence: String::new(),
        remark: None,
    };
    comparison.remark = remark(input, spec, table, &comparison)?;
    judge_comparison(&mut comparison, bounds, spec.not_judged.as_deref());
    Ok((comparison, Curve { comparison: id, points: prediction.curve }))
}

/// The prediction of a comparison: a printed column, or a catalogue form, perhaps calibrated first.
fn predict(
    input: &Input,
    spec: &ComparisonSpec,
    table: &PublishedTable,
    response: &Response,
) -> Result<(Prediction, Option<FitRecord>), AnalysisError> {
    if let Some(column) = table.predicted.iter().find(|p| p.form == spec.form) {
        return Ok((Prediction::published(table, column), None));
    }
    let actuator = &input.actuator;
    let model_form = spec.model.as_deref().unwrap_or(&spec.form);
    let forms = || catalogue::entries().filter(|e| e.actuator == actuator.kind && e.quantity == spec.quantity);
    let Some(entry) = forms().find(|e| e.form == model_form) else {
        return Err(unknown_form(input, spec, forms().map(|e| e.form)));
    };
    if entry.quantity_si_unit != table.quantity.unit.dimension.si_symbol() || entry.chambers != response.chambers {
        return Err(AnalysisError::Input {
            file: input.file.clone(),
            name: spec.quantity.clone(),
            expected: format!("a unit of {}, chambers {}", entry.quantity_si_unit, entry.chambers.join(", ")),
            found: format!("unit `{}`, chambers {}", table.quantity.unit.symbol, response.chambers.join(", ")),
        });
    }
    let (mut values, rests_on) = inputs(entry, actuator)?;
    let mut record = None;
    if let Some(fit) = &spec.fit {
        let (fitted, found, targets) = fit_column(input, spec, fit, entry, &values, table)?;
        record = Some(fit_record(input, fit, table, &found, targets));
        values = fitted;
    }
    let model = build(entry, &values, actuator)?;
    let prediction = Prediction::computed(&spec.form, entry, &model, rests_on, response);
    Ok((prediction, record))
}

fn unknown_form<'a>(
    input: &'a Input,
    spec: &ComparisonSpec,
    forms: impl IntoIterator<Item = &'a str>,
) -> AnalysisError {
    let table = input.dataset.table(&spec.quantity);
    let printed = table.into_iter().flat_map(|t| t.predicted.iter().map(|p| p.form.as_str()));
    let form = spec.model.as_deref().unwrap_or(&spec.form);
    AnalysisError::UnknownForm {
        file: input.file.clone(),
        line: spec.line,
        quantity: spec.quantity.clone(),
        form: form.to_owned(),
        next: suggestion(form, printed.chain(forms)),
    }
}

type Calibrated = (catalogue::Inputs, Fit, usize);

fn fit_column(
    input: &Input,
    spec: &ComparisonSpec,
    fit: &FitSpec,
    entry: &Entry,
    values: &catalogue::Inputs,
    table: &PublishedTable,
) -> Result<Calibrated, AnalysisError> {
    if let Some(name) = fit.parameters.iter().find(|name| !entry.parameters.iter().any(|p| p.name == name.as_str())) {
        return Err(AnalysisError::UnknownParameter {
            file: input.file.clone(),
            line: spec.line,
            form: entry.form.to_owned(),
            name: name.clone(),
            next: suggestion(name, entry.parameters.iter().map(|p| p.name)),
        });
    }
    let column = column_of(fit, table);
    let targets: Vec<(Vec<f64>, f64)> = table
        .pressures_gauge_pa
        .iter()
        .zip(column)
        // The zero-pressure reference holds for every material: it would count as a point without being one.
        .filter(|(pressures, _)| pressures.iter().any(|p| *p != 0.0))
        .filter_map(|(pressures, cell)| cell.map(|c| (pressures.clone(), c.si)))
        .collect();
    if let Some((_, value)) = targets.iter().find(|(_, value)| !value.is_finite()) {
        let source = ModelError::OutOfDomain { symbol: "value to fit", value: *value, domain: "finite" };
        return Err(AnalysisError::Fit { file: input.file.clone(), line: spec.line, form: spec.form.clone(), source });
    }
    let (fitted, found) = calibrate(entry, values, &fit.parameters, &targets).map_err(|source| AnalysisError::Fit {
        file: input.file.clone(),
        line: spec.line,
        form: spec.form.clone(),
        source,
    })?;
    Ok((fitted, found, targets.len()))
}

fn column_of<'a>(fit: &FitSpec, table: &'a PublishedTable) -> &'a [Option<Printed>] {
    let printed = table.predicted.iter().find(|p| p.form == fit.to);
    printed.map_or(&table.measured, |p| &p.cells)
}

fn fit_record(input: &Input, fit: &FitSpec, table: &PublishedTable, found: &Fit, n: usize) -> FitRecord {
    let parameters = fit
        .parameters
        .iter()
        .enumerate()
        .map(|(i, name)| FittedParameter {
            name: name.clone(),
            value_si: found.parameters[i],
            std_si: found.parameters_std.as_ref().map(|std| std[i]),
            unit: input.actuator.values.get(name).map_or("1", |v| v.unit.symbol).to_owned(),
        })
        .collect();
    FitRecord {
        fitted_on: vec![format!("{}/{} {}", input.dataset.id, table.quantity.id, fit.to)],
        parameters,
        rmse_si: found.rmse,
        n,
        condition_number: found.condition_number,
    }
}

/// Every point of the response with its prediction, and what becomes of it.
fn points(response: &Response, prediction: &Prediction) -> Vec<Point> {
    let pressures: Vec<Vec<f64>> = response.points.iter().map(|p| p.pressures_gauge_pa.clone()).collect();
    let full = full_pressures(&pressures);
    response.points.iter().zip(&prediction.at).map(|(measured, predicted)| point(measured, predicted, &full)).collect()
}

fn point(response: &ResponsePoint, predicted: &Predicted, full: &[f64]) -> Point {
    let finite = |printed: &Printed| printed.si.is_finite();
    let value = match predicted {
        Predicted::Value(printed) => Some(*printed),
        Predicted::NoSolution(_) | Predicted::Failed(_) | Predicted::NotPrinted => None,
    };
    let (status, reason) = if response.is_zero_reference() && response.measured.is_some() {
        let reason = match predicted {
            Predicted::Value(_) => "zero-pressure reference".to_owned(),
            Predicted::NoSolution(why) | Predicted::Failed(why) => format!("zero-pressure reference; {why}"),
            Predicted::NotPrinted => "zero-pressure reference; no predicted value is printed".to_owned(),
        };
        (PointStatus::ZeroReference, Some(reason))
    } else {
        match (response.measured, predicted) {
            (None, _) => (PointStatus::HoleInPrint, Some("no measured value is printed".to_owned())),
            (_, Predicted::NoSolution(why)) => (PointStatus::NoPrediction, Some(why.clone())),
            (_, Predicted::Failed(why)) => (PointStatus::NotFinite, Some(why.clone())),
            (_, Predicted::NotPrinted) => {
                (PointStatus::PredictionNotPrinted, Some("no predicted value is printed".to_owned()))
            }
            (Some(m), Predicted::Value(p)) if finite(&m) && finite(p) => (PointStatus::Used, None),
            (Some(m), Predicted::Value(_)) => {
                let which = if finite(&m) { "predicted" } else { "measured" };
                (PointStatus::NotFinite, Some(format!("the {which} value is not a finite number")))
            }
        }
    };
    let measured = response.measured.filter(finite);
    let predicted = value.filter(finite);
    Point {
        line: response.line,
        pressures_gauge_pa: response.pressures_gauge_pa.clone(),
        pressure_share: share(&response.pressures_gauge_pa, full),
        measured: measured.map(|m| m.si),
        measured_half_width: measured.map_or(0.0, |m| m.half_width_si),
        predicted: predicted.map(|p| p.si),
        predicted_half_width: predicted.map_or(0.0, |p| p.half_width_si),
        residual: measured.zip(predicted).map(|(m, p)| p.si - m.si),
        status,
        reason,
    }
}

fn measure_all(points: &[Point], n_without_prediction: usize) -> Vec<MetricRecord> {
    let pair = |p: &Point| {
        let interval = |value: Option<f64>, half_width_si| {
            Interval::from(Printed { si: value.unwrap_or(f64::NAN), half_width_si })
        };
        Pair {
            predicted: interval(p.predicted, p.predicted_half_width),
            measured: interval(p.measured, p.measured_half_width),
        }
    };
    let of = |status| points.iter().filter(move |p| p.status == status);
    let in_metrics = |p: &&Point| matches!(p.status, PointStatus::Used | PointStatus::NotFinite);
    let pairs: Vec<Pair> = points.iter().filter(in_metrics).map(pair).collect();
    let at_zero: Vec<Pair> = of(PointStatus::ZeroReference).map(pair).collect();
    let not_printed = of(PointStatus::PredictionNotPrinted).count();
    let asked = pairs.len() + n_without_prediction + not_printed;
    // Points that are missing from a mean would make it another mean: it is then only told, never judged.
    let missing = if n_without_prediction > 0 {
        Some(format!("no prediction at {n_without_prediction} of {asked} measured points"))
    } else if not_printed > 0 && !pairs.is_empty() {
        Some(format!("no predicted value is printed at {not_printed} of {asked} measured points"))
    } else {
        None
    };
    Metric::ALL
        .into_iter()
        .map(|metric| {
            let record = MetricRecord::new(metric, metrics::measure(metric, &pairs, &at_zero));
            match &missing {
                Some(why) if metric != Metric::ResidualAtZero => MetricRecord {
                    metric,
                    value: None,
                    lower: None,
                    upper: None,
                    undefined: Some(record.undefined.unwrap_or_else(|| why.clone())),
                    over_predicted_points: record.value,
                },
                _ => record,
            }
        })
        .collect()
}

/// A remark with its placeholders filled in from computed and printed numbers.
fn remark(
    input: &Input,
    spec: &ComparisonSpec,
    table: &PublishedTable,
    comparison: &Comparison,
) -> Result<Option<String>, AnalysisError> {
    let Some(template) = &spec.remark else { return Ok(None) };
    let unit = table.quantity.unit;
    let value = |v: Option<f64>, missing: &str| v.map_or(missing.to_owned(), |v| format::quantity(v, unit, 2));
    let predicted: Vec<String> = comparison.points.iter().map(|p| value(p.predicted, "no prediction")).collect();
    let measured: Vec<String> = comparison.points.iter().map(|p| value(p.measured, "no value")).collect();
    let printed: BTreeMap<String, Vec<String>> = table.texts.iter().cloned().collect();
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
    let inputs = &input.actuator.values;
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
        file: input.file.clone(),
        line: spec.line,
        message: error.detail().map_or_else(|| error.kind().to_string(), str::to_owned),
    })
}

fn actuator_record(actuator: &Actuator) -> ActuatorRecord {
    let inputs = actuator
        .values
        .iter()
        .map(|(name, value)| InputRecord {
            name: name.clone(),
            value_si: value.si,
            std_si: value.std_si,
            unit: value.unit.symbol.to_owned(),
            origin: value.origin.name().to_owned(),
            place: value.place.clone(),
        })
        .collect();
    ActuatorRecord {
        id: actuator.id.clone(),
        kind: actuator.kind.clone(),
        title: actuator.title.clone(),
        summary: actuator.summary.clone(),
        inputs,
        datasets: vec![],
    }
}

fn dataset_record(input: &Input) -> DatasetRecord {
    let dataset = &input.dataset;
    let own = dataset.files.iter().map(|f| SourceFile { path: f.name.clone(), sha256: f.sha256.clone() });
    let actuator = SourceFile { path: input.actuator_path.clone(), sha256: input.actuator.sha256.clone() };
    let stated = dataset.stated.iter().map(|s| StatedRecord {
        title: s.title.clone(),
        value_si: s.value.si,
        unit: s.value.unit.symbol.to_owned(),
        place: s.value.place.clone(),
    });
    let listings = dataset.listings.iter().map(|l| ListingRecord {
        title: l.title.clone(),
        place: l.place.clone(),
        names: l.names.clone(),
        rows: l.rows.clone(),
    });
    DatasetRecord {
        id: dataset.id.clone(),
        paper: dataset.paper.title.clone(),
        reference: dataset.paper.reference.clone(),
        notes: dataset.notes.clone(),
        unprinted: dataset.unprinted.clone(),
        stated: stated.collect(),
        listings: listings.collect(),
        sources: own.chain([actuator]).chain(input.bounds_source.clone()).collect(),
    }
}
