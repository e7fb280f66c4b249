//! The text of a log as it is read from front to back: encodings, zero bytes at its end, and the part of it that is in memory.
//!
//! What is decided of a line may depend on bytes behind it: a line end of three bytes, a quote that closes two lines further down, zero
//! bytes that are lost data at the end of the file and damage anywhere else. So a [`Window`] says whether the text ends with it, and
//! whoever looks beyond one that does not asks for more.

use std::io::Read;

use crate::IngestError;
use crate::limits::LINE_BYTES_MAX;
use crate::raw::RawFile;

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

impl Encoding {
    /// The encoding, given the lines that are not UTF-8.
    pub(in crate::formats) fn with(self, bad: &BadLines) -> Self {
        match self {
            Self::Utf8 | Self::Utf8Bom if bad.count > 0 => Self::Latin1,
            encoding => encoding,
        }
    }
}

/// Lines with bytes that are not the encoding: how many, and the first of them.
#[derive(Debug, Clone, Default)]
pub(in crate::formats) struct BadLines {
    pub count: usize,
    pub first: Vec<usize>,
    last: usize,
}

/// Lines with bad bytes that are listed.
const BAD_LINES_LISTED: usize = 20;

impl BadLines {
    /// Adds a line, once however often it is told; lines come in order.
    pub fn add(&mut self, line: usize) {
        if self.last == line {
            return;
        }
        self.last = line;
        self.count += 1;
        if self.first.len() < BAD_LINES_LISTED {
            self.first.push(line);
        }
    }
}

/// A part of a text.
#[derive(Debug, Clone, Copy)]
pub(in crate::formats) struct Window<'a> {
    pub bytes: &'a [u8],
    /// Whether the text ends with it.
    pub ended: bool,
}

impl<'a> Window<'a> {
    /// A text that is all there.
    pub fn whole(bytes: &'a [u8]) -> Self {
        Self { bytes, ended: true }
    }

    /// Where the line ends that goes on at `from`: at a line feed, a carriage return, the end of the text, or at `limit` if none of
    /// these comes before. `None` if it cannot be said yet.
    pub fn line_end(self, from: usize, limit: usize) -> Option<usize> {
        let seen = limit.min(self.bytes.len());
        let rest = self.bytes.get(from..seen).unwrap_or_default();
        match rest.iter().position(|b| matches!(b, b'\n' | b'\r')) {
            Some(length) => Some(from + length),
            None if limit <= self.bytes.len() => Some(limit),
            None => self.ended.then_some(self.bytes.len()),
        }
    }

    /// Where the next line begins after a line that ends at `end`: LF, CR LF, CR CR LF (written through two layers that both translate
    /// line ends) and CR each are one line end. `None` if it cannot be said yet.
    pub fn after_line_end(self, end: usize) -> Option<usize> {
        match self.bytes.get(end..) {
            None | Some([]) => self.ended.then_some(end),
            Some([b'\r', b'\r', b'\n', ..]) => Some(end + 3),
            Some([b'\r', b'\n', ..]) => Some(end + 2),
            Some([b'\r'] | [b'\r', b'\r']) => self.ended.then_some(end + 1),
            Some(_) => Some(end + 1),
        }
    }

    /// The end of the line that begins at `from`, and where the next one begins. One that is too long is cut.
    pub fn line(self, from: usize) -> Option<(usize, usize)> {
        let limit = from.saturating_add(LINE_BYTES_MAX + 1);
        let end = self.line_end(from, limit)?;
        Some((end, if end == limit { end } else { self.after_line_end(end)? }))
    }
}

/// Bytes asked of the system at once: few enough to stay in the cache until they are numbers.
pub(in crate::formats) const CHUNK: usize = 1 << 18;

/// Zero bytes in a row among the text beyond which it does not matter how many there are: no line is as long.
const ZEROS_MAX: u64 = 2 * LINE_BYTES_MAX as u64;

