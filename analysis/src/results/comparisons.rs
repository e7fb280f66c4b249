//! Comparisons: their points, metrics and judgements, and what these mean for the exit code.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{Against, ConditionRecord, MeetingRecord, MovementAlignmentRecord, QuantityRecord};
use crate::bounds::Bound;
use crate::metrics::{Interval, Measure, Metric};
use crate::response::Branch;
use crate::uncertainty::errors::Cause;
use crate::uncertainty::intervals::Method;
use crate::verdict::{Basis, Verdict, is_as_expected};

/// One prediction against one measurement.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Comparison {
    /// `dataset/quantity/form`.
    pub id: String,
    /// Actuator id.
    pub actuator: String,
    /// Dataset id.
    pub dataset: String,
    /// What is compared.
    pub quantity: QuantityRecord,
    /// Form id.
    pub form: String,
    /// Name in legends and tables.
    pub title: String,
    /// `published`, `printed`, `consistent` or `reading`.
    pub kind: String,
    /// Paper and place of the prediction.
    pub source: String,
    /// Paper and place of the measurement, and how it was measured.
    pub measured_source: String,
    /// The equation, for computed forms.
    pub equation: Option<String>,
    /// What fails in print, or departs from it.
    pub misprints: Vec<String>,
    /// Inputs that nobody printed or measured: `assumed sheet_width`, `calibrated C10`.
    pub rests_on: Vec<String>,
    /// Runs of this comparison on which values of the actuator file were calibrated, `dataset/quantity run`: then it is calibration.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub calibrated_on: Vec<String>,
    /// The calibration that came first.
    pub fit: Option<FitRecord>,
    /// What is equal where the two are compared.
    pub against: Against,
    /// Of a movement at equal time or arc length, how much of it meets the prediction.
    pub meeting: Option<MeetingRecord>,
    /// How the prediction was moved onto the measurement first; null: not at all.
    pub alignment: Option<MovementAlignmentRecord>,
    /// Every point is one sample of one run, of which no other is a repeat: those of a movement.
    pub samples_alone: bool,
    /// Ground of the intervals.
    pub basis: Basis,
    /// The metrics are printed in the source, without the points behind them: nobody can compute them again.
    pub metrics_printed: bool,
    /// What is set beside the pressure, in the order of each point's conditions.
    pub conditions: Vec<ConditionRecord>,
    /// Chambers, in the order of each point's pressures.
    pub chambers: Vec<String>,
    /// Points with a measured value; of a movement, how many could meet the prediction.
    pub n_available: usize,
    /// Points that entered the metrics.
    pub n_used: usize,
    /// Measured points, zero reference apart, at which the prediction has no value.
    pub n_without_prediction: usize,
    /// Every point of the source, used or not.
    pub points: Vec<Point>,
    /// Every metric.
    pub metrics: Vec<MetricRecord>,
    /// What makes the uncertainty of the residuals; empty for published points.
    pub budget: Vec<BudgetRecord>,
    /// What the comparison says of the model as ASME V&V 20 asks; null for published points.
    pub validation: Option<ValidationRecord>,
    /// What became of uncertain inputs of the model; null where none is declared.
    pub inputs: Option<InputsRecord>,
    /// Every bound with its verdict.
    pub judgements: Vec<JudgementRecord>,
    /// The verdict of the bound that decides.
    pub verdict: Verdict,
    /// Whether it counts for the exit code.
    pub counted: bool,
    /// Why, in a sentence.
    pub sentence: String,
    /// What the page says about it.
    pub remark: Option<String>,
}

/// A calibration.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FitRecord {
    /// The data it was fitted to.
    pub fitted_on: Vec<String>,
    /// Which points the fit did not see, in words; null: none were held out.
    pub hold_out: Option<String>,
    /// Fitted parameters.
    pub parameters: Vec<FittedParameter>,
    /// Root mean square residual of the fit, SI units.
    pub rmse_si: f64,
    /// Points fitted.
    pub n: usize,
    /// Condition number of the scaled Jacobian.
    pub condition_number: f64,
}

/// A fitted parameter.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FittedParameter {
    /// Name.
    pub name: String,
    /// Value in SI units.
    pub value_si: f64,
    /// Standard uncertainty from the residual scatter, SI units.
    pub std_si: Option<f64>,
    /// Unit it is shown in.
    pub unit: String,
}

/// What became of a point.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum PointStatus {
    /// In the metrics.
    Used,
    /// At zero pressure: the reference, not in the metrics.
    ZeroReference,
    /// No measured value is printed.
    HoleInPrint,
    /// Measured or predicted is not a finite number: no metric can be formed.
    NotFinite,
    /// The model has no value here.
    NoPrediction,
    /// The prediction is a printed column with a hole here.
    PredictionNotPrinted,
    /// The model was fitted on this point, and is judged on others.
    InFit,
    /// No model predicts this quantity.
    NotCompared,
    /// In a cycle that is shown and not compared: the first, beside conditioned ones.
    CycleApart,
}

