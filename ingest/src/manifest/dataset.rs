//! `dataset.toml`: a paper's printed tables, what they are compared with, and what else the paper states.

use serde::Deserialize;
use toml::Spanned;

use super::{check_id, check_schema};
use crate::digest;
use crate::document::{Document, RawValue, Value, parse_unit};
use crate::error::{IngestError, suggestion};
use crate::number::Printed;
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

/// What a table measures.
#[derive(Debug, Clone, PartialEq)]
pub struct Quantity {
    /// Its id, as in the model catalogue.
    pub id: String,
    /// Its name on pages.
    pub title: String,
    /// The unit it is shown in.
    pub unit: Unit,
}

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
    /// Measured values; `None` is a hole in print.
    pub measured: Vec<Option<Printed>>,
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
    /// The numbers; `None` is a hole in print.
    pub cells: Vec<Option<Printed>>,
}

/// One row of `validate`: a prediction against the measured column of a quantity.
#[derive(Debug, Clone, PartialEq)]
pub struct ComparisonSpec {
    /// The quantity.
    pub quantity: String,
    /// Id of the prediction: a printed column, a catalogue form, or a fitted variant of one.
    pub form: String,
    /// The catalogue form it evaluates, where `form` names a variant.
    pub model: Option<String>,
    /// Name in legends and tables; the catalogue's where absent.
    pub title: Option<String>,
    /// Parameters calibrated first.
    pub fit: Option<FitSpec>,
    /// Why this comparison is shown but not judged.
    pub not_judged: Option<String>,
    /// A sentence for the page, with `{{ }}` placeholders for computed numbers.
    pub remark: Option<String>,
    /// Where in `dataset.toml` it stands, for errors of whoever evaluates it.
    pub line: usize,
}

