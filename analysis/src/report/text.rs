//! The texts that pages and the terminal share, so that they cannot disagree.

pub use super::view::{
    DASH, DecisionView, NotedText, bounds, counted, excluded, expectation, metric_cell, relative_metric, tone,
};

use crate::results::Results;

/// The decision over all comparisons, in words.
pub fn decision(results: &Results) -> DecisionView {
    super::view::decision(results, None)
}
