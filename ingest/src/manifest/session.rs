//! `session.toml`: one sitting at a rig: which files, which column is which channel, what is measured against what.

use std::collections::BTreeMap;

use serde::Deserialize;
use toml::Spanned;

use super::comparison::{
    Comparable, ComparisonSpec, OneOrMany, Quantity, RawComparison, RawQuantity, check_width, comparisons,
};
use super::{check_id, check_inside, check_schema};
use crate::digest;
use crate::document::{Document, finite, parse_unit};
use crate::error::{IngestError, shown, suggestion};
use crate::formats::csv::{self, CsvOptions};
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
    pub reader: CsvOptions,
    /// Where time comes from; without it rows are states, not moments.
    pub clock: Option<ClockSpec>,
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

/// A column of a log, by name or by number from 1.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum ColumnRef {
    /// As in the header.
    Name(String),
    /// From the left, the first is 1.
    Number(usize),
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
        /// Line of the file.
        line: usize,
    },
    /// A stated rate, in Hz.
    Rate(f64),
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
    /// Rows of the file that belong to it: those with this text in this column.
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
    /// Channel and chamber.
    pub pressure: Vec<(String, String)>,
    /// Channels of the components.
    pub measured: Vec<String>,
    /// How it was measured.
    pub method: String,
    /// Channel and id of what is set beside the pressure.
    pub conditions: Vec<ConditionSpec>,
    /// How samples become points.
    pub points: PointRule,
    /// Gauge pressures so near zero are the zero-pressure reference, in Pa; 0.5 % of the largest pressure where absent.
    pub zero_within_pa: Option<f64>,
    /// Line of the file.
    pub line: usize,
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

/// How samples become points of a response.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum PointRule {
    /// Every sample is a point: a log of steady states.
    Samples,
    /// Every stretch of steady pressure is a point: the mean over its end.
    Plateaus {
        /// How far the pressure may be from the stretch's mean, in Pa.
        tolerance_pa: f64,
        /// How long a stretch must last, in s.
        hold_s: f64,
        /// The end of it that is averaged, in s.
        window_s: f64,
    },
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Raw {
    schema: Spanned<i64>,
    id: Spanned<String>,
    actuator: Spanned<String>,
    title: Option<String>,
    rig: Option<Spanned<String>>,
    date: Option<String>,
    operator: Option<String>,
    #[serde(default)]
    synthetic: bool,
    specimen: Option<Specimen>,
    #[serde(default)]
    notes: Vec<String>,
    excluded_max: Option<RawAmount>,
    #[serde(default)]
    reader: RawReader,
    clock: Option<Spanned<RawClock>>,
    #[serde(default)]
    channel: Vec<RawChannel>,
    #[serde(default)]
    derived: Vec<RawDerived>,
    #[serde(default)]
    run: Vec<RawRun>,
    #[serde(default)]
    response: Vec<RawResponse>,
    #[serde(default)]
    comparison: Vec<RawComparison>,
}

/// `{ value, unit }`.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawAmount {
    value: Spanned<f64>,
    unit: Spanned<String>,
}

impl RawAmount {
    /// The amount in SI units: positive, of a dimension.
    fn checked(&self, document: &Document, dimension: Dimension) -> Result<f64, IngestError> {
        let unit = parse_unit(document, &self.unit)?;
        if unit.dimension != dimension {
            let found = format!("unit `{}`", unit.symbol);
            return Err(document.malformed(self.unit.span(), dimension.name(), found, "correct the unit"));
        }
        let value = finite(document, &self.value)?;
        if value > 0.0 && unit.to_si(value).is_finite() {
            return Ok(unit.to_si(value));
        }
        Err(document.malformed(self.value.span(), "a number > 0", value.to_string(), "correct it"))
    }
}

#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields)]
struct RawReader {
    delimiter: Option<Delimiter>,
    decimal: Option<Decimal>,
    header: Option<Header>,
    skip_lines: Option<usize>,
    comment: Option<CommentMark>,
}

