//! The tables of segments whose channels are alike, while they grow: channels that share every stamp share a table.

use std::collections::HashMap;

use super::layout::Layout;
use crate::finding::places::{ByKind, cell_finding};
use crate::finding::{Finding, FindingKind, LineMap};
use crate::formats::csv::{CellKind, Decimal};
use crate::recording::{Builder, Cells, ClockUnit, Column, Keep, Table};

/// Where the stamps of a channel come from.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Axis {
    /// A cell of the row, in units of `unit_s`, and what is added to it.
    Cell { cell: usize, unit_s: f64, offset_s: f64 },
    /// The number of the row.
    Steps { first: f64, step: f64, unit_s: f64, offset_s: f64 },
}

impl Axis {
    #[inline]
    fn stamp(self, values: &[f64], at: usize) -> f64 {
        match self {
            Self::Cell { cell, unit_s, offset_s } => values.get(cell).copied().unwrap_or(f64::NAN) * unit_s + offset_s,
            Self::Steps { first, step, unit_s, offset_s } => (first + at as f64 * step) * unit_s + offset_s,
        }
    }

    fn cell(self) -> Option<usize> {
        if let Self::Cell { cell, .. } = self { Some(cell) } else { None }
    }

    /// What two channels of one table have in common for a whole segment, as a key.
    fn key(self) -> (bool, [u64; 4]) {
        match self {
            Self::Cell { unit_s, offset_s, .. } => (true, [0, 0, unit_s.to_bits(), offset_s.to_bits()]),
            Self::Steps { first, step, unit_s, offset_s } => (false, [first, step, unit_s, offset_s].map(f64::to_bits)),
        }
    }
}

/// A row.
#[derive(Clone, Copy)]
pub(super) struct Row<'r> {
    /// The numbers of its cells; NaN is a hole.
    pub values: &'r [f64],
    /// What the cells are and what stands in them, unless all are numbers.
    pub careful: Option<(&'r [CellKind], &'r [&'r [u8]])>,
    /// Its number in the segment, from 0.
    pub at: usize,
    pub line: usize,
    pub comment: &'r str,
    /// The cell from which on the end of the file may have taken something: what is missing there says nothing of the clock of a channel.
    pub cut: Option<usize>,
}

impl Row<'_> {
    fn is_empty(&self, cell: usize) -> bool {
        self.careful.is_some_and(|(kinds, _)| matches!(kinds.get(cell), None | Some(CellKind::Empty)))
    }

    /// Tells a cell that holds no number; the sample is `row`.
    fn tell(&self, cell: usize, row: usize, odd: &mut ByKind) {
        let Some((kinds, cells)) = self.careful else { return };
        let kind = match kinds.get(cell).copied().unwrap_or(CellKind::Empty) {
            CellKind::Number(_) => return,
            CellKind::Empty => FindingKind::EmptyCell,
            CellKind::Hole => FindingKind::NoValue,
            CellKind::Text => FindingKind::NonNumericCell,
        };
        odd.entry(kind).or_default().add(row, self.line, cells.get(cell).copied().unwrap_or_default());
    }
}

/// A channel on its way into a column.
struct Member {
    channel: usize,
    name: String,
    unit: Option<String>,
    cell: usize,
    axis: Axis,
    numbers: Builder,
    odd: ByKind,
    /// Rows in a row, up to the last one, that hold nothing for it.
    tail: usize,
}

/// Channels that share every stamp so far.
struct Group {
    members: Vec<Member>,
    /// Whether their X stands in cells of their own, which may come to differ.
    is_several: bool,
    name: String,
    x: Builder,
    odd: ByKind,
    lines: LineMap,
    /// Rows that hold neither X nor a value: no rows, unless others follow.
    pending: LineMap,
    pending_at: usize,
    /// Samples before this segment.
    before: usize,
    /// First and last sample of this segment with a stamp, and the stamps.
    first: Option<(usize, f64)>,
    last: (usize, f64),
}

/// Names that are given once.
#[derive(Default)]
pub(super) struct Names {
    taken: HashMap<String, usize>,
}

