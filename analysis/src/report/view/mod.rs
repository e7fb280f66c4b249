//! What pages show: stored numbers as text.

mod budget;
mod method;
mod overview;
mod session;
mod tables;

use std::collections::BTreeMap;

use serde::Serialize;

use pneuval_ingest::units::Unit;

use budget::BudgetTable;
use session::{MaterialView, SessionView};
use tables::{MetricTable, PointTable};
pub use tables::{place, values};

use super::figures::{DATASETS_MAX, Figure, by_urgency};
use super::group::{by_measurement, measurement_title};
use crate::format;
use crate::gate::{asked, limit_text, metric_text};
use crate::metrics::Metric;
use crate::results::{
    ActuatorRecord, Comparison, Decision, FindingRecord, JudgementRecord, PointStatus, Results, Standing,
};
use crate::verdict::Verdict;

/// The head of every page.
#[derive(Serialize)]
pub struct Head {
    pub program: String,
    pub metric_definitions: u32,
    pub report_only: bool,
    pub actuators: Vec<Link>,
}

#[derive(Serialize)]
pub struct Link {
    pub id: String,
    pub title: String,
}

/// The decision over some comparisons.
#[derive(Serialize)]
pub struct DecisionView {
    /// `good`, `bad` or `open`, for colour.
    pub tone: &'static str,
    /// The decision in a sentence.
    pub headline: String,
    /// Counts.
    pub detail: String,
}

/// What the index shows.
#[derive(Serialize)]
pub struct Index {
    pub decision: DecisionView,
    pub overview: Vec<Card>,
    pub rows: Vec<Row>,
    pub findings: Vec<FindingView>,
    pub losses: Vec<String>,
    /// Titles of sessions that a program wrote.
    pub synthetic: Vec<String>,
}

/// A finding.
#[derive(Serialize)]
pub struct FindingView {
    pub severity: &'static str,
    pub place: String,
    pub text: String,
}

/// An actuator on the index.
#[derive(Serialize)]
pub struct Card {
    pub id: String,
    pub title: String,
    pub summary: String,
    pub decision: DecisionView,
    /// Worst bound, sessions, specimens, points.
    pub facts: Vec<(&'static str, String)>,
}

/// A row of the comparison table.
#[derive(Serialize)]
pub struct Row {
    pub actuator: String,
    pub actuator_title: String,
    pub quantity: String,
    pub title: String,
    pub form: String,
    pub kind: String,
    pub n: String,
    pub excluded: String,
    pub rmse: NotedText,
    pub max: NotedText,
    pub relative: NotedText,
    pub relative_of: &'static str,
    pub bound: String,
    pub verdict: &'static str,
    /// `good`, `bad`, `open` or `none`.
    pub tone: &'static str,
    pub expectation: &'static str,
    pub sentence: String,
    pub remark: Option<String>,
    pub rests_on: String,
}

/// Everything a type's page shows.
#[derive(Serialize)]
pub struct ActuatorPage<'a> {
    pub record: &'a ActuatorRecord,
    pub decision: DecisionView,
    pub facts: Vec<(&'static str, String)>,
    pub rows: Vec<Row>,
    /// Of those that are shown in detail.
    pub words: Vec<Row>,
    pub figures: Vec<FigureView<'a>>,
    /// What is not shown in detail because there is much.
    pub undetailed: Option<String>,
    /// Some dataset names figures whose data are not printed.
    pub unprinted: bool,
    pub tables: Vec<PointTable>,
    pub metrics: Vec<MetricTable>,
    pub budgets: Vec<BudgetTable>,
    pub forms: Vec<FormView>,
    /// Bounds, and why they are what they are.
    pub reasons: Vec<(String, Vec<String>)>,
    pub inputs: Vec<InputView>,
    pub materials: Vec<MaterialView>,
    pub sessions: Vec<SessionView>,
    pub findings: Vec<FindingView>,
    pub stated: Vec<StatedView>,
    pub terms: Vec<method::Term>,
    /// Titles of sessions that a program wrote.
    pub synthetic: Vec<String>,
}

#[derive(Serialize)]
pub struct FigureView<'a> {
    pub name: &'a str,
    pub title: &'a str,
    pub caption: &'a str,
    /// An `svg` element.
    pub svg: &'a str,
    pub legend: &'a [(String, String)],
    /// There is a PNG file of it.
    pub has_file: bool,
}

