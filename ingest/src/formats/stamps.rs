//! Stamps written as dates and times of day: text columns that become seconds.
//!
//! What a stamp leaves open stays open: no time zone is guessed, and where day and month may be either way round the date is not used.
//! Days are counted in the Gregorian calendar by Hinnant's `days_from_civil` (<https://howardhinnant.github.io/date_algorithms.html>).

use std::fmt::Write as _;

use crate::error::shown;
use crate::finding::places::{Places, cell_finding};
use crate::finding::{Finding, FindingKind, LineMap, Severity};
use crate::recording::{Cells, Column, Recording, Table, full_name};
use crate::watch::ClockWatch;

const NANOS_PER_SECOND: i64 = 1_000_000_000;
const SECONDS_PER_DAY: i64 = 86_400;
const NANOS_PER_DAY: i64 = SECONDS_PER_DAY * NANOS_PER_SECOND;

/// A stamp as one cell holds it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Stamp {
    date: Date,
    /// Since midnight; absent where only a date is written.
    time_ns: Option<i64>,
    /// Minutes by which the clock is ahead of UTC, where said.
    offset_min: Option<i64>,
}

/// The date of a stamp, in days since 1970.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Date {
    None,
    Days(i64),
    /// Day and month may be either way round; `None` for what is no date.
    Either {
        day_first: Option<i64>,
        month_first: Option<i64>,
    },
}

/// A column of stamps as numbers.
#[derive(Debug, Clone, PartialEq)]
pub struct Stamps {
    /// Seconds since the origin; NaN where a cell is empty or no stamp.
    pub seconds: Vec<f64>,
    /// The origin in RFC 3339, to the second: without an offset where the stamps state none. `None` for times of day and where the
    /// date is open; then seconds count from the midnight before the first stamp.
    pub origin: Option<String>,
    /// The samples at which a time of day begins anew; a day is added from each of them on.
    pub wraps: Vec<usize>,
    /// Whether day and month may be either way round, and the date is for this reason not used.
    pub is_date_open: bool,
    /// The cells that hold something else.
    pub odd: Vec<usize>,
    /// What kind of stamps they are.
    pub reason: String,
}

/// Reads a column of stamps; `None` if it is none: if fewer than half of the cells with something in them are stamps, if kinds of
/// stamps are mixed, or if day and month may be either way round and the date changes.
///
/// ```
/// use pneuval_ingest::formats::stamps::parse;
/// let cells = ["22.11.2026 09:13:00,500", "22.11.2026 09:13:01,000"].map(str::to_owned);
/// let stamps = parse(&cells).unwrap();
/// assert_eq!((stamps.seconds, stamps.origin.as_deref()), (vec![0.5, 1.0], Some("2026-11-22T09:13:00")));
/// ```
pub fn parse(cells: &[String]) -> Option<Stamps> {
    of_stamps(&cells.iter().map(|cell| (one(cell), cell.trim().is_empty())).collect::<Vec<_>>(), None)
}

/// Whether a text is a stamp, a bare number excepted.
pub(crate) fn is_stamp(text: &[u8]) -> bool {
    let is_marked = text.iter().any(|b| matches!(b, b':' | b'-' | b'/'));
    is_marked && std::str::from_utf8(text).ok().and_then(one).is_some()
}

/// A time of day or a stamp of an unambiguous date, as seconds since midnight or since 1970 in the clock's own zone.
pub(crate) fn seconds_of(text: &str) -> Option<(f64, bool)> {
    let stamp = one(text)?;
    let time = stamp.time_ns?;
    match stamp.date {
        Date::None => Some((seconds(time.into()), false)),
        Date::Days(days) => {
            let offset = stamp.offset_min.unwrap_or(0) * 60 * NANOS_PER_SECOND;
            Some((seconds(i128::from(days) * i128::from(NANOS_PER_DAY) + i128::from(time - offset)), true))
        }
        Date::Either { .. } => None,
    }
}

fn seconds(nanos: i128) -> f64 {
    // Whole seconds and the rest, each exact: one rounding only.
    let second = i128::from(NANOS_PER_SECOND);
    if nanos.abs() < 1 << 53 { nanos as f64 / 1e9 } else { (nanos / second) as f64 + (nanos % second) as f64 / 1e9 }
}

