//! How sure a number is: intervals by resampling, and what uncertain inputs do to a prediction.

pub mod bootstrap;
pub mod inputs;
pub mod random;
