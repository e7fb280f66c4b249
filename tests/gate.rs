//! The gate bites: seeded errors just over and just under a bound, and everything that must not pass, through the binary.

// In a test a panic is how a failure is told.
#![allow(clippy::unwrap_used, clippy::panic)]

mod common;

use common::{Lab, datasets, pneuval};

/// Residuals of the made-up table: +1, -2, +3 mm on 20, 30, 40 mm; +0.5 mm at zero.
const METRICS: [(&str, f64, &str); 11] = [
    ("bias", 2.0 / 3.0, "mm"),
    ("mae", 2.0, "mm"),
    ("rmse", 2.160_246_899_469_287, "mm"),
    ("max_abs_error", 3.0, "mm"),
    ("relative_to_measured_max", 7.5, "%"),
    ("relative_to_measured_mean", 100.0 * (1.0 / 20.0 + 2.0 / 30.0 + 3.0 / 40.0) / 3.0, "%"),
    ("relative_to_predicted_max", 100.0 * 2.0 / 28.0, "%"),
    ("relative_to_predicted_mean", 100.0 * (1.0 / 21.0 + 2.0 / 28.0 + 3.0 / 43.0) / 3.0, "%"),
    ("relative_to_range_max", 15.0, "%"),
    ("relative_to_range_rmse", 10.801_234_497_346_433, "%"),
    ("residual_at_zero", 0.5, "mm"),
];

#[test]
fn every_metric_passes_just_under_its_bound_and_fails_just_over() {
    let lab = Lab::new();
    for (metric, value, unit) in METRICS {
        // Printed to six decimals, so the interval is below 1e-4 of every metric.
        lab.bound(metric, value * 1.0001, unit, "pass");
        let said = lab.validate();
        assert_eq!(said.code, 0, "{metric} under its bound: {}{}", said.out, said.err);
        lab.bound(metric, value * 0.9999, unit, "pass");
        let said = lab.validate();
        assert_eq!(said.code, 1, "{metric} over its bound: {}{}", said.out, said.err);
        assert!(said.out.contains("fail, expected to pass"), "{}", said.out);
        // The same through stored results.
        assert_eq!(pneuval(lab.path(), &["gate", "report"]).code, 1, "{metric} gate");
    }
}

#[test]
fn within_the_printed_digits_of_the_bound_it_is_inconclusive() {
    let lab = Lab::new();
    lab.change("size.csv", "43.000000", "43");
    lab.bound("max_abs_error", 3.2, "mm", "pass");
    let said = lab.validate();
    assert_eq!(said.code, 3, "{}", said.out);
    assert!(said.out.contains("could decide it"), "{}", said.out);
}

#[test]
fn an_expected_exceed_is_zero_while_it_exceeds_and_one_when_it_passes() {
    let lab = Lab::new();
    lab.bound("max_abs_error", 2.9, "mm", "exceed");
    assert_eq!(lab.validate().code, 0);
    lab.bound("max_abs_error", 3.1, "mm", "exceed");
    let said = lab.validate();
    assert_eq!(said.code, 1);
    assert!(said.out.contains("expected to exceed"), "{}", said.out);
}

#[test]
fn no_bound_is_unjudged_and_the_report_is_written_all_the_same() {
    let lab = Lab::new();
    let said = lab.validate();
    assert_eq!(said.code, 3);
    assert!(said.out.contains("unjudged") && said.out.contains("write a row in bounds.toml"), "{}", said.out);
    assert!(lab.path().join("report/balloon.html").is_file());
}

#[test]
fn report_only_exits_zero_and_says_so_on_page_one() {
    let lab = Lab::new();
    let said = pneuval(lab.path(), &["validate", ".", "--out", "report", "--report-only"]);
    assert_eq!(said.code, 0);
    let page = std::fs::read_to_string(lab.path().join("report/index.html")).unwrap();
    assert!(page.contains("Report only"));
}

