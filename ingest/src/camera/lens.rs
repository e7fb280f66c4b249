//! A lens: where a ray meets the picture, and back.
//!
//! Brown and Conrady's model in `OpenCV`'s order of coefficients. With x = X/Z, y = Y/Z and r² = x² + y²:
//!
//! ```text
//! x' = x (1 + k1 r² + k2 r⁴ + k3 r⁶) + 2 p1 x y + p2 (r² + 2 x²)
//! y' = y (1 + k1 r² + k2 r⁴ + k3 r⁶) + p1 (r² + 2 y²) + 2 p2 x y
//! u = fx x' + cx,   v = fy y' + cy
//! ```
//!
//! Points are undistorted, not pixels: an edge that was found to a hundredth of a pixel is not resampled.

use nalgebra::{Matrix2, Vector2, Vector3};

use super::picture::Place;

/// Steps by which a distorted point is traced back, at most; each gains several digits.
const STEPS_MAX: usize = 50;

/// It is found where a step is smaller than this, in units of the focal length.
const FOUND: f64 = 1e-13;

/// Intrinsics and distortion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lens {
    /// Focal lengths, in px.
    pub focal_px: Vector2<f64>,
    /// Principal point, in px.
    pub centre_px: Place,
    /// k1, k2, k3.
    pub radial: [f64; 3],
    /// p1, p2.
    pub tangential: [f64; 2],
}

impl Lens {
    /// A pinhole.
    pub fn pinhole(focal_px: f64, centre_px: Place) -> Self {
        Self { focal_px: Vector2::repeat(focal_px), centre_px, radial: [0.0; 3], tangential: [0.0; 2] }
    }

    /// Where a ray (X/Z, Y/Z) goes behind the lens, and how that changes with the ray.
    pub fn distort(&self, ray: Vector2<f64>) -> (Vector2<f64>, Matrix2<f64>) {
        let (x, y) = (ray.x, ray.y);
        let (r2, [k1, k2, k3], [p1, p2]) = (x * x + y * y, self.radial, self.tangential);
        let radial = 1.0 + r2 * (k1 + r2 * (k2 + r2 * k3));
        // Of the radial factor, over r².
        let slope = k1 + r2 * (2.0 * k2 + 3.0 * k3 * r2);
        let bent = Vector2::new(
            x * radial + 2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x),
            y * radial + p1 * (r2 + 2.0 * y * y) + 2.0 * p2 * x * y,
        );
        let across = 2.0 * x * y * slope + 2.0 * (p1 * x + p2 * y);
        let derivative = Matrix2::new(
            radial + 2.0 * x * x * slope + 2.0 * p1 * y + 6.0 * p2 * x,
            across,
            across,
            radial + 2.0 * y * y * slope + 6.0 * p1 * y + 2.0 * p2 * x,
        );
        (bent, derivative)
    }

    /// Where a point before the camera (x to the right, y down, z ahead) is seen; `None` behind it.
    pub fn project(&self, point: Vector3<f64>) -> Option<Place> {
        let ahead = point.z > 0.0;
        ahead.then(|| self.on_picture(Vector2::new(point.x / point.z, point.y / point.z)))
    }

    /// Where a ray is seen.
    pub fn on_picture(&self, ray: Vector2<f64>) -> Place {
        self.distort(ray).0.component_mul(&self.focal_px) + self.centre_px
    }

    /// The ray (X/Z, Y/Z) that is seen at a place; `None` where the model folds, far outside of what it was calibrated for.
    pub fn ray(&self, at: Place) -> Option<Vector2<f64>> {
        let bent = (at - self.centre_px).component_div(&self.focal_px);
        let mut ray = bent;
        for _ in 0..STEPS_MAX {
            let (there, derivative) = self.distort(ray);
            let step = derivative.try_inverse()? * (bent - there);
            ray += step;
            if !ray.x.is_finite() || !ray.y.is_finite() {
                return None;
            }
            if step.norm() < FOUND {
                // Beyond the fold another ray is seen there, turned over or reversed.
                let derivative = self.distort(ray).1;
                return (derivative.determinant() > 0.0 && derivative.trace() > 0.0).then_some(ray);
            }
        }
        None
    }

    /// Where a pinhole with the same intrinsics would have seen it.
    pub fn straight(&self, at: Place) -> Option<Place> {
        Some(self.ray(at)?.component_mul(&self.focal_px) + self.centre_px)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lens() -> Lens {
        Lens {
            focal_px: Vector2::new(536.07, 536.02),
            centre_px: Place::new(342.37, 235.54),
            radial: [-0.265, -0.0467, 0.252],
            tangential: [0.00183, -0.0003],
        }
    }

    #[test]
    fn a_point_comes_back_from_the_picture_and_the_derivative_is_the_difference() {
        let lens = lens();
        for (u, v) in [(0.0, 0.0), (639.0, 479.0), (342.37, 235.54), (100.0, 400.0)] {
            let ray = lens.ray(Place::new(u, v)).unwrap();
            assert!((lens.on_picture(ray) - Place::new(u, v)).norm() < 1e-9);
            for (i, by) in [Vector2::new(1e-6, 0.0), Vector2::new(0.0, 1e-6)].into_iter().enumerate() {
                let difference = (lens.distort(ray + by).0 - lens.distort(ray - by).0) / 2e-6;
                assert!((difference - lens.distort(ray).1.column(i)).norm() < 1e-8);
            }
        }
        // One value by hand: r² = 0.05, on the x axis and the y axis alike.
        let (bent, _) = lens.distort(Vector2::new(0.2, 0.1));
        let radial = 1.0 - 0.265 * 0.05 - 0.0467 * 0.0025 + 0.252 * 0.000_125;
        let x = 0.2 * radial + 2.0 * 0.00183 * 0.02 - 0.0003 * (0.05 + 0.08);
        assert!((bent.x - x).abs() < 1e-15);
    }

    #[test]
    fn a_pinhole_is_straight_and_what_lies_behind_is_not_seen() {
        let pinhole = Lens::pinhole(1000.0, Place::new(320.0, 240.0));
        assert_eq!(pinhole.project(Vector3::new(0.1, -0.2, 2.0)), Some(Place::new(370.0, 140.0)));
        assert_eq!(pinhole.project(Vector3::new(0.1, 0.2, -1.0)), None);
        let at = Place::new(12.0, 450.0);
        assert!((pinhole.straight(at).unwrap() - at).norm() < 1e-9);
        // r (1 - 0.3 r²) is never more than 0.703.
        let barrel = Lens { radial: [-0.3, 0.0, 0.0], ..pinhole };
        assert!(barrel.ray(Place::new(320.0 + 700.0, 240.0)).is_some());
        assert_eq!(barrel.ray(Place::new(320.0 + 710.0, 240.0)), None);
        assert_eq!(Lens { focal_px: Vector2::repeat(100.0), ..barrel }.ray(Place::new(900.0, 0.0)), None);
    }
}
