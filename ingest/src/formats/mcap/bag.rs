//! What the records of a file add up to: channels, rows, and what is odd.

use std::collections::HashMap;
use std::rc::Rc;

use ::mcap::records::{Record, Statistics, op};

use super::chunk::{Inflate, Overrun, Records};
use super::columns::Budget;
use super::fields;
use super::scan::{End, Framed, Scan, Seen, Step};
use super::tell::{self, Broken, Tell};
use super::topic::{Origin, Schema, Topic};
use crate::IngestError;
use crate::error::{Place, shown};
use crate::finding::{Finding, LineMap, Severity};
use crate::formats::csv::Decimal;
use crate::limits::LOG_COLUMNS_MAX;
use crate::raw::RawFile;
use crate::recording::{Cells, Keep, Recording, Table};

/// Lines of metadata that are kept, and characters of each.
const METADATA_LINES_MAX: usize = 200;
const METADATA_CHARACTERS_MAX: usize = 400;

/// A channel of the file at hand.
#[derive(Debug)]
struct Channel {
    definition: ::mcap::records::Channel,
    /// Its topic, once a schema it names could have come.
    topic: usize,
    messages: u64,
    /// Defined again otherwise: its messages cannot be told apart any more.
    conflict: bool,
}

/// What is read from one or more files.
pub(super) struct Bag<'k> {
    keep: Keep<'k>,
    topics: Vec<Topic>,
    by_name: HashMap<String, Vec<usize>>,
    budget: Budget,
    pub origin: Option<Origin>,
    last_time: Option<u64>,
    pub findings: Vec<Finding>,
    pub reasons: Vec<String>,
    pub metadata: Vec<String>,
    file: Part,
}

/// What is known of the file at hand; ids begin anew in each.
#[derive(Default)]
struct Part {
    name: String,
    schemas: HashMap<u16, Rc<Schema>>,
    channels: Vec<Option<Channel>>,
    tell: Tell,
    statistics: Option<Statistics>,
    data_ended: bool,
    /// The last chunk, if it is broken: the indexes behind it tell how many messages it held.
    pending: Option<Broken>,
    chunks: u64,
    unchecked_chunks: u64,
    loose_messages: u64,
    messages: u64,
}

impl<'k> Bag<'k> {
    pub fn new(keep: Keep<'k>) -> Self {
        Self {
            keep,
            topics: vec![],
            by_name: HashMap::new(),
            budget: Budget::default(),
            origin: None,
            last_time: None,
            findings: vec![],
            reasons: vec![],
            metadata: vec![],
            file: Part::default(),
        }
    }

    /// Whether no limit has been passed: an error of one file is then none of the others.
    pub fn is_within_limits(&self) -> bool {
        self.budget.exceeded().is_none()
    }

    /// Reads a file; topics of files before it go on. Gives its messages by topic.
    pub fn read(&mut self, raw: &RawFile) -> Result<HashMap<String, u64>, IngestError> {
        self.file = Part { name: raw.name().to_owned(), ..Part::default() };
        let Some(mut scan) = Scan::new(raw)? else { return Err(super::no_magic(raw)) };
        let (mut body, mut inflate) = (Vec::new(), Inflate::default());
        let end = loop {
            match scan.next(&mut body)? {
                Step::Record(framed) => self.record(framed, &body, &mut inflate)?,
                Step::End(end) => break end,
            }
        };
        Ok(self.end_of_file(raw, end))
    }

    fn record(&mut self, framed: Framed, body: &[u8], inflate: &mut Inflate) -> Result<(), IngestError> {
        let Framed { opcode, offset, length, seen } = framed;
        if opcode != op::MESSAGE_INDEX
            && let Some(broken) = self.file.pending.take()
        {
            self.file.tell.broken(broken);
        }
        if let Seen::TooLong { limit } = seen {
            let name = super::record_name(opcode);
            let what = || format!("a {name} of {length} bytes, at most {limit} are read of one");
            // What comes behind what is missing can still be read.
            if opcode < 0x80 {
                self.file.tell.bad_record(offset, what);
            }
            return Ok(());
        }
        if self.file.data_ended && matches!(opcode, op::MESSAGE | op::CHUNK | op::ATTACHMENT) {
            self.file
                .tell
                .bad_record(offset, || format!("a {} behind the end of the data", super::record_name(opcode)));
            return Ok(());
        }
        match opcode {
            op::MESSAGE => {
                self.file.loose_messages += 1;
                self.message(offset, body)
            }
            op::CHUNK => self.chunk(offset, body, inflate),
            op::ATTACHMENT => {
                self.attachment(offset, body, seen);
                Ok(())
            }
            0x10.. => {
                if opcode < 0x80 {
                    self.file.tell.unknown_record(offset, opcode);
                }
                Ok(())
            }
            _ => {
                let Some(record) = fields::parse(opcode, body) else {
                    self.malformed(offset, opcode);
                    return Ok(());
                };
                self.parsed(offset, record, seen)
            }
        }
    }

