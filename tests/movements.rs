//! Movements, asked of the built binary: where a measured path meets a predicted one, and how far apart they are there.

// In a test a panic is how a failure is told.
#![allow(clippy::unwrap_used, clippy::panic)]

mod common;

use std::fmt::Write as _;
use std::fs;

use serde_json::Value;
use tempfile::TempDir;

use common::sitting::findings;
use common::{Said, pneuval};

const SESSION: &str = r#"schema = 1
id = "wave"
actuator = "arm"
rig = "bench"

[clock]
column = "t"
unit = "s"

[[channel]]
id = "x"
column = "x"
instrument = "camera"

[[channel]]
id = "y"
column = "y"
instrument = "camera"

[[channel]]
id = "z"
column = "z"
instrument = "camera"

[[run]]
id = "a"
file = "log.csv"

[[response]]
quantity = { id = "tip", title = "Tip position", unit = "mm", components = ["x", "y", "z"] }
measured = { channel = ["x", "y", "z"], method = "camera" }
points = { from = "trajectory", at = "time" }

[[comparison]]
quantity = "tip"
form = "sim"
"#;

const RIG: &str = "schema = 1\nid = \"bench\"\n[instrument.camera]\ninput = \"mm\"\noutput = \"mm\"\nstd = 0.0001\n";

const ACTUATOR: &str = r#"schema = 1
id = "arm"
title = "Arm"

[[model]]
kind = "imported"
form = "sim"
title = "Simulator"
quantity = { id = "tip", title = "Tip position", unit = "mm", components = ["x", "y", "z"] }
file = "sim.csv"
time = { column = "t" }
predicted = ["x", "y", "z"]
"#;

/// Two turns of a helix in 4 s, in mm.
fn helix(t: f64) -> [f64; 3] {
    let angle = std::f64::consts::PI * t;
    [30.0 * angle.cos(), 30.0 * angle.sin(), 10.0 * t]
}

/// A table of positions: stamps in s from `first` on, `step` apart.
fn table(delimiter: char, (first, step, count): (f64, f64, u32), of: impl Fn(f64) -> [f64; 3]) -> String {
    let mut text =
        ["t", "x", "y", "z\n"].join(&delimiter.to_string()) + &["s", "mm", "mm", "mm\n"].join(&delimiter.to_string());
    for i in 0..count {
        let t = first + step * f64::from(i);
        let [x, y, z] = of(t);
        let cells = [t, x, y, z].map(|v| format!("{v:.9}"));
        writeln!(text, "{}", cells.join(&delimiter.to_string())).unwrap();
    }
    text
}

struct Wave {
    folder: TempDir,
}

impl Wave {
    /// A measured helix at 100 Hz for 4 s, and a prediction.
    fn new(sim: &str) -> Self {
        let wave = Self { folder: tempfile::tempdir().unwrap() };
        for (name, text) in
            [("session.toml", SESSION), ("rig.toml", RIG), ("actuator.toml", ACTUATOR), ("sim.csv", sim)]
        {
            wave.write(name, text);
        }
        wave.write("log.csv", &table(';', (0.0, 0.01, 401), helix));
        wave
    }

    fn write(&self, name: &str, text: &str) {
        fs::write(self.folder.path().join(name), text).unwrap();
    }

    fn change(&self, name: &str, from: &str, to: &str) {
        let text = fs::read_to_string(self.folder.path().join(name)).unwrap();
        assert!(text.contains(from), "{name} has no {from:?}");
        self.write(name, &text.replacen(from, to, 1));
    }

    /// A bound on the RMSE, which one repeat may meet.
    fn bound(&self, max: f64) {
        self.write(
            "bounds.toml",
            &format!(
                "schema = 1\n[[bound]]\nactuator = \"arm\"\nquantity = \"tip\"\nmodel = \"sim\"\nmetric = \"rmse\"\n\
                 max = {{ value = {max:?}, unit = \"mm\" }}\nreason = \"a test\"\nallow_single_repeat = true\n"
            ),
        );
    }

