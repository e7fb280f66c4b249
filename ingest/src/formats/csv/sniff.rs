//! Finding out how a log is laid out, from its first lines.
//!
//! Every delimiter and decimal sign is tried on the first lines; the pair under which they hold the most numbers wins. Then the
//! table begins at its first line of data, and what stands directly before it may be its header.

use super::cells::{Facts, Kind, WRONG_VALUE, facts, filled, kind};
use super::numbers::Decimal;
use super::text::{Cell, Encoding, Record, Text, after_line_end, line_end, line_ends, split, to_text, trim};
use super::{CsvOptions, Header, unusable};
use crate::IngestError;
use crate::error::shown;
use crate::limits::{LINE_BYTES_MAX, LOG_COLUMNS_MAX};
use crate::units::Unit;

/// What marks a comment line.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Comment {
    /// `#`
    Hash,
    /// `%`
    Percent,
    /// `//`
    Slashes,
}

impl Comment {
    const ALL: [Self; 3] = [Self::Hash, Self::Percent, Self::Slashes];

    /// As written.
    pub fn prefix(self) -> &'static str {
        match self {
            Self::Hash => "#",
            Self::Percent => "%",
            Self::Slashes => "//",
        }
    }
}

/// Which lines are comments.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Comments {
    /// Lines that begin so.
    Of(Comment),
    /// None.
    None,
}

/// How a log is laid out.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Layout {
    /// How the text is encoded.
    pub encoding: Encoding,
    /// What stands between cells; a blank stands for any run of blanks and tabs.
    pub delimiter: u8,
    /// The decimal sign.
    pub decimal: Decimal,
    /// What marked comment lines before or at the head of the table, if any did.
    pub comment: Option<Comment>,
    /// Names of the columns as written.
    pub names: Option<Vec<String>>,
    /// The line of the names, from 1.
    pub names_line: Option<usize>,
    /// Units of the columns as written in a row of their own.
    pub units: Option<Vec<String>>,
    /// The line of the units.
    pub units_line: Option<usize>,
    /// The first line of data.
    pub data_line: usize,
    /// Columns.
    pub columns: usize,
    /// Cells that most lines hold; fewer than `columns` where the header names more.
    pub cells_per_line: usize,
    /// How each of these was found out, one sentence each.
    pub reasons: Vec<String>,
}

/// A layout with what only the reader needs.
#[derive(Debug)]
pub(super) struct Found {
    pub layout: Layout,
    pub comments: CommentRule,
    /// Lines before the table.
    pub metadata_lines: usize,
    /// Offset of the first line of data.
    pub data_at: usize,
    /// Whether a column holds text rather than numbers.
    pub text: Vec<bool>,
    /// Names and units as they stand in the file, to know them again among the data.
    pub header: Vec<Vec<u8>>,
    /// A header that does not fit: its line, its cells.
    pub misfit: Option<(usize, usize)>,
    /// Lines directly before the data that hold numbers, but not as many as the others.
    pub cut: Vec<usize>,
}

/// Which lines are comments, given the delimiter.
#[derive(Debug, Clone, Copy)]
pub(super) struct CommentRule {
    asked: Option<Comments>,
    delimiter: u8,
}

impl CommentRule {
    /// The mark of a comment line. A mark followed by a delimiter is a cell: a unit `%`, a column named `#`.
    pub fn mark(self, line: &[u8]) -> Option<Comment> {
        let line = trim(line);
        // Numbers are by far the most usual beginning.
        if !matches!(line.first(), Some(b'#' | b'%' | b'/')) {
            return None;
        }
        let of = |comment: Comment| {
            let rest = line.strip_prefix(comment.prefix().as_bytes())?;
            let is_cell = self.delimiter != b' ' && rest.first() == Some(&self.delimiter);
            (!is_cell).then_some(comment)
        };
        match self.asked {
            Some(Comments::None) => None,
            Some(Comments::Of(comment)) => of(comment),
            None => Comment::ALL.into_iter().find_map(of),
        }
    }
}

/// A line of the sample.
struct Line {
    record: Record,
    line: usize,
    /// Cells up to the last that is not empty.
    cells: usize,
    /// All cells.
    cells_with_empty: usize,
    facts: Facts,
    blank: bool,
    comment: Option<Comment>,
}

/// Bytes that are looked at first; sixteen times as many if they hold no table.
const SAMPLE_BYTES: usize = 64 << 10;

/// Bytes and lines beyond which no table is looked for: every line looked at is held in memory. Lines that are skipped as asked do
/// not count.
const SAMPLE_BYTES_MAX: usize = 16 << 20;
const SAMPLE_LINES_MAX: usize = 100_000;

