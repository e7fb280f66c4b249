//! TDMS files that LabVIEW, DAQ cards and other programs wrote, against what another reader reads. They are not part of this repository:
//! `PNEUVAL_REFERENCE_DATA` names their folder.

// In a test a panic is how a failure is told; equality of floats is asked where it must be exact.
#![allow(clippy::unwrap_used, clippy::panic, clippy::float_cmp)]

#[path = "common/reference.rs"]
mod reference;

use std::path::Path;

use pneuval_ingest::IngestError;
use pneuval_ingest::finding::Severity;
use pneuval_ingest::formats::stamps;
use pneuval_ingest::formats::{Format, Options, detect, read};
use pneuval_ingest::raw::RawFile;
use pneuval_ingest::recording::{Cells, Column, Keep, Recording};
use reference::files;
use serde_json::Value;

fn open(path: &Path) -> Result<Recording, IngestError> {
    let raw = RawFile::open(path, &path.display().to_string(), u64::MAX)?;
    assert_eq!(detect(&raw)?, Format::Tdms);
    read(&raw, &Options::default(), Keep::All)
}

fn column<'r>(recording: &'r Recording, group: &str, name: &str) -> Option<&'r Column> {
    recording.tables.iter().filter(|table| table.name == group).find_map(|table| table.column(name))
}

/// Whether the first cells of a column are as another reader gives them.
fn check(recording: &Recording, column: &Column, expected: &Value, what: &str) {
    let count = usize::try_from(expected["n"].as_u64().unwrap()).unwrap();
    let first = expected["first64"].as_array().unwrap();
    assert_eq!(first.len(), count.min(64));
    match &column.cells {
        Cells::Text(texts) => {
            assert_eq!(texts.len(), count, "{what}");
            assert!(texts.iter().zip(first).all(|(text, expected)| expected == text), "{what}");
        }
        Cells::Numbers(numbers) => {
            // A channel may be cut shorter than others of its table.
            assert!(
                numbers.len() == count || numbers[count..].iter().all(|n| n.is_nan()),
                "{what}: {count} {numbers:?}"
            );
            for (number, expected) in numbers.iter().zip(first) {
                let expected = match expected {
                    Value::Number(expected) => expected.as_f64().unwrap(),
                    Value::String(word) if word == "True" || word == "False" => f64::from(u8::from(word == "True")),
                    Value::String(instant) => {
                        let origin = recording.origin.clone().unwrap().trim_end_matches('Z').to_owned();
                        stamps::parse(&[origin, instant.clone()]).unwrap().seconds[1]
                    }
                    other => panic!("{what}: {other}"),
                };
                assert!(
                    (number - expected).abs() <= 1e-6 * f64::from(u8::from(column.unit.as_deref() == Some("s"))),
                    "{what}: {number} {expected}"
                );
            }
        }
        Cells::NotKept => assert_eq!(count, 0, "{what}"),
    }
}

#[test]
fn generated_streams_are_read_as_another_reader_reads_them_and_refused_where_it_refuses() {
    let Some(files) = files("tdms/generated", "tdms") else { return };
    assert_eq!(files.len(), 36);
    let (mut refused, mut channels) = (0, 0);
    for path in files {
        let what = path.file_name().unwrap().to_string_lossy().into_owned();
        let expected: Value = serde_json::from_slice(&std::fs::read(path.with_extension("json")).unwrap()).unwrap();
        let recording = open(&path);
        if expected.get("error").is_some() {
            let error = recording.err().unwrap_or_else(|| panic!("{what} is read"));
            assert!(matches!(error, IngestError::Unusable { .. }), "{what}: {error}");
            refused += 1;
            continue;
        }
        let recording = recording.unwrap_or_else(|error| panic!("{what}: {error}"));
        for (group, of_group) in expected["groups"].as_object().unwrap() {
            for (name, expected) in of_group.as_object().unwrap() {
                channels += 1;
                if expected.get("n").is_some() {
                    let column = column(&recording, group, name).unwrap_or_else(|| panic!("{what}: no {name}"));
                    check(&recording, column, expected, &what);
                    continue;
                }
                // Counts of a DAQ card, by scaler.
                let scalers = expected.as_object().unwrap();
                for (id, expected) in scalers {
                    let of_scaler = if scalers.len() == 1 { name.clone() } else { format!("{name}[{id}]") };
                    let column =
                        column(&recording, group, &of_scaler).unwrap_or_else(|| panic!("{what}: no {of_scaler}"));
                    check(&recording, column, expected, &what);
                }
            }
        }
        let is_cut = what.contains("truncated_interleaved");
        let is_lossy = recording.findings.iter().any(|finding| finding.severity == Severity::Lost);
        assert_eq!(is_lossy, is_cut, "{what}: {:?}", recording.findings);
    }
    assert_eq!((refused, channels), (3, 60));
}

#[test]
fn files_of_real_programs() {
    let Some(files) = files("tdms", "tdms") else { return };
    assert_eq!(files.len(), 4);
    for path in files {
        let recording = open(&path).unwrap();
        assert_eq!(recording.findings, [], "{}", path.display());
        let shape: Vec<(usize, usize)> = recording.tables.iter().map(|t| (t.columns.len(), t.rows)).collect();
        let number = |group: &str, name: &str, row: usize| {
            column(&recording, group, name).unwrap_or_else(|| panic!("no {name}")).cells.numbers().unwrap()[row]
        };
        match path.file_name().and_then(|name| name.to_str()).unwrap() {
            "big_endian.tdms" => {
                assert_eq!(shape, [(3, 3500)]);
                assert_eq!(number("Measured Data", "Phase sweep", 2), 0.126_579_862_379_904_1);
                assert_eq!(number("Measured Data", "time", 3499), 3.499);
                assert_eq!(recording.origin, None);
            }
            "raw1.tdms" => {
                // Seven multiplexed channels, whose beginnings differ by less than any stamp can tell.
                assert_eq!(shape, [(8, 2000)]);
                let counts = number("Layer Data", "First  Channel", 0) / 0.000_305_185_094_759_971_9;
                assert!((counts - counts.round()).abs() < 1e-9, "{counts}");
                assert_eq!(recording.origin.as_deref(), Some("2016-12-15T22:35:21Z"));
                assert_eq!(recording.tables[0].columns[1].unit.as_deref(), Some("Volts"));
            }
            "Digital_Input.tdms" => {
                assert_eq!(shape, [(2, 20_000), (2, 400), (2, 8)]);
                assert_eq!(recording.origin.as_deref(), Some("2012-07-09T23:58:24Z"));
                let begin = recording.tables[0].columns[0].cells.numbers().unwrap()[0];
                assert!((begin - 0.593_732).abs() < 1e-6, "{begin}");
            }
            "raw_timestamps.tdms" => {
                assert_eq!(shape, [(2, 128)]);
                // The stored fraction is finer than a microsecond.
                let begin = number("Untitled", "time", 0);
                assert!((begin - 0.068_614).abs() < 1e-6 && begin != 0.068_614, "{begin}");
            }
            other => panic!("{other}"),
        }
    }
}
