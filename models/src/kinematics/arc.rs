//! The arc kit: a straight chord of length h that bulges to a circular arc of half-angle t.
//!
//! ```text
//! stretch   l(t) = t / sin t          dl/dt = (sin t - t cos t) / sin² t
//! sagitta   s(t) = (h/2) tan(t/2)     radius ρ = h / (2 sin t)
//! area      A(t) = ρ² (t - sin t cos t)      dA/dt = 2 ρ² (1 - t cot t)
//! ```
//!
//! | symbol | unit | domain | meaning |
//! |---|---|---|---|
//! | t | rad | `0 <= t < π` | half the angle the arc subtends at its centre |
//! | h | m | > 0 | chord: the flat, unloaded length |
//!
//! # Source
//! internal-support, section "Theoretical Model" (λ_c = θ / sin θ); dual-chamber-finger, Eq. 10 and 16.
//! # Numerics
//! Everything is written with `sin t / t`, `(t - sin t) / t³` and `(sin t - t cos t) / t³`, which are evaluated by their
//! series where subtraction would cancel: the limits at t = 0 are exact, with no epsilon.
//! # Check value
//! Half circle, t = π/2, h = 2 m: stretch π/2, sagitta 1 m, radius 1 m, area π/2 m².
//! ```
//! use pneuval_models::kinematics::arc;
//! use std::f64::consts::FRAC_PI_2;
//! assert!((1.0 + arc::stretch_excess(FRAC_PI_2) - FRAC_PI_2).abs() < 1e-15);
//! assert!((arc::sagitta_m(2.0, FRAC_PI_2) - 1.0).abs() < 1e-15);
//! assert!((arc::radius_m(2.0, FRAC_PI_2) - 1.0).abs() < 1e-15);
//! assert!((arc::segment_area_m2(2.0, FRAC_PI_2) - FRAC_PI_2).abs() < 1e-15);
//! assert_eq!(arc::stretch_excess(0.0), 0.0);
//! ```

/// `sin x / x`, 1 at x = 0.
pub fn sinc(x: f64) -> f64 {
    if x == 0.0 { 1.0 } else { x.sin() / x }
}

/// Sum of an alternating power series in x²: `first · (1 - x²/d(1) · (1 - x²/d(2) · …))`.
fn series(x: f64, first: f64, divisor: impl Fn(f64) -> f64) -> f64 {
    let (mut term, mut sum, mut k) = (first, first, 1.0);
    while term.abs() > f64::EPSILON * 0.1 * sum.abs() {
        term *= -x * x / divisor(k);
        sum += term;
        k += 1.0;
    }
    sum
}

/// Below this the series lose nothing and the subtraction would; above it the subtraction is exact enough.
const SERIES_BELOW: f64 = 1.0;

/// `(x - sin x) / x³`, 1/6 at x = 0.
fn cubic_defect_of_sine(x: f64) -> f64 {
    if x.abs() < SERIES_BELOW {
        series(x, 1.0 / 6.0, |k| (2.0 * k + 2.0) * (2.0 * k + 3.0))
    } else {
        (x - x.sin()) / x.powi(3)
    }
}

/// `(sin x - x cos x) / x³`, 1/3 at x = 0.
fn cubic_defect_of_slope(x: f64) -> f64 {
    if x.abs() < SERIES_BELOW {
        series(x, 1.0 / 3.0, |k| 2.0 * k * (2.0 * k + 3.0))
    } else {
        (x.sin() - x * x.cos()) / x.powi(3)
    }
}

/// `1 - sin x / x`, accurate to the last digits also near x = 0, where it is exactly 0.
pub fn sinc_defect(x: f64) -> f64 {
    x * x * cubic_defect_of_sine(x)
}

/// Stretch minus one, `t / sin t - 1`, accurate to the last digits also near t = 0.
pub fn stretch_excess(half_angle_rad: f64) -> f64 {
    let t = half_angle_rad;
    t * t * cubic_defect_of_sine(t) / sinc(t)
}

/// Slope of the stretch, `dl/dt = (sin t - t cos t) / sin² t` in 1/rad.
pub fn stretch_slope(half_angle_rad: f64) -> f64 {
    let t = half_angle_rad;
    t * cubic_defect_of_slope(t) / sinc(t).powi(2)
}

/// Height of the bulge over the chord, `(h/2) tan(t/2)` in m.
pub fn sagitta_m(chord_m: f64, half_angle_rad: f64) -> f64 {
    0.5 * chord_m * (0.5 * half_angle_rad).tan()
}

/// Half-angle of the arc with a given sagitta, `2 atan(2 s / h)` in rad: the inverse of [`sagitta_m`].
pub fn half_angle_from_sagitta_rad(chord_m: f64, sagitta_m: f64) -> f64 {
    2.0 * (2.0 * sagitta_m / chord_m).atan()
}

/// Radius of the arc, `h / (2 sin t)` in m; infinite at t = 0.
pub fn radius_m(chord_m: f64, half_angle_rad: f64) -> f64 {
    chord_m / (2.0 * half_angle_rad.sin())
}

/// Area between arc and chord, `ρ² (t - sin t cos t)` in m².
pub fn segment_area_m2(chord_m: f64, half_angle_rad: f64) -> f64 {
    let t = half_angle_rad;
    chord_m.powi(2) * t * cubic_defect_of_sine(2.0 * t) / sinc(t).powi(2)
}

/// Slope of the segment area, `dA/dt = 2 ρ² (1 - t cot t)` in m²/rad.
pub fn segment_area_slope_m2(chord_m: f64, half_angle_rad: f64) -> f64 {
    let t = half_angle_rad;
    0.5 * chord_m.powi(2) * cubic_defect_of_slope(t) / sinc(t).powi(3)
}
