//! Findings: what is odd about recorded data, told in the report and never repaired in silence.
//!
//! An error stops the reading; a finding stands beside the data that were read. Findings are plain values: readers collect them,
//! [`clock_findings`] derives those of a time channel, and later stages count what is excluded or lost.

mod clock;
mod kind;
pub(crate) mod places;

pub use clock::{clock_findings, forward_samples, leave_forward, median_step, rate_hz, unwrap};
pub use kind::FindingKind;

use serde::{Deserialize, Serialize};

/// What a finding means for the samples it names.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Severity {
    /// Everything is kept; it is worth knowing.
    Note,
    /// The named samples or cells are not used; they are counted and listed.
    Excluded,
    /// Data that the instrument had are gone.
    Lost,
}

impl Severity {
    /// Every severity, the mildest first.
    pub const ALL: [Self; 3] = [Self::Note, Self::Excluded, Self::Lost];

    /// The word used in results.
    pub fn id(self) -> &'static str {
        match self {
            Self::Note => "note",
            Self::Excluded => "excluded",
            Self::Lost => "lost",
        }
    }
}

/// A run of neighbouring samples and the lines they stand on.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Span {
    /// First sample, from 0. Where lines are meant that hold no sample: the sample that follows them.
    pub first_sample: usize,
    /// Last sample, itself included.
    pub last_sample: usize,
    /// First line, from 1; 0 where the file has no lines.
    pub first_line: usize,
    /// Last line, itself included.
    pub last_line: usize,
}

/// Spans kept per finding; `count` counts all.
pub const SPANS_MAX: usize = 20;

/// Adds a span, or lengthens the last one if this one continues it. Beyond [`SPANS_MAX`] nothing is added.
pub fn extend(spans: &mut Vec<Span>, span: Span) {
    if let Some(last) = spans.last_mut()
        && span.first_sample <= last.last_sample + 1
        && span.first_line <= last.last_line + 1
    {
        last.last_sample = last.last_sample.max(span.last_sample);
        last.last_line = last.last_line.max(span.last_line);
    } else if spans.len() < SPANS_MAX {
        spans.push(span);
    }
}

/// Something odd about recorded data.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Finding {
    /// What.
    pub kind: FindingKind,
    /// What it means for the samples.
    pub severity: Severity,
    /// The file, as the user named it.
    pub file: String,
    /// The channel, if one is meant.
    pub channel: Option<String>,
    /// Where: the first [`SPANS_MAX`] places.
    pub spans: Vec<Span>,
    /// Samples, cells or lines concerned: all of them.
    pub count: usize,
    /// A sentence that names the first places.
    pub text: String,
}

/// Which line each sample stands on: only the places where lines and samples do not advance together are stored.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct LineMap {
    runs: Vec<LineRun>,
    rows: usize,
    /// The line on which the next row would continue the last run.
    next_line: usize,
}

/// Rows on lines that are equally far apart: every second one where a blank line stands between them, as LF CR makes it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct LineRun {
    row: usize,
    line: usize,
    step: usize,
}

impl LineMap {
    /// Adds the next row, which stands on `line`.
    #[inline]
    pub fn push(&mut self, line: usize) {
        match self.runs.last_mut() {
            Some(last) if line == self.next_line => self.next_line += last.step,
            // The second row of a run says how far apart its lines are.
            Some(last) if last.row + 1 == self.rows && line > last.line => {
                last.step = line - last.line;
                self.next_line = line + last.step;
            }
            _ => {
                self.runs.push(LineRun { row: self.rows, line, step: 1 });
                self.next_line = line + 1;
            }
        }
        self.rows += 1;
    }

    /// The line of a row, from 1; 0 for a row that is not there.
    pub fn line_of(&self, row: usize) -> usize {
        let run = self.runs.partition_point(|run| run.row <= row);
        match run.checked_sub(1).and_then(|i| self.runs.get(i)) {
            Some(run) if row < self.rows => run.line + (row - run.row) * run.step,
            _ => 0,
        }
    }

    /// How many rows stand before a line.
    pub fn rows_before(&self, line: usize) -> usize {
        let next = self.runs.partition_point(|run| run.line < line);
        let Some(run) = next.checked_sub(1).and_then(|i| self.runs.get(i)) else { return 0 };
        let end = self.runs.get(next).map_or(self.rows, |next| next.row);
        end.min(run.row + (line - run.line).div_ceil(run.step))
    }

    /// How many rows there are.
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// Where a row stands, in words: `line 5`, or `sample 4` where the file has no lines.
    ///
    /// ```
    /// use pneuval_ingest::finding::LineMap;
    /// let mut lines = LineMap::default();
    /// assert_eq!(lines.place(0), "sample 0");
    /// lines.push(5);
    /// assert_eq!(lines.place(0), "line 5");
    /// ```
    pub fn place(&self, row: usize) -> String {
        match self.line_of(row) {
            0 => format!("sample {row}"),
            line => format!("line {line}"),
        }
    }

