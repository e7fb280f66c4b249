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

/// Makes a mistake in the laboratory, which is told by place, with nothing written.
fn told(lab: &Lab, file: &str, from: &str, to: &str, words: &[&str]) {
    lab.change(file, from, to);
    let said = lab.validate();
    assert_eq!(said.code, 2, "{file}: {to:?}: {}{}", said.out, said.err);
    for word in words {
        assert!(said.err.contains(word), "{file}: {to:?}: expected {word:?} in\n{}", said.err);
    }
    assert!(said.err.contains("\n  next:     "), "{file}: {to:?}: no next step in\n{}", said.err);
    assert!(said.out.is_empty() && !lab.path().join("report").exists(), "{file}: {to:?}: something was written");
}

/// The made-up dataset with a piece added to one of its files.
fn lab_with(file: &str, more: &str) -> Lab {
    let lab = Lab::new();
    let text = std::fs::read_to_string(lab.path().join(file)).unwrap();
    lab.write(file, &format!("{text}\n{more}"));
    lab
}

const MATERIAL: &str = r#"[material.skin]
law = "yeoh"

[material.skin.constants]
C10 = { value = 0.1, unit = "MPa", source = "measured" }
"#;

#[test]
fn mistakes_in_a_material() {
    assert_eq!(lab_with("actuator.toml", MATERIAL).validate().code, 3);
    for (from, to, words) in [
        ("\"yeoh\"", "\"yeho\"", ["actuator.toml:13: key `law`", "a hyperelastic law", "did you mean `yeoh`?"]),
        ("law = \"yeoh\"\n", "", ["actuator.toml:12: key `[material.skin]`", "expected: key `law`", "add `law`"]),
        ("law =", "lwa =", ["actuator.toml:13: key `lwa`", "one of: law, constants", "did you mean `law`?"]),
        (
            "C10 =",
            "C20 =",
            ["actuator.toml:13: key `law`", "the constants of `yeoh`", "parameter `C10` is missing (half the initial"],
        ),
        ("0.1", "-0.1", ["actuator.toml:13: key `law`", "C10 = -100000", "outside its domain"]),
        ("MPa", "mm", ["actuator.toml:16: key `C10`", "in a unit of Pa", "unit `mm`"]),
        ("MPa", "Mpa", ["actuator.toml:16: key `C10`", "a known unit", "did you mean `MPa`?"]),
    ] {
        told(&lab_with("actuator.toml", MATERIAL), "actuator.toml", from, to, &words);
    }
    // Of two materials, the one that is wrong.
    let second = MATERIAL.replace("skin", "core").replace("C10", "C20");
    let two = lab_with("actuator.toml", &format!("{MATERIAL}\n{second}"));
    told(&two, "actuator.toml", "core", "core", &["actuator.toml:19: key `law`", "`C10` is missing"]);
}

#[test]
fn mistakes_in_a_fit() {
    let fit = "form = \"f\"\nmodel = \"consistent\"\nfit = { to = \"model\", parameters = [\"C10\"], hold_out = \"one-pressure\" }\n";
    for (change, words) in [
        ("", ["dataset.toml:21: key `fit`", "to = \"measured\" beside it", "remove `hold_out`"]),
        (
            "one-presure",
            ["dataset.toml:21: key `fit`", "one of: none, one-pressure, odd-pressures", "did you mean `one-p"],
        ),
    ] {
        let fit = if change.is_empty() { fit.to_owned() } else { fit.replace("one-pressure", change) };
        told(&Lab::new(), "dataset.toml", "form = \"model\"\n", &fit, &words);
    }
    // A form that is printed beside the measurement is not computed.
    let printed =
        "form = \"model\"\nfit = { to = \"measured\", parameters = [\"C10\"], hold_out = \"one-pressure\" }\n";
    let words = ["dataset.toml:20: key `fit`", "`model`, which is printed in the table", "remove them"];
    told(&Lab::new(), "dataset.toml", "form = \"model\"\n", printed, &words);
}

