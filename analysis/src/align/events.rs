//! When something happened, as one channel saw it: edges of a line of two states, steps through the middle, knocks.
//!
//! Only samples with a stamp that counts are looked at. Where time stands or a gap lies, nothing is interpolated: samples of one
//! stamp are one moment, and what happened in a gap is left out.

use pneuval_ingest::finding::median_step;
use pneuval_ingest::manifest::SyncEvent;

use crate::response::GAP_STEPS;

/// Between two states lies the middle of the way; a line stays in the outer parts.
const OUTER_SHARE: f64 = 0.25;

/// So many samples of a line of two states may stand between them, as a share.
const BETWEEN_SHARE_MAX: f64 = 0.01;

/// A knock stands out of the noise so many times.
const TAP_NOISES: f64 = 8.0;

/// Deviations of more than this share of the largest are knocks of their own, if they lie so far apart, in s.
const TAP_SHARE: f64 = 0.5;
const TAP_APART_S: f64 = 0.25;

/// From the median of absolute deviations to the standard deviation of normal noise.
const MAD_TO_STD: f64 = 1.482_602_218_505_602;

/// Events of one channel at most: beyond it the channel shows something else.
pub const EVENTS_MAX: usize = 2000;

/// An event in the device's own time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Event {
    /// The best guess, in s.
    pub at_s: f64,
    /// It lies within so much of the guess, all of it equally likely, in s.
    pub half_width_s: f64,
    /// Beyond that, standard uncertainty from noise of stamps and readings, in s.
    pub std_s: f64,
    /// Whether the signal rises.
    pub rises: bool,
}

/// What a channel shows.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Events {
    /// Events in time.
    pub found: Vec<Event>,
    /// Events that fall into a gap of the stamps, which are left out.
    pub in_gaps: usize,
}

/// A moment: the samples of one stamp.
#[derive(Debug, Clone, Copy)]
struct Moment {
    at_s: f64,
    first: f64,
    last: f64,
}

/// A channel in time, without what does not count.
struct Track {
    moments: Vec<Moment>,
    /// A longer step is a gap.
    gap_s: f64,
    step_s: f64,
    /// Standard deviation of single stamps.
    jitter_s: f64,
}

impl Track {
    fn of(seconds: &[f64], values: &[f64]) -> Option<Self> {
        let mut moments: Vec<Moment> = Vec::new();
        let pairs = seconds.iter().zip(values).filter(|(t, v)| t.is_finite() && v.is_finite());
        for (&at_s, &value) in pairs {
            match moments.last_mut() {
                // Stamps that count never go back.
                Some(moment) if at_s <= moment.at_s => moment.last = value,
                _ => moments.push(Moment { at_s, first: value, last: value }),
            }
        }
        let stamps: Vec<f64> = moments.iter().map(|moment| moment.at_s).collect();
        let step_s = median_step(&stamps)?;
        let strays: Vec<f64> = stamps.windows(2).map(|pair| (pair[1] - pair[0] - step_s).abs()).collect();
        // A step is the difference of two stamps.
        let jitter_s = MAD_TO_STD * median(strays) / std::f64::consts::SQRT_2;
        Some(Self { moments, gap_s: GAP_STEPS * step_s, step_s, jitter_s })
    }

    /// Smallest and largest.
    fn range(&self) -> (f64, f64) {
        let values = self.moments.iter().flat_map(|moment| [moment.first, moment.last]);
        values.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(v), b.max(v)))
    }

    /// Standard deviation of the noise, from differences of neighbours, which know no slow motion.
    fn noise(&self) -> f64 {
        let steps = self.moments.windows(2).map(|pair| (pair[1].first - pair[0].last).abs()).collect();
        MAD_TO_STD * median(steps) / std::f64::consts::SQRT_2
    }

    fn is_gap(&self, from_s: f64, to_s: f64) -> bool {
        to_s - from_s > self.gap_s
    }
}

/// The events of a channel.
///
/// # Errors
/// Why there are none, in words.
pub fn events(seconds: &[f64], values: &[f64], event: SyncEvent) -> Result<Events, String> {
    let track = Track::of(seconds, values).ok_or("it has no two samples with stamps")?;
    let (low, high) = track.range();
    if high.partial_cmp(&low) != Some(std::cmp::Ordering::Greater) {
        return Err("it never changes".to_owned());
    }
    let events = match event {
        SyncEvent::Edges => edges(&track, low, high)?,
        SyncEvent::Steps => steps(&track, low, high),
        SyncEvent::Tap => taps(&track)?,
    };
    match events.found.len() {
        0 if events.in_gaps > 0 => Err(format!("its {} events lie in gaps of its stamps", events.in_gaps)),
        0 => Err("no event is seen".to_owned()),
        n if n > EVENTS_MAX => {
            Err(format!("{n} events, more than the {EVENTS_MAX} that any sitting has: is it another signal?"))
        }
        _ => Ok(events),
    }
}

