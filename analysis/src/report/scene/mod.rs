//! A drawing as simple elements at places in px of a page, from which both the picture on a page and the file are made.

mod raster;
mod svg;

pub use raster::png;
pub(in crate::report) use raster::{FONT, register};
pub use svg::{svg, swatch};

/// What colours mean; which they are depends on whether the page is light or dark.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Tint {
    /// Text, and what was measured.
    Ink,
    /// Axes and their numbers.
    Muted,
    /// Lines behind everything.
    Grid,
    /// The ground a figure stands on.
    Paper,
    /// What a bound allows.
    Bound,
    /// Where that ends.
    BoundEdge,
    /// What a finding is about.
    Flag,
    /// Where that ends.
    FlagEdge,
    /// Solid material of a cross-section.
    Solid,
    /// A form, by its place in the list.
    Form(usize),
}

/// Colours of forms: those of Okabe and Ito (2008), which colour-blind readers can tell apart, the pale ones darkened so that they stand
/// out from white; then darker ones for long lists.
pub const FORMS: usize = 10;

impl Tint {
    /// Red, green and blue on a white ground.
    pub fn rgb(self) -> [u8; 3] {
        const OF_FORMS: [[u8; 3]; FORMS] = [
            [0x00, 0x72, 0xb2],
            [0xd5, 0x5e, 0x00],
            [0x00, 0x8f, 0x68],
            [0xb9, 0x60, 0x90],
            [0xb8, 0x7f, 0x00],
            [0x2f, 0x98, 0xd6],
            [0x5e, 0x3c, 0x99],
            [0x8a, 0x5a, 0x2b],
            [0x4d, 0x4d, 0x4d],
            [0x6d, 0x7d, 0x1a],
        ];
        match self {
            Self::Ink => [0x1b, 0x24, 0x30],
            Self::Muted => [0x5b, 0x67, 0x75],
            Self::Grid => [0xe6, 0xea, 0xef],
            Self::Paper => [0xff, 0xff, 0xff],
            Self::Bound => [0xe3, 0xf1, 0xea],
            Self::BoundEdge => [0x7f, 0xb5, 0x9a],
            Self::Flag => [0xfd, 0xf0, 0xd0],
            Self::FlagEdge => [0xc9, 0x97, 0x1f],
            Self::Solid => [0xd5, 0xdd, 0xe6],
            Self::Form(i) => OF_FORMS[i % FORMS],
        }
    }
}

/// The shape of a mark, so that colour is never the only difference.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Shape {
    /// Filled disc: measured.
    Disc,
    /// Circle: measured on the way down.
    Ring,
    /// Square.
    Square,
    /// Triangle.
    Triangle,
    /// Diamond.
    Diamond,
    /// Cross.
    Cross,
    /// Small disc: where there are many.
    Dot,
}

impl Shape {
    /// The shape of a form, by its place in the list.
    pub fn of_form(i: usize) -> Self {
        [Self::Square, Self::Triangle, Self::Diamond, Self::Cross][i % 4]
    }

    /// The corners of one that has corners, around its middle.
    pub fn corners(self) -> &'static [(f64, f64)] {
        match self {
            Self::Square => &[(-5.0, -5.0), (5.0, -5.0), (5.0, 5.0), (-5.0, 5.0)],
            Self::Triangle => &[(0.0, -6.5), (6.0, 4.5), (-6.0, 4.5)],
            Self::Diamond => &[(0.0, -7.0), (6.0, 0.0), (0.0, 7.0), (-6.0, 0.0)],
            Self::Disc | Self::Ring | Self::Cross | Self::Dot => &[],
        }
    }

    /// The radius of a round one.
    pub fn radius(self) -> f64 {
        match self {
            Self::Disc => 5.0,
            Self::Ring => 4.2,
            Self::Dot => 2.0,
            _ => 0.0,
        }
    }
}

/// Half the length of a cross's arms on either axis, in px.
pub const CROSS: f64 = 4.6;

/// The stroke of a cross and of a ring, in px.
pub const MARK_STROKE: f64 = 2.2;

