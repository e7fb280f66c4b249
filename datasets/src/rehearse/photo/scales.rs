//! Chessboard, disc and ruler: what a scale is measured from.

use super::camera::{Camera, View};
use super::canvas::{Layer, shoot};
use super::extras::{ellipse, scene};
use super::settings::Settings;
use super::{NoPhotograph, Photograph};

use pneuval_ingest::camera::picture::Place;

/// Places along the side of a square or a mark, for lenses that bend it.
const SIDE: usize = 24;

/// Width of a mark, in pitches; lengths of marks, of fifth and of tenth ones, in pitches.
const MARK_WIDTH: f64 = 0.2;
const MARK_LENGTHS: [f64; 3] = [5.0, 7.0, 9.0];

/// More squares or marks are none.
const PARTS_MAX: usize = 10_000;

/// What is laid before the camera.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Object {
    /// A chessboard with so many inner corners in a row, rows of them, and squares of a side in m.
    Chessboard {
        /// Inner corners of a row.
        columns: usize,
        /// Rows of inner corners.
        rows: usize,
        /// In m.
        square_m: f64,
    },
    /// A disc: a coin.
    Disc {
        /// In m.
        diameter_m: f64,
    },
    /// A ruler with so many marks at a pitch in m, along x.
    Ruler {
        /// In m.
        pitch_m: f64,
        /// Marks.
        marks: usize,
    },
}

/// What is known of the scale.
#[derive(Debug, Clone, PartialEq)]
pub struct ScaleTruth {
    /// Metres in a px in the plane through the object's middle, square to the optical axis.
    pub metre_per_px: f64,
    /// Inner corners of a chessboard row by row, middles of marks, or the middle of a disc, as they are seen.
    pub places_px: Vec<Place>,
}

/// A rectangle as it is seen, with places along its sides.
fn rectangle(view: &View, from: [f64; 2], to: [f64; 2]) -> Result<Vec<Place>, NoPhotograph> {
    let corners = [[from[0], from[1]], [to[0], from[1]], [to[0], to[1]], [from[0], to[1]]];
    let at = |i: usize| {
        let ([a, b], part) = ([corners[i / SIDE], corners[(i / SIDE + 1) % 4]], (i % SIDE) as f64 / SIDE as f64);
        view.flat(a[0] + part * (b[0] - a[0]), a[1] + part * (b[1] - a[1]))
    };
    (0..4 * SIDE).map(at).collect()
}

fn board(
    view: &View,
    columns: usize,
    rows: usize,
    square_m: f64,
) -> Result<(Vec<Vec<Place>>, Vec<Place>), NoPhotograph> {
    let at = |column: f64, row: f64| {
        [(column - 0.5 * (columns + 1) as f64) * square_m, (row - 0.5 * (rows + 1) as f64) * square_m]
    };
    let mut squares = Vec::new();
    for row in 0..=rows {
        for column in (row % 2..=columns).step_by(2) {
            let (x, y) = (column as f64, row as f64);
            squares.push(rectangle(view, at(x, y), at(x + 1.0, y + 1.0))?);
        }
    }
    let mut corners = Vec::new();
    for row in 1..=rows {
        for column in 1..=columns {
            let [x, y] = at(column as f64, row as f64);
            corners.push(view.flat(x, y)?);
        }
    }
    Ok((squares, corners))
}

fn ruler(view: &View, pitch_m: f64, marks: usize) -> Result<(Vec<Vec<Place>>, Vec<Place>), NoPhotograph> {
    let (mut outlines, mut places) = (Vec::new(), Vec::new());
    for mark in 0..marks {
        let x = (mark as f64 - 0.5 * (marks - 1) as f64) * pitch_m;
        let length = MARK_LENGTHS[usize::from(mark % 5 == 0) + usize::from(mark % 10 == 0)] * pitch_m;
        let half = 0.5 * MARK_WIDTH * pitch_m;
        let top = -0.5 * MARK_LENGTHS[2] * pitch_m;
        outlines.push(rectangle(view, [x - half, top], [x + half, top + length])?);
        places.push(view.flat(x, top + 0.5 * length)?);
    }
    Ok((outlines, places))
}

