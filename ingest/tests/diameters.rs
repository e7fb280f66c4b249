//! Diameters from pictures whose truth is known: where they are told, how surely, and what is refused.

// In a test a panic is how a failure is told.
#![allow(clippy::unwrap_used, clippy::panic)]

use pneuval_ingest::camera::diameter::{Diameter, Flag, diameter};
use pneuval_ingest::camera::picture::{Picture, Pixels, Place};
use pneuval_ingest::camera::silhouette::{Axis, Refusal, Sought};
use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg64Mcg;
use statrs::distribution::{ContinuousCDF, Normal};

/// A barrel on a rod: r(v) = ends + (middle - ends)(1 - (2v/length)²).
#[derive(Clone)]
struct Barrel {
    size: (usize, usize),
    centre: (f64, f64),
    tilt: f64,
    length: f64,
    ends: f64,
    middle: f64,
    blur: f64,
    noise: f64,
    levels: (f64, f64),
    /// Light over the picture, at a place from -1 to 1.
    light: fn(f64, f64) -> f64,
    seed: u64,
}

impl Default for Barrel {
    fn default() -> Self {
        Self {
            size: (480, 360),
            centre: (241.3, 172.8),
            tilt: 0.05,
            length: 210.0,
            ends: 30.0,
            middle: 70.25,
            blur: 1.6,
            noise: 3.0,
            levels: (190.0, 50.0),
            light: |_, _| 1.0,
            seed: 1,
        }
    }
}

impl Barrel {
    /// Brightness without noise, `more` drawn over it.
    fn picture(&self, more: &dyn Fn(f64, f64, f64) -> f64) -> Picture {
        let normal = Normal::standard();
        let mut generator = Pcg64Mcg::new(u128::from(self.seed));
        let (w, h) = self.size;
        let mut pixels = Vec::with_capacity(w * h);
        for i in 0..w * h {
            let (x, y) = ((i % w) as f64, (i / w) as f64);
            let (s, c) = self.tilt.sin_cos();
            let (dx, dy) = (x - self.centre.0, y - self.centre.1);
            let (u, v) = (dx * c + dy * s, dy * c - dx * s);
            let t = (2.0 * v / self.length).clamp(-1.0, 1.0);
            let profile = self.ends + (self.middle - self.ends) * (1.0 - t * t);
            let slope = -(self.middle - self.ends) * 4.0 * t / self.length;
            let side = (profile - u.abs()) / slope.hypot(1.0);
            let rod = (0.5 * self.ends - u.abs()).min(if v > 0.0 { 1e4 } else { -1e4 });
            let inside = side.min(0.5 * self.length - v.abs()).max(rod);
            let body = normal.cdf(inside / self.blur);
            let light = (self.light)(2.0 * x / w as f64 - 1.0, 2.0 * y / h as f64 - 1.0);
            let z: f64 = StandardNormal.sample(&mut generator);
            let plain = light * (self.levels.0 * (1.0 - body) + self.levels.1 * body);
            let value = more(x, y, plain) + self.noise * z;
            // Clamped to the range of a byte.
            #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
            pixels.push(value.round().clamp(0.0, 255.0) as u8);
        }
        Picture::new(w, h, Pixels::Gray8(pixels)).unwrap()
    }

    fn plain(&self) -> Picture {
        self.picture(&|_, _, plain| plain)
    }

    fn truth(&self) -> f64 {
        2.0 * self.middle
    }
}

fn measured(picture: &Picture, sought: Sought) -> Result<Diameter, Refusal> {
    diameter(picture, sought, &|place| Some(place))
}

fn found(picture: &Picture) -> Diameter {
    measured(picture, Sought::default()).unwrap()
}

/// Off by less than so many px, and by less than four of its standard uncertainties.
fn near(found: &Diameter, truth: f64, within: f64) {
    let off = (found.width_px - truth).abs();
    assert!(
        off < within && off < 4.0 * found.std_px,
        "{} ± {} is not {truth}: {:?}",
        found.width_px,
        found.std_px,
        found.flags
    );
}

