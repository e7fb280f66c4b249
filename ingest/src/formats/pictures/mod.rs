//! Photographs as a log: a folder of pictures, or one, each a sample of what is measured in it.
//!
//! One row per picture, in the order of their names, with numbers first. Its columns are the numbers that the names hold (by a pattern), a
//! time where `fps` gives one, and what the task measures: each value with a column of its standard uncertainty. A picture that cannot be
//! decoded or measured is a row of holes, and a finding with the reason; the others go on. Pictures are measured in parallel, and the result does not depend
//! on it.
//!
//! A topic of pictures in a bag is a log of the same kind: each picture has the stamp of its message.
//!
//! | file | holds |
//! |---|---|
//! | `names.rs` | numbers in file names |
//! | `measured.rs` | what became of pictures, as columns and findings |
//! | `bag.rs` | the pictures of a topic |

mod bag;
mod measured;
pub mod names;

use std::cell::RefCell;
use std::cmp::Ordering;
use std::io::Read;

use rayon::prelude::*;

use crate::IngestError;
use crate::camera::decode::{decode, is_picture};
use crate::camera::photograph::is_shown;
use crate::camera::picture::Picture;
use crate::camera::task::Task;
use crate::error::Place;
use crate::finding::{FindingKind, Severity};
use crate::limits::PICTURE_BYTES_MAX;
use crate::raw::RawFile;
use crate::recording::{Keep, Recording};
use measured::{Row, Sheet, told_of};
use names::Pattern;

pub use bag::with_topic;

/// What is known of a folder of pictures.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct PictureOptions {
    /// What is measured; `None`: only what is there is told.
    pub task: Option<Task>,
    /// How they are named.
    pub names: Option<Pattern>,
    /// Pictures in a second, and the time of the first in s: gives each its time.
    pub film: Option<(f64, f64)>,
    /// The topic of the pictures, in a bag.
    pub topic: Option<String>,
}

/// The name of the column of times that a rate gives.
pub const TIME: &str = "time";

/// Whether a file, or the first one of a folder that is no bag, is a picture.
///
/// # Errors
/// [`IngestError::Read`].
pub fn looks_like(raw: &RawFile) -> Result<bool, IngestError> {
    let head = |part: &RawFile| part.head(16).map(|head| is_picture(&head));
    match raw.parts() {
        None => head(raw),
        Some(parts) => Ok(parts.iter().any(|part| has_name_of_picture(part.file_name()))),
    }
}

/// Whether a file is named as a picture.
pub fn has_name_of_picture(name: &str) -> bool {
    let extension = std::path::Path::new(name).extension().and_then(|e| e.to_str()).unwrap_or_default();
    ["png", "jpg", "jpeg", "tif", "tiff"].iter().any(|known| extension.eq_ignore_ascii_case(known))
}

/// The pictures of a file or folder, in order.
pub fn pictures<'r, 'a>(raw: &'r RawFile<'a>) -> Vec<&'r RawFile<'a>> {
    let mut all: Vec<&RawFile> = match raw.parts() {
        None => vec![raw],
        Some(parts) => parts.iter().filter(|part| has_name_of_picture(part.file_name())).collect(),
    };
    all.sort_by(|a, b| by_number(a.file_name(), b.file_name()));
    all
}

/// Names in the order of the numbers in them: `p2` before `p10`.
fn by_number(a: &str, b: &str) -> Ordering {
    let (mut x, mut y) = (a.as_bytes(), b.as_bytes());
    while let (Some(p), Some(q)) = (x.first(), y.first()) {
        if p.is_ascii_digit() && q.is_ascii_digit() {
            let digits = |of: &[u8]| of.iter().take_while(|c| c.is_ascii_digit()).count();
            let (m, n) = (digits(x), digits(y));
            let without_zeros = |of: &[u8]| of.iter().take_while(|c| **c == b'0').count();
            let (u, v) = (&x[without_zeros(&x[..m])..m], &y[without_zeros(&y[..n])..n]);
            let order = u.len().cmp(&v.len()).then_with(|| u.cmp(v));
            if order != Ordering::Equal {
                return order;
            }
            (x, y) = (&x[m..], &y[n..]);
        } else if p == q {
            (x, y) = (&x[1..], &y[1..]);
        } else {
            return p.cmp(q);
        }
    }
    x.len().cmp(&y.len()).then_with(|| a.cmp(b))
}