/// Stamps to seconds; `origin_ns` is that of other columns of the same file.
fn of_stamps(cells: &[(Option<Stamp>, bool)], origin_ns: Option<i128>) -> Option<Stamps> {
    let filled = cells.iter().filter(|(_, is_empty)| !is_empty).count();
    let stamps: Vec<Stamp> = cells.iter().filter_map(|(stamp, _)| *stamp).collect();
    let first = *stamps.first()?;
    if stamps.len() * 2 <= filled {
        return None;
    }
    let kind = |stamp: &Stamp| (stamp.date == Date::None, stamp.time_ns.is_some(), stamp.offset_min.is_some());
    if stamps.iter().any(|stamp| kind(stamp) != kind(&first)) {
        return None;
    }
    let either: Vec<(Option<i64>, Option<i64>)> = stamps
        .iter()
        .filter_map(|stamp| match stamp.date {
            Date::Either { day_first, month_first } => Some((day_first, month_first)),
            _ => None,
        })
        .collect();
    let only_day_first = either.iter().any(|(_, month_first)| month_first.is_none());
    let only_month_first = either.iter().any(|(day_first, _)| day_first.is_none());
    if only_day_first && only_month_first {
        return None;
    }
    let is_open = !either.is_empty() && !only_day_first && !only_month_first;
    let same_date = either.iter().all(|date| Some(date) == either.first());
    // `03/03/2026` is one day whichever way round.
    let is_date_open = is_open && either.iter().any(|(a, b)| a != b);
    if is_date_open && (!same_date || first.time_ns.is_none()) {
        return None;
    }
    let days = |stamp: &Stamp| match stamp.date {
        Date::Days(days) => Some(days),
        Date::Either { .. } if is_date_open => None,
        Date::Either { day_first, month_first } => {
            if only_month_first {
                month_first
            } else {
                day_first
            }
        }
        Date::None => None,
    };
    let nanos = |stamp: &Stamp| {
        let offset = i128::from(stamp.offset_min.unwrap_or(0)) * 60 * i128::from(NANOS_PER_SECOND);
        i128::from(days(stamp).unwrap_or(0)) * i128::from(NANOS_PER_DAY) + i128::from(stamp.time_ns.unwrap_or(0))
            - if days(stamp).is_some() { offset } else { 0 }
    };
    let is_absolute = days(&first).is_some();
    let second = i128::from(NANOS_PER_SECOND);
    let origin_ns = if is_absolute { origin_ns.unwrap_or(nanos(&first).div_euclid(second) * second) } else { 0 };
    let (mut wraps, mut odd, mut out) = (Vec::new(), Vec::new(), Vec::with_capacity(cells.len()));
    let (mut before, mut added): (Option<i128>, i128) = (None, 0);
    for (row, (stamp, is_empty)) in cells.iter().enumerate() {
        let Some(stamp) = stamp else {
            if !is_empty {
                odd.push(row);
            }
            out.push(f64::NAN);
            continue;
        };
        let mut at = nanos(stamp) - origin_ns;
        if !is_absolute {
            // Half a day back is no clock that was set: it is midnight.
            let half_day = i128::from(NANOS_PER_DAY) / 2;
            if before.is_some_and(|before| before - (at + added) > half_day) {
                added += i128::from(NANOS_PER_DAY);
                wraps.push(row);
            }
            at += added;
            before = Some(at);
        }
        out.push(seconds(at));
    }
    let zone = match first.offset_min {
        Some(0) => "in UTC".to_owned(),
        Some(_) => "with the offset from UTC that each states".to_owned(),
        None => "of a clock whose zone is not stated".to_owned(),
    };
    let order = match (either.is_empty(), is_date_open, only_month_first) {
        (true, ..) | (_, true, _) => "",
        (_, _, true) => ", the month first",
        (_, _, false) => ", the day first",
    };
    let what = if is_date_open {
        "stamps whose date may be read two ways: seconds count from midnight".to_owned()
    } else if is_absolute {
        format!("dates{order}, {zone}: seconds count from {}", rfc3339(origin_ns, first.offset_min))
    } else {
        "times of day: seconds count from midnight".to_owned()
    };
    let origin = is_absolute.then(|| rfc3339(origin_ns, first.offset_min));
    Some(Stamps { seconds: out, origin, wraps, is_date_open, odd, reason: what })
}

