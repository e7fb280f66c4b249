//! A lens from pictures of a chessboard: Zhang's closed form, then least squares over lens and poses.
//!
//! What is smallest is the sum of squared distances, in px, between the corners seen and those that lens and poses predict
//! (residual = predicted - measured). Every corner counts the same: on real boards paper and print deviate more than corners are uncertain.
//! Levenberg and Marquardt's steps with the derivatives in closed form; each pose stands apart from the others, so that only the lens'
//! equations (Schur's complement) are solved together. The covariance is that of the equations times the squares left over per degree of
//! freedom.
//!
//! Zhang, Z.: A flexible new technique for camera calibration. IEEE Trans. Pattern Anal. Mach. Intell. 22 (2000), 1330-1334.

mod closed_form;
pub mod homography;

use std::fmt;

use nalgebra::{Matrix2x3, Matrix3, Rotation3, SMatrix, SVector, Vector2, Vector3};

use self::homography::Homography;
use super::lens::Lens;
use super::picture::Place;

/// Numbers of a lens: fx, fy, cx, cy, k1, k2, p1, p2, k3.
pub const LENS_NUMBERS: usize = 9;

/// Numbers of a pose.
const POSE_NUMBERS: usize = 6;

/// Pictures below which lens and poses are not told apart.
pub const PICTURES_MIN: usize = 3;

/// Corners of a picture, at least.
const CORNERS_MIN: usize = 6;

/// Boards whose normals differ by less than this do not tell focal length from distance, in degrees.
pub const TILT_MIN_DEG: f64 = 5.0;

/// A focal length that is known no better than by this share is no calibration.
const FOCAL_STD_MAX: f64 = 0.05;

/// Steps, at most.
const STEPS_MAX: usize = 200;

/// The search ends where a step lowers the sum of squares by less than this share.
const SETTLED: f64 = 1e-12;

/// Corners of a board in one picture.
#[derive(Debug, Clone, PartialEq)]
pub struct View {
    /// Where they are on the board, in m (or squares), and where they were seen, in px.
    pub corners: Vec<(Vector2<f64>, Place)>,
}

/// What of the distortion is fitted; the rest is nought.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Free {
    /// How many of k1, k2, k3, in that order.
    pub radial: usize,
    /// p1 and p2.
    pub tangential: bool,
}

/// A board before the camera: `point = rotation * (X, Y, 0) + translation`, x to the right, y down, z ahead.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pose {
    /// From the board to the camera.
    pub rotation: Rotation3<f64>,
    /// Where the board's origin is, in the board's unit.
    pub translation: Vector3<f64>,
    /// Standard uncertainties: of the rotation about x, y, z of the camera, in rad, and of the translation.
    pub std: [f64; POSE_NUMBERS],
}

/// What is left over of a picture, or of all.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reprojection {
    /// Root of the mean squared distance, in px.
    pub rms_px: f64,
    /// Mean distance, in px.
    pub mean_px: f64,
    /// Largest distance, in px.
    pub worst_px: f64,
}

/// A calibrated lens.
#[derive(Debug, Clone, PartialEq)]
pub struct Calibration {
    /// The lens.
    pub lens: Lens,
    /// Standard uncertainties, number by number; 0 where a number was not fitted.
    pub std: Lens,
    /// Covariance of fx, fy, cx, cy, k1, k2, p1, p2, k3.
    pub covariance: SMatrix<f64, LENS_NUMBERS, LENS_NUMBERS>,
    /// The boards, picture by picture.
    pub poses: Vec<Pose>,
    /// What is left over, picture by picture.
    pub of_pictures: Vec<Reprojection>,
    /// What is left over of all.
    pub reprojection: Reprojection,
    /// Standard deviation of a coordinate of a corner, in px, by what is left over per degree of freedom.
    pub place_std_px: f64,
}

/// Why there is no calibration.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum CalibrateError {
    /// Too few pictures.
    FewPictures {
        /// Pictures given.
        found: usize,
    },
    /// Too few points.
    FewPoints {
        /// Points given.
        found: usize,
        /// Points needed.
        needed: usize,
    },
    /// A number that is none, or a picture without size.
    NotFinite,
    /// All points on one line, or all the same.
    Alike,
    /// All boards parallel: focal length and distance cannot be told apart.
    Parallel {
        /// Largest angle between two boards, in degrees; `None` where the pictures do not even say that.
        tilt_deg: Option<f64>,
    },
    /// The pictures do not say enough.
    Undetermined {
        /// Standard uncertainty of the focal length, as a share of it; `None`: infinite.
        focal_std: Option<f64>,
    },
    /// The search did not end.
    NotConverged {
        /// Steps made.
        steps: usize,
    },
}

