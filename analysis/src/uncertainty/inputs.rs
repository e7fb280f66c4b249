//! What uncertain inputs do to a prediction, by Monte Carlo (JCGM 101:2008): dimensions and material constants with their standard
//! uncertainties go in, the scatter of the predicted values comes out, and which input it comes from.
//!
//! Inputs are independent. One without a sign to keep is normal. One that must be positive is log-normal with the stated mean and
//! standard uncertainty: a truncated normal would have neither, and would not say how often it was cut. Where the uncertainty is small
//! the two are the same (at 5 % of the mean, the 97.5 % quantile lies 0.07 standard uncertainties further out).
//!
//! The sample is a Latin hypercube (`McKay`, Beckman, Conover, Technometrics 21 (1979) 239): of N samples, each N-th part of the
//! probability of each input holds one. It is doubled until the quantiles stay where they are: every part is halved, the half that
//! is empty gets a new sample, and no earlier one is lost.
//!
//! With z the inputs in standard uncertainties from their means, the predicted values of a place are y = b₀ + Σ bⱼ zⱼ + r by least
//! squares. bⱼ is the linear part of input j, in the unit of y and with the sign of its effect; r is what is left: curvature and what
//! inputs do together. Then the mean is b₀ and the variance Σ bⱼ² + var(r), in which inputs that happen to go together in the sample
//! count for nothing: of a linear model both are exact with any sample.

use nalgebra::{DMatrix, DVector};
use statrs::distribution::{ContinuousCDF, Normal};
use thiserror::Error;

use super::bootstrap::quantile;
use super::random::Draws;

/// Samples to begin with; more where there are many inputs.
const SAMPLES_MIN: usize = 64;

/// Samples that can be asked for at most.
pub const SAMPLES_LIMIT: usize = 1 << 20;

/// Samples with a solution for each coefficient at least.
const SAMPLES_PER_COEFFICIENT: usize = 4;

/// Steps from 0 to 1 of a probability, as a power of two: with a half added, each is exact.
const PROBABILITY_BITS: u32 = 52;

/// The quantiles of [`Place`].
const QUANTILES: [f64; 2] = [0.025, 0.975];

/// So small, as a share of the largest value of a place, a scatter is rounding.
const ROUNDING_SHARE: f64 = 1e-12;

/// An input of a model, in any unit that the model takes.
#[derive(Debug, Clone, PartialEq)]
pub struct Input {
    /// Its name, unlike that of any other: it decides which random numbers the input has.
    pub name: String,
    /// Mean.
    pub mean: f64,
    /// Standard uncertainty; zero for an exact one.
    pub std: f64,
    /// Whether it is positive by its nature: a length, a modulus.
    pub positive: bool,
}

/// How to sample.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sampling {
    /// What the random numbers come from.
    pub seed: u64,
    /// Samples at most, at least 128 and no more than [`SAMPLES_LIMIT`].
    pub samples_max: usize,
    /// The quantiles are settled when a doubling moves none by more than this share of its place's standard uncertainty.
    pub settled_share: f64,
}

/// The predicted values of one place, in the unit of the prediction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Place {
    /// Mean.
    pub mean: f64,
    /// Standard uncertainty from all inputs together.
    pub std: f64,
    /// 2.5 % quantile.
    pub lower: f64,
    /// 97.5 % quantile.
    pub upper: f64,
    /// Standard deviation of what no input explains linearly: `std`² = Σ linear² + `remainder`².
    pub remainder: f64,
}

/// What uncertain inputs do to a prediction.
#[derive(Debug, Clone, PartialEq)]
pub struct Spread {
    /// Samples drawn.
    pub samples: usize,
    /// Of those, how many the model has no value for. All other figures are of the rest.
    pub without_solution: usize,
    /// Whether the quantiles stayed where they were at the last doubling.
    pub settled: bool,
    /// By how much the last doubling moved a quantile at most, in standard uncertainties of its place; infinite where too few
    /// samples before it had a solution.
    pub moved: f64,
    /// Each place.
    pub places: Vec<Place>,
    /// The linear part of each input, in the order given, at each place.
    pub linear: Vec<Vec<f64>>,
}

