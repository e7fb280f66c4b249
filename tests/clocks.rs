//! Clocks of several devices through the binary: set on each other by events, told as a lag where there are none, refused where they have
//! nothing in common.

// In a test a panic is how a failure is told.
#![allow(clippy::unwrap_used, clippy::panic)]

mod common;

use std::fs;
use std::path::Path;

use common::sitting::findings;
use common::{Said, pneuval};
use serde_json::Value;

/// A rehearsal, `arguments` behind `rehearse`, in the folder `lab` of a new one.
fn rehearsed(arguments: &[&str]) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let said = pneuval(folder.path(), &[&["rehearse"], arguments, &["--out", "lab"]].concat());
    assert_eq!(said.code, 0, "{}", said.err);
    folder
}

fn validate(folder: &Path) -> (Said, Value) {
    let said = pneuval(folder, &["validate", "lab", "--out", "report", "--no-figures"]);
    let results = fs::read(folder.join("report/results/results.json")).unwrap_or_else(|_| b"null".to_vec());
    (said, serde_json::from_slice(&results).unwrap())
}

/// Changes `session.toml`; the text must be there.
fn change(folder: &Path, from: &str, to: &str) {
    let path = folder.join("lab/session.toml");
    let text = fs::read_to_string(&path).unwrap();
    assert!(text.contains(from), "no {from:?} in {text}");
    fs::write(path, text.replacen(from, to, 1)).unwrap();
}

/// Takes the events out of `session.toml`.
fn without_events(folder: &Path) {
    let text = fs::read_to_string(folder.join("lab/session.toml")).unwrap();
    let begin = text.find("[[sync]]").unwrap();
    let end = begin + text[begin..].find("[[run]]").unwrap();
    change(folder, &text[begin..end], "");
}

fn session(results: &Value) -> &Value {
    &results["actuators"][0]["datasets"][0]["session"]
}

fn measured(results: &Value) -> Vec<f64> {
    let points = results["comparisons"][0]["points"].as_array().unwrap();
    points.iter().map(|point| point["measured"][0].as_f64().unwrap()).collect()
}

#[test]
fn a_trigger_gives_offset_and_drift_and_the_session_is_read_as_with_one_clock() {
    for (arguments, device, offset_s, code) in [
        (&["internal-support"][..], "camera", -0.2, 0),
        (&["pdms-wall", "--sitting", "wall-displacement"], "tracker", -0.2, 3),
        (&["wave-finger", "--sitting", "bending-angle", "--format", "mcap"], "/goniometer", 0.35, 0),
    ] {
        let own = rehearsed(&[arguments, &["--clocks", "own"]].concat());
        let (said, results) = validate(own.path());
        let expected = rehearsed(arguments);
        let (said_one, results_one) = validate(expected.path());
        assert_eq!(said.code, said_one.code, "{arguments:?}: {} {}", said.err, said_one.err);
        assert_eq!(said.code, code, "{arguments:?}: {}", said.err);
        for (a, b) in measured(&results).iter().zip(measured(&results_one)) {
            assert!((a - b).abs() < 1e-3 * b.abs().max(0.1), "{arguments:?}: {a} {b}");
        }
        let clocks = session(&results)["alignments"].as_array().unwrap();
        assert_eq!(clocks.len(), session(&results)["runs"].as_array().unwrap().len());
        for clock in clocks {
            assert_eq!((&clock["table"], &clock["events_used"]), (&device.into(), &4.into()), "{clock}");
            let offset = &clock["offset_s"];
            let number = |key: &str| offset[key].as_f64().unwrap();
            // Where the zeros of absolute stamps lie is another matter: only what is left of whole seconds.
            let rest = number("value") - offset_s;
            assert!((rest - rest.round()).abs() < 0.1, "{clock}");
            assert!(number("lower") < number("value") && number("value") < number("upper"));
            assert!(clock["drift"]["upper"].as_f64().unwrap() > clock["drift"]["lower"].as_f64().unwrap());
        }
        let lags = session(&results)["lags"].as_array().unwrap();
        assert!(!lags.is_empty() && lags.iter().all(|lag| lag["meaning"] == "physical"), "{lags:?}");
        assert_eq!(findings(&results, "total-lag").len(), 0);
        let page = fs::read_dir(own.path().join("report")).unwrap().filter_map(Result::ok);
        let pages: String = page.filter_map(|entry| fs::read_to_string(entry.path()).ok()).collect();
        assert!(pages.contains("<h3>Clocks</h3>") && pages.contains("of rig and specimen, kept"));
    }
}

