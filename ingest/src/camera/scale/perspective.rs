//! The silhouette of a round body is wider than the body: lines of sight touch it before its middle.
//!
//! In the plane through the camera that is square to the axis of a cylinder (or through the middle of a sphere), a line of sight at an
//! angle α to that of the middle touches a circle of radius R whose middle is at distance D where
//!
//! ```text
//! sin α = R / D
//! ```
//!
//! The camera sees the two tangents at u₁, u₂ px from the principal point (a pinhole's picture, across the axis). A scale of s
//! m/px holds in a plane parallel to the picture at S = Z - h, Z the distance of the axis and h how far the plane lies before
//! the axis, towards the camera. So the focal length is S/s px, and
//!
//! ```text
//! tan γᵢ = s uᵢ / S      α = (γ₂ - γ₁)/2      β = (γ₁ + γ₂)/2      D = Z / cos β      R = D sin α
//! ```
//!
//! exactly, at the middle of the picture or off it. At the middle R = Z t/√(1 + t²) with t = s w/S, w the apparent half width in
//! px. Read in a plane through the axis, the apparent radius is R/√(1 - (R/Z)²): of R = 20 mm at Z = 300 mm, the diameter seems
//! larger by 0.089 mm.
//!
//! The silhouette of a sphere off the middle is an ellipse. Its middle is m = X Z/(Z² - R²) from the principal point (in focal
//! lengths, X how far the sphere is off the optical axis), and a point p of it lies on the cone of tangents, (X ρ + Z)² = (X² +
//! Z² - R²)(|p|² + 1), ρ the part of p along m. With κ = 1 - (R/Z)² both together are
//!
//! ```text
//! m² (ρ² - |p|² - 1) κ² + (2 m ρ - |p|² - 1) κ + 1 = 0
//! ```

use std::fmt;

use nalgebra::Vector2;

use super::super::picture::Place;
use super::Scale;

/// A body that fills more of the view than this, as tan α, is nearer than anyone photographs: a slip in the units.
const TAN_MAX: f64 = 2.0;

/// Where a body and the plane of its scale are.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Perspective {
    /// From the camera's centre (the entrance pupil of its lens) to the plane of the axis, parallel to the picture, in m; above 0.
    pub distance_m: f64,
    /// Its standard uncertainty.
    pub distance_std_m: f64,
    /// How far the plane in which the scale holds lies before the axis, towards the camera, in m.
    pub offset_m: f64,
    /// Its standard uncertainty.
    pub offset_std_m: f64,
    /// The scale in that plane.
    pub scale: Scale,
}

/// A true radius.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TrueRadius {
    /// In m.
    pub radius_m: f64,
    /// Standard uncertainty: the parts below and that of the places, in m.
    pub std_m: f64,
    /// Of the places alone.
    pub of_places_m: f64,
    /// Of the distance alone.
    pub of_distance_m: f64,
    /// Of the offset alone.
    pub of_offset_m: f64,
    /// Of the scale alone.
    pub of_scale_m: f64,
    /// What the plain product of half width and scale says more, in m.
    pub correction_m: f64,
}

/// Why there is no true radius.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum PerspectiveError {
    /// A distance that is none, or a scale plane behind the camera.
    Distance {
        /// Of the axis, in m.
        distance_m: f64,
        /// Of the scale plane before it, in m.
        offset_m: f64,
    },
    /// A width that is none, or as wide as only a body at the lens could be.
    Width {
        /// Half of it at the scale, in m.
        half_m: f64,
        /// Distance of the axis, in m.
        distance_m: f64,
    },
}

impl fmt::Display for PerspectiveError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Distance { distance_m, offset_m } => write!(
                f,
                "an axis at {distance_m} m and a scale plane {offset_m} m before it: expected a distance above 0 m, and the plane between"
            ),
            Self::Width { half_m, distance_m } => {
                write!(
                    f,
                    "a half width of {half_m} m cannot be seen from {distance_m} m: are distance and scale in metres?"
                )
            }
        }
    }
}

impl std::error::Error for PerspectiveError {}

/// The apparent radius of a body of radius R at distance Z, read in the plane of its axis: R/√(1 - (R/Z)²). `None` where the camera would
/// be inside.
///
/// ```text
/// 2 · 20 mm/√(1 - (20/300)²) - 2 · 20 mm = 0.089 mm
/// ```
pub fn apparent_radius_m(radius_m: f64, distance_m: f64) -> Option<f64> {
    let sine = radius_m / distance_m;
    (radius_m >= 0.0 && (0.0..1.0).contains(&sine)).then(|| radius_m / (1.0 - sine * sine).sqrt())
}

