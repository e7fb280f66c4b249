//! Unknown inputs of an actuator's model, from its measured response.
//!
//! The residual is predicted - measured in the quantity, one per component of every reading of every run; values of the actuator file that
//! carry a standard uncertainty are priors: they pull by `(value - file) / std` against readings that scatter by what the fit leaves.

use nalgebra::DVector;
use serde::Serialize;

use pneuval_ingest::document::Origin;
use pneuval_ingest::manifest::{Actuator, Condition, Quantity};
use pneuval_models::ModelError;
use pneuval_models::catalogue::{Entry, Inputs};
use pneuval_models::least_squares::{Minimum, Problem, minimise, search};

use super::estimate::{Estimates, Stated, estimates, search_record, stated};
use crate::prediction::{Form, full_pressures, share};
use crate::response::Response;

/// A reading to fit or to predict.
#[derive(Debug, Clone, PartialEq)]
pub struct Reading {
    /// Dataset and quantity and run, as `fitted_on` names it: `monday/outer-diameter run-1`.
    pub run: String,
    /// Which specimen it is of, if that is said.
    pub specimen: Option<String>,
    /// Gauge pressure per chamber, Pa.
    pub pressures_gauge_pa: Vec<f64>,
    /// Nominal pressures nearer than this are one, Pa.
    pub same_within_pa: f64,
    /// Value of each condition, SI units.
    pub conditions_si: Vec<f64>,
    /// Value of each component, SI units.
    pub values_si: Vec<f64>,
    /// Whether the fit sees it.
    pub fitted: bool,
}

/// The readings of a response: what was measured, or a printed column in its place. Not at zero pressure, which holds for every
/// material, and not in a cycle apart.
pub fn readings(dataset: &str, response: &Response, to: &str, specimen: Option<&str>) -> Vec<Reading> {
    let quantity = &response.quantity.id;
    let column = response.columns.iter().find(|column| column.form == to);
    let mut readings = Vec::new();
    for (i, point) in response.points.iter().enumerate() {
        if response.is_zero_reference(point) || point.is_apart {
            continue;
        }
        let mut push = |run: &str, pressures: &[f64], conditions: Vec<f64>, values: Vec<f64>| {
            if values.iter().all(|v| v.is_finite()) {
                readings.push(Reading {
                    run: label(dataset, quantity, run),
                    specimen: specimen.map(str::to_owned),
                    pressures_gauge_pa: pressures.to_vec(),
                    same_within_pa: response.same_within_pa,
                    conditions_si: conditions,
                    values_si: values,
                    fitted: true,
                });
            }
        };
        if column.is_none() && !point.repeats.is_empty() {
            for repeat in &point.repeats {
                let run = response.repeats.get(repeat.index).map_or("measured", String::as_str);
                push(run, &repeat.pressures_gauge_pa, repeat.conditions.clone(), repeat.measured.clone());
            }
            continue;
        }
        let cell = column.map_or(point.measured.as_ref(), |column| column.cells[i].as_ref());
        if let Some(values) = cell {
            let conditions = point.conditions.iter().map(|c| c.si).collect();
            push(to, &point.pressures_gauge_pa, conditions, values.iter().map(|v| v.si).collect());
        }
    }
    readings
}

/// How `fitted_on` names a run.
pub fn label(dataset: &str, quantity: &str, run: &str) -> String {
    format!("{dataset}/{quantity} {run}")
}

/// What is fitted.
pub struct Task<'a> {
    /// The actuator, whose values are start values and priors.
    pub actuator: &'a Actuator,
    /// The form.
    pub entry: &'a Entry,
    /// Its inputs from the actuator file.
    pub inputs: Inputs,
    /// What is set beside the pressure.
    pub conditions: &'a [Condition],
    /// What was measured.
    pub quantity: &'a Quantity,
    /// The inputs to fit.
    pub parameters: Vec<String>,
    /// The readings.
    pub readings: Vec<Reading>,
    /// Whether standard uncertainties of the actuator file pull.
    pub priors: bool,
    /// Starts to try.
    pub starts: usize,
    /// Confidence of the intervals.
    pub confidence: f64,
}

