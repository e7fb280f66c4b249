//! What few repeats say of the scatter of their mean.
//!
//! Two repeats know the scatter of one point with one degree of freedom: Student's factor is then 12.7, and nothing can be decided. But
//! they pass many points. What a repeat has in common over its points is told apart from what is each point's own,
//!
//! ```text
//! x_ki - x̄_i = α_k + β_k x̄_i + w_ki
//! ```
//!
//! α an offset (the mounting, the tare), β a share of the response (the supply, the stiffness of the day), per component. What is common keeps
//! its n - 1 degrees of freedom. What remains is pooled: σ² = Σ w²/ν, ν = (n - 1)(p - r), p values and r columns of the common part, and
//! the mean has of it the covariance σ²/n (1 - P), P the projection on the common part. Both together are without bias for any metric
//! that is linear in the values.
//!
//! This assumes that nothing but offset and share moves neighbouring points together, and that is asked of the data: where the products of
//! neighbouring w are larger than chance makes them in one session of twenty, nothing is pooled. From [`FROM`] repeats on nothing is
//! assumed: each value is known by its own repeats.

use nalgebra::{DMatrix, DVector};

/// The 95 % quantile of the standard normal distribution: chance goes beyond it in one of twenty.
const Z_ONE_SIDED: f64 = 1.644_853_626_951_472_7;

/// Repeats from which nothing has to be pooled.
pub const FROM: usize = 5;

/// Values beyond which there is enough to know each by itself, or to pool by a simpler way.
const VALUES_MAX: usize = 256;

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

/// The scatter of the means of values, each of `width` components one after the other, by the deviations of each repeat from the mean
/// over all repeats (repeats × values). `None` where it cannot or need not be pooled.
pub fn scatter(deviations: &[Vec<f64>], means: &[f64], width: usize) -> Option<Scatter> {
    let (n, p) = (deviations.len(), means.len());
    if !(2..FROM).contains(&n) || !(1..=VALUES_MAX).contains(&p) || deviations.iter().any(|d| d.len() != p) {
        return None;
    }
    let basis = common_part(means, width);
    let freedom = (n - 1) * p.checked_sub(basis.len())?;
    if freedom < FREEDOM_MIN || !deviations.iter().flatten().chain(means).all(|x| x.is_finite()) {
        return None;
    }
    let mut rest = DMatrix::identity(p, p);
    for column in &basis {
        rest -= column * column.transpose();
    }
    let own: Vec<DVector<f64>> = deviations.iter().map(|d| &rest * DVector::from_column_slice(d)).collect();
    let squares: f64 = own.iter().map(DVector::norm_squared).sum();
    if squares <= 0.0 || moves_together(&rest, &own, n, width) {
        return None;
    }
    let of_mean = (squares / freedom as f64 / n as f64).sqrt();
    let scale = ((n * (n - 1)) as f64).sqrt();
    let common =
        deviations.iter().zip(&own).map(|(d, w)| d.iter().zip(w.iter()).map(|(d, w)| (d - w) / scale).collect());
    Some(Scatter {
        common: common.collect(),
        own: (0..p).map(|i| rest.column(i).iter().map(|x| x * of_mean).collect()).collect(),
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

/// Whether neighbouring values deviate together: the share of the products of neighbours in the squares, against its mean and variance
/// for values of their own, projected as these are.
fn moves_together(rest: &DMatrix<f64>, own: &[DVector<f64>], n: usize, width: usize) -> bool {
    let p = rest.nrows();
    let neighbours = |w: &DVector<f64>| (width..p).map(|i| w[i] * w[i - width]).sum::<f64>();
    let squares: f64 = own.iter().map(DVector::norm_squared).sum();
    let share = own.iter().map(neighbours).sum::<f64>() / squares;
    // M A, A with one half beside the diagonal on either side.
    let half = |i: usize, j: usize| if i.abs_diff(j) == width { 0.5 } else { 0.0 };
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
            let Some(found) = scatter(&found, &means, 1) else { continue };
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
        // One of twenty is taken for one whose points move together.
        let share = f64::from(kept) / f64::from(trials);
        assert!((0.92..0.97).contains(&share), "{share}");
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
        assert_eq!(scatter(&found, &means, 1), None);
    }

    #[test]
    fn enough_repeats_one_repeat_few_values_and_no_scatter_are_left_as_they_are() {
        let mut generator = Pcg64Mcg::new(3);
        let means: Vec<f64> = (0..11).map(f64::from).collect();
        let mut normal = |_: usize| -> f64 { StandardNormal.sample(&mut generator) };
        assert_eq!(scatter(&deviations(FROM, 11, &mut normal), &means, 1), None);
        assert_eq!(scatter(&deviations(1, 11, &mut normal), &means, 1), None);
        assert_eq!(scatter(&deviations(2, 6, &mut normal), &means[..6], 1), None);
        assert_eq!(scatter(&deviations(2, 11, &mut |_| 1.0), &means, 1), None);
        assert_eq!(scatter(&[], &[], 1), None);
        assert_eq!(scatter(&deviations(2, 11, &mut |_| f64::NAN), &means, 1), None);
    }
}
