//! Raw logs as delimited text: every layout and every malformation, with the places that are told.

// In a test a panic is how a failure is told; equality of floats is asked where it must be exact.
#![allow(clippy::unwrap_used, clippy::panic, clippy::float_cmp)]

use std::fmt::Write;

use pneuval_ingest::IngestError;
use pneuval_ingest::finding::{Finding, FindingKind, Severity, clock_findings};
use pneuval_ingest::formats::csv::{
    Comment, Comments, CsvOptions, Decimal, Encoding, Header, TextLog, WriteOptions, parse_number, read, write,
};
use pneuval_ingest::formats::{Format, detect};
use pneuval_ingest::raw::RawFile;
use pneuval_ingest::recording::{Cells, Column};

const AUTO: CsvOptions =
    CsvOptions { delimiter: None, decimal: None, header: Header::Auto, skip_lines: None, comments: None };

fn log(text: impl AsRef<[u8]>) -> TextLog {
    // Whatever is read here as delimited text is told as such, too.
    let raw = RawFile::of_bytes("r.csv", text.as_ref());
    assert_eq!(detect(&raw).unwrap(), Format::Csv, "{}", String::from_utf8_lossy(text.as_ref()));
    read("r.csv", text.as_ref(), &AUTO).unwrap()
}

fn numbers(log: &TextLog, column: usize) -> &[f64] {
    log.columns[column].cells.numbers().unwrap()
}

fn names(log: &TextLog) -> Vec<&str> {
    log.columns.iter().map(|c| c.name.as_str()).collect()
}

fn units(log: &TextLog) -> Vec<Option<&str>> {
    log.columns.iter().map(|c| c.unit.as_deref()).collect()
}

/// Kind, severity, count and the lines of the spans.
type Told = (FindingKind, Severity, usize, Vec<(usize, usize)>);

fn told(log: &TextLog) -> Vec<Told> {
    let lines = |f: &Finding| f.spans.iter().map(|s| (s.first_line, s.last_line)).collect();
    log.findings.iter().map(|f| (f.kind, f.severity, f.count, lines(f))).collect()
}

fn error(text: impl AsRef<[u8]>, options: &CsvOptions) -> String {
    match read("r.csv", text.as_ref(), options) {
        Err(error @ IngestError::Unusable { .. }) => error.to_string(),
        Err(other) => panic!("another error: {other}"),
        Ok(log) => panic!("read without error: {:?}", log.layout.reasons),
    }
}

#[test]
fn tab_separated_voltages_without_header() {
    let log =
        log("0.000\t3.427\t-0.009\t149.226\r\n11.000\t3.426\t0.004\t149.180\r\n22.000\t3.426\t0.000\t149.180\r\n");
    assert_eq!((log.rows, log.columns.len(), log.layout.delimiter), (3, 4, b'\t'));
    assert_eq!(names(&log), ["column 1", "column 2", "column 3", "column 4"]);
    assert_eq!(numbers(&log, 2), [-0.009, 0.004, 0.0]);
    assert_eq!((log.line_of(0), log.line_of(2)), (1, 3));
    assert_eq!(log.findings, []);
    assert!(log.metadata.is_empty());
}

#[test]
fn a_header_and_a_column_of_words() {
    let log = log("config,p,x\nA10-0,0.0,0.0\nA10-0,50.0,2.293572903\nB20-1,0.0,-1.5\n");
    assert_eq!(names(&log), ["config", "p", "x"]);
    assert_eq!(log.columns[0].cells, Cells::Text(["A10-0", "A10-0", "B20-1"].map(str::to_owned).to_vec()));
    assert_eq!(numbers(&log, 2), [0.0, 2.293_572_903, -1.5]);
    assert_eq!(log.findings, []);
}

#[test]
fn metadata_before_the_table_are_kept_as_they_stand() {
    let text = "PARAMETER;INFO;URL;;\nThickness (mm);3;;;\nMachine;Pull  12;;;\nLab;A, B, C;;;\n;;;;\n\
                Time (s);True Strain;True Stress (MPa);Strain;Stress (MPa)\n\
                0.2;0.0436;0.0097;0.0446;0.0093\n0.3;0.0657;0.0193;0.06795;0.0181\n";
    let log = log(text);
    assert_eq!(log.metadata.len(), 5);
    assert_eq!(log.metadata[2], "Machine;Pull  12;;;");
    assert_eq!((log.layout.names_line, log.layout.data_line), (Some(6), 7));
    assert_eq!(units(&log), [Some("s"), None, Some("MPa"), None, Some("MPa")]);
    assert_eq!(numbers(&log, 4), [0.0093, 0.0181]);
    assert_eq!((log.line_of(0), log.findings.len()), (7, 0));
}

