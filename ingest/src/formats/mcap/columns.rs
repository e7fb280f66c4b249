//! The columns of a topic while its messages go by: one row of cells, filled by a decoder, then added to all columns at once.
//!
//! A message that turns out to be damaged half-way leaves no half row: its cells become holes before the row is added.

use std::collections::HashMap;

use crate::limits::{ARRAY_COLUMNS_MAX, LOG_CELLS_MAX, LOG_COLUMNS_MAX, PADDING_CELLS_MAX, TEXT_BYTES_MAX};
use crate::recording::{Builder, Cells, ClockUnit, Column, Keep};
use crate::watch::Summary;

/// The columns that every topic has: when a message was written to the file, and when it was sent.
pub(super) const TIMES: [&str; 2] = [super::LOG_TIME, super::PUBLISH_TIME];

/// Cells of rows that are given to the columns at once: they fit into the cache beside what else is at work.
const BLOCK_CELLS: usize = 2_048;

/// What all topics of a recording may still ask for.
#[derive(Debug)]
pub(super) struct Budget {
    columns: usize,
    cells: usize,
    padding: usize,
}

impl Default for Budget {
    fn default() -> Self {
        Self { columns: LOG_COLUMNS_MAX, cells: LOG_CELLS_MAX, padding: PADDING_CELLS_MAX }
    }
}

impl Budget {
    /// Whether a limit on cells has been passed, in words.
    pub fn exceeded(&self) -> Option<String> {
        if self.cells == 0 {
            Some(format!("more than {LOG_CELLS_MAX} cells"))
        } else if self.padding == 0 {
            Some(format!("more than {PADDING_CELLS_MAX} holes where sequences are shorter than the longest one"))
        } else {
            None
        }
    }
}

/// Where a decoder puts the cells of a field.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Slot {
    Number(usize),
    Text(usize),
    /// A text that is looked at and not kept.
    Words,
    /// Not asked for, or beyond a limit.
    None,
}

#[derive(Debug)]
struct Texts {
    cells: Vec<String>,
    next: String,
}

/// A column as it will stand in the table.
#[derive(Debug)]
struct Named {
    name: String,
    unit: Option<&'static str>,
    slot: Slot,
}

/// The columns of a topic.
#[derive(Debug)]
pub(super) struct Columns {
    topic: String,
    named: Vec<Named>,
    by_name: HashMap<String, Slot>,
    numbers: Vec<Builder>,
    kept: usize,
    texts: Vec<Texts>,
    /// Rows that stand before the columns get them, so many at once: row after row, the message at hand at `at`.
    block: Vec<f64>,
    width: usize,
    at: usize,
    /// Columns that came after the first message: cells that a message does not fill are holes.
    ragged: bool,
    rows: usize,
    /// Fields with more elements than become columns, and the longest of each.
    pub cut: Vec<(String, usize)>,
    /// Texts too long to be kept.
    pub long_texts: usize,
    /// Texts that are not UTF-8.
    pub bad_texts: usize,
    /// Numbers where the column holds text, and the other way round.
    pub mixed: usize,
}

impl Columns {
    /// The two columns that every topic has; `None` if the recording has too many columns already.
    pub fn new(topic: &str, keep: Keep, budget: &mut Budget) -> Option<Self> {
        let mut columns = Self::empty(topic);
        for time in TIMES {
            let slot = columns.number(time, Some("s"), true, keep, budget);
            if slot == Slot::None {
                return None;
            }
            columns.date(slot);
        }
        // A field of a message may be called the same.
        columns.by_name.clear();
        Some(columns)
    }

    fn empty(topic: &str) -> Self {
        Self {
            topic: topic.to_owned(),
            named: vec![],
            by_name: HashMap::new(),
            numbers: vec![],
            kept: 0,
            texts: vec![],
            block: vec![],
            width: 0,
            at: 0,
            ragged: false,
            rows: 0,
            cut: vec![],
            long_texts: 0,
            bad_texts: 0,
            mixed: 0,
        }
    }

    pub fn rows(&self) -> usize {
        self.rows
    }

