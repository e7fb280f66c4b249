//! The TDMS writer: its bytes, what segments say of themselves, and what it refuses. Other readers are asked by
//! `tests/other_readers/tdms.py`.

// In a test a panic is how a failure is told.
#![allow(clippy::unwrap_used, clippy::panic)]

use std::collections::BTreeMap;
use std::num::NonZeroUsize;

use pneuval_ingest::IngestError;
use pneuval_ingest::finding::LineMap;
use pneuval_ingest::formats::csv::Decimal;
use pneuval_ingest::formats::tdms::{
    Metadata, Number, Properties, Timestamp, Value, WriteOptions, read, write, write_index,
};
use pneuval_ingest::raw::RawFile;
use pneuval_ingest::recording::{Cells, Column, Keep, Table};

fn numbers(name: &str, unit: Option<&str>, values: &[f64]) -> Column {
    Column::new(name, unit, Cells::Numbers(values.to_vec()))
}

fn text(name: &str, cells: &[&str]) -> Column {
    Column::new(name, None, Cells::Text(cells.iter().map(|&cell| cell.to_owned()).collect()))
}

fn table(name: &str, clock: Option<usize>, columns: Vec<Column>) -> Table {
    let (name, lines, rows) = (name.to_owned(), LineMap::default(), columns.first().map_or(0, |c| c.cells.len()));
    Table { name, schema: None, columns, rows, lines, clock, decimal: Decimal::Point }
}

fn written(tables: &[Table], options: &WriteOptions) -> Vec<u8> {
    let mut out = vec![];
    write(&mut out, tables, options).unwrap();
    out
}

fn index(tables: &[Table], options: &WriteOptions) -> Vec<u8> {
    let mut out = vec![];
    write_index(&mut out, tables, options).unwrap();
    out
}

/// What a file is refused with: the place, and what was found.
fn refused(tables: &[Table], options: &WriteOptions) -> (String, String) {
    let mut out = vec![];
    let index = write_index(&mut vec![], tables, options).unwrap_err().to_string();
    match write(&mut out, tables, options).unwrap_err() {
        error @ IngestError::Malformed { .. } => {
            assert!(out.is_empty(), "nothing is written before it is checked");
            assert_eq!(error.to_string(), index);
            let IngestError::Malformed { place, found, .. } = error else { unreachable!() };
            (place.to_string(), found)
        }
        other => panic!("{other}"),
    }
}

/// A segment as its lead-in has it.
#[derive(Debug, PartialEq)]
struct Segment {
    contents: u32,
    metadata: Vec<u8>,
    data: Vec<u8>,
}

/// Walks from lead-in to lead-in; `has_data` is not so for an index.
fn segments(bytes: &[u8], tag: &[u8], has_data: bool) -> Vec<Segment> {
    let (mut at, mut all) = (0, vec![]);
    while at < bytes.len() {
        assert_eq!(&bytes[at..at + 4], tag);
        let contents = u32::from_le_bytes(bytes[at + 4..at + 8].try_into().unwrap());
        let is_big = contents & (1 << 6) != 0;
        let number = |at: usize, width: usize| {
            let bytes = bytes[at..at + width].iter().map(|byte| u64::from(*byte));
            let add = |sum: u64, byte: u64| sum << 8 | byte;
            if is_big { bytes.fold(0, add) } else { bytes.rev().fold(0, add) }
        };
        assert_eq!(number(at + 8, 4), 4713);
        let (next, raw) = (number(at + 12, 8), number(at + 20, 8));
        let (meta, end) = (at + 28, at + 28 + usize::try_from(raw).unwrap());
        let length = usize::try_from(next - raw).unwrap();
        let data = if has_data { bytes[end..end + length].to_vec() } else { vec![] };
        assert_eq!(contents & (1 << 3) != 0, length > 0, "the bit of raw data");
        all.push(Segment { contents, metadata: bytes[meta..end].to_vec(), data });
        at = if has_data { end + length } else { end };
    }
    all
}

fn whole(tables: &[Table], options: &WriteOptions) -> Vec<Segment> {
    segments(&written(tables, options), b"TDSm", true)
}

fn count(count: usize) -> Option<NonZeroUsize> {
    NonZeroUsize::new(count)
}

fn properties(pairs: &[(&str, Value)]) -> Properties {
    pairs.iter().map(|(name, value)| ((*name).to_owned(), value.clone())).collect()
}

fn has(bytes: &[u8], needle: &str) -> bool {
    bytes.windows(needle.len()).any(|window| window == needle.as_bytes())
}

