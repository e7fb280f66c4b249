//! Bags that other people's recorders wrote. They are not part of this repository: `PNEUVAL_REFERENCE_DATA` names their folder.

// In a test a panic is how a failure is told; equality of floats is asked where it must be exact.
#![allow(clippy::unwrap_used, clippy::panic, clippy::float_cmp, clippy::approx_constant)]

#[path = "common/reference.rs"]
mod reference;

use std::collections::BTreeMap;

use mcap::records::{Record, op};
use pneuval_ingest::formats::mcap::{RecordAt, read, records};
use pneuval_ingest::raw::RawFile;
use pneuval_ingest::recording::{Cells, Keep, Recording, Table};
use reference::reference;
use serde_json::{Map, Value, json};

fn bag(name: &str) -> Option<Recording> {
    let path = reference("mcap/rosbag2")?.join(name);
    let raw = RawFile::open(&path, name, u64::MAX).unwrap();
    Some(read(&raw, Keep::All).unwrap())
}

fn map<K: ToString, V: ToString>(map: &BTreeMap<K, V>) -> Value {
    Value::Object(map.iter().map(|(k, v)| (k.to_string(), Value::from(v.to_string()))).collect())
}

fn bytes(data: &[u8]) -> Value {
    data.iter().map(u8::to_string).collect()
}

/// A record as the dumps of the conformance suite have it: numbers as text, fields by name.
fn dump(record: &RecordAt) -> Option<Value> {
    let text = |fields: &[(&str, &dyn ToString)]| -> Map<String, Value> {
        fields.iter().map(|(name, value)| ((*name).to_owned(), value.to_string().into())).collect()
    };
    let (name, fields) = match record.parse() {
        Some(Record::Header(h)) => ("Header", text(&[("library", &h.library), ("profile", &h.profile)])),
        Some(Record::Footer(f)) => {
            let fields: &[(&str, &dyn ToString)] = &[
                ("summary_crc", &f.summary_crc),
                ("summary_offset_start", &f.summary_offset_start),
                ("summary_start", &f.summary_start),
            ];
            ("Footer", text(fields))
        }
        Some(Record::Schema { header, data }) => {
            let mut fields = text(&[("encoding", &header.encoding), ("id", &header.id), ("name", &header.name)]);
            fields.insert("data".to_owned(), bytes(&data));
            ("Schema", fields)
        }
        Some(Record::Channel(c)) => {
            let mut fields = text(&[
                ("id", &c.id),
                ("message_encoding", &c.message_encoding),
                ("schema_id", &c.schema_id),
                ("topic", &c.topic),
            ]);
            fields.insert("metadata".to_owned(), map(&c.metadata));
            ("Channel", fields)
        }
        Some(Record::Message { header, data }) => {
            let mut fields = text(&[
                ("channel_id", &header.channel_id),
                ("log_time", &header.log_time),
                ("publish_time", &header.publish_time),
                ("sequence", &header.sequence),
            ]);
            fields.insert("data".to_owned(), bytes(&data));
            ("Message", fields)
        }
        Some(Record::ChunkIndex(c)) => {
            let mut fields = text(&[
                ("chunk_length", &c.chunk_length),
                ("chunk_start_offset", &c.chunk_start_offset),
                ("compressed_size", &c.compressed_size),
                ("compression", &c.compression),
                ("message_end_time", &c.message_end_time),
                ("message_index_length", &c.message_index_length),
                ("message_start_time", &c.message_start_time),
                ("uncompressed_size", &c.uncompressed_size),
            ]);
            fields.insert("message_index_offsets".to_owned(), map(&c.message_index_offsets));
            ("ChunkIndex", fields)
        }
        Some(Record::AttachmentIndex(a)) => {
            let fields: &[(&str, &dyn ToString)] = &[
                ("create_time", &a.create_time),
                ("data_size", &a.data_size),
                ("length", &a.length),
                ("log_time", &a.log_time),
                ("media_type", &a.media_type),
                ("name", &a.name),
                ("offset", &a.offset),
            ];
            ("AttachmentIndex", text(fields))
        }
        Some(Record::Statistics(s)) => {
            let mut fields = text(&[
                ("attachment_count", &s.attachment_count),
                ("channel_count", &s.channel_count),
                ("chunk_count", &s.chunk_count),
                ("message_count", &s.message_count),
                ("message_end_time", &s.message_end_time),
                ("message_start_time", &s.message_start_time),
                ("metadata_count", &s.metadata_count),
                ("schema_count", &s.schema_count),
            ]);
            fields.insert("channel_message_counts".to_owned(), map(&s.channel_message_counts));
            ("Statistics", fields)
        }
        Some(Record::Metadata(m)) => {
            let mut fields = text(&[("name", &m.name)]);
            fields.insert("metadata".to_owned(), map(&m.metadata));
            ("Metadata", fields)
        }
        Some(Record::MetadataIndex(m)) => {
            ("MetadataIndex", text(&[("length", &m.length), ("name", &m.name), ("offset", &m.offset)]))
        }
        Some(Record::SummaryOffset(s)) => {
            let fields: &[(&str, &dyn ToString)] = &[
                ("group_length", &s.group_length),
                ("group_opcode", &s.group_opcode),
                ("group_start", &s.group_start),
            ];
            ("SummaryOffset", text(fields))
        }
        Some(Record::DataEnd(d)) => ("DataEnd", text(&[("data_section_crc", &d.data_section_crc)])),
        // The dumps hold what is in them instead.
        Some(Record::Chunk { .. } | Record::MessageIndex(_)) => return None,
        None if record.opcode == op::ATTACHMENT => ("Attachment", attachment(record.body)),
        other => panic!("{other:?} at {}", record.offset),
    };
    Some(json!({ "type": name, "fields": fields }))
}

