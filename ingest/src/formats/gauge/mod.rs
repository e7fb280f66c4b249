//! What force gauges write: lines of a value and its unit, with marks beside them.
//!
//! `-0.56 lbF`, `12.34N T`, `1,2 kgf PEAK`, `OL`: as gauges of Mark-10, Imada, Sauter and Mecmesin send it to a port or a program keeps
//! it, with or without a stamp or number before or behind. Values stand as printed: whether a minus or a letter means tension differs
//! from maker to maker, so letters become a column `tension` of their own. Nothing is converted: a value in another unit than the first
//! lines have is a hole.
//!
//! | file | holds |
//! |---|---|
//! | `reading.rs` | a line of a value, its unit and its marks |
//! | `write.rs` | the writer |

mod reading;
mod write;

use super::lines::{Line, Lines, cells, head_lines, trim};
use super::sheet::{OddLines, Sheet};
use super::stamps;
use super::{TextHead, text_head};
use crate::IngestError;
use crate::error::{Place, shown};
use crate::finding::places::{Places, as_text, quoted, told};
use crate::finding::{Finding, FindingKind, Severity};
use crate::formats::csv::{Decimal, clock_unit, parse_number, unit_in_name};
use crate::raw::RawFile;
use crate::recording::{Keep, Recording};
use crate::units::{Dimension, Unit};
use reading::{Item, Reading, Shape, Value, is_force_unit, reading, shape_of};

pub use write::{Clock, write};

/// Delimiters and decimal signs, in the order in which they are tried: a comma between digits is rather a decimal sign.
const CANDIDATES: [(u8, Decimal); 7] = [
    (b'\t', Decimal::Point),
    (b';', Decimal::Point),
    (b'\t', Decimal::Comma),
    (b';', Decimal::Comma),
    (b' ', Decimal::Point),
    (b' ', Decimal::Comma),
    (b',', Decimal::Point),
];

/// Lines that are looked at.
const LOOKED_AT: usize = 400;

/// How the lines of a gauge are laid out.
struct Layout {
    delimiter: u8,
    decimal: Decimal,
    shape: Vec<Shape>,
    /// The unit of each value.
    units: Vec<String>,
}

/// Whether a text is the log of a force gauge, by its first bytes: most lines hold a number with a unit of force.
pub fn looks_like(head: &[u8], is_whole: bool) -> bool {
    Layout::of(&head_lines(head, is_whole)).is_some()
}

impl Layout {
    fn of(lines: &[&[u8]]) -> Option<Self> {
        let lines = lines.get(..LOOKED_AT).unwrap_or(lines);
        let mut best: Option<(usize, Self)> = None;
        let occurs = |delimiter: u8| delimiter == b' ' || lines.iter().any(|line| line.contains(&delimiter));
        for (delimiter, decimal) in CANDIDATES.into_iter().filter(|(delimiter, _)| occurs(*delimiter)) {
            let Some((count, layout)) = Self::under(lines, delimiter, decimal) else { continue };
            if best.as_ref().is_none_or(|(most, _)| count > *most) {
                best = Some((count, layout));
            }
        }
        best.map(|(_, layout)| layout)
    }

    /// The layout under a delimiter, and how many lines fit it.
    fn under(lines: &[&[u8]], delimiter: u8, decimal: Decimal) -> Option<(usize, Self)> {
        let mut shapes: Vec<(Vec<Shape>, Vec<Vec<String>>)> = Vec::new();
        let mut first = None;
        for (index, line) in lines.iter().enumerate() {
            let Some(reading) = reading(line, delimiter, decimal) else { continue };
            let shape = shape_of(&reading);
            let units: Vec<String> = reading.values().map(|value| as_text(value.unit)).collect();
            first.get_or_insert(index);
            match shapes.iter_mut().find(|(known, _)| *known == shape) {
                Some((_, all)) => all.push(units),
                None => shapes.push((shape, vec![units])),
            }
        }
        let (shape, all) = shapes.into_iter().rev().max_by_key(|(_, all)| all.len())?;
        // What stands above the first reading is its head.
        let behind = lines.len() - first?;
        if all.len() < 2 || all.len() * 2 <= behind {
            return None;
        }
        let values = shape.iter().filter(|s| **s == Shape::Value).count();
        let units: Vec<String> = (0..values).map(|at| most_frequent(all.iter().filter_map(|u| u.get(at)))).collect();
        let has_force = units.iter().any(|unit| is_force_unit(unit.as_bytes()));
        has_force.then_some((all.len(), Self { delimiter, decimal, shape, units }))
    }
}

