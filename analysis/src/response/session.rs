//! From the channels of a session to points of a response.
//!
//! Every sample of a log of steady states is a point, or every plateau of the pressure is: the mean over its end. Points of
//! several runs at equal pressure and conditions are repeats of one point.
//!
//! With n >= 2 repeats of mean m and standard deviation s the interval of m is
//! `± √((t s/√n)² + (2 u)²)`, t the 97.5 % quantile of Student's distribution with n - 1 degrees of freedom and u the standard
//! uncertainty of the instrument: at least about 95 %. The instrument's error is taken as common to the repeats, so it does not
//! shrink with their number. One repeat has no scatter: `± 2 u`, or nothing at all. Repeats that agree to the last digit on an
//! instrument that declares nothing say nothing of how sure they are, and have no interval either.

use std::collections::HashMap;

use statrs::distribution::{ContinuousCDF, StudentsT};

use pneuval_ingest::manifest::{Condition, PointRule, ResponseSpec};
use pneuval_ingest::number::Printed;
use pneuval_ingest::session::Session;

use super::census::Census;
use super::readings::{Needed, Reading, SETTING_SHARE};
use super::{IntervalKind, Movement, Response, ResponsePoint};
use crate::trajectory::{Path, Sample};
use crate::verdict::Basis;

/// Points of a response at most: beyond it a log is a trajectory, not a set of steady states.
pub const POINTS_MAX: usize = 20_000;

/// Measured pressures are never exactly zero: so near, as a share of the largest, they are the reference.
const ZERO_SHARE: f64 = 0.005;

/// So near zero, as a share of the largest, a pressure is what rounding leaves of a difference, and is zero.
const ROUNDING_SHARE: f64 = 1e-9;

impl Response {
    /// The response that a session declares, and what became of its samples.
    ///
    /// # Errors
    /// The number of readings, if they are more than [`POINTS_MAX`] per run.
    pub fn from_session(session: &Session, spec: &ResponseSpec) -> Result<(Self, Census), usize> {
        let (names, runs): (Vec<&str>, Vec<Needed>) =
            session.runs.iter().filter_map(|run| Some((run.id.as_str(), Needed::of(session, run, spec)?))).unzip();
        let mut census = Census::default();
        for needed in &runs {
            needed.count(&mut census);
        }
        let states = census.samples - census.holes;
        let samples_per_point = match spec.points {
            PointRule::Samples { .. } => Some(1),
            PointRule::Trajectory(rule) if spec.points.path().is_none() => Some(rule.every),
            _ => None,
        };
        if let Some(points) = samples_per_point.map(|n| states / n).filter(|n| *n > POINTS_MAX * runs.len().max(1)) {
            return Err(points);
        }
        let mut readings = Vec::new();
        for (i, needed) in runs.iter().enumerate() {
            readings.extend(needed.read((i, names[i]), spec, &mut census));
        }
        let largest = readings.iter().flat_map(|r| &r.pressures).map(|p| p.abs()).fold(0.0, f64::max);
        let rounding_pa = ROUNDING_SHARE * largest;
        for pressure in readings.iter_mut().flat_map(|r| &mut r.pressures) {
            *pressure = without_rounding(*pressure, rounding_pa);
        }
        let same_within_pa = match spec.points {
            PointRule::Samples { same_within_pa } => same_within_pa,
            PointRule::Trajectory(_) => 0.0,
            PointRule::Plateaus { tolerance_pa, .. } => tolerance_pa,
        };
        let std_si = std_of(session, spec);
        let mut movement = None;
        let points = match spec.points {
            PointRule::Trajectory(rule) if spec.points.path().is_some() => {
                movement = Some(Movement { rule, std_si, paths: paths(readings, &names) });
                vec![]
            }
            // Loading and unloading, run by run: no sample is a repeat of another.
            PointRule::Trajectory(_) => {
                readings.into_iter().filter_map(|reading| point(&[reading], &std_si, &names)).collect()
            }
            _ => points(readings, same_within_pa, &std_si, &names),
        };
        if points.len() > POINTS_MAX {
            return Err(points.len());
        }
        let zero_within_pa = spec.zero_within_pa.unwrap_or(ZERO_SHARE * largest);
        let response = Self {
            quantity: spec.quantity.clone(),
            basis: Basis::Session,
            source: source(session, spec),
            chambers: spec.pressure.iter().map(|(_, chamber)| chamber.clone()).collect(),
            conditions: conditions(session, spec),
            zero_within_pa,
            // Two readings of one nominal pressure: as near as the reference is to zero, or as a plateau is to itself.
            same_within_pa: same_within_pa.max(zero_within_pa),
            rounding_pa,
            points,
            movement,
            columns: vec![],
            texts: vec![],
        };
        Ok((response, census))
    }
}

/// A gauge pressure, or zero where it is what rounding leaves of a difference.
pub fn without_rounding(pressure_gauge_pa: f64, rounding_pa: f64) -> f64 {
    if pressure_gauge_pa.abs() <= rounding_pa { 0.0 } else { pressure_gauge_pa }
}

