//! The area of an imprint: paint on paper, in colour, with holes.
//!
//! ```text
//! colours on a grid --> two, along the direction in which they differ most (Otsu) --> light of the paper, a surface of second order
//!   --> share of paint in every pixel --> parts, holes, specks --> pixels well inside count whole, those of the rim by their share
//! ```
//!
//! The share of a pixel is where its colour, over that of the paper in this light, lies between paper and paint. Blur spreads shares but
//! leaves their sum: the area does not depend on it. Paint is uneven: within, a pixel counts whole however thick the paint on it is, and at
//! the rim its share is that between the paper and the paint nearby (planes through what lies around). Brightness has to be that of the
//! light: a camera's tone curve is to be taken out before.

mod colour;
mod field;
mod rim;

use std::fmt;

use super::picture::{Picture, Place};
use colour::Colours;
use field::Field;

/// What is sought.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SoughtArea {
    /// Where: left, top, width, height, in px; `None`: everywhere.
    pub region: Option<[usize; 4]>,
    /// The paint's red, green and blue, 0 to 255, where there are other colours than its and the paper's.
    pub paint: Option<[f64; 3]>,
    /// Specks of fewer px² are told, and do not count.
    pub least_px2: f64,
    /// Whether what is not painted within counts as painted.
    pub fill_holes: bool,
}

impl Default for SoughtArea {
    fn default() -> Self {
        Self { region: None, paint: None, least_px2: 30.0, fill_holes: false }
    }
}

/// The imprint.
#[derive(Debug, Clone, PartialEq)]
pub struct Imprint {
    /// Its area, in px² (of a straightened picture where the lens is given).
    pub area_px2: f64,
    /// Standard uncertainty: noise of the rim, level of paint and paper there, and a fiftieth of a pixel all along it.
    pub std_px2: f64,
    /// Parts that do not hang together, by size.
    pub parts: Vec<Part>,
    /// What is not painted within the parts, in px², and how many such holes there are.
    pub holes: (f64, usize),
    /// What is too small to count, in px², and how many.
    pub specks: (f64, usize),
    /// The length of the rim, holes with it, in px.
    pub rim_px: f64,
    /// The rim's blur, in px (standard deviation).
    pub blur_px: f64,
    /// Paper and paint, red, green, blue (of a grey picture, thrice the same).
    pub colours: [[f64; 3]; 2],
    /// Noise over the difference of paper and paint.
    pub noise: f64,
    /// The outline of parts and holes, to be drawn.
    pub outline: Vec<Place>,
    /// What is worth knowing.
    pub notes: Vec<Note>,
}

/// One part of an imprint.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Part {
    /// In px².
    pub area_px2: f64,
    /// Its middle, in px.
    pub centre: Place,
}

/// What the user should know of an area.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Note {
    /// Specks that do not count: how many, and their px².
    Specks(usize, f64),
    /// Paint differs by so much over the imprint (standard deviation, as a share).
    Uneven(f64),
    /// The rim is blurred over so many px.
    Blurred(f64),
    /// So much of what is coloured, as a share of the paint, is of another colour and does not count.
    OtherColour(f64),
    /// So much of the imprint, as a share, is of another colour than most of it, and counts.
    OtherColourCounts(f64),
}

impl fmt::Display for Note {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Specks(count, px2) => write!(f, "{count} specks of {px2:.0} px² in all do not count"),
            Self::Uneven(share) => write!(f, "the paint is uneven by {:.0} %", 100.0 * share),
            Self::Blurred(px) => write!(f, "the rim is blurred by {px:.1} px"),
            Self::OtherColourCounts(share) => write!(
                f,
                "{:.0} % of the painted area is of another colour than the rest, and counts: if it is none of the imprint, name the `paint`, or \
                 a `region` without it",
                100.0 * share
            ),
            Self::OtherColour(share) => {
                write!(f, "something of another colour, {:.0} % of the painted area, does not count", 100.0 * share)
            }
        }
    }
}

/// Why there is no area.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum AreaRefusal {
    /// The region is none.
    Region,
    /// One colour only.
    NoContrast {
        /// How far apart the two are, in standard deviations of the paper.
        stds: f64,
    },
    /// Nothing large enough.
    NoPaint,
    /// Paint reaches the border.
    Border,
    /// More than two colours.
    Colours {
        /// Share of what is coloured that is of others than the most frequent.
        share: f64,
    },
    /// Paper is as bright as can be in every colour that tells it from the paint.
    Saturated,
}

impl fmt::Display for AreaRefusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Region => write!(f, "no picture there: name a `region` of at least 16 px each way within it"),
            Self::NoContrast { stds } => write!(
                f,
                "no imprint: paint and paper cannot be told apart, they lie {stds:.1} standard deviations of the paper from each other"
            ),
            Self::NoPaint => {
                write!(f, "no imprint: nothing painted is large enough; name the `paint` colour or the `region`")
            }
            Self::Border => write!(
                f,
                "the imprint touches the border: more of it may lie outside; if that is something else, name the `region` of the imprint"
            ),
            Self::Colours { share } => write!(
                f,
                "several colours: {:.0} % of what is not paper differs from the rest; name the colour of the `paint`, or the `region`",
                100.0 * share
            ),
            Self::Saturated => {
                write!(
                    f,
                    "saturated: the paper is as bright as can be, so that nobody knows where half of the way is; expose less"
                )
            }
        }
    }
}

/// The area of an imprint. `straight` is where a pinhole would have seen a place: the identity without a calibrated lens.
///
/// # Errors
/// Why there is none.
pub fn area(
    picture: &Picture,
    sought: SoughtArea,
    straight: &dyn Fn(Place) -> Option<Place>,
) -> Result<Imprint, AreaRefusal> {
    let (w, h) = (picture.width(), picture.height());
    let [left, top, across, down] = sought.region.unwrap_or([0, 0, w, h]);
    let region = [left.min(w), top.min(h), across.min(w - left.min(w)), down.min(h - top.min(h))];
    if region[2] < field::LEAST || region[3] < field::LEAST {
        return Err(AreaRefusal::Region);
    }
    let colours = Colours::of(picture, region, sought.paint)?;
    let field = Field::of(picture, region, &colours, sought.paint.is_some())?;
    rim::measured(&field, &colours, sought, straight)
}

#[cfg(test)]
mod tests;
