//! `[[model]]` of an actuator file: a prediction brought as a table, such as an export of a finite-element program or the path that a
//! simulator wrote.

mod columns;

use serde::Deserialize;
use toml::Spanned;

use super::comparison::{Quantity, RawQuantity, check_count};
use super::session::{RawColumn, RawReader};
use super::{FileDigest, ReadBeside, check_id, read_named};
use crate::digest;
use crate::document::{Amount, Document, parse_unit};
use crate::error::{IngestError, shown};
use crate::units::{Dimension, Unit};
use columns::{Asked, Columns};

/// A prediction as a table of a quantity over gauge pressure or time, in SI units.
///
/// Over pressure it is the straight line between two rows, and nothing outside its pressures. Over time it is what stands in its rows.
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
    /// What its rows rise with.
    pub over: Over,
    /// Per row, the value of each component.
    pub values_si: Vec<Vec<f64>>,
    /// Per row, the standard uncertainty of each component, if the table has any.
    pub std_si: Option<Vec<Vec<f64>>>,
    /// The table, with its digest.
    pub file: FileDigest,
}

impl ImportedModel {
    /// The rows in the order in which they were written: that of the path.
    pub fn path(&self) -> Vec<usize> {
        let rows = 0..self.values_si.len();
        if matches!(self.over, Over::Pressure { falls: true, .. }) { rows.rev().collect() } else { rows.collect() }
    }
}

/// What the rows of an imported model rise with.
#[derive(Debug, Clone, PartialEq)]
pub enum Over {
    /// Gauge pressure.
    Pressure {
        /// The chamber whose pressure it is.
        chamber: String,
        /// Rising, in Pa.
        gauge_pa: Vec<f64>,
        /// The rows were written from the top down: so goes the path.
        falls: bool,
    },
    /// Time.
    Time {
        /// Rising stamps, in s.
        seconds: Vec<f64>,
    },
}

