//! Finding out how a log is laid out, from its first lines.
//!
//! Every delimiter and decimal sign is tried on the first lines; the pair under which they hold the most numbers wins. Then the
//! table begins at its first line of data, and what stands directly before it may be its header.
//!
//! | file | holds |
//! |---|---|
//! | `candidate.rs` | a delimiter and a decimal sign, tried on the first lines |
//! | `header.rs` | what stands above the data: names, units, failed samples, a header glued to the first sample |

mod candidate;
mod header;

use super::numbers::Decimal;
use super::source::{CHUNK, Encoding, Source, Window};
use super::text::{LOOKAHEAD, Record, as_text, line_ends, trim};
use super::{CsvOptions, unusable};
use crate::IngestError;
use crate::error::shown;
use crate::limits::LINE_BYTES_MAX;
use crate::raw::RawFile;

pub(super) use header::Glued;

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
    /// Where in the text the data begin.
    pub data_at: u64,
    /// Whether a column holds text rather than numbers.
    pub text: Vec<bool>,
    /// Names and units as they stand in the file, to know them again among the data.
    pub header: Vec<Vec<u8>>,
    /// A header that does not fit: its line, its cells.
    pub misfit: Option<(usize, usize)>,
    /// Lines directly before the data that hold numbers, but not as many as the others.
    pub cut: Vec<usize>,
    /// A header that runs into the first sample.
    pub glued: Option<Glued>,
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

/// The first lines of a log, those that are skipped as asked left out but for the last.
struct Sample<'a> {
    window: Window<'a>,
    encoding: Encoding,
    /// Where they begin in the text.
    offset: u64,
    /// The number of the first of them.
    first_line: usize,
}

/// Bytes that are looked at first; sixteen times as many if they hold no table.
const SAMPLE_BYTES: usize = 64 << 10;

/// Bytes and lines beyond which no table is looked for: every line looked at is held in memory. Lines that are skipped as asked do
/// not count.
const SAMPLE_BYTES_MAX: usize = 16 << 20;
const SAMPLE_LINES_MAX: usize = 100_000;

pub(super) fn sniff(raw: &RawFile, options: &CsvOptions) -> Result<Found, IngestError> {
    let file = raw.name();
    let mut source = Source::open(raw, CHUNK)?;
    // The last of the skipped lines is looked at: it may be a comment that holds the names.
    let skipped = options.skip_lines.unwrap_or(0);
    let first_line = 1 + skip_lines(file, &mut source, skipped.saturating_sub(1))?;
    let mut size = SAMPLE_BYTES;
    loop {
        // Every record that begins in the sample is decided.
        source.hold(size + LOOKAHEAD)?;
        let window = source.window();
        let begin = after_lines(window, 0, usize::from(skipped > 0));
        let end = after_lines(window, begin, SAMPLE_LINES_MAX).min(begin + SAMPLE_BYTES_MAX);
        size = size.min(end);
        let sample = Sample { window, encoding: source.encoding(), offset: source.offset(), first_line };
        if let Some(best) = candidate::best(file, &sample, size, options)? {
            return Found::new(file, &sample, options, best);
        }
        if size == end {
            return Err(no_table(file, window, skipped, begin, end));
        }
        size = size.saturating_mul(16);
    }
}

/// Goes past lines; how many there were.
fn skip_lines(file: &str, source: &mut Source, lines: usize) -> Result<usize, IngestError> {
    let mut skipped = 0;
    while skipped < lines {
        let window = source.window();
        if let Some((end, next)) = window.line(0).filter(|(end, _)| *end < window.bytes.len() || window.ended) {
            check_line(file, Record { start: 0, end, next, lines: 1 }, 1 + skipped)?;
            if next == 0 {
                break;
            }
            source.consume(next);
            skipped += 1;
        } else {
            source.fill()?;
        }
    }
    Ok(skipped)
}

fn no_table(file: &str, window: Window, skipped: usize, begin: usize, end: usize) -> IngestError {
    let first = window.bytes[begin..].split(|b| matches!(b, b'\n' | b'\r')).map(trim).find(|line| !line.is_empty());
    let looked_at = if end < window.bytes.len() || !window.ended {
        format!(" in the first {} lines", line_ends(&window.bytes[begin..end]))
    } else {
        String::new()
    };
    let found = match first {
        None if skipped > 0 => format!("nothing but blank lines{looked_at} behind the {skipped} that are skipped"),
        None => format!("nothing but blank lines{looked_at}"),
        Some(line) if line.contains(&0) => "zero bytes, as in a file that is not text".to_owned(),
        Some(line) => format!("no line of numbers{looked_at}; the first line is {}", shown(&as_text(line))),
    };
    let next = "is this the file you meant? Delimiter, decimal sign and skipped lines can be said";
    unusable(file, None, "a table of numbers", found, next)
}

/// Where the line begins that stands `lines` lines behind `from`; the end of the window if there are not as many.
fn after_lines(window: Window, from: usize, lines: usize) -> usize {
    let mut at = from;
    for _ in 0..lines {
        match window.line(at) {
            Some((_, next)) if next > at => at = next,
            Some(_) => break,
            None => return window.bytes.len(),
        }
    }
    at
}

pub(super) fn check_line(file: &str, record: Record, line: usize) -> Result<(), IngestError> {
    if record.end - record.start <= LINE_BYTES_MAX {
        return Ok(());
    }
    let expected = format!("lines of at most {LINE_BYTES_MAX} bytes");
    let next = "is this a text log? Its line ends may be missing";
    Err(unusable(file, Some(line), &expected, "a longer one".to_owned(), next))
}
