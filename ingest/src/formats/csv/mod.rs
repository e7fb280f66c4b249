//! Delimited text as rigs write it: any delimiter, with or without header, and the damage that happens while logging.
//!
//! [`read`] finds out the layout from the bytes and says how; it takes every sample, keeps holes as NaN where no number
//! stands, and tells each such place as a [`Finding`]. What is asked for in [`CsvOptions`] is never second-guessed. Published tables,
//! which people write, are read strictly by [`crate::table`] instead.
//!
//! | file | holds |
//! |---|---|
//! | `text.rs` | encodings, line ends, quotes: bytes to cells |
//! | `numbers.rs` | decimal numbers, correctly rounded |
//! | `sniff.rs` | the layout |
//! | `rows.rs` | the pass over the data, fast where lines are plain |
//! | `tally.rs` | findings while reading, and their sentences |
//! | `write.rs` | the writer |

mod cells;
mod numbers;
mod rows;
mod sniff;
mod tally;
mod text;
mod write;

use std::io::Read;

use crate::error::{IngestError, Place};
use crate::finding::{Finding, FindingKind, LineMap, Severity};
use crate::limits::LOG_BYTES_MAX;
use crate::raw::RawFile;
use crate::recording::{Cells, Column, Keep, Recording, Table};
use crate::units::{Spelling, Unit};

pub(crate) use cells::{Kind as CellKind, kind as cell_kind};
pub use numbers::{Decimal, parse as parse_number};
pub use sniff::{Comment, Comments, Layout};
pub use text::Encoding;
pub use write::{WriteOptions, write};

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
    check_size(file, bytes)?;
    let text = text::decode(bytes);
    let found = sniff::sniff(file, &text, options)?;
    let mut is_text = found.text.clone();
    let mut rows = rows::read(file, &text.bytes, &found, &is_text)?;
    // The first lines may not be like the others; kinds are those of the whole column, and the same in a second pass.
    if let Some(kinds) = rows.other_kinds(&is_text) {
        is_text = kinds;
        rows = rows::read(file, &text.bytes, &found, &is_text)?;
    }
    let mut layout = found.layout;
    let (names, units) = names_and_units(&mut layout);
    let metadata = metadata(&text.bytes, found.metadata_lines);

    let rows::Rows { numbers, texts, lines, mut tally, .. } = rows;
    tell_file(file, &text, &lines, &mut tally);
    tell_head(file, &layout, found.misfit, &found.cut, &mut tally);
    let findings = tally.findings(file, &names, layout.cells_per_line);
    let columns = numbers
        .into_iter()
        .zip(texts)
        .zip(is_text)
        .zip(names.into_iter().zip(units))
        .map(|(((numbers, text), is_text), (name, unit))| {
            let cells = if is_text { Cells::Text(text) } else { Cells::Numbers(numbers) };
            Column::new(&name, unit.as_deref(), cells)
        })
        .collect();
    Ok(TextLog { layout, columns, rows: lines.rows(), lines, findings, metadata })
}

/// Reads a raw file of delimited text as a recording of one table.
///
/// # Errors
/// As [`read`].
pub fn read_raw(raw: &RawFile, options: &CsvOptions, _keep: Keep) -> Result<Recording, IngestError> {
    let mut bytes = Vec::new();
    raw.reader()?.read_to_end(&mut bytes).map_err(|source| raw.failed(source))?;
    Ok(read(raw.name(), &bytes, options)?.into())
}

impl From<TextLog> for Recording {
    fn from(log: TextLog) -> Self {
        let TextLog { layout, columns, rows, lines, findings, metadata } = log;
        let table = Table { name: String::new(), schema: None, columns, rows, lines, clock: None };
        Self {
            format: "delimited text",
            tables: vec![table],
            findings,
            reasons: layout.reasons,
            metadata,
            origin: None,
        }
    }
}

fn check_size(file: &str, bytes: &[u8]) -> Result<(), IngestError> {
    if bytes.len() as u64 <= LOG_BYTES_MAX {
        return Ok(());
    }
    Err(IngestError::TooLarge { path: file.into(), bytes: bytes.len() as u64, limit: LOG_BYTES_MAX })
}

/// Findings about the bytes.
fn tell_file(file: &str, text: &text::Text, lines: &LineMap, tally: &mut tally::Tally) {
    let end = [(lines.rows(), lines.line_of(lines.rows().saturating_sub(1)))];
    if text.bad_lines > 0 {
        let what = match text.encoding {
            Encoding::Latin1 => "not in UTF-8, read as Latin-1",
            _ => "with UTF-16 units that mean nothing, shown as `\u{fffd}`",
        };
        let first: Vec<String> = text.first_bad_lines.iter().take(3).map(ToString::to_string).collect();
        let more = if text.bad_lines > first.len() { ", ..." } else { "" };
        let lines_word = if text.bad_lines == 1 { "line" } else { "lines" };
        let sentence = format!("{} {lines_word} {what} ({lines_word} {}{more})", text.bad_lines, first.join(", "));
        tally.encoding(file, text.bad_lines, &text.first_bad_lines, lines, sentence);
    }
    if text.zeros > 0 {
        let sentence = format!(
            "the file ends in {} zero bytes, as after a power cut while it was written; what they stand for is lost",
            text.zeros
        );
        tally.tell(file, FindingKind::Truncated, Severity::Lost, &end, sentence);
    }
    if text.half_unit {
        let sentence = "the file ends within a character; what followed is lost".to_owned();
        tally.tell(file, FindingKind::Truncated, Severity::Lost, &end, sentence);
    }
}

/// Findings about what stands above the data.
fn tell_head(file: &str, layout: &Layout, misfit: Option<(usize, usize)>, cut: &[usize], tally: &mut tally::Tally) {
    let usual = layout.cells_per_line;
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
    for column in 0..layout.columns {
        let written = layout.names.as_ref().and_then(|names| names.get(column)).map_or("", |name| name.trim());
        let base = if written.is_empty() { format!("column {}", column + 1) } else { written.to_owned() };
        let mut name = base.clone();
        let mut copy = 1;
        while names.contains(&name) {
            copy += 1;
            name = format!("{base} ({copy})");
        }
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

/// The unit in a name: `pressure (kPa)`, `pressure [kPa]`, `pressure / kPa`, `pressure_kPa`.
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
    let (_, unit) = name.rsplit_once('_')?;
    (known(unit) && !NOT_AFTER_UNDERSCORE.contains(&unit.to_lowercase().as_str())).then_some(unit)
}

fn metadata(bytes: &[u8], count: usize) -> Vec<String> {
    let (mut lines, mut at) = (Vec::new(), 0);
    while lines.len() < count && at < bytes.len() {
        let end = text::line_end(bytes, at);
        lines.push(text::to_text(&bytes[at..end]));
        at = text::after_line_end(bytes, end);
    }
    lines
}

fn unusable(file: &str, line: Option<usize>, expected: &str, found: String, next: &str) -> IngestError {
    IngestError::Unusable {
        place: Place::new(file, line, None),
        expected: expected.to_owned(),
        found,
        next: next.to_owned(),
    }
}
