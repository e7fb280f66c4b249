//! How far a prediction is from a measurement: definitions, version 2.
//!
//! With residual r = predicted - measured, over the n points used (zero-pressure references are not):
//!
//! | metric | definition |
//! |---|---|
//! | `bias` | mean r |
//! | `mae` | mean \|r\| |
//! | `rmse` | √(mean r²) |
//! | `max_abs_error` | max \|r\| |
//! | `relative_to_measured_max`, `_mean` | max, mean of \|r\| / \|measured\| |
//! | `relative_to_predicted_max`, `_mean` | max, mean of \|r\| / \|predicted\| (dual-chamber-finger's choice) |
//! | `relative_to_range_max`, `_rmse` | max \|r\|, RMSE over (max - min of measured) |
//! | `residual_at_zero` | r at the zero-pressure reference; of several, the largest in size |
//! | `r2` | 1 - Σ r² / Σ (measured - its mean)²; shown, never bounded |
//! | `loop_area` | area between unloading and loading over pressure, predicted - measured, by the trapezoidal rule at the measured pressures; shown, never bounded |
//! | `loop_area_share` | its size over (pressure range of the loop × range of measured in it) |
//!
//! Of a position, r is the distance between the predicted and the measured point (wave-finger, Eq. 30: the position error), and
//! \|measured\|, \|predicted\| are distances from the origin of its frame; a distance has no sign, so a position has no bias, and
//! no range and R² are defined for it.
//!
//! **Published points** are intervals: a printed value by half a unit of its last digit either side. Every metric carries the
//! interval that it can take while each printed value moves within its own, all at once: [`measure`]. Pressures, dimensions and
//! constants are taken as exact, although they are printed too; so are conditions, except printed ones declared `exact = false`, which
//! widen the prediction by what their digits leave open. Any other computed prediction has no width. `relative_to_range` and `r2`
//! are handled more coarsely: the former's interval combines the extremes of numerator and denominator, the latter has none.
//!
//! **Sessions** have 95 % intervals from repeats, instruments and inputs: [`crate::uncertainty::intervals`]. There the RMSE is that of the
//! response without what the errors of its points add; what is seen before that correction is stored beside it.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use pneuval_ingest::number::Printed;

/// Version of the definitions above; changes with any number they give.
pub const DEFINITIONS_VERSION: u32 = 2;

/// A metric.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Metric {
    /// Mean residual.
    Bias,
    /// Mean absolute residual.
    Mae,
    /// Root mean square residual.
    Rmse,
    /// Largest absolute residual.
    MaxAbsError,
    /// Largest residual over the measured value.
    RelativeToMeasuredMax,
    /// Mean residual over the measured value.
    RelativeToMeasuredMean,
    /// Largest residual over the predicted value.
    RelativeToPredictedMax,
    /// Mean residual over the predicted value.
    RelativeToPredictedMean,
    /// Largest residual over the measured range.
    RelativeToRangeMax,
    /// RMSE over the measured range.
    RelativeToRangeRmse,
    /// Residual at zero pressure.
    ResidualAtZero,
    /// Coefficient of determination.
    R2,
    /// Area of the loop, predicted - measured.
    LoopArea,
    /// Its size over that of the box around the loop.
    LoopAreaShare,
}

impl Metric {
    /// Every metric, in the order in which they are shown.
    pub const ALL: [Self; 14] = [
        Self::Bias,
        Self::Mae,
        Self::Rmse,
        Self::MaxAbsError,
        Self::RelativeToMeasuredMax,
        Self::RelativeToMeasuredMean,
        Self::RelativeToPredictedMax,
        Self::RelativeToPredictedMean,
        Self::RelativeToRangeMax,
        Self::RelativeToRangeRmse,
        Self::ResidualAtZero,
        Self::R2,
        Self::LoopArea,
        Self::LoopAreaShare,
    ];

