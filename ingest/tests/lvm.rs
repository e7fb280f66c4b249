//! Measurement files of LabVIEW: what a rig's computer writes, what people and transfers do to it, and what is said of it.

// In a test a panic is how a failure is told; equality of floats is asked where it must be exact.
#![allow(clippy::unwrap_used, clippy::panic, clippy::float_cmp)]

use std::fmt::Write as _;

use pneuval_ingest::finding::{Finding, FindingKind, LineMap, Severity};
use pneuval_ingest::formats::csv::Decimal;
use pneuval_ingest::formats::lvm::{WriteOptions, XColumns, write};
use pneuval_ingest::formats::{self, Format, Options, lvm};
use pneuval_ingest::raw::RawFile;
use pneuval_ingest::recording::{Cells, Column, ColumnRef, Keep, Recording, Table};

const HEAD: &str = "LabVIEW Measurement\t\nWriter_Version\t2\nReader_Version\t2\nSeparator\tTab\nDecimal_Separator\t.\n\
    Multi_Headings\tYes\nX_Columns\tOne\nTime_Pref\tRelative\nOperator\tA. B.\nDate\t2026/11/22\nTime\t09:13:00.25\n\
    ***End_of_Header***\t\n\t\n";

const SEGMENT: &str = "Channels\t2\t\t\nSamples\t3\t3\t\nDate\t2026/11/22\t2026/11/22\t\n\
    Time\t09:13:00.5\t09:13:00.5\t\nY_Unit_Label\tkPa\tN\t\nX_Dimension\tTime\tTime\t\nX0\t0.0E+0\t0.0E+0\t\n\
    Delta_X\t0.1\t0.1\t\n***End_of_Header***\t\t\t\nX_Value\tp\tF\tComment\n";

const ROWS: &str = "0.0\t1.5\t-2\n0.1\t2.5\t-3\n0.2\t3.5\t-4\n";

fn whole() -> String {
    format!("{HEAD}{SEGMENT}{ROWS}")
}

fn read_bytes(bytes: &[u8]) -> Recording {
    let raw = RawFile::of_bytes("r.lvm", bytes);
    let recording = formats::read(&raw, &Options::default(), Keep::All).unwrap();
    assert_eq!(recording.format, "LabVIEW measurement file");
    let mut names: Vec<&str> = recording.tables.iter().flat_map(|t| &t.columns).map(|c| c.name.as_str()).collect();
    let all = names.len();
    names.sort_unstable();
    names.dedup();
    assert_eq!(names.len(), all, "names are those of one column each");
    for table in &recording.tables {
        assert_eq!((table.name.as_str(), table.lines.rows()), ("", table.rows));
        assert!(table.columns.iter().all(|column| column.cells.len() == table.rows));
    }
    recording
}

fn read(text: &str) -> Recording {
    read_bytes(text.as_bytes())
}

fn error(text: &str) -> String {
    let options = Options { format: Some(Format::Lvm), ..Options::default() };
    formats::read(&RawFile::of_bytes("r.lvm", text.as_bytes()), &options, Keep::All).unwrap_err().to_string()
}

fn numbers<'r>(recording: &'r Recording, name: &str) -> &'r [f64] {
    let column = recording.tables.iter().find_map(|table| table.column(name));
    column.unwrap_or_else(|| panic!("no {name}")).cells.numbers().unwrap()
}

fn words<'r>(recording: &'r Recording, name: &str) -> &'r [String] {
    recording.tables.iter().find_map(|table| table.column(name)).unwrap().cells.text().unwrap()
}

/// Kind, severity and count of every finding.
fn kinds(recording: &Recording) -> Vec<(FindingKind, Severity, usize)> {
    recording.findings.iter().map(|f| (f.kind, f.severity, f.count)).collect()
}

fn finding(recording: &Recording, kind: FindingKind) -> &Finding {
    let found = recording.findings.iter().find(|finding| finding.kind == kind);
    found.unwrap_or_else(|| panic!("no {kind:?} in {:?}", recording.findings))
}

fn has_reason(recording: &Recording, part: &str) {
    assert!(recording.reasons.iter().any(|reason| reason.contains(part)), "{part}: {:?}", recording.reasons);
}

#[test]
fn one_column_of_x() {
    let recording = read(&whole());
    assert_eq!(recording.findings, []);
    assert_eq!(recording.origin.as_deref(), Some("2026-11-22T09:13:00"));
    assert_eq!((recording.tables.len(), recording.tables[0].clock), (1, Some(0)));
    assert_eq!(numbers(&recording, "X_Value"), [0.5, 0.6, 0.7]);
    let dated: Vec<bool> = recording.tables[0].columns.iter().map(|c| c.is_dated).collect();
    assert_eq!(dated, [true, false, false]);
    assert_eq!((numbers(&recording, "p"), numbers(&recording, "F")), (&[1.5, 2.5, 3.5][..], &[-2.0, -3.0, -4.0][..]));
    let units: Vec<_> = recording.tables[0].columns.iter().map(|c| c.unit.as_deref()).collect();
    assert_eq!(units, [Some("s"), Some("kPa"), Some("N")]);
    assert_eq!(recording.tables[0].lines.line_of(0), 24);
    assert_eq!(recording.metadata[7..10], ["Operator: A. B.", "Date: 2026/11/22", "Time: 09:13:00.25"]);
    assert_eq!(recording.metadata[11], "Samples: 3; 3");
}

#[test]
fn line_ends_encodings_and_separators_change_nothing() {
    let plain = read(&whole());
    let table = |recording: &Recording| recording.tables[0].columns.clone();
    for ends in ["\r\n", "\r\r\n", "\r"] {
        let recording = read(&whole().replace('\n', ends));
        assert_eq!((table(&recording), recording.findings.len()), (table(&plain), 0), "{ends:?}");
    }
    for low_first in [true, false] {
        for mark in ["\u{feff}", ""] {
            let units = format!("{mark}{}", whole());
            let bytes: Vec<u8> = units
                .encode_utf16()
                .flat_map(|unit| if low_first { unit.to_le_bytes() } else { unit.to_be_bytes() })
                .collect();
            assert_eq!(table(&read_bytes(&bytes)), table(&plain));
        }
    }
    assert_eq!(table(&read(&format!("\u{feff}{}", whole()))), table(&plain));
    for (separator, word) in [(",", "Comma"), (";", ";"), (";", "Semicolon"), ("|", "|"), ("&", "&"), (",", ",")] {
        let text = whole().replace('\t', separator).replace("Tab", word);
        let recording = read(&text);
        assert_eq!((table(&recording), recording.findings.len()), (table(&plain), 0), "{word}");
        // Not stated, the bytes tell it.
        let line = format!("Separator{separator}{word}\n");
        let recording = read(&text.replace(&line, ""));
        assert_eq!((table(&recording), recording.findings.len()), (table(&plain), 0), "{word}");
        has_reason(&recording, "`Separator` is not stated");
    }
    // Stated otherwise than it is.
    let recording = read(&whole().replace("Separator\tTab", "Separator\tComma"));
    assert_eq!(table(&recording), table(&plain));
    has_reason(&recording, "cells are parted by tabs, as behind `X_Value`; `Separator` states commas");
    // A title that is missing.
    let recording = read(&whole().replace("LabVIEW Measurement\t\n", ""));
    assert_eq!(table(&recording), table(&plain));
}

