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
    /// N m.
    Torque,
    /// kg.
    Mass,
    /// m².
    Area,
    /// s.
    Time,
    /// V.
    Voltage,
    /// Hz.
    Frequency,
    /// Ohm.
    Resistance,
    /// rad/Pa: bending per pressure.
    AnglePerPressure,
    /// m/Pa: elongation or deflection per pressure.
    LengthPerPressure,
    /// 1/(m Pa): curvature per pressure.
    CurvaturePerPressure,
    /// m⁴: second moment of area.
    SecondMomentOfArea,
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
            Self::Torque => "N m",
            Self::Mass => "kg",
            Self::Area => "m2",
            Self::Time => "s",
            Self::Voltage => "V",
            Self::Frequency => "Hz",
            Self::Resistance => "Ohm",
            Self::AnglePerPressure => "rad/Pa",
            Self::LengthPerPressure => "m/Pa",
            Self::CurvaturePerPressure => "1/(m Pa)",
            Self::SecondMomentOfArea => "m4",
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
            Self::Torque => "a torque (N m, N mm)",
            Self::Mass => "a mass (g, kg)",
            Self::Area => "an area (mm2, cm2, m2)",
            Self::Time => "a time (s, ms)",
            Self::Voltage => "a voltage (V, mV)",
            Self::Frequency => "a frequency (Hz, kHz)",
            Self::Resistance => "a resistance (Ohm, kOhm)",
            Self::AnglePerPressure => "an angle per pressure (rad/Pa, deg/kPa)",
            Self::LengthPerPressure => "a length per pressure (m/Pa, mm/kPa)",
            Self::CurvaturePerPressure => "a curvature per pressure (1/(m Pa), 1/(m kPa))",
            Self::SecondMomentOfArea => "a second moment of area (mm4, m4)",
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
            Self::Torque => "N m",
            Self::Mass => "g",
            Self::Area => "mm2",
            Self::Time => "s",
            Self::Voltage => "V",
            Self::Frequency => "Hz",
            Self::Resistance => "Ohm",
            Self::AnglePerPressure => "deg/kPa",
            Self::LengthPerPressure => "mm/kPa",
            Self::CurvaturePerPressure => "1/(m kPa)",
            Self::SecondMomentOfArea => "mm4",
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
    unit("N/mm2", Dimension::Pressure, 1e6),
    unit("N/cm2", Dimension::Pressure, 1e4),
    // 101325 Pa / 760, by definition.
    unit("Torr", Dimension::Pressure, 101_325.0 / 760.0),
    // Conventional density of mercury, 13 595.1 kg/m³, and standard gravity; 25.4 times that for an inch.
    unit("mmHg", Dimension::Pressure, 133.322_387_415),
    unit("inHg", Dimension::Pressure, 25.4 * 133.322_387_415),
    unit("m", Dimension::Length, 1.0),
    unit("cm", Dimension::Length, 1e-2),
    unit("mm", Dimension::Length, 1e-3),
    unit("um", Dimension::Length, 1e-6),
    unit("in", Dimension::Length, 0.0254),
    unit("rad", Dimension::Angle, 1.0),
    unit("deg", Dimension::Angle, std::f64::consts::PI / 180.0),
    unit("N", Dimension::Force, 1.0),
    unit("mN", Dimension::Force, 1e-3),
    unit("kN", Dimension::Force, 1e3),
    unit("N m", Dimension::Torque, 1.0),
    unit("N mm", Dimension::Torque, 1e-3),
    // Standard gravity, 9.80665 m/s², on 1 kg, 1 g and 1 lb (0.45359237 kg), all exact by definition.
    unit("kgf", Dimension::Force, 9.806_65),
    unit("gf", Dimension::Force, 9.806_65e-3),
    unit("lbf", Dimension::Force, 0.453_592_37 * 9.806_65),
    unit("kg", Dimension::Mass, 1.0),
    unit("g", Dimension::Mass, 1e-3),
    unit("m2", Dimension::Area, 1.0),
    unit("cm2", Dimension::Area, 1e-4),
    unit("mm2", Dimension::Area, 1e-6),
    unit("m4", Dimension::SecondMomentOfArea, 1.0),
    unit("mm4", Dimension::SecondMomentOfArea, 1e-12),
    unit("s", Dimension::Time, 1.0),
    unit("ms", Dimension::Time, 1e-3),
    unit("us", Dimension::Time, 1e-6),
    unit("ns", Dimension::Time, 1e-9),
    unit("min", Dimension::Time, 60.0),
    unit("h", Dimension::Time, 3600.0),
    unit("V", Dimension::Voltage, 1.0),
    unit("mV", Dimension::Voltage, 1e-3),
    unit("Hz", Dimension::Frequency, 1.0),
    unit("kHz", Dimension::Frequency, 1e3),
    unit("Ohm", Dimension::Resistance, 1.0),
    unit("kOhm", Dimension::Resistance, 1e3),
    unit("rad/Pa", Dimension::AnglePerPressure, 1.0),
    unit("rad/kPa", Dimension::AnglePerPressure, 1e-3),
    unit("deg/kPa", Dimension::AnglePerPressure, std::f64::consts::PI / 180.0 / 1e3),
    unit("deg/bar", Dimension::AnglePerPressure, std::f64::consts::PI / 180.0 / 1e5),
    unit("m/Pa", Dimension::LengthPerPressure, 1.0),
    unit("mm/kPa", Dimension::LengthPerPressure, 1e-6),
    unit("mm/bar", Dimension::LengthPerPressure, 1e-8),
    unit("1/(m Pa)", Dimension::CurvaturePerPressure, 1.0),
    unit("1/(m kPa)", Dimension::CurvaturePerPressure, 1e-3),
    unit("1/(m bar)", Dimension::CurvaturePerPressure, 1e-5),
    unit("1", Dimension::Ratio, 1.0),
    unit("%", Dimension::Ratio, 1e-2),
];

