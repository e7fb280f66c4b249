//! A plane in metres seen by a pinhole: the homography between the two, and what a pixel is on that plane.
//!
//! ```text
//! w (u, v, 1)ᵀ = H (X, Y, 1)ᵀ
//! ```
//!
//! First the linear solution in coordinates about their middle (Hartley, 1997), then least squares of the distances in the picture. Places
//! are those of a pinhole: [`Lens::straight`](super::super::lens::Lens::straight) comes before. Eight numbers are fitted, the ninth is
//! one in the middle of the points, which lies before the camera.

use nalgebra::{Matrix2, Matrix3, SMatrix, SVector, SymmetricEigen, Vector2, Vector3};

use super::super::picture::Place;
use super::CalibrateError;

/// Numbers of a homography.
const UNKNOWNS: usize = 8;

/// Points that fix them.
const POINTS_MIN: usize = 4;

/// Steps of least squares, at most.
const STEPS_MAX: usize = 100;

/// A step that changes the numbers by less is the last.
const FOUND: f64 = 1e-12;

/// The second smallest eigenvalue of the linear equations, as a share of the largest: below it, more than one homography fits.
const SEVERAL_FIT: f64 = 1e-12;

/// A plane and its picture.
#[derive(Debug, Clone, PartialEq)]
pub struct Homography {
    /// From the plane to the picture, both about their middle.
    centred: Matrix3<f64>,
    inverse: Matrix3<f64>,
    plane: Centred,
    picture: Centred,
    /// Of the first eight numbers of `centred`, row by row.
    covariance: SMatrix<f64, UNKNOWNS, UNKNOWNS>,
    /// Standard deviation of a coordinate in the picture, in px: what was left over, or what was stated.
    pub place_std_px: f64,
}

/// Coordinates about their middle, their mean distance from it the root of two.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Centred {
    middle: Vector2<f64>,
    factor: f64,
}

/// What a pixel is on a plane at one place of the picture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlaneScale {
    /// The root of the area of a pixel, in m.
    pub metre_per_px: f64,
    /// Its standard uncertainty, in m, for exact points of the plane.
    pub std: f64,
    /// Along the direction in which a pixel is longest on the plane, in m.
    pub longest: f64,
    /// Across it.
    pub shortest: f64,
    /// The direction in the picture in which it is longest, in rad from x towards y, within ± π/2.
    pub direction_rad: f64,
}

impl PlaneScale {
    /// How much longer a pixel is on the plane one way than the other; 1: the plane is parallel to the picture.
    pub fn anisotropy(&self) -> f64 {
        self.longest / self.shortest
    }
}

impl Centred {
    fn of(points: impl Iterator<Item = Vector2<f64>> + Clone) -> Option<Self> {
        let n = points.clone().count() as f64;
        let middle = points.clone().sum::<Vector2<f64>>() / n;
        let distance = points.map(|p| (p - middle).norm()).sum::<f64>() / n;
        let factor = std::f64::consts::SQRT_2 / distance;
        (factor.is_finite() && middle.x.is_finite() && middle.y.is_finite()).then_some(Self { middle, factor })
    }

    fn to(self, point: Vector2<f64>) -> Vector2<f64> {
        (point - self.middle) * self.factor
    }

    fn from(self, point: Vector2<f64>) -> Vector2<f64> {
        point / self.factor + self.middle
    }

    fn matrix(self) -> Matrix3<f64> {
        let (f, m) = (self.factor, self.middle);
        Matrix3::new(f, 0.0, -f * m.x, 0.0, f, -f * m.y, 0.0, 0.0, 1.0)
    }
}