/// A form's equation and source.
#[derive(Clone, PartialEq, Serialize)]
pub struct FormView {
    pub title: String,
    pub quantity: String,
    pub kind: String,
    pub source: String,
    pub equation: Option<String>,
    pub misprints: Vec<String>,
    pub fit: Option<String>,
}

#[derive(Serialize)]
pub struct InputView {
    pub name: String,
    pub value: String,
    pub origin: String,
    pub place: String,
}

#[derive(Serialize)]
pub struct StatedView {
    pub title: String,
    pub value: String,
    pub place: String,
}

/// Stands where there is no number.
pub const DASH: &str = "–";

pub fn head(results: &Results) -> Head {
    Head {
        program: results.program.clone(),
        metric_definitions: results.metric_definitions,
        report_only: results.report_only,
        actuators: results.actuators.iter().map(|a| Link { id: a.id.clone(), title: a.title.clone() }).collect(),
    }
}

pub fn index(results: &Results) -> Index {
    let card = |a: &ActuatorRecord| Card {
        id: a.id.clone(),
        title: a.title.clone(),
        summary: a.summary.clone(),
        decision: decision(results, Some(&a.id)),
        facts: overview::facts(results, a),
    };
    let mut overview: Vec<Card> = results.actuators.iter().map(card).collect();
    // A reader looks for what went wrong.
    overview.sort_by_key(|card| ["bad", "open"].iter().position(|tone| *tone == card.decision.tone).unwrap_or(2));
    Index {
        decision: decision(results, None),
        overview,
        rows: rows_by_urgency(results),
        findings: results.findings.iter().map(finding).collect(),
        losses: results.losses(),
        synthetic: synthetic(results.actuators.iter()),
    }
}

/// Titles of sessions that a program wrote.
fn synthetic<'a>(actuators: impl Iterator<Item = &'a ActuatorRecord>) -> Vec<String> {
    let datasets = actuators.flat_map(|a| &a.datasets);
    datasets.filter(|d| d.session.as_ref().is_some_and(|s| s.synthetic)).map(|d| d.title.clone()).collect()
}

/// Rows in the order in which a reader needs them: what differs from the expected first, then what is open.
pub fn rows_by_urgency(results: &Results) -> Vec<Row> {
    let all: Vec<&Comparison> = results.comparisons.iter().collect();
    by_standing(&all).map(|c| row(results, c)).collect()
}

fn by_standing<'a, 'b>(all: &'b [&'a Comparison]) -> impl Iterator<Item = &'a Comparison> + use<'a, 'b> {
    let order = [Standing::Unexpected, Standing::Open, Standing::AsExpected, Standing::NotCounted];
    order.into_iter().flat_map(move |standing| all.iter().copied().filter(move |c| c.standing() == standing))
}

fn row(results: &Results, c: &Comparison) -> Row {
    let unit = c.quantity.unit();
    let title = results.actuators.iter().find(|a| a.id == c.actuator).map_or(c.actuator.clone(), |a| a.title.clone());
    let (relative_metric, relative_of) = relative_metric(c);
    Row {
        actuator: c.actuator.clone(),
        actuator_title: title,
        quantity: measurement_title(c),
        title: c.title.clone(),
        form: c.form.clone(),
        kind: if c.alignment.is_some() { format!("{}, aligned to the measurement", c.kind) } else { c.kind.clone() },
        n: counted(c),
        excluded: excluded(c),
        rmse: metric_cell(c, Metric::Rmse, unit),
        max: metric_cell(c, Metric::MaxAbsError, unit),
        relative: metric_cell(c, relative_metric, unit),
        relative_of,
        bound: bounds(c),
        verdict: c.verdict.name(),
        tone: tone(c),
        expectation: expectation(c),
        sentence: c.sentence.clone(),
        remark: c.remark.clone(),
        rests_on: c.rests_on.join(", ").replace('_', " "),
    }
}

/// The relative error a row shows: the one its bound names, else of the measured value.
pub fn relative_metric(c: &Comparison) -> (Metric, &'static str) {
    match c.deciding().map(|j| j.bound.metric) {
        Some(m @ Metric::RelativeToPredictedMax) => (m, "of predicted"),
        Some(m @ Metric::RelativeToPredictedMean) => (m, "of predicted, mean"),
        Some(m @ Metric::RelativeToRangeMax) => (m, "of range"),
        Some(m @ Metric::RelativeToRangeRmse) => (m, "of range, RMSE"),
        Some(m @ Metric::RelativeToMeasuredMean) => (m, "of measured, mean"),
        _ => (Metric::RelativeToMeasuredMax, "of measured"),
    }
}

