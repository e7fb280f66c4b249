//! The pitch of a ruler's marks along a line, by phase.
//!
//! Brightness along the line is a few harmonics of one phase on a light that changes slowly,
//!
//! ```text
//! I(s) = Σ cᵢ sⁱ + Σ (a_h cos hφ + b_h sin hφ)      φ = ω s + κ s²
//! ```
//!
//! s in px from the middle of the line, κ what a tilt of the ruler changes. First the strongest frequency of a periodogram, then
//! least squares over all of them: every mark has its part in ω, and the pitch 2π/ω in the middle of the line is known far
//! better than one mark's place. The standard uncertainty is by the residuals themselves, with what neighbours have in common
//! over two pitches (Newey and West's sum, 1987).
//!
//! Where every k-th mark is longer or stronger, the spectrum shows it between the harmonics. Up to half of the strength of the
//! pitch itself that is told and fitted; beyond, the pitch may be k times as large, and it is refused unless the caller says
//! about how large it is.

use std::f64::consts::TAU;
use std::fmt;

use nalgebra::{DMatrix, DVector};

use super::super::lens::Lens;
use super::super::picture::{Picture, Place};
use super::{Length, Scale, ScaleError, as_seen, straight};

/// Samples per px along the line, and samples at most.
const PER_PX: f64 = 2.0;
const LONGEST_PX: f64 = 20_000.0;

/// Marks that a line must cross.
const MARKS_MIN: f64 = 8.0;

/// A pitch of fewer px is not resolved.
const PITCH_MIN_PX: f64 = 2.5;

/// Harmonics fitted, and the highest frequency that pixels still show, in cycles per px.
const HARMONICS: usize = 4;
const FREQUENCY_MAX: f64 = 0.42;

/// Powers of s that follow the light.
const LIGHT: usize = 4;

/// Frequencies per 1/length.
const FINE: f64 = 4.0;

/// A peak must be so many times the median of the spectrum, and the fit must say this share of the squares.
const PEAK_MIN: f64 = 4.0;
const EXPLAINED_MIN: f64 = 0.5;

/// Every k-th mark differs: looked at up to k. Told from the first share of the pitch's strength on, refused from the second on.
const EVERY_MAX: usize = 10;
const TOLD: f64 = 0.1;
const REFUSED: f64 = 0.5;

/// A pitch that the caller says is looked for within this share.
const ABOUT: f64 = 0.25;

/// A tilt may change the pitch along the line by this share, at most.
const CHANGE_MAX: f64 = 0.2;

/// Steps of least squares, at most, and the change of phase at the ends that ends them, in rad.
const STEPS_MAX: usize = 40;
const FOUND_RAD: f64 = 1e-7;

/// The line across the marks.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Line {
    /// One end, in px.
    pub from: Place,
    /// The other.
    pub to: Place,
    /// Brightness is the mean over so many px along the marks.
    pub across_px: f64,
    /// About how large the pitch is, in px, where that is known.
    pub about_px: Option<f64>,
}

/// A pitch.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ruler {
    /// In the middle of the line, in px (of a straightened picture where the lens is given).
    pub pitch_px: f64,
    /// Standard uncertainty, in px.
    pub std_px: f64,
    /// Pitches along the line.
    pub marks: f64,
    /// By which share the pitch is larger at the second end than at the first, for the ruler is tilted.
    pub change: f64,
    /// Its standard uncertainty.
    pub change_std: f64,
    /// Every k-th mark differs, and by which share of the pitch's strength in the spectrum.
    pub every: Option<(usize, f64)>,
}

/// Why there is no pitch.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum RulerError {
    /// The line is too short or too long, or not in the picture.
    Line {
        /// Its length, in px.
        length_px: f64,
    },
    /// Nothing repeats along it.
    NoMarks,
    /// The pitch is this, or so many times as large.
    Ambiguous {
        /// The smaller one, in px.
        pitch_px: f64,
        /// How many times.
        times: usize,
    },
    /// The lens is not known there.
    Lens(ScaleError),
}

