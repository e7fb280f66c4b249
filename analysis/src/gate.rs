//! From stored metrics and bounds to verdicts and the sentences that tell them: the same for `validate` and `gate`.

use std::collections::BTreeSet;

use pneuval_ingest::units::Unit;

use crate::AnalysisError;
use crate::bounds::{Bound, Bounds, Expect};
use crate::decide::what_would_decide;
use crate::format;
use crate::metrics::{Interval, Measure, Metric};
use crate::results::{Comparison, FindingRecord, JudgementRecord, MetricRecord, Point, PointStatus, Results, Severity};
use crate::verdict::{Basis, Grounds, Verdict, Why, judge};

/// Two runs went to one pressure, if they are as near as this share of it.
const SAME_PRESSURE_SHARE: f64 = 0.01;

/// Measured points at which the model fails a bound for want of a value. A value that is not a number leaves everything open,
/// whatever else is missing; the zero-pressure metric asks the zero-pressure references alone.
fn points_without_prediction(comparison: &Comparison, metric: Metric) -> usize {
    if metric == Metric::ResidualAtZero || comparison.points.iter().any(|p| p.status == PointStatus::NotFinite) {
        0
    } else {
        comparison.n_without_prediction
    }
}

/// Judges a comparison by bounds, from its stored metrics alone.
pub fn judge_comparison(comparison: &mut Comparison, bounds: Vec<Bound>, not_judged: Option<&str>) {
    judge_by(comparison, bounds, not_judged);
    comparison.sentence += &comparison.circumstances();
}

fn judge_by(comparison: &mut Comparison, bounds: Vec<Bound>, not_judged: Option<&str>) {
    comparison.judgements.clear();
    comparison.counted = true;
    if let Some(reason) = not_judged {
        comparison.verdict = Verdict::Unjudged;
        comparison.counted = false;
        comparison.sentence = format!("not judged: {reason}");
        return;
    }
    let own_data = format!("{}/{} measured", comparison.dataset, comparison.quantity.id);
    if comparison.fit.as_ref().is_some_and(|fit| fit.hold_out.is_none() && fit.fitted_on.contains(&own_data)) {
        comparison.verdict = Verdict::Calibration;
        comparison.counted = false;
        comparison.sentence = String::from("fitted to these very data: calibration, not validation");
        return;
    }
    if let [first, more @ ..] = comparison.calibrated_on.as_slice() {
        let others = if more.is_empty() { String::new() } else { format!(" and {} more of its runs", more.len()) };
        comparison.verdict = Verdict::Calibration;
        comparison.counted = false;
        comparison.sentence = format!(
            "the actuator file's values were fitted on {first}{others}: calibration, not validation; runs that the fit did not see, in a session of their own, would validate it"
        );
        return;
    }
    for bound in bounds {
        let measure = comparison.metric(bound.metric).map_or(Measure::Undefined("not stored"), MetricRecord::measure);
        let grounds = Grounds {
            points_without_prediction: points_without_prediction(comparison, bound.metric),
            single_repeat: comparison.metric(bound.metric).is_some_and(|record| record.single_repeat),
        };
        let judgement = judge(measure, &bound, grounds);
        let sentence = sentence(comparison, &bound, judgement.why);
        comparison.judgements.push(JudgementRecord { bound, verdict: judgement.verdict, sentence });
    }
    comparison.verdict = comparison.deciding().map_or(Verdict::Unjudged, |judgement| judgement.verdict);
    if let Some(too_little) = too_little(comparison).filter(|_| comparison.judgements.is_empty()) {
        comparison.sentence = too_little;
        return;
    }
    let unjudged = if let Some(why) = why_nothing(comparison) {
        why
    } else if comparison.points.is_empty() && !comparison.metrics_printed {
        "there is no point: no stretch of the pressure is steady for the declared hold, or nothing was logged"
    } else if comparison.points.iter().any(|p| p.status == PointStatus::NotCompared) {
        "nothing predicts this quantity: add a [[model]] to the actuator file, or name a type that has one"
    } else {
        "no bound for this comparison: write a row in bounds.toml to have it judged"
    };
    comparison.sentence =
        comparison.deciding().map_or_else(|| unjudged.to_owned(), |judgement| judgement.sentence.clone());
}

