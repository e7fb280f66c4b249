//! How long figures take: `redraw REPORT`. Draws the figures of stored results several times, without files and with them, and prints the
//! median CPU-bound wall time of all of them and of one.

// An example may end with a panic.
#![allow(clippy::unwrap_used)]

use std::path::Path;
use std::time::Instant;

use pneuval_analysis::folder;
use pneuval_analysis::report::{Files, figures};

const ROUNDS: usize = 11;

fn main() {
    for report in std::env::args().skip(1) {
        let (_, evaluation) = folder::load(Path::new(&report)).unwrap();
        for files in [Files::None, Files::Every] {
            let mut rounds: Vec<(f64, usize)> = (0..ROUNDS)
                .map(|_| {
                    let begun = Instant::now();
                    let drawn =
                        figures(&evaluation.results, &evaluation.curves, &evaluation.logs, files, &|_, _| {}).unwrap();
                    (1e3 * begun.elapsed().as_secs_f64(), drawn.len())
                })
                .collect();
            rounds.sort_by(|a, b| a.0.total_cmp(&b.0));
            let (all, n) = rounds[ROUNDS / 2];
            let what = if files == Files::None { "SVG" } else { "SVG and PNG" };
            println!("{report}: {n} figures, {what}: {all:.1} ms, {:.2} ms each", all / n as f64);
        }
    }
}