/// Only small ones are held whole; their checksum is not part of the body.
fn attachment(body: &[u8]) -> Map<String, Value> {
    let number = |at: usize| u64::from_le_bytes(body[at..at + 8].try_into().unwrap());
    let text = |at: usize| {
        let length = u32::from_le_bytes(body[at..at + 4].try_into().unwrap()) as usize;
        (String::from_utf8(body[at + 4..at + 4 + length].to_vec()).unwrap(), at + 4 + length)
    };
    let (name, at) = text(16);
    let (media_type, at) = text(at);
    let data = &body[at + 8..];
    assert_eq!(number(at), data.len() as u64);
    let mut fields = Map::new();
    for (key, value) in [
        ("create_time", number(8).to_string()),
        ("log_time", number(0).to_string()),
        ("media_type", media_type),
        ("name", name),
    ] {
        fields.insert(key.to_owned(), value.into());
    }
    fields.insert("data".to_owned(), bytes(data));
    fields
}

#[test]
fn every_record_of_the_conformance_suite() {
    let Some(root) = reference("mcap/conformance") else { return };
    let mut files = 0;
    for kind in std::fs::read_dir(root).unwrap() {
        for entry in std::fs::read_dir(kind.unwrap().path()).unwrap() {
            let path = entry.unwrap().path();
            if path.extension().is_none_or(|extension| extension != "mcap") {
                continue;
            }
            files += 1;
            let name = path.display().to_string();
            let raw = RawFile::open(&path, &name, u64::MAX).unwrap();
            let mut found = vec![];
            records(&raw, &mut |record| {
                found.extend(dump(&record));
                Ok(())
            })
            .unwrap();
            let text = std::fs::read_to_string(path.with_extension("json")).unwrap();
            let expected: Value = serde_json::from_str(&text).unwrap();
            let expected = expected["records"].as_array().unwrap();
            for (found, expected) in found.iter().zip(expected) {
                let mut fields = expected["fields"].as_array().unwrap().clone();
                // Stands in the last four bytes, which pass by.
                fields.retain(|field| expected["type"] != "Attachment" || field[0] != "crc");
                let fields: Map<String, Value> =
                    fields.iter().map(|field| (field[0].as_str().unwrap().to_owned(), field[1].clone())).collect();
                assert_eq!(found, &json!({ "type": expected["type"], "fields": fields }), "{name}");
            }
            assert_eq!(found.len(), expected.len(), "{name}");
            // Their messages are three bytes in an encoding called `a`, their checksums are right.
            let error = read(&raw, Keep::All).unwrap_err().to_string();
            assert!(error.contains("expected: at least one channel") && !error.contains("checksum"), "{error}");
        }
    }
    assert_eq!(files, 107);
}

fn numbers<'t>(table: &'t Table, column: &str) -> &'t [f64] {
    table.column(column).unwrap_or_else(|| panic!("no column {column}")).cells.numbers().unwrap()
}

/// What `test_msgs` sends by default, as its definition has it.
fn default_of(field: &str) -> f64 {
    match field {
        "bool_value" => 1.0,
        "byte_value" => 50.0,
        "char_value" => 100.0,
        "float32_value" | "float64_value" => 1.125,
        "int8_value" => -50.0,
        "uint8_value" => 200.0,
        "int16_value" => -1000.0,
        "uint16_value" => 2000.0,
        "int32_value" => -30_000.0,
        "uint32_value" => 60_000.0,
        "int64_value" => -40_000_000.0,
        "uint64_value" => 50_000_000.0,
        other => panic!("{other}"),
    }
}

