//! Errors of reading and writing: where, expected, found, next step.

use std::fmt;
use std::path::{Path, PathBuf};

use thiserror::Error;

/// Where in a file something stands.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Place {
    /// The file, as the user named it.
    pub file: String,
    /// Line, from 1; `None` where the whole file is meant.
    pub line: Option<usize>,
    /// What stands there: a key, a column or a cell.
    pub item: Option<String>,
}

impl Place {
    /// A place in a file.
    pub fn new(file: &str, line: Option<usize>, item: Option<String>) -> Self {
        Self { file: file.to_owned(), line, item }
    }
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.file)?;
        if let Some(line) = self.line {
            write!(f, ":{line}")?;
        }
        if let Some(item) = &self.item {
            write!(f, ": {item}")?;
        }
        Ok(())
    }
}

/// Errors of this crate.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum IngestError {
    /// A file could not be read.
    #[error("{}: cannot be read: {source}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// A file could not be written.
    #[error("{}: cannot be written: {source}", path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// A file is larger than anything of its kind should be.
    #[error("{}: {bytes} bytes, at most {limit} are read of such a file\n  next:     is this the file you meant?", path.display())]
    TooLarge {
        /// The file.
        path: PathBuf,
        /// Its size.
        bytes: u64,
        /// The limit.
        limit: u64,
    },
    /// What the user wrote is not what the file format asks for.
    #[error("{place}\n  expected: {expected}\n  found:    {found}\n  next:     {next}")]
    Malformed {
        /// Where.
        place: Place,
        /// What should stand there.
        expected: String,
        /// What stands there.
        found: String,
        /// What to do.
        next: String,
    },
    /// What an instrument wrote cannot be used, whatever the user writes.
    #[error("{place}\n  expected: {expected}\n  found:    {found}\n  next:     {next}")]
    Unusable {
        /// Where.
        place: Place,
        /// What should stand there.
        expected: String,
        /// What stands there.
        found: String,
        /// What to do.
        next: String,
    },
    /// A Parquet file could not be written or read.
    #[error("{}: Parquet: {message}", path.display())]
    Parquet {
        /// The file.
        path: PathBuf,
        /// What polars said.
        message: String,
    },
}

impl IngestError {
    /// A read error with its path.
    pub fn read(path: &Path, source: std::io::Error) -> Self {
        Self::Read { path: path.to_owned(), source }
    }

    /// A write error with its path.
    pub fn write(path: &Path, source: std::io::Error) -> Self {
        Self::Write { path: path.to_owned(), source }
    }
}

/// What a user wrote, fit to be shown: control characters as escapes, and not more than one can read.
///
/// ```
/// use pneuval_ingest::error::shown;
/// assert_eq!(shown("12,5"), "`12,5`");
/// assert_eq!(shown("a\u{1b}[2J"), "`a\\u{1b}[2J`");
/// ```
pub fn shown(text: &str) -> String {
    const CHARACTERS_MAX: usize = 80;
    let mut out = String::from("`");
    for (i, c) in text.chars().enumerate() {
        if i == CHARACTERS_MAX {
            out.push('…');
            break;
        }
        if c.is_control() || ('\u{202a}'..='\u{202e}').contains(&c) || ('\u{2066}'..='\u{2069}').contains(&c) {
            out.extend(c.escape_unicode());
        } else {
            out.push(c);
        }
    }
    out.push('`');
    out
}

/// The candidate nearest to a mistyped word, as a next step: "did you mean `x`?", or else the candidates.
pub fn suggestion<'a>(word: &str, candidates: impl IntoIterator<Item = &'a str>) -> String {
    let candidates: Vec<&str> = candidates.into_iter().collect();
    let nearest = candidates
        .iter()
        .map(|c| (strsim::damerau_levenshtein(&word.to_lowercase(), &c.to_lowercase()), *c))
        .min_by_key(|(distance, _)| *distance);
    // `stroke` where there is only `stroke [mm]`.
    let mut begin = candidates.iter().copied().filter(|c| !word.is_empty() && c.starts_with(word));
    let one_begins = begin.next().filter(|_| begin.next().is_none());
    match nearest {
        Some((distance, name)) if distance <= 1 + name.chars().count() / 3 => format!("did you mean `{name}`?"),
        _ if candidates.is_empty() => "remove it".to_owned(),
        _ if let Some(name) = one_begins => format!("did you mean `{name}`?"),
        _ => format!("use one of: {}", candidates.join(", ")),
    }
}
