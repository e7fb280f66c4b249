//! Which objects a file holds: groups and channels with their properties and values, checked.

use std::collections::{BTreeMap, BTreeSet};

use super::{Number, UNTITLED, WriteOptions};
use crate::IngestError;
use crate::error::Place;
use crate::formats::tdms::value::{Properties, Timestamp, Value};
use crate::recording::{Cells, Column, Table};

/// The objects of a file.
pub(super) struct Plan<'t> {
    pub(super) root: Properties,
    pub(super) groups: Vec<Group>,
    /// Those of a group one after the other.
    pub(super) channels: Vec<Channel<'t>>,
}

pub(super) struct Group {
    pub(super) path: String,
    pub(super) properties: Properties,
}

pub(super) struct Channel<'t> {
    /// By its place among the groups.
    pub(super) group: usize,
    /// What errors call it.
    pub(super) place: Place,
    pub(super) path: String,
    pub(super) properties: Properties,
    pub(super) values: Values<'t>,
}

/// The values of a channel.
pub(super) enum Values<'t> {
    Double(&'t [f64]),
    Single(&'t [f64]),
    Counts {
        values: &'t [f64],
        slope: f64,
        intercept: f64,
    },
    /// In s since the origin.
    Instants {
        stamps: &'t [f64],
        origin: Timestamp,
    },
    Text(&'t [String]),
}

impl Values<'_> {
    pub(super) fn len(&self) -> usize {
        match self {
            Self::Double(values) | Self::Single(values) | Self::Counts { values, .. } => values.len(),
            Self::Instants { stamps, .. } => stamps.len(),
            Self::Text(text) => text.len(),
        }
    }
}

fn malformed(place: Place, expected: &str, found: impl Into<String>, next: &str) -> IngestError {
    IngestError::Malformed { place, expected: expected.to_owned(), found: found.into(), next: next.to_owned() }
}

const CORRECT: &str = "correct the table that is to be written";

impl<'t> Plan<'t> {
    pub(super) fn new(tables: &'t [Table], options: &WriteOptions) -> Result<Self, IngestError> {
        check_names(tables, options)?;
        let mut plan = Self { root: options.file.clone(), groups: vec![], channels: vec![] };
        check_properties(&Place::new("the file", None, None), &plan.root)?;
        for table in tables {
            plan.add(table, options)?;
        }
        // Tables of one name are one group.
        plan.channels.sort_by_key(|channel| channel.group);
        let mut paths = BTreeSet::new();
        for channel in &plan.channels {
            if !paths.insert(&channel.path) {
                let found = format!("two of the path {}", channel.path);
                return Err(malformed(channel.place.clone(), "channels of different names", found, CORRECT));
            }
        }
        plan.check_layout(options)?;
        Ok(plan)
    }

    fn add(&mut self, table: &'t Table, options: &WriteOptions) -> Result<(), IngestError> {
        let name = if table.name.is_empty() { UNTITLED } else { &table.name };
        let path = format!("/{}", quoted(name));
        let group = self.groups.iter().position(|group| group.path == path).unwrap_or_else(|| {
            self.groups.push(Group { path: path.clone(), properties: Properties::new() });
            self.groups.len() - 1
        });
        if let Some(properties) = options.groups.get(&table.name) {
            check_properties(&Place::new(name, None, None), properties)?;
            self.groups[group].properties.extend(properties.clone());
        }
        let clock = table.clock.filter(|clock| is_clock(table, *clock));
        let stamps = clock.and_then(|clock| table.columns[clock].cells.numbers());
        // What the options say of a clock needs a channel.
        let is_named = |clock: usize| {
            let key = (table.name.clone(), table.columns[clock].name.clone());
            options.numbers.contains_key(&key) || options.channels.contains_key(&key)
        };
        let stamps = stamps.filter(|_| table.columns.len() > 1 && !clock.is_some_and(is_named));
        let waveform = stamps.and_then(even);
        for (number, column) in table.columns.iter().enumerate() {
            let place = Place::new(name, None, Some(column.name.clone()));
            if column.cells.len() != table.rows || matches!(column.cells, Cells::NotKept) {
                let found = match column.cells {
                    Cells::NotKept => "cells that were not kept".to_owned(),
                    _ => format!("{} of them", column.cells.len()),
                };
                return Err(malformed(place, &format!("{} cells", table.rows), found, CORRECT));
            }
            let is_clock = clock == Some(number);
            if is_clock && waveform.is_some() {
                continue;
            }
            let key = (table.name.clone(), column.name.clone());
            let kind = options.numbers.get(&key).copied();
            let origin = options.origin.filter(|_| is_clock && kind.is_none());
            let (values, mut properties) = values_of(column, kind, origin, &place)?;
            if let Some(waveform) = waveform {
                properties.extend(waveform.properties(table.rows, options.origin));
            }
            let is_instant = matches!(values, Values::Instants { .. });
            if let Some(unit) = column.unit.as_ref().filter(|_| !is_instant) {
                properties.insert("unit_string".to_owned(), Value::Text(unit.clone()));
            }
            for (name, value) in options.channels.get(&key).into_iter().flatten() {
                if properties.insert(name.clone(), value.clone()).is_some() {
                    let expected = "properties that the writer does not state itself";
                    return Err(malformed(place, expected, format!("`{name}`"), "leave it out"));
                }
            }
            check_properties(&place, &properties)?;
            let path = format!("{path}/{}", quoted(&column.name));
            self.channels.push(Channel { group, place, path, properties, values });
        }
        Ok(())
    }

    fn check_layout(&self, options: &WriteOptions) -> Result<(), IngestError> {
        let chunks = options.segment_chunks.map_or(1, usize::from);
        for channel in &self.channels {
            let place = || channel.place.clone();
            let is_text = matches!(channel.values, Values::Text(_));
            if is_text && options.interleaved {
                return Err(malformed(place(), "numbers, which can be interleaved", "text", "do not interleave it"));
            }
            if is_text && chunks > 1 {
                // All chunks of a segment have one size, which is stated once.
                return Err(malformed(
                    place(),
                    "numbers in segments of several chunks",
                    "text",
                    "use one chunk a segment",
                ));
            }
        }
        for pair in self.channels.windows(2).filter(|_| options.interleaved) {
            let [one, other] = pair else { continue };
            let (rows, others) = (one.values.len(), other.values.len());
            if one.group == other.group && rows != others {
                let expected = format!("{rows} rows, as those before it in this group, to be interleaved");
                let next = "give the tables different names, or do not interleave them";
                return Err(malformed(other.place.clone(), &expected, format!("{others}"), next));
            }
        }
        Ok(())
    }
}

/// Options that name nothing would be lost.
fn check_names(tables: &[Table], options: &WriteOptions) -> Result<(), IngestError> {
    let tables: BTreeMap<&str, Vec<&Column>> = tables.iter().fold(BTreeMap::new(), |mut all, table| {
        all.entry(&table.name).or_insert_with(Vec::new).extend(&table.columns);
        all
    });
    let unknown = |table: &str, column: Option<&str>| {
        let place = Place::new(table, None, column.map(str::to_owned));
        malformed(place, "a name among those that are to be written", "no such", "correct the options")
    };
    for name in options.groups.keys() {
        if !tables.contains_key(name.as_str()) {
            return Err(unknown(name, None));
        }
    }
    for (name, column) in options.channels.keys().chain(options.numbers.keys()) {
        let columns = tables.get(name.as_str());
        if !columns.is_some_and(|columns| columns.iter().any(|one| one.name == *column)) {
            return Err(unknown(name, Some(column)));
        }
    }
    Ok(())
}

fn check_properties(place: &Place, properties: &Properties) -> Result<(), IngestError> {
    for (name, value) in properties {
        let is_of_wave = name.starts_with("wf_") && value.number().is_some_and(|number| !number.is_finite());
        if is_of_wave || matches!(value, Value::Void) {
            let found = if is_of_wave { value.to_string() } else { "none".to_owned() };
            let expected = format!("a value of `{name}`");
            return Err(malformed(place.clone(), &expected, found, "correct the options"));
        }
    }
    Ok(())
}

/// Whether a column of a table is numbers in s.
fn is_clock(table: &Table, clock: usize) -> bool {
    let column = table.columns.get(clock);
    column.is_some_and(|column| column.unit.as_deref() == Some("s") && column.cells.numbers().is_some())
}

/// A name as it stands in a path.
fn quoted(name: &str) -> String {
    format!("'{}'", name.replace('\'', "''"))
}

fn values_of<'t>(
    column: &'t Column,
    kind: Option<Number>,
    origin: Option<Timestamp>,
    place: &Place,
) -> Result<(Values<'t>, Properties), IngestError> {
    let numbers = match &column.cells {
        Cells::Numbers(numbers) => numbers,
        Cells::Text(_) if kind.is_some() => {
            return Err(malformed(place.clone(), "numbers, which have a type", "text", "correct the options"));
        }
        Cells::Text(text) => return Ok((Values::Text(text), Properties::new())),
        Cells::NotKept => return Err(malformed(place.clone(), "cells", "cells that were not kept", CORRECT)),
    };
    let refuse = |expected: &str, row: usize| {
        let found = numbers.get(row).map_or(String::new(), |number| format!("{number:?} in row {row}"));
        malformed(place.clone(), expected, found, "store it as doubles")
    };
    if let Some(origin) = origin {
        return match numbers.iter().position(|stamp| origin_plus(origin, *stamp).is_none()) {
            Some(row) => Err(refuse("an instant in every row of a clock with an origin", row)),
            None => Ok((Values::Instants { stamps: numbers, origin }, Properties::new())),
        };
    }
    match kind.unwrap_or_default() {
        Number::Double => Ok((Values::Double(numbers), Properties::new())),
        Number::Single => match numbers.iter().position(|number| single(*number).is_none()) {
            Some(row) => Err(refuse("numbers that a single can hold", row)),
            None => Ok((Values::Single(numbers), Properties::new())),
        },
        Number::Counts { slope, intercept } => {
            if !slope.is_normal() || !intercept.is_finite() {
                let found = format!("{slope:?} and {intercept:?}");
                return Err(malformed(
                    place.clone(),
                    "a slope that is not 0 and an intercept",
                    found,
                    "correct the options",
                ));
            }
            if let Some(row) = numbers.iter().position(|number| count(*number, slope, intercept).is_none()) {
                return Err(refuse("numbers that are counts from -32768 to 32767", row));
            }
            let text = |text: &str| Value::Text(text.to_owned());
            let properties = [
                ("NI_Scaling_Status", text("unscaled")),
                ("NI_Number_Of_Scales", Value::Uint(1)),
                ("NI_Scale[0]_Scale_Type", text("Linear")),
                ("NI_Scale[0]_Linear_Slope", Value::Double(slope)),
                ("NI_Scale[0]_Linear_Y_Intercept", Value::Double(intercept)),
                ("NI_Scale[0]_Linear_Input_Source", Value::Uint(0xFFFF_FFFF)),
            ];
            let properties = properties.map(|(name, value)| (name.to_owned(), value)).into();
            Ok((Values::Counts { values: numbers, slope, intercept }, properties))
        }
    }
}