    fn validate(&self) -> (Said, Value) {
        let said = pneuval(self.folder.path(), &["validate", ".", "--out", "report", "--no-figures"]);
        let bytes =
            fs::read(self.folder.path().join("report/results/results.json")).unwrap_or_else(|_| b"null".to_vec());
        (said, serde_json::from_slice(&bytes).unwrap())
    }
}

fn metric(results: &Value, id: &str) -> Value {
    let metrics = results["comparisons"][0]["metrics"].as_array().unwrap();
    metrics.iter().find(|m| m["metric"] == id).unwrap()["value"].clone()
}

fn near(value: &Value, expected: f64, within: f64) {
    let found = value.as_f64().unwrap_or(f64::NAN);
    assert!((found - expected).abs() <= within, "{found} is not {expected} within {within}");
}

/// The helix in another frame: turned by 30 degrees about z, then shifted.
fn moved(t: f64) -> [f64; 3] {
    let [x, y, z] = helix(t);
    let (s, c) = 30_f64.to_radians().sin_cos();
    [c * x - s * y + 5.0, s * x + c * y - 7.0, z + 2.0]
}

#[test]
fn a_rigid_alignment_finds_the_known_transform_and_tells_it() {
    // Stamps of its own, between those of the log.
    let wave = Wave::new(&table(',', (0.005, 0.02, 199), moved));
    wave.bound(0.1);
    let (said, results) = wave.validate();
    assert_eq!(said.code, 1, "{}{}", said.out, said.err);
    let square = |i: u32| {
        let t = 0.005 + 0.02 * f64::from(i);
        moved(t).iter().zip(helix(t)).map(|(a, b)| (a - b).powi(2)).sum::<f64>()
    };
    let apart = ((0..199).map(square).sum::<f64>() / 199.0).sqrt();
    near(&metric(&results, "rmse"), 1e-3 * apart, 5e-6);
    wave.change("session.toml", "form = \"sim\"", "form = \"sim\"\nalign = \"rigid\"");
    let (said, results) = wave.validate();
    // What the tracker declares is the same in all its readings: turned and shifted onto them, nothing of it is left to judge by.
    assert_eq!(said.code, 3, "{}{}", said.out, said.err);
    assert!(said.out.contains("takes out all that is declared to be uncertain"), "{}", said.out);
    let alignment = &results["comparisons"][0]["alignment"];
    // The prediction is turned back.
    near(&alignment["rotation_deg"], 30.0, 1e-3);
    near(&alignment["rotation_axis"][2], -1.0, 1e-6);
    let (s, c) = (-30_f64).to_radians().sin_cos();
    for (i, expected) in [-(c * 5.0 + s * 7.0), -(s * 5.0 - c * 7.0), -2.0].into_iter().enumerate() {
        near(&alignment["translation_si"][i], 1e-3 * expected, 1e-6);
    }
    // A chord of 10 ms stays 30 mm (1 - cos 0.9 deg) within its arc, and that is all that is left.
    near(&alignment["rmse_after_si"], 0.0, 5e-6);
    assert!(alignment["rmse_before_si"].as_f64().unwrap() > 5e-3, "{alignment}");
    let sentence = results["comparisons"][0]["sentence"].as_str().unwrap();
    assert!(
        sentence.contains("turned by 30.0") && sentence.contains("199 of 199 met, overlap 100.000 %"),
        "{sentence}"
    );
    let page = fs::read_to_string(wave.folder.path().join("report/arm.html")).unwrap();
    assert!(
        page.contains("rigidly aligned") && page.contains("aligned to the measurement"),
        "the page does not tell it"
    );
    let again = pneuval(wave.folder.path(), &["gate", "report"]);
    assert_eq!(again.code, 3, "{}{}", again.out, again.err);
}