impl Over {
    /// What the rows rise with: gauge pressures in Pa, or stamps in s.
    pub fn rising(&self) -> &[f64] {
        match self {
            Self::Pressure { gauge_pa, .. } => gauge_pa,
            Self::Time { seconds } => seconds,
        }
    }
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
    reader: Option<RawReader>,
    pressure: Option<RawPressure>,
    time: Option<RawTime>,
    predicted: Spanned<OneOrMany>,
    std: Option<Spanned<OneOrMany>>,
    unit: Option<Spanned<String>>,
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
    column: Spanned<RawColumn>,
    unit: Option<Spanned<String>>,
    chamber: Spanned<String>,
    #[serde(rename = "reference")]
    _reference: Reference,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawTime {
    column: Spanned<RawColumn>,
    unit: Option<Spanned<String>>,
    /// Added to its stamps, which count from a zero of their own.
    offset: Option<Amount>,
}

#[derive(Deserialize)]
#[serde(rename_all = "lowercase")]
enum Reference {
    Gauge,
}

/// One column, or one per component, by name or number.
#[derive(Deserialize)]
#[serde(untagged, expecting = "a column's name in quotes or its number, or one per component in brackets")]
enum OneOrMany {
    One(RawColumn),
    Many(Vec<RawColumn>),
}

impl OneOrMany {
    fn all(&self) -> &[RawColumn] {
        match self {
            Self::One(column) => std::slice::from_ref(column),
            Self::Many(columns) => columns,
        }
    }
}

/// The unit that a manifest states for columns, if it does.
fn stated(document: &Document, unit: Option<&Spanned<String>>) -> Result<Option<Unit>, IngestError> {
    unit.map(|unit| parse_unit(document, unit)).transpose()
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
        let (rising, rising_unit, dimension) = match (&self.pressure, &self.time) {
            (Some(pressure), None) => (&pressure.column, pressure.unit.as_ref(), Dimension::Pressure),
            (None, Some(time)) => (&time.column, time.unit.as_ref(), Dimension::Time),
            (both, _) => {
                let found = if both.is_some() { "both" } else { "neither" };
                let next =
                    "say over what the table is: pressure = { column, chamber, reference }, or time = { column }";
                return Err(document.malformed(self.file.span(), "one of `pressure` and `time`", found, next));
            }
        };
        let (full, bytes) = read_named(document, &self.file, beside)?;
        let unit = stated(document, self.unit.as_ref())?;
        let asked = |column, span| Asked { column, span, unit, dimension: quantity.unit.dimension };
        let mut all = vec![Asked {
            column: rising.get_ref(),
            span: rising.span(),
            unit: stated(document, rising_unit)?,
            dimension,
        }];
        for columns in [Some(&self.predicted), self.std.as_ref()].into_iter().flatten() {
            check_count(document, columns.span(), columns.get_ref().all().len(), &quantity)?;
            all.extend(columns.get_ref().all().iter().map(|column| asked(column, columns.span())));
        }
        let options = self.reader.as_ref().map(|reader| reader.options(document)).transpose()?;
        let columns = Columns::read(document, (&full, &bytes), options.as_ref(), &all)?;
        let mut rising_si = columns.first().to_vec();
        if rising_si.len() < 2 {
            let (expected, what) = match dimension {
                Dimension::Pressure => ("at least two pressures", "pressures"),
                _ => ("at least two stamps", "stamps"),
            };
            let found = format!("{} in {full}", rising_si.len());
            let next = format!("export the model at more {what}: nothing is extrapolated");
            return Err(document.malformed(self.file.span(), expected, found, next));
        }
        // From the top down is the same table; the two ends say which way it goes. Time goes one way.
        let falls = dimension == Dimension::Pressure && rising_si.first() > rising_si.last();
        let goes_on = |i: usize| if falls { rising_si[i] < rising_si[i - 1] } else { rising_si[i] > rising_si[i - 1] };
        if let Some(row) = (1..rising_si.len()).find(|&i| !goes_on(i)) {
            let (expected, next) = match dimension {
                Dimension::Pressure => (
                    "pressures that rise from row to row, or fall from row to row",
                    "sort the rows, and keep one value per pressure: loading or unloading",
                ),
                _ => ("stamps that rise from row to row", "sort the rows, and keep one row per stamp"),
            };
            return Err(columns.malformed(row, 0, expected, next));
        }
        let width = quantity.width();
        let values_si = columns.rows(1..=width);
        let std_si = self.std.as_ref().map(|_| columns.rows(width + 1..=2 * width));
        let negative = |row: &Vec<f64>| row.iter().position(|s| *s < 0.0);
        let first = std_si.iter().flatten().enumerate().find_map(|(i, row)| Some((i, negative(row)?)));
        if let Some((row, component)) = first {
            return Err(columns.malformed(row, 1 + width + component, "a standard uncertainty >= 0", "correct it"));
        }
        let ordered = |mut rows: Vec<Vec<f64>>| {
            if falls {
                rows.reverse();
            }
            rows
        };
        if falls {
            rising_si.reverse();
        }
        let over = match (&self.pressure, &self.time) {
            (Some(pressure), _) => {
                Over::Pressure { chamber: check_id(document, &pressure.chamber)?, gauge_pa: rising_si, falls }
            }
            (None, time) => {
                let offset = time.as_ref().and_then(|time| time.offset.as_ref());
                let offset_s = offset.map_or(Ok(0.0), |offset| offset.signed(document, Dimension::Time))?;
                Over::Time { seconds: rising_si.into_iter().map(|stamp| stamp + offset_s).collect() }
            }
        };
        Ok(ImportedModel {
            title: self.title.clone().unwrap_or_else(|| form.clone()),
            form,
            source: self.source.clone().unwrap_or_else(|| format!("table {}", shown(self.file.get_ref()))),
            quantity,
            over,
            values_si: ordered(values_si),
            std_si: std_si.map(ordered),
            file: FileDigest { name: self.file.get_ref().clone(), sha256: digest::sha256(&bytes) },
        })
    }
}
