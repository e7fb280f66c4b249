//! Questions asked of every model in the catalogue at once: a new entry is in the list or the test fails.

// In a test a panic is how a failure is told; equality of floats is asked where it must be exact.
#![allow(clippy::unwrap_used, clippy::panic, clippy::float_cmp)]

use pneuval_models::ModelError;
use pneuval_models::catalogue::{self, Entry, Inputs, Model};
use pneuval_models::solve::Branch;

fn model(entry: &Entry) -> Model {
    entry.build(&entry.stated_inputs()).unwrap()
}

#[test]
fn every_check_value_holds() {
    let mut checked = 0;
    for entry in catalogue::entries() {
        assert!(!entry.checks.is_empty(), "{} {} has no check value", entry.quantity, entry.form);
        for check in entry.checks {
            let found = (check.compute)().unwrap();
            assert!(
                (found - check.expected).abs() <= check.tolerance,
                "{} {} {}: {}: expected {} ± {} {}, found {found}",
                entry.actuator,
                entry.quantity,
                entry.form,
                check.statement,
                check.expected,
                check.tolerance,
                check.unit
            );
            checked += 1;
        }
    }
    assert!(checked >= 90, "{checked}");
}

#[test]
fn ids_are_unique_and_found() {
    for entry in catalogue::entries() {
        let found = catalogue::find(entry.actuator, entry.quantity, entry.form).unwrap();
        assert!(std::ptr::eq(found, entry), "{} {} {} twice", entry.actuator, entry.quantity, entry.form);
    }
}

#[test]
fn a_form_gives_one_finite_value_per_component() {
    for entry in catalogue::entries() {
        let model = model(entry);
        for pressure in [0.0, 1e3, 5e3] {
            match model.predict(&vec![pressure; entry.chambers.len()]) {
                Ok(values) => {
                    assert_eq!(values.len(), entry.components.len().max(1), "{} {}", entry.quantity, entry.form);
                    assert!(values.iter().all(|v| v.is_finite()));
                }
                Err(error) => assert!(
                    matches!(
                        error,
                        ModelError::BelowStart { .. } | ModelError::BeyondLimit { .. } | ModelError::NotThisUnit { .. }
                    ),
                    "{} {} {}: {error}",
                    entry.actuator,
                    entry.quantity,
                    entry.form
                ),
            }
        }
    }
}

#[test]
fn a_scalar_is_asked_of_a_scalar_only() {
    for entry in catalogue::entries() {
        let (one, all) = (model(entry), model(entry));
        let zero = vec![0.0; entry.chambers.len()];
        match one.predict_scalar(&zero) {
            Ok(value) => assert_eq!(all.predict(&zero), Ok(vec![value])),
            Err(ModelError::NotScalar { components }) => assert_eq!(components, entry.components.len()),
            Err(error) => assert_eq!(all.predict(&zero), Err(error)),
        }
    }
}

#[test]
fn wrong_pressures_are_refused_by_every_form() {
    for entry in catalogue::entries() {
        let model = model(entry);
        let n = entry.chambers.len();
        assert_eq!(
            model.predict(&vec![1e3; n + 1]),
            Err(ModelError::ChamberCount { expected: n, found: n + 1 }),
            "{} {}",
            entry.quantity,
            entry.form
        );
        assert_eq!(model.predict(&[]), Err(ModelError::ChamberCount { expected: n, found: 0 }));
        for wrong in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            let mut pressures = vec![1e3; n];
            pressures[n - 1] = wrong;
            let said = model.predict(&pressures);
            assert!(
                matches!(said, Err(ModelError::OutOfDomain { symbol: "gauge pressure", .. })),
                "{} {} at {wrong}: {said:?}",
                entry.quantity,
                entry.form
            );
        }
    }
}

#[test]
fn a_result_that_is_no_number_is_an_error() {
    let overflowing = Model::explicit(|p| Ok(vec![0.0, p * 1e300]));
    assert_eq!(overflowing.predict(&[1e300]), Err(ModelError::NotFinite { component: 1, value: f64::INFINITY }));
    for entry in catalogue::entries() {
        if let Ok(values) = model(entry).predict(&vec![f64::MAX; entry.chambers.len()]) {
            assert!(values.iter().all(|v| v.is_finite()), "{} {}", entry.quantity, entry.form);
        }
    }
}

#[test]
fn inverse_of_forward_is_the_pressure() {
    let mut worst = 0.0_f64;
    for entry in catalogue::entries() {
        let model = model(entry);
        let Model::Single(branch) = model else {
            assert!(
                matches!(model.invert(0.1), Err(ModelError::NotInvertible { .. })),
                "{} {}",
                entry.quantity,
                entry.form
            );
            continue;
        };
        for pressure in pressures(&branch) {
            let quantity = branch.quantity(pressure).unwrap();
            let back = branch.pressure_gauge_pa(quantity).unwrap();
            // Near rest a diameter of 30 mm plus a few nanometres has no digits left for the pressure: there the range counts.
            let scale = if pressure > 1e-3 * branch.limit_gauge_pa() { pressure } else { branch.limit_gauge_pa() };
            let error = (back - pressure).abs() / scale;
            worst = worst.max(error);
            assert!(error <= 1e-10, "{} {}: {pressure} -> {quantity} -> {back}", entry.quantity, entry.form);
        }
    }
    // Not one comparison short of the whole catalogue slipped through.
    assert!(worst > 0.0);
}

