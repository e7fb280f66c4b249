//! Measurement files of LabVIEW (`.lvm`): what the express VIs "Write To Measurement File" and their kin write.
//!
//! A header of keys, then segments: a header of their own, a line of names that begins with `X_Value`, and rows. [`read`] takes every
//! row in one pass, keeps holes as NaN where no number stands, and tells each such place. What headers state is compared with what the
//! rows hold, and where they differ the rows count: `X_Columns`, `Separator` and `Decimal_Separator` are asked of the bytes too,
//! `Samples` and `Delta_X` are often wrong (`Delta_X` is printed with six decimals) and are told where they are.
//!
//! Channels that share every stamp are one table. Stamps are the start of the segment, by its `Date` and `Time`, plus X, from the whole
//! second before the first start; so segments whose X begins at 0 again stand one behind the other. Where X is not in the file it is
//! `X0 + i Delta_X`. X beyond 10^9 counts from 1904, whatever `Time_Pref` states. X that has gone on by as much as the start since the
//! first segment counts from the first start: added to a later one, the time between would count twice. LabVIEW's zero, 1904-01-01
//! 00:00 UTC, stands where data have no start, and is none.
//!
//! What a file that was cut reveals: a cut within a line, within a header behind the first segment, or within a special block is told as
//! lost; so are fewer samples than `Samples` states. A cut at the end of a line leaves no trace where `Samples` is absent, or is that of
//! the first packet only (`Multi_Headings` is `No`), or where whole segments are gone; and a cut within the last number of a row gives a
//! shorter number, which is told as a line without an end.
//!
//! | file | holds |
//! |---|---|
//! | `header.rs` | keys, and how cells are parted |
//! | `layout.rs` | which cell of a row is what |
//! | `start.rs`, `clock.rs` | when segments began, and what X counts from |
//! | `block.rs` | tables while they grow |
//! | `rows.rs` | the pass over the file |
//! | `tell.rs` | what headers state and rows do not bear out |
//! | `write.rs` | the writer |

mod block;
mod clock;
mod header;
mod layout;
mod rows;
mod start;
mod tell;
#[cfg(test)]
mod tests;
mod write;

use crate::IngestError;
use crate::finding::places::{Places, told};
use crate::finding::{Finding, FindingKind, LineMap, Severity};
use crate::formats::csv::source::{CHUNK, Encoding};
use crate::formats::csv::tell_file;
use crate::limits::LOG_BYTES_MAX;
use crate::raw::RawFile;
use crate::recording::{Keep, Recording};

pub use write::{WriteOptions, XColumns, write};

/// The column of what was noted beside rows.
pub(crate) const COMMENT: &str = "Comment";

/// Whether a text is a measurement file: by its first words, or where these are missing by the end of a header and a line of names.
pub(super) fn looks_like(head: &[u8]) -> bool {
    let head = head.trim_ascii_start();
    if header::is_title(head) {
        return true;
    }
    let mut lines = head.split(|b| matches!(b, b'\n' | b'\r'));
    lines.any(|line| line.starts_with(header::END_OF_HEADER))
        && lines.any(|line| header::behind(line, header::X_VALUE).is_some())
}

