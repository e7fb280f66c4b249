//! From outlines to pixels.
//!
//! ```text
//! outlines --> light of cells, CELLS of them along a pixel (exact areas) --> pixel and blur: one kernel, across and then down
//!          --> light over the picture, tone, noise, steps
//! ```
//!
//! The mean of the cells of a pixel is the pixel's own area exactly; the blur of the lens is a normal distribution. Both are applied to the
//! whole picture, not to single edges, so that corners, thin parts and curved edges come out as they would. Far from edges there is
//! nothing to blur.

use std::collections::VecDeque;

use pneuval_ingest::camera::picture::{Picture, Pixels, Place};

use super::super::random::Normal;
use super::camera::Camera;
use super::cover::Contour;
use super::settings::{Depth, Rgb, Settings};
use super::{NoPhotograph, Photograph};

/// Cells along a pixel. Brightness at an edge is off by no more than what a shift of the edge by 0.005 px makes, where the blur is 0.5 px
/// and more; that is of the width of the blur, the edge itself stays where it is.
const CELLS: usize = 4;

/// What is farther away than so many standard deviations of the blur leaves no trace, in 16 bits either.
const REACH_BLURS: f64 = 4.5;

/// More pixels are no photograph.
pub(super) const PIXELS_MAX: usize = 67_000_000;

/// Weights of red, green and blue in the brightness (ITU-R BT.601), as pictures are read.
const LUMA: Rgb = [0.299, 0.587, 0.114];

/// Steps of 8 bits, and how many of 16 bits one of them is.
const STEPS: f64 = 255.0;
const STEPS_OF_16: f64 = 257.0;

/// What is seen, one layer over the other.
#[derive(Debug, Clone, PartialEq)]
pub struct Scene {
    /// What lies behind all.
    pub background: Rgb,
    /// From behind to the front.
    pub layers: Vec<Layer>,
}

/// Something of one colour: all that its outlines cover together, but for holes.
#[derive(Debug, Clone, PartialEq)]
pub struct Layer {
    /// Closed outlines, in px.
    pub outlines: Vec<Vec<Place>>,
    /// What is cut out of them.
    pub holes: Vec<Vec<Place>>,
    /// Its light.
    pub light: Rgb,
    /// How much of what lies behind it shows through.
    pub uneven: Option<Uneven>,
}

/// Thin here and there.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Uneven {
    /// What shows through everywhere, and by how much more at most, as shares.
    pub through: [f32; 2],
    /// From thin place to thin place, in px.
    pub period_px: f64,
    /// Where these lie, in rad.
    pub phases: [f64; 2],
}

impl Layer {
    /// Opaque, without holes.
    pub fn of(outline: Vec<Place>, light: Rgb) -> Self {
        Self { outlines: vec![outline], holes: vec![], light, uneven: None }
    }
}

/// Photographs a scene.
pub(super) fn shoot<T>(
    camera: &Camera,
    settings: &Settings,
    scene: &Scene,
    seed: u64,
    truth: T,
) -> Result<Photograph<T>, NoPhotograph> {
    let settings = settings.checked()?;
    let (width, height) = (camera.width, camera.height);
    let wrong_size = NoPhotograph::Size { width, height };
    let pixels = width.checked_mul(height).filter(|pixels| (1..=PIXELS_MAX).contains(pixels)).ok_or(wrong_size)?;
    let mut sensor = Sensor::new(settings, width, height, pixels, seed);
    if settings.is_colour {
        Canvas::<3>::new(width, height, settings, scene).rows(|y, row| sensor.row(y, row));
    } else {
        Canvas::<1>::new(width, height, settings, scene).rows(|y, row| sensor.row(y, row));
    }
    Ok(Photograph { picture: Picture::new(width, height, sensor.pixels).ok_or(wrong_size)?, truth })
}

/// A layer on the grid of cells.
struct Painted {
    outlines: Vec<Contour>,
    holes: Vec<Contour>,
    light: Rgb,
    uneven: Option<(Uneven, Vec<f32>)>,
}

/// The grid of cells, with a margin of what blur brings in from beyond the border. `C` colours: three, or brightness alone.
struct Canvas<const C: usize> {
    width: usize,
    height: usize,
    margin: usize,
    columns: usize,
    rows: usize,
    kernel: Vec<f32>,
    background: [f32; C],
    layers: Vec<Painted>,
}

