//! From a measured response and a prediction to a comparison, a verdict and a report.
//!
//! ```text
//! published table --> Response --.
//!                                 >--> Comparison --> Verdict --> results folder --> pages
//! model, printed column --> Prediction --'
//! ```
//!
//! | module | holds |
//! |---|---|
//! | [`response`] | a quantity against gauge pressure, as measured |
//! | [`prediction`] | what a model or a printed column says at those pressures |
//! | [`fit`] | calibration of parameters before a comparison |
//! | [`metrics`] | how far apart they are, with the interval that is known |
//! | [`bounds`] | acceptance limits, each with its reason |
//! | [`verdict`] | `judge()`, the only place where a metric meets a bound |
//! | [`compare`] | response and prediction to comparison |
//! | [`gate`] | stored metrics and bounds to verdicts, and their sentences |
//! | [`results`] | every number, computed once; the schema of `results.json` |
//! | [`folder`] | the results folder on disk |
//! | [`report`] | figures and pages, drawn from stored numbers only |
//!
//! Residual = predicted - measured: positive means that the model is too high.

pub mod bounds;
pub mod compare;
pub mod error;
pub mod fit;
pub mod folder;
pub mod format;
pub mod gate;
pub mod metrics;
pub mod prediction;
pub mod report;
pub mod response;
pub mod results;
pub mod series;
pub mod verdict;

pub use error::AnalysisError;