impl Homography {
    /// The homography of points on a plane, in m, and where a pinhole sees them. `place_std_px` is the standard uncertainty of a
    /// coordinate where it is known; else it comes of what is left over, and takes more than four points.
    ///
    /// # Errors
    /// [`CalibrateError::FewPoints`], [`CalibrateError::Alike`] if the points are on one line, [`CalibrateError::NotConverged`].
    pub fn fit(points: &[(Vector2<f64>, Place)], place_std_px: Option<f64>) -> Result<Self, CalibrateError> {
        let needed = POINTS_MIN + usize::from(place_std_px.is_none());
        if points.len() < needed {
            return Err(CalibrateError::FewPoints { found: points.len(), needed });
        }
        let plane = Centred::of(points.iter().map(|(p, _)| *p)).ok_or(CalibrateError::Alike)?;
        let picture = Centred::of(points.iter().map(|(_, p)| *p)).ok_or(CalibrateError::Alike)?;
        let centred: Vec<_> = points.iter().map(|(a, b)| (plane.to(*a), picture.to(*b))).collect();
        let start = linear(&centred).ok_or(CalibrateError::Alike)?;
        let (matrix, normal, squares) = least_squares(&centred, start)?;
        let inverse = matrix.try_inverse().ok_or(CalibrateError::Alike)?;
        let freedom = 2 * points.len() - UNKNOWNS;
        let std = place_std_px.unwrap_or_else(|| (squares / freedom as f64).sqrt() / picture.factor);
        let covariance = normal.try_inverse().ok_or(CalibrateError::Alike)? * (std * picture.factor).powi(2);
        if !covariance.iter().chain(inverse.iter()).all(|v| v.is_finite()) {
            return Err(CalibrateError::Alike);
        }
        Ok(Self { centred: matrix, inverse, plane, picture, covariance, place_std_px: std })
    }

    /// From the plane (X, Y, 1) in m to the picture (u, v, 1) in px.
    pub fn matrix(&self) -> Matrix3<f64> {
        let back = Centred { middle: -self.picture.middle * self.picture.factor, factor: 1.0 / self.picture.factor };
        back.matrix() * self.centred * self.plane.matrix()
    }

    /// Where a pinhole sees a point of the plane; `None` behind the camera.
    pub fn to_picture(&self, point: Vector2<f64>) -> Option<Place> {
        Some(self.picture.from(apply(&self.centred, self.plane.to(point))?))
    }

    /// The point of the plane, in m, at a place of a pinhole's picture; `None` above the plane's horizon.
    pub fn to_plane(&self, at: Place) -> Option<Vector2<f64>> {
        Some(self.plane.from(apply(&self.inverse, self.picture.to(at))?))
    }

    /// What a pixel is on the plane there.
    ///
    /// With G = H⁻¹ and its third row g, the area of a pixel is det G / (g·p)³. Its logarithm is differentiated by the numbers of H,
    /// `dG = -G dH G`, and their covariance gives the standard uncertainty.
    pub fn scale_at(&self, at: Place) -> Option<PlaneScale> {
        let p = self.picture.to(at).push(1.0);
        let q = self.inverse * p;
        if q.z <= 0.0 {
            return None;
        }
        let g = self.inverse.row(2).transpose();
        let point = Vector2::new(q.x / q.z, q.y / q.z);
        let of_plane = self.inverse.fixed_view::<2, 2>(0, 0) - point * g.xy().transpose();
        let per_px: Matrix2<f64> = of_plane * (self.picture.factor / self.plane.factor / q.z);
        let metre_per_px = per_px.determinant().abs().sqrt();
        let eigen = SymmetricEigen::new(per_px.transpose() * per_px);
        let (longest, shortest) = (eigen.eigenvalues.imax(), eigen.eigenvalues.imin());
        let way = eigen.eigenvectors.column(longest);
        let derivative = self.inverse.transpose() * -0.5 + g * q.transpose() * (1.5 / q.z);
        let by_number = SVector::<f64, UNKNOWNS>::from_fn(|i, _| derivative[(i / 3, i % 3)]);
        let relative = by_number.dot(&(self.covariance * by_number)).max(0.0).sqrt();
        let scale = PlaneScale {
            metre_per_px,
            std: metre_per_px * relative,
            longest: eigen.eigenvalues[longest].max(0.0).sqrt(),
            shortest: eigen.eigenvalues[shortest].max(0.0).sqrt(),
            direction_rad: if way.x == 0.0 { std::f64::consts::FRAC_PI_2 } else { (way.y / way.x).atan() },
        };
        (scale.metre_per_px > 0.0 && scale.shortest > 0.0 && scale.std.is_finite() && scale.longest.is_finite())
            .then_some(scale)
    }
}

