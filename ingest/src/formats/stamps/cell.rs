//! A stamp as one cell holds it, and the calendar.
//!
//! Days are counted in the Gregorian calendar by Hinnant's `days_from_civil` (<https://howardhinnant.github.io/date_algorithms.html>).

pub(super) const NANOS_PER_SECOND: i64 = 1_000_000_000;
const SECONDS_PER_DAY: i64 = 86_400;
pub(super) const NANOS_PER_DAY: i64 = SECONDS_PER_DAY * NANOS_PER_SECOND;

/// A stamp as one cell holds it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Stamp {
    pub date: Date,
    /// Since midnight; absent where only a date is written.
    pub time_ns: Option<i64>,
    /// Minutes by which the clock is ahead of UTC, where said.
    pub offset_min: Option<i64>,
}

/// The date of a stamp, in days since 1970.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Date {
    None,
    Days(i64),
    /// Day and month may be either way round; `None` for what is no date.
    Either {
        day_first: Option<i64>,
        month_first: Option<i64>,
    },
}

/// An instant in RFC 3339, in UTC where the offset is known, else without any.
pub(super) fn rfc3339(nanos: i128, offset_min: Option<i64>) -> String {
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
    days_of(year, month, day)
}

/// The same of any year; the day is not checked.
pub(super) fn days_of(year: i64, month: i64, day: i64) -> Option<i64> {
    if !(-999_999..999_999).contains(&year) || !(1..=12).contains(&month) || !(1..=31).contains(&day) {
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
pub(super) fn one(text: &str) -> Option<Stamp> {
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

#[cfg(test)]
mod tests {
    use super::*;

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