#[test]
fn decimal_commas_with_names_and_units() {
    for (text, delimiter) in [
        ("Zeit;Druck\ns;kPa\n0,00;1,5\n0,01;-2,25\n", b';'),
        ("Zeit\tDruck\n[s]\t[kPa]\n0,00\t1,5\n0,01\t-2,25\n", b'\t'),
    ] {
        let log = log(text);
        assert_eq!((log.layout.delimiter, log.layout.decimal), (delimiter, Decimal::Comma));
        assert_eq!(names(&log), ["Zeit", "Druck"]);
        assert_eq!(units(&log), [Some("s"), Some("kPa")]);
        assert_eq!(numbers(&log, 1), [1.5, -2.25]);
        assert_eq!((log.layout.units_line, log.line_of(0)), (Some(2), 3));
    }
}

#[test]
fn one_column_of_decimal_commas_under_one_name() {
    let log = log("Druck\n1,5\n1,25\n");
    assert_eq!((log.columns.len(), numbers(&log, 0)), (1, &[1.5, 1.25][..]));
}

#[test]
fn blanks_bars_and_commas_part_columns() {
    for (text, delimiter) in [
        ("  0.0   1.5e+00\n  0.1  -2.5e+00\n", b' '),
        ("0.0|1.5\n0.1|-2.5\n", b'|'),
        ("0.0, 1.5\n0.1, -2.5\n", b','),
        ("0.0,1.5,\n0.1,-2.5,\n", b','),
        ("\"0.0\",\"1.5\"\n\"0.1\",\"-2.5\"\n", b','),
        ("0,1.5\n0.1,-25d-1\n", b','),
    ] {
        let log = log(text);
        assert_eq!((log.layout.delimiter, log.columns.len()), (delimiter, 2), "{text}");
        assert_eq!((numbers(&log, 1), log.findings.len()), (&[1.5, -2.5][..], 0), "{text}");
    }
}

#[test]
fn the_layout_says_how_it_was_found_out() {
    let log = log("# rig 3\ntime_s;p\n0,5;1\n1,0;2\n");
    let layout = &log.layout;
    assert_eq!((layout.comment, log.metadata.as_slice()), (Some(Comment::Hash), &["# rig 3".to_owned()][..]));
    let reasons = layout.reasons.join("\n");
    assert!(reasons.contains("`;` between cells and a decimal comma"), "{reasons}");
    assert!(reasons.contains("line 2 holds the names"), "{reasons}");
    assert!(reasons.contains("data begin on line 3;"), "{reasons}");
}

#[test]
fn what_is_asked_for_is_not_second_guessed() {
    let options = CsvOptions { delimiter: Some(b';'), decimal: Some(Decimal::Point), ..AUTO };
    let log = read("r.csv", b"0.5;1,5\n1.0;2,5\n1.5;2.5\n", &options).unwrap();
    // Two of three cells are text under a decimal point.
    assert_eq!(log.columns[1].cells, Cells::Text(["1,5", "2,5", "2.5"].map(str::to_owned).to_vec()));

    let options = CsvOptions { skip_lines: Some(2), ..AUTO };
    let log = read("r.csv", b"1,2\n3,4\n5,6\n7,8\n", &options).unwrap();
    assert_eq!((log.rows, log.metadata.as_slice()), (2, &["1,2".to_owned(), "3,4".to_owned()][..]));

    let options = CsvOptions { header: Header::None, ..AUTO };
    let log = read("r.csv", b"t,p\n1,2\n3,4\n", &options).unwrap();
    assert_eq!((names(&log), log.metadata.as_slice()), (vec!["column 1", "column 2"], &["t,p".to_owned()][..]));

    let options = CsvOptions { header: Header::Names, ..AUTO };
    let log = read("r.csv", b"1,2\n3,4\n5,6\n", &options).unwrap();
    assert_eq!((names(&log), numbers(&log, 0)), (vec!["1", "2"], &[3.0, 5.0][..]));

    let options = CsvOptions { header: Header::NamesAndUnits, ..AUTO };
    let log = read("r.csv", b"t,p\nticks,counts\n3,4\n5,6\n", &options).unwrap();
    assert_eq!((names(&log), units(&log)), (vec!["t", "p"], vec![Some("ticks"), Some("counts")]));
    let message = error("3,4\n", &options);
    assert!(message.starts_with("r.csv:1\n  expected: a row of names and a row of units"), "{message}");

    let options = CsvOptions { comments: Some(Comments::None), header: Header::Names, ..AUTO };
    let log = read("r.csv", b"#,% open\n1,2\n3,4\n", &options).unwrap();
    assert_eq!(names(&log), ["#", "% open"]);
}

