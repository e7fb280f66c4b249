//! What `results.json` says of actuators, datasets, sessions and findings, beside the comparisons.

use std::collections::BTreeMap;

use pneuval_ingest::error::suggestion;
use pneuval_ingest::finding::{self, rate_hz};
use pneuval_ingest::manifest::{
    Actuator, ChannelSpec, ClockSpec, ColumnRef, ImportedModel, Material, PublishedDataset, Specimen,
};
use pneuval_ingest::session::{Run, Session};
use pneuval_models::catalogue::{LAWS, find, find_law};
use pneuval_models::materials::LoadCase;

use crate::AnalysisError;
use crate::align::{AlignedRun, Estimate, RunLag, StreamClock};
use crate::compare::errors::of_measured;
use crate::response::{Branch, Census, Response, ResponsePoint, TableCensus, Unmet, Unsure, loop_weights};
use crate::results::{
    ActuatorRecord, AlignmentRecord, CensusRecord, ChannelRecord, Comparison, DatasetRecord, EstimateRecord,
    FindingRecord, InputRecord, IntervalRecord, LagRecord, ListingRecord, MaterialRecord, RunMeetingRecord, RunRecord,
    SessionRecord, Severity, SourceFile, SpanRecord, StatedRecord, TableRecord, WayRecord,
};
use crate::study::{Data, Study};
use crate::uncertainty::errors::Errors;
use crate::uncertainty::pointwise::linear;

/// How far a material's stability is looked at: beyond any stretch of the papers' actuators.
const STRETCH_MAX: f64 = 4.0;

/// An actuator, its inputs and materials.
///
/// # Errors
/// [`AnalysisError::UnknownLaw`], [`AnalysisError::Input`] or [`AnalysisError::Law`] for a material that no law describes.
pub fn actuator(actuator: &Actuator) -> Result<ActuatorRecord, AnalysisError> {
    let inputs = actuator.values.iter().map(|(name, value)| InputRecord {
        name: name.clone(),
        value_si: value.si,
        std_si: value.std_si,
        unit: value.unit.symbol.to_owned(),
        origin: value.origin.name().to_owned(),
        place: value.place.clone(),
    });
    let materials = actuator.materials.iter().map(|(id, m)| material(actuator, id, m));
    Ok(ActuatorRecord {
        id: actuator.id.clone(),
        kind: actuator.kind.clone(),
        title: actuator.title.clone(),
        summary: actuator.summary.clone(),
        inputs: inputs.collect(),
        materials: materials.collect::<Result<_, _>>()?,
        datasets: vec![],
    })
}

fn material(actuator: &Actuator, id: &str, material: &Material) -> Result<MaterialRecord, AnalysisError> {
    let Some(entry) = find_law(&material.law) else {
        return Err(AnalysisError::UnknownLaw {
            file: actuator.file.clone(),
            line: material.line,
            law: material.law.clone(),
            next: suggestion(&material.law, LAWS.iter().map(|law| law.id)),
        });
    };
    let refused = |source| AnalysisError::Law {
        file: actuator.file.clone(),
        line: material.line,
        law: material.law.clone(),
        source,
    };
    for parameter in entry.constants() {
        let value = material.constants.get(parameter.name).and_then(|key| actuator.values.get(key));
        if let Some(value) = value.filter(|v| v.unit.dimension.si_symbol() != parameter.si_unit) {
            return Err(AnalysisError::Input {
                file: format!("{}:{}", actuator.file, value.line),
                name: parameter.name.to_owned(),
                expected: format!("{}, in a unit of {}", parameter.meaning, parameter.si_unit),
                found: format!("unit `{}`", value.unit.symbol),
            });
        }
    }
    let constant = |name: &str| material.constants.get(name).and_then(|key| actuator.values.get(key)).map(|v| v.si);
    let law = entry.build(&constant).map_err(refused)?;
    let unstable = |case: LoadCase| {
        let range = law.stable_range(case, 1.0, STRETCH_MAX).map_err(refused)?;
        let end = range.max.stretch;
        Ok((case.name().to_owned(), (end < STRETCH_MAX).then_some(end)))
    };
    Ok(MaterialRecord {
        id: id.to_owned(),
        law: material.law.clone(),
        initial_shear_modulus_pa: law.shear_modulus_pa(),
        unstable_from: LoadCase::ALL.into_iter().map(unstable).collect::<Result<BTreeMap<_, _>, AnalysisError>>()?,
        stretch_max: STRETCH_MAX,
    })
}

