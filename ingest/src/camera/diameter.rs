//! The largest width of a body across its axis, and its width all along.
//!
//! ```text
//! body --> edges of some rows, with their blur --> two curves --> edges of every row, one step from those curves
//!      --> axis: the line on which the middles between the sides lie --> two curves in its frame --> the largest distance
//! ```
//!
//! Edges are fitted along rows (columns, where the axis lies across); a slanting one looks wider there by its slope, which is taken into
//! account. Curves are polynomials of the degree that the edges ask for. Blur moves the half level of a curved edge towards its centre,
//! by σ²/2 over the radius, which is taken back.

mod axis;
mod outline;
mod seeker;

use nalgebra::Vector2;

use super::curve::{Curve, DEGREE_MAX, median, some};
use super::picture::{Picture, Place};
use super::silhouette::{Axis, Body, Refusal, Row, Sought, body};
use axis::axis;
use outline::{largest, part_above, profile};
use seeker::{Found, Rows, Seeker};

/// Where the body is thinner than this share of its largest width, only one of so many rows is looked at: a curve turned by its tilt needs some
/// more than the four fifths of the width over which it is measured.
const THIN_SHARE: f64 = 0.76;
const PROFILE_STEP: usize = 4;

/// Thinner than this share of the largest width nothing is looked at; and from one row of the grid to the next a body does not become so
/// many times as wide.
const LEAST_SHARE: f64 = 0.45;
const JUMP: f64 = 1.5;

/// An edge is odd where its line strays so many times as much as the others' (in squares, beside what rounding to whole steps makes) and by
/// such a share of its height, or where its height is off by so many deviations and by such a share.
const ODD_NOISE: f64 = 3.0;
const QUANTISED: f64 = 0.25;
const ODD_SHARE: f64 = 0.06;
const ODD_STDS: f64 = 5.0;
const ODD_HEIGHT: f64 = 0.1;
const DEGREE_HEIGHT: usize = 2;

/// Where an outline goes over so many px a row, near either end, the body ends.
const END_SLOPE: f64 = 1.2;

/// The degree of the first curves.
const DEGREE_FIRST: usize = 4;

/// The first curve passes by edges that are so many times the blur away from it: there the outline is no such curve.
const PASSES_BLURS: f64 = 1.5;

/// Fewer edges of a side are too few.
const EDGES_MIN: usize = 12;
const EDGES_SHARE_MIN: f64 = 0.5;

/// Blur in px that is looked for.
const BLUR_PX: (f64, f64) = (0.5, 12.0);

/// A picture in which so many edges are saturated is.
const SATURATED_SHARE_MAX: f64 = 0.3;

/// Blur is told by rows about the widest place, where the outline's slope is known best.
const BLUR_SHARE: f64 = 0.92;

/// Rounds in which the blur settles, which it has where it changes by less than such a share.
const ROUNDS: usize = 3;
const SETTLED: f64 = 0.01;
const STEPS_MAX: usize = 4;

/// Where edges stray so many times as much as noise makes them, a narrower part is tried, where the body is as wide as this share of its
/// largest width; it is taken where they stray less by such a share.
const ROUGH: f64 = 1.4;
const NARROWER: [f64; 5] = [0.86, 0.91, 0.95, 0.97, 0.985];
const LESS_ROUGH: f64 = 0.8;

/// What remains beside noise: of pixels that are not alike, and curves that are no polynomials. Standard uncertainty in px.
const FLOOR_PX: f64 = 0.003;

/// Part of the blur's shift that is left open: blur is not quite normal, and not all of it is that of the lens.
const SHIFT_SHARE: f64 = 1.0;

/// What the user should know of a measured width.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Flag {
    /// The body is about as long as wide, or stands on a mount and is wider than long: its axis was taken to lie so.
    AxisGuessed(Axis),
    /// It reaches out of the picture along its axis; its width there hardly changes.
    Cut,
    /// Some edges lie beside brightness that is as high, or as low, as it can be: so many, as a share.
    Clipped(f64),
    /// So many edges, as a share, are no part of the curves: glare, a wire, dirt.
    Strays(f64),
    /// Edges stray about their curves so many times as much as noise makes them.
    Rough(f64),
    /// Blurred by so many px (standard deviation).
    Blurred(f64),
}

