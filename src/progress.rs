//! Progress on a terminal: what is done, how fast, and how long it will take.
//!
//! It is told on standard error, only where that is a terminal, and it leaves nothing behind. Work that is done before a reader would look
//! up shows nothing.

use std::io::{IsTerminal as _, stderr};
use std::time::Duration;

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

/// Nothing is shown of work that takes less.
const PATIENCE: Duration = Duration::from_millis(700);

/// A bar over so many steps.
pub struct Progress {
    bar: ProgressBar,
    begun: std::time::Instant,
    is_shown: bool,
}

impl Progress {
    /// Of work that is `doing` something, such as `reading`, to so many of a kind.
    pub fn of(doing: &'static str, kind: &'static str, all: usize) -> Self {
        let bar = ProgressBar::with_draw_target(Some(all as u64), ProgressDrawTarget::hidden());
        let template = format!("{doing} {{pos}} of {{len}} {kind}, {{per_sec}}, {{eta}} left {{wide_bar:.dim}}");
        // The template above has no key that indicatif does not know; its plain bar stands in for it if that changes.
        bar.set_style(ProgressStyle::with_template(&template).unwrap_or_else(|_| ProgressStyle::default_bar()));
        Self { bar, begun: std::time::Instant::now(), is_shown: !stderr().is_terminal() }
    }

    /// One more is done.
    pub fn step(&mut self) {
        self.bar.inc(1);
        if !self.is_shown && self.begun.elapsed() > PATIENCE {
            self.is_shown = true;
            self.bar.set_draw_target(ProgressDrawTarget::stderr());
        }
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}