/// A dataset or session, and every file that went into it.
pub fn dataset(study: &Study) -> DatasetRecord {
    let input = study.input;
    let (mut record, files) = match &input.data {
        Data::Published(dataset) => (published(dataset), &dataset.files),
        Data::Session(session) => (session_dataset(study, session), &session.files),
    };
    record.sources.extend(files.iter().map(|f| SourceFile { path: f.name.clone(), sha256: f.sha256.clone() }));
    record.sources.push(SourceFile { path: input.actuator_path.clone(), sha256: input.actuator.sha256.clone() });
    let folder = input.actuator_path.rsplit_once('/').map_or(String::new(), |(folder, _)| format!("{folder}/"));
    for model in &input.actuator.imported {
        let path = format!("{folder}{}", model.file.name);
        // Several models may be columns of one table.
        if record.sources.iter().all(|source| source.path != path) {
            record.sources.push(SourceFile { path, sha256: model.file.sha256.clone() });
        }
    }
    record.sources.extend(input.bounds_source.clone());
    record
}

fn published(dataset: &PublishedDataset) -> DatasetRecord {
    let stated = dataset.stated.iter().map(|s| StatedRecord {
        title: s.title.clone(),
        value_si: s.value.si,
        unit: s.value.unit.symbol.to_owned(),
        place: s.value.place.clone(),
    });
    let listings = dataset.listings.iter().map(|l| ListingRecord {
        title: l.title.clone(),
        place: l.place.clone(),
        names: l.names.clone(),
        rows: l.rows.clone(),
    });
    DatasetRecord {
        id: dataset.id.clone(),
        title: dataset.paper.title.clone(),
        reference: dataset.paper.reference.clone(),
        session: None,
        notes: dataset.notes.clone(),
        unprinted: dataset.unprinted.clone(),
        stated: stated.collect(),
        listings: listings.collect(),
        sources: vec![],
    }
}

fn session_dataset(study: &Study, session: &Session) -> DatasetRecord {
    let manifest = &session.manifest;
    let mut sources = vec![SourceFile { path: "session.toml".to_owned(), sha256: manifest.sha256.clone() }];
    sources.extend(session.rig.iter().map(|rig| SourceFile { path: rig.relative.clone(), sha256: rig.sha256.clone() }));
    DatasetRecord {
        id: manifest.id.clone(),
        title: manifest.title.clone(),
        reference: None,
        session: Some(session_record(study, session)),
        notes: manifest.notes.clone(),
        unprinted: vec![],
        stated: vec![],
        listings: vec![],
        sources,
    }
}

