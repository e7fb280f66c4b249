//! Writes TDMS files with every combination of options into a folder, a table of what they hold beside each, for other readers to
//! compare: `cargo run -p pneuval-ingest --example write_tdms -- FOLDER`, then `python tests/other_readers/tdms.py FOLDER`.

// A tool for those who work on the readers: a panic is its error message.
#![allow(clippy::unwrap_used, clippy::panic)]

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::num::NonZeroUsize;
use std::path::Path;

use pneuval_ingest::finding::LineMap;
use pneuval_ingest::formats::csv::Decimal;
use pneuval_ingest::formats::tdms::{Metadata, Number, Timestamp, Value, WriteOptions, write, write_index};
use pneuval_ingest::recording::{Cells, Column, Table};

const ORIGIN: Timestamp = Timestamp { seconds: 3_873_400_000, fraction: 0xC000_0000_0000_0001 };

const COUNT: f64 = 20.0 / 65_536.0;

fn numbers(rows: usize, number: impl Fn(f64) -> f64) -> Cells {
    Cells::Numbers((0..rows).map(|row| number(row as f64)).collect())
}

fn table(name: &str, rows: usize, clock: Option<usize>, columns: Vec<Column>) -> Table {
    let (name, lines) = (name.to_owned(), LineMap::default());
    Table { name, schema: None, columns, rows, lines, clock, decimal: Decimal::Point }
}

/// A rig with an even clock, one with an uneven clock and a hole, one without clock or name, an empty one, and perhaps text.
fn tables(has_text: bool) -> Vec<Table> {
    let rig = vec![
        Column::new("t", Some("s"), numbers(100, |i| 0.25 + i * 0.001)),
        Column::new("p", Some("kPa"), numbers(100, |i| (i * 0.3).sin() * 100.0)),
        Column::new("F/'tip'", Some("N"), numbers(100, |i| i / 7.0)),
        Column::new("counts", Some("V"), numbers(100, |i| (i * 0.1).cos() * 9.9)),
    ];
    let flex = vec![
        Column::new("time", Some("s"), numbers(41, |i| i * 0.01 + (i * 1e3).sin() * 1e-4)),
        Column::new("angle", Some("°"), numbers(41, |i| if (6.5..7.5).contains(&i) { f64::NAN } else { i.powi(3) })),
    ];
    let bare =
        vec![Column::new("x", None, numbers(3, |i| -i)), Column::new("y", None, numbers(3, |i| 1.0 / (i - 1.0)))];
    let none = vec![Column::new("z", None, numbers(0, |i| i))];
    let mut tables = vec![
        table("rig", 100, Some(0), rig),
        table("camera's", 41, Some(0), flex),
        table("", 3, None, bare),
        table("none", 0, None, none),
    ];
    if has_text {
        let said = ["", "größer", "a\nb", "µ", "last one"].map(str::to_owned);
        let columns = vec![
            Column::new("t", Some("s"), numbers(5, |i| i * 2.0)),
            Column::new("said", None, Cells::Text(said.into())),
        ];
        tables.push(table("notes", 5, Some(0), columns));
    }
    tables
}

fn options() -> WriteOptions {
    let key = |table: &str, column: &str| (table.to_owned(), column.to_owned());
    let of = |pairs: &[(&str, Value)]| pairs.iter().map(|(name, value)| ((*name).to_owned(), value.clone())).collect();
    WriteOptions {
        numbers: BTreeMap::from([
            (key("rig", "F/'tip'"), Number::Single),
            (key("rig", "counts"), Number::Counts { slope: COUNT, intercept: 0.01 }),
        ]),
        file: of(&[
            ("operator", Value::Text("Jörg".to_owned())),
            ("run", Value::Uint(7)),
            ("many", Value::Uint(u64::MAX)),
            ("few", Value::Int(i64::MIN)),
            ("offset", Value::Int(-3)),
            ("half", Value::Single(0.5)),
            ("gain", Value::Double(0.1)),
            ("is good", Value::Bool(true)),
            ("began", Value::Time(ORIGIN)),
        ]),
        groups: BTreeMap::from([("rig".to_owned(), of(&[("specimen", Value::Text("A-3".to_owned()))]))]),
        channels: BTreeMap::from([(key("rig", "p"), of(&[("sensor", Value::Text("MPX5100".to_owned()))]))]),
        ..WriteOptions::default()
    }
}

