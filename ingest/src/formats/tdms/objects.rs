//! What is known of the objects of a file so far, and which of them have values in the segment at hand.

use std::collections::{HashMap, HashSet};

use super::metadata::{Entry, IndexSaid, RawIndex, names};
use super::value::{Properties, Value};
use crate::error::shown;
use crate::finding::places::as_text;
use crate::limits::{TDMS_OBJECTS_MAX, TDMS_PROPERTIES_BYTES_MAX};

/// The file, a group or a channel.
#[derive(Debug)]
pub(super) struct Object {
    pub group: Option<String>,
    pub channel: Option<String>,
    pub properties: Properties,
    /// How its raw values stood when that was last said.
    pub index: Option<RawIndex>,
    /// Where it stands among those of the segment.
    slot: Option<usize>,
}

/// An object of the segment at hand.
#[derive(Debug, Clone, Copy)]
struct Active {
    object: usize,
    has_data: bool,
}

/// A property that was set.
#[derive(Debug)]
pub(super) struct Set {
    pub object: usize,
    pub name: String,
    /// Whether it had another value before.
    pub is_change: bool,
}

/// All objects of a file.
#[derive(Debug, Default)]
pub(super) struct Objects {
    list: Vec<Object>,
    by_path: HashMap<Vec<u8>, usize>,
    groups: HashMap<String, usize>,
    file: Option<usize>,
    active: Vec<Active>,
    /// Bytes of all properties, names included.
    property_bytes: usize,
}

impl Objects {
    pub fn get(&self, object: usize) -> Option<&Object> {
        self.list.get(object)
    }

    pub fn iter(&self) -> impl ExactSizeIterator<Item = &Object> {
        self.list.iter()
    }

    /// The properties of the file.
    pub fn of_file(&self) -> Option<&Properties> {
        Some(&self.get(self.file?)?.properties)
    }

    /// The properties of a group.
    pub fn of_group(&self, group: &str) -> Option<&Properties> {
        Some(&self.get(*self.groups.get(group)?)?.properties)
    }

    /// Objects that have values in the segment, and how they stand, in the order in which they do.
    pub fn with_data(&self) -> impl Iterator<Item = (usize, &RawIndex)> {
        let index = |active: &Active| Some((active.object, self.list.get(active.object)?.index.as_ref()?));
        self.active.iter().filter(|active| active.has_data).filter_map(index)
    }

    /// Takes what the metadata of a segment say; gives the properties that were set. The error is a sentence about the segment; nothing
    /// is taken then.
    pub fn apply(&mut self, entries: Vec<Entry>, is_new_list: bool) -> Result<Vec<Set>, String> {
        self.check(&entries)?;
        if is_new_list {
            for active in std::mem::take(&mut self.active) {
                if let Some(object) = self.list.get_mut(active.object) {
                    object.slot = None;
                }
            }
        }
        let mut sets = Vec::new();
        for Entry { path, index, properties } in entries {
            let known = self.by_path.get(path).copied();
            let at = known.unwrap_or_else(|| {
                let (group, channel) = names(path).unwrap_or_default();
                match (&group, &channel) {
                    (None, _) => self.file = Some(self.list.len()),
                    (Some(group), None) => drop(self.groups.insert(group.clone(), self.list.len())),
                    (Some(_), Some(_)) => {}
                }
                self.list.push(Object { group, channel, properties: Properties::new(), index: None, slot: None });
                self.by_path.insert(path.to_vec(), self.list.len() - 1);
                self.list.len() - 1
            });
            let Some(object) = self.list.get_mut(at) else { continue };
            let has_data = index != IndexSaid::NoData;
            if let IndexSaid::New(index) = index {
                object.index = Some(index);
            }
            if let Some(active) = object.slot.and_then(|slot| self.active.get_mut(slot)) {
                active.has_data = has_data;
            } else {
                object.slot = Some(self.active.len());
                self.active.push(Active { object: at, has_data });
            }
            for (name, value) in properties {
                let name = as_text(name);
                let before = object.properties.get(&name);
                if before == Some(&value) {
                    continue;
                }
                sets.push(Set { object: at, name: name.clone(), is_change: before.is_some() });
                self.property_bytes += bytes(&name, &value);
                self.property_bytes -= before.map_or(0, |before| bytes(&name, before));
                object.properties.insert(name, value);
            }
        }
        Ok(sets)
    }

    /// Whether everything in the metadata of a segment can be taken.
    fn check(&self, entries: &[Entry]) -> Result<(), String> {
        let mut new = HashSet::new();
        let mut property_bytes = self.property_bytes;
        // Those that are met here for the first time, with a word on how their values stand.
        let mut described = HashSet::new();
        for entry in entries {
            let path = || shown(&as_text(entry.path));
            let known = self.by_path.get(entry.path).and_then(|object| self.list.get(*object));
            if known.is_none() && new.insert(entry.path) && names(entry.path).is_none() {
                return Err(format!("{} is no path of a group or channel", path()));
            }
            if known.is_none_or(|object| object.index.is_none()) {
                if matches!(entry.index, IndexSaid::New(_)) {
                    described.insert(entry.path);
                } else if entry.index == IndexSaid::AsBefore && !described.contains(entry.path) {
                    return Err(format!("the values of {} should stand as before, and were not there before", path()));
                }
            }
            property_bytes +=
                entry.properties.iter().map(|(name, value)| 64 + name.len() + length(value)).sum::<usize>();
        }
        let count = self.list.len() + new.len();
        if count > TDMS_OBJECTS_MAX {
            return Err(format!("{count} groups and channels up to there; at most {TDMS_OBJECTS_MAX} are read"));
        }
        if property_bytes > TDMS_PROPERTIES_BYTES_MAX {
            return Err(format!(
                "{property_bytes} bytes of properties up to there; at most {TDMS_PROPERTIES_BYTES_MAX} are read"
            ));
        }
        Ok(())
    }
}

/// Bytes of a property in memory, about.
fn bytes(name: &str, value: &Value) -> usize {
    64 + name.len() + length(value)
}

fn length(value: &Value) -> usize {
    value.text().map_or(0, str::len)
}