#[test]
fn a_prediction_that_lies_on_a_line_does_not_say_how_it_is_turned() {
    let wave = Wave::new(&table(',', (0.0, 0.02, 200), |t| [3.0 * t, 2.0 * t, t]));
    wave.change("session.toml", "form = \"sim\"", "form = \"sim\"\nalign = \"rigid\"");
    wave.bound(1.0);
    let (said, results) = wave.validate();
    assert_eq!(said.code, 3, "{}{}", said.out, said.err);
    let sentence = results["comparisons"][0]["sentence"].as_str().unwrap();
    assert!(
        sentence.contains("the rotation is not determined: the predicted points lie on a straight line"),
        "{sentence}"
    );
    wave.change("session.toml", "align = \"rigid\"", "align = \"origin\"");
    let (_, results) = wave.validate();
    near(&results["comparisons"][0]["alignment"]["translation_si"][0], 0.03, 1e-9);
}

#[test]
fn a_shifted_clock_is_an_error_of_the_speed_times_the_shift() {
    let wave = Wave::new(&table(',', (0.2, 0.02, 180), |t| helix(t - 0.1)));
    wave.bound(5.0);
    let (said, results) = wave.validate();
    assert_eq!(said.code, 1, "{}{}", said.out, said.err);
    // 100 ms late: a chord of 18 degrees of the circle, and 1 mm of rise. Nothing was shifted.
    let expected = (60.0 * 9_f64.to_radians().sin()).hypot(1.0);
    near(&metric(&results, "rmse"), 1e-3 * expected, 2e-5);
    // Declared, it is taken out.
    wave.change("actuator.toml", "{ column = \"t\" }", "{ column = \"t\", offset = { value = -100, unit = \"ms\" } }");
    let (said, results) = wave.validate();
    assert_eq!(said.code, 0, "{}{}", said.out, said.err);
    near(&metric(&results, "rmse"), 0.0, 1e-5);
}

#[test]
fn half_a_percent_of_overlap_is_no_small_error() {
    for points in ["at = \"time\"", "at = \"time\", match = \"nearest\", within = { value = 1, unit = \"ms\" }"] {
        // The prediction begins 20 ms before the log ends.
        let wave = Wave::new(&table(',', (3.98, 0.01, 401), helix));
        wave.change("session.toml", "at = \"time\"", points);
        wave.bound(5.0);
        let (said, results) = wave.validate();
        assert_eq!(said.code, 3, "{}{}", said.out, said.err);
        assert_eq!(metric(&results, "rmse"), Value::Null);
        // Nothing of the little that met is left where a reader would take it for the whole.
        let comparison = &results["comparisons"][0];
        for metric in comparison["metrics"].as_array().unwrap() {
            for key in ["value", "lower", "upper", "uncorrected", "method"] {
                assert_eq!(metric[key], Value::Null, "{metric}");
            }
            assert_eq!(metric["shares"], serde_json::json!([]));
        }
        assert_eq!((&comparison["budget"], &comparison["validation"]), (&serde_json::json!([]), &Value::Null));
        let overlap = results["comparisons"][0]["meeting"]["overlap"].as_f64().unwrap();
        assert!((0.004..0.008).contains(&overlap), "{overlap}");
        let told = format!("only {:.3} % of the shorter series overlaps", 100.0 * overlap);
        assert!(said.out.contains(&told) && said.out.contains("3/401"), "{}", said.out);
        // Nor when the stored results are judged again.
        assert_eq!(pneuval(wave.folder.path(), &["gate", "report"]).code, 3);
    }
}

#[test]
fn clocks_without_an_instant_in_common_are_told_with_their_ranges() {
    let wave = Wave::new(&table(',', (1000.0, 0.01, 401), helix));
    wave.bound(5.0);
    let (said, _) = wave.validate();
    assert_eq!(said.code, 3, "{}{}", said.out, said.err);
    assert!(
        said.out.contains("measured from 0.000 s to 4.000 s, predicted from 1000.000 s to 1004.000 s"),
        "{}",
        said.out
    );
}

