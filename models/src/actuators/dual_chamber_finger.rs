//! Dual-chamber finger with an embedded steel sheet: pressure in the tip and in the root -> tip, root and total bending angle.
//!
//! Source: Cai et al. 2025, Actuators 14, 268, doi:10.3390/act14060268; equation numbers are the paper's.
//!
//! | symbol | field | mm | meaning |
//! |---|---|---|---|
//! | w | `width_m` | 28 | finger width (Table 1: W) |
//! | k | `chamber_straight_height_m` | 6 | straight part of the chamber height (Table 1: K + r = 18, 2r = 24) |
//! | z | `constraint_thickness_m` | 2 | strain restriction layer (Table 1: Z) |
//! | u | `chamber_length_m` | 4 | chamber length (Table 1: f) |
//! | R | `outer_radius_m` | 14 | r + radial wall g = 12 + 2 |
//! | s | `chamber_width_m` | 24 | chamber width (Table 1: 2r) |
//! | r1 | `chamber_radius_m` | 12 | half the chamber width |
//! | g | `radial_wall_m` | 2 | radial wall (Table 1: g) |

use std::f64::consts::PI;

use crate::ModelError;
use crate::kinematics::arc;
use crate::materials::{LoadCase, Yeoh};
use crate::solve::Curve;

/// The D-shaped cross-section that tip and root share, in m.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Section {
    /// w, finger width.
    pub width_m: f64,
    /// k, straight part of the chamber height.
    pub chamber_straight_height_m: f64,
    /// z, thickness of the strain restriction layer.
    pub constraint_thickness_m: f64,
    /// u, chamber length along the finger.
    pub chamber_length_m: f64,
    /// R, outer radius of the round part.
    pub outer_radius_m: f64,
    /// s, chamber width.
    pub chamber_width_m: f64,
    /// r1, radius of the round part of the chamber.
    pub chamber_radius_m: f64,
    /// g, radial wall thickness.
    pub radial_wall_m: f64,
}

impl Section {
    /// The section, if every length is finite and positive and the chamber lies inside the finger.
    ///
    /// # Errors
    /// [`ModelError::OutOfDomain`] naming the first length that is not.
    pub fn checked(self) -> Result<Self, ModelError> {
        for (symbol, value) in [
            ("width", self.width_m),
            ("chamber_straight_height", self.chamber_straight_height_m),
            ("constraint_thickness", self.constraint_thickness_m),
            ("chamber_length", self.chamber_length_m),
            ("outer_radius", self.outer_radius_m),
            ("chamber_width", self.chamber_width_m),
            ("chamber_radius", self.chamber_radius_m),
            ("radial_wall", self.radial_wall_m),
        ] {
            positive_length(symbol, value)?;
        }
        if self.chamber_radius_m >= self.outer_radius_m {
            return Err(ModelError::OutOfDomain {
                symbol: "chamber_radius",
                value: self.chamber_radius_m,
                domain: "< outer_radius",
            });
        }
        Ok(self)
    }
}

fn positive_length(symbol: &'static str, value: f64) -> Result<(), ModelError> {
    if value.is_finite() && value > 0.0 {
        Ok(())
    } else {
        Err(ModelError::OutOfDomain { symbol, value, domain: "finite and > 0 m" })
    }
}

/// What the paper leaves open in the tip model.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TipReading {
    /// Eq. 12 as printed: an airbag bends by θ, the angle in λ = θ / sin θ.
    Printed,
    /// λ = θ / sin θ holds for θ *half* the central angle of the arc (arc 2ρθ over chord 2ρ sin θ), so an airbag bends by 2θ.
    Consistent,
    /// The energy of Eq. 5, last line, which prints `(λ² - λ⁻²)` for `(λ - 1/λ)`; a misprint, kept to show that it is one.
    Eq5LastLine,
}

