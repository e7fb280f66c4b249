//! Bracketed roots, and the physical branch of a pressure curve.
//!
//! The papers' models give pressure as a function of a shape angle, p(t). What a user asks for is the inverse, the shape at a
//! given pressure, on the branch that starts at the undeformed state and rises: [`Branch`] traces that branch once and
//! then solves on it in both directions.

use crate::error::{BranchEnd, ModelError};

/// Pressure and quantity along one shape parameter (the *state*), 0 at the undeformed shape.
pub trait Curve: Send + Sync {
    /// Where the state's range ends, in rad.
    fn state_end_rad(&self) -> f64;
    /// Gauge pressure that holds the state, in Pa.
    fn pressure_gauge_pa(&self, state_rad: f64) -> f64;
    /// The measured quantity at the state, in SI units; rises strictly with the state.
    fn quantity(&self, state_rad: f64) -> f64;
}

/// The rising branch of a [`Curve`] from the undeformed state to its first turning point or the end of its range.
///
/// The turning point is looked for on 512 steps of the state, then refined to about 1e-12 of it; a dip narrower than a step is
/// not seen.
pub struct Branch {
    curve: Box<dyn Curve>,
    start_gauge_pa: f64,
    limit_gauge_pa: f64,
    limit_state_rad: f64,
    end: BranchEnd,
}

/// Steps on which a turning point is looked for.
const TRACE_STEPS: u32 = 512;

impl Branch {
    /// Follows a curve from the undeformed state for as long as the pressure rises.
    ///
    /// # Errors
    /// [`ModelError::OutOfDomain`] if the pressure is not a number somewhere along the way.
    pub fn trace(curve: Box<dyn Curve>) -> Result<Self, ModelError> {
        let state_end_rad = curve.state_end_rad();
        let step = state_end_rad / f64::from(TRACE_STEPS);
        let start_gauge_pa = curve.pressure_gauge_pa(0.0);
        let (mut limit_gauge_pa, mut limit_state_rad, mut end) = (start_gauge_pa, 0.0, BranchEnd::EndOfRange);
        for i in 1..=TRACE_STEPS {
            let state = step * f64::from(i);
            let pressure = curve.pressure_gauge_pa(state);
            if pressure.is_nan() {
                return Err(ModelError::OutOfDomain {
                    symbol: "state",
                    value: state,
                    domain: "where the pressure is a number",
                });
            }
            if pressure <= limit_gauge_pa {
                let top = golden_maximum(&*curve, (limit_state_rad - step).max(0.0), state);
                if top.1 > start_gauge_pa {
                    (limit_state_rad, limit_gauge_pa) = top;
                    end = BranchEnd::TurnsOver;
                } else {
                    end = BranchEnd::FallsFromStart;
                }
                break;
            }
            (limit_gauge_pa, limit_state_rad) = (pressure, state);
        }
        Ok(Self { curve, start_gauge_pa, limit_gauge_pa, limit_state_rad, end })
    }

    /// The largest gauge pressure on the branch, in Pa.
    pub fn limit_gauge_pa(&self) -> f64 {
        self.limit_gauge_pa
    }

    /// Why the branch ends.
    pub fn end(&self) -> BranchEnd {
        self.end
    }

    /// The quantity at the undeformed state and at the end of the branch, SI units.
    pub fn reach(&self) -> (f64, f64) {
        (self.curve.quantity(0.0), self.curve.quantity(self.limit_state_rad))
    }

    /// The state at a gauge pressure.
    ///
    /// # Errors
    /// [`ModelError::OutOfDomain`] for a negative or non-finite pressure, [`ModelError::BelowStart`] and
    /// [`ModelError::BeyondLimit`] where the branch has no solution.
    pub fn state_rad(&self, pressure_gauge_pa: f64) -> Result<f64, ModelError> {
        let p = pressure_gauge_pa;
        if !p.is_finite() || p < 0.0 {
            return Err(ModelError::OutOfDomain { symbol: "gauge pressure", value: p, domain: "finite and >= 0 Pa" });
        }
        if p < self.start_gauge_pa {
            return Err(ModelError::BelowStart { pressure_gauge_pa: p, start_gauge_pa: self.start_gauge_pa });
        }
        if p > self.limit_gauge_pa {
            return Err(ModelError::BeyondLimit {
                pressure_gauge_pa: p,
                limit_gauge_pa: self.limit_gauge_pa,
                end: self.end,
            });
        }
        brent(|t| self.curve.pressure_gauge_pa(t) - p, 0.0, self.limit_state_rad)
    }

    /// The quantity at a gauge pressure, SI units.
    ///
    /// # Errors
    /// As [`Branch::state_rad`].
    pub fn quantity(&self, pressure_gauge_pa: f64) -> Result<f64, ModelError> {
        Ok(self.curve.quantity(self.state_rad(pressure_gauge_pa)?))
    }