/// Photographs a scale.
///
/// # Errors
/// [`NoPhotograph`] for numbers that nothing has.
pub fn scale_only(
    object: &Object,
    camera: &Camera,
    settings: &Settings,
    seed: u64,
) -> Result<Photograph<ScaleTruth>, NoPhotograph> {
    let view = camera.checked()?.view();
    let (length_m, parts) = match object {
        Object::Chessboard { columns, rows, square_m } => (*square_m, columns.saturating_mul(*rows)),
        Object::Disc { diameter_m } => (*diameter_m, 1),
        Object::Ruler { pitch_m, marks } => (*pitch_m, *marks),
    };
    if !length_m.is_finite() || length_m <= 0.0 || !(1..=PARTS_MAX).contains(&parts) {
        return Err(NoPhotograph::Number("a scale: expected a length above 0, and squares or marks up to 10 000"));
    }
    let (outlines, places_px) = match object {
        Object::Chessboard { columns, rows, square_m } => board(&view, *columns, *rows, *square_m)?,
        Object::Disc { diameter_m } => {
            (vec![ellipse(&view, [0.0; 2], [0.5 * diameter_m; 2])?], vec![view.flat(0.0, 0.0)?])
        }
        Object::Ruler { pitch_m, marks } => ruler(&view, *pitch_m, *marks)?,
    };
    let layer = Layer { outlines, holes: vec![], light: settings.object, uneven: None };
    let truth = ScaleTruth { metre_per_px: camera.metre_per_px(), places_px };
    shoot(camera, settings, &scene(camera, settings, vec![layer], None), seed, truth)
}

#[cfg(test)]
mod tests {
    use super::*;
    use pneuval_ingest::camera::chessboard;

    #[test]
    fn a_disc_is_as_large_as_it_is_and_a_board_has_its_corners_behind_a_lens_too() {
        let camera = Camera::facing(400, 300, 1e-4, 0.3);
        let settings = Settings { noise: 0.0, background: [1.0; 3], object: [0.0; 3], ..Settings::default() };
        let disc = scale_only(&Object::Disc { diameter_m: 0.02 }, &camera, &settings, 1).unwrap();
        let dark: f64 = (0..120_000).map(|i| 1.0 - f64::from(disc.picture.luma(i % 400, i / 400)) / 255.0).sum();
        let truth = std::f64::consts::PI * 1e-4 / 1e-8;
        assert!((dark / truth - 1.0).abs() < 1e-4 && (disc.truth.metre_per_px - 1e-4).abs() < 1e-18, "{dark} {truth}");
        // The reader's own corners, behind a lens, tilted.
        let mut camera = Camera { tilt_rad: [0.2, -0.1], roll_rad: 0.05, ..Camera::facing(640, 480, 1e-4, 0.3) };
        camera.lens.radial = [-0.2, 0.1, 0.0];
        let object = Object::Chessboard { columns: 7, rows: 5, square_m: 0.006 };
        let board = scale_only(&object, &camera, &Settings { noise: 1.0, ..Settings::default() }, 1).unwrap();
        let found = chessboard::find(&board.picture, 7, 5).unwrap();
        let off = |at: &Place| found.corners.iter().map(|corner| (corner.at - at).norm()).fold(f64::INFINITY, f64::min);
        let worst = board.truth.places_px.iter().map(off).fold(0.0, f64::max);
        assert!(board.truth.places_px.len() == 35 && worst < 0.1, "{worst}");
    }

    #[test]
    fn marks_of_a_ruler_are_a_pitch_apart_and_what_is_no_scale_is_refused() {
        let camera = Camera::facing(640, 240, 1e-4, 0.3);
        let shot = |object| scale_only(&object, &camera, &Settings::default(), 1);
        let ruler = shot(Object::Ruler { pitch_m: 1e-3, marks: 51 }).unwrap();
        let places = &ruler.truth.places_px;
        assert!(places.len() == 51 && places.windows(2).all(|pair| ((pair[1] - pair[0]).x - 10.0).abs() < 1e-9));
        assert!(ruler.picture.luma(320, 100) < 120.0, "a mark of the middle");
        for object in [
            Object::Disc { diameter_m: 0.0 },
            Object::Disc { diameter_m: f64::NAN },
            Object::Ruler { pitch_m: 1e-3, marks: 0 },
            Object::Chessboard { columns: usize::MAX, rows: 2, square_m: 1e-3 },
        ] {
            assert!(shot(object).is_err(), "{object:?}");
        }
    }
}