#[test]
fn without_a_report_the_numbers_and_the_exit_code_are_the_same_and_nothing_is_written() {
    let lab = Lab::new();
    for (max, code) in [(3.1, 0), (2.9, 1)] {
        lab.bound("max_abs_error", max, "mm", "pass");
        let written = lab.validate();
        let stored = std::fs::read_to_string(lab.path().join("report/results/results.json")).unwrap();
        std::fs::remove_dir_all(lab.path().join("report")).unwrap();
        let files = || std::fs::read_dir(lab.path()).unwrap().count();
        let before = files();
        let said = pneuval(lab.path(), &["validate", ".", "--no-report"]);
        assert_eq!((said.code, written.code, files()), (code, code, before), "{}{}", said.out, said.err);
        let table = written.out.split("Report:").next().unwrap();
        assert_eq!(said.out, table);
        let said = pneuval(lab.path(), &["validate", ".", "--no-report", "--json"]);
        let numbers = |json: &str| -> serde_json::Value {
            let mut value: serde_json::Value = serde_json::from_str(json).unwrap();
            // The digests of files that are not written.
            value["files"] = serde_json::Value::Null;
            value
        };
        assert_eq!(numbers(&said.out), numbers(&stored));
    }
    for other in [&["--out", "report"][..], &["--no-figures"], &["--report-only"]] {
        let said = pneuval(lab.path(), &[&["validate", ".", "--no-report"], other].concat());
        assert_eq!(said.code, 2, "{other:?}");
        assert!(said.err.contains("cannot be used with"), "{}", said.err);
    }
}

#[test]
fn nan_in_any_column_is_inconclusive_for_every_metric_over_the_points() {
    for cell in ["30.000000", "28.000000"] {
        let lab = Lab::new();
        lab.change("size.csv", cell, "NaN");
        for (metric, _, unit) in METRICS.iter().filter(|(m, ..)| *m != "residual_at_zero") {
            lab.bound(metric, 1e6, unit, "pass");
            let said = lab.validate();
            assert_eq!(said.code, 3, "{metric}: {}", said.out);
            assert!(said.out.contains("not a finite number"), "{}", said.out);
        }
    }
    let lab = Lab::new();
    lab.change("size.csv", "10.500000", "NaN");
    lab.bound("residual_at_zero", 1e6, "mm", "pass");
    assert_eq!(lab.validate().code, 3);
}

#[test]
fn an_empty_overlap_is_inconclusive() {
    let lab = Lab::new();
    lab.write("size.csv", "p,model,measured\nkPa,mm,mm\n0,10,10\n10,,20\n20,28,\n30,,40\n");
    lab.bound("max_abs_error", 100.0, "mm", "pass");
    let said = lab.validate();
    assert_eq!(said.code, 3, "{}", said.out);
    assert!(said.out.contains("no point where both"), "{}", said.out);
}

#[test]
fn a_printed_prediction_missing_at_one_measured_point_leaves_it_open_however_good_the_rest() {
    let lab = Lab::new();
    lab.change("size.csv", "28.000000", "");
    for expect in ["pass", "exceed"] {
        lab.bound("max_abs_error", 1e6, "mm", expect);
        let said = lab.validate();
        assert_eq!(said.code, 3, "{}", said.out);
        assert!(said.out.contains("no predicted value is printed at 1 of 3 measured points"), "{}", said.out);
    }
}

#[test]
fn a_hole_in_the_measured_column_is_counted_and_listed() {
    let lab = Lab::new();
    lab.change("size.csv", "30.000000", "");
    lab.bound("max_abs_error", 3.1, "mm", "pass");
    let said = lab.validate();
    assert_eq!(said.code, 0, "{}", said.out);
    assert!(said.out.contains("2/3"), "{}", said.out);
    let page = std::fs::read_to_string(lab.path().join("report/balloon.html")).unwrap();
    assert!(page.contains("1 not printed") && page.contains("1 zero reference"));
}

#[test]
fn a_named_bounds_file_must_be_there() {
    let lab = Lab::new();
    let said = pneuval(lab.path(), &["validate", ".", "--out", "report", "--bounds", "none.toml"]);
    assert_eq!(said.code, 2);
    assert!(said.err.contains("none.toml") && said.out.is_empty(), "{}", said.err);
    assert!(!lab.path().join("report").exists());
}

#[test]
fn a_calibration_alone_decides_nothing() {
    let lab = Lab::new();
    lab.write("actuator.toml", &std::fs::read_to_string(datasets().join("actuators/internal-support.toml")).unwrap());
    for file in ["dataset.toml", "outer_diameter.csv"] {
        let text = std::fs::read_to_string(datasets().join("published/internal-support").join(file)).unwrap();
        lab.write(file, &text);
    }
    lab.change("dataset.toml", "fit = { to = \"published-fea\"", "fit = { to = \"measured\"");
    lab.write("bounds.toml", "schema = 1\n");
    let text = std::fs::read_to_string(lab.path().join("dataset.toml")).unwrap();
    let from = text.find("[[comparison]]").unwrap();
    let fitted =
        text.find("[[comparison]]\nquantity = \"outer-diameter\"\nform = \"consistent-fitted-to-fea\"").unwrap();
    lab.write("dataset.toml", &format!("{}{}", &text[..from], &text[fitted..]));
    let said = lab.validate();
    assert_eq!(said.code, 3, "{}{}", said.out, said.err);
    assert!(said.out.contains("calibration, not counted"), "{}", said.out);
}

