//! From a chart to places in px.

use plotters::coord::ranged1d::Ranged;
use plotters::coord::types::RangedCoordf64;
use std::ops::Range;

use super::clip::{pieces, thinned};
use super::{Chart, Ground, HEIGHT_PX, Ink, LINE_PX, Layer, TRAIL_PX, WIDTH_PX, head};
use crate::format;
use crate::report::scene::{Anchor, Element, Px, Readout, Scene, Shape, TEXT_PX, Tint, Words};

/// Room for the numbers of the vertical axis, and beyond the ends of the axes.
const LEFT_PX: f64 = 62.0;
const RIGHT_PX: f64 = 18.0;
const TOP_PX: f64 = 30.0;
const BOTTOM_PX: f64 = 50.0;
/// Under a panel that leaves its axis to the one below.
const BETWEEN_PX: f64 = 12.0;

pub(super) const ASPECT: f64 = (WIDTH_PX - LEFT_PX - RIGHT_PX) / (HEIGHT_PX - TOP_PX - BOTTOM_PX);

/// Height of a row, and of its line of text.
const ROW_PX: f64 = 46.0;
const ROW_TEXT_PX: f64 = 20.0;
/// Width of a letter, on average.
const LETTER_PX: f64 = 6.6;
pub(super) const ROW_TEXT_SHARE: f64 = (ROW_TEXT_PX + 1.0) / ROW_PX;

/// Numbers on an axis, about.
const TICKS: usize = 7;

/// The plot of a chart: where its axes are.
struct Frame<'a> {
    chart: &'a Chart,
    x: Range<f64>,
    y: Range<f64>,
    /// Left, top, right, bottom in px.
    left: f64,
    top: f64,
    right: f64,
    bottom: f64,
}

impl Chart {
    /// The chart without title and legend.
    ///
    /// # Errors
    /// An axis that cannot be divided.
    pub fn scene(&self) -> Result<Scene, String> {
        let is_numeric = self.rows.is_empty();
        let has_x = !self.x_title.is_empty();
        let below = if has_x { BOTTOM_PX } else { BETWEEN_PX };
        let height = if is_numeric { self.height_px } else { ROW_PX * self.rows.len() as f64 + below + 6.0 };
        let mut scene = Scene::new((WIDTH_PX, height));
        let frame = Frame {
            chart: self,
            x: drawable(&self.x)?,
            y: drawable(&self.y)?,
            left: if is_numeric { LEFT_PX } else { 10.0 },
            top: if is_numeric { TOP_PX } else { 6.0 },
            right: WIDTH_PX - RIGHT_PX,
            bottom: height - below,
        };
        frame.axes(&mut scene);
        for layer in &self.layers {
            frame.layer(layer, &mut scene);
        }
        frame.row_names(&mut scene);
        frame.readouts(&mut scene);
        Ok(scene)
    }
}

