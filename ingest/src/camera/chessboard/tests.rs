use super::super::lens::Lens;
use super::super::picture::Pixels;
use super::*;
use nalgebra::{Rotation3, Vector2, Vector3};
use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg64Mcg;
use statrs::function::erf::erf;

/// A board of 9 x 6 inner corners before a camera, its light, blur and noise.
struct Scene {
    size: (usize, usize),
    lens: Lens,
    rotation: Rotation3<f64>,
    at: Vector3<f64>,
    blur: f64,
    /// Brightness of white at the left and at the right border; black is a tenth of it.
    light: (f64, f64),
    noise: f64,
}

const SQUARE: f64 = 0.02;
const COLUMNS: usize = 9;
const ROWS: usize = 6;

impl Scene {
    fn new(turn: [f64; 3], at: [f64; 3]) -> Self {
        let lens = Lens { radial: [-0.2, 0.05, 0.0], ..Lens::pinhole(390.0, Place::new(236.0, 178.0)) };
        let rotation = Rotation3::from_euler_angles(turn[0], turn[1], turn[2]);
        Self { size: (480, 360), lens, rotation, at: Vector3::from(at), blur: 0.8, light: (200.0, 200.0), noise: 1.0 }
    }

    fn point(column: f64, row: f64) -> Vector2<f64> {
        Vector2::new(column - (COLUMNS - 1) as f64 / 2.0, row - (ROWS - 1) as f64 / 2.0) * SQUARE
    }

    fn seen(&self, point: Vector2<f64>) -> Place {
        self.lens.project(self.rotation * point.push(0.0) + self.at).unwrap()
    }

    /// The board at a place of the picture, in squares from the first corner.
    fn on_board(&self, at: Place) -> Vector2<f64> {
        let ray = self.rotation.inverse() * self.lens.ray(at).unwrap().push(1.0);
        let from = self.rotation.inverse() * -self.at;
        let p = from + ray * (-from.z / ray.z);
        p.xy() / SQUARE + Vector2::new((COLUMNS - 1) as f64 / 2.0, (ROWS - 1) as f64 / 2.0)
    }

    /// Brightness of the board: white and black squares of soft edges, a white margin of one square, clutter beyond.
    fn albedo(&self, at: Place, p: Vector2<f64>, per_px: Vector2<f64>) -> f64 {
        let soft = |d: f64, per_px: f64| erf(d / (per_px * self.blur * std::f64::consts::SQRT_2));
        let outside = (-1.0 - p.x).max(p.x - COLUMNS as f64).max(-1.0 - p.y).max(p.y - ROWS as f64);
        if outside > 1.0 {
            // Stripes and blots.
            let blots = (at.x * 0.11 + at.y * 0.03).sin() + (at.y * 0.17 - at.x * 0.05).sin();
            return 0.4 + 0.15 * blots + 0.15 * f64::from(u8::from((at.x * 0.05).sin() > 0.3));
        }
        // Squares alternate: the product of the signs of the nearest lines, from the rim inwards.
        let wave = |v: f64, per_px: f64, last: f64| {
            let nearest = v.round().clamp(-1.0, last);
            let sign = if (nearest.rem_euclid(2.0)) == 0.0 { 1.0 } else { -1.0 };
            sign * soft(v - nearest, per_px)
        };
        let inner = wave(p.x, per_px.x, COLUMNS as f64) * wave(p.y, per_px.y, ROWS as f64);
        let squares = 0.5 + 0.5 * inner;
        if outside > 0.0 { 1.0 } else { squares }
    }

    fn picture(&self, generator: &mut Pcg64Mcg) -> Picture {
        let mut pixels = vec![];
        let place = |x: usize, y: usize| Place::new(x as f64, y as f64);
        let of_row =
            |y: usize| -> Vec<Vector2<f64>> { (0..=self.size.0).map(|x| self.on_board(place(x, y))).collect() };
        let mut row = of_row(0);
        for y in 0..self.size.1 {
            let below = of_row(y + 1);
            for x in 0..self.size.0 {
                // How many squares a pixel is, across the lines of either kind.
                let per_px = (row[x + 1] - row[x]).zip_map(&(below[x] - row[x]), f64::hypot);
                let light = self.light.0 + (self.light.1 - self.light.0) * x as f64 / self.size.0 as f64;
                let luma = light * (0.1 + 0.9 * self.albedo(place(x, y), row[x], per_px));
                let z: f64 = StandardNormal.sample(generator);
                // Clamped to what eight bits hold.
                #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
                pixels.push((luma + self.noise * z).round().clamp(0.0, 255.0) as u8);
            }
            row = below;
        }
        Picture::new(self.size.0, self.size.1, Pixels::Gray8(pixels)).unwrap()
    }

    /// Errors over standard uncertainties, and the largest error, in px. The board may be turned by half.
    fn errors(&self, board: &Board) -> (f64, f64) {
        let truth = |i: usize| self.seen(Self::point((i % COLUMNS) as f64, (i / COLUMNS) as f64));
        let count = COLUMNS * ROWS;
        let turned = (board.corners[0].at - truth(0)).norm() > (board.corners[0].at - truth(count - 1)).norm();
        let (mut share, mut worst) = (0.0, 0.0_f64);
        for (i, corner) in board.corners.iter().enumerate() {
            let off = corner.at - truth(if turned { count - 1 - i } else { i });
            let [x, y] = corner.std_px;
            share += ((off.x / x).powi(2) + (off.y / y).powi(2)) / (2 * count) as f64;
            worst = worst.max(off.norm());
        }
        (share, worst)
    }
}

