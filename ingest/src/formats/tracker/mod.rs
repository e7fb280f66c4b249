//! Position trackers: trakSTAR logs and the sequence files of the PLUS toolkit.

pub mod plus;
pub mod trakstar;
mod write;

pub use write::{write_plus, write_trakstar};

/// What is known about a tracker's log beforehand.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct TrackerOptions {
    /// The largest quality number at which a trakSTAR's pose is used: 0 is undisturbed, 32767 the worst. Without it every pose is.
    pub quality_max: Option<u32>,
}

/// Angles in degrees without their jumps: a step of more than half a circle is taken for one the other way round. Holes stay, and a
/// step across them counts as any other. Nothing calls it unasked: what a tracker writes is left as written.
///
/// ```
/// use pneuval_ingest::formats::tracker::unwrap_deg;
/// assert_eq!(unwrap_deg(&[170.0, -175.0, -160.0, 175.0]), [170.0, 185.0, 200.0, 175.0]);
/// ```
pub fn unwrap_deg(angles_deg: &[f64]) -> Vec<f64> {
    let mut before: Option<f64> = None;
    let mut turns = 0.0;
    let unwrapped = angles_deg.iter().map(|angle| {
        if angle.is_finite() {
            if let Some(before) = before {
                turns -= ((angle - before) / 360.0).round();
            }
            before = Some(*angle);
        }
        angle + 360.0 * turns
    });
    unwrapped.collect()
}
