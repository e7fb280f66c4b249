//! Messages as JSON objects: every number, truth value and text by its path, found out from the messages themselves.

use std::fmt;

use serde::de::{DeserializeSeed, Deserializer, Error, IgnoredAny, MapAccess, SeqAccess, Visitor};

use super::cdr::{Bad, Target};
use super::columns::Slot;
use super::plan::is_stamp;
use crate::limits::ARRAY_COLUMNS_MAX;

/// What the path of the field at hand may grow to.
const PATH_BYTES_MAX: usize = 1 << 12;

/// Decodes a message.
pub(super) fn decode(data: &[u8], path: &mut String, target: &mut Target) -> Result<bool, Bad> {
    target.columns.begin(true);
    path.clear();
    let mut json = serde_json::Deserializer::from_slice(data);
    let root = Node { path, target };
    json.deserialize_map(root).map_err(|error| if error.is_eof() { Bad::Short } else { Bad::Syntax })?;
    json.end().map_err(|_| Bad::Syntax)?;
    Ok(false)
}

/// A value on its way to the cell of its path.
struct Node<'n, 't, 'p> {
    path: &'p mut String,
    target: &'n mut Target<'t>,
}

/// What stands where a time may stand in two parts.
enum Part {
    Seconds,
    Nanoseconds,
}

fn part(key: &str) -> Option<Part> {
    match key {
        "sec" | "secs" | "seconds" => Some(Part::Seconds),
        "nanosec" | "nanosecs" | "nsec" | "nsecs" | "nanos" | "nanoseconds" => Some(Part::Nanoseconds),
        _ => None,
    }
}

/// Whether a field of two parts is an instant, by its name: JSON does not say.
pub(super) fn is_instant(path: &str) -> bool {
    let name = path.rsplit('.').next().unwrap_or(path).to_ascii_lowercase();
    name.contains("stamp") || name.ends_with("time")
}

/// Seconds and nanoseconds into the cell of a path.
pub(super) fn put_time(path: &str, seconds: i64, nanoseconds: i64, instant: bool, target: &mut Target) {
    let from = if instant { target.origin_s } else { 0 };
    let ns = i128::from(seconds).saturating_sub(from.into()) * 1_000_000_000 + i128::from(nanoseconds);
    let slot = target.columns.number(path, Some("s"), is_stamp(path), target.keep, target.budget);
    if instant {
        target.columns.date(slot);
    }
    target.columns.put(slot, ns as f64 / 1e9);
}

impl Node<'_, '_, '_> {
    fn number(self, value: f64) {
        // A text in the first message and a number in a later one: the column stays one of text, and this cell empty.
        let slot = self.target.columns.number(self.path, None, false, self.target.keep, self.target.budget);
        self.target.columns.put(slot, value);
    }
}

impl<'de> DeserializeSeed<'de> for Node<'_, '_, '_> {
    type Value = ();

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<(), D::Error> {
        deserializer.deserialize_any(self)
    }
}

impl<'de> Visitor<'de> for Node<'_, '_, '_> {
    type Value = ();

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str("a JSON value")
    }

    fn visit_bool<E>(self, value: bool) -> Result<(), E> {
        self.number(f64::from(u8::from(value)));
        Ok(())
    }

    fn visit_i64<E>(self, value: i64) -> Result<(), E> {
        self.number(value as f64);
        Ok(())
    }

    fn visit_u64<E>(self, value: u64) -> Result<(), E> {
        self.number(value as f64);
        Ok(())
    }

    fn visit_f64<E>(self, value: f64) -> Result<(), E> {
        self.number(value);
        Ok(())
    }

    fn visit_unit<E>(self) -> Result<(), E> {
        Ok(())
    }

    fn visit_str<E>(self, value: &str) -> Result<(), E> {
        if self.path == "header.frame_id" {
            self.target.frames.see(value.as_bytes());
            return Ok(());
        }
        let slot = self.target.columns.text(self.path, self.target.keep, self.target.budget);
        if slot != Slot::None {
            self.target.columns.put_text(slot, value.as_bytes());
        }
        Ok(())
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut elements: A) -> Result<(), A::Error> {
        let length = self.path.len();
        for index in 0.. {
            let more = if index < ARRAY_COLUMNS_MAX {
                use fmt::Write as _;
                // Writing to a String cannot fail.
                let _ = write!(self.path, "[{index}]");
                let node = Node { path: &mut *self.path, target: &mut *self.target };
                let more = elements.next_element_seed(node)?.is_some();
                self.path.truncate(length);
                more
            } else {
                elements.next_element::<IgnoredAny>()?.is_some()
            };
            if !more {
                if index > ARRAY_COLUMNS_MAX {
                    self.target.columns.cut_at(self.path, index);
                }
                break;
            }
        }
        Ok(())
    }

    fn visit_map<A: MapAccess<'de>>(self, mut fields: A) -> Result<(), A::Error> {
        let length = self.path.len();
        let (mut seconds, mut nanoseconds) = (None, None);
        while let Some(key) = fields.next_key::<String>()? {
            if length + key.len() > PATH_BYTES_MAX {
                return Err(A::Error::custom("the path of a field is too long"));
            }
            if let Some(part) = part(&key)
                && length > 0
            {
                let value = fields.next_value::<serde_json::Value>()?;
                let serde_json::Value::Number(number) = value else {
                    self.path.push('.');
                    self.path.push_str(&key);
                    let node = Node { path: &mut *self.path, target: &mut *self.target };
                    let done = node.deserialize(value);
                    self.path.truncate(length);
                    done.map_err(A::Error::custom)?;
                    continue;
                };
                match part {
                    Part::Seconds => seconds = Some((key, number)),
                    Part::Nanoseconds => nanoseconds = Some((key, number)),
                }
                continue;
            }
            if length > 0 {
                self.path.push('.');
            }
            self.path.push_str(&key);
            let done = fields.next_value_seed(Node { path: &mut *self.path, target: &mut *self.target });
            self.path.truncate(length);
            done?;
        }
        let whole = |part: &Option<(String, serde_json::Number)>| part.as_ref().and_then(|(_, number)| number.as_i64());
        if let (Some(seconds), Some(nanoseconds)) = (whole(&seconds), whole(&nanoseconds)) {
            put_time(self.path, seconds, nanoseconds, is_instant(self.path), self.target);
            return Ok(());
        }
        for (key, number) in seconds.into_iter().chain(nanoseconds) {
            self.path.push('.');
            self.path.push_str(&key);
            let node = Node { path: &mut *self.path, target: &mut *self.target };
            node.number(number.as_f64().unwrap_or(f64::NAN));
            self.path.truncate(length);
        }
        Ok(())
    }
}
