//! A line of keys and values: `t=123 p=101.3kPa`, `p:1.2,flex:3`, `Pressure: 101.3 kPa; Flex 1: 2.31`.

use crate::formats::lines::trim;
use crate::units::Unit;

/// A key and what stands behind it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Pair<'b> {
    pub key: &'b [u8],
    /// A number or a word.
    pub value: &'b [u8],
    /// The unit behind a number, without brackets; may be empty.
    pub unit: &'b [u8],
}

/// What a line holds.
#[derive(Debug, Default)]
pub(super) struct Pairs<'b> {
    pub pairs: Vec<Pair<'b>>,
    /// Words before the first key.
    pub words_before: usize,
    /// Words behind it that belong to no key.
    pub words_behind: usize,
}

impl Pairs<'_> {
    /// Whether there are pairs and nothing else.
    pub fn is_plain(&self) -> bool {
        !self.pairs.is_empty() && self.words_before + self.words_behind == 0
    }
}

/// Longest key: what is longer is a sentence.
const KEY_BYTES_MAX: usize = 64;

/// Longest unit.
const UNIT_BYTES_MAX: usize = 16;

/// Takes a line apart.
pub(super) fn pairs(line: &[u8]) -> Pairs<'_> {
    let line = trim(line);
    let line = line.strip_prefix(b"{").and_then(|l| l.strip_suffix(b"}")).unwrap_or(line);
    let mut out = Pairs::default();
    // A comma between digits is a decimal sign: every value has its key.
    let is_digit = |at: Option<usize>| at.and_then(|at| line.get(at)).is_some_and(u8::is_ascii_digit);
    let parts = |at: usize| match line.get(at) {
        Some(b';' | b'\t' | b'|') => true,
        Some(b',') => !(is_digit(at.checked_sub(1)) && is_digit(Some(at + 1))),
        _ => false,
    };
    let mut start = 0;
    for at in 0..=line.len() {
        if at == line.len() || parts(at) {
            let item = trim(line.get(start..at).unwrap_or_default());
            start = at + 1;
            if item.is_empty() {
                continue;
            }
            match pair(item) {
                Some(pair) => out.pairs.push(pair),
                None => by_blanks(item, &mut out),
            }
        }
    }
    out
}

fn is_assign(b: u8) -> bool {
    matches!(b, b'=' | b':')
}

/// An item that is one pair and nothing else.
fn pair(item: &[u8]) -> Option<Pair<'_>> {
    let at = item.iter().position(|b| *b == b'=').or_else(|| item.iter().position(|b| *b == b':'))?;
    let key = key(item.get(..at)?)?;
    let right = trim(item.get(at + 1..)?);
    // A second pair in it, unless these are the colons of a time.
    let is_time = right.iter().all(|b| b.is_ascii_digit() || matches!(b, b':' | b'.'));
    if right.is_empty() || (!is_time && right.iter().any(|b| is_assign(*b))) {
        return None;
    }
    let (value, unit) = number_and_unit(right);
    // Words behind a word are a sentence.
    let is_words = unit.is_empty() && value.iter().any(|b| matches!(b, b' ' | b'\t')) && !value.starts_with(b"\"");
    if is_words {
        return None;
    }
    Some(Pair { key, value: unquoted(value), unit })
}

fn unquoted(bytes: &[u8]) -> &[u8] {
    bytes.strip_prefix(b"\"").and_then(|b| b.strip_suffix(b"\"")).unwrap_or(bytes)
}

fn key(bytes: &[u8]) -> Option<&[u8]> {
    let key = unquoted(trim(bytes));
    let text = std::str::from_utf8(key).ok()?;
    let first = text.chars().next()?;
    let is_fit = |c: char| c.is_alphanumeric() || " _-./#()[]%°²³^*".contains(c);
    let is_key = (first.is_alphabetic() || first == '_') && key.len() <= KEY_BYTES_MAX && text.chars().all(is_fit);
    is_key.then_some(key)
}

/// A number and the unit behind it, or the whole as a word.
fn number_and_unit(text: &[u8]) -> (&[u8], &[u8]) {
    let mut at = usize::from(matches!(text.first(), Some(b'+' | b'-')));
    let digits_from = at;
    while let Some(b) = text.get(at) {
        let is_exponent = matches!(b, b'e' | b'E')
            && at > digits_from
            && match text.get(at + 1) {
                Some(b'+' | b'-') => text.get(at + 2).is_some_and(u8::is_ascii_digit),
                Some(next) => next.is_ascii_digit(),
                None => false,
            };
        if b.is_ascii_digit() || matches!(b, b'.' | b',') {
            at += 1;
        } else if is_exponent {
            at += 2;
        } else {
            break;
        }
    }
    let (number, behind) = text.split_at_checked(at).unwrap_or((text, b""));
    let unit = trim(behind);
    let inside = |open: &[u8], close: &[u8]| unit.strip_prefix(open).and_then(|u| u.strip_suffix(close));
    let unit = inside(b"(", b")").or_else(|| inside(b"[", b"]")).unwrap_or(unit);
    let has_digits = number.iter().any(u8::is_ascii_digit);
    let is_unit = unit.len() <= UNIT_BYTES_MAX
        && std::str::from_utf8(unit).is_ok_and(|unit| {
            unit.chars().next().is_none_or(|c| c.is_alphabetic() || "%°µ1".contains(c))
                && unit.chars().all(|c| c.is_alphanumeric() || "%°µ²³/^*._-() ".contains(c))
        })
        && !unit.contains(&b' ');
    if has_digits && is_unit { (number, unit) } else { (text, b"") }
}