/// Why nothing can be said of a movement that hardly meets its prediction.
fn too_little(comparison: &Comparison) -> Option<String> {
    let meeting = comparison.meeting.as_ref().filter(|meeting| meeting.is_too_little())?;
    Some(format!(
        "only {} of the shorter series overlaps the other, less than the {} asked for ({}), so no metric stands for the whole; series \
         that overlap, or overlap_min in `points`, could decide it",
        format::percent(meeting.overlap),
        format::percent(meeting.overlap_min),
        meeting.reach()
    ))
}

/// Why no asked point has a value at all, where one reason holds for all of them: a fit that failed.
fn why_nothing(comparison: &Comparison) -> Option<&str> {
    let mut asked = comparison.points.iter().filter(|p| {
        !matches!(p.status, PointStatus::ZeroReference | PointStatus::HoleInPrint | PointStatus::CycleApart)
    });
    let first = asked.next().filter(|p| p.status == PointStatus::NotFinite && p.predicted.is_none())?;
    let same = |p: &Point| p.status == first.status && p.reason == first.reason;
    first.reason.as_deref().filter(|_| asked.all(same))
}

/// A metric's value in the unit it is shown in.
pub fn metric_text(metric: Metric, value: f64, unit: Unit) -> String {
    match metric {
        Metric::R2 => format::fixed(value, 4),
        Metric::LoopArea => area_text(value, unit),
        metric if metric.is_ratio() => format::percent(value),
        _ => format::quantity(value, unit, format::error_decimals(unit)),
    }
}

/// The area of a loop, in the quantity's unit × kPa.
pub fn area_text(value_si: f64, unit: Unit) -> String {
    let kpa = pneuval_ingest::units::Dimension::Pressure.display_unit();
    let value = kpa.from_si(unit.from_si(value_si));
    format!("{} {}·{}", format::significant(value, 4), unit.printed(), kpa.printed())
}

/// A bound's limit in the unit it is shown in, without digits nobody wrote.
pub fn limit_text(metric: Metric, max: f64, unit: Unit) -> String {
    if metric.is_ratio() {
        format!("{} %", format::short(100.0 * max))
    } else {
        format::with_unit(&format::short(unit.from_si(max)), unit)
    }
}

/// Measured points, zero references apart: what a prediction is asked for.
pub fn asked(comparison: &Comparison) -> usize {
    if let Some(meeting) = &comparison.meeting {
        return meeting.n_available();
    }
    let not_asked = |p: &&Point| {
        matches!(
            p.status,
            PointStatus::ZeroReference
                | PointStatus::HoleInPrint
                | PointStatus::InFit
                | PointStatus::NotCompared
                | PointStatus::CycleApart
        )
    };
    comparison.points.len() - comparison.points.iter().filter(not_asked).count()
}

