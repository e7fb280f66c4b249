//! The decision in Markdown, for a pull request or the summary of a CI job: the failed first.

use std::fmt::Write as _;

use super::{by_urgency, numbers, relative};
use crate::baseline::Move;
use crate::format::visible;
use crate::metrics::Metric;
use crate::report::text;
use crate::results::{Comparison, Results, Severity, Standing};

/// Findings that are listed; more are counted.
const FINDINGS: usize = 20;

/// The text, with what moved since a baseline.
pub fn markdown(results: &Results, moves: &[Move]) -> String {
    let decision = text::decision(results);
    let mut out = format!("## pneuval: {}\n\n{}\n\n", plain(&decision.headline), plain(&decision.detail));
    if results.report_only {
        out += "Only reported: the exit code is 0 whatever the verdicts.\n\n";
    }
    out += "| verdict | type | quantity | prediction | n | RMSE | max &#124;e&#124; | max relative error | bound |\n";
    out += "|---|---|---|---|---:|---:|---:|---:|---|\n";
    for c in by_urgency(results) {
        let cells = cells(c).map(|cell| plain(&cell));
        // Writing to a String cannot fail.
        let _ = writeln!(out, "| {} |", cells.join(" | "));
    }
    let told: Vec<&Comparison> =
        by_urgency(results).into_iter().filter(|c| c.standing() != Standing::AsExpected).collect();
    if !told.is_empty() {
        out += "\n### Why\n\n";
    }
    for c in told {
        let _ = writeln!(
            out,
            "- **{} {}**: {} ({})",
            c.verdict.name(),
            plain(&c.id),
            plain(&c.sentence),
            plain(&numbers(c))
        );
    }
    if !moves.is_empty() {
        out += "\n### Since the baseline\n\n";
    }
    for m in moves {
        let _ = writeln!(out, "- **{}** {}: {}", m.moved.name(), plain(&m.id), plain(&m.sentence));
    }
    let mut findings: Vec<_> = results.findings.iter().filter(|f| f.severity != Severity::Note).collect();
    findings.sort_by_key(|f| f.severity);
    if !findings.is_empty() {
        out += "\n### Data\n\n";
    }
    for f in findings.iter().take(FINDINGS) {
        let place: Vec<&str> = f.dataset.iter().chain(&f.file).map(String::as_str).collect();
        let _ = writeln!(out, "- {}: {}: {}", f.severity.name(), plain(&place.join(", ")), plain(&f.text));
    }
    if findings.len() > FINDINGS {
        let _ = writeln!(out, "- and {} more in results.json", findings.len() - FINDINGS);
    }
    out
}

fn cells(c: &Comparison) -> [String; 9] {
    let unit = c.quantity.unit();
    let cell = |metric| text::metric_cell(c, metric, unit).text;
    let expectation = text::expectation(c);
    let verdict = if expectation.is_empty() {
        c.verdict.name().to_owned()
    } else {
        format!("{}, {expectation}", c.verdict.name())
    };
    let of_type = if c.dataset == c.actuator { c.actuator.clone() } else { format!("{} ({})", c.actuator, c.dataset) };
    [
        verdict,
        of_type,
        c.quantity.id.clone(),
        c.form.clone(),
        text::counted(c),
        cell(Metric::Rmse),
        cell(Metric::MaxAbsError),
        relative(c),
        text::bounds(c),
    ]
}

/// Text that Markdown takes for nothing else: what could be markup is an entity, a line break a space.
fn plain(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in visible(text).chars() {
        match c {
            '\n' => out.push(' '),
            '\\' | '`' | '*' | '_' | '{' | '}' | '[' | ']' | '<' | '>' | '#' | '|' | '&' | '@' | '~' | '!' | '$' => {
                // Writing to a String cannot fail.
                let _ = write!(out, "&#{};", u32::from(c));
            }
            _ => out.push(c),
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::plain;

    #[test]
    fn nothing_in_a_text_is_markup() {
        assert_eq!(plain("a|b\n[x](y) <b> @me"), "a&#124;b &#91;x&#93;(y) &#60;b&#62; &#64;me");
        assert_eq!(plain("\u{1b}[31m\u{202e}"), "&#92;u&#123;1b&#125;&#91;31m&#92;u&#123;202e&#125;");
    }
}
