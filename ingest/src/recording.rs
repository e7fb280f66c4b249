//! What a raw file holds, whatever its format: tables of columns, and what is odd about them.
//!
//! A text log is one table, a ROS 2 bag has one for each topic. The samples of a table share one clock; those of two tables need not.

use crate::camera::photograph::Photograph;
use crate::finding::{Finding, LineMap, median_step};
use crate::formats::csv::Decimal;
use crate::units::Unit;
use crate::watch::{ClockSummary, ClockWatch, Summary, Watch};

/// What was read from a raw file.
#[derive(Debug, Clone, PartialEq)]
pub struct Recording {
    /// Its format in words: `MCAP`, `delimited text`.
    pub format: &'static str,
    /// Its tables, in the order of the file; topics by name.
    pub tables: Vec<Table>,
    /// What is odd about it.
    pub findings: Vec<Finding>,
    /// How the format and layout were found out, one sentence each.
    pub reasons: Vec<String>,
    /// What the file says beside its samples: metadata lines, records, attachments.
    pub metadata: Vec<String>,
    /// The instant from which stamps count, where they are absolute: RFC 3339, to the second.
    pub origin: Option<String>,
    /// Some of its pictures, where it holds any that were measured.
    pub photographs: Vec<Photograph>,
}

/// Columns of equal length.
#[derive(Debug, Clone, PartialEq)]
pub struct Table {
    /// The topic; empty where the file has no names for its tables. It is a namespace: several tables may share a name, and then no two
    /// of their columns do, so that a column's [`full_name`] is one column of the recording.
    pub name: String,
    /// What it holds, where the file says it: a message type.
    pub schema: Option<String>,
    /// Its columns.
    pub columns: Vec<Column>,
    /// Samples.
    pub rows: usize,
    /// The line of every sample; empty for files without lines.
    pub lines: LineMap,
    /// The column that is its clock where the format says so.
    pub clock: Option<usize>,
    /// The decimal sign of numbers among text.
    pub decimal: Decimal,
}

/// A column.
#[derive(Debug, Clone, PartialEq)]
pub struct Column {
    /// As the header has it, `column 3`, or the path of a field.
    pub name: String,
    /// As written in the file.
    pub unit: Option<String>,
    /// What it holds.
    pub cells: Cells,
    /// What can be said of its numbers without keeping them.
    pub summary: Summary,
    /// The same of a column that is, or seems to be, a clock.
    pub clock: Option<ClockSummary>,
    /// Whether its numbers are seconds since the [`origin`](Recording::origin).
    pub is_dated: bool,
    /// The standard uncertainty of its numbers, where the reader knows it: of what was measured in pictures.
    pub std: Option<f64>,
}

/// The cells of a column.
#[derive(Debug, Clone, PartialEq)]
pub enum Cells {
    /// Numbers; NaN is a hole.
    Numbers(Vec<f64>),
    /// Text.
    Text(Vec<String>),
    /// Read, looked at and not kept: see [`Keep`].
    NotKept,
}

impl Cells {
    /// The numbers of a column of numbers.
    pub fn numbers(&self) -> Option<&[f64]> {
        match self {
            Self::Numbers(numbers) => Some(numbers),
            Self::Text(_) | Self::NotKept => None,
        }
    }

    /// The words of a column of text.
    pub fn text(&self) -> Option<&[String]> {
        match self {
            Self::Text(text) => Some(text),
            Self::Numbers(_) | Self::NotKept => None,
        }
    }

    /// Number of cells kept.
    pub fn len(&self) -> usize {
        match self {
            Self::Numbers(cells) => cells.len(),
            Self::Text(cells) => cells.len(),
            Self::NotKept => 0,
        }
    }

    /// Whether there is no cell.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

impl Column {
    /// A column of cells at hand.
    pub fn new(name: &str, unit: Option<&str>, cells: Cells) -> Self {
        let mut watch = Watch::default();
        if let Cells::Numbers(numbers) = &cells {
            watch.block(numbers);
        }
        let (name, unit) = (name.to_owned(), unit.map(str::to_owned));
        Self { name, unit, cells, summary: watch.finish(), clock: None, is_dated: false, std: None }
    }

