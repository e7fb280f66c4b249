//! Homogeneous deformations of an incompressible block: its invariants, and the stress they lead to.

use crate::ModelError;

/// A homogeneous deformation of an incompressible block, told by one stretch l.
///
/// | case | principal stretches | `I1 - 3` | `I2 - 3` | dW/dl |
/// |---|---|---|---|---|
/// | uniaxial | l, l^-1/2, l^-1/2 | (l-1)² (l+2)/l | (l-1)² (2l+1)/l² | nominal stress |
/// | planar | l, 1, 1/l | (l - 1/l)² | (l - 1/l)² | nominal stress |
/// | equibiaxial | l, l, l^-2 | (l²-1)² (2l²+1)/l⁴ | (l²-1)² (l²+2)/l² | 2 × nominal stress (two loaded edges) |
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

    /// The load case in a word.
    pub fn name(self) -> &'static str {
        match self {
            Self::Uniaxial => "uniaxial",
            Self::Planar => "planar",
            Self::Equibiaxial => "equibiaxial",
        }
    }

    /// The load case of a name.
    pub fn find(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|case| case.name() == name)
    }

    /// `I1 - 3` at stretch `1 + excess`, factored so that nothing cancels near the undeformed state.
    pub fn i1_minus_3(self, excess: f64) -> f64 {
        let l = 1.0 + excess;
        match self {
            Self::Uniaxial => excess * excess * (l + 2.0) / l,
            Self::Planar => (excess * (l + 1.0) / l).powi(2),
            Self::Equibiaxial => (excess * (l + 1.0)).powi(2) * (2.0 * l * l + 1.0) / l.powi(4),
        }
    }

    /// `I2 - 3` at stretch `1 + excess`, factored in the same way.
    pub fn i2_minus_3(self, excess: f64) -> f64 {
        let l = 1.0 + excess;
        match self {
            Self::Uniaxial => excess * excess * (2.0 * l + 1.0) / (l * l),
            Self::Planar => self.i1_minus_3(excess),
            Self::Equibiaxial => (excess * (l + 1.0)).powi(2) * (l * l + 2.0) / (l * l),
        }
    }

    /// How many edges carry the nominal stress, so that `dW/dl = edges × stress`.
    pub fn loaded_edges(self) -> f64 {
        match self {
            Self::Uniaxial | Self::Planar => 1.0,
            Self::Equibiaxial => 2.0,
        }
    }

    /// The geometric factor g of `nominal stress = 2 g (W1 + c W2)`: `l - l^-2`, `l - l^-3` or `l - l^-5`.
    /// Also half the slope of I1 for each loaded edge.
    pub(super) fn stress_factor(self, excess: f64) -> f64 {
        let l = 1.0 + excess;
        match self {
            Self::Uniaxial => excess * (l * l + l + 1.0) / l.powi(2),
            Self::Planar => excess * (l + 1.0) * (l * l + 1.0) / l.powi(3),
            Self::Equibiaxial => excess * (l + 1.0) * (l.powi(4) + l * l + 1.0) / l.powi(5),
        }
    }

    /// dg/dl.
    pub(super) fn stress_factor_slope(self, stretch: f64) -> f64 {
        let l = stretch;
        match self {
            Self::Uniaxial => 1.0 + 2.0 * l.powi(-3),
            Self::Planar => 1.0 + 3.0 * l.powi(-4),
            Self::Equibiaxial => 1.0 + 5.0 * l.powi(-6),
        }
    }

    /// The weight c of W2 beside W1: `1/l`, 1 or `l²`.
    pub(super) fn second_weight(self, stretch: f64) -> f64 {
        match self {
            Self::Uniaxial => 1.0 / stretch,
            Self::Planar => 1.0,
            Self::Equibiaxial => stretch * stretch,
        }
    }

    /// dc/dl.
    fn second_weight_slope(self, stretch: f64) -> f64 {
        match self {
            Self::Uniaxial => -1.0 / (stretch * stretch),
            Self::Planar => 0.0,
            Self::Equibiaxial => 2.0 * stretch,
        }
    }

    /// Nominal stress `2 g (W1 + c W2)` at stretch `1 + excess`, in Pa.
    pub(super) fn nominal_stress_pa(self, excess: f64, slopes: Slopes) -> f64 {
        2.0 * self.stress_factor(excess) * (slopes.w1_pa + self.second_weight(1.0 + excess) * slopes.w2_pa)
    }

    /// Its slope `2 g' (W1 + c W2) + 2 g (W11 dI1/dl + c' W2)`, in Pa.
    pub(super) fn tangent_pa(self, excess: f64, slopes: Slopes) -> f64 {
        let stretch = 1.0 + excess;
        let factor = self.stress_factor(excess);
        let i1_slope = 2.0 * self.loaded_edges() * factor;
        let first = slopes.w1_pa + self.second_weight(stretch) * slopes.w2_pa;
        let second = slopes.w11_pa * i1_slope + self.second_weight_slope(stretch) * slopes.w2_pa;
        2.0 * self.stress_factor_slope(stretch) * first + 2.0 * factor * second
    }
}

/// Slopes of an energy that is linear in I2, in Pa.
#[derive(Debug, Clone, Copy)]
pub(super) struct Slopes {
    /// W1 = dW/dI1.
    pub w1_pa: f64,
    /// W2 = dW/dI2, a constant.
    pub w2_pa: f64,
    /// W11 = d²W/dI1².
    pub w11_pa: f64,
}

/// `stretch - 1` of a stretch that a block can have.
///
/// # Errors
/// [`ModelError::OutOfDomain`] if the stretch is not finite and positive.
pub(super) fn excess(stretch: f64) -> Result<f64, ModelError> {
    if stretch.is_finite() && stretch > 0.0 {
        Ok(stretch - 1.0)
    } else {
        Err(ModelError::OutOfDomain { symbol: "stretch", value: stretch, domain: "finite and > 0" })
    }
}

/// A result of a law, if it is a number.
///
/// # Errors
/// [`ModelError::OutOfDomain`] if it overflowed.
pub(super) fn finite(value: f64, stretch: f64) -> Result<f64, ModelError> {
    if value.is_finite() {
        Ok(value)
    } else {
        Err(ModelError::OutOfDomain {
            symbol: "stretch",
            value: stretch,
            domain: "near enough to 1 for the law's numbers to stay finite",
        })
    }
}