/// Tip bending by virtual work, Eq. 7 to 13.
///
/// ```text
/// V1 = w (k+z) (u+2e) + π/2 (u+2e) R²      V2 = k s u + π/2 r1² u      Vr = V1 - V2
/// P  = (Vr/V1) 2 λ (1 - λ⁻⁴) [C10 + 2 C20 (λ - 1/λ)²]      λ = θ / sin θ      angle = n θ
/// ```
///
/// e is the tip's expansion wall (1.5 mm), n = 5 its number of airbags. Domain: `0 <= θ <= 3` rad.
///
/// # Misprints
/// Eq. 9 prints `V1 (1 + λ)` for `V1 λ`: at λ = 1 the volume would be doubled, but the derivative, all that Eq. 12 uses, is
/// the same. Eq. 5, last line: see [`TipReading::Eq5LastLine`]; it would give 96.98 deg at 40 kPa.
///
/// # Check value
/// V1 = 3723.132560, V2 = 1480.778684, Vr = 2242.353876 mm³; 40 kPa gives 197.724703 deg: see the catalogue's checks.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tip {
    section: Section,
    wall_m: f64,
    airbags: f64,
    law: Yeoh,
    reading: TipReading,
}

impl Tip {
    /// The tip of a section, its wall e, its number of airbags n and a material.
    ///
    /// # Errors
    /// [`ModelError::OutOfDomain`] for a length or count that is not positive.
    pub fn new(
        section: Section,
        wall_m: f64,
        airbags: f64,
        law: Yeoh,
        reading: TipReading,
    ) -> Result<Self, ModelError> {
        let section = section.checked()?;
        positive_length("tip_wall", wall_m)?;
        if !(airbags.is_finite() && airbags >= 1.0) {
            return Err(ModelError::OutOfDomain { symbol: "tip_airbags", value: airbags, domain: "finite and >= 1" });
        }
        Ok(Self { section, wall_m, airbags, law, reading })
    }

    /// Volume of one airbag, walls included, V1 in m³ (Eq. 8).
    pub fn airbag_volume_m3(&self) -> f64 {
        let s = &self.section;
        let length = s.chamber_length_m + 2.0 * self.wall_m;
        length
            * (s.width_m * (s.chamber_straight_height_m + s.constraint_thickness_m)
                + 0.5 * PI * s.outer_radius_m.powi(2))
    }

    /// Volume of the air in one airbag, V2 in m³ (Eq. 8).
    pub fn air_volume_m3(&self) -> f64 {
        let s = &self.section;
        s.chamber_length_m * (s.chamber_straight_height_m * s.chamber_width_m + 0.5 * PI * s.chamber_radius_m.powi(2))
    }

    /// Volume of the silicone of one airbag, Vr = V1 - V2 in m³ (Eq. 8).
    pub fn silicone_volume_m3(&self) -> f64 {
        self.airbag_volume_m3() - self.air_volume_m3()
    }
}

impl Curve for Tip {
    fn state_end_rad(&self) -> f64 {
        3.0
    }

    fn pressure_gauge_pa(&self, theta: f64) -> f64 {
        let excess = arc::stretch_excess(theta);
        // dW/dλ: for the plane-strain energy of Eq. 5 it is the planar nominal stress, Eq. 14.
        let energy_slope_pa = match self.reading {
            TipReading::Printed | TipReading::Consistent => {
                self.law.nominal_stress_at_excess_pa(LoadCase::Planar, excess)
            }
            TipReading::Eq5LastLine => {
                let l = 1.0 + excess;
                let root = excess * (l + 1.0) * (l * l + 1.0) / (l * l);
                self.law.energy_slope_pa(root * root) * 2.0 * root * 2.0 * (l + l.powi(-3))
            }
        };
        self.silicone_volume_m3() / self.airbag_volume_m3() * energy_slope_pa
    }

    fn quantity(&self, theta: f64) -> f64 {
        let bend_per_airbag = match self.reading {
            TipReading::Printed | TipReading::Eq5LastLine => theta,
            TipReading::Consistent => 2.0 * theta,
        };
        self.airbags * bend_per_airbag
    }
}

