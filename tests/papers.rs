//! The embedded papers through the binary: the figures that the papers' own numbers give.

// In a test a panic is how a failure is told.
#![allow(clippy::unwrap_used, clippy::panic)]

mod common;

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::sync::LazyLock;

use common::{datasets, pneuval};
use serde_json::Value;

/// One `validate` of the embedded papers, for every test that only reads.
struct Run {
    results: Value,
    /// Every file of the report by relative path.
    report: BTreeMap<String, Vec<u8>>,
}

static RUN: LazyLock<Run> = LazyLock::new(|| {
    let folder = tempfile::tempdir().unwrap();
    let said = pneuval(folder.path(), &["validate", "--out", "report", "--json"]);
    // Every verdict is as expected, and nothing is told beside it.
    assert_eq!((said.code, said.err.as_str()), (0, ""));
    Run { results: serde_json::from_str(&said.out).unwrap(), report: files(&folder.path().join("report")) }
});

fn page(name: &str) -> &'static str {
    std::str::from_utf8(&RUN.report[name]).unwrap()
}

fn rows() -> &'static [Value] {
    RUN.results["comparisons"].as_array().unwrap()
}

fn comparison(id: &str) -> &'static Value {
    rows().iter().find(|c| c["id"] == id).unwrap_or_else(|| panic!("no {id}"))
}

fn text<'a>(record: &'a Value, key: &str) -> &'a str {
    record[key].as_str().unwrap_or_else(|| panic!("{key} of {record}"))
}

fn metric_record(id: &str, metric: &str) -> &'static Value {
    comparison(id)["metrics"].as_array().unwrap().iter().find(|m| m["metric"] == metric).unwrap()
}

fn metric(id: &str, metric: &str) -> f64 {
    metric_record(id, metric)["value"].as_f64().unwrap()
}

/// The points of a comparison: predicted, measured, residual, and half the widths of the first two.
fn scalars(id: &str, key: &str) -> Vec<Option<f64>> {
    let one = |p: &Value| match &p[key] {
        Value::Array(components) => {
            assert_eq!(components.len(), 1, "{id} {key}");
            components[0].as_f64()
        }
        other => other.as_f64(),
    };
    comparison(id)["points"].as_array().unwrap().iter().map(one).collect()
}

/// Whether a number is a printed one: within half a unit of its last digit.
fn is_printed(value: f64, printed: &str) -> bool {
    let decimals = printed.split_once('.').map_or(0, |(_, digits)| digits.len());
    format!("{value:.decimals$}") == printed
}

fn parameter(id: &str, name: &str) -> f64 {
    let parameters = comparison(id)["fit"]["parameters"].as_array().unwrap();
    parameters.iter().find(|p| p["name"] == name).unwrap()["value_si"].as_f64().unwrap()
}

/// Comparison, verdict, and whether it counts.
const ROWS: [(&str, &str, bool); 33] = [
    ("dual-chamber-finger/tip-angle/printed", "pass", true),
    ("dual-chamber-finger/tip-angle/published-fea", "pass", true),
    ("dual-chamber-finger/root-angle/printed", "fail", true),
    ("dual-chamber-finger/root-angle/sheet-strain", "fail", true),
    ("dual-chamber-finger/root-angle/elastic-strip", "fail", true),
    ("dual-chamber-finger/root-angle/elastic-strip-1000x-soft", "pass", true),
    ("dual-chamber-finger/root-angle/no-sheet-k2-1.7-c-1", "pass", true),
    ("dual-chamber-finger/root-angle/no-sheet-k2-1.0-c-pi", "pass", true),
    ("dual-chamber-finger/root-angle/no-sheet-k2-0.85-c-1", "pass", true),
    ("dual-chamber-finger/root-angle/no-sheet-k2-0.85-c-pi", "pass", true),
    ("dual-chamber-finger/root-angle/no-sheet-full-stress-k2-1.7-c-1", "pass", true),
    ("dual-chamber-finger/root-angle/published-fea", "pass", true),
    ("dual-chamber-finger/total-angle/printed-no-sheet", "pass", true),
    ("dual-chamber-finger/total-angle/published-fea", "pass", true),
    ("fruit-finger/bending-angle/printed-calibrated", "calibration", false),
    ("fruit-finger/bending-angle/consistent-calibrated", "calibration", false),
    ("fruit-finger/tip-force/leave-one-pressure-out", "fail", true),
    ("fruit-finger/tip-force/leave-one-pressure-out-affine", "fail", true),
    ("fruit-finger/tip-force/printed", "fail", true),
    ("internal-support/outer-diameter/published-theory", "pass", true),
    ("internal-support/outer-diameter/published-fea", "pass", true),
    ("internal-support/outer-diameter/printed", "fail", true),
    ("internal-support/outer-diameter/consistent", "fail", true),
    ("internal-support/outer-diameter/consistent-fitted-to-fea", "pass", true),
    ("pdms-wall/wall-displacement/strip-as-printed", "unjudged", false),
    ("pdms-wall/wall-displacement/strip-mu-is-modulus", "unjudged", false),
    ("pdms-wall/contact-force/printed", "pass", true),
    ("pdms-wall/wall-displacement/published-simulation-2-mm", "unjudged", false),
    ("pdms-wall/wall-displacement/published-simulation-2.5-mm", "unjudged", false),
    ("wave-finger/bending-angle/linear", "fail", true),
    ("wave-finger/bending-angle/published-fea", "fail", true),
    ("wave-finger/tip-position/published-constant-curvature", "fail", true),
    ("wave-finger/tip-position/published-fea", "pass", true),
];

