//! Which colours paper and paint have, and how the light falls on the paper.

use image::GrayImage;
use imageproc::contrast::otsu_level;
use nalgebra::{Matrix3, Matrix6, SymmetricEigen, Vector3, Vector6};

use super::super::picture::Picture;
use super::AreaRefusal;

/// The shorter side of the grid has about so many points.
const GRID: usize = 160;

/// Light is looked at so often, each time without what does not belong to the paper.
const ROUNDS: usize = 3;

/// Paint is farther from the paper than so many standard deviations of the paper.
const CONTRAST_STDS: f64 = 5.0;

/// A colour in which so much of the paper is as bright as can be says nothing of it.
const SATURATED: f64 = 254.0;
const SATURATED_SHARE: f64 = 0.3;

/// What lies farther beside the line from paper to paint than this share of its length is of another colour.
pub(super) const BESIDE: f64 = 0.45;

/// More of what is no paper than this share is of another colour: the paint has to be named.
const OTHERS: f64 = 0.2;

/// The light of the paper in each colour, and the direction in which the paint lies.
pub(super) struct Colours {
    /// Coefficients of 1, x, y, x², xy, y² with x and y from -1 to 1 over the region, by colour.
    light: [Vector6<f64>; 3],
    size: (f64, f64),
    /// Paint over paper, less one.
    pub paint: Vector3<f64>,
    /// Standard deviation of the paper about its light, along the paint, as a share.
    pub std: f64,
}

fn terms(x: f64, y: f64) -> Vector6<f64> {
    Vector6::new(1.0, x, y, x * x, x * y, y * y)
}

impl Colours {
    pub fn of(
        picture: &Picture,
        [left, top, across, down]: [usize; 4],
        named: Option<[f64; 3]>,
    ) -> Result<Self, AreaRefusal> {
        let step = (across.min(down) / GRID).max(1);
        let (width, height) = (across / step, down / step);
        let at = |i: usize| (i % width * step + step / 2, i / width * step + step / 2);
        let pixel = |i: usize| {
            let (x, y) = at(i);
            Vector3::from(picture.rgb(left + x, top + y).map(f64::from))
        };
        let all: Vec<Vector3<f64>> = (0..width * height).map(pixel).collect();
        let size = (across as f64, down as f64);
        let place = |i: usize| {
            let (x, y) = at(i);
            (2.0 * x as f64 / size.0 - 1.0, 2.0 * y as f64 / size.1 - 1.0)
        };
        let is_border = |i: usize| {
            let (x, y) = (i % width, i / width);
            x == 0 || y == 0 || x + 1 == width || y + 1 == height
        };
        let mut found = Self { light: [Vector6::zeros(); 3], size, paint: Vector3::zeros(), std: 0.0 };
        // As the light falls, and then over the paper's.
        let mut over: Vec<Vector3<f64>> = all.clone();
        let mut is_paper = vec![true; all.len()];
        for round in 0..ROUNDS {
            let values = along(&over)?;
            let halves = split(&values, width, height);
            let border = (0..all.len()).filter(|&i| is_border(i));
            let (high, count) = border.fold((0, 0), |(high, n), i| (high + usize::from(halves[i]), n + 1));
            let paper_is_high = match named.filter(|_| round > 0) {
                // Paper is what is not on the named colour's side.
                Some(paint) => {
                    let mean = |high: bool| mean_of((0..all.len()).filter(|&i| halves[i] == high).map(|i| &all[i]));
                    let far = |high: bool| mean(high).map_or(0.0, |mean| (mean - Vector3::from(paint)).norm());
                    far(true) > far(false)
                }
                None => 2 * high >= count,
            };
            is_paper = halves.iter().map(|is_high| *is_high == paper_is_high).collect();
            for (colour, light) in found.light.iter_mut().enumerate() {
                *light = surface(&all, colour, &is_paper, &place).ok_or(AreaRefusal::NoContrast { stds: 0.0 })?;
            }
            over = (0..all.len()).map(|i| all[i].component_div(&found.at(place(i)))).collect();
        }
        let ones = Vector3::repeat(1.0);
        // A colour that is as bright as can be tells nothing: it is left out.
        let papers = is_paper.iter().filter(|p| **p).count().max(1) as f64;
        let useful = Vector3::from_fn(|k, _| {
            let full = (0..all.len()).filter(|&i| is_paper[i] && all[i][k] >= SATURATED).count() as f64;
            f64::from(u8::from(full < SATURATED_SHARE * papers))
        });
        if useful.sum() < 0.5 {
            return Err(AreaRefusal::Saturated);
        }
        // The paint is told by places whose neighbours are painted too: no mixtures.
        let is_inner = |i: usize| {
            let (x, y) = (i % width, i / width);
            let inside = x > 0 && y > 0 && x + 1 < width && y + 1 < height;
            inside && [i, i - 1, i + 1, i - width, i + width].iter().all(|&k| !is_paper[k])
        };
        let mut painted: Vec<Vector3<f64>> =
            (0..all.len()).filter(|&i| is_inner(i)).map(|i| (over[i] - ones).component_mul(&useful)).collect();
        if painted.is_empty() {
            painted =
                (0..all.len()).filter(|&i| !is_paper[i]).map(|i| (over[i] - ones).component_mul(&useful)).collect();
        }
        if painted.is_empty() {
            return Err(AreaRefusal::NoPaint);
        }
        let middle = |of: &[Vector3<f64>]| {
            Vector3::from_fn(|k, _| super::super::curve::median(of.iter().map(|v| v[k]).collect()))
        };
        found.paint = if let Some(paint) = named {
            let paper = found.at((0.0, 0.0));
            let wanted = (Vector3::from(paint).component_div(&paper) - ones).component_mul(&useful);
            painted.retain(|v| beside(v, &wanted) < BESIDE * wanted.norm());
            if painted.is_empty() {
                return Err(AreaRefusal::NoPaint);
            }
            middle(&painted)
        } else {
            let paint = middle(&painted);
            let others = painted.iter().filter(|v| beside(v, &paint) > BESIDE * paint.norm()).count();
            let share = others as f64 / painted.len() as f64;
            if share > OTHERS {
                return Err(AreaRefusal::Colours { share });
            }
            paint
        };
        let square = found.paint.norm_squared();
        let papers = (0..all.len()).filter(|&i| is_paper[i]);
        let mut shares: Vec<f64> = papers.map(|i| ((over[i] - ones).dot(&found.paint) / square).abs()).collect();
        shares.retain(|s| s.is_finite());
        // From the median of absolute values to a standard deviation; mixtures at the rim do not count.
        found.std = 1.482_6 * super::super::curve::median(shares);
        let stds = 1.0 / found.std.max(1e-9);
        if !(square > 0.0 && stds > CONTRAST_STDS) {
            return Err(AreaRefusal::NoContrast { stds: if square > 0.0 { stds } else { 0.0 } });
        }
        Ok(found)
    }

