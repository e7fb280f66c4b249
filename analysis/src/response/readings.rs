//! From the channels of one run to readings: at every sample, or over every plateau.
//!
//! Plateaus are found on the stream of the pressures. What is measured may stand on other streams: its reading is then the mean of its
//! own samples that are stamped within the plateau's window, from the first to the last sample of the window, both included. Nothing is
//! interpolated; a window without a sample is a hole.
//!
//! Where a motion is late and nobody knows whether by its clock or by the specimen, what is stamped within the window was there, or is the
//! answer to the pressure, so much earlier: a plateau is read only if its window, moved back by that, still lies in it. Where its stamps
//! may be off either way, samples that near to an end of the window are not taken.

use pneuval_ingest::manifest::{PointRule, ResponseSpec};
use pneuval_ingest::session::Stream;

use super::census::{Census, TableCensus, Unmet, Unsure};
use super::plateaus::{GAP_STEPS, Plateau, plateaus, rounding_s};
use crate::align::{AlignedRun, Reach, Slack};

/// Fewer samples of a window say nothing of how it moves.
const CREEP_SAMPLES_MIN: usize = 8;

/// Measured conditions so near each other, as a share of the largest, are one setting.
pub(super) const SETTING_SHARE: f64 = 0.01;

/// A point of one run, before repeats meet.
#[derive(Debug, Clone)]
pub(super) struct Reading {
    /// Index of the run.
    pub run: usize,
    pub line: usize,
    /// Stamp of its first sample; not a number where there is no clock.
    pub seconds: f64,
    pub pressures: Vec<f64>,
    pub conditions: Vec<f64>,
    /// A component without a number makes the reading a hole, which still takes its turn.
    pub measured: Vec<f64>,
    /// By how much each component moved from the beginning to the end of the window, with its standard uncertainty.
    pub creep: Vec<Option<(f64, f64)>>,
}

/// The channels of a run that a response needs.
pub(super) struct Needed<'a> {
    /// Their streams, that of pressures and conditions first.
    parts: Vec<Part<'a>>,
    pressures: Vec<&'a [f64]>,
    conditions: Vec<&'a [f64]>,
    /// Each with the place of its stream among the parts.
    measured: Vec<(usize, &'a [f64])>,
}

/// A stream, and every channel needed of it.
struct Part<'a> {
    stream: &'a Stream,
    /// Its stamps, on the clock of the pressures where that is known.
    seconds: Option<&'a [f64]>,
    /// How late what it shows may be, in s.
    late_s: f64,
    /// How far off its stamps may be, either way.
    slack: Slack,
    channels: Vec<&'a [f64]>,
}

impl Part<'_> {
    fn is_stamped(&self, i: usize) -> bool {
        self.seconds.is_none_or(|seconds| seconds[i].is_finite())
    }

    /// Whether the stamp of a sample counts and all that is needed of it are numbers.
    fn is_whole(&self, i: usize) -> bool {
        self.is_stamped(i) && self.channels.iter().all(|c| c[i].is_finite())
    }

    fn whole(&self) -> Vec<usize> {
        (0..self.stream.samples).filter(|&i| self.is_whole(i)).collect()
    }
}

