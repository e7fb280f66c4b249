//! The lag of a motion behind a pressure: the shift under which the two correlate best.
//!
//! ```text
//! samples --> local straight lines, of one width for both --> a common grid, holes where stamps leave gaps
//!         --> normalised cross-correlation without mean and trend over shifts, coarse, then fine --> its top
//! ```
//!
//! The local lines are as wide as the slower of the two needs: what only the faster one can see is taken out of both, in the same
//! way, so that neither is delayed by it. The top between two shifts is found by least squares (Gauss and Newton): the shift, and the
//! scale, under which the pressure comes nearest to the motion. Its standard uncertainty is that of this fit, from what is left over
//! with its correlation from sample to sample (Newey and West), and a share of a grid step for the resampling.
//!
//! Of a pure delay this is the delay. A motion that follows late and slowly, as a viscoelastic one does, has no single delay: then
//! it is the shift that explains most of it, which lies between the dead time and the dead time with the mean retardation.

use crate::response::GAP_STEPS;
use pneuval_ingest::finding::median_step;

/// Shifts are looked at up to this one either way, in s, and up to a share of the time that both were recorded.
pub const LAG_MAX_S: f64 = 5.0;
const LAG_SHARE_MAX: f64 = 0.25;

/// A correlation below this is none.
pub const CORRELATION_MIN: f64 = 0.7;

/// Another shift that correlates as well as the best one, up to this share, makes the lag ambiguous.
const AS_GOOD: f64 = 0.98;

/// So much lower is the valley between two tops, as a share.
const VALLEY: f64 = 0.02;

/// Points of the coarse and of the fine grid at most.
const COARSE: f64 = 4096.0;
const FINE: f64 = 65536.0;

/// Half the width of the local lines, in steps of the grid.
const LINE_STEPS: f64 = 2.0;

/// The share of a grid step that resampling may cost, as a standard uncertainty.
const RESAMPLING: f64 = 0.02;

/// Rounds of the fit at most, and the step, as a share of that of the grid, below which it stands.
const ROUNDS: usize = 8;
const STANDS: f64 = 1e-6;

/// Fewer samples say nothing.
const SAMPLES_MIN: usize = 8;

/// The share of a value that rounding may leave of nothing.
const ROUNDING: f64 = 1e-12;

/// The lag of a motion behind a pressure.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lag {
    /// Positive: the motion comes later, in s.
    pub value_s: f64,
    /// Standard uncertainty, in s.
    pub std_s: f64,
    /// The correlation there; negative where the motion falls as the pressure rises.
    pub correlation: f64,
    /// Shifts were looked at up to this one either way, in s.
    pub range_s: f64,
    /// The usual step of the slower of the two, in s.
    pub step_s: f64,
}

/// A channel with its stamps.
#[derive(Debug, Clone, Copy)]
pub struct Signal<'a> {
    /// Stamps in s; what is not finite does not count.
    pub seconds: &'a [f64],
    /// Values; what is not finite is a hole.
    pub values: &'a [f64],
}

