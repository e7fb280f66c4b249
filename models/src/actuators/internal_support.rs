//! Internal-support gripper: a thin cylindrical wall between thick end plates bulges outward; pressure -> outer diameter.
//!
//! The paper ("Design and Theoretical Modeling of a Novel Internally-Actuated Soft End-Effector") numbers no equation; they
//! are cited by their left-hand side, from its section "Theoretical Model for Actuator Expansion".
//!
//! | symbol | field | mm | meaning |
//! |---|---|---|---|
//! | D = 2 r2 | `outer_diameter_m` | 30 | outer diameter at rest |
//! | d2 = 2 r1 | `chamber_diameter_m` | 28 | air chamber diameter |
//! | h = h2 | `chamber_height_m` | 28 | height of the wall that bulges |
//!
//! The paper's side wall d1 = (D - d2)/2 = 1 mm is not a separate input.

use std::f64::consts::PI;

use crate::ModelError;
use crate::kinematics::arc::{self, sinc};
use crate::materials::{LoadCase, Yeoh};
use crate::solve::Curve;

/// Dimensions of the bulging part, in m.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Geometry {
    outer_diameter_m: f64,
    chamber_diameter_m: f64,
    chamber_height_m: f64,
}

impl Geometry {
    /// Dimensions, checked.
    ///
    /// # Errors
    /// [`ModelError::OutOfDomain`] unless `0 < chamber diameter < outer diameter` and `chamber height > 0`.
    pub fn new(outer_diameter_m: f64, chamber_diameter_m: f64, chamber_height_m: f64) -> Result<Self, ModelError> {
        for (symbol, value) in [("chamber_diameter", chamber_diameter_m), ("chamber_height", chamber_height_m)] {
            if !(value.is_finite() && value > 0.0) {
                return Err(ModelError::OutOfDomain { symbol, value, domain: "finite and > 0 m" });
            }
        }
        if !(outer_diameter_m.is_finite() && outer_diameter_m > chamber_diameter_m) {
            return Err(ModelError::OutOfDomain {
                symbol: "outer_diameter",
                value: outer_diameter_m,
                domain: "finite and > chamber_diameter",
            });
        }
        Ok(Self { outer_diameter_m, chamber_diameter_m, chamber_height_m })
    }

    fn inner_radius_m(&self) -> f64 {
        0.5 * self.chamber_diameter_m
    }

    fn outer_radius_m(&self) -> f64 {
        0.5 * self.outer_diameter_m
    }
}

/// The model as the paper prints it. It cannot describe the actuator; it is kept to show that.
///
/// ```text
/// p(θ) = 3 cos³(θ/2) π (r1² - r2²) h dW/dθ / (6π r1² cos(θ/2) + 4 r1³ + 12 θ tan(θ/2) r1³)
/// L(θ) = 2 r1 (1 + 1/cos(θ/2))        λ = θ/sin θ        W = C10 (λ² + λ⁻² - 2) + C20 (λ² + λ⁻² - 2)²
/// ```
///
/// Domain: `0 <= θ <= 3` rad. The denominator adds mm² to mm³, so the number depends on the unit: it is evaluated in mm and MPa,
/// the paper's units, and returned in Pa.
///
/// # Misprints
/// 1. Sign: `r1² - r2²` makes the pressure negative for every θ > 0, so no positive pressure has a solution.
/// 2. Units: `6π r1²` stands beside `4 r1³`.
/// 3. The derivative of the printed volume is `3π r1³ cos(θ/2) + 4 r1³ + 6 θ tan(θ/2) r1³`:
///    [`Printed::pressure_from_printed_volume_pa`].
/// 4. `L(0) = 4 r1` = 56 mm, where the actuator measures 30 mm.
/// 5. The hoop stretch is left out although the diameter grows by 38 %.
///
/// # Check value
/// p(0.5) = -1.0599698e-3 MPa as printed, +5.2141893e-4 MPa from the printed volume; L(0) = 56 mm.
/// ```
/// use pneuval_models::{actuators::internal_support::{Geometry, Printed}, materials::Yeoh, solve::Curve};
/// let model = Printed::new(Geometry::new(0.030, 0.028, 0.028)?, Yeoh::new(0.05e6, 0.005e6, 0.0)?);
/// assert!((model.pressure_gauge_pa(0.5) - -1.0599698e-3 * 1e6).abs() < 5e-5);
/// assert!((model.pressure_from_printed_volume_pa(0.5) - 5.2141893e-4 * 1e6).abs() < 5e-6);
/// assert!((model.quantity(0.0) - 0.056).abs() < 1e-15);
/// # Ok::<(), pneuval_models::ModelError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Printed {
    geometry: Geometry,
    law: Yeoh,
}