/// Fitted inputs of an actuator's model.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ActuatorFit {
    /// The actuator.
    pub actuator: String,
    /// The quantity.
    pub quantity: String,
    /// SI unit of it, and of every error below.
    pub si_unit: &'static str,
    /// The form.
    pub form: String,
    /// Runs that the fit saw.
    pub fitted_on: Vec<String>,
    /// What was found, in SI units.
    pub estimates: Estimates,
    /// What the actuator file says of each parameter.
    pub file: Vec<FileValue>,
    /// The values of the actuator file, all together, against the readings.
    pub file_jointly: Stated,
    /// Every reading with what the fit says there.
    pub readings: Vec<ReadingRecord>,
    /// Errors at the readings that the fit saw: how well it fits, which is not how well it predicts.
    pub in_sample: Errors,
    /// Errors at readings that it did not see, if any were kept from it.
    pub held_out: Option<Errors>,
    /// Predicted by fits to the others, group by group: pressures, runs, specimens.
    pub left_out: Vec<LeaveOut>,
}

/// What the actuator file says of a parameter.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FileValue {
    /// Its name.
    pub name: String,
    /// Its unit in the file, and the SI value of one.
    pub unit: &'static str,
    /// SI value of that unit.
    pub unit_si: f64,
    /// Its value, SI.
    pub value: f64,
    /// `published`, `measured`, `assumed`, `calibrated`.
    pub origin: &'static str,
    /// How many standard errors it is from the fit; `None` if nothing is known of the scatter.
    pub standard_errors_away: Option<f64>,
    /// Whether it lies in the interval; `None` likewise.
    pub in_interval: Option<bool>,
    /// Whether it pulled on the fit.
    pub prior: bool,
}

/// A reading beside its prediction.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ReadingRecord {
    /// The run.
    pub run: String,
    /// Gauge pressure per chamber, Pa.
    pub pressures_gauge_pa: Vec<f64>,
    /// Conditions, SI units.
    pub conditions_si: Vec<f64>,
    /// Measured, SI units.
    pub measured: Vec<f64>,
    /// Predicted, SI units; `None` where the model has no value.
    pub predicted: Option<Vec<f64>>,
    /// Whether the fit saw it.
    pub fitted: bool,
}

/// Errors over readings.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Errors {
    /// Values that have a prediction.
    pub n_used: usize,
    /// Values.
    pub n_available: usize,
    /// Root mean square, SI.
    pub rmse: Option<f64>,
    /// The largest size, SI.
    pub max_abs: Option<f64>,
}

/// A validation by leaving out.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct LeaveOut {
    /// `pressure`, `run` or `specimen`.
    pub by: &'static str,
    /// Errors over all groups.
    pub errors: Errors,
    /// Group by group.
    pub groups: Vec<LeftOutGroup>,
}

/// What a fit to the others says of a group.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct LeftOutGroup {
    /// The group.
    pub group: String,
    /// Its errors.
    pub errors: Errors,
    /// The parameters of the fit to the others, SI; `None` if it failed.
    pub parameters: Option<Vec<f64>>,
    /// Why it failed.
    pub why: Option<String>,
}

/// Fits.
///
/// # Errors
/// [`ModelError`] if the model has no value at any start, or no minimum is found.
pub fn fit(task: &Task) -> Result<ActuatorFit, ModelError> {
    let fitted: Vec<&Reading> = task.readings.iter().filter(|reading| reading.fitted).collect();
    let start: Vec<f64> = task.parameters.iter().map(|name| task.inputs.get(name).unwrap_or(f64::NAN)).collect();
    let mut problem = AtReadings::new(task, &fitted);
    let start = reachable(&problem, start);
    let mut found = search(&problem, &start, &[], task.starts)?;
    let priors = if task.priors { priors(task) } else { vec![None; start.len()] };
    if priors.iter().any(Option::is_some) && found.best.degrees_of_freedom() > 0 {
        // Priors are weighed against what the readings scatter by, which the fit without them tells.
        let freedom = found.best.degrees_of_freedom() as f64;
        problem.scatter = (found.best.sum_of_squares() / freedom).sqrt();
        problem.priors.clone_from(&priors);
        let best = minimise(&problem, &found.best.parameters)?;
        found.given = Ok(best.clone());
        found.best = best;
    }
    let estimates = estimates(&problem, &found.best, search_record(&found), &task.parameters, task.confidence);
    let (in_sample, held_out, readings) = predicted(task, &found.best.parameters);
    let values: Vec<f64> = task.parameters.iter().map(|name| task.inputs.get(name).unwrap_or(f64::NAN)).collect();
    let file = file_values(task, &estimates, &priors);
    let mut fitted_on: Vec<String> = fitted.iter().map(|reading| reading.run.clone()).collect();
    fitted_on.dedup();
    fitted_on.sort();
    fitted_on.dedup();
    let left_out = [
        ("pressure", by_pressure(&fitted)),
        ("run", by(&fitted, |r| Some(r.run.clone()))),
        ("specimen", by(&fitted, |r| r.specimen.clone())),
    ]
    .into_iter()
    .filter(|(_, groups)| groups.len() > 1)
    .map(|(name, groups)| leave_out(task, name, &groups, &found.best))
    .collect();
    Ok(ActuatorFit {
        actuator: task.actuator.id.clone(),
        quantity: task.quantity.id.clone(),
        si_unit: task.quantity.unit.dimension.si_symbol(),
        form: task.entry.form.to_owned(),
        fitted_on,
        file_jointly: stated(&problem, &found.best, &values),
        estimates,
        file,
        readings,
        in_sample,
        held_out,
        left_out,
    })
}