/// A text on its way through memory, as bytes in UTF-8, single lines in Latin-1.
pub(in crate::formats) struct Source<'a> {
    raw: &'a RawFile<'a>,
    reader: Box<dyn Read + 'a>,
    encoding: Encoding,
    wide: Option<Wide>,
    /// What is in memory is `buffer[start..end]`; behind it is room.
    buffer: Vec<u8>,
    start: usize,
    end: usize,
    /// Where `start` is in the text.
    offset: u64,
    chunk: usize,
    /// Bytes of the file that were read.
    taken: u64,
    /// Zero bytes behind the window: lost data if the file ends with them, text if it goes on.
    zeros: u64,
    ended: bool,
}

impl<'a> Source<'a> {
    /// The text of a file from its first character, read in pieces of `chunk` bytes.
    pub fn open(raw: &'a RawFile<'a>, chunk: usize) -> Result<Self, IngestError> {
        let head = raw.head(256)?;
        let wide = utf16(&head);
        let (encoding, mark) = match (wide, head.strip_prefix(b"\xef\xbb\xbf")) {
            (Some(wide), _) => (wide, if matches!(head[..], [0xff, 0xfe, ..] | [0xfe, 0xff, ..]) { 2 } else { 0 }),
            (None, Some(_)) => (Encoding::Utf8Bom, 3),
            (None, None) => (Encoding::Utf8, 0),
        };
        let mut reader = raw.reader()?;
        let mut skipped = Vec::new();
        reader.by_ref().take(mark).read_to_end(&mut skipped).map_err(|source| raw.failed(source))?;
        // No more room than the file can fill.
        let chunk = chunk.min(usize::try_from(raw.len()).map_or(chunk, |length| length + 1));
        Ok(Self {
            raw,
            reader,
            encoding,
            wide: wide.map(|encoding| Wide::new(encoding == Encoding::Utf16Be)),
            buffer: Vec::new(),
            start: 0,
            end: 0,
            offset: 0,
            chunk,
            taken: mark,
            zeros: 0,
            ended: false,
        })
    }

    /// What is in memory.
    pub fn window(&self) -> Window<'_> {
        Window { bytes: &self.buffer[self.start..self.end], ended: self.ended }
    }

    /// Where the window begins in the text.
    pub fn offset(&self) -> u64 {
        self.offset
    }

    /// The encoding, as far as the first bytes tell it.
    pub fn encoding(&self) -> Encoding {
        self.encoding
    }

    /// The first bytes of the window are done with.
    pub fn consume(&mut self, count: usize) {
        let count = count.min(self.end - self.start);
        self.start += count;
        self.offset += count as u64;
    }

    /// Reads on: afterwards the window holds at least one byte more, or the text has ended.
    pub fn fill(&mut self) -> Result<(), IngestError> {
        self.buffer.copy_within(self.start..self.end, 0);
        self.end -= self.start;
        self.start = 0;
        let before = self.end;
        while self.end == before && !self.ended {
            self.read_chunk()?;
        }
        Ok(())
    }

    /// Reads on until the window holds `count` bytes, or the text has ended.
    pub fn hold(&mut self, count: usize) -> Result<(), IngestError> {
        while self.end - self.start < count && !self.ended {
            self.fill()?;
        }
        Ok(())
    }

    /// How long the whole text will be, if its other bytes make as much text each as those read so far.
    pub fn expected_length(&self) -> u64 {
        let text = u128::from(self.offset) + (self.end - self.start) as u128 + u128::from(self.zeros);
        let expected = u128::from(self.raw.len()) * text / u128::from(self.taken.max(1));
        u64::try_from(expected).unwrap_or(u64::MAX)
    }

    /// What the end of the text tells; of use once it has ended.
    pub fn ending(self) -> Ending {
        let (half_unit, bad) = self.wide.map_or_else(Default::default, |wide| (wide.odd.is_some(), wide.bad));
        let bytes_each = if matches!(self.encoding, Encoding::Utf16Le | Encoding::Utf16Be) { 2 } else { 1 };
        Ending { encoding: self.encoding, zeros: bytes_each * self.zeros, half_unit, bad }
    }

    fn read_chunk(&mut self) -> Result<(), IngestError> {
        if let Some(wide) = &mut self.wide {
            wide.input.resize(self.chunk, 0);
            let count = read(&mut self.reader, &mut wide.input).map_err(|source| self.raw.failed(source))?;
            self.taken += count as u64;
            self.ended = count == 0;
            self.buffer.truncate(self.end);
            wide.decode(count, self.ended, &mut self.buffer);
            let added = self.buffer.len() - self.end;
            self.accept(added);
            return Ok(());
        }
        let room = self.end + self.chunk;
        if self.buffer.len() < room {
            self.buffer.resize(room, 0);
        }
        let count =
            read(&mut self.reader, &mut self.buffer[self.end..room]).map_err(|source| self.raw.failed(source))?;
        self.taken += count as u64;
        self.ended = count == 0;
        self.accept(count);
        Ok(())
    }

    /// Takes new bytes behind the window into it, but for zero bytes at their end.
    fn accept(&mut self, count: usize) {
        let new = &self.buffer[self.end..self.end + count];
        let text = new.iter().rposition(|b| *b != 0).map_or(0, |last| last + 1);
        let zeros = std::mem::replace(&mut self.zeros, (count - text) as u64);
        if text == 0 {
            self.zeros += zeros;
            return;
        }
        if let Ok(zeros @ 1..) = usize::try_from(zeros.min(ZEROS_MAX)) {
            self.buffer.splice(self.end..self.end, std::iter::repeat_n(0, zeros));
            self.end += zeros;
        }
        self.end += text;
    }
}