#[test]
fn without_events_the_total_lag_is_told_and_nothing_is_shifted() {
    let own = rehearsed(&["internal-support", "--clocks", "own"]);
    let (_, with_events) = validate(own.path());
    without_events(own.path());
    let (said, results) = validate(own.path());
    assert_eq!(said.code, 0, "{}", said.err);
    let told = findings(&results, "total-lag");
    assert_eq!((told.len(), &told[0]["severity"]), (1, &"note".into()), "{told:?}");
    assert!(told[0]["text"].as_str().unwrap().contains("nothing is shifted"), "{}", told[0]);
    assert!(session(&results)["alignments"].is_null());
    for lag in session(&results)["lags"].as_array().unwrap() {
        assert_eq!(lag["meaning"], "total");
        let physical = &session(&with_events)["lags"][0];
        let of = |lag: &Value| lag["value_s"].as_f64().unwrap();
        // The camera's clock is 200 ms ahead.
        assert!((of(lag) - of(physical) - 0.2).abs() < 0.06, "{lag} {physical}");
    }
    // Declared to be the clock's, the stamps are moved by it.
    change(own.path(), "schema = 1\n", "schema = 1\nlag = \"clock\"\n");
    let (said, results) = validate(own.path());
    assert_eq!(said.code, 0, "{}", said.err);
    assert!(findings(&results, "clock-shift")[0]["text"].as_str().unwrap().contains("declared to be the clock's"));
    assert_eq!(session(&results)["lags"][0]["meaning"], "clock");
    change(own.path(), "lag = \"clock\"", "lag = \"physical\"");
    let (said, results) = validate(own.path());
    assert_eq!(said.code, 0, "{}", said.err);
    assert_eq!(session(&results)["lags"][0]["meaning"], "physical");
}

#[test]
fn a_motion_that_leads_its_pressure_is_read_only_if_a_clock_is_declared_to_be_off() {
    // The angle gauge is 350 ms behind.
    let own = rehearsed(&["wave-finger", "--sitting", "bending-angle", "--clocks", "own"]);
    without_events(own.path());
    let (said, results) = validate(own.path());
    assert_eq!(said.code, 3, "{}", said.err);
    let told = findings(&results, "total-lag");
    assert_eq!(told[0]["severity"], "lost", "{told:?}");
    assert!(told[0]["text"].as_str().unwrap().contains("lag = \"clock\""), "{told:?}");
    assert_eq!(results["comparisons"][0]["points"], serde_json::json!([]));
    change(own.path(), "schema = 1\n", "schema = 1\nlag = \"clock\"\n");
    let (said, results) = validate(own.path());
    assert_eq!(said.code, 0, "{}", said.err);
    assert_eq!(measured(&results).len(), 2);
}

#[test]
fn a_window_is_read_only_where_the_clock_is_known_well_enough_to_say_what_lies_in_it() {
    let own = rehearsed(&["internal-support", "--clocks", "own"]);
    let (_, sure) = validate(own.path());
    let used = |results: &Value| session(results)["responses"][0]["used"].as_u64().unwrap();
    // Recordings of one event up to 5 s apart, of windows of a second or so.
    change(own.path(), "event = \"edges\"", "event = \"edges\"\nstd = { value = 5, unit = \"s\" }");
    let (said, results) = validate(own.path());
    assert_eq!(said.code, 3, "{}", said.err);
    assert_eq!(results["comparisons"][0]["points"], serde_json::json!([]));
    let told = said.out + &said.err;
    assert!(told.contains("on the clock of the pressure") && told.contains("are not read"), "{told}");
    // Known to some 0.1 s less of each window is.
    change(own.path(), "value = 5,", "value = 0.1,");
    let (_, results) = validate(own.path());
    assert_eq!(measured(&results).len(), measured(&sure).len());
    assert!(used(&results) < used(&sure), "{} {}", used(&results), used(&sure));
}

