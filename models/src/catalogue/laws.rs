//! The hyperelastic laws: found by name, built from named constants.

use std::f64::consts::LN_2;

use super::{Check, Parameter};
use crate::ModelError;
use crate::materials::LoadCase::{self, Equibiaxial, Planar, Uniaxial};
use crate::materials::{EndReason, Gent, Hyperelastic, MooneyRivlin, NeoHooke, Ogden, OgdenTerm, Yeoh};

/// Named constants in SI units, as a caller keeps them.
type Constants<'a> = &'a dyn Fn(&str) -> Option<f64>;

/// One hyperelastic law.
pub struct LawEntry {
    /// Its id, as in actuator files.
    pub id: &'static str,
    /// Its name in print.
    pub title: &'static str,
    /// The strain energy per undeformed volume, in plain text.
    pub energy: &'static str,
    /// The nominal stress in each load case, in the order of [`LoadCase::ALL`], in plain text.
    pub nominal_stress: [&'static str; 3],
    /// The initial shear modulus in its constants.
    pub shear_modulus: &'static str,
    /// Where it holds, and which convention its constants follow.
    pub range: &'static str,
    /// Constants that must be given.
    pub required: &'static [Parameter],
    /// Constants that may be given; what they say about their absence stands in their meaning.
    pub optional: &'static [Parameter],
    /// Literature.
    pub source: &'static str,
    /// Numbers it must reproduce.
    pub checks: &'static [Check],
    builder: fn(Constants<'_>) -> Result<Box<dyn Hyperelastic>, ModelError>,
}

impl LawEntry {
    /// Every constant the law knows, required ones first.
    pub fn constants(&self) -> impl Iterator<Item = &'static Parameter> + use<> {
        self.required.iter().chain(self.optional)
    }

    /// The law with its constants, which are looked up by name in SI units; names it does not know are never asked for.
    ///
    /// # Errors
    /// [`ModelError::MissingParameter`], or [`ModelError::OutOfDomain`] for constants that are no material.
    pub fn build(&self, constant: &dyn Fn(&str) -> Option<f64>) -> Result<Box<dyn Hyperelastic>, ModelError> {
        (self.builder)(constant)
    }
}

/// The law of an id.
pub fn find_law(id: &str) -> Option<&'static LawEntry> {
    LAWS.iter().find(|law| law.id == id)
}

const C10: Parameter = Parameter { name: "C10", si_unit: "Pa", meaning: "half the initial shear modulus" };
const C20: Parameter = Parameter { name: "C20", si_unit: "Pa", meaning: "stiffening at moderate stretch; 0 if absent" };
const C30: Parameter = Parameter { name: "C30", si_unit: "Pa", meaning: "stiffening at large stretch; 0 if absent" };
const C1: Parameter = Parameter { name: "c1", si_unit: "Pa", meaning: "weight of I1-3" };
const C2: Parameter = Parameter { name: "c2", si_unit: "Pa", meaning: "weight of I2-3" };
const MU: Parameter = Parameter { name: "mu", si_unit: "Pa", meaning: "initial shear modulus" };
const JM: Parameter = Parameter { name: "Jm", si_unit: "1", meaning: "I1-3 at which the chains are fully stretched" };
const MU1: Parameter = Parameter { name: "mu1", si_unit: "Pa", meaning: "weight of the first term" };
const ALPHA1: Parameter = Parameter { name: "alpha1", si_unit: "1", meaning: "its exponent, not 0" };
const MU2: Parameter = Parameter { name: "mu2", si_unit: "Pa", meaning: "weight of the second term, if there is one" };
const ALPHA2: Parameter = Parameter { name: "alpha2", si_unit: "1", meaning: "its exponent, not 0" };
const MU3: Parameter = Parameter { name: "mu3", si_unit: "Pa", meaning: "weight of the third term, if there is one" };
const ALPHA3: Parameter = Parameter { name: "alpha3", si_unit: "1", meaning: "its exponent, not 0" };

