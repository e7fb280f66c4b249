//! Thermistors.

use super::Unsupported;
use super::stated::Stated;

/// Codes of NI-DAQmx for what drives a sensor.
const VOLTAGE_EXCITATION: u64 = 10_322;
const CURRENT_EXCITATION: u64 = 10_134;

/// From the voltage across a thermistor to its temperature, by the equation of Steinhart and Hart.
///
/// ```text
/// driven by a current:                    R' = V / I
/// driven by a voltage in series with R1:  R' = R1 / (U / V - 1)
///
/// R = R'             two wires driven by a voltage, or four wires
/// R = R' - 2 RL      two wires driven by a current
/// R = R' - RL        three wires
///
/// T = 1 / (A + B ln R + C (ln R)³) - T0        R in Ω
/// ```
///
/// | symbol  | property                                                       | unit | domain |
/// |---------|----------------------------------------------------------------|------|--------|
/// | V       | what it takes                                                  | V    | R > 0  |
/// | I or U  | `Excitation_Value`; `Excitation_Type` 10134 or 10322           | A, V | not 0  |
/// | R1      | `R1_Reference_Resistance`                                      | Ω    | not 0  |
/// | RL      | `Lead_Wire_Resistance`, of one wire                            | Ω    |        |
/// |         | `Resistance_Configuration`                                     |      | 2, 3, 4 wires |
/// | A, B, C | `A`, `B`, `C`                                                  | 1/K  |        |
/// | T0      | `Temperature_Offset`: 273.15 K gives degrees Celsius           | K    |        |
///
/// Returns T in K above T0. Where R is not positive there is no logarithm, and no number.
///
/// # Source
/// National Instruments, NI-DAQ User Manual for PC Compatibles, pp. 5-7 and 5-8: the divider and Steinhart-Hart. Which wires are taken
/// off is as npTDMS has it.
/// # Check value
/// A = 1.295361e-3, B = 2.343159e-4, C = 1.018703e-7 per K (p. 5-8), R = 5 kΩ: ln R = 8.517193, T = 298.1500 K, 25 °C.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Thermistor {
    driven: Driven,
    /// Of all the wires that are measured with it, in Ω.
    leads: f64,
    a: f64,
    b: f64,
    c: f64,
    offset: f64,
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Driven {
    ByCurrent { current: f64 },
    ByVoltage { voltage: f64, reference: f64 },
}

impl Thermistor {
    pub(super) fn of(stated: &Stated) -> Result<Self, Unsupported> {
        let value = || stated.divisor("Excitation_Value");
        let driven = match stated.count("Excitation_Type")? {
            CURRENT_EXCITATION => Driven::ByCurrent { current: value()? },
            VOLTAGE_EXCITATION => {
                Driven::ByVoltage { voltage: value()?, reference: stated.divisor("R1_Reference_Resistance")? }
            }
            code => return Err(stated.unsupported(&format!("states the excitation {code}, which is not known"))),
        };
        let lead = || stated.number("Lead_Wire_Resistance");
        let leads = match (stated.count("Resistance_Configuration")?, driven) {
            (2, Driven::ByCurrent { .. }) => 2.0 * lead()?,
            (3, _) => lead()?,
            (2, Driven::ByVoltage { .. }) | (4, _) => 0.0,
            (wires, _) => {
                return Err(
                    stated.unsupported(&format!("states the resistance configuration {wires}, which is not known"))
                );
            }
        };
        let number = |name| stated.number(name);
        let offset = number("Temperature_Offset")?;
        Ok(Self { driven, leads, a: number("A")?, b: number("B")?, c: number("C")?, offset })
    }

    pub(super) fn apply(self, values: &[f64], out: &mut Vec<f64>) {
        match self.driven {
            Driven::ByCurrent { current } => out.extend(values.iter().map(|v| self.temperature(v / current))),
            Driven::ByVoltage { voltage, reference } => {
                out.extend(values.iter().map(|v| self.temperature(reference * (1.0 / (voltage * (1.0 / v) - 1.0)))));
            }
        }
    }

    /// `R'` to T.
    fn temperature(self, measured: f64) -> f64 {
        let log = (measured - self.leads).ln();
        // From the highest power down; there is no square.
        let cubic = ((self.c + log * 0.0) * log) * log;
        1.0 / (self.a + (self.b + cubic) * log) - self.offset
    }
}
