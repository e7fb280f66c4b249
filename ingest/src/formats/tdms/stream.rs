//! The bytes of a file from front to back, as many at once as are asked for.

use std::io::{ErrorKind, Read};

use crate::IngestError;
use crate::raw::RawFile;

/// Bytes asked of the system at once: few enough to stay in the cache until they are numbers.
const CHUNK: usize = 1 << 18;

/// A file on its way through memory.
pub(super) struct Stream<'a> {
    raw: &'a RawFile<'a>,
    reader: Box<dyn Read + 'a>,
    /// What is in memory is `buffer[start..end]`.
    buffer: Vec<u8>,
    start: usize,
    end: usize,
    offset: u64,
    ended: bool,
}

impl<'a> Stream<'a> {
    pub fn open(raw: &'a RawFile<'a>) -> Result<Self, IngestError> {
        Ok(Self { raw, reader: raw.reader()?, buffer: Vec::new(), start: 0, end: 0, offset: 0, ended: false })
    }

    /// Where the next byte stands in the file.
    pub fn offset(&self) -> u64 {
        self.offset
    }

    /// What is in memory: at least `count` bytes, or all that are left. Whoever states `count` has limited it.
    #[inline]
    pub fn at_least(&mut self, count: usize) -> Result<&[u8], IngestError> {
        if self.end - self.start < count && !self.ended {
            self.fill(count)?;
        }
        Ok(self.buffer.get(self.start..self.end).unwrap_or_default())
    }

    /// The first bytes in memory are done with.
    #[inline]
    pub fn consume(&mut self, count: usize) {
        let count = count.min(self.end - self.start);
        self.start += count;
        self.offset += count as u64;
    }

    /// Goes past bytes; how many were there.
    pub fn skip(&mut self, count: u64) -> Result<u64, IngestError> {
        let mut left = count;
        while left > 0 {
            let held = self.at_least(1)?.len();
            if held == 0 {
                break;
            }
            let step = usize::try_from(left).map_or(held, |left| left.min(held));
            self.consume(step);
            left -= step as u64;
        }
        Ok(count - left)
    }

    #[cold]
    fn fill(&mut self, count: usize) -> Result<(), IngestError> {
        self.buffer.copy_within(self.start..self.end, 0);
        self.end -= self.start;
        self.start = 0;
        // No more room than the file can fill.
        let chunk = usize::try_from(self.raw.len()).map_or(CHUNK, |length| CHUNK.min(length + 1));
        while self.end < count && !self.ended {
            let room = self.end + chunk;
            if self.buffer.len() < room {
                self.buffer.resize(room, 0);
            }
            match self.reader.read(self.buffer.get_mut(self.end..room).unwrap_or_default()) {
                Ok(0) => self.ended = true,
                Ok(count) => self.end += count,
                Err(error) if error.kind() == ErrorKind::Interrupted => {}
                Err(error) => return Err(self.raw.failed(error)),
            }
        }
        Ok(())
    }
}
