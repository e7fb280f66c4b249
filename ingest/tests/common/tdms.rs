//! TDMS files byte by byte, written down from the format's description: the tests' own, so that reader and writer cannot err alike.

// Each test file takes what it needs.
#![allow(dead_code)]

/// Bits of the table of contents.
pub const METADATA: u32 = 2;
pub const NEW_LIST: u32 = 4;
pub const RAW: u32 = 8;
pub const INTERLEAVED: u32 = 32;
pub const BIG_ENDIAN: u32 = 64;
pub const DAQMX: u32 = 128;
pub const USUAL: u32 = METADATA | NEW_LIST | RAW;

/// Numbers with the low or the high byte first.
#[derive(Clone, Copy)]
pub struct Order {
    pub big: bool,
}

pub const LITTLE: Order = Order { big: false };
pub const BIG: Order = Order { big: true };

impl Order {
    pub fn bytes(self, little: &[u8]) -> Vec<u8> {
        let mut bytes = little.to_vec();
        if self.big {
            bytes.reverse();
        }
        bytes
    }

    pub fn u32(self, value: u32) -> Vec<u8> {
        self.bytes(&value.to_le_bytes())
    }

    pub fn u64(self, value: u64) -> Vec<u8> {
        self.bytes(&value.to_le_bytes())
    }

    pub fn text(self, text: &str) -> Vec<u8> {
        [self.u32(u32::try_from(text.len()).unwrap()), text.as_bytes().to_vec()].concat()
    }
}

/// The value of a property with its type.
#[derive(Clone, Copy)]
pub enum Prop<'a> {
    I32(i32),
    U32(u32),
    F64(f64),
    Text(&'a str),
    Time(i64, u64),
    Bool(bool),
}

impl Order {
    fn prop(self, name: &str, value: Prop) -> Vec<u8> {
        let (code, bytes) = match value {
            Prop::I32(value) => (3, self.bytes(&value.to_le_bytes())),
            Prop::U32(value) => (7, self.u32(value)),
            Prop::F64(value) => (10, self.bytes(&value.to_le_bytes())),
            Prop::Text(text) => (0x20, self.text(text)),
            Prop::Time(seconds, fraction) => (0x44, self.stamp(seconds, fraction)),
            Prop::Bool(value) => (0x21, vec![u8::from(value)]),
        };
        [self.text(name), self.u32(code), bytes].concat()
    }

    pub fn stamp(self, seconds: i64, fraction: u64) -> Vec<u8> {
        self.bytes(&[fraction.to_le_bytes(), seconds.to_le_bytes()].concat())
    }

    /// An object of the metadata.
    pub fn object(self, path: &str, index: &[u8], props: &[(&str, Prop)]) -> Vec<u8> {
        let mut object = [self.text(path), index.to_vec(), self.u32(u32::try_from(props.len()).unwrap())].concat();
        for (name, value) in props {
            object.extend(self.prop(name, *value));
        }
        object
    }

    /// Values of a type of fixed width.
    pub fn index(self, code: u32, count: u64) -> Vec<u8> {
        [self.u32(20), self.u32(code), self.u32(1), self.u64(count)].concat()
    }

    pub fn text_index(self, count: u64, bytes: u64) -> Vec<u8> {
        [self.u32(28), self.u32(0x20), self.u32(1), self.u64(count), self.u64(bytes)].concat()
    }

    pub fn no_data(self) -> Vec<u8> {
        self.u32(u32::MAX)
    }

    pub fn as_before(self) -> Vec<u8> {
        self.u32(0)
    }

    /// Values of a DAQ card: (type, buffer, byte or line, id) of each scaler, and the widths of the buffers.
    pub fn daqmx(
        self,
        code: u32,
        is_digital: bool,
        count: u64,
        scalers: &[(u32, u32, u32, u32)],
        widths: &[u32],
    ) -> Vec<u8> {
        let header = if is_digital { 0x126a } else { 0x1269 };
        let mut index = [self.u32(header), self.u32(code), self.u32(1), self.u64(count)].concat();
        index.extend(self.u32(u32::try_from(scalers.len()).unwrap()));
        for (of, buffer, place, id) in scalers {
            index.extend([self.u32(*of), self.u32(*buffer), self.u32(*place)].concat());
            index.extend(if is_digital { vec![0] } else { self.u32(0) });
            index.extend(self.u32(*id));
        }
        index.extend(self.u32(u32::try_from(widths.len()).unwrap()));
        for width in widths {
            index.extend(self.u32(*width));
        }
        index
    }

    /// A segment.
    pub fn segment(self, toc: u32, objects: &[Vec<u8>], data: &[u8]) -> Vec<u8> {
        let metadata = if toc & METADATA == 0 { vec![] } else { self.metadata(objects) };
        let next = (metadata.len() + data.len()) as u64;
        [self.lead(*b"TDSm", toc, next, metadata.len() as u64), metadata, data.to_vec()].concat()
    }

    pub fn metadata(self, objects: &[Vec<u8>]) -> Vec<u8> {
        [self.u32(u32::try_from(objects.len()).unwrap()), objects.concat()].concat()
    }

    pub fn lead(self, tag: [u8; 4], toc: u32, next: u64, raw: u64) -> Vec<u8> {
        let toc = if self.big { toc | BIG_ENDIAN } else { toc };
        [tag.to_vec(), toc.to_le_bytes().to_vec(), self.u32(4713), self.u64(next), self.u64(raw)].concat()
    }
}

/// Little-endian bytes of numbers.
pub fn f64s(values: &[f64]) -> Vec<u8> {
    values.iter().flat_map(|value| value.to_le_bytes()).collect()
}

pub fn i32s(values: &[i32]) -> Vec<u8> {
    values.iter().flat_map(|value| value.to_le_bytes()).collect()
}

pub fn i16s(values: &[i16]) -> Vec<u8> {
    values.iter().flat_map(|value| value.to_le_bytes()).collect()
}

pub const P: &str = "/'rig'/'p'";
pub const F: &str = "/'rig'/'F'";

/// A file of two channels of doubles with a waveform each, in three segments of two chunks of three samples: 18 samples.
pub fn two_channels() -> Vec<u8> {
    let wave = [("wf_increment", Prop::F64(0.01)), ("wf_start_offset", Prop::F64(0.0))];
    let index = LITTLE.index(10, 3);
    let full = [LITTLE.object(P, &index, &wave), LITTLE.object(F, &index, &wave)];
    let mut file = vec![];
    for segment in 0..3 {
        let mut data = vec![];
        for chunk in 0..2 {
            let first = f64::from(segment * 6 + chunk * 3);
            data.extend(f64s(&[first, first + 1.0, first + 2.0]));
            data.extend(f64s(&[-first, -first - 1.0, -first - 2.0]));
        }
        file.extend(match segment {
            0 => LITTLE.segment(USUAL, &full, &data),
            1 => LITTLE.segment(METADATA | RAW, &[LITTLE.object(P, &LITTLE.as_before(), &[])], &data),
            _ => LITTLE.segment(RAW, &[], &data),
        });
    }
    file
}
