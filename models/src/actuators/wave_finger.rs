//! Finger with wave-shaped contour: pressure -> bending angle and tip trajectory; tensile test -> Yeoh constants.
//!
//! Source: Chen et al., "Performance optimizing of pneumatic soft robotic hands using wave-shaped contour actuator"; equation
//! numbers are the paper's.
//!
//! What can be evaluated: the kinematics, Eq. 5 to 8 ([`crate::kinematics::constant_curvature`]); a linear law, because the
//! paper says "linear trend" and prints no coefficient ([`LinearAngle`]); and the line through tensile data, Eq. 28
//! ([`yeoh_from_tensile`]). Eq. 11 to 21, pressure from angle, cannot be: [`crate::catalogue::unevaluable`] says why.
//!
//! # Misprints
//! Eq. 1 prints `l/r = M/(EI)`, a pure number equal to one over a length: the left side must be 1/r. Eq. 9 squares both terms,
//! `W = C10 (I1-3)² + C20 (I1-3)²`: Yeoh's first is linear, as the paper's own Eq. 28 needs it. Table 2 prints the
//! chord as `d2 = 2 sin(kl/2)/2` for `2 sin(kl/2)/k`.

use crate::ModelError;
use crate::domain::{finite, positive};

/// Bending angle in proportion to gauge pressure.
///
/// ```text
/// θ = p θ_full / p_full
/// ```
///
/// | symbol | argument | unit | domain | meaning |
/// |---|---|---|---|---|
/// | p | `pressure_gauge_pa` | Pa | finite | gauge pressure |
/// | `p_full` | `full_pressure_gauge_pa` | Pa | > 0 | pressure of the far point of the line: 26 kPa |
/// | `θ_full` | `full_angle_rad` | rad | finite | angle there: 180 deg |
///
/// # Errors
/// [`ModelError::OutOfDomain`] for what is outside its domain.
/// # Source
/// Assumed. wave-finger, section 4.2, says "following a linear trend" and prints no line; this one goes through (0, 0) and (26
/// kPa, 180 deg), the finite element result of section 3.3. The abstract calls 180 deg at 26 kPa experimental; the measured
/// trajectory of section 4.2 ends at 168 deg.
/// # Check value
/// 26 kPa gives exactly 180 deg.
/// ```
/// use pneuval_models::actuators::wave_finger::LinearAngle;
/// let law = LinearAngle::new(26e3, std::f64::consts::PI)?;
/// assert_eq!(law.bending_angle_rad(26e3)?, std::f64::consts::PI);
/// assert_eq!(law.bending_angle_rad(0.0)?, 0.0);
/// # Ok::<(), pneuval_models::ModelError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LinearAngle {
    full_pressure_gauge_pa: f64,
    full_angle_rad: f64,
}

impl LinearAngle {
    /// The line through rest and one other point.
    ///
    /// # Errors
    /// As the type.
    pub fn new(full_pressure_gauge_pa: f64, full_angle_rad: f64) -> Result<Self, ModelError> {
        positive("linear_full_pressure", full_pressure_gauge_pa, "finite and > 0 Pa")?;
        finite("linear_full_angle", full_angle_rad)?;
        Ok(Self { full_pressure_gauge_pa, full_angle_rad })
    }

    /// Bending angle at a gauge pressure, in rad.
    ///
    /// # Errors
    /// As the type.
    pub fn bending_angle_rad(&self, pressure_gauge_pa: f64) -> Result<f64, ModelError> {
        let share = finite("gauge pressure", pressure_gauge_pa)? / self.full_pressure_gauge_pa;
        Ok(share * self.full_angle_rad)
    }
}

/// The two constants of a Yeoh law, as a line through tensile data gives them: not yet a material, for nothing keeps bad data
/// from a negative C10.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct YeohConstants {
    /// C10 in Pa.
    pub c10_pa: f64,
    /// C20 in Pa.
    pub c20_pa: f64,
}

impl YeohConstants {
    /// From the slope and the intercept of the line of Eq. 28: C20 = slope, C10 = intercept + 6 C20.
    ///
    /// # Check value
    /// The paper's lines, `y1 = 0.0076 x + 0.0681` and `y2 = 0.081 x + 0.741` MPa, give (C10, C20) = (0.1137, 0.0076) and (1.227,
    /// 0.081) MPa; the paper states (0.1, 0.0076) and (0.08, 0.015): neither line gives the stated pair.
    /// ```
    /// use pneuval_models::actuators::wave_finger::YeohConstants;
    /// let lower = YeohConstants::from_line(0.0076e6, 0.0681e6);
    /// assert!((lower.c10_pa - 0.1137e6).abs() < 1e-9 && lower.c20_pa == 0.0076e6);
    /// let upper = YeohConstants::from_line(0.081e6, 0.741e6);
    /// assert!((upper.c10_pa - 1.227e6).abs() < 1e-9 && upper.c20_pa == 0.081e6);
    /// ```
    pub fn from_line(slope_pa: f64, intercept_pa: f64) -> Self {
        Self { c10_pa: intercept_pa + 6.0 * slope_pa, c20_pa: slope_pa }
    }
}