/// A second since 1970 in RFC 3339, as UTC or as a clock whose zone is not stated.
pub(crate) fn utc_second(seconds: f64, is_utc: bool) -> String {
    // Dates end long before the numbers do.
    #[expect(clippy::cast_possible_truncation)]
    let seconds = seconds as i64;
    rfc3339(i128::from(seconds) * i128::from(NANOS_PER_SECOND), is_utc.then_some(0))
}

/// An instant in RFC 3339, in UTC where the offset is known, else without any.
fn rfc3339(nanos: i128, offset_min: Option<i64>) -> String {
    let seconds = nanos.div_euclid(i128::from(NANOS_PER_SECOND));
    let day = i128::from(SECONDS_PER_DAY);
    let (days, rest) = (seconds.div_euclid(day), seconds.rem_euclid(day));
    let (year, month, date) = civil_from_days(i64::try_from(days).unwrap_or(0));
    let mut out = format!("{year:04}-{month:02}-{date:02}T{:02}:{:02}:{:02}", rest / 3600, rest / 60 % 60, rest % 60);
    if offset_min.is_some() {
        out.push('Z');
    }
    out
}

/// Days since 1970-01-01 of a date; `None` for what is no date.
fn days_from_civil(year: i64, month: i64, day: i64) -> Option<i64> {
    const DAYS: [i64; 12] = [31, 28, 31, 30, 31, 30, 31, 31, 30, 31, 30, 31];
    let leap = year % 4 == 0 && (year % 100 != 0 || year % 400 == 0);
    let length = DAYS.get(usize::try_from(month.checked_sub(1)?).ok()?)? + i64::from(leap && month == 2);
    // Instruments whose clock was never set begin in 1970 or 1904; nothing is logged before or long after.
    if !(1900..2200).contains(&year) || !(1..=length).contains(&day) {
        return None;
    }
    let shifted = if month <= 2 { year - 1 } else { year };
    let era = shifted.div_euclid(400);
    let year_of_era = shifted.rem_euclid(400);
    let day_of_year = (153 * ((month + 9) % 12) + 2) / 5 + day - 1;
    Some(era * 146_097 + year_of_era * 365 + year_of_era / 4 - year_of_era / 100 + day_of_year - 719_468)
}

fn civil_from_days(days: i64) -> (i64, i64, i64) {
    let days = days + 719_468;
    let era = days.div_euclid(146_097);
    let day_of_era = days.rem_euclid(146_097);
    let year_of_era = (day_of_era - day_of_era / 1460 + day_of_era / 36_524 - day_of_era / 146_096) / 365;
    let day_of_year = day_of_era - (365 * year_of_era + year_of_era / 4 - year_of_era / 100);
    let shifted = (5 * day_of_year + 2) / 153;
    let month = if shifted < 10 { shifted + 3 } else { shifted - 9 };
    (year_of_era + era * 400 + i64::from(month <= 2), month, day_of_year - (153 * shifted + 2) / 5 + 1)
}

/// Reads a stamp.
fn one(text: &str) -> Option<Stamp> {
    let text = text.trim();
    // Longer than any stamp; most words end here.
    if text.is_empty() || text.len() > 48 || !text.bytes().any(|b| b.is_ascii_digit()) {
        return None;
    }
    if let Some(epoch) = epoch(text) {
        return Some(epoch);
    }
    let date = date(text);
    let (date, rest) = date.map_or((Date::None, text), |(date, rest)| (date, rest));
    if rest.is_empty() {
        return (date != Date::None).then_some(Stamp { date, time_ns: None, offset_min: None });
    }
    let rest = if date == Date::None {
        rest
    } else {
        let behind = rest.trim_start_matches([' ', ',']);
        behind.strip_prefix(['T', 't', '_']).unwrap_or(behind)
    };
    if date != Date::None && rest.is_empty() {
        return Some(Stamp { date, time_ns: None, offset_min: None });
    }
    let (time_ns, rest) = time(rest)?;
    let offset_min = offset(rest)?;
    if date == Date::None && offset_min.is_some() {
        return None;
    }
    Some(Stamp { date, time_ns: Some(time_ns), offset_min })
}

/// Digits at the beginning, at most so many, and what follows.
fn digits(text: &str, most: usize) -> Option<(i64, usize, &str)> {
    let count = text.bytes().take_while(u8::is_ascii_digit).count();
    if count == 0 || count > most {
        return None;
    }
    let (number, rest) = text.split_at_checked(count)?;
    Some((number.parse().ok()?, count, rest))
}

