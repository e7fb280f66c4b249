//! Measured and predicted values side by side: what becomes of every point, and the metrics over those that are used.

use pneuval_ingest::number::Printed;

use crate::metrics::{self, Interval, LoopArea, Measure, Metric, Pair};
use crate::prediction::{Predicted, full_pressures, share};
use crate::response::{IntervalKind, Response, ResponsePoint, loop_weights};
use crate::results::{BudgetRecord, MetricRecord, Point, PointStatus, ValidationRecord};
use crate::uncertainty::errors::{Cause, Errors, Factor, Source};
use crate::uncertainty::intervals::{Known, Sample};

/// Every point of the response with its prediction, and what becomes of it.
pub fn points(response: &Response, predicted: &[Predicted]) -> Vec<Point> {
    let full = full_pressures(&response.pressures());
    let width = response.quantity.width();
    let of = |(measured, predicted)| point(measured, predicted, response.is_zero_reference(measured), &full, width);
    response.points.iter().zip(predicted).map(of).collect()
}

fn point(
    response: &ResponsePoint,
    predicted: &Predicted,
    is_zero_reference: bool,
    full: &[f64],
    width: usize,
) -> Point {
    let (status, reason) = status(response, predicted, is_zero_reference);
    let finite = |values: &&Vec<Printed>| values.iter().all(|v| v.si.is_finite());
    let measured = response.measured.as_ref().filter(finite);
    let predicted = match predicted {
        Predicted::Value(values) | Predicted::InFit(values) => Some(values).filter(finite),
        _ => None,
    };
    let half_widths = |values: Option<&Vec<Printed>>| {
        values.map_or(vec![0.0; width], |values| values.iter().map(|v| v.half_width_si).collect())
    };
    let numbers = |values: Option<&Vec<Printed>>| values.map(|v| v.iter().map(|v| v.si).collect());
    let residual = measured.zip(predicted).map(|(m, p)| pair(m, p).residual());
    // Of a session they come from its errors, which points share.
    let printed = residual.filter(|_| response.interval == IntervalKind::PrintedDigits);
    Point {
        line: response.line,
        runs: response.runs.clone(),
        branch: response.branch,
        repeats: response.repeats.len(),
        pressures_gauge_pa: response.pressures_gauge_pa.clone(),
        pressure_share: share(&response.pressures_gauge_pa, full),
        at: response.at,
        conditions_si: response.conditions.iter().map(|c| c.si).collect(),
        measured_half_width: measured
            .filter(|_| response.interval != IntervalKind::Unknown)
            .map(|m| half_widths(Some(m))),
        measured: numbers(measured),
        predicted_half_width: half_widths(predicted),
        predicted: numbers(predicted),
        residual: residual.map(|r| r.value),
        residual_lower: printed.map(|r| r.lower),
        residual_upper: printed.map(|r| r.upper),
        status,
        reason,
    }
}

fn pair(measured: &[Printed], predicted: &[Printed]) -> Pair {
    let intervals = |values: &[Printed]| values.iter().map(|v| Interval::from(*v)).collect();
    Pair { predicted: intervals(predicted), measured: intervals(measured) }
}

fn status(response: &ResponsePoint, predicted: &Predicted, is_zero_reference: bool) -> (PointStatus, Option<String>) {
    let finite = |values: &[Printed]| values.iter().all(|v| v.si.is_finite());
    if *predicted == Predicted::NotCompared {
        return (PointStatus::NotCompared, None);
    }
    if response.is_apart && response.measured.is_some() {
        return (PointStatus::CycleApart, Some("of a cycle that is shown and not compared".to_owned()));
    }
    if is_zero_reference && response.measured.is_some() {
        let why = match predicted {
            Predicted::NoSolution(why) | Predicted::Failed(why) => format!("; {why}"),
            Predicted::NotPrinted => "; no predicted value is printed".to_owned(),
            Predicted::Value(_) | Predicted::InFit(_) | Predicted::NotCompared => String::new(),
        };
        return (PointStatus::ZeroReference, Some(format!("zero-pressure reference{why}")));
    }
    match (&response.measured, predicted) {
        (None, _) => (PointStatus::HoleInPrint, Some("no measured value is printed".to_owned())),
        (_, Predicted::NoSolution(why)) => (PointStatus::NoPrediction, Some(why.clone())),
        (_, Predicted::Failed(why)) => (PointStatus::NotFinite, Some(why.clone())),
        (_, Predicted::NotPrinted) => {
            (PointStatus::PredictionNotPrinted, Some("no predicted value is printed".to_owned()))
        }
        (Some(m), Predicted::Value(p) | Predicted::InFit(p)) if !finite(m) || !finite(p) => {
            let which = if finite(m) { "predicted" } else { "measured" };
            (PointStatus::NotFinite, Some(format!("the {which} value is not a finite number")))
        }
        (_, Predicted::InFit(_)) => (PointStatus::InFit, Some("in the fit".to_owned())),
        (_, Predicted::Value(_) | Predicted::NotCompared) => (PointStatus::Used, None),
    }
}