/// Reads a measurement file: one table for each clock and set of channels, all without a name.
///
/// ```
/// use pneuval_ingest::{formats::lvm, raw::RawFile, recording::Keep};
/// let text = "LabVIEW Measurement\nSeparator\tTab\nDecimal_Separator\t,\nX_Columns\tOne\n***End_of_Header***\n\n\
///     Channels\t1\nSamples\t2\nDate\t2026/11/22\nTime\t09:13:00,5\nY_Unit_Label\tkPa\nX_Dimension\tTime\n\
///     ***End_of_Header***\nX_Value\tp\tComment\n0,00\t1,5\n0,25\tERR\tvalve stuck\n";
/// let recording = lvm::read(&RawFile::of_bytes("run.lvm", text.as_bytes()), Keep::All)?;
/// let table = &recording.tables[0];
/// assert_eq!(table.time().and_then(|x| x.cells.numbers()), Some(&[0.5, 0.75][..]));
/// assert_eq!(recording.origin.as_deref(), Some("2026-11-22T09:13:00"));
/// assert_eq!(table.column("p").and_then(|p| p.unit.as_deref()), Some("kPa"));
/// assert_eq!(recording.findings[0].text, "column `p`: 1 cell is not a number (line 16: `ERR`); left as holes");
/// # Ok::<(), pneuval_ingest::IngestError>(())
/// ```
///
/// # Errors
/// [`IngestError::Unusable`] if the file ends before the channels are named, for a separator that numbers may hold, and for sizes beyond
/// [`crate::limits`]; [`IngestError::TooLarge`] for too many bytes; [`IngestError::Read`] if it cannot be read.
pub fn read(raw: &RawFile, keep: Keep) -> Result<Recording, IngestError> {
    read_in_pieces(raw, keep, CHUNK)
}

/// Reads in pieces of `chunk` bytes, whose size changes nothing of what is read.
fn read_in_pieces(raw: &RawFile, keep: Keep, chunk: usize) -> Result<Recording, IngestError> {
    let file = raw.name();
    if raw.len() > LOG_BYTES_MAX {
        return Err(IngestError::TooLarge { path: file.into(), bytes: raw.len(), limit: LOG_BYTES_MAX });
    }
    let rows::Read { blocks, decimal, mut tally, odd, mut clock, metadata, mut reasons, bad, ending, usual } =
        rows::read(raw, keep, chunk)?;
    let mut tables = Vec::new();
    let mut of_cells = Vec::new();
    for block in blocks {
        block.finish(file, decimal, &mut tables, &mut of_cells);
    }
    let encoding = ending.encoding.with(&bad);
    if encoding != Encoding::Utf8 {
        reasons.insert(0, format!("the text is {}", encoding.name()));
    }
    let no_lines = LineMap::default();
    let lines = tables.last().map_or(&no_lines, |table| &table.lines);
    let bad = if bad.count > 0 { &bad } else { &ending.bad };
    tell_file(file, encoding, bad, &ending, lines, &mut tally);
    let mut findings = tally.findings(file, &[], usual);
    findings.extend(odd.finish(file));
    findings.extend(of_starts(file, &mut clock));
    findings.append(&mut of_cells);
    let is_one_clock = clock.is_one();
    let (origin, of_clock) = clock.finish();
    for table in tables.iter_mut().filter(|_| origin.is_some() && is_one_clock) {
        if let Some(x) = table.clock.and_then(|clock| table.columns.get_mut(clock)) {
            x.is_dated = true;
        }
    }
    reasons.extend(of_clock);
    Ok(Recording {
        format: "LabVIEW measurement file",
        tables,
        findings,
        reasons,
        metadata,
        origin,
        photographs: vec![],
    })
}

/// Findings about the starts of segments.
fn of_starts(file: &str, clock: &mut clock::Clock) -> Vec<Finding> {
    let mut findings = Vec::new();
    if clock.is_open() {
        let text = "day and month of the start may be either way round: the date is not used".to_owned();
        findings.push(told(FindingKind::AmbiguousDate, Severity::Note, file, 0, 0, text));
    }
    let take = |places: &mut Places| std::mem::take(places);
    let back = take(&mut clock.back);
    if back.count() > 0 {
        let segments = back.counted("segment begins", "segments begin");
        let text =
            format!("{segments} before one that stands before it {}; X is used as it stands there", back.listed());
        findings.push(back.finding(FindingKind::TimeReversed, Severity::Note, file, None, text));
    }
    let unread = take(&mut clock.unread);
    if unread.count() > 0 {
        let starts = unread.counted("start is no date and time", "starts are no date and time");
        let text = format!("{starts} {}; not used", unread.listed());
        findings.push(unread.finding(FindingKind::NonNumericCell, Severity::Note, file, None, text));
    }
    findings
}
