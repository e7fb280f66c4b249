//! Tables of a page: point by point, and every metric.

use serde::Serialize;

use pneuval_ingest::units::Unit;

use super::{DASH, NotedText, counted, measurement_title, metric_cell};
use crate::format;
use crate::gate::metric_text;
use crate::metrics::Metric;
use crate::results::{Against, Comparison, Point, PointStatus};
use crate::verdict::Basis;

/// Rows on a page; a longer table stands in `results.json` alone.
const ROWS_MAX: usize = 200;

/// Measured and predicted values of one quantity, point by point.
#[derive(Serialize)]
pub struct PointTable {
    pub title: String,
    pub basis: &'static str,
    pub source: String,
    pub conditions: Vec<String>,
    pub components: String,
    pub forms: Vec<String>,
    /// What its rows are headed by.
    pub place: &'static str,
    pub points: Vec<PointRow>,
    /// Points that are in `results.json` and not on the page.
    pub hidden: usize,
}

#[derive(Serialize)]
pub struct PointRow {
    pub place: String,
    pub conditions: Vec<String>,
    pub measured: String,
    pub note: String,
    pub predicted: Vec<Cell>,
}

#[derive(Serialize)]
pub struct Cell {
    pub value: String,
    pub residual: String,
    pub note: &'static str,
}

/// Every metric of one quantity, form by form.
#[derive(Serialize)]
pub struct MetricTable {
    pub title: String,
    pub names: Vec<&'static str>,
    pub rows: Vec<MetricRow>,
}

#[derive(Serialize)]
pub struct MetricRow {
    pub title: String,
    pub n: String,
    pub cells: Vec<MetricCell>,
}

#[derive(Serialize)]
pub struct MetricCell {
    pub value: NotedText,
    pub interval: String,
}

/// The table of a measurement; where a movement meets each prediction elsewhere, one for each.
pub(super) fn point_tables(comparisons: &[&Comparison]) -> Vec<PointTable> {
    match comparisons.first() {
        Some(first) if first.against != Against::Pressure => comparisons.chunks(1).filter_map(point_table).collect(),
        _ => point_table(comparisons).into_iter().collect(),
    }
}

/// Where a point stands.
pub fn place(c: &Comparison, point: &Point) -> String {
    match (c.against, point.at) {
        (Against::Time, Some(at)) => format!("{at:.4} s"),
        (Against::ArcLength, Some(at)) => format::percent(at),
        _ => format::pressures(&point.pressures_gauge_pa, &c.chambers),
    }
}

fn point_table(comparisons: &[&Comparison]) -> Option<PointTable> {
    let comparisons: Vec<&Comparison> = comparisons.iter().copied().filter(|c| !c.metrics_printed).collect();
    let first = *comparisons.first()?;
    let unit = first.quantity.unit();
    let shown = first.points.len().min(ROWS_MAX);
    let points = first.points[..shown]
        .iter()
        .enumerate()
        .map(|(i, point)| PointRow {
            place: place(first, point),
            conditions: conditions(first, &point.conditions_si),
            measured: point.measured.as_deref().map_or(DASH.to_owned(), |m| {
                values(
                    m,
                    point.measured_half_width.as_deref().unwrap_or_default(),
                    first.basis == Basis::PublishedPoint,
                    unit,
                )
            }),
            note: match point.status {
                PointStatus::ZeroReference => "reference, not in the metrics".to_owned(),
                PointStatus::HoleInPrint => "not printed".to_owned(),
                _ => String::new(),
            },
            predicted: comparisons.iter().map(|c| cell(c, i, unit)).collect(),
        })
        .collect();
    Some(PointTable {
        title: measurement_title(first),
        basis: first.basis.label(),
        source: first.measured_source.clone(),
        conditions: first.conditions.iter().map(|c| c.title.clone()).collect(),
        components: first.quantity.components.join(", "),
        forms: comparisons.iter().map(|c| c.title.clone()).collect(),
        place: match first.against {
            Against::Pressure => "Gauge pressure",
            Against::Time => "Time",
            Against::ArcLength => "Share of arc length",
        },
        hidden: first.points.len() - shown,
        points,
    })
}

