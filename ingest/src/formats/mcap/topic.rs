//! A topic: what its messages are, and the rows they become.

use std::rc::Rc;

use super::cdr::{self, Bad, Frames, Target};
use super::columns::{Budget, Columns};
use super::fields::MessageHead;
use super::plan::Plan;
use super::{json, protobuf};
use crate::finding::places::Places;
use crate::formats::stamps::rfc3339_second;
use crate::recording::Keep;

/// A message definition.
#[derive(Debug, PartialEq, Eq)]
pub(super) struct Schema {
    pub name: String,
    pub encoding: String,
    pub data: Vec<u8>,
}

/// Where stamps count from.
#[derive(Debug, Clone, Copy)]
pub(super) struct Origin {
    pub ns: u64,
}

impl Origin {
    /// The whole second of an instant.
    pub fn of(log_time: u64) -> Self {
        Self { ns: log_time / 1_000_000_000 * 1_000_000_000 }
    }

    pub fn seconds(self) -> i64 {
        (self.ns / 1_000_000_000).cast_signed()
    }

    /// As a date.
    pub fn date(self) -> String {
        rfc3339_second(self.seconds(), true)
    }

    /// An instant in s: the difference is taken between whole nanoseconds.
    #[inline]
    pub fn since(self, ns: u64) -> f64 {
        if ns >= self.ns { (ns - self.ns) as f64 / 1e9 } else { -((self.ns - ns) as f64 / 1e9) }
    }
}

#[derive(Debug)]
enum Decoder {
    /// No message yet.
    Open,
    Cdr(Box<Plan>),
    Json,
    Protobuf(Box<protobuf::Descriptors>),
    /// Why its messages cannot be used.
    None(String),
}

#[derive(Debug)]
pub(super) struct Topic {
    pub name: String,
    pub schema: Option<Rc<Schema>>,
    pub encoding: String,
    pub columns: Columns,
    pub frames: Frames,
    /// Messages that cannot be decoded.
    pub bads: Places,
    /// Messages with bytes behind their last field.
    pub trailing: usize,
    decoder: Decoder,
    path: String,
}

impl Topic {
    /// `None` if the recording has too many columns already.
    pub fn new(
        name: String,
        schema: Option<Rc<Schema>>,
        encoding: String,
        keep: Keep,
        budget: &mut Budget,
    ) -> Option<Self> {
        let columns = Columns::new(&name, keep, budget)?;
        let (frames, bads, path) = (Frames::default(), Places::default(), String::new());
        Some(Self { name, schema, encoding, columns, frames, bads, trailing: 0, decoder: Decoder::Open, path })
    }

    /// Adds a message.
    #[inline]
    pub fn add(&mut self, head: MessageHead, data: &[u8], origin: Origin, keep: Keep, budget: &mut Budget) {
        if matches!(self.decoder, Decoder::Open) {
            self.open(keep, budget);
        }
        let Self { columns, frames, decoder, path, .. } = self;
        let mut target = Target { columns, keep, budget, frames, origin_s: origin.seconds() };
        let done = match decoder {
            Decoder::Cdr(plan) => cdr::decode(plan, data, &mut target),
            Decoder::Json => json::decode(data, path, &mut target),
            Decoder::Protobuf(descriptor) => protobuf::decode(descriptor, data, path, &mut target),
            Decoder::Open | Decoder::None(_) => Ok(false),
        };
        match done {
            Ok(trailing) => self.trailing += usize::from(trailing),
            Err(bad) => self.bad(bad),
        }
        self.columns.commit(origin.since(head.log_time), origin.since(head.publish_time), budget);
    }

    #[cold]
    fn bad(&mut self, bad: Bad) {
        self.columns.spoil();
        let row = self.columns.rows();
        self.bads.add_worded(row, 0, || format!("sample {row} {}", bad.sentence()));
    }

    /// Finds out how its messages are decoded; also for a topic without any, whose columns are known all the same.
    pub fn open(&mut self, keep: Keep, budget: &mut Budget) {
        if !matches!(self.decoder, Decoder::Open) {
            return;
        }
        let columns = &mut self.columns;
        let schema = self.schema.as_deref();
        let text = |schema: &Schema| match std::str::from_utf8(&schema.data) {
            Ok(text) => Ok(text.to_owned()),
            Err(_) => Err("its definition is not text".to_owned()),
        };
        let made = match (self.encoding.as_str(), schema.map(|s| s.encoding.as_str()), schema) {
            ("cdr", Some("ros2msg"), Some(schema)) => text(schema)
                .and_then(|text| Plan::new(&schema.name, &text, columns, keep, budget))
                .map(|plan| Decoder::Cdr(Box::new(plan)))
                .map_err(|why| format!("its definition cannot be used: {why}")),
            ("cdr", Some(other), _) => {
                Err(format!("its definition is in {}; `ros2msg` is read", crate::error::shown(other)))
            }
            ("cdr", ..) => Err("no definition of its messages is in the file".to_owned()),
            ("json", ..) => Ok(Decoder::Json),
            ("protobuf", Some("protobuf"), Some(schema)) => {
                protobuf::Descriptors::parse(&schema.name, &schema.data).map(Box::new).map(Decoder::Protobuf)
            }
            ("protobuf", ..) => Err("no descriptor of its messages is in the file".to_owned()),
            (other, ..) => {
                let other = crate::error::shown(other);
                Err(format!("its messages are in {other}; `cdr`, `json` and `protobuf` are read"))
            }
        };
        self.decoder = made.unwrap_or_else(|why| {
            // Columns of fields that were understood before one was not.
            self.columns.forget();
            Decoder::None(why)
        });
    }

    /// Why its messages cannot be used.
    pub fn unreadable(&self) -> Option<&str> {
        match &self.decoder {
            Decoder::None(why) => Some(why),
            _ => None,
        }
    }
}
