//! A smooth curve through edge points: a polynomial of least squares, robust against points that are none.

use nalgebra::{SMatrix, SVector};
use statrs::distribution::{ContinuousCDF, FisherSnedecor};

/// Points farther off than so many standard deviations of the others are no part of the edge.
const FAR_STDS: f64 = 4.0;

/// From the median of absolute deviations to the standard deviation of normal noise.
const MAD_TO_STD: f64 = 1.482_602_218_505_602;

/// Points are looked at so often.
const ROUNDS: usize = 5;

/// Two degrees more are worth it where chance explains them in less than this share.
const WORTH: f64 = 0.005;

/// Lags over which what is left over is asked whether it hangs together.
const LAGS: usize = 8;

/// Coefficients of the highest degree.
const TERMS: usize = 7;

/// The highest degree of a curve.
pub(super) const DEGREE_MAX: usize = TERMS - 1;

/// y over x as `Σ c_k t^k`, t = (x - middle)/half from -1 to 1: of so few degrees that is well enough conditioned.
#[derive(Debug, Clone, PartialEq)]
pub struct Curve {
    middle: f64,
    half: f64,
    coefficients: [f64; TERMS],
    terms: usize,
    /// Of the normal equations: the covariance of the coefficients for points of variance one.
    inverse: SMatrix<f64, TERMS, TERMS>,
    /// Standard deviation of the points about it.
    pub left: f64,
    /// Which of the points belong to it.
    pub used: Vec<bool>,
}

fn powers(t: f64) -> [f64; TERMS] {
    let mut all = [1.0; TERMS];
    for k in 1..TERMS {
        all[k] = all[k - 1] * t;
    }
    all
}

impl Curve {
    /// The curve of a degree through points with x in a range. `None` if they are too few.
    pub fn fit(points: &[(f64, f64)], range: (f64, f64), degree: usize) -> Option<Self> {
        Self::of(points, range, degree.min(DEGREE_MAX), None)
    }

    /// Two outlines of one body, both of the degree that the points ask for, up to `most`; and that degree.
    pub fn pair(points: [&[(f64, f64)]; 2], range: (f64, f64), most: usize) -> Option<([Self; 2], usize)> {
        // What is no part of the edge, once and for all: by the most flexible curve.
        let flexible = [Self::fit(points[0], range, most)?, Self::fit(points[1], range, most)?];
        let sums = [0, 1].map(|i| Moments::of(points[i], range, &flexible[i].used));
        let n: usize = flexible.iter().map(Self::n).sum();
        let squares = |degree: usize| Some(sums[0].left(degree)? + sums[1].left(degree)?);
        let mut degree = 0;
        let mut left = squares(0)?;
        while degree + 2 <= most {
            // Whether one of the richer ones explains more than chance does.
            let richer = (degree + 2..=most).step_by(2).find_map(|d| {
                let of_richer = squares(d)?;
                let more = (2 * (d - degree)) as f64;
                let freedom = n.checked_sub(2 * (d + 1)).filter(|f| *f > 0)? as f64;
                let f = (left - of_richer) / more / (of_richer / freedom);
                let worth = FisherSnedecor::new(more, freedom).ok()?.inverse_cdf(1.0 - WORTH);
                (f > worth).then_some((of_richer, d))
            });
            let Some((of_richer, d)) = richer else { break };
            (left, degree) = (of_richer, d);
        }
        let one = |i: usize| Self::of(points[i], range, degree, Some(&flexible[i].used));
        Some(([one(0)?, one(1)?], degree))
    }

    fn of(points: &[(f64, f64)], (from, to): (f64, f64), degree: usize, given: Option<&[bool]>) -> Option<Self> {
        let (middle, half) = (f64::midpoint(from, to), 0.5 * (to - from));
        if half.partial_cmp(&0.0) != Some(std::cmp::Ordering::Greater) {
            return None;
        }
        let n = degree + 1;
        let inside = |&(x, y): &(f64, f64)| x >= from && x <= to && y.is_finite();
        let mut used: Vec<bool> = match given {
            Some(given) => given.to_vec(),
            None => points.iter().map(inside).collect(),
        };
        let rounds = if given.is_some() { 1 } else { ROUNDS };
        let mut found: Option<Self> = None;
        for _ in 0..rounds {
            let count = used.iter().filter(|u| **u).count();
            if count < n + 2 {
                return None;
            }
            let sums = Moments::of(points, (from, to), &used);
            let inverse = sums.inverse(degree)?;
            let mut coefficients: [f64; TERMS] = (inverse * sums.right(degree)).into();
            coefficients[0] += sums.origin;
            let mut curve = Self { middle, half, coefficients, terms: n, inverse, left: 0.0, used: used.clone() };
            let left: Vec<f64> = points.iter().map(|(x, y)| y - curve.at(*x)).collect();
            let of_used: Vec<f64> = left.iter().zip(&used).filter(|(_, u)| **u).map(|(r, _)| *r).collect();
            curve.left = (of_used.iter().map(|r| r * r).sum::<f64>() / (count - n) as f64).sqrt();
            let next: Vec<bool> = if given.is_some() {
                used.clone()
            } else {
                let limit = FAR_STDS * MAD_TO_STD * median(some(of_used.iter().map(|r| r.abs()))) + f64::EPSILON;
                points.iter().zip(&left).map(|(p, r)| inside(p) && r.abs() <= limit).collect()
            };
            let is_settled = next == used;
            found = Some(curve);
            if is_settled {
                break;
            }
            used = next;
        }
        found
    }

