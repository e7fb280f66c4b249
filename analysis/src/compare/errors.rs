//! What may move the values of a session's comparison: repeats, instruments, the model's inputs, numerics.

use pneuval_ingest::manifest::{ComparisonSpec, HoldOut, ImportedModel};
use pneuval_models::catalogue::Parameter;

use super::predict::{Between, Posed, predict};
use crate::prediction::{Form, Predicted, Predictor, full_pressures, predict_at};
use crate::response::{Repeat, Response, ResponsePoint, Target};
use crate::results::InputsRecord;
use crate::study::Study;
use crate::uncertainty::coverage::Z95;
use crate::uncertainty::errors::{Cause, Errors, Factor, Source};
use crate::uncertainty::inputs::{Input, Sampling, Spread, propagate};
use crate::uncertainty::scatter::{Apart, scatter};

/// The step over which the slope of a prediction is taken, as a share of the full pressure or of the condition.
const SLOPE_SHARE: f64 = 1e-3;

/// What rounding and the end of a bracketed root leave of a computed value, as a share of it.
const SOLVER_SHARE: f64 = 8.0 * f64::EPSILON;

/// Samples of the model's inputs: never more than the second, and with a slow model no fewer than the first, whatever
/// [`EVALUATIONS_MAX`] says.
const SAMPLES: (usize, usize) = (256, 8192);

/// Evaluations of the model in all.
const EVALUATIONS_MAX: usize = 200_000;

/// Quantiles of the prediction are settled when a doubling moves none by more than this share of its standard uncertainty.
const SETTLED_SHARE: f64 = 0.1;

/// The standard deviation of what lies anywhere within ± 1.
const RECTANGULAR: f64 = 0.577_350_269_189_625_8;

/// Everything that may move the measured and predicted values at the points of a response, and what became of the model's
/// inputs. The repeats are for whoever picks points to count.
///
/// What was fitted to these very values moves with them: every direction goes through the fit. What a parameter scatters by is in
/// them, and nothing of its own is added.
pub(super) fn errors(
    study: &Study,
    spec: &ComparisonSpec,
    response: &Response,
    posed: &Posed,
) -> (Errors, Option<InputsRecord>) {
    let mut errors = Errors::default();
    let mut inputs = None;
    let zeros = || vec![0.0; response.points.len() * response.quantity.width()];
    let refit = posed.fit.as_ref().map(|_| Refit { study, spec, response, posed });
    let may_pool = refit.as_ref().is_none_or(Refit::is_quick);
    add_scatter(&mut errors, response, scatters(response, &|target| known(slopes(response, posed, target))), may_pool);
    let mut names: Vec<&str> = Vec::new();
    for instrument in &response.instruments {
        if !names.contains(&instrument.source.as_str()) {
            names.push(&instrument.source);
        }
    }
    for name in names {
        let mut moved = (zeros(), zeros());
        let mut cause = Cause::State;
        let mut unknown = 0;
        for instrument in response.instruments.iter().filter(|i| i.source == name) {
            if let Target::Component(_) = instrument.target {
                cause = Cause::Instrument;
            }
            unknown = unknown.max(add_instrument(&mut moved, response, posed, instrument.target, instrument.std_si));
        }
        let name = match unknown {
            0 => name.to_owned(),
            n => format!("{name} (without {n} of {} values, which tell no slope of the prediction)", moved.0.len()),
        };
        errors.add(Source::new(name, cause), [moved]);
    }
    let values = |of: &dyn Fn(usize, usize, f64) -> f64| -> Vec<f64> {
        let width = response.quantity.width();
        let value = |i: usize, c: usize| number(&posed.prediction.at[i], c).map_or(0.0, |v| of(i, c, v));
        (0..response.points.len()).flat_map(|i| (0..width).map(move |c| (i, c))).map(|(i, c)| value(i, c)).collect()
    };
    match &posed.between {
        // Straight lines between its rows are what the table says, by declaration; what its own numerics leave open is for its `std`.
        Between::Imported(model) => {
            let std = |i: usize, c: usize| std_at(model, &response.points[i], c);
            errors.add(
                Source::new(format!("std of {}", model.form), Cause::Input),
                [(zeros(), values(&|i, c, _| std(i, c)))],
            );
        }
        // The table's standard uncertainty of the row that meets each point.
        Between::Path(model) => {
            let std = |i: usize, c: usize| match &posed.prediction.at[i] {
                Predicted::Value(row) => row.get(c).map_or(0.0, |v| v.half_width_si / Z95),
                _ => 0.0,
            };
            errors.add(
                Source::new(format!("std of {}", model.form), Cause::Input),
                [(zeros(), values(&|i, c, _| std(i, c)))],
            );
        }
        Between::Form(form) => {
            let open = values(&|_, _, v| RECTANGULAR * SOLVER_SHARE * v);
            errors.add(Source::new("solver and rounding", Cause::Numerical), [(zeros(), open)]);
            inputs = add_inputs(&mut errors, study, response, posed, form);
        }
        Between::Nothing(_) => {}
    }
    if let Some(refit) = &refit {
        for factor in &mut errors.factors {
            let source = &mut errors.sources[factor.source].name;
            if !refit.follow(factor) && !source.ends_with(FIT_FAILED) {
                *source += FIT_FAILED;
            }
        }
    }
    (errors, inputs)
}