/// Start values, doubled together until the model reaches every pressure: a material too soft to stay in range is no start.
fn reachable(problem: &AtReadings, mut start: Vec<f64>) -> Vec<f64> {
    const DOUBLINGS_MAX: u32 = 30;
    let first = start.clone();
    for _ in 0..DOUBLINGS_MAX {
        if problem.residuals(&start).is_ok() {
            return start;
        }
        for value in &mut start {
            *value *= 2.0;
        }
    }
    first
}

/// Values of the actuator file with a standard uncertainty.
fn priors(task: &Task) -> Vec<Option<(f64, f64)>> {
    let of = |name: &String| {
        let value = task.actuator.values.get(name)?;
        // What was fitted before is no independent knowledge of the same data.
        let knows = matches!(value.origin, Origin::Published | Origin::Measured | Origin::Assumed);
        value.std_si.filter(|std| knows && *std > 0.0).map(|std| (value.si, std))
    };
    task.parameters.iter().map(of).collect()
}

fn file_values(task: &Task, estimates: &Estimates, priors: &[Option<(f64, f64)>]) -> Vec<FileValue> {
    let mut values = Vec::new();
    for ((name, estimate), prior) in task.parameters.iter().zip(&estimates.parameters).zip(priors) {
        let Some(value) = task.actuator.values.get(name) else { continue };
        let inside = match (estimate.lower.value(), estimate.upper.value()) {
            (None, None) => None,
            (low, high) => Some(low.is_none_or(|low| value.si >= low) && high.is_none_or(|high| value.si <= high)),
        };
        values.push(FileValue {
            name: name.clone(),
            unit: value.unit.symbol,
            unit_si: value.unit.factor,
            value: value.si,
            origin: value.origin.name(),
            standard_errors_away: estimate.std.filter(|std| *std > 0.0).map(|std| (value.si - estimate.value) / std),
            in_interval: inside,
            prior: prior.is_some(),
        });
    }
    values
}

/// Every reading with its prediction, and the errors of those seen and of those not.
fn predicted(task: &Task, parameters: &[f64]) -> (Errors, Option<Errors>, Vec<ReadingRecord>) {
    let form = form(task, parameters);
    let records: Vec<ReadingRecord> = task
        .readings
        .iter()
        .map(|reading| ReadingRecord {
            run: reading.run.clone(),
            pressures_gauge_pa: reading.pressures_gauge_pa.clone(),
            conditions_si: reading.conditions_si.clone(),
            measured: reading.values_si.clone(),
            predicted: form.value(&reading.pressures_gauge_pa, &reading.conditions_si).ok(),
            fitted: reading.fitted,
        })
        .collect();
    let of = |fitted: bool| {
        errors(records.iter().filter(|r| r.fitted == fitted).map(|r| (&r.measured, r.predicted.as_ref())))
    };
    let held_out = records.iter().any(|record| !record.fitted).then(|| of(false));
    (of(true), held_out, records)
}

fn errors<'a>(pairs: impl Iterator<Item = (&'a Vec<f64>, Option<&'a Vec<f64>>)>) -> Errors {
    let (mut n_available, mut sizes) = (0, Vec::new());
    for (measured, predicted) in pairs {
        n_available += measured.len();
        if let Some(predicted) = predicted {
            sizes.extend(measured.iter().zip(predicted).map(|(m, p)| (p - m).abs()));
        }
    }
    let n_used = sizes.len();
    let rmse = (n_used > 0).then(|| (sizes.iter().map(|e| e * e).sum::<f64>() / n_used as f64).sqrt());
    Errors { n_used, n_available, rmse, max_abs: sizes.into_iter().reduce(f64::max) }
}

fn form<'a>(task: &'a Task, parameters: &[f64]) -> Form<'a> {
    let mut inputs = task.inputs.clone();
    for (name, value) in task.parameters.iter().zip(parameters) {
        inputs.set(name.as_str(), *value);
    }
    Form::new(task.entry, inputs, task.conditions)
}