impl Printed {
    /// The model of a geometry and a material.
    pub fn new(geometry: Geometry, law: Yeoh) -> Self {
        Self { geometry, law }
    }

    /// dW/dθ in MPa: plane strain, λ = θ/sin θ.
    fn energy_slope_mpa(&self, theta: f64) -> f64 {
        let stress_pa = self.law.nominal_stress_at_excess_pa(LoadCase::Planar, arc::stretch_excess(theta));
        stress_pa * arc::stretch_slope(theta) * 1e-6
    }

    /// What the paper's virtual work gives when its own printed volume is differentiated, sign and units right, in Pa:
    ///
    /// ```text
    /// p(θ) = 3 cos³(θ/2) π (r2² - r1²) h dW/dθ / (3π r1³ cos(θ/2) + 4 r1³ + 6 θ tan(θ/2) r1³)
    /// ```
    pub fn pressure_from_printed_volume_pa(&self, theta: f64) -> f64 {
        let (r1, r2, h) = self.lengths_mm();
        let half = 0.5 * theta;
        let numerator = 3.0 * half.cos().powi(3) * PI * (r2 * r2 - r1 * r1) * h * self.energy_slope_mpa(theta);
        let denominator = r1.powi(3) * (3.0 * PI * half.cos() + 4.0 + 6.0 * theta * half.tan());
        1e6 * numerator / denominator
    }

    fn lengths_mm(&self) -> (f64, f64, f64) {
        let g = &self.geometry;
        (1e3 * g.inner_radius_m(), 1e3 * g.outer_radius_m(), 1e3 * g.chamber_height_m)
    }
}

impl Curve for Printed {
    fn state_end_rad(&self) -> f64 {
        3.0
    }

    fn pressure_gauge_pa(&self, theta: f64) -> f64 {
        let (r1, r2, h) = self.lengths_mm();
        let half = 0.5 * theta;
        let numerator = 3.0 * half.cos().powi(3) * PI * (r1 * r1 - r2 * r2) * h * self.energy_slope_mpa(theta);
        let denominator = 6.0 * PI * r1 * r1 * half.cos() + 4.0 * r1.powi(3) + 12.0 * theta * half.tan() * r1.powi(3);
        1e6 * numerator / denominator
    }

    fn quantity(&self, theta: f64) -> f64 {
        2.0 * self.geometry.inner_radius_m() * (1.0 + 1.0 / (0.5 * theta).cos())
    }
}

