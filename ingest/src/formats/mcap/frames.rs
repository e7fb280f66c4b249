//! The pictures of a topic, one after the other: they never become columns, and only one is in memory at a time.

use std::collections::HashMap;

use ::mcap::records::{Record, op};
use re_ros_msg::message_spec::MessageSpecification;

use super::fields;
use super::plan::Definitions;
use super::topic::Origin;
use crate::IngestError;
use crate::error::{Place, shown, suggestion};
use crate::raw::RawFile;

/// A picture as it was sent.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Frame<'a> {
    /// The sample of its topic, from 0.
    pub sample: usize,
    /// Stamp of its header in s, from the origin of the recording.
    pub stamp_s: f64,
    /// When it was written to the file, in s from the origin.
    pub log_time_s: f64,
    /// When it was sent, in s from the origin.
    pub publish_time_s: f64,
    /// How its bytes are to be understood.
    pub kind: FrameKind<'a>,
    /// Its bytes.
    pub data: &'a [u8],
}

/// How the bytes of a picture are to be understood.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FrameKind<'a> {
    /// Rows of pixels: `sensor_msgs/Image`.
    Raw {
        /// `mono8`, `bgr8`, `bayer_rggb8`, ...
        encoding: &'a str,
        /// Pixels in a row.
        width: u32,
        /// Rows.
        height: u32,
        /// Bytes from one row to the next.
        step: u32,
        /// Whether pixels of several bytes begin with the highest.
        big_endian: bool,
    },
    /// A file of a picture: `sensor_msgs/CompressedImage`.
    Compressed {
        /// `jpeg`, `png`, or words around them.
        format: &'a str,
    },
}

/// The two message types that are known here.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Type {
    Image,
    Compressed,
}

const IMAGE: &[&str] = &["header", "height", "width", "encoding", "is_bigendian", "step", "data"];
const COMPRESSED: &[&str] = &["header", "format", "data"];

/// Whether a definition is that of pictures: by its name and by its fields, which CDR depends on.
fn type_of(name: &str, text: &[u8]) -> Option<Type> {
    let definitions = Definitions::parse(name, std::str::from_utf8(text).ok()?).ok()?;
    let (name, spec): (_, &MessageSpecification) = definitions.root();
    let fields: Vec<&str> = spec.fields.iter().map(|field| field.name.as_str()).collect();
    match name {
        "sensor_msgs/Image" if fields == IMAGE => Some(Type::Image),
        "sensor_msgs/CompressedImage" if fields == COMPRESSED => Some(Type::Compressed),
        _ => None,
    }
}

/// Hands out the pictures of a topic in the order of the file, and says how many there were. Chunks and messages that are damaged
/// are left out, as [`read`](super::read) tells.
///
/// # Errors
/// [`IngestError::Malformed`] if there is no topic of this name, or its messages are no pictures; those of [`super::read`] and of
/// `visit`.
pub fn frames(
    raw: &RawFile,
    topic: &str,
    visit: &mut dyn FnMut(Frame) -> Result<(), IngestError>,
) -> Result<usize, IngestError> {
    let mut state = State { topic, origin: None, sample: 0, handed: 0, seen: vec![], found: false };
    for file in super::rosbag2::files(raw)? {
        state.file(file, visit)?;
    }
    if state.found {
        return Ok(state.handed);
    }
    let known = state.seen.iter().any(|seen| seen == topic);
    let found = if known { "a topic of other messages".to_owned() } else { "no such topic".to_owned() };
    let next = if known {
        "name a topic of pictures".to_owned()
    } else {
        suggestion(topic, state.seen.iter().map(String::as_str))
    };
    Err(IngestError::Malformed {
        place: Place::new(raw.name(), None, Some(shown(topic))),
        expected: "a topic of `sensor_msgs/msg/Image` or `sensor_msgs/msg/CompressedImage` in cdr".to_owned(),
        found,
        next,
    })
}

struct State<'s> {
    topic: &'s str,
    origin: Option<Origin>,
    sample: usize,
    handed: usize,
    seen: Vec<String>,
    found: bool,
}

