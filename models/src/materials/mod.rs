//! Incompressible hyperelastic laws: energy and its slopes side by side, one law per file.
//!
//! | law | energy W | constants |
//! |---|---|---|
//! | [`NeoHooke`] | C10 (I1-3) | C10 |
//! | [`MooneyRivlin`] | c1 (I1-3) + c2 (I2-3) | c1, c2 |
//! | [`Yeoh`] | C10 (I1-3) + C20 (I1-3)² + C30 (I1-3)³ | C10, C20, C30 |
//! | [`Ogden`] | sum of `mu_p/alpha_p (l1^alpha_p + l2^alpha_p + l3^alpha_p - 3)` | mu1, alpha1, ... |
//! | [`Gent`] | -mu Jm/2 ln(1 - (I1-3)/Jm) | mu, Jm |
//!
//! A test holds every law to *stress = derivative of energy* in every [`LoadCase`], and to zero stress at stretch 1.
//! How a law is found by name and built from named constants is told in [`crate::catalogue`].

mod family;
pub mod gent;
mod load_case;
pub mod mooney_rivlin;
pub mod neo_hooke;
pub mod ogden;
mod stability;
pub mod yeoh;

pub use family::Family;
pub use gent::Gent;
pub use load_case::LoadCase;
pub use mooney_rivlin::MooneyRivlin;
pub use neo_hooke::NeoHooke;
pub use ogden::{Ogden, OgdenTerm};
pub use stability::{EndReason, StableEnd, StableRange};
pub use yeoh::Yeoh;

use crate::ModelError;
use load_case::{Slopes, excess, finite};

/// A hyperelastic law of an incompressible material, asked in a homogeneous [`LoadCase`].
///
/// The stretch is finite and > 0; some laws end earlier. What overflows is refused, so every answer is a finite number.
/// Nothing cancels near the undeformed state: the stress is exactly zero at stretch 1, and has all its digits at
/// 1 + 1e-9.
pub trait Hyperelastic: std::fmt::Debug + Send + Sync {
    /// Strain energy per undeformed volume, W in Pa.
    ///
    /// # Errors
    /// [`ModelError::OutOfDomain`] for a stretch outside the law's domain.
    fn strain_energy_pa(&self, case: LoadCase, stretch: f64) -> Result<f64, ModelError>;

    /// Nominal (engineering) stress, force per undeformed area, in Pa.
    ///
    /// # Errors
    /// [`ModelError::OutOfDomain`] for a stretch outside the law's domain.
    fn nominal_stress_pa(&self, case: LoadCase, stretch: f64) -> Result<f64, ModelError>;

    /// Slope of the nominal stress over stretch, in Pa: positive where the material is stable in this load case.
    ///
    /// # Errors
    /// [`ModelError::OutOfDomain`] for a stretch outside the law's domain.
    fn tangent_pa(&self, case: LoadCase, stretch: f64) -> Result<f64, ModelError>;

    /// Shear modulus at the undeformed state, in Pa: a third, a quarter and a sixth of the uniaxial, planar and
    /// equibiaxial tangent there. Positive for every law that can be built.
    fn shear_modulus_pa(&self) -> f64;

    /// The stretches round 1 over which the stress rises in a load case, scanned in steps of 0.1 % of the stretch: a
    /// dip narrower than that is not seen. Stable in one load case does not say stable in another.
    ///
    /// # Errors
    /// [`ModelError::OutOfDomain`] unless `0 < stretch_min <= 1 <= stretch_max`, both finite.
    fn stable_range(&self, case: LoadCase, stretch_min: f64, stretch_max: f64) -> Result<StableRange, ModelError> {
        stability::stable_range(&|stretch| self.tangent_pa(case, stretch), stretch_min, stretch_max)
    }

    /// The first stretch above 1 at which the stress stops rising, `None` if it rises up to `stretch_max`; scanned as
    /// in [`Hyperelastic::stable_range`].
    ///
    /// # Errors
    /// [`ModelError::OutOfDomain`] if `stretch_max` is not finite and >= 1, or the law ends, still stable, before it.
    fn unstable_from(&self, case: LoadCase, stretch_max: f64) -> Result<Option<f64>, ModelError> {
        let end = self.stable_range(case, 1.0, stretch_max)?.max;
        match end.why {
            EndReason::AsFarAsAsked => Ok(None),
            EndReason::Unstable => Ok(Some(end.stretch)),
            // Asked once more where it ends, the law says why.
            EndReason::OutOfDomain => self.tangent_pa(case, end.stretch).map(|_| None),
        }
    }
}

/// A law whose energy is a function of I1 plus a constant times I2: everything follows from the energy and its slopes.
trait InInvariants: std::fmt::Debug + Send + Sync {
    /// W in Pa.
    fn energy_pa(&self, i1_minus_3: f64, i2_minus_3: f64) -> Result<f64, ModelError>;

    /// Its slopes.
    fn slopes(&self, i1_minus_3: f64) -> Result<Slopes, ModelError>;

    /// `2 (W1 + W2)` at rest.
    fn shear_modulus_pa(&self) -> f64;
}

impl<Law: InInvariants> Hyperelastic for Law {
    fn strain_energy_pa(&self, case: LoadCase, stretch: f64) -> Result<f64, ModelError> {
        let excess = excess(stretch)?;
        finite(self.energy_pa(case.i1_minus_3(excess), case.i2_minus_3(excess))?, stretch)
    }

    fn nominal_stress_pa(&self, case: LoadCase, stretch: f64) -> Result<f64, ModelError> {
        let excess = excess(stretch)?;
        finite(case.nominal_stress_pa(excess, self.slopes(case.i1_minus_3(excess))?), stretch)
    }

    fn tangent_pa(&self, case: LoadCase, stretch: f64) -> Result<f64, ModelError> {
        let excess = excess(stretch)?;
        finite(case.tangent_pa(excess, self.slopes(case.i1_minus_3(excess))?), stretch)
    }

    fn shear_modulus_pa(&self) -> f64 {
        InInvariants::shear_modulus_pa(self)
    }
}

/// A constant that must be a number.
fn check_finite(symbol: &'static str, value: f64) -> Result<f64, ModelError> {
    if value.is_finite() { Ok(value) } else { Err(ModelError::OutOfDomain { symbol, value, domain: "finite" }) }
}

/// A constant that must be a positive number.
fn check_positive(symbol: &'static str, value: f64, domain: &'static str) -> Result<f64, ModelError> {
    if value.is_finite() && value > 0.0 { Ok(value) } else { Err(ModelError::OutOfDomain { symbol, value, domain }) }
}
