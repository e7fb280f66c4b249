//! The files a user writes. Unknown keys are errors with the nearest known key.

mod actuator;
mod dataset;

pub use actuator::{Actuator, Chamber};
pub use dataset::{
    ComparisonSpec, FileDigest, FitSpec, Listing, Paper, PredictedColumn, PublishedDataset, PublishedTable, Quantity,
    Stated,
};

use toml::Spanned;

use crate::document::Document;
use crate::error::{IngestError, shown};

/// The version of the file formats this program reads.
const SCHEMA: i64 = 1;

fn check_schema(document: &Document, schema: &Spanned<i64>) -> Result<(), IngestError> {
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

fn check_id(document: &Document, id: &Spanned<String>) -> Result<String, IngestError> {
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
