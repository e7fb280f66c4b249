//! A lens as `OpenCV`'s `FileStorage` writes it.

use crate::camera::lens::Lens;

/// The text of a calibration that [`read`](super::read) and `OpenCV` read: matrix and k1, k2, p1, p2, k3, each number with all its digits.
///
/// ```
/// use pneuval_ingest::camera::lens::Lens;
/// use pneuval_ingest::camera::opencv::{read, write};
/// use pneuval_ingest::camera::picture::Place;
/// let lens = Lens { radial: [-0.2654, 0.1 / 3.0, 0.0], ..Lens::pinhole(536.07, Place::new(342.37, 235.54)) };
/// let back = read(&write(&lens, (640, 480), 0.2), None)?;
/// assert_eq!((back.lens, back.size_px), (lens, Some((640, 480))));
/// # Ok::<(), pneuval_ingest::camera::opencv::OpenCvError>(())
/// ```
pub fn write(lens: &Lens, (width, height): (usize, usize), rms_px: f64) -> String {
    let Lens { focal_px: f, centre_px: c, radial: [k1, k2, k3], tangential: [p1, p2] } = lens;
    // With an exponent, or `0` would be a whole number there.
    let list = |numbers: &[f64]| numbers.iter().map(|v| format!("{v:e}")).collect::<Vec<_>>().join(", ");
    let matrix = list(&[f.x, 0.0, c.x, 0.0, f.y, c.y, 0.0, 0.0, 1.0]);
    let distortion = list(&[*k1, *k2, *p1, *p2, *k3]);
    format!(
        "%YAML:1.0\n---\nimage_width: {width}\nimage_height: {height}\n\
         camera_matrix: !!opencv-matrix\n   rows: 3\n   cols: 3\n   dt: d\n   data: [ {matrix} ]\n\
         distortion_coefficients: !!opencv-matrix\n   rows: 1\n   cols: 5\n   dt: d\n   data: [ {distortion} ]\n\
         avg_reprojection_error: {rms_px:e}\n"
    )
}
