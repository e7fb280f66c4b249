//! A body of revolution on its mount rod, with the silhouette that a camera near by sees.
//!
//! ```text
//!        ||      rod         S(s, θ) = (R cos θ, s, R sin θ),  normal n ~ (cos θ, -R', sin θ)
//!      .----.                line of sight from the eye E touches where  n · (S - E) = 0:
//!     (      ) R(s)
//!      '----'                Ex cos θ + Ez sin θ = R - R' (s - Ey)
//! ```
//!
//! The axis is y of the object's frame. At each place along it there are two such angles; between the ends their points are the outline, and at
//! the ends it is closed by the circles there. A sphere has its own ends: where the two angles are one.

use std::f64::consts::{PI, TAU};

use nalgebra::Vector3;

use pneuval_ingest::camera::picture::Place;

use super::camera::{Camera, View};
use super::canvas::{Layer, shoot};
use super::extras::{CORNERS, ellipse, scene};
use super::settings::Settings;
use super::{NoPhotograph, Photograph};

/// Places along the axis at which the outline is worked out: closer than a px.
const PLACES: usize = 3000;

/// Halvings that find where a silhouette ends.
const HALVINGS: usize = 60;

/// The rod goes so many times as far as the picture reaches.
const ROD_REACH: f64 = 1.5;

/// Shine: an upright spot, its middle and half axes in radii of the body.
const SHINE: ([f64; 2], [f64; 2]) = ([-0.5, 0.1], [0.08, 0.3]);

/// Radius along the axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Profile {
    /// Straight; half of its length beside the radius.
    Cylinder {
        /// In m.
        radius_m: f64,
        /// In m.
        length_m: f64,
    },
    /// R = r₀ + (rₘ - r₀)(1 - (2 s/L)²).
    Barrel {
        /// rₘ, in the middle, in m.
        middle_radius_m: f64,
        /// r₀, at the ends, in m.
        end_radius_m: f64,
        /// L, in m.
        length_m: f64,
    },
    /// A ball.
    Sphere {
        /// In m.
        radius_m: f64,
    },
}

/// A round body.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Body {
    /// Its radius along the axis.
    pub profile: Profile,
    /// The radius of the rod that it is mounted on, which comes from above; 0 is none.
    pub rod_radius_m: f64,
    /// How long a plate below it is, as wide as its lower end; 0 is none.
    pub foot_m: f64,
}

/// What is known of it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BodyTruth {
    /// The largest diameter, in m.
    pub diameter_m: f64,
}

impl Profile {
    /// Radius and its slope.
    fn at(&self, s: f64) -> (f64, f64) {
        match self {
            Self::Cylinder { radius_m, .. } => (*radius_m, 0.0),
            Self::Barrel { middle_radius_m, end_radius_m, length_m } => {
                let (part, rise) = (2.0 * s / length_m, middle_radius_m - end_radius_m);
                (end_radius_m + rise * (1.0 - part * part), -4.0 * rise * part / length_m)
            }
            Self::Sphere { radius_m } => {
                let radius = (radius_m * radius_m - s * s).max(0.0).sqrt();
                (radius, -s / radius.max(f64::MIN_POSITIVE))
            }
        }
    }

    fn half_length(&self) -> f64 {
        match self {
            Self::Cylinder { length_m, .. } | Self::Barrel { length_m, .. } => 0.5 * length_m,
            Self::Sphere { radius_m } => *radius_m,
        }
    }

    /// The largest radius, in m.
    pub fn radius_max_m(&self) -> f64 {
        match self {
            Self::Cylinder { radius_m, .. } | Self::Sphere { radius_m } => *radius_m,
            Self::Barrel { middle_radius_m, end_radius_m, .. } => middle_radius_m.max(*end_radius_m),
        }
    }

    fn is_sound(&self) -> bool {
        let positive = |all: &[f64]| all.iter().all(|x| *x > 0.0 && x.is_finite());
        match self {
            Self::Cylinder { radius_m, length_m } => positive(&[*radius_m, *length_m]),
            Self::Barrel { middle_radius_m, end_radius_m, length_m } => {
                positive(&[*middle_radius_m, *end_radius_m, *length_m])
            }
            Self::Sphere { radius_m } => positive(&[*radius_m]),
        }
    }
}

/// The two angles at which lines of sight touch at a place of the axis; `None` where they pass it by.
fn touching(profile: &Profile, eye: Vector3<f64>, s: f64) -> Option<[f64; 2]> {
    let (radius, slope) = profile.at(s);
    let across = eye.x.hypot(eye.z);
    let share = (radius - slope * (s - eye.y)) / across;
    let (middle, half) = (eye.z.atan2(eye.x), share.clamp(-1.0, 1.0).acos());
    (share.abs() <= 1.0).then_some([middle - half, middle + half])
}

