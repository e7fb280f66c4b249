//! From bytes to framed records: an opcode, a length, a body; and where a cut file ends.
//!
//! The file is read once from front to back. The CRCs of the data section and of the summary run along, because they cover
//! everything that passes here.

use std::io::{BufReader, Read};

use ::mcap::records::op;
use crc32fast::Hasher;

use crate::IngestError;
use crate::limits::{MCAP_RECORD_BYTES_MAX, MCAP_SCHEMA_BYTES_MAX};
use crate::raw::RawFile;

/// First and last bytes of every file.
pub(super) const MAGIC: &[u8] = ::mcap::MAGIC;

/// Opcode and length.
pub(super) const FRAME_BYTES: u64 = 9;

const FRAME: usize = 9;

/// Bytes of an attachment that are looked at; the rest passes by.
const ATTACHMENT_HEAD: u64 = 1 << 20;

/// Bytes that pass by at once.
const BLOCK: usize = 1 << 16;

/// A record of which the body has been read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Framed {
    pub opcode: u8,
    /// Where its opcode stands.
    pub offset: u64,
    /// Bytes of its body, as stated.
    pub length: u64,
    /// What is known once the whole record has passed.
    pub seen: Seen,
}

/// What the scan knows of a record beyond its body.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Seen {
    /// The whole body.
    Body,
    /// A body beyond the limit of its kind went by unread.
    TooLong { limit: u64 },
    /// The beginning of an attachment's body; the CRC of all but its last four bytes, and those.
    Attachment { calculated: u32, stated: u32 },
    /// The CRC of everything before the record, or in the case of a footer of the summary and of itself.
    Section { calculated: u32 },
}

/// How a file ends.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct End {
    /// After the last whole record.
    pub good: u64,
    pub how: How,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum How {
    /// As it should.
    Whole,
    /// As it should, and then more bytes follow.
    Trailing,
    /// Between two records, or within the frame of one.
    NoFooter,
    /// A record states more bytes than there are.
    InRecord { opcode: u8, length: u64 },
    /// No record begins with this byte.
    NoRecord,
    /// A footer, but the closing magic is cut or another.
    NoMagic,
}

#[derive(Debug)]
pub(super) enum Step {
    Record(Framed),
    End(End),
}

pub(super) struct Scan<'a> {
    raw: &'a RawFile<'a>,
    reader: BufReader<Box<dyn Read + 'a>>,
    /// Of the next record.
    offset: u64,
    section: Hasher,
    footer: bool,
    ended: Option<End>,
}

/// Bytes of a body that are kept, by the kind of record.
fn limit(opcode: u8) -> u64 {
    match opcode {
        op::SCHEMA => MCAP_SCHEMA_BYTES_MAX,
        _ => MCAP_RECORD_BYTES_MAX,
    }
}

impl<'a> Scan<'a> {
    /// At the first record of a file.
    ///
    /// `None` if the magic is not there.
    pub fn new(raw: &'a RawFile<'a>) -> Result<Option<Self>, IngestError> {
        let reader = BufReader::with_capacity(1 << 18, raw.reader()?);
        let mut scan = Self { raw, reader, offset: 0, section: Hasher::new(), footer: false, ended: None };
        let mut magic = [0; 8];
        let whole = scan.exactly(&mut magic)? == MAGIC.len() && magic == *MAGIC;
        scan.section.update(&magic);
        scan.offset = MAGIC.len() as u64;
        Ok(whole.then_some(scan))
    }

