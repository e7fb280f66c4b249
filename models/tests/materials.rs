//! Questions asked of every hyperelastic law at once: slopes, limits, kinship, stability, and what is refused.

// In a test a panic is how a failure is told; equality of floats is asked where it must be exact.
#![allow(clippy::unwrap_used, clippy::panic, clippy::float_cmp)]

use pneuval_models::ModelError;
use pneuval_models::catalogue::{LAWS, LawEntry, find_law};
use pneuval_models::materials::{
    EndReason, Gent, Hyperelastic, LoadCase, MooneyRivlin, NeoHooke, Ogden, OgdenTerm, Yeoh,
};

/// Central difference with its own error well below 1e-8 for smooth functions near 1.
fn slope(f: impl Fn(f64) -> f64, x: f64) -> f64 {
    let h = 1e-5;
    (8.0 * (f(x + h) - f(x - h)) - (f(x + 2.0 * h) - f(x - 2.0 * h))) / (12.0 * h)
}

fn ogden<const N: usize>(terms: [(f64, f64); N]) -> Ogden {
    Ogden::new(&terms.map(|(mu_pa, alpha)| OgdenTerm { mu_pa, alpha })).unwrap()
}

/// Ogden (1972), three terms for Treloar's vulcanised rubber: 6.3, 0.012 and -0.1 kg/cm².
fn ogden_of_treloar() -> Ogden {
    ogden([(6.3, 1.3), (0.012, 5.0), (-0.1, -2.0)].map(|(mu, alpha)| (mu * KILOGRAM_PER_CM2_PA, alpha)))
}

const KILOGRAM_PER_CM2_PA: f64 = 98_066.5;

/// Every law, with constants of either sign where the law has room for them.
fn laws() -> Vec<Box<dyn Hyperelastic>> {
    vec![
        Box::new(NeoHooke::new(0.2e6).unwrap()),
        Box::new(MooneyRivlin::new(0.15e6, 0.02e6).unwrap()),
        Box::new(MooneyRivlin::new(0.26e6, -0.023e6).unwrap()),
        Box::new(MooneyRivlin::new(-0.01e6, 0.1e6).unwrap()),
        Box::new(Yeoh::new(0.05e6, 0.005e6, 0.0).unwrap()),
        Box::new(Yeoh::new(0.11e6, 0.02e6, 0.0).unwrap()),
        Box::new(Yeoh::new(0.3e6, -0.02e6, 0.004e6).unwrap()),
        Box::new(ogden([(0.1e6, 4.0)])),
        Box::new(ogden([(0.3e6, 1.7), (-0.01e6, -3.1)])),
        Box::new(ogden_of_treloar()),
        // Jm beyond what the largest stretch asked for below needs.
        Box::new(Gent::new(0.2e6, 90.0).unwrap()),
    ]
}

#[test]
fn the_list_of_laws_has_one_of_every_entry() {
    let listed = laws().iter().map(|law| format!("{law:?}")).collect::<Vec<_>>();
    for entry in LAWS {
        let name: String = entry.title.replace('-', "");
        let named = |law: &String| law.to_lowercase().starts_with(&name.to_lowercase());
        assert!(listed.iter().any(named), "no {name} in {listed:?}");
    }
}

#[test]
fn invariants_are_those_of_the_principal_stretches() {
    for l in [0.5_f64, 0.99, 1.0, 1.4, 3.0] {
        for (case, stretches) in [
            (LoadCase::Uniaxial, [l, l.powf(-0.5), l.powf(-0.5)]),
            (LoadCase::Planar, [l, 1.0, 1.0 / l]),
            (LoadCase::Equibiaxial, [l, l, l.powi(-2)]),
        ] {
            let i1 = stretches.iter().map(|s| s * s).sum::<f64>() - 3.0;
            assert!((case.i1_minus_3(l - 1.0) - i1).abs() < 1e-13 * (1.0 + i1.abs()), "I1 {case:?} {l}");
            let i2 = stretches.iter().map(|s| 1.0 / (s * s)).sum::<f64>() - 3.0;
            assert!((case.i2_minus_3(l - 1.0) - i2).abs() < 1e-13 * (1.0 + i2.abs()), "I2 {case:?} {l}");
        }
    }
}

