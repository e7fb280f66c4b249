//! What is wrong with a test of a strip: found and told, never averaged away.
//!
//! | defect | how it is seen | what becomes of it |
//! |---|---|---|
//! | sign | load opposes the stretch in most samples | refused |
//! | clock | stamps that go back or repeat | noted: stress over stretch needs no clock |
//! | several loadings | the stretch turns back by more than a tenth of its range | one loading is used, the others are left out; what the first needs more is told |
//! | rupture | load falls below half of its largest and stays there | left out |
//! | slippage | load falls by more than its noise, and rises again, while the strip gets longer | noted, with the places |
//! | slack | the strip takes up stiffness at the beginning instead of giving it up | noted, with the stretch from which it pulls |
//! | stiffness | an initial slope that no elastomer has | noted: a unit may be wrong |

use std::fmt::Write as _;

use crate::finding::{Finding, FindingKind, LineMap, Severity};

use super::columns::{finding, significant};

/// Elastomers lie between: a very soft gel, and a rubber that is nearly a plastic.
const MODULUS_MIN_PA: f64 = 2e3;
const MODULUS_MAX_PA: f64 = 5e7;
/// A fall of the stress by this many times its scatter is no scatter.
const SLIP_SCATTERS: f64 = 8.0;
/// And by this share of its largest.
const SLIP_SHARE: f64 = 0.005;

/// A test as it was recorded.
pub struct Curve<'a> {
    /// The file, for messages.
    pub file: &'a str,
    /// Length over length at rest.
    pub stretch: &'a [f64],
    /// Force over section at rest.
    pub stress_pa: &'a [f64],
    /// Where samples stand.
    pub lines: &'a LineMap,
}