/// The word that occurs most often, none excepted; of several the first.
fn most_frequent<'a>(words: impl Iterator<Item = &'a String>) -> String {
    let mut counts: Vec<(&String, usize)> = Vec::new();
    for word in words.filter(|word| !word.is_empty()) {
        match counts.iter_mut().find(|(known, _)| *known == word) {
            Some((_, count)) => *count += 1,
            None => counts.push((word, 1)),
        }
    }
    counts.into_iter().rev().max_by_key(|(_, count)| *count).map(|(word, _)| word.clone()).unwrap_or_default()
}

/// Reads the log of a force gauge as a recording of one table.
///
/// # Errors
/// [`IngestError::Unusable`] if it holds no values with a unit of force, and for sizes beyond [`crate::limits`];
/// [`IngestError::Read`].
pub fn read(raw: &RawFile, keep: Keep) -> Result<Recording, IngestError> {
    let file = raw.name();
    let TextHead { bytes, is_whole } = text_head(raw)?;
    let head = head_lines(&bytes, is_whole);
    let Some(layout) = Layout::of(&head) else {
        return Err(IngestError::Unusable {
            place: Place::new(file, None, None),
            expected: "lines of a value and its unit of force: `-12.34 N`".to_owned(),
            found: "other lines".to_owned(),
            next: "is this the log of a force gauge? Columns of bare numbers are read as `csv`".to_owned(),
        });
    };
    let mut log = Log::new(file, &layout, &head, keep)?;
    let mut lines = Lines::of(raw)?;
    while let Some(line) = lines.next()? {
        if !line.bytes.trim_ascii().is_empty() {
            log.line(line)?;
        }
    }
    let end = lines.end_findings(log.sheet.lines());
    Ok(log.finish(end))
}

/// A stated rate: `Sampling rate: 100 Hz`, `Interval 0.01 s`; in Hz.
fn stated_rate(line: &[u8]) -> Option<f64> {
    let text = as_text(line).to_lowercase();
    let of = |words: &[&str]| words.iter().any(|word| text.contains(word));
    let is_rate = of(&["rate", "frequency", "sampling", "samples/s", "abtastrate"]);
    let is_step = of(&["interval", "period", "time step", "intervall"]);
    if !is_rate && !is_step {
        return None;
    }
    let start = text.find(|c: char| c.is_ascii_digit())?;
    let behind = text.get(start..)?;
    let end = behind.find(|c: char| !c.is_ascii_digit() && c != '.' && c != ',').unwrap_or(behind.len());
    let (number, unit) = behind.split_at_checked(end)?;
    let number = parse_number(number.replace(',', ".").as_bytes(), Decimal::Point).filter(|n| *n > 0.0)?;
    match unit.trim().trim_matches(['(', ')', '[', ']']) {
        "hz" | "/s" | "1/s" | "s/s" | "sps" | "samples/s" | "per second" | "samples per second" if is_rate => {
            Some(number)
        }
        "khz" if is_rate => Some(number * 1e3),
        "s" | "sec" | "seconds" => Some(1.0 / number),
        "ms" | "msec" => Some(1e3 / number),
        _ => None,
    }
    .filter(|rate| rate.is_finite())
}

/// Lines without a reading that may be a trailer: beyond this they are none.
const PENDING_MAX: usize = 1000;

/// Lines of text kept as metadata.
const METADATA_MAX: usize = 200;

struct Log<'a> {
    file: &'a str,
    layout: &'a Layout,
    /// The first reading.
    example: Vec<u8>,
    sheet: Sheet<'a>,
    /// The column of every item of a line.
    columns: Vec<usize>,
    peak: Option<usize>,
    tension: Option<usize>,
    /// The column of times made from a stated rate, and the rate in Hz.
    paced: Option<(usize, f64)>,
    has_clock: Option<usize>,
    peaks: Places,
    letters: Places,
    odd: OddLines,
    pending: Vec<(usize, Vec<u8>)>,
    metadata: Vec<String>,
    reasons: Vec<String>,
}

