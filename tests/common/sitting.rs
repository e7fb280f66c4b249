//! A sitting at a rig: a session on an actuator of a type that nobody embedded.

use std::fs;
use std::path::Path;

use serde_json::Value;
use tempfile::TempDir;

use super::{Said, pneuval};

/// A folder with a session on an actuator of a type that nobody embedded.
pub struct Sitting {
    pub folder: TempDir,
}

pub const ACTUATOR: &str = r#"schema = 1
id = "my-bellows"
title = "My bellows"
summary = "A bellows nobody has published."

[chamber.air]
pressure_gauge_max = { value = 40, unit = "kPa", source = "measured" }

[[model]]
kind = "imported"
form = "abaqus"
title = "Abaqus, C3D8H"
quantity = { id = "stroke", title = "Stroke", unit = "mm" }
source = "Abaqus 2024, job bellows-7"
file = "fea.csv"
pressure = { column = "p", chamber = "air", reference = "gauge" }
predicted = "u3"
std = "u3_std"
"#;

pub const FEA: &str = "p,u3,u3_std\nkPa,mm,mm\n0,0,0\n20,10.0,0.01\n40,30.0,0.01\n";

pub const LOG: &str = "pressure (kPa);stroke [mm]\n0;0,0\n10;5,2\n20;10,1\n30;19,8\n40;30,5\n";

pub const SESSION: &str = r#"schema = 1
id = "monday"
actuator = "my-bellows"

[[channel]]
id = "pressure"
column = "pressure (kPa)"
reference = "gauge"

[[channel]]
id = "stroke"
column = "stroke [mm]"

[[run]]
file = "log.csv"

[[response]]
quantity = { id = "stroke", title = "Stroke", unit = "mm" }
pressure = [{ channel = "pressure", chamber = "air" }]
measured = { channel = "stroke", method = "laser" }
"#;

/// A folder with a session on that actuator and the log that it names.
pub fn with_log(session: &str, name: &str, log: &[u8]) -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    for (name, text) in [("actuator.toml", ACTUATOR), ("fea.csv", FEA), ("session.toml", session)] {
        fs::write(folder.path().join(name), text).unwrap();
    }
    fs::write(folder.path().join(name), log).unwrap();
    folder
}

/// What was measured at the points of the first comparison in `report`, in SI.
pub fn measured(folder: &Path) -> Vec<String> {
    let results = fs::read_to_string(folder.join("report/results/results.json")).unwrap();
    let results: Value = serde_json::from_str(&results).unwrap();
    let points = results["comparisons"][0]["points"].as_array().unwrap();
    points.iter().map(|point| format!("{:.4}", point["measured"][0].as_f64().unwrap())).collect()
}

impl Sitting {
    pub fn new() -> Self {
        let sitting = Self { folder: tempfile::tempdir().unwrap() };
        for (name, text) in [("actuator.toml", ACTUATOR), ("fea.csv", FEA), ("log.csv", LOG), ("session.toml", SESSION)]
        {
            sitting.write(name, text);
        }
        sitting
    }

    pub fn path(&self) -> &Path {
        self.folder.path()
    }

    pub fn write(&self, name: &str, text: &str) {
        fs::write(self.path().join(name), text).unwrap();
    }

    pub fn change(&self, name: &str, from: &str, to: &str) {
        let text = fs::read_to_string(self.path().join(name)).unwrap();
        assert!(text.contains(from), "{name} has no {from:?}");
        self.write(name, &text.replacen(from, to, 1));
    }

    pub fn bound(&self, max: f64, more: &str) {
        self.write(
            "bounds.toml",
            &format!(
                "schema = 1\n[[bound]]\nactuator = \"my-bellows\"\nquantity = \"stroke\"\nmodel = \"abaqus\"\n\
                 metric = \"max_abs_error\"\nmax = {{ value = {max:?}, unit = \"mm\" }}\nreason = \"a test\"\n{more}"
            ),
        );
    }

    pub fn validate(&self) -> Said {
        pneuval(self.path(), &["validate", ".", "--out", "report"])
    }

    pub fn results(&self) -> Value {
        serde_json::from_slice(&fs::read(self.path().join("report/results/results.json")).unwrap()).unwrap()
    }
}

pub fn points(results: &Value, comparison: usize) -> &Vec<Value> {
    results["comparisons"][comparison]["points"].as_array().unwrap()
}

pub fn findings<'a>(results: &'a Value, kind: &str) -> Vec<&'a Value> {
    results["findings"].as_array().unwrap().iter().filter(|f| f["kind"] == kind).collect()
}
