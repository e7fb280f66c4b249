//! Finger of a fruit gripper: pressure -> bending angle (flex sensor) and force of the held tip (push-pull gauge).
//!
//! Source: "Model Analysis and Experimental Investigation of Soft Pneumatic Manipulator for Fruit Grasping"; equation numbers
//! are the paper's.
//!
//! Three angles must not be confused: the bending angle θ of Eq. 4 and of the flex sensor, which is the tip's rotation; the
//! *rod angle* of Eq. 13 to 15, half of it, because `θ0 = M L/(2EI)` is half the end slope `M L/(EI)` of a rod under an end
//! moment; and φ, by which one cavity opens.

use std::f64::consts::PI;

use crate::ModelError;
use crate::domain::{between, finite, positive};
use crate::kinematics::arc::sinc;
use crate::materials::{LoadCase, Yeoh};
use crate::solve::Curve;

/// Supply of the voltage divider, in V.
const SUPPLY_V: f64 = 5.0;
/// Fixed resistor of the voltage divider, in ohm.
const FIXED_RESISTOR_OHM: f64 = 22e3;

fn divider_ratio(voltage_v: f64) -> Result<f64, ModelError> {
    let u = between("sensor voltage", voltage_v, 0.0, SUPPLY_V, "0 < u < 5 V")?;
    Ok((SUPPLY_V - u) / u)
}

/// Resistance of the flex sensor from the voltage of its divider.
///
/// ```text
/// R = (5 - u) 22 / u   kΩ
/// ```
///
/// | symbol | argument | unit | domain | meaning |
/// |---|---|---|---|---|
/// | u | `voltage_v` | V | `0 < u < 5` | voltage across the 22 kΩ resistor |
///
/// # Errors
/// [`ModelError::OutOfDomain`] for a voltage that no divider between 0 and 5 V gives.
/// # Source
/// fruit-finger, Eq. 16. Misprint: the text calls u "the voltage assigned to the bending sensor"; by Eq. 16 it stands across the
/// other resistor, since R = 22 u/(5 - u) kΩ if u stood across the sensor.
/// # Check value
/// u = 2.5 V: the sensor has the 22 kΩ of the resistor.
/// ```
/// use pneuval_models::actuators::fruit_finger::flex_resistance_ohm;
/// assert_eq!(flex_resistance_ohm(2.5)?, 22e3);
/// assert!(flex_resistance_ohm(0.0).is_err() && flex_resistance_ohm(5.0).is_err() && flex_resistance_ohm(f64::NAN).is_err());
/// # Ok::<(), pneuval_models::ModelError>(())
/// ```
pub fn flex_resistance_ohm(voltage_v: f64) -> Result<f64, ModelError> {
    Ok(divider_ratio(voltage_v)? * FIXED_RESISTOR_OHM)
}

/// Bending angle from the voltage of the flex sensor's divider.
///
/// ```text
/// θ = (5 - u) 70.74 / u - 109.3   deg
/// ```
///
/// | symbol | argument | unit | domain | meaning |
/// |---|---|---|---|---|
/// | u | `voltage_v` | V | `0 < u < 5` | voltage across the 22 kΩ resistor |
///
/// # Errors
/// As [`flex_resistance_ohm`].
/// # Source
/// fruit-finger, Eq. 17; u as in [`flex_resistance_ohm`].
/// # Check value
/// u = 1.9645 V: 0.0058 deg; 1.2195 V: 109.9969 deg; 1.5 V: 55.76 deg.
/// ```
/// use pneuval_models::actuators::fruit_finger::flex_angle_rad;
/// assert!((flex_angle_rad(1.9645)?.to_degrees() - 0.0058).abs() < 5e-5);
/// assert!((flex_angle_rad(1.2195)?.to_degrees() - 109.9969).abs() < 5e-5);
/// assert!((flex_angle_rad(1.5)?.to_degrees() - 55.76).abs() < 5e-3);
/// assert!(flex_angle_rad(5.0).is_err() && flex_angle_rad(-1.0).is_err());
/// # Ok::<(), pneuval_models::ModelError>(())
/// ```
pub fn flex_angle_rad(voltage_v: f64) -> Result<f64, ModelError> {
    Ok((divider_ratio(voltage_v)? * 70.74 - 109.3).to_radians())
}

/// Which axial stress stands in Eq. 12.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum AxialStress {
    /// Eq. 11 as printed: the hydrostatic pressure from σ2 = 0, factor `λ1² - λ2²`.
    Printed,
    /// The hydrostatic pressure from σ3 = 0, factor `λ1² - λ1⁻²`: the faces of a thin wall carry next to no stress, whereas σ2 is what
    /// holds λ2 at 1.
    Consistent,
}

