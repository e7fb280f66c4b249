//! Every number of a validation, computed once: the content of `results.json`.
//!
//! Values are in SI units; residual = predicted - measured. The JSON Schema in `analysis/schema/` is generated from these
//! types, and a test holds the two together.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use pneuval_ingest::manifest::is_id;
use pneuval_ingest::units::Unit;

use crate::bounds::Bound;
use crate::format;
use crate::metrics::{Interval, Measure, Metric};
use crate::verdict::{Basis, Verdict, is_as_expected};

/// Version of the layout of `results.json`.
pub const SCHEMA_VERSION: u32 = 2;

/// The results of one `validate`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Results {
    /// Version of this layout.
    pub schema_version: u32,
    /// Name and version of the program.
    pub program: String,
    /// Version of the metric definitions.
    pub metric_definitions: u32,
    /// Verdicts are shown, but the exit code is 0.
    pub report_only: bool,
    /// One per actuator, by id.
    pub actuators: Vec<ActuatorRecord>,
    /// One per row of the main table, by actuator, in the order of the dataset.
    pub comparisons: Vec<Comparison>,
    /// What a reader should know about the run, by severity and text.
    pub findings: Vec<FindingRecord>,
    /// SHA-256 of the other files of the results folder, by relative path.
    pub files: BTreeMap<String, String>,
}

/// How much a finding matters.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Severity {
    /// Data are gone: the results are open.
    Lost,
    /// Samples are left out, counted and listed.
    Excluded,
    /// Worth knowing; nothing is missing.
    Note,
}

impl Severity {
    /// The word used in files and on pages.
    pub fn name(self) -> &'static str {
        match self {
            Self::Lost => "lost",
            Self::Excluded => "excluded",
            Self::Note => "note",
        }
    }
}

/// Something a reader should know about the run.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FindingRecord {
    /// How much it matters.
    pub severity: Severity,
    /// What kind it is, such as `gap` or `non-numeric-cell`.
    pub kind: String,
    /// The dataset or session it is about, if any.
    pub dataset: Option<String>,
    /// The file, relative to the session's folder.
    pub file: Option<String>,
    /// The channel or column.
    pub channel: Option<String>,
    /// Samples or lines concerned.
    pub count: Option<usize>,
    /// Where, the first of many.
    pub spans: Vec<SpanRecord>,
    /// What was found.
    pub text: String,
}

/// A stretch of samples and lines of a log.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SpanRecord {
    /// From 0.
    pub first_sample: usize,
    /// Inclusive.
    pub last_sample: usize,
    /// From 1.
    pub first_line: usize,
    /// Inclusive.
    pub last_line: usize,
}

/// An actuator and the data it was compared with.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ActuatorRecord {
    /// Id.
    pub id: String,
    /// Type, which chooses the models.
    pub kind: String,
    /// Name on pages.
    pub title: String,
    /// What it is.
    pub summary: String,
    /// Dimensions and material constants.
    pub inputs: Vec<InputRecord>,
    /// Materials and where their laws are stable.
    pub materials: Vec<MaterialRecord>,
    /// Datasets, by id.
    pub datasets: Vec<DatasetRecord>,
}

/// A dimension or material constant.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct InputRecord {
    /// Name.
    pub name: String,
    /// Value in SI units.
    pub value_si: f64,
    /// Standard uncertainty in SI units, if stated.
    pub std_si: Option<f64>,
    /// Unit it was written in.
    pub unit: String,
    /// `published`, `measured`, `assumed` or `calibrated`.
    pub origin: String,
    /// Paper, table or equation.
    pub place: Option<String>,
}

/// A material of an actuator.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MaterialRecord {
    /// Its id in the actuator file.
    pub id: String,
    /// Its law.
    pub law: String,
    /// Initial shear modulus, Pa.
    pub initial_shear_modulus_pa: f64,
    /// Where the stress stops rising, per load case; null: not up to the stretch looked at.
    pub unstable_from: BTreeMap<String, Option<f64>>,
    /// The stretch looked at.
    pub stretch_max: f64,
}

/// A dataset or session and where it comes from.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DatasetRecord {
    /// Id.
    pub id: String,
    /// Title of the paper, or of the session.
    pub title: String,
    /// Authors, journal, year, DOI.
    pub reference: Option<String>,
    /// For a session: what was read and how.
    pub session: Option<SessionRecord>,
    /// Sentences for the page.
    pub notes: Vec<String>,
    /// Figures whose data are not printed.
    pub unprinted: Vec<String>,
    /// Results stated in the text, not compared here.
    pub stated: Vec<StatedRecord>,
    /// Tables shown as printed.
    pub listings: Vec<ListingRecord>,
    /// Every file that went in, relative to the dataset's folder.
    pub sources: Vec<SourceFile>,
}