impl fmt::Display for RulerError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Line { length_px } => write!(
                f,
                "a line of {length_px:.1} px: expected one in the picture, across at least {MARKS_MIN} marks that are {PITCH_MIN_PX} px apart"
            ),
            Self::NoMarks => {
                write!(
                    f,
                    "no even marks along the line: let it cross at least {MARKS_MIN} marks, all of one length, and no digits"
                )
            }
            Self::Ambiguous { pitch_px, times } => write!(
                f,
                "the marks repeat every {pitch_px:.2} px, but each {times}th differs so much that the pitch may be {:.2} px: say about how large it is",
                pitch_px * *times as f64
            ),
            Self::Lens(why) => write!(f, "{why}"),
        }
    }
}

impl std::error::Error for RulerError {}

impl Ruler {
    /// The scale in the middle of the line, for marks so far apart.
    ///
    /// # Errors
    /// If the length is none.
    pub fn scale(&self, apart: Length) -> Result<Scale, ScaleError> {
        Ok(Scale::of(apart.checked()?, self.pitch_px, self.std_px))
    }
}

/// The pitch of the marks along a line.
///
/// # Errors
/// Why there is none: no marks, too few, or two pitches that are as likely.
pub fn pitch(picture: &Picture, line: &Line, lens: Option<&Lens>) -> Result<Ruler, RulerError> {
    let profile = Profile::sampled(picture, line, lens)?;
    let (frequency, every) = profile.strongest(line.about_px)?;
    let start = profile.with_change(frequency);
    profile.fitted(start, every)
}

/// Brightness along the line, without the light.
struct Profile {
    length_px: f64,
    /// From the middle of the line, as shares of half its length.
    shares: Vec<f64>,
    luma: Vec<f64>,
    /// `luma` without what changes slowly, weighed down towards the ends.
    windowed: Vec<f64>,
}

/// Phase at a share of half the length: `ends * share + bend * share²`, in rad.
#[derive(Clone, Copy)]
struct Phase {
    ends: f64,
    bend: f64,
}

impl Phase {
    fn at(self, share: f64) -> f64 {
        share * (self.ends + self.bend * share)
    }
}

impl Profile {
    fn sampled(picture: &Picture, line: &Line, lens: Option<&Lens>) -> Result<Self, RulerError> {
        let (right, bottom) = ((picture.width() - 1) as f64, (picture.height() - 1) as f64);
        let inside = |at: Place| (0.0..=right).contains(&at.x) && (0.0..=bottom).contains(&at.y);
        let bad = RulerError::Line { length_px: (line.to - line.from).norm() };
        if !inside(line.from) || !inside(line.to) {
            return Err(bad);
        }
        let from = straight(lens, line.from).map_err(RulerError::Lens)?;
        let to = straight(lens, line.to).map_err(RulerError::Lens)?;
        let length_px = (to - from).norm();
        if !(MARKS_MIN * PITCH_MIN_PX..LONGEST_PX).contains(&length_px) {
            return Err(bad);
        }
        let along = (to - from) / length_px;
        let aside = Place::new(-along.y, along.x);
        // Below the longest line, and below the width of a picture.
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        let (n, lines) = ((PER_PX * length_px) as usize, line.across_px.clamp(1.0, right + bottom + 1.0) as usize);
        let share_of = |i: usize| 2.0 * i as f64 / (n - 1) as f64 - 1.0;
        let middle = (from + to) / 2.0;
        let luma_of = |share: f64| {
            let at = middle + along * (share * length_px / 2.0);
            let one = |k: usize| picture.between(as_seen(lens, at + aside * (k as f64 - (lines - 1) as f64 / 2.0)));
            (0..lines).map(one).sum::<f64>() / lines as f64
        };
        let shares: Vec<f64> = (0..n).map(share_of).collect();
        let luma: Vec<f64> = shares.iter().map(|share| luma_of(*share)).collect();
        let light = DMatrix::from_fn(n, LIGHT, |i, k| legendre(shares[i], k));
        let slow = solve(&light, &luma).map(|(c, _)| &light * c).ok_or(RulerError::NoMarks)?;
        let hann = |share: f64| 0.5 * (1.0 + (share * TAU / 2.0).cos());
        let windowed = (0..n).map(|i| hann(shares[i]) * (luma[i] - slow[i])).collect();
        Ok(Self { length_px, shares, luma, windowed })
    }