#[test]
fn corners_come_back_to_hundredths_of_a_pixel_however_the_board_lies() {
    let mut generator = Pcg64Mcg::new(41);
    let scenes = [
        ([0.0, 0.0, 0.0], [0.0, 0.0, 0.24]),
        ([0.5, -0.3, 0.2], [0.01, 0.0, 0.26]),
        ([-0.4, 0.6, 1.4], [-0.01, 0.01, 0.28]),
        ([0.2, -0.7, 2.9], [0.0, -0.01, 0.26]),
    ];
    for (i, (turn, at)) in scenes.into_iter().enumerate() {
        // Every other one in a light that falls off to a quarter, and noisy.
        let (light, noise) = if i % 2 == 0 { ((200.0, 200.0), 1.0) } else { ((230.0, 60.0), 3.0) };
        let scene = Scene { light, noise, ..Scene::new(turn, at) };
        let board = find(&scene.picture(&mut generator), COLUMNS, ROWS).unwrap_or_else(|e| panic!("{turn:?}: {e}"));
        let (share, worst) = scene.errors(&board);
        assert!(worst < 0.06 && (0.4..2.0).contains(&share), "{turn:?}: {share} {worst}");
    }
}

#[test]
fn the_order_is_that_of_reading_and_rows_are_rows() {
    let mut generator = Pcg64Mcg::new(42);
    let scene = Scene::new([0.1, 0.1, 0.1], [0.0, 0.0, 0.25]);
    let picture = scene.picture(&mut generator);
    let board = find(&picture, COLUMNS, ROWS).unwrap();
    assert_eq!((board.columns, board.rows, board.corners.len()), (9, 6, 54));
    let at = |i: usize| board.corners[i].at;
    assert!(at(1).x > at(0).x && at(9).y > at(0).y && (at(8).y - at(0).y).abs() < (at(8).x - at(0).x));
    // Asked for the other way round, rows are the columns.
    let turned = find(&picture, ROWS, COLUMNS).unwrap();
    let (along, across) = (turned.corners[1].at - turned.corners[0].at, turned.corners[6].at - turned.corners[0].at);
    assert!(along.y.abs() > along.x.abs() && along.x * across.y - along.y * across.x > 0.0);
    let placed = board.with_squares(0.5);
    assert_eq!((placed[10].0, placed[10].1), (Place::new(0.5, 0.5), at(10)));
}

#[test]
fn a_reduced_picture_finds_what_the_whole_one_fits() {
    let mut generator = Pcg64Mcg::new(43);
    let mut scene = Scene::new([0.3, 0.3, 0.1], [0.0, 0.0, 0.30]);
    scene.lens.focal_px *= 2.6;
    (scene.size, scene.lens.centre_px, scene.blur) = ((1280, 960), Place::new(640.0, 480.0), 2.5);
    let board = find(&scene.picture(&mut generator), COLUMNS, ROWS).unwrap();
    let (share, worst) = scene.errors(&board);
    assert!(worst < 0.06 && share < 2.0, "{share} {worst}");
}

#[test]
fn what_is_no_such_board_is_refused_with_the_reason() {
    let mut generator = Pcg64Mcg::new(44);
    let picture = Scene::new([0.0, 0.2, 0.0], [0.0, 0.0, 0.25]).picture(&mut generator);
    let other = find(&picture, 8, 6).unwrap_err();
    assert_eq!(other, ChessboardError::Count { wanted: (8, 6), found: (9, 6) });
    assert_eq!(find(&picture, 2, 6), Err(ChessboardError::Pattern { columns: 2, rows: 6 }));
    let cut = Scene::new([0.0, 0.2, 0.0], [0.08, 0.0, 0.25]).picture(&mut generator);
    let cut = find(&cut, COLUMNS, ROWS).unwrap_err();
    assert!(matches!(cut, ChessboardError::Border { .. }), "{cut}");
    // A hand over two corners, where its own outline may look like one, and over more.
    let Pixels::Gray8(pixels) = picture.pixels().clone() else { panic!() };
    let covered = |half: usize| {
        let mut pixels = pixels.clone();
        for y in 178 - half..178 + half {
            pixels[y * 480 + 220 - half..y * 480 + 220 + half].fill(150);
        }
        find(&Picture::new(480, 360, Pixels::Gray8(pixels)).unwrap(), COLUMNS, ROWS).unwrap_err()
    };
    let few = covered(24);
    assert!(matches!(few, ChessboardError::Incomplete { .. } | ChessboardError::Unclear { .. }), "{few}");
    let many = covered(40);
    assert!(matches!(many, ChessboardError::Incomplete { .. }), "{many}");
    let grey = Picture::new(640, 480, Pixels::Gray8(vec![120; 640 * 480])).unwrap();
    assert_eq!(find(&grey, COLUMNS, ROWS), Err(ChessboardError::NoBoard));
    // Noise and nothing else.
    let noise = (0..320 * 240).map(|_| {
        let z: f64 = StandardNormal.sample(&mut generator);
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        let luma = (120.0 + 30.0 * z).clamp(0.0, 255.0) as u8;
        luma
    });
    let noise = Picture::new(320, 240, Pixels::Gray8(noise.collect())).unwrap();
    assert_eq!(find(&noise, COLUMNS, ROWS), Err(ChessboardError::NoBoard));
}

#[test]
fn two_boards_are_told() {
    let mut generator = Pcg64Mcg::new(45);
    let scene = Scene::new([0.0, 0.0, 0.0], [0.0, 0.0, 0.36]);
    let Pixels::Gray8(one) = scene.picture(&mut generator).pixels().clone() else { panic!() };
    let mut both = vec![];
    for row in one.chunks_exact(480) {
        both.extend_from_slice(row);
        both.extend_from_slice(row);
    }
    let both = Picture::new(960, 360, Pixels::Gray8(both)).unwrap();
    assert_eq!(find(&both, COLUMNS, ROWS), Err(ChessboardError::Several));
}
