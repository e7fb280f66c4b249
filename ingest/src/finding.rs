//! Findings: what is odd about recorded data, told in the report and never repaired in silence.
//!
//! An error stops the reading; a finding stands beside the data that were read. Findings are plain values: readers collect them,
//! [`clock_findings`] derives those of a time channel, and later stages count what is excluded or lost.

mod clock;

pub use clock::{clock_findings, forward_samples, median_rate_hz, median_step};

/// What a finding means for the samples it names.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Severity {
    /// Everything is kept; it is worth knowing.
    Note,
    /// The named samples or cells are not used; they are counted and listed.
    Excluded,
    /// Data that the instrument had are gone.
    Lost,
}

impl Severity {
    /// The word used in results.
    pub fn id(self) -> &'static str {
        match self {
            Self::Note => "note",
            Self::Excluded => "excluded",
            Self::Lost => "lost",
        }
    }
}

/// What was found.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
#[non_exhaustive]
pub enum FindingKind {
    /// Bytes that are not the text encoding they should be.
    Encoding,
    /// The header names another number of columns than the lines hold.
    HeaderMismatch,
    /// The header runs into the first sample without a line end.
    HeaderGlued,
    /// Text where a number should stand.
    NonNumericCell,
    /// The instrument wrote that it had no value: `NaN`, `inf`, `--`, `n/a`.
    NoValue,
    /// Nothing stands where a number should.
    EmptyCell,
    /// A line with too few or too many cells.
    RaggedLine,
    /// A line among the data that is no sample.
    SkippedLine,
    /// A comment among the data.
    CommentLine,
    /// The header stands again among the data.
    RepeatedHeader,
    /// Text after the last sample.
    Trailer,
    /// The file ends within a line.
    Truncated,
    /// The last line is whole but has no line end.
    NoLineEnd,
    /// A sample without a time stamp.
    NoStamp,
    /// Time goes back.
    TimeReversed,
    /// A stamp equal to the one before.
    DuplicateStamp,
    /// Steps of time much longer than usual.
    Gap,
    /// Values outside the range in which the sensor was calibrated.
    OutOfCalibration,
    /// Values beyond what the instrument can show.
    OutOfRange,
    /// A log that cannot be used at all, beside others that can.
    UnusableFile,
    /// The log says another unit than the session or the instrument.
    UnitMismatch,
    /// Rows that belong to no run.
    UnclaimedRows,
    /// Numbers that leave the range of a double on their way to SI.
    Overflow,
    /// The channel's zero is the mean of its first samples.
    Tared,
}

impl FindingKind {
    /// Its id in results.
    pub fn id(self) -> &'static str {
        match self {
            Self::Encoding => "encoding",
            Self::HeaderMismatch => "header-mismatch",
            Self::HeaderGlued => "header-glued",
            Self::NonNumericCell => "non-numeric-cell",
            Self::NoValue => "no-value",
            Self::EmptyCell => "empty-cell",
            Self::RaggedLine => "ragged-line",
            Self::SkippedLine => "skipped-line",
            Self::CommentLine => "comment-line",
            Self::RepeatedHeader => "repeated-header",
            Self::Trailer => "trailer",
            Self::Truncated => "truncated",
            Self::NoLineEnd => "no-line-end",
            Self::NoStamp => "no-stamp",
            Self::TimeReversed => "time-reversed",
            Self::DuplicateStamp => "duplicate-stamp",
            Self::Gap => "gap",
            Self::OutOfCalibration => "out-of-calibration",
            Self::OutOfRange => "out-of-range",
            Self::UnusableFile => "unusable-file",
            Self::UnitMismatch => "unit-mismatch",
            Self::UnclaimedRows => "unclaimed-rows",
            Self::Overflow => "overflow",
            Self::Tared => "tared",
        }
    }
}

/// A run of neighbouring samples and the lines they stand on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
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
#[derive(Debug, Clone, PartialEq, Eq)]
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
