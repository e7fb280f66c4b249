//! Every point of every comparison, component by component: a table for spreadsheets, pandas and DuckDB.
//!
//! Values are in SI units, `unit` is the one that pages show; `residual_si` is predicted - measured of the component, `distance_si` that
//! of a position, and `residual_lower_si` and `residual_upper_si` bound the one that its points are judged by.

use pneuval_ingest::store::{Columns, Series};

use crate::AnalysisError;
use crate::format::visible;
use crate::results::{Comparison, Point, Results};

/// A cell.
enum Cell {
    Text(String),
    Number(Option<f64>),
}

const NAMES: [&str; 26] = [
    "comparison",
    "actuator",
    "dataset",
    "quantity",
    "component",
    "form",
    "verdict",
    "unit",
    "status",
    "reason",
    "line",
    "runs",
    "repeats",
    "branch",
    "pressures_gauge_pa",
    "pressure_share",
    "at",
    "conditions_si",
    "measured_si",
    "measured_half_width_si",
    "predicted_si",
    "predicted_half_width_si",
    "residual_si",
    "distance_si",
    "residual_lower_si",
    "residual_upper_si",
];

/// The table as columns.
pub fn points(results: &Results) -> Columns {
    let rows: Vec<[Cell; NAMES.len()]> = rows(results).collect();
    let column = |k: usize| match rows.first().map(|row| &row[k]) {
        Some(Cell::Number(_)) => Series::Number(
            rows.iter().map(|row| if let Cell::Number(number) = &row[k] { *number } else { None }).collect(),
        ),
        _ => Series::Text(
            rows.iter().map(|row| if let Cell::Text(text) = &row[k] { text.clone() } else { String::new() }).collect(),
        ),
    };
    NAMES.iter().enumerate().map(|(k, name)| ((*name).to_owned(), column(k))).collect()
}

/// The table as CSV: one line of names, then the rows; nothing where there is no number.
///
/// # Errors
/// [`AnalysisError::Results`] if it cannot be written, which writing to memory rules out.
pub fn points_csv(results: &Results) -> Result<Vec<u8>, AnalysisError> {
    let failed = |error: String| AnalysisError::Results {
        path: "points.csv".into(),
        problem: error,
        next: "report this as a bug".to_owned(),
    };
    let mut writer = csv::Writer::from_writer(vec![]);
    writer.write_record(NAMES).map_err(|error| failed(error.to_string()))?;
    for row in rows(results) {
        let texts = row.map(|cell| match cell {
            Cell::Text(text) => text,
            Cell::Number(number) => number.map_or(String::new(), |number| number.to_string()),
        });
        writer.write_record(&texts).map_err(|error| failed(error.to_string()))?;
    }
    writer.into_inner().map_err(|error| failed(error.to_string()))
}

fn rows(results: &Results) -> impl Iterator<Item = [Cell; NAMES.len()]> {
    results.comparisons.iter().flat_map(|c| {
        let width = c.quantity.components.len().max(1);
        c.points.iter().flat_map(move |point| (0..width).map(move |k| row(c, point, k)))
    })
}

fn row(c: &Comparison, point: &Point, k: usize) -> [Cell; NAMES.len()] {
    let text = |text: &str| Cell::Text(visible(text));
    let of = |values: &Option<Vec<f64>>| values.as_ref().and_then(|values| values.get(k)).copied();
    let is_position = !c.quantity.components.is_empty();
    let (measured, predicted) = (of(&point.measured), of(&point.predicted));
    let named = |names: &mut dyn Iterator<Item = &str>, values: &[f64]| {
        let pairs: Vec<String> = names.zip(values).map(|(name, value)| format!("{name}={value}")).collect();
        pairs.join(";")
    };
    let pressures = named(&mut c.chambers.iter().map(String::as_str), &point.pressures_gauge_pa);
    let conditions = named(&mut c.conditions.iter().map(|c| c.id.as_str()), &point.conditions_si);
    [
        text(&c.id),
        text(&c.actuator),
        text(&c.dataset),
        text(&c.quantity.id),
        text(c.quantity.components.get(k).map_or("", String::as_str)),
        text(&c.form),
        text(c.verdict.name()),
        text(&c.quantity.display_unit),
        text(point.status.id()),
        text(point.reason.as_deref().unwrap_or_default()),
        Cell::Number(Some(point.line as f64)),
        text(&point.runs.join(";")),
        Cell::Number(Some(point.repeats as f64)),
        text(point.branch.map_or("", crate::response::Branch::name)),
        text(&pressures),
        Cell::Number(Some(point.pressure_share)),
        Cell::Number(point.at),
        text(&conditions),
        Cell::Number(measured),
        Cell::Number(of(&point.measured_half_width)),
        Cell::Number(predicted),
        Cell::Number(point.predicted_half_width.get(k).copied().filter(|_| predicted.is_some())),
        Cell::Number(if is_position { measured.zip(predicted).map(|(m, p)| p - m) } else { point.residual }),
        Cell::Number(point.residual.filter(|_| is_position)),
        Cell::Number(point.residual_lower),
        Cell::Number(point.residual_upper),
    ]
}
