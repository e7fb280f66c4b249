//! Raw logs through a session, by the binary: a type of one's own, calibration, findings, repeats.

// In a test a panic is how a failure is told.
#![allow(clippy::unwrap_used, clippy::panic)]

mod common;

use std::fmt::Write as _;
use std::fs;

use common::pneuval;
use common::sitting::{ACTUATOR, LOG, SESSION, Sitting, findings, points};
use serde_json::Value;

/// The 97.5 % quantile of the standard normal distribution.
const Z95: f64 = 1.959_963_984_540_054;

#[test]
fn a_type_of_ones_own_from_an_actuator_file_a_table_and_a_log() {
    let sitting = Sitting::new();
    // Residuals at 10 to 40 kPa: straight lines give 5, 10, 20, 30 mm against 5.2, 10.1, 19.8, 30.5.
    sitting.change("session.toml", "id = \"stroke\"\ncolumn", "id = \"stroke\"\ninstrument = \"laser\"\ncolumn");
    sitting.change("session.toml", "actuator = ", "rig = \"bench\"\nactuator = ");
    sitting.write("rig.toml", "schema = 1\nid = \"bench\"\n[instrument.laser]\ninput = \"mm\"\nstd = 0.02\n");
    sitting.bound(0.6, "allow_single_repeat = true\n");
    let said = sitting.validate();
    assert_eq!(said.code, 0, "{}{}", said.out, said.err);
    assert!(said.out.contains("0.5000 mm") && said.out.contains("pass"), "{}", said.out);
    let page = fs::read_to_string(sitting.path().join("report/my-bellows.html")).unwrap();
    for word in ["My bellows", "Abaqus 2024, job bellows-7", "straight lines between", "Session: monday", "<svg "] {
        assert!(page.contains(word), "{word}");
    }
    let png = sitting.path().join("report/results/figures/monday_stroke_response.png");
    assert!(image::open(png).unwrap().width() == 2160);
    let results = sitting.results();
    let point = &points(&results, 0)[3];
    assert!((point["predicted"][0].as_f64().unwrap() - 20e-3).abs() < 1e-15);
    // 95 %: 1.96 of the table's standard uncertainties, and of the instrument's.
    assert!((point["predicted_half_width"][0].as_f64().unwrap() - Z95 * 0.01e-3).abs() < 1e-15);
    assert!((point["measured_half_width"][0].as_f64().unwrap() - Z95 * 0.02e-3).abs() < 1e-15);
    let sources = results["actuators"][0]["datasets"][0]["sources"].as_array().unwrap();
    let names: Vec<&str> = sources.iter().map(|s| s["path"].as_str().unwrap()).collect();
    assert_eq!(names, ["session.toml", "rig.toml", "log.csv", "actuator.toml", "fea.csv", "bounds.toml"]);
    // A tighter bound, a failure; and the same through the stored results.
    sitting.bound(0.4, "allow_single_repeat = true\n");
    assert_eq!(sitting.validate().code, 1);
    assert_eq!(pneuval(sitting.path(), &["gate", "report"]).code, 1);
}

#[test]
fn nothing_is_extrapolated() {
    let sitting = Sitting::new();
    sitting.change("fea.csv", "40,30.0,0.01\n", "");
    sitting.bound(9.0, "");
    let said = sitting.validate();
    assert_eq!(said.code, 1, "{}", said.out);
    assert!(said.out.contains("no prediction at 2 of 4 measured points"), "{}", said.out);
    assert!(said.out.contains("the table reaches from 0 kPa to 20 kPa; nothing is extrapolated"), "{}", said.out);
}

#[test]
fn what_rounding_adds_to_the_last_pressure_of_a_table_is_still_in_the_table() {
    let sitting = Sitting::new();
    sitting.change("session.toml", "reference = \"gauge\"", "reference = \"absolute\"");
    sitting.change(
        "session.toml",
        "file = \"log.csv\"",
        "file = \"log.csv\"\natmosphere = { value = 90.02, unit = \"kPa\" }",
    );
    sitting.write("log.csv", "pressure (kPa);stroke [mm]\n90,02;0,0\n110,02;10,1\n130,02;30,5\n130,03;30,6\n");
    sitting.validate();
    let results = sitting.results();
    let (end, beyond) = (&points(&results, 0)[2], &points(&results, 0)[3]);
    // The subtraction leaves more than the 40 kPa at which the table ends.
    assert!(end["pressures_gauge_pa"][0].as_f64().unwrap() > 40e3, "{end}");
    assert!((end["predicted"][0].as_f64().unwrap() - 30e-3).abs() < 1e-15 && end["status"] == "used", "{end}");
    assert!(beyond["predicted"].is_null() && beyond["status"] == "no_prediction", "{beyond}");
    assert!(beyond["reason"].as_str().unwrap().contains("reaches from 0 kPa to 40 kPa"), "{beyond}");
    assert_eq!(
        (&results["comparisons"][0]["n_used"], &results["comparisons"][0]["n_without_prediction"]),
        (&2.into(), &1.into())
    );
}

#[test]
fn one_repeat_decides_nothing_unless_the_bound_allows_it_and_the_instrument_says_how_sure_it_is() {
    let sitting = Sitting::new();
    sitting.bound(5.0, "");
    let said = sitting.validate();
    assert_eq!(said.code, 3);
    assert!(said.out.contains("from one repeat"), "{}", said.out);
    // Allowed, but the log says nothing about its uncertainty.
    sitting.bound(5.0, "allow_single_repeat = true\n");
    let said = sitting.validate();
    assert_eq!(said.code, 3);
    assert!(said.out.contains("declares no uncertainty"), "{}", said.out);
}

