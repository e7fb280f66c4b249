//! From channels to tables: those of a group that have as many values at the same times share one.

use std::collections::{HashMap, HashSet};

use super::channel::Channel;
use super::objects::Objects;
use super::reading::{Pass, unique};
use super::timing::Axes;
use super::unusable;
use super::value::{Properties, Timestamp};
use crate::IngestError;
use crate::error::shown;
use crate::finding::places::placeless;
use crate::finding::{Finding, FindingKind, LineMap, Severity};
use crate::formats::csv::Decimal;
use crate::raw::RawFile;
use crate::recording::{Builder, ClockUnit, Column, Keep, Recording, Table, full_name};

use super::tell;

/// Lines of metadata that are kept, and characters of each.
const METADATA_LINES_MAX: usize = 10_000;
const METADATA_CHARACTERS_MAX: usize = 400;

/// Tables whose time axis is explained, and changes of an axis that are listed.
const TOLD_MAX: usize = 20;

/// The column of the times that a waveform states.
const TIME: &str = "time";

/// Channels that share their times.
struct Group {
    name: String,
    stated: u64,
    axes: Axes,
    channels: Vec<Channel>,
}

/// What was read, as a recording.
pub(super) fn recording(raw: &RawFile, pass: Pass, keep: Keep) -> Result<Recording, IngestError> {
    let Pass { objects, channels, origin, tell, is_index, segments, is_scaled_late } = pass;
    if is_index {
        return Err(index(raw, &channels));
    }
    if let Some(channel) = channels.iter().find(|channel| channel.is_asked && channel.refused().is_some()) {
        return Err(refused(raw, channel));
    }
    if !channels.is_empty() && channels.iter().all(|channel| channel.refused().is_some()) {
        // The first of them stands for all.
        return Err(channels.first().map_or_else(|| no_channel(raw), |channel| refused(raw, channel)));
    }
    if channels.is_empty() {
        return Err(no_channel(raw));
    }
    let file = raw.name();
    let mut findings = tell::channels(file, &channels);
    let mut reasons = tell.reasons();
    if is_scaled_late {
        reasons.push("a scale is stated behind values that it belongs to; it holds for all of them".to_owned());
    }
    let shorter: Vec<(String, u64, u64)> = channels
        .iter()
        .filter(|channel| channel.values < channel.stated && channel.refused().is_none())
        .map(|channel| (full_name(&channel.group, &channel.name), channel.values, channel.stated))
        .collect();
    findings.extend(tell.findings(file, raw.len(), &shorter));
    reasons.insert(0, format!("it begins with `TDSm`; segments: {segments}"));

    let mut names: HashMap<String, HashSet<String>> = HashMap::new();
    for channel in &channels {
        names.entry(channel.group.clone()).or_default().insert(channel.name.clone());
    }
    let mut making = Making { file, objects: &objects, origin, keep, names, reasons, findings, undated: Vec::new() };
    let tables = groups(channels).into_iter().map(|group| making.table(group)).collect();
    let Making { reasons, mut findings, undated, .. } = making;
    let origin = origin.map(|seconds| Timestamp { seconds, fraction: 0 }.second());
    findings.extend(origin.as_ref().and_then(|origin| tell::undated(file, &undated, origin)));
    Ok(Recording {
        format: "TDMS",
        tables,
        findings,
        reasons,
        metadata: metadata(&objects),
        origin,
        photographs: vec![],
    })
}

