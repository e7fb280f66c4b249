//! Results go to standard output through a writer whose errors are seen; diagnostics go to standard error.

use std::io::Write;

use serde::Serialize;

use crate::exit::Failure;

/// Prints text to standard output.
///
/// # Errors
/// [`Failure::Output`], also for a closed pipe.
pub fn print(text: &str) -> Result<(), Failure> {
    let mut out = std::io::stdout().lock();
    out.write_all(text.as_bytes())?;
    out.flush()?;
    Ok(())
}

/// Prints a value as JSON to standard output.
///
/// # Errors
/// As [`print()`].
pub fn print_json(value: &impl Serialize) -> Result<(), Failure> {
    let text = serde_json::to_string_pretty(value).map_err(std::io::Error::from)?;
    print(&(text + "\n"))
}
