//! The decision as other programs read it: `JUnit` for CI servers, Markdown for pull requests, annotations for GitHub, a table of every point.
//!
//! ```text
//! Results --> decision, verdicts, numbers as on pages --> junit.xml, summary.md, ::error lines
//!         --> points                                  --> points.csv, points.parquet
//! ```
//!
//! None of these computes anything: texts are those of the pages, numbers those of `results.json`.

mod github;
mod junit;
mod markdown;
mod points;

pub use github::annotations;
pub use junit::junit;
pub use markdown::markdown;
pub use points::{points, points_csv};

use crate::metrics::Metric;
use crate::report::text;
use crate::results::{Comparison, Results, Standing};

/// What a comparison is called.
fn name(c: &Comparison) -> String {
    format!("{} {}: {}", c.dataset, c.quantity.id, c.form)
}

/// Its numbers in a line, as the main table has them.
fn numbers(c: &Comparison) -> String {
    let unit = c.quantity.unit();
    let cell = |metric| {
        let cell = text::metric_cell(c, metric, unit);
        if cell.note.is_empty() { cell.text } else { format!("{} {}", cell.text, cell.note) }
    };
    format!(
        "n {}; RMSE {}; max |e| {}; max relative error {}; bound {}",
        text::counted(c),
        cell(Metric::Rmse),
        cell(Metric::MaxAbsError),
        relative(c),
        text::bounds(c)
    )
}

/// The largest relative error, and of what.
fn relative(c: &Comparison) -> String {
    let (metric, of) = text::relative_metric(c);
    match text::metric_cell(c, metric, c.quantity.unit()).text {
        dash if dash == text::DASH => dash,
        value => format!("{value} {of}"),
    }
}

/// Comparisons with those first that need a reader: what differs, what is open, the rest as it stands.
fn by_urgency(results: &Results) -> Vec<&Comparison> {
    let mut all: Vec<&Comparison> = results.comparisons.iter().collect();
    all.sort_by_key(|c| match c.standing() {
        Standing::Unexpected => 0,
        Standing::Open => 1,
        Standing::AsExpected | Standing::NotCounted => 2,
    });
    all
}
