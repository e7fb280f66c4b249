//! What can be read off a figure: points in words.

use pneuval_ingest::units::Unit;

use crate::format;
use crate::report::chart::Reading;
use crate::report::view::{place, values};
use crate::results::{Comparison, Point};
use crate::verdict::Basis;

/// Places of a figure that can be read, at most: a reader's keyboard stops at each of them.
const PLACES_MAX: usize = 40;

/// Lines of one place.
const LINES_MAX: usize = 12;

/// Letters of the name of a form.
const NAME_MAX: usize = 30;

/// Places nearer to each other than this share of the axis are read together.
const TOGETHER: f64 = 0.004;

/// A place with what it says, and how much it matters where not all can be kept.
pub(super) struct Said {
    pub at: (f64, f64),
    pub lines: Vec<String>,
    pub weight: f64,
}

/// Where a point stands: pressure, conditions, the way of the pressure.
pub(super) fn heading(c: &Comparison, p: &Point) -> String {
    let conditions = c.conditions.iter().zip(&p.conditions_si).map(|(condition, v)| condition.text(*v));
    let mut parts: Vec<String> = std::iter::once(place(c, p)).chain(conditions).collect();
    if c.points.iter().any(|other| other.branch != p.branch) {
        parts.extend(p.branch.map(|branch| branch.name().to_owned()));
    }
    parts.join(", ")
}

/// The measured value with its interval, and of how many repeats it is the mean.
pub(super) fn measured(c: &Comparison, p: &Point, unit: Unit) -> String {
    let Some(value) = &p.measured else { return "not measured".to_owned() };
    let widths = p.measured_half_width.as_deref().unwrap_or_default();
    let repeats = if p.repeats > 1 { format!(", {} repeats", p.repeats) } else { String::new() };
    format!("measured {}{repeats}", values(value, widths, c.basis == Basis::PublishedPoint, unit))
}

/// A form's value.
pub(super) fn predicted(c: &Comparison, p: &Point, unit: Unit) -> String {
    let value = p
        .predicted
        .as_deref()
        .map_or("no prediction".to_owned(), |v| values(v, &p.predicted_half_width, c.kind == "published", unit));
    format!("{}: {value}", shortened(&c.title))
}

/// A form's residual with its interval.
pub(super) fn residual(c: &Comparison, p: &Point, unit: Unit) -> Option<String> {
    let decimals = format::error_decimals(unit);
    let number = |si: f64| {
        let text = format::fixed(unit.from_si(si), decimals);
        if si > 0.0 && !c.quantity.is_position() { format!("+{text}") } else { text }
    };
    let ends = p.residual_lower.zip(p.residual_upper).filter(|(low, high)| low < high);
    let ends = ends.map_or(String::new(), |(low, high)| format!(" ({} to {})", number(low), number(high)));
    Some(format!("{}: {}{ends}", shortened(&c.title), format::with_unit(&number(p.residual?), unit)))
}

fn shortened(name: &str) -> String {
    if name.chars().count() <= NAME_MAX {
        return name.to_owned();
    }
    name.chars().take(NAME_MAX - 1).chain(['…']).collect()
}

/// Places that are read at their x, `size` being the length of that axis; of more than can be kept those of the greatest weight.
pub(super) fn columns(mut said: Vec<Said>, size: f64) -> Vec<Reading> {
    said.retain(|s| s.at.0.is_finite() && s.at.1.is_finite());
    said.sort_by(|a, b| a.at.0.total_cmp(&b.at.0));
    let mut readings: Vec<Reading> = Vec::new();
    for one in kept(said, size) {
        match readings.last_mut().filter(|last| (last.at.0 - one.at.0).abs() <= TOGETHER * size) {
            Some(last) => last.lines.extend(one.lines),
            None => readings.push(Reading { at: one.at, is_column: true, lines: one.lines }),
        }
    }
    readings.iter_mut().for_each(cut);
    readings
}

/// Places that are read one by one, in their order.
pub(super) fn places(said: Vec<Said>) -> Vec<Reading> {
    let finite = said.into_iter().filter(|s| s.at.0.is_finite() && s.at.1.is_finite()).collect();
    let of = |s: Said| {
        let mut reading = Reading { at: s.at, is_column: false, lines: s.lines };
        cut(&mut reading);
        reading
    };
    by_turns(finite).into_iter().map(of).collect()
}

/// Of so many neighbours the one of the greatest weight.
fn by_turns(said: Vec<Said>) -> Vec<Said> {
    let share = said.len().div_ceil(PLACES_MAX).max(1);
    let mut kept: Vec<Said> = Vec::new();
    for (i, one) in said.into_iter().enumerate() {
        match kept.last_mut() {
            Some(last) if i % share != 0 => {
                if one.weight > last.weight {
                    *last = one;
                }
            }
            _ => kept.push(one),
        }
    }
    kept
}

/// Along an axis: those of the greatest weight in equal parts of it, if there are too many.
fn kept(said: Vec<Said>, size: f64) -> Vec<Said> {
    let mut distinct = 0;
    let mut first = f64::NEG_INFINITY;
    for one in &said {
        if one.at.0 - first > TOGETHER * size {
            distinct += 1;
            first = one.at.0;
        }
    }
    if distinct <= PLACES_MAX {
        return said;
    }
    let mut kept: Vec<Said> = Vec::new();
    let part = |one: &Said| (one.at.0 / size * PLACES_MAX as f64).floor();
    for one in said {
        match kept.last_mut().filter(|last| part(last).total_cmp(&part(&one)).is_eq()) {
            Some(last) if one.weight > last.weight => *last = one,
            Some(_) => {}
            None => kept.push(one),
        }
    }
    kept
}

fn cut(reading: &mut Reading) {
    let more = reading.lines.len().saturating_sub(LINES_MAX);
    if more > 0 {
        reading.lines.truncate(LINES_MAX - 1);
        reading.lines.push(format!("and {} more lines", more + 1));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn of_many_places_the_worst_of_each_part_of_the_axis_can_be_read() {
        let said = |i: u32| Said {
            at: (f64::from(i), 0.0),
            lines: vec![i.to_string()],
            weight: if i == 777 { 5.0 } else { f64::from(i % 10) },
        };
        let readings = columns((0..1000).map(said).collect(), 1000.0);
        assert_eq!(readings.len(), PLACES_MAX);
        assert!(readings.iter().filter(|r| r.lines != ["777"]).all(|r| r.lines[0].ends_with('9')));
        assert_eq!(places((0..1000).map(said).collect()).len(), PLACES_MAX);
    }

    #[test]
    fn places_above_one_another_are_read_together() {
        let said = |x: f64, text: &str| Said { at: (x, 0.0), lines: vec![text.to_owned()], weight: 0.0 };
        let readings = columns(vec![said(2.0, "c"), said(1.0, "a"), said(1.0001, "b")], 10.0);
        let lines: Vec<&[String]> = readings.iter().map(|r| r.lines.as_slice()).collect();
        assert_eq!(lines, [vec!["a", "b"], vec!["c"]]);
    }
}