#[test]
fn the_rows_are_those_of_the_five_papers_and_every_verdict_is_as_expected() {
    let found: Vec<(&str, &str, bool)> =
        rows().iter().map(|c| (text(c, "id"), text(c, "verdict"), c["counted"].as_bool().unwrap())).collect();
    assert_eq!(found, ROWS);
    // Every comparison that counts has a bound, and every bound its verdict and its reason.
    for row in rows().iter().filter(|c| c["counted"] == true) {
        let judgements = row["judgements"].as_array().unwrap();
        assert!(!judgements.is_empty(), "{}", row["id"]);
        for judgement in judgements {
            let expected = if judgement["bound"]["expect"] == "exceed" { "fail" } else { "pass" };
            assert_eq!(text(judgement, "verdict"), expected, "{}", row["id"]);
            assert!(!text(&judgement["bound"], "reason").is_empty());
        }
    }
    assert_eq!(RUN.results["findings"].as_array().unwrap().len(), 0);
    // Nothing but printed points: no repeats, no instruments.
    assert!(rows().iter().all(|c| c["basis"] == "published-point"
        && c["metrics"].as_array().unwrap().iter().all(|m| m["single_repeat"] == false)));
}

#[test]
fn published_errors_of_internal_support() {
    let theory = "internal-support/outer-diameter/published-theory";
    assert!((metric(theory, "rmse") - 0.8689e-3).abs() < 5e-8);
    assert!((metric(theory, "max_abs_error") - 0.94e-3).abs() < 1e-12);
    assert!((metric(theory, "relative_to_measured_max") - 0.028_11).abs() < 5e-6);
    let fea = "internal-support/outer-diameter/published-fea";
    assert!((metric(fea, "rmse") - 1.7689e-3).abs() < 5e-8);
    assert!((metric(fea, "max_abs_error") - 1.86e-3).abs() < 1e-12);
    assert!((metric(fea, "relative_to_measured_max") - 0.049_06).abs() < 5e-6);
    let row = comparison(theory);
    assert_eq!((&row["n_used"], &row["n_available"]), (&Value::from(5), &Value::from(6)));
}

#[test]
fn the_fit_to_the_fea_column_finds_the_stiffer_silicone() {
    let fit = &comparison("internal-support/outer-diameter/consistent-fitted-to-fea")["fit"];
    let parameter = |i: usize| fit["parameters"][i]["value_si"].as_f64().unwrap();
    assert!((parameter(0) - 0.342e6).abs() < 5e2, "C10 {}", parameter(0));
    assert!((parameter(1) - 0.104e6).abs() < 5e2, "C20 {}", parameter(1));
    assert!((fit["rmse_si"].as_f64().unwrap() - 0.035e-3).abs() < 5e-7);
    assert_eq!(fit["fitted_on"][0], "internal-support/outer-diameter published-fea");
}