#[test]
fn what_was_measured_once_has_no_interval_and_says_so_metric_by_metric() {
    let sitting = Sitting::new();
    let metric = |results: &Value, id: &str| {
        let metrics = results["comparisons"][0]["metrics"].as_array().unwrap();
        metrics.iter().find(|m| m["metric"] == id).unwrap().clone()
    };
    let open = |record: &Value| record["lower"].is_null() && record["upper"].is_null();
    sitting.validate();
    let results = sitting.results();
    for id in ["bias", "rmse", "max_abs_error", "residual_at_zero"] {
        let record = metric(&results, id);
        assert!(record["value"].is_number() && open(&record) && record["single_repeat"] == true, "{record}");
    }
    // A second run that never was at zero: only the reference is a single repeat.
    sitting.write("log2.csv", "pressure (kPa);stroke [mm]\n10;5,3\n20;10,2\n30;19,9\n40;30,7\n");
    sitting.change("session.toml", "file = \"log.csv\"\n", "file = \"log.csv\"\n[[run]]\nfile = \"log2.csv\"\n");
    sitting.validate();
    let results = sitting.results();
    let (error, at_zero) = (metric(&results, "max_abs_error"), metric(&results, "residual_at_zero"));
    assert!(error["single_repeat"] == false && error["upper"].as_f64() > error["value"].as_f64(), "{error}");
    assert!(at_zero["single_repeat"] == true && at_zero["value"] == 0.0 && open(&at_zero), "{at_zero}");
    // Without a point at zero there is no residual at zero.
    sitting.change("log.csv", "0;0,0\n", "");
    sitting.validate();
    let at_zero = metric(&sitting.results(), "residual_at_zero");
    assert!(at_zero["value"].is_null() && at_zero["undefined"] == "no zero-pressure reference", "{at_zero}");
}

#[test]
fn repeats_give_an_interval_that_decides() {
    let sitting = Sitting::new();
    sitting.write(
        "log2.csv",
        &LOG.replace("5,2", "5,3").replace("10,1", "10,2").replace("30,5", "30,7").replace("19,8", "19,9"),
    );
    sitting.write("log3.csv", &LOG.replace("30,5", "30,6"));
    sitting.change(
        "session.toml",
        "[[run]]\nfile = \"log.csv\"\n",
        "[[run]]\nfile = \"log.csv\"\n[[run]]\nfile = \"log2.csv\"\n[[run]]\nfile = \"log3.csv\"\n",
    );
    sitting.bound(2.0, "");
    let said = sitting.validate();
    assert_eq!(said.code, 0, "{}", said.out);
    let results = sitting.results();
    let last = &points(&results, 0)[4];
    assert_eq!(last["runs"].as_array().unwrap().len(), 3);
    assert!((last["measured"][0].as_f64().unwrap() - 30.6e-3).abs() < 1e-12);
    // s = 0.1 mm, n = 3: 4.302653 × 0.1 / √3.
    let half = last["measured_half_width"][0].as_f64().unwrap() * 1e3;
    assert!((half - 4.302_652_73 * 0.1 / 3.0_f64.sqrt()).abs() < 1e-6, "{half}");
    // Repeats that agree to the last digit say nothing of how sure they are, unless the instrument does.
    sitting.write("log2.csv", &(LOG.to_owned() + "\n"));
    sitting.write("log3.csv", &(LOG.to_owned() + "\n\n"));
    let said = sitting.validate();
    assert!(said.code == 3 && said.out.contains("agree to the last digit"), "{}", said.out);
    sitting.write(
        "log2.csv",
        &LOG.replace("5,2", "5,3").replace("10,1", "10,2").replace("30,5", "30,7").replace("19,8", "19,9"),
    );
    sitting.write("log3.csv", &LOG.replace("30,5", "30,6"));
    // Wholly beyond, and over the bound: 0.6 mm with 0.25 mm either side.
    sitting.bound(0.1, "");
    assert_eq!(sitting.validate().code, 1);
    for (bound, why) in [(0.75, "repeats could decide it"), (0.6, "what lies on the bound no measurement can decide")] {
        sitting.bound(bound, "");
        let said = sitting.validate();
        assert_eq!(said.code, 3);
        assert!(said.out.contains("the scatter of 3 repeats makes") && said.out.contains(why), "{}", said.out);
    }
}

#[test]
fn text_in_a_number_column_is_a_hole_with_line_and_column() {
    let sitting = Sitting::new();
    sitting.change("log.csv", "20;10,1", "20;error");
    let said = sitting.validate();
    assert_eq!(said.code, 3, "{}", said.err);
    assert!(
        said.err.contains("stroke [mm]") && said.err.contains("line 4") && said.err.contains("`error`"),
        "{}",
        said.err
    );
    let results = sitting.results();
    let finding = findings(&results, "non-numeric-cell")[0];
    assert_eq!((&finding["severity"], &finding["channel"]), (&Value::from("excluded"), &Value::from("stroke [mm]")));
    assert_eq!(
        (&finding["spans"][0]["first_sample"], &finding["spans"][0]["first_line"]),
        (&Value::from(2), &Value::from(4))
    );
    assert_eq!(points(&results, 0).len(), 4);
    let session = &results["actuators"][0]["datasets"][0]["session"];
    assert_eq!((&session["samples_read"], &session["samples_excluded"]), (&Value::from(5), &Value::from(1)));
    // One in five is more than the one in twenty that a session allows by itself; a session may allow more.
    assert!(
        fs::read_to_string(sitting.path().join("report/index.html")).unwrap().contains("more than the 5.000 % allowed")
    );
    sitting.bound(2.0, "allow_single_repeat = true\n");
    sitting.change("session.toml", "actuator = ", "rig = \"bench\"\nactuator = ");
    sitting.change("session.toml", "id = \"stroke\"\ncolumn", "id = \"stroke\"\ninstrument = \"laser\"\ncolumn");
    sitting.write("rig.toml", "schema = 1\nid = \"bench\"\n[instrument.laser]\ninput = \"mm\"\nstd = 0.02\n");
    assert_eq!(sitting.validate().code, 3);
    sitting.change("session.toml", "actuator = ", "excluded_max = { value = 20, unit = \"%\" }\nactuator = ");
    assert_eq!(sitting.validate().code, 0);
}

