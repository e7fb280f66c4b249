//! Photographs of sessions on their way into the results folder: some of those that were measured, with what was measured in them.

use std::collections::BTreeMap;

use pneuval_ingest::camera::photograph::{Photograph, is_shown};
use pneuval_ingest::session::Run;

use crate::AnalysisError;
use crate::report;
use crate::results::{DatasetRecord, PhotographRecord, Results};
use crate::study::{Data, Study};

/// Their folder inside the results.
pub const PHOTOGRAPHS: &str = "photographs";

/// A photograph that is shown.
#[derive(Debug, Clone, PartialEq)]
pub enum Shown {
    /// With what was measured in it, to be drawn.
    Measured(Box<Photograph>),
    /// Drawn already: the bytes of a JPEG file.
    Drawn(Vec<u8>),
}

/// Photographs of a session: some of all its logs, spread evenly.
pub(crate) fn show(study: &Study, dataset: &mut DatasetRecord, all: &mut BTreeMap<String, Shown>) {
    let Data::Session(session) = &study.input.data else { return };
    let Some(record) = &mut dataset.session else { return };
    let of_runs = session.runs.iter().flat_map(|run| run.photographs.iter().map(move |shown| (run, shown)));
    let candidates: Vec<(&Run, &Photograph)> = of_runs.collect();
    let chosen = candidates.iter().enumerate().filter(|(i, _)| is_shown(*i, candidates.len()));
    for (_, (run, shown)) in chosen {
        // Numbered through all sessions: their names may be alike.
        let path = format!("{PHOTOGRAPHS}/{}-{}.jpg", dataset.id, all.len() + 1);
        record.photographs.push(PhotographRecord {
            path: path.clone(),
            run: run.id.clone(),
            name: shown.name.clone(),
            label: shown.marks.label.clone(),
            refused: shown.refused.clone(),
            width: shown.picture.width(),
            height: shown.picture.height(),
        });
        all.insert(path, Shown::Measured(Box::new((*shown).clone())));
    }
}

/// Their files.
pub(crate) fn drawn(all: BTreeMap<String, Shown>) -> Result<BTreeMap<String, Vec<u8>>, AnalysisError> {
    let draw = |(name, shown): (String, Shown)| match shown {
        Shown::Drawn(jpeg) => Ok((name, jpeg)),
        Shown::Measured(photograph) => match report::thumbnail(&photograph) {
            Ok(jpeg) => Ok((name, jpeg)),
            Err(message) => Err(AnalysisError::Figure { figure: name, message }),
        },
    };
    all.into_iter().map(draw).collect()
}

/// Those that results name.
pub(crate) fn records(results: &Results) -> impl Iterator<Item = &PhotographRecord> {
    let sessions = results.actuators.iter().flat_map(|a| &a.datasets).filter_map(|d| d.session.as_ref());
    sessions.flat_map(|session| &session.photographs)
}

/// Where no photograph is drawn, none is named.
pub(crate) fn forget(results: &mut Results) {
    let sessions = results.actuators.iter_mut().flat_map(|a| &mut a.datasets).filter_map(|d| d.session.as_mut());
    sessions.for_each(|session| session.photographs.clear());
}