/// Tried in this order, which decides between equals. A decimal comma between commas is never tried: `1,5` would be two numbers.
const CANDIDATES: [(u8, Decimal); 9] = [
    (b',', Decimal::Point),
    (b'\t', Decimal::Point),
    (b';', Decimal::Point),
    (b'|', Decimal::Point),
    (b' ', Decimal::Point),
    (b'\t', Decimal::Comma),
    (b';', Decimal::Comma),
    (b'|', Decimal::Comma),
    (b' ', Decimal::Comma),
];

pub(super) fn sniff(file: &str, text: &Text, options: &CsvOptions) -> Result<Found, IngestError> {
    let bytes: &[u8] = &text.bytes;
    let skipped = options.skip_lines.map_or(0, |skip| after_lines(bytes, 0, skip));
    let end = after_lines(bytes, skipped, SAMPLE_LINES_MAX).min(skipped.saturating_add(SAMPLE_BYTES_MAX));
    let mut size = SAMPLE_BYTES;
    loop {
        size = size.min(end);
        if let Some(best) = best_candidate(file, bytes, size, options)? {
            return Found::new(file, text, options, best);
        }
        if size == end {
            let first = bytes.split(|b| matches!(b, b'\n' | b'\r')).map(trim).find(|line| !line.is_empty());
            let found = match first {
                None => "nothing but blank lines".to_owned(),
                Some(line) if line.contains(&0) => "zero bytes, as in a file that is not text".to_owned(),
                Some(line) => {
                    let looked_at = if end < bytes.len() {
                        let lines = line_ends(&bytes[skipped..end]);
                        format!(" in the first {lines} lines")
                    } else {
                        String::new()
                    };
                    format!("no line of numbers{looked_at}; the first line is {}", shown(&to_text(line)))
                }
            };
            let next = "is this the file you meant? Delimiter, decimal sign and skipped lines can be said";
            return Err(unusable(file, None, "a table of numbers", found, next));
        }
        size = size.saturating_mul(16);
    }
}

/// Where the line begins that stands `lines` lines behind `from`; the end of the text if there are not as many.
fn after_lines(bytes: &[u8], from: usize, lines: usize) -> usize {
    let mut at = from;
    for _ in 0..lines {
        if at >= bytes.len() {
            break;
        }
        at = after_line_end(bytes, line_end(bytes, at));
    }
    at
}

struct Candidate {
    delimiter: u8,
    decimal: Decimal,
    lines: Vec<Line>,
    /// Cells of the lines that hold the most numbers.
    usual: usize,
    /// Index of the first line of data.
    start: usize,
    is_text: Vec<bool>,
    score: f64,
}

fn best_candidate(
    file: &str,
    bytes: &[u8],
    size: usize,
    options: &CsvOptions,
) -> Result<Option<Candidate>, IngestError> {
    let mut pairs: Vec<(u8, Decimal)> = CANDIDATES
        .into_iter()
        .filter(|(_, decimal)| options.decimal.is_none_or(|asked| asked == *decimal))
        .filter(|(delimiter, _)| options.delimiter.is_none_or(|asked| asked == *delimiter))
        .collect();
    if let (true, Some(delimiter)) = (pairs.is_empty(), options.delimiter) {
        pairs.push((delimiter, options.decimal.unwrap_or(Decimal::Point)));
    }
    let mut best: Option<Candidate> = None;
    for (delimiter, decimal) in pairs {
        let candidate = candidate(file, bytes, size, options, delimiter, decimal)?;
        if let Some(candidate) = candidate
            && best.as_ref().is_none_or(|best| candidate.score > best.score)
        {
            best = Some(candidate);
        }
    }
    Ok(best)
}

