//! Sittings of several devices through the binary: each writes a file of its own, and one clock stamps them all or does not.

// In a test a panic is how a failure is told.
#![allow(clippy::unwrap_used, clippy::panic)]

mod common;

use std::fmt::Write as _;
use std::fs;
use std::io::Cursor;

use common::sitting::{Sitting, findings, measured, points, with_log};
use common::{Said, pneuval};
use pneuval_ingest::finding::LineMap;
use pneuval_ingest::formats::csv::Decimal;
use pneuval_ingest::formats::{mcap, tdms};
use pneuval_ingest::recording::{Cells, Column, Table};
use pneuval_ingest::store::read_parquet;
use serde_json::Value;

/// Pressure at 100 Hz beside the stroke of a tracker at 40 Hz, three runs.
const SESSION: &str = r#"schema = 1
id = "monday"
actuator = "my-bellows"
clocks = "one"

[reader]
format = "csv"

[clock]
column = "t"
unit = "ms"

[[device]]
id = "tracker"
reader = { format = "trakstar" }
clock = { column = "time1", unit = "s" }

[[channel]]
id = "pressure"
column = "p"
unit = "kPa"
reference = "gauge"

[[channel]]
id = "stroke"
device = "tracker"
column = "x1"
unit = "mm"

[[run]]
id = "run-1"
file = "rig-1.csv"
files = { tracker = "tracker-1.log" }

[[run]]
id = "run-2"
file = "rig-2.csv"
files = { tracker = "tracker-2.log" }

[[run]]
id = "run-3"
file = "rig-3.csv"
files = { tracker = "tracker-3.log" }

[[response]]
quantity = { id = "stroke", title = "Stroke", unit = "mm" }
pressure = [{ channel = "pressure", chamber = "air" }]
measured = { channel = "stroke" }
points = { from = "plateaus", tolerance = { value = 0.1, unit = "kPa" }, hold = { value = 1.9, unit = "s" }, window = { value = 0.5, unit = "s" } }
"#;

/// The same actuator without a model.
const PLAIN: &str = r#"schema = 1
id = "my-bellows"
title = "My bellows"
summary = "A bellows nobody has published."

[chamber.air]
pressure_gauge_max = { value = 40, unit = "kPa", source = "measured" }
"#;

/// Plateaus of 2 s at 0, 20 and 40 kPa; every run drifts by a few Pa, so that no two logs are the same.
fn rig(run: u32) -> String {
    let line = |i: u32| format!("{},{}\n", 10 * i, 20.0 * f64::from(i / 200) + 0.001 * f64::from(run));
    format!("t,p\n{}", (0..600).map(line).collect::<String>())
}

/// What the tracker saw at each plateau of a run, in mm.
fn stroke(run: u32, plateau: u32) -> f64 {
    [0.0, 10.0, 30.0][plateau as usize] + 0.1 * f64::from(run)
}

/// The tracker's log from `begin_s` to `end_s` after the rig began: noise of which the mean over a window is zero, and in the first
/// second of every plateau, when it still moves, 5 mm too much.
fn tracked(run: u32, from_s: f64, samples: u32) -> String {
    let mut log = "x1,y1,z1,a1,e1,r1,time1,quality1\n".to_owned();
    for i in 0..samples {
        let at = i % 80;
        let moving = if at < 40 { 5.0 } else { 0.0 };
        let noise = if i % 2 == 0 { 0.2 } else { -0.2 };
        let x = stroke(run, (i / 80).min(2)) + moving + noise;
        writeln!(log, "{x:.3},0.1,0.2,1,2,3,{:.3},50", from_s + f64::from(i) / 40.0).unwrap();
    }
    log
}

/// Lines, each with its end.
fn text(lines: impl IntoIterator<Item = String>) -> String {
    lines.into_iter().fold(String::new(), |text, line| text + &line + "\n")
}

/// A log without the lines from number `from` to `to` behind its header.
fn without(log: &str, from: usize, to: usize) -> String {
    text(log.lines().enumerate().filter(|(i, _)| !(from..=to).contains(i)).map(|(_, line)| line.to_owned()))
}