/// The same idea, virtual work of a bulging wall, re-derived so that sign, units and the limit at rest are right.
///
/// The wall is a surface of revolution: its meridian is the arc of half-angle t over the chord h.
///
/// ```text
/// bulge      g(f) = ρ (cos f - cos t),  f in [-t, t],  ρ = h / (2 sin t)
/// stretches  λ_m = t / sin t (uniform),  λ_h = 1 + g / r_mid,  r_mid = (r1 + r2)/2,  λ_r = 1 / (λ_m λ_h)
/// energy     U(t) = π (r2² - r1²) h · mean over f of W
/// volume     V(t) = π ∫ (r1 + g)² dz,  z = ρ sin f
/// p(t) = (dU/dt) / (dV/dt)        L(t) = D + h tan(t/2)
/// ```
///
/// Domain: `0 <= t <= 2.2` rad. The pressure rises over all of it for the papers' materials; without stiffening it turns over
/// inside (C10 = 0.05 MPa, C20 = 0: at 10.09 kPa). Past t = π/2 the free arc overhangs the end plates, which a real wall would
/// touch: values there are the model's, not an actuator's.
///
/// # Departures from the print
/// Energy and volume belong to one shape (the print takes a plane-strain wall and two spherical caps); the hoop stretch is
/// kept; L starts at D. Wall thinning is left out of L: it overstates L by `d1 (1 - λ_r)`, 0.34 mm at L = 40.9 mm. The end
/// plates are rigid and the wall is a membrane.
///
/// # Numerics
/// Both integrals by 32-point Gauss-Legendre in u = f/t, derivatives taken under the integral; with `sin αt / sin t` written
/// through `sinc`, the limit at t = 0 is exact.
///
/// # Check value
/// (C10, C20) = (0.05, 0.005) MPa: t = 0.5 gives L = 37.149574 mm, p = 4.99325010e-3 MPa.
/// ```
/// use pneuval_models::{actuators::internal_support::{Consistent, Geometry}, materials::Yeoh, solve::Curve};
/// let model = Consistent::new(Geometry::new(0.030, 0.028, 0.028)?, Yeoh::new(0.05e6, 0.005e6, 0.0)?);
/// assert!((model.quantity(0.5) * 1e3 - 37.149574).abs() < 5e-7);
/// assert!((model.pressure_gauge_pa(0.5) * 1e-6 - 4.99325010e-3).abs() < 5e-12);
/// assert_eq!(model.pressure_gauge_pa(0.0), 0.0);
/// # Ok::<(), pneuval_models::ModelError>(())
/// ```
#[derive(Debug, Clone)]
pub struct Consistent {
    geometry: Geometry,
    law: Yeoh,
    /// Nodes u in (0, 1) and weights of the mean over the half meridian (the shape is symmetric).
    nodes: Vec<(f64, f64)>,
}

/// Where the consistent model's range ends, in rad.
const HALF_ANGLE_END_RAD: f64 = 2.2;

impl Consistent {
    /// The model of a geometry and a material.
    pub fn new(geometry: Geometry, law: Yeoh) -> Self {
        Self { geometry, law, nodes: gauss_legendre_unit(32) }
    }

    /// Strain energy U(t) in J.
    pub fn energy_j(&self, half_angle_rad: f64) -> f64 {
        let wall_m3 = self.wall_volume_m3();
        let meridian = Meridian::at(half_angle_rad);
        self.nodes
            .iter()
            .map(|&(u, weight)| {
                weight * self.law.energy_pa(self.strain(&meridian, &self.shape(&meridian, u)).i1_minus_3)
            })
            .sum::<f64>()
            * wall_m3
    }

    /// Enclosed volume V(t) in m³.
    pub fn volume_m3(&self, half_angle_rad: f64) -> f64 {
        let meridian = Meridian::at(half_angle_rad);
        let r1 = self.geometry.inner_radius_m();
        let mean = |&(u, weight): &(f64, f64)| {
            let shape = self.shape(&meridian, u);
            weight * (r1 + shape.bulge_m).powi(2) * shape.height_slope_m
        };
        2.0 * PI * self.nodes.iter().map(mean).sum::<f64>()
    }

    fn wall_volume_m3(&self) -> f64 {
        let g = &self.geometry;
        PI * (g.outer_radius_m().powi(2) - g.inner_radius_m().powi(2)) * g.chamber_height_m
    }

    /// Position of the meridian point u = f/t, and its derivatives.
    fn shape(&self, meridian: &Meridian, u: f64) -> Shape {
        let (h, t, st) = (self.geometry.chamber_height_m, meridian.half_angle_rad, meridian.sinc);
        let (a, b) = (0.5 * (1.0 + u), 0.5 * (1.0 - u));
        let (at, bt, ut) = (a * t, b * t, u * t);
        // cos f - cos t = 2 sin(at) sin(bt); with sin x = x sinc x every quotient by sin t stays finite at t = 0.
        let (sa, sb) = (a * sinc(at), b * sinc(bt));
        let bulge_m = h * t * sa * sb / st;
        let bulge_slope_m = h * ((a * at.cos() * sb + b * sa * bt.cos()) / st - sa * sb * meridian.cos / (st * st));
        // z = (h/2) sin(ut)/sin t
        let height_slope_m = 0.5 * h * ut.cos() / st;
        // d/dt of cos(ut) t/sin t
        let height_slope_rate_m = 0.5 * h * (ut.cos() * meridian.stretch_slope - u * ut.sin() / st);
        Shape { bulge_m, bulge_slope_m, height_slope_m, height_slope_rate_m }
    }