    /// Its id in files.
    pub fn id(self) -> &'static str {
        match self {
            Self::Bias => "bias",
            Self::Mae => "mae",
            Self::Rmse => "rmse",
            Self::MaxAbsError => "max_abs_error",
            Self::RelativeToMeasuredMax => "relative_to_measured_max",
            Self::RelativeToMeasuredMean => "relative_to_measured_mean",
            Self::RelativeToPredictedMax => "relative_to_predicted_max",
            Self::RelativeToPredictedMean => "relative_to_predicted_mean",
            Self::RelativeToRangeMax => "relative_to_range_max",
            Self::RelativeToRangeRmse => "relative_to_range_rmse",
            Self::ResidualAtZero => "residual_at_zero",
            Self::R2 => "r2",
            Self::LoopArea => "loop_area",
            Self::LoopAreaShare => "loop_area_share",
        }
    }

    /// Its name on pages.
    pub fn title(self) -> &'static str {
        match self {
            Self::Bias => "bias",
            Self::Mae => "mean |e|",
            Self::Rmse => "RMSE",
            Self::MaxAbsError => "max |e|",
            Self::RelativeToMeasuredMax => "max |e| / measured",
            Self::RelativeToMeasuredMean => "mean |e| / measured",
            Self::RelativeToPredictedMax => "max |e| / predicted",
            Self::RelativeToPredictedMean => "mean |e| / predicted",
            Self::RelativeToRangeMax => "max |e| / range",
            Self::RelativeToRangeRmse => "RMSE / range",
            Self::ResidualAtZero => "e at zero pressure",
            Self::R2 => "R²",
            Self::LoopArea => "e of the loop area",
            Self::LoopAreaShare => "|e| of the loop area / box",
        }
    }

    /// The metric of an id.
    pub fn parse(id: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|m| m.id() == id)
    }

    /// Whether it is a share, or has the quantity's unit.
    pub fn is_ratio(self) -> bool {
        !matches!(self, Self::Bias | Self::Mae | Self::Rmse | Self::MaxAbsError | Self::ResidualAtZero | Self::LoopArea)
    }

    /// Whether an upper bound makes sense: a smaller size is better, and there is a unit to write it in.
    pub fn is_boundable(self) -> bool {
        !matches!(self, Self::R2 | Self::LoopArea)
    }
}

/// A number and the interval it is known to lie in.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Interval {
    /// The number, from the values as printed.
    pub value: f64,
    /// Lower end.
    pub lower: f64,
    /// Upper end.
    pub upper: f64,
}

impl Interval {
    /// The interval of the absolute value.
    #[must_use]
    pub fn abs(self) -> Self {
        let (a, b) = (self.lower.abs(), self.upper.abs());
        let lower = if self.lower <= 0.0 && self.upper >= 0.0 { 0.0 } else { a.min(b) };
        Self { value: self.value.abs(), lower, upper: a.max(b) }
    }

    /// Half its width.
    pub fn half_width(self) -> f64 {
        0.5 * (self.upper - self.lower)
    }

    fn map(self, f: impl Fn(f64) -> f64) -> Self {
        Self { value: f(self.value), lower: f(self.lower), upper: f(self.upper) }
    }

    fn is_finite(self) -> bool {
        self.value.is_finite() && self.lower.is_finite() && self.upper.is_finite()
    }
}

impl From<Printed> for Interval {
    fn from(printed: Printed) -> Self {
        let (value, half) = (printed.si, printed.half_width_si);
        Self { value, lower: value - half, upper: value + half }
    }
}

/// A predicted and a measured value at one point: one interval, or one per component of a position.
#[derive(Debug, Clone, PartialEq)]
pub struct Pair {
    /// Predicted.
    pub predicted: Vec<Interval>,
    /// Measured.
    pub measured: Vec<Interval>,
}

impl Pair {
    /// Predicted - measured; of a position, the distance between the two.
    pub fn residual(&self) -> Interval {
        let component = |(p, m): (&Interval, &Interval)| Interval {
            value: p.value - m.value,
            lower: p.lower - m.upper,
            upper: p.upper - m.lower,
        };
        let components: Vec<Interval> = self.predicted.iter().zip(&self.measured).map(component).collect();
        match components.as_slice() {
            [one] => *one,
            many => length(many),
        }
    }

    /// Predicted - measured, component by component.
    pub fn differences(&self) -> Vec<f64> {
        self.predicted.iter().zip(&self.measured).map(|(p, m)| p.value - m.value).collect()
    }

    /// The predicted or the measured values.
    pub fn numbers(&self, predicted: bool) -> Vec<f64> {
        let side = if predicted { &self.predicted } else { &self.measured };
        side.iter().map(|component| component.value).collect()
    }

    /// Whether it is a position.
    fn is_position(&self) -> bool {
        self.measured.len() > 1
    }

