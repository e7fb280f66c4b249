//! One clock set on another by events that both saw: `reference = offset + (1 + drift) stamp`.
//!
//! Weighted least squares about the weighted middle of the events, where the offset is known best and its error has nothing to do
//! with that of the drift. Every event is wrong by two parts: an even one, where it lies anywhere within its half width, on each of
//! the two clocks; and a normal one, from noise. Offset and drift are linear in these, so what they are wrong by is a sum of such
//! parts, each with a known factor, and its 95 % interval is that of the sum's own distribution: of few events it is no normal one.
//!
//! With three or more events they can contradict each other. The sum of squares of what is left over is compared with chi-square
//! (the 99.9 % quantile); beyond it every uncertainty grows by the root of its excess over the degrees of freedom.

use statrs::distribution::{ChiSquared, ContinuousCDF, Normal};

use super::events::Event;
use super::lag::count;

/// The share of the intervals.
const COVERAGE: f64 = 0.95;

/// Events contradict each other where less than this share of honest ones would differ as much.
const CONTRADICTS: f64 = 0.001;

/// Points at which the distribution of a sum is computed.
const GRID: usize = 4096;

/// An estimate with its standard uncertainty and its 95 % interval.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Estimate {
    /// The value.
    pub value: f64,
    /// Standard uncertainty.
    pub std: f64,
    /// Half the width of the 95 % interval.
    pub half_width: f64,
}

impl Estimate {
    /// Whether the interval holds a value.
    pub fn holds(&self, value: f64) -> bool {
        (value - self.value).abs() <= self.half_width
    }
}

/// What is added to the stamps of one clock to get those of another.
#[derive(Debug, Clone, PartialEq)]
pub struct ClockFit {
    /// In the middle of the events, in s.
    pub offset: Estimate,
    /// The stamp at which that holds, on this clock, in s.
    pub middle_s: f64,
    /// What must be added more in every second; `None`: one event does not say.
    pub drift: Option<Estimate>,
    /// Events used.
    pub events: usize,
    /// Root mean square of what is left over, in s.
    pub residual_s: f64,
    /// The factor by which uncertainties grew, because events contradict each other; 1: they do not.
    pub inflation: f64,
    /// Of every event: its weight in the offset and in the drift, and the parts of its error.
    parts: Vec<Part>,
}

/// An event's part in the fit.
#[derive(Debug, Clone, PartialEq)]
struct Part {
    /// Factor in the offset, and in the drift.
    factors: (f64, f64),
    /// Half widths of the even parts.
    even_s: [f64; 2],
    /// Standard deviation of the normal part.
    std_s: f64,
}

impl ClockFit {
    /// The clock by pairs of one event, first as the reference saw it, with the standard uncertainty of how far apart the two
    /// recordings really are. `None` without events.
    pub fn of(pairs: &[(Event, Event, f64)]) -> Option<Self> {
        let first = pairs.first()?;
        // Stamps may count from 1970: differences are taken before anything is squared.
        let origin = (first.0.at_s, first.1.at_s);
        let parts: Vec<Part> = pairs
            .iter()
            .map(|(reference, device, apart_s)| Part {
                factors: (0.0, 0.0),
                even_s: [reference.half_width_s, device.half_width_s],
                std_s: reference.std_s.hypot(device.std_s).hypot(*apart_s),
            })
            .collect();
        // An event of no width at all would weigh infinitely.
        let floor = f64::EPSILON * (1.0 + origin.0.abs().max(origin.1.abs()));
        let variances: Vec<f64> = parts.iter().map(|part| part.variance().max(floor * floor)).collect();
        let weights: Vec<f64> = variances.iter().map(|variance| 1.0 / variance).collect();
        let sum: f64 = weights.iter().sum();
        let at: Vec<f64> = pairs.iter().map(|(_, device, _)| device.at_s - origin.1).collect();
        let apart: Vec<f64> = pairs.iter().zip(&at).map(|((r, _, _), at)| (r.at_s - origin.0) - at).collect();
        let mean = |of: &[f64]| of.iter().zip(&weights).map(|(v, w)| v * w).sum::<f64>() / sum;
        let (middle, offset) = (mean(&at), mean(&apart));
        let spread: f64 = at.iter().zip(&weights).map(|(at, w)| w * (at - middle).powi(2)).sum();
        let has_drift = pairs.len() > 1 && spread > 0.0;
        let mut fit = Self {
            offset: Estimate { value: offset + (origin.0 - origin.1), std: 0.0, half_width: 0.0 },
            middle_s: middle + origin.1,
            drift: None,
            events: pairs.len(),
            residual_s: 0.0,
            inflation: 1.0,
            parts,
        };
        for ((part, w), at) in fit.parts.iter_mut().zip(&weights).zip(&at) {
            part.factors = (w / sum, if has_drift { w * (at - middle) / spread } else { 0.0 });
        }
        let drift = has_drift
            .then(|| fit.parts.iter().zip(&apart).map(|(part, apart)| part.factors.1 * (apart - offset)).sum::<f64>());
        let left: Vec<f64> =
            apart.iter().zip(&at).map(|(d, at)| d - offset - drift.unwrap_or(0.0) * (at - middle)).collect();
        fit.residual_s = (left.iter().map(|r| r * r).sum::<f64>() / left.len() as f64).sqrt();
        fit.inflation = inflation(&left, &variances);
        fit.offset = fit.estimate(fit.offset.value, 1.0, 0.0);
        fit.drift = drift.map(|drift| fit.estimate(drift, 0.0, 1.0));
        Some(fit)
    }

