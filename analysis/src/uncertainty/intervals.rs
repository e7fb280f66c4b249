//! Metrics of a session with their 95 % intervals and budgets.
//!
//! What is estimated is the metric of the mean response without noise of the conditioned specimen, at the pressures that were measured;
//! the interval says where it lies. Methods, by metric:
//!
//! | metric | method |
//! |---|---|
//! | bias, loop area, residual at zero | linear in the values: the variance is the sum over the factors |
//! | RMSE | corrected for what the errors add, [`quadratic`](super::quadratic) |
//! | max, and max over a value | simultaneous over the values that may be the largest, [`pointwise`](super::pointwise) |
//! | mean size, and mean over a value | first order with folded signs, [`pointwise`](super::pointwise) |
//! | over the range | that of the numerator and of the range, in squares |
//!
//! From 20 repeats on the part of the repeats in the bias is that of a `BCa` bootstrap, a repeat being a block:
//! [`bootstrap`](super::bootstrap). What everything else adds is added to it in squares. Sizes are no smooth functions of what may be
//! zero, and a bootstrap of them promises too much: they keep theirs.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::bootstrap::{Blocks, bca};
use super::coverage::Z95;
use super::errors::{Cause, Errors, Factor};
use super::pointwise::{Moved, linear};
use super::quadratic::root_mean_square;
use crate::metrics::{Interval, LoopArea, Measure, Metric, Pair, measure};

/// A metric with what is known of it.
#[derive(Debug, Clone, PartialEq)]
pub struct Known {
    /// Value and interval.
    pub measure: Measure,
    /// Its value before the correction for what the errors add, where there is one.
    pub uncorrected: Option<f64>,
    /// The share of each source of the errors in its variance.
    pub shares: Vec<f64>,
    /// How the interval was found.
    pub method: Option<Method>,
}

/// How the interval of a metric was found.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Method {
    /// From variances, with a factor between the normal and Student's.
    Parametric,
    /// Of the repeats by a `BCa` bootstrap.
    Bca,
}

/// Repeats from which a bootstrap is trusted, and how often they are resampled.
const BCA_REPEATS_MIN: usize = 20;
const RESAMPLES: usize = 10_000;

/// Repeats × values × resamples at most: beyond it the parametric interval stays.
const BCA_WORK_MAX: usize = 300_000_000;

/// Parts of a sum that cancel leave so much of each, at most.
const LOOP_ROUNDING: f64 = 1e-9;

impl Known {
    fn of(measure: Measure) -> Self {
        Self { measure, uncorrected: None, shares: vec![], method: None }
    }
}

/// The points of a comparison as numbers, with what moves them.
pub struct Sample<'a> {
    /// Pairs that are used; their intervals are not asked.
    pub used: &'a [Pair],
    /// What moves them.
    pub errors: Errors,
    /// Pairs at zero pressure.
    pub at_zero: &'a [Pair],
    /// What moves those.
    pub errors_at_zero: Errors,
    /// The loop, if the pressure went up and down.
    pub loop_area: Result<LoopArea, &'static str>,
    /// What moves its residuals.
    pub errors_of_loop: Errors,
}

