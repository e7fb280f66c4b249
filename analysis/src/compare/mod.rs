//! Response and prediction to comparison and verdict: the whole analysis, of published datasets and of sessions alike.

pub(crate) mod errors;
mod predict;

use std::borrow::Cow;
use std::collections::{BTreeMap, BTreeSet};

use pneuval_ingest::document::Origin;
use pneuval_ingest::error::suggestion;
use pneuval_ingest::manifest::{Align, ComparisonSpec, Quantity, Statistic};

use predict::unknown_form;
pub(crate) use predict::{Between, Posed, predict};

use crate::AnalysisError;
use crate::fit;
use crate::gate::{judge_comparison, notes, strangers};
use crate::logs::{self, Log};
use crate::metrics::{self, Interval, Measure, Metric};
use crate::pairing::{measure_published, measure_session, points};
use crate::photographs::{self, Shown};
use crate::prediction::Prediction;
use crate::records;
use crate::remark::remark;
use crate::response::{POINTS_MAX, Response};
use crate::results::{
    ActuatorRecord, Against, Comparison, ConditionRecord, FindingRecord, MeetingRecord, MetricRecord,
    MovementAlignmentRecord, PointStatus, QuantityRecord, Results, SCHEMA_VERSION,
};
use crate::series::Curve;
use crate::study::{BoundsScope, Input, NO_FORM, Study};
use crate::trajectory;
use crate::uncertainty::errors::Errors;
use crate::verdict::{Basis, Verdict};

/// What `validate` computes: the numbers, and the curves behind the figures.
#[derive(Debug, Clone, PartialEq)]
pub struct Evaluation {
    /// The content of `results.json`.
    pub results: Results,
    /// The content of `series.parquet`.
    pub curves: Vec<Curve>,
    /// The content of `logs.parquet`.
    pub logs: Vec<Log>,
    /// Photographs that sessions show, by their path in the results folder.
    pub photographs: BTreeMap<String, Shown>,
}

/// Compares every prediction of every dataset with its measurement and judges it, and says after each dataset that it is done.
///
/// # Errors
/// [`AnalysisError`] for a comparison that cannot be posed: an unknown form, an input missing or in a wrong unit, a bound
/// beside the dataset that meets no comparison. A model without a solution is no error but a failed comparison; data of a
/// session that cannot be fitted leave theirs open.
pub fn validate(inputs: &[Input], report_only: bool, done: &mut dyn FnMut()) -> Result<Evaluation, AnalysisError> {
    let mut studies = Vec::new();
    let mut actuators: BTreeMap<String, ActuatorRecord> = BTreeMap::new();
    let mut comparisons = Vec::new();
    let mut curves = Vec::new();
    let mut findings = Vec::new();
    let mut kept = Vec::new();
    let mut shown = BTreeMap::new();
    for input in inputs {
        let study = Study::of(input)?;
        for spec in &study.comparisons {
            let (comparison, curve) = compare(&study, spec)?;
            curves.push(curve);
            findings.extend(records::meetings(&comparison));
            comparisons.push(comparison);
        }
        for statistic in study.statistics {
            comparisons.push(stated(&study, statistic)?);
        }
        if input.bounds_scope == BoundsScope::Own
            && let Some(error) = input.bounds.unused(&input.actuator.id, &study.posed())
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
        if !actuators.contains_key(&input.actuator.id) {
            actuators.insert(input.actuator.id.clone(), records::actuator(&input.actuator)?);
        }
        if let Some(record) = actuators.get_mut(&input.actuator.id) {
            let mut dataset = records::dataset(&study);
            photographs::show(&study, &mut dataset, &mut shown);
            logs::keep(&study, &mut dataset, &mut kept);
            record.datasets.push(dataset);
        }
        findings.extend(records::findings(&study));
        studies.push(study);
        done();
    }
    findings.extend(unused_bounds(&studies));
    // Stable: what weighs most first, else in the order of the data.
    findings.sort_by_key(|finding| finding.severity);
    let results = Results {
        schema_version: SCHEMA_VERSION,
        program: concat!("pneuval ", env!("CARGO_PKG_VERSION")).to_owned(),
        metric_definitions: metrics::DEFINITIONS_VERSION,
        report_only,
        actuators: actuators.into_values().collect(),
        comparisons,
        findings,
        files: BTreeMap::new(),
    };
    logs::thin(&mut kept);
    Ok(Evaluation { results, curves, logs: kept, photographs: shown })
}

/// Rows of bounds that judged nothing in the whole run, and columns that nothing was compared with.
fn unused_bounds(studies: &[Study]) -> Vec<FindingRecord> {
    let mut texts = BTreeSet::new();
    for study in studies.iter().filter(|study| study.input.bounds_scope != BoundsScope::Embedded) {
        let id = &study.input.actuator.id;
        let all: Vec<(String, String)> =
            studies.iter().filter(|other| other.input.actuator.id == *id).flat_map(Study::posed).collect();
        texts.extend(study.input.bounds.unused_rows(id, &all));
        let here: Vec<&str> = studies.iter().map(|other| other.input.actuator.id.as_str()).collect();
        texts.extend(strangers(&study.input.bounds, &here));
    }
    texts.extend(studies.iter().flat_map(Study::uncompared));
    texts.extend(studies.iter().flat_map(|study| records::slips(&study.input.actuator)));
    texts.extend(studies.iter().flat_map(|study| records::hidden_forms(&study.input.actuator)));
    notes(texts)
}

