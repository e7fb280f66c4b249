//! Levenberg-Marquardt on QR factors.

use nalgebra::{DMatrix, DVector};

use super::Problem;
use crate::ModelError;

/// Steps at most, those refused included.
const STEPS_MAX: usize = 2000;
/// The part of the residuals that a step could still take away, as a share of them: so small that it is rounding.
const OFFSET_SETTLED: f64 = 1e-11;
/// A relative change of every parameter that is rounding.
const STEP_SETTLED: f64 = 1e-15;
/// Above this offset a place from which no step leads down is no minimum: rounding stands in the way.
const OFFSET_STUCK: f64 = 1e-3;

/// Damping of the first step.
const DAMPING_START: f64 = 1e-4;
/// Residuals below this share of the model's size are rounding.
const EXACT_SHARE: f64 = 1e-13;

/// A minimum of the sum of squares.
#[derive(Debug, Clone, PartialEq)]
pub struct Minimum {
    /// The parameters there.
    pub parameters: Vec<f64>,
    /// The residuals there.
    pub residuals: DVector<f64>,
    /// Their derivatives there.
    pub jacobian: DMatrix<f64>,
    /// Accepted steps.
    pub iterations: usize,
}

impl Minimum {
    /// The sum of squared residuals.
    pub fn sum_of_squares(&self) -> f64 {
        self.residuals.norm_squared()
    }

    /// Root mean square of the residuals.
    pub fn rmse(&self) -> f64 {
        (self.sum_of_squares() / self.residuals.len() as f64).sqrt()
    }

    /// Residuals more than parameters.
    pub fn degrees_of_freedom(&self) -> usize {
        self.residuals.len() - self.parameters.len()
    }
}

/// A minimum of the sum of squared residuals, from a start.
///
/// Steps solve `min |J s + r|² + damping |D s|²` through the QR factors of J (D: the longest that each column has been, so that the
/// unit of a parameter does not matter). A trial at which the model has no value is refused like one that makes things worse. It has
/// settled where the residuals have no component left that a step could take away (relative offset, Bates and Watts 1981,
/// doi:10.1080/00401706.1981.10486267), or where steps are lost in the last digit of every parameter. The last steps are
/// undamped: of a linear problem they are its solution by QR.
///
/// # Errors
/// [`ModelError::TooFewResiduals`], [`ModelError::OutOfDomain`] for a start that is not finite, [`ModelError::NotConverged`] if it
/// did not settle, or where the sum of squares only falls towards the edge of the model's domain; whatever the model says at the
/// start.
pub fn minimise(problem: &dyn Problem, start: &[f64]) -> Result<Minimum, ModelError> {
    if let Some(&value) = start.iter().find(|v| !v.is_finite()) {
        return Err(ModelError::OutOfDomain { symbol: "start value", value, domain: "finite" });
    }
    let mut state = State::at(problem, start.to_vec())?;
    if state.residuals.len() < start.len() {
        return Err(ModelError::TooFewResiduals { residuals: state.residuals.len(), parameters: start.len() });
    }
    let mut scale = DVector::from_iterator(start.len(), state.jacobian.column_iter().map(|c| nonzero(c.norm())));
    let (mut damping, mut growth) = (DAMPING_START, 2.0);
    let (mut iterations, mut settled, mut computed) = (0, false, false);
    let mut factors = state.factors();
    for _ in 0..STEPS_MAX {
        let offset = factors.offset(&state.residuals);
        settled = offset <= OFFSET_SETTLED || state.cost == 0.0;
        if settled {
            break;
        }
        let Some(step) = factors.step(damping, &scale) else { break };
        let relative = |(s, x): (&f64, &f64)| s.abs() <= STEP_SETTLED * x.abs().max(f64::MIN_POSITIVE);
        // Of every parameter, or of what the model says.
        let is_lost =
            step.iter().zip(&state.parameters).all(relative) || factors.length(&step) <= STEP_SETTLED * state.size();
        if is_lost {
            // Steps may be short because they are damped, or because there is nowhere to go.
            let undamped = computed || iterations > 0 || damping <= DAMPING_START;
            settled = undamped && (offset <= OFFSET_STUCK || state.is_exact());
            break;
        }
        let predicted = factors.predicted_gain(&step, damping, &scale);
        match State::at(problem, state.moved(&step)).ok().filter(State::is_finite) {
            Some(trial) if trial.cost < state.cost => {
                let ratio = (state.cost - trial.cost) / predicted.max(f64::MIN_POSITIVE);
                // Nielsen 1999, "Damping parameter in Marquardt's method", Eq. 2.21.
                damping = (damping * (1.0 - (2.0 * ratio - 1.0).powi(3)).clamp(1.0 / 10.0, 2.0)).max(1e-16);
                (growth, computed) = (2.0, false);
                state = trial;
                iterations += 1;
                for (longest, column) in scale.iter_mut().zip(state.jacobian.column_iter()) {
                    *longest = longest.max(column.norm());
                }
                factors = state.factors();
            }
            trial => {
                computed |= trial.is_some();
                damping *= growth;
                growth *= 2.0;
                if damping > 1e30 {
                    settled = computed && (offset <= OFFSET_STUCK || state.is_exact());
                    break;
                }
            }
        }
    }
    if !settled {
        return Err(ModelError::NotConverged { method: "Levenberg-Marquardt", iterations: STEPS_MAX });
    }
    polish(problem, &mut state);
    Ok(Minimum { parameters: state.parameters, residuals: state.residuals, jacobian: state.jacobian, iterations })
}

