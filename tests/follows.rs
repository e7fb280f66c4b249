//! A measured pressure against the commanded one, by the binary: what is wrong with a log is told, and no number changes.

// In a test a panic is how a failure is told.
#![allow(clippy::unwrap_used, clippy::panic)]

mod common;

use std::fmt::Write as _;

use common::sitting::{Sitting, findings, points};
use serde_json::Value;

const SESSION: &str = r#"schema = 1
id = "monday"
actuator = "my-bellows"

[clock]
column = "t"
unit = "s"

[[channel]]
id = "command"
column = "set"
unit = "kPa"
reference = "gauge"
commanded = true

[[channel]]
id = "pressure"
column = "p"
unit = "kPa"
reference = "gauge"
follows = { channel = "command", within = { value = 1, unit = "kPa" }, after = { value = 2, unit = "s" } }

[[channel]]
id = "stroke"
column = "u"
unit = "mm"

[[run]]
file = "log.csv"

[[response]]
quantity = { id = "stroke", title = "Stroke", unit = "mm" }
pressure = [{ channel = "command", chamber = "air" }]
measured = { channel = "stroke", method = "laser" }
points = { from = "plateaus", tolerance = { value = 0.5, unit = "kPa" }, hold = { value = 4, unit = "s" }, window = { value = 1, unit = "s" } }
"#;

/// Commands of 5 s each at 10 Hz, and a pressure that needs 1 s to get there; `gauge` says what is logged of it at a time.
fn log(gauge: impl Fn(f64, f64) -> f64) -> String {
    let mut text = String::from("t,set,p,u\n");
    let mut pressure = 0.0;
    for (step, command) in [0.0, 20.0, 40.0, 10.0, 0.0].into_iter().enumerate() {
        for i in 0..50 {
            let t = f64::from(i) / 10.0 + step as f64 * 5.0;
            pressure += (command - pressure) * 0.4;
            // A sensor's noise, 0.1 kPa.
            let noise = 0.1 * (t * 7919.0).sin();
            writeln!(text, "{t:.1},{command},{:.4},{:.3}", gauge(t, pressure + noise), command / 2.0).unwrap();
        }
    }
    text
}

fn sitting(log: &str) -> Sitting {
    let sitting = Sitting::new();
    sitting.write("session.toml", SESSION);
    sitting.write("log.csv", log);
    sitting
}

/// The only finding of a kind: its text, its spans as first and last line, its count.
fn told(sitting: &Sitting, kind: &str) -> (String, Vec<(u64, u64)>, u64) {
    let said = sitting.validate();
    assert!(said.code == 0 || said.code == 3, "{}", said.err);
    let results = sitting.results();
    let [finding] = findings(&results, kind)[..] else { panic!("{}", results["findings"]) };
    assert_eq!((&finding["severity"], &finding["channel"]), (&"note".into(), &"pressure".into()));
    let line = |span: &Value, key: &str| span[key].as_u64().unwrap();
    let spans = finding["spans"].as_array().unwrap();
    let spans = spans.iter().map(|span| (line(span, "first_line"), line(span, "last_line"))).collect();
    (finding["text"].as_str().unwrap().to_owned(), spans, finding["count"].as_u64().unwrap())
}

#[test]
fn a_pressure_that_follows_its_command_tells_nothing() {
    let sitting = sitting(&log(|_, p| p));
    sitting.validate();
    let results = sitting.results();
    assert!(findings(&results, "command-mismatch").is_empty(), "{}", results["findings"]);
    assert!(findings(&results, "not-compared").is_empty(), "{}", results["findings"]);
}

#[test]
fn a_log_in_psi_is_told_with_place_and_figures_and_no_number_changes() {
    let (right, wrong) = (sitting(&log(|_, p| p)), sitting(&log(|_, p| p / 6.894_757)));
    right.validate();
    let (text, spans, count) = told(&wrong, "command-mismatch");
    // The second to the fourth command, each without its first 2 s; line 1 is the header.
    assert_eq!((spans, count), (vec![(72, 101), (122, 151), (172, 201)], 90));
    for words in [
        "channel `pressure` of run log.csv: 90 samples of 150 compared where `command` has stood for 2 s are more than 1 kPa from it",
        "the first, samples 70 to 99 (lines 72 to 101), 7 s to 9.9 s: 20 kPa commanded, 2.9",
        "largest difference 34.2",
    ] {
        assert!(text.contains(words), "{words}: {text}");
    }
    assert!(text.ends_with("; as if it were in psi"), "{text}");
    assert_eq!(points(&wrong.results(), 0), points(&right.results(), 0));
    // With its unit there is nothing to tell.
    wrong.change("session.toml", "column = \"p\"\nunit = \"kPa\"", "column = \"p\"\nunit = \"psi\"");
    wrong.validate();
    assert!(findings(&wrong.results(), "command-mismatch").is_empty());
}

