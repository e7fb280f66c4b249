//! Traps: data that look as if they said something. Each ends with the exit code of its kind, and the cause is named.

// In a test a panic is how a failure is told.
#![allow(clippy::unwrap_used, clippy::panic)]

mod common;

use std::fmt::Write;

use common::sitting::{FEA, SESSION, Sitting, findings, points};
use common::{Lab, Said};
use serde_json::Value;

/// What the imported model says, and what a finger that agrees with it does.
const STATES: [(&str, &str); 5] = [("0", "0,0"), ("10", "5,0"), ("20", "10,0"), ("30", "20,0"), ("40", "30,0")];

/// A log of five steady states with other values in some of them; a last digit of its own for each run.
fn log(run: usize, states: &[(&str, &str)]) -> String {
    let mut log = String::from("pressure (kPa);stroke [mm]\n");
    for (pressure, stroke) in states {
        let digit = if stroke.contains(',') { format!("{run}") } else { String::new() };
        writeln!(log, "{pressure};{stroke}{digit}").unwrap();
    }
    log
}

fn with_strokes(strokes: [&'static str; 5]) -> [(&'static str, &'static str); 5] {
    std::array::from_fn(|i| (STATES[i].0, strokes[i]))
}

/// A session of three runs of the same states, and a bound of 1 mm on the largest error.
fn three_runs(states: &[(&str, &str)]) -> Sitting {
    let sitting = Sitting::new();
    let mut runs = String::new();
    for run in 1..=3 {
        sitting.write(&format!("log{run}.csv"), &log(run, states));
        write!(runs, "[[run]]\nfile = \"log{run}.csv\"\n").unwrap();
    }
    sitting.change("session.toml", "[[run]]\nfile = \"log.csv\"\n", &runs);
    sitting.bound(1.0, "");
    sitting
}

/// The exit code, and words on either stream.
fn assert_said(said: &Said, code: i32, words: &[&str]) {
    let all = format!("{}{}", said.out, said.err);
    assert_eq!(said.code, code, "{all}");
    for word in words {
        assert!(all.contains(word), "no {word:?} in: {all}");
    }
}

fn metric<'a>(results: &'a Value, id: &str) -> &'a Value {
    results["comparisons"][0]["metrics"].as_array().unwrap().iter().find(|m| m["metric"] == id).unwrap()
}

#[test]
fn three_of_five_nan_in_a_log_hide_no_huge_error_and_let_nothing_pass() {
    // The huge error is seen: it fails, and the holes are told.
    let seen = three_runs(&with_strokes(["0,0", "NaN", "NaN", "NaN", "300,0"]));
    assert_said(&seen.validate(), 1, &["beyond the bound", "3 cells say that there is no value", "line 3: `NaN`"]);
    // What is left agrees: that is no pass of the session, most of which nobody knows.
    let left = three_runs(&with_strokes(["0,0", "NaN", "NaN", "NaN", "30,0"]));
    assert_said(&left.validate(), 3, &["3 cells say that there is no value", "too many are excluded"]);
    let comparison = &left.results()["comparisons"][0];
    assert_eq!((&comparison["n_used"], &comparison["n_available"]), (&1.into(), &5.into()));
}

/// Five pressures beside zero, in print.
const PRINTED: &str =
    "p,model,measured\nkPa,mm,mm\n0,10.5,10.0\n10,21.0,20.5\n20,30.0,30.5\n25,35.0,35.5\n30,40.0,40.5\n35,45.0,45.5\n";

#[test]
fn three_of_five_nan_in_a_printed_table_leave_a_huge_error_open() {
    for (column, to) in [("measured", "NaN"), ("model", "NaN")] {
        let lab = Lab::new();
        lab.bound("max_abs_error", 1.0, "mm", "pass");
        lab.write("size.csv", PRINTED);
        assert_eq!(lab.validate().code, 0);
        lab.change("size.csv", "10,21.0", "10,900.0");
        assert_said(&lab.validate(), 1, &["beyond the bound"]);
        for (model, measured) in [("30.0", "30.5"), ("35.0", "35.5"), ("40.0", "40.5")] {
            let (model_to, measured_to) = if column == "model" { (to, measured) } else { (model, to) };
            lab.change("size.csv", &format!("{model},{measured}"), &format!("{model_to},{measured_to}"));
        }
        assert_said(&lab.validate(), 3, &["value is not a finite number", "could decide it"]);
    }
}

#[test]
fn a_brought_table_with_nan_is_the_users_to_mend() {
    let sitting = three_runs(&STATES);
    assert_eq!(sitting.validate().code, 0);
    sitting.write("fea.csv", "p,u3,u3_std\nkPa,mm,mm\n0,0,0\n10,NaN,0.01\n20,NaN,0.01\n30,NaN,0.01\n40,300.0,0.01\n");
    assert_said(&sitting.validate(), 2, &["fea.csv:4: column `u3`", "a number in every row"]);
}