/// The lag of `motion` behind `pressure`.
///
/// # Errors
/// Why there is none, in words.
pub fn lag(pressure: Signal, motion: Signal) -> Result<Lag, String> {
    let pressure = Samples::of(pressure).ok_or("the pressure has no two stamped samples")?;
    let motion = Samples::of(motion).ok_or("the motion has no two stamped samples")?;
    let (from, to) = (pressure.first().max(motion.first()), pressure.last().min(motion.last()));
    let span = to - from;
    if span.partial_cmp(&0.0) != Some(std::cmp::Ordering::Greater) {
        return Err(format!(
            "no stamps in common: the pressure's reach from {:.3} s to {:.3} s, the motion's from {:.3} s to {:.3} s",
            pressure.first(),
            pressure.last(),
            motion.first(),
            motion.last()
        ));
    }
    let slower = pressure.step_s.max(motion.step_s);
    let range_s = LAG_MAX_S.min(LAG_SHARE_MAX * span);
    if range_s < 4.0 * slower {
        return Err(format!("both were recorded for {span:.3} s only, some {:.0} samples", span / slower));
    }
    let fine = slower.max(span / FINE);
    let coarse = fine.max(span / COARSE);
    let grid = |step_s: f64| {
        let points = count(span / step_s) + 1;
        let on = |samples: &Samples| samples.resampled(from, step_s, points);
        Ok::<_, String>(Pair {
            pressure: centred(on(&pressure), "pressure")?,
            motion: centred(on(&motion), "motion")?,
            step_s,
        })
    };
    let pair = grid(coarse)?;
    let most = nearest((range_s / coarse).floor());
    let all: Vec<(i64, f64)> = (-most..=most).filter_map(|k| Some((k, pair.correlation(k)?))).collect();
    let Some(&(best, peak)) = all.iter().max_by(|a, b| a.1.abs().total_cmp(&b.1.abs())) else {
        return Err("no two samples of both stand in the same stretch".to_owned());
    };
    if peak.abs() < CORRELATION_MIN {
        return Err(format!(
            "the two have nothing in common: no shift up to {range_s:.3} s correlates them by more than {:.2}",
            peak.abs()
        ));
    }
    if best.abs() >= most {
        return Err(format!("they correlate ever better up to the largest shift looked at, {range_s:.3} s"));
    }
    if let Some(other) = rival(&all, best, peak) {
        return Err(format!(
            "shifts of {:.3} s and {:.3} s fit alike: the pressure repeats itself",
            best as f64 * coarse,
            other as f64 * coarse
        ));
    }
    let (pair, start) = if coarse > fine {
        let pair = grid(fine)?;
        let middle = nearest(best as f64 * coarse / fine);
        let reach = nearest((2.0 * coarse / fine).ceil());
        let near = (middle - reach..=middle + reach).filter_map(|k| Some((k, pair.correlation(k)?.abs())));
        let best = near.max_by(|a, b| a.1.total_cmp(&b.1)).map_or(middle, |(k, _)| k);
        (pair, best)
    } else {
        (pair, best)
    };
    let (steps, std_steps) = pair.fitted(start as f64).ok_or("the pressure hardly moves where both were recorded")?;
    let correlation = pair.correlation(nearest(steps)).unwrap_or(peak);
    Ok(Lag {
        value_s: steps * pair.step_s,
        std_s: (std_steps * pair.step_s).hypot(RESAMPLING * pair.step_s),
        correlation,
        range_s,
        step_s: slower,
    })
}

/// Whole steps; grids have far fewer points than this allows.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "within the range of both")]
pub(super) fn count(steps: f64) -> usize {
    steps.floor().clamp(0.0, 1e9) as usize
}

/// The nearest whole number of steps, either way.
#[expect(clippy::cast_possible_truncation, reason = "within the range of both")]
fn nearest(steps: f64) -> i64 {
    steps.round().clamp(-1e9, 1e9) as i64
}

/// Another top that is nearly as high, across a valley.
fn rival(all: &[(i64, f64)], best: i64, peak: f64) -> Option<i64> {
    let at = all.iter().position(|(k, _)| *k == best)?;
    let beyond = |sides: &[(i64, f64)], forward: bool| {
        let mut crossed = false;
        let mut is_rival = |(k, c): &(i64, f64)| {
            let height = c * peak.signum() / peak.abs();
            crossed |= height < AS_GOOD - VALLEY;
            (crossed && height >= AS_GOOD).then_some(*k)
        };
        if forward { sides.iter().find_map(&mut is_rival) } else { sides.iter().rev().find_map(&mut is_rival) }
    };
    beyond(&all[at + 1..], true).or_else(|| beyond(&all[..at], false))
}

/// The samples of a signal that count, in time.
struct Samples {
    seconds: Vec<f64>,
    values: Vec<f64>,
    step_s: f64,
    /// The gaps before each sample, counted from the first.
    gaps: Vec<u32>,
}

impl Samples {
    fn of(signal: Signal) -> Option<Self> {
        let counts = signal.seconds.iter().zip(signal.values).filter(|(t, v)| t.is_finite() && v.is_finite());
        let (seconds, values): (Vec<f64>, Vec<f64>) = counts.map(|(t, v)| (*t, *v)).unzip();
        let step_s = median_step(&seconds)?;
        let is_gap = |pair: &[f64]| u32::from(pair[1] - pair[0] > GAP_STEPS * step_s);
        let mut before = 0;
        let behind = seconds.windows(2).map(|pair| {
            before += is_gap(pair);
            before
        });
        let gaps = std::iter::once(0).chain(behind).collect();
        Some(Self { seconds, values, step_s, gaps })
    }

    fn first(&self) -> f64 {
        self.seconds.first().copied().unwrap_or(f64::NAN)
    }

    fn last(&self) -> f64 {
        self.seconds.last().copied().unwrap_or(f64::NAN)
    }

