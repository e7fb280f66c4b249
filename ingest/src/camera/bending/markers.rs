//! A bending finger by round markers of one colour that are painted along its centreline.
//!
//! ```text
//! chroma along the named colour --> spots --> centroids --> shortest way through all, from the root --> a curve through them
//! ```
//!
//! Chroma is what a colour has beyond grey. It is linear in light: a pixel that a marker covers by half has half of it, however bright the
//! (grey) finger beneath is, so that centroids weighed by it are those of the markers. The first marker is the root, the last one the tip.

use std::fmt;

use image::{GrayImage, Luma};
use imageproc::distance_transform::{Norm, distance_transform};
use imageproc::region_labelling::{Connectivity, connected_components};
use nalgebra::{Matrix2, SymmetricEigen, Vector3};

use super::path::{Path, wrapped};
use super::{Bending, BendingFlag, ConstantCurvature, PROFILE, SIDES, profile};
use crate::camera::curve::{median, some};
use crate::camera::diameter::EdgeUse;
use crate::camera::picture::{Picture, Place};

/// Markers on one finger.
pub const COUNT: (usize, usize) = (3, 12);

/// A colour has at least so much chroma, in steps of brightness.
pub const CHROMA_MIN: f64 = 12.0;

/// Spots have more of the named chroma than this share of it, and so many standard deviations of what is around.
const SHARE_MIN: f64 = 0.25;
const NOISE_STDS: f64 = 6.0;

/// What lies farther beside the named chroma than this share of its own is of another colour.
const BESIDE: f64 = 0.5;

/// Spots of fewer px are none.
const SPOT_PX: usize = 12;

/// Of spots that are too many, those smaller than this share of the smallest marker are told, and left out.
const SPECK_SHARE: f64 = 0.25;

/// A marker is weighed to so many px about its spot, and what is around it told by as many beyond.
const MARGIN: u8 = 4;

/// Deeper within a marker than so many px it counts whole: glare within does not move it.
const DEPTH: u8 = 3;

/// What remains beside noise, in px.
const FLOOR_PX: f64 = 0.03;

/// A curve of one degree more needs so many markers more than unknowns.
const FREEDOM_MIN: usize = 2;

/// What is sought.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SoughtMarkers {
    /// Red, green and blue of the markers, 0 to 255; no grey.
    pub colour: [f64; 3],
    /// How many.
    pub count: usize,
    /// Near which place the first of them is, in px.
    pub root: Place,
    /// Where: left, top, width, height, in px; `None`: everywhere.
    pub region: Option<[usize; 4]>,
    /// The direction of the finger at its root, where the rig knows it: from x towards y, in rad; `None`: as the curve begins.
    pub heading_rad: Option<f64>,
}

/// Why the markers say nothing.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum MarkersRefusal {
    /// The region is none.
    Region,
    /// The picture has no colours.
    Grey,
    /// Too few, or too many.
    Count {
        /// Found.
        found: usize,
        /// To be found.
        of: usize,
    },
    /// One lies at the border.
    Border,
    /// The first one is far from where the root is said to be.
    FarRoot {
        /// How far, in px.
        px: f64,
    },
    /// No curve goes through them.
    NoCurve,
    /// The lens is not known there.
    Lens,
}

impl fmt::Display for MarkersRefusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Region => write!(f, "no picture there: name a `region` within it"),
            Self::Grey => write!(f, "the picture is grey: markers are told by their colour"),
            Self::Count { found, of } if found < of => write!(
                f,
                "{found} of {of} markers: covered, run together, or of another colour in this light; correct their colour or count"
            ),
            Self::Count { found, of } => write!(
                f,
                "{found} spots of the colour of {of} markers; name the `region` of the finger, or correct their colour or count"
            ),
            Self::Border => write!(f, "a marker touches the border: part of it may lie outside"),
            Self::FarRoot { px } => write!(f, "the nearest marker lies {px:.0} px from the `root`: correct it"),
            Self::NoCurve => write!(f, "no smooth curve goes through the markers"),
            Self::Lens => {
                write!(f, "the lens is not known there: its model folds; calibrate with corners near the border")
            }
        }
    }
}

