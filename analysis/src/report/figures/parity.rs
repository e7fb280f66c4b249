//! Predicted against measured, for every quantity of one unit.

use pneuval_ingest::units::Unit;

use super::readings::{self, Said};
use super::{Group, spread, unit_name};
use crate::format;
use crate::report::chart::{Chart, Ink, Key, Layer};
use crate::report::scene::Shape;
use crate::results::PointStatus;

/// Predicted against measured, for every quantity of one unit.
pub(super) fn parity(groups: &[&Group], unit: Unit) -> (Chart, String) {
    let measured: Vec<f64> = groups.iter().flat_map(|g| g.measured(unit)).map(|(_, v)| v).collect();
    // Several quantities start at their common zero; one is shown around its own values.
    let zero = (groups.len() > 1).then_some(0.0);
    let range = spread(measured.iter().copied().chain(zero), if measured.len() > 1 { 0.12 } else { 0.5 });
    let mut layers = vec![Layer::Reference(vec![(range.start, range.start), (range.end, range.end)])];
    let mut legend = vec![Key::line("predicted = measured", Ink::Measured)];
    // One quantity: a look per form, as in its other figures. Several: a look per kind of form, or the legend would be longer
    // than the figure.
    let mut looks: Vec<&str> = Vec::new();
    let mut front = Vec::new();
    let mut said: Vec<Said> = Vec::new();
    let crowded = groups.iter().any(|g| g.is_crowded());
    for comparison in groups.iter().flat_map(|g| &g.comparisons) {
        let name = if groups.len() == 1 { comparison.title.as_str() } else { comparison.kind.as_str() };
        let i = looks.iter().position(|look| *look == name).unwrap_or_else(|| {
            looks.push(name);
            looks.len() - 1
        });
        let points: Vec<(f64, f64, String)> = comparison
            .points
            .iter()
            .filter(|p| p.status == PointStatus::Used)
            .filter_map(|p| p.measured_scalar().zip(p.predicted_scalar()))
            .map(|(m, p)| (unit.from_si(m), unit.from_si(p), format::quantity(p, unit, 1)))
            .collect();
        let ink = Ink::Form(i);
        let shape = if crowded { Shape::Dot } else { Shape::of_form(i) };
        let key = Key::mark(name, ink, shape);
        if !points.is_empty() && !legend.contains(&key) {
            legend.push(key);
        }
        said.extend(comparison.points.iter().filter(|p| p.status == PointStatus::Used).filter_map(|p| {
            let (measured, predicted) = p.measured_scalar().zip(p.predicted_scalar())?;
            let at = (unit.from_si(measured), unit.from_si(predicted));
            let lines = vec![
                format!("{}, {}", comparison.quantity.title, readings::heading(comparison, p)),
                readings::measured(comparison, p, unit),
                readings::predicted(comparison, p, unit),
            ];
            // What lies beyond the axis is an arrow with its value.
            range.contains(&at.1).then_some(Said { at, lines, weight: p.residual.map_or(0.0, f64::abs) })
        }));
        let target = if comparison.kind == "published" { &mut front } else { &mut layers };
        target.push(Layer::Marks { points, ink, shape });
    }
    layers.append(&mut front);
    let titles: Vec<&str> =
        groups.iter().filter_map(|g| g.comparisons.first()).map(|c| c.quantity.title.as_str()).collect();
    let chart = Chart {
        title: "Predicted against measured".to_owned(),
        x_title: format!("Measured / {}", unit_name(unit)),
        y_title: format!("Predicted / {}", unit_name(unit)),
        x: range.clone(),
        y: range,
        layers,
        legend,
        readings: readings::places(said),
        ..Chart::default()
    };
    let caption = format!("{}: a perfect prediction lies on the line.", titles.join(", "));
    (chart, caption)
}
