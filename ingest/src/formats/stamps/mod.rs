//! Stamps written as dates and times of day: text columns that become seconds.
//!
//! What a stamp leaves open stays open: no time zone is guessed, and where day and month may be either way round the date is not used.

mod cell;

use std::fmt::Write as _;

use crate::error::shown;
use crate::finding::places::{Places, cell_finding};
use crate::finding::{Finding, FindingKind, LineMap, Severity};
use crate::recording::{Cells, Column, Recording, Table, full_name};
use crate::watch::ClockWatch;

use cell::{Date, NANOS_PER_DAY, NANOS_PER_SECOND, Stamp, days_of, one, rfc3339};

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

/// The second since 1970 of an origin in RFC 3339, and whether its zone is known; without one it is taken as UTC.
///
/// ```
/// use pneuval_ingest::formats::stamps::origin_second;
/// assert_eq!(origin_second("1970-01-02T00:00:00Z"), Some((86_400, true)));
/// assert_eq!(origin_second("1970-01-02T00:00:01"), Some((86_401, false)));
/// assert_eq!(origin_second("at noon"), None);
/// ```
pub fn origin_second(origin: &str) -> Option<(i64, bool)> {
    let Stamp { date: Date::Days(days), time_ns, offset_min } = one(origin)? else { return None };
    let seconds = time_ns?.div_euclid(NANOS_PER_SECOND) - offset_min.unwrap_or(0) * 60;
    Some((days * (NANOS_PER_DAY / NANOS_PER_SECOND) + seconds, offset_min.is_some()))
}

/// A date and a time of day in whole seconds since 1970, by the clock that wrote them; and whether day and month may be either way round,
/// in which case the day is taken to stand first.
pub(crate) fn local_second(text: &str) -> Option<(i64, bool)> {
    let stamp = one(text)?;
    let (days, is_open) = match stamp.date {
        Date::Days(days) => (days, false),
        Date::Either { day_first: Some(days), month_first } => (days, month_first.is_some_and(|other| other != days)),
        Date::Either { day_first: None, month_first } => (month_first?, false),
        Date::None => return None,
    };
    Some((days * (NANOS_PER_DAY / NANOS_PER_SECOND) + stamp.time_ns? / NANOS_PER_SECOND, is_open))
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

/// As [`rfc3339_second`], of a time in s.
pub(crate) fn utc_second(seconds: f64, is_utc: bool) -> String {
    // Dates end long before the numbers do.
    #[expect(clippy::cast_possible_truncation)]
    let seconds = seconds as i64;
    rfc3339_second(seconds, is_utc)
}

/// A second since 1970 in RFC 3339, as UTC or as a clock whose zone is not stated.
pub(crate) fn rfc3339_second(seconds: i64, is_utc: bool) -> String {
    rfc3339(i128::from(seconds) * i128::from(NANOS_PER_SECOND), is_utc.then_some(0))
}

/// The instant from which stamps count, to the second.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Epoch {
    /// Seconds since 1970, by the clock that wrote the stamps.
    pub second: i64,
    /// Whether that clock is UTC; else its zone is not stated.
    pub is_utc: bool,
}

impl Epoch {
    /// 1970 in UTC, from which computers count.
    pub const UNIX: Self = Self { second: 0, is_utc: true };

    /// An origin as a [`Recording`] states it; `None` for any other text.
    ///
    /// ```
    /// use pneuval_ingest::formats::stamps::Epoch;
    /// let epoch = Epoch::parse("2026-11-22T09:13:00Z").unwrap();
    /// assert_eq!((epoch.second, epoch.is_utc), (1_795_338_780, true));
    /// assert_eq!(epoch.to_string(), "2026-11-22T09:13:00Z");
    /// assert_eq!(Epoch::parse("09:13:00"), None);
    /// ```
    pub fn parse(origin: &str) -> Option<Self> {
        let (text, is_utc) = origin.strip_suffix('Z').map_or((origin, false), |text| (text, true));
        let (date, time) = text.split_once('T')?;
        let mut date = date.rsplitn(3, '-');
        let mut time = time.split(':');
        let mut of_date = || date.next()?.parse::<i64>().ok();
        let (day, month, year) = (of_date()?, of_date()?, of_date()?);
        let mut of_time = || time.next()?.parse::<i64>().ok().filter(|part| (0..60).contains(part));
        let of_day = of_time()? * 3600 + of_time()? * 60 + of_time()?;
        let second = days_of(year, month, day)? * (NANOS_PER_DAY / NANOS_PER_SECOND) + of_day;
        let epoch = Self { second, is_utc };
        (epoch.to_string() == origin).then_some(epoch)
    }

    /// Seconds from another instant to this one; `None` if one is UTC and of the other nobody knows the zone.
    pub fn since(self, other: Self) -> Option<i64> {
        (self.is_utc == other.is_utc).then(|| self.second.checked_sub(other.second))?
    }
}

impl std::fmt::Display for Epoch {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&rfc3339_second(self.second, self.is_utc))
    }
}

/// Replaces the text columns of a recording that hold stamps by their seconds, and tells what is odd about them. All columns with a
/// date count from one origin: the second of the first stamp of the first of them.
///
/// A column of times of day beside a column of dates takes its date from there.
pub fn with_stamps(file: &str, recording: &mut Recording) {
    let mut origin: Option<(i128, String)> = None;
    let Recording { tables, findings, reasons, origin: known, .. } = recording;
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
            // A file that has an origin of its own keeps it: what counts from another instant is not dated by it.
            let is_dated =
                stamps.origin.is_some() && known.as_ref().is_none_or(|known| stamps.origin.as_ref() == Some(known));
            take(file, table, index, stamps, findings, reasons);
            if let Some(column) = table.columns.get_mut(index) {
                column.is_dated = is_dated;
            }
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
        if places.count() > 0 {
            findings.push(cell_finding(kind, places, file, &channel));
        }
    }
    findings.extend(wrap_finding(file, &channel, &stamps.wraps, &table.lines));
    reasons.push(format!("column {} holds {}", shown(&name), stamps.reason));
    let mut watch = ClockWatch::default();
    watch.block(&stamps.seconds);
    let is_dated = stamps.origin.is_some();
    let column = Column::new(&name, Some("s"), Cells::Numbers(stamps.seconds));
    table.columns[index] = Column { clock: Some(watch.finish()), is_dated, ..column };
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
    (places.count() > 0).then(|| places.finding(FindingKind::ClockWrap, Severity::Note, file, Some(channel), text))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn column(cells: &[&str]) -> Option<Stamps> {
        parse(&cells.iter().map(|c| (*c).to_owned()).collect::<Vec<_>>())
    }

    #[test]
    fn days_have_dates() {
        // As `date -u -d @N --iso-8601=seconds` prints them.
        for (seconds, date) in [
            (0, "1970-01-01T00:00:00Z"),
            (951_782_399, "2000-02-28T23:59:59Z"),
            (951_782_400, "2000-02-29T00:00:00Z"),
            (951_868_800, "2000-03-01T00:00:00Z"),
            (1_700_000_000, "2023-11-14T22:13:20Z"),
            (4_107_542_400, "2100-03-01T00:00:00Z"),
            (18_446_744_073, "2554-07-21T23:34:33Z"),
        ] {
            assert_eq!(rfc3339_second(seconds, true), date);
        }
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
    fn cells_that_are_no_stamps_are_counted_and_most_must_be_some() {
        assert_eq!(column(&["09:13:00", "ERR", "FAIL"]), None);
        assert_eq!(column(&["09:13:00", "ERR", "09:13:01"]).unwrap().odd, [1]);
    }
}
