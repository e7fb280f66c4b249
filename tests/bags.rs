//! Bags of ROS 2 through the binary: topics with clocks of their own, damage, folders.

// In a test a panic is how a failure is told.
#![allow(clippy::unwrap_used, clippy::panic)]

mod common;

use std::fs;
use std::io::Cursor;

use common::pneuval;
use common::sitting::{measured, with_log};
use pneuval_ingest::finding::LineMap;
use pneuval_ingest::formats::csv::Decimal;
use pneuval_ingest::formats::mcap::{Compression, WriteOptions, write};
use pneuval_ingest::recording::{Cells, Column, Table};
use pneuval_ingest::store::read_parquet;
use serde_json::Value;
use tempfile::TempDir;

/// Three plateaus of 2 s at 0, 20 and 40 kPa, and the stroke at each: pressure and stroke in one message, the pose in another.
fn bag() -> Vec<u8> {
    let rows = 600_usize;
    let numbers = |f: &dyn Fn(usize) -> f64| Cells::Numbers((0..rows).map(f).collect());
    let table = |name: &str, columns: Vec<Column>| Table {
        name: name.to_owned(),
        schema: None,
        columns,
        rows,
        lines: LineMap::default(),
        clock: None,
        decimal: Decimal::Point,
    };
    let stamp = |delay: f64| Column::new("log_time", Some("s"), numbers(&|i| i as f64 / 100.0 + delay));
    let step = |i: usize| (i / 200) as f64;
    let rig = table(
        "/rig",
        vec![
            stamp(0.0),
            Column::new("pressure", None, numbers(&|i| 20e3 * step(i))),
            Column::new("stroke", None, numbers(&|i| [0.0, 0.0101, 0.0299][i / 200])),
        ],
    );
    let pose = table("/pose", vec![stamp(0.003), Column::new("x", None, numbers(&|i| 1e-3 * step(i)))]);
    let mut bytes = Cursor::new(Vec::new());
    let options = WriteOptions { compression: Compression::Zstd, chunk_bytes: Some(4096), ..WriteOptions::default() };
    write(&mut bytes, &[rig, pose], &options).unwrap();
    bytes.into_inner()
}

const SESSION: &str = r#"schema = 1
id = "monday"
actuator = "my-bellows"

[[channel]]
id = "pressure"
column = "/rig.pressure"
unit = "Pa"
reference = "gauge"

[[channel]]
id = "stroke"
column = "/rig.stroke"
unit = "m"

[[channel]]
id = "pose"
column = "/pose.x"
unit = "m"

[[run]]
file = "run.mcap"

[[response]]
quantity = { id = "stroke", title = "Stroke", unit = "mm" }
pressure = [{ channel = "pressure", chamber = "air" }]
measured = { channel = "stroke" }
points = { from = "plateaus", tolerance = { value = 0.1, unit = "kPa" }, hold = { value = 1, unit = "s" }, window = { value = 0.5, unit = "s" } }
"#;

fn sitting(session: &str, bag: &[u8]) -> TempDir {
    with_log(session, "run.mcap", bag)
}

#[test]
fn a_bag_is_compared_by_its_own_clock() {
    let folder = sitting(SESSION, &bag());
    let said = pneuval(folder.path(), &["validate", ".", "--out", "report"]);
    // One repeat and no bound: nothing is decided, everything is measured.
    assert_eq!(said.code, 3, "{}", said.err);
    assert_eq!(measured(folder.path()), ["0.0000", "0.0101", "0.0299"]);
}

#[test]
fn every_topic_has_a_table_of_its_own_in_the_store() {
    let folder = sitting(SESSION, &bag());
    let said = pneuval(folder.path(), &["ingest", ".", "--json"]);
    assert_eq!(said.code, 0, "{}", said.err);
    let told: Value = serde_json::from_str(&said.out).unwrap();
    let tables = told[0]["record"]["files"][0]["runs"][0]["tables"].as_array().unwrap();
    let of = |key: &str| -> Vec<String> { tables.iter().map(|table| table[key].to_string()).collect() };
    assert_eq!(of("file"), ["\"run.rig.parquet\"", "\"run.pose.parquet\""]);
    assert_eq!((of("samples"), of("from_s")), (vec!["600".to_owned(); 2], vec!["0.0".to_owned(), "0.003".to_owned()]));
}

