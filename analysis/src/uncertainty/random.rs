//! Random numbers that depend on the seed and on what they are for, and on nothing else. The same on every machine.

use rand_pcg::Pcg64Mcg;
use rand_pcg::rand_core::Rng;

/// 1 / 2^53: the spacing of uniform numbers.
const STEP: f64 = 1.0 / (1_u64 << 53) as f64;

/// Numbers for one purpose.
#[derive(Debug, Clone)]
pub struct Draws(Pcg64Mcg);

impl Draws {
    /// Those of a seed and a purpose: `"bootstrap"`, the name of an input.
    pub fn new(seed: u64, purpose: &str) -> Self {
        // FNV-1a over both, 128 bits wide.
        let bytes = seed.to_le_bytes().into_iter().chain(purpose.bytes());
        let hash = bytes.fold(0x6c62_272e_07bb_0142_62b8_2175_6295_c58d_u128, |hash, byte| {
            (hash ^ u128::from(byte)).wrapping_mul(0x0100_0000_0000_0000_0000_013b)
        });
        // The generator wants an odd state; neighbours part after some steps.
        let mut draws = Self(Pcg64Mcg::new(hash | 1));
        for _ in 0..8 {
            draws.bits();
        }
        draws
    }

    /// The next 64 random bits.
    #[inline]
    pub fn bits(&mut self) -> u64 {
        self.0.next_u64()
    }

    /// The next number of the open interval from 0 to 1: never one of its ends, so that every quantile of it is finite.
    pub fn uniform(&mut self) -> f64 {
        ((self.bits() >> 11) as f64 + 0.5) * STEP
    }

    /// An index below `n`. Each is as likely as another, but for a share of n / 2^64.
    pub fn below(&mut self, n: usize) -> usize {
        take(&mut self.bits(), n as u64)
    }
}

/// An index below `n` from random bits, which are then the bits that are left: the high word of bits × n is the index, the low
/// word is as good as fresh for further indices as long as the product of all ranges is far below 2^64 (several dice from one
/// number, after Lemire). Of m indices below n, every m-tuple is as likely as another, but for a share of n^m / 2^64.
#[inline]
pub fn take(bits: &mut u64, n: u64) -> usize {
    let product = u128::from(*bits) * u128::from(n);
    // The low word, on purpose.
    #[allow(clippy::cast_possible_truncation)]
    {
        *bits = product as u64;
        (product >> 64) as usize
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn several_indices_of_one_number_are_uniform_and_know_nothing_of_each_other() {
        let (n, words) = (7_u64, 70_000);
        let mut draws = Draws::new(3, "dice");
        let (mut counts, mut pairs) = ([0_u32; 7], [[0_u32; 7]; 7]);
        for _ in 0..words {
            let mut bits = draws.bits();
            let four: [usize; 4] = std::array::from_fn(|_| take(&mut bits, n));
            for index in four {
                counts[index] += 1;
            }
            pairs[four[0]][four[3]] += 1;
        }
        // Six standard deviations of a count.
        let near = |count: u32, expected: f64| (f64::from(count) - expected).abs() < 6.0 * expected.sqrt();
        assert!(counts.iter().all(|c| near(*c, 40_000.0)), "{counts:?}");
        assert!(pairs.iter().flatten().all(|c| near(*c, 70_000.0 / 49.0)), "{pairs:?}");
    }

    #[test]
    fn uniform_numbers_keep_off_the_ends_and_purposes_part() {
        let series = |seed: u64, purpose: &str| -> Vec<f64> {
            let mut draws = Draws::new(seed, purpose);
            (0..10_000).map(|_| draws.uniform()).collect()
        };
        let a = series(1, "a");
        assert!(a.iter().all(|u| *u > 0.0 && *u < 1.0));
        assert!((a.iter().sum::<f64>() / 10_000.0 - 0.5).abs() < 0.02);
        let b = series(1, "b");
        let together = |b: &[f64]| a.iter().zip(b).map(|(a, b)| (a - 0.5) * (b - 0.5)).sum::<f64>() / 10_000.0;
        assert!(together(&b).abs() < 0.005 && together(&series(2, "a")).abs() < 0.005);
        assert_eq!(a, series(1, "a"));
    }
}