#[test]
fn nothing_is_interpolated_across_a_gap_or_between_identical_stamps() {
    let wave = Wave::new(&table(',', (0.0, 0.02, 201), helix));
    wave.bound(0.1);
    let log = fs::read_to_string(wave.folder.path().join("log.csv")).unwrap();
    // A second is missing, and the sample at 3 s stands twice, with another value.
    let kept =
        |line: &&str| !(1.005..1.995).contains(&line.split(';').next().and_then(|t| t.parse().ok()).unwrap_or(-1.0));
    let mut log: Vec<String> = log.lines().filter(kept).map(str::to_owned).collect();
    let twice = log.iter().position(|line| line.starts_with("3.000000000;")).unwrap();
    log.insert(twice + 1, "3.000000000;900;900;900".to_owned());
    wave.write("log.csv", &(log.join("\n") + "\n"));
    let (_, results) = wave.validate();
    let run = &results["comparisons"][0]["meeting"]["runs"][0];
    assert_eq!((&run["n_in_gaps"], &run["n_at_doubled_stamps"]), (&49.into(), &1.into()), "{run}");
    assert_eq!(run["n_matched"], 151);
    near(&run["overlap"], 0.75, 1e-9);
    // The 900 mm touch the next stamp's neighbours only.
    near(&run["gap_s"], 0.05, 1e-9);
    let told = findings(&results, "meeting");
    assert_eq!(told.len(), 2, "{told:?}");
    // A longer gap may be allowed, and is then a chord.
    wave.change("session.toml", "at = \"time\"", "at = \"time\", gap = { value = 2, unit = \"s\" }");
    let (_, results) = wave.validate();
    assert_eq!(results["comparisons"][0]["meeting"]["runs"][0]["n_matched"], 200);
}

#[test]
fn holes_shorten_no_series() {
    let wave = Wave::new(&table(',', (0.0, 1.0, 5), helix));
    wave.write("log.csv", "t;x;y;z\ns;mm;mm;mm\n0;30;0;0\n1;-30;0;10\n2;;;\n3;;;\n4;;;\n");
    wave.change("session.toml", "rig = \"bench\"", "rig = \"bench\"\nexcluded_max = { value = 90, unit = \"%\" }");
    wave.bound(5.0);
    let (said, results) = wave.validate();
    assert_eq!(said.code, 3, "{}{}", said.out, said.err);
    assert_eq!(metric(&results, "rmse"), Value::Null);
    assert!(said.out.contains("only 25.000 % of the shorter series"), "{}", said.out);
}

#[test]
fn equal_arc_length_asks_for_no_clock_and_compares_shapes() {
    // The same helix, twice as fast, in steps that shorten: the path is the same.
    let wave = Wave::new(&table(',', (0.0, 0.01, 201), |t| helix(2.0 * t)));
    wave.change("session.toml", "at = \"time\"", "at = \"arc-length\"");
    wave.change("session.toml", "[clock]\ncolumn = \"t\"\nunit = \"s\"\n", "");
    wave.bound(0.1);
    let (said, results) = wave.validate();
    assert_eq!(said.code, 0, "{}{}", said.out, said.err);
    let comparison = &results["comparisons"][0];
    assert_eq!(comparison["against"], "arc_length");
    near(&comparison["points"][100]["at"], 0.5, 1e-6);
    let length = 4e-3 * (30.0 * std::f64::consts::PI).hypot(10.0);
    near(&comparison["meeting"]["runs"][0]["measured_length_si"], length, 1e-4);
}

#[test]
fn a_path_over_falling_pressures_goes_as_its_rows_do() {
    let wave = Wave::new("");
    let mut sim = "p,x,y,z\nkPa,mm,mm,mm\n".to_owned();
    for i in 0..201 {
        let [x, y, z] = helix(0.02 * f64::from(i));
        writeln!(sim, "{},{x},{y},{z}", 200 - i).unwrap();
    }
    wave.write("sim.csv", &sim);
    wave.change(
        "actuator.toml",
        "time = { column = \"t\" }",
        "pressure = { column = \"p\", chamber = \"air\", reference = \"gauge\" }",
    );
    wave.change("session.toml", "at = \"time\"", "at = \"arc-length\"");
    wave.bound(0.1);
    let (said, _) = wave.validate();
    assert_eq!(said.code, 0, "{}{}", said.out, said.err);
}

