//! A prediction moved onto the measurement: shifted, or turned and shifted by least squares (Kabsch, 1976; Umeyama, 1991, without scale).
//!
//! With centred predicted points p and measured points m the rotation is `R = V diag(1, .., d) Uᵀ` of the singular values
//! `Σ p mᵀ = U S Vᵀ`, d = ±1 so that det R = 1; the translation takes the turned centre to the measured one. One rotation and one
//! translation serve all runs of a comparison: frames do not move between them.

use nalgebra::{Matrix3, Rotation3, SymmetricEigen, UnitQuaternion, Vector3};

use pneuval_ingest::manifest::Align;
use pneuval_ingest::number::Printed;

use crate::prediction::{Predicted, Prediction};
use crate::response::{Response, ResponsePoint};
use crate::results::{AlignmentKind, MovementAlignmentRecord};
use crate::uncertainty::errors::{Errors, Factor};

/// A path is a straight line where its points leave the line by less than this share of their spread along it.
const STRAIGHT_SHARE: f64 = 1e-3;

/// A difference below this share of what it is between is left by rounding.
const ROUNDING_SHARE: f64 = 1e-9;

/// A predicted and a measured point.
type Points = (Vector3<f64>, Vector3<f64>);

/// Rotation matrix and translation.
struct Transform {
    rotation: Matrix3<f64>,
    translation: Vector3<f64>,
}

impl Transform {
    fn apply(&self, values: &[f64]) -> Vec<f64> {
        let moved = self.rotation * vector(values) + self.translation;
        moved.iter().take(values.len()).copied().collect()
    }

    /// What half widths become: the box around the turned box.
    fn half_widths(&self, half_widths: &[f64]) -> Vec<f64> {
        let turned = self.rotation.abs() * vector(half_widths);
        turned.iter().take(half_widths.len()).copied().collect()
    }
}

/// Components as a vector; what is not there is zero.
fn vector(values: &[f64]) -> Vector3<f64> {
    Vector3::from_fn(|i, _| values.get(i).copied().unwrap_or(0.0))
}

/// Moves a prediction onto the measurement, its drawn curves and what moves it too. Where the points do not say how, nothing is
/// predicted, and why.
pub(crate) fn align(
    align: Align,
    response: &Response,
    prediction: &mut Prediction,
    errors: Option<&mut Errors>,
) -> Option<MovementAlignmentRecord> {
    if align == Align::None {
        return None;
    }
    let pairs = pairs(response, &prediction.at);
    let width = response.quantity.width();
    let transform = match transform(align, response, &prediction.at) {
        Ok(transform) => transform,
        Err(why) => {
            let why = format!("the prediction cannot be aligned to the measurement: {why}");
            for at in &mut prediction.at {
                if matches!(at, Predicted::Value(_) | Predicted::InFit(_)) {
                    *at = Predicted::Failed(why.clone());
                }
            }
            prediction.traces.clear();
            return None;
        }
    };
    let rmse = |of: &dyn Fn(&Vector3<f64>) -> Vector3<f64>| {
        let sum: f64 = pairs.iter().map(|(p, m)| (of(p) - m).norm_squared()).sum();
        (sum / pairs.len() as f64).sqrt()
    };
    let (rotation_axis, rotation_deg) = turned(&transform.rotation, width);
    let record = MovementAlignmentRecord {
        kind: if align == Align::Origin { AlignmentKind::Origin } else { AlignmentKind::Rigid },
        n: pairs.len(),
        rotation_axis,
        rotation_deg,
        translation_si: transform.translation.iter().take(width).copied().collect(),
        rmse_before_si: rmse(&|p| *p),
        rmse_after_si: rmse(&|p| transform.rotation * p + transform.translation),
    };
    // What moves the points moves where they are laid, too: an offset of the instrument, which all of them share, leaves nothing.
    for factor in errors.into_iter().flat_map(|errors| &mut errors.factors) {
        follow(factor, (align, &transform), response, &prediction.at);
    }
    for at in &mut prediction.at {
        if let Predicted::Value(values) | Predicted::InFit(values) = at {
            let moved = transform.apply(&values.iter().map(|v| v.si).collect::<Vec<_>>());
            let widths = transform.half_widths(&values.iter().map(|v| v.half_width_si).collect::<Vec<_>>());
            for (value, (si, half_width_si)) in values.iter_mut().zip(moved.into_iter().zip(widths)) {
                (value.si, value.half_width_si) = (si, half_width_si);
            }
        }
    }
    // Of a movement the first curve is the prediction, and the others are what was measured.
    let predicted = if response.movement.is_some() { 1 } else { prediction.traces.len() };
    for point in prediction.traces.iter_mut().take(predicted).flat_map(|trace| &mut trace.points) {
        point.values = transform.apply(&point.values);
    }
    Some(record)
}

