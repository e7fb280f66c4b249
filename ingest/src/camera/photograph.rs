//! A picture as a report shows it: small, with what was measured in it.

use super::picture::Picture;
use super::task::{Marks, Reading};

/// So many pictures of a log are kept to be shown, at most.
pub const SHOWN_MAX: usize = 8;

/// As wide as this at most, in px.
const WIDTH_MAX: usize = 480;

/// As many places of edges are drawn on a small picture, at most.
const EDGES_MAX: usize = 600;

/// A picture that was measured, or could not be.
#[derive(Debug, Clone, PartialEq)]
pub struct Photograph {
    /// The table of its log; empty where there is one only.
    pub table: String,
    /// Its row in that table, from 0.
    pub sample: usize,
    /// What it is called: its file, or its topic and number.
    pub name: String,
    /// The picture, smaller.
    pub picture: Picture,
    /// How many px of the photograph one of these stands for, each way.
    pub by: usize,
    /// What was measured, in px of the photograph; nothing if it was refused.
    pub marks: Marks,
    /// Why it was not measured.
    pub refused: Option<String>,
}

impl Photograph {
    /// Of a picture and what it says.
    pub fn new(name: &str, sample: usize, picture: &Picture, reading: Result<&Reading, &str>) -> Self {
        let by = picture.width().div_ceil(WIDTH_MAX);
        let mut marks = reading.map_or_else(|_| Marks::default(), |reading| reading.marks.clone());
        let every = marks.edges.len().div_ceil(EDGES_MAX).max(1);
        marks.edges = marks.edges.into_iter().step_by(every).collect();
        Self {
            table: String::new(),
            sample,
            name: name.to_owned(),
            picture: picture.smaller(by),
            by,
            marks,
            refused: reading.err().map(str::to_owned),
        }
    }
}

/// Whether one of so many is among those that are shown: they lie evenly, the first and the last with them.
///
/// ```
/// use pneuval_ingest::camera::photograph::is_shown;
/// let shown = |of: usize| (0..of).filter(|i| is_shown(*i, of)).collect::<Vec<_>>();
/// assert_eq!(shown(5), [0, 1, 2, 3, 4]);
/// assert_eq!(shown(15), [0, 2, 4, 6, 8, 10, 12, 14]);
/// assert_eq!(shown(1), [0]);
/// ```
pub fn is_shown(i: usize, of: usize) -> bool {
    if of <= SHOWN_MAX {
        return i < of;
    }
    let (last, gaps) = (of - 1, SHOWN_MAX - 1);
    // The picture nearest to each of the evenly spaced places.
    (0..=gaps).any(|k| (2 * k * last + gaps) / (2 * gaps) == i)
}