fn session_record(study: &Study, session: &Session) -> SessionRecord {
    let manifest = &session.manifest;
    let responses = study.responses.iter().zip(&study.censuses).map(|(response, census)| CensusRecord {
        quantity: response.quantity.id.clone(),
        samples: census.samples,
        holes: census.holes,
        used: census.used,
        points: response.points.len(),
        tables: census.tables.iter().map(table).collect(),
        repeats: response.repeats.clone(),
        points_apart: response.points.iter().filter(|p| p.is_apart).count(),
        way: way(response),
    });
    let derived = manifest.derived.iter().map(|d| ChannelRecord {
        id: d.id.clone(),
        source: format!("derived from {}", d.from.join(", ")),
        unit: d.unit.symbol.to_owned(),
        instrument: None,
        std_si: None,
    });
    SessionRecord {
        synthetic: manifest.synthetic,
        date: manifest.date.clone(),
        operator: manifest.operator.clone(),
        rig: session.rig.as_ref().map(|rig| rig.title.clone()),
        specimen: manifest.specimen.as_ref().map(specimen).unwrap_or_default(),
        runs: session.runs.iter().map(run).collect(),
        channels: manifest.channels.iter().map(|spec| channel(session, spec)).chain(derived).collect(),
        samples_read: session.runs.iter().map(Run::samples).sum(),
        samples_excluded: study.censuses.iter().map(|census| census.holes).max().unwrap_or(0),
        lines_skipped: session.lines_skipped(),
        excluded_share_max: manifest.excluded_share_max,
        responses: responses.collect(),
        alignments: study
            .alignment
            .runs
            .iter()
            .flat_map(|run| run.clocks.iter().map(|clock| alignment(run, clock)))
            .collect(),
        lags: study.alignment.runs.iter().flat_map(|run| run.lags.iter().map(|of_run| lag(run, of_run))).collect(),
        photographs: vec![],
    }
}

fn estimate(estimate: Estimate) -> EstimateRecord {
    let Estimate { value, std, half_width } = estimate;
    EstimateRecord { value, std, lower: value - half_width, upper: value + half_width }
}

fn alignment(aligned: &AlignedRun, clock: &StreamClock) -> AlignmentRecord {
    let title = |stream: usize| aligned.run.streams[stream].title();
    let fit = clock.fit.as_ref().ok();
    let start = fit.map(|fit| fit.offset_at(clock.start_s - fit.offset.value));
    AlignmentRecord {
        run: aligned.run.id.clone(),
        table: title(clock.stream),
        reference: title(clock.reference),
        events: clock.found.1,
        events_reference: clock.found.0,
        events_used: fit.map_or(0, |fit| fit.events),
        offset_s: fit.map(|fit| estimate(fit.offset)),
        at_s: fit.map(|fit| fit.on_reference(fit.middle_s)),
        offset_at_start_s: start.map(estimate),
        start_s: clock.start_s,
        drift: fit.and_then(|fit| fit.drift).map(estimate),
        residual_s: fit.map(|fit| fit.residual_s),
        inflation: fit.map(|fit| fit.inflation),
        refused: clock.fit.as_ref().err().cloned(),
    }
}

fn lag(aligned: &AlignedRun, of_run: &RunLag) -> LagRecord {
    let found = of_run.found.as_ref().ok();
    LagRecord {
        run: aligned.run.id.clone(),
        quantity: of_run.quantity.clone(),
        pressure: of_run.pressure.clone(),
        channel: of_run.channel.clone(),
        table: aligned.run.streams[of_run.stream].title(),
        meaning: of_run.meaning.id().to_owned(),
        value_s: found.map(|lag| lag.value_s),
        std_s: found.map(|lag| lag.std_s),
        correlation: found.map(|lag| lag.correlation),
        refused: of_run.found.as_ref().err().cloned(),
    }
}

