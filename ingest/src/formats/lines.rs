//! Lines of a text log, read from front to back in memory bounded by the longest line.
//!
//! LF, CR LF, CR CR LF and CR each end a line. UTF-16 becomes UTF-8, a byte-order mark is taken off, and zero bytes at the end,
//! which a power cut leaves, are counted and no line.

use std::io::Read;

use crate::IngestError;
use crate::error::Place;
use crate::finding::places::{HALF_CHARACTER, told, zero_bytes};
use crate::finding::{Finding, FindingKind, LineMap, Severity};
use crate::limits::LINE_BYTES_MAX;
use crate::raw::RawFile;

/// Bytes asked of the file at once.
const BLOCK: usize = 1 << 16;

/// How the bytes stand for characters.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Encoding {
    Bytes,
    Utf16 { low_first: bool },
}

impl Encoding {
    /// By the mark at the beginning, or by every second byte being zero; and the length of the mark.
    fn of(head: &[u8]) -> (Self, usize) {
        let utf16 = |low_first| Self::Utf16 { low_first };
        match head {
            [0xff, 0xfe, ..] => return (utf16(true), 2),
            [0xfe, 0xff, ..] => return (utf16(false), 2),
            [0xef, 0xbb, 0xbf, ..] => return (Self::Bytes, 3),
            _ => {}
        }
        let (pairs, _) = head.get(..256.min(head.len())).unwrap_or_default().as_chunks::<2>();
        if pairs.len() < 4 {
            (Self::Bytes, 0)
        } else if pairs.iter().all(|[a, b]| *a != 0 && *b == 0) {
            (utf16(true), 0)
        } else if pairs.iter().all(|[a, b]| *a == 0 && *b != 0) {
            (utf16(false), 0)
        } else {
            (Self::Bytes, 0)
        }
    }
}

/// The bytes of a text as UTF-8, block by block.
pub(crate) struct Decoder<'a> {
    reader: Box<dyn Read + 'a>,
    block: Vec<u8>,
    begun: bool,
    encoding: Encoding,
    /// The first byte of a UTF-16 unit whose second is still to come.
    half: Option<u8>,
    /// The first unit of a pair of units.
    high: Option<u16>,
}

impl<'a> Decoder<'a> {
    /// The text that a reader gives.
    pub fn of(reader: Box<dyn Read + 'a>) -> Self {
        Self { reader, block: Vec::new(), begun: false, encoding: Encoding::Bytes, half: None, high: None }
    }

    /// Adds the next bytes to `out`; whether there were any.
    pub fn more(&mut self, out: &mut Vec<u8>) -> std::io::Result<bool> {
        self.block.resize(BLOCK, 0);
        let mut filled = 0;
        // The encoding is told from the first bytes, which may come one at a time.
        while filled < BLOCK {
            match self.reader.read(&mut self.block[filled..]) {
                Ok(0) => break,
                Ok(count) => filled += count,
                Err(error) if error.kind() == std::io::ErrorKind::Interrupted => {}
                Err(error) => return Err(error),
            }
        }
        let mut bytes = &self.block[..filled];
        if !self.begun {
            self.begun = true;
            let (encoding, mark) = Encoding::of(bytes);
            self.encoding = encoding;
            bytes = &bytes[mark..];
        }
        match self.encoding {
            Encoding::Bytes => out.extend_from_slice(bytes),
            Encoding::Utf16 { low_first } => {
                for byte in bytes {
                    let Some(first) = self.half.take() else {
                        self.half = Some(*byte);
                        continue;
                    };
                    let pair = [first, *byte];
                    let unit = if low_first { u16::from_le_bytes(pair) } else { u16::from_be_bytes(pair) };
                    push_unit(unit, &mut self.high, out);
                }
                if filled == 0 && self.high.take().is_some() {
                    push(char::REPLACEMENT_CHARACTER, out);
                }
            }
        }
        Ok(filled > 0)
    }
}

fn push(c: char, out: &mut Vec<u8>) {
    out.extend_from_slice(c.encode_utf8(&mut [0; 4]).as_bytes());
}

fn push_unit(unit: u16, high: &mut Option<u16>, out: &mut Vec<u8>) {
    if let Some(high) = high.take() {
        let pair = char::decode_utf16([high, unit]).next().and_then(Result::ok);
        push(pair.unwrap_or(char::REPLACEMENT_CHARACTER), out);
        if pair.is_some() {
            return;
        }
    }
    if (0xd800..0xdc00).contains(&unit) {
        // The first of two units.
        *high = Some(unit);
    } else {
        push(char::from_u32(unit.into()).unwrap_or(char::REPLACEMENT_CHARACTER), out);
    }
}

/// The lines of a text log.
pub(crate) struct Lines<'a> {
    raw: &'a RawFile<'a>,
    decoder: Decoder<'a>,
    buffer: Vec<u8>,
    /// Where the next line begins.
    at: usize,
    /// Bytes of it that hold no line end.
    searched: usize,
    ended: bool,
    number: usize,
    /// Zero bytes behind the last line.
    zeros: usize,
}

