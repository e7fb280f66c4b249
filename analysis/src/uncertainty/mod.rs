//! From what is known of repeats, instruments and inputs to an honest interval: pure numbers.

pub mod coverage;
pub mod errors;
pub mod intervals;
pub mod pointwise;
pub mod quadratic;
