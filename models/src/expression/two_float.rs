//! A number as the sum of two doubles: 32 digits.
//!
//! Error-free sums and products after Dekker 1971 (doi:10.1007/BF01397083) and Hida, Li and Bailey 2001 (doi:10.1109/ARITH.2001.930115). Our
//! own: the published crate's exponential function has 12 digits (0.8.4), which is fewer than a double has.

use std::ops::{Add, Div, Mul, Neg, Sub};

/// A number as the sum of two doubles, the second at most half a unit of the first's last digit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TwoFloat {
    high: f64,
    low: f64,
}

const LN_2: TwoFloat = TwoFloat { high: std::f64::consts::LN_2, low: 2.319_046_813_846_299_6e-17 };
const HALF_PI: TwoFloat = TwoFloat { high: std::f64::consts::FRAC_PI_2, low: 6.123_233_995_736_766e-17 };

impl From<f64> for TwoFloat {
    fn from(value: f64) -> Self {
        Self { high: value, low: 0.0 }
    }
}

impl From<TwoFloat> for f64 {
    fn from(value: TwoFloat) -> Self {
        value.high
    }
}

impl Add for TwoFloat {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        let sum = Self::sum(self.high, other.high);
        let low = Self::sum(self.low, other.low);
        let sum = Self::ordered(sum.high, sum.low + low.high);
        Self::ordered(sum.high, sum.low + low.low)
    }
}

impl Neg for TwoFloat {
    type Output = Self;
    fn neg(self) -> Self {
        Self { high: -self.high, low: -self.low }
    }
}

impl Sub for TwoFloat {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        self + -other
    }
}

impl Mul for TwoFloat {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        let high = self.high * other.high;
        let error = self.high.mul_add(other.high, -high);
        Self::ordered(high, error + (self.high * other.low + self.low * other.high))
    }
}

impl Div for TwoFloat {
    type Output = Self;
    fn div(self, other: Self) -> Self {
        let first = self.high / other.high;
        let rest = self - other * first.into();
        let second = rest.high / other.high;
        let rest = rest - other * second.into();
        Self::ordered(first, second) + (rest.high / other.high).into()
    }
}

impl TwoFloat {
    /// The sum of two doubles, exactly.
    pub fn sum(a: f64, b: f64) -> Self {
        let high = a + b;
        let part = high - a;
        Self { high, low: (a - (high - part)) + (b - part) }
    }

    /// The same where the first is the larger.
    fn ordered(a: f64, b: f64) -> Self {
        let high = a + b;
        Self { high, low: b - (high - a) }
    }

    /// Its size.
    #[must_use]
    pub fn abs(self) -> Self {
        if self.high < 0.0 { -self } else { self }
    }

    /// Its square root, one step of Newton's from that of a double.
    #[must_use]
    pub fn sqrt(self) -> Self {
        let root = self.high.sqrt();
        if !(root > 0.0 && root.is_finite()) {
            return root.into();
        }
        let rest = self - Self::from(root) * root.into();
        Self::ordered(root, 0.5 * rest.high / root)
    }

    /// A whole power, by squaring.
    #[must_use]
    pub fn powi(self, exponent: i32) -> Self {
        let (mut power, mut base, mut rest) = (Self::from(1.0), self, exponent.unsigned_abs());
        while rest > 0 {
            if rest & 1 == 1 {
                power = power * base;
            }
            base = base * base;
            rest >>= 1;
        }
        if exponent < 0 { Self::from(1.0) / power } else { power }
    }

    /// e to the power: `2^k (e^(r/512))^512` with `|r| <= ln 2 / 2`, a Taylor series for the inner one.
    #[must_use]
    pub fn exp(self) -> Self {
        const HALVINGS: i32 = 9;
        let whole = (self.high / std::f64::consts::LN_2).round();
        if whole.is_nan() || whole.abs() >= 1000.0 {
            return self.high.exp().into();
        }
        let r = (self - LN_2 * whole.into()) * 0.5_f64.powi(HALVINGS).into();
        // e^r - 1, whose digits survive the squarings better than those of e^r.
        let (mut term, mut sum) = (r, r);
        for k in 2..=9 {
            term = term * r / f64::from(k).into();
            sum = sum + term;
        }
        for _ in 0..HALVINGS {
            sum = sum * Self::from(2.0) + sum * sum;
        }
        // Whole and below 1000.
        #[expect(clippy::cast_possible_truncation)]
        let scale = 2.0_f64.powi(whole as i32);
        (sum + 1.0.into()) * scale.into()
    }

    /// Its natural logarithm, one step of Newton's from that of a double.
    #[must_use]
    pub fn ln(self) -> Self {
        let first = self.high.ln();
        if !first.is_finite() {
            return first.into();
        }
        Self::from(first) + (self * (-Self::from(first)).exp() - 1.0.into())
    }

    /// Sine and cosine: the argument reduced to an eighth of a turn, then their Taylor series.
    #[must_use]
    pub fn sin_cos(self) -> (Self, Self) {
        let quarters = (self.high / std::f64::consts::FRAC_PI_2).round();
        if quarters.is_nan() || quarters.abs() >= 1e9 {
            let (sin, cos) = self.high.sin_cos();
            return (sin.into(), cos.into());
        }
        let r = self - HALF_PI * quarters.into();
        let square = r * r;
        let (mut sin, mut cos) = (r, Self::from(1.0));
        let (mut sin_term, mut cos_term) = (r, Self::from(1.0));
        for k in 1..=14 {
            let k = 2.0 * f64::from(k);
            cos_term = -(cos_term * square) / (k * (k - 1.0)).into();
            sin_term = -(sin_term * square) / (k * (k + 1.0)).into();
            (sin, cos) = (sin + sin_term, cos + cos_term);
        }
        // Whole and below 1e9.
        #[expect(clippy::cast_possible_truncation)]
        match (quarters as i64).rem_euclid(4) {
            0 => (sin, cos),
            1 => (cos, -sin),
            2 => (-sin, -cos),
            _ => (-cos, sin),
        }
    }

    /// Its inverse tangent: from that of a double, `atan x = y + atan((x - tan y)/(1 + x tan y))`.
    #[must_use]
    pub fn atan(self) -> Self {
        let first = self.high.atan();
        let (sin, cos) = Self::from(first).sin_cos();
        let rest = (self * cos - sin) / (cos + self * sin);
        if rest.high.is_finite() { Self::from(first) + rest } else { first.into() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Digits beyond a double of values computed with 50: the second double of each.
    #[test]
    fn functions_have_thirty_digits() {
        let tenth = two(1.0) / two(10.0);
        let cases = [
            (two(-1.5).exp(), 0.223_130_160_148_429_82, 1.088_772_369_904_226_3e-17),
            ((two(0.0) - tenth).exp(), 0.904_837_418_035_959_6, -5.543_959_909_995_408e-17),
            (two(2.0).ln(), std::f64::consts::LN_2, 2.319_046_813_846_299_6e-17),
            (two(1.0).sin_cos().0, 0.841_470_984_807_896_5, 1.776_845_092_935_536e-18),
            (two(1.0).atan(), std::f64::consts::FRAC_PI_4, 3.061_616_997_868_383e-17),
            (two(2.0).sqrt(), std::f64::consts::SQRT_2, -9.667_293_313_452_913e-17),
        ];
        for (value, high, low) in cases {
            assert!((value - TwoFloat::sum(high, low)).high.abs() < 1e-30, "{value:?} is not {high} + {low}");
        }
    }

    fn two(value: f64) -> TwoFloat {
        value.into()
    }
}
