//! What is asked of the pressure over time: levels and straight lines between them.

use super::plan::{Programme, ProgrammeKind};
use super::random::Normal;

/// Straight pieces of a period of a sine.
const SINE_PIECES: usize = 240;

/// What is set at one time.
#[derive(Debug, Clone, PartialEq)]
pub struct State {
    /// Gauge pressure of each chamber of the programme.
    pub pressures_pa: Vec<f64>,
    /// Which set of conditions.
    pub set: usize,
    /// Which level, from zero; at rest there is none.
    pub level: Option<usize>,
}

/// A state that stands.
#[derive(Debug, Clone, PartialEq)]
pub struct Plateau {
    /// Since when, in s.
    pub from_s: f64,
    /// Until when, in s.
    pub to_s: f64,
    /// What is set.
    pub state: State,
    /// Whether the pressure was no higher before.
    pub loading: bool,
    /// Which cycle, from zero.
    pub cycle: usize,
}

/// A programme in time.
#[derive(Debug, Clone, PartialEq)]
pub struct Timeline {
    /// Times in s and what is set at them; straight lines between.
    pub knots: Vec<(f64, State)>,
    /// States that stand.
    pub plateaus: Vec<Plateau>,
    /// How long it lasts, in s.
    pub end_s: f64,
    /// When the trigger line is raised, and when it falls, in s.
    pub triggers_s: Vec<(f64, f64)>,
}

/// Within a rest the trigger line rises and falls in these shares of it, somewhere.
const RISE: (f64, f64) = (0.3, 0.4);
const FALL: (f64, f64) = (0.6, 0.7);

/// Builds it piece by piece.
struct Building {
    knots: Vec<(f64, State)>,
    plateaus: Vec<Plateau>,
    now_s: f64,
}

impl Building {
    fn go(&mut self, for_s: f64, state: &State) {
        self.now_s += for_s;
        self.knots.push((self.now_s, state.clone()));
    }

    fn hold(&mut self, for_s: f64, state: &State, loading: bool, cycle: usize) {
        let from_s = self.now_s;
        self.go(for_s, state);
        self.plateaus.push(Plateau { from_s, to_s: self.now_s, state: state.clone(), loading, cycle });
    }
}

impl Programme {
    /// The states in order, each held once per cycle where the programme holds at all. Somebody presses the trigger at both ends, at
    /// no instant that any device's samples know of.
    pub fn timeline(&self, states: &[State], hand: &mut Normal) -> Timeline {
        let largest = |state: &&State| state.pressures_pa.iter().copied().fold(0.0, f64::max);
        let top = states.iter().max_by(|a, b| largest(a).total_cmp(&largest(b)));
        let zeros = vec![0.0; self.chambers.len()];
        let rest = |set: usize| State { pressures_pa: zeros.clone(), set, level: None };
        let first = rest(states.first().map_or(0, |state| state.set));
        let mut building = Building { knots: vec![(0.0, first.clone())], plateaus: vec![], now_s: 0.0 };
        building.hold(self.rest_s, &first, true, 0);
        for cycle in 0..self.cycles {
            let Some(top) = top else { break };
            match self.kind {
                ProgrammeKind::Steps => {
                    let down = states.iter().rev().skip(1).filter(|_| self.unload);
                    for state in states.iter().chain(down) {
                        // As much or more than before, in sum over the chambers.
                        let sum = |state: &State| state.pressures_pa.iter().sum::<f64>();
                        let loading = building.knots.last().is_none_or(|(_, before)| sum(state) >= sum(before));
                        building.go(self.rise_s, state);
                        building.hold(self.hold_s, state, loading, cycle);
                    }
                    let set = building.knots.last().map_or(0, |(_, state)| state.set);
                    building.go(self.rise_s, &rest(set));
                    if cycle + 1 < self.cycles {
                        building.hold(self.hold_s, &rest(set), false, cycle);
                    }
                }
                ProgrammeKind::Ramp => {
                    building.go(self.rise_s, top);
                    building.go(self.rise_s, &rest(top.set));
                }
                ProgrammeKind::Sine => {
                    for piece in 1..=SINE_PIECES {
                        let phase = std::f64::consts::TAU * piece as f64 / SINE_PIECES as f64;
                        let share = 0.5 * (1.0 - phase.cos());
                        let pressures_pa = top.pressures_pa.iter().map(|p| p * share).collect();
                        let state = State { pressures_pa, set: top.set, level: None };
                        building.go(self.hold_s / SINE_PIECES as f64, &state);
                    }
                }
                ProgrammeKind::Cycles => {
                    building.go(self.rise_s, top);
                    building.hold(self.hold_s, top, true, cycle);
                    building.go(self.rise_s, &rest(top.set));
                    building.hold(self.hold_s, &rest(top.set), false, cycle);
                }
            }
        }
        let last = rest(building.knots.last().map_or(0, |(_, state)| state.set));
        let begin_s = building.now_s;
        building.hold(self.rest_s, &last, false, self.cycles - 1);
        let Building { knots, plateaus, now_s } = building;
        let mut within = |(least, most): (f64, f64)| (least + (most - least) * hand.even()) * self.rest_s;
        let triggers_s = [0.0, begin_s].map(|rest| (rest + within(RISE), rest + within(FALL))).to_vec();
        Timeline { knots, plateaus, end_s: now_s, triggers_s }
    }
}

impl Timeline {
    /// Whether the trigger line is raised.
    pub fn is_triggered(&self, at_s: f64) -> bool {
        self.triggers_s.iter().any(|(from, to)| (*from..*to).contains(&at_s))
    }
}

/// Goes along a timeline.
pub struct Walk<'t> {
    timeline: &'t Timeline,
    /// The knot before.
    knot: usize,
}

/// Where a walk is: between two states.
pub struct Between<'t> {
    /// The state before.
    pub from: &'t State,
    /// The state after.
    pub to: &'t State,
    /// How much of the way is done.
    pub share: f64,
}

impl Between<'_> {
    /// A value that goes straight from one state to the other.
    pub fn blend(&self, of: impl Fn(&State) -> f64) -> f64 {
        let (from, to) = (of(self.from), of(self.to));
        from + self.share * (to - from)
    }
}

impl<'t> Walk<'t> {
    /// At its beginning.
    pub fn new(timeline: &'t Timeline) -> Self {
        Self { timeline, knot: 0 }
    }

    /// Goes on to a later time.
    pub fn to(&mut self, at_s: f64) -> Between<'t> {
        let knots = &self.timeline.knots;
        while self.knot + 2 < knots.len() && knots[self.knot + 1].0 <= at_s {
            self.knot += 1;
        }
        let (from_s, from) = &knots[self.knot];
        let Some((to_s, to)) = knots.get(self.knot + 1) else { return Between { from, to: from, share: 0.0 } };
        let share = if to_s > from_s { ((at_s - from_s) / (to_s - from_s)).clamp(0.0, 1.0) } else { 1.0 };
        Between { from, to, share }
    }
}