fn sitting() -> Sitting {
    let sitting = Sitting::new();
    sitting.write("session.toml", SESSION);
    for run in 1..=3 {
        sitting.write(&format!("rig-{run}.csv"), &rig(run));
        sitting.write(&format!("tracker-{run}.log"), &tracked(run, 0.0, 240));
    }
    sitting
}

fn measured_mm(results: &Value) -> Vec<f64> {
    points(results, 0).iter().map(|point| point["measured"][0].as_f64().unwrap() * 1e3).collect()
}

fn near(found: &[f64], expected: &[f64]) {
    assert_eq!(found.len(), expected.len(), "{found:?}");
    assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-9), "{found:?} {expected:?}");
}

fn ingest(sitting: &Sitting) -> (Said, Value) {
    let said = pneuval(sitting.path(), &["ingest", ".", "--json"]);
    let told: Value = serde_json::from_str(&said.out).unwrap_or_else(|error| panic!("{error}: {}", said.err));
    (said, told[0].clone())
}

#[test]
fn what_another_device_measured_is_the_mean_over_each_plateau() {
    let sitting = sitting();
    let said = sitting.validate();
    assert_eq!(said.code, 3, "{}", said.err);
    let results = sitting.results();
    // The mean over three runs: 0.2 mm more than at rest.
    near(&measured_mm(&results), &[0.2, 10.2, 30.2]);
    assert_eq!(points(&results, 0)[1]["runs"], serde_json::json!(["run-1", "run-2", "run-3"]));
    let session = &results["actuators"][0]["datasets"][0]["session"];
    assert_eq!((&session["samples_read"], &session["samples_excluded"]), (&2520.into(), &0.into()));
    // Of each plateau the last 0.5 s: 51 samples of the rig, 20 of the tracker.
    let census = &session["responses"][0];
    assert_eq!((&census["samples"], &census["holes"]), (&2520.into(), &0.into()));
    assert_eq!(census["used"], 9 * (51 + 20));
}

#[test]
fn a_store_keeps_devices_apart_and_reads_only_what_has_changed() {
    let sitting = sitting();
    let (said, told) = ingest(&sitting);
    assert_eq!(said.code, 0, "{}", said.err);
    let files = told["record"]["files"].as_array().unwrap();
    let of =
        |file: &Value| (file["name"].clone(), file["device"].clone(), file["runs"][0]["tables"][0]["file"].clone());
    assert_eq!(of(&files[0]), ("rig-1.csv".into(), Value::Null, "run-1.parquet".into()));
    assert_eq!(of(&files[1]), ("tracker-1.log".into(), "tracker".into(), "run-1.tracker.parquet".into()));
    assert_eq!((files.len(), told["read"].as_array().unwrap().len()), (6, 6));
    let columns = read_parquet(&sitting.path().join(".pneuval/run-3.tracker.parquet")).unwrap();
    let names: Vec<&str> = columns.iter().map(|(name, _)| name.as_str()).collect();
    assert_eq!((names, columns[0].1.len()), (vec!["time_s", "stroke_m"], 240));
    let (_, told) = ingest(&sitting);
    assert_eq!((told["read"].as_array().unwrap().len(), told["unchanged"].as_array().unwrap().len()), (0, 6));
    sitting.write("tracker-2.log", &tracked(2, 0.0, 239));
    let (_, told) = ingest(&sitting);
    assert_eq!(told["read"], serde_json::json!(["tracker-2.log"]));
    assert!(pneuval(sitting.path(), &["ingest", "."]).out.contains("run-2.tracker.parquet"));
}

/// The session with the runs numbered `runs` only.
fn with_runs(runs: &[u32]) -> Sitting {
    let sitting = sitting();
    for run in (1..=3).filter(|run| !runs.contains(run)) {
        let block = format!(
            "[[run]]\nid = \"run-{run}\"\nfile = \"rig-{run}.csv\"\nfiles = {{ tracker = \"tracker-{run}.log\" }}\n"
        );
        sitting.change("session.toml", &block, "");
    }
    sitting
}