fn source(session: &Session, spec: &ResponseSpec) -> String {
    let mut source = format!("session {}", session.manifest.title);
    if !spec.method.is_empty() {
        source.extend(["; ", &spec.method]);
    }
    let channels = |id: &String| session.runs.iter().filter_map(|run| run.channels.get(id)).any(|c| c.commanded);
    if spec.pressure.iter().any(|(channel, _)| channels(channel)) {
        source += "; the pressure is commanded, not measured";
    }
    if let PointRule::Trajectory(rule) = spec.points
        && rule.every > 1
    {
        source.extend(["; one of every ", &rule.every.to_string(), " samples"]);
    }
    source
}

fn conditions(session: &Session, spec: &ResponseSpec) -> Vec<Condition> {
    let unit = |channel: &String| session.runs.iter().find_map(|run| run.channels.get(channel)).map(|c| c.unit);
    spec.conditions
        .iter()
        .map(|c| Condition {
            id: c.id.clone(),
            title: c.title.clone(),
            unit: unit(&c.channel).unwrap_or(spec.quantity.unit),
        })
        .collect()
}

/// The instruments' standard uncertainty of each component; `None` where one declares none.
fn std_of(session: &Session, spec: &ResponseSpec) -> Vec<Option<f64>> {
    let channel = |id: &String| session.runs.iter().find_map(|run| run.channels.get(id));
    spec.measured.iter().map(|id| channel(id).and_then(|c| c.std_si)).collect()
}

/// Readings as the movement of each run.
fn paths(readings: Vec<Reading>, runs: &[&str]) -> Vec<Path> {
    let mut paths: Vec<Path> = runs.iter().map(|run| Path { run: (*run).to_owned(), samples: vec![] }).collect();
    for Reading { run, line, seconds, pressures, measured, .. } in readings {
        if let Some(path) = paths.get_mut(run) {
            path.samples.push(Sample { line, seconds, pressures, measured });
        }
    }
    paths
}

/// Readings at equal pressures and conditions.
#[derive(Default)]
struct Alike {
    /// Their groups, in order.
    groups: Vec<usize>,
    /// How many of them each run has joined.
    joined: HashMap<usize, usize>,
}

/// Readings of several runs at equal pressure and conditions become one point: the first of each run meets the first of the
/// others, the second the second, whether or not anything was measured at it. Equal is to the bit for logged states; else
/// within the tolerance, and conditions within 1 % of the largest.
fn points(readings: Vec<Reading>, same_within_pa: f64, std_si: &[Option<f64>], runs: &[&str]) -> Vec<ResponsePoint> {
    let mut groups: Vec<Vec<Reading>> = Vec::new();
    if same_within_pa > 0.0 {
        let settings = readings.first().map_or(0, |r| r.conditions.len());
        let near: Vec<f64> = (0..settings)
            .map(|i| SETTING_SHARE * readings.iter().map(|r| r.conditions[i].abs()).fold(0.0, f64::max))
            .collect();
        for reading in readings {
            let meets = |group: &&mut Vec<Reading>| {
                let Some(first) = group.first() else { return false };
                let pressures = first.pressures.iter().zip(&reading.pressures);
                let conditions = first.conditions.iter().zip(&reading.conditions).zip(&near);
                pressures.into_iter().all(|(a, b)| (a - b).abs() <= same_within_pa)
                    && conditions.into_iter().all(|((a, b), near)| (a - b).abs() <= *near)
                    && group.iter().all(|r| r.run != reading.run)
            };
            match groups.iter_mut().find(meets) {
                Some(group) => group.push(reading),
                None => groups.push(vec![reading]),
            }
        }
    } else {
        let mut alike: HashMap<Vec<u64>, Alike> = HashMap::new();
        for reading in readings {
            // Adding zero makes a negative zero a positive one.
            let bits = |v: &f64| (v + 0.0).to_bits();
            let key = reading.pressures.iter().chain(&reading.conditions).map(bits).collect();
            let here = alike.entry(key).or_default();
            let turn = here.joined.entry(reading.run).or_default();
            if let Some(&group) = here.groups.get(*turn) {
                groups[group].push(reading);
            } else {
                here.groups.push(groups.len());
                groups.push(vec![reading]);
            }
            *turn += 1;
        }
    }
    groups.iter().filter_map(|group| point(group, std_si, runs)).collect()
}

