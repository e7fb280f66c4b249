//! The neo-Hooke law, an energy linear in the first invariant.

use super::load_case::Slopes;
use super::{InInvariants, check_positive};
use crate::ModelError;

/// The neo-Hooke law of an incompressible rubber.
///
/// ```text
/// W = C10 (I1 - 3)        shear modulus mu = 2 C10
/// nominal stress: uniaxial 2 (l - l^-2) C10    planar 2 (l - l^-3) C10    equibiaxial 2 (l - l^-5) C10
/// ```
///
/// | symbol | argument | unit | domain | meaning |
/// |---|---|---|---|---|
/// | C10 | `c10_pa` | Pa | > 0 | half the shear modulus |
/// | l | `stretch` | 1 | > 0 | length over undeformed length |
///
/// The constant is C10, not mu: a source that writes `W = mu/2 (I1 - 3)` gives `C10 = mu/2`.
///
/// # Source
/// Rivlin (1948), Phil. Trans. R. Soc. A 240, 459-490, doi:10.1098/rsta.1948.0002; Eq. not yet checked.
/// # Check value
/// Uniaxial, l = 2, C10 = 0.1 MPa: stress 2 (2 - 1/4) 0.1 = 0.35 MPa.
/// ```
/// use pneuval_models::materials::{Hyperelastic, LoadCase, NeoHooke};
/// let rubber = NeoHooke::new(0.1e6)?;
/// let stress = rubber.nominal_stress_pa(LoadCase::Uniaxial, 2.0)?;
/// assert!((stress - 0.35e6).abs() < 1e-9);
/// # Ok::<(), pneuval_models::ModelError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NeoHooke {
    c10_pa: f64,
}

impl NeoHooke {
    /// A law from its constant.
    ///
    /// # Errors
    /// [`ModelError::OutOfDomain`] if C10 is not finite and positive.
    pub fn new(c10_pa: f64) -> Result<Self, ModelError> {
        Ok(Self { c10_pa: check_positive("C10", c10_pa, "finite and > 0 Pa")? })
    }
}

impl InInvariants for NeoHooke {
    fn energy_pa(&self, i1_minus_3: f64, _: f64) -> Result<f64, ModelError> {
        Ok(self.c10_pa * i1_minus_3)
    }

    fn slopes(&self, _: f64) -> Result<Slopes, ModelError> {
        Ok(Slopes { w1_pa: self.c10_pa, w2_pa: 0.0, w11_pa: 0.0 })
    }

    fn shear_modulus_pa(&self) -> f64 {
        2.0 * self.c10_pa
    }
}