#[test]
fn a_window_without_a_sample_is_a_hole_and_told() {
    // The tracker of run 2 was switched on during the second plateau and off before the last; that of run 3 an hour too late.
    let sitting = sitting();
    let late = without(&tracked(2, 0.0, 200), 1, 90);
    sitting.write("tracker-2.log", &late);
    sitting.write("tracker-3.log", &tracked(3, 3600.0, 240));
    let said = sitting.validate();
    assert_eq!(said.code, 3, "{}", said.err);
    let results = sitting.results();
    near(&measured_mm(&results), &[0.1, 10.15, 30.1]);
    assert_eq!(points(&results, 0)[1]["runs"], serde_json::json!(["run-1", "run-2"]));
    let told = findings(&results, "unmet-plateaus");
    assert_eq!(told.len(), 2, "{told:?}");
    for (finding, file, severity, word) in [
        (
            told[0],
            "tracker-3.log",
            "lost",
            "3 of 3 plateaus, which lie from 1.490 s to 5.990 s; its samples reach from 3600.000 s",
        ),
        (told[1], "tracker-2.log", "excluded", "2 of 3 plateaus"),
    ] {
        assert_eq!((&finding["file"], &finding["severity"]), (&file.into(), &severity.into()));
        assert!(finding["text"].as_str().unwrap().contains(word), "{finding}");
    }
}

#[test]
fn a_device_that_lost_much_is_seen_beside_a_fast_logger() {
    // 30 of 240 poses are holes: an eighth of what the tracker saw, a thirtieth of all samples.
    let sitting = with_runs(&[1]);
    let mut lines: Vec<String> = tracked(1, 0.0, 240).lines().map(str::to_owned).collect();
    for line in &mut lines[1..31] {
        *line = line.replacen(line.split(',').next().unwrap(), "ERR", 1);
    }
    sitting.write("tracker-1.log", &(lines.join("\n") + "\n"));
    sitting.validate();
    let results = sitting.results();
    let session = &results["actuators"][0]["datasets"][0]["session"];
    assert_eq!((&session["samples_read"], &session["samples_excluded"]), (&840.into(), &30.into()));
    let tables = serde_json::json!([{"table": "`file`", "samples": 600, "holes": 0}, {"table": "tracker", "samples": 240, "holes": 30}]);
    assert_eq!(session["responses"][0]["tables"], tables);
    let page = fs::read_to_string(sitting.path().join("report/index.html")).unwrap();
    assert!(page.contains("30 of 240 samples of tracker are excluded, more than the 5.000 % allowed"), "{page}");
}

#[test]
fn components_of_several_devices_are_each_the_mean_of_their_own_samples() {
    let sitting = with_runs(&[1]);
    sitting.change("session.toml", "[[channel]]\nid = \"stroke\"", "[[device]]\nid = \"gauge\"\nreader = { format = \"csv\" }\n\
        clock = { rate = { value = 10, unit = \"Hz\" } }\n[[channel]]\nid = \"z\"\ndevice = \"gauge\"\ncolumn = 1\nunit = \"mm\"\n[[channel]]\nid = \"stroke\"");
    sitting.change(
        "session.toml",
        "tracker = \"tracker-1.log\"",
        "tracker = \"tracker-1.log\", gauge = \"gauge-1.csv\"",
    );
    sitting.change(
        "session.toml",
        "title = \"Stroke\", unit = \"mm\"",
        "title = \"Tip\", unit = \"mm\", components = [\"x\", \"z\"]",
    );
    sitting.change("session.toml", "channel = \"stroke\" }", "channel = [\"stroke\", \"z\"] }");
    sitting.write("actuator.toml", PLAIN);
    // Every 0.1 s its own number: within 1.49 to 1.99 s lie 15 to 19.
    sitting.write("gauge-1.csv", &text((0..60).map(|i| format!("{i}.0"))));
    let said = sitting.validate();
    assert_eq!(said.code, 3, "{}", said.err);
    let results = sitting.results();
    near(&measured_mm(&results), &[0.1, 10.1, 30.1]);
    let z: Vec<f64> = points(&results, 0).iter().map(|p| p["measured"][1].as_f64().unwrap() * 1e3).collect();
    near(&z, &[17.0, 37.0, 57.0]);
}

