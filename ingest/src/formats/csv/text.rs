//! Bytes to lines and cells: encodings, line ends, quotes.

use std::borrow::Cow;

use crate::limits::LINE_BYTES_MAX;

/// How the text is encoded.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Encoding {
    /// UTF-8, ASCII included.
    Utf8,
    /// UTF-8 after a byte-order mark.
    Utf8Bom,
    /// UTF-16, low byte first.
    Utf16Le,
    /// UTF-16, high byte first.
    Utf16Be,
    /// UTF-8 except for single lines, which are read as Latin-1.
    Latin1,
}

impl Encoding {
    /// Its name in sentences.
    pub fn name(self) -> &'static str {
        match self {
            Self::Utf8 => "UTF-8",
            Self::Utf8Bom => "UTF-8 with a byte-order mark",
            Self::Utf16Le => "UTF-16, low byte first",
            Self::Utf16Be => "UTF-16, high byte first",
            Self::Latin1 => "Latin-1",
        }
    }
}

/// A text as bytes in UTF-8, single lines in Latin-1.
#[derive(Debug)]
pub(super) struct Text<'a> {
    pub bytes: Cow<'a, [u8]>,
    pub encoding: Encoding,
    /// Zero bytes cut off at the end: what a file system leaves of a file that was being written when the power went.
    pub zeros: usize,
    /// A UTF-16 text that ends within a unit.
    pub half_unit: bool,
    /// Lines with bytes that are not the encoding: how many, and the first of them.
    pub bad_lines: usize,
    pub first_bad_lines: Vec<usize>,
}

/// Lines with bad bytes that are listed.
const BAD_LINES_LISTED: usize = 20;

pub(super) fn decode(bytes: &[u8]) -> Text<'_> {
    if let Some(encoding) = utf16(bytes) {
        return decode_utf16(bytes, encoding);
    }
    let (encoding, bytes) = match bytes.strip_prefix(b"\xef\xbb\xbf") {
        Some(rest) => (Encoding::Utf8Bom, rest),
        None => (Encoding::Utf8, bytes),
    };
    let end = bytes.iter().rposition(|b| *b != 0).map_or(0, |last| last + 1);
    let zeros = bytes.len() - end;
    let bytes = &bytes[..end];
    let mut text = Text {
        bytes: Cow::Borrowed(bytes),
        encoding,
        zeros,
        half_unit: false,
        bad_lines: 0,
        first_bad_lines: Vec::new(),
    };
    if std::str::from_utf8(bytes).is_err() {
        text.encoding = Encoding::Latin1;
        let (mut at, mut line) = (0, 1);
        while at < bytes.len() {
            let end = line_end(bytes, at);
            if std::str::from_utf8(&bytes[at..end]).is_err() {
                text.bad(line);
            }
            at = after_line_end(bytes, end);
            line += 1;
        }
    }
    text
}

impl Text<'_> {
    fn bad(&mut self, line: usize) {
        self.bad_lines += 1;
        if self.first_bad_lines.len() < BAD_LINES_LISTED {
            self.first_bad_lines.push(line);
        }
    }
}

/// UTF-16 by its mark, or by every second byte of the beginning being zero.
fn utf16(bytes: &[u8]) -> Option<Encoding> {
    match bytes {
        [0xff, 0xfe, ..] => return Some(Encoding::Utf16Le),
        [0xfe, 0xff, ..] => return Some(Encoding::Utf16Be),
        _ => {}
    }
    let (pairs, _) = bytes.get(..256.min(bytes.len()))?.as_chunks::<2>();
    if pairs.len() < 4 {
        return None;
    }
    let low_first = pairs.iter().all(|[a, b]| *a != 0 && *b == 0);
    let high_first = pairs.iter().all(|[a, b]| *a == 0 && *b != 0);
    low_first.then_some(Encoding::Utf16Le).or(high_first.then_some(Encoding::Utf16Be))
}

fn decode_utf16(bytes: &[u8], encoding: Encoding) -> Text<'static> {
    let (pairs, rest) = bytes.as_chunks::<2>();
    let units = pairs.iter().map(|pair| match encoding {
        Encoding::Utf16Be => u16::from_be_bytes(*pair),
        _ => u16::from_le_bytes(*pair),
    });
    let mut text = Text {
        bytes: Cow::Borrowed(&[]),
        encoding,
        zeros: 0,
        half_unit: !rest.is_empty(),
        bad_lines: 0,
        first_bad_lines: Vec::new(),
    };
    let mut out = String::with_capacity(pairs.len());
    let mut line = 1;
    for c in char::decode_utf16(units) {
        let c = c.unwrap_or_else(|_| {
            if text.first_bad_lines.last() != Some(&line) {
                text.bad(line);
            }
            char::REPLACEMENT_CHARACTER
        });
        line += usize::from(c == '\n');
        out.push(c);
    }
    if out.starts_with('\u{feff}') {
        out.drain(..'\u{feff}'.len_utf8());
    }
    let end = out.trim_end_matches('\0').len();
    text.zeros = 2 * (out.len() - end);
    out.truncate(end);
    text.bytes = Cow::Owned(out.into_bytes());
    text
}

