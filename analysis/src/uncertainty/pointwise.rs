//! Intervals of the largest and of the mean size of values that are known with errors.

use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg64Mcg;
use statrs::function::erf::erf;

use super::coverage::{Variance, Z95, student_excess};
use super::errors::{Errors, Source};
use crate::metrics::Interval;

/// Draws from which the simultaneous factor is taken: it is known to about 1 %.
const DRAWS: usize = 4000;

/// Degrees of freedom from which points may be drawn each by itself: with fewer the factor would be Student's of one or two.
const OWN_FROM: usize = 4;

/// Values that may be the largest, so many standard uncertainties around it.
const REACH: f64 = 4.0;

/// Draws of all factors for all candidates; beyond it they are taken as independent, which is wider.
const DRAWN_MAX: usize = 100_000_000;

/// Values, one a point, and by how much each factor moves each of them.
#[derive(Debug, Clone, PartialEq)]
pub struct Moved {
    /// Values.
    pub values: Vec<f64>,
    /// Of each factor, by how much it moves every value.
    pub by: Vec<Vec<f64>>,
    /// By how much each value may be seen too large, a length by what lies across it; zero for a number with a sign.
    pub across: Vec<f64>,
}

impl Moved {
    fn variance(&self, point: usize, errors: &Errors) -> Variance {
        errors.variance(self.by.iter().map(|by| by[point]))
    }

    /// The largest in size, and its interval.
    ///
    /// The interval holds all values that may be the largest at once: with c the 95 % quantile of the largest of their errors, each
    /// over its standard uncertainty, it reaches from the largest of |v| - c u to the largest of |v| + c u. It is conservative.
    /// Values that are no rival to the largest are not asked, so that one that stands out has the interval it would have alone.
    pub fn largest(&self, errors: &Errors) -> Option<(Interval, usize)> {
        let size = |i: usize| self.values[i].abs();
        let top = (0..self.values.len()).max_by(|&a, &b| size(a).total_cmp(&size(b)))?;
        let std: Vec<f64> = (0..self.values.len()).map(|i| self.variance(i, errors).half_width() / Z95).collect();
        let floor = (0..self.values.len()).map(|i| size(i) - REACH * std[i]).fold(0.0, f64::max);
        let rivals: Vec<usize> = (0..self.values.len()).filter(|&i| size(i) + REACH * std[i] >= floor).collect();
        let factor = self.simultaneous(&rivals, errors);
        let lower = rivals.iter().map(|&i| size(i) - factor * std[i] - self.across[i]).fold(0.0, f64::max);
        let upper = rivals.iter().map(|&i| size(i) + factor * std[i]).fold(size(top), f64::max);
        Some((Interval { value: size(top), lower: lower.min(size(top)), upper }, top))
    }

    /// How many standard uncertainties hold all of some values at once in 95 %: from draws of their errors with fixed seed. A scatter that
    /// is found from repeats is drawn anew with them: of several points that seem to scatter little, one does so by luck.
    ///
    /// Directions of repeats are fewer than points: drawn by them, points that scatter each by itself look bound to each other. Where nothing
    /// is pooled they are drawn each by itself too, and the larger factor counts.
    fn simultaneous(&self, points: &[usize], errors: &Errors) -> f64 {
        let is_uncertain = |i: &usize| self.by.iter().any(|by| by[*i] != 0.0);
        let uncertain: Vec<usize> = points.iter().copied().filter(is_uncertain).collect();
        let n = uncertain.len();
        let mut sources: Vec<Drawn> = Drawn::all(errors, &self.by);
        let work: usize = sources.iter().map(|s| s.factors.len() * s.draws()).sum();
        if n < 2 {
            return Z95;
        }
        if n * work * DRAWS > DRAWN_MAX {
            return independent(n, errors);
        }
        let factor = self.drawn(&uncertain, &sources);
        let mut is_bound = false;
        for source in &mut sources {
            if !source.is_pooled && source.scatter.is_some_and(|(freedom, _)| (OWN_FROM..n).contains(&freedom)) {
                (source.is_own, is_bound) = (true, true);
            }
        }
        if is_bound { factor.max(self.drawn(&uncertain, &sources)) } else { factor }
    }

