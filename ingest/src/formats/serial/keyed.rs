//! A log of lines of keys and values, read twice: the first pass learns the keys, the second takes the samples.

use std::collections::HashMap;

use super::pairs::{Pairs, pairs};
use super::prefix::strip;
use super::{LOOKED_AT, Terminal};
use crate::IngestError;
use crate::error::{Place, shown};
use crate::finding::places::{ByKind, Places, as_text, told};
use crate::finding::{Finding, FindingKind, Severity};
use crate::formats::csv::{CellKind, Decimal, cell_kind, unit_in_name};
use crate::formats::lines::{Line, Lines, trim};
use crate::formats::sheet::{OddLines, Sheet};
use crate::limits::LOG_COLUMNS_MAX;
use crate::raw::RawFile;
use crate::recording::{Keep, Recording};

/// A key on this share of the lines of keys makes a line a sample; half of the share of the most frequent key, if that is less.
const FREQUENT: f64 = 0.05;

/// Keys that are remembered beside a key, units that are told apart, lines of text kept as metadata.
const MATES_MAX: usize = 16;
const UNITS_MAX: usize = 8;
const METADATA_MAX: usize = 200;

/// Keys that noise may make before the file is no log.
const KEYS_MAX: usize = 16 * LOG_COLUMNS_MAX;

/// Whether a third of the lines and more hold keys that come again, and fewer are lines of bare numbers.
pub(super) fn looks_like(lines: &[&[u8]]) -> bool {
    let mut counts: HashMap<&[u8], usize> = HashMap::new();
    let mut keyed: Vec<Vec<&[u8]>> = Vec::new();
    let lines = lines.get(..LOOKED_AT).unwrap_or(lines);
    let (mut numbers, mut values) = (0, 0);
    for line in lines {
        let found = pairs(strip(line).rest);
        if found.is_plain() {
            for pair in &found.pairs {
                *counts.entry(pair.key).or_default() += 1;
                values += 1;
                numbers += usize::from(is_number(pair.value));
            }
            keyed.push(found.pairs.iter().map(|pair| pair.key).collect());
        }
    }
    let again = |key: &&[u8]| counts.get(*key).is_some_and(|count| *count > 1);
    let samples = keyed.iter().filter(|keys| keys.iter().any(again)).count();
    let is_one = lines.len() == 1 && keyed.first().is_some_and(|keys| keys.len() > 1);
    let is_bare =
        |line: &&&[u8]| strip(line).rest.first().is_some_and(|b| b.is_ascii_digit() || matches!(b, b'-' | b'+'));
    let bare = lines.iter().filter(is_bare).count();
    ((samples > 1 && samples * 3 >= lines.len() && samples > bare) || is_one) && numbers * 2 > values
}

fn is_number(value: &[u8]) -> bool {
    let is = |decimal| matches!(cell_kind(value, decimal), CellKind::Number(_) | CellKind::Hole);
    is(Decimal::Point) || is(Decimal::Comma)
}

/// What the first pass learns of a key.
#[derive(Default)]
struct Key {
    lines: usize,
    numbers: usize,
    words: usize,
    /// Keys that stand on lines with it, the first of them.
    mates: Vec<usize>,
    units: Vec<(Vec<u8>, usize)>,
}

/// What the first pass learns.
#[derive(Default)]
struct Keys {
    names: Vec<Vec<u8>>,
    keys: Vec<Key>,
    index: HashMap<Vec<u8>, usize>,
    lines: usize,
    stamped: usize,
    points: usize,
    commas: usize,
}

impl Keys {
    fn of(raw: &RawFile) -> Result<Self, IngestError> {
        let mut out = Self::default();
        let mut lines = Lines::of(raw)?;
        while let Some(line) = lines.next()? {
            let stripped = strip(line.bytes);
            let found = pairs(stripped.rest);
            if found.is_plain() && line.is_ended {
                out.stamped += usize::from(stripped.stamp.is_some());
                out.learn(&found, raw.name(), line.number)?;
            }
        }
        if out.lines == 0 {
            // One line that is not ended is better than nothing.
            let mut lines = Lines::of(raw)?;
            while let Some(line) = lines.next()? {
                let stripped = strip(line.bytes);
                let found = pairs(stripped.rest);
                if found.is_plain() {
                    out.stamped += usize::from(stripped.stamp.is_some());
                    out.learn(&found, raw.name(), line.number)?;
                }
            }
        }
        Ok(out)
    }