/// A date at the beginning and what follows.
fn date(text: &str) -> Option<(Date, &str)> {
    let (first, length, rest) = digits(text, 4)?;
    let mark = rest.chars().next().filter(|c| matches!(c, '-' | '/' | '.'))?;
    let rest = rest.strip_prefix(mark)?;
    if length == 4 {
        let (month, _, rest) = digits(rest, 2)?;
        let (day, _, rest) = digits(rest.strip_prefix(mark)?, 2)?;
        return Some((Date::Days(days_from_civil(first, month, day)?), rest));
    }
    if length > 2 {
        return None;
    }
    if let Some((month, rest)) = month_name(rest) {
        let (year, 4, rest) = digits(rest.strip_prefix(mark)?, 4)? else { return None };
        return Some((Date::Days(days_from_civil(year, month, first)?), rest));
    }
    let (second, _, rest) = digits(rest, 2)?;
    let (year, 4, rest) = digits(rest.strip_prefix(mark)?, 4)? else { return None };
    let day_first = days_from_civil(year, second, first);
    let month_first = days_from_civil(year, first, second);
    let date = match (mark, day_first, month_first) {
        // Nobody who parts a date by points writes the month first.
        ('.', Some(days), _) => Date::Days(days),
        ('.', None, _) | (_, None, None) => return None,
        _ => Date::Either { day_first, month_first },
    };
    Some((date, rest))
}

fn month_name(text: &str) -> Option<(i64, &str)> {
    const NAMES: [&str; 12] = ["jan", "feb", "mar", "apr", "may", "jun", "jul", "aug", "sep", "oct", "nov", "dec"];
    let (name, rest) = text.split_at_checked(3)?;
    let index = NAMES.iter().position(|known| known.eq_ignore_ascii_case(name))?;
    Some((i64::try_from(index).ok()? + 1, rest))
}

/// A time of day in ns at the beginning, AM and PM included, and what follows.
fn time(text: &str) -> Option<(i64, &str)> {
    let (mut hour, _, rest) = digits(text, 2)?;
    let (minute, 2, rest) = digits(rest.strip_prefix(':')?, 2)? else { return None };
    let (mut nanos, mut rest) = (0, rest);
    let mut second = 0;
    if let Some(behind) = rest.strip_prefix(':') {
        let (whole, 2, behind) = digits(behind, 2)? else { return None };
        second = whole;
        rest = behind;
        if let Some(fraction) = rest.strip_prefix(['.', ',']) {
            let count = fraction.bytes().take_while(u8::is_ascii_digit).count();
            let (fraction, behind) = fraction.split_at_checked(count)?;
            let kept = fraction.get(..count.min(9))?;
            if count == 0 || count > 12 {
                return None;
            }
            let scale = 10_i64.pow(u32::try_from(9 - kept.len()).ok()?);
            nanos = kept.parse::<i64>().ok()? * scale;
            rest = behind;
        }
    }
    let behind = rest.trim_start();
    let half = behind.get(..2).filter(|half| half.eq_ignore_ascii_case("am") || half.eq_ignore_ascii_case("pm"));
    if let Some(half) = half {
        if !(1..=12).contains(&hour) {
            return None;
        }
        hour = hour % 12 + if half.eq_ignore_ascii_case("pm") { 12 } else { 0 };
        rest = behind.get(2..)?;
    }
    if hour > 23 || minute > 59 || second > 59 {
        return None;
    }
    Some((((hour * 60 + minute) * 60 + second) * NANOS_PER_SECOND + nanos, rest))
}

/// An offset from UTC in minutes, which may be absent.
#[expect(clippy::option_option)]
fn offset(text: &str) -> Option<Option<i64>> {
    let text = text.trim();
    if text.is_empty() {
        return Some(None);
    }
    if matches!(text, "Z" | "z" | "UTC" | "GMT") {
        return Some(Some(0));
    }
    let (sign, rest) = match text.split_at_checked(1)? {
        ("+", rest) => (1, rest),
        ("-", rest) => (-1, rest),
        _ => return None,
    };
    let (number, count, rest) = digits(rest, 4)?;
    let minutes = match (count, rest.strip_prefix(':')) {
        (4, None) if rest.is_empty() => number / 100 * 60 + number % 100,
        (1 | 2, None) if rest.is_empty() => number * 60,
        (1 | 2, Some(minutes)) => {
            let (minutes, 2, "") = digits(minutes, 2)? else { return None };
            number * 60 + minutes
        }
        _ => return None,
    };
    (minutes <= 24 * 60).then_some(Some(sign * minutes))
}

