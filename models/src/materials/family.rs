//! Laws with open constants, for fitting: stress and its derivative by every constant.

use super::LoadCase;
use super::load_case::excess;
use crate::ModelError;

/// A law whose constants are to be found. In some of them the stress is linear, so that those follow from the others.
///
/// | family | constants | linear in |
/// |---|---|---|
/// | [`Family::NeoHooke`] | C10 | C10 |
/// | [`Family::MooneyRivlin`] | c1, c2 | both |
/// | [`Family::Yeoh`] of n terms | C10, C20, C30 | all |
/// | [`Family::Ogden`] of n terms | mu1, alpha1, mu2, alpha2, ... | every mu |
/// | [`Family::Gent`] | mu, Jm | mu |
///
/// A test holds the stress to that of the laws themselves, and the derivatives to differences.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Family {
    /// [`super::NeoHooke`].
    NeoHooke,
    /// [`super::MooneyRivlin`].
    MooneyRivlin,
    /// [`super::Yeoh`] of one to three terms.
    Yeoh(usize),
    /// [`super::Ogden`] of one to three terms.
    Ogden(usize),
    /// [`super::Gent`].
    Gent,
}

const YEOH: [&str; 3] = ["C10", "C20", "C30"];
const OGDEN: [&str; 6] = ["mu1", "alpha1", "mu2", "alpha2", "mu3", "alpha3"];

impl Family {
    /// Every family that a fit tries, the simplest first.
    pub const ALL: [Self; 8] = [
        Self::NeoHooke,
        Self::MooneyRivlin,
        Self::Yeoh(2),
        Self::Yeoh(3),
        Self::Gent,
        Self::Ogden(1),
        Self::Ogden(2),
        Self::Ogden(3),
    ];

    /// Its id: that of the law, with the number of terms where there may be several.
    pub fn id(self) -> &'static str {
        match self {
            Self::NeoHooke => "neo-hooke",
            Self::MooneyRivlin => "mooney-rivlin",
            Self::Yeoh(0 | 1) => "yeoh-1",
            Self::Yeoh(2) => "yeoh-2",
            Self::Yeoh(_) => "yeoh-3",
            Self::Ogden(0 | 1) => "ogden-1",
            Self::Ogden(2) => "ogden-2",
            Self::Ogden(_) => "ogden-3",
            Self::Gent => "gent",
        }
    }

    /// The family of an id.
    pub fn find(id: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|family| family.id() == id)
    }

    /// The id of its law in the catalogue.
    pub fn law(self) -> &'static str {
        match self {
            Self::NeoHooke => "neo-hooke",
            Self::MooneyRivlin => "mooney-rivlin",
            Self::Yeoh(_) => "yeoh",
            Self::Ogden(_) => "ogden",
            Self::Gent => "gent",
        }
    }

    /// Its constants, as the catalogue names them.
    pub fn constants(self) -> Vec<&'static str> {
        match self {
            Self::NeoHooke => vec!["C10"],
            Self::MooneyRivlin => vec!["c1", "c2"],
            Self::Yeoh(terms) => YEOH.into_iter().take(terms).collect(),
            Self::Ogden(terms) => OGDEN.into_iter().take(2 * terms).collect(),
            Self::Gent => vec!["mu", "Jm"],
        }
    }

    /// Which of them the stress is linear in.
    pub fn linear(self) -> Vec<usize> {
        match self {
            Self::Ogden(terms) => (0..terms).map(|term| 2 * term).collect(),
            Self::Gent => vec![0],
            Self::NeoHooke | Self::MooneyRivlin | Self::Yeoh(_) => (0..self.constants().len()).collect(),
        }
    }

    /// Nominal stress in Pa at a stretch; `slopes` becomes its derivative by each constant.
    ///
    /// # Errors
    /// [`ModelError::OutOfDomain`] for a stretch that is not finite and positive, or beyond where the chains lock (Gent).
    pub fn nominal_stress_pa(
        self,
        constants: &[f64],
        case: LoadCase,
        stretch: f64,
        slopes: &mut [f64],
    ) -> Result<f64, ModelError> {
        let excess = excess(stretch)?;
        let factor = 2.0 * case.stress_factor(excess);
        match self {
            Self::NeoHooke | Self::Yeoh(_) => {
                let i = case.i1_minus_3(excess);
                let mut power = 1.0;
                for (k, slope) in slopes.iter_mut().enumerate() {
                    *slope = factor * (k + 1) as f64 * power;
                    power *= i;
                }
            }
            Self::MooneyRivlin => {
                slopes[0] = factor;
                slopes[1] = factor * case.second_weight(stretch);
            }
            Self::Ogden(terms) => {
                let log = excess.ln_1p();
                // l^(alpha - 1) - l^(-k alpha - 1)
                let k = match case {
                    LoadCase::Uniaxial => 0.5,
                    LoadCase::Planar => 1.0,
                    LoadCase::Equibiaxial => 2.0,
                };
                for term in 0..terms {
                    let (mu, alpha) = (constants[2 * term], constants[2 * term + 1]);
                    let low = (-k * alpha * log).exp();
                    slopes[2 * term] = low * ((1.0 + k) * alpha * log).exp_m1() / stretch;
                    slopes[2 * term + 1] = mu * log * ((alpha * log).exp() + k * low) / stretch;
                }
                return Ok((0..terms).map(|term| constants[2 * term] * slopes[2 * term]).sum());
            }
            Self::Gent => {
                let (mu, jm) = (constants[0], constants[1]);
                let i = case.i1_minus_3(excess);
                if jm.is_nan() || jm <= i {
                    return Err(ModelError::OutOfDomain {
                        symbol: "Jm",
                        value: jm,
                        domain: "above I1-3 of every stretch",
                    });
                }
                slopes[0] = 0.5 * factor * jm / (jm - i);
                slopes[1] = -0.5 * factor * mu * i / (jm - i).powi(2);
                return Ok(mu * slopes[0]);
            }
        }
        Ok(constants.iter().zip(slopes.iter()).map(|(constant, slope)| constant * slope).sum())
    }
}
