//! Any formula fitted to any table: `b1*(1 - exp(-b2*x))`.

use nalgebra::{DMatrix, DVector};
use serde::Serialize;
use thiserror::Error;

use pneuval_models::ModelError;
use pneuval_models::expression::{
    Expression, ParseError, Precise, Relation, RelationKind, TwoFloat, Workspace, decimal,
};
use pneuval_models::least_squares::{Problem, minimise, search};

use super::estimate::{Estimates, estimates, search_record};

/// Residuals below this share of the measured values are counted with twice the digits.
const ROUNDING_SHARE: f64 = 1e-9;

/// A formula, the table it is fitted to, and where to start.
#[derive(Debug, Clone, PartialEq)]
pub struct Task {
    /// What is measured, as a formula of columns: mostly the name of one.
    pub response: Expression,
    /// What predicts it, in columns and parameters.
    pub formula: Expression,
    /// Columns by name.
    pub columns: Vec<(String, Vec<f64>)>,
    /// Standard uncertainties of the measured values, if they differ: weights are their inverse squares.
    pub std: Option<Vec<f64>>,
    /// Parameters and their start values.
    pub start: Vec<(String, f64)>,
    /// Starts to try, the given one included.
    pub starts: usize,
    /// Confidence of the intervals.
    pub confidence: f64,
}

/// A fitted formula.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Fitted {
    /// The formula.
    pub formula: String,
    /// What it was fitted to.
    pub response: String,
    /// Parameters in which it is linear.
    pub linear_in: Vec<String>,
    /// How residuals were weighted.
    pub weighting: String,
    /// Rows fitted.
    pub rows_used: usize,
    /// Rows of the table.
    pub rows_available: usize,
    /// Whether a minimum was reached that determines every parameter.
    pub converged: bool,
    /// What was found.
    pub estimates: Estimates,
}

/// Why a formula cannot be fitted.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum ExpressionError {
    /// The formula cannot be read.
    #[error(transparent)]
    Parse(#[from] ParseError),
    /// A name is neither a column nor a parameter.
    #[error(
        "formula `{formula}`: `{name}`\n  expected: a column ({columns}) or a parameter with a start value\n  found:    neither\n  next:     --start \"{name}=1\", or name the columns with --columns"
    )]
    Unknown {
        /// The formula.
        formula: String,
        /// The name.
        name: String,
        /// The columns there are.
        columns: String,
    },
    /// A start value belongs to nothing.
    #[error(
        "--start: `{name}`\n  expected: a parameter of the formula\n  found:    no such name in `{formula}`\n  next:     correct the name, or leave it out"
    )]
    Unused {
        /// The name.
        name: String,
        /// The formula.
        formula: String,
    },
    /// The response is no formula of columns.
    #[error(
        "response `{response}`\n  expected: a column, or a formula of columns, left of a single `=`\n  found:    {found}\n  next:     --response NAME, or write `NAME = formula`; columns: {columns}"
    )]
    Response {
        /// The response.
        response: String,
        /// What is wrong.
        found: String,
        /// The columns there are.
        columns: String,
    },
    /// No minimum was found from any start.
    #[error(
        "no minimum was found from any of {starts} starts: {source}\n  next:     start nearer, or fit fewer parameters"
    )]
    NoMinimum {
        /// How many starts there were.
        starts: usize,
        /// What the given start ended with.
        source: ModelError,
    },
}

/// `response = formula`, or a formula alone, whose response is then `default`.
///
/// # Errors
/// [`ExpressionError::Parse`], and [`ExpressionError::Response`] for another relation.
pub fn sides(text: &str, default: Option<&str>) -> Result<(Expression, Expression), ExpressionError> {
    if text.contains(['=', '<', '>']) {
        let relation = Relation::parse(text)?;
        if relation.kind != RelationKind::Equal {
            let found = format!("`{}`", relation.kind.symbol());
            return Err(ExpressionError::Response { response: text.to_owned(), found, columns: String::new() });
        }
        return Ok((relation.left, relation.right));
    }
    Ok((Expression::parse(default.unwrap_or("y"))?, Expression::parse(text)?))
}