/// A calibration before a comparison.
#[derive(Debug, Clone, PartialEq)]
pub struct FitSpec {
    /// The printed column (a prediction's form id, or `measured`) that is fitted.
    pub to: String,
    /// The parameters that move.
    pub parameters: Vec<String>,
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
    measured: RawMeasured,
    #[serde(default)]
    predicted: Vec<RawPredicted>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawQuantity {
    id: Spanned<String>,
    title: String,
    unit: Spanned<String>,
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
struct RawMeasured {
    column: String,
    method: String,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawPredicted {
    column: String,
    form: Spanned<String>,
    title: String,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawComparison {
    quantity: Spanned<String>,
    form: Spanned<String>,
    model: Option<Spanned<String>>,
    title: Option<String>,
    fit: Option<RawFit>,
    judge: Option<Spanned<bool>>,
    reason: Option<String>,
    remark: Option<String>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawFit {
    to: Spanned<String>,
    parameters: Spanned<Vec<String>>,
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

/// Reads a file of the dataset's folder by its name: its full name for messages, and its bytes.
pub type ReadBeside<'a> = &'a dyn Fn(&str) -> Result<(String, Vec<u8>), IngestError>;

impl PublishedDataset {
    /// Reads a dataset and the tables it names.
    ///
    /// # Errors
    /// [`IngestError::Malformed`] with file, line and key or cell; [`IngestError::Read`] for a table that is not there.
    pub fn read(file: &str, bytes: &[u8], beside: ReadBeside) -> Result<Self, IngestError> {
        let document = Document::new(file, bytes)?;
        let raw: Raw = document.parse()?;
        check_schema(&document, &raw.schema)?;
        let mut files = vec![FileDigest { name: "dataset.toml".to_owned(), sha256: digest::sha256(bytes) }];
        let mut open = |name: &Spanned<String>| -> Result<Table, IngestError> {
            check_inside(&document, name)?;
            let (full, bytes) = beside(name.get_ref())?;
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
        let comparisons = comparisons(&document, &raw.comparison, &tables)?;
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

impl RawTable {
    fn checked(&self, document: &Document, table: &Table) -> Result<PublishedTable, IngestError> {
        let unit = parse_unit(document, &self.quantity.unit)?;
        let quantity =
            Quantity { id: check_id(document, &self.quantity.id)?, title: self.quantity.title.clone(), unit };
        let mut chambers = Vec::new();
        let mut pressures_gauge_pa = vec![Vec::new(); table.height()];
        for pressure in &self.pressure {
            chambers.push(check_id(document, &pressure.chamber)?);
            let column = table.column(&pressure.column, Dimension::Pressure)?;
            for (row, cell) in column.cells.iter().enumerate() {
                match cell {
                    Some(cell) if cell.si.is_finite() => pressures_gauge_pa[row].push(cell.si),
                    _ => return Err(table.hole(row, &pressure.column, "a pressure")),
                }
            }
        }
        if chambers.is_empty() {
            return Err(document.malformed(
                self.file.span(),
                "at least one pressure column",
                "none",
                "declare `pressure`",
            ));
        }
        let measured = table.column(&self.measured.column, unit.dimension)?.cells;
        let mut predicted: Vec<PredictedColumn> = Vec::new();
        for raw in &self.predicted {
            let form = check_id(document, &raw.form)?;
            if predicted.iter().any(|p| p.form == form) {
                return Err(document.malformed(
                    raw.form.span(),
                    "every form once",
                    format!("`{form}` twice"),
                    "rename one",
                ));
            }
            if raw.column == self.measured.column {
                let found = format!("`{}`, the measured column", raw.column);
                return Err(document.malformed(
                    raw.form.span(),
                    "a prediction of its own",
                    found,
                    "name another column",
                ));
            }
            let cells = table.column(&raw.column, unit.dimension)?.cells;
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
            measured,
            predicted,
            lines: (0..table.height()).map(|row| table.line(row)).collect(),
            texts: table.names().iter().enumerate().map(|(i, name)| (name.clone(), column(i))).collect(),
        })
    }

    /// A column nobody declared would be data lost in silence.
    fn check_all_declared(&self, table: &Table) -> Result<(), IngestError> {
        let declared: Vec<&str> = self
            .pressure
            .iter()
            .map(|p| p.column.as_str())
            .chain([self.measured.column.as_str()])
            .chain(self.predicted.iter().map(|p| p.column.as_str()))
            .collect();
        match table.names().iter().find(|name| !declared.contains(&name.as_str())) {
            None => Ok(()),
            Some(name) => Err(table.undeclared(name, &declared)),
        }
    }
}

fn comparisons(
    document: &Document,
    raw: &[RawComparison],
    tables: &[PublishedTable],
) -> Result<Vec<ComparisonSpec>, IngestError> {
    let mut specs: Vec<ComparisonSpec> = Vec::new();
    for r in raw {
        let quantity = r.quantity.get_ref();
        let Some(table) = tables.iter().find(|t| &t.quantity.id == quantity) else {
            let next = suggestion(quantity, tables.iter().map(|t| t.quantity.id.as_str()));
            return Err(document.malformed(
                r.quantity.span(),
                "a quantity of a table above",
                format!("`{quantity}`"),
                next,
            ));
        };
        let form = check_id(document, &r.form)?;
        if specs.iter().any(|s| &s.quantity == quantity && s.form == form) {
            let found = format!("`{form}` of `{quantity}` twice");
            return Err(document.malformed(r.form.span(), "every comparison once", found, "remove one"));
        }
        let printed = table.predicted.iter().any(|p| p.form == form);
        let unused = r.model.as_ref().map(Spanned::span).or(r.fit.as_ref().map(|fit| fit.to.span()));
        if let Some(span) = unused.filter(|_| printed) {
            let found = format!("`{form}`, which is printed in the table");
            return Err(document.malformed(
                span,
                "`model` and `fit` only for a form that is computed",
                found,
                "remove them",
            ));
        }
        let fit = match &r.fit {
            None => None,
            Some(fit) => {
                let to = fit.to.get_ref();
                let known = table.predicted.iter().map(|p| p.form.as_str()).chain(["measured"]);
                if !known.clone().any(|k| k == to) {
                    let next = suggestion(to, known);
                    return Err(document.malformed(fit.to.span(), "a column of the table", format!("`{to}`"), next));
                }
                let names = fit.parameters.get_ref();
                if names.iter().enumerate().any(|(i, name)| names[..i].contains(name)) {
                    return Err(document.malformed(
                        fit.parameters.span(),
                        "every parameter once",
                        "one twice",
                        "remove one",
                    ));
                }
                if fit.parameters.get_ref().is_empty() {
                    return Err(document.malformed(fit.parameters.span(), "at least one parameter", "none", "name it"));
                }
                Some(FitSpec { to: to.clone(), parameters: fit.parameters.get_ref().clone() })
            }
        };
        let not_judged = match (&r.judge, &r.reason) {
            (Some(judge), reason) if !judge.get_ref() => match reason {
                Some(reason) if !reason.trim().is_empty() => Some(reason.clone()),
                _ => {
                    let next = "say why this comparison is not judged";
                    return Err(document.malformed(judge.span(), "key `reason` beside judge = false", "nothing", next));
                }
            },
            (_, Some(_)) => {
                let next = "add judge = false, or move the reason to the bound";
                return Err(document.malformed(r.form.span(), "`reason` only beside judge = false", "`reason`", next));
            }
            _ => None,
        };
        specs.push(ComparisonSpec {
            quantity: quantity.clone(),
            form,
            model: r.model.as_ref().map(|m| m.get_ref().clone()),
            title: r.title.clone(),
            fit,
            not_judged,
            remark: r.remark.clone(),
            line: document.line_of(r.form.span().start),
        });
    }
    Ok(specs)
}

/// A dataset's files stay inside its folder.
fn check_inside(document: &Document, name: &Spanned<String>) -> Result<(), IngestError> {
    let text = name.get_ref();
    let inside = std::path::Path::new(text).components().all(|part| matches!(part, std::path::Component::Normal(_)));
    if inside && !text.is_empty() && !text.contains('\\') {
        return Ok(());
    }
    Err(document.malformed(name.span(), "a file inside this folder", format!("`{text}`"), "move the file here"))
}
