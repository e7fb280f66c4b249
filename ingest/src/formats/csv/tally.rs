//! Collecting what is odd while lines are read, and telling it afterwards.

use std::collections::BTreeMap;

use super::text::to_text;
use crate::error::shown;
use crate::finding::{Finding, FindingKind, LineMap, Severity, Span, extend};

/// Places quoted in a sentence.
const QUOTED_MAX: usize = 3;

/// Bytes kept of a quoted place: more than is ever shown.
const QUOTED_BYTES: usize = 400;

#[derive(Debug, Default)]
struct Group {
    count: usize,
    spans: Vec<Span>,
    /// Line and what stands there.
    quoted: Vec<(usize, String)>,
}

impl Group {
    fn add(&mut self, row: usize, line: usize, quote: impl FnOnce() -> String) {
        self.count += 1;
        extend(&mut self.spans, Span { first_sample: row, last_sample: row, first_line: line, last_line: line });
        if self.quoted.len() < QUOTED_MAX {
            self.quoted.push((line, quote()));
        }
    }

    /// `(line 5: `ERR`; line 9: `OVL`; and 4 more)`.
    fn places(&self) -> String {
        let mut places: Vec<String> = self
            .quoted
            .iter()
            .map(
                |(line, quote)| if quote.is_empty() { format!("line {line}") } else { format!("line {line}: {quote}") },
            )
            .collect();
        if self.count > self.quoted.len() {
            places.push(format!("and {} more", self.count - self.quoted.len()));
        }
        format!("({})", places.join("; "))
    }
}

/// What was odd, by kind and column.
#[derive(Debug, Default)]
pub(super) struct Tally {
    cells: BTreeMap<(usize, FindingKind), Group>,
    lines: BTreeMap<FindingKind, Group>,
    /// Findings that have their sentence already.
    told: Vec<Finding>,
}

impl Tally {
    /// A cell of a column of numbers that holds none.
    pub fn cell(&mut self, kind: FindingKind, column: usize, row: usize, line: usize, cell: &[u8]) {
        let quote = || if cell.is_empty() { String::new() } else { quoted(cell) };
        self.cells.entry((column, kind)).or_default().add(row, line, quote);
    }

    /// A line, and what is said of it; `row` is the sample on it, or the next one.
    pub fn line(&mut self, kind: FindingKind, row: usize, line: usize, what: impl FnOnce() -> String) {
        self.lines.entry(kind).or_default().add(row, line, what);
    }

    /// A finding with its sentence.
    pub fn tell(&mut self, file: &str, kind: FindingKind, severity: Severity, lines: &[(usize, usize)], text: String) {
        let mut spans = Vec::new();
        for (row, line) in lines {
            extend(&mut spans, Span { first_sample: *row, last_sample: *row, first_line: *line, last_line: *line });
        }
        let count = lines.len();
        self.told.push(Finding { kind, severity, file: file.to_owned(), channel: None, spans, count, text });
    }

    /// Lines with bytes that are not the encoding; known before any row is read.
    pub fn encoding(&mut self, file: &str, count: usize, first: &[usize], lines: &LineMap, text: String) {
        let places: Vec<(usize, usize)> = first.iter().map(|line| (lines.rows_before(*line), *line)).collect();
        self.tell(file, FindingKind::Encoding, Severity::Note, &places, text);
        if let Some(finding) = self.told.last_mut() {
            finding.count = count;
        }
    }

    /// All findings: those of the file, of lines, of cells by column.
    pub fn findings(self, file: &str, names: &[String], usual: usize) -> Vec<Finding> {
        let mut findings = self.told;
        for (kind, group) in self.lines {
            let (severity, text) = line_sentence(kind, &group, usual);
            let Group { count, spans, .. } = group;
            findings.push(Finding { kind, severity, file: file.to_owned(), channel: None, spans, count, text });
        }
        for ((column, kind), group) in self.cells {
            let name = names.get(column).cloned().unwrap_or_default();
            let (severity, text) = cell_sentence(kind, &group, &name);
            let Group { count, spans, .. } = group;
            findings.push(Finding { kind, severity, file: file.to_owned(), channel: Some(name), spans, count, text });
        }
        findings
    }
}

/// What stands in a file, fit to be shown.
pub(super) fn quoted(bytes: &[u8]) -> String {
    shown(&to_text(&bytes[..bytes.len().min(QUOTED_BYTES)]))
}

fn plural(count: usize, one: &str, many: &str) -> String {
    if count == 1 { format!("1 {one}") } else { format!("{count} {many}") }
}

fn line_sentence(kind: FindingKind, group: &Group, usual: usize) -> (Severity, String) {
    let places = group.places();
    match kind {
        FindingKind::RaggedLine => {
            let lines = plural(group.count, "line does", "lines do");
            let text = format!(
                "{lines} not hold {usual} cells {places}; missing cells are holes, and a line with too many is one in every column"
            );
            (Severity::Excluded, text)
        }
        FindingKind::CommentLine => {
            (Severity::Note, format!("{} among the data {places}", plural(group.count, "comment", "comments")))
        }
        FindingKind::RepeatedHeader => {
            let times = plural(group.count, "line", "lines");
            (
                Severity::Note,
                format!("the header stands again among the data, {times} {places}: was the log started anew?"),
            )
        }
        FindingKind::Trailer => {
            let lines = plural(group.count, "line", "lines");
            (Severity::Note, format!("{lines} of text after the last sample {places}; not read as data"))
        }
        // Lines among the data that hold no sample, and whatever kind is added.
        _ => {
            let lines = plural(group.count, "line", "lines");
            (Severity::Excluded, format!("{lines} without a sample left out {places}"))
        }
    }
}

fn cell_sentence(kind: FindingKind, group: &Group, name: &str) -> (Severity, String) {
    let (name, places) = (shown(name), group.places());
    let cells = |one: &str, many: &str| plural(group.count, one, many);
    match kind {
        FindingKind::EmptyCell => (
            Severity::Note,
            format!("column {name}: {} {places}; left as holes", cells("cell is empty", "cells are empty")),
        ),
        FindingKind::NoValue => {
            let cells = cells("cell says that there is no value", "cells say that there is no value");
            (Severity::Excluded, format!("column {name}: {cells} {places}; left as holes"))
        }
        _ => {
            let cells = cells("cell is not a number", "cells are not numbers");
            (Severity::Excluded, format!("column {name}: {cells} {places}; left as holes"))
        }
    }
}