#[test]
fn angles_of_the_dual_chamber_finger() {
    let predicted = |id: &str| scalars(&format!("dual-chamber-finger/{id}"), "predicted")[0].unwrap().to_degrees();
    assert!((predicted("tip-angle/printed") - 197.724_703).abs() < 5e-7);
    assert!((predicted("root-angle/no-sheet-k2-1.7-c-1") - 46.357_709).abs() < 5e-7);
    assert!((predicted("total-angle/printed-no-sheet") - 244.08).abs() < 5e-3);
    let share = metric("dual-chamber-finger/total-angle/printed-no-sheet", "relative_to_predicted_max");
    assert!((share - 0.0577).abs() < 5e-6);
    let printed = comparison("dual-chamber-finger/root-angle/printed");
    assert!(printed["points"][0]["predicted"].is_null());
    assert!(text(printed, "sentence").contains("551.21 MPa"));
}

#[test]
fn tip_force_of_the_fruit_finger_with_one_pressure_left_out() {
    let id = "fruit-finger/tip-force/leave-one-pressure-out";
    assert!(is_printed(metric(id, "rmse"), "0.108") && is_printed(metric(id, "max_abs_error"), "0.214"));
    assert!(is_printed(parameter(id, "rod_stiffness"), "2.145"));
    let affine = "fruit-finger/tip-force/leave-one-pressure-out-affine";
    assert!(is_printed(metric(affine, "rmse"), "0.098") && is_printed(metric(affine, "max_abs_error"), "0.309"));
    for id in [id, affine] {
        let row = comparison(id);
        assert_eq!((&row["n_used"], &row["n_available"]), (&27.into(), &27.into()), "{id}");
        // Every force is printed to 0.01 N and judged by a fit that did not see its pressure.
        assert!(scalars(id, "measured_half_width").iter().all(|w| (w.unwrap() - 0.005).abs() < 1e-12));
        assert_eq!(
            text(&row["fit"], "hold_out"),
            "each pressure is predicted by a fit to the others, and the fit to all of them is"
        );
        assert_eq!(row["fit"]["n"], 27);
        assert_eq!(row["fit"]["fitted_on"][0], "fruit-finger/tip-force measured");
        assert_eq!(row["conditions"][0]["id"], "held_angle");
        // The fit that saw every force is better than the ones that judge.
        assert!(row["fit"]["rmse_si"].as_f64().unwrap() < metric(id, "rmse"));
        // The metrics are those of the points.
        let residuals: Vec<f64> = scalars(id, "residual").into_iter().map(Option::unwrap).collect();
        let rmse = (residuals.iter().map(|r| r * r).sum::<f64>() / 27.0).sqrt();
        let max = residuals.iter().fold(0.0_f64, |max, r| max.max(r.abs()));
        assert!((rmse - metric(id, "rmse")).abs() < 1e-12 && (max - metric(id, "max_abs_error")).abs() < 1e-12);
    }
}

/// The free rod angle at 60 kPa that K and a imply is above the 110 deg of the abstract: the note on the page says so.
#[test]
fn the_stored_calibration_is_the_one_that_the_fit_finds() {
    let (id, affine) =
        ("fruit-finger/tip-force/leave-one-pressure-out", "fruit-finger/tip-force/leave-one-pressure-out-affine");
    let actuators = RUN.results["actuators"].as_array().unwrap();
    let inputs = actuators.iter().find(|a| a["id"] == "fruit-finger").unwrap()["inputs"].as_array().unwrap();
    for (id, name, tolerance) in [
        (id, "rod_stiffness", 5e-4),
        (id, "free_rod_angle_per_pressure", 5e-9),
        (affine, "affine_rod_stiffness", 5e-4),
        (affine, "affine_free_rod_angle_per_pressure", 5e-9),
        (affine, "affine_free_rod_angle_at_zero", 5e-5),
    ] {
        let stored = inputs.iter().find(|i| i["name"] == name).unwrap();
        assert_eq!(stored["origin"], "calibrated");
        assert!((stored["value_si"].as_f64().unwrap() - parameter(id, name)).abs() < tolerance, "{name}");
    }
    let bend_deg = 2.0 * (parameter(id, "free_rod_angle_per_pressure") * 60e3).to_degrees();
    assert!(bend_deg > 110.0 && page("fruit-finger.html").contains("it implies a free angle of 135 deg at 60 kPa"));
}

