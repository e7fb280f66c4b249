//! What moved since results that were accepted on purpose: metric by metric, by how much, and whether intervals explain it.
//!
//! ```text
//! Results --accept--> Baseline (a file under version control)
//! Baseline + Results --> Move: same | explained | better | worse | new | gone
//! ```
//!
//! A metric went from a to b. Where the measured data are others than before, their intervals are those of two independent samples, and
//! explain a move of up to √(h₁² + h₂²), h the half widths on the sides that face each other (95 % of a session, the reach of printed
//! digits). Where the data are the same, byte for byte, nothing random lies between the two: model, actuator or program moved it, and no
//! interval explains that. Where data are others and an interval is not known, nobody can say. Worse is larger in size; of R², smaller.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use pneuval_ingest::{IngestError, limits};
use serde::{Deserialize, Serialize};

use crate::AnalysisError;
use crate::format;
use crate::gate::metric_text;
use crate::metrics::Metric;
use crate::results::{Comparison, DatasetRecord, Results, Standing};
use crate::verdict::Verdict;

/// Version of the layout of a baseline.
const SCHEMA_VERSION: u32 = 1;

/// Numbers that differ by less than this share are the same: sums may be taken in another order on another machine.
const SAME_SHARE: f64 = 1e-9;

/// Accepted results.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Baseline {
    /// Version of this layout.
    pub baseline_version: u32,
    /// Version of the metric definitions.
    pub metric_definitions: u32,
    /// Why it was accepted, the latest last.
    pub accepted: Vec<Acceptance>,
    /// What every comparison said.
    pub comparisons: Vec<Kept>,
}

/// Why results were accepted.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Acceptance {
    /// In the words of who did it.
    pub because: String,
    /// Name and version of the program whose results they were.
    pub program: String,
}

/// A comparison as it was accepted.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Kept {
    /// `dataset/quantity/form`.
    pub id: String,
    /// Its verdict.
    pub verdict: Verdict,
    /// Points in its metrics.
    pub n_used: usize,
    /// SHA-256 of the files that it was measured in, by path.
    pub data: BTreeMap<String, String>,
    /// Metrics that have a value.
    pub metrics: Vec<KeptMetric>,
}

/// A metric as it was accepted, in SI units.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct KeptMetric {
    /// Which.
    pub metric: Metric,
    /// Value.
    pub value: f64,
    /// Ends of its interval.
    pub interval: Option<(f64, f64)>,
}

/// What became of a metric, or of a comparison.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Moved {
    /// It is no longer compared.
    Gone,
    /// Worse by more than intervals explain.
    Worse,
    /// Its verdict is another.
    Verdict,
    /// It was not compared before.
    New,
    /// Better by more than intervals explain.
    Better,
    /// Other data, and nothing is known of the intervals: nobody can say what moved it.
    Unknown,
    /// Within what intervals explain.
    Explained,
}

impl Moved {
    /// In a word.
    pub fn name(self) -> &'static str {
        match self {
            Self::Gone => "gone",
            Self::Worse => "worse",
            Self::Verdict => "verdict",
            Self::New => "new",
            Self::Better => "better",
            Self::Unknown => "unknown",
            Self::Explained => "explained",
        }
    }
}

/// Something that moved.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Move {
    /// The comparison.
    pub id: String,
    /// The metric; of a whole comparison, none.
    pub metric: Option<Metric>,
    /// What became of it.
    pub moved: Moved,
    /// Its values, SI units.
    pub before: Option<f64>,
    /// Now.
    pub after: Option<f64>,
    /// By how much intervals let it move, SI units; null where the data are the same, or nothing is known.
    pub open: Option<f64>,
    /// Whether the gate fails by it.
    pub counts: bool,
    /// In a sentence.
    pub sentence: String,
}

impl Baseline {
    /// What results say, accepted for a reason.
    pub fn of(results: &Results, because: &str) -> Self {
        let kept = |c: &Comparison| Kept {
            id: c.id.clone(),
            verdict: c.verdict,
            n_used: c.n_used,
            data: data(results, c),
            metrics: c
                .metrics
                .iter()
                .filter_map(|m| Some(KeptMetric { metric: m.metric, value: m.value?, interval: m.lower.zip(m.upper) }))
                .collect(),
        };
        Self {
            baseline_version: SCHEMA_VERSION,
            metric_definitions: results.metric_definitions,
            accepted: vec![Acceptance { because: because.to_owned(), program: results.program.clone() }],
            comparisons: results.comparisons.iter().map(kept).collect(),
        }
    }

