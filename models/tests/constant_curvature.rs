//! Constant curvature and what rests on it: limits, derivatives, round trips, frames.

// In a test a panic is how a failure is told; equality of floats is asked where it must be exact.
#![allow(clippy::unwrap_used, clippy::panic, clippy::float_cmp)]

use std::f64::consts::PI;

use pneuval_models::actuators::constant_curvature::{Bender, Bending};
use pneuval_models::actuators::wave_finger::{TensilePoint, YeohConstants, yeoh_from_tensile};
use pneuval_models::kinematics::constant_curvature::{Bent, bending_angle_from_polar_rad, polar_angle_rad};
use pneuval_models::materials::{Hyperelastic, LoadCase, Yeoh};
use pneuval_models::{ModelError, catalogue};

/// Central difference with its own error well below 1e-8 for smooth functions near 1.
fn slope(f: impl Fn(f64) -> f64, x: f64) -> f64 {
    let h = 1e-4;
    (8.0 * (f(x + h) - f(x - h)) - (f(x + 2.0 * h) - f(x - 2.0 * h))) / (12.0 * h)
}

#[test]
fn tip_is_eq_8_and_its_tangent_has_the_bending_angle() {
    let k = 3.0;
    for kl in [1e-3, 0.4, 1.0, PI, 4.0, 6.0] {
        let l = kl / k;
        let [x, z] = Bent::new(kl, l).unwrap().tip_position_m();
        assert!((x - (1.0 - kl.cos()) / k).abs() < 1e-15 && (z - kl.sin() / k).abs() < 1e-15, "{kl}");
        // Along the arc the tip moves at unit speed under the angle kl to z: dx/dl = sin kl, dz/dl = cos kl.
        let tip = |l: f64| Bent::new(k * l, l).unwrap().tip_position_m();
        assert!((slope(|l| tip(l)[0], l) - kl.sin()).abs() < 1e-9, "{kl}");
        assert!((slope(|l| tip(l)[1], l) - kl.cos()).abs() < 1e-9, "{kl}");
    }
}

#[test]
fn straight_is_exact_and_nearly_straight_keeps_its_digits() {
    let l = 0.115;
    assert_eq!(Bent::new(0.0, l).unwrap().tip_position_m(), [0.0, l]);
    assert_eq!(Bent::new(0.0, l).unwrap().chord_m(), l);
    assert_eq!(Bent::new(0.0, l).unwrap().tip_displacement_m(0.0), [0.0, 0.0]);
    // Leading terms: x = lθ/2, along = -lθ²/6. By subtraction both would have no digit left at 1e-9.
    for theta in [1e-9, 1e-12, -1e-9] {
        let [along, sideways] = Bent::new(theta, l).unwrap().tip_displacement_m(0.0);
        assert!((sideways / (0.5 * l * theta) - 1.0).abs() < 1e-15, "{theta}");
        assert!((along / (-l * theta * theta / 6.0) - 1.0).abs() < 1e-15, "{theta}");
    }
}

#[test]
fn inverse_of_the_tip_is_the_arc() {
    for theta in [-6.0, -PI, -1.0, -1e-7, 0.0, 1e-7, 0.3, 1.0, 2.0, PI, 4.0, 6.0] {
        let bent = Bent::new(theta, 0.115).unwrap();
        let back = Bent::from_tip_m(bent.tip_position_m()).unwrap();
        assert!((back.bending_angle_rad - theta).abs() < 1e-13 * theta.abs().max(1e-3), "{theta} {back:?}");
        // Near a full turn the tip is near the base, and a chord of few digits stands for a long arc.
        let conditioning = 1.0 / (2.0 * PI - theta.abs());
        assert!((back.arc_length_m / 0.115 - 1.0).abs() < 1e-14 * conditioning.max(1.0), "{theta} {back:?}");
    }
}