/// Every law, in the order in which they are reported.
pub const LAWS: &[LawEntry] = &[
    LawEntry {
        id: "neo-hooke",
        title: "Neo-Hooke",
        energy: "W = C10 (I1-3)",
        nominal_stress: ["2 (l - l^-2) C10", "2 (l - l^-3) C10", "2 (l - l^-5) C10"],
        shear_modulus: "2 C10",
        range: "l > 0; C10 > 0; where a source gives mu, C10 = mu/2",
        required: &[C10],
        optional: &[],
        source: "Rivlin 1948, Phil. Trans. R. Soc. A 240, 459, doi:10.1098/rsta.1948.0002",
        checks: &[
            megapascal("W uniaxial, l = 2, C10 0.1 MPa: 0.1 × 2", 0.2, || energy(&neo_hooke()?, Uniaxial)),
            megapascal("stress uniaxial, l = 2: 2 × 7/4 × 0.1", 0.35, || stress(&neo_hooke()?, Uniaxial)),
            megapascal("stress planar, l = 2: 2 × 15/8 × 0.1", 0.375, || stress(&neo_hooke()?, Planar)),
            megapascal("stress equibiaxial, l = 2: 2 × 63/32 × 0.1", 0.393_75, || stress(&neo_hooke()?, Equibiaxial)),
        ],
        builder: |constant| Ok(Box::new(NeoHooke::new(require(constant, C10)?)?)),
    },
    LawEntry {
        id: "mooney-rivlin",
        title: "Mooney-Rivlin",
        energy: "W = c1 (I1-3) + c2 (I2-3)",
        nominal_stress: ["2 (l - l^-2) (c1 + c2/l)", "2 (l - l^-3) (c1 + c2)", "2 (l - l^-5) (c1 + c2 l^2)"],
        shear_modulus: "2 (c1 + c2)",
        range: "l > 0; c1 + c2 > 0; where a source writes mu1/2 and mu2/2 in W, c1 = mu1/2 and c2 = mu2/2",
        required: &[C1, C2],
        optional: &[],
        source: "Mooney 1940, J. Appl. Phys. 11, 582, doi:10.1063/1.1712836; Rivlin 1948, Phil. Trans. R. Soc. A 241, 379, doi:10.1098/rsta.1948.0024",
        checks: &[
            megapascal("W uniaxial, l = 2, c1 0.1, c2 0.02 MPa: 0.1 × 2 + 0.02 × 5/4", 0.225, || {
                energy(&mooney_rivlin()?, Uniaxial)
            }),
            megapascal("stress uniaxial, l = 2: 2 × 7/4 × 0.11", 0.385, || stress(&mooney_rivlin()?, Uniaxial)),
            megapascal("stress planar, l = 2: 2 × 15/8 × 0.12", 0.45, || stress(&mooney_rivlin()?, Planar)),
            megapascal("stress equibiaxial, l = 2: 2 × 63/32 × 0.18", 0.708_75, || {
                stress(&mooney_rivlin()?, Equibiaxial)
            }),
            number("equibiaxial stress of c1 0.26, c2 -0.023 MPa stops rising at l", 2.0, || {
                end(&MooneyRivlin::new(0.26e6, -0.023e6)?, Equibiaxial, EndReason::Unstable)
            }),
        ],
        builder: |constant| Ok(Box::new(MooneyRivlin::new(require(constant, C1)?, require(constant, C2)?)?)),
    },
    LawEntry {
        id: "yeoh",
        title: "Yeoh",
        energy: "W = C10 (I1-3) + C20 (I1-3)^2 + C30 (I1-3)^3",
        nominal_stress: [
            "2 (l - l^-2) (C10 + 2 C20 (I1-3) + 3 C30 (I1-3)^2)",
            "2 (l - l^-3) (C10 + 2 C20 (I1-3) + 3 C30 (I1-3)^2)",
            "2 (l - l^-5) (C10 + 2 C20 (I1-3) + 3 C30 (I1-3)^2)",
        ],
        shear_modulus: "2 C10",
        range: "l > 0; C10 > 0; C20 and C30 of either sign",
        required: &[C10],
        optional: &[C20, C30],
        source: "Yeoh 1993, Rubber Chem. Technol. 66, 754, doi:10.5254/1.3538343",
        checks: &[
            megapascal("W uniaxial, l = 2, C10 0.11, C20 0.02, C30 0.001 MPa: 0.22 + 0.08 + 0.008", 0.308, || {
                energy(&yeoh()?, Uniaxial)
            }),
            megapascal("stress uniaxial, l = 2: 2 × 7/4 × 0.202", 0.707, || stress(&yeoh()?, Uniaxial)),
            megapascal("stress planar, l = 2, C30 0: 2 × 15/8 × 0.2", 0.75, || {
                stress(&Yeoh::new(0.11e6, 0.02e6, 0.0)?, Planar)
            }),
            megapascal("stress equibiaxial, l = 2, C30 0: 2 × 63/32 × 0.3125", 1.230_468_75, || {
                stress(&Yeoh::new(0.11e6, 0.02e6, 0.0)?, Equibiaxial)
            }),
        ],
        builder: |constant| {
            let optional = |parameter: Parameter| constant(parameter.name).unwrap_or(0.0);
            Ok(Box::new(Yeoh::new(require(constant, C10)?, optional(C20), optional(C30))?))
        },
    },
    LawEntry {
        id: "ogden",
        title: "Ogden",
        energy: "W = sum over p of mu_p/alpha_p (l1^alpha_p + l2^alpha_p + l3^alpha_p - 3)",
        nominal_stress: [
            "sum of mu_p (l^(alpha_p - 1) - l^(-alpha_p/2 - 1))",
            "sum of mu_p (l^(alpha_p - 1) - l^(-alpha_p - 1))",
            "sum of mu_p (l^(alpha_p - 1) - l^(-2 alpha_p - 1))",
        ],
        shear_modulus: "1/2 sum of mu_p alpha_p",
        range: "l > 0; one to three terms; sum of mu_p alpha_p > 0; where a source writes 2 mu_p/alpha_p^2 in W (Abaqus), multiply its mu_p by 2/alpha_p",
        required: &[MU1, ALPHA1],
        optional: &[MU2, ALPHA2, MU3, ALPHA3],
        source: "Ogden 1972, Proc. R. Soc. Lond. A 326, 565, doi:10.1098/rspa.1972.0026",
        checks: &[
            megapascal("W uniaxial, l = 2, mu1 0.1 MPa, alpha1 4: 0.1/4 × (16 + 2/4 - 3)", 0.3375, || {
                energy(&ogden()?, Uniaxial)
            }),
            megapascal("stress uniaxial, l = 2: 0.1 × (8 - 1/8)", 0.7875, || stress(&ogden()?, Uniaxial)),
            megapascal("stress planar, l = 2: 0.1 × (8 - 1/32)", 0.796_875, || stress(&ogden()?, Planar)),
            megapascal("stress equibiaxial, l = 2: 0.1 × (8 - 1/512)", 0.799_804_687_5, || {
                stress(&ogden()?, Equibiaxial)
            }),
        ],
        builder: |constant| {
            let term = |mu, alpha| Ok(OgdenTerm { mu_pa: require(constant, mu)?, alpha: require(constant, alpha)? });
            let given = |parameter: Parameter| constant(parameter.name).is_some();
            let third = given(MU3) || given(ALPHA3);
            let mut terms = vec![term(MU1, ALPHA1)?];
            // A third term without a second one is a gap in the list, not a law of two terms.
            if third || given(MU2) || given(ALPHA2) {
                terms.push(term(MU2, ALPHA2)?);
            }
            if third {
                terms.push(term(MU3, ALPHA3)?);
            }
            Ok(Box::new(Ogden::new(&terms)?))
        },
    },
    LawEntry {
        id: "gent",
        title: "Gent",
        energy: "W = -mu Jm/2 ln(1 - (I1-3)/Jm)",
        nominal_stress: [
            "(l - l^-2) mu Jm / (Jm - (I1-3))",
            "(l - l^-3) mu Jm / (Jm - (I1-3))",
            "(l - l^-5) mu Jm / (Jm - (I1-3))",
        ],
        shear_modulus: "mu",
        range: "l > 0 and I1-3 < Jm: it locks there; mu > 0, Jm > 0",
        required: &[MU, JM],
        optional: &[],
        source: "Gent 1996, Rubber Chem. Technol. 69, 59, doi:10.5254/1.3538357",
        checks: &[
            megapascal("W uniaxial, l = 2, mu 0.2 MPa, Jm 4: 0.4 ln 2", 0.4 * LN_2, || energy(&gent()?, Uniaxial)),
            megapascal("stress uniaxial, l = 2: 7/4 × 0.2 × 4/2", 0.7, || stress(&gent()?, Uniaxial)),
            megapascal("stress planar, l = 2: 15/8 × 0.2 × 4/(7/4) = 6/7", 6.0 / 7.0, || stress(&gent()?, Planar)),
            number("with Jm 2 it locks in uniaxial tension at l", 2.0, || {
                end(&Gent::new(0.2e6, 2.0)?, Uniaxial, EndReason::OutOfDomain)
            }),
        ],
        builder: |constant| Ok(Box::new(Gent::new(require(constant, MU)?, require(constant, JM)?)?)),
    },
];

