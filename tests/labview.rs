//! What LabVIEW writes, through the binary: TDMS streams, their damage and their scales, and measurement files.

// In a test a panic is how a failure is told.
#![allow(clippy::unwrap_used, clippy::panic)]

mod common;
#[path = "../ingest/tests/common/tdms.rs"]
mod tdms;

use std::fs;

use common::pneuval;
use common::sitting::{measured, with_log};
use pneuval_ingest::store::read_parquet;
use serde_json::Value;
use tdms::{LITTLE, Prop, USUAL, i16s};
use tempfile::TempDir;

/// Three plateaus of 2 s at 0, 20 and 40 kPa at 100 Hz, and the stroke at each, as a card with 16 bits measures both.
fn stream() -> Vec<u8> {
    let plateau = |i: usize, of: [i16; 3]| of[i / 200];
    let scale = |slope: f64, unit: &'static str| {
        [
            ("unit_string", Prop::Text(unit)),
            ("wf_increment", Prop::F64(0.01)),
            ("wf_start_time", Prop::Time(3_871_000_000, 0)),
            ("NI_Number_Of_Scales", Prop::U32(1)),
            ("NI_Scale[0]_Scale_Type", Prop::Text("Linear")),
            ("NI_Scale[0]_Linear_Slope", Prop::F64(slope)),
            ("NI_Scale[0]_Linear_Y_Intercept", Prop::F64(0.0)),
            ("NI_Scale[0]_Linear_Input_Source", Prop::U32(u32::MAX)),
        ]
    };
    let mut bytes = vec![];
    for block in 0..12 {
        let rows = block * 50..block * 50 + 50;
        // 2 Pa a count: 40 kPa do not fit into 16 bits otherwise.
        let pressure: Vec<i16> = rows.clone().map(|i| plateau(i, [0, 10_000, 20_000])).collect();
        let stroke: Vec<i16> = rows.map(|i| plateau(i, [0, 101, 299])).collect();
        let index = LITTLE.index(2, 50);
        let objects = [
            LITTLE.object("/'rig'/'p'", &index, &scale(2.0, "Pa")),
            LITTLE.object("/'rig'/'stroke'", &index, &scale(0.1, "mm")),
        ];
        bytes.extend(LITTLE.segment(USUAL, &objects, &i16s(&[pressure, stroke].concat())));
    }
    bytes
}

const SESSION: &str = r#"schema = 1
id = "monday"
actuator = "my-bellows"

[[channel]]
id = "pressure"
column = "rig.p"
reference = "gauge"

[[channel]]
id = "stroke"
column = "rig.stroke"

[[run]]
file = "run.tdms"

[[response]]
quantity = { id = "stroke", title = "Stroke", unit = "mm" }
pressure = [{ channel = "pressure", chamber = "air" }]
measured = { channel = "stroke" }
points = { from = "plateaus", tolerance = { value = 0.1, unit = "kPa" }, hold = { value = 1, unit = "s" }, window = { value = 0.5, unit = "s" } }
"#;

fn sitting(stream: &[u8]) -> TempDir {
    with_log(SESSION, "run.tdms", stream)
}

#[test]
fn a_stream_is_compared_by_the_times_that_its_waveforms_state() {
    let folder = sitting(&stream());
    let said = pneuval(folder.path(), &["validate", ".", "--out", "report"]);
    // One repeat and no bound: nothing is decided, everything is measured.
    assert_eq!(said.code, 3, "{}", said.err);
    assert_eq!(measured(folder.path()), ["0.0000", "0.0101", "0.0299"]);
}

#[test]
fn a_stream_is_stored_with_its_units_and_its_clock() {
    let folder = sitting(&stream());
    let said = pneuval(folder.path(), &["ingest", ".", "--json"]);
    assert_eq!(said.code, 0, "{}", said.err);
    let told: Value = serde_json::from_str(&said.out).unwrap();
    let table = &told[0]["record"]["files"][0]["runs"][0]["tables"][0];
    assert_eq!((&table["samples"], &table["from_s"]), (&Value::from(600), &Value::from(0.0)));
    assert_eq!(table["file"], "run.rig.parquet");
    let columns = read_parquet(&folder.path().join(".pneuval/run.rig.parquet")).unwrap();
    let names: Vec<&str> = columns.iter().map(|(name, _)| name.as_str()).collect();
    assert_eq!(names, ["time_s", "pressure_Pa", "stroke_m"]);
}