/// Said of a source that could not be followed through a calibration.
const FIT_FAILED: &str = ", but for the fit, which failed where it was moved";

/// Refits of a calibration beyond which no scatter is pooled: that has a direction for each value.
const REFITS_MAX: usize = 2000;

/// A calibration that is done again with its data moved.
struct Refit<'a> {
    study: &'a Study<'a>,
    spec: &'a ComparisonSpec,
    response: &'a Response,
    posed: &'a Posed<'a>,
}

impl Refit<'_> {
    /// Whether it can be done again for every value.
    fn is_quick(&self) -> bool {
        let n = self.response.points.len();
        let folds = if self.spec.fit.as_ref().is_some_and(|fit| fit.hold_out == HoldOut::OnePressure) { n } else { 1 };
        n * self.response.quantity.width() * folds <= REFITS_MAX
    }

    /// What a direction does to the predicted values, through the fit too. What it does to the state, by the slope of the
    /// prediction, is for the fit as if it did the contrary to what was measured. Whether the fit could be done again.
    fn follow(&self, factor: &mut Factor) -> bool {
        let width = self.response.quantity.width();
        let mut moved = self.response.clone();
        for (i, point) in moved.points.iter_mut().enumerate() {
            for (c, value) in point.measured.iter_mut().flatten().enumerate() {
                let at = i * width + c;
                value.si += factor.measured[at] - factor.predicted[at];
            }
        }
        // One that fails leaves the prediction where it is, and is told.
        let Ok(again) = predict(self.study, self.spec, &moved) else { return false };
        for (at, by) in factor.predicted.iter_mut().enumerate() {
            let of = |posed: &Posed| number(&posed.prediction.at[at / width], at % width);
            if let Some((after, before)) = of(&again).zip(of(self.posed)) {
                *by += after - before;
            }
        }
        true
    }
}

