//! What is compared, and what explanations are given: logs whose fault is known.

use std::cell::RefCell;

use super::*;
use crate::manifest::{ColumnRef, PressureReference};

const KPA: f64 = 1e3;
const RATE: f64 = 10.0;

/// A log at 10 Hz in which each command, in kPa, stands for 5 s, and what is measured at a time and a command.
struct Log {
    command: Vec<f64>,
    measured: Vec<f64>,
    seconds: Vec<f64>,
}

impl Log {
    fn new(commands: &[f64], measured: impl Fn(f64, f64) -> f64) -> Self {
        let command: Vec<f64> = commands.iter().flat_map(|c| [c * KPA; 50]).collect();
        let seconds: Vec<f64> = (0..command.len()).map(|i| i as f64 / RATE).collect();
        let measured = command.iter().zip(&seconds).map(|(c, t)| KPA * measured(*t, c / KPA)).collect();
        Self { command, measured, seconds }
    }

    fn pair(&self) -> Pair<'_> {
        Pair { command: &self.command, measured: &self.measured, seconds: Some(&self.seconds) }
    }

    fn compared(&self) -> Compared {
        self.pair().compare(KPA, 2.0)
    }

    /// The hint between two gauge pressures in kPa.
    fn hint(&self) -> Option<String> {
        hint_in(&self.pair(), 2.0, ("kPa", PressureReference::Gauge), ("kPa", PressureReference::Gauge))
    }
}

fn channel(id: &str, reference: PressureReference) -> ChannelSpec {
    ChannelSpec {
        id: id.to_owned(),
        device: None,
        column: ColumnRef::Number(1),
        unit: None,
        instrument: None,
        reference: Some(reference),
        commanded: false,
        tare_samples: None,
        follows: None,
        line: 1,
    }
}

fn hint_in(
    pair: &Pair,
    after_s: f64,
    measured: (&str, PressureReference),
    command: (&str, PressureReference),
) -> Option<String> {
    let unit = |symbol: &str| Unit::parse(symbol).unwrap();
    let follows = Follows { channel: "command".to_owned(), within: (1.0, unit("kPa")), after_s, line: 1 };
    let (of_measured, of_command) = (channel("pressure", measured.1), channel("command", command.1));
    let between = Between {
        measured: (&of_measured, unit(measured.0)),
        command: (&of_command, unit(command.0)),
        atmosphere_pa: None,
    };
    let all = pair.compare(KPA, after_s);
    let moment = all.apart.first.first().map(|(first, _)| format!("{} s", stamp(pair.time(*first))));
    pair.explanation(&all, &follows, &between, &moment?)
}

/// Deterministic noise between -1 and 1.
fn noise(t: f64) -> f64 {
    (t * 7919.0).sin()
}

const STEPS: [f64; 6] = [0.0, 20.0, 40.0, 50.0, 30.0, 0.0];

#[test]
fn what_meets_its_command_is_compared_where_the_command_stands_and_nothing_is_told() {
    // Behind every step the pressure needs 1.5 s.
    let log = Log::new(&STEPS, |t, c| if t % 5.0 < 1.5 { 0.0 } else { c + 0.4 * noise(t) });
    let all = log.compared();
    // 5 s at 10 Hz without the first 2 s, six times.
    assert_eq!((all.standing, all.compared, all.apart.count), (180, 180, 0));
    assert_eq!(log.hint(), None);
}

#[test]
fn a_ramp_is_not_compared_however_slow() {
    let command: Vec<f64> = (0..600).map(|i| f64::from(i) * 0.01 * KPA).collect();
    let measured = vec![0.0; 600];
    let seconds: Vec<f64> = (0..600).map(|i| f64::from(i) / RATE).collect();
    let pair = Pair { command: &command, measured: &measured, seconds: Some(&seconds) };
    // 0.01 kPa a sample: the command leaves a hundredth of 1 kPa behind two samples.
    assert_eq!(pair.compare(KPA, 2.0).standing, 0);
    // A converter's step within that hundredth is no ramp.
    let command: Vec<f64> = (0..600).map(|i| (50.0 + 0.009 * f64::from(i % 2)) * KPA).collect();
    let all = Pair { command: &command, ..pair }.compare(KPA, 2.0);
    assert_eq!((all.standing, all.apart.count), (580, 580));
}

