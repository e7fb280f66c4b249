//! Colour on a terminal: of verdicts, of the decision, of what is told on standard error.
//!
//! Text is painted before it is known who reads it. The streams of `anstream` take the colour off again where no terminal is, where
//! `NO_COLOR` is set, and where `TERM` is `dumb`; `CLICOLOR_FORCE` keeps it on.

use std::fmt::Write as _;

use anstyle::{AnsiColor, Style};

/// What a text means to its reader.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Tone {
    /// As it should be.
    Good,
    /// What somebody must look at.
    Bad,
    /// Not decided, or to be noted.
    Open,
    /// Known, or not counted.
    Quiet,
}

/// A text in its colour.
pub fn painted(tone: Tone, text: &str) -> String {
    let style = match tone {
        Tone::Good => AnsiColor::Green.on_default(),
        Tone::Bad => AnsiColor::Red.on_default().bold(),
        Tone::Open => AnsiColor::Yellow.on_default(),
        Tone::Quiet => Style::new().dimmed(),
    };
    format!("{style}{text}{style:#}")
}

/// A table whose last column holds verdicts, those in their colours, also where they are wrapped.
pub fn verdicts(table: &str) -> String {
    let Some(before) = table.lines().next().and_then(|header| Some(header[..header.find("verdict")?].chars().count()))
    else {
        return table.to_owned();
    };
    let mut out = String::new();
    // Lines of one verdict, until it is whole.
    let mut open: Vec<(&str, &str)> = Vec::new();
    for line in table.lines() {
        // A column begins where its header does: no cell of this table is wider than a letter a character.
        let at = line.char_indices().nth(before).map_or(line.len(), |(at, _)| at);
        let (rest, verdict) = line.split_at(at);
        open.push((rest, verdict.trim_end()));
        let whole: Vec<&str> = open.iter().map(|(_, verdict)| *verdict).filter(|verdict| !verdict.is_empty()).collect();
        let tone = tone_of(&whole.join(" "));
        if tone.is_some() || whole.is_empty() || whole == ["verdict"] {
            open.drain(..).for_each(|line| add(&mut out, line, tone));
        }
    }
    for line in open {
        add(&mut out, line, None);
    }
    out
}

fn add(out: &mut String, (rest, verdict): (&str, &str), tone: Option<Tone>) {
    // Writing to a String cannot fail.
    let _ = match tone.filter(|_| !verdict.is_empty()) {
        Some(tone) => writeln!(out, "{rest}{}", painted(tone, verdict)),
        None => writeln!(out, "{rest}{verdict}"),
    };
}

/// What a verdict with its expectation means; `None` while it is not whole.
fn tone_of(verdict: &str) -> Option<Tone> {
    Some(match verdict {
        "pass" => Tone::Good,
        "pass, expected to exceed" | "fail, expected to pass" | "fail" => Tone::Bad,
        "fail, as expected" => Tone::Quiet,
        _ if verdict.ends_with(", not counted") => Tone::Quiet,
        _ if verdict.ends_with(", open") => Tone::Open,
        _ => return None,
    })
}

/// What is told on standard error, its first word in the colour of its weight.
pub fn told(message: &str) -> String {
    let Some((word, rest)) = message.split_once(':') else { return message.to_owned() };
    let tone = match word {
        "error" | "lost" => Tone::Bad,
        "excluded" | "warning" => Tone::Open,
        "note" => Tone::Quiet,
        _ => return message.to_owned(),
    };
    format!("{}{rest}", painted(tone, &format!("{word}:")))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn verdicts_have_the_colour_of_their_meaning_over_all_their_lines() {
        let table = "type  verdict\n\
                     a     pass\n\
                     b     fail, as expected\n\
                     c     fail, expected to\n      pass\n\
                     d     pass, expected to exceed\n\
                     e     inconclusive, open\n";
        let painted = verdicts(table);
        let tones = [Tone::Good, Tone::Quiet, Tone::Bad, Tone::Bad, Tone::Bad, Tone::Open];
        let texts = [
            "pass",
            "fail, as expected",
            "fail, expected to",
            "pass",
            "pass, expected to exceed",
            "inconclusive, open",
        ];
        for (line, (tone, text)) in painted.lines().skip(1).zip(tones.into_iter().zip(texts)) {
            assert_eq!(&line[6..], super::painted(tone, text), "{painted:?}");
        }
        // The colour adds nothing but itself.
        assert_eq!(anstream::adapter::strip_str(&painted).to_string(), table);
    }

    #[test]
    fn an_error_is_red_and_other_words_are_not() {
        assert!(told("error: no such file").contains("\u{1b}["));
        assert_eq!(told("Seen: 4 files"), "Seen: 4 files");
    }
}