fn apply(matrix: &Matrix3<f64>, point: Vector2<f64>) -> Option<Vector2<f64>> {
    let there = matrix * point.push(1.0);
    (there.z > 0.0).then(|| Vector2::new(there.x / there.z, there.y / there.z))
}

/// The homography for which H p × q is smallest over all points, as one.
fn linear(points: &[(Vector2<f64>, Vector2<f64>)]) -> Option<Matrix3<f64>> {
    let mut normal = SMatrix::<f64, 9, 9>::zeros();
    for (a, b) in points {
        for (row, to) in [(0, b.x), (1, b.y)] {
            let mut equation = SVector::<f64, 9>::zeros();
            for (i, value) in [a.x, a.y, 1.0].into_iter().enumerate() {
                equation[3 * row + i] = value;
                equation[6 + i] = -to * value;
            }
            normal += equation * equation.transpose();
        }
    }
    let eigen = SymmetricEigen::new(normal);
    let mut order: Vec<usize> = (0..9).collect();
    order.sort_by(|i, j| eigen.eigenvalues[*i].total_cmp(&eigen.eigenvalues[*j]));
    if eigen.eigenvalues[order[1]] <= SEVERAL_FIT * eigen.eigenvalues[order[8]] {
        return None;
    }
    let h = eigen.eigenvectors.column(order[0]);
    let matrix = Matrix3::from_fn(|i, j| h[3 * i + j]);
    let scaled = matrix / matrix[(2, 2)];
    scaled.iter().all(|v| v.is_finite()).then_some(scaled)
}

type Normal = SMatrix<f64, UNKNOWNS, UNKNOWNS>;

/// Levenberg and Marquardt's steps; the matrix, the normal equations there and the sum of squares.
fn least_squares(
    points: &[(Vector2<f64>, Vector2<f64>)],
    start: Matrix3<f64>,
) -> Result<(Matrix3<f64>, Normal, f64), CalibrateError> {
    let squares_of = |h: &Matrix3<f64>| -> Option<f64> {
        points.iter().map(|(a, b)| Some((apply(h, *a)? - b).norm_squared())).sum()
    };
    let mut h = start;
    let mut squares = squares_of(&h).ok_or(CalibrateError::Alike)?;
    let mut damping = 1e-6;
    for _ in 0..STEPS_MAX {
        let (normal, gradient) = normal_equations(points, &h);
        loop {
            let damped = normal + Normal::from_diagonal(&(normal.diagonal() * damping));
            let step = damped.cholesky().ok_or(CalibrateError::Alike)?.solve(&-gradient);
            let next = h + Matrix3::from_fn(|i, j| if i + j == 4 { 0.0 } else { step[3 * i + j] });
            if step.norm() < FOUND * h.norm() {
                return Ok((h, normal, squares));
            }
            if let Some(less) = squares_of(&next).filter(|less| *less <= squares) {
                (h, squares, damping) = (next, less, (damping * 0.1).max(1e-15));
                break;
            }
            damping *= 10.0;
            if damping > 1e12 {
                return Ok((h, normal, squares));
            }
        }
    }
    Err(CalibrateError::NotConverged { steps: STEPS_MAX })
}