/// By how much a diameter read without regard to the distance is too large, in m: for an apparent radius, a distance that is typical,
/// and a scale plane so far before the axis (0: in it).
///
/// The same equations: R = Z t/√(1 + t²), t = r/(Z - h), and the error 2 (r - R). A plane behind the axis makes it smaller, and
/// negative where that outweighs the tangents. `None` if the plane is not before the camera.
pub fn error_if_ignored_m(apparent_radius_m: f64, distance_m: f64, offset_m: f64) -> Option<f64> {
    let plane_m = distance_m - offset_m;
    let tangent = apparent_radius_m / plane_m;
    let error = 2.0 * (apparent_radius_m - distance_m * tangent / 1.0_f64.hypot(tangent));
    (distance_m > 0.0 && plane_m > 0.0 && apparent_radius_m >= 0.0 && error.is_finite()).then_some(error)
}

/// What the equations need, as plain numbers.
#[derive(Clone, Copy)]
struct At {
    distance_m: f64,
    offset_m: f64,
    metre_per_px: f64,
}

impl At {
    /// Tangent of the angle under which a pixel is seen.
    fn per_px(self) -> f64 {
        self.metre_per_px / (self.distance_m - self.offset_m)
    }

    fn cylinder(self, [u1, u2]: [f64; 2]) -> f64 {
        let (g1, g2) = ((u1 * self.per_px()).atan(), (u2 * self.per_px()).atan());
        self.distance_m * ((g2 - g1) / 2.0).sin().abs() / f64::midpoint(g1, g2).cos()
    }

    fn sphere(self, a: Place, b: Place) -> f64 {
        let (a, b) = (a * self.per_px(), b * self.per_px());
        let middle = (a + b) / 2.0;
        let m2 = middle.norm_squared();
        // m ρ is the product of the two vectors; m² ρ² its square. Either end is on the ellipse: their mean has no preference.
        let share = |p: Vector2<f64>| {
            let (m_rho, one) = (middle.dot(&p), p.norm_squared() + 1.0);
            let (second, first) = (m_rho * m_rho - m2 * one, 2.0 * m_rho - one);
            // The root that stays where m is nought: κ = 1/(1 + w²).
            let kappa = 2.0 / (-first + (first * first - 4.0 * second).max(0.0).sqrt());
            1.0 - kappa
        };
        self.distance_m * f64::midpoint(share(a), share(b)).max(0.0).sqrt()
    }
}

impl Perspective {
    /// The radius of a cylinder whose axis is parallel to the picture, by where its two edges are seen across the axis: signed
    /// distances from the principal point, in px of a pinhole, and their standard uncertainties.
    ///
    /// # Errors
    /// If the camera cannot have seen that.
    pub fn cylinder(&self, edges_px: [f64; 2], edges_std_px: [f64; 2]) -> Result<TrueRadius, PerspectiveError> {
        let half_px = (edges_px[1] - edges_px[0]).abs() / 2.0;
        let reach_px = edges_px[0].abs().max(edges_px[1].abs());
        let by_place = |at: At| {
            let of = |i: usize| {
                let moved = |by: f64| at.cylinder(std::array::from_fn(|k| edges_px[k] + if i == k { by } else { 0.0 }));
                slope(moved, edges_std_px[i], half_px)
            };
            of(0).hypot(of(1))
        };
        self.radius(half_px, reach_px, |at| at.cylinder(edges_px), by_place)
    }

    /// The radius of a sphere by two opposite ends of its silhouette (their middle is that of the ellipse): places from the
    /// principal point, in px of a pinhole, and the standard uncertainty of each along the line between them.
    ///
    /// # Errors
    /// If the camera cannot have seen that.
    pub fn sphere(&self, ends_px: [Place; 2], ends_std_px: [f64; 2]) -> Result<TrueRadius, PerspectiveError> {
        let [a, b] = ends_px;
        let half_px = (b - a).norm() / 2.0;
        let reach_px = a.norm().max(b.norm());
        let way = (b - a) / (2.0 * half_px);
        let by_place = |at: At| {
            let first = slope(|by| at.sphere(a + way * by, b), ends_std_px[0], half_px);
            first.hypot(slope(|by| at.sphere(a, b + way * by), ends_std_px[1], half_px))
        };
        self.radius(half_px, reach_px, |at| at.sphere(a, b), by_place)
    }

