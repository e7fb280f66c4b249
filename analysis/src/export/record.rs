//! What was written, as JSON: what `--json` prints, and by what an export is known as one.

use std::collections::BTreeSet;

use serde::Serialize;

use super::table::{Column, Origin};
use crate::results::SourceFile;

/// The file's name, which is no id: no folder of a session is called so.
pub(super) const NAME: &str = "pneuval_export.json";

/// Name and version of the program.
pub(super) const PROGRAM: &str = concat!("pneuval ", env!("CARGO_PKG_VERSION"));

/// The version of this layout.
const LAYOUT: u32 = 1;

/// The content of `pneuval_export.json`.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ExportRecord {
    /// Name and version of the program.
    pub program: &'static str,
    /// The version of this layout.
    pub layout: u32,
    /// `mcap`, `csv` or `parquet`.
    pub format: &'static str,
    /// One for each session or dataset, by id.
    pub data: Vec<DataRecord>,
}

/// What was written of a session or dataset.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct DataRecord {
    /// Its id.
    pub id: String,
    /// `session` or `published`.
    pub kind: &'static str,
    /// Its name on pages.
    pub title: String,
    /// The actuator it was taken on.
    pub actuator: String,
    /// Written by a program, not by an instrument.
    pub synthetic: bool,
    /// Whether more samples are excluded than the session allows.
    pub too_many_excluded: bool,
    /// Every file that went in.
    pub sources: Vec<SourceFile>,
    /// Every file that came out.
    pub files: Vec<FileRecord>,
    /// What is in none of them, and why.
    pub left_out: Vec<LeftOut>,
}

/// A file.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FileRecord {
    /// Its path in the export.
    pub file: String,
    /// Its length.
    pub bytes: u64,
    /// Its SHA-256.
    pub sha256: String,
    /// The run it is of.
    pub run: Option<String>,
    /// Topics of a bag; the one table of any other file.
    pub tables: Vec<TableRecord>,
}

/// A table.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct TableRecord {
    /// Its topic in a bag.
    pub topic: Option<String>,
    /// The table of the log that its clock is from, where the log has several.
    pub stream: Option<String>,
    /// Rows or messages.
    pub rows: usize,
    /// Its columns, or the fields of its messages.
    pub columns: Vec<ColumnRecord>,
}

/// A column.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ColumnRecord {
    /// Its name, which ends in its unit.
    pub name: String,
    /// Its unit; null for words.
    pub unit: Option<&'static str>,
    /// What it is called on pages.
    pub title: String,
    /// Where it comes from.
    pub origin: Origin,
    /// The form that predicts it.
    pub form: Option<String>,
    /// What else is to be known of it.
    pub note: Option<String>,
}

/// Something that is in no file.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct LeftOut {
    /// What.
    pub what: String,
    /// Why.
    pub why: String,
}

impl LeftOut {
    pub(super) fn new(what: String, why: String) -> Self {
        Self { what, why }
    }
}

impl ExportRecord {
    pub(super) fn new(format: &'static str, data: Vec<DataRecord>) -> Self {
        Self { program: PROGRAM, layout: LAYOUT, format, data }
    }

    /// As it stands in the export.
    ///
    /// # Errors
    /// None that is known: strings, numbers and lists of them always have a JSON.
    pub fn to_json(&self) -> serde_json::Result<String> {
        Ok(serde_json::to_string_pretty(self)? + "\n")
    }
}

impl ColumnRecord {
    pub(super) fn of(column: &Column) -> Self {
        Self {
            name: column.name.clone(),
            unit: column.unit.map(|unit| unit.symbol),
            title: column.title.clone(),
            origin: column.origin,
            form: column.form.clone(),
            note: column.note.clone(),
        }
    }

    /// On one line, for the metadata of a file.
    pub(super) fn to_json(&self) -> String {
        // Strings always have a JSON.
        serde_json::to_string(self).unwrap_or_default()
    }

    /// In words, for a comment.
    pub(super) fn to_words(&self) -> String {
        let by = self.form.as_ref().map_or(String::new(), |form| format!(" by {form}"));
        let origin = match self.origin {
            Origin::Residual => format!("{}{}", self.origin.words(), by.replacen(" by ", ", of ", 1)),
            _ => format!("{}{by}", self.origin.words()),
        };
        let unit = self.unit.map(str::to_owned);
        let words = unit.into_iter().chain([origin, self.title.clone()]).chain(self.note.clone());
        words.collect::<Vec<_>>().join("; ")
    }
}

/// The files that an earlier record names, itself included.
pub(super) fn files_of(record: &serde_json::Value) -> Option<BTreeSet<String>> {
    let mut files = BTreeSet::from([NAME.to_owned()]);
    for data in record.get("data")?.as_array()? {
        let named = data.get("files")?.as_array()?.iter();
        files.extend(named.filter_map(|file| Some(file.get("file")?.as_str()?.to_owned())));
    }
    Some(files)
}