/// A metric in a table: its value, or what is known over the points that have a prediction, or a dash.
pub fn metric_cell(c: &Comparison, metric: Metric, unit: Unit) -> NotedText {
    let plain = |text: String| NotedText { text, note: String::new() };
    let Some(record) = c.metric(metric) else { return plain(DASH.to_owned()) };
    match (record.value, record.over_predicted_points) {
        (Some(value), _) if c.metrics_printed => plain(stated_text(metric, value, record.upper, unit)),
        (Some(value), _) => plain(metric_text(metric, value, unit)),
        (None, Some(partial)) => {
            let note = format!("at {} of {} points", c.n_used, asked(c));
            NotedText { text: format!("({})", metric_text(metric, partial, unit)), note }
        }
        (None, None) => plain(DASH.to_owned()),
    }
}

/// A stated metric with the digits it is printed with.
pub fn stated_text(metric: Metric, value: f64, upper: Option<f64>, unit: Unit) -> String {
    let half = upper.map_or(0.0, |upper| upper - value);
    if metric.is_ratio() || half <= 0.0 {
        return metric_text(metric, value, unit);
    }
    format::quantity(value, unit, tables::printed_decimals(unit.from_si(half)))
}

/// A text and what must be known to read it.
#[derive(Serialize)]
pub struct NotedText {
    /// The text.
    pub text: String,
    /// The note; often empty.
    pub note: String,
}

/// Points used of points available.
pub fn counted(c: &Comparison) -> String {
    if c.metrics_printed { "not printed".to_owned() } else { format!("{} / {}", c.n_used, c.n_available) }
}

fn finding(f: &FindingRecord) -> FindingView {
    let file = f.file.as_deref().unwrap_or_default();
    FindingView {
        severity: f.severity.name(),
        place: f.dataset.as_ref().map_or(String::new(), |id| format!("{id}, {file}")),
        text: f.text.clone(),
    }
}

/// Points that are not in the metrics, counted by reason.
pub fn excluded(c: &Comparison) -> String {
    let count = |status| c.points.iter().filter(|p| p.status == status).count();
    let mut parts = Vec::new();
    for (status, one) in [
        (PointStatus::ZeroReference, "zero reference"),
        (PointStatus::NoPrediction, "without prediction"),
        (PointStatus::NotFinite, "not finite"),
        (PointStatus::PredictionNotPrinted, "prediction not printed"),
        (PointStatus::HoleInPrint, "not printed"),
        (PointStatus::InFit, "in the fit"),
        (PointStatus::NotCompared, "not compared"),
        (PointStatus::CycleApart, "of a cycle apart"),
    ] {
        let n = count(status);
        if n > 0 {
            parts.push(format!("{n} {one}"));
        }
    }
    parts.extend(c.meeting.as_ref().map(|m| format!("overlap {}", format::percent(m.overlap))));
    parts.join(", ")
}

/// Whether the verdict is what was expected, in a word.
pub fn expectation(c: &Comparison) -> &'static str {
    match c.standing() {
        Standing::AsExpected if c.verdict == Verdict::Fail => "as expected",
        Standing::AsExpected => "",
        Standing::Unexpected if c.verdict == Verdict::Pass => "expected to exceed",
        Standing::Unexpected => "expected to pass",
        Standing::Open => "open",
        Standing::NotCounted => "not counted",
    }
}

/// What a standing means to a reader, for colour: `good`, `known`, `bad`, `open` or `none`.
pub fn tone(c: &Comparison) -> &'static str {
    match c.standing() {
        Standing::AsExpected if c.verdict == Verdict::Fail => "known",
        Standing::AsExpected => "good",
        Standing::Unexpected => "bad",
        Standing::Open => "open",
        Standing::NotCounted => "none",
    }
}

