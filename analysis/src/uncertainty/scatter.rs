//! What repeats say of the scatter of their mean.
//!
//! Two repeats know the scatter of one point with one degree of freedom: Student's factor is then 12.7, and nothing can be decided. But
//! they pass many points. What a repeat has in common over its points is told apart from what is each point's own,
//!
//! ```text
//! x_ki - x̄_i = α_k + β_k x̄_i + w_ki
//! ```
//!
//! α an offset (the mounting, the tare), β a share of the response (the supply, the stiffness of the day), per component. What is common keeps
//! its n - 1 degrees of freedom. What remains is pooled: σ² = Σ w²/ν, ν = (n - 1)(p - r), p values and r columns of the common part, each component by itself, and
//! the mean has of it the covariance σ²/n (1 - P), P the projection on the common part. Both together are without bias for any metric
//! that is linear in the values.
//!
//! This assumes that nothing but offset and share moves neighbouring points together and that no point scatters more than the others, and both
//! are asked of the data: where the products of neighbouring w are larger than chance makes them in one session of twenty, or the
//! largest w² than in one of twenty, or where loading and unloading differ by more than in one of ten, nothing is pooled. From [`FROM`] repeats on nothing is
//! assumed: each value is known by its own repeats.

use nalgebra::{DMatrix, DVector};
use statrs::distribution::{ContinuousCDF, FisherSnedecor};

/// The 95 % quantile of the standard normal distribution: chance goes beyond it in one of twenty.
const Z_ONE_SIDED: f64 = 1.644_853_626_951_472_7;

/// One point may scatter more than the others by a chance of so much.
const UNEVEN_BY_CHANCE: f64 = 0.05;

/// Repeats from which each value is known by its own well enough.
pub const FROM: usize = 20;

/// Values beyond which there is enough to know each by itself, or to pool by a simpler way.
const VALUES_MAX: usize = 256;

/// A loop may seem to scatter by a chance of so much. Few points and repeats see only a gross one, and a loop area lives on it: so the chance is
/// large.
const LOOP_BY_CHANCE: f64 = 0.1;

/// A value of which the common part leaves less than this share says nothing of its own scatter.
const LEFT_MIN: f64 = 0.05;

/// Degrees of freedom below which pooling is worth little.
const FREEDOM_MIN: usize = 5;

/// A column of the common part that is so much the others', as a share of its length, adds nothing to them.
const INDEPENDENT_SHARE: f64 = 1e-6;

/// The scatter of the mean of few repeats, told apart. Directions are one standard uncertainty of the mean each.
#[derive(Debug, Clone, PartialEq)]
pub struct Scatter {
    /// What each repeat has in common over the values: repeats × values.
    pub common: Vec<Vec<f64>>,
    /// What is each value's own.
    pub own: Vec<Vec<f64>>,
    /// Degrees of freedom of what is each value's own.
    pub freedom: usize,
}

/// Why a scatter is not pooled.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Apart {
    /// It need not or cannot be: many repeats, one, few values or very many, or no scatter.
    Plain,
    /// Neighbouring values deviate together.
    Together,
    /// One value scatters more than the others.
    Uneven,
    /// Loading and unloading deviate from each other: the loop scatters.
    Loop,
}

