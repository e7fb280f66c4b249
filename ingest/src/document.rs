//! TOML documents whose errors say file, line, key, expected, found and next step.

use std::ops::Range;

use serde::Deserialize;
use serde::de::DeserializeOwned;
use toml::Spanned;

use crate::error::{IngestError, Place, shown, suggestion};
use crate::units::{Dimension, Unit};

/// A TOML text with its file's name.
#[derive(Debug, Clone, Copy)]
pub struct Document<'a> {
    file: &'a str,
    text: &'a str,
}

impl<'a> Document<'a> {
    /// A document; a byte-order mark is skipped.
    ///
    /// # Errors
    /// [`IngestError::Malformed`] if the bytes are not UTF-8.
    pub fn new(file: &'a str, bytes: &'a [u8]) -> Result<Self, IngestError> {
        let text = utf8(file, bytes)?;
        Ok(Self { file, text })
    }

    /// The document as a value of `T`, which should deny unknown fields.
    ///
    /// # Errors
    /// [`IngestError::Malformed`] with line and key; for an unknown key, with the nearest known one.
    pub fn parse<T: DeserializeOwned>(&self) -> Result<T, IngestError> {
        toml::from_str(self.text).map_err(|error| self.told(&error))
    }

    /// An error at a span of this document.
    pub fn malformed(
        &self,
        span: Range<usize>,
        expected: impl Into<String>,
        found: impl Into<String>,
        next: impl Into<String>,
    ) -> IngestError {
        self.malformed_at(self.line_of(span.start), expected, found, next)
    }

    /// An error at a line of this document.
    pub fn malformed_at(
        &self,
        line: usize,
        expected: impl Into<String>,
        found: impl Into<String>,
        next: impl Into<String>,
    ) -> IngestError {
        let item = self.key_on_line(line).map(|key| format!("key `{key}`"));
        let place = Place::new(self.file, Some(line), item);
        IngestError::Malformed { place, expected: expected.into(), found: found.into(), next: next.into() }
    }

    /// The file's name.
    pub fn file(&self) -> &'a str {
        self.file
    }

    /// The line of a byte offset, from 1.
    pub fn line_of(&self, offset: usize) -> usize {
        1 + self.text.as_bytes()[..offset.min(self.text.len())].iter().filter(|b| **b == b'\n').count()
    }

    /// The key that a line assigns, or the table it opens.
    fn key_on_line(&self, line: usize) -> Option<&'a str> {
        let text = self.text.lines().nth(line - 1)?.trim();
        let key = text.split_once('=').map_or(text, |(key, _)| key.trim());
        (!key.is_empty() && !key.starts_with('#')).then_some(key)
    }

    /// serde and toml tell what is wrong in words: "unknown field `x`, expected one of `a`, `b`".
    fn told(&self, error: &toml::de::Error) -> IngestError {
        let span = error.span().unwrap_or(0..0);
        let message = error.message();
        let at_span = self.text.get(span.clone()).unwrap_or_default().trim();
        if let Some(rest) = message.strip_prefix("unknown field ").or_else(|| message.strip_prefix("unknown variant "))
        {
            let mut words = backticked(rest);
            if !words.is_empty() {
                let word = words.remove(0);
                let expected = format!("one of: {}", words.join(", "));
                return self.malformed(span, expected, format!("`{word}`"), suggestion(word, words));
            }
        }
        if let Some(field) = message.strip_prefix("missing field ") {
            let field = backticked(field).first().copied().unwrap_or(field);
            return self.malformed(span, format!("key `{field}`"), "nothing", format!("add `{field}`"));
        }
        if let Some((found, expected)) = message.split_once(", expected ") {
            let found = found.trim_start_matches("invalid type: ").trim_start_matches("invalid value: ");
            let (expected, next) = match expected {
                "f64" => ("a number", "correct the value"),
                "a string" => ("text in quotes", "put it in quotes"),
                other => (other, "correct the value"),
            };
            return self.malformed(span, expected, found, next);
        }
        let found = if at_span.is_empty() || at_span.contains('\n') { "something else" } else { at_span };
        self.malformed(span, format!("valid TOML ({message})"), found, "correct the line")
    }
}

