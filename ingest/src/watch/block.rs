//! Passes over a block of numbers, written so that several numbers are worked on at once.

/// Numbers looked at together: they stay in the cache from one pass to the next.
pub(super) const BLOCK: usize = 1024;

/// Equal numbers in a row that are worth a look.
pub(super) const LONG: usize = 8;

/// Sums that are formed side by side.
const LANES: usize = 8;

/// The samples that the numbers of a block are.
#[derive(Clone, Copy)]
pub(super) enum At<'a> {
    /// Without holes they follow each other from this one on.
    From(usize),
    /// One by one.
    Listed(&'a [usize]),
}

impl At<'_> {
    /// The sample of a number of the block.
    pub fn sample(self, number: usize) -> usize {
        match self {
            Self::From(first) => first + number,
            Self::Listed(samples) => samples.get(number).copied().unwrap_or(0),
        }
    }
}

/// What one look at numbers gives.
pub(super) struct Scan {
    /// Whether every one is a finite number; if not, the rest says nothing. Numbers too large to be added are taken for none at first.
    pub finite: bool,
    pub min: f64,
    pub max: f64,
    pub sum: f64,
}

/// Looks at each number once. The order of the sum depends on nothing but how many there are.
pub(super) fn scan(values: &[f64]) -> Scan {
    let mut min = [f64::INFINITY; LANES];
    let mut max = [f64::NEG_INFINITY; LANES];
    let mut sum = [0.0; LANES];
    let mut look = |i: usize, value: f64| {
        min[i] = if value < min[i] { value } else { min[i] };
        max[i] = if value > max[i] { value } else { max[i] };
        sum[i] += value;
    };
    let (chunks, rest) = values.as_chunks::<LANES>();
    for chunk in chunks {
        for (i, value) in chunk.iter().enumerate() {
            look(i, *value);
        }
    }
    for (i, value) in rest.iter().enumerate() {
        look(i, *value);
    }
    let sum: f64 = sum.iter().sum();
    Scan {
        finite: sum.is_finite(),
        min: min.into_iter().fold(f64::INFINITY, f64::min),
        max: max.into_iter().fold(f64::NEG_INFINITY, f64::max),
        sum,
    }
}

/// Runs of equal numbers in a block, of at least eight: first number and the number behind the last.
// Exactly equal is what is meant, here and below: what an instrument writes again is the same number.
#[expect(clippy::float_cmp)]
#[expect(clippy::needless_bitwise_bool, reason = "without branches several are compared at once")]
pub(super) fn long_runs(values: &[f64], mut found: impl FnMut(usize, usize)) {
    let values = &values[..values.len().min(BLOCK)];
    let Some((_, later)) = values.split_first() else { return };
    // Any eight hold four that begin at a multiple of four. Most columns have no such four.
    let (fours, _) = values.as_chunks::<4>();
    if !fours.iter().fold(false, |any, [a, b, c, d]| any | ((a == b) & (b == c) & (c == d))) {
        return;
    }
    // Whether a number equals the next one, then whether it does so twice, four and seven times in a row: each is worked out for many
    // numbers at once, and without a branch that noise of a coarse converter, which often repeats itself, would make guesswork.
    let mut once = [0_u8; BLOCK + LONG];
    let mut twice = [0_u8; BLOCK + LONG];
    let mut long = [0_u8; BLOCK];
    for ((equal, a), b) in once.iter_mut().zip(values).zip(later) {
        *equal = u8::from(a == b);
    }
    for ((both, a), b) in twice.iter_mut().zip(&once).zip(&once[1..]) {
        *both = a & b;
    }
    for (i, seven) in long.iter_mut().enumerate() {
        *seven = twice[i] & twice[i + 2] & twice[i + 4] & once[i + 6];
    }
    let mut at = 0;
    while let Some(next) = long.get(at..).and_then(first_set) {
        let first = at + next;
        at = first + 1 + once[first..].iter().take_while(|equal| **equal != 0).count();
        found(first, at);
    }
}

/// Where the first byte stands that is not 0.
fn first_set(bytes: &[u8]) -> Option<usize> {
    let (eights, rest) = bytes.as_chunks::<8>();
    let skipped = eights.iter().take_while(|eight| u64::from_ne_bytes(**eight) == 0).count();
    let from = 8 * skipped;
    let rest = if skipped == eights.len() { rest } else { &bytes[from..] };
    rest.iter().position(|byte| *byte != 0).map(|i| from + i)
}

/// The mean size of second differences: of a straight line it is 0, of noise about twice its standard deviation. `None` of fewer than
/// three numbers, and of numbers too large to be subtracted.
pub(super) fn wobble(values: &[f64]) -> Option<f64> {
    let count = values.len().checked_sub(2).filter(|n| *n > 0)?;
    let mut sum = [0.0; LANES];
    let (a, b, c) = (&values[..count], &values[1..=count], &values[2..]);
    let ((a8, a1), (b8, b1), (c8, c1)) = (a.as_chunks::<LANES>(), b.as_chunks::<LANES>(), c.as_chunks::<LANES>());
    for ((a, b), c) in a8.iter().zip(b8).zip(c8) {
        for i in 0..LANES {
            sum[i] += ((c[i] - b[i]) - (b[i] - a[i])).abs();
        }
    }
    for (i, ((a, b), c)) in a1.iter().zip(b1).zip(c1).enumerate() {
        sum[i] += ((c - b) - (b - a)).abs();
    }
    let mean = sum.iter().sum::<f64>() / count as f64;
    mean.is_finite().then_some(mean)
}