/// Where a line of two states changes. The change lies between two samples, anywhere with equal right.
fn edges(track: &Track, low: f64, high: f64) -> Result<Events, String> {
    let share = |value: f64| (value - low) / (high - low);
    let is_between = |value: f64| (OUTER_SHARE..=1.0 - OUTER_SHARE).contains(&share(value));
    let between = track.moments.iter().filter(|moment| is_between(moment.first) || is_between(moment.last)).count();
    if between as f64 > BETWEEN_SHARE_MAX * track.moments.len() as f64 {
        return Err(format!(
            "{between} of {} samples stand between its two states: say event = \"steps\"",
            track.moments.len()
        ));
    }
    let is_up = |value: f64| share(value) > 0.5;
    let mut events = Events::default();
    let mut add = |from_s: f64, to_s: f64, rises: bool| {
        if track.is_gap(from_s, to_s) {
            events.in_gaps += 1;
            return;
        }
        events.found.push(Event {
            at_s: f64::midpoint(from_s, to_s),
            half_width_s: 0.5 * (to_s - from_s),
            // Both ends stray on their own.
            std_s: track.jitter_s / std::f64::consts::SQRT_2,
            rises,
        });
    };
    let moments = &track.moments;
    for i in 0..moments.len() {
        let here = moments[i];
        if let Some(before) = i.checked_sub(1).map(|before| moments[before])
            && is_up(before.last) != is_up(here.first)
        {
            add(before.at_s, here.at_s, is_up(here.first));
        }
        // Within one stamp: anywhere between its neighbours.
        if is_up(here.first) != is_up(here.last) {
            let before = i.checked_sub(1).map_or(here, |before| moments[before]);
            let after = moments.get(i + 1).copied().unwrap_or(here);
            add(before.at_s, after.at_s, is_up(here.last));
        }
    }
    Ok(events)
}

/// Where a signal passes the middle on its way from the lower to the upper part of its range or back, on a straight line between
/// two samples. That line is wrong by no more than the share of the way that lies between the two.
fn steps(track: &Track, low: f64, high: f64) -> Events {
    let share = |moment: &Moment| (moment.last - low) / (high - low);
    let noise = track.noise() / (high - low);
    let mut events = Events::default();
    // Since when the signal is on its way, and from which side.
    let mut side: Option<bool> = None;
    let mut left_at = 0;
    for (i, moment) in track.moments.iter().enumerate() {
        let now = match share(moment) {
            s if s < OUTER_SHARE => false,
            s if s > 1.0 - OUTER_SHARE => true,
            _ => continue,
        };
        if side.is_some_and(|before| before != now) {
            // Of noisy crossings the middle one.
            let crosses = |k: &usize| (share(&track.moments[k - 1]) > 0.5) != (share(&track.moments[*k]) > 0.5);
            let crossings: Vec<usize> = (left_at + 1..=i).filter(crosses).collect();
            let Some(&k) = crossings.get(crossings.len() / 2) else { continue };
            let (a, b) = (&track.moments[k - 1], &track.moments[k]);
            if track.is_gap(a.at_s, b.at_s) {
                events.in_gaps += 1;
            } else {
                let (from, to) = (share(a), share(b));
                let part = (0.5 - from) / (to - from);
                let way = (to - from).abs().min(1.0);
                // The slope over the whole way: that of two noisy neighbours may be anything.
                let slope = 1.0 - 2.0 * OUTER_SHARE;
                let lasts_s = moment.at_s - track.moments[left_at].at_s;
                events.found.push(Event {
                    at_s: a.at_s + part * (b.at_s - a.at_s),
                    half_width_s: 0.5 * way * (b.at_s - a.at_s),
                    std_s: (noise / slope * lasts_s).min(lasts_s).hypot(track.jitter_s / std::f64::consts::SQRT_2),
                    rises: now,
                });
            }
        }
        side = Some(now);
        left_at = i;
    }
    events
}