    /// A value whose error is `offset` times that of the offset and `drift` times that of the drift.
    fn estimate(&self, value: f64, offset: f64, drift: f64) -> Estimate {
        let (mut even, mut variance, mut normal) = (Vec::new(), 0.0, 0.0);
        for part in &self.parts {
            let factor = (offset * part.factors.0 + drift * part.factors.1).abs();
            even.extend(part.even_s.iter().map(|half| factor * half));
            normal += (factor * part.std_s).powi(2);
            variance += factor * factor * part.variance();
        }
        Estimate {
            value,
            std: self.inflation * variance.sqrt(),
            half_width: self.inflation * half_width_of_sum(&even, normal.sqrt()),
        }
    }

    /// What is added at another stamp of this clock; as far as that is known without the drift where one event does not say it.
    pub fn offset_at(&self, stamp_s: f64) -> Estimate {
        let since_s = stamp_s - self.middle_s;
        match self.drift {
            None => self.offset,
            Some(drift) => self.estimate(self.offset.value + drift.value * since_s, 1.0, since_s),
        }
    }

    /// A stamp of this clock on the reference.
    pub fn on_reference(&self, stamp_s: f64) -> f64 {
        let drift = self.drift.map_or(0.0, |drift| drift.value);
        stamp_s + (self.offset.value + drift * (stamp_s - self.middle_s))
    }
}

impl Part {
    fn variance(&self) -> f64 {
        self.even_s.iter().map(|half| half * half / 3.0).sum::<f64>() + self.std_s * self.std_s
    }
}

/// By how much events differ more than they should: the root of chi-square over its degrees of freedom, or 1.
fn inflation(left: &[f64], variances: &[f64]) -> f64 {
    let Some(freedom) = left.len().checked_sub(2).filter(|freedom| *freedom > 0) else { return 1.0 };
    let freedom = freedom as f64;
    let sum: f64 = left.iter().zip(variances).map(|(r, v)| r * r / v).sum();
    let most = ChiSquared::new(freedom).map_or(f64::INFINITY, |chi| chi.inverse_cdf(1.0 - CONTRADICTS));
    if sum > most { (sum / freedom).sqrt() } else { 1.0 }
}

/// Half the width of the interval that holds a sum of independent parts with 95 %: even ones between plus and minus their half
/// widths, and a normal one.
///
/// The distribution is built part by part: that of a sum with an even part is the mean of the one before over the part's width. On
/// a grid, with straight lines between its points, exact to some 1e-4 of the width.
pub fn half_width_of_sum(even: &[f64], std: f64) -> f64 {
    let mut even: Vec<f64> = even.iter().copied().filter(|half| *half > 0.0).collect();
    even.sort_by(f64::total_cmp);
    // Far out in the tails of many parts nothing is left that counts.
    let total = even.iter().map(|half| half * half / 3.0).sum::<f64>() + std * std;
    let reach = (even.iter().sum::<f64>() + 8.0 * std).min(8.0 * total.sqrt());
    if reach.partial_cmp(&0.0) != Some(std::cmp::Ordering::Greater) || !reach.is_finite() {
        return if reach == 0.0 { 0.0 } else { f64::INFINITY };
    }
    let step = 2.0 * reach / (GRID - 1) as f64;
    let at = |i: usize| i as f64 * step - reach;
    let normal = Normal::new(0.0, std).ok().filter(|_| std > step);
    let mut below: Vec<f64> = match normal {
        Some(normal) => (0..GRID).map(|i| normal.cdf(at(i))).collect(),
        None => match even.pop() {
            Some(widest) => (0..GRID).map(|i| ((at(i) + widest) / (2.0 * widest)).clamp(0.0, 1.0)).collect(),
            // Narrower than the grid cannot be: the reach is that of the normal part alone.
            None => (0..GRID).map(|i| if at(i) < 0.0 { 0.0 } else { 1.0 }).collect(),
        },
    };
    let mut sums = vec![0.0; GRID];
    for half in even.into_iter().filter(|half| *half > 1e-3 * step) {
        for i in 1..GRID {
            sums[i] = sums[i - 1] + 0.5 * step * (below[i - 1] + below[i]);
        }
        // Up to any place: the area under straight lines.
        let area = |x: f64| {
            let place = (x + reach) / step;
            if place <= 0.0 {
                return 0.0;
            }
            let last = (GRID - 1) as f64;
            if place >= last {
                return sums[GRID - 1] + (place - last) * step;
            }
            let (i, part) = (count(place), place.fract());
            sums[i] + step * part * (below[i] + 0.5 * part * (below[i + 1] - below[i]))
        };
        let wider: Vec<f64> = (0..GRID).map(|i| (area(at(i) + half) - area(at(i) - half)) / (2.0 * half)).collect();
        below = wider;
    }
    let wanted = 0.5 * (1.0 + COVERAGE);
    let i = below.partition_point(|p| *p < wanted).clamp(1, GRID - 1);
    let part = (wanted - below[i - 1]) / (below[i] - below[i - 1]);
    at(i - 1) + part.clamp(0.0, 1.0) * step
}

