//! Constant curvature: an axis of length l bent to a circular arc, its base tangent along z.
//!
//! ```text
//! tip    x = (1 - cos kl) / k      z = sin(kl) / k      θ = kl
//! chord  c = l sinc(θ/2)           polar angle of the tip seen from the base  atan2(x, z) = θ/2
//! ```
//!
//! | symbol | unit | domain | meaning |
//! |---|---|---|---|
//! | θ | rad | finite | bending angle: by how much the tip has rotated against the base, + toward +x |
//! | l | m | > 0 | length of the arc |
//! | k | 1/m | finite | curvature; written as θ/l throughout, so that a straight axis divides by nothing |
//! | x | m | | sideways: across the unbent axis |
//! | z | m | | along the unbent axis |
//!
//! # Assumptions
//! Planar, curvature uniform along the axis: no load at the tip, no gravity.
//! # Source
//! wave-finger, Eq. 5 to 8; fruit-finger, section 4.1 ("assumed to be a constant curvature model").
//! Frame: wave-finger's text puts x along the finger, its Eq. 8 puts z along and x sideways; this is Eq. 8.
//! Misprint: wave-finger, Table 2, prints the chord as `d2 = 2 sin(kl/2)/2`; Eq. 7 and 8 need `2 sin(kl/2)/k`. Test:
//! `table_2_as_printed_is_not_the_chord`.

use super::arc::{sinc, sinc_defect};
use crate::ModelError;
use crate::domain::{between, finite, positive};

const FULL_TURN_RAD: f64 = 2.0 * std::f64::consts::PI;

/// An arc: how long it is and how far it bends.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bent {
    /// θ, bending angle in rad.
    pub bending_angle_rad: f64,
    /// l, length of the arc in m.
    pub arc_length_m: f64,
}

impl Bent {
    /// An arc, if its length is finite and positive and its angle finite.
    ///
    /// # Errors
    /// [`ModelError::OutOfDomain`] naming what is not.
    pub fn new(bending_angle_rad: f64, arc_length_m: f64) -> Result<Self, ModelError> {
        Ok(Self {
            bending_angle_rad: finite("bending_angle", bending_angle_rad)?,
            arc_length_m: positive("arc length", arc_length_m, "finite and > 0 m")?,
        })
    }

    /// Position of the tip, `[x, z]` in m.
    ///
    /// # Numerics
    /// `x = l sin(θ/2) sinc(θ/2)`, `z = l sinc θ`: nothing cancels, and θ = 0 gives exactly `[0, l]`.
    /// # Check value
    /// l = 115 mm, 180 deg: x = 73.2112738 mm, z = 0 (wave-finger at its full angle).
    /// ```
    /// use pneuval_models::kinematics::constant_curvature::Bent;
    /// let [x, z] = Bent::new(std::f64::consts::PI, 0.115)?.tip_position_m();
    /// assert!((x * 1e3 - 73.2112738).abs() < 5e-8 && z.abs() < 1e-15);
    /// assert_eq!(Bent::new(0.0, 0.115)?.tip_position_m(), [0.0, 0.115]);
    /// # Ok::<(), pneuval_models::ModelError>(())
    /// ```
    pub fn tip_position_m(&self) -> [f64; 2] {
        let half = 0.5 * self.bending_angle_rad;
        [self.arc_length_m * half.sin() * sinc(half), self.arc_length_m * sinc(self.bending_angle_rad)]
    }

    /// Where the tip of an axis that was straight at rest has moved, `[along, sideways]` in m, from how much the axis grew:
    /// `along = z - (l - elongation)`, `sideways = x`.
    ///
    /// # Numerics
    /// `along = elongation - l (1 - sinc θ)` with [`sinc_defect`]: small displacements keep their digits.
    /// # Check value
    /// A quarter circle of l = π/2 m that did not grow: the tip comes back by π/2 - 1 m and goes 1 m sideways.
    /// ```
    /// use pneuval_models::kinematics::constant_curvature::Bent;
    /// use std::f64::consts::FRAC_PI_2;
    /// let [along, sideways] = Bent::new(FRAC_PI_2, FRAC_PI_2)?.tip_displacement_m(0.0);
    /// assert!((along - (1.0 - FRAC_PI_2)).abs() < 1e-15 && (sideways - 1.0).abs() < 1e-15);
    /// # Ok::<(), pneuval_models::ModelError>(())
    /// ```
    pub fn tip_displacement_m(&self, elongation_m: f64) -> [f64; 2] {
        let [x, _] = self.tip_position_m();
        [elongation_m - self.arc_length_m * sinc_defect(self.bending_angle_rad), x]
    }