fn candidate(
    file: &str,
    bytes: &[u8],
    size: usize,
    options: &CsvOptions,
    delimiter: u8,
    decimal: Decimal,
) -> Result<Option<Candidate>, IngestError> {
    // Text costs a quarter of a number; text that holds another delimiter costs a whole one.
    let score = |facts: Facts| facts.numbers as f64 - 0.25 * facts.texts as f64 - 0.75 * facts.odd as f64;
    let rule = CommentRule { asked: options.comments, delimiter };
    let mut cells = Vec::new();
    let (mut lines, mut at, mut line) = (Vec::new(), 0, 1);
    let mut scores: Vec<f64> = Vec::new();
    while at < bytes.len() {
        let record = split(bytes, at, delimiter, &mut cells);
        check_line(file, record, line)?;
        if record.next > size && !lines.is_empty() && record.next < bytes.len() {
            break;
        }
        let comment = rule.mark(&bytes[record.start..record.end]);
        let filled = filled(&cells);
        let mut facts = facts(bytes, &cells[..filled], decimal, &[]);
        if comment.is_some() || options.skip_lines.is_some_and(|skip| line <= skip) {
            facts = Facts::default();
        }
        if score(facts) > 0.0 && filled <= LOG_COLUMNS_MAX {
            if scores.len() <= filled {
                scores.resize(filled + 1, 0.0);
            }
            // Runs of blanks and tabs part what tabs alone may part.
            let tabbed = delimiter == b' ' && bytes[record.start..record.end].contains(&b'\t');
            scores[filled] += if tabbed { 0.75 * score(facts) } else { score(facts) };
        }
        lines.push(Line {
            record,
            line,
            cells: filled,
            cells_with_empty: cells.len(),
            facts,
            blank: filled == 0,
            comment,
        });
        line += record.lines;
        at = record.next;
    }
    let Some((usual, mut total)) =
        scores.into_iter().enumerate().filter(|(_, s)| *s > 0.0).max_by(|(_, a), (_, b)| a.total_cmp(b))
    else {
        return Ok(None);
    };
    // A last column that is mostly empty: lines have their delimiter for it, and some have its cell.
    let delimited = lines.iter().filter(|l| l.cells == usual && l.facts.numbers > 0).map(|l| l.cells_with_empty).min();
    let delimited = delimited.unwrap_or(usual);
    let wider = lines.iter().filter(|l| l.facts.numbers > 0 && (usual + 1..=delimited).contains(&l.cells));
    let usual = wider.map(|l| l.cells).max().unwrap_or(usual);
    let is_text = text_columns(bytes, &lines, usual, delimiter, decimal);
    let Some(start) = first_data(bytes, &lines, usual, &is_text, delimiter, decimal, options) else { return Ok(None) };
    // A header that does not have as many cells as the data speaks against a delimiter. A line of one cell may be a title, but
    // between commas it is rather the name of one column with a decimal comma; and one column under a header that has commas is
    // not one column.
    let before = lines[..start].iter().rev().find(|l| !l.blank && l.comment.is_none());
    let misfits = |l: &Line| l.cells != usual && (l.cells > 1 || delimiter == b',');
    let parted = |l: &Line| usual == 1 && bytes[l.record.start..l.record.end].contains(&b',');
    if before.is_some_and(|l| l.facts.numbers == 0 && (misfits(l) || parted(l))) {
        total *= 0.4;
    }
    Ok(Some(Candidate { delimiter, decimal, lines, usual, start, is_text, score: total }))
}

pub(super) fn check_line(file: &str, record: Record, line: usize) -> Result<(), IngestError> {
    let length = record.end - record.start;
    if length <= LINE_BYTES_MAX {
        return Ok(());
    }
    let expected = format!("lines of at most {LINE_BYTES_MAX} bytes");
    let next = "is this a text log? Its line ends may be missing";
    Err(unusable(file, Some(line), &expected, format!("{length} bytes"), next))
}

/// A column is text if more of its cells are text than numbers.
fn text_columns(bytes: &[u8], lines: &[Line], usual: usize, delimiter: u8, decimal: Decimal) -> Vec<bool> {
    let mut balance = vec![0_i64; usual];
    let mut cells = Vec::new();
    for line in lines.iter().filter(|l| l.cells_with_empty >= usual && l.facts.numbers > 0) {
        split(bytes, line.record.start, delimiter, &mut cells);
        for (balance, cell) in balance.iter_mut().zip(&cells) {
            match kind(cell.of(bytes), decimal) {
                Kind::Number(_) => *balance -= 1,
                Kind::Text => *balance += 1,
                Kind::Empty | Kind::Hole => {}
            }
        }
    }
    balance.into_iter().map(|b| b > 0).collect()
}

