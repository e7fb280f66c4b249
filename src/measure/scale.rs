//! `pneuval measure scale`: how long a pixel is.

use serde::Serialize;

use pneuval_ingest::IngestError;
use pneuval_ingest::camera::chessboard;
use pneuval_ingest::camera::lens::Lens;
use pneuval_ingest::camera::picture::{Picture, Place};
use pneuval_ingest::camera::scale::ruler::{self, Line};
use pneuval_ingest::camera::scale::{Scale, disc};
use pneuval_ingest::error::Place as FilePlace;

use super::arguments::{MeasureScale, ScaleOf, ScaleOfBoard, ScaleOfDisc, ScaleOfLength, ScaleOfRuler, ScalePicture};
use super::{opened, words};
use crate::exit::{Failure, Outcome};
use crate::output;

/// A tilt of the plane that changes the scale by a thousandth and more across a body a tenth of the distance wide is worth a word, in deg.
const TILT_MAX_DEG: f64 = 5.0;

/// A plane on which a pixel is longer one way than the other by this share is not parallel to the picture.
const ANISOTROPY_MAX: f64 = 0.005;

/// A scale, for `--json`.
#[derive(Serialize)]
struct Told {
    file: String,
    /// In mm.
    mm_per_px: f64,
    std_mm: f64,
    /// What it rests on, in words.
    of: String,
    notes: Vec<String>,
}

pub fn run(arguments: &MeasureScale) -> Result<Outcome, Failure> {
    match &arguments.of {
        ScaleOf::Disc(arguments) => of_disc(arguments),
        ScaleOf::Ruler(arguments) => of_ruler(arguments),
        ScaleOf::Length(arguments) => of_length(arguments),
        ScaleOf::Board(arguments) => of_board(arguments),
    }
}

fn of_disc(arguments: &ScaleOfDisc) -> Result<Outcome, Failure> {
    let diameter = words::above_zero("--diameter", &arguments.diameter)?;
    let region = arguments.region.as_deref().map(words::region).transpose()?;
    // The last pixels of the region belong to it. Pictures are far smaller than 2^52 px.
    let part = region.map(|[left, top, width, height]| {
        let place = |x: usize, y: usize| Place::new(x as f64, y as f64);
        [place(left, top), place((left + width).saturating_sub(1), (top + height).saturating_sub(1))]
    });
    let (picture, lens) = picture(&arguments.of)?;
    let disc = disc::find(&picture, part, lens.as_ref()).map_err(|why| refused(&arguments.of, &why.to_string()))?;
    let scale = disc.scale(diameter).map_err(|why| refused(&arguments.of, &why.to_string()))?;
    let of = format!(
        "a disc of {:.3} ± {:.3} px around ({:.1}, {:.1}), {} of {} lines across its edge",
        disc.diameter_px,
        1.96 * disc.std_px,
        disc.centre.x,
        disc.centre.y,
        disc.lines.0,
        disc.lines.1
    );
    let tilt = disc.tilt_rad.to_degrees();
    let tilted = (tilt > TILT_MAX_DEG).then(|| {
        format!(
            "the disc is tilted by {tilt:.1}°: its scale is that of its longer axis, and changes across the picture"
        )
    });
    tell(&arguments.of, scale, of, tilted.into_iter().collect())
}

fn of_ruler(arguments: &ScaleOfRuler) -> Result<Outcome, Failure> {
    let pitch = words::above_zero("--pitch", &arguments.pitch)?;
    let (from, to) = (words::place("--from", &arguments.from)?, words::place("--to", &arguments.to)?);
    let (picture, lens) = picture(&arguments.of)?;
    let line = Line { from, to, across_px: arguments.across, about_px: arguments.about };
    let found = ruler::pitch(&picture, &line, lens.as_ref()).map_err(|why| refused(&arguments.of, &why.to_string()))?;
    let scale = found.scale(pitch).map_err(|why| refused(&arguments.of, &why.to_string()))?;
    let of = format!("{:.1} marks {:.4} ± {:.4} px apart", found.marks, found.pitch_px, 1.96 * found.std_px);
    let changes = found.change.abs() > 3.0 * found.change_std && found.change.abs() > ANISOTROPY_MAX;
    let tilted = changes.then(|| {
        let share = 100.0 * found.change;
        format!("marks are {share:+.1} % farther apart at the second end: the ruler is tilted, and the scale that of the middle of the line")
    });
    tell(&arguments.of, scale, of, tilted.into_iter().collect())
}

