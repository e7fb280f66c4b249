//! Lines that are no samples: keys with their values, marks, and what the first bytes tell of the layout.

use std::collections::HashMap;

use crate::finding::places::as_text;
use crate::formats::csv::{Decimal, parse_number};
use crate::formats::lines::trim;

/// The first words of every file.
pub(super) const TITLE: &str = "LabVIEW Measurement";
/// Ends the header of the file, and that of a segment.
pub(super) const END_OF_HEADER: &[u8] = b"***End_of_Header***";
/// Begins a block of something else.
pub(super) const START_SPECIAL: &[u8] = b"***Start_Special***";
/// Ends it.
pub(super) const END_SPECIAL: &[u8] = b"***End_Special***";
/// The name of a column of X, the first on the line of names.
pub(super) const X_VALUE: &[u8] = b"X_Value";

/// Keys of a file.
const FILE_KEYS: [&str; 13] = [
    "Writer_Version",
    "Reader_Version",
    "Separator",
    "Decimal_Separator",
    "Multi_Headings",
    "X_Columns",
    "Time_Pref",
    "Operator",
    "Project",
    "Description",
    "Date",
    "Time",
    "Notes",
];

/// Keys of a segment.
const SEGMENT_KEYS: [&str; 17] = [
    "Channels",
    "Samples",
    "Date",
    "Time",
    "Y_Unit_Label",
    "Y_Dimension",
    "X_Unit_Label",
    "X_Dimension",
    "X0",
    "Delta_X",
    "Notes",
    "Test_Name",
    "Test_Numbers",
    "Test_Series",
    "UUT_Name",
    "UUT_M/N",
    "UUT_S/N",
];

/// Keys that hold for the next segment too where its header does not say otherwise.
const LASTING: [&str; 4] = ["Y_Unit_Label", "X_Unit_Label", "X_Dimension", "Delta_X"];

/// The key of a segment that a line begins with.
pub(super) fn segment_key(line: &[u8]) -> Option<&'static str> {
    let key = key(line);
    SEGMENT_KEYS.into_iter().find(|known| known.as_bytes() == key)
}

fn file_key(line: &[u8]) -> Option<&'static str> {
    let key = key(line);
    FILE_KEYS.into_iter().find(|known| known.as_bytes() == key)
}

/// The word that a line begins with: as far as a key can go.
fn key(line: &[u8]) -> &[u8] {
    let end = line.iter().position(|b| !(b.is_ascii_alphanumeric() || matches!(b, b'_' | b'/'))).unwrap_or(line.len());
    line.get(..end).unwrap_or(line)
}

/// Whether a line that has no end is the beginning of a line of a header.
pub(super) fn is_begun(line: &[u8]) -> bool {
    let words = SEGMENT_KEYS.iter().map(|key| key.as_bytes());
    let mut marks = words.chain([X_VALUE, END_OF_HEADER, START_SPECIAL, TITLE.as_bytes()]);
    marks.any(|mark| mark.starts_with(line) || line.starts_with(mark))
}

/// What stands behind a word at the beginning of a line, if the word ends there.
pub(super) fn behind<'a>(line: &'a [u8], word: &[u8]) -> Option<&'a [u8]> {
    let rest = line.strip_prefix(word)?;
    rest.first().is_none_or(|b| !(b.is_ascii_alphanumeric() || *b == b'_')).then_some(rest)
}

/// Whether a line is the first one of a file.
pub(super) fn is_title(line: &[u8]) -> bool {
    line.starts_with(TITLE.as_bytes())
}

/// Without separators and blanks at its end.
pub(super) fn without_end(mut line: &[u8], separator: u8) -> &[u8] {
    while let [rest @ .., last] = line
        && (*last == separator || matches!(last, b' ' | b'\t'))
    {
        line = rest;
    }
    line
}

/// The cells of a line. Blanks and quotes around a cell do not belong to it.
pub(super) fn cells(line: &[u8], separator: u8) -> impl Iterator<Item = &[u8]> {
    line.split(move |b| *b == separator).map(plain)
}

/// A cell without the blanks and quotes around it.
pub(super) fn plain(cell: &[u8]) -> &[u8] {
    let cell = trim(cell);
    cell.strip_prefix(b"\"").and_then(|cell| cell.strip_suffix(b"\"")).unwrap_or(cell)
}

/// Keys and values of a header; the first line of a key counts.
#[derive(Debug, Clone, Default)]
pub(super) struct Header {
    values: HashMap<&'static str, Vec<String>>,
    /// Whether a key stands in it that is not from the header before.
    pub is_stated: bool,
}