/// The inputs of a form with a declared standard uncertainty, by Monte Carlo: the linear part of each is a direction, and what is left is
/// another, as if it moved all values together.
fn add_inputs(
    errors: &mut Errors,
    study: &Study,
    response: &Response,
    posed: &Posed,
    form: &Form,
) -> Option<InputsRecord> {
    let declared = &study.input.actuator.values;
    let is_fitted = |name: &str| posed.fit.iter().flat_map(|fit| &fit.parameters).any(|p| p.name == name);
    let input = |parameter: &Parameter| {
        let std = declared.get(parameter.name).filter(|_| !is_fitted(parameter.name))?.std_si?;
        let mean = form.input(parameter.name)?;
        // A length or a modulus has no other sign; an angle or an offset may.
        let positive = mean > 0.0 && !matches!(parameter.si_unit, "rad" | "1");
        (std > 0.0).then(|| Input { name: parameter.name.to_owned(), mean, std, positive })
    };
    let inputs: Vec<Input> = form.parameters().filter_map(input).collect();
    if inputs.is_empty() {
        return None;
    }
    let width = response.quantity.width();
    let places: Vec<usize> = (0..response.points.len())
        .filter(|&i| number(&posed.prediction.at[i], 0).is_some() && response.points[i].measured.is_some())
        .collect();
    let predict = |values: &[f64]| -> Option<Vec<f64>> {
        let changed: Vec<(&str, f64)> = inputs.iter().zip(values).map(|(input, v)| (input.name.as_str(), *v)).collect();
        let form = form.with(&changed);
        let mut predicted = Vec::with_capacity(places.len() * width);
        for &i in &places {
            let Predicted::Value(values) = predict_at(&form, &response.points[i]) else { return None };
            predicted.extend(values.iter().map(|v| v.si));
        }
        Some(predicted)
    };
    let samples_max = (EVALUATIONS_MAX / places.len().max(1)).clamp(SAMPLES.0, SAMPLES.1);
    let sampling = Sampling { seed: 0, samples_max, settled_share: SETTLED_SHARE };
    let names = inputs.iter().map(|input| input.name.clone()).collect();
    let spread = match propagate(&inputs, &sampling, &predict) {
        Ok(spread) => spread,
        Err(why) => {
            let without =
                InputsRecord { names, samples: 0, settled: false, without_solution: 0, problem: Some(why.to_string()) };
            return Some(without);
        }
    };
    // From the places back to all points.
    let scatter = |of: &dyn Fn(usize) -> f64| -> Vec<f64> {
        let mut all = vec![0.0; response.points.len() * width];
        for (k, &i) in places.iter().enumerate() {
            for c in 0..width {
                all[i * width + c] = of(k * width + c);
            }
        }
        all
    };
    let zeros = || vec![0.0; response.points.len() * width];
    for (input, linear) in inputs.iter().zip(&spread.linear) {
        let source = Source::new(&input.name, Cause::Input);
        errors.add(source, [(zeros(), scatter(&|k| linear[k]))]);
    }
    let curved = Source::new("inputs, beyond their linear part", Cause::Input);
    errors.add(curved, [(zeros(), scatter(&|k| spread.places[k].remainder))]);
    let problem = (!spread.settled).then(|| {
        format!("the quantiles still moved by {:.2} standard uncertainties at the last doubling", spread.moved)
    });
    let Spread { samples, without_solution, settled, .. } = spread;
    Some(InputsRecord { names, samples, settled, without_solution, problem })
}

/// What may move the measured values alone: repeats and the instruments that read them.
pub(crate) fn of_measured(response: &Response) -> Errors {
    let mut errors = Errors { repeats: fewest(response), ..Errors::default() };
    let width = response.quantity.width();
    let measured: Vec<Predicted> =
        response.points.iter().map(|p| p.measured.clone().map_or(Predicted::NotPrinted, Predicted::Value)).collect();
    let slopes = |target| -> Vec<f64> {
        let places = (0..response.points.len()).flat_map(|i| (0..width).map(move |c| (i, c)));
        known(places.map(|(i, c)| of_neighbours(response, &measured, i, target, c)).collect())
    };
    // What was read at another pressure is another value at this one.
    let scatter = scatters(response, &slopes).into_iter().map(|(measured, by_state)| {
        let zeros = vec![0.0; measured.len()];
        (measured.iter().zip(by_state).map(|(m, by)| m - by).collect(), zeros)
    });
    add_scatter(&mut errors, response, scatter.collect(), true);
    for instrument in &response.instruments {
        let Target::Component(component) = instrument.target else { continue };
        let mut moved = vec![0.0; response.points.len() * width];
        moved.iter_mut().skip(component).step_by(width).for_each(|value| *value = instrument.std_si);
        let source = Source::new(&instrument.source, Cause::Instrument);
        errors.add(source, [(moved, vec![0.0; response.points.len() * width])]);
    }
    errors
}