#[test]
fn what_a_cut_stream_still_holds_is_used_and_the_loss_is_told() {
    let whole = stream();
    let folder = sitting(&whole[..whole.len() - 77]);
    let said = pneuval(folder.path(), &["ingest", "."]);
    assert_eq!(said.code, 3, "{}", said.err);
    let text = format!("{}{}", said.out, said.err);
    assert!(text.contains("the file ends within the values of the segment at byte"), "{text}");
    assert!(text.contains("`rig.stroke` has 561 values of the 600 that its last chunk states"), "{text}");
}

#[test]
fn a_scale_that_is_not_known_is_refused_by_its_name() {
    let kind = [("NI_Number_Of_Scales", Prop::U32(1)), ("NI_Scale[0]_Scale_Type", Prop::Text("RTD"))];
    let index = LITTLE.index(2, 4);
    let objects = [LITTLE.object("/'rig'/'p'", &index, &[]), LITTLE.object("/'rig'/'stroke'", &index, &kind)];
    let folder = sitting(&LITTLE.segment(USUAL, &objects, &i16s(&[0; 8])));
    let said = pneuval(folder.path(), &["ingest", "."]);
    assert_eq!(said.code, 4, "{}{}", said.out, said.err);
    assert!(said.err.contains("channel `rig.stroke`: scale 0 is of the type RTD"), "{}", said.err);
    // `inspect` shows the others, and that this one is missing.
    let said = pneuval(folder.path(), &["inspect", "run.tdms"]);
    assert_eq!(said.code, 3, "{}{}", said.out, said.err);
    assert!(said.out.contains("RTD") && said.out.contains("  p "), "{}", said.out);
}

#[test]
fn streams_are_described_by_init_and_their_indexes_are_not_in_the_way() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("run.tdms"), stream()).unwrap();
    fs::write(folder.path().join("run.tdms_index"), b"TDSh").unwrap();
    let said = pneuval(folder.path(), &["init", "."]);
    assert_eq!(said.code, 0, "{}{}", said.out, said.err);
    let session = fs::read_to_string(folder.path().join("session.toml")).unwrap();
    assert!(session.contains("column = \"rig.p\"") && session.contains("file = \"run.tdms\""), "{session}");
    assert!(!session.contains("index"), "{session}");
}

#[test]
fn an_index_is_no_log_and_says_where_the_log_is() {
    let folder = sitting(&stream());
    let whole = LITTLE.metadata(&[LITTLE.object("/'rig'/'p'", &LITTLE.index(2, 50), &[])]);
    let index = [LITTLE.lead(*b"TDSh", USUAL, whole.len() as u64 + 100, whole.len() as u64), whole].concat();
    fs::write(folder.path().join("run.tdms_index"), index).unwrap();
    let said = pneuval(folder.path(), &["inspect", "run.tdms_index"]);
    assert_eq!(said.code, 4, "{}{}", said.out, said.err);
    assert!(said.err.contains("read run.tdms beside it"), "{}", said.err);
}

/// The same plateaus as a measurement file: decimal comma, a clock for each channel, a header that is wrong about its step.
fn measurement_file() -> String {
    let mut text = "LabVIEW Measurement\t\r\nWriter_Version\t2\r\nSeparator\tTab\r\nDecimal_Separator\t,\r\nMulti_Headings\tNo\r\n\
        X_Columns\tMulti\r\nTime_Pref\tAbsolute\r\nDate\t2026/11/22\r\nTime\t09:13:00,0\r\n***End_of_Header***\t\r\n\t\r\n\
        Channels\t2\t\t\r\nSamples\t600\t\t600\t\r\nDate\t2026/11/22\t\t2026/11/22\t\r\nTime\t09:13:00,5\t\t09:13:00,5\t\r\n\
        Y_Unit_Label\tkPa\t\tmm\t\r\nX_Dimension\tTime\t\tTime\t\r\nX0\t0,0\t\t0,0\t\r\nDelta_X\t0,010000\t\t0,010000\t\r\n\
        ***End_of_Header***\t\t\t\t\r\nX_Value\tp\tX_Value\tstroke\tComment\r\n"
        .to_owned();
    for i in 0..600_usize {
        let x = format!("{:.6}", i as f64 * 0.01).replace('.', ",");
        let (p, stroke) = [("0,0", "0,0"), ("20,0", "10,1"), ("40,0", "29,9")][i / 200];
        text += &[x.as_str(), p, x.as_str(), stroke].join("\t");
        text += "\r\n";
    }
    text
}

