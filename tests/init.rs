//! First drafts of a description, and what is checked before any log is read.

// In a test a panic is how a failure is told.
#![allow(clippy::unwrap_used, clippy::panic)]

mod common;

use std::fs;
use std::path::Path;

use common::pneuval;
use common::sitting::{ACTUATOR, LOG, SESSION, Sitting};
use serde_json::Value;

/// A log in which no cell of a channel is a number.
const UNUSABLE: &str = "pressure (kPa);stroke [mm]\n0;ERR\n10;ERR\n20;ERR\n";

#[test]
fn init_proposes_a_session_that_validate_accepts_once_the_actuator_is_filled_in() {
    let rows = |n: u32, line: &dyn Fn(u32) -> String| (0..n).map(line).collect::<String>();
    let clocked =
        rows(400, &|i| format!("{}\t{:.3}\t{:.3}\r\n", 10 * i, 1.0 + f64::from(i / 100), 0.1 * f64::from(i % 7)));
    for (name, text) in [
        ("a.csv", "Pressure [bar],Tip angle (deg),Force N\n0,0,0\n0.1,10,0.2\n0.2,19,0.5\n".to_owned()),
        ("b.csv", "\u{feff}Druck;Weg\r\nkPa;mm\r\n0;0,0\r\n10;1,5\r\n20;3,5\r\n\r\nEnde der Messung\r\n".to_owned()),
        ("c.tsv", clocked),
        ("d.txt", "# rig 7\nconfig,p,x\nA 1,0,0\nA 1,50,2\nB/2,0,0\nB/2,50,3\n".to_owned()),
        ("e.log", "t pressure flex\ns V V\n0 0.1 1.9\n0.1 0.2 1.8\n0.2 0.3 1.7\n".to_owned()),
        ("f.csv", "1,2\n3,4\n5,6\n".to_owned()),
        ("g.csv", "index,measured,none\n0,1,2\n1,2,3\n2,3,4\n".to_owned()),
    ] {
        let lab = tempfile::tempdir().unwrap();
        let folder = lab.path().join("Monday 3");
        fs::create_dir(&folder).unwrap();
        fs::write(folder.join(name), &text).unwrap();
        let said = pneuval(lab.path(), &["init", "Monday 3"]);
        assert_eq!(said.code, 0, "{name}: {}", said.err);
        assert!(said.out.contains("session.toml") && said.out.contains("Next:"), "{}", said.out);
        let written = fs::read_to_string(folder.join("session.toml")).unwrap();
        let validate = || pneuval(lab.path(), &["validate", "Monday 3", "--out", "report"]);
        let said = validate();
        assert!(said.code == 2 && said.err.contains("session.toml:3: key `actuator`"), "{name}: {}", said.err);
        for id in ["internal-support", "an-actuator-of-mine"] {
            fs::write(folder.join("session.toml"), written.replace("FILL-IN", id)).unwrap();
            let said = validate();
            assert_eq!(said.code, 3, "{name} {id}: {}\n{written}", said.err);
            assert!(lab.path().join(format!("report/{id}.html")).is_file(), "{name}");
        }
        // A second time nothing is written over.
        let said = pneuval(lab.path(), &["init", "Monday 3"]);
        assert!(said.code == 2 && said.err.contains("there already"), "{}", said.err);
    }
    let empty = tempfile::tempdir().unwrap();
    let said = pneuval(empty.path(), &["init", "."]);
    assert!(said.code == 2 && said.err.contains("no log of two columns"), "{}", said.err);
    assert_eq!(fs::read_dir(empty.path()).unwrap().count(), 0);
}

#[test]
fn init_leaves_out_an_empty_column_and_takes_the_log_for_the_log() {
    let lab = tempfile::tempdir().unwrap();
    let folder = lab.path().join("monday");
    fs::create_dir(&folder).unwrap();
    fs::write(folder.join("fea.csv"), "p,u\nkPa,mm\n0,0\n40,30\n").unwrap();
    fs::write(folder.join("log.csv"), "p [kPa],spare [V],d [mm]\n0,,0\n10,,1\n20,,2\n30,,3\n").unwrap();
    let said = pneuval(lab.path(), &["init", "monday", "--actuator", "my-bellows"]);
    assert_eq!(said.code, 0, "{}", said.err);
    assert!(said.out.contains("Read:    log.csv\n") && said.out.contains("Not used: fea.csv"), "{}", said.out);
    assert!(said.out.contains("spare [V] is left out"), "{}", said.out);
    let said = pneuval(lab.path(), &["validate", "monday", "--out", "report", "--no-figures"]);
    assert_eq!(said.code, 3, "{}", said.err);
}