/// Slopes as far as they are known: repeats that read at other pressures are then as far apart as they were read.
fn known(slopes: Vec<Option<f64>>) -> Vec<f64> {
    slopes.into_iter().map(|slope| slope.unwrap_or(0.0)).collect()
}

fn fewest(response: &Response) -> usize {
    response.points.iter().filter(|p| !p.is_apart && p.repeats.len() > 1).map(|p| p.repeats.len()).min().unwrap_or(0)
}

/// The scatter of repeats, each a direction; of few repeats what they have in common, and what is each point's own pooled over points.
fn add_scatter(errors: &mut Errors, response: &Response, scatters: Vec<(Vec<f64>, Vec<f64>)>, may_pool: bool) {
    let width = response.quantity.width();
    let n = response.points.iter().map(|p| p.repeats.len()).max().unwrap_or(0);
    let name = format!("{n} repeats");
    let Some((repeats, places)) = response.read_by_all_repeats().filter(|(repeats, _)| repeats.len() == n) else {
        errors.add(Source::new(name, Cause::Repeats), scatters);
        return;
    };
    let mean = |at: &usize| response.points[at / width].measured.as_ref().map_or(f64::NAN, |m| m[at % width].si);
    let means: Vec<f64> = places.iter().map(mean).collect();
    // Back from what a repeat adds to the mean to its deviation; at equal pressure.
    let scale = ((n * n.saturating_sub(1)) as f64).sqrt();
    let at_equal = |of: &(Vec<f64>, Vec<f64>)| places.iter().map(|&i| scale * (of.0[i] - of.1[i])).collect();
    let deviations: Vec<Vec<f64>> = repeats.iter().filter_map(|&k| scatters.get(k)).map(at_equal).collect();
    let pooled = if may_pool {
        scatter(&deviations, &means, &response.read_on_the_way_down(&places), width)
    } else {
        Err(Apart::Plain)
    };
    let found = match pooled {
        Ok(found) => found,
        Err(apart) => {
            let why = match apart {
                Apart::Plain => "",
                Apart::Together => ", not pooled: neighbouring points deviate together",
                Apart::Loop => ", not pooled: loading and unloading deviate from each other",
                Apart::Uneven => ", not pooled: one point scatters more than the others",
            };
            errors.add(Source::new(format!("{name}{why}"), Cause::Repeats), scatters);
            return;
        }
    };
    let mut common = scatters;
    for (k, (measured, predicted)) in common.iter_mut().enumerate() {
        let of = repeats.iter().position(|index| *index == k).and_then(|row| found.common.get(row));
        for (place, &at) in places.iter().enumerate() {
            (measured[at], predicted[at]) = (of.map_or(0.0, |of| of[place]), 0.0);
        }
    }
    errors.add(Source::new(name.as_str(), Cause::Repeats), common);
    let zeros = || vec![0.0; response.points.len() * width];
    let own = found.own.iter().map(|direction| {
        let mut moved = zeros();
        places.iter().zip(direction).for_each(|(&at, by)| moved[at] = *by);
        (moved, zeros())
    });
    let source =
        Source { pooled: Some(found.freedom), ..Source::new(format!("{name}, point by point"), Cause::Repeats) };
    errors.add(source, own);
}

