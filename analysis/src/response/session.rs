//! From the channels of a session to points of a response.
//!
//! Every sample of a log of steady states is a point, or every plateau of the pressure is: the mean over its end. Points of
//! several runs at equal pressure and conditions are repeats of one point.
//!
//! With n >= 2 repeats of mean m and standard deviation s the interval of m is
//! `± √((t s/√n)² + (2 u)²)`, t the 97.5 % quantile of Student's distribution with n - 1 degrees of freedom and u the standard
//! uncertainty that the instrument declares (0 if it declares none): the instrument's error is common to the repeats, so it
//! does not shrink with their number. One repeat has no scatter: `± 2 u`, or nothing at all.

use std::collections::HashMap;

use statrs::distribution::{ContinuousCDF, StudentsT};

use pneuval_ingest::manifest::{Condition, PointRule, ResponseSpec};
use pneuval_ingest::number::Printed;
use pneuval_ingest::session::{Run, Session};

use super::{IntervalKind, Response, ResponsePoint};
use crate::verdict::Basis;

/// Points of a response at most: beyond it a log is a trajectory, not a set of steady states.
pub const POINTS_MAX: usize = 20_000;

/// Measured pressures are never exactly zero: so near, as a share of the largest, they are the reference.
const ZERO_SHARE: f64 = 0.005;

/// A point of one run, before repeats meet.
struct Reading {
    run: String,
    line: usize,
    pressures: Vec<f64>,
    conditions: Vec<f64>,
    measured: Vec<f64>,
}

/// What became of the samples of a session on their way to points.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Census {
    /// Samples of the response's channels.
    pub samples: usize,
    /// Samples with a hole in one of the channels needed.
    pub holes: usize,
    /// Samples that lie in a point.
    pub used: usize,
}

impl Response {
    /// The response that a session declares, and what became of its samples.
    pub fn from_session(session: &Session, spec: &ResponseSpec) -> (Self, Census) {
        let mut census = Census::default();
        let mut readings = Vec::new();
        for run in &session.runs {
            readings.extend(read(run, spec, &mut census));
        }
        let std_si = std_of(session, spec);
        let tolerance_pa = match spec.points {
            PointRule::Samples => 0.0,
            PointRule::Plateaus { tolerance_pa, .. } => tolerance_pa,
        };
        let conditions = spec
            .conditions
            .iter()
            .map(|c| Condition {
                id: c.id.clone(),
                title: c.title.clone(),
                unit: session
                    .runs
                    .iter()
                    .find_map(|run| run.channels.get(&c.channel))
                    .map_or(spec.quantity.unit, |channel| channel.unit),
            })
            .collect();
        let commanded = spec.pressure.iter().any(|(channel, _)| {
            session.runs.iter().filter_map(|run| run.channels.get(channel)).any(|channel| channel.commanded)
        });
        let mut source = format!("session {}", session.manifest.title);
        if !spec.method.is_empty() {
            source.extend(["; ", &spec.method]);
        }
        if commanded {
            source += "; the pressure is commanded, not measured";
        }
        let points = points(readings, tolerance_pa, &std_si);
        let largest = points.iter().flat_map(|p| &p.pressures_gauge_pa).map(|p| p.abs()).fold(0.0, f64::max);
        let response = Self {
            quantity: spec.quantity.clone(),
            basis: Basis::Session,
            source,
            chambers: spec.pressure.iter().map(|(_, chamber)| chamber.clone()).collect(),
            conditions,
            zero_within_pa: spec.zero_within_pa.unwrap_or(ZERO_SHARE * largest),
            points,
            columns: vec![],
            texts: vec![],
        };
        (response, census)
    }
}

/// The instruments' standard uncertainty of each component; `None` where one declares none.
fn std_of(session: &Session, spec: &ResponseSpec) -> Vec<Option<f64>> {
    let channel = |id: &String| session.runs.iter().find_map(|run| run.channels.get(id));
    spec.measured.iter().map(|id| channel(id).and_then(|c| c.std_si)).collect()
}

