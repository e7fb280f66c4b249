//! What makes the uncertainty of a comparison, and what the comparison says of the model beside it.

use serde::Serialize;

use super::measurement_title;
use crate::format;
use crate::gate::area_text;
use crate::metrics::Metric;
use crate::results::{BudgetRecord, CensusRecord, Comparison, IntervalRecord};
use crate::uncertainty::errors::Cause;
use pneuval_ingest::units::Unit;

/// The uncertainty budget of a comparison.
#[derive(Serialize)]
pub struct BudgetTable {
    pub title: String,
    pub rows: Vec<BudgetRow>,
    /// E, `u_val` and where they meet, in a sentence.
    pub validation: String,
    /// What became of the model's inputs.
    pub inputs: String,
    /// What noise adds to the RMSE.
    pub correction: String,
}

#[derive(Serialize)]
pub struct BudgetRow {
    pub source: String,
    pub cause: &'static str,
    pub evaluation: String,
    pub std: String,
    pub largest: String,
    pub share: String,
}

pub(super) fn table(c: &Comparison) -> Option<BudgetTable> {
    // Of no point nothing is known.
    if c.budget.is_empty() || c.n_used == 0 {
        return None;
    }
    let unit = c.quantity.unit();
    let text = |si: f64| format::with_unit(&format::significant(unit.from_si(si), 3), unit);
    let rmse = c.metric(Metric::Rmse);
    let share = |i: usize| rmse.and_then(|r| r.shares.get(i)).copied();
    let row = |(i, b): (usize, &BudgetRecord)| BudgetRow {
        source: b.source.replace('_', " "),
        cause: b.cause.title(),
        evaluation: match b.degrees_of_freedom {
            Some(1) => format!("{}, 1 degree of freedom", b.evaluation),
            Some(freedom) => format!("{}, {freedom} degrees of freedom", b.evaluation),
            None => b.evaluation.clone(),
        },
        std: text(b.std_rms_si),
        largest: text(b.std_max_si),
        share: share(i).map_or(String::new(), |share| format!("{} %", format::fixed(100.0 * share, 1))),
    };
    let validation = c.validation.as_ref().map_or(String::new(), |v| {
        format!(
            "E {}, u_val {} (u_D {}, u_input {}, u_num {}), root mean square over the values used. {} of {} values lie within the 95 % interval \
             of u_val: {}",
            text(v.e_si),
            text(v.u_val_si),
            text(v.u_d_si),
            text(v.u_input_si),
            text(v.u_num_si),
            v.within,
            v.values,
            match v.within {
                n if n == v.values => "these data show no error of the model; it may be off by as much.",
                0 => "the model is off beyond what data and inputs leave open.",
                _ => "at the others the model is off beyond what data and inputs leave open.",
            }
        )
    });
    let inputs = c.inputs.as_ref().map_or(String::new(), |inputs| {
        let problem = inputs.problem.as_ref().map_or(String::new(), |problem| format!("; {problem}"));
        let without = match inputs.without_solution {
            0 => String::new(),
            n => format!(", {n} of them without a solution of the model"),
        };
        format!(
            "Inputs {} by Monte Carlo, Latin hypercube of {} samples{without}{problem}.",
            inputs.names.join(", ").replace('_', " "),
            inputs.samples
        )
    });
    // Without repeats nothing is taken off.
    let has_repeats = c.budget.iter().any(|b| b.cause == Cause::Repeats);
    let rmse = rmse.filter(|_| has_repeats);
    let correction = rmse.and_then(|r| Some((r.uncorrected?, r.value?))).map_or(String::new(), |(plain, corrected)| {
        format!(
            "RMSE of the mean values {}; without what the scatter of repeats adds {}.",
            format::quantity(plain, unit, format::error_decimals(unit)),
            format::quantity(corrected, unit, format::error_decimals(unit))
        )
    });
    Some(BudgetTable {
        title: format!("{}, {}", measurement_title(c), c.title),
        rows: c.budget.iter().enumerate().map(row).collect(),
        validation,
        inputs,
        correction,
    })
}

/// How a response depends on the way of the pressure, in a sentence.
pub(super) fn way(census: &CensusRecord, unit: Unit) -> String {
    let way = &census.way;
    let quantity = |v: f64| format::with_unit(&format::significant(unit.from_si(v), 3), unit);
    let with_ends = |record: &IntervalRecord, text: &dyn Fn(f64) -> String| match (record.lower, record.upper) {
        (Some(lower), Some(upper)) => format!("{} (95 %: {} to {})", text(record.value), text(lower), text(upper)),
        _ => format!("{}, without an interval", text(record.value)),
    };
    let mut parts = vec![match census.repeats.len() {
        0 => format!("{}: every sample on its own, none is a repeat", census.quantity),
        n => format!("{}: {n} repeats", census.quantity),
    }];
    if census.points_apart > 0 {
        parts.push(format!("{} points of a cycle apart, shown and not compared", census.points_apart));
    }
    match (&way.loop_area_si, &way.no_loop) {
        (Some(area), _) => parts.push(format!("loop area {}", with_ends(area, &|v| area_text(v, unit)))),
        (None, Some(why)) => parts.push(format!("no loop: {why}")),
        (None, None) => {}
    }
    if let Some(left) = &way.residual_at_zero_si {
        parts.push(format!("left at zero pressure {}", with_ends(left, &quantity)));
    }
    if let Some(drift) = &way.drift_per_cycle_si {
        parts.push(format!("drift {} per cycle, over {} cycles", with_ends(drift, &quantity), way.drift_cycles));
    }
    parts.join("; ")
}