    /// The 95 % quantile of the largest error of some values, each over its standard uncertainty.
    fn drawn(&self, points: &[usize], sources: &[Drawn]) -> f64 {
        let mut generator = Pcg64Mcg::new(0x5eed);
        let mut largest = Vec::with_capacity(DRAWS);
        let n = points.len();
        let (mut moved, mut one) = (vec![0.0; n], vec![0.0; n]);
        let mut variances = vec![Variance::default(); n];
        for _ in 0..DRAWS {
            moved.fill(0.0);
            variances.fill(Variance::default());
            for source in sources {
                source.draw(&self.by, points, &mut generator, &mut one);
                moved.iter_mut().zip(&one).for_each(|(sum, by)| *sum += by);
                source.seen(&self.by, points, &mut generator, &mut one, &mut variances);
            }
            let pivot = |(error, variance): (&f64, &Variance)| Z95 * error.abs() / variance.half_width();
            largest.push(moved.iter().zip(&variances).map(pivot).fold(0.0, f64::max));
        }
        largest.sort_by(f64::total_cmp);
        largest[DRAWS * 95 / 100].max(Z95)
    }

    /// The mean size, its interval, and by how much each factor moves it.
    ///
    /// A value near zero adds its size whichever way its error goes: the mean size is then seen too large by
    /// `E|v + d| - |v|` (the folded normal distribution, at the least |v| that may be), by which the lower end is lowered, and its error counts as far as its
    /// sign is known, erf(|v|/√2 u).
    pub fn mean_size(&self, errors: &Errors) -> (Interval, Vec<f64>) {
        let n = self.values.len() as f64;
        let mut signs = Vec::with_capacity(self.values.len());
        let mut added = 0.0;
        for (i, value) in self.values.iter().enumerate() {
            added += self.across[i];
            let std = self.variance(i, errors).half_width() / Z95;
            if std <= 0.0 {
                signs.push(value.signum());
                continue;
            }
            let size = value.abs();
            let known = erf(size / (std::f64::consts::SQRT_2 * std));
            // What it adds at most: it may lie nearer to zero than it is seen.
            let nearest = (size - Z95 * std).max(0.0);
            // A length is folded already.
            added += if self.across[i] > 0.0 { 0.0 } else { folded(nearest, std) - nearest };
            signs.push(value.signum() * known);
        }
        let value = self.values.iter().map(|v| v.abs()).sum::<f64>() / n;
        let moved: Vec<f64> =
            self.by.iter().map(|by| by.iter().zip(&signs).map(|(by, sign)| by * sign).sum::<f64>() / n).collect();
        let half = errors.variance(moved.iter().copied()).half_width();
        (Interval { value, lower: (value - half - added / n).max(0.0), upper: value + half }, moved)
    }
}

/// The mean size of a normal number of this mean and standard deviation.
fn folded(mean: f64, std: f64) -> f64 {
    let by = mean / std;
    std * (2.0 / std::f64::consts::PI).sqrt() * (-0.5 * by * by).exp() + mean * erf(by / std::f64::consts::SQRT_2)
}

/// A source of errors as it is drawn.
struct Drawn {
    /// Its factors.
    factors: Vec<usize>,
    /// Its degrees of freedom with what they add to the factor, where it is found from repeats; whether it is pooled.
    scatter: Option<(usize, f64)>,
    is_pooled: bool,
    /// Drawn for each point by itself.
    is_own: bool,
}