    /// |predicted / measured - 1| = |residual| / |measured|: `None` where the measured interval touches zero.
    fn relative_to_measured(&self) -> Option<Interval> {
        self.relative_to(&self.predicted, &self.measured)
    }

    /// |measured / predicted - 1| = |residual| / |predicted|.
    fn relative_to_predicted(&self) -> Option<Interval> {
        self.relative_to(&self.measured, &self.predicted)
    }

    fn relative_to(&self, other: &[Interval], base: &[Interval]) -> Option<Interval> {
        if let ([a], [b]) = (other, base) {
            return relative(*a, *b);
        }
        let (error, size) = (self.residual(), length(base));
        (size.lower > 0.0).then(|| Interval {
            value: error.value / size.value,
            lower: error.lower / size.upper,
            upper: error.upper / size.lower,
        })
    }
}

/// The length of a vector of intervals.
fn length(components: &[Interval]) -> Interval {
    let norm = |of: fn(&Interval) -> f64| components.iter().map(|c| of(&c.abs()).powi(2)).sum::<f64>().sqrt();
    Interval { value: norm(|c| c.value), lower: norm(|c| c.lower), upper: norm(|c| c.upper) }
}

/// |a / b - 1| over both intervals. The quotient is monotone in each, so its extremes lie at the corners.
fn relative(a: Interval, b: Interval) -> Option<Interval> {
    if b.lower <= 0.0 && b.upper >= 0.0 {
        return None;
    }
    let corners = [a.lower / b.lower, a.lower / b.upper, a.upper / b.lower, a.upper / b.upper];
    let lower = corners.iter().copied().fold(f64::INFINITY, f64::min);
    let upper = corners.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    // The value as |a - b| / |b|, the papers' own order of operations.
    let value = (a.value - b.value).abs() / b.value.abs();
    let size = Interval { value, lower: lower - 1.0, upper: upper - 1.0 }.abs();
    // Both orders of operations round differently: the value stays inside its interval.
    Some(Interval { value, lower: size.lower.min(value), upper: size.upper.max(value) })
}

/// What is known of a metric.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Measure {
    /// A finite number with its interval.
    Known(Interval),
    /// A finite number without interval.
    Shown(f64),
    /// No number, and why.
    Undefined(&'static str),
}

/// What the area of a loop is made of: weights of values, so that it is a sum.
#[derive(Debug, Clone, PartialEq)]
pub struct LoopArea {
    /// Index of a value and its weight in Pa, of unloading minus loading.
    pub weights: Vec<(usize, f64)>,
    /// Predicted and measured value by index.
    pub values: Vec<(f64, f64)>,
    /// The box around the measured loop: pressure range × range of the values, in their unit × Pa.
    pub box_area: f64,
}

impl LoopArea {
    /// The weighted sum of something that each value has.
    pub fn of(&self, value: impl Fn(usize) -> f64) -> f64 {
        self.weights.iter().map(|(i, weight)| weight * value(*i)).sum()
    }
}