impl Header {
    /// The header of the next segment: what lasts of this one.
    pub fn next(&mut self) -> Self {
        let mut values = std::mem::take(&mut self.values);
        values.retain(|key, _| LASTING.contains(key));
        Self { values, is_stated: false }
    }

    /// Takes a line of the header of a file; whether it is one.
    pub fn file_line(&mut self, line: &[u8], separator: u8) -> bool {
        let Some(key) = file_key(line) else { return false };
        self.values.entry(key).or_insert_with(|| values(line, key, separator));
        true
    }

    /// Takes a line of the header of a segment; whether it is one. `own` are the keys of this header so far.
    pub fn segment_line(&mut self, line: &[u8], separator: u8, own: &mut Vec<&'static str>) -> bool {
        let Some(key) = segment_key(line) else { return false };
        self.is_stated = true;
        if !own.contains(&key) {
            own.push(key);
            self.values.insert(key, values(line, key, separator));
        }
        true
    }

    /// The one value of a key.
    pub fn value(&self, key: &str) -> Option<&str> {
        self.values.get(key)?.iter().map(|value| value.trim()).find(|value| !value.is_empty())
    }

    /// The value of a key for a channel: it stands above the channel's numbers, in column `column` from 0. Where there is none, values
    /// that stand one behind the other are those of the channels, and where `is_common` a single one is that of every channel.
    pub fn of_channel(
        &self,
        key: &str,
        column: usize,
        channel: usize,
        channels: usize,
        is_common: bool,
    ) -> Option<&str> {
        let values = self.values.get(key)?;
        let own = column.checked_sub(1).and_then(|i| values.get(i)).map(|value| value.trim());
        if let Some(own) = own.filter(|own| !own.is_empty()) {
            return Some(own);
        }
        let mut filled = values.iter().map(|value| value.trim()).filter(|value| !value.is_empty());
        match filled.clone().count() {
            1 if is_common => filled.next(),
            count if count == channels && channels > 1 => filled.nth(channel),
            _ => None,
        }
    }
}

/// The values of a line behind its key: a list as long as the line has cells.
fn values(line: &[u8], key: &str, separator: u8) -> Vec<String> {
    let rest = line.get(key.len()..).unwrap_or_default();
    let Some((first, rest)) = rest.split_first() else { return Vec::new() };
    // A header may be parted otherwise than its rows.
    let separator = if *first == separator || !matches!(first, b'\t' | b',' | b';') { separator } else { *first };
    cells(rest, separator).map(as_text).collect()
}

/// A line of a header in words: `Operator: JS`, values of several channels parted by `; `.
pub(super) fn in_words(line: &[u8], separator: u8) -> String {
    let Some(key) = segment_key(line).or_else(|| file_key(line)) else {
        return as_text(without_end(line, separator));
    };
    // Free text is left as it stands, with whatever separators are in it.
    if matches!(key, "Description" | "Notes" | "Separator" | "Decimal_Separator") {
        let rest = line.get(key.len() + 1..).unwrap_or_default();
        let rest = if matches!(key, "Description" | "Notes") { without_end(rest, separator) } else { rest };
        return format!("{key}: {}", as_text(rest).trim());
    }
    let mut values = values(line, key, separator);
    values.retain(|value| !value.is_empty());
    format!("{key}: {}", values.join("; "))
}

/// A number of a header, whichever decimal sign it has.
pub(super) fn number(text: &str) -> Option<f64> {
    let of = |decimal| parse_number(text.as_bytes(), decimal);
    of(Decimal::Point).or_else(|| of(Decimal::Comma)).filter(|number| number.is_finite())
}

/// What the first bytes tell of how cells are parted.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Parting {
    pub separator: u8,
    /// What `Separator` states.
    pub stated: Stated,
}

/// What a key states.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Stated {
    Nothing,
    Byte(u8),
    /// Something that is no single character of ASCII.
    Other,
}