/// A cell, quoted.
fn cell(text: &str) -> String {
    format!("\"{}\"", text.replace('"', "\"\""))
}

/// What a file holds, a channel a line: how it is stored, its group and name, and its values.
fn held(tables: &[Table], options: &WriteOptions) -> String {
    let mut out = String::new();
    let mut line = |cells: Vec<String>| {
        writeln!(out, "{}", cells.iter().map(|text| cell(text)).collect::<Vec<_>>().join(",")).unwrap();
    };
    for (name, value) in &options.file {
        let kind = format!("{value:?}").split('(').next().unwrap_or_default().to_lowercase();
        let value = match value {
            Value::Time(at) => format!("{} {}", at.seconds, at.fraction),
            other => format!("{other}"),
        };
        line(vec!["property".to_owned(), kind, name.clone(), value]);
    }
    for table in tables {
        let group = if table.name.is_empty() { "Untitled" } else { &table.name };
        let is_even = table.name == "rig" || table.name == "notes";
        for (number, column) in table.columns.iter().enumerate() {
            let key = (table.name.clone(), column.name.clone());
            let kind = match (options.numbers.get(&key), &column.cells) {
                (_, Cells::Text(_)) => "text".to_owned(),
                _ if table.clock == Some(number) && is_even => "waveform".to_owned(),
                _ if table.clock == Some(number) && options.origin.is_some() => "instants".to_owned(),
                (Some(Number::Single), _) => "single".to_owned(),
                (Some(Number::Counts { slope, .. }), _) => format!("within {}", slope / 2.0),
                _ => "double".to_owned(),
            };
            let unit = column.unit.clone().unwrap_or_default();
            let values: Vec<String> = match &column.cells {
                Cells::Numbers(values) => values.iter().map(|value| format!("{value:.16e}")).collect(),
                Cells::Text(text) => text.clone(),
                Cells::NotKept => vec![],
            };
            line([vec![kind, group.to_owned(), column.name.clone(), unit], values].concat());
        }
    }
    out
}

fn main() {
    let folder = std::env::args().nth(1).expect("usage: write_tdms FOLDER");
    let folder = Path::new(&folder);
    std::fs::create_dir_all(folder).unwrap();
    let mut count = 0;
    for case in 0..128_usize {
        let bit = |place: usize| case >> place & 1 == 1;
        let metadata = [Metadata::Repeated, Metadata::AsBefore, Metadata::Changes, Metadata::Absent][case >> 5];
        let options = WriteOptions {
            big_endian: bit(0),
            interleaved: bit(1),
            origin: bit(2).then_some(ORIGIN),
            chunk_rows: NonZeroUsize::new(if bit(3) { 7 } else { 0 }),
            segment_chunks: NonZeroUsize::new(if bit(4) { 3 } else { 0 }),
            metadata,
            ..options()
        };
        let tables = tables(!options.interleaved && options.segment_chunks.is_none());
        let (mut bytes, mut index) = (vec![], vec![]);
        write(&mut bytes, &tables, &options).unwrap();
        write_index(&mut index, &tables, &options).unwrap();
        let name = format!(
            "{}-{}-{}-{}-{}-{metadata:?}",
            if bit(0) { "big" } else { "little" },
            if bit(1) { "interleaved" } else { "contiguous" },
            if bit(2) { "origin" } else { "relative" },
            if bit(3) { "7rows" } else { "allrows" },
            if bit(4) { "3chunks" } else { "1chunk" },
        );
        std::fs::write(folder.join(format!("{name}.tdms")), bytes).unwrap();
        std::fs::write(folder.join(format!("{name}.tdms_index")), index).unwrap();
        std::fs::write(folder.join(format!("{name}.csv")), held(&tables, &options)).unwrap();
        count += 1;
    }
    println!("{count} files in {}", folder.display());
}