#[test]
fn a_file_that_cannot_be_used_is_lost_and_its_run_keeps_the_other_channels() {
    let sitting = sitting();
    sitting.write("tracker-2.log", "the tracker was off\n");
    let said = sitting.validate();
    assert_eq!(said.code, 3, "{}", said.err);
    let results = sitting.results();
    near(&measured_mm(&results), &[0.2, 10.2, 30.2]);
    assert_eq!(points(&results, 0)[1]["runs"], serde_json::json!(["run-1", "run-3"]));
    let lost = findings(&results, "unusable-file")[0];
    assert_eq!((&lost["file"], &lost["severity"]), (&"tracker-2.log".into(), &"lost".into()));
    let runs = results["actuators"][0]["datasets"][0]["session"]["runs"].as_array().unwrap();
    let files: Vec<&str> = runs.iter().map(|run| run["file"].as_str().unwrap()).collect();
    assert_eq!(files, ["rig-1.csv, tracker-1.log", "rig-2.csv", "rig-3.csv, tracker-3.log"]);
    // The logger's file lost: what the tracker saw is stored all the same.
    sitting.write("rig-3.csv", "the rig was off\n");
    let (said, told) = ingest(&sitting);
    assert_eq!(said.code, 3, "{}", said.err);
    let stored: Vec<usize> =
        told["record"]["files"].as_array().unwrap().iter().map(|f| f["runs"].as_array().unwrap().len()).collect();
    assert_eq!(stored, [1, 1, 1, 0, 0, 1]);
    sitting.validate();
    assert_eq!(points(&sitting.results(), 0)[1]["runs"], serde_json::json!(["run-1"]));
    // Without any log of the tracker nothing is measured, and the reason is that of its file.
    for run in 1..=3 {
        sitting.write(&format!("tracker-{run}.log"), &format!("the tracker was off in run {run}\n"));
    }
    let said = sitting.validate();
    assert_eq!(said.code, 4, "{}", said.err);
    assert!(said.err.contains("tracker-1.log") && said.err.contains("azimuth"), "{}", said.err);
}

/// 09:13:00 on 2026-11-22 in UTC.
const MORNING_S: f64 = 1_795_338_780.0;

/// One run whose logger stamps dates from 09:13:00 on, and whose tracker counts from 1970 and began `early_s` before.
fn dated(early_s: u32) -> Sitting {
    let sitting = with_runs(&[1]);
    let line = |i: u32| {
        let ms = 10 * i;
        format!("2026-11-22T09:13:{:02}.{:03}Z,{}\n", ms / 1000, ms % 1000, 20.0 * f64::from(i / 200))
    };
    sitting.write("rig-1.csv", &format!("t,p\n{}", (0..600).map(line).collect::<String>()));
    sitting.change("session.toml", "column = \"t\"\nunit = \"ms\"", "column = \"t\"");
    sitting.change("session.toml", "clock = { column = \"time1\", unit = \"s\" }", "");
    // What it saw before the rig began belongs to no plateau.
    let log = tracked(1, MORNING_S, 240);
    let (header, rest) = log.split_once('\n').unwrap();
    let early = |i: u32| format!("99,0.1,0.2,1,2,3,{:.3},50", MORNING_S - f64::from(early_s) + f64::from(i) / 40.0);
    sitting.write("tracker-1.log", &format!("{header}\n{}{rest}", text((0..40 * early_s).map(early))));
    sitting
}