    /// Distance from base to tip, `2R sin(θ/2) = l sinc(θ/2)` in m (wave-finger, Eq. 7).
    ///
    /// ```
    /// use pneuval_models::kinematics::constant_curvature::Bent;
    /// let half_circle = Bent::new(std::f64::consts::PI, std::f64::consts::PI)?;
    /// assert!((half_circle.chord_m() - 2.0).abs() < 1e-15);
    /// # Ok::<(), pneuval_models::ModelError>(())
    /// ```
    pub fn chord_m(&self) -> f64 {
        self.arc_length_m * sinc(0.5 * self.bending_angle_rad).abs()
    }

    /// The arc from the base to a tip `[x, z]` in m: `θ = 2 atan2(x, z)`, `l = c / sinc(θ/2)`.
    ///
    /// The inverse of [`Bent::tip_position_m`] within one turn, `-2π < θ < 2π`.
    ///
    /// # Errors
    /// [`ModelError::OutOfDomain`] for a tip that is not finite, at the base itself (every full turn has it) or straight behind
    /// it (no arc of finite length ends there).
    /// # Check value
    /// The tip of a quarter circle of radius 1 m is at x = z = 1 m.
    /// ```
    /// use pneuval_models::kinematics::constant_curvature::Bent;
    /// use std::f64::consts::FRAC_PI_2;
    /// let bent = Bent::from_tip_m([1.0, 1.0])?;
    /// assert!((bent.bending_angle_rad - FRAC_PI_2).abs() < 1e-15 && (bent.arc_length_m - FRAC_PI_2).abs() < 1e-15);
    /// # Ok::<(), pneuval_models::ModelError>(())
    /// ```
    pub fn from_tip_m([x, z]: [f64; 2]) -> Result<Self, ModelError> {
        finite("tip x", x)?;
        finite("tip z", z)?;
        if x == 0.0 && z <= 0.0 {
            return Err(ModelError::OutOfDomain { symbol: "tip z", value: z, domain: "> 0 m where x = 0 m" });
        }
        let polar = x.atan2(z);
        Self::new(2.0 * polar, x.hypot(z) / sinc(polar))
    }
}

/// Polar angle of the tip seen from the base, `θ/2` in rad: the angle of the chord, what `atan2(x, z)` gives.
///
/// # Errors
/// [`ModelError::OutOfDomain`] outside `-2π < θ < 2π`: past one turn `atan2` wraps and the half angle does not.
/// ```
/// use pneuval_models::kinematics::constant_curvature::polar_angle_rad;
/// assert_eq!(polar_angle_rad(1.0)?, 0.5);
/// assert!(polar_angle_rad(6.3).is_err());
/// # Ok::<(), pneuval_models::ModelError>(())
/// ```
pub fn polar_angle_rad(bending_angle_rad: f64) -> Result<f64, ModelError> {
    let domain = "-2π < angle < 2π rad: within one turn";
    Ok(0.5 * between("bending_angle", bending_angle_rad, -FULL_TURN_RAD, FULL_TURN_RAD, domain)?)
}

/// Bending angle of an arc whose tip is seen under a polar angle, `θ = 2 × polar` in rad: the inverse of [`polar_angle_rad`].
///
/// # Errors
/// [`ModelError::OutOfDomain`] outside `-π < polar < π`.
/// ```
/// use pneuval_models::kinematics::constant_curvature::bending_angle_from_polar_rad;
/// assert_eq!(bending_angle_from_polar_rad(0.5)?, 1.0);
/// assert!(bending_angle_from_polar_rad(3.2).is_err());
/// # Ok::<(), pneuval_models::ModelError>(())
/// ```
pub fn bending_angle_from_polar_rad(polar_angle_rad: f64) -> Result<f64, ModelError> {
    let half_turn = 0.5 * FULL_TURN_RAD;
    Ok(2.0 * between("polar_angle", polar_angle_rad, -half_turn, half_turn, "-π < angle < π rad")?)
}
