use super::super::super::picture::Pixels;
use super::*;
use nalgebra::Rotation2;
use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg64Mcg;
use statrs::function::erf::erf;

/// An ellipse: middle, semi-axes, direction.
type Truth = (Place, [f64; 2], f64);

/// Share of the ellipse under a Gaussian about a place, exact in one direction and summed in the other: true blur, curved edge and all.
fn share(at: Place, (centre, [a, b], turn): Truth, blur: f64) -> f64 {
    let d = Rotation2::new(-turn) * (at - centre);
    let reach = 5.0 * blur;
    let inner = (d.x / a).hypot(d.y / b);
    let margin = reach / b;
    if inner < 1.0 - margin {
        return 1.0;
    }
    if inner > 1.0 + margin {
        return 0.0;
    }
    let steps = 60;
    let width = 2.0 * reach / f64::from(steps);
    let one = |k: i32| {
        let y = -reach + (f64::from(k) + 0.5) * width;
        let half = a * (1.0 - ((d.y + y) / b).powi(2)).max(0.0).sqrt();
        let side = |x: f64| erf((x - d.x) / (blur * std::f64::consts::SQRT_2));
        0.5 * (side(half) - side(-half)) * (-0.5 * (y / blur).powi(2)).exp()
    };
    let sum: f64 = (0..steps).map(one).sum();
    sum * width / (blur * std::f64::consts::TAU.sqrt())
}

struct Scene {
    size: (usize, usize),
    discs: Vec<Truth>,
    blur: f64,
    levels: (f64, f64),
    noise: f64,
}

impl Scene {
    fn one(centre: (f64, f64), axes: [f64; 2], turn: f64) -> Self {
        let discs = vec![(Place::new(centre.0, centre.1), axes, turn)];
        Self { size: (240, 200), discs, blur: 1.5, levels: (60.0, 190.0), noise: 0.0 }
    }

    fn picture(&self, generator: &mut Pcg64Mcg, of: impl Fn(Place) -> Place) -> Picture {
        let mut pixels = vec![];
        for y in 0..self.size.1 {
            for x in 0..self.size.0 {
                let at = of(Place::new(x as f64, y as f64));
                let part: f64 = self.discs.iter().map(|truth| share(at, *truth, self.blur)).sum();
                let light = 1.0 + 3e-4 * (x as f64 - y as f64);
                let z: f64 = StandardNormal.sample(generator);
                let luma = (self.levels.0 + (self.levels.1 - self.levels.0) * part) * light + self.noise * z;
                // Clamped to what sixteen bits hold.
                #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
                pixels.push((luma * 257.0).round().clamp(0.0, 65535.0) as u16);
            }
        }
        Picture::new(self.size.0, self.size.1, Pixels::Gray16(pixels)).unwrap()
    }

    fn found(&self, generator: &mut Pcg64Mcg) -> Result<Disc, DiscError> {
        find(&self.picture(generator, |at| at), None, None)
    }
}

#[test]
fn the_diameter_comes_back_without_the_bias_of_blur_bright_or_dark() {
    let mut generator = Pcg64Mcg::new(31);
    for radius in [12.3, 30.1, 70.7] {
        {
            for (blur, levels) in [(0.9, (60.0, 190.0)), (2.0, (200.0, 40.0))] {
                let scene = Scene { blur, levels, ..Scene::one((118.3, 97.6), [radius; 2], 0.0) };
                let found = scene.found(&mut generator).unwrap();
                let off = found.diameter_px - 2.0 * radius;
                // The light falls off across the disc; at the second order in blur over radius, something is left.
                let second_order = 2.0 * blur * (blur / radius).powi(3);
                assert!(off.abs() < 0.006 + second_order, "{radius} {blur}: {off} {found:?}");
                // Without the correction it would be too small by so much.
                assert!(
                    (found.correction_px - (blur * blur + 1.0 / 6.0) / radius).abs() < 0.15 * found.correction_px,
                    "{found:?}"
                );
                assert_eq!(found.is_bright, levels.1 > levels.0);
                assert!((found.centre - Place::new(118.3, 97.6)).norm() < 0.02);
            }
        }
    }
}

#[test]
fn it_scatters_as_stated() {
    let mut generator = Pcg64Mcg::new(32);
    let (mut squares, mut bias, n) = (0.0, 0.0, 8);
    for i in 0..n {
        let centre = (100.0 + 0.37 * f64::from(i), 90.0 + 0.21 * f64::from(i));
        let scene = Scene { noise: 4.0, ..Scene::one(centre, [40.3; 2], 0.0) };
        let found = scene.found(&mut generator).unwrap();
        let z = (found.diameter_px - 80.6) / found.std_px;
        squares += z * z / f64::from(n);
        bias += (found.diameter_px - 80.6) / f64::from(n);
        assert!(found.std_px < 0.08 && found.tilt_rad < 0.15, "{found:?}");
    }
    assert!((0.2..2.0).contains(&squares) && bias.abs() < 0.03, "{squares} {bias}");
}

