//! Equations of soft pneumatic actuators, in SI units and plain `f64`.
//!
//! Nothing here knows a file, a clock, a session or a report: numbers in, numbers out.
//!
//! | module | holds |
//! |---|---|
//! | [`materials`] | hyperelastic laws: energy, stress, stability |
//! | [`kinematics`] | the bulged arc, the axis of constant curvature |
//! | [`actuators`] | the papers' actuators, each in its forms; any actuator that bends with constant curvature |
//! | [`solve`] | bracketed roots, and the physical branch of a pressure curve |
//! | [`least_squares`] | calibration of parameters |
//! | [`expression`] | formulas that users and claims write, with exact derivatives |
//! | [`catalogue`] | every form that can be evaluated: source, range, misprints, check values; and what cannot be |
//!
//! Four kinds of form are kept apart. *Printed*: the equation exactly as the paper prints it, never repaired.
//! *Consistent*: the same idea re-derived so that units, sign and the undeformed limit are right. *Reading*: one of
//! several ways to read an equation that the paper leaves open. *Assumed*: a law that nobody printed, chosen, and said so.
//! Residuals are *predicted - measured* project-wide.

pub mod actuators;
pub mod catalogue;
mod domain;
pub mod error;
pub mod expression;
pub mod kinematics;
pub mod least_squares;
pub mod materials;
pub mod solve;

pub use error::ModelError;
