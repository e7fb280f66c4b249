//! The store, by the binary: what is read again, what changes, what other programs see.

// In a test a panic is how a failure is told.
#![allow(clippy::unwrap_used, clippy::panic)]

mod common;

use std::fs;
use std::path::Path;

use common::{Said, pneuval};
use pneuval_ingest::store::{Series, read_parquet};
use serde_json::Value;
use tempfile::TempDir;

const SESSION: &str = r#"schema = 1
id = "monday"
actuator = "internal-support"

[clock]
column = "t"
unit = "ms"

[[channel]]
id = "pressure"
column = "p"
unit = "kPa"
reference = "gauge"

[[channel]]
id = "tip-force"
column = "F"
unit = "N"

[[run]]
file = "a.csv"

[[run]]
file = "A.log"

[[response]]
quantity = { id = "tip-force", title = "Tip force", unit = "N" }
pressure = [{ channel = "pressure", chamber = "chamber" }]
measured = { channel = "tip-force" }
"#;

fn sitting() -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("session.toml"), SESSION).unwrap();
    fs::write(folder.path().join("a.csv"), "t,p,F\n0,0,0\n10,1,0.5\n20,2,\n30,3,1.5\n").unwrap();
    fs::write(folder.path().join("A.log"), "t,p,F\n0,0,0\n10,1,0.25\n").unwrap();
    folder
}

/// Ingests, as JSON: what was said, and what was stored of the only session.
fn ingested(folder: &Path) -> (Said, Value) {
    let said = pneuval(folder, &["ingest", ".", "--json"]);
    let told: Value = serde_json::from_str(&said.out).unwrap_or_else(|error| panic!("{error}: {}", said.err));
    (said, told[0].clone())
}

/// The files of a store with their bytes.
fn files(store: &Path) -> Vec<(String, Vec<u8>)> {
    let mut files: Vec<_> = fs::read_dir(store)
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .map(|path| (path.file_name().unwrap().to_str().unwrap().to_owned(), fs::read(&path).unwrap()))
        .collect();
    files.sort();
    files
}

fn names(value: &Value) -> Vec<&str> {
    value.as_array().unwrap().iter().map(|name| name.as_str().unwrap()).collect()
}

#[test]
fn channels_are_columns_in_si_units_and_holes_are_null() {
    let folder = sitting();
    let (said, told) = ingested(folder.path());
    // A hole in one of six samples is more than the session allows.
    assert_eq!(said.code, 3, "{}", said.err);
    let table = &told["record"]["files"][0]["runs"][0]["tables"][0];
    assert_eq!((&table["file"], &table["samples"], &table["rate_hz"]), (&"a.parquet".into(), &4.into(), &100.0.into()));
    let columns = read_parquet(&folder.path().join(".pneuval/a.parquet")).unwrap();
    let expected = [
        ("time_s", vec![Some(0.0), Some(0.01), Some(0.02), Some(0.03)]),
        ("pressure_Pa", vec![Some(0.0), Some(1e3), Some(2e3), Some(3e3)]),
        ("tip_force_N", vec![Some(0.0), Some(0.5), None, Some(1.5)]),
    ];
    assert_eq!(columns, expected.map(|(name, cells)| (name.to_owned(), Series::Number(cells))));
    assert_eq!(table["channels"][1]["holes"], 1);
}

#[test]
fn only_what_has_changed_is_read_again_and_the_bytes_are_the_same() {
    let folder = sitting();
    let store = folder.path().join(".pneuval");
    let (_, first) = ingested(folder.path());
    assert_eq!((names(&first["read"]), names(&first["unchanged"])), (vec!["a.csv", "A.log"], vec![]));
    let before = files(&store);
    let record = || fs::metadata(store.join("session.json")).unwrap().modified().unwrap();
    let written = record();

    let (_, again) = ingested(folder.path());
    assert_eq!((names(&again["read"]), names(&again["unchanged"])), (vec![], vec!["a.csv", "A.log"]));
    assert_eq!((files(&store), record()), (before.clone(), written), "nothing is written where nothing has changed");

    fs::write(folder.path().join("A.log"), "t,p,F\n0,0,0\n10,1,0.75\n").unwrap();
    let (_, changed) = ingested(folder.path());
    assert_eq!((names(&changed["read"]), names(&changed["unchanged"])), (vec!["A.log"], vec!["a.csv"]));
    // Findings of what was not read again are still told.
    assert_eq!(changed["record"]["files"][0]["findings"], first["record"]["files"][0]["findings"]);

    // A store that somebody damaged, a record that nobody understands, another manifest: built anew.
    fs::write(folder.path().join("A.log"), "t,p,F\n0,0,0\n10,1,0.25\n").unwrap();
    fs::write(store.join("a.parquet"), b"PAR1").unwrap();
    let (_, mended) = ingested(folder.path());
    assert_eq!(names(&mended["read"]), ["a.csv", "A.log"]);
    assert_eq!(files(&store), before);
    fs::write(store.join("session.json"), "{}").unwrap();
    assert_eq!(names(&ingested(folder.path()).1["read"]).len(), 2);
    fs::write(folder.path().join("session.toml"), SESSION.replace("\"kPa\"", "\"Pa\"")).unwrap();
    assert_eq!(names(&ingested(folder.path()).1["read"]).len(), 2);
}