fn compare(study: &Study, spec: &ComparisonSpec) -> Result<(Comparison, Curve), AnalysisError> {
    let Some(response) = study.response(&spec.quantity) else {
        // The readers refuse a comparison without its measurement.
        return Err(unknown_form(study, spec, []));
    };
    let mut sides = side_by_side(study, spec, response)?;
    // What moves a prediction moves it where it is predicted: it is turned with it.
    let mut errors =
        (response.basis == Basis::Session).then(|| errors::errors(study, spec, &sides.response, &sides.posed));
    let alignment = sides.align(spec.align, errors.as_mut().map(|(errors, _)| errors));
    let Sides { response, posed: Posed { prediction, fit: fitted, .. }, meeting } = sides;
    let response = response.as_ref();
    let mut points = points(response, &prediction.at);
    let mut comparison = blank(study, &spec.quantity, response, &spec.form);
    comparison.title = spec.title.clone().unwrap_or(prediction.title);
    comparison.kind = prediction.kind;
    comparison.source = prediction.source;
    comparison.equation = prediction.equation;
    comparison.misprints = prediction.misprints;
    comparison.calibrated_on = calibrated_on(study, spec, response, &prediction.rests_on);
    comparison.rests_on = prediction.rests_on;
    comparison.fit = fitted;
    let count = |status| points.iter().filter(|p| p.status == status).count();
    comparison.n_available = meeting.as_ref().map_or_else(
        || points.len() - count(PointStatus::HoleInPrint) + response.unmeasured,
        MeetingRecord::n_available,
    );
    comparison.n_used = count(PointStatus::Used);
    comparison.n_without_prediction = count(PointStatus::NoPrediction);
    match errors {
        None => comparison.metrics = measure_published(&points),
        Some((errors, inputs)) => {
            comparison.inputs = inputs;
            let found = measure_session(&points, response, &errors);
            (comparison.metrics, comparison.budget) = (found.metrics, found.budget);
            comparison.validation = found.validation;
            for (i, interval) in found.residuals {
                (points[i].residual_lower, points[i].residual_upper) = (Some(interval.lower), Some(interval.upper));
            }
        }
    }
    comparison.points = points;
    if let Some(too_little) = meeting.as_ref().filter(|meeting| meeting.is_too_little()) {
        let why = format!("too little of the two overlaps: {}", too_little.reach());
        comparison.metrics.iter_mut().for_each(|metric| metric.withhold(&why));
        comparison.budget.clear();
        comparison.validation = None;
    }
    (comparison.meeting, comparison.alignment) = (meeting, alignment);
    comparison.remark = remark(study, spec, response, &comparison)?;
    let dimension = response.quantity.unit.dimension;
    let bounds = study.input.bounds.of(&study.input.actuator.id, &spec.quantity, &spec.form, dimension)?;
    judge_comparison(&mut comparison, bounds, spec.not_judged.as_deref());
    let curve = Curve { comparison: comparison.id.clone(), traces: prediction.traces };
    Ok((comparison, curve))
}

/// The runs of a response on which calibrated values that the prediction rests on were fitted.
fn calibrated_on(study: &Study, spec: &ComparisonSpec, response: &Response, rests_on: &[String]) -> Vec<String> {
    let label = |run: &str| fit::actuator::label(study.id, &spec.quantity, run);
    let own: Vec<String> = if response.repeats.is_empty() {
        vec![label("measured")]
    } else {
        response.repeats.iter().map(|run| label(run)).collect()
    };
    let names = rests_on.iter().filter_map(|text| text.strip_prefix(Origin::Calibrated.name()));
    let values = names.filter_map(|name| study.input.actuator.values.get(name.trim()));
    let fitted: BTreeSet<&String> = values.flat_map(|value| &value.fitted_on).collect();
    own.into_iter().filter(|run| fitted.contains(run)).collect()
}

/// A response and a prediction at the same points.
pub(crate) struct Sides<'a> {
    /// With the points at which the two are compared.
    pub response: Cow<'a, Response>,
    /// With the prediction at those points.
    pub posed: Posed<'a>,
    /// How much of a movement meets the prediction.
    pub meeting: Option<MeetingRecord>,
}

impl Sides<'_> {
    /// Moves the prediction onto the measurement, if that is asked for, and what moves it with it; how.
    pub fn align(&mut self, align: Align, errors: Option<&mut Errors>) -> Option<MovementAlignmentRecord> {
        trajectory::align(align, &self.response, &mut self.posed.prediction, errors)
    }
}