#[test]
fn one_repeat_decides_nothing_however_well_it_agrees_or_fails() {
    for max in [100.0, 0.001] {
        let sitting = Sitting::new();
        sitting.bound(max, "");
        assert_said(&sitting.validate(), 3, &["from one repeat", "more repeats"]);
        let results = sitting.results();
        assert!(metric(&results, "max_abs_error")["upper"].is_null());
    }
}

#[test]
fn a_measured_channel_that_never_moves_is_told_and_gives_no_share_of_a_range() {
    let sitting = three_runs(&with_strokes(["5,0"; 5]));
    // Three runs, three readings: not constant, and yet no range.
    assert_said(&sitting.validate(), 1, &["beyond the bound"]);
    sitting.change("bounds.toml", "max_abs_error", "relative_to_range_max");
    sitting.change("bounds.toml", "unit = \"mm\"", "unit = \"%\"");
    assert_said(&sitting.validate(), 3, &["the measured values do not span a range"]);
    let results = sitting.results();
    for id in ["relative_to_range_max", "relative_to_range_rmse"] {
        let record = metric(&results, id);
        assert!(record["value"].is_null() && record["upper"].is_null(), "{record}");
    }
    // The same reading throughout: repeats that agree to the last digit, and a sensor that may have stopped.
    for run in 1..=3 {
        sitting.write(&format!("log{run}.csv"), &(log(0, &with_strokes(["5,0"; 5])) + &"\n".repeat(run)));
    }
    let said = sitting.validate();
    assert_said(&said, 3, &["channel `stroke` is 5 mm in all 15 samples", "did the sensor stop"]);
    let told = sitting.results();
    assert_eq!(findings(&told, "constant")[0]["severity"], "note");
}

#[test]
fn a_pressure_that_never_moves_is_told() {
    // The stroke goes through its range while the pressure is said to stay.
    let stuck: Vec<(&str, &str)> = STATES.iter().map(|(_, stroke)| ("20", *stroke)).collect();
    let sitting = three_runs(&stuck);
    assert_said(&sitting.validate(), 1, &["channel `pressure` is 20 kPa in all 15 samples", "did the sensor stop"]);
    // Stuck at zero there is nothing but references.
    let zero: Vec<(&str, &str)> = STATES.iter().map(|(_, stroke)| ("0", *stroke)).collect();
    let sitting = three_runs(&zero);
    assert_said(&sitting.validate(), 3, &["channel `pressure` is 0 kPa", "no point where both"]);
    // One that moves is not told.
    let sitting = three_runs(&STATES);
    sitting.validate();
    assert!(findings(&sitting.results(), "constant").is_empty());
}

#[test]
fn a_log_whose_stamps_fall_is_no_measurement_of_its_states() {
    let sitting = three_runs(&STATES);
    let session = SESSION.replacen("[[channel]]", "[clock]\ncolumn = \"t\"\nunit = \"s\"\n\n[[channel]]", 1);
    sitting.write("session.toml", &session);
    let stamped = |stamp: fn(usize) -> usize| {
        let mut rows = String::from("t;pressure (kPa);stroke [mm]\n");
        for (i, (pressure, stroke)) in STATES.iter().enumerate() {
            writeln!(rows, "{};{pressure};{stroke}", stamp(i)).unwrap();
        }
        rows
    };
    sitting.write("log.csv", &stamped(|i| 9 - i));
    assert_said(&sitting.validate(), 3, &["time goes back, first from 9 s back to 8 s", "4 samples left out"]);
    let results = sitting.results();
    assert_eq!(results["comparisons"][0]["n_used"], 0);
    assert_eq!(findings(&results, "time-reversed")[0]["severity"], "excluded");
    // With stamps that rise the same rows are five states.
    sitting.write("log.csv", &stamped(|i| i));
    sitting.validate();
    assert_eq!(sitting.results()["comparisons"][0]["n_used"], 4);
}