/// Spellings in headers of logs that stand for one unit only. Case does not count in them, so none is here that would have another
/// meaning in another case (`Mpa` may be MPa or mPa), and none that says more than the unit (`psig` is a gauge pressure).
const SPELLINGS: &[(&str, &str)] = &[
    ("pa", "Pa"),
    ("kpa", "kPa"),
    ("hpa", "hPa"),
    ("gpa", "GPa"),
    ("pascal", "Pa"),
    ("kilopascal", "kPa"),
    ("megapascal", "MPa"),
    ("bar", "bar"),
    ("millibar", "mbar"),
    ("psi", "psi"),
    ("torr", "Torr"),
    ("mmhg", "mmHg"),
    ("inhg", "inHg"),
    ("n/mm^2", "N/mm2"),
    ("n/mm²", "N/mm2"),
    ("n/cm^2", "N/cm2"),
    ("n/cm²", "N/cm2"),
    ("metre", "m"),
    ("meter", "m"),
    ("centimetre", "cm"),
    ("centimeter", "cm"),
    ("millimetre", "mm"),
    ("millimeter", "mm"),
    ("micrometre", "um"),
    ("micrometer", "um"),
    ("micron", "um"),
    ("µm", "um"),
    ("inch", "in"),
    ("inches", "in"),
    ("°", "deg"),
    ("deg", "deg"),
    ("degree", "deg"),
    ("rad", "rad"),
    ("radian", "rad"),
    ("newton", "N"),
    ("millinewton", "mN"),
    ("kilonewton", "kN"),
    ("kgf", "kgf"),
    ("lbf", "lbf"),
    ("nm", "N m"),
    ("n·m", "N m"),
    ("n-m", "N m"),
    ("gram", "g"),
    ("kg", "kg"),
    ("kilogram", "kg"),
    ("m²", "m2"),
    ("m^2", "m2"),
    ("cm²", "cm2"),
    ("cm^2", "cm2"),
    ("mm²", "mm2"),
    ("mm^2", "mm2"),
    ("sec", "s"),
    ("second", "s"),
    ("msec", "ms"),
    ("millisecond", "ms"),
    ("usec", "us"),
    ("µs", "us"),
    ("microsecond", "us"),
    ("nsec", "ns"),
    ("nanosecond", "ns"),
    ("minute", "min"),
    ("hr", "h"),
    ("hour", "h"),
    ("volt", "V"),
    ("millivolt", "mV"),
    ("hz", "Hz"),
    ("khz", "kHz"),
    ("hertz", "Hz"),
    ("ohm", "Ohm"),
    ("ω", "Ohm"),
    ("kohm", "kOhm"),
    ("kω", "kOhm"),
    ("°/kpa", "deg/kPa"),
    ("°/bar", "deg/bar"),
    ("percent", "%"),
];