fn point(group: &[Reading], std_si: &[Option<f64>], runs: &[&str]) -> Option<ResponsePoint> {
    let whole: Vec<&Reading> = group.iter().filter(|r| r.measured.iter().all(|v| v.is_finite())).collect();
    let first = *whole.first()?;
    let n = whole.len() as f64;
    let mean = |of: fn(&Reading) -> &Vec<f64>| -> Vec<f64> {
        (0..of(first).len()).map(|i| whole.iter().map(|r| of(r)[i]).sum::<f64>() / n).collect()
    };
    let instrument = |i: usize| std_si.get(i).copied().flatten();
    let measured = (0..first.measured.len())
        .map(|i| {
            let mean = whole.iter().map(|r| r.measured[i]).sum::<f64>() / n;
            let declared = 2.0 * instrument(i).unwrap_or(0.0);
            let half_width_si = if whole.len() < 2 {
                declared
            } else {
                let variance = whole.iter().map(|r| (r.measured[i] - mean).powi(2)).sum::<f64>() / (n - 1.0);
                (student_975(whole.len() - 1)? * (variance / n).sqrt()).hypot(declared)
            };
            // Beyond what a double can hold nothing is known: not a number, which is never judged.
            let si = if half_width_si.is_finite() { mean } else { f64::NAN };
            Some(Printed { si, half_width_si })
        })
        .collect::<Option<Vec<_>>>()?;
    let widths = measured.iter().all(|m| m.half_width_si > 0.0);
    let interval = if whole.len() >= 2 && widths {
        IntervalKind::Repeats
    } else if (0..first.measured.len()).all(|i| instrument(i).is_some()) {
        IntervalKind::Instrument
    } else {
        IntervalKind::Unknown
    };
    Some(ResponsePoint {
        line: first.line,
        runs: whole.iter().filter_map(|r| runs.get(r.run)).map(|run| (*run).to_owned()).collect(),
        pressures_gauge_pa: mean(|r| &r.pressures),
        at: None,
        conditions: mean(|r| &r.conditions).into_iter().map(|si| Printed { si, half_width_si: 0.0 }).collect(),
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

    fn reading(run: usize, pressure: f64, value: f64) -> Reading {
        Reading {
            run,
            line: 1,
            seconds: f64::NAN,
            pressures: vec![pressure],
            conditions: vec![],
            measured: vec![value],
        }
    }

    fn value(point: &ResponsePoint) -> Printed {
        point.measured.as_ref().unwrap()[0]
    }

    const RUNS: [&str; 2] = ["a", "b"];

    #[test]
    fn repeats_give_an_interval_and_one_reading_gives_none() {
        let found = points(vec![reading(0, 1e4, 1.0), reading(1, 1e4, 3.0), reading(0, 2e4, 5.0)], 0.0, &[None], &RUNS);
        assert_eq!(found[0].interval, IntervalKind::Repeats);
        // s = √2, n = 2: t s/√n = 12.706.
        assert!((value(&found[0]).si - 2.0).abs() < 1e-15);
        assert!((value(&found[0]).half_width_si - 12.706_204_736).abs() < 1e-9);
        assert_eq!((found[1].interval, value(&found[1]).half_width_si), (IntervalKind::Unknown, 0.0));
        let found = points(vec![reading(0, 1e4, 1.0)], 0.0, &[Some(0.25)], &RUNS);
        assert_eq!(found[0].interval, IntervalKind::Instrument);
        assert!((value(&found[0]).half_width_si - 0.5).abs() < 1e-15);
    }

    #[test]
    fn equal_readings_of_an_instrument_that_declares_nothing_have_no_interval() {
        let found = points(vec![reading(0, 1e4, 3.0), reading(1, 1e4, 3.0)], 0.0, &[None], &RUNS);
        assert_eq!(found[0].interval, IntervalKind::Unknown);
        let found = points(vec![reading(0, 1e4, 3.0), reading(1, 1e4, 3.0)], 0.0, &[Some(0.1)], &RUNS);
        assert_eq!(found[0].interval, IntervalKind::Repeats);
    }

    #[test]
    fn a_hole_takes_its_turn_so_that_loading_does_not_meet_unloading() {
        // Up and down through 20 kPa in both runs; the second run's way up was not measured.
        let all = vec![reading(0, 2e4, 8.0), reading(0, 2e4, 12.0), reading(1, 2e4, f64::NAN), reading(1, 2e4, 12.2)];
        let found = points(all, 0.0, &[None], &RUNS);
        assert_eq!(found.len(), 2);
        assert!((value(&found[0]).si - 8.0).abs() < 1e-12 && found[0].runs == ["a"]);
        assert!((value(&found[1]).si - 12.1).abs() < 1e-12 && found[1].runs == ["a", "b"]);
    }

    #[test]
    fn measured_pressures_within_the_tolerance_are_repeats() {
        let found = points(vec![reading(0, 20.0e3, 8.0), reading(1, 20.1e3, 8.2)], 200.0, &[None], &RUNS);
        assert_eq!(found.len(), 1);
        assert!((found[0].pressures_gauge_pa[0] - 20.05e3).abs() < 1e-9);
        assert_eq!(points(vec![reading(0, 20.0e3, 8.0), reading(1, 20.1e3, 8.2)], 50.0, &[None], &RUNS).len(), 2);
        // A negative zero is a zero.
        assert_eq!(points(vec![reading(0, 0.0, 8.0), reading(1, -0.0, 8.2)], 0.0, &[None], &RUNS).len(), 1);
    }

    #[test]
    fn what_overflows_is_no_number() {
        let found = points(vec![reading(0, 1e4, 1e308), reading(1, 1e4, -1e308)], 0.0, &[None], &RUNS);
        assert!(value(&found[0]).si.is_nan());
    }
}