    /// The slot of a column of numbers, made if there is none of that name; a stamp is decoded even if it is not asked for.
    pub fn number(
        &mut self,
        name: &str,
        unit: Option<&'static str>,
        stamp: bool,
        keep: Keep,
        budget: &mut Budget,
    ) -> Slot {
        if let Some(slot) = self.by_name.get(name) {
            return *slot;
        }
        let asked = name;
        let name = &*self.unique(name);
        // Which stamp is the clock turns out at the end; when the recorder wrote the message is asked for by name.
        let kept = keep.keeps(&self.topic, name, 0) || (stamp && asked != super::LOG_TIME && keep.wants(&self.topic));
        if !self.room(name, budget) {
            return Slot::None;
        }
        let slot = if kept || stamp || !matches!(keep, Keep::Only(_)) {
            // Stamps that are kept can be looked at later.
            let is_watched = stamp && !kept;
            let mut builder =
                if is_watched { Builder::clock(false, ClockUnit::Seconds(1.0)) } else { Builder::new(kept) };
            for _ in 0..self.rows {
                builder.push(f64::NAN);
            }
            budget.padding = budget.padding.saturating_sub(self.rows);
            self.kept += usize::from(kept);
            self.ragged |= self.rows > 0;
            self.numbers.push(builder);
            self.widen();
            Slot::Number(self.width - 1)
        } else {
            Slot::None
        };
        self.add(asked, name, unit, slot)
    }

    /// Says that a column holds instants: they count from the recording's origin.
    pub fn date(&mut self, slot: Slot) {
        if let Slot::Number(slot) = slot
            && let Some(builder) = self.numbers.get_mut(slot)
        {
            builder.date();
        }
    }

    /// The cells of the message at hand.
    #[inline]
    fn row(&mut self) -> &mut [f64] {
        // The block always has room for one more row: it is made so, and emptied when it is full.
        &mut self.block[self.at..self.at + self.width]
    }

    /// Neighbouring cells of the message at hand.
    #[inline]
    pub fn cells(&mut self, slot: usize, count: usize) -> Option<&mut [f64]> {
        self.row().get_mut(slot..slot + count)
    }

    /// Makes room for one more column in the block, in the message at hand too.
    fn widen(&mut self) {
        let message = self.row().to_vec();
        // The new column has its holes for these rows already.
        let (rows, made) = (self.block[..self.at].to_vec(), self.numbers.len() - 1);
        for (column, builder) in self.numbers.iter_mut().take(made).enumerate() {
            builder.extend(rows.chunks_exact(self.width).map(|row| row[column]));
        }
        self.width += 1;
        self.at = 0;
        let rows = (BLOCK_CELLS / self.width).max(1);
        self.block = vec![f64::NAN; rows * self.width];
        self.block[..message.len()].copy_from_slice(&message);
    }

    /// Gives the rows of the block to the columns.
    fn flush(&mut self) {
        for (column, builder) in self.numbers.iter_mut().enumerate() {
            builder.extend(self.block[..self.at].chunks_exact(self.width).map(|row| row[column]));
        }
        self.at = 0;
    }

    /// The slot of a column of text, made if there is none of that name.
    pub fn text(&mut self, name: &str, keep: Keep, budget: &mut Budget) -> Slot {
        if let Some(slot) = self.by_name.get(name) {
            return *slot;
        }
        let asked = name;
        let name = &*self.unique(name);
        if !self.room(name, budget) {
            return Slot::None;
        }
        let slot = if keep.keeps(&self.topic, name, 0) {
            self.texts.push(Texts { cells: vec![String::new(); self.rows], next: String::new() });
            budget.padding = budget.padding.saturating_sub(self.rows);
            Slot::Text(self.texts.len() - 1)
        } else if matches!(keep, Keep::Only(_)) {
            Slot::None
        } else {
            Slot::Words
        };
        self.add(asked, name, None, slot)
    }

    fn room(&mut self, name: &str, budget: &mut Budget) -> bool {
        if budget.columns == 0 || budget.padding == 0 {
            // Names of single elements would fill the sentence.
            let field = name.split('[').next().unwrap_or(name);
            self.cut_at(field, 0);
            return false;
        }
        budget.columns -= 1;
        true
    }