    fn radius(
        &self,
        half_px: f64,
        reach_px: f64,
        of: impl Fn(At) -> f64,
        of_places: impl Fn(At) -> f64,
    ) -> Result<TrueRadius, PerspectiveError> {
        let at = At { distance_m: self.distance_m, offset_m: self.offset_m, metre_per_px: self.scale.metre_per_px };
        let plane_m = self.distance_m - self.offset_m;
        let plain_m = half_px * at.metre_per_px;
        if !(self.distance_m > 0.0 && plane_m > 0.0 && plane_m.is_finite()) {
            return Err(PerspectiveError::Distance { distance_m: self.distance_m, offset_m: self.offset_m });
        }
        let width = PerspectiveError::Width { half_m: plain_m, distance_m: self.distance_m };
        if !(plain_m > 0.0 && reach_px * at.metre_per_px < TAN_MAX * plane_m) {
            return Err(width);
        }
        let radius_m = of(at);
        let nearest_m = plane_m.min(self.distance_m);
        let by_distance = |by: f64| of(At { distance_m: at.distance_m + by, ..at });
        let of_distance_m = slope(by_distance, self.distance_std_m, nearest_m);
        let of_offset_m = slope(|by| of(At { offset_m: at.offset_m + by, ..at }), self.offset_std_m, nearest_m);
        let by_scale = |by: f64| of(At { metre_per_px: at.metre_per_px + by, ..at });
        let of_scale_m = slope(by_scale, self.scale.std, at.metre_per_px);
        let of_places_m = of_places(at);
        let std_m = of_distance_m.hypot(of_offset_m).hypot(of_scale_m).hypot(of_places_m);
        let sound = radius_m.is_finite() && radius_m > 0.0 && std_m.is_finite();
        let correction_m = plain_m - radius_m;
        sound
            .then_some(TrueRadius {
                radius_m,
                std_m,
                of_places_m,
                of_distance_m,
                of_offset_m,
                of_scale_m,
                correction_m,
            })
            .ok_or(width)
    }
}

