//! One look for every figure: axes, marks, legend, text from the embedded font.
//!
//! A [`Chart`] is plain data; [`Chart::draw`] turns it into a PNG. Marks outside the axes are not drawn outside: lines are cut at
//! the frame, and points become arrows at its edge with their value beside them.

use std::io::Cursor;
use std::ops::Range;
use std::sync::OnceLock;

use image::{ExtendedColorType, ImageEncoder, codecs::png::PngEncoder};
use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};
use plotters::style::{FontStyle, register_font};

use crate::format;

/// Pixels of a figure; pages show it at half this size, so that text is sharp on dense screens.
pub const WIDTH_PX: u32 = 1520;
const HEIGHT_PX: u32 = 860;
/// Height of a row in a figure of rows, and what its title and axis take.
const ROW_PX: u32 = 74;
const AROUND_ROWS_PX: u32 = 220;
/// Figures are drawn this many times larger and averaged down: the plotting library rounds line ends to whole pixels, which
/// makes flat curves wobble.
const OVERSAMPLING: u32 = 2;
/// Width of the line of a movement.
const TRAIL_PX: u32 = 3;
const LEGEND_PX: i32 = px(430);
const TITLE_PX: i32 = px(84);
pub(super) const FONT: &str = "pneuval";

const INK: RGBColor = RGBColor(0x1b, 0x24, 0x30);
const MUTED: RGBColor = RGBColor(0x5b, 0x67, 0x75);
const GRID: RGBColor = RGBColor(0xe6, 0xea, 0xef);
const BAND: RGBColor = RGBColor(0xe3, 0xf1, 0xea);
const BAND_EDGE: RGBColor = RGBColor(0x7f, 0xb5, 0x9a);

/// Colours that colour-blind readers can tell apart (Okabe and Ito, 2008), then darker ones for long lists.
const COLOURS: [RGBColor; 10] = [
    RGBColor(0x00, 0x72, 0xb2),
    RGBColor(0xd5, 0x5e, 0x00),
    RGBColor(0x00, 0x9e, 0x73),
    RGBColor(0xcc, 0x79, 0xa7),
    RGBColor(0xe6, 0x9f, 0x00),
    RGBColor(0x56, 0xb4, 0xe9),
    RGBColor(0x5e, 0x3c, 0x99),
    RGBColor(0x8a, 0x5a, 0x2b),
    RGBColor(0x4d, 0x4d, 0x4d),
    RGBColor(0x7b, 0x8d, 0x1e),
];

/// The look of one form or of the measurement.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Ink {
    /// The measurement: black.
    Measured,
    /// A form, by its place in the list.
    Form(usize),
}

impl Ink {
    fn colour(self) -> RGBColor {
        match self {
            Self::Measured => INK,
            Self::Form(i) => COLOURS[i % COLOURS.len()],
        }
    }
}

/// The shape of a mark, so that colour is never the only difference.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Shape {
    /// Filled disc: measured.
    Disc,
    /// Square.
    Square,
    /// Triangle.
    Triangle,
    /// Diamond.
    Diamond,
    /// Cross.
    Cross,
    /// Small disc: measured, where there are many.
    Dot,
    /// To the right: the value lies beyond.
    Beyond,
}

impl Shape {
    /// The shape of a form, by its place in the list.
    pub fn of_form(i: usize) -> Self {
        [Self::Square, Self::Triangle, Self::Diamond, Self::Cross][i % 4]
    }
}

/// Something drawn inside the axes.
#[derive(Debug, Clone, PartialEq)]
pub enum Layer {
    /// A shaded rectangle: x range, y range.
    Band(Range<f64>, Range<f64>),
    /// A thin reference line.
    Reference(Vec<(f64, f64)>),
    /// A line.
    Line { points: Vec<(f64, f64)>, ink: Ink, dashed: bool },
    /// The line of a movement or of noise, which turns sharply and comes back.
    Trail { points: Vec<(f64, f64)>, ink: Ink },
    /// Marks, each with the text it gets if it lies outside the axes.
    Marks { points: Vec<(f64, f64, String)>, ink: Ink, shape: Shape },
    /// Vertical bars from low to high at an x: intervals of measured values.
    Bars { spans: Vec<(f64, f64, f64)>, ink: Ink },
    /// Words that end at a place.
    Words { at: (f64, f64), text: String, muted: bool },
}

