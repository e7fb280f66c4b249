//! Bags: every encoding of messages, every compression, every kind of damage, and folders of split files.

// In a test a panic is how a failure is told; equality of floats is asked where it must be exact.
#![allow(clippy::unwrap_used, clippy::panic, clippy::float_cmp)]

#[path = "common/bag.rs"]
mod recorder;

use std::collections::BTreeMap;
use std::io::Cursor;

use pneuval_ingest::IngestError;
use pneuval_ingest::finding::{Finding, FindingKind, LineMap, Severity};
use pneuval_ingest::formats::csv::Decimal;
use pneuval_ingest::formats::mcap::{
    Compression, Encoding, FrameKind, Stamp, WriteOptions, definition, frames, is_mcap, read, write,
};
use pneuval_ingest::formats::{Format, Options, detect};
use pneuval_ingest::raw::RawFile;
use pneuval_ingest::recording::{Cells, Column, ColumnRef, Keep, Recording, Table};
use recorder::{COMPRESSED, IMAGE, Recorder, T0, picture};

fn bag(bytes: &[u8]) -> Recording {
    read(&RawFile::of_bytes("r.mcap", bytes), Keep::All).unwrap()
}

fn error(bytes: &[u8]) -> String {
    match read(&RawFile::of_bytes("r.mcap", bytes), Keep::All) {
        Err(error @ IngestError::Unusable { .. }) => error.to_string(),
        Err(other) => panic!("another error: {other}"),
        Ok(bag) => panic!("read: {} tables", bag.tables.len()),
    }
}

fn numbers<'t>(table: &'t Table, column: &str) -> &'t [f64] {
    table.column(column).unwrap_or_else(|| panic!("no column {column}")).cells.numbers().unwrap()
}

fn names(table: &Table) -> Vec<&str> {
    table.columns.iter().map(|c| c.name.as_str()).collect()
}

fn told(findings: &[Finding]) -> Vec<(FindingKind, Severity, usize)> {
    findings.iter().map(|f| (f.kind, f.severity, f.count)).collect()
}

fn column(name: &str, numbers: Vec<f64>) -> Column {
    Column::new(name, None, Cells::Numbers(numbers))
}

fn table(name: &str, schema: &str, columns: Vec<Column>) -> Table {
    let rows = columns[0].cells.len();
    Table {
        name: name.to_owned(),
        schema: Some(schema.to_owned()),
        columns,
        rows,
        lines: LineMap::default(),
        clock: None,
        decimal: Decimal::Point,
    }
}

/// Pressure at 100 Hz and force at 50 Hz, stamped.
fn rig(samples: u32) -> Vec<Table> {
    let seconds = |step_ms: u32, ms: u32| (0..samples).map(|i| f64::from(i * step_ms + ms) / 1e3).collect::<Vec<_>>();
    let wave = |scale: f64| (0..samples).map(|i| scale * f64::from(i).sin()).collect::<Vec<_>>();
    let pressure = vec![
        column("log_time", seconds(10, 2)),
        column("publish_time", seconds(10, 1)),
        column("header.stamp", seconds(10, 0)),
        column("fluid_pressure", wave(1e5)),
        column("variance", wave(0.5)),
    ];
    let force = vec![
        column("log_time", seconds(20, 3)),
        column("publish_time", seconds(20, 2)),
        column("header.stamp", seconds(20, 0)),
        column("wrench.force.z", wave(3.0)),
        column("wrench.torque.x", wave(0.1)),
    ];
    vec![
        table("/force", "geometry_msgs/msg/WrenchStamped", force),
        table("/pressure", "sensor_msgs/msg/FluidPressure", pressure),
    ]
}

fn written(tables: &[Table], options: &WriteOptions) -> Vec<u8> {
    let mut out = Cursor::new(vec![]);
    write(&mut out, tables, options).unwrap();
    out.into_inner()
}

fn small_chunks(compression: Compression) -> WriteOptions {
    WriteOptions { compression, chunk_bytes: Some(600), origin_s: T0 / 1_000_000_000, ..WriteOptions::default() }
}

/// One topic `/t` of `pkg/msg/T` with the given definition and messages.
fn cdr(definition: &str, messages: &[&[u8]]) -> Vec<u8> {
    let mut recorder = Recorder::plain();
    let channel = recorder.channel("/t", ("pkg/msg/T", "ros2msg", definition.as_bytes()), "cdr");
    for (index, message) in (0..).zip(messages) {
        recorder.send(channel, index * 1_000_000, message);
    }
    recorder.bytes()
}

fn assert_same(found: &Recording, tables: &[Table]) {
    assert_eq!(found.findings, []);
    for table in tables {
        let read = found.tables.iter().find(|t| t.name == table.name).unwrap();
        assert_eq!((read.rows, &read.schema), (table.rows, &table.schema));
        for column in &table.columns {
            assert_eq!(numbers(read, &column.name), column.cells.numbers().unwrap(), "{}", column.name);
        }
    }
}

#[test]
fn what_is_written_reads_back_bit_for_bit_and_the_crate_agrees() {
    let tables = rig(500);
    for compression in [Compression::Zstd, Compression::Lz4, Compression::None] {
        let options = WriteOptions { chunk_bytes: None, ..small_chunks(compression) };
        let bytes = written(&tables, &options);
        assert_eq!(bytes, written(&tables, &options), "the same tables give the same bytes");
        let found = bag(&bytes);
        assert_same(&found, &tables);
        assert_eq!(found.origin.as_deref(), Some("2023-11-14T22:13:20Z"));
        // The crate finds the same messages in the same order.
        let (mut log, mut pressure) = (vec![], vec![]);
        for message in mcap::MessageStream::new(&bytes).unwrap() {
            let message = message.unwrap();
            if message.channel.topic == "/pressure" {
                log.push((message.log_time - T0) as f64 / 1e9);
                let data = &message.data[4 + 16..][..8];
                pressure.push(f64::from_le_bytes(data.try_into().unwrap()));
            }
        }
        assert_eq!(
            (numbers(&found.tables[1], "log_time"), numbers(&found.tables[1], "fluid_pressure")),
            (&log[..], &pressure[..])
        );
    }
}

#[test]
fn units_and_clocks_are_those_of_ros() {
    let found = bag(&written(&rig(5), &small_chunks(Compression::None)));
    let [force, pressure] = &found.tables[..] else { panic!() };
    let unit = |table: &Table, name: &str| table.column(name).unwrap().unit.clone();
    assert_eq!(unit(pressure, "fluid_pressure").as_deref(), Some("Pa"));
    assert_eq!(unit(pressure, "variance"), None);
    assert_eq!(unit(force, "wrench.force.z").as_deref(), Some("N"));
    assert_eq!(unit(force, "wrench.torque.x").as_deref(), Some("N m"));
    assert_eq!(unit(force, "header.stamp").as_deref(), Some("s"));
    assert_eq!(pressure.clock.map(|c| pressure.columns[c].name.as_str()), Some("header.stamp"));
    assert_eq!(Stamp::Header.column(pressure), Some("header.stamp"));
    let dated = pressure.columns.iter().filter(|column| column.is_dated).map(|column| column.name.as_str());
    assert_eq!(dated.collect::<Vec<_>>(), ["log_time", "publish_time", "header.stamp"]);
    assert_eq!(Stamp::Log.column(pressure), Some("log_time"));
    assert_eq!(found.metadata, ["/force: frame_id ``", "/pressure: frame_id ``"]);
    let raw = written(&rig(5), &small_chunks(Compression::Zstd));
    assert!(is_mcap(&raw) && !is_mcap(b"t,p\n"));
    assert_eq!(detect(&RawFile::of_bytes("x", &raw)).unwrap(), Format::Mcap);
    let read =
        pneuval_ingest::formats::read(&RawFile::of_bytes("x", &raw), &Options::default(), Keep::Nothing).unwrap();
    assert_eq!(read.format, "MCAP");
}