impl Frame<'_> {
    fn at(&self, p: (f64, f64)) -> Px {
        let along = |v: f64, range: &Range<f64>| (v - range.start) / (range.end - range.start);
        (
            self.left + along(p.0, &self.x) * (self.right - self.left),
            self.bottom - along(p.1, &self.y) * (self.bottom - self.top),
        )
    }

    fn line(&self, points: &[(f64, f64)], tint: Tint, width: f64, is_dashed: bool, scene: &mut Scene) {
        for piece in pieces(points, &self.x, &self.y) {
            let placed: Vec<Px> = piece.into_iter().map(|p| self.at(p)).collect();
            scene.elements.push(Element::Line { points: thinned(&placed), tint, width, is_dashed });
        }
    }

    fn axes(&self, scene: &mut Scene) {
        let (left, right, top, bottom) = (self.left, self.right, self.top, self.bottom);
        let is_numeric = self.chart.rows.is_empty();
        let has_x = !self.chart.x_title.is_empty();
        let few = if self.chart.height_px < 300.0 { 4 } else { TICKS };
        let (across, up) = (ticks(&self.x, TICKS), if is_numeric { ticks(&self.y, few) } else { vec![] });
        let mut grid: Vec<[Px; 2]> =
            across.iter().map(|v| self.at((*v, self.y.start)).0).map(|x| [(x, top), (x, bottom)]).collect();
        grid.extend(up.iter().map(|v| self.at((self.x.start, *v)).1).map(|y| [(left, y), (right, y)]));
        scene.elements.push(Element::Segments { ends: grid, tint: Tint::Grid, width: 1.0 });
        let corners = if is_numeric {
            vec![(left, top), (left, bottom), (right, bottom)]
        } else {
            vec![(left, bottom), (right, bottom)]
        };
        scene.line(corners, Tint::Muted, 1.0);
        if has_x {
            for (i, v) in across.iter().enumerate() {
                let x = self.at((*v, self.y.start)).0;
                scene.elements.push(Element::Words(Words {
                    at: (x, bottom + 14.0),
                    text: format::short(*v),
                    anchor: Anchor::Middle,
                    tint: Tint::Muted,
                    size: TEXT_PX,
                    is_bold: false,
                    // Every other one is left out on a narrow page.
                    is_spare: i % 2 == 1,
                }));
            }
            scene.words((right, bottom + 36.0), self.chart.x_title.clone(), Anchor::End, Tint::Ink);
        }
        for v in up {
            let y = self.at((self.x.start, v)).1;
            scene.words((left - 7.0, y), tick(v), Anchor::End, Tint::Muted);
        }
        if is_numeric {
            scene.words((4.0, 13.0), self.chart.y_title.clone(), Anchor::Start, Tint::Ink);
        }
    }

    fn layer(&self, layer: &Layer, scene: &mut Scene) {
        match layer {
            Layer::Band { x, y, ground } => self.band(x, y, *ground, scene),
            Layer::Reference(points) => self.line(points, Tint::Muted, 1.0, false, scene),
            Layer::Line { points, ink, is_dashed } => self.line(points, ink.tint(), LINE_PX, *is_dashed, scene),
            Layer::Trail { points, ink } => self.line(points, ink.tint(), TRAIL_PX, false, scene),
            Layer::Marks { points, ink, shape } => self.marks(points, *ink, *shape, scene),
            Layer::Bars { spans, ink } => {
                let ends = spans.iter().filter_map(|(x, low, high)| self.cut([(*x, *low), (*x, *high)]));
                let ends = ends.collect();
                scene.elements.push(Element::Segments { ends, tint: ink.tint(), width: TRAIL_PX });
            }
            Layer::Spans { spans, ink } => {
                let ends = spans.iter().filter_map(|(y, low, high)| self.cut([(*low, *y), (*high, *y)]));
                let ends = ends.collect();
                scene.elements.push(Element::Segments { ends, tint: ink.tint(), width: TRAIL_PX });
            }
            Layer::Vectors { ends, ink } => {
                let inside = |p: &(f64, f64)| self.x.contains(&p.0) && self.y.contains(&p.1);
                let shown: Vec<[Px; 2]> = ends
                    .iter()
                    .filter(|[a, b]| inside(a) && inside(b))
                    .map(|[a, b]| [self.at(*a), self.at(*b)])
                    .collect();
                for [from, tip] in &shown {
                    // A head as long as its line is no arrow.
                    if (tip.0 - from.0).hypot(tip.1 - from.1) > 7.0 {
                        scene.elements.push(Element::Area { corners: head(*from, *tip, 5.0), tint: ink.tint() });
                    }
                }
                scene.elements.push(Element::Segments { ends: shown, tint: ink.tint(), width: 1.2 });
            }
        }
    }

    /// A segment cut at the frame, in px.
    fn cut(&self, ends: [(f64, f64); 2]) -> Option<[Px; 2]> {
        let piece = pieces(&ends, &self.x, &self.y).pop()?;
        let [a, b] = piece.as_slice() else { return None };
        Some([self.at(*a), self.at(*b)])
    }

    fn band(&self, x: &Range<f64>, y: &Range<f64>, ground: Ground, scene: &mut Scene) {
        let within = |v: f64, range: &Range<f64>| v.clamp(range.start, range.end);
        let a = self.at((within(x.start, &self.x), within(y.end, &self.y)));
        let b = self.at((within(x.end, &self.x), within(y.start, &self.y)));
        let (fill, edge) = ground.tints();
        // What lasts an instant is still seen.
        let size = ((b.0 - a.0).max(if ground == Ground::Flag { 2.0 } else { 0.0 }), b.1 - a.1);
        scene.elements.push(Element::Rect { at: a, size, tint: fill });
        // Only the edges that lie inside the axes are drawn; the frame is no bound.
        let mut ends: Vec<[Px; 2]> = Vec::new();
        if self.chart.rows.is_empty() && ground == Ground::Bound {
            let levels = [y.start, y.end].into_iter().filter(|level| self.y.contains(level));
            ends.extend(levels.map(|level| self.at((self.x.start, level)).1).map(|y| [(a.0, y), (b.0, y)]));
        } else {
            let places = [x.start, x.end].into_iter().filter(|place| self.x.contains(place));
            ends.extend(places.map(|place| self.at((place, self.y.start)).0).map(|x| [(x, a.1), (x, b.1)]));
        }
        scene.elements.push(Element::Segments { ends, tint: edge, width: 1.0 });
    }

    fn marks(&self, points: &[(f64, f64, String)], ink: Ink, shape: Shape, scene: &mut Scene) {
        let mut inside = Vec::new();
        for (x, y, label) in points {
            let within = (x.clamp(self.x.start, self.x.end), y.clamp(self.y.start, self.y.end));
            let at = self.at(within);
            let (dx, dy) = (sign(x - within.0), -sign(y - within.1));
            if dx == 0.0 && dy == 0.0 {
                inside.push(at);
                continue;
            }
            // An arrow at the edge, pointing to where the point lies, and its value beside it.
            let tip = (at.0 - dx, at.1 - dy);
            let (from, place, anchor) = if dy == 0.0 {
                let anchor = if dx > 0.0 { Anchor::End } else { Anchor::Start };
                ((tip.0 - 10.0 * dx, tip.1), (tip.0 - 14.0 * dx, tip.1), anchor)
            } else if at.0 > self.right - 60.0 {
                ((tip.0, tip.1 - 10.0 * dy), (tip.0 - 9.0, tip.1 - 6.0 * dy), Anchor::End)
            } else {
                ((tip.0, tip.1 - 10.0 * dy), (tip.0 + 9.0, tip.1 - 6.0 * dy), Anchor::Start)
            };
            scene.elements.push(Element::Area { corners: head(from, tip, 10.0), tint: ink.tint() });
            // Of numbers that would lie on one another the first stands for all; every one can be read at its place.
            if is_free(scene, place, anchor, label) {
                // In the colour of text: some of the inks are too pale for letters.
                scene.words(place, label.clone(), anchor, Tint::Ink);
            }
        }
        if !inside.is_empty() {
            scene.elements.push(Element::Marks { at: inside, tint: ink.tint(), shape });
        }
    }

    /// The name of a row stands at its upper left, its number at the right.
    fn row_names(&self, scene: &mut Scene) {
        for (i, row) in self.chart.rows.iter().enumerate() {
            let y = self.top + ROW_PX * i as f64 + 0.5 * ROW_TEXT_PX;
            let tint = if row.is_muted { Tint::Muted } else { Tint::Ink };
            scene.words((self.left, y), row.name.clone(), Anchor::Start, Tint::Ink);
            scene.words((self.right, y), row.value.clone(), Anchor::End, tint);
            // The name alone has room on a narrow page; the number stands in the text and the tables.
            if let Some(Element::Words(words)) = scene.elements.last_mut() {
                words.is_spare = true;
            }
        }
    }

    fn readouts(&self, scene: &mut Scene) {
        let all = &self.chart.readings;
        let x_of = |i: usize| all.get(i).map(|r: &super::Reading| self.at(r.at).0);
        for (i, reading) in all.iter().enumerate() {
            let at = self.at(reading.at);
            let field = if reading.is_column {
                // To the middle between neighbours.
                let before = i.checked_sub(1).and_then(x_of).map_or(self.left, |x| 0.5 * (x + at.0));
                let after = x_of(i + 1).map_or(self.right, |x| 0.5 * (x + at.0));
                let (from, to) = ((at.0 - 40.0).max(before), (at.0 + 40.0).min(after));
                ((from, self.top), ((to - from).max(1.0), self.bottom - self.top))
            } else {
                ((at.0 - 9.0, at.1 - 9.0), (18.0, 18.0))
            };
            scene.readouts.push(Readout { at, field, is_column: reading.is_column, lines: reading.lines.clone() });
        }
    }
}

