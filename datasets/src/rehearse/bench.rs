//! One run on the bench: from the programme through regulator and specimen to what every device logs.

use std::collections::VecDeque;

use pneuval_ingest::manifest::{Instrument, Rig};
use pneuval_ingest::units::Unit;

use super::instrument::Meter;
use super::plan::{Channel, Deviation, Device, Plan, Response, Shows, Sitting};
use super::programme::{Between, Plateau, State, Timeline, Walk};
use super::random::Normal;
use super::specimen::{Behaviour, Component, lagged};
use super::truth::Equilibrium;

/// The shortest and the longest step of the simulation, in s.
const STEP_S: (f64, f64) = (1e-4, 5e-3);

/// A stamp strays by no more than this share of a step: a clock without faults never goes back.
const STRAY_MAX: f64 = 0.4;

/// What a run does.
#[derive(Debug, Clone)]
pub struct RunSetting<'a> {
    /// Its id, which its noise depends on.
    pub id: &'a str,
    /// What the noise of the specimen depends on.
    pub sitting: &'a str,
    /// What this specimen makes of every deflection.
    pub factor: f64,
    /// Cycles that the specimen has seen.
    pub cycles_before: u64,
    /// What leaks.
    pub leak: Option<Leak>,
}

/// A chamber that leaks.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Leak {
    /// Index of the chamber in the programme.
    pub chamber: usize,
    /// Since when, in s.
    pub from_s: f64,
    /// The share of the pressure that is lost.
    pub share: f64,
}

/// What one device logs in one run.
#[derive(Debug, Clone, PartialEq)]
pub struct DeviceLog {
    /// Index of the device in the plan.
    pub device: usize,
    /// When each sample was taken, in s of the true time.
    pub true_s: Vec<f64>,
    /// The device's stamps, in s.
    pub stamps_s: Vec<f64>,
    /// Channels and their logged numbers.
    pub columns: Vec<LoggedColumn>,
}

/// What one channel logs.
#[derive(Debug, Clone, PartialEq)]
pub struct LoggedColumn {
    /// Index of the channel in the plan.
    pub channel: usize,
    /// The unit of the numbers.
    pub unit: Unit,
    /// Numbers.
    pub values: Vec<f64>,
}

/// What was there at a plateau.
#[derive(Debug, Clone, PartialEq)]
pub struct TruePoint {
    /// The plateau as it was asked for.
    pub plateau: Plateau,
    /// Mean pressures over its window, in Pa.
    pub pressures_pa: Vec<f64>,
    /// Of each response, each component: at equilibrium at these pressures, and the mean over the window without noise.
    pub values: Vec<Vec<(f64, f64)>>,
}

/// A run, logged.
#[derive(Debug, Clone, PartialEq)]
pub struct RunLog {
    /// Devices in the order of the plan, those that log something.
    pub devices: Vec<DeviceLog>,
    /// What was there.
    pub points: Vec<TruePoint>,
}

/// A sitting, ready to run.
pub struct Bench<'a> {
    /// The plan.
    pub plan: &'a Plan,
    /// The sitting.
    pub sitting: &'a Sitting,
    /// The rig.
    pub rig: &'a Rig,
    /// Truth of each response.
    pub equilibria: &'a [Equilibrium],
    /// What is added at each level, of each response.
    pub deviations: &'a [Vec<f64>],
    /// Of each set, the values of the sitting's settings.
    pub settings: &'a [Vec<f64>],
    /// Ids of the settings.
    pub setting_ids: &'a [String],
    /// The largest pressure of each chamber, in Pa.
    pub full_pa: &'a [f64],
    /// The seed.
    pub seed: u64,
}

/// The signals of one moment, one after the other: commands, pressures, components, settings, the trigger.
type Signals = Vec<f64>;

