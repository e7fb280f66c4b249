//! Bootstrap intervals, bias-corrected and accelerated, of means and of functions of means.
//!
//! B. Efron, "Better bootstrap confidence intervals", J. Am. Stat. Assoc. 82 (1987) 171. From n rows, each resample draws n rows with
//! replacement; the statistic of it is θ*, that of the data is θ̂, that without row i is θ₍ᵢ₎, their mean θ₍.₎. Then
//!
//! - bias correction z₀ = Φ⁻¹( share of θ* below θ̂, those equal to it counted half ),
//! - acceleration a = Σ (θ₍.₎ - θ₍ᵢ₎)³ / ( 6 [Σ (θ₍.₎ - θ₍ᵢ₎)²]^(3/2) ),
//! - ends: the quantiles of θ* at Φ( z₀ + (z₀ + z) / (1 - a (z₀ + z)) ), z = ± Φ⁻¹((1 + level) / 2), with straight lines between
//!   order statistics (the k-th of B, from zero, is the quantile k / (B - 1)).
//!
//! These are the definitions of `scipy.stats.bootstrap(method="BCa")`; both agree but for the random draws. "Equal" leaves room for
//! rounding: a resample that holds every row once has the mean of the data in another order of addition. (scipy leaves none, so that
//! few values with decimals, such as 4.7 and 5.1, may move its ends a little.)
//!
//! A row is what is independent of the other rows: a repeat, a cycle, a specimen. Samples of a series are not; their rows are
//! blocks ([`blocks_of`]), and [`block_length`] says how long. An interval from few rows is too short whatever the method
//! (n = 3: about 80 % for stated 95 %); that is the caller's to know.

use statrs::distribution::{ContinuousCDF, Normal};
use thiserror::Error;

use super::random::{Draws, take};

/// Rows at most: beyond it two indices no longer fit into one random number without bias (n²/2^64 < 10^-6).
pub const ROWS_MAX: usize = 1 << 22;

/// Up to so many rows, four indices fit into one random number without bias (n⁴/2^64 < 10^-6).
const ROWS_OF_FOUR: usize = 1 << 11;

/// Values so near, as a share of the largest, are equal up to the order of addition.
const ROUNDING_SHARE: f64 = 1e-12;

/// Why there is no interval.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
pub enum NoInterval {
    /// One row has no scatter.
    #[error("an interval by resampling needs at least two independent rows")]
    TooFewRows,
    /// More rows than [`ROWS_MAX`].
    #[error("more than {ROWS_MAX} rows to resample")]
    TooManyRows,
    /// Columns of different lengths, or none.
    #[error("the columns to resample do not have the same number of rows")]
    Uneven,
    /// A value, or the statistic of a resample, is not a finite number.
    #[error("a resampled value is not a finite number")]
    NotFinite,
    /// Every resample gives the same value: nothing is known of how it scatters.
    #[error("the rows do not differ, so that they say nothing of how sure their mean is")]
    NoScatter,
    /// The value lies at the edge of all resampled ones, or the acceleration is beyond what the correction can follow, or both ends coincide.
    #[error("the resampled values lie too much to one side for a bias correction")]
    OneSided,
    /// A level outside 0 to 1, no resample, or a block of no or all samples.
    #[error("the level, the number of resamples or the block length is out of its range")]
    OutOfDomain,
}

/// What is resampled: rows that are independent of each other, of one or several columns.
#[derive(Debug, Clone, PartialEq)]
pub struct Blocks {
    columns: Vec<Vec<f64>>,
    /// Rows that a resample draws.
    draws: usize,
    /// Every so-manieth row shares nothing with the others: 1 but for overlapping blocks.
    apart: usize,
}

impl Blocks {
    /// Independent rows, given as columns of equal length.
    ///
    /// # Errors
    /// Fewer than two or too many rows, columns of unequal length, a value that is not finite.
    pub fn new(columns: Vec<Vec<f64>>) -> Result<Self, NoInterval> {
        let rows = columns.first().ok_or(NoInterval::Uneven)?.len();
        Self::checked(columns, rows, 1)
    }

