//! What photographs have that nobody wants: shine, a cable.

use std::f64::consts::TAU;

use pneuval_ingest::camera::picture::Place;

use super::NoPhotograph;
use super::camera::{Camera, View};
use super::canvas::{Layer, Scene};
use super::settings::{Rgb, Settings};

/// Corners of a round outline.
pub(super) const CORNERS: usize = 720;

/// A cable: its width and how far it hangs in, as shares of the picture's width, and its light.
const CABLE_WIDTH: f64 = 0.008;
const CABLE_REACH: f64 = 0.05;
const CABLE: Rgb = [0.04; 3];

/// The scene of an object: what lies behind, a cable if there is one, the object, the shine on it.
pub(super) fn scene(camera: &Camera, settings: &Settings, object: Vec<Layer>, shine: Option<Vec<Place>>) -> Scene {
    let mut layers = Vec::new();
    if settings.clutter {
        layers.push(Layer::of(cable(camera), CABLE));
    }
    layers.extend(object);
    if let Some(outline) = shine.filter(|_| settings.glare > 0.0) {
        #[expect(clippy::cast_possible_truncation, reason = "a share")]
        let glare = settings.glare as f32;
        layers.push(Layer::of(outline, settings.object.map(|share| share + glare * (1.0 - share))));
    }
    Scene { background: settings.background, layers }
}

/// A bow from the upper left border to the lower one.
fn cable(camera: &Camera) -> Vec<Place> {
    let (width, height) = (camera.width as f64, camera.height as f64);
    let half = 0.5 * CABLE_WIDTH * width;
    let middle = |t: f64| Place::new(CABLE_REACH * width * 4.0 * t * (1.0 - t) - half, t * height);
    let way = |t: f64| Place::new(CABLE_REACH * width * 4.0 * (1.0 - 2.0 * t), height).normalize();
    let side = |i: usize, sign: f64| {
        let t = -0.05 + 1.1 * i as f64 / CORNERS as f64;
        middle(t) + sign * half * Place::new(way(t).y, -way(t).x)
    };
    (0..=CORNERS).map(|i| side(i, 1.0)).chain((0..=CORNERS).rev().map(|i| side(i, -1.0))).collect()
}

/// An ellipse in the object's plane as it is seen.
pub(super) fn ellipse(view: &View, middle_m: [f64; 2], half_m: [f64; 2]) -> Result<Vec<Place>, NoPhotograph> {
    let at = |i: usize| {
        let (sin, cos) = (i as f64 * TAU / CORNERS as f64).sin_cos();
        view.flat(middle_m[0] + half_m[0] * cos, middle_m[1] + half_m[1] * sin)
    };
    (0..CORNERS).map(at).collect()
}
