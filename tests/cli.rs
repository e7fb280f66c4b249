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
        &["export", "--help"],
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
    assert!(constants.iter().all(|c| c["place"].is_string()) && constants.len() == 2, "{constants:?}");

    let text = pneuval(Path::new("."), &["materials"]).out;
    for words in ["stable up to 4 at least", "0.005 MPa", "published", "initial shear modulus: 100.0 kPa"] {
        assert!(text.contains(words) && !text.contains("FAILS"), "{words} in\n{text}");
    }
    // Every material under the law it names, with its own constants alone; of two, each by its name.
    let rows = |law: &str| -> Vec<(String, String, f64, Vec<String>)> {
        let listing: Value = serde_json::from_str(&pneuval(Path::new("."), &["materials", law, "--json"]).out).unwrap();
        let row = |m: &Value| {
            let word = |key: &str| m[key].as_str().unwrap().to_owned();
            let names = m["constants"].as_array().unwrap().iter().map(|c| c["name"].as_str().unwrap().to_owned());
            let modulus_kpa = (m["shear_modulus_pa"].as_f64().unwrap() / 100.0).round() / 10.0;
            (word("actuator"), word("material"), modulus_kpa, names.collect())
        };
        listing["materials"].as_array().unwrap().iter().map(row).collect()
    };
    let rubber = rows("mooney-rivlin");
    assert_eq!(rubber.len(), 1);
    assert_eq!((rubber[0].0.as_str(), rubber[0].1.as_str(), rubber[0].2), ("pdms-wall", "wall", 333.5));
    assert_eq!(rubber[0].3, ["c1", "c2", "mu", "mu1", "mu2", "poisson_ratio"]);
    let yeoh = rows("yeoh");
    let wave: Vec<(&str, f64)> = yeoh.iter().filter(|m| m.0 == "wave-finger").map(|m| (m.1.as_str(), m.2)).collect();
    assert_eq!(wave, [("lower", 200.0), ("upper", 160.0)]);
    assert!(yeoh.iter().all(|m| m.3 == ["C10", "C20"] && m.0 != "pdms-wall"), "{yeoh:?}");
    for words in ["pdms-wall, wall: mooney-rivlin", "wave-finger, upper: yeoh", "wave-finger, lower: yeoh"] {
        assert!(text.contains(words) && !text.contains("linear_full_pressure"), "{words} in\n{text}");
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
fn predict_takes_parameters_in_place_of_the_files() {
    let here = Path::new(".");
    let bending = ["predict", "fruit-finger", "--quantity", "bending-angle", "--form", "printed", "--at", "60 kPa"];
    let with: Vec<&str> = bending.into_iter().chain(["--with", "finger_length = 46.7 mm"]).collect();
    let said = pneuval(here, &with);
    assert!(
        said.out.contains("printed: with finger_length = 46.7 mm; rests on assumed chamber_radius\n"),
        "{}",
        said.out
    );
    let json: Vec<&str> = with.into_iter().chain(["--json"]).collect();
    let blocks: Vec<Value> = serde_json::from_str(&pneuval(here, &json).out).unwrap();
    let form = &blocks[0]["forms"][0];
    let angle_deg = form["predicted_si"][0].as_f64().unwrap().to_degrees();
    assert!((angle_deg - 110.0).abs() < 0.1, "{angle_deg}");
    assert_eq!(form["rests_on"], serde_json::json!(["assumed chamber_radius"]));
}

/// The actuator file and the catalogue's stated inputs give the same numbers: none of two fits is mixed with the other.
#[test]
fn predict_gives_the_catalogues_check_values_of_both_fits() {
    let here = Path::new(".");
    let models: Vec<Value> = serde_json::from_str(&pneuval(here, &["models", "fruit-finger", "--json"]).out).unwrap();
    for (form, pressure, held, statement) in [
        ("consistent-proportional", "60 kPa", "0 deg", "60 kPa, held straight: K a P / 2"),
        ("consistent-proportional", "40 kPa", "45 deg", "40 kPa, held at 45 deg"),
        ("consistent-affine", "60 kPa", "0 deg", "60 kPa, held straight: K (a P + b) / 2"),
        ("consistent-affine", "60 kPa", "90 deg", "60 kPa, held at 90 deg"),
    ] {
        let row = models.iter().find(|m| m["form"] == form).unwrap();
        let check = row["checks"].as_array().unwrap().iter().find(|c| c["statement"] == statement).unwrap();
        let held = format!("held_angle = {held}");
        let said =
            pneuval(here, &["predict", "fruit-finger", "--form", form, "--at", pressure, "--with", &held, "--json"]);
        let blocks: Vec<Value> = serde_json::from_str(&said.out).unwrap();
        let force_n = blocks[0]["forms"][0]["predicted_si"][0].as_f64().unwrap();
        let expected = check["expected"].as_f64().unwrap();
        assert!((force_n - expected).abs() < 1e-7, "{form} {held}: {force_n} {expected}");
    }
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
