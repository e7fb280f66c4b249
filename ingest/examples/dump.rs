//! Prints what is read from raw files, one line of JSON for each column, for comparison with other readers:
//! `cargo run --release -p pneuval-ingest --example dump -- FILE..`.

// A tool for those who work on the readers: a panic is its error message.
#![allow(clippy::unwrap_used)]

use std::io::{BufWriter, Write};

use pneuval_ingest::formats::{self, Options};
use pneuval_ingest::raw::RawFile;
use pneuval_ingest::recording::{Cells, Keep};
use serde_json::json;

fn main() {
    let mut out = BufWriter::new(std::io::stdout().lock());
    for path in std::env::args().skip(1) {
        let raw = RawFile::open(path.as_ref(), &path, u64::MAX).unwrap();
        let recording = match formats::read(&raw, &Options::default(), Keep::All) {
            Ok(recording) => recording,
            Err(error) => {
                writeln!(out, "{}", json!({"file": path, "error": error.to_string()})).unwrap();
                continue;
            }
        };
        let findings: Vec<_> = recording.findings.iter().map(|f| (f.severity.id(), f.kind.id(), &f.text)).collect();
        writeln!(out, "{}", json!({"file": path, "origin": recording.origin, "findings": findings})).unwrap();
        for table in &recording.tables {
            for column in &table.columns {
                let (numbers, text) = match &column.cells {
                    // What is no number becomes null.
                    Cells::Numbers(numbers) => (Some(numbers), None),
                    Cells::Text(text) => (None, Some(text)),
                    Cells::NotKept => (None, None),
                };
                let line = json!({
                    "file": path, "table": table.name, "column": column.name, "unit": column.unit, "rows": table.rows,
                    "numbers": numbers, "text": text,
                });
                writeln!(out, "{line}").unwrap();
            }
        }
    }
}