fn transform(align: Align, response: &Response, at: &[Predicted]) -> Result<Transform, String> {
    match align {
        Align::None => Ok(Transform { rotation: Matrix3::identity(), translation: Vector3::zeros() }),
        Align::Origin => origin(response, at),
        Align::Rigid => rigid(&pairs(response, at), response.quantity.width()),
    }
}

/// What a direction does to the aligned prediction: aligned again with both sides moved along it.
fn follow(factor: &mut Factor, (align, known): (Align, &Transform), response: &Response, at: &[Predicted]) {
    let width = response.quantity.width();
    let (mut moved_response, mut moved_at) = (response.clone(), at.to_vec());
    let add = |values: &mut Vec<Printed>, by: &[f64]| values.iter_mut().zip(by).for_each(|(v, by)| v.si += by);
    for ((point, at), (measured, predicted)) in moved_response
        .points
        .iter_mut()
        .zip(&mut moved_at)
        .zip(factor.measured.chunks(width).zip(factor.predicted.chunks(width)))
    {
        if let Some(values) = &mut point.measured {
            add(values, measured);
        }
        if let Predicted::Value(values) | Predicted::InFit(values) = at {
            add(values, predicted);
        }
    }
    let size = factor.measured.iter().chain(&factor.predicted).fold(0.0_f64, |most, by| most.max(by.abs()));
    // Where the moved points do not say how, they lie as the others do.
    let found = transform(align, &moved_response, &moved_at);
    let again = found.as_ref().unwrap_or(known);
    for ((before, after), by) in at.iter().zip(&moved_at).zip(factor.predicted.chunks_mut(width)) {
        let (Predicted::Value(before) | Predicted::InFit(before), Predicted::Value(after) | Predicted::InFit(after)) =
            (before, after)
        else {
            continue;
        };
        let laid = |by: &Transform, values: &[Printed]| by.apply(&values.iter().map(|v| v.si).collect::<Vec<_>>());
        let (before, after) = (laid(known, before), laid(again, after));
        by.iter_mut().zip(after.iter().zip(before)).for_each(|(by, (after, before))| *by = after - before);
    }
    // What rounding leaves of nothing is nothing.
    for (predicted, measured) in factor.predicted.iter_mut().zip(&factor.measured) {
        if (*predicted - measured).abs() <= ROUNDING_SHARE * size {
            *predicted = *measured;
        }
    }
}

/// Predicted and measured where both are numbers; without zero references, and cycles that are not compared.
fn pairs(response: &Response, at: &[Predicted]) -> Vec<Points> {
    let is_asked = |point: &ResponsePoint| !point.is_apart && !response.is_zero_reference(point);
    let asked = response.points.iter().zip(at).filter(|(point, _)| is_asked(point));
    asked.filter_map(|(point, at)| pair(point.measured.as_ref()?, at)).collect()
}

fn pair(measured: &[Printed], at: &Predicted) -> Option<Points> {
    let Predicted::Value(predicted) = at else { return None };
    let all = |values: &[Printed]| values.iter().map(|v| v.si).collect::<Vec<_>>();
    let (p, m) = (vector(&all(predicted)), vector(&all(measured)));
    p.iter().chain(m.iter()).all(|v| v.is_finite()).then_some((p, m))
}

/// The shift by which the first points of the runs meet, on average.
fn origin(response: &Response, at: &[Predicted]) -> Result<Transform, String> {
    let mut runs: Vec<&[String]> = Vec::new();
    let mut shifts: Vec<Vector3<f64>> = Vec::new();
    for (point, at) in response.points.iter().zip(at).filter(|(point, _)| !point.is_apart) {
        let Some((p, m)) = point.measured.as_ref().and_then(|measured| pair(measured, at)) else { continue };
        if !runs.contains(&point.runs.as_slice()) {
            runs.push(&point.runs);
            shifts.push(m - p);
        }
        // Points of several runs at pressures are means over the same runs: the first counts.
        if response.movement.is_none() {
            break;
        }
    }
    if shifts.is_empty() {
        return Err("no point has both a measured and a predicted value".to_owned());
    }
    let translation = shifts.iter().sum::<Vector3<f64>>() / shifts.len() as f64;
    Ok(Transform { rotation: Matrix3::identity(), translation })
}