/// How cells are parted: by what stands behind `X_Value`, the first cell of the names; or else as the header states it; or else by what
/// stands behind its keys. `None` if nothing tells.
pub(super) fn parting(head: &[u8]) -> Option<Parting> {
    let mut stated = Stated::Nothing;
    let (mut by_names, mut by_keys) = (None, None);
    let mut is_special = false;
    for line in head.split(|b| matches!(b, b'\n' | b'\r')) {
        if is_special || line.starts_with(START_SPECIAL) {
            is_special = !line.starts_with(END_SPECIAL);
        } else if let Some(rest) = behind(line, b"Separator")
            && stated == Stated::Nothing
            && !rest.is_empty()
        {
            stated = of_words(rest);
        } else if let Some([first, ..]) = behind(line, X_VALUE)
            && first.is_ascii()
        {
            by_names = by_names.or(Some(*first));
            break;
        } else if (segment_key(line).is_some() || file_key(line).is_some())
            && let Some(b @ (b'\t' | b',' | b';' | b'|')) = line.get(key(line).len())
        {
            by_keys = by_keys.or(Some(*b));
        }
    }
    let by_stated = if let Stated::Byte(byte) = stated { Some(byte) } else { None };
    by_names.or(by_stated).or(by_keys).map(|separator| Parting { separator, stated })
}

/// The separator that stands behind its key, as a word or as itself.
fn of_words(rest: &[u8]) -> Stated {
    // The first byte parts key and value.
    let Some((first, value)) = rest.split_first() else { return Stated::Nothing };
    // `Separator,Comma,` and `Separator;;`.
    let word = without_end(value, *first).trim_ascii();
    let byte = match word.to_ascii_lowercase().as_slice() {
        b"tab" | b"\\t" => b'\t',
        b"comma" => b',',
        b"semicolon" => b';',
        b"space" | b"blank" => b' ',
        b"pipe" | b"bar" => b'|',
        b"colon" => b':',
        [] => *first,
        [_] => word.first().copied().unwrap_or(*first),
        _ => return Stated::Other,
    };
    // A letter is what a cut leaves of a word.
    if byte.is_ascii() && !byte.is_ascii_alphanumeric() { Stated::Byte(byte) } else { Stated::Other }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_separator_is_found_in_words_and_in_bytes() {
        let separator = |head: &str| parting(head.as_bytes()).map(|p| p.separator);
        for (head, byte) in [
            ("LabVIEW Measurement\t\nSeparator\tTab\nX_Value\tp\n", b'\t'),
            ("Separator,Comma\n", b','),
            ("Separator,,\n", b','),
            ("Separator;;\nX_Value;p\n", b';'),
            ("Separator\tSemicolon\n", b';'),
            // The bytes win.
            ("Separator\tTab\nX_Value;p\n", b';'),
            ("Channels;2;;\nSamples;1;1\n", b';'),
            ("X_Value|p\n", b'|'),
            // What a special block holds is its own.
            ("***Start_Special***\nSeparator,Comma\nX_Value,1\n***End_Special***\nX_Value\tp\n", b'\t'),
        ] {
            assert_eq!(separator(head), Some(byte), "{head}");
        }
        assert_eq!(separator("0.1 0.2\n"), None);
        assert_eq!(parting("Separator\tab cd\nX_Value\tp".as_bytes()).map(|p| p.stated), Some(Stated::Other));
    }

    #[test]
    fn a_value_stands_above_its_channel() {
        let mut header = Header::default();
        let mut own = vec![];
        for line in ["Samples\t5\t\t7\t", "Date\t2016/08/23", "X0\t1\t2", "Y_Unit_Label\tV"] {
            assert!(header.segment_line(line.as_bytes(), b'\t', &mut own));
        }
        let of = |key, column, channel, is_common| header.of_channel(key, column, channel, 2, is_common);
        assert_eq!((of("Samples", 1, 0, true), of("Samples", 3, 1, true)), (Some("5"), Some("7")));
        assert_eq!((of("Date", 1, 0, true), of("Date", 3, 1, true)), (Some("2016/08/23"), Some("2016/08/23")));
        assert_eq!((of("X0", 1, 0, true), of("X0", 3, 1, true)), (Some("1"), Some("2")));
        assert_eq!((of("Y_Unit_Label", 1, 0, false), of("Y_Unit_Label", 3, 1, false)), (Some("V"), None));
    }

    #[test]
    fn lines_of_headers_are_told_in_words() {
        let words = |line: &str| in_words(line.as_bytes(), b'\t');
        assert_eq!(words("Operator\tJS\t"), "Operator: JS");
        assert_eq!(words("Samples\t10\t10\t"), "Samples: 10; 10");
        assert_eq!(words("Notes\ta\tb\t"), "Notes: a\tb");
        assert_eq!(words("of a second line\t"), "of a second line");
        assert_eq!(words("Separator\tTab"), "Separator: Tab");
    }
}
