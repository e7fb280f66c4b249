//! Lengths, angles and areas from pictures.

pub mod area;
pub mod bending;
pub mod calibrate;
pub mod chessboard;
mod curve;
pub mod decode;
pub mod diameter;
pub mod edge;
pub mod lens;
pub mod opencv;
pub mod photograph;
pub mod picture;
pub mod rows;
pub mod scale;
pub mod silhouette;
pub mod task;
#[cfg(test)]
mod testing;
pub mod tone;
