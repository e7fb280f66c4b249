//! What only the process can show: help, streams, pipes; and the published schema.

// In a test a panic is how a failure is told.
#![allow(clippy::unwrap_used, clippy::panic)]

mod common;

use std::path::Path;
use std::process::{Command, Stdio};

use common::pneuval;
use serde_json::Value;

#[test]
fn every_help_has_an_example() {
    let here = Path::new(".");
    for command in [
        &["--help"][..],
        &["validate", "--help"],
        &["gate", "--help"],
        &["report", "--help"],
        &["predict", "--help"],
        &["models", "--help"],
    ] {
        let said = pneuval(here, command);
        assert_eq!(said.code, 0);
        assert!(said.out.contains("Example") && said.out.contains("pneuval "), "{command:?}");
    }
    assert!(pneuval(here, &["--help"]).out.contains("Exit codes:"));
    assert_eq!(pneuval(here, &[]).code, 2);
    assert_eq!(pneuval(here, &["validate", "--no-such-flag"]).code, 2);
}

#[test]
fn a_reader_that_stops_early_is_no_error() {
    let mut child = Command::new(env!("CARGO_BIN_EXE_pneuval"))
        .args(["predict", "internal-support", "--steps", "20000"])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    drop(child.stdout.take());
    let said = child.wait_with_output().unwrap();
    assert!(said.status.success(), "{:?} {}", said.status, String::from_utf8_lossy(&said.stderr));
}

#[test]
fn models_lists_every_form_and_every_check_holds() {
    let said = pneuval(Path::new("."), &["models", "--json"]);
    let rows: Vec<Value> = serde_json::from_str(&said.out).unwrap();
    let mut checks = 0;
    for row in &rows {
        for check in row["checks"].as_array().unwrap() {
            assert_eq!(check["holds"], true, "{check}");
            checks += 1;
        }
    }
    assert!(rows.len() >= 15 && checks >= 30, "{} forms, {checks} checks", rows.len());
    let text = pneuval(Path::new("."), &["models"]).out;
    assert!(text.contains("misprint") && !text.contains("FAILS"));
}

#[test]
fn predict_prints_the_papers_angles_and_says_why_there_is_none() {
    let said = pneuval(Path::new("."), &["predict", "dual-chamber-finger"]);
    assert_eq!(said.code, 0, "{}", said.err);
    for number in ["197.7247", "46.3577", "244.0824", "no solution", "551.21 MPa"] {
        assert!(said.out.contains(number), "{number} in\n{}", said.out);
    }
    let said = pneuval(
        Path::new("."),
        &["predict", "dual-chamber-finger", "--quantity", "total-angle", "--at", "4e4 Pa, 0.05 MPa", "--json"],
    );
    let blocks: Vec<Value> = serde_json::from_str(&said.out).unwrap();
    let total = blocks[0]["forms"][0]["predicted_si"][0].as_f64().unwrap().to_degrees();
    assert!((total - 244.082).abs() < 5e-4, "{total}");
}

#[test]
fn the_published_schema_is_that_of_the_results() {
    let committed = Path::new(env!("CARGO_MANIFEST_DIR")).join("analysis/schema/results.schema.json");
    let current = pneuval_analysis::folder::schema_json().unwrap();
    let stored = std::fs::read_to_string(&committed).unwrap_or_default();
    assert!(
        stored == current,
        "write the new schema: `pneuval validate`, then copy results/results.schema.json to analysis/schema/"
    );
}