/// The decision over all comparisons, or over those of one actuator.
pub fn decision(results: &Results, actuator: Option<&str>) -> DecisionView {
    let mine: Vec<&Comparison> =
        results.comparisons.iter().filter(|c| actuator.is_none_or(|id| c.actuator == id)).collect();
    let count = |standing| mine.iter().filter(|c| c.standing() == standing).count();
    let (unexpected, open) = (count(Standing::Unexpected), count(Standing::Open));
    let known = mine.iter().filter(|c| c.standing() == Standing::AsExpected && c.verdict == Verdict::Fail).count();
    let passed = count(Standing::AsExpected) - known;
    let decision = match actuator {
        None => results.decision(),
        Some(_) if unexpected > 0 => Decision::Unexpected,
        Some(_) if open > 0 || passed + known == 0 => Decision::Open,
        Some(_) => Decision::AsExpected,
    };
    let (tone, headline) = match decision {
        Decision::AsExpected => ("good", "Every verdict is as expected".to_owned()),
        Decision::Unexpected => ("bad", format!("{unexpected} of {} differ from what was expected", mine.len())),
        Decision::Open if open == 0 && passed + known > 0 => {
            ("open", "Data are lost or too many are excluded".to_owned())
        }
        Decision::Open if passed + known + unexpected + open == 0 => ("open", "Nothing was judged".to_owned()),
        Decision::Open => ("open", format!("{open} of {} open: inconclusive or without a bound", mine.len())),
    };
    let plural = if mine.len() == 1 { "" } else { "s" };
    let mut parts = vec![format!("{} comparison{plural}", mine.len()), format!("{passed} pass")];
    if known > 0 {
        parts.push(format!("{known} exceed their bound as expected"));
    }
    if unexpected > 0 {
        parts.push(format!("{unexpected} differ"));
    }
    if open > 0 {
        parts.push(format!("{open} open"));
    }
    if count(Standing::NotCounted) > 0 {
        parts.push(format!("{} not counted", count(Standing::NotCounted)));
    }
    DecisionView { tone, headline, detail: parts.join(" · ") }
}

pub fn actuator_page<'a>(
    results: &'a Results,
    record: &'a ActuatorRecord,
    figures: &'a [Figure],
    photographs: Option<&BTreeMap<String, Vec<u8>>>,
    every: bool,
) -> ActuatorPage<'a> {
    let mine: Vec<&Comparison> = results.comparisons.iter().filter(|c| c.actuator == record.id).collect();
    let order = by_urgency(results, record);
    let detailed: Vec<&str> = order.iter().take(if every { usize::MAX } else { DATASETS_MAX }).copied().collect();
    let shown: Vec<&Comparison> = mine.iter().copied().filter(|c| detailed.contains(&c.dataset.as_str())).collect();
    // One table per dataset and quantity, in the order of the comparisons.
    let groups = by_measurement(shown.iter().copied());
    ActuatorPage {
        record,
        decision: decision(results, Some(&record.id)),
        facts: overview::facts(results, record),
        rows: by_standing(&mine).map(|c| row(results, c)).collect(),
        words: by_standing(&shown).map(|c| row(results, c)).collect(),
        figures: figures
            .iter()
            .filter(|f| f.actuator == record.id)
            .map(|f| figure_view(f, photographs.is_none()))
            .collect(),
        undetailed: (detailed.len() < order.len()).then(|| undetailed(detailed.len(), order.len())),
        unprinted: record.datasets.iter().any(|d| !d.unprinted.is_empty()),
        tables: groups.iter().flat_map(|group| tables::point_tables(group)).collect(),
        metrics: groups.iter().filter_map(|group| tables::metric_table(group)).collect(),
        budgets: shown.iter().filter_map(|c| budget::table(c)).collect(),
        forms: forms(&mine),
        reasons: reasons(&mine),
        inputs: record.inputs.iter().map(input_view).collect(),
        materials: record.materials.iter().map(session::material).collect(),
        sessions: record
            .datasets
            .iter()
            .filter(|d| detailed.contains(&d.id.as_str()))
            .filter_map(|d| session::session(d, &mine, photographs))
            .collect(),
        findings: results
            .findings
            .iter()
            .filter(|f| f.dataset.as_ref().is_some_and(|id| record.datasets.iter().any(|d| d.id == *id)))
            .map(finding)
            .collect(),
        stated: record.datasets.iter().flat_map(|d| &d.stated).map(stated_view).collect(),
        terms: method::terms(&mine),
        synthetic: synthetic(std::iter::once(record)),
    }
}

fn undetailed(n: usize, all: usize) -> String {
    format!(
        "Shown in detail: {n} of {all} datasets, first those whose verdicts differ or are open, then those that use most of their bound. \
         The table of comparisons and the files beside this page hold all of them; `--every-figure` shows every one."
    )
}

