//! Bags as recorders write them, by the crate.

// In a test a panic is how a failure is told; not every test that has this uses all of it.
#![allow(clippy::unwrap_used, dead_code)]

use std::collections::BTreeMap;
use std::io::Cursor;

use mcap::records::MessageHeader;

pub const T0: u64 = 1_700_000_000_000_000_000;

/// Messages as a recorder hands them to the crate: topic, schema, encoding of messages, log time and data.
pub struct Recorder {
    pub writer: mcap::Writer<Cursor<Vec<u8>>>,
}

impl Recorder {
    pub fn new(options: mcap::WriteOptions) -> Self {
        Self { writer: options.create(Cursor::new(vec![])).unwrap() }
    }

    pub fn plain() -> Self {
        Self::new(mcap::WriteOptions::new().compression(None))
    }

    pub fn channel(&mut self, topic: &str, schema: (&str, &str, &[u8]), encoding: &str) -> u16 {
        let (name, kind, data) = schema;
        let schema = if name.is_empty() { 0 } else { self.writer.add_schema(name, kind, data).unwrap() };
        self.writer.add_channel(schema, topic, encoding, &BTreeMap::new()).unwrap()
    }

    pub fn send(&mut self, channel_id: u16, ns: u64, data: &[u8]) {
        let log_time = T0 + ns;
        let head = MessageHeader { channel_id, sequence: 0, log_time, publish_time: log_time };
        self.writer.write_to_known_channel(&head, data).unwrap();
    }

    pub fn bytes(mut self) -> Vec<u8> {
        self.writer.finish().unwrap();
        self.writer.into_inner().into_inner()
    }
}

macro_rules! with_header {
    ($fields:literal) => {
        concat!(
            "std_msgs/Header header\n",
            $fields,
            "\n================================================================================\nMSG: std_msgs/Header\n",
            "builtin_interfaces/Time stamp\nstring frame_id\n",
            "================================================================================\n",
            "MSG: builtin_interfaces/Time\nint32 sec\nuint32 nanosec\n"
        )
    };
}

/// `sensor_msgs/msg/Image`.
pub const IMAGE: &str =
    with_header!("uint32 height\nuint32 width\nstring encoding\nuint8 is_bigendian\nuint32 step\nuint8[] data");

/// `sensor_msgs/msg/CompressedImage`.
pub const COMPRESSED: &str = with_header!("string format\nuint8[] data");

/// A message of either, stamped a second of the recording and 5 ns, with the fields behind its header.
pub fn picture(second: u32, rest: &[u8]) -> Vec<u8> {
    let stamp = [(1_700_000_000 + second).to_le_bytes(), 5_u32.to_le_bytes()].concat();
    [&[0, 1, 0, 0][..], &stamp, &4_u32.to_le_bytes(), b"cam\0", rest].concat()
}
