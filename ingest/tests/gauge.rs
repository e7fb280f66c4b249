//! What force gauges write: values, units, signs, peaks, overloads, stamps and stated rates.

// In a test a panic is how a failure is told; equality of floats is asked where it must be exact.
#![allow(clippy::unwrap_used, clippy::panic, clippy::float_cmp)]

use pneuval_ingest::finding::{Finding, FindingKind, Severity, clock_findings};
use pneuval_ingest::formats::gauge::{Clock, write};
use pneuval_ingest::formats::{Format, Options, detect, read};
use pneuval_ingest::raw::RawFile;
use pneuval_ingest::recording::{Keep, Recording};

fn gauge(text: impl AsRef<[u8]>) -> Recording {
    let raw = RawFile::of_bytes("r.txt", text.as_ref());
    assert_eq!(detect(&raw).unwrap(), Format::Gauge, "{}", String::from_utf8_lossy(text.as_ref()));
    read(&raw, &Options::default(), Keep::All).unwrap()
}

fn names(recording: &Recording) -> Vec<&str> {
    recording.tables[0].columns.iter().map(|c| c.name.as_str()).collect()
}

fn numbers<'a>(recording: &'a Recording, name: &str) -> &'a [f64] {
    let column = recording.tables[0].column(name);
    column.unwrap_or_else(|| panic!("{name}: {:?}", names(recording))).cells.numbers().unwrap()
}

/// Kind, severity, count and the lines of the spans.
type Told = (FindingKind, Severity, usize, Vec<(usize, usize)>);

fn told(recording: &Recording) -> Vec<Told> {
    let lines = |f: &Finding| f.spans.iter().map(|s| (s.first_line, s.last_line)).collect();
    recording.findings.iter().map(|f| (f.kind, f.severity, f.count, lines(f))).collect()
}

#[test]
fn values_with_their_unit() {
    for (text, unit) in [
        ("1.50 N\r\n-2.25 N\r\n", "N"),
        ("1.50N\n-2.25N\n", "N"),
        ("+1.50 lbF\r-2.25 lbF\r", "lbF"),
        ("1,50 kgf\n-2,25 kgf\n", "kgf"),
        ("Sauter FH 500\n\n 1.50 N\n-2.25 N\n", "N"),
    ] {
        let log = gauge(text);
        assert_eq!((names(&log), numbers(&log, "force")), (vec!["force"], &[1.5, -2.25][..]), "{text}");
        assert_eq!((log.tables[0].columns[0].unit.as_deref(), log.findings.len()), (Some(unit), 0), "{text}");
    }
}

#[test]
fn stamps_numbers_and_elapsed_times_beside_values() {
    let log = gauge("2026-11-22 09:13:00.5 1.50 N\n2026-11-22 09:13:00.6 1.75 N\n");
    assert_eq!((names(&log), log.origin.as_deref()), (vec!["time", "force"], Some("2026-11-22T09:13:00")));
    assert_eq!(numbers(&log, "time"), [0.5, 0.6]);
    assert_eq!(log.tables[0].clock, Some(0));

    let log = gauge("No.;Time;Load\n1;09:13:00,5;1,50 N\n2;09:13:00,6;1,75 N\n3;09:13:00,7;1,80 N\n");
    assert_eq!(names(&log), ["No.", "Time", "Load"]);
    assert_eq!((numbers(&log, "No."), numbers(&log, "Load")), (&[1.0, 2.0, 3.0][..], &[1.5, 1.75, 1.8][..]));
    assert!((numbers(&log, "Time")[1] - 33_180.6).abs() < 1e-9);

    let log = gauge("1\t1.50 N\n2\t1.75 N\n3\t1.80 N\n");
    assert_eq!(names(&log), ["index", "force"]);
    let log = gauge("0.00,1.50 N,0.1 mm\n0.01,1.75 N,0.2 mm\n0.02,1.80 N,0.3 mm\n");
    assert_eq!((names(&log), log.tables[0].clock), (vec!["time", "force", "travel"], Some(0)));
    assert_eq!(log.tables[0].columns[2].unit.as_deref(), Some("mm"));
}

