//! What is odd about a bag: collected while it is read, told as findings.

use super::scan::{End, How};
use super::topic::{Origin, Topic};
use crate::error::shown;
use crate::finding::places::{Firsts, placeless};
use crate::finding::{Finding, FindingKind, SPANS_MAX, Severity};

/// Places named in a sentence.
const NAMED_MAX: usize = 3;

/// A chunk that was left out.
#[derive(Debug, Clone)]
pub(super) struct Broken {
    pub offset: u64,
    pub why: String,
    pub start_time: u64,
    pub end_time: u64,
    /// As the indexes behind it say; nothing where there are none.
    pub messages: Option<u64>,
}

/// What was odd about one file.
#[derive(Debug, Default)]
pub(super) struct Tell {
    broken: Vec<Broken>,
    /// Beyond those that are told one by one.
    more_broken: usize,
    /// Messages known to be lost with chunks.
    pub messages_lost: u64,
    records: Firsts,
    /// Records of kinds that the format may have later.
    unknown: Firsts,
    orphans: Firsts,
    conflicts: Firsts,
    /// Messages of a channel that was defined anew otherwise.
    pub after_conflict: usize,
    loose: u64,
    checksums: Vec<(Severity, String)>,
    counts: Vec<String>,
}

/// `1 message`, `2 messages`.
pub(super) fn messages(count: u64) -> String {
    if count == 1 { "1 message".to_owned() } else { format!("{count} messages") }
}

/// A time in the words of the columns, or as a date where there is no origin.
fn time(ns: u64, origin: Option<Origin>) -> String {
    match origin {
        Some(origin) => format!("{:.3} s", origin.since(ns)),
        None => Origin::of(ns).date(),
    }
}

impl Tell {
    pub fn broken(&mut self, broken: Broken) {
        self.messages_lost += broken.messages.unwrap_or(0);
        if self.broken.len() < SPANS_MAX {
            self.broken.push(broken);
        } else {
            self.more_broken += 1;
        }
    }

    pub fn bad_record(&mut self, offset: u64, what: impl FnOnce() -> String) {
        self.records.add(|| format!("byte {offset}: {}", what()));
    }

    pub fn unknown_record(&mut self, offset: u64, opcode: u8) {
        self.unknown.add(|| format!("byte {offset}: opcode {opcode:#04x}"));
    }

    pub fn orphan(&mut self, offset: u64, channel: u16) {
        self.orphans.add(|| format!("byte {offset}: channel {channel}"));
    }

    pub fn conflict(&mut self, offset: u64, what: impl FnOnce() -> String) {
        self.conflicts.add(|| format!("byte {offset}: {}", what()));
    }

    pub fn checksum(&mut self, severity: Severity, sentence: String) {
        self.checksums.push((severity, sentence));
    }

    /// Messages outside of chunks in a file that has chunks: no writer is known to do that, but a damaged index may look like one.
    pub fn loose(&mut self, messages: u64) {
        self.loose = messages;
    }

    pub fn count(&mut self, sentence: String) {
        self.counts.push(sentence);
    }

    /// Whether messages are known to be missing, so that no count can be right.
    pub fn is_lossy(&self) -> bool {
        !self.broken.is_empty() || self.records.count > 0 || self.orphans.count > 0
    }

    pub fn findings(self, file: &str, origin: Option<Origin>) -> Vec<Finding> {
        let mut findings = vec![];
        let mut tell = |kind, severity, count: usize, text: String| {
            findings.push(placeless(kind, severity, file, None, count, text));
        };
        let last = self.broken.len();
        for (index, broken) in self.broken.into_iter().enumerate() {
            let Broken { offset, why, start_time, end_time, messages: count } = broken;
            let held = match count {
                Some(count) => format!("its {} are lost", messages(count)),
                None => "how many messages it held is not known; they are lost".to_owned(),
            };
            let from_to = format!("{} to {}", time(start_time, origin), time(end_time, origin));
            let mut text = format!("the chunk at byte {offset} {why}: {held}, logged from {from_to}");
            if self.more_broken > 0 && index + 1 == last {
                text.extend(["; and ", &self.more_broken.to_string(), " more chunks like it"]);
            }
            tell(
                FindingKind::CrcMismatch,
                Severity::Lost,
                usize::try_from(count.unwrap_or(1)).unwrap_or(usize::MAX).max(1),
                text,
            );
        }
        for (severity, sentence) in self.checksums {
            tell(FindingKind::CrcMismatch, severity, 1, sentence);
        }
        if self.records.count > 0 {
            let text = format!("{} not what they should be ({})", are(self.records.count), self.records.listed());
            tell(FindingKind::BadRecord, Severity::Lost, self.records.count, text);
        }
        if self.unknown.count > 0 {
            let text = format!(
                "{} of a kind that the format does not have ({}); left out",
                are(self.unknown.count),
                self.unknown.listed()
            );
            tell(FindingKind::BadRecord, Severity::Note, self.unknown.count, text);
        }
        if self.loose > 0 {
            let text =
                format!("{} outside of the chunks, where no checksum covers it: is it one?", messages(self.loose));
            tell(FindingKind::BadRecord, Severity::Note, usize::try_from(self.loose).unwrap_or(usize::MAX), text);
        }
        if self.orphans.count > 0 {
            let count = messages(self.orphans.count as u64);
            let text = format!("{count} of channels that are not defined before ({}); lost", self.orphans.listed());
            tell(FindingKind::BadRecord, Severity::Lost, self.orphans.count, text);
        }
        if self.conflicts.count > 0 {
            let after = self.after_conflict;
            let (severity, what) = match after {
                0 => (Severity::Note, "the first definition holds; no message came after another".to_owned()),
                _ => (
                    Severity::Lost,
                    format!("{} after it cannot be told apart and are left out", messages(after as u64)),
                ),
            };
            let text = format!("defined again, and not alike ({}): {what}", self.conflicts.listed());
            tell(FindingKind::ConflictingDefinition, severity, after.max(self.conflicts.count), text);
        }
        for sentence in self.counts {
            tell(FindingKind::CountMismatch, Severity::Lost, 1, sentence);
        }
        findings
    }
}

