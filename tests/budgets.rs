//! Uncertainty through the binary, against numbers by hand: the budget, what a fit and a shared calibration make of it, what would decide an
//! open verdict, and which method makes an interval.

// In a test a panic is how a failure is told.
#![allow(clippy::unwrap_used, clippy::panic)]

mod common;

use common::sitting::Sitting;
use serde_json::Value;

const Z95: f64 = 1.959_963_984_540_054;

fn near(found: &Value, expected: f64, within: f64) {
    let number = found.as_f64().unwrap_or(f64::NAN);
    assert!((number - expected).abs() <= within, "{found} is not {expected} within {within}");
}

fn row<'a>(results: &'a Value, source: &str) -> &'a Value {
    let budget = results["comparisons"][0]["budget"].as_array().unwrap();
    let found = budget.iter().find(|row| row["source"].as_str().unwrap().contains(source));
    found.unwrap_or_else(|| panic!("no {source} in {budget:?}"))
}

fn metric<'a>(results: &'a Value, id: &str) -> &'a Value {
    results["comparisons"][0]["metrics"].as_array().unwrap().iter().find(|m| m["metric"] == id).unwrap()
}

/// An actuator that bends by 0.01 rad/kPa, known to 5 %, and runs of (pressure in kPa, angle in rad).
fn bender(runs: &[&[(f64, f64)]], comparison: &str) -> Sitting {
    let sitting = Sitting::new();
    sitting.write(
        "actuator.toml",
        "schema = 1\nid = \"bender\"\ntype = \"constant-curvature\"\ntitle = \"Bender\"\nsummary = \"Bends.\"\n[chamber.chamber]\n\
         pressure_gauge_max = { value = 40, unit = \"kPa\", source = \"measured\" }\n[geometry]\n\
         angle_per_pressure = { value = 0.01, std = 0.0005, unit = \"rad/kPa\", source = \"measured\" }\n",
    );
    sitting.write(
        "rig.toml",
        "schema = 1\nid = \"bench\"\n[instrument.gauge]\ninput = \"kPa\"\nstd = 0.2\n[instrument.goniometer]\ninput = \"rad\"\nstd = 0.01\n",
    );
    let mut of_runs = String::new();
    for (i, run) in runs.iter().enumerate() {
        let rows: Vec<String> = run.iter().map(|(p, angle)| format!("{p},{angle}\n")).collect();
        sitting.write(&format!("log{i}.csv"), &format!("p,angle\nkPa,rad\n{}", rows.concat()));
        of_runs.extend(["[[run]]\nfile = \"log", &i.to_string(), ".csv\"\n"]);
    }
    sitting.write(
        "session.toml",
        &format!(
            "schema = 1\nid = \"bend\"\nactuator = \"bender\"\nrig = \"bench\"\n\
             [[channel]]\nid = \"p\"\ncolumn = \"p\"\nreference = \"gauge\"\ninstrument = \"gauge\"\n\
             [[channel]]\nid = \"angle\"\ncolumn = \"angle\"\ninstrument = \"goniometer\"\n{of_runs}[[response]]\n\
             quantity = {{ id = \"bending-angle\", title = \"Angle\", unit = \"rad\" }}\n\
             pressure = [{{ channel = \"p\", chamber = \"chamber\" }}]\nmeasured = {{ channel = \"angle\" }}\n\
             [[comparison]]\nquantity = \"bending-angle\"\nform = \"linear-angle\"\n{comparison}"
        ),
    );
    sitting
}

fn bound(sitting: &Sitting, metric: &str, max: f64) {
    sitting.write(
        "bounds.toml",
        &format!(
            "schema = 1\n[[bound]]\nactuator = \"bender\"\nquantity = \"bending-angle\"\nmodel = \"linear-angle\"\n\
             metric = \"{metric}\"\nmax = {{ value = {max}, unit = \"rad\" }}\nreason = \"a test\"\n"
        ),
    );
}