/// A marker that was found.
#[derive(Debug, Clone, Copy)]
struct Marker {
    centre: Place,
    std_px: f64,
    /// Half axes and the direction of the first, of an ellipse with its moments.
    halves: [f64; 2],
    way_rad: f64,
}

/// How much of the named chroma each pixel of a region has: 0 grey, 1 as named.
struct Chroma {
    origin: (usize, usize),
    width: usize,
    height: usize,
    shares: Vec<f32>,
    /// Of what is around, in shares.
    noise: f64,
    /// Spots, from 1; 0 is none.
    labels: Vec<u32>,
    /// Pixels of each.
    counts: Vec<usize>,
}

/// The finger that markers show. `straight` is where a pinhole would have seen a place: the identity without a calibrated lens.
///
/// # Errors
/// Why there is none.
pub fn markers(
    picture: &Picture,
    sought: SoughtMarkers,
    straight: &dyn Fn(Place) -> Option<Place>,
) -> Result<Bending, MarkersRefusal> {
    if !picture.is_colour() {
        return Err(MarkersRefusal::Grey);
    }
    let chroma = Chroma::of(picture, &sought)?;
    let (spots, specks) = chroma.spots(sought.count)?;
    let found: Vec<Marker> = spots.iter().map(|label| chroma.marker(*label)).collect::<Result<_, _>>()?;
    let found = chained(&found, sought.root)?;
    let places: Vec<Place> =
        found.iter().map(|marker| straight(marker.centre)).collect::<Option<_>>().ok_or(MarkersRefusal::Lens)?;
    let stds: Vec<f64> = found.iter().map(|marker| marker.std_px).collect();
    let least = (stds.iter().map(|std| std * std).sum::<f64>() / stds.len() as f64).sqrt();
    let line = through(&places, least).ok_or(MarkersRefusal::NoCurve)?;
    let arc = of_degree(&places, 1, least).ok_or(MarkersRefusal::NoCurve)?;
    let (root, tip) = (places[0], places[places.len() - 1]);
    let (root_s, tip_s) = (line.nearest_of_all(root), line.nearest_of_all(tip));
    let own = line.angle(root_s);
    let (heading, angle_std_rad) = match sought.heading_rad {
        Some(heading) => (own + wrapped(heading - own), line.angle_std(tip_s)),
        None => (own, line.turn_std(root_s, tip_s)),
    };
    let beside: Vec<f64> = places.iter().map(|place| (place - arc.at(arc.nearest_of_all(*place))).norm()).collect();
    let (per_px, std_per_px) = arc.curvature(0.5 * arc.length());
    // The curve as it is seen: straight lines where the lens bends it are not told from it over so short ways.
    let seen: Vec<Place> = found.iter().map(|marker| marker.centre).collect();
    let drawn = of_degree(&seen, line.degree(), least).unwrap_or_else(|| line.clone());
    let (from, to) = (drawn.nearest_of_all(seen[0]), drawn.nearest_of_all(seen[seen.len() - 1]));
    let mut flags = vec![];
    if specks > 0 {
        flags.push(BendingFlag::Specks(specks));
    }
    Ok(Bending {
        root,
        tip,
        tip_std_px: [stds[stds.len() - 1]; 2],
        angle_rad: line.angle(tip_s) - heading,
        angle_std_rad,
        heading_rad: heading,
        named_heading_rad: sought.heading_rad,
        root_std_px: stds[0],
        length_px: (tip_s - root_s, stds[stds.len() - 1]),
        curvature: profile(&line, (root_s, tip_s)),
        arc: ConstantCurvature {
            per_px,
            std_per_px,
            rms_px: (beside.iter().map(|d| d * d).sum::<f64>() / beside.len() as f64).sqrt(),
            worst_px: beside.iter().copied().fold(0.0, f64::max),
        },
        centreline: (0..PROFILE).map(|i| drawn.at(from + (to - from) * i as f64 / (PROFILE - 1) as f64)).collect(),
        edges: found.iter().flat_map(Marker::outline).collect(),
        blur_px: f64::NAN,
        levels: (f64::NAN, f64::NAN),
        degree: line.degree(),
        flags,
    })
}