/// A sitting at a rig.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SessionRecord {
    /// Written by a program, not by a rig.
    pub synthetic: bool,
    /// When, in the user's words.
    pub date: Option<String>,
    /// Who.
    pub operator: Option<String>,
    /// The rig.
    pub rig: Option<String>,
    /// What was tested, in words.
    pub specimen: Vec<(String, String)>,
    /// Logs.
    pub runs: Vec<RunRecord>,
    /// Channels and how they were calibrated.
    pub channels: Vec<ChannelRecord>,
    /// Samples of all runs.
    pub samples_read: usize,
    /// Of those, samples that the response that lost most could not use: a hole in a channel it needs, or no stamp that counts.
    pub samples_excluded: usize,
    /// Lines of the logs that hold no sample and should have.
    pub lines_skipped: usize,
    /// The share of excluded samples that the session allows.
    pub excluded_share_max: f64,
    /// Per response: samples read, samples with a hole in a channel needed, samples in a point.
    pub responses: Vec<CensusRecord>,
}

impl SessionRecord {
    /// Samples excluded and lines skipped, as a share of what there should be.
    pub fn excluded_share(&self) -> f64 {
        let lost = self.samples_excluded + self.lines_skipped;
        lost as f64 / (self.samples_read + self.lines_skipped).max(1) as f64
    }
}

/// A run of a session.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RunRecord {
    /// Its id.
    pub id: String,
    /// Its log.
    pub file: String,
    /// Samples.
    pub samples: usize,
    /// From first to last stamp, s.
    pub span_s: Option<f64>,
    /// Samples per second, from the median step.
    pub rate_hz: Option<f64>,
}

/// A channel of a session.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ChannelRecord {
    /// Its id.
    pub id: String,
    /// The column, or what it is derived from.
    pub source: String,
    /// The unit it is shown in.
    pub unit: String,
    /// The instrument and its calibration.
    pub instrument: Option<String>,
    /// Standard uncertainty of one sample, SI units.
    pub std_si: Option<f64>,
}

/// What became of the samples of a response.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CensusRecord {
    /// The quantity.
    pub quantity: String,
    /// Samples read.
    pub samples: usize,
    /// Samples with a hole in a channel needed.
    pub holes: usize,
    /// Samples that lie in a point.
    pub used: usize,
    /// Points.
    pub points: usize,
}

/// A result stated in a paper.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct StatedRecord {
    /// What it is.
    pub title: String,
    /// Value in SI units.
    pub value_si: f64,
    /// Unit it is printed in.
    pub unit: String,
    /// Where it is printed.
    pub place: Option<String>,
}

/// A table as printed.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ListingRecord {
    /// What it is.
    pub title: String,
    /// Where it is printed.
    pub place: String,
    /// Column names with units.
    pub names: Vec<String>,
    /// Cells.
    pub rows: Vec<Vec<String>>,
}

/// A file that went in.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SourceFile {
    /// Path relative to the dataset's folder.
    pub path: String,
    /// SHA-256.
    pub sha256: String,
}

/// What is compared.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct QuantityRecord {
    /// Id.
    pub id: String,
    /// Name on pages.
    pub title: String,
    /// SI unit of every value below.
    pub si_unit: String,
    /// Unit it is shown in.
    pub display_unit: String,
    /// Names of the components of a position; empty for a plain number.
    pub components: Vec<String>,
}

/// What is set beside the pressure at each point.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ConditionRecord {
    /// Id.
    pub id: String,
    /// Name on pages.
    pub title: String,
    /// Unit it is shown in.
    pub display_unit: String,
}

impl ConditionRecord {
    /// A value in SI units as text: `held angle 30°`.
    pub fn text(&self, value_si: f64) -> String {
        let value = Unit::parse(&self.display_unit).map_or_else(
            || format::short(value_si),
            |unit| format::with_unit(&format::short(unit.from_si(value_si)), unit),
        );
        format!("{} {value}", self.title)
    }
}

impl QuantityRecord {
    /// Whether it is a position.
    pub fn is_position(&self) -> bool {
        !self.components.is_empty()
    }

    /// The unit it is shown in.
    pub fn unit(&self) -> Unit {
        // Written by this program from a parsed unit; a hand-edited unknown one falls back to SI or a plain number.
        let plain = || Unit { symbol: "1", dimension: pneuval_ingest::units::Dimension::Ratio, factor: 1.0 };
        Unit::parse(&self.display_unit).or_else(|| Unit::parse(&self.si_unit)).unwrap_or_else(plain)
    }
}

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
    /// The calibration that came first.
    pub fit: Option<FitRecord>,
    /// Ground of the intervals.
    pub basis: Basis,
    /// The metrics are printed in the source, without the points behind them: nobody can compute them again.
    pub metrics_printed: bool,
    /// What is set beside the pressure, in the order of each point's conditions.
    pub conditions: Vec<ConditionRecord>,
    /// Chambers, in the order of each point's pressures.
    pub chambers: Vec<String>,
    /// Points with a measured value.
    pub n_available: usize,
    /// Points that entered the metrics.
    pub n_used: usize,
    /// Measured points, zero reference apart, at which the prediction has no value.
    pub n_without_prediction: usize,
    /// Every point of the source, used or not.
    pub points: Vec<Point>,
    /// Every metric.
    pub metrics: Vec<MetricRecord>,
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
}