impl std::fmt::Display for Flag {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::AxisGuessed(axis) => {
                let how = match axis {
                    Axis::Vertical => "stand upright",
                    Axis::Horizontal => "lie across",
                };
                write!(f, "its shape does not say which way its axis lies: taken to {how}; `axis` says it")
            }
            Self::Cut => write!(f, "it reaches out of the picture along its axis"),
            Self::Clipped(share) => {
                write!(f, "{:.0} % of its edges lie beside brightness at the end of its range", 100.0 * share)
            }
            Self::Strays(share) => write!(f, "{:.0} % of its edges are left out: glare, a wire or dirt", 100.0 * share),
            Self::Rough(times) => write!(f, "its edges stray {times:.1} times as much as noise makes them"),
            Self::Blurred(px) => write!(f, "blurred by {px:.1} px"),
        }
    }
}

/// A width.
#[derive(Debug, Clone, PartialEq)]
pub struct Diameter {
    /// The largest distance of the two edges across the axis, in px.
    pub width_px: f64,
    /// Its standard uncertainty.
    pub std_px: f64,
    /// The ends of that line on the picture (of a lens that was given, where a pinhole would see them).
    pub ends: [Place; 2],
    /// The direction of the axis, downwards or to the right.
    pub axis: Vector2<f64>,
    /// Standard uncertainty of that direction, in rad.
    pub axis_std_rad: f64,
    /// Standard deviation of the blur, in px.
    pub blur_px: f64,
    /// Brightness of body and surroundings beside the edges, 0 to 255.
    pub levels: (f64, f64),
    /// Standard deviation of the noise, in steps.
    pub noise: f64,
    /// By how much the blur of curved edges was corrected, in px.
    pub shift_px: f64,
    /// The degree of the curves.
    pub degree: usize,
    /// Edges of the two curves, and those of them that are used.
    pub edges: [Vec<(Place, EdgeUse)>; 2],
    /// The width all along the body.
    pub profile: Vec<Width>,
    /// What is worth knowing.
    pub flags: Vec<Flag>,
}

/// What becomes of an edge.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum EdgeUse {
    /// The largest width rests on it.
    Used,
    /// It lies beyond: only the profile has it.
    Beyond,
    /// It is no part of the outline: glare, a wire, dirt.
    Odd,
}

/// The width at a place of the axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Width {
    /// Along the axis from the widest place, in px.
    pub along_px: f64,
    /// The width, in px.
    pub width_px: f64,
    /// Its standard uncertainty.
    pub std_px: f64,
}

/// The two outlines of a body over its rows.
type Outlines = [Curve; 2];

/// The largest width of the body in a picture. `straight` is where a pinhole would have seen a place: the identity without a calibrated
/// lens.
///
/// # Errors
/// Why there is none.
pub fn diameter(
    picture: &Picture,
    sought: Sought,
    straight: &dyn Fn(Place) -> Option<Place>,
) -> Result<Diameter, Refusal> {
    let body = body(picture, sought)?;
    let mut seeker = Seeker::new(picture, body.axis);
    let wide = wide_rows(&body)?;
    let first = first(&mut seeker, &body, &wide)?;
    let blur_px = first.blur_px;
    let found = every(&mut seeker, &first, &wide);
    let found = found.map(sound);
    let looked_for = found[0].len().max(found[1].len()).max(wide.len());
    for side in &found {
        if side.len() < EDGES_MIN || (side.len() as f64) < EDGES_SHARE_MIN * looked_for as f64 {
            return Err(Refusal::FewEdges { found: side.len(), of: looked_for });
        }
    }
    let clipped = share(found.iter().flatten(), |f| f.is_clipped);
    if clipped > SATURATED_SHARE_MAX {
        return Err(Refusal::Saturated { share: clipped });
    }
    measure(&seeker.rows, &body, &found, blur_px, clipped, straight)
}

