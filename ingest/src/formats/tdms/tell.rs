//! What is odd about a file, and the sentences that tell it.

use std::collections::BTreeSet;

use super::channel::Channel;
use crate::error::shown;
use crate::finding::places::{Firsts, placeless, zero_bytes};
use crate::finding::{Finding, FindingKind, Severity};
use crate::recording::full_name;

/// Channels named in a sentence.
const NAMED_MAX: usize = 3;

/// How the usable part of a file ends.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum Cut {
    /// Within the lead-in of a segment.
    InLead,
    /// Within the metadata of a segment.
    InMetadata { stated: u64, there: u64 },
    /// Within its values; `stated` is unknown where the writer did not come to say it.
    InData { stated: Option<u64>, there: u64 },
    /// Something else stands where a segment should begin.
    NoSegment,
    /// Nothing but zero bytes stand there.
    Zeros,
    /// The segment is not what it should be.
    Damaged(String),
}

/// What was odd.
#[derive(Debug, Default)]
pub(super) struct Tell {
    cut: Option<(u64, Cut)>,
    unexplained: Firsts,
    unexplained_bytes: u64,
    short_chunks: Firsts,
    versions: Vec<u32>,
    bad_texts: Vec<(String, usize)>,
    rescaled: BTreeSet<String>,
}

/// Whose scale it is.
#[derive(Debug, Clone, Copy)]
pub(super) enum Scaled<'a> {
    /// Group and name.
    Channel(&'a str, &'a str),
    Group(&'a str),
    File,
}

impl Tell {
    pub fn lost(&mut self, at: u64, cut: Cut) {
        self.cut = Some((at, cut));
    }

    /// Bytes of a segment that belong to no channel.
    pub fn unexplained(&mut self, at: u64, bytes: u64) {
        self.unexplained_bytes += bytes;
        self.unexplained.add(|| format!("the segment at byte {at}: {}", count(bytes, "byte", "bytes")));
    }

    /// A last chunk that is shorter than the others of a segment that is whole.
    pub fn short_chunk(&mut self, at: u64, there: u64, stated: u64) {
        self.short_chunks.add(|| format!("the segment at byte {at}: {there} of {stated} bytes"));
    }

    pub fn version(&mut self, version: u32) {
        if !self.versions.contains(&version) && self.versions.len() < NAMED_MAX {
            self.versions.push(version);
        }
    }

    /// Texts of a chunk whose lengths do not fit.
    pub fn bad_texts(&mut self, channel: &str, texts: usize) {
        match self.bad_texts.iter_mut().find(|(name, _)| name == channel) {
            Some((_, count)) => *count += texts,
            None => self.bad_texts.push((channel.to_owned(), texts)),
        }
    }

    /// A scale that was stated anew behind values.
    pub fn rescaled(&mut self, of: Scaled) {
        self.rescaled.insert(match of {
            Scaled::Channel(group, name) => format!("channel {}", shown(&full_name(group, name))),
            Scaled::Group(group) => format!("group {}", shown(group)),
            Scaled::File => "the file".to_owned(),
        });
    }

    /// Sentences that are no findings.
    pub fn reasons(&self) -> Vec<String> {
        let of =
            |version: &u32| format!("it says that it is of version {version} of the format, which is read as 4713");
        self.versions.iter().map(of).collect()
    }