    /// Whether it was watched as a clock and its stamps go forward.
    pub fn is_forward(&self) -> bool {
        self.clock.as_ref().is_some_and(ClockSummary::is_forward)
    }
}

impl Table {
    /// The column that is its clock: as the format says, or else the first that goes forward as clocks do, or else the first that has a
    /// unit of time, whatever its stamps do.
    pub fn time(&self) -> Option<&Column> {
        let own = self.clock.and_then(|clock| self.columns.get(clock));
        let watched = || self.columns.iter().filter(|column| column.clock.is_some());
        own.or_else(|| watched().find(|column| column.is_forward())).or_else(|| watched().find(|c| c.unit.is_some()))
    }

    /// The column of a name.
    pub fn column(&self, name: &str) -> Option<&Column> {
        self.columns.iter().find(|c| c.name == name)
    }

    /// What manifests call a column: `/pressure.fluid_pressure`, or its bare name where the file holds one table only.
    pub fn full_name(&self, column: &str) -> String {
        full_name(&self.name, column)
    }
}

/// What manifests call a column of a table.
///
/// ```
/// use pneuval_ingest::recording::full_name;
/// assert_eq!(full_name("/pressure", "fluid_pressure"), "/pressure.fluid_pressure");
/// assert_eq!(full_name("", "p"), "p");
/// ```
pub fn full_name(table: &str, column: &str) -> String {
    if table.is_empty() { column.to_owned() } else { format!("{table}.{column}") }
}

/// A column, as manifests name it.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub enum ColumnRef {
    /// Its [`full_name`].
    Name(String),
    /// From the left, the first is 1; in files of one table.
    Number(usize),
}

/// Which columns are kept in memory. All are looked at, but for fields of messages that are not asked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Keep<'a> {
    /// Every column.
    All,
    /// None: the summaries are what is wanted.
    Nothing,
    /// These.
    Only(&'a [ColumnRef]),
}

impl Keep<'_> {
    /// Whether any column of a table is kept, and with it the table's clock.
    pub fn wants(self, table: &str) -> bool {
        let is_of = |name: &str| name.strip_prefix(table).is_some_and(|rest| table.is_empty() || rest.starts_with('.'));
        match self {
            Self::All => true,
            Self::Nothing => false,
            Self::Only(columns) => columns.iter().any(|asked| match asked {
                ColumnRef::Number(_) => table.is_empty(),
                ColumnRef::Name(name) => is_of(name),
            }),
        }
    }

    /// Whether a column is kept; `number` counts from 1.
    pub fn keeps(self, table: &str, column: &str, number: usize) -> bool {
        match self {
            Self::All => true,
            Self::Nothing => false,
            Self::Only(columns) => columns.iter().any(|asked| match asked {
                ColumnRef::Number(asked) => table.is_empty() && *asked == number,
                ColumnRef::Name(asked) => *asked == full_name(table, column),
            }),
        }
    }
}

/// What one unit of a column of stamps is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ClockUnit {
    /// So many seconds.
    Seconds(f64),
    /// Not said: see [`guessed_unit`].
    Guessed,
}

/// 2014 to 2036, in s since 1970: a stamp so large counts from there.
pub const OUR_DAYS: std::ops::Range<f64> = 1.4e9..2.1e9;

/// The unit of stamps that state none, from one of them and the usual step: what counts from 1970 to our days tells its unit, and else
/// steps of one and more are milliseconds, for rigs log faster than once a second.
///
/// ```
/// use pneuval_ingest::recording::guessed_unit;
/// assert_eq!(guessed_unit(20.0, 10.0).symbol, "ms");
/// assert_eq!(guessed_unit(0.02, 0.01).symbol, "s");
/// assert_eq!(guessed_unit(1_790_000_000.0, 1.0).symbol, "s");
/// assert_eq!(guessed_unit(1.79e18, 1e7).symbol, "ns");
/// ```
pub fn guessed_unit(stamp: f64, step: f64) -> Unit {
    let since_1970 = |unit: &Unit| OUR_DAYS.contains(&unit.to_si(stamp));
    let units = [Unit::SECOND, Unit::MILLISECOND, Unit::MICROSECOND, Unit::NANOSECOND];
    let by_step = if step >= 1.0 { Unit::MILLISECOND } else { Unit::SECOND };
    units.into_iter().find(since_1970).unwrap_or(by_step)
}