/// The picture of a file.
///
/// # Errors
/// [`IngestError::Read`]; why it is none, in words.
pub fn open(raw: &RawFile) -> Result<Result<Picture, String>, IngestError> {
    if raw.len() > PICTURE_BYTES_MAX {
        return Ok(Err(format!("{} bytes are more than the {PICTURE_BYTES_MAX} that are read", raw.len())));
    }
    // Pictures of a folder are about as large: memory is asked of the system once a thread.
    BYTES.with_borrow_mut(|bytes| {
        bytes.clear();
        bytes.shrink_to(KEPT_BYTES);
        raw.reader()?.read_to_end(bytes).map_err(|source| raw.failed(source))?;
        Ok(decode(bytes).map_err(|broken| broken.to_string()))
    })
}

thread_local! {
    /// The bytes of the picture that is read.
    static BYTES: RefCell<Vec<u8>> = const { RefCell::new(Vec::new()) };
}

/// Of which so many are kept for the next.
const KEPT_BYTES: usize = 32 << 20;

/// Reads pictures as a recording of one table.
///
/// # Errors
/// [`IngestError::Unusable`] if there is none; [`IngestError::Read`].
pub fn read(raw: &RawFile, options: &PictureOptions, keep: Keep) -> Result<Recording, IngestError> {
    let pictures = pictures(raw);
    if pictures.is_empty() {
        return Err(IngestError::Unusable {
            place: Place::new(raw.name(), None, None),
            expected: "pictures: .png, .jpg, .tif".to_owned(),
            found: "none in the folder".to_owned(),
            next: "name the folder that holds them".to_owned(),
        });
    }
    let of = pictures.len();
    let row = |(i, raw): (usize, &&RawFile)| -> Result<Row, IngestError> {
        let opened = open(raw)?;
        Ok(Row::new(raw.file_name(), opened, options.task.as_ref(), is_shown(i, of).then_some(i)))
    };
    let rows: Vec<Row> = pictures.par_iter().enumerate().map(row).collect::<Result<_, IngestError>>()?;
    let mut sheet = Sheet::new("", rows.len(), keep);
    let mut findings = measured::broken(raw.name(), &rows);
    if let Some(pattern) = &options.names {
        let read: Vec<Option<Vec<f64>>> = pictures.iter().map(|raw| pattern.read(raw.file_name())).collect();
        let such: Vec<String> = (0..read.len())
            .filter(|&i| read[i].is_none())
            .map(|i| format!("{} is not named as {}", pictures[i].file_name(), pattern.text()))
            .collect();
        findings.extend(told_of(raw.name(), FindingKind::UnreadName, Severity::Excluded, &such));
        for (k, field) in pattern.fields().enumerate() {
            let of = |i: usize| read[i].as_ref().and_then(|all| all.get(k)).copied().unwrap_or(f64::NAN);
            sheet.add(&field.name, field.unit.as_deref(), None, of);
        }
    }
    let clock = options.film.map(|(fps, start_s)| sheet.add_stamps(TIME, |i| start_s + i as f64 / fps));
    findings.extend(measured::add(&mut sheet, raw.name(), &rows, options.task.as_ref()));
    let reasons = vec![format!("{of} pictures, in the order of the numbers in their names")];
    let photographs = rows.into_iter().filter_map(|row| row.photograph).collect();
    let tables = vec![sheet.finish(None, clock)];
    Ok(Recording { format: "pictures", tables, findings, reasons, metadata: vec![], origin: None, photographs })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_go_by_their_numbers() {
        let mut names = ["p10.png", "p2.png", "p02b.png", "p2.5.png", "a1.png", "p1_10.png", "p1_9.png"];
        names.sort_by(|a, b| by_number(a, b));
        assert_eq!(names, ["a1.png", "p1_9.png", "p1_10.png", "p2.5.png", "p2.png", "p02b.png", "p10.png"]);
    }
}