/// What each repeat adds to the mean of its points: over all repeats the squares sum up to the variance of the mean. Repeats
/// differ in the pressures at which they read, too, and by the slope of the prediction in what is predicted for them.
fn scatters(response: &Response, slopes: &dyn Fn(Target) -> Vec<f64>) -> Vec<(Vec<f64>, Vec<f64>)> {
    // Of the samples of a movement nothing is a repeat.
    if response.repeats.is_empty() {
        return vec![];
    }
    let width = response.quantity.width();
    let of_chambers: Vec<Vec<f64>> = (0..response.chambers.len()).map(|c| slopes(Target::Pressure(c))).collect();
    let of_conditions: Vec<Vec<f64>> = (0..response.conditions.len()).map(|c| slopes(Target::Condition(c))).collect();
    let of = |repeat: usize| {
        let mut moved = (Vec::new(), Vec::new());
        for (i, point) in response.points.iter().enumerate() {
            let n = point.repeats.len() as f64;
            let here = point.repeats.iter().find(|r| r.index == repeat).filter(|_| point.repeats.len() >= 2);
            let (Some(here), Some(mean)) = (here, &point.measured) else {
                moved.0.extend(vec![0.0; width]);
                moved.1.extend(vec![0.0; width]);
                continue;
            };
            let scale = (n * (n - 1.0)).sqrt();
            // The mean over the repeats: that of the point is over all readings, of which a repeat may have more than another.
            let middle = |of: &dyn Fn(&Repeat) -> f64| point.repeats.iter().map(of).sum::<f64>() / n;
            for (component, (value, mean)) in here.measured.iter().zip(mean).enumerate() {
                moved.0.push((value - mean.si) / scale);
                let at = i * width + component;
                let by_pressure: f64 = of_chambers
                    .iter()
                    .enumerate()
                    .map(|(c, slope)| slope[at] * (here.pressures_gauge_pa[c] - middle(&|r| r.pressures_gauge_pa[c])))
                    .sum();
                let by_condition: f64 = of_conditions
                    .iter()
                    .enumerate()
                    .map(|(c, slope)| slope[at] * (here.conditions[c] - middle(&|r| r.conditions[c])))
                    .sum();
                moved.1.push((by_pressure + by_condition) / scale);
            }
        }
        moved
    };
    (0..response.repeats.len()).map(of).collect()
}

/// Adds what an instrument that is off by one standard uncertainty moves; the values that are predicted and tell no slope, of which nothing
/// is known.
fn add_instrument(
    moved: &mut (Vec<f64>, Vec<f64>),
    response: &Response,
    posed: &Posed,
    target: Target,
    std: f64,
) -> usize {
    let width = response.quantity.width();
    match target {
        Target::Component(component) => {
            moved.0.iter_mut().skip(component).step_by(width).for_each(|value| *value += std);
            0
        }
        Target::Pressure(_) | Target::Condition(_) => {
            let slopes = slopes(response, posed, target);
            let is_predicted = |at: usize| number(&posed.prediction.at[at / width], at % width).is_some();
            moved.1.iter_mut().zip(&slopes).for_each(|(value, slope)| *value += slope.unwrap_or(0.0) * std);
            (0..slopes.len()).filter(|&at| slopes[at].is_none() && is_predicted(at)).count()
        }
    }
}

fn number(predicted: &Predicted, component: usize) -> Option<f64> {
    match predicted {
        Predicted::Value(values) | Predicted::InFit(values) => values.get(component).map(|v| v.si),
        _ => None,
    }
    .filter(|v| v.is_finite())
}

/// The slope of the prediction over a pressure or condition, at each point and component: by the form itself, else between its neighbours;
/// `None` where neither tells it.
fn slopes(response: &Response, posed: &Posed, target: Target) -> Vec<Option<f64>> {
    let width = response.quantity.width();
    let full = match target {
        Target::Pressure(_) => full_pressures(&response.pressures()),
        _ => largest_conditions(response),
    };
    let at = &posed.prediction.at;
    let mut slopes = Vec::with_capacity(response.points.len() * width);
    for (i, point) in response.points.iter().enumerate() {
        for component in 0..width {
            let of_form = posed.between.predictor().ok().and_then(|p| of_predictor(p, point, target, &full, component));
            slopes.push(of_form.or_else(|| of_neighbours(response, at, i, target, component)));
        }
    }
    slopes
}