fn are(count: usize) -> String {
    if count == 1 { "1 record is".to_owned() } else { format!("{count} records are") }
}

/// How the file ends, if not as it should.
pub(super) fn ending(
    file: &str,
    length: u64,
    end: End,
    data_ended: bool,
    last: Option<u64>,
    origin: Option<Origin>,
) -> Option<Finding> {
    let End { good, how } = end;
    let unread = length.saturating_sub(good);
    let last = match last {
        Some(ns) => format!("the last message that was read was logged at {}", time(ns, origin)),
        None => "no message was read".to_owned(),
    };
    let read = format!("it is read up to byte {good}, {unread} bytes behind that are not; {last}");
    let rest = if data_ended { "; the data section is whole" } else { "" };
    let (kind, severity, text) = match how {
        How::Whole => return None,
        How::Trailing => {
            let trailing = unread.saturating_sub(super::scan::MAGIC.len() as u64);
            let text = format!("{trailing} bytes follow the end of the file at byte {}; not read", length - trailing);
            (FindingKind::Trailer, Severity::Note, text)
        }
        How::NoFooter => {
            let text = format!("the file is cut, its footer is missing: {read}{rest}");
            (FindingKind::Truncated, Severity::Lost, text)
        }
        How::InRecord { opcode, length: stated } => {
            let name = super::record_name(opcode);
            let text =
                format!("the file ends within the {name} at byte {good}, which states {stated} bytes: {read}{rest}");
            (FindingKind::Truncated, Severity::Lost, text)
        }
        How::NoRecord => {
            let text = format!("no record begins at byte {good}, where one should: {read}{rest}");
            (FindingKind::Truncated, Severity::Lost, text)
        }
        How::NoMagic => {
            let text = format!("the closing magic at byte {good} is missing or damaged: {read}{rest}");
            (FindingKind::Truncated, Severity::Lost, text)
        }
    };
    Some(placeless(kind, severity, file, None, 1, text))
}

/// What is odd about the messages of a topic.
pub(super) fn topic(file: &str, topic: &Topic) -> Vec<Finding> {
    let mut findings = vec![];
    let name = shown(&topic.name);
    let rows = topic.columns.rows();
    let mut tell = |kind, severity, count, spans, text| {
        let (file, channel) = (file.to_owned(), Some(topic.name.clone()));
        findings.push(Finding { kind, severity, file, channel, spans, count, text });
    };
    if let Some(why) = topic.unreadable() {
        let text =
            format!("topic {name}: {why}; {} stay in the file, only their times are read", messages(rows as u64));
        tell(FindingKind::UnreadTopic, Severity::Note, rows, vec![], text);
    }
    if topic.bads.count() > 0 {
        let count = messages(topic.bads.count() as u64);
        let text = format!("topic {name}: {count} cannot be decoded {}; left as holes", topic.bads.listed());
        let spans = topic.bads.spans().to_vec();
        tell(FindingKind::UnreadMessage, Severity::Excluded, topic.bads.count(), spans, text);
    }
    if topic.trailing > 0 {
        let text = format!(
            "topic {name}: {} hold more bytes than their definition explains; is it another version of it?",
            messages(topic.trailing as u64)
        );
        tell(FindingKind::UnreadMessage, Severity::Note, topic.trailing, vec![], text);
    }
    let columns = &topic.columns;
    if !columns.cut.is_empty() {
        let fields: Vec<String> = columns
            .cut
            .iter()
            .take(NAMED_MAX)
            .map(|(field, elements)| match elements {
                0 => shown(field),
                elements => format!("{} with up to {elements} elements", shown(field)),
            })
            .collect();
        let more = columns.cut.len() - fields.len();
        let more = if more > 0 { format!("; and {more} more fields") } else { String::new() };
        let text = format!(
            "topic {name}: not all of {}{more} became columns: pictures, packets, or more than is shown",
            fields.join("; ")
        );
        tell(FindingKind::NotExpanded, Severity::Note, columns.cut.len(), vec![], text);
    }
    if columns.long_texts > 0 {
        let (count, max) = (columns.long_texts, crate::limits::TEXT_BYTES_MAX);
        let texts = if count == 1 { "text" } else { "texts" };
        let text = format!("topic {name}: {count} {texts} of more than {max} bytes left out");
        tell(FindingKind::NotExpanded, Severity::Note, count, vec![], text);
    }
    if columns.bad_texts > 0 {
        let count = columns.bad_texts;
        let texts = if count == 1 { "text is" } else { "texts are" };
        let text = format!("topic {name}: {count} {texts} not in UTF-8; what means nothing is shown as `\u{fffd}`");
        tell(FindingKind::Encoding, Severity::Note, count, vec![], text);
    }
    if columns.mixed > 0 {
        let count = columns.mixed;
        let text = format!(
            "topic {name}: {} text where the first one was a number, or the other way round; left as holes",
            if count == 1 { "1 value is".to_owned() } else { format!("{count} values are") }
        );
        tell(FindingKind::NonNumericCell, Severity::Excluded, count, vec![], text);
    }
    findings
}