#[test]
fn the_budget_of_two_points_is_that_by_hand() {
    let sitting = bender(&[&[(10.0, 0.11), (20.0, 0.22)], &[(10.0, 0.13), (20.0, 0.26)]], "");
    sitting.validate();
    let results = sitting.results();
    // Means 0.12 and 0.24 rad, of which two repeats leave 0.01 and 0.02 rad; predicted 0.1 and 0.2 rad.
    let rms = |a: f64, b: f64| (0.5 * (a * a + b * b)).sqrt();
    near(&row(&results, "2 repeats")["std_rms_si"], rms(0.01, 0.02), 1e-12);
    near(&row(&results, "goniometer")["std_rms_si"], 0.01, 1e-12);
    // The slope of the prediction times 0.2 kPa.
    near(&row(&results, "gauge of p")["std_rms_si"], 0.002, 1e-9);
    near(&row(&results, "angle_per_pressure")["std_rms_si"], rms(0.005, 0.01), 1e-4);
    let validation = &results["comparisons"][0]["validation"];
    near(&validation["e_si"], rms(0.02, 0.04), 1e-12);
    let of_data: [f64; 2] = [1.0e-4 + 1.0e-4 + 4.0e-6, 4.0e-4 + 1.0e-4 + 4.0e-6];
    let u_d = (0.5 * (of_data[0] + of_data[1])).sqrt();
    near(&validation["u_d_si"], u_d, 1e-9);
    near(&validation["u_input_si"], rms(0.005, 0.01), 1e-4);
    near(&validation["u_val_si"], u_d.hypot(rms(0.005, 0.01)), 1e-4);
    // Of the bias, whose parts add up over the points before they are squared: 0.015, 0.01, 0.002 and 0.0075 rad.
    let parts: [f64; 4] = [0.015, 0.01, 0.002, 0.0075];
    let variance: f64 = parts.iter().map(|p| p * p).sum();
    let budget = results["comparisons"][0]["budget"].as_array().unwrap();
    for (source, part) in ["2 repeats", "goniometer", "gauge of p", "angle_per_pressure"].iter().zip(parts) {
        let i = budget.iter().position(|row| row["source"].as_str().unwrap().contains(source)).unwrap();
        near(&metric(&results, "bias")["shares"][i], part * part / variance, 5e-3);
    }
    // Three quarters of a percent and more is what pools of so many degrees of freedom leave: between the normal and Student's factor of one.
    let bias = metric(&results, "bias");
    let half = 0.5 * (bias["upper"].as_f64().unwrap() - bias["lower"].as_f64().unwrap());
    assert!(half > Z95 * variance.sqrt() && half < 12.71 * variance.sqrt(), "{half}");
}

#[test]
fn an_offset_of_the_instrument_goes_through_a_fit_with_the_data() {
    // Fitted on 20 and 40 kPa, judged on 10 and 30.
    let rows = [(10.0, 0.10), (20.0, 0.21), (30.0, 0.29), (40.0, 0.41)];
    let fit = "fit = { to = \"measured\", parameters = [\"angle_per_pressure\"], hold_out = \"odd-pressures\" }\n";
    let sitting = bender(&[&rows, &rows.map(|(p, a)| (p, a + 0.001 * p / 10.0))], fit);
    sitting.validate();
    let results = sitting.results();
    let used: Vec<f64> = results["comparisons"][0]["points"]
        .as_array()
        .unwrap()
        .iter()
        .filter(|p| p["status"] == "used")
        .map(|p| p["pressures_gauge_pa"][0].as_f64().unwrap() * 1e-3)
        .collect();
    assert_eq!(used.len(), 2, "{used:?}");
    let fitted: Vec<f64> = rows.iter().map(|(p, _)| *p).filter(|p| used.iter().all(|u| (u - p).abs() > 1.0)).collect();
    // k moves by d Σp/Σp², the residual at p by p times that, less d.
    let slope = fitted.iter().sum::<f64>() / fitted.iter().map(|p| p * p).sum::<f64>();
    let moved: Vec<f64> = used.iter().map(|p| 0.01 * (p * slope - 1.0)).collect();
    let rms = (moved.iter().map(|m| m * m).sum::<f64>() / 2.0).sqrt();
    near(&row(&results, "goniometer")["std_rms_si"], rms, 1e-6);
    // What the parameter is declared to be uncertain by is no matter any more.
    let budget = results["comparisons"][0]["budget"].as_array().unwrap();
    assert!(budget.iter().all(|row| row["source"] != "angle_per_pressure"), "{budget:?}");
}