#[test]
fn stamps_that_nobody_set_are_no_clock() {
    let mut tables = rig(3);
    tables[1].columns[2] = column("header.stamp", vec![-1.7e9; 3]);
    let found = bag(&written(&tables, &small_chunks(Compression::None)));
    let pressure = &found.tables[1];
    assert_eq!(pressure.clock.map(|c| pressure.columns[c].name.as_str()), Some("publish_time"));
    assert!(found.reasons.iter().any(|r| r.contains("never set")), "{:?}", found.reasons);
}

#[test]
fn only_what_is_asked_for_is_kept() {
    let tables = rig(3000);
    let bytes = written(&tables, &WriteOptions { chunk_bytes: None, ..small_chunks(Compression::Zstd) });
    let raw = RawFile::of_bytes("r.mcap", &bytes);
    let all = read(&raw, Keep::All).unwrap();
    let nothing = read(&raw, Keep::Nothing).unwrap();
    for (all, nothing) in all.tables.iter().zip(&nothing.tables) {
        for (all, nothing) in all.columns.iter().zip(&nothing.columns) {
            assert_eq!((&all.name, &all.summary), (&nothing.name, &nothing.summary));
            assert_eq!(nothing.cells, Cells::NotKept);
            assert_eq!(all.cells.len(), 3000);
        }
    }
    let asked = [ColumnRef::Name("/force.wrench.force.z".to_owned())];
    let only = read(&raw, Keep::Only(&asked)).unwrap();
    for (all, only) in all.tables.iter().zip(&only.tables) {
        assert_eq!((names(all), all.rows, all.clock), (names(only), only.rows, only.clock));
        for (all, only) in all.columns.iter().zip(&only.columns) {
            // What is asked for comes with its clock.
            let is_kept = all.cells == only.cells;
            let name = (only.name.as_str(), is_kept);
            assert!(is_kept || only.cells == Cells::NotKept, "{name:?}");
            // Times are looked at all the same.
            let is_looked_at = only.name == "wrench.force.z" || only.unit.as_deref() == Some("s");
            assert_eq!(only.summary.samples > 0, is_looked_at, "{name:?}");
        }
    }
    let kept = |table: &Table| -> Vec<String> {
        let columns = table.columns.iter().filter(|c| c.cells != Cells::NotKept);
        columns.map(|c| c.name.clone()).collect()
    };
    assert_eq!(kept(&only.tables[0]), ["header.stamp", "wrench.force.z"]);
    assert_eq!(kept(&only.tables[1]), [""; 0]);
    assert_eq!(numbers(&only.tables[0], "wrench.force.z"), numbers(&all.tables[0], "wrench.force.z"));
}

#[test]
fn texts_are_looked_at_alike_whether_they_are_kept_or_not() {
    let mut recorder = Recorder::plain();
    let json = recorder.channel("/j", ("", "", b""), "json");
    for message in [r#"{"s":"idle","n":1}"#, r#"{"s":2,"n":2}"#, r#"{"s":"run","n":"x"}"#] {
        recorder.send(json, 0, message.as_bytes());
    }
    let words = recorder.channel("/w", ("pkg/msg/T", "ros2msg", b"string w"), "cdr");
    recorder.send(words, 0, b"\0\x01\0\0\x03\0\0\0a\xff\0");
    recorder.send(words, 0, &[&b"\0\x01\0\0\x2d\x01\0\0"[..], &[b'a'; 300], b"\0"].concat());
    let bytes = recorder.bytes();
    let raw = RawFile::of_bytes("r.mcap", &bytes);
    let (all, nothing) = (read(&raw, Keep::All).unwrap(), read(&raw, Keep::Nothing).unwrap());
    let (mixed, length, encoding) = (FindingKind::NonNumericCell, FindingKind::NotExpanded, FindingKind::Encoding);
    let found = told(&all.findings);
    assert!(found.contains(&(mixed, Severity::Excluded, 2)), "{found:?}");
    assert!(found.contains(&(encoding, Severity::Note, 1)), "{found:?}");
    assert!(found.iter().any(|(kind, _, count)| (*kind, *count) == (length, 1)), "{found:?}");
    assert_eq!(all.findings, nothing.findings);
}

const EVERYTHING: &str = "int8 CONSTANT=5\nbool b\nint8 i8\nuint16 u16\nint32 i32\nuint64 u64\nfloat32 f32\nfloat64 f64\n\
string<=9 word\npkg/Inner inner\npkg/Nothing nothing\nfloat64[2] pair\nint16[] some\npkg/Inner[<=4] more\nstring[] words\nuint8 last\n\
================================================================================\nMSG: pkg/Inner\nint16 a\nfloat64 x\n\
================================================================================\nMSG: pkg/Nothing\n";

/// The same message in any byte order and alignment, with as many elements in its sequences as asked.
fn everything(big: bool, xcdr2: bool, elements: u8, scale: f64) -> Vec<u8> {
    let id = match (xcdr2, big) {
        (false, true) => 0,
        (false, false) => 1,
        (true, true) => 6,
        (true, false) => 7,
    };
    let mut body = vec![];
    let put = |body: &mut Vec<u8>, little: &[u8]| {
        let align = little.len().min(if xcdr2 { 4 } else { 8 });
        while !body.len().is_multiple_of(align) {
            body.push(0xee);
        }
        let mut bytes = little.to_vec();
        if big {
            bytes.reverse();
        }
        body.extend(bytes);
    };
    let text = |body: &mut Vec<u8>, text: &str| {
        put(body, &(u32::try_from(text.len()).unwrap() + 1).to_le_bytes());
        body.extend(text.as_bytes());
        body.push(0);
    };
    put(&mut body, &[1]);
    put(&mut body, &(-8_i8).to_le_bytes());
    put(&mut body, &16_u16.to_le_bytes());
    put(&mut body, &(-32_i32).to_le_bytes());
    put(&mut body, &(1_u64 << 60).to_le_bytes());
    put(&mut body, &0.5_f32.to_le_bytes());
    put(&mut body, &(scale * 0.1).to_le_bytes());
    text(&mut body, "wörd");
    put(&mut body, &7_i16.to_le_bytes());
    put(&mut body, &(scale * 0.7).to_le_bytes());
    // The dummy member of a message without fields.
    put(&mut body, &[0xaa]);
    put(&mut body, &1.0_f64.to_le_bytes());
    put(&mut body, &2.0_f64.to_le_bytes());
    put(&mut body, &u32::from(elements).to_le_bytes());
    for i in 0..elements {
        put(&mut body, &i16::from(i).to_le_bytes());
    }
    if xcdr2 {
        put(&mut body, &99_u32.to_le_bytes());
    }
    put(&mut body, &u32::from(elements).to_le_bytes());
    for i in 0..elements {
        put(&mut body, &i16::from(i).to_le_bytes());
        put(&mut body, &(scale * f64::from(i)).to_le_bytes());
    }
    if xcdr2 {
        put(&mut body, &99_u32.to_le_bytes());
    }
    put(&mut body, &u32::from(elements).to_le_bytes());
    for i in 0..elements {
        text(&mut body, &format!("w{i}"));
    }
    put(&mut body, &[200]);
    [&[0, id, 0, 0][..], &body].concat()
}

