//! Files of known formats that are not read here: what they are, told by their first bytes, and the command that converts them.

use crate::IngestError;
use crate::error::Place;
use crate::raw::RawFile;

/// Bytes that are looked at: the longest mark stands behind the 512 bytes before an HDF5 file in a `.mat`.
const HEAD_BYTES: u64 = 4096;

/// The command that turns bags in `SQLite` into MCAP; the folder is that of the `.db3` file.
pub(super) const CONVERT_BAG: &str = "convert it where ROS 2 is installed: write `output_bags: [{uri: converted, storage_id: mcap, all: true}]` to a file \
     `mcap.yaml`, run `ros2 bag convert -i FOLDER -o mcap.yaml` and read the folder `converted`";

/// Refuses a file of a known format that is not read, with the command that converts it.
///
/// ```
/// use pneuval_ingest::{formats::foreign, raw::RawFile};
/// let video = RawFile::of_bytes("side view.mp4", b"\0\0\0\x18ftypmp42\0\0\0\0");
/// let error = foreign::check(&video).unwrap_err().to_string();
/// assert!(error.contains("ffmpeg -i 'side view.mp4' frame_%06d.png"));
/// ```
///
/// # Errors
/// [`IngestError::Unusable`] for such a file; [`IngestError::Read`] if it cannot be read.
pub fn check(raw: &RawFile) -> Result<(), IngestError> {
    let head = raw.head(HEAD_BYTES)?;
    let Some((what, next)) = known(&head, raw.name()) else { return Ok(()) };
    Err(IngestError::Unusable {
        place: Place::new(raw.name(), None, None),
        expected: "a log in a format that is read".to_owned(),
        found: what.to_owned(),
        next,
    })
}

/// What a file is and what to do about it.
fn known(head: &[u8], name: &str) -> Option<(&'static str, String)> {
    let file = quoted(name);
    let stem = name.rsplit(['/', '\\']).next().unwrap_or(name);
    let stem = stem.rsplit_once('.').map_or(stem, |(stem, _)| stem);
    let begins = |mark: &[u8]| head.starts_with(mark);
    let at = |offset: usize, mark: &[u8]| head.get(offset..).is_some_and(|rest| rest.starts_with(mark));
    let holds = |mark: &[u8]| head.windows(mark.len()).any(|window| window == mark);
    let unpack = |command: &str| format!("unpack it: {command} {file}");
    Some(if begins(b"SQLite format 3\0") {
        let yaml = format!("output_bags:\\n- uri: {stem}_mcap\\n  storage_id: mcap\\n  all: true\\n");
        let command =
            format!("printf '{}' > convert.yaml && ros2 bag convert -i {file} -o convert.yaml", yaml.replace('\'', ""));
        ("an SQLite database, as ROS 2 bags of the kind `.db3` are", format!("convert it to MCAP: {command}"))
    } else if begins(b"#ROSBAG V") {
        let next = format!("convert it to MCAP: mcap convert {file} {}", quoted(&format!("{stem}.mcap")));
        ("a ROS 1 bag", next)
    } else if at(4, b"ftyp") || [&b"moov"[..], b"mdat", b"wide", b"free"].iter().any(|mark| at(4, mark)) {
        ("a video (MP4 or QuickTime)", video(&file))
    } else if begins(b"RIFF") && at(8, b"AVI ") {
        ("a video (AVI)", video(&file))
    } else if begins(b"\x1a\x45\xdf\xa3") {
        ("a video (Matroska or WebM)", video(&file))
    } else if begins(b"PK\x03\x04") && holds(b"opendocument.spreadsheet") {
        ("a spreadsheet (OpenDocument)", spreadsheet(&file))
    } else if begins(b"PK\x03\x04") && (holds(b"xl/") || holds(b"[Content_Types].xml")) {
        ("a spreadsheet (Excel, .xlsx)", spreadsheet(&file))
    } else if begins(b"PK\x03\x04") || begins(b"PK\x05\x06") {
        ("a ZIP archive", unpack("unzip"))
    } else if begins(b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1") {
        ("an OLE document, as old Excel files (.xls) are", spreadsheet(&file))
    } else if begins(b"MATLAB 5.0 MAT-file") || begins(b"MATLAB 7.3 MAT-file") {
        let next = format!(
            "in MATLAB: S = load('{}'); writetable(struct2table(S), '{}')",
            name.replace('\'', "''"),
            format!("{stem}.csv").replace('\'', "''")
        );
        ("a MATLAB file", next)
    } else if begins(b"\x89HDF\r\n\x1a\n") || at(512, b"\x89HDF\r\n\x1a\n") {
        let next = format!(
            "list its data sets with: h5ls -r {file}, then write one as text with: h5dump -y -w 0 -d /NAME -o {} {file}",
            quoted(&format!("{stem}.csv"))
        );
        ("an HDF5 file", next)
    } else if begins(b"\x1f\x8b") {
        ("a gzip archive", unpack("gunzip -k"))
    } else if begins(b"\x28\xb5\x2f\xfd") {
        ("a Zstandard archive", unpack("unzstd"))
    } else if begins(b"\xfd7zXZ\0") {
        ("an XZ archive", unpack("unxz -k"))
    } else if begins(b"BZh") && at(4, b"1AY&SY") {
        ("a bzip2 archive", unpack("bunzip2 -k"))
    } else if begins(b"\x04\x22\x4d\x18") {
        ("an LZ4 archive", unpack("unlz4"))
    } else if begins(b"7z\xbc\xaf\x27\x1c") {
        ("a 7z archive", unpack("7z x"))
    } else if begins(b"%PDF-") {
        (
            "a PDF document",
            "export the numbers as CSV from the program that wrote it; a printed table: `pdftotext -layout`".to_owned(),
        )
    } else if begins(b"PAR1") {
        let next = format!("convert it: duckdb -c \"COPY (FROM {}) TO {}\"", sql(name), sql(&format!("{stem}.csv")));
        ("a Parquet file", next)
    } else if begins(b"\x93NUMPY") {
        let next = format!(
            "convert it: python3 -c \"import sys, numpy; numpy.savetxt(sys.argv[2], numpy.load(sys.argv[1]), delimiter=',')\" {file} {}",
            quoted(&format!("{stem}.csv"))
        );
        ("a NumPy array", next)
    } else if is_image(head) {
        ("an image", format!("images are measured, not read as logs: pneuval measure diameter {file}"))
    } else {
        return None;
    })
}

