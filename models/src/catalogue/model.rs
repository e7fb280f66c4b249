//! A model ready to be evaluated.

use crate::ModelError;
use crate::solve::{Branch, Curve};

/// A model form with its inputs: gauge pressures in, one quantity out, perhaps of several components.
pub enum Model {
    /// One chamber.
    Single(Branch),
    /// Parts in series, each with a chamber of its own: their quantities add (dual-chamber-finger, Eq. 25).
    Sum(Vec<Branch>),
    /// A closed form.
    Explicit(Explicit),
}

/// What a closed form computes: gauge pressures in Pa, one per chamber, to one value per component in SI units.
type Formula = dyn Fn(&[f64]) -> Result<Vec<f64>, ModelError> + Send + Sync;

/// A form that is evaluated directly, without solving for a state.
pub struct Explicit {
    chambers: usize,
    formula: Box<Formula>,
}

impl Explicit {
    /// A closed form of several chamber pressures. The formula is given exactly that many, every one finite.
    pub fn new(
        chambers: usize,
        formula: impl Fn(&[f64]) -> Result<Vec<f64>, ModelError> + Send + Sync + 'static,
    ) -> Self {
        Self { chambers, formula: Box::new(formula) }
    }

    /// A closed form of one chamber pressure.
    pub fn one(formula: impl Fn(f64) -> Result<Vec<f64>, ModelError> + Send + Sync + 'static) -> Self {
        Self::new(1, move |pressures_gauge_pa| match pressures_gauge_pa {
            [pressure] => formula(*pressure),
            _ => Err(ModelError::ChamberCount { expected: 1, found: pressures_gauge_pa.len() }),
        })
    }

    /// One value per component.
    ///
    /// # Errors
    /// Whatever the formula says.
    fn values(&self, pressures_gauge_pa: &[f64]) -> Result<Vec<f64>, ModelError> {
        (self.formula)(pressures_gauge_pa)
    }
}

impl Model {
    /// A single-chamber model from its curve.
    ///
    /// # Errors
    /// As [`Branch::trace`].
    pub fn single(curve: impl Curve + 'static) -> Result<Self, ModelError> {
        Ok(Self::Single(Branch::trace(Box::new(curve))?))
    }

    /// A single-chamber model from a closed form.
    pub fn explicit(formula: impl Fn(f64) -> Result<Vec<f64>, ModelError> + Send + Sync + 'static) -> Self {
        Self::Explicit(Explicit::one(formula))
    }

    /// The branches, one per chamber; none for a closed form.
    pub fn branches(&self) -> &[Branch] {
        match self {
            Self::Single(branch) => std::slice::from_ref(branch),
            Self::Sum(branches) => branches,
            Self::Explicit(_) => &[],
        }
    }

    /// How many chamber pressures the model takes.
    pub fn chambers(&self) -> usize {
        match self {
            Self::Single(_) => 1,
            Self::Sum(branches) => branches.len(),
            Self::Explicit(explicit) => explicit.chambers,
        }
    }

    /// The quantity at the given gauge pressures, one per chamber, in SI units: one value per component, a scalar has one.
    ///
    /// # Errors
    /// [`ModelError::ChamberCount`]; [`ModelError::OutOfDomain`] for a pressure that is not finite; [`ModelError::NotFinite`] for a
    /// result that is not; otherwise as [`Branch::quantity`] and as the closed form says.
    pub fn predict(&self, pressures_gauge_pa: &[f64]) -> Result<Vec<f64>, ModelError> {
        let (expected, found) = (self.chambers(), pressures_gauge_pa.len());
        if expected != found {
            return Err(ModelError::ChamberCount { expected, found });
        }
        if let Some(&value) = pressures_gauge_pa.iter().find(|p| !p.is_finite()) {
            return Err(ModelError::OutOfDomain { symbol: "gauge pressure", value, domain: "finite" });
        }
        let values = match self {
            Self::Explicit(explicit) => explicit.values(pressures_gauge_pa)?,
            Self::Single(_) | Self::Sum(_) => {
                let parts = self.branches().iter().zip(pressures_gauge_pa);
                vec![parts.map(|(branch, &pressure)| branch.quantity(pressure)).sum::<Result<f64, ModelError>>()?]
            }
        };
        match values.iter().position(|v| !v.is_finite()) {
            Some(component) => Err(ModelError::NotFinite { component, value: values[component] }),
            None => Ok(values),
        }
    }

    /// The same for a quantity of one component.
    ///
    /// # Errors
    /// [`ModelError::NotScalar`] for a quantity of several; otherwise as [`Model::predict`].
    pub fn predict_scalar(&self, pressures_gauge_pa: &[f64]) -> Result<f64, ModelError> {
        match self.predict(pressures_gauge_pa)?[..] {
            [value] => Ok(value),
            ref values => Err(ModelError::NotScalar { components: values.len() }),
        }
    }

    /// The gauge pressure at which a single-chamber curve has a value.
    ///
    /// # Errors
    /// [`ModelError::NotInvertible`] for several chambers and for closed forms; otherwise as [`Branch::pressure_gauge_pa`].
    pub fn invert(&self, quantity: f64) -> Result<f64, ModelError> {
        match self {
            Self::Single(branch) => branch.pressure_gauge_pa(quantity),
            Self::Sum(_) => Err(ModelError::NotInvertible { why: "it depends on several pressures" }),
            Self::Explicit(_) => {
                Err(ModelError::NotInvertible { why: "the form is evaluated from pressure to quantity only" })
            }
        }
    }
}
