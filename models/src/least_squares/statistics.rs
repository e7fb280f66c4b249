//! How well residuals determine parameters.

use nalgebra::{DMatrix, DVector};

use super::Minimum;
use crate::ModelError;

/// What the linear theory says at a minimum.
#[derive(Debug, Clone, PartialEq)]
pub struct Statistics {
    /// Residual variance, `sum of squares / (n - p)`; `None` without degrees of freedom.
    pub variance: Option<f64>,
    /// Standard error of each parameter; `None` without degrees of freedom.
    pub std: Option<Vec<f64>>,
    /// Correlation of each pair of parameters.
    pub correlations: DMatrix<f64>,
    /// Condition number of the Jacobian with columns of one length.
    pub condition_number: f64,
    /// The relative change of the parameters, of length 1, that the residuals feel least, and by how much they would change it
    /// (one standard deviation), `None` without degrees of freedom.
    pub weakest: (Vec<f64>, Option<f64>),
}

impl Minimum {
    /// Standard errors `s sqrt(diag((J'J)^-1))`, correlations and the weakest direction, from the singular values of the Jacobian
    /// with columns of one length: the units of the parameters do not matter.
    ///
    /// # Errors
    /// [`ModelError::Undetermined`] if a parameter has no influence, or two do the same, to the digits of a double.
    pub fn statistics(&self) -> Result<Statistics, ModelError> {
        let p = self.parameters.len();
        let lengths: Vec<f64> = self.jacobian.column_iter().map(|column| column.norm()).collect();
        if lengths.iter().any(|length| !(*length > 0.0 && length.is_finite())) {
            return Err(ModelError::Undetermined { condition_number: f64::INFINITY });
        }
        let mut unit = self.jacobian.clone();
        for (mut column, length) in unit.column_iter_mut().zip(&lengths) {
            column /= *length;
        }
        let svd = unit.qr().r().svd(false, true);
        let (largest, smallest) = (svd.singular_values.max(), svd.singular_values.min());
        let condition_number = largest / smallest;
        let Some(v_t) = svd.v_t.filter(|_| condition_number < 1.0 / f64::EPSILON) else {
            return Err(ModelError::Undetermined { condition_number });
        };
        // (J'J)^-1 = V S^-2 V', in the scale of the columns.
        let mut root = v_t.transpose();
        for (mut column, s) in root.column_iter_mut().zip(svd.singular_values.iter()) {
            column /= *s;
        }
        let inverse = &root * root.transpose();
        let diagonal: Vec<f64> = (0..p).map(|i| inverse[(i, i)].sqrt()).collect();
        let correlations = DMatrix::from_fn(p, p, |i, j| {
            if i == j { 1.0 } else { (inverse[(i, j)] / (diagonal[i] * diagonal[j])).clamp(-1.0, 1.0) }
        });
        let freedom = self.degrees_of_freedom();
        let variance = (freedom > 0).then(|| self.sum_of_squares() / freedom as f64);
        let std = variance.map(|v| diagonal.iter().zip(&lengths).map(|(d, l)| v.sqrt() * d / l).collect());
        Ok(Statistics { variance, std, correlations, condition_number, weakest: self.weakest(variance) })
    }

    /// The direction of relative changes that the residuals feel least.
    fn weakest(&self, variance: Option<f64>) -> (Vec<f64>, Option<f64>) {
        let mut relative = self.jacobian.clone();
        for (mut column, value) in relative.column_iter_mut().zip(&self.parameters) {
            // Of a parameter at zero no relative change exists.
            column *= if *value == 0.0 { 1.0 } else { value.abs() };
        }
        let svd = relative.qr().r().svd(false, true);
        let (at, smallest) = svd
            .singular_values
            .iter()
            .copied()
            .enumerate()
            .fold((0, f64::INFINITY), |best, here| if here.1 < best.1 { here } else { best });
        let mut direction = svd.v_t.map_or(DVector::zeros(self.parameters.len()), |v| v.row(at).transpose());
        // A direction has no sign: the first component that counts is positive.
        if direction.iter().find(|d| d.abs() > 0.1).is_some_and(|d| *d < 0.0) {
            direction = -direction;
        }
        (direction.iter().copied().collect(), variance.map(|v| v.sqrt() / smallest))
    }
}
