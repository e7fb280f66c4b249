//! Taking the values of a segment out of its bytes, whole ones only.

use super::channel::{Channel, Shared};
use super::layout::{Layout, Piece, RawBuffer};
use super::stream::Stream;
use super::tell::Tell;
use super::types::{DataType, Values};
use super::unusable;
use crate::IngestError;
use crate::limits::LOG_CELLS_MAX;
use crate::raw::RawFile;
use crate::recording::full_name;

/// Bytes that become numbers at once: few enough to stay in the nearest cache until they are looked at.
const STEP: usize = 1 << 14;

/// Where values go.
pub(super) struct Sink {
    pub channels: Vec<Channel>,
    pub shared: Shared,
    /// Cells so far, and those in memory.
    cells: u64,
    kept: u64,
    /// Lines of a digital port make up to eight cells of a byte; many more than that are damage.
    cells_max: u64,
    /// Parts of segments that were looked at so far.
    parts: u64,
}

/// Taking the values of a segment.
pub(super) struct Task<'t, 'a> {
    pub raw: &'t RawFile<'a>,
    pub layout: &'t Layout,
    pub stream: &'t mut Stream<'a>,
    pub sink: &'t mut Sink,
    pub tell: &'t mut Tell,
}

impl Task<'_, '_> {
    /// A chunk of values channel after channel, or its first bytes: whole values are taken.
    pub fn chunk(&mut self, mut bytes: u64) -> Result<(), IngestError> {
        for piece in &self.layout.pieces {
            self.state(piece.channel, piece.count);
            let there = piece.bytes.min(bytes);
            bytes -= there;
            self.piece(piece, piece.count, there)?;
        }
        Ok(())
    }

    /// A last chunk that the segment states to be shorter than the others, each channel having fewer values; or its first bytes.
    pub fn short_chunk(&mut self, stated: u64, mut bytes: u64) -> Result<(), IngestError> {
        let is_whole = bytes == stated;
        if self.layout.pieces.iter().any(|piece| piece.data_type == DataType::Text) {
            // How many texts would be its share nobody knows: channel after channel as far as it goes.
            self.chunk(bytes)?;
            for piece in self.layout.pieces.iter().filter(|_| is_whole) {
                if let Some(channel) = self.sink.channels.get_mut(piece.channel) {
                    channel.stated = channel.values;
                }
            }
            return Ok(());
        }
        for piece in &self.layout.pieces {
            let share = u128::from(piece.count) * u128::from(stated) / u128::from(self.layout.chunk_bytes);
            let count = u64::try_from(share).unwrap_or(0);
            self.state(piece.channel, count);
            let there = bytes.min(count * piece.data_type.width().unwrap_or(0) as u64);
            bytes -= there;
            self.piece(piece, count, there)?;
        }
        Ok(())
    }

    /// The values of a channel in a chunk: `count` of them in so many bytes, or fewer.
    fn piece(&mut self, piece: &Piece, count: u64, bytes: u64) -> Result<(), IngestError> {
        let Some(width) = piece.data_type.width() else { return self.texts(piece, count, bytes) };
        if width == 0 {
            return Ok(());
        }
        let whole = bytes / width as u64;
        self.sink.add(self.raw, piece.channel, whole)?;
        let Some(channel) = self.sink.channels.get_mut(piece.channel) else { return Ok(()) };
        if channel.is_read() {
            let mut left = whole;
            while left > 0 {
                let window = self.stream.at_least(width)?;
                let fit = (window.len().min(STEP) / width).min(usize::try_from(left).unwrap_or(usize::MAX));
                let Some(bytes) = window.get(..fit * width).filter(|bytes| !bytes.is_empty()) else { break };
                let values = Values { bytes, stride: width, offset: 0, big_endian: self.layout.big_endian };
                channel.push(values, piece.data_type, &mut self.sink.shared);
                self.stream.consume(fit * width);
                left -= fit as u64;
            }
            channel.values += whole - left;
            self.stream.skip(bytes - whole * width as u64)?;
        } else {
            channel.values += whole;
            self.stream.skip(bytes)?;
        }
        Ok(())
    }