#[test]
fn the_bending_angle_is_twice_the_angle_of_the_chord() {
    for theta in [-5.0, -1.0, 0.0, 0.1, 2.0, PI, 6.0] {
        let [x, z] = Bent::new(theta, 0.2).unwrap().tip_position_m();
        assert!((polar_angle_rad(theta).unwrap() - x.atan2(z)).abs() < 1e-14, "{theta}");
        let back = bending_angle_from_polar_rad(polar_angle_rad(theta).unwrap()).unwrap();
        assert_eq!(back, theta);
        assert!((Bent::new(theta, 0.2).unwrap().chord_m() - x.hypot(z)).abs() < 1e-15, "{theta}");
    }
    for theta in [2.0 * PI, -2.0 * PI, 7.0, f64::NAN, f64::INFINITY] {
        assert!(matches!(polar_angle_rad(theta), Err(ModelError::OutOfDomain { .. })), "{theta}");
        assert!(matches!(bending_angle_from_polar_rad(0.5 * theta), Err(ModelError::OutOfDomain { .. })), "{theta}");
    }
}

#[test]
fn what_is_no_arc_is_refused() {
    for (theta, length) in [(f64::NAN, 1.0), (f64::INFINITY, 1.0), (1.0, 0.0), (1.0, -1.0), (1.0, f64::NAN)] {
        assert!(matches!(Bent::new(theta, length), Err(ModelError::OutOfDomain { .. })), "{theta} {length}");
    }
    for tip in [[0.0, 0.0], [0.0, -1.0], [-0.0, -1.0], [f64::NAN, 1.0], [1.0, f64::INFINITY]] {
        assert!(matches!(Bent::from_tip_m(tip), Err(ModelError::OutOfDomain { .. })), "{tip:?}");
    }
}

#[test]
fn table_2_as_printed_is_not_the_chord() {
    // wave-finger, Table 2: d2 = 2 sin(kl/2)/2; Eq. 7: 2R sin(θ/2).
    let (k, l) = (20.0_f64, 0.115);
    let chord = Bent::new(k * l, l).unwrap().chord_m();
    assert!((chord - 2.0 * (0.5 * k * l).sin() / k).abs() < 1e-15);
    assert!((chord - 2.0 * (0.5 * k * l).sin() / 2.0).abs() > 0.5);
    // A rotation by θ/2, the chord, a rotation by θ/2 is the matrix of Eq. 8.
    let [x, z] = Bent::new(k * l, l).unwrap().tip_position_m();
    let half = 0.5 * k * l;
    assert!((chord * half.sin() - x).abs() < 1e-15 && (chord * half.cos() - z).abs() < 1e-15);
}

#[test]
fn a_bender_that_keeps_its_length_and_one_that_only_grows() {
    let stiff = Bender::new(0.1, 0.0, Bending::Angle(2e-5)).unwrap();
    let mut sideways_before = 0.0;
    for kilopascal in 1..=100 {
        let p = 1e3 * f64::from(kilopascal);
        assert_eq!(stiff.at(p).unwrap().arc_length_m, 0.1);
        let [along, sideways] = stiff.tip_displacement_m(p).unwrap();
        assert!(along < 0.0 && sideways > sideways_before, "{p}");
        sideways_before = sideways;
        // A vacuum bends it the other way, by the same.
        let [along_back, sideways_back] = stiff.tip_displacement_m(-p).unwrap();
        assert!(along_back == along && sideways_back == -sideways, "{p}");
    }
    let growing = Bender::new(0.1, 1e-7, Bending::Curvature(0.0)).unwrap();
    assert_eq!(growing.tip_displacement_m(50e3), Ok([50e3 * 1e-7, 0.0]));
    let shrinking = Bender::new(0.1, -1e-6, Bending::Curvature(1e-4)).unwrap();
    assert!(matches!(shrinking.at(101e3), Err(ModelError::OutOfDomain { symbol: "arc length", .. })));
}

