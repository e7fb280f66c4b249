//! The pass through a file: segment after segment, its values straight into columns.

use std::collections::{HashMap, HashSet};

use super::channel::{Channel, Shared, is_of_scaling};
use super::layout::{Layout, Piece, RawBuffer, Shape};
use super::metadata::{self, INDEX_TAG, LEAD_BYTES, Lead, TAG, VERSIONS};
use super::objects::{Objects, Set};
use super::stream::Stream;
use super::tell::{Cut, Tell};
use super::timing::{TIMING, Timing};
use super::types::{DataType, Values};
use super::unusable;
use crate::IngestError;
use crate::limits::{LOG_CELLS_MAX, LOG_COLUMNS_MAX, TDMS_METADATA_BYTES_MAX};
use crate::raw::RawFile;
use crate::recording::{Keep, full_name};

/// Bytes that become numbers at once: few enough to stay in the nearest cache until they are looked at.
const STEP: usize = 1 << 14;

/// Bytes after which it is guessed how many values there will be.
const RESERVE_AT: u64 = 1 << 18;

/// What a pass has read.
pub(super) struct Pass {
    pub objects: Objects,
    pub channels: Vec<Channel>,
    pub origin: Option<i64>,
    pub tell: Tell,
    pub is_index: bool,
    pub segments: u64,
    /// Whether a scale was stated after values it belongs to.
    pub is_scaled_late: bool,
}

/// Reads a file. `known` holds all objects of it, if a pass before has met them.
pub(super) fn read(raw: &RawFile, keep: Keep, known: Option<&Objects>) -> Result<Pass, IngestError> {
    let mut reading = Reading {
        raw,
        keep,
        known,
        stream: Stream::open(raw)?,
        sink: Sink {
            channels: Vec::new(),
            shared: Shared::default(),
            cells: 0,
            kept: 0,
            cells_max: raw.len().saturating_mul(16).saturating_add(1 << 20),
        },
        by_object: HashMap::new(),
        names: HashMap::new(),
        objects: Objects::default(),
        layout: None,
        before: None,
        tell: Tell::default(),
        segments: 0,
        is_index: false,
        is_reserved: false,
        is_scaled_late: false,
    };
    while reading.segment()? {}
    let Reading { objects, sink, tell, is_index, segments, is_scaled_late, .. } = reading;
    Ok(Pass { objects, channels: sink.channels, origin: sink.shared.origin, tell, is_index, segments, is_scaled_late })
}

struct Reading<'a> {
    raw: &'a RawFile<'a>,
    keep: Keep<'a>,
    known: Option<&'a Objects>,
    stream: Stream<'a>,
    sink: Sink,
    /// Which channel an object is.
    by_object: HashMap<usize, usize>,
    /// Names of channels by group.
    names: HashMap<String, HashSet<String>>,
    objects: Objects,
    /// How the values of the segment stand; `None` before the first metadata.
    layout: Option<Layout>,
    /// Table of contents and metadata of the segment before: writers repeat them.
    before: Option<(u32, Vec<u8>)>,
    tell: Tell,
    segments: u64,
    is_index: bool,
    is_reserved: bool,
    is_scaled_late: bool,
}

/// Where values go.
struct Sink {
    channels: Vec<Channel>,
    shared: Shared,
    /// Cells so far, and those in memory.
    cells: u64,
    kept: u64,
    /// Lines of a digital port make up to eight cells of a byte; many more than that are damage.
    cells_max: u64,
}

