//! When a segment began: the date and the time of day that its header states, or else that of the file.

use crate::formats::stamps::local_second;

/// The beginning of a channel's samples, by the clock of the computer that wrote the file. No zone is stated.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Start {
    /// Whole seconds since 1970 in that clock's own zone.
    pub second: i64,
    /// The rest of it, in s.
    pub fraction: f64,
    /// Whether day and month may be either way round.
    pub is_open: bool,
}

/// Seconds of a day, and of what time zones are apart.
const DAY_S: i64 = 86_400;
const QUARTER_S: i64 = 900;

/// Seconds from 1904-01-01 00:00, from which LabVIEW counts, to 1970-01-01 00:00.
pub(super) const S_1904_TO_1970: i64 = 2_082_844_800;

impl Start {
    /// From a date and a time of day with any number of decimals, behind a point or a comma; `None` if it is none.
    pub fn of(date: &str, time: &str) -> Option<Self> {
        let time = time.trim();
        let seconds = time.rfind(':').map_or(0, |colon| colon + 1);
        let sign = time.get(seconds..)?.find(['.', ',']).map(|at| seconds + at);
        let (whole, fraction, behind) = match sign {
            None => (time, "", ""),
            Some(sign) => {
                // The sign is one byte.
                let (whole, rest) = (time.get(..sign)?, time.get(sign + 1..)?);
                let digits = rest.bytes().take_while(u8::is_ascii_digit).count();
                (whole, rest.get(..digits)?, rest.get(digits..)?)
            }
        };
        let (second, is_open) = local_second(&format!("{} {whole}{behind}", date.trim()))?;
        let fraction = if fraction.is_empty() { 0.0 } else { format!("0.{fraction}").parse().ok()? };
        Some(Self { second, fraction, is_open })
    }

    /// Whether it is the zero of LabVIEW's clock, in whatever zone: data to which nobody gave a start.
    pub fn is_unset(self) -> bool {
        (self.second + S_1904_TO_1970).abs() <= DAY_S && self.second.rem_euclid(QUARTER_S) == 0 && self.fraction == 0.0
    }

    /// Seconds from a whole second to it.
    pub fn since(self, second: i64) -> f64 {
        (self.second - second) as f64 + self.fraction
    }

    /// Whether the time between two starts is known: of dates that may be read two ways only if they are one day.
    pub fn is_comparable(self, other: Self) -> bool {
        let day = |start: Self| start.second.div_euclid(DAY_S);
        !(self.is_open || other.is_open) || day(self) == day(other)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn starts_are_read_to_the_last_digit_of_a_double() {
        // As `date -u -d '2013-02-19 09:51:40' +%s` prints it.
        let start = |second, fraction, is_open| Some(Start { second, fraction, is_open });
        let expected = start(1_361_267_500, 0.727_189_064_025_878_9, false);
        for (date, time) in [
            ("2013/02/19", "09:51:40,7271890640258789063"),
            ("2013/02/19", " 09:51:40.7271890640258789063"),
            ("19.02.2013", "9:51:40.7271890640258789063"),
            ("02/19/2013", "09:51:40.7271890640258789063 AM"),
            ("19/02/2013", "09:51:40.7271890640258789063"),
        ] {
            assert_eq!(Start::of(date, time), expected, "{date} {time}");
        }
        assert_eq!(Start::of("2013/02/19", "09:51:40"), start(1_361_267_500, 0.0, false));
        assert_eq!(Start::of("2013/02/19", "09:51:40."), start(1_361_267_500, 0.0, false));
        assert_eq!(Start::of("2013/02/19", "09:51"), start(1_361_267_460, 0.0, false));
        assert!(Start::of("03/02/2013", "09:51:40").is_some_and(|start| start.is_open));
        for (date, time) in
            [("", "09:51:40"), ("2013/02/19", ""), ("2013/02/30", "09:51:40"), ("2013/02/19", "25:00:00")]
        {
            assert_eq!(Start::of(date, time), None, "{date} {time}");
        }
    }
}