#[test]
fn a_log_that_was_mended_takes_no_table_of_another() {
    let folder = sitting();
    let store = folder.path().join(".pneuval");
    fs::write(folder.path().join("a.csv"), "the rig was off\n").unwrap();
    ingested(folder.path());
    let names = || files(&store).into_iter().map(|(name, _)| name).collect::<Vec<String>>();
    assert_eq!(names(), ["A.parquet", "session.json"]);
    // The name is that of the first run again, as in a store made anew.
    fs::write(folder.path().join("a.csv"), "t,p,F\n0,0,0\n10,1,0.5\n20,2,\n30,3,1.5\n").unwrap();
    let (_, told) = ingested(folder.path());
    assert_eq!(names(), ["A-2.parquet", "a.parquet", "session.json"]);
    let rows = |file: usize| told["record"]["files"][file]["runs"][0]["tables"][0]["samples"].clone();
    assert_eq!((rows(0), rows(1)), (4.into(), 2.into()));
    let read = |name: &str| read_parquet(&store.join(name)).unwrap()[0].1.len();
    assert_eq!((read("a.parquet"), read("A-2.parquet")), (4, 2));
}

#[test]
fn a_run_that_is_gone_takes_its_table_with_it_and_names_that_differ_in_case_are_two_files() {
    let folder = sitting();
    let store = folder.path().join(".pneuval");
    ingested(folder.path());
    let names: Vec<String> = files(&store).into_iter().map(|(name, _)| name).collect();
    assert_eq!(names, ["A-2.parquet", "a.parquet", "session.json"]);
    fs::write(folder.path().join("session.toml"), SESSION.replace("[[run]]\nfile = \"A.log\"\n", "")).unwrap();
    ingested(folder.path());
    let names: Vec<String> = files(&store).into_iter().map(|(name, _)| name).collect();
    assert_eq!(names, ["a.parquet", "session.json"]);
}

#[test]
fn the_store_is_where_it_was_asked_for_and_the_session_stays_as_it_is() {
    let folder = sitting();
    let said = pneuval(folder.path(), &["ingest", ".", "--store", "elsewhere"]);
    assert_eq!(said.code, 3, "{}", said.err);
    assert!(folder.path().join("elsewhere/monday/session.json").is_file());
    assert!(!folder.path().join(".pneuval").exists());
    assert!(said.out.contains("2 files read, 0 unchanged; stored in elsewhere/monday"), "{}", said.out);
}

#[test]
fn a_cut_file_is_3_one_without_numbers_beside_others_is_3_and_alone_4() {
    let folder = sitting();
    fs::write(folder.path().join("a.csv"), "t,p,F\n0,0,0\n10,1,0.5\n20,2").unwrap();
    let (said, told) = ingested(folder.path());
    assert_eq!(said.code, 3);
    assert!(said.err.contains("lost: monday, a.csv: the file ends within line 4"), "{}", said.err);
    assert_eq!(told["record"]["files"][0]["findings"][0]["kind"], "truncated");

    fs::write(folder.path().join("a.csv"), "boot\nno sensor\n").unwrap();
    let (said, told) = ingested(folder.path());
    assert_eq!((said.code, told["record"]["files"][0]["runs"].as_array().map(Vec::len)), (3, Some(0)));

    fs::write(folder.path().join("A.log"), "boot\n").unwrap();
    let before = files(&folder.path().join(".pneuval"));
    let said = pneuval(folder.path(), &["ingest", "."]);
    assert_eq!(said.code, 4, "{}", said.err);
    assert_eq!(files(&folder.path().join(".pneuval")), before, "what cannot be used changes nothing");
}