impl<'a> Log<'a> {
    fn new(file: &'a str, layout: &'a Layout, head: &[&[u8]], keep: Keep<'a>) -> Result<Self, IngestError> {
        let mut sheet = Sheet::new(file, "", keep);
        let first = head.iter().position(|line| fits(line, layout)).unwrap_or(0);
        let above = head.get(..first).unwrap_or_default();
        let mut parts = Vec::new();
        // The line above the first reading names the columns if it has as many cells.
        let names: Vec<String> = match above.last() {
            Some(line) if layout.delimiter != b' ' && layout.shape.len() > 1 => {
                cells(line, layout.delimiter, &mut parts);
                let is_names = parts.len() == layout.shape.len()
                    && parts.iter().all(|cell| !cell.is_empty() && parse_number(cell, layout.decimal).is_none());
                if is_names { parts.iter().map(|cell| as_text(cell)).collect() } else { Vec::new() }
            }
            _ => Vec::new(),
        };
        let rate = above.iter().find_map(|line| stated_rate(line).map(|rate| (rate, as_text(trim(line)))));
        let mut reasons = vec![format!(
            "lines of a value and its unit, a decimal {}, {}",
            if layout.decimal == Decimal::Comma { "comma" } else { "point" },
            match layout.delimiter {
                b' ' => "parted by blanks".to_owned(),
                b'\t' => "parted by tabs".to_owned(),
                other => format!("parted by `{}`", char::from(other)),
            }
        )];
        let mut has_clock = None;
        let mut columns = Vec::with_capacity(layout.shape.len());
        let mut units = layout.units.iter();
        for (index, shape) in layout.shape.iter().enumerate() {
            let written = names.get(index);
            let column = match shape {
                Shape::Value => {
                    let unit = units.next().map_or("", String::as_str);
                    let name = written.map_or(quantity(unit), String::as_str);
                    sheet.numbers(name, Some(unit).filter(|unit| !unit.is_empty()), true)?
                }
                Shape::Word => {
                    let column = sheet.written_stamps(written.map_or("time", String::as_str))?;
                    has_clock.get_or_insert(column);
                    column
                }
                Shape::Number => {
                    let numbers = Numbers::of(&plain_numbers(head, layout, index));
                    let name = match (written, numbers) {
                        (Some(name), _) => name.as_str(),
                        (None, Numbers::Count) => "index",
                        (None, Numbers::Rising) => "time",
                        (None, Numbers::AlmostRising) if !is_behind_value(layout, index) => "time",
                        (None, _) => "number",
                    };
                    let is_time = match numbers {
                        Numbers::Rising => true,
                        // What almost rises may be a travel: only what is called a time is one.
                        Numbers::AlmostRising => clock_unit(name, unit_in_name(name)).is_some(),
                        Numbers::Count | Numbers::Other => false,
                    };
                    if is_time {
                        let column = sheet.stamps(name, unit_in_name(name))?;
                        has_clock.get_or_insert(column);
                        column
                    } else {
                        sheet.numbers(name, unit_in_name(name), true)?
                    }
                }
            };
            columns.push(column);
        }
        let paced = match (rate, has_clock) {
            (Some((rate, line)), None) => {
                reasons.push(format!("column `time` is made from the stated rate, {rate} Hz: {}", shown(&line)));
                Some((sheet.numbers("time", Some("s"), false)?, rate))
            }
            _ => None,
        };
        Ok(Self {
            file,
            layout,
            example: head.get(first).copied().unwrap_or_default().to_vec(),
            sheet,
            columns,
            peak: None,
            tension: None,
            paced,
            has_clock,
            peaks: Places::default(),
            letters: Places::default(),
            odd: OddLines::default(),
            pending: Vec::new(),
            metadata: Vec::new(),
            reasons,
        })
    }

    fn line(&mut self, line: Line) -> Result<(), IngestError> {
        let layout = self.layout;
        let row = self.sheet.rows();
        let found = reading(line.bytes, layout.delimiter, layout.decimal);
        let Some(found) = found.filter(|found| shape_of(found) == layout.shape) else {
            let text = trim(line.bytes);
            if row == 0 {
                if self.metadata.len() < METADATA_MAX {
                    self.metadata.push(as_text(text));
                }
            } else if !line.is_ended && begins_reading(line.bytes, &self.example, layout) {
                return self.cut(line);
            } else {
                if self.pending.len() >= PENDING_MAX {
                    self.settle()?;
                }
                self.pending.push((line.number, text.get(..400).unwrap_or(text).to_vec()));
            }
            return Ok(());
        };
        if !line.is_ended && ends_within_unit(line.bytes, &found, layout) {
            return self.cut(line);
        }
        self.settle()?;
        let row = self.sheet.rows();
        if !line.is_ended {
            // Its units are whole: only what stands behind them may be missing.
            let mut parts = vec![line.bytes];
            self.odd.fit(self.file, &mut parts, 1, row, line);
        }
        let mut units = layout.units.iter();
        for (item, column) in found.items.iter().zip(&self.columns) {
            match item {
                Item::Plain(cell) => self.sheet.cell(*column, cell, layout.decimal, line.number),
                Item::Value(value) => {
                    let usual = units.next().map_or("", String::as_str);
                    put_value(&mut self.sheet, *column, value, usual, line);
                }
            }
        }
        if found.is_peak {
            let column = match self.peak {
                Some(column) => column,
                None => *self.peak.insert(self.sheet.marks("peak")?),
            };
            self.sheet.put(column, 1.0);
            self.peaks.add(row, line.number, trim(line.bytes));
        }
        if let Some(is_tension) = found.is_tension {
            let column = match self.tension {
                Some(column) => column,
                None => *self.tension.insert(self.sheet.numbers("tension", None, true)?),
            };
            self.sheet.put(column, if is_tension { 1.0 } else { 0.0 });
            self.letters.add(row, line.number, trim(line.bytes));
        }
        self.end_row(line.number, true)
    }

