//! Which part each column of a log seems to play.

use std::collections::BTreeSet;

use super::text::{one_line, quoted, slug, unique};
use crate::finding::median_step;
use crate::formats::csv::TIMES;
use crate::recording::{Cells, Column, Recording, Table};
use crate::units::{Dimension, Unit};

/// Names of pressures, by which columns are told.
const PRESSURES: [&str; 6] = ["p", "pressure", "press", "druck", "kpa", "bar"];

/// Columns of stamps that every message has: clocks to choose from, and no channels.
const STAMPS: [&str; 3] = ["log_time", "publish_time", "header.stamp"];

/// A column with the part it seems to play.
pub(super) struct Part<'a> {
    pub table: &'a Table,
    pub column: &'a Column,
    /// From 1.
    pub number: usize,
    /// A channel's id.
    pub id: String,
    pub unit: Option<Unit>,
    /// The smallest and the largest number in all logs.
    pub range: (f64, f64),
}

impl Part<'_> {
    /// How the manifest names the column: by number where the header has no name of its own.
    pub fn reference(&self) -> String {
        if self.table.name.is_empty() && self.column.name == format!("column {}", self.number) {
            self.number.to_string()
        } else {
            quoted(&self.table.full_name(&self.column.name))
        }
    }

    /// As the user is told of it.
    pub fn full_name(&self) -> String {
        one_line(&self.table.full_name(&self.column.name))
    }

    /// Why its unit is a guess.
    pub fn why_no_unit(&self) -> String {
        match &self.column.unit {
            Some(unit) => format!("`{}`, as the log says, is no unit that is known here", one_line(unit)),
            None => "the log does not say".to_owned(),
        }
    }

    /// A hundredth of the range, as two digits.
    pub fn tolerance(&self) -> String {
        let tolerance = 0.01 * (self.range.1 - self.range.0);
        if tolerance > 0.0 && tolerance.is_finite() { format!("{tolerance:.1e}") } else { "1".to_owned() }
    }

    /// A stamp of a clock and the usual step, both as they are logged.
    pub fn stamp_and_step(&self) -> Option<(f64, f64)> {
        let (min, max) = self.range;
        let stamp = if min.abs() > max.abs() { min } else { max };
        let watched = || {
            // A clock that went by was watched in seconds: its largest stamp says how many of what is logged make one.
            let clock = self.column.clock.as_ref()?;
            let (min, max) = self.column.summary.range?;
            let ends = clock.span.into_iter().flat_map(|(first, last)| [first, last]);
            let seconds =
                ends.chain(clock.backs.iter().map(|back| back.seconds.0)).fold(0.0, |a: f64, t| a.max(t.abs()));
            let thousands = (min.abs().max(max.abs()) / seconds).log10() / 3.0;
            let step = clock.steps.usual_s? * 1e3_f64.powf(thousands.round());
            step.is_finite().then_some(step)
        };
        let step = self.column.cells.numbers().and_then(median_step).or_else(watched)?;
        // Differences of stamps have digits that nobody logged.
        Some((stamp, format!("{step:.2e}").parse().unwrap_or(step)))
    }

    fn is_named(&self, names: &[&str]) -> bool {
        words(&self.column.name).iter().any(|word| names.contains(&word.as_str()))
    }
}

/// The columns of numbers; one without any number in all logs is told and left out, and so are those that tell time beside the
/// table's own clock.
pub(super) fn parts<'a>(logs: &[&'a Recording], guesses: &mut Vec<String>) -> Vec<Part<'a>> {
    let (mut ids, mut parts) = (BTreeSet::new(), Vec::new());
    let Some(first) = logs.first() else { return parts };
    for (t, table) in first.tables.iter().enumerate() {
        for (i, column) in table.columns.iter().enumerate() {
            let is_text = matches!(column.cells, Cells::Text(_)) || column.summary.samples == 0;
            let tells_time = table.clock.is_some() && STAMPS.contains(&column.name.as_str());
            if is_text || tells_time || table.clock == Some(i) {
                continue;
            }
            let full = table.full_name(&column.name);
            let Some(range) = range(logs, t, i) else {
                guesses.push(format!("{} is left out: it holds no number in any log", one_line(&full)));
                continue;
            };
            let unit = column.unit.as_deref().and_then(Unit::parse_loose).map(|(unit, _)| unit);
            let name = table.full_name(bare(column));
            let id = unique(&slug(&name, i + 1), &mut ids);
            parts.push(Part { table, column, number: i + 1, id, unit, range });
        }
    }
    parts
}