impl<'a> Needed<'a> {
    /// `None` if the run lacks a channel, or if its channels cannot be set against each other.
    pub fn of(aligned: &'a AlignedRun, spec: &ResponseSpec) -> Option<Self> {
        let run = aligned.run;
        let is_one = run.stream_of(spec.channels()).is_some();
        if !is_one && !spec.points.is_timed() {
            return None;
        }
        // What is measured may stand alone: a movement at equal time needs no pressure.
        let lead = if is_one { spec.channels().next()? } else { spec.state_channels().next()? };
        let state = run.channels.get(lead)?.stream;
        if !is_one {
            run.stream_of(spec.state_channels())?;
        }
        let mut parts: Vec<Part<'a>> = Vec::new();
        let mut indices: Vec<usize> = Vec::new();
        let mut take = |id: &str| -> Option<(usize, &'a [f64])> {
            let channel = run.channels.get(id)?;
            let stream = channel.stream;
            let at = indices.iter().position(|known| *known == stream).unwrap_or(parts.len());
            if at == parts.len() {
                let (late_s, slack) = match aligned.reach(spec, state, stream) {
                    Reach::Known(_) if stream == state => (0.0, Slack::default()),
                    Reach::Known(slack) => (0.0, slack),
                    Reach::Late(late_s) => (late_s, Slack::default()),
                    Reach::Apart => return None,
                };
                let seconds = aligned.seconds(stream);
                parts.push(Part { stream: run.streams.get(stream)?, seconds, late_s, slack, channels: vec![] });
                indices.push(stream);
            }
            parts[at].channels.push(&channel.values_si);
            Some((at, channel.values_si.as_slice()))
        };
        let pressures = spec.pressure.iter().map(|(id, _)| Some(take(id)?.1)).collect::<Option<_>>()?;
        let conditions = spec.conditions.iter().map(|c| Some(take(&c.channel)?.1)).collect::<Option<_>>()?;
        let measured = spec.measured.iter().map(|id| take(id)).collect::<Option<_>>()?;
        Some(Self { parts, pressures, conditions, measured })
    }

    /// Adds its samples and holes.
    pub fn count(&self, census: &mut Census) {
        for part in &self.parts {
            let samples = part.stream.samples;
            let holes = (0..samples).filter(|&i| !part.is_whole(i)).count();
            census.samples += samples;
            census.holes += holes;
            if self.parts.len() > 1 {
                census.add(TableCensus { table: part.stream.title(), samples, holes });
            }
        }
    }

    /// Whether the state of a sample is known: its stamp counts, and pressures and conditions are numbers.
    fn is_state(&self, i: usize) -> bool {
        self.parts[0].is_stamped(i) && self.pressures.iter().chain(&self.conditions).all(|c| c[i].is_finite())
    }

    /// The readings of a run, which is number `number`.
    pub fn read(&self, (number, run): (usize, &str), spec: &ResponseSpec, census: &mut Census) -> Vec<Reading> {
        let first = &self.parts[0];
        let stretches: Vec<Plateau> = match &spec.points {
            PointRule::Samples { .. } | PointRule::Trajectory(_) => {
                let every = if let PointRule::Trajectory(rule) = &spec.points { rule.every } else { 1 };
                let stamp = |i: usize| first.seconds.map_or(f64::NAN, |seconds| seconds[i]);
                let states = (0..first.stream.samples).filter(|&i| self.is_state(i)).step_by(every);
                states.map(|i| Plateau { from_s: stamp(i), window: vec![i] }).collect()
            }
            PointRule::Windows { begin_s, window_s, .. } => {
                let mut windows = Windows::of(first);
                let from_s = windows.begin_s();
                let stretch = |begin: &f64| {
                    let reach = (from_s + begin, from_s + begin + window_s);
                    // What stands before a declared window nobody says.
                    Plateau { from_s: reach.0, window: windows.whole_rows(reach) }
                };
                let found: Vec<Plateau> = begin_s.iter().map(stretch).collect();
                census.unmet.extend(windows.unmet(run));
                found
            }
            &PointRule::Plateaus { tolerance_pa, hold_s, window_s } => {
                let Some(seconds) = first.seconds else { return vec![] };
                let mut steady: Vec<(&[f64], f64)> = self.pressures.iter().map(|p| (*p, tolerance_pa)).collect();
                steady.extend(self.conditions.iter().map(|c| (*c, SETTING_SHARE * largest(c))));
                plateaus(&first.whole(), seconds, &steady, hold_s, window_s)
            }
        };
        let mut others: Vec<Windows> = self.parts.iter().skip(1).map(Windows::of).collect();
        let mut readings = Vec::with_capacity(stretches.len());
        for Plateau { from_s, window: rows } in stretches {
            let Some((&start, &end)) = rows.first().zip(rows.last()) else { continue };
            let stamp = |i: usize| first.seconds.map_or(f64::NAN, |seconds| seconds[i]);
            // A reading that may belong to what was before the plateau is none, of any component.
            let mut is_unsure = false;
            for other in &mut others {
                is_unsure |= other.is_unsure(from_s, (stamp(start), stamp(end)));
            }
            if is_unsure {
                continue;
            }
            census.used += rows.iter().filter(|&&i| first.is_whole(i)).count();
            let mut of_parts = vec![rows];
            for other in &mut others {
                of_parts.push(other.rows((stamp(start), stamp(end)), census));
            }
            let rows = &of_parts[0];
            readings.push(Reading {
                run: number,
                line: first.stream.lines.line_of(start),
                seconds: stamp(start),
                pressures: self.pressures.iter().map(|c| mean(c, rows)).collect(),
                conditions: self.conditions.iter().map(|c| mean(c, rows)).collect(),
                measured: self.measured.iter().map(|(part, c)| mean(c, &of_parts[*part])).collect(),
                creep: self.measured.iter().map(|(part, c)| self.creep(*part, c, &of_parts[*part])).collect(),
            });
        }
        census.unsure.extend(others.iter().filter_map(|other| other.unsure(run)));
        census.unmet.extend(others.into_iter().filter_map(|other| other.unmet(run)));
        readings
    }
}