    fn learn(&mut self, found: &Pairs, file: &str, line: usize) -> Result<(), IngestError> {
        self.lines += 1;
        let mut indices = Vec::with_capacity(found.pairs.len());
        for pair in &found.pairs {
            let index = if let Some(index) = self.index.get(pair.key) {
                *index
            } else {
                if self.keys.len() == KEYS_MAX {
                    return Err(IngestError::Unusable {
                        place: Place::new(file, Some(line), None),
                        expected: format!("at most {KEYS_MAX} keys"),
                        found: "one more".to_owned(),
                        next: "is this a log of channels?".to_owned(),
                    });
                }
                self.index.insert(pair.key.to_vec(), self.keys.len());
                self.names.push(pair.key.to_vec());
                self.keys.push(Key::default());
                self.keys.len() - 1
            };
            indices.push(index);
            let is_comma = pair.value.contains(&b',');
            if is_number(pair.value) {
                self.commas += usize::from(is_comma);
                self.points += usize::from(pair.value.contains(&b'.'));
            }
            let Some(key) = self.keys.get_mut(index) else { continue };
            if is_number(pair.value) {
                key.numbers += 1;
                if let Some((_, count)) = key.units.iter_mut().find(|(unit, _)| unit == pair.unit) {
                    *count += 1;
                } else if key.units.len() < UNITS_MAX {
                    key.units.push((pair.unit.to_vec(), 1));
                }
            } else {
                key.words += 1;
            }
        }
        for index in &indices {
            let Some(key) = self.keys.get_mut(*index) else { continue };
            key.lines += 1;
            for mate in &indices {
                if key.mates.len() < MATES_MAX && mate != index && !key.mates.contains(mate) {
                    key.mates.push(*mate);
                }
            }
        }
        Ok(())
    }

    /// Which keys make a line a sample.
    fn frequent(&self) -> Vec<bool> {
        let most = self.keys.iter().map(|key| key.lines).max().unwrap_or(0) as f64;
        let limit = (FREQUENT * self.lines as f64).min(most / 2.0);
        self.keys.iter().map(|key| key.lines as f64 >= limit).collect()
    }

    fn decimal(&self) -> Decimal {
        if self.commas > self.points { Decimal::Comma } else { Decimal::Point }
    }
}

/// What becomes of a key.
#[derive(Clone, Copy, PartialEq)]
enum Use {
    Column(usize),
    /// It stands on one line only, or on lines without samples.
    Stray,
}

/// Reads a log of lines of keys and values.
pub(super) fn read(raw: &RawFile, keep: Keep) -> Result<Recording, IngestError> {
    let file = raw.name();
    let keys = Keys::of(raw)?;
    let frequent = keys.frequent();
    if !keys.keys.iter().zip(&frequent).any(|(key, frequent)| *frequent && key.numbers > 0) {
        return Err(IngestError::Unusable {
            place: Place::new(file, None, None),
            expected: "lines of keys and numbers: t=0.01 p=101.3".to_owned(),
            found: "none".to_owned(),
            next: "is this the file you meant?".to_owned(),
        });
    }
    let mut sheet = Sheet::new(file, "", keep);
    let terminal = if keys.stamped * 2 > keys.lines { Some(Terminal::add(&mut sheet)?) } else { None };
    let mut uses = Vec::with_capacity(keys.keys.len());
    let mut units: Vec<Vec<u8>> = Vec::with_capacity(keys.keys.len());
    for ((key, name), is_frequent) in keys.keys.iter().zip(&keys.names).zip(&frequent) {
        let is_mate = key.mates.iter().any(|mate| frequent.get(*mate) == Some(&true));
        let is_column = *is_frequent || (is_mate && key.lines > 1);
        let unit = key.units.iter().rev().max_by_key(|(_, count)| *count).map(|(unit, _)| unit.clone());
        let unit = unit.unwrap_or_default();
        let name = as_text(name);
        let written = if unit.is_empty() { unit_in_name(&name).map(str::to_owned) } else { Some(as_text(&unit)) };
        uses.push(match (is_column, key.words > key.numbers) {
            (false, _) => Use::Stray,
            (true, true) => Use::Column(sheet.text(&name)?),
            (true, false) => Use::Column(sheet.numbers(&name, written.as_deref(), *is_frequent)?),
        });
        units.push(unit);
    }
    let usual = keys.keys.iter().map(|key| key.lines).sum::<usize>() / keys.lines.max(1);
    let mut reading = Reading {
        file,
        decimal: keys.decimal(),
        keys: &keys,
        frequent,
        uses,
        units,
        usual: usual.max(1),
        sheet,
        terminal,
        odd: OddLines::default(),
        pending: Vec::new(),
        skipped: Places::default(),
        before: Places::default(),
        tagged: Places::default(),
        stray: ByKind::new(),
        metadata: Vec::new(),
    };
    let mut lines = Lines::of(raw)?;
    while let Some(line) = lines.next()? {
        if !line.bytes.trim_ascii().is_empty() {
            reading.line(line)?;
        }
    }
    let end = lines.end_findings(reading.sheet.lines());
    Ok(reading.finish(end))
}

