//! Segments: a lead-in, what the segment says of its objects, and chunks of values.

use std::io::Write;
use std::ops::Range;

use super::plan::{Channel, Plan, Values, count, origin_plus, single};
use super::{Metadata, WriteOptions};
use crate::IngestError;
use crate::error::Place;
use crate::formats::tdms::value::{Properties, Timestamp, Value};

/// Whether the values are written too.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Form {
    Whole,
    Index,
}

/// What a segment holds, as bits of its lead-in.
const META_DATA: u32 = 1 << 1;
const NEW_LIST: u32 = 1 << 2;
const RAW_DATA: u32 = 1 << 3;
const INTERLEAVED: u32 = 1 << 5;
const BIG_ENDIAN: u32 = 1 << 6;

/// Version 2.0 of the format.
const VERSION: u32 = 4713;

/// In place of the size of a raw index: no data, or as before.
const NO_DATA: u32 = 0xFFFF_FFFF;
const AS_BEFORE: u32 = 0;

/// Bytes of values that are collected before they are written.
const BUFFER_BYTES: usize = 1 << 16;

/// What a channel has in each chunk of a segment.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Part {
    /// By its place among the channels.
    channel: usize,
    rows: usize,
    bytes: u64,
}

/// The data of a segment.
struct Segment {
    parts: Vec<Part>,
    chunks: usize,
}

pub(super) fn write(out: &mut impl Write, plan: &Plan, options: &WriteOptions, form: Form) -> Result<(), IngestError> {
    let failed = |source| IngestError::write("the TDMS file".as_ref(), source);
    let mut done = vec![0; plan.channels.len()];
    let mut before: Option<Vec<Part>> = None;
    let mut encoder = Encoder { big_endian: options.big_endian, bytes: vec![] };
    for stream in streams(plan, options) {
        loop {
            let segment = next(plan, options, stream.clone(), &done)?;
            // What has no data is told once, in the first segment.
            if segment.parts.is_empty() && before.is_some() {
                break;
            }
            head(&mut encoder, plan, options, form, &segment, before.as_deref())?;
            for _ in 0..segment.chunks {
                if form == Form::Whole && options.interleaved {
                    let rows = segment.parts.first().map_or(0, |part| part.rows);
                    for row in 0..rows {
                        for part in &segment.parts {
                            let row = done[part.channel] + row;
                            encoder.values(&plan.channels[part.channel].values, row..row + 1);
                        }
                        encoder.flush(out, BUFFER_BYTES).map_err(failed)?;
                    }
                } else if form == Form::Whole {
                    for part in &segment.parts {
                        let (values, start) = (&plan.channels[part.channel].values, done[part.channel]);
                        encoder.offsets(values, start..start + part.rows);
                        for row in (start..start + part.rows).step_by(BUFFER_BYTES / 16) {
                            encoder.values(values, row..(row + BUFFER_BYTES / 16).min(start + part.rows));
                            encoder.flush(out, BUFFER_BYTES).map_err(failed)?;
                        }
                    }
                }
                for part in &segment.parts {
                    done[part.channel] += part.rows;
                }
            }
            encoder.flush(out, 0).map_err(failed)?;
            before = Some(segment.parts);
        }
    }
    if before.is_none() {
        // A file without channels.
        head(&mut encoder, plan, options, form, &Segment { parts: vec![], chunks: 0 }, None)?;
        encoder.flush(out, 0).map_err(failed)?;
    }
    out.flush().map_err(failed)
}

/// Channels that share segments: all of them, or those of a group.
fn streams(plan: &Plan, options: &WriteOptions) -> Vec<Range<usize>> {
    let mut streams: Vec<Range<usize>> = vec![];
    for (number, channel) in plan.channels.iter().enumerate() {
        let is_together =
            |last: &&mut Range<usize>| !options.interleaved || plan.channels[last.start].group == channel.group;
        match streams.last_mut().filter(is_together) {
            Some(last) => last.end = number + 1,
            None => streams.push(number..number + 1),
        }
    }
    streams
}

/// The next segment of a stream: whole chunks as long as every channel that goes on fills them, then a shorter one.
fn next(plan: &Plan, options: &WriteOptions, stream: Range<usize>, done: &[usize]) -> Result<Segment, IngestError> {
    let left = |channel: usize| plan.channels[channel].values.len() - done[channel];
    let chunk_rows = options.chunk_rows.map_or(usize::MAX, usize::from);
    let mut chunks = options.segment_chunks.map_or(1, usize::from);
    let mut parts = vec![];
    for channel in stream.filter(|channel| left(*channel) > 0) {
        let rows = left(channel).min(chunk_rows);
        chunks = chunks.min((left(channel) / chunk_rows).max(1));
        let bytes = bytes_of(&plan.channels[channel], done[channel]..done[channel] + rows)?;
        parts.push(Part { channel, rows, bytes });
    }
    Ok(Segment { chunks: if parts.is_empty() { 0 } else { chunks }, parts })
}

