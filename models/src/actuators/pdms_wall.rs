//! Expanding wall of a ring gripper: pressure -> displacement of the wall; contact pressure and area -> contact force.
//!
//! Source: "Pneumatic Hyperelastic Actuators for Grasping Curved Organic Objects"; equation numbers are the paper's. The paper
//! has no closed model of the displacement (its prediction is a COMSOL simulation): the strip is ours.

use crate::ModelError;
use crate::domain::{finite, positive};
use crate::kinematics::arc;
use crate::materials::{LoadCase, Yeoh};
use crate::solve::Curve;

/// How the paper's two material constants enter its energy.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Constants {
    /// Eq. 1 as printed, `W = μ1/2 (I1-3) + μ2/2 (I2-3)`. With the paper's μ = 2 (μ1 + μ2) the law's initial shear modulus is
    /// μ1 + μ2 = μ/2, not μ.
    AsPrinted,
    /// `W = μ1 (I1-3) + μ2 (I2-3)`: the initial shear modulus, 2 (μ1 + μ2), is the paper's μ.
    MuIsModulus,
}

/// A long clamped strip that bulges to an arc, in plane strain.
///
/// ```text
/// p = (dU/dt) / (dA/dt) = t_d h c 2 (l - l⁻³) (dl/dt) / (dA/dt)      l = t / sin t      δ = (h/2) tan(t/2)
/// c = (μ1 + μ2)/2 (as printed)  or  μ1 + μ2 (μ is the modulus)
/// ```
///
/// | symbol | field | unit | domain | meaning |
/// |---|---|---|---|---|
/// | t | state | rad | `0 <= t <= 3` | half the angle of the arc |
/// | h | `chord_m` | m | > 0 | width of the strip between its clamps: chamber height, 20 mm |
/// | `t_d` | `wall_thickness_m` | m | > 0 | wall thickness at rest: 1.5, 2, 2.5 mm |
/// | μ1, μ2 | | Pa | finite, sum > 0 | Mooney-Rivlin constants: 7/16 and 1/16 of μ = 6.67e5 Pa |
/// | δ | quantity | m | | displacement of the middle of the wall |
///
/// In plane strain I1 = I2, so the law acts through c = c1 + c2 alone, like a Yeoh law of C10 = c.
///
/// # Errors
/// [`ModelError::OutOfDomain`] for what is outside its domain.
/// # Assumptions
/// Membrane, no bending stiffness; ends clamped and unmoved; flat at rest, although the wall is an arc of 60 deg across the
/// other direction; no contact; the bulk term of Eq. 1 left out (J = 1).
/// # Numerics
/// The quotient of the slopes is `2 sin t / h²`, so this is Laplace's law, `p = true stress × thickness / radius`; the pressure
/// rises over the whole range for every c: `p = (4 c t_d/h)(t - sin⁴t/t³)`. Test: `strip_work_of_pressure_is_the_energy`.
/// # Source
/// Ours; material: pdms-wall, section 2.3 and Eq. 1.
/// # Check value
/// c = 0.16675 MPa, h = 20, `t_d` = 2 mm, t = 0.6: 8.63181118e-3 MPa.
/// ```
/// use pneuval_models::actuators::pdms_wall::{Constants, Strip};
/// use pneuval_models::solve::Curve;
/// let strip = Strip::new(20e-3, 2e-3, 6.67e5 * 7.0 / 16.0, 6.67e5 / 16.0, Constants::AsPrinted)?;
/// assert!((strip.pressure_gauge_pa(0.6) * 1e-6 - 8.63181118e-3).abs() < 5e-12);
/// assert_eq!((strip.pressure_gauge_pa(0.0), strip.quantity(0.0)), (0.0, 0.0));
/// # Ok::<(), pneuval_models::ModelError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Strip {
    chord_m: f64,
    wall_thickness_m: f64,
    /// The law in plane strain.
    law: Yeoh,
}

impl Strip {
    /// A strip of a width, a thickness and the paper's two constants in one reading.
    ///
    /// # Errors
    /// As the type.
    pub fn new(
        chord_m: f64,
        wall_thickness_m: f64,
        mu1_pa: f64,
        mu2_pa: f64,
        constants: Constants,
    ) -> Result<Self, ModelError> {
        let sum_pa = finite("mu1", mu1_pa)? + finite("mu2", mu2_pa)?;
        let c_pa = match constants {
            Constants::AsPrinted => 0.5 * sum_pa,
            Constants::MuIsModulus => sum_pa,
        };
        positive("mu1 + mu2", c_pa, "finite and > 0 Pa")?;
        Ok(Self {
            chord_m: positive("chord", chord_m, "finite and > 0 m")?,
            wall_thickness_m: positive("wall_thickness", wall_thickness_m, "finite and > 0 m")?,
            law: Yeoh::new(c_pa, 0.0, 0.0)?,
        })
    }

    /// Strain energy per length of the strip, U(t) in J/m.
    pub fn energy_j_per_m(&self, half_angle_rad: f64) -> f64 {
        let i1_minus_3 = LoadCase::Planar.i1_minus_3(arc::stretch_excess(half_angle_rad));
        self.wall_thickness_m * self.chord_m * self.law.energy_pa(i1_minus_3)
    }

    /// Area between the strip and its chord, A(t) in m²: volume per length of the strip.
    pub fn area_m2(&self, half_angle_rad: f64) -> f64 {
        arc::segment_area_m2(self.chord_m, half_angle_rad)
    }
}

impl Curve for Strip {
    fn state_end_rad(&self) -> f64 {
        3.0
    }

    fn pressure_gauge_pa(&self, t: f64) -> f64 {
        let stress = self.law.nominal_stress_at_excess_pa(LoadCase::Planar, arc::stretch_excess(t));
        // h (dl/dt)/(dA/dt) = 1/ρ
        stress * self.wall_thickness_m * 2.0 * t.sin() / self.chord_m
    }

    fn quantity(&self, t: f64) -> f64 {
        arc::sagitta_m(self.chord_m, t)
    }
}

/// Contact force, `F = P_c A_c` in N.
///
/// | symbol | argument | unit | domain | meaning |
/// |---|---|---|---|---|
/// | `P_c` | `contact_pressure_pa` | Pa | >= 0 | contact pressure, from COMSOL at 34.47 kPa in the chamber |
/// | `A_c` | `contact_area_m2` | m² | >= 0 | contact area, from the imprint of paint on a sphere of 60 mm |
///
/// # Errors
/// [`ModelError::OutOfDomain`] for what is outside its domain.
/// # Source
/// pdms-wall, Eq. 3. Misprint: none known.
/// # Check value
/// Table 2, wall of 1.5 mm: 37 kPa on 424.4 mm² is 15.7 N.
/// ```
/// use pneuval_models::actuators::pdms_wall::contact_force_n;
/// assert!((contact_force_n(37e3, 424.4e-6)? - 15.7).abs() < 0.05);
/// assert!(contact_force_n(-1.0, 1e-4).is_err() && contact_force_n(37e3, f64::NAN).is_err());
/// # Ok::<(), pneuval_models::ModelError>(())
/// ```
pub fn contact_force_n(contact_pressure_pa: f64, contact_area_m2: f64) -> Result<f64, ModelError> {
    for (symbol, value, domain) in [
        ("contact_pressure", contact_pressure_pa, "finite and >= 0 Pa"),
        ("contact_area", contact_area_m2, "finite and >= 0 m2"),
    ] {
        if !(value.is_finite() && value >= 0.0) {
            return Err(ModelError::OutOfDomain { symbol, value, domain });
        }
    }
    Ok(contact_pressure_pa * contact_area_m2)
}
