//! Protobuf messages by the descriptors in the file.
//!
//! The wire format is read directly: field number and wire type, then the value
//! (<https://protobuf.dev/programming-guides/encoding/>). Fields that a descriptor does not name are passed over, as every reader of
//! Protobuf does.

use std::collections::HashMap;

use prost::Message as _;
use prost_types::field_descriptor_proto::{Label, Type};
use prost_types::{DescriptorProto, FieldDescriptorProto, FileDescriptorProto, FileDescriptorSet};

use super::cdr::{Bad, Target};
use super::columns::Slot;
use super::json::put_time;
use crate::limits::{ARRAY_COLUMNS_MAX, NESTING_MAX};

/// The message types of a file.
#[derive(Debug)]
pub(super) struct Descriptors {
    messages: Vec<Message>,
    root: usize,
}

#[derive(Debug)]
struct Message {
    name: String,
    fields: HashMap<u32, Field>,
    /// Numbers of the fields that are 0 or empty where they are absent.
    defaults: Vec<u32>,
    /// Whether it is an entry of a map.
    is_entry: bool,
}

#[derive(Debug)]
struct Field {
    name: String,
    kind: Type,
    /// The message it holds.
    of: Option<usize>,
    repeated: bool,
}

impl Descriptors {
    /// Reads a `FileDescriptorSet` and finds the type of a topic in it.
    pub fn parse(name: &str, set: &[u8]) -> Result<Self, String> {
        let set = FileDescriptorSet::decode(set).map_err(|error| format!("its descriptor cannot be used: {error}"))?;
        let mut found = vec![];
        for file in &set.file {
            let package = file.package.as_deref().filter(|package| !package.is_empty());
            for message in &file.message_type {
                collect(message, package.unwrap_or_default(), file, 0, &mut found);
            }
        }
        let numbers: HashMap<String, usize> =
            found.iter().enumerate().map(|(n, (name, ..))| (name.clone(), n)).collect();
        let messages =
            found.into_iter().map(|(name, message, file)| Message::new(name, message, file, &numbers)).collect();
        let root = numbers.get(name.trim_start_matches('.')).copied();
        let root = root.ok_or_else(|| format!("its descriptors do not hold {}", crate::error::shown(name)))?;
        Ok(Self { messages, root })
    }
}

/// The messages of a file with those within them, by full name.
fn collect<'d>(
    message: &'d DescriptorProto,
    scope: &str,
    file: &'d FileDescriptorProto,
    depth: usize,
    found: &mut Vec<(String, &'d DescriptorProto, &'d FileDescriptorProto)>,
) {
    if depth > NESTING_MAX {
        return;
    }
    let dot = if scope.is_empty() { "" } else { "." };
    let name = format!("{scope}{dot}{}", message.name());
    for nested in &message.nested_type {
        collect(nested, &name, file, depth + 1, found);
    }
    found.push((name, message, file));
}