#[test]
fn every_kind_of_field_in_both_byte_orders_and_both_alignments() {
    for (big, xcdr2) in [(false, false), (true, false), (false, true), (true, true)] {
        let messages = [everything(big, xcdr2, 1, 1.0), everything(big, xcdr2, 0, 2.0), everything(big, xcdr2, 3, 3.0)];
        let bytes = cdr(EVERYTHING, &messages.each_ref().map(Vec::as_slice));
        let found = bag(&bytes);
        assert_eq!(found.findings, []);
        let t = &found.tables[0];
        let same = |name: &str, value: f64| assert_eq!(numbers(t, name), [value; 3], "{name}");
        same("b", 1.0);
        same("i8", -8.0);
        same("u16", 16.0);
        same("i32", -32.0);
        same("u64", 2_f64.powi(60));
        same("f32", 0.5);
        same("inner.a", 7.0);
        same("pair[1]", 2.0);
        same("last", 200.0);
        assert_eq!(numbers(t, "f64"), [1.0, 2.0, 3.0].map(|scale| scale * 0.1));
        assert_eq!(t.column("word").unwrap().cells.text().unwrap(), ["wörd"; 3]);
        let holes = |name: &str| numbers(t, name).iter().map(|v| v.is_nan()).collect::<Vec<_>>();
        assert_eq!(holes("some[0]"), [false, true, false]);
        assert_eq!((holes("some[2]"), numbers(t, "some[2]")[2]), (vec![true, true, false], 2.0));
        assert_eq!((holes("more[1].x"), numbers(t, "more[1].x")[2]), (vec![true, true, false], 3.0));
        assert_eq!(t.column("words[0]").unwrap().cells.text().unwrap(), ["w0", "", "w0"]);
        assert_eq!(t.column("words[2]").unwrap().cells.text().unwrap(), ["", "", "w2"]);
        let all = names(t);
        assert!(!all.iter().any(|n| n.contains("nothing") || n.contains("CONSTANT")), "{all:?}");
    }
}

#[test]
fn wide_characters_of_both_kinds_are_passed_over() {
    for width in [2_usize, 4] {
        let mut message = vec![0, 1, 0, 0, 3, 0, 0, 0];
        message.extend(vec![b'x'; 3 * width]);
        message.resize(4 + (message.len() - 4).next_multiple_of(4), 0);
        message.extend(5_u32.to_le_bytes());
        let found = bag(&cdr("wstring w\nuint32 n\n", &[&message]));
        assert_eq!((numbers(&found.tables[0], "n"), &found.findings[..]), (&[5.0][..], &[][..]), "{width}");
    }
}

#[test]
fn a_message_that_cannot_be_decoded_keeps_its_row_with_holes() {
    let whole = everything(false, false, 1, 1.0);
    let messages: Vec<Vec<u8>> = (0..whole.len()).map(|end| whole[..end].to_vec()).chain([whole.clone()]).collect();
    let found = bag(&cdr(EVERYTHING, &messages.iter().map(Vec::as_slice).collect::<Vec<_>>()));
    assert_eq!(told(&found.findings), [(FindingKind::UnreadMessage, Severity::Excluded, whole.len())]);
    let f = &found.findings[0];
    assert_eq!((f.spans.len(), f.spans[0].last_sample, f.channel.as_deref()), (1, whole.len() - 1, Some("/t")));
    assert!(f.text.contains("cannot be decoded (sample 0 ends before its last field;"), "{}", f.text);
    let t = &found.tables[0];
    assert_eq!(t.rows, whole.len() + 1);
    for column in &t.columns[2..] {
        match &column.cells {
            Cells::Numbers(cells) => {
                assert!(cells[..whole.len()].iter().all(|v| v.is_nan()) && !cells[whole.len()].is_nan());
            }
            Cells::Text(cells) => assert!(cells[..whole.len()].iter().all(String::is_empty)),
            Cells::NotKept => panic!(),
        }
    }
    assert!(numbers(t, "log_time").iter().all(|s| s.is_finite()));
    // Another encapsulation, and bytes that nothing explains.
    let mut other = whole.clone();
    other[1] = 3;
    let found = bag(&cdr(EVERYTHING, &[&whole, &other, &[&whole[..], &[0; 16]].concat()]));
    let kinds = [(FindingKind::UnreadMessage, Severity::Excluded, 1), (FindingKind::UnreadMessage, Severity::Note, 1)];
    assert_eq!(told(&found.findings), kinds);
}

#[test]
fn stamps_need_no_definition_in_the_file() {
    let definition = "std_msgs/Header header\nfloat64 x\n\
                      ================================================================================\n\
                      MSG: std_msgs/Header\nbuiltin_interfaces/Time stamp\nstring frame_id\n";
    let message = |second: u32, x: f64| {
        // Sequence of bytes: encapsulation, stamp, an empty text with its zero, padding to 8 bytes, the number.
        [&[0, 1, 0, 0][..], &second.to_le_bytes(), &[0; 4], &[1, 0, 0, 0, 0, 0, 0, 0], &x.to_le_bytes()].concat()
    };
    let found = bag(&cdr(definition, &[&message(5, 1.5), &message(6, 2.5)]));
    assert_eq!(found.findings, []);
    // From the first second of the recording.
    assert_eq!(found.origin.as_deref(), Some("2023-11-14T22:13:20Z"));
    assert_eq!(numbers(&found.tables[0], "header.stamp"), [5.0 - 1.7e9, 6.0 - 1.7e9]);
    assert_eq!(numbers(&found.tables[0], "x"), [1.5, 2.5]);
}

#[test]
fn topics_in_other_encodings_are_told_and_the_rest_is_read() {
    let mut recorder = Recorder::plain();
    let good = recorder.channel("/good", ("pkg/msg/T", "ros2msg", b"float64 x"), "cdr");
    let channels = [
        recorder.channel("/ros1", ("pkg/T", "ros1msg", b"float64 x"), "ros1"),
        recorder.channel("/idl", ("pkg/msg/T", "ros2idl", b"module pkg {};"), "cdr"),
        recorder.channel("/none", ("", "", b""), "cdr"),
        recorder.channel("/broken", ("pkg/msg/B", "ros2msg", b"float64 x\npkg/Missing y"), "cdr"),
        recorder.channel("/cbor", ("", "", b""), "cbor"),
    ];
    recorder.send(good, 0, &[&[0, 1, 0, 0][..], &2.5_f64.to_le_bytes()].concat());
    for channel in channels {
        recorder.send(channel, 5, b"abc");
    }
    let found = bag(&recorder.bytes());
    assert_eq!(told(&found.findings), [(FindingKind::UnreadTopic, Severity::Note, 1); 5]);
    let topics: Vec<_> = found.findings.iter().map(|f| f.channel.as_deref().unwrap()).collect();
    assert_eq!(topics, ["/broken", "/cbor", "/idl", "/none", "/ros1"]);
    assert!(found.findings[0].text.contains("`pkg/Missing`"), "{}", found.findings[0].text);
    assert_eq!(numbers(found.tables.iter().find(|t| t.name == "/good").unwrap(), "x"), [2.5]);
    assert_eq!(found.tables.iter().map(|t| t.columns.len()).collect::<Vec<_>>(), [2, 2, 3, 2, 2, 2]);

    let mut alone = Recorder::plain();
    let channel = alone.channel("/ros1", ("pkg/T", "ros1msg", b"float64 x"), "ros1");
    alone.send(channel, 0, b"abc");
    let error = error(&alone.bytes());
    assert!(error.contains("`/ros1`") && error.contains("`cdr`, `json` and `protobuf` are read"), "{error}");
}