#[test]
fn one_event_leaves_open_what_a_clock_gains_and_events_that_fail_are_told_whichever_log_is_the_reference() {
    let own = rehearsed(&["internal-support", "--clocks", "own"]);
    let (_, both_ends) = validate(own.path());
    let used = |results: &Value| session(results)["responses"][0]["used"].as_u64().unwrap();
    // The line rises once and stays there.
    for (run, log, column) in (1..=3).flat_map(|run| [(run, "rig", "trigger"), (run, "camera", "led")]) {
        let path = own.path().join(format!("lab/run-{run}-{log}.csv"));
        let text = fs::read_to_string(&path).unwrap();
        let mut at = None;
        let mut is_up = false;
        let mut line = |line: &str| {
            let mut cells: Vec<&str> = line.split(',').collect();
            at = at.or_else(|| cells.iter().position(|cell| *cell == column));
            if let Some(cell) = at.and_then(|at| cells.get_mut(at)) {
                is_up |= cell.parse::<f64>().is_ok_and(|v| v > 0.5);
                *cell = if is_up { "1" } else { *cell };
            }
            cells.join(",") + "\n"
        };
        fs::write(path, text.lines().map(&mut line).collect::<String>()).unwrap();
    }
    let (_, one) = validate(own.path());
    assert_eq!(findings(&one, "drift-unknown").len(), 3, "{}", session(&one)["alignments"]);
    // Up to 1 % of the time since the event is taken off.
    assert!(used(&one) < used(&both_ends) && !measured(&one).is_empty(), "{} {}", used(&one), used(&both_ends));
    // The camera's log as the reference, and an LED that never lit: the events are not there, whichever way round.
    let swapped = rehearsed(&["internal-support", "--clocks", "own"]);
    let path = swapped.path().join("lab/session.toml");
    let mut text = fs::read_to_string(&path)
        .unwrap()
        .replace("id = \"camera\"\nreader", "id = \"rig\"\nreader")
        .replace("device = \"camera\"\n", "");
    for channel in ["pressure_set", "pressure", "trigger"] {
        text = text
            .replace(&format!("id = \"{channel}\"\ncolumn"), &format!("id = \"{channel}\"\ndevice = \"rig\"\ncolumn"));
    }
    for run in 1..=3 {
        let rig = format!("file = \"run-{run}-rig.csv\"\nfiles = {{ \"camera\" = \"run-{run}-camera.csv\" }}");
        assert!(text.contains(&rig), "{text}");
        text =
            text.replace(&rig, &format!("file = \"run-{run}-camera.csv\"\nfiles = {{ rig = \"run-{run}-rig.csv\" }}"));
    }
    fs::write(&path, text).unwrap();
    let (said, _) = validate(swapped.path());
    assert_eq!(said.code, 0, "{}", said.err);
    for run in 1..=3 {
        let path = swapped.path().join(format!("lab/run-{run}-camera.csv"));
        let text = fs::read_to_string(&path).unwrap();
        fs::write(path, text.replace(",1.0\n", ",0.0\n").replace(",1\n", ",0\n")).unwrap();
    }
    let (said, _) = validate(swapped.path());
    assert!(said.code == 4 && said.err.contains("`led`: it never changes"), "{}: {}", said.code, said.err);
    // Declared to agree, they are read all the same, and the events that failed are told.
    change(swapped.path(), "schema = 1\n", "schema = 1\nlag = \"physical\"\n");
    let (_, results) = validate(swapped.path());
    let told = findings(&results, "sync-mismatch");
    assert!(told.len() == 3 && told[0]["text"].as_str().unwrap().contains("do not set it"), "{told:?}");
}

#[test]
fn a_motion_before_its_pressure_is_told_although_the_clocks_are_declared_to_agree() {
    let own = rehearsed(&["wave-finger", "--sitting", "bending-angle", "--clocks", "own"]);
    without_events(own.path());
    change(own.path(), "schema = 1\n", "schema = 1\nlag = \"physical\"\n");
    let (_, results) = validate(own.path());
    let told = findings(&results, "unusual-lag");
    assert_eq!(told.len(), 1, "{}", session(&results)["lags"]);
    assert!(told[0]["text"].as_str().unwrap().contains("No motion precedes its pressure"), "{told:?}");
}

