//! Delimited text as rigs write it: any delimiter, with or without header, and the damage that happens while logging.
//!
//! [`read`] finds out the layout from the bytes and says how; it takes every sample, keeps holes as NaN where no number
//! stands, and tells each such place as a [`Finding`]. What is asked for in [`CsvOptions`] is never second-guessed. Published tables,
//! which people write, are read strictly by [`crate::table`] instead.
//!
//! | file | holds |
//! |---|---|
//! | `source.rs` | encodings, and the part of the text that is in memory |
//! | `text.rs` | line ends, quotes: text to cells |
//! | `numbers.rs` | decimal numbers, correctly rounded |
//! | `sniff/` | the layout, from the first lines |
//! | `rows.rs` | the pass over the data, fast where lines are plain |
//! | `tally.rs` | what is odd, while reading |
//! | `write.rs` | the writer |

mod cells;
pub(in crate::formats) mod numbers;
pub(in crate::formats) mod rows;
mod sniff;
pub(in crate::formats) mod source;
pub(in crate::formats) mod tally;
#[cfg(test)]
mod tests;
pub(in crate::formats) mod text;
mod write;

use std::collections::{HashMap, HashSet};

use crate::error::{IngestError, Place, shown};
use crate::finding::places::{HALF_CHARACTER, zero_bytes};
use crate::finding::{Finding, FindingKind, LineMap, Severity};
use crate::limits::LOG_BYTES_MAX;
use crate::raw::RawFile;
use crate::recording::{Cells, ClockUnit, Column, Keep, Recording, Table};
use crate::units::{Dimension, Spelling, Unit};

use sniff::Glued;
use source::{BadLines, CHUNK, Ending};

pub(crate) use cells::{Kind as CellKind, kind as cell_kind};
pub use numbers::{Decimal, parse as parse_number};
pub use sniff::{Comment, Comments, Layout};
pub use source::Encoding;
pub use write::{WriteOptions, lines, write};

/// What is known about a log beforehand; `None` is found out from the bytes.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct CsvOptions {
    /// Tab, comma, semicolon, bar or blank, or any other byte.
    pub delimiter: Option<u8>,
    /// The decimal sign.
    pub decimal: Option<Decimal>,
    /// What stands above the data.
    pub header: Header,
    /// Lines before the table.
    pub skip_lines: Option<usize>,
    /// Which lines are comments; by default those that begin with `#`, `%` or `//`.
    pub comments: Option<Comments>,
}

/// What stands above the data.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Header {
    /// Found out.
    #[default]
    Auto,
    /// Nothing.
    None,
    /// A row of names.
    Names,
    /// A row of names, then a row of units.
    NamesAndUnits,
}

/// A log.
#[derive(Debug, Clone, PartialEq)]
pub struct TextLog {
    /// How it is laid out.
    pub layout: Layout,
    /// Columns of `rows` cells each.
    pub columns: Vec<Column>,
    /// Samples.
    pub rows: usize,
    /// The line of every sample.
    pub lines: LineMap,
    /// What is odd about it.
    pub findings: Vec<Finding>,
    /// Lines before the table, as they stand.
    pub metadata: Vec<String>,
}

impl TextLog {
    /// The line of a sample, from 1.
    pub fn line_of(&self, row: usize) -> usize {
        self.lines.line_of(row)
    }

    /// The column of a name.
    pub fn column(&self, name: &str) -> Option<&Column> {
        self.columns.iter().find(|c| c.name == name)
    }
}