fn of_length(arguments: &ScaleOfLength) -> Result<Outcome, Failure> {
    let length = words::above_zero("--length", &arguments.length)?;
    let places = [words::place("--from", &arguments.from)?, words::place("--to", &arguments.to)?];
    let (_, lens) = picture(&arguments.of)?;
    let scale = Scale::from_length(length, places, [arguments.std_px; 2], lens.as_ref())
        .map_err(|why| refused(&arguments.of, &why.to_string()))?;
    let of = format!(
        "{:.2} px between two places, each known to {} px",
        length.metre / scale.metre_per_px,
        arguments.std_px
    );
    tell(&arguments.of, scale, of, vec![])
}

fn of_board(arguments: &ScaleOfBoard) -> Result<Outcome, Failure> {
    let (columns, rows) = words::corners(&arguments.board.corners)?;
    let square = words::above_zero("--square", &arguments.board.square)?;
    let (picture, lens) = picture(&arguments.of)?;
    let board = chessboard::find(&picture, columns, rows).map_err(|why| refused(&arguments.of, &why.to_string()))?;
    let (scale, plane) =
        Scale::from_board(square, &board, lens.as_ref()).map_err(|why| refused(&arguments.of, &why.to_string()))?;
    let of = format!("{} corners of a chessboard", board.corners.len());
    let share = plane.anisotropy() - 1.0;
    let tilted = (share > ANISOTROPY_MAX).then(|| {
        let tilt = plane.anisotropy().recip().acos().to_degrees();
        format!(
            "the board is tilted by about {tilt:.0}°: a px is {:.1} % longer one way, and the scale that of its middle",
            100.0 * share
        )
    });
    tell(&arguments.of, scale, of, tilted.into_iter().collect())
}

fn picture(of: &ScalePicture) -> Result<(Picture, Option<Lens>), Failure> {
    let lens = of.lens.as_deref().map(words::lens).transpose()?;
    let raw = opened(&of.picture)?;
    if raw.parts().is_some() {
        return Err(refused(of, "a folder, where one picture of the scale is asked for"));
    }
    let picture = pneuval_ingest::formats::pictures::open(&raw)?.map_err(|why| refused(of, &why))?;
    Ok((picture, lens))
}

fn refused(of: &ScalePicture, why: &str) -> Failure {
    IngestError::Unusable {
        place: FilePlace::new(&of.picture.display().to_string(), None, None),
        expected: "a picture that a scale can be taken from".to_owned(),
        found: why.to_owned(),
        next: "take it again as the reason says, or measure a length between two places by hand: `pneuval measure scale length`".to_owned(),
    }
    .into()
}

fn tell(asked: &ScalePicture, scale: Scale, of: String, notes: Vec<String>) -> Result<Outcome, Failure> {
    let (mm_per_px, std_mm) = (1e3 * scale.metre_per_px, 1e3 * scale.std);
    let told = Told { file: asked.picture.display().to_string(), mm_per_px, std_mm, of, notes };
    if asked.json {
        output::print_json(&told)?;
    } else {
        let share = 100.0 * 1.96 * std_mm / mm_per_px;
        // As many digits as the uncertainty has, and two.
        let digits = digits(std_mm, mm_per_px);
        output::print(&format!(
            "{mm_per_px:.digits$} ± {:.digits$} mm per px ({share:.3} %), of {}\n\nscale = {{ value = {mm_per_px:.digits$}, unit = \"mm\", std = {std_mm:.digits$} }}\n",
            1.96 * std_mm,
            told.of
        ))?;
        told.notes.iter().for_each(|note| output::tell(&format!("note: {note}")));
    }
    Ok(Outcome::Expected)
}

/// Decimals of a value of which the standard uncertainty is told by two digits.
fn digits(std: f64, value: f64) -> usize {
    let smallest = if std > 0.0 { std } else { 1e-6 * value };
    // Between 0 and 12 by what stands before it.
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
    let digits = (1.0 - smallest.log10().floor()).clamp(0.0, 12.0) as usize;
    digits
}
