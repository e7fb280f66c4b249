//! `pneuval completions` and `pneuval man`: what shells and `man` know of the commands, from the definitions of the help.

use std::path::Path;

use clap::CommandFactory as _;
use clap_complete::generate;
use pneuval_ingest::IngestError;

use crate::cli::{Cli, Completions, Man};
use crate::exit::{Failure, Outcome};
use crate::output;

/// Prints the completions of a shell.
pub fn completions(arguments: &Completions) -> Result<Outcome, Failure> {
    let mut script = Vec::new();
    generate(arguments.shell, &mut Cli::command(), "pneuval", &mut script);
    output::print_script(&script)?;
    Ok(Outcome::Expected)
}

/// Writes a page for the program and one for each command.
pub fn man(arguments: &Man) -> Result<Outcome, Failure> {
    let folder: &Path = &arguments.out;
    std::fs::create_dir_all(folder).map_err(|source| IngestError::write(folder, source))?;
    clap_mangen::generate_to(Cli::command(), folder).map_err(|source| IngestError::write(folder, source))?;
    output::print(&format!("Man pages: {}\nNext: man {}\n", folder.display(), folder.join("pneuval.1").display()))?;
    Ok(Outcome::Expected)
}
