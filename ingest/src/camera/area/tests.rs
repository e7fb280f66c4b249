//! Imprints whose area is known, rendered with blur, light, uneven paint and noise.

use super::*;
use crate::camera::picture::Pixels;
use crate::camera::testing::shares;
use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg64Mcg;
use rand_pcg::rand_core::Rng;

const SIZE: (usize, usize) = (480, 360);

/// A wavy outline about a middle, with round holes: r(φ) = mean (1 + wave cos(kφ)).
struct Shape {
    middle: (f64, f64),
    mean: f64,
    wave: f64,
    times: f64,
    holes: Vec<(f64, f64, f64)>,
}

impl Shape {
    fn hole_px2(&self) -> f64 {
        self.holes.iter().map(|(_, _, r)| std::f64::consts::PI * r * r).sum()
    }

    /// ½∮r² dφ, less the holes.
    fn px2(&self) -> f64 {
        std::f64::consts::PI * self.mean * self.mean * (1.0 + 0.5 * self.wave * self.wave) - self.hole_px2()
    }

    fn is_in(&self, x: f64, y: f64) -> bool {
        let (dx, dy) = (x - self.middle.0, y - self.middle.1);
        let r = self.mean * (1.0 + self.wave * (self.times * dy.atan2(dx)).cos());
        dx.hypot(dy) < r && self.holes.iter().all(|(hx, hy, hr)| (x - hx).hypot(y - hy) > *hr)
    }
}

/// How a picture is taken.
struct Taken {
    paper: [f64; 3],
    paint: [f64; 3],
    blur: f64,
    noise: f64,
    fall: f64,
    uneven: f64,
    seed: u128,
}

impl Default for Taken {
    fn default() -> Self {
        Self {
            paper: [225.0, 218.0, 196.0],
            paint: [150.0, 40.0, 38.0],
            blur: 1.6,
            noise: 3.0,
            fall: 0.25,
            uneven: 0.15,
            seed: 1,
        }
    }
}

fn picture(shape: &Shape, taken: &Taken, more: &dyn Fn(f64, f64) -> Option<[f64; 3]>) -> Picture {
    let (w, h) = SIZE;
    let shares = shares(SIZE, &|x, y| shape.is_in(x, y), taken.blur);
    let mut generator = Pcg64Mcg::new(taken.seed);
    let mut pixels = Vec::with_capacity(3 * w * h);
    for (i, share) in shares.iter().enumerate() {
        let (x, y) = ((i % w) as f64, (i / w) as f64);
        let light = 1.0 - taken.fall * (x / w as f64 - 0.5) - 0.1 * (y / h as f64 - 0.5).powi(2);
        // Thicker here, thinner there.
        let thick = 1.0 + taken.uneven * (x / 47.0 + 0.4).sin() * (y / 61.0).cos();
        let other = more(x, y);
        for k in 0..3 {
            let plain = taken.paper[k] + (taken.paint[k] - taken.paper[k]) * (share * thick);
            let z: f64 = StandardNormal.sample(&mut generator);
            let value = light * other.map_or(plain, |rgb| rgb[k]) + taken.noise * z;
            // Clamped to the range of a byte.
            #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
            pixels.push(value.round().clamp(0.0, 255.0) as u8);
        }
    }
    Picture::new(w, h, Pixels::Rgb8(pixels)).unwrap()
}

fn plain(picture: &Picture, sought: SoughtArea) -> Result<Imprint, AreaRefusal> {
    area(picture, sought, &|place| Some(place))
}

fn shape() -> Shape {
    Shape {
        middle: (241.3, 178.6),
        mean: 98.0,
        wave: 0.12,
        times: 5.0,
        holes: vec![(220.0, 170.0, 18.0), (285.4, 200.2, 9.0), (262.0, 140.0, 5.0)],
    }
}

#[test]
fn areas_and_holes_are_those_of_the_shapes_and_their_intervals_hold() {
    let mut generator = Pcg64Mcg::new(9);
    let mut uniform = |from: f64, to: f64| from + (to - from) * f64::from(generator.next_u32()) / f64::from(u32::MAX);
    let (mut held, mut worst, mut of) = (0, 0.0_f64, 0);
    for seed in 0..24 {
        let mean = uniform(70.0, 130.0);
        let middle = (uniform(225.0, 255.0), uniform(170.0, 190.0));
        let mut holes =
            vec![(middle.0 - 0.3 * mean, middle.1 + 3.0, 0.16 * mean), (middle.0 + 0.35 * mean, middle.1 - 9.3, 7.0)];
        holes.truncate(usize::try_from(seed % 3).unwrap());
        let shape = Shape { middle, mean, wave: uniform(0.0, 0.15), times: 5.0, holes };
        let paint = [[150.0, 40.0, 38.0], [40.0, 60.0, 150.0], [45.0, 42.0, 40.0]][usize::try_from(seed % 3).unwrap()];
        let taken = Taken {
            paint,
            blur: uniform(1.0, 2.5),
            noise: uniform(2.0, 5.0),
            fall: uniform(-0.25, 0.25),
            uneven: uniform(0.0, 0.2),
            seed,
            ..Taken::default()
        };
        let found = plain(&picture(&shape, &taken, &|_, _| None), SoughtArea::default()).unwrap();
        let (error, truth) = (found.area_px2 - shape.px2(), shape.px2());
        worst = worst.max((error / truth).abs());
        held += usize::from(error.abs() < 1.96 * found.std_px2);
        of += 1;
        assert_eq!(found.holes.1, shape.holes.len(), "{seed}: {found:?}");
        assert!(
            (found.holes.0 - shape.hole_px2()).abs() < 0.05 * shape.hole_px2() + 3.0,
            "{seed} {:?} {}",
            found.holes,
            shape.hole_px2()
        );
        println!("{seed} {truth:.0} {error:.1} {:.1} {:.4} %", found.std_px2, 100.0 * error / truth);
    }
    assert!(worst < 0.005, "{worst}");
    assert!((22..=24).contains(&held), "{held} of {of}");
}