#[cfg(unix)]
#[test]
fn init_writes_nothing_through_a_link_that_leads_nowhere() {
    let lab = tempfile::tempdir().unwrap();
    let folder = lab.path().join("monday");
    fs::create_dir(&folder).unwrap();
    fs::write(folder.join("log.csv"), LOG).unwrap();
    let link = |name: &str| std::os::unix::fs::symlink(lab.path().join("elsewhere.toml"), folder.join(name)).unwrap();
    link("rig.toml");
    let said = pneuval(lab.path(), &["init", "monday"]);
    assert_eq!(said.code, 0, "{}", said.err);
    assert!(said.out.contains("Kept:    rig.toml"), "{}", said.out);
    fs::remove_file(folder.join("session.toml")).unwrap();
    link("session.toml");
    let said = pneuval(lab.path(), &["init", "monday"]);
    assert!(said.code == 2 && said.err.contains("there already"), "{}", said.err);
    assert!(!lab.path().join("elsewhere.toml").exists());
}

#[test]
fn a_draft_that_is_filled_in_is_nearer_than_an_embedded_actuator() {
    let sitting = Sitting::new();
    sitting.change("session.toml", "actuator = \"my-bellows\"", "actuator = \"internal-support\"");
    sitting.change("actuator.toml", "id = \"my-bellows\"\n", "");
    let told = || {
        let said = sitting.validate();
        assert_eq!(said.code, 3, "{}", said.err);
        let results = sitting.results();
        let sources = results["actuators"][0]["datasets"][0]["sources"].as_array().unwrap();
        let paths: Vec<String> = sources.iter().map(|s| s["path"].as_str().unwrap().to_owned()).collect();
        (results["actuators"][0]["title"].as_str().unwrap().to_owned(), paths)
    };
    let (title, paths) = told();
    assert_eq!((title.as_str(), paths.contains(&"actuator.toml".to_owned())), ("My bellows", true), "{paths:?}");
    for filled in [
        "[geometry]\nlength = { value = 100, unit = \"mm\", source = \"measured\" }\n",
        "[material.silicone]\nlaw = \"yeoh\"\n",
        "[chamber.air]\npressure_gauge_max = { value = 40, unit = \"kPa\", source = \"measured\" }\n",
    ] {
        sitting.write("actuator.toml", &format!("schema = 1\ntitle = \"Mine\"\n{filled}"));
        let said = sitting.validate();
        assert!(!said.err.contains("embedded"), "{}", said.err);
        if said.code == 3 {
            assert_eq!(sitting.results()["actuators"][0]["title"], "Mine", "{filled}");
        }
    }
    // Nothing but words: the embedded one describes more.
    sitting.write("actuator.toml", "schema = 1\ntitle = \"Mine\"\n");
    let (title, paths) = told();
    assert!(title != "Mine" && !paths.contains(&"actuator.toml".to_owned()), "{title} {paths:?}");
}

#[test]
fn init_takes_the_chamber_of_the_actuator_above() {
    let lab = tempfile::tempdir().unwrap();
    let chamber = "[chamber.air]\npressure_gauge_max = { value = 30, unit = \"kPa\", source = \"measured\" }\n";
    let head = "schema = 1\nid = \"balloon\"\ntype = \"balloon\"\ntitle = \"Balloon\"\nsummary = \"A balloon.\"\n\n";
    fs::write(lab.path().join("actuator.toml"), format!("{head}{chamber}")).unwrap();
    let folder = lab.path().join("monday");
    fs::create_dir(&folder).unwrap();
    fs::write(folder.join("log.csv"), "p,d\nkPa,mm\n0,20\n10,24\n20,29\n").unwrap();
    let said = pneuval(lab.path(), &["init", "monday", "--actuator", "balloon"]);
    assert_eq!(said.code, 0, "{}", said.err);
    let written = fs::read_to_string(folder.join("session.toml")).unwrap();
    assert!(written.contains("pressure = [{ channel = \"pressure\", chamber = \"air\" }]"), "{written}");
    assert_eq!(pneuval(lab.path(), &["validate", "monday", "--out", "report"]).code, 3);
}

