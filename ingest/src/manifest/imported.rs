//! `[[model]]` of an actuator file: a prediction brought as a table, such as an export of a finite-element program.

use serde::Deserialize;
use toml::Spanned;

use super::comparison::{OneOrMany, Quantity, RawQuantity, check_width};
use super::{FileDigest, ReadBeside, check_id, read_named};
use crate::digest;
use crate::document::Document;
use crate::error::{IngestError, shown};
use crate::table::Table;
use crate::units::Dimension;

/// A prediction as a table of gauge pressure against a quantity, in SI units.
///
/// Between two rows it is the straight line; outside its pressures it predicts nothing.
#[derive(Debug, Clone, PartialEq)]
pub struct ImportedModel {
    /// Its id, as a form.
    pub form: String,
    /// Its name in legends and tables.
    pub title: String,
    /// What it predicts.
    pub quantity: Quantity,
    /// Where it comes from, in the user's words.
    pub source: String,
    /// The chamber whose pressure it is a function of.
    pub chamber: String,
    /// Rising gauge pressures, in Pa.
    pub pressures_gauge_pa: Vec<f64>,
    /// Per pressure, the value of each component.
    pub values_si: Vec<Vec<f64>>,
    /// Per pressure, the standard uncertainty of each component, if the table has any.
    pub std_si: Option<Vec<Vec<f64>>>,
    /// The table, with its digest.
    pub file: FileDigest,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawImported {
    #[serde(rename = "kind")]
    _kind: Kind,
    form: Spanned<String>,
    title: Option<String>,
    quantity: RawQuantity,
    source: Option<String>,
    file: Spanned<String>,
    pressure: RawPressure,
    predicted: Spanned<OneOrMany>,
    std: Option<Spanned<OneOrMany>>,
    /// Said, so that nobody need guess; there is one.
    #[serde(default, rename = "interpolation")]
    _interpolation: Interpolation,
}

#[derive(Deserialize)]
#[serde(rename_all = "kebab-case")]
enum Kind {
    Imported,
}

#[derive(Default, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum Interpolation {
    #[default]
    Linear,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawPressure {
    column: String,
    chamber: Spanned<String>,
    #[serde(rename = "reference")]
    _reference: Reference,
}

#[derive(Deserialize)]
#[serde(rename_all = "lowercase")]
enum Reference {
    Gauge,
}

impl RawImported {
    pub fn read(
        &self,
        document: &Document,
        beside: ReadBeside,
        before: &[ImportedModel],
    ) -> Result<ImportedModel, IngestError> {
        let form = check_id(document, &self.form)?;
        let quantity = self.quantity.checked(document)?;
        if before.iter().any(|m| m.form == form && m.quantity.id == quantity.id) {
            let found = format!("`{form}` of `{}` twice", quantity.id);
            return Err(document.malformed(self.form.span(), "every model once", found, "rename one"));
        }
        let (full, bytes) = read_named(document, &self.file, beside)?;
        let table = Table::read(&full, &bytes)?;
        let every = |name: &str, dimension| -> Result<Vec<f64>, IngestError> {
            let cells = table.every(name, dimension, "a number in every row of a model's table")?;
            Ok(cells.into_iter().map(|cell| cell.si).collect())
        };
        let pressures = every(&self.pressure.column, Dimension::Pressure)?;
        if pressures.len() < 2 {
            let found = format!("{} in {full}", pressures.len());
            let next = "export the model at more pressures: nothing is extrapolated";
            return Err(document.malformed(self.file.span(), "at least two pressures", found, next));
        }
        // From the top down is the same table; the two ends say which way it goes.
        let falls = pressures.first() > pressures.last();
        let goes_on = |i: usize| if falls { pressures[i] < pressures[i - 1] } else { pressures[i] > pressures[i - 1] };
        if let Some(row) = (1..pressures.len()).find(|&i| !goes_on(i)) {
            let expected = "pressures that rise from row to row, or fall from row to row";
            let next = "sort the rows, and keep one value per pressure: loading or unloading";
            return Err(table.malformed(row, &self.pressure.column, expected, next));
        }
        let columns = |names: &Spanned<OneOrMany>| -> Result<Vec<Vec<f64>>, IngestError> {
            check_width(document, names, &quantity)?;
            let names = names.get_ref().names();
            let columns = names.iter().map(|name| every(name, quantity.unit.dimension));
            let columns = columns.collect::<Result<Vec<_>, _>>()?;
            Ok((0..pressures.len()).map(|row| columns.iter().map(|c| c[row]).collect()).collect())
        };
        let values_si = columns(&self.predicted)?;
        let std_si = self.std.as_ref().map(&columns).transpose()?;
        if let (Some(std), Some(names)) = (&std_si, &self.std)
            && let Some(row) = std.iter().position(|row| row.iter().any(|s| *s < 0.0))
        {
            let name = names.get_ref().names().first().map_or("", String::as_str);
            return Err(table.malformed(row, name, "a standard uncertainty >= 0", "correct it"));
        }
        let rising = |mut rows: Vec<Vec<f64>>| {
            if falls {
                rows.reverse();
            }
            rows
        };
        let mut pressures = pressures;
        if falls {
            pressures.reverse();
        }
        Ok(ImportedModel {
            title: self.title.clone().unwrap_or_else(|| form.clone()),
            form,
            source: self.source.clone().unwrap_or_else(|| format!("table {}", shown(self.file.get_ref()))),
            quantity,
            chamber: check_id(document, &self.pressure.chamber)?,
            pressures_gauge_pa: pressures,
            values_si: rising(values_si),
            std_si: std_si.map(rising),
            file: FileDigest { name: self.file.get_ref().clone(), sha256: digest::sha256(&bytes) },
        })
    }
}
