//! The papers' actuators, one module per type, each equation in its printed and its consistent form; and any actuator that bends
//! with constant curvature.

pub mod constant_curvature;
pub mod dual_chamber_finger;
pub mod fruit_finger;
pub mod internal_support;
pub mod pdms_wall;
pub mod wave_finger;