impl Drawn {
    fn all(errors: &Errors, by: &[Vec<f64>]) -> Vec<Self> {
        let of = |(index, source): (usize, &Source)| {
            let factors = (0..by.len()).filter(|&f| errors.factors[f].source == index).collect();
            let scatter = errors.freedom(index).filter(|freedom| *freedom > 0);
            Self {
                factors,
                scatter: scatter.map(|freedom| (freedom, student_excess(freedom))),
                is_pooled: source.pooled.is_some(),
                is_own: false,
            }
        };
        errors.sources.iter().enumerate().map(of).collect()
    }

    /// How often all factors are gone through for one draw.
    fn draws(&self) -> usize {
        match self.scatter {
            Some((freedom, _)) if !self.is_pooled => 1 + freedom,
            _ => 1,
        }
    }

    fn variance_at(&self, by: &[Vec<f64>], point: usize) -> f64 {
        self.factors.iter().map(|&f| by[f][point] * by[f][point]).sum()
    }

    /// What it adds to each point.
    fn draw(&self, by: &[Vec<f64>], points: &[usize], generator: &mut Pcg64Mcg, into: &mut [f64]) {
        into.fill(0.0);
        if self.is_own {
            for (sum, &i) in into.iter_mut().zip(points) {
                let z: f64 = StandardNormal.sample(generator);
                *sum = z * self.variance_at(by, i).sqrt();
            }
            return;
        }
        for &factor in &self.factors {
            let z: f64 = StandardNormal.sample(generator);
            for (sum, &i) in into.iter_mut().zip(points) {
                *sum += z * by[factor][i];
            }
        }
    }

    /// The variance of each point that is then seen.
    fn seen(
        &self,
        by: &[Vec<f64>],
        points: &[usize],
        generator: &mut Pcg64Mcg,
        one: &mut [f64],
        variances: &mut [Variance],
    ) {
        let true_at = |i: usize| self.variance_at(by, i);
        match self.scatter {
            None => {
                for (variance, &i) in variances.iter_mut().zip(points) {
                    *variance = variance.with_excess(true_at(i), 0.0);
                }
            }
            Some((freedom, excess)) if self.is_pooled => {
                let squares: f64 =
                    (0..freedom).map(|_| StandardNormal.sample(generator)).map(|z: f64| z * z).sum::<f64>();
                let share = squares / freedom as f64;
                for (variance, &i) in variances.iter_mut().zip(points) {
                    *variance = variance.with_excess(share * true_at(i), excess);
                }
            }
            Some((freedom, excess)) => {
                let mut squares = vec![0.0; points.len()];
                for _ in 0..freedom {
                    self.draw(by, points, generator, one);
                    squares.iter_mut().zip(one.iter()).for_each(|(sum, x)| *sum += x * x);
                }
                for (variance, square) in variances.iter_mut().zip(squares) {
                    *variance = variance.with_excess(square / freedom as f64, excess);
                }
            }
        }
    }
}

/// The factor for so many independent values (Šidák), of the fewest degrees of freedom.
fn independent(n: usize, errors: &Errors) -> f64 {
    use statrs::distribution::{ContinuousCDF, Normal, StudentsT};
    let p = 0.5 + 0.5 * 0.95_f64.powf(1.0 / n as f64);
    let freedom = (0..errors.sources.len()).filter_map(|i| errors.freedom(i)).filter(|f| *f > 0).min();
    let student = freedom.and_then(|f| StudentsT::new(0.0, 1.0, f as f64).ok().map(|t| (t, f)));
    // Each value's own interval has Student's factor already.
    match student {
        Some((t, freedom)) => Z95 * t.inverse_cdf(p) / (Z95 * Z95 + student_excess(freedom)).sqrt(),
        None => Normal::standard().inverse_cdf(p),
    }
}

/// The interval of a number that each factor moves by so much.
pub fn linear(value: f64, moved: &[f64], errors: &Errors) -> Interval {
    let half = errors.variance(moved.iter().copied()).half_width();
    Interval { value, lower: value - half, upper: value + half }
}
