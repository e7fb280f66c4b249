//! What a user may get wrong: file, line, key or cell, expected, found; exit 2; nothing written.

// In a test a panic is how a failure is told.
#![allow(clippy::unwrap_used, clippy::panic)]

mod common;

use common::{Lab, pneuval};

/// Each row: file, what is replaced, by what, and what the message must say.
const MISTAKES: &[(&str, &str, &str, &[&str])] = &[
    ("dataset.toml", "unit = \"mm\"", "unit = \"mmm\"", &["dataset.toml:11: key `quantity`", "did you mean `mm`?"]),
    (
        "dataset.toml",
        "unit = \"mm\"",
        "unit = \"kPa\"",
        &["size.csv:2: column `measured`", "expected: a pressure", "unit `mm`"],
    ),
    (
        "dataset.toml",
        "place = \"Table 1\"",
        "plase = \"Table 1\"",
        &["dataset.toml:12: key `plase`", "did you mean `place`?"],
    ),
    ("dataset.toml", "schema = 1", "schema = 9", &["dataset.toml:1: key `schema`", "found:    9"]),
    ("dataset.toml", "id = \"balloon\"", "id = \"../balloon\"", &["dataset.toml:2: key `id`", "`../balloon`"]),
    ("dataset.toml", "actuator = \"balloon\"", "actuator = \"baloon\"", &["key `actuator`", "`baloon`"]),
    (
        "dataset.toml",
        "file = \"size.csv\"",
        "file = \"../size.csv\"",
        &["dataset.toml:10: key `file`", "a file inside this folder"],
    ),
    ("dataset.toml", "file = \"size.csv\"", "file = \"none.csv\"", &["none.csv: cannot be read"]),
    ("dataset.toml", "reference = \"gauge\"", "reference = \"absolute\"", &["dataset.toml:13", "`absolute`", "gauge"]),
    ("dataset.toml", "basis = \"published-point\"", "", &["expected: key `basis`", "nothing"]),
    (
        "dataset.toml",
        "quantity = \"size\"",
        "quantity = \"sise\"",
        &["dataset.toml:18: key `quantity`", "did you mean `size`?"],
    ),
    (
        "dataset.toml",
        "form = \"model\"\n",
        "form = \"modle\"\n",
        &["dataset.toml:19: key `form`", "did you mean `model`?"],
    ),
    (
        "dataset.toml",
        "form = \"model\"\n",
        "form = \"model\"\nremark = \"{{ predicted[9] }}\"\n",
        &["dataset.toml:19: key `remark`"],
    ),
    (
        "dataset.toml",
        "form = \"model\"\n",
        "form = \"model\"\njudge = false\n",
        &["dataset.toml:20: key `judge`", "`reason`"],
    ),
    ("dataset.toml", "[paper]", "[paper", &["dataset.toml:6: key `[paper`", "unclosed table"]),
    ("size.csv", "kPa,mm,mm", "mm,mm,mm", &["size.csv:2: column `p`", "a pressure", "unit `mm`"]),
    ("size.csv", "p,model,measured", "p,model,mesured", &["size.csv:1: column `measured`", "did you mean `mesured`?"]),
    ("size.csv", "p,model,measured", "p,model,measured,x", &["size.csv:2", "4 cells", "3 cells"]),
    ("size.csv", "21.000000", "twenty-one", &["size.csv:4: column `model`", "expected: a number", "`twenty-one`"]),
    ("size.csv", "21.000000", "inf", &["size.csv:4: column `model`", "`inf`"]),
    ("size.csv", "10,21.000000", ",21.000000", &["size.csv:4: column `p`", "a pressure", "no number"]),
    (
        "actuator.toml",
        "unit = \"kPa\"",
        "unit = \"N\"",
        &["actuator.toml:8: key `pressure_gauge_max`", "a pressure", "unit `N`"],
    ),
    (
        "actuator.toml",
        "value = 30",
        "value = \"thirty\"",
        &["actuator.toml:8: key `pressure_gauge_max`", "a number", "thirty"],
    ),
    ("actuator.toml", "value = 30", "value = nan", &["actuator.toml:8", "a finite number", "NaN"]),
    ("actuator.toml", "source = \"measured\"", "source = \"published\"", &["actuator.toml:8", "`place`"]),
    ("actuator.toml", "source = \"measured\"", "source = \"guessed\"", &["actuator.toml:8", "`guessed`", "assumed"]),
    ("bounds.toml", "unit = \"mm\"", "unit = \"deg\"", &["bounds.toml:5: key `max`", "a length", "an angle"]),
    ("bounds.toml", "metric = \"rmse\"", "metric = \"rmsd\"", &["bounds.toml:6: key `metric`", "did you mean `rmse`?"]),
    ("bounds.toml", "reason = \"a test\"", "", &["bounds.toml", "key `reason`"]),
];

#[test]
fn every_mistake_is_told_by_place_and_nothing_is_written() {
    for (file, from, to, words) in MISTAKES {
        let lab = Lab::new();
        lab.bound("rmse", 5.0, "mm", "pass");
        lab.change(file, from, to);
        let said = lab.validate();
        assert_eq!(said.code, 2, "{file}: {to}: {}{}", said.out, said.err);
        for word in *words {
            assert!(said.err.contains(word), "{file}: {to:?}: expected {word:?} in\n{}", said.err);
        }
        assert!(said.out.is_empty() && !lab.path().join("report").exists(), "{file}: {to}: something was written");
    }
}

