//! `judge()`: the only place where a metric meets a bound.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::bounds::{Bound, Expect};
use crate::metrics::{Interval, Measure};

/// What is known about the comparison.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Verdict {
    /// The whole interval is within the bound.
    Pass,
    /// The whole interval is beyond the bound, or the model gives no prediction where there is a measurement.
    Fail,
    /// Not finite, not printed, no overlap, or the interval straddles the bound.
    Inconclusive,
    /// No bound.
    Unjudged,
    /// The model was fitted on the same data: shown, never counted.
    Calibration,
}

impl Verdict {
    /// The word used in files and on pages.
    pub fn name(self) -> &'static str {
        match self {
            Self::Pass => "pass",
            Self::Fail => "fail",
            Self::Inconclusive => "inconclusive",
            Self::Unjudged => "unjudged",
            Self::Calibration => "calibration",
        }
    }
}

/// On what ground an interval is known.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Basis {
    /// Printed values: the interval is what their last digits leave open; no measurement uncertainty is published.
    PublishedPoint,
    /// Measured in a session: points and metrics have 95 % intervals from repeats, instruments and the model's inputs.
    Session,
}

impl Basis {
    /// The label on pages.
    pub fn label(self) -> &'static str {
        match self {
            Self::PublishedPoint => "published point: no measurement uncertainty published",
            Self::Session => "measured session: 95 % intervals from repeats and the instruments' declared uncertainty",
        }
    }
}

/// A verdict and the sentence that says why.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Judgement {
    /// The verdict.
    pub verdict: Verdict,
    /// Why, and what would decide it if it is open.
    pub why: Why,
}

/// The reason behind a verdict, for whoever words it with units.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Why {
    /// The interval lies within the bound.
    Within,
    /// The interval lies beyond the bound.
    Beyond,
    /// The interval reaches over the bound.
    Straddles,
    /// The interval is wider than the bound's `max_uncertainty`.
    TooUncertain,
    /// The metric is not a finite number.
    NotFinite,
    /// The model predicts nothing at some measured point.
    NoPrediction,
    /// One repeat, and the bound does not allow that.
    SingleRepeat,
    /// One repeat, and the instruments declare no uncertainty.
    NoInterval,
}

/// What a metric rests on, beside its number.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Grounds {
    /// Measured points at which the model has no value.
    pub points_without_prediction: usize,
    /// Some point is a single repeat of a session, so that the interval lacks the scatter.
    pub single_repeat: bool,
}

/// Compares a metric with a bound.
///
/// Passes by `upper <= max`, never by "not greater". Where the model has no value at a measured point it fails, whatever the metric
/// over the other points. A single repeat decides nothing unless the bound allows it and the instruments declare an
/// uncertainty. The caller gives 0 such points where a value that is not a
/// number leaves everything open; such a metric comes as [`Measure::Undefined`], and is looked at before any bound.
///
/// ```
/// use pneuval_analysis::bounds::{Bound, Expect};
/// use pneuval_analysis::metrics::{Interval, Measure, Metric};
/// use pneuval_analysis::verdict::{Grounds, Verdict, judge};
/// let bound = Bound {
///     metric: Metric::Rmse, max: 1.0, max_uncertainty: None, reason: "need".into(), expect: Expect::Pass,
///     allow_single_repeat: false,
/// };
/// let known = |value| Measure::Known(Interval { value, lower: value - 0.1, upper: value + 0.1 });
/// assert_eq!(judge(known(0.9), &bound, Grounds::default()).verdict, Verdict::Pass);
/// assert_eq!(judge(known(1.05), &bound, Grounds::default()).verdict, Verdict::Inconclusive);
/// assert_eq!(judge(known(1.2), &bound, Grounds::default()).verdict, Verdict::Fail);
/// assert_eq!(judge(Measure::Undefined("NaN"), &bound, Grounds::default()).verdict, Verdict::Inconclusive);
/// ```
pub fn judge(measure: Measure, bound: &Bound, grounds: Grounds) -> Judgement {
    let judgement = |verdict, why| Judgement { verdict, why };
    if grounds.points_without_prediction > 0 {
        return judgement(Verdict::Fail, Why::NoPrediction);
    }
    let interval = match measure {
        Measure::Known(interval) => interval.abs(),
        Measure::Shown(value) if value.is_finite() && grounds.single_repeat => {
            return judgement(Verdict::Inconclusive, Why::NoInterval);
        }
        Measure::Shown(_) | Measure::Undefined(_) => return judgement(Verdict::Inconclusive, Why::NotFinite),
    };
    let Interval { value, lower, upper } = interval;
    let numbers = value.is_finite() && lower.is_finite() && upper.is_finite() && bound.max.is_finite();
    if !(numbers && lower <= value && value <= upper) {
        return judgement(Verdict::Inconclusive, Why::NotFinite);
    }
    if grounds.single_repeat && !bound.allow_single_repeat {
        return judgement(Verdict::Inconclusive, Why::SingleRepeat);
    }
    if lower > bound.max {
        return judgement(Verdict::Fail, Why::Beyond);
    }
    if upper <= bound.max {
        return match bound.max_uncertainty {
            None => judgement(Verdict::Pass, Why::Within),
            Some(limit) if interval.half_width() <= limit => judgement(Verdict::Pass, Why::Within),
            Some(_) => judgement(Verdict::Inconclusive, Why::TooUncertain),
        };
    }
    judgement(Verdict::Inconclusive, Why::Straddles)
}