impl Needed<'_> {
    /// By how much a channel moves over the samples of a window: the slope of the straight line through them times their span, with
    /// the standard uncertainty that their scatter about the line gives.
    fn creep(&self, part: usize, values: &[f64], rows: &[usize]) -> Option<(f64, f64)> {
        let seconds = self.parts[part].stream.seconds.as_ref()?;
        if rows.len() < CREEP_SAMPLES_MIN {
            return None;
        }
        let n = rows.len() as f64;
        let (t0, y0) = (mean(seconds, rows), mean(values, rows));
        let sum = |of: &dyn Fn(f64, f64) -> f64| rows.iter().map(|&i| of(seconds[i] - t0, values[i] - y0)).sum::<f64>();
        let (tt, ty, yy) = (sum(&|t, _| t * t), sum(&|t, y| t * y), sum(&|_, y| y * y));
        let slope = ty / tt;
        let span = seconds[*rows.last()?] - seconds[*rows.first()?];
        let scatter = ((yy - slope * ty).max(0.0) / (n - 2.0) / tt).sqrt();
        slope.is_finite().then_some((slope * span, scatter * span))
    }
}

/// The samples of a stream that count, to be asked for by windows of time that rise.
struct Windows<'a> {
    stream: &'a Stream,
    seconds: &'a [f64],
    whole: Vec<usize>,
    /// How many of them lay in windows or before them.
    passed: usize,
    /// From the first window to the last.
    reach_s: Option<(f64, f64)>,
    /// Windows, and those of them in which nothing lay.
    asked: usize,
    empty: usize,
    /// How late its samples may be, in s, and plateaus that are too short for that.
    late_s: f64,
    /// How far off its stamps may be, either way, and the most of it that kept a window from being read, in s.
    slack: Slack,
    either_s: f64,
    too_short: usize,
}

impl<'a> Windows<'a> {
    fn of(part: &Part<'a>) -> Self {
        let seconds = part.seconds.unwrap_or_default();
        // Without stamps nothing lies in any window.
        let whole = if part.seconds.is_some() { part.whole() } else { vec![] };
        let &Part { stream, late_s, slack, .. } = part;
        let (asked, empty, too_short) = (0, 0, 0);
        Self { stream, seconds, whole, passed: 0, reach_s: None, asked, empty, late_s, slack, either_s: 0.0, too_short }
    }

    /// The first stamp that counts.
    fn begin_s(&self) -> f64 {
        self.whole.first().map_or(0.0, |&i| self.seconds[i])
    }