/// The first line of data: the first line that looks like one, unless it stands alone and a row of names follows.
fn first_data(
    bytes: &[u8],
    lines: &[Line],
    usual: usize,
    is_text: &[bool],
    delimiter: u8,
    decimal: Decimal,
    options: &CsvOptions,
) -> Option<usize> {
    let mut cells = Vec::new();
    let mut is_data = |line: &Line| {
        if line.blank || line.comment.is_some() || line.cells > usual + 1 || line.facts.numbers == 0 {
            return false;
        }
        if options.skip_lines.is_some_and(|skip| line.line <= skip) {
            return false;
        }
        split(bytes, line.record.start, delimiter, &mut cells);
        let facts = facts(bytes, &cells, decimal, is_text);
        // A line with too few cells may be the end of one that began before the log: what is missing stood in front.
        line.cells_with_empty >= usual && facts.numbers > 0 && (facts.numbers > facts.texts || facts.first_is_number)
    };
    let kinds: Vec<bool> = lines.iter().map(&mut is_data).collect();
    let start = kinds.iter().position(|data| *data)?;
    // A lone line of numbers before the names of the table is metadata: a rate, a count of channels.
    let is_names = |l: &Line| l.comment.is_none() && l.facts.numbers == 0 && l.facts.texts > 1 && l.cells == usual;
    let above = lines[..start].iter().rev().find(|l| !l.blank && l.comment.is_none());
    if !above.is_some_and(is_names)
        && let Some(next) = kinds[start + 1..].iter().position(|data| *data).map(|n| start + 1 + n)
        && lines[start + 1..next].iter().any(is_names)
    {
        return Some(next);
    }
    Some(start)
}

/// Whether a line that does not look like data is a sample all the same: every number in it is there, missing or said to be wrong.
fn is_failed_sample(
    bytes: &[u8],
    line: &Line,
    usual: usize,
    is_text: &[bool],
    delimiter: u8,
    decimal: Decimal,
) -> bool {
    let mut cells = Vec::new();
    split(bytes, line.record.start, delimiter, &mut cells);
    let wrong = |cell: &[u8]| WRONG_VALUE.iter().any(|word| cell.eq_ignore_ascii_case(word.as_bytes()));
    let fits = |(column, cell): (usize, &Cell)| {
        let cell = cell.of(bytes);
        is_text.get(column) == Some(&true) || kind(cell, decimal) != Kind::Text || wrong(cell)
    };
    line.cells == usual && cells.iter().enumerate().all(fits) && is_text.iter().any(|is_text| !is_text)
}

impl Found {
    fn new(file: &str, text: &Text, options: &CsvOptions, candidate: Candidate) -> Result<Self, IngestError> {
        let bytes: &[u8] = &text.bytes;
        let Candidate { delimiter, decimal, lines, usual, start, is_text, .. } = candidate;
        let mut cells = Vec::new();
        let mut words = |line: &Line| -> Vec<String> {
            split(bytes, line.record.start, delimiter, &mut cells);
            cells[..filled(&cells)].iter().map(|c| c.text(bytes)).collect()
        };
        let raw = |line: &Line| trim(&bytes[line.record.start..line.record.end]).to_vec();

        let skipped = |l: &Line| options.skip_lines.is_some_and(|skip| l.line <= skip);
        let mut before: Vec<usize> = (0..start)
            .rev()
            .filter(|i| !lines[*i].blank && lines[*i].comment.is_none() && !skipped(&lines[*i]))
            .collect();
        let mut start = start;
        let failed =
            before.iter().take_while(|i| is_failed_sample(bytes, &lines[**i], usual, &is_text, delimiter, decimal));
        let failed = failed.count();
        // Words such as `error` may also be names: then there are none above them.
        let named = before.get(failed).is_some_and(|i| lines[*i].cells == usual && lines[*i].facts.numbers == 0);
        let failed = before[..failed]
            .iter()
            .take_while(|i| named || lines[**i].facts.texts == 0 || lines[**i].facts.numbers > 0);
        let failed = failed.count();
        if let Some(first) = before.drain(..failed).next_back() {
            start = first;
        }
        let (mut names, mut units) = (None, None);
        match options.header {
            Header::None => {}
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
        if text.encoding != Encoding::Utf8 {
            reasons.push(format!("the text is {}", text.encoding.name()));
        }

        let mut found = Self {
            layout: Layout {
                encoding: text.encoding,
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
            data_at: lines[start].record.start,
            text: is_text,
            header: Vec::new(),
            misfit: None,
            cut: Vec::new(),
        };
        if let Some(row) = names {
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

    /// `# time, pressure`: the last comment before the data, if it holds exactly one word per column.
    fn names_from_comment(&mut self, bytes: &[u8], before: &[Line]) {
        let Some(line) = before.last() else { return };
        let Some(comment) = line.comment else { return };
        let text = trim(&bytes[line.record.start..line.record.end]);
        let Some(text) = text.strip_prefix(comment.prefix().as_bytes()) else { return };
        let mut cells = Vec::new();
        split(text, 0, self.layout.delimiter, &mut cells);
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

/// Words that are at least two blanks, or a tab, apart.
fn parted_by_two_blanks(line: &[u8]) -> Vec<String> {
    let text = to_text(line).replace('\t', "  ");
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
