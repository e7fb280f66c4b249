//! Readings of several runs and cycles that belong together: stations.
//!
//! A station is a pressure, a setting of the conditions and a branch. The conditioned cycles of a run give one value, their mean: cycles of a
//! run are not independent of each other. So runs are the repeats; of a sole run its conditioned cycles are. The first
//! cycle has stations of its own.

use std::collections::HashMap;

use pneuval_ingest::manifest::Cycles;

use super::readings::{Reading, SETTING_SHARE};
use super::way::{Branch, ways};

/// A reading and where on the way of the pressure it lies.
#[derive(Debug, Clone)]
pub(super) struct Placed {
    pub reading: Reading,
    pub branch: Branch,
    /// From 1, in its run.
    pub cycle: usize,
    /// It belongs to the first cycle, and others are conditioned.
    pub is_first: bool,
}

/// Says of every reading, in the order of runs, on which way it lies: settings of the conditions have ways of their own.
///
/// States whose order means nothing lie on no way, with an infinite threshold: all of them are loading, and one cycle.
pub(super) fn place(readings: Vec<Reading>, threshold: f64, cycles_before: Option<u64>) -> Vec<Placed> {
    let sum = |reading: &Reading| reading.pressures.iter().sum::<f64>();
    let near = nearness(&readings);
    let mut found: Vec<(Branch, usize)> = vec![(Branch::Loading, 1); readings.len()];
    let mut rest: Vec<usize> = (0..readings.len()).collect();
    while let Some(&first) = rest.first() {
        let alike = |i: usize| readings[i].run == readings[first].run && is_near(&readings[i], &readings[first], &near);
        let (group, others): (Vec<usize>, Vec<usize>) = rest.into_iter().partition(|&i| alike(i));
        let pressures: Vec<f64> = group.iter().map(|&i| sum(&readings[i])).collect();
        for (&i, way) in group.iter().zip(ways(&pressures, threshold)) {
            found[i] = way;
        }
        rest = others;
    }
    let last_cycle = |run: usize| {
        let of_run = readings.iter().zip(&found).filter(|(r, _)| r.run == run);
        of_run.map(|(_, (_, cycle))| *cycle).max().unwrap_or(1)
    };
    let runs = readings.iter().map(|r| r.run).max().map_or(0, |last| last + 1);
    let cycles: Vec<usize> = (0..runs).map(last_cycle).collect();
    let first_run = readings.first().map(|r| r.run);
    let is_first = |run: usize, cycle: usize| match cycles_before {
        // Nobody says: what follows in the same run is conditioned by it.
        None => cycle == 1 && cycles[run] > 1,
        Some(0) => cycle == 1 && first_run == Some(run),
        Some(_) => false,
    };
    let first: Vec<bool> = readings.iter().zip(&found).map(|(r, (_, cycle))| is_first(r.run, *cycle)).collect();
    let any_other = first.iter().any(|is| !is);
    let zipped = readings.into_iter().zip(found).zip(first);
    let placed =
        |((reading, (branch, cycle)), is_first)| Placed { reading, branch, cycle, is_first: is_first && any_other };
    zipped.map(placed).collect()
}

/// How near conditions must be to be one setting.
fn nearness(readings: &[Reading]) -> Vec<f64> {
    let settings = readings.first().map_or(0, |r| r.conditions.len());
    (0..settings).map(|i| SETTING_SHARE * readings.iter().map(|r| r.conditions[i].abs()).fold(0.0, f64::max)).collect()
}

fn is_near(a: &Reading, b: &Reading, near: &[f64]) -> bool {
    a.conditions.iter().zip(&b.conditions).zip(near).all(|((a, b), near)| (a - b).abs() <= *near)
}

/// Groups of the same logged bits, and how many readings of a run and cycle have joined them.
#[derive(Default)]
struct Alike {
    groups: Vec<usize>,
    joined: HashMap<(usize, usize), usize>,
}

/// Readings at equal pressure and conditions on the same branch, first cycles apart: the first of each run and cycle meets the first of the
/// others, the second the second, whether or not anything was measured at it. Equal is to the bit for logged states; else within the
/// tolerance, and conditions within 1 % of the largest.
pub(super) fn stations(placed: Vec<Placed>, same_within_pa: f64) -> Vec<Vec<Placed>> {
    let mut groups: Vec<Vec<Placed>> = Vec::new();
    if same_within_pa > 0.0 {
        let settings = placed.first().map_or(0, |p| p.reading.conditions.len());
        let largest = |i: usize| placed.iter().map(|p| p.reading.conditions[i].abs()).fold(0.0, f64::max);
        let near: Vec<f64> = (0..settings).map(|i| SETTING_SHARE * largest(i)).collect();
        for one in placed {
            let meets = |group: &&mut Vec<Placed>| {
                let Some(first) = group.first() else { return false };
                let mut pressures = first.reading.pressures.iter().zip(&one.reading.pressures);
                (first.branch, first.is_first) == (one.branch, one.is_first)
                    && pressures.all(|(a, b)| (a - b).abs() <= same_within_pa)
                    && is_near(&first.reading, &one.reading, &near)
                    && group.iter().all(|p| (p.reading.run, p.cycle) != (one.reading.run, one.cycle))
            };
            match groups.iter_mut().find(meets) {
                Some(group) => group.push(one),
                None => groups.push(vec![one]),
            }
        }
        return groups;
    }
    let mut alike: HashMap<(Branch, bool, Vec<u64>), Alike> = HashMap::new();
    for one in placed {
        // Adding zero makes a negative zero a positive one.
        let bits = |v: &f64| (v + 0.0).to_bits();
        let state = one.reading.pressures.iter().chain(&one.reading.conditions).map(bits).collect();
        let here = alike.entry((one.branch, one.is_first, state)).or_default();
        let turn = here.joined.entry((one.reading.run, one.cycle)).or_default();
        if let Some(&group) = here.groups.get(*turn) {
            groups[group].push(one);
        } else {
            here.groups.push(groups.len());
            groups.push(vec![one]);
        }
        *turn += 1;
    }
    groups
}

/// What is repeated in a response.
pub(super) struct Repeats {
    /// Their names.
    pub names: Vec<String>,
    /// A sole run, whose cycles are the repeats.
    of_cycles: bool,
}

impl Repeats {
    /// Those of some readings.
    pub fn of(placed: &[Placed], runs: &[&str]) -> Self {
        let sole = placed.iter().all(|p| Some(p.reading.run) == placed.first().map(|p| p.reading.run));
        let last = placed.iter().map(|p| p.cycle).max().unwrap_or(1);
        let name = |cycle: usize| {
            format!("{} cycle {cycle}", placed.first().and_then(|p| runs.get(p.reading.run)).unwrap_or(&""))
        };
        let of_cycles = sole && last > 1;
        let names =
            if of_cycles { (1..=last).map(name).collect() } else { runs.iter().map(|&r| r.to_owned()).collect() };
        Self { names, of_cycles }
    }

    /// Which of them a reading is.
    pub fn index(&self, placed: &Placed) -> usize {
        if self.of_cycles { placed.cycle - 1 } else { placed.reading.run }
    }
}

/// Whether what belongs to the first cycle, or to the others, is shown and not compared.
pub(super) fn is_apart(is_first: bool, has_first: bool, cycles: Cycles) -> bool {
    match cycles {
        Cycles::All => false,
        Cycles::Conditioned => is_first,
        Cycles::First => has_first && !is_first,
    }
}