#[test]
fn mistakes_in_components() {
    let unit = "unit = \"mm\" }";
    for (to, words) in [
        (
            "unit = \"mm\", components = [\"x\"] }",
            ["dataset.toml:11: key `quantity`", "at least two components", "leave `components` out"],
        ),
        (
            "unit = \"mm\", components = [\"x\", \"x\"] }",
            ["dataset.toml:11: key `quantity`", "every component named once", "x, x"],
        ),
        (
            "unit = \"mm\", components = [\"x\", \"z\"] }",
            ["dataset.toml:14: key `measured`", "2 for `size`: x, z", "name one per component"],
        ),
    ] {
        told(&Lab::new(), "dataset.toml", unit, to, &words);
    }
    let words = ["dataset.toml:15: key `predicted`", "one for `size`", "found:    2"];
    told(&Lab::new(), "dataset.toml", "column = \"model\"", "column = [\"model\", \"p\"]", &words);
    let words = ["dataset.toml:15: key `predicted`", "a column name in quotes, or one per component", "found:    3"];
    told(&Lab::new(), "dataset.toml", "column = \"model\"", "column = 3", &words);
}

/// A table of tip forces for the embedded fruit finger, whose model asks for the held angle.
fn held() -> Lab {
    let lab = Lab::new();
    lab.write("size.csv", "p,angle,model,measured\nkPa,deg,N,N\n10,0,0.1,0.07\n20,0,0.2,0.24\n20,30,0.1,0.08\n");
    for (from, to) in [
        ("actuator = \"balloon\"", "actuator = \"fruit-finger\""),
        ("id = \"size\"", "id = \"tip-force\""),
        ("unit = \"mm\"", "unit = \"N\""),
        ("chamber = \"air\"", "chamber = \"chamber\""),
        (
            "measured = {",
            "condition = [{ column = \"angle\", id = \"held_angle\", title = \"held at\", unit = \"deg\" }]\nmeasured = {",
        ),
        ("quantity = \"size\"\nform = \"model\"", "quantity = \"tip-force\"\nform = \"consistent-proportional\""),
    ] {
        lab.change("dataset.toml", from, to);
    }
    lab
}

#[test]
fn mistakes_in_a_condition() {
    assert_eq!(held().validate().code, 3);
    let lab = held();
    lab.change(
        "size.csv",
        "p,angle,model,measured\nkPa,deg,N,N\n10,0,0.1,0.07\n20,0,0.2,0.24\n20,30,",
        "p,model,measured\nkPa,N,N\n10,",
    );
    let all = "condition = [{ column = \"angle\", id = \"held_angle\", title = \"held at\", unit = \"deg\" }]\n";
    let form = "dataset.toml:19: key `form`, `consistent-proportional` of `tip-force`";
    told(&lab, "dataset.toml", all, "", &[form, "conditions held_angle / rad", "unit `N`, chambers chamber\n"]);
    let form = "dataset.toml:20: key `form`, `consistent-proportional` of `tip-force`";
    let words = [form, "conditions held_angle / rad", "conditions angle / deg"];
    told(&held(), "dataset.toml", "id = \"held_angle\"", "id = \"angle\"", &words);
    let lab = held();
    lab.change("size.csv", "kPa,deg", "kPa,mm");
    let words = [form, "conditions held_angle / rad", "conditions held_angle / mm"];
    told(&lab, "dataset.toml", "unit = \"deg\"", "unit = \"mm\"", &words);
    let words = ["size.csv:4: column `angle`", "a value of the condition", "no number"];
    told(&held(), "size.csv", "20,0,", "20,,", &words);
    told(&held(), "size.csv", "kPa,deg", "kPa,mm", &["size.csv:2: column `angle`", "expected: an angle", "unit `mm`"]);
    let words = ["size.csv:1: column `angel`", "did you mean `angle`?"];
    told(&held(), "dataset.toml", "column = \"angle\"", "column = \"angel\"", &words);
    let words = ["dataset.toml:14: key `condition`", "one of: column, id, title, unit", "did you mean `id`?"];
    told(&held(), "dataset.toml", "id = \"held_angle\"", "idd = \"held_angle\"", &words);
}