/// 100 rows of a rig with an even clock.
fn rig() -> Vec<Table> {
    let time: Vec<f64> = (0..100).map(|i| f64::from(i) * 0.001).collect();
    let pressure: Vec<f64> = (0..100).map(|i| f64::from(i).sin()).collect();
    let force: Vec<f64> = (0..100).map(|i| f64::from(i) / 3.0).collect();
    let columns =
        vec![numbers("t", Some("s"), &time), numbers("p", Some("kPa"), &pressure), numbers("F", None, &force)];
    vec![table("rig", Some(0), columns)]
}

#[test]
fn the_smallest_file_byte_by_byte() {
    // A lead-in; three objects, two without data or properties; then the values.
    let bytes = written(&[table("g", None, vec![numbers("c'", Some("V"), &[1.0, -2.0])])], &WriteOptions::default());
    let meta = [
        &[3, 0, 0, 0][..],
        &[1, 0, 0, 0],
        b"/",
        &[255, 255, 255, 255, 0, 0, 0, 0],
        &[4, 0, 0, 0],
        b"/'g'",
        &[255, 255, 255, 255, 0, 0, 0, 0],
        &[10, 0, 0, 0],
        b"/'g'/'c'''",
        &[20, 0, 0, 0, 10, 0, 0, 0, 1, 0, 0, 0, 2, 0, 0, 0, 0, 0, 0, 0],
        &[1, 0, 0, 0, 11, 0, 0, 0],
        b"unit_string",
        &[0x20, 0, 0, 0, 1, 0, 0, 0],
        b"V",
    ]
    .concat();
    let length = u8::try_from(meta.len()).unwrap();
    let lead = [b"TDSm", &[0b1110, 0, 0, 0, 0x69, 0x12, 0, 0][..]].concat();
    let offsets = [length + 16, 0, 0, 0, 0, 0, 0, 0, length, 0, 0, 0, 0, 0, 0, 0];
    assert_eq!(bytes, [&lead[..], &offsets, &meta, &1.0_f64.to_le_bytes(), &(-2.0_f64).to_le_bytes()].concat());
}

#[test]
fn an_index_is_the_file_without_its_values() {
    for (interleaved, metadata) in [(false, Metadata::Repeated), (true, Metadata::Absent), (false, Metadata::Changes)] {
        let options = WriteOptions {
            interleaved,
            metadata,
            chunk_rows: count(7),
            segment_chunks: count(2),
            ..WriteOptions::default()
        };
        let (file, index) = (written(&rig(), &options), index(&rig(), &options));
        let of = |all: Vec<Segment>| all.into_iter().map(|s| (s.contents, s.metadata)).collect::<Vec<_>>();
        assert_eq!(of(segments(&file, b"TDSm", true)), of(segments(&index, b"TDSh", false)));
        assert!(index.len() < file.len());
    }
}

#[test]
fn rows_are_cut_into_chunks_and_segments_and_come_together_again() {
    let one = whole(&rig(), &WriteOptions::default());
    assert_eq!(one.len(), 1);
    // Two channels of 100 doubles: the clock is a waveform.
    assert_eq!(one[0].data.len(), 1600);
    let (p, f) = one[0].data.split_at(800);
    for metadata in [Metadata::Repeated, Metadata::AsBefore, Metadata::Changes, Metadata::Absent] {
        let options =
            WriteOptions { metadata, chunk_rows: count(7), segment_chunks: count(4), ..WriteOptions::default() };
        let many = whole(&rig(), &options);
        // 3 segments of 4 chunks with 7 rows, one of 2 chunks, one of 2 rows.
        let rows: Vec<usize> = many.iter().map(|segment| segment.data.len() / 16).collect();
        assert_eq!(rows, [28, 28, 28, 14, 2]);
        let mut joined = (vec![], vec![]);
        for segment in &many {
            for chunk in segment.data.chunks(7 * 16) {
                let (p, f) = chunk.split_at(chunk.len() / 2);
                joined.0.extend_from_slice(p);
                joined.1.extend_from_slice(f);
            }
        }
        assert_eq!((&joined.0[..], &joined.1[..]), (p, f));
        let side_by_side = WriteOptions { interleaved: true, ..options };
        let rows: Vec<u8> = whole(&rig(), &side_by_side).into_iter().flat_map(|segment| segment.data).collect();
        let expected: Vec<u8> = p.chunks(8).zip(f.chunks(8)).flat_map(|(p, f)| [p, f].concat()).collect();
        assert_eq!(rows, expected);
    }
}

