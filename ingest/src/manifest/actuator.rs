//! `actuator.toml`: an actuator's type, chambers, dimensions and materials, each value with its unit and origin; and models
//! that a user brings as a table.

use std::collections::BTreeMap;

use serde::Deserialize;
use toml::Spanned;

use super::imported::{ImportedModel, RawImported};
use super::{ReadBeside, check_id, check_schema};
use crate::digest;
use crate::document::{Document, RawValue, Value};
use crate::error::IngestError;
use crate::units::Dimension;

/// An actuator.
#[derive(Debug, Clone, PartialEq)]
pub struct Actuator {
    /// Its id, named by datasets, sessions and bounds.
    pub id: String,
    /// The type whose models describe it; its own id where the file names none.
    pub kind: String,
    /// Its name on pages.
    pub title: String,
    /// What it is, in a sentence.
    pub summary: String,
    /// Its air chambers, by id.
    pub chambers: BTreeMap<String, Chamber>,
    /// Dimensions and material constants by name; a name stands for one value only.
    pub values: BTreeMap<String, Value>,
    /// Its materials, by id.
    pub materials: BTreeMap<String, Material>,
    /// Models brought as tables.
    pub imported: Vec<ImportedModel>,
    /// The file names no id: a first draft, meant for the session beside it, and for nothing else.
    pub draft: bool,
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

/// A material: its law, and where its constants stand.
#[derive(Debug, Clone, PartialEq)]
pub struct Material {
    /// Id of the hyperelastic law; whoever knows laws checks it.
    pub law: String,
    /// The law's constants: the name in the law, and the key in [`Actuator::values`]. They are the same where the actuator has
    /// one material; of several, the key is `<material>_<constant>`.
    pub constants: BTreeMap<String, String>,
    /// Line of the file where the law is named.
    pub line: usize,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Raw {
    schema: Spanned<i64>,
    id: Option<Spanned<String>>,
    #[serde(rename = "type")]
    kind: Option<Spanned<String>>,
    title: Option<String>,
    #[serde(default)]
    summary: String,
    #[serde(default)]
    chamber: BTreeMap<Spanned<String>, RawChamber>,
    #[serde(default)]
    geometry: BTreeMap<Spanned<String>, RawValue>,
    #[serde(default)]
    material: BTreeMap<Spanned<String>, RawMaterial>,
    #[serde(default)]
    model: Vec<RawImported>,
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
    #[serde(default)]
    constants: BTreeMap<Spanned<String>, RawValue>,
}

impl Actuator {
    /// Reads an actuator file and the tables of its imported models.
    ///
    /// A file without `id` is a first draft that lies beside a session: it describes the actuator `asked`.
    ///
    /// # Errors
    /// [`IngestError::Malformed`] with line and key.
    pub fn read(file: &str, bytes: &[u8], asked: &str, beside: ReadBeside) -> Result<Self, IngestError> {
        let document = Document::new(file, bytes)?;
        let raw: Raw = document.parse()?;
        check_schema(&document, &raw.schema)?;
        let id = raw.id.as_ref().map_or(Ok(asked.to_owned()), |id| check_id(&document, id))?;
        let kind = raw.kind.as_ref().map_or(Ok(id.clone()), |kind| check_id(&document, kind))?;
        let mut chambers = BTreeMap::new();
        for (id, chamber) in raw.chamber {
            let pressure_gauge_max = chamber.pressure_gauge_max.checked_as(&document, Dimension::Pressure)?;
            chambers.insert(check_id(&document, &id)?, Chamber { pressure_gauge_max });
        }
        let mut values: BTreeMap<String, Value> = BTreeMap::new();
        let mut add = |name: &Spanned<String>, key: String, value: &RawValue| {
            if values.contains_key(&key) {
                let found = format!("`{key}` twice, under [geometry] and the constants of a material");
                return Err(document.malformed(name.span(), "every name once", found, "rename one"));
            }
            values.insert(key, value.checked(&document)?);
            Ok(())
        };
        for (name, value) in &raw.geometry {
            add(name, name.get_ref().clone(), value)?;
        }
        let mut materials = BTreeMap::new();
        let several = raw.material.len() > 1;
        for (id, material) in &raw.material {
            let mut constants = BTreeMap::new();
            for (name, value) in &material.constants {
                let constant = name.get_ref();
                let key = if several { format!("{}_{constant}", id.get_ref()) } else { constant.clone() };
                add(name, key.clone(), value)?;
                constants.insert(constant.clone(), key);
            }
            let line = document.line_of(material.law.span().start);
            let law = check_id(&document, &material.law)?;
            materials.insert(check_id(&document, id)?, Material { law, constants, line });
        }
        let mut imported: Vec<ImportedModel> = Vec::new();
        for model in &raw.model {
            let model = model.read(&document, beside, &imported)?;
            imported.push(model);
        }
        Ok(Self {
            title: raw.title.unwrap_or_else(|| id.clone()),
            id,
            kind,
            summary: raw.summary,
            chambers,
            values,
            materials,
            imported,
            draft: raw.id.is_none(),
            file: file.to_owned(),
            sha256: digest::sha256(bytes),
        })
    }
}
