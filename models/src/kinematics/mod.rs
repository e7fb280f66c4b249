//! Shapes: from the state of a model to lengths, areas and their derivatives.

pub mod arc;
pub mod constant_curvature;