    /// Reads a baseline, or the results of a report in its place.
    ///
    /// # Errors
    /// [`AnalysisError::Results`] if it is neither; [`IngestError`] if it cannot be read.
    pub fn read(path: &Path) -> Result<Self, AnalysisError> {
        if path.is_dir() || path.file_name().is_some_and(|name| name == "results.json") {
            let (_, evaluation) = crate::folder::load(path)?;
            return Ok(Self::of(&evaluation.results, "a report, not accepted by name"));
        }
        let problem = |problem: String| AnalysisError::Results {
            path: path.to_owned(),
            problem,
            next: "name a file that `pneuval accept` wrote, or a report".to_owned(),
        };
        let bytes = limits::read(path, limits::RESULTS_BYTES_MAX)?;
        let found: Self =
            serde_json::from_slice(&bytes).map_err(|error| problem(format!("not a baseline: {error}")))?;
        if found.baseline_version != SCHEMA_VERSION {
            let version = found.baseline_version;
            return Err(problem(format!("baseline_version {SCHEMA_VERSION} expected, found {version}")));
        }
        Ok(found)
    }

    /// Writes it, whole or not at all; of an earlier one its reasons stay.
    ///
    /// # Errors
    /// As [`Self::read`] for what is there already; [`IngestError`] if it cannot be written.
    pub fn write(mut self, path: &Path) -> Result<(), AnalysisError> {
        if path.exists() {
            let mut earlier = Self::read(path)?.accepted;
            earlier.append(&mut self.accepted);
            self.accepted = earlier;
        }
        let failed = |source| AnalysisError::from(IngestError::write(path, source));
        let text = serde_json::to_string_pretty(&self).map_err(|error| failed(error.into()))? + "\n";
        let folder = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
        let new = tempfile::NamedTempFile::new_in(folder).map_err(failed)?;
        fs::write(new.path(), text).map_err(failed)?;
        new.persist(path).map_err(|error| failed(error.error))?;
        Ok(())
    }

    /// What moved, what matters most first; what stayed is not told.
    ///
    /// # Errors
    /// [`AnalysisError::Results`] if the metrics are defined otherwise.
    pub fn moves(&self, results: &Results) -> Result<Vec<Move>, AnalysisError> {
        if self.metric_definitions != results.metric_definitions {
            return Err(AnalysisError::Results {
                path: "baseline".into(),
                problem: format!(
                    "its metrics are of definitions {}, those of the results of {}: they cannot be compared",
                    self.metric_definitions, results.metric_definitions
                ),
                next: "accept the results of this version".to_owned(),
            });
        }
        let mut moves = vec![];
        for kept in &self.comparisons {
            match results.comparisons.iter().find(|c| c.id == kept.id) {
                Some(c) => moves.extend(of_comparison(results, kept, c)),
                None => moves.push(whole(&kept.id, Moved::Gone, true, "it is no longer compared".to_owned())),
            }
        }
        for c in results.comparisons.iter().filter(|c| self.comparisons.iter().all(|kept| kept.id != c.id)) {
            let told = format!("it was not compared before; it is {}", c.verdict.name());
            moves.push(whole(&c.id, Moved::New, false, told));
        }
        moves.sort_by_key(|m| (!m.counts, m.moved));
        Ok(moves)
    }
}

fn whole(id: &str, moved: Moved, counts: bool, sentence: String) -> Move {
    Move { id: id.to_owned(), metric: None, moved, before: None, after: None, open: None, counts, sentence }
}

/// Files that a comparison is measured in: the logs and manifests of a session, the tables of a paper; not what describes the actuator,
/// its models and its bounds.
fn data(results: &Results, c: &Comparison) -> BTreeMap<String, String> {
    let datasets = results.actuators.iter().filter(|a| a.id == c.actuator).flat_map(|a| &a.datasets);
    let of_dataset = |d: &DatasetRecord| {
        let logs: Option<Vec<String>> = d
            .session
            .as_ref()
            .map(|session| session.runs.iter().flat_map(|run| run.file.split(", ").map(str::to_owned)).collect());
        let is_data = |path: &str| {
            let name = path.rsplit('/').next().unwrap_or(path);
            let is_manifest = Path::new(name).extension().is_some_and(|e| e == "toml");
            let is_log = logs.as_ref().is_none_or(|logs| logs.iter().any(|log| log == path));
            name != "actuator.toml" && name != "bounds.toml" && (is_manifest || is_log)
        };
        let files = d.sources.iter().filter(|f| is_data(&f.path));
        files.map(|f| (f.path.clone(), f.sha256.clone())).collect::<Vec<_>>()
    };
    datasets.filter(|d| d.id == c.dataset).flat_map(of_dataset).collect()
}