/// The largest size of each condition.
fn largest_conditions(response: &Response) -> Vec<f64> {
    let size = |i: usize| response.points.iter().filter_map(move |p| p.conditions.get(i)).map(|c| c.si.abs());
    (0..response.conditions.len()).map(|i| size(i).fold(0.0, f64::max)).collect()
}

fn of_predictor(
    predictor: &dyn Predictor,
    point: &ResponsePoint,
    target: Target,
    full: &[f64],
    component: usize,
) -> Option<f64> {
    let conditions: Vec<f64> = point.conditions.iter().map(|c| c.si).collect();
    let value = |by: f64| {
        let (mut pressures, mut conditions) = (point.pressures_gauge_pa.clone(), conditions.clone());
        match target {
            Target::Pressure(chamber) => *pressures.get_mut(chamber)? += by,
            Target::Condition(index) => *conditions.get_mut(index)? += by,
            Target::Component(_) => return None,
        }
        number(&predictor.at(&pressures, &conditions), component)
    };
    let scale = match target {
        Target::Pressure(chamber) => full.get(chamber).copied().unwrap_or(0.0),
        // At a condition of zero its step is that of the others.
        Target::Condition(index) => full.get(index).copied().unwrap_or(0.0),
        Target::Component(_) => 0.0,
    };
    let step = SLOPE_SHARE * scale;
    if step <= 0.0 {
        return None;
    }
    // At an end of the form one side is all there is.
    let (below, here, above) = (value(-step), value(0.0), value(step));
    match (below, here, above) {
        (Some(below), _, Some(above)) => Some((above - below) / (2.0 * step)),
        (None, Some(here), Some(above)) => Some((above - here) / step),
        (Some(below), Some(here), None) => Some((here - below) / step),
        _ => None,
    }
}

/// The slope between the neighbours of a point: on its branch, with its other pressures and conditions.
fn of_neighbours(response: &Response, at: &[Predicted], i: usize, target: Target, component: usize) -> Option<f64> {
    let here = &response.points[i];
    let along = |p: &ResponsePoint| match target {
        Target::Pressure(chamber) => p.pressures_gauge_pa.get(chamber).copied(),
        Target::Condition(index) => p.conditions.get(index).map(|c| c.si),
        Target::Component(_) => None,
    };
    let alike = |p: &&(usize, &ResponsePoint)| {
        let pressures = p.1.pressures_gauge_pa.iter().zip(&here.pressures_gauge_pa).enumerate();
        let conditions = p.1.conditions.iter().zip(&here.conditions).enumerate();
        p.1.branch == here.branch
            && pressures
                .filter(|(c, _)| target != Target::Pressure(*c))
                .all(|(_, (a, b))| (a - b).abs() <= response.same_within_pa)
            && conditions
                .filter(|(c, _)| target != Target::Condition(*c))
                .all(|(_, (a, b))| (a.si - b.si).abs() <= 0.01 * b.si.abs())
    };
    let x0 = along(here)?;
    let all: Vec<(usize, &ResponsePoint)> = response.points.iter().enumerate().collect();
    let others = all.iter().filter(alike).filter_map(|(j, p)| Some((along(p)?, number(&at[*j], component)?)));
    let mut below: Option<(f64, f64)> = None;
    let mut above: Option<(f64, f64)> = None;
    for (x, y) in others {
        if x < x0 && below.is_none_or(|(b, _)| x > b) {
            below = Some((x, y));
        } else if x > x0 && above.is_none_or(|(a, _)| x < a) {
            above = Some((x, y));
        }
    }
    let own = number(&at[i], component).map(|y| (x0, y));
    let (a, b) = (below.or(own)?, above.or(own)?);
    (b.0 > a.0).then(|| (b.1 - a.1) / (b.0 - a.0))
}

/// The table's own standard uncertainty at a point.
fn std_at(model: &ImportedModel, point: &ResponsePoint, component: usize) -> f64 {
    match model.at(&point.pressures_gauge_pa, &[]) {
        Predicted::Value(values) => values.get(component).map_or(0.0, |v| v.half_width_si / Z95),
        _ => 0.0,
    }
}
