//! Writing what [`read`](super::read) reads: for rehearsals and for export.
//!
//! Messages follow a definition: a known ROS type, one that is given, or one made from the names of the columns. The bytes depend
//! on the tables and the options alone.

mod cdr;
mod protobuf;

use std::collections::BTreeMap;
use std::io::{Seek, Write};

use super::plan::{Definitions, short_name};
use super::{LOG_TIME, PUBLISH_TIME};
use crate::IngestError;
use crate::error::Place;
use crate::recording::{Cells, Table};

/// How messages are encoded.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Hash)]
pub enum Encoding {
    /// As ROS 2 does it, little endian.
    #[default]
    Cdr,
    /// As objects; a hole is an absent field.
    Json,
    /// With every number a double; a hole is an absent field.
    Protobuf,
}

/// How chunks are compressed.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Hash)]
pub enum Compression {
    /// As ROS 2 does it by default.
    #[default]
    Zstd,
    /// Larger and faster.
    Lz4,
    /// Not at all.
    None,
}

/// How a bag is written.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct WriteOptions {
    /// How messages are encoded.
    pub encoding: Encoding,
    /// How chunks are compressed.
    pub compression: Compression,
    /// Bytes after which a chunk is closed; about 1 MB if absent.
    pub chunk_bytes: Option<u64>,
    /// The instant that the stamps of the tables count from, in s since 1970.
    pub origin_s: u64,
    /// Message definitions by type, beyond those known here: `("rig_msgs/msg/Flex", "float64 data")`.
    pub definitions: Vec<(String, String)>,
    /// Metadata records before the messages: a name, and what it says.
    pub metadata: Vec<(String, BTreeMap<String, String>)>,
}

/// A message definition of a header with its stamp and of one double a field, each with a comment above it: what a bag can say of units
/// and meanings where every reader looks. Comments are one line each, whatever they hold.
///
/// ```
/// use pneuval_ingest::formats::mcap::definition;
/// let text = definition(&["a rig"], &[("pressure_kpa", "kPa; measured")]);
/// assert!(text.starts_with("# a rig\nstd_msgs/Header header\n# kPa; measured\nfloat64 pressure_kpa\n===="));
/// ```
pub fn definition(comments: &[&str], fields: &[(&str, &str)]) -> String {
    let comment = |text: &str| -> String {
        let line: String = text.chars().map(|c| if c.is_control() { ' ' } else { c }).collect();
        format!("# {}\n", line.trim_end())
    };
    let mut text: String = comments.iter().map(|line| comment(line)).collect();
    text += "std_msgs/Header header\n";
    for (name, meaning) in fields {
        text.extend([&comment(meaning), "float64 ", name, "\n"]);
    }
    cdr::with_header(text)
}

/// Columns of a table by the name of their field.
struct Source<'t> {
    table: &'t Table,
    origin_s: u64,
}

impl<'t> Source<'t> {
    fn cells(&self, path: &str) -> Option<&'t Cells> {
        self.table.column(path).map(|column| &column.cells)
    }

    fn number(&self, path: &str, row: usize) -> Option<f64> {
        self.cells(path)?.numbers()?.get(row).copied()
    }

    fn text(&self, path: &str, row: usize) -> &'t str {
        self.cells(path).and_then(|cells| cells.text()?.get(row)).map_or("", String::as_str)
    }

    /// A stamp of a column in whole nanoseconds since 1970.
    // Beyond the range of i128 it ends there, far beyond that of u64.
    #[allow(clippy::cast_possible_truncation)]
    fn ns(&self, path: &str, row: usize) -> Option<u64> {
        let seconds = self.number(path, row).filter(|s| s.is_finite())?;
        let ns = i128::from(self.origin_s) * 1_000_000_000 + (seconds * 1e9).round() as i128;
        u64::try_from(ns).ok()
    }
}