impl Message {
    fn new(
        name: String,
        message: &DescriptorProto,
        file: &FileDescriptorProto,
        numbers: &HashMap<String, usize>,
    ) -> Self {
        let mut fields = HashMap::new();
        let mut defaults = vec![];
        for field in &message.field {
            let Ok(number) = u32::try_from(field.number()) else { continue };
            let repeated = field.label() == Label::Repeated;
            if file.syntax() == "proto3" && !repeated && is_default(field) {
                defaults.push(number);
            }
            let of = numbers.get(field.type_name().trim_start_matches('.')).copied();
            fields.insert(number, Field { name: field.name().to_owned(), kind: field.r#type(), of, repeated });
        }
        let is_entry = message.options.as_ref().is_some_and(prost_types::MessageOptions::map_entry);
        Self { name, fields, defaults, is_entry }
    }
}

/// Whether an absent field stands for its default: in the newer syntax, unless it is one of several or optional.
fn is_default(field: &FieldDescriptorProto) -> bool {
    let number = !matches!(field.r#type(), Type::Message | Type::Group | Type::Bytes | Type::String);
    number && field.oneof_index.is_none() && !field.proto3_optional()
}

/// Decodes a message.
pub(super) fn decode(
    descriptors: &Descriptors,
    data: &[u8],
    path: &mut String,
    target: &mut Target,
) -> Result<bool, Bad> {
    target.columns.begin(true);
    path.clear();
    Walk { descriptors, path, target }.message(descriptors.root, data, 0)?;
    Ok(false)
}

/// What stands behind a field number.
#[derive(Clone, Copy)]
enum Wire<'a> {
    Varint(u64),
    Eight([u8; 8]),
    Four([u8; 4]),
    Bytes(&'a [u8]),
}

/// The next field of a message.
fn next<'a>(data: &mut &'a [u8]) -> Result<(u32, Wire<'a>), Bad> {
    let key = varint(data)?;
    let number = u32::try_from(key >> 3).map_err(|_| Bad::Syntax)?;
    let value = match key & 7 {
        0 => Wire::Varint(varint(data)?),
        1 => Wire::Eight(fixed(data)?),
        2 => {
            let count = usize::try_from(varint(data)?).map_err(|_| Bad::Short)?;
            let (bytes, rest) = data.split_at_checked(count).ok_or(Bad::Short)?;
            *data = rest;
            Wire::Bytes(bytes)
        }
        5 => Wire::Four(fixed(data)?),
        // Groups have been obsolete since 2008.
        _ => return Err(Bad::Syntax),
    };
    Ok((number, value))
}

fn varint(data: &mut &[u8]) -> Result<u64, Bad> {
    let mut value = 0;
    for shift in (0..70).step_by(7) {
        let (byte, rest) = data.split_first().ok_or(Bad::Short)?;
        *data = rest;
        value |= u64::from(byte & 0x7f).checked_shl(shift).unwrap_or(0);
        if byte & 0x80 == 0 {
            return Ok(value);
        }
    }
    Err(Bad::Syntax)
}

fn fixed<const N: usize>(data: &mut &[u8]) -> Result<[u8; N], Bad> {
    let (bytes, rest) = data.split_first_chunk().ok_or(Bad::Short)?;
    *data = rest;
    Ok(*bytes)
}

/// The number that a value of a kind stands for; `None` if it is not written as such a kind is.
// Integers wrap to the width of their kind, as the encoding says; beyond 2^53 the nearest double.
#[allow(clippy::cast_possible_truncation)]
fn number(kind: Type, value: Wire) -> Option<f64> {
    let zigzag = |value: u64| (value >> 1).cast_signed() ^ -(value & 1).cast_signed();
    Some(match (kind, value) {
        (Type::Double, Wire::Eight(bytes)) => f64::from_le_bytes(bytes),
        (Type::Float, Wire::Four(bytes)) => f64::from(f32::from_le_bytes(bytes)),
        (Type::Int32 | Type::Enum, Wire::Varint(value)) => f64::from((value as u32).cast_signed()),
        (Type::Int64, Wire::Varint(value)) => value.cast_signed() as f64,
        (Type::Uint32, Wire::Varint(value)) => f64::from(value as u32),
        (Type::Uint64, Wire::Varint(value)) => value as f64,
        (Type::Sint32 | Type::Sint64, Wire::Varint(value)) => zigzag(value) as f64,
        (Type::Bool, Wire::Varint(value)) => f64::from(u8::from(value != 0)),
        (Type::Fixed32, Wire::Four(bytes)) => f64::from(u32::from_le_bytes(bytes)),
        (Type::Sfixed32, Wire::Four(bytes)) => f64::from(i32::from_le_bytes(bytes)),
        (Type::Fixed64, Wire::Eight(bytes)) => u64::from_le_bytes(bytes) as f64,
        (Type::Sfixed64, Wire::Eight(bytes)) => i64::from_le_bytes(bytes) as f64,
        _ => return None,
    })
}

/// One number of a packed list.
fn packed<'a>(kind: Type, data: &mut &'a [u8]) -> Result<Wire<'a>, Bad> {
    Ok(match kind {
        Type::Double | Type::Fixed64 | Type::Sfixed64 => Wire::Eight(fixed(data)?),
        Type::Float | Type::Fixed32 | Type::Sfixed32 => Wire::Four(fixed(data)?),
        _ => Wire::Varint(varint(data)?),
    })
}

struct Walk<'w, 't> {
    descriptors: &'w Descriptors,
    path: &'w mut String,
    target: &'w mut Target<'t>,
}

impl Walk<'_, '_> {
    fn message(&mut self, index: usize, mut data: &[u8], depth: usize) -> Result<(), Bad> {
        if depth > NESTING_MAX {
            return Err(Bad::Syntax);
        }
        let descriptors = self.descriptors;
        let Some(message) = descriptors.messages.get(index) else { return Ok(()) };
        if message.name == "google.protobuf.Timestamp" || message.name == "google.protobuf.Duration" {
            return self.time(message.name.ends_with("Timestamp"), data);
        }
        for number in &message.defaults {
            if let Some(field) = message.fields.get(number) {
                self.within(&field.name, |walk| {
                    walk.put(0.0);
                    Ok(())
                })?;
            }
        }
        // How often each repeated field has come by, in a list because there are few.
        let mut counts: Vec<(u32, usize)> = vec![];
        while !data.is_empty() {
            let (number, value) = next(&mut data)?;
            let Some(field) = message.fields.get(&number) else { continue };
            if !field.repeated {
                self.within(&field.name, |walk| walk.value(field, value, depth))?;
                continue;
            }
            let at = counts.iter().position(|(counted, _)| *counted == number).unwrap_or_else(|| {
                counts.push((number, 0));
                counts.len() - 1
            });
            let count = &mut counts[at].1;
            self.within(&field.name, |walk| walk.repeated(field, value, count, depth))?;
        }
        Ok(())
    }

