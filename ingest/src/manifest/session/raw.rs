//! `session.toml` as it is written, and the way from there to what is checked.

use std::collections::BTreeMap;
use std::ops::Range;

use serde::Deserialize;
use toml::Spanned;

use super::camera::RawCamera;
use super::device::{self, Clocks, DeviceSpec, RawDevice};
use super::follows::RawFollows;
use super::points::{Abscissa, PointRule, RawPoints};
use super::sync::{LagMeaning, RawSync};
use super::{
    Branches, ChannelSpec, ClockSpec, ConditionSpec, Cycles, DerivedRule, DerivedSpec, PressureReference, ResponseSpec,
    RunSpec, Specimen, Stamp,
};
use crate::document::{Amount, Document, parse_unit};
use crate::error::{IngestError, shown, suggestion};
use crate::formats::csv::{self, CsvOptions};
use crate::formats::pictures::PictureOptions;
use crate::formats::tracker::TrackerOptions;
use crate::formats::{Format, Options};
use crate::manifest::comparison::{OneOrMany, RawComparison, RawQuantity, check_width};
use crate::manifest::{check_id, check_inside, is_id};
use crate::recording::ColumnRef;
use crate::units::Dimension;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Raw {
    pub schema: Spanned<i64>,
    pub id: Spanned<String>,
    pub actuator: Spanned<String>,
    pub title: Option<String>,
    pub rig: Option<Spanned<String>>,
    pub date: Option<String>,
    pub operator: Option<String>,
    #[serde(default)]
    pub synthetic: bool,
    pub specimen: Option<Specimen>,
    #[serde(default)]
    pub notes: Vec<String>,
    pub excluded_max: Option<Amount>,
    #[serde(default)]
    pub reader: RawReader,
    pub clock: Option<Spanned<RawClock>>,
    #[serde(default)]
    pub clocks: Clocks,
    pub lag: Option<Spanned<LagMeaning>>,
    #[serde(default)]
    pub sync: Vec<RawSync>,
    #[serde(default)]
    pub device: Vec<RawDevice>,
    #[serde(default)]
    pub channel: Vec<RawChannel>,
    #[serde(default)]
    pub derived: Vec<RawDerived>,
    #[serde(default)]
    pub run: Vec<RawRun>,
    #[serde(default)]
    pub response: Vec<RawResponse>,
    #[serde(default)]
    pub comparison: Vec<RawComparison>,
}

#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(in crate::manifest) struct RawReader {
    format: Option<Spanned<String>>,
    delimiter: Option<Delimiter>,
    decimal: Option<Decimal>,
    header: Option<Header>,
    skip_lines: Option<usize>,
    comment: Option<CommentMark>,
    quality_max: Option<u32>,
    camera: Option<Spanned<RawCamera>>,
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