#[test]
fn a_difference_of_just_what_is_allowed_is_none() {
    for (measured, apart) in [(51.1, 0), (49.1, 0), (51.100_001, 1), (49.099_999, 1)] {
        let pair = Pair { command: &[50.1 * KPA], measured: &[measured * KPA], seconds: None };
        assert_eq!(pair.compare(KPA, 0.0).apart.count, apart, "{measured}");
    }
}

#[test]
fn the_command_has_stood_long_enough_at_just_that_time() {
    // 10.3 s and 2 s are no binary numbers.
    let seconds: Vec<f64> = (0..30).map(|i| (103.0 + f64::from(i)) / RATE).collect();
    let (command, measured) = (vec![0.0; 30], vec![5.0 * KPA; 30]);
    let all = Pair { command: &command, measured: &measured, seconds: Some(&seconds) }.compare(KPA, 2.0);
    assert_eq!((all.standing, all.apart.first.clone()), (10, vec![(20, 29)]));
}

#[test]
fn holes_are_neither_agreement_nor_disagreement() {
    let mut log = Log::new(&[50.0], |_, _| 10.0);
    log.measured[30] = f64::NAN;
    log.command[35] = f64::NAN;
    log.seconds[40] = f64::NAN;
    log.measured[41] = f64::INFINITY;
    let all = log.compared();
    assert_eq!((all.standing, all.compared, all.apart.count), (28, 26, 26));
    assert_eq!(all.apart.first, [(20, 29), (31, 34), (36, 39), (42, 49)]);
    // A channel without a number agrees with nothing.
    let log = Log::new(&[50.0], |_, _| f64::NAN);
    assert_eq!((log.compared().standing, log.compared().compared), (30, 0));
    // A hole in the command does not hide that it has moved.
    let mut log = Log::new(&[50.0, 20.0], |_, _| 50.0);
    log.command[45..55].fill(f64::NAN);
    assert_eq!(log.compared().apart.first, [(75, 99)]);
}

#[test]
fn a_log_in_another_unit_is_seen_as_such() {
    let psi = Unit::parse("psi").unwrap().factor / KPA;
    let gauge = PressureReference::Gauge;
    let hint = |factor: f64, measured: &str, command: &str| {
        let log = Log::new(&STEPS, |t, c| (c + 0.2 * noise(t)) * factor);
        hint_in(&log.pair(), 2.0, (measured, gauge), (command, gauge))
    };
    assert_eq!(hint(1.0 / psi, "kPa", "kPa").unwrap(), "as if it were in psi");
    // The one in kPa is said to be in psi: 6.89 times too much.
    assert_eq!(hint(psi, "psi", "kPa").unwrap(), "as if it were in kPa, or `command` were in psi");
    assert_eq!(hint(psi, "kPa", "kPa").unwrap(), "as if `command` were in psi");
    assert_eq!(hint(0.01, "kPa", "bar").unwrap(), "as if it were in bar, or `command` were in kPa");
    assert_eq!(hint(1000.0, "kPa", "kPa").unwrap(), "as if it were in Pa, or `command` were in MPa");
    assert_eq!(hint(0.001, "kPa", "kPa").unwrap(), "as if it were in MPa, or `command` were in Pa");
    assert_eq!(hint(-1.0, "kPa", "kPa").unwrap(), "as if it had the other sign");
}