/// The readings of one run.
fn read(run: &Run, spec: &ResponseSpec, census: &mut Census) -> Vec<Reading> {
    let values = |ids: &[&String]| -> Option<Vec<&[f64]>> {
        ids.iter().map(|id| run.channels.get(*id).map(|c| c.values_si.as_slice())).collect()
    };
    let (Some(pressures), Some(measured), Some(conditions)) = (
        values(&spec.pressure.iter().map(|(channel, _)| channel).collect::<Vec<_>>()),
        values(&spec.measured.iter().collect::<Vec<_>>()),
        values(&spec.conditions.iter().map(|c| &c.channel).collect::<Vec<_>>()),
    ) else {
        // Every channel of the manifest is read in every run.
        return vec![];
    };
    let samples = run.samples;
    let whole = |i: usize| pressures.iter().chain(&measured).chain(&conditions).all(|c| c[i].is_finite());
    census.samples += samples;
    census.holes += (0..samples).filter(|&i| !whole(i)).count();
    let mean = |channels: &[&[f64]], rows: &[usize]| -> Vec<f64> {
        channels.iter().map(|c| rows.iter().map(|&i| c[i]).sum::<f64>() / rows.len() as f64).collect()
    };
    let stretches: Vec<Vec<usize>> = match spec.points {
        PointRule::Samples => (0..samples).filter(|&i| whole(i)).map(|i| vec![i]).collect(),
        PointRule::Plateaus { tolerance_pa, hold_s, window_s } => {
            let Some(seconds) = &run.seconds else { return vec![] };
            let usable: Vec<usize> = (0..samples).filter(|&i| whole(i) && seconds[i].is_finite()).collect();
            plateaus(&usable, seconds, &pressures, tolerance_pa, hold_s, window_s)
        }
    };
    let mut readings: Vec<Reading> = Vec::new();
    for rows in stretches {
        let Some(&first) = rows.first() else { continue };
        census.used += rows.len();
        readings.push(Reading {
            run: run.id.clone(),
            line: run.lines.line_of(first),
            pressures: mean(&pressures, &rows),
            conditions: mean(&conditions, &rows),
            measured: mean(&measured, &rows),
        });
    }
    readings
}

/// The ends of stretches in which every pressure stays within a tolerance of its mean for long enough.
fn plateaus(
    usable: &[usize],
    seconds: &[f64],
    pressures: &[&[f64]],
    tolerance_pa: f64,
    hold_s: f64,
    window_s: f64,
) -> Vec<Vec<usize>> {
    let mut found = Vec::new();
    let mut start = 0;
    while start < usable.len() {
        // The range of a stretch is at most twice the tolerance: then every sample is within it of the middle.
        let mut low: Vec<f64> = pressures.iter().map(|p| p[usable[start]]).collect();
        let mut high = low.clone();
        let mut end = start;
        while end + 1 < usable.len() {
            let next = usable[end + 1];
            let fits = pressures
                .iter()
                .zip(low.iter().zip(&high))
                .all(|(p, (low, high))| high.max(p[next]) - low.min(p[next]) <= 2.0 * tolerance_pa);
            if !fits || seconds[next] < seconds[usable[end]] {
                break;
            }
            for (i, p) in pressures.iter().enumerate() {
                (low[i], high[i]) = (low[i].min(p[next]), high[i].max(p[next]));
            }
            end += 1;
        }
        let last = seconds[usable[end]];
        if last - seconds[usable[start]] >= hold_s {
            let inside = |i: &&usize| seconds[**i] >= last - window_s;
            found.push(usable[start..=end].iter().filter(inside).copied().collect());
            start = end + 1;
        } else {
            start += 1;
        }
    }
    found
}

/// Readings at equal pressures and conditions.
#[derive(Default)]
struct Alike {
    /// Their groups, in order.
    groups: Vec<usize>,
    /// How many of them each run has joined.
    joined: HashMap<String, usize>,
}

/// Readings of several runs at equal pressure and conditions become one point: the first of each run meets the first of the
/// others, the second the second. Equal is to the bit for logged states; for plateaus, within the tolerance that makes one.
fn points(readings: Vec<Reading>, tolerance_pa: f64, std_si: &[Option<f64>]) -> Vec<ResponsePoint> {
    let mut groups: Vec<Vec<Reading>> = Vec::new();
    if tolerance_pa > 0.0 {
        for reading in readings {
            let meets = |group: &&mut Vec<Reading>| {
                let Some(first) = group.first() else { return false };
                let near = first.pressures.iter().zip(&reading.pressures).all(|(a, b)| (a - b).abs() <= tolerance_pa);
                near && first.conditions == reading.conditions && group.iter().all(|r| r.run != reading.run)
            };
            match groups.iter_mut().find(meets) {
                Some(group) => group.push(reading),
                None => groups.push(vec![reading]),
            }
        }
    } else {
        let mut alike: HashMap<Vec<u64>, Alike> = HashMap::new();
        for reading in readings {
            let key = reading.pressures.iter().chain(&reading.conditions).map(|v| v.to_bits()).collect();
            let here = alike.entry(key).or_default();
            let turn = here.joined.entry(reading.run.clone()).or_default();
            if let Some(&group) = here.groups.get(*turn) {
                groups[group].push(reading);
            } else {
                here.groups.push(groups.len());
                groups.push(vec![reading]);
            }
            *turn += 1;
        }
    }
    groups.iter().filter_map(|group| point(group, std_si)).collect()
}

