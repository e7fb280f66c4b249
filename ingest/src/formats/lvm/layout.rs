//! How the rows of a segment are laid out: by the line of names, by what the headers state, and where they differ or say nothing, by the
//! first rows.

use std::fmt::Write as _;

use super::header::{
    END_SPECIAL, Header, START_SPECIAL, X_VALUE, behind, cells, is_title, number, segment_key, without_end,
};
use crate::finding::places::as_text;
use crate::formats::csv::source::Window;
use crate::formats::csv::{CellKind, Decimal, cell_kind};
use crate::units::{Dimension, Unit};

/// Rows that are looked at before a segment is read, and bytes in which they are looked for.
const LOOKED_ROWS: usize = 8;
pub(super) const LOOKED_BYTES: usize = 1 << 16;

/// Which columns of X a file has.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum XColumns {
    /// None: X is `X0 + i Delta_X`, and the first cell of a row is empty.
    No,
    /// One, for all channels.
    One,
    /// One for each channel.
    Multi,
}

impl XColumns {
    pub(super) fn of(text: &str) -> Option<Self> {
        [(Self::No, "No"), (Self::One, "One"), (Self::Multi, "Multi")]
            .into_iter()
            .find_map(|(kind, word)| word.eq_ignore_ascii_case(text).then_some(kind))
    }

    pub(super) fn word(self) -> &'static str {
        match self {
            Self::No => "No",
            Self::One => "One",
            Self::Multi => "Multi",
        }
    }
}

/// The first rows behind a line of names, as cells.
pub(super) struct Looked<'b> {
    pub rows: Vec<Vec<&'b [u8]>>,
}

impl<'b> Looked<'b> {
    /// `None` if more of the text is to be read first.
    pub fn new(window: Window<'b>, separator: u8) -> Option<Self> {
        let mut rows = Vec::new();
        let (mut at, mut is_special) = (0, false);
        while rows.len() < LOOKED_ROWS && at < LOOKED_BYTES {
            let Some((end, next)) = window.line(at) else {
                return (window.bytes.len() >= LOOKED_BYTES).then_some(Self { rows });
            };
            let line = window.bytes.get(at..end).unwrap_or_default();
            if next == at || (window.ended && next == end) {
                // The end of the text: a last line without an end may be cut, but it is all there is.
                if !is_special && rows.is_empty() && !line.is_empty() && !is_other(line) {
                    rows.push(cells(line, separator).collect());
                }
                break;
            }
            at = next;
            if line.starts_with(START_SPECIAL) || is_special {
                is_special = !line.starts_with(END_SPECIAL);
            } else if is_other(line) {
                break;
            } else if !without_end(line, separator).is_empty() {
                rows.push(cells(line, separator).collect());
            }
        }
        Some(Self { rows })
    }

    fn kind(&self, column: usize, decimal: Decimal) -> impl Iterator<Item = CellKind> {
        self.rows.iter().map(move |row| row.get(column).map_or(CellKind::Empty, |cell| cell_kind(cell, decimal)))
    }

    fn is_filled(&self, column: usize) -> bool {
        self.rows.iter().any(|row| row.get(column).is_some_and(|cell| !cell.is_empty()))
    }

    /// The first number in a column.
    pub fn first(&self, column: usize, decimal: Decimal) -> Option<f64> {
        self.kind(column, decimal)
            .find_map(|kind| if let CellKind::Number(number) = kind { Some(number) } else { None })
    }

    /// How many cells are numbers with this decimal sign.
    pub fn numbers(&self, decimal: Decimal) -> usize {
        let is_number = |cell: &&&[u8]| matches!(cell_kind(cell, decimal), CellKind::Number(_));
        self.rows.iter().flatten().filter(is_number).count()
    }
}

/// Whether a line begins something other than a row.
fn is_other(line: &[u8]) -> bool {
    line.starts_with(b"***") || behind(line, X_VALUE).is_some() || segment_key(line).is_some() || is_title(line)
}

/// A channel of a segment.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Channel {
    /// As the line of names has it.
    pub name: String,
    pub unit: Option<String>,
    /// Its column in the header and in the line of names.
    pub column: usize,
    /// The cell of a row that holds its value.
    pub cell: usize,
    /// The cell that holds its X, if it has one.
    pub x_cell: Option<usize>,
    /// `Delta_X`.
    pub step: Option<f64>,
}

