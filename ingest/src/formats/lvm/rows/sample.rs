//! A row that is not plain, cell by cell.

use super::super::block::Row;
use super::super::header::{cells, is_begun, plain, without_end};
use super::{Line, Reader};
use crate::finding::places::{as_text, cut_line, no_line_end, quoted};
use crate::finding::{FindingKind, Severity};
use crate::formats::csv::text::check_utf8;
use crate::formats::csv::{CellKind, cell_kind};
use crate::limits::LOG_COLUMNS_MAX;

impl Reader<'_> {
    /// Takes a row, holes where there is no number.
    pub(super) fn sample(&mut self, line: Line) {
        let (bytes, separator) = (line.bytes, self.separator);
        check_utf8(bytes, line.number, &mut self.bad);
        let row = self.rows();
        let Some(block) = self.blocks.get_mut(self.current) else { return };
        let usual = block.layout.cells;
        let mut all: Vec<&[u8]> = cells(bytes, separator).collect();
        if all.len() > LOG_COLUMNS_MAX.max(2 * usual) {
            all.truncate(LOG_COLUMNS_MAX.max(2 * usual));
        }
        let comment = comment(bytes, separator, usual);
        let extra = all.get(usual..).unwrap_or_default();
        let filled_extra = extra.iter().filter(|cell| !cell.is_empty()).count();
        let extras = extra.len();
        let first_extra = extra.first().copied().unwrap_or_default();
        let is_number = matches!(cell_kind(first_extra, self.decimal), CellKind::Number(_));
        // Which of too many cells is the one too many, nobody knows.
        let is_shifted = is_number && (!block.layout.is_comment_named || filled_extra > 1);
        let mut held = all.len().min(usual);
        // Of what is there only the last cell may have been cut.
        let cut = (!line.is_ended && extras == 0).then_some(held.saturating_sub(1));
        all.truncate(usual);
        self.values.clear();
        self.kinds.clear();
        for cell in &all {
            let kind = cell_kind(cell, self.decimal);
            self.values.push(if let CellKind::Number(number) = kind { number } else { f64::NAN });
            self.kinds.push(kind);
        }
        let is_sample = self.kinds.iter().any(|kind| matches!(kind, CellKind::Number(_)))
            || held >= usual
            || (comment.is_empty() && self.kinds.iter().all(|kind| matches!(kind, CellKind::Empty | CellKind::Hole)));
        if !is_sample && !line.is_ended && is_begun(bytes) {
            let text =
                format!("the file ends within line {}, the first of a header; what followed is lost", line.number);
            self.tally.tell(self.raw.name(), FindingKind::Truncated, Severity::Lost, &[(row, line.number)], text);
            return;
        }
        if !is_sample {
            self.tally.line(FindingKind::SkippedLine, row, line.number, || quoted(bytes));
            return;
        }
        if !line.is_ended {
            let file = self.raw.name();
            if held < usual {
                // Unless a separator closes it, the last cell may be cut too: `12.5` of `12.53`.
                let is_cut = bytes.last() != Some(&separator);
                let text = cut_line(line.number, held - usize::from(!is_cut), usual, is_cut);
                held -= 1;
                self.kinds.truncate(held);
                self.values.truncate(held);
                self.tally.tell(file, FindingKind::Truncated, Severity::Lost, &[(row, line.number)], text);
                if self.kinds.iter().all(|kind| *kind == CellKind::Empty) {
                    return;
                }
            } else {
                let text = no_line_end(line.number);
                self.tally.tell(file, FindingKind::NoLineEnd, Severity::Note, &[(row, line.number)], text);
            }
        } else if held < usual {
            // Channels with an X of their own may be shorter than others.
            let is_shorter = held > 0 && block.layout.x_cells.get(held).copied().unwrap_or(false);
            if !is_shorter {
                self.tally.line(FindingKind::RaggedLine, row, line.number, || format!("{held} cells"));
            }
        } else if is_shifted {
            let count = usual + extras;
            self.tally.line(FindingKind::RaggedLine, row, line.number, || format!("{count} cells"));
            self.values.iter_mut().for_each(|value| *value = f64::NAN);
        }
        self.values.resize(usual, f64::NAN);
        self.kinds.resize(usual, CellKind::Empty);
        if block.layout.is_first_blank && self.kinds.first().is_some_and(|kind| *kind != CellKind::Empty) {
            self.odd.ignored_x.add(row, line.number, all.first().copied().unwrap_or_default());
        }
        let words = if is_shifted || comment.is_empty() { String::new() } else { as_text(comment) };
        if !words.is_empty() && !block.layout.is_comment_named {
            let why = "text behind the channels is kept as `Comment`, which the line of names does not have".to_owned();
            if !self.reasons.contains(&why) {
                self.reasons.push(why);
            }
        }
        let careful = (!is_shifted).then_some((&self.kinds[..], &all[..]));
        let row = Row { values: &self.values, careful, at: self.at, line: line.number, comment: &words, cut };
        block.push(row, &mut self.names);
        self.at += 1;
    }
}

/// What stands behind the channels.
fn comment(line: &[u8], separator: u8, usual: usize) -> &[u8] {
    let mut rest = line;
    for _ in 0..usual {
        let Some(at) = rest.iter().position(|b| *b == separator) else { return &[] };
        rest = rest.get(at + 1..).unwrap_or_default();
    }
    plain(without_end(rest, separator))
}