#[test]
fn the_decimal_comma_is_read_stated_or_not() {
    let comma = |text: &str| text.replace('.', ",").replace("A, B,", "A. B.");
    let plain = read(&whole()).tables[0].columns.clone();
    let text = comma(&whole());
    assert_eq!(read(&text).tables[0].columns, plain);
    let recording = read(&text.replace("Decimal_Separator\t,\n", ""));
    assert_eq!((&recording.tables[0].columns, recording.tables[0].decimal), (&plain, Decimal::Comma));
    has_reason(&recording, "Decimal_Separator is not stated: by the bytes it is the comma");
    assert_eq!(recording.origin.as_deref(), Some("2026-11-22T09:13:00"));
    // Stated as what it is not.
    let recording = read(&text.replace("Decimal_Separator\t,", "Decimal_Separator\t."));
    assert_eq!(recording.tables[0].columns, plain);
    assert_eq!(kinds(&recording), [(FindingKind::HeaderMismatch, Severity::Note, 1)]);
    // Where commas part the cells there is no decimal comma.
    let recording = read(&whole().replace('\t', ",").replace("Decimal_Separator,.", "Decimal_Separator,,"));
    assert_eq!(recording.tables[0].columns, plain);
}

#[test]
fn latin_1_units_are_read_and_told() {
    let mut bytes = whole().replace("kPa", "°C").into_bytes();
    let at = bytes.iter().position(|b| *b == 0xc2).unwrap();
    bytes.remove(at);
    let recording = read_bytes(&bytes);
    assert_eq!(recording.tables[0].column("p").unwrap().unit.as_deref(), Some("°C"));
    assert_eq!(kinds(&recording), [(FindingKind::Encoding, Severity::Note, 1)]);
    assert!(recording.findings[0].text.contains("line 18"), "{}", recording.findings[0].text);
}

const NO: &str = "0\t1.5\t-2\n";

#[test]
fn without_x_it_is_counted_from_x0_and_delta_x() {
    let text = whole().replace("X_Columns\tOne", "X_Columns\tNo").replace("\n0.0\t1", "\n\t1");
    let text = text.replace("\n0.1\t2", "\n\t2").replace("\n0.2\t3", "\n\t3").replace("X0\t0.0E+0\t0.0E+0", "X0\t2\t2");
    let recording = read(&text);
    assert_eq!((recording.tables.len(), recording.findings.len()), (1, 0));
    assert_eq!(numbers(&recording, "X_Value"), [2.5, 0.5 + (2.0 + 0.1), 0.5 + (2.0 + 0.2)]);
    assert_eq!(numbers(&recording, "F"), [-2.0, -3.0, -4.0]);
    // Not stated, the empty cells tell it.
    let silent = read(&text.replace("X_Columns\tNo\n", ""));
    assert_eq!(silent.tables[0].columns, recording.tables[0].columns);
    has_reason(&silent, "X_Columns is not stated: by names and rows it is No");
    // Stated as what it is not.
    has_reason(&read(&text.replace("X_Columns\tNo", "X_Columns\tOne")), "X_Columns is One, by names and rows it is No");
    let given = read(&whole().replace("X_Columns\tOne", "X_Columns\tNo"));
    assert_eq!(numbers(&given, "X_Value"), [0.5, 0.6, 0.7]);
    has_reason(&given, "X_Columns is No, by names and rows it is One");
    // Rows that begin with the first channel.
    let shifted = read(&text.replace("\n\t1", "\n1").replace("\n\t2", "\n2").replace("\n\t3", "\n3"));
    assert_eq!(shifted.tables[0].columns, recording.tables[0].columns);
    // Nothing to count with.
    let counted = read(&text.replace("Delta_X\t0.1\t0.1\t\n", ""));
    assert_eq!((numbers(&counted, "X_Value"), counted.tables[0].clock), (&[2.0, 3.0, 4.0][..], None));
    has_reason(&counted, "X counts the rows");
    has_reason(&read(&text.replace("X0\t2\t2\t\n", "")), "X0 is not stated");
}

#[test]
fn channels_on_other_clocks_have_tables_of_their_own() {
    let no = format!("{HEAD}{SEGMENT}\t1\t-1\n\t2\t-2\n\t3\t-3\n").replace("X_Columns\tOne", "X_Columns\tNo");
    for (from, to, x, other) in [
        ("Delta_X\t0.1\t0.1", "Delta_X\t0.1\t0.2", [0.5, 0.6, 0.7], [0.5, 0.7, 0.9]),
        ("X0\t0.0E+0\t0.0E+0", "X0\t0\t1", [0.5, 0.6, 0.7], [1.5, 1.6, 1.7]),
        ("Time\t09:13:00.5\t09:13:00.5", "Time\t09:13:00.5\t09:13:04", [0.5, 0.6, 0.7], [4.0, 4.1, 4.2]),
        ("Time\t09:13:00.5\t09:13:00.5", "Time\t09:13:04\t09:13:00.5", [4.0, 4.1, 4.2], [0.5, 0.6, 0.7]),
    ] {
        let recording = read(&no.replace(from, to));
        assert_eq!((recording.tables.len(), recording.findings.len()), (2, 0), "{to}");
        let near = |name, expected: [f64; 3]| {
            let stamps = numbers(&recording, name);
            assert!(stamps.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-12), "{to}: {stamps:?}");
        };
        near("X_Value", x);
        near("X_Value (2)", other);
        assert_eq!(
            (&recording.tables[0].columns[1].name, &recording.tables[1].columns[1].name[..]),
            (&"p".to_owned(), "F")
        );
        assert_eq!((recording.tables[0].clock, recording.tables[1].clock), (Some(0), Some(0)));
    }
    // One column of X, but channels that began apart.
    let text = whole().replace("Time\t09:13:00.5\t09:13:00.5", "Time\t09:13:00.5\t09:13:01.5");
    assert_eq!(numbers(&read(&text), "X_Value (2)"), [1.5, 1.6, 1.7]);
}

fn multi(rows: &str) -> String {
    let segment = "Channels\t3\t\t\t\t\t\nSamples\t3\t\t3\t\t2\t\nDate\t2026/11/22\t\t2026/11/22\t\t2026/11/22\t\n\
        Time\t09:13:00\t\t09:13:00\t\t09:13:00\t\nY_Unit_Label\tkPa\t\tN\t\t\t\nX_Dimension\tTime\t\tTime\t\tTime\t\n\
        X0\t0\t\t0\t\t0\t\nDelta_X\t0.1\t\t0.1\t\t0.2\t\n***End_of_Header***\t\t\t\t\t\t\n\
        X_Value\ta\tX_Value\tb\tX_Value\tc\tComment\n";
    format!("{}{segment}{rows}", HEAD.replace("X_Columns\tOne", "X_Columns\tMulti"))
}

#[test]
fn channels_with_an_x_each_share_a_table_where_every_x_is_the_same() {
    let text = multi("0\t1\t0\t10\t0\t100\n0.1\t2\t0.1\t20\t0.2\t200\n0.2\t3\t0.2\t30\t\t\n");
    for text in [&text, &text.replace("X_Columns\tMulti\n", ""), &text.replace("\t0.2\t30\t\t\n", "\t0.2\t30\n")] {
        let recording = read(text);
        assert_eq!(recording.tables.iter().map(|t| (t.rows, t.columns.len())).collect::<Vec<_>>(), [(3, 3), (2, 2)]);
        assert_eq!(
            (numbers(&recording, "X_Value"), numbers(&recording, "b")),
            (&[0.0, 0.1, 0.2][..], &[10.0, 20.0, 30.0][..])
        );
        assert_eq!(
            (numbers(&recording, "X_Value (2)"), numbers(&recording, "c")),
            (&[0.0, 0.2][..], &[100.0, 200.0][..])
        );
        assert_eq!(recording.tables[0].column("b").unwrap().unit.as_deref(), Some("N"));
        assert_eq!(kinds(&recording), [(FindingKind::EmptyCell, Severity::Note, 1)]);
        assert!(recording.findings[0].text.starts_with("1 rows at the end of segments hold nothing"));
    }
    // A hole within stays where it is, and parts the channels: their stamps differ there.
    let recording = read(&multi("0\t1\t0\t10\t0\t100\n0.1\t2\t\t\t0.1\t200\n0.2\t3\t0.2\t30\t0.2\t300\n"));
    assert_eq!(recording.tables.iter().map(|t| t.rows).collect::<Vec<_>>(), [3, 3]);
    let b = numbers(&recording, "b");
    assert!(b[1].is_nan() && b[2] == 30.0 && numbers(&recording, "X_Value (2)")[1].is_nan());
    assert_eq!(finding(&recording, FindingKind::CountMismatch).count, 1, "three samples of `c`, two stated");
    // A value that is missing where there is an X does not.
    let recording = read(&multi("0\t1\t0\t10\t0\t100\n0.1\t2\t0.1\t\t0.1\t200\n0.2\t3\t0.2\t30\t\t\n"));
    assert_eq!(recording.tables[0].columns.len(), 3);
    assert!(numbers(&recording, "b")[1].is_nan());
    assert_eq!(finding(&recording, FindingKind::EmptyCell).spans.len(), 1);
    // In a row at the end of the file, what stands before its last cell is not cut.
    let recording = read(&multi("0\t1\t0\t10\t0\t100\n0.1\t2\t\t\t0.1\t200"));
    assert_eq!(recording.tables.iter().map(|t| t.rows).collect::<Vec<_>>(), [2, 1]);
    // Without names of their own.
    let unnamed = text.replace("X_Value\ta\tX_Value\tb\tX_Value\tc", "X_Value\ta\t\tb\t\tc");
    assert_eq!(read(&unnamed).tables.len(), 2);
}

