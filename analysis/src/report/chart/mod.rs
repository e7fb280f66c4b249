//! One look for every figure: axes, marks, legend.
//!
//! A [`Chart`] is plain data. [`Chart::scene`] lays it out without its title and legend, which a page sets as text beside it;
//! [`file`] lays out charts, title and legend as one drawing for a file. Marks outside the axes are not drawn outside: lines are cut at
//! the frame, and points become arrows at its edge with their value beside them.

mod clip;
mod layout;

use std::ops::Range;

use super::scene::{Anchor, Element, Px, Scene, Shape, Tint, Words, swatch};

/// Width of a plot on a page, in px.
pub const WIDTH_PX: f64 = 600.0;

/// Height of a plot with two axes, in px.
pub const HEIGHT_PX: f64 = 400.0;

/// A plot with two axes, width over height of what lies between them.
pub const ASPECT: f64 = layout::ASPECT;

/// Of a file: the column of the legend, and the height of the title.
const LEGEND_PX: f64 = 232.0;
const TITLE_PX: f64 = 42.0;
const MARGIN_PX: f64 = 14.0;

/// Widths of lines, in px.
const LINE_PX: f64 = 2.0;
const TRAIL_PX: f64 = 1.5;

/// The look of one form or of the measurement.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Ink {
    /// The measurement: black.
    Measured,
    /// A form, by its place in the list.
    Form(usize),
}

impl Ink {
    fn tint(self) -> Tint {
        match self {
            Self::Measured => Tint::Ink,
            Self::Form(i) => Tint::Form(i),
        }
    }
}

/// What a shaded band means.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Ground {
    /// Within a bound.
    Bound,
    /// A finding is about it.
    Flag,
    /// Material of a cross-section.
    Solid,
}

/// Something drawn inside the axes.
#[derive(Debug, Clone, PartialEq)]
pub enum Layer {
    /// A shaded rectangle: x range, y range.
    Band { x: Range<f64>, y: Range<f64>, ground: Ground },
    /// A thin reference line.
    Reference(Vec<(f64, f64)>),
    /// A line.
    Line { points: Vec<(f64, f64)>, ink: Ink, is_dashed: bool },
    /// The thinner line of a movement, of noise, of a loop.
    Trail { points: Vec<(f64, f64)>, ink: Ink },
    /// Marks, each with the text it gets if it lies outside the axes.
    Marks { points: Vec<(f64, f64, String)>, ink: Ink, shape: Shape },
    /// Vertical bars from low to high at an x: intervals.
    Bars { spans: Vec<(f64, f64, f64)>, ink: Ink },
    /// Horizontal bars from low to high at a y: intervals.
    Spans { spans: Vec<(f64, f64, f64)>, ink: Ink },
    /// From a measured place to the predicted one.
    Vectors { ends: Vec<[(f64, f64); 2]>, ink: Ink },
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
    pub band: Option<Ground>,
}

impl Key {
    /// Of a mark.
    pub fn mark(text: impl Into<String>, ink: Ink, shape: Shape) -> Self {
        Self { text: text.into(), ink, shape: Some(shape), line: None, band: None }
    }

    /// Of a solid line.
    pub fn line(text: impl Into<String>, ink: Ink) -> Self {
        Self { text: text.into(), ink, shape: None, line: Some(false), band: None }
    }

    /// Of a band.
    pub fn band(text: impl Into<String>, ground: Ground) -> Self {
        Self { text: text.into(), ink: Ink::Measured, shape: None, line: None, band: Some(ground) }
    }

    /// Of material.
    pub fn solid(text: impl Into<String>) -> Self {
        Self::band(text, Ground::Solid)
    }

    /// Of an outline that is not known.
    pub fn dashed(text: impl Into<String>) -> Self {
        Self { text: text.into(), ink: Ink::Measured, shape: None, line: Some(true), band: None }
    }

    /// Its swatch, 30 px wide and 18 high.
    fn elements(&self) -> Vec<Element> {
        let mut elements = Vec::new();
        if let Some(ground) = self.band {
            let (fill, edge) = ground.tints();
            elements.push(Element::Rect { at: (1.0, 2.0), size: (28.0, 14.0), tint: fill });
            let corners = vec![(1.0, 2.0), (29.0, 2.0), (29.0, 16.0), (1.0, 16.0), (1.0, 2.0)];
            elements.push(Element::Line { points: corners, tint: edge, width: 1.0, is_dashed: false });
            return elements;
        }
        if let Some(is_dashed) = self.line {
            let points = vec![(1.0, 9.0), (29.0, 9.0)];
            elements.push(Element::Line { points, tint: self.ink.tint(), width: LINE_PX, is_dashed });
        }
        let at = vec![(15.0, 9.0)];
        elements.extend(self.shape.map(|shape| Element::Marks { at, tint: self.ink.tint(), shape }));
        elements
    }

    /// Its swatch as an `svg` element.
    pub fn swatch(&self) -> String {
        swatch(&self.elements())
    }
}

impl Ground {
    fn tints(self) -> (Tint, Tint) {
        match self {
            Self::Bound => (Tint::Bound, Tint::BoundEdge),
            Self::Flag => (Tint::Flag, Tint::FlagEdge),
            Self::Solid => (Tint::Solid, Tint::Ink),
        }
    }
}

