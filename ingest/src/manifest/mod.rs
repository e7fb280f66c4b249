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
use crate::error::IngestError;

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

/// Ids become file names and keys: lower-case letters, digits, `-` and `.`. `index` is the report's first page.
fn check_id(document: &Document, id: &Spanned<String>) -> Result<String, IngestError> {
    let text = id.get_ref();
    let allowed = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '-' || c == '.';
    if text != "index"
        && !text.is_empty()
        && text.len() <= 80
        && text.chars().all(allowed)
        && text.starts_with(|c: char| c.is_ascii_alphanumeric())
    {
        return Ok(text.clone());
    }
    Err(document.malformed(
        id.span(),
        "an id of lower-case letters, digits, `-` and `.`, at most 80, starting with a letter or digit, not `index`",
        format!("`{}`", text.escape_debug()),
        "rename it",
    ))
}
