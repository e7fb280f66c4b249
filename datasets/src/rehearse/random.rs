//! Random numbers that depend on the seed and on what they are for, and on nothing else: another channel, another run or another
//! order changes none of them.

use rand_distr::{Distribution, Open01, StandardNormal};
use rand_pcg::Pcg64Mcg;

/// Random numbers for one purpose, normal ones above all.
#[derive(Debug, Clone)]
pub struct Normal(Pcg64Mcg);

impl Normal {
    /// Those of a seed and a purpose: `"run-1 pressure"`.
    pub fn new(seed: u64, purpose: &str) -> Self {
        // FNV-1a over both, 128 bits wide.
        let bytes = seed.to_le_bytes().into_iter().chain(purpose.bytes());
        let hash = bytes.fold(0x6c62_272e_07bb_0142_62b8_2175_6295_c58d_u128, |hash, byte| {
            (hash ^ u128::from(byte)).wrapping_mul(0x0100_0000_0000_0000_0000_013b)
        });
        // An odd state is what the generator asks for; neighbours part after some steps.
        let mut generator = Self(Pcg64Mcg::new(hash | 1));
        for _ in 0..8 {
            generator.next();
        }
        generator
    }

    /// The next, of mean 0 and variance 1.
    pub fn next(&mut self) -> f64 {
        StandardNormal.sample(&mut self.0)
    }

    /// The next, between 0 and 1, all of it equally likely.
    pub fn even(&mut self) -> f64 {
        Open01.sample(&mut self.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_normal_and_those_of_neighbouring_seeds_and_purposes_have_nothing_in_common() {
        let series = |seed: u64, purpose: &str| -> Vec<f64> {
            let mut normal = Normal::new(seed, purpose);
            (0..20_000).map(|_| normal.next()).collect()
        };
        let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
        let a = series(1, "run-1 pressure");
        let square: Vec<f64> = a.iter().map(|v| v * v).collect();
        assert!(mean(&a).abs() < 0.03 && (mean(&square) - 1.0).abs() < 0.05);
        assert!((a.iter().filter(|v| v.abs() < 1.96).count() as f64 / 20_000.0 - 0.95).abs() < 0.01);
        for b in [series(2, "run-1 pressure"), series(1, "run-2 pressure"), series(0, "run-1 pressure")] {
            let product: Vec<f64> = a.iter().zip(&b).map(|(a, b)| a * b).collect();
            assert!(mean(&product).abs() < 0.03);
        }
        let mut even = Normal::new(1, "instants");
        let even: Vec<f64> = (0..20_000).map(|_| even.even()).collect();
        assert!((mean(&even) - 0.5).abs() < 0.01 && even.iter().all(|v| (0.0..1.0).contains(v)));
        assert!(a.iter().zip(series(1, "run-1 pressure")).all(|(a, b)| a.to_bits() == b.to_bits()));
    }
}