impl Reading<'_> {
    /// Reads the next segment; whether another may follow.
    fn segment(&mut self) -> Result<bool, IngestError> {
        let at = self.stream.offset();
        let head = self.stream.at_least(LEAD_BYTES)?;
        if head.is_empty() && at > 0 {
            return Ok(false);
        }
        let tag = if at == 0 && head.starts_with(INDEX_TAG) { INDEX_TAG } else { TAG };
        self.is_index |= tag == INDEX_TAG;
        let tag = if self.is_index { INDEX_TAG } else { TAG };
        if !head.starts_with(tag) {
            if at == 0 {
                return Err(no_tag(self.raw, head));
            }
            let is_cut = tag.starts_with(head);
            self.lost(at, if is_cut { Cut::InLead } else { Cut::NoSegment })?;
            return Ok(false);
        }
        let Some(lead) = Lead::parse(head) else {
            if at == 0 {
                let found = format!("{} bytes of it", head.len());
                return Err(unusable(self.raw, "a lead-in of 28 bytes", found, "the file is cut; copy it again"));
            }
            self.lost(at, Cut::InLead)?;
            return Ok(false);
        };
        self.stream.consume(LEAD_BYTES);
        if !VERSIONS.contains(&lead.version) {
            self.tell.version(lead.version);
        }
        let left = self.raw.len().saturating_sub(self.stream.offset());
        if lead.next.is_some_and(|next| next < lead.raw) {
            return self.damaged(at, "its raw data should begin behind its end".to_owned());
        }
        if lead.raw > left {
            return self.cut(at, Cut::InMetadata { stated: lead.raw, there: left });
        }
        if lead.has_metadata() {
            if lead.raw > TDMS_METADATA_BYTES_MAX {
                let what =
                    format!("it states {} bytes of metadata; at most {TDMS_METADATA_BYTES_MAX} are read", lead.raw);
                return self.damaged(at, what);
            }
            if let Err(what) = self.metadata(lead)? {
                return self.damaged(at, what);
            }
        } else {
            self.stream.skip(lead.raw)?;
            let Some(layout) = &mut self.layout else {
                return self.damaged(at, "it has no metadata, and none were before it".to_owned());
            };
            layout.big_endian = lead.is_big_endian();
            // Metadata that come again may not mean the same after this.
            self.before = None;
        }
        self.segments += 1;
        if self.is_index {
            let raw_bytes = lead.next.map(|next| next - lead.raw);
            self.count(lead, raw_bytes);
            return Ok(true);
        }
        let left = left - lead.raw;
        let (bytes, is_whole) = match lead.next {
            Some(next) => (left.min(next - lead.raw), left >= next - lead.raw),
            None => (left, false),
        };
        if lead.has_raw_data() {
            self.raw_data(at, bytes, is_whole, lead)?;
        } else if bytes > 0 {
            self.tell.unexplained(at, bytes);
        }
        // What no channel has taken.
        let taken = self.stream.offset() - at - LEAD_BYTES as u64 - lead.raw;
        self.stream.skip(bytes - taken.min(bytes))?;
        self.reserve();
        Ok(is_whole)
    }

    /// Reads metadata and prepares the channels; the inner error is a sentence about the segment.
    fn metadata(&mut self, lead: Lead) -> Result<Result<(), String>, IngestError> {
        // Checked to be at most what is read of metadata.
        let length = usize::try_from(lead.raw).unwrap_or(usize::MAX);
        let held = self.stream.at_least(length)?;
        let Some(bytes) = held.get(..length) else {
            let there = held.len();
            return Ok(Err(format!(
                "its metadata are {length} bytes, and {there} came: does somebody write to the file?"
            )));
        };
        if self.before.as_ref().is_some_and(|(toc, before)| *toc == lead.toc && before == bytes) {
            self.stream.consume(length);
            return Ok(Ok(()));
        }
        let done = metadata::parse(bytes, lead.is_big_endian())
            .and_then(|entries| self.objects.apply(entries, lead.is_new_list()));
        let before = self.before.get_or_insert_default();
        before.0 = lead.toc;
        before.1.clear();
        before.1.extend_from_slice(bytes);
        self.stream.consume(length);
        Ok(match done {
            Ok(sets) => self.prepare(lead, &sets),
            Err(what) => Err(what),
        })
    }

    /// Makes channels of objects that have values, and the layout of the segment.
    fn prepare(&mut self, lead: Lead, sets: &[Set]) -> Result<(), String> {
        let Self { objects, sink, by_object, names, keep, .. } = self;
        let mut indexes = Vec::new();
        for (at, object) in objects.iter().enumerate().skip(self.tell.objects) {
            let unique = |group: &str, name: &str| {
                let taken = names.entry(group.to_owned()).or_default();
                unique(taken, name)
            };
            if let Some(channel) = Channel::new(at, object, unique, *keep) {
                by_object.insert(at, sink.channels.len());
                sink.channels.push(channel);
            }
        }
        self.tell.objects = objects.iter().len();
        if sink.channels.len() > LOG_COLUMNS_MAX {
            return Err(format!("{} channels up to there; at most {LOG_COLUMNS_MAX} are read", sink.channels.len()));
        }
        for (object, index) in objects.with_data() {
            let Some(channel) = by_object.get(&object) else {
                if index.count == 0 {
                    continue;
                }
                return Err("the file or a group should have values; only channels can".to_owned());
            };
            indexes.push((*channel, index));
        }
        for Set { object, name, is_change } in sets {
            let channel = by_object.get(object).and_then(|channel| sink.channels.get_mut(*channel));
            if is_of_scaling(name) {
                let has_values = match &channel {
                    Some(channel) => channel.values > 0,
                    None => sink.cells > 0,
                };
                self.is_scaled_late |= has_values && (*is_change || channel.is_some());
                continue;
            }
            if let Some(channel) = channel
                && TIMING.contains(&name.as_str())
                && let Some(object) = objects.get(*object)
            {
                let timing = Timing::of(&object.properties);
                if let Some(start) = timing.start {
                    sink.shared.origin.get_or_insert(start.seconds);
                }
                if !channel.timings.set(channel.values, timing) {
                    return Err("the time axis of a channel changes too often to be followed".to_owned());
                }
            }
        }
        for (channel, index) in &indexes {
            let Some(channel) = sink.channels.get_mut(*channel) else { continue };
            if index.count > 0 {
                channel.begin(index, self.known.unwrap_or(objects), *keep).map_err(|what| {
                    let name = full_name(&channel.group, &channel.name);
                    format!("{}: {what}", crate::error::shown(&name))
                })?;
            }
        }
        self.layout = Some(Layout::new(lead, indexes.into_iter())?);
        Ok(())
    }

    /// Takes the values of a segment.
    fn raw_data(&mut self, at: u64, bytes: u64, is_whole: bool, lead: Lead) -> Result<(), IngestError> {
        let Self { raw, layout: Some(layout), stream, sink, tell, .. } = self else { return Ok(()) };
        let mut task = Task { raw, layout, stream, sink, tell };
        if layout.chunk_bytes == 0 {
            if bytes > 0 {
                task.tell.unexplained(at, bytes);
            }
            return Ok(());
        }
        let stated = lead.next.map(|next| next - lead.raw);
        match &layout.shape {
            Shape::Interleaved { width } => task.rows(bytes / width, *width)?,
            Shape::Contiguous => {
                for _ in 0..bytes / layout.chunk_bytes {
                    task.chunk(layout.chunk_bytes)?;
                }
                let rest = bytes % layout.chunk_bytes;
                if rest > 0 && is_whole {
                    task.short_chunk(rest)?;
                } else if rest > 0 {
                    task.chunk(rest)?;
                }
            }
            Shape::Daqmx(buffers) => {
                for _ in 0..bytes / layout.chunk_bytes {
                    task.daqmx(buffers, layout.chunk_bytes)?;
                }
                let rest = bytes % layout.chunk_bytes;
                if rest > 0 {
                    task.daqmx(buffers, rest)?;
                }
            }
        }
        let over = match &layout.shape {
            Shape::Interleaved { width } => bytes % width,
            _ => bytes - bytes.min(stream.offset() - at - LEAD_BYTES as u64 - lead.raw),
        };
        if is_whole && layout.shape == Shape::Contiguous && !bytes.is_multiple_of(layout.chunk_bytes) {
            tell.short_chunk(at, bytes % layout.chunk_bytes, layout.chunk_bytes);
        }
        if !is_whole {
            tell.lost(at, Cut::InData { stated, there: bytes });
        } else if over > 0 {
            tell.unexplained(at, over);
        }
        Ok(())
    }

    /// Counts the values that an index states.
    fn count(&mut self, lead: Lead, bytes: Option<u64>) {
        let Some(layout) = &self.layout else { return };
        // The last segment of an index that was never closed says nothing.
        let Some(bytes) = bytes else { return };
        if layout.chunk_bytes == 0 || !lead.has_raw_data() {
            return;
        }
        for piece in &layout.pieces {
            if let Some(channel) = self.sink.channels.get_mut(piece.channel) {
                let share = u128::from(piece.count) * u128::from(bytes) / u128::from(layout.chunk_bytes);
                channel.stated = channel.stated.saturating_add(u64::try_from(share).unwrap_or(u64::MAX));
            }
        }
    }

    /// Asks once for the memory that as many values in all other bytes would need.
    fn reserve(&mut self) {
        let read = self.stream.offset();
        if self.is_reserved || read < RESERVE_AT {
            return;
        }
        self.is_reserved = true;
        let rest = u128::from(self.raw.len().saturating_sub(read));
        let per_channel = LOG_CELLS_MAX / self.sink.channels.len().max(1);
        for channel in &mut self.sink.channels {
            let expected = rest * u128::from(channel.values) / u128::from(read);
            let expected = usize::try_from(expected + expected / 64).unwrap_or(usize::MAX);
            channel.reserve(expected.min(per_channel));
        }
    }

    /// The rest of the file cannot be used.
    fn lost(&mut self, at: u64, cut: Cut) -> Result<(), IngestError> {
        let zeros = matches!(cut, Cut::NoSegment) && self.only_zeros()?;
        self.tell.lost(at, if zeros { Cut::Zeros } else { cut });
        Ok(())
    }

    fn only_zeros(&mut self) -> Result<bool, IngestError> {
        loop {
            let held = self.stream.at_least(1)?;
            let count = held.len();
            if held.iter().any(|byte| *byte != 0) {
                return Ok(false);
            }
            if count == 0 {
                return Ok(true);
            }
            self.stream.consume(count);
        }
    }

    /// A segment that is not what it should be: without it nobody knows what stands behind it, or when it was measured.
    fn damaged(&mut self, at: u64, what: String) -> Result<bool, IngestError> {
        if self.segments == 0 {
            let next = "is this the file you meant? Read it with the program that wrote it";
            return Err(unusable(
                self.raw,
                "a segment of a TDMS file",
                format!("a first segment that cannot be used: {what}"),
                next,
            ));
        }
        self.tell.lost(at, Cut::Damaged(what));
        Ok(false)
    }

    fn cut(&mut self, at: u64, cut: Cut) -> Result<bool, IngestError> {
        if self.segments == 0 {
            let found = format!("a first segment that ends before its values begin, after {} bytes", self.raw.len());
            return Err(unusable(self.raw, "a segment with values", found, "the file is cut; copy it again"));
        }
        self.tell.lost(at, cut);
        Ok(false)
    }
}