#[test]
fn units_are_taken_from_names_only_where_known() {
    let log = log(
        "pressure (kPa),pressure [kPa],pressure / kPa,pressure_kPa,angle_deg,p_min,flow_in,x (raw),pressure_gauge_pa\n\
         1,2,3,4,5,6,7,8,9\n",
    );
    let kpa = Some("kPa");
    assert_eq!(units(&log), [kpa, kpa, kpa, kpa, Some("deg"), None, None, None, Some("pa")]);
    assert!(log.layout.reasons.iter().any(|r| r == "the unit kPa of column pressure_kPa is taken from its name"));
}

#[test]
fn names_are_trimmed_completed_and_made_unique() {
    let log = log(" p , p,,\"a, b\"\n1,2,3,4\n5,6,7,8\n");
    assert_eq!(names(&log), ["p", "p (2)", "column 3", "a, b"]);
}

#[test]
fn a_table_is_not_looked_for_behind_a_hundred_thousand_lines_unless_they_are_skipped() {
    let text = |lines: usize| "a\n".repeat(lines) + "t,p\n0,1\n1,2\n";
    let read = |lines: usize, skip_lines: Option<usize>| {
        read("r.csv", text(lines).as_bytes(), &CsvOptions { skip_lines, ..AUTO })
    };
    assert_eq!(read(99_000, None).unwrap().rows, 2);
    let refused = read(100_000, None).unwrap_err().to_string();
    assert!(refused.contains("no line of numbers in the first 100000 lines; the first line is `a`"), "{refused}");
    let log = read(250_000, Some(250_000)).unwrap();
    assert_eq!((log.rows, log.line_of(0), names(&log)), (2, 250_002, vec!["t", "p"]));
    assert!(read(350_000, Some(250_000)).is_err());
}

#[test]
fn names_in_the_comment_above_the_data() {
    let log = log("% rig 3\n% time p\n0.1 5\n0.2 6\n");
    assert_eq!((names(&log), log.metadata.as_slice()), (vec!["time", "p"], &["% rig 3".to_owned()][..]));
}

#[test]
fn byte_order_marks_and_sixteen_bit_text() {
    let text = "t;Δp\n1,5;2\n2,5;3\n";
    let with_mark = format!("\u{feff}{text}");
    let wide: Vec<u8> = with_mark.encode_utf16().flat_map(u16::to_le_bytes).collect();
    let swapped: Vec<u8> = with_mark.encode_utf16().flat_map(u16::to_be_bytes).collect();
    for (bytes, encoding) in
        [(with_mark.into_bytes(), Encoding::Utf8Bom), (wide, Encoding::Utf16Le), (swapped, Encoding::Utf16Be)]
    {
        let log = log(bytes);
        assert_eq!((log.layout.encoding, names(&log), log.findings.len()), (encoding, vec!["t", "Δp"], 0));
        assert_eq!(numbers(&log, 0), [1.5, 2.5]);
    }
}

#[test]
fn bytes_that_are_not_utf8_are_latin1_and_told() {
    let log = log(b"t,angle (\xb0),\xc2\xb5\n1,2,3\n4,5,6\n");
    assert_eq!(names(&log)[1], "angle (°)");
    assert_eq!(units(&log)[1], Some("°"));
    // The column's name is UTF-8, which no other cell of the line makes Latin-1.
    assert_eq!(names(&log)[2], "µ");
    assert_eq!(told(&log), [(FindingKind::Encoding, Severity::Note, 1, vec![(1, 1)])]);
    assert_eq!(log.layout.encoding, Encoding::Latin1);
}

#[test]
fn every_line_end_is_one_line_end() {
    for end in ["\n", "\r\n", "\r", "\r\r\n"] {
        let log = log(["t,p", "1,2", "", "3,4", ""].join(end));
        assert_eq!((log.rows, log.line_of(0), log.line_of(1)), (2, 2, 4), "{end:?}");
        assert_eq!(log.findings, []);
    }
}

#[test]
fn comments_and_blank_lines_are_skipped_and_comments_counted() {
    let log = log("t,p\n1,2\n# valve open\n\n3,4\n,\n// end\n5,6\n");
    assert_eq!(log.rows, 3);
    assert_eq!([0, 1, 2].map(|row| log.line_of(row)), [2, 5, 8]);
    assert_eq!(told(&log), [(FindingKind::CommentLine, Severity::Note, 2, vec![(3, 3), (7, 7)])]);
    assert_eq!(log.findings[0].text, "2 comments among the data (line 3: `# valve open`; line 7: `// end`)");
    assert_eq!(log.findings[0].spans[0].first_sample, 1);
}