impl Bench<'_> {
    /// The channels that a device logs in this sitting: pressures and triggers always, else what a response needs.
    pub fn channels_of<'p>(&'p self, device: &'p Device) -> impl Iterator<Item = (usize, &'p Channel)> + 'p {
        let is_of = move |channel: &Channel| channel.device == device.id && self.signal(&channel.shows).is_some();
        self.plan.channels.iter().enumerate().filter(move |(_, channel)| is_of(channel))
    }

    /// Where a signal stands among the others; `None` for one that this sitting does not have.
    fn signal(&self, shows: &Shows) -> Option<usize> {
        let chambers = &self.sitting.programme.chambers;
        let chamber = |id: &String| chambers.iter().position(|known| known == id);
        let responses = &self.sitting.responses;
        let width = |responses: &[Response]| responses.iter().map(|r| r.quantity.width()).sum::<usize>();
        match shows {
            Shows::Command(id) => chamber(id),
            Shows::Pressure(id) => Some(chambers.len() + chamber(id)?),
            Shows::Quantity(id, component) => {
                let index = responses.iter().position(|r| r.quantity.id == *id)?;
                (*component < responses[index].quantity.width())
                    .then(|| 2 * chambers.len() + width(&responses[..index]) + component)
            }
            Shows::Condition(id) => {
                let index = self.setting_ids.iter().position(|known| known == id)?;
                Some(2 * chambers.len() + width(responses) + index)
            }
            Shows::Trigger => Some(2 * chambers.len() + width(responses) + self.setting_ids.len()),
        }
    }

    /// Whether any device of the plan logs something in this sitting.
    pub fn logs(&self, device: &Device) -> bool {
        self.channels_of(device).any(|(_, channel)| channel.shows != Shows::Trigger)
    }

    /// Runs once.
    pub fn run(&self, timeline: &Timeline, setting: &RunSetting) -> RunLog {
        let fastest = self.plan.devices.iter().map(|device| device.rate_hz).fold(1.0, f64::max);
        let step_s = (0.5 / fastest).clamp(STEP_S.0, STEP_S.1);
        let mut physics = Physics::new(self, setting, step_s);
        let mut recorders: Vec<Recorder> = self.recorders(setting).collect();
        let mut watch = Watching::new(timeline, self.sitting.programme.window_s);
        let mut walk = Walk::new(timeline);
        let mut before = physics.signals(&walk.to(0.0), timeline, 0.0);
        let mut now = before.clone();
        let mut step = 0_u64;
        loop {
            let at_s = step as f64 * step_s;
            for recorder in &mut recorders {
                recorder.record(at_s, step_s, &before, &now, timeline);
            }
            watch.see(at_s, &now);
            if at_s >= timeline.end_s {
                break;
            }
            step += 1;
            std::mem::swap(&mut before, &mut now);
            let at_s = step as f64 * step_s;
            physics.step(&walk.to(at_s), timeline, at_s, &mut now);
        }
        let points = watch.finish(self);
        RunLog { devices: recorders.into_iter().map(Recorder::finish).collect(), points }
    }

    /// By how much a channel's instrument is off, in all that one seed rehearses: its declared standard uncertainty, once drawn.
    fn bias_si(&self, channel: &Channel, instrument: &Instrument) -> f64 {
        let Some(std) = instrument.std else { return 0.0 };
        if channel.is_flawless {
            return 0.0;
        }
        instrument.output.to_si(std) * Normal::new(self.seed, &format!("bias of {}", channel.id)).next()
    }

    fn recorders<'s>(&'s self, setting: &'s RunSetting) -> impl Iterator<Item = Recorder<'s>> + 's {
        self.plan.devices.iter().enumerate().filter(|(_, device)| self.logs(device)).map(|(index, device)| {
            let meters = self.channels_of(device).filter_map(|(i, channel)| {
                let instrument = channel.instrument.as_ref().and_then(|id| self.rig.instruments.get(id));
                let bias_si = instrument.map_or(0.0, |instrument| self.bias_si(channel, instrument));
                let purpose = format!("{} {} {}", setting.sitting, setting.id, channel.id);
                let meter = Meter::new(channel, instrument, bias_si, Normal::new(self.seed, &purpose));
                Some((i, self.signal(&channel.shows)?, meter, Vec::new()))
            });
            Recorder {
                index,
                device,
                meters: meters.collect(),
                jitter: Normal::new(self.seed, &format!("{} {} stamps of {}", setting.sitting, setting.id, device.id)),
                true_s: vec![],
                stamps_s: vec![],
            }
        })
    }
}

