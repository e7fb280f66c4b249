//! What properties state of scales.

use super::Unsupported;
use crate::error::shown;
use crate::formats::tdms::value::{Properties, Value};
use crate::limits::TDMS_SCALES_MAX;

/// The id that stands for the raw values.
const RAW: u64 = 0xFFFF_FFFF;

/// Whether values are scaled already.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum Status {
    Unscaled,
    Scaled,
    /// A word that is neither.
    Unknown(String),
}

pub(super) fn status_of(properties: &Properties) -> Status {
    match properties.get("NI_Scaling_Status") {
        None => Status::Unscaled,
        Some(Value::Text(text)) if text == "unscaled" => Status::Unscaled,
        Some(Value::Text(text)) if text == "scaled" => Status::Scaled,
        Some(other) => Status::Unknown(other.to_string()),
    }
}

/// How many scales are stated: `NI_Number_Of_Scales`, or up to the last that has a type.
pub(super) fn scales_of(properties: &Properties) -> Result<usize, Unsupported> {
    let count = match properties.get("NI_Number_Of_Scales") {
        Some(count) => whole(count).ok_or_else(|| not_a("NI_Number_Of_Scales", "a whole number", count))?,
        None => properties.keys().filter_map(|name| typed(name)).max().map_or(0, |last| last.saturating_add(1)),
    };
    let count = usize::try_from(count).unwrap_or(usize::MAX);
    if count > TDMS_SCALES_MAX {
        return Err(Unsupported(format!("{count} scales are stated, at most {TDMS_SCALES_MAX} are supported")));
    }
    Ok(count)
}

/// The id of a scale in the name of its type.
fn typed(name: &str) -> Option<u64> {
    let id = name.strip_prefix("NI_Scale[")?.strip_suffix("]_Scale_Type")?;
    let is_number = !id.is_empty() && id.bytes().all(|byte| byte.is_ascii_digit());
    is_number.then(|| id.parse().unwrap_or(u64::MAX))
}

/// The type of a scale; `None` for what the card gives under this id.
pub(super) fn kind_of(properties: &Properties, id: usize) -> Result<Option<&str>, Unsupported> {
    let name = format!("NI_Scale[{id}]_Scale_Type");
    match properties.get(&name) {
        None => Ok(None),
        Some(Value::Text(kind)) => Ok(Some(kind)),
        Some(other) => Err(not_a(&name, "a text", other)),
    }
}

/// What a scale takes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Input {
    Raw,
    /// One of those that are stated.
    Scale(usize),
}

/// A scale and its properties.
pub(super) struct Stated<'p> {
    pub(super) properties: &'p Properties,
    pub(super) id: usize,
    pub(super) kind: &'p str,
    /// How many there are.
    pub(super) scales: usize,
}

impl Stated<'_> {
    /// A property of this scale under its whole name.
    fn get(&self, name: &str) -> (String, Option<&Value>) {
        let name = format!("NI_Scale[{}]_{}_{name}", self.id, self.kind);
        let value = self.properties.get(&name);
        (name, value)
    }

    pub(super) fn unsupported(&self, why: &str) -> Unsupported {
        Unsupported(format!("scale {} ({}) {why}", self.id, self.kind))
    }

    fn missing(&self, name: &str) -> Unsupported {
        self.unsupported(&format!("lacks the property `{name}`"))
    }

    /// A finite number.
    pub(super) fn number(&self, name: &str) -> Result<f64, Unsupported> {
        let (name, value) = self.get(name);
        let value = value.ok_or_else(|| self.missing(&name))?;
        value.number().filter(|number| number.is_finite()).ok_or_else(|| not_a(&name, "a finite number", value))
    }

    /// A finite number by which something is divided.
    pub(super) fn divisor(&self, name: &str) -> Result<f64, Unsupported> {
        let number = self.number(name)?;
        if number == 0.0 { Err(self.unsupported(&format!("states `{}` as 0", self.get(name).0))) } else { Ok(number) }
    }

    /// A whole number, not negative.
    pub(super) fn count(&self, name: &str) -> Result<u64, Unsupported> {
        let found = self.count_or_none(name)?;
        found.ok_or_else(|| self.missing(&self.get(name).0))
    }

    /// The same where it may be absent.
    pub(super) fn count_or_none(&self, name: &str) -> Result<Option<u64>, Unsupported> {
        let (name, value) = self.get(name);
        let read = |value| whole(value).ok_or_else(|| not_a(&name, "a whole number", value));
        value.map(read).transpose()
    }

    /// So many finite numbers, `name[0]` and on. `left` is how many the channel may still have.
    pub(super) fn numbers(&self, name: &str, count: u64, left: &mut usize) -> Result<Vec<f64>, Unsupported> {
        let within = usize::try_from(count).ok().and_then(|count| left.checked_sub(count));
        *left = within.ok_or_else(|| {
            self.unsupported(&format!("states {count} numbers `{}`, which is too many", self.get(name).0))
        })?;
        (0..count).map(|place| self.number(&format!("{name}[{place}]"))).collect()
    }

    /// What it takes.
    pub(super) fn input(&self, name: &str) -> Result<Input, Unsupported> {
        let (whole_name, value) = self.get(name);
        self.input_in(&whole_name, value.ok_or_else(|| self.missing(&whole_name))?)
    }

    /// The same; the raw values where nothing is stated.
    pub(super) fn input_or_raw(&self, name: &str) -> Result<Input, Unsupported> {
        let (whole_name, value) = self.get(name);
        value.map_or(Ok(Input::Raw), |value| self.input_in(&whole_name, value))
    }

    fn input_in(&self, name: &str, value: &Value) -> Result<Input, Unsupported> {
        // NI's tools know the raw values as -1, and store it without a sign.
        if *value == Value::Int(-1) {
            return Ok(Input::Raw);
        }
        let id = whole(value).ok_or_else(|| not_a(name, "a whole number", value))?;
        let known = usize::try_from(id).ok().filter(|id| *id < self.scales);
        match known {
            Some(id) => Ok(Input::Scale(id)),
            None if id == RAW => Ok(Input::Raw),
            None => Err(self.unsupported(&format!("takes scale {id}, and the last is scale {}", self.scales - 1))),
        }
    }
}

fn whole(value: &Value) -> Option<u64> {
    match value {
        Value::Uint(value) => Some(*value),
        Value::Int(value) => u64::try_from(*value).ok(),
        _ => None,
    }
}

fn not_a(name: &str, what: &str, value: &Value) -> Unsupported {
    Unsupported(format!("the property `{name}` is {}, not {what}", shown(&value.to_string())))
}