impl ClockUnit {
    /// In seconds; a guess is made once, from the first stamps.
    fn seconds(&mut self, first: &[f64]) -> f64 {
        if let Self::Guessed = self {
            let stamp = first.iter().copied().find(|stamp| stamp.is_finite()).unwrap_or(0.0);
            *self = Self::Seconds(guessed_unit(stamp, median_step(first).unwrap_or(0.0)).to_si(1.0));
        }
        match self {
            Self::Seconds(seconds) => *seconds,
            Self::Guessed => 1.0,
        }
    }
}

/// Numbers on their way into a column: watched in blocks while they are in the cache, and kept if they are asked for.
#[derive(Debug, Clone, Default)]
pub struct Builder {
    /// All of them, or those not watched yet.
    values: Vec<f64>,
    watched: usize,
    keep: bool,
    watch: Watch,
    /// Of a clock.
    clock: Option<(ClockUnit, ClockWatch)>,
    is_dated: bool,
}

/// Numbers watched at once.
const BLOCK: usize = 1024;

impl Builder {
    /// An empty column.
    pub fn new(keep: bool) -> Self {
        Self { keep, ..Self::default() }
    }

    /// An empty column of stamps, watched as a clock.
    pub fn clock(keep: bool, unit: ClockUnit) -> Self {
        Self { keep, clock: Some((unit, ClockWatch::default())), ..Self::default() }
    }

    /// Says that the numbers are seconds since the recording's origin.
    pub fn date(&mut self) {
        self.is_dated = true;
    }

    /// Adds a number; NaN is a hole.
    #[inline]
    pub fn push(&mut self, value: f64) {
        self.values.push(value);
        if self.values.len() - self.watched >= BLOCK {
            self.flush();
        }
    }

    /// Adds numbers; NaN is a hole.
    #[inline]
    pub fn extend(&mut self, values: impl Iterator<Item = f64>) {
        self.values.extend(values);
        if self.values.len() - self.watched >= BLOCK {
            self.flush();
        }
    }

    /// Numbers so far.
    pub fn len(&self) -> usize {
        self.watch.samples() + self.values.len() - self.watched
    }

    /// Whether there is none so far.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Asks for the memory of so many more numbers, if they are kept.
    pub fn reserve(&mut self, count: usize) {
        if self.keep {
            self.values.reserve(count);
        }
    }

    /// Looks at whole blocks: what is cut otherwise would have to be put together again.
    #[cold]
    fn flush(&mut self) {
        let whole = (self.values.len() - self.watched) / BLOCK * BLOCK;
        self.watch(whole);
        if self.keep {
            self.watched += whole;
        } else {
            self.values.drain(..whole);
        }
    }

    fn watch(&mut self, count: usize) {
        let block = &self.values[self.watched..self.watched + count];
        self.watch.block(block);
        if let Some((unit, clock)) = &mut self.clock {
            let unit_s = unit.seconds(block);
            let mut seconds = [0.0; BLOCK];
            for block in block.chunks(BLOCK) {
                for (second, stamp) in seconds.iter_mut().zip(block) {
                    *second = stamp * unit_s;
                }
                clock.block(&seconds[..block.len()]);
            }
        }
    }

    /// The column.
    pub fn finish(mut self, name: String, unit: Option<String>) -> Column {
        self.watch(self.values.len() - self.watched);
        let cells = if self.keep { Cells::Numbers(self.values) } else { Cells::NotKept };
        let clock = self.clock.map(|(_, clock)| clock.finish());
        Column { name, unit, cells, summary: self.watch.finish(), clock, is_dated: self.is_dated, std: None }
    }
}
