//! Where a segment begins and ends.

use super::super::block::{Axis, Block};
use super::super::clock::Segment;
use super::super::header::number;
use super::super::layout::{Channel, Looked, Question, XColumns};
use super::{Reader, State};
use crate::IngestError;
use crate::formats::csv::Decimal;
use crate::limits::LOG_COLUMNS_MAX;

impl Reader<'_> {
    /// Finds out the decimal sign from the first rows, once there are some.
    fn find_decimal(&mut self, looked: &Looked, line: usize) {
        if self.is_decimal_found {
            return;
        }
        let stated = match self.file.value("Decimal_Separator") {
            Some("." | "Point" | "Dot" | "Period") => Some(Decimal::Point),
            Some("," | "Comma") => Some(Decimal::Comma),
            _ => None,
        };
        self.is_decimal_found = !looked.rows.is_empty();
        if self.separator == b',' {
            self.decimal = Decimal::Point;
            if stated == Some(Decimal::Comma) && self.is_decimal_found {
                self.reason("commas part the cells: the decimal sign is the point, whatever is stated".to_owned());
            }
            return;
        }
        let (points, commas) = (looked.numbers(Decimal::Point), looked.numbers(Decimal::Comma));
        let in_header =
            ["X0", "Delta_X"].iter().filter_map(|key| self.header.value(key)).chain(self.file.value("Time"));
        let header_has_comma = in_header.filter(|value| value.contains([',', '.'])).map(|v| v.contains(',')).next();
        let by_header = header_has_comma.map(|comma| if comma { Decimal::Comma } else { Decimal::Point });
        let by_rows = match points.cmp(&commas) {
            std::cmp::Ordering::Greater => Some(Decimal::Point),
            std::cmp::Ordering::Less => Some(Decimal::Comma),
            std::cmp::Ordering::Equal => None,
        };
        self.decimal = by_rows.or(stated).or(by_header).unwrap_or(Decimal::Point);
        if !self.is_decimal_found {
            return;
        }
        let word = if self.decimal == Decimal::Comma { "the comma" } else { "the point" };
        match stated {
            Some(stated) if stated != self.decimal => {
                self.odd.decimal.add_said(0, line, || format!("it is {word}"));
                self.reason(format!("by the first rows the decimal sign is {word}, not as stated"));
            }
            Some(_) => self.reason(format!("the decimal sign is {word}, as stated")),
            None => self.reason(format!("Decimal_Separator is not stated: by the bytes it is {word}")),
        }
    }

    /// A line of names, or a first row without one: finds out how the rows behind it are laid out and where they go.
    pub(super) fn begin_segment(
        &mut self,
        names: Option<Vec<&[u8]>>,
        looked: &Looked,
        line: usize,
    ) -> Result<(), IngestError> {
        self.find_decimal(looked, line);
        let stated = self.file.value("X_Columns").and_then(XColumns::of);
        let question = Question { names, header: &self.header, stated, looked, decimal: self.decimal };
        let (mut layout, remarks) = question.answer();
        let current = self.blocks.get(self.current).map(|block| &block.layout);
        if let Some(before) = current.filter(|before| looked.rows.is_empty() && before.is_named_as(&layout)) {
            // Without rows nothing tells that it is laid out otherwise than the one before.
            layout = before.clone();
        } else {
            for reason in remarks.reasons {
                self.reason(reason);
            }
        }
        let row = self.rows();
        if let Some(mismatch) = remarks.mismatch {
            self.odd.channels.add_said(row, line, || mismatch);
        }
        // The first samples of a channel may be missing: any one says what X counts from.
        let channels = layout.channels.len();
        let x0 = |(index, channel): (usize, &Channel)| {
            self.header.of_channel("X0", channel.column, index, channels, true).and_then(number)
        };
        let x = |(index, channel): (usize, &Channel)| match channel.x_cell {
            Some(cell) => looked.first(cell, self.decimal),
            None => x0((index, channel)),
        };
        let first_x = layout.channels.iter().enumerate().find_map(x).map(|x| x * layout.unit_s);
        let is_absolute = self.file.value("Time_Pref").is_some_and(|pref| pref.eq_ignore_ascii_case("absolute"));
        let (file, header) = (&self.file, &self.header);
        let (offsets, start) =
            self.clock.begin(&Segment { file, header, layout: &layout, first_x, is_absolute, row, line });
        let is_time = layout.is_time;
        let axis = |(index, channel): (usize, &Channel)| {
            let offset_s = offsets.get(index).copied().unwrap_or(0.0);
            let unit_s = layout.unit_s;
            if let Some(cell) = channel.x_cell {
                return Axis::Cell { cell, unit_s, offset_s };
            }
            let first = x0((index, channel)).unwrap_or(0.0);
            // Where there is no step, X counts the rows.
            let step = channel.step.unwrap_or(1.0);
            Axis::Steps { first, step, unit_s, offset_s }
        };
        let axes: Vec<Axis> = layout.channels.iter().enumerate().map(axis).collect();
        let implicit =
            axes.iter().find_map(|axis| if let Axis::Steps { step, .. } = axis { Some(*step) } else { None });
        self.start = start.filter(|_| is_time && implicit.is_some());
        let is_x0_missing = |(index, channel)| Channel::is_implicit(channel) && x0((index, channel)).is_none();
        if is_time && header.is_stated && layout.channels.iter().enumerate().any(is_x0_missing) {
            self.reason("X0 is not stated: taken for 0".to_owned());
        }
        let is_plain = layout.channels.iter().all(|channel| channel.x_cell.is_some());
        let is_blank = layout.is_first_blank && layout.cells > 1;
        let is_shifted = layout.x_cells.iter().all(|is_x| !is_x);
        let can_be_fast = self.separator.is_ascii() && self.separator != b' ' && (is_plain || is_blank || is_shifted);
        self.fast = can_be_fast.then_some((layout.cells, is_blank));
        let known = self.of_signature.get(&layout.signature).copied();
        let index = if let Some(index) = known {
            // Steps, and whether comments are named, are those of this segment.
            if let Some(block) = self.blocks.get_mut(index) {
                block.layout = layout;
            }
            index
        } else {
            let columns: usize = self.blocks.iter().map(Block::columns).sum();
            let all = columns.saturating_add(layout.channels.len() + 1);
            if all > LOG_COLUMNS_MAX {
                let expected = format!("at most {LOG_COLUMNS_MAX} columns in all segments");
                let next = "segments with other channels become tables of their own: split the file";
                return Err(self.unusable(line, &expected, format!("{all} so far"), next));
            }
            self.of_signature.insert(layout.signature.clone(), self.blocks.len());
            self.blocks.push(Block::new(layout, &axes, self.keep, &mut self.names));
            self.blocks.len() - 1
        };
        // Without a header of its own a segment counts on.
        if self.header.is_stated || index != self.current {
            self.at = 0;
        }
        self.parted = None;
        if index != self.current {
            let cells = |index: usize| self.blocks.get(index).map_or(0, Block::cells);
            self.other_cells = (self.other_cells + cells(self.current)).saturating_sub(cells(index));
        }
        self.current = index;
        if let Some(block) = self.blocks.get_mut(index) {
            block.begin(&axes, line, &mut self.names);
        }
        self.state = State::Rows;
        Ok(())
    }

    /// The rows of a segment have ended.
    pub(super) fn end_segment(&mut self) {
        self.fast = None;
        self.state = State::Between;
        self.clock.is_used |= self.at > 0;
        let is_parted = self.parted.is_some_and(|rows| 0 < rows && rows < self.at);
        let Some(block) = self.blocks.get_mut(self.current) else { return };
        let (line, row) = (block.line, block.rows().saturating_sub(1));
        let layout = block.layout.clone();
        let is_implicit = layout.channels.iter().any(Channel::is_implicit);
        if is_parted && is_implicit && layout.is_time {
            self.reason(
                "blank lines part rows under one header: X counts on behind them, as if no time had gone by".to_owned(),
            );
        }
        let Some(block) = self.blocks.get_mut(self.current) else { return };
        let held = block.end();
        self.odd.segment(&held, &self.header, &layout, line, row);
        if let Some(first) = held.first()
            && layout.is_time
            && layout.channels.first().is_some_and(|channel| channel.x_cell.is_none())
            && let Some(step) = layout.channels.first().and_then(|channel| channel.step)
        {
            self.odd.implicit(self.start, first.rows, step * layout.unit_s);
        }
        self.header = self.header.next();
        self.own.clear();
    }
}
