//! How readings move from cycle to cycle.

use super::readings::Reading;
use crate::metrics::Interval;
use crate::uncertainty::coverage::student_975;

/// Cycles, over runs, below which no drift can be told from scatter.
const CYCLES_MIN: usize = 3;

/// The change of a response per cycle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Drift {
    /// Slope of the mean reading over the number of the cycle, with its 95 % interval, in SI units per cycle.
    pub per_cycle_si: Interval,
    /// Conditioned cycles it is taken from, over all runs.
    pub cycles: usize,
}

/// The drift of the conditioned cycles, each a set of readings of the stations that all of them have: their number over the life of the specimen and
/// the readings' means.
pub(super) fn drift(cycles: &[(f64, f64)]) -> Option<Drift> {
    if cycles.len() < CYCLES_MIN {
        return None;
    }
    let n = cycles.len() as f64;
    let mean = |of: &dyn Fn(&(f64, f64)) -> f64| cycles.iter().map(of).sum::<f64>() / n;
    let (x0, y0) = (mean(&|c| c.0), mean(&|c| c.1));
    let sum = |of: &dyn Fn(f64, f64) -> f64| cycles.iter().map(|(x, y)| of(x - x0, y - y0)).sum::<f64>();
    let (xx, xy, yy) = (sum(&|x, _| x * x), sum(&|x, y| x * y), sum(&|_, y| y * y));
    let value = xy / xx;
    let std = ((yy - value * xy).max(0.0) / (n - 2.0) / xx).sqrt();
    let half = student_975(cycles.len() - 2)? * std;
    let per_cycle_si = Interval { value, lower: value - half, upper: value + half };
    (value.is_finite() && half.is_finite()).then_some(Drift { per_cycle_si, cycles: cycles.len() })
}

/// The mean over the first components of some readings; `None` where one is a hole.
pub(super) fn mean_reading<'a>(readings: impl Iterator<Item = &'a Reading>) -> Option<f64> {
    let values: Vec<f64> = readings.map(|r| r.measured.first().copied().unwrap_or(f64::NAN)).collect();
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    mean.is_finite().then_some(mean)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_straight_drift_is_its_slope_and_two_cycles_have_none() {
        let found = drift(&[(1.0, 10.0), (2.0, 10.5), (4.0, 11.5)]).unwrap();
        assert!((found.per_cycle_si.value - 0.5).abs() < 1e-12 && found.per_cycle_si.half_width() < 1e-9);
        assert_eq!(found.cycles, 3);
        // Residuals 1/6, -1/3, 1/6 about a slope of 1/2: s = √(1/6), over √2; t with one degree of freedom.
        let found = drift(&[(1.0, 0.0), (2.0, 0.0), (3.0, 1.0)]).unwrap();
        assert!((found.per_cycle_si.half_width() - 12.706_204_736 * (1.0_f64 / 12.0).sqrt()).abs() < 1e-8);
        assert_eq!(drift(&[(1.0, 0.0), (2.0, 1.0)]), None);
    }
}
