//! Logs that other people's rigs wrote. They are not part of this repository: `PNEUVAL_REFERENCE_DATA` names their folder.

// In a test a panic is how a failure is told; equality of floats is asked where it must be exact.
#![allow(clippy::unwrap_used, clippy::panic, clippy::float_cmp)]

#[path = "common/reference.rs"]
mod reference;

use std::path::Path;

use pneuval_ingest::finding::{FindingKind, clock_findings, rate_hz};
use pneuval_ingest::formats::csv::{CsvOptions, TextLog, read};
use pneuval_ingest::limits;
use reference::files;

fn log(path: &Path) -> (TextLog, usize) {
    let bytes = limits::read(path, limits::LOG_BYTES_MAX).unwrap();
    let log = read(&path.display().to_string(), &bytes, &CsvOptions::default()).unwrap();
    (log, bytes.iter().filter(|b| **b == b'\n').count())
}

fn numbers(log: &TextLog, column: usize) -> &[f64] {
    log.columns[column].cells.numbers().unwrap()
}

#[test]
fn zillen_friction_logs() {
    let (Some(first), Some(again)) = (files("rig/zillen", "csv"), files("rig/zillen/rerun", "csv")) else { return };
    assert_eq!((first.len(), again.len()), (6, 3));
    for path in first.iter().chain(&again) {
        let (log, lines) = log(path);
        let name = path.file_name().and_then(|n| n.to_str()).unwrap();
        assert_eq!((log.columns.len(), log.rows, log.line_of(log.rows - 1)), (7, lines, lines), "{name}");
        assert_eq!(log.findings, [], "{name}");
        assert_eq!((log.metadata.len(), log.layout.delimiter), (0, b'\t'));
        let seconds: Vec<f64> = numbers(&log, 0).iter().map(|ms| ms / 1e3).collect();
        let rate = rate_hz(&seconds).unwrap();
        // Most steps are 10 ms, some 11.
        assert!((96.0..100.0).contains(&rate), "{name}: {rate}");
        let findings = clock_findings(name, "column 1", &seconds, Some(&log.lines));
        assert!(findings.iter().all(|f| f.kind == FindingKind::Gap), "{name}: {findings:?}");
        let gaps = findings.first().map_or(0, |f| f.count);
        let expected = match name {
            "O-ring257_1bar.csv" => 4,
            "X-ring257_3bar.csv" => 3,
            "NAPN_3bar.csv" => 2,
            "3_O-ring257_3bar.csv" => 0,
            _ => 1,
        };
        assert_eq!(gaps, expected, "{name}: {findings:?}");
        if name == "O-ring257_1bar.csv" {
            assert_eq!((findings[0].spans[0].first_sample, findings[0].spans[0].last_line), (0, 2));
            assert!(findings[0].text.contains("276 ms from 0 s to 0.276 s"), "{}", findings[0].text);
        }
        if name == "O-ring257_3bar.csv" {
            let first: Vec<f64> = log.columns.iter().map(|c| c.cells.numbers().unwrap()[0]).collect();
            assert_eq!(first, [0.0, 4.469, 1.505, 3.333, 0.0, 2.998, 154.659]);
            assert_eq!((findings[0].spans[0].first_sample, findings[0].spans[0].last_line), (0, 2));
            assert!(findings[0].text.contains("273 ms from 0 s to 0.273 s"), "{}", findings[0].text);
        }
    }
}

#[test]
fn gunawardane_tip_poses() {
    let Some(files) = files("rig/gunawardane", "csv") else { return };
    let (log, lines) = log(&files[0]);
    assert_eq!((log.rows, log.columns.len()), (lines - 1, 5));
    let mut groups = log.columns[0].cells.text().unwrap().to_vec();
    groups.dedup();
    groups.sort();
    groups.dedup();
    assert_eq!(groups.len(), 53);
    assert_eq!((log.columns[4].name.as_str(), numbers(&log, 4)[1]), ("theta", -7.136_508_282));
    assert_eq!(log.findings, []);
}

#[test]
fn soromadb_tensile_tests() {
    let Some(files) = files("tensile/soromadb", "csv") else { return };
    assert_eq!(files.len(), 3);
    for path in &files {
        let (log, lines) = log(path);
        assert_eq!((log.metadata.len(), log.columns.len(), log.rows), (17, 5, lines - 18), "{}", path.display());
        assert_eq!(log.metadata[1], "Specimen Thickness (mm);3;;;");
        assert_eq!((log.columns[2].name.as_str(), log.columns[2].unit.as_deref()), ("True Stress (MPa)", Some("MPa")));
        assert!(log.columns.iter().all(|c| c.cells.numbers().unwrap().iter().all(|v| v.is_finite())));
        assert_eq!(log.findings, []);
    }
}

#[test]
fn tracker_with_a_clock_of_words_for_every_sensor() {
    let Some(files) = files("tracker/trakstar", "csv") else { return };
    let (log, lines) = log(&files[0]);
    assert_eq!((log.rows, log.columns.len()), (lines - 1, 64));
    assert_eq!(log.column("time1").unwrap().cells.text().unwrap()[0], "00:00:00.0119684");
    assert_eq!(log.findings, []);
}