impl fmt::Display for CalibrateError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::FewPictures { found } => {
                write!(
                    f,
                    "{found} pictures of the board, at least {PICTURES_MIN} are needed: take more, each tilted another way"
                )
            }
            Self::FewPoints { found, needed } => write!(f, "{found} points, at least {needed} are needed"),
            Self::NotFinite => write!(f, "a coordinate is no finite number, or the picture has no size"),
            Self::Alike => write!(f, "the points lie on one line, or on one another: they span no plane"),
            Self::Parallel { tilt_deg } => {
                write!(f, "the boards are parallel")?;
                if let Some(deg) = tilt_deg {
                    write!(f, " within {deg:.1} deg, at least {TILT_MIN_DEG} are needed")?;
                }
                write!(
                    f,
                    ": focal length and distance cannot be told apart; take pictures with the board tilted by 20 to 40 deg"
                )
            }
            Self::Undetermined { focal_std } => {
                write!(f, "the focal length is not known")?;
                if let Some(share) = focal_std {
                    write!(
                        f,
                        " better than by {:.1} %, at least {} % are needed",
                        100.0 * share,
                        100.0 * FOCAL_STD_MAX
                    )?;
                }
                write!(f, ": take more pictures, tilted and near")
            }
            Self::NotConverged { steps } => {
                write!(f, "the search for the lens did not end in {steps} steps: are all corners in the same order?")
            }
        }
    }
}

impl std::error::Error for CalibrateError {}

impl Default for Free {
    /// k1, k2, p1, p2, k3, as `OpenCV` fits them.
    fn default() -> Self {
        Self { radial: 3, tangential: true }
    }
}

impl Free {
    /// Whether a number of the lens is fitted.
    fn fits(self, number: usize) -> bool {
        match number {
            4 => self.radial > 0,
            5 => self.radial > 1,
            6 | 7 => self.tangential,
            8 => self.radial > 2,
            _ => true,
        }
    }

    fn count(self) -> usize {
        (0..LENS_NUMBERS).filter(|i| self.fits(*i)).count()
    }
}

type LensVector = SVector<f64, LENS_NUMBERS>;
type LensMatrix = SMatrix<f64, LENS_NUMBERS, LENS_NUMBERS>;
type PoseVector = SVector<f64, POSE_NUMBERS>;
type PoseMatrix = SMatrix<f64, POSE_NUMBERS, POSE_NUMBERS>;
type Mixed = SMatrix<f64, LENS_NUMBERS, POSE_NUMBERS>;

/// A lens and the boards before it.
#[derive(Debug, Clone)]
struct Guess {
    lens: Lens,
    poses: Vec<(Rotation3<f64>, Vector3<f64>)>,
}

/// The equations of a step: the lens' own, and of each picture the mixed ones and the pose's.
struct Equations {
    lens: LensMatrix,
    lens_right: LensVector,
    of_pictures: Vec<(Mixed, PoseMatrix, PoseVector)>,
}

/// A lens from pictures of so many px, all with the same lens, focus and size.
///
/// # Errors
/// Why there is none: too few pictures or points, boards that are parallel, a search that does not end.
pub fn calibrate(views: &[View], size_px: (usize, usize), free: Free) -> Result<Calibration, CalibrateError> {
    let guess = start(views, size_px)?;
    let (guess, settled) = search(views, guess, free)?;
    // Of parallel boards the search need not end: that is told first.
    let tilt_deg = tilt_deg(&guess.poses);
    if tilt_deg < TILT_MIN_DEG {
        return Err(CalibrateError::Parallel { tilt_deg: Some(tilt_deg) });
    }
    if !settled {
        return Err(CalibrateError::NotConverged { steps: STEPS_MAX });
    }
    finish(views, &guess, free)
}

