//! Equations of soft pneumatic actuators, in SI units and plain `f64`.
//!
//! Nothing here knows a file, a clock, a session or a report: numbers in, numbers out.
//!
//! | module | holds |
//! |---|---|
//! | [`materials`] | hyperelastic laws: energy, stress, stability |
//! | [`kinematics`] | the bulged arc |
//! | [`actuators`] | the papers' actuators, each in its forms |
//! | [`solve`] | bracketed roots, and the physical branch of a pressure curve |
//! | [`least_squares`] | calibration of parameters |
//! | [`catalogue`] | every form that can be evaluated: source, range, misprints, check values |
//!
//! Three kinds of form are kept apart. *Printed*: the equation exactly as the paper prints it, never repaired.
//! *Consistent*: the same idea re-derived so that units, sign and the undeformed limit are right. *Reading*: one of
//! several ways to read an equation that the paper leaves open. Residuals are *predicted - measured* project-wide.

pub mod actuators;
pub mod catalogue;
pub mod error;
pub mod kinematics;
pub mod least_squares;
pub mod materials;
pub mod solve;

pub use error::ModelError;