/// Channels by their times. Channels that state none join those of their group that are as many, if there is one such table.
fn groups(channels: Vec<Channel>) -> Vec<Group> {
    let mut groups: Vec<Group> = Vec::new();
    let mut by_group: HashMap<String, Vec<usize>> = HashMap::new();
    let mut without = Vec::new();
    for channel in channels {
        let stated = channel.stated.max(channel.values);
        let axes = channel.timings.clone().finish(channel.values);
        if axes.is_none() {
            without.push((channel, stated, axes));
            continue;
        }
        put(&mut groups, &mut by_group, channel, stated, axes, |group, axes| group.axes.is_alike(axes));
    }
    for (channel, stated, axes) in without {
        let alike = |at: &&usize| groups.get(**at).is_some_and(|group| group.stated == stated && !group.axes.is_none());
        let timed = by_group.get(&channel.group).map_or(0, |known| known.iter().filter(alike).count());
        put(&mut groups, &mut by_group, channel, stated, axes, |group, _| timed == 1 || group.axes.is_none());
    }
    for group in &mut groups {
        group.channels.sort_by_key(|channel| channel.object);
    }
    groups.sort_by_key(|group| group.channels.first().map(|channel| channel.object));
    groups
}

fn put(
    groups: &mut Vec<Group>,
    by_group: &mut HashMap<String, Vec<usize>>,
    channel: Channel,
    stated: u64,
    axes: Axes,
    is_alike: impl Fn(&Group, &Axes) -> bool,
) {
    let known = by_group.entry(channel.group.clone()).or_default();
    let fits = |at: &&usize| groups.get(**at).is_some_and(|group| group.stated == stated && is_alike(group, &axes));
    let found = known.iter().find(fits).copied();
    if let Some(group) = found.and_then(|at| groups.get_mut(at)) {
        group.channels.push(channel);
    } else {
        known.push(groups.len());
        groups.push(Group { name: channel.group.clone(), stated, axes, channels: vec![channel] });
    }
}

/// Tables in the making.
struct Making<'a> {
    file: &'a str,
    objects: &'a Objects,
    origin: Option<i64>,
    keep: Keep<'a>,
    /// Names of columns by group.
    names: HashMap<String, HashSet<String>>,
    reasons: Vec<String>,
    findings: Vec<Finding>,
    /// Clocks without a date.
    undated: Vec<String>,
}

impl Making<'_> {
    fn table(&mut self, group: Group) -> Table {
        let time = self.time(&group);
        let Group { name, axes, channels, .. } = group;
        let rows = rows(&channels);
        let mut clock = axes.first().filter(|first| first.other.is_none()).map(|_| 0);
        // Where no waveform says the times, a channel of instants does, if there is one only.
        let is_stamped = clock.is_none() && channels.iter().filter(|channel| channel.is_instants()).count() == 1;
        let mut columns: Vec<Column> = time.into_iter().collect();
        let taken = self.names.entry(name.clone()).or_default();
        for channel in channels {
            let object = self.objects.get(channel.object);
            let is_wide = channel.is_wide();
            if is_stamped && channel.is_instants() {
                clock = Some(columns.len());
            }
            let own = channel.finish(rows, object, &mut |name| unique(taken, name));
            let wide = own.iter().filter(|_| is_wide);
            self.findings.extend(wide.filter_map(|column| rounded(self.file, &name, column)));
            columns.extend(own);
        }
        Table { name, schema: None, columns, rows, lines: LineMap::default(), clock, decimal: Decimal::Point }
    }

    /// The column of the time axis, and what is to be said of it.
    fn time(&mut self, group: &Group) -> Option<Column> {
        let Group { name, axes, channels, .. } = group;
        let first = axes.first()?;
        let is_time = first.other.is_none();
        let (column, unit) =
            first.other.as_ref().map_or((TIME, Some("s")), |(name, unit)| (name.as_str(), unit.as_deref()));
        let column = unique(self.names.entry(name.clone()).or_default(), column);
        let full = full_name(name, &column);
        if self.reasons.len() < TOLD_MAX {
            let step = crate::watch::rounded(first.increment.unwrap_or(0.0));
            let unit = unit.map_or_else(String::new, |unit| format!(" {unit}"));
            let start = first.start.filter(|_| is_time);
            let start = start.map_or_else(String::new, |start| format!(" from {}", start.rounded()));
            let reason = format!("column {}: steps of {step}{unit}{start}, as the waveforms state", shown(&full));
            self.reasons.push(reason);
        }
        if self.origin.is_some() && is_time && first.start.is_none() {
            self.undated.push(full.clone());
        }
        self.findings.extend(tell::changes(self.file, &full, &axes.changes().collect::<Vec<_>>()));
        let mut builder = times(axes, rows(channels), self.origin, self.keep.wants(name), is_time);
        if is_time && first.start.is_some() {
            builder.date();
        }
        Some(builder.finish(column, unit.map(str::to_owned)))
    }
}

