//! A model ready to be evaluated.

use crate::ModelError;
use crate::solve::{Branch, Curve};

/// A model form with its inputs: gauge pressures in, one quantity out.
pub enum Model {
    /// One chamber.
    Single(Branch),
    /// Parts in series, each with a chamber of its own: their quantities add (dual-chamber-finger, Eq. 25).
    Sum(Vec<Branch>),
}

impl Model {
    /// A single-chamber model from its curve.
    ///
    /// # Errors
    /// As [`Branch::trace`].
    pub fn single(curve: impl Curve + 'static) -> Result<Self, ModelError> {
        Ok(Self::Single(Branch::trace(Box::new(curve))?))
    }

    /// The branches, one per chamber.
    pub fn branches(&self) -> &[Branch] {
        match self {
            Self::Single(branch) => std::slice::from_ref(branch),
            Self::Sum(branches) => branches,
        }
    }

    /// The quantity at the given gauge pressures, one per chamber, in SI units.
    ///
    /// # Errors
    /// [`ModelError::ChamberCount`]; otherwise as [`Branch::quantity`].
    pub fn predict(&self, pressures_gauge_pa: &[f64]) -> Result<f64, ModelError> {
        let branches = self.branches();
        if pressures_gauge_pa.len() != branches.len() {
            return Err(ModelError::ChamberCount { expected: branches.len(), found: pressures_gauge_pa.len() });
        }
        branches.iter().zip(pressures_gauge_pa).map(|(branch, &pressure)| branch.quantity(pressure)).sum()
    }

    /// The gauge pressure at which a single-chamber model has a value.
    ///
    /// # Errors
    /// [`ModelError::NotInvertible`] for several chambers; otherwise as [`Branch::pressure_gauge_pa`].
    pub fn invert(&self, quantity: f64) -> Result<f64, ModelError> {
        match self {
            Self::Single(branch) => branch.pressure_gauge_pa(quantity),
            Self::Sum(branches) => Err(ModelError::NotInvertible { chambers: branches.len() }),
        }
    }
}