#[test]
fn a_wrong_sign_a_leak_and_a_zero_that_slipped_are_told_apart() {
    let (text, spans, _) = told(&sitting(&log(|_, p| -p)), "command-mismatch");
    assert_eq!(spans, [(72, 101), (122, 151), (172, 201)]);
    assert!(text.ends_with("; as if it had the other sign"), "{text}");
    // From 13.3 s on a fifth is lost: in the middle of the third command.
    let (text, spans, _) = told(&sitting(&log(|t, p| if t < 13.25 { p } else { 0.8 * p })), "command-mismatch");
    assert_eq!(spans, [(135, 151), (172, 201)]);
    assert!(text.contains("lines 135 to 151), 13.3 s to 14.9 s: 40 kPa commanded, 3"), "{text}");
    assert!(text.ends_with("; from 13.3 s on about 20 % short of the command: a leak?"), "{text}");
    let (text, spans, _) = told(&sitting(&log(|_, p| p + 3.0)), "command-mismatch");
    assert_eq!(spans, [(22, 51), (72, 101), (122, 151), (172, 201), (222, 251)]);
    assert!(text.ends_with("; as if about 3 kPa were added to it: a zero that slipped?"), "{text}");
    // An absolute pressure that is said to be gauge; with the atmosphere of the run it follows.
    let absolute = sitting(&log(|_, p| p + 101.3));
    let (text, ..) = told(&absolute, "command-mismatch");
    assert!(text.ends_with("; as if it were an absolute pressure"), "{text}");
    absolute.change(
        "session.toml",
        "column = \"p\"\nunit = \"kPa\"\nreference = \"gauge\"",
        "column = \"p\"\nunit = \"kPa\"\nreference = \"absolute\"",
    );
    absolute.change(
        "session.toml",
        "file = \"log.csv\"",
        "file = \"log.csv\"\natmosphere = { value = 101.3, unit = \"kPa\" }",
    );
    absolute.validate();
    assert!(findings(&absolute.results(), "command-mismatch").is_empty());
}

#[test]
fn the_finding_is_kept_with_a_stored_session() {
    let sitting = sitting(&log(|_, p| -p));
    let said = common::pneuval(sitting.path(), &["ingest", "."]);
    assert_eq!(said.code, 0, "{}", said.err);
    let record = std::fs::read_to_string(sitting.path().join(".pneuval/session.json")).unwrap();
    assert!(record.contains("\"command-mismatch\"") && record.contains("the other sign"), "{record}");
}

#[test]
fn a_channel_that_could_not_be_compared_says_so() {
    // The command never stands: a ramp.
    let mut text = String::from("t,set,p,u\n");
    for i in 0..200 {
        writeln!(text, "{},{},99,0", f64::from(i) / 10.0, f64::from(i) / 5.0).unwrap();
    }
    // One plateau, so that there is a response.
    for i in 200..250 {
        writeln!(text, "{},40,,20", f64::from(i) / 10.0).unwrap();
    }
    let (words, spans, count) = told(&sitting(&text), "not-compared");
    assert_eq!((spans, count), (vec![], 250));
    assert!(
        words.contains(
            "250 samples, none compared with `command`: it has no number at the 30 where `command` has stood for 2 s"
        ),
        "{words}"
    );
    let sitting = sitting(&log(|_, p| p));
    sitting.change("session.toml", "after = { value = 2, unit = \"s\" }", "after = { value = 2, unit = \"min\" }");
    let (words, ..) = told(&sitting, "not-compared");
    assert!(words.contains("at none of them `command` has stood for 120 s; a shorter `after`"), "{words}");
}

#[test]
fn steady_states_without_a_clock_are_compared_line_by_line() {
    let sitting = Sitting::new();
    sitting.write("log.csv", "set,p,u\n0,0,0\n10,10.9,5\n20,18.9,10\n30,30,\n40,,20\n");
    let clock = "[clock]\ncolumn = \"t\"\nunit = \"s\"\n";
    let (head, points) = SESSION.split_once("points = ").unwrap();
    assert!(points.contains("plateaus"));
    sitting.write("session.toml", &head.replace(clock, "").replace("after = { value = 2", "after = { value = 0"));
    let (text, spans, count) = told(&sitting, "command-mismatch");
    assert_eq!((spans, count), (vec![(4, 4)], 1));
    assert!(
        text.contains(
            "1 sample of 4 compared is more than 1 kPa from `command`; the first, sample 2 (line 4): 20 kPa commanded, 18.9 kPa measured; largest difference 1.1 kPa"
        ),
        "{text}"
    );
}