/// Seconds, ms, us or ns since 1970, told apart by their size: each is the years 2001 to 2096 in one unit only.
fn epoch(text: &str) -> Option<Stamp> {
    let (whole, fraction) = text.split_once('.').unwrap_or((text, ""));
    let is_digits = |s: &str| s.bytes().all(|b| b.is_ascii_digit());
    if !is_digits(whole) || !is_digits(fraction) || fraction.len() > 9 {
        return None;
    }
    let number: i128 = whole.parse().ok()?;
    let (low, high) = (1_000_000_000_i128, 4_000_000_000_i128);
    let scale =
        [1_i128, 1_000, 1_000_000, 1_000_000_000].into_iter().find(|s| (low * s..high * s).contains(&number))?;
    let unit_ns = i128::from(NANOS_PER_SECOND) / scale;
    let fraction_ns = if fraction.is_empty() {
        0
    } else {
        let power = 10_i128.pow(u32::try_from(fraction.len()).ok()?);
        fraction.parse::<i128>().ok()? * unit_ns / power
    };
    let nanos = number * unit_ns + fraction_ns;
    let day = i128::from(NANOS_PER_DAY);
    Some(Stamp {
        date: Date::Days(i64::try_from(nanos.div_euclid(day)).ok()?),
        time_ns: Some(i64::try_from(nanos.rem_euclid(day)).ok()?),
        offset_min: Some(0),
    })
}

/// Replaces the text columns of a recording that hold stamps by their seconds, and tells what is odd about them. All columns with a
/// date count from one origin: the second of the first stamp of the first of them.
///
/// A column of times of day beside a column of dates takes its date from there.
pub fn with_stamps(file: &str, recording: &mut Recording) {
    let mut origin: Option<(i128, String)> = None;
    let Recording { tables, findings, reasons, .. } = recording;
    for table in tables {
        for index in 0..table.columns.len() {
            let Some(cells) = stamp_cells(table, index) else { continue };
            let Some(stamps) = of_stamps(&cells, origin.as_ref().map(|(ns, _)| *ns)) else {
                findings.extend(unused(file, table, index, &cells));
                continue;
            };
            // Dates alone are a label, no clock.
            if cells.iter().all(|(stamp, _)| stamp.is_none_or(|stamp| stamp.time_ns.is_none())) {
                continue;
            }
            if let (Some(text), None) = (&stamps.origin, &origin)
                && let Some(stamp) = one(text)
                && let (Date::Days(days), Some(time)) = (stamp.date, stamp.time_ns)
            {
                origin = Some((i128::from(days) * i128::from(NANOS_PER_DAY) + i128::from(time), text.clone()));
            }
            take(file, table, index, stamps, findings, reasons);
        }
    }
    if let Some((_, origin)) = origin {
        recording.origin.get_or_insert(origin);
    }
}

/// The cells of a column of text as stamps, with the dates of the column beside it where they are times of day; `None` if the first
/// of them are no stamps.
fn stamp_cells(table: &Table, index: usize) -> Option<Vec<(Option<Stamp>, bool)>> {
    let text = |index: usize| table.columns.get(index).and_then(|c| c.cells.text());
    let words = text(index)?;
    let looked_at = words.iter().filter(|word| !word.trim().is_empty()).take(64);
    let (known, all) = looked_at.fold((0, 0), |(known, all), word| (known + usize::from(one(word).is_some()), all + 1));
    if known * 2 <= all {
        return None;
    }
    let mut cells: Vec<(Option<Stamp>, bool)> = words.iter().map(|w| (one(w), w.trim().is_empty())).collect();
    let is_time = |cells: &[(Option<Stamp>, bool)]| {
        let mut stamps = cells.iter().filter_map(|(stamp, _)| *stamp).peekable();
        stamps.peek().is_some() && stamps.all(|s| s.date == Date::None && s.time_ns.is_some())
    };
    if is_time(&cells) {
        let beside = [index.checked_sub(1), Some(index + 1)].into_iter().flatten().filter_map(text);
        for dates in beside {
            let dates: Vec<Option<Stamp>> = dates.iter().map(|word| one(word)).collect();
            let is_date = |date: &Option<Stamp>| date.is_some_and(|d| d.time_ns.is_none());
            if !dates.is_empty() && dates.iter().all(is_date) {
                for ((stamp, _), date) in cells.iter_mut().zip(dates) {
                    if let (Some(stamp), Some(date)) = (stamp, date) {
                        stamp.date = date.date;
                    }
                }
                break;
            }
        }
    }
    Some(cells)
}

