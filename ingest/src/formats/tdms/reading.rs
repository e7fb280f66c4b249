//! The pass through a file: segment after segment, its values straight into columns.

use std::collections::{HashMap, HashSet};

use super::channel::{Channel, is_of_scaling};
use super::layout::{Layout, Shape};
use super::metadata::{self, INDEX_TAG, LEAD_BYTES, Lead, TAG, VERSIONS};
use super::objects::{Objects, Set};
use super::stream::Stream;
use super::take::{Sink, Task};
use super::tell::{Cut, Scaled, Tell};
use super::timing::{TIMING, Timing};
use super::unusable;
use crate::IngestError;
use crate::error::shown;
use crate::limits::{LOG_CELLS_MAX, LOG_COLUMNS_MAX, TDMS_METADATA_BYTES_MAX};
use crate::raw::RawFile;
use crate::recording::{Keep, full_name};

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
        sink: Sink::new(raw.len()),
        by_object: HashMap::new(),
        names: HashMap::new(),
        begun: HashSet::new(),
        objects: Objects::default(),
        looked_at: 0,
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
    /// Groups of channels that have begun to have values.
    begun: HashSet<String>,
    objects: Objects,
    /// Objects that were looked at so far: behind them are new ones.
    looked_at: usize,
    /// How values stand; `None` where metadata came since that was last asked.
    layout: Option<Layout>,
    /// Table of contents and metadata of the segment before: writers repeat them.
    before: Option<(u32, Vec<u8>)>,
    tell: Tell,
    segments: u64,
    is_index: bool,
    is_reserved: bool,
    is_scaled_late: bool,
}

impl Reading<'_> {
    /// Reads the next segment; whether another may follow.
    fn segment(&mut self) -> Result<bool, IngestError> {
        let at = self.stream.offset();
        let head = self.stream.at_least(LEAD_BYTES)?;
        if head.is_empty() && at > 0 {
            return Ok(false);
        }
        if at == 0 {
            self.is_index = head.starts_with(INDEX_TAG);
        }
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
            if self.segments == 0 {
                return self.damaged(at, "it has no metadata, and none were before it".to_owned());
            }
            // Metadata that come again may not mean the same after this.
            self.before = None;
        }
        if lead.has_raw_data()
            && let Err(what) = self.lay_out(lead)?
        {
            return self.damaged(at, what);
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
        self.layout = None;
        Ok(match done {
            Ok(sets) => self.prepare(&sets),
            Err(what) => Err(what),
        })
    }

    /// Makes channels of new objects, and looks at the properties that were set.
    fn prepare(&mut self, sets: &[Set]) -> Result<(), String> {
        let Self { objects, sink, by_object, names, keep, .. } = self;
        for (at, object) in objects.iter().enumerate().skip(self.looked_at) {
            let unique = |group: &str, name: &str| {
                let taken = names.entry(group.to_owned()).or_default();
                unique(taken, name)
            };
            if let Some(channel) = Channel::new(at, object, unique, *keep) {
                by_object.insert(at, sink.channels.len());
                sink.channels.push(channel);
            }
        }
        self.looked_at = objects.iter().len();
        if sink.channels.len() > LOG_COLUMNS_MAX {
            return Err(format!("{} channels up to there; at most {LOG_COLUMNS_MAX} are read", sink.channels.len()));
        }
        for Set { object: at, name, is_change } in sets {
            let Some(object) = objects.get(*at) else { continue };
            let channel = by_object.get(at).and_then(|channel| sink.channels.get_mut(*channel));
            if is_of_scaling(name) {
                // That of a group or of the file may be the scale of any channel there.
                let (is_begun, of) = match (&channel, &object.group) {
                    (Some(channel), _) => (channel.is_begun(), Scaled::Channel(&channel.group, &channel.name)),
                    (None, Some(group)) => (self.begun.contains(group), Scaled::Group(group)),
                    (None, None) => (!self.begun.is_empty(), Scaled::File),
                };
                self.is_scaled_late |= is_begun;
                if is_begun && *is_change {
                    self.tell.rescaled(of);
                }
                continue;
            }
            if let Some(channel) = channel
                && TIMING.contains(&name.as_str())
            {
                let timing = Timing::of(&object.properties);
                if let Some(start) = timing.start {
                    sink.shared.origin.get_or_insert(start.seconds);
                }
                channel.timings.set(channel.values, timing);
            }
        }
        Ok(())
    }

    /// Finds out how the values of a segment stand; the inner error is a sentence about the segment.
    fn lay_out(&mut self, lead: Lead) -> Result<Result<(), String>, IngestError> {
        if let Some(layout) = &mut self.layout
            && layout.is_interleaved == lead.is_interleaved()
        {
            layout.big_endian = lead.is_big_endian();
            return self.sink.work(self.raw, layout.parts()).map(Ok);
        }
        let Self { raw, keep, known, sink, by_object, begun, objects, .. } = self;
        let mut indexes = Vec::new();
        for (object, index) in objects.with_data().filter(|(_, index)| index.count > 0 || index.text_bytes > 0) {
            let Some(at) = by_object.get(&object) else {
                return Ok(Err("the file or a group should have values; only channels can".to_owned()));
            };
            let Some(channel) = sink.channels.get_mut(*at) else { continue };
            if !channel.is_begun() && !begun.contains(&channel.group) {
                begun.insert(channel.group.clone());
            }
            if let Err(what) = channel.begin(index, known.unwrap_or(objects), *keep) {
                let name = full_name(&channel.group, &channel.name);
                return Ok(Err(format!("{}: {what}", shown(&name))));
            }
            indexes.push((*at, index));
        }
        Ok(match Layout::new(lead, indexes.into_iter()) {
            Ok(layout) => {
                sink.work(raw, layout.parts())?;
                self.layout = Some(layout);
                Ok(())
            }
            Err(what) => Err(what),
        })
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
        let (chunks, rest) = (bytes / layout.chunk_bytes, bytes % layout.chunk_bytes);
        match &layout.shape {
            Shape::Interleaved { width } => task.rows(bytes / width, *width)?,
            Shape::Contiguous => {
                for _ in 0..chunks {
                    task.chunk(layout.chunk_bytes)?;
                }
                // Where the file ends within a last chunk that is short anyway, it is the first bytes of that.
                let short = stated.filter(|stated| stated / layout.chunk_bytes == chunks);
                if let Some(stated) = short.filter(|_| rest > 0) {
                    task.short_chunk(stated % layout.chunk_bytes, rest)?;
                } else if rest > 0 {
                    task.chunk(rest)?;
                }
            }
            Shape::Daqmx(buffers) => {
                for _ in 0..chunks {
                    task.daqmx(buffers)?;
                }
                if rest > 0 {
                    task.short_daqmx(buffers, rest, is_whole)?;
                }
            }
        }
        if !is_whole {
            tell.lost(at, Cut::InData { stated, there: bytes });
            return Ok(());
        }
        let is_in_rows = matches!(layout.shape, Shape::Interleaved { .. });
        if !is_in_rows && rest > 0 {
            tell.short_chunk(at, rest, layout.chunk_bytes);
        }
        let taken = stream.offset() - at - LEAD_BYTES as u64 - lead.raw;
        if bytes > taken {
            tell.unexplained(at, bytes - taken);
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
