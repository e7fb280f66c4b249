//! Any actuator that bends with constant curvature while its axis grows: pressure -> bending angle, tip position, displacement.
//!
//! Nobody printed this model for one actuator: it is the smallest law with physical meaning for a user's own, and says so.
//!
//! ```text
//! l(p) = l0 + e p      θ(p) = k1 p l(p)  or  θ(p) = a p  or  θ measured      tip: kinematics::constant_curvature
//! ```
//!
//! | symbol | field | unit | domain | meaning |
//! |---|---|---|---|---|
//! | l0 | `rest_length_m` | m | > 0 | length of the axis at rest |
//! | e | `elongation_m_per_pa` | m/Pa | finite | growth of the axis per pressure; 0 for a constraint layer that does not stretch |
//! | k1 | [`Bending::Curvature`] | 1/(m Pa) | finite | curvature per pressure |
//! | a | [`Bending::Angle`] | rad/Pa | finite | bending angle per pressure |
//! | θ | [`Bending::Held`] | rad | finite | bending angle, measured |

use crate::ModelError;
use crate::domain::{finite, positive};
use crate::kinematics::constant_curvature::Bent;

/// How far the actuator bends.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Bending {
    /// Curvature in proportion to gauge pressure, k1 in 1/(m Pa): θ = k1 p l(p).
    Curvature(f64),
    /// Angle in proportion to gauge pressure, a in rad/Pa: θ = a p.
    Angle(f64),
    /// The angle itself, in rad, whatever the pressure.
    Held(f64),
}

/// An actuator of constant curvature.
///
/// Valid for pressure of either sign as long as the axis keeps a positive length; the angle is not bounded.
///
/// # Source
/// None: assumed. Geometry: wave-finger, Eq. 5 to 8.
/// # Check value
/// l0 = 100 mm, e = 1e-7 m/Pa, k1 = 3e-4 /(m Pa) at 50 kPa: l = 105 mm, θ = 1.575 rad, tip x = 66.94691072 mm,
/// z = 66.66607764 mm.
/// ```
/// use pneuval_models::actuators::constant_curvature::{Bender, Bending};
/// let bender = Bender::new(0.1, 1e-7, Bending::Curvature(3e-4))?;
/// let bent = bender.at(50e3)?;
/// assert!((bent.arc_length_m - 0.105).abs() < 1e-15 && (bent.bending_angle_rad - 1.575).abs() < 1e-14);
/// let [x, z] = bent.tip_position_m();
/// assert!((x * 1e3 - 66.94691072).abs() < 5e-9 && (z * 1e3 - 66.66607764).abs() < 5e-9);
/// assert_eq!(bender.tip_displacement_m(0.0)?, [0.0, 0.0]);
/// # Ok::<(), pneuval_models::ModelError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bender {
    rest_length_m: f64,
    elongation_m_per_pa: f64,
    bending: Bending,
}

impl Bender {
    /// An actuator from its rest length, its growth per pressure and how it bends.
    ///
    /// # Errors
    /// [`ModelError::OutOfDomain`] for a rest length that is not positive or a coefficient that is not finite.
    pub fn new(rest_length_m: f64, elongation_m_per_pa: f64, bending: Bending) -> Result<Self, ModelError> {
        positive("rest_length", rest_length_m, "finite and > 0 m")?;
        finite("elongation", elongation_m_per_pa)?;
        match bending {
            Bending::Curvature(value) => finite("curvature_per_pressure", value)?,
            Bending::Angle(value) => finite("angle_per_pressure", value)?,
            Bending::Held(value) => finite("bending_angle", value)?,
        };
        Ok(Self { rest_length_m, elongation_m_per_pa, bending })
    }

    /// The arc at a gauge pressure.
    ///
    /// # Errors
    /// [`ModelError::OutOfDomain`] where the axis would have no length left, or for a pressure that is not finite.
    pub fn at(&self, pressure_gauge_pa: f64) -> Result<Bent, ModelError> {
        let p = finite("gauge pressure", pressure_gauge_pa)?;
        let arc_length_m = self.rest_length_m + self.elongation_m_per_pa * p;
        let bending_angle_rad = match self.bending {
            Bending::Curvature(per_pressure) => per_pressure * p * arc_length_m,
            Bending::Angle(per_pressure) => per_pressure * p,
            Bending::Held(angle) => angle,
        };
        Bent::new(bending_angle_rad, arc_length_m)
    }

    /// Where the tip has moved from rest, `[along, sideways]` in m: `[z - l0, x]`.
    ///
    /// # Errors
    /// As [`Bender::at`].
    pub fn tip_displacement_m(&self, pressure_gauge_pa: f64) -> Result<[f64; 2], ModelError> {
        Ok(self.at(pressure_gauge_pa)?.tip_displacement_m(self.elongation_m_per_pa * pressure_gauge_pa))
    }
}
