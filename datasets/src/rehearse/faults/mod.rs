//! Faults on demand: what goes wrong at rigs, each by name, in one run, with a record of where it lies and what should be found.
//!
//! | file | holds |
//! |---|---|
//! | `mod.rs` | the names, and what a fault hits |
//! | `log.rs` | faults of what is logged |
//! | `bytes.rs` | faults of files |

mod bytes;
mod log;

use serde::Serialize;

use pneuval_ingest::error::suggestion;
use pneuval_ingest::finding::FindingKind;
use pneuval_ingest::formats::Format;
use pneuval_ingest::units::{Dimension, Unit};

use super::bench::Bench;
use super::plan::{Channel, Shows};

pub use bytes::{Layout, line_number, spoil_bytes};
pub use log::spoil_log;

/// What goes wrong.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Fault {
    /// Samples are missing.
    Gap,
    /// Steps of time differ.
    Jitter,
    /// The clock is set back.
    TimeBack,
    /// Stamps repeat.
    DuplicateStamps,
    /// An instrument is silent from some moment on.
    DroppedInstrument,
    /// Two columns stand under each other's names.
    SwappedChannels,
    /// Logged in psi, said to be the rig's unit.
    UnitPsi,
    /// Logged in bar.
    UnitBar,
    /// Logged in Pa.
    UnitPa,
    /// Logged in cm.
    UnitCm,
    /// A hundred times too large.
    Hundredfold,
    /// The other sign.
    WrongSign,
    /// The instrument's range ends too early.
    Saturation,
    /// An instrument stops.
    Flatline,
    /// `NaN` among the numbers.
    NotANumber,
    /// A word among the numbers.
    TextInNumbers,
    /// The file ends too early.
    Truncated,
    /// One bit of the file is wrong.
    FlippedBit,
    /// No line end between the header and the first sample.
    GluedHeader,
    /// A line of text behind the last sample.
    Trailer,
    /// Decimal commas on some lines.
    DecimalComma,
    /// A device's clock is ahead.
    ClockOffset,
    /// A device's clock is fast.
    ClockDrift,
    /// A chamber leaks from some moment on.
    Leak,
    /// The zero slips in the middle.
    SlippedZero,
}

/// Every fault: its name and what it does.
pub const FAULTS: [(&str, Fault, &str); 25] = [
    ("gap", Fault::Gap, "a tenth of the samples is missing in the middle"),
    ("jitter", Fault::Jitter, "steps of time differ by up to nine tenths of a step"),
    ("time-back", Fault::TimeBack, "the clock is set back by 50 steps, once"),
    ("duplicate-stamps", Fault::DuplicateStamps, "ten stamps repeat the one before"),
    ("dropped-instrument", Fault::DroppedInstrument, "an instrument is silent for the last four tenths"),
    ("swapped-channels", Fault::SwappedChannels, "two columns stand under each other's names"),
    ("unit-psi", Fault::UnitPsi, "a pressure is logged in psi under another unit"),
    ("unit-bar", Fault::UnitBar, "a pressure is logged in bar under another unit"),
    ("unit-pa", Fault::UnitPa, "a pressure is logged in Pa under another unit"),
    ("unit-cm", Fault::UnitCm, "a length is logged in cm under another unit"),
    ("x100", Fault::Hundredfold, "a channel is a hundred times too large"),
    ("wrong-sign", Fault::WrongSign, "a channel has the other sign"),
    ("saturation", Fault::Saturation, "an instrument shows nothing above 85 % of the largest reading"),
    ("flatline", Fault::Flatline, "an instrument stops for three tenths of the run"),
    ("nan", Fault::NotANumber, "ten readings are NaN"),
    ("text", Fault::TextInNumbers, "ten readings are the word ERR"),
    ("truncated", Fault::Truncated, "the file ends within its seventh tenth"),
    ("flipped-bit", Fault::FlippedBit, "one bit in the middle of the file is wrong"),
    ("glued-header", Fault::GluedHeader, "the header runs into the first sample"),
    ("trailer", Fault::Trailer, "a line of text stands behind the last sample"),
    ("decimal-comma", Fault::DecimalComma, "twenty lines have decimal commas"),
    ("clock-offset", Fault::ClockOffset, "a device's clock is 0.25 s ahead"),
    ("clock-drift", Fault::ClockDrift, "a device's clock gains 2000 ppm"),
    ("leak", Fault::Leak, "the chamber loses 15 % of its pressure from four tenths on"),
    ("slipped-zero", Fault::SlippedZero, "a channel's zero slips by a tenth of its range in the middle"),
];

/// A fault that is asked for: `flatline`, `flatline@diameter`, `flatline@diameter:run-3`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Asked {
    /// Its name.
    pub name: &'static str,
    /// What.
    pub fault: Fault,
    /// The channel; the one that shows it best if absent.
    pub channel: Option<String>,
    /// The run; the second if absent, of one the first.
    pub run: Option<String>,
}

