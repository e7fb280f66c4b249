//! What stands above the data: names, units, failed samples, a header glued to the first sample.

use super::super::cells::{Kind, WRONG_VALUE, filled, kind};
use super::super::numbers::{self, Decimal};
use super::super::source::Window;
use super::super::text::{Cell, as_text, split, trim};
use super::super::{Header, unusable};
use super::candidate::{Candidate, Line};
use super::{CommentRule, CsvOptions, Found, Layout, Sample};
use crate::IngestError;
use crate::limits::LOG_COLUMNS_MAX;
use crate::units::Unit;

/// Whether a line that does not look like data is a sample all the same: every number in it is there, missing or said to be wrong.
fn is_failed_sample(
    window: Window,
    line: &Line,
    usual: usize,
    is_text: &[bool],
    delimiter: u8,
    decimal: Decimal,
) -> bool {
    let mut cells = Vec::new();
    split(window, line.record.start, delimiter, &mut cells);
    let wrong = |cell: &[u8]| WRONG_VALUE.iter().any(|word| cell.eq_ignore_ascii_case(word.as_bytes()));
    let fits = |(column, cell): (usize, &Cell)| {
        let cell = cell.of(window.bytes);
        is_text.get(column) == Some(&true) || kind(cell, decimal) != Kind::Text || wrong(cell)
    };
    line.cells == usual && cells.iter().enumerate().all(fits) && is_text.iter().any(|is_text| !is_text)
}

/// How many of the lines above the data, nearest first, are samples that failed.
///
/// Words such as `error` may also be names. A line that holds nothing else is a sample only where names stand above it: a line of
/// `usual` cells without a number.
fn failed_samples(above: &[usize], lines: &[Line], usual: usize, is_failed: impl Fn(usize) -> bool) -> usize {
    let failed = above.iter().take_while(|i| is_failed(**i)).count();
    let named = above.get(failed).is_some_and(|i| lines[*i].cells == usual && lines[*i].facts.numbers == 0);
    let no_words = |line: &Line| line.facts.texts == 0 || line.facts.numbers > 0;
    above[..failed].iter().take_while(|i| named || no_words(&lines[**i])).count()
}

/// A header and the first sample on one line: the line end between them is missing.
#[derive(Debug)]
pub(in super::super) struct Glued {
    pub line: usize,
    /// The cell that is half name, half number.
    pub cell: String,
    /// The name; `None` where it is not certain where it ends, and the sample is lost.
    pub name: Option<String>,
}