#[test]
fn judge_false_is_shown_and_not_counted() {
    let lab = Lab::new();
    lab.change(
        "dataset.toml",
        "form = \"model\"\n",
        "form = \"model\"\njudge = false\nreason = \"nobody can recompute it\"\n",
    );
    let said = lab.validate();
    assert_eq!(said.code, 3);
    assert!(said.out.contains("unjudged, not counted") && said.out.contains("nobody can recompute it"), "{}", said.out);
}

#[test]
fn gate_with_other_bounds_judges_the_stored_numbers_anew() {
    let lab = Lab::new();
    lab.bound("max_abs_error", 3.1, "mm", "pass");
    assert_eq!(lab.validate().code, 0);
    lab.bound("max_abs_error", 2.9, "mm", "pass");
    assert_eq!(pneuval(lab.path(), &["gate", "report"]).code, 0);
    assert_eq!(pneuval(lab.path(), &["gate", "report", "--bounds", "bounds.toml"]).code, 1);
    assert_eq!(pneuval(lab.path(), &["gate", "report/results/results.json", "--bounds", "bounds.toml"]).code, 1);
    assert_eq!(pneuval(lab.path(), &["gate", "report", "--bounds", "none.toml"]).code, 2);
}

#[test]
fn a_bound_that_meets_no_comparison_is_refused() {
    let lab = Lab::new();
    lab.bound("max_abs_error", 3.1, "mm", "pass");
    lab.change("bounds.toml", "\"model\"", "\"modle\"");
    let said = lab.validate();
    assert_eq!(said.code, 2);
    assert!(said.err.contains("did you mean `model`?"), "{}", said.err);
}

/// A computed form that has a solution at some pressures and none at others.
fn soft_material() -> Lab {
    let lab = Lab::new();
    let from = datasets();
    lab.write("actuator.toml", &std::fs::read_to_string(from.join("actuators/internal-support.toml")).unwrap());
    lab.write("size.csv", "p,measured\nkPa,mm\n10,45\n20,70\n50,80\n");
    lab.change("dataset.toml", "actuator = \"balloon\"", "actuator = \"internal-support\"");
    lab.change("dataset.toml", "id = \"size\"", "id = \"outer-diameter\"");
    lab.change("dataset.toml", "chamber = \"air\"", "chamber = \"chamber\"");
    lab.change("dataset.toml", "predicted = [{ column = \"model\", form = \"model\", title = \"model\" }]\n", "");
    lab.change(
        "dataset.toml",
        "quantity = \"size\"\nform = \"model\"",
        "quantity = \"outer-diameter\"\nform = \"consistent\"",
    );
    lab.bound("max_abs_error", 1e6, "mm", "pass");
    lab.change("bounds.toml", "\"balloon\"", "\"internal-support\"");
    lab.change("bounds.toml", "\"size\"", "\"outer-diameter\"");
    lab.change("bounds.toml", "\"model\"", "\"consistent\"");
    lab
}

#[test]
fn a_model_without_solution_at_one_measured_point_fails_however_good_the_rest() {
    let lab = soft_material();
    let said = lab.validate();
    assert_eq!(said.code, 1, "{}{}", said.out, said.err);
    assert!(
        said.out.contains("no prediction at 1 of 3 measured points: no solution at 50 kPa: the limit is"),
        "{}",
        said.out
    );
}

#[test]
fn of_two_bounds_the_one_that_makes_the_exit_code_is_told() {
    let lab = Lab::new();
    lab.bound("max_abs_error", 1.0, "mm", "exceed");
    let first = std::fs::read_to_string(lab.path().join("bounds.toml")).unwrap();
    for (rmse, code, words) in [(1.0, 1, "RMSE is 2.1602 mm"), (3.0, 0, "as expected")] {
        lab.bound("rmse", rmse, "mm", "pass");
        let second = std::fs::read_to_string(lab.path().join("bounds.toml")).unwrap();
        lab.write("bounds.toml", &format!("{first}{}", second.strip_prefix("schema = 1\n").unwrap()));
        let said = lab.validate();
        assert_eq!(said.code, code, "{}", said.out);
        assert!(said.out.contains(words), "{}", said.out);
    }
}

