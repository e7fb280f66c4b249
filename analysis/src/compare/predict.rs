//! The prediction of a comparison, perhaps of a form that is calibrated first.

use std::collections::BTreeSet;

use pneuval_ingest::error::suggestion;
use pneuval_ingest::manifest::{Abscissa, ComparisonSpec, FitSpec, HoldOut, ImportedModel, Over};
use pneuval_models::ModelError;
use pneuval_models::catalogue::{self, Entry, Inputs};
use pneuval_models::least_squares::Fit;

use super::NO_FORM;
use crate::AnalysisError;
use crate::fit::{Target, calibrate};
use crate::prediction::{self, Form, Predicted, Prediction, Predictor, inputs, predict_at, traces_of_points};
use crate::response::Response;
use crate::results::{FitRecord, FittedParameter};
use crate::study::{self, Study};
use crate::verdict::Basis;

/// A comparison that is posed.
pub(crate) struct Posed<'a> {
    /// What is predicted at the points of the response.
    pub prediction: Prediction,
    /// What was calibrated first.
    pub fit: Option<FitRecord>,
    /// What predicts at any other pressure.
    pub between: Between<'a>,
    /// Why the data of a session could not be fitted: then nothing is predicted.
    pub refused: Option<AnalysisError>,
}

/// What gives a value at any pressure.
pub(crate) enum Between<'a> {
    /// A catalogue form, calibrated or not.
    Form(Form<'a>),
    /// A user's table.
    Imported(&'a ImportedModel),
    /// A user's table as a path: its rows meet a movement.
    Path(&'a ImportedModel),
    /// Nothing does, and why.
    Nothing(&'static str),
}

impl Between<'_> {
    /// What predicts.
    pub fn predictor(&self) -> Result<&dyn Predictor, &'static str> {
        match self {
            Self::Form(form) => Ok(form),
            Self::Imported(model) => Ok(*model),
            Self::Path(_) => Err("it is a path, which meets what was measured at its own rows only"),
            Self::Nothing(why) => Err(why),
        }
    }
}

/// The prediction of a comparison: a printed column, a user's table, or a catalogue form, perhaps calibrated first.
pub(crate) fn predict<'a>(
    study: &'a Study,
    spec: &'a ComparisonSpec,
    response: &'a Response,
) -> Result<Posed<'a>, AnalysisError> {
    if let Some(column) = response.columns.iter().find(|p| p.form == spec.form) {
        let between = Between::Nothing("it is printed, and only at the points of its table");
        return Ok(Posed { prediction: Prediction::published(response, column), fit: None, between, refused: None });
    }
    if spec.form == NO_FORM {
        let between = Between::Nothing("no model of this quantity is known");
        return Ok(Posed { prediction: Prediction::none(response), fit: None, between, refused: None });
    }
    let actuator = &study.input.actuator;
    let model_form = spec.model.as_deref().unwrap_or(&spec.form);
    let imported = actuator.imported.iter().filter(|m| m.quantity.id == spec.quantity);
    if let Some(model) = imported.clone().find(|m| m.form == model_form) {
        if let Some(fit) = &spec.fit {
            return Err(AnalysisError::UnknownParameter {
                file: study.input.file.clone(),
                line: spec.line,
                form: model.form.clone(),
                name: fit.parameters.join(", "),
                next: "remove `fit`: a table has no parameters".to_owned(),
            });
        }
        let fits = model.quantity.unit.dimension == response.quantity.unit.dimension
            && model.quantity.components == response.quantity.components
            && meets(&model.over, response);
        if !fits {
            return Err(mismatch(
                study,
                spec,
                response,
                &format!("a unit of {}, {}", model.quantity.unit.dimension.si_symbol(), over(model, response)),
            ));
        }
        let prediction = Prediction::imported(model, response);
        let between = if response.movement.is_some() { Between::Path(model) } else { Between::Imported(model) };
        return Ok(Posed { prediction, fit: None, between, refused: None });
    }
    let forms = || catalogue::entries().filter(|e| e.actuator == actuator.kind && e.quantity == spec.quantity);
    let Some(entry) = forms().find(|e| e.form == model_form) else {
        return Err(unknown_form(study, spec, forms().map(|e| e.form).chain(imported.map(|m| m.form.as_str()))));
    };
    if !study::suits(entry, response) {
        let mut expected = format!("a unit of {}, chambers {}", entry.quantity_si_unit, entry.chambers.join(", "));
        if response.movement.is_some() {
            expected = format!("points at equal pressure (a form knows no time), {expected}");
        }
        if !entry.components.is_empty() {
            expected = format!("{expected}, components {}", entry.components.join(", "));
        }
        if !entry.conditions.is_empty() {
            let names: Vec<String> = entry.conditions.iter().map(|c| format!("{} / {}", c.name, c.si_unit)).collect();
            expected = format!("{expected}, conditions {}", names.join(", "));
        }
        return Err(mismatch(study, spec, response, &expected));
    }
    let (values, mut rests_on) = inputs(entry, actuator)?;
    let Some(fit) = &spec.fit else {
        // Under conditions, which vary, only the points can tell whether the inputs are good.
        if entry.conditions.is_empty() {
            prediction::build(entry, &values, actuator)?;
        }
        let form = Form::new(entry, values, &response.conditions);
        let prediction = Prediction::computed(entry, &form, rests_on, response);
        return Ok(Posed { prediction, fit: None, between: Between::Form(form), refused: None });
    };
    // What is fitted here does not rest on what the actuator file says of it.
    rests_on.retain(|text| !fit.parameters.iter().any(|name| text.ends_with(&format!(" {name}"))));
    let calibration = Calibration { study, spec, fit, entry, values, response };
    calibration.run(rests_on.clone()).or_else(|error| calibration.open(error, rests_on))
}