    /// A field that is called as one of the times gets another name.
    fn unique<'n>(&self, name: &'n str) -> std::borrow::Cow<'n, str> {
        if self.named.len() >= TIMES.len() && TIMES.contains(&name) {
            format!("message.{name}").into()
        } else {
            name.into()
        }
    }

    fn add(&mut self, field: &str, name: &str, unit: Option<&'static str>, slot: Slot) -> Slot {
        self.named.push(Named { name: name.to_owned(), unit, slot });
        self.by_name.insert(field.to_owned(), slot);
        slot
    }

    /// A field holds more elements than become columns.
    pub fn cut_at(&mut self, field: &str, elements: usize) {
        if let Some((_, most)) = self.cut.iter_mut().find(|(name, _)| name == field) {
            *most = elements.max(*most);
        } else if self.cut.len() < ARRAY_COLUMNS_MAX {
            // More could not be read in a finding anyway.
            self.cut.push((field.to_owned(), elements));
        }
    }

    /// Before a message, if not every message fills every cell.
    #[inline]
    pub fn begin(&mut self, ragged: bool) {
        self.ragged |= ragged;
        if self.ragged {
            self.row().fill(f64::NAN);
        }
        for text in &mut self.texts {
            text.next.clear();
        }
    }

    /// Puts a number into its cell.
    #[inline]
    pub fn put(&mut self, slot: Slot, value: f64) {
        match slot {
            Slot::Number(slot) => {
                if let Some(cell) = self.row().get_mut(slot) {
                    *cell = value;
                }
            }
            Slot::Text(_) | Slot::Words => self.mixed += 1,
            Slot::None => {}
        }
    }

    /// Puts a text into its cell.
    pub fn put_text(&mut self, slot: Slot, text: &[u8]) {
        let cell = match slot {
            Slot::Text(slot) => self.texts.get_mut(slot),
            Slot::Words => None,
            Slot::Number(_) => {
                self.mixed += 1;
                return;
            }
            Slot::None => return,
        };
        let is_long = text.len() > TEXT_BYTES_MAX;
        self.long_texts += usize::from(is_long);
        self.bad_texts += usize::from(!is_long && std::str::from_utf8(text).is_err());
        if let Some(cell) = cell {
            cell.next.clear();
            if !is_long {
                cell.next.push_str(&String::from_utf8_lossy(text));
            }
        }
    }

    /// After a message that cannot be decoded: nothing of it counts but its row and its times.
    pub fn spoil(&mut self) {
        self.row().fill(f64::NAN);
        self.texts.iter_mut().for_each(|text| text.next.clear());
    }

    /// Adds the row, with the times of the message.
    #[inline]
    pub fn commit(&mut self, log_time: f64, publish_time: f64, budget: &mut Budget) {
        if let [log, publish, ..] = self.row() {
            (*log, *publish) = (log_time, publish_time);
        }
        if self.ragged {
            let holes = self.row().iter().filter(|cell| cell.is_nan()).count();
            budget.padding = budget.padding.saturating_sub(holes);
        }
        self.at += self.width;
        if self.at == self.block.len() {
            self.flush();
        }
        let mut cells = self.kept;
        for text in &mut self.texts {
            cells += 4 + text.next.len() / 8;
            text.cells.push(text.next.clone());
        }
        budget.cells = budget.cells.saturating_sub(cells);
        self.rows += 1;
    }

    /// Removes all columns but the times, before the first message.
    pub fn forget(&mut self) {
        self.named.truncate(TIMES.len());
        self.numbers.truncate(TIMES.len());
        self.width = self.numbers.len();
        self.block = vec![f64::NAN; BLOCK_CELLS / self.width * self.width];
        self.texts.clear();
        self.by_name.clear();
    }

    /// Removes the columns whose names begin so: a field turned out not to be a signal.
    pub fn drop_field(&mut self, field: &str) {
        self.named.retain(|named| !named.name.starts_with(field) || !named.name[field.len()..].starts_with('['));
    }

    /// The columns.
    pub fn finish(mut self) -> Vec<Column> {
        self.flush();
        let mut numbers: Vec<Option<Builder>> = self.numbers.into_iter().map(Some).collect();
        let mut texts: Vec<Option<Texts>> = self.texts.into_iter().map(Some).collect();
        let column = |Named { name, unit, slot }: Named| {
            let unit = unit.map(str::to_owned);
            let builder = match slot {
                Slot::Number(slot) => numbers.get_mut(slot).and_then(Option::take),
                _ => None,
            };
            let text = match slot {
                Slot::Text(slot) => texts.get_mut(slot).and_then(Option::take),
                _ => None,
            };
            match (builder, text) {
                (Some(builder), _) => builder.finish(name, unit),
                (None, text) => {
                    let cells = text.map_or(Cells::NotKept, |text| Cells::Text(text.cells));
                    Column { name, unit, cells, summary: Summary::default(), clock: None, is_dated: false, std: None }
                }
            }
        };
        self.named.into_iter().map(column).collect()
    }
}
