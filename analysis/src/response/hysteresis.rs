//! The loop between loading and unloading.

use super::way::Branch;
use super::{Response, ResponsePoint};

/// A point of a loop: its index, its pressure in Pa.
type Station = (usize, f64);

/// Weights of values whose sum is the area between unloading and loading, over the pressures that both reach, by the trapezoidal rule
/// (straight lines between points); in Pa. The top of the loading branch begins the unloading one. Also the range of pressures.
///
/// # Errors
/// Why the response has no loop.
pub fn loop_weights(
    response: &Response,
    usable: &dyn Fn(&ResponsePoint) -> bool,
) -> Result<(Vec<Station>, f64), &'static str> {
    if response.movement.is_some() {
        return Err("a movement at equal time or arc length has no loop over the pressure");
    }
    if response.quantity.width() > 1 {
        return Err("a position has no loop area");
    }
    if response.chambers.len() != 1 {
        return Err("a loop is that of one chamber");
    }
    if response.condition_sets(1).is_none() {
        return Err("a loop is that of one setting of the conditions");
    }
    let branch = |which: Branch| -> Vec<Station> {
        let points = response.points.iter().enumerate();
        let here = points.filter(|(_, p)| p.branch == Some(which) && usable(p));
        let mut stations: Vec<Station> = here.map(|(i, p)| (i, p.pressures_gauge_pa[0])).collect();
        stations.sort_by(|a, b| a.1.total_cmp(&b.1));
        stations
    };
    let (up, mut down) = (branch(Branch::Loading), branch(Branch::Unloading));
    if down.is_empty() {
        return Err("the pressure was not taken down again");
    }
    let Some(top) = up.last().copied() else { return Err("the pressure was not raised") };
    if down.last().is_none_or(|last| last.1 < top.1) {
        down.push(top);
    }
    let (low, high) = (up[0].1.max(down[0].1), top.1);
    if down.len() < 3 || up.len() < 2 || low >= high {
        return Err("too few points on the way down for a loop");
    }
    let mut weights = trapezoids(&down, low, high);
    weights.extend(trapezoids(&up, low, high).into_iter().map(|(i, weight)| (i, -weight)));
    Ok((weights, high - low))
}

/// Weights of the values at stations of rising pressure whose sum is the integral from `low` to `high`.
fn trapezoids(stations: &[Station], low: f64, high: f64) -> Vec<(usize, f64)> {
    let mut weights = Vec::new();
    for pair in stations.windows(2) {
        let ((i, a), (j, b)) = (pair[0], pair[1]);
        let (from, to) = (a.max(low), b.min(high));
        if b > a && to > from {
            let span = 2.0 * (b - a);
            weights.push((i, ((b - from).powi(2) - (b - to).powi(2)) / span));
            weights.push((j, ((to - a).powi(2) - (from - a).powi(2)) / span));
        }
    }
    weights
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_triangle_has_the_area_of_a_triangle_whatever_its_ends() {
        let sum = |weights: Vec<(usize, f64)>, y: &[f64]| weights.iter().map(|(i, w)| w * y[*i]).sum::<f64>();
        // y = p over 0, 1, 3: its integral from 0.5 to 2 is 1.875.
        assert!((sum(trapezoids(&[(0, 0.0), (1, 1.0), (2, 3.0)], 0.5, 2.0), &[0.0, 1.0, 3.0]) - 1.875).abs() < 1e-15);
        assert!((sum(trapezoids(&[(0, 0.0), (1, 1.0)], 0.0, 1.0), &[0.0, 1.0]) - 0.5).abs() < 1e-15);
    }
}
