//! A measured quantity against gauge pressure: where published tables (and, later, sessions) meet.

use pneuval_ingest::manifest::{PublishedTable, Quantity};
use pneuval_ingest::number::Printed;

/// A measured response.
#[derive(Debug, Clone, PartialEq)]
pub struct Response {
    /// What was measured.
    pub quantity: Quantity,
    /// Chambers, in the order of each point's pressures.
    pub chambers: Vec<String>,
    /// The points, in the order of the source.
    pub points: Vec<ResponsePoint>,
}

/// One point of a response.
#[derive(Debug, Clone, PartialEq)]
pub struct ResponsePoint {
    /// Line of the source.
    pub line: usize,
    /// Gauge pressure per chamber, in Pa.
    pub pressures_gauge_pa: Vec<f64>,
    /// The value with its rounding interval; `None` is a hole in print.
    pub measured: Option<Printed>,
}

impl ResponsePoint {
    /// Whether every chamber is at zero gauge pressure: the reference, excluded from metrics.
    pub fn is_zero_reference(&self) -> bool {
        self.pressures_gauge_pa.iter().all(|p| *p == 0.0)
    }
}

impl From<&PublishedTable> for Response {
    fn from(table: &PublishedTable) -> Self {
        let points = table
            .pressures_gauge_pa
            .iter()
            .zip(&table.measured)
            .zip(&table.lines)
            .map(|((pressures, measured), line)| ResponsePoint {
                line: *line,
                pressures_gauge_pa: pressures.clone(),
                measured: *measured,
            })
            .collect();
        Self { quantity: table.quantity.clone(), chambers: table.chambers.clone(), points }
    }
}