#[test]
fn many_channels_that_part_late_keep_what_they_had() {
    let mut text = HEAD.replace("X_Columns\tOne", "X_Columns\tMulti");
    text.push_str("Channels\t40\n***End_of_Header***\n");
    text.push_str(&(0..40).map(|i| format!("X_Value\tc{i}")).collect::<Vec<_>>().join("\t"));
    text.push('\n');
    for row in 0..300 {
        // Channels of one remainder stay together.
        let x = |channel: usize| if row < 250 { row } else { row + channel % 4 };
        text.push_str(&(0..40).map(|i| format!("{}\t{}", x(i), row * i)).collect::<Vec<_>>().join("\t"));
        text.push('\n');
    }
    let recording = read(&text);
    let shapes: Vec<_> = recording.tables.iter().map(|t| (t.rows, t.columns.len())).collect();
    assert_eq!(shapes, [(300, 11); 4]);
    for (remainder, table) in recording.tables.iter().enumerate() {
        let x = table.time().unwrap().cells.numbers().unwrap();
        assert_eq!((x[0], x[249], x[250]), (0.25, 249.25, 250.25 + remainder as f64));
        assert_eq!(table.columns[1].cells.numbers().unwrap()[299], (299 * remainder) as f64);
    }
}

#[test]
fn comments_are_kept_where_they_stand() {
    let rows = "0.0\t1.5\t-2\n0.1\t2.5\t-3\tvalve, open\t\n0.2\t3.5\t-4\t\n";
    let recording = read(&format!("{HEAD}{SEGMENT}{rows}"));
    assert_eq!(words(&recording, "Comment"), ["", "valve, open", ""]);
    assert_eq!(recording.findings, []);
    // A separator within a comment.
    let recording = read(&format!("{HEAD}{SEGMENT}{}", rows.replace("valve, open", "valve\topen")));
    assert_eq!((words(&recording, "Comment")[1].as_str(), recording.findings.len()), ("valve\topen", 0));
    // Not named.
    let recording = read(&format!("{HEAD}{}{rows}", SEGMENT.replace("\tComment\n", "\n")));
    assert_eq!(words(&recording, "Comment")[1], "valve, open");
    has_reason(&recording, "which the line of names does not have");
    // A number behind it is a comment as well; one behind channels without a comment is a cell too many.
    let recording = read(&format!("{HEAD}{SEGMENT}{}", rows.replace("valve, open", "7")));
    assert_eq!(words(&recording, "Comment")[1], "7");
    let recording = read(&format!("{HEAD}{}{rows}", SEGMENT.replace("\tComment\n", "\n")).replace("valve, open", "7"));
    assert_eq!(kinds(&recording), [(FindingKind::RaggedLine, Severity::Excluded, 1)]);
    assert!(numbers(&recording, "p")[1].is_nan() && numbers(&recording, "X_Value")[1].is_nan());
    // A row of nothing but a comment is a row.
    let recording = read(&format!("{HEAD}{SEGMENT}{ROWS}\t\t\tend\n").replace("Samples\t3\t3", "Samples\t4\t4"));
    assert_eq!((recording.tables[0].rows, words(&recording, "Comment")[3].as_str()), (4, "end"));
    // No comment, no column.
    assert!(read(&whole()).tables[0].column("Comment").is_none());
}

#[test]
fn what_is_no_number_is_a_hole_and_told() {
    use FindingKind::{EmptyCell, NoValue, NonNumericCell, RaggedLine, SkippedLine, StepMismatch};
    use Severity::{Excluded, Note};
    let rows = "0.0\tERR\t-2\n0.1\t\t-3\nNaN\t3.5\t-4\n0.3\t4.5\n0.4\t5.5\t1,5\n\t\t\t\n0.6\t6.5\t-7\nend of test\n";
    let recording = read(&format!("{HEAD}{SEGMENT}{rows}").replace("Samples\t3\t3", "Samples\t7\t7"));
    let (p, f) = (numbers(&recording, "p"), numbers(&recording, "F"));
    let holes = |column: &[f64]| column.iter().map(|v| v.is_nan()).collect::<Vec<_>>();
    assert_eq!(holes(p), [true, true, false, false, false, true, false]);
    assert_eq!(holes(f), [false, false, false, true, true, true, false]);
    assert_eq!(holes(numbers(&recording, "X_Value")), [false, false, true, false, false, true, false]);
    let expected = [
        (RaggedLine, Excluded, 1),
        (SkippedLine, Excluded, 1),
        (NoValue, Excluded, 1),
        (EmptyCell, Note, 1),
        (NonNumericCell, Excluded, 1),
        (EmptyCell, Note, 2),
        (NonNumericCell, Excluded, 1),
        (EmptyCell, Note, 2),
    ];
    assert_eq!(kinds(&recording), expected, "{:#?}", recording.findings);
    assert!(recording.findings.iter().all(|finding| finding.kind != StepMismatch));
    assert!(recording.findings[4].text.contains("column `p`: 1 cell is not a number (line 24: `ERR`)"));
    assert!(recording.findings[1].text.contains("line 31: `end of test`"));
    assert_eq!(recording.findings[0].spans[0].first_sample, 3);
}

#[test]
fn special_blocks_are_metadata_wherever_they_stand() {
    let special = "***Start_Special***\t\nBinary_Data\n1\t2\t3\nX_Value\t9\n***End_Special***\t\n";
    let plain = read(&whole());
    let places =
        ["Operator\t", "***End_of_Header***\t\n\t", "Channels\t2", "X_Value\tp", "0.0\t1.5", "0.1\t2.5", "0.2\t3.5"];
    for place in places {
        let text = whole().replacen(place, &format!("{special}{place}"), 1);
        let recording = read(&text);
        assert_eq!(
            (&recording.tables[0].columns, &recording.findings[..]),
            (&plain.tables[0].columns, &[][..]),
            "{place}"
        );
        assert!(recording.metadata.iter().any(|line| line == "Binary_Data"), "{place}");
        assert!(recording.metadata.iter().any(|line| line == "X_Value\t9"), "{place}");
    }
    // Bytes without a line end for longer than any line.
    let long = format!("***Start_Special***\n{}\n***End_Special***\n", "x".repeat(3 << 20));
    assert_eq!(
        read(&whole().replacen("0.1\t2.5", &format!("{long}0.1\t2.5"), 1)).tables[0].columns,
        plain.tables[0].columns
    );
    let cut = read(&format!("{}{}", whole(), &special[..40]));
    assert_eq!(kinds(&cut), [(FindingKind::Truncated, Severity::Lost, 1)]);
}

