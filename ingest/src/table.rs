//! CSV tables of published numbers: a name row, a unit row, numbers; `#` starts a comment line; an empty cell is a hole.

use csv::ReaderBuilder;

use crate::document::utf8;
use crate::error::{IngestError, Place, shown, suggestion};
use crate::limits::{TABLE_COLUMNS_MAX, TABLE_ROWS_MAX};
use crate::number::{self, Printed};
use crate::units::{Dimension, Unit};

/// A table as written: every cell still text, with its line.
#[derive(Debug, Clone)]
pub struct Table {
    file: String,
    names: Vec<String>,
    names_line: usize,
    units: Vec<String>,
    units_line: usize,
    rows: Vec<Row>,
}

#[derive(Debug, Clone)]
struct Row {
    line: usize,
    cells: Vec<String>,
}

/// One column as numbers; a hole in print is `None`.
#[derive(Debug, Clone, PartialEq)]
pub struct Column {
    /// The unit of the unit row.
    pub unit: Unit,
    /// The numbers, one per row.
    pub cells: Vec<Option<Printed>>,
}

impl Table {
    /// Reads a table.
    ///
    /// # Errors
    /// [`IngestError::Malformed`] for text that is not UTF-8 or not CSV, a name given twice, a missing unit row, or a row with
    /// another number of cells than the name row.
    pub fn read(file: &str, bytes: &[u8]) -> Result<Self, IngestError> {
        let text = utf8(file, bytes)?;
        let mut reader = ReaderBuilder::new()
            .has_headers(false)
            .flexible(true)
            .comment(Some(b'#'))
            .trim(csv::Trim::All)
            .from_reader(text.as_bytes());
        let mut rows = Vec::new();
        for record in reader.records() {
            let record = record.map_err(|error| {
                let line = error.position().and_then(|p| usize::try_from(p.line()).ok());
                malformed(Place::new(file, line, None), "CSV", error.to_string(), "correct the line")
            })?;
            let offset = record.position().and_then(|p| usize::try_from(p.byte()).ok()).unwrap_or(0);
            let line = line_of_record(text, offset);
            if rows.len() == TABLE_ROWS_MAX + 2 {
                let place = Place::new(file, Some(line), None);
                let expected = format!("a published table of at most {TABLE_ROWS_MAX} rows");
                return Err(malformed(place, &expected, "more".to_owned(), "split the table"));
            }
            rows.push(Row { line, cells: record.iter().map(str::to_owned).collect() });
        }
        let mut rows = rows.into_iter();
        let (Some(names), Some(units)) = (rows.next(), rows.next()) else {
            let place = Place::new(file, None, None);
            return Err(malformed(place, "a name row and a unit row", "fewer than two rows".into(), "add them"));
        };
        if names.cells.len() > TABLE_COLUMNS_MAX {
            let place = Place::new(file, Some(names.line), None);
            let expected = format!("a published table of at most {TABLE_COLUMNS_MAX} columns");
            return Err(malformed(place, &expected, format!("{} columns", names.cells.len()), "split the table"));
        }
        for (i, name) in names.cells.iter().enumerate() {
            if names.cells[..i].contains(name) {
                let place = Place::new(file, Some(names.line), Some(format!("column `{name}`")));
                return Err(malformed(place, "every column name once", format!("{} twice", shown(name)), "rename one"));
            }
        }
        let table = Self {
            file: file.to_owned(),
            names: names.cells,
            names_line: names.line,
            units: units.cells,
            units_line: units.line,
            rows: rows.collect(),
        };
        table.check_widths()?;
        Ok(table)
    }

    fn check_widths(&self) -> Result<(), IngestError> {
        let lines = std::iter::once((self.units_line, self.units.len()))
            .chain(self.rows.iter().map(|row| (row.line, row.cells.len())));
        for (line, width) in lines {
            if width != self.names.len() {
                let place = Place::new(&self.file, Some(line), None);
                let expected = format!("{} cells, as in the name row", self.names.len());
                return Err(IngestError::Malformed {
                    place,
                    expected,
                    found: format!("{width} cells"),
                    next: "leave a missing number empty, but keep its comma".to_owned(),
                });
            }
        }
        Ok(())
    }

    /// The column names, in order.
    pub fn names(&self) -> &[String] {
        &self.names
    }

    /// The column names, each with its unit where it has one.
    pub fn names_with_units(&self) -> Vec<String> {
        let with_unit = |(name, unit): (&String, &String)| {
            if unit.is_empty() { name.clone() } else { format!("{name} / {unit}") }
        };
        self.names.iter().zip(&self.units).map(with_unit).collect()
    }

