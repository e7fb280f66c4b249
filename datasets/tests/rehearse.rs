//! A rehearsal of an actuator that nobody embedded: every fault in every format is found where it lies, and nothing on a clean one.

// Helpers of tests may unwrap and panic, as tests do.
#![allow(clippy::unwrap_used, clippy::panic)]

use std::fs;
use std::path::Path;

use tempfile::TempDir;

use pneuval_datasets::FoundData;
use pneuval_datasets::rehearse::{Bag, FAULTS, FaultRecord, Rehearsal, Request, Written};
use pneuval_ingest::finding::Finding;
use pneuval_ingest::formats::{Format, mcap};

const ACTUATOR: &str = r#"schema = 1
id = "my-finger"
title = "My finger"

[chamber.air]
pressure_gauge_max = { value = 40, unit = "kPa", source = "measured" }
"#;

/// Rising all the way, so that no plateau looks like another.
const TRUTH: &str = "pressure,x,z\nkPa,mm,mm\n0,0,100\n10,20,95\n20,40,85\n40,70,60\n";

const PLAN: &str = r#"schema = 1
id = "my-finger"
actuator = "my-finger"
rig = "rehearsal"
title = "Tip of my finger"

[regulator]
time_constant = { value = 0.1, unit = "s" }
droop = { value = 0.1, unit = "%" }

[specimen]
creep = [{ share = { value = 3, unit = "%" }, time = { value = 0.3, unit = "s" } }]
hysteresis = { value = 3, unit = "%" }
repeat = { value = 0.1, unit = "%" }

[[device]]
id = "rig"
format = "csv"
rate = { value = 100, unit = "Hz" }
jitter = { value = 0.2, unit = "ms" }

[[device]]
id = "tracker"
format = "trakstar"
rate = { value = 120, unit = "Hz" }
decimals = 6
offset = { value = 0.3, unit = "s" }
drift_ppm = 50

[[device]]
id = "gauge"
format = "gauge"
rate = { value = 50, unit = "Hz" }

[[channel]]
id = "asked"
device = "rig"
shows = { command = "air" }
unit = "kPa"
decimals = 2

[[channel]]
id = "pressure"
device = "rig"
shows = { pressure = "air" }
instrument = "pressure-sensor"
noise = { value = 0.05, unit = "kPa" }
decimals = 3

[[channel]]
id = "diameter"
device = "rig"
shows = { quantity = "diameter" }
instrument = "camera"
noise = { value = 0.05, unit = "mm" }
decimals = 3

[[channel]]
id = "x"
device = "tracker"
shows = { component = { quantity = "tip", index = 0 } }
instrument = "tracker"
noise = { value = 0.06, unit = "mm" }
decimals = 6

[[channel]]
id = "z"
device = "tracker"
shows = { component = { quantity = "tip", index = 1 } }
instrument = "tracker"
noise = { value = 0.06, unit = "mm" }
decimals = 6

[[channel]]
id = "force"
device = "gauge"
shows = { quantity = "force" }
instrument = "force-gauge"
noise = { value = 0.01, unit = "N" }
decimals = 3

[[sitting]]
id = "tip"
title = "Tip of my finger"

[sitting.programme]
kind = "steps"
chambers = ["air"]
levels = { values = [10, 20, 40], unit = "kPa" }
rest = { value = 2, unit = "s" }
rise = { value = 0.5, unit = "s" }
hold = { value = 3, unit = "s" }
window = { value = 1, unit = "s" }
tolerance = { value = 0.4, unit = "kPa" }

[[sitting.response]]
quantity = { id = "diameter", title = "Diameter", unit = "mm" }
chambers = ["air"]
measured = ["diameter"]
method = "camera"
truth = { file = "diameter.csv" }

[[sitting.response]]
quantity = { id = "tip", title = "Tip position", unit = "mm", components = ["x", "z"] }
chambers = ["air"]
measured = ["x", "z"]
method = "tracker"
truth = { file = "tip.csv" }

[[sitting.response]]
quantity = { id = "force", title = "Force", unit = "N" }
chambers = ["air"]
measured = ["force"]
method = "gauge"
truth = { file = "force.csv" }
"#;

/// A folder with all that the plan names.
fn lab() -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    for (name, text) in [
        ("actuator.toml", ACTUATOR),
        ("plan.toml", PLAN),
        ("tip.csv", TRUTH),
        ("diameter.csv", "pressure,diameter\nkPa,mm\n0,30\n40,42\n"),
        ("force.csv", "pressure,force\nkPa,N\n0,0\n40,8\n"),
    ] {
        fs::write(folder.path().join(name), text).unwrap();
    }
    folder
}

fn rehearse(lab: &Path, to: &Path, request: Request) -> Result<Vec<Written>, String> {
    let rehearsal = Rehearsal::find("plan.toml", lab, request).map_err(|error| error.to_string())?;
    let mut sink = |name: &str, bytes: &[u8]| {
        let path = to.join(name);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, bytes).unwrap();
        Ok(())
    };
    rehearsal.write(&mut sink).map_err(|error| error.to_string())
}

