//! Raw logs as instruments write them: one reader per format, its writer beside it.
//!
//! A reader keeps every sample where it stood, turns what is no number into a hole, and tells each such place as a
//! [`Finding`](crate::finding::Finding). It never repairs and never interpolates.
//!
//! [`read`] finds out the format from the first bytes and gives a [`Recording`], whatever the format. It reads in one pass, or two
//! where the first lines mislead, in memory for the columns that are kept and a bounded rest.

pub mod csv;
pub mod foreign;
pub mod gauge;
mod lines;
pub mod lvm;
pub mod mcap;
pub mod pictures;
pub mod serial;
mod sheet;
pub mod stamps;
pub mod tdms;
pub mod tracker;
pub mod transposed;

use crate::IngestError;
use crate::raw::RawFile;
use crate::recording::{Keep, Recording};
use csv::CsvOptions;
use pictures::PictureOptions;
use tracker::TrackerOptions;

/// What is known about a raw file beforehand; what is absent is found out from the bytes.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Options {
    /// Its format.
    pub format: Option<Format>,
    /// How delimited text is laid out.
    pub csv: CsvOptions,
    /// What of a tracker's log is used.
    pub tracker: TrackerOptions,
    /// What is measured in pictures.
    pub pictures: PictureOptions,
}

/// The format of a raw file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Format {
    /// A bag of ROS 2 or another recording in an MCAP file, or a folder of such files.
    Mcap,
    /// A photograph, or a folder of them.
    Pictures,
    /// What LabVIEW and NI's drivers stream to, or its index.
    Tdms,
    /// A measurement file of LabVIEW.
    Lvm,
    /// The sequence file of a PLUS toolkit's tracker.
    Plus,
    /// The log of a trakSTAR.
    Trakstar,
    /// One line per quantity.
    Transposed,
    /// The log of a force gauge: values with their unit.
    Gauge,
    /// What a microcontroller wrote to a terminal.
    Serial,
    /// Delimited text: one sample a line.
    Csv,
}

impl Format {
    /// All formats, in the order in which they are tried.
    pub const ALL: [Self; 10] = [
        Self::Mcap,
        Self::Pictures,
        Self::Tdms,
        Self::Lvm,
        Self::Plus,
        Self::Trakstar,
        Self::Transposed,
        Self::Gauge,
        Self::Serial,
        Self::Csv,
    ];

    /// Its word in manifests.
    pub fn id(self) -> &'static str {
        match self {
            Self::Mcap => "mcap",
            Self::Pictures => "pictures",
            Self::Tdms => "tdms",
            Self::Lvm => "lvm",
            Self::Plus => "plus",
            Self::Trakstar => "trakstar",
            Self::Transposed => "transposed",
            Self::Gauge => "gauge",
            Self::Serial => "serial",
            Self::Csv => "csv",
        }
    }
}

/// Bytes from which the format of a text is told.
const HEAD_BYTES: u64 = 64 << 10;

/// The beginning of a text, in UTF-8.
struct TextHead {
    bytes: Vec<u8>,
    /// Whether nothing follows.
    is_whole: bool,
}

fn text_head(raw: &RawFile) -> Result<TextHead, IngestError> {
    let bytes = lines::decoded_head(&raw.head(HEAD_BYTES)?);
    Ok(TextHead { bytes, is_whole: raw.len() <= HEAD_BYTES })
}

/// Finds out the format of a raw file from its first bytes.
///
/// # Errors
/// [`IngestError::Read`] if it cannot be read; [`IngestError::Unusable`] for a format that is known and not read, with the command
/// that converts it.
pub fn detect(raw: &RawFile) -> Result<Format, IngestError> {
    if pictures::looks_like(raw)? {
        return Ok(Format::Pictures);
    }
    if raw.parts().is_some() {
        return Ok(Format::Mcap);
    }
    let head = raw.head(64)?;
    if mcap::is_mcap(&head) {
        return Ok(Format::Mcap);
    }
    if tdms::is_tdms(&head) {
        return Ok(Format::Tdms);
    }
    foreign::check(raw)?;
    let TextHead { bytes, is_whole } = text_head(raw)?;
    let is = |format: &Format| match format {
        Format::Mcap | Format::Pictures | Format::Tdms => false,
        Format::Lvm => lvm::looks_like(&bytes),
        Format::Plus => tracker::plus::looks_like(&bytes),
        Format::Trakstar => tracker::trakstar::looks_like(&bytes, is_whole),
        Format::Transposed => transposed::looks_like(&bytes, is_whole),
        Format::Gauge => gauge::looks_like(&bytes, is_whole),
        Format::Serial => serial::looks_like(&bytes, is_whole),
        Format::Csv => true,
    };
    Ok(Format::ALL.into_iter().find(is).unwrap_or(Format::Csv))
}

/// Reads a raw file.
///
/// # Errors
/// As [`detect`] and the readers of the formats.
pub fn read(raw: &RawFile, options: &Options, keep: Keep) -> Result<Recording, IngestError> {
    let mut recording = match options.format.map_or_else(|| detect(raw), Ok)? {
        Format::Mcap => {
            return pictures::with_topic(raw, mcap::read(raw, keep)?, &options.pictures, keep);
        }
        Format::Pictures => return pictures::read(raw, &options.pictures, keep),
        Format::Tdms => return tdms::read(raw, keep),
        Format::Lvm => lvm::read(raw, keep)?,
        Format::Plus => tracker::plus::read(raw, keep)?,
        Format::Trakstar => tracker::trakstar::read(raw, options.tracker, keep)?,
        Format::Transposed => transposed::read(raw, keep)?,
        Format::Gauge => gauge::read(raw, keep)?,
        Format::Serial => serial::read(raw, keep)?,
        Format::Csv => csv::read_raw(raw, &options.csv, keep)?,
    };
    stamps::with_stamps(raw.name(), &mut recording);
    Ok(recording)
}
