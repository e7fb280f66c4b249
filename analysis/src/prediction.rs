//! What a model or a printed column says at the pressures of a response.

use pneuval_ingest::document::Origin;
use pneuval_ingest::manifest::{Actuator, PredictedColumn, PublishedTable};
use pneuval_ingest::number::Printed;
use pneuval_models::ModelError;
use pneuval_models::catalogue::{Entry, Inputs, Model};

use crate::AnalysisError;
use crate::response::Response;

/// Points on which a model is drawn between zero and full pressure.
const CURVE_STEPS: u32 = 100;

/// A prediction at the points of a response.
#[derive(Debug, Clone, PartialEq)]
pub struct Prediction {
    /// Id of the form.
    pub form: String,
    /// Its name in legends and tables.
    pub title: String,
    /// `published`, `printed`, `consistent` or `reading`.
    pub kind: String,
    /// Paper and place.
    pub source: String,
    /// The equation, for computed forms.
    pub equation: Option<String>,
    /// What fails in print, or departs from it.
    pub misprints: Vec<String>,
    /// Inputs that nobody printed or measured: `assumed sheet_width`, `calibrated C10`.
    pub rests_on: Vec<String>,
    /// One per point of the response.
    pub at: Vec<Predicted>,
    /// The form between the points, for figures: share of full pressure, value in SI.
    pub curve: Vec<CurvePoint>,
}

/// A prediction at one point.
#[derive(Debug, Clone, PartialEq)]
pub enum Predicted {
    /// A value with what its print leaves open (nothing, for a computed one).
    Value(Printed),
    /// The model has no value here, and why.
    NoSolution(String),
    /// The solver gave up here, and why: nothing is known, so nothing is judged.
    Failed(String),
    /// A printed column has no number here.
    NotPrinted,
}

/// A point of a drawn curve.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CurvePoint {
    /// Share of the full pressure of every chamber, 0 to 1.
    pub share: f64,
    /// The quantity, SI units.
    pub value: f64,
}

impl Prediction {
    /// A column printed beside the measured one.
    pub fn published(table: &PublishedTable, column: &PredictedColumn) -> Self {
        let at = column.cells.iter().map(|cell| cell.map_or(Predicted::NotPrinted, Predicted::Value)).collect();
        let full = full_pressures(&table.pressures_gauge_pa);
        let curve = table
            .pressures_gauge_pa
            .iter()
            .zip(&column.cells)
            .filter_map(|(pressures, cell)| {
                cell.filter(|c| c.si.is_finite()).map(|c| CurvePoint { share: share(pressures, &full), value: c.si })
            })
            .collect();
        Self {
            form: column.form.clone(),
            title: column.title.clone(),
            kind: "published".to_owned(),
            source: table.place.clone(),
            equation: None,
            misprints: vec![],
            rests_on: vec![],
            at,
            curve,
        }
    }

    /// A catalogue form evaluated at the points of a response.
    pub fn computed(form: &str, entry: &Entry, model: &Model, rests_on: Vec<String>, response: &Response) -> Self {
        let pressures: Vec<Vec<f64>> = response.points.iter().map(|p| p.pressures_gauge_pa.clone()).collect();
        let full = full_pressures(&pressures);
        let curve = (0..=CURVE_STEPS)
            .filter_map(|i| {
                // Denser near zero, where bending rises like the square root of pressure.
                let share = (f64::from(i) / f64::from(CURVE_STEPS)).powi(2);
                let pressures: Vec<f64> = full.iter().map(|p| share * p).collect();
                model.predict(&pressures).ok().map(|value| CurvePoint { share, value })
            })
            .collect();
        Self {
            form: form.to_owned(),
            title: entry.title.to_owned(),
            kind: entry.kind.name().to_owned(),
            source: entry.source.to_owned(),
            equation: Some(entry.equation.to_owned()),
            misprints: entry.misprints.iter().map(|m| (*m).to_owned()).collect(),
            rests_on,
            at: pressures.iter().map(|p| predict_at(model, p)).collect(),
            curve,
        }
    }
}

fn predict_at(model: &Model, pressures_gauge_pa: &[f64]) -> Predicted {
    match model.predict(pressures_gauge_pa) {
        Ok(si) => Predicted::Value(Printed { si, half_width_si: 0.0 }),
        // The physics has an answer here, and it is "none"; anything else is a failure of the computation.
        Err(
            error @ (ModelError::BeyondLimit { .. } | ModelError::BelowStart { .. } | ModelError::OutOfDomain { .. }),
        ) => Predicted::NoSolution(error.to_string()),
        Err(error) => Predicted::Failed(error.to_string()),
    }
}

/// The largest pressure of each chamber in size: a vacuum is a pressure too.
pub fn full_pressures(pressures_gauge_pa: &[Vec<f64>]) -> Vec<f64> {
    let chambers = pressures_gauge_pa.first().map_or(0, Vec::len);
    (0..chambers).map(|c| pressures_gauge_pa.iter().map(|p| p[c].abs()).fold(0.0, f64::max)).collect()
}

/// Share of full pressure, -1 to 1: the mean over chambers that have one.
pub fn share(pressures_gauge_pa: &[f64], full: &[f64]) -> f64 {
    let shares: Vec<f64> = pressures_gauge_pa.iter().zip(full).filter(|(_, f)| **f > 0.0).map(|(p, f)| p / f).collect();
    if shares.is_empty() { 0.0 } else { shares.iter().sum::<f64>() / shares.len() as f64 }
}

/// The inputs of a catalogue form from an actuator file, and which of them nobody printed or measured.
///
/// # Errors
/// [`AnalysisError::Input`] for a value that is missing or measures something else.
pub fn inputs(entry: &Entry, actuator: &Actuator) -> Result<(Inputs, Vec<String>), AnalysisError> {
    let mut inputs = Inputs::default();
    let mut rests_on = Vec::new();
    for parameter in entry.parameters {
        let error = |file: String, found: String| AnalysisError::Input {
            file,
            name: parameter.name.to_owned(),
            expected: format!("{}, in a unit of {}", parameter.meaning, parameter.si_unit),
            found,
        };
        let file = || actuator.file.clone();
        let value = actuator.values.get(parameter.name).ok_or_else(|| error(file(), "nothing".to_owned()))?;
        if value.unit.dimension.si_symbol() != parameter.si_unit {
            return Err(error(format!("{}:{}", file(), value.line), format!("unit `{}`", value.unit.symbol)));
        }
        if matches!(value.origin, Origin::Assumed | Origin::Calibrated) {
            rests_on.push(format!("{} {}", value.origin.name(), parameter.name));
        }
        inputs.set(parameter.name, value.si);
    }
    Ok((inputs, rests_on))
}

/// The model of a catalogue form, an actuator and perhaps changed inputs.
///
/// # Errors
/// [`AnalysisError::Model`] if the form refuses its inputs.
pub fn build(entry: &Entry, inputs: &Inputs, actuator: &Actuator) -> Result<Model, AnalysisError> {
    entry.build(inputs).map_err(|source| AnalysisError::Model {
        file: actuator.file.clone(),
        quantity: entry.quantity.to_owned(),
        form: entry.form.to_owned(),
        source,
    })
}