/// Light as the colours that a canvas has.
fn colours<const C: usize>(light: Rgb) -> [f32; C] {
    let luma: f32 = light.iter().zip(LUMA).map(|(share, weight)| share * weight).sum();
    std::array::from_fn(|c| if C == 3 { light[c] } else { luma })
}

/// Pixel and blur together, at cells from a pixel's first one less the margin on.
fn kernel(blur_px: f64, margin: usize) -> Vec<f32> {
    let taps = (2 * margin + 1) * CELLS;
    // From the middle of one cell to that of another, in px.
    let normal = |cells: f64| {
        let z = cells / (CELLS as f64 * blur_px);
        (-0.5 * z * z).exp()
    };
    let mut weights = vec![0.0; taps];
    for of_pixel in 0..CELLS {
        let at = margin * CELLS + of_pixel;
        for (i, weight) in weights.iter_mut().enumerate() {
            *weight += if i == at { 1.0 } else { normal(i as f64 - at as f64) };
        }
    }
    let sum: f64 = weights.iter().sum();
    #[expect(clippy::cast_possible_truncation, reason = "light is a share of 1: seven digits are enough")]
    let share = |weight: f64| (weight / sum) as f32;
    weights.into_iter().map(share).collect()
}

impl<const C: usize> Canvas<C> {
    fn new(width: usize, height: usize, settings: &Settings, scene: &Scene) -> Self {
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a blur is between 0 and 50 px")]
        let margin = (REACH_BLURS * settings.blur_px).ceil() as usize;
        let (columns, rows) = ((width + 2 * margin) * CELLS, (height + 2 * margin) * CELLS);
        // The centre of the first pixel is (0, 0).
        let to_cells = |at: &Place| at.add_scalar(margin as f64 + 0.5) * CELLS as f64;
        let contour = |points: &Vec<Place>| Contour::new(&points.iter().map(to_cells).collect::<Vec<_>>(), rows);
        let painted = |layer: &Layer| Painted {
            outlines: layer.outlines.iter().map(contour).collect(),
            holes: layer.holes.iter().map(contour).collect(),
            light: layer.light,
            uneven: layer
                .uneven
                .map(|uneven| (uneven, wave(columns, uneven.period_px * CELLS as f64, uneven.phases[0]))),
        };
        Self {
            width,
            height,
            margin,
            columns,
            rows,
            kernel: kernel(settings.blur_px, margin),
            background: colours(scene.background),
            layers: scene.layers.iter().map(painted).collect(),
        }
    }

    /// All rows of pixels, one after the other.
    fn rows(&self, mut take: impl FnMut(usize, &[[f32; C]])) {
        let mut brush = Brush::new(self);
        let mut across: VecDeque<Vec<[f32; C]>> = VecDeque::new();
        let mut row = vec![[0.0; C]; self.width];
        let mut painted = 0;
        for y in 0..self.height {
            while painted < (y + 2 * self.margin + 1) * CELLS {
                // A row that no pixel needs any more is used again.
                let mut into = if across.len() >= self.kernel.len() { across.pop_front() } else { None }
                    .unwrap_or_else(|| vec![[0.0; C]; self.width]);
                brush.paint(painted, &mut into);
                across.push_back(into);
                painted += 1;
            }
            row.fill([0.0; C]);
            for (weight, cells) in self.kernel.iter().zip(&across) {
                for (sum, light) in row.iter_mut().zip(cells) {
                    for c in 0..C {
                        sum[c] += weight * light[c];
                    }
                }
            }
            take(y, &row);
        }
    }
}

/// (1 + cos)/2 at each of so many cells.
fn wave(cells: usize, period: f64, phase: f64) -> Vec<f32> {
    #[expect(clippy::cast_possible_truncation, reason = "shares")]
    let at = |i: usize| (0.5 + 0.5 * (i as f64 * std::f64::consts::TAU / period + phase).cos()) as f32;
    (0..cells).map(at).collect()
}

/// Paints a row of cells, and blurs it across.
struct Brush<'c, const C: usize> {
    canvas: &'c Canvas<C>,
    cells: Vec<[f32; C]>,
    covered: Vec<f32>,
    cut: Vec<f32>,
    sums: Vec<f64>,
    edges: Vec<usize>,
    near: Vec<bool>,
}

