//! Whether the parts of a plan fit together, with its rig and its actuator, before anything is written.

use pneuval_ingest::IngestError;
use pneuval_ingest::calibration::Calibration;
use pneuval_ingest::error::{Place, shown, suggestion};
use pneuval_ingest::formats::Format;
use pneuval_ingest::manifest::{Actuator, Rig};
use pneuval_ingest::units::{Dimension, Unit};

use super::files::STAMPS;
use super::plan::{Channel, Device, Moments, Plan, Response, Shows, Sitting};

/// Checks a plan.
///
/// # Errors
/// [`IngestError::Malformed`] at the line of the channel, device or response that does not fit.
pub fn check(plan: &Plan, rig: &Rig, actuator: &Actuator) -> Result<(), IngestError> {
    let check = Check { plan, rig, actuator };
    plan.channels.iter().try_for_each(|channel| check.channel(channel))?;
    check.devices()?;
    plan.sittings.iter().try_for_each(|sitting| check.sitting(sitting))
}

struct Check<'a> {
    plan: &'a Plan,
    rig: &'a Rig,
    actuator: &'a Actuator,
}

impl Check<'_> {
    fn wrong(&self, line: usize, item: String, expected: &str, found: &str, next: String) -> IngestError {
        IngestError::Malformed {
            place: Place::new(&self.plan.file, Some(line), Some(item)),
            expected: expected.to_owned(),
            found: found.to_owned(),
            next,
        }
    }

    fn responses(&self) -> impl Iterator<Item = &Response> {
        self.plan.sittings.iter().flat_map(|sitting| &sitting.responses)
    }

    /// What a channel measures; `None` for what may be of any dimension.
    fn dimension(&self, channel: &Channel) -> Result<Option<Dimension>, IngestError> {
        let item = || format!("channel `{}`", channel.id);
        match &channel.shows {
            Shows::Command(id) | Shows::Pressure(id) => {
                let chambers = || self.plan.sittings.iter().flat_map(|sitting| &sitting.programme.chambers);
                if chambers().any(|known| known == id) {
                    return Ok(Some(Dimension::Pressure));
                }
                let next = suggestion(id, chambers().map(String::as_str));
                Err(self.wrong(channel.line, item(), "a chamber of a programme", &shown(id), next))
            }
            Shows::Quantity(id, component) => {
                let Some(response) = self.responses().find(|response| response.quantity.id == *id) else {
                    let next = suggestion(id, self.responses().map(|response| response.quantity.id.as_str()));
                    return Err(self.wrong(channel.line, item(), "a quantity of a response", &shown(id), next));
                };
                if *component >= response.quantity.width() {
                    let expected = format!("a component of `{id}`, counted from 0, of {}", response.quantity.width());
                    let next = "correct `index`".to_owned();
                    return Err(self.wrong(channel.line, item(), &expected, &component.to_string(), next));
                }
                Ok(Some(response.quantity.unit.dimension))
            }
            Shows::Condition(id) => {
                let conditions = || self.responses().flat_map(|response| &response.conditions);
                if conditions().any(|known| known.id == *id) {
                    return Ok(None);
                }
                let next = suggestion(id, conditions().map(|condition| condition.id.as_str()));
                Err(self.wrong(channel.line, item(), "a condition of a response", &shown(id), next))
            }
            Shows::Trigger => Ok(Some(Dimension::Ratio)),
        }
    }

    fn channel(&self, channel: &Channel) -> Result<(), IngestError> {
        let item = || format!("channel `{}`", channel.id);
        if channel.id == STAMPS {
            let next = "rename it".to_owned();
            return Err(self.wrong(channel.line, item(), "a name that the stamps do not have", STAMPS, next));
        }
        let instrument = match &channel.instrument {
            None => None,
            Some(id) => {
                let Some(instrument) = self.rig.instruments.get(id) else {
                    let expected = format!("an instrument of {}", self.rig.file);
                    let next = suggestion(id, self.rig.instruments.keys().map(String::as_str));
                    return Err(self.wrong(channel.line, item(), &expected, &shown(id), next));
                };
                Some(instrument)
            }
        };
        let is_polynomial = instrument
            .is_some_and(|i| matches!(i.calibration, Some(Calibration::Polynomial { .. })) && i.valid.is_none());
        if is_polynomial {
            let expected = "an instrument whose polynomial has a `valid` range, in which it is followed back";
            let next = format!("add `valid` to it in {}", self.rig.file);
            return Err(self.wrong(channel.line, item(), expected, "none", next));
        }
        let measured = instrument.map(|i| i.output).or(channel.unit).unwrap_or(Unit::ONE);
        if let Some(dimension) = self.dimension(channel)?.filter(|dimension| *dimension != measured.dimension) {
            let found = format!("unit `{}`", measured.symbol);
            let next = "name another instrument, or correct the unit".to_owned();
            return Err(self.wrong(channel.line, item(), dimension.name(), &found, next));
        }
        if channel.noise_dimensions.iter().any(|dimension| *dimension != measured.dimension) {
            let expected = format!("noise and drift as {}", measured.dimension.name());
            let next = "correct their unit: they are of what is measured".to_owned();
            return Err(self.wrong(channel.line, item(), &expected, "another kind of unit", next));
        }
        Ok(())
    }

    /// Devices of special formats log what those hold.
    fn devices(&self) -> Result<(), IngestError> {
        for device in &self.plan.devices {
            let channels: Vec<&Channel> = self.plan.channels.iter().filter(|c| c.device == device.id).collect();
            let logged = |channel: &Channel| {
                let instrument = channel.instrument.as_ref().and_then(|id| self.rig.instruments.get(id));
                instrument.map(|i| i.input).or(channel.unit)
            };
            let is_quantity = |channel: &Channel| matches!(channel.shows, Shows::Quantity(..));
            let expected = match device.format {
                Format::Gauge => {
                    let is_force =
                        |c: &&Channel| is_quantity(c) && logged(c).is_some_and(|u| u.dimension == Dimension::Force);
                    let is_one = channels.len() == 1 && channels.iter().all(is_force);
                    (!is_one).then_some("one channel of a force: a gauge logs nothing else")
                }
                Format::Trakstar => self.of_tracker(&channels, &logged),
                Format::Pictures => self.of_camera(device, &channels),
                _ => None,
            };
            if let Some(expected) = expected {
                let names: Vec<&str> = channels.iter().map(|channel| channel.id.as_str()).collect();
                let next = "take another format, csv for instance, or another device".to_owned();
                let item = format!("device `{}`", device.id);
                return Err(self.wrong(device.line, item, expected, &names.join(", "), next));
            }
        }
        Ok(())
    }

    /// What a camera asks of its channels and they are not.
    fn of_camera(&self, device: &Device, channels: &[&Channel]) -> Option<&'static str> {
        let camera = device.camera.as_ref()?;
        let Some(seen) = channels.iter().find(|channel| channel.id == camera.channel) else {
            return Some("a channel of its own that is seen in its pictures: `channel` of the camera");
        };
        let is_bare = seen.instrument.is_none() && seen.noise_si <= 0.0 && seen.drift_si_per_s.abs() <= 0.0;
        let of_kind = seen.unit.is_some_and(|unit| unit.dimension == camera.object.dimension());
        if !is_bare || !of_kind || !matches!(seen.shows, Shows::Quantity(..) | Shows::Condition(_)) {
            return Some(
                "a quantity or condition of the kind that is seen, by its `unit`, without instrument and noise",
            );
        }
        if channels.iter().any(|channel| channel.shows == Shows::Trigger) {
            return Some("no trigger: none is seen in its pictures");
        }
        if camera.moments == Moments::Film && channels.len() > 1 {
            return Some("of a film, the channel that is seen alone: its pictures are numbered, and say nothing else");
        }
        let is_there = |sitting: &Sitting| match &seen.shows {
            Shows::Quantity(id, _) => sitting.responses.iter().any(|response| response.quantity.id == *id),
            Shows::Condition(id) => {
                sitting.responses.iter().flat_map(|response| &response.conditions).any(|setting| setting.id == *id)
            }
            _ => false,
        };
        if !self.plan.sittings.iter().all(is_there) {
            return Some("a channel that every sitting has: without it there is nothing to see");
        }
        None
    }

    /// What a tracker asks of its channels and they are not.
    fn of_tracker(&self, channels: &[&Channel], logged: &dyn Fn(&Channel) -> Option<Unit>) -> Option<&'static str> {
        for sitting in &self.plan.sittings {
            let mut quantity = None;
            for channel in channels {
                let Shows::Quantity(id, component) = &channel.shows else {
                    if channel.shows == Shows::Trigger {
                        continue;
                    }
                    return Some("components of a position: a tracker logs nothing else");
                };
                if sitting.responses.iter().all(|response| response.quantity.id != *id) {
                    continue;
                }
                if quantity.replace(id).is_some_and(|known| known != id) || *component > 1 {
                    return Some(
                        "one quantity of one or two components in a sitting: a rehearsed tracker has one sensor",
                    );
                }
                if logged(channel).is_none_or(|unit| unit.symbol != "mm") {
                    return Some("lengths in mm, as the tracker's columns say");
                }
            }
        }
        None
    }

    fn sitting(&self, sitting: &Sitting) -> Result<(), IngestError> {
        for response in &sitting.responses {
            let item = || format!("response `{}`", response.quantity.id);
            let mut pressure_device = None;
            for chamber in &response.chambers {
                let programme = sitting.programme.chambers.iter().map(String::as_str);
                if sitting.programme.chambers.iter().all(|known| known != chamber) {
                    let next = suggestion(chamber, programme);
                    return Err(self.wrong(response.line, item(), "a chamber of its programme", &shown(chamber), next));
                }
                let known = self.actuator.chambers.keys().map(String::as_str);
                if !self.actuator.chambers.is_empty() && !self.actuator.chambers.contains_key(chamber) {
                    let expected = format!("a chamber of {}", self.actuator.id);
                    return Err(self.wrong(
                        response.line,
                        item(),
                        &expected,
                        &shown(chamber),
                        suggestion(chamber, known),
                    ));
                }
                let shows = Shows::Pressure(chamber.clone());
                let Some(channel) = self.plan.channels.iter().find(|channel| channel.shows == shows) else {
                    let expected = format!("a channel that shows the pressure of `{chamber}`");
                    let next = "add a [[channel]] with shows = { pressure = \"..\" }".to_owned();
                    return Err(self.wrong(response.line, item(), &expected, "none", next));
                };
                pressure_device = Some(&channel.device);
            }
            for (component, id) in response.measured.iter().enumerate() {
                let shows = Shows::Quantity(response.quantity.id.clone(), component);
                if self.plan.channels.iter().any(|channel| channel.id == *id && channel.shows != shows) {
                    let expected = format!("channels that show `{}`, component by component", response.quantity.id);
                    let next = "correct `shows` of the channel, or `measured`".to_owned();
                    return Err(self.wrong(response.line, item(), &expected, &shown(id), next));
                }
            }
            for setting in &response.conditions {
                let shows = Shows::Condition(setting.id.clone());
                let is_it = |channel: &&Channel| channel.id == setting.channel && channel.shows == shows;
                let channel = self.plan.channels.iter().find(is_it);
                if channel.is_none_or(|channel| Some(&channel.device) != pressure_device) {
                    let expected =
                        format!("a channel that shows the condition `{}`, logged with the pressure", setting.id);
                    let next = "add it, or correct its `shows` and `device`".to_owned();
                    return Err(self.wrong(response.line, item(), &expected, &shown(&setting.channel), next));
                }
            }
        }
        Ok(())
    }
}