/// Pairs with blanks between them, and blanks around their signs where there are any.
fn by_blanks<'b>(item: &'b [u8], out: &mut Pairs<'b>) {
    let is_blank = |b: &u8| matches!(b, b' ' | b'\t');
    let skip = |mut at: usize| {
        while item.get(at).is_some_and(is_blank) {
            at += 1;
        }
        at
    };
    let word_end = |from: usize| {
        let length = item.get(from..).unwrap_or_default().iter().position(is_blank);
        length.map_or(item.len(), |length| from + length)
    };
    let mut at = skip(0);
    while at < item.len() {
        let end = word_end(at);
        let word = item.get(at..end).unwrap_or_default();
        let sign = word.iter().position(|b| *b == b'=').or_else(|| word.iter().position(|b| is_assign(*b)));
        // The sign stands in the word, or alone behind it.
        let (name, mut value_at) = match sign {
            Some(sign) => (item.get(at..at + sign), at + sign + 1),
            None if item.get(skip(end)).is_some_and(|b| is_assign(*b)) => (Some(word), skip(end) + 1),
            None => (None, end),
        };
        value_at = skip(value_at);
        let value_end = word_end(value_at);
        let value = item.get(value_at..value_end).unwrap_or_default();
        let is_second = value.contains(&b'=');
        let Some(key) = name.and_then(key).filter(|_| !value.is_empty() && !is_second) else {
            if out.pairs.is_empty() {
                out.words_before += 1;
            } else {
                out.words_behind += 1;
            }
            at = skip(end);
            continue;
        };
        let (value, mut unit) = number_and_unit(value);
        at = skip(value_end);
        let next_end = word_end(at);
        let next = item.get(at..next_end).unwrap_or_default();
        let is_key = next.iter().any(|b| is_assign(*b)) || item.get(skip(next_end)).is_some_and(|b| is_assign(*b));
        let is_number = value.iter().any(u8::is_ascii_digit);
        if unit.is_empty()
            && !is_key
            && is_number
            && std::str::from_utf8(next).is_ok_and(|next| next != "1" && Unit::parse_loose(next).is_some())
        {
            let bare = next.strip_prefix(b"(").and_then(|u| u.strip_suffix(b")"));
            unit = bare.or_else(|| next.strip_prefix(b"[").and_then(|u| u.strip_suffix(b"]"))).unwrap_or(next);
            at = skip(next_end);
        }
        out.pairs.push(Pair { key, value: unquoted(value), unit });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(line: &str) -> (Vec<(String, String, String)>, bool) {
        let pairs = pairs(line.as_bytes());
        let text = |bytes: &[u8]| String::from_utf8(bytes.to_vec()).unwrap();
        let is_plain = pairs.is_plain();
        (pairs.pairs.iter().map(|p| (text(p.key), text(p.value), text(p.unit))).collect(), is_plain)
    }

    #[test]
    fn pairs_in_every_spelling() {
        let p = |key: &str, value: &str, unit: &str| (key.to_owned(), value.to_owned(), unit.to_owned());
        for (line, pairs) in [
            ("t=123 p=101.3 flex=2.31", vec![p("t", "123", ""), p("p", "101.3", ""), p("flex", "2.31", "")]),
            ("p:1.2,flex:3", vec![p("p", "1.2", ""), p("flex", "3", "")]),
            ("p=12.5kPa; flex=-2.3e-1V", vec![p("p", "12.5", "kPa"), p("flex", "-2.3e-1", "V")]),
            ("p=12.5 [kPa]\tf=3 (N)", vec![p("p", "12.5", "kPa"), p("f", "3", "N")]),
            ("p=1,5 flex=2,31", vec![p("p", "1,5", ""), p("flex", "2,31", "")]),
            ("p=1,5;flex=2,31", vec![p("p", "1,5", ""), p("flex", "2,31", "")]),
            ("Pressure: 101.3 kPa, Flex 1: 2.31 V", vec![p("Pressure", "101.3", "kPa"), p("Flex 1", "2.31", "V")]),
            ("Pressure: 101.3 kPa Flex: 2.31 V", vec![p("Pressure", "101.3", "kPa"), p("Flex", "2.31", "V")]),
            ("t = 1 m = 2", vec![p("t", "1", ""), p("m", "2", "")]),
            ("{\"t\":1,\"p\":2.5}", vec![p("t", "1", ""), p("p", "2.5", "")]),
            ("t=12:33:01 s=RUN", vec![p("t", "12:33:01", ""), p("s", "RUN", "")]),
            ("p(kPa)=1.5", vec![p("p(kPa)", "1.5", "")]),
            ("T=21.5°C", vec![p("T", "21.5", "°C")]),
        ] {
            assert_eq!(of(line), (pairs, true), "{line}");
        }
    }

    #[test]
    fn sentences_and_numbers_are_no_pairs() {
        for line in [
            "1,2,3",
            "Booting v1.2 ...",
            "12:33:01 1 2",
            "WARN p=500 too high",
            "Note: five samples",
            "",
            "=",
            "a=",
            "=1",
        ] {
            assert!(!of(line).1, "{line}: {:?}", of(line));
        }
        let cut = pairs(b".3 p=1 q=2");
        assert_eq!((cut.words_before, cut.words_behind, cut.pairs.len()), (1, 0, 2));
    }
}