/// Undamped steps, as long as they become shorter: rounding in the sum of squares hides a minimum long before it hides its place.
fn polish(problem: &dyn Problem, state: &mut State) {
    const STEPS: usize = 30;
    let mut before = f64::INFINITY;
    for _ in 0..STEPS {
        let factors = state.factors();
        let Some(step) = factors.step(0.0, &DVector::zeros(state.parameters.len())) else { return };
        // In the length of what the step does to the model, which has no unit of a parameter in it.
        let length = factors.length(&step);
        let Some(trial) = State::at(problem, state.moved(&step)).ok().filter(State::is_finite) else { return };
        // The sum may rise by rounding.
        if !(length < 0.9 * before && trial.cost <= state.cost * (1.0 + 1e-9)) {
            return;
        }
        before = length;
        *state = trial;
    }
}

/// A length that can be divided by.
fn nonzero(length: f64) -> f64 {
    if length > 0.0 && length.is_finite() { length } else { 1.0 }
}

/// Parameters with what the model says there.
struct State {
    parameters: Vec<f64>,
    residuals: DVector<f64>,
    jacobian: DMatrix<f64>,
    cost: f64,
}

impl State {
    fn at(problem: &dyn Problem, parameters: Vec<f64>) -> Result<Self, ModelError> {
        let residuals = problem.residuals(&parameters)?;
        let jacobian = problem.jacobian(&parameters)?;
        let cost = residuals.norm_squared();
        Ok(Self { parameters, residuals, jacobian, cost })
    }

    fn is_finite(&self) -> bool {
        self.cost.is_finite() && self.jacobian.iter().all(|v| v.is_finite())
    }

    /// Whether the residuals are what rounding leaves of the model's own size: there is nothing to take away.
    fn is_exact(&self) -> bool {
        self.residuals.norm() <= EXACT_SHARE * self.size()
    }

    /// How large what the model says is.
    fn size(&self) -> f64 {
        let columns = self.jacobian.column_iter().zip(&self.parameters);
        columns.map(|(column, value)| column.norm() * value.abs()).sum()
    }

    fn moved(&self, step: &DVector<f64>) -> Vec<f64> {
        self.parameters.iter().zip(step.iter()).map(|(x, s)| x + s).collect()
    }

    fn factors(&self) -> Factors {
        let qr = self.jacobian.clone().qr();
        let mut projected = self.residuals.clone();
        qr.q_tr_mul(&mut projected);
        let tangent = projected.rows(0, self.parameters.len()).into_owned();
        Factors { triangle: qr.r(), tangent }
    }
}

/// QR factors of a Jacobian: its triangle, and the residuals in the plane that its columns span.
struct Factors {
    triangle: DMatrix<f64>,
    tangent: DVector<f64>,
}

impl Factors {
    /// The part of the residuals in that plane, as a share of them.
    fn offset(&self, residuals: &DVector<f64>) -> f64 {
        let all = residuals.norm();
        if all == 0.0 { 0.0 } else { self.tangent.norm() / all }
    }

    /// The step of a damping; `None` if the columns do not determine it.
    fn step(&self, damping: f64, scale: &DVector<f64>) -> Option<DVector<f64>> {
        let n = self.tangent.len();
        let mut stacked = DMatrix::zeros(2 * n, n);
        stacked.view_mut((0, 0), (n, n)).copy_from(&self.triangle);
        for i in 0..n {
            stacked[(n + i, i)] = damping.sqrt() * scale[i];
        }
        let mut target = DVector::zeros(2 * n);
        target.rows_mut(0, n).copy_from(&-&self.tangent);
        let qr = stacked.qr();
        qr.q_tr_mul(&mut target);
        let step = qr.r().solve_upper_triangular(&target.rows(0, n).into_owned())?;
        step.iter().all(|s| s.is_finite()).then_some(step)
    }

    /// How far a step moves what the model says.
    fn length(&self, step: &DVector<f64>) -> f64 {
        (&self.triangle * step).norm()
    }

    /// How far the sum of squares falls along a step if the model were linear.
    fn predicted_gain(&self, step: &DVector<f64>, damping: f64, scale: &DVector<f64>) -> f64 {
        let along = (&self.triangle * step).norm_squared();
        let damped: f64 = step.iter().zip(scale.iter()).map(|(s, d)| (s * d).powi(2)).sum();
        along + 2.0 * damping * damped
    }
}
