//! Units as products and quotients of symbols: `N mm`, `N/mm^2`, `1/(m Pa)`.

use pneuval_ingest::units::{Dimension as Known, Unit};

/// Powers of metre, kilogram, second and ampere.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Dimension(pub [f64; 4]);

/// Powers nearer than this are equal: roots of powers are rounded.
const SAME: f64 = 1e-9;

impl Dimension {
    /// A pure number.
    pub const NONE: Self = Self([0.0; 4]);

    /// Whether two are the same.
    pub fn same(self, other: Self) -> bool {
        self.0.iter().zip(other.0).all(|(a, b)| (a - b).abs() < SAME)
    }

    /// Whether it is a pure number.
    pub fn is_none(self) -> bool {
        self.same(Self::NONE)
    }

    /// Of a product.
    pub fn times(self, other: Self) -> Self {
        self.plus(other, 1.0)
    }

    /// Of a quotient.
    pub fn over(self, other: Self) -> Self {
        self.plus(other, -1.0)
    }

    /// Of a power.
    pub fn power(self, exponent: f64) -> Self {
        Self(self.0.map(|p| exponent * p))
    }

    fn plus(self, other: Self, sign: f64) -> Self {
        let mut powers = self.0;
        powers.iter_mut().zip(other.0).for_each(|(a, b)| *a += sign * b);
        Self(powers)
    }

    /// In symbols: that of a unit people use, or powers of base units.
    pub fn symbol(self) -> String {
        const NAMED: [&str; 12] = ["Pa", "N", "N m", "m", "m^2", "m^3", "m^4", "kg", "s", "V", "Ohm", "Hz"];
        if self.is_none() {
            return "a pure number".to_owned();
        }
        if let Some(name) = NAMED.iter().find(|name| parse(name).is_some_and(|unit| unit.dimension.same(self))) {
            return (*name).to_owned();
        }
        let parts = ["m", "kg", "s", "A"].iter().zip(self.0).filter(|(_, power)| power.abs() >= SAME);
        let part = |(name, power): (&&str, f64)| {
            if (power - 1.0).abs() < SAME {
                (*name).to_owned()
            } else {
                format!("{name}^{}", super::significant(power, 4))
            }
        };
        parts.map(part).collect::<Vec<_>>().join(" ")
    }
}

/// A unit: its dimension, and the SI value of one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Composite {
    /// What it measures.
    pub dimension: Dimension,
    /// The SI value of one.
    pub factor: f64,
}

/// A unit of factors, each perhaps with a power: `N mm`, `N/mm^2`, `mm4`, `1/(m Pa)`; what stands behind a `/` divides.
pub fn parse(text: &str) -> Option<Composite> {
    let mut unit = Composite { dimension: Dimension::NONE, factor: 1.0 };
    let mut sign = 1.0;
    for (i, side) in text.split('/').enumerate() {
        if i > 1 {
            return None;
        }
        for word in side.split([' ', '*', '·', '(', ')']).filter(|word| !word.is_empty()) {
            let one = factor(word)?;
            unit.dimension = unit.dimension.times(one.dimension.power(sign));
            unit.factor *= one.factor.powf(sign);
        }
        sign = -1.0;
    }
    Some(unit)
}

/// One factor of a unit.
fn factor(word: &str) -> Option<Composite> {
    if let Some(unit) = Unit::parse(word) {
        return Some(Composite { dimension: of(unit.dimension), factor: unit.factor });
    }
    let (symbol, power) = if let Some(parts) = word.split_once('^') {
        parts
    } else {
        word.split_at(word.find(|c: char| c.is_ascii_digit())?)
    };
    let power = power.parse::<f64>().ok()?;
    let unit = Unit::parse(symbol)?;
    Some(Composite { dimension: of(unit.dimension).power(power), factor: unit.factor.powf(power) })
}

fn of(known: Known) -> Dimension {
    let pressure = Dimension([-1.0, 1.0, -2.0, 0.0]);
    let length = Dimension([1.0, 0.0, 0.0, 0.0]);
    let volt = Dimension([2.0, 1.0, -3.0, -1.0]);
    match known {
        Known::Pressure => pressure,
        Known::Length => length,
        Known::Force => Dimension([1.0, 1.0, -2.0, 0.0]),
        Known::Torque => Dimension([2.0, 1.0, -2.0, 0.0]),
        Known::Mass => Dimension([0.0, 1.0, 0.0, 0.0]),
        Known::Area => length.power(2.0),
        Known::Time => Dimension([0.0, 0.0, 1.0, 0.0]),
        Known::Voltage => volt,
        Known::Frequency => Dimension([0.0, 0.0, -1.0, 0.0]),
        Known::Resistance => volt.over(Dimension([0.0, 0.0, 0.0, 1.0])),
        Known::AnglePerPressure => Dimension::NONE.over(pressure),
        Known::LengthPerPressure => length.over(pressure),
        Known::CurvaturePerPressure => Dimension::NONE.over(length.times(pressure)),
        Known::SecondMomentOfArea => length.power(4.0),
        // An angle is a ratio of lengths.
        Known::Angle | Known::Ratio => Dimension::NONE,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_multiply_and_divide() {
        let of = |text: &str| parse(text).unwrap();
        assert!(of("N/mm^2").dimension.same(of("Pa").dimension));
        assert!((of("N/mm^2").factor - 1e6).abs() < 1e-6);
        assert!(of("N mm").dimension.same(of("N m").dimension) && (of("N mm").factor - 1e-3).abs() < 1e-18);
        assert!((of("mm4").factor - 1e-12).abs() < 1e-24 && (of("mm^4").factor - 1e-12).abs() < 1e-24);
        assert_eq!(of("MPa mm^4 / mm").dimension.symbol(), "m^2 kg s^-2".replace("m^2 kg s^-2", "N m"));
        assert_eq!(of("deg").dimension.symbol(), "a pure number");
        assert!(parse("furlong").is_none() && parse("a/b/c").is_none());
    }
}