impl PointStatus {
    /// Its word in files.
    pub fn id(self) -> &'static str {
        match self {
            Self::Used => "used",
            Self::ZeroReference => "zero_reference",
            Self::HoleInPrint => "hole_in_print",
            Self::NotFinite => "not_finite",
            Self::NoPrediction => "no_prediction",
            Self::PredictionNotPrinted => "prediction_not_printed",
            Self::InFit => "in_fit",
            Self::NotCompared => "not_compared",
            Self::CycleApart => "cycle_apart",
        }
    }
}

/// A point of a comparison.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Point {
    /// Line of the source, from 1; 0 where the raw file has no lines.
    pub line: usize,
    /// Runs whose repeats it is the mean of; empty for a printed point.
    pub runs: Vec<String>,
    /// Which way the pressure went; null for a printed point.
    pub branch: Option<Branch>,
    /// Repeats behind it: runs, or conditioned cycles of a sole run; 0 for a printed point.
    pub repeats: usize,
    /// Gauge pressure per chamber, Pa.
    pub pressures_gauge_pa: Vec<f64>,
    /// Share of the largest pressure in size, -1 to 1.
    pub pressure_share: f64,
    /// Of a movement, where it is compared: time in s, or share of the arc length; null where that is the pressure.
    pub at: Option<f64>,
    /// Value of each condition, SI units.
    pub conditions_si: Vec<f64>,
    /// Measured value per component; null where there is none or it is not finite.
    pub measured: Option<Vec<f64>>,
    /// Half the width of its interval, per component; null where nothing is known of it.
    pub measured_half_width: Option<Vec<f64>>,
    /// Predicted value per component; null where there is none.
    pub predicted: Option<Vec<f64>>,
    /// Half the width of its interval, per component; 0 for a computed value.
    pub predicted_half_width: Vec<f64>,
    /// Predicted - measured; of a position, the distance between the two.
    pub residual: Option<f64>,
    /// Lower end of its interval: of what printed digits leave open, or 95 % of a session, for this point by itself; null where nothing
    /// is known, and where the point is not used.
    pub residual_lower: Option<f64>,
    /// Upper end.
    pub residual_upper: Option<f64>,
    /// What became of it.
    pub status: PointStatus,
    /// Why it is not used.
    pub reason: Option<String>,
}

/// A metric of a comparison.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MetricRecord {
    /// Which.
    pub metric: Metric,
    /// Value, SI units or share; null where it cannot be formed.
    pub value: Option<f64>,
    /// Lower end of its interval: of what printed digits leave open, or 95 % of a session.
    pub lower: Option<f64>,
    /// Upper end.
    pub upper: Option<f64>,
    /// Before what the errors of the points add was taken off: of an RMSE in a session.
    pub uncorrected: Option<f64>,
    /// The share of each row of the budget in its variance; empty where there is none.
    pub shares: Vec<f64>,
    /// How the interval of a session's metric was found.
    pub method: Option<Method>,
    /// Why there is no value.
    pub undefined: Option<String>,
    /// Where some points have no prediction, or too few meet it: the metric over the others. Never judged.
    pub over_predicted_points: Option<f64>,
    /// Some point behind it is a single repeat of a session, so that its interval lacks the scatter.
    pub single_repeat: bool,
}

impl Point {
    /// The measured value of a plain number.
    pub fn measured_scalar(&self) -> Option<f64> {
        scalar(self.measured.as_deref())
    }

    /// The predicted value of a plain number.
    pub fn predicted_scalar(&self) -> Option<f64> {
        scalar(self.predicted.as_deref())
    }
}

fn scalar(values: Option<&[f64]>) -> Option<f64> {
    match values {
        Some([one]) => Some(*one),
        _ => None,
    }
}

impl MetricRecord {
    /// The record of a measure.
    pub fn new(metric: Metric, measure: Measure) -> Self {
        let mut record = Self {
            metric,
            value: None,
            lower: None,
            upper: None,
            uncorrected: None,
            shares: vec![],
            method: None,
            undefined: None,
            over_predicted_points: None,
            single_repeat: false,
        };
        match measure {
            Measure::Known(Interval { value, lower, upper }) => {
                (record.value, record.lower, record.upper) = (Some(value), Some(lower), Some(upper));
            }
            Measure::Shown(value) => record.value = Some(value),
            Measure::Undefined(why) => record.undefined = Some(why.to_owned()),
        }
        record
    }

    /// What is known of it, for judging again.
    pub fn measure(&self) -> Measure {
        match (self.value, self.lower, self.upper) {
            (Some(value), Some(lower), Some(upper)) => Measure::Known(Interval { value, lower, upper }),
            (Some(value), ..) => Measure::Shown(value),
            _ => Measure::Undefined("stored without a value"),
        }
    }

    /// Keeps a value from being taken for that of the whole: it is told as one over some points, and never judged.
    pub fn withhold(&mut self, why: &str) {
        let told = self.uncorrected.take().or(self.value);
        self.value = None;
        self.over_predicted_points = told.or(self.over_predicted_points);
        (self.lower, self.upper, self.method) = (None, None, None);
        self.shares.clear();
        self.undefined.get_or_insert_with(|| why.to_owned());
    }
}