/// A line of the legend.
#[derive(Debug, Clone, PartialEq)]
pub struct Key {
    /// What it stands for.
    pub text: String,
    /// Its look.
    pub ink: Ink,
    /// Its mark.
    pub shape: Option<Shape>,
    /// Its line: solid, dashed or none.
    pub line: Option<bool>,
    /// A shaded band instead.
    pub band: bool,
}

/// A figure as data.
#[derive(Debug, Clone, PartialEq)]
pub struct Chart {
    /// What is shown.
    pub title: String,
    /// Horizontal axis with unit.
    pub x_title: String,
    /// Vertical axis with unit; empty where rows carry names.
    pub y_title: String,
    /// Horizontal range.
    pub x: Range<f64>,
    /// Largest x whose tick gets a number; beyond it stand words, not values. All of them where absent.
    pub x_labelled_to: Option<f64>,
    /// Vertical range.
    pub y: Range<f64>,
    /// Names of rows, from the top, at y = 0.5, 1.5, … from the top of the range; empty for a numeric axis.
    pub rows: Vec<String>,
    /// From back to front.
    pub layers: Vec<Layer>,
    /// From top to bottom.
    pub legend: Vec<Key>,
}

/// A length of the finished figure in drawn pixels.
const fn px(length: i32) -> i32 {
    // OVERSAMPLING is 2.
    length * OVERSAMPLING.cast_signed()
}

/// The same for a stroke.
const fn stroke(width: u32) -> u32 {
    width * OVERSAMPLING
}

type Area<'a> = DrawingArea<BitMapBackend<'a>, Shift>;
type Plot<'a, 'b> = ChartContext<
    'a,
    BitMapBackend<'b>,
    Cartesian2d<plotters::coord::types::RangedCoordf64, plotters::coord::types::RangedCoordf64>,
>;

/// plotters draws text at 1/1.24 of its nominal size.
const FONT_SCALE: f64 = 1.24 * OVERSAMPLING as f64;

/// A font of a size in pixels of the finished figure.
fn font(size_px: f64) -> FontDesc<'static> {
    (FONT, size_px * FONT_SCALE).into_font()
}

fn text(size_px: f64, colour: RGBColor) -> TextStyle<'static> {
    font(size_px).color(&colour)
}

/// Registers the embedded font once; the machine's own fonts are never asked.
pub(super) fn register() -> Result<(), String> {
    static DONE: OnceLock<bool> = OnceLock::new();
    let registered = *DONE.get_or_init(|| {
        let regular = include_bytes!("../../assets/pneuval-sans-regular.otf");
        let semibold = include_bytes!("../../assets/pneuval-sans-semibold.otf");
        register_font(FONT, FontStyle::Normal, regular).is_ok()
            && register_font(FONT, FontStyle::Bold, semibold).is_ok()
    });
    if registered { Ok(()) } else { Err("the embedded font was refused".to_owned()) }
}

impl Chart {
    /// Height of the finished figure in pixels: a figure of rows is as high as its rows need.
    pub fn height_px(&self) -> u32 {
        match u32::try_from(self.rows.len()) {
            Ok(rows) if rows > 0 => (AROUND_ROWS_PX + ROW_PX * rows).min(4 * HEIGHT_PX),
            _ => HEIGHT_PX,
        }
    }