    /// Strength of a phase.
    fn strength(&self, phase: Phase) -> f64 {
        let mut sum = (0.0, 0.0);
        for (share, value) in self.shares.iter().zip(&self.windowed) {
            let (sin, cos) = phase.at(*share).sin_cos();
            sum = (sum.0 + value * cos, sum.1 + value * sin);
        }
        sum.0.hypot(sum.1) / self.shares.len() as f64
    }

    /// Strength of so many cycles along the line, turned on from sample to sample.
    fn strength_of(&self, cycles: f64) -> f64 {
        let (s, c) = (cycles * TAU / (self.shares.len() - 1) as f64).sin_cos();
        let (mut sin, mut cos, mut sum) = (0.0, 1.0, (0.0, 0.0));
        for value in &self.windowed {
            sum = (sum.0 + value * cos, sum.1 + value * sin);
            (sin, cos) = (sin * c + cos * s, cos * c - sin * s);
        }
        f64::hypot(sum.0, sum.1) / self.shares.len() as f64
    }

    /// Cycles along the line of the strongest frequency, and whether every k-th mark differs.
    fn strongest(&self, about_px: Option<f64>) -> Result<(f64, Option<(usize, f64)>), RulerError> {
        let most = self.length_px * FREQUENCY_MAX.min(1.0 / PITCH_MIN_PX);
        // Above nought, and below the longest line.
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        let count = (most * FINE) as usize;
        let cycles_of = |i: usize| i as f64 / FINE;
        let spectrum: Vec<f64> = (0..=count).map(|i| self.strength_of(cycles_of(i))).collect();
        let near = |cycles: f64| match about_px {
            Some(px) => (cycles * px / self.length_px - 1.0).abs() < ABOUT,
            None => true,
        };
        let peak = (0..=count)
            .filter(|i| cycles_of(*i) >= MARKS_MIN - 1.0 && near(cycles_of(*i)))
            .max_by(|a, b| spectrum[*a].total_cmp(&spectrum[*b]))
            .ok_or(RulerError::NoMarks)?;
        let mut sorted = spectrum.clone();
        sorted.sort_by(f64::total_cmp);
        let own = spectrum[peak];
        if own <= PEAK_MIN * sorted[sorted.len() / 2] || own <= 0.0 {
            return Err(RulerError::NoMarks);
        }
        let cycles = cycles_of(peak);
        let mut every: Option<(usize, f64)> = None;
        for k in 2..=EVERY_MAX {
            // The window must tell the lines apart.
            if cycles / (k as f64) < 4.0 {
                break;
            }
            // Of marks that differ, all harmonics between show it; of an uneven light, only the lowest.
            let mut between: Vec<f64> = (1..k).map(|m| self.strength_of(cycles * m as f64 / k as f64) / own).collect();
            between.sort_by(f64::total_cmp);
            let share = between[(between.len() - 1) / 2];
            if share > TOLD && every.is_none_or(|(_, most)| share > 1.2 * most) {
                every = Some((k, share));
            }
        }
        match every {
            Some((times, share)) if share > REFUSED && about_px.is_none() => {
                Err(RulerError::Ambiguous { pitch_px: self.length_px / cycles, times })
            }
            _ => Ok((cycles, every)),
        }
    }

    /// The strongest phase near so many cycles, whose pitch may change along the line.
    fn with_change(&self, cycles: f64) -> Phase {
        let most = CHANGE_MAX * cycles * TAU / 8.0;
        let steps = (most / 0.4).ceil();
        // Some hundred, at most.
        #[allow(clippy::cast_possible_truncation)]
        let steps = steps.clamp(1.0, 500.0) as i32;
        let mut best = (0.0, Phase { ends: cycles * TAU / 2.0, bend: 0.0 });
        for i in -steps..=steps {
            for j in -8..=8 {
                let phase = Phase {
                    ends: (cycles + f64::from(j) / 8.0) * TAU / 2.0,
                    bend: most * f64::from(i) / f64::from(steps),
                };
                let strength = self.strength(phase);
                if strength > best.0 {
                    best = (strength, phase);
                }
            }
        }
        best.1
    }