/// As many rows as the longest channel has values, which were counted while they were read.
fn rows(channels: &[Channel]) -> usize {
    let values = channels.iter().map(|channel| channel.values).max().unwrap_or(0);
    usize::try_from(values).unwrap_or(usize::MAX)
}

/// What is told of integers that a double cannot hold.
fn rounded(file: &str, table: &str, column: &Column) -> Option<Finding> {
    /// Every integer up to here is a double.
    const EXACT: f64 = (1_u64 << 53) as f64;
    let (min, max) = column.summary.range.filter(|(min, max)| *min < -EXACT || *max > EXACT)?;
    let full = full_name(table, &column.name);
    let text = format!(
        "column {}: integers from {min} to {max}; beyond 2^53 not all of them are doubles, and the nearest stand for them",
        shown(&full)
    );
    let count = column.summary.samples - column.summary.holes;
    Some(placeless(FindingKind::Rounded, Severity::Note, file, Some(&full), count, text))
}

/// The times of all samples.
// Samples beyond 2^53 are more than any file holds.
#[allow(clippy::cast_precision_loss)]
fn times(axes: &Axes, rows: usize, origin: Option<i64>, is_kept: bool, is_time: bool) -> Builder {
    // What is kept can be looked at later.
    let is_watched = is_time && !is_kept;
    let mut times = if is_watched { Builder::clock(false, ClockUnit::Seconds(1.0)) } else { Builder::new(is_kept) };
    times.reserve(rows);
    for (count, begin, step) in axes.runs(rows as u64, origin) {
        let mut at = 0;
        while at < count {
            let end = count.min(at + 1024);
            times.extend((at..end).map(|i| begin + i as f64 * step));
            at = end;
        }
    }
    times
}

/// Properties of the file, its groups and its channels as lines.
fn metadata(objects: &Objects) -> Vec<String> {
    let mut lines = Vec::new();
    let mut add = |prefix: &str, properties: &Properties| {
        for (name, value) in properties {
            if lines.len() >= METADATA_LINES_MAX {
                return;
            }
            let line = format!("{prefix}{name}: {value}");
            lines.push(line.chars().take(METADATA_CHARACTERS_MAX).collect());
        }
    };
    for object in objects.iter() {
        match (&object.group, &object.channel) {
            (None, _) => add("", &object.properties),
            (Some(group), None) => add(&format!("{group}: "), &object.properties),
            (Some(group), Some(channel)) => add(&format!("{}: ", full_name(group, channel)), &object.properties),
        }
    }
    lines
}

fn refused(raw: &RawFile, channel: &Channel) -> IngestError {
    let name = shown(&full_name(&channel.group, &channel.name));
    let why = channel.refused().unwrap_or_default();
    let next = "let the program that measured write scaled values, or export the channel as text";
    unusable(raw, "channels whose scale is known", format!("channel {name}: {why}"), next)
}

/// An index says what stands in the file beside it.
fn index(raw: &RawFile, channels: &[Channel]) -> IngestError {
    let values = channels.iter().fold(0_u64, |sum, channel| sum.saturating_add(channel.stated));
    let found = format!(
        "the index of one, which names {} channels with {values} values and holds none of them",
        channels.len()
    );
    let beside = raw.name().strip_suffix("_index");
    let next =
        beside.map_or_else(|| "read the .tdms file beside it".to_owned(), |name| format!("read {name} beside it"));
    unusable(raw, "a TDMS file", found, &next)
}

fn no_channel(raw: &RawFile) -> IngestError {
    unusable(raw, "channels", "none".to_owned(), "is this the file you meant?")
}
