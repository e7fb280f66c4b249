//! What microcontrollers write to serial ports: keys and values, stamps of terminals, and the noise between.

// In a test a panic is how a failure is told; equality of floats is asked where it must be exact.
#![allow(clippy::unwrap_used, clippy::panic, clippy::float_cmp)]

use std::fmt::Write as _;

use pneuval_ingest::IngestError;
use pneuval_ingest::finding::{Finding, FindingKind, Severity};
use pneuval_ingest::formats::serial::{WriteOptions, write};
use pneuval_ingest::formats::{Format, Options, detect, read};
use pneuval_ingest::limits::LINE_BYTES_MAX;
use pneuval_ingest::raw::RawFile;
use pneuval_ingest::recording::{Cells, Column, ColumnRef, Keep, Recording};

fn recording(text: impl AsRef<[u8]>, expected: Format) -> Recording {
    let raw = RawFile::of_bytes("r.log", text.as_ref());
    assert_eq!(detect(&raw).unwrap(), expected, "{}", String::from_utf8_lossy(text.as_ref()));
    let recording = read(&raw, &Options::default(), Keep::All).unwrap();
    for column in &recording.tables[0].columns {
        assert_eq!(column.cells.len(), recording.tables[0].rows, "{}", column.name);
    }
    recording
}

fn serial(text: impl AsRef<[u8]>) -> Recording {
    recording(text, Format::Serial)
}

fn numbers<'a>(recording: &'a Recording, name: &str) -> &'a [f64] {
    let column = recording.tables[0].column(name);
    column.unwrap_or_else(|| panic!("{name}: {:?}", names(recording))).cells.numbers().unwrap()
}

fn names(recording: &Recording) -> Vec<&str> {
    recording.tables[0].columns.iter().map(|c| c.name.as_str()).collect()
}

/// Kind, severity, count and the lines of the spans.
type Told = (FindingKind, Severity, usize, Vec<(usize, usize)>);

fn told(recording: &Recording) -> Vec<Told> {
    let lines = |f: &Finding| f.spans.iter().map(|s| (s.first_line, s.last_line)).collect();
    recording.findings.iter().map(|f| (f.kind, f.severity, f.count, lines(f))).collect()
}

fn line_of(recording: &Recording, row: usize) -> usize {
    recording.tables[0].lines.line_of(row)
}

#[test]
fn keys_and_values_in_every_spelling() {
    for text in [
        "t=0 p=101.3 flex=2.31\nt=10 p=101.4 flex=2.32\nt=20 p=-0.5 flex=2e-1\n",
        "t:0,p:101.3,flex:2.31\nt:10,p:101.4,flex:2.32\nt:20,p:-0.5,flex:2e-1\n",
        "t=0;p=101,3;flex=2,31\r\r\nt=10;p=101,4;flex=2,32\r\r\nt=20;p=-0,5;flex=2e-1\r\r\n",
        "> t=0\tp=101.3\tflex=2.31\n> flex=2.32\tt=10\tp=101.4\n> p=-0.5\tt=20\tflex=2e-1\n",
        "{\"t\": 0, \"p\": 101.3, \"flex\": 2.31}\n{\"t\": 10, \"p\": 101.4, \"flex\": 2.32}\n{\"t\": 20, \"p\": -0.5, \"flex\": 2e-1}\n",
    ] {
        let log = serial(text);
        assert_eq!(names(&log), ["t", "p", "flex"], "{text}");
        assert_eq!(numbers(&log, "t"), [0.0, 10.0, 20.0], "{text}");
        assert_eq!(numbers(&log, "p"), [101.3, 101.4, -0.5], "{text}");
        assert_eq!(numbers(&log, "flex"), [2.31, 2.32, 0.2], "{text}");
        assert_eq!((log.findings.as_slice(), line_of(&log, 2)), (&[][..], 3), "{text}");
    }
}

#[test]
fn units_glued_in_brackets_or_behind_a_blank_are_the_columns() {
    for text in [
        "t=0ms p=1.5kPa\nt=10ms p=2.5kPa\n",
        "t=0 [ms] p=1.5 [kPa]\nt=10 [ms] p=2.5 [kPa]\n",
        "t (ms): 0, p (kPa): 1.5\nt (ms): 10, p (kPa): 2.5\n",
        "t: 0 ms, p: 1.5 kPa\nt: 10 ms, p: 2.5 kPa\n",
    ] {
        let log = serial(text);
        let units: Vec<_> = log.tables[0].columns.iter().map(|c| c.unit.as_deref()).collect();
        assert_eq!((units, log.findings.len()), (vec![Some("ms"), Some("kPa")], 0), "{text}");
        let values = log.tables[0].columns[1].cells.numbers().unwrap();
        assert_eq!(values, [1.5, 2.5]);
    }
}