fn sentence(comparison: &Comparison, bound: &Bound, why: Why) -> String {
    let unit = comparison.quantity.unit();
    let name = bound.metric.title();
    let limit = limit_text(bound.metric, bound.max, unit);
    let record = comparison.metric(bound.metric);
    let value = match record.map(MetricRecord::measure) {
        Some(Measure::Known(interval)) => {
            let interval = interval.abs();
            let text = |v| metric_text(bound.metric, v, unit);
            if interval.half_width() > 0.0 {
                let ground = match comparison.basis {
                    Basis::PublishedPoint => "printed digits",
                    Basis::Session if record.is_some_and(|r| r.single_repeat) => "instruments alone, 95 %",
                    Basis::Session => "95 %",
                };
                format!("{} ({ground}: {} to {})", text(interval.value), text(interval.lower), text(interval.upper))
            } else {
                text(interval.value)
            }
        }
        Some(Measure::Shown(value)) => metric_text(bound.metric, value, unit),
        Some(Measure::Undefined(_)) | None => "undefined".to_owned(),
    };
    let expected = if bound.expect == Expect::Exceed { ", as expected" } else { "" };
    // What would decide it, if the half width of the interval had to shrink to this.
    let decides = |half: f64| {
        let general = match comparison.basis {
            Basis::PublishedPoint => "one more printed digit, or the raw data, could decide it",
            Basis::Session => "more repeats, or a better instrument, could decide it",
        };
        let known = record.map(MetricRecord::measure);
        let Some(Measure::Known(interval)) = known else { return general.to_owned() };
        let Interval { value, lower, upper } = interval;
        // The wider side: the other may end at zero.
        let width = match why {
            Why::Straddles => (upper - value).max(value - lower),
            _ => interval.abs().half_width(),
        };
        what_would_decide(comparison, bound.metric, width, half).unwrap_or_else(|| general.to_owned())
    };
    // The points that the metric lives on.
    let on = match bound.metric {
        Metric::ResidualAtZero => PointStatus::ZeroReference,
        _ => PointStatus::Used,
    };
    let distance = record.and_then(|r| r.value).map_or(0.0, |value| (value.abs() - bound.max).abs());
    match why {
        Why::NoInterval if bound.metric != Metric::ResidualAtZero && nothing_moves(comparison) => format!(
            "{name} is {value}, and the alignment or fit takes out all that is declared to be uncertain, which is the same in every reading; `std` of the prediction's table row by row, or the comparison without it, could decide it"
        ),
        // Runs of a movement are not merged, however many there are.
        Why::SingleRepeat if comparison.samples_alone => format!(
            "{name} is {value}, from single samples, matched at equal {}, which have no scatter to judge by; allow_single_repeat in the bound could decide it",
            comparison.against.name()
        ),
        Why::NoInterval if comparison.samples_alone => format!(
            "{name} is {value}, from single samples, matched at equal {}, of an instrument that declares no uncertainty; `std` or `resolution` in rig.toml and allow_single_repeat in the bound could decide it",
            comparison.against.name()
        ),
        Why::SingleRepeat => format!(
            "{name} is {value}, from one repeat at {}, which has no scatter to judge by{}; a second repeat at equal pressure, or allow_single_repeat in the bound, could decide it",
            of_points(comparison, on, |p| p.repeats < 2),
            other_way(comparison, on)
        ),
        Why::NoInterval => {
            let is_unknown = |p: &Point| p.measured_half_width.is_none();
            let agree = comparison.points.iter().any(|p| p.status == on && is_unknown(p) && p.repeats > 1);
            format!(
                "{name} is {value}, from {} at {}, of an instrument that declares no uncertainty{}; `std` or `resolution` in rig.toml, and more repeats or allow_single_repeat in the bound, could decide it",
                if agree { "one repeat, or repeats that agree to the last digit," } else { "one repeat" },
                of_points(comparison, on, is_unknown),
                other_way(comparison, on)
            )
        }
        Why::Within if bound.expect == Expect::Exceed => {
            format!("{name} is {value}, within the bound of {limit}, which it was expected to exceed")
        }
        Why::Within => format!("{name} is {value}, within the bound of {limit}"),
        Why::Beyond => format!("{name} is {value}, beyond the bound of {limit}{expected}"),
        Why::Straddles => {
            format!("{name} is {value}, which reaches over the bound of {limit}; {}", decides(distance))
        }
        Why::TooUncertain => format!(
            "{name} is {value}, known less sharply than the ± {} asked for; {}",
            limit_text(bound.metric, bound.max_uncertainty.unwrap_or(f64::NAN), unit),
            decides(bound.max_uncertainty.unwrap_or(0.0))
        ),
        Why::NotFinite => {
            if let Some(too_little) = too_little(comparison) {
                return too_little;
            }
            let undefined = record.and_then(|r| r.undefined.as_deref());
            let reason = why_nothing(comparison).or(undefined).unwrap_or("it is not a finite number");
            format!("{name} cannot be formed: {reason}; a finite value at every point could decide it")
        }
        Why::NoPrediction => {
            let total = asked(comparison);
            let first = comparison.points.iter().find(|p| p.status == PointStatus::NoPrediction);
            let reason = first.and_then(|p| p.reason.as_deref()).unwrap_or("no value");
            format!(
                "no prediction at {} of {total} measured points{expected}: {reason}",
                comparison.n_without_prediction
            )
        }
    }
}

