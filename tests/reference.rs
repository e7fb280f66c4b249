//! Real rig logs with known truth, outside this repository: found through `PNEUVAL_REFERENCE_DATA`; where it is unset these
//! tests say in one line that they did not run.

// In a test a panic is how a failure is told.
#![allow(clippy::unwrap_used, clippy::panic)]

mod common;

use std::collections::BTreeMap;
use std::fs;
use std::io::Write as _;
use std::path::{Path, PathBuf};

use common::pneuval;
use pneuval_datasets::{FoundData, find};
use pneuval_ingest::finding::FindingKind;
use pneuval_ingest::session::Session;
use serde_json::Value;

fn data(folder: &str) -> Option<PathBuf> {
    let found = std::env::var_os("PNEUVAL_REFERENCE_DATA").map(|root| {
        let root = PathBuf::from(root);
        // Tests run in their crate's folder, the variable is set where cargo is called.
        let root = if root.is_absolute() { root } else { Path::new(env!("CARGO_MANIFEST_DIR")).join(root) };
        root.join(folder)
    });
    if found.is_none() {
        // Not `println!`, which the test runner keeps to itself. Nobody is told less if the stream is closed.
        let _ = writeln!(std::io::stderr(), "{folder}: not run, PNEUVAL_REFERENCE_DATA is not set");
    }
    found
}

fn session(folder: &Path) -> Box<Session> {
    match find(&[folder.to_owned()]).unwrap().remove(0).data {
        FoundData::Session(session) => session,
        FoundData::Published(_) => panic!("no session"),
    }
}

const ZILLEN_RIG: &str = r#"schema = 1
id = "zillen"

[instrument.laser]
input = "V"
output = "mm"
calibration = { kind = "line", slope = 13.33756, offset = -47.48980 }

[instrument.pressure]
input = "V"
output = "bar"
calibration = { kind = "line", slope = 2.00393, offset = -0.00596 }

[instrument.force]
input = "V"
output = "N"
calibration = { kind = "line", slope = 46.5180, offset = 0.00648 }
"#;

/// Channel, slope, half a unit of the slope's last printed digit, unit, SI value of the unit.
const ZILLEN: [(&str, f64, f64, &str, f64); 3] = [
    ("laser", 13.337_56, 5e-6, "mm", 1e-3),
    ("pressure", 2.003_93, 5e-6, "bar", 1e5),
    ("force", 46.518, 5e-5, "N", 1.0),
];

/// Seven columns without a header: ms, three voltages, and what the logger made of them. The logger's zeros were set anew
/// before every run.
fn zillen_session(file: &str, zeros: [f64; 3]) -> String {
    let zero = |i: usize| format!("{} = {{ value = {:.5}, unit = \"{}\" }}", ZILLEN[i].0, zeros[i], ZILLEN[i].3);
    let zeros = [zero(0), zero(1), zero(2)].join(", ");
    format!(
        r#"schema = 1
id = "zillen"
actuator = "friction-cylinder"
rig = "zillen"
clock = {{ column = 1, unit = "ms" }}

[[channel]]
id = "laser"
column = 2
instrument = "laser"

[[channel]]
id = "pressure"
column = 3
instrument = "pressure"
reference = "gauge"

[[channel]]
id = "force"
column = 4
instrument = "force"

[[channel]]
id = "laser-logged"
column = 5
unit = "mm"

[[channel]]
id = "pressure-logged"
column = 6
unit = "bar"
reference = "gauge"

[[channel]]
id = "force-logged"
column = 7
unit = "N"

[[run]]
file = "{file}"
zero = {{ {zeros} }}

[[response]]
quantity = {{ id = "position", title = "Position", unit = "mm" }}
pressure = [{{ channel = "pressure", chamber = "cylinder" }}]
measured = {{ channel = "laser", method = "laser" }}
points = {{ from = "plateaus", tolerance = {{ value = 0.05, unit = "bar" }}, hold = {{ value = 1, unit = "s" }}, window = {{ value = 0.5, unit = "s" }} }}
"#
    )
}

