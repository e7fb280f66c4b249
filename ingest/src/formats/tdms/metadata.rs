//! Lead-in and metadata of a segment, as they stand in the file.

use super::types::{DataType, timestamp};
use super::value::Value;
use crate::error::shown;
use crate::finding::places::as_text;
use crate::limits::{TDMS_BUFFERS_MAX, TDMS_SCALES_MAX};

/// Bytes of a lead-in.
pub(super) const LEAD_BYTES: usize = 28;

/// What stands at the beginning of each segment, and of each segment of an index.
pub(super) const TAG: &[u8; 4] = b"TDSm";
pub(super) const INDEX_TAG: &[u8; 4] = b"TDSh";

/// Versions of the format that are written.
pub(super) const VERSIONS: [u32; 2] = [4712, 4713];

/// Bits of the table of contents.
const METADATA: u32 = 1 << 1;
const NEW_LIST: u32 = 1 << 2;
const RAW_DATA: u32 = 1 << 3;
const INTERLEAVED: u32 = 1 << 5;
const BIG_ENDIAN: u32 = 1 << 6;

/// The lead-in of a segment.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Lead {
    /// The table of contents.
    pub toc: u32,
    pub version: u32,
    /// Bytes from behind the lead-in to the next segment; `None` where the writer did not come to know.
    pub next: Option<u64>,
    /// Bytes from behind the lead-in to the raw data.
    pub raw: u64,
}

impl Lead {
    /// Reads it behind its tag; `None` if there are not enough bytes.
    pub fn parse(bytes: &[u8]) -> Option<Self> {
        // The table of contents is always little endian: it says how the rest stands.
        let toc = u32::from_le_bytes(*bytes.get(4..)?.first_chunk()?);
        let mut rest = Cursor { bytes: bytes.get(8..LEAD_BYTES)?, at: 0, big_endian: toc & BIG_ENDIAN != 0 };
        let (version, next, raw) = (rest.u32().ok()?, rest.u64().ok()?, rest.u64().ok()?);
        Some(Self { toc, version, next: (next != u64::MAX).then_some(next), raw })
    }

    pub fn has_metadata(self) -> bool {
        self.toc & METADATA != 0
    }

    pub fn is_new_list(self) -> bool {
        self.toc & NEW_LIST != 0
    }

    pub fn has_raw_data(self) -> bool {
        self.toc & RAW_DATA != 0
    }

    pub fn is_interleaved(self) -> bool {
        self.toc & INTERLEAVED != 0
    }

    pub fn is_big_endian(self) -> bool {
        self.toc & BIG_ENDIAN != 0
    }
}

/// Where a value of a DAQ card stands, and what it is.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Scaler {
    pub id: u32,
    pub data_type: DataType,
    /// Which of the raw buffers.
    pub buffer: usize,
    /// Bytes from the beginning of a row of the buffer.
    pub offset: usize,
    /// The line of a digital port: a bit of that byte.
    pub bit: Option<u32>,
}

/// How the raw values of a channel stand in a chunk.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct RawIndex {
    pub data_type: DataType,
    /// Values in a chunk.
    pub count: u64,
    /// Bytes of all texts of a chunk.
    pub text_bytes: u64,
    /// Of a DAQ card: its scalers, and the bytes of a row in each raw buffer.
    pub daqmx: Option<(Vec<Scaler>, Vec<u64>)>,
}

/// What the metadata of a segment say about the raw data of an object.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum IndexSaid {
    /// It has none.
    NoData,
    /// They stand as in the segment before.
    AsBefore,
    /// They stand so.
    New(RawIndex),
}

/// An object in the metadata of a segment.
#[derive(Debug)]
pub(super) struct Entry<'b> {
    pub path: &'b [u8],
    pub index: IndexSaid,
    pub properties: Vec<(&'b [u8], Value)>,
}

/// Bytes of metadata being read; every error is a sentence about what is wrong there.
struct Cursor<'b> {
    bytes: &'b [u8],
    at: usize,
    big_endian: bool,
}