/// What is found in the session of a folder.
fn findings(folder: &Path) -> Vec<Finding> {
    match pneuval_datasets::find(&[folder.to_owned()]) {
        Ok(found) => found
            .into_iter()
            .flat_map(|found| match found.data {
                FoundData::Session(session) => session.findings,
                FoundData::Published(_) => vec![],
            })
            .collect(),
        Err(error) => panic!("{error}"),
    }
}

/// Every format, `None` for those of the plan: delimited text, trakSTAR and gauge.
fn formats() -> Vec<(Option<Format>, Bag)> {
    let bag = |encoding, compression| (Some(Format::Mcap), Bag { encoding, compression });
    let plain = |format| (format, Bag::default());
    vec![
        plain(None),
        plain(Some(Format::Csv)),
        plain(Some(Format::Serial)),
        plain(Some(Format::Lvm)),
        plain(Some(Format::Tdms)),
        bag(mcap::Encoding::Cdr, mcap::Compression::Zstd),
        bag(mcap::Encoding::Json, mcap::Compression::Lz4),
        bag(mcap::Encoding::Protobuf, mcap::Compression::None),
    ]
}

#[test]
fn nothing_is_found_in_a_clean_session_of_any_format() {
    let lab = lab();
    for (format, bag) in formats() {
        let to = tempfile::tempdir().unwrap();
        rehearse(lab.path(), to.path(), Request { format, bag, repeats: 2, ..Request::default() }).unwrap();
        let found = findings(to.path());
        assert!(found.is_empty(), "{format:?} {bag:?}: {found:#?}");
    }
}

/// Whether a fault is told where it lies. What hits every sample, or the file as a whole, lies everywhere.
fn is_told_there(finding: &Finding, record: &FaultRecord) -> bool {
    let (first, last) = record.samples;
    let spans = &finding.spans;
    let inside = || spans.iter().all(|span| span.first_sample + 1 >= first && span.last_sample <= last + 1);
    match record.fault {
        // Steps as a whole.
        "truncated" | "glued-header" | "trailer" | "jitter" => true,
        "flatline" => spans.iter().any(|s| s.first_sample.abs_diff(first) <= 1 && s.last_sample.abs_diff(last) <= 1),
        // A chunk as a whole.
        "flipped-bit" if record.lines.is_none() => true,
        _ => !spans.is_empty() && inside(),
    }
}

#[test]
fn every_fault_is_found_where_it_lies_in_every_format_that_can_carry_it() {
    let lab = lab();
    let mut carried = 0;
    let mut missed = Vec::new();
    let mut silent = Vec::new();
    for (format, bag) in formats() {
        for (name, _, _) in FAULTS {
            let to = tempfile::tempdir().unwrap();
            let request =
                Request { format, bag, repeats: 1, faults: vec![name.parse().unwrap()], ..Request::default() };
            let written = match rehearse(lab.path(), to.path(), request) {
                Ok(written) => written,
                Err(error) => {
                    // A format that cannot carry it says so, and names the fault.
                    assert!(error.contains(name), "{format:?} {name}: {error}");
                    continue;
                }
            };
            carried += 1;
            let record = &written[0].faults[0];
            let here = format!("{format:?} {:?} {name}", bag.encoding);
            if record.expected.is_empty() || record.expected == ["unusual-lag"] {
                silent.push(here);
                continue;
            }
            let found = match pneuval_datasets::find(&[to.path().to_owned()]) {
                Ok(found) => found,
                Err(error) => {
                    missed.push(format!("{here}: {error}"));
                    continue;
                }
            };
            let Some(FoundData::Session(session)) = found.into_iter().next().map(|found| found.data) else { panic!() };
            let is_it = |f: &&Finding| record.expected.contains(&f.kind.id()) && f.file == record.file;
            let told: Vec<&Finding> = session.findings.iter().filter(is_it).collect();
            // The other devices of the run, and the other runs, are clean.
            let elsewhere: Vec<&Finding> = session.findings.iter().filter(|f| f.file != record.file).collect();
            if !elsewhere.is_empty() {
                missed.push(format!("{here}: elsewhere {elsewhere:#?}"));
            }
            if !told.iter().any(|finding| is_told_there(finding, record)) {
                missed.push(format!("{here}: {:?} {:?}: {:#?}", record.samples, record.expected, session.findings));
            }
        }
    }
    assert!(missed.is_empty(), "{} of {carried}\n{}", missed.len(), missed.join("\n"));
    // What no single file shows: the clocks of several devices. `validate` tells them by the lags of several runs.
    assert!(silent.iter().all(|here| here.ends_with("clock-offset") || here.ends_with("clock-drift")), "{silent:?}");
}