impl<'c, const C: usize> Brush<'c, C> {
    fn new(canvas: &'c Canvas<C>) -> Self {
        let columns = canvas.columns;
        Self {
            canvas,
            cells: vec![[0.0; C]; columns],
            covered: vec![0.0; columns],
            cut: vec![0.0; columns],
            sums: vec![0.0; columns + 1],
            edges: vec![],
            near: vec![false; canvas.width],
        }
    }

    fn paint(&mut self, row: usize, into: &mut [[f32; C]]) {
        let canvas = self.canvas;
        self.cells.fill(canvas.background);
        self.edges.clear();
        for layer in &canvas.layers {
            self.lay(layer, row.min(canvas.rows - 1));
        }
        self.near.fill(false);
        for &edge in &self.edges {
            // The pixel of the cell, and those that its blur reaches.
            let pixel = edge / CELLS;
            let (from, to) = (pixel.saturating_sub(2 * canvas.margin), (pixel + 1).min(canvas.width));
            self.near[from.min(to)..to].fill(true);
        }
        let middle = canvas.margin * CELLS + CELLS / 2;
        for (x, light) in into.iter_mut().enumerate() {
            *light = if self.near[x] {
                let mut sum = [0.0; C];
                for (weight, cell) in canvas.kernel.iter().zip(&self.cells[x * CELLS..]) {
                    for c in 0..C {
                        sum[c] += weight * cell[c];
                    }
                }
                sum
            } else {
                self.cells[x * CELLS + middle]
            };
        }
    }

    fn lay(&mut self, layer: &Painted, row: usize) {
        self.covered.fill(0.0);
        for outline in &layer.outlines {
            outline.add(row, &mut self.sums, &mut self.covered, &mut self.edges);
        }
        if !layer.holes.is_empty() {
            self.cut.fill(0.0);
            for hole in &layer.holes {
                hole.add(row, &mut self.sums, &mut self.cut, &mut self.edges);
            }
            self.covered.iter_mut().zip(&self.cut).for_each(|(covered, cut)| *covered *= 1.0 - cut);
        }
        if let Some((uneven, wave_across)) = &layer.uneven {
            let down =
                wave(1, 1.0, row as f64 * std::f64::consts::TAU / (uneven.period_px * CELLS as f64) + uneven.phases[1])
                    [0];
            let [least, more] = uneven.through;
            for (covered, across) in self.covered.iter_mut().zip(wave_across) {
                *covered *= 1.0 - least - more * across * down;
            }
        }
        let light = colours::<C>(layer.light);
        for (cell, covered) in self.cells.iter_mut().zip(&self.covered) {
            if *covered > 0.0 {
                for c in 0..C {
                    cell[c] += covered * (light[c] - cell[c]);
                }
            }
        }
    }
}

/// What makes numbers of light.
struct Sensor<'s> {
    settings: &'s Settings,
    width: usize,
    height: usize,
    noise: Normal,
    pixels: Pixels,
}

impl<'s> Sensor<'s> {
    fn new(settings: &'s Settings, width: usize, height: usize, pixels: usize, seed: u64) -> Self {
        let pixels = match (settings.is_colour, settings.depth) {
            (false, Depth::Eight) => Pixels::Gray8(Vec::with_capacity(pixels)),
            (false, Depth::Sixteen) => Pixels::Gray16(Vec::with_capacity(pixels)),
            (true, Depth::Eight) => Pixels::Rgb8(Vec::with_capacity(3 * pixels)),
            (true, Depth::Sixteen) => Pixels::Rgb16(Vec::with_capacity(3 * pixels)),
        };
        Self { settings, width, height, noise: Normal::new(seed, "noise of a photograph"), pixels }
    }

