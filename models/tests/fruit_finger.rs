//! fruit-finger: Eq. 12 against its own balance, Eq. 15 against Table 1.

// In a test a panic is how a failure is told; equality of floats is asked where it must be exact.
#![allow(clippy::unwrap_used, clippy::panic, clippy::float_cmp)]

use std::f64::consts::PI;

use pneuval_models::actuators::fruit_finger::{
    AxialStress, Bending, eq_15_as_printed, flex_angle_rad, flex_resistance_ohm, tip_force_n,
};
use pneuval_models::error::BranchEnd;
use pneuval_models::least_squares::levenberg_marquardt;
use pneuval_models::materials::Yeoh;
use pneuval_models::solve::{Branch, Curve};
use pneuval_models::{ModelError, catalogue};

/// Table 1, "Output force at the end of the soft actuator without constraint rings (F/N)": kPa, then 0, 15, ... 90 deg.
const TABLE_1: [(f64, &[f64]); 6] = [
    (10.0, &[0.07]),
    (20.0, &[0.24, 0.15, 0.08]),
    (30.0, &[0.46, 0.36, 0.29, 0.21, 0.11]),
    (40.0, &[0.72, 0.61, 0.53, 0.45, 0.36]),
    (50.0, &[1.08, 0.95, 0.84, 0.73, 0.64, 0.52]),
    (60.0, &[1.36, 1.22, 1.09, 0.95, 0.84, 0.71, 0.55]),
];

/// A force of Table 1.
#[derive(Clone, Copy)]
struct Held {
    pressure_gauge_pa: f64,
    held_angle_rad: f64,
    force_n: f64,
}

fn table_1() -> Vec<Held> {
    let row = |(kilopascal, forces): &(f64, &'static [f64])| {
        let pressure_gauge_pa = kilopascal * 1e3;
        let held = |(i, &force_n): (usize, &f64)| Held {
            pressure_gauge_pa,
            held_angle_rad: (15.0 * i as f64).to_radians(),
            force_n,
        };
        forces.iter().enumerate().map(held).collect::<Vec<_>>()
    };
    TABLE_1.iter().flat_map(row).collect()
}

/// Predicted - measured, by the catalogue's form with the given inputs.
fn residuals(form: &str, inputs: &[(&str, f64)], points: &[Held]) -> Result<Vec<f64>, ModelError> {
    let entry = catalogue::find("fruit-finger", "tip-force", form).unwrap();
    let residual = |point: &Held| {
        let mut all = entry.stated_inputs();
        for (name, value) in inputs {
            all.set(*name, *value);
        }
        all.set("held_angle", point.held_angle_rad);
        Ok(entry.build(&all)?.predict_scalar(&[point.pressure_gauge_pa])? - point.force_n)
    };
    points.iter().map(residual).collect()
}