#[test]
fn json_by_path() {
    let mut recorder = Recorder::plain();
    let channel = recorder.channel("/j", ("", "", b""), "json");
    let messages = [
        r#"{"header":{"stamp":{"sec":1700000001,"nanosec":500},"frame_id":"rig"},"p":{"v":1.5,"ok":true},"a":[1,[2,3]],"who":"x"}"#,
        r#"{"p":{"v":null,"ok":false},"extra":7,"a":[9],"log_time":3}"#,
        r#"{"p":{"v":2}"#,
        r#"{"p":{"v":"text"},"took":{"secs":1,"nsecs":500000000}}"#,
    ];
    for message in messages {
        recorder.send(channel, 0, message.as_bytes());
    }
    let found = bag(&recorder.bytes());
    let t = &found.tables[0];
    let bits = |name: &str| numbers(t, name).iter().map(|v| if v.is_nan() { -99.0 } else { *v }).collect::<Vec<_>>();
    assert_eq!(bits("header.stamp"), [1.000_000_5, -99.0, -99.0, -99.0]);
    assert_eq!(bits("p.v"), [1.5, -99.0, -99.0, -99.0]);
    assert_eq!(bits("p.ok"), [1.0, 0.0, -99.0, -99.0]);
    assert_eq!(bits("a[1][1]"), [3.0, -99.0, -99.0, -99.0]);
    assert_eq!((bits("a[0]"), bits("extra")), (vec![1.0, 9.0, -99.0, -99.0], vec![-99.0, 7.0, -99.0, -99.0]));
    assert_eq!((bits("message.log_time"), bits("log_time")), (vec![-99.0, 3.0, -99.0, -99.0], vec![0.0; 4]));
    assert_eq!(bits("took"), [-99.0, -99.0, -99.0, 1.5]);
    assert_eq!(t.column("who").unwrap().cells.text().unwrap(), ["x", "", "", ""]);
    assert_eq!(found.metadata, ["/j: frame_id `rig`"]);
    let kinds =
        [(FindingKind::UnreadMessage, Severity::Excluded, 1), (FindingKind::NonNumericCell, Severity::Excluded, 1)];
    assert_eq!(told(&found.findings), kinds);
}

#[test]
fn protobuf_by_path() {
    let source = r#"
        syntax = "proto3";
        import "google/protobuf/timestamp.proto";
        message Rig {
            google.protobuf.Timestamp timestamp = 1;
            double p = 2;
            optional float f = 3;
            repeated sint32 steps = 4;
            enum Mode { OFF = 0; ON = 1; }
            Mode mode = 5;
            map<string, double> by_name = 6;
            message Inner { bool ok = 1; bytes raw = 2; string word = 3; }
            Inner inner = 7;
            oneof either { int64 left = 8; fixed64 right = 9; }
        }"#;
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("rig.proto"), source).unwrap();
    let set = protox::Compiler::new([folder.path()])
        .unwrap()
        .include_imports(true)
        .open_file("rig.proto")
        .unwrap()
        .encode_file_descriptor_set();
    let mut recorder = Recorder::plain();
    let channel = recorder.channel("/rig", ("Rig", "protobuf", &set), "protobuf");
    // Field number and wire type, then the value, by hand.
    let mut time = vec![0x08];
    let mut seconds = 1_700_000_001_u64;
    while seconds >= 0x80 {
        time.push(u8::try_from(seconds & 0x7f).unwrap() | 0x80);
        seconds >>= 7;
    }
    time.push(u8::try_from(seconds).unwrap());
    time.extend([0x10, 0xf4, 0x03]);
    let mut message = vec![0x0a, u8::try_from(time.len()).unwrap()];
    message.extend(&time);
    message.push(0x11);
    message.extend(101.5_f64.to_le_bytes());
    message.extend([0x22, 0x02, 0x01, 0x04, 0x28, 0x01]);
    message.extend([0x32, 0x0c, 0x0a, 0x01, b'k', 0x11]);
    message.extend(4.5_f64.to_le_bytes());
    message.extend([0x3a, 0x09, 0x08, 0x01, 0x12, 0x02, 1, 2, 0x1a, 0x01, b'w', 0x40, 0x2a]);
    recorder.send(channel, 0, &message);
    recorder.send(channel, 0, &[]);
    recorder.send(channel, 0, &[0x11, 1, 2]);
    let found = bag(&recorder.bytes());
    assert_eq!(told(&found.findings), [(FindingKind::UnreadMessage, Severity::Excluded, 1)]);
    let t = &found.tables[0];
    let bits = |name: &str| numbers(t, name).iter().map(|v| if v.is_nan() { -99.0 } else { *v }).collect::<Vec<_>>();
    assert_eq!(bits("timestamp"), [1.000_000_5, -99.0, -99.0]);
    assert_eq!(t.clock.map(|c| t.columns[c].name.as_str()), Some("timestamp"));
    // A field without a presence has its default.
    assert_eq!((bits("p"), bits("mode")), (vec![101.5, 0.0, -99.0], vec![1.0, 0.0, -99.0]));
    assert_eq!((bits("steps[0]"), bits("steps[1]")), (vec![-1.0, -99.0, -99.0], vec![2.0, -99.0, -99.0]));
    assert_eq!(
        (bits("by_name[k]"), bits("inner.ok"), bits("left")),
        (vec![4.5, -99.0, -99.0], vec![1.0, -99.0, -99.0], vec![42.0, -99.0, -99.0])
    );
    assert_eq!(t.column("inner.word").unwrap().cells.text().unwrap(), ["w", "", ""]);
    assert!(t.column("f").is_none() && t.column("inner.raw").is_none() && t.column("right").is_none());
}

#[test]
fn json_and_protobuf_are_written_too() {
    let mut tables = rig(50);
    for encoding in [Encoding::Json, Encoding::Protobuf] {
        let options = WriteOptions { encoding, ..small_chunks(Compression::Zstd) };
        tables[0].columns[3] = column("wrench.force.z", [f64::NAN].into_iter().chain((1..50).map(f64::from)).collect());
        let bytes = written(&tables, &options);
        assert_eq!(bytes, written(&tables, &options));
        let found = bag(&bytes);
        assert_eq!(found.findings, []);
        for (found, table) in found.tables.iter().zip(&tables) {
            for column in &table.columns {
                let same = |(a, b): (&f64, &f64)| a.to_bits() == b.to_bits() || (a.is_nan() && b.is_nan());
                let pairs = numbers(found, &column.name).iter().zip(column.cells.numbers().unwrap());
                assert!(pairs.into_iter().all(same), "{encoding:?} {}", column.name);
            }
        }
    }
}

#[test]
fn a_definition_is_made_or_given_where_none_is_known() {
    let columns = vec![
        column("log_time", vec![0.0, 0.5]),
        column("Flex 1 (V)", vec![1.5, 2.5]),
        Column::new("note", None, Cells::Text(vec!["a".to_owned(), String::new()])),
    ];
    let mut flex = table("/flex", "rig_msgs/msg/Flex", columns);
    let made = bag(&written(&[flex.clone()], &small_chunks(Compression::Lz4)));
    assert_eq!(names(&made.tables[0]), ["log_time", "publish_time", "flex_1_v", "note"]);
    assert_eq!(numbers(&made.tables[0], "flex_1_v"), [1.5, 2.5]);
    assert_eq!(made.tables[0].column("note").unwrap().cells.text().unwrap(), ["a", ""]);
    flex.columns[1] = column("volts[0]", vec![1.0, 2.0]);
    let definitions = vec![("rig_msgs/Flex".to_owned(), "int16[] volts\nstring note".to_owned())];
    let options = WriteOptions { definitions, ..small_chunks(Compression::Lz4) };
    let given = bag(&written(&[flex.clone()], &options));
    assert_eq!(numbers(&given.tables[0], "volts[0]"), [1.0, 2.0]);
    // A hole is no integer.
    flex.columns[1] = column("volts", vec![f64::NAN, 2.0]);
    let definitions = vec![("rig_msgs/Flex".to_owned(), "int16 volts".to_owned())];
    let mut out = Cursor::new(vec![]);
    let error = write(&mut out, &[flex], &WriteOptions { definitions, ..WriteOptions::default() }).unwrap_err();
    assert!(error.to_string().contains("NaN in row 0 of `volts`"), "{error}");
}

