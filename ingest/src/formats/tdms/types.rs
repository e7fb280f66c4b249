//! Types of raw values, and their way to doubles.

use super::value::Timestamp;

/// The type of the values of a channel.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum DataType {
    /// No values.
    Void,
    I8,
    I16,
    I32,
    I64,
    U8,
    U16,
    U32,
    U64,
    Single,
    Double,
    Bool,
    Time,
    ComplexSingle,
    ComplexDouble,
    Text,
    /// Values that only the scalers of a DAQ card know.
    Daqmx,
}

impl DataType {
    /// By the code in a raw data index.
    pub fn of(code: u32) -> Result<Self, String> {
        Ok(match code {
            0 => Self::Void,
            1 => Self::I8,
            2 => Self::I16,
            3 => Self::I32,
            4 => Self::I64,
            5 => Self::U8,
            6 => Self::U16,
            7 => Self::U32,
            8 => Self::U64,
            // With and without a unit among the properties: the values are the same.
            9 | 0x19 => Self::Single,
            10 | 0x1a => Self::Double,
            0x20 => Self::Text,
            0x21 => Self::Bool,
            0x44 => Self::Time,
            0x0008_000c => Self::ComplexSingle,
            0x0010_000d => Self::ComplexDouble,
            0xffff_ffff => Self::Daqmx,
            11 | 0x1b => {
                return Err(format!("extended-precision numbers (type {code:#x}), whose size no document states"));
            }
            0x4f => return Err("fixed-point numbers (type 0x4f), whose layout no document states".to_owned()),
            _ => return Err(format!("values of the unknown type {code:#x}")),
        })
    }

    /// By the code in a scaler of a DAQ card, which counts otherwise.
    pub fn of_scaler(code: u32) -> Result<Self, String> {
        Ok(match code {
            0 => Self::U8,
            1 => Self::I8,
            2 => Self::U16,
            3 => Self::I16,
            4 => Self::U32,
            5 => Self::I32,
            6 => Self::U64,
            7 => Self::I64,
            8 => Self::Single,
            9 => Self::Double,
            0xffff_ffff => Self::Time,
            _ => return Err(format!("a scaler of the unknown type {code}")),
        })
    }

    /// Bytes of a value; `None` for text, whose length is its own.
    pub fn width(self) -> Option<usize> {
        Some(match self {
            Self::Void | Self::Daqmx => 0,
            Self::I8 | Self::U8 | Self::Bool => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::Single => 4,
            Self::I64 | Self::U64 | Self::Double | Self::ComplexSingle => 8,
            Self::Time | Self::ComplexDouble => 16,
            Self::Text => return None,
        })
    }

    /// What it is called.
    pub fn name(self) -> &'static str {
        match self {
            Self::Void => "no type",
            Self::I8 => "int8",
            Self::I16 => "int16",
            Self::I32 => "int32",
            Self::I64 => "int64",
            Self::U8 => "uint8",
            Self::U16 => "uint16",
            Self::U32 => "uint32",
            Self::U64 => "uint64",
            Self::Single => "single",
            Self::Double => "double",
            Self::Bool => "boolean",
            Self::Time => "timestamps",
            Self::ComplexSingle => "complex single",
            Self::ComplexDouble => "complex double",
            Self::Text => "text",
            Self::Daqmx => "DAQmx raw data",
        }
    }
}

/// Values in a block of bytes: one every `stride` bytes, at `offset` behind each such place.
#[derive(Debug, Clone, Copy)]
pub(super) struct Values<'b> {
    pub bytes: &'b [u8],
    pub stride: usize,
    pub offset: usize,
    pub big_endian: bool,
}

/// Where values go.
pub(super) trait Sink {
    fn extend(&mut self, values: impl Iterator<Item = f64>);
}

impl Sink for crate::recording::Builder {
    #[inline]
    fn extend(&mut self, values: impl Iterator<Item = f64>) {
        Self::extend(self, values);
    }
}

impl Sink for Vec<f64> {
    #[inline]
    fn extend(&mut self, values: impl Iterator<Item = f64>) {
        Extend::extend(self, values);
    }
}

impl Values<'_> {
    /// Bytes of `N` each, side by side or apart.
    #[inline]
    fn each<const N: usize>(self, sink: &mut impl Sink, of: impl Fn([u8; N]) -> f64) {
        if self.stride == N && self.offset == 0 {
            let (values, _) = self.bytes.as_chunks::<N>();
            sink.extend(values.iter().map(|bytes| of(*bytes)));
        } else if self.offset + N <= self.stride {
            let offset = self.offset;
            let places = self.bytes.chunks_exact(self.stride);
            sink.extend(
                places.map(|place| place.get(offset..).and_then(<[u8]>::first_chunk).map_or(f64::NAN, |b| of(*b))),
            );
        }
    }

    /// The numbers, as doubles; integers beyond 2^53 are rounded to the nearest. `instant` makes a number of a timestamp.
    ///
    /// Text gives nothing, and neither do types without values; of complex numbers the real parts come.
    pub fn push(self, data_type: DataType, sink: &mut impl Sink, instant: impl Fn(Timestamp) -> f64) {
        macro_rules! of {
            ($type:ty, $double:expr) => {
                if self.big_endian {
                    self.each(sink, |bytes| $double(<$type>::from_be_bytes(bytes)))
                } else {
                    self.each(sink, |bytes| $double(<$type>::from_le_bytes(bytes)))
                }
            };
        }
        match data_type {
            DataType::I8 => of!(i8, f64::from),
            DataType::I16 => of!(i16, f64::from),
            DataType::I32 => of!(i32, f64::from),
            DataType::I64 => of!(i64, |int: i64| int as f64),
            DataType::U8 => of!(u8, f64::from),
            DataType::U16 => of!(u16, f64::from),
            DataType::U32 => of!(u32, f64::from),
            DataType::U64 => of!(u64, |int: u64| int as f64),
            DataType::Single | DataType::ComplexSingle => of!(f32, f64::from),
            DataType::Double | DataType::ComplexDouble => of!(f64, |double: f64| double),
            DataType::Bool => self.each(sink, |[byte]: [u8; 1]| f64::from(u8::from(byte != 0))),
            DataType::Time => {
                let big_endian = self.big_endian;
                self.each(sink, |bytes: [u8; 16]| instant(timestamp(bytes, big_endian)));
            }
            DataType::Void | DataType::Text | DataType::Daqmx => {}
        }
    }

    /// The imaginary parts of complex numbers.
    pub fn push_imaginary(self, data_type: DataType, sink: &mut impl Sink) {
        let half = if data_type == DataType::ComplexSingle { 4 } else { 8 };
        let part = if data_type == DataType::ComplexSingle { DataType::Single } else { DataType::Double };
        Self { offset: self.offset + half, ..self }.push(part, sink, |_| f64::NAN);
    }

    /// One bit of each value, as 0 or 1: a line of a digital port.
    pub fn push_bit(self, bit: u32, sink: &mut impl Sink) {
        self.each(sink, |[byte]: [u8; 1]| f64::from((byte >> bit) & 1));
    }
}

/// An instant: the fraction stands first where the low byte does.
pub(super) fn timestamp(bytes: [u8; 16], big_endian: bool) -> Timestamp {
    let both = if big_endian { u128::from_be_bytes(bytes) } else { u128::from_le_bytes(bytes) };
    let [seconds, fraction] = [both >> 64, both & u128::from(u64::MAX)].map(|half| u64::try_from(half).unwrap_or(0));
    Timestamp { seconds: seconds.cast_signed(), fraction }
}