/// Less than this share of the largest value is moved by rounding alone.
const ROUNDING_SHARE: f64 = 1e-12;

/// What is known of how sure a set of measured values is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Knowledge {
    /// Some value is a single repeat of a session.
    pub single_repeat: bool,
    /// Some value has no interval at all.
    pub unknown: bool,
}

impl Knowledge {
    /// Of the intervals of some points.
    pub fn of(kinds: &[IntervalKind]) -> Self {
        let unknown = kinds.contains(&IntervalKind::Unknown);
        Self { single_repeat: unknown || kinds.contains(&IntervalKind::Instrument), unknown }
    }
}

/// What is known of the points that metrics live on.
#[derive(Debug, Clone, Copy, Default)]
struct Grounds {
    used: Knowledge,
    at_zero: Knowledge,
    of_loop: Knowledge,
}

/// The metrics of a comparison, and what moves them.
pub struct Measured {
    /// Every metric.
    pub metrics: Vec<MetricRecord>,
    /// Of points that are used, by their index: the interval of the residual.
    pub residuals: Vec<(usize, Interval)>,
    /// What each source contributes to the uncertainty of the points.
    pub budget: Vec<BudgetRecord>,
    /// Comparison error and validation uncertainty.
    pub validation: Option<ValidationRecord>,
}

/// Every metric over the points of a published table: intervals of what print leaves open.
pub fn measure_published(points: &[Point]) -> Vec<MetricRecord> {
    let split = Split::of(points);
    let none = "a printed table has no way up and down";
    let known = |metric| Known {
        measure: metrics::measure(metric, &split.used, &split.at_zero, Err(none)),
        uncorrected: None,
        shares: vec![],
        method: None,
    };
    split.records(points, &known, Grounds::default())
}

/// Every metric over the points of a session. Without intervals (a single repeat of an instrument that declares nothing) a metric has a
/// value and no interval. What is known of the zero-pressure references is the concern of their own metric alone.
pub fn measure_session(points: &[Point], response: &Response, errors: &Errors) -> Measured {
    let split = Split::of(points);
    let width = response.quantity.width();
    let kinds = |of: &[usize]| -> Vec<IntervalKind> { of.iter().map(|&i| response.points[i].interval).collect() };
    let over = |of: &[usize]| {
        let repeats = of.iter().map(|&i| response.points[i].repeats.len()).min().unwrap_or(0);
        Errors { repeats, ..errors.of_points(of, width) }
    };
    let (mut used, at_zero) = (Knowledge::of(&kinds(&split.used_at)), Knowledge::of(&kinds(&split.at_zero_at)));
    let loop_area = loop_area(points, response);
    let errors_of_loop = {
        // As few repeats as at any point of the loop.
        let all: Vec<usize> = (0..points.len()).collect();
        let weight =
            |i: usize| loop_area.as_ref().map_or(0.0, |area| area.of(|at| f64::from(u8::from(at / width == i))));
        let repeats = all.iter().filter(|i| weight(**i) != 0.0).map(|&i| response.points[i].repeats.len()).min();
        Errors { repeats: repeats.unwrap_or(0), ..over(&all) }
    };
    let sample = Sample {
        used: &split.used,
        errors: over(&split.used_at),
        at_zero: &split.at_zero,
        errors_at_zero: over(&split.at_zero_at),
        loop_area,
        errors_of_loop,
    };
    // What an alignment or a fit takes wholly out of the residuals says nothing of how sure they are.
    if !moves(&sample) {
        used = Knowledge { single_repeat: true, unknown: true };
    }
    // A loop that only a common offset could move is as sure as nothing says.
    let of_loop = if sample.loop_moves() { used } else { Knowledge { single_repeat: true, unknown: true } };
    let known = |metric| sample.metric(metric);
    let metrics = split.records(points, &known, Grounds { used, at_zero, of_loop });
    let is_known = !split.used.is_empty() && !used.unknown;
    let validation = is_known.then(|| validation(&split.used, &sample.errors)).flatten();
    let intervals = if is_known { sample.residual_intervals() } else { vec![] };
    let is_finite = |interval: &Interval| interval.lower.is_finite() && interval.upper.is_finite();
    let residuals = split.used_at.iter().copied().zip(intervals).filter(|(_, interval)| is_finite(interval)).collect();
    Measured { metrics, residuals, budget: budget(&sample.errors), validation }
}