#[test]
fn fields_carry_comments_and_a_file_carries_words() {
    let columns = vec![column("header.stamp", vec![0.25, 0.5]), column("pressure_kpa", vec![1.5, f64::NAN])];
    let rig = Table { clock: Some(0), ..table("/rig", "pneuval_msgs/msg/Monday", columns) };
    // A title that would be another definition if a comment could end.
    let hostile = "kPa\n================\nMSG: std_msgs/Header\nint32 sec";
    let definitions =
        vec![("pneuval_msgs/Monday".to_owned(), definition(&["SYNTHETIC"], &[("pressure_kpa", hostile)]))];
    let words = BTreeMap::from([("unit".to_owned(), "kPa".to_owned()), ("title".to_owned(), "Δp".to_owned())]);
    let metadata = vec![("pneuval".to_owned(), words)];
    let bytes = written(&[rig], &WriteOptions { definitions, metadata, ..small_chunks(Compression::Zstd) });
    let found = bag(&bytes);
    let told = ["pneuval: title = Δp", "pneuval: unit = kPa", "/rig: frame_id ``"].map(str::to_owned);
    assert_eq!((found.metadata, found.findings), (told.into(), vec![]));
    let read = &found.tables[0];
    assert_eq!(names(read), ["log_time", "publish_time", "header.stamp", "pressure_kpa"]);
    assert!(numbers(read, "pressure_kpa")[1].is_nan() && numbers(read, "header.stamp") == [0.25, 0.5]);
    assert!(read.columns[..3].iter().all(|column| column.is_dated) && !read.columns[3].is_dated);
}

/// Where the records of a file outside of chunks begin and end.
fn ends(bytes: &[u8]) -> Vec<(u8, usize, usize)> {
    let mut at = 8;
    let mut ends = vec![];
    while at + 9 <= bytes.len() - 8 {
        let length = usize::try_from(u64::from_le_bytes(bytes[at + 1..at + 9].try_into().unwrap())).unwrap();
        ends.push((bytes[at], at, at + 9 + length));
        at += 9 + length;
    }
    ends
}

#[test]
fn a_file_cut_anywhere_gives_its_whole_chunks_and_says_where_it_ends() {
    let tables = rig(12);
    let bytes = written(&tables, &small_chunks(Compression::Zstd));
    let whole = bag(&bytes);
    assert_eq!(whole.findings, []);
    let ends = ends(&bytes);
    assert!(ends.iter().filter(|(opcode, ..)| *opcode == 6).count() > 2);
    let mut rows_before = 0;
    for cut in 0..bytes.len() {
        let raw = RawFile::of_bytes("r.mcap", &bytes[..cut]);
        let good = ends.iter().map(|(.., end)| *end).filter(|end| *end <= cut).max().unwrap_or(8);
        let readable = ends.iter().any(|(opcode, _, end)| *opcode == 6 && *end <= cut);
        let found = match read(&raw, Keep::All) {
            Ok(found) => found,
            Err(error @ IngestError::Unusable { .. }) if !readable => {
                assert!(cut < 8 || error.to_string().contains(&format!("up to byte {good}")), "{cut}: {error}");
                continue;
            }
            Err(error) => panic!("{cut}: {error}"),
        };
        let [finding] = &found.findings[..] else { panic!("{cut}: {:?}", found.findings) };
        assert_eq!((finding.kind, finding.severity), (FindingKind::Truncated, Severity::Lost), "{cut}");
        let unread = format!("up to byte {good}, {} bytes behind that are not", cut - good);
        assert!(finding.text.contains(&unread) || finding.text.contains("closing magic"), "{cut}: {}", finding.text);
        let last = found.tables.iter().flat_map(|t| numbers(t, "log_time").iter().copied()).fold(0.0, f64::max);
        let any = found.tables.iter().any(|t| t.rows > 0);
        let last = if any { format!("was logged at {last:.3} s") } else { "no message was read".to_owned() };
        assert!(finding.text.contains(&last), "{cut}: {}", finding.text);
        let mut rows = 0;
        for table in &found.tables {
            let all = whole.tables.iter().find(|t| t.name == table.name).unwrap();
            rows += table.rows;
            for (found, all) in table.columns.iter().zip(&all.columns) {
                assert_eq!(found.cells.numbers().unwrap(), &all.cells.numbers().unwrap()[..table.rows], "{cut}");
            }
        }
        assert!(rows >= rows_before);
        rows_before = rows;
    }
    assert_eq!(rows_before, 24);
}

/// A xorshift generator: the same numbers on every machine.
fn random(state: &mut u64) -> u64 {
    *state ^= *state << 13;
    *state ^= *state >> 7;
    *state ^= *state << 17;
    *state
}

#[test]
fn a_flipped_bit_is_found_and_what_is_read_is_what_was_written() {
    let tables = rig(30);
    let mut state = 0x2545_f491_4f6c_dd1d;
    for compression in [Compression::Zstd, Compression::Lz4, Compression::None] {
        let bytes = written(&tables, &small_chunks(compression));
        let whole = bag(&bytes);
        let chunks: Vec<_> = ends(&bytes).into_iter().filter(|(opcode, ..)| *opcode == 6).collect();
        let mut in_chunks = 0;
        // Any bit: the data, the summary, both magics are all under some checksum or compared.
        for _ in 0..600 {
            let at = usize::try_from(random(&mut state) % bytes.len() as u64).unwrap();
            let mut damaged = bytes.clone();
            damaged[at] ^= 1 << (random(&mut state) % 8);
            let Ok(found) = read(&RawFile::of_bytes("r.mcap", &damaged), Keep::All) else { continue };
            assert_ne!(found.findings, [], "{compression:?}, byte {at}");
            // Outside of chunks an altered byte may look like another record; within one nothing comes through.
            if !chunks.iter().any(|(_, start, end)| (start + 9..*end).contains(&at)) {
                continue;
            }
            in_chunks += 1;
            for table in &found.tables {
                let all = whole.tables.iter().find(|t| t.name == table.name).unwrap();
                let times = numbers(all, "log_time");
                let stamps = numbers(table, "log_time");
                let places: Vec<usize> =
                    stamps.iter().map(|stamp| times.iter().position(|t| t == stamp).unwrap()).collect();
                assert!(places.is_sorted_by(|a, b| a < b), "{compression:?}, byte {at}");
                for column in &table.columns {
                    let expected = numbers(all, &column.name);
                    let found = column.cells.numbers().unwrap();
                    assert!(places.iter().zip(found).all(|(place, value)| expected[*place] == *value), "{at}");
                }
            }
        }
        assert!(in_chunks > 100, "{in_chunks}");
    }
}

