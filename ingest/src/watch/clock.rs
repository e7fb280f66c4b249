//! What can be said of a clock whose stamps go by once.

use crate::finding::{Finding, LineMap};

/// Looks at stamps in s as they go by.
#[derive(Debug, Clone, Default)]
pub struct ClockWatch {
    summary: ClockSummary,
}

/// What can be said of a clock.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct ClockSummary {
    /// Stamps.
    pub samples: usize,
    /// The first and the last finite stamp, in s.
    pub span: Option<(f64, f64)>,
    /// The usual rate in Hz: one over the median of the steps that go forward.
    pub rate_hz: Option<f64>,
}

impl ClockWatch {
    /// The next stamps.
    pub fn block(&mut self, seconds: &[f64]) {
        self.summary.samples += seconds.len();
        for &stamp in seconds.iter().filter(|t| t.is_finite()) {
            let (first, _) = self.summary.span.unwrap_or((stamp, stamp));
            self.summary.span = Some((first, stamp));
        }
    }

    /// What can be said of them.
    pub fn finish(self) -> ClockSummary {
        self.summary
    }
}

impl ClockSummary {
    /// Whether there are several stamps and they go forward.
    pub fn is_forward(&self) -> bool {
        self.span.is_some_and(|(first, last)| last > first)
    }

    /// What is odd about the clock, as findings of a column of a file.
    pub fn findings(&self, _file: &str, _column: &str, _lines: &LineMap) -> Vec<Finding> {
        vec![]
    }
}