/// A line.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Line<'b> {
    /// What stands on it, without its end.
    pub bytes: &'b [u8],
    /// From 1.
    pub number: usize,
    /// Whether a line end follows.
    pub is_ended: bool,
}

impl<'a> Lines<'a> {
    /// The lines of a file.
    pub fn of(raw: &'a RawFile<'a>) -> Result<Self, IngestError> {
        let decoder = Decoder::of(raw.reader()?);
        Ok(Self { raw, decoder, buffer: Vec::new(), at: 0, searched: 0, ended: false, number: 0, zeros: 0 })
    }

    /// The next line. The last one may be empty only if something stands behind its line end.
    pub fn next(&mut self) -> Result<Option<Line<'_>>, IngestError> {
        let end = loop {
            let rest = self.buffer.get(self.at + self.searched..).unwrap_or_default();
            if let Some(found) = rest.iter().position(|b| matches!(b, b'\n' | b'\r')) {
                let end = self.at + self.searched + found;
                // CR CR LF is one line end; what follows a CR must be known.
                if self.ended || self.buffer.len() >= end + 3 || self.buffer.get(end) == Some(&b'\n') {
                    self.searched = end - self.at;
                    break Some(end);
                }
                self.searched = end - self.at;
            } else {
                self.searched = self.buffer.len() - self.at;
                if self.ended {
                    break None;
                }
            }
            if self.searched > LINE_BYTES_MAX {
                return Err(self.too_long());
            }
            self.buffer.drain(..self.at);
            self.at = 0;
            self.ended = !self.decoder.more(&mut self.buffer).map_err(|source| self.raw.failed(source))?;
            if self.ended {
                let kept = self.buffer.iter().rposition(|b| *b != 0).map_or(0, |last| last + 1);
                self.zeros += self.buffer.len() - kept;
                self.buffer.truncate(kept);
                self.searched = self.searched.min(kept);
            } else {
                self.skip_zeros()?;
            }
        };
        let start = self.at;
        if end.is_some_and(|end| end - start > LINE_BYTES_MAX) {
            return Err(self.too_long());
        }
        self.number += 1;
        self.searched = 0;
        let Some(end) = end else {
            self.at = self.buffer.len();
            let bytes = &self.buffer[start..];
            return Ok((!bytes.is_empty()).then_some(Line { bytes, number: self.number, is_ended: false }));
        };
        self.at = match self.buffer.get(end..) {
            Some([b'\r', b'\r', b'\n', ..]) => end + 3,
            Some([b'\r', b'\n', ..]) => end + 2,
            _ => end + 1,
        };
        Ok(Some(Line { bytes: &self.buffer[start..end], number: self.number, is_ended: true }))
    }

    /// Zero bytes that go on for longer than a line may be are kept as a count: a file system may leave any number of them.
    fn skip_zeros(&mut self) -> Result<(), IngestError> {
        loop {
            let kept = self.buffer.iter().rposition(|b| *b != 0).map_or(0, |last| last + 1);
            let zeros = self.buffer.len() - kept;
            if zeros <= BLOCK && self.zeros == 0 {
                return Ok(());
            }
            self.buffer.truncate(kept);
            self.searched = self.searched.min(kept.saturating_sub(self.at));
            let mut next = Vec::new();
            let more = self.decoder.more(&mut next).map_err(|source| self.raw.failed(source))?;
            self.zeros += zeros;
            if !more {
                self.ended = true;
                return Ok(());
            }
            if next.iter().any(|b| *b != 0) {
                // Something stands behind them after all: they belong to a line.
                if self.zeros > LINE_BYTES_MAX {
                    return Err(self.too_long());
                }
                self.buffer.resize(kept + self.zeros, 0);
                self.zeros = 0;
            }
            self.buffer.append(&mut next);
        }
    }

    fn too_long(&self) -> IngestError {
        IngestError::Unusable {
            place: Place::new(self.raw.name(), Some(self.number + 1), None),
            expected: format!("lines of at most {LINE_BYTES_MAX} bytes"),
            found: "a longer one".to_owned(),
            next: "is this a text log? Its line ends may be missing".to_owned(),
        }
    }

    /// What the end of the file says, after the last line: zero bytes, half a character.
    pub fn end_findings(&self, lines: &LineMap) -> Vec<Finding> {
        let mut findings = Vec::new();
        let mut tell = |text: String| {
            let line = lines.line_of(lines.rows().saturating_sub(1));
            findings.push(told(FindingKind::Truncated, Severity::Lost, self.raw.name(), lines.rows(), line, text));
        };
        if self.zeros > 0 {
            tell(zero_bytes(self.zeros as u64));
        }
        if self.decoder.half.is_some() {
            tell(HALF_CHARACTER.to_owned());
        }
        findings
    }
}

