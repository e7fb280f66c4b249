//! A delimiter and a decimal sign, tried on the first lines.

use super::super::cells::{Facts, Kind, facts, filled, kind};
use super::super::numbers::Decimal;
use super::super::source::Window;
use super::super::text::{Record, split};
use super::{Comment, CommentRule, CsvOptions, Sample, check_line};
use crate::IngestError;
use crate::limits::LOG_COLUMNS_MAX;

/// A line of the sample.
pub(super) struct Line {
    pub record: Record,
    pub line: usize,
    /// Cells up to the last that is not empty.
    pub cells: usize,
    /// All cells.
    pub cells_with_empty: usize,
    pub facts: Facts,
    pub blank: bool,
    pub comment: Option<Comment>,
}

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

/// What the first lines are under a delimiter and a decimal sign.
pub(super) struct Candidate {
    pub delimiter: u8,
    pub decimal: Decimal,
    pub lines: Vec<Line>,
    /// Cells of the lines that hold the most numbers.
    pub usual: usize,
    /// Index of the first line of data.
    pub start: usize,
    pub is_text: Vec<bool>,
    score: f64,
}

/// The delimiter and decimal sign under which the first `size` bytes hold the most numbers, if they hold a table at all.
pub(super) fn best(
    file: &str,
    sample: &Sample,
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
        let candidate = candidate(file, sample, size, options, delimiter, decimal)?;
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
    sample: &Sample,
    size: usize,
    options: &CsvOptions,
    delimiter: u8,
    decimal: Decimal,
) -> Result<Option<Candidate>, IngestError> {
    // Text costs a quarter of a number; text that holds another delimiter costs a whole one.
    let score = |facts: Facts| facts.numbers as f64 - 0.25 * facts.texts as f64 - 0.75 * facts.odd as f64;
    let rule = CommentRule { asked: options.comments, delimiter };
    let window = sample.window;
    let bytes = window.bytes;
    let mut cells = Vec::new();
    let (mut lines, mut at, mut line) = (Vec::new(), 0, sample.first_line);
    let mut scores: Vec<f64> = Vec::new();
    while at < bytes.len() {
        let Some(record) = split(window, at, delimiter, &mut cells) else { break };
        check_line(file, record, line)?;
        let is_last = window.ended && record.next == bytes.len();
        if record.next > size && !lines.is_empty() && !is_last {
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
    let is_text = text_columns(window, &lines, usual, delimiter, decimal);
    let Some(start) = first_data(window, &lines, usual, &is_text, delimiter, decimal, options) else { return Ok(None) };
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

/// A column is text if more of its cells are text than numbers.
fn text_columns(window: Window, lines: &[Line], usual: usize, delimiter: u8, decimal: Decimal) -> Vec<bool> {
    let mut balance = vec![0_i64; usual];
    let mut cells = Vec::new();
    for line in lines.iter().filter(|l| l.cells_with_empty >= usual && l.facts.numbers > 0) {
        split(window, line.record.start, delimiter, &mut cells);
        for (balance, cell) in balance.iter_mut().zip(&cells) {
            match kind(cell.of(window.bytes), decimal) {
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
    window: Window,
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
        split(window, line.record.start, delimiter, &mut cells);
        let facts = facts(window.bytes, &cells, decimal, is_text);
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