    /// Leaves out the last line, within which the file ends. Lines above it are no trailer: samples went on behind them.
    fn cut(&mut self, line: Line) -> Result<(), IngestError> {
        self.settle()?;
        let text = format!(
            "the file ends within line {}: {} is no whole reading and is left out; what followed is lost",
            line.number,
            quoted(trim(line.bytes))
        );
        let row = self.sheet.rows();
        self.odd.tell(told(FindingKind::Truncated, Severity::Lost, self.file, row, line.number, text));
        Ok(())
    }

    fn end_row(&mut self, line: usize, is_told: bool) -> Result<(), IngestError> {
        if let Some((column, rate_hz)) = self.paced {
            let row = self.sheet.rows() as f64;
            self.sheet.put(column, row / rate_hz);
        }
        self.sheet.end_row(line, is_told)
    }

    /// Readings follow after other lines, so these are no trailer. Where samples are counted they keep their place, or those behind
    /// them would move.
    fn settle(&mut self) -> Result<(), IngestError> {
        for (number, bytes) in std::mem::take(&mut self.pending) {
            let line = Line { bytes: &bytes, number, is_ended: true };
            self.odd.add(FindingKind::SkippedLine, self.sheet.rows(), line);
            if self.paced.is_some() {
                self.end_row(number, false)?;
            }
        }
        Ok(())
    }

    fn finish(mut self, end: Vec<Finding>) -> Recording {
        let file = self.file;
        let row = self.sheet.rows();
        for (number, bytes) in std::mem::take(&mut self.pending) {
            self.odd.add(FindingKind::Trailer, row, Line { bytes: &bytes, number, is_ended: true });
        }
        let mut findings = self.odd.finish(file, 1);
        if self.paced.is_some() {
            for finding in findings.iter_mut().filter(|f| f.kind == FindingKind::SkippedLine) {
                finding.text.push_str("; each is a hole in every column and keeps its place in time");
            }
        }
        findings.extend(end);
        if self.peaks.count() > 0 {
            let what = self.peaks.counted("value is marked as a peak", "values are marked as peaks");
            let text = format!("{what} {}: column `peak` holds 1 there", self.peaks.listed());
            findings.push(self.peaks.finding(FindingKind::PeakMark, Severity::Note, file, None, text));
        }
        if self.letters.count() > 0 {
            let what = self.letters.counted("line says", "lines say");
            let text = format!(
                "{what} by a letter whether the force is tension or compression {}: column `tension` holds 1 or 0, values stand as printed",
                self.letters.listed()
            );
            findings.push(self.letters.finding(FindingKind::SignLetter, Severity::Note, file, None, text));
        }
        let clock = self.paced.map(|(column, _)| column).or(self.has_clock);
        let (mut table, cells) = self.sheet.finish();
        table.clock = clock;
        findings.extend(cells);
        Recording {
            format: "force gauge log",
            tables: vec![table],
            findings,
            reasons: self.reasons,
            metadata: self.metadata,
            origin: None,
            photographs: vec![],
        }
    }
}

/// Puts a value that stands in the usual unit; every other is a hole.
fn put_value(sheet: &mut Sheet, column: usize, value: &Value, usual: &str, line: Line) {
    match value.number {
        Some(number) if value.unit == usual.as_bytes() => sheet.put(column, number),
        Some(_) => sheet.hole(column, FindingKind::UnitMismatch, line.number, trim(line.bytes)),
        None => {
            let is_dash = value.text.iter().all(|b| matches!(b, b'-' | b'.' | b'_'));
            let kind = if is_dash { FindingKind::NoValue } else { FindingKind::OutOfRange };
            sheet.hole(column, kind, line.number, value.text);
        }
    }
}

