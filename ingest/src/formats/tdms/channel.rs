//! A channel while it is read: what its raw values are, and the columns they become.

use super::metadata::RawIndex;
use super::objects::{Object, Objects};
use super::scaling::{Scaling, Scratch, Unsupported};
use super::timing::{Timing, Timings};
use super::types::{DataType, Sink, Values};
use super::value::{Properties, Timestamp, Value};
use crate::finding::places::{Places, as_text};
use crate::formats::csv;
use crate::recording::{Builder, Cells, ClockUnit, Column, Keep};
use crate::units::{Dimension, Unit};

/// A channel.
#[derive(Debug)]
pub(super) struct Channel {
    pub object: usize,
    pub group: String,
    /// As the file has it, made unique in its group.
    pub name: String,
    pub is_kept: bool,
    /// Whether it was asked for by its name.
    pub is_asked: bool,
    /// Values that its chunks state, those that the end of the file cuts off included.
    pub stated: u64,
    /// Values that are there.
    pub values: u64,
    pub timings: Timings,
    /// Whether its raw values are integers that a double may not hold.
    is_wide: bool,
    content: Content,
}

/// What the values of a channel become.
#[derive(Debug)]
enum Content {
    /// No values yet.
    Open,
    /// Nobody asked for them.
    Skipped,
    /// They cannot be used: why.
    Refused(String),
    Numbers(Builder),
    Instants(Builder),
    Complex(Box<[Builder; 2]>),
    Texts(Vec<String>),
    /// Counts of a DAQ card without a scale, by scaler.
    Counts(Vec<(u32, Builder)>),
    Scaled(Box<Scaled>),
}

/// Values on their way through a scaling.
#[derive(Debug)]
struct Scaled {
    scaling: Scaling,
    raw: Vec<f64>,
    /// In the order of [`Scaling::scalers`].
    scalers: Vec<Vec<f64>>,
    /// Where the values of each scaler of the channel go.
    slots: Vec<Option<usize>>,
    out: Vec<f64>,
    numbers: Builder,
    /// Values that the equations of the scaling do not hold for.
    beyond: Places,
}

/// What all channels of a file share.
#[derive(Debug, Default)]
pub(super) struct Shared {
    /// The whole second from which instants count: that of the first of them.
    pub origin: Option<i64>,
    scratch: Scratch,
}

impl Shared {
    /// The origin, which is the whole second of `first` unless there is one already.
    fn origin(&mut self, first: impl FnOnce() -> Option<Timestamp>) -> i64 {
        if let Some(origin) = self.origin {
            return origin;
        }
        first().map_or(0, |first| *self.origin.insert(first.seconds))
    }
}

impl Channel {
    /// A channel without values so far; `None` for the file and for groups.
    pub fn new(at: usize, object: &Object, unique: impl FnOnce(&str, &str) -> String, keep: Keep) -> Option<Self> {
        let (Some(group), Some(name)) = (&object.group, &object.channel) else { return None };
        let name = unique(group, name);
        // Complex numbers and scalers become columns of their own names.
        let names = [name.clone(), format!("{name}.re"), format!("{name}.im")];
        let is_kept = names.iter().any(|name| keep.keeps(group, name, 0)) || keeps_scaler(keep, group, &name);
        Some(Self {
            object: at,
            group: group.clone(),
            name,
            is_kept,
            is_asked: is_kept && matches!(keep, Keep::Only(_)),
            stated: 0,
            values: 0,
            timings: Timings::new(Timing::of(&object.properties)),
            is_wide: false,
            content: Content::Open,
        })
    }

    /// Why its values cannot be used.
    pub fn refused(&self) -> Option<&str> {
        match &self.content {
            Content::Refused(why) => Some(why),
            _ => None,
        }
    }

    /// Values that the equations of its scaling do not hold for.
    pub fn beyond(&self) -> Option<&Places> {
        match &self.content {
            Content::Scaled(scaled) if scaled.beyond.count() > 0 => Some(&scaled.beyond),
            _ => None,
        }
    }