    /// The values on a grid, by a straight line through the samples around each of its points, weighted by (1 - x²)²; not a
    /// number where there is a gap or fewer than two stamps.
    fn resampled(&self, from_s: f64, step_s: f64, points: usize) -> Vec<f64> {
        let width = LINE_STEPS * step_s;
        let per_width = 1.0 / width;
        let last = self.seconds.len() - 1;
        let (mut begin, mut end) = (0, 0);
        (0..points)
            .map(|i| {
                let at = from_s + i as f64 * step_s;
                while self.seconds.get(begin).is_some_and(|t| *t <= at - width) {
                    begin += 1;
                }
                end = end.max(begin);
                while self.seconds.get(end).is_some_and(|t| *t < at + width) {
                    end += 1;
                }
                // From the sample before the window to the one behind it there is no gap.
                if self.gaps[begin.saturating_sub(1).min(last)] != self.gaps[end.min(last)] {
                    return f64::NAN;
                }
                let (mut s0, mut s1, mut s2, mut v0, mut v1) = (0.0, 0.0, 0.0, 0.0, 0.0);
                for (t, v) in self.seconds[begin..end].iter().zip(&self.values[begin..end]) {
                    let u = t - at;
                    let x = u * per_width;
                    let w = (1.0 - x * x) * (1.0 - x * x);
                    (s0, s1, s2) = (s0 + w, s1 + w * u, s2 + w * u * u);
                    (v0, v1) = (v0 + w * v, v1 + w * u * v);
                }
                let spread = s0 * s2 - s1 * s1;
                if spread > 1e-9 * s0 * s0 * width * width { (s2 * v0 - s1 * v1) / spread } else { f64::NAN }
            })
            .collect()
    }
}

/// Without the mean, which would cost digits.
fn centred(mut values: Vec<f64>, what: &str) -> Result<Vec<f64>, String> {
    let finite = || values.iter().copied().filter(|v| v.is_finite());
    let n = finite().count();
    if n < SAMPLES_MIN {
        return Err(format!("the {what} has {n} samples without gaps around them"));
    }
    let (low, high) = finite().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(v), b.max(v)));
    // What rounding leaves of a constant is no motion.
    if high - low <= ROUNDING * low.abs().max(high.abs()) {
        return Err(format!("the {what} is constant"));
    }
    let mean = finite().sum::<f64>() / n as f64;
    for value in &mut values {
        *value -= mean;
    }
    Ok(values)
}

/// Both on one grid.
struct Pair {
    pressure: Vec<f64>,
    motion: Vec<f64>,
    step_s: f64,
}

impl Pair {
    /// The correlation of the motion with the pressure so many steps before.
    fn correlation(&self, steps: i64) -> Option<f64> {
        let shift = usize::try_from(steps.unsigned_abs()).ok()?;
        let (p, x) = if steps >= 0 {
            (&self.pressure[..], self.motion.get(shift..)?)
        } else {
            (self.pressure.get(shift..)?, &self.motion[..])
        };
        // Sums of 1, t, p, x and of their products, about the middle of the stretch.
        let middle = 0.5 * (p.len().min(x.len()) as f64 - 1.0);
        let mut sums = [0.0; 9];
        for (i, (p, x)) in p.iter().zip(x).enumerate() {
            if p.is_finite() && x.is_finite() {
                let t = i as f64 - middle;
                for (sum, term) in sums.iter_mut().zip([1.0, t, *p, *x, t * t, t * p, t * x, p * p, x * x]) {
                    *sum += term;
                }
            }
        }
        let px: f64 = p.iter().zip(x).map(|(p, x)| p * x).filter(|product| product.is_finite()).sum();
        let [n, st, sp, sx, tt, tp, tx, pp, xx] = sums;
        // A stretch that is mostly gaps says nothing.
        if n < SAMPLES_MIN as f64 || n < 0.5 * p.len().min(x.len()) as f64 {
            return None;
        }
        // Without mean, then without trend.
        let about = |ab: f64, a: f64, b: f64| ab - a * b / n;
        let (ctt, ctp, ctx) = (about(tt, st, st), about(tp, st, sp), about(tx, st, sx));
        let without = |ab: f64, ta: f64, tb: f64| ab - ta * tb / ctt;
        let (vp, vx) = (without(about(pp, sp, sp), ctp, ctp), without(about(xx, sx, sx), ctx, ctx));
        // Constant over the stretch, but for rounding.
        if vp <= ROUNDING * pp || vx <= ROUNDING * xx {
            return None;
        }
        Some(without(about(px, sp, sx), ctp, ctx) / (vp * vx).sqrt())
    }