/// The scatter of the means of values, each of `width` components one after the other, by the deviations of each repeat from the mean
/// over all repeats (repeats × values), and whether each was read on the way down.
///
/// # Errors
/// Why it is not told apart and pooled.
pub fn scatter(deviations: &[Vec<f64>], means: &[f64], is_down: &[bool], width: usize) -> Result<Scatter, Apart> {
    let (n, p) = (deviations.len(), means.len());
    if !(2..FROM).contains(&n)
        || !(1..=VALUES_MAX).contains(&p)
        || is_down.len() != p
        || deviations.iter().any(|d| d.len() != p)
    {
        return Err(Apart::Plain);
    }
    let basis = common_part(means, width);
    // Of one component.
    let freedom = (n - 1) * (p / width).saturating_sub(basis.len().div_ceil(width));
    if freedom < FREEDOM_MIN || !deviations.iter().flatten().chain(means).all(|x| x.is_finite()) {
        return Err(Apart::Plain);
    }
    let mut rest = DMatrix::identity(p, p);
    for column in &basis {
        rest -= column * column.transpose();
    }
    let own: Vec<DVector<f64>> = deviations.iter().map(|d| &rest * DVector::from_column_slice(d)).collect();
    // Components are apart: each has a scatter of its own.
    let mut of_means = Vec::with_capacity(width);
    for component in 0..width {
        let places: Vec<usize> = (component..p).step_by(width).collect();
        let rest = rest.select_rows(&places).select_columns(&places);
        let own: Vec<DVector<f64>> = own.iter().map(|w| w.select_rows(&places)).collect();
        let squares: f64 = own.iter().map(DVector::norm_squared).sum();
        if squares <= 0.0 {
            return Err(Apart::Plain);
        }
        if is_uneven(&rest, &own, n) {
            return Err(Apart::Uneven);
        }
        if moves_together(&rest, &own, n) {
            return Err(Apart::Together);
        }
        let is_down: Vec<bool> = places.iter().map(|&i| is_down[i]).collect();
        if has_loop(&rest, &own, &is_down, n) {
            return Err(Apart::Loop);
        }
        of_means.push((squares / ((n - 1) as f64 * rest.trace()) / n as f64).sqrt());
    }
    let scale = ((n * (n - 1)) as f64).sqrt();
    let common =
        deviations.iter().zip(&own).map(|(d, w)| d.iter().zip(w.iter()).map(|(d, w)| (d - w) / scale).collect());
    Ok(Scatter {
        common: common.collect(),
        own: (0..p).map(|i| rest.column(i).iter().map(|x| x * of_means[i % width]).collect()).collect(),
        freedom,
    })
}

/// Offset and share of each component, orthonormal.
fn common_part(means: &[f64], width: usize) -> Vec<DVector<f64>> {
    let mut basis: Vec<DVector<f64>> = Vec::new();
    for component in 0..width {
        let of = |value: &dyn Fn(f64) -> f64| {
            let one = |(i, mean): (usize, &f64)| if i % width == component { value(*mean) } else { 0.0 };
            DVector::from_vec(means.iter().enumerate().map(one).collect())
        };
        for column in [of(&|_| 1.0), of(&|mean| mean)] {
            let length = column.norm();
            let mut left = column;
            for known in &basis {
                let along = known.dot(&left);
                left -= known * along;
            }
            let norm = left.norm();
            if norm > INDEPENDENT_SHARE * length {
                basis.push(left / norm);
            }
        }
    }
    basis
}

/// Whether one value scatters more than the others: its share of the squares (Cochran's C, 1941), against what chance makes of the
/// largest of so many.
fn is_uneven(rest: &DMatrix<f64>, own: &[DVector<f64>], n: usize) -> bool {
    let p = rest.nrows();
    // A value that the common part follows keeps less of its own.
    let square = |i: usize| own.iter().map(|w| w[i] * w[i]).sum::<f64>() / rest[(i, i)];
    let squares: Vec<f64> = (0..p).filter(|&i| rest[(i, i)] > LEFT_MIN).map(square).collect();
    let (groups, freedom) = (squares.len() as f64, (n - 1) as f64);
    let share = squares.iter().copied().fold(0.0, f64::max) / squares.iter().sum::<f64>();
    let Ok(distribution) = FisherSnedecor::new(freedom, freedom * (groups - 1.0)) else { return false };
    let f = distribution.inverse_cdf(1.0 - UNEVEN_BY_CHANCE / groups);
    share > 1.0 / (1.0 + (groups - 1.0) / f)
}

