//! The Yeoh law, an energy in powers of the first invariant.

use super::LoadCase;
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
/// internal-support, section "Material Constitutive Modeling"; dual-chamber-finger, Eq. 1 to 6 and 14.
/// Misprint: dual-chamber-finger Eq. 5, last line, prints `(λ² - λ^-2)` where the line above it gives `(λ - 1/λ)`.
/// Test: `eq_5_last_line_is_not_the_energy_above_it`.
/// # Check value
/// Planar, l = 2, C10 = 0.11 MPa, C20 = 0.02 MPa: `I1 - 3` = 2.25, W1 = 0.2 MPa, stress 2 (2 - 1/8) 0.2 = 0.75 MPa.
/// ```
/// use pneuval_models::materials::{LoadCase, Yeoh};
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
        if !(c10_pa.is_finite() && c10_pa > 0.0) {
            return Err(ModelError::OutOfDomain { symbol: "C10", value: c10_pa, domain: "finite and > 0 Pa" });
        }
        for (symbol, value) in [("C20", c20_pa), ("C30", c30_pa)] {
            if !value.is_finite() {
                return Err(ModelError::OutOfDomain { symbol, value, domain: "finite" });
            }
        }
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

    /// d²W/dI1² in Pa, from `I1 - 3`.
    fn energy_curvature_pa(&self, i1_minus_3: f64) -> f64 {
        2.0 * self.c20_pa + 6.0 * self.c30_pa * i1_minus_3
    }

    /// Force per undeformed area, in Pa.
    ///
    /// # Errors
    /// [`ModelError::OutOfDomain`] if the stretch is not finite and positive.
    pub fn nominal_stress_pa(&self, case: LoadCase, stretch: f64) -> Result<f64, ModelError> {
        check_stretch(stretch)?;
        Ok(self.nominal_stress_at_excess_pa(case, stretch - 1.0))
    }

    /// The same at stretch `1 + excess`, without cancellation near the undeformed state.
    pub fn nominal_stress_at_excess_pa(&self, case: LoadCase, excess: f64) -> f64 {
        2.0 * case.stress_factor(excess) * self.energy_slope_pa(case.i1_minus_3(excess))
    }

    /// Slope of the nominal stress, in Pa: positive where the material is stable in this load case.
    ///
    /// # Errors
    /// [`ModelError::OutOfDomain`] if the stretch is not finite and positive.
    pub fn tangent_pa(&self, case: LoadCase, stretch: f64) -> Result<f64, ModelError> {
        check_stretch(stretch)?;
        let excess = stretch - 1.0;
        let i = case.i1_minus_3(excess);
        let factor = case.stress_factor(excess);
        let i_slope = 2.0 * case.loaded_edges() * factor;
        Ok(2.0 * case.stress_factor_slope(stretch) * self.energy_slope_pa(i)
            + 2.0 * factor * self.energy_curvature_pa(i) * i_slope)
    }

    /// The first stretch above 1 at which the stress stops rising in a load case, `None` if it rises up to `stretch_max`.
    ///
    /// Scanned in steps of 0.001: a dip narrower than that is not seen.
    ///
    /// # Errors
    /// [`ModelError::OutOfDomain`] if `stretch_max` is not finite and positive.
    pub fn unstable_from(&self, case: LoadCase, stretch_max: f64) -> Result<Option<f64>, ModelError> {
        check_stretch(stretch_max)?;
        let mut stretch = 1.0;
        while stretch <= stretch_max {
            if self.tangent_pa(case, stretch)? <= 0.0 {
                return Ok(Some(stretch));
            }
            stretch += 0.001;
        }
        Ok(None)
    }
}

fn check_stretch(stretch: f64) -> Result<(), ModelError> {
    if stretch.is_finite() && stretch > 0.0 {
        Ok(())
    } else {
        Err(ModelError::OutOfDomain { symbol: "stretch", value: stretch, domain: "finite and > 0" })
    }
}