fn point(group: &[Reading], std_si: &[Option<f64>]) -> Option<ResponsePoint> {
    let first = group.first()?;
    let n = group.len() as f64;
    let mean = |of: fn(&Reading) -> &Vec<f64>| -> Vec<f64> {
        (0..of(first).len()).map(|i| group.iter().map(|r| of(r)[i]).sum::<f64>() / n).collect()
    };
    let instrument = |i: usize| std_si.get(i).copied().flatten();
    let measured = (0..first.measured.len())
        .map(|i| {
            let mean = group.iter().map(|r| r.measured[i]).sum::<f64>() / n;
            let declared = 2.0 * instrument(i).unwrap_or(0.0);
            let half_width_si = if group.len() < 2 {
                declared
            } else {
                let variance = group.iter().map(|r| (r.measured[i] - mean).powi(2)).sum::<f64>() / (n - 1.0);
                (student_975(group.len() - 1)? * (variance / n).sqrt()).hypot(declared)
            };
            Some(Printed { si: mean, half_width_si })
        })
        .collect::<Option<Vec<_>>>()?;
    let interval = if group.len() >= 2 {
        IntervalKind::Repeats
    } else if (0..first.measured.len()).all(|i| instrument(i).is_some()) {
        IntervalKind::Instrument
    } else {
        IntervalKind::Unknown
    };
    Some(ResponsePoint {
        line: first.line,
        runs: group.iter().map(|r| r.run.clone()).collect(),
        pressures_gauge_pa: mean(|r| &r.pressures),
        conditions: first.conditions.iter().map(|&si| Printed { si, half_width_si: 0.0 }).collect(),
        measured: Some(measured),
        interval,
    })
}

/// The 97.5 % quantile of Student's distribution; `None` without degrees of freedom.
fn student_975(freedom: usize) -> Option<f64> {
    StudentsT::new(0.0, 1.0, freedom as f64).ok().map(|t| t.inverse_cdf(0.975))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_stretch_of_steady_pressure_is_one_point_and_a_ramp_is_none() {
        // 0 to 1 s at 10 kPa, a ramp to 20 kPa until 2 s, 2 to 4 s at 20 kPa; 10 Hz.
        let seconds: Vec<f64> = (0..=40).map(|i| f64::from(i) / 10.0).collect();
        let pressure: Vec<f64> = seconds.iter().map(|t| 1e4 + 1e4 * (t - 1.0).clamp(0.0, 1.0)).collect();
        let usable: Vec<usize> = (0..=40).collect();
        let found = plateaus(&usable, &seconds, &[&pressure], 100.0, 0.9, 0.5);
        assert_eq!(found.len(), 2);
        assert_eq!((found[0].first(), found[0].last()), (Some(&5), Some(&10)));
        assert_eq!((found[1].first(), found[1].last()), (Some(&35), Some(&40)));
        assert!(plateaus(&usable, &seconds, &[&pressure], 100.0, 5.0, 0.5).is_empty());
    }

    #[test]
    fn repeats_give_an_interval_and_one_reading_gives_none() {
        let reading = |run: &str, pressure: f64, value: f64| Reading {
            run: run.to_owned(),
            line: 1,
            pressures: vec![pressure],
            conditions: vec![],
            measured: vec![value],
        };
        let found = points(vec![reading("a", 1e4, 1.0), reading("b", 1e4, 3.0), reading("a", 2e4, 5.0)], 0.0, &[None]);
        let value = |i: usize| found[i].measured.as_ref().unwrap()[0];
        assert_eq!(found[0].interval, IntervalKind::Repeats);
        // s = √2, n = 2: t s/√n = 12.706.
        assert!((value(0).si - 2.0).abs() < 1e-15 && (value(0).half_width_si - 12.706_204_736).abs() < 1e-9);
        assert_eq!((found[1].interval, value(1).half_width_si), (IntervalKind::Unknown, 0.0));
        let found = points(vec![reading("a", 1e4, 1.0)], 0.0, &[Some(0.25)]);
        assert_eq!(found[0].interval, IntervalKind::Instrument);
        assert!((found[0].measured.as_ref().unwrap()[0].half_width_si - 0.5).abs() < 1e-15);
    }
}