impl Chroma {
    fn of(picture: &Picture, sought: &SoughtMarkers) -> Result<Self, MarkersRefusal> {
        let (w, h) = (picture.width(), picture.height());
        let [left, top, width, height] = sought.region.unwrap_or([0, 0, w, h]);
        let (left, top) = (left.min(w), top.min(h));
        let (width, height) = (width.min(w - left), height.min(h - top));
        if width.min(height) <= 4 * usize::from(MARGIN) {
            return Err(MarkersRefusal::Region);
        }
        let named = beyond_grey(sought.colour);
        let per = 1.0 / named.norm_squared();
        let (mut shares, mut is_named) = (Vec::with_capacity(width * height), Vec::with_capacity(width * height));
        for (x, y) in (0..height).flat_map(|y| (0..width).map(move |x| (x, y))) {
            let own = beyond_grey(picture.rgb(left + x, top + y).map(f64::from));
            let share = own.dot(&named) * per;
            is_named.push((own - named * share).norm_squared() <= (BESIDE * share).powi(2) / per);
            // Of the order of one: single precision holds it to a millionth.
            #[allow(clippy::cast_possible_truncation)]
            shares.push(share as f32);
        }
        let usual = median(some(shares.iter().map(|share| f64::from(*share))));
        let noise = 1.482_6 * median(some(shares.iter().map(|share| (f64::from(*share) - usual).abs())));
        let limit = SHARE_MIN.max(usual + NOISE_STDS * noise);
        let mask = shares.iter().zip(is_named).map(|(share, is)| is && f64::from(*share) > limit);
        let (labels, counts) = parts(mask, (width, height), Connectivity::Eight);
        Ok(Self { origin: (left, top), width, height, shares, noise, labels, counts })
    }

    /// The labels of as many spots, and how many specks there are beside them.
    fn spots(&self, count: usize) -> Result<(Vec<u32>, usize), MarkersRefusal> {
        let numbered = (0_u32..).zip(&self.counts).skip(1).filter(|(_, pixels)| **pixels >= SPOT_PX);
        let mut all: Vec<(u32, usize)> = numbered.map(|(label, pixels)| (label, *pixels)).collect();
        all.sort_by_key(|(label, pixels)| (std::cmp::Reverse(*pixels), *label));
        let wrong = Err(MarkersRefusal::Count { found: all.len(), of: count });
        let Some((_, least)) = count.checked_sub(1).and_then(|last| all.get(last)) else { return wrong };
        if all.get(count).is_some_and(|(_, next)| *next as f64 > SPECK_SHARE * *least as f64) {
            return wrong;
        }
        Ok((all[..count].iter().map(|(label, _)| *label).collect(), all.len() - count))
    }