#[test]
fn free_text_in_headers_is_kept_and_changes_nothing() {
    let plain = read(&whole());
    for notes in [
        "Description\tpressure\tforce\t\n",
        "Description\tfirst line\nsecond line, 1\t2\t3\n\nthird\n",
        "Description\t\"quoted\t text\"\n",
        "Description\tescaped\\09tab\\0D\\0A\n",
    ] {
        let recording = read(&whole().replace("Operator\t", &format!("{notes}Operator\t")));
        assert_eq!((&recording.tables[0].columns, recording.findings.len()), (&plain.tables[0].columns, 0), "{notes}");
        let first = notes.split('\n').next().unwrap().replacen('\t', ": ", 1);
        assert!(recording.metadata.contains(&first.trim().to_owned()), "{first}: {:?}", recording.metadata);
        let in_segment = notes.replace("Description", "Notes");
        let recording = read(&whole().replace("Samples\t", &format!("{in_segment}Samples\t")));
        assert_eq!((&recording.tables[0].columns, recording.findings.len()), (&plain.tables[0].columns, 0), "{notes}");
    }
}

#[test]
fn any_key_may_be_missing() {
    let plain = read(&whole());
    let text = whole();
    let lines: Vec<&str> = text.split_inclusive('\n').collect();
    for (left_out, line) in lines.iter().enumerate().filter(|(_, line)| !line.starts_with("X_Value")) {
        if line.starts_with(|c: char| c.is_ascii_digit()) {
            continue;
        }
        let text: String = lines.iter().enumerate().filter(|(i, _)| *i != left_out).map(|(_, line)| *line).collect();
        let recording = read(&text);
        let (p, f) = (numbers(&recording, "p"), numbers(&recording, "F"));
        assert_eq!((p, f), (numbers(&plain, "p"), numbers(&plain, "F")), "without {line}");
        let steps: Vec<f64> = numbers(&recording, "X_Value").windows(2).map(|pair| pair[1] - pair[0]).collect();
        assert!(steps.iter().all(|step| (step - 0.1).abs() < 1e-12), "without {line}");
        assert_eq!(recording.findings, [], "without {line}");
    }
    // The segment has no start: the file's counts.
    let without: String = lines.iter().enumerate().filter(|(i, _)| ![15, 16].contains(i)).map(|(_, l)| *l).collect();
    assert_eq!(numbers(&read(&without), "X_Value")[0], 0.25);
    // No start at all.
    let without = text.lines().filter(|l| !l.starts_with("Date") && !l.starts_with("Time\t")).map(|l| format!("{l}\n"));
    let recording = read(&without.collect::<String>());
    assert_eq!((numbers(&recording, "X_Value"), &recording.origin), (&[0.0, 0.1, 0.2][..], &None));
    assert!(!recording.tables[0].columns[0].is_dated);
    has_reason(&recording, "no start is stated");
    has_reason(&read(&text.replace("X_Dimension\tTime\tTime\t\n", "")), "X_Dimension is not stated");
    // Nothing but names and rows behind the end of a header.
    let recording = read(&format!("***End_of_Header***\nX_Value\tp\tF\n{ROWS}"));
    assert_eq!(numbers(&recording, "F"), numbers(&plain, "F"));
    // Not even names.
    let recording = read_as_lvm(&format!("LabVIEW Measurement\n***End_of_Header***\n\n{ROWS}"));
    assert_eq!(numbers(&recording, "column 3"), numbers(&plain, "F"));
    has_reason(&recording, "no line `X_Value`");
}

fn read_as_lvm(text: &str) -> Recording {
    lvm::read(&RawFile::of_bytes("r.lvm", text.as_bytes()), Keep::All).unwrap()
}

#[test]
fn starts_place_segments_one_behind_the_other() {
    let second = |time: &str| SEGMENT.replace("09:13:00.5", time);
    let text = format!("{}\n{}{ROWS}", whole(), second("09:13:01.25"));
    let recording = read(&text);
    assert_eq!((recording.tables.len(), recording.findings.len()), (1, 0));
    let x = numbers(&recording, "X_Value");
    assert!(x.iter().zip([0.5, 0.6, 0.7, 1.25, 1.35, 1.45]).all(|(a, b)| (a - b).abs() < 1e-12), "{x:?}");
    assert_eq!(numbers(&recording, "p")[3..], [1.5, 2.5, 3.5]);
    assert_eq!(recording.tables[0].lines.line_of(3), 38);
    // At midnight.
    let next_day = second("00:00:01").replace("2026/11/22", "2026/11/23");
    assert_eq!(numbers(&read(&format!("{}\n{next_day}{ROWS}", whole())), "X_Value")[3], 53_221.0);
    // The same start again: X goes on, or does not.
    let again = format!("{}\n{SEGMENT}0.3\t1\t2\n", whole()).replace("Samples\t3\t3", "Samples");
    let recording = read(&again);
    assert_eq!(numbers(&recording, "X_Value")[3], 0.8);
    has_reason(&recording, "1 of 2 segments state the start of the segment before");
    // Back.
    let recording = read(&format!("{}\n{}{ROWS}", whole(), second("09:12:00")));
    assert_eq!(numbers(&recording, "X_Value")[3], 0.5);
    assert_eq!(kinds(&recording), [(FindingKind::TimeReversed, Severity::Note, 1)]);
    // None.
    let none = SEGMENT.lines().filter(|l| !l.starts_with("Date") && !l.starts_with("Time")).map(|l| format!("{l}\n"));
    let recording = read(&format!("{}\n{}{ROWS}", whole(), none.collect::<String>()));
    assert_eq!(numbers(&recording, "X_Value")[3], 0.5);
    has_reason(&recording, "1 of 2 segments state no start");
}

#[test]
fn one_header_may_stand_for_many_segments() {
    let text = HEAD.replace("Multi_Headings\tYes", "Multi_Headings\tNo");
    for between in ["", "\n", "\t\n", "\n\t\n"] {
        let text = format!("{text}{SEGMENT}{ROWS}{between}0.3\t4.5\t-5\n");
        let recording = read(&text);
        assert_eq!(numbers(&recording, "p"), [1.5, 2.5, 3.5, 4.5], "{between:?}");
        assert_eq!(kinds(&recording), [(FindingKind::CountMismatch, Severity::Note, 2)]);
    }
    // Names again: told, and X counts on.
    let no = format!("{text}{SEGMENT}\t1\t2\n\t3\t4\nX_Value\tp\tF\tComment\n\t5\t6\n")
        .replace("X_Columns\tOne", "X_Columns\tNo");
    let recording = read(&no);
    let x = numbers(&recording, "X_Value");
    assert!((x[2] - 0.7).abs() < 1e-12, "{x:?}");
    assert!(recording.findings.iter().any(|f| f.kind == FindingKind::RepeatedHeader));
}

#[test]
fn segments_of_other_channels_are_other_tables() {
    let other = SEGMENT.replace("X_Value\tp\tF", "X_Value\tp\tq").replace("09:13:00.5", "09:13:10.5");
    let third = SEGMENT.replace("09:13:00.5", "09:13:20.5");
    let recording = read(&format!("{}\n{other}{ROWS}\n{third}{ROWS}", whole()));
    let shapes: Vec<_> = recording.tables.iter().map(|t| t.rows).collect();
    assert_eq!(shapes, [6, 3]);
    let names: Vec<_> = recording.tables[1].columns.iter().map(|c| c.name.as_str()).collect();
    assert_eq!(names, ["X_Value (2)", "p (2)", "q"]);
    assert_eq!((numbers(&recording, "X_Value (2)")[0], numbers(&recording, "X_Value")[3]), (10.5, 20.5));
    // Another unit is not the same channel.
    let other = SEGMENT.replace("kPa", "bar");
    assert_eq!(read(&format!("{}\n{other}{ROWS}", whole())).tables.len(), 2);
    // Without rows nothing tells where X stands: it is no other table.
    let no = format!("{HEAD}{SEGMENT}\t1\t2\n\n").replace("X_Columns\tOne\n", "");
    assert_eq!(read(&format!("{no}{SEGMENT}\n")).tables.len(), 1);
    assert_eq!(read(&format!("{no}{SEGMENT}\n{SEGMENT}\t3\t4\n")).tables[0].rows, 2);
    // A second file behind the first.
    assert_eq!(read(&format!("{}{}", whole(), whole())).tables[0].rows, 6);
}

