//! The columns of an imported model, from a table with a name row and a unit row or from a log of any format.

use std::ops::{Range, RangeInclusive};

use crate::document::Document;
use crate::error::{IngestError, Place, shown};
use crate::finding::{LineMap, Severity};
use crate::formats::{self, Options};
use crate::manifest::session::{RawColumn, column_ref};
use crate::raw::RawFile;
use crate::recording::{self, ColumnRef, Keep};
use crate::table::Table;
use crate::units::{Dimension, Unit};

const NEEDED: &str = "a number in every row of a model's table";

/// A column that a manifest asks for.
pub(super) struct Asked<'a> {
    pub column: &'a RawColumn,
    /// Where it is asked for.
    pub span: Range<usize>,
    /// The unit that is stated beside it.
    pub unit: Option<Unit>,
    /// What it should measure.
    pub dimension: Dimension,
}

/// Columns without holes, in SI units, in the order in which they were asked for.
pub(super) struct Columns {
    file: String,
    names: Vec<String>,
    /// In which they are written.
    units: Vec<Unit>,
    lines: Lines,
    values_si: Vec<Vec<f64>>,
}

enum Lines {
    Table(Vec<usize>),
    Log(LineMap),
}

impl Lines {
    fn of(&self, row: usize) -> Option<usize> {
        let line = match self {
            Self::Table(lines) => lines.get(row).copied().unwrap_or(0),
            Self::Log(lines) => lines.line_of(row),
        };
        (line > 0).then_some(line)
    }
}

impl Columns {
    /// Reads a file: as a log where `reader` says how, else as a table.
    pub fn read(
        document: &Document,
        (file, bytes): (&str, &[u8]),
        reader: Option<&Options>,
        asked: &[Asked],
    ) -> Result<Self, IngestError> {
        match reader {
            None => Self::of_table(document, &Table::read(file, bytes)?, file, asked),
            Some(options) => Self::of_log(document, (file, bytes), options, asked),
        }
    }

    fn of_table(document: &Document, table: &Table, file: &str, asked: &[Asked]) -> Result<Self, IngestError> {
        let (mut names, mut units, mut values_si) = (Vec::new(), Vec::new(), Vec::new());
        for Asked { column, span, unit, dimension } in asked {
            let name = match column_ref(document, column, span)? {
                ColumnRef::Name(name) => name,
                ColumnRef::Number(number) => table.names().get(number - 1).cloned().ok_or_else(|| {
                    let found = format!("column {number} of {}", table.names().len());
                    document.malformed(span.clone(), "a column of the table", found, "count from 1")
                })?,
            };
            let cells = table.every_in(&name, *dimension, *unit, NEEDED)?;
            values_si.push(cells.into_iter().map(|cell| cell.si).collect());
            units.push(table.column_in(&name, *dimension, *unit)?.unit);
            names.push(name);
        }
        let lines = Lines::Table((0..table.height()).map(|row| table.line(row)).collect());
        Ok(Self { file: file.to_owned(), names, units, lines, values_si })
    }

