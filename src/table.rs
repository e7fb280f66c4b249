//! The table of comparisons on the terminal.

use std::fmt::Write as _;

use comfy_table::{CellAlignment, ContentArrangement, Table, presets};
use terminal_size::{Width, terminal_size_of};

use pneuval_analysis::format::visible;
use pneuval_analysis::metrics::Metric;
use pneuval_analysis::report::text;
use pneuval_analysis::results::{Comparison, Results, Standing};

use crate::paint::{self, Tone};

/// The rows of the results, their reasons where something needs one, and the decision: painted, and nothing in it unseen.
pub fn render(results: &Results) -> String {
    let width = terminal_size_of(std::io::stdout()).map_or(usize::MAX, |(Width(width), _)| usize::from(width));
    let mut out = if width < NARROW { blocks(results) } else { rows(results) };
    out += "\n";
    for comparison in results.comparisons.iter().filter(|c| !matches!(c.standing(), Standing::AsExpected)) {
        // Writing to a String cannot fail.
        let verdict = paint::painted(tone(text::tone(comparison)), comparison.verdict.name());
        let _ = writeln!(out, "{verdict} {}", visible(&format!("{}: {}", comparison.id, comparison.sentence)));
    }
    let partial = |c: &Comparison| c.metrics.iter().any(|m| m.over_predicted_points.is_some());
    if results.comparisons.iter().any(partial) {
        out += "( ) over the points that have a prediction, and meet it; never judged.\n";
    }
    let decision = text::decision(results);
    let headline = paint::painted(tone(decision.tone), &decision.headline);
    out + &format!("{headline}: {}\n", decision.detail)
}

fn rows(results: &Results) -> String {
    let headers = ["type", "quantity", "prediction", "n", "RMSE", "max |e|", "max relative error", "bound", "verdict"];
    let mut table = plain(&headers, &[3, 4, 5, 6]);
    for comparison in &results.comparisons {
        table.add_row(row(comparison));
    }
    fit(&mut table);
    paint::verdicts(&visible(&table.trim_fmt()))
}

/// A terminal narrower than this has no room for nine columns.
const NARROW: usize = 110;

/// The rows as blocks of lines.
fn blocks(results: &Results) -> String {
    let mut out = String::new();
    for comparison in &results.comparisons {
        let cells = row(comparison);
        let [subject, quantity, form, n, rmse, max, relative, bound, verdict] = cells.as_slice() else { continue };
        let painted = paint::painted(tone(text::tone(comparison)), verdict);
        let numbers = format!("    n {n} · RMSE {rmse} · max |e| {max} · {relative}\n    {bound}\n");
        // Writing to a String cannot fail.
        let _ = write!(out, "{painted}  {}", visible(&format!("{subject}, {quantity}, {form}\n{numbers}")));
    }
    out
}

fn tone(name: &str) -> Tone {
    match name {
        "good" => Tone::Good,
        "bad" => Tone::Bad,
        "open" => Tone::Open,
        _ => Tone::Quiet,
    }
}

fn row(comparison: &Comparison) -> Vec<String> {
    let unit = comparison.quantity.unit();
    let (metric, of) = text::relative_metric(comparison);
    let cell = |metric| text::metric_cell(comparison, metric, unit).text;
    let relative = cell(metric);
    let expectation = text::expectation(comparison);
    vec![
        if comparison.dataset == comparison.actuator {
            comparison.actuator.clone()
        } else {
            format!("{} ({})", comparison.actuator, comparison.dataset)
        },
        comparison.quantity.id.clone(),
        comparison.form.clone(),
        // The number of points behind a stated error is not printed.
        if comparison.metrics_printed {
            text::DASH.to_owned()
        } else {
            format!("{}/{}", comparison.n_used, comparison.n_available)
        },
        cell(Metric::Rmse),
        cell(Metric::MaxAbsError),
        if relative == text::DASH { relative } else { format!("{relative} {of}") },
        text::bounds(comparison),
        if expectation.is_empty() {
            comparison.verdict.name().to_owned()
        } else {
            format!("{}, {expectation}", comparison.verdict.name())
        },
    ]
}

/// On a terminal a table keeps to its width; in a pipe or a file every row is one line.
pub fn fit(table: &mut Table) {
    if let Some((Width(width), _)) = terminal_size_of(std::io::stdout()) {
        table.set_width(width).set_content_arrangement(ContentArrangement::Dynamic);
    }
}

/// A table without lines, some columns set to the right.
pub fn plain<S: AsRef<str>>(headers: &[S], right: &[usize]) -> Table {
    let mut table = Table::new();
    table.load_style(presets::NOTHING).set_header(headers.iter().map(AsRef::as_ref));
    for (i, column) in table.column_iter_mut().enumerate() {
        column.set_padding((0, 2));
        if right.contains(&i) {
            column.set_cell_alignment(CellAlignment::Right);
        }
    }
    table
}

/// A time to three decimals, of a unit in which it does not vanish.
pub fn seconds(seconds: f64) -> String {
    match seconds {
        0.0 => "0 s".to_owned(),
        s if s < 1e-4 => format!("{:.3} us", 1e6 * s),
        s if s < 0.1 => format!("{:.3} ms", 1e3 * s),
        s => format!("{s:.3} s"),
    }
}

/// A rate to four digits.
pub fn hertz(rate: f64) -> String {
    format!("{} Hz", number(rate))
}

/// A number to six digits, with an exponent where it is very small or very large.
pub fn number(value: f64) -> String {
    let size = value.abs();
    if value == 0.0 {
        return "0".to_owned();
    }
    if !(1e-4..1e7).contains(&size) {
        return format!("{value:.4e}");
    }
    // Between 1e-4 and 1e7 the logarithm is small.
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
    let decimals = (5.0 - size.log10().floor()).clamp(0.0, 9.0) as usize;
    let text = format!("{value:.decimals$}");
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}

/// A length in bytes.
pub fn bytes(count: u64) -> String {
    match count {
        0..1_000 => format!("{count} B"),
        1_000..1_000_000 => format!("{:.1} kB", count as f64 / 1e3),
        1_000_000..1_000_000_000 => format!("{:.1} MB", count as f64 / 1e6),
        _ => format!("{:.2} GB", count as f64 / 1e9),
    }
}

/// A line that one can read.
pub fn cut(line: &str) -> String {
    const LETTERS_MAX: usize = 120;
    if line.chars().count() <= LETTERS_MAX {
        return line.to_owned();
    }
    line.chars().take(LETTERS_MAX).chain(['…']).collect()
}
