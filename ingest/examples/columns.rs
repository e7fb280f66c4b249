//! Reads a raw file of any format into columns and prints what it cost, as one line of JSON:
//! `cargo run --release -p pneuval-ingest --example columns -- FILE [all|nothing|COLUMN..]`.

// A tool for those who work on the readers: a panic is its error message.
#![allow(clippy::unwrap_used, clippy::panic)]

use std::time::Instant;

use pneuval_ingest::formats::{self, Options};
use pneuval_ingest::raw::RawFile;
use pneuval_ingest::recording::{ColumnRef, Keep};

/// Time that the process has spent on processors, in s: user and system, by the clock of the kernel.
fn cpu_s() -> f64 {
    let stat = std::fs::read_to_string("/proc/self/stat").unwrap_or_default();
    let fields: Vec<&str> = stat.rsplit(") ").next().unwrap_or_default().split(' ').collect();
    let ticks = |index: usize| fields.get(index).and_then(|ticks| ticks.parse::<f64>().ok()).unwrap_or(f64::NAN);
    (ticks(11) + ticks(12)) / 100.0
}

/// The sum of all finite numbers, formed side by side as other readers' arrays do it.
fn sum(numbers: &[f64]) -> f64 {
    let (eights, rest) = numbers.as_chunks::<8>();
    let mut sums = [0.0; 8];
    for eight in eights {
        for (sum, number) in sums.iter_mut().zip(eight) {
            *sum += if number.is_finite() { *number } else { 0.0 };
        }
    }
    sums.iter().sum::<f64>() + rest.iter().filter(|number| number.is_finite()).sum::<f64>()
}

fn main() {
    let mut args = std::env::args().skip(1);
    let path = args.next().expect("usage: columns FILE [all|nothing|COLUMN..]");
    let asked: Vec<String> = args.collect();
    let columns: Vec<ColumnRef> = asked.iter().cloned().map(ColumnRef::Name).collect();
    let keep = match asked.first().map(String::as_str) {
        None | Some("all") => Keep::All,
        Some("nothing") => Keep::Nothing,
        Some(_) => Keep::Only(&columns),
    };
    let (wall, cpu) = (Instant::now(), cpu_s());
    let raw = RawFile::open(path.as_ref(), &path, u64::MAX).unwrap();
    let recording = formats::read(&raw, &Options::default(), keep).unwrap();
    let rows: usize = recording.tables.iter().map(|table| table.rows).sum();
    // Stamps are large and would hide everything else.
    let values = recording.tables.iter().flat_map(|table| &table.columns).filter(|c| c.unit.as_deref() != Some("s"));
    let sum: f64 = values.filter_map(|c| c.cells.numbers()).map(sum).sum();
    let (wall, cpu) = (wall.elapsed().as_secs_f64(), cpu_s() - cpu);
    println!(
        "{{\"name\":\"columns\",\"wall\":{wall:.6},\"cpu\":{cpu:.3},\"items\":{rows},\"check\":{sum},\"findings\":{}}}",
        recording.findings.len()
    );
    for finding in &recording.findings {
        eprintln!("{} {}: {}", finding.severity.id(), finding.kind.id(), finding.text);
    }
}