impl Names {
    /// The name, or it with a number behind it that nothing else has.
    pub fn unique(&mut self, base: &str) -> String {
        let mut name = base.to_owned();
        // Counted on from where the last of that name stopped: thousands of equal names must not take minutes.
        let mut copy = self.taken.get(base).copied().unwrap_or(1);
        while self.taken.contains_key(&name) {
            copy += 1;
            name = format!("{base} ({copy})");
        }
        self.taken.insert(base.to_owned(), copy);
        self.taken.entry(name.clone()).or_insert(1);
        name
    }
}

/// What is said behind the channels.
struct Comments {
    name: String,
    words: Vec<String>,
    keep: bool,
}

/// What a segment that has ended held of a channel.
pub(super) struct Held<'b> {
    pub channel: usize,
    pub name: &'b str,
    pub rows: usize,
    /// The mean step of its stamps in s and how many steps there are, where they stand in the file.
    pub mean_step: Option<(f64, usize)>,
    /// Rows at the end that hold nothing for it.
    pub dropped: usize,
    /// Whether it is the first of its table.
    pub is_first: bool,
}

/// The tables of segments whose channels are alike.
pub(super) struct Block<'a> {
    pub layout: Layout,
    keep: Keep<'a>,
    groups: Vec<Group>,
    comments: Option<Comments>,
    has_tail: bool,
    expected_rows: usize,
    /// The line of the segment's names.
    pub line: usize,
}

impl<'a> Block<'a> {
    /// Tables without rows.
    pub fn new(layout: Layout, axes: &[Axis], keep: Keep<'a>, names: &mut Names) -> Self {
        let x_name = names.unique("X_Value");
        // The stamps are kept with whatever they are the clock of.
        let keep_x = keep.wants("");
        let x = if layout.is_time { Builder::clock(keep_x, ClockUnit::Seconds(1.0)) } else { Builder::new(keep_x) };
        let member = |(index, channel): (usize, &super::layout::Channel)| {
            let name = names.unique(&channel.name);
            // A column by number is further to the left once others have a table of their own.
            let is_kept = keep.keeps("", &name, index + 2)
                || matches!(keep, Keep::Only(_)) && (1..index + 2).any(|number| keep.keeps("", &name, number));
            let axis =
                axes.get(index).copied().unwrap_or(Axis::Steps { first: 0.0, step: 1.0, unit_s: 1.0, offset_s: 0.0 });
            Member {
                channel: index,
                name,
                unit: channel.unit.clone(),
                cell: channel.cell,
                axis,
                numbers: Builder::new(is_kept),
                odd: ByKind::new(),
                tail: 0,
            }
        };
        let members = layout.channels.iter().enumerate().map(member).collect();
        let group = Group {
            members,
            is_several: false,
            name: x_name,
            x,
            odd: ByKind::new(),
            lines: LineMap::default(),
            pending: LineMap::default(),
            pending_at: 0,
            before: 0,
            first: None,
            last: (0, 0.0),
        };
        Self { layout, keep, groups: vec![group], comments: None, has_tail: false, expected_rows: 0, line: 0 }
    }

    /// Begins a segment: where stamps now come from, channel by channel.
    pub fn begin(&mut self, axes: &[Axis], line: usize, names: &mut Names) {
        self.line = line;
        for group in &mut self.groups {
            for member in &mut group.members {
                if let Some(axis) = axes.get(member.channel) {
                    member.axis = *axis;
                }
                member.tail = 0;
            }
        }
        for index in 0..self.groups.len() {
            self.split(index, |member| member.axis.key(), names);
        }
        for group in &mut self.groups {
            let first = group.members.first().and_then(|member| member.axis.cell());
            group.is_several = group.members.iter().any(|member| member.axis.cell() != first);
            group.before = group.lines.rows();
            group.first = None;
        }
        self.has_tail = false;
    }

    /// Gives members whose key is not that of the first a table of their own, together with others of the same key.
    fn split<K: std::hash::Hash + Eq>(&mut self, index: usize, key: impl Fn(&Member) -> K, names: &mut Names) {
        let Some(group) = self.groups.get_mut(index) else { return };
        let Some(first) = group.members.first().map(&key) else { return };
        if group.members.iter().all(|member| key(member) == first) {
            return;
        }
        let (stay, leave) = std::mem::take(&mut group.members).into_iter().partition(|member| key(member) == first);
        group.members = stay;
        let mut of_key: HashMap<K, usize> = HashMap::new();
        let mut new: Vec<Group> = Vec::new();
        for member in Vec::from_iter::<Vec<Member>>(leave) {
            let at = *of_key.entry(key(&member)).or_insert(new.len());
            if at == new.len() {
                let mut x = group.x.clone();
                x.reserve(self.expected_rows.saturating_sub(x.len()));
                new.push(Group {
                    members: Vec::new(),
                    is_several: group.is_several,
                    name: names.unique("X_Value"),
                    x,
                    odd: group.odd.clone(),
                    lines: group.lines.clone(),
                    pending: group.pending.clone(),
                    ..*group
                });
            }
            if let Some(group) = new.get_mut(at) {
                group.members.push(member);
            }
        }
        self.groups.append(&mut new);
    }