    /// Whether its columns may hold integers that were rounded.
    pub fn is_wide(&self) -> bool {
        self.is_wide && matches!(self.content, Content::Numbers(_) | Content::Counts(_))
    }

    /// Whether its values are counts of a DAQ card without a scale.
    pub fn is_unscaled(&self) -> bool {
        matches!(self.content, Content::Counts(_))
    }

    /// Whether it is known what its values become.
    pub fn is_begun(&self) -> bool {
        !matches!(self.content, Content::Open)
    }

    /// Whether its values are looked at.
    pub fn is_read(&self) -> bool {
        !matches!(self.content, Content::Skipped | Content::Refused(_))
    }

    /// Columns of numbers that a value becomes.
    pub fn cells(&self) -> u64 {
        match &self.content {
            Content::Complex(_) => 2,
            Content::Counts(counts) => counts.len() as u64,
            Content::Open | Content::Skipped | Content::Refused(_) => 0,
            Content::Numbers(_) | Content::Instants(_) | Content::Texts(_) | Content::Scaled(_) => 1,
        }
    }

    /// Prepares for values that stand so. `objects` hold the properties that are to be used; those of this file may be all known, or
    /// those known so far.
    ///
    /// The error is a sentence: the values are of another kind than those before.
    pub fn begin(&mut self, index: &RawIndex, objects: &Objects, keep: Keep) -> Result<(), String> {
        let is_wide = |data_type| matches!(data_type, DataType::I64 | DataType::U64);
        let scalers = index.daqmx.iter().flat_map(|(scalers, _)| scalers);
        self.is_wide |= is_wide(index.data_type) || scalers.clone().any(|scaler| is_wide(scaler.data_type));
        if let Content::Open = self.content {
            self.content = self.content_for(index, objects, keep);
            return Ok(());
        }
        let kind = match (index.data_type, &index.daqmx) {
            (DataType::Text, _) => "text",
            (DataType::Time, _) => "timestamps",
            (DataType::ComplexSingle | DataType::ComplexDouble, _) => "complex numbers",
            (_, Some((scalers, _))) if scalers.len() > 1 => "several scalers",
            _ => "numbers",
        };
        let is_alike = match &self.content {
            Content::Open | Content::Skipped | Content::Refused(_) => true,
            Content::Numbers(_) => kind == "numbers",
            Content::Instants(_) => kind == "timestamps",
            Content::Complex(_) => kind == "complex numbers",
            Content::Texts(_) => kind == "text",
            Content::Counts(counts) => index.daqmx.as_ref().is_some_and(|(scalers, _)| {
                scalers.iter().map(|scaler| scaler.id).eq(counts.iter().map(|(id, _)| *id))
            }),
            Content::Scaled(scaled) => match &index.daqmx {
                // Scalers may stand elsewhere, but must be the same.
                Some((scalers, _)) => {
                    let slots = scalers.iter().map(|scaler| slot(&scaled.scaling, scaler.id));
                    slots.eq(scaled.slots.iter().copied())
                }
                None => kind == "numbers" && scaled.scaling.takes_raw(),
            },
        };
        if is_alike { Ok(()) } else { Err(format!("its values become {kind} and were something else before")) }
    }

