//! A bending finger seen from the side, flat in the object's plane.
//!
//! ```text
//!   ######  mount          along: down (y of the object's frame), where the finger points at rest
//!    |  )                  across: to the right (x), where it bends
//!    |  )  waves           the centreline is bent over its length less half of its width;
//!     \  )                 there the round end begins, which goes on straight: its end is the tip
//!      `-'
//! ```

use std::f64::consts::PI;

use nalgebra::{Vector2, Vector3};

use pneuval_ingest::camera::picture::Place;

use super::camera::{Camera, View};
use super::canvas::{Layer, shoot};
use super::extras::{CORNERS, ellipse, scene};
use super::settings::{Rgb, Settings};
use super::{NoPhotograph, Photograph};

/// Steps along the centreline.
const STEPS: usize = 4000;

/// The mount, in widths of the finger: half of its breadth, and its height, which goes beyond the border.
const MOUNT: (f64, f64) = (1.0, 10.0);

/// Shine: where along the finger, and its half axes in widths.
const SHINE: (f64, [f64; 2]) = (0.4, [0.08, 0.3]);

/// Curvature along the centreline, which goes from 0 at the mount to 1 where the round end begins.
#[derive(Debug, Clone, PartialEq)]
pub enum Bending {
    /// The same everywhere: the angle at the end, in rad.
    Constant(f64),
    /// At even steps from mount to end, straight lines between them, in 1/m.
    Given(Vec<f64>),
}

/// A finger.
#[derive(Debug, Clone, PartialEq)]
pub struct Finger {
    /// How it is bent.
    pub bending: Bending,
    /// From the mount to the tip along the centreline, in m.
    pub length_m: f64,
    /// Across, in m.
    pub width_m: f64,
    /// How many waves its outer side (left, where it is bent to the right) has, and their height in m.
    pub waves: (usize, f64),
    /// Its markers.
    pub markers: Vec<Marker>,
}

/// A round marker on the centreline.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Marker {
    /// From the mount along the centreline, in m.
    pub at_m: f64,
    /// In m.
    pub radius_m: f64,
    /// Its colour.
    pub light: Rgb,
}

/// What is known of it.
#[derive(Debug, Clone, PartialEq)]
pub struct FingerTruth {
    /// From the direction at the mount to that at the tip, in rad.
    pub angle_rad: f64,
    /// From the mount to the tip, along and across, in m.
    pub tip_m: [f64; 2],
    /// Where the tip is seen.
    pub tip_px: Place,
    /// Where the middle of the mount's edge is seen.
    pub root_px: Place,
    /// Along the centreline, in m.
    pub length_m: f64,
    /// Where the middles of markers are, along and across, in m, and where they are seen.
    pub markers: Vec<([f64; 2], Place)>,
}

/// The centreline, in the object's frame.
struct Centreline {
    step_m: f64,
    /// Place and direction (from y towards x, in rad) at each step.
    points: Vec<(Vector2<f64>, f64)>,
}

impl Bending {
    /// At a share of the bent length.
    fn curvature(&self, share: f64, bent_m: f64) -> f64 {
        match self {
            Self::Constant(angle) => angle / bent_m,
            Self::Given(all) => {
                let place = share * (all.len() - 1) as f64;
                #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a share of a length")]
                let i = (place as usize).min(all.len().saturating_sub(2));
                let next = all.get(i + 1).unwrap_or(&all[i]);
                all[i] + (place - i as f64) * (next - all[i])
            }
        }
    }
}

fn way(angle: f64) -> Vector2<f64> {
    Vector2::new(angle.sin(), angle.cos())
}

impl Centreline {
    fn new(finger: &Finger) -> Self {
        let bent_m = finger.length_m - 0.5 * finger.width_m;
        let step_m = bent_m / STEPS as f64;
        let mut points = vec![(Vector2::zeros(), 0.0)];
        let (mut at, mut angle) = (Vector2::zeros(), 0.0);
        for i in 0..STEPS {
            let of = |part: f64| finger.bending.curvature((i as f64 + part) / STEPS as f64, bent_m);
            // An arc over each step: exact where the curvature is constant.
            let turn = step_m * of(0.5);
            let chord = if turn.abs() < 1e-6 { 1.0 - turn * turn / 24.0 } else { 2.0 * (0.5 * turn).sin() / turn };
            at += step_m * chord * way(angle + 0.5 * turn);
            angle += turn;
            points.push((at, angle));
        }
        Self { step_m, points }
    }

    fn end(&self) -> (Vector2<f64>, f64) {
        self.points[self.points.len() - 1]
    }

