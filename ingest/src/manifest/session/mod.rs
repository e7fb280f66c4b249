//! `session.toml`: one sitting at a rig: which files, which column is which channel, what is measured against what.

mod camera;
mod device;
mod follows;
mod points;
mod raw;
mod sync;

use std::collections::BTreeMap;

use serde::Deserialize;

pub use device::{Clocks, DeviceSpec, LogFile, Views};
pub use follows::Follows;
use follows::check_follows;
pub use points::{Abscissa, Matching, PointRule, TrajectoryRule};
pub use raw::channel_id;
use raw::{Raw, responses, runs};
pub(in crate::manifest) use raw::{RawColumn, RawReader, column_ref};
pub use sync::{LagMeaning, SyncEvent, SyncSpec};

use super::comparison::{Comparable, ComparisonSpec, Quantity, comparisons};
use super::{check_id, check_schema};
use crate::digest;
use crate::document::Document;
use crate::error::{IngestError, shown};
use crate::formats::Options;
pub use crate::formats::mcap::Stamp;
pub use crate::recording::ColumnRef;
use crate::units::{Dimension, Unit};

/// What `pneuval init` writes where only the user knows.
pub const TO_FILL_IN: &str = "FILL-IN";

/// Excluded samples above this share of those read leave a session open, unless it declares another share.
const EXCLUDED_SHARE_MAX: f64 = 0.05;

/// A session as the user wrote it.
#[derive(Debug, Clone, PartialEq)]
pub struct SessionManifest {
    /// Its id.
    pub id: String,
    /// The actuator it was taken on.
    pub actuator: String,
    /// Its name on pages.
    pub title: String,
    /// The rig, if channels name instruments.
    pub rig: Option<String>,
    /// When, in the user's words.
    pub date: Option<String>,
    /// Who.
    pub operator: Option<String>,
    /// Written by a program, not by a rig: said on every page.
    pub synthetic: bool,
    /// What was tested.
    pub specimen: Option<Specimen>,
    /// Sentences for the page.
    pub notes: Vec<String>,
    /// The share of samples that may be excluded before the session is left open.
    pub excluded_share_max: f64,
    /// How logs are written; what is absent is found out from the file.
    pub reader: Options,
    /// Where time comes from; without it the file's own clock counts, and where there is none, rows are states, not moments.
    pub clock: Option<ClockSpec>,
    /// What logged beside the runs' `file`, in the order of the manifest.
    pub devices: Vec<DeviceSpec>,
    /// Whether the stamps of all files may be set against each other.
    pub clocks: Clocks,
    /// Events that several devices recorded.
    pub syncs: Vec<SyncSpec>,
    /// What the lag between pressure and motion is, where there are no events.
    pub lag: LagMeaning,
    /// Channels, in the order of the file.
    pub channels: Vec<ChannelSpec>,
    /// Channels computed from others.
    pub derived: Vec<DerivedSpec>,
    /// Logs.
    pub runs: Vec<RunSpec>,
    /// What is measured against pressure.
    pub responses: Vec<ResponseSpec>,
    /// What is compared; empty: every model of every response.
    pub comparisons: Vec<ComparisonSpec>,
    /// The file as the user named it.
    pub file: String,
    /// SHA-256 of the file.
    pub sha256: String,
}

/// What was tested.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Specimen {
    /// Which one.
    pub serial: String,
    /// Batch of its material.
    pub material_batch: Option<String>,
    /// How it was cured.
    pub cure: Option<String>,
    /// Load cycles it had seen before.
    pub cycles_before: Option<u64>,
}

/// Where time comes from.
#[derive(Debug, Clone, PartialEq)]
pub enum ClockSpec {
    /// A column of stamps.
    Column {
        /// Which.
        column: ColumnRef,
        /// Its unit; the file's where absent.
        unit: Option<Unit>,
        /// A counter starts anew from zero behind this time, in s.
        wrap_s: Option<f64>,
        /// Line of the file.
        line: usize,
    },
    /// A stated rate, in Hz.
    Rate(f64),
    /// One of the stamps that every message of a bag has.
    Stamp(Stamp, usize),
}

/// Gauge or absolute.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum PressureReference {
    /// Against the atmosphere.
    Gauge,
    /// Against vacuum; the run says the atmospheric pressure.
    Absolute,
}