/// The largest deviations from the rest, each at the top of a parabola through three samples.
fn taps(track: &Track) -> Result<Events, String> {
    let rest = median(track.moments.iter().map(|moment| moment.first).collect());
    let deviation: Vec<f64> = track
        .moments
        .iter()
        .map(|moment| {
            let (first, last) = (moment.first - rest, moment.last - rest);
            if first.abs() > last.abs() { first } else { last }
        })
        .collect();
    let size: Vec<f64> = deviation.iter().map(|d| d.abs()).collect();
    let largest = size.iter().copied().fold(0.0, f64::max);
    let noise = MAD_TO_STD * median(size.clone());
    if largest <= TAP_NOISES * noise {
        return Err("no knock stands out of its noise".to_owned());
    }
    let mut peaks: Vec<usize> = Vec::new();
    let mut last_s = f64::NEG_INFINITY;
    for i in (0..size.len()).filter(|&i| size[i] > TAP_SHARE * largest) {
        let at_s = track.moments[i].at_s;
        match peaks.last_mut().filter(|_| at_s - last_s < TAP_APART_S) {
            Some(peak) if size[i] > size[*peak] => *peak = i,
            Some(_) => {}
            None => peaks.push(i),
        }
        last_s = at_s;
    }
    // A knock is short: what stays away from the rest is a line, or a step.
    for &peak in &peaks {
        let is_out = |i: &usize| size[*i] > TAP_SHARE * largest && (deviation[*i] > 0.0) == (deviation[peak] > 0.0);
        let from = (0..peak).rev().take_while(is_out).last().unwrap_or(peak);
        let to = (peak + 1..size.len()).take_while(is_out).last().unwrap_or(peak);
        let lasts_s = track.moments[to].at_s - track.moments[from].at_s;
        if lasts_s > TAP_APART_S {
            return Err(format!(
                "what stands out of its rest at {:.3} s lasts {lasts_s:.2} s, which no knock does: say event = \"edges\" for a line, \"steps\" for a \
                 signal between two levels",
                track.moments[from].at_s
            ));
        }
    }
    let mut events = Events::default();
    for peak in peaks {
        let here = track.moments[peak].at_s;
        let neighbours = peak.checked_sub(1).zip(track.moments.get(peak + 1).map(|_| peak + 1));
        let Some((before, after)) = neighbours else {
            events.in_gaps += 1;
            continue;
        };
        let (a, b) = (track.moments[before].at_s - here, track.moments[after].at_s - here);
        if track.is_gap(0.0, -a) || track.is_gap(0.0, b) {
            events.in_gaps += 1;
            continue;
        }
        let (ya, yb) = (size[before] - size[peak], size[after] - size[peak]);
        // y = m t + c t² through (a, ya), (0, 0), (b, yb).
        let c = (ya / a - yb / b) / (a - b);
        let m = ya / a - c * a;
        let shift = if c < 0.0 { (-0.5 * m / c).clamp(0.5 * a, 0.5 * b) } else { 0.0 };
        events.found.push(Event {
            at_s: here + shift,
            // The top of what was really there lies nearer to this sample than to its neighbours.
            half_width_s: 0.5 * track.step_s,
            std_s: track.jitter_s,
            rises: deviation[peak] > 0.0,
        });
    }
    Ok(events)
}

/// The middle value; zero of none.
fn median(mut values: Vec<f64>) -> f64 {
    if values.is_empty() {
        return 0.0;
    }
    let middle = values.len() / 2;
    *values.select_nth_unstable_by(middle, f64::total_cmp).1
}

/// Pairs of the same event, by their places in both lists.
///
/// Equally many events are paired in order, if the intervals between them agree. Otherwise the shift is looked for under which most
/// events meet; there must be one such pairing only.
///
/// # Errors
/// Why no pairing can be trusted, in words.
pub fn matched(reference: &[Event], device: &[Event], drift_max: f64) -> Result<Vec<(usize, usize)>, String> {
    let in_order = || (0..device.len()).map(|i| (i, i)).collect::<Vec<_>>();
    if reference.len() == device.len() && agree(reference, device, &in_order(), drift_max) {
        return Ok(in_order());
    }
    let mut best: Vec<Vec<(usize, usize)>> = Vec::new();
    for (first, r) in reference.iter().enumerate() {
        for (second, d) in device.iter().enumerate() {
            if r.rises != d.rises {
                continue;
            }
            let pairing = under_shift(reference, device, (first, second), drift_max);
            match best.first().map_or(0, Vec::len).cmp(&pairing.len()) {
                std::cmp::Ordering::Less => best = vec![pairing],
                std::cmp::Ordering::Equal if !best.contains(&pairing) => best.push(pairing),
                _ => {}
            }
        }
    }
    let found = format!("{} events here, {} there", device.len(), reference.len());
    match &best[..] {
        [only] if only.len() >= 2 => Ok(only.clone()),
        [] => Err(format!("{found}, and none that could be the same")),
        [only, ..] if only.len() < 2 => Err(format!("{found}, and no two that lie equally far apart")),
        several => Err(format!("{found}, and {} ways to pair {} of them", several.len(), several[0].len())),
    }
}

