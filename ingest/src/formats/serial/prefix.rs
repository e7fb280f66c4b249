//! What a terminal writes before what the microcontroller wrote: a stamp, a prompt.

use crate::formats::lines::trim;
use crate::formats::stamps::seconds_of;

/// A line without what the terminal added.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Stripped<'b> {
    /// The terminal's stamp in s, and whether it is a date: since 1970, or else since midnight.
    pub stamp: Option<(f64, bool)>,
    pub rest: &'b [u8],
}

/// Longest stamp that is looked for: `2026-11-22 09:13:00.123456789+01:00`.
const STAMP_BYTES_MAX: usize = 40;

/// Takes off `12:33:01.123 -> ` and `[12:33:01.123] `, with or without a date, and then prompts: `> `.
pub(super) fn strip(line: &[u8]) -> Stripped<'_> {
    let line = trim(line);
    let stripped = arrow(line).or_else(|| brackets(line)).unwrap_or(Stripped { stamp: None, rest: line });
    Stripped { rest: without_prompt(stripped.rest), ..stripped }
}

fn arrow(line: &[u8]) -> Option<Stripped<'_>> {
    let head = line.get(..STAMP_BYTES_MAX).unwrap_or(line);
    let at = head.windows(2).position(|pair| pair == b"->")?;
    let stamp = seconds_of(std::str::from_utf8(line.get(..at)?).ok()?)?;
    Some(Stripped { stamp: Some(stamp), rest: trim(line.get(at + 2..)?) })
}

fn brackets(line: &[u8]) -> Option<Stripped<'_>> {
    let inside = line.strip_prefix(b"[")?;
    let head = inside.get(..STAMP_BYTES_MAX).unwrap_or(inside);
    let at = head.iter().position(|b| *b == b']')?;
    let stamp = seconds_of(std::str::from_utf8(inside.get(..at)?).ok()?)?;
    let rest = trim(inside.get(at + 1..)?);
    Some(Stripped { stamp: Some(stamp), rest: trim(rest.strip_prefix(b":").unwrap_or(rest)) })
}

fn without_prompt(mut line: &[u8]) -> &[u8] {
    while let [b'>' | b'$' | b' ' | b'\t', rest @ ..] = line {
        line = rest;
    }
    line
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stamps_and_prompts_are_taken_off() {
        let of = |text: &'static str| {
            let Stripped { stamp, rest } = strip(text.as_bytes());
            (stamp, std::str::from_utf8(rest).unwrap())
        };
        assert_eq!(of("12:33:01.125 -> 1,2,3"), (Some((45_181.125, false)), "1,2,3"));
        assert_eq!(of("[12:33:01.125] > t=1"), (Some((45_181.125, false)), "t=1"));
        assert_eq!(of("[2026-11-22 09:13:00.5] 1;2"), (Some((1_795_338_780.5, true)), "1;2"));
        assert_eq!(of(">p:1.2"), (None, "p:1.2"));
        assert_eq!(of("[boot] -> x"), (None, "[boot] -> x"));
        assert_eq!(of("1,2,3"), (None, "1,2,3"));
    }
}