    /// The chart as a PNG file.
    ///
    /// # Errors
    /// What the plotting library or the PNG encoder says.
    pub fn draw(&self) -> Result<Vec<u8>, String> {
        register()?;
        let (width, height) = (WIDTH_PX * OVERSAMPLING, self.height_px() * OVERSAMPLING);
        let mut pixels = vec![0; 3 * width as usize * height as usize];
        {
            let root = BitMapBackend::with_buffer(&mut pixels, (width, height)).into_drawing_area();
            self.draw_on(&root).map_err(|e| e.to_string())?;
            root.present().map_err(|e| e.to_string())?;
        }
        let pixels = averaged(&pixels, width as usize);
        let mut png = Cursor::new(Vec::new());
        PngEncoder::new(&mut png)
            .write_image(&pixels, WIDTH_PX, self.height_px(), ExtendedColorType::Rgb8)
            .map_err(|e| e.to_string())?;
        Ok(png.into_inner())
    }

    fn draw_on(&self, root: &Area) -> Result<(), Box<dyn std::error::Error>> {
        root.fill(&WHITE)?;
        root.draw(&Text::new(
            self.title.clone(),
            (px(40), px(30)),
            (FONT, 30.0 * FONT_SCALE, FontStyle::Bold).into_font().color(&INK),
        ))?;
        let (width, height) = (px(WIDTH_PX.cast_signed()), px(self.height_px().cast_signed()));
        let plot_area = root.clone().shrink((0, TITLE_PX), (width - LEGEND_PX, height - TITLE_PX - px(16)));
        let numeric = self.rows.is_empty();
        let mut plot = ChartBuilder::on(&plot_area)
            .margin_left(px(if numeric { 20 } else { 330 }))
            .margin_right(px(24))
            .margin_top(px(8))
            .x_label_area_size(px(86))
            .y_label_area_size(px(if numeric { 110 } else { 8 }))
            .build_cartesian_2d(drawable(&self.x)?, drawable(&self.y)?)?;
        let number = |value: &f64| format::short(*value);
        let labelled_to = self.x_labelled_to.unwrap_or(f64::INFINITY);
        let x_number = |value: &f64| if *value > labelled_to { String::new() } else { number(value) };
        let mut mesh = plot.configure_mesh();
        mesh.bold_line_style(GRID.stroke_width(stroke(2)))
            .light_line_style(TRANSPARENT)
            .axis_style(MUTED.stroke_width(stroke(2)))
            .set_all_tick_mark_size(px(7))
            .label_style(text(24.0, MUTED))
            .axis_desc_style(text(25.0, INK))
            .x_desc(&self.x_title)
            .x_labels(8)
            .x_label_formatter(&x_number)
            .y_label_formatter(&number);
        if numeric {
            mesh.y_desc(&self.y_title).y_labels(8).draw()?;
        } else {
            mesh.disable_y_mesh().y_labels(0).draw()?;
        }
        for layer in &self.layers {
            self.draw_layer(layer, &mut plot)?;
        }
        self.draw_row_names(root, &plot)?;
        self.draw_legend(root, width - LEGEND_PX + px(10))?;
        Ok(())
    }