/// Whether what was read on the way down deviates from what was read on the way up: the square along that contrast against the others.
fn has_loop(rest: &DMatrix<f64>, own: &[DVector<f64>], is_down: &[bool], n: usize) -> bool {
    let contrast = rest * DVector::from_iterator(is_down.len(), is_down.iter().map(|down| f64::from(u8::from(*down))));
    let length = contrast.norm();
    if length <= INDEPENDENT_SHARE * (is_down.len() as f64).sqrt() {
        return false;
    }
    let along: f64 = own.iter().map(|w| (contrast.dot(w) / length).powi(2)).sum();
    let squares: f64 = own.iter().map(DVector::norm_squared).sum();
    let (freedom, others) = ((n - 1) as f64, (n - 1) as f64 * (rest.trace() - 1.0));
    let Ok(distribution) = FisherSnedecor::new(freedom, others) else { return false };
    along / freedom > distribution.inverse_cdf(1.0 - LOOP_BY_CHANCE) * (squares - along) / others
}

/// Whether neighbouring values deviate together: the share of the products of neighbours in the squares, against its mean and variance
/// for values of their own, projected as these are.
fn moves_together(rest: &DMatrix<f64>, own: &[DVector<f64>], n: usize) -> bool {
    let p = rest.nrows();
    let neighbours = |w: &DVector<f64>| (1..p).map(|i| w[i] * w[i - 1]).sum::<f64>();
    let squares: f64 = own.iter().map(DVector::norm_squared).sum();
    let share = own.iter().map(neighbours).sum::<f64>() / squares;
    // M A, A with one half beside the diagonal on either side.
    let half = |i: usize, j: usize| if i.abs_diff(j) == 1 { 0.5 } else { 0.0 };
    let product = rest * DMatrix::from_fn(p, p, half);
    let dimensions = (n - 1) as f64;
    let freedom = dimensions * rest.trace();
    let (tr1, tr2) = (dimensions * product.trace(), dimensions * (&product * &product).trace());
    let mean = tr1 / freedom;
    let variance = 2.0 * (freedom * tr2 - tr1 * tr1) / (freedom * freedom * (freedom + 2.0));
    share > mean + Z_ONE_SIDED * variance.max(0.0).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand_distr::{Distribution, StandardNormal};
    use rand_pcg::Pcg64Mcg;

    /// Deviations of `n` repeats from their mean, of values that each repeat draws.
    fn deviations(n: usize, p: usize, draw: &mut dyn FnMut(usize) -> f64) -> Vec<Vec<f64>> {
        let drawn: Vec<Vec<f64>> = (0..n).map(|_| (0..p).map(&mut *draw).collect()).collect();
        let mean: Vec<f64> = (0..p).map(|i| drawn.iter().map(|d| d[i]).sum::<f64>() / n as f64).collect();
        drawn.iter().map(|d| d.iter().zip(&mean).map(|(x, m)| x - m).collect()).collect()
    }

    fn variance(directions: &[Vec<f64>], weights: &[f64]) -> f64 {
        let along = |d: &Vec<f64>| d.iter().zip(weights).map(|(d, w)| d * w).sum::<f64>().powi(2);
        directions.iter().map(along).sum()
    }

    #[test]
    fn the_variance_of_any_sum_of_values_is_without_bias_and_what_is_common_is_not_pooled() {
        let mut generator = Pcg64Mcg::new(7);
        let means: Vec<f64> = (0..11).map(|i| 5.0 + f64::from(i * i)).collect();
        let weights: Vec<f64> = (0..11).map(|i| f64::from(i % 3) - 0.4).collect();
        let (mut sum, mut kept, trials) = (0.0, 0, 4000);
        for _ in 0..trials {
            let mut normal = || -> f64 { StandardNormal.sample(&mut generator) };
            let common: Vec<(f64, f64)> = (0..2).map(|_| (0.3 * normal(), 0.02 * normal())).collect();
            let mut k = 0;
            let found = deviations(2, 11, &mut |i| {
                let (offset, share) = common[k / 11];
                k += 1;
                offset + share * means[i] + 0.5 * normal()
            });
            let Ok(found) = scatter(&found, &means, &[false; 11], 1) else { continue };
            assert_eq!(found.freedom, 9);
            kept += 1;
            sum += variance(&found.common, &weights) + variance(&found.own, &weights);
        }
        // By hand: half of (Σw)² 0.3² + (Σ w m)² 0.02² + Σ w² 0.5².
        let of = |f: &dyn Fn(usize) -> f64| (0..11).map(f).sum::<f64>();
        let expected = 0.5
            * (of(&|i| weights[i]).powi(2) * 0.09
                + of(&|i| weights[i] * means[i]).powi(2) * 0.0004
                + of(&|i| weights[i].powi(2)) * 0.25);
        let mean = sum / f64::from(kept);
        assert!((mean / expected - 1.0).abs() < 0.08, "{mean} {expected}");
        // One of twenty is taken for one whose points move together, one of twenty for an uneven one.
        let share = f64::from(kept) / f64::from(trials);
        assert!((0.87..0.94).contains(&share), "{share}");
    }

    #[test]
    fn values_that_move_together_are_not_pooled() {
        let means: Vec<f64> = (0..21).map(f64::from).collect();
        // One way on the first half, the other on the second: a loop that grows from repeat to repeat.
        let found = deviations(2, 21, &mut {
            let mut k = 0;
            move |i| {
                k += 1;
                let grown = if k > 21 { 1.0 } else { 0.0 };
                grown * (f64::from(u8::try_from(i).unwrap()) * 0.3).sin()
                    + 0.01 * f64::from(u8::try_from(i % 2).unwrap())
            }
        });
        assert_eq!(scatter(&found, &means, &[false; 21], 1), Err(Apart::Together));
        // A snap at one pressure, which comes earlier or later.
        let mut generator = Pcg64Mcg::new(5);
        let mut normal = || -> f64 { StandardNormal.sample(&mut generator) };
        let found = deviations(2, 21, &mut |i| if i == 12 { 20.0 * normal() } else { normal() });
        assert_eq!(scatter(&found, &means, &[false; 21], 1), Err(Apart::Uneven));
    }

    #[test]
    fn a_loop_that_scatters_is_not_pooled() {
        let mut generator = Pcg64Mcg::new(9);
        let means: Vec<f64> = (0..20).map(|i| f64::from(if i < 10 { i } else { 19 - i })).collect();
        let is_down: Vec<bool> = (0..20).map(|i| i >= 10).collect();
        let (mut k, mut refused) = (0, 0);
        for _ in 0..100 {
            let mut normal = || -> f64 { StandardNormal.sample(&mut generator) };
            let wider = 2.0 * normal();
            let found = deviations(2, 20, &mut |i| {
                k += 1;
                normal() + if is_down[i] && k % 40 < 20 { wider } else { 0.0 }
            });
            refused += u32::from(matches!(scatter(&found, &means, &is_down, 1), Err(Apart::Loop | Apart::Together)));
        }
        assert!((50..=95).contains(&refused), "{refused} of 100");
    }

    #[test]
    fn enough_repeats_one_repeat_few_values_and_no_scatter_are_left_as_they_are() {
        let mut generator = Pcg64Mcg::new(3);
        let means: Vec<f64> = (0..11).map(f64::from).collect();
        let mut normal = |_: usize| -> f64 { StandardNormal.sample(&mut generator) };
        assert_eq!(scatter(&deviations(FROM, 11, &mut normal), &means, &[false; 11], 1), Err(Apart::Plain));
        assert_eq!(scatter(&deviations(1, 11, &mut normal), &means, &[false; 11], 1), Err(Apart::Plain));
        assert_eq!(scatter(&deviations(2, 3, &mut normal), &means[..3], &[false; 3], 1), Err(Apart::Plain));
        assert_eq!(scatter(&deviations(2, 11, &mut |_| 1.0), &means, &[false; 11], 1), Err(Apart::Plain));
        assert_eq!(scatter(&[], &[], &[], 1), Err(Apart::Plain));
        assert_eq!(scatter(&deviations(2, 11, &mut |_| f64::NAN), &means, &[false; 11], 1), Err(Apart::Plain));
    }
}
