//! What a specimen does on the way to its equilibrium: hysteresis, softening, creep.
//!
//! With y0 the value at rest, D the deflection at full pressure, x the pressure as a share of the full one and d = y(x) - y0:
//!
//! | effect | what happens |
//! |---|---|
//! | first cycles (Mullins) | d is less by the share m exp(-n/c), n the cycles seen before |
//! | hysteresis | a play of half width w: s goes from +1 (loading) to -1 (unloading) over 2 w of x; d grows by h D g(x) (1 - s)/2, g(x) = r + (1 - r) 4x(1 - x), r what is left at zero |
//! | creep (Prony) | `y = y0 + d + Σ g_i (q_i - d)`, `dq_i/dt = (d - q_i)/τ_i` |
//!
//! So the loading branch of a conditioned specimen, held long enough, is the equilibrium curve: what the papers' tables print.

use super::plan::Specimen;

/// Half width of the play, as a share of the full pressure.
const PLAY: f64 = 0.01;

/// A cycle ends where the pressure falls below the first share of the full one, after it was above the second.
const CYCLE: (f64, f64) = (0.05, 0.5);

/// A specimen in one run.
#[derive(Debug, Clone)]
pub struct Behaviour<'a> {
    specimen: &'a Specimen,
    /// What this specimen and this run make of every deflection.
    factor: f64,
    /// Cycles seen.
    cycles: f64,
    has_risen: bool,
    /// Of the play: +1 loading, -1 unloading.
    side: f64,
    share: f64,
    step_s: f64,
}

/// One component of a quantity, on its way.
#[derive(Debug, Clone, Default)]
pub struct Component {
    /// The late parts of the deflection.
    late: Vec<f64>,
    /// The deflection a step before.
    before: f64,
}

impl<'a> Behaviour<'a> {
    /// A specimen that was loaded so often before, at rest since long; time goes in equal steps.
    pub fn new(specimen: &'a Specimen, factor: f64, cycles_before: u64, step_s: f64) -> Self {
        let cycles = cycles_before as f64;
        Self { specimen, factor, cycles, has_risen: false, side: 1.0, share: 0.0, step_s }
    }

    /// Goes on to the next pressure, as a share of the full one.
    pub fn go(&mut self, share: f64) {
        self.side = (self.side + (share - self.share) / PLAY).clamp(-1.0, 1.0);
        self.share = share;
        if share > CYCLE.1 {
            self.has_risen = true;
        } else if share < CYCLE.0 && self.has_risen {
            self.has_risen = false;
            self.cycles += 1.0;
        }
    }

    /// The value of a component whose equilibrium is `y`, at rest `rest`, with the deflection `full` at full pressure.
    pub fn value(&self, component: &mut Component, y: f64, rest: f64, full: f64) -> f64 {
        let Specimen { creep, hysteresis, residual, softening, softening_cycles, .. } = self.specimen;
        let x = self.share.clamp(0.0, 1.0);
        let opening = residual + (1.0 - residual) * 4.0 * x * (1.0 - x);
        let loop_part = hysteresis * full * opening * 0.5 * (1.0 - self.side);
        let softened = 1.0 - softening * (-self.cycles / softening_cycles).exp();
        let d = self.factor * softened * (y - rest + loop_part);
        // The first call finds it at rest.
        if component.late.len() < creep.len() {
            *component = Component { late: vec![d; creep.len()], before: d };
        }
        let mut value = rest + d;
        for ((share, time_s), late) in creep.iter().zip(&mut component.late) {
            *late = lagged(*late, component.before, d, self.step_s, *time_s);
            value += share * (*late - d);
        }
        component.before = d;
        value
    }
}

/// A first-order lag after a step in which its target goes straight from one value to another: the exact solution, so that nothing
/// depends on the length of steps.
pub fn lagged(value: f64, from: f64, to: f64, step_s: f64, time_s: f64) -> f64 {
    if time_s <= 0.0 {
        return to;
    }
    let behind = (to - from) / step_s * time_s;
    to - behind + (value - from + behind) * (-step_s / time_s).exp()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn after(specimen: &Specimen, path: &[f64], cycles: u64) -> Vec<f64> {
        let mut behaviour = Behaviour::new(specimen, 1.0, cycles, 0.01);
        let mut component = Component::default();
        let go = |x: &f64| {
            behaviour.go(*x);
            // y = 10 + 20 x.
            behaviour.value(&mut component, 10.0 + 20.0 * x, 10.0, 20.0)
        };
        path.iter().map(go).collect()
    }

    #[test]
    fn creep_follows_its_prony_series_and_ends_at_equilibrium() {
        let specimen = Specimen { creep: vec![(0.1, 2.0)], ..Specimen::default() };
        let path: Vec<f64> = (0..3000).map(|i| if i < 10 { 0.0 } else { 1.0 }).collect();
        let y = after(&specimen, &path, 0);
        // The step is a ramp of h = 0.01 s, τ = 2 s: at t after its end 30 - 0.1·20·(τ/h)(1 - exp(-h/τ)) exp(-t/τ).
        for i in [10, 110, 410, 2999] {
            let t = 0.01 * f64::from(i - 10);
            let expected = 30.0 - 2.0 * 200.0 * (1.0 - (-0.005_f64).exp()) * (-t / 2.0).exp();
            assert!((y[usize::try_from(i).unwrap()] - expected).abs() < 1e-9, "{i}");
        }
    }

    #[test]
    fn loading_is_the_equilibrium_and_unloading_lies_above_by_the_loop() {
        let specimen = Specimen { hysteresis: 0.05, residual: 0.2, ..Specimen::default() };
        let path: Vec<f64> = (0..=100).chain((0..100).rev()).map(|i| f64::from(i) / 100.0).collect();
        let y = after(&specimen, &path, 0);
        assert!((y[50] - 20.0).abs() < 1e-12);
        assert!((y[150] - 21.0).abs() < 1e-12, "half way down: 5 % of 20 more");
        assert!((y[200] - (10.0 + 0.05 * 0.2 * 20.0)).abs() < 1e-12, "what is left at zero");
    }

    #[test]
    fn a_virgin_specimen_is_stiffer_in_its_first_cycle() {
        let specimen = Specimen { softening: 0.1, softening_cycles: 1.0, ..Specimen::default() };
        let path = [0.0, 1.0, 0.0, 1.0];
        let y = after(&specimen, &path, 0);
        assert!((y[1] - (10.0 + 0.9 * 20.0)).abs() < 1e-12);
        assert!((y[3] - (10.0 + (1.0 - 0.1 * (-1.0_f64).exp()) * 20.0)).abs() < 1e-12);
        assert!((after(&specimen, &path, 50)[1] - 30.0).abs() < 1e-9);
    }
}
