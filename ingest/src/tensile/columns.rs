//! Which column of a test is what, and what the file says of its strip.

use crate::IngestError;
use crate::error::Place;
use crate::finding::{Finding, FindingKind, LineMap, Severity, Span};
use crate::recording::{Column, Table};
use crate::units::{Dimension, Unit};

use super::Specimen;

/// A column as a user names it: `stress/MPa`, `stretch`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Named {
    /// What it is.
    pub name: String,
    /// Its unit, if it is said.
    pub unit: Option<String>,
}

/// What a column of a test may be.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Role {
    Time,
    Stretch,
    Strain,
    TrueStrain,
    Displacement,
    Stress,
    TrueStress,
    Force,
}

const ROLES: &str = "time, stretch, strain, true strain, displacement, stress, true stress, force";

impl Role {
    /// What a name and a unit say.
    fn of(name: &str, unit: Option<&str>) -> Option<Self> {
        let name = name.to_lowercase();
        let has = |words: &[&str]| words.iter().any(|word| name.contains(word));
        let is_true = has(&["true", "cauchy", "log", "hencky"]);
        let dimension = unit.and_then(Unit::parse_loose).map(|(unit, _)| unit.dimension);
        // Names before units: `Elongation (%)` is a strain, `extension/mm` is none.
        if has(&["strain"]) || (has(&["elongation", "extension"]) && dimension == Some(Dimension::Ratio)) {
            return Some(if is_true { Self::TrueStrain } else { Self::Strain });
        }
        if has(&["stretch", "lambda", "λ"]) {
            return Some(Self::Stretch);
        }
        if has(&["stress", "spannung", "contrainte"]) {
            return Some(if is_true { Self::TrueStress } else { Self::Stress });
        }
        if has(&["force", "load", "kraft"]) {
            return Some(Self::Force);
        }
        if has(&["displacement", "extension", "elongation", "crosshead", "stroke", "position", "weg"]) {
            return Some(Self::Displacement);
        }
        if has(&["time", "zeit", "temps"]) {
            return Some(Self::Time);
        }
        match dimension? {
            Dimension::Pressure => Some(Self::Stress),
            Dimension::Force => Some(Self::Force),
            Dimension::Length => Some(Self::Displacement),
            Dimension::Time => Some(Self::Time),
            _ => None,
        }
    }

    fn dimension(self) -> Dimension {
        match self {
            Self::Time => Dimension::Time,
            Self::Stretch | Self::Strain | Self::TrueStrain => Dimension::Ratio,
            Self::Displacement => Dimension::Length,
            Self::Stress | Self::TrueStress => Dimension::Pressure,
            Self::Force => Dimension::Force,
        }
    }
}

/// A column with what it is, in SI units.
struct Told {
    role: Role,
    name: String,
    values: Vec<f64>,
}

/// The columns of a test.
pub struct Meant {
    told: Vec<Told>,
    /// Seconds, if there is a clock.
    pub time: Option<Vec<f64>>,
}

/// Finds out which column is what.
///
/// # Errors
/// [`IngestError::Malformed`] for more names than columns, a name that says nothing, a unit that is missing or of another dimension.
pub fn meant(file: &str, table: &Table, names: &[Named]) -> Result<Meant, IngestError> {
    let malformed = |item: String, expected: &str, found: String, next: &str| IngestError::Malformed {
        place: Place::new(file, None, Some(item)),
        expected: expected.to_owned(),
        found,
        next: next.to_owned(),
    };
    let numbers: Vec<&Column> = table.columns.iter().filter(|column| column.cells.numbers().is_some()).collect();
    if names.len() > numbers.len() {
        let found = format!("{} names", names.len());
        let expected = format!("at most {} names, one a column of numbers", numbers.len());
        return Err(malformed("columns".to_owned(), &expected, found, "name the columns from the left"));
    }
    let mut told: Vec<Told> = Vec::new();
    for (i, column) in numbers.iter().enumerate() {
        let named = names.get(i);
        let name = named.map_or(column.name.as_str(), |named| named.name.as_str());
        let unit = named.map_or(column.unit.as_deref(), |named| named.unit.as_deref());
        let unit = unit.or_else(|| name.contains('%').then_some("%"));
        let role = Role::of(name, unit);
        let Some(role) = role else {
            if named.is_some() && !matches!(name, "-" | "_" | "") {
                let found = format!("`{name}`");
                return Err(malformed("columns".to_owned(), ROLES, found, "write `-` for a column that is not used"));
            }
            continue;
        };
        let known = unit.map(|symbol| Unit::parse_loose(symbol).map(|(unit, _)| unit).ok_or(symbol)).transpose();
        let unit = known.map_err(|symbol| {
            malformed(format!("column `{name}`"), "a known unit", format!("`{symbol}`"), &Unit::suggestion(symbol))
        })?;
        let factor = match unit {
            Some(unit) if unit.dimension == role.dimension() => unit.factor,
            Some(unit) => {
                let expected = role.dimension().name();
                return Err(malformed(
                    format!("column `{name}`"),
                    expected,
                    format!("`{}`", unit.symbol),
                    "correct the unit",
                ));
            }
            None if role.dimension() == Dimension::Ratio => 1.0,
            // A clock without a unit is not needed.
            None if role == Role::Time => continue,
            None => {
                let expected = role.dimension().name();
                let next = format!("say it: --columns \"…, {name}/UNIT\", one name a column from the left");
                return Err(malformed(format!("column `{name}`"), expected, "no unit".to_owned(), &next));
            }
        };
        let values = column.cells.numbers().unwrap_or_default().iter().map(|v| factor * v).collect();
        // Of two of a kind the first is meant.
        if told.iter().all(|other| other.role != role) {
            told.push(Told { role, name: name.to_owned(), values });
        }
    }
    let time = told.iter().find(|t| t.role == Role::Time).map(|t| t.values.clone());
    Ok(Meant { told, time })
}