#[test]
fn only_a_required_channel_without_any_number_is_exit_4() {
    let sitting = Sitting::new();
    sitting.write("log.csv", "pressure (kPa);stroke [mm];note\n0;0,0;a\n10;off;b\n20;off;c\n");
    assert_eq!(sitting.validate().code, 3, "one sample survives");
    sitting.write(
        "rig.toml",
        "schema = 1\nid = \"bench\"\n[instrument.laser]\ninput = \"mm\"\nvalid = { min = 100, max = 200 }\n",
    );
    sitting.change("session.toml", "actuator = ", "rig = \"bench\"\nactuator = ");
    sitting.change("session.toml", "id = \"stroke\"\ncolumn", "id = \"stroke\"\ninstrument = \"laser\"\ncolumn");
    let before = fs::read_dir(sitting.path()).unwrap().count();
    let said = sitting.validate();
    assert_eq!(said.code, 4, "{}", said.err);
    assert!(said.err.contains("channel `stroke`") && said.err.contains("none of 3"), "{}", said.err);
    assert_eq!(fs::read_dir(sitting.path()).unwrap().count(), before, "nothing is written over an earlier report");
    // A log with no number in it at all.
    let sitting = Sitting::new();
    sitting.write("log.csv", "the rig was off\n");
    assert_eq!(sitting.validate().code, 4);
}

#[test]
fn flex_volts_become_degrees_and_what_the_sensor_cannot_mean_is_refused_per_sample() {
    let sitting = Sitting::new();
    // The embedded rig of the fruit gripper's finger: Eq. 16 and 17.
    sitting.write(
        "session.toml",
        &SESSION
            .replace("actuator = ", "rig = \"fruit-finger\"\nactuator = ")
            .replace(
                "id = \"stroke\"\ncolumn = \"stroke [mm]\"",
                "id = \"angle\"\ncolumn = \"u\"\ninstrument = \"flex\"",
            )
            .replace("pressure (kPa)", "p")
            .replace("reference", "unit = \"kPa\"\nreference")
            .replace(
                "{ id = \"stroke\", title = \"Stroke\", unit = \"mm\" }",
                "{ id = \"angle\", title = \"Angle\", unit = \"deg\" }",
            )
            .replace("channel = \"stroke\"", "channel = \"angle\""),
    );
    sitting.write("log.csv", "p,u\n0,1.9645\n10,1.5\n20,1.2195\n30,0\n40,5\n50,-0.2\n60,5.3\n");
    let said = sitting.validate();
    assert_eq!(said.code, 3, "{}", said.err);
    let results = sitting.results();
    let degrees: Vec<f64> =
        points(&results, 0).iter().map(|p| p["measured"][0].as_f64().unwrap().to_degrees()).collect();
    assert_eq!(degrees.len(), 3);
    for (found, printed, half) in [(degrees[0], 0.0058, 5e-5), (degrees[1], 55.76, 5e-3), (degrees[2], 109.9969, 5e-5)]
    {
        assert!((found - printed).abs() <= half, "{found} {printed}");
    }
    let refused = findings(&results, "out-of-calibration")[0];
    assert_eq!((&refused["count"], &refused["severity"]), (&Value::from(4), &Value::from("excluded")));
    let text = refused["text"].as_str().unwrap();
    for word in ["0 V at line 5", "5 V at line 6", "-0.2 V at line 7", "5.3 V at line 8"] {
        assert!(text.contains(word), "{word}: {text}");
    }
    assert_eq!(
        (&refused["spans"][0]["first_sample"], &refused["spans"][0]["last_sample"]),
        (&Value::from(3), &Value::from(6))
    );
}

#[test]
fn absolute_pressure_needs_the_atmosphere_and_becomes_gauge() {
    let sitting = Sitting::new();
    sitting.change("session.toml", "reference = \"gauge\"", "reference = \"absolute\"");
    sitting.change(
        "log.csv",
        "0;0,0\n10;5,2\n20;10,1\n30;19,8\n40;30,5",
        "101;0,0\n111;5,2\n121;10,1\n131;19,8\n141;30,5",
    );
    let said = sitting.validate();
    assert_eq!(said.code, 2);
    assert!(said.err.contains("session.toml:15") && said.err.contains("`atmosphere`"), "{}", said.err);
    sitting.change(
        "session.toml",
        "file = \"log.csv\"",
        "file = \"log.csv\"\natmosphere = { value = 101, unit = \"kPa\" }",
    );
    assert_eq!(sitting.validate().code, 3);
    let results = sitting.results();
    let gauge: Vec<f64> = points(&results, 0).iter().map(|p| p["pressures_gauge_pa"][0].as_f64().unwrap()).collect();
    assert_eq!(gauge, [0.0, 10e3, 20e3, 30e3, 40e3]);
    // A pressure of which nobody says which it is, is refused.
    sitting.change("session.toml", "reference = \"absolute\"\n", "");
    let said = sitting.validate();
    assert!(said.code == 2 && said.err.contains("gauge or absolute"), "{}", said.err);
}

/// Three axes of a sensor and a transmitter at the origin; contact pressure and area; a tared force.
const POSE: &str =
    "p,x,y,z,pc,area,f\nkPa,mm,mm,mm,kPa,mm2,N\n0,30,0,40,0,0,0.5\n0,30,0,40,0,0,0.7\n20,33,0,44,37,424.4,1.6\n";