/// The axial stress in the root's walls.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RootStress {
    /// Eq. 15: `σ1 = 8 C10 (λ - 1)`, the linear part of Eq. 14.
    Linear,
    /// Eq. 14 in full.
    Full,
}

/// What the steel sheet adds to the torque balance.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Sheet {
    /// Left out.
    None,
    /// Eq. 21 as printed, `β = λ E`, in Eq. 22: the sheet is stressed by E before it bends.
    Printed {
        /// Young's modulus, E in Pa.
        modulus_pa: f64,
    },
    /// `β = (λ - 1) E` in Eq. 22.
    Strain {
        /// Young's modulus, E in Pa.
        modulus_pa: f64,
    },
    /// An elastic strip bent to the root's angle over its length a: `M3 = E w t³/12 · θ/a`. Not in the paper; the sheet's width
    /// is an input, because the paper prints none.
    ElasticStrip {
        /// Young's modulus, E in Pa.
        modulus_pa: f64,
        /// Length over which the root bends, a in m.
        root_length_m: f64,
        /// Width of the sheet, in m.
        sheet_width_m: f64,
    },
}

/// How thick the silicone beside the sheet is taken to be, k2, out of the restriction layer z and the sheet t.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Layer {
    /// `2 k2 + t = z`, two equal layers around the sheet, as Eq. 22 places it: 0.85 mm.
    TwoEqual,
    /// `k2 = z - t`, all silicone on one side: 1.7 mm.
    OneSide,
    /// `k2 = z / 2`: 1.0 mm.
    Half,
}

impl Layer {
    fn thickness_m(self, constraint_m: f64, sheet_m: f64) -> f64 {
        match self {
            Self::TwoEqual => 0.5 * (constraint_m - sheet_m),
            Self::OneSide => constraint_m - sheet_m,
            Self::Half => 0.5 * constraint_m,
        }
    }
}

/// One way to read Eq. 14 to 24, which leave k2, the factor of one integral and the sheet's stress open.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RootReading {
    /// k2: thickness of the silicone beside the sheet; the paper prints no number.
    pub layer: Layer,
    /// c: 1 where the outer `∫ dθ` of Eq. 20 is dropped as in Eq. 23, π where it is kept.
    pub layer_factor: f64,
    /// Linear or full stress.
    pub stress: RootStress,
    /// The sheet.
    pub sheet: Sheet,
    /// Thickness of the sheet, t in m.
    pub sheet_thickness_m: f64,
}

/// Root bending by torque balance, Eq. 14 to 24.
///
/// ```text
/// P [s k²/2 + 2 r1³/3 + π k r1²/2]
///   = σ1 [g k² + 2 (R³ - r1³)/3 + π k (R² - r1²)/2  +  w k2²/2 + c w k2 (3/2 k2 + t)]  +  M3
/// λ = θ / sin θ      root angle = θ
/// ```
///
/// k1 of the paper is k. M3 is zero, `β w t (k2 + t/2)` (Eq. 22) or the elastic strip: see [`Sheet`]. Domain: `0 <= θ <= 3` rad.
///
/// # Misprints
/// Eq. 21, `β = λ E`, stresses an unbent sheet by E = 193 GPa: the undeformed state already needs 551 MPa, so no working
/// pressure has a solution. Eq. 20 keeps an integral over θ that Eq. 23 drops. There is no `consistent` form: the paper
/// does not say enough (k2, the sheet's width) to derive one.
///
/// # Check value
/// No sheet, k2 = 1.7 mm, c = 1: 50 kPa gives 46.357709 deg: see the catalogue's checks.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Root {
    section: Section,
    law: Yeoh,
    c10_pa: f64,
    /// k2 in m.
    layer_m: f64,
    reading: RootReading,
}

