//! Values of another reader, the physics run backwards, and everything that is not understood.

use std::f64::consts::PI;

use super::*;
use crate::formats::tdms::value::Value;
use crate::limits::TDMS_SCALES_MAX;

const RAW: u64 = 0xFFFF_FFFF;

/// A scaling with its values, as `values.txt` has it.
#[derive(Default)]
struct Case {
    name: &'static str,
    properties: Properties,
    raw: Vec<f64>,
    scalers: Vec<(u32, Vec<f64>)>,
    gives: Vec<f64>,
}

fn numbers(text: &str) -> Vec<f64> {
    text.split_whitespace().map(|number| number.parse().unwrap()).collect()
}

fn cases() -> Vec<Case> {
    let text = include_str!("values.txt");
    let lines = |case: &'static str| {
        let mut lines = case.lines();
        let mut read = Case { name: lines.next().unwrap(), ..Case::default() };
        for line in lines.filter(|line| !line.is_empty()) {
            let (word, rest) = line.split_once(' ').unwrap_or((line, ""));
            let (name, value) = rest.split_once(' ').unwrap_or((rest, ""));
            let value = match word {
                "raw" => {
                    read.raw = numbers(rest);
                    continue;
                }
                "scaler" => {
                    read.scalers.push((name.parse().unwrap(), numbers(value)));
                    continue;
                }
                "gives" => {
                    read.gives = numbers(rest);
                    continue;
                }
                "whole" => Value::Uint(value.parse().unwrap()),
                "number" => Value::Double(value.parse().unwrap()),
                "text" => Value::Text(value.to_owned()),
                _ => panic!("{line}"),
            };
            read.properties.insert(name.to_owned(), value);
        }
        read
    };
    text.split("\ncase ").skip(1).map(lines).collect()
}

fn of(properties: &Properties) -> Result<Option<Scaling>, Unsupported> {
    Scaling::of(properties, &Properties::new(), &Properties::new())
}

fn scaled(properties: &Properties, raw: &[f64]) -> Vec<f64> {
    let mut out = vec![];
    of(properties).unwrap().unwrap().apply(raw, &[], &mut Scratch::default(), &mut out);
    out
}

fn why(properties: &Properties) -> String {
    of(properties).unwrap_err().0
}

fn text(text: &str) -> Value {
    Value::Text(text.to_owned())
}

