//! Tracker logs that other people's rigs wrote. They are not part of this repository: `PNEUVAL_REFERENCE_DATA` names their folder.

// In a test a panic is how a failure is told; equality of floats is asked where it must be exact.
#![allow(clippy::unwrap_used, clippy::panic, clippy::float_cmp)]

#[path = "common/reference.rs"]
mod reference;

use std::path::Path;

use pneuval_ingest::finding::{FindingKind, Severity, rate_hz};
use pneuval_ingest::formats::tracker::{TrackerOptions, trakstar};
use pneuval_ingest::formats::{Format, Options, detect, read};
use pneuval_ingest::raw::RawFile;
use pneuval_ingest::recording::{Keep, Recording};
use reference::reference;

fn recording(path: &Path, expected: Format) -> Recording {
    let raw = RawFile::open(path, "log", u64::MAX).unwrap();
    assert_eq!(detect(&raw).unwrap(), expected);
    read(&raw, &Options::default(), Keep::All).unwrap()
}

fn column<'a>(recording: &'a Recording, name: &str) -> &'a [f64] {
    recording.tables[0].column(name).unwrap_or_else(|| panic!("{name}")).cells.numbers().unwrap()
}

#[test]
fn trakstar_of_eight_sensors_is_in_cm_at_89_hz() {
    let Some(path) = reference("tracker/trakstar/8-sensors-89hz.csv") else { return };
    let recording = recording(&path, Format::Trakstar);
    let table = &recording.tables[0];
    assert_eq!((recording.tables.len(), table.rows, table.columns.len()), (1, 1447, 64));
    assert_eq!(table.clock.map(|clock| table.columns[clock].name.as_str()), Some("time1"));
    let time = column(&recording, "time1");
    assert_eq!((time[0], time[1446]), (0.011_968_4, 16.238_795_1));
    assert!(((1446.0 / (time[1446] - time[0])) - 89.0).abs() < 1.0);
    assert!((rate_hz(time).unwrap() - 89.0).abs() < 1.0);
    for (name, unit) in [("x1", "cm"), ("z8", "cm"), ("a1", "deg"), ("r8", "deg"), ("time8", "s")] {
        assert_eq!(table.column(name).unwrap().unit.as_deref(), Some(unit), "{name}");
    }
    assert_eq!(table.column("quality1").unwrap().unit, None);
    assert_eq!(column(&recording, "quality6")[0], 22760.0);
    let inferred: Vec<_> = recording.findings.iter().filter(|f| f.kind == FindingKind::InferredUnit).collect();
    assert_eq!((inferred.len(), inferred[0].severity, inferred[0].count), (1, Severity::Note, 24));
    assert_eq!(
        inferred[0].text,
        "the unit cm of the positions is inferred, the file states none: all of them are multiples of 0.0111621 cm, \
         4 times the step of a trakSTAR of 36 in range (36 in / 32768)"
    );
    let others = recording.findings.iter().filter(|f| f.kind != FindingKind::InferredUnit);
    assert!(others.clone().all(|f| f.kind == FindingKind::AngleWrap && f.severity == Severity::Note));
    // Counted beforehand, from the text.
    let jumps =
        |name: &str| column(&recording, name).windows(2).filter(|pair| (pair[1] - pair[0]).abs() > 180.0).count();
    assert!(others.clone().count() > 0);
    for finding in others {
        assert_eq!(finding.count, jumps(finding.channel.as_deref().unwrap()), "{}", finding.text);
    }
    assert!(recording.reasons.iter().any(|r| r == "angles are multiples of 180/8192 deg"), "{:?}", recording.reasons);
}

#[test]
fn poses_of_poor_quality_are_holes_when_asked() {
    let Some(path) = reference("tracker/trakstar/8-sensors-89hz.csv") else { return };
    let raw = RawFile::open(&path, "log", u64::MAX).unwrap();
    let recording = trakstar::read(&raw, TrackerOptions { quality_max: Some(9000) }, Keep::All).unwrap();
    for sensor in 1..=8 {
        let quality = column(&recording, &format!("quality{sensor}"));
        let poor = quality.iter().filter(|q| **q > 9000.0).count();
        for part in ["x", "y", "z", "a", "e", "r"] {
            let name = format!("{part}{sensor}");
            let holes = column(&recording, &name).iter().filter(|v| v.is_nan()).count();
            let told = recording
                .findings
                .iter()
                .find(|f| f.channel.as_deref() == Some(&name) && f.kind == FindingKind::LowQuality);
            assert_eq!((holes, told.map_or(0, |f| f.count)), (poor, poor), "{name}");
        }
    }
}

#[test]
fn plus_sequences_have_their_frames() {
    for (name, frames) in [("SyntheticTrackerBuffer20.igs.mha", 20), ("Prostate10_tracker.igs.mha", 10)] {
        let Some(path) = reference(&format!("tracker/plus/{name}")) else { return };
        let recording = recording(&path, Format::Plus);
        let table = &recording.tables[0];
        assert_eq!((table.rows, table.clock.map(|c| table.columns[c].name.as_str())), (frames, Some("Timestamp")));
        assert_eq!(table.column("ToolToTracker.x").unwrap().unit.as_deref(), Some("mm"));
        let time = column(&recording, "Timestamp");
        assert_eq!((time[0], time[frames - 1]), (1.0, 1.0 + 0.5 * (frames - 1) as f64));
        assert_eq!(recording.findings, [], "{name}");
    }
    let Some(path) = reference("tracker/plus/SyntheticTrackerBuffer20.igs.mha") else { return };
    let recording = recording(&path, Format::Plus);
    let z = column(&recording, "ToolToTracker.z");
    assert_eq!((z[0], z[10], z[19]), (30.0, 38.0, 31.0));
    assert_eq!(column(&recording, "ToolToTracker.qw")[0], 1.0);
}

#[test]
fn logs_of_rigs_are_still_told_as_delimited_text() {
    for folder in ["rig/zillen", "rig/zillen/rerun", "rig/gunawardane", "tensile/soromadb", "tensile/treloar", "tube"] {
        let Some(folder) = reference(folder) else { return };
        let mut folders = vec![folder];
        let mut told = 0;
        while let Some(folder) = folders.pop() {
            for entry in std::fs::read_dir(folder).unwrap() {
                let path = entry.unwrap().path();
                if path.is_dir() {
                    folders.push(path);
                } else if path.extension().is_some_and(|extension| extension == "csv" || extension == "txt") {
                    let raw = RawFile::open(&path, "log", u64::MAX).unwrap();
                    assert_eq!(detect(&raw).unwrap(), Format::Csv, "{}", path.display());
                    told += 1;
                }
            }
        }
        assert!(told > 0);
    }
}