/// A prediction beside what it is compared with: at the points of the response, or where a movement meets it. Nothing is moved yet.
pub(crate) fn side_by_side<'a>(
    study: &'a Study,
    spec: &'a ComparisonSpec,
    response: &'a Response,
) -> Result<Sides<'a>, AnalysisError> {
    let mut posed = predict(study, spec, response)?;
    let mut meeting = None;
    let mut response = Cow::Borrowed(response);
    if let (Between::Path(model), Some(movement)) = (&posed.between, &response.movement) {
        posed.prediction.traces = trajectory::traces(movement, model);
        if let Some(met) = trajectory::meet(&response, model) {
            posed.prediction.at = met.at;
            (response, meeting) = (Cow::Owned(met.response), Some(met.record));
        }
    } else if let Some(samples) = trajectory::samples(&response, POINTS_MAX) {
        posed.prediction = Prediction::none(&samples);
        response = Cow::Owned(samples);
    }
    if response.points.len() > POINTS_MAX {
        return Err(AnalysisError::TooManyPoints {
            file: study.input.file.clone(),
            line: spec.line,
            quantity: spec.quantity.clone(),
            points: response.points.len(),
            limit: POINTS_MAX,
            next: "thin the rows of the prediction: each is a point",
        });
    }
    Ok(Sides { response, posed, meeting })
}

/// A comparison before anything is known of it.
fn blank(study: &Study, quantity: &str, response: &Response, form: &str) -> Comparison {
    Comparison {
        id: format!("{}/{quantity}/{form}", study.id),
        actuator: study.input.actuator.id.clone(),
        dataset: study.id.to_owned(),
        quantity: quantity_record(&response.quantity),
        form: form.to_owned(),
        title: String::new(),
        kind: String::new(),
        source: String::new(),
        measured_source: response.source.clone(),
        equation: None,
        misprints: vec![],
        rests_on: vec![],
        calibrated_on: vec![],
        fit: None,
        against: response.movement.as_ref().map_or(Against::Pressure, |movement| movement.rule.at.into()),
        meeting: None,
        alignment: None,
        samples_alone: response.basis == Basis::Session && response.repeats.is_empty(),
        basis: response.basis,
        metrics_printed: false,
        conditions: response
            .conditions
            .iter()
            .map(|c| ConditionRecord {
                id: c.id.clone(),
                title: c.title.clone(),
                display_unit: c.unit.symbol.to_owned(),
            })
            .collect(),
        chambers: response.chambers.clone(),
        n_available: 0,
        n_used: 0,
        n_without_prediction: 0,
        points: vec![],
        metrics: vec![],
        budget: vec![],
        validation: None,
        inputs: None,
        judgements: vec![],
        verdict: Verdict::Unjudged,
        counted: true,
        sentence: String::new(),
        remark: None,
    }
}

fn quantity_record(quantity: &Quantity) -> QuantityRecord {
    QuantityRecord {
        id: quantity.id.clone(),
        title: quantity.title.clone(),
        si_unit: quantity.unit.dimension.si_symbol().to_owned(),
        display_unit: quantity.unit.symbol.to_owned(),
        components: quantity.components.clone(),
    }
}

/// An error that the source states without its data: judged on what its printed digits leave open.
fn stated(study: &Study, statistic: &Statistic) -> Result<Comparison, AnalysisError> {
    let response = Response {
        quantity: statistic.quantity.clone(),
        basis: Basis::PublishedPoint,
        source: format!("{}; {}", statistic.place, statistic.method),
        chambers: vec![],
        conditions: vec![],
        zero_within_pa: 0.0,
        same_within_pa: 0.0,
        rounding_pa: 0.0,
        points: vec![],
        unmeasured: 0,
        movement: None,
        columns: vec![],
        texts: vec![],
        repeats: vec![],
        instruments: vec![],
        drift: None,
    };
    let mut comparison = blank(study, &statistic.quantity.id, &response, &statistic.form);
    comparison.title.clone_from(&statistic.title);
    "published".clone_into(&mut comparison.kind);
    comparison.source.clone_from(&statistic.place);
    comparison.metrics_printed = true;
    comparison.remark.clone_from(&statistic.remark);
    let mut printed = BTreeMap::new();
    for (id, value, line) in &statistic.metrics {
        let metric = Metric::parse(id).filter(|m| m.is_boundable()).ok_or_else(|| AnalysisError::UnknownMetric {
            file: study.input.file.clone(),
            line: *line,
            name: id.clone(),
            next: suggestion(id, Metric::ALL.iter().filter(|m| m.is_boundable()).map(|m| m.id())),
        })?;
        printed.insert(metric, Measure::Known(Interval::from(*value)));
    }
    let missing = Measure::Undefined("not printed, and the data behind it are not printed either");
    comparison.metrics = Metric::ALL
        .into_iter()
        .map(|metric| MetricRecord::new(metric, printed.get(&metric).copied().unwrap_or(missing)))
        .collect();
    let dimension = statistic.quantity.unit.dimension;
    let bounds = study.input.bounds.of(&study.input.actuator.id, &statistic.quantity.id, &statistic.form, dimension)?;
    judge_comparison(&mut comparison, bounds, statistic.not_judged.as_deref());
    Ok(comparison)
}