#[test]
fn eq_15_as_printed_is_no_force() {
    let row = comparison("fruit-finger/tip-force/printed");
    assert_eq!(
        (&row["n_used"], &row["n_available"], &row["n_without_prediction"]),
        (&0.into(), &27.into(), &27.into())
    );
    for point in row["points"].as_array().unwrap() {
        assert!(point["predicted"].is_null() && point["status"] == "no_prediction");
        assert!(text(point, "reason").contains("N mm"), "{point}");
    }
    assert!(text(row, "sentence").contains("Eq. 15 as printed gives N mm, not N: it is not a force"));
    // What is not a force has no error in newtons either.
    assert!(row["metrics"].as_array().unwrap().iter().all(|m| m["value"].is_null()));
}

#[test]
fn eq_12_is_calibrated_on_the_one_printed_angle_and_decides_nothing() {
    for (form, length_mm) in [("printed", "46.7"), ("consistent", "58.2")] {
        let id = format!("fruit-finger/bending-angle/{form}-calibrated");
        let row = comparison(&id);
        assert!(is_printed(parameter(&id, "finger_length") * 1e3, length_mm), "{form}");
        assert!((scalars(&id, "predicted")[0].unwrap().to_degrees() - 110.0).abs() < 1e-6);
        assert_eq!((text(row, "verdict"), row["counted"].as_bool()), ("calibration", Some(false)));
        assert!(row["fit"]["hold_out"].is_null() && row["judgements"].as_array().unwrap().is_empty());
        // One point and one parameter leave no scatter to tell an uncertainty from.
        assert!(row["fit"]["parameters"][0]["std_si"].is_null());
        assert!(text(row, "remark").contains(&format!("L = {length_mm} mm")));
    }
}

#[test]
fn the_wave_fingers_linear_law_ends_twelve_degrees_above_the_measurement() {
    let linear = "wave-finger/bending-angle/linear";
    let degrees = |id: &str, key: &str| scalars(id, key)[0].unwrap().to_degrees();
    for id in [linear, "wave-finger/bending-angle/published-fea"] {
        assert!((degrees(id, "predicted") - 180.0).abs() < 1e-9 && (degrees(id, "measured") - 168.0).abs() < 1e-9);
        assert!((degrees(id, "residual") - 12.0).abs() < 1e-9);
        assert_eq!(comparison(id)["points"][0]["pressures_gauge_pa"][0], 26e3);
    }
    // A computed angle leaves nothing open; one printed in whole degrees leaves half a degree.
    assert!(degrees(linear, "predicted_half_width").abs() < 1e-12);
    assert!((degrees("wave-finger/bending-angle/published-fea", "predicted_half_width") - 0.5).abs() < 1e-9);
    assert_eq!(text(comparison(linear), "kind"), "assumed");
}

#[test]
fn stated_errors_of_the_wave_finger_are_judged_as_printed() {
    let (arc, fea) =
        ("wave-finger/tip-position/published-constant-curvature", "wave-finger/tip-position/published-fea");
    for (id, name, printed_mm) in
        [(arc, "max_abs_error", 4.682), (arc, "rmse", 0.962), (fea, "max_abs_error", 1.753), (fea, "rmse", 1.148)]
    {
        let record = metric_record(id, name);
        for (key, mm) in [("value", printed_mm), ("lower", printed_mm - 0.0005), ("upper", printed_mm + 0.0005)] {
            assert!((record[key].as_f64().unwrap() * 1e3 - mm).abs() < 1e-9, "{id} {name} {key}");
        }
    }
    let verdicts = |id: &str| -> Vec<(&str, &str, &str)> {
        let judgements = comparison(id)["judgements"].as_array().unwrap().iter();
        judgements.map(|j| (text(&j["bound"], "metric"), text(j, "verdict"), text(&j["bound"], "expect"))).collect()
    };
    // 2 % of 115 mm: the largest error of constant curvature exceeds it, its RMSE does not.
    assert_eq!(verdicts(arc), [("max_abs_error", "fail", "exceed"), ("rmse", "pass", "pass")]);
    assert_eq!(verdicts(fea), [("max_abs_error", "pass", "pass"), ("rmse", "pass", "pass")]);
}