#[cfg(test)]
mod tests {
    use super::*;

    fn event(at_s: f64, half_width_s: f64) -> Event {
        Event { at_s, half_width_s, std_s: 0.0, rises: true }
    }

    #[test]
    fn the_interval_of_a_sum_is_that_of_its_own_distribution() {
        let near =
            |found: f64, expected: f64| assert!((found - expected).abs() < 5e-4 * expected, "{found} {expected}");
        // One even part: 95 % of its width.
        near(half_width_of_sum(&[2.0], 0.0), 1.9);
        // Two equal ones: a triangle, 2 a (1 - √0.05).
        near(half_width_of_sum(&[1.0, 1.0], 0.0), 2.0 * (1.0 - 0.05_f64.sqrt()));
        // A wide and a narrow one: the corner of the trapezoid is cut where 2.5 % remain, d = √(2·0.025·4·a·b).
        near(half_width_of_sum(&[1.0, 0.5], 0.0), 1.5 - (0.025_f64 * 8.0 * 0.5).sqrt());
        near(half_width_of_sum(&[], 0.5), 0.5 * 1.959_964);
        // Many: normal.
        near(half_width_of_sum(&[1.0; 300], 0.0), 10.0 * 1.959_964);
        assert!(half_width_of_sum(&[], 0.0).abs() < 1e-300 && half_width_of_sum(&[f64::NAN], 1.0) > 0.0);
    }

    #[test]
    fn a_clock_that_is_known_exactly_comes_back_whatever_it_counts_from() {
        for zero in [0.0, 1_795_338_780.0] {
            let pair = |t: f64| (event(t, 0.001), event(zero + 0.2 + (t) * (1.0 + 30e-6), 0.004), 0.0);
            let fit = ClockFit::of(&[pair(1.0), pair(2.0), pair(30.0), pair(31.0)]).unwrap();
            let drift = fit.drift.unwrap();
            assert!((drift.value + 30e-6).abs() < 1e-7, "{drift:?}");
            for t in [0.0, 16.0, 100.0] {
                let stamp = zero + 0.2 + t * (1.0 + 30e-6);
                assert!((fit.on_reference(stamp) - t).abs() < 1e-6, "{t}: {}", fit.on_reference(stamp));
            }
            // The offset is known best in the middle, and the drift by its distance from there.
            assert!(fit.offset_at(fit.middle_s).half_width < fit.offset_at(fit.middle_s + 10.0).half_width);
            assert!((fit.inflation - 1.0).abs() < 1e-12);
        }
    }

    #[test]
    fn one_event_says_nothing_of_the_drift_and_events_that_contradict_each_other_are_less_sure() {
        let fit = ClockFit::of(&[(event(5.0, 0.01), event(7.0, 0.01), 0.0)]).unwrap();
        assert!(fit.drift.is_none() && (fit.offset.value + 2.0).abs() < 1e-12);
        assert!((fit.offset.half_width - 0.02 * (1.0 - 0.05_f64.sqrt())).abs() < 1e-5, "{fit:?}");
        let wrong = |t: f64, by: f64| (event(t, 0.001), event(t + by, 0.001), 0.0);
        let fit = ClockFit::of(&[wrong(1.0, 0.0), wrong(2.0, 0.1), wrong(3.0, 0.0), wrong(4.0, 0.1)]).unwrap();
        assert!(fit.inflation > 30.0 && fit.offset.half_width > 0.02, "{fit:?}");
        // Declared to be as far apart as that, they do not.
        let told = |t: f64, by: f64| (event(t, 0.001), event(t + by, 0.001), 0.1);
        let fit = ClockFit::of(&[told(1.0, 0.0), told(2.0, 0.1), told(3.0, 0.0), told(4.0, 0.1)]).unwrap();
        assert!((fit.inflation - 1.0).abs() < 1e-12 && fit.offset.half_width > 0.09);
        assert!(ClockFit::of(&[]).is_none());
    }
}