    /// Points that belong to it.
    pub fn n(&self) -> usize {
        self.used.iter().filter(|u| **u).count()
    }

    /// The range it is good for.
    pub fn range(&self) -> (f64, f64) {
        (self.middle - self.half, self.middle + self.half)
    }

    /// y at x.
    pub fn at(&self, x: f64) -> f64 {
        let t = (x - self.middle) / self.half;
        self.coefficients[..self.terms].iter().rev().fold(0.0, |sum, c| sum * t + c)
    }

    /// Standard uncertainty of that, by the points that it goes through: neighbours that stray together know less than their number.
    pub fn std_at(&self, x: f64, points: &[(f64, f64)]) -> f64 {
        let mut basis = SVector::<f64, TERMS>::from(powers((x - self.middle) / self.half));
        basis.iter_mut().skip(self.terms).for_each(|b| *b = 0.0);
        let of_used = points.iter().zip(&self.used).filter(|(_, used)| **used);
        let left: Vec<f64> = of_used.map(|((x, y), _)| y - self.at(*x)).collect();
        self.left * ((self.inverse * basis).dot(&basis).max(0.0) * together(&left)).sqrt()
    }

    /// Slope and second derivative at x.
    pub fn derivatives(&self, x: f64) -> (f64, f64) {
        let t = (x - self.middle) / self.half;
        let (mut first, mut second) = (0.0, 0.0);
        for (k, c) in self.coefficients[..self.terms].iter().enumerate().skip(1).rev() {
            let k = k as f64;
            first = first * t + k * c;
        }
        for (k, c) in self.coefficients[..self.terms].iter().enumerate().skip(2).rev() {
            let k = k as f64;
            second = second * t + k * (k - 1.0) * c;
        }
        (first / self.half, second / (self.half * self.half))
    }
}

/// Sums of powers over points: all that a polynomial of any degree is solved from.
struct Moments {
    /// Σ t^k.
    powers: [f64; 2 * TERMS - 1],
    /// Σ t^k (y - origin).
    right: [f64; TERMS],
    /// Σ (y - origin)².
    squares: f64,
    /// One of the points, so that squares keep their digits.
    origin: f64,
}

impl Moments {
    fn of(points: &[(f64, f64)], (from, to): (f64, f64), used: &[bool]) -> Self {
        let (middle, per_half) = (f64::midpoint(from, to), 2.0 / (to - from));
        let origin = points.get(points.len() / 2).map_or(0.0, |(_, y)| *y);
        let origin = if origin.is_finite() { origin } else { 0.0 };
        let mut sums = Self { powers: [0.0; 2 * TERMS - 1], right: [0.0; TERMS], squares: 0.0, origin };
        for ((x, y), _) in points.iter().zip(used).filter(|(_, used)| **used) {
            let (t, y) = ((x - middle) * per_half, y - origin);
            let all = powers(t);
            let top = all[TERMS - 1];
            sums.powers[..TERMS].iter_mut().zip(all).for_each(|(sum, p)| *sum += p);
            sums.powers[TERMS..].iter_mut().zip(&all[1..]).for_each(|(sum, p)| *sum += top * p);
            sums.right.iter_mut().zip(all).for_each(|(sum, p)| *sum += p * y);
            sums.squares += y * y;
        }
        sums
    }

    /// The inverse of the normal equations; terms beyond the degree are kept apart by ones.
    fn inverse(&self, degree: usize) -> Option<SMatrix<f64, TERMS, TERMS>> {
        let normal = SMatrix::<f64, TERMS, TERMS>::from_fn(|i, j| match i.max(j) {
            k if k <= degree => self.powers[i + j],
            _ => f64::from(u8::from(i == j)),
        });
        Some(normal.cholesky()?.inverse())
    }

    fn right(&self, degree: usize) -> SVector<f64, TERMS> {
        SVector::from_fn(|i, _| if i <= degree { self.right[i] } else { 0.0 })
    }

    /// The sum of squares that a polynomial of a degree leaves; not below what rounding leaves of nothing.
    fn left(&self, degree: usize) -> Option<f64> {
        let right = self.right(degree);
        let explained = (self.inverse(degree)? * right).dot(&right);
        Some((self.squares - explained).max(f64::EPSILON * self.squares))
    }
}

/// By how much a sum over neighbours varies more than one over strangers: one and twice the sum of their correlations, weighed down
/// with their distance (Newey and West).
pub(super) fn together(left: &[f64]) -> f64 {
    let squares: f64 = left.iter().map(|r| r * r).sum();
    if left.len() <= 4 * LAGS || squares <= 0.0 {
        return 1.0;
    }
    let lag = |k: usize| left.iter().zip(&left[k..]).map(|(a, b)| a * b).sum::<f64>() / squares;
    let weight = |k: usize| 1.0 - k as f64 / (LAGS + 1) as f64;
    (1.0 + 2.0 * (1..=LAGS).map(|k| weight(k) * lag(k)).sum::<f64>()).max(1.0)
}

/// So many values tell where their middle lies: the first of every few, spread over all.
const TELLING: usize = 256;

/// Enough of many values for their median.
pub(super) fn some(values: impl ExactSizeIterator<Item = f64>) -> Vec<f64> {
    let step = (values.len() / TELLING).max(1);
    values.step_by(step).collect()
}

/// The middle value; zero of none.
pub(super) fn median(mut values: Vec<f64>) -> f64 {
    if values.is_empty() {
        return 0.0;
    }
    let middle = values.len() / 2;
    *values.select_nth_unstable_by(middle, f64::total_cmp).1
}
