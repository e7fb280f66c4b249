//! `[[sync]]`: events that several devices recorded, by which their clocks are set against each other; and what a lag is where there
//! are none.

use serde::Deserialize;
use toml::Spanned;

use super::device::Clocks;
use super::{ChannelSpec, DerivedSpec};
use crate::document::{Amount, Document};
use crate::error::{IngestError, shown, suggestion};
use crate::units::Dimension;

/// Events that several devices recorded, each on a channel of its own.
#[derive(Debug, Clone, PartialEq)]
pub struct SyncSpec {
    /// The channels, each on a clock of its own; the first is on the reference clock.
    pub channels: Vec<String>,
    /// What an event is.
    pub event: SyncEvent,
    /// Standard uncertainty of how far apart two recordings of one event really are, in s; 0: they are one instant.
    pub std_s: f64,
    /// Line of the file.
    pub line: usize,
}

/// What an event looks like on a channel.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum SyncEvent {
    /// A line of two states: it rises or falls.
    Edges,
    /// A signal that moves between its lowest and its highest level: it passes the middle.
    Steps,
    /// A knock: the largest deviation from the rest.
    Tap,
}

/// What the lag between pressure and motion is, where clocks are not set against each other.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum LagMeaning {
    /// Nobody knows: it is told in sum, and nothing is shifted by it.
    #[default]
    #[serde(skip)]
    Unsaid,
    /// That of the clocks: the stamps are shifted by it.
    Clock,
    /// That of rig and specimen: the clocks agree, and nothing is shifted.
    Physical,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawSync {
    channels: Spanned<Vec<String>>,
    event: SyncEvent,
    std: Option<Amount>,
}

/// The events of a session. The reference clock is that of the runs' `file` where a channel of it is named, else that of the first.
pub(super) fn syncs(
    document: &Document,
    raw: &[RawSync],
    channels: &[ChannelSpec],
    derived: &[DerivedSpec],
) -> Result<Vec<SyncSpec>, IngestError> {
    let known = || channels.iter().map(|c| c.id.as_str()).chain(derived.iter().map(|d| d.id.as_str()));
    let device_of = |id: &str| super::device::device_of(channels, derived, id);
    raw.iter()
        .map(|sync| {
            let (names, span) = (sync.channels.get_ref(), || sync.channels.span());
            if let Some(name) = names.iter().find(|name| !known().any(|id| id == name.as_str())) {
                return Err(document.malformed(
                    span(),
                    "channels of the session",
                    shown(name),
                    suggestion(name, known()),
                ));
            }
            if names.len() < 2 {
                let next = "name the channel of every device that recorded the event";
                return Err(document.malformed(span(), "two channels or more", names.len().to_string(), next));
            }
            let apart = |(i, name): (usize, &String)| {
                let device = device_of(name);
                // Tables of one file may have clocks of their own: only the file says so.
                names[..i].iter().find(|other| *other == name || (device.is_some() && device_of(other) == device))
            };
            if let Some((i, other)) = (0..names.len()).find_map(|i| Some((i, apart((i, &names[i]))?))) {
                let found = if *other == names[i] {
                    format!("`{other}` twice")
                } else {
                    format!("`{other}` and `{}`, both of {}", names[i], device_of(other).unwrap_or("`file`"))
                };
                let next = "keep one of each device: one clock needs no events to agree with itself";
                return Err(document.malformed(span(), "a channel of each of several devices", found, next));
            }
            let mut channels = names.clone();
            let reference = channels.iter().position(|name| device_of(name).is_none()).unwrap_or(0);
            channels[..=reference].rotate_right(1);
            Ok(SyncSpec {
                channels,
                event: sync.event,
                std_s: sync.std.as_ref().map_or(Ok(0.0), |std| std.not_negative(document, Dimension::Time))?,
                line: document.line_of(sync.channels.span().start),
            })
        })
        .collect()
}

/// One declaration of how clocks lie to each other: those that would contradict each other are refused.
pub(super) fn check_clocks(
    document: &Document,
    clocks: Clocks,
    lag: Option<&Spanned<LagMeaning>>,
    syncs: &[SyncSpec],
) -> Result<(), IngestError> {
    if let Some(lag) = lag.filter(|lag| *lag.get_ref() == LagMeaning::Clock && !syncs.is_empty()) {
        let next = "remove `lag`: the events say how the clocks lie to each other; or remove [[sync]]";
        return Err(document.malformed(lag.span(), "no lag of a clock beside [[sync]]", "\"clock\"", next));
    }
    if clocks != Clocks::One {
        return Ok(());
    }
    if let Some(sync) = syncs.first() {
        let next = "remove `clocks`: the events say how the clocks lie to each other; or remove [[sync]]";
        return Err(document.malformed_at(sync.line, "no [[sync]] beside clocks = \"one\"", "one", next));
    }
    if let Some(lag) = lag.filter(|lag| *lag.get_ref() == LagMeaning::Clock) {
        let next = "remove `clocks` if a clock is off, or `lag` if none is";
        return Err(document.malformed(lag.span(), "no lag of a clock beside clocks = \"one\"", "\"clock\"", next));
    }
    Ok(())
}
