//! Places of one kind of oddity, gathered while a file is read and told in one finding.

use std::collections::BTreeMap;

use super::{Finding, FindingKind, Severity, Span, extend};
use crate::error::shown;

/// Places quoted in a sentence; the spans hold more.
const QUOTED_MAX: usize = 3;

/// Bytes kept of a quoted place: more than is ever shown.
const QUOTED_BYTES: usize = 400;

/// How often something odd was met, and the first times in words.
#[derive(Debug, Clone, Default)]
pub(crate) struct Firsts {
    /// How often.
    pub count: usize,
    first: Vec<String>,
}

impl Firsts {
    /// One more time, in words that are asked for only if they are quoted.
    pub fn add(&mut self, words: impl FnOnce() -> String) {
        self.count += 1;
        if self.first.len() < QUOTED_MAX {
            self.first.push(words());
        }
    }

    /// `byte 9: no length; byte 40: no length; and 4 more`.
    pub fn listed(&self) -> String {
        let more = self.count - self.first.len();
        let more = if more > 0 { format!("; and {more} more") } else { String::new() };
        format!("{}{more}", self.first.join("; "))
    }
}

/// Where something odd stands.
#[derive(Debug, Clone, Default)]
pub(crate) struct Places {
    firsts: Firsts,
    spans: Vec<Span>,
}

impl Places {
    /// How many there are.
    pub fn count(&self) -> usize {
        self.firsts.count
    }

    /// The first of them.
    pub fn spans(&self) -> &[Span] {
        &self.spans
    }

    /// A place: the sample on it or the next one, the line, and the bytes to quote, which may be none.
    pub fn add(&mut self, row: usize, line: usize, quote: &[u8]) {
        self.add_said(row, line, || if quote.is_empty() { String::new() } else { quoted(quote) });
    }

    /// A place and what is said of it.
    pub fn add_said(&mut self, row: usize, line: usize, what: impl FnOnce() -> String) {
        self.add_worded(row, line, || match what().as_str() {
            "" => format!("line {line}"),
            what => format!("line {line}: {what}"),
        });
    }

    /// A place in words of its own; `line` is 0 where the file has no lines.
    pub fn add_worded(&mut self, row: usize, line: usize, words: impl FnOnce() -> String) {
        extend(&mut self.spans, Span { first_sample: row, last_sample: row, first_line: line, last_line: line });
        self.firsts.add(words);
    }

    /// `(line 5: `ERR`; line 9: `OVL`; and 4 more)`.
    pub fn listed(&self) -> String {
        format!("({})", self.firsts.listed())
    }

    /// `1 line` or `7 lines`.
    pub fn counted(&self, one: &str, many: &str) -> String {
        match self.count() {
            1 => format!("1 {one}"),
            count => format!("{count} {many}"),
        }
    }

    /// The finding.
    pub fn finding(
        self,
        kind: FindingKind,
        severity: Severity,
        file: &str,
        channel: Option<&str>,
        text: String,
    ) -> Finding {
        let Self { firsts: Firsts { count, .. }, spans } = self;
        Finding { kind, severity, file: file.to_owned(), channel: channel.map(str::to_owned), spans, count, text }
    }
}

/// A cell without a number, as a finding: `column `p`: 1 cell is not a number (line 3: `ERR`); left as holes`.
pub(crate) fn cell_finding(kind: FindingKind, places: Places, file: &str, name: &str) -> Finding {
    let (severity, what) = match kind {
        FindingKind::EmptyCell => (Severity::Note, places.counted("cell is empty", "cells are empty")),
        FindingKind::NoValue => {
            (Severity::Excluded, places.counted("cell says that there is no value", "cells say that there is no value"))
        }
        FindingKind::OutOfRange => (Severity::Excluded, places.counted("cell says overload", "cells say overload")),
        FindingKind::UnitMismatch => {
            (Severity::Excluded, places.counted("cell is in another unit", "cells are in another unit"))
        }
        FindingKind::LowQuality => (
            Severity::Excluded,
            places.counted("value is not to be trusted by its status", "values are not to be trusted by their status"),
        ),
        _ => (Severity::Excluded, places.counted("cell is not a number", "cells are not numbers")),
    };
    let text = format!("column {}: {what} {}; left as holes", shown(name), places.listed());
    places.finding(kind, severity, file, Some(name), text)
}

