//! Estimates as a table.

use std::fmt::Write as _;

use pneuval_analysis::fit::estimate::{End, Estimate, Estimates, Given, Identified};

use crate::table::{self, number};

/// The unit of a parameter: its name, its symbol, its SI value.
pub type Units<'a> = &'a [(&'a str, &'static str, f64)];

/// Parameters with their intervals, what is correlated, and where the minimum was looked for.
pub fn estimates(estimates: &Estimates, units: Units) -> String {
    let percent = 100.0 * estimates.confidence;
    let interval = format!("{}% interval", number(percent));
    let mut rows = table::plain(&["parameter", "value", "unit", "std", interval.as_str(), "the data say"], &[1, 3]);
    for estimate in &estimates.parameters {
        let (symbol, factor) =
            units.iter().find(|u| u.0 == estimate.name).map_or(("", 1.0), |(_, symbol, factor)| (*symbol, *factor));
        rows.add_row(vec![
            estimate.name.clone(),
            digits(estimate.value / factor, estimate.std.map(|std| std / factor)),
            symbol.to_owned(),
            estimate.std.map_or("–".to_owned(), |std| table::number(std / factor)),
            ends(estimate, factor),
            estimate.identified.words().to_owned(),
        ]);
    }
    table::fit(&mut rows);
    let mut out = format!("{}\n\n", rows.trim_fmt());
    let std = estimates.residual_std.map_or("unknown".to_owned(), |std| format!("{std:.10e}"));
    // Writing to a String cannot fail.
    let _ = writeln!(
        out,
        "sum of squares {:.10e} over {} values, {} degrees of freedom; residual standard deviation {std}",
        estimates.sum_of_squares, estimates.n, estimates.degrees_of_freedom
    );
    out += &correlated(estimates);
    out += &searched(estimates);
    for warning in &estimates.warnings {
        let _ = writeln!(out, "warning: {warning}");
    }
    out
}

/// A value with the digits that a reader may want to compare: ten significant ones.
fn digits(value: f64, _std: Option<f64>) -> String {
    if value == 0.0 { "0".to_owned() } else { format!("{value:.10e}") }
}

fn ends(estimate: &Estimate, factor: f64) -> String {
    let end = |end: End| match end {
        End::At(value) => number(value / factor),
        End::Edge(value) => format!("{} (edge)", number(value / factor)),
        End::Open => "open".to_owned(),
        End::Unknown => "unknown".to_owned(),
    };
    match (estimate.lower, estimate.upper) {
        (End::Unknown, _) | (_, End::Unknown) => "unknown".to_owned(),
        (lower, upper) => format!("{} to {}", end(lower), end(upper)),
    }
}

/// Pairs that move together, and the direction that the data feel least.
fn correlated(estimates: &Estimates) -> String {
    const STRONG: f64 = 0.95;
    let names: Vec<&str> = estimates.parameters.iter().map(|p| p.name.as_str()).collect();
    let mut pairs = Vec::new();
    for (i, row) in estimates.correlations.iter().enumerate() {
        for (j, correlation) in row.iter().enumerate().take(i) {
            if correlation.abs() >= STRONG {
                pairs.push(format!("{} and {} {correlation:+.4}", names[j], names[i]));
            }
        }
    }
    let mut out = String::new();
    // Writing to a String cannot fail, here and below.
    if !pairs.is_empty() {
        let _ = writeln!(out, "correlated    {}", pairs.join(", "));
    }
    let uncertain =
        estimates.parameters.iter().any(|p| !matches!(p.identified, Identified::Well | Identified::Unknown));
    if let Some(weakest) = estimates.weakest.as_ref().filter(|_| uncertain && names.len() > 1) {
        let parts = names.iter().zip(&weakest.direction).filter(|(_, share)| share.abs() >= 0.1);
        let parts: Vec<String> = parts.map(|(name, share)| format!("{name} by {share:+.2}")).collect();
        let by = weakest.std_share.map_or(String::new(), |std| {
            format!("; one standard deviation along it is {} % of their values", number(100.0 * std))
        });
        let _ = writeln!(out, "least felt    moving {} together{by}", parts.join(", "));
    }
    if let Some(condition) = estimates.condition_number {
        let _ = writeln!(out, "condition     {}", number(condition));
    }
    out
}

fn searched(estimates: &Estimates) -> String {
    let search = &estimates.search;
    let given = match &search.given {
        Given::Lowest => "the given start led there".to_owned(),
        Given::Higher { sum_of_squares } => {
            format!("the given start led to a higher minimum, sum of squares {sum_of_squares:.6e}")
        }
        Given::Nothing { why } => format!("the given start led nowhere: {why}"),
    };
    format!(
        "search        {} starts, {} minima, {} of them this one; {given}\n",
        search.starts, search.settled, search.at_lowest
    )
}
