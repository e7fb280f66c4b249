//! `series.parquet`: the curves behind the figures, so that they can be drawn again.

use pneuval_ingest::store::{Columns, Series};

/// The curve of one comparison.
#[derive(Debug, Clone, PartialEq)]
pub struct Curve {
    /// The comparison's id.
    pub comparison: String,
    /// One trace per set of conditions that its points have, in the order of their first point. Of a movement the first is the
    /// prediction, the others the runs as measured, thinned to what a figure shows.
    pub traces: Vec<Trace>,
}

/// A line over pressure; of a movement, over time or the share of its arc length.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Trace {
    /// Its points, by rising pressure, or as they follow each other.
    pub points: Vec<CurvePoint>,
}

/// A point of a drawn curve.
#[derive(Debug, Clone, PartialEq)]
pub struct CurvePoint {
    /// Share of the full pressure of every chamber, 0 to 1; of a movement, time in s or the share of its arc length.
    pub share: f64,
    /// The quantity per component, SI units.
    pub values: Vec<f64>,
}

const COLUMNS: [&str; 5] = ["comparison", "trace", "component", "at", "value_si"];

/// Curves as columns: comparison id, trace and component (from 0), share of full pressure (of a movement time in s, or the share of
/// its arc length), value in SI units.
pub fn to_columns(curves: &[Curve]) -> Columns {
    let mut ids = Vec::new();
    let mut numbers: [Vec<Option<f64>>; 4] = Default::default();
    for curve in curves {
        for (t, trace) in curve.traces.iter().enumerate() {
            for point in &trace.points {
                for (c, value) in point.values.iter().enumerate() {
                    ids.push(curve.comparison.clone());
                    for (column, number) in numbers.iter_mut().zip([t as f64, c as f64, point.share, *value]) {
                        column.push(Some(number));
                    }
                }
            }
        }
    }
    let names = COLUMNS.iter().map(|name| (*name).to_owned());
    names.zip(std::iter::once(Series::Text(ids)).chain(numbers.map(Series::Number))).collect()
}

/// The curves of stored columns; `None` if they are not what [`to_columns`] writes.
pub fn from_columns(columns: &Columns) -> Option<Vec<Curve>> {
    if !columns.iter().map(|(name, _)| name.as_str()).eq(COLUMNS) {
        return None;
    }
    let [(_, Series::Text(ids)), numbers @ ..] = columns.as_slice() else { return None };
    let number = |column: usize, row: usize| match &numbers.get(column)?.1 {
        Series::Number(cells) => *cells.get(row)?,
        Series::Text(_) => None,
    };
    let mut curves: Vec<Curve> = Vec::new();
    for (row, id) in ids.iter().enumerate() {
        let (trace, component) = (number(0, row)?, number(1, row)?);
        let (share, value) = (number(2, row)?, number(3, row)?);
        if curves.last().is_none_or(|curve| curve.comparison != *id) {
            curves.push(Curve { comparison: id.clone(), traces: vec![] });
        }
        let traces = &mut curves.last_mut()?.traces;
        // Traces without a point leave no row.
        while (traces.len() as f64) <= trace {
            if traces.len() > ids.len() {
                return None;
            }
            traces.push(Trace::default());
        }
        let points = &mut traces.last_mut()?.points;
        if component == 0.0 {
            points.push(CurvePoint { share, values: vec![value] });
        } else {
            points.last_mut()?.values.push(value);
        }
    }
    Some(curves)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn curves_come_back_as_they_were() {
        let point = |share, values: &[f64]| CurvePoint { share, values: values.to_vec() };
        let trace = |points: Vec<CurvePoint>| Trace { points };
        let curves = vec![
            Curve {
                comparison: "a/q/f".to_owned(),
                traces: vec![
                    trace(vec![point(0.0, &[1.0]), point(1.0, &[2.0])]),
                    trace(vec![]),
                    trace(vec![point(0.5, &[7.0])]),
                ],
            },
            Curve { comparison: "a/q/g".to_owned(), traces: vec![trace(vec![point(0.5, &[-3.0, 4.0])])] },
        ];
        assert_eq!(from_columns(&to_columns(&curves)), Some(curves));
        assert_eq!(from_columns(&vec![]), None);
    }
}
