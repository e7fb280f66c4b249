//! `rig.toml`: the instruments of a test bench, with range, resolution, standard uncertainty and calibration.

use std::collections::BTreeMap;

use serde::Deserialize;
use toml::Spanned;

use super::{check_id, check_schema};
use crate::calibration::Calibration;
use crate::digest;
use crate::document::{Document, finite, parse_unit};
use crate::error::{IngestError, shown};
use crate::units::Unit;

/// A test bench.
#[derive(Debug, Clone, PartialEq)]
pub struct Rig {
    /// Its id, named by sessions.
    pub id: String,
    /// Its name on pages.
    pub title: String,
    /// Instruments by id.
    pub instruments: BTreeMap<String, Instrument>,
    /// The file as the user named it.
    pub file: String,
    /// Its path relative to the session's folder, for provenance: whoever looked it up fills it in.
    pub relative: String,
    /// SHA-256 of the file.
    pub sha256: String,
}

/// An instrument: what it puts out, and what that means.
#[derive(Debug, Clone, PartialEq)]
pub struct Instrument {
    /// Its name on pages.
    pub title: String,
    /// Unit of what is logged.
    pub input: Unit,
    /// Unit after calibration; the input's where there is none.
    pub output: Unit,
    /// From logged to measured; `None` where the log already holds what is measured.
    pub calibration: Option<Calibration>,
    /// Logged values outside are refused, sample by sample.
    pub valid: Option<(f64, f64)>,
    /// Measured values outside are beyond what the instrument can show, in output units.
    pub range: Option<(f64, f64)>,
    /// The smallest step it can show, in output units.
    pub resolution: Option<f64>,
    /// Standard uncertainty of one reading, in output units.
    pub std: Option<f64>,
    /// One calibration stands behind all channels of it: what it is off by is the same in all of them.
    pub shared_calibration: bool,
    /// When it was calibrated, and by whom, in the user's words.
    pub certificate: Option<String>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Raw {
    schema: Spanned<i64>,
    id: Spanned<String>,
    title: Option<String>,
    #[serde(default)]
    instrument: BTreeMap<Spanned<String>, RawInstrument>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawInstrument {
    title: Option<String>,
    input: Spanned<String>,
    output: Option<Spanned<String>>,
    calibration: Option<Spanned<RawCalibration>>,
    valid: Option<RawRange>,
    range: Option<RawRange>,
    resolution: Option<Spanned<f64>>,
    std: Option<Spanned<f64>>,
    #[serde(default)]
    shared_calibration: bool,
    certificate: Option<String>,
}

/// `{ min, max }` in the units said beside it.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawRange {
    min: Spanned<f64>,
    max: Spanned<f64>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawCalibration {
    kind: Kind,
    slope: Option<Spanned<f64>>,
    offset: Option<Spanned<f64>>,
    coefficients: Option<Vec<Spanned<f64>>>,
    points: Option<Spanned<Vec<(f64, f64)>>>,
    supply: Option<Spanned<f64>>,
    gain: Option<Spanned<f64>>,
}

#[derive(Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum Kind {
    Line,
    Polynomial,
    Table,
    Divider,
}

impl Kind {
    /// The keys it needs beside `kind`.
    fn keys(self) -> &'static [&'static str] {
        match self {
            Self::Line => &["slope", "offset"],
            Self::Polynomial => &["coefficients"],
            Self::Table => &["points"],
            Self::Divider => &["supply", "gain", "offset"],
        }
    }
}

impl Rig {
    /// Reads a rig file.
    ///
    /// # Errors
    /// [`IngestError::Malformed`] with line and key.
    pub fn read(file: &str, bytes: &[u8]) -> Result<Self, IngestError> {
        let document = Document::new(file, bytes)?;
        let raw: Raw = document.parse()?;
        check_schema(&document, &raw.schema)?;
        let id = check_id(&document, &raw.id)?;
        let mut instruments = BTreeMap::new();
        for (name, instrument) in &raw.instrument {
            let checked = instrument.checked(&document, name.get_ref())?;
            instruments.insert(check_id(&document, name)?, checked);
        }
        Ok(Self {
            title: raw.title.unwrap_or_else(|| id.clone()),
            id,
            instruments,
            file: file.to_owned(),
            relative: String::new(),
            sha256: digest::sha256(bytes),
        })
    }
}

