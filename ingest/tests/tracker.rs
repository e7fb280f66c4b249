//! Tracker logs in every order of columns, transposed logs, stamps, formats told apart, and damage that must not break a reader.

// In a test a panic is how a failure is told; equality of floats is asked where it must be exact.
#![allow(clippy::unwrap_used, clippy::panic, clippy::float_cmp)]

use std::fmt::Write as _;

use pneuval_ingest::IngestError;
use pneuval_ingest::finding::{Finding, FindingKind, LineMap, Severity};
use pneuval_ingest::formats::csv::Decimal;
use pneuval_ingest::formats::tracker::{TrackerOptions, write_plus, write_trakstar};
use pneuval_ingest::formats::{Format, Options, detect, read, transposed};
use pneuval_ingest::raw::RawFile;
use pneuval_ingest::recording::{Cells, Column, Keep, Recording, Table};

fn recording(text: impl AsRef<[u8]>, expected: Format) -> Recording {
    let raw = RawFile::of_bytes("r.txt", text.as_ref());
    assert_eq!(detect(&raw).unwrap(), expected, "{}", String::from_utf8_lossy(text.as_ref()));
    read(&raw, &Options::default(), Keep::All).unwrap()
}

fn numbers<'a>(recording: &'a Recording, table: usize, name: &str) -> &'a [f64] {
    let table = &recording.tables[table];
    let names: Vec<&str> = table.columns.iter().map(|c| c.name.as_str()).collect();
    table.column(name).unwrap_or_else(|| panic!("{name}: {names:?}")).cells.numbers().unwrap()
}

/// Kind, severity, count and the lines of the spans.
type Told = (FindingKind, Severity, usize, Vec<(usize, usize)>);

fn told(recording: &Recording) -> Vec<Told> {
    let lines = |f: &Finding| f.spans.iter().map(|s| (s.first_line, s.last_line)).collect();
    recording.findings.iter().map(|f| (f.kind, f.severity, f.count, lines(f))).collect()
}

/// Positions of a trakSTAR in a unit, and angles, of `count` records.
fn poses(count: usize, unit_per_inch: f64) -> Vec<([f64; 3], [f64; 3])> {
    let step = 36.0 / 32768.0 * unit_per_inch;
    (0..count)
        .map(|i| {
            let position = [1, 3, 7].map(|k| ((i * k * 37 + 911) % 9001) as f64 * step);
            let angle = [5, 9, 13].map(|k| ((i * k) % 4000) as f64 * 180.0 / 8192.0);
            (position, angle)
        })
        .collect()
}

#[test]
fn records_with_time_first_are_a_table_per_sensor() {
    for header in ["", "Sensor,Time,X,Y,Z,A,E,R,Quality\n"] {
        let mut text = header.to_owned();
        for (i, (p, a)) in poses(60, 25.4).iter().enumerate() {
            let (sensor, seconds) = (1 + i % 2, i / 2);
            writeln!(
                text,
                "{sensor},10:00:{seconds:02}.5,{:.5},{:.5},{:.5},{:.4},{:.4},{:.4},{}",
                p[0],
                p[1],
                p[2],
                a[0],
                a[1],
                a[2],
                100 + i
            )
            .unwrap();
        }
        let log = recording(&text, Format::Trakstar);
        let tables: Vec<(&str, usize)> = log.tables.iter().map(|t| (t.name.as_str(), t.rows)).collect();
        assert_eq!(tables, [("sensor 1", 30), ("sensor 2", 30)]);
        let time = if header.is_empty() { "time" } else { "Time" };
        let quality = if header.is_empty() { "quality" } else { "Quality" };
        assert_eq!(numbers(&log, 1, time)[..2], [36_000.5, 36_001.5]);
        assert_eq!(numbers(&log, 1, quality)[..2], [101.0, 103.0]);
        let offset = usize::from(!header.is_empty());
        assert_eq!((log.tables[0].lines.line_of(1), log.tables[1].lines.line_of(1)), (3 + offset, 4 + offset));
        assert_eq!(log.tables[0].columns[1].unit.as_deref(), Some("mm"));
        assert_eq!(told(&log), [(FindingKind::InferredUnit, Severity::Note, 3, vec![])]);
    }
}