/// Calibrated and logged values of a channel in the unit of the log.
fn both(session: &Session, (channel, _, _, _, unit): (&str, f64, f64, &str, f64)) -> (Vec<f64>, Vec<f64>) {
    let values = |id: &str| session.runs[0].channels[id].values_si.iter().map(|v| v / unit).collect();
    (values(channel), values(&format!("{channel}-logged")))
}

/// The rig's calibration turns logged volts into the logged engineering columns, to what three decimals leave open. The slopes
/// are those of the rig, the same for every file; the zeros are each run's own, and are found from the logged columns: three
/// numbers against thousands of samples.
#[test]
fn zillen_volts_through_the_rigs_calibration_are_the_logged_columns() {
    let Some(root) = data("rig/zillen") else { return };
    let mut files: Vec<PathBuf> = fs::read_dir(&root).unwrap().map(|e| e.unwrap().path()).collect();
    files.retain(|path| path.extension().is_some_and(|e| e == "csv"));
    files.sort();
    assert_eq!(files.len(), 6);
    for path in files {
        let name = path.file_name().unwrap().to_str().unwrap();
        let lab = tempfile::tempdir().unwrap();
        fs::copy(&path, lab.path().join(name)).unwrap();
        fs::write(lab.path().join("rig.toml"), ZILLEN_RIG).unwrap();
        fs::write(lab.path().join("actuator.toml"), "schema = 1\n").unwrap();
        let read = |zeros| {
            fs::write(lab.path().join("session.toml"), zillen_session(name, zeros)).unwrap();
            session(lab.path())
        };
        let raw = read([0.0; 3]);
        let zeros = ZILLEN.map(|channel| {
            let (calibrated, logged) = both(&raw, channel);
            let differences = calibrated.iter().zip(&logged).map(|(a, b)| a - b);
            let (low, high) = differences.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), d| (l.min(d), h.max(d)));
            0.5 * (low + high)
        });
        let session = read(zeros);
        let lines = fs::read_to_string(&path).unwrap().lines().count();
        assert_eq!(session.runs[0].samples(), lines, "{name}");
        for (channel, zero) in ZILLEN.into_iter().zip(zeros) {
            let (calibrated, logged) = both(&session, channel);
            // Half a unit of the third decimal of the volts, through the slope, and of the logged value; and what the slope's own
            // last digit leaves open over 5 V.
            let allowed = 0.0005 * channel.1 + 0.0005 + 5.0 * channel.2;
            let worst = calibrated.iter().zip(&logged).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            assert!(worst <= allowed, "{name} {}: {worst} allowed {allowed}", channel.0);
            println!(
                "{name} {}: {lines} samples, zero {zero:.3} {}, worst difference {worst:.5} of {allowed:.5} allowed",
                channel.0, channel.3
            );
        }
        let of = |kind: FindingKind| session.findings.iter().filter(move |f| f.kind == kind);
        let begins_with = match name {
            "O-ring257_1bar.csv" => Some("276 ms from 0 s to 0.276 s"),
            "O-ring257_3bar.csv" => Some("273 ms from 0 s to 0.273 s"),
            _ => None,
        };
        let first = of(FindingKind::Gap).find(|gap| gap.spans[0].first_sample == 0);
        assert_eq!(first.is_some(), begins_with.is_some(), "{name}");
        if let (Some(gap), Some(words)) = (first, begins_with) {
            assert!(gap.text.contains(words), "{}", gap.text);
            assert_eq!((gap.spans[0].first_line, gap.spans[0].last_line), (1, 2));
        }
        assert_eq!(of(FindingKind::Gap).count() + of(FindingKind::Tared).count(), session.findings.len(), "{name}");
    }
}

const BENDER: &str = r#"schema = 1
id = "soft-bender"
type = "constant-curvature"
title = "Soft bending actuator"
summary = "Bending actuators of one length and 53 configurations; pressure -> tip displacement and angle."

[chamber.chamber]
pressure_gauge_max = { value = 400, unit = "kPa", source = "measured" }

[geometry]
rest_length = { value = 135, unit = "mm", source = "assumed", place = "follows from the logged angle: it is atan2(y, 135 mm + x)" }
elongation = { value = 0.05, unit = "mm/kPa", source = "assumed", place = "start of the fit" }
curvature_per_pressure = { value = 0.02, unit = "1/(m kPa)", source = "assumed", place = "start of the fit" }
"#;

