//! Formats that are known by their first bytes and not read: an error with the command that converts them.

use crate::error::{IngestError, Place};

/// The command that turns bags in `SQLite` into MCAP; the folder is that of the `.db3` file.
pub(super) const CONVERT_BAG: &str = "convert it where ROS 2 is installed: write `output_bags: [{uri: converted, storage_id: mcap, all_topics: true}]` to a file \
     `mcap.yaml`, run `ros2 bag convert -i FOLDER -o mcap.yaml` and read the folder `converted`";

/// What a file is whose first bytes are those of a format that is not read.
pub(super) fn recognise(name: &str, head: &[u8]) -> Option<IngestError> {
    let at = |offset: usize, bytes: &[u8]| head.get(offset..).is_some_and(|head| head.starts_with(bytes));
    let film = "extract what you measure as a table, or its frames as pictures: `ffmpeg -i FILM frame%05d.png`";
    let (what, next) = if at(0, b"SQLite format 3\0") {
        ("an SQLite database, as ROS 2 stores bags in `.db3` files", CONVERT_BAG)
    } else if at(0, b"#ROSBAG V") {
        (
            "a bag of ROS 1",
            "convert it: `mcap convert IN.bag OUT.mcap` gives messages in `ros1`, `rosbags-convert --src IN.bag --dst OUT` those of ROS 2",
        )
    } else if at(0, b"\x28\xb5\x2f\xfd") {
        ("a file compressed by zstd", "decompress it: `zstd -d FILE`")
    } else if at(0, b"\x1f\x8b") {
        ("a file compressed by gzip", "decompress it: `gunzip FILE`")
    } else if at(0, b"PK\x03\x04") {
        (
            "a zip archive or an Excel workbook",
            "save the sheet as CSV: `libreoffice --headless --convert-to csv FILE.xlsx`, or unpack the archive",
        )
    } else if at(0, b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1") {
        ("an old Excel workbook", "save the sheet as CSV: `libreoffice --headless --convert-to csv FILE.xls`")
    } else if at(4, b"ftyp") {
        ("a film (MP4 or MOV)", film)
    } else if at(0, b"RIFF") && at(8, b"AVI ") {
        ("a film (AVI)", film)
    } else if at(0, b"\x1a\x45\xdf\xa3") {
        ("a film (Matroska or WebM)", film)
    } else {
        return None;
    };
    Some(IngestError::Unusable {
        place: Place::new(name, None, None),
        expected: "a log: delimited text or an MCAP file".to_owned(),
        found: what.to_owned(),
        next: next.to_owned(),
    })
}

#[cfg(test)]
mod tests {
    use super::recognise;

    #[test]
    fn what_is_not_read_names_its_conversion() {
        for (head, next) in [
            (&b"SQLite format 3\0\x10\0"[..], "ros2 bag convert"),
            (b"#ROSBAG V2.0\n", "mcap convert"),
            (b"\x28\xb5\x2f\xfd\0", "zstd -d"),
            (b"PK\x03\x04\x14\0", "--convert-to csv"),
            (b"\0\0\0\x20ftypisom", "ffmpeg"),
            (b"RIFF\0\0\0\0AVI LIST", "ffmpeg"),
        ] {
            let error = recognise("f", head).map(|error| error.to_string()).unwrap_or_default();
            assert!(error.contains(next), "{error}");
        }
        assert!(recognise("f", b"0.1,0.2\n").is_none() && recognise("f", b"").is_none());
    }
}