const STATISTIC: &str = r#"[[statistic]]
quantity = { id = "tip", title = "Tip", unit = "mm" }
form = "stated"
title = "as stated"
place = "section 4"
method = "camera"
metrics = { rmse = "0.962" }
"#;

#[test]
fn mistakes_in_a_stated_error() {
    assert_eq!(lab_with("dataset.toml", STATISTIC).validate().code, 3);
    let metrics = "dataset.toml:27: key `metrics`";
    for (from, to, words) in [
        ("rmse =", "rsme =", [metrics, "a metric", "did you mean `rmse`?"]),
        ("rmse =", "r2 =", [metrics, "`r2`", "use one of: bias, mae"]),
        ("\"0.962\"", "\"0,962\"", [metrics, "a number as printed", "`0,962`"]),
        ("\"0.962\"", "\"about 1\"", [metrics, "a number as printed", "`about 1`"]),
        ("\"0.962\"", "\"NaN\"", [metrics, "a number as printed", "`NaN`"]),
        ("\"0.962\"", "0.962", [metrics, "expected: text in quotes", "floating point `0.962`"]),
        ("rmse = \"0.962\"", "", ["dataset.toml:23: key `form`", "at least one metric", "add it to `metrics`"]),
        ("place = \"section 4\"\n", "", ["dataset.toml:21: key `[[statistic]]`", "key `place`", "nothing"]),
        (
            "id = \"tip\", title = \"Tip\", unit = \"mm\" }\nform = \"stated\"",
            "id = \"size\", title = \"Size\", unit = \"mm\" }\nform = \"model\"",
            ["dataset.toml:23: key `form`", "every form once", "`model` of `size` twice"],
        ),
    ] {
        told(&lab_with("dataset.toml", STATISTIC), "dataset.toml", from, to, &words);
    }
}

const IMPORTED: &str = r#"[[model]]
kind = "imported"
form = "fem"
quantity = { id = "size", title = "Size", unit = "mm" }
file = "fem.csv"
pressure = { column = "p", chamber = "air", reference = "gauge" }
predicted = "u"
std = "s"
"#;

/// The made-up dataset, compared with a table that the actuator file names.
fn imported() -> Lab {
    let lab = lab_with("actuator.toml", IMPORTED);
    lab.write("fem.csv", "p,u,s\nkPa,mm,mm\n0,10,0.1\n10,21,0.1\n20,28,0.1\n30,43,0.1\n");
    lab.change("dataset.toml", "form = \"model\"\n", "form = \"fem\"\n");
    lab
}