#[test]
fn energy_is_that_of_the_principal_stretches() {
    // The one law that is written in them, from its definition.
    let (law, terms) = (ogden([(0.3e6, 1.7), (-0.01e6, -3.1)]), [(0.3e6, 1.7), (-0.01e6, -3.1_f64)]);
    for l in [0.6_f64, 1.3, 2.5] {
        for (case, stretches) in [
            (LoadCase::Uniaxial, [l, l.powf(-0.5), l.powf(-0.5)]),
            (LoadCase::Planar, [l, 1.0, 1.0 / l]),
            (LoadCase::Equibiaxial, [l, l, l.powi(-2)]),
        ] {
            let sum = |a: f64| stretches.iter().map(|s: &f64| s.powf(a)).sum::<f64>() - 3.0;
            let expected: f64 = terms.iter().map(|(mu, alpha)| mu / alpha * sum(*alpha)).sum();
            let energy = law.strain_energy_pa(case, l).unwrap();
            assert!((energy / expected - 1.0).abs() < 1e-12, "{case:?} at {l}: {energy} against {expected}");
        }
    }
}

#[test]
fn stress_is_the_derivative_of_energy() {
    for law in laws() {
        for case in LoadCase::ALL {
            for stretch in [0.6, 0.9, 1.000_1, 1.1, 1.7, 2.5, 4.0] {
                let stress = law.nominal_stress_pa(case, stretch).unwrap();
                let expected = slope(|l| law.strain_energy_pa(case, l).unwrap(), stretch) / case.loaded_edges();
                assert!(
                    (stress - expected).abs() <= 1e-8 * stress.abs().max(1e4),
                    "{law:?} {case:?} at {stretch}: {stress} against {expected}"
                );
            }
        }
    }
}

#[test]
fn tangent_is_the_derivative_of_stress() {
    for law in laws() {
        for case in LoadCase::ALL {
            for stretch in [0.7, 1.0, 1.3, 2.2, 3.5] {
                let tangent = law.tangent_pa(case, stretch).unwrap();
                let expected = slope(|l| law.nominal_stress_pa(case, l).unwrap(), stretch);
                assert!(
                    (tangent - expected).abs() <= 1e-8 * tangent.abs().max(1e5),
                    "{law:?} {case:?} at {stretch}: {tangent} against {expected}"
                );
            }
        }
    }
}

#[test]
fn stress_is_exactly_zero_undeformed_and_its_slope_is_the_modulus() {
    for law in laws() {
        for (case, times) in [(LoadCase::Uniaxial, 3.0), (LoadCase::Planar, 4.0), (LoadCase::Equibiaxial, 6.0)] {
            assert_eq!(law.strain_energy_pa(case, 1.0), Ok(0.0), "{law:?}");
            assert_eq!(law.nominal_stress_pa(case, 1.0), Ok(0.0), "{law:?}");
            let tangent = law.tangent_pa(case, 1.0).unwrap();
            assert!((tangent / law.shear_modulus_pa() / times - 1.0).abs() < 1e-14, "{law:?} {case:?}");
        }
    }
}

#[test]
fn nothing_cancels_next_to_the_undeformed_state() {
    let excess = (1.0_f64 + 1e-9) - 1.0;
    for law in laws() {
        for (case, times) in [(LoadCase::Uniaxial, 3.0), (LoadCase::Planar, 4.0), (LoadCase::Equibiaxial, 6.0)] {
            let linear = times * law.shear_modulus_pa() * excess;
            let stress = law.nominal_stress_pa(case, 1.0 + excess).unwrap();
            // What is left is the next order of the stress: some times the excess, 1e-9.
            assert!((stress / linear - 1.0).abs() < 1e-8, "{law:?} {case:?}: {stress} against {linear}");
            let energy = law.strain_energy_pa(case, 1.0 + excess).unwrap();
            let expected = 0.5 * case.loaded_edges() * linear * excess;
            assert!((energy / expected - 1.0).abs() < 1e-8, "{law:?} {case:?}: {energy} against {expected}");
        }
    }
    // Digit by digit for the simplest law: 2 (l - 1/l²) = 6 e - 6 e² + 8 e³ - ..., e = l - 1.
    let series = 0.2e6 * (6.0 * excess - 6.0 * excess * excess);
    let stress = NeoHooke::new(0.2e6).unwrap().nominal_stress_pa(LoadCase::Uniaxial, 1.0 + excess).unwrap();
    assert!((stress / series - 1.0).abs() < 1e-15, "{stress} against {series}");
}