    fn draw_layer(&self, layer: &Layer, plot: &mut Plot) -> Result<(), Box<dyn std::error::Error>> {
        match layer {
            Layer::Band(x, y) => {
                let corner = |x: f64, y: f64| (x.clamp(self.x.start, self.x.end), y.clamp(self.y.start, self.y.end));
                let (a, b) = (corner(x.start, y.start), corner(x.end, y.end));
                plot.draw_series([Rectangle::new([a, b], BAND.filled())])?;
                // Only the edges that lie inside the axes are drawn; the frame is no bound.
                if self.rows.is_empty() {
                    for level in [y.start, y.end].into_iter().filter(|level| self.y.contains(level)) {
                        let edge = [(a.0, level), (b.0, level)];
                        plot.draw_series([PathElement::new(edge, BAND_EDGE.stroke_width(stroke(2)))])?;
                    }
                } else {
                    for level in [x.start, x.end].into_iter().filter(|level| self.x.contains(level)) {
                        let edge = [(level, a.1), (level, b.1)];
                        plot.draw_series([PathElement::new(edge, BAND_EDGE.stroke_width(stroke(2)))])?;
                    }
                }
            }
            Layer::Reference(points) => {
                for piece in self.clipped(points) {
                    plot.draw_series([PathElement::new(piece, MUTED.stroke_width(stroke(2)))])?;
                }
            }
            Layer::Line { points, ink, dashed } => {
                for piece in self.clipped(points) {
                    let style = ink.colour().stroke_width(stroke(4));
                    if *dashed {
                        plot.draw_series(DashedLineSeries::new(piece, stroke(14), stroke(9), style))?;
                    } else {
                        plot.draw_series([PathElement::new(piece, style)])?;
                    }
                }
            }
            Layer::Trail { points, ink } => {
                for piece in self.clipped(points) {
                    // The plotting library joins the sides of a line where they meet, which is far away at a sharp turn: each step is a
                    // line of its own, and a disc joins two.
                    let style = ink.colour().stroke_width(stroke(TRAIL_PX));
                    plot.draw_series(piece.windows(2).map(|step| PathElement::new(step.to_vec(), style)))?;
                    let radius = stroke(TRAIL_PX) / 2;
                    plot.draw_series(piece.iter().map(|at| Circle::new(*at, radius, ink.colour().filled())))?;
                }
            }
            Layer::Marks { points, ink, shape } => {
                for (x, y, label) in points {
                    self.draw_mark((*x, *y), label, *ink, *shape, plot)?;
                }
            }
            Layer::Bars { spans, ink } => {
                for (x, low, high) in spans {
                    for piece in self.clipped(&[(*x, *low), (*x, *high)]) {
                        plot.draw_series([PathElement::new(piece, ink.colour().stroke_width(stroke(3)))])?;
                    }
                }
            }
            Layer::Words { at, text: words, muted } => {
                let style = text(22.0, if *muted { MUTED } else { INK }).pos(Pos::new(HPos::Right, VPos::Center));
                plot.draw_series([Text::new(words.clone(), *at, style)])?;
            }
        }
        Ok(())
    }

    fn draw_mark(
        &self,
        (x, y): (f64, f64),
        label: &str,
        ink: Ink,
        shape: Shape,
        plot: &Plot,
    ) -> Result<(), Box<dyn std::error::Error>> {
        let inside = (x.clamp(self.x.start, self.x.end), y.clamp(self.y.start, self.y.end));
        let (column, row) = plot.backend_coord(&inside);
        let area = plot.plotting_area().strip_coord_spec();
        let (ox, oy) = area.get_base_pixel();
        let at = (column - ox, row - oy);
        let outside = (x - inside.0, y - inside.1);
        if outside == (0.0, 0.0) {
            return draw_shape(&area, at, ink, Some(shape));
        }
        // An arrow at the edge, pointing to where the point lies, and its value beside it.
        let (dx, dy) = (sign(outside.0), -sign(outside.1));
        let tip = (at.0 - dx * px(2), at.1 - dy * px(2));
        let corner = |side: i32| {
            if dy == 0 {
                (tip.0 - dx * px(20), tip.1 + side * px(11))
            } else {
                (tip.0 + side * px(11), tip.1 - dy * px(20))
            }
        };
        area.draw(&Polygon::new([tip, corner(-1), corner(1)], ink.colour().filled()))?;
        let (place, anchor) = if dy == 0 {
            ((tip.0 - dx * px(28), tip.1), Pos::new(if dx > 0 { HPos::Right } else { HPos::Left }, VPos::Center))
        } else {
            ((tip.0 + px(18), tip.1 - dy * px(12)), Pos::new(HPos::Left, VPos::Center))
        };
        area.draw(&Text::new(label.to_owned(), place, text(22.0, ink.colour()).pos(anchor)))?;
        Ok(())
    }

