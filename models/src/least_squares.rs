//! Nonlinear least squares: which parameters make a model pass closest to given values.

use nalgebra::{DMatrix, DVector};

use crate::ModelError;

/// A calibrated parameter set.
#[derive(Debug, Clone, PartialEq)]
pub struct Fit {
    /// The parameters at the minimum, in the order of the start values.
    pub parameters: Vec<f64>,
    /// Standard uncertainty of each, from the residual scatter; `None` without residual degrees of freedom.
    pub parameters_std: Option<Vec<f64>>,
    /// Root mean square of the residuals.
    pub rmse: f64,
    /// Condition number of the scaled Jacobian: large means that the data cannot tell the parameters apart.
    pub condition_number: f64,
    /// Accepted steps.
    pub iterations: usize,
}

/// Minimises the sum of squared residuals by Levenberg-Marquardt.
///
/// Parameters are scaled by their start values, which must not be zero; the Jacobian is by central differences; a trial point
/// at which the model has no value is refused like one that makes things worse (Marquardt's damping grows). Stops when a
/// step changes the sum of squares by less than 1e-14 of itself.
///
/// # Errors
/// [`ModelError::TooFewResiduals`] with fewer residuals than parameters, [`ModelError::OutOfDomain`] for a start value of zero,
/// [`ModelError::NotConverged`] after 200 steps or at the edge of the model's domain, [`ModelError::Undetermined`] if the data do
/// not determine every parameter; and whatever the model says at the start values.
///
/// # Check value
/// A straight line through three points, 1 + 2x: exact.
/// ```
/// use pneuval_models::least_squares::levenberg_marquardt;
/// let data = [(0.0, 1.0), (1.0, 3.0), (2.0, 5.0)];
/// let fit = levenberg_marquardt(|p| Ok(data.iter().map(|(x, y)| p[0] + p[1] * x - y).collect()), &[0.5, 0.5])?;
/// assert!((fit.parameters[0] - 1.0).abs() < 1e-9 && (fit.parameters[1] - 2.0).abs() < 1e-9);
/// # Ok::<(), pneuval_models::ModelError>(())
/// ```
pub fn levenberg_marquardt(
    residuals: impl Fn(&[f64]) -> Result<Vec<f64>, ModelError>,
    start: &[f64],
) -> Result<Fit, ModelError> {
    const ITERATIONS: usize = 200;
    const SETTLED: f64 = 1e-14;
    if let Some(&value) = start.iter().find(|v| !v.is_finite() || **v == 0.0) {
        return Err(ModelError::OutOfDomain { symbol: "start value", value, domain: "finite and not zero" });
    }
    let at = |scaled: &DVector<f64>| -> Result<DVector<f64>, ModelError> {
        let parameters: Vec<f64> = scaled.iter().zip(start).map(|(s, v)| s * v).collect();
        residuals(&parameters).map(DVector::from_vec)
    };
    let mut x = DVector::from_element(start.len(), 1.0);
    let mut r = at(&x)?;
    if r.len() < start.len() {
        return Err(ModelError::TooFewResiduals { residuals: r.len(), parameters: start.len() });
    }
    let mut cost = r.norm_squared();
    let mut damping = 1e-3;
    // Whether a trial of the present damping ladder could be computed at all.
    let mut computed = false;
    let mut settled = false;
    let mut iterations = 0;
    let mut jacobian = jacobian_of(&at, &x, r.len())?;
    for _ in 0..ITERATIONS {
        if cost == 0.0 {
            settled = true;
            break;
        }
        let normal = jacobian.tr_mul(&jacobian);
        let gradient = jacobian.tr_mul(&r);
        let mut damped = normal.clone();
        for i in 0..start.len() {
            damped[(i, i)] += damping * normal[(i, i)].max(f64::MIN_POSITIVE);
        }
        let step = damped.cholesky().map(|c| c.solve(&(-&gradient)));
        let trial = step.as_ref().map(|s| &x + s).and_then(|t| at(&t).ok().map(|r| (t, r)));
        match trial {
            Some((trial_x, trial_r)) if trial_r.norm_squared() <= cost => {
                let gain = cost - trial_r.norm_squared();
                (x, r) = (trial_x, trial_r);
                iterations += 1;
                damping = (damping / 10.0).max(1e-15);
                computed = false;
                jacobian = jacobian_of(&at, &x, r.len())?;
                settled = gain <= SETTLED * cost;
                cost = r.norm_squared();
            }
            trial => {
                computed |= trial.is_some();
                damping *= 10.0;
                // No step, however small, improves: the minimum to the last digits. If none could be computed, it is an edge.
                settled = damping > 1e12 && computed;
                if damping > 1e12 && !computed {
                    break;
                }
            }
        }
        if settled {
            break;
        }
    }
    if !settled {
        return Err(ModelError::NotConverged { method: "Levenberg-Marquardt", iterations: ITERATIONS });
    }
    if jacobian.iter().any(|v| !v.is_finite()) {
        return Err(ModelError::NotConverged { method: "Levenberg-Marquardt", iterations });
    }
    let singular = jacobian.clone().svd(false, false).singular_values;
    let condition_number = singular.max() / singular.min();
    // Beyond the digits of a double the data do not determine every parameter: a parameter without influence, or two that do
    // the same.
    let determined = condition_number < 1.0 / f64::EPSILON;
    if !determined {
        return Err(ModelError::Undetermined { condition_number });
    }
    let freedom = r.len() - start.len();
    let parameters_std = (freedom > 0).then(|| jacobian.tr_mul(&jacobian).try_inverse()).flatten().map(|inverse| {
        let variance = cost / freedom as f64;
        (0..start.len()).map(|i| (variance * inverse[(i, i)]).sqrt() * start[i].abs()).collect()
    });
    Ok(Fit {
        parameters: x.iter().zip(start).map(|(s, v)| s * v).collect(),
        parameters_std,
        rmse: (cost / r.len() as f64).sqrt(),
        condition_number,
        iterations,
    })
}

/// Jacobian of the residuals by the scaled parameters, central differences.
fn jacobian_of(
    at: &impl Fn(&DVector<f64>) -> Result<DVector<f64>, ModelError>,
    x: &DVector<f64>,
    rows: usize,
) -> Result<DMatrix<f64>, ModelError> {
    let mut jacobian = DMatrix::zeros(rows, x.len());
    for i in 0..x.len() {
        // The cube root of machine precision balances rounding against curvature in a central difference.
        let step = f64::EPSILON.cbrt() * x[i].abs().max(1e-3);
        let (mut up, mut down) = (x.clone(), x.clone());
        up[i] += step;
        down[i] -= step;
        jacobian.set_column(i, &((at(&up)? - at(&down)?) / (2.0 * step)));
    }
    Ok(jacobian)
}