/// Bending by the balance of one cavity, Eq. 12, with Eq. 4 put in.
///
/// ```text
/// P r (2L/θ + π r) = 2π S [C10 + 2 C20 (I1 - 3)] ((r + t0/λ1)² - r²)      λ1 = 1 + 2 r θ/L
/// S = λ1² - 1 (printed)  or  λ1² - λ1⁻² (consistent)      I1 - 3 = (λ1 - 1/λ1)²
/// ```
///
/// | symbol | field | unit | domain | meaning |
/// |---|---|---|---|---|
/// | θ | state | rad | `0 <= θ <= 2π` | bending angle of the whole finger |
/// | r | `chamber_radius_m` | m | > 0 | radius of the cavity (not printed) |
/// | L | `finger_length_m` | m | > 0 | length of the finger (not printed) |
/// | t0 | `wall_m` | m | > 0 | wall thickness at rest: 2.5 mm |
/// | C10, C20 | `law` | Pa | see [`Yeoh`] | material: 0.11 and 0.02 MPa |
///
/// With θ = L φ/(2b) (Eq. 4) the cavity length b cancels: 4b/φ = 2L/θ and r φ/b = 2 r θ/L. r and L cannot be told apart by
/// one angle at one pressure: (r, L) of 110 deg at 60 kPa lie on a curve.
///
/// # Errors
/// [`ModelError::OutOfDomain`] for a length that is not finite and positive.
/// # Numerics
/// Both sides times θ: nothing is divided by it, and no pressure bends by exactly nothing.
/// # Source
/// fruit-finger, Eq. 4 to 12. Departure of [`AxialStress::Consistent`]: the text sets σ2 = 0 in the direction in which it also
/// holds the stretch at 1; a wall in plane strain has σ3 = 0. Test: `eq_12_is_the_balance_of_one_cavity`.
/// # Check value
/// b = 8, r = 6, t0 = 2.5 mm, φ = 0.1: printed 1.77596636e-3, consistent 3.31276798e-3 MPa (with L = 2b, θ is φ).
/// ```
/// use pneuval_models::actuators::fruit_finger::{AxialStress, Bending};
/// use pneuval_models::{materials::Yeoh, solve::Curve};
/// let law = Yeoh::new(0.11e6, 0.02e6, 0.0)?;
/// let pressure = |stress| Ok(Bending::new(6e-3, 16e-3, 2.5e-3, law, stress)?.pressure_gauge_pa(0.1) * 1e-6);
/// let printed: Result<f64, pneuval_models::ModelError> = pressure(AxialStress::Printed);
/// assert!((printed? - 1.77596636e-3).abs() < 5e-12);
/// assert!((pressure(AxialStress::Consistent)? - 3.31276798e-3).abs() < 5e-12);
/// # Ok::<(), pneuval_models::ModelError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bending {
    chamber_radius_m: f64,
    finger_length_m: f64,
    wall_m: f64,
    law: Yeoh,
    stress: AxialStress,
}

impl Bending {
    /// A finger from its cavity radius, its length, its wall and its material.
    ///
    /// # Errors
    /// As the type.
    pub fn new(
        chamber_radius_m: f64,
        finger_length_m: f64,
        wall_m: f64,
        law: Yeoh,
        stress: AxialStress,
    ) -> Result<Self, ModelError> {
        let domain = "finite and > 0 m";
        Ok(Self {
            chamber_radius_m: positive("chamber_radius", chamber_radius_m, domain)?,
            finger_length_m: positive("finger_length", finger_length_m, domain)?,
            wall_m: positive("wall", wall_m, domain)?,
            law,
            stress,
        })
    }

    /// σ1, true axial stress in the wall, in Pa (Eq. 11), at stretch `1 + excess`.
    fn axial_stress_pa(&self, excess: f64) -> f64 {
        let l = 1.0 + excess;
        match self.stress {
            // 2 (λ1² - 1) W1
            AxialStress::Printed => {
                2.0 * excess * (l + 1.0) * self.law.energy_slope_pa(LoadCase::Planar.i1_minus_3(excess))
            }
            // 2 (λ1² - λ1⁻²) W1: true stress is λ1 times the planar nominal one.
            AxialStress::Consistent => l * self.law.nominal_stress_at_excess_pa(LoadCase::Planar, excess),
        }
    }
}

impl Curve for Bending {
    /// A full turn: beyond it the tip would pass through the base.
    fn state_end_rad(&self) -> f64 {
        2.0 * PI
    }

    fn pressure_gauge_pa(&self, theta: f64) -> f64 {
        let (r, l) = (self.chamber_radius_m, self.finger_length_m);
        let excess = 2.0 * r * theta / l;
        let wall = self.wall_m / (1.0 + excess);
        // (r + t0/λ1)² - r²
        let ring = wall * (2.0 * r + wall);
        self.axial_stress_pa(excess) * PI * ring * theta / (r * (2.0 * l + PI * r * theta))
    }