    /// The light of the paper at a place from -1 to 1.
    fn at(&self, (x, y): (f64, f64)) -> Vector3<f64> {
        let t = terms(x, y);
        Vector3::from_fn(|k, _| self.light[k].dot(&t).max(1.0))
    }

    /// The light of the paper along a row of the region, px by px.
    pub fn row(&self, row: usize) -> impl Iterator<Item = [f64; 3]> + '_ {
        let y = 2.0 * row as f64 / self.size.1 - 1.0;
        let of = |c: &Vector6<f64>| (c[0] + y * (c[2] + y * c[5]), c[1] + y * c[4], c[3]);
        let parts = [of(&self.light[0]), of(&self.light[1]), of(&self.light[2])];
        let per = 2.0 / self.size.0;
        (0..).map(move |i: u32| {
            let x = f64::from(i) * per - 1.0;
            parts.map(|(constant, slope, bend)| (constant + x * (slope + x * bend)).max(1.0))
        })
    }

    /// Paper and paint in the middle of the region.
    pub fn told(&self) -> [[f64; 3]; 2] {
        let paper = self.at((0.0, 0.0));
        let paint = paper.component_mul(&(self.paint + Vector3::repeat(1.0)));
        [paper.into(), paint.into()]
    }
}

/// How far a colour lies beside the line to another.
pub(super) fn beside(of: &Vector3<f64>, line: &Vector3<f64>) -> f64 {
    let square = line.norm_squared();
    if square > 0.0 { (of - line * (of.dot(line) / square)).norm() } else { f64::INFINITY }
}

fn mean_of<'a>(of: impl Iterator<Item = &'a Vector3<f64>>) -> Option<Vector3<f64>> {
    let (sum, n) = of.fold((Vector3::zeros(), 0.0), |(sum, n), v| (sum + v, n + 1.0));
    (n > 0.0).then(|| sum / n)
}

/// Colours along the direction in which they differ most.
fn along(all: &[Vector3<f64>]) -> Result<Vec<f64>, AreaRefusal> {
    let mean = mean_of(all.iter()).ok_or(AreaRefusal::NoPaint)?;
    let spread = all.iter().fold(Matrix3::zeros(), |sum, v| sum + (v - mean) * (v - mean).transpose());
    let eigen = SymmetricEigen::new(spread);
    let way: Vector3<f64> = eigen.eigenvectors.column(eigen.eigenvalues.imax()).into();
    Ok(all.iter().map(|v| (v - mean).dot(&way)).collect())
}

/// Whether each value is above Otsu's threshold.
fn split(values: &[f64], width: usize, height: usize) -> Vec<bool> {
    let (low, high) = values.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(*v), h.max(*v)));
    let scale = 255.0 / (high - low).max(f64::MIN_POSITIVE);
    // Between 0 and 255 by construction; grids are far smaller than 2^32.
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
    let levels: Vec<u8> = values.iter().map(|v| ((v - low) * scale) as u8).collect();
    let size = |n: usize| u32::try_from(n).unwrap_or(0);
    let image = GrayImage::from_raw(size(width), size(height), levels).unwrap_or_default();
    let limit = otsu_level(&image);
    image.as_raw().iter().map(|level| *level > limit).collect()
}

/// The light of the paper in one colour, without what strays.
fn surface(
    all: &[Vector3<f64>],
    colour: usize,
    is_paper: &[bool],
    place: &dyn Fn(usize) -> (f64, f64),
) -> Option<Vector6<f64>> {
    let mut limit = f64::INFINITY;
    let mut found: Option<Vector6<f64>> = None;
    for _ in 0..2 {
        let (mut normal, mut right) = (Matrix6::zeros(), Vector6::zeros());
        for i in (0..all.len()).filter(|&i| is_paper[i]) {
            let (x, y) = place(i);
            let t = terms(x, y);
            if found.is_none_or(|c| (c.dot(&t) - all[i][colour]).abs() <= limit) {
                normal += t * t.transpose();
                right += t * all[i][colour];
            }
        }
        let solved = normal.cholesky()?.solve(&right);
        let left = (0..all.len()).filter(|&i| is_paper[i]).map(|i| {
            let (x, y) = place(i);
            (solved.dot(&terms(x, y)) - all[i][colour]).abs()
        });
        limit = 4.0 * super::super::curve::median(left.collect()) + 1.0;
        found = Some(solved);
    }
    found
}
