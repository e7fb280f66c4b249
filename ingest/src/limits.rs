//! Sizes are checked before memory is asked for.

use std::fs::File;
use std::io::Read;
use std::path::Path;

use crate::IngestError;

/// A manifest or a published table: text that people write.
pub const WRITTEN_BYTES_MAX: u64 = 16 << 20;

/// Rows of a published table: print ends long before.
pub const TABLE_ROWS_MAX: usize = 10_000;

/// Columns of a published table.
pub const TABLE_COLUMNS_MAX: usize = 1_000;

/// Stored results.
pub const RESULTS_BYTES_MAX: u64 = 1 << 30;

/// A raw log: hours of several channels at 1 kHz.
pub const LOG_BYTES_MAX: u64 = 4 << 30;

/// Channels of a raw log.
pub const LOG_COLUMNS_MAX: usize = 4_096;

/// Cells of a raw log, 8 bytes each: short lines under a wide header would ask for far more memory than the file is long.
pub const LOG_CELLS_MAX: usize = 1 << 28;

/// A line of a raw log.
pub const LINE_BYTES_MAX: usize = 1 << 20;

/// The file of a picture.
pub const PICTURE_BYTES_MAX: u64 = 512 << 20;

/// A record of an MCAP file that stands outside of chunks, or a chunk as it is stored: larger than the largest picture.
pub const MCAP_RECORD_BYTES_MAX: u64 = 128 << 20;

/// A chunk of an MCAP file, decompressed. Writers make them of about 1 MB.
pub const MCAP_CHUNK_BYTES_MAX: u64 = 128 << 20;

/// A message definition in an MCAP file, with all it refers to.
pub const MCAP_SCHEMA_BYTES_MAX: u64 = 4 << 20;

/// Elements of an array or sequence that become columns.
pub const ARRAY_COLUMNS_MAX: usize = 256;

/// Bytes of a byte array that become columns: beyond it is a picture or a packet, not a signal.
pub const BYTE_COLUMNS_MAX: usize = 16;

/// Bytes of a text that is kept as a cell.
pub const TEXT_BYTES_MAX: usize = 256;

/// The metadata of a segment of a TDMS file: some thousands of channels with all their properties.
pub const TDMS_METADATA_BYTES_MAX: u64 = 64 << 20;

/// Groups and channels of a TDMS file; of the channels [`LOG_COLUMNS_MAX`] have values.
pub const TDMS_OBJECTS_MAX: usize = 1 << 16;

/// Properties of a TDMS file in memory.
pub const TDMS_PROPERTIES_BYTES_MAX: usize = 64 << 20;

/// Texts of a channel in a chunk of a TDMS file.
pub const TDMS_TEXTS_BYTES_MAX: u64 = 64 << 20;

/// Raw buffers of a segment of a TDMS file: a DAQ card has one.
pub const TDMS_BUFFERS_MAX: usize = 1_024;

/// Scales of a channel of a TDMS file, and scalers of a DAQ card that it may take.
pub const TDMS_SCALES_MAX: usize = 256;

/// Numbers in the tables and polynomials that scale a channel of a TDMS file. A group states them once for all its channels.
pub const TDMS_SCALE_NUMBERS_MAX: usize = 1 << 13;

/// Messages within messages.
pub const NESTING_MAX: usize = 32;

/// Steps to decode a message: definitions that refer to each other could ask for any number.
pub const DECODE_STEPS_MAX: usize = 1 << 16;

/// Holes that stand for elements which shorter sequences do not have.
pub const PADDING_CELLS_MAX: usize = 1 << 27;

/// Files of a folder that is read as one.
pub const FOLDER_FILES_MAX: usize = 10_000;

/// A whole file, if it is not larger than the limit.
///
/// # Errors
/// [`IngestError::Read`] if it cannot be read, [`IngestError::TooLarge`] if it is too large, also if it grows while it is read.
pub fn read(path: &Path, limit: u64) -> Result<Vec<u8>, IngestError> {
    let failed = |source| IngestError::read(path, source);
    // Before it is opened: opening a pipe waits for whoever writes to it.
    if !std::fs::metadata(path).map_err(failed)?.is_file() {
        return Err(failed(std::io::Error::other("it is not a file")));
    }
    let file = File::open(path).map_err(failed)?;
    let size = file.metadata().map_err(failed)?.len();
    let too_large = |bytes| IngestError::TooLarge { path: path.to_owned(), bytes, limit };
    if size > limit {
        return Err(too_large(size));
    }
    let mut bytes = Vec::new();
    // One byte more than allowed is enough to see that it grew.
    file.take(limit + 1).read_to_end(&mut bytes).map_err(failed)?;
    if bytes.len() as u64 > limit { Err(too_large(bytes.len() as u64)) } else { Ok(bytes) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_over_the_limit_is_not_read() {
        let file = tempfile::NamedTempFile::new().unwrap();
        std::fs::write(file.path(), [0; 10]).unwrap();
        assert_eq!(read(file.path(), 10).unwrap().len(), 10);
        assert!(matches!(read(file.path(), 9), Err(IngestError::TooLarge { bytes: 10, limit: 9, .. })));
        assert!(matches!(read(Path::new("/dev/zero"), 100), Err(IngestError::Read { .. })));
    }
}
