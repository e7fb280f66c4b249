//! What stands beside a decision: the bound that is nearest, and on what it rests.

use std::collections::BTreeSet;

use crate::format;
use crate::gate::{limit_text, metric_text};
use crate::report::group::{by_measurement, measurement_title};
use crate::results::{ActuatorRecord, Comparison, PointStatus, Results, Standing};
use crate::verdict::Verdict;

/// Name and value of each fact of an actuator: worst bound, sessions, specimens, points.
pub fn facts(results: &Results, record: &ActuatorRecord) -> Vec<(&'static str, String)> {
    let mine: Vec<&Comparison> = results.comparisons.iter().filter(|c| c.actuator == record.id).collect();
    let mut facts = Vec::new();
    facts.extend(worst(&mine).map(|text| ("worst bound", text)));
    let sessions: Vec<_> = record.datasets.iter().filter_map(|d| d.session.as_ref()).collect();
    let published = record.datasets.len() - sessions.len();
    let sittings = match (sessions.len(), published) {
        (0, 1) => "none; the numbers of 1 paper".to_owned(),
        (0, n) => format!("none; the numbers of {n} papers"),
        (n, 0) => n.to_string(),
        (n, 1) => format!("{n}, and the numbers of 1 paper"),
        (n, m) => format!("{n}, and the numbers of {m} papers"),
    };
    facts.push(("sessions", sittings));
    if !sessions.is_empty() {
        // A specimen is the same after more cycles; a serial number of another batch is another specimen.
        let identity = |specimen: &[(String, String)]| -> Vec<(String, String)> {
            specimen.iter().filter(|(name, _)| ["serial", "material batch"].contains(&name.as_str())).cloned().collect()
        };
        let named: BTreeSet<_> =
            sessions.iter().filter(|s| !s.specimen.is_empty()).map(|s| identity(&s.specimen)).collect();
        let unnamed = sessions.iter().filter(|s| s.specimen.is_empty()).count();
        let text = match (named.len(), unnamed) {
            (n, 0) => n.to_string(),
            (0, _) => "not named".to_owned(),
            (n, 1) => format!("{n}; 1 session names none"),
            (n, m) => format!("{n}; {m} sessions name none"),
        };
        facts.push(("specimens", text));
    }
    facts.push(("points", points(&mine)));
    facts
}

/// Measured points, and how many of them some prediction is compared with.
fn points(mine: &[&Comparison]) -> String {
    let (mut measured, mut compared) = (0, 0);
    for group in by_measurement(mine.iter().copied()) {
        let most = group.iter().max_by_key(|c| c.points.iter().filter(|p| p.measured.is_some()).count());
        measured += most.map_or(0, |c| c.points.iter().filter(|p| p.measured.is_some()).count());
        let n = group.iter().map(|c| c.points.len()).max().unwrap_or(0);
        let used = |i: &usize| group.iter().any(|c| c.points.get(*i).is_some_and(|p| p.status == PointStatus::Used));
        compared += (0..n).filter(used).count();
    }
    format!("{compared} compared of {measured} measured")
}

/// Of what counts most (what differs, else what is open, else what passes, else what fails as expected) the judgement that uses most of its bound.
fn worst(mine: &[&Comparison]) -> Option<String> {
    let passes = |c: &&&Comparison| c.standing() == Standing::AsExpected && c.verdict == Verdict::Pass;
    let all: [Vec<&&Comparison>; 4] = [
        mine.iter().filter(|c| c.standing() == Standing::Unexpected).collect(),
        mine.iter().filter(|c| c.standing() == Standing::Open).collect(),
        mine.iter().filter(passes).collect(),
        mine.iter().filter(|c| c.standing() == Standing::AsExpected).collect(),
    ];
    let candidates = all.into_iter().find(|some| some.iter().any(|c| !c.judgements.is_empty()))?;
    let judged = candidates.iter().flat_map(|c| c.judgements.iter().map(|j| (**c, j)));
    let (c, j, share) = judged.map(|(c, j)| (c, j, c.share_of(j))).max_by(|a, b| a.2.total_cmp(&b.2))?;
    let unit = c.quantity.unit();
    let name = shortened(&format!("{}, {}", measurement_title(c), c.title));
    let limit = limit_text(j.bound.metric, j.bound.max, unit);
    let Some(value) = c.metric(j.bound.metric).and_then(|m| m.value) else {
        return Some(format!("{name}: {} has no value, {limit} allowed", j.bound.metric.title()));
    };
    let value = metric_text(j.bound.metric, value, unit);
    Some(format!("{name}: {} {value} of {limit}, {} %", j.bound.metric.title(), format::significant(100.0 * share, 2)))
}

/// Long names are whole in the table of comparisons.
fn shortened(name: &str) -> String {
    const LETTERS: usize = 120;
    if name.chars().count() <= LETTERS {
        name.to_owned()
    } else {
        name.chars().take(LETTERS - 1).chain(['…']).collect()
    }
}
