//! What is compared: actuators, materials, datasets, sessions and their quantities.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use pneuval_ingest::units::Unit;

use super::Severity;
use crate::format;

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
    /// Clocks that were set on another by events, run by run.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub alignments: Vec<AlignmentRecord>,
    /// Lags of motions behind pressures that another device or table holds, run by run.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub lags: Vec<LagRecord>,
    /// Some of its photographs, with what was measured in them.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub photographs: Vec<PhotographRecord>,
}

/// A photograph that is shown.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PhotographRecord {
    /// The picture with its marks, relative to the results folder.
    pub path: String,
    /// The run it is of.
    pub run: String,
    /// Its file, or its topic and number.
    pub name: String,
    /// What was measured, in words.
    pub label: String,
    /// Why nothing was.
    pub refused: Option<String>,
    /// In px, as it is shown.
    pub width: usize,
    /// In px, as it is shown.
    pub height: usize,
}

/// A value with what is left open of it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct EstimateRecord {
    /// The value.
    pub value: f64,
    /// Its standard uncertainty.
    pub std: f64,
    /// The lower end of its 95 % interval.
    pub lower: f64,
    /// The upper end.
    pub upper: f64,
}

/// A clock set on another by events that both recorded: `reference = stamp + offset + drift (stamp - at)`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct AlignmentRecord {
    /// The run.
    pub run: String,
    /// The table whose stamps were set on the reference: its device and topic.
    pub table: String,
    /// The table of the reference clock.
    pub reference: String,
    /// Events that the table shows.
    pub events: usize,
    /// Events that the reference shows.
    pub events_reference: usize,
    /// Events that both show, by which the clock was set.
    pub events_used: usize,
    /// What is added to the stamps in the middle of the events, in s, where it is known best.
    pub offset_s: Option<EstimateRecord>,
    /// That middle on the reference clock, in s.
    pub at_s: Option<f64>,
    /// What is added at the first stamp of the reference, in s.
    pub offset_at_start_s: Option<EstimateRecord>,
    /// That first stamp, in s.
    pub start_s: f64,
    /// What is added more in every second of the stamps; null: one event does not say.
    pub drift: Option<EstimateRecord>,
    /// Root mean square of what the events differ by after all, in s.
    pub residual_s: Option<f64>,
    /// The factor by which uncertainties grew, because the events contradict each other; 1: they do not.
    pub inflation: Option<f64>,
    /// Why the clock was not set.
    pub refused: Option<String>,
}

/// The lag of a motion behind a pressure: the shift under which the two correlate best.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LagRecord {
    /// The run.
    pub run: String,
    /// The quantity.
    pub quantity: String,
    /// The channel of the pressure.
    pub pressure: String,
    /// The channel of the motion.
    pub channel: String,
    /// Its table.
    pub table: String,
    /// `physical`: that of rig and specimen, kept; `total`: that of clocks, rig and specimen in sum, kept; `clock`: that of the clock,
    /// by which the stamps were shifted.
    pub meaning: String,
    /// The lag in s, positive where the motion comes later; null: none was found.
    pub value_s: Option<f64>,
    /// Its standard uncertainty, in s.
    pub std_s: Option<f64>,
    /// The correlation under that shift.
    pub correlation: Option<f64>,
    /// Why none was found.
    pub refused: Option<String>,
}

impl SessionRecord {
    /// Samples excluded and lines skipped, as a share of what there should be; where the channels of a response come from several
    /// tables, at least the share of the table that lost most.
    pub fn excluded_share(&self) -> f64 {
        let lost = self.samples_excluded + self.lines_skipped;
        let of_all = lost as f64 / (self.samples_read + self.lines_skipped).max(1) as f64;
        self.worst_table().map_or(of_all, |table| table.excluded_share().max(of_all))
    }

    /// The table that lost the largest share of its samples, where a response needs several.
    pub fn worst_table(&self) -> Option<&TableRecord> {
        let tables = self.responses.iter().flat_map(|response| &response.tables);
        tables.max_by(|a, b| a.excluded_share().total_cmp(&b.excluded_share()))
    }
}

/// A run of a session.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RunRecord {
    /// Its id.
    pub id: String,
    /// Its log, or its logs one behind the other.
    pub file: String,
    /// Samples.
    pub samples: usize,
    /// From first to last stamp, s.
    pub span_s: Option<f64>,
    /// Samples per second where none are missing; of several clocks the fastest.
    pub rate_hz: Option<f64>,
    /// Clocks of the channels kept in `logs.parquet` that are not set on one another; each is counted from its own first stamp.
    pub clocks: usize,
    /// Channels with a clock that are not kept there.
    pub channels_left_out: usize,
    /// Where findings are in its logs, as far as their time is known.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub marks: Vec<MarkRecord>,
}

/// Where a finding is in a run.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MarkRecord {
    /// What kind it is, such as `gap`.
    pub kind: String,
    /// How much it matters.
    pub severity: Severity,
    /// The channels that it is about: one, or all on a clock.
    pub channels: Vec<String>,
    /// From then, in s since the first stamp of the run.
    pub from_s: f64,
    /// To then.
    pub to_s: f64,
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
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
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
    /// Samples and holes table by table, where the channels come from several.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub tables: Vec<TableRecord>,
    /// What is repeated: runs, or the conditioned cycles of a sole run.
    pub repeats: Vec<String>,
    /// Points of a cycle that is shown and not compared.
    pub points_apart: usize,
    /// The loop between loading and unloading, and what is left of it.
    pub way: WayRecord,
}

/// How a response depends on the way of the pressure.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct WayRecord {
    /// Area between unloading and loading, in the quantity's SI unit × Pa.
    pub loop_area_si: Option<IntervalRecord>,
    /// Why there is none.
    pub no_loop: Option<String>,
    /// What is left at zero pressure behind the way down, less what was there before, in SI units.
    pub residual_at_zero_si: Option<IntervalRecord>,
    /// Change of the mean reading from cycle to cycle, in SI units; over runs, too.
    pub drift_per_cycle_si: Option<IntervalRecord>,
    /// Conditioned cycles it is taken from.
    pub drift_cycles: usize,
}

/// A number with its 95 % interval; without repeats and declared instruments it has none.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct IntervalRecord {
    /// The number.
    pub value: f64,
    /// Lower end.
    pub lower: Option<f64>,
    /// Upper end.
    pub upper: Option<f64>,
}

/// What became of the samples of one table of a session.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TableRecord {
    /// Its device and topic.
    pub table: String,
    /// Samples read.
    pub samples: usize,
    /// Samples with a hole in a channel needed.
    pub holes: usize,
}

impl TableRecord {
    /// Samples excluded as a share of those read.
    pub fn excluded_share(&self) -> f64 {
        self.holes as f64 / self.samples.max(1) as f64
    }
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
