//! Calibration: parameters of a form fitted to a column, before the form is compared with another.

use pneuval_models::ModelError;
use pneuval_models::catalogue::{Entry, Inputs};
use pneuval_models::least_squares::{Fit, levenberg_marquardt};

/// How often the start values may be doubled until the model reaches every pressure.
const DOUBLINGS_MAX: u32 = 30;

/// Fits parameters of a form so that it passes closest (least squares in the quantity) to values at pressures.
///
/// Starts from the given inputs; if the model has no solution at some pressure there (a material too soft to stay in range),
/// the fitted parameters are doubled together until it has.
///
/// # Errors
/// Whatever the model or [`levenberg_marquardt`] says.
pub fn calibrate(
    entry: &Entry,
    inputs: &Inputs,
    parameters: &[String],
    targets: &[(Vec<f64>, f64)],
) -> Result<(Inputs, Fit), ModelError> {
    let with = |values: &[f64]| {
        let mut changed = inputs.clone();
        for (name, value) in parameters.iter().zip(values) {
            changed.set(name.as_str(), *value);
        }
        changed
    };
    // Scaled to the size of the quantity, so that the optimiser sees numbers near one.
    let scale = targets.iter().map(|(_, v)| v.abs()).fold(0.0, f64::max).max(f64::MIN_POSITIVE);
    let residuals = |values: &[f64]| {
        let model = entry.build(&with(values))?;
        targets
            .iter()
            .map(|(pressures, target)| Ok((model.predict(pressures)? - target) / scale))
            .collect::<Result<Vec<f64>, ModelError>>()
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