impl Meant {
    fn column(&self, role: Role) -> Option<&Told> {
        self.told.iter().find(|told| told.role == role)
    }

    /// The stretch at every sample, and from what it is.
    pub fn stretch(&self, file: &str, specimen: Specimen) -> Result<(Vec<f64>, String), IngestError> {
        let of = |role: Role, change: &dyn Fn(f64) -> f64| {
            self.column(role)
                .map(|told| (told.values.iter().map(|v| change(*v)).collect::<Vec<f64>>(), told.name.clone()))
        };
        if let Some((values, name)) = of(Role::Stretch, &|v| v) {
            return Ok((values, format!("stretch is column `{name}`")));
        }
        if let Some((values, name)) = of(Role::Strain, &|v| 1.0 + v) {
            return Ok((values, format!("stretch is 1 + engineering strain, column `{name}`")));
        }
        if let Some((values, name)) = of(Role::TrueStrain, &f64::exp) {
            return Ok((values, format!("stretch is exp(true strain), column `{name}`")));
        }
        let Some(told) = self.column(Role::Displacement) else {
            return Err(self.missing(file, "a column of stretch, strain or displacement"));
        };
        let Some(length) = specimen.length_m else {
            return Err(IngestError::Malformed {
                place: Place::new(file, None, Some(format!("column `{}`", told.name))),
                expected: "the strip's length at rest, because this is a displacement".to_owned(),
                found: "no length, neither with the command nor in the file's own words".to_owned(),
                next: "add --length \"33 mm\"".to_owned(),
            });
        };
        let values = told.values.iter().map(|u| 1.0 + u / length).collect();
        Ok((values, format!("stretch is 1 + `{}` / {} mm", told.name, 1e3 * length)))
    }

    /// The nominal stress at every sample, in Pa, and from what it is.
    pub fn stress(&self, file: &str, specimen: Specimen, stretch: &[f64]) -> Result<(Vec<f64>, String), IngestError> {
        if let Some(told) = self.column(Role::Stress) {
            return Ok((told.values.clone(), format!("nominal stress is column `{}`", told.name)));
        }
        if let Some(told) = self.column(Role::TrueStress) {
            let values = told.values.iter().zip(stretch).map(|(s, l)| s / l).collect();
            return Ok((values, format!("nominal stress is true stress / stretch, column `{}`", told.name)));
        }
        let Some(told) = self.column(Role::Force) else {
            return Err(self.missing(file, "a column of stress or force"));
        };
        let Some(area) = specimen.area_m2 else {
            return Err(IngestError::Malformed {
                place: Place::new(file, None, Some(format!("column `{}`", told.name))),
                expected: "the strip's section at rest, because this is a force".to_owned(),
                found: "no width and thickness, neither with the command nor in the file's own words".to_owned(),
                next: "add --width \"6 mm\" --thickness \"3 mm\", or --area \"18 mm2\"".to_owned(),
            });
        };
        let values = told.values.iter().map(|f| f / area).collect();
        Ok((values, format!("nominal stress is `{}` / {} mm2", told.name, significant(1e6 * area))))
    }

    fn missing(&self, file: &str, expected: &str) -> IngestError {
        let found: Vec<String> = self.told.iter().map(|told| format!("`{}`", told.name)).collect();
        IngestError::Malformed {
            place: Place::new(file, None, None),
            expected: expected.to_owned(),
            found: if found.is_empty() { "no column whose name says what it is".to_owned() } else { found.join(", ") },
            next: "name the columns from the left: --columns \"stress/MPa, stretch\"".to_owned(),
        }
    }