/// Four numbers in a row of which none equals its neighbour go to and fro: up, down, up, or the other way round.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(super) struct Zigzags {
    /// All of them.
    pub all: u64,
    /// Those that come back to other numbers than they left, as noise of more than one step of an instrument does.
    pub loose: u64,
}

/// Counts four in a row that go to and fro; no number may equal its neighbour.
#[expect(clippy::float_cmp)]
#[expect(clippy::needless_bitwise_bool, reason = "without branches several are counted at once")]
pub(super) fn zigzags(values: &[f64]) -> Zigzags {
    let Some(count) = values.len().checked_sub(3) else { return Zigzags::default() };
    let (a, b, c, d) = (&values[..count], &values[1..=count], &values[2..count + 2], &values[3..]);
    let (mut all, mut loose) = (0, 0);
    for (((a, b), c), d) in a.iter().zip(b).zip(c).zip(d) {
        let to_and_fro = ((b > a) != (c > b)) & ((c > b) != (d > c));
        all += u64::from(to_and_fro);
        loose += u64::from(to_and_fro & (a != c) & (b != d));
    }
    Zigzags { all, loose }
}

/// Runs of equal numbers among fewer than `SIZE` numbers.
pub(super) struct Runs<const SIZE: usize> {
    /// Their values, and where they begin.
    values: [f64; SIZE],
    starts: [u16; SIZE],
    count: usize,
}

impl<const SIZE: usize> Runs<SIZE> {
    /// The runs of the first numbers, as many as there is place for.
    #[expect(clippy::float_cmp, clippy::cast_possible_truncation, reason = "a block has fewer than 2^16 numbers")]
    pub fn new(values: &[f64]) -> Self {
        let values = &values[..values.len().min(SIZE - 1)];
        let mut runs = Self { values: [0.0; SIZE], starts: [0; SIZE], count: 0 };
        // Every number is written to the next free place and stays there if a run begins with it: no branch to guess.
        let mut last = f64::NAN;
        let mut count = 0;
        for (i, value) in values.iter().enumerate() {
            runs.values[count] = *value;
            runs.starts[count] = i as u16;
            count += usize::from(*value != last);
            last = *value;
        }
        // The slot behind the last run says where that ends.
        runs.starts[count] = values.len() as u16;
        runs.count = count;
        runs
    }

    /// Their values.
    pub fn values(&self) -> &[f64] {
        &self.values[..self.count]
    }

    /// How many numbers each of them has.
    pub fn lengths(&self) -> impl Iterator<Item = usize> {
        self.starts[..=self.count].windows(2).map(|pair| usize::from(pair[1] - pair[0]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_scan_sees_every_number_and_every_hole() {
        let values: Vec<f64> = (0..1003).map(|i| f64::from((i * 37) % 1003)).collect();
        let seen = scan(&values);
        assert!(seen.finite);
        assert_eq!((seen.min, seen.max, seen.sum), (0.0, 1002.0, 1002.0 * 1003.0 / 2.0));
        for hole in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            for at in [0, 7, 500, 1002] {
                let mut values = values.clone();
                values[at] = hole;
                assert!(!scan(&values).finite, "{hole} at {at}");
            }
        }
    }

    #[test]
    fn noise_comes_back_to_other_numbers_and_toggling_to_the_same() {
        assert_eq!(zigzags(&[0.0, 1.0, 0.0, 1.0, 0.0]), Zigzags { all: 2, loose: 0 });
        assert_eq!(zigzags(&[0.0, 2.0, 1.0, 3.0]), Zigzags { all: 1, loose: 1 });
        assert_eq!(zigzags(&[0.0, 1.0, 2.0, 1.0, 0.0]), Zigzags::default());
        assert_eq!(zigzags(&[0.0, 1.0]), Zigzags::default());
    }

    #[test]
    fn a_straight_line_does_not_wobble() {
        let line: Vec<f64> = (0..100).map(|i| 0.5 * f64::from(i)).collect();
        assert_eq!(wobble(&line), Some(0.0));
        assert_eq!(wobble(&[0.0, 1.0, 0.0]), Some(2.0));
        assert_eq!((wobble(&[0.0, 1.0]), wobble(&[1e308, -1e308, 1e308])), (None, None));
    }

    #[test]
    fn runs_begin_where_the_number_changes() {
        let runs = Runs::<9>::new(&[1.0, 1.0, 2.0, 2.0, 2.0, 3.0]);
        assert_eq!(runs.values(), [1.0, 2.0, 3.0]);
        assert_eq!(runs.lengths().collect::<Vec<_>>(), [2, 3, 1]);
        assert_eq!(Runs::<9>::new(&[]).lengths().count(), 0);
    }

    #[test]
    fn eight_equal_numbers_are_never_overlooked() {
        for (count, length) in (8..30).flat_map(|count| (7..=count).map(move |length| (count, length))) {
            for at in 0..=count - length {
                let mut values: Vec<f64> = (0..count).map(|i| i as f64).collect();
                values[at..at + length].fill(-1.0);
                let mut found = Vec::new();
                long_runs(&values, |from, to| found.push((from, to)));
                let expected = if length < LONG { vec![] } else { vec![(at, at + length)] };
                assert_eq!(found, expected, "{length} at {at} of {count}");
            }
        }
        // One behind the other.
        let mut found = Vec::new();
        long_runs(&[[1.0; 9], [2.0; 9], [1.0; 9]].concat(), |from, to| found.push((from, to)));
        assert_eq!(found, [(0, 9), (9, 18), (18, 27)]);
    }
}