#[test]
fn files_that_begin_at_different_seconds_are_set_on_one_base_and_told() {
    let sitting = dated(3600);
    let said = sitting.validate();
    assert_eq!(said.code, 3, "{}", said.err);
    let results = sitting.results();
    near(&measured_mm(&results), &[0.1, 10.1, 30.1]);
    let shift = findings(&results, "clock-shift")[0];
    assert_eq!((&shift["severity"], &shift["file"]), (&"note".into(), &"tracker-1.log".into()));
    assert_eq!(
        shift["text"],
        "run run-1: -3600 s are added to the stamps of tracker, which count from 2026-11-22T08:13:00Z, so that they count from \
         2026-11-22T09:13:00Z as those of `file` do"
    );
    // The store holds one base too, and says which.
    let (_, told) = ingest(&sitting);
    let table = |told: &Value, file: usize| told["record"]["files"][file]["runs"][0]["tables"][0].clone();
    assert_eq!(table(&told, 1)["counts_from"], "2026-11-22T09:13:00Z");
    assert_eq!(
        (&table(&told, 1)["shift_s"], &table(&told, 1)["from_s"]),
        (&Value::from(-3600.0), &Value::from(-3600.0))
    );
    assert_eq!(told["record"]["files"][1]["origin"], "2026-11-22T08:13:00Z");
    let (_, told) = ingest(&sitting);
    assert_eq!(told["read"], serde_json::json!([]));
    // The logger's first line is gone, and with it the second from which the run counts: the tracker's table follows.
    let rig = fs::read_to_string(sitting.path().join("rig-1.csv")).unwrap();
    sitting.write("rig-1.csv", &without(&rig, 1, 150));
    let (_, told) = ingest(&sitting);
    assert_eq!(told["read"], serde_json::json!(["rig-1.csv", "tracker-1.log"]));
    assert_eq!(
        (&table(&told, 1)["counts_from"], &table(&told, 1)["shift_s"]),
        (&"2026-11-22T09:13:01Z".into(), &Value::from(-3601.0))
    );
    // As a store made anew.
    let stored = fs::read(sitting.path().join(".pneuval/session.json")).unwrap();
    fs::remove_dir_all(sitting.path().join(".pneuval")).unwrap();
    ingest(&sitting);
    assert_eq!(fs::read(sitting.path().join(".pneuval/session.json")).unwrap(), stored);
}

#[test]
fn seconds_since_1970_and_dates_are_one_clock() {
    let sitting = dated(2);
    let line = |i: u32| format!("{:.2},{}\n", MORNING_S + 0.01 * f64::from(i), 20.0 * f64::from(i / 200));
    sitting.write("rig-1.csv", &format!("t,p\n{}", (0..600).map(line).collect::<String>()));
    sitting.change("session.toml", "column = \"t\"", "column = \"t\"\nunit = \"s\"");
    let said = sitting.validate();
    assert_eq!(said.code, 3, "{}", said.err);
    let results = sitting.results();
    near(&measured_mm(&results), &[0.1, 10.1, 30.1]);
    assert!(
        findings(&results, "clock-shift")[0]["text"]
            .as_str()
            .unwrap()
            .contains("count from 1970-01-01T00:00:00Z as those of `file`")
    );
}

#[test]
fn clocks_that_have_nothing_in_common_are_an_error() {
    // The logger counts from its own start, the tracker from 1970.
    let sitting = dated(2);
    sitting.write("rig-1.csv", &rig(1));
    sitting.change("session.toml", "column = \"t\"", "column = \"t\"\nunit = \"ms\"");
    for command in ["validate", "ingest"] {
        let said = pneuval(sitting.path(), &[command, "."]);
        assert_eq!(said.code, 2, "{}", said.err);
        for word in [
            "session.toml:32: run `run-1`",
            "stamps of `file` from a zero of their own, stamps of tracker from 2026-11-22T09:12:58Z",
            "clocks = \"one\"",
        ] {
            assert!(said.err.contains(word), "{word}: {}", said.err);
        }
    }
    // Without the declaration everything is stored as it stands.
    sitting.change("session.toml", "clocks = \"one\"\n", "");
    let (said, told) = ingest(&sitting);
    assert_eq!(said.code, 0, "{}", said.err);
    let tables: Vec<&Value> =
        told["record"]["files"].as_array().unwrap().iter().map(|f| &f["runs"][0]["tables"][0]).collect();
    assert_eq!((&tables[0]["counts_from"], &tables[1]["counts_from"]), (&Value::Null, &"2026-11-22T09:12:58Z".into()));
    // A clock whose zone nobody states is no better.
    let sitting = dated(2);
    let rig = fs::read_to_string(sitting.path().join("rig-1.csv")).unwrap().replace('Z', "");
    sitting.write("rig-1.csv", &rig);
    let said = sitting.validate();
    assert_eq!(said.code, 2, "{}", said.err);
    assert!(said.err.contains("2026-11-22T09:13:00 in a zone that is not stated"), "{}", said.err);
}