/// An error that is only stated has its digits and nothing that anyone could compute again.
#[test]
fn stated_errors_have_no_points_and_no_other_metric() {
    let stated: BTreeSet<&str> =
        rows().iter().filter(|c| c["metrics_printed"] == true).map(|c| text(c, "id")).collect();
    let expected = [
        "pdms-wall/wall-displacement/published-simulation-2-mm",
        "pdms-wall/wall-displacement/published-simulation-2.5-mm",
        "wave-finger/tip-position/published-constant-curvature",
        "wave-finger/tip-position/published-fea",
    ];
    assert_eq!(stated, BTreeSet::from(expected));
    for id in stated {
        let row = comparison(id);
        assert!(row["points"].as_array().unwrap().is_empty() && row["n_used"] == 0 && row["n_available"] == 0, "{id}");
        for record in row["metrics"].as_array().unwrap().iter().filter(|m| m["value"].is_null()) {
            assert!(text(record, "undefined").contains("not printed"), "{record}");
        }
    }
    let difference =
        |wall: &str| metric(&format!("pdms-wall/wall-displacement/published-simulation-{wall}-mm"), "max_abs_error");
    assert!((difference("2") - 0.08e-3).abs() < 1e-12 && (difference("2.5") - 1.11e-3).abs() < 1e-12);
}

#[test]
fn the_wall_bulges_as_the_strip_says_and_nobody_judges_it() {
    for (form, walls_mm) in
        [("strip-as-printed", ["6.456938", "5.559623", "4.999073"]), ("strip-mu-is-modulus", ["4.60", "4.07", "3.72"])]
    {
        let id = format!("pdms-wall/wall-displacement/{form}");
        for (predicted, mm) in scalars(&id, "predicted").into_iter().zip(walls_mm) {
            assert!(is_printed(predicted.unwrap() * 1e3, mm), "{form}: {predicted:?} for {mm}");
        }
        let row = comparison(&id);
        assert_eq!((&row["n_used"], &row["n_available"]), (&0.into(), &0.into()));
        let points = row["points"].as_array().unwrap();
        let walls: Vec<f64> = points.iter().map(|p| p["conditions_si"][0].as_f64().unwrap()).collect();
        assert_eq!(walls, [1.5e-3, 2e-3, 2.5e-3]);
        assert!(points.iter().all(|p| p["measured"].is_null() && p["status"] == "hole_in_print"));
        assert!(row["metrics"].as_array().unwrap().iter().all(|m| m["value"].is_null()));
        assert!(row["judgements"].as_array().unwrap().is_empty());
        assert!(text(row, "sentence").contains("no measured displacement is printed"));
    }
}

#[test]
fn the_printed_contact_forces_are_products_within_their_rounding() {
    let id = "pdms-wall/contact-force/printed";
    let of = |key: &str| scalars(id, key).into_iter().map(Option::unwrap);
    for ((residual, measured), predicted) in
        of("residual").zip(of("measured_half_width")).zip(of("predicted_half_width"))
    {
        assert!(residual.abs() <= measured + predicted, "zero lies in the interval: {residual} {measured} {predicted}");
    }
    for (predicted, product) in of("predicted").zip([15.7028, 18.3448, 19.25165]) {
        assert!((predicted - product).abs() < 1e-9, "{predicted} {product}");
    }
    // 37 kPa in whole kPa and 424.4 mm² to a tenth leave (37.5 × 424.45 - 37 × 424.4) N/1000 open.
    assert!((of("predicted_half_width").next().unwrap() - 0.214_075).abs() < 1e-9);
    let end = |name: &str, key: &str| metric_record(id, name)[key].as_f64().unwrap();
    assert!(end("bias", "lower") < 0.0 && end("bias", "upper") > 0.0);
    for name in ["mae", "rmse", "max_abs_error", "relative_to_measured_max"] {
        assert!(end(name, "lower").abs() < 1e-12 && end(name, "upper") > 0.0, "{name}");
    }
    assert_eq!(text(comparison(id), "verdict"), "pass");
}