/// Whether a table rises with what a response is compared at. A path needs no stamps of its own to be compared at equal arc length.
fn meets(over: &Over, response: &Response) -> bool {
    match (over, &response.movement) {
        (Over::Pressure { chamber, .. }, None) => response.chambers == [chamber.as_str()],
        (Over::Pressure { .. }, Some(movement)) => movement.rule.at == Abscissa::ArcLength,
        (Over::Time { .. }, movement) => movement.is_some(),
    }
}

/// Over what a table is, and with what response it is compared.
fn over(model: &ImportedModel, response: &Response) -> String {
    let mut text = match &model.over {
        Over::Pressure { chamber, .. } if response.movement.is_some() => {
            format!(
                "points at equal pressure of chamber {chamber}, or at equal arc length (it is a table over pressure)"
            )
        }
        Over::Pressure { chamber, .. } => format!("chamber {chamber}"),
        Over::Time { .. } => {
            "points = { from = \"trajectory\", at = \"time\" or \"arc-length\" } (it is a table over time)".to_owned()
        }
    };
    if !model.quantity.components.is_empty() {
        text = format!("{text}, components {}", model.quantity.components.join(", "));
    }
    text
}

fn mismatch(study: &Study, spec: &ComparisonSpec, response: &Response, expected: &str) -> AnalysisError {
    let mut found = format!("unit `{}`, chambers {}", response.quantity.unit.symbol, response.chambers.join(", "));
    if let Some(movement) = &response.movement {
        found = format!("unit `{}`, at equal {}", response.quantity.unit.symbol, movement.rule.at.id());
    }
    if !response.quantity.components.is_empty() {
        found = format!("{found}, components {}", response.quantity.components.join(", "));
    }
    if !response.conditions.is_empty() {
        let ids: Vec<String> = response.conditions.iter().map(|c| format!("{} / {}", c.id, c.unit.symbol)).collect();
        found = format!("{found}, conditions {}", ids.join(", "));
    }
    AnalysisError::Mismatch {
        file: study.input.file.clone(),
        line: spec.line,
        quantity: spec.quantity.clone(),
        form: spec.form.clone(),
        expected: expected.to_owned(),
        found,
    }
}

pub(super) fn unknown_form<'a>(
    study: &'a Study,
    spec: &ComparisonSpec,
    forms: impl IntoIterator<Item = &'a str>,
) -> AnalysisError {
    let printed = study.response(&spec.quantity).into_iter().flat_map(|r| r.columns.iter().map(|p| p.form.as_str()));
    let form = spec.model.as_deref().unwrap_or(&spec.form);
    AnalysisError::UnknownForm {
        file: study.input.file.clone(),
        line: spec.line,
        quantity: spec.quantity.clone(),
        form: form.to_owned(),
        next: suggestion(form, printed.chain(forms)),
    }
}

/// Pressures that may be left out one at a time: each costs a fit.
const FOLDS_MAX: usize = 200;

/// A form that is fitted before it is compared.
struct Calibration<'a> {
    study: &'a Study<'a>,
    spec: &'a ComparisonSpec,
    fit: &'a FitSpec,
    entry: &'a Entry,
    values: Inputs,
    response: &'a Response,
}

