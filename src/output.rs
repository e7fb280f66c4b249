//! Results go to standard output through a writer whose errors are seen; diagnostics go to standard error.

use std::fmt::Write as _;
use std::io::{self, Write as _};

use serde::Serialize;

use pneuval_analysis::format::visible;
use pneuval_analysis::results::Results;

use crate::paint;

/// Prints text to standard output.
///
/// # Errors
/// If standard output cannot be written; a closed pipe is no error.
pub fn print(text: &str) -> io::Result<()> {
    write(&visible(text))
}

/// Prints JSON to standard output: control characters that JSON leaves as they are become escapes that JSON knows.
///
/// # Errors
/// As [`print()`].
pub fn print_json_text(text: &str) -> io::Result<()> {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        if c.is_control() && c != '\n' {
            // Writing to a String cannot fail.
            let _ = write!(out, "\\u{:04x}", u32::from(c));
        } else {
            out.push(c);
        }
    }
    write(&out)
}

/// Prints a script for a shell as it is.
///
/// # Errors
/// As [`print()`].
pub fn print_script(script: &[u8]) -> io::Result<()> {
    write(&String::from_utf8_lossy(script))
}

/// Prints painted text, whose parts from files and users are visible already; colour only where it is wanted.
///
/// # Errors
/// As [`print()`].
pub fn print_painted(text: &str) -> io::Result<()> {
    write_to(&mut anstream::stdout().lock(), text)
}

fn write(text: &str) -> io::Result<()> {
    write_to(&mut io::stdout().lock(), text)
}

fn write_to(out: &mut impl io::Write, text: &str) -> io::Result<()> {
    match out.write_all(text.as_bytes()).and_then(|()| out.flush()) {
        // A reader that has seen enough (`| head`) is no error, and does not change what the exit code says.
        Err(error) if error.kind() == std::io::ErrorKind::BrokenPipe => Ok(()),
        written => written,
    }
}

/// Prints a value as JSON to standard output.
///
/// # Errors
/// As [`print()`].
pub fn print_json(value: &impl Serialize) -> io::Result<()> {
    let text = serde_json::to_string_pretty(value).map_err(io::Error::from)?;
    print_json_text(&(text + "\n"))
}

/// Tells something on standard error; if nobody can read that either, the exit code still says it.
pub fn tell(message: &str) {
    let _ = writeln!(anstream::stderr(), "{}", paint::told(&no_command(&visible(message))));
}

/// A name that holds a line break must not begin what a CI server takes for a command (`::error::`, `##[error]`, `##vso[`).
fn no_command(message: &str) -> String {
    let mut lines = message.split('\n');
    let mut out = lines.next().unwrap_or_default().to_owned();
    for line in lines {
        let begins = line.trim_start();
        out += if begins.starts_with("::") || begins.starts_with("##") { "\\u{a}" } else { "\n" };
        out += line;
    }
    out
}

/// Tells every finding, and what the losses mean.
pub fn tell_findings(results: &Results) {
    for finding in &results.findings {
        let file = finding.file.as_ref().map_or(String::new(), |file| format!("{file}: "));
        let place = finding.dataset.as_ref().map_or(String::new(), |id| format!("{id}, {file}"));
        tell(&format!("{}: {place}{}", finding.severity.name(), finding.text));
    }
}
