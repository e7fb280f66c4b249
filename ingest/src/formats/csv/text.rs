//! Text to lines and cells: line ends, quotes.

use super::source::{BadLines, Window};
pub(super) use crate::finding::places::as_text;
pub(super) use crate::formats::lines::trim;
use crate::limits::LINE_BYTES_MAX;

/// Where the line ends that goes on at `from`: at a line feed, a carriage return or the end of the text.
pub(super) fn line_end(bytes: &[u8], from: usize) -> usize {
    bytes[from..].iter().position(|b| matches!(b, b'\n' | b'\r')).map_or(bytes.len(), |length| from + length)
}

/// Where the next line begins after a line that ends at `end`: LF, CR LF, CR CR LF (written through two layers that both
/// translate line ends) and CR each are one line end.
#[inline]
pub(in crate::formats) fn after_line_end(bytes: &[u8], end: usize) -> usize {
    match bytes.get(end..) {
        None | Some([]) => end,
        Some([b'\r', b'\r', b'\n', ..]) => end + 3,
        Some([b'\r', b'\n', ..]) => end + 2,
        Some(_) => end + 1,
    }
}

/// A cell between its delimiters, blanks and quotes taken off.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Cell {
    pub start: usize,
    pub end: usize,
    pub quoted: bool,
}

impl Cell {
    pub fn of<'a>(&self, bytes: &'a [u8]) -> &'a [u8] {
        &bytes[self.start..self.end]
    }

    /// The text, with doubled quotes made single.
    pub fn text(&self, bytes: &[u8]) -> String {
        let text = as_text(self.of(bytes));
        if self.quoted { text.replace("\"\"", "\"") } else { text }
    }
}

/// One line of cells; more than one line of text where a quoted cell holds line ends.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Record {
    pub start: usize,
    pub end: usize,
    /// Where the next record begins.
    pub next: usize,
    /// Lines of text.
    pub lines: usize,
}

impl Record {
    /// Whether a line end follows.
    pub fn is_ended(&self) -> bool {
        self.next > self.end
    }

    /// The same, followed by a line end.
    pub fn ended(self) -> Self {
        Self { next: self.end + 1, ..self }
    }
}

/// Bytes behind its beginning on which a record may depend: a quote in its last allowed byte closes a line's length further on.
pub(super) const LOOKAHEAD: usize = 2 * LINE_BYTES_MAX + 16;

/// Splits the record that begins at `start` into cells, as RFC 4180 has it. Blanks around a cell do not belong to it. With a blank
/// as delimiter, any run of blanks and tabs is one delimiter.
///
/// A quote that is not closed before a delimiter or line end is a character like any other: an inch mark, or damage that must not
/// swallow the lines behind it.
///
/// `None` if the record depends on bytes behind the window. One that is too long is given without its cells and without its end.
pub(super) fn split(window: Window, start: usize, delimiter: u8, cells: &mut Vec<Cell>) -> Option<Record> {
    cells.clear();
    let bytes = window.bytes;
    let too_long = start.saturating_add(LINE_BYTES_MAX + 1);
    let cut = |end, lines| Some(Record { start, end, next: end, lines });
    let mut end = window.line_end(start, too_long)?;
    let mut lines = 1;
    if end == too_long {
        return cut(end, lines);
    }
    let mut at = start;
    let blank = |b: u8| (b == b' ' || b == b'\t') && b != delimiter;
    let by_blanks = delimiter == b' ';
    loop {
        while at < end && (blank(bytes[at]) || (by_blanks && bytes[at] == b' ')) {
            at += 1;
        }
        if by_blanks && at == end && !cells.is_empty() {
            break;
        }
        let close = if at < end && bytes[at] == b'"' { closing_quote(window, at, delimiter)? } else { Close::Nowhere };
        if let Close::At(close) = close {
            if close > end {
                lines += line_ends(&bytes[at..close]);
                end = if close < too_long { window.line_end(close, too_long)? } else { close };
                if end >= too_long {
                    cells.clear();
                    return cut(end, lines);
                }
            }
            cells.push(Cell { start: at + 1, end: close, quoted: true });
            at = close + 1;
            while at < end && blank(bytes[at]) {
                at += 1;
            }
        } else {
            let ends_here = |b: &u8| *b == delimiter || (by_blanks && *b == b'\t');
            let stop = bytes[at..end].iter().position(ends_here).map_or(end, |length| at + length);
            let cell = trim(&bytes[at..stop]);
            cells.push(Cell { start: at, end: at + cell.len(), quoted: false });
            at = stop;
        }
        if at >= end {
            break;
        }
        at += 1;
    }
    Some(Record { start, end, next: window.after_line_end(end)?, lines })
}

/// Where a quote is closed.
enum Close {
    At(usize),
    Nowhere,
}

