//! Unit symbols, their dimension, and the way to SI.

use crate::error::suggestion;

/// What kind of quantity a unit measures.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Dimension {
    /// Pa. Gauge or absolute is said beside it, never by the unit.
    Pressure,
    /// m.
    Length,
    /// rad.
    Angle,
    /// N.
    Force,
    /// kg.
    Mass,
    /// m².
    Area,
    /// s.
    Time,
    /// V.
    Voltage,
    /// A pure number or a share.
    Ratio,
}

impl Dimension {
    /// Its SI unit.
    pub fn si_symbol(self) -> &'static str {
        match self {
            Self::Pressure => "Pa",
            Self::Length => "m",
            Self::Angle => "rad",
            Self::Force => "N",
            Self::Mass => "kg",
            Self::Area => "m2",
            Self::Time => "s",
            Self::Voltage => "V",
            Self::Ratio => "1",
        }
    }

    /// Its name in error messages, with examples of units.
    pub fn name(self) -> &'static str {
        match self {
            Self::Pressure => "a pressure (Pa, kPa, MPa, bar, psi)",
            Self::Length => "a length (mm, cm, m)",
            Self::Angle => "an angle (deg, rad)",
            Self::Force => "a force (N, mN)",
            Self::Mass => "a mass (g, kg)",
            Self::Area => "an area (mm2, cm2, m2)",
            Self::Time => "a time (s, ms)",
            Self::Voltage => "a voltage (V, mV)",
            Self::Ratio => "a number or share (1, %)",
        }
    }

    /// The unit in which people at a rig read it.
    pub fn display_unit(self) -> Unit {
        let symbol = match self {
            Self::Pressure => "kPa",
            Self::Length => "mm",
            Self::Angle => "deg",
            Self::Force => "N",
            Self::Mass => "g",
            Self::Area => "mm2",
            Self::Time => "s",
            Self::Voltage => "V",
            Self::Ratio => "1",
        };
        // Every symbol above stands in `UNITS`; `every_display_unit_is_known` holds it to that.
        Unit::parse(symbol).unwrap_or(UNITS[0])
    }
}

/// A unit: `value in SI = factor × value`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Unit {
    /// As written in files.
    pub symbol: &'static str,
    /// What it measures.
    pub dimension: Dimension,
    /// SI value of one.
    pub factor: f64,
}

const fn unit(symbol: &'static str, dimension: Dimension, factor: f64) -> Unit {
    Unit { symbol, dimension, factor }
}

/// Every known unit. Case counts: `mPa` is not `MPa`.
const UNITS: &[Unit] = &[
    unit("Pa", Dimension::Pressure, 1.0),
    unit("hPa", Dimension::Pressure, 1e2),
    unit("kPa", Dimension::Pressure, 1e3),
    unit("MPa", Dimension::Pressure, 1e6),
    unit("GPa", Dimension::Pressure, 1e9),
    unit("mbar", Dimension::Pressure, 1e2),
    unit("bar", Dimension::Pressure, 1e5),
    // 1 lbf (0.45359237 kg × 9.80665 m/s²) on 1 in² (25.4 mm squared), all exact by definition.
    unit("psi", Dimension::Pressure, 0.453_592_37 * 9.806_65 / (0.0254 * 0.0254)),
    unit("m", Dimension::Length, 1.0),
    unit("cm", Dimension::Length, 1e-2),
    unit("mm", Dimension::Length, 1e-3),
    unit("um", Dimension::Length, 1e-6),
    unit("in", Dimension::Length, 0.0254),
    unit("rad", Dimension::Angle, 1.0),
    unit("deg", Dimension::Angle, std::f64::consts::PI / 180.0),
    unit("N", Dimension::Force, 1.0),
    unit("mN", Dimension::Force, 1e-3),
    unit("kg", Dimension::Mass, 1.0),
    unit("g", Dimension::Mass, 1e-3),
    unit("m2", Dimension::Area, 1.0),
    unit("cm2", Dimension::Area, 1e-4),
    unit("mm2", Dimension::Area, 1e-6),
    unit("s", Dimension::Time, 1.0),
    unit("ms", Dimension::Time, 1e-3),
    unit("min", Dimension::Time, 60.0),
    unit("V", Dimension::Voltage, 1.0),
    unit("mV", Dimension::Voltage, 1e-3),
    unit("1", Dimension::Ratio, 1.0),
    unit("%", Dimension::Ratio, 1e-2),
];

impl Unit {
    /// The unit of a symbol.
    pub fn parse(symbol: &str) -> Option<Self> {
        UNITS.iter().find(|u| u.symbol == symbol).copied()
    }

    /// What to write instead of an unknown symbol.
    pub fn suggestion(symbol: &str) -> String {
        suggestion(symbol, UNITS.iter().map(|u| u.symbol))
    }

    /// A value in this unit, in SI.
    pub fn to_si(self, value: f64) -> f64 {
        value * self.factor
    }

    /// An SI value, in this unit.
    pub fn from_si(self, value_si: f64) -> f64 {
        value_si / self.factor
    }

    /// How the unit is set in print: `°`, `mm²`; nothing for a pure number.
    pub fn printed(self) -> &'static str {
        match self.symbol {
            "deg" => "°",
            "um" => "µm",
            "m2" => "m²",
            "cm2" => "cm²",
            "mm2" => "mm²",
            "1" => "",
            other => other,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const DIMENSIONS: [Dimension; 9] = [
        Dimension::Pressure,
        Dimension::Length,
        Dimension::Angle,
        Dimension::Force,
        Dimension::Mass,
        Dimension::Area,
        Dimension::Time,
        Dimension::Voltage,
        Dimension::Ratio,
    ];

    #[test]
    fn every_display_unit_is_known() {
        for dimension in DIMENSIONS {
            assert_eq!(dimension.display_unit().dimension, dimension);
            assert_eq!(Unit::parse(dimension.si_symbol()).unwrap().factor.to_bits(), 1.0_f64.to_bits());
        }
    }

    #[test]
    fn symbols_are_unique_and_case_counts() {
        for (i, a) in UNITS.iter().enumerate() {
            assert!(UNITS[i + 1..].iter().all(|b| a.symbol != b.symbol), "{}", a.symbol);
        }
        assert!(Unit::parse("mpa").is_none() && Unit::parse("KPa").is_none());
        assert_eq!(Unit::suggestion("Mpa"), "did you mean `MPa`?");
    }

    #[test]
    fn psi_is_the_defined_6894_757_pa() {
        // pdms-wall steps in 1 psi, printed as 6.89 kPa.
        let psi = Unit::parse("psi").unwrap();
        assert!((psi.to_si(1.0) - 6_894.757_293_168).abs() < 1e-6);
    }
}