/// Tells of dates that are not used because day and month may be either way round.
fn unused(file: &str, table: &Table, index: usize, cells: &[(Option<Stamp>, bool)]) -> Option<Finding> {
    let is_open = |(stamp, _): &(Option<Stamp>, bool)| {
        matches!(stamp, Some(Stamp { date: Date::Either { day_first: Some(_), month_first: Some(_) }, .. }))
    };
    cells.iter().all(is_open).then_some(())?;
    let column = table.columns.get(index)?;
    let text = format!(
        "column {}: day and month of its dates may be either way round, and the date changes; it is left as text",
        shown(&column.name)
    );
    Some(ambiguous(file, table, column, text))
}

fn ambiguous(file: &str, table: &Table, column: &Column, text: String) -> Finding {
    let mut places = Places::default();
    places.add(0, table.lines.line_of(0), &[]);
    let channel = full_name(&table.name, &column.name);
    places.finding(FindingKind::AmbiguousDate, Severity::Note, file, Some(&channel), text)
}

fn take(
    file: &str,
    table: &mut Table,
    index: usize,
    stamps: Stamps,
    findings: &mut Vec<Finding>,
    reasons: &mut Vec<String>,
) {
    let Some(column) = table.columns.get(index) else { return };
    let name = column.name.clone();
    let channel = full_name(&table.name, &name);
    let words = column.cells.text().unwrap_or_default();
    let mut odd = Places::default();
    for row in &stamps.odd {
        let word = words.get(*row).map_or("", String::as_str);
        odd.add(*row, table.lines.line_of(*row), word.as_bytes());
    }
    let mut empty = Places::default();
    for (row, _) in words.iter().enumerate().filter(|(_, word)| word.trim().is_empty()) {
        empty.add(row, table.lines.line_of(row), &[]);
    }
    if stamps.is_date_open {
        let text = format!(
            "column {}: day and month of its date may be either way round; the date is not used, only the time of day",
            shown(&name)
        );
        findings.push(ambiguous(file, table, column, text));
    }
    for (kind, places) in [(FindingKind::NonNumericCell, odd), (FindingKind::EmptyCell, empty)] {
        if places.count > 0 {
            findings.push(cell_finding(kind, places, file, &channel));
        }
    }
    findings.extend(wrap_finding(file, &channel, &stamps.wraps, &table.lines));
    reasons.push(format!("column {} holds {}", shown(&name), stamps.reason));
    let mut watch = ClockWatch::default();
    watch.block(&stamps.seconds);
    let column = Column::new(&name, Some("s"), Cells::Numbers(stamps.seconds));
    table.columns[index] = Column { clock: Some(watch.finish()), ..column };
}