fn fit(form: &str, names: &[&'static str], start: &[f64], points: &[Held]) -> Vec<(&'static str, f64)> {
    let with = |values: &[f64]| names.iter().copied().zip(values.iter().copied()).collect::<Vec<_>>();
    let fit = levenberg_marquardt(|values| residuals(form, &with(values), points), start).unwrap();
    with(&fit.parameters)
}

/// Every pressure predicted by a fit to the other five.
fn leave_one_pressure_out(form: &str, names: &[&'static str], start: &[f64]) -> Vec<f64> {
    let out = |(kilopascal, _): &(f64, &[f64])| {
        let left_out = |p: &&Held| p.pressure_gauge_pa == kilopascal * 1e3;
        let (test, train): (Vec<Held>, Vec<Held>) = table_1().iter().partition(left_out);
        residuals(form, &fit(form, names, start, &train), &test).unwrap()
    };
    TABLE_1.iter().flat_map(out).collect()
}

fn rmse(residuals: &[f64]) -> f64 {
    (residuals.iter().map(|r| r * r).sum::<f64>() / residuals.len() as f64).sqrt()
}

fn largest(residuals: &[f64]) -> f64 {
    residuals.iter().fold(0.0, |m, r| r.abs().max(m))
}

const PROPORTIONAL: [&str; 2] = ["rod_stiffness", "free_rod_angle_per_pressure"];
const AFFINE: [&str; 3] =
    ["affine_rod_stiffness", "affine_free_rod_angle_per_pressure", "affine_free_rod_angle_at_zero"];

#[test]
fn table_1_has_27_forces_that_fall_with_angle_and_rise_with_pressure() {
    assert_eq!(table_1().len(), 27);
    for (_, forces) in TABLE_1 {
        assert!(forces.windows(2).all(|f| f[1] < f[0]));
    }
    for rows in TABLE_1.windows(2) {
        assert!(rows[0].1.iter().zip(rows[1].1).all(|(low, high)| low < high));
    }
}

#[test]
fn proportional_law_predicts_every_pressure_left_out() {
    let all = fit("consistent-proportional", &PROPORTIONAL, &[1.0, 1e-5], &table_1());
    // K and a of all 27 forces, θ0 and θ1 being half the rotation.
    assert!((all[0].1 - 2.145).abs() < 5e-4, "{all:?}");
    assert!((all[1].1 - 1.9373e-5).abs() < 5e-10, "{all:?}");
    let out = leave_one_pressure_out("consistent-proportional", &PROPORTIONAL, &[1.0, 1e-5]);
    assert_eq!(out.len(), 27);
    assert!((rmse(&out) - 0.108).abs() < 5e-4, "{}", rmse(&out));
    assert!((largest(&out) - 0.214).abs() < 5e-4, "{}", largest(&out));
}

#[test]
fn affine_law_is_closer_on_the_whole_and_further_off_at_its_worst() {
    let all = fit("consistent-affine", &AFFINE, &[1.0, 1e-5, -0.1], &table_1());
    // K, a and b of all 27 forces: none of them is that of the proportional fit.
    for ((_, found), (stored, tolerance)) in all.iter().zip([(2.150, 5e-4), (2.250e-5, 5e-9), (-0.1534, 5e-5)]) {
        assert!((found - stored).abs() < tolerance, "{all:?}");
    }
    let out = leave_one_pressure_out("consistent-affine", &AFFINE, &[1.0, 1e-5, -0.1]);
    assert!((rmse(&out) - 0.098).abs() < 5e-4, "{}", rmse(&out));
    assert!((largest(&out) - 0.309).abs() < 5e-4, "{}", largest(&out));
}

#[test]
fn one_stiffness_and_a_free_angle_per_pressure_are_a_calibration() {
    let points = table_1();
    let row = |p: &Held| TABLE_1.iter().position(|(k, _)| k * 1e3 == p.pressure_gauge_pa).unwrap();
    let with = |values: &[f64]| {
        let residual = |p: &Held| Ok(tip_force_n(values[0], values[1 + row(p)], p.held_angle_rad)? - p.force_n);
        points.iter().map(residual).collect::<Result<Vec<f64>, ModelError>>()
    };
    let fit = levenberg_marquardt(with, &[1.0, 0.1, 0.2, 0.4, 0.6, 0.8, 1.0]).unwrap();
    let left = with(&fit.parameters).unwrap();
    assert!((rmse(&left) - 0.057).abs() < 5e-4 && (largest(&left) - 0.112).abs() < 5e-4, "{left:?}");
    // Free bending angle at 60 kPa, twice the rod angle: the paper's Figure 15 and abstract say 110 deg with rings.
    let free_at_60 = 2.0 * fit.parameters[6].to_degrees();
    assert!((free_at_60 - 135.0).abs() < 0.5, "{free_at_60}");
}

#[test]
fn whole_rotations_for_rod_angles_do_not_reproduce_table_1() {
    // With θ1 the tip's rotation, sin 2θ1 is nearly zero at 90 deg: no stiffness fits.
    let residual = |k: f64, a: f64, p: &Held| {
        let t = p.held_angle_rad;
        let lever = if t == 0.0 { 0.5 } else { t / (2.0 * t).sin() };
        k * lever * (a * p.pressure_gauge_pa - t) - p.force_n
    };
    let points = table_1();
    let with = |v: &[f64]| Ok(points.iter().map(|p| residual(v[0], v[1], p)).collect::<Vec<f64>>());
    let left = levenberg_marquardt(with, &[1.0, 1e-5]).and_then(|fit| with(&fit.parameters));
    assert!(left.is_err() || left.is_ok_and(|r| rmse(&r) > 0.3));
}

#[test]
fn eq_15_as_printed_is_not_a_force() {
    let entry = catalogue::find("fruit-finger", "tip-force", "printed").unwrap();
    let model = entry.build(&entry.stated_inputs()).unwrap();
    for pressure in [0.0, 10e3, 60e3] {
        let error = model.predict(&[pressure]).unwrap_err();
        assert!(matches!(error, ModelError::NotThisUnit { expected: "N", found: "N mm", .. }));
        assert_eq!(error.to_string(), "Eq. 15 as printed gives N mm, not N: it is not a force");
    }
    // Times L it is the consistent force times L: a moment about the base.
    let (stiffness, length) = (1.3e-3, 0.058);
    let moment = eq_15_as_printed(stiffness, length, 0.9, 0.7).unwrap();
    let force = tip_force_n(4.0 * stiffness / (length * length), 0.9, 0.7).unwrap();
    assert!((moment - force * length).abs() < 1e-15);
}

#[test]
fn force_falls_with_held_angle_and_rises_with_pressure() {
    for kilopascal in [10, 20, 30, 40, 50, 60] {
        let free = 1.9373e-5 * 1e3 * f64::from(kilopascal);
        let force = |degrees: i32| tip_force_n(2.145, free, f64::from(degrees).to_radians()).unwrap();
        for degrees in 0..90 {
            assert!(force(degrees + 1) < force(degrees), "{kilopascal} kPa {degrees} deg");
            assert!(tip_force_n(2.145, free * 1.01, f64::from(degrees).to_radians()).unwrap() > force(degrees));
        }
        // Nothing is left at the free angle itself; beyond it the finger would have to be pulled.
        assert!(tip_force_n(2.145, free, 2.0 * free).unwrap().abs() < 1e-15);
        assert!(tip_force_n(2.145, free, 2.0 * free + 0.1).unwrap() < 0.0);
    }
}

#[test]
fn force_has_an_exact_limit_straight_and_a_refused_one_at_a_right_rod_angle() {
    assert_eq!(tip_force_n(2.0, 0.7, 0.0), Ok(0.7));
    let near = tip_force_n(2.0, 0.7, 1e-9).unwrap();
    assert!((near - (0.7 - 0.5e-9)).abs() < 1e-15, "{near}");
    for held in [PI, -PI, 4.0, f64::NAN] {
        let said = tip_force_n(2.0, 0.7, held);
        assert!(matches!(said, Err(ModelError::OutOfDomain { symbol: "held_angle", .. })), "{held}");
    }
    assert!(tip_force_n(0.0, 0.7, 0.1).is_err() && tip_force_n(2.0, f64::NAN, 0.1).is_err());
}

fn bending(radius_mm: f64, length_mm: f64, stress: AxialStress) -> Bending {
    let law = Yeoh::new(0.11e6, 0.02e6, 0.0).unwrap();
    Bending::new(radius_mm * 1e-3, length_mm * 1e-3, 2.5e-3, law, stress).unwrap()
}

#[test]
fn eq_12_is_the_balance_of_one_cavity() {
    // Eq. 10 and 11 with b and φ, in mm and MPa, on any number of cavities: b cancels.
    for (stress, printed) in [(AxialStress::Printed, true), (AxialStress::Consistent, false)] {
        for (b, phi, r, length) in [(8.0, 0.1, 6.0, 58.2), (3.0, 0.2, 8.0, 40.0), (11.0, 0.7, 4.0, 90.0)] {
            let l: f64 = 1.0 + r * phi / b;
            let i1_minus_3 = l * l + 1.0 / (l * l) - 2.0;
            let factor = if printed { l * l - 1.0 } else { l * l - 1.0 / (l * l) };
            let sigma = 2.0 * factor * (0.11 + 2.0 * 0.02 * i1_minus_3);
            let ring = PI * ((2.5 / l) * (2.0 * r + 2.5 / l));
            let expected = sigma * ring / (r * (4.0 * b / phi + PI * r));
            let theta = length * phi / (2.0 * b);
            let found = bending(r, length, stress).pressure_gauge_pa(theta) * 1e-6;
            assert!((found / expected - 1.0).abs() < 1e-12, "{stress:?} {b} {phi}: {found} {expected}");
        }
    }
}

#[test]
fn pressure_starts_at_exactly_zero_and_rises_to_a_full_turn() {
    for stress in [AxialStress::Printed, AxialStress::Consistent] {
        for (r, length) in [(4.0, 40.0), (6.0, 58.2), (10.0, 69.6)] {
            let curve = bending(r, length, stress);
            assert_eq!(curve.pressure_gauge_pa(0.0), 0.0);
            // Leading term: σ1 is linear in θ, and so is the lever: pressure rises like θ².
            let ratio = curve.pressure_gauge_pa(2e-7) / curve.pressure_gauge_pa(1e-7);
            assert!((ratio - 4.0).abs() < 1e-5, "{ratio}");
            let branch = Branch::trace(Box::new(curve)).unwrap();
            assert_eq!(branch.end(), BranchEnd::EndOfRange, "{stress:?} {r} {length}");
        }
    }
}

#[test]
fn plane_strain_is_twice_as_stiff_at_first_and_the_same_far_out() {
    // λ² - λ⁻² against λ² - 1: 4e against 2e, then both λ².
    let ratio = |theta| {
        let [a, b] = [AxialStress::Consistent, AxialStress::Printed].map(|s| bending(6.0, 58.2, s));
        a.pressure_gauge_pa(theta) / b.pressure_gauge_pa(theta)
    };
    assert!((ratio(1e-8) - 2.0).abs() < 1e-7);
    assert!(ratio(2.0 * PI) > 1.0 && ratio(2.0 * PI) < ratio(1.0) && ratio(1.0) < 2.0);
}

#[test]
fn flex_sensor_falls_with_voltage_and_covers_the_papers_range() {
    let angle = |u: f64| flex_angle_rad(u).unwrap().to_degrees();
    assert!((1..499).all(|i| angle(0.01 * f64::from(i)) > angle(0.01 * f64::from(i + 1))));
    assert!((angle(1.9645) - 0.0058).abs() < 5e-5 && (angle(1.2195) - 109.9969).abs() < 5e-5);
    assert!((angle(1.5) - 55.76).abs() < 5e-3);
    // Eq. 16 and 17 are one line: θ = 70.74 R/22 kΩ - 109.3 deg.
    let r = flex_resistance_ohm(1.5).unwrap();
    assert!((angle(1.5) - (70.74 * r / 22e3 - 109.3)).abs() < 1e-12);
    for u in [0.0, 5.0, -0.1, 5.1, f64::NAN] {
        assert!(matches!(flex_angle_rad(u), Err(ModelError::OutOfDomain { symbol: "sensor voltage", .. })), "{u}");
        assert!(flex_resistance_ohm(u).is_err());
    }
}