/// Bytes as text without a byte-order mark.
///
/// # Errors
/// [`IngestError::Malformed`] naming the line of the first byte that is not UTF-8.
pub fn utf8<'a>(file: &str, bytes: &'a [u8]) -> Result<&'a str, IngestError> {
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    std::str::from_utf8(bytes).map_err(|error| {
        let line = 1 + bytes[..error.valid_up_to()].iter().filter(|b| **b == b'\n').count();
        IngestError::Malformed {
            place: Place::new(file, Some(line), None),
            expected: "text in UTF-8".to_owned(),
            found: format!("byte 0x{:02x}", bytes[error.valid_up_to()]),
            next: "save the file as UTF-8".to_owned(),
        }
    })
}

/// The words between backticks.
fn backticked(text: &str) -> Vec<&str> {
    text.split('`').skip(1).step_by(2).collect()
}

/// Where a value of an actuator comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Origin {
    /// Printed in a paper.
    Published,
    /// Measured on the specimen.
    Measured,
    /// Nobody printed or measured it: chosen, and every comparison that rests on it says so.
    Assumed,
    /// Fitted to data.
    Calibrated,
}

impl Origin {
    /// The word used in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Published => "published",
            Self::Measured => "measured",
            Self::Assumed => "assumed",
            Self::Calibrated => "calibrated",
        }
    }
}

/// `{ value, unit, std, source, place }` as a user writes it.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RawValue {
    value: Spanned<f64>,
    unit: Spanned<String>,
    std: Option<Spanned<f64>>,
    source: Origin,
    place: Option<String>,
    fitted_on: Option<Spanned<Vec<String>>>,
}

/// A checked value in SI units.
#[derive(Debug, Clone, PartialEq)]
pub struct Value {
    /// In SI units.
    pub si: f64,
    /// Standard uncertainty in SI units, if stated.
    pub std_si: Option<f64>,
    /// The unit it was written in.
    pub unit: Unit,
    /// Where it comes from.
    pub origin: Origin,
    /// Paper, table or equation.
    pub place: Option<String>,
    /// The runs a calibrated value was fitted on, `dataset/quantity run`: where they are compared with it, that is calibration.
    pub fitted_on: Vec<String>,
    /// Line of the file, for errors of whoever knows what it should measure.
    pub line: usize,
}

impl RawValue {
    /// The value in SI units, whatever it measures.
    ///
    /// # Errors
    /// [`IngestError::Malformed`] for an unknown unit, a number that is not finite, a negative `std`, or a published value
    /// without its place.
    pub fn checked(&self, document: &Document) -> Result<Value, IngestError> {
        let unit = parse_unit(document, &self.unit)?;
        let value = finite(document, &self.value)?;
        if !unit.to_si(value).is_finite() {
            let found = format!("{value:e} {}", unit.symbol);
            return Err(document.malformed(
                self.value.span(),
                "a number that is finite in SI units",
                found,
                "correct it",
            ));
        }
        let std_si = match &self.std {
            Some(std) => {
                let number = finite(document, std)?;
                if number < 0.0 || !unit.to_si(number).is_finite() {
                    return Err(document.malformed(
                        std.span(),
                        "a finite standard uncertainty >= 0",
                        number.to_string(),
                        "correct it",
                    ));
                }
                Some(unit.to_si(number))
            }
            None => None,
        };
        if self.source == Origin::Published && self.place.is_none() {
            return Err(document.malformed(
                self.value.span(),
                "key `place`: paper, table or equation of a published value",
                "nothing",
                "add `place`, or say source = \"assumed\"",
            ));
        }
        if let Some(runs) = self.fitted_on.as_ref().filter(|_| self.source != Origin::Calibrated) {
            let found = format!("source = \"{}\"", self.source.name());
            return Err(document.malformed(
                runs.span(),
                "`fitted_on` beside source = \"calibrated\" only",
                found,
                "correct the source",
            ));
        }
        let fitted_on = self.fitted_on.as_ref().map(|runs| runs.get_ref().clone()).unwrap_or_default();
        let line = document.line_of(self.value.span().start);
        let (origin, place) = (self.source, self.place.clone());
        Ok(Value { si: unit.to_si(value), std_si, unit, origin, place, fitted_on, line })
    }