/// A device that logs.
struct Recorder<'a> {
    index: usize,
    device: &'a Device,
    meters: Vec<(usize, usize, Meter<'a>, Vec<f64>)>,
    jitter: Normal,
    true_s: Vec<f64>,
    stamps_s: Vec<f64>,
}

impl Recorder<'_> {
    /// Logs the samples that fall between the last step and this one.
    fn record(&mut self, at_s: f64, step_s: f64, before: &Signals, now: &Signals, timeline: &Timeline) {
        loop {
            let sample_s = self.true_s.len() as f64 / self.device.rate_hz;
            if sample_s > at_s || sample_s > timeline.end_s {
                return;
            }
            let share = (1.0 - (at_s - sample_s) / step_s).clamp(0.0, 1.0);
            for (_, signal, meter, values) in &mut self.meters {
                // An edge has no width: it is where it is, and not within a step of the simulation.
                let value = if meter.shows_trigger() {
                    f64::from(u8::from(timeline.is_triggered(sample_s)))
                } else {
                    before[*signal] + share * (now[*signal] - before[*signal])
                };
                values.push(meter.read(value, sample_s));
            }
            let Device { offset_s, drift, jitter_s, rate_hz, decimals, .. } = self.device;
            let stray = if *jitter_s > 0.0 { jitter_s * self.jitter.next() } else { 0.0 };
            let most = STRAY_MAX / rate_hz;
            // A clock does not begin before it begins.
            let stamp = offset_s + (1.0 + drift) * sample_s + stray.clamp(-most.min(sample_s), most);
            let scale = 10_f64.powi(i32::try_from(*decimals).unwrap_or(9));
            self.true_s.push(sample_s);
            self.stamps_s.push((stamp * scale).round() / scale + 0.0);
        }
    }

    fn finish(self) -> DeviceLog {
        let columns = self.meters.into_iter().map(|(channel, _, meter, values)| LoggedColumn {
            channel,
            unit: meter.logged(),
            values,
        });
        DeviceLog { device: self.index, true_s: self.true_s, stamps_s: self.stamps_s, columns: columns.collect() }
    }
}

/// From the programme to pressures and quantities, step by step.
struct Physics<'a> {
    bench: &'a Bench<'a>,
    setting: &'a RunSetting<'a>,
    step_s: f64,
    pressures: Vec<f64>,
    /// What the pressures go towards.
    targets: Vec<f64>,
    /// Of each response, if it is none of sums.
    behaviours: Vec<Option<(Behaviour<'a>, Vec<Component>)>>,
    /// What is measured, of the last steps, as long as the specimen's delay.
    late: VecDeque<Vec<f64>>,
}

impl<'a> Physics<'a> {
    fn new(bench: &'a Bench<'a>, setting: &'a RunSetting<'a>, step_s: f64) -> Self {
        let specimen = &bench.plan.specimen;
        let purpose = format!("{} {} specimen", setting.sitting, setting.id);
        let repeat = 1.0 + specimen.repeat * Normal::new(bench.seed, &purpose).next();
        let behaviour = |(response, equilibrium): (&Response, &Equilibrium)| {
            matches!(equilibrium, Equilibrium::Curves { .. }).then(|| {
                let behaviour = Behaviour::new(specimen, setting.factor * repeat, setting.cycles_before, step_s);
                (behaviour, vec![Component::default(); response.quantity.width()])
            })
        };
        let behaviours = bench.sitting.responses.iter().zip(bench.equilibria).map(behaviour).collect();
        let pressures = vec![0.0; bench.sitting.programme.chambers.len()];
        Self { bench, setting, step_s, targets: pressures.clone(), pressures, behaviours, late: VecDeque::new() }
    }

    fn signals(&mut self, between: &Between, timeline: &Timeline, at_s: f64) -> Signals {
        let mut signals = Vec::new();
        self.step(between, timeline, at_s, &mut signals);
        signals
    }

