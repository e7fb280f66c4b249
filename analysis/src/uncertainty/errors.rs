//! What may move measured and predicted values away from what they stand for, as directions.
//!
//! Every cause gives one or more *factors*: a vector over all values, which is by how much they move together when the cause is off by
//! one standard uncertainty. Factors are independent of each other; the covariance of the values is the sum of their outer products
//! (GUM, 5.2, with correlations kept: what one instrument adds to one value it adds to all). A metric's variance is the sum of the squares of
//! what each factor does to it, so its budget falls out by the way.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// What kind of cause it is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Cause {
    /// The scatter of repeats (type A).
    Repeats,
    /// The declared uncertainty of the instrument that measures the quantity (type B).
    Instrument,
    /// The declared uncertainty of the pressure or of a condition, by the slope of the prediction (type B).
    State,
    /// An input of the model (type B).
    Input,
    /// What a solver or an interpolation leaves open (type B).
    Numerical,
}

impl Cause {
    /// Its name on pages.
    pub fn title(self) -> &'static str {
        match self {
            Self::Repeats => "scatter of repeats",
            Self::Instrument => "instrument",
            Self::State => "pressure or condition",
            Self::Input => "model input",
            Self::Numerical => "numerical",
        }
    }

    /// Evaluated from the data at hand (A) or from other knowledge (B).
    pub fn evaluation(self) -> &'static str {
        if self == Self::Repeats { "A" } else { "B" }
    }
}

/// A cause with its name.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Source {
    /// Which: an instrument, an input.
    pub name: String,
    /// Of what kind.
    pub cause: Cause,
}

/// One direction in which values move together.
#[derive(Debug, Clone, PartialEq)]
pub struct Factor {
    /// Index of its source.
    pub source: usize,
    /// By how much each measured value moves; component by component, point by point.
    pub measured: Vec<f64>,
    /// The same of each predicted value.
    pub predicted: Vec<f64>,
}

/// All that is known to move the values of a comparison.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Errors {
    /// Causes.
    pub sources: Vec<Source>,
    /// Their directions.
    pub factors: Vec<Factor>,
    /// The fewest repeats at any value.
    pub repeats: usize,
}

impl Errors {
    /// Adds a cause with its directions; one that moves nothing is left out.
    pub fn add(&mut self, source: Source, directions: impl IntoIterator<Item = (Vec<f64>, Vec<f64>)>) {
        let index = self.sources.len();
        let moving = |(measured, predicted): &(Vec<f64>, Vec<f64>)| measured.iter().chain(predicted).any(|x| *x != 0.0);
        let factors = directions.into_iter().filter(moving);
        let before = self.factors.len();
        self.factors.extend(factors.map(|(measured, predicted)| Factor { source: index, measured, predicted }));
        if self.factors.len() > before {
            self.sources.push(source);
        }
    }

    /// Those of some points only, each of so many components.
    #[must_use]
    pub fn of_points(&self, points: &[usize], width: usize) -> Self {
        let pick = |all: &[f64]| points.iter().flat_map(|&i| all[i * width..(i + 1) * width].iter().copied()).collect();
        let factor =
            |f: &Factor| Factor { source: f.source, measured: pick(&f.measured), predicted: pick(&f.predicted) };
        Self {
            sources: self.sources.clone(),
            factors: self.factors.iter().map(factor).collect(),
            repeats: self.repeats,
        }
    }

    /// The variances of something that each factor moves by so much: of the repeats, and of everything else.
    pub fn variances(&self, moved: impl IntoIterator<Item = f64>) -> (f64, f64) {
        self.factors.iter().zip(moved).fold((0.0, 0.0), |(a, b), (factor, by)| {
            if self.is_type_a(factor) { (a + by * by, b) } else { (a, b + by * by) }
        })
    }

    /// The share of each source in a variance.
    pub fn shares(&self, moved: impl IntoIterator<Item = f64>) -> Vec<f64> {
        let mut shares = vec![0.0; self.sources.len()];
        for (factor, by) in self.factors.iter().zip(moved) {
            shares[factor.source] += by * by;
        }
        let total: f64 = shares.iter().sum();
        if total > 0.0 {
            for share in &mut shares {
                *share /= total;
            }
        }
        shares
    }

    /// Whether a factor is the scatter of repeats.
    pub fn is_type_a(&self, factor: &Factor) -> bool {
        self.sources.get(factor.source).is_some_and(|source| source.cause == Cause::Repeats)
    }
}