impl Curve<'_> {
    fn finding(&self, kind: FindingKind, severity: Severity, places: &[usize], text: String) -> Finding {
        finding(kind, severity, self.file, places, self.lines, text)
    }

    fn line(&self, sample: usize) -> usize {
        self.lines.line_of(sample)
    }

    fn largest_stress(&self, used: &[bool]) -> f64 {
        let sizes = self.stress_pa.iter().zip(used).filter(|(s, used)| **used && s.is_finite()).map(|(s, _)| s.abs());
        sizes.fold(0.0, f64::max)
    }

    /// `37 of 40` if most samples that are loaded at all are loaded the wrong way.
    pub fn wrong_sign(&self) -> Option<String> {
        let largest = self.largest_stress(&vec![true; self.stress_pa.len()]);
        let loaded = |i: &usize| self.stress_pa[*i].abs() > 0.05 * largest && (self.stretch[*i] - 1.0).abs() > 1e-3;
        let loaded: Vec<usize> = (0..self.stretch.len()).filter(loaded).collect();
        let wrong = loaded.iter().filter(|i| self.stress_pa[**i] * (self.stretch[**i] - 1.0) < 0.0).count();
        (5 * wrong > 4 * loaded.len()).then(|| format!("{wrong} of {}", loaded.len()))
    }

    /// Samples without a number, or at which there would be no strip.
    pub fn no_numbers(&self, used: &mut [bool], findings: &mut Vec<Finding>) {
        let bad =
            |i: &usize| !(self.stretch[*i] > 0.0 && self.stretch[*i].is_finite() && self.stress_pa[*i].is_finite());
        let places: Vec<usize> = (0..used.len()).filter(bad).collect();
        let Some(&first) = places.first() else { return };
        for i in &places {
            used[*i] = false;
        }
        let text = format!(
            "{} samples have no stretch above 0 or no stress, first on line {}; they are left out",
            places.len(),
            self.line(first)
        );
        findings.push(self.finding(FindingKind::NoValue, Severity::Excluded, &places, text));
    }

    /// Stamps that go back or repeat.
    pub fn clock(&self, time_s: &[f64], findings: &mut Vec<Finding>) {
        let steps = |is: &dyn Fn(f64) -> bool| -> Vec<usize> {
            (1..time_s.len()).filter(|&i| is(time_s[i] - time_s[i - 1])).collect()
        };
        let (back, again) = (steps(&|step| step < 0.0), steps(&|step| step == 0.0));
        for (places, kind, what) in [
            (back, FindingKind::TimeReversed, "time goes back"),
            (again, FindingKind::DuplicateStamp, "a stamp is that of the sample before"),
        ] {
            if let Some(&first) = places.first() {
                let text = format!(
                    "{what} at {} samples, first on line {}; stress over stretch needs no clock, so they are kept: look whether two tests stand in one file",
                    places.len(),
                    self.line(first)
                );
                findings.push(self.finding(kind, Severity::Note, &places, text));
            }
        }
    }

    /// Keeps one loading, where the stretch goes up and down; says which.
    pub fn loadings(&self, asked: Option<usize>, used: &mut [bool], findings: &mut Vec<Finding>) -> Option<String> {
        let places: Vec<usize> = (0..used.len()).filter(|i| used[*i]).collect();
        let loadings = self.ways(&places);
        if loadings.len() < 2 && asked.is_none() {
            // One way up; a way down behind it is another state of the material.
            let (start, end) = *loadings.first()?;
            let after = places.iter().filter(|i| **i > end || **i < start).count();
            if after == 0 {
                return None;
            }
        }
        let number = asked.unwrap_or(loadings.len()).clamp(1, loadings.len().max(1));
        let (start, end) = *loadings.get(number - 1)?;
        let out: Vec<usize> = places.iter().copied().filter(|i| !(start..=end).contains(i)).collect();
        for i in &out {
            used[*i] = false;
        }
        let mut text = format!(
            "the strip was loaded {} times; loading {number}, lines {} to {}, is used, the other {} samples are left out (--loading N for another)",
            loadings.len(),
            self.line(start),
            self.line(end),
            out.len()
        );
        if let (Some(first), true) = (loadings.first(), number > 1) {
            // At the middle of the loading that is used, whatever else differs.
            let middle = 0.5 * (self.stretch[start] + self.stretch[end]);
            let at =
                |way: (usize, usize)| (way.0..=way.1).find(|i| self.stretch[*i] >= middle).map(|i| self.stress_pa[i]);
            if let (Some(virgin), Some(later)) = (at(*first), at((start, end))) {
                // Writing to a String cannot fail.
                let _ = write!(
                    text,
                    "; at stretch {} the first loading needs {} % more stress than this one",
                    significant(middle),
                    significant(100.0 * (virgin / later - 1.0))
                );
            }
        }
        findings.push(self.finding(FindingKind::SeveralLoadings, Severity::Note, &out, text));
        Some(format!("loading {number} of {}", loadings.len()))
    }

    /// First and last sample of every way up: to a turn by more than a tenth of the range. Of a test in compression, every way down.
    fn ways(&self, places: &[usize]) -> Vec<(usize, usize)> {
        let of = |i: usize| self.stretch[i];
        let range = places.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |r, i| (r.0.min(of(*i)), r.1.max(of(*i))));
        let turn = 0.1 * (range.1 - range.0);
        let outwards = if range.1 - 1.0 >= 1.0 - range.0 { 1.0 } else { -1.0 };
        let mut ways = Vec::new();
        let Some(&first) = places.first() else { return ways };
        // The lowest since the last way ended, and the highest since then.
        let (mut low, mut high) = (first, first);
        let mut rising = false;
        let height = |i: usize| outwards * of(i);
        for &i in places {
            if rising {
                if height(i) >= height(high) {
                    high = i;
                } else if height(high) - height(i) > turn {
                    ways.push((low, high));
                    (rising, low) = (false, i);
                }
            } else if height(i) < height(low) {
                low = i;
            } else if height(i) - height(low) > turn {
                (rising, high) = (true, i);
            }
        }
        if rising {
            ways.push((low, high));
        }
        ways
    }

    /// Leaves out what comes after the strip broke.
    pub fn rupture(&self, used: &mut [bool], findings: &mut Vec<Finding>) {
        let places: Vec<usize> = (0..used.len()).filter(|i| used[*i]).collect();
        let size = |i: &usize| self.stress_pa[*i].abs();
        let Some(peak) = (0..places.len()).max_by(|a, b| size(&places[*a]).total_cmp(&size(&places[*b]))) else {
            return;
        };
        let limit = 0.5 * size(&places[peak]);
        let after = &places[peak + 1..];
        // From the fall on nothing comes back.
        let Some(falls) = after.iter().position(|i| size(i) < limit) else { return };
        if after[falls..].iter().any(|i| size(i) > limit) {
            return;
        }
        let out: Vec<usize> = after.to_vec();
        for i in &out {
            used[*i] = false;
        }
        let text = format!(
            "the load falls below half of its largest and does not come back: the strip broke or left its grips; the {} samples after the largest load, from line {}, are left out",
            out.len(),
            self.line(out[0])
        );
        findings.push(self.finding(FindingKind::Rupture, Severity::Excluded, &out, text));
    }

    /// Falls of the load while the strip gets longer.
    pub fn slippage(&self, used: &[bool], findings: &mut Vec<Finding>) {
        let places: Vec<usize> = (0..used.len()).filter(|i| used[*i]).collect();
        if places.len() < 8 {
            return;
        }
        let bends: Vec<f64> = places
            .windows(3)
            .map(|w| (self.stress_pa[w[0]] - 2.0 * self.stress_pa[w[1]] + self.stress_pa[w[2]]).abs())
            .collect();
        // Second differences of white scatter are sqrt(6) as large, and their median size is 0.6745 of one.
        let scatter = median(bends) / 0.6745 / 6.0_f64.sqrt();
        let limit = (SLIP_SCATTERS * scatter).max(SLIP_SHARE * self.largest_stress(used));
        let sense = |i: usize| self.stress_pa[i].signum();
        let falls: Vec<usize> = places
            .windows(2)
            .filter(|w| {
                let longer = sense(w[1]) * (self.stretch[w[1]] - self.stretch[w[0]]) >= 0.0;
                longer && sense(w[0]) * (self.stress_pa[w[0]] - self.stress_pa[w[1]]) > limit
            })
            .map(|w| w[1])
            .collect();
        let Some(&first) = falls.first() else { return };
        let fall =
            places.windows(2).find(|w| w[1] == first).map_or(0.0, |w| self.stress_pa[w[0]] - self.stress_pa[first]);
        let text = format!(
            "the load falls at {} places while the strip gets longer, first by {} kPa on line {}: it slipped in its grips, and every later stretch is too large by what slipped; nothing is corrected",
            falls.len(),
            significant(1e-3 * fall),
            self.line(first)
        );
        findings.push(self.finding(FindingKind::Slippage, Severity::Note, &falls, text));
    }

    /// A toe: stiffness that grows at the beginning, where that of every elastomer falls.
    pub fn slack(&self, used: &[bool], findings: &mut Vec<Finding>) {
        let places: Vec<usize> = (0..used.len()).filter(|i| used[*i]).collect();
        // A toe is looked for in the first tenth of the stress, and needs some samples to be seen.
        let largest = self.largest_stress(used);
        let range: f64 = places.iter().map(|i| (self.stretch[*i] - 1.0).abs()).fold(0.0, f64::max);
        let below = |share: f64| places.iter().take_while(|i| self.stress_pa[**i].abs() < share * largest).count();
        let near = |i: &usize| (self.stretch[*i] - 1.0).abs() < 0.25 * range.max(0.2);
        let count = places.iter().take_while(|i| near(i)).count();
        if count < 8 {
            return;
        }
        let slope = |part: &[usize]| line(part.iter().map(|i| (self.stretch[*i], self.stress_pa[*i])));
        let block = (count / 6).max(3);
        let blocks: Vec<(f64, f64, usize)> = (0..count.saturating_sub(block - 1))
            .step_by((block / 2).max(1))
            .filter_map(|start| slope(&places[start..start + block]).map(|(s, at)| (s, at, start)))
            .collect();
        let Some(first) = blocks.first() else { return };
        let Some(steepest) = blocks.iter().max_by(|a, b| a.0.total_cmp(&b.0)) else { return };
        // Half the later stiffness at the beginning is a toe; scatter is not.
        if steepest.2 == 0 || first.0 > 0.5 * steepest.0 || below(0.005) == 0 {
            return;
        }
        let from = steepest.1;
        if (from - 1.0).abs() < 0.002 {
            return;
        }
        let toe: Vec<usize> =
            places.iter().copied().filter(|i| (self.stretch[*i] - 1.0).abs() < (from - 1.0).abs()).collect();
        let text = format!(
            "the strip hangs slack at the beginning: its stiffness grows from {} to {} kPa where that of an elastomer falls, and a line through its steepest part meets zero at stretch {}; every stretch is too large by about {} %; nothing is moved: correct the gauge length, or leave out the beginning with --stretch-min",
            significant(1e-3 * first.0),
            significant(1e-3 * steepest.0),
            significant(from),
            significant(100.0 * (from - 1.0))
        );
        findings.push(self.finding(FindingKind::SlackToe, Severity::Note, &toe, text));
    }

    /// A stiffness that no elastomer has.
    pub fn stiffness(&self, used: &[bool], findings: &mut Vec<Finding>) {
        let range =
            self.stretch.iter().zip(used).filter(|(_, used)| **used).map(|(l, _)| (l - 1.0).abs()).fold(0.0, f64::max);
        let near = |i: &usize| used[*i] && (self.stretch[*i] - 1.0).abs() <= (0.2 * range).max(0.1);
        let points = (0..used.len()).filter(near).map(|i| (self.stretch[i], self.stress_pa[i]));
        let (mut top, mut bottom) = (0.0, 0.0);
        for (stretch, stress) in points {
            top += (stretch - 1.0) * stress;
            bottom += (stretch - 1.0).powi(2);
        }
        let modulus = top / bottom;
        if !modulus.is_finite() || (MODULUS_MIN_PA..=MODULUS_MAX_PA).contains(&modulus) {
            return;
        }
        let unit = if modulus < MODULUS_MIN_PA {
            "kPa may be MPa, or a section too large"
        } else {
            "MPa may be kPa, or a section too small"
        };
        let text = format!(
            "the stiffness at small stretch is {} kPa; elastomers lie between {} and {} kPa: {unit}",
            significant(1e-3 * modulus),
            significant(1e-3 * MODULUS_MIN_PA),
            significant(1e-3 * MODULUS_MAX_PA)
        );
        findings.push(self.finding(FindingKind::ImplausibleStiffness, Severity::Note, &[], text));
    }
}

/// Slope of a line through points, and where it meets zero.
fn line(points: impl Iterator<Item = (f64, f64)>) -> Option<(f64, f64)> {
    let points: Vec<(f64, f64)> = points.collect();
    let n = points.len() as f64;
    let (x, y) = points.iter().fold((0.0, 0.0), |sum, p| (sum.0 + p.0 / n, sum.1 + p.1 / n));
    let (top, bottom) =
        points.iter().fold((0.0, 0.0), |sum, p| (sum.0 + (p.0 - x) * (p.1 - y), sum.1 + (p.0 - x) * (p.0 - x)));
    let slope = top / bottom;
    slope.is_finite().then(|| (slope, x - y / slope))
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(0.0)
}