    fn step(&mut self, between: &Between, timeline: &Timeline, at_s: f64, signals: &mut Signals) {
        let Bench { plan, sitting, equilibria, deviations, settings, full_pa, .. } = self.bench;
        signals.clear();
        let regulator = plan.regulator;
        for i in 0..self.pressures.len() {
            signals.push(between.blend(|state| state.pressures_pa[i]));
        }
        for i in 0..self.pressures.len() {
            let leak = self.setting.leak.filter(|leak| leak.chamber == i && at_s >= leak.from_s);
            let lost = leak.map_or(0.0, |leak| leak.share);
            let target = signals[i] * (1.0 - regulator.droop) * (1.0 - lost);
            let before = std::mem::replace(&mut self.targets[i], target);
            self.pressures[i] = lagged(self.pressures[i], before, target, self.step_s, regulator.time_constant_s);
            signals.push(self.pressures[i]);
        }
        let mut at = Vec::with_capacity(sitting.responses.len());
        for (index, response) in sitting.responses.iter().enumerate() {
            at.push(signals.len());
            let width = response.quantity.width();
            match (&equilibria[index], &mut self.behaviours[index]) {
                (Equilibrium::Curves { chamber, sets }, Some((behaviour, components))) => {
                    let pressure = self.pressures[*chamber];
                    behaviour.go(pressure / full_pa[*chamber].max(f64::MIN_POSITIVE));
                    let deviation = between.blend(|state| level_of(&deviations[index], state));
                    for (c, component) in components.iter_mut().enumerate() {
                        let value_at =
                            |pressure: f64| between.blend(|state| sets[state.set].components[c].at(pressure));
                        let (rest, full) = (value_at(0.0), value_at(full_pa[*chamber]));
                        let y = value_at(pressure) + if c == 0 { deviation } else { 0.0 };
                        signals.push(behaviour.value(component, y, rest, full - rest));
                    }
                }
                (Equilibrium::Sum(parts), _) => {
                    for c in 0..width {
                        let sum = parts.iter().map(|part| signals[at[*part] + c]).sum();
                        signals.push(sum);
                    }
                }
                // Curves have a behaviour: `new` gives them one.
                (Equilibrium::Curves { .. }, None) => signals.extend(std::iter::repeat_n(f64::NAN, width)),
            }
        }
        if let Some(first) = at.first() {
            self.delay(&mut signals[*first..]);
        }
        for i in 0..self.bench.setting_ids.len() {
            signals.push(between.blend(|state| settings[state.set][i]));
        }
        signals.push(if timeline.is_triggered(at_s) { 1.0 } else { 0.0 });
    }
}

impl Physics<'_> {
    /// Replaces what is measured by what it was so long before as the specimen's delay: on a straight line between two steps. Before
    /// the beginning it was as it begins.
    fn delay(&mut self, measured: &mut [f64]) {
        let steps = self.bench.plan.specimen.delay_s / self.step_s;
        if steps <= 0.0 {
            return;
        }
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a plan's delay is a minute at most"
        )]
        let whole = steps.floor() as usize;
        self.late.push_front(measured.to_vec());
        self.late.truncate(whole + 2);
        let Some(first) = self.late.back() else { return };
        let nearer = self.late.get(whole).unwrap_or(first);
        let farther = self.late.get(whole + 1).unwrap_or(first);
        for (i, value) in measured.iter_mut().enumerate() {
            *value = nearer[i] + steps.fract() * (farther[i] - nearer[i]);
        }
    }
}

/// What is added at the level of a state.
fn level_of(deviations: &[f64], state: &State) -> f64 {
    state.level.and_then(|level| deviations.get(level)).copied().unwrap_or(0.0)
}

/// Means of the signals over the windows of plateaus.
struct Watching<'t> {
    timeline: &'t Timeline,
    window_s: f64,
    plateau: usize,
    sums: Vec<f64>,
    count: usize,
    means: Vec<(usize, Vec<f64>)>,
}

impl<'t> Watching<'t> {
    fn new(timeline: &'t Timeline, window_s: f64) -> Self {
        Self { timeline, window_s, plateau: 0, sums: vec![], count: 0, means: vec![] }
    }