    /// `I1 - 3` at a meridian point, and its derivative by t.
    fn strain(&self, meridian: &Meridian, shape: &Shape) -> Strain {
        let mid = 0.5 * (self.geometry.inner_radius_m() + self.geometry.outer_radius_m());
        let (em, eh) = (meridian.stretch_excess, shape.bulge_m / mid);
        let (lm, lh) = (1.0 + em, 1.0 + eh);
        let (log_m, log_h) = (meridian.log_stretch, eh.ln_1p());
        // λ² - 1 and 1/(λ_m λ_h)² - 1 without cancellation.
        let i1_minus_3 = em * (em + 2.0) + eh * (eh + 2.0) + (-2.0 * (log_m + log_h)).exp_m1();
        // λ_m - λ_m⁻³ λ_h⁻² = -λ_m expm1(-4 ln λ_m - 2 ln λ_h), and the same with m and h exchanged.
        let by_m = -2.0 * lm * (-4.0 * log_m - 2.0 * log_h).exp_m1();
        let by_h = -2.0 * lh * (-4.0 * log_h - 2.0 * log_m).exp_m1();
        let slope = by_m * meridian.stretch_slope + by_h * shape.bulge_slope_m / mid;
        Strain { i1_minus_3, slope }
    }
}

/// What every point of a meridian shares: evaluated once per half-angle, not once per point.
struct Meridian {
    half_angle_rad: f64,
    sinc: f64,
    cos: f64,
    stretch_excess: f64,
    stretch_slope: f64,
    log_stretch: f64,
}

impl Meridian {
    fn at(half_angle_rad: f64) -> Self {
        let stretch_excess = arc::stretch_excess(half_angle_rad);
        Self {
            half_angle_rad,
            sinc: sinc(half_angle_rad),
            cos: half_angle_rad.cos(),
            stretch_excess,
            stretch_slope: arc::stretch_slope(half_angle_rad),
            log_stretch: stretch_excess.ln_1p(),
        }
    }
}

struct Shape {
    bulge_m: f64,
    bulge_slope_m: f64,
    height_slope_m: f64,
    height_slope_rate_m: f64,
}

struct Strain {
    i1_minus_3: f64,
    slope: f64,
}

impl Curve for Consistent {
    fn state_end_rad(&self) -> f64 {
        HALF_ANGLE_END_RAD
    }

    fn pressure_gauge_pa(&self, t: f64) -> f64 {
        let meridian = Meridian::at(t);
        let r1 = self.geometry.inner_radius_m();
        let (mut energy_slope, mut volume_slope) = (0.0, 0.0);
        for &(u, weight) in &self.nodes {
            let shape = self.shape(&meridian, u);
            let strain = self.strain(&meridian, &shape);
            let radius = r1 + shape.bulge_m;
            energy_slope += weight * self.law.energy_slope_pa(strain.i1_minus_3) * strain.slope;
            volume_slope += weight
                * (2.0 * radius * shape.bulge_slope_m * shape.height_slope_m
                    + radius * radius * shape.height_slope_rate_m);
        }
        self.wall_volume_m3() * energy_slope / (2.0 * PI * volume_slope)
    }

    fn quantity(&self, t: f64) -> f64 {
        self.geometry.outer_diameter_m + 2.0 * arc::sagitta_m(self.geometry.chamber_height_m, t)
    }
}

/// Gauss-Legendre nodes and weights on (0, 1): `count` nodes, weights summing to 1.
fn gauss_legendre_unit(count: u32) -> Vec<(f64, f64)> {
    let n = f64::from(count);
    (1..=count)
        .map(|i| {
            // Newton's method on the Legendre polynomial from Chebyshev's estimate of its root; settles within 6 steps.
            let mut x = (PI * (f64::from(i) - 0.25) / (n + 0.5)).cos();
            let mut slope = 1.0;
            for _ in 0..10 {
                let (mut before, mut value) = (1.0, x);
                for k in 2..=count {
                    let k = f64::from(k);
                    (before, value) = (value, ((2.0 * k - 1.0) * x * value - (k - 1.0) * before) / k);
                }
                slope = n * (x * value - before) / (x * x - 1.0);
                x -= value / slope;
            }
            (0.5 * (1.0 + x), 1.0 / ((1.0 - x * x) * slope * slope))
        })
        .collect()
}