fn is_image(head: &[u8]) -> bool {
    let marks: [&[u8]; 6] = [b"\x89PNG\r\n\x1a\n", b"\xff\xd8\xff", b"GIF87a", b"GIF89a", b"II*\0", b"MM\0*"];
    // Two letters are no mark: a log may begin with `BM`. The four zero bytes of a bitmap stand behind its length.
    let bitmap = head.starts_with(b"BM") && head.get(6..10) == Some(&[0; 4]);
    let webp = head.starts_with(b"RIFF") && head.get(8..12) == Some(b"WEBP");
    bitmap || webp || marks.iter().any(|mark| head.starts_with(mark))
}

fn video(file: &str) -> String {
    format!("write its pictures: ffmpeg -i {file} frame_%06d.png")
}

fn spreadsheet(file: &str) -> String {
    format!("save the sheet as CSV, or: libreoffice --headless --convert-to csv {file}")
}

/// A file name as a shell takes it for one word, and no command for an option.
fn quoted(name: &str) -> String {
    let name = if name.starts_with('-') { format!("./{name}") } else { name.to_owned() };
    let plain = |c: char| c.is_alphanumeric() || matches!(c, '/' | '.' | '_' | '-' | '+' | ':' | '@' | ',');
    if !name.is_empty() && name.chars().all(plain) { name } else { format!("'{}'", name.replace('\'', "'\\''")) }
}

fn sql(name: &str) -> String {
    format!("'{}'", name.replace('\'', "''"))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn told(name: &str, head: &[u8]) -> Option<String> {
        check(&RawFile::of_bytes(name, head)).err().map(|error| error.to_string())
    }

    #[test]
    fn every_known_format_is_told_with_its_command() {
        let hdf5_mat = [vec![b' '; 512], b"\x89HDF\r\n\x1a\n".to_vec()].concat();
        for (name, head, what, command) in [
            (
                "bag_0.db3",
                &b"SQLite format 3\0\x10\0"[..],
                "an SQLite database",
                "ros2 bag convert -i bag_0.db3 -o convert.yaml",
            ),
            ("old.bag", b"#ROSBAG V2.0\n", "a ROS 1 bag", "mcap convert old.bag old.mcap"),
            ("a.mov", b"\0\0\0\x14ftypqt  ", "a video (MP4", "ffmpeg -i a.mov frame_%06d.png"),
            ("a.avi", b"RIFF\x01\x02\x03\x04AVI LIST", "a video (AVI)", "ffmpeg -i a.avi frame_%06d.png"),
            ("a.mkv", b"\x1a\x45\xdf\xa3\x01", "a video (Matroska", "ffmpeg -i a.mkv frame_%06d.png"),
            ("a b.xlsx", b"PK\x03\x04\x14\0[Content_Types].xml", "Excel, .xlsx", "--convert-to csv 'a b.xlsx'"),
            (
                "a.ods",
                b"PK\x03\x04..mimetypeapplication/vnd.oasis.opendocument.spreadsheet",
                "OpenDocument",
                "--convert-to csv a.ods",
            ),
            ("a.xls", b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1\0", "old Excel", "--convert-to csv a.xls"),
            ("a.zip", b"PK\x03\x04\x14\0run.csv", "a ZIP archive", "unzip a.zip"),
            ("a.mat", b"MATLAB 5.0 MAT-file, Platform", "a MATLAB file", "load('a.mat')"),
            ("a.h5", b"\x89HDF\r\n\x1a\n", "an HDF5 file", "h5ls -r a.h5"),
            ("b.mat", &hdf5_mat, "an HDF5 file", "h5ls -r b.mat"),
            ("a.csv.gz", b"\x1f\x8b\x08\0", "a gzip archive", "gunzip -k a.csv.gz"),
            ("a.csv.zst", b"\x28\xb5\x2f\xfd\x04", "a Zstandard archive", "unzstd a.csv.zst"),
            ("-x.png", b"\x89PNG\r\n\x1a\n", "an image", "pneuval measure diameter ./-x.png"),
            ("a.pdf", b"%PDF-1.7", "a PDF document", "export the numbers"),
            ("a.parquet", b"PAR1\x15", "a Parquet file", "COPY (FROM 'a.parquet') TO 'a.csv'"),
        ] {
            let told = told(name, head).unwrap_or_else(|| panic!("{name} is not known"));
            assert!(told.starts_with(name) && told.contains(what) && told.contains(command), "{told}");
        }
        assert!(told("b.db3", b"SQLite format 3\0").unwrap().contains("uri: b_mcap\\n  storage_id: mcap"));
    }

    #[test]
    fn text_is_not_foreign() {
        for head in [&b""[..], b"time,p\n0,1\n", b"BM,time\n1,2\n", b"PK,1\n", b"\0\0\0\0\0\0\0\0", b"BZh,1\n"] {
            assert_eq!(told("r.csv", head), None);
        }
    }
}