/// Reads a log: its layout is what `options` ask for, the rest is found out from the bytes.
///
/// ```
/// use pneuval_ingest::formats::csv::{CsvOptions, read};
/// let log = read("run.csv", b"time (s);p [kPa]\n0,00;1,5\n0,01;ERR\n", &CsvOptions::default())?;
/// assert_eq!((log.rows, log.columns[1].unit.as_deref()), (2, Some("kPa")));
/// assert_eq!(log.findings[0].text, "column `p [kPa]`: 1 cell is not a number (line 3: `ERR`); left as holes");
/// # Ok::<(), pneuval_ingest::IngestError>(())
/// ```
///
/// # Errors
/// [`IngestError::Unusable`] if there is no table of numbers, or not the header that was asked for, and for sizes beyond
/// [`crate::limits`]; [`IngestError::TooLarge`] for too many bytes.
pub fn read(file: &str, bytes: &[u8], options: &CsvOptions) -> Result<TextLog, IngestError> {
    read_log(&RawFile::of_bytes(file, bytes), options, Keep::All, CHUNK)
}

/// Reads a raw file of delimited text as a recording of one table, in memory for the columns that are kept and a bounded rest.
///
/// # Errors
/// As [`read`], and [`IngestError::Read`] if the file cannot be read.
pub fn read_raw(raw: &RawFile, options: &CsvOptions, keep: Keep) -> Result<Recording, IngestError> {
    Ok(read_log(raw, options, keep, CHUNK)?.into())
}

/// Reads a log in pieces of `chunk` bytes, whose size changes nothing of what is read.
fn read_log(raw: &RawFile, options: &CsvOptions, keep: Keep, chunk: usize) -> Result<TextLog, IngestError> {
    let file = raw.name();
    if raw.len() > LOG_BYTES_MAX {
        return Err(IngestError::TooLarge { path: file.into(), bytes: raw.len(), limit: LOG_BYTES_MAX });
    }
    let mut found = sniff::sniff(raw, options)?;
    let (names, units) = names_and_units(&mut found.layout);
    let keep: Vec<bool> = names.iter().enumerate().map(|(i, name)| keep.keeps("", name, i + 1)).collect();
    // What is kept can be looked at later.
    let clocks: Vec<Option<ClockUnit>> = (0..names.len())
        .map(|i| {
            let seems = || clock_unit(&names[i], units[i].as_deref());
            // The first column of a log without names is often its time.
            let first = || (i == 0 && found.layout.names.is_none() && units[i].is_none()).then_some(ClockUnit::Guessed);
            if keep[i] { None } else { seems().or_else(first) }
        })
        .collect();
    let mut is_text = found.text.clone();
    let pass =
        |is_text: &[bool]| rows::read(rows::Task { raw, found: &found, is_text, keep: &keep, clocks: &clocks, chunk });
    let mut rows = pass(&is_text)?;
    // The first lines may not be like the others; kinds are those of the whole column, and the same in a second pass.
    if let Some(kinds) = rows.other_kinds(&is_text) {
        drop(rows);
        is_text = kinds;
        rows = pass(&is_text)?;
    }

    let rows::Rows { numbers, texts, lines, mut tally, metadata, bad, ending, .. } = rows;
    let bad = if bad.count > 0 { &bad } else { &ending.bad };
    let sniff::Found { mut layout, misfit, cut, glued, .. } = found;
    layout.encoding = ending.encoding.with(bad);
    if layout.encoding != Encoding::Utf8 {
        // Behind the delimiter; that single lines are Latin-1 is known at the end only.
        layout.reasons.insert(1, format!("the text is {}", layout.encoding.name()));
    }
    tell_file(file, layout.encoding, bad, &ending, &lines, &mut tally);
    tell_head(file, &layout, misfit, &cut, glued.as_ref(), &mut tally);
    let findings = tally.findings(file, &names, layout.cells_per_line);
    let columns = numbers
        .into_iter()
        .zip(texts)
        .zip(is_text.into_iter().zip(keep))
        .zip(names.into_iter().zip(units))
        .map(|(((numbers, text), (is_text, keep)), (name, unit))| match (is_text, keep) {
            (false, _) => numbers.finish(name, unit),
            (true, true) => Column::new(&name, unit.as_deref(), Cells::Text(text)),
            (true, false) => Column::new(&name, unit.as_deref(), Cells::NotKept),
        })
        .collect();
    Ok(TextLog { layout, columns, rows: lines.rows(), lines, findings, metadata })
}