/// A column that is a channel.
#[derive(Debug, Clone, PartialEq)]
pub struct ChannelSpec {
    /// Its id.
    pub id: String,
    /// The device whose file holds it; absent: the run's `file`.
    pub device: Option<String>,
    /// Which column.
    pub column: ColumnRef,
    /// Unit of what is logged; the instrument's or the file's where absent.
    pub unit: Option<Unit>,
    /// The instrument of the rig that calibrates it.
    pub instrument: Option<String>,
    /// For a pressure: against what.
    pub reference: Option<PressureReference>,
    /// For a pressure: asked of the regulator, not measured.
    pub commanded: bool,
    /// The mean of so many samples at the start is taken as zero.
    pub tare_samples: Option<usize>,
    /// The commanded channel that it should meet.
    pub follows: Option<Follows>,
    /// Line of the file.
    pub line: usize,
}

/// A channel computed from others.
#[derive(Debug, Clone, PartialEq)]
pub struct DerivedSpec {
    /// Its id.
    pub id: String,
    /// How.
    pub rule: DerivedRule,
    /// From which channels.
    pub from: Vec<String>,
    /// The unit it is shown in.
    pub unit: Unit,
    /// Line of the file.
    pub line: usize,
}

/// How a derived channel is computed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum DerivedRule {
    /// First minus second.
    Difference,
    /// Contact pressure × contact area, a force.
    Product,
    /// Length of the way from the first position to the present one: `|r - r0|`, from two or three coordinates.
    Displacement,
    /// Change of the distance from the transmitter: `|r| - |r0|`, from two or three coordinates.
    TransmitterDistance,
}

/// A log, or a part of one.
#[derive(Debug, Clone, PartialEq)]
pub struct RunSpec {
    /// Its id.
    pub id: String,
    /// File inside the session's folder.
    pub file: String,
    /// The file of each device, inside the session's folder.
    pub files: BTreeMap<String, String>,
    /// Rows of `file` that belong to it: those with this text in this column.
    pub rows: Option<(ColumnRef, String)>,
    /// Atmospheric pressure, where a channel is absolute, in Pa.
    pub atmosphere_pa: Option<f64>,
    /// What channels read when the instruments were set to zero before this run: channel, value, unit. Subtracted.
    pub zero: BTreeMap<String, (f64, Unit)>,
    /// Line of the manifest.
    pub line: usize,
}

/// A quantity measured against pressure.
#[derive(Debug, Clone, PartialEq)]
pub struct ResponseSpec {
    /// What.
    pub quantity: Quantity,
    /// Channel and chamber; none where the points are those of a path at equal time or arc length.
    pub pressure: Vec<(String, String)>,
    /// Channels of the components.
    pub measured: Vec<String>,
    /// How it was measured.
    pub method: String,
    /// What is read at zero pressure before the first rise of a run is taken as its zero.
    pub tare_at_zero: bool,
    /// Which cycles are compared, if the session says so.
    pub cycles: Option<Cycles>,
    /// Whether loading and unloading are kept apart.
    pub branches: Branches,
    /// Channel and id of what is set beside the pressure.
    pub conditions: Vec<ConditionSpec>,
    /// How samples become points.
    pub points: PointRule,
    /// Gauge pressures so near zero are the zero-pressure reference, in Pa; 0.5 % of the largest pressure where absent.
    pub zero_within_pa: Option<f64>,
    /// Line of the file.
    pub line: usize,
}

impl ResponseSpec {
    /// The channels that say at which state something was measured: pressures and conditions.
    pub fn state_channels(&self) -> impl Iterator<Item = &str> {
        let pressures = self.pressure.iter().map(|(channel, _)| channel.as_str());
        pressures.chain(self.conditions.iter().map(|condition| condition.channel.as_str()))
    }

    /// The channels that it needs: pressures, what is measured, conditions.
    pub fn channels(&self) -> impl Iterator<Item = &str> {
        let pressures = self.pressure.iter().map(|(channel, _)| channel.as_str());
        let conditions = self.conditions.iter().map(|condition| condition.channel.as_str());
        pressures.chain(self.measured.iter().map(String::as_str)).chain(conditions)
    }
}

/// A channel that is set beside the pressure.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ConditionSpec {
    /// The channel.
    pub channel: String,
    /// Its id, as the model's input.
    pub id: String,
    /// Its name on pages.
    pub title: String,
}

/// Which cycles of the pressure are compared with a model.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Cycles {
    /// Those behind the first, where there are any: soft materials are stiffer in their first cycle.
    #[default]
    Conditioned,
    /// The first alone.
    First,
    /// All, the first among them.
    All,
}

