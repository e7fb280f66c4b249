//! The Ogden law, an energy in powers of the principal stretches.

use super::load_case::{excess, finite};
use super::{Hyperelastic, LoadCase, check_finite, check_positive};
use crate::ModelError;

/// Names of the constants, for errors.
const NAMES: [(&str, &str); 3] = [("mu1", "alpha1"), ("mu2", "alpha2"), ("mu3", "alpha3")];

/// The Ogden law of an incompressible rubber, with one to three terms.
///
/// ```text
/// W = Σ mu_p/alpha_p (l1^alpha_p + l2^alpha_p + l3^alpha_p - 3)        shear modulus 1/2 Σ mu_p alpha_p
/// nominal stress: uniaxial    Σ mu_p (l^(alpha_p - 1) - l^(-alpha_p/2 - 1))
///                 planar      Σ mu_p (l^(alpha_p - 1) - l^(-alpha_p - 1))
///                 equibiaxial Σ mu_p (l^(alpha_p - 1) - l^(-2 alpha_p - 1))
/// ```
///
/// | symbol | field | unit | domain | meaning |
/// |---|---|---|---|---|
/// | `mu_p` | [`OgdenTerm::mu_pa`] | Pa | finite, `Σ mu_p alpha_p` > 0 | weight of a term |
/// | `alpha_p` | [`OgdenTerm::alpha`] | 1 | finite, not 0 | its exponent |
/// | l | `stretch` | 1 | > 0 | length over undeformed length |
///
/// The convention is Ogden's own. Abaqus and others write `Σ 2 mu_p/alpha_p² (...)`, where the `mu_p` sum to the shear
/// modulus: multiply theirs by `2/alpha_p` to get these.
///
/// # Numerics
/// `l1^alpha + l2^alpha + l3^alpha - 3` is `I1 - 3` at the stretch `l^(alpha/2)`: the factored invariants of
/// [`LoadCase`] are used at `expm1(alpha/2 · ln l)`, so that nothing cancels near l = 1.
/// # Source
/// Ogden (1972), Proc. R. Soc. Lond. A 326, 565-584, doi:10.1098/rspa.1972.0026; Eq. not yet checked.
/// # Check value
/// Uniaxial, l = 2, mu1 = 0.1 MPa, alpha1 = 4: stress 0.1 (2³ - 2^-3) = 0.7875 MPa.
/// ```
/// use pneuval_models::materials::{Hyperelastic, LoadCase, Ogden, OgdenTerm};
/// let rubber = Ogden::new(&[OgdenTerm { mu_pa: 0.1e6, alpha: 4.0 }])?;
/// let stress = rubber.nominal_stress_pa(LoadCase::Uniaxial, 2.0)?;
/// assert!((stress - 0.7875e6).abs() < 1e-8);
/// # Ok::<(), pneuval_models::ModelError>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Ogden {
    terms: Vec<OgdenTerm>,
}

/// One term of an [`Ogden`] law.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OgdenTerm {
    /// `mu_p`, its weight in Pa.
    pub mu_pa: f64,
    /// `alpha_p`, its exponent.
    pub alpha: f64,
}

impl Ogden {
    /// A law from its terms.
    ///
    /// # Errors
    /// [`ModelError::OutOfDomain`] unless there are one to three terms, every constant is finite, no exponent is 0, and
    /// the shear modulus is positive.
    pub fn new(terms: &[OgdenTerm]) -> Result<Self, ModelError> {
        if terms.is_empty() || terms.len() > NAMES.len() {
            let value = terms.len() as f64;
            return Err(ModelError::OutOfDomain { symbol: "number of terms", value, domain: "1 to 3" });
        }
        for (term, (mu, alpha)) in terms.iter().zip(NAMES) {
            check_finite(mu, term.mu_pa)?;
            if !term.alpha.is_finite() || term.alpha == 0.0 {
                return Err(ModelError::OutOfDomain { symbol: alpha, value: term.alpha, domain: "finite and not 0" });
            }
        }
        let law = Self { terms: terms.to_vec() };
        check_positive("initial shear modulus", law.shear_modulus_pa(), "finite and > 0 Pa; it is half of Σ mu alpha")?;
        Ok(law)
    }

    /// A sum over the terms; each gets `l^(alpha/2) - 1`.
    fn sum(&self, stretch: f64, of: impl Fn(&OgdenTerm, f64) -> f64) -> Result<f64, ModelError> {
        let log = excess(stretch)?.ln_1p();
        finite(self.terms.iter().map(|term| of(term, (0.5 * term.alpha * log).exp_m1())).sum(), stretch)
    }
}

impl Hyperelastic for Ogden {
    fn strain_energy_pa(&self, case: LoadCase, stretch: f64) -> Result<f64, ModelError> {
        self.sum(stretch, |term, excess| term.mu_pa / term.alpha * case.i1_minus_3(excess))
    }

    fn nominal_stress_pa(&self, case: LoadCase, stretch: f64) -> Result<f64, ModelError> {
        self.sum(stretch, |term, excess| term.mu_pa * case.stress_factor(excess) * (1.0 + excess) / stretch)
    }

    fn tangent_pa(&self, case: LoadCase, stretch: f64) -> Result<f64, ModelError> {
        self.sum(stretch, |term, excess| {
            let power = 1.0 + excess;
            let factor = case.stress_factor(excess);
            let slope = 0.5 * term.alpha * (case.stress_factor_slope(power) * power + factor) - factor;
            term.mu_pa * power * slope / (stretch * stretch)
        })
    }

    fn shear_modulus_pa(&self) -> f64 {
        0.5 * self.terms.iter().map(|term| term.mu_pa * term.alpha).sum::<f64>()
    }
}
