//! A folder as `ros2 bag record` leaves it: `metadata.yaml`, and the bag in one or more MCAP files.

use std::collections::{BTreeMap, HashMap};

use saphyr_parser::{Event, Parser};

use super::bag::Bag;
use super::tell::messages;
use crate::IngestError;
use crate::error::{Place, shown};
use crate::finding::places::placeless;
use crate::finding::{Finding, FindingKind, Severity};
use crate::formats::foreign::CONVERT_BAG;
use crate::limits::NESTING_MAX;
use crate::raw::RawFile;
use crate::recording::{Keep, Recording};

/// A `metadata.yaml` of hundreds of files and topics.
const METADATA_BYTES_MAX: u64 = 4 << 20;

/// What `metadata.yaml` says.
#[derive(Debug, Default, PartialEq, Eq)]
struct Metadata {
    files: Vec<String>,
    messages: Option<u64>,
    topics: BTreeMap<String, u64>,
    compression: Option<String>,
}

/// Reads the files of a folder as one recording: in the order of `metadata.yaml`, or by name without it.
///
/// # Errors
/// As [`super::read`]; [`IngestError::Unusable`] also if the folder holds no MCAP file, with the command that converts it where
/// its storage is another.
pub fn read(raw: &RawFile, keep: Keep) -> Result<Recording, IngestError> {
    let mut bag = Bag::new(keep);
    let Folder { said, files, findings, reason } = Folder::open(raw)?;
    bag.reasons.extend(reason);
    let mut told = findings;
    let mut tell = |kind, severity, text: String| told.push(finding(raw, kind, severity, text));
    let mut counts: HashMap<String, u64> = HashMap::new();
    let mut unusable = None;
    let mut read = 0;
    for file in files {
        match bag.read(file) {
            Ok(topics) => {
                read += 1;
                for (topic, count) in topics {
                    *counts.entry(topic).or_insert(0) += count;
                }
            }
            Err(error @ IngestError::Unusable { .. }) if bag.is_within_limits() => {
                let words: Vec<String> = error
                    .to_string()
                    .lines()
                    .map(|line| line.split_whitespace().collect::<Vec<_>>().join(" "))
                    .collect();
                tell(FindingKind::UnusableFile, Severity::Lost, format!("a file cannot be used: {}", words.join("; ")));
                unusable.get_or_insert(error);
            }
            Err(error) => return Err(error),
        }
    }
    if let (0, Some(error)) = (read, unusable) {
        return Err(error);
    }
    if let Some(said) = said {
        for (topic, stated) in &said.topics {
            let found = counts.get(topic).copied().unwrap_or(0);
            if found != *stated {
                // More than was counted is odd, and nothing is missing.
                let severity = if found < *stated { Severity::Lost } else { Severity::Note };
                let stated = messages(*stated);
                let text = format!("topic {}: `metadata.yaml` counts {stated}, {found} are in the files", shown(topic));
                tell(FindingKind::CountMismatch, severity, text);
            }
        }
        let found: u64 = counts.values().sum();
        if let Some(stated) = said.messages.filter(|stated| *stated != found && said.topics.is_empty()) {
            let text = format!("`metadata.yaml` counts {}, {found} are in the files", messages(stated));
            let severity = if found < stated { Severity::Lost } else { Severity::Note };
            tell(FindingKind::CountMismatch, severity, text);
        }
    }
    bag.findings.extend(told);
    bag.finish(raw)
}

/// The MCAP files of a folder in their order; a single file is itself.
///
/// # Errors
/// As [`read`], if there is none.
pub(super) fn files<'r>(raw: &'r RawFile<'r>) -> Result<Vec<&'r RawFile<'r>>, IngestError> {
    if raw.parts().is_some() { Ok(Folder::open(raw)?.files) } else { Ok(vec![raw]) }
}

fn finding(raw: &RawFile, kind: FindingKind, severity: Severity, text: String) -> Finding {
    placeless(kind, severity, raw.name(), None, 1, text)
}

/// A folder before its bags are read.
struct Folder<'r> {
    said: Option<Metadata>,
    files: Vec<&'r RawFile<'r>>,
    findings: Vec<Finding>,
    reason: Option<String>,
}