/// How far a value moves for a standard uncertainty of what it depends on, by central differences over a small share of its size.
fn slope(of: impl Fn(f64) -> f64, std: f64, size: f64) -> f64 {
    let step = 1e-5 * size;
    ((of(step) - of(-step)) / (2.0 * step) * std).abs()
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector3;
    use rand_distr::{Distribution, StandardNormal};
    use rand_pcg::Pcg64Mcg;

    const FOCAL_PX: f64 = 2400.0;

    fn set_up(distance_m: f64, offset_m: f64) -> Perspective {
        let scale = Scale { metre_per_px: (distance_m - offset_m) / FOCAL_PX, std: 0.0 };
        Perspective { distance_m, distance_std_m: 0.0, offset_m, offset_std_m: 0.0, scale }
    }

    /// The extremes of u = x/z over the circle.
    fn seen(radius: f64, off: f64, distance: f64) -> [f64; 2] {
        let (mut low, mut high) = (f64::MAX, f64::MIN);
        for i in 0..100_000 {
            let (sin, cos) = (std::f64::consts::TAU * f64::from(i) / 1e5).sin_cos();
            let u = FOCAL_PX * (off + radius * cos) / (distance - radius * sin);
            (low, high) = (low.min(u), high.max(u));
        }
        [low, high]
    }

    #[test]
    fn a_radius_of_20_mm_at_300_mm_seems_wider_by_0_089_mm() {
        let apparent = apparent_radius_m(0.020, 0.300).unwrap();
        assert!((2e3 * (apparent - 0.020) - 0.089).abs() < 5e-4, "{apparent}");
        // Not knowing the distance is the same error, seen from the other side.
        let error = error_if_ignored_m(apparent, 0.300, 0.0).unwrap();
        assert!((error - 2.0 * (apparent - 0.020)).abs() < 1e-15);
        // Far away there is none; a plane before the axis by 3 mm adds a hundredth.
        assert!(error_if_ignored_m(0.020, 1e6, 0.0).unwrap() < 1e-12);
        assert!(error_if_ignored_m(0.020, 0.3, 0.003).unwrap() < -2.0 * 0.020 * 0.0098 + 0.09e-3);
        assert_eq!(apparent_radius_m(0.4, 0.3), None);
        assert_eq!(error_if_ignored_m(0.02, 0.3, 0.3), None);
    }

    #[test]
    fn the_true_radius_comes_back_wherever_the_body_and_the_scale_plane_are() {
        for (radius, off, distance, offset) in [
            (0.020, 0.0, 0.3, 0.0),
            (0.020, 0.05, 0.3, 0.0),
            (0.020, -0.08, 0.25, 0.02),
            (0.035, 0.03, 0.2, -0.04),
            (1e-3, 0.0, 5.0, 0.0),
        ] {
            let found = set_up(distance, offset).cylinder(seen(radius, off, distance), [0.0; 2]).unwrap();
            assert!((found.radius_m / radius - 1.0).abs() < 1e-9, "{radius} {off}: {found:?}");
        }
    }

    #[test]
    fn a_sphere_off_the_middle_comes_back_along_every_diameter_of_its_ellipse() {
        let (radius, distance) = (0.02_f64, 0.25);
        for centre in [
            Vector3::<f64>::new(0.0, 0.0, distance),
            Vector3::new(0.06, -0.03, distance),
            Vector3::new(-0.1, 0.0, distance),
        ] {
            // Tangents: the circle in which the cone touches the sphere.
            let d: f64 = centre.norm();
            let axis: Vector3<f64> = centre / d;
            let side = axis.cross(&Vector3::new(0.3, 1.0, 0.2)).normalize();
            let up = axis.cross(&side);
            let (foot, rim) = (centre * (1.0 - (radius / d).powi(2)), radius * (1.0 - (radius / d).powi(2)).sqrt());
            let of = |angle: f64| {
                let p = foot + (side * angle.cos() + up * angle.sin()) * rim;
                Place::new(p.x / p.z, p.y / p.z) * FOCAL_PX
            };
            let k = d * d - radius * radius - centre.x * centre.x - centre.y * centre.y;
            let middle = Place::new(centre.x, centre.y) * (FOCAL_PX * distance / k);
            // Opposite ends about the ellipse's middle, by bisection.
            for i in 0..6 {
                let from = 0.5 * f64::from(i);
                let a = of(from);
                let off = |angle: f64| {
                    let (p, q) = (a - middle, of(angle) - middle);
                    p.x * q.y - p.y * q.x
                };
                let (mut low, mut high) = (from + 1.5, from + 4.8);
                for _ in 0..200 {
                    let half = f64::midpoint(low, high);
                    *(if (off(half) > 0.0) == (off(low) > 0.0) { &mut low } else { &mut high }) = half;
                }
                let found = set_up(distance, 0.0).sphere([a, of(low)], [0.0; 2]).unwrap();
                assert!((found.radius_m / radius - 1.0).abs() < 1e-9, "{centre} {i}: {found:?}");
            }
        }
    }

    #[test]
    fn the_scatter_is_the_stated_one_and_its_parts_are_told() {
        let mut known = set_up(0.3, 0.01);
        (known.distance_std_m, known.offset_std_m, known.scale.std) = (3e-3, 1e-3, 2e-7);
        let edges = seen(0.02, 0.04, 0.3);
        let stated = known.cylinder(edges, [0.3, 0.2]).unwrap();
        let mut generator = Pcg64Mcg::new(9);
        let mut squares = 0.0;
        for _ in 0..20_000 {
            let mut normal = |std: f64| std * Distribution::<f64>::sample(&StandardNormal, &mut generator);
            let scale = Scale { metre_per_px: known.scale.metre_per_px + normal(2e-7), std: 0.0 };
            let drawn = Perspective { distance_m: 0.3 + normal(3e-3), offset_m: 0.01 + normal(1e-3), scale, ..known };
            let moved = [edges[0] + normal(0.3), edges[1] + normal(0.2)];
            squares += (drawn.cylinder(moved, [0.0; 2]).unwrap().radius_m - 0.02).powi(2) / 20_000.0;
        }
        assert!((squares.sqrt() / stated.std_m - 1.0).abs() < 0.03, "{} {stated:?}", squares.sqrt());
        // The plane before the axis shows the body too small by h/Z, more than the tangents show it too large.
        assert!(stated.correction_m < 0.0 && stated.of_offset_m > stated.of_places_m, "{stated:?}");
    }

    #[test]
    fn what_no_camera_sees_is_refused() {
        assert!(matches!(set_up(0.3, 0.0).cylinder([0.0, 0.0], [0.0; 2]), Err(PerspectiveError::Width { .. })));
        assert!(matches!(set_up(0.3, 0.0).cylinder([-9e3, 9e3], [0.0; 2]), Err(PerspectiveError::Width { .. })));
        assert!(matches!(set_up(0.3, 0.0).sphere([Place::zeros(); 2], [0.0; 2]), Err(PerspectiveError::Width { .. })));
        assert!(matches!(set_up(0.3, 0.3).cylinder([-1.0, 1.0], [0.0; 2]), Err(PerspectiveError::Distance { .. })));
        assert!(matches!(
            set_up(f64::NAN, 0.0).cylinder([-1.0, 1.0], [0.0; 2]),
            Err(PerspectiveError::Distance { .. })
        ));
        let told = set_up(-1.0, 0.0).cylinder([-1.0, 1.0], [0.0; 2]).unwrap_err().to_string();
        assert!(told.contains("above 0 m"), "{told}");
    }
}
