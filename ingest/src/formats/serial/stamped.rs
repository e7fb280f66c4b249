//! Delimited lines that a terminal stamped: `12:33:01.123 -> 1,2,3`.
//!
//! What stands behind the stamps is delimited text and read as such, by [`csv`]; the stamps are gathered in a pass of their own.

use std::io::Read;

use super::prefix::strip;
use super::{LOOKED_AT, Terminal};
use crate::IngestError;
use crate::formats::csv::{self, CsvOptions};
use crate::formats::lines::Lines;
use crate::formats::sheet::Sheet;
use crate::raw::RawFile;
use crate::recording::{ColumnRef, Keep, Recording};

/// Whether most lines begin with a terminal's stamp and hold numbers behind it.
pub(super) fn is_stamped(lines: &[&[u8]]) -> bool {
    let lines = lines.get(..LOOKED_AT).unwrap_or(lines);
    let stamped = lines.iter().filter(|line| {
        let stripped = strip(line);
        let is_number = |b: &u8| b.is_ascii_digit() || matches!(b, b'+' | b'-' | b'.');
        stripped.stamp.is_some() && stripped.rest.first().is_some_and(is_number)
    });
    let count = stamped.count();
    count > 1 && count * 2 > lines.len()
}

/// A text line by line, without what the terminal wrote before each. It has the lines of the file, so their numbers are the same.
struct Bare<'a> {
    lines: Lines<'a>,
    line: Vec<u8>,
    /// How much of the line was given.
    given: usize,
}

fn bare<'r>(raw: &'r RawFile<'r>) -> Result<Box<dyn Read + 'r>, IngestError> {
    Ok(Box::new(Bare { lines: Lines::of(raw)?, line: Vec::new(), given: 0 }))
}

impl Read for Bare<'_> {
    fn read(&mut self, mut out: &mut [u8]) -> std::io::Result<usize> {
        let room = out.len();
        while !out.is_empty() {
            let count = self.line.get(self.given..).unwrap_or_default().read(out)?;
            self.given += count;
            out = out.get_mut(count..).unwrap_or_default();
            if count == 0 {
                let Some(line) = self.lines.next().map_err(std::io::Error::other)? else { break };
                self.line.clear();
                self.line.extend_from_slice(strip(line.bytes).rest);
                self.line.extend(line.is_ended.then_some(b'\n'));
                self.given = 0;
            }
        }
        Ok(room - out.len())
    }
}

/// What a column of the log is called that has the name of the column of stamps.
const SECOND: &str = "terminal_time (2)";

/// The columns that are kept, as they are named and counted without the column of stamps before them.
fn without_stamps(asked: &ColumnRef) -> ColumnRef {
    match asked {
        ColumnRef::Number(number) => ColumnRef::Number(number.saturating_sub(1)),
        ColumnRef::Name(name) if name == SECOND => ColumnRef::Name(Terminal::NAME.to_owned()),
        ColumnRef::Name(name) => ColumnRef::Name(name.clone()),
    }
}

/// Reads such a log: the columns of its delimited text behind one of the stamps.
pub(super) fn read(raw: &RawFile, keep: Keep) -> Result<Recording, IngestError> {
    let file = raw.name();
    let asked: Vec<ColumnRef>;
    let bare_keep = match keep {
        Keep::Only(columns) => {
            asked = columns.iter().map(without_stamps).collect();
            Keep::Only(&asked)
        }
        other => other,
    };
    let mut recording = csv::read_raw(&RawFile::through(raw, bare), &CsvOptions::default(), bare_keep)?;
    let Some(table) = recording.tables.first_mut() else { return Ok(recording) };

    let mut sheet = Sheet::new(file, "", keep);
    let mut terminal = Terminal::add(&mut sheet)?;
    let mut lines = Lines::of(raw)?;
    while let Some(line) = lines.next()? {
        if line.number == table.lines.line_of(sheet.rows()) {
            terminal.put(&mut sheet, strip(line.bytes).stamp, line.number);
            sheet.end_row(line.number, false)?;
        }
    }
    if sheet.rows() != table.rows {
        return Err(raw.failed(std::io::Error::other("it was changed while it was read")));
    }
    recording.findings.extend(lines.end_findings(sheet.lines()));
    recording.findings.extend(terminal.findings(file, &sheet));
    let (stamps, findings) = sheet.finish();
    recording.findings.extend(findings);
    for column in table.columns.iter_mut().filter(|column| column.name == Terminal::NAME) {
        SECOND.clone_into(&mut column.name);
    }
    table.columns.splice(0..0, stamps.columns);
    recording.format = "serial log";
    recording.origin = terminal.origin();
    recording.reasons.push("most lines begin with a terminal's stamp: column `terminal_time`".to_owned());
    Ok(recording)
}