/// Writes tables as topics, their messages ordered by log time. A column of `log_time` or `publish_time` gives a message its
/// times, else they are those of the clock; the columns that a definition names give its fields, what is absent is 0 or empty.
///
/// # Errors
/// [`IngestError::Malformed`] if a message has no time, a definition cannot be used, or a hole stands where CDR needs an integer;
/// [`IngestError::Write`] if it cannot be written.
pub fn write(out: &mut (impl Write + Seek), tables: &[Table], options: &WriteOptions) -> Result<(), IngestError> {
    let wrong = |table: &str, expected: &str, found: String| IngestError::Malformed {
        place: Place::new(table, None, None),
        expected: expected.to_owned(),
        found,
        next: "correct the table that is to be written".to_owned(),
    };
    let failed = |error: ::mcap::McapError| IngestError::write("the bag".as_ref(), std::io::Error::other(error));
    let compression = match options.compression {
        Compression::Zstd => Some(::mcap::Compression::Zstd),
        Compression::Lz4 => Some(::mcap::Compression::Lz4),
        Compression::None => None,
    };
    let chunk_bytes = options.chunk_bytes.unwrap_or(::mcap::WriteOptions::DEFAULT_CHUNK_SIZE);
    let profile = if options.encoding == Encoding::Cdr { "ros2" } else { "" };
    let settings = ::mcap::WriteOptions::new().profile(profile).library("pneuval").chunk_size(Some(chunk_bytes));
    // Frames of more than one thread depend on the machine.
    let mut writer = settings.compression(compression).compression_threads(0).create(out).map_err(failed)?;

    for (name, words) in &options.metadata {
        let record = ::mcap::records::Metadata { name: name.clone(), metadata: words.clone() };
        writer.write_metadata(&record).map_err(failed)?;
    }
    let mut order = vec![];
    let mut topics = vec![];
    for (index, table) in tables.iter().enumerate() {
        let source = Source { table, origin_s: options.origin_s };
        let clock = table.clock.and_then(|clock| table.columns.get(clock)).map(|column| column.name.clone());
        let clock = clock.unwrap_or_else(|| LOG_TIME.to_owned());
        for row in 0..table.rows {
            let log = source.ns(LOG_TIME, row).or_else(|| source.ns(&clock, row));
            let log =
                log.ok_or_else(|| wrong(&table.name, "a time for every message", format!("none in row {row}")))?;
            let publish = source.ns(PUBLISH_TIME, row).unwrap_or(log);
            order.push((log, index, row, publish));
        }
        let shape =
            Shape::new(table, options).map_err(|why| wrong(&table.name, "a definition of its messages", why))?;
        let schema = writer.add_schema(&shape.name, shape.schema_encoding, &shape.schema).map_err(failed)?;
        let metadata = BTreeMap::new();
        let channel = writer.add_channel(schema, &table.name, shape.message_encoding, &metadata).map_err(failed)?;
        topics.push((channel, shape, source, 0));
    }
    order.sort_unstable();
    let mut data = vec![];
    for (log_time, index, row, publish_time) in order {
        let Some((channel, shape, source, sequence)) = topics.get_mut(index) else { continue };
        data.clear();
        shape
            .encode(source, row, &mut data)
            .map_err(|why| wrong(&source.table.name, "a number for every integer", why))?;
        let head = ::mcap::records::MessageHeader { channel_id: *channel, sequence: *sequence, log_time, publish_time };
        writer.write_to_known_channel(&head, &data).map_err(failed)?;
        *sequence += 1;
    }
    writer.finish().map_err(failed)?;
    Ok(())
}

/// What the messages of a topic look like.
struct Shape {
    name: String,
    schema_encoding: &'static str,
    schema: Vec<u8>,
    message_encoding: &'static str,
    leaves: Leaves,
}

/// Where the fields come from.
enum Leaves {
    Cdr(Definitions),
    /// Columns as a tree of their paths.
    Tree(Vec<Node>),
    Protobuf(Vec<Node>),
}

/// A field, or the fields below it.
struct Node {
    name: String,
    path: String,
    below: Vec<Node>,
    text: bool,
}

/// Columns that are fields, as a tree; elements of arrays are fields of their own (`data[3]` as `data_3`) where names must be words.
fn tree(table: &Table, words: bool) -> Vec<Node> {
    let mut roots: Vec<Node> = vec![];
    for column in &table.columns {
        if [LOG_TIME, PUBLISH_TIME].contains(&column.name.as_str()) {
            continue;
        }
        let mut level = &mut roots;
        let parts: Vec<&str> = column.name.split('.').collect();
        for (depth, part) in parts.iter().enumerate() {
            let name = if words { field_name(part) } else { (*part).to_owned() };
            let leaf = depth + 1 == parts.len();
            let at = level.iter().position(|node| node.name == name && !leaf && !node.below.is_empty());
            let at = at.unwrap_or_else(|| {
                let path = if leaf { column.name.clone() } else { String::new() };
                let text = matches!(column.cells, Cells::Text(_));
                level.push(Node { name, path, below: vec![], text });
                level.len() - 1
            });
            level = &mut level[at].below;
        }
    }
    roots
}