/// Bytes of values in the file.
fn bytes_of(channel: &Channel, rows: Range<usize>) -> Result<u64, IngestError> {
    let Values::Text(text) = &channel.values else {
        return Ok(rows.len() as u64 * u64::from(width(&channel.values)));
    };
    let bytes: u64 = text[rows.clone()].iter().map(|text| text.len() as u64).sum();
    if u32::try_from(bytes).is_err() {
        return Err(too_long(channel.place.clone(), bytes));
    }
    Ok(bytes + 4 * rows.len() as u64)
}

fn too_long(place: Place, bytes: u64) -> IngestError {
    IngestError::Malformed {
        place,
        expected: format!("text of at most {} bytes", u32::MAX),
        found: format!("{bytes} bytes"),
        next: "use shorter chunks or names".to_owned(),
    }
}

/// Bytes of a value; of a text its offset.
fn width(values: &Values) -> u32 {
    match values {
        Values::Double(_) => 8,
        Values::Single(_) | Values::Text(_) => 4,
        Values::Counts { .. } => 2,
        Values::Instants { .. } => 16,
    }
}

/// The code of a type.
fn code(values: &Values) -> u32 {
    match values {
        Values::Counts { .. } => 2,
        Values::Single(_) => 9,
        Values::Double(_) => 10,
        Values::Text(_) => 0x20,
        Values::Instants { .. } => 0x44,
    }
}

/// Lead-in and metadata of a segment. `before` is what the segment before it holds; the first has none.
fn head(
    encoder: &mut Encoder,
    plan: &Plan,
    options: &WriteOptions,
    form: Form,
    segment: &Segment,
    before: Option<&[Part]>,
) -> Result<(), IngestError> {
    let mut meta = Encoder { big_endian: options.big_endian, bytes: vec![] };
    let (contents, place) = (options.metadata, |name: &str| Place::new(name, None, None));
    let same_channels = before
        .is_some_and(|before| before.iter().map(|part| part.channel).eq(segment.parts.iter().map(|part| part.channel)));
    let is_as_before = |part: &Part| before.is_some_and(|before| before.contains(part));
    let mut bits = META_DATA;
    if before.is_none() || contents == Metadata::Repeated {
        bits |= NEW_LIST;
        meta.count(1 + plan.groups.len() + plan.channels.len())?;
        meta.text("/", &place("the file"))?;
        meta.u32(NO_DATA);
        meta.properties(&plan.root, &place("the file"))?;
        for (number, group) in plan.groups.iter().enumerate() {
            meta.text(&group.path, &place(&group.path))?;
            meta.u32(NO_DATA);
            meta.properties(&group.properties, &place(&group.path))?;
            let channels = plan.channels.iter().enumerate().filter(|(_, channel)| channel.group == number);
            for (number, channel) in channels {
                meta.text(&channel.path, &channel.place)?;
                match segment.parts.iter().find(|part| part.channel == number) {
                    Some(part) => meta.raw_index(&channel.values, part),
                    None => meta.u32(NO_DATA),
                }
                meta.properties(&channel.properties, &channel.place)?;
            }
        }
    } else {
        let stands = same_channels && contents != Metadata::AsBefore;
        let listed: Vec<&Part> = segment.parts.iter().filter(|part| !stands || !is_as_before(part)).collect();
        if !stands {
            bits |= NEW_LIST;
        } else if listed.is_empty() && contents == Metadata::Absent {
            bits = 0;
        }
        if bits != 0 {
            meta.count(listed.len())?;
        }
        for part in listed {
            let channel = &plan.channels[part.channel];
            meta.text(&channel.path, &channel.place)?;
            if is_as_before(part) {
                meta.u32(AS_BEFORE);
            } else {
                meta.raw_index(&channel.values, part);
            }
            meta.u32(0);
        }
    }
    if !segment.parts.is_empty() {
        bits |= RAW_DATA;
        bits |= if options.interleaved { INTERLEAVED } else { 0 };
    }
    bits |= if options.big_endian { BIG_ENDIAN } else { 0 };
    let data = segment.parts.iter().map(|part| part.bytes).sum::<u64>() * segment.chunks as u64;
    encoder.bytes.extend_from_slice(if form == Form::Whole { b"TDSm" } else { b"TDSh" });
    // Which order the others are in is said here, so that this one has always the same.
    encoder.bytes.extend_from_slice(&bits.to_le_bytes());
    encoder.u32(VERSION);
    encoder.u64(meta.bytes.len() as u64 + data);
    encoder.u64(meta.bytes.len() as u64);
    encoder.bytes.append(&mut meta.bytes);
    Ok(())
}

/// Bytes on their way into the file.
struct Encoder {
    big_endian: bool,
    bytes: Vec<u8>,
}