/// The nearest single of a number that does not become infinite by it.
// Rounding is what is asked for.
#[allow(clippy::cast_possible_truncation)]
pub(super) fn single(number: f64) -> Option<f32> {
    let single = number as f32;
    (single.is_finite() || !number.is_finite()).then_some(single)
}

/// The nearest count.
// What is cast is whole and within the range.
#[allow(clippy::cast_possible_truncation)]
pub(super) fn count(number: f64, slope: f64, intercept: f64) -> Option<i16> {
    let count = ((number - intercept) / slope).round();
    (f64::from(i16::MIN)..=f64::from(i16::MAX)).contains(&count).then_some(count as i16)
}

/// An instant so many seconds after another, to the nearest 2^-64 s.
// What is cast is whole, or the part of a second in units of which there are 2^64.
#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
pub(super) fn origin_plus(origin: Timestamp, seconds: f64) -> Option<Timestamp> {
    const FRACTIONS: f64 = 65_536.0 * 65_536.0 * 65_536.0 * 65_536.0;
    // Towards 0, so that the part that is left has all its digits.
    let whole = seconds.trunc();
    // Beyond it neither the sum nor the file has room.
    if seconds.is_nan() || whole.abs() >= (1_u64 << 62) as f64 {
        return None;
    }
    let part = ((seconds - whole) * FRACTIONS).round() as i128;
    let origin = (i128::from(origin.seconds) << 64) + i128::from(origin.fraction);
    let sum = origin.checked_add((i128::from(whole as i64) << 64) + part)?;
    let fraction = (sum & i128::from(u64::MAX)) as u64;
    i64::try_from(sum >> 64).ok().map(|seconds| Timestamp { seconds, fraction })
}