    fn checked(columns: Vec<Vec<f64>>, draws: usize, apart: usize) -> Result<Self, NoInterval> {
        let rows = columns.first().map_or(0, Vec::len);
        if columns.iter().any(|column| column.len() != rows) {
            Err(NoInterval::Uneven)
        } else if rows < 2 || draws < 2 {
            Err(NoInterval::TooFewRows)
        } else if rows > ROWS_MAX {
            Err(NoInterval::TooManyRows)
        } else if columns.iter().flatten().any(|value| !value.is_finite()) {
            Err(NoInterval::NotFinite)
        } else {
            Ok(Self { columns, draws, apart })
        }
    }

    /// How many rows there are.
    pub fn rows(&self) -> usize {
        self.columns.first().map_or(0, Vec::len)
    }

    /// How many independent rows a resample holds: of a series, the number of blocks that fit into it.
    pub fn draws(&self) -> usize {
        self.draws
    }

    /// Mean of each column.
    pub fn means(&self) -> Vec<f64> {
        let rows = self.rows() as f64;
        self.columns.iter().map(|column| column.iter().sum::<f64>() / rows).collect()
    }

    /// The statistic without one row after the other; of overlapping blocks, of those that do not overlap.
    fn without_each(&self, statistic: &dyn Fn(&[f64]) -> f64) -> Vec<f64> {
        let kept = || (0..self.draws).map(|i| i * self.apart);
        let sums: Vec<f64> = self.columns.iter().map(|column| kept().map(|row| column[row]).sum()).collect();
        let left = (self.draws - 1) as f64;
        let mut means = vec![0.0; sums.len()];
        kept()
            .map(|row| {
                for ((mean, sum), column) in means.iter_mut().zip(&sums).zip(&self.columns) {
                    *mean = (sum - column[row]) / left;
                }
                statistic(&means)
            })
            .collect()
    }
}

/// Overlapping blocks of a series of evenly spaced samples, its end joined to its start (circular block bootstrap): every sample
/// stands in as many blocks as any other, so the mean over all blocks is that of the series. A resample draws as many blocks as fit
/// into the series, a last part left over not counted: rather too wide than too narrow. Columns are series side by side, such as
/// residuals and their squares.
///
/// # Errors
/// As [`Blocks::new`]; [`NoInterval::OutOfDomain`] for a length of zero or of more than half the series.
pub fn blocks_of(series: &[&[f64]], length: usize) -> Result<Blocks, NoInterval> {
    let samples = series.first().map_or(0, |column| column.len());
    if length == 0 || length > samples / 2 {
        return Err(if samples < 2 { NoInterval::TooFewRows } else { NoInterval::OutOfDomain });
    }
    let block_means = |column: &&[f64]| -> Vec<f64> {
        // Each block by itself: a running sum would carry the rounding of large values along.
        let from = |start: usize| (start..start + length).map(|i| column[i % column.len()]).sum::<f64>();
        (0..column.len()).map(|start| from(start) / length as f64).collect()
    };
    Blocks::checked(series.iter().map(block_means).collect(), samples / length, length)
}