/// A name that no other channel of the group has.
pub(super) fn unique(taken: &mut HashSet<String>, name: &str) -> String {
    let mut free = name.to_owned();
    let mut copy = 1;
    while !taken.insert(free.clone()) {
        copy += 1;
        free = format!("{name} ({copy})");
    }
    free
}

fn no_tag(raw: &RawFile, head: &[u8]) -> IngestError {
    let found = if head.is_empty() { "an empty file" } else { "other bytes" };
    let expected = "a TDMS file, which begins with `TDSm`";
    unusable(raw, expected, found.to_owned(), "is this the file you meant?")
}

/// Taking the values of a segment.
struct Task<'t, 'a> {
    raw: &'t RawFile<'a>,
    layout: &'t Layout,
    stream: &'t mut Stream<'a>,
    sink: &'t mut Sink,
    tell: &'t mut Tell,
}

impl Task<'_, '_> {
    /// A chunk of values channel after channel, or its first bytes: whole values are taken.
    fn chunk(&mut self, mut bytes: u64) -> Result<(), IngestError> {
        for piece in &self.layout.pieces {
            self.state(piece.channel, piece.count);
            let there = piece.bytes.min(bytes);
            bytes -= there;
            self.piece(piece, piece.count, there)?;
        }
        Ok(())
    }

