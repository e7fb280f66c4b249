//! A measured quantity against gauge pressure: where published tables and raw sessions meet.

mod census;
mod drift;
mod hysteresis;
mod plateaus;
mod readings;
mod session;
mod stations;
mod way;

pub use census::{Census, Creep, TableCensus, Unmet, Unsure};
pub use drift::Drift;
pub use hysteresis::loop_weights;
pub(crate) use plateaus::GAP_STEPS;
pub(crate) use plateaus::rounding_s;
pub use session::{POINTS_MAX, without_rounding};
pub use way::Branch;

use pneuval_ingest::manifest::{Condition, PredictedColumn, PublishedTable, Quantity, TrajectoryRule};
use pneuval_ingest::number::Printed;

use crate::trajectory::Path;
use crate::verdict::Basis;

/// A measured response.
#[derive(Debug, Clone, PartialEq)]
pub struct Response {
    /// What was measured.
    pub quantity: Quantity,
    /// On what ground its intervals are known.
    pub basis: Basis,
    /// Where it comes from and how it was measured.
    pub source: String,
    /// Chambers, in the order of each point's pressures.
    pub chambers: Vec<String>,
    /// What is set beside the pressure, in the order of each point's conditions.
    pub conditions: Vec<Condition>,
    /// Gauge pressures so near zero are the zero-pressure reference, in Pa.
    pub zero_within_pa: f64,
    /// Gauge pressures so near each other are one nominal pressure, in Pa.
    pub same_within_pa: f64,
    /// Gauge pressures so near zero are what rounding leaves of a difference, and zero, in Pa.
    pub rounding_pa: f64,
    /// The points, in the order of the source.
    pub points: Vec<ResponsePoint>,
    /// States at which nothing was measured, though they were held: a hole is in every sample of what was read there.
    pub unmeasured: usize,
    /// The movements behind a comparison at equal time or arc length: its points are where a prediction meets them.
    pub movement: Option<Movement>,
    /// Predictions that stand beside the measurement in its source.
    pub columns: Vec<PredictedColumn>,
    /// Every cell of the source as printed, by column name, for sentences on the page; empty for a session.
    pub texts: Vec<(String, Vec<String>)>,
    /// What is repeated: runs, or the conditioned cycles of a sole run. Of the samples of a movement nothing is.
    pub repeats: Vec<String>,
    /// What instruments declare of their errors.
    pub instruments: Vec<InstrumentError>,
    /// How the readings move from cycle to cycle.
    pub drift: Option<Drift>,
}

/// The declared standard uncertainty of a channel: its error is the same at every point.
#[derive(Debug, Clone, PartialEq)]
pub struct InstrumentError {
    /// Whose error it is; channels that share it move together.
    pub source: String,
    /// What it moves.
    pub target: Target,
    /// Standard uncertainty in SI units.
    pub std_si: f64,
}

/// What an instrument reads of a response.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Target {
    /// A component of the measured quantity.
    Component(usize),
    /// The pressure of a chamber.
    Pressure(usize),
    /// A condition.
    Condition(usize),
}

/// Movements that are compared at equal time or arc length.
#[derive(Debug, Clone, PartialEq)]
pub struct Movement {
    /// How a prediction meets them.
    pub rule: TrajectoryRule,
    /// The instruments' standard uncertainty of each component; `None` where one declares none.
    pub std_si: Vec<Option<f64>>,
    /// One per run.
    pub paths: Vec<Path>,
}

/// One point of a response.
#[derive(Debug, Clone, PartialEq)]
pub struct ResponsePoint {
    /// Line of the source.
    pub line: usize,
    /// The runs it comes from; empty for a printed point.
    pub runs: Vec<String>,
    /// Gauge pressure per chamber, in Pa.
    pub pressures_gauge_pa: Vec<f64>,
    /// Of a movement: the time in s, or the share of the arc length.
    pub at: Option<f64>,
    /// Value of each condition, with what its print leaves open.
    pub conditions: Vec<Printed>,
    /// The value of each component with its interval; `None` is a hole in print.
    pub measured: Option<Vec<Printed>>,
    /// What the interval is.
    pub interval: IntervalKind,
    /// Which way the pressure went, in a session.
    pub branch: Option<Branch>,
    /// It belongs to a cycle that is shown and not compared: the first, beside conditioned ones.
    pub is_apart: bool,
    /// What each repeat behind it read.
    pub repeats: Vec<Repeat>,
}