    /// The next record, its body in `body`.
    pub fn next(&mut self, body: &mut Vec<u8>) -> Result<Step, IngestError> {
        if let Some(end) = self.ended {
            return Ok(Step::End(end));
        }
        if self.footer {
            let mut magic = [0; 8];
            let whole = self.exactly(&mut magic)? == MAGIC.len() && magic == *MAGIC;
            let how = match self.raw.len().checked_sub(self.offset + MAGIC.len() as u64) {
                Some(0) if whole => How::Whole,
                Some(_) if whole => How::Trailing,
                _ => How::NoMagic,
            };
            return Ok(self.end(how));
        }
        let mut head = [0; FRAME];
        if self.exactly(&mut head)? < head.len() {
            return Ok(self.end(How::NoFooter));
        }
        let [opcode, length @ ..] = head;
        let length = u64::from_le_bytes(length);
        if opcode == 0 {
            return Ok(self.end(How::NoRecord));
        }
        // Not asked of the end of the file alone, which comes late where gigabytes are stated.
        let left = self.raw.len().saturating_sub(self.offset + FRAME_BYTES);
        if length > left {
            return Ok(self.end(How::InRecord { opcode, length }));
        }
        let offset = self.offset;
        let before = (opcode == op::DATA_END).then(|| self.section.clone().finalize());
        self.section.update(&head);
        let limit = limit(opcode);
        let seen = match opcode {
            op::ATTACHMENT => self.attachment(length, body)?,
            _ if length <= limit => self.take(length, body)?.then_some(Seen::Body),
            _ => self.pass(length, &mut Hasher::new())?.then_some(Seen::TooLong { limit }),
        };
        let Some(mut seen) = seen else { return Ok(self.end(How::InRecord { opcode, length })) };
        if let (Some(calculated), Seen::Body) = (before, seen) {
            seen = Seen::Section { calculated };
            self.section = Hasher::new();
        } else if opcode == op::FOOTER && seen == Seen::Body {
            // It covers itself but for its own four bytes.
            self.section.update(body.get(..16).unwrap_or(&[]));
            seen = Seen::Section { calculated: self.section.clone().finalize() };
            self.footer = true;
        } else if seen == Seen::Body {
            self.section.update(body);
        }
        self.offset += FRAME_BYTES + length;
        Ok(Step::Record(Framed { opcode, offset, length, seen }))
    }

    fn end(&mut self, how: How) -> Step {
        let end = End { good: self.offset, how };
        self.ended = Some(end);
        Step::End(end)
    }

    /// Fills `out` as far as the file goes.
    fn exactly(&mut self, out: &mut [u8]) -> Result<usize, IngestError> {
        let mut filled = 0;
        while filled < out.len() {
            match self.reader.read(&mut out[filled..]) {
                Ok(0) => break,
                Ok(count) => filled += count,
                Err(error) if error.kind() == std::io::ErrorKind::Interrupted => {}
                Err(error) => return Err(self.raw.failed(error)),
            }
        }
        Ok(filled)
    }

    /// Reads a body; false if the file ends before.
    fn take(&mut self, length: u64, body: &mut Vec<u8>) -> Result<bool, IngestError> {
        // Not more than is left of the file, hence not more than anybody wrote.
        let Ok(length) = usize::try_from(length) else { return Ok(false) };
        body.resize(length, 0);
        Ok(self.exactly(body)? == length)
    }

    /// Lets bytes pass by, into the CRC of the section and another.
    fn pass(&mut self, mut length: u64, crc: &mut Hasher) -> Result<bool, IngestError> {
        let mut block = vec![0; BLOCK];
        while length > 0 {
            let count = usize::try_from(length).map_or(BLOCK, |length| length.min(BLOCK));
            if self.exactly(&mut block[..count])? < count {
                return Ok(false);
            }
            self.section.update(&block[..count]);
            crc.update(&block[..count]);
            length -= count as u64;
        }
        Ok(true)
    }

    /// An attachment may be a whole film.
    fn attachment(&mut self, length: u64, body: &mut Vec<u8>) -> Result<Option<Seen>, IngestError> {
        let Some(covered) = length.checked_sub(4) else {
            let whole = self.take(length, body)?;
            self.section.update(body);
            return Ok(whole.then_some(Seen::Attachment { calculated: 0, stated: u32::MAX }));
        };
        if !self.take(covered.min(ATTACHMENT_HEAD), body)? {
            return Ok(None);
        }
        self.section.update(body);
        let mut crc = Hasher::new();
        crc.update(body);
        let mut stated = [0; 4];
        if !self.pass(covered - body.len() as u64, &mut crc)? || self.exactly(&mut stated)? < stated.len() {
            return Ok(None);
        }
        self.section.update(&stated);
        Ok(Some(Seen::Attachment { calculated: crc.finalize(), stated: u32::from_le_bytes(stated) }))
    }
}
