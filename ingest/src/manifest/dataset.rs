//! `dataset.toml`: a paper's printed tables, what they are compared with, and what else the paper states.

use serde::Deserialize;
use toml::Spanned;

use super::comparison::{
    Comparable, ComparisonSpec, OneOrMany, Quantity, RawComparison, RawQuantity, check_width, comparisons, not_judged,
};
use super::{ReadBeside, check_id, check_schema, read_named};
use crate::digest;
use crate::document::{Document, RawValue, Value, parse_unit};
use crate::error::{IngestError, shown};
use crate::number::{self, Printed};
use crate::table::Table;
use crate::units::{Dimension, Unit};

/// A published dataset: numbers as printed, and the comparisons asked of them.
#[derive(Debug, Clone, PartialEq)]
pub struct PublishedDataset {
    /// Its id.
    pub id: String,
    /// The actuator it was taken on.
    pub actuator: String,
    /// The paper.
    pub paper: Paper,
    /// Printed tables of pressure against a quantity.
    pub tables: Vec<PublishedTable>,
    /// Which prediction is compared with which table.
    pub comparisons: Vec<ComparisonSpec>,
    /// Errors that the paper states without the data behind them.
    pub statistics: Vec<Statistic>,
    /// Results the paper states outside those tables.
    pub stated: Vec<Stated>,
    /// Tables shown, but not compared.
    pub listings: Vec<Listing>,
    /// Figures whose data are not printed.
    pub unprinted: Vec<String>,
    /// Sentences for the page.
    pub notes: Vec<String>,
    /// Every file read, with its digest.
    pub files: Vec<FileDigest>,
}

/// Where the numbers were printed.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Paper {
    /// Title.
    pub title: String,
    /// Authors, journal, year, DOI, as far as known.
    pub reference: Option<String>,
}

/// A file and its SHA-256.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FileDigest {
    /// Name inside the dataset's folder.
    pub name: String,
    /// SHA-256.
    pub sha256: String,
}

/// Values in SI units, one per component; `None` where print has a hole in any of them.
pub type Cell = Option<Vec<Printed>>;

/// A printed table: gauge pressures, the measured quantity, and columns of predictions, all in SI.
#[derive(Debug, Clone, PartialEq)]
pub struct PublishedTable {
    /// What it measures.
    pub quantity: Quantity,
    /// File name inside the dataset's folder.
    pub file: String,
    /// Where in the paper.
    pub place: String,
    /// How the quantity was measured.
    pub method: String,
    /// Chambers, in the order of `pressures_gauge_pa`.
    pub chambers: Vec<String>,
    /// Per row, the gauge pressure of each chamber.
    pub pressures_gauge_pa: Vec<Vec<f64>>,
    /// What stands beside the pressure at each point: a held angle, a wall thickness.
    pub conditions: Vec<Condition>,
    /// Per row, the value of each condition.
    pub conditions_si: Vec<Vec<Printed>>,
    /// Measured values.
    pub measured: Vec<Cell>,
    /// Predictions printed beside them.
    pub predicted: Vec<PredictedColumn>,
    /// The file's line of each row.
    pub lines: Vec<usize>,
    /// Every cell as printed, by column name, for sentences on the page.
    pub texts: Vec<(String, Vec<String>)>,
}

/// A printed prediction.
#[derive(Debug, Clone, PartialEq)]
pub struct PredictedColumn {
    /// Form id, such as `published-fea`.
    pub form: String,
    /// Name in legends.
    pub title: String,
    /// The numbers.
    pub cells: Vec<Cell>,
}

/// A value that is set beside the pressure, and that a model takes as an input.
#[derive(Debug, Clone, PartialEq)]
pub struct Condition {
    /// Its id, as the model's input.
    pub id: String,
    /// Its name on pages.
    pub title: String,
    /// The unit it is shown in.
    pub unit: Unit,
}

/// An error that a paper states, without the data that would let anyone compute it again.
#[derive(Debug, Clone, PartialEq)]
pub struct Statistic {
    /// What it is an error of.
    pub quantity: Quantity,
    /// Id of the prediction, such as `published-fea`.
    pub form: String,
    /// Its name in legends and tables.
    pub title: String,
    /// Where in the paper.
    pub place: String,
    /// How the quantity was measured.
    pub method: String,
    /// The metrics stated: id, value in SI units (a share for a relative one), line of the file.
    pub metrics: Vec<(String, Printed, usize)>,
    /// Why it is shown but not judged.
    pub not_judged: Option<String>,
    /// A sentence for the page.
    pub remark: Option<String>,
}