#[test]
fn what_headers_state_is_held_against_the_rows() {
    let recording = read(&whole().replace("Samples\t3\t3", "Samples\t5\t2"));
    let expected = [(FindingKind::CountMismatch, Severity::Lost, 1), (FindingKind::CountMismatch, Severity::Note, 1)];
    assert_eq!(kinds(&recording), expected);
    assert!(recording.findings[0].text.contains("`p`: 5 stated, 3 counted"), "{}", recording.findings[0].text);
    let recording = read(&whole().replace("Delta_X\t0.1\t0.1", "Delta_X\t0.11\t0.1"));
    assert_eq!(kinds(&recording), [(FindingKind::StepMismatch, Severity::Note, 1)]);
    assert!(
        recording.findings[0].text.contains("`p`: 0.11 s stated, 0.1 s the mean of X, 10 % more"),
        "{}",
        recording.findings[0].text
    );
    assert_eq!(numbers(&recording, "X_Value"), [0.5, 0.6, 0.7], "X counts");
    // Each segment has a step of its own.
    let second = SEGMENT.replace("Delta_X\t0.1\t0.1", "Delta_X\t0.2\t0.2").replace("09:13:00.5", "09:13:09");
    let rows = "0.0\t1\t2\n0.2\t3\t4\n0.4\t5\t6\n";
    assert_eq!(read(&format!("{}\n{second}{rows}", whole())).findings, []);
    let wrong = read(&format!("{}\n{second}{ROWS}", whole()));
    assert!(
        finding(&wrong, FindingKind::StepMismatch).text.contains("line 37: `p`: 0.2 s stated"),
        "{:?}",
        wrong.findings
    );
    // Names and number.
    let recording = read(&whole().replace("Channels\t2", "Channels\t3"));
    assert_eq!(kinds(&recording), [(FindingKind::HeaderMismatch, Severity::Note, 1)]);
    // More cells than names.
    let recording = read(&whole().replace("X_Value\tp\tF\tComment", "X_Value\tp"));
    assert_eq!(numbers(&recording, "column 3"), [-2.0, -3.0, -4.0]);
    assert_eq!(finding(&recording, FindingKind::HeaderMismatch).count, 1);
    // A rounded step and the starts of segments.
    let segment = |k: usize| {
        SEGMENT.replace("09:13:00.5", &format!("09:13:0{k}")).replace("Delta_X\t0.1\t0.1", "Delta_X\t0.3\t0.3")
    };
    let rows = NO.replacen('0', "", 1).repeat(3);
    let text = (0..4).map(|k| format!("{}{rows}\n", segment(k))).collect::<Vec<_>>().concat();
    let recording = read(&format!("{HEAD}{text}").replace("X_Columns\tOne", "X_Columns\tNo"));
    assert_eq!(kinds(&recording), [(FindingKind::StepMismatch, Severity::Note, 1)]);
    assert!(recording.findings[0].text.contains("0.3333 s a sample, 10 % off"), "{}", recording.findings[0].text);
}

#[test]
fn ten_thousand_segments_are_told_together() {
    let mut text = HEAD.to_owned();
    for k in 0..10_000 {
        let time = format!("{:02}:{:02}:{:02}.5", k / 3600, k / 60 % 60, k % 60);
        let _ = writeln!(text, "{}{ROWS}", SEGMENT.replace("09:13:00.5", &time).replace("Samples\t3", "Samples\t4"));
    }
    let recording = read(&text);
    assert_eq!(recording.tables[0].rows, 30_000);
    assert_eq!(kinds(&recording), [(FindingKind::CountMismatch, Severity::Lost, 10_000)]);
    assert_eq!(numbers(&recording, "X_Value")[29_999], 9_999.7);
    assert!(recording.metadata.len() <= 10_001);
    assert!(recording.metadata.last().unwrap().ends_with("more lines of headers)"));
}

#[test]
fn x_since_1904_is_known_by_its_size() {
    let text = whole().replace("Relative", "Absolute");
    let recording = read(&text);
    assert_eq!(numbers(&recording, "X_Value"), [0.5, 0.6, 0.7]);
    has_reason(&recording, "X does not count from 1904");
    // 2016-08-23 10:45:47 UTC, since 1904.
    let since = |x: &str| format!("\n37547{}.{x}\t", 16_347);
    let text = text.replace("\n0.0\t", &since("25")).replace("\n0.1\t", &since("35")).replace("\n0.2\t", &since("45"));
    for text in [&text, &text.replace("Absolute", "Relative")] {
        let recording = read(text);
        assert!((numbers(&recording, "X_Value")[0] - 0.25).abs() < 1e-6);
        // `date -u -d @$((3754716347 - 2082844800))`
        assert_eq!(recording.origin.as_deref(), Some("2022-12-24T08:45:47Z"));
        has_reason(&recording, "1904");
    }
    // A segment without rows, and a first channel without samples, say nothing of what X counts from.
    let recording = read(&text.replacen("Channels", &format!("{SEGMENT}\nChannels"), 1));
    assert_eq!(recording.origin.as_deref(), Some("2022-12-24T08:45:47Z"));
    // Rows behind a block that is longer than what is looked at are rows.
    let special = format!("***Start_Special***\n{}\n***End_Special***\n", "x".repeat(1 << 17));
    let second = SEGMENT.replace("09:13:00.5", "09:13:10.5");
    let recording = read(&format!("{HEAD}{SEGMENT}{special}{ROWS}\n{second}{ROWS}"));
    assert_eq!((numbers(&recording, "X_Value")[0], numbers(&recording, "X_Value")[3]), (0.5, 10.5));
    let recording = read(&multi("\t\t3754716347.5\t1\t3754716347.5\t2\n"));
    assert_eq!((numbers(&recording, "X_Value (2)"), numbers(&recording, "b")), (&[0.5][..], &[1.0][..]));
    assert_eq!(recording.origin.as_deref(), Some("2022-12-24T08:45:47Z"));
    // X0 is no other X.
    let no = format!("{HEAD}{SEGMENT}\t1\t2\n").replace("X_Columns\tOne", "X_Columns\tNo");
    let recording = read(&no.replace("0.0E+0", "3754716347.5"));
    assert_eq!(
        (numbers(&recording, "X_Value"), recording.origin.as_deref()),
        (&[0.5][..], Some("2022-12-24T08:45:47Z"))
    );
}

#[test]
fn dates_are_read_where_they_say_one_thing() {
    let with = |date: &str| read(&whole().replace("2026/11/22", date));
    for date in ["22.11.2026", "11/22/2026", "22/11/2026", "2026-11-22", "22-Nov-2026"] {
        assert_eq!(with(date).origin.as_deref(), Some("2026-11-22T09:13:00"), "{date}");
    }
    let open = with("03/02/2026");
    assert_eq!((open.origin.as_deref(), numbers(&open, "X_Value")[0]), (None, 0.5));
    assert_eq!(kinds(&open), [(FindingKind::AmbiguousDate, Severity::Note, 1)]);
    let odd = with("Monday");
    assert_eq!((odd.origin.as_deref(), numbers(&odd, "X_Value")[0]), (None, 0.0));
    assert!(finding(&odd, FindingKind::NonNumericCell).text.contains("Monday"));
}

