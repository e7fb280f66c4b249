//! Protobuf messages by the descriptors in the file.

use prost_reflect::{DescriptorPool, DynamicMessage, FieldDescriptor, MessageDescriptor, ReflectMessage as _, Value};

use super::cdr::{Bad, Target};
use super::json::put_time;
use crate::limits::{ARRAY_COLUMNS_MAX, NESTING_MAX};

/// The descriptor of a message type.
pub(super) fn descriptor(name: &str, set: &[u8]) -> Result<MessageDescriptor, String> {
    let pool = DescriptorPool::decode(set).map_err(|error| format!("its descriptor cannot be used: {error}"))?;
    let found = pool.get_message_by_name(name);
    found.ok_or_else(|| format!("its descriptors do not hold {}", crate::error::shown(name)))
}

/// Decodes a message.
pub(super) fn decode(
    descriptor: &MessageDescriptor,
    data: &[u8],
    path: &mut String,
    target: &mut Target,
) -> Result<bool, Bad> {
    target.columns.begin(true);
    path.clear();
    let message = DynamicMessage::decode(descriptor.clone(), data).map_err(|_| Bad::Syntax)?;
    walk(&message, path, 0, target);
    Ok(false)
}

fn walk(message: &DynamicMessage, path: &mut String, depth: usize, target: &mut Target) {
    if depth > NESTING_MAX {
        target.columns.cut_at(path, 0);
        return;
    }
    let length = path.len();
    for field in message.descriptor().fields() {
        // What has a presence and is absent has no value; the others have their default.
        if field.supports_presence() && !message.has_field(&field) {
            continue;
        }
        if length > 0 {
            path.push('.');
        }
        path.push_str(field.name());
        value(&field, &message.get_field(&field), path, depth, target);
        path.truncate(length);
    }
}

fn value(field: &FieldDescriptor, value_of: &Value, path: &mut String, depth: usize, target: &mut Target) {
    let number = match value_of {
        Value::Bool(value) => f64::from(u8::from(*value)),
        Value::I32(value) | Value::EnumNumber(value) => f64::from(*value),
        Value::I64(value) => *value as f64,
        Value::U32(value) => f64::from(*value),
        Value::U64(value) => *value as f64,
        Value::F32(value) => f64::from(*value),
        Value::F64(value) => *value,
        Value::String(text) => {
            if path == "header.frame_id" || path == "frame_id" {
                target.frames.see(text.as_bytes());
            } else {
                let slot = target.columns.text(path, target.keep, target.budget);
                target.columns.put_text(slot, text.as_bytes());
            }
            return;
        }
        // A picture or a packet.
        Value::Bytes(_) => return,
        Value::Message(message) => return self::message(message, path, depth, target),
        Value::List(elements) => {
            if elements.len() > ARRAY_COLUMNS_MAX {
                target.columns.cut_at(path, elements.len());
            }
            for (index, element) in elements.iter().take(ARRAY_COLUMNS_MAX).enumerate() {
                within(field, element, &index.to_string(), path, depth, target);
            }
            return;
        }
        Value::Map(entries) => {
            let mut sorted: Vec<_> = entries.iter().map(|(key, value)| (format!("{key:?}"), key, value)).collect();
            sorted.sort_by(|a, b| a.0.cmp(&b.0));
            for (_, key, element) in sorted.into_iter().take(ARRAY_COLUMNS_MAX) {
                let key = match key {
                    prost_reflect::MapKey::Bool(key) => key.to_string(),
                    prost_reflect::MapKey::I32(key) => key.to_string(),
                    prost_reflect::MapKey::I64(key) => key.to_string(),
                    prost_reflect::MapKey::U32(key) => key.to_string(),
                    prost_reflect::MapKey::U64(key) => key.to_string(),
                    prost_reflect::MapKey::String(key) => key.clone(),
                };
                within(field, element, &key, path, depth, target);
            }
            return;
        }
    };
    let slot = target.columns.number(path, None, false, target.keep, target.budget);
    target.columns.put(slot, number);
}

fn within(field: &FieldDescriptor, element: &Value, key: &str, path: &mut String, depth: usize, target: &mut Target) {
    let length = path.len();
    path.push('[');
    path.push_str(key);
    path.push(']');
    value(field, element, path, depth + 1, target);
    path.truncate(length);
}

fn message(message: &DynamicMessage, path: &mut String, depth: usize, target: &mut Target) {
    let descriptor = message.descriptor();
    let instant = match descriptor.full_name() {
        "google.protobuf.Timestamp" => true,
        "google.protobuf.Duration" => false,
        _ => return walk(message, path, depth + 1, target),
    };
    let part = |number| message.get_field_by_number(number);
    let whole = |value: Option<std::borrow::Cow<Value>>| value.and_then(|v| v.as_i64().or(v.as_i32().map(i64::from)));
    if let (Some(seconds), Some(nanoseconds)) = (whole(part(1)), whole(part(2))) {
        put_time(path, seconds, nanoseconds, instant, target);
    }
}
