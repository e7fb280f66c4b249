//! A bending finger, seen from the side: its centreline, the angle it bends by, its tip, its curvature.
//!
//! ```text
//! strip on a grid, root to tip --> centreline: a polynomial of the tangent --> both edges along its normals, with their blur
//!      --> the middles between them --> centreline, of the degree that they ask for --> the end, on lines along it --> tip, angle
//! ```
//!
//! What has an outline on one side only cannot be seen to bend: from where a round end begins, half a width before it, the centreline goes
//! straight on. The tip is where it meets the outline of the free end; the angle, by how much the tangent turns from the root to there. A
//! flat end begins with the tip. Angles are positive from x towards y, clockwise as one looks at the picture. Where one outline is wavy and the
//! other is not, the centreline is that at half the width between the waves from the smooth one.

pub mod markers;
mod path;
mod sides;
mod strip;

use std::fmt;

use nalgebra::Vector2;

use super::diameter::EdgeUse;
use super::edge::Blur;
use super::picture::{Picture, Place};
use super::silhouette::{Refusal, Sought};
use path::{DEGREE_MAX, Path, wrapped};
use sides::{Looked, Sides};
use strip::{Strip, strip};

/// The first guess of the blur, in px.
const BLUR_FIRST_PX: f64 = 1.8;

/// A finger has two clear outlines up to this share of half its width before its round end begins.
const END_HALVES: f64 = 0.15;

/// Fewer stations with both edges are too few; of all, such a share.
const STATIONS_MIN: usize = 20;
const STATIONS_SHARE_MIN: f64 = 0.5;

/// A picture in which so many edges are saturated is.
const SATURATED_SHARE_MAX: f64 = 0.3;

/// What remains beside noise, in px: along the finger, of an end that is no perfect circle, and across it, of outlines that are no mirror
/// of each other; and by how much the place is open from where it is straight.
const END_FLOOR_PX: f64 = 0.06;
const FLOOR_PX: f64 = 0.02;
const STRAIGHT_PX: f64 = 0.1;

/// One degree more is to be worth so many times what Schwarz's criterion asks: a bend that is not there turns the end.
const STRICT: f64 = 2.0;

/// A finger is at most so many times as wide where it begins as farther on; more may be a mount.
const WIDER: f64 = 1.12;

/// Sides of a polygon that stands for a curve.
const SIDES: usize = 60;

/// Places at which the curvature is told.
const PROFILE: usize = 41;

/// What is sought.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct SoughtBending {
    /// Where, and whether it is darker than what is around; the axis does not matter.
    pub body: Sought,
    /// Where the finger leaves its mount, in px; `None`: at the shoulders of a mount that is wider, or where it leaves the picture or the region.
    pub root: Option<Place>,
    /// The direction of the finger at its root, where the rig knows it: from x towards y, in rad; `None`: as its centreline begins.
    pub heading_rad: Option<f64>,
}

/// A bent finger. Places and lengths are those of a straightened picture where the lens is given.
#[derive(Debug, Clone, PartialEq)]
pub struct Bending {
    /// Where it begins.
    pub root: Place,
    /// Where it ends.
    pub tip: Place,
    /// Standard uncertainty of the tip along the centreline and across it, in px.
    pub tip_std_px: [f64; 2],
    /// By how much the tangent turns from the root to the tip, in rad.
    pub angle_rad: f64,
    /// Its standard uncertainty.
    pub angle_std_rad: f64,
    /// The direction at the root, in rad from x towards y.
    pub heading_rad: f64,
    /// The direction that was named.
    pub named_heading_rad: Option<f64>,
    /// Standard uncertainty of where it begins, along it, in px.
    pub root_std_px: f64,
    /// Along the centreline, in px, and its standard uncertainty.
    pub length_px: (f64, f64),
    /// The curvature along it.
    pub curvature: Vec<CurvatureAt>,
    /// The arc of constant curvature that comes nearest.
    pub arc: ConstantCurvature,
    /// The centreline, from the root to the tip, and all edges, as they are seen in the picture.
    pub centreline: Vec<Place>,
    /// Edges, as they are seen in the picture.
    pub edges: Vec<(Place, EdgeUse)>,
    /// Blur of its edges, in px (standard deviation); NaN where markers were looked at.
    pub blur_px: f64,
    /// Brightness of the finger and its surroundings beside the edges, 0 to 255; NaN where markers were looked at.
    pub levels: (f64, f64),
    /// Degree of the tangent's polynomial: 1 is constant curvature.
    pub degree: usize,
    /// What is worth knowing.
    pub flags: Vec<BendingFlag>,
}