/// Forms, each once however many datasets it is compared with.
fn forms(mine: &[&Comparison]) -> Vec<FormView> {
    let mut seen: Vec<(&str, FormView)> = Vec::new();
    for c in mine.iter().filter(|c| c.kind != "none") {
        let (id, view) = (c.quantity.id.as_str(), form_view(c));
        let is_same = |(of, other): &&mut (&str, FormView)| {
            *of == id && FormView { quantity: view.quantity.clone(), ..other.clone() } == view
        };
        match seen.iter_mut().find(is_same) {
            // Of several measurements the quantity alone names it.
            Some((_, other)) if other.quantity != view.quantity => other.quantity.clone_from(&c.quantity.title),
            Some(_) => {}
            None => seen.push((id, view)),
        }
    }
    seen.into_iter().map(|(_, view)| view).collect()
}

/// Bounds with their reasons, each once.
fn reasons(mine: &[&Comparison]) -> Vec<(String, Vec<String>)> {
    let mut seen: Vec<(String, Vec<String>)> = Vec::new();
    for c in mine.iter().filter(|c| !c.judgements.is_empty()) {
        let mut why: Vec<String> = c.judgements.iter().map(|j| j.bound.reason.clone()).collect();
        why.dedup();
        let one = (format!("{}, {}: {}", c.quantity.title, c.title, bounds(c)), why);
        if !seen.contains(&one) {
            seen.push(one);
        }
    }
    seen
}

fn figure_view(figure: &Figure, has_folder: bool) -> FigureView<'_> {
    FigureView {
        name: &figure.name,
        title: &figure.title,
        caption: &figure.caption,
        svg: &figure.svg,
        legend: &figure.legend,
        has_file: has_folder && figure.png.is_some(),
    }
}

fn form_view(c: &Comparison) -> FormView {
    let fit = c.fit.as_ref().map(|fit| {
        let unit = c.quantity.unit();
        let parameters: Vec<String> = fit
            .parameters
            .iter()
            .map(|p| {
                let shown = |v: f64| Unit::parse(&p.unit).map_or(v, |u| u.from_si(v));
                let std = p.std_si.map_or(String::new(), |s| format!(" ± {}", format::significant(shown(s), 2)));
                format!("{} = {}{std} {}", p.name, format::significant(shown(p.value_si), 4), p.unit)
            })
            .collect();
        let held = fit.hold_out.as_ref().map_or(String::new(), |text| format!("; {text}"));
        let any_std = fit.parameters.iter().any(|p| p.std_si.is_some());
        let what = if any_std { "; ± is the standard error" } else { "" };
        format!(
            "fitted on {}{held} ({} points{what}): {}; RMSE of the fit {}, condition number {}",
            fit.fitted_on.join(", "),
            fit.n,
            parameters.join(", "),
            format::quantity(fit.rmse_si, unit, format::error_decimals(unit)),
            format::significant(fit.condition_number, 2)
        )
    });
    FormView {
        title: c.title.clone(),
        quantity: measurement_title(c),
        kind: c.kind.clone(),
        source: c.source.clone(),
        equation: c.equation.clone(),
        misprints: c.misprints.clone(),
        fit,
    }
}

fn input_view(input: &crate::results::InputRecord) -> InputView {
    let shown = Unit::parse(&input.unit).map_or_else(
        || format::short(input.value_si),
        |unit| {
            let std = input.std_si.map_or(String::new(), |s| format!(" ± {}", format::short(unit.from_si(s))));
            format::with_unit(&format!("{}{std}", format::short(unit.from_si(input.value_si))), unit)
        },
    );
    InputView {
        name: input.name.replace('_', " "),
        value: shown,
        origin: input.origin.clone(),
        place: input.place.clone().unwrap_or_default(),
    }
}

fn stated_view(stated: &crate::results::StatedRecord) -> StatedView {
    let value = Unit::parse(&stated.unit).map_or_else(
        || format::short(stated.value_si),
        |u| format::with_unit(&format::short(u.from_si(stated.value_si)), u),
    );
    StatedView { title: stated.title.clone(), value, place: stated.place.clone().unwrap_or_default() }
}

/// The bounds of a comparison: `max |e| ≤ 2.5 mm`.
pub fn bounds(comparison: &Comparison) -> String {
    let unit = comparison.quantity.unit();
    let one =
        |j: &JudgementRecord| format!("{} ≤ {}", j.bound.metric.title(), limit_text(j.bound.metric, j.bound.max, unit));
    let all: Vec<String> = comparison.judgements.iter().map(one).collect();
    if all.is_empty() { DASH.to_owned() } else { all.join("; ") }
}
