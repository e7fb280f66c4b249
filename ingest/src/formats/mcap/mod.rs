//! MCAP: bags of ROS 2, and any other recording in this container whose messages are CDR, JSON or Protobuf.
//!
//! [`read`] goes through the file once, from front to back, and never holds more of it than one chunk: every topic becomes a
//! table, every number of its messages a column called by its path (`wrench.force.z`, `data[3]`). A chunk counts only if its
//! checksum is right; what is cut or damaged is told and the rest is read. The `mcap` crate gives the record types and the writer,
//! and the tests hold this reader against it; the walk over the bytes is our own, because the crate's checks no checksum unless
//! asked and costs twice the time.
//!
//! Stamps are in s from the origin of the recording: the whole second in which its first message was logged. So a double holds
//! them to the nanosecond for a hundred days. 64-bit integers beyond 2^53 become the nearest double.
//!
//! | file | holds |
//! |---|---|
//! | `scan.rs` | bytes to framed records; where a cut file ends |
//! | `fields.rs` | the fields of a record |
//! | `chunk.rs` | decompression and the checksum of a chunk |
//! | `bag.rs` | what the records add up to |
//! | `topic.rs` | the messages of a topic and how they are decoded |
//! | `plan.rs` | message definitions to steps |
//! | `cdr.rs`, `json.rs`, `protobuf.rs` | messages to cells |
//! | `columns.rs` | cells to columns |
//! | `known.rs` | units that ROS messages promise |
//! | `tell.rs` | findings and their sentences |
//! | `rosbag2.rs` | folders of split files |
//! | `frames.rs` | pictures, one at a time |
//! | `records.rs` | every record, for those who look into a file |
//! | `write/` | the writer |

mod bag;
mod cdr;
mod chunk;
mod columns;
mod fields;
mod frames;
mod json;
mod known;
mod plan;
mod protobuf;
mod records;
pub mod rosbag2;
mod scan;
mod tell;
mod topic;
mod write;

use ::mcap::records::op;

pub use frames::{Frame, FrameKind, frames};
pub use records::{RecordAt, records};
pub use write::{Compression, Encoding, WriteOptions, definition, field_name, write};

use serde::Deserialize;

use crate::IngestError;
use crate::error::Place;
use crate::raw::RawFile;
use crate::recording::{Keep, Recording, Table};
use bag::Bag;
use topic::Origin;

/// The column of the times at which messages were written to the file.
pub const LOG_TIME: &str = "log_time";

/// The column of the times at which messages were sent.
pub const PUBLISH_TIME: &str = "publish_time";

/// Fields that are the stamp of a message itself, if they are times.
const HEADER_STAMPS: [&str; 3] = ["header.stamp", "stamp", "timestamp"];

/// Whether a column is one of the times of a message.
fn is_message_stamp(name: &str) -> bool {
    [LOG_TIME, PUBLISH_TIME].contains(&name) || HEADER_STAMPS.contains(&name)
}

/// Which of the times of a message is its clock.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Stamp {
    /// When it was measured, as its header says.
    Header,
    /// When it was sent.
    Publish,
    /// When it was written to the file.
    Log,
}