impl Sample<'_> {
    /// A metric of the sample.
    pub fn metric(&self, metric: Metric) -> Known {
        let known = self.parametric(metric);
        self.resampled(metric, &known).unwrap_or(known)
    }

    /// The same with the repeats resampled, where they are many enough, and all there at every point.
    fn resampled(&self, metric: Metric, known: &Known) -> Option<Known> {
        let Measure::Known(interval) = known.measure else { return None };
        if metric != Metric::Bias {
            return None;
        }
        let repeats: Vec<&Factor> = self.errors.factors.iter().filter(|f| self.errors.is_type_a(f)).collect();
        let (n, values) = (repeats.len(), self.used.len() * self.used.first()?.measured.len());
        if n < BCA_REPEATS_MIN || n != self.errors.repeats || n * values * RESAMPLES > BCA_WORK_MAX {
            return None;
        }
        let residuals: Vec<f64> = self.used.iter().flat_map(Pair::differences).collect();
        // What a factor holds of a repeat is its deviation from the mean over √(n (n - 1)).
        let scale = ((n * (n - 1)) as f64).sqrt();
        let column =
            |i: usize| repeats.iter().map(|f| residuals[i] + scale * (f.predicted[i] - f.measured[i])).collect();
        let blocks = Blocks::new((0..values).map(column).collect()).ok()?;
        let points = self.used.len() as f64;
        let statistic = |e: &[f64]| e.iter().sum::<f64>() / points;
        let found = bca(&blocks, &statistic, RESAMPLES, 0, 0.95).ok()?;
        // What everything else adds: its share of the metric's variance.
        let of_repeats: f64 = self
            .errors
            .sources
            .iter()
            .zip(&known.shares)
            .filter(|(s, _)| s.cause == Cause::Repeats)
            .map(|(_, s)| s)
            .sum();
        let other = |end: f64| (interval.value - end).abs() * (1.0 - of_repeats).max(0.0).sqrt();
        let lower = interval.value - (found.value - found.lower).max(0.0).hypot(other(interval.lower));
        let upper = interval.value + (found.upper - found.value).max(0.0).hypot(other(interval.upper));
        let measure = finite(Interval { value: interval.value, lower, upper });
        Some(Known { measure, method: Some(Method::Bca), ..known.clone() })
    }

    /// Whether anything moves the area of the loop beyond what rounding does; so it is where there is none.
    pub fn loop_moves(&self) -> bool {
        let Ok(area) = &self.loop_area else { return true };
        let moves = |f: &Factor| {
            let by = |i: usize| f.predicted[i] - f.measured[i];
            let parts: f64 = area.weights.iter().map(|(i, weight)| (weight * by(*i)).abs()).sum();
            area.of(by).abs() > LOOP_ROUNDING * parts
        };
        self.errors_of_loop.factors.iter().any(moves)
    }

    fn parametric(&self, metric: Metric) -> Known {
        let plain = measure(metric, self.used, self.at_zero, self.loop_area.as_ref().map_err(|why| *why));
        let Measure::Known(Interval { value, .. }) = plain else { return Known::of(plain) };
        match metric {
            Metric::Bias => {
                let n = self.used.len() as f64;
                let moved: Vec<f64> =
                    Self::residuals(self.used, &self.errors).by.iter().map(|by| by.iter().sum::<f64>() / n).collect();
                known_linear(value, &moved, &self.errors)
            }
            Metric::Mae => mean_of(&Self::residuals(self.used, &self.errors), &self.errors),
            Metric::Rmse => self.rmse(),
            Metric::MaxAbsError => largest_of(&Self::residuals(self.used, &self.errors), &self.errors),
            Metric::RelativeToMeasuredMax | Metric::RelativeToMeasuredMean => self.relative(metric, false),
            Metric::RelativeToPredictedMax | Metric::RelativeToPredictedMean => self.relative(metric, true),
            Metric::RelativeToRangeMax => {
                let known = largest_of(&Self::residuals(self.used, &self.errors), &self.errors);
                self.over_range(known)
            }
            Metric::RelativeToRangeRmse => self.over_range(self.rmse()),
            Metric::ResidualAtZero => {
                let moved = Self::residuals(self.at_zero, &self.errors_at_zero);
                if let [_] = moved.values[..] {
                    let by: Vec<f64> = moved.by.iter().map(|by| by[0]).collect();
                    return known_linear(value, &by, &self.errors_at_zero);
                }
                let known = largest_of(&moved, &self.errors_at_zero);
                // Of several the one that is seen largest; its sign is known where it cannot be zero.
                let signed = |Interval { lower, upper, .. }: Interval| match (lower > 0.0, value < 0.0) {
                    (true, true) => Interval { value, lower: -upper, upper: -lower },
                    (true, false) => Interval { value, lower, upper },
                    (false, _) => Interval { value, lower: -upper, upper },
                };
                let measure = match known.measure {
                    Measure::Known(interval) => Measure::Known(signed(interval)),
                    other => other,
                };
                Known { measure, ..known }
            }
            Metric::LoopArea | Metric::LoopAreaShare => {
                let Ok(area) = &self.loop_area else { return Known::of(plain) };
                let scale = if metric == Metric::LoopArea { 1.0 } else { 1.0 / area.box_area };
                let by = |f: &Factor| scale * area.of(|i| f.predicted[i] - f.measured[i]);
                let moved: Vec<f64> = self.errors_of_loop.factors.iter().map(by).collect();
                let known = known_linear(value, &moved, &self.errors_of_loop);
                // A share is a size.
                let size = |measure| match measure {
                    Measure::Known(interval) if metric == Metric::LoopAreaShare => Measure::Known(interval.abs()),
                    other => other,
                };
                Known { measure: size(known.measure), ..known }
            }
            Metric::R2 => Known::of(plain),
        }
    }

    fn rmse(&self) -> Known {
        let residuals: Vec<f64> = self.used.iter().flat_map(Pair::differences).collect();
        let directions: Vec<Vec<f64>> = self.errors.factors.iter().map(difference).collect();
        let found = root_mean_square(&residuals, self.used.len(), &directions, &self.errors);
        Known {
            measure: finite(found.interval),
            uncorrected: Some(found.uncorrected),
            shares: self.errors.shares(found.moved.iter().copied()),
            method: Some(Method::Parametric),
        }
    }

    /// The 95 % interval of every residual that is used, by itself; of a distance, from what may be taken off it.
    pub fn residual_intervals(&self) -> Vec<Interval> {
        let moved = Self::residuals(self.used, &self.errors);
        let is_distance = self.used.first().is_some_and(|pair| pair.measured.len() > 1);
        let of = |(i, value): (usize, &f64)| {
            let half = self.errors.variance(moved.by.iter().map(|by| by[i])).half_width();
            let lower = value - half - moved.across[i];
            Interval { value: *value, lower: if is_distance { lower.max(0.0) } else { lower }, upper: value + half }
        };
        moved.values.iter().enumerate().map(of).collect()
    }

    /// Residuals, or distances of a position, and how each factor moves them.
    fn residuals(pairs: &[Pair], errors: &Errors) -> Moved {
        let width = pairs.first().map_or(1, |p| p.measured.len());
        let differences: Vec<Vec<f64>> = pairs.iter().map(Pair::differences).collect();
        let values: Vec<f64> = differences.iter().map(|d| signed_size(d)).collect();
        let by = errors.factors.iter().map(|factor| {
            let moved = difference(factor);
            differences.iter().enumerate().map(|(i, d)| along(d, &moved[i * width..(i + 1) * width])).collect()
        });
        let by: Vec<Vec<f64>> = by.collect();
        let across = (0..values.len()).map(|i| across(&differences[i], i, errors)).collect();
        Moved { values, by, across }
    }

    /// |residual| over the measured or the predicted value, point by point.
    fn relative(&self, metric: Metric, to_predicted: bool) -> Known {
        let residuals = Self::residuals(self.used, &self.errors);
        let width = self.used.first().map_or(1, |p| p.measured.len());
        let bases: Vec<Vec<f64>> = self.used.iter().map(|p| p.numbers(to_predicted)).collect();
        let sizes: Vec<f64> = bases.iter().map(|b| signed_size(b)).collect();
        let size_by = |factor: &Factor, i: usize| {
            let of = if to_predicted { &factor.predicted } else { &factor.measured };
            along(&bases[i], &of[i * width..(i + 1) * width])
        };
        for (i, size) in sizes.iter().enumerate() {
            let moved = self.errors.factors.iter().map(|f| size_by(f, i));
            if size.abs() <= self.errors.variance(moved).half_width() {
                return Known::of(Measure::Undefined(if to_predicted {
                    "a predicted value that may be zero cannot be a denominator"
                } else {
                    "a measured value that may be zero cannot be a denominator"
                }));
            }
        }
        // d(r/b) = (dr - (r/b) db)/b.
        let values: Vec<f64> = residuals.values.iter().zip(&sizes).map(|(r, b)| r / b).collect();
        let by =
            self.errors.factors.iter().zip(&residuals.by).map(|(factor, r)| {
                (0..values.len()).map(|i| (r[i] - values[i] * size_by(factor, i)) / sizes[i]).collect()
            });
        let across = residuals.across.iter().zip(&sizes).map(|(across, size)| across / size.abs()).collect();
        let by = by.collect();
        let moved = Moved { values, by, across };
        match metric {
            Metric::RelativeToMeasuredMax | Metric::RelativeToPredictedMax => largest_of(&moved, &self.errors),
            _ => mean_of(&moved, &self.errors),
        }
    }

    /// A size over the range of the measured values.
    fn over_range(&self, size: Known) -> Known {
        let measured: Vec<f64> = self.used.iter().flat_map(|p| p.numbers(false)).collect();
        let at = |better: fn(f64, f64) -> bool| {
            (0..measured.len()).reduce(|best, i| if better(measured[i], measured[best]) { i } else { best })
        };
        let (Some(top), Some(bottom)) = (at(|a, b| a > b), at(|a, b| a < b)) else { return size };
        let range = measured[top] - measured[bottom];
        let moved = self.errors.factors.iter().map(|f| f.measured[top] - f.measured[bottom]);
        let open = self.errors.variance(moved).half_width();
        if range <= open {
            return Known::of(Measure::Undefined("the measured values do not span a range"));
        }
        let Measure::Known(Interval { value, lower, upper }) = size.measure else { return size };
        let of_range = value * open / range;
        let interval = Interval {
            value: value / range,
            lower: ((value - (value - lower).hypot(of_range)) / range).max(0.0),
            upper: (value + (upper - value).hypot(of_range)) / range,
        };
        Known { measure: finite(interval), uncorrected: size.uncorrected.map(|v| v / range), ..size }
    }
}