/// A clock as the first stamp and what each next one adds.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Waveform {
    offset_s: f64,
    increment_s: f64,
}

impl Waveform {
    fn properties(self, rows: usize, origin: Option<Timestamp>) -> Properties {
        let rows = i64::try_from(rows).unwrap_or(i64::MAX);
        let properties = [
            ("wf_start_offset", Value::Double(self.offset_s)),
            ("wf_increment", Value::Double(self.increment_s)),
            ("wf_samples", Value::Int(rows)),
            ("wf_xname", Value::Text("Time".to_owned())),
            ("wf_xunit_string", Value::Text("s".to_owned())),
        ];
        let start = origin.map(|origin| ("wf_start_time", Value::Time(origin)));
        properties.into_iter().chain(start).map(|(name, value)| (name.to_owned(), value)).collect()
    }
}

/// The waveform of stamps that are even: `offset + i * increment` gives each within two roundings of the largest.
///
/// An increment of up to 12 digits that does it was probably asked of the instrument; else it is the mean.
fn even(stamps: &[f64]) -> Option<Waveform> {
    let [first, .., last] = stamps else { return None };
    let within = 2.0 * f64::EPSILON * first.abs().max(last.abs());
    let mean = (last - first) / (stamps.len() - 1) as f64;
    let rounded = (0..12).filter_map(|digits| format!("{mean:.digits$e}").parse::<f64>().ok()).chain([mean]);
    let is_even = |increment: &f64| {
        let stamp = |i: usize| first + i as f64 * increment;
        stamps.iter().enumerate().all(|(i, s)| (s - stamp(i)).abs() <= within)
    };
    let increment_s = rounded.filter(|increment| *increment > 0.0 && increment.is_finite()).find(is_even)?;
    Some(Waveform { offset_s: *first, increment_s })
}