impl<'r> Folder<'r> {
    fn open(raw: &'r RawFile<'r>) -> Result<Self, IngestError> {
        let parts = raw.parts().unwrap_or_default();
        let mut findings = vec![];
        let mut tell = |kind, severity, text: String| findings.push(finding(raw, kind, severity, text));
        let (mut said, mut reason) = (None, None);
        match parts.iter().find(|part| part.file_name() == "metadata.yaml") {
            Some(part) => match parse(&part.head(METADATA_BYTES_MAX)?) {
                Ok(metadata) => said = Some(metadata),
                Err(why) => {
                    let text = format!("{} cannot be used ({why}); the files are read by name", part.name());
                    tell(FindingKind::UnusableFile, Severity::Note, text);
                }
            },
            None => reason = Some("no `metadata.yaml` in the folder: the files are read by name".to_owned()),
        }
        let is_mcap = |part: &&RawFile| ends_with(part, "mcap");
        let mut files: Vec<&RawFile> = vec![];
        for name in said.as_ref().map_or(&[][..], |said| &said.files) {
            // Recorders of some releases put the folder before the name.
            let name = name.rsplit('/').next().unwrap_or(name);
            match parts.iter().find(|part| part.file_name() == name) {
                Some(part) if files.iter().any(|file| file.name() == part.name()) => {}
                Some(part) if is_mcap(&part) => files.push(part),
                // Told below.
                Some(part) if ends_with(part, "zstd") => {}
                Some(part) => {
                    let name = shown(part.file_name());
                    let text = format!("`metadata.yaml` names {name}, which is no `.mcap` file: it is not read");
                    tell(FindingKind::UnusableFile, Severity::Lost, text);
                }
                None => {
                    let name = shown(name);
                    let text =
                        format!("`metadata.yaml` names {name}, which is not in the folder: its messages are lost");
                    tell(FindingKind::CountMismatch, Severity::Lost, text);
                }
            }
        }
        for part in parts.iter().filter(is_mcap) {
            if !files.iter().any(|file| file.name() == part.name()) {
                if said.is_some() {
                    let name = shown(part.file_name());
                    let text = format!("{name} is not named in `metadata.yaml`; read after the others");
                    tell(FindingKind::CountMismatch, Severity::Note, text);
                }
                files.push(part);
            }
        }
        if files.is_empty() {
            return Err(no_file(raw, parts, said.as_ref()));
        }
        for part in parts.iter().filter(|part| ends_with(part, "zstd")) {
            let name = shown(part.file_name());
            let text =
                format!("{name} is compressed as a whole and not read; decompress it in the folder: `zstd -d *.zstd`");
            tell(FindingKind::UnusableFile, Severity::Lost, text);
        }
        Ok(Self { said, files, findings, reason })
    }
}

fn ends_with(part: &RawFile, ending: &str) -> bool {
    std::path::Path::new(part.name()).extension().is_some_and(|e| e == ending)
}

fn no_file(raw: &RawFile, parts: &[RawFile], said: Option<&Metadata>) -> IngestError {
    let ends = |with: &str| parts.iter().any(|part| part.name().ends_with(with));
    let compressed =
        said.and_then(|said| said.compression.as_deref()).is_some_and(|mode| mode.eq_ignore_ascii_case("file"));
    let (found, next) = if ends(".db3") {
        ("an SQLite store (`.db3`)", CONVERT_BAG.to_owned())
    } else if compressed || ends(".mcap.zstd") || ends(".zstd") {
        ("files that are compressed as a whole", "decompress them in the folder: `zstd -d *.zstd`".to_owned())
    } else {
        ("none", "is this the folder you meant?".to_owned())
    };
    IngestError::Unusable {
        place: Place::new(raw.name(), None, None),
        expected: "a folder with `.mcap` files".to_owned(),
        found: found.to_owned(),
        next,
    }
}

/// A YAML value; scalars as they are written.
#[derive(Debug, Clone, PartialEq, Eq)]
enum Yaml {
    Scalar(String),
    List(Vec<Yaml>),
    Map(Vec<(String, Yaml)>),
}

impl Yaml {
    fn get(&self, key: &str) -> Option<&Self> {
        match self {
            Self::Map(entries) => entries.iter().find(|(name, _)| name == key).map(|(_, value)| value),
            _ => None,
        }
    }