#[test]
fn specks_other_colours_and_filled_holes_are_as_asked_for() {
    let (shape, taken) = (shape(), Taken::default());
    // Two specks, and a green ruler.
    let speck = |x: f64, y: f64| (x - 40.0).hypot(y - 50.0) < 2.2 || (x - 420.0).hypot(y - 60.0) < 2.2;
    let specked = picture(&shape, &taken, &|x, y| speck(x, y).then_some([150.0, 40.0, 38.0]));
    let found = plain(&specked, SoughtArea::default()).unwrap();
    assert!((found.area_px2 / shape.px2() - 1.0).abs() < 0.004 && found.specks.1 == 2, "{found:?}");
    assert!(found.notes.iter().any(|note| note.to_string().contains("2 specks of")), "{:?}", found.notes);
    let filled = plain(&specked, SoughtArea { fill_holes: true, ..SoughtArea::default() }).unwrap();
    assert!((filled.area_px2 / (shape.px2() + shape.hole_px2()) - 1.0).abs() < 0.004, "{}", filled.area_px2);
    let ruler = picture(&shape, &taken, &|_, y| (y > 320.0 && y < 350.0).then_some([60.0, 140.0, 60.0]));
    let why = plain(&ruler, SoughtArea::default()).unwrap_err();
    assert!(matches!(why, AreaRefusal::Border | AreaRefusal::Colours { .. }), "{why}");
    let named = plain(&ruler, SoughtArea { paint: Some([150.0, 40.0, 38.0]), ..SoughtArea::default() }).unwrap();
    assert!((named.area_px2 / shape.px2() - 1.0).abs() < 0.005, "{named:?}");
    assert!(named.notes.iter().any(|note| matches!(note, Note::OtherColour(_))), "{:?}", named.notes);
    // A small sticker counts as long as no paint is named, and that is told.
    let sticker = picture(&shape, &taken, &|x, y| {
        ((20.0..70.0).contains(&x) && (290.0..330.0).contains(&y)).then_some([30.0, 80.0, 170.0])
    });
    let found = plain(&sticker, SoughtArea::default()).unwrap();
    assert!((found.area_px2 - shape.px2() - 2000.0).abs() < 0.01 * shape.px2(), "{}", found.area_px2);
    assert!(found.notes.iter().any(|note| matches!(note, Note::OtherColourCounts(_))), "{:?}", found.notes);
    // A region without the ruler is as good.
    let region = Some([60, 20, 380, 290]);
    let found = plain(&ruler, SoughtArea { region, ..SoughtArea::default() }).unwrap();
    assert!((found.area_px2 / shape.px2() - 1.0).abs() < 0.005, "{}", found.area_px2);
}

#[test]
fn a_lens_changes_what_a_pixel_counts() {
    let (shape, taken) = (shape(), Taken::default());
    let seen = picture(&shape, &taken, &|_, _| None);
    let twice = area(&seen, SoughtArea::default(), &|place| Some(2.0 * place)).unwrap();
    let once = plain(&seen, SoughtArea::default()).unwrap();
    assert!((twice.area_px2 / once.area_px2 - 4.0).abs() < 1e-9);
    // Beyond what the lens is known for there is no number.
    let beyond = area(&seen, SoughtArea::default(), &|_| None).unwrap();
    assert!(beyond.area_px2.is_nan() || beyond.parts.is_empty(), "{beyond:?}");
}

#[test]
fn what_cannot_be_measured_is_refused_with_its_reason() {
    let blank = |value: u8| Picture::new(64, 48, Pixels::Rgb8(vec![value; 3 * 64 * 48])).unwrap();
    assert!(plain(&blank(200), SoughtArea::default()).is_err());
    let shape_cut = Shape { middle: (20.0, 180.0), ..shape() };
    let cut = plain(&picture(&shape_cut, &Taken::default(), &|_, _| None), SoughtArea::default());
    assert_eq!(cut, Err(AreaRefusal::Border));
    let noise = Shape { mean: 0.0, holes: vec![], ..shape() };
    let none = plain(&picture(&noise, &Taken { noise: 6.0, ..Taken::default() }, &|_, _| None), SoughtArea::default());
    assert!(none.is_err(), "{none:?}");
    let bright = Taken { paper: [400.0; 3], paint: [300.0, 290.0, 280.0], fall: 0.0, ..Taken::default() };
    let saturated = plain(&picture(&shape(), &bright, &|_, _| None), SoughtArea::default());
    assert!(saturated.is_err(), "{saturated:?}");
    let region = Some([0, 0, 5, 5]);
    assert_eq!(plain(&blank(9), SoughtArea { region, ..SoughtArea::default() }), Err(AreaRefusal::Region));
}