    /// The pressure between two points of the grid, and its slope for each step, by a cubic through four points.
    fn pressure_at(&self, place: f64) -> Option<(f64, f64)> {
        let (i, u) = (place.floor(), place - place.floor());
        if i < 1.0 || i + 2.0 >= self.pressure.len() as f64 {
            return None;
        }
        let i = count(i);
        let [a, b, c, d] = [self.pressure[i - 1], self.pressure[i], self.pressure[i + 1], self.pressure[i + 2]];
        let (k1, k2, k3) = (0.5 * (c - a), a - 2.5 * b + 2.0 * c - 0.5 * d, 0.5 * (d - a) + 1.5 * (b - c));
        let value = b + u * (k1 + u * (k2 + u * k3));
        let slope = k1 + u * (2.0 * k2 + 3.0 * u * k3);
        (value.is_finite() && slope.is_finite()).then_some((value, slope))
    }

    /// The shift under which the pressure, scaled, with a mean and a trend, comes nearest to the motion, with its standard
    /// uncertainty, in steps.
    fn fitted(&self, start: f64) -> Option<(f64, f64)> {
        let mut lag = start;
        for round in 1..=ROUNDS {
            // Time, pressure, slope and motion.
            let mut rows: Vec<[f64; 4]> = Vec::with_capacity(self.motion.len());
            for (i, x) in self.motion.iter().enumerate().filter(|(_, x)| x.is_finite()) {
                if let Some((p, slope)) = self.pressure_at(i as f64 - lag) {
                    rows.push([i as f64, p, slope, *x]);
                }
            }
            let n = rows.len() as f64;
            for column in 0..4 {
                let mean = rows.iter().map(|row| row[column]).sum::<f64>() / n;
                for row in &mut rows {
                    row[column] -= mean;
                }
            }
            let pressure = dot(&rows, 1, 1);
            let motion = dot(&rows, 3, 3);
            without(&mut rows, 0)?;
            let scale = without(&mut rows, 1)?[3];
            let slopes = dot(&rows, 2, 2);
            if slopes <= ROUNDING * pressure || scale * scale * pressure <= ROUNDING * motion {
                return None;
            }
            // x = scale p(i - lag): a longer lag adds -scale p'.
            let by = -dot(&rows, 2, 3) / (scale * slopes);
            lag += by.clamp(-1.0, 1.0);
            if by.abs() < STANDS || round == ROUNDS {
                let left: Vec<f64> = rows.iter().map(|row| row[2] * (row[3] + scale * by * row[2])).collect();
                let std = long_run(&left).sqrt() / (scale.abs() * slopes);
                return (lag.is_finite() && std.is_finite()).then_some((lag, std));
            }
        }
        None
    }
}

fn dot(rows: &[[f64; 4]], a: usize, b: usize) -> f64 {
    rows.iter().map(|row| row[a] * row[b]).sum()
}

/// Takes out of the columns behind one what that one explains. Gives the factors; `None` if it is constant.
fn without(rows: &mut [[f64; 4]], column: usize) -> Option<[f64; 4]> {
    let size = dot(rows, column, column);
    if size.partial_cmp(&0.0) != Some(std::cmp::Ordering::Greater) {
        return None;
    }
    let mut factors = [0.0; 4];
    for other in column + 1..4 {
        factors[other] = dot(rows, column, other) / size;
        for row in &mut *rows {
            row[other] -= factors[other] * row[column];
        }
    }
    Some(factors)
}

