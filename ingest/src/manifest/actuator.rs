//! `actuator.toml`: an actuator's type, chambers, dimensions and material, each value with its unit and origin.

use std::collections::BTreeMap;

use serde::Deserialize;
use toml::Spanned;

use super::{check_id, check_schema};
use crate::digest;
use crate::document::{Document, RawValue, Value};
use crate::error::IngestError;
use crate::units::Dimension;

/// An actuator.
#[derive(Debug, Clone, PartialEq)]
pub struct Actuator {
    /// Its id, named by datasets and bounds.
    pub id: String,
    /// The type whose models describe it.
    pub kind: String,
    /// Its name on pages.
    pub title: String,
    /// What it is, in a sentence.
    pub summary: String,
    /// Its air chambers, by id.
    pub chambers: BTreeMap<String, Chamber>,
    /// Dimensions and material constants by name; a name stands for one value only.
    pub values: BTreeMap<String, Value>,
    /// The file as the user named it.
    pub file: String,
    /// SHA-256 of the file.
    pub sha256: String,
}

/// An air chamber.
#[derive(Debug, Clone, PartialEq)]
pub struct Chamber {
    /// The largest gauge pressure it is used at.
    pub pressure_gauge_max: Value,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Raw {
    schema: Spanned<i64>,
    id: Spanned<String>,
    #[serde(rename = "type")]
    kind: Spanned<String>,
    title: String,
    summary: String,
    chamber: BTreeMap<Spanned<String>, RawChamber>,
    geometry: BTreeMap<Spanned<String>, RawValue>,
    material: RawMaterial,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawChamber {
    pressure_gauge_max: RawValue,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawMaterial {
    law: Spanned<String>,
    constants: BTreeMap<Spanned<String>, RawValue>,
}

impl Actuator {
    /// Reads an actuator file.
    ///
    /// # Errors
    /// [`IngestError::Malformed`] with line and key.
    pub fn read(file: &str, bytes: &[u8]) -> Result<Self, IngestError> {
        let document = Document::new(file, bytes)?;
        let raw: Raw = document.parse()?;
        check_schema(&document, &raw.schema)?;
        if raw.material.law.get_ref() != "yeoh" {
            let found = format!("`{}`", raw.material.law.get_ref());
            return Err(document.malformed(raw.material.law.span(), "law = \"yeoh\"", found, "use a known law"));
        }
        let mut chambers = BTreeMap::new();
        for (id, chamber) in raw.chamber {
            let pressure_gauge_max = chamber.pressure_gauge_max.checked_as(&document, Dimension::Pressure)?;
            chambers.insert(check_id(&document, &id)?, Chamber { pressure_gauge_max });
        }
        let mut values = BTreeMap::new();
        for (name, value) in raw.geometry.into_iter().chain(raw.material.constants) {
            if values.contains_key(name.get_ref()) {
                let found = format!("`{}` under [geometry] and [material.constants]", name.get_ref());
                return Err(document.malformed(name.span(), "every name once", found, "rename one"));
            }
            values.insert(name.into_inner(), value.checked(&document)?);
        }
        Ok(Self {
            id: check_id(&document, &raw.id)?,
            kind: check_id(&document, &raw.kind)?,
            title: raw.title,
            summary: raw.summary,
            chambers,
            values,
            file: file.to_owned(),
            sha256: digest::sha256(bytes),
        })
    }
}