    fn row<const C: usize>(&mut self, y: usize, row: &[[f32; C]]) {
        let Settings { light: field, tone, noise, .. } = self.settings;
        let part = |i: usize, n: usize| 2.0 * i as f64 / (n - 1).max(1) as f64 - 1.0;
        let v = part(y, self.height);
        for (x, colours) in row.iter().enumerate() {
            let u = part(x, self.width);
            let strength = 1.0 + field.slope[0] * u + field.slope[1] * v - field.fall_off * (u * u + v * v);
            for light in colours {
                let lit = (f64::from(*light) * strength).clamp(0.0, 1.0);
                let stray = if *noise > 0.0 { noise * self.noise.next() } else { 0.0 };
                let steps = (STEPS * tone.of(lit) + stray).clamp(0.0, STEPS);
                #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "cut to the range before")]
                match &mut self.pixels {
                    Pixels::Gray8(all) | Pixels::Rgb8(all) => all.push(steps.round() as u8),
                    Pixels::Gray16(all) | Pixels::Rgb16(all) => all.push((STEPS_OF_16 * steps).round() as u16),
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plain() -> Settings {
        Settings { noise: 0.0, depth: Depth::Sixteen, ..Settings::default() }
    }

    fn shot(settings: &Settings, layers: Vec<Layer>, width: usize, height: usize) -> Picture {
        let camera = Camera::facing(width, height, 1e-4, 0.3);
        let scene = Scene { background: settings.background, layers };
        shoot(&camera, settings, &scene, 1, ()).unwrap().picture
    }

    /// Share of a pixel at so many px from an edge that is blurred by a normal distribution, both upright.
    fn share(at: f64, blur: f64) -> f64 {
        let steps = 2000;
        let sum: f64 = (0..steps)
            .map(|i| at - 0.5 + (f64::from(i) + 0.5) / f64::from(steps))
            .map(|t| 0.5 * (1.0 + erf(t / (blur * 2.0_f64.sqrt()))))
            .sum();
        sum / f64::from(steps)
    }

    /// By its series, good to 1e-12 up to 4.
    fn erf(x: f64) -> f64 {
        if x.abs() > 4.0 {
            return x.signum();
        }
        let (mut term, mut sum) = (x, x);
        for n in 1..200 {
            term *= -x * x / f64::from(n);
            sum += term / f64::from(2 * n + 1);
        }
        sum * 2.0 / std::f64::consts::PI.sqrt()
    }

    #[test]
    fn an_upright_edge_is_the_integral_of_a_blurred_step_wherever_it_lies_between_cells() {
        for blur_px in [0.5, 1.2, 2.5] {
            let settings = Settings { blur_px, background: [0.8; 3], ..plain() };
            for part in 0..13 {
                let edge = 20.0 + f64::from(part) / 13.0;
                let points = [(edge, -9.0), (99.0, -9.0), (99.0, 99.0), (edge, 99.0)].map(|(x, y)| Place::new(x, y));
                let picture = shot(&settings, vec![Layer::of(points.to_vec(), [0.2; 3])], 40, 9);
                let slope = 0.6 * 255.0 * 0.4 / blur_px;
                for x in 0..40 {
                    let expected = 255.0 * (0.8 - 0.6 * share(x as f64 - edge, blur_px));
                    let off_px = (f64::from(picture.luma(x, 4)) - expected).abs() / slope;
                    assert!(off_px < 0.005, "blur {blur_px}, edge {edge}, x {x}: {off_px} px");
                }
            }
        }
    }

    /// What a pixel sees of a convex outline: pixel and blur over a fine grid of points.
    fn by_points(outline: &[Place], pixel: Place, blur: f64) -> f64 {
        let n = outline.len();
        let inside = |at: Place| (0..n).all(|i| (outline[(i + 1) % n] - outline[i]).perp(&(at - outline[i])) > 0.0);
        let weight = |t: f64| {
            let below = |t: f64| 0.5 * (1.0 + erf(t / (blur * 2.0_f64.sqrt())));
            below(t + 0.5) - below(t - 0.5)
        };
        let steps = 500;
        let reach = 4.5 * blur + 0.5;
        let step = 2.0 * reach / f64::from(steps);
        let offs: Vec<(f64, f64)> =
            (0..steps).map(|i| (f64::from(i) + 0.5) * step - reach).map(|t| (t, step * weight(t))).collect();
        let column = |(x, u): &(f64, f64)| {
            let seen = offs.iter().filter(|(y, _)| inside(pixel + Place::new(*x, *y)));
            u * seen.map(|(_, v)| v).sum::<f64>()
        };
        offs.iter().map(column).sum()
    }

    #[test]
    fn corners_and_small_discs_are_the_integral_over_pixel_and_blur() {
        let square = [(10.3, 8.1), (21.7, 12.4), (17.2, 22.9), (6.6, 18.8)].map(|(x, y)| Place::new(x, y)).to_vec();
        let disc: Vec<Place> = (0..60)
            .map(|i| f64::from(i) * std::f64::consts::TAU / 60.0)
            .map(|t| Place::new(14.2 + 3.0 * t.cos(), 15.7 + 3.0 * t.sin()))
            .collect();
        for (outline, pixels) in
            [(square, [(10, 8), (11, 9), (21, 12), (17, 23)]), (disc, [(11, 16), (14, 13), (16, 18), (14, 15)])]
        {
            for blur_px in [0.6, 1.5] {
                let settings = Settings { blur_px, background: [0.0; 3], ..plain() };
                let picture = shot(&settings, vec![Layer::of(outline.clone(), [1.0; 3])], 32, 32);
                for (x, y) in pixels {
                    let share = f64::from(picture.luma(x, y)) / 255.0;
                    let truth = by_points(&outline, Place::new(x as f64, y as f64), blur_px);
                    assert!((share - truth).abs() < 0.002, "blur {blur_px}, ({x}, {y}): {share} {truth}");
                }
            }
        }
    }

    #[test]
    fn light_is_kept_whatever_the_blur() {
        let square = [(10.3, 8.1), (21.7, 12.4), (17.2, 22.9), (6.6, 18.8)].map(|(x, y)| Place::new(x, y)).to_vec();
        let hole =
            square.iter().map(|at| Place::new(14.0, 15.5) + 0.5 * (at - Place::new(14.0, 15.5))).collect::<Vec<_>>();
        let area = |points: &[Place]| {
            let n = points.len();
            0.5 * (0..n).map(|i| points[i].perp(&points[(i + 1) % n])).sum::<f64>().abs()
        };
        let light = |layer: &Layer, blur_px: f64| {
            let picture = shot(&Settings { blur_px, background: [0.0; 3], ..plain() }, vec![layer.clone()], 32, 32);
            (0..1024).map(|i| f64::from(picture.luma(i % 32, i / 32)) / 255.0).sum::<f64>()
        };
        let whole = Layer::of(square.clone(), [1.0; 3]);
        let cut = Layer { holes: vec![hole.clone()], ..whole.clone() };
        for blur_px in [0.0, 0.3, 1.0, 2.0] {
            assert!((light(&whole, blur_px) - area(&square)).abs() < 0.01, "{blur_px}");
            assert!((light(&cut, blur_px) - area(&square) + area(&hole)).abs() < 0.01, "{blur_px}");
        }
    }

    #[test]
    fn light_noise_tone_and_colours_are_those_of_the_settings() {
        let flat = |settings: &Settings| shot(settings, vec![], 101, 51);
        let uneven = Settings { light: super::super::Light { slope: [0.1, -0.2], fall_off: 0.05 }, ..plain() };
        let at = |x: usize, y: usize| f64::from(flat(&uneven).luma(x, y)) / (0.76 * 255.0);
        assert!(
            (at(50, 25) - 1.0).abs() < 1e-4 && (at(100, 25) - 1.05).abs() < 1e-4 && (at(50, 0) - 1.15).abs() < 1e-4
        );
        let noisy = flat(&Settings { noise: 3.0, depth: Depth::Eight, ..plain() });
        let values: Vec<f64> = (0..5151).map(|i| f64::from(noisy.luma(i % 101, i / 101))).collect();
        let mean = values.iter().sum::<f64>() / 5151.0;
        let variance = values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / 5150.0;
        // Rounding to steps adds a twelfth.
        assert!((mean - 0.76 * 255.0).abs() < 0.2 && (variance - 9.0 - 1.0 / 12.0).abs() < 0.5, "{mean} {variance}");
        assert!(
            flat(&Settings { tone: super::super::Tone::Srgb, background: [0.214_041; 3], ..plain() }).luma(3, 3)
                > 127.4
        );
        let red = flat(&Settings { is_colour: true, background: [0.8, 0.1, 0.0], ..plain() });
        assert!(red.is_colour() && (red.rgb(7, 7)[0] - 204.0).abs() < 0.01 && red.rgb(7, 7)[2] < 0.01);
        let grey = flat(&Settings { background: [1.0, 0.0, 0.0], ..plain() });
        assert!((grey.luma(7, 7) - 0.299 * 255.0).abs() < 0.01);
    }

    #[test]
    fn a_picture_without_pixels_or_with_too_many_is_refused() {
        let scene = Scene { background: [0.5; 3], layers: vec![] };
        for (width, height) in [(0, 5), (5, 0), (1 << 20, 1 << 20), (usize::MAX, 2)] {
            let camera = Camera::facing(width, height, 1e-4, 0.3);
            assert_eq!(shoot(&camera, &plain(), &scene, 1, ()), Err(NoPhotograph::Size { width, height }));
        }
    }
}