    fn content_for(&self, index: &RawIndex, objects: &Objects, keep: Keep) -> Content {
        if !self.is_kept && matches!(keep, Keep::Only(_)) {
            return Content::Skipped;
        }
        let Some(object) = objects.get(self.object) else { return Content::Skipped };
        let none = Properties::new();
        let properties = &object.properties;
        let group = objects.of_group(&self.group).unwrap_or(&none);
        let scaling = match Scaling::of(properties, group, objects.of_file().unwrap_or(&none)) {
            Ok(scaling) => scaling,
            Err(Unsupported(why)) => return Content::Refused(why),
        };
        let numbers = || match seems_clock(&self.name, properties).filter(|_| !self.is_kept) {
            Some(unit) => Builder::clock(false, unit),
            None => Builder::new(self.is_kept),
        };
        match (index.data_type, scaling, &index.daqmx) {
            (DataType::Text, _, _) => Content::Texts(Vec::new()),
            (DataType::Time, None, _) => Content::Instants(Builder::clock(self.is_kept, ClockUnit::Seconds(1.0))),
            (DataType::ComplexSingle | DataType::ComplexDouble, None, _) => {
                Content::Complex(Box::new([Builder::new(self.is_kept), Builder::new(self.is_kept)]))
            }
            (data_type @ (DataType::ComplexSingle | DataType::ComplexDouble | DataType::Time), Some(_), None) => {
                Content::Refused(format!("a scale is stated for its {}", data_type.name()))
            }
            (_, None, Some((scalers, _))) if index.data_type == DataType::Daqmx => {
                let builder = |scaler: &super::metadata::Scaler| (scaler.id, Builder::new(self.is_kept));
                Content::Counts(scalers.iter().map(builder).collect())
            }
            (_, None, _) => Content::Numbers(numbers()),
            (_, Some(scaling), daqmx) => {
                let ids: Vec<u32> = daqmx.iter().flat_map(|(scalers, _)| scalers).map(|scaler| scaler.id).collect();
                if let Some(missing) = scaling.scalers().iter().find(|id| !ids.contains(id)) {
                    let has: Vec<String> = ids.iter().map(u32::to_string).collect();
                    let has = if has.is_empty() { "none".to_owned() } else { has.join(", ") };
                    return Content::Refused(format!("its scale takes scaler {missing}, and the channel has {has}"));
                }
                if scaling.takes_raw() && index.data_type == DataType::Daqmx {
                    return Content::Refused(
                        "its scale takes raw values, and a DAQ card gives scalers only".to_owned(),
                    );
                }
                let slots = ids.iter().map(|id| slot(&scaling, *id)).collect();
                let scalers = vec![Vec::new(); scaling.scalers().len()];
                let numbers = numbers();
                Content::Scaled(Box::new(Scaled {
                    scaling,
                    raw: vec![],
                    scalers,
                    slots,
                    out: vec![],
                    numbers,
                    beyond: Places::default(),
                }))
            }
        }
    }

    /// Takes raw values, which are whole; those of a DAQ card go to [`push_scaler`](Self::push_scaler).
    pub fn push(&mut self, values: Values, data_type: DataType, shared: &mut Shared) {
        let none = |_: Timestamp| f64::NAN;
        match &mut self.content {
            Content::Numbers(numbers) => values.push(data_type, numbers, none),
            Content::Instants(numbers) => {
                let origin = shared.origin(|| values.first_instant());
                values.push(data_type, numbers, |stamp| stamp.since(origin));
            }
            Content::Complex(parts) => {
                let [re, im] = parts.as_mut();
                values.push(data_type, re, none);
                values.push_imaginary(data_type, im);
            }
            Content::Scaled(scaled) => {
                values.push(data_type, &mut scaled.raw, none);
                scaled.apply(&mut shared.scratch);
            }
            Content::Open | Content::Skipped | Content::Refused(_) | Content::Texts(_) | Content::Counts(_) => {}
        }
    }