impl Channel {
    /// Whether its X is `X0 + i Delta_X`.
    pub fn is_implicit(&self) -> bool {
        self.x_cell.is_none()
    }
}

/// How the rows of a segment are laid out.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Layout {
    pub channels: Vec<Channel>,
    /// Cells of a row without its comment.
    pub cells: usize,
    /// Whether the line of names has a `Comment` behind the channels.
    pub is_comment_named: bool,
    /// Whether the first cell of a row is empty, where X would stand.
    pub is_first_blank: bool,
    /// Which cells of a row hold X, given or not.
    pub x_cells: Vec<bool>,
    /// Whether X is time.
    pub is_time: bool,
    /// One unit of X in s.
    pub unit_s: f64,
    /// What must agree for rows of two segments to stand in one table.
    pub signature: String,
}

/// What was odd about a header, or found out beside it.
#[derive(Debug, Default)]
pub(super) struct Remarks {
    pub reasons: Vec<String>,
    /// The line of names has another number of channels than is stated, or than the rows hold.
    pub mismatch: Option<String>,
}

/// What a layout is found out from.
pub(super) struct Question<'a, 'b> {
    /// The cells of the line of names, if there is one.
    pub names: Option<Vec<&'b [u8]>>,
    pub header: &'a Header,
    pub stated: Option<XColumns>,
    pub looked: &'a Looked<'b>,
    pub decimal: Decimal,
}

impl Question<'_, '_> {
    /// The layout and what was odd on the way.
    pub fn answer(mut self) -> (Layout, Remarks) {
        let mut remarks = Remarks::default();
        let (looked, header, decimal) = (self.looked, self.header, self.decimal);
        let is_named = self.names.is_some();
        let mut names = self.names.take().unwrap_or_else(|| vec![&b""[..]; self.width()]);
        let stated_channels = header.value("Channels").and_then(|value| value.parse::<usize>().ok());
        // Separators at the end name nothing, unless a channel stands there whose name is empty.
        while let Some(last) = names.len().checked_sub(1)
            && (stated_channels.is_none_or(|stated| last > stated) || !looked.is_filled(last))
            && names.pop_if(|name| name.is_empty() && is_named).is_some()
        {}
        let is_comment = |name: &&[u8]| name.eq_ignore_ascii_case(super::COMMENT.as_bytes());
        let mut is_comment_named = names.len() > 1 && names.last().is_some_and(is_comment);
        let last = names.len().saturating_sub(1);
        let is_number = |kind: CellKind| matches!(kind, CellKind::Number(_));
        if is_comment_named && stated_channels == Some(last) && last > 1 && looked.kind(last, decimal).all(is_number) {
            // Channels may have any name.
            is_comment_named = looked.rows.is_empty();
        }
        if is_comment_named {
            names.pop();
        }
        let before = names.len();
        if is_named && !is_comment_named {
            while names.len() < 2 * before + 1
                && !looked.rows.is_empty()
                && looked.kind(names.len(), decimal).all(|kind| matches!(kind, CellKind::Number(_) | CellKind::Hole))
            {
                names.push(b"");
            }
        }
        let is_x = self.x_of(&names, stated_channels);
        let mut channels = self.channels(&names, &is_x);
        if names.len() > before {
            remarks.mismatch = Some(format!("{before} columns are named, the rows hold {}", names.len()));
        } else if let Some(stated) = stated_channels.filter(|stated| *stated != channels.len()) {
            remarks.mismatch = Some(format!("`Channels` is {stated}, {} are named", channels.len()));
        }
        let (is_first_blank, is_shifted) = self.place_x(&mut channels, &mut remarks);
        let step = channels.iter().find_map(|channel| channel.step);
        for channel in channels.iter_mut().filter(|channel| channel.x_cell.is_none() && channel.step.is_none()) {
            channel.step = step;
            if let Some(step) = step {
                let name = crate::error::shown(&channel.name);
                remarks.reasons.push(format!(
                    "{name} has neither an X nor a `Delta_X`: {step}, that of another channel, is taken"
                ));
            }
        }
        if !is_named {
            remarks.reasons.push("no line `X_Value` names the columns".to_owned());
        }
        let (mut is_time, unit_s) = self.x_dimension(&channels, &mut remarks);
        if is_time && channels.first().is_some_and(|c| c.x_cell.is_none() && c.step.is_none()) {
            remarks
                .reasons
                .push("there is neither a column of X nor a `Delta_X`: X counts the rows, from 0".to_owned());
            is_time = false;
        }
        let cells = names.len().max(1) - usize::from(is_shifted);
        let x_cells = if is_shifted { vec![false; cells] } else { is_x };
        let mut layout = Layout {
            channels,
            cells,
            is_comment_named,
            is_first_blank,
            x_cells,
            is_time,
            unit_s,
            signature: String::new(),
        };
        layout.sign();
        (layout, remarks)
    }

