//! How many metres a pixel is, and how well that is known.
//!
//! A scale holds in one plane parallel to the picture: that of the ruler, the coin or the board. A body before or behind it is
//! seen at another one ([`perspective`]). It comes of a known length between two places, of a disc ([`disc`]), of the pitch of a
//! ruler's marks ([`ruler`]), or of a chessboard. Where the lens is known, places are straightened first.

pub mod disc;
pub mod perspective;
pub mod ruler;

use std::fmt;

use super::calibrate::CalibrateError;
use super::calibrate::homography::{Homography, PlaneScale};
use super::chessboard::Board;
use super::lens::Lens;
use super::picture::Place;

/// Metres per pixel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Scale {
    /// In m; above 0.
    pub metre_per_px: f64,
    /// Standard uncertainty, in m.
    pub std: f64,
}

/// A length and its standard uncertainty, in m.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Length {
    /// In m.
    pub metre: f64,
    /// Standard uncertainty, in m.
    pub std: f64,
}

/// Why there is no scale.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum ScaleError {
    /// A known length that is none.
    Length {
        /// In m.
        metre: f64,
        /// Its standard uncertainty, in m.
        std: f64,
    },
    /// Two places that are the same, or none.
    Places {
        /// First.
        from: Place,
        /// Second.
        to: Place,
    },
    /// Beyond what the lens was calibrated for.
    Lens {
        /// Where, in px.
        at: Place,
    },
    /// No homography of a chessboard.
    Board(CalibrateError),
    /// The middle of a chessboard is not seen.
    Behind,
}

impl fmt::Display for ScaleError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Length { metre, std } => {
                write!(
                    f,
                    "a known length of {metre} m with a standard uncertainty of {std} m: expected one above 0 m, and known"
                )
            }
            Self::Places { from, to } => write!(
                f,
                "from ({}, {}) to ({}, {}) px: expected two places in the picture, at least 1 px apart",
                from.x, from.y, to.x, to.y
            ),
            Self::Lens { at } => {
                write!(
                    f,
                    "the lens is not known at ({:.0}, {:.0}) px: its model folds there; calibrate with corners near the border",
                    at.x, at.y
                )
            }
            Self::Board(why) => write!(f, "no scale of the chessboard: {why}"),
            Self::Behind => write!(f, "no scale of the chessboard: its middle is not seen"),
        }
    }
}

impl std::error::Error for ScaleError {}

/// Where a pinhole would have seen a place; without a lens, there.
pub(crate) fn straight(lens: Option<&Lens>, at: Place) -> Result<Place, ScaleError> {
    lens.map_or(Some(at), |lens| lens.straight(at)).ok_or(ScaleError::Lens { at })
}

/// The other way round.
pub(crate) fn as_seen(lens: Option<&Lens>, straight: Place) -> Place {
    lens.map_or(straight, |lens| lens.on_picture((straight - lens.centre_px).component_div(&lens.focal_px)))
}

impl Length {
    /// Checked: above nought, known.
    pub(crate) fn checked(self) -> Result<Self, ScaleError> {
        let sound = self.metre > 0.0 && self.metre.is_finite() && self.std >= 0.0 && self.std < self.metre;
        sound.then_some(self).ok_or(ScaleError::Length { metre: self.metre, std: self.std })
    }
}

impl Scale {
    /// Of a length that is so many px: relative uncertainties add by squares.
    pub(crate) fn of(length: Length, px: f64, std_px: f64) -> Self {
        let metre_per_px = length.metre / px;
        Self { metre_per_px, std: metre_per_px * (length.std / length.metre).hypot(std_px / px) }
    }

    /// A length in px and its standard uncertainty, in m.
    pub fn length(&self, px: f64, std_px: f64) -> Length {
        Length { metre: px * self.metre_per_px, std: (px * self.std).hypot(std_px * self.metre_per_px) }
    }

    /// Of a known length between two places, each known with a standard uncertainty along the line between them, in px.
    ///
    /// # Errors
    /// If length or places are none, or the lens is not known there.
    pub fn from_length(
        length: Length,
        [from, to]: [Place; 2],
        stds_px: [f64; 2],
        lens: Option<&Lens>,
    ) -> Result<Self, ScaleError> {
        let length = length.checked()?;
        let px = (straight(lens, to)? - straight(lens, from)?).norm();
        let std_px = stds_px[0].hypot(stds_px[1]);
        if !(px >= 1.0 && px.is_finite() && std_px.is_finite()) {
            return Err(ScaleError::Places { from, to });
        }
        Ok(Self::of(length, px, std_px))
    }