    /// Does something one field further down.
    fn within(&mut self, name: &str, mut act: impl FnMut(&mut Self) -> Result<(), Bad>) -> Result<(), Bad> {
        let length = self.path.len();
        if length > 0 && !name.starts_with('[') {
            self.path.push('.');
        }
        self.path.push_str(name);
        let done = act(self);
        self.path.truncate(length);
        done
    }

    fn put(&mut self, value: f64) {
        let Target { columns, keep, budget, .. } = &mut *self.target;
        let slot = columns.number(self.path, None, false, *keep, budget);
        columns.put(slot, value);
    }

    fn value(&mut self, field: &Field, value: Wire, depth: usize) -> Result<(), Bad> {
        match (field.kind, value) {
            (Type::Message, Wire::Bytes(data)) => match field.of {
                Some(of) => self.message(of, data, depth + 1),
                None => Ok(()),
            },
            (Type::String, Wire::Bytes(text)) => {
                let Target { columns, keep, budget, frames, .. } = &mut *self.target;
                if self.path == "header.frame_id" || self.path == "frame_id" {
                    frames.see(text);
                    return Ok(());
                }
                let slot = columns.text(self.path, *keep, budget);
                if slot != Slot::None {
                    columns.put_text(slot, text);
                }
                Ok(())
            }
            // A picture or a packet.
            (Type::Bytes, Wire::Bytes(_)) => Ok(()),
            (kind, value) => {
                self.put(number(kind, value).ok_or(Bad::Syntax)?);
                Ok(())
            }
        }
    }

    fn repeated(&mut self, field: &Field, value: Wire, count: &mut usize, depth: usize) -> Result<(), Bad> {
        let entry = field.of.and_then(|of| self.descriptors.messages.get(of)).filter(|message| message.is_entry);
        if let (Some(entry), Wire::Bytes(data)) = (entry, value) {
            return self.entry(entry, data, depth);
        }
        let text = matches!(field.kind, Type::String | Type::Bytes | Type::Message);
        if let (Wire::Bytes(mut data), false) = (value, text) {
            while !data.is_empty() {
                let value = packed(field.kind, &mut data)?;
                self.element(field, value, count, depth)?;
            }
            return Ok(());
        }
        self.element(field, value, count, depth)
    }

    fn element(&mut self, field: &Field, value: Wire, count: &mut usize, depth: usize) -> Result<(), Bad> {
        let index = *count;
        *count += 1;
        if index >= ARRAY_COLUMNS_MAX {
            self.target.columns.cut_at(self.path, *count);
            return Ok(());
        }
        self.within(&format!("[{index}]"), |walk| walk.value(field, value, depth))
    }

    /// An entry of a map: a message of a key and a value.
    fn entry(&mut self, entry: &Message, data: &[u8], depth: usize) -> Result<(), Bad> {
        let (mut rest, mut name, mut found) = (data, String::new(), None);
        while !rest.is_empty() {
            match (next(&mut rest)?, entry.fields.get(&1)) {
                ((1, Wire::Bytes(key)), _) => name = String::from_utf8_lossy(key).into_owned(),
                ((1, key), Some(field)) => name = number(field.kind, key).ok_or(Bad::Syntax)?.to_string(),
                ((2, value), _) => found = Some(value),
                _ => {}
            }
        }
        let (Some(field), Some(value)) = (entry.fields.get(&2), found) else { return Ok(()) };
        self.within(&format!("[{name}]"), |walk| walk.value(field, value, depth + 1))
    }

    fn time(&mut self, instant: bool, mut data: &[u8]) -> Result<(), Bad> {
        let (mut seconds, mut nanoseconds) = (0, 0);
        while !data.is_empty() {
            match next(&mut data)? {
                (1, Wire::Varint(value)) => seconds = value.cast_signed(),
                (2, Wire::Varint(value)) => nanoseconds = value.cast_signed(),
                _ => {}
            }
        }
        put_time(self.path, seconds, nanoseconds, instant, self.target);
        Ok(())
    }
}