#[test]
fn derived_channels_are_computed_once_and_a_tare_is_told() {
    let sitting = Sitting::new();
    let channel = |c: &&str| {
        let more = match *c {
            "p" | "pc" => "reference = \"gauge\"\n",
            "f" => "tare_samples = 2\n",
            _ => "",
        };
        format!("[[channel]]\nid = \"{c}\"\ncolumn = \"{c}\"\n{more}")
    };
    let channels = ["p", "x", "y", "z", "pc", "area", "f"].iter().map(channel).collect::<Vec<_>>().concat();
    let derived = |id: &str, rule: &str, from: &str, unit: &str| {
        format!("[[derived]]\nid = \"{id}\"\nrule = \"{rule}\"\nfrom = [{from}]\nunit = \"{unit}\"\n")
    };
    let response = |id: &str, unit: &str| {
        format!(
            "[[response]]\nquantity = {{ id = \"{id}\", title = \"{id}\", unit = \"{unit}\" }}\n\
             pressure = [{{ channel = \"p\", chamber = \"air\" }}]\nmeasured = {{ channel = \"{id}\" }}\n"
        )
    };
    let text = format!(
        "schema = 1\nid = \"pose\"\nactuator = \"my-bellows\"\nsynthetic = true\n{channels}{}{}{}{}\n[[run]]\nfile = \"log.csv\"\n{}{}{}{}{}",
        derived("way", "displacement", "\"x\", \"y\", \"z\"", "mm"),
        derived("range", "transmitter-distance", "\"x\", \"y\", \"z\"", "mm"),
        derived("contact", "product", "\"pc\", \"area\"", "N"),
        derived("net", "difference", "\"f\", \"contact\"", "N"),
        response("way", "mm"),
        response("range", "mm"),
        response("contact", "N"),
        response("net", "N"),
        response("f", "N"),
    );
    sitting.write("session.toml", &text);
    sitting.write("log.csv", POSE);
    let said = sitting.validate();
    assert_eq!(said.code, 3, "{}", said.err);
    let results = sitting.results();
    let last = |comparison: usize| points(&results, comparison).last().unwrap()["measured"][0].as_f64().unwrap();
    // (3, 0, 4) from (30, 0, 40): 5 mm of way; from 50 to 55 mm of range.
    assert!((last(0) - 5e-3).abs() < 1e-15 && (last(1) - 5e-3).abs() < 1e-15);
    assert!((last(2) - 37e3 * 424.4e-6).abs() < 1e-12);
    // Tared by the mean of 0.5 and 0.7 N.
    assert!((last(4) - 1.0).abs() < 1e-12 && (last(3) - (1.0 - 15.7028)).abs() < 1e-9);
    assert!(findings(&results, "tared")[0]["text"].as_str().unwrap().contains("0.6 N"));
    assert!(said.err.contains("zero is the mean of its first 2 samples"), "{}", said.err);
    let page = fs::read_to_string(sitting.path().join("report/my-bellows.html")).unwrap();
    assert!(page.contains("Synthetic data"));
}

#[test]
fn a_position_is_judged_by_its_distance() {
    let sitting = Sitting::new();
    sitting.write(
        "actuator.toml",
        &ACTUATOR
            .replace(
                "{ id = \"stroke\", title = \"Stroke\", unit = \"mm\" }",
                "{ id = \"tip\", title = \"Tip\", unit = \"mm\", components = [\"x\", \"z\"] }",
            )
            .replace("predicted = \"u3\"\nstd = \"u3_std\"\n", "predicted = [\"ux\", \"uz\"]\n"),
    );
    sitting.write("fea.csv", "p,ux,uz\nkPa,mm,mm\n0,0,100\n40,40,80\n");
    sitting.write("log.csv", "p,x,z\nkPa,mm,mm\n0,0,100\n20,23,94\n40,40,80\n");
    sitting.write(
        "session.toml",
        "schema = 1\nid = \"tip\"\nactuator = \"my-bellows\"\n[[channel]]\nid = \"p\"\ncolumn = \"p\"\nreference = \"gauge\"\n\
         [[channel]]\nid = \"x\"\ncolumn = \"x\"\n[[channel]]\nid = \"z\"\ncolumn = \"z\"\n[[run]]\nfile = \"log.csv\"\n[[response]]\n\
         quantity = { id = \"tip\", title = \"Tip\", unit = \"mm\", components = [\"x\", \"z\"] }\n\
         pressure = [{ channel = \"p\", chamber = \"air\" }]\nmeasured = { channel = [\"x\", \"z\"] }\n",
    );
    let said = sitting.validate();
    assert_eq!(said.code, 3, "{}", said.err);
    let results = sitting.results();
    // (20, 90) predicted, (23, 94) measured: 3-4-5.
    assert!((points(&results, 0)[1]["residual"].as_f64().unwrap() - 5e-3).abs() < 1e-15);
    let metric = |id: &str| {
        let metrics = results["comparisons"][0]["metrics"].as_array().unwrap();
        metrics.iter().find(|m| m["metric"] == id).unwrap()["value"].as_f64()
    };
    assert!((metric("max_abs_error").unwrap() - 5e-3).abs() < 1e-15);
    assert!((metric("rmse").unwrap() - 5e-3 / 2.0_f64.sqrt()).abs() < 1e-15);
    assert_eq!(metric("bias"), None);
    assert!(sitting.path().join("report/results/figures/tip_tip_response.png").is_file());
}

#[test]
fn plateaus_of_a_clocked_log_are_points_and_a_gap_is_told() {
    let sitting = Sitting::new();
    let mut log = String::from("t_ms\tp_kPa\tmm\n");
    for i in 0..120 {
        // 2 s at 10 kPa, 1 s of ramp, 3 s at 20 kPa, at 20 Hz; half a second is missing in the second hold.
        let t = 50.0 * f64::from(i) + if i >= 90 { 500.0 } else { 0.0 };
        let p = 10.0 + (f64::from(i - 40) * 0.5).clamp(0.0, 10.0);
        writeln!(log, "{t}\t{p}\t{}", 0.5 * p + if i % 2 == 0 { 0.01 } else { -0.01 }).unwrap();
    }
    sitting.write("log.csv", &log);
    sitting.write(
        "session.toml",
        &SESSION
            .replace("[[channel]]\nid = \"pressure\"\ncolumn = \"pressure (kPa)\"", "[clock]\ncolumn = \"t_ms\"\nunit = \"ms\"\n[[channel]]\nid = \"pressure\"\ncolumn = \"p_kPa\"\nunit = \"kPa\"")
            .replace("column = \"stroke [mm]\"", "column = \"mm\"\nunit = \"mm\"")
            .replace(
                "method = \"laser\" }\n",
                "method = \"laser\" }\npoints = { from = \"plateaus\", tolerance = { value = 0.2, unit = \"kPa\" }, hold = { value = 1, unit = \"s\" }, window = { value = 0.5, unit = \"s\" } }\n",
            ),
    );
    let said = sitting.validate();
    assert_eq!(said.code, 3, "{}", said.err);
    let results = sitting.results();
    let found: Vec<(f64, f64)> = points(&results, 0)
        .iter()
        .map(|p| (p["pressures_gauge_pa"][0].as_f64().unwrap() / 1e3, p["measured"][0].as_f64().unwrap() * 1e3))
        .collect();
    // Nobody knows what happened in the gap: the hold at 20 kPa is two.
    assert_eq!(found.len(), 3, "{found:?}");
    for ((p, d), expected) in found.iter().zip([10.0, 20.0, 20.0]) {
        assert!((p - expected).abs() < 0.1 && (d - 0.5 * expected).abs() < 0.05, "{found:?}");
    }
    assert!(findings(&results, "gap")[0]["text"].as_str().unwrap().contains("550 ms"));
    let census = &results["actuators"][0]["datasets"][0]["session"]["responses"][0];
    assert_eq!((&census["samples"], &census["points"]), (&Value::from(120), &Value::from(3)));
}

