//! A folder of one's own with a dataset in it, and the built binary to ask.

// Every test binary compiles this file and uses a part of it.
#![allow(dead_code)]

pub mod sitting;

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use tempfile::TempDir;

/// What the binary said.
pub struct Said {
    pub code: i32,
    pub out: String,
    pub err: String,
}

/// Runs `pneuval` in a folder.
pub fn pneuval(folder: &Path, arguments: &[&str]) -> Said {
    let Output { status, stdout, stderr } =
        Command::new(env!("CARGO_BIN_EXE_pneuval")).current_dir(folder).args(arguments).output().unwrap();
    Said {
        code: status.code().unwrap(),
        out: String::from_utf8(stdout).unwrap(),
        err: String::from_utf8(stderr).unwrap(),
    }
}

/// The datasets folder of this repository.
pub fn datasets() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("datasets")
}

/// A dataset on disk: one printed prediction `model` against one measured column, three pressures.
pub struct Lab {
    pub folder: TempDir,
}

const ACTUATOR: &str = r#"schema = 1
id = "balloon"
type = "balloon"
title = "Balloon"
summary = "A made-up actuator."

[chamber.air]
pressure_gauge_max = { value = 30, unit = "kPa", source = "measured" }

[geometry]
"#;

const DATASET: &str = r#"schema = 1
id = "balloon"
actuator = "balloon"
basis = "published-point"

[paper]
title = "A made-up paper"

[[table]]
file = "size.csv"
quantity = { id = "size", title = "Size", unit = "mm" }
place = "Table 1"
pressure = [{ column = "p", chamber = "air", reference = "gauge" }]
measured = { column = "measured", method = "ruler" }
predicted = [{ column = "model", form = "model", title = "model" }]

[[comparison]]
quantity = "size"
form = "model"
"#;

/// Six decimals, so that the rounding interval is far smaller than the steps the tests take.
const TABLE: &str = "p,model,measured\n\
                     kPa,mm,mm\n\
                     0,10.500000,10.000000\n\
                     10,21.000000,20.000000\n\
                     20,28.000000,30.000000\n\
                     30,43.000000,40.000000\n";

impl Lab {
    /// The made-up dataset, with no bounds.
    pub fn new() -> Self {
        let lab = Self { folder: tempfile::tempdir().unwrap() };
        lab.write("actuator.toml", ACTUATOR);
        lab.write("dataset.toml", DATASET);
        lab.write("size.csv", TABLE);
        lab
    }

    pub fn path(&self) -> &Path {
        self.folder.path()
    }

    pub fn write(&self, name: &str, text: &str) {
        fs::write(self.path().join(name), text).unwrap();
    }

    /// Replaces a piece of a file, which must be there.
    pub fn change(&self, name: &str, from: &str, to: &str) {
        let text = fs::read_to_string(self.path().join(name)).unwrap();
        assert!(text.contains(from), "{name} has no {from:?}");
        self.write(name, &text.replacen(from, to, 1));
    }

    /// One bound on the one comparison.
    pub fn bound(&self, metric: &str, value: f64, unit: &str, expect: &str) {
        self.write(
            "bounds.toml",
            &format!(
                "schema = 1\n[[bound]]\nactuator = \"balloon\"\nquantity = \"size\"\nmodel = \"model\"\n\
                 metric = \"{metric}\"\nmax = {{ value = {value:?}, unit = \"{unit}\" }}\nexpect = \"{expect}\"\n\
                 reason = \"a test\"\n"
            ),
        );
    }

    /// `pneuval validate` here.
    pub fn validate(&self) -> Said {
        pneuval(self.path(), &["validate", ".", "--out", "report"])
    }
}