#[test]
fn a_factor_is_told_only_if_every_plateau_has_it() {
    let psi = KPA / Unit::parse("psi").unwrap().factor;
    // One plateau of six is right, or wrong in another way.
    for odd in [1.0, 0.5, 0.2] {
        let log = Log::new(&STEPS, |t, c| c * if (10.0..15.0).contains(&t) { odd } else { psi });
        assert!(log.compared().apart.count > 0);
        assert_eq!(log.hint(), None, "{odd}");
    }
    // It need not be far from it.
    let log = Log::new(&STEPS, |t, c| c * if (10.0..15.0).contains(&t) { 0.17 } else { psi });
    assert_eq!(log.hint().unwrap(), "throughout about 85 % short of the command");
    // A factor near one that has a name, but not that near.
    let log = Log::new(&STEPS, |_, c| c * psi * 1.03);
    assert_eq!(log.hint().unwrap(), "throughout about 85 % short of the command");
    let log = Log::new(&STEPS, |_, c| c * psi * 1.015);
    assert_eq!(log.hint().unwrap(), "as if it were in psi");
    // A reading where nothing is commanded comes from no unit.
    let log = Log::new(&STEPS, |_, c| c * psi + 0.9);
    assert_eq!(log.hint().unwrap(), "throughout about 84 % short of the command");
    let log = Log::new(&STEPS, |_, c| c * psi + 1.1);
    assert_eq!(log.hint(), None);
}

#[test]
fn an_offset_is_told_apart_from_a_factor_by_several_commands() {
    let log = Log::new(&STEPS, |t, c| c + 2.5 + 0.2 * noise(t));
    assert_eq!(log.hint().unwrap(), "as if about 2.5 kPa were added to it: a zero that slipped?");
    // 50 kPa and 40 measured: a fifth is missing, or 10 kPa.
    let log = Log::new(&[50.0], |_, _| 40.0);
    assert_eq!(log.hint(), None);
    let log = Log::new(&[50.0, 50.2, 49.8], |_, c| c - 10.0);
    assert_eq!(log.hint(), None);
    // From a moment on, which is no moment of a step.
    let log = Log::new(&STEPS, |t, c| c - if t < 12.8 { 0.0 } else { 3.0 });
    assert_eq!(log.hint().unwrap(), "from 12.8 s on as if about 3 kPa were taken from it: a zero that slipped?");
    // It drifts: no one offset.
    let log = Log::new(&STEPS, |t, c| c + 0.3 * t);
    assert!(log.compared().apart.count > 0);
    assert_eq!(log.hint(), None);
}

#[test]
fn an_atmosphere_too_much_is_that_of_the_other_zero() {
    use PressureReference::{Absolute, Gauge};
    let hint = |offset: f64, measured, command| {
        let log = Log::new(&STEPS, |t, c| c + offset + 0.1 * noise(t));
        hint_in(&log.pair(), 2.0, ("kPa", measured), ("kPa", command)).unwrap()
    };
    assert_eq!(hint(101.3, Gauge, Gauge), "as if it were an absolute pressure");
    assert_eq!(hint(-101.3, Absolute, Gauge), "as if it were a gauge pressure, or `command` were an absolute pressure");
    assert_eq!(hint(-99.0, Gauge, Gauge), "as if `command` were an absolute pressure");
    // No other zero gives this.
    assert_eq!(hint(101.3, Absolute, Gauge), "as if about 100 kPa were added to it: a zero that slipped?");
    assert_eq!(hint(60.0, Gauge, Gauge), "as if about 60 kPa were added to it: a zero that slipped?");
    // Nothing but zero was commanded.
    let log = Log::new(&[0.0], |_, _| 101.3);
    assert_eq!(log.hint().unwrap(), "as if it were an absolute pressure");
}

#[test]
fn a_share_that_is_lost_from_some_moment_on_may_be_a_leak() {
    let log = Log::new(&STEPS, |t, c| c * if t < 12.3 { 1.0 } else { 0.85 } + 0.2 * noise(t));
    assert_eq!(log.compared().apart.first[0].0, 123);
    assert_eq!(log.hint().unwrap(), "from 12.3 s on about 15 % short of the command: a leak?");
    // One command only: what is lost may as well be an offset.
    let log = Log::new(&[0.0, 50.0], |t, c| if t < 7.5 { c } else { 0.85 * c });
    assert_eq!(log.hint().unwrap(), "from 7.5 s on about 15 % short of the command: a leak, or a zero that slipped?");
    // It comes back: no moment from which on.
    let log = Log::new(&STEPS, |t, c| c * if (12.3..18.0).contains(&t) { 0.85 } else { 1.0 });
    assert!(log.compared().apart.count > 0);
    assert_eq!(log.hint(), None);
    // At the very end it is not known whether it stays.
    let log = Log::new(&[0.0, 50.0, 40.0], |t, c| if t < 13.5 { c } else { 0.85 * c });
    assert_eq!((log.compared().apart.count, log.hint()), (15, None));
    // Slower and slower: at no two commands the same share.
    let log = Log::new(&STEPS, |t, c| c * (1.0 - 0.012 * (t - 8.0).max(0.0)));
    assert!(log.compared().apart.count > 0);
    assert_eq!(log.hint(), None);
    // More than was asked for leaks nowhere.
    let log = Log::new(&STEPS, |t, c| c * if t < 12.3 { 1.0 } else { 1.2 });
    assert_eq!(log.hint().unwrap(), "from 12.3 s on about 20 % over the command");
}

