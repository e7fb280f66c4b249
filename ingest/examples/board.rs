//! Calibrates a camera on pictures of a chessboard, and prints what `OpenCV` can check, as JSON:
//! `cargo run --release -p pneuval-ingest --example board -- COLUMNS ROWS PICTURE..` (inner corners; squares of one).

// A tool for those who check the calibration: a panic is its error message.
#![allow(clippy::unwrap_used)]

use std::path::Path;

use pneuval_ingest::camera::calibrate::{Free, View, calibrate};
use pneuval_ingest::camera::chessboard::find;
use pneuval_ingest::camera::decode::decode;
use serde_json::json;

fn main() {
    let mut arguments = std::env::args().skip(1);
    let mut number = || -> usize { arguments.next().unwrap().parse().unwrap() };
    let (columns, rows) = (number(), number());
    let (mut views, mut pictures, mut size) = (Vec::new(), Vec::new(), (0, 0));
    for file in arguments {
        let picture = decode(&std::fs::read(&file).unwrap()).unwrap();
        size = (picture.width(), picture.height());
        let board = find(&picture, columns, rows).unwrap();
        let corners: Vec<[f64; 2]> = board.corners.iter().map(|corner| [corner.at.x, corner.at.y]).collect();
        pictures.push(json!({ "file": Path::new(&file).file_name().unwrap().to_str(), "corners": corners }));
        views.push(View { corners: board.with_squares(1.0) });
    }
    let found = calibrate(&views, size, Free::default()).unwrap();
    let (lens, reprojection) = (found.lens, found.reprojection);
    let told = json!({
        "columns": columns, "rows": rows,
        "focal_px": [lens.focal_px.x, lens.focal_px.y], "centre_px": [lens.centre_px.x, lens.centre_px.y],
        "radial": lens.radial, "tangential": lens.tangential,
        "rms_px": reprojection.rms_px, "mean_px": reprojection.mean_px, "pictures": pictures,
    });
    println!("{told}");
}