#[test]
fn a_tilted_disc_shows_its_diameter_along_the_longer_axis() {
    let mut generator = Pcg64Mcg::new(33);
    let tilt = 0.5_f64;
    let scene = Scene { noise: 2.0, ..Scene::one((120.0, 100.0), [60.0, 60.0 * tilt.cos()], 0.7) };
    let found = scene.found(&mut generator).unwrap();
    assert!((found.diameter_px - 120.0).abs() < 0.1, "{found:?}");
    assert!((found.tilt_rad - tilt).abs() < 0.01 && found.tilt_rad_max > found.tilt_rad, "{found:?}");
    assert!((found.direction_rad - 0.7).abs() < 0.01, "{found:?}");
    let scale = found.scale(Length { metre: 0.02, std: 2e-5 }).unwrap();
    assert!((scale.metre_per_px - 0.02 / 120.0).abs() < 3e-7 && scale.std > 1e-3 * scale.metre_per_px);
}

#[test]
fn behind_a_lens_the_diameter_is_that_of_the_straight_picture() {
    let lens = Lens { radial: [-0.12, 0.02, 0.0], ..Lens::pinhole(260.0, Place::new(120.0, 100.0)) };
    let scene = Scene { blur: 1.2, ..Scene::one((150.0, 115.0), [50.0; 2], 0.0) };
    let picture = scene.picture(&mut Pcg64Mcg::new(34), |at| lens.straight(at).unwrap());
    let found = find(&picture, None, Some(&lens)).unwrap();
    assert!((found.diameter_px - 100.0).abs() < 0.03, "{found:?}");
    let bent = find(&picture, None, None).unwrap();
    assert!(bent.diameter_px < 99.5, "{bent:?}");
}

#[test]
fn what_touches_it_is_left_out_and_holes_do_not_matter() {
    let mut generator = Pcg64Mcg::new(35);
    let mut scene = Scene { noise: 2.0, ..Scene::one((120.0, 100.0), [60.0; 2], 0.0) };
    // A dark hole inside, and a nick in the rim.
    scene.discs.push((Place::new(110.0, 110.0), [12.0, 9.0], 0.3));
    let picture = scene.picture(&mut generator, |at| at);
    let Pixels::Gray16(mut pixels) = picture.pixels().clone() else { panic!() };
    for y in 0..200 {
        for x in 0..240 {
            let i = y * 240 + x;
            let d = Place::new(x as f64 - 110.0, y as f64 - 110.0);
            if d.norm() < 11.0 || (x > 172 && (92..104).contains(&y)) {
                pixels[i] = 60 * 257;
            }
        }
    }
    let picture = Picture::new(240, 200, Pixels::Gray16(pixels)).unwrap();
    let found = find(&picture, None, None).unwrap();
    assert!((found.diameter_px - 120.0).abs() < 0.12, "{found:?}");
    assert!(found.lines.0 < found.lines.1, "{found:?}");
}

#[test]
fn no_disc_two_discs_and_a_cut_one_are_refused() {
    let mut generator = Pcg64Mcg::new(36);
    let flat = Scene { discs: vec![], noise: 3.0, ..Scene::one((0.0, 0.0), [1.0; 2], 0.0) };
    assert!(matches!(flat.found(&mut generator), Err(DiscError::NoDisc | DiscError::Border)));
    let mut two = Scene::one((60.0, 100.0), [40.0; 2], 0.0);
    two.discs.push((Place::new(170.0, 100.0), [35.0; 2], 0.0));
    assert!(matches!(two.found(&mut generator), Err(DiscError::Several { .. })));
    // With the part that holds it, it is one.
    let part = Some([Place::new(5.0, 5.0), Place::new(115.0, 190.0)]);
    let one = find(&two.picture(&mut generator, |at| at), part, None).unwrap();
    assert!((one.diameter_px - 80.0).abs() < 0.01, "{one:?}");
    let cut = Scene::one((20.0, 100.0), [40.0; 2], 0.0);
    assert_eq!(cut.found(&mut generator), Err(DiscError::Border));
    // A square is no disc.
    let square: Vec<u8> = (0..240 * 200)
        .map(|i| if (60..160).contains(&(i % 240)) && (50..150).contains(&(i / 240)) { 190 } else { 60 })
        .collect();
    let square = Picture::new(240, 200, Pixels::Gray8(square)).unwrap();
    assert_eq!(find(&square, None, None), Err(DiscError::NoDisc));
    let nowhere = Some([Place::repeat(f64::NAN), Place::zeros()]);
    assert_eq!(find(&square, nowhere, None), Err(DiscError::Region));
}