#[test]
fn single_samples_that_disagree_have_no_explanation() {
    let log = Log::new(&STEPS, |t, c| if (t * RATE).round() % 7.0 == 0.0 { -c } else { c });
    assert!(log.compared().apart.count > 10);
    assert_eq!(log.hint(), None);
}

#[test]
fn lines_that_are_steady_states_need_no_clock() {
    let command: Vec<f64> = (0..8).map(|i| f64::from(i) * 10.0 * KPA).collect();
    let measured: Vec<f64> = command.iter().map(|c| -c).collect();
    let pair = Pair { command: &command, measured: &measured, seconds: None };
    let all = pair.compare(KPA, 0.0);
    assert_eq!((all.compared, all.apart.first.clone()), (8, vec![(1, 7)]));
    let gauge = PressureReference::Gauge;
    assert_eq!(hint_in(&pair, 0.0, ("kPa", gauge), ("kPa", gauge)).unwrap(), "as if it had the other sign");
}

#[test]
fn of_more_commands_than_anybody_gives_no_explanation_is_sought() {
    let command: Vec<f64> = (0..10_000).map(|i| f64::from(i) * 10.0 * KPA).collect();
    let measured: Vec<f64> = command.iter().map(|c| -c).collect();
    let all = Pair { command: &command, measured: &measured, seconds: None }.compare(KPA, 0.0);
    assert_eq!((all.apart.count, all.plateaus.len()), (9_999, 0));
}

/// Numbers between 0 and 1, the same on every run.
fn random(state: &mut u64) -> f64 {
    *state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
    (*state >> 33) as f64 / f64::from(1_u32 << 31)
}

#[test]
fn an_explanation_is_right_or_absent() {
    let mut state = 1;
    let mut given = [0; 5];
    for most in [20.0, 50.0, 200.0].into_iter().cycle().take(500) {
        let commands: Vec<f64> = (0..6).map(|_| (random(&mut state) * most).round()).collect();
        // Half of what is allowed, and a sensor that is half a percent wrong.
        let sigma = 0.5 * random(&mut state);
        let gain = 1.0 + 0.01 * (random(&mut state) - 0.5);
        let noise: Vec<f64> = (0..300).map(|_| sigma * 2.0 * (random(&mut state) - 0.5)).collect();
        let (offset, lost) = (2.0 + 8.0 * random(&mut state), 0.1 + 0.8 * random(&mut state));
        let words = ["", "it were in psi", "other sign", "added to it: a zero", "a leak?"];
        for (fault, (words, given)) in words.iter().zip(&mut given).enumerate() {
            let noise = RefCell::new(noise.iter());
            let log = Log::new(&commands, |t, c| {
                let right = c * gain + noise.borrow_mut().next().unwrap();
                match fault {
                    1 => right / 6.894_757,
                    2 => -right,
                    3 => right + offset,
                    4 if t > 13.0 => right * (1.0 - lost),
                    _ => right,
                }
            });
            let Some(hint) = log.hint() else { continue };
            *given += 1;
            // Less is said where noise hides the name of a factor, or where a share was lost before the first command.
            let also =
                fault == 4 && hint.contains("short of the command") || fault == 1 && hint.starts_with("throughout");
            assert!(fault > 0 && hint.contains(words) || also, "{fault}: {hint} at {commands:?}");
        }
    }
    assert_eq!(given[0], 0);
    // Commands near each other, or all below what is allowed, explain nothing.
    assert!(given[1..].iter().all(|given| *given > 350), "{given:?}");
}
