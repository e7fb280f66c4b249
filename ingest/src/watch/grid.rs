//! The grid on which the numbers of a column stand: the step of an analogue-to-digital converter, or of print.

use super::sketch::Sketch;

/// Numbers that are remembered, all of them different.
const LEVELS_MAX: usize = 64;

/// Numbers kept where there are too many: those closest together.
const LEVELS_KEPT: usize = 32;

/// Numbers looked at first without a choice, and later each time.
const PROBED_FIRST: usize = 8192;
const PROBED_LATER: usize = 16;

/// So much of a step a number may be off its grid: print rounds what a converter gave.
const OFF_MAX: f64 = 0.2;

/// ... where there are so few numbers that any would be near some grid.
const FEW: usize = 16;
const FEW_OFF_MAX: f64 = 0.05;

/// No two numbers on a grid are closer together than this share of a step.
const CLOSE_MAX: f64 = 0.5;

/// Of the numbers of a signal at most one in so many is far from the one before.
const FAR_SHARE: u64 = 4;

/// Remembers a few numbers that are close together, closer and closer as more of them come. Those of a grid end up as neighbours.
#[derive(Debug, Clone)]
pub(super) struct Grid {
    /// In order.
    levels: Vec<f64>,
    window: (f64, f64),
    /// The least that two neighbouring numbers of the column differ: a smooth signal looks like a grid where it is steep, but not where
    /// it turns.
    least: f64,
    apart: Sketch,
    probed: usize,
}

impl Default for Grid {
    fn default() -> Self {
        Self {
            levels: Vec::new(),
            window: (f64::NEG_INFINITY, f64::INFINITY),
            least: f64::INFINITY,
            apart: Sketch::coarse(),
            probed: 0,
        }
    }
}

impl Grid {
    /// The next numbers of a block.
    pub fn probe(&mut self, values: &[f64]) {
        let most = PROBED_FIRST.saturating_sub(self.probed).max(PROBED_LATER);
        let values = &values[..values.len().min(most)];
        self.probed += values.len();
        for pair in values.windows(2) {
            let apart = (pair[1] - pair[0]).abs();
            self.apart.add(apart);
            if apart < self.least && apart > rounding(pair[1]) {
                self.least = apart;
            }
        }
        for value in values {
            if *value >= self.window.0 && *value <= self.window.1 {
                self.put(*value);
            }
        }
    }

    fn put(&mut self, value: f64) {
        let at = self.levels.partition_point(|level| *level < value);
        let same = |level: &f64| (level - value).abs() <= rounding(value);
        let near = [at.checked_sub(1), Some(at)];
        if near.into_iter().flatten().any(|i| self.levels.get(i).is_some_and(same)) {
            return;
        }
        self.levels.insert(at, value);
        if self.levels.len() > LEVELS_MAX {
            self.narrow();
        }
    }

    #[cold]
    fn narrow(&mut self) {
        let width = |first: usize| self.levels[first + LEVELS_KEPT - 1] - self.levels[first];
        let first = (0..=self.levels.len() - LEVELS_KEPT).min_by(|a, b| width(*a).total_cmp(&width(*b))).unwrap_or(0);
        self.levels.drain(..first);
        self.levels.truncate(LEVELS_KEPT);
        if let (Some(first), Some(last)) = (self.levels.first(), self.levels.last()) {
            self.window = (*first, *last);
        }
    }

    /// Whether most neighbouring numbers of the column are as near to each other as those of a signal are.
    pub fn follows(&self, near: f64) -> bool {
        FAR_SHARE * self.apart.sorted().above(near) <= self.apart.count()
    }

    /// The step of the grid, if the numbers stand on one.
    pub fn step(&self) -> Option<f64> {
        let levels = &self.levels;
        if levels.len() < 3 {
            return None;
        }
        let apart = || levels.windows(2).map(|pair| pair[1] - pair[0]);
        let least = apart().fold(f64::INFINITY, f64::min);
        // Print makes some steps longer and some shorter: their mean is nearer to the truth than the shortest.
        let (sum, count) = apart().filter(|d| *d <= 1.5 * least).fold((0.0, 0.0), |(sum, n), d| (sum + d, n + 1.0));
        let few = levels.len() < FEW;
        let divisors: &[f64] = if few { &[1.0] } else { &[1.0, 2.0, 3.0] };
        let step = divisors.iter().find_map(|divisor| fit(levels, sum / count / divisor, few))?;
        (self.least >= CLOSE_MAX * step).then_some(step)
    }
}