#[test]
fn later_segments_say_no_more_than_is_asked() {
    const META: u32 = 1 << 1;
    const LIST: u32 = 1 << 2;
    let said = |metadata| {
        let options = WriteOptions { metadata, chunk_rows: count(40), ..WriteOptions::default() };
        whole(&rig(), &options).iter().map(|s| (s.contents & (META | LIST), s.metadata.len())).collect::<Vec<_>>()
    };
    // 40, 40 and 20 rows: the second segment is as the first, the third is not.
    let repeated = said(Metadata::Repeated);
    assert!(repeated.iter().all(|segment| *segment == repeated[0]) && repeated[0].0 == META | LIST);
    let first = repeated[0];
    // A count, and for each of two channels its path of 10 bytes, "as before" and no properties; or a raw index of 20 bytes.
    let (as_before, new) = (4 + 2 * (4 + 10 + 4 + 4), 4 + 2 * (4 + 10 + 20 + 4));
    assert_eq!(said(Metadata::AsBefore), [first, (META | LIST, as_before), (META | LIST, new)]);
    assert_eq!(said(Metadata::Changes), [first, (META, 4), (META, new)]);
    assert_eq!(said(Metadata::Absent), [first, (0, 0), (META, new)]);
}

#[test]
fn a_table_that_ends_first_leaves_the_list() {
    let short = table("short", None, vec![numbers("x", None, &[1.0; 5])]);
    let tables = [rig().remove(0), short];
    for metadata in [Metadata::Repeated, Metadata::AsBefore, Metadata::Changes, Metadata::Absent] {
        let options =
            WriteOptions { metadata, chunk_rows: count(3), segment_chunks: count(2), ..WriteOptions::default() };
        let sizes: Vec<usize> = whole(&tables, &options).iter().map(|segment| segment.data.len() / 8).collect();
        // 3 rows of three channels, then 2 of the short one beside 3; then what is left of the two others: 94 rows.
        assert_eq!(sizes[..3], [9, 8, 12]);
        assert_eq!(sizes.iter().sum::<usize>(), 205);
        let interleaved = WriteOptions { interleaved: true, ..options };
        let sizes: Vec<usize> = whole(&tables, &interleaved).iter().map(|segment| segment.data.len() / 8).collect();
        // Each group by itself: 16 segments of 6 rows and two short ones, then the short table.
        assert_eq!((sizes.len(), &sizes[16..]), (20, &[6, 2, 3, 2][..]));
    }
}

#[test]
fn the_order_of_bytes_is_turned_everywhere_but_in_the_bits() {
    let little = written(&rig(), &WriteOptions::default());
    let big = written(&rig(), &WriteOptions { big_endian: true, ..WriteOptions::default() });
    assert_eq!(little.len(), big.len());
    assert_eq!(big[4..12], [0b100_1110, 0, 0, 0, 0, 0, 0x12, 0x69]);
    let turned: Vec<u8> = big[big.len() - 1600..].chunks(8).flat_map(|value| value.iter().rev().copied()).collect();
    assert_eq!(turned, little[little.len() - 1600..]);
    // An instant: seconds stand before their fraction, which they follow else.
    let columns = vec![numbers("t", Some("s"), &[0.0, 0.5, 0.75])];
    let origin = Some(Timestamp { seconds: 0x0102, fraction: 0x0304 });
    let last = |big_endian| {
        let options = WriteOptions { origin, big_endian, ..WriteOptions::default() };
        let bytes = written(&[table("g", Some(0), columns.clone())], &options);
        bytes[bytes.len() - 16..].to_vec()
    };
    assert_eq!(last(false), [4, 3, 0, 0, 0, 0, 0, 0xC0, 2, 1, 0, 0, 0, 0, 0, 0]);
    assert_eq!(last(true), [0, 0, 0, 0, 0, 0, 1, 2, 0xC0, 0, 0, 0, 0, 0, 3, 4]);
}

