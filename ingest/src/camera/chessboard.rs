//! A chessboard in a picture: its inner corners, row by row, to a few hundredths of a pixel.
//!
//! Where four squares meet, brightness has a saddle: the determinant of its second derivatives is negative, and the two directions in which
//! the second derivative vanishes are the edges. Saddles are looked for in a reduced picture; along an edge, the next corner is a
//! saddle of the other sign. So the board grows from corner to corner, however it lies; nothing is thresholded, so that the light may
//! be uneven. In the end each corner is fitted in the picture itself (`corner.rs`).
//!
//! A board may be turned by half without looking different. The order is that of reading: columns and rows turn like x and y of the
//! picture (never mirrored), and of the orders left, the first corner is the one nearest to the upper left.

mod corner;
mod grow;
mod saddles;

use std::fmt;

use super::picture::{Picture, Place};
use grow::Grid;

/// Corners of a row or a column, at least: with fewer, any four squares would be a board.
pub const CORNERS_MIN: usize = 3;

/// Corners of a row or a column, at most.
pub const CORNERS_MAX: usize = 200;

/// The longer side of the reduced picture that is searched first, in px.
const FIRST_PX: usize = 1000;

/// A reduced picture is not smaller than this, in px.
const LAST_PX: usize = 80;

/// What is less than a third of a board is not called a part of one.
const PART: usize = 3;

/// A grid that is so near to the border, in squares, may go on behind it.
const BORDER_SQUARES: f64 = 1.3;

/// An edge that a lens bends is fitted as a straight one: of the bend between a corner and its neighbours, the corner moves by this
/// share times the square of window over distance. It is the mean of d² along the edge under the window's weights.
const BEND: f64 = 1.0 / 7.0;

/// A corner.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Corner {
    /// Where it is, in px.
    pub at: Place,
    /// Standard uncertainty along x and along y, in px: by what the fit of the corner leaves over, and by how much the lens bends the
    /// edges in its window.
    pub std_px: [f64; 2],
}

/// The inner corners of a board.
#[derive(Debug, Clone, PartialEq)]
pub struct Board {
    /// Corners of a row.
    pub columns: usize,
    /// Rows.
    pub rows: usize,
    /// Row by row.
    pub corners: Vec<Corner>,
}

/// Why there is no board.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum ChessboardError {
    /// No such board is looked for.
    Pattern {
        /// Corners of a row.
        columns: usize,
        /// Rows.
        rows: usize,
    },
    /// Nothing like a board.
    NoBoard,
    /// A board with another number of corners.
    Count {
        /// Corners wanted, of a row and of a column.
        wanted: (usize, usize),
        /// Corners found.
        found: (usize, usize),
    },
    /// Corners are covered, in glare or out of focus.
    Incomplete {
        /// Corners found.
        found: usize,
        /// Corners wanted.
        wanted: usize,
    },
    /// The board goes on behind the picture's border.
    Border {
        /// Corners found.
        found: usize,
    },
    /// More than one such board.
    Several,
    /// A corner that cannot be fitted.
    Unclear {
        /// About where, in px.
        at: Place,
    },
}

impl fmt::Display for ChessboardError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Pattern { columns, rows } => write!(
                f,
                "a board of {columns} x {rows} inner corners: each must be {CORNERS_MIN} to {CORNERS_MAX}; count where four squares meet"
            ),
            Self::NoBoard => write!(f, "no chessboard in the picture"),
            Self::Count { wanted, found } => write!(
                f,
                "the board has {} x {} inner corners, not {} x {}: count where four squares meet, and let nothing cover a part of it",
                found.0, found.1, wanted.0, wanted.1
            ),
            Self::Incomplete { found, wanted } => {
                write!(
                    f,
                    "{found} of {wanted} inner corners found: is a part of the board covered, in glare or out of focus?"
                )
            }
            Self::Border { found } => {
                write!(
                    f,
                    "the board touches the border of the picture: {found} inner corners found; show all of it, its white margin too"
                )
            }
            Self::Several => write!(f, "more than one such board in the picture: cover the others"),
            Self::Unclear { at } => {
                write!(
                    f,
                    "the corner near ({:.0}, {:.0}) px is no crossing of two edges: is it covered, too small or blurred?",
                    at.x, at.y
                )
            }
        }
    }
}

impl std::error::Error for ChessboardError {}

impl Board {
    /// The corners with their places on a board of squares of so many m, from the first corner; what
    /// [`calibrate`](super::calibrate::calibrate) takes.
    pub fn with_squares(&self, square_m: f64) -> Vec<(Place, Place)> {
        let on_board = |i: usize| Place::new((i % self.columns) as f64, (i / self.columns) as f64) * square_m;
        self.corners.iter().enumerate().map(|(i, corner)| (on_board(i), corner.at)).collect()
    }
}

