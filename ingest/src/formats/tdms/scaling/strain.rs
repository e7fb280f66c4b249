//! Strain gauges in a Wheatstone bridge.

use super::Unsupported;
use super::stated::Stated;

/// From the voltage out of a bridge to the strain of its gauges.
///
/// Two dividers stand between the poles of the excitation: R1 above R2, and R4 above R3. The bridge gives the difference of their
/// middles. A gauge along the strain has the resistance R0 (1 + G ε), one across it R0 (1 - ν G ε), one on the other side of what is
/// bent both with -ε.
///
/// ```text
/// V / U = R3 / (R3 + R4) - R2 / (R1 + R2)        r = (V - V0) / U
/// ```
///
/// | code  | configuration    | gauges, as parts of R0 that they change by                | V / U                                   |
/// |-------|------------------|-----------------------------------------------------------|-----------------------------------------|
/// | 10183 | full bridge I    | R1, R3: -G ε; R2, R4: +G ε                                | -G ε                                    |
/// | 10184 | full bridge II   | R1: -ν G ε; R2: +ν G ε; R3: -G ε; R4: +G ε                | -G ε (1 + ν) / 2                        |
/// | 10185 | full bridge III  | R1, R3: -ν G ε; R2, R4: +G ε                              | -G ε (1 + ν) / (2 + G ε (1 - ν))        |
/// | 10188 | half bridge I    | R3: -ν G ε; R4: +G ε                                      | -G ε (1 + ν) / (4 + 2 G ε (1 - ν))      |
/// | 10189 | half bridge II   | R3: -G ε; R4: +G ε                                        | -G ε / 2                                |
/// | 10271 | quarter bridge I | R4: +G ε                                                  | -G ε / (4 + 2 G ε)                      |
/// | 10272 | quarter bridge II | as I; a gauge that is not strained completes the bridge  | as I                                    |
///
/// Solved for the strain, with the correction of a shunt calibration k and that of the wires l = 1 + RL / Rg:
///
/// ```text
/// full I:    ε = -k r / G
/// full II:   ε = -2 k r / (G (1 + ν))
/// full III:  ε = -2 k r / (G ((1 + ν) + r (1 - ν)))
/// half I:    ε = -4 k l r / (G ((1 + ν) + 2 r (1 - ν)))
/// half II:   ε = -2 k l r / G
/// quarter:   ε = (2 k l / G) (1 / (1 + 2 r) - 1) = -4 k l r / (G (1 + 2 r))
/// ```
///
/// | symbol | property                                   | unit | domain                      |
/// |--------|--------------------------------------------|------|-----------------------------|
/// | V      | what it takes                              | V    |                             |
/// | V0     | `Initial_Bridge_Voltage`, without strain   | V    |                             |
/// | U      | `Voltage_Excitation`                       | V    | not 0                       |
/// | G      | `Gage_Factor`                              | 1    | not 0                       |
/// | ν      | `Poisson_Ratio`; full II and III, half I   | 1    | not -1                      |
/// | k      | `Bridge_Shunt_Calibration_Gain_Adjustment` | 1    | not 0                       |
/// | RL     | `Lead_Wire_Resistance`; half and quarter   | Ω    | not -Rg                     |
/// | Rg     | `Gage_Resistance`; half and quarter        | Ω    | not 0                       |
///
/// Returns ε in m/m, + where the gauge along it is stretched.
///
/// # Source
/// National Instruments, SCC-SG Series Strain-Gauge Modules User Guide, p. 43, prints full II and III, with r as Vr and G as GF. All
/// ratios V / U above were derived from the bridge, and the tests go from strain to voltage by its resistances. How k and l enter is as
/// npTDMS has it.
/// # Check value
/// Quarter bridge, G = 2, U = 10 V, ε = 1e-3: R4 = 1.002 R0, V = 10 (1 / 2.002 - 1 / 2) V = -4.995005 mV, and back.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Strain {
    /// V0.
    initial: f64,
    form: Form,
}

/// How strain follows from v = V - V0.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Form {
    /// `factor v`
    Proportional { factor: f64 },
    /// `v / (slope v + level)`
    Ratio { slope: f64, level: f64 },
    /// `(1 / (ratio v + 1) - 1) factor`
    Quarter { ratio: f64, factor: f64 },
}

impl Strain {
    pub(super) fn of(stated: &Stated) -> Result<Self, Unsupported> {
        let initial = stated.number("Initial_Bridge_Voltage")?;
        let gain = stated.divisor("Bridge_Shunt_Calibration_Gain_Adjustment")?;
        let (voltage, gauge) = (stated.divisor("Voltage_Excitation")?, stated.divisor("Gage_Factor")?);
        let poisson = || {
            let poisson = stated.number("Poisson_Ratio")?;
            let is_minus_one = 1.0 + poisson == 0.0;
            if is_minus_one { Err(stated.unsupported("states a Poisson ratio of -1")) } else { Ok(poisson) }
        };
        // 1 / l.
        let wires = || {
            let ratio = stated.number("Lead_Wire_Resistance")? / stated.divisor("Gage_Resistance")?;
            let is_short = 1.0 + ratio == 0.0;
            if is_short {
                Err(stated.unsupported("states wires that take away its resistance"))
            } else {
                Ok(1.0 / (1.0 + ratio))
            }
        };
        let form = match stated.count("Configuration")? {
            10_183 => Form::Proportional { factor: -gain / (voltage * gauge) },
            10_184 => Form::Proportional { factor: -gain * 2.0 / (voltage * gauge * (1.0 + poisson()?)) },
            10_185 => {
                let (common, poisson) = (-0.5 / gain, poisson()?);
                let slope = common * (1.0 - poisson) * gauge;
                Form::Ratio { slope, level: common * voltage * gauge * (1.0 + poisson) }
            }
            10_188 => {
                let (wires, poisson) = (wires()?, poisson()?);
                let common = -gauge * voltage * wires / (4.0 * gain);
                let slope = common * 2.0 * (1.0 - poisson) / voltage;
                Form::Ratio { slope, level: common * (1.0 + poisson) }
            }
            10_189 => Form::Proportional { factor: -2.0 * gain / (gauge * voltage * wires()?) },
            10_271 | 10_272 => Form::Quarter { ratio: 2.0 / voltage, factor: 2.0 * gain / (gauge * wires()?) },
            code => return Err(stated.unsupported(&format!("states the configuration {code}, which is not known"))),
        };
        let (first, second) = match form {
            Form::Proportional { factor } => (factor, 0.0),
            Form::Ratio { slope, level } => (slope, level),
            Form::Quarter { ratio, factor } => (ratio, factor),
        };
        if !first.is_finite() || !second.is_finite() {
            return Err(stated.unsupported("states numbers whose strain is beyond all numbers"));
        }
        Ok(Self { initial, form })
    }

    pub(super) fn apply(self, values: &[f64], out: &mut Vec<f64>) {
        let values = values.iter().map(|value| value - self.initial);
        match self.form {
            Form::Proportional { factor } => out.extend(values.map(|v| v * factor)),
            Form::Ratio { slope, level } => out.extend(values.map(|v| v / (v * slope + level))),
            Form::Quarter { ratio, factor } => out.extend(values.map(|v| (1.0 / (v * ratio + 1.0) - 1.0) * factor)),
        }
    }
}
