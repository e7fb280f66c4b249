//! What measurement would decide an open verdict: from the budget of a metric.

use crate::metrics::{Interval, Metric};
use crate::results::{BudgetRecord, Comparison};
use crate::uncertainty::coverage::coverage_factor;
use crate::uncertainty::errors::Cause;

/// More repeats than these nobody takes.
const REPEATS_MAX: usize = 1000;

/// Nearer to the bound than this share of the half width a value lies on it.
const ON_THE_BOUND: f64 = 1e-3;

/// What would bring the half width of a metric's interval down to `half`, in words; `None` where there is no budget.
pub fn what_would_decide(comparison: &Comparison, metric: Metric, interval: Interval, half: f64) -> Option<String> {
    let record = comparison.metric(metric)?;
    let budget = &comparison.budget;
    let (top, share) = record.shares.iter().copied().enumerate().max_by(|a, b| a.1.total_cmp(&b.1))?;
    let first = budget.get(top).filter(|_| share > 0.0)?;
    let makes = |row: &BudgetRecord, share: f64| match row.cause {
        Cause::Repeats => format!("the scatter of {} makes {:.0} % of its variance", row.source, 100.0 * share),
        _ => format!("{} makes {:.0} % of its variance", row.source, 100.0 * share),
    };
    let said = makes(first, share);
    if half <= ON_THE_BOUND * interval.half_width() {
        return Some(format!("{said}; what lies on the bound no measurement can decide"));
    }
    let repeats = budget.iter().find_map(|row| row.degrees_of_freedom).map_or(0, |freedom| freedom + 1);
    let type_a: f64 =
        budget.iter().zip(&record.shares).filter(|(row, _)| row.cause == Cause::Repeats).map(|(_, s)| s).sum();
    let factor = coverage_factor(type_a, 1.0 - type_a, repeats);
    let total = (interval.half_width() / factor).powi(2);
    let (a, b) = (type_a * total, (1.0 - type_a) * total);
    let is_enough = |a: f64, b: f64, n: usize| coverage_factor(a, b, n) * (a + b).sqrt() <= half;
    if first.cause == Cause::Repeats {
        let with = |n: usize| is_enough(a * repeats as f64 / n as f64, b, n);
        if let Some(n) = (repeats + 1..=REPEATS_MAX).find(|n| with(*n)) {
            return Some(format!("{said}: about {n} repeats could decide it"));
        }
    } else {
        let part = share * total;
        // Known so many times as well.
        let times = (2..=200).map(|i| f64::from(i) / 2.0).find(|t| is_enough(a, b - part + part / (t * t), repeats));
        if let Some(times) = times {
            return Some(format!("{said}: known {times} times as well, it could decide"));
        }
    }
    let others = record.shares.iter().copied().enumerate().filter(|(i, _)| *i != top);
    let second = others.max_by(|a, b| a.1.total_cmp(&b.1)).filter(|(_, share)| *share > 0.0);
    let also = second.and_then(|(i, share)| Some(format!("; {}", makes(budget.get(i)?, share))));
    Some(format!("{said}{}: all of it would have to be known better to decide it", also.unwrap_or_default()))
}
