//! What logs beside the runs' `file`: devices that each write a file of their own.

use std::collections::{BTreeMap, HashSet};

use serde::Deserialize;
use toml::Spanned;

use super::raw::{RawClock, RawDerived, RawReader, RawRun};
use super::{ChannelSpec, ClockSpec, DerivedSpec, RunSpec, SessionManifest};
use crate::document::Document;
use crate::error::{IngestError, shown, suggestion};
use crate::formats::Options;
use crate::manifest::{check_id, check_inside};

/// A device that logs beside the runs' `file`.
#[derive(Debug, Clone, PartialEq)]
pub struct DeviceSpec {
    /// Its id.
    pub id: String,
    /// How its files are written.
    pub reader: Options,
    /// Where its time comes from; as [`SessionManifest::clock`].
    pub clock: Option<ClockSpec>,
    /// Line of the file.
    pub line: usize,
}

/// What is known of the clocks of a sitting.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Clocks {
    /// Nothing: what was stamped by different clocks is not set against each other.
    #[default]
    #[serde(skip)]
    Unsaid,
    /// Every stamp counts from one clock.
    One,
}

/// A file that runs name.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct LogFile<'a> {
    /// Inside the session's folder.
    pub name: &'a str,
    /// The device that wrote it; `None`: it is the `file` of a run.
    pub device: Option<&'a str>,
    /// Line of the first run that names it.
    pub line: usize,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawDevice {
    id: Spanned<String>,
    #[serde(default)]
    reader: RawReader,
    clock: Option<Spanned<RawClock>>,
}

pub(super) fn devices(document: &Document, raw: &[RawDevice]) -> Result<Vec<DeviceSpec>, IngestError> {
    let mut devices: Vec<DeviceSpec> = Vec::new();
    for device in raw {
        let id = check_id(document, &device.id)?;
        if devices.iter().any(|other| other.id == id) {
            let found = format!("`{id}` twice");
            return Err(document.malformed(device.id.span(), "every device once", found, "rename one"));
        }
        devices.push(DeviceSpec {
            id,
            reader: device.reader.options(document)?,
            clock: device.clock.as_ref().map(|clock| clock.get_ref().checked(document, clock)).transpose()?,
            line: document.line_of(device.id.span().start),
        });
    }
    Ok(devices)
}

/// A device that is declared.
pub(super) fn known(document: &Document, devices: &[DeviceSpec], id: &Spanned<String>) -> Result<String, IngestError> {
    let known = || devices.iter().map(|device| device.id.as_str());
    if known().any(|known| known == id.get_ref()) {
        return Ok(id.get_ref().clone());
    }
    let next = if devices.is_empty() {
        "add a [[device]] of that id, or remove it".to_owned()
    } else {
        suggestion(id.get_ref(), known())
    };
    Err(document.malformed(id.span(), "the id of a [[device]]", shown(id.get_ref()), next))
}

/// A device is there for its channels, and so is `file`: what nothing is taken from is a `device` forgotten at a channel.
pub(super) fn check_used(
    document: &Document,
    devices: &[DeviceSpec],
    channels: &[ChannelSpec],
    session: &Spanned<String>,
) -> Result<(), IngestError> {
    let is_used = |id: Option<&str>| channels.iter().any(|channel| channel.device.as_deref() == id);
    if let Some(device) = devices.iter().find(|device| !is_used(Some(&device.id))) {
        let expected = format!("a channel of device `{}`", device.id);
        let next = format!("add device = \"{}\" to its channels, or remove the device", device.id);
        return Err(document.malformed_at(device.line, expected, "none", next));
    }
    if !devices.is_empty() && !is_used(None) {
        let next = "make one of the devices the `file` of the runs: its `reader` and `clock` are [reader] and [clock]";
        return Err(document.malformed(
            session.span(),
            "a channel of the runs' `file`",
            "channels of devices only",
            next,
        ));
    }
    Ok(())
}

/// Samples of two files do not belong together by their number.
pub(super) fn check_derived(
    document: &Document,
    raw: &[RawDerived],
    channels: &[ChannelSpec],
    derived: &[DerivedSpec],
) -> Result<(), IngestError> {
    for (raw, spec) in raw.iter().zip(derived) {
        let of = |id: &String| device_of(channels, derived, id);
        if spec.from.windows(2).all(|pair| of(&pair[0]) == of(&pair[1])) {
            continue;
        }
        let name = |id: &String| format!("`{id}` of {}", of(id).unwrap_or("`file`"));
        let found = spec.from.iter().map(name).collect::<Vec<_>>().join(", ");
        let next = "derive it from channels of one device: samples of two files have no partners";
        return Err(document.malformed(raw.from.span(), "channels of one device", found, next));
    }
    Ok(())
}