    fn malformed(&mut self, offset: u64, opcode: u8) {
        self.file.tell.bad_record(offset, || format!("not what a {} holds", super::record_name(opcode)));
    }

    fn parsed(&mut self, offset: u64, record: Record, seen: Seen) -> Result<(), IngestError> {
        match record {
            Record::Header(header) => {
                let by =
                    if header.library.is_empty() { String::new() } else { format!(", by {}", shown(&header.library)) };
                let profile = if header.profile.is_empty() {
                    "no profile".to_owned()
                } else {
                    format!("profile {}", shown(&header.profile))
                };
                // The files of one bag say it once.
                let reason = format!("an MCAP file by its first bytes, {profile}{by}");
                if !self.reasons.contains(&reason) {
                    self.reasons.push(reason);
                }
            }
            Record::Schema { header, data } => self.schema(offset, header, &data),
            Record::Channel(channel) => self.channel(offset, channel)?,
            Record::MessageIndex(index) => {
                if let Some(broken) = &mut self.file.pending {
                    *broken.messages.get_or_insert(0) += index.records.len() as u64;
                }
            }
            Record::Metadata(metadata) => {
                for (key, value) in metadata.metadata {
                    self.tell_metadata(format!("{}: {key} = {value}", metadata.name));
                }
            }
            Record::Statistics(statistics) => self.file.statistics = Some(statistics),
            Record::DataEnd(end) => {
                self.file.data_ended = true;
                let stated = end.data_section_crc;
                if let Seen::Section { calculated } = seen {
                    if stated == 0 {
                        if self.file.loose_messages > 0 {
                            self.reason(
                                "the messages outside of chunks carry no checksum: damage in them cannot be seen",
                            );
                        }
                    } else if calculated != stated {
                        self.file.tell.checksum(Severity::Lost, format!(
                            "the data up to byte {offset} do not match their checksum ({calculated:08x}, stated is {stated:08x}): some byte of them is not what was written"
                        ));
                    }
                }
            }
            Record::Footer(footer) => {
                let stated = footer.summary_crc;
                if let Seen::Section { calculated } = seen
                    && stated != 0
                    && calculated != stated
                {
                    self.file.tell.checksum(Severity::Note, format!(
                        "the summary before byte {offset} does not match its checksum ({calculated:08x}, stated is {stated:08x}); no message is read from it"
                    ));
                }
            }
            _ => {}
        }
        Ok(())
    }

    fn reason(&mut self, sentence: &str) {
        if !self.reasons.iter().any(|reason| reason == sentence) {
            self.reasons.push(sentence.to_owned());
        }
    }

    fn tell_metadata(&mut self, line: String) {
        if self.metadata.len() < METADATA_LINES_MAX {
            let short = match line.char_indices().nth(METADATA_CHARACTERS_MAX) {
                Some((end, _)) => format!("{}…", &line[..end]),
                None => line,
            };
            self.metadata.push(short);
        }
    }

    fn attachment(&mut self, offset: u64, body: &[u8], seen: Seen) {
        let Some((name, media, bytes)) = fields::attachment(body) else {
            return self.malformed(offset, op::ATTACHMENT);
        };
        if let Seen::Attachment { calculated, stated } = seen
            && stated != 0
            && calculated != stated
        {
            let text = format!(
                "the attachment {} at byte {offset} does not match its checksum ({calculated:08x}, stated is {stated:08x})",
                shown(&name)
            );
            self.file.tell.checksum(Severity::Lost, text);
        }
        self.tell_metadata(format!("attachment {} ({media}), {bytes} bytes", shown(&name)));
    }

    fn schema(&mut self, offset: u64, header: ::mcap::records::SchemaHeader, data: &[u8]) {
        let ::mcap::records::SchemaHeader { id, name, encoding } = header;
        match self.file.schemas.get(&id) {
            Some(same) if same.name == name && same.encoding == encoding && same.data == data => {}
            Some(_) => self.file.tell.conflict(offset, || format!("schema {id}, {}", shown(&name))),
            None if id == 0 => self.malformed(offset, op::SCHEMA),
            None => {
                self.file.schemas.insert(id, Rc::new(Schema { name, encoding, data: data.to_vec() }));
            }
        }
    }