impl Spread {
    /// The share of samples that the model has no value for.
    pub fn share_without_solution(&self) -> f64 {
        self.without_solution as f64 / self.samples as f64
    }
}

/// Why there is no spread.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum NoSpread {
    /// An input's mean or standard uncertainty is not a number, or a positive input's mean is not positive.
    #[error(
        "the input `{name}` needs a finite mean (positive for one that is positive) and a standard uncertainty of zero or more"
    )]
    Input {
        /// Its name.
        name: String,
    },
    /// Two inputs of one name would have the same random numbers.
    #[error("two inputs are called `{name}`")]
    Twice {
        /// The name.
        name: String,
    },
    /// [`Sampling`] asks for what cannot be.
    #[error(
        "the samples ({samples_max} at most) are too few for {inputs} inputs or beyond {SAMPLES_LIMIT}, or the share at which quantiles are settled is not positive"
    )]
    Sampling {
        /// Samples asked for at most.
        samples_max: usize,
        /// Inputs that are not exact.
        inputs: usize,
    },
    /// The model has a value for too few samples.
    #[error("the model has no value for {without_solution} of {samples} samples of its inputs")]
    NoSolution {
        /// Samples drawn.
        samples: usize,
        /// Of those, without a value.
        without_solution: usize,
    },
    /// The model predicted at another number of places than before.
    #[error("the model predicts at {found} places for one sample of its inputs and at {expected} for another")]
    Places {
        /// Places of the first sample.
        expected: usize,
        /// Places of another.
        found: usize,
    },
}

/// Sends samples of the inputs through a model. `predict` takes the inputs in the order given here and gives the predicted value of
/// each place, or nothing where the model has no solution; a value that is not a finite number counts as none.
///
/// The same inputs and seed give the same bits, in whatever order the inputs are given.
///
/// # Errors
/// See [`NoSpread`]. Quantiles that are not settled with all samples allowed are no error: [`Spread::settled`] says so.
///
/// # Check value
/// y = 3 a + b² with a = 1 ± 0.1 and b = 2 ± 0.2: linear parts 0.3 and 0.8, remainder √2 · 0.04, mean 3 + 4 + 0.04.
/// ```
/// use pneuval_analysis::uncertainty::inputs::{Input, Sampling, propagate};
/// let input = |name: &str, mean, std| Input { name: name.to_owned(), mean, std, positive: false };
/// let inputs = [input("a", 1.0, 0.1), input("b", 2.0, 0.2)];
/// let sampling = Sampling { seed: 1, samples_max: 4096, settled_share: 0.02 };
/// let spread = propagate(&inputs, &sampling, &|x| Some(vec![3.0 * x[0] + x[1] * x[1]]))?;
/// let place = spread.places[0];
/// assert!((spread.linear[0][0] - 0.3).abs() < 0.002 && (spread.linear[1][0] - 0.8).abs() < 0.002);
/// assert!((place.remainder / (0.04 * 2.0_f64.sqrt()) - 1.0).abs() < 0.05 && (place.mean - 7.04).abs() < 0.001);
/// # Ok::<(), pneuval_analysis::uncertainty::inputs::NoSpread>(())
/// ```
pub fn propagate(
    inputs: &[Input],
    sampling: &Sampling,
    predict: &dyn Fn(&[f64]) -> Option<Vec<f64>>,
) -> Result<Spread, NoSpread> {
    check(inputs)?;
    // By name, so that sums are formed in one order whatever the caller's.
    let mut order: Vec<usize> = (0..inputs.len()).filter(|i| inputs[*i].std > 0.0).collect();
    order.sort_by(|a, b| inputs[*a].name.cmp(&inputs[*b].name));
    let start = (SAMPLES_PER_COEFFICIENT * (order.len() + 1)).next_power_of_two().max(SAMPLES_MIN);
    // At least one doubling, or nothing is known of how settled the quantiles are.
    if 2 * start > sampling.samples_max
        || sampling.samples_max > SAMPLES_LIMIT
        || sampling.settled_share.is_nan()
        || sampling.settled_share <= 0.0
    {
        return Err(NoSpread::Sampling { samples_max: sampling.samples_max, inputs: order.len() });
    }
    let mut columns: Vec<Column> = order.iter().map(|i| Column::new(sampling.seed, &inputs[*i])).collect();
    let mut values: Vec<f64> = inputs.iter().map(|input| input.mean).collect();
    let mut solved = Solved::default();
    let (mut samples, mut count) = (0, start);
    let mut before: Option<Fitted> = None;
    loop {
        for column in &mut columns {
            column.grow(count);
        }
        for sample in samples..count {
            for (column, i) in columns.iter().zip(&order) {
                values[*i] = inputs[*i].value(column.normal(sample));
            }
            let deviations = order.iter().map(|i| (values[*i] - inputs[*i].mean) / inputs[*i].std);
            solved.add(deviations, predict(&values))?;
        }
        samples = count;
        let without_solution = samples - solved.values.len();
        let fitted = solved.fit(order.len());
        let moved = match (&fitted, &before) {
            (Some(fitted), Some(before)) => fitted.moved_from(before),
            _ => f64::INFINITY,
        };
        let settled = moved <= sampling.settled_share;
        if settled || 2 * count > sampling.samples_max {
            let fitted = fitted.ok_or(NoSpread::NoSolution { samples, without_solution })?;
            let mut linear = vec![vec![0.0; fitted.places.len()]; inputs.len()];
            for (i, parts) in order.iter().zip(fitted.linear) {
                linear[*i] = parts;
            }
            return Ok(Spread { samples, without_solution, settled, moved, places: fitted.places, linear });
        }
        before = fitted;
        count *= 2;
    }
}