#[test]
fn several_zero_references_are_all_looked_at() {
    let lab = Lab::new();
    lab.change("size.csv", "10,21.000000", "0,99.000000,10.000000\n10,21.000000");
    lab.bound("residual_at_zero", 2.0, "mm", "pass");
    assert_eq!(lab.validate().code, 1);
}

#[test]
fn a_closed_pipe_does_not_change_the_verdict() {
    use std::process::{Command, Stdio};
    let lab = Lab::new();
    lab.bound("max_abs_error", 1.0, "mm", "pass");
    assert_eq!(lab.validate().code, 1);
    for arguments in [&["gate", "report"][..], &["validate", ".", "--out", "report"], &["gate", "report", "--json"]] {
        let mut child = Command::new(env!("CARGO_BIN_EXE_pneuval"))
            .current_dir(lab.path())
            .args(arguments)
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        drop(child.stdout.take());
        assert_eq!(child.wait().unwrap().code(), Some(1), "{arguments:?}");
    }
}

#[test]
fn gate_judges_what_is_named_and_nothing_else() {
    let lab = Lab::new();
    lab.bound("max_abs_error", 3.1, "mm", "pass");
    assert_eq!(lab.validate().code, 0);
    for wrong in ["report/results/baseline.json", "report/nosuch", "nosuch", "report/index.html"] {
        assert_eq!(pneuval(lab.path(), &["gate", wrong]).code, 2, "{wrong}");
    }
    assert_eq!(pneuval(&lab.path().join("report/results"), &["gate", "nosuch"]).code, 2);
    assert_eq!(pneuval(&lab.path().join("report/results"), &["gate", "."]).code, 0);
    let figure = lab.path().join("report/results/figures/balloon_size_response.png");
    std::fs::remove_file(figure).unwrap();
    assert_eq!(pneuval(lab.path(), &["gate", "report"]).code, 2);
}

#[test]
fn a_bound_that_gate_does_not_use_is_told() {
    let lab = Lab::new();
    lab.bound("max_abs_error", 3.1, "mm", "pass");
    assert_eq!(lab.validate().code, 0);
    let text = std::fs::read_to_string(lab.path().join("bounds.toml")).unwrap();
    let row = text.strip_prefix("schema = 1\n").unwrap().replace("\"model\"", "\"modle\"");
    std::fs::write(lab.path().join("lab.toml"), format!("{text}{row}")).unwrap();
    let said = pneuval(lab.path(), &["gate", "report", "--bounds", "lab.toml"]);
    assert!(said.code == 0 && said.err.contains("modle met no comparison"), "{}", said.err);
}

#[test]
fn the_measured_column_cannot_be_its_own_prediction() {
    let lab = Lab::new();
    lab.change("dataset.toml", "column = \"model\", form", "column = \"measured\", form");
    let said = lab.validate();
    assert!(said.code == 2 && said.err.contains("the measured column"), "{}", said.err);
}

/// A comparison of the stored results.
fn stored(lab: &Lab, id: &str) -> serde_json::Value {
    let text = std::fs::read_to_string(lab.path().join("report/results/results.json")).unwrap();
    let results: serde_json::Value = serde_json::from_str(&text).unwrap();
    results["comparisons"].as_array().unwrap().iter().find(|c| c["id"] == id).unwrap().clone()
}

#[test]
fn a_stated_error_is_judged_on_what_its_digits_leave_open() {
    for (max, code) in [(0.963, 0), (0.962, 3), (0.961, 1)] {
        let lab = Lab::new();
        lab.change("dataset.toml", "[[comparison]]\nquantity = \"size\"\nform = \"model\"\n", "");
        lab.change(
            "dataset.toml",
            "[[table]]",
            "[[statistic]]\nquantity = { id = \"tip\", title = \"Tip\", unit = \"mm\" }\nform = \"stated\"\n\
             title = \"as stated\"\nplace = \"section 4\"\nmethod = \"camera\"\nmetrics = { rmse = \"0.962\" }\n\n[[table]]",
        );
        lab.bound("rmse", max, "mm", "pass");
        lab.change("bounds.toml", "\"size\"", "\"tip\"");
        lab.change("bounds.toml", "\"model\"", "\"stated\"");
        let said = lab.validate();
        assert_eq!(said.code, code, "{max}: {}{}", said.out, said.err);
        // Nobody can compute it again, and a metric that is not printed cannot be judged.
        assert_eq!(stored(&lab, "balloon/tip/stated")["metrics_printed"], true);
        lab.change("bounds.toml", "\"rmse\"", "\"max_abs_error\"");
        assert_eq!(lab.validate().code, 3);
    }
}

