//! What a model, an imported table or a printed column says at the points of a response.

use std::cell::RefCell;

use pneuval_ingest::calibration::interpolate;
use pneuval_ingest::document::Origin;
use pneuval_ingest::manifest::{Actuator, Condition, ImportedModel, Over, PredictedColumn};
use pneuval_ingest::number::Printed;
use pneuval_models::ModelError;
use pneuval_models::catalogue::{Entry, Inputs, Model, Parameter};

use crate::AnalysisError;
use crate::format;
use crate::response::{Response, ResponsePoint};
use crate::series::{CurvePoint, Trace};
use crate::uncertainty::coverage::Z95;

/// Points on which a model is drawn between zero and full pressure.
const CURVE_STEPS: u32 = 100;

/// Sets of conditions up to which they are settings, each with a curve of its own; more are measured values.
pub const SETS_MAX: usize = 12;

/// A pressure beyond the end of a table by so little of its range is the end: conversions round.
const TABLE_END_SHARE: f64 = 1e-9;

/// Models kept for points to come: settings come again, measured conditions do not.
const BUILT_MAX: usize = 64;

/// A prediction at the points of a response.
#[derive(Debug, Clone, PartialEq)]
pub struct Prediction {
    /// Its name in legends and tables.
    pub title: String,
    /// `published`, `printed`, `consistent`, `reading`, `assumed` or `imported`.
    pub kind: String,
    /// Paper and place, or whose table.
    pub source: String,
    /// The equation, for computed forms.
    pub equation: Option<String>,
    /// What fails in print, or departs from it.
    pub misprints: Vec<String>,
    /// Inputs that nobody printed or measured: `assumed sheet_width`, `calibrated C10`.
    pub rests_on: Vec<String>,
    /// One per point of the response.
    pub at: Vec<Predicted>,
    /// The form between the points, for figures: one trace per set of conditions.
    pub traces: Vec<Trace>,
}

/// A prediction at one point.
#[derive(Debug, Clone, PartialEq)]
pub enum Predicted {
    /// A value per component with what is left open: by print, by printed conditions, or by an imported uncertainty.
    Value(Vec<Printed>),
    /// The model has no value here, and why.
    NoSolution(String),
    /// The solver or the fit gave up, and why: nothing is known, so nothing is judged.
    Failed(String),
    /// A printed column has no number here.
    NotPrinted,
    /// The model was fitted on this point.
    InFit(Vec<Printed>),
    /// Nothing predicts this quantity.
    NotCompared,
}

/// What gives a value at pressures and conditions.
pub trait Predictor {
    /// The value of each component at gauge pressures, one per chamber, and conditions in SI units.
    fn at(&self, pressures_gauge_pa: &[f64], conditions_si: &[f64]) -> Predicted;
}

/// A catalogue form with its inputs. A set of conditions is a set of inputs: each gives a model of its own, kept for its next
/// point.
pub struct Form<'a> {
    entry: &'a Entry,
    inputs: Inputs,
    conditions: &'a [Condition],
    built: RefCell<Vec<Built>>,
}

/// A set of conditions and the model that it gives.
type Built = (Vec<f64>, Result<Model, ModelError>);

impl<'a> Form<'a> {
    /// A form whose inputs are complete but for the conditions.
    pub fn new(entry: &'a Entry, inputs: Inputs, conditions: &'a [Condition]) -> Self {
        Self { entry, inputs, conditions, built: RefCell::new(Vec::new()) }
    }

    /// The names of its inputs, but for what is set beside the pressure.
    pub fn parameters(&self) -> impl Iterator<Item = &'static Parameter> {
        self.entry.parameters.iter()
    }

    /// The value of an input.
    pub fn input(&self, name: &str) -> Option<f64> {
        self.inputs.get(name)
    }

    /// The same form with other values of some inputs.
    #[must_use]
    pub fn with(&self, changed: &[(&str, f64)]) -> Self {
        let mut inputs = self.inputs.clone();
        for (name, value) in changed {
            inputs.set(*name, *value);
        }
        Self::new(self.entry, inputs, self.conditions)
    }

    /// The value of each component.
    ///
    /// # Errors
    /// What the model says.
    pub fn value(&self, pressures_gauge_pa: &[f64], conditions_si: &[f64]) -> Result<Vec<f64>, ModelError> {
        let mut built = self.built.borrow_mut();
        let known = built.iter().position(|(set, _)| set == conditions_si);
        if known.is_none() && built.len() == BUILT_MAX {
            built.clear();
        }
        let i = known.unwrap_or_else(|| {
            let mut inputs = self.inputs.clone();
            // What the form does not ask for must not take the place of an input of the same name.
            let asked = |id: &str| self.entry.conditions.iter().any(|c| c.name == id);
            for (condition, value) in self.conditions.iter().zip(conditions_si).filter(|(c, _)| asked(&c.id)) {
                inputs.set(condition.id.as_str(), *value);
            }
            built.push((conditions_si.to_vec(), self.entry.build(&inputs)));
            built.len() - 1
        });
        match &built[i].1 {
            Ok(model) => model.predict(pressures_gauge_pa),
            Err(error) => Err(error.clone()),
        }
    }
}