/// Whether anything moves a residual beyond what rounding does.
fn moves(sample: &Sample) -> bool {
    let largest = sample.used.iter().flat_map(|pair| pair.numbers(false)).fold(0.0_f64, |most, v| most.max(v.abs()));
    let by = |factor: &Factor| {
        let moved = factor.predicted.iter().zip(&factor.measured).map(|(p, m)| (p - m).abs());
        moved.fold(0.0, f64::max)
    };
    sample.used.is_empty() || sample.errors.factors.iter().any(|factor| by(factor) > ROUNDING_SHARE * largest)
}

/// E, its uncertainty by cause, and where the two meet.
fn validation(used: &[Pair], errors: &Errors) -> Option<ValidationRecord> {
    let e: Vec<f64> = used.iter().flat_map(Pair::differences).collect();
    let rms = |values: &[f64]| (values.iter().map(|v| v * v).sum::<f64>() / values.len() as f64).sqrt();
    let moved = |factor: &Factor, i: usize| factor.predicted[i] - factor.measured[i];
    let std_of = |causes: &[Cause]| -> f64 {
        let is_of = |factor: &&Factor| errors.sources.get(factor.source).is_some_and(|s| causes.contains(&s.cause));
        let of = |i: usize| errors.factors.iter().filter(is_of).map(|f| moved(f, i).powi(2)).sum::<f64>().sqrt();
        rms(&(0..e.len()).map(of).collect::<Vec<f64>>())
    };
    let within = |i: usize| {
        let moved = errors.factors.iter().map(|f| moved(f, i));
        e[i].abs() <= errors.variance(moved).half_width()
    };
    let (u_d_si, u_input_si, u_num_si) = (
        std_of(&[Cause::Repeats, Cause::Instrument, Cause::State]),
        std_of(&[Cause::Input]),
        std_of(&[Cause::Numerical]),
    );
    let record = ValidationRecord {
        e_si: rms(&e),
        u_d_si,
        u_input_si,
        u_num_si,
        u_val_si: u_d_si.hypot(u_input_si).hypot(u_num_si),
        values: e.len(),
        within: (0..e.len()).filter(|&i| within(i)).count(),
    };
    (record.e_si.is_finite() && record.u_val_si.is_finite()).then_some(record)
}

/// What each source contributes to the uncertainty of the residuals of the points that are used.
fn budget(errors: &Errors) -> Vec<BudgetRecord> {
    let of = |(index, source): (usize, &Source)| {
        let mine = || errors.factors.iter().filter(|factor| factor.source == index);
        let n = mine().next().map_or(0, |factor| factor.measured.len());
        let squares: Vec<f64> =
            (0..n).map(|i| mine().map(|f| (f.predicted[i] - f.measured[i]).powi(2)).sum::<f64>()).collect();
        BudgetRecord {
            source: source.name.clone(),
            cause: source.cause,
            evaluation: source.cause.evaluation().to_owned(),
            degrees_of_freedom: errors.freedom(index),
            std_rms_si: if n > 0 { (squares.iter().sum::<f64>() / n as f64).sqrt() } else { 0.0 },
            std_max_si: squares.iter().copied().fold(0.0, f64::max).sqrt(),
        }
    };
    errors.sources.iter().enumerate().map(of).collect()
}