#[test]
fn a_clock_that_gains_more_than_any_clock_does_is_told() {
    let own = rehearsed(&["internal-support", "--clocks", "own"]);
    let (_, results) = validate(own.path());
    assert_eq!(findings(&results, "sync-mismatch").len(), 0);
    for run in 1..=3 {
        let path = own.path().join(format!("lab/run-{run}-camera.csv"));
        let text = fs::read_to_string(&path).unwrap();
        let line = |line: &str| match line.split_once(',') {
            Some((stamp, rest)) if stamp.parse::<f64>().is_ok() => {
                format!("{:.6},{rest}\n", stamp.parse::<f64>().unwrap() * 1.005)
            }
            _ => format!("{line}\n"),
        };
        fs::write(path, text.lines().map(line).collect::<String>()).unwrap();
    }
    let (_, results) = validate(own.path());
    let told = findings(&results, "sync-mismatch");
    assert_eq!(told.len(), 3, "{told:?}");
    assert!(told[0]["text"].as_str().unwrap().contains(" ppm (± "), "{}", told[0]);
}

#[test]
fn what_has_nothing_in_common_is_refused_with_the_reason_and_the_next_step() {
    let refused = |folder: &Path, code: i32, words: &[&str]| {
        let (said, _) = validate(folder);
        assert_eq!(said.code, code, "{}", said.err);
        for word in words.iter().chain(&["response `outer-diameter`", "`diameter` from camera", "[[sync]]"]) {
            assert!(said.err.contains(word), "{word}: {}", said.err);
        }
        // It is stored all the same.
        assert_eq!(pneuval(folder, &["ingest", "lab"]).code, 0);
    };
    let later = rehearsed(&["internal-support", "--clocks", "own"]);
    without_events(later.path());
    for run in 1..=3 {
        let path = later.path().join(format!("lab/run-{run}-camera.csv"));
        let text = fs::read_to_string(&path).unwrap();
        let line = |line: &str| match line.split_once(',') {
            Some((stamp, rest)) if stamp.parse::<f64>().is_ok() => {
                format!("{:.4},{rest}\n", stamp.parse::<f64>().unwrap() + 3600.0)
            }
            _ => format!("{line}\n"),
        };
        fs::write(path, text.lines().map(line).collect::<String>()).unwrap();
    }
    // The session does not say how the clocks lie: the user's to mend.
    refused(later.path(), 2, &["no stamps in common"]);
    // A trigger that the camera never saw.
    let unseen = rehearsed(&["internal-support", "--clocks", "own"]);
    for run in 1..=3 {
        let path = unseen.path().join(format!("lab/run-{run}-camera.csv"));
        let text = fs::read_to_string(&path).unwrap();
        fs::write(path, text.replace(",1.0\n", ",0.0\n").replace(",1\n", ",0\n")).unwrap();
    }
    refused(unseen.path(), 4, &["`led`: it never changes"]);
    // In one run only: that run is lost, and told.
    let partly = rehearsed(&["internal-support", "--clocks", "own"]);
    let path = partly.path().join("lab/run-2-camera.csv");
    let text = fs::read_to_string(&path).unwrap();
    fs::write(path, text.replace(",1.0\n", ",0.0\n").replace(",1\n", ",0\n")).unwrap();
    let (said, results) = validate(partly.path());
    assert_eq!(said.code, 3, "{}", said.err);
    let told = findings(&results, "clock-unaligned");
    assert_eq!((&told[0]["severity"], &told[0]["file"]), (&"lost".into(), &"run-2-camera.csv".into()), "{told:?}");
    assert_eq!(results["comparisons"][0]["points"][1]["runs"], serde_json::json!(["run-1", "run-3"]));
}

