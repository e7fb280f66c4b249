//! TDMS: what LabVIEW and NI's drivers stream to.

#[cfg_attr(not(test), expect(dead_code, reason = "the reader is not here yet"))]
mod scaling;
mod value;
mod write;

pub use value::{Properties, Timestamp, Value};
pub use write::{Metadata, Number, UNTITLED, WriteOptions, write, write_index};
