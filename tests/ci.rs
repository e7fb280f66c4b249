//! The decision in every shape: page, JSON, `JUnit`, Markdown, annotations, terminal and exit code say the same.

// Helpers of tests may unwrap and panic, as tests do.
#![allow(clippy::unwrap_used, clippy::panic)]

mod common;

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use common::pneuval;
use serde_json::Value;

/// A folder with the papers' datasets, one bound changed so that a verdict differs, and one removed so that another is open.
fn changed(folder: &Path) {
    let said = pneuval(folder, &["validate", "--out", "papers", "--no-figures"]);
    assert_eq!(said.code, 0, "{}", said.err);
    let bounds = "schema = 1\n\
        [[bound]]\nactuator = \"internal-support\"\nquantity = \"outer-diameter\"\nmodel = \"published-theory\"\n\
        metric = \"max_abs_error\"\nmax = { value = 0.5, unit = \"mm\" }\nreason = \"stricter, for this test\"\n\
        [[bound]]\nactuator = \"internal-support\"\nquantity = \"outer-diameter\"\nmodel = \"published-fea\"\n\
        metric = \"max_abs_error\"\nmax = { value = 2.5, unit = \"mm\" }\nreason = \"as it was\"\n";
    fs::write(folder.join("stricter.toml"), bounds).unwrap();
}

/// What an attribute of an element says.
fn attribute<'a>(element: &'a str, name: &str) -> &'a str {
    element.split(&format!(" {name}=\"")).nth(1).unwrap().split('"').next().unwrap()
}

/// The cases of a document: what became of each, by its name.
fn fates(xml: &str) -> BTreeMap<String, &'static str> {
    let cases = xml.split("<testcase ").skip(1);
    let fate = |case: &str| {
        let end = case.find("</testcase>").unwrap();
        ["failure", "error", "skipped"].into_iter().find(|w| case[..end].contains(&format!("<{w}"))).unwrap_or("passed")
    };
    cases.map(|case| (attribute(&format!(" {case}"), "name").to_owned(), fate(case))).collect()
}

#[test]
fn page_json_junit_markdown_annotations_terminal_and_exit_code_agree() {
    let folder = tempfile::tempdir().unwrap();
    changed(folder.path());
    let gate = |format: &str| {
        let said = pneuval(folder.path(), &["gate", "papers", "--bounds", "stricter.toml", "--format", format]);
        assert_eq!(said.code, 1, "{format}: {}", said.err);
        said.out
    };
    let results: Value = serde_json::from_str(&gate("json")).unwrap();
    let comparisons = results["comparisons"].as_array().unwrap();
    let (junit, markdown, github, table) = (gate("junit"), gate("markdown"), gate("github"), gate("table"));
    let fates = fates(&junit);
    assert_eq!(fates.len(), comparisons.len());
    let mut counts: BTreeMap<&str, usize> = BTreeMap::new();
    for c in comparisons {
        let text = |key: &str| c[key].as_str().unwrap();
        let quantity = c["quantity"]["id"].as_str().unwrap();
        let name = format!("{} {quantity}: {}", text("dataset"), text("form"));
        // Only one bound is left that differs, and one that does not.
        let fate = match text("verdict") {
            _ if c["counted"] == false => "skipped",
            "unjudged" => "error",
            "fail" => "failure",
            verdict => {
                assert_eq!((verdict, text("form")), ("pass", "published-fea"), "{name}");
                "passed"
            }
        };
        *counts.entry(fate).or_default() += 1;
        assert_eq!(fates[&name], fate, "{name}");
        // One row a comparison, with its verdict.
        let row = markdown.lines().find(|l| {
            let cells: Vec<&str> = l.split(" | ").collect();
            cells.len() > 4 && cells[2] == quantity && cells[3] == text("form") && cells[1].starts_with(text("dataset"))
        });
        assert!(row.unwrap_or_else(|| panic!("{name}: {markdown}")).starts_with(&format!("| {}", text("verdict"))));
    }
    // The numbers of the comparison that fails, in each of them.
    for (what, told) in [("junit", &junit), ("markdown", &markdown), ("github", &github), ("table", &table)] {
        for number in ["0.8689 mm", "0.9400 mm", "2.811 %"] {
            assert!(told.contains(number), "{what} lacks {number}: {told}");
        }
    }
    let count = |fate: &str| counts.get(fate).copied().unwrap_or(0).to_string();
    let all = junit.split("<testsuites ").nth(1).unwrap();
    let all = format!(" {}", all.split('>').next().unwrap());
    assert_eq!(attribute(&all, "failures"), count("failure"));
    assert_eq!(attribute(&all, "errors"), count("error"));
    assert!(
        github.starts_with("::error title=fail%3A internal-support outer-diameter%3A published-theory::"),
        "{github}"
    );
    assert_eq!(github.lines().filter(|l| l.starts_with("::error")).count().to_string(), count("failure"));
    // What is stored is what is printed, and the page says it too.
    let stored = |name: &str| fs::read_to_string(folder.path().join("papers/results").join(name)).unwrap();
    let plain = |format: &str| pneuval(folder.path(), &["gate", "papers", "--format", format]).out;
    assert_eq!(stored("junit.xml"), plain("junit"));
    assert_eq!(stored("summary.md"), plain("markdown"));
    let page = fs::read_to_string(folder.path().join("papers/internal-support.html")).unwrap();
    assert!(["0.8689 mm", "0.9400 mm", "2.811 %"].iter().all(|number| page.contains(number)));
}

