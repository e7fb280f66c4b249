//! The papers' actuators: one module per type, each equation in its printed and its consistent form.

pub mod dual_chamber_finger;
pub mod internal_support;
