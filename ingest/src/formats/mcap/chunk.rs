//! The records of a chunk: decompressed into a buffer that is used again, and checked before any of them counts.

use std::io::Read as _;

use super::fields::{self, Fields};
use crate::limits::MCAP_CHUNK_BYTES_MAX;

/// Buffers that serve all chunks of a file.
#[derive(Default)]
pub(super) struct Inflate {
    zstd: Option<zstd::bulk::Decompressor<'static>>,
    out: Vec<u8>,
}

/// A chunk that can be used.
pub(super) struct Open<'a> {
    pub records: &'a [u8],
    /// Whether a CRC vouches for it.
    pub checked: bool,
}

impl Inflate {
    /// The records of a chunk, or why they cannot be had.
    pub fn open<'a>(&'a mut self, chunk: &fields::Chunk<'a>) -> Result<Open<'a>, String> {
        let size = chunk.uncompressed_size;
        let within = usize::try_from(size).ok().filter(|_| size <= MCAP_CHUNK_BYTES_MAX);
        let length = within
            .ok_or_else(|| format!("states {size} bytes, at most {MCAP_CHUNK_BYTES_MAX} are read of one chunk"))?;
        let records: &[u8] = match chunk.compression {
            b"" => chunk.data,
            b"zstd" => self.zstd(chunk.data, length)?,
            b"lz4" => self.lz4(chunk.data, length)?,
            other => {
                let name = crate::error::shown(&String::from_utf8_lossy(other));
                return Err(format!("is compressed by {name}; zstd, lz4 and none are read"));
            }
        };
        if records.len() != length {
            return Err(format!("holds {} bytes where it states {size}", records.len()));
        }
        if chunk.crc == 0 {
            return Ok(Open { records, checked: false });
        }
        let calculated = crc32fast::hash(records);
        if calculated != chunk.crc {
            return Err(format!("does not match its checksum ({calculated:08x}, stated is {:08x})", chunk.crc));
        }
        Ok(Open { records, checked: true })
    }

    fn zstd(&mut self, data: &[u8], length: usize) -> Result<&[u8], String> {
        let failed = |error: std::io::Error| format!("does not decompress ({error})");
        let decompressor = match &mut self.zstd {
            Some(decompressor) => decompressor,
            none => none.insert(zstd::bulk::Decompressor::new().map_err(failed)?),
        };
        self.out.clear();
        // A frame that says how long it is may spare the memory for what a damaged record states.
        let said = zstd::zstd_safe::get_frame_content_size(data).ok().flatten();
        if said.is_some_and(|said| said > length as u64) {
            return Err(format!("does not decompress to the {length} bytes it states"));
        }
        self.out.reserve(length);
        decompressor.decompress_to_buffer(data, &mut self.out).map_err(failed)?;
        Ok(&self.out)
    }

    fn lz4(&mut self, data: &[u8], length: usize) -> Result<&[u8], String> {
        let failed = |error: std::io::Error| format!("does not decompress ({error})");
        self.out.clear();
        let decoder = lz4::Decoder::new(data).map_err(failed)?;
        // One byte more than stated is enough to see that it is too long.
        decoder.take(length as u64 + 1).read_to_end(&mut self.out).map_err(failed)?;
        Ok(&self.out)
    }
}

/// The records of an open chunk: opcode, where it stands in the chunk, body.
pub(super) struct Records<'a> {
    fields: Fields<'a>,
    length: usize,
}

/// The records of a chunk go on beyond its end.
pub(super) struct Overrun {
    pub offset: usize,
}

impl<'a> Records<'a> {
    pub fn new(records: &'a [u8]) -> Self {
        Self { fields: Fields(records), length: records.len() }
    }
}

impl<'a> Iterator for Records<'a> {
    type Item = Result<(u8, usize, &'a [u8]), Overrun>;

    #[inline]
    fn next(&mut self) -> Option<Self::Item> {
        if self.fields.0.is_empty() {
            return None;
        }
        let offset = self.length - self.fields.0.len();
        let record = (|| {
            let [opcode] = self.fields.array()?;
            let length = usize::try_from(self.fields.u64()?).ok()?;
            Some((opcode, offset, self.fields.bytes(length)?))
        })();
        if record.is_none() {
            self.fields.0 = &[];
        }
        Some(record.ok_or(Overrun { offset }))
    }
}