/// By how much a factor moves predicted - measured.
fn difference(factor: &Factor) -> Vec<f64> {
    factor.predicted.iter().zip(&factor.measured).map(|(p, m)| p - m).collect()
}

/// A number as it is; of several components, their length.
fn signed_size(components: &[f64]) -> f64 {
    match components {
        [one] => *one,
        many => many.iter().map(|c| c * c).sum::<f64>().sqrt(),
    }
}

/// By how much the errors square to a vector make it longer, at most: |e + d| is |e| + d∥ + |d⊥|²/2|e| and more, |e| the least that may be.
fn across(vector: &[f64], point: usize, errors: &Errors) -> f64 {
    let width = vector.len();
    if width < 2 {
        return 0.0;
    }
    let of = |component: usize| {
        let moved = |f: &Factor| f.predicted[point * width + component] - f.measured[point * width + component];
        (errors.variance(errors.factors.iter().map(moved)).half_width() / Z95).powi(2)
    };
    let square: f64 = (0..width).map(of).sum();
    let length = vector.iter().map(|v| v * v).sum::<f64>().sqrt();
    let nearest = (length - Z95 * square.sqrt()).max(0.0);
    nearest.hypot(square.sqrt()) - nearest
}

/// By how much a move changes the size of a vector: its part along it, or all of it where the vector is none.
fn along(vector: &[f64], moved: &[f64]) -> f64 {
    let length = vector.iter().map(|v| v * v).sum::<f64>().sqrt();
    match (vector, moved) {
        ([_], [by]) => *by,
        _ if length > 0.0 => vector.iter().zip(moved).map(|(v, by)| v * by).sum::<f64>() / length,
        _ => moved.iter().map(|by| by * by).sum::<f64>().sqrt(),
    }
}

fn known_linear(value: f64, moved: &[f64], errors: &Errors) -> Known {
    let shares = errors.shares(moved.iter().copied());
    Known { measure: finite(linear(value, moved, errors)), uncorrected: None, shares, method: Some(Method::Parametric) }
}

fn largest_of(moved: &Moved, errors: &Errors) -> Known {
    let Some((interval, top)) = moved.largest(errors) else {
        return Known::of(Measure::Undefined("no point where both a measured and a predicted value exist"));
    };
    let shares = errors.shares(moved.by.iter().map(|by| by[top]));
    Known { measure: finite(interval), uncorrected: None, shares, method: Some(Method::Parametric) }
}

fn mean_of(moved: &Moved, errors: &Errors) -> Known {
    let (interval, by) = moved.mean_size(errors);
    let shares = errors.shares(by);
    Known { measure: finite(interval), uncorrected: None, shares, method: Some(Method::Parametric) }
}

fn finite(interval: Interval) -> Measure {
    let Interval { value, lower, upper } = interval;
    if value.is_finite() && lower.is_finite() && upper.is_finite() {
        Measure::Known(interval)
    } else {
        Measure::Undefined("the result is not a finite number")
    }
}