#[test]
fn the_largest_width_is_found_to_a_few_hundredths_of_a_pixel_and_the_interval_says_so() {
    let (mut held, mut held_tilt, mut squares, n) = (0, 0, 0.0, 60);
    for seed in 0..n {
        let at = |k: u64| f64::from(u32::try_from((seed * k) % 97).unwrap()) / 97.0;
        let barrel = Barrel {
            seed,
            centre: (240.0 + at(13), 170.0 + at(29)),
            tilt: 0.2 * (at(41) - 0.5),
            middle: 60.0 + 30.0 * at(53),
            blur: 1.2 + 1.3 * at(61),
            ..Barrel::default()
        };
        let found = found(&barrel.plain());
        near(&found, barrel.truth(), 0.15);
        let off = found.width_px - barrel.truth();
        squares += off * off;
        held += u32::from(off.abs() < 1.96 * found.std_px);
        let turned = (-found.axis.x).atan2(found.axis.y) - barrel.tilt;
        assert!(turned.abs() < 0.5_f64.to_radians(), "{turned}");
        held_tilt += u32::from(turned.abs() < 1.96 * found.axis_std_rad);
        assert!((found.blur_px - barrel.blur).abs() < 0.1, "{} {}", found.blur_px, barrel.blur);
        assert!((found.noise - 3.0).abs() < 0.2 && (found.levels.1 - found.levels.0 - 140.0).abs() < 4.0, "{found:?}");
    }
    assert!((squares / f64::from(u32::try_from(n).unwrap())).sqrt() < 0.04);
    assert!((54..=60).contains(&held) && (53..=60).contains(&held_tilt), "{held} and {held_tilt} of {n}");
}

#[test]
fn a_bright_body_a_lying_one_and_a_tilted_one_are_measured_alike() {
    let dark = Barrel::default();
    near(&found(&Barrel { levels: (40.0, 200.0), ..dark.clone() }.plain()), dark.truth(), 0.1);
    let lying = Barrel { tilt: std::f64::consts::FRAC_PI_2 + 0.1, ..dark.clone() };
    let along = found(&lying.plain());
    near(&along, dark.truth(), 0.1);
    assert!(along.axis.x.abs() > 0.99, "{}", along.axis);
    for tilt in [-0.5, 0.3, 0.6] {
        let tilted = found(&Barrel { tilt, ..dark.clone() }.plain());
        near(&tilted, dark.truth(), 0.1);
        assert!(((-tilted.axis.x).atan2(tilted.axis.y) - tilt).abs() < 0.02, "{} {tilt}", tilted.axis);
        let ends = tilted.ends;
        assert!(
            ((ends[1] - ends[0]).norm() - tilted.width_px).abs() < 0.1
                && (ends[1] - ends[0]).dot(&tilted.axis).abs() < 0.1
        );
    }
}

#[test]
fn uneven_light_glare_and_a_busy_border_do_not_move_it() {
    let barrel =
        Barrel { light: |x, y| 1.0 + 0.3 * x - 0.15 * y - 0.1 * x * x, levels: (150.0, 40.0), ..Barrel::default() };
    near(&found(&barrel.plain()), barrel.truth(), 0.1);
    let barrel = Barrel::default();
    // A band of glare within the body, and a spot of it over one edge.
    let glare = |x: f64, y: f64, plain: f64| {
        let band = 150.0 * (-((x - 222.0) / 8.0).powi(2)).exp() * f64::from(u8::from((y - 172.0).abs() < 60.0));
        let spot = 120.0 * (-((x - 311.0) / 5.0).powi(2) - ((y - 150.0) / 6.0).powi(2)).exp();
        plain + band + spot
    };
    near(&found(&barrel.picture(&glare)), barrel.truth(), 0.15);
    // Dark things that come in from the border, one of them thick.
    let clutter = |x: f64, y: f64, plain: f64| {
        let table = y > 330.0;
        let shelf = x < 40.0 && y < 120.0;
        let cable = ((x - 430.0) - 0.2 * y).abs() < 6.0;
        if table || shelf || cable { 45.0 } else { plain }
    };
    near(&found(&barrel.picture(&clutter)), barrel.truth(), 0.1);
    // Dirt on one edge is left out, and told.
    let dirt = |x: f64, y: f64, plain: f64| {
        if (165.0..175.0).contains(&x) && (160.0..175.0).contains(&y) { 50.0 } else { plain }
    };
    let dirty = found(&barrel.picture(&dirt));
    near(&dirty, barrel.truth(), 0.15);
    assert!(dirty.flags.iter().any(|flag| matches!(flag, Flag::Strays(share) if *share > 0.02)), "{:?}", dirty.flags);
}