fn with(pairs: impl IntoIterator<Item = (&'static str, Value)>) -> Properties {
    pairs.into_iter().map(|(name, value)| (name.to_owned(), value)).collect()
}

fn linear(id: usize, slope: f64, intercept: f64, source: u64) -> Properties {
    [
        (format!("NI_Scale[{id}]_Scale_Type"), text("Linear")),
        (format!("NI_Scale[{id}]_Linear_Slope"), Value::Double(slope)),
        (format!("NI_Scale[{id}]_Linear_Y_Intercept"), Value::Double(intercept)),
        (format!("NI_Scale[{id}]_Linear_Input_Source"), Value::Uint(source)),
    ]
    .into()
}

#[test]
fn values_are_those_of_another_reader_to_the_last_bit() {
    let cases = cases();
    assert_eq!(cases.len(), 31);
    for case in cases {
        let scaling = of(&case.properties).unwrap().unwrap();
        assert_eq!(scaling.scalers(), case.scalers.iter().map(|(id, _)| *id).collect::<Vec<_>>(), "{}", case.name);
        assert_eq!(scaling.takes_raw(), case.scalers.is_empty(), "{}", case.name);
        let scalers: Vec<&[f64]> = case.scalers.iter().map(|(_, values)| &values[..]).collect();
        let mut out = vec![0.5];
        scaling.apply(&case.raw, &scalers, &mut Scratch::default(), &mut out);
        assert_eq!(out.len(), 1 + case.gives.len(), "{}", case.name);
        for (got, expected) in out[1..].iter().zip(&case.gives) {
            // Logarithms of two libraries may differ in the last digit; nothing else may.
            let within = if case.name.starts_with("thermistor") { 4.0 * f64::EPSILON * expected.abs() } else { 0.0 };
            let is_same = got.to_bits() == expected.to_bits() || (got - expected).abs() <= within;
            assert!(is_same || (got.is_nan() && expected.is_nan()), "{}: {got:?}, not {expected:?}", case.name);
        }
    }
}

#[test]
fn blocks_do_not_show() {
    // Several steps, more values than a block holds, and buffers that another channel used.
    let case = cases().into_iter().find(|case| case.name.starts_with("a chain")).unwrap();
    let scaling = of(&case.properties).unwrap().unwrap();
    let raw: Vec<f64> = (0..3 * BLOCK + 7).map(|i| (i as f64).sin()).collect();
    let (mut scratch, mut whole, mut single) = (Scratch::default(), vec![], vec![]);
    scaling.apply(&raw, &[], &mut scratch, &mut whole);
    assert_eq!(whole.len(), raw.len());
    for value in &raw {
        scaling.apply(&[*value], &[], &mut scratch, &mut single);
    }
    assert_eq!(whole, single);
    scaling.apply(&[], &[], &mut scratch, &mut single);
    assert_eq!(whole, single);
}

#[test]
fn a_hole_stays_a_hole_in_every_equation() {
    for case in cases().into_iter().filter(|case| case.scalers.is_empty()) {
        let out = scaled(&case.properties, &[f64::NAN]);
        assert!(out[0].is_nan() || case.name.contains("no coefficient"), "{}", case.name);
    }
}

/// The bridge as resistors: its voltage per excitation, from what its four arms are as parts of R0.
fn bridge([r1, r2, r3, r4]: [f64; 4]) -> f64 {
    r3 / (r3 + r4) - r2 / (r1 + r2)
}

#[test]
fn strain_comes_back_from_the_voltage_of_the_resistors() {
    let (gauge, poisson, excitation, initial) = (2.07, 0.285, 3.3, 0.00013);
    for strain in [-2e-2, -1e-3, -1e-6, 0.0, 1e-6, 1e-3, 2e-2] {
        let (along, across) = (gauge * strain, gauge * poisson * strain);
        let arms = |code| match code {
            10_183 => [1.0 - along, 1.0 + along, 1.0 - along, 1.0 + along],
            10_184 => [1.0 - across, 1.0 + across, 1.0 - along, 1.0 + along],
            10_185 => [1.0 - across, 1.0 + along, 1.0 - across, 1.0 + along],
            10_188 => [1.0, 1.0, 1.0 - across, 1.0 + along],
            10_189 => [1.0, 1.0, 1.0 - along, 1.0 + along],
            _ => [1.0, 1.0, 1.0, 1.0 + along],
        };
        for code in [10_183, 10_184, 10_185, 10_188, 10_189, 10_271, 10_272_u64] {
            let mut properties = strain_gauge(code);
            properties.insert("NI_Scale[0]_Strain_Lead_Wire_Resistance".to_owned(), Value::Double(0.0));
            let volts = excitation * bridge(arms(code)) + initial;
            let back = scaled(&properties, &[volts])[0];
            assert!((back - strain).abs() < 1e-15, "{code}: {back:e}, not {strain:e}");
            // Two wires in series with a gauge weaken what it shows; the correction and that of a calibration are factors.
            properties.insert("NI_Scale[0]_Strain_Lead_Wire_Resistance".to_owned(), Value::Double(35.0));
            properties
                .insert("NI_Scale[0]_Strain_Bridge_Shunt_Calibration_Gain_Adjustment".to_owned(), Value::Double(1.25));
            let factor = if code < 10_188 { 1.25 } else { 1.25 * 1.1 };
            let corrected = scaled(&properties, &[volts])[0];
            assert!((corrected - factor * strain).abs() < 1e-14, "{code}");
        }
    }
}

fn strain_gauge(code: u64) -> Properties {
    with([
        ("NI_Scale[0]_Scale_Type", text("Strain")),
        ("NI_Scale[0]_Strain_Configuration", Value::Uint(code)),
        ("NI_Scale[0]_Strain_Poisson_Ratio", Value::Double(0.285)),
        ("NI_Scale[0]_Strain_Gage_Resistance", Value::Double(350.0)),
        ("NI_Scale[0]_Strain_Lead_Wire_Resistance", Value::Double(1.7)),
        ("NI_Scale[0]_Strain_Initial_Bridge_Voltage", Value::Double(0.00013)),
        ("NI_Scale[0]_Strain_Gage_Factor", Value::Double(2.07)),
        ("NI_Scale[0]_Strain_Bridge_Shunt_Calibration_Gain_Adjustment", Value::Double(1.0)),
        ("NI_Scale[0]_Strain_Voltage_Excitation", Value::Double(3.3)),
        ("NI_Scale[0]_Strain_Input_Source", Value::Uint(RAW)),
    ])
}

#[test]
fn temperature_comes_back_from_the_voltage_of_a_thermistor() {
    let (a, b, c) = (1.295_361e-3, 2.343_159e-4, 1.018_703e-7);
    // Steinhart and Hart solved for the resistance: a cubic in its logarithm.
    let resistance = |kelvin: f64| {
        let (p, q) = (b / c, (a - 1.0 / kelvin) / c);
        let root = (q * q / 4.0 + p * p * p / 27.0).sqrt();
        ((root - q / 2.0).cbrt() - (root + q / 2.0).cbrt()).exp()
    };
    // ln 5000 = 8.517193191416238, by hand.
    assert!((resistance(298.150_013_141_324_9) - 5000.0).abs() < 1e-8);
    for kelvin in [230.0, 273.15, 298.15, 400.0] {
        let ohms = resistance(kelvin);
        for (wires, leads) in [(2_u64, 71.0), (3, 35.5), (4, 0.0)] {
            let volts = 0.00015 * (ohms + leads);
            let back = scaled(&thermistor(10_134, 0.00015, wires), &[volts])[0];
            assert!((back - (kelvin - 273.15)).abs() < 1e-9, "{wires} wires: {back}");
            let leads = if wires == 3 { 35.5 } else { 0.0 };
            let volts = 2.5 * (ohms + leads) / (ohms + leads + 10_000.0);
            let back = scaled(&thermistor(10_322, 2.5, wires), &[volts])[0];
            assert!((back - (kelvin - 273.15)).abs() < 1e-9, "{wires} wires: {back}");
        }
    }
    // No resistance is negative: what asks for its logarithm is a hole, not a number.
    assert!(scaled(&thermistor(10_134, 0.00015, 4), &[-1.0])[0].is_nan());
}

fn thermistor(excitation: u64, value: f64, wires: u64) -> Properties {
    with([
        ("NI_Scale[0]_Scale_Type", text("Thermistor")),
        ("NI_Scale[0]_Thermistor_Excitation_Type", Value::Uint(excitation)),
        ("NI_Scale[0]_Thermistor_Excitation_Value", Value::Double(value)),
        ("NI_Scale[0]_Thermistor_Resistance_Configuration", Value::Uint(wires)),
        ("NI_Scale[0]_Thermistor_R1_Reference_Resistance", Value::Double(10_000.0)),
        ("NI_Scale[0]_Thermistor_Lead_Wire_Resistance", Value::Double(35.5)),
        ("NI_Scale[0]_Thermistor_A", Value::Double(1.295_361e-3)),
        ("NI_Scale[0]_Thermistor_B", Value::Double(2.343_159e-4)),
        ("NI_Scale[0]_Thermistor_C", Value::Double(1.018_703e-7)),
        ("NI_Scale[0]_Thermistor_Temperature_Offset", Value::Double(273.15)),
        ("NI_Scale[0]_Thermistor_Input_Source", Value::Uint(RAW)),
    ])
}

#[test]
fn the_nearest_object_that_states_scales_counts() {
    let (none, one, two) = (Properties::new(), linear(0, 1.0, 1.0, RAW), linear(0, 2.0, 0.0, RAW));
    let first = |channel: &Properties, group: &Properties, file: &Properties| {
        let mut out = vec![];
        let scaling: Option<Scaling> = Scaling::of(channel, group, file).unwrap();
        if let Some(scaling) = scaling {
            scaling.apply(&[5.0], &[], &mut Scratch::default(), &mut out);
        }
        out.first().copied()
    };
    assert_eq!(first(&one, &two, &two), Some(6.0));
    assert_eq!(first(&none, &two, &one), Some(10.0));
    assert_eq!(first(&none, &none, &one), Some(6.0));
    assert_eq!(first(&none, &none, &none), None);
    // No scale of its own, said with a number.
    assert_eq!(first(&with([("NI_Number_Of_Scales", Value::Uint(0))]), &one, &none), Some(6.0));
    // What is scaled already is not scaled again, by the group either.
    let done = with([("NI_Scaling_Status", text("scaled"))]);
    assert_eq!(first(&done, &one, &none), None);
    assert_eq!(first(&done.clone().into_iter().chain(one.clone()).collect(), &none, &none), None);
    let raw = with([("NI_Scaling_Status", text("unscaled"))]);
    assert_eq!(first(&raw.into_iter().chain(one.clone()).collect(), &none, &none), Some(6.0));
    let odd: Properties = with([("NI_Scaling_Status", text("SCALED?"))]).into_iter().chain(one).collect();
    assert_eq!(why(&odd), "`NI_Scaling_Status` is `SCALED?`, neither scaled nor unscaled");
}

#[test]
fn a_scale_without_a_type_is_what_the_card_gives() {
    let scaling = of(&with([("NI_Number_Of_Scales", Value::Int(1))])).unwrap().unwrap();
    assert_eq!((scaling.scalers(), scaling.takes_raw()), (&[0][..], false));
    let mut out = vec![];
    scaling.apply(&[], &[&[1.0, 2.0]], &mut Scratch::default(), &mut out);
    assert_eq!(out, [1.0, 2.0]);
}

#[test]
fn a_missing_property_is_named() {
    for case in cases() {
        let may_be_absent = |name: &str| {
            let optional = ["Linear_Input", "Polynomial_Input", "Table_Input", "API_Input", "Coefficients_Size"];
            name == "NI_Number_Of_Scales"
                || name.contains("_Scale_Type")
                || optional.iter().any(|end| name.contains(end))
        };
        for name in case.properties.keys().filter(|name| !may_be_absent(name)) {
            let mut properties = case.properties.clone();
            properties.remove(name);
            match of(&properties) {
                Err(Unsupported(why)) => assert!(why.ends_with(&format!("lacks the property `{name}`")), "{why}"),
                // What its configuration does not ask for, or a scale that the last one does not take.
                Ok(scaling) => assert_eq!(scaling, of(&case.properties).unwrap(), "{}: {name}", case.name),
            }
        }
    }
    let mut short = linear(1, 1.0, 0.0, 0);
    short.remove("NI_Scale[1]_Linear_Slope");
    assert_eq!(why(&short), "scale 1 (Linear) lacks the property `NI_Scale[1]_Linear_Slope`");
}

#[test]
fn what_is_not_understood_is_said_and_never_left_raw() {
    let of_type = |kind| {
        let mut properties = linear(1, 1.0, 0.0, RAW);
        properties.insert("NI_Scale[1]_Scale_Type".to_owned(), kind);
        why(&properties)
    };
    assert_eq!(of_type(text("Thermocouple")), "scale 1 is of the type Thermocouple, which is not supported");
    assert_eq!(of_type(text("RTD")), "scale 1 is of the type RTD, which is not supported");
    assert_eq!(of_type(text("linear\u{1b}")), "scale 1 is of the type `linear\\u{1b}`, which is not known");
    assert_eq!(of_type(Value::Bool(true)), "the property `NI_Scale[1]_Scale_Type` is `true`, not a text");

    let changed = |mut properties: Properties, name: &str, value| {
        properties.insert(name.to_owned(), value);
        why(&properties)
    };
    let slope = |value| changed(linear(0, 1.0, 0.0, RAW), "NI_Scale[0]_Linear_Slope", value);
    assert_eq!(slope(text("1.5")), "the property `NI_Scale[0]_Linear_Slope` is `1.5`, not a finite number");
    assert_eq!(slope(Value::Double(f64::NAN)), "the property `NI_Scale[0]_Linear_Slope` is `NaN`, not a finite number");
    let number = |value| changed(linear(0, 1.0, 0.0, RAW), "NI_Number_Of_Scales", value);
    assert_eq!(number(Value::Int(-1)), "the property `NI_Number_Of_Scales` is `-1`, not a whole number");
    assert_eq!(number(Value::Double(1.0)), "the property `NI_Number_Of_Scales` is `1`, not a whole number");
    let strain = |name: &str, value| changed(strain_gauge(10_188), &format!("NI_Scale[0]_Strain_{name}"), value);
    assert_eq!(
        strain("Configuration", Value::Uint(10_186)),
        "scale 0 (Strain) states the configuration 10186, which is not known"
    );
    for name in ["Voltage_Excitation", "Gage_Factor", "Gage_Resistance", "Bridge_Shunt_Calibration_Gain_Adjustment"] {
        let expected = format!("scale 0 (Strain) states `NI_Scale[0]_Strain_{name}` as 0");
        assert_eq!(strain(name, Value::Double(0.0)), expected);
    }
    assert_eq!(strain("Poisson_Ratio", Value::Double(-1.0)), "scale 0 (Strain) states a Poisson ratio of -1");
    assert_eq!(
        strain("Lead_Wire_Resistance", Value::Double(-350.0)),
        "scale 0 (Strain) states wires that take away its resistance"
    );
    assert_eq!(
        changed(strain_gauge(10_183), "NI_Scale[0]_Strain_Gage_Factor", Value::Double(5e-324)),
        "scale 0 (Strain) states numbers whose strain is beyond all numbers"
    );
    let heat =
        |name: &str, value| changed(thermistor(10_322, 2.5, 3), &format!("NI_Scale[0]_Thermistor_{name}"), value);
    assert_eq!(
        heat("Excitation_Type", Value::Uint(1)),
        "scale 0 (Thermistor) states the excitation 1, which is not known"
    );
    assert_eq!(
        heat("Resistance_Configuration", Value::Uint(5)),
        "scale 0 (Thermistor) states the resistance configuration 5, which is not known"
    );
    assert_eq!(
        heat("R1_Reference_Resistance", Value::Int(0)),
        "scale 0 (Thermistor) states `NI_Scale[0]_Thermistor_R1_Reference_Resistance` as 0"
    );
}

#[test]
fn sources_that_do_not_exist_or_go_round_are_said() {
    assert_eq!(why(&linear(2, 1.0, 0.0, 3)), "scale 2 (Linear) takes scale 3, and the last is scale 2");
    assert_eq!(why(&linear(0, 1.0, 0.0, 0)), "scale 0 takes its own values");
    let round: Properties =
        linear(0, 1.0, 0.0, 2).into_iter().chain(linear(1, 1.0, 0.0, 0)).chain(linear(2, 1.0, 0.0, 1)).collect();
    assert_eq!(why(&round), "scale 2 takes its own values");
    // NI's tools show the raw values as -1.
    let mut signed = linear(0, 2.0, 0.0, 0);
    signed.insert("NI_Scale[0]_Linear_Input_Source".to_owned(), Value::Int(-1));
    assert_eq!(scaled(&signed, &[4.0]), [8.0]);
}

#[test]
fn sums_of_sums_cost_one_step_each() {
    // Each scale takes the one before it twice: as a tree they would be 2^255 steps.
    let last = TDMS_SCALES_MAX - 1;
    let mut properties = linear(0, 1.0, 0.0, RAW);
    for id in 1..=last {
        properties.insert(format!("NI_Scale[{id}]_Scale_Type"), text("Add"));
        for side in ["Left", "Right"] {
            properties.insert(format!("NI_Scale[{id}]_Add_{side}_Operand_Input_Source"), Value::Uint(id as u64 - 1));
        }
    }
    assert_eq!(scaled(&properties, &[1.0]), [2.0_f64.powi(255)]);
    // One more is too many, however it is said.
    let why_not = format!("{} scales are stated, at most {TDMS_SCALES_MAX} are supported", TDMS_SCALES_MAX + 1);
    let count = |count| why(&with([("NI_Number_Of_Scales", count)]));
    assert_eq!(count(Value::Uint(TDMS_SCALES_MAX as u64 + 1)), why_not);
    assert!(count(Value::Uint(u64::MAX)).starts_with(&u64::MAX.to_string()));
    properties.insert(format!("NI_Scale[{}]_Scale_Type", last + 1), text("Add"));
    assert_eq!(why(&properties), why_not);
    properties.insert(format!("NI_Scale[{}]_Scale_Type", "9".repeat(40)), text("Add"));
    assert!(why(&properties).contains("at most"));
    // What only resembles a type is none.
    assert_eq!(of(&with([("NI_Scale[x]_Scale_Type", text("Add")), ("NI_Scale[]_Scale_Type", text("Add"))])), Ok(None));
}

#[test]
fn tables_and_polynomials_have_limits_and_one_direction() {
    let table = |x: &[f64], y: &[f64]| {
        let mut properties = with([("NI_Scale[0]_Scale_Type", text("Table"))]);
        for (what, values) in [("Pre_Scaled", x), ("Scaled", y)] {
            properties.insert(format!("NI_Scale[0]_Table_{what}_Values_Size"), Value::Uint(values.len() as u64));
            for (i, value) in values.iter().enumerate() {
                properties.insert(format!("NI_Scale[0]_Table_{what}_Values[{i}]"), Value::Double(*value));
            }
        }
        properties
    };
    let direction = "scale 0 (Table) has values to scale that neither all go up nor all go down";
    for x in [[0.0, 1.0, 1.0], [0.0, 2.0, 1.0], [2.0, 0.0, 1.0], [1.0, 1.0, 0.0], [1.0, 2.0, 1.0]] {
        assert_eq!(why(&table(&x, &[0.0, 1.0, 2.0])), direction);
    }
    assert_eq!(why(&table(&[1.0], &[])), "scale 0 (Table) has 1 values to scale and 0 that are scaled");
    assert_eq!(why(&table(&[], &[])), "scale 0 (Table) has no points");
    // A table as large as is allowed follows a sine.
    let points = TDMS_SCALE_NUMBERS_MAX / 2;
    let x: Vec<f64> = (0..points).map(|i| PI * i as f64 / points as f64).collect();
    let y: Vec<f64> = x.iter().map(|x| x.sin()).collect();
    let asked: Vec<f64> = (0..5000).map(|i| (f64::from(i) * 0.77) % 3.1).collect();
    for (value, x) in scaled(&table(&x, &y), &asked).iter().zip(&asked) {
        assert!((value - x.sin()).abs() < 1e-7);
    }
    let (x, y) = ([&x[..], &[9.0]].concat(), [&y[..], &[9.0]].concat());
    assert_eq!(
        why(&table(&x, &y)),
        format!("scale 0 (Table) states {} numbers `NI_Scale[0]_Table_Scaled_Values`, which is too many", points + 1)
    );
    // A size is refused before memory is asked for.
    let mut polynomial = with([("NI_Scale[0]_Scale_Type", text("Polynomial"))]);
    polynomial.insert("NI_Scale[0]_Polynomial_Coefficients_Size".to_owned(), Value::Uint(u64::MAX));
    assert!(why(&polynomial).ends_with("which is too many"));
    // Four coefficients where no size is stated.
    polynomial.remove("NI_Scale[0]_Polynomial_Coefficients_Size");
    for i in 0..4 {
        assert_eq!(
            why(&polynomial),
            format!("scale 0 (Polynomial) lacks the property `NI_Scale[0]_Polynomial_Coefficients[{i}]`")
        );
        polynomial.insert(format!("NI_Scale[0]_Polynomial_Coefficients[{i}]"), Value::Single(2.0));
    }
    assert_eq!(scaled(&polynomial, &[3.0]), [80.0]);
}