impl State<'_> {
    fn file(
        &mut self,
        raw: &RawFile,
        visit: &mut dyn FnMut(Frame) -> Result<(), IngestError>,
    ) -> Result<(), IngestError> {
        let mut schemas: HashMap<u16, Option<Type>> = HashMap::new();
        let mut channels: HashMap<u16, Option<Type>> = HashMap::new();
        super::records(raw, &mut |record| {
            match record.opcode {
                op::SCHEMA => {
                    if let Some(Record::Schema { header, data }) = record.parse() {
                        let known = header.encoding == "ros2msg";
                        schemas.entry(header.id).or_insert_with(|| type_of(&header.name, &data).filter(|_| known));
                    }
                }
                op::CHANNEL => {
                    if let Some(Record::Channel(channel)) = record.parse() {
                        let kind = schemas.get(&channel.schema_id).copied().flatten();
                        let meant = channel.topic == self.topic && channel.message_encoding == "cdr";
                        let kind = kind.filter(|_| meant);
                        self.found |= kind.is_some();
                        if !self.seen.contains(&channel.topic) {
                            self.seen.push(channel.topic);
                        }
                        channels.entry(channel.id).or_insert(kind);
                    }
                }
                op::MESSAGE => {
                    let Some((head, data)) = fields::message(record.body) else { return Ok(()) };
                    let Some(kind) = channels.get(&head.channel) else { return Ok(()) };
                    let origin = *self.origin.get_or_insert_with(|| Origin::of(head.log_time));
                    let Some(kind) = kind else { return Ok(()) };
                    let sample = self.sample;
                    self.sample += 1;
                    if let Some(frame) = frame(*kind, data, origin, sample, head) {
                        self.handed += 1;
                        return visit(frame);
                    }
                }
                _ => {}
            }
            Ok(())
        })
    }
}

fn frame(kind: Type, message: &[u8], origin: Origin, sample: usize, times: fields::MessageHead) -> Option<Frame<'_>> {
    let (head, body) = message.split_first_chunk::<4>()?;
    // Nothing here is wider than four bytes, so both rules of alignment are one.
    let big = match head[..2] {
        [0, 0 | 6] => true,
        [0, 1 | 7] => false,
        _ => return None,
    };
    let mut cdr = Cdr { body, at: 0, big };
    let (seconds, nanoseconds) = (cdr.u32()?.cast_signed(), cdr.u32()?);
    cdr.bytes()?;
    let ns = (i64::from(seconds) - origin.seconds()).saturating_mul(1_000_000_000).saturating_add(nanoseconds.into());
    let kind = match kind {
        Type::Image => {
            let (height, width, encoding) = (cdr.u32()?, cdr.u32()?, cdr.text()?);
            let (big_endian, step) = (cdr.u8()? != 0, cdr.u32()?);
            FrameKind::Raw { encoding, width, height, step, big_endian }
        }
        Type::Compressed => FrameKind::Compressed { format: cdr.text()? },
    };
    let data = cdr.bytes()?;
    Some(Frame {
        sample,
        stamp_s: ns as f64 / 1e9,
        log_time_s: origin.since(times.log_time),
        publish_time_s: origin.since(times.publish_time),
        kind,
        data,
    })
}

struct Cdr<'a> {
    body: &'a [u8],
    at: usize,
    big: bool,
}

impl<'a> Cdr<'a> {
    fn u8(&mut self) -> Option<u8> {
        let byte = *self.body.get(self.at)?;
        self.at += 1;
        Some(byte)
    }

    fn u32(&mut self) -> Option<u32> {
        let start = self.at.next_multiple_of(4);
        let bytes = *self.body.get(start..)?.first_chunk()?;
        self.at = start + 4;
        Some(if self.big { u32::from_be_bytes(bytes) } else { u32::from_le_bytes(bytes) })
    }

    fn bytes(&mut self) -> Option<&'a [u8]> {
        let count = self.u32()? as usize;
        let bytes = self.body.get(self.at..self.at.checked_add(count)?)?;
        self.at += count;
        Some(bytes)
    }

    fn text(&mut self) -> Option<&'a str> {
        let bytes = self.bytes()?;
        std::str::from_utf8(bytes.strip_suffix(&[0]).unwrap_or(bytes)).ok()
    }
}
