//! Annotations of GitHub Actions: lines that its runner turns into marks on a change.

use super::{by_urgency, name, numbers};
use crate::baseline::Move;
use crate::format::visible;
use crate::report::text;
use crate::results::{Results, Severity, Standing};

/// One line for each comparison that differs (error) or is open (warning), for lost data (error) and excluded ones (warning), what
/// moved since a baseline, and the decision.
pub fn annotations(results: &Results, moves: &[Move]) -> String {
    let mut lines = vec![];
    // Whoever only reports wants no red marks.
    let bad = if results.report_only { "warning" } else { "error" };
    for c in by_urgency(results) {
        let level = match c.standing() {
            Standing::Unexpected => bad,
            Standing::Open => "warning",
            Standing::AsExpected | Standing::NotCounted => continue,
        };
        let title = format!("{}: {}", c.verdict.name(), name(c));
        lines.push(line(level, &title, &format!("{}\n{}", c.sentence, numbers(c))));
    }
    for m in moves {
        let level = if m.counts { bad } else { "notice" };
        lines.push(line(level, &format!("{} since the baseline: {}", m.moved.name(), m.id), &m.sentence));
    }
    for loss in results.losses() {
        lines.push(line(bad, "data lost", &loss));
    }
    for f in results.findings.iter().filter(|f| f.severity == Severity::Excluded) {
        let place: Vec<&str> = f.dataset.iter().chain(&f.file).map(String::as_str).collect();
        lines.push(line("warning", &format!("excluded: {}", place.join(", ")), &f.text));
    }
    let decision = text::decision(results);
    lines.push(line("notice", "pneuval", &format!("{}: {}", decision.headline, decision.detail)));
    lines.concat()
}

/// A workflow command; what would end its text or its title is escaped as the runner reads it.
fn line(level: &str, title: &str, message: &str) -> String {
    let text = |text: &str| visible(text).replace('%', "%25").replace('\r', "%0D").replace('\n', "%0A");
    let title = text(title).replace(':', "%3A").replace(',', "%2C");
    format!("::{level} title={title}::{}\n", text(message))
}

#[cfg(test)]
mod tests {
    use super::line;

    #[test]
    fn a_text_cannot_end_its_line_or_its_title() {
        let told = line("error", "a,b::c", "100 %\n::set-output name=x::y\u{7}");
        assert_eq!(told, "::error title=a%2Cb%3A%3Ac::100 %25%0A::set-output name=x::y\\u{7}\n");
    }
}
