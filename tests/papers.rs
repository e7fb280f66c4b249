//! The embedded papers through the binary: the figures that the two papers' own numbers give.

// In a test a panic is how a failure is told.
#![allow(clippy::unwrap_used, clippy::panic)]

mod common;

use std::collections::BTreeMap;
use std::path::Path;

use common::{datasets, pneuval};
use serde_json::Value;

fn results(folder: &Path) -> Value {
    let said = pneuval(folder, &["validate", "--out", "report", "--json"]);
    assert_eq!(said.code, 0, "{}", said.err);
    serde_json::from_str(&said.out).unwrap()
}

fn comparison<'a>(results: &'a Value, id: &str) -> &'a Value {
    results["comparisons"].as_array().unwrap().iter().find(|c| c["id"] == id).unwrap_or_else(|| panic!("no {id}"))
}

fn metric(results: &Value, id: &str, metric: &str) -> f64 {
    let metrics = comparison(results, id)["metrics"].as_array().unwrap();
    metrics.iter().find(|m| m["metric"] == metric).unwrap()["value"].as_f64().unwrap()
}

#[test]
fn the_rows_are_those_of_the_two_papers_and_every_verdict_is_as_expected() {
    let folder = tempfile::tempdir().unwrap();
    let results = results(folder.path());
    let rows: Vec<(&str, &str)> = results["comparisons"]
        .as_array()
        .unwrap()
        .iter()
        .map(|c| (c["id"].as_str().unwrap(), c["verdict"].as_str().unwrap()))
        .collect();
    let expected = [
        ("dual-chamber-finger/tip-angle/printed", "pass"),
        ("dual-chamber-finger/tip-angle/published-fea", "pass"),
        ("dual-chamber-finger/root-angle/printed", "fail"),
        ("dual-chamber-finger/root-angle/sheet-strain", "fail"),
        ("dual-chamber-finger/root-angle/elastic-strip", "fail"),
        ("dual-chamber-finger/root-angle/elastic-strip-1000x-soft", "pass"),
        ("dual-chamber-finger/root-angle/no-sheet-k2-1.7-c-1", "pass"),
        ("dual-chamber-finger/root-angle/no-sheet-k2-1.0-c-pi", "pass"),
        ("dual-chamber-finger/root-angle/no-sheet-k2-0.85-c-1", "pass"),
        ("dual-chamber-finger/root-angle/no-sheet-k2-0.85-c-pi", "pass"),
        ("dual-chamber-finger/root-angle/no-sheet-full-stress-k2-1.7-c-1", "pass"),
        ("dual-chamber-finger/root-angle/published-fea", "pass"),
        ("dual-chamber-finger/total-angle/printed-no-sheet", "pass"),
        ("dual-chamber-finger/total-angle/published-fea", "pass"),
        ("internal-support/outer-diameter/published-theory", "pass"),
        ("internal-support/outer-diameter/published-fea", "pass"),
        ("internal-support/outer-diameter/printed", "fail"),
        ("internal-support/outer-diameter/consistent", "fail"),
        ("internal-support/outer-diameter/consistent-fitted-to-fea", "pass"),
    ];
    assert_eq!(rows, expected);
}

#[test]
fn published_errors_of_internal_support() {
    let folder = tempfile::tempdir().unwrap();
    let results = results(folder.path());
    let theory = "internal-support/outer-diameter/published-theory";
    assert!((metric(&results, theory, "rmse") - 0.8689e-3).abs() < 5e-8);
    assert!((metric(&results, theory, "max_abs_error") - 0.94e-3).abs() < 1e-12);
    assert!((metric(&results, theory, "relative_to_measured_max") - 0.028_11).abs() < 5e-6);
    let fea = "internal-support/outer-diameter/published-fea";
    assert!((metric(&results, fea, "rmse") - 1.7689e-3).abs() < 5e-8);
    assert!((metric(&results, fea, "max_abs_error") - 1.86e-3).abs() < 1e-12);
    assert!((metric(&results, fea, "relative_to_measured_max") - 0.049_06).abs() < 5e-6);
    let row = comparison(&results, theory);
    assert_eq!((&row["n_used"], &row["n_available"]), (&Value::from(5), &Value::from(6)));
}

#[test]
fn the_fit_to_the_fea_column_finds_the_stiffer_silicone() {
    let folder = tempfile::tempdir().unwrap();
    let results = results(folder.path());
    let fit = &comparison(&results, "internal-support/outer-diameter/consistent-fitted-to-fea")["fit"];
    let parameter = |i: usize| fit["parameters"][i]["value_si"].as_f64().unwrap();
    assert!((parameter(0) - 0.342e6).abs() < 5e2, "C10 {}", parameter(0));
    assert!((parameter(1) - 0.104e6).abs() < 5e2, "C20 {}", parameter(1));
    assert!((fit["rmse_si"].as_f64().unwrap() - 0.035e-3).abs() < 5e-7);
    assert_eq!(fit["fitted_on"][0], "internal-support/outer-diameter published-fea");
}

