//! What an instrument logs of what is there: bias, drift, noise, saturation, resolution, the way back through its calibration, and
//! the decimals of the log.

use pneuval_ingest::calibration::Calibration;
use pneuval_ingest::manifest::Instrument;
use pneuval_ingest::units::Unit;

use super::plan::{Channel, Shows};
use super::random::Normal;

/// Steps of a bisection: a double has no more.
const BISECTIONS: usize = 64;

/// A channel's instrument in one run.
#[derive(Debug)]
pub struct Meter<'a> {
    channel: &'a Channel,
    instrument: Option<&'a Instrument>,
    /// The unit that is measured, and the one that is logged.
    measured: Unit,
    logged: Unit,
    bias_si: f64,
    noise: Normal,
    /// 10 to the decimals.
    scale: f64,
}

impl<'a> Meter<'a> {
    /// An instrument; its bias is that of the seed, its noise that of the run.
    pub fn new(channel: &'a Channel, instrument: Option<&'a Instrument>, bias_si: f64, noise: Normal) -> Self {
        let own = channel.unit.unwrap_or(Unit::ONE);
        let (logged, measured) = instrument.map_or((own, own), |i| (i.input, i.output));
        let decimals = i32::try_from(channel.decimals).unwrap_or(0);
        Self { channel, instrument, measured, logged, bias_si, noise, scale: 10_f64.powi(decimals) }
    }

    /// The unit of what is logged.
    pub fn logged(&self) -> Unit {
        self.logged
    }

    /// Whether it logs the trigger line.
    pub fn shows_trigger(&self) -> bool {
        self.channel.shows == Shows::Trigger
    }

    /// The logged number of a true value at a time; NaN where the calibration gives no such reading.
    pub fn read(&mut self, true_si: f64, at_s: f64) -> f64 {
        let noise = if self.channel.noise_si > 0.0 { self.channel.noise_si * self.noise.next() } else { 0.0 };
        let drifted = true_si + self.bias_si + self.channel.drift_si_per_s * at_s + noise;
        let mut value = self.measured.from_si(drifted);
        let Some(instrument) = self.instrument else { return self.rounded(value) };
        if let Some((min, max)) = instrument.range {
            value = value.clamp(min, max);
        }
        if let Some(step) = instrument.resolution {
            value = (value / step).round() * step;
        }
        let logged = match &instrument.calibration {
            None => self.logged.from_si(self.measured.to_si(value)),
            Some(calibration) => inverse(calibration, instrument.valid, value).unwrap_or(f64::NAN),
        };
        self.rounded(logged)
    }

    fn rounded(&self, value: f64) -> f64 {
        // No negative zero: nobody logs one.
        (value * self.scale).round() / self.scale + 0.0
    }
}

/// What an instrument puts out when it measures `y`: the other way through its calibration. Of a polynomial the way is looked for
/// within the valid range only.
pub fn inverse(calibration: &Calibration, valid: Option<(f64, f64)>, y: f64) -> Option<f64> {
    let x = match calibration {
        Calibration::Line { slope, offset } => (y - offset) / slope,
        Calibration::Divider { supply, gain, offset } => gain * supply / (y - offset + gain),
        Calibration::Table { points } => {
            let (low, high) = (points.first()?.0, points.last()?.0);
            bisect(|x| calibration.apply(x), low, high, y)?
        }
        Calibration::Polynomial { .. } => {
            let (low, high) = valid?;
            bisect(|x| calibration.apply(x), low, high, y)?
        }
    };
    x.is_finite().then_some(x)
}

fn bisect(of: impl Fn(f64) -> Option<f64>, mut low: f64, mut high: f64, y: f64) -> Option<f64> {
    let rises = of(high)? > of(low)?;
    let (least, most) = if rises { (of(low)?, of(high)?) } else { (of(high)?, of(low)?) };
    let y = y.clamp(least, most);
    for _ in 0..BISECTIONS {
        let middle = 0.5 * (low + high);
        if (of(middle)? < y) == rises { low = middle } else { high = middle }
    }
    Some(0.5 * (low + high))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_logged_goes_back_through_the_calibration() {
        let table = Calibration::Table { points: vec![(0.0, 5.0), (1.0, 3.0), (4.0, 0.0)] };
        let cubic = Calibration::Polynomial { coefficients: vec![0.1, 24.2, -0.03, 0.4] };
        let line = Calibration::Line { slope: -3.0, offset: 2.0 };
        let flex = Calibration::Divider { supply: 5.0, gain: 70.74, offset: -109.3 };
        for (calibration, values) in [(table, [0.5, 2.9, 4.4]), (cubic, [1.0, 30.0, 90.0]), (line, [-1.0, 0.0, 9.0])] {
            for y in values {
                let x = inverse(&calibration, Some((0.0, 4.0)), y).unwrap();
                assert!((calibration.apply(x).unwrap() - y).abs() < 1e-9, "{calibration}: {y}");
            }
        }
        // The paper's flex sensor: 1.5 V are 55.76 deg.
        assert!((inverse(&flex, None, 55.76).unwrap() - 1.5).abs() < 1e-9);
    }
}