#[test]
fn another_unit_on_one_line_is_a_hole_and_never_converted() {
    let log = serial("p=1.5kPa\np=15mbar\np=2.5kPa\np=2.75kPa\n");
    assert!(numbers(&log, "p")[1].is_nan());
    assert_eq!(told(&log), [(FindingKind::UnitMismatch, Severity::Excluded, 1, vec![(2, 2)])]);
}

#[test]
fn boot_messages_half_lines_noise_and_trailers_are_told_with_their_lines() {
    let text =
        b"rst:0x1 (POWERON_RESET)\nBooting rig v1.2\n3 p=1.0 f=5\n\xff\xfe\x01\x80\nt=10 p=1.1 f=6\nt=20 p=1.2 f=7\n\
                 WARN p=500 too high\nt=30 p=1.3 f=8\nDone, 4 samples.\n";
    let log = serial(text);
    assert_eq!(numbers(&log, "p"), [1.0, 1.1, 1.2, 1.3]);
    assert!(numbers(&log, "t")[0].is_nan());
    assert_eq!(log.metadata, ["rst:0x1 (POWERON_RESET)", "Booting rig v1.2"]);
    assert_eq!(
        told(&log),
        [
            (FindingKind::SkippedLine, Severity::Note, 2, vec![(1, 2)]),
            (FindingKind::SkippedLine, Severity::Excluded, 2, vec![(4, 4), (7, 7)]),
            (FindingKind::SkippedLine, Severity::Note, 1, vec![(3, 3)]),
            (FindingKind::Trailer, Severity::Note, 1, vec![(9, 9)]),
            (FindingKind::EmptyCell, Severity::Note, 1, vec![(3, 3)]),
        ]
    );
    let skipped = &log.findings[1].text;
    assert_eq!(skipped, "2 lines without a sample left out (line 4: `ÿþ\\u{1}\\u{80}`; line 7: `WARN p=500 too high`)");
}

#[test]
fn missing_keys_new_keys_and_stray_keys() {
    let mut text = String::new();
    for i in 0..40 {
        match i {
            7 => text.push_str("t=7 f=1\n"),
            9 => text.push_str("t=9 p=1 f=1 x=3\n"),
            30.. => writeln!(text, "q={i} t={i} p=1 f=1").unwrap(),
            _ => writeln!(text, "t={i} p=1 f=1").unwrap(),
        }
    }
    let log = serial(&text);
    assert_eq!(names(&log), ["t", "p", "f", "q"]);
    assert!(numbers(&log, "p")[7].is_nan() && numbers(&log, "q")[29].is_nan());
    assert_eq!(numbers(&log, "q")[30..], (30..40).map(f64::from).collect::<Vec<_>>());
    assert_eq!(
        told(&log),
        [
            (FindingKind::StrayKey, Severity::Excluded, 1, vec![(10, 10)]),
            (FindingKind::EmptyCell, Severity::Note, 1, vec![(8, 8)]),
            (FindingKind::EmptyCell, Severity::Note, 30, vec![(1, 30)]),
        ]
    );
}

#[test]
fn two_lines_run_together_are_holes_and_keep_their_place() {
    let log = serial("t=0 p=1\nt=1 p=2 t=2 p=3\nt=3 p=4\n");
    assert!(numbers(&log, "t")[1].is_nan() && numbers(&log, "p")[1].is_nan());
    assert_eq!(told(&log), [(FindingKind::RaggedLine, Severity::Excluded, 1, vec![(2, 2)])]);
    let log = serial("t=0 p=1\nt=1 p=2t=2 p=3\nt=3 p=4\n");
    assert_eq!((numbers(&log, "p"), line_of(&log, 1)), (&[1.0, 4.0][..], 3));
    assert_eq!(told(&log), [(FindingKind::SkippedLine, Severity::Excluded, 1, vec![(2, 2)])]);
}

#[test]
fn a_last_line_without_end() {
    let log = serial("t=0 p=1.25\nt=1 p=1.25\nt=2 p=1.2");
    assert_eq!(told(&log), [(FindingKind::NoLineEnd, Severity::Note, 1, vec![(3, 3)])]);
    let log = serial("t=0 p=1.25\nt=1 p=1.25\nt=2");
    assert_eq!((told(&log), log.tables[0].rows), (vec![(FindingKind::Truncated, Severity::Lost, 1, vec![(3, 3)])], 2));
    let log = serial("t=0 p=1.25 f=1\nt=1 p=1.25 f=1\nt=2 p=1.2");
    assert_eq!((told(&log), log.tables[0].rows), (vec![(FindingKind::Truncated, Severity::Lost, 1, vec![(3, 3)])], 3));
    assert!(numbers(&log, "p")[2].is_nan());
    let cut = [b"t=0 p=1.25\nt=1 p=1.25\n".to_vec(), vec![0; 70_000]].concat();
    assert_eq!(told(&serial(cut)), [(FindingKind::Truncated, Severity::Lost, 1, vec![(2, 2)])]);
}