fn share<'a>(of: impl Iterator<Item = &'a Found>, is: impl Fn(&Found) -> bool) -> f64 {
    let (mut n, mut such) = (0.0, 0.0);
    for one in of {
        n += 1.0;
        such += f64::from(u8::from(is(one)));
    }
    if n > 0.0 { such / n } else { 0.0 }
}

/// The rows about the largest circle in the body, down to where it is thin, a mount or a cable, or stands on something.
fn wide_rows(body: &Body) -> Result<Vec<Row>, Refusal> {
    let width = |row: &Row| (row.span.1 - row.span.0) as f64;
    let middle = *body.rows.get(body.deepest).ok_or(Refusal::NoBody)?;
    if !middle.is_free {
        return Err(Refusal::Border);
    }
    let mut widest = width(&middle);
    let mut walk = |rows: &mut dyn Iterator<Item = &Row>| {
        let mut found: Vec<Row> = Vec::new();
        let mut last = width(&middle);
        for row in rows {
            let now = width(row);
            if now < LEAST_SHARE * widest {
                break;
            }
            if !row.is_free || now > JUMP * last {
                // What is suddenly as wide as that is another thing, on which the body stands; else the body itself goes on outside.
                return if now > JUMP * last || last < THIN_SHARE * widest { Ok(found) } else { Err(Refusal::Border) };
            }
            (widest, last) = (widest.max(now), now);
            found.push(*row);
        }
        Ok(found)
    };
    let mut rows = walk(&mut body.rows[..body.deepest].iter().rev())?;
    rows.reverse();
    rows.push(middle);
    rows.extend(walk(&mut body.rows[body.deepest + 1..].iter())?);
    rows.retain(|row| width(row) > LEAST_SHARE * widest);
    // A flat end that is tilted crosses rows: its outline goes over so many px a row there that it is none of the sides.
    let crosses = |a: &Row, b: &Row| {
        let limit = END_SLOPE * (b.at.abs_diff(a.at)) as f64 + body.step as f64;
        a.span.0.abs_diff(b.span.0) as f64 > limit || a.span.1.abs_diff(b.span.1) as f64 > limit
    };
    let half = rows.len() / 3;
    let before = (0..half).rev().find(|&i| crosses(&rows[i], &rows[i + 1])).map_or(0, |i| i + 2);
    let n = rows.len();
    let behind = (0..half).rev().find(|&i| crosses(&rows[n - 1 - i], &rows[n - 2 - i])).map_or(0, |i| i + 2);
    Ok(rows[before..n - behind].to_vec())
}

/// What the edges of the grid's rows say.
struct First {
    /// Through those edges.
    outlines: Outlines,
    /// The blur that they agree on.
    blur_px: f64,
    /// The edges, row by row.
    edges: [Vec<(f64, f64)>; 2],
}

impl First {
    /// Where an edge is to be expected on a row, and its slope: on the outline, or, where that passes its edges by, between those.
    fn guess(&self, side: usize, y: f64) -> (f64, f64) {
        let outline = &self.outlines[side];
        let (smooth, edges) = ((outline.at(y), outline.derivatives(y).0), &self.edges[side]);
        let i = edges.partition_point(|(row, _)| *row < y);
        let (Some(before), Some(behind)) = (edges.get(i.wrapping_sub(1)), edges.get(i)) else { return smooth };
        let slope = (behind.1 - before.1) / (behind.0 - before.0);
        let between = before.1 + slope * (y - before.0);
        if (between - smooth.0).abs() > PASSES_BLURS * self.blur_px { (between, slope) } else { smooth }
    }
}

