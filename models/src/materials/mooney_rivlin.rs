//! The Mooney-Rivlin law, an energy linear in both invariants.

use super::load_case::Slopes;
use super::{InInvariants, check_finite, check_positive};
use crate::ModelError;

/// The Mooney-Rivlin law of an incompressible rubber.
///
/// ```text
/// W = c1 (I1 - 3) + c2 (I2 - 3)        shear modulus 2 (c1 + c2)
/// nominal stress: uniaxial    2 (l - l^-2)(c1 + c2/l)
///                 planar      2 (l - l^-3)(c1 + c2)
///                 equibiaxial 2 (l - l^-5)(c1 + l² c2)
/// ```
///
/// | symbol | argument | unit | domain | meaning |
/// |---|---|---|---|---|
/// | c1 | `c1_pa` | Pa | finite | weight of I1 |
/// | c2 | `c2_pa` | Pa | finite, c1 + c2 > 0 | weight of I2; a negative one softens in equibiaxial tension |
/// | l | `stretch` | 1 | > 0 | length over undeformed length |
///
/// A source that writes `W = mu1/2 (I1 - 3) + mu2/2 (I2 - 3)` gives `c1 = mu1/2`, `c2 = mu2/2`.
///
/// # Source
/// Mooney (1940), J. Appl. Phys. 11, 582-592, doi:10.1063/1.1712836; Rivlin (1948), Phil. Trans. R. Soc. A 241,
/// 379-397, doi:10.1098/rsta.1948.0024; Eq. not yet checked.
/// # Check value
/// Equibiaxial, l = 2, c1 = 0.1 MPa, c2 = 0.02 MPa: stress 2 (2 - 1/32)(0.1 + 4 × 0.02) = 0.70875 MPa.
/// ```
/// use pneuval_models::materials::{Hyperelastic, LoadCase, MooneyRivlin};
/// let rubber = MooneyRivlin::new(0.1e6, 0.02e6)?;
/// let stress = rubber.nominal_stress_pa(LoadCase::Equibiaxial, 2.0)?;
/// assert!((stress - 0.70875e6).abs() < 1e-9);
/// # Ok::<(), pneuval_models::ModelError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MooneyRivlin {
    c1_pa: f64,
    c2_pa: f64,
}

impl MooneyRivlin {
    /// A law from its constants.
    ///
    /// # Errors
    /// [`ModelError::OutOfDomain`] if a constant is not finite, or the shear modulus is not positive.
    pub fn new(c1_pa: f64, c2_pa: f64) -> Result<Self, ModelError> {
        let law = Self { c1_pa: check_finite("c1", c1_pa)?, c2_pa: check_finite("c2", c2_pa)? };
        check_positive("initial shear modulus", law.shear_modulus_pa(), "finite and > 0 Pa; it is 2 (c1 + c2)")?;
        Ok(law)
    }
}

impl InInvariants for MooneyRivlin {
    fn energy_pa(&self, i1_minus_3: f64, i2_minus_3: f64) -> Result<f64, ModelError> {
        Ok(self.c1_pa * i1_minus_3 + self.c2_pa * i2_minus_3)
    }

    fn slopes(&self, _: f64) -> Result<Slopes, ModelError> {
        Ok(Slopes { w1_pa: self.c1_pa, w2_pa: self.c2_pa, w11_pa: 0.0 })
    }

    fn shear_modulus_pa(&self) -> f64 {
        2.0 * (self.c1_pa + self.c2_pa)
    }
}