#[test]
fn a_stated_rate_is_the_clock() {
    for head in ["Sampling rate: 100 Hz", "Interval 0.01 s", "Sample interval [ms] = 10 ms", "Rate = 100 S/s"] {
        let log = gauge(format!("Mark-10 M5-50\n{head}\n1.0 N\n2.0 N\nx#!\n4.0 N\nend of data\n"));
        assert_eq!(numbers(&log, "time"), [0.0, 0.01, 0.02, 0.03], "{head}");
        assert!(numbers(&log, "force")[2].is_nan());
        assert_eq!(log.tables[0].clock.map(|c| log.tables[0].columns[c].name.as_str()), Some("time"));
        assert_eq!(
            told(&log),
            [
                (FindingKind::SkippedLine, Severity::Excluded, 1, vec![(5, 5)]),
                (FindingKind::Trailer, Severity::Note, 1, vec![(7, 7)]),
            ]
        );
    }
}

#[test]
fn peaks_letters_overloads_and_other_units_are_told() {
    let log = gauge("1.0 N T\n2.0 N T\n3.0 N C PEAK\nOL N\n---- N\n4.0 lbF T\n5.0 N T\n");
    assert_eq!(names(&log), ["force", "tension", "peak"]);
    let force = numbers(&log, "force");
    assert_eq!((&force[..3], force[6]), (&[1.0, 2.0, 3.0][..], 5.0));
    assert!(force[3..6].iter().all(|f| f.is_nan()));
    assert_eq!(numbers(&log, "tension")[..3], [1.0, 1.0, 0.0]);
    assert_eq!(numbers(&log, "peak"), [0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0]);
    assert_eq!(
        told(&log),
        [
            (FindingKind::PeakMark, Severity::Note, 1, vec![(3, 3)]),
            (FindingKind::SignLetter, Severity::Note, 5, vec![(1, 3), (6, 7)]),
            (FindingKind::NoValue, Severity::Excluded, 1, vec![(5, 5)]),
            (FindingKind::OutOfRange, Severity::Excluded, 1, vec![(4, 4)]),
            (FindingKind::UnitMismatch, Severity::Excluded, 1, vec![(6, 6)]),
            (FindingKind::EmptyCell, Severity::Note, 2, vec![(4, 5)]),
        ]
    );
    assert_eq!(log.findings[4].text, "column `force`: 1 cell is in another unit (line 6: `4.0 lbF T`); left as holes");
}

#[test]
fn what_is_written_reads_back() {
    let values: Vec<f64> = (0..300).map(|i| f64::from(i * 7 % 50) / 4.0 - 3.0).collect();
    let seconds: Vec<f64> = (0..300).map(|i| f64::from(i) / 8.0).collect();
    for clock in [Clock::Rate(8.0), Clock::Seconds(&seconds)] {
        let log = gauge(write(&values, "N", 2, clock));
        assert_eq!((numbers(&log, "force"), numbers(&log, "time")), (&values[..], &seconds[..]));
        assert_eq!(log.findings, []);
    }
}

#[test]
fn a_last_line_that_the_file_ends_within_is_lost_and_told() {
    let lost = |line| vec![(FindingKind::Truncated, Severity::Lost, 1, vec![(line, line)])];
    for (whole, cut) in [
        ("10.3\t1.200 N\n10.4\t1.234 N\n", "10.4001\t1"),
        ("10.3\t1.200 N\n10.4\t1.234 N\n", "10.4001\t"),
        ("10.3\t1.200 N\n10.4\t1.234 N\n", "10"),
        ("10.3\t1.200 N\n10.4\t1.234 N\n", "10.4001\tO"),
        ("1.50 N\n-2.25 N\n", "-"),
        ("1.50 N\n-2.25 N\n", "3."),
        ("1.50 N\n-2.25 N\n", "3.50 N PE"),
        ("1.50N\n-2.25N\n", "3.5"),
        ("1,50 kgf\n-2,25 kgf\n", "3,50 k"),
        // Kilograms too are a unit, but not the one of this file.
        ("1,50 kgf\n-2,25 kgf\n", "3,50 kg"),
        ("1.50 N\t0.1 mm\n-2.25 N\t0.2 mm\n", "3.50 N"),
        ("1.50 N\t0.1 mm\n-2.25 N\t0.2 mm\n", "3.50 N\t0.3 m"),
        ("2026-11-22 09:13:00.5 1.50 N\n2026-11-22 09:13:00.6 1.75 N\n", "2026-11-22 09:1"),
    ] {
        let log = gauge(format!("{whole}{cut}"));
        assert_eq!((log.tables[0].rows, told(&log)), (2, lost(3)), "{cut}");
        assert!(log.findings[0].text.contains("ends within line 3"), "{}", log.findings[0].text);
        // Whether or not it is a sample's, a line that ends is not cut.
        assert!(gauge(format!("{whole}{cut}\n")).findings.iter().all(|f| f.severity != Severity::Lost), "{cut}");
    }
    // Samples went on behind the other line, which is no trailer.
    let log = gauge("Sampling rate: 100 Hz\n1.0 N\n2.0 N\n3.0 N\nx#!\n5.");
    assert_eq!(numbers(&log, "time"), [0.0, 0.01, 0.02, 0.03]);
    let skipped = (FindingKind::SkippedLine, Severity::Excluded, 1, vec![(5, 5)]);
    assert_eq!(told(&log), [lost(6), vec![skipped]].concat());
}