    /// At a length from the mount; straight on behind the bent part.
    fn at(&self, length_m: f64) -> (Vector2<f64>, f64) {
        let place = length_m / self.step_m;
        let (end, angle) = self.end();
        if place >= STEPS as f64 {
            return (end + (length_m - self.step_m * STEPS as f64) * way(angle), angle);
        }
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "between nought and STEPS")]
        let i = place.max(0.0) as usize;
        let ((a, from), (b, to)) = (self.points[i], self.points[i + 1]);
        let part = place - i as f64;
        (a + part * (b - a), from + part * (to - from))
    }
}

impl Finger {
    fn checked(&self) -> Result<&Self, NoPhotograph> {
        let Self { bending, length_m, width_m, waves, markers } = self;
        let bends = match bending {
            Bending::Constant(angle) => angle.is_finite(),
            Bending::Given(all) => !all.is_empty() && all.iter().all(|curvature| curvature.is_finite()),
        };
        if !bends || !length_m.is_finite() || *width_m <= 0.0 || *length_m <= *width_m || width_m.is_nan() {
            let expected = "a finger: expected finite curvatures, a width above 0 and a length above it";
            return Err(NoPhotograph::Number(expected));
        }
        let marked = |marker: &Marker| marker.radius_m > 0.0 && (0.0..=*length_m).contains(&marker.at_m);
        if !(0.0..=*width_m).contains(&waves.1) || !markers.iter().all(marked) {
            return Err(NoPhotograph::Number("waves and markers of a finger: expected ones that lie on it"));
        }
        Ok(self)
    }

    /// Its outline, from the mount down the outer side, round the end, and up again.
    fn outline(&self, line: &Centreline, view: &View) -> Result<Vec<Place>, NoPhotograph> {
        let half = 0.5 * self.width_m;
        let left = |angle: f64| Vector2::new(-angle.cos(), angle.sin());
        let mut outline = Vec::new();
        for (i, (at, angle)) in line.points.iter().enumerate() {
            let phase = 2.0 * PI * self.waves.0 as f64 * i as f64 / STEPS as f64;
            let wave = 0.5 * self.waves.1 * (1.0 - phase.cos());
            outline.push(at + (half + wave) * left(*angle));
        }
        let (end, angle) = line.end();
        outline.extend((1..CORNERS).map(|i| {
            let (sin, cos) = (PI * i as f64 / CORNERS as f64).sin_cos();
            end + half * (cos * left(angle) + sin * way(angle))
        }));
        outline.extend(line.points.iter().rev().map(|(at, angle)| at - half * left(*angle)));
        outline.iter().map(|at| view.flat(at.x, at.y)).collect()
    }
}