    /// Columns of the first rows, where no line names them.
    fn width(&self) -> usize {
        let numbers = |row: &Vec<&[u8]>| {
            let filled = row.iter().rposition(|cell| !cell.is_empty()).map_or(0, |last| last + 1);
            let is_text = |cell: &&[u8]| matches!(cell_kind(cell, self.decimal), CellKind::Text);
            row.iter().position(is_text).unwrap_or(filled).min(filled)
        };
        self.looked.rows.iter().map(numbers).max().unwrap_or(0)
    }

    /// Which columns hold X.
    fn x_of(&self, names: &[&[u8]], stated_channels: Option<usize>) -> Vec<bool> {
        let mut is_x: Vec<bool> = names.iter().map(|name| name.eq_ignore_ascii_case(X_VALUE)).collect();
        if let Some(first) = is_x.first_mut() {
            *first = true;
        }
        // A channel may have that name too: one whose X stands before it, or that has nothing behind it.
        let is_single = self.stated != Some(XColumns::Multi) && stated_channels.is_some_and(|n| names.len() == n + 1);
        for column in 1..is_x.len() {
            let is_behind = column.checked_sub(1).and_then(|before| is_x.get(before)) == Some(&true);
            let is_last = column + 1 == is_x.len();
            if (is_single || is_behind || is_last)
                && let Some(is_x) = is_x.get_mut(column)
            {
                *is_x = false;
            }
        }
        let is_once = is_x.iter().filter(|is_x| **is_x).count() == 1;
        let fits = stated_channels.map_or(names.len().is_multiple_of(2), |channels| names.len() == 2 * channels);
        if self.stated == Some(XColumns::Multi) && is_once && fits && names.len() > 2 {
            is_x = (0..names.len()).map(|column| column % 2 == 0).collect();
        }
        is_x
    }

    fn channels(&self, names: &[&[u8]], is_x: &[bool]) -> Vec<Channel> {
        let mut x_cell = None;
        let mut columns = Vec::new();
        for (column, (name, is_x)) in names.iter().zip(is_x).enumerate() {
            if *is_x {
                x_cell = Some(column);
            } else {
                columns.push((column, *name, x_cell));
            }
        }
        if columns.is_empty() {
            // Nothing but X: it is the one channel.
            columns.push((0, X_VALUE, None));
        }
        let count = columns.len();
        let channel = |(index, (column, name, x_cell)): (usize, (usize, &[u8], Option<usize>))| {
            let of = |key, is_common| self.header.of_channel(key, column, index, count, is_common);
            let name = if name.is_empty() { format!("column {}", column + 1) } else { as_text(name) };
            let unit = of("Y_Unit_Label", false).map(str::to_owned);
            let step = of("Delta_X", true).and_then(number).filter(|step| *step != 0.0);
            Channel { name, unit, column, cell: column, x_cell, step }
        };
        columns.into_iter().enumerate().map(channel).collect()
    }