    /// What is odd about the file; `shorter` names the channels that its end has made shorter than others, with the values that are
    /// there and those that the last chunk states.
    pub fn findings(self, file: &str, length: u64, shorter: &[(String, u64, u64)]) -> Vec<Finding> {
        let mut findings = Vec::new();
        let mut tell = |kind, severity, channel: Option<String>, count: usize, text| {
            findings.push(placeless(kind, severity, file, channel.as_deref(), count, text));
        };
        if let Some((at, cut)) = self.cut {
            let behind = length.saturating_sub(at);
            let kept = "what stands before it is read";
            let (kind, text) = match cut {
                Cut::InLead => {
                    let text = format!("the file ends within the lead-in of the segment at byte {at}: {kept}");
                    (FindingKind::Truncated, text)
                }
                Cut::InMetadata { stated, there } => {
                    let text = format!(
                        "the file ends within the metadata of the segment at byte {at}, {there} of {stated} bytes: {kept}"
                    );
                    (FindingKind::Truncated, text)
                }
                Cut::InData { stated, there } => (FindingKind::Truncated, in_data(at, stated, there, shorter)),
                Cut::Zeros => (FindingKind::Truncated, zero_bytes(behind)),
                Cut::NoSegment => {
                    let text = format!(
                        "no segment begins at byte {at}, where one should: {kept}, the {} behind it are not",
                        count(behind, "byte", "bytes")
                    );
                    (FindingKind::BadRecord, text)
                }
                Cut::Damaged(what) => {
                    let text = format!(
                        "the segment at byte {at} cannot be used, {what}: {kept}; the {behind} bytes from there on are not, for without it \
                         nobody knows when later values were taken"
                    );
                    (FindingKind::BadRecord, text)
                }
            };
            tell(kind, Severity::Lost, None, 1, text);
        }
        if self.unexplained.count > 0 {
            let bytes = count(self.unexplained_bytes, "byte", "bytes");
            let text = format!("{bytes} of raw data belong to no channel ({}); left out", self.unexplained.listed());
            tell(FindingKind::CountMismatch, Severity::Lost, None, self.unexplained.count, text);
        }
        if self.short_chunks.count > 0 {
            let chunks = count(self.short_chunks.count as u64, "last chunk is", "last chunks are");
            let text = format!(
                "{chunks} shorter than the metadata say though the segment is whole ({}): numbers side by side are shared out to all \
                 channels, rows and texts are taken as far as they go",
                self.short_chunks.listed()
            );
            tell(FindingKind::CountMismatch, Severity::Note, None, self.short_chunks.count, text);
        }
        if !self.rescaled.is_empty() {
            let first: Vec<&str> = self.rescaled.iter().take(NAMED_MAX).map(String::as_str).collect();
            let more = match self.rescaled.len().saturating_sub(NAMED_MAX) {
                0 => String::new(),
                more => format!(" and {more} more"),
            };
            let text = format!(
                "the scale of {}{more} is stated anew behind values: the last one is used for all of them, also for those before",
                first.join(", ")
            );
            tell(FindingKind::ConflictingDefinition, Severity::Note, None, self.rescaled.len(), text);
        }
        for (channel, texts) in self.bad_texts {
            let name = shown(&channel);
            let texts_are = if texts == 1 { "text does" } else { "texts do" };
            let text = format!("channel {name}: {texts} {texts_are} not end where the file says; left empty");
            tell(FindingKind::BadRecord, Severity::Lost, Some(channel), texts, text);
        }
        findings
    }
}

fn in_data(at: u64, stated: Option<u64>, there: u64, shorter: &[(String, u64, u64)]) -> String {
    let begin = match stated {
        Some(stated) => {
            format!(
                "the file ends within the values of the segment at byte {at}, {there} of {stated} bytes: whole values are kept"
            )
        }
        None => format!(
            "the last segment, at byte {at}, was never closed, as when the program that wrote it stops: the {there} bytes of values that \
             are there are kept, and how many were meant is not known"
        ),
    };
    let named = |(name, values, stated): &(String, u64, u64)| {
        format!("{} has {values} values of the {stated} that its last chunk states", shown(name))
    };
    let first: Vec<String> = shorter.iter().take(NAMED_MAX).map(named).collect();
    match shorter.len() {
        0 => begin,
        many if many > NAMED_MAX => format!("{begin}; {}; and {} more", first.join("; "), many - NAMED_MAX),
        _ => format!("{begin}; {}", first.join("; ")),
    }
}

/// `1 byte`, `2 bytes`.
fn count(count: u64, one: &str, many: &str) -> String {
    if count == 1 { format!("1 {one}") } else { format!("{count} {many}") }
}