fn start(views: &[View], size_px: (usize, usize)) -> Result<Guess, CalibrateError> {
    if views.len() < PICTURES_MIN {
        return Err(CalibrateError::FewPictures { found: views.len() });
    }
    if let Some(few) = views.iter().map(|view| view.corners.len()).find(|found| *found < CORNERS_MIN) {
        return Err(CalibrateError::FewPoints { found: few, needed: CORNERS_MIN });
    }
    let numbers = views.iter().flat_map(|view| &view.corners).flat_map(|(a, b)| [a.x, a.y, b.x, b.y]);
    if size_px.0.min(size_px.1) == 0 || !numbers.into_iter().all(f64::is_finite) {
        return Err(CalibrateError::NotFinite);
    }
    let homographies: Vec<Matrix3<f64>> = views
        .iter()
        .map(|view| Ok(Homography::fit(&view.corners, None)?.matrix()))
        .collect::<Result<_, CalibrateError>>()?;
    let size = Vector2::new(size_px.0 as f64, size_px.1 as f64);
    let parallel = CalibrateError::Parallel { tilt_deg: None };
    let intrinsics = closed_form::intrinsics(&homographies, size).ok_or_else(|| parallel.clone())?;
    let pose = |h| closed_form::pose(h, intrinsics).ok_or_else(|| parallel.clone());
    let poses = homographies.iter().map(pose).collect::<Result<_, _>>()?;
    let [fx, fy, cx, cy] = intrinsics;
    let pinhole = Lens::pinhole(fx, Place::new(cx, cy));
    Ok(Guess { lens: Lens { focal_px: Vector2::new(fx, fy), ..pinhole }, poses })
}

/// Levenberg and Marquardt's steps towards the smallest sum of squares, and whether it was reached.
fn search(views: &[View], start: Guess, free: Free) -> Result<(Guess, bool), CalibrateError> {
    let (mut guess, mut damping) = (start, 1e-3);
    let mut squares = guess.squares(views).ok_or(CalibrateError::NotConverged { steps: 0 })?;
    for _ in 0..STEPS_MAX {
        let equations = guess.equations(views, free);
        let stepped = equations.solve(damping).map(|(lens, poses)| guess.moved(&lens, &poses));
        match stepped.and_then(|next| Some((next.squares(views)?, next))) {
            Some((less, next)) if less <= squares => {
                let settled = squares - less <= SETTLED * squares;
                (guess, squares, damping) = (next, less, (damping * 0.1).max(1e-12));
                if settled {
                    return Ok((guess, true));
                }
            }
            _ => damping *= 10.0,
        }
        // No step lowers the sum any more: rounding is all that is left.
        if damping > 1e9 {
            return Ok((guess, true));
        }
    }
    Ok((guess, false))
}

/// Largest angle between two boards.
fn tilt_deg(poses: &[(Rotation3<f64>, Vector3<f64>)]) -> f64 {
    let normals: Vec<Vector3<f64>> = poses.iter().map(|(rotation, _)| rotation * Vector3::z()).collect();
    let angle = |a: &Vector3<f64>, b: &Vector3<f64>| a.cross(b).norm().atan2(a.dot(b).abs()).to_degrees();
    normals.iter().enumerate().flat_map(|(i, a)| normals[i + 1..].iter().map(move |b| angle(a, b))).fold(0.0, f64::max)
}

fn finish(views: &[View], guess: &Guess, free: Free) -> Result<Calibration, CalibrateError> {
    let of_views: Option<Vec<Vec<f64>>> = (0..views.len()).map(|i| guess.distances(views, i)).collect();
    let of_views = of_views.ok_or(CalibrateError::NotConverged { steps: STEPS_MAX })?;
    let all: Vec<f64> = of_views.iter().flatten().copied().collect();
    let freedom = (2 * all.len()).saturating_sub(free.count() + POSE_NUMBERS * views.len()).max(1);
    let variance = all.iter().map(|d| d * d).sum::<f64>() / freedom as f64;
    let undetermined = CalibrateError::Undetermined { focal_std: None };
    let (lens, poses) = guess.equations(views, free).covariances(free).ok_or_else(|| undetermined.clone())?;
    let covariance = lens * variance;
    let std: Vec<f64> = (0..LENS_NUMBERS).map(|i| covariance[(i, i)].max(0.0).sqrt()).collect();
    let share = (std[0] / guess.lens.focal_px.x).max(std[1] / guess.lens.focal_px.y);
    if !std.iter().all(|s| s.is_finite()) {
        return Err(undetermined);
    }
    if share > FOCAL_STD_MAX {
        return Err(CalibrateError::Undetermined { focal_std: Some(share) });
    }
    let pose = |((rotation, translation), covariance): (&(_, _), &PoseMatrix)| Pose {
        rotation: *rotation,
        translation: *translation,
        std: std::array::from_fn(|i| (covariance[(i, i)] * variance).max(0.0).sqrt()),
    };
    Ok(Calibration {
        lens: guess.lens,
        std: lens_of(&LensVector::from_column_slice(&std)),
        covariance,
        poses: guess.poses.iter().zip(&poses).map(pose).collect(),
        of_pictures: of_views.iter().map(|distances| Reprojection::of(distances)).collect(),
        reprojection: Reprojection::of(&all),
        place_std_px: variance.sqrt(),
    })
}