fn check(inputs: &[Input]) -> Result<(), NoSpread> {
    for (i, input) in inputs.iter().enumerate() {
        let sound = input.mean.is_finite() && input.std.is_finite() && input.std >= 0.0;
        if !sound || (input.positive && input.mean <= 0.0) {
            return Err(NoSpread::Input { name: input.name.clone() });
        }
        if inputs[..i].iter().any(|other| other.name == input.name) {
            return Err(NoSpread::Twice { name: input.name.clone() });
        }
    }
    Ok(())
}

impl Input {
    /// The value at a standard normal number.
    fn value(&self, normal: f64) -> f64 {
        if self.positive {
            let variance = (self.std / self.mean).powi(2).ln_1p();
            self.mean * (variance.sqrt() * normal - 0.5 * variance).exp()
        } else {
            self.mean + self.std * normal
        }
    }
}

/// The samples of one input.
struct Column {
    draws: Draws,
    /// Probabilities, in steps of 2^-[`PROBABILITY_BITS`].
    steps: Vec<u64>,
    normal: Normal,
}

impl Column {
    fn new(seed: u64, input: &Input) -> Self {
        Self { draws: Draws::new(seed, &input.name), steps: Vec::new(), normal: Normal::standard() }
    }

    /// To `count` samples, a power of two: each equal part of the probability that is still empty gets one, in random order.
    fn grow(&mut self, count: usize) {
        let within = PROBABILITY_BITS - count.trailing_zeros();
        let mut taken = vec![false; count];
        for step in &self.steps {
            // Below `count`.
            #[allow(clippy::cast_possible_truncation)]
            {
                taken[(step >> within) as usize] = true;
            }
        }
        let mut free: Vec<u64> = (0_u64..).zip(&taken).filter(|(_, taken)| !**taken).map(|(part, _)| part).collect();
        for i in (1..free.len()).rev() {
            let other = self.draws.below(i + 1);
            free.swap(i, other);
        }
        for part in free {
            let step = (part << within) + (self.draws.bits() >> (u64::BITS - within));
            self.steps.push(step);
        }
    }

    /// The standard normal number of a sample.
    fn normal(&self, sample: usize) -> f64 {
        let share = (self.steps[sample] as f64 + 0.5) / (1_u64 << PROBABILITY_BITS) as f64;
        self.normal.inverse_cdf(share)
    }
}