/// A source of uncertainty of the residuals.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BudgetRecord {
    /// Which: an instrument and its channel, an input of the model, repeats.
    pub source: String,
    /// Of what kind.
    pub cause: Cause,
    /// `A`: from the scatter of the data; `B`: from what is declared.
    pub evaluation: String,
    /// Degrees of freedom, of type A.
    pub degrees_of_freedom: Option<usize>,
    /// Standard uncertainty of a residual, root mean square over the points used, SI units.
    pub std_rms_si: f64,
    /// The largest.
    pub std_max_si: f64,
}

/// The Monte Carlo of a model's inputs.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct InputsRecord {
    /// Inputs with a standard uncertainty.
    pub names: Vec<String>,
    /// Samples drawn.
    pub samples: usize,
    /// Whether the quantiles of the prediction stayed where they were at the last doubling.
    pub settled: bool,
    /// Samples for which the model has no solution: left out.
    pub without_solution: usize,
    /// What went wrong; then the budget lacks the inputs, or is not settled.
    pub problem: Option<String>,
}

/// Comparison error and validation uncertainty, root mean square over the points used, SI units (ASME V&V 20).
///
/// E = S - D, `u_val² = u_num² + u_input² + u_D²`: how far the model may be off without these data telling it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ValidationRecord {
    /// Of E, predicted - measured.
    pub e_si: f64,
    /// Of the data: repeats, instruments, and the pressures and conditions at which they were taken.
    pub u_d_si: f64,
    /// Of the inputs of the model.
    pub u_input_si: f64,
    /// Of its solution.
    pub u_num_si: f64,
    /// Of all.
    pub u_val_si: f64,
    /// Values used, component by component.
    pub values: usize,
    /// Those with |E| within the 95 % interval that `u_val` gives: there the data show no error of the model.
    pub within: usize,
}

/// A bound and its verdict.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct JudgementRecord {
    /// The bound.
    pub bound: Bound,
    /// The verdict.
    pub verdict: Verdict,
    /// Why, in a sentence.
    pub sentence: String,
}

impl Comparison {
    /// What must be known beside its numbers: how much of a movement met the prediction, and how that was moved.
    pub fn circumstances(&self) -> String {
        let met = self.meeting.as_ref().filter(|meeting| !meeting.is_too_little()).map(MeetingRecord::text);
        let moved = self.alignment.as_ref().map(|alignment| alignment.text(self.quantity.unit()));
        let texts: Vec<String> = met.into_iter().chain(moved).map(|text| format!("; {text}")).collect();
        texts.concat()
    }

    /// How much of a bound is used; more than all of it where there is no value.
    pub fn share_of(&self, judgement: &JudgementRecord) -> f64 {
        let bound = &judgement.bound;
        let value = self.metric(bound.metric).and_then(|m| m.value);
        value.filter(|_| bound.max > 0.0).map_or(f64::INFINITY, |v| v / bound.max)
    }

    /// Its place in the order in which a reader needs comparisons: what differs first, then what is open, then by the share of the
    /// bound that is used; what counts least has the greatest number.
    pub fn urgency(&self) -> (u8, f64) {
        let rank = match self.standing() {
            Standing::Unexpected => 0,
            Standing::Open => 1,
            Standing::AsExpected => 2,
            Standing::NotCounted => 3,
        };
        (rank, -self.judgements.iter().map(|j| self.share_of(j)).fold(0.0, f64::max))
    }

    /// A metric's record.
    pub fn metric(&self, metric: Metric) -> Option<&MetricRecord> {
        self.metrics.iter().find(|m| m.metric == metric)
    }

    /// The judgement that makes the comparison's standing: one that differs from the expected, else an open one, else a
    /// failure, else the first.
    pub fn deciding(&self) -> Option<&JudgementRecord> {
        let rank = |j: &&JudgementRecord| match (j.verdict, is_as_expected(j.verdict, j.bound.expect)) {
            (Verdict::Fail, false) => 0,
            (Verdict::Pass, false) => 1,
            (_, false) => 2,
            (Verdict::Fail, true) => 3,
            (_, true) => 4,
        };
        self.judgements.iter().min_by_key(rank)
    }

    /// What the comparison means for the exit code.
    pub fn standing(&self) -> Standing {
        if !self.counted {
            return Standing::NotCounted;
        }
        let closed = |j: &&JudgementRecord| matches!(j.verdict, Verdict::Pass | Verdict::Fail);
        if self.judgements.iter().filter(closed).any(|j| !is_as_expected(j.verdict, j.bound.expect)) {
            return Standing::Unexpected;
        }
        if !self.judgements.is_empty() && self.judgements.iter().all(|j| is_as_expected(j.verdict, j.bound.expect)) {
            return Standing::AsExpected;
        }
        Standing::Open
    }
}

/// What a comparison means for the exit code.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Standing {
    /// Every verdict is the expected one.
    AsExpected,
    /// Some verdict is the opposite of the expected one.
    Unexpected,
    /// Inconclusive or unjudged.
    Open,
    /// Calibration, or judged by nobody on purpose.
    NotCounted,
}
