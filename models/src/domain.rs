//! Domains of inputs: a value passes by a positive condition, so that NaN never does.

use crate::ModelError;

/// The value, if it is finite and above zero.
pub fn positive(symbol: &'static str, value: f64, domain: &'static str) -> Result<f64, ModelError> {
    if value.is_finite() && value > 0.0 { Ok(value) } else { Err(ModelError::OutOfDomain { symbol, value, domain }) }
}

/// The value, if it is finite.
pub fn finite(symbol: &'static str, value: f64) -> Result<f64, ModelError> {
    if value.is_finite() { Ok(value) } else { Err(ModelError::OutOfDomain { symbol, value, domain: "finite" }) }
}

/// The value, if it lies strictly between two ends.
pub fn between(symbol: &'static str, value: f64, low: f64, high: f64, domain: &'static str) -> Result<f64, ModelError> {
    if value > low && value < high { Ok(value) } else { Err(ModelError::OutOfDomain { symbol, value, domain }) }
}