/// Photographs a finger.
///
/// # Errors
/// [`NoPhotograph`] for numbers that nothing has.
pub fn finger(
    finger: &Finger,
    camera: &Camera,
    settings: &Settings,
    seed: u64,
) -> Result<Photograph<FingerTruth>, NoPhotograph> {
    let view = camera.checked()?.view();
    let line = Centreline::new(finger.checked()?);
    let width = finger.width_m;
    let mount = [(-MOUNT.0, -MOUNT.1), (MOUNT.0, -MOUNT.1), (MOUNT.0, 0.0), (-MOUNT.0, 0.0)];
    let mount = mount.iter().map(|(x, y)| view.flat(x * width, y * width)).collect::<Result<_, _>>()?;
    let outlines = vec![mount, finger.outline(&line, &view)?];
    let mut layers = vec![Layer { outlines, holes: vec![], light: settings.object, uneven: None }];
    let mut markers = Vec::new();
    for marker in &finger.markers {
        let (at, _) = line.at(marker.at_m);
        layers.push(Layer::of(ellipse(&view, at.into(), [marker.radius_m; 2])?, marker.light));
        markers.push(([at.y, at.x], view.flat(at.x, at.y)?));
    }
    let (tip, angle_rad) = line.at(finger.length_m);
    let (spot, _) = line.at(SHINE.0 * finger.length_m);
    let shine = ellipse(&view, spot.into(), SHINE.1.map(|half| half * width))?;
    let truth = FingerTruth {
        angle_rad,
        tip_m: [tip.y, tip.x],
        tip_px: view.flat(tip.x, tip.y)?,
        root_px: view.place(Vector3::zeros())?,
        length_m: finger.length_m,
        markers,
    };
    shoot(camera, settings, &scene(camera, settings, layers, Some(shine)), seed, truth)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn straight() -> Finger {
        Finger { bending: Bending::Constant(0.0), length_m: 0.05, width_m: 0.01, waves: (0, 0.0), markers: vec![] }
    }

    fn camera() -> Camera {
        Camera { shift_m: [0.0, -0.02], ..Camera::facing(640, 640, 1e-4, 0.4) }
    }

    fn shot(of: &Finger) -> Photograph<FingerTruth> {
        let settings = Settings { noise: 0.0, background: [0.8; 3], object: [0.0; 3], ..Settings::default() };
        finger(of, &camera(), &settings, 1).unwrap()
    }

    #[test]
    fn a_straight_finger_hangs_down_to_its_length_and_is_as_wide_as_it_is() {
        let marker = Marker { at_m: 0.03, radius_m: 0.002, light: [0.9; 3] };
        let Photograph { picture, truth } = shot(&Finger { markers: vec![marker], ..straight() });
        assert!(truth.angle_rad.abs() < 1e-15 && (truth.tip_m[0] - 0.05).abs() < 1e-12 && truth.tip_m[1].abs() < 1e-15);
        let root = Place::new(319.5, 119.5);
        assert!((truth.root_px - root).norm() < 1e-9 && (truth.tip_px - root - Place::new(0.0, 500.0)).norm() < 1e-6);
        assert!((truth.markers[0].1 - root - Place::new(0.0, 300.0)).norm() < 1e-6);
        // 100 px across where there is no marker.
        let dark: f64 = (0..640).map(|x| 1.0 - f64::from(picture.luma(x, 300)) / 204.0).sum();
        assert!((dark - 100.0).abs() < 0.05, "{dark}");
        assert!(picture.luma(320, 420) > 200.0, "the marker is bright");
        // Down to the tip.
        let dark: f64 = (500..640).map(|y| 1.0 - f64::from(picture.luma(319, y)) / 204.0).sum();
        assert!((dark - 120.0).abs() < 0.05, "{dark}");
    }

    #[test]
    fn a_bent_finger_ends_where_its_arc_does() {
        for angle in [0.3, 1.5, -0.7, 3.0] {
            let truth = shot(&Finger { bending: Bending::Constant(angle), ..straight() }).truth;
            let radius = 0.045 / angle;
            let tip = [radius * angle.sin() + 0.005 * angle.cos(), radius * (1.0 - angle.cos()) + 0.005 * angle.sin()];
            assert!((truth.angle_rad - angle).abs() < 1e-12);
            assert!((0..2).all(|i| (truth.tip_m[i] - tip[i]).abs() < 1e-9), "{:?} {tip:?}", truth.tip_m);
        }
        // A curvature that rises from nought to k turns by half of k L, and one that is the same is constant.
        let of = |all: Vec<f64>| shot(&Finger { bending: Bending::Given(all), ..straight() }).truth;
        assert!((of(vec![0.0, 20.0]).angle_rad - 0.45).abs() < 1e-12);
        assert!((of(vec![20.0]).tip_m[1] - of(vec![20.0, 20.0, 20.0]).tip_m[1]).abs() < 1e-12);
        assert!((of(vec![20.0]).angle_rad - 0.9).abs() < 1e-12);
    }

    #[test]
    fn waves_are_on_the_outer_side_only() {
        let dark = |of: &Finger, from: usize, to: usize| -> f64 {
            let picture = shot(of).picture;
            let row = |y: usize| (from..to).map(|x| 1.0 - f64::from(picture.luma(x, y)) / 204.0).sum::<f64>();
            (150..550).map(row).sum()
        };
        let waved = Finger { waves: (5, 0.002), ..straight() };
        assert!(dark(&waved, 0, 320) > dark(&straight(), 0, 320) + 3000.0);
        assert!((dark(&waved, 320, 640) - dark(&straight(), 320, 640)).abs() < 1.0);
    }

    #[test]
    fn fingers_that_cannot_be_are_refused() {
        let refused = |of: Finger| finger(&of, &camera(), &Settings::default(), 1).is_err();
        assert!(refused(Finger { width_m: 0.06, ..straight() }) && refused(Finger { width_m: f64::NAN, ..straight() }));
        assert!(refused(Finger { bending: Bending::Given(vec![]), ..straight() }));
        assert!(refused(Finger { bending: Bending::Constant(f64::INFINITY), ..straight() }));
        let marker = Marker { at_m: 0.07, radius_m: 0.001, light: [1.0; 3] };
        assert!(refused(Finger { markers: vec![marker], ..straight() }));
    }
}