impl<'a> Calibration<'a> {
    fn run(&self, rests_on: Vec<String>) -> Result<Posed<'a>, AnalysisError> {
        let known = |name: &&String| self.entry.parameters.iter().any(|p| p.name == name.as_str());
        if let Some(name) = self.fit.parameters.iter().find(|name| !known(name)) {
            return Err(AnalysisError::UnknownParameter {
                file: self.study.input.file.clone(),
                line: self.spec.line,
                form: self.entry.form.to_owned(),
                name: name.clone(),
                next: suggestion(name, self.entry.parameters.iter().map(|p| p.name)),
            });
        }
        let targets = self.targets();
        if let Some(value) = targets.iter().flatten().flat_map(|t| &t.values_si).find(|v| !v.is_finite()) {
            return Err(self.failed(ModelError::OutOfDomain {
                symbol: "value to fit",
                value: *value,
                domain: "finite",
            }));
        }
        let numbers = pressure_numbers(self.response);
        let odd = |i: usize| numbers[i] % 2 == 1;
        let seen = |i: &usize| self.fit.hold_out != HoldOut::OddPressures || !odd(*i);
        let chosen: Vec<&Target> = (0..targets.len()).filter(seen).filter_map(|i| targets[i].as_ref()).collect();
        let judged = (0..targets.len()).any(|i| targets[i].is_some() && odd(i));
        if self.fit.hold_out == HoldOut::OddPressures && !judged {
            return Err(self.nothing_held_out());
        }
        let (inputs, found) = self.calibrate(&chosen)?;
        let form = Form::new(self.entry, inputs, &self.response.conditions);
        let mut prediction = Prediction::computed(self.entry, &form, rests_on, self.response);
        let mut between = Between::Form(form);
        match self.fit.hold_out {
            HoldOut::None => {}
            HoldOut::OddPressures => {
                let fitted = |i: &usize| targets[*i].is_some() && !odd(*i);
                for (_, at) in prediction.at.iter_mut().enumerate().filter(|(i, _)| fitted(i)) {
                    if let Predicted::Value(values) = at {
                        *at = Predicted::InFit(std::mem::take(values));
                    }
                }
            }
            HoldOut::OnePressure => {
                let mut left_out: Vec<usize> = (0..targets.len()).filter(|&i| targets[i].is_some()).collect();
                left_out.sort_by_key(|&i| numbers[i]);
                if !(2..=FOLDS_MAX).contains(&self.pressures_to_fit()) {
                    return Err(self.nothing_held_out());
                }
                for group in left_out.chunk_by(|&a, &b| numbers[a] == numbers[b]) {
                    let others: Vec<&Target> =
                        (0..targets.len()).filter(|i| !group.contains(i)).filter_map(|i| targets[i].as_ref()).collect();
                    let (inputs, _) = self.calibrate(&others)?;
                    let form = Form::new(self.entry, inputs, &self.response.conditions);
                    for &i in group {
                        prediction.at[i] = predict_at(&form, &self.response.points[i]);
                    }
                }
                prediction.traces = traces_of_points(&prediction.at, self.response);
                between =
                    Between::Nothing("each pressure is predicted by a fit of its own, so only the points have a value");
            }
        }
        Ok(Posed { prediction, fit: Some(self.record(&found, chosen.len())), between, refused: None })
    }

    /// The comparison without a prediction, where the data of a session refuse the fit: what an instrument wrote is no mistake
    /// of the user's, and must not hide what else is known of the session. Every other error stays one.
    fn open(&self, error: AnalysisError, rests_on: Vec<String>) -> Result<Posed<'a>, AnalysisError> {
        let why = match &error {
            _ if self.response.basis != Basis::Session => return Err(error),
            AnalysisError::Fit { source, .. } if self.can_start() => format!("the fit failed: {source}"),
            // More pressures than may be held out are a rule of the manifest that does not suit a trajectory.
            AnalysisError::HoldOut { .. } if self.pressures_to_fit() <= FOLDS_MAX => {
                "the fit failed: too few pressures beside zero were measured to hold one out".to_owned()
            }
            _ => return Err(error),
        };
        let prediction = Prediction::failed(self.entry, rests_on, self.response, &why);
        let between = Between::Nothing("the fit failed");
        Ok(Posed { prediction, fit: None, between, refused: Some(error) })
    }

    /// Whether the values of the actuator file are some that a fit can start from. Under conditions, which are measured, only
    /// the points can tell whether the form takes them.
    fn can_start(&self) -> bool {
        let start = |name: &String| self.values.get(name).is_some_and(|value| value.is_finite() && value != 0.0);
        self.fit.parameters.iter().all(start)
            && (!self.entry.conditions.is_empty() || self.entry.build(&self.values).is_ok())
    }

    /// How many pressures have a value to fit.
    fn pressures_to_fit(&self) -> usize {
        let numbers = pressure_numbers(self.response).into_iter().zip(self.targets());
        let fitted: BTreeSet<usize> = numbers.filter_map(|(number, target)| target.map(|_| number)).collect();
        fitted.len()
    }

    /// Per point, the value to fit; none at the zero-pressure reference, which would count as a point without being one: it
    /// holds for every material.
    fn targets(&self) -> Vec<Option<Target>> {
        let column = self.response.columns.iter().find(|p| p.form == self.fit.to);
        let value = |i: usize| match column {
            Some(column) => column.cells[i].as_ref(),
            None => self.response.points[i].measured.as_ref(),
        };
        let points = self.response.points.iter().enumerate();
        points
            .map(|(i, point)| {
                let values = value(i).filter(|_| !self.response.is_zero_reference(point) && !point.is_apart)?;
                Some(Target {
                    pressures_gauge_pa: point.pressures_gauge_pa.clone(),
                    conditions_si: point.conditions.iter().map(|c| c.si).collect(),
                    values_si: values.iter().map(|v| v.si).collect(),
                })
            })
            .collect()
    }

    fn calibrate(&self, targets: &[&Target]) -> Result<(Inputs, Fit), AnalysisError> {
        let conditions = &self.response.conditions;
        calibrate(self.entry, &self.values, conditions, &self.fit.parameters, targets).map_err(|e| self.failed(e))
    }

    fn nothing_held_out(&self) -> AnalysisError {
        AnalysisError::HoldOut {
            file: self.study.input.file.clone(),
            line: self.spec.line,
            form: self.spec.form.clone(),
            limit: FOLDS_MAX,
        }
    }

    fn failed(&self, source: ModelError) -> AnalysisError {
        AnalysisError::Fit {
            file: self.study.input.file.clone(),
            line: self.spec.line,
            form: self.spec.form.clone(),
            source,
        }
    }

    fn record(&self, found: &Fit, n: usize) -> FitRecord {
        let values = &self.study.input.actuator.values;
        let parameters = self.fit.parameters.iter().enumerate().map(|(i, name)| FittedParameter {
            name: name.clone(),
            value_si: found.parameters[i],
            std_si: found.parameters_std.as_ref().map(|std| std[i]),
            unit: values.get(name).map_or("1", |v| v.unit.symbol).to_owned(),
        });
        FitRecord {
            fitted_on: vec![format!("{}/{} {}", self.study.id, self.response.quantity.id, self.fit.to)],
            hold_out: self.fit.hold_out.label().map(str::to_owned),
            parameters: parameters.collect(),
            rmse_si: found.rmse,
            n,
            condition_number: found.condition_number,
        }
    }
}