#[test]
fn a_cylinder_from_border_to_border_has_a_width_and_a_profile() {
    let pipe = Barrel { length: 4000.0, ends: 54.3, middle: 54.3, tilt: 0.02, ..Barrel::default() };
    let pipe_found = found(&pipe.plain());
    near(&pipe_found, pipe.truth(), 0.05);
    assert!(pipe_found.flags.contains(&Flag::Cut) && pipe_found.degree == 0, "{:?}", pipe_found.flags);
    assert!(pipe_found.profile.len() > 60);
    let mean = pipe_found.profile.iter().map(|w| w.width_px).sum::<f64>() / pipe_found.profile.len() as f64;
    assert!((mean - pipe.truth()).abs() < 0.05, "{mean}");
    // Of the barrel the profile is its parabola.
    let barrel = Barrel { noise: 0.5, ..Barrel::default() };
    for width in found(&barrel.plain()).profile.iter().filter(|w| w.along_px.abs() < 60.0) {
        let t = 2.0 * width.along_px / barrel.length;
        let expected = 2.0 * (barrel.ends + (barrel.middle - barrel.ends) * (1.0 - t * t));
        assert!((width.width_px - expected).abs() < 0.5, "{width:?} {expected}");
    }
}

#[test]
fn what_cannot_be_measured_is_refused_with_the_reason() {
    let barrel = Barrel::default();
    let refused = |picture: &Picture| measured(picture, Sought::default()).unwrap_err();
    let empty = barrel.picture(&|_, _, _| 180.0);
    assert!(matches!(refused(&empty), Refusal::NoBody | Refusal::NoContrast { .. }), "{}", refused(&empty));
    let shaded = Barrel { levels: (150.0, 150.0), light: |x, y| 1.0 + 0.4 * x + 0.2 * y, ..barrel.clone() };
    assert!(matches!(refused(&shaded.plain()), Refusal::NoBody | Refusal::NoContrast { .. }));
    // Two of a size: the region says which.
    let twin = |x: f64, y: f64, plain: f64| if (x - 420.0).hypot(y - 100.0) < 50.0 { 50.0 } else { plain };
    let twins = barrel.picture(&twin);
    assert!(matches!(refused(&twins), Refusal::SeveralBodies { .. }));
    let region = Sought { region: Some([100, 20, 250, 320]), ..Sought::default() };
    near(&measured(&twins, region).unwrap(), barrel.truth(), 0.1);
    // Half out of the picture, to the side and below.
    for centre in [(20.0, 170.0), (465.0, 170.0)] {
        let out = refused(&Barrel { centre, ..barrel.clone() }.plain());
        assert!(matches!(out, Refusal::Border | Refusal::NoBody), "{centre:?}: {out}");
    }
    let below = Barrel { centre: (240.0, 380.0), ends: 20.0, ..barrel.clone() };
    assert!(matches!(refused(&below.plain()), Refusal::Border | Refusal::NoBody), "{}", refused(&below.plain()));
    // So bright that half of the way is anywhere.
    let burnt = Barrel { levels: (400.0, 40.0), ..barrel.clone() };
    assert!(matches!(refused(&burnt.plain()), Refusal::Saturated { .. }));
    // Just as bright as it can be: clipped noise alone hardly moves it.
    let bright = Barrel { levels: (254.0, 60.0), noise: 1.0, ..barrel };
    assert!(
        measured(&bright.plain(), Sought::default()).is_err()
            || (found(&bright.plain()).width_px - bright.truth()).abs() < 0.1
    );
}

#[test]
fn the_user_may_say_which_way_the_axis_lies() {
    let wide = Barrel { length: 120.0, middle: 70.0, ends: 50.0, ..Barrel::default() };
    let upright = measured(&wide.plain(), Sought { axis: Some(Axis::Vertical), ..Sought::default() }).unwrap();
    near(&upright, wide.truth(), 0.1);
    let colour = Picture::new(2, 2, Pixels::Rgb8(vec![0; 12])).unwrap();
    assert_eq!(measured(&colour, Sought::default()), Err(Refusal::NoBody));
    // A lens that makes everything half as large.
    let half = |place: Place| Some(place * 0.5);
    let seen = diameter(&wide.plain(), Sought { axis: Some(Axis::Vertical), ..Sought::default() }, &half).unwrap();
    assert!((seen.width_px - wide.middle).abs() < 0.1, "{}", seen.width_px);
}