impl std::str::FromStr for Asked {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (rest, run) = text.split_once(':').map_or((text, None), |(rest, run)| (rest, Some(run.to_owned())));
        let (name, channel) = rest.split_once('@').map_or((rest, None), |(name, id)| (name, Some(id.to_owned())));
        let known = FAULTS.iter().find(|(known, ..)| *known == name);
        let (name, fault, _) = known.ok_or_else(|| suggestion(name, FAULTS.iter().map(|(name, ..)| *name)))?;
        Ok(Self { name, fault: *fault, channel, run })
    }
}

/// Where a fault lies, and what should be found of it.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FaultRecord {
    /// Its name.
    pub fault: &'static str,
    /// The run.
    pub run: String,
    /// The file.
    pub file: String,
    /// The device.
    pub device: String,
    /// The channel, if it hits one.
    pub channel: Option<String>,
    /// First and last sample that it hits, from 0, as they stand in the file.
    pub samples: (usize, usize),
    /// First and last line of the file, for a text.
    pub lines: Option<(usize, usize)>,
    /// The kinds of findings of which one should tell it; none: nothing in the file shows it.
    pub expected: Vec<&'static str>,
}

/// What a fault hits.
#[derive(Debug, Clone, PartialEq)]
pub struct Target {
    /// The device, as an index in the plan.
    pub device: usize,
    /// The channel, as an index in the plan, if it hits one.
    pub channel: Option<usize>,
}