/// The session with a clock in column `t`.
fn clocked() -> String {
    SESSION.replacen("[[channel]]", "[clock]\ncolumn = \"t\"\nunit = \"s\"\n\n[[channel]]", 1)
}

#[test]
fn a_sample_whose_stamp_goes_back_is_in_no_point() {
    let sitting = Sitting::new();
    sitting.write("session.toml", &clocked());
    // 39 mm at 30 kPa is stamped before what stands above it; an equal stamp is only noted.
    sitting.write(
        "log.csv",
        "t;pressure (kPa);stroke [mm]\n0;0;0,0\n1;10;5,2\n2;20;10,1\n1,5;30;39,0\n3;30;19,8\n3;40;30,5\n",
    );
    sitting.validate();
    let results = sitting.results();
    let measured: Vec<f64> = points(&results, 0).iter().map(|p| p["measured"][0].as_f64().unwrap() * 1e3).collect();
    assert_eq!(measured.len(), 5, "{measured:?}");
    assert!(measured.iter().all(|mm| *mm < 31.0), "{measured:?}");
    assert_eq!(results["comparisons"][0]["n_used"], 4);
    let session = &results["actuators"][0]["datasets"][0]["session"];
    assert_eq!((&session["samples_read"], &session["samples_excluded"]), (&6.into(), &1.into()));
    let census = &session["responses"][0];
    assert_eq!((&census["holes"], &census["used"]), (&1.into(), &5.into()));
    let back = findings(&results, "time-reversed")[0];
    assert_eq!((&back["severity"], &back["count"]), (&"excluded".into(), &1.into()));
    assert_eq!(back["spans"][0]["first_line"], 5);
    let twice = findings(&results, "duplicate-stamp")[0];
    assert_eq!((&twice["severity"], &twice["spans"][0]["first_line"]), (&"note".into(), &7.into()));
}

#[test]
fn a_sample_whose_stamp_goes_back_is_in_no_mean_of_a_plateau() {
    let sitting = Sitting::new();
    sitting.write(
        "session.toml",
        &clocked().replace(
            "method = \"laser\" }\n",
            "method = \"laser\" }\npoints = { from = \"plateaus\", tolerance = { value = 0.2, unit = \"kPa\" }, \
             hold = { value = 2, unit = \"s\" }, window = { value = 2, unit = \"s\" } }\n",
        ),
    );
    sitting.write(
        "log.csv",
        "t;pressure (kPa);stroke [mm]\n0;20;10,0\n1;20;10,1\n2;20;10,2\n0,5;20;99,0\n3;40;30,0\n4;40;30,1\n5;40;30,2\n",
    );
    sitting.validate();
    let results = sitting.results();
    let measured: Vec<f64> = points(&results, 0).iter().map(|p| p["measured"][0].as_f64().unwrap() * 1e3).collect();
    assert_eq!(measured.len(), 2, "{measured:?}");
    assert!((measured[0] - 10.1).abs() < 1e-9 && (measured[1] - 30.1).abs() < 1e-9, "{measured:?}");
    let census = &results["actuators"][0]["datasets"][0]["session"]["responses"][0];
    assert_eq!((&census["samples"], &census["holes"], &census["used"]), (&7.into(), &1.into(), &6.into()));
}

#[test]
fn rows_that_no_run_claims_are_told() {
    let sitting = Sitting::new();
    sitting.write(
        "log.csv",
        "run;pressure (kPa);stroke [mm]\nA;0;0,0\nA;20;10,1\nB;0;0,5\nB;20;11,0\nA;40;30,5\nC;40;33,0\n",
    );
    sitting.change(
        "session.toml",
        "file = \"log.csv\"",
        "file = \"log.csv\"\nrows = { column = \"run\", equals = \"A\" }",
    );
    sitting.validate();
    let results = sitting.results();
    assert_eq!(points(&results, 0).len(), 3);
    let told = findings(&results, "unclaimed-rows")[0];
    assert_eq!((&told["severity"], &told["count"], &told["file"]), (&"note".into(), &3.into(), &"log.csv".into()));
    let lines = |i: usize| (told["spans"][i]["first_line"].as_u64(), told["spans"][i]["last_line"].as_u64());
    assert_eq!([lines(0), lines(1)], [(Some(4), Some(5)), (Some(7), Some(7))]);
    assert!(told["text"].as_str().unwrap().contains("3 of 6 rows"), "{told}");
}

#[test]
fn a_log_copied_under_another_name_is_no_repeat() {
    let sitting = Sitting::new();
    sitting.write("again.csv", LOG);
    sitting.change("session.toml", "file = \"log.csv\"\n", "file = \"log.csv\"\n[[run]]\nfile = \"again.csv\"\n");
    let said = sitting.validate();
    assert_eq!(said.code, 2, "{}", said.out);
    for word in ["session.toml:17", "`again.csv`, byte for byte `log.csv`", "next:"] {
        assert!(said.err.contains(word), "{word}: {}", said.err);
    }
    assert!(!sitting.path().join("report").exists());
}

#[test]
fn an_absolute_pressure_takes_no_other_zero_than_the_atmosphere() {
    let sitting = Sitting::new();
    sitting.change("session.toml", "reference = \"gauge\"", "reference = \"absolute\"");
    sitting.change(
        "session.toml",
        "file = \"log.csv\"",
        "file = \"log.csv\"\natmosphere = { value = 101, unit = \"kPa\" }\nzero = { pressure = { value = 1, unit = \"kPa\" } }",
    );
    let said = sitting.validate();
    assert_eq!(said.code, 2, "{}", said.out);
    assert!(said.err.contains("session.toml:15") && said.err.contains("no zero for `pressure`"), "{}", said.err);
}