    fn list(&self) -> &[Self] {
        match self {
            Self::List(elements) => elements,
            _ => &[],
        }
    }

    fn text(&self) -> Option<&str> {
        match self {
            Self::Scalar(text) => Some(text),
            _ => None,
        }
    }

    fn number(&self) -> Option<u64> {
        self.text()?.parse().ok()
    }
}

fn parse(bytes: &[u8]) -> Result<Metadata, String> {
    let text = std::str::from_utf8(bytes).map_err(|_| "it is not text".to_owned())?;
    let document = yaml(text)?;
    let bag = document.get("rosbag2_bagfile_information").ok_or("it does not describe a bag")?;
    let texts = |key: &str| bag.get(key).map_or(&[][..], Yaml::list).iter().filter_map(Yaml::text).map(str::to_owned);
    let topic = |entry: &Yaml| {
        let name = entry.get("topic_metadata")?.get("name")?.text()?;
        Some((name.to_owned(), entry.get("message_count")?.number()?))
    };
    let topics = bag.get("topics_with_message_count").map_or(&[][..], Yaml::list);
    Ok(Metadata {
        files: texts("relative_file_paths").collect(),
        messages: bag.get("message_count").and_then(Yaml::number),
        topics: topics.iter().filter_map(topic).collect(),
        compression: bag.get("compression_mode").and_then(Yaml::text).map(str::to_owned),
    })
}

/// The one document of a YAML text. References to other parts of it are not followed: they could ask for any memory.
fn yaml(text: &str) -> Result<Yaml, String> {
    let mut open: Vec<(Yaml, Option<String>)> = vec![];
    for event in Parser::new_from_str(text) {
        let (event, span) = event.map_err(|error| error.to_string())?;
        let value = match event {
            Event::Scalar(text, ..) => Yaml::Scalar(text.into_owned()),
            Event::SequenceStart(..) => {
                open.push((Yaml::List(vec![]), None));
                continue;
            }
            Event::MappingStart(..) => {
                open.push((Yaml::Map(vec![]), None));
                continue;
            }
            Event::SequenceEnd | Event::MappingEnd => match open.pop() {
                Some((value, _)) => value,
                None => continue,
            },
            Event::Alias(_) => return Err(format!("line {}: references are not read", span.start.line())),
            _ => continue,
        };
        if open.len() > NESTING_MAX {
            return Err(format!("more than {NESTING_MAX} levels deep"));
        }
        match open.last_mut() {
            None => return Ok(value),
            Some((Yaml::List(elements), _)) => elements.push(value),
            Some((Yaml::Map(entries), key)) => match key.take() {
                Some(name) => entries.push((name, value)),
                None => match value {
                    Yaml::Scalar(name) => *key = Some(name),
                    _ => return Err(format!("line {}: a key that is no word", span.start.line())),
                },
            },
            Some((Yaml::Scalar(_), _)) => {}
        }
    }
    Err("it is empty or ends early".to_owned())
}

#[cfg(test)]
mod tests {
    use super::{Metadata, parse};

    #[test]
    fn metadata_as_ros_writes_it() {
        let text = "rosbag2_bagfile_information:\n  version: 5\n  storage_identifier: mcap\n  duration:\n    nanoseconds: 1\n  \
             message_count: 7\n  topics_with_message_count:\n    - topic_metadata:\n        name: /p\n        type: \
             sensor_msgs/msg/FluidPressure\n        offered_qos_profiles: \"- history: 3\\n  depth: 0\"\n      \
             message_count: 7\n  compression_format: \"\"\n  compression_mode: \"\"\n  relative_file_paths:\n    - \
             rig_0.mcap\n    - rig_1.mcap\n";
        let expected = Metadata {
            files: vec!["rig_0.mcap".to_owned(), "rig_1.mcap".to_owned()],
            messages: Some(7),
            topics: [("/p".to_owned(), 7)].into(),
            compression: Some(String::new()),
        };
        assert_eq!(parse(text.as_bytes()), Ok(expected));
        assert!(parse(b"a: &x [1]\nb: *x\n").unwrap_err().contains("references"));
        assert!(parse(b"").is_err() && parse(b"[").is_err() && parse("[".repeat(100).as_bytes()).is_err());
    }
}