/// The defaults of its arrays.
fn defaults_of(field: &str) -> [f64; 3] {
    match field {
        "bool_values" => [0.0, 1.0, 0.0],
        "byte_values" | "uint8_values" => [0.0, 1.0, 255.0],
        "char_values" => [0.0, 1.0, 127.0],
        "float32_values" => [1.125, 0.0, -1.125],
        "float64_values" => [3.1415, 0.0, -3.1415],
        "int8_values" => [0.0, 127.0, -128.0],
        "int16_values" => [0.0, 32_767.0, -32_768.0],
        "uint16_values" => [0.0, 1.0, 65_535.0],
        "int32_values" => [0.0, 2_147_483_647.0, -2_147_483_648.0],
        "uint32_values" => [0.0, 1.0, 4_294_967_295.0],
        // The nearest doubles.
        "int64_values" => [0.0, 2_f64.powi(63), -(2_f64.powi(63))],
        "uint64_values" => [0.0, 1.0, 2_f64.powi(64)],
        other => panic!("{other}"),
    }
}

#[test]
fn rosbag2_cdr_test() {
    let Some(bag) = bag("cdr_test_0.mcap") else { return };
    assert_eq!(bag.findings, []);
    let [arrays, basic] = &bag.tables[..] else { panic!("{:?}", bag.tables.len()) };
    assert_eq!((arrays.name.as_str(), basic.name.as_str()), ("/array_topic", "/test_topic"));
    assert_eq!((arrays.rows, basic.rows), (4, 3));
    assert_eq!(bag.origin.as_deref(), Some("2020-04-09T04:27:36Z"));
    assert_eq!(numbers(basic, "log_time"), [0.763_032_325, 0.812_989_925, 0.863_382_628]);
    assert_eq!(basic.columns.len(), 2 + 13);
    for column in &basic.columns[2..] {
        let expected = if column.name == "int32_value" { 123.0 } else { 0.0 };
        assert_eq!(column.cells, Cells::Numbers(vec![expected; 3]), "{}", column.name);
    }
    let mut looked_at = 0;
    for column in &arrays.columns[2..] {
        let name = column.name.as_str();
        let expected = match name {
            "bool_values[0]" | "bool_values[2]" => 1.0,
            _ if name.starts_with("string_values_default[") || name.starts_with("string_values[") => {
                let Cells::Text(texts) = &column.cells else { panic!("{name}") };
                let index: usize = name[name.len() - 2..name.len() - 1].parse().unwrap();
                let default = ["", "max value", "min value"][index];
                let expected =
                    if name.contains("default") { default.to_owned() } else { format!("Complex Hello{}", index + 1) };
                assert_eq!(texts, &vec![expected; 4], "{name}");
                looked_at += 1;
                continue;
            }
            _ => match name.split_once("].") {
                Some((parent, field)) if parent.starts_with("defaults_values") => default_of(field),
                Some(_) => 0.0,
                None => match name.split_once("_default[") {
                    Some((field, index)) => defaults_of(field)[index[..1].parse::<usize>().unwrap()],
                    None => 0.0,
                },
            },
        };
        looked_at += 1;
        assert_eq!(numbers(arrays, name), [expected; 4], "{name}");
    }
    // 14 arrays of three, six messages of thirteen, as many defaults as arrays, and one number behind them.
    assert_eq!(looked_at, 14 * 3 + 6 * 13 + 14 * 3 + 1);
}

#[test]
fn rosbag2_talker() {
    let Some(bag) = bag("talker.mcap") else { return };
    assert_eq!(bag.findings, []);
    let names: Vec<_> = bag.tables.iter().map(|t| (t.name.as_str(), t.rows)).collect();
    assert_eq!(names, [("/parameter_events", 0), ("/rosout", 10), ("/topic", 10)]);
    let topic = bag.tables.iter().find(|t| t.name == "/topic").unwrap();
    let Cells::Text(words) = &topic.column("data").unwrap().cells else { panic!() };
    let expected: Vec<String> = (0..10).map(|n| format!("Hello, world! {n}")).collect();
    assert_eq!(words, &expected);
    let log = bag.tables.iter().find(|t| t.name == "/rosout").unwrap();
    assert_eq!(log.clock.map(|c| log.columns[c].name.as_str()), Some("stamp"));
    assert_eq!(numbers(log, "stamp")[..2], [0.112_130_688, 0.612_230_956]);
}

#[test]
fn rosbag2_seek_and_rewriter() {
    let (Some(seek), Some(rewriter)) = (bag("test_bag_for_seek_0.mcap"), bag("rewriter_a_0.mcap")) else { return };
    assert_eq!((&seek.findings[..], &rewriter.findings[..]), (&[][..], &[][..]));
    assert_eq!(seek.tables.len(), 1);
    assert_eq!(numbers(&seek.tables[0], "int32_value"), [1.0, 2.0, 3.0, 4.0, 5.0]);
    assert_eq!(numbers(&seek.tables[0], "log_time"), [0.0, 0.1, 0.2, 0.3, 0.4]);
    let [empty, basic] = &rewriter.tables[..] else { panic!() };
    assert_eq!((empty.rows, basic.rows, empty.columns.len()), (100, 50, 2));
    assert_eq!(numbers(basic, "uint8_value"), [100.0; 50]);
}