/// Lines without a sample that may be a trailer: beyond this they are none.
const PENDING_MAX: usize = 1000;

struct Reading<'a> {
    file: &'a str,
    decimal: Decimal,
    keys: &'a Keys,
    frequent: Vec<bool>,
    uses: Vec<Use>,
    units: Vec<Vec<u8>>,
    /// Keys on a line on average.
    usual: usize,
    sheet: Sheet<'a>,
    terminal: Option<Terminal>,
    odd: OddLines,
    /// Lines without a sample behind the last one: number and text.
    pending: Vec<(usize, Vec<u8>)>,
    skipped: Places,
    /// Text before the first sample.
    before: Places,
    /// Words before the first key.
    tagged: Places,
    stray: ByKind,
    metadata: Vec<String>,
}

impl Reading<'_> {
    fn line(&mut self, line: Line) -> Result<(), IngestError> {
        let stripped = strip(line.bytes);
        let mut found = pairs(stripped.rest);
        let index: Vec<Option<usize>> = found.pairs.iter().map(|p| self.keys.index.get(p.key).copied()).collect();
        let frequent = index.iter().flatten().filter(|i| self.frequent.get(**i) == Some(&true)).count();
        // Words before the keys are half a line, or a tag; a message that quotes one key is neither.
        let is_sample =
            frequent > 0 && found.words_behind == 0 && (found.words_before == 0 || frequent * 2 >= self.usual);
        let row = self.sheet.rows();
        if !is_sample {
            self.no_sample(line);
            return Ok(());
        }
        self.settle(row);
        if found.words_before > 0 {
            self.tagged.add(row, line.number, trim(line.bytes));
        }
        if !line.is_ended {
            let missing: Vec<String> = self.missing(&index);
            let (kind, severity, text) = if missing.is_empty() {
                let text = format!(
                    "line {}, the last, has no line end: its last number may be cut, or nothing is missing",
                    line.number
                );
                (FindingKind::NoLineEnd, Severity::Note, text)
            } else {
                found.pairs.pop();
                let text = format!(
                    "the file ends within line {}: {} {} missing; the last value may be cut and is a hole; what followed is lost",
                    line.number,
                    missing.join(", "),
                    if missing.len() == 1 { "is" } else { "are" }
                );
                (FindingKind::Truncated, Severity::Lost, text)
            };
            self.odd.tell(told(kind, severity, self.file, row, line.number, text));
            if found.pairs.is_empty() {
                return Ok(());
            }
        }
        let twice = index.iter().enumerate().any(|(i, key)| key.is_some() && index.iter().take(i).any(|k| k == key));
        if let Some(terminal) = &mut self.terminal {
            terminal.put(&mut self.sheet, stripped.stamp, line.number);
        }
        if twice {
            // Two lines run together: which value is whose, nobody knows.
            self.odd.add(FindingKind::RaggedLine, row, line);
            return self.sheet.end_row(line.number, false);
        }
        for (pair, key) in found.pairs.iter().zip(&index) {
            let of = |key: usize| Some((*self.uses.get(key)?, self.units.get(key)?));
            let Some((Use::Column(column), unit)) = key.and_then(of) else {
                let quote = [pair.key, b"=", pair.value, pair.unit].concat();
                self.stray.entry(FindingKind::StrayKey).or_default().add(row, line.number, &quote);
                continue;
            };
            let is_number = matches!(cell_kind(pair.value, self.decimal), CellKind::Number(_));
            if is_number && pair.unit != unit.as_slice() {
                let quote = [pair.value, pair.unit].concat();
                self.sheet.hole(column, FindingKind::UnitMismatch, line.number, &quote);
            } else {
                self.sheet.cell(column, pair.value, self.decimal, line.number);
            }
        }
        self.sheet.end_row(line.number, line.is_ended)
    }

    /// Keys that stand on most lines and not on this one.
    fn missing(&self, index: &[Option<usize>]) -> Vec<String> {
        let on_most = |key: usize| self.keys.keys.get(key).is_some_and(|k| k.lines * 2 > self.keys.lines);
        let keys = self.keys.names.iter().enumerate();
        keys.filter(|(key, _)| on_most(*key) && !index.contains(&Some(*key)))
            .map(|(_, name)| shown(&as_text(name)))
            .collect()
    }

    fn no_sample(&mut self, line: Line) {
        let text = trim(line.bytes);
        let row = self.sheet.rows();
        let is_text = std::str::from_utf8(text).is_ok_and(|t| !t.chars().any(|c| c.is_control() && c != '\t'));
        if row == 0 && is_text {
            // A comment above the samples is meant to stand there.
            if !text.starts_with(b"#") {
                self.before.add(row, line.number, text);
            }
            if self.metadata.len() < METADATA_MAX {
                self.metadata.push(as_text(text));
            }
        } else if row == 0 || self.pending.len() >= PENDING_MAX || !is_text {
            self.settle(row);
            self.skipped.add(row, line.number, text);
        } else {
            self.pending.push((line.number, text.get(..400).unwrap_or(text).to_vec()));
        }
    }

    /// Samples follow after lines of text, so these are no trailer.
    fn settle(&mut self, row: usize) {
        for (line, text) in std::mem::take(&mut self.pending) {
            self.skipped.add(row, line, &text);
        }
    }

    fn finish(self, end: Vec<Finding>) -> Recording {
        let Self { file, keys, sheet, terminal, odd, pending, skipped, before, tagged, stray, uses, .. } = self;
        let rows = sheet.rows();
        let mut findings = odd.finish(file, self.usual);
        for finding in &mut findings {
            if finding.kind == FindingKind::RaggedLine {
                let (one, many) = ("line holds a key twice", "lines hold a key twice");
                let lines = if finding.count == 1 { format!("1 {one}") } else { format!("{} {many}", finding.count) };
                let first: Vec<String> = finding.spans.iter().take(3).map(|s| s.first_line.to_string()).collect();
                finding.text = format!(
                    "{lines}, as where two lines run together (first: line {}); each is a hole in every column",
                    first.join(", ")
                );
            }
        }
        findings.extend(end);
        let mut tell = |places: Places, kind, severity, one: &str, many: &str, behind: &str| {
            if places.count() > 0 {
                let text = format!("{} {}{behind}", places.counted(one, many), places.listed());
                findings.push(places.finding(kind, severity, file, None, text));
            }
        };
        let (note, out) = (Severity::Note, Severity::Excluded);
        let kind = FindingKind::SkippedLine;
        let (one, many) = ("line of text before the first sample", "lines of text before the first sample");
        tell(before, kind, note, one, many, "; kept as metadata");
        tell(skipped, kind, out, "line without a sample left out", "lines without a sample left out", "");
        let (one, many) =
            ("line begins with words before its first key", "lines begin with words before their first key");
        tell(tagged, kind, note, one, many, "; the words are not read");
        for (kind, places) in stray {
            let (one, many) = ("value under a key that no other line has", "values under keys that no other line has");
            tell(places, kind, out, one, many, "; left out");
        }
        let mut trailer = Places::default();
        for (line, text) in pending {
            trailer.add(rows, line, &text);
        }
        let (one, many) = ("line of text after the last sample", "lines of text after the last sample");
        tell(trailer, FindingKind::Trailer, note, one, many, "; not read as data");
        if let Some(terminal) = &terminal {
            findings.extend(terminal.findings(file, &sheet));
        }
        let used = keys.names.iter().zip(&uses).filter(|(_, u)| matches!(u, Use::Column(_)));
        let names: Vec<String> = used.map(|(name, _)| shown(&as_text(name))).collect();
        let decimal = if self.decimal == Decimal::Comma { "comma" } else { "point" };
        let mut reasons = vec![format!(
            "lines of keys and values with a decimal {decimal}; keys that come again: {}",
            names.join(", ")
        )];
        if terminal.is_some() {
            reasons.push("most lines begin with a terminal's stamp: column `terminal_time`".to_owned());
        }
        let origin = terminal.as_ref().and_then(Terminal::origin);
        let (table, cells) = sheet.finish();
        findings.extend(cells);
        Recording {
            format: "serial log",
            tables: vec![table],
            findings,
            reasons,
            metadata: self.metadata,
            origin,
            photographs: vec![],
        }
    }
}