/// Whether a verdict is what its bound expects; an open verdict is neither.
pub fn is_as_expected(verdict: Verdict, expect: Expect) -> bool {
    matches!((verdict, expect), (Verdict::Pass, Expect::Pass) | (Verdict::Fail, Expect::Exceed))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::metrics::Metric;

    fn bound(max: f64, max_uncertainty: Option<f64>) -> Bound {
        let (metric, expect) = (Metric::Bias, Expect::Pass);
        Bound { metric, max, max_uncertainty, reason: String::new(), expect, allow_single_repeat: false }
    }

    fn known(value: f64, half: f64) -> Measure {
        Measure::Known(Interval { value, lower: value - half, upper: value + half })
    }

    fn verdict(measure: Measure, max: f64) -> Verdict {
        judge(measure, &bound(max, None), Grounds::default()).verdict
    }

    #[test]
    fn equal_passes_and_the_next_double_above_fails() {
        assert_eq!(verdict(known(1.0, 0.0), 1.0), Verdict::Pass);
        assert_eq!(verdict(known(1.0_f64.next_up(), 0.0), 1.0), Verdict::Fail);
        assert_eq!(verdict(known(1.0_f64.next_down(), 0.0), 1.0), Verdict::Pass);
    }

    #[test]
    fn a_negative_bias_is_judged_by_its_size() {
        assert_eq!(verdict(known(-1.5, 0.1), 1.0), Verdict::Fail);
        assert_eq!(verdict(known(-0.5, 0.1), 1.0), Verdict::Pass);
        assert_eq!(verdict(known(0.0, 2.0), 1.0), Verdict::Inconclusive);
    }

    #[test]
    fn nothing_that_is_not_finite_passes_or_fails() {
        for value in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            assert_eq!(verdict(known(value, 0.0), 1.0), Verdict::Inconclusive);
            assert_eq!(verdict(known(0.5, 0.0), value), Verdict::Inconclusive);
        }
        assert_eq!(verdict(Measure::Undefined("empty"), 1.0), Verdict::Inconclusive);
        assert_eq!(verdict(Measure::Shown(0.5), 1.0), Verdict::Inconclusive);
    }

    #[test]
    fn a_point_without_prediction_fails_whatever_the_rest_says() {
        let without = |n| Grounds { points_without_prediction: n, ..Grounds::default() };
        assert_eq!(judge(known(0.0, 0.0), &bound(1.0, None), without(1)).verdict, Verdict::Fail);
        assert_eq!(judge(Measure::Undefined("none"), &bound(1.0, None), without(5)).verdict, Verdict::Fail);
    }

    #[test]
    fn a_single_repeat_decides_only_where_the_bound_allows_it() {
        let grounds = Grounds { single_repeat: true, ..Grounds::default() };
        for (value, allowed) in [(0.5, Verdict::Pass), (5.0, Verdict::Fail)] {
            let strict = bound(1.0, None);
            let lenient = Bound { allow_single_repeat: true, ..strict.clone() };
            assert_eq!(judge(known(value, 0.1), &strict, grounds).why, Why::SingleRepeat);
            assert_eq!(judge(known(value, 0.1), &lenient, grounds).verdict, allowed);
            // Without a declared uncertainty there is no interval to judge.
            assert_eq!(judge(Measure::Shown(value), &lenient, grounds).why, Why::NoInterval);
        }
    }

    #[test]
    fn an_interval_wider_than_allowed_does_not_pass() {
        assert_eq!(judge(known(0.5, 0.2), &bound(1.0, Some(0.1)), Grounds::default()).why, Why::TooUncertain);
        assert_eq!(judge(known(0.5, 0.1), &bound(1.0, Some(0.2)), Grounds::default()).verdict, Verdict::Pass);
        // A failure beyond doubt stays one, however wide.
        assert_eq!(judge(known(5.0, 0.2), &bound(1.0, Some(0.1)), Grounds::default()).verdict, Verdict::Fail);
    }

    #[test]
    fn only_the_expected_outcome_is_as_expected() {
        assert!(is_as_expected(Verdict::Pass, Expect::Pass) && is_as_expected(Verdict::Fail, Expect::Exceed));
        for (verdict, expect) in [
            (Verdict::Fail, Expect::Pass),
            (Verdict::Pass, Expect::Exceed),
            (Verdict::Inconclusive, Expect::Pass),
            (Verdict::Inconclusive, Expect::Exceed),
        ] {
            assert!(!is_as_expected(verdict, expect));
        }
    }
}