impl Stamp {
    /// What its column may be called.
    pub fn names(self) -> &'static [&'static str] {
        match self {
            Self::Header => &HEADER_STAMPS,
            Self::Publish => &[PUBLISH_TIME],
            Self::Log => &[LOG_TIME],
        }
    }

    /// The name of its column in a table of a bag; `None` if the messages have no stamp of their own.
    ///
    /// ```
    /// use pneuval_ingest::formats::mcap::{Stamp, WriteOptions, read, write};
    /// use pneuval_ingest::raw::RawFile;
    /// use pneuval_ingest::recording::{Cells, Column, Keep, Table};
    /// # use pneuval_ingest::finding::LineMap;
    /// # use pneuval_ingest::formats::csv::Decimal;
    /// let columns = vec![
    ///     Column::new("log_time", Some("s"), Cells::Numbers(vec![0.25, 0.5])),
    ///     Column::new("data", None, Cells::Numbers(vec![101.0, 102.0])),
    /// ];
    /// let table = Table { name: "/p".into(), schema: None, columns, rows: 2, lines: LineMap::default(), clock: None, decimal: Decimal::Point };
    /// let mut bytes = std::io::Cursor::new(vec![]);
    /// write(&mut bytes, &[table], &WriteOptions::default())?;
    /// let bag = read(&RawFile::of_bytes("p.mcap", bytes.get_ref()), Keep::All)?;
    /// assert_eq!(Stamp::Header.column(&bag.tables[0]), None);
    /// assert_eq!(Stamp::Publish.column(&bag.tables[0]), Some("publish_time"));
    /// assert_eq!(bag.tables[0].column("data").and_then(|c| c.cells.numbers()), Some(&[101.0, 102.0][..]));
    /// # Ok::<(), pneuval_ingest::IngestError>(())
    /// ```
    pub fn column(self, table: &Table) -> Option<&str> {
        let columns = self.names().iter().filter_map(|name| table.column(name));
        columns.into_iter().find(|column| column.unit.as_deref() == Some("s")).map(|column| column.name.as_str())
    }
}

/// Whether a file begins as one of this format.
pub fn is_mcap(head: &[u8]) -> bool {
    head.starts_with(&scan::MAGIC[..5])
}

/// Reads a bag: a file, or a folder as [`rosbag2`] describes it. Of topics and fields that `keep` does not name only the times are looked at.
///
/// # Errors
/// [`IngestError::Unusable`] if it is no MCAP file, if no channel in it can be read, and for sizes beyond [`crate::limits`];
/// [`IngestError::Read`] if it cannot be read.
pub fn read(raw: &RawFile, keep: Keep) -> Result<Recording, IngestError> {
    if raw.parts().is_some() {
        return rosbag2::read(raw, keep);
    }
    let mut bag = Bag::new(keep);
    bag.read(raw)?;
    bag.finish(raw)
}

/// The clock of a table, and why, where it is not its header's.
fn clock_of(table: &Table, origin: Option<Origin>) -> (Option<usize>, Option<String>) {
    let position = |name: &str| table.columns.iter().position(|c| c.name == name);
    let publish = position(PUBLISH_TIME);
    let Some(header) = Stamp::Header.column(table).and_then(position) else { return (publish, None) };
    // A stamp that nobody set is that of 1970.
    let unset = origin.map(|origin| -(origin.seconds() as f64));
    let range = table.columns.get(header).and_then(|column| column.summary.range);
    if range.is_some() && range == unset.map(|unset| (unset, unset)) && unset != Some(0.0) {
        let name = crate::error::shown(&table.name);
        return (
            publish,
            Some(format!("topic {name}: its header stamps were never set, so its clock is the publish time")),
        );
    }
    (Some(header), None)
}

fn no_magic(raw: &RawFile) -> IngestError {
    IngestError::Unusable {
        place: Place::new(raw.name(), None, None),
        expected: "an MCAP file, which begins with the bytes 89 4d 43 41 50 30 0d 0a".to_owned(),
        found: if raw.is_empty() { "an empty file".to_owned() } else { "other bytes".to_owned() },
        next: "is this the file you meant? `mcap doctor` tells more about a damaged one".to_owned(),
    }
}

/// What a record is called.
fn record_name(opcode: u8) -> String {
    let name = match opcode {
        op::HEADER => "header",
        op::FOOTER => "footer",
        op::SCHEMA => "schema",
        op::CHANNEL => "channel",
        op::MESSAGE => "message",
        op::CHUNK => "chunk",
        op::MESSAGE_INDEX => "message index",
        op::CHUNK_INDEX => "chunk index",
        op::ATTACHMENT => "attachment",
        op::ATTACHMENT_INDEX => "attachment index",
        op::STATISTICS => "statistics record",
        op::METADATA => "metadata record",
        op::METADATA_INDEX => "metadata index",
        op::SUMMARY_OFFSET => "summary offset",
        op::DATA_END => "end of data",
        other => return format!("record of kind {other:#04x}"),
    };
    name.to_owned()
}
