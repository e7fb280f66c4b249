//! From the channels of a session to points of a response.
//!
//! Every sample of a log of steady states is a point, or every plateau of the pressure is, or every declared window: the mean over it.
//! Points of several runs at equal pressure and conditions on the same branch are repeats of one station.
//!
//! With n >= 2 repeats of mean m and standard deviation s the interval of m has the half width that
//! [`Variance`](crate::uncertainty::coverage::Variance) gives of s²/n and u², u the standard uncertainty of the instrument: 95 %.
//! The instrument's error is taken as common to the repeats, so it does not shrink with their number. One repeat has no scatter:
//! `± 1.96 u`, or nothing at all. Repeats that agree to the last digit on an instrument that declares nothing say nothing of how
//! sure they are, and have no interval either.

use pneuval_ingest::manifest::{Branches, Condition, PointRule, ResponseSpec};
use pneuval_ingest::number::Printed;
use pneuval_ingest::session::Session;

use super::census::{Census, Creep};
use super::drift::{drift, mean_reading};
use super::readings::{Needed, Reading};
use super::stations::{Placed, Repeats, is_apart, place, stations};
use super::{InstrumentError, IntervalKind, Movement, Repeat, Response, ResponsePoint, Target};
use crate::align::AlignedRun;
use crate::trajectory::{Path, Sample};
use crate::uncertainty::coverage::Variance;
use crate::uncertainty::scatter::scatter;
use crate::verdict::Basis;

/// Points of a response at most: beyond it a log is a trajectory, not a set of steady states.
pub const POINTS_MAX: usize = 20_000;

/// Measured pressures are never exactly zero: so near, as a share of the largest, they are the reference.
const ZERO_SHARE: f64 = 0.005;

/// So near zero, as a share of the largest, a pressure is what rounding leaves of a difference, and is zero.
const ROUNDING_SHARE: f64 = 1e-9;

/// The pressure turns where it comes back by so much, as a share of the largest: of plateaus, and of single samples, which are noisy.
const TURN_SHARE: f64 = 0.01;
const TURN_SHARE_SAMPLES: f64 = 0.03;

/// What moves over its window by more than this share of the measured range, and by more than its scatter explains, creeps.
const CREEP_SHARE: f64 = 0.01;
const CREEP_STDS: f64 = 4.0;