#[test]
fn a_unit_in_the_log_other_than_the_stated_one_is_told_and_the_users_word_counts() {
    let sitting = Sitting::new();
    // The channel says cm where the log says mm.
    sitting.change("session.toml", "column = \"stroke [mm]\"", "column = \"stroke [mm]\"\nunit = \"cm\"");
    sitting.validate();
    let results = sitting.results();
    let told = findings(&results, "unit-mismatch")[0];
    assert_eq!((&told["severity"], &told["channel"]), (&"note".into(), &"stroke".into()));
    assert!(told["text"].as_str().unwrap().contains("session.toml says cm, the log says mm; cm is taken"), "{told}");
    assert!((points(&results, 0)[4]["measured"][0].as_f64().unwrap() - 0.305).abs() < 1e-12);
    // The instrument puts out volts where the log says mm.
    let sitting = Sitting::new();
    sitting.change("session.toml", "actuator = ", "rig = \"bench\"\nactuator = ");
    sitting.change("session.toml", "id = \"stroke\"\ncolumn", "id = \"stroke\"\ninstrument = \"laser\"\ncolumn");
    let laser = "schema = 1\nid = \"bench\"\n[instrument.laser]\ninput = \"V\"\noutput = \"mm\"\n\
                 calibration = { kind = \"line\", slope = 2, offset = 0 }\n";
    sitting.write("rig.toml", laser);
    sitting.validate();
    let results = sitting.results();
    let told = findings(&results, "unit-mismatch")[0]["text"].as_str().unwrap().to_owned();
    assert!(told.contains("the instrument says V, the log says mm; V is taken"), "{told}");
    assert!((points(&results, 0)[4]["measured"][0].as_f64().unwrap() - 61e-3).abs() < 1e-12);
    // Millivolts are volts of another size: they are converted, and there is nothing to tell.
    sitting.write("log.csv", &LOG.replace("[mm]", "[mV]"));
    sitting.change("session.toml", "stroke [mm]", "stroke [mV]");
    sitting.validate();
    let results = sitting.results();
    assert!(findings(&results, "unit-mismatch").is_empty());
    assert!((points(&results, 0)[4]["measured"][0].as_f64().unwrap() - 61e-6).abs() < 1e-15);
}

#[test]
fn a_derived_channel_is_as_sure_as_its_sources() {
    let sitting = Sitting::new();
    let rig = "schema = 1\nid = \"bench\"\n[instrument.near]\ninput = \"mm\"\nstd = 0.03\n[instrument.far]\ninput = \"mm\"\nstd = 0.04\n\
               [instrument.pad]\ninput = \"kPa\"\nstd = 0.5\n[instrument.ruler]\ninput = \"mm2\"\nstd = 2\n";
    sitting.write("rig.toml", rig);
    sitting.write("log.csv", "p,a,b,pc,area\nkPa,mm,mm,kPa,mm2\n0,30,40,0,0\n20,33,44,40,400\n");
    let channel = |id: &str, more: &str| format!("[[channel]]\nid = \"{id}\"\ncolumn = \"{id}\"\n{more}\n");
    let derived = |id: &str, rule: &str, from: &str, unit: &str| {
        format!(
            "[[derived]]\nid = \"{id}\"\nrule = \"{rule}\"\nfrom = [{from}]\nunit = \"{unit}\"\n[[response]]\n\
             quantity = {{ id = \"{id}\", title = \"{id}\", unit = \"{unit}\" }}\n\
             pressure = [{{ channel = \"p\", chamber = \"air\" }}]\nmeasured = {{ channel = \"{id}\" }}\n"
        )
    };
    let text = [
        "schema = 1\nid = \"sure\"\nactuator = \"my-bellows\"\nrig = \"bench\"\n".to_owned(),
        channel("p", "reference = \"gauge\""),
        channel("a", "instrument = \"near\""),
        channel("b", "instrument = \"far\""),
        channel("pc", "instrument = \"pad\"\nreference = \"gauge\""),
        channel("area", "instrument = \"ruler\""),
        "[[run]]\nfile = \"log.csv\"\n".to_owned(),
        derived("apart", "difference", "\"b\", \"a\"", "mm"),
        derived("way", "displacement", "\"a\", \"b\"", "mm"),
        derived("range", "transmitter-distance", "\"a\", \"b\"", "mm"),
        derived("contact", "product", "\"pc\", \"area\"", "N"),
    ]
    .concat();
    sitting.write("session.toml", &text);
    sitting.validate();
    let results = sitting.results();
    let half = |i: usize| points(&results, i).last().unwrap()["measured_half_width"][0].as_f64().unwrap();
    // 1.96 of the standard uncertainty: 3-4-5; √2 of the less sure coordinate; 40 kPa × 2 mm² and 400 mm² × 0.5 kPa.
    assert!((half(0) - Z95 * 0.05e-3).abs() < 1e-15, "{}", half(0));
    for i in [1, 2] {
        assert!((half(i) - Z95 * 2.0_f64.sqrt() * 0.04e-3).abs() < 1e-15, "{}", half(i));
    }
    assert!((half(3) - Z95 * 0.08_f64.hypot(0.2)).abs() < 1e-12, "{}", half(3));
    // One source that declares nothing leaves all that comes from it without an interval.
    sitting.write("rig.toml", &rig.replace("std = 0.03\n", ""));
    sitting.validate();
    let results = sitting.results();
    for i in 0..3 {
        assert_eq!(points(&results, i).last().unwrap()["measured_half_width"], Value::Null);
    }
    assert!(points(&results, 3).last().unwrap()["measured_half_width"][0].as_f64() > Some(0.0));
}

