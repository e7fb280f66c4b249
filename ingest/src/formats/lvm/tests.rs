//! What only the module itself can try: pieces of other sizes than it reads in.

use super::read_in_pieces;
use crate::formats::csv::source::CHUNK;
use crate::raw::RawFile;
use crate::recording::Keep;

#[test]
fn the_size_of_pieces_changes_nothing() {
    let segment = |k: usize| {
        let rows = (0..20).map(|i| format!("0.{i:02}\t{}\t{}\r\r\n", i * k, i + k)).collect::<Vec<_>>().concat();
        let (head, tail) = rows.split_at(rows.len() / 2);
        let cut = tail.find('\n').map_or(0, |end| end + 1);
        let (line, tail) = tail.split_at(cut);
        format!(
            "Channels\t2\t\r\r\nDate\t2026/11/22\r\r\nTime\t09:{:02}:{:02}\r\r\n***End_of_Header***\r\r\n\
             X_Value\tp\tF{}\tComment\r\r\n{head}{line}***Start_Special***\r\r\nX_Value\t1\r\r\n***End_Special***\r\r\n\
             0.5\tERR\t3\tstuck\r\r\n{tail}\r\r\n",
            k / 60,
            k % 60,
            k % 3
        )
    };
    let text = format!(
        "LabVIEW Measurement\t\r\r\nX_Columns\tOne\r\r\n***End_of_Header***\r\r\n\r\r\n{}",
        (0..400).map(segment).collect::<String>()
    );
    assert!(text.len() > 100_000, "behind the bytes that are held at the beginning");
    let raw = RawFile::of_bytes("r.lvm", text.as_bytes());
    // Debug, because holes are not equal to themselves.
    let read = |chunk| format!("{:?}", read_in_pieces(&raw, Keep::All, chunk).unwrap());
    let whole = read(CHUNK);
    assert!(whole.contains("stuck"));
    for chunk in [1, 2, 3, 7, 100, 4_096] {
        assert_eq!(read(chunk), whole, "{chunk}");
    }
}
