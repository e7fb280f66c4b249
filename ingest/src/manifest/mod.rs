//! The files a user writes. Unknown keys are errors with the nearest known key.

mod actuator;
mod comparison;
mod dataset;
mod imported;
mod rig;
mod session;

pub use actuator::{Actuator, Chamber, Material};
pub use comparison::{
    Align, Comparable, ComparisonSpec, FitSpec, HoldOut, Quantity, RawComparison, RawQuantity, comparisons,
};
pub use dataset::{
    Cell, Condition, FileDigest, Listing, Paper, PredictedColumn, PublishedDataset, PublishedTable, Stated, Statistic,
};
pub use imported::{ImportedModel, Over};
pub use rig::{Instrument, Rig};
pub use session::*;

use toml::Spanned;

use crate::document::Document;
use crate::error::{IngestError, shown};

/// The version of the file formats this program reads.
const SCHEMA: i64 = 1;

/// The version of a file that a user wrote.
///
/// # Errors
/// [`IngestError::Malformed`] for another than this program's.
pub fn check_schema(document: &Document, schema: &Spanned<i64>) -> Result<(), IngestError> {
    if *schema.get_ref() == SCHEMA {
        return Ok(());
    }
    Err(document.malformed(
        schema.span(),
        format!("schema = {SCHEMA}"),
        schema.get_ref().to_string(),
        "use a program version that knows this schema",
    ))
}

/// Reads a file of the manifest's folder by its name: its full name for messages, and its bytes.
pub type ReadBeside<'a> = &'a dyn Fn(&str) -> Result<(String, Vec<u8>), IngestError>;

/// The files a manifest names stay inside its folder.
fn check_inside(document: &Document, name: &Spanned<String>) -> Result<(), IngestError> {
    let text = name.get_ref();
    let inside = std::path::Path::new(text).components().all(|part| matches!(part, std::path::Component::Normal(_)));
    if inside && !text.is_empty() && !text.contains('\\') {
        return Ok(());
    }
    Err(document.malformed(name.span(), "a file inside this folder", shown(text), "move the file here"))
}

/// A file that a manifest names. One that cannot be read is told where it is named.
fn read_named(
    document: &Document,
    name: &Spanned<String>,
    beside: ReadBeside,
) -> Result<(String, Vec<u8>), IngestError> {
    check_inside(document, name)?;
    beside(name.get_ref()).map_err(|error| match error {
        IngestError::Read { .. } => {
            let next = "correct the name, or put the file there";
            document.malformed(name.span(), "a file that can be read", error.to_string(), next)
        }
        other => other,
    })
}

/// Whether a text is an id: lower-case letters, digits, `-` and `.`, at most 80, starting with a letter or digit. Ids become
/// file names; `index` is the report's first page, and `measured` the measured column.
pub fn is_id(text: &str) -> bool {
    let allowed = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '-' || c == '.';
    text != "index"
        && text != "measured"
        && !text.is_empty()
        && text.len() <= 80
        && text.chars().all(allowed)
        && text.starts_with(|c: char| c.is_ascii_alphanumeric())
}

/// An id that a user wrote.
///
/// # Errors
/// [`IngestError::Malformed`] for what [`is_id`] refuses.
pub fn check_id(document: &Document, id: &Spanned<String>) -> Result<String, IngestError> {
    let text = id.get_ref();
    if is_id(text) {
        return Ok(text.clone());
    }
    Err(document.malformed(
        id.span(),
        "an id of lower-case letters, digits, `-` and `.`, at most 80, starting with a letter or digit; not `index`, not `measured`",
        shown(text),
        "rename it",
    ))
}