#[test]
fn seconds_since_1970_and_records_that_take_turns() {
    let mut text = String::new();
    for (i, (p, a)) in poses(40, 1.0).iter().enumerate() {
        let time = 1_795_338_780.25 + i as f64 / 64.0;
        writeln!(text, "{} {time:.6} {:.6} {:.6} {:.6} {:.6} {:.6} {:.6}", i % 4, p[0], p[1], p[2], a[0], a[1], a[2])
            .unwrap();
    }
    let log = recording(&text, Format::Trakstar);
    assert_eq!((log.tables.len(), log.origin.as_deref()), (4, Some("2026-11-22T09:13:00Z")));
    assert_eq!(numbers(&log, 0, "time")[..2], [0.25, 0.3125]);
    assert!(log.tables[0].columns.iter().all(|column| column.is_dated == (column.name == "time")));
    assert_eq!(log.tables[0].columns[1].unit.as_deref(), Some("in"));
}

fn wide(rows: usize) -> String {
    let mut text = String::from("x1,y1,z1,a1,e1,r1,time1,quality1\n");
    for (i, (p, a)) in poses(rows, 2.54).iter().enumerate() {
        writeln!(
            text,
            "{:.6},{:.6},{:.6},{:.5},{:.5},{:.5},00:00:{:02}.25,{}",
            p[0],
            p[1],
            p[2],
            a[0],
            a[1],
            a[2],
            i,
            50 * i
        )
        .unwrap();
    }
    text
}

#[test]
fn damage_in_a_wide_log_is_told_with_its_lines() {
    let good = wide(40);
    let mut lines: Vec<String> = good.lines().map(str::to_owned).collect();
    lines[3] = lines[3].replacen(lines[3].split(',').next().unwrap(), "ERR", 1);
    lines[5] = "1.0,2.0".to_owned();
    lines[7] = lines[0].clone();
    lines[9] = "tracker restarted".to_owned();
    let text = format!("operator: A. Sch\n{}\n1.0,2.0,3.", lines.join("\n"));
    let log = recording(&text, Format::Trakstar);
    assert_eq!((log.tables[0].rows, log.metadata.as_slice()), (39, &["operator: A. Sch".to_owned()][..]));
    assert_eq!(
        told(&log),
        [
            (FindingKind::Truncated, Severity::Lost, 1, vec![(43, 43)]),
            (FindingKind::RaggedLine, Severity::Excluded, 1, vec![(7, 7)]),
            (FindingKind::SkippedLine, Severity::Excluded, 1, vec![(11, 11)]),
            (FindingKind::RepeatedHeader, Severity::Note, 1, vec![(9, 9)]),
            (FindingKind::InferredUnit, Severity::Note, 3, vec![]),
            (FindingKind::NonNumericCell, Severity::Excluded, 1, vec![(5, 5)]),
        ]
    );
    assert_eq!(log.tables[0].columns[0].unit.as_deref(), Some("cm"));
}

#[test]
fn a_wide_log_without_header_is_known_by_its_clock() {
    let text = wide(30);
    let (_, body) = text.split_once('\n').unwrap();
    let log = recording(body, Format::Trakstar);
    let names: Vec<&str> = log.tables[0].columns.iter().map(|c| c.name.as_str()).collect();
    assert_eq!(names, ["x1", "y1", "z1", "a1", "e1", "r1", "time1", "quality1"]);
    assert_eq!((log.tables[0].rows, numbers(&log, 0, "time1")[29]), (30, 29.25));
}

#[test]
fn quality_masks_only_when_asked() {
    let text = wide(30);
    let raw = RawFile::of_bytes("r.csv", text.as_bytes());
    let options = Options { tracker: TrackerOptions { quality_max: Some(1000) }, ..Options::default() };
    let masked = read(&raw, &options, Keep::All).unwrap();
    // 50 i > 1000 for i from 21: lines 23 to 31.
    let low: Vec<_> = told(&masked).into_iter().filter(|t| t.0 == FindingKind::LowQuality).collect();
    assert_eq!(low, vec![(FindingKind::LowQuality, Severity::Excluded, 9, vec![(23, 31)]); 6]);
    assert!(numbers(&masked, 0, "x1")[21].is_nan() && numbers(&masked, 0, "x1")[20].is_finite());
    let all = read(&raw, &Options::default(), Keep::All).unwrap();
    assert!(numbers(&all, 0, "x1").iter().all(|x| x.is_finite()));
    assert!(all.reasons.iter().any(|r| r.contains("quality numbers from 0 to 1450")), "{:?}", all.reasons);
}