#[test]
fn a_law_that_is_a_special_case_of_another_agrees_with_it() {
    let neo_hooke = NeoHooke::new(0.1e6).unwrap();
    let mooney_rivlin = MooneyRivlin::new(0.1e6, 0.02e6).unwrap();
    let pairs: [(&dyn Hyperelastic, &dyn Hyperelastic, f64); 6] = [
        (&ogden([(0.2e6, 2.0)]), &neo_hooke, 1e-13),
        (&ogden([(0.15e6, 2.0), (0.05e6, 2.0)]), &neo_hooke, 1e-13),
        (&ogden([(0.2e6, 2.0), (-0.04e6, -2.0)]), &mooney_rivlin, 1e-13),
        (&Yeoh::new(0.1e6, 0.0, 0.0).unwrap(), &neo_hooke, 1e-15),
        (&MooneyRivlin::new(0.1e6, 0.0).unwrap(), &neo_hooke, 1e-15),
        // The difference is of the order (I1-3)/Jm, at most 60/1e12 here.
        (&Gent::new(0.2e6, 1e12).unwrap(), &neo_hooke, 2e-10),
    ];
    for (special, known, tolerance) in pairs {
        assert!((special.shear_modulus_pa() / known.shear_modulus_pa() - 1.0).abs() < 1e-15);
        for case in LoadCase::ALL {
            for stretch in [0.4, 0.95, 1.000_1, 1.5, 3.0, 5.0] {
                type Ask = fn(&dyn Hyperelastic, LoadCase, f64) -> Result<f64, ModelError>;
                let asked: [Ask; 3] = [
                    |law, case, l| law.strain_energy_pa(case, l),
                    |law, case, l| law.nominal_stress_pa(case, l),
                    |law, case, l| law.tangent_pa(case, l),
                ];
                for ask in asked {
                    let ratio = ask(special, case, stretch).unwrap() / ask(known, case, stretch).unwrap();
                    assert!((ratio - 1.0).abs() < tolerance, "{special:?} {case:?} at {stretch}: ratio {ratio}");
                }
            }
        }
    }
}

#[test]
fn ogdens_constants_follow_treloars_rubber() {
    let law = ogden_of_treloar();
    assert!((law.shear_modulus_pa() / KILOGRAM_PER_CM2_PA - 4.225).abs() < 1e-12);
    // Treloar (1944), simple extension: stretch, force per undeformed area in kg/cm². The law has the upturn at the end.
    for (stretch, measured) in [(1.24, 2.30), (1.90, 5.10), (3.02, 8.80), (5.36, 19.9), (7.25, 49.6)] {
        let stress = law.nominal_stress_pa(LoadCase::Uniaxial, stretch).unwrap() / KILOGRAM_PER_CM2_PA;
        assert!((stress / measured - 1.0).abs() < 0.12, "at {stretch}: {stress} against {measured}");
    }
    // Neo-Hooke of the same modulus follows it at small stretch, and misses the upturn by more than half.
    let gauss = NeoHooke::new(0.5 * law.shear_modulus_pa()).unwrap();
    let ratio = |l| {
        gauss.nominal_stress_pa(LoadCase::Uniaxial, l).unwrap() / law.nominal_stress_pa(LoadCase::Uniaxial, l).unwrap()
    };
    assert!((ratio(1.1) - 1.0).abs() < 0.05 && ratio(7.25) < 0.7, "{} {}", ratio(1.1), ratio(7.25));
    for case in LoadCase::ALL {
        assert_eq!(law.unstable_from(case, 8.0), Ok(None));
    }
}

#[test]
fn an_unstable_law_is_found_out_and_a_stable_one_is_not() {
    let softening = Yeoh::new(0.1e6, -0.02e6, 0.0).unwrap();
    let from = softening.unstable_from(LoadCase::Uniaxial, 3.0).unwrap().unwrap();
    assert!(softening.tangent_pa(LoadCase::Uniaxial, from).unwrap() <= 0.0);
    assert!(softening.tangent_pa(LoadCase::Uniaxial, from - 1e-9).unwrap() > 0.0);
    let paper = Yeoh::new(0.11e6, 0.02e6, 0.0).unwrap();
    for case in LoadCase::ALL {
        assert_eq!(paper.unstable_from(case, 6.0), Ok(None));
    }
}