/// How long blocks of a series should be for the circular block bootstrap of its mean: the rule of Politis and White, "Automatic
/// block-length selection for the dependent bootstrap", Econometric Reviews 23 (2004) 53, as corrected by Patton, Politis and White,
/// ibid. 28 (2009) 372.
///
/// With autocovariances R(k) and autocorrelations ρ(k) of N samples, m is the smallest lag after which max(5, √log₁₀N) autocorrelations
/// in a row stay within ± 2 √(log₁₀N / N), and M = 2 m (at most √N + that number). With the flat-top window λ(t) = 1 up to t = 1/2, then
/// 2 (1 - t): G = Σ λ(k/M) |k| R(k), g = Σ λ(k/M) R(k), both over -M..M, and the length is (2 G² / (4/3 g²) · N)^(1/3), rounded
/// up, at most 3 √N and N/3. Samples that do not know of each other have blocks of 1.
///
/// # Errors
/// Fewer than 9 samples, a value that is not finite, or a series that is constant.
///
/// # Check value
/// Blocks of a series in which every value stands three times are longer than those of the values by themselves.
/// ```
/// use pneuval_analysis::uncertainty::bootstrap::block_length;
/// let values: Vec<f64> = (0..300_u64).map(|i| (i * i % 307) as f64).collect();
/// let held: Vec<f64> = values.iter().flat_map(|v| [*v; 3]).collect();
/// assert_eq!((block_length(&values), block_length(&held)), (Ok(1), Ok(10)));
/// ```
pub fn block_length(series: &[f64]) -> Result<usize, NoInterval> {
    let n = series.len();
    if n < 9 {
        return Err(NoInterval::TooFewRows);
    }
    if series.iter().any(|value| !value.is_finite()) {
        return Err(NoInterval::NotFinite);
    }
    let size = n as f64;
    let mean = series.iter().sum::<f64>() / size;
    let residuals: Vec<f64> = series.iter().map(|value| value - mean).collect();
    let covariance = |lag: usize| residuals.iter().zip(&residuals[lag..]).map(|(a, b)| a * b).sum::<f64>() / size;
    let in_a_row = whole(size.log10().sqrt().ceil()).max(5);
    let lags_max = (whole(size.sqrt().ceil()) + in_a_row).min(n - 1);
    let covariances: Vec<f64> = (0..=lags_max).map(covariance).collect();
    let largest = series.iter().map(|value| value.abs()).fold(0.0, f64::max);
    if covariances[0] <= (ROUNDING_SHARE * largest).powi(2) {
        return Err(NoInterval::NoScatter);
    }
    let limit = 2.0 * (size.log10() / size).sqrt() * covariances[0];
    let quiet = |m: &usize| covariances[m + 1..=m + in_a_row].iter().all(|c| c.abs() < limit);
    let lags = (0..=lags_max - in_a_row).find(quiet).map_or(lags_max, |m| (2 * m).min(lags_max));
    let (mut slope, mut density) = (0.0, covariances[0]);
    for (lag, covariance) in covariances.iter().enumerate().take(lags + 1).skip(1) {
        let window = (2.0 * (1.0 - lag as f64 / lags as f64)).min(1.0);
        slope += 2.0 * window * lag as f64 * covariance;
        density += 2.0 * window * covariance;
    }
    let longest = (3.0 * size.sqrt()).min(size / 3.0);
    let length = (1.5 * (slope / density).powi(2) * size).cbrt();
    // A density of zero asks for the longest blocks.
    let length = if length.is_finite() { length.min(longest) } else { longest };
    Ok(whole(length.ceil()).max(1))
}

/// A number of samples from one that is whole, small and not negative already.
#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
fn whole(value: f64) -> usize {
    value as usize
}

/// A bias-corrected and accelerated interval.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bca {
    /// The statistic of the data, in its own unit, as are the ends.
    pub value: f64,
    /// Lower end.
    pub lower: f64,
    /// Upper end.
    pub upper: f64,
    /// z₀: how far the median of the resampled values lies from the value, in standard deviations.
    pub bias_correction: f64,
    /// a: how fast the standard deviation changes with the value.
    pub acceleration: f64,
}

