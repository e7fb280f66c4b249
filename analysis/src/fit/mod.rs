//! Calibration: parameters of a form fitted to values, before the form is compared with others.

pub mod actuator;
pub mod certified;
pub mod estimate;
pub mod expression;
pub mod material;

use pneuval_ingest::manifest::Condition;
use pneuval_models::ModelError;
use pneuval_models::catalogue::{Entry, Inputs};
use pneuval_models::least_squares::{Fit, levenberg_marquardt};

use crate::prediction::Form;

/// How often the start values may be doubled until the model reaches every pressure.
const DOUBLINGS_MAX: u32 = 30;

/// A value to fit.
#[derive(Debug, Clone, PartialEq)]
pub struct Target {
    /// Gauge pressure per chamber, Pa.
    pub pressures_gauge_pa: Vec<f64>,
    /// Value of each condition, SI units.
    pub conditions_si: Vec<f64>,
    /// Value of each component, SI units.
    pub values_si: Vec<f64>,
}

/// Fits parameters of a form so that it passes closest (least squares in the quantity, every component alike) to values.
///
/// Starts from the given inputs; if the model has no solution at some pressure there (a material too soft to stay in range),
/// the fitted parameters are doubled together until it has.
///
/// # Errors
/// Whatever the model or [`levenberg_marquardt`] says.
pub fn calibrate(
    entry: &Entry,
    inputs: &Inputs,
    conditions: &[Condition],
    parameters: &[String],
    targets: &[&Target],
) -> Result<(Inputs, Fit), ModelError> {
    let with = |values: &[f64]| {
        let mut changed = inputs.clone();
        for (name, value) in parameters.iter().zip(values) {
            changed.set(name.as_str(), *value);
        }
        changed
    };
    // Scaled to the size of the quantity, so that the optimiser sees numbers near one.
    let values = targets.iter().flat_map(|t| &t.values_si);
    let scale = values.map(|v| v.abs()).fold(0.0, f64::max).max(f64::MIN_POSITIVE);
    let residuals = |values: &[f64]| {
        let form = Form::new(entry, with(values), conditions);
        let mut residuals = Vec::new();
        for target in targets {
            let predicted = form.value(&target.pressures_gauge_pa, &target.conditions_si)?;
            residuals.extend(predicted.iter().zip(&target.values_si).map(|(p, t)| (p - t) / scale));
        }
        Ok(residuals)
    };
    let mut start: Vec<f64> = parameters.iter().map(|name| inputs.get(name).unwrap_or(f64::NAN)).collect();
    for _ in 0..DOUBLINGS_MAX {
        if residuals(&start).is_ok() {
            break;
        }
        for value in &mut start {
            *value *= 2.0;
        }
    }
    let mut fit = levenberg_marquardt(residuals, &start)?;
    fit.rmse *= scale;
    Ok((with(&fit.parameters), fit))
}