#[test]
fn tables_of_somebody_else_stay_where_they_are() {
    let folder = sitting();
    let store = folder.path().join("shared/monday");
    fs::create_dir_all(&store).unwrap();
    fs::write(store.join("theirs.parquet"), "theirs").unwrap();
    for session in [SESSION.to_owned(), SESSION.replace("\n[[run]]\nfile = \"A.log\"\n", "")] {
        fs::write(folder.path().join("session.toml"), session).unwrap();
        assert_eq!(pneuval(folder.path(), &["ingest", ".", "--store", "shared"]).code, 3);
        assert_eq!(fs::read(store.join("theirs.parquet")).unwrap(), b"theirs");
    }
    // What the run of before left is the store's own, and goes with the run.
    let names: Vec<String> = files(&store).into_iter().map(|(name, _)| name).collect();
    assert_eq!(names, ["a.parquet", "session.json", "theirs.parquet"]);
}

/// What `inspect` suggests for a log, with what only the user knows.
fn suggested(text: &str) -> String {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("log.txt"), text).unwrap();
    let said = pneuval(folder.path(), &["inspect", "log.txt", "--json"]);
    let told: Value = serde_json::from_str(&said.out).unwrap_or_else(|error| panic!("{error}: {}", said.err));
    let block = told[0]["session"].as_str().unwrap().to_owned();
    let session = format!("schema = 1\nid = \"monday\"\nactuator = \"internal-support\"\n{block}");
    fs::write(folder.path().join("session.toml"), session).unwrap();
    let (said, told) = ingested(folder.path());
    assert_eq!(said.code, 0, "{block}\n{}", said.err);
    let rate = told["record"]["files"][0]["runs"][0]["tables"][0]["rate_hz"].as_f64();
    format!("{:.0} Hz {block}", rate.unwrap_or_else(|| panic!("{block}")))
}

#[test]
fn the_suggested_clock_gives_the_rate_that_was_logged() {
    let lines = |line: &dyn Fn(u32) -> String| (0..50).map(line).collect::<String>();
    // A step of 10 is 10 ms, one of 0.01 is 10 ms, and stamps since 1970 tell their unit themselves.
    for (rate, unit, log) in [
        ("100 Hz", "ms", format!("t,p\n{}", lines(&|i| format!("{},{i}\n", 10 * i)))),
        ("1000 Hz", "ms", format!("t,p\n{}", lines(&|i| format!("{i},{i}\n")))),
        ("100 Hz", "s", format!("t,p\n{}", lines(&|i| format!("{:.2},{i}\n", 0.01 * f64::from(i))))),
        ("100 Hz", "ms", lines(&|i| format!("t={} p={i}\n", 10 * i))),
        ("100 Hz", "s", lines(&|i| format!("t:{:.2}\tp:{i}\n", 0.01 * f64::from(i)))),
        ("1 Hz", "s", format!("time,p\n{}", lines(&|i| format!("{},{i}\n", 1_790_000_000 + i)))),
        ("100 Hz", "ms", format!("time,p\n{}", lines(&|i| format!("{},{i}\n", 1_790_000_000_000 + 10 * u64::from(i))))),
        ("100 Hz", "us", format!("micros,p\n{}", lines(&|i| format!("{},{i}\n", 10_000 * i)))),
    ] {
        let told = suggested(&log);
        assert!(told.starts_with(rate) && told.contains(&format!("unit = \"{unit}\"")), "{log}{told}");
    }
}

#[test]
fn dates_that_go_back_are_told_in_a_short_log_too() {
    let folder = tempfile::tempdir().unwrap();
    let times = ["23:58", "23:59", "00:00", "00:01", "00:02"];
    let rows: Vec<String> = times.iter().enumerate().map(|(i, time)| format!("2024-03-05 {time},{i}\n")).collect();
    fs::write(folder.path().join("night.csv"), format!("when,p\n{}", rows.concat())).unwrap();
    let said = pneuval(folder.path(), &["inspect", "night.csv"]);
    assert!(said.out.contains("`when`: time goes back once") && said.out.contains("(line 4)"), "{}", said.out);
}

#[test]
fn mistakes_are_told_before_anything_is_written() {
    let folder = sitting();
    fs::remove_file(folder.path().join("A.log")).unwrap();
    let said = pneuval(folder.path(), &["ingest", "."]);
    assert_eq!(said.code, 2, "{}", said.err);
    assert!(said.err.contains("A.log"), "{}", said.err);
    assert!(!folder.path().join(".pneuval").exists());

    let folder = sitting();
    fs::write(folder.path().join("session.toml"), SESSION.replace("column = \"F\"", "column = \"G\"")).unwrap();
    let said = pneuval(folder.path(), &["ingest", "."]);
    assert_eq!(said.code, 2, "{}", said.err);
    assert!(said.err.contains("a column of the log: t, p, F"), "{}", said.err);
    assert!(!folder.path().join(".pneuval").exists());
}