/// Fits a formula.
///
/// Derivatives are exact; parameters in which the formula is linear are solved for from every start. Rows with a hole in a column that
/// is used are left out and counted.
///
/// # Errors
/// [`ExpressionError`].
pub fn fit(task: &Task) -> Result<Fitted, ExpressionError> {
    let mut problem = Formula::new(task)?;
    let names: Vec<String> = task.start.iter().map(|(name, _)| name.clone()).collect();
    let start: Vec<f64> = task.start.iter().map(|(_, value)| *value).collect();
    let linear = problem.linear();
    let mut found = search(&problem, &start, &linear, task.starts)
        .map_err(|source| ExpressionError::NoMinimum { starts: task.starts, source })?;
    let record = search_record(&found);
    // Residuals this small are mostly rounding: counted once more with twice the digits.
    let size = problem.measured.iter().zip(&problem.weights).map(|(y, w)| (y * w).powi(2)).sum::<f64>().sqrt();
    if found.best.sum_of_squares().sqrt() < ROUNDING_SHARE * size {
        problem.with_twice_the_digits();
        if let Ok(minimum) = minimise(&problem, &found.best.parameters) {
            found.best = minimum;
        }
    }
    let converged = found.best.statistics().is_ok();
    let estimates = estimates(&problem, &found.best, record, &names, task.confidence);
    Ok(Fitted {
        formula: task.formula.text().to_owned(),
        response: task.response.text().to_owned(),
        linear_in: linear.iter().map(|&i| names[i].clone()).collect(),
        weighting: match &task.std {
            Some(_) => "each residual over its standard uncertainty".to_owned(),
            None => "every residual alike".to_owned(),
        },
        rows_used: problem.measured.len(),
        rows_available: task.columns.first().map_or(0, |(_, values)| values.len()),
        converged,
        estimates,
    })
}

/// A formula at the rows of a table.
struct Formula<'a> {
    formula: &'a Expression,
    /// Per symbol of the formula: a parameter, or a column.
    slots: Vec<Slot>,
    parameters: usize,
    /// Per row used: the columns that the formula reads, in the order of [`Slot::Column`].
    rows: Vec<Vec<f64>>,
    measured: Vec<f64>,
    weights: Vec<f64>,
    /// Measured values and columns with twice the digits, if they are wanted.
    precise: Option<Vec<(TwoFloat, Vec<TwoFloat>)>>,
    response: &'a Expression,
    outputs: Vec<Vec<f64>>,
}

#[derive(Clone, Copy)]
enum Slot {
    Parameter(usize),
    Column(usize),
}

impl<'a> Formula<'a> {
    fn new(task: &'a Task) -> Result<Self, ExpressionError> {
        let columns = || task.columns.iter().map(|(name, _)| name.as_str()).collect::<Vec<_>>().join(", ");
        let column = |name: &str| task.columns.iter().position(|(known, _)| known == name);
        let mut slots = Vec::new();
        let mut read = Vec::new();
        for symbol in task.formula.symbols() {
            // A parameter by name is meant as one, even beside a column of that name.
            if let Some(i) = task.start.iter().position(|(name, _)| name == symbol) {
                slots.push(Slot::Parameter(i));
            } else if let Some(i) = column(symbol) {
                slots.push(Slot::Column(read.len()));
                read.push(i);
            } else {
                let formula = task.formula.text().to_owned();
                return Err(ExpressionError::Unknown { formula, name: symbol.clone(), columns: columns() });
            }
        }
        if let Some((name, _)) = task.start.iter().find(|(name, _)| !task.formula.symbols().contains(name)) {
            return Err(ExpressionError::Unused { name: name.clone(), formula: task.formula.text().to_owned() });
        }
        let mut of_response = Vec::new();
        for symbol in task.response.symbols() {
            let Some(i) = column(symbol) else {
                let found = format!("`{symbol}` is no column");
                let response = task.response.text().to_owned();
                return Err(ExpressionError::Response { response, found, columns: columns() });
            };
            of_response.push(i);
        }
        let count = task.columns.first().map_or(0, |(_, values)| values.len());
        let (mut rows, mut measured, mut weights) = (Vec::new(), Vec::new(), Vec::new());
        let mut used_outputs = Vec::new();
        for row in 0..count {
            let of = |which: &[usize]| which.iter().map(|&i| task.columns[i].1[row]).collect::<Vec<f64>>();
            let (inputs, outputs) = (of(&read), of(&of_response));
            let value = task.response.value(&outputs);
            let weight = task.std.as_ref().map_or(1.0, |std| 1.0 / std[row]);
            if inputs.iter().all(|v| v.is_finite()) && value.is_finite() && weight.is_finite() && weight > 0.0 {
                rows.push(inputs);
                measured.push(value);
                used_outputs.push(outputs);
                weights.push(weight);
            }
        }
        Ok(Self {
            formula: &task.formula,
            slots,
            parameters: task.start.len(),
            rows,
            measured,
            weights,
            precise: None,
            response: &task.response,
            outputs: used_outputs,
        })
    }