/// The quote that closes the one at `open`: not doubled, and followed by a delimiter or line end, all within the length of a line.
/// `None` if the bytes that decide it are behind the window.
fn closing_quote(window: Window, open: usize, delimiter: u8) -> Option<Close> {
    let limit = open.saturating_add(LINE_BYTES_MAX);
    let bytes = &window.bytes[..window.bytes.len().min(limit)];
    let is_all = window.ended || bytes.len() == limit;
    let mut at = open + 1;
    while let Some(length) = bytes.get(at..).and_then(|rest| rest.iter().position(|b| *b == b'"')) {
        at += length;
        let behind = &bytes[at + 1..];
        if behind.first() == Some(&b'"') {
            at += 2;
            continue;
        }
        return match behind.iter().find(|b| **b == delimiter || !matches!(**b, b' ' | b'\t')) {
            Some(b'\n' | b'\r') => Some(Close::At(at)),
            Some(b) if *b == delimiter => Some(Close::At(at)),
            Some(_) => Some(Close::Nowhere),
            None if bytes.len() == limit => Some(Close::Nowhere),
            None => is_all.then_some(Close::At(at)),
        };
    }
    is_all.then_some(Close::Nowhere)
}

/// Tells which lines hold bytes that are not UTF-8; the first of them is `line`.
pub(in crate::formats) fn check_utf8(bytes: &[u8], mut line: usize, bad: &mut BadLines) {
    if std::str::from_utf8(bytes).is_ok() {
        return;
    }
    let mut at = 0;
    while at < bytes.len() {
        let end = line_end(bytes, at);
        if std::str::from_utf8(&bytes[at..end]).is_err() {
            bad.add(line);
        }
        at = after_line_end(bytes, end);
        line += 1;
    }
}

/// Line ends in a text.
pub(super) fn line_ends(bytes: &[u8]) -> usize {
    let (mut at, mut count) = (0, 0);
    loop {
        let end = line_end(bytes, at);
        if end == bytes.len() {
            return count;
        }
        at = after_line_end(bytes, end);
        count += 1;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cells(text: &str, delimiter: u8) -> (Vec<String>, usize) {
        let mut cells = Vec::new();
        let record = split(Window::whole(text.as_bytes()), 0, delimiter, &mut cells).unwrap();
        (cells.iter().map(|c| c.text(text.as_bytes())).collect(), record.lines)
    }

    #[test]
    fn cells_are_split_as_rfc_4180_has_it() {
        assert_eq!(cells("a, b ,\"c,\"\"d\"\"\"\nx", b',').0, ["a", "b", "c,\"d\""]);
        assert_eq!(cells("", b',').0, [""]);
        assert_eq!(cells("a,", b',').0, ["a", ""]);
        assert_eq!(cells("\"a\r\nb\",c\n", b','), (vec!["a\r\nb".to_owned(), "c".to_owned()], 2));
        assert_eq!(cells("1\t\t 2\t", b'\t').0, ["1", "", "2", ""]);
        assert_eq!(cells("  1   2\t3  ", b' ').0, ["1", "2", "3"]);
        assert_eq!(cells("\"a b\" c", b' ').0, ["a b", "c"]);
    }

    #[test]
    fn a_quote_that_is_not_closed_swallows_nothing() {
        assert_eq!(cells("5\",6\n7,8\n", b','), (vec!["5\"".to_owned(), "6".to_owned()], 1));
        assert_eq!(cells("\"5,6\n7,8\n", b','), (vec!["\"5".to_owned(), "6".to_owned()], 1));
        assert_eq!(cells("\"5,6\n\"7,8\n", b','), (vec!["\"5".to_owned(), "6".to_owned()], 1));
    }

    #[test]
    fn line_ends_of_every_kind_are_one_each() {
        let text = b"a\nb\r\nc\r\r\nd\re\n\nf";
        let (mut at, mut lines) = (0, Vec::new());
        while at < text.len() {
            let end = line_end(text, at);
            lines.push(as_text(&text[at..end]));
            at = after_line_end(text, end);
        }
        assert_eq!(lines, ["a", "b", "c", "d", "e", "", "f"]);
    }

    #[test]
    fn a_record_is_decided_once_its_bytes_are_there_and_not_before() {
        let texts =
            ["1,2\r\r\n3", "1,2\r\r", "1,\"a\"\"\nb\" \r\n\"c", "1,\"2\n3,4\n5\"6,\n", "\"a\"\"\n", "", "a \" b\n"];
        for (text, delimiter) in texts.iter().flat_map(|text| [(text.as_bytes(), b','), (text.as_bytes(), b' ')]) {
            let mut expected = Vec::new();
            let record = split(Window::whole(text), 0, delimiter, &mut expected);
            for cut in 0..text.len() {
                let mut cells = Vec::new();
                let begun = split(Window { bytes: &text[..cut], ended: false }, 0, delimiter, &mut cells);
                assert!(begun.is_none() || (begun == record && cells == expected), "{text:?} {cut}");
            }
        }
    }

    #[test]
    fn no_record_looks_further_than_it_may() {
        // The longest lookahead: a quote in the last allowed byte, and the next one as far away as is looked for it.
        let mut text = vec![b'1'; LINE_BYTES_MAX];
        text[LINE_BYTES_MAX - 2..].copy_from_slice(b",\"");
        text.push(b'\n');
        text.extend(std::iter::repeat_n(b'2', LINE_BYTES_MAX));
        text.resize(LOOKAHEAD, b'"');
        let mut cells = Vec::new();
        let record = split(Window { bytes: &text, ended: false }, 0, b',', &mut cells).unwrap();
        assert_eq!((record.end, cells.len()), (LINE_BYTES_MAX, 2));
    }
}