    fn channel(&mut self, offset: u64, definition: ::mcap::records::Channel) -> Result<(), IngestError> {
        let id = usize::from(definition.id);
        if let Some(Some(channel)) = self.file.channels.get_mut(id) {
            if channel.definition != definition {
                // Behind the data a damaged summary changes nothing any more.
                channel.conflict = !self.file.data_ended;
                self.file.tell.conflict(offset, || format!("channel {id}, {}", shown(&definition.topic)));
            }
            return Ok(());
        }
        let schema = self.file.schemas.get(&definition.schema_id).cloned();
        let alike = |topic: &Topic| topic.schema == schema && topic.encoding == definition.message_encoding;
        let same_name = self.by_name.get(&definition.topic).map_or(&[][..], Vec::as_slice);
        let topic = if let Some(index) = same_name.iter().find(|index| alike(&self.topics[**index])) {
            *index
        } else {
            // Two publishers may not agree on what they send.
            let name = match same_name.len() {
                0 => definition.topic.clone(),
                before => format!("{}#{}", definition.topic, before + 1),
            };
            if name != definition.topic {
                let (topic, name) = (shown(&definition.topic), shown(&name));
                self.reasons.push(format!(
                    "topic {topic} is sent with more than one definition: another of them is called {name}"
                ));
            }
            let encoding = definition.message_encoding.clone();
            let made = Topic::new(name, schema, encoding, self.keep, &mut self.budget);
            self.topics.push(made.ok_or_else(|| self.too_many_columns())?);
            self.by_name.entry(definition.topic.clone()).or_default().push(self.topics.len() - 1);
            self.topics.len() - 1
        };
        if self.file.channels.len() <= id {
            self.file.channels.resize_with(id + 1, || None);
        }
        self.file.channels[id] = Some(Channel { definition, topic, messages: 0, conflict: false });
        Ok(())
    }

    fn too_many_columns(&self) -> IngestError {
        IngestError::Unusable {
            place: Place::new(&self.file.name, None, None),
            expected: format!("at most {LOG_COLUMNS_MAX} columns"),
            found: format!("{} topics with their columns", self.topics.len() + 1),
            next: "write the topics you need to a bag of their own: `mcap filter --include-topic-regex`".to_owned(),
        }
    }

    #[inline]
    fn message(&mut self, offset: u64, body: &[u8]) -> Result<(), IngestError> {
        let Some((head, data)) = fields::message(body) else {
            self.malformed(offset, op::MESSAGE);
            return Ok(());
        };
        let Some(Some(channel)) = self.file.channels.get_mut(usize::from(head.channel)) else {
            self.file.tell.orphan(offset, head.channel);
            return Ok(());
        };
        channel.messages += 1;
        self.file.messages += 1;
        if channel.conflict {
            self.file.tell.after_conflict += 1;
            return Ok(());
        }
        let origin = *self.origin.get_or_insert_with(|| Origin::of(head.log_time));
        self.last_time = Some(self.last_time.map_or(head.log_time, |last| last.max(head.log_time)));
        // Channels name topics that are there.
        self.topics[channel.topic].add(head, data, origin, self.keep, &mut self.budget);
        match self.budget.exceeded() {
            None => Ok(()),
            Some(found) => Err(IngestError::Unusable {
                place: Place::new(&self.file.name, None, None),
                expected: "a recording whose columns fit into memory".to_owned(),
                found,
                next: "name the columns you need, or cut the bag into shorter ones".to_owned(),
            }),
        }
    }

    fn chunk(&mut self, offset: u64, body: &[u8], inflate: &mut Inflate) -> Result<(), IngestError> {
        let Some(chunk) = fields::chunk(body) else {
            self.malformed(offset, op::CHUNK);
            return Ok(());
        };
        let open = match inflate.open(&chunk) {
            Ok(open) => open,
            Err(why) => {
                let (start_time, end_time) = (chunk.start_time, chunk.end_time);
                self.file.pending = Some(Broken { offset, why, start_time, end_time, messages: None });
                return Ok(());
            }
        };
        self.file.chunks += 1;
        self.file.unchecked_chunks += u64::from(!open.checked);
        for record in Records::new(open.records) {
            match record {
                Ok((op::MESSAGE, _, body)) => self.message(offset, body)?,
                Ok((opcode @ (op::SCHEMA | op::CHANNEL), at, body)) => match fields::parse(opcode, body) {
                    Some(record) => self.parsed(offset, record, Seen::Body)?,
                    None => self.file.tell.bad_record(offset, || {
                        format!("in its chunk at {at}, not what a {} holds", super::record_name(opcode))
                    }),
                },
                Ok((opcode, at, _)) => {
                    if opcode < 0x80 {
                        self.file.tell.bad_record(offset, || {
                            format!(
                                "in its chunk at {at}, a {} does not belong into a chunk",
                                super::record_name(opcode)
                            )
                        });
                    }
                }
                Err(Overrun { offset: at }) => {
                    self.file
                        .tell
                        .bad_record(offset, || format!("in its chunk at {at}, a record goes on beyond its end"));
                }
            }
        }
        Ok(())
    }

