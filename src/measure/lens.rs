//! `pneuval measure lens`: a lens from pictures of a chessboard.

use std::fmt::Write as _;

use rayon::prelude::*;
use serde::Serialize;

use pneuval_ingest::IngestError;
use pneuval_ingest::camera::calibrate::{Calibration, Free, View, calibrate};
use pneuval_ingest::camera::{chessboard, opencv};
use pneuval_ingest::error::Place;
use pneuval_ingest::formats::pictures::{open, pictures};
use pneuval_ingest::raw::RawFile;

use super::arguments::MeasureLens;
use super::{Progress, opened, words};
use crate::exit::{Failure, Outcome};
use crate::{output, table};

/// A calibration, for `--json`.
#[derive(Serialize)]
struct Told {
    size_px: (usize, usize),
    focal_px: [Number; 2],
    centre_px: [Number; 2],
    radial: [Number; 3],
    tangential: [Number; 2],
    rms_px: f64,
    mean_px: f64,
    worst_px: f64,
    pictures: Vec<PictureTold>,
}

#[derive(Serialize)]
struct Number {
    value: f64,
    std: f64,
}

#[derive(Serialize)]
struct PictureTold {
    file: String,
    /// Between its corners and where the lens puts them.
    mean_px: Option<f64>,
    worst_px: Option<f64>,
    refused: Option<String>,
}

/// What was found in a picture: its size and the corners, or why there are none.
type Seen = Result<((usize, usize), View), String>;

pub fn run(arguments: &MeasureLens) -> Result<Outcome, Failure> {
    let (columns, rows) = words::corners(&arguments.board.corners)?;
    let square = words::above_zero("--square", &arguments.board.square)?;
    let raws: Vec<RawFile> = arguments.pictures.iter().map(|path| opened(path)).collect::<Result<_, _>>()?;
    let all: Vec<&RawFile> = raws.iter().flat_map(|raw| pictures(raw)).collect();
    let progress = Progress::new(all.len());
    let seen = |raw: &&RawFile| -> Result<Seen, IngestError> {
        let picture = open(raw)?;
        let board = picture.and_then(|picture| {
            let board = chessboard::find(&picture, columns, rows).map_err(|why| why.to_string())?;
            let corners = board.with_squares(square.metre);
            Ok(((picture.width(), picture.height()), View { corners }))
        });
        progress.step();
        Ok(board)
    };
    let mut seen: Vec<Seen> = all.par_iter().map(seen).collect::<Result<_, _>>()?;
    progress.end();
    let size = seen.iter().find_map(|seen| Some(seen.as_ref().ok()?.0)).unwrap_or((0, 0));
    for one in &mut seen {
        if let Some(other) = one.as_ref().ok().map(|(other, _)| *other).filter(|other| *other != size) {
            *one = Err(format!("{} × {} px, where the first has {} × {}", other.0, other.1, size.0, size.1));
        }
    }
    let views: Vec<View> = seen.iter().flatten().map(|(_, view)| view.clone()).collect();
    let unusable = |found: String| {
        IngestError::Unusable {
        place: Place::new(&arguments.pictures[0].display().to_string(), None, None),
        expected: format!("pictures of a chessboard with {columns} by {rows} inner corners, tilted in different ways"),
        found,
        next: "take more pictures, the whole board in each, at tilts of 20 to 40 degrees; count inner corners, not squares".to_owned(),
    }
    };
    let why = |seen: &Seen| seen.as_ref().err().cloned();
    if views.is_empty() {
        let found = all.iter().zip(&seen).find_map(|(raw, seen)| Some(format!("{}: {}", raw.name(), why(seen)?)));
        return Err(unusable(found.unwrap_or_else(|| "no picture".to_owned())).into());
    }
    let found = calibrate(&views, size, Free::default()).map_err(|error| unusable(error.to_string()))?;
    let mut left = found.of_pictures.iter();
    let told = all.iter().zip(&seen).map(|(raw, seen)| {
        let of = if seen.is_ok() { left.next() } else { None };
        PictureTold {
            file: raw.name().to_owned(),
            mean_px: of.map(|r| r.mean_px),
            worst_px: of.map(|r| r.worst_px),
            refused: why(seen),
        }
    });
    let told = told_of(&found, size, told.collect());
    if let Some(out) = &arguments.out {
        let yaml = opencv::write(&found.lens, size, found.reprojection.rms_px);
        std::fs::write(out, yaml).map_err(|source| IngestError::write(out, source))?;
    }
    if arguments.json {
        output::print_json(&told)?;
    } else {
        output::print(&text(&told))?;
    }
    Ok(if seen.iter().all(Result::is_ok) { Outcome::Expected } else { Outcome::Open })
}

fn told_of(found: &Calibration, size_px: (usize, usize), pictures: Vec<PictureTold>) -> Told {
    let (lens, std) = (&found.lens, &found.std);
    let number = |value: f64, std: f64| Number { value, std };
    Told {
        size_px,
        focal_px: [0, 1].map(|i| number(lens.focal_px[i], std.focal_px[i])),
        centre_px: [0, 1].map(|i| number(lens.centre_px[i], std.centre_px[i])),
        radial: [0, 1, 2].map(|i| number(lens.radial[i], std.radial[i])),
        tangential: [0, 1].map(|i| number(lens.tangential[i], std.tangential[i])),
        rms_px: found.reprojection.rms_px,
        mean_px: found.reprojection.mean_px,
        worst_px: found.reprojection.worst_px,
        pictures,
    }
}

fn text(told: &Told) -> String {
    let mut pictures = table::plain(&["picture", "mean (px)", "worst (px)", "notes"], &[1, 2]);
    for one in &told.pictures {
        let px = |value: Option<f64>| value.map_or("–".to_owned(), |v| format!("{v:.3}"));
        pictures.add_row([
            one.file.clone(),
            px(one.mean_px),
            px(one.worst_px),
            one.refused.clone().unwrap_or_default(),
        ]);
    }
    table::fit(&mut pictures);
    let mut text = format!("{pictures}\n\n");
    let mut line = |name: &str, numbers: &[Number], digits: usize| {
        let each: Vec<String> =
            numbers.iter().map(|n| format!("{:.digits$} ± {:.digits$}", n.value, 1.96 * n.std)).collect();
        // Writing to a string does not fail.
        let _ = writeln!(text, "{name:<22}{}", each.join(", "));
    };
    line("focal lengths (px)", &told.focal_px, 3);
    line("centre (px)", &told.centre_px, 3);
    line("radial k1, k2, k3", &told.radial, 5);
    line("tangential p1, p2", &told.tangential, 5);
    let list = |numbers: &[Number], digits: usize| {
        numbers.iter().map(|n| format!("{:.digits$}", n.value)).collect::<Vec<_>>().join(", ")
    };
    let used = told.pictures.iter().filter(|p| p.refused.is_none()).count();
    let _ = write!(
        text,
        "corners lie {:.3} px from where this lens puts them, in the mean of {used} pictures (root mean square {:.3}, worst {:.3})\n\n\
         lens = {{ focal = [{}], centre = [{}], radial = [{}], tangential = [{}] }}\n",
        told.mean_px,
        told.rms_px,
        told.worst_px,
        list(&told.focal_px, 4),
        list(&told.centre_px, 4),
        list(&told.radial, 7),
        list(&told.tangential, 7)
    );
    text
}