/// How a unit was written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Spelling {
    /// As its symbol.
    Exact,
    /// In another way that can mean nothing else.
    Loose,
}

impl Unit {
    /// Of pure numbers.
    pub const ONE: Self = unit("1", Dimension::Ratio, 1.0);
    /// Percent, in which papers print relative errors.
    pub const PERCENT: Self = unit("%", Dimension::Ratio, 1e-2);
    /// Seconds, and what logs count in instead.
    pub const SECOND: Self = unit("s", Dimension::Time, 1.0);
    /// Milliseconds.
    pub const MILLISECOND: Self = unit("ms", Dimension::Time, 1e-3);
    /// Microseconds.
    pub const MICROSECOND: Self = unit("us", Dimension::Time, 1e-6);
    /// Nanoseconds.
    pub const NANOSECOND: Self = unit("ns", Dimension::Time, 1e-9);

    /// The unit that a header of a log means, brackets around it or not: for suggestions and for what a reader infers, never for
    /// what a user writes, where only the symbol counts.
    ///
    /// ```
    /// use pneuval_ingest::units::{Spelling, Unit};
    /// let told = |text| Unit::parse_loose(text).map(|(unit, spelling)| (unit.symbol, spelling));
    /// assert_eq!(told("[kPa]"), Some(("kPa", Spelling::Exact)));
    /// assert_eq!(told("Degrees"), Some(("deg", Spelling::Loose)));
    /// assert_eq!(told("Mpa"), None);
    /// ```
    pub fn parse_loose(text: &str) -> Option<(Self, Spelling)> {
        let text = text.trim();
        let inside = |open, close| text.strip_prefix(open).and_then(|t| t.strip_suffix(close));
        let text = inside('(', ')').or(inside('[', ']')).unwrap_or(text).trim();
        if let Some(unit) = Self::parse(text) {
            return Some((unit, Spelling::Exact));
        }
        if text == "pA" {
            return None;
        }
        // Two characters look like a micro sign, and two like an ohm sign; lower case makes one of the latter.
        let lower = text.to_lowercase().replace('\u{3bc}', "µ");
        let of = |word: &str| SPELLINGS.iter().find(|(spelling, _)| *spelling == word).map(|(_, symbol)| *symbol);
        // Only whole words have a plural.
        let singular = lower.strip_suffix('s').filter(|word| word.len() > 2 && word.is_ascii());
        let symbol = of(&lower).or_else(|| singular.and_then(of))?;
        Self::parse(symbol).map(|unit| (unit, Spelling::Loose))
    }

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

    /// An SI value in this unit as a file should hold it: of the numbers that read back as this very SI value the one with fewest
    /// digits, so that 7.3° are 7.3 again; the nearest one where none does.
    ///
    /// ```
    /// use pneuval_ingest::units::Unit;
    /// let deg = Unit::parse("deg").unwrap();
    /// let si = deg.to_si(7.3);
    /// assert_ne!(deg.from_si(si), 7.3);
    /// assert_eq!(deg.to_written(si), 7.3);
    /// ```
    pub fn to_written(self, value_si: f64) -> f64 {
        let nearest = self.from_si(value_si);
        if self.factor.to_bits() == 1.0_f64.to_bits() || !nearest.is_finite() {
            return nearest;
        }
        // Fifteen digits are what a double holds of any decimal number.
        let short = format!("{nearest:.14e}").parse().unwrap_or(nearest);
        let reads_back = |value: &f64| self.to_si(*value).to_bits() == value_si.to_bits();
        let near = [short, nearest, nearest.next_up(), nearest.next_down()];
        near.into_iter().find(reads_back).unwrap_or(nearest)
    }