    /// The gauge pressure at which the quantity has a value: the inverse of [`Branch::quantity`].
    ///
    /// # Errors
    /// [`ModelError::OutOfReach`] if no state of the branch has it.
    pub fn pressure_gauge_pa(&self, quantity: f64) -> Result<f64, ModelError> {
        let (reach_min, reach_max) = self.reach();
        // A positive condition, so that NaN is refused too.
        if !(quantity >= reach_min && quantity <= reach_max) {
            return Err(ModelError::OutOfReach { value: quantity, reach_min, reach_max });
        }
        let state = brent(|t| self.curve.quantity(t) - quantity, 0.0, self.limit_state_rad)?;
        Ok(self.curve.pressure_gauge_pa(state))
    }
}

/// Maximum of the pressure in `[low, high]` by golden-section search: `(state, pressure)`.
fn golden_maximum(curve: &dyn Curve, mut low: f64, mut high: f64) -> (f64, f64) {
    let golden = 0.5 * (5.0_f64.sqrt() - 1.0);
    // Each step shrinks the interval by 0.618; 60 of them reach the last digits of any starting step.
    for _ in 0..60 {
        let a = high - golden * (high - low);
        let b = low + golden * (high - low);
        if curve.pressure_gauge_pa(a) < curve.pressure_gauge_pa(b) {
            low = a;
        } else {
            high = b;
        }
    }
    let state = 0.5 * (low + high);
    (state, curve.pressure_gauge_pa(state))
}

/// A root of `f` between `low` and `high`, to the last digits of the root.
///
/// Brent (1973), chapter 4: inverse quadratic interpolation and secant steps, kept safe by bisection. The bracket may end
/// exactly on the root.
///
/// # Errors
/// [`ModelError::NoBracket`] if `f` has the same sign at both ends or is not a number there.
///
/// ```
/// let root = pneuval_models::solve::brent(|x| x * x - 2.0, 0.0, 2.0)?;
/// assert!((root - std::f64::consts::SQRT_2).abs() < 1e-15);
/// # Ok::<(), pneuval_models::ModelError>(())
/// ```
// Brent's method compares ends that it has copied from one another.
#[allow(clippy::float_cmp)]
pub fn brent(f: impl Fn(f64) -> f64, low: f64, high: f64) -> Result<f64, ModelError> {
    const ITERATIONS: usize = 200;
    let (mut a, mut b) = (low, high);
    let (mut fa, mut fb) = (f(a), f(b));
    if fa == 0.0 {
        return Ok(a);
    }
    if fb == 0.0 {
        return Ok(b);
    }
    if fa.is_nan() || fb.is_nan() || fa.signum() == fb.signum() {
        return Err(ModelError::NoBracket { low, high, f_low: fa, f_high: fb });
    }
    let (mut c, mut fc) = (a, fa);
    let mut step = b - a;
    let mut step_before = step;
    for _ in 0..ITERATIONS {
        if fc.abs() < fb.abs() {
            (a, b, c) = (b, c, b);
            (fa, fb, fc) = (fb, fc, fb);
        }
        let tolerance = 2.0 * f64::EPSILON * b.abs() + f64::MIN_POSITIVE;
        let half = 0.5 * (c - b);
        if fb == 0.0 || half.abs() <= tolerance {
            return Ok(b);
        }
        if step_before.abs() < tolerance || fa.abs() <= fb.abs() {
            (step, step_before) = (half, half);
        } else {
            let s = fb / fa;
            let (mut p, mut q) = if a == c {
                (2.0 * half * s, 1.0 - s)
            } else {
                let (q, r) = (fa / fc, fb / fc);
                (s * (2.0 * half * q * (q - r) - (b - a) * (r - 1.0)), (q - 1.0) * (r - 1.0) * (s - 1.0))
            };
            if p > 0.0 {
                q = -q;
            } else {
                p = -p;
            }
            if 2.0 * p < (3.0 * half * q - (tolerance * q).abs()).min((step_before * q).abs()) {
                (step_before, step) = (step, p / q);
            } else {
                (step, step_before) = (half, half);
            }
        }
        (a, fa) = (b, fb);
        b += if step.abs() > tolerance { step } else { tolerance.copysign(half) };
        fb = f(b);
        if fb.is_nan() {
            return Err(ModelError::NoBracket { low, high, f_low: fa, f_high: fb });
        }
        if (fb > 0.0) == (fc > 0.0) {
            (c, fc) = (a, fa);
            step = b - a;
            step_before = step;
        }
    }
    Err(ModelError::NotConverged { method: "Brent's method", iterations: ITERATIONS })
}