impl Response {
    /// The response that a session declares, from its runs as they were aligned, and what became of its samples.
    ///
    /// # Errors
    /// The number of readings, if they are more than [`POINTS_MAX`] per run.
    pub fn from_session(
        session: &Session,
        aligned: &[AlignedRun],
        spec: &ResponseSpec,
    ) -> Result<(Self, Census), usize> {
        let (names, runs): (Vec<&str>, Vec<Needed>) =
            aligned.iter().filter_map(|aligned| Some((aligned.run.id.as_str(), Needed::of(aligned, spec)?))).unzip();
        let mut census = Census::default();
        for needed in &runs {
            needed.count(&mut census);
        }
        let states = census.samples - census.holes;
        let samples_per_point = match &spec.points {
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
        let std_si = std_of(session, spec);
        let mut movement = None;
        if let (PointRule::Trajectory(rule), Some(_)) = (&spec.points, spec.points.path()) {
            let paths = paths(std::mem::take(&mut readings), &names);
            movement = Some(Movement { rule: *rule, std_si: std_si.clone(), paths });
        }
        let zero_within_pa = spec.zero_within_pa.unwrap_or(ZERO_SHARE * largest);
        let same_within_pa = spec.points.same_within_pa();
        let turn = if spec.points.is_timed() { TURN_SHARE } else { TURN_SHARE_SAMPLES };
        let turn_pa = match spec.branches {
            Branches::Apart => (turn * largest).max(1.5 * same_within_pa),
            Branches::Together => f64::INFINITY,
        };
        let before = session.manifest.specimen.as_ref().and_then(|specimen| specimen.cycles_before);
        // Rows of a table of states are no cycles of load unless somebody says so.
        let says_so = spec.points.is_timed() || spec.cycles.is_some();
        let before = if says_so { before } else { before.or(Some(1)) };
        let mut placed = place(readings, turn_pa, before);
        if spec.tare_at_zero {
            census.untared = tare(&mut placed, zero_within_pa, &names);
        }
        census.creeping = creeping(&placed, &names);
        let drift = drift(&cycle_means(&placed));
        let repeats = Repeats::of(&placed, &names);
        let is_movement = matches!(spec.points, PointRule::Trajectory(_));
        // Where all are first none stands apart from others; where none can be, none is compared as the first.
        let has_first = placed.iter().any(|p| p.is_first) || before.is_some_and(|before| before > 0);
        // Run by run: no sample of a movement is a repeat of another.
        let groups = if is_movement {
            placed.into_iter().map(|one| vec![one]).collect()
        } else {
            stations(placed, same_within_pa)
        };
        let points: Vec<ResponsePoint> = groups
            .iter()
            .filter_map(|group| {
                let apart = is_apart(group.first()?.is_first, has_first, spec.cycles.unwrap_or_default());
                point(group, &std_si, &names, &repeats, apart)
            })
            .collect();
        if points.len() > POINTS_MAX {
            return Err(points.len());
        }
        let unmeasured = groups.len() - points.len();
        let mut instruments = instruments(session, spec);
        if movement.is_some() {
            // What is predicted for an instant has no slope over the pressure.
            instruments.retain(|i| matches!(i.target, Target::Component(_)));
        }
        let mut response = Self {
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
            unmeasured,
            movement,
            columns: vec![],
            texts: vec![],
            repeats: if is_movement { vec![] } else { repeats.names },
            instruments,
            drift,
        };
        pool_scatter(&mut response, &std_si);
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
    if let PointRule::Trajectory(rule) = &spec.points
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

/// What the instruments of the channels of a response declare.
fn instruments(session: &Session, spec: &ResponseSpec) -> Vec<InstrumentError> {
    let of = |(target, id): (Target, &String)| {
        let std_si = session.runs.iter().find_map(|run| run.channels.get(id))?.std_si?;
        let channel = session.manifest.channels.iter().find(|c| c.id == *id);
        let name = channel.and_then(|c| c.instrument.as_ref());
        let instrument = name.and_then(|name| session.rig.as_ref()?.instruments.get(name));
        let source = match (name, instrument) {
            (Some(name), Some(instrument)) if instrument.shared_calibration => name.clone(),
            (Some(name), _) => format!("{name} of {id}"),
            (None, _) => format!("instruments behind {id}"),
        };
        Some(InstrumentError { source, target, std_si })
    };
    let components = spec.measured.iter().enumerate().map(|(i, id)| (Target::Component(i), id));
    let pressures = spec.pressure.iter().enumerate().map(|(i, (id, _))| (Target::Pressure(i), id));
    let conditions = spec.conditions.iter().enumerate().map(|(i, c)| (Target::Condition(i), &c.channel));
    components.chain(pressures).chain(conditions).filter_map(of).collect()
}

/// Takes the mean reading at zero pressure before the first rise of each run as its zero; the runs that have none, which are left
/// without readings: what was not tared must not be compared with what was.
fn tare(placed: &mut [Placed], zero_within_pa: f64, names: &[&str]) -> Vec<String> {
    let mut untared = Vec::new();
    for (run, name) in names.iter().enumerate() {
        let is_of = |p: &Placed| p.reading.run == run;
        let width = placed.iter().find(|p| is_of(p)).map_or(0, |p| p.reading.measured.len());
        let is_zero = |p: &&Placed| p.reading.pressures.iter().all(|p| p.abs() <= zero_within_pa);
        let before: Vec<&Reading> =
            placed.iter().filter(|p| is_of(p)).take_while(is_zero).map(|p| &p.reading).collect();
        let zero: Vec<f64> =
            (0..width).map(|i| before.iter().map(|r| r.measured[i]).sum::<f64>() / before.len() as f64).collect();
        if zero.iter().any(|z| !z.is_finite()) {
            untared.push((*name).to_owned());
        }
        for one in placed.iter_mut().filter(|p| is_of(p)) {
            one.reading.measured.iter_mut().zip(&zero).for_each(|(value, zero)| *value -= zero);
        }
    }
    untared
}

/// Runs at whose readings something still moves.
fn creeping(placed: &[Placed], names: &[&str]) -> Vec<Creep> {
    let width = placed.first().map_or(0, |p| p.reading.measured.len());
    let range = |i: usize| {
        let values = placed.iter().map(|p| p.reading.measured[i]).filter(|v| v.is_finite());
        let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
        high - low
    };
    let limits: Vec<f64> = (0..width).map(|i| CREEP_SHARE * range(i)).collect();
    let moves = |reading: &Reading| {
        let creeps = reading.creep.iter().zip(&limits).filter_map(|(creep, limit)| {
            let (by, std) = (*creep)?;
            (by.abs() > *limit && by.abs() > CREEP_STDS * std).then_some(by)
        });
        creeps.max_by(|a, b| a.abs().total_cmp(&b.abs()))
    };
    let of_run = |(run, name): (usize, &&str)| {
        let here = || placed.iter().filter(|p| p.reading.run == run).map(|p| &p.reading);
        let moving: Vec<f64> = here().filter_map(moves).collect();
        let largest_si = moving.iter().copied().max_by(|a, b| a.abs().total_cmp(&b.abs()))?;
        Some(Creep { run: (*name).to_owned(), readings: here().count(), creeping: moving.len(), largest_si })
    };
    names.iter().enumerate().filter_map(of_run).collect()
}

/// The conditioned cycles of all runs one after the other: the number of each and the mean of its readings.
fn cycle_means(placed: &[Placed]) -> Vec<(f64, f64)> {
    let mut cycles: Vec<(usize, usize)> = placed.iter().map(|p| (p.reading.run, p.cycle)).collect();
    cycles.dedup();
    let of = |(number, &(run, cycle)): (usize, &(usize, usize))| {
        let here = || placed.iter().filter(move |p| (p.reading.run, p.cycle) == (run, cycle));
        let is_first = here().any(|p| p.is_first);
        Some((number as f64, mean_reading(here().map(|p| &p.reading))?, here().count())).filter(|_| !is_first)
    };
    let found: Vec<(f64, f64, usize)> = cycles.iter().enumerate().filter_map(of).collect();
    // Means over different stations are no drift.
    let most = found.iter().map(|(.., n)| *n).max().unwrap_or(0);
    found.into_iter().filter(|(.., n)| *n == most).map(|(number, mean, _)| (number, mean)).collect()
}

/// The intervals of values that few repeats read, by a scatter that is pooled over points where it can be.
fn pool_scatter(response: &mut Response, std_si: &[Option<f64>]) {
    let width = response.quantity.width();
    let Some((repeats, places)) = response.read_by_all_repeats() else { return };
    let values = |at: usize| response.points[at / width].repeats.iter().map(move |r| r.measured[at % width]);
    let means: Vec<f64> = places.iter().map(|&at| values(at).sum::<f64>() / repeats.len() as f64).collect();
    let deviation = |k: usize, at: usize, mean: f64| response.points[at / width].repeats[k].measured[at % width] - mean;
    let of = |k: usize| places.iter().zip(&means).map(|(&at, mean)| deviation(k, at, *mean)).collect();
    let deviations: Vec<Vec<f64>> = (0..repeats.len()).map(of).collect();
    let Ok(found) = scatter(&deviations, &means, &response.read_on_the_way_down(&places), width) else { return };
    let variance = |directions: &[Vec<f64>], place: usize| directions.iter().map(|d| d[place] * d[place]).sum::<f64>();
    for (place, at) in places.into_iter().enumerate() {
        let known = Variance::new(std_si.get(at % width).copied().flatten().unwrap_or(0.0).powi(2));
        let (common, own) = (variance(&found.common, place), variance(&found.own, place));
        let half_width_si = known.with(common, repeats.len() - 1).with(own, found.freedom).half_width();
        if let Some(values) = response.points[at / width].measured.as_mut()
            && half_width_si.is_finite()
        {
            values[at % width].half_width_si = half_width_si;
        }
    }
    // Readings of one point that agree to the last digit scatter as their neighbours do.
    for point in &mut response.points {
        let is_known = point.measured.iter().flatten().all(|value| value.half_width_si > 0.0);
        if point.repeats.len() == repeats.len() && is_known {
            point.interval = IntervalKind::Repeats;
        }
    }
}

/// The point of a station; `None` where nothing was measured at it.
fn point(
    group: &[Placed],
    std_si: &[Option<f64>],
    runs: &[&str],
    repeats: &Repeats,
    is_apart: bool,
) -> Option<ResponsePoint> {
    let whole: Vec<&Placed> = group.iter().filter(|p| p.reading.measured.iter().all(|v| v.is_finite())).collect();
    let first = *whole.first()?;
    let width = first.reading.measured.len();
    // The mean over the cycles of each repeat.
    let mut indices: Vec<usize> = whole.iter().map(|one| repeats.index(one)).collect();
    indices.sort_unstable();
    indices.dedup();
    let of_repeat = |index: usize| {
        let here: Vec<&Reading> = whole.iter().filter(|p| repeats.index(p) == index).map(|p| &p.reading).collect();
        let mean = |of: fn(&Reading) -> &Vec<f64>| -> Vec<f64> {
            let sum = |i: usize| here.iter().map(|r| of(r)[i]).sum::<f64>();
            (0..of(here[0]).len()).map(|i| sum(i) / here.len() as f64).collect()
        };
        Repeat {
            index,
            measured: mean(|r| &r.measured),
            pressures_gauge_pa: mean(|r| &r.pressures),
            conditions: mean(|r| &r.conditions),
        }
    };
    let values: Vec<Repeat> = indices.into_iter().map(of_repeat).collect();
    let n = values.len();
    let mean = |of: fn(&Reading) -> &Vec<f64>| -> Vec<f64> {
        let sum = |i: usize| whole.iter().map(|p| of(&p.reading)[i]).sum::<f64>();
        (0..of(&first.reading).len()).map(|i| sum(i) / whole.len() as f64).collect()
    };
    let instrument = |i: usize| std_si.get(i).copied().flatten();
    let measured: Vec<Printed> = (0..width)
        .map(|i| {
            let mean = values.iter().map(|r| r.measured[i]).sum::<f64>() / n as f64;
            let squares: f64 = values.iter().map(|r| (r.measured[i] - mean).powi(2)).sum();
            let scatter = if n < 2 { 0.0 } else { squares / ((n - 1) * n) as f64 };
            let known = Variance::new(instrument(i).unwrap_or(0.0).powi(2));
            let half_width_si = known.with(scatter, n - 1).half_width();
            // Beyond what a double can hold nothing is known: not a number, which is never judged.
            if half_width_si.is_finite() {
                Printed { si: mean, half_width_si }
            } else {
                Printed { si: f64::NAN, half_width_si: 0.0 }
            }
        })
        .collect();
    let widths = measured.iter().all(|m| m.half_width_si > 0.0);
    let interval = if n >= 2 && widths {
        IntervalKind::Repeats
    } else if (0..width).all(|i| instrument(i).is_some()) {
        IntervalKind::Instrument
    } else {
        IntervalKind::Unknown
    };
    let mut of_runs: Vec<&str> = whole.iter().filter_map(|p| runs.get(p.reading.run).copied()).collect();
    of_runs.dedup();
    Some(ResponsePoint {
        line: first.reading.line,
        runs: of_runs.into_iter().map(str::to_owned).collect(),
        pressures_gauge_pa: mean(|r| &r.pressures),
        at: None,
        conditions: mean(|r| &r.conditions).into_iter().map(|si| Printed { si, half_width_si: 0.0 }).collect(),
        measured: Some(measured),
        interval,
        branch: Some(first.branch),
        is_apart,
        repeats: values,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::uncertainty::coverage::Z95;

    fn reading(run: usize, pressure: f64, value: f64) -> Reading {
        Reading {
            run,
            line: 1,
            seconds: f64::NAN,
            pressures: vec![pressure],
            conditions: vec![],
            measured: vec![value],
            creep: vec![None],
        }
    }

    fn points(
        readings: Vec<Reading>,
        same_within_pa: f64,
        std_si: &[Option<f64>],
        runs: &[&str],
    ) -> Vec<ResponsePoint> {
        let placed = place(readings, 300.0, None);
        let repeats = Repeats::of(&placed, runs);
        let groups = stations(placed, same_within_pa);
        groups.iter().filter_map(|group| point(group, std_si, runs, &repeats, false)).collect()
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
        assert!((value(&found[0]).half_width_si - 0.25 * Z95).abs() < 1e-15);
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