/// A row of a chart of rows: a name, and a number.
#[derive(Debug, Clone, PartialEq)]
pub struct Row {
    /// What it is.
    pub name: String,
    /// Its number as text.
    pub value: String,
    /// There is no number.
    pub is_muted: bool,
}

/// What can be read off at a place.
#[derive(Debug, Clone, PartialEq)]
pub struct Reading {
    /// The place, in the units of the axes.
    pub at: (f64, f64),
    /// Everything at this x is read together.
    pub is_column: bool,
    /// What it says, a line each.
    pub lines: Vec<String>,
}

/// A figure, or one of several panels of a figure, as data.
#[derive(Debug, Clone, PartialEq)]
pub struct Chart {
    /// What is shown.
    pub title: String,
    /// Horizontal axis with unit; empty in a panel above another.
    pub x_title: String,
    /// Vertical axis with unit; empty where rows carry names.
    pub y_title: String,
    /// Horizontal range.
    pub x: Range<f64>,
    /// Vertical range.
    pub y: Range<f64>,
    /// Rows from the top, the first between y = n - 1 and n; empty for a numeric axis.
    pub rows: Vec<Row>,
    /// Height of a plot with two axes, in px.
    pub height_px: f64,
    /// From back to front.
    pub layers: Vec<Layer>,
    /// From top to bottom.
    pub legend: Vec<Key>,
    /// From left to right.
    pub readings: Vec<Reading>,
}

impl Default for Chart {
    fn default() -> Self {
        Self {
            title: String::new(),
            x_title: String::new(),
            y_title: String::new(),
            x: 0.0..1.0,
            y: 0.0..1.0,
            rows: vec![],
            height_px: HEIGHT_PX,
            layers: vec![],
            legend: vec![],
            readings: vec![],
        }
    }
}

impl Chart {
    /// Whether a mark lies beyond the axes, where an arrow stands for it.
    pub fn reaches_beyond(&self) -> bool {
        let within = |v: f64, range: &Range<f64>| (range.start..=range.end).contains(&v);
        let beyond = |layer: &Layer| matches!(layer, Layer::Marks { points, .. } if points.iter().any(|(x, y, _)| !within(*x, &self.x) || !within(*y, &self.y)));
        self.layers.iter().any(beyond)
    }
}

/// Where the marks of a row of so many lie, under its name: the first row is the uppermost.
pub fn strip(rows: usize, row: usize) -> Range<f64> {
    let top = rows as f64 - row as f64;
    top - 0.97..top - layout::ROW_TEXT_SHARE
}

/// Panels above one another as one drawing.
///
/// # Errors
/// An axis that cannot be divided.
pub fn stacked(panels: &[Chart]) -> Result<Scene, String> {
    let mut all = Scene::new((WIDTH_PX, 0.0));
    for panel in panels {
        let scene = panel.scene()?;
        let height = scene.size.1;
        all.place(scene, (0.0, all.size.1));
        all.size.1 += height;
    }
    Ok(all)
}

/// A drawing with its title above and its legend beside, as a file needs it.
pub fn file(title: &str, scene: Scene, legend: &[Key]) -> Scene {
    let left = MARGIN_PX + scene.size.0 + 18.0;
    let width = if legend.is_empty() { MARGIN_PX + scene.size.0 + MARGIN_PX } else { left + LEGEND_PX };
    let mut keys = Vec::new();
    let mut y = TITLE_PX + 14.0;
    for key in legend {
        let mut swatch = Scene::new((0.0, 0.0));
        swatch.elements = key.elements();
        keys.push((swatch, y));
        for line in wrapped(&key.text, 29) {
            let mut words = Scene::new((0.0, 0.0));
            words.words((38.0, 9.0), line, Anchor::Start, Tint::Ink);
            keys.push((words, y));
            y += 16.0;
        }
        y += 8.0;
    }
    let height = (TITLE_PX + scene.size.1 + 8.0).max(y);
    let mut all = Scene::new((width, height));
    for (i, line) in wrapped(title, 90).into_iter().take(1).enumerate() {
        all.elements.push(Element::Words(Words {
            at: (MARGIN_PX + 2.0, 22.0 + 18.0 * i as f64),
            text: line,
            anchor: Anchor::Start,
            tint: Tint::Ink,
            size: 15.0,
            is_bold: true,
            is_spare: false,
        }));
    }
    all.place(scene, (MARGIN_PX, TITLE_PX));
    for (key, y) in keys {
        all.place(key, (left, y));
    }
    all
}

/// Words in lines of at most so many letters.
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

/// Corners of an arrow's head at its tip, so long, for a line that comes from `from`.
fn head(from: Px, tip: Px, length: f64) -> Vec<Px> {
    let (dx, dy) = (tip.0 - from.0, tip.1 - from.1);
    let size = dx.hypot(dy).max(1e-9);
    let (ux, uy) = (dx / size * length, dy / size * length);
    vec![tip, (tip.0 - ux - 0.45 * uy, tip.1 - uy + 0.45 * ux), (tip.0 - ux + 0.45 * uy, tip.1 - uy - 0.45 * ux)]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_names_are_wrapped_between_words() {
        assert_eq!(wrapped("consistent, fitted to the FEA", 20), ["consistent, fitted", "to the FEA"]);
        assert_eq!(wrapped("", 20), Vec::<String>::new());
    }
}
