//! Writing TDMS: for rehearsals and for export. Tables become groups, their columns channels.
//!
//! The bytes depend on the tables and the options alone. Nothing is bent to fit: what the layout cannot hold is refused.

mod plan;
mod segment;

use std::collections::BTreeMap;
use std::io::Write;
use std::num::NonZeroUsize;

use super::value::{Properties, Timestamp};
use crate::IngestError;
use crate::recording::Table;
use plan::Plan;
use segment::Form;

/// The group of a table without a name, as LabVIEW calls it.
pub const UNTITLED: &str = "Untitled";

/// How a TDMS file is written. A default one is a single segment of doubles, little endian.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct WriteOptions {
    /// The instant that clocks count from.
    pub origin: Option<Timestamp>,
    /// Rows of each chunk; the whole table if absent.
    pub chunk_rows: Option<NonZeroUsize>,
    /// Chunks of each segment; one if absent. The last segments have fewer, and may be shorter.
    pub segment_chunks: Option<NonZeroUsize>,
    /// Whether the values of a row lie side by side. Each group then has segments of its own.
    pub interleaved: bool,
    /// Whether bytes are ordered as processors of Power Macintosh and real-time targets do.
    pub big_endian: bool,
    /// What segments after the first say of themselves.
    pub metadata: Metadata,
    /// How numbers are stored, by the names of table and column; doubles if absent.
    pub numbers: BTreeMap<(String, String), Number>,
    /// Properties of the file.
    pub file: Properties,
    /// Properties of groups, by the name of the table.
    pub groups: BTreeMap<String, Properties>,
    /// Properties of channels, by the names of table and column.
    pub channels: BTreeMap<(String, String), Properties>,
}

/// What segments after the first say of themselves.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Hash)]
pub enum Metadata {
    /// All objects with all their properties.
    #[default]
    Repeated,
    /// The channels that have data, each "as before" where it is; no properties.
    AsBefore,
    /// The channels that changed, in the list that stands.
    Changes,
    /// Nothing where nothing changed.
    Absent,
}

/// How numbers of a channel are stored.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub enum Number {
    /// As they are.
    #[default]
    Double,
    /// Rounded to singles.
    Single,
    /// As a card with 16 bits measures them, with the scaling that gives them back: `value = slope * count + intercept`, rounded to the
    /// nearest count. A hole, or what is beyond the counts, is refused.
    Counts {
        /// What a count stands for; not 0.
        slope: f64,
        /// The value of count 0.
        intercept: f64,
    },
}

/// Writes tables as groups.
///
/// Numbers are stored as the options say, text as strings, a unit as `unit_string`. A clock in s whose stamps are even, each within
/// two roundings of the largest, is no channel: the others state it as a waveform (`wf_start_offset`, `wf_increment`, with an origin
/// `wf_start_time`). Any other clock in s, and one that the options name, is a channel, of instants if there is an origin, else of numbers. A table without a name is
/// the group [`UNTITLED`]. What a table says of its message type is not written.
///
/// ```
/// use pneuval_ingest::formats::tdms::{WriteOptions, write};
/// use pneuval_ingest::recording::{Cells, Column};
/// # use pneuval_ingest::{finding::LineMap, formats::csv::Decimal, recording::Table};
/// let time = Column::new("t", Some("s"), Cells::Numbers(vec![0.0, 0.5, 1.0]));
/// let pressure = Column::new("p", Some("kPa"), Cells::Numbers(vec![1.0, 2.0, 3.0]));
/// # let columns = vec![time, pressure];
/// # let (name, schema, lines) = ("rig".to_owned(), None, LineMap::default());
/// # let table = Table { name, schema, columns, rows: 3, lines, clock: Some(0), decimal: Decimal::Point };
/// let mut bytes = vec![];
/// write(&mut bytes, &[table], &WriteOptions::default())?;
/// assert!(bytes.starts_with(b"TDSm"));
/// assert!(bytes.ends_with(&[0, 0, 0, 0, 0, 0, 8, 64]), "the last pressure");
/// # Ok::<(), pneuval_ingest::IngestError>(())
/// ```
///
/// # Errors
/// [`IngestError::Malformed`] if a channel would be there twice, cells are not at hand or of another number than the rows, an option
/// names what is not there, a property stands twice or cannot be stored, a number does not fit its type, or an instant is a hole;
/// if text is to be interleaved or put into several chunks of a segment; if one group is to be interleaved and has two lengths.
/// [`IngestError::Write`] if it cannot be written.
pub fn write(out: &mut impl Write, tables: &[Table], options: &WriteOptions) -> Result<(), IngestError> {
    segment::write(out, &Plan::new(tables, options)?, options, Form::Whole)
}

/// Writes the `.tdms_index` that belongs to it: what [`write()`] writes without the values.
///
/// # Errors
/// As [`write()`].
pub fn write_index(out: &mut impl Write, tables: &[Table], options: &WriteOptions) -> Result<(), IngestError> {
    segment::write(out, &Plan::new(tables, options)?, options, Form::Index)
}