impl Instrument {
    /// Standard uncertainty in output units: the declared one, and half a step of the resolution either way, equally likely
    /// everywhere (1/√12 of the step). `None` if neither is declared.
    pub fn uncertainty(&self) -> Option<f64> {
        let quantisation = self.resolution.map(|step| step / 12.0_f64.sqrt());
        match (self.std, quantisation) {
            (None, None) => None,
            (std, quantisation) => Some(std.unwrap_or(0.0).hypot(quantisation.unwrap_or(0.0))),
        }
    }
}

impl RawInstrument {
    fn checked(&self, document: &Document, id: &str) -> Result<Instrument, IngestError> {
        let input = parse_unit(document, &self.input)?;
        let output = self.output.as_ref().map_or(Ok(input), |unit| parse_unit(document, unit))?;
        if let (None, Some(unit)) = (&self.calibration, &self.output)
            && output.dimension != input.dimension
        {
            let next = "add `calibration`, or log the output itself";
            let expected = format!("a calibration from {} to {}", input.symbol, output.symbol);
            return Err(document.malformed(unit.span(), expected, "none", next));
        }
        let positive = |value: &Spanned<f64>| -> Result<f64, IngestError> {
            let number = finite(document, value)?;
            if number > 0.0 {
                return Ok(number);
            }
            Err(document.malformed(value.span(), "a number > 0", number.to_string(), "correct it"))
        };
        Ok(Instrument {
            title: self.title.clone().unwrap_or_else(|| id.to_owned()),
            input,
            output,
            calibration: self.calibration.as_ref().map(|c| c.get_ref().checked(document, c)).transpose()?,
            valid: self.valid.as_ref().map(|range| range.checked(document)).transpose()?,
            range: self.range.as_ref().map(|range| range.checked(document)).transpose()?,
            resolution: self.resolution.as_ref().map(positive).transpose()?,
            std: self.std.as_ref().map(positive).transpose()?,
            shared_calibration: self.shared_calibration,
            certificate: self.certificate.clone(),
        })
    }
}

impl RawRange {
    fn checked(&self, document: &Document) -> Result<(f64, f64), IngestError> {
        let (min, max) = (finite(document, &self.min)?, finite(document, &self.max)?);
        if min < max {
            return Ok((min, max));
        }
        Err(document.malformed(self.max.span(), format!("more than min = {min}"), max.to_string(), "correct the range"))
    }
}

