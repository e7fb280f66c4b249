//! Lengths, places and files of a command line.

use std::path::Path;

use pneuval_ingest::camera::lens::Lens;
use pneuval_ingest::camera::opencv;
use pneuval_ingest::camera::picture::Place;
use pneuval_ingest::camera::scale::{Length, Scale};
use pneuval_ingest::camera::silhouette::{Axis, Sought};
use pneuval_ingest::camera::task::Setup;
use pneuval_ingest::formats::pictures::names::Pattern;
use pneuval_ingest::limits;
use pneuval_ingest::units::{Dimension, Unit};

use super::arguments::{AxisArgument, BodyArgument, Camera};
use crate::exit::Failure;

/// Camera, scale and where the body is.
pub fn setup(camera: &Camera, axis: Option<AxisArgument>) -> Result<Setup, Failure> {
    let above = |flag, text: &Option<String>| text.as_deref().map(|text| above_zero(flag, text)).transpose();
    Ok(Setup {
        sought: Sought {
            axis: axis.map(|axis| match axis {
                AxisArgument::Vertical => Axis::Vertical,
                AxisArgument::Horizontal => Axis::Horizontal,
            }),
            is_dark: camera.body.map(|body| matches!(body, BodyArgument::Dark)),
            region: camera.region.as_deref().map(region).transpose()?,
        },
        scale: above("--scale", &camera.scale)?.map(|l| Scale { metre_per_px: l.metre, std: l.std }),
        lens: camera.lens.as_deref().map(lens).transpose()?,
        distance: above("--distance", &camera.distance)?,
        offset_m: camera.offset.as_deref().map(|text| length("--offset", text)).transpose()?,
    })
}

/// A length above zero and above its standard uncertainty.
pub fn above_zero(flag: &'static str, text: &str) -> Result<Length, Failure> {
    let (metre, std) = length(flag, text)?;
    let expected = "a length above zero and above its uncertainty";
    (metre > 0.0 && std < metre).then_some(Length { metre, std }).ok_or_else(|| bad(flag, text, expected))
}

/// `120,400`: a place in px.
pub fn place(flag: &'static str, text: &str) -> Result<Place, Failure> {
    let numbers: Option<Vec<f64>> = text.split(',').map(|n| n.trim().parse().ok()).collect();
    match numbers.as_deref() {
        Some([x, y]) if x.is_finite() && y.is_finite() => Ok(Place::new(*x, *y)),
        _ => Err(Failure::Flag {
            flag,
            found: format!("`{text}`"),
            expected: "a place in px: x to the right, y down, from the middle of the first pixel".to_owned(),
            next: "write it as 120,400".to_owned(),
        }),
    }
}

/// `9x6`: inner corners in a row, and rows.
pub fn corners(text: &str) -> Result<(usize, usize), Failure> {
    let pair = text.split_once(['x', '×']).and_then(|(a, b)| Some((a.trim().parse().ok()?, b.trim().parse().ok()?)));
    pair.ok_or_else(|| Failure::Flag {
        flag: "--corners",
        found: format!("`{text}`"),
        expected: "inner corners in a row and rows of them: a board of 10 by 7 squares has 9x6".to_owned(),
        next: "write it as 9x6".to_owned(),
    })
}

/// `300,0,450,140`
pub fn region(text: &str) -> Result<[usize; 4], Failure> {
    let numbers: Option<Vec<usize>> = text.split(',').map(|n| n.trim().parse().ok()).collect();
    numbers.and_then(|n| n.try_into().ok()).ok_or_else(|| Failure::Flag {
        flag: "--region",
        found: format!("`{text}`"),
        expected: "left, top, width and height in px".to_owned(),
        next: "write it as 300,0,450,140".to_owned(),
    })
}

pub fn lens(path: &Path) -> Result<Lens, Failure> {
    let bytes = limits::read(path, limits::WRITTEN_BYTES_MAX)?;
    let text = String::from_utf8_lossy(&bytes);
    let calibrated = opencv::read(&text, None).map_err(|why| Failure::Flag {
        flag: "--lens",
        found: format!("{}: {why}", path.display()),
        expected: "a calibration as OpenCV or ROS writes it in YAML".to_owned(),
        next: "correct the file, or calibrate again".to_owned(),
    })?;
    Ok(calibrated.lens)
}

fn bad(flag: &'static str, found: &str, expected: &str) -> Failure {
    Failure::Flag {
        flag,
        found: format!("`{found}`"),
        expected: expected.to_owned(),
        next: "write it as 300mm, or 300mm+-1 with its standard uncertainty".to_owned(),
    }
}

/// `300mm`, `300 mm ± 1`, `300mm+-1`: value and standard uncertainty in m.
fn length(flag: &'static str, text: &str) -> Result<(f64, f64), Failure> {
    let expected = "a number, a unit of length, and its standard uncertainty in the same unit behind `+-`";
    let refused = || bad(flag, text, expected);
    let (value, std) = match text.split_once("+-").or_else(|| text.split_once('±')) {
        Some((value, std)) => (value, std.trim().parse::<f64>().map_err(|_| refused())?),
        None => (text, 0.0),
    };
    let value = value.trim();
    let split = value.find(|c: char| c.is_alphabetic() || c == 'µ').ok_or_else(refused)?;
    let number: f64 = value[..split].trim().parse().map_err(|_| refused())?;
    let unit =
        Unit::parse(value[split..].trim()).filter(|unit| unit.dimension == Dimension::Length).ok_or_else(refused)?;
    let sound = number.is_finite() && std.is_finite() && std >= 0.0;
    sound.then(|| (unit.to_si(number), unit.to_si(std))).ok_or_else(refused)
}

pub fn names(text: &str) -> Result<Pattern, Failure> {
    Pattern::parse(text).map_err(|why| Failure::Flag {
        flag: "--names",
        found: format!("`{text}`: {why}"),
        expected: "names with numbers in braces".to_owned(),
        next: "write it as 'p{pressure:kPa}_{n}.png'".to_owned(),
    })
}