impl Fault {
    /// The kinds of findings that tell it, of which one is enough.
    ///
    /// # Errors
    /// Why it cannot stand in a file of that format.
    pub fn expected(self, format: Format, follows: bool, is_beyond: bool) -> Result<Vec<FindingKind>, &'static str> {
        use FindingKind as K;
        let is_text = !matches!(format, Format::Mcap | Format::Tdms);
        let only_text = |kinds: &[FindingKind]| {
            if is_text { Ok(kinds.to_vec()) } else { Err("numbers are stored in binary: no text, no lines") }
        };
        // A measured pressure is held against its command, everything else against the range of its instrument. What stays within
        // that is seen by nobody who looks at one channel.
        let by_meaning = || {
            let mut kinds = Vec::new();
            if follows {
                kinds.push(K::CommandMismatch);
            }
            if is_beyond {
                kinds.extend([K::OutOfRange, K::OutOfCalibration]);
            }
            Ok(kinds)
        };
        match self {
            Self::Gap => Ok(vec![K::Gap]),
            Self::Jitter => Ok(vec![K::Jitter]),
            Self::TimeBack => Ok(vec![K::TimeReversed]),
            Self::DuplicateStamps => Ok(vec![K::DuplicateStamp]),
            // A gauge without a reading shows an overload.
            Self::DroppedInstrument | Self::NotANumber if format == Format::Gauge => {
                Ok(vec![K::OutOfRange, K::NoValue])
            }
            Self::DroppedInstrument | Self::NotANumber => Ok(vec![K::NoValue, K::EmptyCell, K::NonNumericCell]),
            Self::SwappedChannels
            | Self::UnitPsi
            | Self::UnitBar
            | Self::UnitPa
            | Self::UnitCm
            | Self::Hundredfold
            | Self::WrongSign => by_meaning(),
            Self::Leak | Self::SlippedZero => Ok(if follows { vec![K::CommandMismatch] } else { vec![] }),
            Self::Saturation => Ok(vec![K::Saturated]),
            Self::Flatline => Ok(vec![K::Flatline, K::Saturated]),
            Self::TextInNumbers => only_text(&[K::NonNumericCell, K::SkippedLine, K::RaggedLine, K::NoValue]),
            // A number that is cut may still be one: then the file has no line end.
            Self::Truncated => Ok(vec![K::Truncated, K::CountMismatch, K::CrcMismatch, K::NoLineEnd]),
            Self::FlippedBit => match format {
                Format::Mcap => Ok(vec![K::CrcMismatch]),
                Format::Tdms => Err("the format has no checksum: any bits are a number"),
                _ => Ok(vec![K::NonNumericCell, K::SkippedLine, K::RaggedLine, K::NoValue]),
            },
            Self::GluedHeader => match format {
                Format::Csv => Ok(vec![K::HeaderGlued]),
                _ => Err("its header cannot run into the first sample"),
            },
            Self::Trailer => only_text(&[K::Trailer, K::SkippedLine]),
            Self::DecimalComma => only_text(&[K::RaggedLine, K::NonNumericCell, K::SkippedLine]),
            // No file shows it: `validate` tells a run whose lag is far from that of the others, where one clock is declared.
            Self::ClockOffset | Self::ClockDrift => Ok(vec![K::UnusualLag]),
        }
    }

    /// The factor of a wrong unit, from the unit that is said to the one that is logged.
    fn factor(self, said: Unit) -> f64 {
        let logged = |symbol: &str| Unit::parse(symbol).map_or(1.0, |unit| said.to_si(1.0) / unit.to_si(1.0));
        match self {
            Self::UnitPsi => logged("psi"),
            Self::UnitBar => logged("bar"),
            Self::UnitPa => logged("Pa"),
            Self::UnitCm => logged("cm"),
            Self::Hundredfold => 100.0,
            Self::WrongSign => -1.0,
            _ => 1.0,
        }
    }

    /// What it hits in a sitting.
    ///
    /// # Errors
    /// Why it has nothing to hit.
    pub fn target(self, asked: Option<&str>, bench: &Bench) -> Result<Target, String> {
        let plan = bench.plan;
        let device_of = |channel: &Channel| plan.devices.iter().position(|device| device.id == channel.device);
        let channels = || plan.devices.iter().flat_map(|device| bench.channels_of(device));
        let is_pressure = |channel: &Channel| matches!(channel.shows, Shows::Pressure(_));
        let is_measured = |channel: &Channel| matches!(channel.shows, Shows::Quantity(..));
        let unit_of = |channel: &Channel| {
            let instrument = channel.instrument.as_ref().and_then(|id| bench.rig.instruments.get(id));
            instrument.map(|i| i.input).or(channel.unit)
        };
        let has = |channel: &Channel, dimension: Dimension| unit_of(channel).is_some_and(|u| u.dimension == dimension);
        let fits = |channel: &Channel| match self {
            Self::UnitPsi | Self::UnitBar | Self::UnitPa => is_pressure(channel) && has(channel, Dimension::Pressure),
            Self::UnitCm => is_measured(channel) && has(channel, Dimension::Length),
            // A clock that is off is off beside that of the pressure.
            Self::ClockOffset | Self::ClockDrift => is_measured(channel),
            Self::Leak | Self::SlippedZero | Self::FlippedBit | Self::DecimalComma => is_pressure(channel),
            _ if self.is_of_device() => is_pressure(channel),
            Self::SwappedChannels => {
                is_pressure(channel)
                    && channels()
                        .any(|(_, other)| other.device == channel.device && !is_pressure(other) && is_live(other))
            }
            _ => is_measured(channel),
        };
        let found = match asked {
            Some(id) => {
                let known = || channels().map(|(_, channel)| channel.id.as_str());
                let named = channels().find(|(_, channel)| channel.id == id);
                let named = named.ok_or_else(|| format!("no channel `{id}`: {}", suggestion(id, known())))?;
                let is_hit = self.is_of_device() || is_live(named.1) && self.may_hit(named.1, bench, unit_of(named.1));
                named_or(is_hit.then_some(named), id)?
            }
            None => channels()
                .find(|(_, channel)| fits(channel))
                .ok_or_else(|| "no channel in this sitting that it could hit".to_owned())?,
        };
        // Every channel names a device that is there: the plan is checked for it.
        let device = device_of(found.1).ok_or("no device")?;
        let channel = (!self.is_of_device()).then_some(found.0);
        Ok(Target { device, channel })
    }

    /// Whether it makes sense on a channel that shows readings.
    fn may_hit(self, channel: &Channel, bench: &Bench, unit: Option<Unit>) -> bool {
        let has = |dimension: Dimension| unit.is_some_and(|unit| unit.dimension == dimension);
        match self {
            Self::Leak => matches!(channel.shows, Shows::Pressure(_)),
            Self::UnitPsi | Self::UnitBar | Self::UnitPa => has(Dimension::Pressure),
            Self::UnitCm => has(Dimension::Length),
            Self::SwappedChannels => {
                let channels = bench.plan.channels.iter();
                channels.filter(|other| other.device == channel.device && is_live(other)).count() > 1
            }
            _ => true,
        }
    }

    /// Whether it hits a whole device or file.
    fn is_of_device(self) -> bool {
        matches!(
            self,
            Self::Gap
                | Self::Jitter
                | Self::TimeBack
                | Self::DuplicateStamps
                | Self::Truncated
                | Self::GluedHeader
                | Self::Trailer
                | Self::ClockOffset
                | Self::ClockDrift
        )
    }
}

/// A channel that was found, or why it cannot be hit.
fn named_or<T>(found: Option<T>, id: &str) -> Result<T, String> {
    found.ok_or_else(|| format!("channel `{id}`, on which it would show nothing"))
}

/// Whether a channel shows readings: no command, no condition that somebody set, no trigger.
fn is_live(channel: &Channel) -> bool {
    matches!(channel.shows, Shows::Pressure(_) | Shows::Quantity(..))
}
