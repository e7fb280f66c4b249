//! What results say of a movement: where it meets its prediction, and how the prediction was moved onto it.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use pneuval_ingest::manifest::Abscissa;
use pneuval_ingest::units::Unit;

use crate::format;

/// What is equal where a measurement and a prediction are compared.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Against {
    /// Gauge pressure.
    Pressure,
    /// Time, in s.
    Time,
    /// The share of the path's arc length, 0 to 1.
    ArcLength,
}

impl Against {
    /// Its name in sentences.
    pub fn name(self) -> &'static str {
        match self {
            Self::Pressure => "pressure",
            Self::Time => "time",
            Self::ArcLength => "arc length",
        }
    }
}

impl From<Abscissa> for Against {
    fn from(at: Abscissa) -> Self {
        match at {
            Abscissa::Pressure => Self::Pressure,
            Abscissa::Time => Self::Time,
            Abscissa::ArcLength => Self::ArcLength,
        }
    }
}

/// How much of a movement meets its prediction.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MeetingRecord {
    /// Stamps of the two series are as far apart as this at most, in s; null where the measurement is interpolated.
    pub within_s: Option<f64>,
    /// The smallest overlap of all runs.
    pub overlap: f64,
    /// With less than this nothing is judged.
    pub overlap_min: f64,
    /// One per run.
    pub runs: Vec<RunMeetingRecord>,
}

/// How much of one run meets its prediction.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RunMeetingRecord {
    /// The run.
    pub run: String,
    /// Pairs of a measured and a predicted value.
    pub n_matched: usize,
    /// How many there could be: the rows of the prediction; where the nearest stamps are paired, the samples of the shorter series.
    pub n_available: usize,
    /// The share of the shorter series that meets the other: of its samples where the nearest are paired, else of its time; at equal arc
    /// length, of the rows of the prediction.
    pub overlap: f64,
    /// Pairs whose sample of the longer series had been paired before.
    pub met_twice: usize,
    /// Rows of the prediction outside of what was measured, or without a stamp near enough.
    pub n_outside: usize,
    /// Rows of the prediction within a step of the measurement that is longer than `gap_s`.
    pub n_in_gaps: usize,
    /// Rows of the prediction at an instant that the measurement has twice.
    pub n_at_doubled_stamps: usize,
    /// The longest step that is interpolated across, in s; null: none is, or there is no clock.
    pub gap_s: Option<f64>,
    /// First and last measured stamp, in s.
    pub measured_s: Option<(f64, f64)>,
    /// First and last predicted stamp, in s.
    pub predicted_s: Option<(f64, f64)>,
    /// At equal arc length: how long the measured path is, its noise included, in SI units.
    pub measured_length_si: Option<f64>,
    /// At equal arc length: how long the predicted path is, in SI units.
    pub predicted_length_si: Option<f64>,
}

impl MeetingRecord {
    /// Pairs of all runs.
    pub fn n_matched(&self) -> usize {
        self.runs.iter().map(|run| run.n_matched).sum()
    }

    /// How many there could be.
    pub fn n_available(&self) -> usize {
        self.runs.iter().map(|run| run.n_available).sum()
    }

    /// Whether too little of the two overlaps to say anything of the whole.
    pub fn is_too_little(&self) -> bool {
        // What is not a number is too little.
        self.overlap.is_nan() || self.overlap < self.overlap_min || self.n_matched() == 0
    }

    /// How many met, in words.
    pub fn text(&self) -> String {
        let least = if self.runs.len() > 1 { "at least " } else { "" };
        format!("{} of {} met, overlap {least}{}", self.n_matched(), self.n_available(), format::percent(self.overlap))
    }