/// A place, in px to the right and down.
pub type Px = (f64, f64);

/// Where a text stands at its place.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Anchor {
    /// It begins there.
    Start,
    /// Its middle is there.
    Middle,
    /// It ends there.
    End,
}

/// Words on a drawing; they stand in the middle of their line's height.
#[derive(Debug, Clone, PartialEq)]
pub struct Words {
    /// Where.
    pub at: Px,
    /// What.
    pub text: String,
    /// Where that place is in them.
    pub anchor: Anchor,
    /// Colour.
    pub tint: Tint,
    /// Height of the font in px of a page.
    pub size: f64,
    /// Heavy.
    pub is_bold: bool,
    /// Left out where there is little room.
    pub is_spare: bool,
}

/// What is drawn, from back to front.
#[derive(Debug, Clone, PartialEq)]
pub enum Element {
    /// A filled rectangle: left upper corner, and size.
    Rect { at: Px, size: Px, tint: Tint },
    /// A filled shape.
    Area { corners: Vec<Px>, tint: Tint },
    /// A line through places.
    Line { points: Vec<Px>, tint: Tint, width: f64, is_dashed: bool },
    /// Lines that do not touch.
    Segments { ends: Vec<[Px; 2]>, tint: Tint, width: f64 },
    /// Marks of one look.
    Marks { at: Vec<Px>, tint: Tint, shape: Shape },
    /// Text.
    Words(Words),
}

/// What a reader learns who points at a place or comes to it by keyboard.
#[derive(Debug, Clone, PartialEq)]
pub struct Readout {
    /// The place.
    pub at: Px,
    /// What answers to the pointer: left upper corner, and size.
    pub field: (Px, Px),
    /// The whole height of the figure is read at this place.
    pub is_column: bool,
    /// What it says, a line each.
    pub lines: Vec<String>,
}

/// A drawing.
#[derive(Debug, Clone, PartialEq)]
pub struct Scene {
    /// Width and height in px.
    pub size: Px,
    /// From back to front.
    pub elements: Vec<Element>,
    /// What can be read off.
    pub readouts: Vec<Readout>,
}

impl Scene {
    /// An empty one.
    pub fn new(size: Px) -> Self {
        Self { size, elements: vec![], readouts: vec![] }
    }

    /// Adds plain words.
    pub fn words(&mut self, at: Px, text: impl Into<String>, anchor: Anchor, tint: Tint) {
        self.elements.push(Element::Words(Words {
            at,
            text: text.into(),
            anchor,
            tint,
            size: TEXT_PX,
            is_bold: false,
            is_spare: false,
        }));
    }

    /// Adds a thin line.
    pub fn line(&mut self, points: Vec<Px>, tint: Tint, width: f64) {
        self.elements.push(Element::Line { points, tint, width, is_dashed: false });
    }

    /// Another drawing, moved.
    pub fn place(&mut self, other: Self, by: Px) {
        let moved = |p: Px| (p.0 + by.0, p.1 + by.1);
        let all = |points: Vec<Px>| points.into_iter().map(moved).collect();
        self.elements.extend(other.elements.into_iter().map(|element| match element {
            Element::Rect { at, size, tint } => Element::Rect { at: moved(at), size, tint },
            Element::Area { corners, tint } => Element::Area { corners: all(corners), tint },
            Element::Line { points, tint, width, is_dashed } => {
                Element::Line { points: all(points), tint, width, is_dashed }
            }
            Element::Segments { ends, tint, width } => {
                Element::Segments { ends: ends.into_iter().map(|[a, b]| [moved(a), moved(b)]).collect(), tint, width }
            }
            Element::Marks { at, tint, shape } => Element::Marks { at: all(at), tint, shape },
            Element::Words(words) => Element::Words(Words { at: moved(words.at), ..words }),
        }));
        self.readouts.extend(other.readouts.into_iter().map(|r| Readout {
            at: moved(r.at),
            field: (moved(r.field.0), r.field.1),
            ..r
        }));
    }
}

/// Height of ordinary text in px.
pub const TEXT_PX: f64 = 12.0;