/// What nobody printed is said beside the comparison that rests on it, in the results and on the page.
#[test]
fn comparisons_that_rest_on_assumed_inputs_say_so() {
    let expected: BTreeMap<&str, &[&str]> = BTreeMap::from([
        ("dual-chamber-finger/root-angle/elastic-strip", &["assumed sheet_width"][..]),
        ("dual-chamber-finger/root-angle/elastic-strip-1000x-soft", &["assumed sheet_width"]),
        ("fruit-finger/bending-angle/printed-calibrated", &["assumed chamber_radius"]),
        ("fruit-finger/bending-angle/consistent-calibrated", &["assumed chamber_radius"]),
        ("wave-finger/bending-angle/linear", &["assumed linear_full_pressure", "assumed linear_full_angle"]),
    ]);
    for row in rows() {
        let found: Vec<&str> = row["rests_on"].as_array().unwrap().iter().map(|v| v.as_str().unwrap()).collect();
        assert_eq!(found, *expected.get(text(row, "id")).unwrap_or(&&[][..]), "{}", row["id"]);
    }
    for (name, words, times) in [
        ("dual-chamber-finger.html", "rests on assumed sheet width", 2),
        ("fruit-finger.html", "rests on assumed chamber radius", 2),
        ("wave-finger.html", "rests on assumed linear full pressure, assumed linear full angle", 1),
        ("internal-support.html", "rests on", 0),
        ("pdms-wall.html", "rests on", 0),
    ] {
        assert_eq!(page(name).matches(words).count(), times, "{name}: {words}");
    }
}

#[test]
fn materials_are_those_of_the_papers_and_stable_where_looked_at() {
    let moduli: BTreeMap<(&str, &str), f64> = RUN.results["actuators"]
        .as_array()
        .unwrap()
        .iter()
        .flat_map(|a| a["materials"].as_array().unwrap().iter().map(|m| (text(a, "id"), m)))
        .map(|(actuator, m)| {
            assert!(m["unstable_from"].as_object().unwrap().values().all(Value::is_null), "{actuator}");
            ((actuator, text(m, "id")), m["initial_shear_modulus_pa"].as_f64().unwrap())
        })
        .collect();
    // Twice C10 of a Yeoh law. The wall's is mu/2 of the printed 6.67e5 Pa, as its Eq. 1 has it.
    let expected = [
        (("dual-chamber-finger", "silicone"), 0.22e6),
        (("fruit-finger", "silicone"), 0.22e6),
        (("internal-support", "silicone"), 0.1e6),
        (("pdms-wall", "wall"), 333.5e3),
        (("wave-finger", "lower"), 0.2e6),
        (("wave-finger", "upper"), 0.16e6),
    ];
    assert_eq!(moduli.len(), expected.len());
    for (material, modulus) in expected {
        assert!((moduli[&material] - modulus).abs() < 1e-6, "{material:?}: {}", moduli[&material]);
    }
}

#[test]
fn the_page_says_in_words_that_the_published_curve_cannot_come_from_the_stated_material() {
    let page = page("internal-support.html");
    assert!(
        page.contains("reaches 45.88 mm at 10 kPa, where the paper prints 31.86 (FEA), 32.5 (theory) and 33.44 mm")
    );
    assert!(page.contains("The published curve cannot come from that material"));
}

#[test]
fn the_pages_of_the_new_types_say_what_their_numbers_are() {
    for (name, words) in [
        ("pdms-wall.html", "15.7028 ± 0.21 N"),
        ("pdms-wall.html", "a dash where there is one pressure only"),
        ("fruit-finger.html", "each pressure by a fit to the others: lines join different fits"),
        ("fruit-finger.html", "L² = 2.15 N. That the free rod angle is proportional to pressure is assumed"),
        (
            "fruit-finger.html",
            "measured; each pressure is predicted by a fit to the others, and the fit to all of them is (27 points; ± is the standard error): rod_stiffness = 2.145 ± 0.14 N",
        ),
        ("fruit-finger.html", "Figure 15c: measured and theoretical bending angle over pressure"),
        ("wave-finger.html", "gives 180.00° where 168.00° was measured"),
        ("wave-finger.html", "Figure 18: tip trajectory, measured and FEA"),
        ("pdms-wall.html", "bulges by 6.46 mm, 5.56 mm and 5.00 mm"),
        ("pdms-wall.html", "twice as stiff: 4.60 mm, 4.07 mm and 3.72 mm"),
        ("pdms-wall.html", "Figure 8b: measured and simulated displacement at 34.47 kPa, three walls"),
        ("pdms-wall.html", "printed product, not measured"),
    ] {
        assert!(page(name).contains(words), "{name}: {words}");
    }
}

