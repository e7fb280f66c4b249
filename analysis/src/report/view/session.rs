//! What a page says of sessions and materials.

use serde::Serialize;

use pneuval_ingest::units::Unit;

use crate::format;
use crate::results::{ChannelRecord, DatasetRecord, MaterialRecord, RunRecord, TableRecord};

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

pub(super) fn session(dataset: &DatasetRecord) -> Option<SessionView> {
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
    Some(SessionView {
        title: dataset.title.clone(),
        synthetic: session.synthetic,
        facts,
        runs: session.runs.iter().map(run).collect(),
        channels: session.channels.iter().map(channel).collect(),
        census: census.collect(),
    })
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