/// An actuator of constant curvature whose angle is fitted, and a log with every pressure twice, nearly.
fn bender(hold_out: &str) -> Sitting {
    let sitting = Sitting::new();
    sitting.write(
        "actuator.toml",
        "schema = 1\nid = \"bender\"\ntype = \"constant-curvature\"\ntitle = \"Bender\"\nsummary = \"Bends.\"\n[chamber.chamber]\n\
         pressure_gauge_max = { value = 40, unit = \"kPa\", source = \"measured\" }\n[geometry]\n\
         angle_per_pressure = { value = 0.02, unit = \"rad/kPa\", source = \"assumed\", place = \"start of the fit\" }\n",
    );
    // 0.01 rad/kPa, but for the two near 20 kPa, which stand 0.1 rad above.
    sitting.write(
        "log.csv",
        "p,angle\nkPa,rad\n0,0\n10,0.1\n20,0.3\n30,0.3\n40,0.4\n10.1,0.101\n20.1,0.301\n30.1,0.301\n40.1,0.401\n",
    );
    sitting.write(
        "session.toml",
        &format!(
            "schema = 1\nid = \"bend\"\nactuator = \"bender\"\n[[channel]]\nid = \"p\"\ncolumn = \"p\"\nreference = \"gauge\"\n\
             [[channel]]\nid = \"angle\"\ncolumn = \"angle\"\n[[run]]\nfile = \"log.csv\"\n[[response]]\n\
             quantity = {{ id = \"bending-angle\", title = \"Angle\", unit = \"rad\" }}\nzero_within = {{ value = 0.3, unit = \"kPa\" }}\n\
             pressure = [{{ channel = \"p\", chamber = \"chamber\" }}]\nmeasured = {{ channel = \"angle\" }}\n\
             points = {{ from = \"samples\" }}\n[[comparison]]\n\
             quantity = \"bending-angle\"\nform = \"linear-angle\"\n\
             fit = {{ to = \"measured\", parameters = [\"angle_per_pressure\"], hold_out = \"{hold_out}\" }}\n"
        ),
    );
    let said = sitting.validate();
    assert_eq!(said.code, 3, "{}{}", said.out, said.err);
    sitting
}

#[test]
fn pressures_that_are_nearly_equal_are_held_out_together() {
    let kilopascals = |point: &Value| point["pressures_gauge_pa"][0].as_f64().unwrap() / 1e3;
    // Numbers 1 and 3 are 10 and 30 kPa, whichever of the two readings it is.
    let results = bender("odd-pressures").results();
    assert_eq!(points(&results, 0).len(), 9, "zero, and every other pressure twice");
    for point in points(&results, 0) {
        let expected = match kilopascals(point) {
            p if p < 1.0 => "zero_reference",
            p if [10.0, 30.0].iter().any(|odd| (p - odd).abs() < 1.0) => "used",
            _ => "in_fit",
        };
        assert_eq!(point["status"], expected, "{point}");
    }
    // With both readings near 20 kPa left out the others lie on a line, and it is that line.
    let results = bender("one-pressure").results();
    let mut seen = 0;
    for point in points(&results, 0).iter().filter(|p| (kilopascals(p) - 20.0).abs() < 1.0) {
        let predicted = point["predicted"][0].as_f64().unwrap();
        assert!((predicted - 0.01 * kilopascals(point)).abs() < 1e-9, "{point}");
        seen += 1;
    }
    assert_eq!(seen, 2);
}

#[test]
fn data_that_no_fit_can_use_leave_their_comparison_open_and_the_others_alone() {
    let sitting = bender("one-pressure");
    // One pressure beside zero: none is left to fit when it is held out. The remark asks for what was to be fitted.
    sitting.write("log.csv", "p,angle\nkPa,rad\n0,0\n10,0.2\n10.1,0.202\n");
    sitting.change(
        "session.toml",
        "fit = {",
        "remark = \"fitted: {{ fit.angle_per_pressure }}, {{ fit.rmse }}\"\nfit = {",
    );
    let session = fs::read_to_string(sitting.path().join("session.toml")).unwrap();
    let other = "[[comparison]]\nquantity = \"bending-angle\"\nform = \"as-given\"\nmodel = \"linear-angle\"\n";
    sitting.write("session.toml", &(session + other));
    let bound = |form: &str| {
        format!(
            "[[bound]]\nactuator = \"bender\"\nquantity = \"bending-angle\"\nmodel = \"{form}\"\nmetric = \"max_abs_error\"\n\
             max = {{ value = 1, unit = \"rad\" }}\nreason = \"a test\"\nallow_single_repeat = true\n"
        )
    };
    sitting.write("bounds.toml", &format!("schema = 1\n{}{}", bound("linear-angle"), bound("as-given")));
    sitting.change("session.toml", "actuator = ", "rig = \"bench\"\nactuator = ");
    sitting.change("session.toml", "column = \"angle\"", "column = \"angle\"\ninstrument = \"encoder\"");
    sitting.write("rig.toml", "schema = 1\nid = \"bench\"\n[instrument.encoder]\ninput = \"rad\"\nstd = 0.001\n");
    for (hold_out, why) in
        [("one-pressure", "too few pressures beside zero"), ("odd-pressures", "least squares needs at least as many")]
    {
        if hold_out == "odd-pressures" {
            // Number 1 is judged; what is left to fit is the zero, which is no point of a fit.
            sitting.change("session.toml", "one-pressure", hold_out);
        }
        let said = sitting.validate();
        assert_eq!(said.code, 3, "{}{}", said.out, said.err);
        let results = sitting.results();
        let [fitted, given] = &results["comparisons"].as_array().unwrap()[..] else { panic!("{results}") };
        assert_eq!((&fitted["verdict"], &given["verdict"]), (&"inconclusive".into(), &"pass".into()), "{results}");
        let sentence = fitted["sentence"].as_str().unwrap();
        assert!(sentence.contains("the fit failed: ") && sentence.contains(why), "{sentence}");
        assert_eq!(fitted["remark"], "fitted: no value, no value");
        assert!(fitted["fit"].is_null() && fitted["metrics"][0]["value"].is_null(), "{fitted}");
        for point in points(&results, 0) {
            assert!(point["predicted"].is_null() && point["reason"].as_str().unwrap().contains(why), "{point}");
        }
        assert_eq!(pneuval(sitting.path(), &["gate", "report"]).code, 3);
        let said = pneuval(sitting.path(), &["export", ".", "--out", "out", "--format", "csv"]);
        assert!(said.code == 0 && said.out.contains("Left out: linear-angle of bending-angle: "), "{}", said.out);
    }
    // Without a bound the reason is told as well.
    fs::remove_file(sitting.path().join("bounds.toml")).unwrap();
    assert_eq!(sitting.validate().code, 3);
    let fitted = &sitting.results()["comparisons"][0];
    assert_eq!(fitted["verdict"], "unjudged");
    assert!(fitted["sentence"].as_str().unwrap().starts_with("the fit failed: "), "{fitted}");
    // What the user wrote is still the user's to mend.
    for (file, from, to, word) in [
        ("session.toml", "[\"angle_per_pressure\"]", "[\"angle_per_presure\"]", "did you mean `angle_per_pressure`?"),
        ("actuator.toml", "value = 0.02", "value = 0", "start value = 0 is outside its domain"),
    ] {
        let before = fs::read_to_string(sitting.path().join(file)).unwrap();
        sitting.change(file, from, to);
        let said = sitting.validate();
        assert!(said.code == 2 && said.err.contains(word), "{} {}", said.code, said.err);
        sitting.write(file, &before);
    }
}