impl Reprojection {
    fn of(distances: &[f64]) -> Self {
        let n = distances.len().max(1) as f64;
        Self {
            rms_px: (distances.iter().map(|d| d * d).sum::<f64>() / n).sqrt(),
            mean_px: distances.iter().sum::<f64>() / n,
            worst_px: distances.iter().copied().fold(0.0, f64::max),
        }
    }
}

/// fx, fy, cx, cy, k1, k2, p1, p2, k3.
fn numbers_of(lens: &Lens) -> LensVector {
    let ([k1, k2, k3], [p1, p2]) = (lens.radial, lens.tangential);
    let (f, c) = (lens.focal_px, lens.centre_px);
    LensVector::from([f.x, f.y, c.x, c.y, k1, k2, p1, p2, k3])
}

fn lens_of(numbers: &LensVector) -> Lens {
    let n = |i: usize| numbers[i];
    Lens {
        focal_px: Vector2::new(n(0), n(1)),
        centre_px: Place::new(n(2), n(3)),
        radial: [n(4), n(5), n(8)],
        tangential: [n(6), n(7)],
    }
}

impl Guess {
    fn predicted(&self, picture: usize, point: Vector2<f64>) -> Option<Place> {
        let (rotation, translation) = self.poses.get(picture)?;
        self.lens.project(rotation * point.push(0.0) + translation)
    }

    fn distances(&self, views: &[View], picture: usize) -> Option<Vec<f64>> {
        let corners = &views.get(picture)?.corners;
        corners.iter().map(|(point, seen)| Some((self.predicted(picture, *point)? - seen).norm())).collect()
    }

    /// Sum of squares; `None` if a corner is behind the camera or a number is none.
    fn squares(&self, views: &[View]) -> Option<f64> {
        let of = |i| Some(self.distances(views, i)?.iter().map(|d| d * d).sum::<f64>());
        let sum: f64 = (0..views.len()).map(of).sum::<Option<f64>>()?;
        (sum.is_finite() && self.lens.focal_px.min() > 0.0).then_some(sum)
    }

    fn moved(&self, lens: &LensVector, poses: &[PoseVector]) -> Self {
        let turn = |(rotation, translation): &(Rotation3<f64>, Vector3<f64>), by: &PoseVector| {
            let turned = Rotation3::new(by.fixed_rows::<3>(0).into_owned()) * rotation;
            (turned, translation + by.fixed_rows::<3>(3))
        };
        Self {
            lens: lens_of(&(numbers_of(&self.lens) + lens)),
            poses: self.poses.iter().zip(poses).map(|(pose, by)| turn(pose, by)).collect(),
        }
    }

    /// Residual of a corner and its derivatives by the lens' numbers and the pose's (a turn about the camera's axes, a shift).
    #[allow(clippy::type_complexity)]
    fn derivatives(
        &self,
        (rotation, translation): &(Rotation3<f64>, Vector3<f64>),
        (point, seen): &(Vector2<f64>, Place),
    ) -> (Vector2<f64>, SMatrix<f64, 2, LENS_NUMBERS>, SMatrix<f64, 2, POSE_NUMBERS>) {
        let turned = rotation * point.push(0.0);
        let at = turned + translation;
        let ray = Vector2::new(at.x / at.z, at.y / at.z);
        let (bent, by_ray) = self.lens.distort(ray);
        let (f, (x, y), r2) = (self.lens.focal_px, (ray.x, ray.y), ray.norm_squared());
        let residual = bent.component_mul(&f) + self.lens.centre_px - seen;
        let mut by_lens = SMatrix::<f64, 2, LENS_NUMBERS>::zeros();
        by_lens.set_column(0, &Vector2::new(bent.x, 0.0));
        by_lens.set_column(1, &Vector2::new(0.0, bent.y));
        by_lens.set_column(2, &Vector2::x());
        by_lens.set_column(3, &Vector2::y());
        for (column, factor) in [(4, r2), (5, r2 * r2), (8, r2 * r2 * r2)] {
            by_lens.set_column(column, &(ray * factor).component_mul(&f));
        }
        by_lens.set_column(6, &Vector2::new(2.0 * x * y, r2 + 2.0 * y * y).component_mul(&f));
        by_lens.set_column(7, &Vector2::new(r2 + 2.0 * x * x, 2.0 * x * y).component_mul(&f));
        let ray_by_point = Matrix2x3::new(1.0, 0.0, -x, 0.0, 1.0, -y) / at.z;
        let by_point = SMatrix::<f64, 2, 2>::from_diagonal(&f) * by_ray * ray_by_point;
        let mut by_pose = SMatrix::<f64, 2, POSE_NUMBERS>::zeros();
        by_pose.fixed_view_mut::<2, 3>(0, 0).copy_from(&(by_point * -turned.cross_matrix()));
        by_pose.fixed_view_mut::<2, 3>(0, 3).copy_from(&by_point);
        (residual, by_lens, by_pose)
    }