impl Predictor for Form<'_> {
    fn at(&self, pressures_gauge_pa: &[f64], conditions_si: &[f64]) -> Predicted {
        match self.value(pressures_gauge_pa, conditions_si) {
            Ok(values) => Predicted::Value(exact(&values)),
            // The physics has an answer here, and it is "none"; anything else is a failure of the computation.
            Err(
                error @ (ModelError::BeyondLimit { .. }
                | ModelError::BelowStart { .. }
                | ModelError::OutOfDomain { .. }
                | ModelError::NotThisUnit { .. }),
            ) => Predicted::NoSolution(error.to_string()),
            Err(error) => Predicted::Failed(error.to_string()),
        }
    }
}

impl Predictor for ImportedModel {
    fn at(&self, pressures_gauge_pa: &[f64], _conditions_si: &[f64]) -> Predicted {
        let Some(&pressure) = pressures_gauge_pa.first() else {
            return Predicted::NoSolution("no pressure to look up".to_owned());
        };
        let Over::Pressure { chamber, gauge_pa, .. } = &self.over else {
            return Predicted::NoSolution("it is a table over time, and says nothing of pressure".to_owned());
        };
        // What arithmetic leaves of a pressure at the end of the table is that end.
        let ends = (gauge_pa.first(), gauge_pa.last());
        let (Some(&low), Some(&high)) = ends else { return Predicted::NoSolution("the table is empty".to_owned()) };
        let slack = TABLE_END_SHARE * (high - low);
        let near = (low - slack..=high + slack).contains(&pressure);
        let pressure = if near { pressure.clamp(low, high) } else { pressure };
        let column = |table: &[Vec<f64>], i: usize| {
            let points: Vec<(f64, f64)> = gauge_pa.iter().zip(table).map(|(p, row)| (*p, row[i])).collect();
            interpolate(&points, pressure)
        };
        let value = |i: usize| -> Option<Printed> {
            let si = column(&self.values_si, i)?;
            let std = self.std_si.as_ref().and_then(|table| column(table, i)).unwrap_or(0.0);
            Some(Printed { si, half_width_si: Z95 * std })
        };
        if let Some(values) = (0..self.quantity.width()).map(value).collect::<Option<Vec<_>>>() {
            return Predicted::Value(values);
        }
        let chamber = std::slice::from_ref(chamber);
        let end = |p: Option<&f64>| p.map_or(String::new(), |p| format::pressures(&[*p], chamber));
        Predicted::NoSolution(format!(
            "the table reaches from {} to {}; nothing is extrapolated",
            end(gauge_pa.first()),
            end(gauge_pa.last())
        ))
    }
}

/// Computed values leave nothing open.
fn exact(values: &[f64]) -> Vec<Printed> {
    values.iter().map(|&si| Printed { si, half_width_si: 0.0 }).collect()
}

/// The prediction at a point. Printed conditions are intervals: where one has a width, the prediction gets the width that its
/// ends give.
pub fn predict_at(predictor: &dyn Predictor, point: &ResponsePoint) -> Predicted {
    let conditions: Vec<f64> = point.conditions.iter().map(|c| c.si).collect();
    let mut predicted = predictor.at(&point.pressures_gauge_pa, &conditions);
    let open: Vec<usize> = (0..conditions.len()).filter(|&i| point.conditions[i].half_width_si > 0.0).collect();
    let Predicted::Value(values) = &mut predicted else { return predicted };
    // Every corner of the box that the printed digits leave open; a handful of conditions at most.
    for corner in 0..1_u32 << open.len().min(6) {
        let mut moved = conditions.clone();
        for (bit, &i) in open.iter().enumerate().take(6) {
            let half = point.conditions[i].half_width_si;
            moved[i] += if corner >> bit & 1 == 1 { half } else { -half };
        }
        if let Predicted::Value(at_corner) = predictor.at(&point.pressures_gauge_pa, &moved) {
            for (value, other) in values.iter_mut().zip(at_corner) {
                value.half_width_si = value.half_width_si.max((other.si - value.si).abs());
            }
        }
    }
    predicted
}

