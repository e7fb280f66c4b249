//! What a microcontroller wrote to a serial port and a terminal kept: an STM32's or Arduino's log.
//!
//! Lines of keys and values (`t=123 p=101.3 flex=2.31kPa`) are read here, in any order of keys, and so are the stamps of a terminal
//! before delimited lines (`12:33:01.123 -> 1,2,3`). Delimited lines themselves are left to [`csv`](super::csv), which takes boot
//! messages, noise, a header without its line end, repeated headers and trailers among them as they come.
//!
//! | file | holds |
//! |---|---|
//! | `prefix.rs` | what the terminal wrote before a line |
//! | `pairs.rs` | a line of keys and values |
//! | `keyed.rs` | a log of such lines |
//! | `stamped.rs` | delimited lines behind stamps |
//! | `write.rs` | the writer |

mod keyed;
mod pairs;
mod prefix;
mod stamped;
mod write;

use super::lines::head_lines;
use super::sheet::Sheet;
use super::stamps::{utc_second, wrap_finding};
use super::{TextHead, text_head};
use crate::IngestError;
use crate::finding::{Finding, FindingKind};
use crate::raw::RawFile;
use crate::recording::{Keep, Recording};

pub use write::{WriteOptions, write};

/// Whether a text is a serial log that plain delimited text is not, by its first bytes: keys that come again and again, or stamps of
/// a terminal.
pub fn looks_like(head: &[u8], is_whole: bool) -> bool {
    let lines = head_lines(head, is_whole);
    keyed::looks_like(&lines) || stamped::is_stamped(&lines)
}

/// Reads a serial log as a recording of one table. Where a terminal stamped the lines, the column `terminal_time` holds its stamps
/// in s.
///
/// # Errors
/// [`IngestError::Unusable`] if no line is a sample, and for sizes beyond [`crate::limits`]; [`IngestError::Read`].
pub fn read(raw: &RawFile, keep: Keep) -> Result<Recording, IngestError> {
    let TextHead { bytes, is_whole } = text_head(raw)?;
    let lines = head_lines(&bytes, is_whole);
    if keyed::looks_like(&lines) {
        return keyed::read(raw, keep);
    }
    if stamped::is_stamped(&lines) {
        return stamped::read(raw, keep);
    }
    // Asked for, but the first lines show neither: keys may begin later, and what else there is, is delimited text.
    match keyed::read(raw, keep) {
        Err(IngestError::Unusable { .. }) => super::csv::read_raw(raw, &super::csv::CsvOptions::default(), keep),
        other => other,
    }
}

/// Lines on which keys are looked for at the beginning.
const LOOKED_AT: usize = 400;

/// The column of a terminal's stamps.
struct Terminal {
    column: usize,
    before: Option<f64>,
    days: f64,
    wraps: Vec<usize>,
    /// Whole seconds since 1970 from which stamps count.
    origin_s: Option<f64>,
}

impl Terminal {
    const NAME: &'static str = "terminal_time";

    fn add(sheet: &mut Sheet) -> Result<Self, IngestError> {
        let column = sheet.numbers(Self::NAME, Some("s"), true)?;
        Ok(Self { column, before: None, days: 0.0, wraps: Vec::new(), origin_s: None })
    }

    /// The stamp of the row that is being filled.
    fn put(&mut self, sheet: &mut Sheet, stamp: Option<(f64, bool)>, line: usize) {
        match stamp {
            Some((seconds, true)) => {
                let origin = *self.origin_s.get_or_insert(seconds.floor());
                sheet.date(self.column);
                sheet.put(self.column, seconds - origin);
            }
            // Times of day among dates: from where they count is open.
            Some((_, false)) if self.origin_s.is_some() => {
                sheet.hole(self.column, FindingKind::NonNumericCell, line, &[]);
            }
            Some((seconds, false)) => {
                // Half a day back is no clock that was set: it is midnight.
                if self.before.is_some_and(|before| before - seconds > 43_200.0) {
                    self.days += 86_400.0;
                    self.wraps.push(sheet.rows());
                }
                self.before = Some(seconds);
                sheet.put(self.column, seconds + self.days);
            }
            None => {}
        }
    }

    fn origin(&self) -> Option<String> {
        self.origin_s.map(|seconds| utc_second(seconds, false))
    }

    fn findings(&self, file: &str, sheet: &Sheet) -> Option<Finding> {
        wrap_finding(file, Self::NAME, &self.wraps, sheet.lines())
    }
}