#[test]
fn a_clock_is_a_waveform_if_nothing_is_lost_by_it() {
    let file = |stamps: &[f64], unit: &str, options: &WriteOptions| {
        let columns = vec![numbers("t", Some(unit), stamps), numbers("p", None, &vec![0.0; stamps.len()])];
        let bytes = written(&[table("g", Some(0), columns)], options);
        (has(&bytes, "wf_increment"), has(&bytes, "/'g'/'t'"), has(&bytes, "wf_start_time"))
    };
    let plain = WriteOptions::default();
    let dated = WriteOptions { origin: Some(Timestamp { seconds: 1, fraction: 0 }), ..WriteOptions::default() };
    let (waveform, channel) = ((true, false, false), (false, true, false));
    assert_eq!(file(&[0.0, 0.1, 0.2, 0.1 * 3.0], "s", &plain), waveform);
    assert_eq!(file(&[0.0, 0.1, 0.2, 0.1 * 3.0], "s", &dated), (true, false, true));
    assert_eq!(file(&[0.0, 0.1, 0.2, 0.300_001], "s", &plain), channel);
    assert_eq!(file(&[0.0, 0.1, 0.2, 0.300_001], "s", &dated), channel);
    assert_eq!(file(&[0.0, 0.1, f64::NAN, 0.3], "s", &plain), channel);
    assert_eq!(file(&[0.0], "s", &plain), channel);
    // A waveform counts in s.
    assert_eq!(file(&[0.0, 100.0, 200.0], "ms", &dated), channel);
    // What is asked of the clock itself needs a channel.
    let key = ("g".to_owned(), "t".to_owned());
    let asked = WriteOptions { numbers: [(key, Number::Single)].into(), ..WriteOptions::default() };
    assert_eq!(file(&[0.0, 0.1, 0.2], "s", &asked), channel);
    // A clock alone would vanish.
    let alone = written(&[table("g", Some(0), vec![numbers("t", Some("s"), &[0.0, 1.0])])], &plain);
    assert!(has(&alone, "/'g'/'t'") && !has(&alone, "wf_"));
}

#[test]
fn counts_are_quantised_and_bring_their_scaling() {
    let key = ("g".to_owned(), "c".to_owned());
    let kind = Number::Counts { slope: 0.5, intercept: 10.0 };
    let options = WriteOptions { numbers: [(key.clone(), kind)].into(), ..WriteOptions::default() };
    let file = |values: &[f64]| vec![table("g", None, vec![numbers("c", Some("V"), values)])];
    let bytes = written(&file(&[10.0, 10.6, 9.6, -16_374.0, 16_393.5]), &options);
    let counts: Vec<i16> =
        bytes[bytes.len() - 10..].chunks(2).map(|two| i16::from_le_bytes([two[0], two[1]])).collect();
    assert_eq!(counts, [0, 1, -1, i16::MIN, i16::MAX]);
    for name in ["Scale_Type", "Linear_Slope", "Linear_Y_Intercept", "Linear_Input_Source"] {
        assert!(has(&bytes, &format!("NI_Scale[0]_{name}")));
    }
    let found = |values: &[f64]| refused(&file(values), &options);
    assert_eq!(found(&[0.0, f64::NAN]), ("g: c".to_owned(), "NaN in row 1".to_owned()));
    assert_eq!(found(&[16_394.0]), ("g: c".to_owned(), "16394.0 in row 0".to_owned()));
    let flat = Number::Counts { slope: 0.0, intercept: 0.0 };
    let options = WriteOptions { numbers: [(key.clone(), flat)].into(), ..WriteOptions::default() };
    assert_eq!(refused(&file(&[0.0]), &options).1, "0.0 and 0.0");
    let options = WriteOptions { numbers: [(key, Number::Single)].into(), ..WriteOptions::default() };
    assert_eq!(refused(&file(&[0.1, -1e39]), &options).1, "-1e39 in row 1");
    // A hole is one in singles too.
    assert!(written(&file(&[f64::NAN, f64::INFINITY]), &options).ends_with(&f32::INFINITY.to_le_bytes()));
}