#[test]
fn text_in_a_column_of_numbers_is_a_hole() {
    let log = log("t,p\n0,1\n1,ERR\n2,1'000\n3,4\n4,1e999\n5,6\n");
    let p = numbers(&log, 1);
    assert!(p[1].is_nan() && p[2].is_nan() && p[4].is_nan() && p[5] == 6.0);
    assert_eq!(told(&log), [(FindingKind::NonNumericCell, Severity::Excluded, 3, vec![(3, 4), (6, 6)])]);
    let finding = &log.findings[0];
    assert_eq!(finding.channel.as_deref(), Some("p"));
    assert_eq!(
        finding.text,
        "column `p`: 3 cells are not numbers (line 3: `ERR`; line 4: `1'000`; line 6: `1e999`); left as holes"
    );
    assert_eq!((finding.spans[0].first_sample, finding.spans[0].last_sample), (1, 2));
}

#[test]
fn words_for_no_value_and_empty_cells_are_holes_apart() {
    let log = log("t,p\n0,1\n1,NaN\n2,\n3,--\n4,n/a\n5,-Inf\n6,7\n7,8\n8,9\n");
    assert_eq!(numbers(&log, 1).iter().filter(|p| p.is_nan()).count(), 5);
    assert_eq!(
        told(&log),
        [
            (FindingKind::NoValue, Severity::Excluded, 4, vec![(3, 3), (5, 7)]),
            (FindingKind::EmptyCell, Severity::Note, 1, vec![(4, 4)]),
        ]
    );
    assert_eq!(log.findings[1].text, "column `p`: 1 cell is empty (line 4); left as holes");
}

#[test]
fn a_line_of_words_keeps_the_place_of_its_sample() {
    // The clock may be the count of samples.
    let log = log("1.0\n2.0\nERR\n4.0\n");
    assert_eq!((log.rows, numbers(&log, 0)[3]), (4, 4.0));
    assert_eq!(told(&log), [(FindingKind::NonNumericCell, Severity::Excluded, 1, vec![(3, 3)])]);
}

#[test]
fn a_ragged_line_keeps_what_can_be_trusted() {
    let log = log("t,p,d\n0,1,2\n1,2\n2,3,4,5\n3,4,5,\n4,5,6\n");
    assert_eq!(log.rows, 5);
    // A line cut short still holds its first cells; of a line with a cell too many (a decimal
    // comma among commas, say) nobody knows which cell belongs where.
    assert_eq!((numbers(&log, 0)[1], numbers(&log, 1)[1]), (1.0, 2.0));
    assert!(numbers(&log, 2)[1].is_nan());
    assert!((0..3).all(|column| numbers(&log, column)[2].is_nan()));
    assert_eq!(numbers(&log, 2)[3..], [5.0, 6.0]);
    assert_eq!(told(&log)[0], (FindingKind::RaggedLine, Severity::Excluded, 2, vec![(3, 4)]));
    let text = &log.findings[0].text;
    assert!(text.starts_with("2 lines do not hold 3 cells (line 3: 2 cells; line 4: 4 cells)"), "{text}");
}

#[test]
fn a_first_sample_without_a_value_is_not_the_names() {
    for (first, kind) in [
        ("ERR,ERR", FindingKind::NonNumericCell),
        ("ERR,1.0", FindingKind::NonNumericCell),
        ("NaN,NaN", FindingKind::NoValue),
        ("nan,OVLD", FindingKind::NonNumericCell),
    ] {
        for header in [Header::Auto, Header::Names] {
            let text = format!("time,p\n{first}\n0.1,1.5\n0.2,1.6\n0.3,1.7\n");
            let log = read("r.csv", text.as_bytes(), &CsvOptions { header, ..AUTO }).unwrap();
            assert_eq!((log.rows, names(&log)), (4, vec!["time", "p"]), "{first}, {header:?}");
            assert!(numbers(&log, 0)[0].is_nan() && numbers(&log, 0)[1] == 0.1, "{first}");
            assert!(told(&log).iter().any(|(k, _, _, at)| *k == kind && at[0].0 == 2), "{first}: {:?}", told(&log));
        }
        let log = self::log(format!("{first}\n0.1,1.5\n0.2,1.6\n"));
        assert_eq!(log.rows, if first == "ERR,ERR" || first == "nan,OVLD" { 2 } else { 3 }, "{first}");
    }
    // One column may well be named so.
    let log = log("t,error\n0,1\n1,2\n");
    assert_eq!(names(&log), ["t", "error"]);
    assert_eq!(names(&self::log("error\n1\n2\n")), ["error"]);
    // Units stay units.
    assert_eq!(self::log("t,p\ns,kPa\n-,ERR\n0,1\n1,2\n").rows, 3);
}