fn bender_session(id: &str, config: &str) -> String {
    format!(
        r#"schema = 1
id = "{id}"
actuator = "soft-bender"

[[channel]]
id = "pressure"
column = "p"
unit = "kPa"
reference = "gauge"

[[channel]]
id = "along"
column = "x"
unit = "mm"

[[channel]]
id = "sideways"
column = "y"
unit = "mm"

[[channel]]
id = "polar_angle"
column = "theta"
unit = "deg"

[[run]]
file = "tip-pose-vs-pressure.csv"
rows = {{ column = "config", equals = "{config}" }}

[[response]]
quantity = {{ id = "polar-angle", title = "Polar angle of the tip", unit = "deg" }}
pressure = [{{ channel = "pressure", chamber = "chamber" }}]
measured = {{ channel = "polar_angle", method = "tip pose" }}

[[response]]
quantity = {{ id = "tip-displacement", title = "Tip displacement", unit = "mm", components = ["along", "sideways"] }}
pressure = [{{ channel = "pressure", chamber = "chamber" }}]
condition = [{{ channel = "polar_angle" }}, {{ channel = "polar_angle", id = "bending_angle" }}]
measured = {{ channel = ["along", "sideways"], method = "tip pose" }}

[[comparison]]
quantity = "polar-angle"
form = "linear-curvature"
fit = {{ to = "measured", parameters = ["elongation", "curvature_per_pressure"], hold_out = "odd-pressures" }}

[[comparison]]
quantity = "tip-displacement"
form = "linear-curvature"
fit = {{ to = "measured", parameters = ["elongation", "curvature_per_pressure"], hold_out = "odd-pressures" }}

[[comparison]]
quantity = "tip-displacement"
form = "from-polar-angle"
fit = {{ to = "measured", parameters = ["elongation"], hold_out = "odd-pressures" }}

[[comparison]]
quantity = "tip-displacement"
form = "from-angle"
fit = {{ to = "measured", parameters = ["rest_length", "elongation"], hold_out = "odd-pressures" }}
"#
    )
}

/// Medians and worst cases that `datasets/README.md` tells, in the order in which they are printed.
const SAID: [(f64, f64, &str); 8] = [
    (0.173, 0.392, "ef30-ds30-2-1"),
    (0.233, 0.488, "ef30-ds30-2-1"),
    (3.967, 7.142, "ef30-ds30-6-6"),
    (5.607, 10.055, "ef30-ds30-6-6"),
    (0.483, 7.140, "ef30-ds30-6-6"),
    (0.688, 11.572, "ef30-ds30-6-6"),
    (2.284, 7.699, "ef30-ds30-3-1"),
    (3.351, 11.282, "ef30-ds30-3-1"),
];

/// Configurations with fewer than nine points, and how many they have.
const SHORT: [(&str, usize); 9] = [
    ("DS10-DS10-2-1", 7),
    ("DS10-DS30-3-2", 7),
    ("DS30-DS10-6-6", 4),
    ("DS30-DS30-2-1", 7),
    ("DS30-DS30-3-2", 8),
    ("DS30-DS30-6-0", 7),
    ("DS30-EF30-3-1", 8),
    ("EF30-DS30-6-1", 8),
    ("EF30-DS30-6-2", 8),
];

/// Rows of the log by configuration, in their order.
fn configurations(text: &str) -> Vec<(String, usize)> {
    let mut found: Vec<(String, usize)> = Vec::new();
    for line in text.lines().skip(1) {
        let name = line.split(',').next().unwrap();
        match found.iter_mut().find(|(known, _)| known == name) {
            Some((_, count)) => *count += 1,
            None => found.push((name.to_owned(), 1)),
        }
    }
    found
}

fn median(values: &mut [f64]) -> f64 {
    values.sort_by(f64::total_cmp);
    let n = values.len();
    0.5 * (values[(n - 1) / 2] + values[n / 2])
}

