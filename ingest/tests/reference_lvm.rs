//! Measurement files that LabVIEW wrote on other people's rigs. They are not part of this repository: `PNEUVAL_REFERENCE_DATA` names
//! their folder.

// In a test a panic is how a failure is told; equality of floats is asked where it must be exact.
#![allow(clippy::unwrap_used, clippy::panic, clippy::float_cmp)]

#[path = "common/reference.rs"]
mod reference;

use std::path::Path;

use pneuval_ingest::finding::{FindingKind, Severity};
use pneuval_ingest::formats::{Options, read};
use pneuval_ingest::raw::RawFile;
use pneuval_ingest::recording::{Keep, Recording};
use reference::reference;

fn recording(path: &Path) -> Recording {
    let name = path.display().to_string();
    let raw = RawFile::open(path, &name, u64::MAX).unwrap();
    let recording = read(&raw, &Options::default(), Keep::All).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(recording.format, "LabVIEW measurement file", "{name}");
    recording
}

fn column<'r>(recording: &'r Recording, name: &str) -> &'r [f64] {
    recording.tables[0].column(name).unwrap_or_else(|| panic!("no {name}")).cells.numbers().unwrap()
}

fn kinds(recording: &Recording) -> Vec<(FindingKind, Severity)> {
    recording.findings.iter().map(|finding| (finding.kind, finding.severity)).collect()
}

#[test]
fn triggered_impacts_without_x() {
    let Some(folder) = reference("lvm") else { return };
    let recording = recording(&folder.join("short.lvm"));
    let table = &recording.tables[0];
    assert_eq!((recording.tables.len(), table.rows, table.columns.len()), (1, 10, 3));
    let (force, response) = (column(&recording, "Excitation (Trigger)"), column(&recording, "Response (Trigger)"));
    assert_eq!((force[0], force[9], response[0], response[9]), (0.914_018, 0.680_572, 1.204_792, 1.212_775));
    assert_eq!(recording.origin.as_deref(), Some("2013-02-19T09:51:40"));
    let x = column(&recording, "X_Value");
    assert_eq!(x[0], 0.727_189_064_025_878_9);
    assert!((x[9] - x[0] - 9.0 * 3.906_25e-5).abs() < 1e-15);
    assert_eq!(table.columns[2].unit.as_deref(), Some("m/s^2"));
    assert_eq!(recording.findings, []);
}

#[test]
fn two_channels_with_an_x_each() {
    let Some(folder) = reference("lvm") else { return };
    let recording = recording(&folder.join("multi_time_column.lvm"));
    let table = &recording.tables[0];
    assert_eq!((recording.tables.len(), table.rows, table.columns.len()), (1, 3, 3));
    assert_eq!(column(&recording, "Voltage"), [-0.035_229, -0.034_882, -0.034_191]);
    assert_eq!(column(&recording, "Acceleration"), [0.532_608, 0.502_991, 0.467_541]);
    let x = column(&recording, "X_Value");
    assert!((x[2] - x[0] - 3.906_25e-5).abs() < 1e-15, "{x:?}");
    assert_eq!(recording.origin.as_deref(), Some("2016-08-23T10:45:47"));
    // It was shortened: 51200 samples are stated.
    assert_eq!(kinds(&recording), [(FindingKind::CountMismatch, Severity::Lost)]);
}

#[test]
fn a_process_log_with_remarks_in_latin_1() {
    let Some(folder) = reference("lvm") else { return };
    let recording = recording(&folder.join("with_comments.lvm"));
    let table = &recording.tables[0];
    assert_eq!((recording.tables.len(), table.rows, table.columns.len()), (1, 9, 5));
    assert_eq!(table.columns[2].unit.as_deref(), Some("°C"));
    let (pressure, x) = (column(&recording, "Pressão ABS. (MPa)"), column(&recording, "X_Value"));
    assert_eq!((pressure[0], pressure[8]), (1.833_787, 1.717_152));
    assert!((x[8] - x[0] - 9.723_275).abs() < 1e-12, "{x:?}");
    let remarks = table.column("Comment").unwrap().cells.text().unwrap();
    assert_eq!((remarks[0].as_str(), remarks[1].as_str(), remarks.len()), ("LOST COMMUNICATION", "OK", 9));
    let expected = [
        (FindingKind::Encoding, Severity::Note),
        (FindingKind::CountMismatch, Severity::Note),
        (FindingKind::StepMismatch, Severity::Note),
    ];
    assert_eq!(kinds(&recording), expected);
}

#[test]
fn every_file_of_the_folder_is_read_and_none_loses_a_row() {
    let Some(folder) = reference("lvm") else { return };
    let entries = std::fs::read_dir(&folder).unwrap_or_else(|error| panic!("{}: {error}", folder.display()));
    for path in entries.map(|entry| entry.unwrap().path()).filter(|p| p.extension().is_some_and(|e| e == "lvm")) {
        let recording = recording(&path);
        assert!(recording.tables.iter().any(|table| table.rows > 0), "{}", path.display());
        let excluded = recording.findings.iter().find(|f| f.kind == FindingKind::SkippedLine);
        assert_eq!(excluded, None, "{}", path.display());
    }
}