    /// The samples that were taken from `first_s` to `last_s`, however far off their stamps may be. Stamps that count never go back.
    fn rows(&mut self, (first_s, last_s): (f64, f64), census: &mut Census) -> Vec<usize> {
        // One instant, stamped by two devices, is still one.
        let either_s = self.slack.at(f64::midpoint(first_s, last_s));
        let slack = rounding_s(first_s.abs().max(last_s.abs())) - either_s;
        let begin = self.whole.partition_point(|&i| self.seconds[i] < first_s - slack);
        let end = self.whole.partition_point(|&i| self.seconds[i] <= last_s + slack).max(begin);
        // Two windows may share a stamp: its samples are counted once.
        census.used += end.saturating_sub(self.passed.max(begin));
        self.passed = self.passed.max(end);
        self.reach_s = Some((self.reach_s.map_or(first_s, |(first, _)| first), last_s));
        self.asked += 1;
        self.empty += usize::from(begin == end);
        self.whole[begin..end].to_vec()
    }

    /// Whether what is stamped in a window may belong to what was before its plateau, or all of it to what is beyond.
    fn is_unsure(&mut self, from_s: f64, (first_s, last_s): (f64, f64)) -> bool {
        let either_s = self.slack.at(f64::midpoint(first_s, last_s));
        let slack = rounding_s(first_s.abs().max(last_s.abs()));
        let count = |from_s: f64, to_s: f64| {
            let begin = self.whole.partition_point(|&i| self.seconds[i] < from_s - slack);
            self.whole.partition_point(|&i| self.seconds[i] <= to_s + slack).saturating_sub(begin)
        };
        // Samples lie in it, and none of them surely.
        let nothing_left = either_s > 0.0
            && (last_s - first_s < 2.0 * either_s
                || (count(first_s, last_s) > 0 && count(first_s + either_s, last_s - either_s) == 0));
        let unsure = first_s - self.late_s < from_s - rounding_s(first_s) || nothing_left;
        if nothing_left {
            self.either_s = self.either_s.max(either_s);
        }
        self.too_short += usize::from(unsure);
        unsure
    }

    /// Plateaus that are too short for the lag.
    fn unsure(&self, run: &str) -> Option<Unsure> {
        (self.too_short > 0).then(|| Unsure {
            run: run.to_owned(),
            device: self.stream.device.clone(),
            table: self.stream.title(),
            plateaus: self.asked + self.too_short,
            unsure: self.too_short,
            late_s: self.late_s,
            either_s: self.either_s,
            leads: self.slack.leads_s >= self.either_s && self.either_s > 0.0,
        })
    }

    /// Those of a declared window; none where the stamps end within it, or begin there: half of it is another mean.
    fn whole_rows(&mut self, reach: (f64, f64)) -> Vec<usize> {
        let rows = self.rows(reach, &mut Census::default());
        let stamp = |i: Option<&usize>| i.map_or(f64::NAN, |&i| self.seconds[i]);
        let (first, last) = (stamp(self.whole.first()), stamp(self.whole.last()));
        let step_s = (last - first) / self.whole.len().saturating_sub(1).max(1) as f64;
        let is_cut = reach.0 < first - GAP_STEPS * step_s || last + GAP_STEPS * step_s < reach.1;
        if !is_cut || rows.is_empty() {
            return rows;
        }
        self.empty += 1;
        vec![]
    }

    /// Plateaus at which nothing was stamped.
    fn unmet(self, run: &str) -> Option<Unmet> {
        let stamp = |i: Option<&usize>| i.map(|&i| self.seconds[i]);
        (self.empty > 0).then(|| Unmet {
            run: run.to_owned(),
            device: self.stream.device.clone(),
            table: self.stream.title(),
            plateaus: self.asked,
            unmet: self.empty,
            plateaus_s: self.reach_s.unwrap_or_default(),
            table_s: stamp(self.whole.first()).zip(stamp(self.whole.last())),
        })
    }
}

/// The mean at some samples; not a number where there is none.
fn mean(values: &[f64], rows: &[usize]) -> f64 {
    rows.iter().map(|&i| values[i]).sum::<f64>() / rows.len() as f64
}

/// The largest size among finite values.
fn largest(values: &[f64]) -> f64 {
    values.iter().filter(|v| v.is_finite()).fold(0.0, |m: f64, v| m.max(v.abs()))
}
