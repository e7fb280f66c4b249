//! The bootstrap interval of numbers on standard input, one row a line, columns parted by commas, and what it cost:
//! `cargo run --release -p pneuval-analysis --example bootstrap -- mean|rmse|ratio RESAMPLES SEED [LEVEL] < numbers.csv`.
//!
//! `mean` and `rmse` (the root of the mean square) are of the first column, `ratio` is mean of the first over mean of the second;
//! `mean-of-series` draws blocks of the length that the rule gives.

// A tool for those who check the bootstrap: a panic is its error message.
#![allow(clippy::unwrap_used)]

use std::time::Instant;

use pneuval_analysis::uncertainty::bootstrap::{Blocks, bca, block_length, blocks_of};

/// A figure of the process from the kernel's status file, in kB.
fn status_kb(key: &str) -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix(key)).unwrap_or_default();
    line.split_whitespace().find_map(|word| word.parse().ok()).unwrap_or(0)
}

/// Time that this thread has run, in ms, by the scheduler's count.
fn cpu_ms() -> f64 {
    let schedule = std::fs::read_to_string("/proc/thread-self/schedstat").unwrap_or_default();
    let nanoseconds = schedule.split(' ').next().and_then(|ns| ns.parse::<f64>().ok());
    nanoseconds.unwrap_or(f64::NAN) / 1e6
}

fn main() {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let [statistic, resamples, seed, rest @ ..] = args.as_slice() else {
        eprintln!("usage: bootstrap mean|rmse|ratio|mean-of-series RESAMPLES SEED [LEVEL] < numbers.csv");
        std::process::exit(2);
    };
    let text = std::io::read_to_string(std::io::stdin()).unwrap();
    let mut columns: Vec<Vec<f64>> = Vec::new();
    for line in text.lines().filter(|line| !line.trim().is_empty()) {
        for (i, cell) in line.split(',').enumerate() {
            if columns.len() <= i {
                columns.push(Vec::new());
            }
            columns[i].push(cell.trim().parse().unwrap());
        }
    }
    columns.truncate(if statistic == "ratio" { 2 } else { 1 });
    let rows = columns[0].len();
    if statistic == "rmse" {
        columns[0].iter_mut().for_each(|value| *value *= *value);
    }
    let of_means = |means: &[f64]| match statistic.as_str() {
        "rmse" => means[0].sqrt(),
        "ratio" => means[0] / means[1],
        _ => means[0],
    };
    let level = rest.first().map_or(0.95, |level| level.parse().unwrap());
    // What lies in memory before: the program and the data.
    let before_kb = status_kb("VmRSS:");
    let (wall, cpu) = (Instant::now(), cpu_ms());
    let blocks = if statistic == "mean-of-series" {
        blocks_of(&[&columns[0]], block_length(&columns[0]).unwrap()).unwrap()
    } else {
        Blocks::new(columns).unwrap()
    };
    let found = bca(&blocks, &of_means, resamples.parse().unwrap(), seed.parse().unwrap(), level).unwrap();
    let (wall, cpu) = (wall.elapsed().as_secs_f64() * 1e3, cpu_ms() - cpu);
    let peak_kb = status_kb("VmHWM:");
    println!(
        "{{\"rows\":{rows},\"draws\":{},\"value\":{},\"lower\":{},\"upper\":{},\"bias_correction\":{},\"acceleration\":{},\
         \"wall_ms\":{wall:.2},\"cpu_ms\":{cpu:.2},\"peak_kb\":{peak_kb},\"beyond_the_data_kb\":{}}}",
        blocks.draws(),
        found.value,
        found.lower,
        found.upper,
        found.bias_correction,
        found.acceleration,
        peak_kb.saturating_sub(before_kb)
    );
}