#[test]
fn jumps_of_angles_are_told_and_left() {
    let mut text = String::from("x1,y1,z1,a1,e1,r1,time1,quality1\n");
    for (i, a) in [170.0, 178.0, -178.0, -170.0, 179.0].iter().enumerate() {
        writeln!(text, "1,2,3,{a},0,0,00:00:0{i}.0,7").unwrap();
    }
    let log = recording(&text, Format::Trakstar);
    assert_eq!(told(&log), [(FindingKind::AngleWrap, Severity::Note, 2, vec![(4, 4), (6, 6)])]);
    assert_eq!(numbers(&log, 0, "a1"), [170.0, 178.0, -178.0, -170.0, 179.0]);
    assert!(log.reasons.iter().any(|r| r.contains("the unit is left open")), "{:?}", log.reasons);
}

#[test]
fn units_that_a_header_states_are_kept() {
    let text = wide(40).replacen("x1,y1,z1", "x1 (in),y1 (in),z1 (in)", 1);
    let log = recording(&text, Format::Trakstar);
    assert_eq!((log.tables[0].columns[0].unit.as_deref(), log.findings.len()), (Some("in"), 0));
}

fn plus(frames: &[(&str, &str, &str)]) -> String {
    let mut text = String::from("ObjectType = Image\nNDims = 3\nCustomFrameFieldNames = ToolToTrackerTransform\n");
    for (i, (stamp, matrix, status)) in frames.iter().enumerate() {
        write!(
            text,
            "Seq_Frame{i:04}_FrameNumber = {}\nSeq_Frame{i:04}_ToolToTrackerTransformStatus = {status} \n\
             Seq_Frame{i:04}_Timestamp = {stamp}\nSeq_Frame{i:04}_ToolToTrackerTransform = {matrix} \n",
            10 + i
        )
        .unwrap();
    }
    write!(text, "DimSize = 1 1 {}\nElementDataFile = LOCAL\n", frames.len()).unwrap();
    text
}

const TURNED: &str = "0 -1 0 5 1 0 0 6 0 0 1 7 0 0 0 1";

#[test]
fn plus_statuses_matrices_and_counts_are_checked() {
    let frames = [
        ("0.0", TURNED, "OK"),
        ("0.1", TURNED, "INVALID"),
        ("0.2", "2 0 0 1 0 1 0 2 0 0 1 3 0 0 0 1", "OK"),
        ("0.3", "1 0 0 1 0 1 0", "OK"),
        ("0.4", TURNED, "OK"),
    ];
    let text = plus(&frames).replace("Frame0004_FrameNumber = 14", "Frame0004_FrameNumber = 20");
    // What stands behind the header are pixels.
    let log = recording([text.as_bytes(), b"Seq_Frame0009_Timestamp = 9\n\xff\0\n"].concat(), Format::Plus);
    assert_eq!(log.tables[0].rows, 5);
    let x = numbers(&log, 0, "ToolToTracker.x");
    assert_eq!((x[0], x[2], x[4]), (5.0, 1.0, 5.0));
    assert!(x[1].is_nan() && x[3].is_nan());
    let qz = numbers(&log, 0, "ToolToTracker.qz");
    assert!((qz[0] - 0.5_f64.sqrt()).abs() < 1e-12 && qz[2].is_nan());
    let all = told(&log);
    assert_eq!(all[0], (FindingKind::Gap, Severity::Note, 1, vec![(20, 20)]));
    assert_eq!(all[1], (FindingKind::NotRotation, Severity::Excluded, 1, vec![(15, 15)]));
    let poses = all[2..].iter().map(|t| (t.0, t.2, t.3.clone())).collect::<Vec<_>>();
    let each = [(FindingKind::NonNumericCell, 1, vec![(19, 19)]), (FindingKind::LowQuality, 1, vec![(9, 9)])];
    assert_eq!(poses, vec![each; 7].concat());
}