    fn fitted(&self, start: Phase, every: Option<(usize, f64)>) -> Result<Ruler, RulerError> {
        let n = self.shares.len();
        let mut phase = start;
        // The pitch itself first, then its overtones, which would lose their way earlier.
        let mut fit = None;
        for all in [false, true] {
            let orders = self.orders(phase, every, all);
            fit = Some(self.steps(&mut phase, &orders)?);
        }
        let (design, _, inverse, left) = fit.ok_or(RulerError::NoMarks)?;
        let light = DMatrix::from_fn(n, LIGHT, |i, k| legendre(self.shares[i], k));
        let (c, _) = solve(&light, &self.luma).ok_or(RulerError::NoMarks)?;
        let before = (DVector::from_column_slice(&self.luma) - &light * c).norm_squared();
        let explained = 1.0 - left.norm_squared() / before;
        let cycles = phase.ends * 2.0 / TAU;
        let pitch_px = self.length_px / cycles;
        if !(explained > EXPLAINED_MIN && cycles >= MARKS_MIN - 1.0 && pitch_px >= PITCH_MIN_PX) {
            return Err(RulerError::NoMarks);
        }
        // Samples within two pitches have something in common.
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        let lags = (2.0 * pitch_px * PER_PX) as usize;
        let std_of = |column: usize| {
            let influence = &design * inverse.column(column);
            let parts: Vec<f64> = influence.iter().zip(left.iter()).map(|(a, b)| a * b).collect();
            let lagged = |lag: usize| parts.iter().zip(&parts[lag.min(n)..]).map(|(a, b)| a * b).sum::<f64>();
            let common: f64 = (1..=lags).map(|lag| 2.0 * (1.0 - lag as f64 / (lags + 1) as f64) * lagged(lag)).sum();
            let own = lagged(0);
            // Few samples: what they have in common cannot be less than nothing.
            ((own + common.max(0.0)) * n as f64 / (n - design.ncols()).max(1) as f64).sqrt()
        };
        let ends_std = std_of(design.ncols() - 2);
        let bend_std = std_of(design.ncols() - 1);
        // Frequency at a share is ends + 2 bend share: the pitch changes the other way.
        let change = -4.0 * phase.bend / phase.ends;
        let ruler = Ruler {
            pitch_px,
            std_px: pitch_px * ends_std / phase.ends.abs(),
            marks: cycles,
            change,
            change_std: 4.0 * bend_std / phase.ends.abs(),
            every,
        };
        (ruler.std_px.is_finite() && ruler.change_std.is_finite() && ruler.std_px < 0.1 * pitch_px)
            .then_some(ruler)
            .ok_or(RulerError::NoMarks)
    }

    /// Orders of the pitch that are fitted: below one where every k-th mark differs.
    fn orders(&self, phase: Phase, every: Option<(usize, f64)>, all: bool) -> Vec<f64> {
        let frequency = phase.ends * 2.0 / TAU / self.length_px;
        let overtones = (1..=if all { HARMONICS } else { 1 }).map(|h| h as f64);
        let mut orders: Vec<f64> = overtones.filter(|h| h * frequency < FREQUENCY_MAX).collect();
        if let Some((k, _)) = every.filter(|_| all) {
            let between = (1..2 * k).filter(|m| m % k != 0).map(|m| m as f64 / k as f64);
            orders.extend(between.filter(|order| order * frequency < FREQUENCY_MAX));
        }
        orders
    }