/// Is the bending constant-curvature? Fitted on even-numbered pressures, judged on odd-numbered ones, configuration by
/// configuration, through the binary.
#[test]
fn gunawardane_against_constant_curvature_with_elongation() {
    let Some(root) = data("rig/gunawardane") else { return };
    let log = fs::read_to_string(root.join("tip-pose-vs-pressure.csv")).unwrap();
    let configurations = configurations(&log);
    assert_eq!(configurations.len(), 53);
    let lab = tempfile::tempdir().unwrap();
    fs::write(lab.path().join("actuator.toml"), BENDER).unwrap();
    let mut short: Vec<(&str, usize)> = Vec::new();
    for (i, (config, points)) in configurations.iter().enumerate() {
        if *points < 9 {
            short.push((config, *points));
            continue;
        }
        let folder = lab.path().join(format!("{i:02}"));
        fs::create_dir(&folder).unwrap();
        fs::write(folder.join("tip-pose-vs-pressure.csv"), &log).unwrap();
        let id = config.to_lowercase();
        fs::write(folder.join("session.toml"), bender_session(&id, config)).unwrap();
    }
    let said = pneuval(lab.path(), &["validate", ".", "--out", "report", "--no-figures", "--json"]);
    // Nothing has a bound here: the numbers are asked for, not a verdict.
    assert_eq!(said.code, 3, "{}", said.err);
    let results: Value = serde_json::from_str(&said.out).unwrap();
    assert_eq!(short, SHORT);
    let mut found = Vec::new();
    for (quantity, form, unit, scale) in [
        ("polar-angle", "linear-curvature", "deg", 180.0 / std::f64::consts::PI),
        ("tip-displacement", "linear-curvature", "mm", 1e3),
        ("tip-displacement", "from-polar-angle", "mm", 1e3),
        ("tip-displacement", "from-angle", "mm", 1e3),
    ] {
        for metric in ["rmse", "max_abs_error"] {
            let mut values = Vec::new();
            let mut worst = (0.0, String::new());
            for c in results["comparisons"].as_array().unwrap() {
                if c["quantity"]["id"] != quantity || c["form"] != form {
                    continue;
                }
                assert_eq!((&c["n_used"], &c["n_available"]), (&Value::from(4), &Value::from(9)), "{}", c["id"]);
                let record = c["metrics"].as_array().unwrap().iter().find(|m| m["metric"] == metric).unwrap();
                let value = scale * record["value"].as_f64().unwrap();
                values.push(value);
                if value > worst.0 {
                    worst = (value, c["dataset"].as_str().unwrap().to_owned());
                }
            }
            assert_eq!(values.len(), 44);
            let median = median(&mut values);
            println!(
                "{quantity} {form} {metric}: median {median:.3} {unit}, worst {:.3} {unit} ({})",
                worst.0, worst.1
            );
            found.push((median, worst.0, worst.1));
        }
    }
    // What datasets/README.md says.
    for ((median, worst, config), said) in found.iter().zip(SAID) {
        assert!((median - said.0).abs() < 5e-3 && (worst - said.1).abs() < 5e-3, "{found:?}");
        assert_eq!(config, said.2, "{found:?}");
    }
}

/// The logged angle is the direction in which the tip is seen from the base, 135 mm behind its rest, but for two configurations.
#[test]
fn gunawardane_logged_angle_is_computed_from_the_logged_tip() {
    let Some(root) = data("rig/gunawardane") else { return };
    let log = fs::read_to_string(root.join("tip-pose-vs-pressure.csv")).unwrap();
    let mut worst: BTreeMap<&str, f64> = BTreeMap::new();
    for line in log.lines().skip(1) {
        let cells: Vec<&str> = line.split(',').collect();
        let [x, y, theta] = [2, 3, 4].map(|column: usize| cells[column].trim().parse::<f64>().unwrap());
        let difference = (y.atan2(135.0 + x).to_degrees() - theta).abs();
        let known = worst.entry(cells[0]).or_default();
        *known = known.max(difference);
    }
    let others: Vec<&str> = worst.iter().filter(|(_, worst)| **worst > 1e-6).map(|(config, _)| *config).collect();
    assert_eq!((worst.len(), others), (53, vec!["EF30-DS30-6-3", "EF30-DS30-6-6"]), "{worst:?}");
}