#[cfg(test)]
mod tests {
    // Equality of floats is asked where it must be exact.
    #![allow(clippy::float_cmp)]

    use super::*;

    #[test]
    fn a_clock_is_even_within_its_rounding_only() {
        let clock = |count: usize, stamp: fn(f64) -> f64| (0..count).map(|i| stamp(i as f64)).collect::<Vec<_>>();
        let increment = |stamps: &[f64]| even(stamps).map(|waveform| waveform.increment_s);
        assert_eq!(increment(&clock(100_000, |i| i * 0.001)), Some(0.001));
        assert_eq!(increment(&clock(100_000, |i| i / 1000.0)), Some(0.001));
        assert_eq!(increment(&clock(100_000, |i| 1_790_000_000.25 + i / 1000.0)), Some(0.001));
        assert_eq!(increment(&clock(30_001, |i| i / 30_000.0)), Some(1.0 / 30_000.0));
        assert_eq!(increment(&clock(2, |i| 5.0 - i)), None);
        assert_eq!((increment(&[]), increment(&[1.0]), increment(&[1.0, 1.0])), (None, None, None));
        // A nanosecond of jitter in one stamp of six minutes, and a hole.
        let mut stamps = clock(360_000, |i| i / 1000.0);
        stamps[180_000] += 1e-9;
        assert_eq!(increment(&stamps), None);
        stamps[180_000] = f64::NAN;
        assert_eq!(increment(&stamps), None);
        assert_eq!(increment(&[f64::NAN, 1.0, f64::NAN]), None);
        assert_eq!(increment(&[f64::MIN, 0.0, f64::MAX]), None);
    }

    #[test]
    fn instants_are_exact_to_their_last_bit() {
        let origin = Timestamp { seconds: 3_873_000_000, fraction: 3 << 62 };
        for stamp in [0.0, 0.1, 0.25, 1e-9, 12_345.678_9, -0.1, -7.0] {
            let instant = origin_plus(origin, stamp).unwrap();
            let whole = Timestamp { seconds: origin.seconds, fraction: 0 };
            // `since` rounds once; the stamps lie above the last digit of the sum.
            assert_eq!(instant.since(whole.seconds), 0.75 + stamp, "{stamp}");
        }
        // The smallest step back carries into the seconds.
        let zero = Timestamp { seconds: 0, fraction: 0 };
        assert_eq!(origin_plus(zero, -(2.0_f64.powi(-64))), Some(Timestamp { seconds: -1, fraction: u64::MAX }));
        assert_eq!(origin_plus(zero, -1e-300), Some(zero));
        for none in [f64::NAN, f64::INFINITY, 1e300, -1e19] {
            assert_eq!(origin_plus(zero, none), None);
        }
        assert_eq!(origin_plus(Timestamp { seconds: i64::MAX, fraction: 0 }, 1.0), None);
    }
}