/// 200 pressures from the start of the branch to its end, dense near the start.
fn pressures(branch: &Branch) -> Vec<f64> {
    let limit = branch.limit_gauge_pa();
    if limit <= 0.0 {
        return vec![];
    }
    let reach_at_zero = branch.pressure_gauge_pa(branch.reach().0).unwrap();
    (1..=200).map(|i| reach_at_zero + (limit - reach_at_zero) * (f64::from(i) / 200.0).powi(3)).collect()
}

/// What a form says at zero pressure: exactly this, or nothing that a test of all forms could know.
fn undeformed(entry: &Entry) -> Option<Vec<f64>> {
    Some(match (entry.actuator, entry.quantity, entry.form) {
        // No solution; another unit; a held or measured condition decides.
        ("dual-chamber-finger", "root-angle", "printed")
        | ("fruit-finger", "tip-force", _)
        | ("wave-finger", "tip-position", "constant-curvature")
        | ("pdms-wall", "contact-force", _)
        | ("constant-curvature", _, "from-angle" | "from-polar-angle") => return None,
        (_, "outer-diameter", "printed") => vec![56e-3],
        (_, "outer-diameter", _) => vec![30e-3],
        ("wave-finger", "tip-position", _) => vec![0.0, 0.115],
        ("constant-curvature", "tip-position", _) => vec![0.0, 0.1],
        ("constant-curvature", "tip-displacement", _) => vec![0.0, 0.0],
        _ => vec![0.0],
    })
}

#[test]
fn zero_pressure_is_exactly_the_undeformed_state() {
    for entry in catalogue::entries() {
        let zero = vec![0.0; entry.chambers.len()];
        let said = model(entry).predict(&zero);
        if let Some(expected) = undeformed(entry) {
            assert_eq!(said, Ok(expected), "{} {} {}", entry.actuator, entry.quantity, entry.form);
        }
    }
}

#[test]
fn an_unbent_condition_at_zero_pressure_is_exactly_the_undeformed_state() {
    for (actuator, quantity, form, condition, expected) in [
        ("fruit-finger", "tip-force", "consistent-proportional", "held_angle", vec![0.0]),
        ("wave-finger", "tip-position", "constant-curvature", "bending_angle", vec![0.0, 0.115]),
        ("constant-curvature", "tip-position", "from-angle", "bending_angle", vec![0.0, 0.1]),
        ("constant-curvature", "tip-displacement", "from-angle", "bending_angle", vec![0.0, 0.0]),
        ("constant-curvature", "tip-displacement", "from-polar-angle", "polar_angle", vec![0.0, 0.0]),
    ] {
        let entry = catalogue::find(actuator, quantity, form).unwrap();
        let mut inputs = entry.stated_inputs();
        inputs.set(condition, 0.0);
        assert_eq!(entry.build(&inputs).unwrap().predict(&[0.0]), Ok(expected), "{actuator} {quantity} {form}");
    }
}

#[test]
fn chambers_and_branches_agree() {
    for entry in catalogue::entries() {
        let model = model(entry);
        assert_eq!(model.chambers(), entry.chambers.len(), "{} {}", entry.quantity, entry.form);
        match model {
            Model::Explicit(_) => assert!(model.branches().is_empty()),
            Model::Single(_) | Model::Sum(_) => assert_eq!(model.branches().len(), entry.chambers.len()),
        }
    }
}

#[test]
fn a_quantity_has_the_same_components_unit_and_chambers_in_every_form() {
    for a in catalogue::entries() {
        for b in catalogue::entries().filter(|b| a.actuator == b.actuator && a.quantity == b.quantity) {
            assert_eq!(
                (a.components, a.quantity_si_unit, a.chambers),
                (b.components, b.quantity_si_unit, b.chambers),
                "{} {}",
                a.actuator,
                a.quantity
            );
        }
    }
}

#[test]
fn every_unevaluable_equation_says_why_and_where() {
    let listed = catalogue::unevaluable();
    assert!(listed.iter().any(|u| u.actuator == "wave-finger" && u.equations.contains("Eq. 11 to 21")));
    for unevaluable in listed {
        assert!(catalogue::entries().any(|e| e.actuator == unevaluable.actuator));
        assert!(!unevaluable.why.is_empty() && !unevaluable.source.is_empty());
    }
}

#[test]
fn a_missing_input_is_named() {
    for entry in catalogue::entries() {
        for parameter in entry.inputs() {
            let full = entry.stated_inputs();
            let without = entry
                .inputs()
                .filter(|p| p.name != parameter.name)
                .map(|p| (p.name, full.get(p.name).unwrap()))
                .collect::<Inputs>();
            let message = entry.build(&without).err().map(|e| e.to_string()).unwrap_or_default();
            assert!(
                message.contains(parameter.name),
                "{} {} {}: {message}",
                entry.quantity,
                entry.form,
                parameter.name
            );
        }
    }
}

#[test]
fn an_input_that_is_no_number_is_refused() {
    for entry in catalogue::entries() {
        for parameter in entry.inputs() {
            for wrong in [f64::NAN, f64::INFINITY] {
                let mut inputs = entry.stated_inputs();
                inputs.set(parameter.name, wrong);
                assert!(
                    matches!(entry.build(&inputs).err(), Some(ModelError::OutOfDomain { .. })),
                    "{} {} {} = {wrong}",
                    entry.quantity,
                    entry.form,
                    parameter.name
                );
            }
        }
    }
}

#[test]
fn an_input_is_a_parameter_or_a_condition_and_has_a_unit() {
    for entry in catalogue::entries() {
        for condition in entry.conditions {
            assert!(!entry.parameters.iter().any(|p| p.name == condition.name), "{} {}", entry.form, condition.name);
        }
        assert!(entry.inputs().all(|p| !p.si_unit.is_empty() && !p.meaning.is_empty()));
    }
}
