//! Incompressible hyperelastic laws: energy and its derivative side by side, one law per file.
//!
//! A test holds every law to *stress = derivative of energy* in every [`LoadCase`], and to zero stress at stretch 1.

pub mod yeoh;

pub use yeoh::Yeoh;

/// A homogeneous deformation of an incompressible block, told by one stretch l.
///
/// | case | principal stretches | `I1 - 3` | dW/dl |
/// |---|---|---|---|
/// | uniaxial | l, l^-1/2, l^-1/2 | (l-1)² (l+2)/l | nominal stress |
/// | planar | l, 1, 1/l | (l - 1/l)² | nominal stress |
/// | equibiaxial | l, l, l^-2 | (l²-1)² (2l²+1)/l⁴ | 2 × nominal stress (two loaded edges) |
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LoadCase {
    /// Pulled along one axis, free across it.
    Uniaxial,
    /// Pulled along one axis, held at its length along the second (pure shear, plane strain).
    Planar,
    /// Pulled equally along two axes.
    Equibiaxial,
}

impl LoadCase {
    /// Every load case, for tests and tables.
    pub const ALL: [Self; 3] = [Self::Uniaxial, Self::Planar, Self::Equibiaxial];

    /// `I1 - 3` at stretch `1 + excess`, factored so that nothing cancels near the undeformed state.
    pub fn i1_minus_3(self, excess: f64) -> f64 {
        let l = 1.0 + excess;
        match self {
            Self::Uniaxial => excess * excess * (l + 2.0) / l,
            Self::Planar => (excess * (l + 1.0) / l).powi(2),
            Self::Equibiaxial => (excess * (l + 1.0)).powi(2) * (2.0 * l * l + 1.0) / l.powi(4),
        }
    }

    /// The geometric factor g of `nominal stress = 2 g W1`: `l - l^-2`, `l - l^-3` or `l - l^-5`.
    fn stress_factor(self, excess: f64) -> f64 {
        let l = 1.0 + excess;
        match self {
            Self::Uniaxial => excess * (l * l + l + 1.0) / l.powi(2),
            Self::Planar => excess * (l + 1.0) * (l * l + 1.0) / l.powi(3),
            Self::Equibiaxial => excess * (l + 1.0) * (l.powi(4) + l * l + 1.0) / l.powi(5),
        }
    }

    /// dg/dl.
    fn stress_factor_slope(self, stretch: f64) -> f64 {
        let l = stretch;
        match self {
            Self::Uniaxial => 1.0 + 2.0 * l.powi(-3),
            Self::Planar => 1.0 + 3.0 * l.powi(-4),
            Self::Equibiaxial => 1.0 + 5.0 * l.powi(-6),
        }
    }

    /// How many edges carry the nominal stress, so that `dW/dl = edges × stress`.
    pub fn loaded_edges(self) -> f64 {
        match self {
            Self::Uniaxial | Self::Planar => 1.0,
            Self::Equibiaxial => 2.0,
        }
    }
}