/// The inner corners of the board of so many in a row and so many rows.
///
/// # Errors
/// Why they are not told: no board or another one, corners that are missing, a board at the border, several boards.
pub fn find(picture: &Picture, columns: usize, rows: usize) -> Result<Board, ChessboardError> {
    let of_board = CORNERS_MIN..=CORNERS_MAX;
    if !of_board.contains(&columns) || !of_board.contains(&rows) {
        return Err(ChessboardError::Pattern { columns, rows });
    }
    let mut best: Option<Grid> = None;
    for factor in factors(picture) {
        let saddles = saddles::saddles(picture, factor);
        let mut grids = grow::grids(&saddles, columns * rows);
        let mut whole = grids.iter().enumerate().filter(|(_, grid)| grid.is_whole(columns, rows)).map(|(i, _)| i);
        if let Some(i) = whole.next() {
            if whole.next().is_some() {
                return Err(ChessboardError::Several);
            }
            return refined(picture, &grids.swap_remove(i), (columns, rows), factor);
        }
        // Of the boards that are not whole, the largest is told.
        for grid in grids.into_iter().filter(Grid::is_part) {
            if best.as_ref().is_none_or(|other| grid.count() > other.count()) {
                best = Some(grid);
            }
        }
    }
    let grid = best.ok_or(ChessboardError::NoBoard)?;
    Err(reason(picture, &grid, (columns, rows)))
}

/// By how much the picture is reduced: first to what is fast, then finer, then coarser.
fn factors(picture: &Picture) -> Vec<usize> {
    let longer = picture.width().max(picture.height());
    let mut first = 1;
    while longer / first > FIRST_PX {
        first *= 2;
    }
    let finer = std::iter::successors(Some(first), |f| (*f > 1).then_some(f / 2));
    let coarser = std::iter::successors(Some(2 * first), |f| Some(2 * f)).take_while(|f| longer / f >= LAST_PX);
    finer.chain(coarser).collect()
}

fn reason(picture: &Picture, grid: &Grid, wanted: (usize, usize)) -> ChessboardError {
    let (width, height, found) = (grid.width(), grid.height(), grid.count());
    // A few saddles line up in many pictures.
    if PART * found < wanted.0 * wanted.1 || width.min(height) < CORNERS_MIN {
        return ChessboardError::NoBoard;
    }
    let (long, short) = (wanted.0.max(wanted.1), wanted.0.min(wanted.1));
    let smaller = width.max(height) <= long && width.min(height) <= short;
    if smaller && grid.touches(picture.width() as f64, picture.height() as f64, BORDER_SQUARES) {
        return ChessboardError::Border { found };
    }
    if found == width * height || found > wanted.0 * wanted.1 {
        let (a, b) = if wanted.0 >= wanted.1 {
            (width.max(height), width.min(height))
        } else {
            (width.min(height), width.max(height))
        };
        return ChessboardError::Count { wanted, found: (a, b) };
    }
    ChessboardError::Incomplete { found, wanted: wanted.0 * wanted.1 }
}

fn refined(
    picture: &Picture,
    grid: &Grid,
    (columns, rows): (usize, usize),
    factor: usize,
) -> Result<Board, ChessboardError> {
    let places = grid.in_order(columns, rows);
    let at = |column: usize, row: usize| places.get(row * columns + column).copied();
    let mut corners = Vec::with_capacity(places.len());
    for (i, place) in places.iter().enumerate() {
        let (column, row) = (i % columns, i / columns);
        let beside = |a: Option<usize>, b: Option<usize>| at(a?, b?).map(|p| p - place);
        let along =
            [beside(column.checked_sub(1), Some(row)), beside((column + 1 < columns).then_some(column + 1), Some(row))];
        let across =
            [beside(Some(column), row.checked_sub(1)), beside(Some(column), (row + 1 < rows).then_some(row + 1))];
        let unclear = ChessboardError::Unclear { at: *place };
        corners.push(corner::fit(picture, *place, along, across, factor as f64).ok_or(unclear)?);
    }
    let windows: Vec<f64> = corners.iter().map(|(_, window)| *window).collect();
    let mut board = Board { columns, rows, corners: corners.into_iter().map(|(corner, _)| corner).collect() };
    board.add_bends(&windows);
    Ok(board)
}

impl Board {
    /// Adds to the uncertainties what bent edges do; the windows' radii in px.
    fn add_bends(&mut self, windows: &[f64]) {
        let at = |column: usize, row: usize| self.corners.get(row * self.columns + column).map(|corner| corner.at);
        // Of three neighbours in a line, how far the middle one is off the straight one through the others, and half their distance.
        let bend = |i: usize, last: usize, of: &dyn Fn(usize) -> Option<Place>| -> Option<(Place, f64)> {
            let middle = i.clamp(1, last - 1);
            let (a, b, c) = (of(middle - 1)?, of(middle)?, of(middle + 1)?);
            let (along, off) = ((c - a).normalize(), b - (a + c) / 2.0);
            Some((off - along * along.dot(&off), (c - a).norm() / 2.0))
        };
        let (columns, rows) = (self.columns, self.rows);
        let added: Vec<[f64; 2]> = (0..self.corners.len())
            .zip(windows)
            .map(|(i, window)| {
                let (column, row) = (i % columns, i / columns);
                let of_row = bend(column, columns - 1, &|k| at(k, row));
                let of_column = bend(row, rows - 1, &|k| at(column, k));
                let shift = |(off, step): (Place, f64)| off * (BEND * (window / step).powi(2));
                let both = [of_row, of_column].map(|found| found.map_or(Place::zeros(), shift));
                [both[0].x.hypot(both[1].x), both[0].y.hypot(both[1].y)]
            })
            .collect();
        for (corner, by) in self.corners.iter_mut().zip(added) {
            corner.std_px = [corner.std_px[0].hypot(by[0]), corner.std_px[1].hypot(by[1])];
        }
    }
}

#[cfg(test)]
mod tests;