    /// The value, which must measure `dimension`.
    ///
    /// # Errors
    /// As [`RawValue::checked`], and for a unit of another dimension.
    pub fn checked_as(&self, document: &Document, dimension: Dimension) -> Result<Value, IngestError> {
        let value = self.checked(document)?;
        if value.unit.dimension == dimension {
            Ok(value)
        } else {
            Err(document.malformed(
                self.unit.span(),
                dimension.name(),
                format!("unit `{}`", self.unit.get_ref()),
                "correct the unit",
            ))
        }
    }
}

/// `{ value, unit }` as a user writes it.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Amount {
    value: Spanned<f64>,
    unit: Spanned<String>,
}

impl Amount {
    /// Where its value stands.
    pub fn span(&self) -> Range<usize> {
        self.value.span()
    }

    /// The number as it is written, and its unit.
    ///
    /// # Errors
    /// [`IngestError::Malformed`] for an unknown unit, and for a number that is not finite.
    pub fn written(&self, document: &Document) -> Result<(f64, Unit), IngestError> {
        let unit = parse_unit(document, &self.unit)?;
        Ok((finite(document, &self.value)?, unit))
    }

    /// The amount in SI units, of either sign.
    ///
    /// # Errors
    /// [`IngestError::Malformed`] for an unknown unit, a unit of another dimension, or a number that is not finite.
    pub fn signed(&self, document: &Document, dimension: Dimension) -> Result<f64, IngestError> {
        let (value, unit) = self.written(document)?;
        if unit.dimension != dimension {
            let found = format!("unit `{}`", unit.symbol);
            return Err(document.malformed(self.unit.span(), dimension.name(), found, "correct the unit"));
        }
        let si = unit.to_si(value);
        if si.is_finite() {
            return Ok(si);
        }
        let found = format!("{value} {}", unit.symbol);
        Err(document.malformed(self.value.span(), "a number that is finite in SI units", found, "correct it"))
    }

    /// The amount in SI units, more than zero.
    ///
    /// # Errors
    /// As [`Amount::signed`], and for zero and less.
    pub fn checked(&self, document: &Document, dimension: Dimension) -> Result<f64, IngestError> {
        let si = self.signed(document, dimension)?;
        if si > 0.0 {
            return Ok(si);
        }
        Err(document.malformed(self.value.span(), "a number > 0", self.value.get_ref().to_string(), "correct it"))
    }

    /// The amount in SI units, or zero, whose unit may be any.
    ///
    /// # Errors
    /// As [`Amount::checked`], but for zero.
    pub fn not_negative(&self, document: &Document, dimension: Dimension) -> Result<f64, IngestError> {
        if *self.value.get_ref() == 0.0 {
            parse_unit(document, &self.unit)?;
            return Ok(0.0);
        }
        self.checked(document, dimension)
    }
}

/// A unit in a document.
///
/// # Errors
/// [`IngestError::Malformed`] for an unknown symbol, with the nearest known one.
pub fn parse_unit(document: &Document, symbol: &Spanned<String>) -> Result<Unit, IngestError> {
    Unit::parse(symbol.get_ref()).ok_or_else(|| {
        document.malformed(symbol.span(), "a known unit", shown(symbol.get_ref()), Unit::suggestion(symbol.get_ref()))
    })
}

/// A finite number in a document.
///
/// # Errors
/// [`IngestError::Malformed`] for NaN and infinities.
pub fn finite(document: &Document, value: &Spanned<f64>) -> Result<f64, IngestError> {
    let number = *value.get_ref();
    if number.is_finite() {
        Ok(number)
    } else {
        Err(document.malformed(value.span(), "a finite number", number.to_string(), "correct the number"))
    }
}