/// The prediction between the points of a response, one trace per set of conditions; none where the sets are too many to be
/// settings.
pub fn traces(predictor: &dyn Predictor, response: &Response) -> Vec<Trace> {
    let Some(sets) = response.condition_sets(SETS_MAX) else { return vec![] };
    let full = full_pressures(&response.pressures());
    // From the deepest vacuum to the highest pressure, zero in any case.
    let measured: Vec<f64> = response.points.iter().map(|p| share(&p.pressures_gauge_pa, &full)).collect();
    let deepest = measured.iter().copied().fold(0.0, f64::min);
    let highest = measured.iter().copied().fold(0.0, f64::max);
    let points = |conditions: &[f64]| {
        let at = |share: f64| {
            let pressures: Vec<f64> = full.iter().map(|p| share * p).collect();
            match predictor.at(&pressures, conditions) {
                Predicted::Value(values) => Some(CurvePoint { share, values: values.iter().map(|v| v.si).collect() }),
                _ => None,
            }
        };
        // Denser near zero, where bending rises like the square root of pressure.
        let step = |i: u32| (f64::from(i) / f64::from(CURVE_STEPS)).powi(2);
        let vacuum = (1..=CURVE_STEPS).rev().filter(|_| deepest < 0.0).map(|i| deepest * step(i));
        let pressure = (0..=CURVE_STEPS).map(|i| highest * step(i));
        vacuum.chain(pressure).filter_map(at).collect::<Vec<_>>()
    };
    sets.iter().map(|set| Trace { points: points(set) }).collect()
}

/// The traces through the predicted points themselves, where nothing lies between them.
pub fn traces_of_points(at: &[Predicted], response: &Response) -> Vec<Trace> {
    let Some(sets) = response.condition_sets(SETS_MAX) else { return vec![] };
    let full = full_pressures(&response.pressures());
    let of = |set: &Vec<f64>| {
        let here = |point: &ResponsePoint| point.conditions.iter().map(|c| c.si).eq(set.iter().copied());
        let mut points: Vec<CurvePoint> = response
            .points
            .iter()
            .zip(at)
            .filter(|(point, _)| here(point))
            .filter_map(|(point, predicted)| match predicted {
                Predicted::Value(values) | Predicted::InFit(values) if values.iter().all(|v| v.si.is_finite()) => {
                    let share = share(&point.pressures_gauge_pa, &full);
                    Some(CurvePoint { share, values: values.iter().map(|v| v.si).collect() })
                }
                _ => None,
            })
            .collect();
        points.sort_by(|a, b| a.share.total_cmp(&b.share));
        Trace { points }
    };
    sets.iter().map(of).collect()
}

impl Prediction {
    /// A column printed beside the measured one.
    pub fn published(response: &Response, column: &PredictedColumn) -> Self {
        let at: Vec<Predicted> =
            column.cells.iter().map(|cell| cell.clone().map_or(Predicted::NotPrinted, Predicted::Value)).collect();
        Self {
            title: column.title.clone(),
            kind: "published".to_owned(),
            source: response.source.split("; ").next().unwrap_or_default().to_owned(),
            equation: None,
            misprints: vec![],
            rests_on: vec![],
            traces: traces_of_points(&at, response),
            at,
        }
    }

    /// A user's table at the points of a response.
    pub fn imported(model: &ImportedModel, response: &Response) -> Self {
        let lines = if response.movement.is_some() {
            "the path of its rows; nothing of it is interpolated, nothing is extrapolated"
        } else {
            "straight lines between the rows of the table; nothing is extrapolated"
        };
        let mut notes = vec![lines.to_owned()];
        if model.std_si.is_some() {
            notes.push(
                "the interval of a prediction is 1.96 of the table's standard uncertainties either side: 95 %"
                    .to_owned(),
            );
        }
        Self {
            title: model.title.clone(),
            kind: "imported".to_owned(),
            source: model.source.clone(),
            equation: None,
            misprints: notes,
            rests_on: vec![],
            at: response.points.iter().map(|point| predict_at(model, point)).collect(),
            traces: if response.movement.is_some() { vec![] } else { traces(model, response) },
        }
    }