/// A point of a uniaxial tensile test.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TensilePoint {
    /// λ1, length over undeformed length.
    pub stretch: f64,
    /// t1, force over *undeformed* area, in Pa.
    pub nominal_stress_pa: f64,
}

/// Yeoh constants by a straight line through tensile data.
///
/// ```text
/// y = t1 / (2 (λ - λ⁻²))      x = 2 (λ² + 2/λ)      y = (C10 - 6 C20) + C20 x
/// ```
///
/// | symbol | field | unit | domain | meaning |
/// |---|---|---|---|---|
/// | λ | `stretch` | 1 | > 0, not 1 | stretch; undeformed, y is 0/0 |
/// | t1 | `nominal_stress_pa` | Pa | finite | nominal stress: Eq. 22 is the derivative of the energy, and Eq. 27 has `λ - λ⁻²` |
///
/// The paper calls t1 a "principal axial force" and the "stress"; true stress would stand over `2 (λ² - 1/λ)`.
///
/// # Errors
/// [`ModelError::TooFewResiduals`] with fewer than two points, [`ModelError::OutOfDomain`] for a point outside the domain,
/// [`ModelError::Undetermined`] if every point has the same x, [`ModelError::NotFinite`] if the sums overflow.
/// # Numerics
/// x and y are taken from their means before anything is summed. The fit is least squares in y, as the paper's: points near
/// λ = 1 weigh as much as the others although their y is the least certain.
/// # Source
/// wave-finger, Eq. 28 and the text below it. Misprint: Eq. 9 squares both terms of W; Eq. 28 follows from Yeoh's law, whose first
/// is linear. Test: `a_line_through_tensile_data_gives_back_the_constants`.
/// # Check value
/// λ = 2 under the upper silicone's stated (0.08, 0.015) MPa: t1 = 2 (2 - 1/4) (0.08 + 2 × 0.015 × 2) = 0.49 MPa; λ = 4: 3.819375.
/// ```
/// use pneuval_models::actuators::wave_finger::{TensilePoint, yeoh_from_tensile};
/// let at = |stretch, mpa: f64| TensilePoint { stretch, nominal_stress_pa: mpa * 1e6 };
/// let found = yeoh_from_tensile(&[at(2.0, 0.49), at(4.0, 3.819375)])?;
/// assert!((found.c10_pa - 0.08e6).abs() < 1e-6 && (found.c20_pa - 0.015e6).abs() < 1e-6);
/// # Ok::<(), pneuval_models::ModelError>(())
/// ```
pub fn yeoh_from_tensile(points: &[TensilePoint]) -> Result<YeohConstants, ModelError> {
    if points.len() < 2 {
        return Err(ModelError::TooFewResiduals { residuals: points.len(), parameters: 2 });
    }
    let line = points.iter().map(|point| {
        let l = positive("stretch", point.stretch, "finite and > 0")?;
        let stress = finite("nominal stress", point.nominal_stress_pa)?;
        // λ - λ⁻², factored: nothing cancels near λ = 1.
        let factor = (l - 1.0) * (l * l + l + 1.0) / (l * l);
        if factor == 0.0 {
            return Err(ModelError::OutOfDomain { symbol: "stretch", value: l, domain: "not 1: there y is 0/0" });
        }
        Ok((2.0 * (l * l + 2.0 / l), stress / (2.0 * factor)))
    });
    let line = line.collect::<Result<Vec<(f64, f64)>, ModelError>>()?;
    let n = line.len() as f64;
    let (x_mean, y_mean) = (line.iter().map(|p| p.0).sum::<f64>() / n, line.iter().map(|p| p.1).sum::<f64>() / n);
    let xx: f64 = line.iter().map(|p| (p.0 - x_mean).powi(2)).sum();
    let xy: f64 = line.iter().map(|p| (p.0 - x_mean) * (p.1 - y_mean)).sum();
    // How far the points spread in x against where they lie: without spread, slope and intercept cannot be told apart.
    let condition_number = x_mean.abs() / (xx / n).sqrt();
    let determined = condition_number < 1.0 / f64::EPSILON;
    if !determined {
        return Err(ModelError::Undetermined { condition_number });
    }
    let found = YeohConstants::from_line(xy / xx, y_mean - xy / xx * x_mean);
    match [found.c10_pa, found.c20_pa].into_iter().enumerate().find(|(_, v)| !v.is_finite()) {
        Some((component, value)) => Err(ModelError::NotFinite { component, value }),
        None => Ok(found),
    }
}