    fn equations(&self, views: &[View], free: Free) -> Equations {
        let mut all = Equations { lens: LensMatrix::zeros(), lens_right: LensVector::zeros(), of_pictures: vec![] };
        for (view, pose) in views.iter().zip(&self.poses) {
            let (mut mixed, mut own, mut right) = (Mixed::zeros(), PoseMatrix::zeros(), PoseVector::zeros());
            for corner in &view.corners {
                let (residual, mut by_lens, by_pose) = self.derivatives(pose, corner);
                for i in (0..LENS_NUMBERS).filter(|i| !free.fits(*i)) {
                    by_lens.fill_column(i, 0.0);
                }
                all.lens += by_lens.transpose() * by_lens;
                all.lens_right -= by_lens.transpose() * residual;
                mixed += by_lens.transpose() * by_pose;
                own += by_pose.transpose() * by_pose;
                right -= by_pose.transpose() * residual;
            }
            all.of_pictures.push((mixed, own, right));
        }
        // A number that is not fitted stays: one equation that says so.
        for i in (0..LENS_NUMBERS).filter(|i| !free.fits(*i)) {
            all.lens[(i, i)] = 1.0;
        }
        all
    }
}

impl Equations {
    /// The step, its equations damped; `None` where they are singular.
    fn solve(&self, damping: f64) -> Option<(LensVector, Vec<PoseVector>)> {
        let mut schur = self.lens + LensMatrix::from_diagonal(&(self.lens.diagonal() * damping));
        let mut right = self.lens_right;
        let mut solved = Vec::with_capacity(self.of_pictures.len());
        for (mixed, own, own_right) in &self.of_pictures {
            let damped = own + PoseMatrix::from_diagonal(&(own.diagonal() * damping));
            let inverse = damped.cholesky()?.inverse();
            schur -= mixed * inverse * mixed.transpose();
            right -= mixed * inverse * own_right;
            solved.push(inverse);
        }
        let lens = schur.cholesky()?.solve(&right);
        let pose = |((mixed, _, right), inverse): (&(Mixed, PoseMatrix, PoseVector), &PoseMatrix)| {
            inverse * (right - mixed.transpose() * lens)
        };
        let poses = self.of_pictures.iter().zip(&solved).map(pose).collect();
        Some((lens, poses))
    }

    /// Covariances of lens and poses for a standard deviation of 1 px.
    fn covariances(&self, free: Free) -> Option<(LensMatrix, Vec<PoseMatrix>)> {
        let mut schur = self.lens;
        let mut inverses = Vec::with_capacity(self.of_pictures.len());
        for (mixed, own, _) in &self.of_pictures {
            let inverse = own.cholesky()?.inverse();
            schur -= mixed * inverse * mixed.transpose();
            inverses.push(inverse);
        }
        let mut lens = schur.cholesky()?.inverse();
        for i in (0..LENS_NUMBERS).filter(|i| !free.fits(*i)) {
            lens.fill_row(i, 0.0);
            lens.fill_column(i, 0.0);
        }
        let pose = |((mixed, ..), inverse): (&(Mixed, PoseMatrix, PoseVector), &PoseMatrix)| {
            let by = inverse * mixed.transpose();
            inverse + by * lens * by.transpose()
        };
        let poses = self.of_pictures.iter().zip(&inverses).map(pose).collect();
        Some((lens, poses))
    }
}

#[cfg(test)]
mod tests;
