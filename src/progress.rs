//! Progress on a terminal: what is done, how fast, and how long it will take.
//!
//! It is told on standard error, only where that is a terminal, and it leaves nothing behind. Work that is done before a reader would look
//! up shows nothing.

use std::io::{IsTerminal as _, stderr};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressState, ProgressStyle};

/// Nothing is shown of work that takes less.
const PATIENCE: Duration = Duration::from_millis(700);

/// A bar over so many steps.
pub struct Progress {
    bar: ProgressBar,
    begun: Instant,
    is_settled: AtomicBool,
}

impl Progress {
    /// Of work that is `doing` something, such as `reading`, to so many of a kind.
    pub fn of(doing: &'static str, kind: &'static str, all: usize) -> Self {
        let bar = ProgressBar::with_draw_target(Some(all as u64), ProgressDrawTarget::hidden());
        let template = format!("{doing} {{pos}} of {{len}} {kind}, {{rate}} a second, {{eta}} left {{wide_bar:.dim}}");
        // The template has no key that is not known; the plain bar would stand in for it.
        let style = ProgressStyle::with_template(&template).unwrap_or_else(|_| ProgressStyle::default_bar());
        let rate = |state: &ProgressState, out: &mut dyn std::fmt::Write| {
            // What cannot be written is not shown.
            let _ = write!(out, "{:.1}", state.per_sec());
        };
        bar.set_style(style.with_key("rate", rate));
        Self { bar, begun: Instant::now(), is_settled: AtomicBool::new(!stderr().is_terminal()) }
    }

    /// One more is done.
    pub fn step(&self) {
        self.bar.inc(1);
        self.show();
    }

    /// So many of so many are done.
    pub fn at(&self, done: usize, all: usize) {
        self.bar.set_length(all as u64);
        self.bar.set_position(done as u64);
        self.show();
    }

    fn show(&self) {
        if self.begun.elapsed() > PATIENCE && !self.is_settled.swap(true, Ordering::Relaxed) {
            self.bar.set_draw_target(ProgressDrawTarget::stderr());
        }
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}
