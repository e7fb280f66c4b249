//! `follows`: the commanded channel that a measured one should meet.

use serde::Deserialize;
use toml::Spanned;

use super::ChannelSpec;
use crate::document::{Amount, Document};
use crate::error::{IngestError, shown, suggestion};
use crate::units::{Dimension, Unit};

/// What a measured channel should be: where the command has stood for a while, a difference is told.
#[derive(Debug, Clone, PartialEq)]
pub struct Follows {
    /// The commanded channel.
    pub channel: String,
    /// The largest difference that is none, more than zero, as it is written. Only the channels say whether the unit is of their kind.
    pub within: (f64, Unit),
    /// How long the command has stood where the two are compared, in s; 0: everywhere, with or without a clock.
    pub after_s: f64,
    /// Line of the file.
    pub line: usize,
}

impl Follows {
    /// The largest difference that is none, in SI units.
    pub fn within_si(&self) -> f64 {
        self.within.1.to_si(self.within.0)
    }
}

/// `{ channel, within, after }`.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawFollows {
    channel: Spanned<String>,
    within: Amount,
    after: Amount,
}

impl RawFollows {
    pub fn checked(&self, document: &Document) -> Result<Follows, IngestError> {
        let (value, unit) = self.within.written(document)?;
        let si = unit.to_si(value);
        if !(si.is_finite() && si > 0.0) {
            let next = "write the difference that does not count";
            return Err(document.malformed(self.within.span(), "a number > 0", value.to_string(), next));
        }
        Ok(Follows {
            channel: self.channel.get_ref().clone(),
            within: (value, unit),
            after_s: self.after.not_negative(document, Dimension::Time)?,
            line: document.line_of(self.channel.span().start),
        })
    }
}

/// Every channel that follows one follows another that was commanded, wherever in the file that stands.
pub(super) fn check_follows(document: &Document, channels: &[ChannelSpec]) -> Result<(), IngestError> {
    for spec in channels {
        let Some(follows) = &spec.follows else { continue };
        let refused = |expected: &str, found: String, next: String| {
            Err(document.malformed_at(follows.line, expected, found, next))
        };
        if follows.channel == spec.id {
            let found = format!("`{}` itself", spec.id);
            return refused("another channel", found, "name the channel that was commanded".to_owned());
        }
        let Some(command) = channels.iter().find(|other| other.id == follows.channel) else {
            let others = channels.iter().map(|other| other.id.as_str()).filter(|id| *id != spec.id);
            return refused("a [[channel]]", shown(&follows.channel), suggestion(&follows.channel, others));
        };
        if !command.commanded {
            let next = if spec.commanded {
                format!("write `follows` at `{}`, naming `{}`", command.id, spec.id)
            } else {
                format!("say commanded = true at `{}`, or name the channel that was commanded", command.id)
            };
            return refused("a commanded channel", format!("`{}`, which is measured", command.id), next);
        }
    }
    Ok(())
}