    fn draw_row_names(&self, root: &Area, plot: &Plot) -> Result<(), Box<dyn std::error::Error>> {
        for (i, name) in self.rows.iter().enumerate() {
            let (x, y) = plot.backend_coord(&(self.x.start, self.y.end - 0.5 - i as f64));
            let lines = wrapped(name, 25);
            let top = y - px(13) * (i32::try_from(lines.len())? - 1);
            for (line, words) in (0..).zip(lines) {
                let style = text(22.0, INK).pos(Pos::new(HPos::Right, VPos::Center));
                root.draw(&Text::new(words, (x - px(18), top + line * px(26)), style))?;
            }
        }
        Ok(())
    }

    fn draw_legend(&self, root: &Area, left: i32) -> Result<(), Box<dyn std::error::Error>> {
        const LINE: i32 = px(32);
        let mut y = TITLE_PX + px(30);
        for key in &self.legend {
            let swatch = [(left, y), (left + px(52), y)];
            if key.band {
                root.draw(&Rectangle::new([(left, y - px(13)), (left + px(52), y + px(13))], BAND.filled()))?;
                root.draw(&Rectangle::new(
                    [(left, y - px(13)), (left + px(52), y + px(13))],
                    BAND_EDGE.stroke_width(stroke(2)),
                ))?;
            } else {
                match key.line {
                    Some(false) => root.draw(&PathElement::new(swatch, key.ink.colour().stroke_width(stroke(4))))?,
                    Some(true) => {
                        for start in [left, left + px(21), left + px(42)] {
                            let dash = [(start, y), (start + px(11), y)];
                            root.draw(&PathElement::new(dash, key.ink.colour().stroke_width(stroke(4))))?;
                        }
                    }
                    None => {}
                }
                draw_shape(root, (left + px(26), y), key.ink, key.shape)?;
            }
            for line in wrapped(&key.text, 27) {
                let style = text(23.0, INK).pos(Pos::new(HPos::Left, VPos::Center));
                root.draw(&Text::new(line, (left + px(70), y), style))?;
                y += LINE;
            }
            y += px(14);
        }
        Ok(())
    }

    /// The pieces of a line that lie inside the axes, cut at the frame.
    fn clipped(&self, points: &[(f64, f64)]) -> Vec<Vec<(f64, f64)>> {
        let mut pieces: Vec<Vec<(f64, f64)>> = Vec::new();
        for pair in points.windows(2) {
            let Some((a, b)) = clip(pair[0], pair[1], &self.x, &self.y) else { continue };
            match pieces.last_mut() {
                Some(piece) if piece.last() == Some(&a) => piece.push(b),
                _ => pieces.push(vec![a, b]),
            }
        }
        pieces
    }
}

/// A range the plotting library can divide into ticks: it loops for ever over an empty one.
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

fn sign(x: f64) -> i32 {
    if x > 0.0 {
        1
    } else if x < 0.0 {
        -1
    } else {
        0
    }
}

fn draw_shape(
    area: &Area,
    (x, y): (i32, i32),
    ink: Ink,
    shape: Option<Shape>,
) -> Result<(), Box<dyn std::error::Error>> {
    let fill = ink.colour().filled();
    // A white rim keeps marks apart where they overlap.
    let rim = WHITE.stroke_width(stroke(2));
    let polygon = |corners: Vec<(i32, i32)>| -> Result<(), Box<dyn std::error::Error>> {
        let moved: Vec<(i32, i32)> = corners.into_iter().map(|(dx, dy)| (x + px(dx), y + px(dy))).collect();
        area.draw(&Polygon::new(moved.clone(), fill))?;
        let closed: Vec<(i32, i32)> = moved.iter().copied().chain(moved.first().copied()).collect();
        area.draw(&PathElement::new(closed, rim))?;
        Ok(())
    };
    match shape {
        None => {}
        Some(Shape::Disc) => {
            area.draw(&Circle::new((x, y), px(12), WHITE.filled()))?;
            area.draw(&Circle::new((x, y), px(10), fill))?;
        }
        Some(Shape::Dot) => area.draw(&Circle::new((x, y), px(4), fill))?,
        Some(Shape::Beyond) => polygon(vec![(-9, -11), (11, 0), (-9, 11)])?,
        Some(Shape::Square) => polygon(vec![(-10, -10), (10, -10), (10, 10), (-10, 10)])?,
        Some(Shape::Triangle) => polygon(vec![(0, -13), (12, 9), (-12, 9)])?,
        Some(Shape::Diamond) => polygon(vec![(0, -14), (12, 0), (0, 14), (-12, 0)])?,
        Some(Shape::Cross) => {
            for (dx, dy) in [(px(10), px(10)), (px(10), px(-10))] {
                let arm = [(x - dx, y - dy), (x + dx, y + dy)];
                area.draw(&PathElement::new(arm, WHITE.stroke_width(stroke(9))))?;
                area.draw(&PathElement::new(arm, ink.colour().stroke_width(stroke(5))))?;
            }
        }
    }
    Ok(())
}