#[test]
fn a_first_line_that_began_before_the_log_is_left_out() {
    let log = log("27\t149.2\n11.0\t3.426\t149.1\n22.0\t3.426\t149.1\n");
    assert_eq!((log.rows, log.line_of(0), log.metadata[0].as_str()), (2, 2, "27\t149.2"));
    assert_eq!(told(&log), [(FindingKind::SkippedLine, Severity::Excluded, 1, vec![(1, 1)])]);
}

#[test]
fn a_lone_line_of_numbers_before_the_names_is_metadata_and_told() {
    let log = log("100,2\ntime,p\n0,1\n1,2\n");
    assert_eq!((names(&log), log.metadata.as_slice()), (vec!["time", "p"], &["100,2".to_owned()][..]));
    assert_eq!(told(&log), [(FindingKind::SkippedLine, Severity::Excluded, 1, vec![(1, 1)])]);
}

#[test]
fn a_file_that_ends_within_a_line_has_lost_data() {
    let log = log("t,p,d\n0,1,2\n1,2,3\n2,3.4");
    assert_eq!(log.rows, 3);
    // `3.4` may be the beginning of `3.47`.
    assert!(numbers(&log, 0)[2] == 2.0 && numbers(&log, 1)[2].is_nan() && numbers(&log, 2)[2].is_nan());
    assert_eq!(told(&log)[0], (FindingKind::Truncated, Severity::Lost, 1, vec![(4, 4)]));

    let log = self::log("t,p,d\n0,1,2\n1,2,3\n2,3.4,");
    assert_eq!(numbers(&log, 1)[2], 3.4);
    assert_eq!(told(&log)[0].0, FindingKind::Truncated);

    let log = self::log("t,p,d\n0,1,2\n1,2,3\n2");
    assert_eq!((log.rows, told(&log)[0].1), (2, Severity::Lost));
}

#[test]
fn a_whole_last_line_without_line_end_is_noted() {
    let log = log("t,p\n0,1\n1,2");
    assert_eq!(numbers(&log, 1), [1.0, 2.0]);
    assert_eq!(told(&log), [(FindingKind::NoLineEnd, Severity::Note, 1, vec![(3, 3)])]);
}

#[test]
fn zero_bytes_at_the_end_are_lost_data() {
    let log = log(b"t,p\n0,1\n1,2\n\0\0\0\0\0\0");
    assert_eq!(numbers(&log, 1), [1.0, 2.0]);
    assert_eq!(told(&log)[0].0, FindingKind::Truncated);
    assert_eq!(log.findings[0].severity, Severity::Lost);
}

#[test]
fn text_after_the_last_sample_is_a_trailer() {
    let log = log("t,p\n0,1\n1,2\n\nEnd of test\nOperator: X, Y\nNotes");
    assert_eq!(log.rows, 2);
    let trailer = (FindingKind::Trailer, Severity::Note, 3, vec![(5, 7)]);
    assert_eq!(told(&log), [trailer]);
    assert!(log.findings[0].text.contains("line 5: `End of test`"), "{}", log.findings[0].text);
}

#[test]
fn a_header_in_the_middle_is_told() {
    let log = log("t,p\ns,kPa\n0,1\n1,2\nt,p\ns,kPa\n0,1\npump off\n1,2\n");
    assert_eq!((log.rows, log.line_of(2), log.line_of(3)), (4, 7, 9));
    assert_eq!(
        told(&log),
        [
            (FindingKind::SkippedLine, Severity::Excluded, 1, vec![(8, 8)]),
            (FindingKind::RepeatedHeader, Severity::Note, 2, vec![(5, 6)]),
        ]
    );
}

#[test]
fn a_header_that_does_not_fit_gives_no_name_to_the_wrong_column() {
    let log = log("t,p\n0,1,2\n1,2,3\n");
    assert_eq!(names(&log), ["column 1", "column 2", "column 3"]);
    assert_eq!(told(&log)[0], (FindingKind::HeaderMismatch, Severity::Note, 1, vec![(1, 1)]));
    // A `Comment` column of which no line holds anything.
    let log = self::log("t,p,Comment\n0,1\n1,2\n2,3,4\n3,4\n");
    assert_eq!((names(&log), log.layout.cells_per_line), (vec!["t", "p", "Comment"], 2));
    assert_eq!(numbers(&log, 2)[2], 4.0);
    assert_eq!(told(&log), [(FindingKind::HeaderMismatch, Severity::Note, 1, vec![(1, 1)])]);
}