    /// Texts of a channel: where each ends, then all of them.
    fn texts(&mut self, piece: &Piece, count: u64, bytes: u64) -> Result<(), IngestError> {
        // Checked to be at most what is read of texts.
        let length = usize::try_from(bytes).unwrap_or(usize::MAX);
        let window = self.stream.at_least(length)?;
        let all = window.get(..length).unwrap_or(window);
        let stated = usize::try_from(count).unwrap_or(usize::MAX);
        let (ends, texts) = all.split_at_checked(stated.saturating_mul(4)).unwrap_or((all, &[]));
        // Of a chunk that is cut as many as there are ends, however many are stated.
        let count = stated.min(ends.len() / 4);
        self.sink.add(self.raw, piece.channel, count as u64)?;
        let Some(channel) = self.sink.channels.get_mut(piece.channel) else { return Ok(()) };
        let mut start = 0;
        let mut whole = 0;
        let mut is_damaged = false;
        for end in ends.as_chunks::<4>().0 {
            let end = if self.layout.big_endian { u32::from_be_bytes(*end) } else { u32::from_le_bytes(*end) };
            let Some(text) = texts.get(start..end as usize) else {
                is_damaged = (end as usize) < start || bytes == piece.bytes;
                break;
            };
            channel.push_text(text);
            start = end as usize;
            whole += 1;
        }
        let length = all.len();
        if is_damaged {
            self.tell.bad_texts(&full_name(&channel.group, &channel.name), count - whole);
            // They keep their places: what follows must not move.
            for _ in whole..count {
                channel.push_text(b"");
            }
            whole = count;
        }
        channel.values += whole as u64;
        self.stream.consume(length);
        Ok(())
    }

    /// Rows with a value of each channel.
    pub fn rows(&mut self, rows: u64, width: u64) -> Result<(), IngestError> {
        let stride = usize::try_from(width).unwrap_or(usize::MAX);
        let mut left = rows;
        while left > 0 {
            let window = self.stream.at_least(stride)?;
            let fit = (window.len().min(STEP.max(stride)) / stride).min(usize::try_from(left).unwrap_or(usize::MAX));
            let Some(bytes) = window.get(..fit * stride).filter(|bytes| !bytes.is_empty()) else { break };
            // Counted before they are taken: many channels of few bytes must not fill the memory.
            for piece in &self.layout.pieces {
                self.sink.add(self.raw, piece.channel, fit as u64)?;
            }
            let mut offset = 0;
            for piece in &self.layout.pieces {
                let Some(channel) = self.sink.channels.get_mut(piece.channel) else { continue };
                let values = Values { bytes, stride, offset, big_endian: self.layout.big_endian };
                channel.push(values, piece.data_type, &mut self.sink.shared);
                channel.values += fit as u64;
                channel.stated = channel.stated.saturating_add(fit as u64);
                offset += piece.data_type.width().unwrap_or(0);
            }
            self.stream.consume(fit * stride);
            left -= fit as u64;
        }
        Ok(())
    }

    /// A chunk of DAQ cards.
    pub fn daqmx(&mut self, buffers: &[RawBuffer]) -> Result<(), IngestError> {
        for piece in &self.layout.pieces {
            self.state(piece.channel, piece.count);
        }
        for buffer in buffers {
            self.buffer(buffer, buffer.rows, |_| u64::MAX)?;
        }
        for piece in &self.layout.pieces {
            self.count(piece.channel, piece.count);
        }
        Ok(())
    }

    /// The first bytes of a chunk of DAQ cards. Of every channel as many values are taken as there are of all its scalers: what is over
    /// would meet values of the next segment.
    pub fn short_daqmx(&mut self, buffers: &[RawBuffer], mut bytes: u64, is_whole: bool) -> Result<(), IngestError> {
        let mut rows = Vec::with_capacity(buffers.len());
        let mut values: Vec<u64> = self.layout.pieces.iter().map(|piece| piece.count).collect();
        for buffer in buffers {
            let there = buffer.rows.min(bytes / buffer.width.max(1));
            // No more than one row is cut, and nothing stands behind it.
            bytes = if there < buffer.rows { 0 } else { bytes - there * buffer.width };
            rows.push(there);
            for tap in &buffer.taps {
                if let Some(values) = values.get_mut(tap.piece) {
                    *values = there.min(*values);
                }
            }
        }
        for (piece, values) in self.layout.pieces.iter().zip(&values) {
            self.state(piece.channel, if is_whole { *values } else { piece.count });
        }
        for (buffer, rows) in buffers.iter().zip(rows) {
            self.buffer(buffer, rows, |piece| values.get(piece).copied().unwrap_or(0))?;
        }
        for (piece, values) in self.layout.pieces.iter().zip(&values) {
            self.count(piece.channel, *values);
        }
        Ok(())
    }