/// The samples that the model has a value for.
#[derive(Default)]
struct Solved {
    /// Of each sample, each input in standard uncertainties from its mean.
    deviations: Vec<Vec<f64>>,
    /// Of each sample, the value of each place.
    values: Vec<Vec<f64>>,
}

/// What a sample of some size says.
struct Fitted {
    places: Vec<Place>,
    /// Of each input, its linear part at each place.
    linear: Vec<Vec<f64>>,
}

impl Solved {
    fn add(&mut self, deviations: impl Iterator<Item = f64>, values: Option<Vec<f64>>) -> Result<(), NoSpread> {
        let Some(values) = values.filter(|values| values.iter().all(|v| v.is_finite())) else { return Ok(()) };
        let expected = self.values.first().map_or(values.len(), Vec::len);
        if values.len() != expected {
            return Err(NoSpread::Places { expected, found: values.len() });
        }
        self.deviations.push(deviations.collect());
        self.values.push(values);
        Ok(())
    }

    /// Nothing where there are too few samples to tell the inputs apart.
    fn fit(&self, inputs: usize) -> Option<Fitted> {
        let count = self.values.len();
        if count < SAMPLES_PER_COEFFICIENT * (inputs + 1) {
            return None;
        }
        let size = count as f64;
        let centre: Vec<f64> =
            (0..inputs).map(|j| self.deviations.iter().map(|row| row[j]).sum::<f64>() / size).collect();
        let design = DMatrix::from_fn(count, inputs, |i, j| self.deviations[i][j] - centre[j]);
        let normal_equations = design.tr_mul(&design).cholesky()?;
        let places = self.values[0].len();
        let mut fitted =
            Fitted { places: Vec::with_capacity(places), linear: vec![Vec::with_capacity(places); inputs] };
        for place in 0..places {
            let mut values: Vec<f64> = self.values.iter().map(|row| row[place]).collect();
            let average = values.iter().sum::<f64>() / size;
            let about = DVector::from_iterator(count, values.iter().map(|value| value - average));
            let linear = normal_equations.solve(&design.tr_mul(&about));
            let left = (&about - &design * &linear).norm_squared() / (count - inputs - 1) as f64;
            let mean = average - linear.iter().zip(&centre).map(|(b, z)| b * z).sum::<f64>();
            values.sort_unstable_by(f64::total_cmp);
            let [lower, upper] = QUANTILES.map(|share| quantile(&values, share));
            let std = (linear.norm_squared() + left).sqrt();
            if !std.is_finite() || !mean.is_finite() {
                return None;
            }
            fitted.places.push(Place { mean, std, lower, upper, remainder: left.sqrt() });
            for (parts, part) in fitted.linear.iter_mut().zip(linear.iter()) {
                parts.push(*part);
            }
        }
        Some(fitted)
    }
}