    /// The error of a hole where a value is needed.
    pub fn hole(&self, row: usize, column: &str, needed: &str) -> IngestError {
        let place = Place::new(&self.file, Some(self.rows[row].line), Some(format!("column `{column}`")));
        malformed(place, needed, "no number".to_owned(), "fill in the cell or remove the row")
    }

    /// The error of a cell that is a number, but not one that may stand there.
    pub fn malformed(&self, row: usize, column: &str, expected: &str, next: &str) -> IngestError {
        let place = Place::new(&self.file, Some(self.rows[row].line), Some(format!("column `{column}`")));
        let found = self.names.iter().position(|n| n == column).map_or("", |i| self.text(row, i));
        malformed(place, expected, shown(found), next)
    }

    /// The error of a column that nobody declared.
    pub fn undeclared(&self, column: &str, declared: &[&str]) -> IngestError {
        let place = Place::new(&self.file, Some(self.names_line), Some(format!("column `{column}`")));
        let found = format!("`{column}`, which dataset.toml does not declare");
        malformed(place, &format!("columns {}", declared.join(", ")), found, "declare it or remove it")
    }

    /// How many rows of numbers there are.
    pub fn height(&self) -> usize {
        self.rows.len()
    }

    /// The file's line of a row.
    pub fn line(&self, row: usize) -> usize {
        self.rows[row].line
    }

    /// A cell's text as printed.
    pub fn text(&self, row: usize, column: usize) -> &str {
        &self.rows[row].cells[column]
    }

    /// A column as numbers in SI units.
    ///
    /// # Errors
    /// [`IngestError::Malformed`] if the column is missing (with the nearest name), its unit is unknown or measures something
    /// else, or a cell is neither empty nor a number.
    pub fn column(&self, name: &str, dimension: Dimension) -> Result<Column, IngestError> {
        self.column_in(name, dimension, None)
    }

    /// A column whose unit is stated elsewhere, where the unit row does not say it.
    ///
    /// # Errors
    /// As [`Table::column`], and for a unit row that says another unit.
    pub fn column_in(&self, name: &str, dimension: Dimension, stated: Option<Unit>) -> Result<Column, IngestError> {
        let Some(index) = self.names.iter().position(|n| n == name) else {
            let place = Place::new(&self.file, Some(self.names_line), Some(format!("column `{name}`")));
            let found = format!("columns {}", self.names.join(", "));
            let next = suggestion(name, self.names.iter().map(String::as_str));
            return Err(malformed(place, &format!("a column named `{name}`"), found, &next));
        };
        let symbol = &self.units[index];
        let place = || Place::new(&self.file, Some(self.units_line), Some(format!("column `{name}`")));
        let unit = if symbol.is_empty() { stated } else { Unit::parse(symbol) };
        let Some(unit) = unit else {
            if symbol.parse::<f64>().is_ok() {
                let next = "write the units in a line of their own below the names, such as `kPa,mm`";
                return Err(malformed(place(), "a unit", shown(symbol), next));
            }
            return Err(malformed(place(), "a known unit", shown(symbol), &Unit::suggestion(symbol)));
        };
        if let Some(stated) = stated.filter(|stated| *stated != unit) {
            let expected = format!("unit `{}`, as is stated", stated.symbol);
            let next = "remove the stated `unit`, or correct one of them";
            return Err(malformed(place(), &expected, shown(symbol), next));
        }
        if unit.dimension != dimension {
            return Err(malformed(
                place(),
                dimension.name(),
                format!("unit {}", shown(symbol)),
                "correct the unit or the column",
            ));
        }
        let cells = self.rows.iter().map(|row| self.cell(row, index, name, unit)).collect::<Result<_, _>>()?;
        Ok(Column { unit, cells })
    }

    /// A column without holes.
    ///
    /// # Errors
    /// As [`Table::column`], and for a hole, with what is `needed` instead.
    pub fn every(&self, name: &str, dimension: Dimension, needed: &str) -> Result<Vec<Printed>, IngestError> {
        self.every_in(name, dimension, None, needed)
    }

    /// A column without holes, whose unit is stated elsewhere where the unit row does not say it.
    ///
    /// # Errors
    /// As [`Table::column_in`], and for a hole, with what is `needed` instead.
    pub fn every_in(
        &self,
        name: &str,
        dimension: Dimension,
        stated: Option<Unit>,
        needed: &str,
    ) -> Result<Vec<Printed>, IngestError> {
        let number = |(row, cell): (usize, Option<Printed>)| match cell {
            Some(cell) if cell.si.is_finite() => Ok(cell),
            _ => Err(self.hole(row, name, needed)),
        };
        self.column_in(name, dimension, stated)?.cells.into_iter().enumerate().map(number).collect()
    }

