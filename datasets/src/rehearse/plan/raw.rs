//! A plan as it is written, and the way from there to what is checked.

use serde::Deserialize;
use toml::Spanned;

use pneuval_ingest::IngestError;
use pneuval_ingest::document::{Amount, Document, parse_unit};
use pneuval_ingest::error::{shown, suggestion};
use pneuval_ingest::formats::Format;
use pneuval_ingest::manifest::{
    Comparable, RawComparison, RawQuantity, channel_id, check_id, check_schema, comparisons,
};
use pneuval_ingest::units::Dimension;

use super::camera::RawCamera;
use super::{
    Channel, Deviation, Device, Plan, Programme, ProgrammeKind, Regulator, Response, Setting, Shows, Sitting, Specimen,
    Tensile, Truth,
};

/// No pressure takes longer to move what it moves.
const DELAY_MAX_S: f64 = 60.0;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Raw {
    schema: Spanned<i64>,
    id: Spanned<String>,
    actuator: Spanned<String>,
    title: String,
    rig: Spanned<String>,
    regulator: RawRegulator,
    specimen: RawSpecimen,
    #[serde(default)]
    device: Vec<RawDevice>,
    #[serde(default)]
    channel: Vec<RawChannel>,
    #[serde(default)]
    sitting: Vec<RawSitting>,
    #[serde(default)]
    tensile: Vec<RawTensile>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawTensile {
    material: Spanned<String>,
    strips: Spanned<usize>,
    length: Amount,
    width: Amount,
    thickness: Amount,
    /// Way of the machine in a minute.
    per_minute: Amount,
    stretch_max: Spanned<f64>,
    rate: Amount,
    force_noise: Amount,
    displacement_noise: Amount,
    spread: Amount,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawRegulator {
    time_constant: Amount,
    droop: Amount,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawSpecimen {
    #[serde(default)]
    creep: Vec<RawCreep>,
    hysteresis: Option<Amount>,
    residual: Option<Amount>,
    softening: Option<Amount>,
    softening_cycles: Option<Spanned<f64>>,
    #[serde(default)]
    cycles_before: u64,
    spread: Option<Amount>,
    repeat: Option<Amount>,
    delay: Option<Amount>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawCreep {
    share: Amount,
    time: Amount,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawDevice {
    id: Spanned<String>,
    format: Spanned<String>,
    rate: Amount,
    decimals: Option<Spanned<usize>>,
    offset: Option<Amount>,
    /// Microseconds per second.
    drift_ppm: Option<Spanned<f64>>,
    jitter: Option<Amount>,
    camera: Option<RawCamera>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawChannel {
    id: Spanned<String>,
    device: Spanned<String>,
    shows: Spanned<RawShows>,
    instrument: Option<String>,
    unit: Option<Spanned<String>>,
    noise: Option<Amount>,
    /// Per hour.
    drift: Option<Amount>,
    decimals: Spanned<usize>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields, rename_all = "lowercase")]
enum RawShows {
    Command(String),
    Pressure(String),
    Quantity(String),
    Component { quantity: String, index: usize },
    Condition(String),
    Trigger,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawSitting {
    id: Spanned<String>,
    title: String,
    programme: RawProgramme,
    #[serde(default)]
    response: Vec<RawResponse>,
    #[serde(default)]
    comparison: Vec<RawComparison>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawProgramme {
    kind: RawKind,
    chambers: Spanned<Vec<String>>,
    levels: Option<Spanned<RawLevels>>,
    rest: Amount,
    rise: Amount,
    hold: Amount,
    #[serde(default)]
    unload: bool,
    cycles: Option<Spanned<usize>>,
    window: Amount,
    tolerance: Amount,
}

#[derive(Deserialize)]
#[serde(rename_all = "kebab-case")]
enum RawKind {
    Steps,
    Ramp,
    Sine,
    Cycles,
}

/// `{ values = [10, 20], unit = "kPa" }`, of several chambers `[[10, 0], [20, 0]]`.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawLevels {
    values: Vec<OneOrSeveral>,
    unit: Spanned<String>,
}

#[derive(Deserialize)]
#[serde(untagged, expecting = "a pressure, or one per chamber in brackets")]
enum OneOrSeveral {
    One(f64),
    Several(Vec<f64>),
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawResponse {
    quantity: RawQuantity,
    chambers: Vec<String>,
    measured: Spanned<Vec<String>>,
    method: String,
    #[serde(default)]
    condition: Vec<RawSetting>,
    truth: Spanned<RawTruth>,
    deviation: Option<Spanned<RawDeviation>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawSetting {
    channel: String,
    id: Spanned<String>,
    title: String,
    values: Option<RawValues>,
    #[serde(default)]
    per_run: bool,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawValues {
    values: Vec<f64>,
    unit: Spanned<String>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
enum RawTruth {
    #[serde(rename = "published")]
    Published,
    #[serde(rename = "form")]
    Form(String),
    #[serde(rename = "file")]
    File(String),
    #[serde(rename = "sum")]
    Sum(Vec<String>),
}

/// `{ each = [..], unit }`, or `{ max, rmse }`.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawDeviation {
    each: Option<Vec<f64>>,
    unit: Option<Spanned<String>>,
    max: Option<Amount>,
    rmse: Option<Amount>,
}

impl Raw {
    pub fn checked(&self, document: &Document) -> Result<Plan, IngestError> {
        check_schema(document, &self.schema)?;
        let id = check_id(document, &self.id)?;
        let regulator = Regulator {
            time_constant_s: self.regulator.time_constant.not_negative(document, Dimension::Time)?,
            droop: share(document, &self.regulator.droop)?,
        };
        let mut devices: Vec<Device> = Vec::new();
        for raw in &self.device {
            let device = raw.checked(document)?;
            once(document, &raw.id, devices.iter().any(|known| known.id == device.id))?;
            devices.push(device);
        }
        if devices.is_empty() {
            let next = "add what logs: [[device]] with id, format and rate";
            return Err(document.malformed(self.id.span(), "at least one [[device]]", "none", next));
        }
        let mut channels: Vec<Channel> = Vec::new();
        for raw in &self.channel {
            let channel = raw.checked(document, &devices)?;
            once(document, &raw.id, channels.iter().any(|known| known.id == channel.id))?;
            channels.push(channel);
        }
        let mut sittings: Vec<Sitting> = Vec::new();
        for raw in &self.sitting {
            let sitting = raw.checked(document, &channels)?;
            once(document, &raw.id, sittings.iter().any(|known| known.id == sitting.id))?;
            sittings.push(sitting);
        }
        if sittings.is_empty() {
            let next = "add what is done: [[sitting]] with a programme and responses";
            return Err(document.malformed(self.id.span(), "at least one [[sitting]]", "none", next));
        }
        Ok(Plan {
            id,
            actuator: check_id(document, &self.actuator)?,
            title: self.title.clone(),
            rig: check_id(document, &self.rig)?,
            regulator,
            specimen: self.specimen.checked(document)?,
            devices,
            channels,
            sittings,
            tensile: self.tensile.iter().map(|raw| raw.checked(document)).collect::<Result<_, _>>()?,
            file: document.file().to_owned(),
        })
    }
}

/// Every id once.
fn once(document: &Document, id: &Spanned<String>, is_known: bool) -> Result<(), IngestError> {
    if is_known {
        let found = format!("{} twice", shown(id.get_ref()));
        return Err(document.malformed(id.span(), "every id once", found, "rename one"));
    }
    Ok(())
}

/// Decimals of stamps that are not said: a tenth of a millisecond.
const STAMP_DECIMALS: usize = 4;

/// A count up to a limit.
fn at_most(document: &Document, count: &Spanned<usize>, most: usize) -> Result<usize, IngestError> {
    if *count.get_ref() <= most {
        return Ok(*count.get_ref());
    }
    let found = count.get_ref().to_string();
    Err(document.malformed(count.span(), format!("at most {most}"), found, "correct it"))
}

/// A share from 0 to less than 1.
pub(super) fn share(document: &Document, amount: &Amount) -> Result<f64, IngestError> {
    let share = amount.not_negative(document, Dimension::Ratio)?;
    if share < 1.0 {
        return Ok(share);
    }
    Err(document.malformed(amount.span(), "a share below 1", share.to_string(), "correct it"))
}

impl RawSpecimen {
    fn delay(&self, document: &Document) -> Result<f64, IngestError> {
        let Some(delay) = &self.delay else { return Ok(0.0) };
        let delay_s = delay.not_negative(document, Dimension::Time)?;
        if delay_s <= DELAY_MAX_S {
            return Ok(delay_s);
        }
        let expected = format!("at most {DELAY_MAX_S} s");
        Err(document.malformed(delay.span(), expected, format!("{delay_s} s"), "shorten it"))
    }

    fn checked(&self, document: &Document) -> Result<Specimen, IngestError> {
        let or_none = |amount: &Option<Amount>| amount.as_ref().map_or(Ok(0.0), |amount| share(document, amount));
        let mut creep = Vec::new();
        for raw in &self.creep {
            creep.push((share(document, &raw.share)?, raw.time.checked(document, Dimension::Time)?));
            if creep.iter().map(|(share, _)| share).sum::<f64>() >= 1.0 {
                let next = "what comes at once is what the shares leave";
                return Err(document.malformed(raw.share.span(), "shares whose sum is below 1", "1 or more", next));
            }
        }
        let softening_cycles = match &self.softening_cycles {
            None => 1.0,
            Some(cycles) if *cycles.get_ref() > 0.0 && cycles.get_ref().is_finite() => *cycles.get_ref(),
            Some(cycles) => {
                let found = cycles.get_ref().to_string();
                return Err(document.malformed(cycles.span(), "a finite number > 0", found, "correct it"));
            }
        };
        Ok(Specimen {
            creep,
            hysteresis: or_none(&self.hysteresis)?,
            residual: or_none(&self.residual)?,
            softening: or_none(&self.softening)?,
            softening_cycles,
            cycles_before: self.cycles_before,
            spread: or_none(&self.spread)?,
            repeat: or_none(&self.repeat)?,
            delay_s: self.delay(document)?,
        })
    }
}

impl RawDevice {
    fn checked(&self, document: &Document) -> Result<Device, IngestError> {
        let name = self.format.get_ref();
        let known = |format: &Format| !matches!(format, Format::Plus | Format::Transposed);
        let Some(format) = Format::ALL.into_iter().filter(known).find(|format| format.id() == name) else {
            let next = suggestion(name, Format::ALL.into_iter().filter(known).map(Format::id));
            return Err(document.malformed(self.format.span(), "a format that a device writes", shown(name), next));
        };
        let camera = self.camera.as_ref().map(|camera| camera.checked(document)).transpose()?;
        if camera.is_some() != (format == Format::Pictures) {
            let next = "add [device.camera] to a device of `pictures`, and to no other";
            return Err(document.malformed(self.format.span(), "pictures of a camera", shown(name), next));
        }
        let seconds = |amount: &Option<Amount>| {
            amount.as_ref().map_or(Ok(0.0), |amount| amount.signed(document, Dimension::Time))
        };
        let drift = match &self.drift_ppm {
            Some(drift) if !drift.get_ref().is_finite() || drift.get_ref().abs() > 1e5 => {
                let found = drift.get_ref().to_string();
                return Err(document.malformed(drift.span(), "a drift within 100000 ppm", found, "correct it"));
            }
            drift => drift.as_ref().map_or(0.0, |drift| drift.get_ref() * 1e-6),
        };
        Ok(Device {
            id: check_id(document, &self.id)?,
            format,
            rate_hz: self.rate.checked(document, Dimension::Frequency)?,
            decimals: self.decimals.as_ref().map_or(Ok(STAMP_DECIMALS), |d| at_most(document, d, 9))?,
            offset_s: seconds(&self.offset)?,
            drift,
            jitter_s: self.jitter.as_ref().map_or(Ok(0.0), |jitter| jitter.not_negative(document, Dimension::Time))?,
            camera,
            line: document.line_of(self.id.span().start),
        })
    }
}

impl RawChannel {
    fn checked(&self, document: &Document, devices: &[Device]) -> Result<Channel, IngestError> {
        let device = self.device.get_ref();
        if devices.iter().all(|known| known.id != *device) {
            let next = suggestion(device, devices.iter().map(|known| known.id.as_str()));
            return Err(document.malformed(self.device.span(), "a [[device]] above", shown(device), next));
        }
        let shows = match self.shows.get_ref() {
            RawShows::Command(chamber) => Shows::Command(chamber.clone()),
            RawShows::Pressure(chamber) => Shows::Pressure(chamber.clone()),
            RawShows::Quantity(quantity) => Shows::Quantity(quantity.clone(), 0),
            RawShows::Component { quantity, index } => Shows::Quantity(quantity.clone(), *index),
            RawShows::Condition(id) => Shows::Condition(id.clone()),
            RawShows::Trigger => Shows::Trigger,
        };
        let unit = self.unit.as_ref().map(|unit| parse_unit(document, unit)).transpose()?;
        if unit.is_none() && self.instrument.is_none() && shows != Shows::Trigger {
            let next = "add `unit`, or an `instrument` of the rig";
            return Err(document.malformed(self.id.span(), "what is logged, as a unit", "nothing", next));
        }
        // What is measured the rig says: whether these are amounts of it is checked with it.
        let amounts = [&self.noise, &self.drift].into_iter().flatten();
        let noise_dimensions =
            amounts.map(|amount| Ok(amount.written(document)?.1.dimension)).collect::<Result<_, IngestError>>()?;
        let si = |amount: &Option<Amount>| -> Result<f64, IngestError> {
            amount.as_ref().map_or(Ok(0.0), |amount| {
                let (value, unit) = amount.written(document)?;
                Ok(unit.to_si(value))
            })
        };
        Ok(Channel {
            id: channel_id(document, &self.id)?,
            device: device.clone(),
            shows,
            instrument: self.instrument.clone(),
            unit,
            noise_si: si(&self.noise)?.abs(),
            drift_si_per_s: si(&self.drift)? / 3600.0,
            noise_dimensions,
            is_flawless: false,
            decimals: at_most(document, &self.decimals, 12)?,
            line: document.line_of(self.id.span().start),
        })
    }
}

impl RawSitting {
    fn checked(&self, document: &Document, channels: &[Channel]) -> Result<Sitting, IngestError> {
        let programme = self.programme.checked(document)?;
        let mut responses: Vec<Response> = Vec::new();
        for raw in &self.response {
            let response = raw.checked(document, channels, &responses)?;
            once(document, &raw.quantity.id, responses.iter().any(|r| r.quantity.id == response.quantity.id))?;
            responses.push(response);
        }
        if responses.is_empty() {
            let next = "add a [[sitting.response]]: what is measured, and what really happens";
            return Err(document.malformed(self.id.span(), "at least one [[sitting.response]]", "none", next));
        }
        let measured: Vec<Comparable> = responses
            .iter()
            .map(|r| Comparable { quantity: &r.quantity.id, width: r.quantity.width(), columns: vec![] })
            .collect();
        let comparisons = comparisons(document, &self.comparison, &measured)?;
        Ok(Sitting { id: check_id(document, &self.id)?, title: self.title.clone(), programme, responses, comparisons })
    }
}

impl RawProgramme {
    fn checked(&self, document: &Document) -> Result<Programme, IngestError> {
        let chambers = self.chambers.get_ref().clone();
        if chambers.is_empty() {
            return Err(document.malformed(self.chambers.span(), "at least one chamber", "none", "name it"));
        }
        if (1..chambers.len()).any(|i| chambers[..i].contains(&chambers[i])) {
            let found = chambers.join(", ");
            return Err(document.malformed(self.chambers.span(), "every chamber once", found, "remove one"));
        }
        let levels = self.levels.as_ref().map_or(Ok(vec![]), |raw| {
            let unit = parse_unit(document, &raw.get_ref().unit)?;
            let level = |level: &OneOrSeveral| match level {
                OneOrSeveral::One(value) => vec![unit.to_si(*value)],
                OneOrSeveral::Several(values) => values.iter().map(|v| unit.to_si(*v)).collect(),
            };
            let levels: Vec<Vec<f64>> = raw.get_ref().values.iter().map(level).collect();
            let is_good =
                |level: &Vec<f64>| level.len() == chambers.len() && level.iter().all(|p| p.is_finite() && *p >= 0.0);
            if unit.dimension != Dimension::Pressure || levels.is_empty() || !levels.iter().all(is_good) {
                let expected = format!("gauge pressures >= 0, one for each of {}", chambers.join(", "));
                return Err(document.malformed(raw.span(), expected, "something else", "correct them"));
            }
            Ok(levels)
        })?;
        let cycles = self.cycles.as_ref().map_or(1, |cycles| *cycles.get_ref());
        if cycles == 0 || cycles > 100_000 {
            let span = self.cycles.as_ref().map_or(0..0, Spanned::span);
            return Err(document.malformed(span, "1 to 100000 cycles", cycles.to_string(), "correct it"));
        }
        let (hold_s, window_s) =
            (self.hold.checked(document, Dimension::Time)?, self.window.checked(document, Dimension::Time)?);
        if window_s >= hold_s {
            let expected = format!("less than the hold of {hold_s} s");
            return Err(document.malformed(self.window.span(), expected, format!("{window_s} s"), "shorten it"));
        }
        Ok(Programme {
            kind: match self.kind {
                RawKind::Steps => ProgrammeKind::Steps,
                RawKind::Ramp => ProgrammeKind::Ramp,
                RawKind::Sine => ProgrammeKind::Sine,
                RawKind::Cycles => ProgrammeKind::Cycles,
            },
            chambers,
            levels,
            rest_s: self.rest.checked(document, Dimension::Time)?,
            rise_s: self.rise.checked(document, Dimension::Time)?,
            hold_s,
            unload: self.unload,
            cycles,
            window_s,
            tolerance_pa: self.tolerance.checked(document, Dimension::Pressure)?,
        })
    }
}

impl RawResponse {
    fn checked(&self, document: &Document, channels: &[Channel], before: &[Response]) -> Result<Response, IngestError> {
        let quantity = self.quantity.checked(document)?;
        let measured = self.measured.get_ref();
        for name in measured {
            if channels.iter().all(|channel| channel.id != *name) {
                let next = suggestion(name, channels.iter().map(|channel| channel.id.as_str()));
                return Err(document.malformed(self.measured.span(), "channels above", shown(name), next));
            }
        }
        if measured.len() != quantity.width() {
            let expected = format!("{} for `{}`", quantity.width(), quantity.id);
            let found = measured.len().to_string();
            return Err(document.malformed(self.measured.span(), expected, found, "name one per component"));
        }
        let truth = match self.truth.get_ref() {
            RawTruth::Published => Truth::Published,
            RawTruth::Form(form) => Truth::Form(form.clone()),
            RawTruth::File(file) => Truth::File(file.clone()),
            RawTruth::Sum(parts) if parts.is_empty() => {
                let next = "name the quantities whose sum it is";
                return Err(document.malformed(self.truth.span(), "at least one quantity", "none", next));
            }
            RawTruth::Sum(parts) => {
                let known = before.iter().map(|response| response.quantity.id.as_str());
                if let Some(part) = parts.iter().find(|part| !known.clone().any(|id| id == part.as_str())) {
                    let next = suggestion(part, known);
                    return Err(document.malformed(self.truth.span(), "responses above", shown(part), next));
                }
                Truth::Sum(parts.clone())
            }
        };
        let dimension = quantity.unit.dimension;
        let deviation = self
            .deviation
            .as_ref()
            .map_or(Ok(Deviation::None), |raw| raw.get_ref().checked(document, raw, dimension))?;
        let mut conditions = Vec::new();
        for raw in &self.condition {
            let values_si = raw.values.as_ref().map_or(Ok(vec![]), |values| {
                let unit = parse_unit(document, &values.unit)?;
                Ok(values.values.iter().map(|value| unit.to_si(*value)).collect::<Vec<f64>>())
            })?;
            conditions.push(Setting {
                channel: raw.channel.clone(),
                id: channel_id(document, &raw.id)?,
                title: raw.title.clone(),
                values_si,
                per_run: raw.per_run,
            });
        }
        Ok(Response {
            line: document.line_of(self.quantity.id.span().start),
            quantity,
            chambers: self.chambers.clone(),
            measured: measured.clone(),
            method: self.method.clone(),
            conditions,
            truth,
            deviation,
        })
    }
}

impl RawTensile {
    fn checked(&self, document: &Document) -> Result<Tensile, IngestError> {
        let length = |amount: &Amount| amount.checked(document, Dimension::Length);
        let stretch_max = *self.stretch_max.get_ref();
        if !(stretch_max > 1.0 && stretch_max <= 20.0) {
            let found = stretch_max.to_string();
            return Err(document.malformed(self.stretch_max.span(), "a stretch from 1 to 20", found, "correct it"));
        }
        Ok(Tensile {
            material: self.material.get_ref().clone(),
            strips: at_most(document, &self.strips, 1000)?,
            length_m: length(&self.length)?,
            width_m: length(&self.width)?,
            thickness_m: length(&self.thickness)?,
            speed_m_per_s: length(&self.per_minute)? / 60.0,
            stretch_max,
            rate_hz: self.rate.checked(document, Dimension::Frequency)?,
            force_noise_n: self.force_noise.not_negative(document, Dimension::Force)?,
            displacement_noise_m: self.displacement_noise.not_negative(document, Dimension::Length)?,
            spread: share(document, &self.spread)?,
            line: document.line_of(self.material.span().start),
        })
    }
}

impl RawDeviation {
    fn checked<T>(
        &self,
        document: &Document,
        all: &Spanned<T>,
        dimension: Dimension,
    ) -> Result<Deviation, IngestError> {
        match self {
            Self { each: Some(each), unit: Some(unit), max: None, rmse: None } => {
                let parsed = parse_unit(document, unit)?;
                if parsed.dimension != dimension {
                    let found = format!("unit `{}`", parsed.symbol);
                    return Err(document.malformed(unit.span(), dimension.name(), found, "correct the unit"));
                }
                if let Some(value) = each.iter().find(|value| !value.is_finite()) {
                    return Err(document.malformed(all.span(), "finite numbers", value.to_string(), "correct it"));
                }
                Ok(Deviation::Each(each.iter().map(|value| parsed.to_si(*value)).collect()))
            }
            Self { each: None, unit: None, max: Some(max), rmse: Some(rmse) } => {
                Ok(Deviation::MaxAndRmse(max.checked(document, dimension)?, rmse.checked(document, dimension)?))
            }
            _ => {
                let expected = "{ each = [..], unit = \"..\" }, or { max = .., rmse = .. }";
                Err(document.malformed(all.span(), expected, "other keys, or not all of them", "complete it"))
            }
        }
    }
}