#[test]
fn a_header_that_runs_into_the_first_sample_gives_names_and_sample() {
    let glued = |severity| (FindingKind::HeaderGlued, severity, 1, vec![(1, 1)]);
    for end in ["\n", "\r\r\n"] {
        let log = log(["time,p,flex0.00,1.2,3", "0.01,1.3,4", "0.02,1.4,5", ""].join(end));
        assert_eq!((log.rows, names(&log)), (3, vec!["time", "p", "flex"]));
        assert_eq!((numbers(&log, 0), numbers(&log, 2)), (&[0.0, 0.01, 0.02][..], &[3.0, 4.0, 5.0][..]));
        assert_eq!([0, 1, 2].map(|row| log.line_of(row)), [1, 2, 3]);
        assert_eq!(told(&log), [glued(Severity::Note)]);
        assert_eq!(
            log.findings[0].text,
            "line 1 holds the names and, without a line end, the first sample: \
             `flex0.00` is read as the name `flex` and the number `0.00`"
        );
    }
    // Half a line before it, decimal commas, units, a sign, a unit in Latin-1.
    let log = self::log("3,4\nt [s];p [kPa]-0,50;1,5\n0,00;1,6\n0,50;1,7\n");
    assert_eq!((names(&log), numbers(&log, 0)), (vec!["t [s]", "p [kPa]"], &[-0.5, 0.0, 0.5][..]));
    assert_eq!((units(&log), log.metadata.as_slice()), (vec![Some("s"), Some("kPa")], &["3,4".to_owned()][..]));
    let log = self::log(b"t,angle (\xb0)1520,3\n1530,4\n1540,5\n");
    assert_eq!((names(&log)[1], numbers(&log, 0)[0]), ("angle (°)", 1520.0));
    assert_eq!(told(&log).iter().map(|t| t.0).collect::<Vec<_>>(), [FindingKind::Encoding, FindingKind::HeaderGlued]);
    let log = self::log("t,p\ns,kPa0.5,1.2\n1.0,1.3\n1.5,1.4\n");
    assert_eq!((names(&log), units(&log), log.rows), (vec!["t", "p"], vec![Some("s"), Some("kPa")], 3));
}

#[test]
fn a_sample_is_lost_where_the_end_of_the_last_name_is_not_certain() {
    for text in [
        // `p1` and 0, or `p` and 10?
        "t,p10,5\n1,5\n2,5\n",
        // A sign belongs to the number, but a name may end in one as well.
        "t,p_1-0.5,5\n0.0,5\n0.5,5\n",
        // A stamp behind the one that follows: rather a count of channels.
        "Rate,Ch7,100\n0,1\n1,2\n2,3\n",
    ] {
        let log = log(text);
        assert_eq!((log.line_of(0), names(&log)[1]), (2, "column 2"), "{text}");
        assert_eq!(told(&log), [(FindingKind::HeaderGlued, Severity::Excluded, 1, vec![(1, 1)])], "{text}");
    }
    // Names and nothing else, however many.
    let log = log("a,b,c1,d,e\n1,2,3\n4,5,6\n");
    assert_eq!(told(&log)[0].0, FindingKind::HeaderMismatch);
    assert_eq!(self::log("t,p1\n0,1\n1,2\n").findings, []);
}

#[test]
fn names_with_blanks_between_blanks() {
    let log = log("Time (s)  Pressure (kPa)\n 0.0  1.0\n 0.1  1.2\n");
    assert_eq!((names(&log), units(&log)), (vec!["Time (s)", "Pressure (kPa)"], vec![Some("s"), Some("kPa")]));
    let log = self::log("Time (s) Pressure (kPa)\n 0.0  1.0\n 0.1  1.2\n");
    assert_eq!((names(&log), told(&log)[0].0), (vec!["column 1", "column 2"], FindingKind::HeaderMismatch));
}

#[test]
fn text_before_the_table_does_not_choose_the_delimiter() {
    let log = log("sensor ready\nV: 1.2\n0\t512\n10\t513\n20\t514\n");
    assert_eq!((log.layout.delimiter, log.metadata.len(), log.rows), (b'\t', 2, 3));
}