#[test]
fn the_error_of_a_position_is_a_distance() {
    let lab = Lab::new();
    lab.write("size.csv", "p,mx,mz,x,z\nkPa,mm,mm,mm,mm\n10,3.000000,4.000000,0.000000,0.000000\n20,5.000000,5.000000,5.000000,4.000000\n");
    lab.change("dataset.toml", "unit = \"mm\" }", "unit = \"mm\", components = [\"x\", \"z\"] }");
    lab.change("dataset.toml", "column = \"measured\"", "column = [\"x\", \"z\"]");
    lab.change("dataset.toml", "column = \"model\"", "column = [\"mx\", \"mz\"]");
    for (max, code) in [(5.0001, 0), (4.9999, 1)] {
        lab.bound("max_abs_error", max, "mm", "pass");
        let said = lab.validate();
        assert_eq!(said.code, code, "{}{}", said.out, said.err);
    }
    let row = stored(&lab, "balloon/size/model");
    assert_eq!(row["points"][0]["predicted"].as_array().unwrap().len(), 2);
    assert!((row["points"][0]["residual"].as_f64().unwrap() - 5e-3).abs() < 1e-12);
}

#[test]
fn an_imported_table_is_interpolated_and_never_extrapolated() {
    let lab = Lab::new();
    let text = std::fs::read_to_string(lab.path().join("actuator.toml")).unwrap();
    let model = "[[model]]\nkind = \"imported\"\nform = \"fem\"\nfile = \"fem.csv\"\npredicted = \"u\"\nstd = \"s\"\n\
                 quantity = { id = \"size\", title = \"Size\", unit = \"mm\" }\n\
                 pressure = { column = \"p\", chamber = \"air\", reference = \"gauge\" }\n";
    lab.write("actuator.toml", &format!("{text}\n{model}"));
    lab.change("dataset.toml", "form = \"model\"\n", "form = \"fem\"\n");
    // At 10, 20, 30 kPa: 21, 31, 41 where 20, 30, 40 were measured.
    let table = "p,u,s\nkPa,mm,mm\n0,11,0.1\n15,26,0.1\n30,41,0.1\n";
    for (max, rows, code) in [(1.3, table, 0), (1.1, table, 3), (0.7, table, 1), (1e6, &table[..table.len() - 10], 1)] {
        lab.write("fem.csv", rows);
        lab.bound("max_abs_error", max, "mm", "pass");
        lab.change("bounds.toml", "\"model\"", "\"fem\"");
        let said = lab.validate();
        assert_eq!(said.code, code, "{max}: {}{}", said.out, said.err);
        let row = stored(&lab, "balloon/size/fem");
        assert_eq!(row["kind"], "imported");
        assert!((row["points"][1]["predicted"][0].as_f64().unwrap() - 21e-3).abs() < 1e-12);
        // Two of the table's standard uncertainties.
        assert!(
            (row["points"][1]["predicted_half_width"][0].as_f64().unwrap() - 1.959_963_984_540_054 * 0.1e-3).abs()
                < 1e-12
        );
    }
    let last = stored(&lab, "balloon/size/fem")["points"][3].clone();
    assert!(last["predicted"].is_null() && last["reason"].as_str().unwrap().contains("nothing is extrapolated"));
}

#[test]
fn points_that_a_fit_has_seen_judge_nothing() {
    let lab = Lab::new();
    let published = datasets().join("published/internal-support");
    lab.write("actuator.toml", &std::fs::read_to_string(datasets().join("actuators/internal-support.toml")).unwrap());
    for file in ["dataset.toml", "outer_diameter.csv"] {
        lab.write(file, &std::fs::read_to_string(published.join(file)).unwrap());
    }
    lab.change(
        "dataset.toml",
        "fit = { to = \"published-fea\"",
        "fit = { hold_out = \"odd-pressures\", to = \"measured\"",
    );
    lab.write("bounds.toml", "schema = 1\n");
    lab.validate();
    let row = stored(&lab, "internal-support/outer-diameter/consistent-fitted-to-fea");
    let status: Vec<&str> = row["points"].as_array().unwrap().iter().map(|p| p["status"].as_str().unwrap()).collect();
    // 0 kPa is the reference and number 0: fitted on 20 and 40 kPa, judged on 10, 30 and 50.
    assert_eq!(status, ["zero_reference", "used", "in_fit", "used", "in_fit", "used"]);
    assert_eq!((&row["fit"]["n"], &row["n_used"], &row["verdict"]), (&2.into(), &3.into(), &"unjudged".into()));
    assert_eq!(row["counted"], true);
}