#[test]
fn a_counter_beside_dates_counts_from_its_own_zero() {
    let sitting = with_runs(&[1]);
    let line = |i: u32| format!("2026-11-22 09:13:{:02},{},{}\n", i / 100, 10 * i, 20.0 * f64::from(i / 200));
    sitting.write("rig-1.csv", &format!("date,t,p\n{}", (0..600).map(line).collect::<String>()));
    let said = sitting.validate();
    assert_eq!(said.code, 3, "{}", said.err);
    let results = sitting.results();
    near(&measured_mm(&results), &[0.1, 10.1, 30.1]);
    assert_eq!(findings(&results, "clock-shift").len(), 0);
    // By its dates it has nothing in common with the tracker's counter.
    sitting.change("session.toml", "column = \"t\"\nunit = \"ms\"", "column = \"date\"");
    let said = sitting.validate();
    assert!(said.code == 2 && said.err.contains("stamps of tracker from a zero of their own"), "{}", said.err);
}

/// Pressure in one table and a position in another, which follows 50 ms later and is stamped 3 ms later.
fn two_tables(rig: &str, pose: &str, time: &str) -> [Table; 2] {
    let rows = 600_usize;
    let table = |name: &str, delay: f64, column: &str, value: &dyn Fn(usize) -> f64| {
        let numbers = |f: &dyn Fn(usize) -> f64| Cells::Numbers((0..rows).map(f).collect());
        let stamps = Column::new(time, Some("s"), numbers(&|i| i as f64 / 100.0 + delay));
        Table {
            name: name.to_owned(),
            schema: None,
            columns: vec![stamps, Column::new(column, None, numbers(value))],
            rows,
            lines: LineMap::default(),
            clock: Some(0),
            decimal: Decimal::Point,
        }
    };
    [
        table(rig, 0.0, "pressure", &|i| 20e3 * (i / 200) as f64),
        table(pose, 0.003, "x", &|i| [0.0, 0.0101, 0.0299][(i.max(5) - 5) / 200]),
    ]
}