    /// Where the two lie that overlap too little.
    pub fn reach(&self) -> String {
        let Some(run) = self.runs.iter().min_by(|a, b| a.overlap.total_cmp(&b.overlap)) else {
            return "no run has every channel".to_owned();
        };
        let from_to = |name: &str, range: Option<(f64, f64)>| match range {
            Some((first, last)) => format!("{name} from {first:.3} s to {last:.3} s"),
            None => format!("nothing {name}"),
        };
        let reach = match (run.measured_s, run.predicted_s) {
            (None, None) => String::new(),
            (measured, predicted) => {
                format!(": {}, {}", from_to("measured", measured), from_to("predicted", predicted))
            }
        };
        format!("{} of {} met in run {}{reach}", run.n_matched, run.n_available, run.run)
    }
}

impl RunMeetingRecord {
    /// What is worth knowing of how it met, in sentences.
    pub fn told(&self) -> Vec<String> {
        let mut told = Vec::new();
        let rows = |n: usize| if n == 1 { "1 row".to_owned() } else { format!("{n} rows") };
        if self.met_twice > 0 {
            told.push(format!(
                "{} of {} pairs share a sample of the longer series with another",
                self.met_twice, self.n_matched
            ));
        }
        if self.n_in_gaps > 0 {
            let gap = self.gap_s.map_or(String::new(), |gap| format!(" longer than {} s", format::short(gap)));
            told.push(format!(
                "{} of the prediction in gaps of the measurement{gap}: nothing is interpolated there",
                rows(self.n_in_gaps)
            ));
        }
        if self.n_at_doubled_stamps > 0 {
            let n = rows(self.n_at_doubled_stamps);
            told.push(format!(
                "{n} of the prediction at stamps that were measured twice: nothing is interpolated there"
            ));
        }
        told
    }
}

/// Which movement of the prediction was allowed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum AlignmentKind {
    /// A shift, so that the first points meet; of several runs, on average.
    Origin,
    /// A rotation and a shift, by least squares.
    Rigid,
}

/// How a prediction was moved onto the measurement: aligned = rotation · predicted + translation.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MovementAlignmentRecord {
    /// What was allowed.
    pub kind: AlignmentKind,
    /// Pairs that it rests on.
    pub n: usize,
    /// In three dimensions, the axis of the rotation; null where nothing is turned. In two the angle counts from the first component
    /// towards the second.
    pub rotation_axis: Option<Vec<f64>>,
    /// Angle of the rotation, in degrees.
    pub rotation_deg: f64,
    /// What is added to the turned prediction, per component, in SI units.
    pub translation_si: Vec<f64>,
    /// Root mean square distance of those pairs before, SI units.
    pub rmse_before_si: f64,
    /// And after.
    pub rmse_after_si: f64,
}

impl MovementAlignmentRecord {
    /// In words.
    pub fn text(&self, unit: Unit) -> String {
        let shown = |v: f64| format::short(unit.from_si(v));
        let list = |values: &[f64], of: &dyn Fn(f64) -> String| -> String {
            values.iter().map(|v| of(*v)).collect::<Vec<_>>().join(", ")
        };
        let turned = match (self.kind, &self.rotation_axis) {
            (AlignmentKind::Origin, _) => String::new(),
            (_, Some(axis)) => {
                let axis = list(axis, &|v| format::fixed(v, 4));
                format!("turned by {}° about ({axis}) and ", format::fixed(self.rotation_deg, 3))
            }
            (_, None) => format!("turned by {}° and ", format::fixed(self.rotation_deg, 3)),
        };
        let name = match self.kind {
            AlignmentKind::Origin => "aligned at the first points",
            AlignmentKind::Rigid => "rigidly aligned",
        };
        let shift = match self.translation_si.as_slice() {
            [one] => shown(*one),
            many => format!("({})", list(many, &shown)),
        };
        format!(
            "after the prediction was {name} to the measurement ({turned}shifted by {}; RMSE {} before, {} after), which makes errors \
             smaller than they are",
            format::with_unit(&shift, unit),
            format::quantity(self.rmse_before_si, unit, format::error_decimals(unit)),
            format::quantity(self.rmse_after_si, unit, format::error_decimals(unit)),
        )
    }
}