/// How many of the points with a status are such.
fn of_points(comparison: &Comparison, status: PointStatus, is_such: impl Fn(&Point) -> bool) -> String {
    let all = || comparison.points.iter().filter(|p| p.status == status);
    format!("{} of {} points", all().filter(|p| is_such(p)).count(), all().count())
}

/// Whether what is declared to be uncertain moves no residual: an alignment or a fit took it out.
fn nothing_moves(comparison: &Comparison) -> bool {
    let used = || comparison.points.iter().filter(|p| p.status == PointStatus::Used);
    !comparison.budget.is_empty() && used().all(|p| p.measured_half_width.is_some())
}

/// What is no repeat because another run went there the other way, in words; nothing where there is none.
fn other_way(comparison: &Comparison, status: PointStatus) -> String {
    let alone = || comparison.points.iter().filter(|p| p.status == status && p.repeats == 1);
    let is_met = |p: &&Point| {
        let near = |a: f64, b: f64| (a - b).abs() <= SAME_PRESSURE_SHARE * b.abs();
        let equal = |q: &Point| p.pressures_gauge_pa.iter().zip(&q.pressures_gauge_pa).all(|(a, b)| near(*a, *b));
        alone().any(|q| q.branch != p.branch && q.runs != p.runs && q.conditions_si == p.conditions_si && equal(q))
    };
    match alone().filter(is_met).count() {
        0 => String::new(),
        n => format!(
            " ({n} of them were read on the way up in one run and on the way down in another, which are no repeats of each other; branches = \"together\" in the response if the order of the rows means nothing)"
        ),
    }
}

/// Judges stored results again, from their stored metrics: by their stored bounds, or by others.
///
/// # Errors
/// [`AnalysisError::Ingest`] for a bound that measures something else than the quantity.
pub fn rejudge(results: &mut Results, bounds: Option<&Bounds>) -> Result<(), AnalysisError> {
    if let Some(bounds) = bounds {
        let of = |id: &str| {
            let mine = results.comparisons.iter().filter(|c| c.actuator == id);
            mine.map(|c| (c.quantity.id.clone(), c.form.clone())).collect::<Vec<_>>()
        };
        let actuators: Vec<&str> = results.actuators.iter().map(|a| a.id.as_str()).collect();
        let mut texts: BTreeSet<String> = actuators.iter().flat_map(|id| bounds.unused_rows(id, &of(id))).collect();
        texts.extend(strangers(bounds, &actuators));
        results.findings.retain(|finding| finding.kind != "bounds");
        results.findings.extend(notes(texts));
    }
    for comparison in results.comparisons.iter_mut().filter(|c| c.counted) {
        let rows = match bounds {
            Some(bounds) => {
                let dimension = comparison.quantity.unit().dimension;
                bounds.of(&comparison.actuator, &comparison.quantity.id, &comparison.form, dimension)?
            }
            None => comparison.judgements.iter().map(|j| j.bound.clone()).collect(),
        };
        judge_comparison(comparison, rows, None);
    }
    Ok(())
}

/// Actuators that bounds name and that are not here.
pub fn strangers(bounds: &Bounds, here: &[&str]) -> Vec<String> {
    let missing = bounds.actuators().filter(|id| !here.contains(id));
    missing.map(|id| format!("bounds on {id} were not used: no such actuator here")).collect()
}

/// Findings worth knowing.
pub fn notes(texts: BTreeSet<String>) -> Vec<FindingRecord> {
    let note = |text| FindingRecord {
        severity: Severity::Note,
        kind: "bounds".to_owned(),
        dataset: None,
        file: None,
        channel: None,
        count: None,
        spans: vec![],
        text,
    };
    texts.into_iter().map(note).collect()
}
