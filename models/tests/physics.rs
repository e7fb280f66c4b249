//! What a physicist asks: derivatives, limits, symmetry, and where a curve ends.

// In a test a panic is how a failure is told; equality of floats is asked where it must be exact.
#![allow(clippy::unwrap_used, clippy::panic, clippy::float_cmp)]

use pneuval_models::actuators::dual_chamber_finger::{Section, Tip, TipReading};
use pneuval_models::actuators::internal_support::{Consistent, Geometry, Printed};
use pneuval_models::error::BranchEnd;
use pneuval_models::kinematics::arc;
use pneuval_models::least_squares::levenberg_marquardt;
use pneuval_models::materials::Yeoh;
use pneuval_models::solve::{Branch, Curve};
use pneuval_models::{ModelError, catalogue};

/// Central difference with its own error well below 1e-8 for smooth functions near 1.
fn slope(f: impl Fn(f64) -> f64, x: f64) -> f64 {
    let h = 1e-5;
    (8.0 * (f(x + h) - f(x - h)) - (f(x + 2.0 * h) - f(x - 2.0 * h))) / (12.0 * h)
}

fn geometry() -> Geometry {
    Geometry::new(30e-3, 28e-3, 28e-3).unwrap()
}

#[test]
fn arc_slopes_are_derivatives_and_limits_are_exact() {
    let h = 0.028;
    for t in [1e-3, 0.1, 0.5, 0.99, 1.01, 1.6, 2.2, 2.9] {
        let stretch = slope(|t| 1.0 + arc::stretch_excess(t), t);
        assert!((arc::stretch_slope(t) - stretch).abs() < 1e-8 * stretch.abs().max(1.0), "stretch at {t}");
        let area = slope(|t| arc::segment_area_m2(h, t) * 1e6, t);
        assert!((arc::segment_area_slope_m2(h, t) * 1e6 - area).abs() < 1e-8 * area.abs().max(1.0), "area at {t}");
        let back = arc::half_angle_from_sagitta_rad(h, arc::sagitta_m(h, t));
        assert!((back - t).abs() < 1e-14, "sagitta at {t}");
    }
    assert_eq!(arc::stretch_excess(0.0), 0.0);
    assert_eq!(arc::stretch_slope(0.0), 0.0);
    assert_eq!(arc::segment_area_m2(h, 0.0), 0.0);
    assert!((arc::segment_area_slope_m2(h, 0.0) - h * h / 6.0).abs() < 1e-18);
    // The leading term of the series, where t / sin t - 1 by subtraction has no digit left.
    assert!((arc::stretch_excess(1e-9) / (1e-18 / 6.0) - 1.0).abs() < 1e-15);
}

#[test]
fn consistent_pressure_is_energy_slope_over_volume_slope() {
    let model = Consistent::new(geometry(), Yeoh::new(0.342e6, 0.104e6, 0.0).unwrap());
    for t in [0.2, 0.8, 1.5, 2.1] {
        let energy = slope(|t| model.energy_j(t), t);
        let volume = slope(|t| model.volume_m3(t), t);
        let expected = energy / volume;
        assert!((model.pressure_gauge_pa(t) / expected - 1.0).abs() < 1e-6, "at {t}");
    }
}

#[test]
fn consistent_volume_starts_at_the_cylinder() {
    let model = Consistent::new(geometry(), Yeoh::new(0.05e6, 0.005e6, 0.0).unwrap());
    let cylinder = std::f64::consts::PI * 14e-3_f64.powi(2) * 28e-3;
    assert!((model.volume_m3(0.0) / cylinder - 1.0).abs() < 1e-14);
    // Pappus: the bulge adds 2π × centroid radius × segment area; a half circle's centroid lies 4R/3π above the chord.
    let radius = 14e-3;
    let bulge_centroid = 14e-3 + 4.0 * radius / (3.0 * std::f64::consts::PI);
    let half_disc = 0.5 * std::f64::consts::PI * radius * radius;
    let expected = cylinder + 2.0 * std::f64::consts::PI * bulge_centroid * half_disc;
    assert!((model.volume_m3(std::f64::consts::FRAC_PI_2) / expected - 1.0).abs() < 1e-13);
}

#[test]
fn consistent_pressure_rises_over_its_whole_range_for_the_papers_materials() {
    for (c10, c20) in [(0.05e6, 0.005e6), (0.342e6, 0.104e6), (0.207e6, 0.180e6), (0.11e6, 0.02e6)] {
        let branch = Branch::trace(Box::new(Consistent::new(geometry(), Yeoh::new(c10, c20, 0.0).unwrap()))).unwrap();
        assert_eq!(branch.end(), BranchEnd::EndOfRange, "{c10} {c20}");
    }
}

#[test]
fn eq_5_last_line_is_not_the_energy_above_it() {
    let section = Section {
        width_m: 28e-3,
        chamber_straight_height_m: 6e-3,
        constraint_thickness_m: 2e-3,
        chamber_length_m: 4e-3,
        outer_radius_m: 14e-3,
        chamber_width_m: 24e-3,
        chamber_radius_m: 12e-3,
        radial_wall_m: 2e-3,
    };
    let law = Yeoh::new(0.11e6, 0.02e6, 0.0).unwrap();
    let at_40_kpa = |reading| {
        let tip = Tip::new(section, 1.5e-3, 5.0, law, reading).unwrap();
        Branch::trace(Box::new(tip)).unwrap().quantity(40e3).unwrap().to_degrees()
    };
    assert!((at_40_kpa(TipReading::Printed) - 197.724_703).abs() < 5e-7);
    assert!((at_40_kpa(TipReading::Eq5LastLine) - 96.98).abs() < 5e-3);
}