impl Found {
    pub(super) fn new(
        file: &str,
        sample: &Sample,
        options: &CsvOptions,
        candidate: Candidate,
    ) -> Result<Self, IngestError> {
        let window = sample.window;
        let bytes = window.bytes;
        let Candidate { delimiter, decimal, lines, usual, start, is_text, .. } = candidate;
        let mut cells = Vec::new();
        let mut words = |line: &Line| -> Vec<String> {
            split(window, line.record.start, delimiter, &mut cells);
            cells[..filled(&cells)].iter().map(|c| c.text(bytes)).collect()
        };
        let raw = |line: &Line| trim(&bytes[line.record.start..line.record.end]).to_vec();

        let skipped = |l: &Line| options.skip_lines.is_some_and(|skip| l.line <= skip);
        let mut before: Vec<usize> = (0..start)
            .rev()
            .filter(|i| !lines[*i].blank && lines[*i].comment.is_none() && !skipped(&lines[*i]))
            .collect();
        let mut start = start;
        let failed = failed_samples(&before, &lines, usual, |i| {
            is_failed_sample(window, &lines[i], usual, &is_text, delimiter, decimal)
        });
        if let Some(first) = before.drain(..failed).next_back() {
            start = first;
        }
        let glued = match options.header {
            Header::Auto | Header::Names => {
                glue(window, &lines, before.first().copied(), start, &is_text, (delimiter, decimal))
            }
            Header::None | Header::NamesAndUnits => None,
        };
        let (mut names, mut units) = (None, None);
        match options.header {
            Header::None => {}
            Header::Auto | Header::Names if glued.is_some() => names = before.first().copied(),
            Header::Auto => {
                let mut above = before.iter().copied().take_while(|i| lines[*i].facts.numbers == 0);
                names = above.next();
                if let (Some(last), Some(first)) = (names, above.next())
                    && is_unit_row(&words(&lines[last]))
                {
                    (names, units) = (Some(first), Some(last));
                }
            }
            Header::Names | Header::NamesAndUnits => {
                let wanted = if options.header == Header::Names { 1 } else { 2 };
                let mut rows: Vec<usize> = before.iter().copied().take(wanted).rev().collect();
                // Names that are numbers look like data.
                while rows.len() < wanted && start + 1 < lines.len() {
                    rows.push(start);
                    let data = lines[start + 1..].iter().position(|l| !l.blank && l.comment.is_none());
                    let Some(data) = data else { break };
                    start += 1 + data;
                }
                if rows.len() < wanted || rows.contains(&start) {
                    let expected = if wanted == 1 { "a row of names" } else { "a row of names and a row of units" };
                    let line = Some(lines[start].line);
                    return Err(unusable(file, line, expected, "data".to_owned(), "say that there is no header"));
                }
                names = rows.first().copied();
                units = rows.get(1).copied();
            }
        }

        let mut reasons = Vec::new();
        let seen = if options.delimiter.is_some() || options.decimal.is_some() { "as asked" } else { "found" };
        reasons.push(format!(
            "{} between cells and a decimal {}, {seen}: under them most cells of the first lines are numbers",
            delimiter_name(delimiter),
            if decimal == Decimal::Point { "point" } else { "comma" }
        ));

        let mut found = Self {
            layout: Layout {
                encoding: sample.encoding,
                delimiter,
                decimal,
                comment: lines[..start].iter().find_map(|l| l.comment),
                names: None,
                names_line: None,
                units: None,
                units_line: None,
                data_line: lines[start].line,
                columns: usual,
                cells_per_line: usual,
                reasons,
            },
            comments: CommentRule { asked: options.comments, delimiter },
            metadata_lines: 0,
            data_at: sample.offset + lines[start].record.start as u64,
            text: is_text,
            header: Vec::new(),
            misfit: None,
            cut: Vec::new(),
            glued: None,
        };
        if let (Some(row), Some((glued, at))) = (names, glued) {
            let above = before.get(1).map(|i| &lines[*i]).filter(|l| l.cells == usual && l.facts.numbers == 0);
            found.take_glued(sample, &lines[row], words(&lines[row]), glued, at);
            let last = found.layout.names.clone().unwrap_or_default();
            if let Some(line) = above.filter(|_| is_unit_row(&last)) {
                (found.layout.units, found.layout.units_line) = (Some(last), found.layout.names_line);
                found.take_names(line, &raw(line), words(line), options);
                found.header.push(raw(line));
            }
        } else if let Some(row) = names {
            found.take_names(&lines[row], &raw(&lines[row]), words(&lines[row]), options);
            found.header.push(raw(&lines[row]));
        }
        if let Some(row) = units {
            found.layout.units = Some(words(&lines[row]));
            found.layout.units_line = Some(lines[row].line);
            found.header.push(raw(&lines[row]));
            found.layout.reasons.push(format!("line {} holds the units", lines[row].line));
        }
        if names.is_none() && options.header == Header::Auto {
            found.names_from_comment(bytes, &lines[..start]);
        }
        // The names of a header that is glued to data stand on the line of the data.
        let table = found.layout.names_line.or(units.map(|row| lines[row].line)).unwrap_or(found.layout.data_line);
        found.metadata_lines = table - 1;
        if names.is_some() {
            // Told, in case it was a sample.
            let alone =
                lines[..start].iter().filter(|l| l.comment.is_none() && l.facts.numbers == usual && !skipped(l));
            found.cut = alone.map(|l| l.line).filter(|line| Some(*line) != found.layout.names_line).collect();
        } else {
            let cut = before.iter().take_while(|i| lines[**i].facts.numbers > 0 && lines[**i].facts.texts == 0);
            found.cut = cut.map(|i| lines[*i].line).collect();
            found.cut.reverse();
        }
        if found.layout.columns > LOG_COLUMNS_MAX {
            let expected = format!("at most {LOG_COLUMNS_MAX} columns");
            let line = Some(found.layout.data_line);
            return Err(unusable(
                file,
                line,
                &expected,
                found.layout.columns.to_string(),
                "is this a log of channels?",
            ));
        }
        found.text.resize(found.layout.columns, false);
        let data = found.layout.data_line;
        found.layout.reasons.push(format!("data begin on line {data}; cells on most lines: {usual}"));
        Ok(found)
    }