    /// Rows of a raw buffer; of each channel, by its place among the pieces, at most so many values.
    fn buffer(&mut self, buffer: &RawBuffer, rows: u64, most: impl Fn(usize) -> u64) -> Result<(), IngestError> {
        let stride = usize::try_from(buffer.width).unwrap_or(usize::MAX);
        let mut done = 0;
        while done < rows {
            let window = self.stream.at_least(stride)?;
            let left = usize::try_from(rows - done).unwrap_or(usize::MAX);
            let fit = (window.len().min(STEP.max(stride)) / stride).min(left);
            let Some(bytes) = window.get(..fit * stride).filter(|bytes| !bytes.is_empty()) else { break };
            // Counted before they are taken: many channels on the same bytes must not fill the memory.
            for tap in buffer.taps.iter().filter(|tap| tap.scaler == 0) {
                self.sink.add(self.raw, tap.channel, fit as u64)?;
            }
            for tap in &buffer.taps {
                let Some(channel) = self.sink.channels.get_mut(tap.channel) else { continue };
                let wanted = usize::try_from(most(tap.piece).saturating_sub(done)).unwrap_or(usize::MAX).min(fit);
                let Some(bytes) = bytes.get(..wanted * stride) else { continue };
                let values = Values { bytes, stride, offset: tap.offset, big_endian: self.layout.big_endian };
                channel.push_scaler(values, tap.scaler, tap.bit, tap.data_type, &mut self.sink.shared);
            }
            self.stream.consume(fit * stride);
            done += fit as u64;
        }
        Ok(())
    }

    /// So many values of a channel are stated.
    fn state(&mut self, channel: usize, count: u64) {
        if let Some(channel) = self.sink.channels.get_mut(channel) {
            channel.stated = channel.stated.saturating_add(count);
        }
    }

    /// So many values of a channel are there.
    fn count(&mut self, channel: usize, count: u64) {
        if let Some(channel) = self.sink.channels.get_mut(channel) {
            channel.values += count;
        }
    }
}

impl Sink {
    /// For the values of a file of so many bytes.
    pub fn new(bytes: u64) -> Self {
        let cells_max = bytes.saturating_mul(16).saturating_add(1 << 20);
        Self { channels: Vec::new(), shared: Shared::default(), cells: 0, kept: 0, cells_max, parts: 0 }
    }

    /// Counts the parts of a segment, and says where there are too many: thousands of channels in segments without a value each would
    /// take hours.
    pub fn work(&mut self, raw: &RawFile, parts: u64) -> Result<(), IngestError> {
        self.parts = self.parts.saturating_add(parts);
        if self.parts > self.cells_max {
            let found = format!("{} so far", self.parts);
            let next = "is this a log of channels? Split it";
            let expected = format!("at most {} channels in segments of so few bytes", self.cells_max);
            return Err(unusable(raw, &expected, found, next));
        }
        Ok(())
    }

    /// Counts values of a channel, and says where there are too many.
    fn add(&mut self, raw: &RawFile, channel: usize, count: u64) -> Result<(), IngestError> {
        let Some(channel) = self.channels.get(channel) else { return Ok(()) };
        let cells = count * channel.cells();
        self.cells += cells;
        if channel.is_kept {
            self.kept += cells;
        }
        let Self { cells, kept, cells_max, .. } = *self;
        if kept > LOG_CELLS_MAX as u64 {
            let next = "ask for fewer channels, or split the file";
            return Err(unusable(raw, &format!("at most {LOG_CELLS_MAX} values"), format!("{kept} so far"), next));
        }
        if cells > cells_max {
            let found = format!("{cells} so far: many channels take the same bytes");
            let next = "is this a log of channels? Split it";
            return Err(unusable(raw, &format!("at most {cells_max} values in so many bytes"), found, next));
        }
        Ok(())
    }
}
