//! What can go wrong when a model is evaluated: always the quantity, the value, and the limit it met.

use thiserror::Error;

/// Why a pressure curve ends.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BranchEnd {
    /// Pressure passes a maximum: beyond it the actuator inflates at falling pressure (snap-through).
    TurnsOver,
    /// The state reached the end of the range the model is defined on.
    EndOfRange,
    /// Pressure falls from the unloaded state on: the curve has no rising branch at all.
    FallsFromStart,
}

impl std::fmt::Display for BranchEnd {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::TurnsOver => "the pressure curve turns over there",
            Self::EndOfRange => "the model's range ends there",
            Self::FallsFromStart => "pressure falls from the unloaded state on, so no positive pressure has a solution",
        })
    }
}

/// Errors of model evaluation.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum ModelError {
    /// An input lies outside the domain of the equation.
    #[error("{symbol} = {value} is outside its domain, {domain}")]
    OutOfDomain {
        /// The input's name.
        symbol: &'static str,
        /// What was given, in SI units.
        value: f64,
        /// What the equation asks for.
        domain: &'static str,
    },
    /// The pressure is beyond the end of the physical branch.
    #[error(
        "no solution at {}: the limit is {}, {end}",
        pressure(*.pressure_gauge_pa),
        pressure(*.limit_gauge_pa)
    )]
    BeyondLimit {
        /// The pressure asked for.
        pressure_gauge_pa: f64,
        /// The largest pressure the branch reaches.
        limit_gauge_pa: f64,
        /// Why the branch ends.
        end: BranchEnd,
    },
    /// The unloaded, undeformed state already needs more pressure than was asked for.
    #[error(
        "no solution at {}: the undeformed state already needs {}",
        pressure(*.pressure_gauge_pa),
        pressure(*.start_gauge_pa)
    )]
    BelowStart {
        /// The pressure asked for.
        pressure_gauge_pa: f64,
        /// The pressure at the undeformed state.
        start_gauge_pa: f64,
    },
    /// The quantity lies outside what the physical branch reaches.
    #[error("no pressure gives {value}: the branch reaches from {reach_min} to {reach_max} (SI units)")]
    OutOfReach {
        /// The value asked for.
        value: f64,
        /// The value at the undeformed state.
        reach_min: f64,
        /// The value at the end of the branch.
        reach_max: f64,
    },
    /// One value of the quantity does not determine the pressure.
    #[error("one value of the quantity does not determine the pressure: {why}")]
    NotInvertible {
        /// What stands in the way.
        why: &'static str,
    },
    /// The quantity has several components where one number was asked for.
    #[error("expected a quantity of one component, found {components} components: ask for all of them")]
    NotScalar {
        /// How many it has.
        components: usize,
    },
    /// The form gives no finite number.
    #[error(
        "the result is {value} (component {component}), expected a finite number: the inputs or pressures are too large or too small"
    )]
    NotFinite {
        /// Which component, counted from 0.
        component: usize,
        /// What came out.
        value: f64,
    },
    /// The equation gives another unit than its quantity has, so its number means nothing.
    #[error("{what} gives {found}, not {expected}: it is not {quantity}")]
    NotThisUnit {
        /// The equation.
        what: &'static str,
        /// The unit of the quantity.
        expected: &'static str,
        /// The unit that comes out.
        found: &'static str,
        /// The quantity, with its article.
        quantity: &'static str,
    },
    /// The wrong number of chamber pressures was given.
    #[error("expected {expected} chamber pressure(s), found {found}")]
    ChamberCount {
        /// What the model asks for.
        expected: usize,
        /// What was given.
        found: usize,
    },
    /// A parameter the form needs was not given.
    #[error("parameter `{name}` is missing ({meaning})")]
    MissingParameter {
        /// Its name in the actuator file.
        name: &'static str,
        /// What it is.
        meaning: &'static str,
    },
    /// The root search was not given a sign change.
    #[error("no sign change between {low} and {high}: f = {f_low} and {f_high}")]
    NoBracket {
        /// Lower end.
        low: f64,
        /// Upper end.
        high: f64,
        /// Function value at the lower end.
        f_low: f64,
        /// Function value at the upper end.
        f_high: f64,
    },
    /// An iteration did not settle.
    #[error("{method} did not converge within {iterations} iterations")]
    NotConverged {
        /// The method.
        method: &'static str,
        /// The limit on iterations.
        iterations: usize,
    },
    /// The data do not determine every fitted parameter.
    #[error("the data do not determine every parameter (condition number {condition_number:e})")]
    Undetermined {
        /// Condition number of the scaled Jacobian.
        condition_number: f64,
    },
    /// A least-squares problem cannot be posed.
    #[error(
        "least squares needs at least as many residuals as parameters: {residuals} residuals, {parameters} parameters"
    )]
    TooFewResiduals {
        /// Number of residuals.
        residuals: usize,
        /// Number of parameters.
        parameters: usize,
    },
}

/// A pressure with at most three decimals, in kPa, or in MPa where that reads better.
fn pressure(pressure_pa: f64) -> String {
    let (value, unit) = if pressure_pa.abs() >= 1e7 { (pressure_pa / 1e6, "MPa") } else { (pressure_pa / 1e3, "kPa") };
    // Adding zero turns a negative zero into a positive one.
    let text = format!("{:.3}", value + 0.0);
    format!("{} {unit}", text.trim_end_matches('0').trim_end_matches('.'))
}