fn cell(c: &Comparison, i: usize, unit: Unit) -> Cell {
    let point = c.points.get(i);
    let residual = point.and_then(|p| p.residual).map_or(String::new(), |r| {
        let text = format::fixed(unit.from_si(r), 2);
        if r > 0.0 { format!("+{text}") } else { text }
    });
    let value = point.and_then(|p| p.predicted.as_deref().map(|v| (v, p.predicted_half_width.as_slice())));
    let none = if c.kind == "none" { DASH } else { "no prediction" };
    // A computed value may have a width, from printed conditions or an imported uncertainty, and still be no printed number.
    let value = value.map_or(none.to_owned(), |(v, half)| values(v, half, c.kind == "published", unit));
    let note = point.filter(|p| p.status == PointStatus::InFit).map_or("", |_| "in the fit");
    Cell { value, residual, note }
}

/// Decimals of a printed number from half a unit of its last digit: 0.005 is two.
pub(super) fn printed_decimals(half_width: f64) -> usize {
    if half_width <= 0.0 {
        return 0;
    }
    // Within ±20 for any number a table can hold; negative where the last digit is a ten or more.
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
    let decimals = (-(2.0 * half_width).log10()).round().clamp(0.0, 12.0) as usize;
    decimals
}

pub(super) fn metric_table(comparisons: &[&Comparison]) -> Option<MetricTable> {
    let first = comparisons.first()?;
    let unit = first.quantity.unit();
    // A metric that no form has a number for (R² of one point, say) is left out.
    let has_number = |m: &Metric| {
        comparisons.iter().filter_map(|c| c.metric(*m)).any(|r| r.value.is_some() || r.over_predicted_points.is_some())
    };
    let metrics: Vec<Metric> = Metric::ALL.into_iter().filter(has_number).collect();
    let rows = comparisons
        .iter()
        .map(|c| MetricRow {
            title: c.title.clone(),
            n: counted(c),
            cells: metrics.iter().map(|m| metric_view(c, *m, unit)).collect(),
        })
        .collect();
    Some(MetricTable { title: measurement_title(first), names: metrics.iter().map(|m| m.title()).collect(), rows })
}

fn metric_view(c: &Comparison, metric: Metric, unit: Unit) -> MetricCell {
    let value = metric_cell(c, metric, unit);
    let ends = c.metric(metric).and_then(|r| r.lower.zip(r.upper));
    let interval = ends.filter(|(lower, upper)| upper > lower).map_or(String::new(), |(lower, upper)| {
        format!("{} to {}", metric_text(metric, lower, unit), metric_text(metric, upper, unit))
    });
    MetricCell { value, interval }
}

/// The values of the conditions, each in its unit.
fn conditions(c: &Comparison, values_si: &[f64]) -> Vec<String> {
    let text = |(condition, value): (&crate::results::ConditionRecord, &f64)| {
        Unit::parse(&condition.display_unit)
            .map_or_else(|| format::short(*value), |unit| format::with_unit(&format::short(unit.from_si(*value)), unit))
    };
    c.conditions.iter().zip(values_si).map(text).collect()
}

/// A value, or the components of a position: a printed one with the digits it was printed with, any other with the half width
/// of its interval, in the same unit.
pub fn values(values_si: &[f64], half_widths: &[f64], printed: bool, unit: Unit) -> String {
    let number = |(value, half): (&f64, &f64)| {
        let (value, half) = (unit.from_si(*value), unit.from_si(*half));
        if half > 0.0 && printed {
            return format::fixed(value, printed_decimals(half));
        }
        let text = format::fixed(value, format::error_decimals(unit));
        if half > 0.0 { format!("{text} ± {}", format::significant(half, 2)) } else { text }
    };
    let widths = half_widths.iter().chain(std::iter::repeat(&0.0));
    let numbers: Vec<String> = values_si.iter().zip(widths).map(number).collect();
    format::with_unit(&numbers.join(", "), unit)
}