fn fits(line: &[u8], layout: &Layout) -> bool {
    reading(line, layout.delimiter, layout.decimal).is_some_and(|found| shape_of(&found) == layout.shape)
}

/// Words that may stand on a line and not on the first reading.
const OTHER_WORDS: [&[u8]; 5] = [b"peak", b"tension", b"compression", b"overload", b"----"];

/// Whether a line that is no reading is the beginning of one: with an end of the first reading behind it, it would be one. A word at
/// its end may be cut too.
fn begins_reading(line: &[u8], example: &[u8], layout: &Layout) -> bool {
    let cut_word = |word: &'static [u8]| {
        let length = (1..word.len()).rev().find(|length| {
            let start = line.len().checked_sub(*length).and_then(|at| line.get(at..));
            start.zip(word.get(..*length)).is_some_and(|(end, start)| end.eq_ignore_ascii_case(start))
        });
        length.and_then(|length| word.get(length..))
    };
    let words = std::iter::once(&[][..]).chain(OTHER_WORDS.into_iter().filter_map(cut_word));
    words.into_iter().any(|word| {
        (0..=example.len()).any(|at| fits(&[line, word, example.get(at..).unwrap_or_default()].concat(), layout))
    })
}

/// Whether a last line ends with a part of the usual unit: `kg` of `kgf`.
fn ends_within_unit(line: &[u8], found: &Reading, layout: &Layout) -> bool {
    found.values().zip(&layout.units).last().is_some_and(|(Value { number, unit, .. }, usual)| {
        number.is_some() && line.ends_with(unit) && unit.len() < usual.len() && usual.as_bytes().starts_with(unit)
    })
}

/// What bare numbers are, from line to line.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Numbers {
    /// Whole numbers, each one more than the one before.
    Count,
    /// They never fall.
    Rising,
    /// They rise, but fall a few times, as the stamps of a clock that was set back.
    AlmostRising,
    Other,
}

impl Numbers {
    fn of(numbers: &[f64]) -> Self {
        let steps: Vec<f64> = numbers.windows(2).map(|pair| pair[1] - pair[0]).collect();
        if steps.is_empty() {
            return Self::Other;
        }
        let is_whole = numbers.iter().all(|n| n.fract().abs() < 1e-9);
        let ones = steps.iter().filter(|step| (**step - 1.0).abs() < 1e-9).count();
        let rising = steps.iter().filter(|step| **step > 0.0).count();
        let falling = steps.iter().filter(|step| **step < 0.0).count();
        if is_whole && ones == steps.len() {
            Self::Count
        } else if falling == 0 {
            Self::Rising
        } else if rising * 10 >= steps.len() * 9
            && falling * 20 <= numbers.len()
            && !(is_whole && ones * 2 > steps.len())
        {
            // Whole numbers that mostly rise by one are a count that began anew.
            Self::AlmostRising
        } else {
            Self::Other
        }
    }
}

/// Whether a value stands before a place.
fn is_behind_value(layout: &Layout, index: usize) -> bool {
    layout.shape.iter().take(index).any(|shape| *shape == Shape::Value)
}

/// The bare numbers at a place of the first lines.
fn plain_numbers(head: &[&[u8]], layout: &Layout, index: usize) -> Vec<f64> {
    let lines = head.iter().take(LOOKED_AT);
    let readings = lines.filter_map(|line| reading(line, layout.delimiter, layout.decimal));
    let numbers =
        readings.filter(|found| shape_of(found) == layout.shape).filter_map(|found| match found.items.get(index) {
            Some(Item::Plain(cell)) => parse_number(cell, layout.decimal),
            _ => None,
        });
    numbers.collect()
}

/// What a value with a unit is.
fn quantity(unit: &str) -> &'static str {
    if is_force_unit(unit.as_bytes()) && Unit::parse(unit).is_none_or(|u| u.dimension == Dimension::Force) {
        return "force";
    }
    match Unit::parse_loose(unit).map(|(unit, _)| unit.dimension) {
        Some(Dimension::Length) => "travel",
        Some(Dimension::Time) => "time",
        Some(Dimension::Mass) => "mass",
        _ => "value",
    }
}

/// Whether stamps are written so that a gauge's line may begin with them.
fn is_stamp(text: &[u8]) -> bool {
    stamps::is_stamp(text)
}