#[test]
fn any_damage_is_survived() {
    let mut state = 0x9e37_79b9_7f4a_7c15;
    let everything: Vec<Vec<u8>> = (0..6).map(|n| everything(n % 2 == 0, n % 3 == 0, n, 1.0)).collect();
    let mut json = Recorder::new(mcap::WriteOptions::new().use_chunks(false).calculate_data_section_crc(false));
    let channel = json.channel("/j", ("", "", b""), "json");
    json.send(channel, 0, br#"{"a":{"b":[1,2,{"c":"d"}]},"stamp":{"sec":1,"nanosec":2}}"#);
    let loose = cdr(EVERYTHING, &everything.iter().map(Vec::as_slice).collect::<Vec<_>>());
    // Nothing vouches for these bytes, so decoders see all of the damage.
    let unchecked = {
        let mut recorder = Recorder::new(mcap::WriteOptions::new().compression(None).calculate_chunk_crcs(false));
        let channel = recorder.channel("/t", ("pkg/msg/T", "ros2msg", EVERYTHING.as_bytes()), "cdr");
        for message in &everything {
            recorder.send(channel, 0, message);
        }
        recorder.bytes()
    };
    let proto = written(&rig(3), &WriteOptions { encoding: Encoding::Protobuf, ..small_chunks(Compression::None) });
    let mut read_some = 0;
    for bytes in [json.bytes(), loose, unchecked, proto] {
        for _ in 0..700 {
            let mut damaged = bytes.clone();
            for _ in 0..=random(&mut state) % 4 {
                let at = usize::try_from(random(&mut state) % bytes.len() as u64).unwrap();
                damaged[at] ^= 1 << (random(&mut state) % 8);
            }
            if random(&mut state).is_multiple_of(4) {
                damaged.truncate(usize::try_from(random(&mut state) % bytes.len() as u64).unwrap());
            }
            read_some += usize::from(read(&RawFile::of_bytes("r.mcap", &damaged), Keep::All).is_ok());
        }
    }
    assert!(read_some > 500, "{read_some}");
}

#[test]
fn a_broken_chunk_is_left_out_with_its_place_its_messages_and_its_times() {
    let tables = rig(40);
    let mut bytes = written(&tables, &small_chunks(Compression::None));
    let chunks: Vec<_> = ends(&bytes).into_iter().filter(|(opcode, ..)| *opcode == 6).collect();
    let (_, start, end) = chunks[1];
    bytes[end - 3] ^= 1;
    let found = bag(&bytes);
    let chunk = &found.findings[0];
    assert_eq!((chunk.kind, chunk.severity), (FindingKind::CrcMismatch, Severity::Lost));
    assert!(
        chunk.text.starts_with(&format!("the chunk at byte {start} does not match its checksum")),
        "{}",
        chunk.text
    );
    assert!(chunk.text.contains(&format!("its {} messages are lost, logged from 0.0", chunk.count)), "{}", chunk.text);
    // The checksum of the whole data section says the same again; the counts of the summary do not.
    assert_eq!(told(&found.findings)[1..], [(FindingKind::CrcMismatch, Severity::Lost, 1)]);
    let rows: usize = found.tables.iter().map(|t| t.rows).sum();
    assert_eq!(rows + chunk.count, 80);
}

#[test]
fn checksums_that_are_absent_are_said_once() {
    let options =
        mcap::WriteOptions::new().calculate_chunk_crcs(false).calculate_data_section_crc(false).chunk_size(Some(64));
    let mut recorder = Recorder::new(options);
    let channel = recorder.channel("/t", ("pkg/msg/T", "ros2msg", b"uint8 x"), "cdr");
    (0..20).for_each(|n| recorder.send(channel, n, &[0, 1, 0, 0, 7]));
    let found = bag(&recorder.bytes());
    assert_eq!(found.findings, []);
    assert_eq!(found.reasons.iter().filter(|r| r.contains("without a checksum")).count(), 1, "{:?}", found.reasons);
}

#[test]
fn attachments_and_metadata_are_told_and_checked() {
    let mut recorder = Recorder::plain();
    let channel = recorder.channel("/t", ("pkg/msg/T", "ros2msg", b"uint8 x"), "cdr");
    recorder.send(channel, 0, &[0, 1, 0, 0, 7]);
    let data = vec![7; 3 << 20].into();
    let attachment =
        mcap::Attachment { log_time: 1, create_time: 1, name: "film".into(), media_type: "video/mp4".into(), data };
    recorder.writer.attach(&attachment).unwrap();
    let metadata = BTreeMap::from([("specimen".to_owned(), "A10".to_owned())]);
    recorder.writer.write_metadata(&mcap::records::Metadata { name: "rig".to_owned(), metadata }).unwrap();
    let mut bytes = recorder.bytes();
    let found = bag(&bytes);
    assert_eq!(
        (found.metadata, found.findings),
        (vec!["attachment `film` (video/mp4), 3145728 bytes".to_owned(), "rig: specimen = A10".to_owned()], vec![])
    );
    let (_, start, end) = ends(&bytes).into_iter().find(|(opcode, ..)| *opcode == 9).unwrap();
    bytes[usize::midpoint(start, end)] ^= 4;
    let found = bag(&bytes);
    assert!(found.findings[0].text.contains("the attachment `film`"), "{:?}", found.findings);
    assert_eq!(told(&found.findings), [(FindingKind::CrcMismatch, Severity::Lost, 1); 2]);
}

/// A record as it is framed.
fn framed(opcode: u8, body: &[u8]) -> Vec<u8> {
    [&[opcode][..], &(body.len() as u64).to_le_bytes(), body].concat()
}

fn text(text: &str) -> Vec<u8> {
    [&u32::try_from(text.len()).unwrap().to_le_bytes()[..], text.as_bytes()].concat()
}

fn schema(id: u16, definition: &str) -> Vec<u8> {
    framed(3, &[&id.to_le_bytes()[..], &text("pkg/msg/T"), &text("ros2msg"), &text(definition)].concat())
}

fn channel(id: u16, schema: u16, topic: &str) -> Vec<u8> {
    framed(4, &[&id.to_le_bytes()[..], &schema.to_le_bytes(), &text(topic), &text("cdr"), &[0; 4]].concat())
}

fn message(channel: u16, value: u8) -> Vec<u8> {
    let times = [T0.to_le_bytes(), T0.to_le_bytes()].concat();
    framed(5, &[&channel.to_le_bytes()[..], &[0; 4], &times, &[0, 1, 0, 0, value]].concat())
}

/// A file of these records with header, end of data and footer.
fn file(records: &[Vec<u8>]) -> Vec<u8> {
    let header = framed(1, &[0; 8]);
    let (data_end, footer) = (framed(15, &[0; 4]), framed(2, &[0; 20]));
    [mcap::MAGIC, &header, &records.concat(), &data_end, &footer, mcap::MAGIC].concat()
}

#[test]
fn what_is_defined_twice_must_be_defined_alike() {
    let (s, c) = (schema(1, "uint8 x"), channel(1, 1, "/t"));
    let alike = bag(&file(&[s.clone(), c.clone(), message(1, 1), s.clone(), c.clone(), message(1, 2)]));
    assert_eq!((numbers(&alike.tables[0], "x"), &alike.findings[..]), (&[1.0, 2.0][..], &[][..]));
    let other = bag(&file(&[s.clone(), c.clone(), message(1, 1), channel(1, 1, "/u"), message(1, 2)]));
    assert_eq!(told(&other.findings), [(FindingKind::ConflictingDefinition, Severity::Lost, 1)]);
    assert_eq!(numbers(&other.tables[0], "x"), [1.0]);
    let schemas = bag(&file(&[s.clone(), c.clone(), message(1, 1), schema(1, "int8 y"), message(1, 2)]));
    assert_eq!(told(&schemas.findings), [(FindingKind::ConflictingDefinition, Severity::Note, 1)]);
    assert_eq!(numbers(&schemas.tables[0], "x"), [1.0, 2.0]);
    // Two channels of one topic are one table if they agree, and two if they do not.
    let same = bag(&file(&[s.clone(), c.clone(), channel(2, 1, "/t"), message(1, 1), message(2, 2)]));
    assert_eq!(numbers(&same.tables[0], "x"), [1.0, 2.0]);
    let two = bag(&file(&[s, schema(2, "int8 y"), c, channel(2, 2, "/t"), message(1, 1), message(2, 255)]));
    assert_eq!(two.tables.iter().map(|t| t.name.as_str()).collect::<Vec<_>>(), ["/t", "/t#2"]);
    assert_eq!(numbers(&two.tables[1], "y"), [-1.0]);
}

#[test]
fn records_that_do_not_belong_are_told() {
    let (s, c) = (schema(1, "uint8 x"), channel(1, 1, "/t"));
    let start = |records: &[Vec<u8>], extra: Vec<u8>| file(&[records, &[extra, message(1, 9)]].concat());
    let base = [s, c];
    let orphan = bag(&start(&base, message(7, 1)));
    assert_eq!(told(&orphan.findings), [(FindingKind::BadRecord, Severity::Lost, 1)]);
    assert!(orphan.findings[0].text.contains("channel 7"), "{}", orphan.findings[0].text);
    let unknown = bag(&start(&base, framed(0x42, b"later")));
    assert_eq!(told(&unknown.findings), [(FindingKind::BadRecord, Severity::Note, 1)]);
    assert_eq!(bag(&start(&base, framed(0xc2, b"private"))).findings, []);
    for bad in [framed(5, b"short"), framed(4, &[1, 0, 1, 0, 255, 255, 255, 255]), framed(6, &[0; 12])] {
        let found = bag(&start(&base, bad));
        assert_eq!(told(&found.findings), [(FindingKind::BadRecord, Severity::Lost, 1)]);
        assert_eq!(numbers(&found.tables[0], "x"), [9.0]);
    }
    // More than there is, and zeros after a power cut.
    let long = [&[5][..], &u64::MAX.to_le_bytes(), b"..."].concat();
    let found = bag(&start(&[&base[..], &[message(1, 3)]].concat(), long));
    assert_eq!(
        (told(&found.findings), numbers(&found.tables[0], "x")),
        (vec![(FindingKind::Truncated, Severity::Lost, 1)], &[3.0][..])
    );
    let mut cut = file(&[&base[..], &[message(1, 3)]].concat());
    cut.truncate(cut.len() - 60);
    cut.resize(cut.len() + 5000, 0);
    assert_eq!(bag(&cut).findings[0].kind, FindingKind::Truncated);
    let mut trailing = file(&[&base[..], &[message(1, 3)]].concat());
    trailing.extend(b"more");
    let found = bag(&trailing);
    assert_eq!(told(&found.findings), [(FindingKind::Trailer, Severity::Note, 1)]);
    assert!(found.findings[0].text.starts_with("4 bytes follow"), "{}", found.findings[0].text);
}

#[test]
fn sizes_are_held_against_limits_before_memory_is_asked_for() {
    let (s, c) = (schema(1, "uint8 x"), channel(1, 1, "/t"));
    let chunk = |compression: &str, size: u64, data: &[u8]| {
        let head =
            [&T0.to_le_bytes()[..], &T0.to_le_bytes(), &size.to_le_bytes(), &[1, 2, 3, 4], &text(compression)].concat();
        framed(6, &[&head[..], &(data.len() as u64).to_le_bytes(), data].concat())
    };
    for (record, word) in [
        (chunk("zstd", u64::MAX, b"(\xb5/\xfd"), "at most 134217728"),
        (chunk("zstd", 1 << 26, b"not zstd"), "does not decompress"),
        (chunk("lz4", 1 << 26, b"not lz4"), "does not decompress"),
        (chunk("br", 10, b"what"), "`br`"),
        (chunk("", 10, b"what"), "holds 4 bytes where it states 10"),
    ] {
        let found = bag(&file(&[s.clone(), c.clone(), record, message(1, 5)]));
        assert_eq!(told(&found.findings), [(FindingKind::CrcMismatch, Severity::Lost, 1)]);
        assert!(found.findings[0].text.contains(word), "{}", found.findings[0].text);
        assert_eq!(numbers(&found.tables[0], "x"), [5.0]);
    }
    // Definitions that unfold without end.
    let line = "=".repeat(80);
    let mut deep = "pkg/A0 a\n".to_owned();
    for n in 0..40 {
        let fields = (0..10).map(|f| format!("pkg/A{} f{f}\n", n + 1)).collect::<Vec<_>>().concat();
        deep.extend([&line, "\nMSG: pkg/A", &n.to_string(), "\n", &fields]);
    }
    let recursive = format!("pkg/A a\n{line}\nMSG: pkg/A\npkg/A[] a\n");
    let good = [schema(9, "uint8 x"), channel(9, 9, "/good"), message(9, 1)].concat();
    for definition in [deep, recursive] {
        let found = bag(&file(&[schema(1, &definition), channel(1, 1, "/t"), message(1, 1), good.clone()]));
        assert_eq!(told(&found.findings), [(FindingKind::UnreadTopic, Severity::Note, 1)]);
    }
    // Arrays and sequences as long as a number can say.
    let huge = "float64[4000000000] a\nuint8 b\n";
    let found = bag(&file(&[schema(1, huge), channel(1, 1, "/t"), message(1, 1), good.clone()]));
    assert!(found.findings.iter().any(|f| f.kind == FindingKind::UnreadMessage));
    let sequence = [&[0, 1, 0, 0][..], &[0xff; 4]].concat();
    let nested = format!("pkg/E[] e\n{line}\nMSG: pkg/E\npkg/N[] n\n{line}\nMSG: pkg/N\nfloat64[] v\n");
    let found = bag(&cdr(&nested, &[&sequence]));
    assert_eq!(told(&found.findings), [(FindingKind::UnreadMessage, Severity::Excluded, 1)]);
}

#[test]
fn long_sequences_and_packets_do_not_become_thousands_of_columns() {
    let packet = |count: u32| {
        let bytes = vec![3; count as usize];
        let numbers: Vec<u8> = (0..300).flat_map(|n: u16| n.to_le_bytes()).collect();
        let pad = vec![0; (4 - count as usize % 4) % 4];
        [&[0, 1, 0, 0][..], &count.to_le_bytes(), &bytes, &pad, &300_u32.to_le_bytes(), &numbers].concat()
    };
    let found = bag(&cdr("uint8[] packet\nuint16[] many\n", &[&packet(4), &packet(40)]));
    let t = &found.tables[0];
    assert!(t.column("packet[0]").is_none() && t.column("many[256]").is_none());
    assert_eq!(numbers(t, "many[255]"), [255.0; 2]);
    let [finding] = &found.findings[..] else { panic!("{:?}", found.findings) };
    assert_eq!((finding.kind, finding.severity), (FindingKind::NotExpanded, Severity::Note));
    assert!(finding.text.contains("`many` with up to 300 elements; `packet` with up to 40"), "{}", finding.text);
    let small = bag(&cdr("uint8[] packet\nuint16[] many\n", &[&packet(4)]));
    assert_eq!(numbers(&small.tables[0], "packet[3]"), [3.0]);
}

#[test]
fn pictures_are_handed_out_one_by_one_and_are_no_columns() {
    let mut recorder = Recorder::plain();
    let raw_channel = recorder.channel("/raw", ("sensor_msgs/msg/Image", "ros2msg", IMAGE.as_bytes()), "cdr");
    let small = recorder.channel("/jpg", ("sensor_msgs/msg/CompressedImage", "ros2msg", COMPRESSED.as_bytes()), "cdr");
    let pixels = [2_u32.to_le_bytes(), 3_u32.to_le_bytes(), 6_u32.to_le_bytes()].concat();
    let rest =
        [&pixels[..], b"mono8\0", &[0, 0], &3_u32.to_le_bytes(), &6_u32.to_le_bytes(), &[9, 8, 7, 6, 5, 4]].concat();
    recorder.send(raw_channel, 0, &picture(1, &rest));
    recorder.send(raw_channel, 1, &picture(2, &rest[..rest.len() - 2]));
    recorder.send(raw_channel, 2, &picture(3, &rest));
    let rest = [&5_u32.to_le_bytes()[..], b"jpeg\0", &[0; 3], &2_u32.to_le_bytes(), &[0xff, 0xd8]].concat();
    recorder.send(small, 500_000_000, &picture(4, &rest));
    let bytes = recorder.bytes();
    let raw = RawFile::of_bytes("r.mcap", &bytes);

    let mut stamps = vec![];
    let count = frames(&raw, "/raw", &mut |frame| {
        let kind = FrameKind::Raw { encoding: "mono8", width: 3, height: 2, step: 3, big_endian: false };
        assert_eq!((frame.kind, frame.data), (kind, &[9, 8, 7, 6, 5, 4][..]));
        stamps.push((frame.sample, frame.stamp_s, frame.log_time_s));
        Ok(())
    });
    assert_eq!((count.unwrap(), stamps), (2, vec![(0, 1.000_000_005, 0.0), (2, 3.000_000_005, 2e-9)]));
    let mut seen = 0;
    frames(&raw, "/jpg", &mut |frame| {
        assert_eq!(
            (frame.kind, frame.data, frame.log_time_s),
            (FrameKind::Compressed { format: "jpeg" }, &[0xff, 0xd8][..], 0.5)
        );
        seen += 1;
        Ok(())
    })
    .unwrap();
    assert_eq!(seen, 1);
    let error = frames(&raw, "/row", &mut |_| Ok(())).unwrap_err().to_string();
    assert!(error.contains("did you mean `/raw`?"), "{error}");

    let found = bag(&bytes);
    let raw = found.tables.iter().find(|t| t.name == "/raw").unwrap();
    assert_eq!(names(raw)[2..], ["header.stamp", "height", "width", "encoding", "is_bigendian", "step"]);
    assert_eq!(told(&found.findings), [(FindingKind::UnreadMessage, Severity::Excluded, 1)]);
}

fn folder(files: &[(&str, &[u8])]) -> Result<Recording, IngestError> {
    let raw = RawFile::of_files("bag", files);
    assert_eq!(detect(&raw).unwrap(), Format::Mcap);
    read(&raw, Keep::All)
}

fn metadata(files: &[&str], count: usize) -> String {
    let files = files.iter().map(|file| format!("    - {file}\n")).collect::<Vec<_>>().concat();
    format!(
        "rosbag2_bagfile_information:\n  version: 6\n  storage_identifier: mcap\n  relative_file_paths:\n{files}  \
         message_count: {count}\n  topics_with_message_count:\n    - topic_metadata:\n        name: /pressure\n        \
         type: sensor_msgs/msg/FluidPressure\n      message_count: {count}\n  compression_mode: \"\"\n"
    )
}

#[test]
fn a_folder_of_split_files_is_one_recording() {
    let part = |from: f64| {
        let pressure =
            vec![column("log_time", vec![from, from + 0.5]), column("fluid_pressure", vec![from, from * 2.0])];
        written(&[table("/pressure", "sensor_msgs/msg/FluidPressure", pressure)], &small_chunks(Compression::Zstd))
    };
    let (first, second) = (part(1.0), part(2.0));
    let yaml = metadata(&["r_10.mcap", "r_9.mcap"], 4);
    // In the order of the metadata, which is not that of the names here.
    let files = [("metadata.yaml", yaml.as_bytes()), ("r_9.mcap", &second[..]), ("r_10.mcap", &first)];
    let whole = folder(&files).unwrap();
    assert_eq!(whole.findings, []);
    assert_eq!((whole.tables.len(), whole.tables[0].rows), (1, 4));
    assert_eq!(numbers(&whole.tables[0], "fluid_pressure"), [1.0, 2.0, 2.0, 4.0]);
    assert_eq!(numbers(&whole.tables[0], "log_time"), [0.0, 0.5, 1.0, 1.5]);
    // Without metadata by name, with a word about it.
    let bare = folder(&files[1..]).unwrap();
    assert!(bare.findings.is_empty() && bare.reasons.iter().any(|r| r.contains("no `metadata.yaml`")));
    // A file of the list is missing; one is cut; one is not in the list.
    let missing = folder(&files[..2]).unwrap();
    assert_eq!(told(&missing.findings), [(FindingKind::CountMismatch, Severity::Lost, 1); 2]);
    assert!(
        missing.findings[0].text.contains("`r_10.mcap`")
            && missing.findings[1].text.contains("counts 4 messages, 2 are")
    );
    let cut = folder(&[files[0], files[1], ("r_10.mcap", &first[..first.len() - 40])]).unwrap();
    assert_eq!(cut.findings[0].kind, FindingKind::Truncated);
    assert_eq!(cut.findings[0].file, "bag/r_10.mcap");
    let yaml = metadata(&["r_10.mcap"], 4);
    let more = folder(&[("metadata.yaml", yaml.as_bytes()), files[1], files[2]]).unwrap();
    assert_eq!(told(&more.findings), [(FindingKind::CountMismatch, Severity::Note, 1)]);
    assert_eq!(more.reasons.iter().filter(|reason| reason.starts_with("an MCAP file")).count(), 1);
    // More than was counted: nothing is missing.
    let yaml = metadata(&["r_10.mcap", "r_9.mcap"], 3);
    let more = folder(&[("metadata.yaml", yaml.as_bytes()), files[1], files[2]]).unwrap();
    assert_eq!(told(&more.findings), [(FindingKind::CountMismatch, Severity::Note, 1)]);
    // One of two is compressed as a file, and no count tells that its messages are missing.
    let some = folder(&[files[1], ("r_10.mcap.zstd", b"\x28\xb5\x2f\xfd")]).unwrap();
    assert_eq!(told(&some.findings), [(FindingKind::UnusableFile, Severity::Lost, 1)]);
    assert!(some.findings[0].text.contains("zstd -d"), "{}", some.findings[0].text);
    // One of two is no bag at all.
    let broken = folder(&[files[0], files[1], ("r_10.mcap", b"nothing")]).unwrap();
    assert_eq!(broken.tables[0].rows, 2);
    let kinds = [(FindingKind::UnusableFile, Severity::Lost, 1), (FindingKind::CountMismatch, Severity::Lost, 1)];
    assert_eq!(told(&broken.findings), kinds);
    assert!(!broken.findings[0].text.contains("  "), "{}", broken.findings[0].text);
}

#[test]
fn bags_in_another_storage_name_their_conversion() {
    let yaml = metadata(&["r_0.db3"], 4);
    let error =
        folder(&[("metadata.yaml", yaml.as_bytes()), ("r_0.db3", b"SQLite format 3\0")]).unwrap_err().to_string();
    assert!(error.contains("ros2 bag convert") && error.contains("storage_id: mcap"), "{error}");
    let error = folder(&[("metadata.yaml", yaml.as_bytes()), ("r_0.mcap.zstd", b"")]).unwrap_err().to_string();
    assert!(error.contains("zstd -d"), "{error}");
    let raw = RawFile::of_bytes("r.db3", b"SQLite format 3\0 and pages");
    assert!(detect(&raw).unwrap_err().to_string().contains("ros2 bag convert"));
}

#[test]
fn what_is_no_bag_is_said_so() {
    for bytes in [&b""[..], b"t,p\n1,2\n", b"\x89MCAP1\r\n"] {
        assert!(error(bytes).contains("expected: an MCAP file"));
    }
    assert!(error(&file(&[])).contains("found:    none"));
    assert!(error(mcap::MAGIC).contains("its footer is missing"));
}