    fn of_log(
        document: &Document,
        (file, bytes): (&str, &[u8]),
        options: &Options,
        asked: &[Asked],
    ) -> Result<Self, IngestError> {
        let refs =
            asked.iter().map(|a| column_ref(document, a.column, &a.span)).collect::<Result<Vec<ColumnRef>, _>>()?;
        let recording = formats::read(&RawFile::of_bytes(file, bytes), options, Keep::Only(&refs))?;
        // A log may lose a line and say so; a model's table has nothing to lose.
        if let Some(finding) = recording.findings.iter().find(|finding| finding.severity != Severity::Note) {
            let line = finding.spans.first().map(|span| span.first_line).filter(|line| *line > 0);
            let place = Place::new(file, line, None);
            return Err(malformed(place, NEEDED, finding.text.clone(), "correct the file"));
        }
        let find = |wanted: &ColumnRef| {
            let keep = Keep::Only(std::slice::from_ref(wanted));
            let here = |table: &recording::Table| {
                (0..table.columns.len()).find(|&i| keep.keeps(&table.name, &table.columns[i].name, i + 1))
            };
            recording.tables.iter().enumerate().find_map(|(t, table)| Some((t, here(table)?)))
        };
        let (mut names, mut units, mut values_si, mut first) = (Vec::new(), Vec::new(), Vec::new(), None);
        for (Asked { span, unit, dimension, .. }, wanted) in asked.iter().zip(&refs) {
            let Some((t, i)) = find(wanted) else {
                let tables = recording.tables.iter();
                let known: Vec<String> =
                    tables.flat_map(|t| t.columns.iter().map(|c| t.full_name(&c.name))).take(40).collect();
                let found = match wanted {
                    ColumnRef::Name(name) => shown(name),
                    ColumnRef::Number(number) => format!("column {number}"),
                };
                let expected = format!("a column of {file}: {}", known.join(", "));
                return Err(document.malformed(span.clone(), expected, found, "correct the column"));
            };
            if *first.get_or_insert(t) != t {
                let next = "name columns of one table: rows of two have no partners";
                return Err(document.malformed(span.clone(), "columns of one table", "columns of several", next));
            }
            let column = &recording.tables[t].columns[i];
            if column.is_dated {
                let next = "write the stamps as numbers, and say their `unit`";
                return Err(document.malformed(span.clone(), "stamps that are numbers", "dates", next));
            }
            let unit = unit_of(document, span, *unit, column)?;
            if unit.dimension != *dimension {
                let found = format!("unit `{}` of column {}", unit.symbol, shown(&column.name));
                return Err(document.malformed(
                    span.clone(),
                    dimension.name(),
                    found,
                    "correct the unit or the column",
                ));
            }
            let values: Vec<f64> = column.cells.numbers().unwrap_or_default().iter().map(|v| unit.to_si(*v)).collect();
            let hole =
                if column.cells.numbers().is_none() { Some(0) } else { values.iter().position(|v| !v.is_finite()) };
            if let Some(row) = hole {
                let line = Some(recording.tables[t].lines.line_of(row)).filter(|line| *line > 0);
                let place = Place::new(file, line, Some(format!("column `{}`", column.name)));
                return Err(malformed(place, NEEDED, "no number".to_owned(), "fill in the cell or remove the row"));
            }
            names.push(column.name.clone());
            units.push(unit);
            values_si.push(values);
        }
        let lines = first.map(|t| recording.tables[t].lines.clone()).unwrap_or_default();
        Ok(Self { file: file.to_owned(), names, units, lines: Lines::Log(lines), values_si })
    }

    /// The numbers of the first column.
    pub fn first(&self) -> &[f64] {
        self.values_si.first().map_or(&[], Vec::as_slice)
    }

    /// Some columns row by row.
    pub fn rows(&self, columns: RangeInclusive<usize>) -> Vec<Vec<f64>> {
        let columns = self.values_si.get(columns).unwrap_or_default();
        let height = columns.first().map_or(0, Vec::len);
        (0..height).map(|row| columns.iter().map(|column| column[row]).collect()).collect()
    }

    /// The error of a number that may not stand where it does.
    pub fn malformed(&self, row: usize, column: usize, expected: &str, next: &str) -> IngestError {
        let item = self.names.get(column).map(|name| format!("column `{name}`"));
        let place = Place::new(&self.file, self.lines.of(row), item);
        let written = self.values_si.get(column).and_then(|values| values.get(row)).zip(self.units.get(column));
        let found = written.map_or_else(String::new, |(si, unit)| unit.to_written(*si).to_string());
        malformed(place, expected, shown(&found), next)
    }
}

/// The unit of a column of a log: the stated one, else the file's. Where both are there and differ, nobody knows which is right.
fn unit_of(
    document: &Document,
    span: &Range<usize>,
    stated: Option<Unit>,
    column: &recording::Column,
) -> Result<Unit, IngestError> {
    let in_file = column.unit.as_deref().and_then(Unit::parse_loose).map(|(unit, _)| unit);
    match (stated, in_file) {
        (Some(stated), Some(other)) if stated != other => {
            let found = format!("`{}` here, `{}` in the file", stated.symbol, other.symbol);
            Err(document.malformed(span.clone(), "one unit", found, "correct one of them"))
        }
        (Some(unit), _) | (None, Some(unit)) => Ok(unit),
        (None, None) => {
            let expected = format!("the unit of column {}, which the file does not say", shown(&column.name));
            Err(document.malformed(span.clone(), expected, "nothing", "add `unit`"))
        }
    }
}

fn malformed(place: Place, expected: &str, found: String, next: &str) -> IngestError {
    IngestError::Malformed { place, expected: expected.to_owned(), found, next: next.to_owned() }
}