#[test]
fn a_duplicate_bound_names_both_lines() {
    let lab = Lab::new();
    lab.bound("rmse", 5.0, "mm", "pass");
    let text = std::fs::read_to_string(lab.path().join("bounds.toml")).unwrap();
    lab.write("bounds.toml", &format!("{text}{}", text.strip_prefix("schema = 1\n").unwrap()));
    let said = lab.validate();
    assert_eq!(said.code, 2);
    assert!(said.err.contains("bounds.toml:13") && said.err.contains("the first at line 5"), "{}", said.err);
    assert!(!lab.path().join("report").exists());
}

#[test]
fn an_earlier_report_survives_a_mistake_unchanged() {
    let lab = Lab::new();
    lab.bound("rmse", 5.0, "mm", "pass");
    assert_eq!(lab.validate().code, 0);
    let before = std::fs::read(lab.path().join("report/results/results.json")).unwrap();
    lab.change("size.csv", "21.000000", "x");
    assert_eq!(lab.validate().code, 2);
    assert_eq!(std::fs::read(lab.path().join("report/results/results.json")).unwrap(), before);
    let names: Vec<_> = std::fs::read_dir(lab.path()).unwrap().map(|e| e.unwrap().file_name()).collect();
    assert!(names.iter().all(|n| !n.to_string_lossy().starts_with(".pneuval")), "{names:?}");
}

#[test]
fn a_folder_with_a_strangers_file_is_not_written_over() {
    let lab = Lab::new();
    lab.bound("rmse", 5.0, "mm", "pass");
    let said = pneuval(lab.path(), &["validate", ".", "--out", "."]);
    assert_eq!(said.code, 2);
    assert!(said.err.contains("not written over"), "{}", said.err);
    assert_eq!(lab.validate().code, 0);
    lab.write("report/mine.txt", "notes");
    let said = lab.validate();
    assert_eq!(said.code, 2);
    assert!(said.err.contains("mine.txt"), "{}", said.err);
    assert!(lab.path().join("report/mine.txt").is_file());
}

#[test]
fn damaged_results_are_refused() {
    let lab = Lab::new();
    lab.bound("rmse", 5.0, "mm", "pass");
    assert_eq!(lab.validate().code, 0);
    let file = lab.path().join("report/results/results.json");
    let text = std::fs::read_to_string(&file).unwrap();
    for (damaged, word) in [
        (text.replacen("\"schema_version\": 1", "\"schema_version\": 2", 1), "schema_version 1 expected, found 2"),
        (text.replacen("\"n_used\"", "\"n_sued\"", 1), "n_sued"),
        (text[..text.len() / 2].to_owned(), "not JSON"),
    ] {
        std::fs::write(&file, damaged).unwrap();
        for command in [["gate", "report"], ["report", "report"]] {
            let said = pneuval(lab.path(), &command);
            assert_eq!(said.code, 2);
            assert!(said.err.contains(word), "{}", said.err);
        }
    }
    std::fs::write(&file, text).unwrap();
    std::fs::write(lab.path().join("report/results/series.parquet"), b"PAR1").unwrap();
    let said = pneuval(lab.path(), &["report", "report"]);
    assert!(said.code == 2 && said.err.contains("SHA-256"), "{}", said.err);
    assert_eq!(pneuval(lab.path(), &["gate", "nowhere"]).code, 2);
}

#[test]
fn flags_are_checked_and_mistyped_words_get_a_suggestion() {
    let lab = Lab::new();
    for (arguments, word) in [
        (&["predict", "internal-suport"][..], "did you mean `internal-support`?"),
        (&["predict", "internal-support", "--form", "consitent"], "did you mean `consistent`?"),
        (&["predict", "internal-support", "--quantity", "outer"], "outer-diameter"),
        (&["predict", "internal-support", "--at", "10"], "write `10 kPa`, say"),
        (&["predict", "internal-support", "--at", "10 mm"], "`mm` is not a pressure"),
        (&["predict", "internal-support", "--at", "10 Kpa"], "did you mean `kPa`?"),
        (&["predict", "internal-support", "--at", "ten kPa"], "does not start with a number"),
        (&["predict", "dual-chamber-finger", "--at", "10 kPa"], "one pressure per chamber"),
        (&["models", "internal"], "internal-support"),
        (&["validate", "nowhere"], "no such file or folder"),
        (&["validate", "report/none"], "no such file or folder"),
    ] {
        let said = pneuval(lab.path(), arguments);
        assert_eq!(said.code, 2, "{arguments:?}");
        assert!(said.err.contains(word), "{arguments:?}: {}", said.err);
        assert!(said.out.is_empty());
    }
}

#[test]
fn an_input_in_the_wrong_unit_or_missing_is_named_by_line_and_key() {
    let lab = Lab::new();
    let text = std::fs::read_to_string(common::datasets().join("actuators/internal-support.toml")).unwrap();
    for file in ["dataset.toml", "outer_diameter.csv"] {
        let text = std::fs::read_to_string(common::datasets().join("published/internal-support").join(file)).unwrap();
        lab.write(file, &text);
    }
    for (from, to, words) in [
        (
            "outer_diameter = { value = 30.0, unit = \"mm\"",
            "outer_diameter = { value = 30.0, unit = \"MPa\"",
            ["actuator.toml:11: key `outer_diameter`", "unit `MPa`"],
        ),
        ("C20 = ", "C2O = ", ["actuator.toml: key `C20`", "nothing"]),
    ] {
        lab.write("actuator.toml", &text.replacen(from, to, 1));
        let said = lab.validate();
        assert_eq!(said.code, 2);
        assert!(words.iter().all(|w| said.err.contains(w)), "{}", said.err);
        assert!(!lab.path().join("report").exists());
    }
}