#[test]
fn a_last_line_that_is_whole_or_no_reading_is_not_lost() {
    for (last, kind) in [
        ("3.50 N", FindingKind::NoLineEnd),
        ("3.50 N PEAK", FindingKind::NoLineEnd),
        ("end of data", FindingKind::Trailer),
        ("3 readings", FindingKind::Trailer),
        ("3.50 N mean", FindingKind::Trailer),
        ("Mean: 3.50", FindingKind::Trailer),
        ("saved 2026-11-22 09:13", FindingKind::Trailer),
    ] {
        let log = gauge(format!("1.50 N\n-2.25 N\n{last}"));
        assert!(log.findings.iter().any(|f| f.kind == kind), "{last}: {:?}", log.findings);
        assert!(log.findings.iter().all(|f| f.severity != Severity::Lost), "{last}: {:?}", log.findings);
    }
}

/// Lines of a number and a value.
fn beside(numbers: impl IntoIterator<Item = f64>) -> String {
    let lines: Vec<String> = numbers.into_iter().map(|number| format!("{number}\t1.50 N\n")).collect();
    lines.concat()
}

#[test]
fn stamps_of_a_clock_that_is_set_back_are_still_stamps() {
    let seconds: Vec<f64> = (0..300).map(|i| f64::from(if i < 150 { i } else { i - 50 }) / 50.0).collect();
    for (head, name) in [("", "time"), ("Time [s]\tLoad\n", "Time [s]")] {
        let log = gauge(format!("{head}{}", beside(seconds.iter().copied())));
        assert_eq!((numbers(&log, name), log.tables[0].clock), (&seconds[..], Some(0)));
        let kinds: Vec<_> = clock_findings("r", name, &seconds, None).iter().map(|f| (f.kind, f.count)).collect();
        assert_eq!(kinds, [(FindingKind::TimeReversed, 49), (FindingKind::DuplicateStamp, 1)]);
    }
}

#[test]
fn numbers_that_only_seem_to_rise_are_no_stamps() {
    // A count that begins anew; a travel there and back; one that is noisy; one that is named.
    let count = beside((0..300).map(|i| f64::from(i % 150)));
    let travel = beside((0..300).map(|i| f64::from(if i < 200 { i } else { 400 - i }) / 50.0));
    let noisy = beside((0..300).map(|i| f64::from(i + if i % 9 == 0 { 3 } else { 0 }) / 50.0));
    let rising = |i: i32| f64::from(if i < 150 { i } else { i - 50 }) / 50.0;
    let named = format!("Travel [mm]\tLoad\n{}", beside((0..300).map(rising)));
    let behind: Vec<String> = (0..300).map(|i| format!("1.50 N\t{}\n", rising(i))).collect();
    for (text, name) in
        [(count, "number"), (travel, "number"), (noisy, "number"), (named, "Travel [mm]"), (behind.concat(), "number")]
    {
        let log = gauge(text);
        assert!(names(&log).contains(&name), "{:?}", names(&log));
        assert_eq!(log.tables[0].clock, None, "{name}");
    }
}