    /// From now on residuals are computed with twice the digits, from the decimals that were written.
    fn with_twice_the_digits(&mut self) {
        let wide = |values: &[f64]| values.iter().map(|value| decimal(*value)).collect::<Vec<_>>();
        let row = |(row, outputs): (&Vec<f64>, &Vec<f64>)| {
            let Ok(measured) = self.response.evaluate(&Precise, &wide(outputs));
            (measured, wide(row))
        };
        self.precise = Some(self.rows.iter().zip(&self.outputs).map(row).collect());
    }

    /// The residual of a row with twice the digits.
    fn precisely(&self, at: &[f64], measured: TwoFloat, row: &[TwoFloat]) -> f64 {
        let of = |slot: &Slot| match slot {
            Slot::Parameter(i) => TwoFloat::from(at[*i]),
            Slot::Column(i) => row[*i],
        };
        let symbols: Vec<TwoFloat> = self.slots.iter().map(of).collect();
        let Ok(predicted) = self.formula.evaluate(&Precise, &symbols);
        f64::from(predicted - measured)
    }

    fn linear(&self) -> Vec<usize> {
        let mut symbols: Vec<usize> = Vec::new();
        let mut linear = Vec::new();
        for parameter in 0..self.parameters {
            let is_it = |slot: &Slot| matches!(slot, Slot::Parameter(i) if *i == parameter);
            let Some(symbol) = self.slots.iter().position(is_it) else { continue };
            symbols.push(symbol);
            if self.formula.is_linear_in(&symbols) {
                linear.push(parameter);
            } else {
                symbols.pop();
            }
        }
        linear
    }

    /// What stands for the symbols at a row.
    fn fill(&self, at: &[f64], row: &[f64], symbols: &mut [f64]) {
        for (symbol, slot) in symbols.iter_mut().zip(&self.slots) {
            *symbol = match slot {
                Slot::Parameter(i) => at[*i],
                Slot::Column(i) => row[*i],
            };
        }
    }
}

impl Problem for Formula<'_> {
    fn parameters(&self) -> usize {
        self.parameters
    }

    fn residuals(&self, at: &[f64]) -> Result<DVector<f64>, ModelError> {
        let mut symbols = vec![0.0; self.slots.len()];
        let mut residuals = DVector::zeros(self.rows.len());
        for (i, row) in self.rows.iter().enumerate() {
            let residual = if let Some(precise) = &self.precise {
                self.precisely(at, precise[i].0, &precise[i].1)
            } else {
                self.fill(at, row, &mut symbols);
                self.formula.value(&symbols) - self.measured[i]
            };
            residuals[i] = self.weights[i] * residual;
        }
        if let Some(value) = residuals.iter().find(|r| !r.is_finite()) {
            return Err(ModelError::NotFinite { component: 0, value: *value });
        }
        Ok(residuals)
    }

    fn jacobian(&self, at: &[f64]) -> Result<DMatrix<f64>, ModelError> {
        let mut symbols = vec![0.0; self.slots.len()];
        let mut gradient = vec![0.0; self.slots.len()];
        let mut room = Workspace::default();
        let mut jacobian = DMatrix::zeros(self.rows.len(), self.parameters);
        for (i, row) in self.rows.iter().enumerate() {
            self.fill(at, row, &mut symbols);
            self.formula.gradient_into(&symbols, &mut room, &mut gradient);
            for (slot, slope) in self.slots.iter().zip(&gradient) {
                if let Slot::Parameter(k) = slot {
                    jacobian[(i, *k)] += self.weights[i] * slope;
                }
            }
        }
        Ok(jacobian)
    }
}