impl RawCalibration {
    fn checked<T>(&self, document: &Document, all: &Spanned<T>) -> Result<Calibration, IngestError> {
        let given = [
            ("slope", self.slope.is_some()),
            ("offset", self.offset.is_some()),
            ("coefficients", self.coefficients.is_some()),
            ("points", self.points.is_some()),
            ("supply", self.supply.is_some()),
            ("gain", self.gain.is_some()),
        ];
        let keys = self.kind.keys();
        let stray = given.iter().find(|(key, there)| *there && !keys.contains(key));
        let missing = keys.iter().find(|key| !given.iter().any(|(k, there)| k == *key && *there));
        if let Some((key, _)) = stray {
            let expected = format!("the keys {}", keys.join(", "));
            return Err(document.malformed(all.span(), expected, shown(key), "remove it, or choose another kind"));
        }
        if let Some(key) = missing {
            return Err(document.malformed(all.span(), format!("key `{key}`"), "nothing", format!("add `{key}`")));
        }
        let number = |value: &Option<Spanned<f64>>| -> Result<f64, IngestError> {
            // Every key of this kind is there: checked above.
            value.as_ref().map_or(Ok(f64::NAN), |value| finite(document, value))
        };
        match self.kind {
            Kind::Line => Ok(Calibration::Line { slope: number(&self.slope)?, offset: number(&self.offset)? }),
            Kind::Polynomial => {
                let coefficients = self.coefficients.iter().flatten().map(|c| finite(document, c));
                let coefficients = coefficients.collect::<Result<Vec<_>, _>>()?;
                if coefficients.len() < 2 {
                    let expected = "at least two coefficients, the constant first";
                    let found = if coefficients.is_empty() { "none" } else { "one: every reading would be the same" };
                    return Err(document.malformed(all.span(), expected, found, "complete them"));
                }
                Ok(Calibration::Polynomial { coefficients })
            }
            Kind::Table => {
                let points = self.points.as_ref().map(|p| p.get_ref().clone()).unwrap_or_default();
                let finite = points.iter().all(|(x, y)| x.is_finite() && y.is_finite());
                if points.len() < 2 || !finite || points.windows(2).any(|pair| pair[1].0 <= pair[0].0) {
                    let found = format!("{} points", points.len());
                    let expected = "at least two finite points [input, output] of rising input";
                    return Err(document.malformed(all.span(), expected, found, "sort or complete them"));
                }
                Ok(Calibration::Table { points })
            }
            Kind::Divider => {
                let supply = number(&self.supply)?;
                if supply <= 0.0 {
                    return Err(document.malformed(all.span(), "a supply > 0", supply.to_string(), "correct it"));
                }
                Ok(Calibration::Divider { supply, gain: number(&self.gain)?, offset: number(&self.offset)? })
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const GOOD: &str = "schema = 1\nid = \"bench\"\n[instrument.laser]\ninput = \"V\"\noutput = \"mm\"\n\
                        calibration = { kind = \"line\", slope = 13.33756, offset = -47.48980 }\nstd = 0.02\n";

    fn error(text: &str) -> String {
        Rig::read("rig.toml", text.as_bytes()).unwrap_err().to_string()
    }

    #[test]
    fn a_rig_reads() {
        let rig = Rig::read("rig.toml", GOOD.as_bytes()).unwrap();
        let laser = &rig.instruments["laser"];
        assert_eq!(laser.calibration, Some(Calibration::Line { slope: 13.337_56, offset: -47.489_80 }));
        assert_eq!((laser.input.symbol, laser.output.symbol, laser.std), ("V", "mm", Some(0.02)));
    }

    #[test]
    fn mistakes_are_named_by_line_and_key() {
        for (from, to, line, word) in [
            ("slope = 13.33756, ", "", 6, "key `slope`"),
            ("slope = 13.33756, ", "slope = nan, ", 6, "a finite number"),
            ("slope = 13.33756, ", "slope = 1, gain = 2, ", 6, "`gain`"),
            ("kind = \"line\"", "kind = \"lien\"", 6, "did you mean `line`?"),
            ("output = \"mm\"", "output = \"milli\"", 5, "a known unit"),
            ("std = 0.02", "std = -0.02", 7, "a number > 0"),
            ("std = 0.02", "sdt = 0.02", 7, "did you mean `std`?"),
            ("std = 0.02", "range = { min = 3, max = 1 }", 7, "more than min = 3"),
            (
                "calibration = { kind = \"line\", slope = 13.33756, offset = -47.48980 }\n",
                "",
                5,
                "a calibration from V to mm",
            ),
            (
                "kind = \"line\", slope = 13.33756, offset = -47.48980",
                "kind = \"table\", points = [[1, 2], [1, 3]]",
                6,
                "rising input",
            ),
            (
                "kind = \"line\", slope = 13.33756, offset = -47.48980",
                "kind = \"polynomial\", coefficients = []",
                6,
                "at least two coefficients",
            ),
            (
                "kind = \"line\", slope = 13.33756, offset = -47.48980",
                "kind = \"polynomial\", coefficients = [3.5]",
                6,
                "one: every reading would be the same",
            ),
        ] {
            let message = error(&GOOD.replace(from, to));
            assert!(message.starts_with(&format!("rig.toml:{line}: key")), "{to}: {message}");
            assert!(message.contains(word), "{to}: {message}");
        }
    }
}