    /// Rows in words: `sample 3 (line 5)`, `samples 7 to 9 (lines 9 to 11)`, or without lines where the file has none.
    pub fn between(&self, first: usize, last: usize) -> String {
        match (first == last, self.line_of(first), self.line_of(last)) {
            (true, 0, _) => format!("sample {first}"),
            (true, line, _) => format!("sample {first} (line {line})"),
            (false, 0, _) => format!("samples {first} to {last}"),
            (false, a, b) => format!("samples {first} to {last} (lines {a} to {b})"),
        }
    }

    /// One span of rows, whatever stands on the lines between them.
    pub fn span(&self, first: usize, last: usize) -> Span {
        Span { first_sample: first, last_sample: last, first_line: self.line_of(first), last_line: self.line_of(last) }
    }

    /// Adds rows to spans as [`extend`] would one by one: where lines stand between them that are no rows, a new span begins.
    pub(crate) fn extend(&self, spans: &mut Vec<Span>, first: usize, last: usize) {
        let mut from = first;
        while from <= last {
            let next = self.runs.partition_point(|run| run.row <= from);
            let is_dense = next.checked_sub(1).and_then(|i| self.runs.get(i)).is_none_or(|run| run.step == 1);
            let end = self.runs.get(next).map_or(last, |run| last.min(run.row - 1));
            let to = if is_dense { end } else { from };
            let before = (spans.len(), spans.last().map(|span| span.last_sample));
            extend(spans, self.span(from, to));
            if before == (spans.len(), spans.last().map(|span| span.last_sample)) {
                // No room, and what follows is no continuation either.
                return;
            }
            from = to + 1;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_and_lines_are_mapped_both_ways() {
        let mut lines = LineMap::default();
        for line in [3, 4, 5, 9, 10, 20] {
            lines.push(line);
        }
        assert_eq!((0..7).map(|row| lines.line_of(row)).collect::<Vec<_>>(), [3, 4, 5, 9, 10, 20, 0]);
        assert_eq!([1, 3, 4, 6, 9, 10, 15, 20, 21].map(|line| lines.rows_before(line)), [0, 0, 1, 3, 3, 4, 5, 5, 6]);
        assert_eq!(lines.runs.len(), 3);
    }

    #[test]
    fn rows_are_placed_in_words() {
        let mut lines = LineMap::default();
        assert_eq!(
            (lines.place(4), lines.between(4, 4), lines.between(4, 6)),
            ("sample 4".to_owned(), "sample 4".to_owned(), "samples 4 to 6".to_owned())
        );
        (0..9).for_each(|row| lines.push(row + 3));
        assert_eq!(
            (lines.place(4), lines.between(4, 4), lines.between(4, 6)),
            ("line 7".to_owned(), "sample 4 (line 7)".to_owned(), "samples 4 to 6 (lines 7 to 9)".to_owned())
        );
    }

    #[test]
    fn rows_added_together_give_the_spans_of_rows_added_one_by_one() {
        let mut lines = LineMap::default();
        for line in [3, 4, 5, 9, 10, 20, 22, 24, 26, 27] {
            lines.push(line);
        }
        for lines in [lines, LineMap::default()] {
            for (first, last) in (0..10).flat_map(|first| (first..10).map(move |last| (first, last))) {
                let (mut one_by_one, mut together) = (vec![], vec![]);
                (first..=last).for_each(|row| extend(&mut one_by_one, lines.span(row, row)));
                lines.extend(&mut together, first, last);
                assert_eq!(together, one_by_one, "{first} to {last}");
            }
        }
    }

    #[test]
    fn ids_in_results_and_in_stored_files_agree() {
        for kind in FindingKind::ALL {
            assert_eq!(serde_json::to_value(kind).unwrap(), kind.id());
            assert_eq!(serde_json::from_value::<FindingKind>(kind.id().into()).unwrap(), *kind);
        }
        for severity in Severity::ALL {
            assert_eq!(serde_json::to_value(severity).unwrap(), severity.id());
        }
        // What serde lists as possible is what `ALL` lists: a kind that is added later cannot be forgotten there.
        let listed = serde_json::from_str::<FindingKind>("\"?\"").unwrap_err().to_string();
        assert_eq!(listed.matches('`').count(), 2 * (1 + FindingKind::ALL.len()), "{listed}");
    }

    #[test]
    fn a_stored_finding_is_read_as_it_was() {
        let finding = Finding {
            kind: FindingKind::CrcMismatch,
            severity: Severity::Lost,
            file: "r.mcap".to_owned(),
            channel: None,
            spans: vec![LineMap::default().span(3, 7)],
            count: 5,
            text: "a sentence".to_owned(),
        };
        let stored = serde_json::to_string(&finding).unwrap();
        assert_eq!(serde_json::from_str::<Finding>(&stored).unwrap(), finding);
    }

    #[test]
    fn lines_with_a_blank_one_between_them_are_one_run() {
        let mut lines = LineMap::default();
        let expected: Vec<usize> = (0..1_000).map(|i| 2 + 2 * i).chain([2_003, 2_004, 2_005, 2_009, 2_013]).collect();
        for line in &expected {
            lines.push(*line);
        }
        assert_eq!((0..lines.rows()).map(|row| lines.line_of(row)).collect::<Vec<_>>(), expected);
        for line in 0..2_020 {
            assert_eq!(lines.rows_before(line), expected.iter().filter(|l| **l < line).count(), "{line}");
        }
        assert_eq!(lines.runs.len(), 3);
    }
}