    /// How the unit is set in print: `°`, `mm²`; nothing for a pure number.
    pub fn printed(self) -> &'static str {
        match self.symbol {
            "deg" => "°",
            "um" => "µm",
            "m2" => "m²",
            "cm2" => "cm²",
            "mm2" => "mm²",
            "mm4" => "mm⁴",
            "us" => "µs",
            "Ohm" => "Ω",
            "kOhm" => "kΩ",
            "N/mm2" => "N/mm²",
            "N/cm2" => "N/cm²",
            "deg/kPa" => "°/kPa",
            "deg/bar" => "°/bar",
            "1" => "",
            other => other,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const DIMENSIONS: [Dimension; 14] = [
        Dimension::Pressure,
        Dimension::Length,
        Dimension::Angle,
        Dimension::Force,
        Dimension::Mass,
        Dimension::Area,
        Dimension::Time,
        Dimension::Voltage,
        Dimension::Frequency,
        Dimension::Resistance,
        Dimension::AnglePerPressure,
        Dimension::LengthPerPressure,
        Dimension::CurvaturePerPressure,
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
    fn what_is_written_reads_back_as_the_same_si_value() {
        let mut state = 0x9e37_79b9_7f4a_7c15_u64;
        for unit in UNITS {
            for i in 0..2_000 {
                state ^= state << 13;
                state ^= state >> 7;
                state ^= state << 17;
                // Decimals as instruments write them, and doubles with every digit.
                let decimal = ((state % 2_000_000) as f64 - 1e6) / 1e4;
                let value = if i % 2 == 0 { decimal } else { decimal * std::f64::consts::PI };
                let si = unit.to_si(value);
                let written = unit.to_written(si);
                assert_eq!(unit.to_si(written).to_bits(), si.to_bits(), "{value} {}", unit.symbol);
                if i % 2 == 0 {
                    assert_eq!(written.to_bits(), value.to_bits(), "{value} {}", unit.symbol);
                }
            }
            assert!(unit.to_written(f64::NAN).is_nan() && unit.to_written(0.0) == 0.0);
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

    #[test]
    fn loose_spellings_are_of_known_units_and_mean_one_thing() {
        for (i, (spelling, symbol)) in SPELLINGS.iter().enumerate() {
            assert!(Unit::parse(symbol).is_some(), "{symbol}");
            assert_eq!(*spelling, spelling.to_lowercase());
            assert!(SPELLINGS[i + 1..].iter().all(|(other, _)| spelling != other), "{spelling}");
        }
        let told = |text| Unit::parse_loose(text).map(|(unit, spelling)| (unit.symbol, spelling == Spelling::Exact));
        for (text, symbol) in [
            ("Kpa", "kPa"),
            ("KPA", "kPa"),
            ("°", "deg"),
            ("degrees", "deg"),
            ("\u{b5}m", "um"),
            ("\u{3bc}m", "um"),
            ("mm²", "mm2"),
            ("sec", "s"),
            ("secs", "s"),
            ("Volts", "V"),
            ("(PSI)", "psi"),
            ("\u{3a9}", "Ohm"),
            ("\u{2126}", "Ohm"),
        ] {
            assert_eq!(told(text), Some((symbol, false)), "{text}");
        }
        assert_eq!(told(" [ mPa ] "), None);
        assert_eq!(told("[MPa]"), Some(("MPa", true)));
        for text in ["mpa", "Mpa", "pA", "psig", "mbars", "p", "", "S", "MS"] {
            assert_eq!(told(text), None, "{text}");
        }
    }

    #[test]
    fn units_of_force_and_mercury_have_their_defined_values() {
        let si = |symbol| Unit::parse(symbol).map(|unit| unit.to_si(1.0)).unwrap();
        assert!((si("lbf") - 4.448_221_615_260_5).abs() < 1e-12);
        assert!((si("inHg") - 3_386.388_640_341).abs() < 1e-9);
        assert!((si("Torr") - 133.322_368_421).abs() < 1e-9);
        assert!((si("deg/kPa") - 1.745_329_251_994_33e-5).abs() < 1e-18);
    }
}
