//! Sittings of several devices through the binary: each writes a file of its own, and one clock stamps them all or does not.

// In a test a panic is how a failure is told.
#![allow(clippy::unwrap_used, clippy::panic)]

mod common;

use std::fmt::Write as _;

use common::sitting::{Sitting, points};
use common::{Said, pneuval};
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
