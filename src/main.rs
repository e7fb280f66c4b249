//! `pneuval`: raw soft-actuator rig logs and published tables in, model-vs-experiment verdicts out.

mod accept;
mod audit;
mod cli;
mod exit;
mod export;
mod fit;
mod gate;
mod ingest;
mod init;
mod inspect;
mod manual;
mod materials;
mod measure;
mod models;
mod output;
mod paint;
mod predict;
mod progress;
mod rehearse;
mod report;
mod selftest;
mod table;
mod told;
mod validate;

use std::process::ExitCode;

use clap::Parser;

use cli::{Cli, Command};

fn main() -> ExitCode {
    let outcome = match Cli::parse().command {
        Command::Validate(arguments) => validate::run(&arguments),
        Command::Init(arguments) => init::run(&arguments),
        Command::Inspect(arguments) => inspect::run(&arguments),
        Command::Ingest(arguments) => ingest::run(&arguments),
        Command::Measure(arguments) => measure::run(&arguments),
        Command::Export(arguments) => export::run(&arguments),
        Command::Gate(arguments) => gate::run(&arguments),
        Command::Accept(arguments) => accept::run(&arguments),
        Command::Report(arguments) => report::run(&arguments),
        Command::Predict(arguments) => predict::run(&arguments),
        Command::Audit(arguments) => audit::run(&arguments),
        Command::Fit(arguments) => fit::run(&arguments),
        Command::Rehearse(arguments) => rehearse::run(&arguments),
        Command::Selftest(arguments) => selftest::run(&arguments),
        Command::Models(arguments) => models::run(&arguments),
        Command::Materials(arguments) => materials::run(&arguments),
        Command::Completions(arguments) => manual::completions(&arguments),
        Command::Man(arguments) => manual::man(&arguments),
    };
    exit::finish(outcome)
}