/// The first bytes of a text as UTF-8, for looking at.
pub(crate) fn decoded_head(head: &[u8]) -> Vec<u8> {
    let mut decoder = Decoder::of(Box::new(head));
    let mut out = Vec::new();
    // Reading from memory does not fail.
    while decoder.more(&mut out).unwrap_or(false) {}
    out
}

/// The lines of a head: the last one only if it is ended or `whole` says that nothing follows.
pub(crate) fn head_lines(head: &[u8], whole: bool) -> Vec<&[u8]> {
    let mut lines: Vec<&[u8]> = head.split(|b| matches!(b, b'\n' | b'\r')).collect();
    if !whole {
        lines.pop();
    }
    lines.retain(|line| !line.trim_ascii().is_empty());
    lines
}

/// Without blanks at both ends.
pub(crate) fn trim(mut bytes: &[u8]) -> &[u8] {
    while let [b' ' | b'\t', rest @ ..] | [rest @ .., b' ' | b'\t'] = bytes {
        bytes = rest;
    }
    bytes
}

/// The cells of a line, blanks and quotes taken off; with a blank as delimiter, any run of blanks and tabs parts.
pub(crate) fn cells<'b>(line: &'b [u8], delimiter: u8, out: &mut Vec<&'b [u8]>) {
    out.clear();
    let plain = |cell: &'b [u8]| {
        let cell = trim(cell);
        cell.strip_prefix(b"\"").and_then(|c| c.strip_suffix(b"\"")).unwrap_or(cell)
    };
    if delimiter == b' ' {
        let parts = line.split(|b| matches!(b, b' ' | b'\t')).filter(|cell| !cell.is_empty());
        out.extend(parts.map(plain));
    } else {
        out.extend(line.split(|b| *b == delimiter).map(plain));
        // A delimiter at the end of the line opens no cell.
        if out.len() > 1 && out.last().is_some_and(|cell| cell.is_empty()) {
            out.pop();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lines(bytes: &[u8]) -> (Vec<String>, Vec<Finding>) {
        let raw = RawFile::of_bytes("r", bytes);
        let mut lines = Lines::of(&raw).unwrap();
        let mut out = Vec::new();
        while let Some(line) = lines.next().unwrap() {
            assert_eq!(line.number, out.len() + 1);
            out.push(String::from_utf8_lossy(line.bytes).into_owned());
        }
        let findings = lines.end_findings(&LineMap::default());
        (out, findings)
    }

    #[test]
    fn line_ends_of_every_kind_are_one_each() {
        assert_eq!(lines(b"a\nb\r\nc\r\r\nd\re\n\nf").0, ["a", "b", "c", "d", "e", "", "f"]);
        assert_eq!(lines(b"").0, [""; 0]);
        assert_eq!(lines(b"a\r").0, ["a"]);
        assert_eq!(lines(b"\xef\xbb\xbfa\n").0, ["a"]);
    }

    #[test]
    fn line_ends_at_the_edges_of_blocks_are_one_each() {
        for length in BLOCK - 4..BLOCK + 4 {
            let text = format!("{}\r\r\nb\r\nc", "a".repeat(length));
            let (lines, _) = lines(text.as_bytes());
            assert_eq!((lines.len(), lines[0].len(), &lines[1..]), (3, length, &["b".to_owned(), "c".to_owned()][..]));
        }
    }

    #[test]
    fn zeros_at_the_end_are_counted_and_zeros_within_are_bytes() {
        for zeros in [1, BLOCK, 5 * BLOCK + 3, 40 * BLOCK] {
            let (lines, findings) = lines(&[b"a\nb\n".to_vec(), vec![0; zeros]].concat());
            assert_eq!(lines, ["a", "b"]);
            assert!(findings[0].text.contains(&format!("ends in {zeros} zero bytes")), "{}", findings[0].text);
        }
        let within = [b"a\n".to_vec(), vec![0; 3 * BLOCK], b"b\n".to_vec()].concat();
        let (all, findings) = lines(&within);
        assert_eq!((all.len(), all[1].len(), findings.len()), (2, 3 * BLOCK + 1, 0));
    }

    #[test]
    fn a_line_over_the_limit_is_refused() {
        let bytes = vec![b'a'; LINE_BYTES_MAX + 2];
        let raw = RawFile::of_bytes("r", &bytes);
        assert!(Lines::of(&raw).unwrap().next().is_err());
    }

    #[test]
    fn utf16_is_read_with_and_without_its_mark() {
        for low_first in [true, false] {
            for text in ["\u{feff}t=1 😀\n°=2\n", "t=1 p=2\n"] {
                let bytes: Vec<u8> = text
                    .encode_utf16()
                    .flat_map(|u| if low_first { u.to_le_bytes() } else { u.to_be_bytes() })
                    .collect();
                let expected: Vec<&str> = text.trim_start_matches('\u{feff}').lines().collect();
                assert_eq!(lines(&bytes).0, expected);
            }
        }
    }
}
