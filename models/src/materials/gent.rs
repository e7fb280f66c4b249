//! The Gent law, whose chains have a finite length.

use super::load_case::Slopes;
use super::{InInvariants, check_positive};
use crate::ModelError;

/// The Gent law of an incompressible rubber: the stress grows without limit as `I1 - 3` comes near Jm.
///
/// ```text
/// W = -mu Jm/2 ln(1 - (I1 - 3)/Jm)        W1 = dW/dI1 = mu/2 · Jm / (Jm - (I1 - 3))
/// nominal stress: uniaxial 2 (l - l^-2) W1    planar 2 (l - l^-3) W1    equibiaxial 2 (l - l^-5) W1
/// ```
///
/// | symbol | argument | unit | domain | meaning |
/// |---|---|---|---|---|
/// | mu | `mu_pa` | Pa | > 0 | initial shear modulus |
/// | Jm | `jm` | 1 | > 0 | `I1 - 3` at which the chains are fully stretched; neo-Hooke as Jm -> infinity |
/// | l | `stretch` | 1 | > 0, `I1 - 3 < Jm` | length over undeformed length |
///
/// # Errors
/// A stretch with `I1 - 3 >= Jm` is [`ModelError::OutOfDomain`]: the law has no energy there.
/// # Source
/// Gent (1996), Rubber Chem. Technol. 69, 59-61, doi:10.5254/1.3538357; Eq. not yet checked.
/// # Check value
/// Uniaxial, l = 2, mu = 0.2 MPa, Jm = 4: `I1 - 3` = 2, W1 = 0.2 MPa, stress 2 (2 - 1/4) 0.2 = 0.7 MPa,
/// W = 0.4 ln 2 MPa.
/// ```
/// use pneuval_models::materials::{Gent, Hyperelastic, LoadCase};
/// let rubber = Gent::new(0.2e6, 4.0)?;
/// assert!((rubber.nominal_stress_pa(LoadCase::Uniaxial, 2.0)? - 0.7e6).abs() < 1e-9);
/// assert!((rubber.strain_energy_pa(LoadCase::Uniaxial, 2.0)? - 0.4e6 * 2_f64.ln()).abs() < 1e-9);
/// assert!(rubber.nominal_stress_pa(LoadCase::Equibiaxial, 2.0).is_err());
/// # Ok::<(), pneuval_models::ModelError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gent {
    mu_pa: f64,
    jm: f64,
}

impl Gent {
    /// A law from its constants.
    ///
    /// # Errors
    /// [`ModelError::OutOfDomain`] if a constant is not finite and positive.
    pub fn new(mu_pa: f64, jm: f64) -> Result<Self, ModelError> {
        Ok(Self {
            mu_pa: check_positive("mu", mu_pa, "finite and > 0 Pa")?,
            jm: check_positive("Jm", jm, "finite and > 0")?,
        })
    }

    /// `Jm - (I1 - 3)`, while anything is left of it.
    fn left(&self, i1_minus_3: f64) -> Result<f64, ModelError> {
        let left = self.jm - i1_minus_3;
        if left > 0.0 {
            Ok(left)
        } else {
            Err(ModelError::OutOfDomain {
                symbol: "(I1 - 3)/Jm",
                value: i1_minus_3 / self.jm,
                domain: "< 1: the Gent law locks where its chains are fully stretched",
            })
        }
    }
}

impl InInvariants for Gent {
    fn energy_pa(&self, i1_minus_3: f64, _: f64) -> Result<f64, ModelError> {
        self.left(i1_minus_3)?;
        Ok(-0.5 * self.mu_pa * (self.jm * (-i1_minus_3 / self.jm).ln_1p()))
    }

    fn slopes(&self, i1_minus_3: f64) -> Result<Slopes, ModelError> {
        let left = self.left(i1_minus_3)?;
        let w1_pa = 0.5 * self.mu_pa * (self.jm / left);
        Ok(Slopes { w1_pa, w2_pa: 0.0, w11_pa: w1_pa / left })
    }

    fn shear_modulus_pa(&self) -> f64 {
        self.mu_pa
    }
}