#[test]
fn words_that_are_no_numbers() {
    let log = serial("t=0 p=1.5 s=IDLE\nt=1 p=nan s=RUN\nt=2 p=ERR s=RUN\nt=3 p=2.5 s=\n");
    // `s=` holds nothing: the line is no line of pairs.
    assert_eq!(log.tables[0].rows, 3);
    assert_eq!(log.tables[0].column("s").unwrap().cells.text().unwrap(), ["IDLE", "RUN", "RUN"]);
    let kinds: Vec<_> = told(&log);
    assert!(kinds.contains(&(FindingKind::NoValue, Severity::Excluded, 1, vec![(2, 2)])), "{kinds:?}");
    assert!(kinds.contains(&(FindingKind::NonNumericCell, Severity::Excluded, 1, vec![(3, 3)])), "{kinds:?}");
}

#[test]
fn stamps_of_a_terminal_are_a_column_in_s() {
    let log = serial("12:33:01.125 -> t=0 p=1\n12:33:01.250 -> t=1 p=2\n");
    assert_eq!(numbers(&log, "terminal_time"), [45_181.125, 45_181.25]);
    assert_eq!((numbers(&log, "p"), log.origin.as_deref()), (&[1.0, 2.0][..], None));
    assert_eq!(log.tables[0].column("terminal_time").unwrap().unit.as_deref(), Some("s"));

    let log = serial("12:33:01.125 -> t,p\n12:33:01.125 -> 0,1.5\n12:33:01.250 -> 1,2.5\nx\n12:33:02.000 -> 2,3.5\n");
    assert_eq!(names(&log), ["terminal_time", "t", "p"]);
    assert_eq!((numbers(&log, "terminal_time")[0], numbers(&log, "p")), (45_181.125, &[1.5, 2.5, 3.5][..]));
    assert_eq!(told(&log), [(FindingKind::SkippedLine, Severity::Excluded, 1, vec![(4, 4)])]);

    let log = serial("[2026-11-22 09:13:00.500] 0,1.5\n[2026-11-22 09:13:01.500] 1,2.5\n");
    assert_eq!((numbers(&log, "terminal_time"), log.origin.as_deref()), (&[0.5, 1.5][..], Some("2026-11-22T09:13:00")));
    // The counter beside the stamps counts from a zero of its own.
    let dated: Vec<bool> = log.tables[0].columns.iter().map(|c| c.is_dated).collect();
    assert_eq!(dated, [true, false, false]);

    let log = serial("23:59:59.5 -> p=1\n00:00:00.5 -> p=2\n00:00:01.5 -> p=3\n");
    assert_eq!(numbers(&log, "terminal_time"), [86_399.5, 86_400.5, 86_401.5]);
    assert_eq!(told(&log), [(FindingKind::ClockWrap, Severity::Note, 1, vec![(2, 2)])]);
}

#[test]
fn behind_stamps_delimited_lines_are_read_as_they_are_without() {
    let text = "boot\r\nt,p,flex0,1.5,2\r\n1,ERR,2\r\nnoise\r\n2,1.5\r\n3,2.5,2\r\n4,3.5,2\r\nbye\r\n5,1";
    let stamped: Vec<String> = text.split("\r\n").map(|line| format!("12:33:01.125 -> {line}")).collect();
    let bare = recording(text, Format::Csv);
    let log = serial(stamped.join("\r\n"));
    assert_eq!(names(&log), ["terminal_time", "t", "p", "flex"]);
    assert_eq!(numbers(&log, "terminal_time"), vec![45_181.125; bare.tables[0].rows]);
    for column in &bare.tables[0].columns {
        let (a, b) = (numbers(&log, &column.name), numbers(&bare, &column.name));
        assert!(a.iter().zip(b).all(|(a, b)| a.to_bits() == b.to_bits()), "{}", column.name);
    }
    assert_eq!((told(&log), &log.tables[0].lines), (told(&bare), &bare.tables[0].lines));
    assert_eq!(told(&log)[0].0, FindingKind::Truncated);
}