/// The interval of a statistic of the column means.
///
/// `level` is the probability that is stated, as 0.95; `resamples` some thousands: with 10,000 the ends of a 95 % interval scatter by
/// about 2 % of its half-width from seed to seed. The same seed gives the same bits.
///
/// # Errors
/// Where no interval can be stated: see [`NoInterval`]. Never a number that is not one.
///
/// # Check value
/// Residuals 1 to 10: `scipy.stats.bootstrap` with four million resamples gives an RMSE between 4.572 and 7.849.
/// ```
/// use pneuval_analysis::uncertainty::bootstrap::{bca, Blocks};
/// let squares: Vec<f64> = (1..=10).map(|r| f64::from(r * r)).collect();
/// let interval = bca(&Blocks::new(vec![squares])?, &|means| means[0].sqrt(), 100_000, 1, 0.95)?;
/// assert!((interval.value - 38.5_f64.sqrt()).abs() < 1e-12);
/// assert!((interval.lower - 4.572).abs() < 0.03 && (interval.upper - 7.849).abs() < 0.03, "{interval:?}");
/// # Ok::<(), pneuval_analysis::uncertainty::bootstrap::NoInterval>(())
/// ```
pub fn bca(
    blocks: &Blocks,
    statistic: &dyn Fn(&[f64]) -> f64,
    resamples: usize,
    seed: u64,
    level: f64,
) -> Result<Bca, NoInterval> {
    if !(level > 0.0 && level < 1.0) || resamples < 2 {
        return Err(NoInterval::OutOfDomain);
    }
    let value = statistic(&blocks.means());
    let mut resampled = resampled(blocks, statistic, resamples, seed);
    let without_each = blocks.without_each(statistic);
    if !value.is_finite() || resampled.iter().chain(&without_each).any(|v| !v.is_finite()) {
        return Err(NoInterval::NotFinite);
    }
    resampled.sort_unstable_by(f64::total_cmp);
    let (least, most) = (resampled[0], resampled[resamples - 1]);
    let rounding = ROUNDING_SHARE * least.abs().max(most.abs());
    let spread = without_each.iter().map(|v| (v - without_each[0]).abs()).fold(0.0, f64::max);
    if most - least <= 2.0 * rounding || spread <= 2.0 * rounding {
        return Err(NoInterval::NoScatter);
    }
    let below = resampled.partition_point(|v| *v < value - rounding);
    let not_above = resampled.partition_point(|v| *v <= value + rounding);
    let share = (below + not_above) as f64 / (2 * resamples) as f64;
    if share <= 0.0 || share >= 1.0 {
        return Err(NoInterval::OneSided);
    }
    let normal = Normal::standard();
    let bias_correction = normal.inverse_cdf(share);
    let acceleration = acceleration(&without_each);
    let end = |z: f64| {
        let shifted = bias_correction + z;
        let stretch = 1.0 - acceleration * shifted;
        (stretch > 0.0)
            .then(|| quantile(&resampled, normal.cdf(bias_correction + shifted / stretch)))
            .ok_or(NoInterval::OneSided)
    };
    let z = normal.inverse_cdf(0.5 * (1.0 + level));
    let (lower, upper) = (end(-z)?, end(z)?);
    // Both corrections may lead to the same resample: no width would promise that all is known.
    if upper - lower <= rounding {
        return Err(NoInterval::OneSided);
    }
    Ok(Bca { value, lower, upper, bias_correction, acceleration })
}

/// The skewness of the jackknife values, a sixth of it.
fn acceleration(without_each: &[f64]) -> f64 {
    let centre = without_each.iter().sum::<f64>() / without_each.len() as f64;
    let (mut squares, mut cubes) = (0.0, 0.0);
    for difference in without_each.iter().map(|v| centre - v) {
        squares += difference * difference;
        cubes += difference.powi(3);
    }
    cubes / (6.0 * squares.powf(1.5))
}

/// A quantile of sorted numbers, of which there is at least one; straight lines between them: the k-th of n is that of k / (n - 1).
pub fn quantile(sorted: &[f64], share: f64) -> f64 {
    let place = share * (sorted.len() - 1) as f64;
    let before = whole(place.floor()).min(sorted.len() - 1);
    let after = (before + 1).min(sorted.len() - 1);
    sorted[before] + (place - before as f64) * (sorted[after] - sorted[before])
}