#[test]
fn channels_of_two_topics_are_set_against_each_other_at_plateaus_only_and_their_lag_is_told() {
    let crossed = SESSION.replace("measured = { channel = \"stroke\" }", "measured = { channel = \"pose\" }");
    let folder = sitting(&crossed, &bag());
    let said = pneuval(folder.path(), &["validate", "."]);
    assert_eq!(said.code, 3, "{}", said.err);
    // The pose is stamped 3 ms later: how much of it is a clock's nobody says.
    assert!(said.err.contains("`pose` of /pose behind `pressure`: total lag 0.003"), "{}", said.err);
    let derived = SESSION.replace(
        "[[run]]",
        "[[derived]]\nid = \"d\"\nrule = \"difference\"\nfrom = [\"stroke\", \"pose\"]\nunit = \"m\"\n\n[[run]]",
    );
    let said = pneuval(sitting(&derived, &bag()).path(), &["ingest", "."]);
    assert_eq!(said.code, 2, "{}", said.err);
    assert!(said.err.contains("channels that share one clock"), "{}", said.err);
    let commanded = SESSION.replace("column = \"/pose.x\"", "column = \"/pose.x\"\ncommanded = true");
    let follows =
        "follows = { channel = \"pose\", within = { value = 1, unit = \"mm\" }, after = { value = 1, unit = \"s\" } }";
    let follows = commanded.replace("column = \"/rig.stroke\"", &format!("column = \"/rig.stroke\"\n{follows}"));
    let said = pneuval(sitting(&follows, &bag()).path(), &["ingest", "."]);
    assert_eq!(said.code, 2, "{}", said.err);
    assert!(said.err.contains("session.toml:14") && said.err.contains("channels that share one clock"), "{}", said.err);
    assert!(said.err.contains("`stroke` from /rig, `pose` from /pose"), "{}", said.err);
}

#[test]
fn a_topic_or_field_that_is_not_there_names_what_is() {
    let folder = sitting(&SESSION.replace("/rig.pressure", "/rig.presure"), &bag());
    let said = pneuval(folder.path(), &["ingest", "."]);
    assert_eq!(said.code, 2, "{}", said.err);
    assert!(said.err.contains("did you mean `/rig.pressure`?"), "{}", said.err);
}

#[test]
fn a_clock_may_be_chosen_and_must_be_there() {
    let clocked = |clock: &str| SESSION.replace("[[run]]", &format!("[clock]\n{clock}\n\n[[run]]"));
    for (clock, code) in [("stamp = \"log\"", 0), ("stamp = \"publish\"", 0), ("column = \"/rig.log_time\"", 0)] {
        let folder = sitting(&clocked(clock), &bag());
        let said = pneuval(folder.path(), &["ingest", "."]);
        assert_eq!(said.code, code, "{clock}: {}", said.err);
        assert!(said.out.contains("100 Hz"), "{clock}: {}", said.out);
    }
    let said = pneuval(sitting(&clocked("stamp = \"header\""), &bag()).path(), &["ingest", "."]);
    assert_eq!(said.code, 2, "{}", said.err);
    assert!(said.err.contains("`header.stamp`"), "{}", said.err);
    let said = pneuval(
        sitting(&clocked("stamp = \"log\"\nrate = { value = 1, unit = \"Hz\" }"), &bag()).path(),
        &["ingest", "."],
    );
    assert_eq!(said.code, 2, "{}", said.err);
}

#[test]
fn two_channels_of_one_field_are_both_read_whichever_clock_is_theirs() {
    let twice = SESSION.replace(
        "[[channel]]\nid = \"pose\"",
        "[[channel]]\nid = \"stroke-again\"\ncolumn = \"/rig.stroke\"\nunit = \"m\"\n\n[[channel]]\nid = \"time\"\ncolumn = \"/rig.log_time\"\n\n[[channel]]\nid = \"pose\"",
    );
    for clock in ["", "[clock]\nstamp = \"log\"\n\n[[run]]", "[clock]\ncolumn = \"/rig.log_time\"\n\n[[run]]"] {
        let session = if clock.is_empty() { twice.clone() } else { twice.replace("[[run]]", clock) };
        let folder = sitting(&session, &bag());
        let said = pneuval(folder.path(), &["ingest", ".", "--json"]);
        assert_eq!(said.code, 0, "{clock}: {}", said.err);
        let columns = read_parquet(&folder.path().join(".pneuval/run.rig.parquet")).unwrap();
        let of = |name: &str| &columns.iter().find(|(column, _)| column == name).unwrap().1;
        assert_eq!((of("stroke_m"), of("time_s").len()), (of("stroke_again_m"), 600), "{clock}");
        assert_eq!(of("time_s"), of("time_s_2"), "{clock}");
        assert_eq!(pneuval(folder.path(), &["validate", "."]).code, 3, "{clock}");
    }
}