    fn cell(&self, row: &Row, index: usize, name: &str, unit: Unit) -> Result<Option<Printed>, IngestError> {
        let text = &row.cells[index];
        if text.is_empty() {
            return Ok(None);
        }
        let in_si = |(value, half): (f64, f64)| (unit.to_si(value), unit.to_si(half));
        // A number may leave the range of doubles on its way to SI; NaN as printed is passed on to be judged.
        let finite = |(value, half): &(f64, f64)| !value.is_infinite() && half.is_finite();
        let Some((si, half_width_si)) = number::parse(text).map(in_si).filter(finite) else {
            let place = Place::new(&self.file, Some(row.line), Some(format!("column `{name}`")));
            let next = "write a decimal number with a point, or leave the cell empty";
            return Err(malformed(place, "a number", shown(text), next));
        };
        Ok(Some(Printed { si, half_width_si }))
    }
}

/// The line of the record that the csv reader found from a byte offset on: it counts the comments and blank lines before a
/// record to the record.
fn line_of_record(text: &str, offset: usize) -> usize {
    let before = text[..offset].matches('\n').count();
    let skipped = text[offset..].lines().take_while(|line| line.trim().is_empty() || line.starts_with('#')).count();
    1 + before + skipped
}

fn malformed(place: Place, expected: &str, found: String, next: &str) -> IngestError {
    IngestError::Malformed { place, expected: expected.to_owned(), found, next: next.to_owned() }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn error(text: &str, column: &str) -> String {
        match Table::read("t.csv", text.as_bytes()).and_then(|t| t.column(column, Dimension::Length).map(|_| ())) {
            Err(error) => error.to_string(),
            Ok(()) => panic!("read without error: {text:?}"),
        }
    }

    #[test]
    fn a_table_reads_with_bom_comments_crlf_and_holes() {
        let text = "\u{feff}# from table 1\r\np,d\r\nkPa,mm\r\n0,30.00\r\n\r\n10,\r\n";
        let table = Table::read("t.csv", text.as_bytes()).unwrap();
        let column = table.column("d", Dimension::Length).unwrap();
        assert_eq!(column.cells.len(), 2);
        assert_eq!(column.cells[1], None);
        let first = column.cells[0].unwrap();
        assert!((first.si - 0.030).abs() < 1e-17 && (first.half_width_si - 5e-6).abs() < 1e-20);
        assert_eq!((table.line(0), table.line(1)), (4, 6));
    }

    #[test]
    fn text_in_a_number_cell_is_named_by_line_and_column() {
        let message = error("p,d\nkPa,mm\n0,30\n10,thirty\n", "d");
        assert!(message.starts_with("t.csv:4: column `d`") && message.contains("`thirty`"), "{message}");
    }

    #[test]
    fn a_decimal_comma_is_not_taken_for_a_number() {
        let message = error("p;d\nkPa;mm\n", "d");
        assert!(message.contains("a column named `d`"), "{message}");
        let message = error("p,d\nkPa,mm\n0,\"30,5\"\n", "d");
        assert!(message.contains("`30,5`") && message.contains("with a point"), "{message}");
    }

    #[test]
    fn a_wrong_unit_is_named_by_line_and_column() {
        let message = error("p,d\nkPa,MPa\n0,30\n", "d");
        assert!(message.starts_with("t.csv:2: column `d`") && message.contains("a length"), "{message}");
        let message = error("p,d\nkPa,mmm\n0,30\n", "d");
        assert!(message.contains("did you mean `mm`?"), "{message}");
    }

    #[test]
    fn a_missing_column_names_the_nearest() {
        let message = error("# table 1\np,diametre\nkPa,mm\n0,30\n", "diameter");
        assert!(message.starts_with("t.csv:2: column"), "{message}");
        assert!(message.contains("did you mean `diametre`?"), "{message}");
    }

    #[test]
    fn ragged_rows_doubled_names_and_bytes_that_are_not_text_are_refused() {
        assert!(error("p,d\nkPa,mm\n0\n", "d").starts_with("t.csv:3\n"));
        assert!(error("d,d\nmm,mm\n", "d").contains("`d` twice"));
        assert!(error("p,d\n", "d").contains("a unit row"));
        let message = Table::read("t.csv", b"p,d\nkPa,\xff\n").unwrap_err().to_string();
        assert!(message.starts_with("t.csv:2") && message.contains("0xff"), "{message}");
    }
}