fn require(constant: Constants<'_>, parameter: Parameter) -> Result<f64, ModelError> {
    constant(parameter.name).ok_or(ModelError::MissingParameter { name: parameter.name, meaning: parameter.meaning })
}

const fn megapascal(statement: &'static str, expected: f64, compute: fn() -> Result<f64, ModelError>) -> Check {
    Check { statement, expected, tolerance: 1e-12, unit: "MPa", compute }
}

const fn number(statement: &'static str, expected: f64, compute: fn() -> Result<f64, ModelError>) -> Check {
    Check { statement, expected, tolerance: 1e-12, unit: "", compute }
}

/// W at l = 2, in MPa.
fn energy(law: &dyn Hyperelastic, case: LoadCase) -> Result<f64, ModelError> {
    Ok(law.strain_energy_pa(case, 2.0)? * 1e-6)
}

/// Nominal stress at l = 2, in MPa.
fn stress(law: &dyn Hyperelastic, case: LoadCase) -> Result<f64, ModelError> {
    Ok(law.nominal_stress_pa(case, 2.0)? * 1e-6)
}

/// Where stability ends below l = 4, NaN if it ends for another reason than the one named.
fn end(law: &dyn Hyperelastic, case: LoadCase, why: EndReason) -> Result<f64, ModelError> {
    let max = law.stable_range(case, 1.0, 4.0)?.max;
    Ok(if max.why == why { max.stretch } else { f64::NAN })
}

fn neo_hooke() -> Result<NeoHooke, ModelError> {
    NeoHooke::new(0.1e6)
}

fn mooney_rivlin() -> Result<MooneyRivlin, ModelError> {
    MooneyRivlin::new(0.1e6, 0.02e6)
}

fn yeoh() -> Result<Yeoh, ModelError> {
    Yeoh::new(0.11e6, 0.02e6, 0.001e6)
}

fn ogden() -> Result<Ogden, ModelError> {
    Ogden::new(&[OgdenTerm { mu_pa: 0.1e6, alpha: 4.0 }])
}

fn gent() -> Result<Gent, ModelError> {
    Gent::new(0.2e6, 4.0)
}
