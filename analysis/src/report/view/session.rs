//! What a page says of sessions and materials.

use std::collections::BTreeMap;

use serde::Serialize;

use pneuval_ingest::units::Unit;

use super::budget;
use crate::format;
use crate::results::{
    AlignmentRecord, CensusRecord, ChannelRecord, Comparison, DatasetRecord, EstimateRecord, LagRecord, MaterialRecord,
    PhotographRecord, RunRecord, TableRecord,
};

/// A session.
#[derive(Serialize)]
pub struct SessionView {
    pub title: String,
    pub synthetic: bool,
    /// Name and value, such as date and specimen.
    pub facts: Vec<(String, String)>,
    pub runs: Vec<RunView>,
    pub channels: Vec<ChannelView>,
    pub census: Vec<String>,
    /// What is known of branches, cycles and repeats.
    pub ways: Vec<String>,
    pub clocks: Vec<ClockView>,
    pub lags: Vec<LagView>,
    pub photographs: Vec<PhotographView>,
}

/// A photograph with what was measured in it.
#[derive(Serialize)]
pub struct PhotographView {
    pub path: String,
    pub run: String,
    pub name: String,
    pub label: String,
    pub refused: Option<String>,
    pub width: usize,
    pub height: usize,
    /// The picture itself, JPEG in base64; without it the page names its file.
    pub data: Option<String>,
}

/// A clock that events set on another.
#[derive(Serialize)]
pub struct ClockView {
    pub run: String,
    pub table: String,
    pub reference: String,
    /// Events used, of those found.
    pub events: String,
    pub offset: String,
    pub at: String,
    pub drift: String,
    pub residual: String,
}

/// The lag of a motion behind a pressure.
#[derive(Serialize)]
pub struct LagView {
    pub run: String,
    pub motion: String,
    pub pressure: String,
    pub lag: String,
    pub meaning: &'static str,
    pub correlation: String,
}

#[derive(Serialize)]
pub struct RunView {
    pub id: String,
    pub file: String,
    pub samples: usize,
    pub span: String,
    pub rate: String,
}

#[derive(Serialize)]
pub struct ChannelView {
    pub id: String,
    pub source: String,
    pub unit: String,
    pub instrument: String,
    pub std: String,
}

/// A material and where its law is stable.
#[derive(Serialize)]
pub struct MaterialView {
    pub id: String,
    pub law: String,
    pub shear_modulus: String,
    pub stable: String,
}

pub(super) fn session(
    dataset: &DatasetRecord,
    comparisons: &[&Comparison],
    photographs: Option<&BTreeMap<String, Vec<u8>>>,
) -> Option<SessionView> {
    let session = dataset.session.as_ref()?;
    let fact = |name: &str, value: &Option<String>| value.clone().map(|value| (name.to_owned(), value));
    let mut facts: Vec<(String, String)> =
        [fact("date", &session.date), fact("operator", &session.operator), fact("rig", &session.rig)]
            .into_iter()
            .flatten()
            .collect();
    facts.extend(session.specimen.iter().map(|(name, value)| (format!("specimen, {name}"), value.clone())));
    facts.push((
        "samples".to_owned(),
        format!(
            "{} read, {} excluded, {} lines skipped ({}; at most {} allowed)",
            session.samples_read,
            session.samples_excluded,
            session.lines_skipped,
            format::percent(session.excluded_share()),
            format::percent(session.excluded_share_max)
        ),
    ));
    let census = session.responses.iter().map(|r| {
        let table = |t: &TableRecord| format!("; {} of {} samples of {} with a hole", t.holes, t.samples, t.table);
        let tables: String = r.tables.iter().map(table).collect();
        // Points of a movement are where a prediction meets it: each comparison has its own.
        let used = if r.points == 0 && r.used > 0 {
            format!("{} in movements", r.used)
        } else {
            format!("{} in {} points", r.used, r.points)
        };
        format!("{}: {} samples, {} with a hole, {used}{tables}", r.quantity, r.samples, r.holes)
    });
    let way = |r: &CensusRecord| {
        let of = comparisons.iter().find(|c| c.dataset == dataset.id && c.quantity.id == r.quantity)?;
        Some(budget::way(r, of.quantity.unit()))
    };
    Some(SessionView {
        title: dataset.title.clone(),
        synthetic: session.synthetic,
        facts,
        runs: session.runs.iter().map(run).collect(),
        channels: session.channels.iter().map(channel).collect(),
        census: census.collect(),
        ways: session.responses.iter().filter_map(way).collect(),
        clocks: session.alignments.iter().map(clock).collect(),
        lags: session.lags.iter().map(lag).collect(),
        photographs: session.photographs.iter().filter_map(|p| photograph(p, photographs)).collect(),
    })
}

