//! What a fit says of its parameters: value, standard error, interval, and whether the data determine it at all.

use serde::Serialize;
use statrs::distribution::{ContinuousCDF, FisherSnedecor, StudentsT};

use pneuval_models::ModelError;
use pneuval_models::least_squares::{Limit, Minimum, Problem, Search, Statistics, minimise, profile};

/// Parameters of a fit, with what the data say of them.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Estimates {
    /// Values fitted to.
    pub n: usize,
    /// Values more than parameters.
    pub degrees_of_freedom: usize,
    /// Of the residuals, weighted as stated.
    pub sum_of_squares: f64,
    /// `sqrt(sum of squares / degrees of freedom)`; `None` without any.
    pub residual_std: Option<f64>,
    /// `sqrt(sum of squares / n)`.
    pub rmse: f64,
    /// One per parameter.
    pub parameters: Vec<Estimate>,
    /// Correlation of each pair, rows and columns in the order of the parameters.
    pub correlations: Vec<Vec<f64>>,
    /// Condition number of the Jacobian with columns of one length; `None` if the data do not determine every parameter.
    pub condition_number: Option<f64>,
    /// The direction that the data determine least.
    pub weakest: Option<Weakest>,
    /// Confidence of the intervals.
    pub confidence: f64,
    /// Where the minimum was looked for.
    pub search: SearchRecord,
    /// What a reader must know before using a number.
    pub warnings: Vec<String>,
}

/// A fitted parameter.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Estimate {
    /// Its name.
    pub name: String,
    /// Its value.
    pub value: f64,
    /// Standard error of the linear theory; `None` if nothing is known of the scatter.
    pub std: Option<f64>,
    /// Where the profile of the sum of squares ends the interval below.
    pub lower: End,
    /// And above.
    pub upper: End,
    /// How well the data determine it.
    pub identified: Identified,
}

/// An end of an interval.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case", tag = "end", content = "value")]
pub enum End {
    /// Here.
    At(f64),
    /// Here the model or what is physical ends; the data would allow more.
    Edge(f64),
    /// Nowhere: the data set no limit on this side.
    Open,
    /// Not known: no degrees of freedom, or no minimum.
    Unknown,
}

impl End {
    /// The number, if there is one.
    pub fn value(self) -> Option<f64> {
        match self {
            Self::At(value) | Self::Edge(value) => Some(value),
            Self::Open | Self::Unknown => None,
        }
    }
}

/// How well data determine a parameter.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Identified {
    /// Its interval is closed and shorter than its value.
    Well,
    /// Its interval is as long as its value, or longer, or holds zero.
    Poorly,
    /// Its interval is open, or the data do not feel it.
    Not,
    /// As many parameters as values: nothing is known of the scatter.
    Unknown,
}

impl Identified {
    /// In words.
    pub fn words(self) -> &'static str {
        match self {
            Self::Well => "well identified",
            Self::Poorly => "poorly identified",
            Self::Not => "not identified",
            Self::Unknown => "no scatter to judge by",
        }
    }
}

/// The relative change of the parameters that the data feel least.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Weakest {
    /// Its direction, of length 1, in relative changes of the parameters.
    pub direction: Vec<f64>,
    /// By how much the parameters may go along it: one standard deviation, as a share of their values.
    pub std_share: Option<f64>,
}

/// Where a minimum was looked for.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SearchRecord {
    /// Starts, the given one included.
    pub starts: usize,
    /// Of them, how many led to a minimum.
    pub settled: usize,
    /// Of them, how many led to the lowest.
    pub at_lowest: usize,
    /// What the start itself led to.
    pub given: Given,
    /// Accepted steps to the lowest minimum.
    pub iterations: usize,
}

/// What the given start led to.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case", tag = "led_to")]
pub enum Given {
    /// The lowest minimum found.
    Lowest,
    /// A minimum that is not the lowest.
    Higher {
        /// Its sum of squares.
        sum_of_squares: f64,
    },
    /// No minimum.
    Nothing {
        /// Why.
        why: String,
    },
}

/// What is kept of a search.
pub fn search_record(search: &Search) -> SearchRecord {
    let best = search.best.sum_of_squares();
    let given = match &search.given {
        Ok(minimum) if minimum.parameters == search.best.parameters => Given::Lowest,
        Ok(minimum) => Given::Higher { sum_of_squares: minimum.sum_of_squares() },
        Err(error) => Given::Nothing { why: error.to_string() },
    };
    debug_assert!(best.is_finite());
    SearchRecord {
        starts: search.starts,
        settled: search.settled,
        at_lowest: search.at_best,
        given,
        iterations: search.best.iterations,
    }
}

/// The quantile of Student's distribution for a two-sided interval.
pub fn student(confidence: f64, freedom: usize) -> Option<f64> {
    let distribution = StudentsT::new(0.0, 1.0, freedom as f64).ok().filter(|_| freedom > 0)?;
    Some(distribution.inverse_cdf(0.5 * (1.0 + confidence)))
}

/// Condition numbers above it leave no digits for a profile.
const CONDITION_MAX: f64 = 1e11;

