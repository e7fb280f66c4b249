//! How the values of all channels stand in the chunks of a segment.

use super::metadata::{Lead, RawIndex};
use super::types::DataType;
use crate::limits::TDMS_TEXTS_BYTES_MAX;

/// The values of a channel in a chunk.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Piece {
    pub channel: usize,
    pub data_type: DataType,
    /// Values.
    pub count: u64,
    /// Bytes of all of them.
    pub bytes: u64,
}

/// A value in the rows of a raw buffer.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Tap {
    pub channel: usize,
    /// Its place among [`Layout::pieces`].
    pub piece: usize,
    /// Which of the channel's scalers.
    pub scaler: usize,
    pub data_type: DataType,
    pub offset: usize,
    pub bit: Option<u32>,
}

/// A raw buffer of a DAQ card: rows with the values of all its channels.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct RawBuffer {
    pub rows: u64,
    pub width: u64,
    pub taps: Vec<Tap>,
}

/// What a chunk looks like.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum Shape {
    /// Channel after channel.
    Contiguous,
    /// Value after value, in rows of so many bytes.
    Interleaved { width: u64 },
    /// Rows of DAQ cards, buffer after buffer.
    Daqmx(Vec<RawBuffer>),
}

/// The chunks of a segment.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Layout {
    pub shape: Shape,
    /// Channels with values, in the order of the file.
    pub pieces: Vec<Piece>,
    pub chunk_bytes: u64,
    pub big_endian: bool,
    /// What the table of contents says, whatever the shape.
    pub is_interleaved: bool,
}

impl Layout {
    /// The layout of a segment; the error is a sentence about it.
    pub fn new<'o>(lead: Lead, with_data: impl Iterator<Item = (usize, &'o RawIndex)>) -> Result<Self, String> {
        let mut pieces = Vec::new();
        let mut cards = Vec::new();
        let mut chunk_bytes = 0_u64;
        let too_large = || "its chunks would be larger than any file".to_owned();
        for (channel, index) in with_data {
            let RawIndex { data_type, count, text_bytes, daqmx } = index;
            let (data_type, count) = (*data_type, *count);
            if count == 0 && daqmx.is_some() {
                continue;
            }
            if let Some(card) = daqmx {
                cards.push((channel, count, card));
                pieces.push(Piece { channel, data_type, count, bytes: 0 });
                continue;
            }
            let bytes = match data_type.width() {
                Some(width) => count.checked_mul(width as u64).ok_or_else(too_large)?,
                None => *text_bytes,
            };
            if count > 0 || bytes > 0 {
                chunk_bytes = chunk_bytes.checked_add(bytes).ok_or_else(too_large)?;
                pieces.push(Piece { channel, data_type, count, bytes });
            }
        }
        let (big_endian, is_interleaved) = (lead.is_big_endian(), lead.is_interleaved());
        if !cards.is_empty() {
            if cards.len() < pieces.len() {
                return Err(
                    "channels of DAQ cards stand beside others in it, which no reader can tell apart".to_owned()
                );
            }
            let buffers = raw_buffers(&cards)?;
            let bytes = |sum: u64, buffer: &RawBuffer| sum.checked_add(buffer.rows.checked_mul(buffer.width)?);
            let chunk_bytes = buffers.iter().try_fold(0, bytes).ok_or_else(too_large)?;
            return Ok(Self { shape: Shape::Daqmx(buffers), pieces, chunk_bytes, big_endian, is_interleaved });
        }
        let shape = if is_interleaved { interleaved(&pieces)? } else { Shape::Contiguous };
        pieces.iter().filter(|piece| piece.data_type == DataType::Text).try_for_each(check_texts)?;
        Ok(Self { shape, pieces, chunk_bytes, big_endian, is_interleaved })
    }

    /// How many parts are looked at for every chunk, however few bytes it has.
    pub fn parts(&self) -> u64 {
        let taps = match &self.shape {
            Shape::Daqmx(buffers) => buffers.iter().map(|buffer| buffer.taps.len()).sum(),
            Shape::Contiguous | Shape::Interleaved { .. } => 0,
        };
        (self.pieces.len() + taps) as u64
    }
}

fn check_texts(piece: &Piece) -> Result<(), String> {
    let Piece { count, bytes, .. } = piece;
    if *bytes > TDMS_TEXTS_BYTES_MAX {
        return Err(format!("{bytes} bytes of text in a chunk of a channel; at most {TDMS_TEXTS_BYTES_MAX} are read"));
    }
    // Each text has at least the four bytes that say where it ends.
    if count.checked_mul(4).is_none_or(|ends| ends > *bytes) {
        return Err(format!("{count} texts in {bytes} bytes, which do not hold their lengths"));
    }
    Ok(())
}

fn interleaved(pieces: &[Piece]) -> Result<Shape, String> {
    if let [one] = pieces
        && one.data_type == DataType::Text
    {
        // A single channel of text stands as it would otherwise.
        return Ok(Shape::Contiguous);
    }
    let mut width = 0;
    for piece in pieces {
        let Some(bytes) = piece.data_type.width() else {
            return Err("text stands between numbers in rows of one length, which cannot be".to_owned());
        };
        width += bytes as u64;
    }
    let counts: Vec<u64> = pieces.iter().map(|piece| piece.count).collect();
    match counts.iter().find(|count| Some(*count) != counts.first()) {
        Some(other) => Err(format!(
            "its channels stand in common rows, but one has {} values and another {other}",
            counts.first().copied().unwrap_or(0)
        )),
        None => Ok(Shape::Interleaved { width }),
    }
}

/// A channel of a DAQ card, its values in a chunk, and its scalers with the widths of the raw buffers.
type Card<'o> = (usize, u64, &'o (Vec<super::metadata::Scaler>, Vec<u64>));

fn raw_buffers(cards: &[Card]) -> Result<Vec<RawBuffer>, String> {
    let widths = cards.first().map(|(_, _, (_, widths))| widths.as_slice()).unwrap_or_default();
    let mut buffers: Vec<RawBuffer> =
        widths.iter().map(|width| RawBuffer { rows: 0, width: *width, taps: Vec::new() }).collect();
    for (piece, (channel, count, (scalers, own))) in cards.iter().enumerate() {
        if own != widths {
            return Err(format!("its channels disagree on the raw buffers: rows of {widths:?} and of {own:?} bytes"));
        }
        for (index, scaler) in scalers.iter().enumerate() {
            let Some(buffer) = buffers.get_mut(scaler.buffer) else {
                return Err(format!("a scaler takes raw buffer {}, and there are {}", scaler.buffer, widths.len()));
            };
            if !buffer.taps.is_empty() && buffer.rows != *count {
                return Err(format!(
                    "its channels disagree on raw buffer {}: {} and {count} rows",
                    scaler.buffer, buffer.rows
                ));
            }
            buffer.rows = *count;
            buffer.taps.push(Tap {
                channel: *channel,
                piece,
                scaler: index,
                data_type: scaler.data_type,
                offset: scaler.offset,
                bit: scaler.bit,
            });
        }
    }
    // Those that nobody takes from have no bytes either.
    buffers.retain(|buffer| buffer.rows > 0);
    Ok(buffers)
}