#[test]
fn mistakes_of_a_plan_are_told_by_line_and_nothing_is_written() {
    let lab = lab();
    for (from, to, words) in [
        ("shows = { command = \"air\" }", "shows = { command = \"aire\" }", "did you mean `air`"),
        ("shows = { quantity = \"force\" }", "shows = { quantity = \"forces\" }", "did you mean `force`"),
        ("index = 1", "index = 2", "a component of `tip`"),
        ("instrument = \"camera\"", "instrument = \"camra\"", "did you mean `camera`"),
        ("instrument = \"camera\"", "instrument = \"protractor\"", "a length"),
        (
            "noise = { value = 0.05, unit = \"mm\" }",
            "noise = { value = 0.05, unit = \"N\" }",
            "noise and drift as a length",
        ),
        ("id = \"asked\"", "id = \"t\"", "a name that the stamps do not have"),
        ("measured = [\"diameter\"]", "measured = [\"pressure\"]", "channels that show `diameter`"),
        ("measured = [\"x\", \"z\"]", "measured = [\"z\", \"x\"]", "component by component"),
        ("device = \"gauge\"\nshows", "device = \"tracker\"\nshows", "tracker has one sensor"),
        ("shows = { pressure = \"air\" }", "shows = { command = \"air\" }", "a channel that shows the pressure"),
        ("chambers = [\"air\"]\nlevels", "chambers = [\"air\", \"air\"]\nlevels", "every chamber once"),
        ("levels = { values = [10, 20, 40]", "levels = { values = [10, -20, 40]", "gauge pressures >= 0"),
        ("rate = { value = 100, unit = \"Hz\" }", "rate = { value = 1e9, unit = \"Hz\" }", "runs of at most"),
        ("hold = { value = 3, unit = \"s\" }", "hold = { value = 1e12, unit = \"s\" }", "runs of at most"),
        ("window = { value = 1, unit = \"s\" }", "window = { value = 3, unit = \"s\" }", "less than the hold"),
        ("truth = { file = \"tip.csv\" }", "truth = { sum = [] }", "at least one quantity"),
        ("truth = { file = \"tip.csv\" }", "truth = \"published\"", "a quantity that the paper prints a table of"),
        ("decimals = 6\noffset", "decimals = 60\noffset", "at most 9"),
        ("format = \"gauge\"", "format = \"plus\"", "a format that a device writes"),
        ("hysteresis = { value = 3, unit = \"%\" }", "hysteresis = { value = 300, unit = \"%\" }", "a share below 1"),
        ("droop", "drop", "did you mean `droop`"),
    ] {
        assert!(PLAN.contains(from), "{from}");
        fs::write(lab.path().join("plan.toml"), PLAN.replacen(from, to, 1)).unwrap();
        let out = tempfile::tempdir().unwrap();
        let error = rehearse(lab.path(), out.path(), Request::default()).unwrap_err();
        assert!(error.contains(words), "{to}: {error}");
        assert!(error.contains("expected:") && error.contains("next:"), "{error}");
        let is_log = |entry: &fs::DirEntry| entry.file_name().to_string_lossy().starts_with("run-");
        assert!(!fs::read_dir(out.path()).unwrap().any(|entry| is_log(&entry.unwrap())), "{to}");
    }
}

/// The pressure follows a ramp as a first-order lag does, whatever the rates of the devices: p = r (t - τ (1 - exp(-t/τ))).
#[test]
fn physics_does_not_depend_on_the_rate_of_a_device() {
    let lab = lab();
    let ideal = "repeat = { value = 0.1, unit = \"%\" }";
    let quiet = PLAN
        .replacen("noise = { value = 0.05, unit = \"kPa\" }\n", "", 1)
        .replacen(ideal, "", 1)
        .replacen("droop = { value = 0.1,", "droop = { value = 0,", 1)
        .replacen("jitter = { value = 0.2, unit = \"ms\" }\n", "", 1)
        .replacen("instrument = \"pressure-sensor\"", "unit = \"kPa\"", 1);
    for rate in [50, 2000] {
        let plan = quiet.replacen("rate = { value = 50, unit", &format!("rate = {{ value = {rate}, unit"), 1);
        fs::write(lab.path().join("plan.toml"), plan).unwrap();
        let out = tempfile::tempdir().unwrap();
        rehearse(lab.path(), out.path(), Request { repeats: 1, ..Request::default() }).unwrap();
        let log = fs::read_to_string(out.path().join("run-1-rig.csv")).unwrap();
        for line in log.lines().skip(3) {
            let cells: Vec<f64> = line.split(',').take(3).map(|cell| cell.parse().unwrap()).collect();
            // From 2 s on to 10 kPa in 0.5 s.
            let t = cells[0] - 2.0;
            if (0.0..=0.5).contains(&t) {
                let expected = 20.0 * (t - 0.1 * (1.0 - (-t / 0.1).exp()));
                assert!((cells[2] - expected).abs() < 2e-3, "{rate} Hz: {line}, {expected}");
            }
        }
    }
}