/// Outlines through edges of the grid's rows, and the blur that they agree on.
fn first(seeker: &mut Seeker, body: &Body, wide: &[Row]) -> Result<First, Refusal> {
    let few = |found: usize| Refusal::FewEdges { found, of: wide.len() };
    let mut guesses: [Vec<(f64, f64)>; 2] = [vec![], vec![]];
    let mut widths = Vec::new();
    for row in wide {
        for (side, near) in [row.span.0, row.span.1].into_iter().enumerate() {
            if let Some((at, width)) = seeker.crossing(row.at, near, body.step) {
                guesses[side].push((row.at as f64, at));
                widths.push(width);
            }
        }
    }
    let range = wide.first().zip(wide.last()).map(|(a, b)| (a.at as f64, b.at as f64)).ok_or(Refusal::NoBody)?;
    let fit = |points: &[(f64, f64)]| Curve::fit(points, range, DEGREE_FIRST).ok_or_else(|| few(points.len()));
    let mut outlines = [fit(&guesses[0])?, fit(&guesses[1])?];
    widths.retain(|w| w.is_finite());
    // The middle half of a normal distribution is 1.349 deviations wide; a mean of five px has a variance of two px².
    let seen = median(widths) / 1.349;
    let mut blur_px = (seen * seen - 2.0).max(0.0).sqrt().clamp(1.0, BLUR_PX.1);
    for _ in 0..ROUNDS {
        let mut points: [Vec<(f64, f64)>; 2] = [vec![], vec![]];
        let (mut wider, mut weights) = (0.0, 0.0);
        let width = |y: f64| outlines[1].at(y) - outlines[0].at(y);
        let widest = wide.iter().map(|row| width(row.at as f64)).fold(0.0, f64::max);
        for row in wide {
            let y = row.at as f64;
            for (side, outline) in outlines.iter().enumerate() {
                let (slope, _) = outline.derivatives(y);
                let Some(found) = seeker.edge(row.at, outline.at(y), slope, blur_px, STEPS_MAX) else { continue };
                // Along the row it looks wider.
                let seen = slope.mul_add(slope, 1.0).sqrt();
                let step = found.edge.blur_step / seen;
                if step.abs() < blur_px && width(y) > BLUR_SHARE * widest {
                    wider += found.edge.blur_weight * seen * seen * step;
                    weights += found.edge.blur_weight * seen * seen;
                }
                points[side].push((y, found.at));
            }
        }
        outlines = [fit(&points[0])?, fit(&points[1])?];
        let step = if weights > 0.0 { wider / weights } else { 0.0 };
        blur_px = (blur_px + step).clamp(BLUR_PX.0, BLUR_PX.1);
        if step.abs() < SETTLED * blur_px {
            break;
        }
    }
    Ok(First { outlines, blur_px, edges: guesses })
}

/// The edges of every row, one step from the first outlines.
fn every(seeker: &mut Seeker, guessed: &First, wide: &[Row]) -> [Vec<Found>; 2] {
    let Some((first, last)) = wide.first().zip(wide.last()) else { return [vec![], vec![]] };
    let mut found = [vec![], vec![]];
    let width = |y: f64| guessed.outlines[1].at(y) - guessed.outlines[0].at(y);
    let widest = wide.iter().map(|row| width(row.at as f64)).fold(0.0, f64::max);
    for row in first.at..=last.at.min(seeker.rows.count() - 1) {
        let y = row as f64;
        // Beyond what the largest width is told by, some rows are enough for the profile.
        if width(y) < THIN_SHARE * widest && row % PROFILE_STEP != 0 {
            continue;
        }
        for (side, found) in found.iter_mut().enumerate() {
            let (at, slope) = guessed.guess(side, y);
            found.extend(seeker.near(row, at, slope, guessed.blur_px));
        }
    }
    found
}

