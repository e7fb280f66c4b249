//! TDMS: what LabVIEW and NI's drivers stream to.

mod value;

pub use value::{Properties, Timestamp, Value};