/// Readings by nominal pressure: by rising share of full pressure, those nearer than the response's tolerance together.
fn by_pressure<'a>(readings: &[&'a Reading]) -> Vec<(String, Vec<&'a Reading>)> {
    let all: Vec<Vec<f64>> = readings.iter().map(|r| r.pressures_gauge_pa.clone()).collect();
    let full = full_pressures(&all);
    let mut rising: Vec<&Reading> = readings.to_vec();
    rising.sort_by(|a, b| share(&a.pressures_gauge_pa, &full).total_cmp(&share(&b.pressures_gauge_pa, &full)));
    let mut groups: Vec<(String, Vec<&Reading>)> = Vec::new();
    for reading in rising {
        let same = |first: &Reading| {
            let near = |(a, b): (&f64, &f64)| (a - b).abs() <= reading.same_within_pa.max(1e-9 * a.abs());
            first.pressures_gauge_pa.iter().zip(&reading.pressures_gauge_pa).all(near)
        };
        match groups.last_mut() {
            Some((_, group)) if group.first().is_some_and(|first| same(first)) => group.push(reading),
            _ => {
                let names: Vec<String> =
                    (1..=reading.pressures_gauge_pa.len()).map(|i| format!("chamber {i}")).collect();
                groups.push((crate::format::pressures(&reading.pressures_gauge_pa, &names), vec![reading]));
            }
        }
    }
    groups
}

/// Readings by a name; those without one belong to no group.
fn by<'a>(readings: &[&'a Reading], name: impl Fn(&Reading) -> Option<String>) -> Vec<(String, Vec<&'a Reading>)> {
    let mut groups: Vec<(String, Vec<&Reading>)> = Vec::new();
    for reading in readings {
        let Some(name) = name(reading) else { continue };
        match groups.iter_mut().find(|(known, _)| *known == name) {
            Some((_, group)) => group.push(reading),
            None => groups.push((name, vec![reading])),
        }
    }
    groups
}

/// Each group predicted by a fit to the others.
fn leave_out(task: &Task, by: &'static str, groups: &[(String, Vec<&Reading>)], all: &Minimum) -> LeaveOut {
    let mut records = Vec::new();
    let mut pairs: Vec<(Vec<f64>, Option<Vec<f64>>)> = Vec::new();
    for (name, group) in groups {
        let others: Vec<&Reading> =
            groups.iter().filter(|(other, _)| other != name).flat_map(|(_, group)| group.iter().copied()).collect();
        let problem = AtReadings::new(task, &others);
        let found = minimise(&problem, &all.parameters).and_then(|minimum| minimum.statistics().map(|_| minimum));
        let found = found.map_err(|error| error.to_string());
        let form = found.as_ref().ok().map(|minimum| form(task, &minimum.parameters));
        let start = pairs.len();
        for reading in group {
            let value = |form: &Form| form.value(&reading.pressures_gauge_pa, &reading.conditions_si).ok();
            pairs.push((reading.values_si.clone(), form.as_ref().and_then(value)));
        }
        records.push(LeftOutGroup {
            group: name.clone(),
            errors: errors(pairs[start..].iter().map(|(m, p)| (m, p.as_ref()))),
            parameters: found.as_ref().ok().map(|minimum| minimum.parameters.clone()),
            why: found.err(),
        });
    }
    LeaveOut { by, errors: errors(pairs.iter().map(|(m, p)| (m, p.as_ref()))), groups: records }
}

/// A form at readings.
struct AtReadings<'a> {
    task: &'a Task<'a>,
    readings: Vec<&'a Reading>,
    priors: Vec<Option<(f64, f64)>>,
    scatter: f64,
}

impl<'a> AtReadings<'a> {
    fn new(task: &'a Task<'a>, readings: &[&'a Reading]) -> Self {
        Self { task, readings: readings.to_vec(), priors: vec![], scatter: 0.0 }
    }
}

impl Problem for AtReadings<'_> {
    fn parameters(&self) -> usize {
        self.task.parameters.len()
    }

    fn residuals(&self, at: &[f64]) -> Result<DVector<f64>, ModelError> {
        let form = form(self.task, at);
        let mut residuals = Vec::with_capacity(self.readings.len());
        for reading in &self.readings {
            let predicted = form.value(&reading.pressures_gauge_pa, &reading.conditions_si)?;
            residuals.extend(predicted.iter().zip(&reading.values_si).map(|(p, m)| p - m));
        }
        for (value, prior) in at.iter().zip(&self.priors) {
            if let Some((file, std)) = prior {
                residuals.push(self.scatter * (value - file) / std);
            }
        }
        Ok(DVector::from_vec(residuals))
    }
}