    /// Adds a row.
    #[inline]
    pub fn push(&mut self, row: Row, names: &mut Names) {
        for index in 0..self.groups.len() {
            let Some(group) = self.groups.get(index).filter(|group| group.is_several && !group.is_one(row.values))
            else {
                continue;
            };
            let bits = |axis: Axis| {
                let value = axis.cell().and_then(|cell| row.values.get(cell));
                value.copied().unwrap_or(f64::NAN).to_bits()
            };
            let first = group.members.first().map_or(0, |member| bits(member.axis));
            let is_missing = |axis: Axis| {
                axis.cell().is_some_and(|cell| row.cut.is_some_and(|cut| cell >= cut) && row.is_empty(cell))
            };
            let key = |member: &Member| if is_missing(member.axis) { first } else { bits(member.axis) };
            self.split(index, key, names);
        }
        if row.careful.is_some() || self.has_tail {
            self.careful(row, names);
            return;
        }
        for group in &mut self.groups {
            group.push(row);
        }
    }

    #[cold]
    fn careful(&mut self, row: Row, names: &mut Names) {
        self.has_tail = row.careful.is_some();
        for (index, group) in self.groups.iter_mut().enumerate() {
            for member in &mut group.members {
                member.tail = if row.is_empty(member.cell) { member.tail + 1 } else { 0 };
            }
            if row.careful.is_some() && group.is_blank(row) && (index > 0 || row.comment.is_empty()) {
                if group.pending.rows() == 0 {
                    group.pending_at = row.at;
                }
                group.pending.push(row.line);
                continue;
            }
            if index == 0 {
                let rows = group.lines.rows() + group.pending.rows();
                Comments::add(&mut self.comments, row.comment, rows, || {
                    let name = names.unique(super::COMMENT);
                    let keep = self.keep.keeps("", &name, group.members.len() + 2);
                    (name, keep)
                });
            }
            group.flush();
            let at = group.lines.rows();
            if let Some(cell) = group.members.first().and_then(|member| member.axis.cell()) {
                row.tell(cell, at, &mut group.odd);
            }
            for member in &mut group.members {
                row.tell(member.cell, at, &mut member.odd);
            }
            group.push(row);
        }
    }