    /// Of a chessboard of squares of a known side: a pixel at its middle, the root of its area. How much the board is tilted is
    /// told by the anisotropy of what comes beside; with a tilt, the scale holds at the middle only.
    ///
    /// # Errors
    /// If the square is none, or the corners are no plane's.
    pub fn from_board(square: Length, board: &Board, lens: Option<&Lens>) -> Result<(Self, PlaneScale), ScaleError> {
        let square = square.checked()?;
        let corners = board.with_squares(square.metre);
        let straightened: Vec<(Place, Place)> = corners
            .iter()
            .map(|(on_board, at)| Ok((*on_board, straight(lens, *at)?)))
            .collect::<Result<_, ScaleError>>()?;
        let plane = Homography::fit(&straightened, None).map_err(ScaleError::Board)?;
        let middle = Place::new((board.columns - 1) as f64, (board.rows - 1) as f64) * (square.metre / 2.0);
        let at = plane.to_picture(middle).and_then(|at| plane.scale_at(at)).ok_or(ScaleError::Behind)?;
        let std = at.metre_per_px * (at.std / at.metre_per_px).hypot(square.std / square.metre);
        Ok((Self { metre_per_px: at.metre_per_px, std }, at))
    }
}

#[cfg(test)]
mod tests {
    use super::super::chessboard::Corner;
    use super::*;
    use nalgebra::{Rotation3, Vector3};

    #[test]
    fn a_known_length_is_a_scale_with_the_uncertainties_of_length_and_places() {
        let length = Length { metre: 0.05, std: 5e-5 };
        let places = [Place::new(100.0, 100.0), Place::new(400.0, 500.0)];
        let scale = Scale::from_length(length, places, [0.3, 0.4], None).unwrap();
        assert!((scale.metre_per_px - 1e-4).abs() < 1e-18);
        // One part in a thousand of each.
        assert!((scale.std / scale.metre_per_px - 1e-3 * 2.0_f64.sqrt()).abs() < 1e-12);
        let ten = scale.length(100.0, 0.1);
        assert!((ten.metre - 0.01).abs() < 1e-15 && (ten.std - 1e-2 * 3e-6_f64.sqrt()).abs() < 1e-12, "{ten:?}");
        // Behind a lens, the straight length counts.
        let lens = Lens { radial: [-0.2, 0.0, 0.0], ..Lens::pinhole(600.0, Place::new(320.0, 240.0)) };
        let bent = places.map(|at| as_seen(Some(&lens), at));
        let same = Scale::from_length(length, bent, [0.3, 0.4], Some(&lens)).unwrap();
        assert!((same.metre_per_px - scale.metre_per_px).abs() < 1e-15);
    }

    #[test]
    fn lengths_and_places_that_are_none_are_refused() {
        let (length, at) = (Length { metre: 0.05, std: 0.0 }, Place::new(1.0, 2.0));
        assert!(matches!(Scale::from_length(length, [at, at], [0.1; 2], None), Err(ScaleError::Places { .. })));
        let places = [at, at * 9.0];
        for metre in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            let none = Scale::from_length(Length { metre, std: 0.0 }, places, [0.1; 2], None);
            assert!(matches!(none, Err(ScaleError::Length { .. })));
        }
        let lens = Lens { radial: [-0.3, 0.0, 0.0], ..Lens::pinhole(1000.0, Place::zeros()) };
        let beyond = Scale::from_length(length, [at, Place::new(710.0, 0.0)], [0.1; 2], Some(&lens)).unwrap_err();
        assert!(beyond.to_string().contains("folds"), "{beyond}");
    }

    #[test]
    fn a_board_gives_the_scale_at_its_middle() {
        let lens = Lens { radial: [-0.1, 0.02, 0.0], ..Lens::pinhole(1000.0, Place::new(500.0, 400.0)) };
        for tilt in [0.0_f64, 0.3] {
            let rotation = Rotation3::from_euler_angles(0.0, tilt, 0.2);
            let at = |i: usize| {
                let point = Vector3::new((i % 9) as f64 - 4.0, (i / 9) as f64 - 2.5, 0.0) * 0.01;
                lens.project(rotation * point + Vector3::new(0.0, 0.0, 0.25)).unwrap()
            };
            let corners = (0..54).map(|i| Corner { at: at(i), std_px: [0.02; 2] }).collect();
            let board = Board { columns: 9, rows: 6, corners };
            let (scale, plane) = Scale::from_board(Length { metre: 0.01, std: 1e-5 }, &board, Some(&lens)).unwrap();
            // 0.25 m by 1000 px; the tilt shows one way of the plane shorter by its cosine.
            let truth = 0.25e-3 / tilt.cos().sqrt();
            assert!((scale.metre_per_px / truth - 1.0).abs() < 1e-9, "{tilt}: {scale:?}");
            assert!((plane.anisotropy() - 1.0 / tilt.cos()).abs() < 1e-8);
            assert!((scale.std / scale.metre_per_px - 1e-3).abs() < 1e-6);
        }
    }
}