#[test]
fn a_fit_that_a_wrong_sign_spoils_does_not_hide_the_findings() {
    let folder = tempfile::tempdir().unwrap();
    let fault = ["--repeats", "1", "--fault", "wrong-sign@pressure"];
    let rehearsal = [["rehearse", "fruit-finger", "--out", "bench"].as_slice(), &fault].concat();
    assert_eq!(pneuval(folder.path(), &rehearsal).code, 0);
    let said = pneuval(folder.path(), &["validate", "bench", "--out", "report", "--no-figures"]);
    assert_eq!(said.code, 3, "{}", said.err);
    assert!(said.err.contains("run-1"), "{}", said.err);
    let results = fs::read(folder.path().join("report/results/results.json")).unwrap();
    let results: Value = serde_json::from_slice(&results).unwrap();
    assert!(!findings(&results, "command-mismatch").is_empty() && !findings(&results, "out-of-range").is_empty());
    let all = results["comparisons"].as_array().unwrap();
    let failed = |c: &&Value| c["sentence"].as_str().unwrap().contains("the fit failed: ");
    assert!(all.iter().any(|c| failed(&c)) && all.iter().any(|c| c["n_used"] != 0), "{all:?}");
}

#[test]
fn mistakes_in_a_session_are_told_by_file_line_and_next_step() {
    for (file, from, to, place, word) in [
        ("session.toml", "actuator = \"my-bellows\"", "actuator = \"FILL-IN\"", "session.toml:3", "pneuval models"),
        (
            "session.toml",
            "actuator = \"my-bellows\"",
            "actuator = \"my-belows\"",
            "session.toml",
            "actuator.toml of that id",
        ),
        (
            "session.toml",
            "column = \"stroke [mm]\"",
            "column = \"stroke\"",
            "session.toml:11",
            "did you mean `stroke [mm]`?",
        ),
        ("session.toml", "column = \"stroke [mm]\"", "column = 3", "session.toml:11", "column 3 of 2"),
        ("session.toml", "column = \"stroke [mm]\"", "column = 0", "session.toml:12", "its number from 1"),
        (
            "session.toml",
            "column = \"stroke [mm]\"",
            "column = \"stroke [mm]\"\nunit = \"kPa\"\nreference = \"gauge\"",
            "session.toml:20",
            "channel `stroke` as a length",
        ),
        (
            "session.toml",
            "id = \"stroke\"\ncolumn",
            "id = \"pressure\"\ncolumn",
            "session.toml:11",
            "every channel once",
        ),
        ("session.toml", "file = \"log.csv\"", "file = \"../log.csv\"", "session.toml:15", "inside this folder"),
        ("session.toml", "file = \"log.csv\"", "file = \"log9.csv\"", "log9.csv", "cannot be read"),
        (
            "session.toml",
            "file = \"log.csv\"\n",
            "file = \"log.csv\"\n[[run]]\nfile = \"gone.csv\"\n",
            "gone.csv",
            "cannot be read",
        ),
        (
            "session.toml",
            "file = \"log.csv\"\n",
            "id = \"a\"\nfile = \"log.csv\"\n[[run]]\nid = \"b\"\nfile = \"log.csv\"\nrows = { column = 1, equals = \"20\" }\n",
            "session.toml:19",
            "line 4 in run a too",
        ),
        ("session.toml", "channel = \"stroke\"", "channel = \"stroek\"", "session.toml:20", "did you mean `stroke`?"),
        ("session.toml", "chamber = \"air\"", "chambre = \"air\"", "session.toml:19", "did you mean `chamber`?"),
        ("session.toml", "[[run]]\nfile = \"log.csv\"\n", "", "session.toml:2", "at least one [[run]]"),
        (
            "session.toml",
            "id = \"stroke\"\ncolumn",
            "id = \"stroke\"\ninstrument = \"laser\"\ncolumn",
            "session.toml:11",
            "rig",
        ),
        (
            "session.toml",
            "method = \"laser\" }",
            "method = \"laser\" }\npoints = { from = \"plateaus\" }",
            "session.toml:21",
            "`tolerance`, `hold` and `window`",
        ),
        (
            "session.toml",
            "method = \"laser\" }",
            "method = \"laser\" }\n[[comparison]]\nquantity = \"stroke\"\nform = \"ansys\"",
            "session.toml:23",
            "use one of: abaqus",
        ),
        (
            "session.toml",
            "method = \"laser\" }",
            "method = \"laser\" }\npoints = { from = \"plateaus\", same_within = { value = 1, unit = \"kPa\" }, tolerance = { value = 1, unit = \"kPa\" }, hold = { value = 1, unit = \"s\" }, window = { value = 1, unit = \"s\" } }\n[clock]\nrate = { value = 1, unit = \"Hz\" }",
            "session.toml:21",
            "no `same_within` beside from = \"plateaus\"",
        ),
        ("actuator.toml", "chamber = \"air\"", "chamber = \"water\"", "session.toml", "chamber water"),
        ("fea.csv", "20,10.0", "x,10.0", "fea.csv:4: column `p`", "a number"),
        ("fea.csv", "20,10.0", "50,10.0", "fea.csv:5: column `p`", "pressures that rise"),
        ("fea.csv", "40,30.0", "40,", "fea.csv:5: column `u3`", "a number in every row"),
    ] {
        let sitting = Sitting::new();
        sitting.change(file, from, to);
        let said = sitting.validate();
        assert_eq!(said.code, 2, "{to}: {}{}", said.out, said.err);
        assert!(said.err.contains(place) && said.err.contains(word), "{to}: {}", said.err);
        assert!(said.err.contains("next:") || word == "cannot be read", "{}", said.err);
        assert!(!sitting.path().join("report").exists(), "{to}");
    }
}
