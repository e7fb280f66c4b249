//! A table to be written: columns of numbers and words, each with its name, unit and origin.

use std::collections::BTreeSet;

use serde::Serialize;

use pneuval_ingest::recording::Cells;
use pneuval_ingest::store::{column_name, unique_name};
use pneuval_ingest::units::Unit;

/// Where a column comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Origin {
    /// The clock.
    Time,
    /// What a row is about.
    Label,
    /// Printed beside what was measured: a pressure, a condition.
    Setting,
    /// An instrument.
    Measured,
    /// Asked of a regulator, not measured.
    Commanded,
    /// Computed from measured channels.
    Derived,
    /// Half the width of a measured value's interval.
    HalfWidth,
    /// A model.
    Predicted,
    /// Predicted - measured; of a position, the distance between the two.
    Residual,
    /// What became of a point in a comparison.
    Status,
}

impl Origin {
    /// Its word in comments.
    pub fn words(self) -> &'static str {
        match self {
            Self::Time => "time",
            Self::Label => "label",
            Self::Setting => "setting",
            Self::Measured => "measured",
            Self::Commanded => "commanded, not measured",
            Self::Derived => "derived",
            Self::HalfWidth => "half the width of the interval of what is measured",
            Self::Predicted => "predicted",
            Self::Residual => "predicted - measured",
            Self::Status => "status",
        }
    }
}

/// A column.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Column {
    /// Ends in its unit; once in its table.
    pub name: String,
    /// `None` for words.
    pub unit: Option<Unit>,
    pub title: String,
    pub origin: Origin,
    /// The form that predicts it.
    pub form: Option<String>,
    /// What else is to be known of it.
    pub note: Option<String>,
    /// Numbers are in the unit.
    pub cells: Cells,
}

impl Column {
    /// The symbol of its unit, where it has one.
    pub fn unit_symbol(&self) -> Option<&'static str> {
        self.unit.map(|unit| unit.symbol).filter(|symbol| *symbol != "1")
    }
}

/// What a column is, before it has a name of its own.
pub(super) struct Head {
    /// What its name is made of.
    pub base: String,
    pub title: String,
    pub origin: Origin,
    pub form: Option<String>,
    pub note: Option<String>,
}

impl Head {
    pub fn new(base: &str, title: &str, origin: Origin) -> Self {
        Self { base: base.to_owned(), title: title.to_owned(), origin, form: None, note: None }
    }
}

/// Columns of equal length.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct Table {
    pub columns: Vec<Column>,
    taken: BTreeSet<String>,
}

impl Table {
    pub fn rows(&self) -> usize {
        self.columns.first().map_or(0, |column| column.cells.len())
    }

    /// Adds a column of SI values, in the unit in which they are shown.
    pub fn numbers(&mut self, head: Head, unit: Unit, values_si: impl IntoIterator<Item = f64>) {
        let values = values_si.into_iter().map(|si| unit.to_written(si)).collect();
        self.add(head, Some(unit), Cells::Numbers(values));
    }

    /// Adds a column of numbers in their unit already.
    pub fn written(&mut self, head: Head, unit: Unit, values: Vec<f64>) {
        self.add(head, Some(unit), Cells::Numbers(values));
    }

    /// Adds a column of words.
    pub fn words(&mut self, head: Head, words: Vec<String>) {
        self.add(head, None, Cells::Text(words));
    }

    fn add(&mut self, head: Head, unit: Option<Unit>, cells: Cells) {
        let Head { base, title, origin, form, note } = head;
        let name = unique_name(&column_name(&base, unit.map_or("", |unit| unit.symbol)), &mut self.taken);
        self.columns.push(Column { name, unit, title, origin, form, note, cells });
    }

    /// Puts the rows of another table under its own; a column that one of them lacks is a hole there.
    pub fn stack(&mut self, other: Self) {
        let (above, below) = (self.rows(), other.rows());
        let holes = |cells: &Cells, count: usize| match cells {
            Cells::Text(_) => Cells::Text(vec![String::new(); count]),
            Cells::Numbers(_) | Cells::NotKept => Cells::Numbers(vec![f64::NAN; count]),
        };
        for column in other.columns {
            let same = |own: &&mut Column| own.name == column.name && own.unit == column.unit;
            if let Some(own) = self.columns.iter_mut().find(same) {
                append(&mut own.cells, column.cells);
            } else {
                let mut cells = holes(&column.cells, above);
                append(&mut cells, column.cells);
                let name = unique_name(&column.name, &mut self.taken);
                self.columns.push(Column { name, cells, ..column });
            }
        }
        for own in self.columns.iter_mut().filter(|own| own.cells.len() < above + below) {
            let missing = holes(&own.cells, above + below - own.cells.len());
            append(&mut own.cells, missing);
        }
    }
}

fn append(cells: &mut Cells, more: Cells) {
    match (cells, more) {
        (Cells::Numbers(cells), Cells::Numbers(mut more)) => cells.append(&mut more),
        (Cells::Text(cells), Cells::Text(mut more)) => cells.append(&mut more),
        // Columns of one name and unit hold one kind of cells.
        _ => {}
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table(columns: &[(&str, &str, &[f64])]) -> Table {
        let mut table = Table::default();
        for (base, unit, values) in columns {
            let unit = Unit::parse(unit).unwrap();
            let si: Vec<f64> = values.iter().map(|v| unit.to_si(*v)).collect();
            table.numbers(Head::new(base, base, Origin::Measured), unit, si);
        }
        table
    }

    fn cells(table: &Table) -> Vec<(&str, Vec<String>)> {
        let text = |column: &Column| column.cells.numbers().unwrap().iter().map(ToString::to_string).collect();
        table.columns.iter().map(|column| (column.name.as_str(), text(column))).collect()
    }

    #[test]
    fn names_end_in_the_unit_and_stand_once() {
        let table =
            table(&[("tip-x", "mm", &[7.3]), ("tip.x", "mm", &[1.0]), ("share", "%", &[5.0]), ("n", "1", &[2.0])]);
        let names: Vec<&str> = table.columns.iter().map(|column| column.name.as_str()).collect();
        assert_eq!(names, ["tip_x_mm", "tip_x_mm_2", "share_percent", "n"]);
    }

    #[test]
    fn what_one_table_lacks_is_a_hole_there() {
        let mut stacked = table(&[("p", "kPa", &[1.0, 2.0]), ("a", "deg", &[7.3, 7.5])]);
        stacked.stack(table(&[("p", "kPa", &[3.0]), ("f", "N", &[0.5])]));
        let words = |words: &[&str]| words.iter().map(|w| (*w).to_owned()).collect::<Vec<_>>();
        let expected = [
            ("p_kPa", words(&["1", "2", "3"])),
            ("a_deg", words(&["7.3", "7.5", "NaN"])),
            ("f_N", words(&["NaN", "NaN", "0.5"])),
        ];
        assert_eq!(cells(&stacked), expected);
    }
}
