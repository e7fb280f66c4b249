//! Paint on paper: shapes and holes of known area, of a colour that is uneven.

use pneuval_ingest::camera::picture::Place;

use super::camera::{Camera, View};
use super::canvas::{Layer, Uneven, shoot};
use super::extras::{CORNERS, scene};
use super::settings::Settings;
use super::shape::{Shape, area_m2};
use super::{NoPhotograph, Photograph};

/// From thin place to thin place, as a share of the picture's width.
const PERIOD: f64 = 0.07;

/// Of the thinning, this share is everywhere.
const EVERYWHERE: f32 = 0.2;

/// An imprint.
#[derive(Debug, Clone, PartialEq)]
pub struct Imprint {
    /// What is painted, all together.
    pub shapes: Vec<Shape>,
    /// What is not.
    pub holes: Vec<Shape>,
    /// By how much the paper shows through at most, as a share: 0 is even.
    pub uneven: f64,
}

/// What is known of it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ImprintTruth {
    /// What is painted, in m².
    pub area_m2: f64,
}

/// An outline as it is seen.
fn seen(view: &View, shape: &Shape) -> Result<Vec<Place>, NoPhotograph> {
    let corners = 4 * CORNERS;
    let at = |i: usize| shape.at(i as f64 * std::f64::consts::TAU / corners as f64);
    (0..corners).map(|i| view.flat(at(i).x, at(i).y)).collect()
}

/// Photographs an imprint; the paint is the settings' object.
///
/// # Errors
/// [`NoPhotograph`] for numbers that nothing has.
pub fn imprint(
    imprint: &Imprint,
    camera: &Camera,
    settings: &Settings,
    seed: u64,
) -> Result<Photograph<ImprintTruth>, NoPhotograph> {
    let view = camera.checked()?.view();
    let Imprint { shapes, holes, uneven } = imprint;
    if !shapes.iter().chain(holes).all(Shape::is_sound) || !(0.0..1.0).contains(uneven) {
        let expected = "an imprint: expected shapes with sides above 0 m, and paper that shows through by 0 to 1";
        return Err(NoPhotograph::Number(expected));
    }
    let outlines = |all: &[Shape]| all.iter().map(|shape| seen(&view, shape)).collect::<Result<_, _>>();
    #[expect(clippy::cast_possible_truncation, reason = "a share")]
    let through = *uneven as f32;
    let layer = Layer {
        outlines: outlines(shapes)?,
        holes: outlines(holes)?,
        light: settings.object,
        uneven: (*uneven > 0.0).then_some(Uneven {
            through: [EVERYWHERE * through, (1.0 - EVERYWHERE) * through],
            period_px: PERIOD * camera.width as f64,
            phases: [1.0, 2.0],
        }),
    };
    let truth = ImprintTruth { area_m2: area_m2(shapes, holes) };
    shoot(camera, settings, &scene(camera, settings, vec![layer], None), seed, truth)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_paint_in_the_picture_is_the_true_area() {
        let camera = Camera { roll_rad: 0.3, ..Camera::facing(400, 300, 1e-4, 0.3) };
        let settings = Settings { noise: 0.0, background: [1.0; 3], object: [0.0; 3], ..Settings::default() };
        let blot = Shape::Blot { middle_m: [-0.004, 0.0], radius_m: 0.008, waves: vec![[0.1, 0.5], [0.05, 2.0]] };
        let bar = Shape::Rectangle { middle_m: [0.004, 0.001], half_m: [0.008, 0.003], corner_m: 0.001, turn_rad: 0.4 };
        let holes = vec![Shape::disc([-0.004, 0.001], 0.002), Shape::disc([0.0, 0.0], 0.001)];
        let of = Imprint { shapes: vec![blot, bar], holes, uneven: 0.0 };
        let Photograph { picture, truth } = imprint(&of, &camera, &settings, 1).unwrap();
        let luma = |i: usize| f64::from(picture.luma(i % 400, i / 400)) / 255.0;
        let paint: f64 = (0..120_000).map(|i| 1.0 - luma(i)).sum();
        assert!((paint * 1e-8 / truth.area_m2 - 1.0).abs() < 1e-4, "{} {}", paint * 1e-8, truth.area_m2);
        // Thin paint is less dark, and covers the same.
        let thin = imprint(&Imprint { uneven: 0.4, ..of.clone() }, &camera, &settings, 1).unwrap();
        let thin_paint: f64 = (0..120_000).map(|i| 1.0 - f64::from(thin.picture.luma(i % 400, i / 400)) / 255.0).sum();
        assert!(thin_paint < 0.95 * paint && thin_paint > 0.6 * paint && thin.truth == truth);
        assert!(imprint(&Imprint { uneven: 1.0, ..of }, &camera, &settings, 1).is_err());
    }
}
