//! Photographs with known truth: numbers in, a picture and what it shows out.
//!
//! ```text
//! object --> outline seen by the camera (true perspective, tilt, lens) --> covered areas --> pixels and blur, in linear light
//!        --> fall-off of the light --> tone curve --> noise --> steps of 8 or 16 bits --> file
//! ```
//!
//! | file | holds |
//! |---|---|
//! | `camera.rs` | where a point of the object is seen |
//! | `body.rs` | a body of revolution on its mount rod |
//! | `finger.rs` | a bending finger from the side, with or without markers |
//! | `imprint.rs`, `shape.rs` | paint on paper, and the area of shapes with holes |
//! | `scales.rs` | chessboard, disc, ruler |
//! | `canvas.rs`, `cover.rs` | from outlines to light at pixels |
//! | `settings.rs` | lens blur, light, noise, depth |
//! | `extras.rs` | shine, a cable |
//! | `write.rs` | PNG, JPEG, TIFF |
//!
//! The camera looks along z, x to the right and y down, as a picture has them. The object has a frame of its own, in m, whose origin is
//! on the optical axis at the camera's distance unless it is shifted. Everything depends on the numbers and the seed alone.

mod body;
mod camera;
mod canvas;
mod cover;
mod extras;
mod finger;
mod imprint;
mod scales;
mod settings;
mod shape;
mod write;

use pneuval_ingest::camera::picture::Picture;

pub use body::{Body, BodyTruth, Profile, body};
pub use camera::Camera;
pub use canvas::{Layer, Scene, Uneven};
pub use finger::{Bending, Finger, FingerTruth, Marker, finger};
pub use imprint::{Imprint, ImprintTruth, imprint};
pub use scales::{Object, ScaleTruth, scale_only};
pub use settings::{Depth, Light, Rgb, Settings, Tone};
pub use shape::{Shape, area_m2};
pub use write::{File, bytes};

/// A picture and what it shows.
#[derive(Debug, Clone, PartialEq)]
pub struct Photograph<T> {
    /// The picture.
    pub picture: Picture,
    /// What nobody at a rig would know.
    pub truth: T,
}

/// Why there is no photograph.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum NoPhotograph {
    /// No picture is that large or small.
    #[error("a picture of {width} x {height} px: expected 1 px to {} million", canvas::PIXELS_MAX / 1_000_000)]
    Size {
        /// In px.
        width: usize,
        /// In px.
        height: usize,
    },
    /// A number that cannot be.
    #[error("{0}")]
    Number(&'static str),
    /// A part of the object is behind the camera, or around it.
    #[error("the object reaches behind the camera: move it away")]
    Behind,
    /// A file that cannot be written.
    #[error("a picture cannot be written as {0}")]
    File(&'static str),
}