/// Tells of the samples at which a time of day begins anew and a day is added.
pub(crate) fn wrap_finding(file: &str, channel: &str, wraps: &[usize], lines: &LineMap) -> Option<Finding> {
    let mut places = Places::default();
    for row in wraps {
        places.add(*row, lines.line_of(*row), &[]);
    }
    let times = places.counted("time", "times");
    let mut text = format!("column {}: the time of day begins anew {times} ", shown(channel));
    let _ = write!(text, "{}; a day is added from there on", places.listed());
    (places.count > 0).then(|| places.finding(FindingKind::ClockWrap, Severity::Note, file, Some(channel), text))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn column(cells: &[&str]) -> Option<Stamps> {
        parse(&cells.iter().map(|c| (*c).to_owned()).collect::<Vec<_>>())
    }

    #[test]
    fn stamps_of_every_kind_are_seconds_since_the_first_second() {
        for (cells, origin) in [
            (["2026-11-22 09:13:00.123", "2026-11-22 09:13:01.5"], "2026-11-22T09:13:00"),
            (["2026-11-22T09:13:00.123Z", "2026-11-22T09:13:01.500Z"], "2026-11-22T09:13:00Z"),
            (["2026-11-22T09:13:00.123+01:00", "2026-11-22T08:13:01.500+00:00"], "2026-11-22T08:13:00Z"),
            (["22.11.2026 09:13:00,123", "22.11.2026 09:13:01,500"], "2026-11-22T09:13:00"),
            (["11/22/2026 9:13:00.123 AM", "11/22/2026 9:13:01.500 AM"], "2026-11-22T09:13:00"),
            (["22/11/2026 21:13:00.123", "22/11/2026 21:13:01.500"], "2026-11-22T21:13:00"),
            (["22-Nov-2026 09:13:00.123", "22-Nov-2026 09:13:01.500"], "2026-11-22T09:13:00"),
            (["11/22/2026 12:13:00.123 am", "11/22/2026 12:13:01.500 am"], "2026-11-22T00:13:00"),
            (["1795338780.123", "1795338781.500"], "2026-11-22T09:13:00Z"),
            (["1795338780123", "1795338781500"], "2026-11-22T09:13:00Z"),
            (["1795338780123000000", "1795338781500000000"], "2026-11-22T09:13:00Z"),
        ] {
            let stamps = column(&cells).unwrap_or_else(|| panic!("{cells:?}"));
            assert_eq!((stamps.seconds, stamps.origin.as_deref()), (vec![0.123, 1.5], Some(origin)), "{cells:?}");
        }
    }

    #[test]
    fn day_and_month_are_decided_by_values_above_twelve_and_never_else() {
        let later = column(&["01/02/2026 00:00:00", "01/13/2026 00:00:00"]).unwrap();
        assert_eq!((later.seconds[1], later.origin.as_deref()), (11.0 * 86_400.0, Some("2026-01-02T00:00:00")));
        let open = column(&["01/02/2026 09:00:00", "01/02/2026 09:00:01"]).unwrap();
        assert_eq!((open.seconds, open.origin, open.is_date_open), (vec![32_400.0, 32_401.0], None, true));
        assert_eq!(column(&["01/02/2026 09:00:00", "02/02/2026 09:00:01"]), None);
        assert_eq!(column(&["13/02/2026 09:00:00", "02/13/2026 09:00:01"]), None);
        assert!(!column(&["03/03/2026 09:00:00"]).unwrap().is_date_open);
    }

    #[test]
    fn midnight_adds_a_day_and_is_told() {
        let stamps = column(&["23:59:59.5", "00:00:00.5", "", "00:00:01.5"]).unwrap();
        assert_eq!(stamps.seconds[..2], [86_399.5, 86_400.5]);
        assert!(stamps.seconds[2].is_nan());
        assert_eq!((stamps.seconds[3], stamps.wraps), (86_401.5, vec![1]));
        // A clock that is set back by an hour is not midnight.
        assert_eq!(column(&["10:00:00", "09:00:00"]).unwrap().wraps, [0; 0]);
    }

    #[test]
    fn what_is_no_stamp_is_none() {
        for text in [
            "A10-0",
            "1.5",
            "2026-13-01 00:00:00",
            "29.02.2025 00:00:00",
            "25:00:00",
            "12:60:00",
            "12:00:61",
            "13:00:00 PM",
            "09:13",
            "1:2",
            "::",
            "2026-11-22T",
            "22.11.26 09:00:00",
            "12",
            "-",
            "é:00:00",
            "2026-11-22 09:00:00 Mars",
        ] {
            let stamp = one(text);
            assert!(
                stamp.is_none_or(|s| text == "09:13" || (text == "2026-11-22T" && s.time_ns.is_none())),
                "{text}: {stamp:?}"
            );
        }
        assert_eq!(column(&["09:13:00", "ERR", "FAIL"]), None);
        assert_eq!(column(&["09:13:00", "ERR", "09:13:01"]).unwrap().odd, [1]);
    }

    #[test]
    fn days_are_counted_both_ways() {
        for (date, days) in
            [((1970, 1, 1), 0), ((2000, 2, 29), 11_016), ((2026, 11, 22), 20_779), ((1904, 1, 1), -24_107)]
        {
            assert_eq!(days_from_civil(date.0, date.1, date.2), Some(days));
            assert_eq!(civil_from_days(days), date);
        }
        for days in -25_000..80_000 {
            let (year, month, day) = civil_from_days(days);
            assert_eq!(days_from_civil(year, month, day), Some(days));
        }
    }
}