impl<'b> Cursor<'b> {
    fn take(&mut self, count: usize) -> Result<&'b [u8], String> {
        let end = self.at.checked_add(count).filter(|end| *end <= self.bytes.len());
        let Some(taken) = end.and_then(|end| self.bytes.get(self.at..end)) else {
            return Err(format!("its metadata end within an item at their byte {}", self.at));
        };
        self.at += count;
        Ok(taken)
    }

    fn array<const N: usize>(&mut self) -> Result<[u8; N], String> {
        let at = self.at;
        self.take(N)?
            .first_chunk()
            .copied()
            .ok_or_else(|| format!("its metadata end within an item at their byte {at}"))
    }

    fn u8(&mut self) -> Result<u8, String> {
        self.array().map(|[byte]: [u8; 1]| byte)
    }

    fn u32(&mut self) -> Result<u32, String> {
        let bytes = self.array()?;
        Ok(if self.big_endian { u32::from_be_bytes(bytes) } else { u32::from_le_bytes(bytes) })
    }

    fn u64(&mut self) -> Result<u64, String> {
        let bytes = self.array()?;
        Ok(if self.big_endian { u64::from_be_bytes(bytes) } else { u64::from_le_bytes(bytes) })
    }

    fn text(&mut self) -> Result<&'b [u8], String> {
        let length = self.u32()?;
        self.take(usize::try_from(length).map_err(|_| "a text of more than 4 GB".to_owned())?)
    }

    /// How many of something follow, each of at least `bytes` bytes: more than the metadata can hold is damage, told before any memory
    /// is asked for.
    fn count(&mut self, what: &str, bytes: usize) -> Result<usize, String> {
        let at = self.at;
        let count = self.u32()?;
        let room = (self.bytes.len() - self.at) / bytes;
        usize::try_from(count).ok().filter(|count| *count <= room).ok_or_else(|| {
            format!("its metadata state {count} {what} at their byte {at}, more than they have room for")
        })
    }

    fn value(&mut self, name: &[u8]) -> Result<Value, String> {
        let code = self.u32()?;
        let data_type =
            DataType::of(code).map_err(|what| format!("the property {} holds {what}", shown(&as_text(name))))?;
        let big_endian = self.big_endian;
        macro_rules! number {
            ($type:ty) => {{
                let bytes = self.array()?;
                if big_endian { <$type>::from_be_bytes(bytes) } else { <$type>::from_le_bytes(bytes) }
            }};
        }
        Ok(match data_type {
            DataType::Void => Value::Void,
            DataType::I8 => Value::Int(number!(i8).into()),
            DataType::I16 => Value::Int(number!(i16).into()),
            DataType::I32 => Value::Int(number!(i32).into()),
            DataType::I64 => Value::Int(number!(i64)),
            DataType::U8 => Value::Uint(number!(u8).into()),
            DataType::U16 => Value::Uint(number!(u16).into()),
            DataType::U32 => Value::Uint(number!(u32).into()),
            DataType::U64 => Value::Uint(number!(u64)),
            DataType::Single => Value::Single(number!(f32)),
            DataType::Double => Value::Double(number!(f64)),
            DataType::ComplexSingle => {
                let re = number!(f32);
                Value::Complex(re.into(), number!(f32).into())
            }
            DataType::ComplexDouble => {
                let re = number!(f64);
                Value::Complex(re, number!(f64))
            }
            DataType::Text => Value::Text(as_text(self.text()?)),
            DataType::Bool => Value::Bool(self.u8()? != 0),
            DataType::Time => Value::Time(timestamp(self.array()?, big_endian)),
            DataType::Daqmx => return Err(format!("the property {} has no type", shown(&as_text(name)))),
        })
    }

    fn index(&mut self) -> Result<IndexSaid, String> {
        match self.u32()? {
            u32::MAX => Ok(IndexSaid::NoData),
            0 => Ok(IndexSaid::AsBefore),
            0x1269 => self.daqmx(false).map(IndexSaid::New),
            // NI's document has the second of these, files the first.
            0x126a | 0x1369 => self.daqmx(true).map(IndexSaid::New),
            // The length of what follows, which its type says too.
            _ => self.plain().map(IndexSaid::New),
        }
    }

    fn dimension(&mut self) -> Result<(), String> {
        match self.u32()? {
            1 => Ok(()),
            other => Err(format!("a channel holds arrays of {other} dimensions; only one is allowed")),
        }
    }

    fn plain(&mut self) -> Result<RawIndex, String> {
        let data_type = DataType::of(self.u32()?).map_err(|what| format!("a channel holds {what}"))?;
        self.dimension()?;
        let count = self.u64()?;
        let text_bytes = if data_type == DataType::Text { self.u64()? } else { 0 };
        if matches!(data_type, DataType::Void | DataType::Daqmx) && count != 0 {
            return Err(format!("a channel holds {count} values of {}", data_type.name()));
        }
        Ok(RawIndex { data_type, count, text_bytes, daqmx: None })
    }

    fn daqmx(&mut self, is_digital: bool) -> Result<RawIndex, String> {
        let data_type = DataType::of(self.u32()?).map_err(|what| format!("a channel holds {what}"))?;
        self.dimension()?;
        let count = self.u64()?;
        let mut scalers = Vec::new();
        let stated = self.count("scalers", if is_digital { 17 } else { 20 })?;
        if stated > TDMS_SCALES_MAX {
            return Err(format!("a channel has {stated} scalers; at most {TDMS_SCALES_MAX} are read"));
        }
        for _ in 0..stated {
            let of = DataType::of_scaler(self.u32()?)?;
            let (buffer, place) = (self.u32()? as usize, self.u32()? as usize);
            // The format of a sample, which nothing depends on.
            let _ = if is_digital { self.u8()?.into() } else { self.u32()? };
            let id = self.u32()?;
            if scalers.iter().any(|known: &Scaler| known.id == id) {
                return Err(format!("a channel has scaler {id} twice"));
            }
            let (offset, bit) = if is_digital {
                // Lines count from the lowest bit of the value, which stands in its last byte where the high byte is first.
                let (byte, width) = (place / 8, of.width().unwrap_or(1).max(1));
                let begin = byte / width * width;
                let byte = if self.big_endian { begin + (width - 1) - (byte - begin) } else { byte };
                (byte, u32::try_from(place % 8).ok())
            } else {
                (place, None)
            };
            if scalers.iter().any(|scaler: &Scaler| scaler.id == id) {
                return Err(format!("a channel has two scalers of the id {id}"));
            }
            scalers.push(Scaler { id, data_type: of, buffer, offset, bit });
        }
        let mut widths = Vec::new();
        let stated = self.count("raw buffers", 4)?;
        if stated > TDMS_BUFFERS_MAX {
            return Err(format!("a channel has {stated} raw buffers; at most {TDMS_BUFFERS_MAX} are read"));
        }
        for _ in 0..stated {
            widths.push(self.u32()?.into());
        }
        if data_type != DataType::Daqmx {
            match scalers.as_slice() {
                [one] if one.data_type == data_type => {}
                [one] => {
                    let (stated, of) = (data_type.name(), one.data_type.name());
                    return Err(format!("a channel states values of the type {stated}, and its scaler {of}"));
                }
                many => {
                    let (stated, count) = (data_type.name(), many.len());
                    return Err(format!("a channel of the type {stated} has {count} scalers; only one is allowed"));
                }
            }
        }
        for scaler in &scalers {
            let width = widths.get(scaler.buffer).copied().unwrap_or(0);
            let end = scaler.offset as u64
                + if scaler.bit.is_some() { 1 } else { scaler.data_type.width().unwrap_or(1) as u64 };
            if end > width {
                return Err(format!(
                    "a scaler takes bytes up to {end} of raw buffer {}, whose rows have {width}",
                    scaler.buffer
                ));
            }
        }
        Ok(RawIndex { data_type, count, text_bytes: 0, daqmx: Some((scalers, widths)) })
    }
}