/// Marks edges that are none, though something is there: a line that is no blurred step, or one of another height than its neighbours'.
fn sound(mut side: Vec<Found>) -> Vec<Found> {
    let freedom = |f: &Found| f.edge.left.1.max(1) as f64;
    let usual = median(some(side.iter().map(|f| f.edge.left.0 / freedom(f))));
    let heights: Vec<(f64, f64)> = side.iter().map(|f| (f.row, f.edge.levels.1 - f.edge.levels.0)).collect();
    let range = side.first().zip(side.last()).map_or((0.0, 0.0), |(a, b)| (a.row, b.row));
    let smooth = Curve::fit(&heights, range, DEGREE_HEIGHT);
    for (f, (row, height)) in side.iter_mut().zip(&heights) {
        let allowed = (ODD_NOISE * usual + QUANTISED).max((ODD_SHARE * height).powi(2));
        let is_step = f.edge.left.0 / freedom(f) <= allowed;
        let is_like = smooth.as_ref().is_none_or(|curve| {
            let expected = curve.at(*row);
            (height - expected).abs() <= (ODD_STDS * curve.left).max(ODD_HEIGHT * expected.abs())
        });
        f.is_sound = is_step && is_like;
    }
    side
}

/// From edges to the largest width.
fn measure(
    rows: &Rows,
    body: &Body,
    found: &[Vec<Found>; 2],
    blur_px: f64,
    clipped: f64,
    straight: &dyn Fn(Place) -> Option<Place>,
) -> Result<Diameter, Refusal> {
    let on_picture = |is_sound: bool| {
        found.each_ref().map(|side| {
            let asked = side.iter().filter(|f| f.is_sound == is_sound);
            asked.filter_map(|f| straight(rows.place(f.row, f.at))).collect::<Vec<Place>>()
        })
    };
    let (places, odd) = (on_picture(true), on_picture(false));
    let looked_for = found[0].len().max(found[1].len());
    let few = || Refusal::FewEdges { found: places[0].len().min(places[1].len()), of: looked_for };
    let axis::Found { frame, wide, gain } = axis(&places, body.axis).ok_or_else(few)?;
    let points = frame.of(&places);
    let mut range = wide;
    let squares: f64 = found.iter().flatten().map(|f| f.edge.left.0).sum();
    let freedom: usize = found.iter().flatten().map(|f| f.edge.left.1).sum();
    let noise = (squares / freedom.max(1) as f64).sqrt();
    let each: Vec<f64> = found.iter().flatten().map(|f| noise * f.edge.std_per_step).collect();
    let expected = median(some(each.into_iter()));
    let rough_of = |curves: &[Curve; 2]| curves[0].left.max(curves[1].left) / expected.max(f64::MIN_POSITIVE);
    let (mut curves, mut degree) = Curve::pair([&points[0], &points[1]], range, DEGREE_MAX).ok_or_else(few)?;
    // An outline with corners is no polynomial: nearer to the widest place it may be.
    for share in NARROWER {
        let rough = rough_of(&curves);
        if rough < ROUGH {
            break;
        }
        let part = part_above(&curves, range, share);
        let Some((closer, of)) = Curve::pair([&points[0], &points[1]], part, DEGREE_MAX) else { break };
        if rough_of(&closer) > LESS_ROUGH * rough {
            continue;
        }
        (curves, degree, range) = (closer, of, part);
    }
    let (curves, degree) = (curves, degree);
    let width = |v: f64| curves[1].at(v) - curves[0].at(v);
    // A cylinder is as wide everywhere.
    let at = if degree == 0 { f64::midpoint(range.0, range.1) } else { largest(&width, range) };
    let is_cut = body.rows.first().is_some_and(|row| is_at_end(row, body))
        || body.rows.last().is_some_and(|row| is_at_end(row, body));
    // Widest at the end of what is seen, and still growing: more lies outside.
    let grows = (width(range.1) - width(range.0)).abs() > 0.01 * width(at);
    let is_end = (at - range.0).min(range.1 - at) < 0.02 * (range.1 - range.0);
    if is_cut && degree > 0 && is_end && grows && ends_at_border(body, frame.place(at, 0.0)) {
        return Err(Refusal::Border);
    }
    let curvature = |curve: &Curve| {
        let (slope, second) = curve.derivatives(at);
        second / (1.0 + slope * slope).powf(1.5)
    };
    // Seen from the body, the left edge is hollow where its second derivative is negative.
    let bulge = if degree > 0 { curvature(&curves[0]) - curvature(&curves[1]) } else { 0.0 };
    let shift_px = 0.5 * blur_px * blur_px * bulge;
    let noise_std = curves[0].std_at(at, &points[0]).hypot(curves[1].std_at(at, &points[1]));
    let std_px = noise_std.hypot(FLOOR_PX).hypot(SHIFT_SHARE * shift_px);
    // Of a straight line through the middles of so many rows.
    let rows_used = 0.5 * (curves[0].n() + curves[1].n()) as f64;
    let middle_std = 0.5 * curves[0].left.hypot(curves[1].left);
    let axis_std_rad = (12.0 / rows_used).sqrt() * middle_std / (range.1 - range.0) / gain.abs().max(f64::EPSILON);
    let level = |of: fn((f64, f64)) -> f64| median(found.iter().flatten().map(|f| of(f.edge.levels)).collect());
    let (low, high) = (level(|(a, b)| a.min(b)), level(|(a, b)| a.max(b)));
    let levels = if body.is_dark { (low, high) } else { (high, low) };
    let rough = rough_of(&curves);
    let in_range = |p: &&(f64, f64)| p.0 >= range.0 && p.0 <= range.1;
    let odd_here = odd.iter().flatten().map(|p| frame.along_of(*p)).filter(|v| *v >= range.0 && *v <= range.1).count();
    let asked: usize = points.iter().flatten().filter(in_range).count() + odd_here;
    let strays = 1.0 - (curves[0].n() + curves[1].n()) as f64 / asked.max(1) as f64;
    let mut flags = Vec::new();
    if body.axis_is_guessed {
        flags.push(Flag::AxisGuessed(body.axis));
    }
    if is_cut && body.rows.iter().any(|row| is_at_end(row, body) && is_thick(row, width(at))) {
        flags.push(Flag::Cut);
    }
    if clipped > 0.01 {
        flags.push(Flag::Clipped(clipped));
    }
    if strays > 0.05 {
        flags.push(Flag::Strays(strays));
    }
    if rough > 2.0 {
        flags.push(Flag::Rough(rough));
    }
    if blur_px > 4.0 {
        flags.push(Flag::Blurred(blur_px));
    }
    let edges = [0, 1].map(|i| {
        let become_of = |((place, (v, _)), used): ((&Place, &(f64, f64)), &bool)| {
            let what = match (used, *v >= range.0 && *v <= range.1) {
                (true, _) => EdgeUse::Used,
                (false, false) => EdgeUse::Beyond,
                (false, true) => EdgeUse::Odd,
            };
            (*place, what)
        };
        let found = places[i].iter().zip(&points[i]).zip(&curves[i].used).map(become_of);
        found.chain(odd[i].iter().map(|place| (*place, EdgeUse::Odd))).collect()
    });
    Ok(Diameter {
        width_px: width(at) + shift_px,
        std_px,
        ends: [frame.place(at, curves[0].at(at)), frame.place(at, curves[1].at(at))],
        axis: frame.along,
        axis_std_rad,
        blur_px,
        levels,
        noise,
        shift_px,
        degree,
        edges,
        profile: profile(&points, at, curves[0].left.hypot(curves[1].left)),
        flags,
    })
}

fn is_at_end(row: &Row, body: &Body) -> bool {
    row.at < body.lines.0 + body.step || row.at + body.step > body.lines.1
}

fn is_thick(row: &Row, width: f64) -> bool {
    (row.span.1 - row.span.0) as f64 > 0.7 * width
}

/// Whether a place on the axis lies at the end of what was looked at.
fn ends_at_border(body: &Body, place: Place) -> bool {
    let row = match body.axis {
        Axis::Vertical => place.y,
        Axis::Horizontal => place.x,
    };
    let (first, last) = (body.lines.0 as f64, body.lines.1 as f64);
    let near = 3.0 * body.step as f64 + 0.03 * (last - first);
    row < first + near || row > last - near
}
