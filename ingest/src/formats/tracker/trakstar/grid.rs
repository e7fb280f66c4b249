//! The steps in which a trakSTAR counts: what the numbers of a file say about the unit they are written in.

use crate::formats::csv::Decimal;
use crate::number;

/// Range over 2^15 in each unit that programs write: 36 in, and 1 in is 25.4 mm by definition. From the coarsest.
const STEPS: [(&str, f64); 4] =
    [("mm", 914.4 / 32768.0), ("cm", 91.44 / 32768.0), ("in", 36.0 / 32768.0), ("m", 0.9144 / 32768.0)];

/// How likely it may be that numbers which are no multiples all look like some, as the natural logarithm.
const CHANCE_LN_MAX: f64 = -40.0;

/// Share of the numbers that may be no multiples: damaged digits.
const MISFITS_MAX: f64 = 0.005;

/// A number as printed: its value and how far what was printed may be from it.
fn printed(cell: &[u8], decimal: Decimal) -> Option<(f64, f64)> {
    let text = std::str::from_utf8(cell).ok()?;
    let (value, half_width) = match decimal {
        Decimal::Point => number::parse(text)?,
        Decimal::Comma => number::parse(&text.replace(',', "."))?,
    };
    // Programs hold positions in single precision: two roundings of 2^-24 each, on the way from the step to the unit.
    Some((value, half_width + value.abs() * 1.2e-7)).filter(|(value, _)| value.is_finite())
}

/// Evidence for one step.
#[derive(Debug, Clone, Copy, Default)]
struct Fit {
    numbers: usize,
    misfits: usize,
    /// Sum of the chances that a number fits by accident.
    chance: f64,
    /// Greatest common divisor of the multiples.
    divisor: u64,
}

impl Fit {
    fn add(&mut self, value: f64, half_width: f64, step: f64) {
        let multiple = (value / step).round();
        self.numbers += 1;
        self.chance += (2.0 * half_width / step).min(1.0);
        if (value - multiple * step).abs() > half_width {
            self.misfits += 1;
        } else if multiple.abs() < 1e9 {
            #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
            let multiple = multiple.abs() as u64;
            self.divisor = gcd(self.divisor, multiple);
        }
    }

    fn holds(&self) -> bool {
        let numbers = self.numbers as f64;
        let chance = self.chance / numbers.max(1.0);
        self.misfits as f64 <= MISFITS_MAX * numbers && numbers * chance.ln() < CHANCE_LN_MAX
    }
}

fn gcd(a: u64, b: u64) -> u64 {
    let (mut a, mut b) = (a, b);
    while b != 0 {
        (a, b) = (b, a % b);
    }
    a
}

/// The unit of positions that all are multiples of a step.
pub(super) struct Found {
    pub unit: &'static str,
    pub step: f64,
    pub multiple: u64,
}

/// Which unit's steps positions are multiples of.
#[derive(Debug, Clone, Default)]
pub(super) struct LengthGrid {
    fits: [Fit; STEPS.len()],
}

impl LengthGrid {
    /// A position as printed.
    pub fn add(&mut self, cell: &[u8], decimal: Decimal) {
        let Some((value, half_width)) = printed(cell, decimal) else { return };
        for (fit, (_, step)) in self.fits.iter_mut().zip(STEPS) {
            fit.add(value, half_width, step);
        }
    }

    /// The unit, if the numbers decide it: multiples of a coarse step are multiples of a finer one too, so the coarsest that fits wins.
    pub fn unit(&self) -> Option<Found> {
        let (fit, (unit, step)) = self.fits.iter().zip(STEPS).find(|(fit, _)| fit.holds())?;
        Some(Found { unit, step, multiple: fit.divisor.max(1) })
    }
}

/// Which step angles are multiples of: half a circle over 2^13, or a half or quarter of that.
#[derive(Debug, Clone, Default)]
pub(super) struct AngleGrid {
    fits: [Fit; 3],
}

impl AngleGrid {
    const PARTS: [f64; 3] = [8192.0, 16384.0, 32768.0];

    /// An angle in degrees as printed.
    pub fn add(&mut self, cell: &[u8], decimal: Decimal) {
        let Some((value, half_width)) = printed(cell, decimal) else { return };
        for (fit, parts) in self.fits.iter_mut().zip(Self::PARTS) {
            fit.add(value, half_width, 180.0 / parts);
        }
    }

    /// The step in words, if the numbers decide it.
    pub fn step_deg(&self) -> Option<String> {
        let (_, parts) = self.fits.iter().zip(Self::PARTS).find(|(fit, _)| fit.holds())?;
        Some(format!("180/{parts}"))
    }
}

/// A step with as many digits as tell it.
pub(super) fn shown_step(step: f64) -> String {
    let decimals = if step < 1e-3 { 9 } else { 7 };
    let text = format!("{step:.decimals$}");
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn unit_of(unit_step: f64, places: usize, multiple: i64) -> Option<&'static str> {
        let mut grid = LengthGrid::default();
        for i in 0..400_i64 {
            let value = ((i * 7919) % 30_011 - 15_000) as f64 * multiple as f64 * unit_step;
            grid.add(format!("{value:.places$}").as_bytes(), Decimal::Point);
        }
        grid.unit().map(|found| found.unit)
    }

    #[test]
    fn the_unit_is_told_by_the_step() {
        for (unit, step) in STEPS {
            for multiple in [1, 2, 8] {
                assert_eq!(unit_of(step, 7, multiple), Some(unit), "{unit} {multiple}");
            }
        }
    }

    #[test]
    fn digits_that_cannot_tell_decide_nothing() {
        assert_eq!(unit_of(36.0 / 32768.0, 2, 1), None);
        assert_eq!(unit_of(0.01, 6, 1), None);
        assert_eq!(LengthGrid::default().unit().map(|f| f.unit), None);
    }
}