/// Names of columns of stamps.
pub(crate) const TIMES: [&str; 8] = ["t", "time", "timestamp", "stamp", "seconds", "elapsed", "zeit", "millis"];

/// Whether a column seems to be a clock: by its unit or by its name.
pub(crate) fn clock_unit(name: &str, unit: Option<&str>) -> Option<ClockUnit> {
    if let Some((unit, _)) = unit.and_then(Unit::parse_loose) {
        return (unit.dimension == Dimension::Time).then(|| ClockUnit::Seconds(unit.to_si(1.0)));
    }
    let lower = name.to_lowercase();
    let named = lower.split(|c: char| !c.is_alphanumeric()).any(|word| TIMES.contains(&word));
    named.then_some(ClockUnit::Guessed)
}

impl From<TextLog> for Recording {
    fn from(log: TextLog) -> Self {
        let TextLog { layout, columns, rows, lines, findings, metadata } = log;
        let table =
            Table { name: String::new(), schema: None, columns, rows, lines, clock: None, decimal: layout.decimal };
        Self {
            format: "delimited text",
            tables: vec![table],
            findings,
            reasons: layout.reasons,
            metadata,
            origin: None,
            photographs: vec![],
        }
    }
}

/// Findings about the bytes.
pub(in crate::formats) fn tell_file(
    file: &str,
    encoding: Encoding,
    bad: &BadLines,
    ending: &Ending,
    lines: &LineMap,
    tally: &mut tally::Tally,
) {
    let end = [(lines.rows(), lines.line_of(lines.rows().saturating_sub(1)))];
    if bad.count > 0 {
        let what = match encoding {
            Encoding::Latin1 => "not in UTF-8, read as Latin-1",
            _ => "with UTF-16 units that mean nothing, shown as `\u{fffd}`",
        };
        let first: Vec<String> = bad.first.iter().take(3).map(ToString::to_string).collect();
        let more = if bad.count > first.len() { ", ..." } else { "" };
        let lines_word = if bad.count == 1 { "line" } else { "lines" };
        let sentence = format!("{} {lines_word} {what} ({lines_word} {}{more})", bad.count, first.join(", "));
        tally.encoding(file, bad.count, &bad.first, lines, sentence);
    }
    if ending.zeros > 0 {
        tally.tell(file, FindingKind::Truncated, Severity::Lost, &end, zero_bytes(ending.zeros));
    }
    if ending.half_unit {
        tally.tell(file, FindingKind::Truncated, Severity::Lost, &end, HALF_CHARACTER.to_owned());
    }
}

/// Findings about what stands above the data.
fn tell_head(
    file: &str,
    layout: &Layout,
    misfit: Option<(usize, usize)>,
    cut: &[usize],
    glued: Option<&Glued>,
    tally: &mut tally::Tally,
) {
    let usual = layout.cells_per_line;
    if let Some(Glued { line, cell, name }) = glued {
        let holds = format!("line {line} holds the names and, without a line end,");
        let (severity, text) = if let Some(name) = name {
            let number = shown(cell.strip_prefix(name.as_str()).unwrap_or_default());
            let done = format!("{} is read as the name {} and the number {number}", shown(cell), shown(name));
            (Severity::Note, format!("{holds} the first sample: {done}"))
        } else {
            let open = format!("where in {} the name ends is not certain", shown(cell));
            let done = "the column has no name, and the sample is left out";
            (Severity::Excluded, format!("{holds} a sample: {open}; {done}"))
        };
        tally.tell(file, FindingKind::HeaderGlued, severity, &[(0, *line)], text);
    }
    if let Some((line, cells)) = misfit {
        let what = if layout.names.is_some() {
            format!("columns {} to {cells} hold nothing where lines are not longer", usual + 1)
        } else {
            "which name belongs to which column is open, so no name is used".to_owned()
        };
        let text = format!("line {line} names {cells} columns, most lines hold {usual} cells: {what}");
        tally.tell(file, FindingKind::HeaderMismatch, Severity::Note, &[(0, line)], text);
    }
    for line in cut {
        let text = format!(
            "line {line} holds numbers but stands apart from the table (names between, or not {usual} cells); it is left out"
        );
        tally.tell(file, FindingKind::SkippedLine, Severity::Excluded, &[(0, *line)], text);
    }
}