/// How far apart two stamps of one event may seem beside those of another.
fn slack_s(a: &Event, b: &Event) -> f64 {
    a.half_width_s + b.half_width_s + 3.0 * a.std_s.hypot(b.std_s)
}

/// Whether the intervals between neighbouring events are alike on both clocks, and all edges go the same way, or all the other.
fn agree(reference: &[Event], device: &[Event], pairs: &[(usize, usize)], drift_max: f64) -> bool {
    let ways: Vec<bool> = pairs.iter().map(|(r, d)| reference[*r].rises == device[*d].rises).collect();
    ways.windows(2).all(|pair| pair[0] == pair[1])
        && pairs.windows(2).all(|pair| {
            let ((r0, d0), (r1, d1)) = (pair[0], pair[1]);
            let (on_reference, on_device) =
                (reference[r1].at_s - reference[r0].at_s, device[d1].at_s - device[d0].at_s);
            let slack = slack_s(&reference[r0], &device[d0]) + slack_s(&reference[r1], &device[d1]);
            (on_reference - on_device).abs() <= drift_max * on_device.abs() + slack
        })
}

/// The events that meet if these two are one.
fn under_shift(reference: &[Event], device: &[Event], (r0, d0): (usize, usize), drift_max: f64) -> Vec<(usize, usize)> {
    let mut pairs = Vec::new();
    let mut next = 0;
    for (d, event) in device.iter().enumerate() {
        let since_s = event.at_s - device[d0].at_s;
        let expected_s = reference[r0].at_s + since_s;
        let meets = |r: &usize| {
            let other = &reference[*r];
            let slack = slack_s(other, event) + slack_s(&reference[r0], &device[d0]) + drift_max * since_s.abs();
            other.rises == event.rises && (other.at_s - expected_s).abs() <= slack
        };
        let from = next.max(reference.partition_point(|e| e.at_s < expected_s - 1.0 - drift_max * since_s.abs()));
        let near =
            (from..reference.len()).take_while(|r| reference[*r].at_s <= expected_s + 1.0 + drift_max * since_s.abs());
        let distance = |r: usize| (reference[r].at_s - expected_s).abs();
        let nearest = near.filter(meets).min_by(|a, b| distance(*a).total_cmp(&distance(*b)));
        if let Some(r) = nearest {
            pairs.push((r, d));
            next = r + 1;
        }
    }
    pairs
}

#[cfg(test)]
mod tests {
    use super::*;

    fn line(rate_hz: f64, samples: u32, offset_s: f64, ups: &[(f64, f64)]) -> (Vec<f64>, Vec<f64>) {
        let times: Vec<f64> = (0..samples).map(|i| f64::from(i) / rate_hz).collect();
        let state = |t: &f64| if ups.iter().any(|(from, to)| (*from..*to).contains(t)) { 1.0 } else { 0.0 };
        let values = times.iter().map(state).collect();
        (times.iter().map(|t| t + offset_s).collect(), values)
    }

    #[test]
    fn an_edge_lies_anywhere_between_two_samples() {
        let (seconds, values) = line(10.0, 100, 0.0, &[(1.23, 2.0), (7.01, 8.05)]);
        let events = events(&seconds, &values, SyncEvent::Edges).unwrap();
        let found: Vec<(f64, bool)> = events.found.iter().map(|e| (e.at_s, e.rises)).collect();
        for ((at_s, rises), expected) in found.iter().zip([(1.25, true), (1.95, false), (7.05, true), (8.05, false)]) {
            assert!((at_s - expected.0).abs() < 1e-9 && *rises == expected.1, "{found:?}");
        }
        assert!(events.found.iter().all(|e| (e.half_width_s - 0.05).abs() < 1e-9 && e.std_s < 1e-9));
    }