/// The outlines of a profile between two places of its axis, as seen: its sides, and the circles of its ends.
fn outlines(view: &View, profile: &Profile, from: f64, to: f64) -> Result<Vec<Vec<Place>>, NoPhotograph> {
    let eye = view.eye;
    let is_seen = |s: f64| touching(profile, eye, s).is_some();
    let middle = 0.5 * (from + to);
    if !is_seen(middle) {
        return Err(NoPhotograph::Number("a body that the camera sees from its end alone: turn it"));
    }
    // Where the silhouette ends before the body does.
    let end = |out: f64| {
        if is_seen(out) {
            return out;
        }
        let (mut seen, mut unseen) = (middle, out);
        for _ in 0..HALVINGS {
            let half = 0.5 * (seen + unseen);
            if is_seen(half) { seen = half } else { unseen = half }
        }
        seen
    };
    let (first, last) = (end(from), end(to));
    let point = |s: f64, angle: f64| {
        let radius = profile.at(s).0;
        view.place(Vector3::new(radius * angle.cos(), s, radius * angle.sin()))
    };
    let (mut left, mut right) = (Vec::new(), Vec::new());
    for i in 0..=PLACES {
        // Closer at the ends, where the outline of a ball turns.
        let share = 0.5 - 0.5 * (PI * i as f64 / PLACES as f64).cos();
        let s = first + share * (last - first);
        let Some([a, b]) = touching(profile, eye, s) else { continue };
        left.push(point(s, a)?);
        right.push(point(s, b)?);
    }
    right.reverse();
    left.extend(right);
    let circle = |s: f64| (0..CORNERS).map(|i| point(s, i as f64 * TAU / CORNERS as f64)).collect::<Result<_, _>>();
    Ok(vec![left, circle(from)?, circle(to)?])
}

/// Photographs a round body.
///
/// # Errors
/// [`NoPhotograph`] for numbers that nothing has.
pub fn body(
    body: &Body,
    camera: &Camera,
    settings: &Settings,
    seed: u64,
) -> Result<Photograph<BodyTruth>, NoPhotograph> {
    let view = camera.checked()?.view();
    let radius = body.profile.radius_max_m();
    let rod = body.rod_radius_m;
    let is_length = body.foot_m >= 0.0 && body.foot_m.is_finite();
    if !body.profile.is_sound() || !(0.0..=radius).contains(&rod) || !is_length {
        return Err(NoPhotograph::Number("a body: expected radii and lengths above 0, and a rod that is no wider"));
    }
    let half = body.profile.half_length();
    if view.eye.x.hypot(view.eye.z) <= radius && view.eye.y.abs() <= half {
        return Err(NoPhotograph::Number("a camera within the body: move it away"));
    }
    let mut all = outlines(&view, &body.profile, -half, half)?;
    if rod > 0.0 {
        let reach = ROD_REACH * camera.metre_per_px() * camera.width.hypot_px(camera.height) + half;
        let rod = Profile::Cylinder { radius_m: rod, length_m: 2.0 * reach };
        all.extend(outlines(&view, &rod, -reach, 0.0)?);
    }
    let end_radius = body.profile.at(half).0;
    if body.foot_m > 0.0 && end_radius > 0.0 {
        let foot = Profile::Cylinder { radius_m: end_radius, length_m: body.foot_m };
        all.extend(outlines(&view, &foot, half, half + body.foot_m)?);
    }
    let layer = Layer { outlines: all, holes: vec![], light: settings.object, uneven: None };
    let (middle, size) = SHINE;
    let shine = ellipse(&view, middle.map(|x| x * radius), [size[0] * radius, size[1] * half.min(radius)])?;
    let scene = scene(camera, settings, vec![layer], Some(shine));
    shoot(camera, settings, &scene, seed, BodyTruth { diameter_m: 2.0 * radius })
}

/// The diagonal of a picture.
trait Diagonal {
    fn hypot_px(self, other: Self) -> f64;
}