/// Names and units of the columns; units that are taken from names are told among the reasons.
fn names_and_units(layout: &mut Layout) -> (Vec<String>, Vec<Option<String>>) {
    let mut names: Vec<String> = Vec::with_capacity(layout.columns);
    let mut units = Vec::with_capacity(layout.columns);
    let (mut taken, mut copies) = (HashSet::new(), HashMap::new());
    for column in 0..layout.columns {
        let written = layout.names.as_ref().and_then(|names| names.get(column)).map_or("", |name| name.trim());
        let base = if written.is_empty() { format!("column {}", column + 1) } else { written.to_owned() };
        let mut name = base.clone();
        // Counted on from where the last of that name stopped: four thousand equal names must not take minutes.
        let copy = copies.entry(base.clone()).or_insert(1);
        while taken.contains(&name) {
            *copy += 1;
            name = format!("{base} ({copy})");
        }
        taken.insert(name.clone());
        let of_row = layout.units.as_ref().map(|units| units.get(column).map_or("", |unit| without_brackets(unit)));
        let unit = match of_row {
            Some(unit) => (!unit.is_empty()).then(|| unit.to_owned()),
            None => unit_in_name(written).map(|unit| {
                layout.reasons.push(format!("the unit {unit} of column {name} is taken from its name"));
                unit.to_owned()
            }),
        };
        names.push(name);
        units.push(unit);
    }
    (names, units)
}

fn without_brackets(unit: &str) -> &str {
    let unit = unit.trim();
    let inside = |open, close| unit.strip_prefix(open).and_then(|rest| rest.strip_suffix(close));
    inside('(', ')').or(inside('[', ']')).unwrap_or(unit).trim()
}

/// Words at the end of a name that are rather words than units: `p_min`, `flow_in`, `pressure_g`.
const NOT_AFTER_UNDERSCORE: [&str; 6] = ["in", "min", "g", "h", "1", "%"];

/// The unit in a name: `pressure (kPa)`, `pressure [kPa]`, `pressure / kPa`, `pressure_kPa`, `micros`.
pub(crate) fn unit_in_name(name: &str) -> Option<&str> {
    let name = name.trim();
    let bracketed = |open, close| name.strip_suffix(close).and_then(|rest| rest.rsplit_once(open));
    let known = |unit: &str| Unit::parse_loose(unit).is_some();
    if let Some((_, unit)) = bracketed('(', ')').or(bracketed('[', ']')) {
        let unit = unit.trim();
        if known(unit) {
            return Some(unit);
        }
        // `curvature per pressure 1/(m Pa)`: the bracket belongs to the unit.
    }
    if let Some((_, unit)) = name.rsplit_once(" / ").or_else(|| name.rsplit_once('/'))
        && Unit::parse_loose(unit).is_some_and(|(_, spelling)| spelling == Spelling::Exact)
    {
        return Some(unit.trim());
    }
    // What a sketch for a microcontroller calls its clocks.
    match name.to_lowercase().trim_end_matches("()") {
        "millis" => return Some("ms"),
        "micros" => return Some("us"),
        _ => {}
    }
    let (_, unit) = name.rsplit_once('_')?;
    (known(unit) && !NOT_AFTER_UNDERSCORE.contains(&unit.to_lowercase().as_str())).then_some(unit)
}

fn unusable(file: &str, line: Option<usize>, expected: &str, found: String, next: &str) -> IngestError {
    IngestError::Unusable {
        place: Place::new(file, line, None),
        expected: expected.to_owned(),
        found,
        next: next.to_owned(),
    }
}