#[test]
fn angles_of_the_dual_chamber_finger() {
    let folder = tempfile::tempdir().unwrap();
    let results = results(folder.path());
    let predicted = |id: &str| {
        comparison(&results, &format!("dual-chamber-finger/{id}"))["points"][0]["predicted"]
            .as_f64()
            .unwrap()
            .to_degrees()
    };
    assert!((predicted("tip-angle/printed") - 197.724_703).abs() < 5e-7);
    assert!((predicted("root-angle/no-sheet-k2-1.7-c-1") - 46.357_709).abs() < 5e-7);
    assert!((predicted("total-angle/printed-no-sheet") - 244.08).abs() < 5e-3);
    let share = metric(&results, "dual-chamber-finger/total-angle/printed-no-sheet", "relative_to_predicted_max");
    assert!((share - 0.0577).abs() < 5e-6);
    let printed = comparison(&results, "dual-chamber-finger/root-angle/printed");
    assert!(printed["points"][0]["predicted"].is_null());
    assert!(printed["sentence"].as_str().unwrap().contains("551.21 MPa"));
}

#[test]
fn the_page_says_in_words_that_the_published_curve_cannot_come_from_the_stated_material() {
    let folder = tempfile::tempdir().unwrap();
    results(folder.path());
    let page = std::fs::read_to_string(folder.path().join("report/internal-support.html")).unwrap();
    assert!(
        page.contains("reaches 45.88 mm at 10 kPa, where the paper prints 31.86 (FEA), 32.5 (theory) and 33.44 mm")
    );
    assert!(page.contains("The published curve cannot come from that material"));
}

#[test]
fn embedded_and_on_disk_give_the_same_bytes_and_so_does_running_twice() {
    let folder = tempfile::tempdir().unwrap();
    let disk = datasets();
    for (out, path) in [("a", None), ("b", Some(disk.to_str().unwrap())), ("c", None)] {
        let arguments: Vec<&str> = ["validate", "--out", out].into_iter().chain(path).collect();
        assert_eq!(pneuval(folder.path(), &arguments).code, 0);
    }
    let read = |name: &str| files(&folder.path().join(name));
    assert_eq!(read("a"), read("b"));
    assert_eq!(read("a"), read("c"));
    assert!(read("a").len() >= 10, "index, pages, results, figures");
    // Over an earlier report, and drawn again from stored numbers.
    assert_eq!(pneuval(folder.path(), &["validate", "--out", "a"]).code, 0);
    assert_eq!(pneuval(folder.path(), &["report", "b", "--out", "d"]).code, 0);
    assert_eq!(read("a"), read("c"));
    assert_eq!(read("d"), read("c"));
}

/// Every file below a folder by relative path.
fn files(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut found = BTreeMap::new();
    let mut open = vec![folder.to_owned()];
    while let Some(next) = open.pop() {
        for entry in std::fs::read_dir(next).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                open.push(path);
            } else {
                let name = path.strip_prefix(folder).unwrap().display().to_string();
                found.insert(name, std::fs::read(path).unwrap());
            }
        }
    }
    found
}

#[test]
fn the_stored_digests_are_those_of_the_files_and_no_path_of_this_machine_is_in_them() {
    let folder = tempfile::tempdir().unwrap();
    let results = results(folder.path());
    let stored = files(&folder.path().join("report/results"));
    let listed = results["files"].as_object().unwrap();
    // results.json and its schema do not list themselves.
    assert_eq!(listed.len() + 2, stored.len());
    for (name, digest) in listed {
        assert_eq!(digest.as_str().unwrap(), pneuval_ingest::digest::sha256(&stored[name]), "{name}");
    }
    let text = String::from_utf8(stored["results.json"].clone()).unwrap();
    assert!(!text.contains(env!("CARGO_MANIFEST_DIR")) && !text.contains(folder.path().to_str().unwrap()));
}

#[test]
fn figures_show_something_and_pages_need_no_other_file() {
    let folder = tempfile::tempdir().unwrap();
    results(folder.path());
    let report = files(&folder.path().join("report"));
    let figures: Vec<_> = report.iter().filter(|(name, _)| name.starts_with("results/figures/")).collect();
    assert_eq!(figures.len(), 10);
    for (name, png) in figures {
        let pixels = image::load_from_memory(png).unwrap().to_rgb8();
        assert!(pixels.width() == 1520 && pixels.height() >= 360, "{name}");
        let ink = pixels.pixels().filter(|p| p.0 != [255, 255, 255]).count();
        assert!(ink > 20_000, "{name} is blank: {ink}");
    }
    for page in ["index.html", "internal-support.html", "dual-chamber-finger.html"] {
        let html = String::from_utf8(report[page].clone()).unwrap();
        assert!(!html.contains("src=\"http") && !html.contains("<script") && !html.contains("<link"), "{page}");
        assert!(html.contains("@font-face"), "{page}");
    }
}

#[test]
fn terminal_page_json_and_exit_code_tell_the_same_numbers() {
    let folder = tempfile::tempdir().unwrap();
    let results = results(folder.path());
    let said = pneuval(folder.path(), &["gate", "report"]);
    assert_eq!(said.code, 0);
    let page = std::fs::read_to_string(folder.path().join("report/index.html")).unwrap();
    for (id, unit, scale) in [
        ("internal-support/outer-diameter/published-theory", " mm", 1e3),
        ("dual-chamber-finger/tip-angle/printed", "°", 180.0 / std::f64::consts::PI),
    ] {
        let text = format!("{:.4}{unit}", metric(&results, id, "max_abs_error") * scale);
        assert!(said.out.contains(&text) && page.contains(&text), "{text}");
    }
    let rows = results["comparisons"].as_array().unwrap().len();
    assert!(said.out.contains(&format!("{rows} comparisons")) && page.contains(&format!("{rows} comparisons")));
}
