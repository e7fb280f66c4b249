//! What every reader must do with any bytes: no panic, and the same answer whether columns are kept or only looked at.

use pneuval_ingest::formats::{self, Format, Options};
use pneuval_ingest::raw::RawFile;
use pneuval_ingest::recording::Keep;

/// Reads bytes in a format, with every column kept and with none.
///
/// # Panics
/// If the two readings differ in anything but the cells: that is what the fuzzer looks for.
pub fn read(format: Format, bytes: &[u8]) {
    let raw = RawFile::of_bytes("fuzz", bytes);
    let options = Options { format: Some(format), ..Options::default() };
    let kept = formats::read(&raw, &options, Keep::All);
    let looked_at = formats::read(&raw, &options, Keep::Nothing);
    match (kept, looked_at) {
        (Ok(kept), Ok(looked_at)) => {
            assert_eq!(format!("{:?}", kept.findings), format!("{:?}", looked_at.findings));
            assert_eq!(kept.tables.len(), looked_at.tables.len());
            for (a, b) in kept.tables.iter().zip(&looked_at.tables) {
                assert_eq!((&a.name, a.rows), (&b.name, b.rows));
                for column in &a.columns {
                    assert_eq!(column.cells.len(), a.rows, "{}", column.name);
                }
            }
        }
        (Err(kept), Err(looked_at)) => assert_eq!(kept.to_string(), looked_at.to_string()),
        (kept, looked_at) => panic!("kept {:?}, looked at {:?}", kept.is_ok(), looked_at.is_ok()),
    }
}

/// Reads bytes in whatever format they seem to be.
pub fn read_any(bytes: &[u8]) {
    let raw = RawFile::of_bytes("fuzz", bytes);
    let _ = formats::read(&raw, &Options::default(), Keep::Nothing);
}