    /// What true and engineering columns say of one another.
    pub fn contradictions(
        &self,
        file: &str,
        stretch: &[f64],
        stress: &[f64],
        sign: f64,
        lines: &LineMap,
    ) -> Vec<Finding> {
        let mut findings = Vec::new();
        let mut check = |role: Role, of: &dyn Fn(usize) -> f64, rule: &str| {
            let Some(told) = self.column(role) else { return };
            let largest = told.values.iter().map(|v| v.abs()).fold(0.0, f64::max);
            let off = |i: &usize| (told.values[*i] - of(*i)).abs() > 0.01 * told.values[*i].abs() + 0.001 * largest;
            let places: Vec<usize> = (0..told.values.len()).filter(off).collect();
            if let (Some(&first), true) = (places.first(), 20 * places.len() > told.values.len()) {
                let text = format!(
                    "`{}` is not {rule}: off by more than 1 % in {} of {} samples, first on line {} ({} where {} follows); one of the columns is not what it is called",
                    told.name,
                    places.len(),
                    told.values.len(),
                    lines.line_of(first),
                    significant(told.values[first]),
                    significant(of(first)),
                );
                findings.push(finding(FindingKind::StrainMismatch, Severity::Note, file, &places, lines, text));
            }
        };
        if self.column(Role::Strain).is_some() || self.column(Role::Stretch).is_some() {
            check(Role::TrueStrain, &|i| stretch[i].ln(), "ln(1 + engineering strain)");
        }
        if self.column(Role::Stress).is_some() {
            check(
                Role::TrueStress,
                &|i| sign * stress[i] * stretch[i],
                "engineering stress × (1 + engineering strain)",
            );
        }
        let largest = self.column(Role::Strain).map_or(0.0, |t| t.values.iter().copied().fold(0.0, f64::max));
        if largest > 50.0 {
            let text = format!(
                "the largest engineering strain is {}: no elastomer goes so far, so the column may be in per cent",
                significant(largest)
            );
            findings.push(finding(FindingKind::StrainMismatch, Severity::Note, file, &[], lines, text));
        }
        findings
    }
}

/// A finding at samples.
pub(super) fn finding(
    kind: FindingKind,
    severity: Severity,
    file: &str,
    places: &[usize],
    lines: &LineMap,
    text: String,
) -> Finding {
    let mut spans = Vec::new();
    for &i in places {
        let line = lines.line_of(i);
        let span = Span { first_sample: i, last_sample: i, first_line: line, last_line: line };
        crate::finding::extend(&mut spans, span);
    }
    Finding { kind, severity, file: file.to_owned(), channel: None, spans, count: places.len(), text }
}

/// A number as one reads it.
pub(super) fn significant(value: f64) -> String {
    let text = format!("{value:.4e}");
    let (mantissa, exponent) = text.split_once('e').unwrap_or((&text, "0"));
    match exponent.parse::<i32>() {
        // Decimals of a small exponent.
        Ok(e @ -4..=5) => {
            let decimals = usize::try_from(4 - e.min(4)).unwrap_or(0);
            let text = format!("{value:.decimals$}");
            if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
        }
        _ => format!("{mantissa}e{exponent}"),
    }
}

/// The strip, as the user says, or else as the file's own words do: `Specimen Length (mm);33`, `length 33 mm`.
pub fn specimen(metadata: &[String], asked: Specimen) -> Specimen {
    let length = |word: &str| metadata.iter().find_map(|line| length_in(line, word));
    let area = || Some(length("width")? * length("thickness")?);
    Specimen { length_m: asked.length_m.or_else(|| length("length")), area_m2: asked.area_m2.or_else(area) }
}

/// The length behind a word in a line, in m: the number that follows, its unit beside either.
fn length_in(line: &str, word: &str) -> Option<f64> {
    let lower = line.to_lowercase();
    let at = lower.find(word)?;
    let rest = lower.get(at + word.len()..)?;
    let mut unit = None;
    let mut number = None;
    for part in rest.split([' ', ';', ',', '\t', ':', '=', '(', ')', '[', ']']).filter(|part| !part.is_empty()) {
        if let Some(symbol) = Unit::parse(part).filter(|unit| unit.dimension == Dimension::Length) {
            unit = Some(symbol);
        } else if let (None, Ok(value)) = (number, part.parse::<f64>()) {
            number = Some(value);
        } else {
            break;
        }
        if number.is_some() && unit.is_some() {
            break;
        }
    }
    let value = unit?.to_si(number?);
    (value.is_finite() && value > 0.0).then_some(value)
}
