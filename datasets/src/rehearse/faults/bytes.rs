//! Faults of files: what a cable, a disk or a terminal program does to bytes.

use std::ops::Range;

use pneuval_ingest::formats::Format;

use super::Fault;

/// What a fault of bytes needs to know of a file.
pub struct Layout<'a> {
    /// Its format.
    pub format: Format,
    /// Samples of its table.
    pub rows: usize,
    /// Column of the channel that is hit, and its name, where the table has it.
    pub column: Option<(usize, &'a str)>,
}

/// Readings that are hit by text, and lines that are hit by commas.
const CELLS: usize = 10;
const LINES: usize = 20;

/// Hits a file. Gives the first and last sample that are hit, from 1; `None` for faults of another stage.
pub fn spoil_bytes(fault: Fault, layout: &Layout, bytes: &mut Vec<u8>) -> Option<(usize, usize)> {
    let Layout { format, rows, column } = layout;
    let middle = rows / 2;
    match fault {
        Fault::TextInNumbers => {
            for row in (middle..middle + CELLS).rev() {
                let cell = cell(bytes, *format, *rows, row, (*column)?)?;
                bytes.splice(cell, *b"ERR");
            }
            Some((middle + 1, middle + CELLS))
        }
        Fault::DecimalComma => {
            for row in middle..middle + LINES {
                let line = line(bytes, *rows, row)?;
                bytes[line].iter_mut().filter(|byte| **byte == b'.').for_each(|byte| *byte = b',');
            }
            Some((middle + 1, middle + LINES))
        }
        Fault::Truncated => {
            // Within a line, and within a number of it; above the samples stand so many lines.
            let head = bytes.iter().filter(|byte| **byte == b'\n').count().saturating_sub(*rows);
            let mut end = bytes.len() * 7 / 10;
            let is_inside = |at: usize| bytes[at - 1].is_ascii_digit() && bytes[at].is_ascii_digit();
            while *format != Format::Mcap && *format != Format::Tdms && !is_inside(end) {
                end += 1;
            }
            bytes.truncate(end);
            let left = bytes.iter().filter(|byte| **byte == b'\n').count();
            // In a bag or a stream of several tables it is about there.
            let is_text = !matches!(format, Format::Mcap | Format::Tdms);
            let row = if is_text { left - head } else { rows * 7 / 10 };
            Some((row + 1, *rows))
        }
        Fault::FlippedBit if *format == Format::Mcap => {
            let at = bytes.len() / 2;
            bytes[at] ^= 0x10;
            Some((1, *rows))
        }
        Fault::FlippedBit => {
            // A bit that makes a letter of a digit: one that makes another digit of it is seen by nobody.
            let cell = cell(bytes, *format, *rows, middle, (*column)?)?;
            let at = cell.start + bytes[cell].iter().position(u8::is_ascii_digit)?;
            bytes[at] ^= 0x40;
            Some((middle + 1, middle + 1))
        }
        Fault::GluedHeader => {
            // The row of units goes too: it would be the one that is glued.
            let note = bytes.iter().position(|byte| *byte == b'\n')? + 1;
            let end = note + bytes[note..].iter().position(|byte| *byte == b'\n')?;
            let units = end + 1 + bytes[end + 1..].iter().position(|byte| *byte == b'\n')?;
            bytes.drain(end..=units);
            Some((1, 1))
        }
        Fault::Trailer => {
            bytes.extend_from_slice(b"Saved by the logger, end of test\n");
            Some((*rows, *rows))
        }
        _ => None,
    }
}

/// Where the line of a sample stands: samples are the last lines of a file.
fn line(bytes: &[u8], rows: usize, row: usize) -> Option<Range<usize>> {
    let ends: Vec<usize> = bytes.iter().enumerate().filter(|(_, byte)| **byte == b'\n').map(|(at, _)| at).collect();
    let number = ends.len().checked_sub(rows)? + row;
    let start = number.checked_sub(1).and_then(|before| ends.get(before)).map_or(0, |end| end + 1);
    Some(start..*ends.get(number)?)
}

/// The number of the line of a sample, from 1.
pub fn line_number(bytes: &[u8], rows: usize, row: usize) -> Option<usize> {
    let ends = bytes.iter().filter(|byte| **byte == b'\n').count();
    Some(ends.checked_sub(rows)? + row + 1)
}

/// Where the number of a column stands in the line of a sample.
fn cell(bytes: &[u8], format: Format, rows: usize, row: usize, (column, name): (usize, &str)) -> Option<Range<usize>> {
    let line = line(bytes, rows, row)?;
    let text = &bytes[line.clone()];
    let start = if format == Format::Serial {
        let key = format!("{name}=");
        text.windows(key.len()).position(|window| window == key.as_bytes())? + key.len()
    } else {
        let delimiter = if matches!(format, Format::Lvm | Format::Gauge) { b'\t' } else { b',' };
        match column {
            0 => 0,
            _ => text.iter().enumerate().filter(|(_, b)| **b == delimiter).nth(column - 1)?.0 + 1,
        }
    };
    let end = start + text[start..].iter().take_while(|byte| is_of_number(**byte)).count();
    Some(line.start + start..line.start + end)
}

fn is_of_number(byte: u8) -> bool {
    byte.is_ascii_digit() || matches!(byte, b'.' | b'-' | b'+' | b'e')
}