/// Bytes as text: UTF-8, or else Latin-1, in which every byte is a character.
pub(super) fn to_text(bytes: &[u8]) -> String {
    match std::str::from_utf8(bytes) {
        Ok(text) => text.to_owned(),
        Err(_) => bytes.iter().map(|b| char::from(*b)).collect(),
    }
}

/// Where the line ends that goes on at `from`: at a line feed, a carriage return or the end of the text.
pub(super) fn line_end(bytes: &[u8], from: usize) -> usize {
    bytes[from..].iter().position(|b| matches!(b, b'\n' | b'\r')).map_or(bytes.len(), |length| from + length)
}

/// Where the next line begins after a line that ends at `end`: LF, CR LF, CR CR LF (written through two layers that both
/// translate line ends) and CR each are one line end.
#[inline]
pub(super) fn after_line_end(bytes: &[u8], end: usize) -> usize {
    match bytes.get(end..) {
        None | Some([]) => end,
        Some([b'\r', b'\r', b'\n', ..]) => end + 3,
        Some([b'\r', b'\n', ..]) => end + 2,
        Some(_) => end + 1,
    }
}

/// Without blanks at both ends.
pub(super) fn trim(mut bytes: &[u8]) -> &[u8] {
    while let [b' ' | b'\t', rest @ ..] | [rest @ .., b' ' | b'\t'] = bytes {
        bytes = rest;
    }
    bytes
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
        let text = to_text(self.of(bytes));
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
}

/// Splits the record that begins at `start` into cells, as RFC 4180 has it. Blanks around a cell do not belong to it. With a blank
/// as delimiter, any run of blanks and tabs is one delimiter.
///
/// A quote that is not closed before a delimiter or line end is a character like any other: an inch mark, or damage that must not
/// swallow the lines behind it.
pub(super) fn split(bytes: &[u8], start: usize, delimiter: u8, cells: &mut Vec<Cell>) -> Record {
    cells.clear();
    let mut end = line_end(bytes, start);
    let mut lines = 1;
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
        let close = if at < end && bytes[at] == b'"' { closing_quote(bytes, at, delimiter) } else { None };
        if let Some(close) = close {
            if close > end {
                lines += line_ends(&bytes[at..close]);
                end = line_end(bytes, close);
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
    Record { start, end, next: after_line_end(bytes, end), lines }
}

/// The quote that closes the one at `open`: not doubled, and followed by a delimiter or line end.
fn closing_quote(bytes: &[u8], open: usize, delimiter: u8) -> Option<usize> {
    let limit = bytes.len().min(open.saturating_add(LINE_BYTES_MAX));
    let mut at = open + 1;
    while at < limit {
        at += bytes[at..limit].iter().position(|b| *b == b'"')?;
        if bytes.get(at + 1) == Some(&b'"') {
            at += 2;
            continue;
        }
        let behind = bytes[at + 1..].iter().find(|b| **b == delimiter || !matches!(**b, b' ' | b'\t'));
        return match behind {
            None | Some(b'\n' | b'\r') => Some(at),
            Some(b) if *b == delimiter => Some(at),
            Some(_) => None,
        };
    }
    None
}

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
        let record = split(text.as_bytes(), 0, delimiter, &mut cells);
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
            lines.push(to_text(&text[at..end]));
            at = after_line_end(text, end);
        }
        assert_eq!(lines, ["a", "b", "c", "d", "e", "", "f"]);
    }

    #[test]
    fn utf16_is_known_with_and_without_its_mark() {
        let units = |text: &str, le: bool| -> Vec<u8> {
            text.encode_utf16().flat_map(|u| if le { u.to_le_bytes() } else { u.to_be_bytes() }).collect()
        };
        for (text, le) in [("\u{feff}a;°\n1;2\n", true), ("\u{feff}a;°\n1;2\n", false)] {
            assert_eq!(&*decode(&units(text, le)).bytes, "a;°\n1;2\n".as_bytes());
        }
        let plain = decode(&units("time;p\n", true)).encoding;
        assert_eq!(plain, Encoding::Utf16Le);
        let mut cut = units("time;p\n", false);
        cut.pop();
        assert!(decode(&cut).half_unit);
    }
}