    fn end_of_file(&mut self, raw: &RawFile, end: End) -> HashMap<String, u64> {
        let mut file = std::mem::take(&mut self.file);
        if let Some(broken) = file.pending.take() {
            file.tell.broken(broken);
        }
        let lossy = file.tell.is_lossy();
        if let Some(statistics) = &file.statistics
            && !lossy
        {
            for (id, stated) in &statistics.channel_message_counts {
                let found = file.channels.get(usize::from(*id)).and_then(Option::as_ref);
                let (name, found) =
                    found.map_or((format!("channel {id}"), 0), |c| (shown(&c.definition.topic), c.messages));
                if found != *stated {
                    file.tell.count(format!(
                        "{name}: the summary counts {}, {found} are in the data",
                        tell::messages(*stated)
                    ));
                }
            }
            let (stated, found) = (statistics.message_count, file.messages);
            if statistics.channel_message_counts.is_empty() && found != stated {
                file.tell.count(format!("the summary counts {}, {found} are in the data", tell::messages(stated)));
            }
        }
        if file.chunks > 0 && file.loose_messages > 0 {
            file.tell.loose(file.loose_messages);
        }
        if file.unchecked_chunks > 0 {
            self.reason("chunks without a checksum: damage in them shows only where they do not decompress");
        }
        let ending = tell::ending(&file.name, raw.len(), end, file.data_ended, self.last_time, self.origin);
        self.findings.extend(ending);
        self.findings.extend(file.tell.findings(&file.name, self.origin));
        let mut by_topic = HashMap::new();
        for channel in file.channels.into_iter().flatten() {
            *by_topic.entry(channel.definition.topic).or_insert(0) += channel.messages;
        }
        by_topic
    }

    /// All that was read, as a recording of `raw`.
    pub fn finish(mut self, raw: &RawFile) -> Result<Recording, IngestError> {
        for topic in &mut self.topics {
            topic.open(self.keep, &mut self.budget);
        }
        self.topics.sort_by(|a, b| a.name.cmp(&b.name));
        if self.topics.iter().all(|topic| topic.unreadable().is_some()) {
            return Err(self.no_channel(raw));
        }
        let mut tables = vec![];
        for topic in self.topics {
            self.findings.extend(tell::topic(raw.name(), &topic));
            for frame in &topic.frames.seen {
                self.metadata.push(format!("{}: frame_id {}", topic.name, shown(frame)));
            }
            let rows = topic.columns.rows();
            let schema = topic.schema.map(|schema| schema.name.clone());
            let columns = topic.columns.finish();
            let mut table = Table {
                name: topic.name,
                schema,
                columns,
                rows,
                lines: LineMap::default(),
                clock: None,
                decimal: Decimal::Point,
            };
            let (clock, why) = super::clock_of(&table, self.origin);
            table.clock = clock;
            for column in table.columns.iter_mut().filter(|column| column.unit.as_deref() == Some("s")) {
                column.is_dated = super::is_message_stamp(&column.name);
            }
            // Which stamp is the clock is known only now: the other was kept in case.
            for (i, column) in table.columns.iter_mut().enumerate().filter(|(i, _)| Some(*i) != clock) {
                if !self.keep.keeps(&table.name, &column.name, i + 1) {
                    column.cells = Cells::NotKept;
                }
            }
            self.reasons.extend(why);
            tables.push(table);
        }
        let origin = self.origin.map(Origin::date);
        let Self { findings, reasons, metadata, .. } = Self { topics: vec![], ..self };
        Ok(Recording { format: "MCAP", tables, findings, reasons, metadata, origin, photographs: vec![] })
    }

    fn no_channel(&self, raw: &RawFile) -> IngestError {
        let first: Vec<String> = self
            .topics
            .iter()
            .take(3)
            .map(|topic| format!("topic {}: {}", shown(&topic.name), topic.unreadable().unwrap_or_default()))
            .collect();
        let lost = self.findings.first().map(|finding| finding.text.clone());
        let found = match (first.is_empty(), lost) {
            (false, _) => first.join("; "),
            (true, Some(lost)) => format!("none; {lost}"),
            (true, None) => "none".to_owned(),
        };
        IngestError::Unusable {
            place: Place::new(raw.name(), None, None),
            expected: "at least one channel with messages in cdr (with ros2msg definitions), json or protobuf"
                .to_owned(),
            found,
            next: "record it again, or with `--storage mcap` from ROS 2; `mcap info` shows what is in it".to_owned(),
        }
    }
}