/// The loop of a response, what is left at zero pressure, and what it gains from cycle to cycle.
fn way(response: &Response) -> WayRecord {
    let errors = of_measured(response);
    let first = |i: usize| response.points[i].measured.as_ref().and_then(|m| m.first()).map_or(f64::NAN, |m| m.si);
    let width = response.quantity.width();
    let sum = |weights: &[(usize, f64)]| -> Option<IntervalRecord> {
        let value: f64 = weights.iter().map(|(i, w)| w * first(*i)).sum();
        let by = errors.factors.iter().map(|f| weights.iter().map(|(i, w)| w * f.measured[i * width]).sum::<f64>());
        let moved: Vec<f64> = by.collect();
        // As few repeats as at any of its points; one that was read once has no scatter.
        let repeats = weights.iter().map(|(i, _)| response.points[*i].repeats.len()).min().unwrap_or(0);
        let found = linear(value, &moved, &Errors { repeats, ..errors.clone() });
        let is_known = repeats > 1 && found.upper > found.lower;
        let ends = |end: f64| Some(end).filter(|_| is_known);
        value.is_finite().then(|| IntervalRecord { value, lower: ends(found.lower), upper: ends(found.upper) })
    };
    let usable = |p: &ResponsePoint| !p.is_apart;
    let (loop_area_si, no_loop) = match loop_weights(response, &usable) {
        Ok((weights, _)) => (sum(&weights), None),
        Err(why) => (None, Some(why.to_owned())),
    };
    let zero = |branch: Branch| {
        let points = response.points.iter().enumerate();
        let mut here = points.filter(|(_, p)| usable(p) && response.is_zero_reference(p) && p.branch == Some(branch));
        here.next().map(|(i, _)| i).filter(|_| here.next().is_none())
    };
    let residual_at_zero_si = match (zero(Branch::Loading), zero(Branch::Unloading)) {
        (Some(before), Some(behind)) if width == 1 => sum(&[(behind, 1.0), (before, -1.0)]),
        _ => None,
    };
    let drift = response.drift.map(|drift| drift.per_cycle_si);
    WayRecord {
        loop_area_si,
        no_loop,
        residual_at_zero_si,
        drift_per_cycle_si: drift.map(|d| IntervalRecord {
            value: d.value,
            lower: Some(d.lower),
            upper: Some(d.upper),
        }),
        drift_cycles: response.drift.map_or(0, |drift| drift.cycles),
    }
}

fn table(census: &TableCensus) -> TableRecord {
    TableRecord { table: census.table.clone(), samples: census.samples, holes: census.holes }
}

fn specimen(specimen: &Specimen) -> Vec<(String, String)> {
    let pair = |name: &str, value: String| (name.to_owned(), value);
    let mut words = vec![pair("serial", specimen.serial.clone())];
    words.extend(specimen.material_batch.clone().map(|v| pair("material batch", v)));
    words.extend(specimen.cure.clone().map(|v| pair("cure", v)));
    words.extend(specimen.cycles_before.map(|v| pair("cycles before", v.to_string())));
    words
}

fn run(run: &Run) -> RunRecord {
    let stamps = run.streams.iter().filter_map(|stream| stream.seconds.as_deref());
    // Devices count from zeros of their own: the longest span is that of one of them.
    let span = |device: Option<&str>| {
        let here = run.streams.iter().filter(|stream| stream.device.as_deref() == device);
        let finite = here.flat_map(|stream| stream.seconds.iter().flatten()).copied().filter(|t| t.is_finite());
        let (first, last) = finite.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), t| (a.min(t), b.max(t)));
        (last > first).then_some(last - first)
    };
    let span_s = run.streams.iter().filter_map(|stream| span(stream.device.as_deref())).max_by(f64::total_cmp);
    // Of several clocks the fastest: what a reader asks first is how finely the run was sampled.
    let rate_hz = stamps.filter_map(rate_hz).max_by(f64::total_cmp);
    RunRecord {
        id: run.id.clone(),
        file: run.files.join(", "),
        samples: run.samples(),
        span_s,
        rate_hz,
        clocks: 0,
        channels_left_out: 0,
        marks: vec![],
    }
}

