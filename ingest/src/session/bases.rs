//! The streams of a run on one time base, where the session says that one clock stamped them all.
//!
//! The base of a run is that of its first stream with a stamp: of its `file`, where that can be used. Stamps that count from another
//! instant are shifted by the whole seconds between the two; stamps that count from a zero of their own are left as they are, for that
//! zero is declared to be one. Between the two kinds nothing is known.

use std::collections::BTreeMap;

use super::{Run, Stream};
use crate::error::{IngestError, Place};
use crate::finding::{Finding, FindingKind, Severity};
use crate::formats::stamps::Epoch;
use crate::manifest::{Clocks, SessionManifest};

/// The time bases of the runs of a session, as far as their files have been read.
pub(crate) struct Bases<'a> {
    manifest: &'a SessionManifest,
    /// By the place of the run in the manifest.
    of_runs: BTreeMap<usize, Base>,
}

struct Base {
    epoch: Option<Epoch>,
    /// Whose it is.
    stream: String,
}

impl<'a> Bases<'a> {
    pub fn new(manifest: &'a SessionManifest) -> Self {
        Self { manifest, of_runs: BTreeMap::new() }
    }

    /// Sets what was read of a run on the run's base, which it makes where there is none yet.
    ///
    /// # Errors
    /// [`IngestError::Malformed`] at the run where nobody knows how its stamps lie to those read before.
    pub fn align(&mut self, number: usize, run: &mut Run, findings: &mut Vec<Finding>) -> Result<(), IngestError> {
        if self.manifest.clocks != Clocks::One {
            return Ok(());
        }
        let Run { id, streams, files, .. } = run;
        for stream in streams {
            if !stream.seconds.iter().flatten().any(|stamp| stamp.is_finite()) {
                continue;
            }
            let Some(base) = self.of_runs.get(&number) else {
                self.of_runs.insert(number, Base { epoch: stream.epoch, stream: stream.title() });
                continue;
            };
            let shift_s = match (stream.epoch, base.epoch) {
                (None, None) => continue,
                (Some(epoch), Some(base)) => epoch.since(base),
                _ => None,
            };
            let Some(shift_s) = shift_s else { return Err(self.apart(number, base, stream)) };
            if shift_s == 0 {
                continue;
            }
            let text = format!(
                "run {id}: {shift_s} s are added to the stamps of {}, which count from {}, so that they count from {} as those of {} do",
                stream.title(),
                counted_from(stream.epoch),
                counted_from(base.epoch),
                base.stream
            );
            // Whole seconds: two roundings of a stamp at most.
            stream.shift_s = shift_s as f64;
            stream.seconds.iter_mut().flatten().for_each(|stamp| *stamp += stream.shift_s);
            stream.epoch = base.epoch;
            findings.push(Finding {
                kind: FindingKind::ClockShift,
                severity: Severity::Note,
                file: files.first().cloned().unwrap_or_default(),
                channel: None,
                spans: vec![],
                count: stream.samples,
                text,
            });
        }
        Ok(())
    }

    /// Whether what is stored of a run stands on the run's base: from where its stamps count, and how far they were shifted to do so.
    pub fn agrees(&self, number: usize, counts_from: Option<&str>, shift_s: f64) -> bool {
        let shown = |epoch: Option<Epoch>| epoch.map(|epoch| epoch.to_string());
        self.of_runs.get(&number).map_or(shift_s == 0.0, |base| shown(base.epoch).as_deref() == counts_from)
            || self.manifest.clocks != Clocks::One
    }

    /// Takes what is stored of a run for its base, if it has none yet.
    pub fn know(&mut self, number: usize, counts_from: Option<&str>, stream: String) {
        let epoch = counts_from.and_then(Epoch::parse);
        self.of_runs.entry(number).or_insert(Base { epoch, stream });
    }

    fn apart(&self, number: usize, base: &Base, stream: &Stream) -> IngestError {
        let run = self.manifest.runs.get(number);
        let from = |name: &str, epoch| format!("stamps of {name} from {}", counted_from(epoch));
        IngestError::Malformed {
            place: Place::new(&self.manifest.file, run.map(|run| run.line), run.map(|run| format!("run `{}`", run.id))),
            expected: "stamps that count from one zero, as clocks = \"one\" says".to_owned(),
            found: format!("{}, {}", from(&base.stream, base.epoch), from(&stream.title(), stream.epoch)),
            next:
                "name clock columns that both hold dates of one zone, or both count from one zero; or remove `clocks`: \
                   where the zeros lie to each other stands in neither file"
                    .to_owned(),
        }
    }
}

fn counted_from(epoch: Option<Epoch>) -> String {
    match epoch {
        None => "a zero of their own".to_owned(),
        Some(epoch) if epoch.is_utc => epoch.to_string(),
        Some(epoch) => format!("{epoch} in a zone that is not stated"),
    }
}