#[test]
fn a_document_has_a_failure_or_an_error_if_and_only_if_the_exit_code_is_not_zero() {
    let folder = tempfile::tempdir().unwrap();
    changed(folder.path());
    for (arguments, code) in [
        (&["validate", "--no-report"][..], 0),
        (&["validate", "--no-report", "--bounds", "stricter.toml"], 1),
        (&["validate", "--no-report", "--bounds", "none.toml"], 3),
    ] {
        fs::write(folder.path().join("none.toml"), "schema = 1\n").unwrap();
        let said = pneuval(folder.path(), &[arguments, &["--format", "junit"]].concat());
        assert_eq!(said.code, code, "{}", said.err);
        let all = format!(" {}", said.out.split("<testsuites ").nth(1).unwrap().split('>').next().unwrap());
        let is_bad = attribute(&all, "failures") != "0" || attribute(&all, "errors") != "0";
        assert_eq!(is_bad, code != 0, "{}", said.out);
    }
    // Whoever only reports wants nothing to fail.
    let arguments = ["validate", "--bounds", "stricter.toml", "--report-only", "--no-figures", "--format", "junit"];
    let said = pneuval(folder.path(), &arguments);
    assert!(
        said.code == 0 && fates(&said.out).values().all(|fate| !["failure", "error"].contains(fate)),
        "{}",
        said.out
    );
    assert!(said.out.contains("<skipped>fail: only reported: max |e|"), "{}", said.out);
    let said = pneuval(folder.path(), &["gate", "papers", "--json", "--format", "junit"]);
    assert!(said.code == 2 && said.err.contains("cannot be used with"), "{}", said.err);
}

#[test]
fn the_table_of_points_holds_every_point_of_results_json() {
    let folder = tempfile::tempdir().unwrap();
    let said = pneuval(folder.path(), &["validate", "--out", "papers", "--no-figures"]);
    assert_eq!(said.code, 0, "{}", said.err);
    let read = |name: &str| fs::read_to_string(folder.path().join("papers/results").join(name)).unwrap();
    let results: Value = serde_json::from_str(&read("results.json")).unwrap();
    let csv = read("points.csv");
    let names: Vec<&str> = csv.lines().next().unwrap().split(',').collect();
    let mut rows = csv.lines().skip(1);
    let column = |name: &str| names.iter().position(|n| *n == name).unwrap();
    for c in results["comparisons"].as_array().unwrap() {
        for point in c["points"].as_array().unwrap() {
            let width = c["quantity"]["components"].as_array().unwrap().len().max(1);
            for k in 0..width {
                let row = rows.next().unwrap();
                // Reasons hold commas: only what stands before and behind them is cut here.
                assert!(row.starts_with(c["id"].as_str().unwrap()), "{row}");
                if row.contains('"') {
                    continue;
                }
                let cells: Vec<&str> = row.split(',').collect();
                assert_eq!(cells.len(), names.len(), "{row}");
                assert_eq!(cells[column("status")], point["status"].as_str().unwrap());
                for (name, key) in [("measured_si", "measured"), ("predicted_si", "predicted")] {
                    let value: Option<f64> = cells[column(name)].parse().ok();
                    assert_eq!(value, point[key].get(k).and_then(Value::as_f64), "{name} {row}");
                }
            }
        }
    }
    assert_eq!(rows.next(), None);
}