#[test]
fn quoted_cells_hold_delimiters_quotes_and_line_ends() {
    let log = log("t,note\n0,\"a, \"\"b\"\"\"\n1,\"two\nlines\"\n2,c\n");
    assert_eq!(log.columns[1].cells.text().unwrap(), ["a, \"b\"", "two\nlines", "c"]);
    assert_eq!([0, 1, 2].map(|row| log.line_of(row)), [2, 3, 5]);
    // A quote that nothing closes costs one cell, not the rest of the file.
    let log = self::log("t,p\n0,1\n1,\"2\n2,3\n3,4\n");
    assert_eq!((log.rows, told(&log)[0].0), (4, FindingKind::NonNumericCell));
}

#[test]
fn kinds_are_those_of_the_whole_column() {
    // Beyond the first lines that are looked at.
    let text = "t,state\n".to_owned() + &"0.5,1\n".repeat(20_000) + &"0.5,open\n".repeat(40_000);
    let log = log(text);
    assert_eq!(log.columns[1].cells.text().map(|cells| cells[59_999].as_str()), Some("open"));
    assert_eq!((log.rows, log.findings.len()), (60_000, 0));
}

#[test]
fn what_holds_no_numbers_is_unusable() {
    for (text, found) in [
        ("", "nothing but blank lines"),
        ("\n\r\n", "nothing but blank lines"),
        ("hello\nworld\n", "the first line is `hello`"),
        ("time,pressure\n", "the first line is `time,pressure`"),
        ("# 1,2\n# 3,4\n", "no line of numbers"),
    ] {
        let message = error(text, &AUTO);
        assert!(message.starts_with("r.csv\n  expected: a table of numbers") && message.contains(found), "{message}");
    }
    let message = error([0x50, 0x4b, 3, 4, 0, 0, 7, 0xff, 0, 0, 9, 9], &AUTO);
    assert!(message.contains("zero bytes"), "{message}");
}

#[test]
fn sizes_are_refused_before_they_cost_memory() {
    let wide = "1,".repeat(5_000) + "1\n";
    assert!(error(wide, &AUTO).contains("a table of numbers"));
    let names = "a,".repeat(5_000) + "b\n1,2\n3,4\n";
    assert!(error(names, &AUTO).contains("at most 4096 columns"));
    let long = "1,2\n3,".to_owned() + &"4".repeat(2 << 20) + "\n";
    let message = error(long, &AUTO);
    assert!(message.starts_with("r.csv:2\n  expected: lines of at most 1048576 bytes"), "{message}");
    let long = "1,2\n".repeat(50_000) + "3," + &"4".repeat(2 << 20) + "\n";
    assert!(error(long, &AUTO).starts_with("r.csv:50001\n"));
    // A wide header over a narrow table would be 4096 holes per line.
    let holes = "a,".repeat(4_000) + "b\n" + &"1,2\n".repeat(100_000);
    assert!(error(holes, &AUTO).contains("cells, rows times columns"));
}

#[test]
fn a_column_of_stamps_feeds_the_clock() {
    let log = log("ms\tV\n0\t1\n273\t2\n283\t3\n293\t4\nnan\t5\n303\t6\n302\t7\n313\t8\n");
    let seconds: Vec<f64> = numbers(&log, 0).iter().map(|ms| ms / 1e3).collect();
    let findings = clock_findings("r.csv", "ms", &seconds, Some(&log.lines));
    let kinds: Vec<FindingKind> = findings.iter().map(|f| f.kind).collect();
    assert_eq!(kinds, [FindingKind::NoStamp, FindingKind::TimeReversed, FindingKind::Gap]);
    assert!(findings[0].text.contains("sample 4 (line 6)"), "{}", findings[0].text);
    assert!(findings[1].text.contains("sample 6 (line 8)"), "{}", findings[1].text);
    assert!(findings[2].text.contains("273 ms from 0 s to 0.273 s"), "{}", findings[2].text);
}

/// A sequence that looks random and is the same on every run.
fn random(state: &mut u64) -> u64 {
    *state ^= *state << 13;
    *state ^= *state >> 7;
    *state ^= *state << 17;
    *state
}