/// The curvature at a place.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CurvatureAt {
    /// From the root, in px.
    pub along_px: f64,
    /// In 1/px.
    pub per_px: f64,
    /// Its standard uncertainty.
    pub std_per_px: f64,
}

/// An arc through the same middles.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ConstantCurvature {
    /// In 1/px.
    pub per_px: f64,
    /// Its standard uncertainty, if the finger were one.
    pub std_per_px: f64,
    /// How far the centreline lies beside it, root mean square, in px.
    pub rms_px: f64,
    /// The same, at most.
    pub worst_px: f64,
}

/// What the user should know of a measured finger.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum BendingFlag {
    /// Edges beside brightness at the end of its range, as a share.
    Clipped(f64),
    /// Stations without both edges, as a share.
    Gaps(f64),
    /// Blurred by so many px.
    Blurred(f64),
    /// One side is wavy: the other tells how it bends.
    OneSide,
    /// So many times as wide where it begins as farther on, without a step in its width.
    Wider(f64),
    /// So many spots of the markers' colour are too small for markers.
    Specks(usize),
    /// Middles stray by so many px about the centreline: a wavy outline.
    Wavy(f64),
}

impl fmt::Display for BendingFlag {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Clipped(share) => {
                write!(f, "{:.0} % of its edges lie beside brightness at the end of its range", 100.0 * share)
            }
            Self::Gaps(share) => {
                write!(f, "{:.0} % of its length shows no edge on one side or the other", 100.0 * share)
            }
            Self::Blurred(px) => write!(f, "blurred by {px:.1} px"),
            Self::OneSide => write!(f, "one side is wavy: its centreline was taken from the smooth one"),
            Self::Wider(times) => write!(
                f,
                "{times:.2} times as wide where it begins as farther on: if that is a mount, name the `root` where it ends"
            ),
            Self::Specks(count) => write!(f, "{count} small spots of the markers' colour beside them"),
            Self::Wavy(px) => write!(f, "its outline is wavy: the middle strays by {px:.2} px about the centreline"),
        }
    }
}

/// Why there is no angle.
#[derive(Debug, Clone, PartialEq)]
pub enum BendingRefusal {
    /// No contrast, or the like.
    Body(Refusal),
    /// Nothing that is long and wide enough.
    NoBody,
    /// Two or more.
    SeveralBodies,
    /// The finger closes a ring: it touches itself, or something else.
    Ring,
    /// Both of its ends are in the picture.
    NoRoot,
    /// It leaves the picture at two places: its tip may lie outside.
    TwoExits,
    /// The root that was named is no end of it.
    FarRoot {
        /// How far away its nearer end is, in px.
        px: f64,
    },
    /// A mount that is wider, without shoulders on both sides.
    NoShoulders,
    /// Not twice as long as wide.
    Short,
    /// Too few stations with two edges.
    FewEdges {
        /// Found.
        found: usize,
        /// Looked for.
        of: usize,
    },
    /// The picture is as bright, or as dark, as it can be beside the edges.
    Saturated {
        /// The share of edges where it is so.
        share: f64,
    },
    /// No end was found.
    NoTip,
    /// The lens is not known there.
    Lens,
}

impl fmt::Display for BendingRefusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Body(why) => write!(f, "{why}"),
            Self::NoBody => {
                write!(f, "no finger: nothing long stands out from what is around; name the `region` it lies in")
            }
            Self::SeveralBodies => write!(f, "several bodies of like size; name the `region` of the one to measure"),
            Self::Ring => write!(
                f,
                "the finger closes a ring: it touches itself or something else, so that nobody sees where it ends"
            ),
            Self::NoRoot => write!(
                f,
                "both ends of the finger are in the picture, and nobody knows which is its root; name the `root`, or a `region` that it leaves there"
            ),
            Self::TwoExits => write!(
                f,
                "the finger leaves the picture at both ends, or at its tip; show all of it, or name its `region`"
            ),
            Self::FarRoot { px } => write!(f, "the `root` lies {px:.0} px from the nearer end of the finger"),
            Self::NoShoulders => write!(
                f,
                "the finger begins in something wider, whose edge beside the finger is not seen on both sides; name the `root`, or a `region` without the mount"
            ),
            Self::Short => write!(f, "the finger is not twice as long as wide: no centreline"),
            Self::FewEdges { found, of } => {
                write!(
                    f,
                    "both edges were found at {found} of {of} stations only: blurred, covered or without contrast"
                )
            }
            Self::Saturated { share } => write!(
                f,
                "saturated: at {:.0} % of the edges the picture is as bright or as dark as it can be; expose less, or more",
                100.0 * share
            ),
            Self::NoTip => write!(f, "the free end has no clear edge: covered, or against something of its brightness"),
            Self::Lens => {
                write!(f, "the lens is not known there: its model folds; calibrate with corners near the border")
            }
        }
    }
}

