//! The texts that pages and the terminal share, so that they cannot disagree.

pub use super::view::{DASH, DecisionView, NotedText, excluded, expectation, metric_cell, relative_metric};

use crate::gate::limit_text;
use crate::results::{Comparison, Results};

/// The decision over all comparisons, in words.
pub fn decision(results: &Results) -> DecisionView {
    super::view::decision(results, None)
}

/// The bounds of a comparison: `max |e| ≤ 2.5 mm`.
pub fn bounds(comparison: &Comparison) -> String {
    let unit = comparison.quantity.unit();
    let one = |j: &crate::results::JudgementRecord| {
        format!("{} ≤ {}", j.bound.metric.title(), limit_text(j.bound.metric, j.bound.max, unit))
    };
    let all: Vec<String> = comparison.judgements.iter().map(one).collect();
    if all.is_empty() { DASH.to_owned() } else { all.join("; ") }
}