    fn see(&mut self, at_s: f64, signals: &Signals) {
        while let Some(plateau) = self.timeline.plateaus.get(self.plateau) {
            if at_s <= plateau.to_s {
                if at_s >= (plateau.to_s - self.window_s).max(plateau.from_s) {
                    self.sums.resize(signals.len(), 0.0);
                    self.sums.iter_mut().zip(signals).for_each(|(sum, signal)| *sum += signal);
                    self.count += 1;
                }
                return;
            }
            self.close();
        }
    }

    fn close(&mut self) {
        if self.count > 0 {
            let mean = self.sums.iter().map(|sum| sum / self.count as f64).collect();
            self.means.push((self.plateau, mean));
        }
        self.sums.clear();
        self.count = 0;
        self.plateau += 1;
    }

    fn finish(mut self, bench: &Bench) -> Vec<TruePoint> {
        self.close();
        let chambers = bench.sitting.programme.chambers.len();
        let point = |(plateau, mean): (usize, Vec<f64>)| {
            let plateau = self.timeline.plateaus[plateau].clone();
            let pressures_pa = mean[chambers..2 * chambers].to_vec();
            let equilibrium =
                |response: usize, c: usize| bench.at_equilibrium(response, c, &plateau.state, &pressures_pa);
            let mut at = 2 * chambers;
            let values = bench.sitting.responses.iter().enumerate().map(|(index, response)| {
                let components = 0..response.quantity.width();
                let values = components.map(|c| (equilibrium(index, c), mean[at + c])).collect();
                at += response.quantity.width();
                values
            });
            let values = values.collect();
            TruePoint { plateau, pressures_pa, values }
        };
        let means = std::mem::take(&mut self.means);
        means.into_iter().map(point).collect()
    }
}

impl Bench<'_> {
    /// A component at equilibrium at a state, at the pressures that were there.
    fn at_equilibrium(&self, response: usize, component: usize, state: &State, pressures_pa: &[f64]) -> f64 {
        match &self.equilibria[response] {
            Equilibrium::Curves { chamber, sets } => {
                let deviation = if component == 0 { level_of(&self.deviations[response], state) } else { 0.0 };
                sets[state.set].components[component].at(pressures_pa[*chamber]) + deviation
            }
            Equilibrium::Sum(parts) => {
                parts.iter().map(|part| self.at_equilibrium(*part, component, state, pressures_pa)).sum()
            }
        }
    }
}

/// What is added at each of so many levels.
pub fn deviations(deviation: &Deviation, levels: usize) -> Result<Vec<f64>, String> {
    match deviation {
        Deviation::None => Ok(vec![0.0; levels]),
        Deviation::Each(each) if each.len() == levels => Ok(each.clone()),
        Deviation::Each(each) => Err(format!("{} amounts for {levels} levels", each.len())),
        Deviation::MaxAndRmse(max, rmse) => {
            let n = levels as f64;
            // (n - 1) a² + max² = n rmse², the largest in the middle, signs in turn.
            let square = (n * rmse * rmse - max * max) / (n - 1.0);
            if levels < 2 || square < 0.0 || square.sqrt() > *max {
                let least = (max / rmse).powi(2).ceil();
                return Err(format!(
                    "{levels} levels, where the largest asks for at least {least} and an RMSE below it"
                ));
            }
            let sign = |i: usize| if i.is_multiple_of(2) { 1.0 } else { -1.0 };
            Ok((0..levels).map(|i| sign(i) * if i == levels / 2 { *max } else { square.sqrt() }).collect())
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_largest_deviation_and_an_rmse_come_back_and_too_few_levels_are_refused() {
        // wave-finger, section 4.2: 4.682 and 0.962 mm of one series.
        let d = deviations(&Deviation::MaxAndRmse(4.682, 0.962), 26).unwrap();
        let rmse = (d.iter().map(|d| d * d).sum::<f64>() / 26.0).sqrt();
        assert!((rmse - 0.962).abs() < 1e-12);
        assert!((d.iter().map(|d| d.abs()).fold(0.0, f64::max) - 4.682).abs() < 1e-15);
        let error = deviations(&Deviation::MaxAndRmse(4.682, 0.962), 23).unwrap_err();
        assert!(error.contains("at least 24"), "{error}");
    }
}