#[test]
fn samples_of_a_movement_are_no_repeats_and_the_sentence_says_what_they_are_matched_by() {
    for (at, equal) in [("time", "time"), ("arc-length", "arc length")] {
        let wave = Wave::new(&table(',', (0.0, 0.02, 201), helix));
        wave.change("rig.toml", "std = 0.0001", "std = 0.1");
        wave.change("session.toml", "at = \"time\"", &format!("at = \"{at}\""));
        // The same movement again, with a last digit of its own.
        wave.write("second.csv", &table(';', (0.0, 0.01, 401), |t| helix(t).map(|v| v + 1e-6)));
        let two = "file = \"log.csv\"\n[[run]]\nid = \"b\"\nfile = \"second.csv\"\n";
        wave.change("session.toml", "file = \"log.csv\"\n", two);
        wave.bound(5.0);
        wave.change("bounds.toml", "allow_single_repeat = true\n", "");
        let (said, results) = wave.validate();
        assert_eq!(said.code, 3, "{}{}", said.out, said.err);
        let told = format!("from single samples, matched at equal {equal}, which have no scatter to judge by");
        assert!(said.out.contains(&told), "{}", said.out);
        let comparison = &results["comparisons"][0];
        // The camera's three channels, each of which moves one component of three; no scatter of repeats.
        let budget = comparison["budget"].as_array().unwrap();
        assert_eq!(budget.len(), 3, "{budget:?}");
        for row in budget {
            assert_eq!(row["cause"], "instrument");
            near(&row["std_rms_si"], 1e-4 / 3_f64.sqrt(), 1e-9);
        }
        assert_eq!(comparison["points"][0]["repeats"], 1);
        assert_eq!(comparison["samples_alone"], true);
    }
}

#[test]
fn what_is_uncertain_of_a_prediction_is_turned_with_it_and_a_common_offset_is_none_when_aligned() {
    // The simulator's first axis is the camera's second, on which the two differ; it alone is uncertain, of every second row.
    let largest = largest_of_turned(["0.3", "0"], 0);
    // Aligned, half of the offset of half of the rows is left: 0.5 + 1.96 · 0.15 mm.
    near(&largest["upper"], 7.94e-4, 2e-5);
    // As far off in every row: then the alignment takes all of it, and nothing says how sure the rest is.
    let largest = largest_of_turned(["0.3", "0.3"], 3);
    near(&largest["value"], 5e-4, 1e-5);
    assert!(largest["upper"].is_null() && largest["lower"].is_null(), "{largest}");
}

/// The largest distance of a turned simulation, aligned rigidly, whose first component has these standard uncertainties in turn, in mm.
fn largest_of_turned(std: [&str; 2], code: i32) -> Value {
    let mut sim = "t,x,y,z,sx,s0\ns,mm,mm,mm,mm,mm\n".to_owned();
    for i in 0..201 {
        let t = 0.02 * f64::from(i);
        let [x, y, z] = helix(t);
        let off = if i % 2 == 0 { 0.5 } else { -0.5 };
        writeln!(sim, "{t},{},{},{z},{},0", y + off, -x, if i % 2 == 0 { std[0] } else { std[1] }).unwrap();
    }
    let wave = Wave::new(&sim);
    wave.change(
        "actuator.toml",
        "predicted = [\"x\", \"y\", \"z\"]",
        "predicted = [\"x\", \"y\", \"z\"]\nstd = [\"sx\", \"s0\", \"s0\"]",
    );
    wave.change("session.toml", "form = \"sim\"", "form = \"sim\"\nalign = \"rigid\"");
    wave.bound(5.0);
    let (said, results) = wave.validate();
    assert_eq!(said.code, code, "{}{}", said.out, said.err);
    let metrics = results["comparisons"][0]["metrics"].as_array().unwrap();
    let largest = metrics.iter().find(|m| m["metric"] == "max_abs_error").unwrap();
    near(&largest["value"], 5e-4, 1e-5);
    largest.clone()
}