#[test]
fn a_cut_plus_header_is_lost_data_and_its_frames_are_read() {
    let text = plus(&[("0.0", TURNED, "OK"), ("0.1", TURNED, "OK"), ("0.2", TURNED, "OK")]);
    let cut = &text[..text.find("Seq_Frame0002_Timestamp").unwrap() + 20];
    let log = recording(cut, Format::Plus);
    assert_eq!(log.tables[0].rows, 3);
    assert_eq!(told(&log)[0], (FindingKind::Truncated, Severity::Lost, 1, vec![(14, 14)]));
    let short = text.replace("DimSize = 1 1 3", "DimSize = 1 1 8");
    let log = recording(short, Format::Plus);
    assert_eq!(told(&log), [(FindingKind::HeaderMismatch, Severity::Lost, 1, vec![(16, 16)])]);
}

#[test]
fn written_tracker_logs_read_back() {
    let column = |name: &str, unit: Option<&str>, f: &dyn Fn(usize) -> f64| {
        Column::new(name, unit, Cells::Numbers((0..100).map(f).collect()))
    };
    let table = |columns| Table {
        name: String::new(),
        schema: None,
        columns,
        rows: 100,
        lines: LineMap::default(),
        clock: None,
        decimal: Decimal::Point,
    };
    let half = 0.5_f64.sqrt();
    let tool = table(vec![
        column("Timestamp", Some("s"), &|i| i as f64 / 10.0),
        column("Tool.x", Some("mm"), &|i| if i == 3 { f64::NAN } else { i as f64 }),
        column("Tool.y", Some("mm"), &|i| -(i as f64)),
        column("Tool.z", Some("mm"), &|_| 2.5),
        column("Tool.qx", None, &|_| half),
        column("Tool.qy", None, &|_| 0.0),
        column("Tool.qz", None, &|_| 0.0),
        column("Tool.qw", None, &|_| half),
    ]);
    let log = recording(write_plus(&tool), Format::Plus);
    for name in ["Timestamp", "Tool.x", "Tool.y", "Tool.qx", "Tool.qw"] {
        let written = tool.column(name).unwrap().cells.numbers().unwrap();
        for (row, (a, b)) in numbers(&log, 0, name).iter().zip(written).enumerate() {
            let is_hole = row == 3 && name != "Timestamp";
            assert!(if is_hole { a.is_nan() } else { (a - b).abs() < 1e-12 }, "{name} {row}: {a} {b}");
        }
    }
    let step = 91.44 / 32768.0;
    let sensor = table(vec![
        column("x1", None, &|i| (i * 31) as f64 * step),
        column("y1", None, &|i| (i * 17) as f64 * step),
        column("z1", None, &|i| (i * 3) as f64 * step),
        column("a1", None, &|i| (i as f64 * 4.0) % 180.0),
        column("e1", None, &|_| 1.5),
        column("r1", None, &|_| -1.5),
        column("time1", None, &|i| i as f64 / 8.0),
        column("quality1", None, &|i| i as f64),
    ]);
    let log = recording(write_trakstar(&sensor), Format::Trakstar);
    for written in &sensor.columns {
        assert_eq!(numbers(&log, 0, &written.name), written.cells.numbers().unwrap(), "{}", written.name);
    }
    assert_eq!(log.tables[0].columns[0].unit.as_deref(), Some("cm"));
}

#[test]
fn transposed_logs_are_read_line_by_line() {
    for text in [
        "time;0;0.1;0.2;0.3\npressure (kPa);0;1;2;3\n",
        "time,0,0.1,0.2,0.3\r\npressure (kPa),0,1,2,3\r\n",
        "operator;Anna\ntime;0;0,1;0,2;0,3\npressure;kPa;0;1;2;3;\n",
        "time\t0\t0.1\t0.2\t0.3\r\r\npressure [kPa]\t0\t1\t2\t3\r\r\n",
    ] {
        let log = recording(text, Format::Transposed);
        assert_eq!(numbers(&log, 0, "time"), [0.0, 0.1, 0.2, 0.3], "{text}");
        let pressure = &log.tables[0].columns[1];
        assert_eq!(
            (pressure.unit.as_deref(), pressure.cells.numbers()),
            (Some("kPa"), Some(&[0.0, 1.0, 2.0, 3.0][..]))
        );
        assert_eq!(log.findings, [], "{text}");
    }
    let log = recording("time;0;1;2;3\np;5;ERR;7\nq;1;2;3;4\nf;1;2;3", Format::Transposed);
    assert_eq!(
        told(&log),
        [
            (FindingKind::RaggedLine, Severity::Excluded, 1, vec![(2, 2)]),
            (FindingKind::NonNumericCell, Severity::Excluded, 1, vec![(2, 2)]),
            (FindingKind::Truncated, Severity::Lost, 1, vec![(4, 4)]),
        ]
    );
    assert!(numbers(&log, 0, "p")[3].is_nan());
}