#[test]
fn a_measurement_file_is_compared_by_the_times_that_it_states() {
    let folder = sitting(&[]);
    fs::write(folder.path().join("run.lvm"), measurement_file()).unwrap();
    let session = SESSION.replace("rig.p", "p").replace("rig.stroke", "stroke").replace("run.tdms", "run.lvm");
    fs::write(folder.path().join("session.toml"), session).unwrap();
    let said = pneuval(folder.path(), &["validate", ".", "--out", "report"]);
    assert_eq!(said.code, 3, "{}", said.err);
    assert_eq!(measured(folder.path()), ["0.0000", "0.0101", "0.0299"]);
    // Both X columns are the same, so there is one clock and one table.
    let said = pneuval(folder.path(), &["ingest", ".", "--json"]);
    assert_eq!(said.code, 0, "{}", said.err);
    let told: Value = serde_json::from_str(&said.out).unwrap();
    let table = &told[0]["record"]["files"][0]["runs"][0]["tables"];
    assert_eq!((table.as_array().unwrap().len(), &table[0]["from_s"]), (1, &Value::from(0.5)));
    let said = pneuval(folder.path(), &["inspect", "run.lvm"]);
    assert_eq!(said.code, 0, "{}", said.err);
    assert!(said.out.contains("600 samples over 5.990 s, 100 Hz by X_Value"), "{}", said.out);
    let odd =
        measurement_file().replace("kPa", "furlong").replace("0,010000", "0,000001").replace("0,01\t", "0,000001\t");
    fs::write(folder.path().join("odd.lvm"), odd).unwrap();
    let said = pneuval(folder.path(), &["inspect", "odd.lvm"]);
    assert!(said.out.contains("GUESS: `furlong`, as the log says, is no unit that is known here"), "{}", said.out);
}

#[test]
fn comments_beside_rows_are_kept_and_name_no_runs() {
    let folder = tempfile::tempdir().unwrap();
    let mut said = ["start\r\n", "ok\r\n"].into_iter().cycle();
    let rows = |line: &str| {
        if line.starts_with(char::is_numeric) {
            format!("{line}\t{}", said.next().unwrap())
        } else {
            line.to_owned() + "\r\n"
        }
    };
    let text: String = measurement_file().split("\r\n").map(rows).collect();
    fs::write(folder.path().join("run.lvm"), text).unwrap();
    assert_eq!(pneuval(folder.path(), &["init", "."]).code, 0);
    let session = fs::read_to_string(folder.path().join("session.toml")).unwrap();
    assert!(!session.contains("Comment") && session.matches("[[run]]").count() == 1, "{session}");
    let said = pneuval(folder.path(), &["inspect", "run.lvm"]);
    assert!(said.out.contains("  Comment "), "{}{}", said.out, said.err);
}

#[test]
fn columns_of_several_clocks_are_named_as_inspect_names_them() {
    // The second channel begins later: its X is another.
    let text = measurement_file().replace("Time\t09:13:00,5\t\t09:13:00,5", "Time\t09:13:00,5\t\t09:13:01,5");
    let folder = sitting(&[]);
    fs::write(folder.path().join("run.lvm"), text).unwrap();
    let session = SESSION.replace("rig.p", "p").replace("rig.stroke", "stroke").replace("run.tdms", "run.lvm");
    let x = "[[channel]]\nid = \"x\"\ncolumn = \"X_Value\"\n\n[[channel]]\nid = \"x-2\"\ncolumn = \"X_Value (2)\"\n\n[[run]]";
    let (channels, _) = session.split_once("[[response]]").unwrap();
    fs::write(folder.path().join("session.toml"), channels.replace("[[run]]", x)).unwrap();
    let said = pneuval(folder.path(), &["ingest", ".", "--json"]);
    assert_eq!(said.code, 0, "{}{}", said.out, said.err);
    let told: Value = serde_json::from_str(&said.out).unwrap();
    let tables = told[0]["record"]["files"][0]["runs"][0]["tables"].as_array().unwrap();
    let starts: Vec<&Value> = tables.iter().map(|table| &table["from_s"]).collect();
    assert_eq!(starts, [0.5, 1.5]);
}