#[derive(Clone, Copy, Deserialize)]
enum CommentMark {
    #[serde(rename = "#")]
    Hash,
    #[serde(rename = "%")]
    Percent,
    #[serde(rename = "//")]
    Slashes,
    #[serde(rename = "none")]
    None,
}

#[derive(Clone, Copy, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum Delimiter {
    Comma,
    Semicolon,
    Tab,
    Pipe,
    Space,
}

#[derive(Clone, Copy, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum Decimal {
    Point,
    Comma,
}

#[derive(Clone, Copy, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum Header {
    None,
    Names,
    NamesAndUnits,
}

#[derive(Clone, Deserialize)]
#[serde(untagged)]
enum RawColumn {
    Number(i64),
    Name(String),
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawClock {
    column: Option<Spanned<RawColumn>>,
    unit: Option<Spanned<String>>,
    rate: Option<RawAmount>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawChannel {
    id: Spanned<String>,
    column: Spanned<RawColumn>,
    unit: Option<Spanned<String>>,
    instrument: Option<String>,
    reference: Option<PressureReference>,
    #[serde(default)]
    commanded: bool,
    tare_samples: Option<Spanned<usize>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawDerived {
    id: Spanned<String>,
    rule: DerivedRule,
    from: Spanned<Vec<String>>,
    unit: Spanned<String>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawRun {
    id: Option<Spanned<String>>,
    file: Spanned<String>,
    rows: Option<RawRows>,
    atmosphere: Option<RawAmount>,
    #[serde(default)]
    zero: BTreeMap<Spanned<String>, RawAmount>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawRows {
    column: Spanned<RawColumn>,
    equals: String,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawResponse {
    quantity: RawQuantity,
    pressure: Spanned<Vec<RawPressure>>,
    measured: RawMeasured,
    #[serde(default)]
    condition: Vec<RawCondition>,
    points: Option<RawPoints>,
    zero_within: Option<RawAmount>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawPressure {
    channel: Spanned<String>,
    chamber: Spanned<String>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawMeasured {
    channel: Spanned<OneOrMany>,
    #[serde(default)]
    method: String,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawCondition {
    channel: Spanned<String>,
    id: Option<Spanned<String>>,
    title: Option<String>,
}

/// `{ from = "samples" }`, or `{ from = "plateaus", tolerance, hold, window }`.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawPoints {
    from: Spanned<PointSource>,
    tolerance: Option<RawAmount>,
    hold: Option<RawAmount>,
    window: Option<RawAmount>,
}

#[derive(Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum PointSource {
    Samples,
    Plateaus,
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
        let mut ids: Vec<String> = Vec::new();
        let channels = raw
            .channel
            .iter()
            .map(|channel| channel.checked(&document, &mut ids))
            .collect::<Result<Vec<_>, IngestError>>()?;
        if let Some(channel) = channels.iter().find(|c| c.instrument.is_some())
            && raw.rig.is_none()
        {
            let next = "add rig = \"…\", the id of a rig.toml here or above";
            return Err(document.malformed_at(channel.line, "key `rig` of the session", "nothing", next));
        }
        // Before derived ones are added: a zero is set at an instrument.
        let runs = runs(&document, &raw.run, &raw.id, &ids)?;
        let derived = raw
            .derived
            .iter()
            .map(|derived| derived.checked(&document, &mut ids))
            .collect::<Result<Vec<_>, IngestError>>()?;
        let responses = responses(&document, &raw.response, &ids, raw.clock.is_some())?;
        let comparable: Vec<Comparable> =
            responses.iter().map(|r| Comparable { quantity: &r.quantity.id, columns: vec![] }).collect();
        let comparisons = comparisons(&document, &raw.comparison, &comparable)?;
        let excluded = raw.excluded_max.as_ref().map(|share| share.checked(&document, Dimension::Ratio)).transpose()?;
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
            reader: raw.reader.options(),
            clock: raw.clock.as_ref().map(|clock| clock.get_ref().checked(&document, clock)).transpose()?,
            channels,
            derived,
            runs,
            responses,
            comparisons,
            file: file.to_owned(),
            sha256: digest::sha256(bytes),
        })
    }

    /// The channels that responses need, with those behind derived ones.
    pub fn required(&self) -> Vec<&str> {
        let mut needed: Vec<&str> = Vec::new();
        for response in &self.responses {
            needed.extend(response.pressure.iter().map(|(channel, _)| channel.as_str()));
            needed.extend(response.measured.iter().map(String::as_str));
            needed.extend(response.conditions.iter().map(|c| c.channel.as_str()));
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

impl RawReader {
    fn options(&self) -> CsvOptions {
        CsvOptions {
            delimiter: self.delimiter.map(|d| match d {
                Delimiter::Comma => b',',
                Delimiter::Semicolon => b';',
                Delimiter::Tab => b'\t',
                Delimiter::Pipe => b'|',
                Delimiter::Space => b' ',
            }),
            decimal: self.decimal.map(|d| match d {
                Decimal::Point => csv::Decimal::Point,
                Decimal::Comma => csv::Decimal::Comma,
            }),
            header: match self.header {
                None => csv::Header::Auto,
                Some(Header::None) => csv::Header::None,
                Some(Header::Names) => csv::Header::Names,
                Some(Header::NamesAndUnits) => csv::Header::NamesAndUnits,
            },
            skip_lines: self.skip_lines,
            comments: self.comment.map(|c| match c {
                CommentMark::Hash => csv::Comments::Of(csv::Comment::Hash),
                CommentMark::Percent => csv::Comments::Of(csv::Comment::Percent),
                CommentMark::Slashes => csv::Comments::Of(csv::Comment::Slashes),
                CommentMark::None => csv::Comments::None,
            }),
        }
    }
}

fn column(document: &Document, raw: &Spanned<RawColumn>) -> Result<ColumnRef, IngestError> {
    match raw.get_ref() {
        RawColumn::Name(name) => Ok(ColumnRef::Name(name.clone())),
        RawColumn::Number(number) => match usize::try_from(*number) {
            Ok(number) if number >= 1 => Ok(ColumnRef::Number(number)),
            _ => {
                let expected = "a column's name, or its number from 1";
                Err(document.malformed(raw.span(), expected, number.to_string(), "correct it"))
            }
        },
    }
}

impl RawClock {
    fn checked<T>(&self, document: &Document, all: &Spanned<T>) -> Result<ClockSpec, IngestError> {
        match (&self.column, &self.rate) {
            (Some(name), None) => Ok(ClockSpec::Column {
                column: column(document, name)?,
                unit: self
                    .unit
                    .as_ref()
                    .map(|unit| {
                        let parsed = parse_unit(document, unit)?;
                        if parsed.dimension == Dimension::Time {
                            return Ok(parsed);
                        }
                        let found = format!("unit `{}`", parsed.symbol);
                        Err(document.malformed(unit.span(), Dimension::Time.name(), found, "correct the unit"))
                    })
                    .transpose()?,
                line: document.line_of(name.span().start),
            }),
            (None, Some(rate)) => Ok(ClockSpec::Rate(rate.checked(document, Dimension::Frequency)?)),
            _ => {
                let expected = "either `column` (with `unit`) or `rate`";
                Err(document.malformed(all.span(), expected, "both or none", "keep one"))
            }
        }
    }
}

/// Every channel id once.
fn new_id(document: &Document, id: &Spanned<String>, ids: &mut Vec<String>) -> Result<String, IngestError> {
    let checked = channel_id(document, id)?;
    if ids.contains(&checked) {
        let found = format!("`{checked}` twice");
        return Err(document.malformed(id.span(), "every channel once", found, "rename one"));
    }
    ids.push(checked.clone());
    Ok(checked)
}

/// Channels may also be named with `_`, as models' inputs are.
fn channel_id(document: &Document, id: &Spanned<String>) -> Result<String, IngestError> {
    let text = id.get_ref();
    if super::is_id(&text.replace('_', "-")) {
        return Ok(text.clone());
    }
    let expected = "an id of lower-case letters, digits, `-`, `_` and `.`";
    Err(document.malformed(id.span(), expected, shown(text), "rename it"))
}

impl RawChannel {
    fn checked(&self, document: &Document, ids: &mut Vec<String>) -> Result<ChannelSpec, IngestError> {
        if let Some(samples) = &self.tare_samples
            && *samples.get_ref() == 0
        {
            return Err(document.malformed(samples.span(), "at least one sample", "0", "leave it out for no tare"));
        }
        Ok(ChannelSpec {
            id: new_id(document, &self.id, ids)?,
            column: column(document, &self.column)?,
            unit: self.unit.as_ref().map(|unit| parse_unit(document, unit)).transpose()?,
            instrument: self.instrument.clone(),
            reference: self.reference,
            commanded: self.commanded,
            tare_samples: self.tare_samples.as_ref().map(|samples| *samples.get_ref()),
            line: document.line_of(self.id.span().start),
        })
    }
}

impl RawDerived {
    fn checked(&self, document: &Document, ids: &mut Vec<String>) -> Result<DerivedSpec, IngestError> {
        let from = self.from.get_ref();
        if let Some(name) = from.iter().find(|name| !ids.contains(name)) {
            let next = suggestion(name, ids.iter().map(String::as_str));
            return Err(document.malformed(self.from.span(), "channels above", shown(name), next));
        }
        let (count, expected) = match self.rule {
            DerivedRule::Difference | DerivedRule::Product => (2..=2, "two channels"),
            DerivedRule::Displacement | DerivedRule::TransmitterDistance => (2..=3, "two or three coordinates"),
        };
        if !count.contains(&from.len()) {
            return Err(document.malformed(self.from.span(), expected, from.len().to_string(), "name them"));
        }
        Ok(DerivedSpec {
            id: new_id(document, &self.id, ids)?,
            rule: self.rule,
            from: from.clone(),
            unit: parse_unit(document, &self.unit)?,
            line: document.line_of(self.id.span().start),
        })
    }
}

fn runs(
    document: &Document,
    raw: &[RawRun],
    session: &Spanned<String>,
    channels: &[String],
) -> Result<Vec<RunSpec>, IngestError> {
    if raw.is_empty() {
        return Err(document.malformed(session.span(), "at least one [[run]]", "none", "add a [[run]] with its file"));
    }
    let mut ids: BTreeMap<String, usize> = BTreeMap::new();
    raw.iter()
        .map(|run| {
            check_inside(document, &run.file)?;
            let line = document.line_of(run.file.span().start);
            let id = match &run.id {
                Some(id) => check_id(document, id)?,
                // A name for people; a file may be called anything.
                None => run.file.get_ref().clone(),
            };
            if let Some(first) = ids.insert(id.clone(), line) {
                let span = run.id.as_ref().map_or(run.file.span(), Spanned::span);
                let found = format!("{} twice, the first at line {first}", shown(&id));
                return Err(document.malformed(span, "every run once", found, "give it an `id` of its own"));
            }
            Ok(RunSpec {
                id,
                file: run.file.get_ref().clone(),
                rows: run
                    .rows
                    .as_ref()
                    .map(|rows| Ok::<_, IngestError>((column(document, &rows.column)?, rows.equals.clone())))
                    .transpose()?,
                zero: run
                    .zero
                    .iter()
                    .map(|(channel, amount)| {
                        let name = channel.get_ref();
                        if !channels.contains(name) {
                            let next = suggestion(name, channels.iter().map(String::as_str));
                            return Err(document.malformed(channel.span(), "a channel above", shown(name), next));
                        }
                        let unit = parse_unit(document, &amount.unit)?;
                        Ok((name.clone(), (finite(document, &amount.value)?, unit)))
                    })
                    .collect::<Result<_, _>>()?,
                atmosphere_pa: run.atmosphere.as_ref().map(|a| a.checked(document, Dimension::Pressure)).transpose()?,
                line,
            })
        })
        .collect()
}

fn responses(
    document: &Document,
    raw: &[RawResponse],
    ids: &[String],
    clock: bool,
) -> Result<Vec<ResponseSpec>, IngestError> {
    let known = |name: &Spanned<String>| -> Result<String, IngestError> {
        if ids.contains(name.get_ref()) {
            return Ok(name.get_ref().clone());
        }
        let next = suggestion(name.get_ref(), ids.iter().map(String::as_str));
        Err(document.malformed(name.span(), "a channel above", shown(name.get_ref()), next))
    };
    let mut responses: Vec<ResponseSpec> = Vec::new();
    for r in raw {
        let quantity = r.quantity.checked(document)?;
        if responses.iter().any(|other| other.quantity.id == quantity.id) {
            let found = format!("`{}` twice", quantity.id);
            return Err(document.malformed(r.quantity.id.span(), "one response per quantity", found, "merge them"));
        }
        check_width(document, &r.measured.channel, &quantity)?;
        let names = r.measured.channel.get_ref().names();
        if let Some(name) = names.iter().find(|name| !ids.contains(name)) {
            let next = suggestion(name, ids.iter().map(String::as_str));
            return Err(document.malformed(r.measured.channel.span(), "a channel above", shown(name), next));
        }
        let mut pressure: Vec<(String, String)> = Vec::new();
        for p in r.pressure.get_ref() {
            let chamber = check_id(document, &p.chamber)?;
            if pressure.iter().any(|(_, c)| *c == chamber) {
                let found = format!("`{chamber}` twice");
                return Err(document.malformed(p.chamber.span(), "every chamber once", found, "rename one"));
            }
            pressure.push((known(&p.channel)?, chamber));
        }
        if pressure.is_empty() {
            let next = "name the channel of the pressure and its chamber";
            return Err(document.malformed(r.pressure.span(), "at least one pressure", "none", next));
        }
        let mut conditions: Vec<ConditionSpec> = Vec::new();
        for c in &r.condition {
            let channel = known(&c.channel)?;
            let id = c.id.as_ref().map_or(Ok(channel.clone()), |id| channel_id(document, id))?;
            let title = c.title.clone().unwrap_or_else(|| id.replace('_', " "));
            conditions.push(ConditionSpec { channel, id, title });
        }
        responses.push(ResponseSpec {
            quantity,
            pressure,
            measured: names.to_vec(),
            method: r.measured.method.clone(),
            conditions,
            zero_within_pa: r.zero_within.as_ref().map(|z| z.checked(document, Dimension::Pressure)).transpose()?,
            points: r.points.as_ref().map_or(Ok(PointRule::Samples), |points| points.checked(document, clock))?,
            line: document.line_of(r.quantity.id.span().start),
        });
    }
    Ok(responses)
}

impl RawPoints {
    fn checked(&self, document: &Document, clock: bool) -> Result<PointRule, IngestError> {
        match (self.from.get_ref(), &self.tolerance, &self.hold, &self.window) {
            (PointSource::Samples, None, None, None) => Ok(PointRule::Samples),
            (PointSource::Samples, ..) => {
                let next = "remove them, or say from = \"plateaus\"";
                let found = "tolerance, hold or window";
                Err(document.malformed(self.from.span(), "nothing beside from = \"samples\"", found, next))
            }
            (PointSource::Plateaus, Some(tolerance), Some(hold), Some(window)) => {
                if !clock {
                    let next = "add [clock] with `column` and `unit`, or with `rate`";
                    return Err(document.malformed(self.from.span(), "a clock, to find plateaus by", "none", next));
                }
                let hold_s = hold.checked(document, Dimension::Time)?;
                let window_s = window.checked(document, Dimension::Time)?;
                if window_s > hold_s {
                    let expected = format!("at most the hold of {hold_s} s");
                    let next = "a window lies inside its plateau";
                    return Err(document.malformed(window.value.span(), expected, format!("{window_s} s"), next));
                }
                let tolerance_pa = tolerance.checked(document, Dimension::Pressure)?;
                Ok(PointRule::Plateaus { tolerance_pa, hold_s, window_s })
            }
            (PointSource::Plateaus, ..) => {
                let next = "add what is missing, each as { value, unit }";
                let expected = "`tolerance`, `hold` and `window` beside from = \"plateaus\"";
                Err(document.malformed(self.from.span(), expected, "not all of them", next))
            }
        }
    }
}
