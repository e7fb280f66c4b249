//! TDMS: what LabVIEW and NI's drivers stream to.
//!
//! A file is a chain of segments: a lead-in, metadata that say which channels have values and how they stand, and the values. Metadata
//! are incremental: what a segment does not say is as before. [`read`] goes through the file once, from front to back, and holds the
//! columns that are kept and one block of bytes.
//!
//! | what | becomes |
//! |---|---|
//! | group | a table; several where its channels differ in length or in their times |
//! | channel | a column: integers, singles, doubles as doubles (integers beyond 2^53 rounded), booleans 0 and 1, text |
//! | complex channel | two columns, `name.re` and `name.im` |
//! | timestamps | seconds since [`Recording::origin`], the whole second of the first instant of the file; correctly rounded from 2^-64 s |
//! | `wf_start_time`, `wf_start_offset`, `wf_increment` | the column `time`, which is the clock of the table |
//! | channel of a DAQ card | its scaled values; counts where the file states no scale, told as a finding |
//! | properties | metadata lines |
//!
//! Scalings of NI (`NI_Scale[..]`) are computed: linear, polynomial, table, thermistor, strain, sums and differences. A channel whose
//! scaling is not supported or not whole is left out with a finding, refused where it is asked for, and never given as raw numbers. A
//! scale holds for all values of its channel, wherever in the file it is stated; the last one does where it changes, which is a finding.
//!
//! # Times
//!
//! `wf_increment` and `wf_start_offset` are in the unit that `wf_xunit_string` states, s where it states none; the column is in s. What is
//! drawn along another axis, as `Frequency`, is no clock. A beginning or step that is stated anew holds from that sample on, and is told
//! unless the times go on as they were. A clock without a date stands beside dated ones with a finding: its zero is not theirs.
//!
//! # Cuts
//!
//! A file that ends within a segment gives every whole value before that, and the loss is told. What cannot be seen from the bytes: a
//! file that is cut exactly between two segments, and one whose last segment was never closed (as when a program stops), of which nobody
//! knows how much was meant. No checksum covers a TDMS file: flipped bits in values cannot be found, those in metadata mostly are.
//!
//! | file | holds |
//! |---|---|
//! | `stream.rs` | the bytes, front to back |
//! | `metadata.rs` | lead-in and metadata of a segment |
//! | `objects.rs` | what is known of groups and channels so far |
//! | `layout.rs` | how values stand in a segment |
//! | `types.rs`, `value.rs` | types of values and of properties |
//! | `channel.rs` | a channel on its way to columns |
//! | `scaling/` | NI's scalings |
//! | `timing.rs`, `tables.rs` | times, and channels that share them |
//! | `reading.rs`, `take.rs` | the pass from segment to segment, and the values of each |
//! | `tell.rs` | findings and their sentences |
//! | `write/` | the writer |

mod channel;
mod layout;
mod metadata;
mod objects;
mod reading;
mod scaling;
mod stream;
mod tables;
mod take;
mod tell;
mod timing;
mod types;
mod value;
mod write;

pub use value::{Properties, Timestamp, Value};
pub use write::{Metadata, Number, UNTITLED, WriteOptions, write, write_index};

use crate::IngestError;
use crate::error::Place;
use crate::raw::RawFile;
use crate::recording::{Keep, Recording};

/// Whether a file begins as one of this format, or as the index of one.
pub fn is_tdms(head: &[u8]) -> bool {
    head.starts_with(metadata::TAG) || head.starts_with(metadata::INDEX_TAG)
}

/// Reads a file. Values of channels that `keep` does not name are passed over; with [`Keep::Nothing`] all are looked at.
///
/// # Errors
/// [`IngestError::Unusable`] if it is no TDMS file but the index of one or anything else, if its first segment is damaged
/// or of a kind that nobody can read, if no channel in it can be used or one that is asked for cannot, and for sizes beyond
/// [`crate::limits`]; [`IngestError::Read`] if it cannot be read.
pub fn read(raw: &RawFile, keep: Keep) -> Result<Recording, IngestError> {
    let mut pass = reading::read(raw, keep, None)?;
    if pass.is_scaled_late {
        let known = pass.objects;
        pass = reading::read(raw, keep, Some(&known))?;
    }
    tables::recording(raw, pass, keep)
}

fn unusable(raw: &RawFile, expected: &str, found: String, next: &str) -> IngestError {
    IngestError::Unusable {
        place: Place::new(raw.name(), None, None),
        expected: expected.to_owned(),
        found,
        next: next.to_owned(),
    }
}