/// The loop of a session's comparison: where loading and unloading are measured and predicted.
fn loop_area(points: &[Point], response: &Response) -> Result<LoopArea, &'static str> {
    let values: Vec<Option<(f64, f64)>> =
        points.iter().map(|p| p.predicted_scalar().zip(p.measured_scalar())).collect();
    let usable = |p: &ResponsePoint| !p.is_apart;
    let (weights, range_pa) = loop_weights(response, &usable)?;
    let mut of_loop = weights.iter().map(|(i, _)| values.get(*i).copied().flatten());
    let Some(pairs) = of_loop.by_ref().collect::<Option<Vec<(f64, f64)>>>() else {
        return Err("a point of the loop has no measured or no predicted value");
    };
    let (low, high) =
        pairs.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), (_, m)| (low.min(*m), high.max(*m)));
    if high <= low {
        return Err("the measured values of the loop do not span a range");
    }
    let values = values.into_iter().map(|v| v.unwrap_or((0.0, 0.0))).collect();
    Ok(LoopArea { weights, values, box_area: range_pa * (high - low) })
}

/// The pairs of a comparison, by what becomes of them, with the indices of their points.
struct Split {
    used: Vec<Pair>,
    used_at: Vec<usize>,
    at_zero: Vec<Pair>,
    at_zero_at: Vec<usize>,
}

impl Split {
    fn of(points: &[Point]) -> Self {
        let pair = |p: &Point| {
            let width = p.predicted_half_width.len();
            let intervals = |values: &Option<Vec<f64>>, half_widths: Option<&Vec<f64>>| -> Vec<Interval> {
                let half_width = |i: usize| half_widths.map_or(0.0, |of| of[i]);
                let value = |i: usize| values.as_ref().map_or(f64::NAN, |v| v[i]);
                (0..width).map(|i| Interval::from(Printed { si: value(i), half_width_si: half_width(i) })).collect()
            };
            Pair {
                predicted: intervals(&p.predicted, Some(&p.predicted_half_width)),
                measured: intervals(&p.measured, p.measured_half_width.as_ref()),
            }
        };
        let at = |wanted: &[PointStatus]| -> Vec<usize> {
            (0..points.len()).filter(|&i| wanted.contains(&points[i].status)).collect()
        };
        let pairs = |of: &[usize]| of.iter().map(|&i| pair(&points[i])).collect();
        let used_at = at(&[PointStatus::Used, PointStatus::NotFinite]);
        let at_zero_at = at(&[PointStatus::ZeroReference]);
        Self { used: pairs(&used_at), used_at, at_zero: pairs(&at_zero_at), at_zero_at }
    }

    fn records(&self, points: &[Point], known: &dyn Fn(Metric) -> Known, all: Grounds) -> Vec<MetricRecord> {
        let count = |status| points.iter().filter(|p| p.status == status).count();
        let (without_prediction, not_printed) =
            (count(PointStatus::NoPrediction), count(PointStatus::PredictionNotPrinted));
        let asked = self.used.len() + without_prediction + not_printed;
        // Points that are missing from a mean would make it another mean: it is then only told, never judged.
        let missing = if without_prediction > 0 {
            Some(format!("no prediction at {without_prediction} of {asked} measured points"))
        } else if not_printed > 0 && !self.used.is_empty() {
            Some(format!("no predicted value is printed at {not_printed} of {asked} measured points"))
        } else {
            None
        };
        let record = |metric| {
            let grounds = match metric {
                Metric::ResidualAtZero => all.at_zero,
                Metric::LoopArea | Metric::LoopAreaShare => all.of_loop,
                _ => all.used,
            };
            let Known { measure, uncorrected, shares, method } = known(metric);
            let measure = match measure {
                Measure::Known(interval) if grounds.unknown => Measure::Shown(uncorrected.unwrap_or(interval.value)),
                measure => measure,
            };
            let record = MetricRecord {
                single_repeat: grounds.single_repeat,
                uncorrected: uncorrected.filter(|_| !grounds.unknown),
                shares,
                method: method.filter(|_| !grounds.unknown),
                ..MetricRecord::new(metric, measure)
            };
            match &missing {
                Some(why) if metric != Metric::ResidualAtZero => MetricRecord {
                    undefined: Some(record.undefined.unwrap_or_else(|| why.clone())),
                    over_predicted_points: record.uncorrected.or(record.value),
                    single_repeat: grounds.single_repeat,
                    ..MetricRecord::new(metric, Measure::Undefined(""))
                },
                _ => record,
            }
        };
        Metric::ALL.into_iter().map(record).collect()
    }
}
