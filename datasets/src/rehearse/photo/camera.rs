//! Where a point of the object is seen.

use nalgebra::{Matrix3, Rotation3, Vector3};

use pneuval_ingest::camera::lens::Lens;
use pneuval_ingest::camera::picture::Place;

use super::NoPhotograph;

/// A camera before an object.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Camera {
    /// Focal length, principal point and distortion (Brown and Conrady, as of `OpenCV`).
    pub lens: Lens,
    /// In px.
    pub width: usize,
    /// In px.
    pub height: usize,
    /// From the camera's centre to the plane through the object's origin, in m.
    pub distance_m: f64,
    /// How far that origin lies to the right of the optical axis and below it, in m.
    pub shift_m: [f64; 2],
    /// The object is turned about the optical axis, clockwise as it is seen, in rad.
    pub roll_rad: f64,
    /// Before that it is tilted: about x (its lower end comes nearer), then about y (its right side goes away), in rad.
    pub tilt_rad: [f64; 2],
}

impl Camera {
    /// A pinhole that sees so many m in a px at its distance, straight before the object.
    pub fn facing(width: usize, height: usize, metre_per_px: f64, distance_m: f64) -> Self {
        let centre = Place::new(0.5 * (width as f64 - 1.0), 0.5 * (height as f64 - 1.0));
        Self {
            lens: Lens::pinhole(distance_m / metre_per_px, centre),
            width,
            height,
            distance_m,
            shift_m: [0.0; 2],
            roll_rad: 0.0,
            tilt_rad: [0.0; 2],
        }
    }

    /// Metres in a px in the plane through the object's origin, square to the optical axis.
    pub fn metre_per_px(&self) -> f64 {
        self.distance_m / self.lens.focal_px.mean()
    }

    /// # Errors
    /// For numbers that no camera has.
    pub(super) fn checked(&self) -> Result<&Self, NoPhotograph> {
        let Self { lens, distance_m, shift_m, roll_rad, tilt_rad, .. } = self;
        let numbers = [lens.focal_px.x, lens.focal_px.y, lens.centre_px.x, lens.centre_px.y, *distance_m, *roll_rad];
        let mut all = numbers.iter().chain(&lens.radial).chain(&lens.tangential).chain(shift_m).chain(tilt_rad);
        if all.any(|number| !number.is_finite()) || lens.focal_px.min() <= 0.0 || *distance_m <= 0.0 {
            return Err(NoPhotograph::Number("the camera: expected finite numbers, focal length and distance above 0"));
        }
        Ok(self)
    }

    /// From the object's frame to the camera's.
    fn turn(&self) -> Matrix3<f64> {
        let about = |axis, angle| Rotation3::from_axis_angle(&axis, angle);
        let roll = about(Vector3::z_axis(), self.roll_rad);
        let tilt = about(Vector3::y_axis(), self.tilt_rad[1]) * about(Vector3::x_axis(), self.tilt_rad[0]);
        (roll * tilt).into_inner()
    }

    fn origin(&self) -> Vector3<f64> {
        Vector3::new(self.shift_m[0], self.shift_m[1], self.distance_m)
    }

    /// Where points of the object are seen.
    pub(super) fn view(&self) -> View<'_> {
        let turn = self.turn();
        View { lens: &self.lens, turn, origin: self.origin(), eye: -(turn.transpose() * self.origin()) }
    }
}

/// A camera with its turn worked out.
pub(super) struct View<'c> {
    lens: &'c Lens,
    turn: Matrix3<f64>,
    origin: Vector3<f64>,
    /// The camera's centre in the object's frame.
    pub eye: Vector3<f64>,
}

impl View<'_> {
    /// Where a point of the object is seen, in px.
    pub fn place(&self, point: Vector3<f64>) -> Result<Place, NoPhotograph> {
        let at = self.lens.project(self.turn * point + self.origin).ok_or(NoPhotograph::Behind)?;
        if at.x.is_finite() && at.y.is_finite() { Ok(at) } else { Err(NoPhotograph::Behind) }
    }

    /// Where a point of the object's own plane is seen.
    pub fn flat(&self, x: f64, y: f64) -> Result<Place, NoPhotograph> {
        self.place(Vector3::new(x, y, 0.0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn turns_go_the_way_that_their_names_say() {
        let camera = Camera::facing(640, 480, 1e-4, 0.3);
        let middle = camera.lens.centre_px;
        let seen = |camera: &Camera, x, y| camera.view().flat(x, y).unwrap() - middle;
        assert!((seen(&camera, 0.01, 0.02) - Place::new(100.0, 200.0)).norm() < 1e-9);
        // A quarter turn clockwise: the right goes down.
        let rolled = Camera { roll_rad: std::f64::consts::FRAC_PI_2, ..camera };
        assert!((seen(&rolled, 0.01, 0.0) - Place::new(0.0, 100.0)).norm() < 1e-9);
        // What is nearer is larger: at 0.3 - 0.02 sin t.
        let tilted = Camera { tilt_rad: [-0.2, 0.0], ..camera };
        let y = 0.3e4 * 0.02 * 0.2_f64.cos() / (0.3 - 0.02 * 0.2_f64.sin());
        assert!((seen(&tilted, 0.0, 0.02).y - y).abs() < 1e-9);
        let right_away = Camera { tilt_rad: [0.0, -0.2], ..camera };
        assert!(seen(&right_away, 0.02, 0.0).x < 200.0 * 0.2_f64.cos());
        assert!((camera.metre_per_px() - 1e-4).abs() < 1e-18);
        // The camera's centre is where it stands.
        assert!((rolled.view().eye - Vector3::new(0.0, 0.0, -0.3)).norm() < 1e-15);
    }

    #[test]
    fn what_lies_behind_the_camera_is_refused() {
        let camera = Camera { tilt_rad: [1.5, 0.0], ..Camera::facing(64, 48, 1e-4, 0.01) };
        assert_eq!(camera.view().flat(0.0, -0.1), Err(NoPhotograph::Behind));
        assert!(Camera { distance_m: f64::NAN, ..camera }.checked().is_err());
        assert!(Camera { distance_m: 0.0, ..camera }.checked().is_err());
    }
}