    fn marker(&self, label: u32) -> Result<Marker, MarkersRefusal> {
        let own = |i: &usize| self.labels[*i] == label;
        let all: Vec<(usize, usize)> =
            (0..self.labels.len()).filter(own).map(|i| (i % self.width, i / self.width)).collect();
        let range = |of: fn(&(usize, usize)) -> usize| {
            (all.iter().map(of).min().unwrap_or(0), all.iter().map(of).max().unwrap_or(0))
        };
        let ((left, right), (top, bottom)) = (range(|p| p.0), range(|p| p.1));
        if left == 0 || top == 0 || right + 1 == self.width || bottom + 1 == self.height {
            return Err(MarkersRefusal::Border);
        }
        // Room for the marker's rim and for what is around.
        let margin = 2 * usize::from(MARGIN) + 1;
        let (x0, y0) = (left.saturating_sub(margin), top.saturating_sub(margin));
        let size = ((right + margin).min(self.width - 1) - x0 + 1, (bottom + margin).min(self.height - 1) - y0 + 1);
        let at = |i: usize| (y0 + i / size.0) * self.width + x0 + i % size.0;
        let count = size.0 * size.1;
        let mut is_own: Vec<bool> = (0..count).map(|i| own(&at(i))).collect();
        // What is not of it, but does not hang together with what is around, is glare.
        let (outside, _) = parts(is_own.iter().map(|is| !is), size, Connectivity::Four);
        let open = outside[0];
        is_own.iter_mut().zip(&outside).for_each(|(is, label)| *is |= *label != open);
        let image = |of: bool| gray(is_own.iter().map(|is| *is == of), size);
        let beyond = distance_transform(&image(true), Norm::LInf).into_raw();
        let depth = distance_transform(&image(false), Norm::LInf).into_raw();
        let is_other = |i: usize| self.labels[at(i)] != label && self.labels[at(i)] != 0 && !is_own[i];
        let share = |i: usize| f64::from(self.shares[at(i)]);
        let inside = median((0..count).filter(|i| depth[*i] >= 2).map(share).collect());
        let inside = if inside > 0.0 { inside } else { (0..count).map(share).fold(0.0, f64::max) };
        let around = (0..count).filter(|i| beyond[*i] > MARGIN && !is_other(*i));
        let around = median(around.map(share).collect());
        let height = inside - around;
        let (mut sum, mut moment) = (0.0, Place::zeros());
        let weighed: Vec<(Place, f64, bool)> = (0..count)
            .filter(|i| beyond[*i] <= MARGIN && !is_other(*i))
            .map(|i| {
                let is_deep = depth[i] > DEPTH;
                let weight = if is_deep { 1.0 } else { (share(i) - around) / height };
                (Place::new((x0 + i % size.0) as f64, (y0 + i / size.0) as f64), weight, is_deep)
            })
            .collect();
        for (place, weight, _) in &weighed {
            sum += weight;
            moment += place * *weight;
        }
        let centre = moment / sum;
        if !(sum > 0.0 && height > 0.0 && centre.iter().all(|v| v.is_finite())) {
            return Err(MarkersRefusal::NoCurve);
        }
        let (mut second, mut lever) = (Matrix2::zeros(), 0.0);
        for (place, weight, is_deep) in &weighed {
            let apart = place - centre;
            second += apart * apart.transpose() * (*weight / sum);
            lever += if *is_deep { 0.0 } else { 0.5 * apart.norm_squared() };
        }
        let eigen = SymmetricEigen::new(second);
        let way = eigen.eigenvectors.column(0);
        let origin = Place::new(self.origin.0 as f64, self.origin.1 as f64);
        Ok(Marker {
            centre: centre + origin,
            std_px: (self.noise / height * lever.sqrt() / sum).hypot(FLOOR_PX),
            // A disc of radius r has the second moment r²/4.
            halves: [0, 1].map(|k| 2.0 * eigen.eigenvalues[k].max(0.0).sqrt()),
            way_rad: way[1].atan2(way[0]),
        })
    }
}

impl Marker {
    fn outline(&self) -> impl Iterator<Item = (Place, EdgeUse)> + '_ {
        let (first, second) =
            (super::direction(self.way_rad), super::direction(self.way_rad + std::f64::consts::FRAC_PI_2));
        (0..SIDES).map(move |i| {
            let (sin, cos) = (std::f64::consts::TAU * i as f64 / SIDES as f64).sin_cos();
            (self.centre + first * (self.halves[0] * cos) + second * (self.halves[1] * sin), EdgeUse::Used)
        })
    }
}

/// What a colour has beyond grey.
fn beyond_grey(rgb: [f64; 3]) -> Vector3<f64> {
    let colour = Vector3::from(rgb);
    colour.add_scalar(-colour.mean())
}