fn channel(session: &Session, spec: &ChannelSpec) -> ChannelRecord {
    let column = match &spec.column {
        ColumnRef::Name(name) => format!("column `{name}`"),
        ColumnRef::Number(number) => format!("column {number}"),
    };
    let of = spec.device.as_ref().map_or_else(String::new, |device| format!(" of {device}"));
    let mut source = column + &of;
    if spec.commanded {
        source += ", commanded";
    }
    let device = spec.device.as_ref().and_then(|id| session.manifest.device(id));
    let clock = device.map_or(&session.manifest.clock, |device| &device.clock);
    if matches!(clock, Some(ClockSpec::Rate(_))) {
        source += ", at the stated rate";
    }
    let instrument = spec.instrument.as_ref().and_then(|id| session.rig.as_ref()?.instruments.get(id)).map(|i| {
        let calibration = i
            .calibration
            .as_ref()
            .map_or(String::new(), |c| format!(": {c}, x in {}, y in {}", i.input.symbol, i.output.symbol));
        let certificate = i.certificate.as_ref().map_or(String::new(), |text| format!(" ({text})"));
        format!("{}{calibration}{certificate}", i.title)
    });
    let read = session.runs.iter().find_map(|run| run.channels.get(&spec.id));
    ChannelRecord {
        id: spec.id.clone(),
        source,
        unit: read.map_or("1", |channel| channel.unit.symbol).to_owned(),
        instrument,
        std_si: read.and_then(|channel| channel.std_si),
    }
}

/// Constants that no law asks for, one letter away from one that it would take: a slip counts as zero otherwise.
pub fn slips(actuator: &Actuator) -> Vec<String> {
    let mut texts = Vec::new();
    for (id, material) in &actuator.materials {
        let Some(law) = find_law(&material.law) else { continue };
        let known: Vec<&str> = law.constants().map(|c| c.name).collect();
        let missing = || known.iter().copied().filter(|name| !material.constants.contains_key(*name));
        for name in material.constants.keys().filter(|name| !known.contains(&name.as_str())) {
            let near = suggestion(name, missing());
            if near.starts_with("did you mean") && name.len() > 2 {
                texts.push(format!(
                    "constant `{name}` of material {id} of {} is no constant of {}: {near}",
                    actuator.id, material.law
                ));
            }
        }
    }
    texts
}

/// Imported models that carry the name of a catalogue form, which they hide.
pub fn hidden_forms(actuator: &Actuator) -> Vec<String> {
    let hides = |m: &&ImportedModel| find(&actuator.kind, &m.quantity.id, &m.form).is_some();
    let text = |m: &ImportedModel| {
        format!("the imported model {} of {} hides the catalogue's form of that name: rename it", m.form, m.quantity.id)
    };
    actuator.imported.iter().filter(hides).map(text).collect()
}

/// The findings of a session.
pub fn findings(study: &Study) -> Vec<FindingRecord> {
    let Data::Session(session) = &study.input.data else { return vec![] };
    let record = |finding: &finding::Finding| FindingRecord {
        severity: match finding.severity {
            finding::Severity::Note => Severity::Note,
            finding::Severity::Excluded => Severity::Excluded,
            finding::Severity::Lost => Severity::Lost,
        },
        kind: finding.kind.id().to_owned(),
        dataset: Some(study.id.to_owned()),
        file: Some(finding.file.clone()),
        channel: finding.channel.clone(),
        count: Some(finding.count),
        spans: finding
            .spans
            .iter()
            .map(|s| SpanRecord {
                first_sample: s.first_sample,
                last_sample: s.last_sample,
                first_line: s.first_line,
                last_line: s.last_line,
            })
            .collect(),
        text: finding.text.clone(),
    };
    let unmet = study.responses.iter().zip(&study.censuses).flat_map(|(response, census)| {
        census.unmet.iter().map(|unmet| unmet_plateaus(study.id, session, &response.quantity.id, unmet))
    });
    let unsure = study.responses.iter().zip(&study.censuses).flat_map(|(response, census)| {
        census.unsure.iter().map(|unsure| unsure_plateaus(study.id, session, &response.quantity.id, unsure))
    });
    let of_clocks = study.alignment.findings.iter().map(record);
    let of_readings = study.responses.iter().zip(&study.censuses);
    let of_readings = of_readings.flat_map(|(response, census)| of_readings_of(study.id, session, response, census));
    let of_session = session.findings.iter().map(record).chain(of_clocks);
    of_session.chain(unsure).chain(unmet).chain(of_readings).collect()
}