    /// Takes the values of one of its scalers.
    pub fn push_scaler(
        &mut self,
        values: Values,
        scaler: usize,
        bit: Option<u32>,
        data_type: DataType,
        shared: &mut Shared,
    ) {
        fn push(values: Values, bit: Option<u32>, data_type: DataType, shared: &mut Shared, sink: &mut impl Sink) {
            match bit {
                Some(bit) => values.push_bit(bit, sink),
                None if data_type == DataType::Time => {
                    let origin = shared.origin(|| values.first_instant());
                    values.push(data_type, sink, |stamp| stamp.since(origin));
                }
                None => values.push(data_type, sink, |_| f64::NAN),
            }
        }
        match &mut self.content {
            Content::Counts(counts) => {
                if let Some((_, numbers)) = counts.get_mut(scaler) {
                    push(values, bit, data_type, shared, numbers);
                }
            }
            Content::Numbers(numbers) | Content::Instants(numbers) => push(values, bit, data_type, shared, numbers),
            Content::Scaled(scaled) => {
                if scaler == 0 && scaled.scaling.takes_raw() {
                    push(values, bit, data_type, shared, &mut scaled.raw);
                }
                let slot = scaled.slots.get(scaler).copied().flatten();
                if let Some(values_of) = slot.and_then(|slot| scaled.scalers.get_mut(slot)) {
                    push(values, bit, data_type, shared, values_of);
                }
                scaled.apply(&mut shared.scratch);
            }
            Content::Open | Content::Skipped | Content::Refused(_) | Content::Complex(_) | Content::Texts(_) => {}
        }
    }

    /// Takes a text.
    pub fn push_text(&mut self, text: &[u8]) {
        if let Content::Texts(texts) = &mut self.content
            && self.is_kept
        {
            texts.push(as_text(text));
        }
    }

    /// Asks for the memory of so many more values.
    pub fn reserve(&mut self, count: usize) {
        match &mut self.content {
            Content::Numbers(numbers) | Content::Instants(numbers) => numbers.reserve(count),
            Content::Scaled(scaled) => scaled.numbers.reserve(count),
            Content::Complex(parts) => parts.iter_mut().for_each(|part| part.reserve(count)),
            Content::Counts(counts) => counts.iter_mut().for_each(|(_, part)| part.reserve(count)),
            Content::Open | Content::Skipped | Content::Refused(_) | Content::Texts(_) => {}
        }
    }

    /// Its columns, each with `rows` cells: holes stand where the end of the file has cut values off.
    pub fn finish(self, rows: usize, object: Option<&Object>, unique: &mut impl FnMut(&str) -> String) -> Vec<Column> {
        let unit = object.and_then(|object| unit(&object.properties));
        let name = self.name;
        let full = |mut builder: Builder, name: String, unit: Option<String>| {
            let missing = rows.saturating_sub(builder.len());
            builder.extend(std::iter::repeat_n(f64::NAN, missing));
            builder.finish(name, unit)
        };
        match self.content {
            Content::Numbers(numbers) => vec![full(numbers, name, unit)],
            Content::Scaled(scaled) => vec![full(scaled.numbers, name, unit)],
            Content::Instants(numbers) => {
                vec![Column { is_dated: true, ..full(numbers, name, Some("s".to_owned())) }]
            }
            Content::Complex(parts) => {
                let [re, im] = *parts;
                let [re_name, im_name] = [".re", ".im"].map(|part| unique(&format!("{name}{part}")));
                vec![full(re, re_name, unit.clone()), full(im, im_name, unit)]
            }
            Content::Counts(mut counts) if counts.len() == 1 => {
                counts.pop().map(|(_, numbers)| full(numbers, name, None)).into_iter().collect()
            }
            Content::Counts(counts) => {
                let column = |(id, numbers): (u32, Builder)| full(numbers, unique(&scaler_name(&name, id)), None);
                counts.into_iter().map(column).collect()
            }
            Content::Texts(mut texts) if self.is_kept => {
                texts.resize(rows, String::new());
                vec![Column::new(&name, unit.as_deref(), Cells::Text(texts))]
            }
            Content::Open if rows == 0 && self.is_kept => {
                vec![Column::new(&name, unit.as_deref(), Cells::Numbers(Vec::new()))]
            }
            Content::Open | Content::Skipped | Content::Texts(_) => {
                vec![Column::new(&name, unit.as_deref(), Cells::NotKept)]
            }
            Content::Refused(_) => vec![],
        }
    }
}