#[test]
fn one_file_that_cannot_be_looked_at_does_not_hide_the_others() {
    let folder = sitting(SESSION, &bag());
    fs::write(folder.path().join("film.mp4"), b"\0\0\0\x20ftypisom").unwrap();
    let said = pneuval(folder.path(), &["inspect", "film.mp4", "run.mcap", "--json"]);
    assert_eq!(said.code, 4, "{}", said.err);
    let told: Value = serde_json::from_str(&said.out).unwrap();
    assert_eq!((told.as_array().unwrap().len(), &told[0]["file"]), (1, &Value::from("run.mcap")));
    let said = pneuval(folder.path(), &["inspect", "film.mp4", "gone.csv", "run.mcap"]);
    assert_eq!(said.code, 2, "what the user can mend comes first: {}", said.err);
    assert!(said.err.contains("ffmpeg") && said.err.contains("gone.csv") && said.out.contains("/rig"), "{}", said.err);
}

#[test]
fn a_cut_bag_is_3_with_what_is_left_and_none_of_it_4() {
    let whole = bag();
    let folder = sitting(SESSION, &whole[..whole.len() / 2]);
    let said = pneuval(folder.path(), &["ingest", "."]);
    assert_eq!(said.code, 3, "{}", said.err);
    assert!(said.err.contains("lost: monday, run.mcap: "), "{}", said.err);
    let looked = pneuval(folder.path(), &["inspect", "run.mcap", "--json"]);
    assert_eq!(looked.code, 3, "{}", looked.err);
    let told: Value = serde_json::from_str(&looked.out).unwrap();
    let lost: Vec<&Value> =
        told[0]["findings"].as_array().unwrap().iter().filter(|f| f["severity"] == "lost").collect();
    assert!(lost.iter().any(|f| f["kind"] == "truncated"), "{lost:?}");
    // How far it was read, how much of it was not, and up to when.
    let text = lost[0]["text"].as_str().unwrap();
    let number = |before: &str, after: &str| -> f64 {
        let (_, rest) = text.split_once(before).unwrap_or_else(|| panic!("{before}: {text}"));
        rest.split_once(after).unwrap().0.parse().unwrap_or_else(|error| panic!("{error}: {text}"))
    };
    let read_to = number("it is read up to byte ", ",");
    let unread = number(&format!("read up to byte {read_to}, "), " bytes behind");
    assert!((read_to + unread - (whole.len() / 2) as f64).abs() < 0.5, "{text}");
    let last = told[0]["tables"].as_array().unwrap().iter().filter_map(|t| t["to_s"].as_f64()).fold(0.0, f64::max);
    assert!((number("was logged at ", " s") - last).abs() < 1e-3 && last > 0.1, "{text}, {last}");

    let folder = sitting(SESSION, &whole[..40]);
    let said = pneuval(folder.path(), &["inspect", "run.mcap"]);
    assert_eq!(said.code, 4, "{}", said.err);
    assert_eq!(pneuval(folder.path(), &["ingest", "."]).code, 4);

    let mut flipped = whole.clone();
    flipped[whole.len() / 3] ^= 0x10;
    let said = pneuval(sitting(SESSION, &flipped).path(), &["inspect", "run.mcap"]);
    assert_eq!(said.code, 3, "{}", said.out);
}

#[test]
fn a_bag_folder_is_one_recording_and_foreign_files_name_their_conversion() {
    let folder = sitting(&SESSION.replace("run.mcap", "bag"), &bag());
    fs::create_dir(folder.path().join("bag")).unwrap();
    fs::rename(folder.path().join("run.mcap"), folder.path().join("bag/bag_0.mcap")).unwrap();
    fs::write(
        folder.path().join("bag/metadata.yaml"),
        "rosbag2_bagfile_information:\n  version: 5\n  storage_identifier: mcap\n  relative_file_paths:\n    - bag_0.mcap\n  message_count: 1200\n",
    )
    .unwrap();
    let said = pneuval(folder.path(), &["ingest", "."]);
    assert_eq!(said.code, 0, "{}", said.err);
    let said = pneuval(folder.path(), &["inspect", "bag"]);
    assert_eq!(said.code, 0, "{}", said.err);

    for (name, head, next) in [
        ("old.db3", &b"SQLite format 3\0\x10\0"[..], "ros2 bag convert"),
        ("film.mp4", b"\0\0\0\x20ftypisom", "ffmpeg -i film.mp4"),
        ("book.xlsx", b"PK\x03\x04\x14\0[Content_Types].xml", "libreoffice"),
    ] {
        fs::write(folder.path().join(name), head).unwrap();
        let said = pneuval(folder.path(), &["inspect", name]);
        assert_eq!(said.code, 4, "{}", said.err);
        assert!(said.err.contains(next), "{}", said.err);
    }
}