/// What the end of a text tells.
#[derive(Debug)]
pub(in crate::formats) struct Ending {
    pub encoding: Encoding,
    /// Zero bytes cut off at the end: what a file system leaves of a file that was being written when the power went.
    pub zeros: u64,
    /// A UTF-16 text that ends within a unit.
    pub half_unit: bool,
    /// Lines of a UTF-16 text with units that mean nothing.
    pub bad: BadLines,
}

fn read(reader: &mut dyn Read, into: &mut [u8]) -> std::io::Result<usize> {
    loop {
        match reader.read(into) {
            Err(error) if error.kind() == std::io::ErrorKind::Interrupted => {}
            done => return done,
        }
    }
}

/// UTF-16 by its mark, or by every second byte of the beginning being zero.
fn utf16(head: &[u8]) -> Option<Encoding> {
    match head {
        [0xff, 0xfe, ..] => return Some(Encoding::Utf16Le),
        [0xfe, 0xff, ..] => return Some(Encoding::Utf16Be),
        _ => {}
    }
    let (pairs, _) = head.as_chunks::<2>();
    if pairs.len() < 4 {
        return None;
    }
    let low_first = pairs.iter().all(|[a, b]| *a != 0 && *b == 0);
    let high_first = pairs.iter().all(|[a, b]| *a == 0 && *b != 0);
    low_first.then_some(Encoding::Utf16Le).or(high_first.then_some(Encoding::Utf16Be))
}

/// UTF-16 on its way to UTF-8.
#[derive(Debug, Default)]
struct Wide {
    high_first: bool,
    input: Vec<u8>,
    /// Half a unit.
    odd: Option<u8>,
    /// Half a character.
    surrogate: Option<u16>,
    units: Vec<u16>,
    /// Line ends so far, and carriage returns in a row that are not counted yet.
    line_ends: usize,
    returns: usize,
    bad: BadLines,
}

impl Wide {
    fn new(high_first: bool) -> Self {
        Self { high_first, ..Self::default() }
    }