#[test]
fn a_transposed_log_with_lines_far_over_a_megabyte() {
    let values: Vec<f64> = (0..200_000).map(|i| f64::from(i) * 0.001).collect();
    let columns = ["time", "p", "f"].map(|name| Column::new(name, Some("s"), Cells::Numbers(values.clone())));
    let text = transposed::write(&columns);
    assert!(text.len() > 4_000_000);
    let log = recording(&text, Format::Transposed);
    assert_eq!((log.tables[0].rows, numbers(&log, 0, "f (s)").last()), (200_000, values.last()));
}

#[test]
fn stamps_in_delimited_text_become_seconds() {
    let log = recording("stamp,p\n2026-11-22 09:13:00.500,1\n2026-11-22 09:13:00.600,2\nERR,3\n", Format::Csv);
    assert_eq!(log.origin.as_deref(), Some("2026-11-22T09:13:00"));
    assert_eq!(numbers(&log, 0, "stamp")[..2], [0.5, 0.6]);
    let dated: Vec<bool> = log.tables[0].columns.iter().map(|c| c.is_dated).collect();
    assert_eq!(dated, [true, false]);
    assert_eq!(log.tables[0].columns[0].unit.as_deref(), Some("s"));
    assert_eq!(told(&log), [(FindingKind::NonNumericCell, Severity::Excluded, 1, vec![(4, 4)])]);

    let log = recording("date;time;p\n22.11.2026;23:59:59,5;1,5\n23.11.2026;00:00:00,5;2,5\n", Format::Csv);
    assert_eq!((numbers(&log, 0, "time"), log.origin.as_deref()), (&[0.5, 1.5][..], Some("2026-11-22T23:59:59")));

    let log = recording("when,p\n01/02/2026 09:00:00,1\n01/02/2026 09:00:01,2\n", Format::Csv);
    assert_eq!((numbers(&log, 0, "when"), log.origin.as_deref()), (&[32_400.0, 32_401.0][..], None));
    assert!(!log.tables[0].columns[0].is_dated);
    assert_eq!(told(&log), [(FindingKind::AmbiguousDate, Severity::Note, 1, vec![(2, 2)])]);

    let log = recording("when,p\n01/02/2026 09:00:00,1\n02/02/2026 09:00:01,2\n", Format::Csv);
    assert!(log.tables[0].columns[0].cells.text().is_some());
    assert_eq!(told(&log), [(FindingKind::AmbiguousDate, Severity::Note, 1, vec![(2, 2)])]);

    let log = recording("clock,p\n23:59:59,1\n00:00:01,2\n", Format::Csv);
    assert_eq!(numbers(&log, 0, "clock"), [86_399.0, 86_401.0]);
    assert_eq!(told(&log), [(FindingKind::ClockWrap, Severity::Note, 1, vec![(3, 3)])]);
}

#[test]
fn ordinary_delimited_logs_stay_csv() {
    for text in [
        "0.000\t3.427\t-0.009\n11.000\t3.426\t0.004\n",
        "config,p,x\nA10-0,0.0,0.0\nA10-0,50.0,2.29\nB20-1,0.0,-1.5\n",
        "A10,0.0,0.0,1\nB10,50.0,2.29,2\nC20,1.0,-1.5,3\n",
        "PARAMETER;INFO;URL;;\nThickness (mm);3;;;\nTime (s);Strain;Stress (MPa)\n0.2;0.04;0.01\n0.3;0.07;0.02\n",
        "Rate: 100 Hz\nOperator: Anna\nGain: 2\nt,p\n0,1\n1,2\n2,3\n",
        "# rate=100 Hz\n# gain=2\nt,p\n0,1\n1,2\n2,3\n",
        "Zeit;Druck\ns;kPa\n0,00;1,5\n0,01;-2,25\n",
        "Druck\n1,5\n1,25\n",
        "  0.0   1.5e+00\n  0.1  -2.5e+00\n",
        "time,x,y,z\n0,1,2,3\n1,2,3,4\n",
        "time,x,y,z,a,b,c,d,e\n0,1,2,3,4,5,6,7,8\n1,2,3,4,5,6,7,8,9\n",
        "0,1,2,3,4,5,6,7,8\n1,2,3,4,5,6,7,8,9\n0,3,2,3,4,5,6,7,8\n1,4,3,4,5,6,7,8,9\n",
        "time,p,unit\n0,1,kPa\n1,2,kPa\n",
        "09:13:00.1,1.5,2\n09:13:00.2,1.6,2\n09:13:00.3,1.7,2\n",
        "t,p\n0,1\n1,ERR\n",
        "1,2\n3,4\n5,6\n",
        "% time p\n0.1 5\n0.2 6\n",
        "p , p,,\"a, b\"\n1,2,3,4\n5,6,7,8\n",
    ] {
        let raw = RawFile::of_bytes("r.csv", text.as_bytes());
        assert_eq!(detect(&raw).unwrap(), Format::Csv, "{text}");
    }
}