/// The variance of a sum of terms that depend on their neighbours: Newey and West, with their weights, over as many neighbours as
/// the usual rule asks for, 4 (n/100)^(2/9), and at least the width of the local lines.
fn long_run(terms: &[f64]) -> f64 {
    let n = terms.len() as f64;
    let reach = count((4.0 * (n / 100.0).powf(2.0 / 9.0)).ceil().max(4.0 * LINE_STEPS));
    let product = |k: usize| terms.iter().zip(terms.iter().skip(k)).map(|(a, b)| a * b).sum::<f64>();
    let neighbours = (1..=reach).map(|k| 2.0 * (1.0 - k as f64 / (reach + 1) as f64) * product(k));
    (product(0) + neighbours.sum::<f64>()).max(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rest, up, hold, further up, hold, down, rest: straight ramps of half a second.
    fn programme(t: f64) -> f64 {
        let knots =
            [(0.0, 0.0), (2.0, 0.0), (2.5, 10.0), (5.0, 10.0), (5.5, 26.0), (8.0, 26.0), (8.5, 0.0), (20.0, 0.0)];
        let at = knots.iter().rposition(|(from, _)| *from <= t).unwrap_or(0);
        let ((t0, v0), (t1, v1)) = (knots[at.min(6)], knots[at.min(6) + 1]);
        v0 + (v1 - v0) * ((t - t0) / (t1 - t0)).clamp(0.0, 1.0)
    }

    /// Even numbers between -1 and 1, the same in every run.
    fn noise(state: &mut u64) -> f64 {
        *state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (*state >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }

    fn recorded(rate_hz: f64, phase_s: f64, of: impl Fn(f64) -> f64) -> (Vec<f64>, Vec<f64>) {
        let seconds: Vec<f64> = (0..count(11.0 * rate_hz)).map(|i| phase_s + i as f64 / rate_hz).collect();
        let values = seconds.iter().map(|t| of(*t)).collect();
        (seconds, values)
    }

    fn between(a: &(Vec<f64>, Vec<f64>), b: &(Vec<f64>, Vec<f64>)) -> Result<Lag, String> {
        fn lag_of(s: &(Vec<f64>, Vec<f64>)) -> Signal<'_> {
            Signal { seconds: &s.0, values: &s.1 }
        }
        lag(lag_of(a), lag_of(b))
    }

    #[test]
    fn a_pure_delay_comes_back_within_its_uncertainty_whatever_the_sign_and_the_rates() {
        let mut state = 7;
        for (rate, slow) in [(1000.0, 120.0), (120.0, 1000.0), (50.0, 50.0)] {
            for delay in [0.15, -0.4, 0.0, 0.0371] {
                for sign in [1.0, -3.0] {
                    let mut errors = vec![];
                    for trial in 0..8 {
                        let phase = 0.0013 * f64::from(trial);
                        let (mut p, mut x) =
                            (recorded(rate, 0.0, programme), recorded(slow, phase, |t| sign * programme(t - delay)));
                        p.1.iter_mut().for_each(|v| *v += 0.1 * noise(&mut state));
                        x.1.iter_mut().for_each(|v| *v += 0.2 * noise(&mut state));
                        let found = between(&p, &x).unwrap();
                        assert!(found.correlation * sign.signum() > 0.99, "{found:?}");
                        errors.push((found.value_s - delay) / found.std_s);
                        assert!(found.std_s < 0.003, "{found:?}");
                    }
                    let worst = errors.iter().map(|e| e.abs()).fold(0.0, f64::max);
                    assert!(worst < 3.5, "{rate} {slow} {delay}: {errors:?}");
                }
            }
        }
    }

    #[test]
    fn nothing_in_common_is_said_with_its_reason() {
        let mut state = 3;
        let p = recorded(100.0, 0.0, programme);
        let refused = |x: &(Vec<f64>, Vec<f64>)| between(&p, x).unwrap_err();
        assert!(refused(&recorded(40.0, 3600.0, programme)).contains("no stamps in common"));
        assert_eq!(refused(&recorded(40.0, 0.0, |_| 7.0)), "the motion is constant");
        let mut random = recorded(40.0, 0.0, |_| 0.0);
        random.1.iter_mut().for_each(|v| *v = noise(&mut state));
        assert!(refused(&random).contains("nothing in common"));
        assert!(refused(&recorded(40.0, 0.0, |t| programme(t + 2.8))).contains("largest shift"));
        // A pressure that repeats itself has no one lag.
        let sine = |t: f64| (std::f64::consts::TAU * t).sin();
        let (p, x) = (recorded(100.0, 0.0, sine), recorded(40.0, 0.0, |t| sine(t - 0.1)));
        assert!(between(&p, &x).unwrap_err().contains("repeats itself"));
    }

    #[test]
    fn nothing_is_interpolated_over_a_gap() {
        let mut x = recorded(40.0, 0.0, |t| programme(t - 0.1));
        // The rise is missing, and half a second on both sides of it.
        let keep: Vec<bool> = x.0.iter().map(|t| !(1.5..3.2).contains(t)).collect();
        let samples = Samples::of(Signal { seconds: &x.0, values: &x.1 }).unwrap();
        assert!(samples.resampled(0.0, 0.025, 400).iter().skip(2).all(|v| v.is_finite()));
        for column in [&mut x.0, &mut x.1] {
            let mut keep = keep.iter();
            column.retain(|_| *keep.next().unwrap());
        }
        let samples = Samples::of(Signal { seconds: &x.0, values: &x.1 }).unwrap();
        let holes = samples.resampled(0.0, 0.025, 400).iter().skip(2).filter(|v| v.is_nan()).count();
        assert!((66..75).contains(&holes), "{holes}");
        let found = between(&recorded(100.0, 0.0, programme), &x).unwrap();
        assert!((found.value_s - 0.1).abs() < 4.0 * found.std_s.max(1e-3), "{found:?}");
    }
}