#[test]
fn an_empty_stamp_is_no_start() {
    // What LabVIEW writes west of Greenwich above data that have no start.
    for (date, time) in [("1903/12/31", "18:00:00"), ("1904/01/01", "01:00:00.0"), ("1904/01/01", "00:00:00")] {
        let segment = SEGMENT.replace("2026/11/22", date).replace("09:13:00.5", time);
        let recording = read(&format!("{HEAD}{segment}{ROWS}"));
        assert_eq!(recording.origin.as_deref(), Some("2026-11-22T09:13:00"), "{date} {time}");
        assert_eq!(numbers(&recording, "X_Value"), [0.25, 0.35, 0.45], "the start of the file counts");
        has_reason(&recording, "1 of 1 segments state 1904-01-01 00:00 UTC, LabVIEW's zero, as their start");
    }
    let head = HEAD.replace("Date\t2026/11/22\n", "");
    let segment = SEGMENT.replace("2026/11/22", "1904/01/01").replace("09:13:00.5", "00:00:00");
    let recording = read(&format!("{head}{segment}{ROWS}"));
    assert_eq!((numbers(&recording, "X_Value"), recording.origin.as_deref()), (&[0.0, 0.1, 0.2][..], None));
}

#[test]
fn x_that_goes_on_as_the_starts_do_is_not_counted_twice() {
    let second = SEGMENT.replace("09:13:00.5", "09:13:10.502");
    let rows = "10.0\t1\t2\n10.1\t1\t2\n10.2\t1\t2\n";
    let recording = read(&format!("{}\n{second}{rows}", whole()));
    assert_eq!(numbers(&recording, "X_Value"), [0.5, 0.6, 0.7, 10.5, 10.6, 10.7]);
    has_reason(&recording, "1 of 2 segments state a later start, and their X has gone on by as much");
    // The same X0 in every segment is another thing.
    let late = |segment: &str| format!("{segment}{}", ROWS.replace("0.0\t", "5.0\t"));
    let x = read(&format!("{HEAD}{}\n{}", late(SEGMENT), late(&second)));
    assert_eq!((numbers(&x, "X_Value")[0], numbers(&x, "X_Value")[3]), (5.5, 15.502));
    // Without a column of X it is X0 that goes on.
    let no = |segment: &str, x0: &str| format!("{}\t1\t2\n\t3\t4\n\n", segment.replace("0.0E+0", x0));
    let text = format!("{HEAD}{}{}", no(SEGMENT, "0"), no(&second, "10")).replace("X_Columns\tOne", "X_Columns\tNo");
    assert_eq!(numbers(&read(&text), "X_Value")[2], 10.5);
}

#[test]
fn nothing_that_one_file_states_holds_for_one_behind_it() {
    let other = whole().replace("Y_Unit_Label\tkPa\tN\t\n", "").replace('.', ",").replace("2026/11/22", "2026/11/23");
    let recording = read(&format!("{}\n{}", whole(), other.replace("A, B,", "A. B.")));
    assert_eq!(recording.tables.len(), 2, "{:?}", recording.findings);
    assert_eq!(recording.tables[1].column("p (2)").unwrap().unit, None);
    assert_eq!(numbers(&recording, "p (2)"), [1.5, 2.5, 3.5]);
    assert_eq!(numbers(&recording, "X_Value (2)")[0], 86_400.5);
}

#[test]
fn a_channel_without_a_step_takes_that_of_another_and_says_so() {
    let no = format!("{HEAD}{SEGMENT}\t1\t-1\n\t2\t-2\n\t3\t-3\n").replace("X_Columns\tOne", "X_Columns\tNo");
    for (steps, name) in [("0.1\t0", "F"), ("0\t0.1", "p"), ("0.1\t???", "F")] {
        let recording = read(&no.replace("Delta_X\t0.1\t0.1", &format!("Delta_X\t{steps}")));
        assert_eq!(recording.tables.len(), 1, "{steps}");
        assert_eq!(numbers(&recording, "X_Value")[1..], [0.5 + 0.1, 0.5 + 0.2]);
        has_reason(&recording, &format!("`{name}` has neither an X nor a `Delta_X`: 0.1"));
    }
}

#[test]
fn channels_may_have_any_name() {
    for names in
        ["X_Value\tX_Value\tF", "X_Value\tp\tX_Value", "X_Value\tX_Value\tX_Value", "X_Value\tp\t", "X_Value\t\tF"]
    {
        for (channels, is_commented) in [("2", true), ("2", false), ("", true)] {
            let comment = if is_commented { "\tComment" } else { "" };
            let text = whole().replace("Channels\t2", &format!("Channels\t{channels}"));
            let recording = read(&text.replace("X_Value\tp\tF\tComment", &format!("{names}{comment}")));
            let table = &recording.tables[0];
            let read: Vec<_> = table.columns.iter().map(|column| column.cells.numbers().unwrap()).collect();
            assert_eq!(
                read,
                [[0.5, 0.6, 0.7], [1.5, 2.5, 3.5], [-2.0, -3.0, -4.0]],
                "{names} {channels} {is_commented}"
            );
            assert_eq!(recording.findings, [], "{names} {channels} {is_commented}");
        }
    }
    // The first samples of a channel without a name are missing.
    let text = whole().replace("X_Value\tp\tF\tComment", "X_Value\tp\t").replace("\t-2\n", "\t\n");
    assert_eq!(numbers(&read(&text), "column 3")[1..], [-3.0, -4.0]);
}

#[test]
fn blank_lines_among_rows_without_x_are_told() {
    let no = format!("{HEAD}{SEGMENT}\t1\t-1\n\t2\t-2\n").replace("X_Columns\tOne", "X_Columns\tNo");
    let told = |text: &str| read(text).reasons.iter().any(|reason| reason.contains("blank lines part rows"));
    assert!(told(&format!("{no}\n\t3\t-3\n")) && told(&format!("{no}\t\n\t3\t-3\n")));
    assert!(!told(&no) && !told(&format!("{no}\n\n")) && !told(&format!("{}\n{ROWS}", whole())));
}

#[test]
fn x_that_is_no_time_is_no_clock() {
    let recording = read(&whole().replace("X_Dimension\tTime\tTime", "X_Dimension\tFrequency\tFrequency"));
    assert_eq!((recording.tables[0].clock, recording.tables[0].columns[0].unit.as_deref()), (None, None));
    assert_eq!((numbers(&recording, "X_Value"), recording.origin.as_deref()), (&[0.0, 0.1, 0.2][..], None));
    has_reason(&recording, "X_Dimension is `Frequency`");
    let ms = read(&whole().replace("X0\t", "X_Unit_Label\tms\tms\nX0\t"));
    assert_eq!(numbers(&ms, "X_Value"), [0.5, 0.1 * 1e-3 + 0.5, 0.2 * 1e-3 + 0.5]);
}

