//! Stretches of steady pressure.

use std::collections::VecDeque;

use pneuval_ingest::finding::median_step;

/// A step of time longer than so many usual ones ends a stretch: nobody knows what happened in it.
pub(crate) const GAP_STEPS: f64 = 5.0;

/// So many standard deviations of their sum the last samples of a window may be off before they are on their way elsewhere.
const MOVING: f64 = 2.0;

/// The standard deviation of normal noise over its median absolute deviation.
const NORMAL_OF_MEDIAN: f64 = 1.482_602_218_505_602;

/// So many steps of a double may lie between two writings of one instant: the roundings of two stamps, and of what is added to them.
const STAMP_ROUNDINGS: f64 = 4.0;

/// What rounding leaves open of a difference of two stamps of this size, in s.
pub(crate) fn rounding_s(stamp_s: f64) -> f64 {
    STAMP_ROUNDINGS * f64::EPSILON * stamp_s.abs()
}

/// A stretch of steady pressure.
#[derive(Debug, Clone, PartialEq)]
pub struct Plateau {
    /// The stamp of its first sample, in s.
    pub from_s: f64,
    /// The samples of its window, which end it.
    pub window: Vec<usize>,
}

/// The ends of stretches in which every channel stays within its tolerance of the middle of its range for long enough.
///
/// `usable` are the samples looked at, in time; `steady` the channels with their tolerances. A stretch ends where a channel
/// moves on, where time goes back and at a gap. Of a stretch that lasts `hold_s` the samples of its last `window_s` are given.
/// The first stretch that lasts long enough is taken, and the search goes on after it; each sample is looked at a constant
/// number of times.
pub fn plateaus(
    usable: &[usize],
    seconds: &[f64],
    steady: &[(&[f64], f64)],
    hold_s: f64,
    window_s: f64,
) -> Vec<Plateau> {
    let stamps: Vec<f64> = usable.iter().map(|&i| seconds[i]).collect();
    let longest_step = median_step(&stamps).map_or(f64::INFINITY, |step| GAP_STEPS * step);
    let largest = stamps.iter().fold(hold_s, |most, stamp| most.max(stamp.abs()));
    // A duration is a difference of stamps: what their roundings take from it is still enough.
    let slack = rounding_s(largest);
    let mut ranges: Vec<Range> = steady.iter().map(|(values, tolerance)| Range::new(values, 2.0 * tolerance)).collect();
    let mut found = Vec::new();
    let (mut start, mut end) = (0, 0);
    while start < usable.len() {
        // Whether the stretch from `start` can take the sample at `end`.
        while end < usable.len() {
            let i = usable[end];
            let step = if end > start { stamps[end] - stamps[end - 1] } else { 0.0 };
            let broken = step < 0.0 || step > longest_step;
            if broken || !ranges.iter().all(|range| range.fits(i)) {
                break;
            }
            for range in &mut ranges {
                range.push(end, i);
            }
            end += 1;
        }
        let last = stamps[end - 1];
        let broken = end < usable.len() && {
            let step = stamps[end] - stamps[end - 1];
            step < 0.0 || step > longest_step
        };
        if end - start > 1 && last - stamps[start] >= hold_s - slack {
            let from = |last: f64| start + stamps[start..end].partition_point(|stamp| *stamp < last - window_s - slack);
            let stands = still(usable, steady, from(last), end);
            let window = usable[from(stamps[stands - 1])..stands].to_vec();
            found.push(Plateau { from_s: stamps[start], window });
            start = end;
            ranges.iter_mut().for_each(Range::clear);
        } else if broken || end == usable.len() {
            // No later start gets further than this end.
            start = end;
            ranges.iter_mut().for_each(Range::clear);
        } else {
            start += 1;
            for range in &mut ranges {
                range.forget_before(start);
            }
            end = end.max(start);
        }
    }
    found
}

/// Where the end of a stretch still stands: a channel on its way to the next pressure is within the tolerance for a while, and what is
/// measured may go far in it. The way begins within the noise, so it is the sum over the last samples that tells: with m the median of
/// the window and s its noise, the last k samples are left out for which |Σ (v - m)|/(s √k) is largest, if it is
/// [`MOVING`] or more; a quarter of the window at most.
fn still(usable: &[usize], steady: &[(&[f64], f64)], first: usize, end: usize) -> usize {
    let window = &usable[first..end];
    let least = end - window.len() / 4;
    let stands = |(values, _): &(&[f64], f64)| {
        let middle = median(window.iter().map(|&i| values[i]).collect());
        let noise = NORMAL_OF_MEDIAN * median(window.iter().map(|&i| (values[i] - middle).abs()).collect());
        let (mut sum, mut best) = (0.0, (MOVING, end));
        for k in (least..end).rev() {
            sum += values[usable[k]] - middle;
            let evidence = sum.abs() / (noise * ((end - k) as f64).sqrt());
            // Without noise every deviation is a movement, and none is none.
            if evidence >= best.0 {
                best = (evidence, k);
            }
        }
        best.1
    };
    steady.iter().map(stands).min().unwrap_or(end)
}

fn median(mut values: Vec<f64>) -> f64 {
    let middle = values.len() / 2;
    values.select_nth_unstable_by(middle, f64::total_cmp);
    values[middle]
}

/// The range of a channel over a moving stretch: smallest and largest at the front of two queues.
struct Range<'a> {
    values: &'a [f64],
    width_max: f64,
    /// Position in the stretch and value; values rise from the front.
    smallest: VecDeque<(usize, f64)>,
    /// The same, falling.
    largest: VecDeque<(usize, f64)>,
}