/// Estimates at a minimum: standard errors from the Jacobian, intervals from profiles.
pub fn estimates(
    problem: &dyn Problem,
    minimum: &Minimum,
    search: SearchRecord,
    names: &[String],
    confidence: f64,
) -> Estimates {
    let freedom = minimum.degrees_of_freedom();
    let statistics = minimum.statistics();
    let mut warnings = Vec::new();
    if let Err(error) = &statistics {
        warnings.push(format!("{error}: their values are one choice among many that fit as well"));
    }
    if freedom == 0 {
        warnings
            .push("as many parameters as values: they pass through every value, and nothing says how well".to_owned());
    }
    let statistics = statistics.ok();
    let quantile = student(confidence, freedom);
    // Beyond it the sum of squares is flat along some direction to the digits of a double: there is no end to look for.
    let is_flat = statistics.as_ref().is_some_and(|s| s.condition_number > CONDITION_MAX);
    let parameters = (0..names.len())
        .map(|i| {
            let value = minimum.parameters[i];
            let std = statistics.as_ref().and_then(|s| s.std.as_ref()).map(|std| std[i]);
            let (lower, upper) = match (quantile, std) {
                (Some(_), Some(_)) if is_flat => (End::Open, End::Open),
                (Some(t), Some(std)) if std > 0.0 => {
                    let interval = profile(problem, minimum, i, t * t / freedom as f64, std);
                    (end(interval.lower), end(interval.upper))
                }
                // No scatter at all: the interval is the value.
                (Some(_), Some(_)) => (End::At(value), End::At(value)),
                _ => (End::Unknown, End::Unknown),
            };
            let identified = identified(value, lower, upper, statistics.is_some());
            Estimate { name: names[i].clone(), value, std, lower, upper, identified }
        })
        .collect();
    let p = names.len();
    let correlations = statistics
        .as_ref()
        .map(|s| (0..p).map(|i| (0..p).map(|j| s.correlations[(i, j)]).collect()).collect())
        .unwrap_or_default();
    Estimates {
        n: minimum.residuals.len(),
        degrees_of_freedom: freedom,
        sum_of_squares: minimum.sum_of_squares(),
        residual_std: (freedom > 0).then(|| (minimum.sum_of_squares() / freedom as f64).sqrt()),
        rmse: minimum.rmse(),
        parameters,
        correlations,
        condition_number: statistics.as_ref().map(|s| s.condition_number),
        weakest: statistics.as_ref().map(weakest),
        confidence,
        search,
        warnings,
    }
}

fn weakest(statistics: &Statistics) -> Weakest {
    Weakest { direction: statistics.weakest.0.clone(), std_share: statistics.weakest.1 }
}

fn end(limit: Limit) -> End {
    match limit {
        Limit::At(value) => End::At(value),
        Limit::Edge(value) => End::Edge(value),
        Limit::Open => End::Open,
    }
}

fn identified(value: f64, lower: End, upper: End, determined: bool) -> Identified {
    if !determined || lower == End::Open || upper == End::Open {
        return Identified::Not;
    }
    match (lower.value(), upper.value()) {
        (Some(low), Some(high)) if low * high <= 0.0 || high - low > value.abs() => Identified::Poorly,
        (Some(_), Some(_)) if matches!(lower, End::Edge(_)) || matches!(upper, End::Edge(_)) => Identified::Poorly,
        (Some(_), Some(_)) => Identified::Well,
        _ => Identified::Unknown,
    }
}

/// How far other values of all parameters are from the fit: the F test of their sum of squares.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Stated {
    /// Their sum of squares; `None` where the model has no value.
    pub sum_of_squares: Option<f64>,
    /// The probability that values as far away would be met by chance if they were right; `None` where the model has none, or
    /// nothing is known of the scatter.
    pub probability: Option<f64>,
    /// Why the model has no value there.
    pub refused: Option<String>,
}

/// How far stated values of all parameters are from the fit, jointly.
pub fn stated(problem: &dyn Problem, minimum: &Minimum, values: &[f64]) -> Stated {
    let (p, freedom) = (values.len(), minimum.degrees_of_freedom());
    match problem.residuals(values) {
        Err(error) => Stated { sum_of_squares: None, probability: None, refused: Some(error.to_string()) },
        Ok(residuals) => {
            let sum = residuals.norm_squared();
            let variance = minimum.sum_of_squares() / freedom as f64;
            let ratio = (sum - minimum.sum_of_squares()).max(0.0) / p as f64 / variance;
            let distribution = FisherSnedecor::new(p as f64, freedom as f64).ok().filter(|_| freedom > 0);
            let probability = distribution.filter(|_| ratio.is_finite()).map(|f| f.sf(ratio));
            Stated { sum_of_squares: Some(sum), probability, refused: None }
        }
    }
}

/// A minimum from a start alone, where only one start makes sense.
///
/// # Errors
/// As [`minimise`].
pub fn from_start(problem: &dyn Problem, start: &[f64]) -> Result<(Minimum, SearchRecord), ModelError> {
    let minimum = minimise(problem, start)?;
    let record =
        SearchRecord { starts: 1, settled: 1, at_lowest: 1, given: Given::Lowest, iterations: minimum.iterations };
    Ok((minimum, record))
}