    /// Names are given to columns only where it is certain which name belongs to which.
    fn take_names(&mut self, line: &Line, raw: &[u8], names: Vec<String>, options: &CsvOptions) {
        let usual = self.layout.cells_per_line;
        let by_blanks = self.layout.delimiter == b' ';
        // Between blanks, names may hold single blanks: `Time (s)  Pressure (kPa)`.
        let apart = if by_blanks && names.len() != usual { parted_by_two_blanks(raw) } else { Vec::new() };
        let names = if apart.len() == usual { apart } else { names };
        // A name of two words would move all names behind it.
        if names.len() < usual || (by_blanks && names.len() > usual) {
            self.misfit = Some((line.line, names.len()));
            // Free text before the data is no header; one with several cells is a header that does not fit.
            if names.len() == 1 && options.header == Header::Auto {
                self.misfit = None;
                self.layout.reasons.push(format!("line {} is not a header: it holds one cell", line.line));
                return;
            }
            self.layout.reasons.push(format!(
                "line {} names {} columns where lines hold {usual} cells: no name is used",
                line.line,
                names.len()
            ));
        } else {
            if names.len() > usual {
                self.misfit = Some((line.line, names.len()));
                self.layout.columns = names.len();
            }
            self.layout.reasons.push(format!("line {} holds the names", line.line));
            self.layout.names = Some(names);
        }
        self.layout.names_line = Some(line.line);
    }

    /// Names of a header whose last name runs into the first sample; the sample begins at `at` in the sample of lines.
    fn take_glued(&mut self, sample: &Sample, line: &Line, mut words: Vec<String>, glued: Glued, at: usize) {
        let usual = self.layout.cells_per_line;
        words.truncate(usual);
        let bytes = sample.window.bytes;
        self.header.push(trim(&bytes[line.record.start..line.record.end]).to_vec());
        if let Some(last) = words.last_mut() {
            // A name is given to the column only where it is certain.
            *last = glued.name.clone().unwrap_or_default();
        }
        if glued.name.is_some() {
            self.header.push(trim(&bytes[line.record.start..at]).to_vec());
            self.data_at = sample.offset + at as u64;
            self.layout.data_line = line.line;
        }
        self.layout.names = Some(words);
        self.layout.names_line = Some(line.line);
        self.layout.reasons.push(format!("line {} holds the names; a sample runs into the last of them", line.line));
        self.glued = Some(glued);
    }

    /// `# time, pressure`: the last comment before the data, if it holds exactly one word per column.
    fn names_from_comment(&mut self, bytes: &[u8], before: &[Line]) {
        let Some(line) = before.last() else { return };
        let Some(comment) = line.comment else { return };
        let text = trim(&bytes[line.record.start..line.record.end]);
        let Some(text) = text.strip_prefix(comment.prefix().as_bytes()) else { return };
        let mut cells = Vec::new();
        split(Window::whole(text), 0, self.layout.delimiter, &mut cells);
        let all_text = cells.iter().all(|c| kind(c.of(text), self.layout.decimal) == Kind::Text);
        if cells.len() > 1 && cells.len() == self.layout.cells_per_line && all_text {
            self.layout.names = Some(cells.iter().map(|c| c.text(text)).collect());
            self.layout.names_line = Some(line.line);
            self.header.push(trim(&bytes[line.record.start..line.record.end]).to_vec());
            let reason = format!("line {}, a comment, holds the names: one word for each column", line.line);
            self.layout.reasons.push(reason);
        }
    }
}