#[test]
fn a_clock_that_is_off_although_it_was_declared_to_be_one_is_seen_by_its_lag() {
    for fault in ["clock-offset", "clock-drift"] {
        let folder = rehearsed(&["internal-support", "--fault", fault]);
        let (_, results) = validate(folder.path());
        let told = findings(&results, "unusual-lag");
        assert_eq!(told.len(), 1, "{fault}: {}", session(&results)["lags"]);
        let text = told[0]["text"].as_str().unwrap();
        assert!(text.contains("in run run-2,") && told[0]["file"] == "run-2-camera.csv", "{text}");
    }
    let (_, clean) = validate(rehearsed(&["internal-support"]).path());
    assert_eq!(findings(&clean, "unusual-lag").len(), 0);
}

#[test]
fn mistakes_with_events_are_told_by_key_and_next_step() {
    let folder = rehearsed(&["internal-support", "--clocks", "own"]);
    let text = fs::read_to_string(folder.path().join("lab/session.toml")).unwrap();
    let channels = "channels = [\"trigger\", \"led\"]";
    for (from, to, words) in [
        (channels, "channels = [\"trigger\", \"leed\"]", ["channels of the session", "did you mean `led`"]),
        (channels, "channels = [\"trigger\"]", ["two channels or more", "every device that recorded"]),
        (channels, "channels = [\"trigger\", \"trigger\"]", ["each of several devices", "twice"]),
        (channels, "channels = [\"trigger\", \"pressure\"]", ["channels of several clocks", "both of `file`"]),
        (channels, "channels = [\"led\", \"diameter\"]", ["each of several devices", "both of camera"]),
        ("event = \"edges\"", "event = \"edge\"", ["edges", "edge"]),
        ("event = \"edges\"", "events = \"edges\"", ["events", "did you mean `event`"]),
        ("event = \"edges\"", "event = \"edges\"\nstd = { value = 1, unit = \"mm\" }", ["time", "mm"]),
        ("event = \"edges\"", "event = \"edges\"\nstd = { value = -1, unit = \"ms\" }", ["> 0", "-1"]),
        ("schema = 1\n", "schema = 1\nclocks = \"one\"\n", ["no [[sync]] beside clocks", "remove `clocks`"]),
        ("schema = 1\n", "schema = 1\nlag = \"mine\"\n", ["clock", "physical"]),
    ] {
        fs::write(folder.path().join("lab/session.toml"), text.replacen(from, to, 1)).unwrap();
        let (said, _) = validate(folder.path());
        assert_eq!(said.code, 2, "{to}: {}{}", said.out, said.err);
        assert!(
            said.err.contains("session.toml") && words.iter().all(|word| said.err.contains(word)),
            "{to}: {}",
            said.err
        );
    }
}

#[test]
fn the_selftest_of_clocks_and_lags_says_what_it_found() {
    let folder = tempfile::tempdir().unwrap();
    let said = pneuval(folder.path(), &["selftest", "lag", "--seeds", "12", "--json"]);
    assert_eq!(said.code, 0, "{}{}", said.out, said.err);
    let told: Value = serde_json::from_str(&said.out).unwrap();
    assert_eq!((&told["broken"], &told["kept"]), (&serde_json::json!([]), &1.0.into()));
    assert_eq!((&told["refused_still"], &told["refused_elsewhere"]), (&1.0.into(), &1.0.into()));
    assert!((told["physical_lag_mean_s"].as_f64().unwrap() - 0.15).abs() < 1e-3, "{told}");
}

#[test]
fn the_intervals_of_metrics_hold_the_truth_of_a_small_sample() {
    let folder = tempfile::tempdir().unwrap();
    let said = pneuval(folder.path(), &["selftest", "coverage", "--repeats", "5", "--seeds", "12", "--json"]);
    let told: serde_json::Value = serde_json::from_str(&said.out).unwrap();
    assert_eq!((said.code, told["broken"].as_array().unwrap().len()), (0, 0), "{}", said.out);
    let cells = told["cells"].as_array().unwrap();
    assert_eq!(cells.len(), 16, "two benches, two models, four metrics");
    for cell in cells {
        // Of 12 sessions one or two may miss by chance; the truth is no number of the sessions themselves.
        assert!(
            cell["covered"].as_f64().unwrap() >= 0.75 && cell["oracle_half_width_si"].as_f64().unwrap() > 0.0,
            "{cell}"
        );
    }
}