#[test]
fn displacement_is_position_minus_rest_in_every_form() {
    for form in ["linear-curvature", "linear-angle", "from-angle"] {
        let predict = |quantity| {
            let entry = catalogue::find("constant-curvature", quantity, form).unwrap();
            entry.build(&entry.stated_inputs()).unwrap().predict(&[37e3]).unwrap()
        };
        let (position, displacement) = (predict("tip-position"), predict("tip-displacement"));
        assert!((position[1] - 0.1 - displacement[0]).abs() < 1e-15, "{form}");
        assert_eq!(position[0], displacement[1], "{form}");
    }
}

#[test]
fn the_linear_forms_agree_where_they_are_the_same_law() {
    // Without elongation, θ = k1 l0 p: the two laws are one.
    let build = |quantity, form, set: &[(&str, f64)]| {
        let entry = catalogue::find("constant-curvature", quantity, form).unwrap();
        let mut inputs = entry.stated_inputs();
        for (name, value) in set {
            inputs.set(*name, *value);
        }
        entry.build(&inputs).unwrap().predict(&[42e3]).unwrap()
    };
    let set = [("elongation", 0.0), ("curvature_per_pressure", 3e-4), ("angle_per_pressure", 3e-4 * 0.1)];
    for quantity in ["bending-angle", "polar-angle", "tip-position", "tip-displacement"] {
        let (a, b) = (build(quantity, "linear-curvature", &set), build(quantity, "linear-angle", &set));
        assert!(a.iter().zip(&b).all(|(a, b)| (a - b).abs() < 1e-15), "{quantity}: {a:?} {b:?}");
    }
}

fn tensile(c10: f64, c20: f64, stretches: &[f64]) -> Vec<TensilePoint> {
    let law = Yeoh::new(c10, c20, 0.0).unwrap();
    stretches
        .iter()
        .map(|&stretch| TensilePoint {
            stretch,
            nominal_stress_pa: law.nominal_stress_pa(LoadCase::Uniaxial, stretch).unwrap(),
        })
        .collect()
}

#[test]
fn a_line_through_tensile_data_gives_back_the_constants() {
    // wave-finger, section 3.2: upper and lower silicone as stated.
    for (c10, c20) in [(0.08e6, 0.015e6), (0.1e6, 0.0076e6), (0.2e6, 0.0)] {
        let found = yeoh_from_tensile(&tensile(c10, c20, &[0.8, 1.1, 1.5, 2.0, 2.7, 3.5, 4.0])).unwrap();
        assert!((found.c10_pa / c10 - 1.0).abs() < 1e-12 && (found.c20_pa - c20).abs() < 1e-12 * c10, "{found:?}");
    }
}

#[test]
fn the_papers_lines_do_not_give_the_papers_constants() {
    // wave-finger, section 3.2: y1 = 0.0076x + 0.0681, stated (0.1, 0.0076); y2 = 0.081x + 0.741, stated (0.08, 0.015) MPa.
    let lower = YeohConstants::from_line(0.0076, 0.0681);
    assert!((lower.c10_pa - 0.1137).abs() < 1e-15 && (lower.c10_pa - 0.1).abs() > 0.01);
    let upper = YeohConstants::from_line(0.081, 0.741);
    assert!((upper.c10_pa - 1.227).abs() < 1e-15 && (upper.c20_pa - 0.015).abs() > 0.06);
}

#[test]
fn tensile_data_that_determine_nothing_are_refused() {
    let points = tensile(0.1e6, 0.01e6, &[1.5, 1.5, 1.5]);
    assert!(matches!(yeoh_from_tensile(&points), Err(ModelError::Undetermined { .. })));
    assert!(matches!(yeoh_from_tensile(&points[..1]), Err(ModelError::TooFewResiduals { residuals: 1, .. })));
    for stretch in [1.0, 0.0, -1.0, f64::NAN] {
        let mut points = tensile(0.1e6, 0.01e6, &[1.5, 2.0]);
        points.push(TensilePoint { stretch, nominal_stress_pa: 0.0 });
        let said = yeoh_from_tensile(&points);
        assert!(matches!(said, Err(ModelError::OutOfDomain { symbol: "stretch", .. })), "{stretch}: {said:?}");
    }
}