#[test]
fn stability_ends_where_the_tangent_says_by_hand() {
    // Equibiaxial tangent of Mooney-Rivlin at l = 2: 2 (c1 69/64 + c2 195/16) = 0 for c2/c1 = -23/260.
    let mooney = MooneyRivlin::new(0.26e6, -0.023e6).unwrap();
    let range = mooney.stable_range(LoadCase::Equibiaxial, 0.5, 4.0).unwrap();
    assert!((range.max.stretch - 2.0).abs() < 1e-12 && range.max.why == EndReason::Unstable, "{range:?}");
    assert_eq!((range.min.stretch, range.min.why), (0.5, EndReason::AsFarAsAsked));
    // Planar it is a neo-Hooke law, and stable.
    assert_eq!(mooney.unstable_from(LoadCase::Planar, 10.0), Ok(None));
    // Uniaxial at l = 1/2: 2 (c1 17 + c2 48) = 0 for c2/c1 = -17/48: only in compression.
    let mooney = MooneyRivlin::new(0.48e6, -0.17e6).unwrap();
    let range = mooney.stable_range(LoadCase::Uniaxial, 0.1, 4.0).unwrap();
    assert!((range.min.stretch - 0.5).abs() < 1e-12 && range.min.why == EndReason::Unstable, "{range:?}");
    assert_eq!((range.max.stretch, range.max.why), (4.0, EndReason::AsFarAsAsked));
    // One negative Ogden term with a large exponent takes over in tension.
    let ogden = ogden([(0.3e6, 2.0), (-1e3, 6.0)]);
    assert!(ogden.unstable_from(LoadCase::Uniaxial, 4.0).unwrap().is_some());
}

#[test]
fn gent_locks_and_says_so() {
    let law = Gent::new(0.2e6, 2.0).unwrap();
    // Uniaxial I1-3 = 2 at l = 2.
    let range = law.stable_range(LoadCase::Uniaxial, 0.5, 4.0).unwrap();
    assert!((range.max.stretch - 2.0).abs() < 1e-12 && range.max.why == EndReason::OutOfDomain, "{range:?}");
    for refused in [
        law.strain_energy_pa(LoadCase::Uniaxial, 2.0),
        law.nominal_stress_pa(LoadCase::Uniaxial, 2.0),
        law.tangent_pa(LoadCase::Uniaxial, 3.0),
    ] {
        let error = refused.unwrap_err();
        assert!(matches!(error, ModelError::OutOfDomain { symbol: "(I1 - 3)/Jm", .. }), "{error}");
        assert!(error.to_string().contains("the Gent law locks"), "{error}");
    }
    let error = law.unstable_from(LoadCase::Uniaxial, 4.0).unwrap_err();
    assert!(error.to_string().contains("the Gent law locks"), "{error}");
    assert!(law.nominal_stress_pa(LoadCase::Uniaxial, 1.999_999).unwrap() > 1e10);
}

#[test]
fn no_stretch_gives_anything_but_a_number() {
    for law in laws() {
        for case in LoadCase::ALL {
            for stretch in [-1.0, 0.0, -0.0, f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
                for answer in [
                    law.strain_energy_pa(case, stretch),
                    law.nominal_stress_pa(case, stretch),
                    law.tangent_pa(case, stretch),
                ] {
                    assert!(matches!(answer, Err(ModelError::OutOfDomain { symbol: "stretch", .. })), "{law:?}");
                }
                assert!(law.unstable_from(case, stretch).is_err() && law.stable_range(case, stretch, 2.0).is_err());
            }
            // Numbers overflow here: refused, not infinite.
            for stretch in [f64::MIN_POSITIVE, 1e-200, 1e-17, 1e60, 1e200, f64::MAX] {
                for answer in [
                    law.strain_energy_pa(case, stretch),
                    law.nominal_stress_pa(case, stretch),
                    law.tangent_pa(case, stretch),
                ] {
                    assert!(answer.is_err() || answer.is_ok_and(f64::is_finite), "{law:?} {case:?} at {stretch}");
                }
            }
            let whole = law.stable_range(case, f64::MIN_POSITIVE, f64::MAX).unwrap();
            assert!(whole.min.stretch < 1.0 && whole.max.stretch > 1.0, "{law:?}: {whole:?}");
        }
    }
}

/// Constants of either law that build it, by name.
fn usable(name: &str) -> Option<f64> {
    Some(match name {
        "C10" | "c1" | "mu" | "mu1" => 0.1e6,
        "C20" | "C30" | "c2" | "mu2" | "mu3" => 0.01e6,
        "alpha1" => 2.0,
        "alpha2" => 4.0,
        "alpha3" => 6.0,
        "Jm" => 30.0,
        _ => return None,
    })
}