impl Scaled {
    /// Scales as many values as there are of everything that is taken.
    fn apply(&mut self, scratch: &mut Scratch) {
        let Self { scaling, raw, scalers, out, numbers, beyond, .. } = self;
        let lengths = scalers.iter().map(Vec::len);
        let count = lengths.chain(scaling.takes_raw().then_some(raw.len())).min().unwrap_or(0);
        if count == 0 {
            return;
        }
        out.clear();
        match scalers.as_slice() {
            [] => scaling.apply(raw, &[], scratch, out),
            [one] => scaling.apply(raw, &[one.get(..count).unwrap_or_default()], scratch, out),
            many => {
                let many: Vec<&[f64]> = many.iter().map(|values| values.get(..count).unwrap_or_default()).collect();
                scaling.apply(raw, &many, scratch, out);
            }
        }
        let first = numbers.len();
        for (i, value) in out.iter_mut().enumerate().filter(|(_, value)| !value.is_finite()) {
            // What was no number before does not become one.
            let is_number = |values: &[f64]| values.get(i).is_none_or(|value| value.is_finite());
            if is_number(raw) && scalers.iter().all(|values| is_number(values)) {
                beyond.add_worded(first + i, 0, || format!("sample {}", first + i));
            }
            *value = f64::NAN;
        }
        numbers.extend(out.iter().copied());
        for values in scalers {
            values.drain(..count);
        }
        raw.drain(..count.min(raw.len()));
    }
}

impl Values<'_> {
    /// The first instant that was set; the beginning of the count stands for none, unless nothing else is there.
    fn first_instant(self) -> Option<Timestamp> {
        let places = self.bytes.chunks_exact(self.stride);
        let mut stamps = places.filter_map(|place| {
            let bytes = place.get(self.offset..)?.first_chunk()?;
            Some(super::types::timestamp(*bytes, self.big_endian))
        });
        let first = stamps.next();
        first.filter(|stamp| stamp.seconds != 0).or_else(|| stamps.find(|stamp| stamp.seconds != 0)).or(first)
    }
}

/// Where the values of a scaler stand among those that a scaling takes.
fn slot(scaling: &Scaling, id: u32) -> Option<usize> {
    scaling.scalers().iter().position(|taken| *taken == id)
}

fn scaler_name(name: &str, id: u32) -> String {
    format!("{name}[{id}]")
}

/// Whether a column of one of the scalers of a channel is asked for.
fn keeps_scaler(keep: Keep, group: &str, name: &str) -> bool {
    let Keep::Only(asked) = keep else { return false };
    let prefix = crate::recording::full_name(group, &format!("{name}["));
    asked.iter().any(|asked| matches!(asked, crate::recording::ColumnRef::Name(asked) if asked.starts_with(&prefix)))
}

/// The unit of a channel: as waveforms and DAQ cards state it.
fn unit(properties: &Properties) -> Option<String> {
    let stated = ["unit_string", "NI_UnitDescription"].into_iter().filter_map(|name| properties.get(name)?.text());
    stated.map(str::trim).find(|unit| !unit.is_empty()).map(str::to_owned)
}

/// Whether a channel of numbers seems to be a clock.
fn seems_clock(name: &str, properties: &Properties) -> Option<ClockUnit> {
    csv::clock_unit(name, unit(properties).as_deref())
}

/// Seconds in one of a unit; `None` where it is none of time.
pub(super) fn seconds_in(unit: &str) -> Option<f64> {
    let (unit, _) = Unit::parse_loose(unit).filter(|(unit, _)| unit.dimension == Dimension::Time)?;
    Some(unit.factor)
}

/// Whether a name is one of a clock.
pub(super) fn is_clock(name: &str) -> bool {
    csv::clock_unit(name, None).is_some()
}

/// Whether a property belongs to a scaling.
pub(super) fn is_of_scaling(name: &str) -> bool {
    name.starts_with("NI_Scal") || name == "NI_Number_Of_Scales"
}

/// A number among properties.
pub(super) fn number(properties: &Properties, name: &str) -> Option<f64> {
    properties.get(name).and_then(Value::number)
}
