//! Raw logs as instruments write them: one reader per format, its writer beside it.
//!
//! A reader keeps every sample where it stood, turns what is no number into a hole, and tells each such place as a
//! [`Finding`](crate::finding::Finding). It never repairs and never interpolates.
//!
//! [`read`] finds out the format from the first bytes and gives a [`Recording`], whatever the format. It reads in one pass, or two
//! where the first lines mislead, in memory for the columns that are kept and a bounded rest.

pub mod csv;
mod foreign;
pub mod mcap;

use crate::IngestError;
use crate::raw::RawFile;
use crate::recording::{Keep, Recording};
use csv::CsvOptions;

/// What is known about a raw file beforehand; what is absent is found out from the bytes.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Options {
    /// Its format.
    pub format: Option<Format>,
    /// How delimited text is laid out.
    pub csv: CsvOptions,
}

/// The format of a raw file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Format {
    /// A bag of ROS 2 or another recording in an MCAP file, or a folder of such files.
    Mcap,
    /// Delimited text: one sample a line.
    Csv,
}

impl Format {
    /// All formats, in the order in which they are tried.
    pub const ALL: [Self; 2] = [Self::Mcap, Self::Csv];

    /// Its word in manifests.
    pub fn id(self) -> &'static str {
        match self {
            Self::Mcap => "mcap",
            Self::Csv => "csv",
        }
    }
}

/// Bytes that tell one format from another.
const HEAD_BYTES: u64 = 64;

/// Finds out the format of a raw file from its first bytes.
///
/// # Errors
/// [`IngestError::Read`] if it cannot be read; [`IngestError::Unusable`] for a format that is known and not read, with the command
/// that converts it.
pub fn detect(raw: &RawFile) -> Result<Format, IngestError> {
    if raw.parts().is_some() {
        return Ok(Format::Mcap);
    }
    let head = raw.head(HEAD_BYTES)?;
    if mcap::is_mcap(&head) {
        return Ok(Format::Mcap);
    }
    match foreign::recognise(raw.name(), &head) {
        Some(error) => Err(error),
        None => Ok(Format::Csv),
    }
}

/// Reads a raw file.
///
/// # Errors
/// As [`detect`] and the readers of the formats.
pub fn read(raw: &RawFile, options: &Options, keep: Keep) -> Result<Recording, IngestError> {
    match options.format.map_or_else(|| detect(raw), Ok)? {
        Format::Mcap => mcap::read(raw, keep),
        Format::Csv => csv::read_raw(raw, &options.csv, keep),
    }
}