#[test]
fn tables_of_one_file_are_set_against_each_other_where_one_clock_is_declared() {
    let (mut bag, mut tdms) = (Cursor::new(Vec::new()), Vec::new());
    mcap::write(&mut bag, &two_tables("/rig", "/pose", "log_time"), &mcap::WriteOptions::default()).unwrap();
    tdms::write(&mut tdms, &two_tables("rig", "pose", "time"), &tdms::WriteOptions::default()).unwrap();
    let without_device = SESSION
        .replace("[reader]\nformat = \"csv\"\n\n[clock]\ncolumn = \"t\"\nunit = \"ms\"\n", "")
        .replace("[[device]]\nid = \"tracker\"\nreader = { format = \"trakstar\" }\nclock = { column = \"time1\", unit = \"s\" }\n", "");
    let runs = without_device.find("[[run]]").unwrap()..without_device.find("[[response]]").unwrap();
    for (file, bytes, slash) in [("run.mcap", bag.into_inner(), "/"), ("run.tdms", tdms, "")] {
        let session = without_device
            .replace(&without_device[runs.clone()], &format!("[[run]]\nfile = \"{file}\"\n\n"))
            .replace(
                "device = \"tracker\"\ncolumn = \"x1\"\nunit = \"mm\"",
                &format!("column = \"{slash}pose.x\"\nunit = \"m\""),
            )
            .replace("column = \"p\"\nunit = \"kPa\"", &format!("column = \"{slash}rig.pressure\"\nunit = \"Pa\""));
        let folder = with_log(&session, file, &bytes);
        let said = pneuval(folder.path(), &["validate", ".", "--out", "report"]);
        assert_eq!(said.code, 3, "{file}: {}", said.err);
        assert_eq!(measured(folder.path()), ["0.0000", "0.0101", "0.0299"], "{file}");
        // Undeclared, their lag is told and nothing is shifted; the plateaus are long enough to be read whosever it is.
        fs::write(folder.path().join("session.toml"), session.replace("clocks = \"one\"\n", "")).unwrap();
        let said = pneuval(folder.path(), &["validate", ".", "--out", "report"]);
        assert_eq!(said.code, 3, "{}", said.err);
        assert_eq!(measured(folder.path()), ["0.0000", "0.0101", "0.0299"], "{file}");
        let results: Value =
            serde_json::from_slice(&fs::read(folder.path().join("report/results/results.json")).unwrap()).unwrap();
        let told = findings(&results, "total-lag");
        assert_eq!((told.len(), &told[0]["severity"]), (1, &"note".into()), "{told:?}");
        let lag = &results["actuators"][0]["datasets"][0]["session"]["lags"][0];
        assert_eq!(lag["meaning"], "total");
        assert!((lag["value_s"].as_f64().unwrap() - 0.053).abs() < 0.003, "{lag}");
    }
}

#[test]
fn mistakes_with_devices_are_told_by_line_and_next_step() {
    let files = "files = { tracker = \"tracker-1.log\" }";
    let device = "[[device]]\nid = \"tracker\"";
    let points = &SESSION[SESSION.find("points =").unwrap()..];
    for (from, to, place, words) in [
        (
            "device = \"tracker\"",
            "device = \"traker\"",
            "session.toml:26",
            ["the id of a [[device]]", "did you mean `tracker`?"],
        ),
        (
            "device = \"tracker\"\n",
            "",
            "session.toml:14",
            ["a channel of device `tracker`", "add device = \"tracker\" to its channels"],
        ),
        (
            "id = \"pressure\"\n",
            "id = \"pressure\"\ndevice = \"tracker\"\n",
            "session.toml:2",
            ["a channel of the runs' `file`", "make one of the devices the `file`"],
        ),
        (
            device,
            "[[device]]\nid = \"tracker\"\n[[device]]\nid = \"tracker\"",
            "session.toml:16",
            ["every device once", "`tracker` twice"],
        ),
        (device, "[[device]]\nid = \"Tracker\"", "session.toml:14", ["lower-case letters", "rename it"]),
        (files, "", "session.toml:32", ["a file of device `tracker` in every run", "add files = { tracker = \"…\" }"]),
        (
            files,
            "files = { traker = \"tracker-1.log\" }",
            "session.toml:33",
            ["the id of a [[device]]", "did you mean `tracker`?"],
        ),
        (
            files,
            "files = { tracker = \"../tracker-1.log\" }",
            "session.toml:33",
            ["a file inside this folder", "move the file here"],
        ),
        (files, "files = { tracker = \"rig-1.csv\" }", "session.toml:33", ["a file of its own", "line 32 names too"]),
        (
            "tracker = \"tracker-2.log\"",
            "tracker = \"tracker-1.log\"",
            "session.toml:38",
            ["a file of its own", "line 33 names too"],
        ),
        (
            "tracker = \"tracker-2.log\"",
            "tracker = \"copy.log\"",
            "session.toml:37",
            ["a log of its own", "`copy.log`, byte for byte `tracker-1.log`"],
        ),
        ("tracker = \"tracker-2.log\"", "tracker = \"gone.log\"", "gone.log", ["cannot be read", "No such file"]),
        ("clocks = \"one\"", "clocks = \"two\"", "session.toml:4", ["one of: one", "two"]),
        ("column = \"x1\"", "column = \"x2\"", "session.toml:25", ["a column of the log", "did you mean `x1`?"]),
        (
            "column = \"time1\"",
            "column = \"time2\"",
            "session.toml:16",
            ["a column of the log", "did you mean `time1`?"],
        ),
        (", unit = \"s\" }\n\n", " }\n\n", "session.toml:16", ["the unit of column `time1`", "add `unit`"]),
        (points, "", "session.toml:46", ["samples of two have no partners", "say from = \"plateaus\""]),
        (
            "measured = { channel = \"stroke\" }\n",
            "measured = { channel = \"stroke\" }\ncondition = [{ channel = \"stroke\" }]\n",
            "session.toml:46",
            ["pressures and conditions of one table", "`pressure` from `file`, `stroke` from tracker"],
        ),
        (
            "[[run]]",
            "[[derived]]\nid = \"d\"\nrule = \"difference\"\nfrom = [\"stroke\", \"pressure\"]\nunit = \"mm\"\n\n[[run]]",
            "session.toml:33",
            ["channels of one device", "`stroke` of tracker, `pressure` of `file`"],
        ),
    ] {
        let sitting = sitting();
        fs::copy(sitting.path().join("tracker-1.log"), sitting.path().join("copy.log")).unwrap();
        sitting.change("session.toml", from, to);
        let said = sitting.validate();
        assert_eq!(said.code, 2, "{to}: {}{}", said.out, said.err);
        assert!(said.err.contains(place) && words.iter().all(|word| said.err.contains(word)), "{to}: {}", said.err);
    }
}