    /// Decodes the first bytes of the input, whatever they are cut through.
    fn decode(&mut self, count: usize, ended: bool, out: &mut Vec<u8>) {
        let unit = |pair: [u8; 2]| if self.high_first { u16::from_be_bytes(pair) } else { u16::from_le_bytes(pair) };
        let mut bytes = &self.input[..count];
        self.units.clear();
        self.units.extend(self.surrogate.take());
        if let (Some(first), [second, rest @ ..]) = (self.odd, bytes) {
            self.units.push(unit([first, *second]));
            self.odd = None;
            bytes = rest;
        }
        let (pairs, rest) = bytes.as_chunks::<2>();
        self.units.extend(pairs.iter().map(|pair| unit(*pair)));
        self.odd = rest.first().copied().or(self.odd);
        if !ended {
            self.surrogate = self.units.pop_if(|unit| (0xd800..0xdc00).contains(unit));
        }
        for c in char::decode_utf16(self.units.iter().copied()) {
            let c = c.unwrap_or_else(|_| {
                self.bad.add(1 + self.line_ends + self.returns);
                char::REPLACEMENT_CHARACTER
            });
            match c {
                // CR CR LF is one line end, CR CR CR are three.
                '\r' if self.returns == 2 => self.line_ends += 1,
                '\r' => self.returns += 1,
                '\n' => {
                    self.line_ends += 1;
                    self.returns = 0;
                }
                _ => self.line_ends += std::mem::take(&mut self.returns),
            }
            match u8::try_from(c) {
                Ok(byte) if byte.is_ascii() => out.push(byte),
                _ => out.extend_from_slice(c.encode_utf8(&mut [0; 4]).as_bytes()),
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn text(bytes: &[u8], chunk: usize) -> (Vec<u8>, Ending) {
        let raw = RawFile::of_bytes("r", bytes);
        let mut source = Source::open(&raw, chunk).unwrap();
        let mut text = Vec::new();
        while !source.window().ended {
            text.extend_from_slice(source.window().bytes);
            source.consume(source.window().bytes.len());
            source.fill().unwrap();
        }
        text.extend_from_slice(source.window().bytes);
        (text, source.ending())
    }

    #[test]
    fn utf16_is_known_with_and_without_its_mark_whatever_it_is_cut_through() {
        let units = |text: &str, le: bool| -> Vec<u8> {
            text.encode_utf16().flat_map(|u| if le { u.to_le_bytes() } else { u.to_be_bytes() }).collect()
        };
        let with_mark = "\u{feff}a;°😀\r\r\n1;2\n";
        for (bytes, encoding) in
            [(units(with_mark, true), Encoding::Utf16Le), (units(with_mark, false), Encoding::Utf16Be)]
        {
            for chunk in 1..=bytes.len() {
                let (text, ending) = text(&bytes, chunk);
                assert_eq!(String::from_utf8(text).unwrap(), "a;°😀\r\r\n1;2\n");
                assert_eq!((ending.encoding, ending.half_unit, ending.bad.count), (encoding, false, 0));
            }
        }
        assert_eq!(text(&units("time;p\n", true), 3).1.encoding, Encoding::Utf16Le);
        let mut cut = units("time;p\n", false);
        cut.pop();
        assert!(text(&cut, 2).1.half_unit);
        // A half of a character alone, on the third line, twice.
        let mut bad = units("\u{feff}t\r\r\n\r1", true);
        bad.extend([0x00, 0xd8, 0x31, 0x00, 0x00, 0xd8]);
        for chunk in 1..=bad.len() {
            let (text, ending) = text(&bad, chunk);
            assert_eq!(String::from_utf8(text).unwrap(), "t\r\r\n\r1\u{fffd}1\u{fffd}");
            assert_eq!((ending.bad.count, ending.bad.first), (1, vec![3]));
        }
    }

    #[test]
    fn zero_bytes_are_cut_off_at_the_end_only() {
        for chunk in 1..=12 {
            let (text, ending) = text(b"\x00\x00a\x00b\x00\x00c\x00\x00\x00\x00", chunk);
            assert_eq!((text.as_slice(), ending.zeros), (&b"\x00\x00a\x00b\x00\x00c"[..], 4), "{chunk}");
        }
        assert_eq!(text(b"\xff\xfe1\0\0\0\0\0", 3).1.zeros, 4);
    }
}