/// Every pixel of the finished figure as the mean of the two by two it was drawn with.
fn averaged(pixels: &[u8], width: usize) -> Vec<u8> {
    const { assert!(OVERSAMPLING == 2, "pixels are averaged two by two") };
    let row = 3 * width;
    let mut out = Vec::with_capacity(pixels.len() / 4);
    for rows in pixels.chunks_exact(2 * row) {
        let (top, bottom) = rows.split_at(row);
        for (a, b) in top.chunks_exact(6).zip(bottom.chunks_exact(6)) {
            for channel in 0..3 {
                let sum = u16::from(a[channel])
                    + u16::from(a[channel + 3])
                    + u16::from(b[channel])
                    + u16::from(b[channel + 3]);
                out.push(((sum + 2) / 4).to_le_bytes()[0]);
            }
        }
    }
    out
}

/// The part of a segment inside a rectangle (Liang and Barsky, 1984).
fn clip(a: (f64, f64), b: (f64, f64), x: &Range<f64>, y: &Range<f64>) -> Option<((f64, f64), (f64, f64))> {
    let (dx, dy) = (b.0 - a.0, b.1 - a.1);
    let (mut enter, mut leave) = (0.0_f64, 1.0_f64);
    for (step, room) in [(-dx, a.0 - x.start), (dx, x.end - a.0), (-dy, a.1 - y.start), (dy, y.end - a.1)] {
        if step == 0.0 {
            if room < 0.0 {
                return None;
            }
        } else if step < 0.0 {
            enter = enter.max(room / step);
        } else {
            leave = leave.min(room / step);
        }
    }
    let at = |s: f64| (a.0 + s * dx, a.1 + s * dy);
    // The ends are kept to the bit, so that neighbouring segments join.
    let start = if enter > 0.0 { at(enter) } else { a };
    let end = if leave < 1.0 { at(leave) } else { b };
    (enter <= leave).then_some((start, end))
}

/// Words in lines of at most so many characters.
fn wrapped(text: &str, width: usize) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for word in text.split_whitespace() {
        match lines.last_mut() {
            Some(line) if line.chars().count() + 1 + word.chars().count() <= width => {
                line.push(' ');
                line.push_str(word);
            }
            _ => lines.push(word.to_owned()),
        }
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn segments_are_cut_at_the_frame() {
        let (x, y) = (0.0..10.0, 0.0..10.0);
        assert_eq!(clip((-5.0, 5.0), (5.0, 5.0), &x, &y), Some(((0.0, 5.0), (5.0, 5.0))));
        assert_eq!(clip((1.0, 1.0), (2.0, 2.0), &x, &y), Some(((1.0, 1.0), (2.0, 2.0))));
        assert_eq!(clip((5.0, 5.0), (5.0, 25.0), &x, &y), Some(((5.0, 5.0), (5.0, 10.0))));
        assert_eq!(clip((-1.0, -1.0), (-2.0, 5.0), &x, &y), None);
    }

    #[test]
    fn long_names_are_wrapped_between_words() {
        assert_eq!(wrapped("consistent, fitted to the FEA", 20), ["consistent, fitted", "to the FEA"]);
        assert_eq!(wrapped("", 20), Vec::<String>::new());
    }
}