/// The device of a channel, or of the first of those it is derived from.
pub(super) fn device_of<'a>(channels: &'a [ChannelSpec], derived: &'a [DerivedSpec], id: &str) -> Option<&'a str> {
    let mut id = id;
    // A derived channel names channels above it only.
    while let Some(spec) = derived.iter().find(|spec| spec.id == id) {
        id = spec.from.first()?;
    }
    channels.iter().find(|channel| channel.id == id)?.device.as_deref()
}

/// Every run has a file of each device, and no other run has it too.
pub(super) fn check_files(document: &Document, devices: &[DeviceSpec], raw: &[RawRun]) -> Result<(), IngestError> {
    let mut named: BTreeMap<&str, usize> = BTreeMap::new();
    let line_of = |file: &Spanned<String>| document.line_of(file.span().start);
    for run in raw {
        // Runs may share it: `rows` says which part is whose.
        named.entry(run.file.get_ref()).or_insert_with(|| line_of(&run.file));
    }
    for run in raw {
        for (device, file) in &run.files {
            known(document, devices, device)?;
            check_inside(document, file)?;
            if let Some(line) = named.insert(file.get_ref(), line_of(file)) {
                let found = format!("{}, which line {line} names too", shown(file.get_ref()));
                let next = "name the file that the device wrote in this run; a file of several runs is to be split";
                return Err(document.malformed(file.span(), "a file of its own", found, next));
            }
        }
        let has = |device: &&DeviceSpec| run.files.keys().any(|id| *id.get_ref() == device.id);
        if let Some(device) = devices.iter().find(|device| !has(device)) {
            let expected = format!("a file of device `{}` in every run", device.id);
            let next = format!("add files = {{ {} = \"…\" }} to the run", device.id);
            return Err(document.malformed(run.file.span(), expected, "none", next));
        }
    }
    Ok(())
}

/// A session as each of its devices sees it: its channels, its reader and clock, runs whose `file` is its own.
#[derive(Debug, Clone, PartialEq)]
pub struct Views {
    file: SessionManifest,
    devices: Vec<(String, SessionManifest)>,
}

impl Views {
    /// What the device sees that wrote a log.
    pub fn of(&self, log: LogFile) -> &SessionManifest {
        let of_device = self.devices.iter().find(|(device, _)| Some(device.as_str()) == log.device);
        of_device.map_or(&self.file, |(_, view)| view)
    }
}

impl SessionManifest {
    /// The files that runs name, each once: of every run first its `file`, then those of the devices in their order.
    pub fn logs(&self) -> Vec<LogFile<'_>> {
        let mut logs: Vec<LogFile> = Vec::new();
        let mut seen = HashSet::new();
        for RunSpec { file, files, line, .. } in &self.runs {
            let of_devices =
                self.devices.iter().filter_map(|device| Some((Some(device.id.as_str()), files.get(&device.id)?)));
            for (device, name) in std::iter::once((None, file)).chain(of_devices) {
                if seen.insert(name.as_str()) {
                    logs.push(LogFile { name, device, line: *line });
                }
            }
        }
        logs
    }

    /// The device of an id.
    pub fn device(&self, id: &str) -> Option<&DeviceSpec> {
        self.devices.iter().find(|device| device.id == id)
    }

    /// The device that a channel comes from; `None` where that is `file`.
    pub fn device_of(&self, channel: &str) -> Option<&str> {
        device_of(&self.channels, &self.derived, channel)
    }

    /// The session as `file` sees it and as each device does.
    pub fn views(&self) -> Views {
        let devices = self.devices.iter().map(|device| (device.id.clone(), self.of_device(Some(&device.id))));
        Views { file: self.of_device(None), devices: devices.collect() }
    }

    fn of_device(&self, device: Option<&str>) -> Self {
        let is_of = |id: &str| self.device_of(id) == device;
        let mut view = self.clone();
        view.channels.retain(|channel| channel.device.as_deref() == device);
        view.derived.retain(|derived| is_of(&derived.id));
        if let Some(spec) = device.and_then(|id| self.device(id)) {
            (view.reader, view.clock) = (spec.reader.clone(), spec.clock.clone());
        }
        view.devices.clear();
        for run in &mut view.runs {
            run.zero.retain(|channel, _| is_of(channel));
            let files = std::mem::take(&mut run.files);
            if let Some(id) = device {
                (run.file, run.rows) = (files.get(id).cloned().unwrap_or_default(), None);
            }
        }
        view
    }
}