/// The finger in a picture. `straight` is where a pinhole would have seen a place: the identity without a calibrated lens.
///
/// # Errors
/// Why there is none.
pub fn bending(
    picture: &Picture,
    sought: SoughtBending,
    straight: &dyn Fn(Place) -> Option<Place>,
) -> Result<Bending, BendingRefusal> {
    let coarse = strip(picture, &sought)?;
    let mut looked =
        Looked { picture, blur: Blur::new(), is_dark: coarse.is_dark, blur_px: BLUR_FIRST_PX, levels: (0.0, 0.0) };
    let (path, mut half_px) = first(&mut looked, &coarse)?;
    let (end, _) = looked
        .end(&path, path.length() + 1.6 * half_px, half_px, 1.8 * half_px + 2.0 * coarse.step)
        .ok_or(BendingRefusal::NoTip)?;
    // From where it begins to where its round end does.
    let root_at = |looked: &Looked, path: &Path, half_px: f64| match (sought.root, coarse.mount) {
        (Some(root), _) => Ok((path.nearest_of_all(root), 0.0)),
        (None, Some(mount)) => {
            let near = path.nearest_of_all(mount);
            let reach = 2.5 * coarse.step + half_px;
            let beside = |half_px: f64| looked.shoulders(path, near, half_px, reach);
            // One that tapers is wider there than in its middle.
            beside(half_px).or_else(|| beside(half_px * coarse.wider)).ok_or(BendingRefusal::NoShoulders)
        }
        (None, None) => Ok((leaves(picture, &sought, path), 0.0)),
    };
    let ((from, _), to) = (root_at(&looked, &path, half_px)?, end.s - END_HALVES * half_px);
    if to - from < 2.0 * half_px {
        return Err(BendingRefusal::Short);
    }
    let mut path = between(&path, from, to).ok_or(BendingRefusal::Short)?;
    let mut before: Option<Sides> = None;
    for _ in 0..3 {
        let reach = if before.is_some() { 0.0 } else { 0.3 * half_px + 3.0 };
        let range = (0.0, path.length());
        let sides = looked.sides(&path, range, half_px, reach, before.as_ref());
        path = checked(path.fitted(&sides.middles(&path), DEGREE_MAX), &sides)?;
        half_px = sides.half_px();
        before = Some(sides);
    }
    let sides = looked.sides(&path, (0.0, path.length()), half_px, 0.0, before.as_ref());
    if sides.clipped > SATURATED_SHARE_MAX {
        return Err(BendingRefusal::Saturated { share: sides.clipped });
    }
    // As many degrees of freedom as the middles ask for: more would turn the end.
    let of_stations = sides.stations.len();
    let seen = sides.middles(&path);
    let few = || BendingRefusal::FewEdges { found: seen.len(), of: of_stations };
    let edges = sides.places(&path);
    let (path, degree) = best(&path, &seen).ok_or_else(few)?;
    let (end, end_edges) = looked
        .end(&path, path.length() + (1.0 + END_HALVES) * half_px, half_px, half_px + 3.0)
        .ok_or(BendingRefusal::NoTip)?;
    let (seen_root, root_std_px) = root_at(&looked, &path, half_px)?;
    // In the straightened picture.
    let found = seen.len();
    let points: Vec<(f64, Place)> = seen
        .iter()
        .map(|(s, place)| Some((*s, straight(*place)?)))
        .collect::<Option<_>>()
        .ok_or(BendingRefusal::Lens)?;
    // The middles as they are straightened, along a curve of their own: a lens may move them far.
    let step = (points.len() / SIDES).max(1);
    let polygon: Vec<Place> = points.iter().step_by(step).chain(points.last()).map(|p| p.1).collect();
    let own = Path::of_polygon(&polygon, DEGREE_MAX).ok_or(BendingRefusal::Short)?;
    let points: Vec<(f64, Place)> = points.iter().map(|(_, place)| (own.nearest_of_all(*place), *place)).collect();
    let line = own.fitted(&points, degree).ok_or_else(few)?;
    let on_line = |s: f64| straight(path.at(s)).map(|place| line.nearest_of_all(place)).ok_or(BendingRefusal::Lens);
    let (root_s, tip_s) = (on_line(seen_root)?, on_line(end.s)?);
    let seen_tip = path.at(end.s) + direction(path.angle(end.s)) * end.ahead;
    let tip = straight(seen_tip).ok_or(BendingRefusal::Lens)?;
    let ahead = (tip - line.at(tip_s)).norm();
    let (heading, angle_std_rad) = match sought.heading_rad {
        Some(heading) => {
            let own = line.angle(root_s);
            (own + wrapped(heading - own), line.angle_std(tip_s))
        }
        None => (line.angle(root_s), line.turn_std(root_s, tip_s)),
    };
    // What the place of the root leaves open turns the beginning.
    let of_root = if sought.heading_rad.is_some() { 0.0 } else { root_std_px * line.curvature(root_s).0 };
    let angle_std_rad = angle_std_rad.hypot(STRAIGHT_PX * line.curvature(tip_s).0).hypot(of_root);
    let bent = (0..PROFILE).map(|i| path.at(seen_root + (end.s - seen_root) * i as f64 / (PROFILE - 1) as f64));
    let mut flags = Vec::new();
    if sides.clipped > 0.01 {
        flags.push(BendingFlag::Clipped(sides.clipped));
    }
    let gaps = 1.0 - found as f64 / of_stations as f64;
    if gaps > 0.1 {
        flags.push(BendingFlag::Gaps(gaps));
    }
    if looked.blur_px > 4.0 {
        flags.push(BendingFlag::Blurred(looked.blur_px));
    }
    if coarse.wider > WIDER && coarse.mount.is_none() && sought.root.is_none() {
        flags.push(BendingFlag::Wider(coarse.wider));
    }
    if sides.smooth_side().is_some() {
        flags.push(BendingFlag::OneSide);
    } else if line.left > 0.5 {
        flags.push(BendingFlag::Wavy(line.left));
    }
    let mut edges = edges;
    edges.extend(end_edges.into_iter().map(|place| (place, EdgeUse::Used)));
    Ok(Bending {
        root: line.at(root_s),
        tip,
        tip_std_px: [end.std_px.hypot(END_FLOOR_PX), line.across_std(tip_s, ahead).hypot(FLOOR_PX)],
        angle_rad: line.angle(tip_s) - heading,
        angle_std_rad,
        heading_rad: heading,
        named_heading_rad: sought.heading_rad,
        root_std_px,
        length_px: (tip_s - root_s + ahead, end.std_px.hypot(END_FLOOR_PX)),
        curvature: profile(&line, (root_s, tip_s)),
        arc: arc(&line, &points, (root_s, tip_s)).ok_or_else(few)?,
        centreline: bent.chain([seen_tip]).collect(),
        edges,
        blur_px: looked.blur_px,
        levels: looked.levels,
        degree,
        flags,
    })
}