    /// A catalogue form at the points of a response.
    pub fn computed(entry: &Entry, form: &Form, rests_on: Vec<String>, response: &Response) -> Self {
        let at = response.points.iter().map(|point| predict_at(form, point)).collect();
        Self::of_entry(entry, rests_on, at, traces(form, response))
    }

    /// A catalogue form that could not be calibrated: no value at any point, and why.
    pub fn failed(entry: &Entry, rests_on: Vec<String>, response: &Response, why: &str) -> Self {
        Self::of_entry(entry, rests_on, vec![Predicted::Failed(why.to_owned()); response.points.len()], vec![])
    }

    fn of_entry(entry: &Entry, rests_on: Vec<String>, at: Vec<Predicted>, traces: Vec<Trace>) -> Self {
        Self {
            title: entry.title.to_owned(),
            kind: entry.kind.name().to_owned(),
            source: entry.source.to_owned(),
            equation: Some(entry.equation.to_owned()),
            misprints: entry.misprints.iter().map(|m| (*m).to_owned()).collect(),
            rests_on,
            at,
            traces,
        }
    }

    /// Nothing: a response that no model is compared with.
    pub fn none(response: &Response) -> Self {
        Self {
            title: "no prediction".to_owned(),
            kind: "none".to_owned(),
            source: "no model of this quantity is known".to_owned(),
            equation: None,
            misprints: vec![],
            rests_on: vec![],
            at: vec![Predicted::NotCompared; response.points.len()],
            traces: vec![],
        }
    }
}

/// The largest pressure of each chamber in size: a vacuum is a pressure too.
pub fn full_pressures(pressures_gauge_pa: &[Vec<f64>]) -> Vec<f64> {
    let chambers = pressures_gauge_pa.first().map_or(0, Vec::len);
    (0..chambers).map(|c| pressures_gauge_pa.iter().map(|p| p[c].abs()).fold(0.0, f64::max)).collect()
}

/// Share of full pressure, -1 to 1: the mean over chambers that have one.
pub fn share(pressures_gauge_pa: &[f64], full: &[f64]) -> f64 {
    let shares: Vec<f64> = pressures_gauge_pa.iter().zip(full).filter(|(_, f)| **f > 0.0).map(|(p, f)| p / f).collect();
    if shares.is_empty() { 0.0 } else { shares.iter().sum::<f64>() / shares.len() as f64 }
}

/// The inputs of a catalogue form from an actuator file, and which of them nobody printed or measured.
///
/// # Errors
/// [`AnalysisError::Input`] for a value that is missing or measures something else.
pub fn inputs(entry: &Entry, actuator: &Actuator) -> Result<(Inputs, Vec<String>), AnalysisError> {
    let mut inputs = Inputs::default();
    let mut rests_on = Vec::new();
    for parameter in entry.parameters {
        let error = |file: String, found: String| AnalysisError::Input {
            file,
            name: parameter.name.to_owned(),
            expected: format!("{}, in a unit of {}", parameter.meaning, parameter.si_unit),
            found,
        };
        let file = || actuator.file.clone();
        let value = actuator.values.get(parameter.name).ok_or_else(|| error(file(), "nothing".to_owned()))?;
        if value.unit.dimension.si_symbol() != parameter.si_unit {
            return Err(error(format!("{}:{}", file(), value.line), format!("unit `{}`", value.unit.symbol)));
        }
        if matches!(value.origin, Origin::Assumed | Origin::Calibrated) {
            rests_on.push(format!("{} {}", value.origin.name(), parameter.name));
        }
        inputs.set(parameter.name, value.si);
    }
    Ok((inputs, rests_on))
}

/// The model of a catalogue form, an actuator and perhaps changed inputs.
///
/// # Errors
/// [`AnalysisError::Model`] if the form refuses its inputs.
pub fn build(entry: &Entry, inputs: &Inputs, actuator: &Actuator) -> Result<Model, AnalysisError> {
    entry.build(inputs).map_err(|source| AnalysisError::Model {
        file: actuator.file.clone(),
        quantity: entry.quantity.to_owned(),
        form: entry.form.to_owned(),
        source,
    })
}