#[test]
fn a_file_cut_anywhere_gives_a_prefix_and_says_what_it_can() {
    let two = format!("{}\n{}{ROWS}", whole(), SEGMENT.replace("09:13:00.5", "09:13:09"));
    for text in [two.clone(), multi("0\t1\t0\t10\t0\t100\n0.1\t2\t0.1\t20\t0.2\t200\n0.2\t3\t0.2\t30\t\t\n")] {
        let all = read(&text);
        let first_row = text.find("Comment\n").unwrap() + 8;
        for cut in 0..text.len() {
            let bytes = &text.as_bytes()[..cut];
            let result = lvm::read(&RawFile::of_bytes("r.lvm", bytes), Keep::All);
            let looked_at = lvm::read(&RawFile::of_bytes("r.lvm", bytes), Keep::Nothing);
            assert_eq!(result.is_ok(), looked_at.is_ok());
            if cut < first_row {
                let error = result.unwrap_err().to_string();
                assert!(error.contains("the file ends within its header"), "{cut}: {error}");
                continue;
            }
            let cut_file = result.unwrap();
            let lost = cut_file.findings.iter().any(|f| f.severity == Severity::Lost);
            let no_end = cut_file.findings.iter().any(|f| f.kind == FindingKind::NoLineEnd);
            for column in cut_file.tables.iter().flat_map(|table| &table.columns) {
                let Some(read) = column.cells.numbers() else { continue };
                let whole = numbers(&all, &column.name);
                for (row, (a, b)) in read.iter().zip(whole).enumerate() {
                    let is_last = row + 1 == read.len();
                    let same = a.to_bits() == b.to_bits() || (a.is_nan() && (b.is_nan() || is_last));
                    assert!(same || (is_last && no_end), "{cut}: {} {row}: {a} {b}", column.name);
                }
            }
            let is_whole_line = text.as_bytes()[cut - 1] == b'\n';
            let rows: usize = cut_file.tables.iter().map(|t| t.rows).sum();
            let missing = rows < all.tables.iter().map(|t| t.rows).sum();
            // A cut between segments, or within the blank line there, leaves no trace.
            let between = cut == whole().len() || cut == whole().len() + 1;
            assert!(lost || no_end || !missing || between, "{cut} {is_whole_line}: {:?}", cut_file.findings);
        }
    }
    // Of a row without X, only the empty cell in front of it.
    let no = format!("{HEAD}{SEGMENT}\t1\t-1\n").replace("Samples\t3\t3", "Samples\t1\t1");
    assert_eq!(kinds(&read(&format!("{no}\t"))), [(FindingKind::NoLineEnd, Severity::Note, 1)]);
    let error = error(&HEAD[..60]);
    assert!(error.starts_with("r.lvm:4") && error.contains("expected: a line `X_Value`"), "{error}");
}

#[test]
fn flipped_bytes_never_panic() {
    let text = format!("{}\n{}{ROWS}", multi("0\t1\t0\t10\t0\t100\n0.1\t2\t0.1\t20\t0.2\t200\n"), SEGMENT);
    for at in 0..text.len() {
        for flip in [0x01, 0x04, 0x20, 0x80, 0xff] {
            let mut bytes = text.clone().into_bytes();
            bytes[at] ^= flip;
            let read = |keep| lvm::read(&RawFile::of_bytes("r", &bytes), keep).map(|r| (r.tables.len(), r.findings));
            match (read(Keep::All), read(Keep::Nothing)) {
                (Ok(kept), Ok(looked_at)) => assert_eq!(kept, looked_at, "{at} {flip}"),
                (Err(kept), Err(looked_at)) => assert_eq!(kept.to_string(), looked_at.to_string()),
                (kept, _) => panic!("{at} {flip}: {}", kept.is_ok()),
            }
        }
    }
}

#[test]
fn hostile_sizes_are_errors_or_small() {
    // A hundred thousand segments, each with other channels.
    let mut text = HEAD.to_owned();
    for k in 0..100_000 {
        let _ = write!(text, "Channels\t1\n***End_of_Header***\nX_Value\tc{k}\n0\t1\n\n");
    }
    assert!(error(&text).contains("at most 4096 columns in all segments"));
    // A header far too wide for its rows.
    let wide = format!("{HEAD}X_Value\t{}\n{}", vec!["a"; 4000].join("\t"), "1\n".repeat(20_000));
    assert!(error(&wide).contains("rows times columns"), "{}", error(&wide));
    let wide = format!("{HEAD}X_Value\t{}\n1\t2\n", vec!["a"; 5000].join("\t"));
    assert!(error(&wide).contains("at most 4096 columns"));
    let long = format!("{HEAD}{SEGMENT}{}\n", "1".repeat(2 << 20));
    assert!(error(&long).contains("lines of at most"));
    // A segment on every other line, without names.
    let recording = read(&format!("{HEAD}{}", "***End_of_Header***\n1\t2\n".repeat(30_000)));
    assert_eq!(recording.tables[0].rows, 30_000);
    // Numbers that no file can hold.
    let recording = read(&whole().replace("Samples\t3\t3", "Samples\t1e300\t99999999999999999999999"));
    assert_eq!(finding(&recording, FindingKind::CountMismatch).count, 2);
    let _ = read(&whole().replace("Delta_X\t0.1\t0.1", "Delta_X\t1e308\t-1e308").replace("X0\t0.0E+0", "X0\t1e308"));
    assert!(error(&whole().replace('\t', "+")).contains("cells parted by"));
    // A page of empty rows is no row.
    let recording = read(&format!("{}{}", whole(), "\t\t\n".repeat(100_000)));
    assert_eq!(
        (recording.tables[0].rows, kinds(&recording)),
        (3, vec![(FindingKind::EmptyCell, Severity::Note, 100_000)])
    );
}

#[test]
fn only_what_is_asked_for_is_kept_and_its_clock() {
    let text = multi("0\t1\t0\t10\t0\t100\n0.1\t2\t0.1\t20\t0.2\t200\n0.2\t3\t0.2\t30\t\t\n");
    let asked = [ColumnRef::Name("c".to_owned())];
    let raw = RawFile::of_bytes("r.lvm", text.as_bytes());
    let recording = lvm::read(&raw, Keep::Only(&asked)).unwrap();
    assert_eq!((numbers(&recording, "c"), numbers(&recording, "X_Value (2)")), (&[100.0, 200.0][..], &[0.0, 0.2][..]));
    assert_eq!(recording.tables[0].column("a").unwrap().cells, Cells::NotKept);
    assert_eq!(recording.tables[0].column("a").unwrap().summary, read(&text).tables[0].column("a").unwrap().summary);
    let nothing = lvm::read(&raw, Keep::Nothing).unwrap();
    let clock = nothing.tables[0].time().unwrap();
    assert_eq!(
        (clock.cells.clone(), clock.is_forward(), nothing.findings),
        (Cells::NotKept, true, read(&text).findings)
    );
}

#[test]
fn the_format_is_told_from_the_first_bytes() {
    let detect = |bytes: &[u8]| formats::detect(&RawFile::of_bytes("r", bytes)).unwrap();
    assert_eq!(detect(whole().as_bytes()), Format::Lvm);
    assert_eq!(detect(&whole().encode_utf16().flat_map(u16::to_le_bytes).collect::<Vec<_>>()), Format::Lvm);
    assert_eq!(detect(b"***End_of_Header***\r\nX_Value\tp\r\n0\t1\r\n"), Format::Lvm);
    assert_ne!(detect(b"X_Value\tp\n0\t1\n1\t2\n"), Format::Lvm);
    assert_eq!(Format::Lvm.id(), "lvm");
}

fn table(name: &str, x: Vec<f64>, columns: &[(&str, Vec<f64>)]) -> Table {
    let rows = x.len();
    let clock = Column::new("X_Value", Some("s"), Cells::Numbers(x));
    let channel = |(name, y): &(&str, Vec<f64>)| Column::new(name, Some("kPa"), Cells::Numbers(y.clone()));
    let columns = std::iter::once(clock).chain(columns.iter().map(channel)).collect();
    let lines = LineMap::default();
    Table { name: name.to_owned(), schema: None, columns, rows, lines, clock: Some(0), decimal: Decimal::Point }
}

/// Values that need every digit.
fn odd_values(rows: usize, seed: u64) -> Vec<f64> {
    let value = |i: usize| {
        let bits = (i as u64 + seed).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        ((bits >> 11) as f64 / 9_007_199_254_740_992.0 - 0.5) * 10.0_f64.powi(i32::try_from(i % 30).unwrap() - 15)
    };
    (0..rows).map(value).collect()
}

