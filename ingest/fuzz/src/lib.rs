//! What every reader must do with any bytes: no panic, and the same answer whether columns are kept or only looked at.

use pneuval_ingest::camera::task::{Setup, Task};
use pneuval_ingest::finding::FindingKind;
use pneuval_ingest::formats::{self, Format, Options};
use pneuval_ingest::raw::RawFile;
use pneuval_ingest::recording::{Keep, Recording};

/// Reads bytes in a format, with every column kept and with none.
///
/// # Panics
/// If the two readings differ in anything but the cells: that is what the fuzzer looks for.
pub fn read(format: Format, bytes: &[u8]) {
    check(&RawFile::of_bytes("fuzz", bytes), Some(format));
}

/// Reads bytes in whatever format they seem to be.
///
/// # Panics
/// As [`read`].
pub fn read_any(bytes: &[u8]) {
    check(&RawFile::of_bytes("fuzz", bytes), None);
}

/// Parts the files of a folder in an input of [`read_folder`]; the first line behind it is the name of the file.
pub const FILE: &[u8] = b"\n%%file ";

/// Reads bytes as a folder of several files.
///
/// # Panics
/// As [`read`].
pub fn read_folder(bytes: &[u8]) {
    let files: Vec<(String, &[u8])> = parted(bytes, FILE)
        .into_iter()
        .map(|file| {
            let end = file.iter().position(|byte| *byte == b'\n').unwrap_or(file.len());
            let name = String::from_utf8_lossy(&file[..end]).replace('/', "_");
            (name, file.get(end + 1..).unwrap_or_default())
        })
        .collect();
    let files: Vec<(&str, &[u8])> = files.iter().map(|(name, bytes)| (name.as_str(), *bytes)).collect();
    check(&RawFile::of_files("fuzz", &files), None);
}

/// Parts schema and messages in an input of [`read_messages`].
pub const MESSAGE: &[u8] = b"%%";

/// Reads messages of one topic: the first byte says how they are encoded, then stand the definition and the messages.
///
/// The records around them are right, so that what is tried out is what a message can hold.
///
/// # Panics
/// As [`read`].
pub fn read_messages(bytes: &[u8]) {
    let Some((kind, rest)) = bytes.split_first() else { return };
    let (schema_encoding, encoding) = match kind {
        b'j' => ("jsonschema", "json"),
        b'p' => ("protobuf", "protobuf"),
        _ => ("ros2msg", "cdr"),
    };
    let parts = parted(rest, MESSAGE);
    let Some((schema, messages)) = parts.split_first() else { return };
    let mut file = b"\x89MCAP0\r\n".to_vec();
    record(&mut file, 1, &[&text(b"ros2"), &text(b"")]);
    record(&mut file, 3, &[&[1, 0], &text(b"pkg.T"), &text(schema_encoding.as_bytes()), &text(schema)]);
    record(&mut file, 4, &[&[1, 0], &[1, 0], &text(b"/t"), &text(encoding.as_bytes()), &[0; 4]]);
    for (index, message) in (0_u64..).zip(messages) {
        let ns = (1_700_000_000_000_000_000 + index * 1_000_000).to_le_bytes();
        record(&mut file, 5, &[&[1, 0], &[0; 4], &ns, &ns, message]);
    }
    record(&mut file, 15, &[&[0; 4]]);
    record(&mut file, 2, &[&[0; 20]]);
    file.extend(b"\x89MCAP0\r\n");
    read(Format::Mcap, &file);
}

fn text(bytes: &[u8]) -> Vec<u8> {
    [&(bytes.len() as u32).to_le_bytes(), bytes].concat()
}

fn record(file: &mut Vec<u8>, opcode: u8, fields: &[&[u8]]) {
    let body = fields.concat();
    file.push(opcode);
    file.extend((body.len() as u64).to_le_bytes());
    file.extend(body);
}

fn parted<'a>(bytes: &'a [u8], sign: &[u8]) -> Vec<&'a [u8]> {
    let (mut parts, mut from, mut at) = (vec![], 0, 0);
    while at < bytes.len() {
        if bytes[at..].starts_with(sign) {
            parts.push(&bytes[from..at]);
            at += sign.len();
            from = at;
        } else {
            at += 1;
        }
    }
    parts.push(&bytes[from..]);
    parts
}

fn check(raw: &RawFile, format: Option<Format>) {
    let mut options = Options { format, ..Options::default() };
    if format == Some(Format::Pictures) {
        options.pictures.task = Some(Task::Diameter(Setup::default()));
    }
    let kept = formats::read(raw, &options, Keep::All);
    let looked_at = formats::read(raw, &options, Keep::Nothing);
    match (kept, looked_at) {
        (Ok(kept), Ok(looked_at)) => {
            assert_same_findings(&kept, &looked_at);
            assert_eq!(kept.tables.len(), looked_at.tables.len());
            for (a, b) in kept.tables.iter().zip(&looked_at.tables) {
                assert_eq!((&a.name, a.rows), (&b.name, b.rows));
                assert_eq!(a.columns.len(), b.columns.len());
                for (kept, looked_at) in a.columns.iter().zip(&b.columns) {
                    assert_eq!(kept.name, looked_at.name);
                    assert_eq!(kept.cells.len(), a.rows, "{}", kept.name);
                }
            }
        }
        (Err(kept), Err(looked_at)) => assert_eq!(kept.to_string(), looked_at.to_string()),
        (kept, looked_at) => panic!("kept {:?}, looked at {:?}", kept.is_ok(), looked_at.is_ok()),
    }
}

/// Dates and times of day are read from the words of a column, so only where these are kept: what is odd about them is told behind all
/// else, and only there.
fn assert_same_findings(kept: &Recording, looked_at: &Recording) {
    use FindingKind::{AmbiguousDate, ClockWrap, EmptyCell, NonNumericCell};
    let common = kept.findings.len().min(looked_at.findings.len());
    let (common, of_stamps) = kept.findings.split_at(common);
    assert_eq!(format!("{common:?}"), format!("{:?}", looked_at.findings));
    for finding in of_stamps {
        let is_of_stamps = !["MCAP", "TDMS"].contains(&kept.format)
            && matches!(finding.kind, AmbiguousDate | ClockWrap | EmptyCell | NonNumericCell)
            && finding.channel.is_some();
        assert!(is_of_stamps, "{finding:?}");
    }
}