/// The smallest and the largest number of a column in all logs.
fn range(logs: &[&Recording], table: usize, column: usize) -> Option<(f64, f64)> {
    let of_log = |log: &Recording| log.tables.get(table)?.columns.get(column)?.summary.range;
    let ranges = logs.iter().filter_map(|log| of_log(log));
    ranges.reduce(|(a, b), (c, d)| (a.min(c), b.max(d)))
}

/// The name of a column without the unit behind it: in brackets, or after `_` or `/`.
pub(super) fn bare(column: &Column) -> &str {
    let name = column.name.trim();
    let cut = |open: char| name.rsplit_once(open).map(|(head, _)| head.trim());
    let head = match (&column.unit, name.chars().last()) {
        (Some(_), Some(')')) => cut('('),
        (Some(_), Some(']')) => cut('['),
        (Some(unit), _) => name.strip_suffix(unit.as_str()).and_then(|head| {
            let head = head.trim_end();
            head.strip_suffix('_').or_else(|| head.strip_suffix('/')).map(str::trim)
        }),
        _ => None,
    };
    head.filter(|head| !head.is_empty()).unwrap_or(name)
}

/// Words of a name in lower case.
pub(super) fn words(name: &str) -> Vec<String> {
    let lower = name.to_lowercase();
    lower.split(|c: char| !c.is_alphanumeric()).filter(|word| !word.is_empty()).map(str::to_owned).collect()
}

/// Takes the column of stamps out of the parts: by unit, by name, or the first if it only rises. A table with a clock of its own
/// needs none.
pub(super) fn take_clock<'a>(parts: &mut Vec<Part<'a>>, guesses: &mut Vec<String>) -> Option<Part<'a>> {
    if parts.iter().any(|part| part.table.clock.is_some()) {
        return None;
    }
    let rises = |part: &Part| {
        let numbers = part.column.cells.numbers().unwrap_or_default();
        numbers.len() > 20 && numbers.windows(2).all(|pair| pair[1] > pair[0])
    };
    let by_unit = |part: &Part| part.unit.is_some_and(|unit| unit.dimension == Dimension::Time);
    let unnamed = |part: &Part| part.number == 1 && part.column.name == "column 1";
    let i = parts
        .iter()
        .position(by_unit)
        .or_else(|| parts.iter().position(|p| p.unit.is_none() && p.is_named(&TIMES)))
        .or_else(|| parts.iter().position(|p| unnamed(p) && rises(p)))?;
    let part = parts.remove(i);
    guesses.push(format!("{} is taken for the time", part.full_name()));
    Some(part)
}

/// The part that is a pressure by its unit or its name.
pub(super) fn seems_pressure(parts: &[Part]) -> Option<usize> {
    let by_unit = |part: &Part| part.unit.is_some_and(|unit| unit.dimension == Dimension::Pressure);
    parts
        .iter()
        .position(|p| by_unit(p) && p.is_named(&PRESSURES))
        .or_else(|| parts.iter().position(by_unit))
        .or_else(|| parts.iter().position(|p| p.is_named(&PRESSURES)))
}

/// Takes the pressure out of the parts: by unit, by name, or the first.
pub(super) fn take_pressure<'a>(parts: &mut Vec<Part<'a>>, guesses: &mut Vec<String>) -> Part<'a> {
    let found = seems_pressure(parts);
    // What has a unit of another kind is no pressure; volts may stand for one.
    let may_be = |part: &Part| part.unit.is_none_or(|unit| unit.dimension == Dimension::Voltage);
    let mut part = parts.remove(found.or_else(|| parts.iter().position(may_be)).unwrap_or(0));
    if found.is_none() {
        guesses.push(format!("{} is taken for the pressure: no column is named so", part.full_name()));
    }
    "pressure".clone_into(&mut part.id);
    let mut taken: BTreeSet<String> = parts.iter().map(|other| other.id.clone()).chain([part.id.clone()]).collect();
    if let Some(other) = parts.iter_mut().find(|other| other.id == part.id) {
        other.id = unique(&other.id, &mut taken);
    }
    part
}