#[test]
fn mistakes_in_follows_are_named_with_line_and_next_step() {
    let line = "session.toml:21";
    for (from, to, words) in [
        ("channel = \"command\", within", "channel = \"comand\", within", ["a [[channel]]", "did you mean `command`?"]),
        ("channel = \"command\", within", "channel = \"pressure\", within", ["`pressure` itself", "name the channel"]),
        (
            "channel = \"command\", within",
            "channel = \"stroke\", within",
            ["`stroke`, which is measured", "commanded = true"],
        ),
        ("within = { value = 1,", "within = { value = 0,", ["a number > 0", "found:    0\n"]),
        ("within = { value = 1,", "within = { value = -1,", ["a number > 0", "found:    -1\n"]),
        ("within = { value = 1,", "within = { value = nan,", ["a finite number", "found:    NaN"]),
        ("unit = \"kPa\" }, after", "unit = \"mm\" }, after", ["`within` as a pressure", "found:    unit `mm`"]),
        ("unit = \"kPa\" }, after", "unit = \"kpa\" }, after", ["a known unit", "did you mean `kPa`?"]),
        ("after = { value = 2, unit = \"s\" }", "after = { value = 2, unit = \"mm\" }", ["a time", "unit `mm`"]),
        ("after = { value = 2,", "after = { value = -2,", ["a number > 0", "found:    -2\n"]),
        (", after = { value = 2, unit = \"s\" }", "", ["key `after`", "add `after`"]),
        ("after = { value = 2,", "afer = { value = 2,", ["`afer`", "did you mean `after`?"]),
    ] {
        let sitting = sitting(&log(|_, p| p));
        sitting.change("session.toml", from, to);
        let said = sitting.validate();
        assert_eq!(said.code, 2, "{to}: {}", said.out);
        assert!(said.err.contains(line) && words.iter().all(|w| said.err.contains(w)), "{to}: {}", said.err);
        assert!(!sitting.path().join("report").exists());
    }
}

#[test]
fn channels_that_cannot_be_compared_are_refused() {
    // The wrong one of the two follows.
    let sitting = self::sitting(&log(|_, p| p));
    let follows = "follows = { channel = \"command\", within = { value = 1, unit = \"kPa\" }, after = { value = 2, unit = \"s\" } }\n";
    sitting.change("session.toml", follows, "");
    sitting.change(
        "session.toml",
        "commanded = true\n",
        &format!("commanded = true\n{}", follows.replace("command\"", "pressure\"")),
    );
    let said = sitting.validate();
    assert_eq!(said.code, 2, "{}", said.out);
    assert!(
        said.err.contains("session.toml:15") && said.err.contains("write `follows` at `pressure`, naming `command`"),
        "{}",
        said.err
    );
    // Another kind of quantity.
    let sitting = self::sitting(&log(|_, p| p));
    sitting.change(
        "session.toml",
        "column = \"set\"\nunit = \"kPa\"\nreference = \"gauge\"",
        "column = \"set\"\nunit = \"V\"",
    );
    let said = sitting.validate();
    assert_eq!(said.code, 2, "{}", said.out);
    assert!(
        said.err.contains("session.toml:20")
            && said.err.contains("`command` as a pressure")
            && said.err.contains("unit `V`"),
        "{}",
        said.err
    );
    // No clock says how long the command has stood.
    let sitting = self::sitting(&log(|_, p| p));
    sitting.change("session.toml", "[clock]\ncolumn = \"t\"\nunit = \"s\"\n\n", "");
    let said = sitting.validate();
    assert_eq!(said.code, 2, "{}", said.out);
    assert!(said.err.contains("session.toml:17") && said.err.contains("how long `command` has stood"), "{}", said.err);
    assert!(said.err.contains("add [clock]") && said.err.contains("after = { value = 0"), "{}", said.err);
}

#[test]
fn the_command_may_stand_below_in_the_file() {
    let sitting = sitting(&log(|_, p| -p));
    let text = std::fs::read_to_string(sitting.path().join("session.toml")).unwrap();
    let from = text.find("[[channel]]\nid = \"command\"").unwrap();
    let to = text.find("[[channel]]\nid = \"pressure\"").unwrap();
    let run = text.find("[[run]]").unwrap();
    let moved = format!("{}{}{}{}", &text[..from], &text[to..run], &text[from..to], &text[run..]);
    sitting.write("session.toml", &moved);
    let (text, ..) = told(&sitting, "command-mismatch");
    assert!(text.ends_with("the other sign"), "{text}");
}