    /// Gauss and Newton's steps; the last columns are those of the phase.
    #[allow(clippy::type_complexity)]
    fn steps(
        &self,
        phase: &mut Phase,
        orders: &[f64],
    ) -> Result<(DMatrix<f64>, DVector<f64>, DMatrix<f64>, DVector<f64>), RulerError> {
        let n = self.shares.len();
        let linear = LIGHT + 2 * orders.len();
        if n < 2 * (linear + 2) {
            return Err(RulerError::NoMarks);
        }
        let column = |phase: &Phase, i: usize, k: usize| match k.checked_sub(LIGHT) {
            None => legendre(self.shares[i], k),
            Some(k) => {
                let (sin, cos) = (orders[k / 2] * phase.at(self.shares[i])).sin_cos();
                if k % 2 == 0 { cos } else { sin }
            }
        };
        let plain = DMatrix::from_fn(n, linear, |i, k| column(phase, i, k));
        let (mut amplitudes, _) = solve(&plain, &self.luma).ok_or(RulerError::NoMarks)?;
        for _ in 0..STEPS_MAX {
            let slope = |i: usize| -> f64 {
                let at = phase.at(self.shares[i]);
                let one = |(k, order): (usize, &f64)| {
                    let (sin, cos) = (order * at).sin_cos();
                    order * (amplitudes[LIGHT + 2 * k + 1] * cos - amplitudes[LIGHT + 2 * k] * sin)
                };
                orders.iter().enumerate().map(one).sum()
            };
            let slopes: Vec<f64> = (0..n).map(slope).collect();
            let design = DMatrix::from_fn(n, linear + 2, |i, k| match k.checked_sub(linear) {
                None => column(phase, i, k),
                Some(0) => slopes[i] * self.shares[i],
                Some(_) => slopes[i] * self.shares[i] * self.shares[i],
            });
            let (solved, inverse) = solve(&design, &self.luma).ok_or(RulerError::NoMarks)?;
            let (ends, bend) = (solved[linear].clamp(-1.0, 1.0), solved[linear + 1].clamp(-1.0, 1.0));
            *phase = Phase { ends: phase.ends + ends, bend: phase.bend + bend };
            amplitudes = solved.rows(0, linear).into_owned();
            if ends.abs().max(bend.abs()) < FOUND_RAD {
                let left = DVector::from_column_slice(&self.luma) - &design * &solved;
                return Ok((design, solved, inverse, left));
            }
        }
        Err(RulerError::NoMarks)
    }
}

/// Legendre's polynomials up to the third: powers that do not resemble each other.
fn legendre(x: f64, order: usize) -> f64 {
    match order {
        0 => 1.0,
        1 => x,
        2 => 1.5 * x * x - 0.5,
        _ => (2.5 * x * x - 1.5) * x,
    }
}

/// Least squares: the numbers, and the inverse of the normal equations.
fn solve(design: &DMatrix<f64>, values: &[f64]) -> Option<(DVector<f64>, DMatrix<f64>)> {
    let normal = design.tr_mul(design).cholesky()?;
    let solved = normal.solve(&design.tr_mul(&DVector::from_column_slice(values)));
    solved.iter().all(|v| v.is_finite()).then(|| (solved, normal.inverse()))
}

#[cfg(test)]
mod tests {
    use super::super::super::picture::Pixels;
    use super::*;
    use rand_distr::{Distribution, StandardNormal};
    use rand_pcg::Pcg64Mcg;
    use statrs::function::erf::erf;

    /// Dark marks across x, `width` wide, at `offset + k pitch` (squeezed by `change` over 600 px); marks of which k % of.0 is 0
    /// are of.1 times as dark.
    fn ruler(pitch: f64, change: f64, of: (i32, f64), noise: f64, generator: &mut Pcg64Mcg) -> Picture {
        let (width, height, blur) = (700, 24, 0.9);
        let side = |d: f64| 0.5 * erf(d / (blur * std::f64::consts::SQRT_2));
        let mut clean = vec![0.0; width];
        for (x, value) in clean.iter_mut().enumerate() {
            let from_middle = x as f64 - 350.0;
            let light = 180.0 + 0.05 * from_middle - 1e-4 * from_middle * from_middle;
            let mut dark = 0.0;
            for k in -150..=150 {
                // Pitch p(x) = pitch (1 + change x/600): marks where the integral of 1/p is whole.
                let at = if change == 0.0 {
                    f64::from(k) * pitch
                } else {
                    600.0 / change * ((f64::from(k) * pitch * change / 600.0).exp() - 1.0)
                };
                let strength = if k % of.0 == 0 { of.1 } else { 1.0 };
                dark += strength
                    * (side(from_middle - at - 3.37 + 0.15 * pitch) - side(from_middle - at - 3.37 - 0.15 * pitch));
            }
            *value = light * (1.0 - 0.55 * dark.min(1.6));
        }
        let mut pixels = vec![];
        for _ in 0..height {
            for value in &clean {
                let z: f64 = StandardNormal.sample(generator);
                // Clamped to what eight bits hold.
                #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
                pixels.push((value + noise * z).round().clamp(0.0, 255.0) as u8);
            }
        }
        Picture::new(width, height, Pixels::Gray8(pixels)).unwrap()
    }

    fn line(about_px: Option<f64>) -> Line {
        Line { from: Place::new(50.0, 11.0), to: Place::new(650.0, 11.0), across_px: 9.0, about_px }
    }