/// A metric over the pairs used, with the pairs at zero pressure and the loop, or why there is none.
pub fn measure(
    metric: Metric,
    pairs: &[Pair],
    at_zero: &[Pair],
    loop_area: Result<&LoopArea, &'static str>,
) -> Measure {
    if matches!(metric, Metric::LoopArea | Metric::LoopAreaShare) {
        let area = match loop_area {
            Ok(area) => area,
            Err(why) => return Measure::Undefined(why),
        };
        let error = area.of(|i| area.values[i].0 - area.values[i].1);
        let value = if metric == Metric::LoopArea { error } else { error.abs() / area.box_area };
        return finite(Interval { value, lower: value, upper: value });
    }
    if metric == Metric::ResidualAtZero {
        let residuals: Vec<Interval> = at_zero.iter().map(Pair::residual).collect();
        if residuals.iter().any(|r| !r.is_finite()) {
            return Measure::Undefined("a measured or predicted value at zero pressure is not a finite number");
        }
        let largest = residuals.into_iter().max_by(|a, b| a.value.abs().total_cmp(&b.value.abs()));
        return largest.map_or(Measure::Undefined("no zero-pressure reference"), finite);
    }
    if pairs.is_empty() {
        return Measure::Undefined("no point where both a measured and a predicted value exist");
    }
    let residuals: Vec<Interval> = pairs.iter().map(Pair::residual).collect();
    if residuals.iter().any(|r| !r.is_finite()) {
        return Measure::Undefined("a measured or predicted value is not a finite number");
    }
    let no_sign = "a position error is a distance: it has no sign, no range and no R²";
    let signed = matches!(metric, Metric::Bias | Metric::RelativeToRangeMax | Metric::RelativeToRangeRmse | Metric::R2);
    if signed && pairs.iter().any(Pair::is_position) {
        return Measure::Undefined(no_sign);
    }
    let sizes: Vec<Interval> = residuals.iter().map(|r| r.abs()).collect();
    let rmse = mean(sizes.iter().map(|s| s.map(|x| x * x))).map(f64::sqrt);
    match metric {
        Metric::Bias => finite(mean(residuals.iter().copied())),
        Metric::Mae => finite(mean(sizes.iter().copied())),
        Metric::Rmse => finite(rmse),
        Metric::MaxAbsError => finite(max(sizes.iter().copied())),
        Metric::RelativeToMeasuredMax | Metric::RelativeToMeasuredMean => {
            match pairs.iter().map(Pair::relative_to_measured).collect::<Option<Vec<_>>>() {
                None => Measure::Undefined("a measured value of zero cannot be a denominator"),
                Some(shares) if metric == Metric::RelativeToMeasuredMax => finite(max(shares.into_iter())),
                Some(shares) => finite(mean(shares.into_iter())),
            }
        }
        Metric::RelativeToPredictedMax | Metric::RelativeToPredictedMean => {
            match pairs.iter().map(Pair::relative_to_predicted).collect::<Option<Vec<_>>>() {
                None => Measure::Undefined("a predicted value of zero cannot be a denominator"),
                Some(shares) if metric == Metric::RelativeToPredictedMax => finite(max(shares.into_iter())),
                Some(shares) => finite(mean(shares.into_iter())),
            }
        }
        Metric::RelativeToRangeMax => over_range(max(sizes.iter().copied()), pairs),
        Metric::RelativeToRangeRmse => over_range(rmse, pairs),
        Metric::R2 => r2(pairs),
        Metric::ResidualAtZero | Metric::LoopArea | Metric::LoopAreaShare => {
            Measure::Undefined("it is not formed from these points")
        }
    }
}

/// Never hands on a number that is not one: NaN in, `Undefined` out.
fn finite(interval: Interval) -> Measure {
    if interval.is_finite() {
        Measure::Known(interval)
    } else {
        Measure::Undefined("the result is not a finite number")
    }
}

fn mean(items: impl ExactSizeIterator<Item = Interval>) -> Interval {
    let n = items.len() as f64;
    let sum = items.fold(Interval { value: 0.0, lower: 0.0, upper: 0.0 }, |a, b| Interval {
        value: a.value + b.value,
        lower: a.lower + b.lower,
        upper: a.upper + b.upper,
    });
    sum.map(|x| x / n)
}

fn max(items: impl Iterator<Item = Interval>) -> Interval {
    items.fold(Interval { value: 0.0, lower: 0.0, upper: 0.0 }, |a, b| Interval {
        value: a.value.max(b.value),
        lower: a.lower.max(b.lower),
        upper: a.upper.max(b.upper),
    })
}

fn over_range(size: Interval, pairs: &[Pair]) -> Measure {
    let extreme = |pick: fn(f64, f64) -> f64, start: f64, of: fn(&Interval) -> f64| {
        pairs.iter().flat_map(|p| &p.measured).map(of).fold(start, pick)
    };
    let range = |of_max: fn(&Interval) -> f64, of_min: fn(&Interval) -> f64| {
        extreme(f64::max, f64::NEG_INFINITY, of_max) - extreme(f64::min, f64::INFINITY, of_min)
    };
    let range = Interval {
        value: range(|i| i.value, |i| i.value),
        lower: range(|i| i.lower, |i| i.upper),
        upper: range(|i| i.upper, |i| i.lower),
    };
    if range.lower <= 0.0 {
        return Measure::Undefined("the measured values do not span a range");
    }
    finite(Interval {
        value: size.value / range.value,
        lower: size.lower / range.upper,
        upper: size.upper / range.lower,
    })
}

