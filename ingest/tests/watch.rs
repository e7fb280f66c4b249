//! What is told of columns and clocks that go by once: each fault at its samples, and nothing of logs as rigs write them.

// In a test a panic is how a failure is told; equality of floats is asked where it must be exact.
#![allow(clippy::unwrap_used, clippy::panic, clippy::float_cmp)]

use std::f64::consts::TAU;

use pneuval_ingest::finding::{FindingKind, LineMap, Severity, clock_findings};
use pneuval_ingest::watch::{ClockSummary, ClockWatch, Summary, Watch};

/// Numbers that look random and are the same on every run.
struct Random(u64);

impl Random {
    /// Evenly between 0 and 1.
    fn even(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// Noise of standard deviation 1.
    fn noise(&mut self) -> f64 {
        let (radius, angle) = ((-2.0 * (1.0 - self.even()).ln()).sqrt(), TAU * self.even());
        radius * angle.cos()
    }

    fn below(&mut self, limit: usize) -> usize {
        self.even();
        usize::try_from(self.0 % limit as u64).unwrap()
    }
}

const KPA_PER_CODE: f64 = 500.0 / 4095.0;

/// What a 12-bit converter gives for a pressure in kPa: it ends at 0 and 500.
fn adc(value: f64) -> f64 {
    (value / KPA_PER_CODE).round().clamp(0.0, 4095.0) * KPA_PER_CODE
}

/// As a log prints it.
fn printed(value: f64) -> f64 {
    format!("{value:.2}").parse().unwrap()
}

fn summary(values: &[f64]) -> Summary {
    let mut watch = Watch::default();
    watch.block(values);
    watch.finish()
}

type Told = (FindingKind, usize, Vec<(usize, usize)>);

fn told(values: &[f64]) -> Vec<Told> {
    let findings = summary(values).findings("r.csv", "p", &LineMap::default());
    assert!(findings.iter().all(|f| f.severity == Severity::Note && f.channel.as_deref() == Some("p")));
    findings
        .into_iter()
        .map(|f| (f.kind, f.count, f.spans.iter().map(|s| (s.first_sample, s.last_sample)).collect()))
        .collect()
}

fn signal(count: usize, seed: u64, value: impl Fn(f64, &mut Random) -> f64) -> Vec<f64> {
    let mut random = Random(seed);
    (0..count).map(|i| value(i as f64, &mut random)).collect()
}

/// Up and down in plateaus: of `hold` samples each, with ramps of `ramp` between them.
fn staircase(levels: &[f64], hold: usize, ramp: usize) -> Vec<f64> {
    let mut out = Vec::new();
    for pair in levels.windows(2) {
        out.extend(vec![pair[0]; hold]);
        out.extend((0..ramp).map(|i| pair[0] + (pair[1] - pair[0]) * i as f64 / ramp as f64));
    }
    out.extend(vec![*levels.last().unwrap(); hold]);
    out
}

fn noisy(values: &[f64], std: f64, seed: u64, shown: impl Fn(f64) -> f64) -> Vec<f64> {
    let mut random = Random(seed);
    values.iter().map(|v| shown(v + std * random.noise())).collect()
}

/// Signals as rigs give them when nothing is wrong.
fn clean() -> Vec<(&'static str, Vec<f64>)> {
    let stairs = staircase(&[0.0, 100.0, 200.0, 300.0, 200.0, 100.0, 0.0], 500, 60);
    let tall = staircase(&[0.0, 300.0, 0.0], 600, 40);
    let cycles: Vec<f64> = (0..6).flat_map(|_| staircase(&[5.0, 250.0, 5.0], 300, 20)).collect();
    // A gauge shows zero below a threshold, then a force with noise, and zero again.
    let force: Vec<f64> = (0..3).flat_map(|_| staircase(&[0.0, 0.0, 8.0, 0.0, 0.0], 200, 50)).collect();
    let mut random = Random(5);
    let touched: Vec<f64> =
        force.iter().map(|f| if *f < 0.05 { 0.0 } else { (f + 0.02 * random.noise()).max(0.0) }).collect();
    let fast: Vec<f64> = (0..4).flat_map(|_| [vec![0.0; 300], vec![6.0; 200]].concat()).collect();
    let fast = fast.iter().map(|f| if *f == 0.0 { 0.0 } else { printed(f + 0.02 * random.noise()) }).collect();
    let random_steps: Vec<f64> = (0..80).flat_map(|_| vec![5.0 * random.below(60) as f64; 100]).collect();
    let last_longest = [random_steps.clone(), vec![310.0; 1500]].concat();
    let mut held = Vec::new();
    for i in 0..600_u32 {
        held.extend(vec![(f64::from(i) * 0.02).sin() * 40.0 + random.noise(); 9 + random.below(4)]);
    }
    let walk = signal(9000, 3, |i, r| (i * 0.001).sin() + 0.02 * r.noise());
    vec![
        ("noise", signal(5000, 1, |_, r| r.noise())),
        ("noise of a converter", signal(5000, 2, |_, r| adc(100.0 + 3.0 * r.noise()))),
        (
            "sine with converter noise",
            signal(20_000, 3, |i, r| adc(200.0 + 150.0 * (i * 0.01).sin() + 0.15 * r.noise())),
        ),
        ("sine, no noise", signal(20_000, 3, |i, _| 200.0 + 150.0 * (i * 0.01).sin())),
        ("sine, converter, no noise", signal(20_000, 3, |i, _| adc(200.0 + 150.0 * (i * 0.001).sin()))),
        ("slow sine, fine noise", signal(50_000, 3, |i, r| adc(200.0 + 150.0 * (i * 2e-4).sin() + 0.03 * r.noise()))),
        ("ramp", signal(4000, 4, |i, r| printed(0.1 * i + 0.05 * r.noise()))),
        ("ramp, no noise", signal(4000, 4, |i, _| 0.1 * i)),
        ("staircase, command", stairs.clone()),
        ("staircase, noise", noisy(&stairs, 0.4, 6, printed)),
        ("staircase, converter, noise below its step", noisy(&stairs, 0.02, 6, adc)),
        ("staircase, converter, noise about a third of its step", noisy(&stairs, 0.04, 6, adc)),
        ("staircase, converter, noise half its step", noisy(&stairs, 0.06, 6, adc)),
        ("one plateau, command", tall.clone()),
        ("one plateau, converter, noise below its step", noisy(&tall, 0.02, 7, adc)),
        ("one plateau, converter, noise about its step", noisy(&tall, 0.12, 7, adc)),
        ("a tracker that a hand moves and puts down", {
            let moved = |i: f64, r: &mut Random| 10.0 * (i * 0.01).sin() + 0.05 * r.noise();
            let mut values = signal(1400, 12, |i, r| ((moved(i, r)) / 0.0112).round() * 0.0112);
            let rest = values[1250] + 0.0112;
            // It settles over a few steps of its grid and then flickers a little.
            values.splice(
                1251..,
                (0..300_u32).map(|i| rest + 0.0112 * f64::from((3 - (i / 6).min(3)) + u32::from(i == 230))),
            );
            values
        }),
        ("settings in a table", signal(460, 13, |_, r| 50.0 * (9.0 * r.even()).floor())),
        ("settings in a table, in order", signal(460, 13, |i, _| 50.0 * (i % 9.0))),
        ("cycles, command", cycles.clone()),
        ("cycles, converter", noisy(&cycles, 0.15, 8, adc)),
        ("cycles, converter, fine noise", noisy(&cycles, 0.02, 8, adc)),
        ("a gauge with zero until it is touched", touched),
        ("a gauge that is touched at once", fast),
        ("random steps, command", random_steps),
        ("random steps, command, the last and longest at the top", last_longest),
        ("a slow sensor in a fast log", held),
        ("counter", signal(5000, 1, |i, _| i)),
        ("counter of 8 bits", signal(5000, 1, |i, _| i % 256.0)),
        ("cycle number", signal(5000, 1, |i, _| (i / 500.0).floor())),
        ("time", signal(5000, 1, |i, _| i * 0.01)),
        ("time in ms, jitter", signal(5000, 1, |i, r| (10.0 * i + r.noise()).round())),
        ("variance", vec![0.25; 5000]),
        ("variance, set once", [vec![0.0; 300], vec![0.25; 5000]].concat()),
        ("valve", signal(5000, 1, |i, _| (i / 250.0).floor() % 2.0)),
        ("valve, pulsed", signal(5000, 1, |_, r| f64::from(u8::from(r.even() < 0.5)))),
        ("mode", signal(9000, 1, |i, _| ((i / 300.0).floor() % 6.0 - 2.0).abs())),
        ("filtered", walk.windows(5).map(|w| w.iter().sum::<f64>() / 5.0).collect()),
        (
            "temperature",
            signal(20_000, 9, |i, r| ((22.0 + 2.0 * (i * 1e-4).sin() + 0.02 * r.noise()) * 100.0).round() / 100.0),
        ),
        ("holes only", vec![f64::NAN; 3000]),
        ("nothing", vec![]),
        ("one number", vec![1.0]),
        ("a few", vec![1.0, 2.0, 1.5, 1.7, 1.7, 1.7]),
        ("short, noise", signal(60, 1, |_, r| r.noise())),
        (
            "every fifth cell, the others empty",
            signal(20_000, 2, |i, r| {
                let value = adc(100.0 + (i * 1e-3).sin() * 50.0 + 0.2 * r.noise());
                if i % 5.0 == 0.0 { value } else { f64::NAN }
            }),
        ),
    ]
}

#[test]
fn clean_columns_have_no_finding() {
    for (name, values) in clean() {
        assert_eq!(told(&values), [], "{name}: {:?}", summary(&values));
    }
}

#[test]
fn clean_columns_have_no_finding_whatever_the_noise() {
    // Noise from nothing to several steps of the converter, which is where a plateau looks most like a sensor that stopped.
    let plateaus = [
        staircase(&[0.0, 300.0, 0.0], 600, 40),
        staircase(&[20.0, 120.0, 220.0, 320.0, 20.0], 400, 30),
        staircase(&[50.0, 150.0, 50.0, 250.0], 1000, 10),
    ];
    for (seed, values) in (1..13).flat_map(|seed| plateaus.iter().map(move |p| (seed, p))) {
        let shift = 0.043 * seed as f64;
        let values: Vec<f64> = values.iter().map(|v| v + shift).collect();
        for tenths in [0, 1, 2, 3, 4, 5, 6, 8, 10, 15, 30] {
            let std = 0.1 * f64::from(tenths) * KPA_PER_CODE;
            let values = noisy(&values, std, seed, adc);
            assert_eq!(told(&values), [], "{tenths} tenths of a step, {seed}: {:?}", summary(&values));
        }
    }
}

#[test]
fn saturation_at_the_top_of_the_range_is_found() {
    let sine = |i: f64, r: &mut Random| 350.0 - 250.0 * (i * TAU / 2000.0).cos() + 0.3 * r.noise();
    let values = signal(6000, 11, |i, r| adc(sine(i, r)));
    let top: Vec<usize> = (0..values.len()).filter(|i| values[*i] == adc(500.0)).collect();
    let all = told(&values);
    let [(FindingKind::Saturated, count, spans)] = &all[..] else { panic!("{all:?}") };
    // Three times, each of about 600 samples; at the edges noise goes to and fro.
    assert_eq!(spans.len(), 3);
    assert!(*count <= top.len() && *count > top.len() - 30, "{count} of {}", top.len());
    for ((first, last), middle) in spans.iter().zip([1000, 3000, 5000]) {
        assert!(values[*first..=*last].iter().all(|v| *v == adc(500.0)));
        assert!(values[first - 1] < 500.0 && values[last + 1] < 500.0);
        assert!((first + last) / 2 > middle - 20 && (first + last) / 2 < middle + 20, "{first} to {last}");
    }
    let findings = summary(&values).findings("r.csv", "p", &LineMap::default());
    assert!(findings[0].text.starts_with("`p`: stays at exactly 500, its largest value, for "), "{}", findings[0].text);
}

#[test]
fn each_fault_is_found_at_its_samples() {
    let alive = |seed| signal(8000, seed, |i, r| adc(200.0 + 100.0 * (i * 0.004).sin() + 0.2 * r.noise()));
    let with = |range: std::ops::RangeInclusive<usize>, value: f64| {
        let mut values = alive(21);
        // What stands beside the fault differs from it.
        values[range.start() - 1] += 3.0 * KPA_PER_CODE;
        values[range.end() + 1] += 3.0 * KPA_PER_CODE;
        values[range].fill(value);
        values
    };
    assert_eq!(told(&with(3000..=3399, 500.0)), [(FindingKind::Saturated, 400, vec![(3000, 3399)])]);
    assert_eq!(told(&with(3000..=3399, -20.0)), [(FindingKind::Saturated, 400, vec![(3000, 3399)])]);
    assert_eq!(told(&with(1020..=1090, 233.5)), [(FindingKind::Flatline, 71, vec![(1020, 1090)])]);
    // A sensor that nothing reaches any more reads zero, which is no end of what it can show.
    assert_eq!(told(&with(1000..=6000, 0.0)), [(FindingKind::Flatline, 5001, vec![(1000, 6000)])]);
    // It stops for good, and for most of the log.
    let mut dead = alive(22);
    let held = dead[1999] + 7.0 * KPA_PER_CODE;
    dead[2000..].fill(held);
    assert_eq!(told(&dead), [(FindingKind::Flatline, 6000, vec![(2000, 7999)])]);
    // It stops now and then, on other values each time.
    let mut stops = alive(23);
    for (first, last) in [(1000, 1100), (3000, 3149), (5000, 5089)] {
        stops[first - 1] += 3.0 * KPA_PER_CODE;
        stops[last + 1] += 3.0 * KPA_PER_CODE;
        let held = stops[first];
        stops[first..=last].fill(held);
    }
    let spans = vec![(1000, 1100), (3000, 3149), (5000, 5089)];
    assert_eq!(told(&stops), [(FindingKind::Flatline, 101 + 150 + 90, spans)]);
    // Both at once, and numbers on no grid.
    let mut both = signal(8000, 24, |i, r| (i * 0.004).sin() + 0.01 * r.noise());
    both[2000..=2199].fill(1.5);
    both[4000..=4299].fill(0.2);
    assert_eq!(
        told(&both),
        [(FindingKind::Saturated, 200, vec![(2000, 2199)]), (FindingKind::Flatline, 300, vec![(4000, 4299)])]
    );
}

#[test]
fn a_gauge_at_the_end_of_its_range_is_found_beside_its_zero() {
    let mut random = Random(31);
    let force = [vec![0.0; 400], staircase(&[0.5, 60.0, 0.5], 150, 200), vec![0.0; 400]].concat();
    let values: Vec<f64> =
        force.iter().map(|f| if *f < 0.05 { 0.0 } else { printed((f + 0.05 * random.noise()).min(50.0)) }).collect();
    let all = told(&values);
    let [(FindingKind::Saturated, count, spans)] = &all[..] else { panic!("{all:?}") };
    assert_eq!(spans.len(), 1);
    assert!((200..=220).contains(count), "{all:?}");
    assert!(values[spans[0].0..=spans[0].1].iter().all(|v| *v == 50.0));
}

#[test]
fn holes_within_a_stretch_do_not_end_it() {
    let mut values = signal(4000, 41, |i, r| (i * 0.01).sin() + 0.05 * r.noise());
    values[1500..=1700].fill(0.125);
    for hole in [1500, 1550, 1551, 1700, 2000] {
        values[hole] = f64::NAN;
    }
    assert_eq!(told(&values), [(FindingKind::Flatline, 197, vec![(1501, 1699)])]);
    assert_eq!(summary(&values).holes, 5);
}

#[test]
fn few_steps_are_told_and_named() {
    let coarse =
        |step: f64| signal(5000, 51, move |i, r| ((3.0 * (i * 0.003).sin() + 0.1 * r.noise()) / step).round() * step);
    let findings = summary(&coarse(0.25)).findings("r.csv", "p", &LineMap::default());
    assert_eq!((findings.len(), findings[0].kind, findings[0].count), (1, FindingKind::Quantised, 5000));
    assert_eq!((findings[0].spans[0].first_sample, findings[0].spans[0].last_sample), (0, 4999));
    assert!(findings[0].text.contains("moves in steps of 0.25 and covers 2"), "{}", findings[0].text);
    assert_eq!(told(&coarse(0.02)), []);
    // A converter whose step print does not hide: 0.1221 shows as 0.12 and 0.13.
    let values: Vec<f64> =
        noisy(&staircase(&[3.0, 5.0, 3.0], 800, 300), 0.05, 52, adc).into_iter().map(printed).collect();
    let summary = summary(&values);
    assert!((summary.quantum.unwrap() / KPA_PER_CODE - 1.0).abs() < 0.01, "{:?}", summary.quantum);
    assert_eq!(told(&values).iter().map(|t| t.0).collect::<Vec<_>>(), [FindingKind::Quantised]);
}

#[test]
fn lines_are_named_where_there_are_lines() {
    let mut values = signal(3000, 61, |_, r| r.noise());
    values[1000..1100].fill(0.5);
    let mut lines = LineMap::default();
    (0..3000).for_each(|row| lines.push(row + 3));
    let findings = summary(&values).findings("r.csv", "p", &lines);
    assert_eq!((findings[0].spans[0].first_line, findings[0].spans[0].last_line), (1003, 1102));
    assert_eq!(
        findings[0].text,
        "`p`: stays at exactly 0.5 for 100 samples: samples 1000 to 1099 (lines 1003 to 1102); elsewhere it varies from sample to \
         sample: did the sensor stop?"
    );
}

#[test]
fn a_summary_says_what_the_numbers_are_like() {
    let seen = summary(&signal(50_000, 71, |i, r| adc(200.0 + 100.0 * (i * 0.001).sin() + 0.3 * r.noise())));
    assert!((seen.quantum.unwrap() / KPA_PER_CODE - 1.0).abs() < 1e-3, "{seen:?}");
    assert!((seen.noise.unwrap() / 0.3 - 1.0).abs() < 0.1, "{seen:?}");
    assert!((seen.mean.unwrap() - 200.0).abs() < 5.0 && seen.constant().is_none());
    let flat = summary(&[0.25, f64::NAN, 0.25, f64::INFINITY]);
    assert_eq!((flat.samples, flat.holes, flat.constant(), flat.mean), (4, 2, Some(0.25), Some(0.25)));
    assert_eq!(summary(&[7.0]).constant(), None);
    assert_eq!(summary(&[]), Summary::default());
    // Too large to be added, not too large to be numbers.
    let huge = summary(&[f64::MAX; 40]);
    assert_eq!((huge.holes, huge.range, huge.mean), (0, Some((f64::MAX, f64::MAX)), None));
}

#[test]
fn blocks_of_any_size_give_the_same() {
    let mut random = Random(81);
    let mut columns = clean();
    columns.push(("stopped, holes", {
        let mut values = signal(7000, 82, |i, r| adc(200.0 + 100.0 * (i * 0.004).sin() + 0.2 * r.noise()));
        values[1000..1500].fill(101.0);
        values[2040..2060].fill(f64::NAN);
        values[3000..3100].fill(500.0);
        values
    }));
    for (name, values) in columns {
        let at_once = summary(&values);
        let clock_at_once = clock(&values);
        for size_max in [7, 1024, 5000] {
            let (mut watch, mut clock_watch) = (Watch::default(), ClockWatch::default());
            let mut rest = &values[..];
            while !rest.is_empty() {
                let (block, later) = rest.split_at((1 + random.below(size_max)).min(rest.len()));
                watch.block(block);
                clock_watch.block(block);
                rest = later;
                assert_eq!(watch.samples() + rest.len(), values.len());
            }
            assert_eq!(watch.finish(), at_once, "{name}, up to {size_max}");
            assert_eq!(clock_watch.finish(), clock_at_once, "{name}, up to {size_max}");
        }
    }
}

fn clock(seconds: &[f64]) -> ClockSummary {
    let mut watch = ClockWatch::default();
    watch.block(seconds);
    watch.finish()
}

fn kinds(seconds: &[f64]) -> Vec<FindingKind> {
    clock_findings("r.csv", "t", seconds, None).iter().map(|f| f.kind).collect()
}

/// Steps, gaps and equal stamps, all kept: what is asked of a clock that never goes back.
fn exactly(seconds: &[f64]) -> (Option<f64>, Vec<(usize, usize)>, Vec<usize>) {
    let forward: Vec<usize> = (0..seconds.len()).filter(|i| seconds[*i].is_finite()).collect();
    let step = |p: &[usize]| seconds[p[1]] - seconds[p[0]];
    let median = pneuval_ingest::finding::median_step(&forward.iter().map(|i| seconds[*i]).collect::<Vec<_>>());
    let long = median.map_or(f64::INFINITY, |m| (5.0 * m).max(1e-3));
    let gaps = forward.windows(2).filter(|p| step(p) > long).map(|p| (p[0], p[1])).collect();
    let equal = forward.windows(2).filter(|p| step(p) == 0.0).map(|p| p[1]).collect();
    (median, gaps, equal)
}

#[test]
fn a_clock_that_goes_by_is_measured_as_one_that_is_kept() {
    let mut random = Random(91);
    for case in 0..120 {
        let (step, jitter) = (10_f64.powf(-4.0 + 4.0 * random.even()), random.even());
        let gap_share = if case % 3 == 0 { 0.0 } else { 0.03 };
        let mut now = if case % 2 == 0 { 0.0 } else { 1.7e9 };
        let count = 1 + random.below(3000);
        let seconds: Vec<f64> = (0..count)
            .map(|_| {
                now += match random.even() {
                    r if r < gap_share => step * (6.0 + 1000.0 * random.even()),
                    r if r < gap_share + 0.02 => 0.0,
                    _ => step * (1.0 + jitter * (random.even() - 0.5)),
                };
                if random.even() < 0.01 { f64::NAN } else { now }
            })
            .collect();
        let seen = clock(&seconds);
        let (median, gaps, equal) = exactly(&seconds);
        assert_eq!(seen.steps.usual_s.is_some(), median.is_some());
        if let Some((usual, median)) = seen.steps.usual_s.zip(median) {
            assert!((usual / median - 1.0).abs() < 2e-4, "{usual} for {median} of {count}");
        }
        let found: Vec<(usize, usize)> = seen.steps.gaps.iter().map(|gap| gap.samples).collect();
        assert_eq!((found, seen.steps.gap_count), (gaps.clone(), gaps.len()));
        assert_eq!((seen.steps.equal.count, seen.back_count), (equal.len(), 0));
        // What inspect says is what ingest says.
        assert_eq!(seen.findings("r.csv", "t", &LineMap::default()), clock_findings("r.csv", "t", &seconds, None));
    }
}

#[test]
fn more_gaps_than_are_remembered_are_counted_nevertheless() {
    let mut now = 0.0;
    let mut random = Random(92);
    let seconds: Vec<f64> = (0..50_000)
        .map(|i| {
            now += if i % 50 == 49 { 0.2 + random.even() } else { 0.01 };
            now
        })
        .collect();
    let seen = clock(&seconds);
    assert_eq!((seen.steps.gap_count, seen.steps.gaps.len()), (1000, 128));
    assert_eq!(seen.findings("r.csv", "t", &LineMap::default())[0].count, 1000);
}

#[test]
fn jitter_is_told_and_what_is_no_jitter_is_not() {
    let even = |i: f64, _: &mut Random| i * 0.01;
    assert_eq!(kinds(&signal(1000, 1, even)), []);
    assert_eq!(kinds(&signal(1000, 1, |i, r| i * 0.01 + 0.001 * r.even())), []);
    let shaken = signal(1000, 1, |i, r| i * 0.01 + 0.008 * r.even());
    let findings = clock_findings("r.csv", "t", &shaken, None);
    assert_eq!((findings.len(), findings[0].kind, findings[0].severity), (1, FindingKind::Jitter, Severity::Note));
    assert_eq!((findings[0].count, findings[0].spans[0].last_sample), (1000, 999));
    assert!(
        findings[0].text.contains("nine in ten are between 4.") && findings[0].text.contains("the usual one"),
        "{}",
        findings[0].text
    );
    // Stamps in whole milliseconds at 600 Hz and 1 kHz: steps of 1 and 2 ms, or 0, 1 and 2.
    assert_eq!(kinds(&signal(1000, 1, |i, _| (i / 0.6).floor() * 1e-3)), []);
    assert_eq!(kinds(&signal(1000, 1, |i, _| 1.7e9 + (i / 0.6).floor() * 1e-3)), []);
    // Gaps are gaps, and a handful of steps shows nothing.
    assert_eq!(kinds(&signal(1000, 1, |i, _| i * 0.01 + (i / 20.0).floor())), [FindingKind::Gap]);
    assert_eq!(kinds(&[0.0, 1.0, 3.0, 4.0, 6.5, 7.0]), []);
}

#[test]
fn clocks_that_begin_anew_are_recognised() {
    let microseconds = |bits: i32, first: f64, count: usize| -> Vec<f64> {
        (0..count).map(|i| ((first + 1000.0 * i as f64) % 2_f64.powi(bits)) * 1e-6).collect()
    };
    let wrap = |seconds: &[f64]| {
        let findings = clock_findings("r.csv", "t", seconds, None);
        let kinds: Vec<FindingKind> = findings.iter().map(|f| f.kind).collect();
        assert_eq!(kinds[..2], [FindingKind::TimeReversed, FindingKind::ClockWrap], "{findings:?}");
        assert_eq!((findings[0].severity, findings[1].severity), (Severity::Excluded, Severity::Note));
        (findings[1].count, findings[1].spans[0].last_sample, findings[1].text.clone())
    };
    let (count, sample, text) = wrap(&microseconds(32, 4_294_900_000.0, 500));
    assert_eq!((count, sample), (1, 68));
    assert!(text.contains("write `wrap = { value = 4294967296, unit = \"us\" }` under `[clock]`"), "{text}");
    let (count, sample, text) = wrap(&microseconds(16, 0.0, 5000));
    assert_eq!((count, sample), (76, 66));
    assert!(text.contains("value = 65536, unit = \"us\"") && text.contains("begins anew 76 times"), "{text}");
    let midnight: Vec<f64> = (0..400).map(|i| (86_398.0 + 0.01 * f64::from(i)) % 86_400.0).collect();
    let (count, sample, text) = wrap(&midnight);
    assert_eq!((count, sample), (1, 200));
    assert!(text.contains("midnight") && text.contains("value = 86400, unit = \"s\""), "{text}");
    let half = 2_f64.powi(31);
    let signed: Vec<f64> = (0..400).map(|i| half - 2000.0 + 10.0 * f64::from(i)).collect();
    let signed: Vec<f64> = signed.into_iter().map(|ms| if ms >= half { ms - 2.0 * half } else { ms } * 1e-3).collect();
    let (count, sample, text) = wrap(&signed);
    assert_eq!((count, sample), (1, 200));
    assert!(text.contains("with a sign") && text.contains("value = 4294967296, unit = \"ms\""), "{text}");
    // A logger that was started anew, and a stamp that came late, are not clocks that began anew.
    let restarted: Vec<f64> = (0..200).map(|i| f64::from(i % 137) * 0.01).collect();
    assert_eq!(kinds(&restarted), [FindingKind::TimeReversed]);
    assert_eq!(kinds(&[0.0, 1.0, 2.0, 1.5, 3.0]), [FindingKind::TimeReversed]);
}

#[test]
fn one_wild_stamp_makes_no_gap_while_it_goes_by() {
    let mut seconds: Vec<f64> = (0..100).map(|i| f64::from(i) * 0.01).collect();
    seconds[50] = 99.0;
    let seen = clock(&seconds);
    assert_eq!((seen.back_count, seen.steps.gap_count), (1, 0));
    assert_eq!(kinds(&seconds), [FindingKind::TimeReversed]);
    let findings = seen.findings("r.csv", "t", &LineMap::default());
    assert_eq!(findings[0].text, "`t`: time goes back once, first from 99 s back to 0.51 s: sample 51");
}

#[test]
fn a_declared_wrap_makes_one_clock_of_it() {
    use pneuval_ingest::finding::unwrap;
    let straight: Vec<f64> = (0..5000).map(|i| 0.001 * f64::from(i)).collect();
    let mut seconds: Vec<f64> = straight.iter().map(|t| t % 0.065_536).collect();
    seconds[777] = f64::NAN;
    let wraps = unwrap(&mut seconds, 0.065_536);
    assert_eq!((wraps.len(), wraps[0]), (76, 66));
    for (sample, (unwrapped, straight)) in seconds.iter().zip(&straight).enumerate().filter(|(i, _)| *i != 777) {
        assert!((unwrapped - straight).abs() < 1e-9, "{sample}");
    }
    assert_eq!(kinds(&seconds), [FindingKind::NoStamp]);
    // A stamp from before the wrap that was written behind it stays before it, and is told.
    let mut late = vec![9.8, 9.9, 0.0, 9.95, 0.1, 0.2];
    assert_eq!(unwrap(&mut late, 10.0), [2, 4]);
    assert_eq!(late, [9.8, 9.9, 10.0, 9.95, 10.1, 10.2]);
    for wrong in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert_eq!(unwrap(&mut late, wrong).len(), 0);
    }
    assert_eq!(late[5], 10.2);
}

#[test]
fn what_goes_back_is_left_out_in_place() {
    use pneuval_ingest::finding::{forward_samples, leave_forward};
    let mut random = Random(101);
    for _ in 0..200 {
        let seconds: Vec<f64> = (0..random.below(60))
            .map(|i| match random.even() {
                r if r < 0.1 => f64::INFINITY,
                r if r < 0.2 => i as f64 - 5.0 * random.even(),
                _ => i as f64,
            })
            .collect();
        let mut left = seconds.clone();
        leave_forward(&mut left);
        let kept: Vec<usize> = (0..left.len()).filter(|i| !left[*i].is_nan()).collect();
        assert_eq!(kept, forward_samples(&seconds));
        assert!(kept.iter().all(|i| left[*i] == seconds[*i]));
    }
}
