//! Measured and predicted values side by side: what becomes of every point, and the metrics over those that are used.

use pneuval_ingest::number::Printed;

use crate::metrics::{self, Interval, Measure, Metric, Pair};
use crate::prediction::{Predicted, full_pressures, share};
use crate::response::{IntervalKind, Response, ResponsePoint};
use crate::results::{MetricRecord, Point, PointStatus};

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
    let residual = measured.zip(predicted).map(|(m, p)| pair(m, p).residual().value);
    Point {
        line: response.line,
        runs: response.runs.clone(),
        pressures_gauge_pa: response.pressures_gauge_pa.clone(),
        pressure_share: share(&response.pressures_gauge_pa, full),
        at: response.at,
        conditions_si: response.conditions.iter().map(|c| c.si).collect(),
        measured_half_width: half_widths(measured),
        measured: numbers(measured),
        predicted_half_width: half_widths(predicted),
        predicted: numbers(predicted),
        residual,
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

/// Every metric over the points. Without intervals (a single repeat of an instrument that declares nothing) a metric has a
/// value and no interval. What is known of the zero-pressure references is the concern of their own metric alone.
pub fn measure_all(points: &[Point], used: Knowledge, at_zero_known: Knowledge) -> Vec<MetricRecord> {
    let pair = |p: &Point| {
        let intervals = |values: &Option<Vec<f64>>, half_widths: &[f64]| -> Vec<Interval> {
            let value = |i: usize| values.as_ref().map_or(f64::NAN, |v| v[i]);
            (0..half_widths.len())
                .map(|i| Interval::from(Printed { si: value(i), half_width_si: half_widths[i] }))
                .collect()
        };
        Pair {
            predicted: intervals(&p.predicted, &p.predicted_half_width),
            measured: intervals(&p.measured, &p.measured_half_width),
        }
    };
    let of = |status| points.iter().filter(move |p| p.status == status);
    let in_metrics = |p: &&Point| matches!(p.status, PointStatus::Used | PointStatus::NotFinite);
    let pairs: Vec<Pair> = points.iter().filter(in_metrics).map(pair).collect();
    let at_zero: Vec<Pair> = of(PointStatus::ZeroReference).map(pair).collect();
    let without_prediction = of(PointStatus::NoPrediction).count();
    let not_printed = of(PointStatus::PredictionNotPrinted).count();
    let asked = pairs.len() + without_prediction + not_printed;
    // Points that are missing from a mean would make it another mean: it is then only told, never judged.
    let missing = if without_prediction > 0 {
        Some(format!("no prediction at {without_prediction} of {asked} measured points"))
    } else if not_printed > 0 && !pairs.is_empty() {
        Some(format!("no predicted value is printed at {not_printed} of {asked} measured points"))
    } else {
        None
    };
    Metric::ALL
        .into_iter()
        .map(|metric| {
            let known = if metric == Metric::ResidualAtZero { at_zero_known } else { used };
            let measure = match metrics::measure(metric, &pairs, &at_zero) {
                Measure::Known(interval) if known.unknown => Measure::Shown(interval.value),
                measure => measure,
            };
            let record = MetricRecord { single_repeat: known.single_repeat, ..MetricRecord::new(metric, measure) };
            match &missing {
                Some(why) if metric != Metric::ResidualAtZero => MetricRecord {
                    metric,
                    value: None,
                    lower: None,
                    upper: None,
                    undefined: Some(record.undefined.unwrap_or_else(|| why.clone())),
                    over_predicted_points: record.value,
                    single_repeat: known.single_repeat,
                },
                _ => record,
            }
        })
        .collect()
}