/// Numbers that differ by so little are the same but for rounding errors.
fn rounding(value: f64) -> f64 {
    4.0 * f64::EPSILON * value.abs()
}

/// The step of a grid through all levels, near a first guess.
fn fit(levels: &[f64], guess: f64, few: bool) -> Option<f64> {
    let origin = *levels.first()?;
    // From each level to the next, with what is known so far: an error of the guess does not add up.
    let mut step = guess;
    let mut at = 0.0;
    let mut places = Vec::with_capacity(levels.len());
    for level in levels {
        at = ((level - origin) / step).round();
        places.push(at);
        if at >= 1.0 {
            step = (level - origin) / at;
        }
    }
    // A grid that is mostly empty is no grid where there are few levels.
    if few && 2.0 * (levels.len() as f64) < at + 1.0 {
        return None;
    }
    let count = levels.len() as f64;
    let mean = (places.iter().sum::<f64>() / count, levels.iter().map(|l| l - origin).sum::<f64>() / count);
    let (mut up, mut across) = (0.0, 0.0);
    for (place, level) in places.iter().zip(levels) {
        up += (place - mean.0) * (level - origin - mean.1);
        across += (place - mean.0) * (place - mean.0);
    }
    let step = up / across;
    let off_max = step * if few { FEW_OFF_MAX } else { OFF_MAX };
    let off = |(place, level): (&f64, &f64)| (level - origin - mean.1 - step * (place - mean.0)).abs();
    (step.is_finite() && step > 0.0 && places.iter().zip(levels).map(off).all(|off| off <= off_max)).then_some(step)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn random(state: &mut u64) -> f64 {
        *state ^= *state << 13;
        *state ^= *state >> 7;
        *state ^= *state << 17;
        (*state >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn step_of(values: impl IntoIterator<Item = f64>) -> Option<f64> {
        let mut grid = Grid::default();
        for block in values.into_iter().collect::<Vec<f64>>().chunks(1024) {
            grid.probe(block);
        }
        grid.step()
    }

    fn assert_near(step: Option<f64>, expected: f64) {
        assert!(step.is_some_and(|s| (s / expected - 1.0).abs() < 2e-3), "{step:?} for {expected}");
    }

    #[test]
    fn converters_of_any_width_are_found() {
        let mut state = 7;
        for bits in [4, 8, 10, 12, 14] {
            let codes = f64::from(1 << bits);
            let step = 500.0 / codes;
            assert_near(step_of((0..20_000).map(|_| (random(&mut state) * codes).floor() * step - 20.0)), step);
        }
    }

    #[test]
    fn print_does_not_hide_the_converter_behind_it() {
        let mut state = 7;
        let step = 500.0 / 4095.0;
        let printed = |digits: f64, value: f64| (value * digits).round() / digits;
        assert_near(step_of((0..5000).map(|_| printed(100.0, (random(&mut state) * 4095.0).floor() * step))), step);
        // Nor does it look like one where there is none: the step is that of print.
        assert_near(step_of((0..5000).map(|_| printed(100.0, random(&mut state) * 40.0))), 0.01);
    }

    #[test]
    fn numbers_on_no_grid_have_no_step() {
        let mut state = 7;
        assert_eq!(step_of((0..20_000).map(|_| random(&mut state))), None);
        assert_eq!(step_of((0..10_000).map(|i| (f64::from(i) * 1e-3).sin())), None);
        assert_eq!(step_of([0.0, 10.0, 27.0, 60.0]), None);
        assert_eq!(step_of([1.0, 2.0, 1.0]), None);
        assert_eq!(step_of([]), None);
    }

    #[test]
    fn few_levels_next_to_each_other_are_a_grid() {
        assert_near(step_of([5.1, 5.2, 5.3, 5.1, 5.2, 5.5]), 0.1);
    }
}