#[test]
fn embedded_and_on_disk_give_the_same_bytes_and_so_does_running_twice() {
    let folder = tempfile::tempdir().unwrap();
    let disk = datasets();
    for (out, path) in [("a", None), ("b", Some(disk.to_str().unwrap())), ("c", None)] {
        let arguments: Vec<&str> = ["validate", "--out", out].into_iter().chain(path).collect();
        assert_eq!(pneuval(folder.path(), &arguments).code, 0);
    }
    let read = |name: &str| files(&folder.path().join(name));
    assert_eq!(read("a"), read("b"));
    assert_eq!(read("a"), read("c"));
    assert!(read("a").len() >= 10, "index, pages, results, figures");
    // Over an earlier report, and drawn again from stored numbers.
    assert_eq!(pneuval(folder.path(), &["validate", "--out", "a"]).code, 0);
    assert_eq!(pneuval(folder.path(), &["report", "b", "--out", "d"]).code, 0);
    assert_eq!(read("a"), read("c"));
    assert_eq!(read("d"), read("c"));
}

/// Every file below a folder by relative path.
fn files(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut found = BTreeMap::new();
    let mut open = vec![folder.to_owned()];
    while let Some(next) = open.pop() {
        for entry in std::fs::read_dir(next).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                open.push(path);
            } else {
                let name = path.strip_prefix(folder).unwrap().display().to_string();
                found.insert(name, std::fs::read(path).unwrap());
            }
        }
    }
    found
}

#[test]
fn the_stored_digests_are_those_of_the_files_and_no_path_of_this_machine_is_in_them() {
    let folder = tempfile::tempdir().unwrap();
    assert_eq!(pneuval(folder.path(), &["validate", "--out", "report"]).code, 0);
    let stored = files(&folder.path().join("report/results"));
    let text = String::from_utf8(stored["results.json"].clone()).unwrap();
    let results: Value = serde_json::from_str(&text).unwrap();
    let listed = results["files"].as_object().unwrap();
    // results.json and its schema do not list themselves.
    assert_eq!(listed.len() + 2, stored.len());
    for (name, digest) in listed {
        assert_eq!(digest.as_str().unwrap(), pneuval_ingest::digest::sha256(&stored[name]), "{name}");
    }
    assert!(!text.contains(env!("CARGO_MANIFEST_DIR")) && !text.contains(folder.path().to_str().unwrap()));
    assert_eq!(results, RUN.results, "what --json prints is what is stored");
}

const PAGES: [&str; 6] = [
    "dual-chamber-finger.html",
    "fruit-finger.html",
    "index.html",
    "internal-support.html",
    "pdms-wall.html",
    "wave-finger.html",
];

/// A response and its residuals per quantity that has numbers, one response per form where conditions make several curves, a
/// parity per unit, and stated errors on their own.
const FIGURES: [&str; 30] = [
    "dual-chamber-finger_parity_deg",
    "dual-chamber-finger_root-angle_residuals",
    "dual-chamber-finger_root-angle_response",
    "dual-chamber-finger_section",
    "dual-chamber-finger_tip-angle_residuals",
    "dual-chamber-finger_tip-angle_response",
    "dual-chamber-finger_total-angle_residuals",
    "dual-chamber-finger_total-angle_response",
    "fruit-finger_bending-angle_response",
    "fruit-finger_parity_N",
    "fruit-finger_section",
    "fruit-finger_tip-force_residuals",
    "fruit-finger_tip-force_response_leave-one-pressure-out",
    "fruit-finger_tip-force_response_leave-one-pressure-out-affine",
    "internal-support_outer-diameter_residuals",
    "internal-support_outer-diameter_response",
    "internal-support_parity_mm",
    "internal-support_section",
    "pdms-wall_contact-force_residuals",
    "pdms-wall_contact-force_response_printed",
    "pdms-wall_parity_N",
    "pdms-wall_section",
    "pdms-wall_wall-displacement_response_strip-as-printed",
    "pdms-wall_wall-displacement_response_strip-mu-is-modulus",
    "pdms-wall_wall-displacement_stated",
    "wave-finger_bending-angle_residuals",
    "wave-finger_bending-angle_response",
    "wave-finger_parity_deg",
    "wave-finger_section",
    "wave-finger_tip-position_stated",
];