/// Whether loading and unloading are kept apart.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Branches {
    /// What was read on the way up meets what was read on the way up: soft materials have hysteresis.
    #[default]
    Apart,
    /// The order of the readings means nothing, as where states were visited at random.
    Together,
}

impl SessionManifest {
    /// Reads a session file.
    ///
    /// # Errors
    /// [`IngestError::Malformed`] with line and key.
    pub fn read(file: &str, bytes: &[u8]) -> Result<Self, IngestError> {
        let document = Document::new(file, bytes)?;
        let raw: Raw = document.parse()?;
        check_schema(&document, &raw.schema)?;
        let id = check_id(&document, &raw.id)?;
        if raw.actuator.get_ref() == TO_FILL_IN {
            let next = "write the id of an actuator: `pneuval models` lists the embedded types, or invent one and describe it in actuator.toml";
            return Err(document.malformed(raw.actuator.span(), "an actuator's id", shown(TO_FILL_IN), next));
        }
        let actuator = check_id(&document, &raw.actuator)?;
        let devices = device::devices(&document, &raw.device)?;
        let mut ids: Vec<String> = Vec::new();
        let channels = raw
            .channel
            .iter()
            .map(|channel| channel.checked(&document, &devices, &mut ids))
            .collect::<Result<Vec<_>, IngestError>>()?;
        check_follows(&document, &channels)?;
        if let Some(channel) = channels.iter().find(|c| c.instrument.is_some())
            && raw.rig.is_none()
        {
            let next = "add rig = \"…\", the id of a rig.toml here or above";
            return Err(document.malformed_at(channel.line, "key `rig` of the session", "nothing", next));
        }
        device::check_used(&document, &devices, &channels, &raw.id)?;
        // Before derived ones are added: a zero is set at an instrument.
        let runs = runs(&document, &raw.run, &raw.id, &ids, &devices)?;
        let derived = raw
            .derived
            .iter()
            .map(|derived| derived.checked(&document, &mut ids))
            .collect::<Result<Vec<_>, IngestError>>()?;
        device::check_derived(&document, &raw.derived, &channels, &derived)?;
        let syncs = sync::syncs(&document, &raw.sync, &channels, &derived)?;
        sync::check_clocks(&document, raw.clocks, raw.lag.as_ref(), &syncs)?;
        let responses = responses(&document, &raw.response, &ids)?;
        let comparable: Vec<Comparable> = responses
            .iter()
            .map(|r| Comparable { quantity: &r.quantity.id, width: r.quantity.width(), columns: vec![] })
            .collect();
        let comparisons = comparisons(&document, &raw.comparison, &comparable)?;
        let excluded =
            raw.excluded_max.as_ref().map(|share| share.not_negative(&document, Dimension::Ratio)).transpose()?;
        Ok(Self {
            title: raw.title.unwrap_or_else(|| id.clone()),
            id,
            actuator,
            rig: raw.rig.as_ref().map(|rig| check_id(&document, rig)).transpose()?,
            date: raw.date,
            operator: raw.operator,
            synthetic: raw.synthetic,
            specimen: raw.specimen,
            notes: raw.notes,
            excluded_share_max: excluded.unwrap_or(EXCLUDED_SHARE_MAX),
            reader: raw.reader.options(&document)?,
            clock: raw.clock.as_ref().map(|clock| clock.get_ref().checked(&document, clock)).transpose()?,
            devices,
            clocks: raw.clocks,
            syncs,
            lag: raw.lag.as_ref().map_or(LagMeaning::Unsaid, |lag| *lag.get_ref()),
            channels,
            derived,
            runs,
            responses,
            comparisons,
            file: file.to_owned(),
            sha256: digest::sha256(bytes),
        })
    }

    /// The column of the clock, if it is one.
    pub fn clock_column(&self) -> Option<&ColumnRef> {
        match &self.clock {
            Some(ClockSpec::Column { column, .. }) => Some(column),
            _ => None,
        }
    }

    /// The channels that responses need, with those behind derived ones.
    pub fn required(&self) -> Vec<&str> {
        let mut needed: Vec<&str> = Vec::new();
        for response in &self.responses {
            needed.extend(response.channels());
        }
        // Derived channels come from channels before them.
        for derived in self.derived.iter().rev() {
            if needed.contains(&derived.id.as_str()) {
                needed.extend(derived.from.iter().map(String::as_str));
            }
        }
        needed.sort_unstable();
        needed.dedup();
        needed
    }
}