#[test]
fn what_is_written_is_read_back_with_every_option() {
    let rows = 57;
    let even: Vec<f64> = (0..rows).map(|i| i as f64 / 8.0).collect();
    let uneven: Vec<f64> = (0..rows).map(|i| i as f64 / 10.0 + f64::from(u8::from(i % 7 == 0)) * 0.01).collect();
    let mut a = odd_values(rows, 1);
    a[5] = f64::NAN;
    for x_columns in [XColumns::No, XColumns::One, XColumns::Multi] {
        for (separator, decimal) in
            [(b'\t', Decimal::Point), (b'\t', Decimal::Comma), (b',', Decimal::Point), (b';', Decimal::Comma)]
        {
            for has_headers in [true, false] {
                for segment_rows in [None, Some(1), Some(10), Some(57)] {
                    for origin in [None, Some("2026-11-22T23:59:58".to_owned())] {
                        let x = if x_columns == XColumns::No { &even } else { &uneven };
                        let mut first = table("", x.clone(), &[("a", a.clone()), ("b [2]", odd_values(rows, 2))]);
                        let mut said = vec![String::new(); rows];
                        said[3] = "valve open".to_owned();
                        first.columns.push(Column::new("Comment", None, Cells::Text(said.clone())));
                        let mut tables = vec![first];
                        if x_columns == XColumns::Multi {
                            tables.push(table("", even[..40].to_vec(), &[("c", odd_values(40, 3))]));
                        }
                        let options = WriteOptions {
                            separator,
                            decimal,
                            x_columns,
                            has_headers,
                            segment_rows,
                            origin: origin.clone(),
                            ..WriteOptions::default()
                        };
                        let mut bytes = vec![];
                        write(&mut bytes, &tables, &options).unwrap();
                        let recording = read_bytes(&bytes);
                        assert_eq!(recording.tables.len(), tables.len(), "{options:?}");
                        assert_eq!(recording.origin, origin, "{options:?}");
                        for (read, written) in recording.tables.iter().zip(&tables) {
                            assert_eq!(read.rows, written.rows, "{options:?}");
                            for (read, written) in read.columns.iter().zip(&written.columns) {
                                let (Some(read), Some(written)) = (read.cells.numbers(), written.cells.numbers())
                                else {
                                    continue;
                                };
                                let same = |(a, b): (&f64, &f64)| a == b || (a.is_nan() && b.is_nan());
                                assert!(read.iter().zip(written).all(same), "{options:?}\n{read:?}\n{written:?}");
                            }
                        }
                        assert_eq!(words(&recording, "Comment"), said);
                        let odd = recording
                            .findings
                            .iter()
                            .filter(|f| f.severity == Severity::Lost || f.kind == FindingKind::NonNumericCell);
                        assert_eq!(odd.count(), 0, "{options:?} {:?}", recording.findings);
                    }
                }
            }
        }
    }
}

#[test]
fn what_a_layout_cannot_say_is_not_written() {
    let good = || table("", vec![0.0, 0.1, 0.2], &[("a", vec![1.0, 2.0, 3.0])]);
    let options = WriteOptions::default;
    let refused = |tables: &[Table], options: WriteOptions, part: &str| {
        let error = write(&mut Vec::new(), tables, &options).unwrap_err().to_string();
        assert!(error.contains(part), "{part}: {error}");
    };
    let no = WriteOptions { x_columns: XColumns::No, ..options() };
    refused(&[table("t", vec![0.0, 0.1, 0.3], &[("a", vec![1.0; 3])])], no.clone(), "an even clock");
    refused(&[table("t", vec![0.0, f64::NAN, 0.2], &[("a", vec![1.0; 3])])], no, "first in row 1");
    refused(&[good(), good()], options(), "one table where X_Columns is One");
    refused(&[], WriteOptions { x_columns: XColumns::Multi, ..options() }, "a channel");
    refused(&[good()], WriteOptions { separator: b',', decimal: Decimal::Comma, ..options() }, "not the decimal sign");
    refused(&[good()], WriteOptions { separator: b'e', ..options() }, "a separator that numbers");
    refused(&[good()], WriteOptions { segment_rows: Some(0), ..options() }, "at least one row");
    refused(&[good()], WriteOptions { origin: Some("today".to_owned()), ..options() }, "an origin");
    for name in ["", "a\tb", " a", "Comment", "X_Value", "a\nb", "\"a\""] {
        let error = write(&mut Vec::new(), &[table("", vec![0.0], &[(name, vec![1.0])])], &options()).unwrap_err();
        assert!(error.to_string().contains("a name"), "{name:?}: {error}");
    }
    refused(&[table("", vec![0.0], &[("a", vec![f64::INFINITY])])], options(), "finite numbers");
    refused(&[table("", vec![0.0], &[("a", vec![1.0, 2.0])])], options(), "1 numbers in every column");
    let clockless =
        Table { clock: None, columns: vec![Column::new("a", None, Cells::Numbers(vec![1.0; 3]))], ..good() };
    refused(&[clockless], options(), "a clock");
}

#[test]
fn few_digits_are_written_where_asked_for() {
    let options = WriteOptions { digits: Some(3), ..WriteOptions::default() };
    let mut bytes = vec![];
    write(&mut bytes, &[table("", vec![0.0, 1.0 / 3.0], &[("a", vec![2.0 / 3.0, -1e9])])], &options).unwrap();
    let text = String::from_utf8(bytes).unwrap();
    assert!(text.ends_with("0.000\t0.667\r\n0.333\t-1000000000.000\r\n"), "{text}");
}

#[test]
fn a_row_that_begins_with_a_word_names_no_columns() {
    // Found by the fuzzer: a first row without names, a word in its first cell and an empty one at its end.
    let text = format!("{HEAD}Channels\t1\n***End_of_Header***\n0.2\t3\n0.3Header\t\n");
    let recording = read(&text);
    assert_eq!(numbers(&recording, "column 2")[0], 3.0);
    has_reason(&recording, "no line `X_Value` names the columns");
    assert_eq!(kinds(&recording)[0].0, FindingKind::NonNumericCell);
}

#[test]
fn lines_of_all_seeds_in_any_order_never_panic_and_are_read_alike() {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("fuzz/seeds/lvm");
    let mut lines: Vec<Vec<u8>> = vec![];
    for entry in std::fs::read_dir(folder).unwrap() {
        let bytes = std::fs::read(entry.unwrap().path()).unwrap();
        lines.extend(bytes.split_inclusive(|b| *b == b'\n').map(<[u8]>::to_vec));
    }
    lines.sort();
    let mut state = 0x9e37_79b9_7f4a_7c15_u64;
    let mut next = |below: usize| {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        usize::try_from(state % below as u64).unwrap()
    };
    let mut read_at_all = 0;
    for _ in 0..6_000 {
        let mut bytes = if next(2) == 0 { HEAD.as_bytes().to_vec() } else { vec![] };
        for _ in 0..next(60) {
            bytes.extend_from_slice(&lines[next(lines.len())]);
            if next(12) == 0 {
                let cut = next(bytes.len() + 1);
                bytes.truncate(cut);
            }
        }
        let raw = RawFile::of_bytes("r", &bytes);
        let read = |keep| lvm::read(&raw, keep);
        match (read(Keep::All), read(Keep::Nothing)) {
            (Ok(kept), Ok(looked_at)) => {
                assert_eq!(kept.findings, looked_at.findings, "{}", String::from_utf8_lossy(&bytes));
                for (a, b) in kept.tables.iter().zip(&looked_at.tables) {
                    assert!(a.columns.iter().all(|column| column.cells.len() == a.rows));
                    assert_eq!((a.rows, a.columns.len(), a.lines.rows()), (b.rows, b.columns.len(), a.rows));
                }
                read_at_all += 1;
            }
            (Err(kept), Err(looked_at)) => assert_eq!(kept.to_string(), looked_at.to_string()),
            (kept, _) => panic!("{}", kept.is_ok()),
        }
    }
    assert!(read_at_all > 1_000, "{read_at_all}");
}