impl Diagonal for usize {
    fn hypot_px(self, other: Self) -> f64 {
        (self as f64).hypot(other as f64)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn camera() -> Camera {
        Camera::facing(1280, 960, 5e-5, 0.3)
    }

    /// The largest half width of an outline, in px.
    fn half_width(camera: &Camera, profile: Profile) -> f64 {
        let view = camera.view();
        let half = profile.half_length();
        let outline = outlines(&view, &profile, -half, half).unwrap().concat();
        let xs = outline.iter().map(|at| at.x);
        let (from, to) = xs.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), x| (a.min(x), b.max(x)));
        0.5 * (to - from)
    }

    #[test]
    fn ball_and_cylinder_look_wider_by_the_closed_form() {
        let (camera, radius_m) = (camera(), 0.02);
        // R/√(1 - (R/Z)²), in the plane of the middle.
        let wider = 1.0 / (1.0 - (0.02_f64 / 0.3).powi(2)).sqrt();
        let truth = radius_m / 5e-5 * wider;
        for profile in [Profile::Sphere { radius_m }, Profile::Cylinder { radius_m, length_m: 0.01 }] {
            let seen = half_width(&camera, profile);
            assert!((seen - truth).abs() < 1e-4, "{profile:?}: {seen} {truth}");
        }
        // A barrel is widest in its middle, where it is a cylinder; a tilt about the line of sight turns it only.
        let barrel = Profile::Barrel { middle_radius_m: 0.02, end_radius_m: 0.016, length_m: 0.03 };
        assert!((half_width(&camera, barrel) - truth).abs() < 1e-3);
        // A ball looks the same from all sides, and off the axis its silhouette is an ellipse: (R/Z) Z²/(Z² - R²) across.
        let turned = Camera { tilt_rad: [0.3, -0.2], roll_rad: 0.4, ..camera };
        assert!((half_width(&turned, Profile::Sphere { radius_m }) - truth).abs() < 1e-3);
        let aside = Camera { shift_m: [0.03, 0.0], ..camera };
        let expected = 6000.0 * 0.02 * (0.03_f64.powi(2) + 0.09 - 4e-4).sqrt() / (0.09 - 4e-4);
        assert!((half_width(&aside, Profile::Sphere { radius_m }) - expected).abs() < 1e-3);
    }

    #[test]
    fn every_point_of_an_outline_is_on_a_line_of_sight_that_touches() {
        let camera = Camera { tilt_rad: [0.05, 0.1], shift_m: [0.004, -0.002], ..camera() };
        let view = camera.view();
        let barrel = Profile::Barrel { middle_radius_m: 0.02, end_radius_m: 0.015, length_m: 0.04 };
        for i in -9..=9 {
            let s = 0.002 * f64::from(i);
            for angle in touching(&barrel, view.eye, s).unwrap() {
                let (radius, slope) = barrel.at(s);
                let point = Vector3::new(radius * angle.cos(), s, radius * angle.sin());
                let normal = Vector3::new(angle.cos(), -slope, angle.sin());
                assert!((point - view.eye).dot(&normal).abs() < 1e-15);
            }
        }
    }

    #[test]
    fn a_foot_goes_on_as_wide_as_the_end_and_a_rod_up_to_the_border() {
        let camera = Camera::facing(240, 320, 2e-4, 0.3);
        let settings = Settings { noise: 0.0, ..Settings::default() };
        let cylinder = |length_m| Profile::Cylinder { radius_m: 0.01, length_m };
        let shot = |body: &Body, camera: &Camera| super::body(body, camera, &settings, 1).unwrap().picture;
        let whole = shot(&Body { profile: cylinder(0.04), rod_radius_m: 0.0, foot_m: 0.0 }, &camera);
        // The same in two pieces, moved so that it is where the whole is.
        let moved = Camera { shift_m: [0.0, -0.01], ..camera };
        let pieces = shot(&Body { profile: cylinder(0.02), rod_radius_m: 0.0, foot_m: 0.02 }, &moved);
        let off = (0..240 * 320).map(|i| (whole.luma(i % 240, i / 240) - pieces.luma(i % 240, i / 240)).abs());
        assert!(off.fold(0.0, f32::max) <= 1.0);
        assert!(whole.luma(120, 2) > 150.0 && whole.luma(120, 160) < 100.0);
        // A rod as wide as the body leaves it as wide.
        let same = shot(&Body { profile: cylinder(0.04), rod_radius_m: 0.01, foot_m: 0.0 }, &camera);
        assert!((0..240).all(|x| (same.luma(x, 120) - whole.luma(x, 120)).abs() <= 1.0));
        let rod = shot(&Body { profile: cylinder(0.04), rod_radius_m: 0.003, foot_m: 0.0 }, &camera);
        assert!(rod.luma(120, 0) < 100.0 && rod.luma(140, 0) > 150.0 && rod.luma(120, 319) > 150.0);
    }

    #[test]
    fn bodies_that_cannot_be_are_refused() {
        let refused = |profile, rod_radius_m| {
            body(&Body { profile, rod_radius_m, foot_m: 0.0 }, &camera(), &Settings::default(), 1).is_err()
        };
        let ball = |radius_m| Profile::Sphere { radius_m };
        assert!(refused(ball(f64::NAN), 0.0) && refused(ball(-0.1), 0.0) && refused(ball(0.0), 0.0));
        assert!(refused(ball(0.01), 0.02) && refused(ball(0.01), f64::NAN));
        assert!(refused(ball(0.4), 0.0), "the camera stands within it");
        let barrel = Profile::Barrel { middle_radius_m: 0.02, end_radius_m: 0.01, length_m: f64::INFINITY };
        assert!(refused(barrel, 0.0));
        let from_the_end = Camera { tilt_rad: [1.57, 0.0], ..camera() };
        let cylinder =
            Body { profile: Profile::Cylinder { radius_m: 0.02, length_m: 0.01 }, rod_radius_m: 0.0, foot_m: 0.0 };
        assert!(body(&cylinder, &from_the_end, &Settings::default(), 1).is_err());
    }
}