#[test]
fn a_force_gauge_counts_by_the_stamps_that_it_writes() {
    let sitting = with_runs(&[1]);
    let line = |i: u32| format!("2026-11-22T09:13:{:02}.{:02},{}\n", i / 100, i % 100, 20.0 * f64::from(i / 200));
    sitting.write("rig-1.csv", &format!("t,p\n{}", (0..600).map(line).collect::<String>()));
    sitting.change("session.toml", "column = \"t\"\nunit = \"ms\"", "column = \"t\"");
    sitting.change(
        "session.toml",
        "{ format = \"trakstar\" }\nclock = { column = \"time1\", unit = \"s\" }",
        "{ format = \"gauge\" }",
    );
    sitting.change("session.toml", "column = \"x1\"\nunit = \"mm\"", "column = \"force\"");
    sitting.change("session.toml", "title = \"Stroke\", unit = \"mm\"", "title = \"Force\", unit = \"N\"");
    sitting.write("actuator.toml", PLAIN);
    // Ten a second from 09:12:58 on: before the rig began it was pushed by hand.
    let force = |i: u32| if i < 20 { 99.0 } else { 0.5 * f64::from((i - 20) / 20) };
    let line = |i: u32| {
        format!("2026-11-22 09:{:02}:{:02}.{} {:.2} N\n", 12 + (580 + i) / 600, (580 + i) / 10 % 60, i % 10, force(i))
    };
    sitting.write("tracker-1.log", &(0..80).map(line).collect::<String>());
    let said = sitting.validate();
    assert_eq!(said.code, 3, "{}", said.err);
    let newtons: Vec<f64> = measured_mm(&sitting.results()).iter().map(|value| value / 1e3).collect();
    near(&newtons, &[0.0, 0.5, 1.0]);
}

/// What the reference of files says of several devices, followed to the letter.
#[test]
fn the_example_of_several_devices_works_as_written() {
    let text = fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/docs/files.md")).unwrap();
    let section = text.split("### Several devices").nth(1).unwrap();
    let example = section.split("```text\n").nth(1).unwrap().split("```").next().unwrap();
    let sitting = sitting();
    sitting.write("session.toml", &format!("schema = 1\nid = \"monday\"\nactuator = \"my-bellows\"\n{example}"));
    let said = sitting.validate();
    assert_eq!(said.code, 3, "{}", said.err);
    near(&measured_mm(&sitting.results()), &[0.1, 10.1, 30.1]);
}