impl Encoder {
    /// Writes what is there, if it is more than so many bytes.
    fn flush(&mut self, out: &mut impl Write, more_than: usize) -> std::io::Result<()> {
        if self.bytes.len() > more_than {
            out.write_all(&self.bytes)?;
            self.bytes.clear();
        }
        Ok(())
    }

    /// Bytes of one value, least significant first.
    fn put<const N: usize>(&mut self, mut bytes: [u8; N]) {
        if self.big_endian {
            bytes.reverse();
        }
        self.bytes.extend_from_slice(&bytes);
    }

    fn u32(&mut self, value: u32) {
        self.put(value.to_le_bytes());
    }

    fn u64(&mut self, value: u64) {
        self.put(value.to_le_bytes());
    }

    fn count(&mut self, count: usize) -> Result<(), IngestError> {
        let place = || Place::new("the file", None, None);
        self.u32(u32::try_from(count).map_err(|_| too_long(place(), count as u64))?);
        Ok(())
    }

    fn text(&mut self, text: &str, place: &Place) -> Result<(), IngestError> {
        self.u32(u32::try_from(text.len()).map_err(|_| too_long(place.clone(), text.len() as u64))?);
        self.bytes.extend_from_slice(text.as_bytes());
        Ok(())
    }

    /// Seconds and their fraction are one number of 128 bits.
    fn instant(&mut self, instant: Timestamp) {
        let whole = (i128::from(instant.seconds) << 64) | i128::from(instant.fraction);
        self.put(whole.to_le_bytes());
    }

    fn raw_index(&mut self, values: &Values, part: &Part) {
        let is_text = matches!(values, Values::Text(_));
        self.u32(if is_text { 28 } else { 20 });
        self.u32(code(values));
        // Of one dimension.
        self.u32(1);
        self.u64(part.rows as u64);
        if is_text {
            self.u64(part.bytes);
        }
    }

    fn properties(&mut self, properties: &Properties, place: &Place) -> Result<(), IngestError> {
        self.count(properties.len())?;
        for (name, value) in properties {
            self.text(name, place)?;
            self.property(value, place)?;
        }
        Ok(())
    }

    /// The code of the type, then the value. Integers have 32 bits where they fit.
    fn property(&mut self, value: &Value, place: &Place) -> Result<(), IngestError> {
        match value {
            Value::Int(value) => {
                if let Ok(value) = i32::try_from(*value) {
                    self.u32(3);
                    self.put(value.to_le_bytes());
                } else {
                    self.u32(4);
                    self.put(value.to_le_bytes());
                }
            }
            Value::Uint(value) => {
                if let Ok(value) = u32::try_from(*value) {
                    self.u32(7);
                    self.u32(value);
                } else {
                    self.u32(8);
                    self.u64(*value);
                }
            }
            Value::Single(value) => {
                self.u32(9);
                self.put(value.to_le_bytes());
            }
            Value::Double(value) => {
                self.u32(10);
                self.put(value.to_le_bytes());
            }
            Value::Complex(re, im) => {
                self.u32(0x10_000D);
                self.put(re.to_le_bytes());
                self.put(im.to_le_bytes());
            }
            Value::Text(text) => {
                self.u32(0x20);
                self.text(text, place)?;
            }
            Value::Bool(value) => {
                self.u32(0x21);
                self.put([u8::from(*value)]);
            }
            Value::Time(instant) => {
                self.u32(0x44);
                self.instant(*instant);
            }
            // The plan refuses it.
            Value::Void => self.u32(0),
        }
        Ok(())
    }

    /// Where each text of a chunk ends, counted from the first.
    // The sum was found to fit.
    #[allow(clippy::cast_possible_truncation)]
    fn offsets(&mut self, values: &Values, rows: Range<usize>) {
        let Values::Text(text) = values else { return };
        let mut end = 0_usize;
        for text in &text[rows] {
            end += text.len();
            self.u32(end as u32);
        }
    }

    /// Values of rows that are there. The plan found that each fits its type.
    fn values(&mut self, values: &Values, rows: Range<usize>) {
        match values {
            Values::Double(values) => values[rows].iter().for_each(|value| self.put(value.to_le_bytes())),
            Values::Single(values) => {
                let singles = values[rows].iter().filter_map(|value| single(*value));
                singles.for_each(|value| self.put(value.to_le_bytes()));
            }
            Values::Counts { values, slope, intercept } => {
                let counts = values[rows].iter().filter_map(|value| count(*value, *slope, *intercept));
                counts.for_each(|value| self.put(value.to_le_bytes()));
            }
            Values::Instants { stamps, origin } => {
                let instants = stamps[rows].iter().filter_map(|stamp| origin_plus(*origin, *stamp));
                instants.for_each(|instant| self.instant(instant));
            }
            Values::Text(text) => text[rows].iter().for_each(|text| self.bytes.extend_from_slice(text.as_bytes())),
        }
    }
}