/// A name that ROS and Protobuf allow for a field: lower-case letters, digits and single underscores, a letter first.
///
/// ```
/// use pneuval_ingest::formats::mcap::field_name;
/// assert_eq!(field_name("tip-x_kPa"), "tip_x_kpa");
/// assert_eq!(field_name("2nd"), "f2nd");
/// ```
pub fn field_name(text: &str) -> String {
    let mut word = String::new();
    for c in text.chars() {
        if c.is_ascii_alphanumeric() {
            word.push(c.to_ascii_lowercase());
        } else if !word.is_empty() && !word.ends_with('_') {
            word.push('_');
        }
    }
    let word = word.trim_end_matches('_');
    if word.starts_with(|c: char| c.is_ascii_alphabetic()) { word.to_owned() } else { format!("f{word}") }
}

impl Shape {
    fn new(table: &Table, options: &WriteOptions) -> Result<Self, String> {
        let name = table.schema.clone().unwrap_or_else(|| "pneuval_msgs/msg/Sample".to_owned());
        match options.encoding {
            Encoding::Json => {
                let leaves = Leaves::Tree(tree(table, false));
                Ok(Self {
                    name,
                    schema_encoding: "jsonschema",
                    schema: br#"{"type":"object"}"#.to_vec(),
                    message_encoding: "json",
                    leaves,
                })
            }
            Encoding::Protobuf => {
                let nodes = tree(table, true);
                let name = field_name(&name);
                let set = protobuf::descriptors(&name, &nodes);
                let leaves = Leaves::Protobuf(nodes);
                Ok(Self { name, schema_encoding: "protobuf", schema: set, message_encoding: "protobuf", leaves })
            }
            Encoding::Cdr => {
                let short = short_name(&name);
                let given = options.definitions.iter().find(|(given, _)| short_name(given) == short);
                let text = match given {
                    Some((_, text)) => text.clone(),
                    None => cdr::known_definition(&short).unwrap_or_else(|| cdr::made_definition(table)),
                };
                let definitions = Definitions::parse(&name, &text)?;
                let leaves = Leaves::Cdr(definitions);
                Ok(Self {
                    name,
                    schema_encoding: "ros2msg",
                    schema: text.into_bytes(),
                    message_encoding: "cdr",
                    leaves,
                })
            }
        }
    }

    fn encode(&self, source: &Source, row: usize, out: &mut Vec<u8>) -> Result<(), String> {
        match &self.leaves {
            Leaves::Tree(nodes) => {
                let object = serde_json::Value::Object(object(nodes, source, row));
                out.extend_from_slice(object.to_string().as_bytes());
                Ok(())
            }
            Leaves::Protobuf(nodes) => {
                protobuf::encode(nodes, source, row, out);
                Ok(())
            }
            Leaves::Cdr(definitions) => cdr::encode(definitions, source, row, out),
        }
    }
}

fn object(nodes: &[Node], source: &Source, row: usize) -> serde_json::Map<String, serde_json::Value> {
    let mut map = serde_json::Map::new();
    for node in nodes {
        let stamp = super::HEADER_STAMPS.contains(&node.path.as_str());
        let value = if !node.below.is_empty() {
            Some(serde_json::Value::Object(object(&node.below, source, row)))
        } else if node.text {
            Some(source.text(&node.path, row).into())
        } else if stamp && let Some(ns) = source.ns(&node.path, row) {
            Some(serde_json::json!({ "sec": ns / 1_000_000_000, "nanosec": ns % 1_000_000_000 }))
        } else {
            source.number(&node.path, row).and_then(serde_json::Number::from_f64).map(serde_json::Value::Number)
        };
        if let Some(value) = value {
            map.insert(node.name.clone(), value);
        }
    }
    map
}