#[test]
fn a_shared_calibration_moves_two_components_together() {
    let upper = |shared: &str| {
        let sitting = Sitting::new();
        sitting.write(
            "actuator.toml",
            "schema = 1\nid = \"arm\"\ntitle = \"Arm\"\nsummary = \"An arm.\"\n[chamber.air]\n\
             pressure_gauge_max = { value = 40, unit = \"kPa\", source = \"measured\" }\n[[model]]\nkind = \"imported\"\nform = \"fea\"\n\
             title = \"FEA\"\nquantity = { id = \"tip\", title = \"Tip\", unit = \"mm\", components = [\"x\", \"z\"] }\nsource = \"a job\"\n\
             file = \"fea.csv\"\npressure = { column = \"p\", chamber = \"air\", reference = \"gauge\" }\npredicted = [\"x\", \"z\"]\n",
        );
        sitting.write(
            "rig.toml",
            &format!("schema = 1\nid = \"bench\"\n[instrument.camera]\ninput = \"mm\"\nstd = 0.5\n{shared}"),
        );
        // Three millimetres off in both.
        sitting.write("fea.csv", "p,x,z\nkPa,mm,mm\n0,0,0\n40,13,23\n");
        sitting.write("log.csv", "p,x,z\nkPa,mm,mm\n0,0,0\n40,10,20\n");
        sitting.write(
            "session.toml",
            "schema = 1\nid = \"tip\"\nactuator = \"arm\"\nrig = \"bench\"\n[[channel]]\nid = \"p\"\ncolumn = \"p\"\nreference = \"gauge\"\n\
             [[channel]]\nid = \"x\"\ncolumn = \"x\"\ninstrument = \"camera\"\n[[channel]]\nid = \"z\"\ncolumn = \"z\"\n\
             instrument = \"camera\"\n[[run]]\nfile = \"log.csv\"\n[[response]]\n\
             quantity = { id = \"tip\", title = \"Tip\", unit = \"mm\", components = [\"x\", \"z\"] }\n\
             pressure = [{ channel = \"p\", chamber = \"air\" }]\nmeasured = { channel = [\"x\", \"z\"] }\n",
        );
        sitting.validate();
        metric(&sitting.results(), "max_abs_error")["upper"].as_f64().unwrap()
    };
    let distance = 3e-3 * 2.0_f64.sqrt();
    // Along the diagonal, which is the way of the error: √2 · 0.5 mm together, 0.5 mm each by itself.
    let together = distance + Z95 * 2.0_f64.sqrt() * 0.5e-3;
    assert!((upper("shared_calibration = true\n") - together).abs() < 1e-9, "{}", upper("shared_calibration = true\n"));
    let apart = distance + Z95 * 0.5e-3;
    assert!((upper("") - apart).abs() < 1e-9, "{}", upper(""));
}

#[test]
fn what_only_a_common_offset_could_move_has_no_interval() {
    // Up and down once: the goniometer's offset moves every value and no area.
    let way = [(0.0, 0.0), (10.0, 0.1), (20.0, 0.2), (30.0, 0.3), (20.0, 0.22), (10.0, 0.12), (0.0, 0.01)];
    let sitting = bender(&[&way], "");
    sitting.change("actuator.toml", "std = 0.0005, ", "");
    sitting.change("rig.toml", "std = 0.2\n", "");
    bound(&sitting, "residual_at_zero", 0.5);
    let said = sitting.validate();
    let results = sitting.results();
    let area = metric(&results, "loop_area");
    assert!(area["value"].is_f64() && area["lower"].is_null() && area["method"].is_null(), "{area}");
    assert!(metric(&results, "bias")["lower"].is_f64());
    // Its sentence counts the points at zero.
    assert!(said.out.contains("from one repeat at 2 of 2 points"), "{}", said.out);
}

/// `n` repeats that stray evenly about 0.02 rad above the model, by a standard deviation of `std`, each alike at both pressures.
fn straying(n: u32, std: f64) -> Sitting {
    let middle = 0.5 * f64::from(n - 1);
    let steps: Vec<f64> = (0..n).map(|i| f64::from(i) - middle).collect();
    let scale = std / (steps.iter().map(|s| s * s).sum::<f64>() / f64::from(n - 1)).sqrt();
    let runs: Vec<Vec<(f64, f64)>> =
        steps.iter().map(|s| vec![(10.0, 0.12 + scale * s), (20.0, 0.22 + scale * s)]).collect();
    let sitting = bender(&runs.iter().map(Vec::as_slice).collect::<Vec<_>>(), "");
    // The repeats alone.
    sitting.change("actuator.toml", "std = 0.0005, ", "");
    sitting.change("rig.toml", "std = 0.2\n", "");
    sitting.change("rig.toml", "std = 0.01\n", "");
    bound(&sitting, "bias", 0.03);
    sitting
}

#[test]
fn the_repeats_that_are_advised_decide_and_a_few_less_do_not() {
    let said = straying(3, 0.02).validate();
    assert_eq!(said.code, 3, "{}", said.out);
    let (before, _) = said.out.split_once(" repeats could decide it").unwrap();
    let advised: u32 = before.rsplit(' ').next().unwrap().parse().unwrap();
    // s/√n times the factor, 0.01 rad from the bound: some 15 to 20.
    assert!((12..=24).contains(&advised), "{advised}: {}", said.out);
    assert_eq!(straying(advised + 1, 0.02).validate().code, 0, "{advised}");
    assert_eq!(straying(advised - 3, 0.02).validate().code, 3, "{advised}");
}

#[test]
fn from_twenty_repeats_on_the_bias_is_bootstrapped_and_hardly_moves() {
    let of = |n: u32| {
        let sitting = straying(n, 0.02);
        sitting.validate();
        metric(&sitting.results(), "bias").clone()
    };
    let (below, from) = (of(19), of(20));
    assert_eq!((&below["method"], &from["method"]), (&"parametric".into(), &"bca".into()));
    let half = |of: &Value| 0.5 * (of["upper"].as_f64().unwrap() - of["lower"].as_f64().unwrap());
    // A bootstrap lacks Student's factor, 2.09 of 1.96, and some 2.5 % of the width, (n - 1)/n.
    assert!((0.85..1.0).contains(&(half(&from) / half(&below))), "{below} {from}");
}