impl Fitted {
    /// By how much a quantile moved at most, in standard uncertainties of its place. A place without scatter has none to settle.
    fn moved_from(&self, before: &Self) -> f64 {
        let of = |(now, before): (&Place, &Place)| {
            let rounding = ROUNDING_SHARE * now.lower.abs().max(now.upper.abs());
            let by = (now.lower - before.lower).abs().max((now.upper - before.upper).abs());
            if now.std <= rounding { 0.0 } else { by / now.std }
        };
        self.places.iter().zip(&before.places).map(of).fold(0.0, f64::max)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SAMPLING: Sampling = Sampling { seed: 1, samples_max: 8192, settled_share: 0.02 };

    fn input(name: &str, mean: f64, std: f64) -> Input {
        Input { name: name.to_owned(), mean, std, positive: false }
    }

    #[test]
    fn a_linear_model_is_exact() {
        let inputs = [input("a", 1.0, 0.5), input("b", -2.0, 3.0), input("exact", 7.0, 0.0)];
        // Two places, 2 a - b + exact and b alone.
        let spread = propagate(&inputs, &SAMPLING, &|x| Some(vec![2.0 * x[0] - x[1] + x[2], x[1]])).unwrap();
        let near = |found: f64, expected: f64| assert!((found - expected).abs() < 1e-12, "{found} {expected}");
        for (found, expected) in spread.linear.iter().flatten().zip([1.0, 0.0, -3.0, 3.0, 0.0, 0.0]) {
            near(*found, expected);
        }
        near(spread.places[0].mean, 11.0);
        near(spread.places[0].std, 10.0_f64.sqrt());
        near(spread.places[1].std, 3.0);
        assert!(spread.places.iter().all(|place| place.remainder < 1e-12));
        // The quantiles of a sum of normal numbers are those of a normal number.
        let half = 1.959_964 * 10.0_f64.sqrt();
        assert!((spread.places[0].lower - (11.0 - half)).abs() < 0.1 * 10.0_f64.sqrt(), "{spread:?}");
        assert!((spread.places[0].upper - (11.0 + half)).abs() < 0.1 * 10.0_f64.sqrt(), "{spread:?}");
        assert!(spread.settled && spread.moved <= 0.02 && spread.without_solution == 0);
    }

    /// a² of a standard normal a has variance 2 and no linear part; the product of two has variance 1.
    #[test]
    fn curvature_and_what_inputs_do_together_are_the_remainder() {
        let inputs = [input("a", 0.0, 1.0), input("b", 0.0, 1.0)];
        let all = Sampling { settled_share: 1e-9, ..SAMPLING };
        let spread = propagate(&inputs, &all, &|x| Some(vec![x[0] * x[0], x[0] * x[1]])).unwrap();
        assert!(!spread.settled && spread.samples == 8192);
        assert!(spread.linear.iter().flatten().all(|part| part.abs() < 0.05), "{:?}", spread.linear);
        for (place, variance, mean) in [(spread.places[0], 2.0_f64, 1.0), (spread.places[1], 1.0, 0.0)] {
            assert!((place.remainder / variance.sqrt() - 1.0).abs() < 0.04, "{place:?}");
            assert!((place.mean - mean).abs() < 0.04, "{place:?}");
        }
    }

    #[test]
    fn the_variance_is_the_squares_of_the_linear_parts_and_of_the_remainder() {
        let inputs = [input("a", 1.0, 0.3), input("b", 2.0, 0.5)];
        let spread = propagate(&inputs, &SAMPLING, &|x| Some(vec![(x[0] * x[1]).exp()])).unwrap();
        let place = spread.places[0];
        let sum: f64 = spread.linear.iter().map(|parts| parts[0].powi(2)).sum();
        assert!((place.std.powi(2) / (sum + place.remainder.powi(2)) - 1.0).abs() < 1e-12);
        assert!(place.lower < place.mean && place.mean < place.upper);
    }

    #[test]
    fn samples_without_a_solution_are_counted_and_too_many_are_an_error() {
        // A standard normal number is below 1 in 84.13 % of all samples.
        let spread = propagate(&[input("a", 0.0, 1.0)], &SAMPLING, &|x| (x[0] < 1.0).then(|| vec![x[0]])).unwrap();
        assert!((spread.share_without_solution() - 0.1587).abs() < 0.01, "{spread:?}");
        assert!(spread.places[0].upper < 1.0);
        let never = propagate(&[input("a", 0.0, 1.0)], &SAMPLING, &|_| None);
        assert_eq!(never, Err(NoSpread::NoSolution { samples: 8192, without_solution: 8192 }));
        let nan = propagate(&[input("a", 0.0, 1.0)], &SAMPLING, &|_| Some(vec![f64::NAN]));
        assert_eq!(nan, never);
    }

    #[test]
    fn the_order_of_the_inputs_changes_nothing_and_the_seed_does() {
        let inputs = [input("a", 1.0, 0.1), input("b", 2.0, 0.3), input("c", 3.0, 0.2)];
        let turned = [inputs[2].clone(), inputs[0].clone(), inputs[1].clone()];
        let of = |a: f64, b: f64, c: f64| Some(vec![a * b.powi(2) / c, a + b + c]);
        let found = propagate(&inputs, &SAMPLING, &|x| of(x[0], x[1], x[2])).unwrap();
        let other = propagate(&turned, &SAMPLING, &|x| of(x[1], x[2], x[0])).unwrap();
        assert_eq!((&found.places, found.samples), (&other.places, other.samples));
        assert_eq!(found.linear, [other.linear[1].clone(), other.linear[2].clone(), other.linear[0].clone()]);
        let again = propagate(&inputs, &SAMPLING, &|x| of(x[0], x[1], x[2])).unwrap();
        assert_eq!(format!("{found:?}"), format!("{again:?}"));
        let seeded = Sampling { seed: 2, ..SAMPLING };
        assert_ne!(found.places, propagate(&inputs, &seeded, &|x| of(x[0], x[1], x[2])).unwrap().places);
    }

    /// However often it was doubled, each N-th part of the probability holds one sample.
    #[test]
    fn a_doubled_hypercube_is_one() {
        let mut column = Column::new(5, &input("a", 0.0, 1.0));
        for count in [64, 128, 256, 512] {
            let before = column.steps.clone();
            column.grow(count);
            assert_eq!(column.steps[..before.len()], before);
            let within = PROBABILITY_BITS - count.trailing_zeros();
            let mut parts: Vec<u64> = column.steps.iter().map(|step| step >> within).collect();
            parts.sort_unstable();
            assert_eq!(parts, (0..count as u64).collect::<Vec<_>>());
        }
    }

    #[test]
    fn a_positive_input_stays_positive_and_keeps_its_mean_and_uncertainty() {
        let thickness = Input { positive: true, ..input("thickness", 2.0, 1.5) };
        let all = Sampling { settled_share: 1e-9, samples_max: 65_536, ..SAMPLING };
        let least = std::cell::Cell::new(f64::INFINITY);
        let spread = propagate(&[thickness], &all, &|x| {
            least.set(least.get().min(x[0]));
            Some(vec![x[0], (x[0] - 2.0).powi(2)])
        })
        .unwrap();
        assert!(least.get() > 0.0);
        // The linear part of the input itself is its uncertainty by definition; the mean square is the sample's own.
        assert!((spread.places[0].mean - 2.0).abs() < 1e-9 && (spread.places[0].std - 1.5).abs() < 1e-9);
        assert!((spread.places[1].mean / 2.25 - 1.0).abs() < 0.05, "{spread:?}");
        // A wide normal input is not asked to be positive.
        let wide = propagate(&[input("offset", 2.0, 1.5)], &all, &|x| Some(vec![x[0]])).unwrap();
        assert!(wide.places[0].lower < 0.0);
    }

    #[test]
    fn what_cannot_be_sampled_is_refused() {
        let of =
            |inputs: &[Input], sampling: &Sampling| propagate(inputs, sampling, &|x| Some(x.to_vec())).unwrap_err();
        for (mean, std, positive) in
            [(f64::NAN, 1.0, false), (1.0, -1.0, false), (1.0, f64::INFINITY, false), (0.0, 1.0, true)]
        {
            let bad = Input { positive, ..input("bad", mean, std) };
            assert_eq!(of(&[bad], &SAMPLING), NoSpread::Input { name: "bad".to_owned() });
        }
        let a = input("a", 1.0, 1.0);
        assert_eq!(of(&[a.clone(), a.clone()], &SAMPLING), NoSpread::Twice { name: "a".to_owned() });
        for (samples_max, settled_share) in [(64, 0.1), (SAMPLES_LIMIT + 1, 0.1), (1024, 0.0), (1024, f64::NAN)] {
            let sampling = Sampling { seed: 1, samples_max, settled_share };
            assert_eq!(of(std::slice::from_ref(&a), &sampling), NoSpread::Sampling { samples_max, inputs: 1 });
        }
        let places = propagate(&[a], &SAMPLING, &|x| Some(vec![0.0; if x[0] < 1.0 { 1 } else { 2 }])).unwrap_err();
        assert!(matches!(places, NoSpread::Places { .. }));
    }

    #[test]
    fn exact_inputs_leave_no_uncertainty() {
        let spread = propagate(&[input("a", 3.0, 0.0)], &SAMPLING, &|x| Some(vec![0.1 * x[0]])).unwrap();
        assert!(spread.settled && spread.places[0].std < 1e-15 && spread.linear == [[0.0]]);
    }
}