/// A centreline through edges about the coarse one, and half the width.
fn first(looked: &mut Looked, coarse: &Strip) -> Result<(Path, f64), BendingRefusal> {
    let path = Path::of_polygon(&coarse.middles, DEGREE_MAX).ok_or(BendingRefusal::Short)?;
    let polygon: Vec<(f64, Place)> = coarse.middles.iter().map(|place| (path.nearest_of_all(*place), *place)).collect();
    let degree = DEGREE_MAX.min(coarse.middles.len().saturating_sub(3)).max(1);
    let mut path = path.fitted(&polygon, degree).unwrap_or(path);
    let mut half_px = coarse.half_px;
    for _ in 0..2 {
        let sides = looked.sides(&path, (0.0, path.length()), half_px, 2.5 * coarse.step + 0.3 * half_px + 4.0, None);
        path = checked(path.fitted(&sides.middles(&path), degree), &sides)?;
        half_px = sides.half_px();
    }
    Ok((path, half_px))
}

fn checked(path: Option<Path>, sides: &Sides) -> Result<Path, BendingRefusal> {
    let both = sides.edges[0].iter().zip(&sides.edges[1]).filter(|(a, b)| a.is_finite() && b.is_finite()).count();
    let of = sides.stations.len();
    let few = both < STATIONS_MIN || (both as f64) < STATIONS_SHARE_MIN * of as f64;
    path.filter(|_| !few).ok_or(BendingRefusal::FewEdges { found: both, of })
}