/// A text of every format, to be damaged.
fn texts() -> Vec<(Format, Vec<u8>)> {
    let mut serial = String::from("boot v1\n");
    let mut gauge = String::from("Sampling rate: 10 Hz\n");
    let mut rows = String::from("t,p,f0.0,1,2\n");
    for i in 0..40 {
        writeln!(serial, "12:00:{i:02}.5 -> t={i} p={}.5kPa s=RUN", i * 3).unwrap();
        writeln!(gauge, "{i} 09:00:{i:02},5 {},25 N T", i % 7).unwrap();
        writeln!(rows, "12:00:{i:02}.5 -> {i}.5,{},{}", i * 2, i * 3).unwrap();
    }
    let frames = vec![("0.5", TURNED, "OK"); 12];
    let series: Vec<String> = (0..60).map(|i| i.to_string()).collect();
    let series = series.join(";");
    vec![
        (Format::Serial, serial.into_bytes()),
        (Format::Serial, rows.into_bytes()),
        (Format::Gauge, gauge.into_bytes()),
        (Format::Trakstar, wide(20).into_bytes()),
        (Format::Plus, plus(&frames).into_bytes()),
        (Format::Transposed, format!("time;{series}\np (kPa);{series}\n").into_bytes()),
    ]
}

#[test]
fn no_damage_makes_a_reader_panic_and_the_same_bytes_give_the_same_result() {
    let mut state = 0x2545_f491_4f6c_dd1d_u64;
    let mut random = move |below: usize| {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        usize::try_from(state % u64::try_from(below.max(1)).unwrap()).unwrap()
    };
    let pieces: [&[u8]; 10] = [b"\r\n", b"\0\0\0", b"=", b";", b",", b"-", b"1e999", b"\xff\xfe", b"NaN", b":"];
    for (format, text) in texts() {
        let raw = RawFile::of_bytes("r", &text);
        assert_eq!(detect(&raw).unwrap(), format);
        for round in 0..60 {
            let mut damaged = text.clone();
            for _ in 0..=random(6) {
                let at = random(damaged.len());
                match random(5) {
                    0 => damaged.truncate(at),
                    1 => damaged[at..].iter_mut().take(1).for_each(|b| *b ^= 1 << (at % 8)),
                    2 => drop(damaged.splice(at..at, pieces[at % pieces.len()].iter().copied())),
                    3 => drop(damaged.drain(at..(at + 1 + at % 40).min(damaged.len()))),
                    _ => damaged.extend_from_within(at..(at + 200).min(damaged.len())),
                }
                if damaged.is_empty() {
                    damaged.push(b'1');
                }
            }
            let raw = RawFile::of_bytes("r", &damaged);
            // Told by its bytes, or said.
            let format = (round % 2 == 0).then_some(format);
            let options = Options { format, ..Options::default() };
            let once = read(&raw, &options, Keep::All);
            let again = read(&raw, &options, Keep::All);
            match (once, again) {
                (Ok(once), Ok(again)) => {
                    // NaN is not equal to itself: what is printed is.
                    assert_eq!(format!("{once:?}"), format!("{again:?}"));
                    for table in &once.tables {
                        assert!(table.columns.iter().all(|c| c.cells.len() == table.rows), "{:?}", once.format);
                    }
                }
                (Err(once), Err(again)) => {
                    assert!(matches!(once, IngestError::Unusable { .. }), "{once}");
                    assert_eq!(once.to_string(), again.to_string());
                }
                _ => panic!("read once, refused the other time"),
            }
        }
    }
}