/// A point of a comparison.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Point {
    /// Line of the source.
    pub line: usize,
    /// Runs whose repeats it is the mean of; empty for a printed point.
    pub runs: Vec<String>,
    /// Gauge pressure per chamber, Pa.
    pub pressures_gauge_pa: Vec<f64>,
    /// Share of the largest pressure in size, -1 to 1.
    pub pressure_share: f64,
    /// Value of each condition, SI units.
    pub conditions_si: Vec<f64>,
    /// Measured value per component; null where there is none or it is not finite.
    pub measured: Option<Vec<f64>>,
    /// Half the width of its interval, per component.
    pub measured_half_width: Vec<f64>,
    /// Predicted value per component; null where there is none.
    pub predicted: Option<Vec<f64>>,
    /// Half the width of its interval, per component; 0 for a computed value.
    pub predicted_half_width: Vec<f64>,
    /// Predicted - measured; of a position, the distance between the two.
    pub residual: Option<f64>,
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
    /// Lower end of what the printed digits leave open.
    pub lower: Option<f64>,
    /// Upper end.
    pub upper: Option<f64>,
    /// Why there is no value.
    pub undefined: Option<String>,
    /// Where some points have no prediction: the metric over the others. Never judged.
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

/// The decision of a whole validation.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Decision {
    /// Every verdict is as expected.
    AsExpected,
    /// Some verdict differs from the expected one.
    Unexpected,
    /// Nothing differs, but something is open, or nothing was judged at all.
    Open,
}

impl Results {
    /// The decision: a differing verdict outweighs an open one.
    pub fn decision(&self) -> Decision {
        let count = |standing| self.comparisons.iter().filter(|c| c.standing() == standing).count();
        if count(Standing::Unexpected) > 0 {
            Decision::Unexpected
        } else if count(Standing::Open) > 0 || count(Standing::AsExpected) == 0 || !self.losses().is_empty() {
            Decision::Open
        } else {
            Decision::AsExpected
        }
    }

    /// Why data that were lost, or too many that were excluded, leave the results open whatever the verdicts.
    pub fn losses(&self) -> Vec<String> {
        let lost = self.findings.iter().filter(|f| f.severity == Severity::Lost).map(|f| f.text.clone());
        let excluded = self.actuators.iter().flat_map(|a| &a.datasets).filter_map(|d| {
            let s = d.session.as_ref()?;
            (s.excluded_share() > s.excluded_share_max).then(|| {
                format!(
                    "{}: {} of {} samples are excluded{}, more than the {} allowed",
                    d.id,
                    s.samples_excluded,
                    s.samples_read,
                    if s.lines_skipped > 0 {
                        format!(", and {} lines hold none", s.lines_skipped)
                    } else {
                        String::new()
                    },
                    format::percent(s.excluded_share_max)
                )
            })
        });
        lost.chain(excluded).collect()
    }

    /// Whether the parts fit together: ids that are ids, points with a pressure per chamber, counts that are those of the points.
    ///
    /// # Errors
    /// What does not fit, in words.
    pub fn check(&self) -> Result<(), String> {
        let id = |text: &str| if is_id(text) { Ok(()) } else { Err(format!("`{}` is not an id", text.escape_debug())) };
        for actuator in &self.actuators {
            id(&actuator.id)?;
        }
        for (i, c) in self.comparisons.iter().enumerate() {
            if self.comparisons[..i].iter().any(|other| other.id == c.id) {
                return Err(format!("{}: twice", c.id));
            }
            for text in [&c.actuator, &c.dataset, &c.quantity.id, &c.form] {
                id(text)?;
            }
            if !self.actuators.iter().any(|a| a.id == c.actuator) {
                return Err(format!("{}: its actuator is not listed", c.id));
            }
            let fits = |p: &Point| {
                let width = c.quantity.components.len().max(1);
                let as_wide = |values: &Option<Vec<f64>>| values.as_ref().is_none_or(|v| v.len() == width);
                p.pressures_gauge_pa.len() == c.chambers.len()
                    && p.conditions_si.len() == c.conditions.len()
                    && as_wide(&p.measured)
                    && as_wide(&p.predicted)
                    && p.measured_half_width.len() == width
                    && p.predicted_half_width.len() == width
            };
            if (c.chambers.is_empty() && !c.metrics_printed) || !c.points.iter().all(fits) {
                return Err(format!("{}: a point without a pressure per chamber or a value per component", c.id));
            }
            let count = |status| c.points.iter().filter(|p| p.status == status).count();
            if c.n_used != count(PointStatus::Used) || c.n_without_prediction != count(PointStatus::NoPrediction) {
                return Err(format!("{}: counts that are not those of its points", c.id));
            }
        }
        Ok(())
    }

    /// The JSON Schema of this layout.
    pub fn schema() -> serde_json::Value {
        schemars::schema_for!(Self).to_value()
    }
}