fn clock(clock: &AlignmentRecord) -> ClockView {
    let wide = |estimate: &EstimateRecord, factor: f64, unit: &str| {
        let half = factor * 0.5 * (estimate.upper - estimate.lower);
        format!("{} ± {} {unit}", format::significant(factor * estimate.value, 6), format::significant(half, 2))
    };
    let drift = clock.drift.as_ref().map(|drift| wide(drift, 1e6, "ppm"));
    let offset = clock.offset_s.as_ref().map(|offset| wide(offset, 1e3, "ms"));
    let s = |value: Option<f64>| value.map_or(String::new(), |value| format!("{} s", format::short(value)));
    ClockView {
        run: clock.run.clone(),
        table: clock.table.clone(),
        reference: clock.reference.clone(),
        events: format!("{} of {}, {}", clock.events_used, clock.events_reference, clock.events),
        // A clock that was not set says why.
        offset: offset.or_else(|| clock.refused.clone()).unwrap_or_default(),
        at: s(clock.at_s.map(|at| (at * 1e3).round() / 1e3)),
        drift: drift.unwrap_or_else(|| "not known".to_owned()),
        residual: clock
            .residual_s
            .map_or(String::new(), |residual| format!("{} ms", format::significant(1e3 * residual, 2))),
    }
}

/// A photograph, within the page if pictures are given, else by its file beside it.
fn photograph(record: &PhotographRecord, within: Option<&BTreeMap<String, Vec<u8>>>) -> Option<PhotographView> {
    use base64::Engine as _;
    let base64 = base64::engine::general_purpose::STANDARD;
    let data = match within {
        Some(pictures) => Some(base64.encode(pictures.get(&record.path)?)),
        None => None,
    };
    Some(PhotographView {
        path: record.path.clone(),
        run: record.run.clone(),
        name: record.name.clone(),
        label: record.label.clone(),
        refused: record.refused.clone(),
        width: record.width,
        height: record.height,
        data,
    })
}

fn lag(lag: &LagRecord) -> LagView {
    let found = lag
        .value_s
        .zip(lag.std_s)
        .map(|(value, std)| format!("{} ± {} ms", format::fixed(1e3 * value, 1), format::significant(2e3 * std, 2)));
    LagView {
        run: lag.run.clone(),
        motion: format!("{} of {}", lag.channel, lag.table),
        pressure: lag.pressure.clone(),
        lag: found.or_else(|| lag.refused.clone()).unwrap_or_default(),
        meaning: match lag.meaning.as_str() {
            "physical" => "of rig and specimen, kept",
            "clock" => "declared to be the clock's, taken out",
            _ => "of clocks, rig and specimen in sum, kept",
        },
        correlation: lag.correlation.map_or(String::new(), |correlation| format::fixed(correlation, 3)),
    }
}

fn run(run: &RunRecord) -> RunView {
    let text = |value: Option<f64>, unit: &str| value.map_or(String::new(), |v| format!("{} {unit}", format::short(v)));
    RunView {
        id: run.id.clone(),
        file: run.file.clone(),
        samples: run.samples,
        span: text(run.span_s, "s"),
        rate: text(run.rate_hz, "Hz"),
    }
}

fn channel(channel: &ChannelRecord) -> ChannelView {
    let unit = Unit::parse(&channel.unit);
    let std =
        channel.std_si.zip(unit).map(|(std, unit)| format::with_unit(&format::significant(unit.from_si(std), 3), unit));
    ChannelView {
        id: channel.id.clone(),
        source: channel.source.clone(),
        unit: channel.unit.clone(),
        instrument: channel.instrument.clone().unwrap_or_default(),
        std: std.unwrap_or_default(),
    }
}

pub(super) fn material(material: &MaterialRecord) -> MaterialView {
    let unstable: Vec<String> = material
        .unstable_from
        .iter()
        .filter_map(|(case, from)| from.map(|stretch| format!("{case} from {}", format::significant(stretch, 4))))
        .collect();
    let reach = format::short(material.stretch_max);
    MaterialView {
        id: material.id.clone(),
        law: material.law.clone(),
        shear_modulus: format!("{} kPa", format::significant(material.initial_shear_modulus_pa / 1e3, 4)),
        stable: if unstable.is_empty() {
            format!("stress rises up to a stretch of {reach} in every load case")
        } else {
            format!("stress stops rising: {}", unstable.join(", "))
        },
    }
}
