//! A log is read alike whatever pieces it comes in, and whether its columns are kept or not.

use std::fmt::Write as _;

use super::*;
use crate::recording::ColumnRef;

fn read_in(bytes: &[u8], keep: Keep, chunk: usize) -> String {
    // NaN is not equal to itself; as text it is.
    format!("{:?}", read_log(&RawFile::of_bytes("r.csv", bytes), &CsvOptions::default(), keep, chunk))
}

/// Logs in which much depends on what stands behind a border.
fn logs() -> Vec<Vec<u8>> {
    let wide = |text: &str| -> Vec<u8> { text.encode_utf16().flat_map(u16::to_le_bytes).collect() };
    vec![
        b"# rig 3\r\r\nt,p\r\r\n0.0,1\r\r\n0.1,2\r\r\n\r\r\n0.2,3\r\r\n".to_vec(),
        b"t;p;n\ns;kPa;-\n0,1;2,5;\"a;\"\"b\"\n0,2;NaN;\"c\r\n\nd\" \n# x\n0,3;ERR;\"d\n0,4;2;e\nend;of\ntest".to_vec(),
        b"t,p\n0,1\n1,2\n\0\0\n2,3\0\n\0\0\0\0\0".to_vec(),
        b"27\t149\n11.0\t3.426\t149.1\n22.0\t3.426\t149.1\nERR\tERR\tERR\r33.0\t3.427\t-\r\rt\tp\td\r44\t3.4\t1"
            .to_vec(),
        b"\xef\xbb\xbft,angle (\xb0)\n0,1\n1,\xb5\n2,3\n".to_vec(),
        wide("\u{feff}t;p;😀\r\n1,5;2;3\r\n\"a\r\nb\";3;4\r\n2,5;°;5\r\n\0\0"),
        b"garbage,1\ntime,p,flex0.00,1.2,3\n0.01,1.3,4\n0.02,1.4,5\n".to_vec(),
        b"1,2\r3,4\r\r\n5,6,7\r\n8,\r9,10".to_vec(),
    ]
}

#[test]
fn a_log_cut_at_every_byte_reads_alike_through_windows_of_every_size() {
    for log in logs() {
        for cut in 0..=log.len() {
            let whole = read_in(&log[..cut], Keep::All, CHUNK);
            for chunk in [1, 2, 3, 5, 8, 13, 21, 34] {
                assert_eq!(read_in(&log[..cut], Keep::All, chunk), whole, "{chunk} {:?}", log[..cut].escape_ascii());
            }
        }
    }
}

#[test]
fn a_log_of_many_windows_reads_alike_through_each_of_them() {
    let mut log = "t,p\n".to_owned();
    for i in 0..3_000 {
        let odd = match i % 97 {
            13 => "\n\"x\ny\",ERR",
            40 => "\r\nt,p",
            66 => "\r\r\nERR,ERR",
            _ => "",
        };
        writeln!(log, "{},{}{odd}", f64::from(i) / 100.0, i * i % 1_009).unwrap();
    }
    let whole = read_in(log.as_bytes(), Keep::All, CHUNK);
    assert!(whole.contains("rows: 3062"), "{}", &whole[..200]);
    for chunk in [64, 1_000, 4_099] {
        assert_eq!(read_in(log.as_bytes(), Keep::All, chunk), whole);
    }
}

#[test]
fn what_is_not_kept_is_looked_at_all_the_same() {
    let log = b"t,state,p\n0,open,1\n1,shut,ERR\n2,open,3\n";
    let raw = RawFile::of_bytes("r.csv", log);
    let of = |keep| read_raw(&raw, &CsvOptions::default(), keep).unwrap();
    let (all, none) = (of(Keep::All), of(Keep::Nothing));
    assert_eq!((&all.findings, &all.reasons), (&none.findings, &none.reasons));
    for (kept, watched) in all.tables[0].columns.iter().zip(&none.tables[0].columns) {
        assert_eq!((&kept.name, &kept.summary, &watched.cells), (&watched.name, &watched.summary, &Cells::NotKept));
    }
    let some = of(Keep::Only(&[ColumnRef::Name("state".to_owned()), ColumnRef::Number(1)]));
    let lengths: Vec<usize> = some.tables[0].columns.iter().map(|c| c.cells.len()).collect();
    assert_eq!((lengths, some.tables[0].rows), (vec![3, 3, 0], 3));
}

#[test]
fn zero_bytes_without_end_cost_no_memory_and_no_line_is_longer_than_allowed() {
    let mut log = b"t,p\n0,1\n1,2\n".to_vec();
    log.resize(9 << 20, 0);
    let read = read("r.csv", &log, &CsvOptions::default()).unwrap();
    assert_eq!((read.rows, read.findings[0].kind), (2, FindingKind::Truncated));
    assert!(read.findings[0].text.contains("ends in 9437172 zero bytes"), "{}", read.findings[0].text);
    log.extend(b"\n2,3\n");
    let refused = super::read("r.csv", &log, &CsvOptions::default()).unwrap_err().to_string();
    assert!(refused.starts_with("r.csv:4\n  expected: lines of at most"), "{refused}");
}

#[test]
fn text_without_end_is_refused_before_it_fills_memory() {
    let log = "t,p\n0,1\n1,2\n".to_owned() + &"a line of text that is no sample\n".repeat(600_000) + "2,3\n";
    let refused = read("r.csv", log.as_bytes(), &CsvOptions::default()).unwrap_err().to_string();
    assert!(refused.contains("lines in a row that are text"), "{refused}");
}

#[test]
fn thousands_of_equal_names_take_no_time() {
    let log = "a,".repeat(4_000) + "b\n" + &"1,".repeat(4_000) + "2\n" + &"1,".repeat(4_000) + "2\n";
    let log = read("r.csv", log.as_bytes(), &CsvOptions::default()).unwrap();
    assert_eq!((log.columns[3_999].name.as_str(), log.columns[4_000].name.as_str()), ("a (4000)", "b"));
}