/// What one repeat read at a point.
#[derive(Debug, Clone, PartialEq)]
pub struct Repeat {
    /// Which of the response's repeats.
    pub index: usize,
    /// Value of each component.
    pub measured: Vec<f64>,
    /// Gauge pressure per chamber, in Pa.
    pub pressures_gauge_pa: Vec<f64>,
    /// Value of each condition.
    pub conditions: Vec<f64>,
}

/// What the interval of a measured value is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum IntervalKind {
    /// Half a unit of the last printed digit.
    PrintedDigits,
    /// From the scatter of repeats and the instruments' uncertainty, 95 %.
    Repeats,
    /// From the instruments' uncertainty alone: one repeat.
    Instrument,
    /// Nothing is known: one repeat, and an instrument that declares nothing.
    Unknown,
}

impl Response {
    /// Whether every chamber of a point is at zero gauge pressure: the reference, excluded from metrics.
    pub fn is_zero_reference(&self, point: &ResponsePoint) -> bool {
        // A movement may begin at zero pressure, and is compared there too.
        point.at.is_none() && point.pressures_gauge_pa.iter().all(|p| p.abs() <= self.zero_within_pa)
    }

    /// The indices of all repeats, and where the values are that every one of them read: component by component, point by point. Not at
    /// zero pressure, where what is tared scatters less, and not in a cycle apart, which is another state of the specimen.
    pub fn read_by_all_repeats(&self) -> Option<(Vec<usize>, Vec<usize>)> {
        let width = self.quantity.width();
        let indices = |p: &ResponsePoint| -> Vec<usize> { p.repeats.iter().map(|r| r.index).collect() };
        let is_asked = |p: &ResponsePoint| !p.is_apart && !self.is_zero_reference(p) && p.measured.is_some();
        let asked = || self.points.iter().enumerate().filter(|(_, p)| is_asked(p));
        let all = asked().map(|(_, p)| indices(p)).max_by_key(Vec::len)?;
        let of_point = |i: usize| (0..width).map(move |c| i * width + c);
        let places = asked().filter(|(_, p)| indices(p) == all).flat_map(|(i, _)| of_point(i)).collect();
        Some((all, places))
    }

    /// Whether values at such places were read on the way down.
    pub fn read_on_the_way_down(&self, places: &[usize]) -> Vec<bool> {
        let width = self.quantity.width();
        places.iter().map(|at| self.points[at / width].branch == Some(Branch::Unloading)).collect()
    }

    /// The gauge pressures of every point.
    pub fn pressures(&self) -> Vec<Vec<f64>> {
        self.points.iter().map(|p| p.pressures_gauge_pa.clone()).collect()
    }

    /// The sets of conditions that occur, in the order of their first point; `None` if they are more than `limit`.
    pub fn condition_sets(&self, limit: usize) -> Option<Vec<Vec<f64>>> {
        let mut sets: Vec<Vec<f64>> = Vec::new();
        for point in &self.points {
            let set: Vec<f64> = point.conditions.iter().map(|c| c.si).collect();
            if !sets.contains(&set) {
                sets.push(set);
            }
            if sets.len() > limit {
                return None;
            }
        }
        Some(sets)
    }
}

impl From<&PublishedTable> for Response {
    fn from(table: &PublishedTable) -> Self {
        let points = (0..table.lines.len())
            .map(|row| ResponsePoint {
                line: table.lines[row],
                runs: vec![],
                pressures_gauge_pa: table.pressures_gauge_pa[row].clone(),
                at: None,
                conditions: table.conditions_si[row].clone(),
                measured: table.measured[row].clone(),
                interval: IntervalKind::PrintedDigits,
                branch: None,
                is_apart: false,
                repeats: vec![],
            })
            .collect();
        Self {
            quantity: table.quantity.clone(),
            basis: Basis::PublishedPoint,
            source: format!("{}; {}", table.place, table.method),
            chambers: table.chambers.clone(),
            conditions: table.conditions.clone(),
            // Print says zero, or it does not.
            unmeasured: 0,
            zero_within_pa: 0.0,
            same_within_pa: 0.0,
            rounding_pa: 0.0,
            points,
            movement: None,
            columns: table.predicted.clone(),
            texts: table.texts.clone(),
            repeats: vec![],
            instruments: vec![],
            drift: None,
        }
    }
}