#[test]
fn mistakes_in_an_imported_model() {
    assert_eq!(imported().validate().code, 3);
    let form = "dataset.toml:19: key `form`, `fem` of `size`";
    for (file, from, to, words) in [
        ("fem.csv", "20,28", "10,28", ["fem.csv:5: column `p`", "pressures that rise", "found:    `10`"]),
        ("fem.csv", "30,43", "15,43", ["fem.csv:6: column `p`", "pressures that rise", "loading or unloading"]),
        ("fem.csv", "28", "n/a", ["fem.csv:5: column `u`", "expected: a number", "`n/a`"]),
        ("fem.csv", "28", "", ["fem.csv:5: column `u`", "a number in every row", "no number"]),
        ("fem.csv", "28,0.1", "28,-0.1", ["fem.csv:5: column `s`", "standard uncertainty >= 0", "`-0.1`"]),
        ("fem.csv", "\n10,21,0.1\n20,28,0.1\n30,43,0.1", "", ["actuator.toml:16: key `file`", "at least two", "1 in"]),
        ("fem.csv", "kPa,mm", "kPa,deg", ["fem.csv:2: column `u`", "expected: a length", "unit `deg`"]),
        ("fem.csv", "kPa,mm", "mm,mm", ["fem.csv:2: column `p`", "expected: a pressure", "unit `mm`"]),
        ("actuator.toml", "\"u\"", "\"uu\"", ["fem.csv:1: column `uu`", "columns p, u, s", "did you mean `u`?"]),
        ("actuator.toml", "\"u\"", "[\"u\", \"s\"]", ["actuator.toml:18: key `predicted`", "one for `size`", "2"]),
        (
            "actuator.toml",
            "\"fem.csv\"",
            "\"fen.csv\"",
            ["actuator.toml:16: key `file`", "fen.csv: cannot be read", "put"],
        ),
        (
            "actuator.toml",
            "\"fem.csv\"",
            "\"../f.csv\"",
            ["actuator.toml:16: key `file`", "inside this folder", "`../f"],
        ),
        ("actuator.toml", "chamber = \"air\"", "chamber = \"water\"", [form, "chamber water", "chambers air"]),
        ("actuator.toml", "\"gauge\"", "\"absolute\"", ["actuator.toml:17: key `pressure`", "`absolute`", "gauge"]),
        ("actuator.toml", "\"imported\"", "\"importd\"", ["actuator.toml:13: key `kind`", "`importd`", "did you mean"]),
        ("dataset.toml", "\"fem\"", "\"fen\"", ["dataset.toml:19: key `form`", "`fen`", "did you mean `fem`?"]),
        (
            "dataset.toml",
            "form = \"fem\"\n",
            "form = \"f\"\nmodel = \"fem\"\nfit = { to = \"measured\", parameters = [\"C10\"] }\n",
            ["dataset.toml:19: key `fit`", "`C10`", "a table has no parameters"],
        ),
    ] {
        told(&imported(), file, from, to, &words);
    }
    told(
        &imported(),
        "fem.csv",
        "kPa,mm,mm\n",
        "",
        &["fem.csv:2: column `p`", "a unit", "`0`", "write the units in a line"],
    );
    // A table of angles does not predict a length.
    let lab = imported();
    lab.change("fem.csv", "kPa,mm,mm", "kPa,deg,deg");
    told(&lab, "actuator.toml", "unit = \"mm\"", "unit = \"deg\"", &[form, "a unit of rad", "unit `mm`"]);
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
        (text.replacen("\"schema_version\": 4", "\"schema_version\": 5", 1), "schema_version 4 expected, found 5"),
        (text.replacen("\"schema_version\": 4", "\"schema_version\": 2", 1), "schema_version 4 expected, found 2"),
        (text.replacen("\"n_used\"", "\"n_sued\"", 1), "n_sued"),
        (text[..text.len() / 2].to_owned(), "not JSON"),
    ] {
        assert_ne!(damaged, text);
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
        (&["predict", "fruit-finger", "--with", "held_angle = 30 mm"], "angle to which the tip is held"),
        (&["predict", "fruit-finger", "--with", "held_angle = 30"], "write the unit behind the number"),
        (&["predict", "fruit-finger", "--with", "held_angle = 30 dge"], "did you mean `deg`?"),
        (&["predict", "fruit-finger", "--with", "held_angle = deg"], "does not start with a number"),
        (&["predict", "fruit-finger", "--with", "held_angle"], "write NAME = VALUE"),
        (&["predict", "fruit-finger", "--with", "held_angel = 30 deg"], "did you mean `held_angle`?"),
        (&["predict", "fruit-finger", "--with", "held_angle=30deg", "--with", "held_angle=0deg"], "`held_angle` twice"),
        (&["predict", "fruit-finger", "--with", "finger_lenght = 30 mm"], "did you mean `finger_length`?"),
        (&["predict", "fruit-finger", "--with", "finger_length = 30 deg"], "L, length of the finger"),
        (&["predict", "internal-support", "--with", "held_angle = 30 deg"], "--with `held_angle`"),
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