/// A law with one constant replaced, or left out.
fn with(entry: &LawEntry, changed: &str, value: Option<f64>) -> Result<Box<dyn Hyperelastic>, ModelError> {
    entry.build(&|name| if name == changed { value } else { usable(name) })
}

#[test]
fn every_entry_builds_and_every_check_value_holds() {
    for entry in LAWS {
        assert_eq!(LAWS.iter().filter(|other| other.id == entry.id).count(), 1, "{} twice", entry.id);
        assert_eq!(find_law(entry.id).unwrap().title, entry.title);
        let law = entry.build(&usable).unwrap();
        assert!(law.shear_modulus_pa() > 0.0);
        assert!(entry.checks.len() >= 4, "{} has too few check values", entry.id);
        for check in entry.checks {
            let found = (check.compute)().unwrap();
            assert!(
                (found - check.expected).abs() <= check.tolerance,
                "{}: {}: expected {}, found {found}",
                entry.id,
                check.statement,
                check.expected
            );
        }
    }
    assert!(find_law("hooke").is_none());
}

#[test]
fn what_is_no_material_is_refused_by_the_name_of_its_constant() {
    for entry in LAWS {
        for constant in entry.constants() {
            for value in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
                let error = with(entry, constant.name, Some(value)).unwrap_err();
                assert!(
                    matches!(error, ModelError::OutOfDomain { symbol, .. } if symbol == constant.name),
                    "{} {} = {value}: {error}",
                    entry.id,
                    constant.name
                );
            }
        }
        for constant in entry.required {
            // A negative leading constant leaves no positive modulus: named itself, or the modulus it spoils.
            let error = with(entry, constant.name, Some(-1e6)).unwrap_err();
            assert!(
                matches!(error, ModelError::OutOfDomain { symbol, .. }
                    if symbol == constant.name || symbol == "initial shear modulus"),
                "{} {}: {error}",
                entry.id,
                constant.name
            );
            let error = with(entry, constant.name, None).unwrap_err();
            assert_eq!(error, ModelError::MissingParameter { name: constant.name, meaning: constant.meaning });
        }
    }
    assert!(matches!(NeoHooke::new(0.0), Err(ModelError::OutOfDomain { symbol: "C10", .. })));
    assert!(matches!(Gent::new(1.0, 0.0), Err(ModelError::OutOfDomain { symbol: "Jm", .. })));
    let error = MooneyRivlin::new(1.0, -1.0).unwrap_err().to_string();
    assert!(error.contains("initial shear modulus = 0") && error.contains("2 (c1 + c2)"), "{error}");
    let zero_exponent = OgdenTerm { mu_pa: 1.0, alpha: 0.0 };
    assert!(matches!(Ogden::new(&[zero_exponent]), Err(ModelError::OutOfDomain { symbol: "alpha1", .. })));
    assert!(matches!(Ogden::new(&[]), Err(ModelError::OutOfDomain { symbol: "number of terms", .. })));
}

#[test]
fn half_a_term_and_a_gap_in_the_terms_are_refused() {
    let ogden = find_law("ogden").unwrap();
    let only = |names: &[&str]| ogden.build(&|name| usable(name).filter(|_| names.contains(&name)));
    assert!(only(&["mu1", "alpha1"]).is_ok());
    assert!(only(&["mu1", "alpha1", "mu2", "alpha2"]).is_ok());
    for (names, missing) in [
        (&["mu1", "alpha1", "mu2"][..], "alpha2"),
        (&["mu1", "alpha1", "alpha2"], "mu2"),
        (&["mu1", "alpha1", "mu3", "alpha3"], "mu2"),
        (&["mu1", "alpha1", "mu2", "alpha2", "mu3"], "alpha3"),
    ] {
        let error = only(names).unwrap_err();
        assert!(matches!(error, ModelError::MissingParameter { name, .. } if name == missing), "{names:?}: {error}");
    }
    // Yeoh's higher terms are zero when absent.
    let yeoh = find_law("yeoh").unwrap().build(&|name| usable(name).filter(|_| name == "C10")).unwrap();
    assert_eq!(
        yeoh.nominal_stress_pa(LoadCase::Planar, 2.0),
        NeoHooke::new(0.1e6).unwrap().nominal_stress_pa(LoadCase::Planar, 2.0)
    );
}