/// The statistic of every resample.
fn resampled(blocks: &Blocks, statistic: &dyn Fn(&[f64]) -> f64, resamples: usize, seed: u64) -> Vec<f64> {
    let mut draws = Draws::new(seed, "bootstrap");
    let (rows, size) = (blocks.rows(), blocks.draws as f64);
    if let [column] = blocks.columns.as_slice() {
        let sum = if rows <= ROWS_OF_FOUR { sum_of_draws::<4> } else { sum_of_draws::<2> };
        return (0..resamples).map(|_| statistic(&[sum(column, blocks.draws, &mut draws) / size])).collect();
    }
    // The same rows of every column: drawn first, then gathered one column after the other.
    let draw = if rows <= ROWS_OF_FOUR { draw_rows::<4> } else { draw_rows::<2> };
    let mut drawn = vec![0_u32; blocks.draws];
    let mut means = vec![0.0; blocks.columns.len()];
    (0..resamples)
        .map(|_| {
            draw(&mut drawn, rows, &mut draws);
            for (mean, column) in means.iter_mut().zip(&blocks.columns) {
                *mean = sum_of(column, &drawn) / size;
            }
            statistic(&means)
        })
        .collect()
}

/// Of so many rows drawn with replacement, the sum; `OF_ONE` indices from each random number. Four sums side by side, so that one addition
/// need not wait for the one before.
fn sum_of_draws<const OF_ONE: usize>(column: &[f64], count: usize, draws: &mut Draws) -> f64 {
    let rows = column.len() as u64;
    let mut sums = [0.0; 4];
    for _ in 0..count / 4 {
        for part in sums.chunks_exact_mut(OF_ONE) {
            let mut bits = draws.bits();
            for sum in part {
                *sum += column[take(&mut bits, rows)];
            }
        }
    }
    for part in sums[..count % 4].chunks_mut(OF_ONE) {
        let mut bits = draws.bits();
        for sum in part {
            *sum += column[take(&mut bits, rows)];
        }
    }
    (sums[0] + sums[1]) + (sums[2] + sums[3])
}

/// The rows that [`sum_of_draws`] draws, in the same order.
fn draw_rows<const OF_ONE: usize>(drawn: &mut [u32], rows: usize, draws: &mut Draws) {
    for part in drawn.chunks_mut(OF_ONE) {
        let mut bits = draws.bits();
        for row in part {
            // Below ROWS_MAX.
            #[allow(clippy::cast_possible_truncation)]
            {
                *row = take(&mut bits, rows as u64) as u32;
            }
        }
    }
}