/// Runs without a zero, and readings at which something still moves.
fn of_readings_of(study: &str, session: &Session, response: &Response, census: &Census) -> Vec<FindingRecord> {
    let quantity = &response.quantity;
    let finding = |run: &str, kind: finding::FindingKind, severity, count, text| FindingRecord {
        severity,
        kind: kind.id().to_owned(),
        dataset: Some(study.to_owned()),
        file: session.manifest.runs.iter().find(|spec| spec.id == run).map(|spec| spec.file.clone()),
        channel: None,
        count: Some(count),
        spans: vec![],
        text,
    };
    let untared = census.untared.iter().map(|run| {
        let text = format!(
            "{}, run {run}: no reading at zero pressure before the first rise, from which its zero should come; the run is not used",
            quantity.id
        );
        finding(run, finding::FindingKind::Untared, Severity::Lost, 1, text)
    });
    let creeping = census.creeping.iter().map(|creep| {
        let text = format!(
            "{}, run {}: still moves while it is averaged, at {} of {} points, by {} at most: hold longer, or average a shorter window",
            quantity.id,
            creep.run,
            creep.creeping,
            creep.readings,
            crate::format::with_unit(
                &crate::format::significant(quantity.unit.from_si(creep.largest_si), 2),
                quantity.unit
            )
        );
        finding(&creep.run, finding::FindingKind::Creeping, Severity::Note, creep.creeping, text)
    });
    untared.chain(creeping).collect()
}

/// Plateaus that are too short for a lag of which nobody knows whose it is. A run that has no other is lost.
fn unsure_plateaus(study: &str, session: &Session, quantity: &str, unsure: &Unsure) -> FindingRecord {
    let spec = session.manifest.runs.iter().find(|run| run.id == unsure.run);
    let file = spec.and_then(|run| unsure.device.as_ref().map_or(Some(&run.file), |device| run.files.get(device)));
    FindingRecord {
        severity: if unsure.unsure == unsure.plateaus { Severity::Lost } else { Severity::Excluded },
        kind: finding::FindingKind::TotalLag.id().to_owned(),
        dataset: Some(study.to_owned()),
        file: file.cloned(),
        channel: None,
        count: Some(unsure.unsure),
        spans: vec![],
        text: format!("{quantity}, {}", unsure.text()),
    }
}

/// What is worth knowing of how movements met a prediction.
pub fn meetings(comparison: &Comparison) -> Vec<FindingRecord> {
    let record = |run: &RunMeetingRecord, text: String| FindingRecord {
        severity: Severity::Note,
        kind: "meeting".to_owned(),
        dataset: Some(comparison.dataset.clone()),
        file: None,
        channel: None,
        count: None,
        spans: vec![],
        text: format!("{} of {}, run {}: {text}", comparison.form, comparison.quantity.id, run.run),
    };
    let runs = comparison.meeting.iter().flat_map(|meeting| &meeting.runs);
    runs.flat_map(|run| run.told().into_iter().map(|text| record(run, text))).collect()
}

/// Plateaus at which nothing was measured. A run that has no other is lost: do its files count from one clock at all?
fn unmet_plateaus(study: &str, session: &Session, quantity: &str, unmet: &Unmet) -> FindingRecord {
    let spec = session.manifest.runs.iter().find(|run| run.id == unmet.run);
    let file = spec.and_then(|run| unmet.device.as_ref().map_or(Some(&run.file), |device| run.files.get(device)));
    FindingRecord {
        severity: if unmet.unmet == unmet.plateaus { Severity::Lost } else { Severity::Excluded },
        kind: finding::FindingKind::UnmetPlateaus.id().to_owned(),
        dataset: Some(study.to_owned()),
        file: file.cloned(),
        channel: None,
        count: Some(unmet.unmet),
        spans: vec![],
        text: format!("{quantity}, {}", unmet.text()),
    }
}
