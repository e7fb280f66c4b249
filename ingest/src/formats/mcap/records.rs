//! Every record of a file, one after the other, those in chunks too.

use ::mcap::records::{Record, op};

use super::chunk::{Inflate, Records};
use super::fields;
use super::scan::{FRAME_BYTES, Scan, Seen, Step};
use crate::IngestError;
use crate::raw::RawFile;

/// A record where it stands.
#[derive(Debug, Clone, Copy)]
pub struct RecordAt<'a> {
    /// Its kind.
    pub opcode: u8,
    /// Byte at which it begins: in the file, or in the decompressed bytes of its chunk.
    pub offset: u64,
    /// Bytes in all, opcode and length included.
    pub length: u64,
    /// Byte at which its chunk begins, if it stands in one.
    pub chunk: Option<u64>,
    /// What it holds; of an attachment only the first bytes if it is large, never its checksum; nothing of a record beyond the limits.
    pub body: &'a [u8],
}

impl<'a> RecordAt<'a> {
    /// Its fields. `None` if it is not what such a record holds, and for attachments, which may be larger than memory.
    pub fn parse(&self) -> Option<Record<'a>> {
        if self.opcode == op::ATTACHMENT { None } else { fields::parse(self.opcode, self.body) }
    }
}

/// Hands out every record of a file as far as it goes; after a chunk its records, if it can be used. Nothing is decoded.
///
/// # Errors
/// [`IngestError::Unusable`] if it is no MCAP file, [`IngestError::Read`] if it cannot be read, and those of `visit`.
pub fn records(raw: &RawFile, visit: &mut dyn FnMut(RecordAt) -> Result<(), IngestError>) -> Result<(), IngestError> {
    let Some(mut scan) = Scan::new(raw)? else { return Err(super::no_magic(raw)) };
    let (mut body, mut inflate) = (Vec::new(), Inflate::default());
    while let Step::Record(framed) = scan.next(&mut body)? {
        let (opcode, offset, length) = (framed.opcode, framed.offset, framed.length + FRAME_BYTES);
        let body = if matches!(framed.seen, Seen::TooLong { .. }) { &[] } else { &body[..] };
        visit(RecordAt { opcode, offset, length, chunk: None, body })?;
        if opcode != op::CHUNK {
            continue;
        }
        let Some(chunk) = fields::chunk(body) else { continue };
        let Ok(open) = inflate.open(&chunk) else { continue };
        for (opcode, at, body) in Records::new(open.records).flatten() {
            let length = body.len() as u64 + FRAME_BYTES;
            visit(RecordAt { opcode, offset: at as u64, length, chunk: Some(offset), body })?;
        }
    }
    Ok(())
}