    #[test]
    fn an_edge_in_a_gap_is_left_out_and_one_within_equal_stamps_is_not_interpolated() {
        let (mut seconds, values) = line(10.0, 100, 0.0, &[(3.0, 9.0)]);
        seconds[29..].iter_mut().for_each(|t| *t += 2.0);
        seconds[30..].iter_mut().for_each(|t| *t += 2.0);
        let found = events(&seconds, &values, SyncEvent::Edges).unwrap();
        assert_eq!((found.found.len(), found.in_gaps), (1, 1));
        // Three samples of one stamp, among them the change: it lies between the stamps before and after.
        let (mut seconds, values) = line(10.0, 100, 0.0, &[(3.0, 20.0)]);
        (seconds[30], seconds[31]) = (seconds[29], seconds[29]);
        let event = events(&seconds, &values, SyncEvent::Edges).unwrap().found[0];
        assert!((event.at_s - 3.0).abs() < 1e-9 && (event.half_width_s - 0.2).abs() < 1e-9, "{event:?}");
        // A stamp that does not count is no sample.
        let (mut seconds, values) = line(10.0, 100, 0.0, &[(3.0, 20.0)]);
        seconds[30] = f64::NAN;
        let event = events(&seconds, &values, SyncEvent::Edges).unwrap().found[0];
        assert!((event.at_s - 3.0).abs() < 1e-9 && (event.half_width_s - 0.1).abs() < 1e-9, "{event:?}");
    }

    #[test]
    fn what_is_no_line_of_two_states_or_shows_nothing_is_refused_with_the_reason() {
        let seconds: Vec<f64> = (0..100).map(f64::from).collect();
        let ramp: Vec<f64> = (0..100).map(f64::from).collect();
        assert!(events(&seconds, &ramp, SyncEvent::Edges).unwrap_err().contains("event = \"steps\""));
        assert_eq!(events(&seconds, &[1.0; 100], SyncEvent::Edges).unwrap_err(), "it never changes");
        assert!(events(&[f64::NAN; 100], &ramp, SyncEvent::Steps).is_err());
        let noise: Vec<f64> = (0..100).map(|i| f64::from(i * 37 % 17)).collect();
        assert!(events(&seconds, &noise, SyncEvent::Tap).unwrap_err().contains("noise"));
    }

    #[test]
    fn a_step_passes_the_middle_and_a_knock_has_a_top() {
        // From 0 to 10 between 1.0 and 1.5 s.
        let seconds: Vec<f64> = (0..300).map(|i| f64::from(i) / 100.0 + 0.003).collect();
        let values: Vec<f64> = seconds.iter().map(|t| 20.0 * (t - 1.0).clamp(0.0, 0.5)).collect();
        let event = events(&seconds, &values, SyncEvent::Steps).unwrap().found[0];
        assert!((event.at_s - 1.25).abs() < 1e-3 && event.half_width_s < 1e-3 && event.rises, "{event:?}");
        // Which stays where it is: no knock.
        assert!(events(&seconds, &values, SyncEvent::Tap).unwrap_err().contains("which no knock does"));
        let values: Vec<f64> = seconds.iter().map(|t| -(-((t - 1.234) / 0.02).powi(2)).exp()).collect();
        let event = events(&seconds, &values, SyncEvent::Tap).unwrap().found[0];
        assert!((event.at_s - 1.234).abs() < 1e-3 && !event.rises, "{event:?}");
    }

    #[test]
    fn events_are_paired_in_order_or_by_their_intervals_or_not_at_all() {
        let at = |times: &[f64]| -> Vec<Event> {
            let event = |(i, t): (usize, &f64)| Event { at_s: *t, half_width_s: 0.01, std_s: 0.0, rises: i % 2 == 0 };
            times.iter().enumerate().map(event).collect()
        };
        let reference = at(&[1.0, 2.0, 7.5, 9.0]);
        let all = vec![(0, 0), (1, 1), (2, 2), (3, 3)];
        assert_eq!(matched(&reference, &at(&[101.0, 102.0, 107.5, 109.0]), 0.01).unwrap(), all);
        // The second device was switched on late.
        assert_eq!(matched(&reference, &at(&[107.5, 109.0]), 0.01).unwrap(), [(2, 0), (3, 1)]);
        // Equally far apart twice.
        let twice = at(&[1.0, 2.0, 7.5, 8.5]);
        assert!(matched(&twice, &at(&[107.5, 108.5]), 0.01).unwrap_err().contains("2 ways to pair 2"));
        assert!(matched(&reference, &at(&[3.0, 13.0]), 0.01).unwrap_err().contains("no two"));
        // Equally many, and not the same ones.
        assert_eq!(matched(&at(&[1.0, 2.0, 7.5, 9.0]), &at(&[7.5, 9.0, 20.0, 33.0]), 0.01).unwrap(), [(2, 0), (3, 1)]);
    }
}