    /// A last chunk that is shorter than the others though its segment is whole: each channel has fewer values.
    fn short_chunk(&mut self, bytes: u64) -> Result<(), IngestError> {
        if self.layout.pieces.iter().any(|piece| piece.data_type == DataType::Text) {
            return self.chunk(bytes);
        }
        for piece in &self.layout.pieces {
            let share = u128::from(piece.count) * u128::from(bytes) / u128::from(self.layout.chunk_bytes);
            let count = u64::try_from(share).unwrap_or(0);
            self.state(piece.channel, count);
            self.piece(piece, count, count * piece.data_type.width().unwrap_or(0) as u64)?;
        }
        Ok(())
    }

    /// The values of a channel in a chunk: `count` of them in so many bytes, or fewer.
    fn piece(&mut self, piece: &Piece, count: u64, bytes: u64) -> Result<(), IngestError> {
        let Some(width) = piece.data_type.width() else { return self.texts(piece, count, bytes) };
        let Some(channel) = self.sink.channels.get_mut(piece.channel) else { return Ok(()) };
        if width == 0 {
            return Ok(());
        }
        let whole = bytes / width as u64;
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
            self.sink.add(self.raw, piece.channel, whole)
        } else {
            channel.values += whole;
            self.stream.skip(bytes)?;
            Ok(())
        }
    }

    /// Texts of a channel: where each ends, then all of them.
    fn texts(&mut self, piece: &Piece, count: u64, bytes: u64) -> Result<(), IngestError> {
        let Some(channel) = self.sink.channels.get_mut(piece.channel) else { return Ok(()) };
        // Checked to be at most what is read of texts.
        let length = usize::try_from(bytes).unwrap_or(usize::MAX);
        let count = usize::try_from(count).unwrap_or(usize::MAX);
        let window = self.stream.at_least(length)?;
        let all = window.get(..length).unwrap_or(window);
        let (ends, texts) = all.split_at_checked(count.saturating_mul(4)).unwrap_or((all, &[]));
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
        self.sink.add(self.raw, piece.channel, whole as u64)
    }

    /// Rows with a value of each channel.
    fn rows(&mut self, rows: u64, width: u64) -> Result<(), IngestError> {
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
                channel.stated += fit as u64;
                offset += piece.data_type.width().unwrap_or(0);
            }
            self.stream.consume(fit * stride);
            left -= fit as u64;
        }
        Ok(())
    }

    /// A chunk of DAQ cards, or its first bytes: whole rows are taken.
    fn daqmx(&mut self, buffers: &[RawBuffer], mut bytes: u64) -> Result<(), IngestError> {
        for buffer in buffers {
            for tap in buffer.taps.iter().filter(|tap| tap.scaler == 0) {
                self.state(tap.channel, buffer.rows);
            }
            let there = (buffer.rows * buffer.width).min(bytes);
            bytes -= there;
            let Some(stride) = usize::try_from(buffer.width).ok().filter(|width| *width > 0) else { continue };
            let mut left = there / buffer.width;
            let over = there % buffer.width;
            while left > 0 {
                let window = self.stream.at_least(stride)?;
                let fit =
                    (window.len().min(STEP.max(stride)) / stride).min(usize::try_from(left).unwrap_or(usize::MAX));
                let Some(rows) = window.get(..fit * stride).filter(|rows| !rows.is_empty()) else { break };
                for tap in buffer.taps.iter().filter(|tap| tap.scaler == 0) {
                    self.sink.add(self.raw, tap.channel, fit as u64)?;
                }
                for tap in &buffer.taps {
                    let Some(channel) = self.sink.channels.get_mut(tap.channel) else { continue };
                    let values = Values { bytes: rows, stride, offset: tap.offset, big_endian: self.layout.big_endian };
                    channel.push_scaler(values, tap.scaler, tap.bit, tap.data_type, &mut self.sink.shared);
                    if tap.scaler == 0 {
                        channel.values += fit as u64;
                    }
                }
                self.stream.consume(fit * stride);
                left -= fit as u64;
            }
            self.stream.skip(over)?;
        }
        Ok(())
    }

    fn state(&mut self, channel: usize, count: u64) {
        if let Some(channel) = self.sink.channels.get_mut(channel) {
            channel.stated += count;
        }
    }
}

impl Sink {
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