fn of_comparison(results: &Results, kept: &Kept, c: &Comparison) -> Vec<Move> {
    let mut moves = vec![];
    if kept.verdict != c.verdict {
        // Whether that is bad, the gate says by its bounds.
        let told = format!("{} before, {} now: {}", kept.verdict.name(), c.verdict.name(), c.sentence);
        moves.push(whole(&c.id, Moved::Verdict, c.standing() == Standing::Unexpected, told));
    }
    let is_same_data = kept.data == data(results, c);
    for before in &kept.metrics {
        let Some(now) = c.metric(before.metric) else { continue };
        let judged = c.judgements.iter().any(|j| j.bound.metric == before.metric)
            || matches!(before.metric, Metric::Rmse | Metric::MaxAbsError);
        let unit = c.quantity.unit();
        let text = |value| metric_text(before.metric, value, unit);
        let name = before.metric.title();
        let Some(after) = now.value else {
            let why = now.undefined.as_deref().unwrap_or("no value");
            let told = format!("{name} was {}, and cannot be formed now: {why}", text(before.value));
            moves.push(Move {
                metric: Some(before.metric),
                before: Some(before.value),
                ..whole(&c.id, Moved::Gone, judged, told)
            });
            continue;
        };
        let change = after - before.value;
        if change.abs() <= SAME_SHARE * after.abs().max(before.value.abs()) {
            continue;
        }
        let open = open(before, (after, now.lower.zip(now.upper)), change).filter(|_| !is_same_data);
        let growth = match before.metric {
            Metric::R2 => before.value - after,
            _ => after.abs() - before.value.abs(),
        };
        let moved = match open {
            Some(open) if change.abs() <= open => Moved::Explained,
            None if !is_same_data => Moved::Unknown,
            _ if growth > 0.0 => Moved::Worse,
            _ => Moved::Better,
        };
        let why = match open {
            Some(open) => format!("intervals explain up to {}", text(open)),
            None if is_same_data => "the data are the same: model, actuator or program moved it".to_owned(),
            None => "nothing is known of its interval".to_owned(),
        };
        let sign = if change > 0.0 { "+" } else { "" };
        moves.push(Move {
            id: c.id.clone(),
            metric: Some(before.metric),
            moved,
            before: Some(before.value),
            after: Some(after),
            open,
            counts: judged && moved == Moved::Worse,
            sentence: format!(
                "{name} {} before, {} now ({sign}{}): {why}",
                text(before.value),
                text(after),
                text(change)
            ),
        });
    }
    moves
}

/// By how much two independent intervals let a value move.
fn open(before: &KeptMetric, (after, interval): (f64, Option<(f64, f64)>), change: f64) -> Option<f64> {
    let ((l0, u0), (l1, u1)) = (before.interval?, interval?);
    let halves = if change > 0.0 { (u0 - before.value, after - l1) } else { (before.value - l0, u1 - after) };
    Some(halves.0.hypot(halves.1)).filter(|open| open.is_finite())
}

/// What moved, in lines: the most important first, what intervals explain counted.
pub fn text(moves: &[Move]) -> String {
    if moves.is_empty() {
        return "Nothing moved since the baseline.\n".to_owned();
    }
    let count = |moved: Moved| moves.iter().filter(|m| m.moved == moved).count();
    let kinds =
        [Moved::Gone, Moved::Worse, Moved::Verdict, Moved::New, Moved::Better, Moved::Unknown, Moved::Explained];
    let parts: Vec<String> =
        kinds.iter().filter(|k| count(**k) > 0).map(|k| format!("{} {}", count(*k), k.name())).collect();
    let mut out = format!("Since the baseline: {}\n", parts.join(" · "));
    for m in moves {
        out += &format::visible(&format!("  {} {}: {}\n", m.moved.name(), m.id, m.sentence));
    }
    out
}
