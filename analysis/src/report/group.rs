//! What is shown together: comparisons that share a measurement.

use crate::results::Comparison;

/// Comparisons grouped by the measurement they share: one quantity of one dataset.
pub fn by_measurement<'a>(comparisons: impl Iterator<Item = &'a Comparison>) -> Vec<Vec<&'a Comparison>> {
    let mut groups: Vec<Vec<&Comparison>> = Vec::new();
    for c in comparisons {
        let same =
            |g: &&mut Vec<&Comparison>| g.iter().all(|o| o.dataset == c.dataset && o.quantity.id == c.quantity.id);
        match groups.iter_mut().find(same) {
            Some(group) => group.push(c),
            None => groups.push(vec![c]),
        }
    }
    groups
}

/// The name of what was measured; with its dataset where that is not the actuator's own.
pub fn measurement_title(c: &Comparison) -> String {
    if c.dataset == c.actuator { c.quantity.title.clone() } else { format!("{} ({})", c.quantity.title, c.dataset) }
}
