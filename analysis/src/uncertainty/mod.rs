//! From what is known of repeats, instruments and inputs to an honest interval: pure numbers.
//!
//! | module | holds |
//! |---|---|
//! | [`errors`] | what moves values, as directions: the covariance and the budget of everything |
//! | [`coverage`] | from standard uncertainties to a 95 % interval, with few repeats |
//! | [`quadratic`], [`pointwise`] | the interval of a root mean square; of the largest and the mean size |
//! | [`intervals`] | every metric of a session with its interval |
//! | [`bootstrap`] | intervals by resampling, where repeats are many |
//! | [`inputs`] | what uncertain inputs do to a prediction |

pub mod bootstrap;
pub mod coverage;
pub mod errors;
pub mod inputs;
pub mod intervals;
pub mod pointwise;
pub mod quadratic;
pub mod random;
