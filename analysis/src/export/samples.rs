//! A run as tables: the channels of each clock, and beside them what every comparison predicts at each sample.
//!
//! Equal states (pressures and conditions, to the bit) are solved once: a staircase of a hundred thousand samples is a handful of
//! equations. Nothing is interpolated.

use std::collections::HashMap;

use pneuval_ingest::manifest::{DerivedRule, DerivedSpec, ResponseSpec};
use pneuval_ingest::session::{Channel, Run, Session};
use pneuval_ingest::store::TIME;
use pneuval_ingest::units::Unit;

use super::record::LeftOut;
use super::table::{Head, Origin, Table};
use super::{Compared, Export, form_of};
use crate::align::AlignedRun;
use crate::prediction::{Predicted, Predictor};
use crate::response::{Response, without_rounding};

/// The samples of a run that share a clock.
pub(super) struct Samples {
    /// The table of the log that they come from; empty where it has one only.
    pub stream: String,
    /// The instant that their stamps count from, where the log dates them.
    pub origin: Option<String>,
    /// Whether the first column is time.
    pub has_clock: bool,
    pub table: Table,
}

/// The tables of a run, and the predictions that are in none of them.
pub(super) fn of_run(export: &Export, session: &Session, aligned: &AlignedRun) -> (Vec<Samples>, Vec<LeftOut>) {
    let run = aligned.run;
    let mut all: Vec<Samples> = (0..run.streams.len()).map(|stream| channels(session, aligned, stream)).collect();
    let mut left_out = Vec::new();
    for (index, (response, spec)) in export.study.responses.iter().zip(&session.manifest.responses).enumerate() {
        let of_response = export.compared.iter().filter(|compared| compared.response == index);
        let mut predicting = Vec::new();
        for compared in of_response {
            match compared.posed.between.predictor() {
                Ok(predictor) => predicting.push((compared, predictor)),
                Err(why) => {
                    left_out.push(LeftOut::new(format!("{} at every sample", form_of(compared.spec)), why.to_owned()));
                }
            }
        }
        if predicting.is_empty() {
            continue;
        }
        let Some(states) = States::of(run, spec, response) else {
            let why = format!("its pressures and conditions in run {} are on several clocks", run.id);
            left_out.extend(predicting.iter().map(|(of, _)| LeftOut::new(form_of(of.spec), why.clone())));
            continue;
        };
        if let Some(samples) = all.get_mut(states.stream) {
            for (compared, predictor) in predicting {
                predict(&mut samples.table, compared, predictor, response, &states);
            }
        }
    }
    (all, left_out)
}

/// Time and channels of a clock, in the order of the manifest.
fn channels(session: &Session, aligned: &AlignedRun, stream: usize) -> Samples {
    let run = aligned.run;
    let mut table = Table::default();
    let clock = &run.streams[stream];
    if let Some(seconds) = aligned.seconds(stream) {
        let note = aligned.epoch(stream).map(|epoch| format!("counts from {epoch}"));
        // The name of the store's column, which is the word `time` with its unit.
        let base = TIME.strip_suffix("_s").unwrap_or(TIME);
        table.numbers(Head { note, ..Head::new(base, "Time", Origin::Time) }, Unit::SECOND, seconds.iter().copied());
    }
    let manifest = &session.manifest;
    let derived = |id: &str| manifest.derived.iter().find(|derived| derived.id == id);
    let ids = manifest.channels.iter().map(|c| &c.id).chain(manifest.derived.iter().map(|d| &d.id));
    for (id, channel) in ids.filter_map(|id| Some((id, run.channels.get(id)?))).filter(|(_, c)| c.stream == stream) {
        let is_said = id.contains("commanded");
        let base = if channel.commanded && !is_said { format!("{id}-commanded") } else { id.clone() };
        let note = derived(id).map(rule);
        let origin = match (channel.commanded, &note) {
            (true, _) => Origin::Commanded,
            (false, Some(_)) => Origin::Derived,
            (false, None) => Origin::Measured,
        };
        let head = Head { note, ..Head::new(&base, &title(session, id), origin) };
        table.numbers(head, channel.unit, channel.values_si.iter().copied());
    }
    let origin = aligned.epoch(stream).map(|epoch| epoch.to_string());
    let parts = [clock.device.as_deref().unwrap_or_default(), &clock.name];
    let stream = parts.into_iter().filter(|part| !part.is_empty()).collect::<Vec<_>>().join(".");
    Samples { stream, origin, has_clock: clock.seconds.is_some(), table }
}

/// How a channel is derived.
fn rule(derived: &DerivedSpec) -> String {
    let rule = match derived.rule {
        DerivedRule::Difference => "difference",
        DerivedRule::Product => "product",
        DerivedRule::Displacement => "displacement",
        DerivedRule::TransmitterDistance => "distance from the transmitter, less that at the start",
    };
    format!("{rule} of {}", derived.from.join(", "))
}