/// Names in a sentence: `` `a`, `b`, `c` and 4 more ``.
fn listed(names: &[String]) -> String {
    let first: Vec<String> = names.iter().take(NAMED_MAX).map(|name| shown(name)).collect();
    match names.len().saturating_sub(NAMED_MAX) {
        0 => first.join(", "),
        more => format!("{} and {more} more", first.join(", ")),
    }
}

/// A finding about channels.
fn of(file: &str, kind: FindingKind, severity: Severity, names: &[String], text: String) -> Finding {
    let channel = if let [one] = names { Some(one.as_str()) } else { None };
    placeless(kind, severity, file, channel, names.len(), text)
}

/// Columns of time without a date in a file whose other stamps count from `origin`.
pub(super) fn undated(file: &str, names: &[String], origin: &str) -> Option<Finding> {
    let (columns, they) = match names {
        [] => return None,
        [_] => ("column", "it counts from a beginning of its own"),
        _ => ("columns", "each counts from a beginning of its own"),
    };
    let text = format!(
        "{columns} {}: no date is stated for these times; {they}, and not from {origin} as others of the file do",
        listed(names)
    );
    Some(of(file, FindingKind::NoDate, Severity::Note, names, text))
}

/// What is told of a time axis that the waveforms state anew at samples.
pub(super) fn changes(file: &str, column: &str, samples: &[u64]) -> Option<Finding> {
    let first: Vec<String> = samples.iter().take(NAMED_MAX).map(u64::to_string).collect();
    let more = if samples.len() > NAMED_MAX { ", ..." } else { "" };
    let text = format!(
        "column {}: the waveforms state another beginning or step at {} (sample {}{more}): the times follow it",
        shown(column),
        count(samples.len() as u64, "place", "places"),
        first.join(", ")
    );
    let finding =
        placeless(FindingKind::ConflictingDefinition, Severity::Note, file, Some(column), samples.len(), text);
    (!samples.is_empty()).then_some(finding)
}

/// What is odd about the values of channels.
pub(super) fn channels(file: &str, channels: &[Channel]) -> Vec<Finding> {
    let name = |channel: &Channel| full_name(&channel.group, &channel.name);
    // Sixty-four thermocouples are one finding.
    let mut refused: Vec<(&str, Vec<String>, u64)> = Vec::new();
    for channel in channels {
        let Some(why) = channel.refused() else { continue };
        match refused.iter_mut().find(|(known, ..)| *known == why) {
            Some((_, names, values)) => {
                names.push(name(channel));
                *values = (*values).max(channel.values);
            }
            None => refused.push((why, vec![name(channel)], channel.values)),
        }
    }
    let unscaled: Vec<String> = channels.iter().filter(|channel| channel.is_unscaled()).map(name).collect();
    let mut findings = Vec::new();
    for (why, names, values) in refused {
        let channels = if names.len() == 1 { "channel" } else { "channels" };
        let its = if names.len() == 1 { "its" } else { "their" };
        let text = format!(
            "{channels} {}: {why}; {its} {values} values are left out, for raw numbers would look like measured ones",
            listed(&names)
        );
        findings.push(of(file, FindingKind::UnsupportedScaling, Severity::Lost, &names, text));
    }
    for (channel, beyond) in channels.iter().filter_map(|channel| Some((channel, channel.beyond()?))) {
        let name = name(channel);
        let values = beyond.counted("value is", "values are");
        let text = format!(
            "channel {}: {values} outside of what the equations of its scale hold for {}; left as holes",
            shown(&name),
            beyond.listed()
        );
        findings.push(beyond.clone().finding(FindingKind::OutOfRange, Severity::Excluded, file, Some(&name), text));
    }
    if !unscaled.is_empty() {
        let (channels, hold) = if unscaled.len() == 1 { ("channel", "holds") } else { ("channels", "hold") };
        let text = format!(
            "{channels} {} {hold} counts of a DAQ card, and the file states no scale for them",
            listed(&unscaled)
        );
        findings.push(of(file, FindingKind::Unscaled, Severity::Note, &unscaled, text));
    }
    findings
}