/// The sum over the rows drawn, in the order of [`sum_of_draws`].
fn sum_of(column: &[f64], drawn: &[u32]) -> f64 {
    let mut sums = [0.0; 4];
    for four in drawn.chunks(4) {
        for (sum, row) in sums.iter_mut().zip(four) {
            *sum += column[*row as usize];
        }
    }
    (sums[0] + sums[1]) + (sums[2] + sums[3])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn column(values: &[f64]) -> Blocks {
        Blocks::new(vec![values.to_vec()]).unwrap()
    }

    fn identity(means: &[f64]) -> f64 {
        means[0]
    }

    const SKEWED: [f64; 5] = [1.0, 1.3, 2.1, 3.9, 9.7];

    /// All 5^5 resamples, each as likely as the others, and the definitions written out on them.
    #[test]
    fn random_resamples_agree_with_the_list_of_all() {
        let statistic = |mean: f64| mean.sqrt();
        let mut all: Vec<f64> = (0..3125_usize)
            .map(|code| (0..5).map(|i| SKEWED[code / 5_usize.pow(i) % 5]).sum::<f64>() / 5.0)
            .map(statistic)
            .collect();
        all.sort_by(f64::total_cmp);
        let value = statistic(SKEWED.iter().sum::<f64>() / 5.0);
        let below = all.iter().filter(|v| **v < value - 1e-9).count() as f64;
        let equal = all.iter().filter(|v| (**v - value).abs() <= 1e-9).count() as f64;
        let normal = Normal::standard();
        let z0 = normal.inverse_cdf((below + 0.5 * equal) / 3125.0);
        let left: Vec<f64> = SKEWED.iter().map(|x| statistic((18.0 - x) / 4.0)).collect();
        let centre = left.iter().sum::<f64>() / 5.0;
        let cubes: f64 = left.iter().map(|v| (centre - v).powi(3)).sum();
        let squares: f64 = left.iter().map(|v| (centre - v).powi(2)).sum();
        let a = cubes / (6.0 * squares.powf(1.5));

        let found = bca(&column(&SKEWED), &|m| statistic(m[0]), 400_000, 7, 0.95).unwrap();
        assert!((found.value - value).abs() < 1e-12 && (found.acceleration - a).abs() < 1e-12);
        assert!((found.bias_correction - z0).abs() < 0.01, "{found:?} {z0}");
        for (end, z) in [(found.lower, -1.959_964), (found.upper, 1.959_964)] {
            let share = normal.cdf(z0 + (z0 + z) / (1.0 - a * (z0 + z)));
            // Half a per cent of all resamples either side is the noise of the draws.
            let (low, high) = (quantile(&all, (share - 0.002).max(0.0)), quantile(&all, (share + 0.002).min(1.0)));
            assert!(low - 1e-9 <= end && end <= high + 1e-9, "{end}: {low} to {high}");
        }
        assert!(equal > 100.0, "resamples that hold every row once are part of the question");
    }

    #[test]
    fn the_other_sign_gives_the_other_ends() {
        let found = bca(&column(&SKEWED), &identity, 2000, 5, 0.9).unwrap();
        let turned = bca(&column(&SKEWED.map(|v| -v)), &identity, 2000, 5, 0.9).unwrap();
        assert!((found.lower + turned.upper).abs() < 1e-9 && (found.upper + turned.lower).abs() < 1e-9);
        assert!(found.lower < found.value && found.value < found.upper);
        // Skewed to the right: the interval reaches further there.
        assert!(found.upper - found.value > found.value - found.lower);
    }

    #[test]
    fn one_column_among_several_is_drawn_as_one_by_itself() {
        for rows in [7, 40, 3000] {
            let values: Vec<f64> = (0..rows).map(|i| f64::from(i * i % 101)).collect();
            let alone = bca(&column(&values), &identity, 500, 11, 0.95).unwrap();
            let other = values.iter().map(|v| v * v).collect();
            let both = Blocks::new(vec![values, other]).unwrap();
            assert_eq!(bca(&both, &identity, 500, 11, 0.95).unwrap(), alone);
        }
    }

    /// The mean of 500 normal-like numbers: the interval is m ± 1.96 s/√n.
    #[test]
    fn of_many_rows_it_is_the_interval_of_the_normal_distribution() {
        let mut draws = Draws::new(1, "test");
        let values: Vec<f64> = (0..500).map(|_| (0..12).map(|_| draws.uniform()).sum::<f64>()).collect();
        let mean = values.iter().sum::<f64>() / 500.0;
        let std = (values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / 499.0).sqrt();
        let half = 1.96 * std / 500.0_f64.sqrt();
        let found = bca(&column(&values), &identity, 40_000, 3, 0.95).unwrap();
        assert!((found.lower - (mean - half)).abs() < 0.05 * half, "{found:?} {mean} {half}");
        assert!((found.upper - (mean + half)).abs() < 0.05 * half, "{found:?} {mean} {half}");
    }

    #[test]
    fn the_seed_alone_decides() {
        let of = |seed| bca(&column(&SKEWED), &identity, 1001, seed, 0.95).unwrap();
        assert_eq!(of(4), of(4));
        assert_ne!(of(4), of(5));
    }

    #[test]
    fn what_has_no_interval_says_why() {
        let new = |values: &[f64]| Blocks::new(vec![values.to_vec()]);
        assert_eq!(new(&[1.0]), Err(NoInterval::TooFewRows));
        assert_eq!(new(&[]), Err(NoInterval::TooFewRows));
        assert_eq!(new(&[1.0, f64::NAN]), Err(NoInterval::NotFinite));
        assert_eq!(Blocks::new(vec![]), Err(NoInterval::Uneven));
        assert_eq!(Blocks::new(vec![vec![1.0, 2.0], vec![1.0]]), Err(NoInterval::Uneven));
        let of = |values: &[f64], level| bca(&column(values), &identity, 500, 1, level);
        // 0.1 has no exact sum: equal up to rounding is equal.
        assert_eq!(of(&[0.1; 7], 0.95), Err(NoInterval::NoScatter));
        assert_eq!(of(&[0.0; 3], 0.95), Err(NoInterval::NoScatter));
        for level in [0.0, 1.0, f64::NAN] {
            assert_eq!(of(&SKEWED, level), Err(NoInterval::OutOfDomain));
        }
        assert_eq!(bca(&column(&SKEWED), &|m| (m[0] - 4.0).sqrt(), 500, 1, 0.95), Err(NoInterval::NotFinite));
        assert_eq!(bca(&column(&SKEWED), &|_| 1.0, 500, 1, 0.95), Err(NoInterval::NoScatter));
        // Beyond every resample.
        let edge = |m: &[f64]| -(m[0] - 3.6).abs();
        assert_eq!(bca(&column(&SKEWED), &edge, 500, 1, 0.95), Err(NoInterval::OneSided));
        // Two rows have an interval of a kind, and it is made of numbers.
        let two = of(&[1.0, 2.0], 0.95).unwrap();
        assert!(two.lower >= 1.0 && two.upper <= 2.0);
    }

    /// A moving average of ten: neighbours know of each other, and rows that do not say so promise √10 too much.
    #[test]
    fn blocks_of_a_series_see_what_single_samples_hide() {
        let mut draws = Draws::new(9, "series");
        let raw: Vec<f64> = (0..4009).map(|_| draws.uniform() - 0.5).collect();
        let series: Vec<f64> = raw.windows(10).map(|w| w.iter().sum::<f64>() / 10.0).collect();
        let length = block_length(&series).unwrap();
        assert!((10..=120).contains(&length), "{length}");
        let width = |blocks: &Blocks| {
            let found = bca(blocks, &identity, 4000, 1, 0.95).unwrap();
            found.upper - found.lower
        };
        let blocks = blocks_of(&[&series], length).unwrap();
        assert_eq!((blocks.rows(), blocks.draws()), (4000, 4000 / length));
        // The mean of 4000 uniform numbers, each of variance 1/12.
        let true_width = 2.0 * 1.96 * (1.0 / 12.0 / 4000.0_f64).sqrt();
        assert!((width(&blocks) / true_width - 1.0).abs() < 0.25, "{} {true_width}", width(&blocks));
        assert!(width(&column(&series)) < 0.4 * true_width);
    }

    #[test]
    fn all_blocks_together_are_the_series() {
        let series = [1.0, 5.0, 2.0, 8.0, 4.0];
        let blocks = blocks_of(&[&series], 2).unwrap();
        assert_eq!(blocks.columns[0], [3.0, 3.5, 5.0, 6.0, 2.5]);
        assert_eq!((blocks.means()[0], blocks.draws()), (4.0, 2));
        for length in [0, 3, 6] {
            assert_eq!(blocks_of(&[&series], length), Err(NoInterval::OutOfDomain));
        }
        assert_eq!(blocks_of(&[&series, &series[..4]], 2), Err(NoInterval::Uneven));
        assert_eq!(block_length(&[2.5; 40]), Err(NoInterval::NoScatter));
        assert_eq!(block_length(&[1.0; 4]), Err(NoInterval::TooFewRows));
    }
}