/// Whether a text would lie on no other.
fn is_free(scene: &Scene, at: Px, anchor: Anchor, text: &str) -> bool {
    let span = |at: Px, anchor: Anchor, text: &str| {
        let width = LETTER_PX * text.chars().count() as f64;
        let left = match anchor {
            Anchor::Start => at.0,
            Anchor::Middle => at.0 - 0.5 * width,
            Anchor::End => at.0 - width,
        };
        (left, left + width)
    };
    let (left, right) = span(at, anchor, text);
    scene.elements.iter().all(|element| {
        let Element::Words(words) = element else { return true };
        let (from, to) = span(words.at, words.anchor, &words.text);
        (words.at.1 - at.1).abs() > 12.0 || to < left || right < from
    })
}

/// A range that can be divided into ticks: the plotting library loops for ever over an empty one.
fn drawable(range: &Range<f64>) -> Result<Range<f64>, String> {
    let (start, end) = (range.start, range.end);
    if start.is_finite()
        && end.is_finite()
        && end - start > 1e-12 * start.abs().max(end.abs())
        && (end - start).is_finite()
    {
        Ok(start..end)
    } else {
        Err(format!("an axis from {start} to {end} cannot be drawn"))
    }
}

/// Round numbers along a range.
fn ticks(range: &Range<f64>, about: usize) -> Vec<f64> {
    let size = range.end - range.start;
    let all = RangedCoordf64::from(range.clone()).key_points(about);
    // A sum of steps misses zero by a rounding error, which would be printed.
    all.into_iter().map(|v| if v.abs() < 1e-9 * size { 0.0 } else { v }).collect()
}