#[test]
fn the_printed_pressure_is_negative_so_no_positive_pressure_has_a_solution() {
    let printed = Printed::new(geometry(), Yeoh::new(0.05e6, 0.005e6, 0.0).unwrap());
    for t in [0.01, 0.5, 1.5, 2.9] {
        assert!(printed.pressure_gauge_pa(t) < 0.0);
        assert!(printed.pressure_from_printed_volume_pa(t) > 0.0);
    }
    let branch = Branch::trace(Box::new(printed)).unwrap();
    let error = branch.quantity(10e3).unwrap_err();
    assert_eq!(
        error,
        ModelError::BeyondLimit { pressure_gauge_pa: 10e3, limit_gauge_pa: 0.0, end: BranchEnd::FallsFromStart }
    );
    assert!(error.to_string().contains("no positive pressure has a solution"), "{error}");
}

#[test]
fn eq_21_as_printed_needs_hundreds_of_mpa_unbent() {
    let entry = catalogue::find("dual-chamber-finger", "root-angle", "printed").unwrap();
    let model = entry.build(&entry.stated_inputs()).unwrap();
    let Err(ModelError::BelowStart { start_gauge_pa, .. }) = model.predict_scalar(&[50e3]) else {
        panic!("has a solution")
    };
    assert!((start_gauge_pa / 551.2e6 - 1.0).abs() < 1e-3, "{start_gauge_pa}");
}

/// A neo-Hookean balloon turns over: the pressure has a maximum at a finite stretch.
struct Balloon;

impl Curve for Balloon {
    fn state_end_rad(&self) -> f64 {
        3.0
    }
    fn pressure_gauge_pa(&self, stretch_minus_one: f64) -> f64 {
        let l = 1.0 + stretch_minus_one;
        1e5 * (1.0 / l - l.powi(-7))
    }
    fn quantity(&self, stretch_minus_one: f64) -> f64 {
        1.0 + stretch_minus_one
    }
}

#[test]
fn beyond_the_turning_point_the_error_names_the_limit_pressure() {
    let branch = Branch::trace(Box::new(Balloon)).unwrap();
    // Known exactly: the maximum of 1/l - l^-7 lies at l = 7^(1/6).
    let stretch = 7_f64.powf(1.0 / 6.0);
    let limit = 1e5 * (1.0 / stretch - stretch.powi(-7));
    assert!((branch.limit_gauge_pa() / limit - 1.0).abs() < 1e-14);
    assert_eq!(branch.end(), BranchEnd::TurnsOver);
    let error = branch.quantity(limit * 1.001).unwrap_err().to_string();
    assert!(error.contains("61.9") && error.contains("turns over"), "{error}");
    // On the branch the smaller of the two stretches with this pressure is found.
    let found = branch.quantity(0.9 * limit).unwrap();
    assert!(found < stretch && (Balloon.pressure_gauge_pa(found - 1.0) / (0.9 * limit) - 1.0).abs() < 1e-12);
}

#[test]
fn pressures_and_values_off_the_branch_are_refused() {
    let branch = Branch::trace(Box::new(Balloon)).unwrap();
    for pressure in [-1.0, f64::NAN, f64::INFINITY] {
        assert!(matches!(branch.quantity(pressure), Err(ModelError::OutOfDomain { .. })), "{pressure}");
    }
    for value in [0.999, 1.5, f64::NAN] {
        assert!(matches!(branch.pressure_gauge_pa(value), Err(ModelError::OutOfReach { .. })), "{value}");
    }
}

#[test]
fn least_squares_recovers_an_exponential_and_its_uncertainty() {
    // y = 2 exp(-0.7 x) + alternating 0.01: parameters near the truth, spread of the size of the disturbance.
    let data: Vec<(f64, f64)> = (0..20)
        .map(|i| {
            let x = f64::from(i) * 0.2;
            (x, 2.0 * (-0.7 * x).exp() + if i % 2 == 0 { 0.01 } else { -0.01 })
        })
        .collect();
    let fit =
        levenberg_marquardt(|p| Ok(data.iter().map(|(x, y)| p[0] * (p[1] * x).exp() - y).collect()), &[1.0, -0.1])
            .unwrap();
    assert!((fit.parameters[0] - 2.0).abs() < 0.02 && (fit.parameters[1] + 0.7).abs() < 0.02, "{fit:?}");
    let std = fit.parameters_std.unwrap();
    assert!(std.iter().all(|s| *s > 1e-3 && *s < 2e-2), "{std:?}");
}

#[test]
fn least_squares_refuses_what_cannot_be_posed() {
    let one = |_: &[f64]| Ok(vec![1.0]);
    assert!(matches!(levenberg_marquardt(one, &[1.0, 2.0]), Err(ModelError::TooFewResiduals { .. })));
    assert!(matches!(levenberg_marquardt(one, &[0.0]), Err(ModelError::OutOfDomain { .. })));
}