/// Per point, the number of its nominal pressure by rising share of full pressure: the lowest is 0. Measured pressures within
/// the response's tolerance of a nominal one are that one, or a fit would see what it is judged on.
fn pressure_numbers(response: &Response) -> Vec<usize> {
    let all = response.pressures();
    let full = prediction::full_pressures(&all);
    let order = |a: &Vec<f64>, b: &Vec<f64>| {
        let shares = prediction::share(a, &full).total_cmp(&prediction::share(b, &full));
        let chambers = a.iter().zip(b).map(|(a, b)| a.total_cmp(b)).find(|o| o.is_ne());
        shares.then(chambers.unwrap_or(std::cmp::Ordering::Equal))
    };
    let mut rising: Vec<usize> = (0..all.len()).collect();
    rising.sort_by(|&a, &b| order(&all[a], &all[b]));
    let mut numbers = vec![0; all.len()];
    let (mut number, mut nominal): (usize, Option<&Vec<f64>>) = (0, None);
    for i in rising {
        let same = |first: &Vec<f64>| first.iter().zip(&all[i]).all(|(a, b)| (a - b).abs() <= response.same_within_pa);
        match nominal {
            Some(first) if same(first) => {}
            Some(_) => (number, nominal) = (number + 1, Some(&all[i])),
            None => nominal = Some(&all[i]),
        }
        numbers[i] = number;
    }
    numbers
}
