//! Formulas: how they are read, their derivatives, what is refused.
#![allow(clippy::unwrap_used, clippy::panic)]

use pneuval_models::expression::{Expression, Relation, RelationKind};

fn value(text: &str, symbols: &[f64]) -> f64 {
    Expression::parse(text).unwrap().value(symbols)
}

#[test]
fn operators_bind_as_in_print() {
    for (text, expected) in [
        ("1 + 2*3", 7.0),
        ("-2^2", -4.0),
        ("2^-1", 0.5),
        ("2^3^2", 512.0),
        ("2**3", 8.0),
        ("8/4/2", 1.0),
        ("exp[0] + [1 + (2)]", 4.0),
        ("-3*-2", 6.0),
        ("1e3 + .5", 1000.5),
        ("log(exp(2)) + log10(1000)", 5.0),
        ("arctan(1)*4/pi", 1.0),
        ("max(1, 3, 2) - min(4, 2)", 1.0),
        ("2 − 3 × 4", -10.0),
    ] {
        assert!((value(text, &[]) - expected).abs() < 1e-14, "{text} gives {}", value(text, &[]));
    }
}

#[test]
fn every_function_and_operator_has_the_slope_that_differences_show() {
    let formulas = [
        "exp(a*b)",
        "ln(a)*b",
        "log10(a + b)",
        "sqrt(a*b)",
        "abs(a - 3*b)",
        "sin(a)*cos(b)",
        "tan(a/4)",
        "asin(a/9)",
        "acos(b/9)",
        "atan(a*b)",
        "sinh(a)-cosh(b)",
        "tanh(a*b/4)",
        "a^b",
        "a^3/b^2",
        "(a - b)^3",
        "-a/(b + a)",
        "max(a, b)",
        "min(a, b*b)",
        "a^-2",
    ];
    for text in formulas {
        let formula = Expression::parse(text).unwrap();
        let at: Vec<f64> = formula.symbols().iter().map(|name| if name == "a" { 1.3 } else { 0.7 }).collect();
        let (value, gradient) = formula.value_and_gradient(&at);
        assert_eq!(value.to_bits(), formula.value(&at).to_bits(), "{text}");
        for i in 0..at.len() {
            let h = 1e-5;
            let (mut up, mut down) = (at.clone(), at.clone());
            up[i] += h;
            down[i] -= h;
            let difference = (formula.value(&up) - formula.value(&down)) / (2.0 * h);
            assert!((gradient[i] - difference).abs() < 1e-8, "{text} by {i}: {} and {difference}", gradient[i]);
        }
    }
}

#[test]
fn what_is_linear_is_known_by_how_it_is_written() {
    let formula = Expression::parse("a*exp(-b*x) + c*x^2 - d/x + (e + f)*2").unwrap();
    let of = |name: &str| formula.symbols().iter().position(|s| s == name).unwrap();
    let linear = |names: &[&str]| formula.is_linear_in(&names.iter().map(|n| of(n)).collect::<Vec<_>>());
    assert!(linear(&["a", "c", "d", "e", "f"]));
    assert!(!linear(&["b"]) && !linear(&["x"]));
    let product = Expression::parse("a*b*x").unwrap();
    assert!(product.is_linear_in(&[0]) && product.is_linear_in(&[1]) && !product.is_linear_in(&[0, 1]));
}

#[test]
fn what_cannot_be_read_says_where() {
    for (text, at, found) in [
        ("a*(b", 5, "the end"),
        ("a b", 3, "`b`"),
        ("foo(x)", 1, "`foo(x)`"),
        ("a + * b", 5, "`* b`"),
        ("(a]", 3, "`]`"),
        ("", 1, "the end"),
        ("sin + 1", 5, "`+ 1`"),
        ("a $ b", 3, "`$`"),
        ("1.2.3", 1, "`1.2.3`"),
        ("1e999", 1, "`1e999`"),
    ] {
        let error = Expression::parse(text).unwrap_err();
        assert_eq!((error.at, error.found.as_str()), (at, found), "{text}: {error}");
    }
    // Too deep is an error, not a crash.
    let deep = format!("{}x{}", "(".repeat(100_000), ")".repeat(100_000));
    assert!(Expression::parse(&deep).unwrap_err().expected.contains("nested"));
    assert!(Expression::parse(&"-".repeat(100_000)).unwrap_err().expected.contains("nested"));
}

#[test]
fn a_relation_has_two_sides() {
    let relation = Relation::parse("(a - b)/b <= 0.02").unwrap();
    assert_eq!((relation.left.text(), relation.right.text()), ("(a - b)/b", "0.02"));
    assert_eq!(relation.kind, RelationKind::LessOrEqual);
    assert!(Relation::parse("a + b").is_err() && Relation::parse("a = b = c").is_err());
}