impl<'a> Range<'a> {
    fn new(values: &'a [f64], width_max: f64) -> Self {
        Self { values, width_max, smallest: VecDeque::new(), largest: VecDeque::new() }
    }

    fn fits(&self, sample: usize) -> bool {
        let v = self.values[sample];
        let low = self.smallest.front().map_or(v, |(_, low)| low.min(v));
        let high = self.largest.front().map_or(v, |(_, high)| high.max(v));
        high - low <= self.width_max
    }

    fn push(&mut self, position: usize, sample: usize) {
        let v = self.values[sample];
        while self.smallest.back().is_some_and(|(_, back)| *back >= v) {
            self.smallest.pop_back();
        }
        while self.largest.back().is_some_and(|(_, back)| *back <= v) {
            self.largest.pop_back();
        }
        self.smallest.push_back((position, v));
        self.largest.push_back((position, v));
    }

    fn forget_before(&mut self, position: usize) {
        for queue in [&mut self.smallest, &mut self.largest] {
            while queue.front().is_some_and(|(front, _)| *front < position) {
                queue.pop_front();
            }
        }
    }

    fn clear(&mut self) {
        self.smallest.clear();
        self.largest.clear();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at_10_hz(n: u32) -> Vec<f64> {
        (0..n).map(|i| f64::from(i) / 10.0).collect()
    }

    #[test]
    fn a_stretch_of_steady_pressure_is_one_point_and_a_ramp_is_none() {
        // 0 to 1 s at 10 kPa, a ramp to 20 kPa until 2 s, 2 to 4 s at 20 kPa.
        let seconds = at_10_hz(41);
        let pressure: Vec<f64> = seconds.iter().map(|t| 1e4 + 1e4 * (t - 1.0).clamp(0.0, 1.0)).collect();
        let usable: Vec<usize> = (0..=40).collect();
        let found = plateaus(&usable, &seconds, &[(&pressure, 100.0)], 0.9, 0.5);
        assert_eq!(found.len(), 2);
        assert!(found[0].from_s.abs() < 1e-12 && (found[1].from_s - 2.0).abs() < 0.11, "{found:?}");
        assert_eq!((found[0].window.first(), found[0].window.last()), (Some(&5), Some(&10)));
        assert_eq!((found[1].window.first(), found[1].window.last()), (Some(&35), Some(&40)));
        assert!(plateaus(&usable, &seconds, &[(&pressure, 100.0)], 5.0, 0.5).is_empty());
    }

    #[test]
    fn a_hold_of_exactly_the_asked_length_counts_whatever_rounding_does() {
        // 20 steps of five samples, 0.4 s from first to last.
        let seconds = at_10_hz(100);
        let pressure: Vec<f64> = (0..100).map(|i| 1e3 * f64::from(i / 5)).collect();
        let usable: Vec<usize> = (0..100).collect();
        let found = plateaus(&usable, &seconds, &[(&pressure, 10.0)], 0.4, 0.2);
        assert_eq!(found.len(), 20);
        assert!(found.iter().all(|plateau| plateau.window.len() == 3), "{found:?}");
    }

    #[test]
    fn stamps_since_1970_are_as_long_as_any() {
        // 2 s at each of three pressures; counted from 1970 a nanosecond for each second would be more than a second.
        let seconds: Vec<f64> = at_10_hz(60).iter().map(|t| 1_795_338_780.0 + t).collect();
        let pressure: Vec<f64> = (0..60).map(|i| 1e4 * f64::from(i / 20)).collect();
        let usable: Vec<usize> = (0..60).collect();
        let found = plateaus(&usable, &seconds, &[(&pressure, 100.0)], 1.9, 0.5);
        assert_eq!(found.iter().map(|plateau| plateau.window.len()).collect::<Vec<_>>(), [6, 6, 6]);
        assert!(plateaus(&usable, &seconds, &[(&pressure, 100.0)], 2.0, 0.5).is_empty());
    }

    #[test]
    fn a_condition_that_moves_and_a_gap_end_a_stretch() {
        let mut seconds = at_10_hz(60);
        let pressure = vec![2e4; 60];
        let held: Vec<f64> = (0..60).map(|i| if i < 30 { 0.0 } else { 1.0 }).collect();
        let usable: Vec<usize> = (0..60).collect();
        let both: [(&[f64], f64); 2] = [(&pressure, 10.0), (&held, 0.01)];
        assert_eq!(plateaus(&usable, &seconds, &both, 2.0, 0.5).len(), 2);
        // Ten seconds are missing in the middle: neither half lasts four seconds.
        seconds.iter_mut().skip(30).for_each(|t| *t += 10.0);
        assert!(plateaus(&usable, &seconds, &[(&pressure, 10.0)], 4.0, 0.5).is_empty());
        assert_eq!(plateaus(&usable, &seconds, &[(&pressure, 10.0)], 2.0, 0.5).len(), 2);
    }

    #[test]
    fn a_slow_ramp_is_searched_in_time() {
        let n = 200_000;
        let seconds: Vec<f64> = (0..n).map(|i| f64::from(i) / 1e3).collect();
        let pressure: Vec<f64> = (0..n).map(|i| 0.1 * f64::from(i)).collect();
        let usable: Vec<usize> = (0..seconds.len()).collect();
        assert!(plateaus(&usable, &seconds, &[(&pressure, 500.0)], 60.0, 1.0).is_empty());
        let constant = vec![2e4; seconds.len()];
        assert!(plateaus(&usable, &seconds, &[(&constant, 500.0)], 3600.0, 1.0).is_empty());
    }
}