#[test]
fn figures_show_something_and_stand_on_the_page_of_their_type() {
    let name = |path: &'static str| path.strip_prefix("results/figures/")?.strip_suffix(".png");
    let found: BTreeSet<&str> = RUN.report.keys().filter_map(|path| name(path)).collect();
    assert_eq!(found, BTreeSet::from(FIGURES));
    for name in FIGURES {
        let png = &RUN.report[&format!("results/figures/{name}.png")];
        let pixels = image::load_from_memory(png).unwrap().to_rgb8();
        assert!([1570, 2160].contains(&pixels.width()) && pixels.height() >= 400, "{name}");
        let ink = pixels.pixels().filter(|p| p.0 != [255, 255, 255]).count();
        // Stated errors are a few marks on a line each.
        let enough = if name.ends_with("_stated") || name.ends_with("_section") { 10_000 } else { 20_000 };
        assert!(ink > enough, "{name} is blank: {ink}");
        // What reaches the edge was cut off there.
        let at_edge = |(x, y, p): (u32, u32, &image::Rgb<u8>)| {
            let outside = x < 4 || y < 4 || x + 4 >= pixels.width() || y + 4 >= pixels.height();
            outside && p.0 != [255, 255, 255]
        };
        assert!(!pixels.enumerate_pixels().any(at_edge), "{name}: something is cut off at the edge");
        let (actuator, _) = name.split_once('_').unwrap();
        assert!(page(&format!("{actuator}.html")).contains(&format!("id=\"{name}\"")), "{name}");
    }
}

#[test]
fn there_is_a_page_per_type_and_none_needs_another_file() {
    let found: Vec<&str> = RUN.report.keys().map(String::as_str).filter(|name| !name.contains('/')).collect();
    assert_eq!(found, PAGES);
    for name in PAGES {
        let html = page(name);
        assert!(!html.contains("src=\"http") && !html.contains("<script") && !html.contains("<link"), "{name}");
        assert!(html.contains("@font-face"), "{name}");
        // Nothing that a template left empty or could not say.
        assert!(
            !html.contains(">NaN") && !html.contains(" NaN") && !html.contains("undefined") && !html.contains("{{"),
            "{name}"
        );
    }
    for name in PAGES.iter().filter(|name| **name != "index.html") {
        assert!(page("index.html").contains(&format!("href=\"{name}\"")), "{name}");
    }
}

#[test]
fn terminal_page_json_and_exit_code_tell_the_same_numbers() {
    let folder = tempfile::tempdir().unwrap();
    assert_eq!(pneuval(folder.path(), &["validate", "--out", "report"]).code, 0);
    let said = pneuval(folder.path(), &["gate", "report"]);
    assert_eq!(said.code, 0);
    let page = std::fs::read_to_string(folder.path().join("report/index.html")).unwrap();
    // A stated error has the digits it is printed with.
    for (id, unit, scale, decimals) in [
        ("internal-support/outer-diameter/published-theory", " mm", 1e3, 4),
        ("dual-chamber-finger/tip-angle/printed", "°", 180.0 / std::f64::consts::PI, 4),
        ("fruit-finger/tip-force/leave-one-pressure-out", " N", 1.0, 4),
        ("wave-finger/tip-position/published-constant-curvature", " mm", 1e3, 3),
        ("pdms-wall/contact-force/printed", " N", 1.0, 4),
    ] {
        let text = format!("{:.decimals$}{unit}", metric(id, "max_abs_error") * scale);
        assert!(said.out.contains(&text) && page.contains(&text), "{text}");
    }
    let count = format!("{} comparisons", ROWS.len());
    assert!(said.out.contains(&count) && page.contains(&count));
}