/// A number beside an axis: with an exponent where its digits have no room.
fn tick(v: f64) -> String {
    let plain = format::short(v);
    if plain.chars().count() <= 8 { plain } else { format!("{v:.2e}").replace('-', "\u{2212}") }
}

fn sign(x: f64) -> f64 {
    if x == 0.0 { 0.0 } else { x.signum() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::chart::{Reading, Row};

    fn chart() -> Chart {
        Chart {
            x_title: "Gauge pressure / kPa".into(),
            y_title: "Angle / °".into(),
            x: 0.0..10.0,
            y: 0.0..1.0,
            ..Chart::default()
        }
    }

    #[test]
    fn an_axis_that_cannot_be_divided_is_an_error() {
        for x in [1.0..1.0, 0.0..f64::NAN, f64::NEG_INFINITY..0.0, 1e17..1e17 + 16.0] {
            assert!(Chart { x, ..chart() }.scene().is_err());
        }
    }

    #[test]
    fn what_lies_beyond_the_axes_is_an_arrow_with_its_value() {
        let points = vec![(5.0, 0.5, "0.5".to_owned()), (5.0, 7.0, "7".to_owned())];
        let layers = vec![Layer::Marks { points, ink: Ink::Form(0), shape: Shape::Square }];
        let scene = Chart { layers, ..chart() }.scene().unwrap();
        let is_arrow = |e: &&Element| matches!(e, Element::Area { .. });
        let tip = scene.elements.iter().find(is_arrow).unwrap();
        let Element::Area { corners, .. } = tip else { unreachable!() };
        assert!(corners.iter().all(|p| p.1 >= TOP_PX && p.1 < TOP_PX + 15.0), "{corners:?}");
        let says = |text: &str| scene.elements.iter().any(|e| matches!(e, Element::Words(w) if w.text == text));
        assert!(says("7") && !says("0.5 mm"));
        let marks =
            scene.elements.iter().filter_map(|e| if let Element::Marks { at, .. } = e { Some(at.len()) } else { None });
        assert_eq!(marks.sum::<usize>(), 1);
    }

    #[test]
    fn every_place_of_a_plot_belongs_to_the_nearest_reading() {
        let reading = |x: f64| Reading { at: (x, 0.0), is_column: true, lines: vec![x.to_string()] };
        let scene = Chart { readings: [1.0, 1.5, 9.0].map(reading).to_vec(), ..chart() }.scene().unwrap();
        let ends: Vec<(f64, f64)> = scene.readouts.iter().map(|r| (r.field.0.0, r.field.0.0 + r.field.1.0)).collect();
        assert!(ends.windows(2).all(|e| e[0].1 <= e[1].0 + 1e-9), "{ends:?}");
        assert!(scene.readouts.iter().zip(&ends).all(|(r, e)| e.0 < r.at.0 && r.at.0 < e.1));
    }

    #[test]
    fn a_figure_of_rows_is_as_high_as_its_rows() {
        let row = Row { name: "a".into(), value: "1".into(), is_muted: false };
        let high = |n: usize| Chart { rows: vec![row.clone(); n], ..chart() }.scene().unwrap().size.1;
        assert!((high(7) - high(3) - 4.0 * ROW_PX).abs() < 1e-9);
    }
}
