//! Nonlinear least squares: which parameters make a model pass closest to given values, and how well the values determine them.
//!
//! | step | here |
//! |---|---|
//! | the problem: residuals, and their derivatives | [`Problem`] |
//! | a minimum from a start | [`minimise`]: Levenberg-Marquardt on QR factors |
//! | the lowest of the minima from many starts | [`search`] |
//! | standard errors, correlations, what is not determined | [`Minimum::statistics`] |
//! | intervals that know of curvature and of bounds | [`profile`] |
//!
//! Nothing here forms the normal equations: they would square the condition number, and halve the digits.

mod marquardt;
mod profile;
mod search;
mod statistics;

pub use marquardt::{Minimum, minimise};
pub use profile::{Limit, ProfileInterval, profile};
pub use search::{Search, search};
pub use statistics::Statistics;

use nalgebra::{DMatrix, DVector};

use crate::ModelError;

/// Residuals as a function of parameters.
pub trait Problem {
    /// How many parameters it has.
    fn parameters(&self) -> usize;

    /// The residuals, predicted - measured, perhaps weighted.
    ///
    /// # Errors
    /// If the model has no value at these parameters.
    fn residuals(&self, at: &[f64]) -> Result<DVector<f64>, ModelError>;

    /// Their derivatives, a row a residual, a column a parameter: by central differences unless the problem knows better.
    ///
    /// # Errors
    /// If the model has no value beside these parameters.
    fn jacobian(&self, at: &[f64]) -> Result<DMatrix<f64>, ModelError> {
        let mut columns = Vec::with_capacity(at.len());
        for i in 0..at.len() {
            // The cube root of machine precision balances rounding against curvature in a central difference.
            let step = f64::EPSILON.cbrt() * if at[i] == 0.0 { 1.0 } else { at[i].abs() };
            let (mut up, mut down) = (at.to_vec(), at.to_vec());
            up[i] += step;
            down[i] -= step;
            columns.push((self.residuals(&up)? - self.residuals(&down)?) / (up[i] - down[i]));
        }
        Ok(DMatrix::from_columns(&columns))
    }
}

/// Residuals that a closure computes.
pub struct Residuals<F> {
    parameters: usize,
    residuals: F,
}

impl<F: Fn(&[f64]) -> Result<Vec<f64>, ModelError>> Residuals<F> {
    /// A problem of so many parameters.
    pub fn new(parameters: usize, residuals: F) -> Self {
        Self { parameters, residuals }
    }
}

impl<F: Fn(&[f64]) -> Result<Vec<f64>, ModelError>> Problem for Residuals<F> {
    fn parameters(&self) -> usize {
        self.parameters
    }

    fn residuals(&self, at: &[f64]) -> Result<DVector<f64>, ModelError> {
        (self.residuals)(at).map(DVector::from_vec)
    }
}

/// A calibrated parameter set.
#[derive(Debug, Clone, PartialEq)]
pub struct Fit {
    /// The parameters at the minimum, in the order of the start values.
    pub parameters: Vec<f64>,
    /// Standard uncertainty of each, from the residual scatter; `None` without residual degrees of freedom.
    pub parameters_std: Option<Vec<f64>>,
    /// Root mean square of the residuals.
    pub rmse: f64,
    /// Condition number of the Jacobian with columns of one length: large means that the data cannot tell the parameters apart.
    pub condition_number: f64,
    /// Accepted steps.
    pub iterations: usize,
}

/// The minimum from one start, with its statistics: see [`minimise`].
///
/// # Errors
/// As [`minimise`]; [`ModelError::OutOfDomain`] for a start value of zero; [`ModelError::Undetermined`] if the data do not determine
/// every parameter.
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
    if let Some(&value) = start.iter().find(|v| !v.is_finite() || **v == 0.0) {
        return Err(ModelError::OutOfDomain { symbol: "start value", value, domain: "finite and not zero" });
    }
    let minimum = minimise(&Residuals::new(start.len(), residuals), start)?;
    let statistics = minimum.statistics()?;
    Ok(Fit {
        rmse: minimum.rmse(),
        parameters_std: statistics.std,
        condition_number: statistics.condition_number,
        iterations: minimum.iterations,
        parameters: minimum.parameters,
    })
}