#[test]
fn runs_meet_the_prediction_each_on_its_own() {
    let wave = Wave::new(&table(',', (0.0, 0.02, 201), helix));
    // The second run's stamps are others, and it lies 1 mm higher.
    wave.write("second.csv", &table(';', (0.003, 0.01, 399), |t| helix(t).map(|v| v + 1.0)));
    wave.change(
        "session.toml",
        "file = \"log.csv\"\n",
        "file = \"log.csv\"\n[[run]]\nid = \"b\"\nfile = \"second.csv\"\n",
    );
    wave.bound(0.1);
    let (said, results) = wave.validate();
    assert_eq!(said.code, 1, "{}{}", said.out, said.err);
    let points = results["comparisons"][0]["points"].as_array().unwrap();
    let of = |run: &str| points.iter().filter(|p| p["runs"][0] == run).count();
    assert_eq!((of("a"), of("b")), (201, 199));
    near(&metric(&results, "max_abs_error"), 1e-3 * 3_f64.sqrt(), 2e-5);
}

#[test]
fn a_path_over_pressure_is_compared_sample_by_sample_loading_and_unloading_alike() {
    let wave = Wave::new("");
    wave.write("sim.csv", "p,x,y,z\nkPa,mm,mm,mm\n0,0,0,0\n40,40,0,20\n");
    wave.change(
        "actuator.toml",
        "time = { column = \"t\" }",
        "pressure = { column = \"p\", chamber = \"air\", reference = \"gauge\" }",
    );
    let mut log = "t;x;y;z;p\ns;mm;mm;mm;kPa\n".to_owned();
    for i in 0..81 {
        let p = 40.0 - (40.0 - f64::from(i)).abs();
        let lag = if i > 40 { 2.0 } else { 0.0 };
        writeln!(log, "{};{};0;{};{p}", 0.1 * f64::from(i), p + lag, 0.5 * p).unwrap();
    }
    wave.write("log.csv", &log);
    wave.change(
        "session.toml",
        "[[run]]",
        "[[channel]]\nid = \"p\"\ncolumn = \"p\"\nunit = \"kPa\"\nreference = \"gauge\"\n\n[[run]]",
    );
    wave.change(
        "session.toml",
        "at = \"time\" }",
        "at = \"pressure\" }\npressure = [{ channel = \"p\", chamber = \"air\" }]",
    );
    wave.bound(5.0);
    let (said, results) = wave.validate();
    assert_eq!(said.code, 0, "{}{}", said.out, said.err);
    let comparison = &results["comparisons"][0];
    // The two samples at zero are the reference.
    assert_eq!((&comparison["n_used"], &comparison["n_available"]), (&79.into(), &81.into()));
    near(&metric(&results, "max_abs_error"), 2e-3, 1e-9);
    wave.change("session.toml", "at = \"pressure\"", "at = \"pressure\", every = 10");
    let (_, results) = wave.validate();
    assert_eq!(results["comparisons"][0]["n_available"], 9);
}

#[test]
fn what_a_trajectory_cannot_heed_is_refused_where_it_stands() {
    let sim = table(',', (0.0, 0.02, 201), helix);
    for (file, from, to, place, words) in [
        ("session.toml", "at = \"time\"", "match = \"nearest\"", "session.toml:32", "`at` beside from"),
        ("session.toml", "at = \"time\"", "at = \"time\", match = \"nearest\"", "session.toml:32", "`within` beside"),
        (
            "session.toml",
            "at = \"time\"",
            "at = \"arc-length\", within = { value = 1, unit = \"s\" }",
            "session.toml:32",
            "no `within`",
        ),
        (
            "session.toml",
            "at = \"time\"",
            "at = \"time\", hold = { value = 1, unit = \"s\" }",
            "session.toml:32",
            "no `hold` beside",
        ),
        (
            "session.toml",
            "at = \"time\" }",
            "at = \"time\" }\ncycles = \"all\"",
            "session.toml:33",
            "no `cycles` beside at = \"time\"",
        ),
        (
            "session.toml",
            "method = \"camera\"",
            "method = \"camera\", tare = \"zero-pressure\"",
            "session.toml:31",
            "no `tare` beside at = \"time\"",
        ),
        (
            "session.toml",
            "from = \"trajectory\", at = \"time\"",
            "from = \"samples\"",
            "session.toml:30",
            "at least one pressure",
        ),
        (
            "session.toml",
            "[clock]\ncolumn = \"t\"\nunit = \"s\"\n",
            "",
            "session.toml",
            "a clock, to compare at equal time by",
        ),
        ("actuator.toml", "time = { column = \"t\" }\n", "", "actuator.toml", "one of `pressure` and `time`"),
        ("actuator.toml", "time = { column = \"t\" }", "time = { column = \"s\" }", "sim.csv:1", "a column named `s`"),
        ("sim.csv", "0.020000000,", "0.000000000,", "sim.csv:4", "stamps that rise"),
        (
            "session.toml",
            "form = \"sim\"",
            "form = \"sim\"\nfit = { to = \"measured\", parameters = [\"a\"] }",
            "session.toml",
            "a table has no parameters",
        ),
    ] {
        let wave = Wave::new(&sim);
        wave.change(file, from, to);
        let (said, _) = wave.validate();
        assert_eq!(said.code, 2, "{to}: {}{}", said.out, said.err);
        assert!(said.err.contains(place) && said.err.contains(words), "{to}: {}", said.err);
    }
}