#[test]
fn what_people_wrote_is_checked_before_what_instruments_wrote() {
    let sitting = Sitting::new();
    sitting.write("log.csv", UNUSABLE);
    assert_eq!(sitting.validate().code, 4);
    sitting.write("bounds.toml", "schema = 1\n[[bound]]\nactuator = 3\n");
    let said = sitting.validate();
    assert!(said.code == 2 && said.err.contains("bounds.toml:3"), "{}", said.err);
    fs::remove_file(sitting.path().join("bounds.toml")).unwrap();

    // A log that is missing, after one that cannot be used.
    sitting.change("session.toml", "[[run]]\n", "[[run]]\nfile = \"log.csv\"\nid = \"a\"\n\n[[run]]\n");
    sitting.change("session.toml", "[[run]]\nfile = \"log.csv\"\n\n", "[[run]]\nfile = \"gone.csv\"\n\n");
    let said = sitting.validate();
    assert!(said.code == 2 && said.err.contains("gone.csv"), "{}", said.err);

    for (name, text) in [
        ("session.toml", "schema = 1\nid = \"second\"\n"),
        ("dataset.toml", "schema = 1\nid = "),
        // Two sessions: this one's column is not in its log.
        ("session.toml", &SESSION.replace("monday", "second").replace("column = \"stroke [mm]\"", "column = \"way\"")),
    ] {
        let sitting = Sitting::new();
        sitting.write("log.csv", UNUSABLE);
        fs::create_dir(sitting.path().join("later")).unwrap();
        sitting.write("later/log.csv", LOG);
        sitting.write(&format!("later/{name}"), text);
        let said = sitting.validate();
        assert!(said.code == 2 && said.err.contains(&format!("later/{name}")), "{}", said.err);
    }
}

#[test]
fn the_sources_name_the_rig_that_was_found_and_every_table_once() {
    let sitting = Sitting::new();
    let rig = "schema = 1\nid = \"bench\"\n[instrument.laser]\ninput = \"mm\"\nstd = 0.02\n";
    sitting.change("session.toml", "id = \"stroke\"\ncolumn", "id = \"stroke\"\ninstrument = \"laser\"\ncolumn");
    sitting.change("session.toml", "actuator = ", "rig = \"bench\"\nactuator = ");
    let again = ACTUATOR.split_once("[[model]]").unwrap().1.replace("\"abaqus\"", "\"abaqus-again\"");
    sitting.write("actuator.toml", &format!("{ACTUATOR}\n[[model]]{again}"));
    fs::create_dir_all(sitting.path().join("monday")).unwrap();
    fs::create_dir_all(sitting.path().join("rigs")).unwrap();
    sitting.write("rigs/bench.toml", rig);
    for name in ["session.toml", "log.csv"] {
        fs::rename(sitting.path().join(name), sitting.path().join("monday").join(name)).unwrap();
    }
    let said = sitting.validate();
    assert_eq!(said.code, 3, "{}", said.err);
    let results = sitting.results();
    let sources = results["actuators"][0]["datasets"][0]["sources"].as_array().unwrap();
    let names: Vec<&str> = sources.iter().map(|s| s["path"].as_str().unwrap()).collect();
    assert_eq!(names, ["session.toml", "../rigs/bench.toml", "log.csv", "../actuator.toml", "../fea.csv"]);
}

#[test]
fn models_as_json_name_what_cannot_be_evaluated() {
    let rows =
        |arguments: &[&str]| -> Vec<Value> { serde_json::from_str(&pneuval(Path::new("."), arguments).out).unwrap() };
    let all = rows(&["models", "--json"]);
    let unevaluable: Vec<&Value> = all.iter().filter(|row| row["unevaluable"] == true).collect();
    assert!(!unevaluable.is_empty() && all[0]["form"].is_string() && all[0]["unevaluable"].is_null());
    for row in unevaluable {
        assert!(row["actuator"].is_string() && row["equations"].is_string() && row["source"].is_string(), "{row}");
        assert!(!row["why"].as_array().unwrap().is_empty() && row["form"].is_null(), "{row}");
    }
    assert!(rows(&["models", "internal-support", "--json"]).iter().all(|row| row["actuator"] == "internal-support"));
}