    fn quantity(&self, theta: f64) -> f64 {
        theta
    }
}

/// Force of a tip held against the finger's wish to bend on, Eq. 15 with right units.
///
/// ```text
/// F = K θ1 (θ0 - θ1) / sin 2θ1      K = 4EI/L²      θ1 = held/2      θ1 -> 0: F = K θ0/2 = 2EI θ0/L²
/// ```
///
/// | symbol | argument | unit | domain | meaning |
/// |---|---|---|---|---|
/// | K | `rod_stiffness_n` | N | > 0 | stiffness of the rod |
/// | θ0 | `free_rod_angle_rad` | rad | finite | rod angle at which the finger would come to rest: half its free bending angle |
/// | held | `held_angle_rad` | rad | `-π < held < π` | rotation of the tip as it is held; the rod angle is half |
///
/// Below zero for θ0 < θ1: the finger would have to be pulled to the held angle, and touches nothing.
///
/// # Errors
/// [`ModelError::OutOfDomain`] for what is outside its domain; the lever arm `R sin 2θ1` vanishes at held = π (θ1 = 90 deg).
/// # Numerics
/// `θ1 / sin 2θ1 = 1 / (2 sinc held)`: the limit at held = 0 is exact.
/// # Source
/// fruit-finger, Eq. 13 to 15. Misprint: Eq. 15 has L for L² and gives N mm; from Eq. 13 and 14, M - M1 = 2EI (θ0 - θ1)/L, and
/// R = L/(2θ1). Test: `eq_15_as_printed_is_not_a_force`.
/// # Check value
/// K = 4 N, θ0 = 1 rad: 2 N straight; held at 90 deg, θ1 = π/4, F = π (1 - π/4) N.
/// ```
/// use pneuval_models::actuators::fruit_finger::tip_force_n;
/// use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI};
/// assert_eq!(tip_force_n(4.0, 1.0, 0.0)?, 2.0);
/// assert!((tip_force_n(4.0, 1.0, FRAC_PI_2)? - PI * (1.0 - FRAC_PI_4)).abs() < 1e-15);
/// assert!(tip_force_n(4.0, 1.0, PI).is_err());
/// # Ok::<(), pneuval_models::ModelError>(())
/// ```
pub fn tip_force_n(rod_stiffness_n: f64, free_rod_angle_rad: f64, held_angle_rad: f64) -> Result<f64, ModelError> {
    let stiffness = positive("rod_stiffness", rod_stiffness_n, "finite and > 0 N")?;
    let free = finite("free rod angle", free_rod_angle_rad)?;
    let held = held_angle(held_angle_rad)?;
    Ok(stiffness * (free - 0.5 * held) / (2.0 * sinc(held)))
}

/// The held angle, if the rod has a lever arm there.
///
/// # Errors
/// [`ModelError::OutOfDomain`] outside `-π < held < π`.
/// ```
/// use pneuval_models::actuators::fruit_finger::held_angle;
/// assert!(held_angle(3.2).is_err() && held_angle(0.0) == Ok(0.0));
/// ```
pub fn held_angle(held_angle_rad: f64) -> Result<f64, ModelError> {
    between("held_angle", held_angle_rad, -PI, PI, "-π < angle < π rad: the lever arm vanishes at θ1 = 90 deg")
}

/// Eq. 15 exactly as printed, `4EI θ1 (θ0 - θ1) / (L sin 2θ1)`: a moment, in the units of `EI / L`.
///
/// Kept to show that it is none in N: it changes by 1000 on going from mm to m, where a force would not.
///
/// # Errors
/// As [`tip_force_n`].
/// # Source
/// fruit-finger, Eq. 15.
/// # Check value
/// EI = 1 N m², L = 0.5 m, θ0 = 1 rad, straight: 4 N m (the force is 8 N).
/// ```
/// use pneuval_models::actuators::fruit_finger::{eq_15_as_printed, tip_force_n};
/// assert_eq!(eq_15_as_printed(1.0, 0.5, 1.0, 0.0)?, 4.0);
/// assert_eq!(tip_force_n(4.0 * 1.0 / (0.5 * 0.5), 1.0, 0.0)?, 8.0);
/// # Ok::<(), pneuval_models::ModelError>(())
/// ```
pub fn eq_15_as_printed(
    bending_stiffness: f64,
    length: f64,
    free_rod_angle_rad: f64,
    held_angle_rad: f64,
) -> Result<f64, ModelError> {
    let length = positive("finger_length", length, "finite and > 0")?;
    tip_force_n(4.0 * bending_stiffness / length, free_rod_angle_rad, held_angle_rad)
}