/// A result stated in the text.
#[derive(Debug, Clone, PartialEq)]
pub struct Stated {
    /// What it is.
    pub title: String,
    /// Its value and place.
    pub value: Value,
}

/// A table shown as printed.
#[derive(Debug, Clone, PartialEq)]
pub struct Listing {
    /// What it is.
    pub title: String,
    /// Where in the paper.
    pub place: String,
    /// The table.
    pub names: Vec<String>,
    /// Its rows, as printed.
    pub rows: Vec<Vec<String>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Raw {
    schema: Spanned<i64>,
    id: Spanned<String>,
    actuator: Spanned<String>,
    paper: Paper,
    /// Only printed points can be read from this file; sessions have a format of their own.
    #[serde(rename = "basis")]
    _basis: Basis,
    #[serde(default)]
    notes: Vec<String>,
    #[serde(default)]
    unprinted: Vec<String>,
    #[serde(default)]
    table: Vec<RawTable>,
    #[serde(default)]
    comparison: Vec<RawComparison>,
    #[serde(default)]
    statistic: Vec<RawStatistic>,
    #[serde(default)]
    stated: Vec<RawStated>,
    #[serde(default)]
    listing: Vec<RawListing>,
}

#[derive(Deserialize)]
#[serde(rename_all = "kebab-case")]
enum Basis {
    PublishedPoint,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawTable {
    file: Spanned<String>,
    quantity: RawQuantity,
    place: String,
    pressure: Vec<RawPressure>,
    #[serde(default)]
    condition: Vec<RawCondition>,
    measured: RawMeasured,
    #[serde(default)]
    predicted: Vec<RawPredicted>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawPressure {
    column: String,
    chamber: Spanned<String>,
    #[serde(rename = "reference")]
    _reference: PressureReference,
}

/// Gauge or absolute is always said; a printed absolute pressure would need the barometer of that day.
#[derive(Deserialize)]
#[serde(rename_all = "lowercase")]
enum PressureReference {
    Gauge,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawCondition {
    column: String,
    id: Spanned<String>,
    title: String,
    unit: Spanned<String>,
    /// A setting is taken as it is printed, as pressures are; a result that is printed has digits that leave something open.
    #[serde(default = "exact")]
    exact: bool,
}

fn exact() -> bool {
    true
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawMeasured {
    column: Spanned<OneOrMany>,
    method: String,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawStatistic {
    quantity: RawQuantity,
    form: Spanned<String>,
    title: String,
    place: String,
    method: String,
    /// Metric id to the number as printed, in the quantity's unit or in percent.
    metrics: std::collections::BTreeMap<String, Spanned<String>>,
    judge: Option<Spanned<bool>>,
    reason: Option<String>,
    remark: Option<String>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawPredicted {
    column: Spanned<OneOrMany>,
    form: Spanned<String>,
    title: String,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawStated {
    title: String,
    value: RawValue,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawListing {
    file: Spanned<String>,
    title: String,
    place: String,
}

impl PublishedDataset {
    /// Reads a dataset and the tables it names.
    ///
    /// # Errors
    /// [`IngestError::Malformed`] with file, line and key or cell, or with the key that names a file that cannot be read.
    pub fn read(file: &str, bytes: &[u8], beside: ReadBeside) -> Result<Self, IngestError> {
        let document = Document::new(file, bytes)?;
        let raw: Raw = document.parse()?;
        check_schema(&document, &raw.schema)?;
        let mut files = vec![FileDigest { name: "dataset.toml".to_owned(), sha256: digest::sha256(bytes) }];
        let mut open = |name: &Spanned<String>| -> Result<Table, IngestError> {
            let (full, bytes) = read_named(&document, name, beside)?;
            files.push(FileDigest { name: name.get_ref().clone(), sha256: digest::sha256(&bytes) });
            Table::read(&full, &bytes)
        };
        let mut tables: Vec<PublishedTable> = Vec::new();
        for raw_table in &raw.table {
            let table = open(&raw_table.file)?;
            let table = raw_table.checked(&document, &table)?;
            if tables.iter().any(|t| t.quantity.id == table.quantity.id) {
                let found = format!("`{}` twice", table.quantity.id);
                return Err(document.malformed(
                    raw_table.quantity.id.span(),
                    "one table per quantity",
                    found,
                    "merge them",
                ));
            }
            tables.push(table);
        }
        let mut listings = Vec::new();
        for raw_listing in &raw.listing {
            let table = open(&raw_listing.file)?;
            let columns = table.names().len();
            let row = |i| (0..columns).map(|c| table.text(i, c).to_owned()).collect();
            listings.push(Listing {
                title: raw_listing.title.clone(),
                place: raw_listing.place.clone(),
                names: table.names_with_units(),
                rows: (0..table.height()).map(row).collect(),
            });
        }
        let comparable: Vec<Comparable> = tables.iter().map(PublishedTable::comparable).collect();
        let comparisons = comparisons(&document, &raw.comparison, &comparable)?;
        let mut statistics: Vec<Statistic> = Vec::new();
        for raw_statistic in &raw.statistic {
            let s = raw_statistic.checked(&document)?;
            let same = |quantity: &str, form: &str| quantity == s.quantity.id && form == s.form;
            if statistics.iter().any(|o| same(&o.quantity.id, &o.form))
                || comparisons.iter().any(|o| same(&o.quantity, &o.form))
            {
                let found = format!("`{}` of `{}` twice", s.form, s.quantity.id);
                return Err(document.malformed(raw_statistic.form.span(), "every form once", found, "rename one"));
            }
            statistics.push(s);
        }
        let stated = raw
            .stated
            .iter()
            .map(|s| Ok(Stated { title: s.title.clone(), value: s.value.checked(&document)? }))
            .collect::<Result<_, IngestError>>()?;
        Ok(Self {
            id: check_id(&document, &raw.id)?,
            actuator: check_id(&document, &raw.actuator)?,
            paper: raw.paper,
            tables,
            comparisons,
            statistics,
            stated,
            listings,
            unprinted: raw.unprinted,
            notes: raw.notes,
            files,
        })
    }

    /// The table of a quantity.
    pub fn table(&self, quantity: &str) -> Option<&PublishedTable> {
        self.tables.iter().find(|t| t.quantity.id == quantity)
    }
}

impl PublishedTable {
    fn comparable(&self) -> Comparable<'_> {
        Comparable {
            quantity: &self.quantity.id,
            width: self.quantity.width(),
            columns: self.predicted.iter().map(|p| p.form.as_str()).collect(),
        }
    }
}

impl RawTable {
    fn checked(&self, document: &Document, table: &Table) -> Result<PublishedTable, IngestError> {
        let quantity = self.quantity.checked(document)?;
        let (chambers, pressures_gauge_pa) = self.pressures(document, table)?;
        let (conditions, conditions_si) = self.conditions(document, table)?;
        let measured = cells(document, table, &self.measured.column, &quantity)?;
        let mut predicted: Vec<PredictedColumn> = Vec::new();
        for raw in &self.predicted {
            let form = check_id(document, &raw.form)?;
            if predicted.iter().any(|p| p.form == form) {
                let found = format!("`{form}` twice");
                return Err(document.malformed(raw.form.span(), "every form once", found, "rename one"));
            }
            let measured_names = self.measured.column.get_ref().names();
            if let Some(name) = raw.column.get_ref().names().iter().find(|name| measured_names.contains(name)) {
                let found = format!("`{name}`, the measured column");
                let next = "name another column";
                return Err(document.malformed(raw.form.span(), "a prediction of its own", found, next));
            }
            let cells = cells(document, table, &raw.column, &quantity)?;
            predicted.push(PredictedColumn { form, title: raw.title.clone(), cells });
        }
        self.check_all_declared(table)?;
        let column = |i| (0..table.height()).map(|row| table.text(row, i).to_owned()).collect();
        Ok(PublishedTable {
            quantity,
            file: self.file.get_ref().clone(),
            place: self.place.clone(),
            method: self.measured.method.clone(),
            chambers,
            pressures_gauge_pa,
            conditions,
            conditions_si,
            measured,
            predicted,
            lines: (0..table.height()).map(|row| table.line(row)).collect(),
            texts: table.names().iter().enumerate().map(|(i, name)| (name.clone(), column(i))).collect(),
        })
    }

    fn pressures(&self, document: &Document, table: &Table) -> Result<(Vec<String>, Vec<Vec<f64>>), IngestError> {
        let mut chambers: Vec<String> = Vec::new();
        let mut rows = vec![Vec::new(); table.height()];
        for pressure in &self.pressure {
            let chamber = check_id(document, &pressure.chamber)?;
            if chambers.contains(&chamber) {
                let found = format!("`{chamber}` twice");
                return Err(document.malformed(pressure.chamber.span(), "every chamber once", found, "rename one"));
            }
            chambers.push(chamber);
            for (row, cell) in rows.iter_mut().zip(table.every(&pressure.column, Dimension::Pressure, "a pressure")?) {
                row.push(cell.si);
            }
        }
        if chambers.is_empty() {
            let next = "declare `pressure`";
            return Err(document.malformed(self.file.span(), "at least one pressure column", "none", next));
        }
        Ok((chambers, rows))
    }

    fn conditions(
        &self,
        document: &Document,
        table: &Table,
    ) -> Result<(Vec<Condition>, Vec<Vec<Printed>>), IngestError> {
        let mut conditions: Vec<Condition> = Vec::new();
        let mut rows = vec![Vec::new(); table.height()];
        for raw in &self.condition {
            let id = raw.id.get_ref();
            if conditions.iter().any(|c| &c.id == id) {
                let found = format!("`{id}` twice");
                return Err(document.malformed(raw.id.span(), "every condition once", found, "rename one"));
            }
            let unit = parse_unit(document, &raw.unit)?;
            let cells = table.every(&raw.column, unit.dimension, "a value of the condition")?;
            let open = |cell: Printed| if raw.exact { Printed { half_width_si: 0.0, ..cell } } else { cell };
            rows.iter_mut().zip(cells).for_each(|(row, cell)| row.push(open(cell)));
            conditions.push(Condition { id: id.clone(), title: raw.title.clone(), unit });
        }
        Ok((conditions, rows))
    }

    /// A column nobody declared would be data lost in silence.
    fn check_all_declared(&self, table: &Table) -> Result<(), IngestError> {
        let declared: Vec<&str> = self
            .pressure
            .iter()
            .map(|p| p.column.as_str())
            .chain(self.condition.iter().map(|c| c.column.as_str()))
            .chain(self.measured.column.get_ref().names().iter().map(String::as_str))
            .chain(self.predicted.iter().flat_map(|p| p.column.get_ref().names()).map(String::as_str))
            .collect();
        match table.names().iter().find(|name| !declared.contains(&name.as_str())) {
            None => Ok(()),
            Some(name) => Err(table.undeclared(name, &declared)),
        }
    }
}

/// The values of a quantity, from one column per component.
fn cells(
    document: &Document,
    table: &Table,
    columns: &Spanned<OneOrMany>,
    quantity: &Quantity,
) -> Result<Vec<Cell>, IngestError> {
    check_width(document, columns, quantity)?;
    let names = columns.get_ref().names();
    let columns = names.iter().map(|name| Ok(table.column(name, quantity.unit.dimension)?.cells));
    let columns = columns.collect::<Result<Vec<_>, IngestError>>()?;
    Ok((0..table.height()).map(|row| columns.iter().map(|column| column[row]).collect()).collect())
}

impl RawStatistic {
    fn checked(&self, document: &Document) -> Result<Statistic, IngestError> {
        let quantity = self.quantity.checked(document)?;
        let mut metrics = Vec::new();
        for (id, text) in &self.metrics {
            // A relative error is printed in percent; which metrics are relative, whoever knows them says.
            let unit = if id.starts_with("relative_") { Unit::PERCENT } else { quantity.unit };
            let parsed = number::parse(text.get_ref()).filter(|(value, _)| value.is_finite());
            let Some((value, half)) = parsed else {
                let expected = "a number as printed, in quotes so that its digits count";
                let next = "write it with a point, such as \"1.10\"";
                return Err(document.malformed(text.span(), expected, shown(text.get_ref()), next));
            };
            let printed = Printed { si: unit.to_si(value), half_width_si: unit.to_si(half) };
            metrics.push((id.clone(), printed, document.line_of(text.span().start)));
        }
        if metrics.is_empty() {
            return Err(document.malformed(self.form.span(), "at least one metric", "none", "add it to `metrics`"));
        }
        Ok(Statistic {
            quantity,
            form: check_id(document, &self.form)?,
            title: self.title.clone(),
            place: self.place.clone(),
            method: self.method.clone(),
            metrics,
            not_judged: not_judged(document, &self.form, self.judge.as_ref(), self.reason.as_deref())?,
            remark: self.remark.clone(),
        })
    }
}