#[test]
fn a_path_as_other_programs_write_it_is_read_by_numbers_of_its_columns() {
    let wave = Wave::new("");
    let mut tum = "# timestamp tx ty tz qx qy qz qw\n".to_owned();
    for i in 0..201 {
        let t = 0.02 * f64::from(i);
        let [x, y, z] = helix(t).map(|v| 1e-3 * v);
        writeln!(tum, "{t:.6} {x:.9} {y:.9} {z:.9} 0 0 0 1").unwrap();
    }
    wave.write("sim.csv", &tum);
    wave.change(
        "actuator.toml",
        "time = { column = \"t\" }",
        "reader = { format = \"csv\" }\ntime = { column = 1, unit = \"s\" }\nunit = \"m\"",
    );
    wave.change("actuator.toml", "predicted = [\"x\", \"y\", \"z\"]", "predicted = [2, 3, 4]");
    wave.bound(0.1);
    let (said, _) = wave.validate();
    assert_eq!(said.code, 0, "{}{}", said.out, said.err);
    // Without the unit nobody knows.
    wave.change("actuator.toml", "\nunit = \"m\"", "");
    let (said, _) = wave.validate();
    assert_eq!(said.code, 2);
    assert!(said.err.contains("the unit of column `tx`"), "{}", said.err);
    // What is lost of a log is told; of a model's table nothing may be.
    wave.change(
        "actuator.toml",
        "time = { column = 1, unit = \"s\" }",
        "time = { column = 1, unit = \"s\" }\nunit = \"m\"",
    );
    wave.change("sim.csv", "0.040000 ", "0.040000 oops");
    let (said, _) = wave.validate();
    assert_eq!(said.code, 2, "{}{}", said.out, said.err);
    assert!(said.err.contains("sim.csv:4"), "{}", said.err);
}

#[test]
fn the_figures_of_a_movement_are_drawn_and_its_page_stays_small() {
    let wave = Wave::new(&table(',', (0.0, 0.0005, 8001), moved));
    wave.write("log.csv", &table(';', (0.0, 0.0002, 20_001), helix));
    let said = pneuval(wave.folder.path(), &["validate", ".", "--out", "report"]);
    assert_eq!(said.code, 3, "{}{}", said.out, said.err);
    for name in ["wave_tip_response_sim.png", "wave_tip_residuals_sim.png"] {
        assert!(wave.folder.path().join("report/results/figures").join(name).exists(), "{name}");
    }
    let page = fs::metadata(wave.folder.path().join("report/arm.html")).unwrap().len();
    assert!(page < 1_000_000, "{page} bytes");
    let said = pneuval(wave.folder.path(), &["export", ".", "--out", "export", "--format", "csv"]);
    assert_eq!(said.code, 0, "{}{}", said.out, said.err);
    let points = fs::read_to_string(wave.folder.path().join("export/wave/points.csv")).unwrap();
    assert_eq!(points.lines().count(), 2 + 8001);
    assert!(points.starts_with("quantity,runs,time_s,tip_x_measured_mm"), "{}", points.lines().next().unwrap());
}
