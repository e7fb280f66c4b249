//! pdms-wall: the strip's energy balance, its closed form, and what thickness does.

// In a test a panic is how a failure is told; equality of floats is asked where it must be exact.
#![allow(clippy::unwrap_used, clippy::panic, clippy::float_cmp)]

use pneuval_models::ModelError;
use pneuval_models::actuators::pdms_wall::{Constants, Strip, contact_force_n};
use pneuval_models::error::BranchEnd;
use pneuval_models::solve::{Branch, Curve};

const MU: f64 = 6.67e5;

fn strip(wall_mm: f64, constants: Constants) -> Strip {
    Strip::new(20e-3, wall_mm * 1e-3, MU * 7.0 / 16.0, MU / 16.0, constants).unwrap()
}

fn displacement_mm(wall_mm: f64, constants: Constants, pressure_gauge_pa: f64) -> f64 {
    Branch::trace(Box::new(strip(wall_mm, constants))).unwrap().quantity(pressure_gauge_pa).unwrap() * 1e3
}

#[test]
fn strip_work_of_pressure_is_the_energy() {
    // dU = p dA over small steps, and ∫ p dA = U over the whole way.
    let strip = strip(2.0, Constants::AsPrinted);
    for t in [0.1, 0.6, 1.0, 1.7, 2.6] {
        let h = 1e-5;
        let difference =
            |f: &dyn Fn(f64) -> f64| (8.0 * (f(t + h) - f(t - h)) - (f(t + 2.0 * h) - f(t - 2.0 * h))) / (12.0 * h);
        let expected = difference(&|t| strip.energy_j_per_m(t)) / difference(&|t| strip.area_m2(t));
        assert!((strip.pressure_gauge_pa(t) / expected - 1.0).abs() < 1e-6, "{t}");
    }
    let steps = 4000;
    let work: f64 = (0..steps)
        .map(|i| {
            let (a, b) = (1.5 * f64::from(i) / f64::from(steps), 1.5 * f64::from(i + 1) / f64::from(steps));
            strip.pressure_gauge_pa(0.5 * (a + b)) * (strip.area_m2(b) - strip.area_m2(a))
        })
        .sum();
    assert!((work / strip.energy_j_per_m(1.5) - 1.0).abs() < 1e-6, "{work}");
}

#[test]
fn strip_pressure_has_a_closed_form_that_rises_to_the_end() {
    // p = (4 c t_d/h)(t - sin⁴t/t³), c = (μ1 + μ2)/2 = μ/4.
    let strip = strip(2.0, Constants::AsPrinted);
    for t in [0.05, 0.6, 1.5, 2.9] {
        let sine: f64 = f64::sin(t);
        let expected = 4.0 * (MU / 4.0) * 2e-3 / 20e-3 * (t - sine.powi(4) / f64::powi(t, 3));
        assert!((strip.pressure_gauge_pa(t) / expected - 1.0).abs() < 1e-11, "{t}");
    }
    assert_eq!((strip.pressure_gauge_pa(0.0), strip.quantity(0.0)), (0.0, 0.0));
    // Leading term 2/3 t³, where the subtraction above has no digit left.
    let t = 1e-7;
    let leading = 4.0 * (MU / 4.0) * 2e-3 / 20e-3 * 2.0 / 3.0 * f64::powi(t, 3);
    assert!((strip.pressure_gauge_pa(t) / leading - 1.0).abs() < 1e-12);
    assert_eq!(Branch::trace(Box::new(strip)).unwrap().end(), BranchEnd::EndOfRange);
}

#[test]
fn displacement_falls_with_thickness_and_with_stiffness_and_rises_with_pressure() {
    // pdms-wall, sections 2.4 and 4.1: 34.47 to 68.94 kPa in steps of 6.89 kPa.
    let mut before = [0.0; 3];
    for step in 0..=5 {
        let pressure = 34.47e3 + 6.89e3 * f64::from(step);
        let at = [1.5, 2.0, 2.5].map(|wall| displacement_mm(wall, Constants::AsPrinted, pressure));
        assert!(at[0] > at[1] && at[1] > at[2], "{pressure}: {at:?}");
        assert!(at.iter().zip(before).all(|(now, before)| *now > before));
        for (wall, soft) in [1.5, 2.0, 2.5].into_iter().zip(at) {
            assert!(displacement_mm(wall, Constants::MuIsModulus, pressure) < soft);
        }
        before = at;
    }
}

#[test]
fn only_the_product_of_thickness_and_stiffness_counts() {
    let thick = displacement_mm(3.0, Constants::AsPrinted, 34.47e3);
    let stiff = displacement_mm(1.5, Constants::MuIsModulus, 34.47e3);
    assert!((thick - stiff).abs() < 1e-12, "{thick} {stiff}");
}

#[test]
fn mu_printed_is_twice_the_laws_initial_shear_modulus() {
    // Plane strain, small stretch: U = 2 μ0 e² × volume, μ0 the initial shear modulus.
    for (constants, expected) in [(Constants::AsPrinted, 0.5 * MU), (Constants::MuIsModulus, MU)] {
        let t = 1e-4_f64;
        let strain = t * t / 6.0;
        let shear_modulus = strip(2.0, constants).energy_j_per_m(t) / (2e-3 * 20e-3) / (2.0 * strain * strain);
        assert!((shear_modulus / expected - 1.0).abs() < 1e-7, "{constants:?} {shear_modulus}");
    }
}

#[test]
fn what_is_no_wall_is_refused() {
    let with = |chord: f64, wall: f64, mu1: f64, mu2: f64| Strip::new(chord, wall, mu1, mu2, Constants::AsPrinted);
    for (said, symbol) in [
        (with(0.0, 1.0, 1.0, 1.0), "chord"),
        (with(1.0, -1.0, 1.0, 1.0), "wall_thickness"),
        (with(1.0, 1.0, f64::NAN, 1.0), "mu1"),
        (with(1.0, 1.0, 1.0, f64::INFINITY), "mu2"),
        (with(1.0, 1.0, 1.0, -1.0), "mu1 + mu2"),
    ] {
        assert!(matches!(said, Err(ModelError::OutOfDomain { symbol: s, .. }) if s == symbol), "{symbol}");
    }
}

#[test]
fn contact_forces_are_table_2_within_its_digits() {
    // Half a unit of the last digit of pressure, area and force.
    for (pressure, half, area, force) in
        [(37e3, 500.0, 424.4e-6, 15.7), (36.8e3, 50.0, 498.5e-6, 18.4), (35.5e3, 50.0, 542.3e-6, 19.3)]
    {
        let low = contact_force_n(pressure - half, area - 0.05e-6).unwrap();
        let high = contact_force_n(pressure + half, area + 0.05e-6).unwrap();
        assert!(low < force + 0.05 && high > force - 0.05, "{low} {force} {high}");
    }
    assert_eq!(contact_force_n(0.0, 1e-4), Ok(0.0));
    assert!(contact_force_n(1.0, -1e-4).is_err());
}
