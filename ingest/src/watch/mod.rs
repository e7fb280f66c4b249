//! What can be said of a column without keeping it: numbers go by once, in blocks, in bounded memory.

mod clock;
mod sketch;
mod wrap;

pub use clock::{ClockSummary, ClockWatch, Places, Step, StepSummary};
pub(crate) use clock::{Steps, Teller, samples, stamp};
pub use wrap::Wrap;

use crate::finding::{Finding, LineMap};

/// Looks at the numbers of a column as they go by.
#[derive(Debug, Clone, Default)]
pub struct Watch {
    samples: usize,
    holes: usize,
    range: Option<(f64, f64)>,
}

/// What can be said of the numbers of a column.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Summary {
    /// Cells.
    pub samples: usize,
    /// Cells without a finite number.
    pub holes: usize,
    /// The smallest and the largest number, if there is one.
    pub range: Option<(f64, f64)>,
}

impl Watch {
    /// The next numbers; what is not finite is a hole.
    pub fn block(&mut self, values: &[f64]) {
        self.samples += values.len();
        for &value in values {
            if value.is_finite() {
                let (min, max) = self.range.unwrap_or((value, value));
                self.range = Some((min.min(value), max.max(value)));
            } else {
                self.holes += 1;
            }
        }
    }

    /// Numbers so far.
    pub fn samples(&self) -> usize {
        self.samples
    }

    /// What can be said of them.
    pub fn finish(self) -> Summary {
        let Self { samples, holes, range } = self;
        Summary { samples, holes, range }
    }
}

impl Summary {
    /// What is odd about the numbers, as findings of a column of a file.
    pub fn findings(&self, _file: &str, _column: &str, _lines: &LineMap) -> Vec<Finding> {
        vec![]
    }
}
