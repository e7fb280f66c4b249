//! Questions asked of every model in the catalogue at once: a new entry is in the list or the test fails.

// In a test a panic is how a failure is told; equality of floats is asked where it must be exact.
#![allow(clippy::unwrap_used, clippy::panic, clippy::float_cmp)]

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
    assert!(checked >= 30, "{checked}");
}

#[test]
fn ids_are_unique_and_found() {
    for entry in catalogue::entries() {
        let found = catalogue::find(entry.actuator, entry.quantity, entry.form).unwrap();
        assert!(std::ptr::eq(found, entry), "{} {} {} twice", entry.actuator, entry.quantity, entry.form);
    }
}

#[test]
fn inverse_of_forward_is_the_pressure() {
    let mut worst = 0.0_f64;
    for entry in catalogue::entries() {
        let Model::Single(branch) = model(entry) else { continue };
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

#[test]
fn zero_pressure_is_exactly_the_undeformed_state() {
    for entry in catalogue::entries() {
        let model = model(entry);
        let zero = vec![0.0; entry.chambers.len()];
        match (entry.quantity, entry.form) {
            ("root-angle", "printed") => assert!(model.predict(&zero).is_err()),
            ("outer-diameter", "printed") => assert_eq!(model.predict(&zero), Ok(56e-3)),
            ("outer-diameter", _) => assert_eq!(model.predict(&zero), Ok(30e-3)),
            _ => assert_eq!(model.predict(&zero), Ok(0.0), "{} {}", entry.quantity, entry.form),
        }
    }
}

#[test]
fn chambers_and_branches_agree() {
    for entry in catalogue::entries() {
        assert_eq!(model(entry).branches().len(), entry.chambers.len(), "{} {}", entry.quantity, entry.form);
    }
}

#[test]
fn a_missing_input_is_named() {
    for entry in catalogue::entries() {
        for parameter in entry.parameters {
            let full = entry.stated_inputs();
            let without = entry
                .parameters
                .iter()
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