/// A column by its name or number.
#[derive(Debug, Clone, Deserialize)]
#[serde(untagged)]
pub(in crate::manifest) enum RawColumn {
    Number(i64),
    Name(String),
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawClock {
    column: Option<Spanned<RawColumn>>,
    unit: Option<Spanned<String>>,
    wrap: Option<Spanned<Amount>>,
    rate: Option<Amount>,
    stamp: Option<Stamp>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawChannel {
    id: Spanned<String>,
    device: Option<Spanned<String>>,
    column: Spanned<RawColumn>,
    unit: Option<Spanned<String>>,
    instrument: Option<String>,
    reference: Option<PressureReference>,
    #[serde(default)]
    commanded: bool,
    tare_samples: Option<Spanned<usize>>,
    follows: Option<RawFollows>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawDerived {
    id: Spanned<String>,
    rule: DerivedRule,
    pub from: Spanned<Vec<String>>,
    unit: Spanned<String>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawRun {
    id: Option<Spanned<String>>,
    pub file: Spanned<String>,
    #[serde(default)]
    pub files: BTreeMap<Spanned<String>, Spanned<String>>,
    rows: Option<RawRows>,
    atmosphere: Option<Amount>,
    #[serde(default)]
    zero: BTreeMap<Spanned<String>, Amount>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawRows {
    column: Spanned<RawColumn>,
    equals: String,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawResponse {
    quantity: RawQuantity,
    pressure: Option<Spanned<Vec<RawPressure>>>,
    measured: RawMeasured,
    #[serde(default)]
    condition: Vec<RawCondition>,
    points: Option<RawPoints>,
    zero_within: Option<Amount>,
    cycles: Option<Spanned<Cycles>>,
    branches: Option<Spanned<Branches>>,
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
    tare: Option<Spanned<RawTare>>,
}

/// Said in words, so that another kind of tare may come.
#[derive(Clone, Copy, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum RawTare {
    ZeroPressure,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawCondition {
    channel: Spanned<String>,
    id: Option<Spanned<String>>,
    title: Option<String>,
}

impl RawReader {
    pub fn options(&self, document: &Document) -> Result<Options, IngestError> {
        let known = |name: &Spanned<String>| {
            Format::ALL.into_iter().find(|format| format.id() == name.get_ref()).ok_or_else(|| {
                let next = suggestion(name.get_ref(), Format::ALL.map(Format::id));
                document.malformed(name.span(), "a format that is read", shown(name.get_ref()), next)
            })
        };
        Ok(Options {
            format: self.format.as_ref().map(known).transpose()?,
            csv: self.csv(),
            tracker: TrackerOptions { quality_max: self.quality_max },
            pictures: self.pictures(document)?,
        })
    }

    fn pictures(&self, document: &Document) -> Result<PictureOptions, IngestError> {
        let Some(camera) = &self.camera else { return Ok(PictureOptions::default()) };
        let options = camera.get_ref().options(document)?;
        let of_topic = options.topic.is_some();
        let expected = if of_topic { Format::Mcap } else { Format::Pictures };
        if let Some(other) = self.format.as_ref().filter(|format| format.get_ref() != expected.id()) {
            let beside = if of_topic { "`camera` of a `topic` with" } else { "`camera` with" };
            return Err(document.malformed(
                camera.span(),
                format!("{beside} format = \"{}\"", expected.id()),
                format!("format = \"{}\"", other.get_ref()),
                "pictures in a bag have a `topic`; a folder of them is format = \"pictures\"",
            ));
        }
        Ok(options)
    }

    fn csv(&self) -> CsvOptions {
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
    column_ref(document, raw.get_ref(), &raw.span())
}

/// A column of a log, as a manifest names it at a span.
pub(in crate::manifest) fn column_ref(
    document: &Document,
    raw: &RawColumn,
    span: &Range<usize>,
) -> Result<ColumnRef, IngestError> {
    match raw {
        RawColumn::Name(name) => Ok(ColumnRef::Name(name.clone())),
        RawColumn::Number(number) => match usize::try_from(*number) {
            Ok(number) if number >= 1 => Ok(ColumnRef::Number(number)),
            _ => {
                let expected = "a column's name, or its number from 1";
                Err(document.malformed(span.clone(), expected, number.to_string(), "correct it"))
            }
        },
    }
}

impl RawClock {
    pub fn checked<T>(&self, document: &Document, all: &Spanned<T>) -> Result<ClockSpec, IngestError> {
        let line = document.line_of(all.span().start);
        if let Some(wrap) = self.wrap.as_ref().filter(|_| self.column.is_none()) {
            let next = "remove it, or name the column of the counter";
            return Err(document.malformed(wrap.span(), "`wrap` beside `column`", "no `column`", next));
        }
        match (&self.column, &self.rate, self.stamp) {
            (None, None, Some(stamp)) => Ok(ClockSpec::Stamp(stamp, line)),
            (Some(name), None, None) => Ok(ClockSpec::Column {
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
                wrap_s: self.wrap.as_ref().map(|wrap| wrap.get_ref().checked(document, Dimension::Time)).transpose()?,
                line: document.line_of(name.span().start),
            }),
            (None, Some(rate), None) => Ok(ClockSpec::Rate(rate.checked(document, Dimension::Frequency)?)),
            _ => {
                let expected = "one of `column` (with `unit`), `rate` and `stamp`";
                Err(document.malformed(all.span(), expected, "several or none", "keep one"))
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
///
/// # Errors
/// [`IngestError::Malformed`] for other signs.
pub fn channel_id(document: &Document, id: &Spanned<String>) -> Result<String, IngestError> {
    let text = id.get_ref();
    if is_id(&text.replace('_', "-")) {
        return Ok(text.clone());
    }
    let expected = "an id of lower-case letters, digits, `-`, `_` and `.`";
    Err(document.malformed(id.span(), expected, shown(text), "rename it"))
}

impl RawChannel {
    pub fn checked(
        &self,
        document: &Document,
        devices: &[DeviceSpec],
        ids: &mut Vec<String>,
    ) -> Result<ChannelSpec, IngestError> {
        if let Some(samples) = &self.tare_samples
            && *samples.get_ref() == 0
        {
            return Err(document.malformed(samples.span(), "at least one sample", "0", "leave it out for no tare"));
        }
        Ok(ChannelSpec {
            id: new_id(document, &self.id, ids)?,
            device: self.device.as_ref().map(|id| device::known(document, devices, id)).transpose()?,
            column: column(document, &self.column)?,
            unit: self.unit.as_ref().map(|unit| parse_unit(document, unit)).transpose()?,
            instrument: self.instrument.clone(),
            reference: self.reference,
            commanded: self.commanded,
            tare_samples: self.tare_samples.as_ref().map(|samples| *samples.get_ref()),
            follows: self.follows.as_ref().map(|follows| follows.checked(document)).transpose()?,
            line: document.line_of(self.id.span().start),
        })
    }
}

impl RawDerived {
    pub fn checked(&self, document: &Document, ids: &mut Vec<String>) -> Result<DerivedSpec, IngestError> {
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

pub(super) fn runs(
    document: &Document,
    raw: &[RawRun],
    session: &Spanned<String>,
    channels: &[String],
    devices: &[DeviceSpec],
) -> Result<Vec<RunSpec>, IngestError> {
    if raw.is_empty() {
        return Err(document.malformed(session.span(), "at least one [[run]]", "none", "add a [[run]] with its file"));
    }
    device::check_files(document, devices, raw)?;
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
                files: run.files.iter().map(|(id, file)| (id.get_ref().clone(), file.get_ref().clone())).collect(),
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
                        Ok((name.clone(), amount.written(document)?))
                    })
                    .collect::<Result<_, _>>()?,
                atmosphere_pa: run.atmosphere.as_ref().map(|a| a.checked(document, Dimension::Pressure)).transpose()?,
                line,
            })
        })
        .collect()
}

pub(super) fn responses(
    document: &Document,
    raw: &[RawResponse],
    ids: &[String],
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
        for p in r.pressure.iter().flat_map(Spanned::get_ref) {
            let chamber = check_id(document, &p.chamber)?;
            if pressure.iter().any(|(_, c)| *c == chamber) {
                let found = format!("`{chamber}` twice");
                return Err(document.malformed(p.chamber.span(), "every chamber once", found, "rename one"));
            }
            pressure.push((known(&p.channel)?, chamber));
        }
        let points = r
            .points
            .as_ref()
            .map_or(Ok(PointRule::Samples { same_within_pa: 0.0 }), |points| points.checked(document))?;
        if pressure.is_empty() && points.path().is_none() {
            let next = "name the channel of the pressure and its chamber; only a trajectory at equal time or arc length needs none";
            let span = r.pressure.as_ref().map_or(r.quantity.id.span(), Spanned::span);
            return Err(document.malformed(span, "at least one pressure", "none", next));
        }
        if let Some(path) = points.path() {
            r.check_path(document, path.at)?;
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
            tare_at_zero: r.measured.tare.is_some(),
            cycles: r.cycles.as_ref().map(|cycles| *cycles.get_ref()),
            branches: r.branches.as_ref().map(|branches| *branches.get_ref()).unwrap_or_default(),
            conditions,
            zero_within_pa: r
                .zero_within
                .as_ref()
                .map(|z| z.not_negative(document, Dimension::Pressure))
                .transpose()?,
            points,
            line: document.line_of(r.quantity.id.span().start),
        });
    }
    Ok(responses)
}

impl RawResponse {
    /// What a path at equal time or arc length cannot heed: nothing of it is at zero pressure, under a condition or of a cycle.
    fn check_path(&self, document: &Document, at: Abscissa) -> Result<(), IngestError> {
        let refused = |span: Range<usize>, key: &str| {
            let expected = format!("no `{key}` beside at = \"{}\"", at.id());
            document.malformed(span, expected, "one", "remove it: nothing would heed it")
        };
        let said = [
            self.zero_within.as_ref().map(|zero| (zero.span(), "zero_within")),
            self.condition.first().map(|condition| (condition.channel.span(), "condition")),
            self.measured.tare.as_ref().map(|tare| (tare.span(), "tare")),
            self.cycles.as_ref().map(|cycles| (cycles.span(), "cycles")),
            self.branches.as_ref().map(|branches| (branches.span(), "branches")),
        ];
        said.into_iter().flatten().next().map_or(Ok(()), |(span, key)| Err(refused(span, key)))
    }
}