/// The rotation and translation of least squares.
fn rigid(pairs: &[Points], width: usize) -> Result<Transform, String> {
    if pairs.len() < 3 {
        return Err(format!("the rotation is not determined by {} points, it needs at least 3", pairs.len()));
    }
    let n = pairs.len() as f64;
    let mean = |of: fn(&Points) -> Vector3<f64>| pairs.iter().map(of).sum::<Vector3<f64>>() / n;
    let (centre_p, centre_m) = (mean(|pair| pair.0), mean(|pair| pair.1));
    let spread = |of: fn(&Points) -> Vector3<f64>, centre: Vector3<f64>| {
        let sum: Matrix3<f64> = pairs.iter().map(|pair| (of(pair) - centre) * (of(pair) - centre).transpose()).sum();
        let mut values: Vec<f64> = SymmetricEigen::new(sum).eigenvalues.iter().map(|v| v.max(0.0).sqrt()).collect();
        values.sort_by(|a, b| b.total_cmp(a));
        (values[0], values[1])
    };
    let reach = pairs.iter().map(|(p, m)| p.norm().max(m.norm())).fold(0.0, f64::max);
    for (name, (long, across)) in
        [("predicted", spread(|pair| pair.0, centre_p)), ("measured", spread(|pair| pair.1, centre_m))]
    {
        // In the plane a straight line says how it is turned; in space it does not say how about itself.
        let what = match width {
            _ if !(long.is_finite() && long > ROUNDING_SHARE * reach) => "are one point",
            2 => continue,
            _ if across < STRAIGHT_SHARE * long => "lie on a straight line",
            _ => continue,
        };
        return Err(format!("the rotation is not determined: the {name} points {what}"));
    }
    let cross: Matrix3<f64> = pairs.iter().map(|(p, m)| (p - centre_p) * (m - centre_m).transpose()).sum();
    let rotation = if width == 2 { in_plane(&cross)? } else { in_space(cross)? };
    Ok(Transform { rotation, translation: centre_m - rotation * centre_p })
}

/// The rotation in the plane of the first two components: the mirrored one is never among them.
fn in_plane(cross: &Matrix3<f64>) -> Result<Matrix3<f64>, String> {
    let (sine, cosine) = (cross[(0, 1)] - cross[(1, 0)], cross[(0, 0)] + cross[(1, 1)]);
    let length = sine.hypot(cosine);
    if length <= f64::EPSILON * cross.norm() {
        return Err("the rotation is not determined: every one is as good".to_owned());
    }
    let (s, c) = (sine / length, cosine / length);
    Ok(Matrix3::new(c, -s, 0.0, s, c, 0.0, 0.0, 0.0, 1.0))
}

fn in_space(cross: Matrix3<f64>) -> Result<Matrix3<f64>, String> {
    let svd = cross.svd(true, true);
    let failed = || "the rotation is not determined: the singular values cannot be found".to_owned();
    let (u, v_t) = (svd.u.ok_or_else(failed)?, svd.v_t.ok_or_else(failed)?);
    let mut v = v_t.transpose();
    let mut values: Vec<(usize, f64)> = svd.singular_values.iter().copied().enumerate().collect();
    values.sort_by(|a, b| b.1.total_cmp(&a.1));
    let (smallest, least) = values[2];
    let sign = if (v * u.transpose()).determinant() < 0.0 { -1.0 } else { 1.0 };
    if values[1].1 + sign * least <= f64::EPSILON * values[0].1 {
        return Err("the rotation is not determined: several are as good".to_owned());
    }
    for row in 0..3 {
        v[(row, smallest)] *= sign;
    }
    Ok(v * u.transpose())
}

/// A rotation as axis and angle in degrees.
fn turned(rotation: &Matrix3<f64>, width: usize) -> (Option<Vec<f64>>, f64) {
    if width < 3 {
        return (None, rotation[(1, 0)].atan2(rotation[(0, 0)]).to_degrees());
    }
    let quaternion = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(*rotation));
    match quaternion.axis_angle() {
        Some((axis, angle)) => (Some(axis.iter().copied().collect()), angle.to_degrees()),
        None => (None, 0.0),
    }
}