/// Lines that are odd, as a finding; `usual` is how many cells a line should hold.
pub(crate) fn line_finding(kind: FindingKind, places: Places, file: &str, usual: usize) -> Finding {
    let listed = places.listed();
    let lines = places.counted("line", "lines");
    let (severity, text) = match kind {
        FindingKind::RaggedLine => {
            let do_not = if places.count() == 1 { "does" } else { "do" };
            let text = format!(
                "{lines} {do_not} not hold {usual} cells {listed}; missing cells are holes, and a line with too many is one in every column"
            );
            (Severity::Excluded, text)
        }
        FindingKind::RepeatedHeader => {
            let text = format!("the header stands again among the data, {lines} {listed}: was the log started anew?");
            (Severity::Note, text)
        }
        FindingKind::CommentLine => {
            (Severity::Note, format!("{} among the data {listed}", places.counted("comment", "comments")))
        }
        FindingKind::Trailer => {
            (Severity::Note, format!("{lines} of text after the last sample {listed}; not read as data"))
        }
        _ => (Severity::Excluded, format!("{lines} without a sample left out {listed}")),
    };
    places.finding(kind, severity, file, None, text)
}

/// A finding about one line.
pub(crate) fn told(
    kind: FindingKind,
    severity: Severity,
    file: &str,
    row: usize,
    line: usize,
    text: String,
) -> Finding {
    let mut places = Places::default();
    places.add(row, line, &[]);
    places.finding(kind, severity, file, None, text)
}

/// A finding of what has no place among samples and lines.
pub(crate) fn placeless(
    kind: FindingKind,
    severity: Severity,
    file: &str,
    channel: Option<&str>,
    count: usize,
    text: String,
) -> Finding {
    Finding { kind, severity, file: file.to_owned(), channel: channel.map(str::to_owned), spans: vec![], count, text }
}

/// What is said of a last line that ends before its cells do; whether the last of them `is_cut` is not certain.
pub(crate) fn cut_line(line: usize, held: usize, usual: usize, is_cut: bool) -> String {
    let cell = if is_cut { "; the last of them may be cut and is a hole" } else { "" };
    format!("the file ends within line {line}: {held} of {usual} cells are there{cell}; what followed is lost")
}

/// What is said of a last line that is whole but for its end.
pub(crate) fn no_line_end(line: usize) -> String {
    format!("line {line}, the last, has no line end: its last number may be cut, or nothing is missing")
}

/// What is said of a text behind which there are zero bytes.
pub(crate) fn zero_bytes(count: u64) -> String {
    format!(
        "the file ends in {count} zero bytes, as after a power cut while it was written; what they stand for is lost"
    )
}

/// What is said of a text that ends within a unit of UTF-16.
pub(crate) const HALF_CHARACTER: &str = "the file ends within a character; what followed is lost";

/// Places by kind.
pub(crate) type ByKind = BTreeMap<FindingKind, Places>;

/// What stands in a file, fit to be shown.
pub(crate) fn quoted(bytes: &[u8]) -> String {
    shown(&as_text(bytes.get(..QUOTED_BYTES).unwrap_or(bytes)))
}

/// Bytes as text: UTF-8, or else Latin-1, in which every byte is a character.
pub(crate) fn as_text(bytes: &[u8]) -> String {
    match std::str::from_utf8(bytes) {
        Ok(text) => text.to_owned(),
        Err(_) => bytes.iter().map(|b| char::from(*b)).collect(),
    }
}