/// Where the centreline, followed backwards from where it begins, leaves the picture or the region.
fn leaves(picture: &Picture, sought: &SoughtBending, path: &Path) -> f64 {
    let (w, h) = (picture.width(), picture.height());
    let [left, top, across, down] = sought.body.region.unwrap_or([0, 0, w, h]);
    let (left, top) = (left.min(w), top.min(h));
    let (right, bottom) = ((left + across).min(w) as f64 - 0.5, (top + down).min(h) as f64 - 0.5);
    let (left, top) = (left as f64 - 0.5, top as f64 - 0.5);
    let is_in = |s: f64| {
        let at = path.at(s);
        at.x > left && at.x < right && at.y > top && at.y < bottom
    };
    // The border lies within a few half widths before the first part.
    let (mut inside, mut outside) = (0.0, -1.0);
    while is_in(outside) && outside > -path.length() {
        (inside, outside) = (outside, outside - 2.0);
    }
    for _ in 0..40 {
        let middle = f64::midpoint(inside, outside);
        if is_in(middle) { inside = middle } else { outside = middle }
    }
    inside
}

/// The same curve with its beginning and end elsewhere.
fn between(path: &Path, from: f64, to: f64) -> Option<Path> {
    let at = |i: usize| path.at(from + (to - from) * i as f64 / SIDES as f64);
    let places: Vec<Place> = (0..=SIDES).map(at).collect();
    let rough = Path::of_polygon(&places, DEGREE_MAX)?;
    let points: Vec<(f64, Place)> = places.iter().map(|place| (rough.nearest_of_all(*place), *place)).collect();
    rough.fitted(&points, DEGREE_MAX)
}

/// The curve of the degree that the middles ask for (Schwarz's criterion, with as many points as tell different things).
fn best(path: &Path, points: &[(f64, Place)]) -> Option<(Path, usize)> {
    let richest = path.fitted(points, DEGREE_MAX)?;
    let told = (richest.squares.1 as f64 / richest.together).max(8.0);
    let score = |fit: &Path, degree: usize| {
        let mean = (fit.squares.0 / fit.squares.1 as f64).max(1e-12);
        told * mean.ln() + STRICT * (degree + 2) as f64 * told.ln()
    };
    let all = (1..DEGREE_MAX).filter_map(|degree| Some((path.fitted(points, degree)?, degree)));
    let all = all.chain([(richest.clone(), DEGREE_MAX)]);
    all.min_by(|a, b| score(&a.0, a.1).total_cmp(&score(&b.0, b.1)))
}

/// The curvature from one place of a centreline to another.
fn profile(line: &Path, (from, to): (f64, f64)) -> Vec<CurvatureAt> {
    let at = |i: usize| {
        let s = from + (to - from) * i as f64 / (PROFILE - 1) as f64;
        let (per_px, std_per_px) = line.curvature(s);
        CurvatureAt { along_px: s - from, per_px, std_per_px }
    };
    (0..PROFILE).map(at).collect()
}

/// The arc of constant curvature through the same middles, and how far the centreline lies beside it.
fn arc(line: &Path, points: &[(f64, Place)], (from, to): (f64, f64)) -> Option<ConstantCurvature> {
    let arc = line.fitted(points, 1)?;
    let (per_px, std_per_px) = arc.curvature(0.5 * arc.length());
    let apart = |i: usize| {
        let place = line.at(from + (to - from) * i as f64 / (PROFILE - 1) as f64);
        let s = arc.nearest_of_all(place);
        (place - arc.at(s)).norm()
    };
    let all: Vec<f64> = (0..PROFILE).map(apart).collect();
    let rms_px = (all.iter().map(|d| d * d).sum::<f64>() / all.len() as f64).sqrt();
    Some(ConstantCurvature { per_px, std_per_px, rms_px, worst_px: all.into_iter().fold(0.0, f64::max) })
}

/// The unit vector of a direction.
pub fn direction(angle_rad: f64) -> Vector2<f64> {
    Vector2::new(angle_rad.cos(), angle_rad.sin())
}

#[cfg(test)]
mod tests;