/// Whether the line above the data is a header into whose last name the first sample runs, `time,p,flex0.00,1.2,3`; and where in the
/// window that sample begins.
///
/// Where the name ends is certain if what stands before the longest number at the end of the cell is neither digit nor sign; if all
/// digits before the decimal sign belong to the number, since there is but one or the next line has as many in this column; and if
/// the number does not fall behind the next where those that follow ascend, as stamps do.
fn glue(
    window: Window,
    lines: &[Line],
    above: Option<usize>,
    start: usize,
    is_text: &[bool],
    (delimiter, decimal): (u8, Decimal),
) -> Option<(Glued, usize)> {
    let bytes = window.bytes;
    let line = lines.get(above?)?;
    let usual = is_text.len();
    if usual < 2 || line.cells != 2 * usual - 1 || is_text.first() == Some(&true) {
        return None;
    }
    let mut cells = Vec::new();
    split(window, line.record.start, delimiter, &mut cells);
    let (names, values) = cells.get(..line.cells)?.split_at(usual);
    let (last, names) = names.split_last()?;
    let is_value = |(column, cell): (usize, &Cell)| is_text[1 + column] || kind(cell.of(bytes), decimal) != Kind::Text;
    if !names.iter().all(|c| kind(c.of(bytes), decimal) == Kind::Text) || !values.iter().enumerate().all(is_value) {
        return None;
    }
    let cell = last.of(bytes);
    let number = |at: usize| numbers::parse(&cell[at..], decimal).filter(|number| number.is_finite());
    let (at, first) = (1..cell.len()).find_map(|at| Some((at, number(at)?))).filter(|_| !last.quoted)?;

    let mut cells = Vec::new();
    let mut first_cells = lines[start..].iter().filter(|l| !l.blank && l.comment.is_none()).map(|line| {
        split(window, line.record.start, delimiter, &mut cells);
        let cell = cells.first().map_or(&[][..], |c| c.of(bytes));
        (whole_digits(cell), numbers::parse(cell, decimal))
    });
    let (next, then) = (first_cells.next()?, first_cells.next());
    let digits = whole_digits(&cell[at..]);
    let ascends = match (next.1, then.and_then(|then| then.1)) {
        (Some(next), Some(then)) if next < then => first < next,
        _ => true,
    };
    let ends_name = !matches!(cell[at - 1], b'0'..=b'9' | b'+' | b'-' | b'.' | b',');
    let is_certain = ends_name && (digits == 1 || digits == next.0) && ascends;
    let name = is_certain.then(|| as_text(&cell[..at]));
    let glued = Glued { line: line.line, cell: as_text(cell), name };
    Some((glued, last.start + at))
}

/// Digits before the decimal sign of a number.
fn whole_digits(number: &[u8]) -> usize {
    let unsigned = number.strip_prefix(b"-").or(number.strip_prefix(b"+")).unwrap_or(number);
    unsigned.iter().take_while(|b| b.is_ascii_digit()).count()
}

/// Words that are at least two blanks, or a tab, apart.
fn parted_by_two_blanks(line: &[u8]) -> Vec<String> {
    let text = as_text(line).replace('\t', "  ");
    text.split("  ").map(str::trim).filter(|word| !word.is_empty()).map(str::to_owned).collect()
}

fn delimiter_name(delimiter: u8) -> String {
    match delimiter {
        b'\t' => "a tab".to_owned(),
        b' ' => "blanks".to_owned(),
        other => format!("`{}`", char::from(other)),
    }
}

/// Whether every cell is a unit, a unit in brackets, a dash or empty, and one at least is a unit.
fn is_unit_row(cells: &[String]) -> bool {
    let known = |cell: &String| Unit::parse_loose(cell).is_some();
    let bracketed = |cell: &String| cell.starts_with(['(', '[']) && cell.ends_with([')', ']']);
    cells.iter().all(|c| c.is_empty() || c == "-" || known(c) || bracketed(c)) && cells.iter().any(known)
}