    #[test]
    fn the_pitch_comes_back_and_scatters_as_stated() {
        let mut generator = Pcg64Mcg::new(21);
        let (mut squares, mut n) = (0.0, 0.0);
        for i in 0..8 {
            let truth = 8.1 + 0.37 * f64::from(i % 8);
            let found = pitch(&ruler(truth, 0.0, (1, 1.0), 4.0, &mut generator), &line(None), None).unwrap();
            assert!((found.pitch_px - truth).abs() < 3e-4 * truth, "{truth}: {found:?}");
            assert!(found.change.abs() < 4.0 * found.change_std + 1e-4 && found.every.is_none(), "{found:?}");
            squares += ((found.pitch_px - truth) / found.std_px).powi(2);
            n += 1.0;
        }
        assert!((0.3..2.0).contains(&(squares / n)), "{}", squares / n);
    }

    #[test]
    fn a_tilted_ruler_is_told_and_the_pitch_is_that_of_the_middle() {
        let mut generator = Pcg64Mcg::new(22);
        for change in [0.04, -0.08] {
            let found = pitch(&ruler(12.0, change, (1, 1.0), 3.0, &mut generator), &line(None), None).unwrap();
            assert!((found.pitch_px - 12.0).abs() < 0.006, "{found:?}");
            assert!((found.change - change).abs() < 0.004, "{found:?}");
        }
    }

    #[test]
    fn longer_marks_are_told_and_marks_that_alternate_are_refused_unless_the_pitch_is_said() {
        let mut generator = Pcg64Mcg::new(23);
        let told = pitch(&ruler(9.0, 0.0, (5, 1.6), 3.0, &mut generator), &line(None), None).unwrap();
        assert!((told.pitch_px - 9.0).abs() < 3e-3, "{told:?}");
        assert_eq!(told.every.unwrap().0, 5);
        let alternating = ruler(10.0, 0.0, (2, 0.3), 3.0, &mut generator);
        let refused = pitch(&alternating, &line(None), None).unwrap_err();
        assert!(matches!(refused, RulerError::Ambiguous { times: 2, .. }), "{refused}");
        for about in [9.0, 22.0] {
            let said = pitch(&alternating, &line(Some(about)), None).unwrap();
            let truth = if about < 15.0 { 10.0 } else { 20.0 };
            assert!((said.pitch_px - truth).abs() < 5e-4 * truth, "{said:?}");
        }
    }

    #[test]
    fn where_nothing_repeats_there_is_no_pitch() {
        let mut generator = Pcg64Mcg::new(24);
        let noise = ruler(1e6, 0.0, (1, 0.0), 12.0, &mut generator);
        assert_eq!(pitch(&noise, &line(None), None), Err(RulerError::NoMarks));
        let flat = Picture::new(700, 24, Pixels::Gray8(vec![90; 700 * 24])).unwrap();
        assert_eq!(pitch(&flat, &line(None), None), Err(RulerError::NoMarks));
        let few = Line { to: Place::new(90.0, 11.0), ..line(None) };
        assert!(pitch(&ruler(12.0, 0.0, (1, 1.0), 3.0, &mut generator), &few, None).is_err());
        let outside = Line { to: Place::new(900.0, 11.0), ..line(None) };
        assert!(matches!(pitch(&flat, &outside, None), Err(RulerError::Line { .. })));
    }

    #[test]
    fn behind_a_lens_the_pitch_is_that_of_the_straight_picture() {
        let mut generator = Pcg64Mcg::new(25);
        let lens = Lens { radial: [-0.08, 0.0, 0.0], ..Lens::pinhole(700.0, Place::new(350.0, 11.0)) };
        let straight = ruler(9.3, 0.0, (1, 1.0), 0.0, &mut generator);
        let mut bent = vec![];
        for y in 0..24 {
            for x in 0..700 {
                let at = lens.straight(Place::new(f64::from(x), f64::from(y))).unwrap();
                #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
                bent.push(straight.between(at).round() as u8);
            }
        }
        let bent = Picture::new(700, 24, Pixels::Gray8(bent)).unwrap();
        let found = pitch(&bent, &line(None), Some(&lens)).unwrap();
        assert!((found.pitch_px - 9.3).abs() < 2e-3, "{found:?}");
    }
}
