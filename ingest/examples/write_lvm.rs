//! Writes measurement files of LabVIEW with every combination of options, and beside each the true values as CSV, for other readers to
//! compare: `cargo run -p pneuval-ingest --example write_lvm -- FOLDER`.

// A tool for those who work on the readers: a panic is its error message.
#![allow(clippy::unwrap_used, clippy::panic)]

use std::path::Path;

use pneuval_ingest::finding::LineMap;
use pneuval_ingest::formats::csv::{self, Decimal};
use pneuval_ingest::formats::lvm::{WriteOptions, XColumns, write};
use pneuval_ingest::recording::{Cells, Column, Table};

const ROWS: usize = 25;

fn table(x: Vec<f64>, names: &[&str]) -> Table {
    let rows = x.len();
    let mut columns = vec![Column::new("X_Value", Some("s"), Cells::Numbers(x))];
    for (index, name) in names.iter().enumerate() {
        let value = |row: usize| {
            if row == 4 {
                f64::NAN
            } else {
                ((row + 7 * index) as f64).sin() * 10.0_f64.powi(3 - 4 * i32::try_from(index).unwrap())
            }
        };
        columns.push(Column::new(name, Some("kPa"), Cells::Numbers((0..rows).map(value).collect())));
    }
    let lines = LineMap::default();
    Table { name: String::new(), schema: None, columns, rows, lines, clock: Some(0), decimal: Decimal::Point }
}

fn main() {
    let folder = std::env::args().nth(1).expect("usage: write_lvm FOLDER");
    std::fs::create_dir_all(&folder).unwrap();
    let even: Vec<f64> = (0..ROWS).map(|row| row as f64 / 4.0).collect();
    let uneven: Vec<f64> = (0..ROWS).map(|row| row as f64 / 4.0 + f64::from(u8::from(row % 3 == 0)) / 7.0).collect();
    for x_columns in [XColumns::No, XColumns::One, XColumns::Multi] {
        for (parting, separator, decimal) in [
            ("tab-point", b'\t', Decimal::Point),
            ("tab-comma", b'\t', Decimal::Comma),
            ("comma-point", b',', Decimal::Point),
            ("semicolon-comma", b';', Decimal::Comma),
        ] {
            for has_headers in [true, false] {
                for segment_rows in [None, Some(10)] {
                    for (dated, origin) in [("dated", Some("2026-11-22T23:59:58".to_owned())), ("undated", None)] {
                        let x = if x_columns == XColumns::No { &even } else { &uneven };
                        let mut tables = vec![table(x.clone(), &["a", "b [2]"])];
                        let mut said = vec![String::new(); ROWS];
                        "valve open".clone_into(&mut said[3]);
                        tables[0].columns.push(Column::new("Comment", None, Cells::Text(said)));
                        if x_columns == XColumns::Multi {
                            tables.push(table(even[..15].to_vec(), &["c"]));
                        }
                        let headers = if has_headers { "headers" } else { "header" };
                        let rows = segment_rows.map_or("all".to_owned(), |rows| rows.to_string());
                        let name = format!("{x_columns:?}_{parting}_{headers}_{rows}_{dated}").to_lowercase();
                        let options = WriteOptions {
                            separator,
                            decimal,
                            x_columns,
                            has_headers,
                            segment_rows,
                            origin,
                            ..WriteOptions::default()
                        };
                        let mut bytes = Vec::new();
                        write(&mut bytes, &tables, &options).unwrap();
                        std::fs::write(Path::new(&folder).join(format!("{name}.lvm")), bytes).unwrap();
                        let truth: Vec<Column> = tables.into_iter().flat_map(|table| table.columns).collect();
                        let plain = csv::WriteOptions {
                            delimiter: b',',
                            decimal: Decimal::Point,
                            names: true,
                            units: false,
                            empty_holes: false,
                        };
                        std::fs::write(Path::new(&folder).join(format!("{name}.csv")), csv::write(&truth, plain))
                            .unwrap();
                    }
                }
            }
        }
    }
}