#[test]
fn what_is_written_reads_back_bit_for_bit() {
    let mut state = 0x2545_f491_4f6c_dd1d;
    let mut value = || {
        let bits = random(&mut state);
        match bits % 4 {
            0 => f64::from_bits(random(&mut state)),
            1 => (random(&mut state) % 100_000) as f64 / 1e3,
            2 => -((random(&mut state) % 1_000_000_007) as f64) / 7.0,
            _ => (random(&mut state) % 1_000) as f64,
        }
    };
    for (delimiter, decimal) in [
        (b',', Decimal::Point),
        (b'\t', Decimal::Point),
        (b'\t', Decimal::Comma),
        (b';', Decimal::Comma),
        (b' ', Decimal::Point),
        (b'|', Decimal::Comma),
    ] {
        for (names, units, empty_holes) in
            [(false, false, false), (true, false, false), (true, true, false), (true, true, true)]
        {
            let mut columns: Vec<Column> = (1..=5)
                .map(|i| {
                    let name = if names { format!("p {i}") } else { format!("column {i}") };
                    Column::new(&name, units.then_some("kPa"), Cells::Numbers((0..400).map(|_| value()).collect()))
                })
                .collect();
            let words = ["a", "b, \"c\"", " d;|e\t", "#f", "", "two\nlines"];
            columns[4].cells = Cells::Text((0..400).map(|i| words[i % words.len()].to_owned()).collect());
            let text = write(&columns, WriteOptions { delimiter, decimal, names, units, empty_holes });
            let log = log(&text);
            assert_eq!((log.layout.delimiter, log.layout.decimal), (delimiter, decimal), "{}", &text[..200]);
            for (written, read) in columns.iter().zip(&log.columns) {
                assert_eq!((&written.name, &written.unit), (&read.name, &read.unit));
                match (&written.cells, &read.cells) {
                    (Cells::Numbers(written), Cells::Numbers(read)) => {
                        // What is not finite comes back as a hole.
                        let bits = |v: &f64| if v.is_finite() { v.to_bits() } else { u64::MAX };
                        assert!(written.iter().map(bits).eq(read.iter().map(bits)));
                    }
                    (written, read) => assert_eq!(written, read),
                }
            }
        }
    }
}

#[test]
fn cells_are_those_of_the_csv_crate() {
    let mut state = 0x1234_5678_9abc_def1;
    let pieces: [&str; 8] = ["7", "1.5", "a", "\"x,y\"", "\"q\"\"q\"", "\"l\nl\"", "", "-3e2"];
    for _ in 0..300 {
        let mut text = "t,b,c,d\n".to_owned();
        for row in 0..20 {
            let cell = |state: &mut u64| pieces[usize::try_from(random(state) % 8).unwrap()];
            writeln!(text, "{row},{},{},k", cell(&mut state), cell(&mut state)).unwrap();
        }
        let log = log(&text);
        let records: Vec<csv::StringRecord> =
            csv::Reader::from_reader(text.as_bytes()).records().map(Result::unwrap).collect();
        assert_eq!(log.rows, records.len(), "{text}");
        for (row, record) in records.iter().enumerate() {
            assert_eq!(u64::try_from(log.line_of(row)).ok(), record.position().map(csv::Position::line), "{text}");
            for (column, cell) in record.iter().enumerate() {
                match &log.columns[column].cells {
                    Cells::Text(cells) => assert_eq!(cells[row], cell, "{text}"),
                    Cells::Numbers(cells) => {
                        let number = parse_number(cell.as_bytes(), Decimal::Point).unwrap_or(f64::NAN);
                        assert_eq!(cells[row].to_bits(), number.to_bits(), "{text}");
                    }
                    Cells::NotKept => panic!("{text}"),
                }
            }
        }
    }
}

#[test]
fn damage_never_panics_and_the_same_bytes_read_the_same() {
    let base = b"t;p;n\ns;kPa;-\n0,1;2,5;\"a;b\"\n0,2;NaN;c\r\n# x\n0,3;ERR;\"d\n0,4;2;e\n";
    let mut state = 0x0dd0_feed_5eed_cafe;
    for _ in 0..4_000 {
        let mut bytes = base.to_vec();
        for _ in 0..=random(&mut state) % 4 {
            let at = usize::try_from(random(&mut state)).unwrap() % bytes.len().max(1);
            if bytes.is_empty() {
                break;
            }
            match random(&mut state) % 4 {
                0 => bytes[at] = random(&mut state).to_le_bytes()[0],
                1 => bytes[at] = b"\n\r\";,\t #0.-e"[usize::try_from(random(&mut state)).unwrap() % 12],
                2 => drop(bytes.remove(at)),
                _ => bytes.truncate(at.max(1)),
            }
        }
        let (a, b) = (read("r.csv", &bytes, &AUTO), read("r.csv", &bytes, &AUTO));
        if let Ok(log) = &a {
            assert!(log.columns.iter().all(|c| c.cells.len() == log.rows), "{bytes:?}");
            assert_eq!(log.lines.rows(), log.rows);
        }
        assert_eq!(format!("{a:?}"), format!("{b:?}"));
    }
}