#[test]
fn columns_behind_stamps_are_counted_and_named_with_the_stamps_before_them() {
    let text = "12:33:01.125 -> terminal_time,p\n12:33:01.125 -> 0,1.5\n12:33:01.250 -> 1,2.5\n";
    let raw = RawFile::of_bytes("r.log", text.as_bytes());
    let kept = |asked: ColumnRef| -> Vec<(String, usize)> {
        let recording = read(&raw, &Options::default(), Keep::Only(&[asked])).unwrap();
        recording.tables[0].columns.iter().map(|c| (c.name.clone(), c.cells.len())).collect()
    };
    let name = |name: &str| ColumnRef::Name(name.to_owned());
    let columns = |lengths: [usize; 3]| -> Vec<(String, usize)> {
        ["terminal_time", "terminal_time (2)", "p"].iter().map(|n| (*n).to_owned()).zip(lengths).collect()
    };
    // Stamps in s are kept with whatever they are the clock of.
    assert_eq!(kept(ColumnRef::Number(3)), columns([2, 0, 2]));
    assert_eq!(kept(name("p")), columns([2, 0, 2]));
    assert_eq!(kept(name("terminal_time (2)")), columns([2, 2, 0]));
    assert_eq!(kept(ColumnRef::Number(1)), columns([2, 0, 0]));
}

#[test]
fn a_line_too_long_behind_a_stamp_is_told_with_its_number() {
    let text = format!("12:33:01 -> 0,1.5\n12:33:01 -> 1,1.5\n12:33:02 -> {}\n", "1".repeat(LINE_BYTES_MAX));
    let raw = RawFile::of_bytes("r.log", text.as_bytes());
    let options = Options { format: Some(Format::Serial), ..Options::default() };
    let error = read(&raw, &options, Keep::All).unwrap_err();
    assert!(matches!(error, IngestError::Unusable { .. }) && error.to_string().contains("r.log:3"), "{error}");
}

#[test]
fn plain_delimited_lines_over_a_serial_port_stay_csv() {
    let text = "ESP-ROM:esp32s3\r\r\nboot ok\r\r\nt_ms,p,flex\r\r\n0,1.5,2\r\r\n10,1.6,2\r\r\nt_ms,p,flex\r\r\n0,1.5,2\r\r\nguru meditation\r\r\n10,1.6,2\r\r\nbye\r\r\n";
    let log = recording(text, Format::Csv);
    assert_eq!(numbers(&log, "p"), [1.5, 1.6, 1.5, 1.6]);
    let kinds: Vec<_> = log.findings.iter().map(|f| (f.kind, f.spans[0].first_line)).collect();
    assert!(kinds.contains(&(FindingKind::RepeatedHeader, 6)), "{kinds:?}");
    assert!(kinds.contains(&(FindingKind::SkippedLine, 8)), "{kinds:?}");
    assert!(kinds.contains(&(FindingKind::Trailer, 10)), "{kinds:?}");
}

#[test]
fn columns_not_asked_for_are_looked_at_and_not_kept() {
    let raw = RawFile::of_bytes("r.log", b"t=0 p=1\nt=1 p=2\n");
    let recording = read(&raw, &Options::default(), Keep::Nothing).unwrap();
    let p = recording.tables[0].column("p").unwrap();
    assert_eq!((&p.cells, p.summary.samples, p.summary.range), (&Cells::NotKept, 2, Some((1.0, 2.0))));
}

#[test]
fn what_is_written_reads_back() {
    let values: Vec<f64> = (0..500).map(|i| f64::from(i) * 0.1 - 7.0).collect();
    let mut holes = values.clone();
    holes[17] = f64::NAN;
    let columns = [
        Column::new("t", Some("s"), Cells::Numbers(values)),
        Column::new("p", Some("kPa"), Cells::Numbers(holes)),
        Column::new("state", None, Cells::Text(vec!["RUN".to_owned(); 500])),
    ];
    for (sign, separator) in [('=', " "), (':', ","), ('=', "; "), (':', "\t")] {
        let log = serial(write(&columns, WriteOptions { sign, separator, units: true }));
        for (read, written) in log.tables[0].columns.iter().zip(&columns) {
            assert_eq!((&read.name, &read.unit), (&written.name, &written.unit));
            match (&read.cells, &written.cells) {
                (Cells::Numbers(a), Cells::Numbers(b)) => {
                    assert!(a.iter().zip(b).all(|(a, b)| a.to_bits() == b.to_bits() || (a.is_nan() && b.is_nan())));
                }
                (a, b) => assert_eq!(a, b),
            }
        }
        assert_eq!(told(&log), [(FindingKind::EmptyCell, Severity::Note, 1, vec![(18, 18)])]);
    }
}