#[test]
fn rows_in_falling_order_give_the_numbers_of_rising_ones() {
    // The values of every metric, and of every point by its pressure.
    let numbers = |results: &Value| {
        let metrics = results["comparisons"][0]["metrics"].clone();
        let mut rows: Vec<String> = Vec::new();
        for point in points(results, 0) {
            let (pressure, residual) = (&point["pressures_gauge_pa"][0], &point["residual"]);
            rows.push(format!("{pressure} {} {} {residual}", point["measured"][0], point["predicted"][0]));
        }
        rows.sort();
        (metrics, rows)
    };
    // In another order of addition the last bits may differ.
    let same = |rising: &Value, falling: &Value| {
        let ((a, rows_a), (b, rows_b)) = (numbers(rising), numbers(falling));
        assert_eq!(rows_a, rows_b);
        for (a, b) in a.as_array().unwrap().iter().zip(b.as_array().unwrap()) {
            for key in ["value", "lower", "upper"] {
                let (a, b) = (a[key].as_f64(), b[key].as_f64());
                let near = a.zip(b).is_none_or(|(a, b)| (a - b).abs() <= 1e-12 * a.abs().max(1e-3));
                assert!(a.is_some() == b.is_some() && near, "{a:?} {b:?}");
            }
        }
    };
    // A log, and the model's own table.
    let rising = three_runs(&STATES);
    assert_eq!(rising.validate().code, 0);
    let fallen: Vec<(&str, &str)> = STATES.iter().rev().copied().collect();
    let falling = three_runs(&fallen);
    let mut table: Vec<&str> = FEA.lines().collect();
    table[2..].reverse();
    falling.write("fea.csv", &(table.join("\n") + "\n"));
    assert_eq!(falling.validate().code, 0);
    same(&rising.results(), &falling.results());
    // Neither up nor down is no function of the pressure.
    falling.write("fea.csv", "p,u3,u3_std\nkPa,mm,mm\n0,0,0\n40,30.0,0.01\n20,10.0,0.01\n");
    assert_said(&falling.validate(), 2, &["fea.csv:5: column `p`", "rise from row to row, or fall"]);
    // A printed table.
    let lab = Lab::new();
    lab.bound("max_abs_error", 1.0, "mm", "pass");
    let results = |text: &str| -> Value {
        lab.write("size.csv", text);
        assert_eq!(lab.validate().code, 0);
        serde_json::from_slice(&std::fs::read(lab.path().join("report/results/results.json")).unwrap()).unwrap()
    };
    let mut rows: Vec<&str> = PRINTED.lines().collect();
    rows[2..].reverse();
    same(&results(PRINTED), &results(&(rows.join("\n") + "\n")));
}

#[test]
fn a_model_fitted_on_the_same_run_is_calibration_however_good_it_looks() {
    let sitting = Sitting::new();
    sitting.write(
        "actuator.toml",
        "schema = 1\nid = \"bender\"\ntype = \"constant-curvature\"\ntitle = \"Bender\"\nsummary = \"Bends.\"\n[chamber.chamber]\n\
         pressure_gauge_max = { value = 40, unit = \"kPa\", source = \"measured\" }\n[geometry]\n\
         angle_per_pressure = { value = 0.02, unit = \"rad/kPa\", source = \"assumed\", place = \"start of the fit\" }\n",
    );
    for run in 1..=2 {
        sitting.write(
            &format!("log{run}.csv"),
            &format!("p,angle\nkPa,rad\n0,0\n10,0.10{run}\n20,0.20{run}\n30,0.30{run}\n40,0.40{run}\n"),
        );
    }
    let session = "schema = 1\nid = \"bend\"\nactuator = \"bender\"\n[[channel]]\nid = \"p\"\ncolumn = \"p\"\nreference = \"gauge\"\n\
                   [[channel]]\nid = \"angle\"\ncolumn = \"angle\"\n[[run]]\nfile = \"log1.csv\"\n[[run]]\nfile = \"log2.csv\"\n[[response]]\n\
                   quantity = { id = \"bending-angle\", title = \"Angle\", unit = \"rad\" }\n\
                   pressure = [{ channel = \"p\", chamber = \"chamber\" }]\nmeasured = { channel = \"angle\" }\n[[comparison]]\n\
                   quantity = \"bending-angle\"\nform = \"linear-angle\"\n";
    sitting.write(
        "bounds.toml",
        "schema = 1\n[[bound]]\nactuator = \"bender\"\nquantity = \"bending-angle\"\nmodel = \"linear-angle\"\n\
         metric = \"max_abs_error\"\nmax = { value = 0.1, unit = \"rad\" }\nreason = \"a test\"\n",
    );
    let fit = "fit = { to = \"measured\", parameters = [\"angle_per_pressure\"] }\n";
    sitting.write("session.toml", &format!("{session}{fit}"));
    assert_said(&sitting.validate(), 3, &["calibration, not counted", "fitted"]);
    assert_eq!(sitting.results()["comparisons"][0]["verdict"], "calibration");
    // Unfitted, the same model is judged by the same bound, and found wanting.
    sitting.write("session.toml", session);
    assert_said(&sitting.validate(), 1, &["beyond the bound"]);
}