    /// Finds out which channels have an X in the rows; whether the first cell is empty, and whether rows begin behind it.
    fn place_x(&self, channels: &mut [Channel], remarks: &mut Remarks) -> (bool, bool) {
        let looked = self.looked;
        let count = channels.len();
        let is_one_x = channels.iter().all(|channel| channel.x_cell == Some(0));
        let begins_behind = |row: &Vec<&[u8]>| {
            let numbers = row
                .iter()
                .take_while(|cell| !matches!(cell_kind(cell, self.decimal), CellKind::Text | CellKind::Empty));
            row.first().is_some_and(|cell| !cell.is_empty()) && numbers.count() <= count
        };
        if self.stated == Some(XColumns::No)
            && is_one_x
            && !looked.rows.is_empty()
            && looked.rows.iter().all(begins_behind)
        {
            remarks.reasons.push("X_Columns is No, and rows have no empty cell where X would stand".to_owned());
            for channel in channels {
                channel.cell = channel.column.saturating_sub(1);
                channel.x_cell = None;
            }
            return (false, true);
        }
        // Channels that share an X are asked together: the first samples of one of them may be missing.
        let mut is_blank = vec![None; channels.last().map_or(0, |last| last.cell + 1)];
        for channel in channels.iter() {
            let Some(blank) = channel.x_cell.and_then(|x| is_blank.get_mut(x)) else { continue };
            let has_x = || channel.x_cell.is_some_and(|x| looked.is_filled(x));
            *blank = Some(match *blank {
                Some((blank, has_y)) => (blank, has_y || looked.is_filled(channel.cell)),
                None => (!has_x(), looked.is_filled(channel.cell)),
            });
        }
        for channel in channels.iter_mut() {
            let blank = channel.x_cell.and_then(|x| is_blank.get(x).copied().flatten());
            if let Some((true, has_y)) = blank
                && (has_y || self.stated == Some(XColumns::No))
            {
                channel.x_cell = None;
            }
        }
        let is_implicit = channels.iter().all(|channel| channel.x_cell.is_none());
        let several = channels.iter().any(|channel| channel.x_cell.is_some_and(|x| x > 0));
        let found = if is_implicit {
            XColumns::No
        } else if several {
            XColumns::Multi
        } else {
            XColumns::One
        };
        match self.stated {
            None => remarks.reasons.push(format!("X_Columns is not stated: by names and rows it is {}", found.word())),
            // One channel has one X either way.
            Some(XColumns::Multi) if found == XColumns::One && count == 1 => {}
            Some(stated) if stated != found => {
                remarks.reasons.push(format!(
                    "X_Columns is {}, by names and rows it is {}",
                    stated.word(),
                    found.word()
                ));
            }
            Some(stated) => remarks.reasons.push(format!("X_Columns is {}, as stated", stated.word())),
        }
        (is_implicit && is_one_x, false)
    }

    /// Whether X is time, and one unit of it in s.
    fn x_dimension(&self, channels: &[Channel], remarks: &mut Remarks) -> (bool, f64) {
        let Some(first) = channels.first() else { return (false, 1.0) };
        let of = |key| self.header.of_channel(key, first.column, 0, channels.len(), true);
        let is_time = match of("X_Dimension") {
            None => {
                remarks.reasons.push("X_Dimension is not stated: X is taken for time in s".to_owned());
                true
            }
            Some(text) if text.eq_ignore_ascii_case("time") => true,
            Some(other) => {
                remarks.reasons.push(format!("X is no time: X_Dimension is {}", crate::error::shown(other)));
                false
            }
        };
        let other = |(index, channel): (usize, &Channel)| {
            let own = self.header.of_channel("X_Dimension", channel.column, index, channels.len(), true);
            own.is_some_and(|own| own.eq_ignore_ascii_case("time") != is_time)
        };
        if let Some(channel) = channels.iter().enumerate().position(other).and_then(|index| channels.get(index)) {
            let name = crate::error::shown(&channel.name);
            remarks
                .reasons
                .push(format!("X_Dimension of {name} is another one: that of the first channel is taken for all"));
        }
        let unit = of("X_Unit_Label").and_then(Unit::parse_loose).map(|(unit, _)| unit);
        let unit_s =
            unit.filter(|unit| is_time && unit.dimension == Dimension::Time).map_or(1.0, |unit| unit.to_si(1.0));
        if unit_s.to_bits() != 1.0_f64.to_bits() {
            remarks.reasons.push(format!("X_Unit_Label makes one unit of X {unit_s} s: stamps are in s"));
        }
        (is_time, unit_s)
    }
}

impl Layout {
    /// Whether names and units are the same, wherever X stands.
    pub fn is_named_as(&self, other: &Self) -> bool {
        let alike = |(a, b): (&Channel, &Channel)| (a.column, &a.name, &a.unit) == (b.column, &b.name, &b.unit);
        self.channels.len() == other.channels.len()
            && self.channels.iter().zip(&other.channels).all(alike)
            && (self.is_time, self.unit_s.to_bits()) == (other.is_time, other.unit_s.to_bits())
    }

    fn sign(&mut self) {
        let mut out = format!("{} {} {}\n", self.is_time, self.unit_s, self.cells);
        for channel in &self.channels {
            let unit = channel.unit.as_deref().unwrap_or_default();
            // Strings cannot fail to be written to.
            let _ = writeln!(out, "{:?} {:?} {unit:?} {}", channel.name, channel.x_cell, channel.cell);
        }
        self.signature = out;
    }
}
