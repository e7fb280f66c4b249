//! `series.parquet`: the curves behind the figures, so that they can be drawn again.

use pneuval_ingest::store::{Columns, Series};

use crate::prediction::CurvePoint;

/// The curve of one comparison.
#[derive(Debug, Clone, PartialEq)]
pub struct Curve {
    /// The comparison's id.
    pub comparison: String,
    /// Its points, by rising pressure.
    pub points: Vec<CurvePoint>,
}

const COLUMNS: [&str; 3] = ["comparison", "pressure_share", "predicted_si"];

/// Curves as columns: comparison id, share of full pressure, predicted value in SI units.
pub fn to_columns(curves: &[Curve]) -> Columns {
    let rows = || curves.iter().flat_map(|c| c.points.iter().map(move |p| (&c.comparison, p)));
    vec![
        (COLUMNS[0].to_owned(), Series::Text(rows().map(|(id, _)| id.clone()).collect())),
        (COLUMNS[1].to_owned(), Series::Number(rows().map(|(_, p)| Some(p.share)).collect())),
        (COLUMNS[2].to_owned(), Series::Number(rows().map(|(_, p)| Some(p.value)).collect())),
    ]
}

/// The curves of stored columns; `None` if they are not what [`to_columns`] writes.
pub fn from_columns(columns: &Columns) -> Option<Vec<Curve>> {
    let [(a, Series::Text(ids)), (b, Series::Number(shares)), (c, Series::Number(values))] = columns.as_slice() else {
        return None;
    };
    if [a, b, c] != COLUMNS {
        return None;
    }
    let mut curves: Vec<Curve> = Vec::new();
    for ((id, share), value) in ids.iter().zip(shares).zip(values) {
        let point = CurvePoint { share: (*share)?, value: (*value)? };
        match curves.last_mut() {
            Some(curve) if curve.comparison == *id => curve.points.push(point),
            _ => curves.push(Curve { comparison: id.clone(), points: vec![point] }),
        }
    }
    Some(curves)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn curves_come_back_as_they_were() {
        let point = |share, value| CurvePoint { share, value };
        let curves = vec![
            Curve { comparison: "a/q/f".to_owned(), points: vec![point(0.0, 1.0), point(1.0, 2.0)] },
            Curve { comparison: "a/q/g".to_owned(), points: vec![point(0.5, -3.0)] },
        ];
        assert_eq!(from_columns(&to_columns(&curves)), Some(curves));
        assert_eq!(from_columns(&vec![]), None);
    }
}
