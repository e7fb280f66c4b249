//! Collecting what is odd while lines are read, and telling it afterwards.

use std::collections::BTreeMap;

use crate::finding::places::{ByKind, Places, cell_finding, line_finding};
use crate::finding::{Finding, FindingKind, LineMap, Severity};

/// What was odd, by kind and column.
#[derive(Debug, Default)]
pub(in crate::formats) struct Tally {
    cells: BTreeMap<(usize, FindingKind), Places>,
    lines: ByKind,
    /// Findings that have their sentence already.
    told: Vec<Finding>,
}

impl Tally {
    /// A cell of a column of numbers that holds none.
    pub fn cell(&mut self, kind: FindingKind, column: usize, row: usize, line: usize, cell: &[u8]) {
        self.cells.entry((column, kind)).or_default().add(row, line, cell);
    }

    /// A line, and what is said of it; `row` is the sample on it, or the next one.
    pub fn line(&mut self, kind: FindingKind, row: usize, line: usize, what: impl FnOnce() -> String) {
        self.lines.entry(kind).or_default().add_said(row, line, what);
    }

    /// A finding with its sentence.
    pub fn tell(&mut self, file: &str, kind: FindingKind, severity: Severity, lines: &[(usize, usize)], text: String) {
        let mut places = Places::default();
        for (row, line) in lines {
            places.add(*row, *line, &[]);
        }
        self.told.push(places.finding(kind, severity, file, None, text));
    }

    /// Lines with bytes that are not the encoding; known before any row is read.
    pub fn encoding(&mut self, file: &str, count: usize, first: &[usize], lines: &LineMap, text: String) {
        let places: Vec<(usize, usize)> = first.iter().map(|line| (lines.rows_before(*line), *line)).collect();
        self.tell(file, FindingKind::Encoding, Severity::Note, &places, text);
        if let Some(finding) = self.told.last_mut() {
            finding.count = count;
        }
    }

    /// All findings: those of the file, of lines, of cells by column. A line should hold `usual` cells.
    pub fn findings(self, file: &str, names: &[String], usual: usize) -> Vec<Finding> {
        let mut findings = self.told;
        findings.extend(self.lines.into_iter().map(|(kind, places)| line_finding(kind, places, file, usual)));
        findings.extend(self.cells.into_iter().map(|((column, kind), places)| {
            let name = names.get(column).map_or("", String::as_str);
            cell_finding(kind, places, file, name)
        }));
        findings
    }
}