    /// Ends the segment: what it held, channel by channel.
    pub fn end(&mut self) -> Vec<Held<'_>> {
        let mut held = Vec::new();
        for group in &mut self.groups {
            let dropped = std::mem::take(&mut group.pending).rows();
            let rows = group.lines.rows() - group.before;
            let steps = group.first.map(|(row, _)| group.last.0.saturating_sub(row)).filter(|steps| *steps > 0);
            let mean = group.first.zip(steps).map(|((_, first), steps)| ((group.last.1 - first) / steps as f64, steps));
            for (index, member) in group.members.iter().enumerate() {
                held.push(Held {
                    channel: member.channel,
                    name: &member.name,
                    rows: (rows + dropped).saturating_sub(member.tail.max(dropped)),
                    mean_step: mean.filter(|_| member.axis.cell().is_some()),
                    dropped,
                    is_first: index == 0,
                });
            }
        }
        held
    }

    /// Asks for the memory of so many more rows.
    pub fn reserve(&mut self, rows: usize) {
        let most = self.groups.iter().map(|group| group.lines.rows()).max().unwrap_or(0);
        self.expected_rows = most.saturating_add(rows);
        for group in &mut self.groups {
            group.x.reserve(rows);
            for member in &mut group.members {
                member.numbers.reserve(rows);
            }
        }
    }

    /// Columns of numbers.
    pub fn columns(&self) -> usize {
        self.groups.iter().map(|group| 1 + group.members.len()).sum()
    }

    /// Cells so far; a word counts as three.
    pub fn cells(&self) -> usize {
        let numbers: usize = self.groups.iter().map(|group| group.lines.rows() * (1 + group.members.len())).sum();
        numbers + 3 * self.comments.as_ref().map_or(0, |comments| comments.words.len())
    }

    /// Samples of the first table.
    pub fn rows(&self) -> usize {
        self.groups.first().map_or(0, |group| group.lines.rows() + group.pending.rows())
    }

    /// The tables, and what is odd about their cells.
    pub fn finish(self, file: &str, decimal: Decimal, tables: &mut Vec<Table>, findings: &mut Vec<Finding>) {
        let Self { layout, mut groups, mut comments, .. } = self;
        groups.sort_by_key(|group| group.members.first().map(|member| member.channel));
        for group in groups {
            let rows = group.lines.rows();
            findings.extend(group.odd.into_iter().map(|(kind, places)| cell_finding(kind, places, file, &group.name)));
            let unit = layout.is_time.then(|| "s".to_owned());
            let mut columns = vec![group.x.finish(group.name, unit)];
            for Member { name, unit, numbers, odd, .. } in group.members {
                findings.extend(odd.into_iter().map(|(kind, places)| cell_finding(kind, places, file, &name)));
                columns.push(numbers.finish(name, unit));
            }
            // The first table holds them.
            if let Some(Comments { name, mut words, keep }) = comments.take() {
                words.resize(if keep { rows } else { 0 }, String::new());
                let cells = if keep { Cells::Text(words) } else { Cells::NotKept };
                columns.push(Column::new(&name, None, cells));
            }
            let clock = layout.is_time.then_some(0);
            tables.push(Table { name: String::new(), schema: None, columns, rows, lines: group.lines, clock, decimal });
        }
    }
}

impl Comments {
    /// Adds what stands behind row `row`; rows before it that had nothing get empty words.
    fn add(comments: &mut Option<Self>, words: &str, row: usize, name: impl FnOnce() -> (String, bool)) {
        if words.is_empty() {
            return;
        }
        let comments = comments.get_or_insert_with(|| {
            let (name, keep) = name();
            Self { name, words: Vec::new(), keep }
        });
        if comments.keep {
            comments.words.resize(row, String::new());
            comments.words.push(words.to_owned());
        }
    }
}

impl Group {
    /// Whether the X of all members is the same in this row.
    fn is_one(&self, values: &[f64]) -> bool {
        let bits = |member: &Member| member.axis.cell().and_then(|cell| values.get(cell)).map(|value| value.to_bits());
        let mut members = self.members.iter().map(bits);
        let first = members.next();
        members.all(|bits| Some(bits) == first)
    }

    fn is_blank(&self, row: Row) -> bool {
        let mut cells = self.members.iter().flat_map(|member| [Some(member.cell), member.axis.cell()]).flatten();
        cells.all(|cell| row.is_empty(cell))
    }

    #[inline]
    fn push(&mut self, row: Row) {
        if self.pending.rows() > 0 {
            self.flush();
        }
        let stamp = self.members.first().map_or(f64::NAN, |member| member.axis.stamp(row.values, row.at));
        if stamp.is_finite() {
            self.last = (self.lines.rows(), stamp);
            if self.first.is_none() {
                self.first = Some(self.last);
            }
        }
        self.x.push(stamp);
        for member in &mut self.members {
            member.numbers.push(row.values.get(member.cell).copied().unwrap_or(f64::NAN));
        }
        self.lines.push(row.line);
    }

    /// Rows of holes that others follow: they keep their place.
    fn flush(&mut self) {
        let pending = std::mem::take(&mut self.pending);
        let Some(axis) = self.members.first().map(|member| member.axis) else { return };
        for i in 0..pending.rows() {
            let (line, row) = (pending.line_of(i), self.lines.rows());
            if axis.cell().is_some() {
                self.odd.entry(FindingKind::EmptyCell).or_default().add(row, line, &[]);
            }
            self.x.push(axis.stamp(&[], self.pending_at + i));
            for member in &mut self.members {
                member.odd.entry(FindingKind::EmptyCell).or_default().add(row, line, &[]);
                member.numbers.push(f64::NAN);
            }
            self.lines.push(line);
        }
    }
}
