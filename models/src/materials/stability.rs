//! Where the stress of a law rises with the stretch.

use crate::ModelError;

/// A scan steps by this share of the stretch; a dip narrower than that is not seen.
const STEP: f64 = 1.001;

/// The stretches round 1 over which the nominal stress rises in a load case.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StableRange {
    /// The end in compression, at most 1.
    pub min: StableEnd,
    /// The end in tension, at least 1.
    pub max: StableEnd,
}

/// One end of a stable range.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StableEnd {
    /// The first stretch, seen from 1, that is no longer stable; or the last one asked for.
    pub stretch: f64,
    /// Why the range ends there.
    pub why: EndReason,
}

/// Why a stable range ends.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum EndReason {
    /// Nobody asked beyond it: stable up to there at least.
    AsFarAsAsked,
    /// The stress stops rising.
    Unstable,
    /// The law ends, as a Gent law does where its chains are fully stretched.
    OutOfDomain,
}

/// The stable range round 1 of a tangent, between two stretches.
///
/// # Errors
/// [`ModelError::OutOfDomain`] unless `0 < stretch_min <= 1 <= stretch_max`, both finite; the tangent's own at
/// stretch 1.
pub(super) fn stable_range(
    tangent_pa: &dyn Fn(f64) -> Result<f64, ModelError>,
    stretch_min: f64,
    stretch_max: f64,
) -> Result<StableRange, ModelError> {
    if !(stretch_min > 0.0 && stretch_min <= 1.0) {
        return Err(ModelError::OutOfDomain { symbol: "stretch_min", value: stretch_min, domain: "> 0 and <= 1" });
    }
    if !(stretch_max.is_finite() && stretch_max >= 1.0) {
        return Err(ModelError::OutOfDomain { symbol: "stretch_max", value: stretch_max, domain: "finite and >= 1" });
    }
    tangent_pa(1.0)?;
    Ok(StableRange { min: walk(tangent_pa, stretch_min, 1.0 / STEP), max: walk(tangent_pa, stretch_max, STEP) })
}

/// From stretch 1 towards `end` by steps of `factor`, then by halves to the stretch where stability is lost.
fn walk(tangent_pa: &dyn Fn(f64) -> Result<f64, ModelError>, end: f64, factor: f64) -> StableEnd {
    let stable = |stretch: f64| tangent_pa(stretch).is_ok_and(|tangent| tangent > 0.0);
    let (mut inside, mut at_end) = (1.0, false);
    while !at_end {
        let next = inside * factor;
        at_end = if factor > 1.0 { next >= end } else { next <= end };
        let mut outside = if at_end { end } else { next };
        if stable(outside) {
            inside = outside;
            continue;
        }
        // A step is a thousandth: sixty halves leave less than its last digit.
        for _ in 0..60 {
            let middle = 0.5 * (inside + outside);
            if stable(middle) {
                inside = middle;
            } else {
                outside = middle;
            }
        }
        let why = if tangent_pa(outside).is_ok() { EndReason::Unstable } else { EndReason::OutOfDomain };
        return StableEnd { stretch: outside, why };
    }
    StableEnd { stretch: end, why: EndReason::AsFarAsAsked }
}
