//! Where the search for a lens begins: intrinsics and poses from homographies, without distortion (Zhang, 2000, without skew).
//!
//! The first two columns h₁, h₂ of a homography are K r₁ and K r₂ up to a factor, and r₁, r₂ are orthogonal and of one length:
//!
//! ```text
//! h₁ᵀ B h₂ = 0,   h₁ᵀ B h₁ = h₂ᵀ B h₂,   B = K⁻ᵀ K⁻¹
//! ```
//!
//! Five numbers of B up to a factor: two equations per picture.

use nalgebra::{Matrix2, Matrix3, Rotation3, SMatrix, SVector, SymmetricEigen, Vector2, Vector3};

/// Focal lengths as shares of the picture's size that a lens may have.
const FOCAL: std::ops::Range<f64> = 0.1..50.0;

/// Focal lengths and principal point of pictures of one size, in px.
pub(super) fn intrinsics(homographies: &[Matrix3<f64>], size_px: Vector2<f64>) -> Option<[f64; 4]> {
    // About the middle of the picture, in units of its size: numbers near one.
    let (unit, middle) = (size_px.norm() / 2.0, (size_px - Vector2::repeat(1.0)) / 2.0);
    let centre = Matrix3::new(1.0, 0.0, -middle.x, 0.0, 1.0, -middle.y, 0.0, 0.0, unit) / unit;
    let centred: Vec<_> = homographies.iter().map(|h| (centre * h).normalize()).collect();
    let usable = |[fx, fy, cx, cy]: [f64; 4]| {
        (FOCAL.contains(&fx) && FOCAL.contains(&fy) && fx < 2.0 * fy && fy < 2.0 * fx && cx.abs().max(cy.abs()) < 1.0)
            .then_some([fx * unit, fy * unit, cx * unit + middle.x, cy * unit + middle.y])
    };
    usable(full(&centred)).or_else(|| about_the_middle(&centred).and_then(usable))
}

/// The two constraints of a homography: factors of B11, B22, B13, B23, B33.
fn constraints(h: &Matrix3<f64>) -> [SVector<f64, 5>; 2] {
    let of = |i: usize, j: usize| {
        let (a, b) = (h.column(i), h.column(j));
        SVector::<f64, 5>::new(
            a[0] * b[0],
            a[1] * b[1],
            a[0] * b[2] + a[2] * b[0],
            a[1] * b[2] + a[2] * b[1],
            a[2] * b[2],
        )
    };
    [of(0, 1), of(0, 0) - of(1, 1)]
}

/// Numbers that are none where a root is of a negative share, which the caller refuses.
fn full(homographies: &[Matrix3<f64>]) -> [f64; 4] {
    let mut normal = SMatrix::<f64, 5, 5>::zeros();
    for row in homographies.iter().flat_map(constraints) {
        normal += row * row.transpose();
    }
    let eigen = SymmetricEigen::new(normal);
    let b = eigen.eigenvectors.column(eigen.eigenvalues.imin()).into_owned();
    let (b11, b22, b13, b23, b33) = (b[0], b[1], b[2], b[3], b[4]);
    let factor = b33 - b13 * b13 / b11 - b23 * b23 / b22;
    [(factor / b11).sqrt(), (factor / b22).sqrt(), -b13 / b11, -b23 / b22]
}

/// The principal point in the middle of the picture; if need be, one focal length.
fn about_the_middle(homographies: &[Matrix3<f64>]) -> Option<[f64; 4]> {
    let mut normal = Matrix2::zeros();
    let mut right = Vector2::zeros();
    for row in homographies.iter().flat_map(constraints) {
        let by = Vector2::new(row[0], row[1]);
        normal += by * by.transpose();
        right -= by * row[4];
    }
    let two = normal.try_inverse().map(|inverse| inverse * right);
    if let Some(two) = two.filter(|two| two.x > 0.0 && two.y > 0.0 && two.x < 4.0 * two.y && two.y < 4.0 * two.x) {
        return Some([two.x.sqrt().recip(), two.y.sqrt().recip(), 0.0, 0.0]);
    }
    let both = Vector2::repeat(1.0);
    let one = both.dot(&right) / (normal * both).dot(&both);
    (one > 0.0).then(|| [one.sqrt().recip(), one.sqrt().recip(), 0.0, 0.0])
}

/// How a board lies before the camera: rotation, and where its origin is.
pub(super) fn pose(h: &Matrix3<f64>, [fx, fy, cx, cy]: [f64; 4]) -> Option<(Rotation3<f64>, Vector3<f64>)> {
    let rays = Matrix3::new(1.0 / fx, 0.0, -cx / fx, 0.0, 1.0 / fy, -cy / fy, 0.0, 0.0, 1.0) * h;
    let factor = 2.0 / (rays.column(0).norm() + rays.column(1).norm());
    // The board is before the camera.
    let rays = rays * if rays[(2, 2)] < 0.0 { -factor } else { factor };
    let (x, y) = (rays.column(0).into_owned(), rays.column(1).into_owned());
    let svd = Matrix3::from_columns(&[x, y, x.cross(&y)]).svd(true, true);
    let rotation = svd.u? * svd.v_t?;
    let translation = rays.column(2).into_owned();
    let sound = translation.iter().chain(rotation.iter()).all(|v| v.is_finite()) && rotation.determinant() > 0.0;
    sound.then(|| (Rotation3::from_matrix_unchecked(rotation), translation))
}
