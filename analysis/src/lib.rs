//! From a measured response and a prediction to a comparison, a verdict and a report.
//!
//! ```text
//! session --> AlignedRun ---> Response --.
//! published table ----------> Response --.
//!                                          >--> Comparison --> Verdict --> results folder --> pages
//! model, table, printed column -> Prediction'
//! ```
//!
//! | module | holds |
//! |---|---|
//! | [`study`] | the responses of a dataset or session, and the comparisons asked of them |
//! | [`align`] | the streams of a run on one time |
//! | [`response`] | a quantity against gauge pressure, as measured |
//! | [`trajectory`] | where a movement meets its prediction; a prediction moved onto a measurement |
//! | [`prediction`] | what a model, an imported table or a printed column says at those points |
//! | [`fit`] | calibration: of a form before a comparison, of materials, actuators, any formula |
//! | [`audit`] | statements of papers and manuscripts, recomputed from their own numbers |
//! | [`pairing`] | what becomes of every point |
//! | [`metrics`] | how far apart they are, with the interval that is known |
//! | [`uncertainty`] | intervals by resampling; what uncertain inputs do to a prediction |
//! | [`bounds`] | acceptance limits, each with its reason |
//! | [`verdict`] | `judge()`, the only place where a metric meets a bound |
//! | [`compare`] | response and prediction to comparison |
//! | [`remark`] | sentences with computed numbers in them |
//! | [`records`] | what the results say of actuators, sessions and findings |
//! | [`gate`] | stored metrics and bounds to verdicts, and their sentences |
//! | [`results`] | every number, computed once; the schema of `results.json` |
//! | [`ci`] | the decision as other programs read it |
//! | [`baseline`] | what moved since results that were accepted |
//! | [`folder`] | the results folder on disk |
//! | [`export`] | measured and predicted values as files for other programs |
//! | [`report`] | figures and pages, drawn from stored numbers only |
//!
//! Residual = predicted - measured: positive means that the model is too high.

pub mod align;
pub mod audit;
pub mod baseline;
pub mod bounds;
pub mod ci;
pub mod compare;
mod decide;
pub mod error;
pub mod export;
pub mod fit;
pub mod folder;
pub mod format;
pub mod gate;
pub mod logs;
pub mod metrics;
pub mod pairing;
pub mod photographs;
mod place;
pub mod prediction;
pub mod records;
pub mod remark;
pub mod report;
pub mod response;
pub mod results;
pub mod series;
pub mod study;
pub mod trajectory;
pub mod uncertainty;
pub mod verdict;

pub use error::AnalysisError;
