//! Baselines: what moved, by how much, and whether intervals explain it.

// In a test a panic is how a failure is told.
#![allow(clippy::unwrap_used, clippy::panic)]

mod common;

use std::fs;
use std::path::Path;

use common::{Said, pneuval};
use serde_json::Value;

/// A session of the wall's force, rehearsed with a seed, and its report.
fn sitting(folder: &Path, name: &str, seed: &str) {
    let said = pneuval(folder, &["rehearse", "internal-support", "--seed", seed, "--out", name]);
    assert_eq!(said.code, 0, "{}", said.err);
    // The same sitting, whatever the seed.
    let session = folder.join(name).join("session.toml");
    let text = fs::read_to_string(&session).unwrap();
    fs::write(&session, text.replace(&format!("-seed{seed}\""), "-seed1\"")).unwrap();
    report(folder, name);
}

fn report(folder: &Path, name: &str) {
    let out = format!("report-{name}");
    let said = pneuval(folder, &["validate", name, "--out", &out, "--no-figures"]);
    assert!(said.code == 0 || said.code == 1, "{}", said.err);
}

fn against(folder: &Path, report: &str, format: &str) -> Said {
    pneuval(folder, &["gate", report, "--baseline", "baseline.json", "--format", format])
}

fn moves(said: &Said) -> Vec<Value> {
    let told: Value = serde_json::from_str(&said.out).unwrap_or_else(|_| panic!("{}", said.err));
    told["moves"].as_array().unwrap().clone()
}

#[test]
fn the_same_results_move_nothing_other_data_are_explained_and_another_model_is_not() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    sitting(here, "monday", "1");
    let accept =
        |report: &str, why: &str| pneuval(here, &["accept", report, "--baseline", "baseline.json", "--because", why]);
    let said = accept("report-monday", "the first");
    assert!(said.code == 0 && said.out.contains("none before"), "{}{}", said.out, said.err);
    let said = against(here, "report-monday", "table");
    assert!(said.code == 0 && said.out.contains("Nothing moved since the baseline."), "{}", said.out);
    // Another day at the same rig: the numbers move within their intervals.
    sitting(here, "tuesday", "2");
    let said = against(here, "report-tuesday", "json");
    let told = moves(&said);
    assert!(said.code == 0 && !told.is_empty(), "{}", said.err);
    for one in told.iter().filter(|m| m["metric"] == "rmse") {
        assert_eq!(one["moved"], "explained", "{one}");
        let (before, after, open) = (&one["before"], &one["after"], &one["open"]);
        let change = after.as_f64().unwrap() - before.as_f64().unwrap();
        assert!(change.abs() <= open.as_f64().unwrap() && change != 0.0, "{one}");
    }
    // Monday's data again, and a prediction that is off by half a millimetre more: no interval explains that.
    let table = here.join("monday/outer-diameter-published-theory.csv");
    let text = fs::read_to_string(&table).unwrap();
    let lower = |line: &str| match line.rsplit_once(',').map(|(head, value)| (head, value.parse::<f64>())) {
        Some((head, Ok(value))) => format!("{head},{}", value - 0.5),
        _ => line.to_owned(),
    };
    fs::write(&table, text.lines().map(lower).collect::<Vec<_>>().join("\n") + "\n").unwrap();
    report(here, "monday");
    let said = against(here, "report-monday", "json");
    let told = moves(&said);
    assert_eq!(said.code, 1, "{}", said.err);
    let rmse = told.iter().find(|m| m["metric"] == "rmse" && m["counts"] == true).unwrap();
    assert!(rmse["moved"] == "worse" && rmse["id"].as_str().unwrap().ends_with("published-theory"), "{rmse}");
    assert!((rmse["after"].as_f64().unwrap() - rmse["before"].as_f64().unwrap() - 5e-4).abs() < 1e-5, "{rmse}");
    assert!(rmse["open"].is_null() && rmse["sentence"].as_str().unwrap().contains("the data are the same"), "{rmse}");
    // The others did not move at all.
    assert!(told.iter().all(|m| m["id"].as_str().unwrap().ends_with("published-theory")), "{told:?}");
    let [junit, markdown, github] =
        ["junit", "markdown", "github"].map(|format| against(here, "report-monday", format));
    assert!([&junit, &markdown, &github].iter().all(|said| said.code == 1));
    assert!(junit.out.contains("<failure type=\"worse\" message=\"RMSE "), "{}", junit.out);
    assert!(markdown.out.contains("### Since the baseline") && markdown.out.contains("**worse**"), "{}", markdown.out);
    assert!(github.out.contains("::error title=worse since the baseline"), "{}", github.out);
    // On purpose: then it is the baseline, and what was said before stays.
    let said = accept("report-monday", "the other table");
    assert!(said.code == 0 && said.out.contains("worse"), "{}", said.out);
    assert_eq!(against(here, "report-monday", "table").code, 0);
    let kept: Value = serde_json::from_slice(&fs::read(here.join("baseline.json")).unwrap()).unwrap();
    let whys: Vec<&str> = kept["accepted"].as_array().unwrap().iter().map(|a| a["because"].as_str().unwrap()).collect();
    assert_eq!(whys, ["the first", "the other table"]);
}

#[test]
fn what_is_gone_fails_what_is_new_is_told_and_a_report_is_as_good_as_a_file() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    sitting(here, "monday", "1");
    let said = pneuval(here, &["validate", "--out", "papers", "--no-figures"]);
    assert_eq!(said.code, 0, "{}", said.err);
    let since = |new: &str, old: &str| pneuval(here, &["gate", new, "--baseline", old]);
    let said = since("report-monday", "papers");
    assert!(said.code == 1 && said.out.contains("33 gone · 4 new"), "{}", said.out);
    let said = since("papers", "papers/results/results.json");
    assert!(said.code == 0 && said.out.contains("Nothing moved"), "{}", said.out);
    for (file, text, words) in [
        ("broken.json", "{", "not a baseline"),
        (
            "other.json",
            "{\"baseline_version\": 9, \"metric_definitions\": 2, \"accepted\": [], \"comparisons\": []}",
            "expected, found 9",
        ),
        (
            "older.json",
            "{\"baseline_version\": 1, \"metric_definitions\": 1, \"accepted\": [], \"comparisons\": []}",
            "cannot be compared",
        ),
    ] {
        fs::write(here.join(file), text).unwrap();
        let said = since("papers", file);
        assert!(said.code == 2 && said.err.contains(words), "{file}: {}", said.err);
    }
    let said = since("papers", "none.json");
    assert!(said.code == 2 && said.err.contains("none.json"), "{}", said.err);
    let said = pneuval(here, &["accept", "papers", "--baseline", "b.json", "--because", " "]);
    assert!(said.code == 2 && said.err.contains("--because") && !here.join("b.json").exists(), "{}", said.err);
    // What is there and is no baseline is not overwritten.
    let said = pneuval(here, &["accept", "papers", "--baseline", "broken.json", "--because", "x"]);
    assert!(said.code == 2 && fs::read_to_string(here.join("broken.json")).unwrap() == "{", "{}", said.err);
}
