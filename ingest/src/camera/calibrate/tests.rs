use super::*;
use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg64Mcg;

const SIZE: (usize, usize) = (1280, 960);

fn lens() -> Lens {
    Lens {
        focal_px: Vector2::new(1205.0, 1198.0),
        centre_px: Place::new(655.0, 470.0),
        radial: [-0.21, 0.12, -0.05],
        tangential: [0.0012, -0.0008],
    }
}

/// Turns about x and y in degrees, and where the board's middle is, in m.
type Shot = (f64, f64, [f64; 3]);

const SHOTS: [Shot; 6] = [
    (25.0, 5.0, [0.0, 0.0, 0.35]),
    (-30.0, 10.0, [0.05, 0.03, 0.40]),
    (5.0, 30.0, [-0.06, -0.03, 0.36]),
    (-10.0, -28.0, [0.04, -0.05, 0.42]),
    (20.0, -20.0, [-0.05, 0.05, 0.38]),
    (0.0, 8.0, [0.02, 0.0, 0.30]),
];

/// Corners of a board of 9 x 6 squares of 25 mm.
fn views(shots: &[Shot], noise_px: f64, generator: &mut Pcg64Mcg) -> Vec<View> {
    let view = |(a, b, at): &Shot| {
        let rotation = Rotation3::from_euler_angles(a.to_radians(), b.to_radians(), 0.1);
        let mut corners = vec![];
        for i in 0..54 {
            let point = Vector2::new(f64::from(i % 9) - 4.0, f64::from(i / 9) - 2.5) * 0.025;
            let seen = lens().project(rotation * point.push(0.0) + Vector3::from(*at)).unwrap();
            let mut noise = || noise_px * Distribution::<f64>::sample(&StandardNormal, generator);
            corners.push((point, seen + Vector2::new(noise(), noise())));
        }
        View { corners }
    };
    shots.iter().map(view).collect()
}

#[test]
fn exact_corners_give_the_exact_lens_and_poses() {
    let found = calibrate(&views(&SHOTS, 0.0, &mut Pcg64Mcg::new(1)), SIZE, Free::default()).unwrap();
    let difference = numbers_of(&found.lens) - numbers_of(&lens());
    assert!(difference.norm() < 1e-5, "{difference}");
    assert!(found.reprojection.rms_px < 1e-7, "{:?}", found.reprojection);
    let (a, b, at) = SHOTS[1];
    let rotation = Rotation3::from_euler_angles(a.to_radians(), b.to_radians(), 0.1);
    let turned = (found.poses[1].rotation.matrix() - rotation.matrix()).norm();
    assert!(turned < 1e-7, "{turned}");
    assert!((found.poses[1].translation - Vector3::from(at)).norm() < 1e-7);
}

#[test]
fn derivatives_are_the_differences() {
    let views = views(&SHOTS, 0.0, &mut Pcg64Mcg::new(1));
    let rotation = Rotation3::from_euler_angles(0.4, -0.2, 0.3);
    let guess = Guess { lens: lens(), poses: vec![(rotation, Vector3::new(0.03, -0.02, 0.4))] };
    let corner = views[0].corners[7];
    let (_, by_lens, by_pose) = guess.derivatives(&guess.poses[0], &corner);
    let residual = |guess: &Guess| guess.derivatives(&guess.poses[0], &corner).0;
    for i in 0..LENS_NUMBERS {
        let by = |h: f64| {
            residual(&guess.moved(&LensVector::from_fn(|j, _| if i == j { h } else { 0.0 }), &[PoseVector::zeros()]))
        };
        let difference = (by(1e-5) - by(-1e-5)) / 2e-5;
        assert!((difference - by_lens.column(i)).norm() < 1e-5, "lens {i}: {difference}");
    }
    for i in 0..POSE_NUMBERS {
        let by = |h: f64| {
            residual(&guess.moved(&LensVector::zeros(), &[PoseVector::from_fn(|j, _| if i == j { h } else { 0.0 })]))
        };
        let difference = (by(1e-6) - by(-1e-6)) / 2e-6;
        assert!((difference - by_pose.column(i)).norm() < 1e-4, "pose {i}: {difference}");
    }
}

#[test]
fn numbers_scatter_as_stated() {
    let mut generator = Pcg64Mcg::new(11);
    let truth = numbers_of(&lens());
    let (mut squares, mut depth, n) = (LensVector::zeros(), 0.0, 120);
    for _ in 0..n {
        let found = calibrate(&views(&SHOTS, 0.1, &mut generator), SIZE, Free::default()).unwrap();
        let std = numbers_of(&found.std);
        squares += (numbers_of(&found.lens) - truth).component_div(&std).map(|z| z * z) / f64::from(n);
        depth += ((found.poses[2].translation.z - 0.36) / found.poses[2].std[5]).powi(2) / f64::from(n);
        assert!((found.place_std_px - 0.1).abs() < 0.012);
        assert!(found.reprojection.mean_px < found.reprojection.rms_px);
    }
    assert!(squares.iter().all(|share| (share - 1.0).abs() < 0.45), "{squares}");
    assert!((depth - 1.0).abs() < 0.45, "{depth}");
}

#[test]
fn what_is_not_fitted_stays_nought() {
    let free = Free { radial: 1, tangential: false };
    let found = calibrate(&views(&SHOTS, 0.05, &mut Pcg64Mcg::new(2)), SIZE, free).unwrap();
    assert!(found.lens.radial[0] < -0.1 && found.std.radial[0] > 0.0);
    assert_eq!((found.lens.radial[1], found.lens.radial[2], found.lens.tangential), (0.0, 0.0, [0.0; 2]));
    assert_eq!((found.std.radial[1], found.std.tangential), (0.0, [0.0; 2]));
}

#[test]
fn pictures_that_say_too_little_are_refused_with_a_reason() {
    let mut generator = Pcg64Mcg::new(3);
    let few = calibrate(&views(&SHOTS[..2], 0.0, &mut generator), SIZE, Free::default());
    assert_eq!(few, Err(CalibrateError::FewPictures { found: 2 }));
    let flat: Vec<Shot> = [0.30, 0.35, 0.40, 0.45].map(|z| (0.0, 0.0, [0.01, 0.0, z])).to_vec();
    let parallel = calibrate(&views(&flat, 0.05, &mut generator), SIZE, Free::default()).unwrap_err();
    let told = matches!(parallel, CalibrateError::Parallel { .. } | CalibrateError::Undetermined { .. });
    assert!(told, "{parallel}");
    let tilted: Vec<Shot> = [0.30, 0.35, 0.40, 0.45].map(|z| (25.0, 0.0, [0.01, 0.0, z])).to_vec();
    let parallel = calibrate(&views(&tilted, 0.05, &mut generator), SIZE, Free::default()).unwrap_err();
    assert!(matches!(parallel, CalibrateError::Parallel { .. }), "{parallel}");
    assert!(parallel.to_string().contains("tilted"), "{parallel}");
    let mut torn = views(&SHOTS, 0.0, &mut generator);
    torn[0].corners[3].1.x = f64::NAN;
    assert_eq!(calibrate(&torn, SIZE, Free::default()), Err(CalibrateError::NotFinite));
    let mut line = views(&SHOTS, 0.0, &mut generator);
    line[0].corners.truncate(9);
    assert_eq!(calibrate(&line, SIZE, Free::default()), Err(CalibrateError::Alike));
}
