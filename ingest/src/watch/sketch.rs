//! A distribution of positive numbers in bounded memory.

/// Bits of the mantissa that tell one bin from the next at first, and slots of the table of bins at most, half of them in use: bins of
/// at most 0.025 %, in about 100 kB.
const FINE: (u32, usize) = (12, 4096);

/// Bins of at most 6 %, in a few kB.
const COARSE: (u32, usize) = (4, 256);

/// Slots at first.
const SLOTS_MIN: usize = 16;

/// Positive numbers, counted in bins of equal relative width: the top bits of a double are its bin.
///
/// A bin remembers its smallest and its largest number. A median lies between those of its bin as if the bin were evenly filled: it is
/// off by less than a bin is wide, and exact where all numbers of its bin are equal. Where numbers scatter over more bins than the table holds, bins are made twice as wide, again and again.
#[derive(Debug, Clone)]
pub(crate) struct Sketch {
    /// Bits of a double below those that are its bin.
    shift: u32,
    slots_max: usize,
    bins: Vec<Bin>,
    used: usize,
    count: u64,
}

#[derive(Debug, Clone, Copy, Default)]
struct Bin {
    /// The bin's bits and one, so that 0 is a free slot.
    key: u32,
    count: u32,
    min: f64,
    max: f64,
}

impl Sketch {
    /// Good to a few parts in ten thousand.
    pub fn fine() -> Self {
        Self::new(FINE)
    }

    /// Good to a few per cent.
    pub fn coarse() -> Self {
        Self::new(COARSE)
    }

    fn new((bits, slots_max): (u32, usize)) -> Self {
        Self { shift: f64::MANTISSA_DIGITS - 1 - bits, slots_max, bins: Vec::new(), used: 0, count: 0 }
    }

    /// Adds a number; what is not finite and above 0 has no bin and is passed over.
    #[inline]
    pub fn add(&mut self, value: f64) {
        if value > 0.0 && value < f64::INFINITY {
            self.count += 1;
            #[expect(clippy::cast_possible_truncation, reason = "of a positive double 11 and 12 bits are left")]
            let key = (value.to_bits() >> self.shift) as u32 + 1;
            self.put(Bin { key, count: 1, min: value, max: value });
        }
    }

    /// Numbers so far.
    pub fn count(&self) -> u64 {
        self.count
    }

    #[inline]
    fn put(&mut self, bin: Bin) {
        let mask = self.bins.len().wrapping_sub(1);
        // Neighbouring bins lie in neighbouring slots: a search that goes on from slot to slot is short.
        let mut slot = bin.key as usize & mask;
        // Half of the slots are free, so the search ends; without slots there is nothing to search.
        while let Some(there) = self.bins.get_mut(slot) {
            if there.key == bin.key {
                there.count = there.count.saturating_add(bin.count);
                there.min = there.min.min(bin.min);
                there.max = there.max.max(bin.max);
                return;
            }
            if there.key == 0 {
                if 2 * (self.used + 1) > mask + 1 {
                    break;
                }
                *there = bin;
                self.used += 1;
                return;
            }
            slot = (slot + 1) & mask;
        }
        self.grow(bin);
    }

    /// More slots, or wider bins where there are as many as there may be; then the bin that found no place.
    #[cold]
    fn grow(&mut self, bin: Bin) {
        let slots = (2 * self.bins.len()).clamp(SLOTS_MIN, self.slots_max);
        let wider = u32::from(slots == self.bins.len());
        self.shift += wider;
        let old = std::mem::replace(&mut self.bins, vec![Bin::default(); slots]);
        self.used = 0;
        for bin in old.into_iter().filter(|b| b.key != 0).chain([bin]) {
            self.put(Bin { key: ((bin.key - 1) >> wider) + 1, ..bin });
        }
    }

    /// What is in the bins, from the smallest number up.
    pub fn sorted(&self) -> Sorted {
        let mut bins: Vec<Bin> = self.bins.iter().copied().filter(|b| b.key != 0).collect();
        bins.sort_unstable_by_key(|b| b.key);
        Sorted(bins)
    }

    /// The median: for an even number of numbers between the two in the middle.
    pub fn median(&self) -> Option<f64> {
        let last = self.count.checked_sub(1)?;
        let sorted = self.sorted();
        Some(f64::midpoint(sorted.ranked(last / 2)?, sorted.ranked(self.count / 2)?))
    }
}

/// The numbers of a sketch in order, each as well as its bin knows it.
pub(crate) struct Sorted(Vec<Bin>);

impl Sorted {
    /// The number of a rank, from 0.
    pub fn ranked(&self, rank: u64) -> Option<f64> {
        let mut before = 0;
        self.0.iter().find_map(|bin| {
            let within = rank - before;
            before += u64::from(bin.count);
            let share = (within as f64 + 0.5) / f64::from(bin.count);
            (rank < before).then_some(bin.min + (bin.max - bin.min) * share)
        })
    }

    /// How many numbers are above a limit; those of a bin on both sides of it as if the bin were evenly filled.
    pub fn above(&self, limit: f64) -> u64 {
        let above = |bin: &Bin| {
            if bin.min > limit {
                f64::from(bin.count)
            } else if bin.max > limit {
                f64::from(bin.count) * (bin.max - limit) / (bin.max - bin.min)
            } else {
                0.0
            }
        };
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a share of a count")]
        self.0.iter().map(|bin| above(bin).round() as u64).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Numbers that look random and are the same on every run, evenly between 0 and 1.
    fn random(state: &mut u64) -> f64 {
        *state ^= *state << 13;
        *state ^= *state >> 7;
        *state ^= *state << 17;
        (*state >> 11) as f64 / (1_u64 << 53) as f64
    }

    #[test]
    fn equal_numbers_have_themselves_as_median() {
        let mut sketch = Sketch::fine();
        assert_eq!(sketch.median(), None);
        for value in [0.25, f64::NAN, 0.0, -1.0, f64::INFINITY] {
            sketch.add(value);
        }
        assert_eq!((sketch.count(), sketch.median()), (1, Some(0.25)));
        sketch.add(0.75);
        assert_eq!(sketch.median(), Some(0.5));
    }

    #[test]
    fn the_median_is_good_to_a_few_parts_in_ten_thousand_and_memory_is_bounded() {
        let mut state = 42;
        // From numbers close together, which keep narrow bins, to numbers of all sizes, which ask for wider ones.
        for (octaves, off_max) in [(0.01, 2e-5), (1.0, 2e-5), (20.0, 4e-4)] {
            let mut sketch = Sketch::fine();
            let mut all: Vec<f64> = (0..100_001).map(|_| 0.01 * f64::exp2(octaves * random(&mut state))).collect();
            for value in &all {
                sketch.add(*value);
            }
            all.sort_by(f64::total_cmp);
            let (exact, median) = (all[50_000], sketch.median().unwrap());
            assert!((median / exact - 1.0).abs() < off_max, "{octaves} octaves: {median} for {exact}");
            assert!(sketch.bins.len() <= FINE.1);
            assert_eq!(sketch.sorted().above(0.0), 100_001);
            let above = all.iter().filter(|v| **v > 1.5 * exact).count() as u64;
            assert!(sketch.sorted().above(1.5 * exact).abs_diff(above) < 20);
        }
    }
}
