//! What measurement would decide an open verdict: from the budget of a metric.

use crate::metrics::Metric;
use crate::results::{BudgetRecord, Comparison, PointStatus};
use crate::uncertainty::coverage::Variance;
use crate::uncertainty::errors::Cause;

/// More repeats than these nobody takes.
const REPEATS_MAX: usize = 1000;

/// Nearer to the bound than this share of the half width a value lies on it.
const ON_THE_BOUND: f64 = 1e-3;

/// What would bring the width of a metric's interval on the side of the bound from `width` down to `half`, in words; `None` where there is no
/// budget.
pub fn what_would_decide(comparison: &Comparison, metric: Metric, width: f64, half: f64) -> Option<String> {
    let record = comparison.metric(metric)?;
    let budget = &comparison.budget;
    let (top, share) = record.shares.iter().copied().enumerate().max_by(|a, b| a.1.total_cmp(&b.1))?;
    let first = budget.get(top).filter(|_| share > 0.0)?;
    let makes = |row: &BudgetRecord, share: f64| match row.cause {
        Cause::Repeats => format!("the scatter of {} makes {:.0} % of its variance", row.source, 100.0 * share),
        _ => format!("{} makes {:.0} % of its variance", row.source, 100.0 * share),
    };
    let said = makes(first, share);
    if half <= ON_THE_BOUND * width {
        return Some(format!("{said}; what lies on the bound no measurement can decide"));
    }
    let repeats =
        comparison.points.iter().filter(|p| p.status == PointStatus::Used).map(|p| p.repeats).min().unwrap_or(0);
    // With so many repeats, and the first source known so many times as well.
    let variance = |n: usize, times: f64| {
        let parts = budget.iter().zip(&record.shares).enumerate();
        parts.fold(Variance::default(), |sum, (i, (row, share))| match row.degrees_of_freedom {
            Some(freedom) if n != repeats => {
                let freedom = freedom * (n - 1) / repeats.saturating_sub(1).max(1);
                sum.with(share * repeats as f64 / n as f64, freedom)
            }
            Some(freedom) => sum.with(*share, freedom),
            None => sum.with(if i == top { share / (times * times) } else { *share }, 0),
        })
    };
    let scale = width / variance(repeats, 1.0).half_width();
    let is_enough = |n: usize, times: f64| scale * variance(n, times).half_width() <= half;
    if first.cause == Cause::Repeats {
        let most = comparison.points.iter().map(|p| p.repeats).max().unwrap_or(repeats);
        if let Some(n) = (most + 1..=REPEATS_MAX).find(|n| is_enough(*n, 1.0)) {
            return Some(format!("{said}: about {n} repeats could decide it"));
        }
    } else {
        let times = (2..=200).map(|i| f64::from(i) / 2.0).find(|times| is_enough(repeats, *times));
        if let Some(times) = times {
            return Some(format!("{said}: known at least {times} times as well, it could decide"));
        }
    }
    let others = record.shares.iter().copied().enumerate().filter(|(i, _)| *i != top);
    let second = others.max_by(|a, b| a.1.total_cmp(&b.1)).filter(|(_, share)| *share > 0.0);
    let also = second.and_then(|(i, share)| Some(format!("; {}", makes(budget.get(i)?, share))));
    Some(format!("{said}{}: all of it would have to be known better to decide it", also.unwrap_or_default()))
}