/// Reads the metadata of a segment. What stands behind them up to the raw data is padding.
///
/// The error is a sentence about the segment.
pub(super) fn parse(bytes: &[u8], big_endian: bool) -> Result<Vec<Entry<'_>>, String> {
    let mut cursor = Cursor { bytes, at: 0, big_endian };
    let count = cursor.count("objects", 12)?;
    let mut entries = Vec::with_capacity(count);
    for _ in 0..count {
        let path = cursor.text()?;
        let index = cursor.index().map_err(|what| format!("{}: {what}", shown(&as_text(path))))?;
        let mut properties = Vec::new();
        for _ in 0..cursor.count("properties", 8)? {
            let name = cursor.text()?;
            properties.push((name, cursor.value(name)?));
        }
        entries.push(Entry { path, index, properties });
    }
    Ok(entries)
}

/// Group and channel of a path: `/'group'/'channel'`, quotes within names doubled. `None` if it is no path.
pub(super) fn names(path: &[u8]) -> Option<(Option<String>, Option<String>)> {
    if path == b"/" {
        return Some((None, None));
    }
    let (group, rest) = name(path)?;
    if rest.is_empty() {
        return Some((Some(group), None));
    }
    let (channel, rest) = name(rest)?;
    rest.is_empty().then_some((Some(group), Some(channel)))
}

/// A name in quotes behind a slash, and what follows it.
fn name(path: &[u8]) -> Option<(String, &[u8])> {
    let rest = path.strip_prefix(b"/'")?;
    let mut text = Vec::new();
    let mut at = 0;
    loop {
        match (rest.get(at)?, rest.get(at + 1)) {
            (b'\'', Some(b'\'')) => {
                text.push(b'\'');
                at += 2;
            }
            (b'\'', _) => return Some((as_text(&text), rest.get(at + 1..)?)),
            (other, _) => {
                text.push(*other);
                at += 1;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_those_between_the_quotes() {
        let some = |name: &str| Some(name.to_owned());
        assert_eq!(names(b"/"), Some((None, None)));
        assert_eq!(names(b"/'Measured Data'"), Some((some("Measured Data"), None)));
        assert_eq!(names(b"/'Dr. T''s Events'/'Time'"), Some((some("Dr. T's Events"), some("Time"))));
        assert_eq!(names(b"/''/'a/''b'''"), Some((some(""), some("a/'b'"))));
        for path in [&b""[..], b"//", b"/'a", b"/'a'b", b"/'a'/'b'/'c'", b"'a'", b"/a"] {
            assert_eq!(names(path), None, "{}", as_text(path));
        }
    }

    #[test]
    fn counts_beyond_the_metadata_are_damage_and_ask_for_no_memory() {
        assert!(parse(&u32::MAX.to_le_bytes(), false).unwrap_err().contains("4294967295 objects"));
        assert!(parse(&[1, 0, 0, 0, 9, 0, 0, 0, b'/'], false).unwrap_err().contains("objects"));
        assert!(parse(&[], false).is_err());
    }
}