/// What a channel is called on pages: by what it is in a response, or else by its id.
fn title(session: &Session, id: &str) -> String {
    let of = |spec: &ResponseSpec| {
        if let Some((_, chamber)) = spec.pressure.iter().find(|(channel, _)| channel == id) {
            return Some(format!("Gauge pressure, {chamber}"));
        }
        if let Some(condition) = spec.conditions.iter().find(|condition| condition.channel == id) {
            return Some(condition.title.clone());
        }
        let index = spec.measured.iter().position(|channel| channel == id)?;
        Some(component_title(&spec.quantity.title, spec.quantity.components.get(index)))
    };
    session.manifest.responses.iter().find_map(of).unwrap_or_else(|| id.to_owned())
}

/// `Tip position, x`.
pub(super) fn component_title(title: &str, component: Option<&String>) -> String {
    component.map_or_else(|| title.to_owned(), |component| format!("{title}, {component}"))
}

/// `tip-x-predicted-fea`.
pub(super) fn component_base(quantity: &str, component: Option<&String>, what: &str) -> String {
    component.map_or_else(|| format!("{quantity}-{what}"), |component| format!("{quantity}-{component}-{what}"))
}

/// The states of a run: which of them each sample is in.
struct States {
    stream: usize,
    /// Per sample; `None` where a pressure or condition is a hole.
    of_sample: Vec<Option<usize>>,
    /// Gauge pressures in Pa and conditions in SI units, in the order in which they occur.
    distinct: Vec<(Vec<f64>, Vec<f64>)>,
}

impl States {
    /// `None` if pressures and conditions do not share a clock.
    fn of(run: &Run, spec: &ResponseSpec, response: &Response) -> Option<Self> {
        let channel = |id: &String| run.channels.get(id);
        let pressures = spec.pressure.iter().map(|(id, _)| channel(id)).collect::<Option<Vec<&Channel>>>()?;
        let conditions = spec.conditions.iter().map(|c| channel(&c.channel)).collect::<Option<Vec<&Channel>>>()?;
        let mut streams = pressures.iter().chain(&conditions).map(|channel| channel.stream);
        let stream = streams.next()?;
        if !streams.all(|other| other == stream) {
            return None;
        }
        let mut states = Self { stream, of_sample: Vec::new(), distinct: Vec::new() };
        let mut known: HashMap<Vec<u64>, usize> = HashMap::new();
        let mut key = Vec::new();
        for i in 0..run.streams.get(stream)?.samples {
            let pressures = pressures.iter().map(|c| without_rounding(c.values_si[i], response.rounding_pa));
            let conditions = conditions.iter().map(|c| c.values_si[i]);
            key.clear();
            // Adding zero makes a negative zero a positive one.
            key.extend(pressures.clone().chain(conditions.clone()).map(|v| (v + 0.0).to_bits()));
            if key.iter().any(|bits| !f64::from_bits(*bits).is_finite()) {
                states.of_sample.push(None);
                continue;
            }
            let state = known.get(&key).copied().unwrap_or_else(|| {
                known.insert(key.clone(), states.distinct.len());
                states.distinct.push((pressures.collect(), conditions.collect()));
                states.distinct.len() - 1
            });
            states.of_sample.push(Some(state));
        }
        Some(states)
    }
}

/// Adds what a comparison predicts at each sample, one column a component; a hole where the model has no value.
fn predict(table: &mut Table, compared: &Compared, predictor: &dyn Predictor, response: &Response, states: &States) {
    let quantity = &response.quantity;
    let values: Vec<Option<Vec<f64>>> = states
        .distinct
        .iter()
        .map(|(pressures, conditions)| match predictor.at(pressures, conditions) {
            Predicted::Value(values) => Some(values.iter().map(|value| quantity.unit.to_written(value.si)).collect()),
            _ => None,
        })
        .collect();
    let form = &compared.spec.form;
    for component in 0..quantity.width() {
        let name = quantity.components.get(component);
        let base = component_base(&quantity.id, name, &format!("predicted-{form}"));
        let title = format!("{}: {}", component_title(&quantity.title, name), compared.title());
        let head =
            Head { form: Some(form.clone()), note: compared.note(), ..Head::new(&base, &title, Origin::Predicted) };
        let at = |state: &Option<usize>| -> f64 {
            let values = state.and_then(|state| values[state].as_ref());
            values.and_then(|values| values.get(component)).copied().filter(|v| v.is_finite()).unwrap_or(f64::NAN)
        };
        table.written(head, quantity.unit, states.of_sample.iter().map(at).collect());
    }
}