/// Whether a colour is told from grey.
pub fn has_chroma(rgb: [f64; 3]) -> bool {
    beyond_grey(rgb).norm() >= CHROMA_MIN
}

fn gray(mask: impl Iterator<Item = bool>, (width, height): (usize, usize)) -> GrayImage {
    let pixels = mask.map(|is| if is { 255 } else { 0 }).collect();
    // Pictures are counted in 32 bits.
    let size = |n: usize| u32::try_from(n).unwrap_or(0);
    GrayImage::from_raw(size(width), size(height), pixels).unwrap_or_default()
}

/// Parts of a mask, from 1, and their pixels.
fn parts(mask: impl Iterator<Item = bool>, size: (usize, usize), by: Connectivity) -> (Vec<u32>, Vec<usize>) {
    let labels = connected_components(&gray(mask, size), by, Luma([0])).into_raw();
    let mut counts = vec![0; labels.iter().copied().max().unwrap_or(0) as usize + 1];
    for label in &labels {
        counts[*label as usize] += 1;
    }
    (labels, counts)
}

/// Markers in the order of the shortest way through all of them that begins with the one nearest to the root.
fn chained(all: &[Marker], root: Place) -> Result<Vec<Marker>, MarkersRefusal> {
    let n = all.len();
    let apart = |i: usize, j: usize| (all[i].centre - all[j].centre).norm();
    let of_root = |i: &usize| (all[*i].centre - root).norm();
    let first = (0..n).min_by(|a, b| of_root(a).total_cmp(&of_root(b))).ok_or(MarkersRefusal::NoCurve)?;
    // The shortest way through each set of markers to each of them (Held and Karp): of twelve, some ten thousand.
    let mut best = vec![vec![(f64::INFINITY, first); n]; 1 << n];
    best[1 << first][first].0 = 0.0;
    for set in 1..1_usize << n {
        for last in (0..n).filter(|i| set >> i & 1 == 1) {
            let so_far = best[set][last].0;
            for next in (0..n).filter(|i| set >> i & 1 == 0) {
                let length = so_far + apart(last, next);
                if length < best[set | 1 << next][next].0 {
                    best[set | 1 << next][next] = (length, last);
                }
            }
        }
    }
    let mut set = (1_usize << n) - 1;
    let end = |a: &usize, b: &usize| best[set][*a].0.total_cmp(&best[set][*b].0);
    let mut last = (0..n).min_by(end).ok_or(MarkersRefusal::NoCurve)?;
    let mean = best[set][last].0 / (n - 1) as f64;
    if of_root(&first) > mean {
        return Err(MarkersRefusal::FarRoot { px: of_root(&first) });
    }
    let mut order = vec![last];
    while order.len() < n {
        let before = best[set][last].1;
        set &= !(1 << last);
        last = before;
        order.push(last);
    }
    Ok(order.into_iter().rev().map(|i| all[i]).collect())
}

/// A curve of a degree through places, which are known no better than so many px.
fn of_degree(places: &[Place], degree: usize, least: f64) -> Option<Path> {
    let rough = Path::of_polygon(places, degree)?;
    let points: Vec<(f64, Place)> = places.iter().map(|place| (rough.nearest_of_all(*place), *place)).collect();
    Some(rough.fitted_to_all(&points, degree)?.known_to(least))
}

/// The curve that the markers ask for (Schwarz's criterion): an arc, unless enough of them say otherwise.
fn through(places: &[Place], least: f64) -> Option<Path> {
    let n = places.len() as f64;
    let score = |path: &Path| {
        let mean = (path.squares.0 / n).max(least * least);
        n * mean.ln() + super::STRICT * (path.degree() + 2) as f64 * n.ln()
    };
    let most = places.len().saturating_sub(2 + FREEDOM_MIN).clamp(1, super::DEGREE_MAX);
    let all = (1..=most).filter_map(|degree| of_degree(places, degree, least));
    all.min_by(|a, b| score(a).total_cmp(&score(b)))
}