#[test]
fn what_the_layout_cannot_hold_is_refused() {
    let notes = || vec![table("notes", None, vec![text("said", &["a", "b"])])];
    let interleaved = WriteOptions { interleaved: true, ..WriteOptions::default() };
    let plain = WriteOptions::default();
    assert_eq!(refused(&notes(), &interleaved), ("notes: said".to_owned(), "text".to_owned()));
    let chunks = WriteOptions { segment_chunks: count(2), ..WriteOptions::default() };
    assert_eq!(refused(&notes(), &chunks), ("notes: said".to_owned(), "text".to_owned()));
    // Offsets to the ends, then the letters.
    assert!(written(&notes(), &plain).ends_with(b"\x01\0\0\0\x02\0\0\0ab"));

    let two = |name: &str, other: &str| {
        let one = table(name, None, vec![numbers("x", None, &[1.0, 2.0])]);
        vec![one, table(other, None, vec![numbers("y", None, &[1.0])])]
    };
    assert_eq!(refused(&two("g", "g"), &interleaved), ("g: y".to_owned(), "1".to_owned()));
    written(&two("g", "h"), &interleaved);
    written(&two("g", "g"), &plain);
    // The name that a table without one is given may be there already.
    assert_eq!(refused(&two("", "Untitled"), &interleaved).0, "Untitled: y");
    let twice = table("g", None, vec![numbers("x", None, &[1.0]), numbers("x", None, &[1.0])]);
    assert_eq!(refused(&[twice], &plain), ("g: x".to_owned(), "two of the path /'g'/'x'".to_owned()));

    let mut uneven = table("g", None, vec![numbers("x", None, &[1.0]), numbers("y", None, &[])]);
    assert_eq!(refused(&[uneven.clone()], &plain), ("g: y".to_owned(), "0 of them".to_owned()));
    uneven.columns[1].cells = Cells::NotKept;
    assert_eq!(refused(&[uneven], &plain).1, "cells that were not kept");

    let dated = WriteOptions { origin: Some(Timestamp { seconds: 0, fraction: 0 }), ..WriteOptions::default() };
    let holed = table("g", Some(0), vec![numbers("t", Some("s"), &[0.0, f64::NAN, 1.0])]);
    assert_eq!(refused(&[holed], &dated), ("g: t".to_owned(), "NaN in row 1".to_owned()));
}

#[test]
fn options_that_cannot_be_followed_are_refused() {
    let key = |table: &str, column: &str| (table.to_owned(), column.to_owned());
    let numbers = |table, column| WriteOptions {
        numbers: [(key(table, column), Number::Single)].into(),
        ..WriteOptions::default()
    };
    assert_eq!(refused(&rig(), &numbers("rig", "q")), ("rig: q".to_owned(), "no such".to_owned()));
    assert_eq!(refused(&rig(), &numbers("gir", "p")).0, "gir: p");
    let groups = WriteOptions { groups: [("gir".to_owned(), Properties::new())].into(), ..WriteOptions::default() };
    assert_eq!(refused(&rig(), &groups).0, "gir");
    let words = vec![table("g", None, vec![text("c", &["a"])])];
    assert_eq!(refused(&words, &numbers("g", "c")), ("g: c".to_owned(), "text".to_owned()));

    let channel = |name: &str, value: Value| {
        let channels = [(key("rig", "p"), properties(&[(name, value)]))].into();
        refused(&rig(), &WriteOptions { channels, ..WriteOptions::default() })
    };
    // The writer states these itself.
    assert_eq!(channel("unit_string", Value::Text("Pa".to_owned())), ("rig: p".to_owned(), "`unit_string`".to_owned()));
    assert_eq!(channel("wf_increment", Value::Double(1.0)).1, "`wf_increment`");
    assert_eq!(channel("wf_trigger_offset", Value::Double(f64::INFINITY)), ("rig: p".to_owned(), "inf".to_owned()));
    assert_eq!(channel("nothing", Value::Void).1, "none");
    let file = WriteOptions { file: properties(&[("nothing", Value::Void)]), ..WriteOptions::default() };
    assert_eq!(refused(&rig(), &file).0, "the file");
}

#[test]
fn files_without_values_are_files() {
    let root =
        WriteOptions { file: properties(&[("operator", Value::Text("J".to_owned()))]), ..WriteOptions::default() };
    let none = whole(&[], &root);
    assert_eq!((none.len(), none[0].contents, none[0].data.len()), (1, 0b110, 0));
    assert!(has(&none[0].metadata, "operator"));
    for interleaved in [false, true] {
        let options = WriteOptions { interleaved, ..WriteOptions::default() };
        let empty = whole(&[table("g", None, vec![numbers("x", None, &[])])], &options);
        assert_eq!((empty.len(), empty[0].contents), (1, 0b110));
        assert!(has(&empty[0].metadata, "/'g'/'x'"));
    }
}

#[test]
fn a_full_disk_is_an_error_of_writing() {
    struct Full(usize);
    impl std::io::Write for Full {
        fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
            self.0 = self.0.checked_sub(bytes.len()).ok_or_else(|| std::io::Error::other("full"))?;
            Ok(bytes.len())
        }
        fn flush(&mut self) -> std::io::Result<()> {
            Ok(())
        }
    }
    let length = written(&rig(), &WriteOptions::default()).len();
    write(&mut Full(length), &rig(), &WriteOptions::default()).unwrap();
    let error = write(&mut Full(length - 1), &rig(), &WriteOptions::default()).unwrap_err();
    assert!(matches!(error, IngestError::Write { .. }), "{error}");
}

