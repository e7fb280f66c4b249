//! The Yeoh law, an energy in powers of the first invariant.

use super::load_case::Slopes;
use super::{InInvariants, LoadCase, check_finite, check_positive};
use crate::ModelError;

/// Yeoh's hyperelastic law for an incompressible rubber.
///
/// ```text
/// W = C10 (I1 - 3) + C20 (I1 - 3)² + C30 (I1 - 3)³      W1 = dW/dI1 = C10 + 2 C20 (I1 - 3) + 3 C30 (I1 - 3)²
/// nominal stress: uniaxial 2 (l - l^-2) W1    planar 2 (l - l^-3) W1    equibiaxial 2 (l - l^-5) W1
/// ```
///
/// | symbol | argument | unit | domain | meaning |
/// |---|---|---|---|---|
/// | C10 | `c10_pa` | Pa | > 0 | half the initial shear modulus |
/// | C20 | `c20_pa` | Pa | finite | stiffening at moderate stretch (negative softens) |
/// | C30 | `c30_pa` | Pa | finite | stiffening at large stretch; 0 for the papers' two-term form |
/// | l | `stretch` | 1 | > 0 | length over undeformed length |
///
/// # Source
/// Yeoh (1993), Rubber Chem. Technol. 66, 754-771, doi:10.5254/1.3538343; Eq. not yet checked. In the papers:
/// internal-support, section "Material Constitutive Modeling"; dual-chamber-finger, Eq. 1 to 6 and 14.
/// Misprint: dual-chamber-finger Eq. 5, last line, prints `(λ² - λ^-2)` where the line above it gives `(λ - 1/λ)`.
/// Test: `eq_5_last_line_is_not_the_energy_above_it`.
/// # Check value
/// Planar, l = 2, C10 = 0.11 MPa, C20 = 0.02 MPa: `I1 - 3` = 2.25, W1 = 0.2 MPa, stress 2 (2 - 1/8) 0.2 = 0.75 MPa.
/// ```
/// use pneuval_models::materials::{Hyperelastic, LoadCase, Yeoh};
/// let rubber = Yeoh::new(0.11e6, 0.02e6, 0.0)?;
/// let stress = rubber.nominal_stress_pa(LoadCase::Planar, 2.0)?;
/// assert!((stress - 0.75e6).abs() < 1e-9);
/// # Ok::<(), pneuval_models::ModelError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Yeoh {
    c10_pa: f64,
    c20_pa: f64,
    c30_pa: f64,
}

impl Yeoh {
    /// A law from its constants.
    ///
    /// # Errors
    /// [`ModelError::OutOfDomain`] if a constant is not finite or C10 is not positive.
    pub fn new(c10_pa: f64, c20_pa: f64, c30_pa: f64) -> Result<Self, ModelError> {
        check_positive("C10", c10_pa, "finite and > 0 Pa")?;
        check_finite("C20", c20_pa)?;
        check_finite("C30", c30_pa)?;
        Ok(Self { c10_pa, c20_pa, c30_pa })
    }

    /// Strain energy per undeformed volume, W in Pa, from `I1 - 3`.
    pub fn energy_pa(&self, i1_minus_3: f64) -> f64 {
        let i = i1_minus_3;
        i * (self.c10_pa + i * (self.c20_pa + i * self.c30_pa))
    }

    /// Slope of the energy, W1 = dW/dI1 in Pa, from `I1 - 3`.
    pub fn energy_slope_pa(&self, i1_minus_3: f64) -> f64 {
        let i = i1_minus_3;
        self.c10_pa + i * (2.0 * self.c20_pa + i * 3.0 * self.c30_pa)
    }

    /// Nominal stress at stretch `1 + excess`, in Pa, for a shape that knows `excess` better than the stretch.
    pub fn nominal_stress_at_excess_pa(&self, case: LoadCase, excess: f64) -> f64 {
        case.nominal_stress_pa(excess, self.slopes_at(case.i1_minus_3(excess)))
    }

    fn slopes_at(&self, i1_minus_3: f64) -> Slopes {
        Slopes {
            w1_pa: self.energy_slope_pa(i1_minus_3),
            w2_pa: 0.0,
            w11_pa: 2.0 * self.c20_pa + 6.0 * self.c30_pa * i1_minus_3,
        }
    }
}

impl InInvariants for Yeoh {
    fn energy_pa(&self, i1_minus_3: f64, _: f64) -> Result<f64, ModelError> {
        Ok(self.energy_pa(i1_minus_3))
    }

    fn slopes(&self, i1_minus_3: f64) -> Result<Slopes, ModelError> {
        Ok(self.slopes_at(i1_minus_3))
    }

    fn shear_modulus_pa(&self) -> f64 {
        2.0 * self.c10_pa
    }
}
