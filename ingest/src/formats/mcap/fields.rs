//! The fields of a record, with every stated length held against the bytes that are there.

use ::mcap::records::{Record, op};

/// Bytes from which fields are taken, front to back.
#[derive(Debug, Clone, Copy)]
pub(super) struct Fields<'a>(pub &'a [u8]);

impl<'a> Fields<'a> {
    pub fn bytes(&mut self, count: usize) -> Option<&'a [u8]> {
        let (taken, rest) = self.0.split_at_checked(count)?;
        self.0 = rest;
        Some(taken)
    }

    pub fn array<const N: usize>(&mut self) -> Option<[u8; N]> {
        let (taken, rest) = self.0.split_first_chunk()?;
        self.0 = rest;
        Some(*taken)
    }

    pub fn u16(&mut self) -> Option<u16> {
        self.array().map(u16::from_le_bytes)
    }

    pub fn u32(&mut self) -> Option<u32> {
        self.array().map(u32::from_le_bytes)
    }

    pub fn u64(&mut self) -> Option<u64> {
        self.array().map(u64::from_le_bytes)
    }

    /// Bytes after their length: a string, a map.
    pub fn counted(&mut self) -> Option<&'a [u8]> {
        let count = self.u32()?;
        self.bytes(count as usize)
    }
}

/// A message before its data.
#[derive(Debug, Clone, Copy)]
pub(super) struct MessageHead {
    pub channel: u16,
    pub log_time: u64,
    pub publish_time: u64,
}

/// A message and its data; parsed here because it happens millions of times.
#[inline]
pub(super) fn message(body: &[u8]) -> Option<(MessageHead, &[u8])> {
    let (head, data) = body.split_first_chunk::<22>()?;
    let mut fields = Fields(head);
    let channel = fields.u16()?;
    fields.u32()?;
    Some((MessageHead { channel, log_time: fields.u64()?, publish_time: fields.u64()? }, data))
}

/// A chunk before its records, and those.
pub(super) struct Chunk<'a> {
    pub start_time: u64,
    pub end_time: u64,
    pub uncompressed_size: u64,
    pub crc: u32,
    pub compression: &'a [u8],
    pub data: &'a [u8],
}

pub(super) fn chunk(body: &[u8]) -> Option<Chunk<'_>> {
    let mut fields = Fields(body);
    let (start_time, end_time, uncompressed_size) = (fields.u64()?, fields.u64()?, fields.u64()?);
    let (crc, compression) = (fields.u32()?, fields.counted()?);
    let size = fields.u64()?;
    let data = fields.bytes(usize::try_from(size).ok()?)?;
    Some(Chunk { start_time, end_time, uncompressed_size, crc, compression, data })
}

/// The name, media type and number of bytes of an attachment whose body begins so.
pub(super) fn attachment(body: &[u8]) -> Option<(String, String, u64)> {
    let mut fields = Fields(body);
    fields.u64()?;
    fields.u64()?;
    let mut text = || fields.counted().map(|bytes| String::from_utf8_lossy(bytes).into_owned());
    Some((text()?, text()?, fields.u64()?))
}

/// A record by its opcode. `None` if its body is not what such a record holds.
///
/// The crate asks for the memory of a string before it looks whether so many bytes are there; so that is looked at first.
pub(super) fn parse(opcode: u8, body: &[u8]) -> Option<Record<'_>> {
    let mut fields = Fields(body);
    let mut counted = |before: usize, counts: usize| {
        fields.bytes(before)?;
        (0..counts).try_for_each(|_| fields.counted().map(drop))
    };
    match opcode {
        op::HEADER => counted(0, 2),
        op::SCHEMA => counted(2, 3),
        op::CHANNEL => {
            counted(4, 2)?;
            map(fields.counted()?)
        }
        op::CHUNK => counted(28, 1),
        op::ATTACHMENT => counted(16, 2),
        op::METADATA => {
            counted(0, 1)?;
            map(fields.counted()?)
        }
        op::ATTACHMENT_INDEX => counted(40, 2),
        op::METADATA_INDEX => counted(16, 1),
        op::CHUNK_INDEX => {
            counted(32, 1)?;
            counted(8, 1)
        }
        _ => Some(()),
    }?;
    ::mcap::parse_record(opcode, body).ok()
}

/// Whether the strings of a map are all there.
fn map(bytes: &[u8]) -> Option<()> {
    let mut fields = Fields(bytes);
    while !fields.0.is_empty() {
        fields.counted()?;
        fields.counted()?;
    }
    Some(())
}
