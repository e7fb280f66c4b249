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
        &["materials", "--help"],
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
    assert!(text.contains("wave-finger / Eq. 11 to 21 (pressure from bending angle)  (not evaluable)"));
}

#[test]
fn materials_lists_every_law_and_the_papers_constants_in_them() {
    let said = pneuval(Path::new("."), &["materials", "--json"]);
    let listing: Value = serde_json::from_str(&said.out).unwrap();
    let laws = listing["laws"].as_array().unwrap();
    assert_eq!(laws.len(), 5);
    for check in laws.iter().flat_map(|law| law["checks"].as_array().unwrap()) {
        assert_eq!(check["holds"], true, "{check}");
    }
    let material = |id: &str| listing["materials"].as_array().unwrap().iter().find(|m| m["actuator"] == id).unwrap();
    let finger = material("dual-chamber-finger");
    assert_eq!(finger["shear_modulus_pa"], 220e3);
    let planar = &finger["load_cases"][1];
    let at_2 = planar["nominal_stress"][1]["nominal_stress_pa"].as_f64().unwrap();
    assert!((at_2 - 0.75e6).abs() < 1e-6, "{at_2}");
    assert_eq!((&planar["stable_to"]["why"], &planar["stable_to"]["stretch"]), (&"at-least".into(), &4.0.into()));
    let constants = finger["constants"].as_array().unwrap();
    assert!(constants.iter().all(|c| c["place"].is_string()) && constants.len() == 3, "{constants:?}");

    let text = pneuval(Path::new("."), &["materials"]).out;
    for words in ["stable up to 4 at least", "0.005 MPa", "published", "initial shear modulus: 100.0 kPa"] {
        assert!(text.contains(words) && !text.contains("FAILS"), "{words} in\n{text}");
    }
    let one = pneuval(Path::new("."), &["materials", "gent"]).out;
    assert!(one.contains("gent: Gent") && !one.contains("ogden") && one.contains("No embedded paper"), "{one}");
    let wrong = pneuval(Path::new("."), &["materials", "yeho"]);
    assert!(wrong.code == 2 && wrong.err.contains("did you mean `yeoh`?"), "{}", wrong.err);
}

#[test]
fn a_material_that_is_none_is_listed_with_the_reason() {
    let mine = tempfile::tempdir().unwrap();
    let file = common::datasets().join("actuators/internal-support.toml");
    let text = std::fs::read_to_string(file).unwrap();
    for (c10, c20, words) in [
        ("-0.05", "0.005", "no material of this law: C10 = -50000 is outside its domain, finite and > 0 Pa"),
        // Planar tangent at l = 2: 2.375 C10 + 38.8125 C20 = 0.
        ("0.0388125", "-0.002375", "unstable from 2"),
    ] {
        let constant = |name: &str, value: &str| format!("{name} = {{ value = {value},");
        let changed = text
            .replace(&constant("C10", "0.05"), &constant("C10", c10))
            .replace(&constant("C20", "0.005"), &constant("C20", c20));
        assert_ne!(changed, text);
        std::fs::write(mine.path().join("actuator.toml"), changed).unwrap();
        let said = pneuval(mine.path(), &["materials", "yeoh"]);
        assert!(said.code == 0 && said.out.contains(words), "{words} in\n{}{}", said.out, said.err);
    }
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
fn predict_takes_conditions_and_names_those_it_lacks() {
    let here = Path::new(".");
    let force = ["predict", "fruit-finger", "--quantity", "tip-force", "--at", "40 kPa"];
    let said = pneuval(here, &force);
    assert!(said.code == 0 && said.out.contains("needs held_angle: give it with --with"), "{}", said.out);
    let with: Vec<&str> = force.into_iter().chain(["--with", "held_angle = 0 deg", "--json"]).collect();
    let blocks: Vec<Value> = serde_json::from_str(&pneuval(here, &with).out).unwrap();
    let form = blocks[0]["forms"].as_array().unwrap().iter().find(|f| f["form"] == "consistent-proportional").unwrap();
    // Held straight, Eq. 15 is 2EI θ0/L² = K a P / 2, with the stored K and a.
    let expected = 2.145 * 1.937e-5 * 40e3 / 2.0;
    assert!((form["predicted_si"][0].as_f64().unwrap() - expected).abs() < 1e-9, "{form}");
    assert_eq!(form["rests_on"][0], "calibrated rod_stiffness");
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