fn normal_equations(points: &[(Vector2<f64>, Vector2<f64>)], h: &Matrix3<f64>) -> (Normal, SVector<f64, UNKNOWNS>) {
    let mut normal = Normal::zeros();
    let mut gradient = SVector::<f64, UNKNOWNS>::zeros();
    for (a, b) in points {
        let p = Vector3::new(a.x, a.y, 1.0);
        let w = h * p;
        for (row, residual) in [(0, w.x / w.z - b.x), (1, w.y / w.z - b.y)] {
            let mut by = SVector::<f64, UNKNOWNS>::zeros();
            for i in 0..3 {
                by[3 * row + i] = p[i] / w.z;
                if i < 2 {
                    by[6 + i] = -w[row] / w.z * p[i] / w.z;
                }
            }
            normal += by * by.transpose();
            gradient += by * residual;
        }
    }
    (normal, gradient)
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand_distr::{Distribution, StandardNormal};
    use rand_pcg::Pcg64Mcg;

    fn truth() -> Matrix3<f64> {
        Matrix3::new(4000.0, 300.0, 320.0, -200.0, 3700.0, 240.0, 0.9, -0.6, 1.0)
    }

    fn grid(std: f64, generator: &mut Pcg64Mcg) -> Vec<(Vector2<f64>, Place)> {
        let point = |i: i32| Vector2::new(f64::from(i % 9) * 0.01, f64::from(i / 9) * 0.01);
        (0..54)
            .map(|i| {
                let mut noise = || std * Distribution::<f64>::sample(&StandardNormal, generator);
                let by = Vector2::new(noise(), noise());
                (point(i), apply(&truth(), point(i)).unwrap() + by)
            })
            .collect()
    }

    #[test]
    fn exact_points_give_the_exact_homography_and_its_scale_is_the_difference() {
        let points = grid(0.0, &mut Pcg64Mcg::new(1));
        let found = Homography::fit(&points, None).unwrap();
        let scaled = found.matrix() / found.matrix()[(2, 2)];
        assert!((scaled - truth()).norm() < 1e-6, "{scaled}");
        let at = found.to_picture(Vector2::new(0.03, 0.02)).unwrap();
        assert!((found.to_plane(at).unwrap() - Vector2::new(0.03, 0.02)).norm() < 1e-12);
        let scale = found.scale_at(at).unwrap();
        let to = |dx: f64, dy: f64| found.to_plane(at + Vector2::new(dx, dy)).unwrap();
        let by_x = (to(1e-3, 0.0) - to(-1e-3, 0.0)) / 2e-3;
        let by_y = (to(0.0, 1e-3) - to(0.0, -1e-3)) / 2e-3;
        let area = by_x.x * by_y.y - by_x.y * by_y.x;
        assert!((scale.metre_per_px - area.abs().sqrt()).abs() < 1e-9 * scale.metre_per_px);
        let (sin, cos) = scale.direction_rad.sin_cos();
        assert!(((by_x * cos + by_y * sin).norm() / scale.longest - 1.0).abs() < 1e-8);
        assert!(((by_x * -sin + by_y * cos).norm() / scale.shortest - 1.0).abs() < 1e-8);
        assert!(scale.anisotropy() > 1.0 && scale.std < 1e-9 * scale.metre_per_px);
    }

    #[test]
    fn the_scale_scatters_as_stated() {
        let mut generator = Pcg64Mcg::new(5);
        let exact = Homography::fit(&grid(0.0, &mut generator), None).unwrap();
        // In the middle of the board and beyond its corner.
        for at in [Place::new(470.0, 330.0), Place::new(900.0, 700.0)] {
            let truth = exact.scale_at(at).unwrap().metre_per_px;
            let (mut squares, mut stated) = (0.0, 0.0);
            for _ in 0..500 {
                let found = Homography::fit(&grid(0.1, &mut generator), None).unwrap();
                let scale = found.scale_at(at).unwrap();
                squares += (scale.metre_per_px - truth).powi(2);
                stated += scale.std.powi(2);
            }
            let share: f64 = squares / stated;
            assert!((share - 1.0).abs() < 0.2, "{at}: {share}");
        }
    }

    #[test]
    fn points_that_say_nothing_are_refused() {
        let points = grid(0.0, &mut Pcg64Mcg::new(1));
        assert_eq!(Homography::fit(&points[..4], None), Err(CalibrateError::FewPoints { found: 4, needed: 5 }));
        let four = [0, 8, 45, 53].map(|i| points[i]);
        assert!(Homography::fit(&four, Some(0.1)).is_ok());
        assert_eq!(Homography::fit(&points[..9], None), Err(CalibrateError::Alike));
        let same = vec![points[0]; 9];
        assert_eq!(Homography::fit(&same, None), Err(CalibrateError::Alike));
        let nan = vec![(Vector2::repeat(f64::NAN), Place::zeros()); 9];
        assert_eq!(Homography::fit(&nan, None), Err(CalibrateError::Alike));
        // Above the horizon, where w turns negative, there is no plane.
        let found = Homography::fit(&points, None).unwrap();
        assert!(found.to_picture(Vector2::new(-2.0, 0.0)).is_none());
        assert!(found.scale_at(Place::new(1e5, -1e5)).is_none());
    }
}