#[test]
fn what_is_written_is_read_again_whatever_the_options() {
    let time: Vec<f64> = (0..11).map(|i| 0.25 + f64::from(i) * 0.01).collect();
    let p: Vec<f64> = (0..11).map(|i| (f64::from(i) * 0.7).sin() / 3.0).collect();
    let f: Vec<f64> = p.iter().map(|p| p * p - 1.0).collect();
    let rig = table(
        "rig",
        Some(0),
        vec![numbers("t", Some("s"), &time), numbers("p", Some("kPa"), &p), numbers("F", Some("N"), &f)],
    );
    let slow = table("it's slow", None, vec![numbers("x", None, &[1.0, f64::NAN, 3.0])]);
    let origin = Timestamp { seconds: 3_871_000_000, fraction: 0 };
    let sizes = [(None, None), (Some(3), None), (Some(2), Some(2)), (Some(1), Some(4))];
    for (chunk, chunks) in sizes.map(|(a, b)| (a.and_then(NonZeroUsize::new), b.and_then(NonZeroUsize::new))) {
        for metadata in [Metadata::Repeated, Metadata::AsBefore, Metadata::Changes, Metadata::Absent] {
            for (interleaved, big_endian) in [(false, false), (true, false), (false, true), (true, true)] {
                let options = WriteOptions {
                    origin: Some(origin),
                    chunk_rows: chunk,
                    segment_chunks: chunks,
                    interleaved,
                    big_endian,
                    metadata,
                    ..WriteOptions::default()
                };
                let bytes = written(&[rig.clone(), slow.clone()], &options);
                let read = read(&RawFile::of_bytes("w.tdms", &bytes), Keep::All).unwrap();
                assert_eq!(read.findings, [], "{options:?}");
                assert_eq!(read.origin.as_deref(), Some("2026-08-31T05:46:40Z"));
                let shape: Vec<(&str, usize)> =
                    read.tables.iter().map(|t| (t.name.as_str(), t.columns.len())).collect();
                assert_eq!(shape, [("rig", 3), ("it's slow", 1)], "{options:?}");
                let column = |table: usize, name: &str| read.tables[table].column(name).unwrap();
                let bits = |cells: &Cells| cells.numbers().unwrap().iter().map(|x| x.to_bits()).collect::<Vec<_>>();
                for (name, expected) in [("p", &p), ("F", &f)] {
                    assert_eq!(bits(&column(0, name).cells), bits(&Cells::Numbers(expected.clone())), "{options:?}");
                }
                assert_eq!(column(0, "p").unit.as_deref(), Some("kPa"));
                assert_eq!(bits(&column(1, "x").cells), bits(&slow.columns[0].cells));
                // The stamps are computed from the first one and the step: two roundings at most.
                for (read, written) in column(0, "time").cells.numbers().unwrap().iter().zip(&time) {
                    assert!((read - written).abs() <= 2.0 * f64::EPSILON, "{read} {written}");
                }
            }
        }
    }
}

#[test]
fn counts_of_a_card_come_back_as_what_they_stand_for() {
    let p = [0.0, 1.25, -2.5];
    let (slope, intercept) = (0.0025, 0.0);
    let number = BTreeMap::from([(("rig".to_owned(), "p".to_owned()), Number::Counts { slope, intercept })]);
    let options = WriteOptions { numbers: number, ..WriteOptions::default() };
    let bytes = written(&[table("rig", None, vec![numbers("p", Some("V"), &p)])], &options);
    let read = read(&RawFile::of_bytes("w.tdms", &bytes), Keep::All).unwrap();
    let read = read.tables[0].columns[0].cells.numbers().unwrap();
    assert!(read.iter().zip(p).all(|(read, p)| (read - p).abs() < 1e-12), "{read:?}");
}

#[test]
fn the_index_says_how_much_stands_in_the_file_beside_it() {
    let rig = table("rig", None, vec![numbers("p", None, &[1.0; 7]), numbers("F", None, &[1.0; 7])]);
    let options = WriteOptions { chunk_rows: NonZeroUsize::new(3), ..WriteOptions::default() };
    let error = read(&RawFile::of_bytes("w.tdms_index", &index(&[rig], &options)), Keep::All).unwrap_err().to_string();
    assert!(error.contains("2 channels with 14 values") && error.contains("read w.tdms beside it"), "{error}");
}
