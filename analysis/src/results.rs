//! Every number of a validation, computed once: the content of `results.json`.
//!
//! Values are in SI units; residual = predicted - measured. The JSON Schema in `analysis/schema/` is generated from these
//! types, and a test holds the two together.

mod comparisons;
mod subjects;
mod trajectory;

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use pneuval_ingest::manifest::is_id;

use crate::format;

pub use comparisons::{
    BudgetRecord, Comparison, FitRecord, FittedParameter, InputsRecord, JudgementRecord, MetricRecord, Point,
    PointStatus, Standing, ValidationRecord,
};
pub use subjects::{
    ActuatorRecord, AlignmentRecord, CensusRecord, ChannelRecord, ConditionRecord, DatasetRecord, EstimateRecord,
    InputRecord, IntervalRecord, LagRecord, ListingRecord, MarkRecord, MaterialRecord, PhotographRecord,
    QuantityRecord, RunRecord, SessionRecord, SourceFile, StatedRecord, TableRecord, WayRecord,
};
pub use trajectory::{Against, AlignmentKind, MeetingRecord, MovementAlignmentRecord, RunMeetingRecord};

/// Version of the layout of `results.json`.
pub const SCHEMA_VERSION: u32 = 4;

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
            let worst = s.worst_table().filter(|table| table.excluded_share() > s.excluded_share_max);
            let of_table = worst.map(|table| {
                format!(
                    "{}: {} of {} samples of {} are excluded, more than the {} allowed",
                    d.id,
                    table.holes,
                    table.samples,
                    table.table,
                    format::percent(s.excluded_share_max)
                )
            });
            let of_all = || {
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
            };
            of_table.or_else(|| (s.excluded_share() > s.excluded_share_max).then(of_all))
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
                    && as_wide(&p.measured_half_width)
                    && p.predicted_half_width.len() == width
            };
            let is_path = c.against != Against::Pressure;
            if (c.chambers.is_empty() && !c.metrics_printed && !is_path) || !c.points.iter().all(fits) {
                return Err(format!("{}: a point without a pressure per chamber or a value per component", c.id));
            }
            if is_path && !c.points.iter().all(|p| p.at.is_some_and(f64::is_finite)) {
                return Err(format!("{}: a point of a movement without a place on it", c.id));
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