fn r2(pairs: &[Pair]) -> Measure {
    let n = pairs.len() as f64;
    let measured = || pairs.iter().flat_map(|p| &p.measured).map(|m| m.value);
    let centre = measured().sum::<f64>() / n;
    let total: f64 = measured().map(|m| (m - centre).powi(2)).sum();
    let left: f64 = pairs.iter().map(|p| p.residual().value.powi(2)).sum();
    let value = 1.0 - left / total;
    if total == 0.0 {
        Measure::Undefined("the measured values do not vary")
    } else if value.is_finite() {
        Measure::Shown(value)
    } else {
        Measure::Undefined("the result is not a finite number")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const NO_LOOP: Result<&LoopArea, &str> = Err("no loop");

    fn pairs(predicted: &[(f64, f64)], measured: &[(f64, f64)]) -> Vec<Pair> {
        let interval =
            |(si, half_width_si): &(f64, f64)| Interval::from(Printed { si: *si, half_width_si: *half_width_si });
        let pair = |(p, m)| Pair { predicted: vec![interval(p)], measured: vec![interval(m)] };
        predicted.iter().zip(measured).map(pair).collect()
    }

    fn known(metric: Metric, pairs: &[Pair]) -> Interval {
        match measure(metric, pairs, &[], NO_LOOP) {
            Measure::Known(interval) => interval,
            other => panic!("{metric:?}: {other:?}"),
        }
    }

    fn published(predicted: [f64; 5], half: f64) -> Vec<Pair> {
        let measured = [33.44, 35.67, 37.72, 39.66, 41.45].map(|m| (m, 0.005));
        pairs(&predicted.map(|p| (p, half)), &measured)
    }

    /// internal-support, table of gauge pressure against L: the published errors.
    #[test]
    fn published_theory_and_fea_give_the_golden_numbers() {
        let theory = published([32.5, 34.8, 36.9, 38.8, 40.6], 0.05);
        assert!((known(Metric::Rmse, &theory).value - 0.8689).abs() < 5e-5);
        assert!((known(Metric::MaxAbsError, &theory).value - 0.94).abs() < 1e-12);
        assert!((known(Metric::RelativeToMeasuredMax, &theory).value - 0.028_11).abs() < 5e-6);
        let fea = published([31.86, 33.92, 35.93, 37.81, 39.59], 0.005);
        assert!((known(Metric::Rmse, &fea).value - 1.7689).abs() < 5e-5);
        assert!((known(Metric::MaxAbsError, &fea).value - 1.86).abs() < 1e-12);
        assert!((known(Metric::RelativeToMeasuredMax, &fea).value - 0.049_06).abs() < 5e-6);
    }

    /// By hand: residuals 1, -2, 3 on measured 10, 20, 30.
    #[test]
    fn every_metric_by_hand() {
        let p = pairs(&[(11.0, 0.0), (18.0, 0.0), (33.0, 0.0)], &[(10.0, 0.0), (20.0, 0.0), (30.0, 0.0)]);
        for (metric, expected) in [
            (Metric::Bias, 2.0 / 3.0),
            (Metric::Mae, 2.0),
            (Metric::Rmse, (14.0_f64 / 3.0).sqrt()),
            (Metric::MaxAbsError, 3.0),
            (Metric::RelativeToMeasuredMax, 0.1),
            (Metric::RelativeToMeasuredMean, 0.1),
            (Metric::RelativeToPredictedMax, 2.0 / 18.0),
            (Metric::RelativeToPredictedMean, (1.0 / 11.0 + 2.0 / 18.0 + 3.0 / 33.0) / 3.0),
            (Metric::RelativeToRangeMax, 0.15),
            (Metric::RelativeToRangeRmse, (14.0_f64 / 3.0).sqrt() / 20.0),
        ] {
            let found = known(metric, &p);
            for number in [found.value, found.lower, found.upper] {
                assert!((number - expected).abs() < 1e-15, "{metric:?}: {number} {expected}");
            }
        }
        assert_eq!(measure(Metric::R2, &p, &[], NO_LOOP), Measure::Shown(1.0 - 14.0 / 200.0));
        let at_zero = pairs(&[(0.5, 0.0)], &[(0.0, 0.0)]);
        let Measure::Known(zero) = measure(Metric::ResidualAtZero, &p, &at_zero, NO_LOOP) else { panic!() };
        assert!((zero.value - 0.5).abs() < 1e-15);
    }

    /// Every corner of the box of printed intervals lies inside the stated interval, and the interval is no wider than needed.
    #[test]
    fn intervals_are_the_extremes_over_the_printed_digits() {
        let predicted = [(5.2, 0.05), (-3.0, 0.5)];
        let measured = [(5.0, 0.5), (-2.0, 0.5)];
        let steps = [-1.0, -0.5, 0.0, 0.5, 1.0];
        for metric in Metric::ALL
            .into_iter()
            .filter(|m| !matches!(m, Metric::R2 | Metric::ResidualAtZero | Metric::LoopArea | Metric::LoopAreaShare))
        {
            let stated = known(metric, &pairs(&predicted, &measured));
            let (mut lower, mut upper) = (f64::INFINITY, f64::NEG_INFINITY);
            for a in steps {
                for b in steps {
                    for c in steps {
                        for d in steps {
                            let at = |(v, h): (f64, f64), s: f64| (v + s * h, 0.0);
                            let moved = pairs(
                                &[at(predicted[0], a), at(predicted[1], b)],
                                &[at(measured[0], c), at(measured[1], d)],
                            );
                            let value = known(metric, &moved).value;
                            (lower, upper) = (lower.min(value), upper.max(value));
                        }
                    }
                }
            }
            assert!(stated.lower <= lower + 1e-12 && stated.upper >= upper - 1e-12, "{metric:?} too narrow");
            let coarse = matches!(metric, Metric::RelativeToRangeMax | Metric::RelativeToRangeRmse);
            // The grid may step over a zero of |r|, so only the upper end is held to be tight.
            assert!(coarse || stated.upper <= upper + 1e-12, "{metric:?} too wide: {stated:?} {lower} {upper}");
        }
    }

    /// By hand: distances 5 (3-4-5) and 0, from points 10 (6-8-10) and 13 (5-12-13) from the origin.
    #[test]
    fn a_position_error_is_the_distance() {
        let exact = |values: [f64; 2]| values.map(|v| Interval::from(Printed { si: v, half_width_si: 0.0 })).to_vec();
        let pair = |p, m| Pair { predicted: exact(p), measured: exact(m) };
        let p = [pair([9.0, 12.0], [6.0, 8.0]), pair([5.0, 12.0], [5.0, 12.0])];
        for (metric, expected) in [
            (Metric::Mae, 2.5),
            (Metric::Rmse, 12.5_f64.sqrt()),
            (Metric::MaxAbsError, 5.0),
            (Metric::RelativeToMeasuredMax, 0.5),
            (Metric::RelativeToPredictedMax, 1.0 / 3.0),
        ] {
            assert!((known(metric, &p).value - expected).abs() < 1e-15, "{metric:?}");
        }
        for metric in [Metric::Bias, Metric::RelativeToRangeMax, Metric::RelativeToRangeRmse, Metric::R2] {
            assert!(matches!(measure(metric, &p, &[], NO_LOOP), Measure::Undefined(_)), "{metric:?}");
        }
        let wide = |v: f64, half_width_si| Interval::from(Printed { si: v, half_width_si });
        let open = Pair { predicted: exact([3.0, 4.0]), measured: vec![wide(0.0, 1.0), wide(0.0, 1.0)] };
        let found = open.residual();
        assert!((found.lower - 13.0_f64.sqrt()).abs() < 1e-15 && (found.upper - 41.0_f64.sqrt()).abs() < 1e-15);
    }

    #[test]
    fn nan_empty_and_zero_denominators_give_no_number() {
        let nan = pairs(&[(1.0, 0.0), (f64::NAN, 0.0)], &[(1.0, 0.0), (2.0, 0.0)]);
        let zero = pairs(&[(0.0, 0.0)], &[(0.0, 0.0)]);
        for metric in Metric::ALL {
            assert!(matches!(measure(metric, &nan, &nan[1..], NO_LOOP), Measure::Undefined(_)), "{metric:?}");
            assert!(matches!(measure(metric, &[], &[], NO_LOOP), Measure::Undefined(_)), "{metric:?}");
        }
        for metric in
            [Metric::RelativeToMeasuredMax, Metric::RelativeToPredictedMean, Metric::RelativeToRangeMax, Metric::R2]
        {
            assert!(matches!(measure(metric, &zero, &[], NO_LOOP), Measure::Undefined(_)), "{metric:?}");
        }
    }

    #[test]
    fn ids_are_found_and_unique() {
        for metric in Metric::ALL {
            assert_eq!(Metric::parse(metric.id()), Some(metric));
            assert_eq!(serde_json::to_string(&metric).unwrap(), format!("\"{}\"", metric.id()));
        }
    }
}