impl Root {
    /// The root of a section, a material and a reading.
    ///
    /// # Errors
    /// [`ModelError::OutOfDomain`] for a length, factor or modulus that is not positive.
    pub fn new(section: Section, law: Yeoh, reading: RootReading) -> Result<Self, ModelError> {
        let section = section.checked()?;
        positive_length("sheet_thickness", reading.sheet_thickness_m)?;
        let layer_m = reading.layer.thickness_m(section.constraint_thickness_m, reading.sheet_thickness_m);
        positive_length("k2", layer_m)?;
        let positive = |symbol, value: f64| {
            if value.is_finite() && value > 0.0 {
                Ok(())
            } else {
                Err(ModelError::OutOfDomain { symbol, value, domain: "finite and > 0" })
            }
        };
        positive("c", reading.layer_factor)?;
        match reading.sheet {
            Sheet::None => {}
            Sheet::Printed { modulus_pa } | Sheet::Strain { modulus_pa } => positive("sheet_modulus", modulus_pa)?,
            Sheet::ElasticStrip { modulus_pa, root_length_m, sheet_width_m } => {
                positive("sheet_modulus", modulus_pa)?;
                positive_length("root_length", root_length_m)?;
                positive_length("sheet_width", sheet_width_m)?;
            }
        }
        Ok(Self { section, law, c10_pa: law.energy_slope_pa(0.0), layer_m, reading })
    }

    /// Torque per unit pressure, the bracket of Eq. 18 in m³.
    fn driving_m3(&self) -> f64 {
        let s = &self.section;
        let (k, r) = (s.chamber_straight_height_m, s.chamber_radius_m);
        0.5 * s.chamber_width_m * k * k + 2.0 / 3.0 * r.powi(3) + 0.5 * PI * k * r * r
    }

    /// Torque per unit stress of walls and constraint layer, the bracket of Eq. 19 and 20 in m³.
    fn resisting_m3(&self) -> f64 {
        let s = &self.section;
        let (k, r, outer) = (s.chamber_straight_height_m, s.chamber_radius_m, s.outer_radius_m);
        let walls =
            s.radial_wall_m * k * k + 2.0 / 3.0 * (outer.powi(3) - r.powi(3)) + 0.5 * PI * k * (outer * outer - r * r);
        let (k2, t) = (self.layer_m, self.reading.sheet_thickness_m);
        walls + 0.5 * s.width_m * k2 * k2 + self.reading.layer_factor * s.width_m * k2 * (1.5 * k2 + t)
    }

    /// Torque of the steel sheet, M3 in N m.
    fn sheet_torque_nm(&self, theta: f64) -> f64 {
        let t = self.reading.sheet_thickness_m;
        let lever_m3 = self.section.width_m * t * (self.layer_m + 0.5 * t);
        match self.reading.sheet {
            Sheet::None => 0.0,
            Sheet::Printed { modulus_pa } => (1.0 + arc::stretch_excess(theta)) * modulus_pa * lever_m3,
            Sheet::Strain { modulus_pa } => arc::stretch_excess(theta) * modulus_pa * lever_m3,
            Sheet::ElasticStrip { modulus_pa, root_length_m, sheet_width_m } => {
                modulus_pa * sheet_width_m * t.powi(3) / 12.0 * theta / root_length_m
            }
        }
    }
}

impl Curve for Root {
    fn state_end_rad(&self) -> f64 {
        3.0
    }

    fn pressure_gauge_pa(&self, theta: f64) -> f64 {
        let excess = arc::stretch_excess(theta);
        let stress_pa = match self.reading.stress {
            RootStress::Linear => 8.0 * self.c10_pa * excess,
            RootStress::Full => self.law.nominal_stress_at_excess_pa(LoadCase::Planar, excess),
        };
        (stress_pa * self.resisting_m3() + self.sheet_torque_nm(theta)) / self.driving_m3()
    }

    fn quantity(&self, theta: f64) -> f64 {
        theta
    }
}
