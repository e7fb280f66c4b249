//! Exports through the binary: what is written reads back as what was measured and predicted, in every format.

// In a test a panic is how a failure is told; equality of floats is asked where it must be exact.
#![allow(clippy::unwrap_used, clippy::panic, clippy::float_cmp)]

mod common;

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::fs;
use std::io::Cursor;
use std::path::Path;

use common::sitting::{ACTUATOR, SESSION, Sitting};
use common::{Lab, Said, pneuval};
use pneuval_ingest::finding::{Finding, LineMap};
use pneuval_ingest::formats::csv::Decimal;
use pneuval_ingest::formats::{Options, mcap, read};
use pneuval_ingest::limits::LOG_BYTES_MAX;
use pneuval_ingest::raw::RawFile;
use pneuval_ingest::recording::{Cells, Column, Keep, Recording, Table};
use pneuval_ingest::store::{Series, read_parquet, read_parquet_metadata};
use pneuval_ingest::units::Unit;
use serde_json::Value;

const FORMATS: [&str; 3] = ["mcap", "csv", "parquet"];

/// Numbers of a table by column; NaN is a hole.
type Numbers = BTreeMap<String, Vec<f64>>;

fn export(folder: &Path, format: &str) -> Said {
    pneuval(folder, &["export", ".", "--out", format, "--format", format, "--json"])
}

/// What `--json` says, which is what stands in the export.
fn told(folder: &Path, format: &str) -> Value {
    let said = export(folder, format);
    let told: Value = serde_json::from_str(&said.out).unwrap_or_else(|error| panic!("{error}: {}", said.err));
    assert_eq!(fs::read_to_string(folder.join(format).join("pneuval_export.json")).unwrap(), said.out);
    told
}

fn recording(path: &Path) -> Recording {
    let raw = RawFile::open(path, "export", LOG_BYTES_MAX).unwrap();
    read(&raw, &Options::default(), Keep::All).unwrap()
}

fn of_table(table: &Table) -> Numbers {
    let numbers = table.columns.iter().filter_map(|c| Some((c.name.clone(), c.cells.numbers()?.to_vec())));
    numbers.collect()
}

/// The numbers of a file by our own readers, and what they find odd.
fn back(path: &Path) -> (Numbers, Vec<Finding>) {
    if path.extension().unwrap() == "parquet" {
        let columns = read_parquet(path).unwrap().into_iter().filter_map(|(name, series)| match series {
            Series::Number(cells) => Some((name, cells.into_iter().map(|cell| cell.unwrap_or(f64::NAN)).collect())),
            Series::Text(_) => None,
        });
        return (columns.collect(), vec![]);
    }
    let recording = recording(path);
    assert_eq!(recording.tables.len(), 1);
    (of_table(&recording.tables[0]), recording.findings)
}

/// A column by its name in Parquet and CSV, or in lower case in MCAP.
fn column<'n>(numbers: &'n Numbers, name: &str) -> &'n [f64] {
    let lower = name.to_lowercase();
    numbers.get(name).or_else(|| numbers.get(&lower)).unwrap_or_else(|| panic!("{name}: {:?}", numbers.keys()))
}

fn assert_same(found: &[f64], expected: &[f64], what: &str) {
    let bits =
        |values: &[f64]| values.iter().map(|v| if v.is_nan() { u64::MAX } else { v.to_bits() }).collect::<Vec<_>>();
    assert_eq!(bits(found), bits(expected), "{what}: {found:?} {expected:?}");
}

/// A sitting with a clock: decimals that no double holds, in units that no power of two leads to.
fn clocked() -> Sitting {
    let sitting = Sitting::new();
    let clock =
        "[clock]\ncolumn = \"t\"\nunit = \"ms\"\n\n[[channel]]\nid = \"bend\"\ncolumn = \"b\"\nunit = \"deg\"\n";
    sitting.change("session.toml", "[[run]]", &format!("{clock}\n[[run]]"));
    sitting.write("log.csv", &log(&[0.0, 10.0, 20.0, 30.0, 40.0]));
    sitting
}

/// One sample each 10 ms at given pressures in kPa.
fn log(pressures: &[f64]) -> String {
    let mut text = "t;pressure (kPa);stroke [mm];b\n".to_owned();
    for (i, p) in pressures.iter().enumerate() {
        writeln!(text, "{};{p};{};{}", 10 * i, strokes(i), bends(i)).unwrap();
    }
    text.replace('.', ",")
}

fn strokes(i: usize) -> f64 {
    [0.1, 15.7, 31.4, 7.3, 4.35][i % 5]
}

fn bends(i: usize) -> f64 {
    [7.3, 7.5, 14.7, -15.1, 0.0][i % 5]
}

#[test]
fn what_was_measured_comes_back_equal_in_every_format() {
    let sitting = clocked();
    for format in FORMATS {
        let told = told(sitting.path(), format);
        let (numbers, findings) = back(&sitting.path().join(format).join(format!("monday/log.{format}")));
        assert_eq!(findings, [], "{format}");
        assert_same(column(&numbers, "time_s"), &[0.0, 0.01, 0.02, 0.03, 0.04], format);
        assert_same(column(&numbers, "pressure_kPa"), &[0.0, 10.0, 20.0, 30.0, 40.0], format);
        let of = |f: fn(usize) -> f64| (0..5).map(f).collect::<Vec<_>>();
        assert_same(column(&numbers, "stroke_mm"), &of(strokes), format);
        assert_same(column(&numbers, "bend_deg"), &of(bends), format);
        // To the bit in SI too: what is written stands for the number that was compared.
        let si = |value: &f64| Unit::parse("deg").unwrap().to_si(*value).to_bits();
        assert!(column(&numbers, "bend_deg").iter().map(si).eq(of(bends).iter().map(si)));
        // Units and origins stand in the record.
        let columns = told["data"][0]["files"].as_array().unwrap().iter().find(|f| f["run"] == "log.csv").unwrap()
            ["tables"][0]["columns"]
            .as_array()
            .unwrap();
        let of = |key: &str| columns.iter().map(|column| column[key].clone()).collect::<Vec<_>>();
        assert_eq!(of("unit"), ["s", "kPa", "mm", "deg", "mm"]);
        assert_eq!(of("origin"), ["time", "measured", "measured", "measured", "predicted"]);
        assert_eq!(columns[1]["title"], "Gauge pressure, air");
        assert_eq!((&columns[4]["form"], &columns[4]["title"]), (&"abaqus".into(), &"Stroke: Abaqus, C3D8H".into()));
    }
}

#[test]
fn the_units_stand_in_every_file() {
    let sitting = clocked();
    for format in FORMATS {
        export(sitting.path(), format);
    }
    let csv = recording(&sitting.path().join("csv/monday/log.csv"));
    let units: Vec<_> = csv.tables[0].columns.iter().map(|c| c.unit.as_deref().unwrap()).collect();
    assert_eq!(units, ["s", "kPa", "mm", "deg", "mm"]);
    let words = read_parquet_metadata(&sitting.path().join("parquet/monday/log.parquet")).unwrap();
    let (_, of_bend) = words.iter().find(|(key, _)| key == "pneuval.column.bend_deg").unwrap();
    assert_eq!(serde_json::from_str::<Value>(of_bend).unwrap()["unit"], "deg");
    let bag = recording(&sitting.path().join("mcap/monday/log.mcap"));
    let line = bag.metadata.iter().find_map(|l| l.strip_prefix("pneuval: /log.bend_deg = ")).unwrap();
    let of_bend: Value = serde_json::from_str(line).unwrap();
    assert_eq!((&of_bend["unit"], &of_bend["origin"]), (&"deg".into(), &"measured".into()));
}

/// A session of the embedded gripper at given pressures, with more of the manifest.
fn gripper(pressures: &[f64], more: &str) -> Sitting {
    let sitting = Sitting::new();
    sitting.write(
        "session.toml",
        &(SESSION
            .replace("my-bellows", "internal-support")
            .replace("[[run]]", "[clock]\ncolumn = \"t\"\nunit = \"ms\"\n\n[[run]]")
            .replace("{ id = \"stroke\", title = \"Stroke\"", "{ id = \"outer-diameter\", title = \"Outer diameter\"")
            .replace("chamber = \"air\"", "chamber = \"chamber\"")
            + more),
    );
    fs::remove_file(sitting.path().join("actuator.toml")).unwrap();
    sitting.write("log.csv", &log(pressures));
    sitting
}

#[test]
fn predictions_are_those_of_predict_at_the_same_pressure() {
    // A staircase with steps that come again, a vacuum, and a pressure beyond the end of the branch.
    let pressures = [0.0, 0.0, 3.7, 3.7, 12.5, 3.7, -2.0, 21.9, 3000.0];
    let sitting = gripper(&pressures, "");
    let mut arguments = vec!["predict", "internal-support", "--quantity", "outer-diameter", "--json"];
    let asked: Vec<String> = pressures.iter().map(|p| format!("{p} kPa")).collect();
    arguments.extend(asked.iter().flat_map(|p| ["--at", p]));
    let blocks: Value = serde_json::from_str(&pneuval(sitting.path(), &arguments).out).unwrap();
    let mm = Unit::parse("mm").unwrap();
    for format in FORMATS {
        let said = export(sitting.path(), format);
        assert_eq!(said.code, 0, "{}", said.err);
        let (numbers, _) = back(&sitting.path().join(format).join(format!("monday/log.{format}")));
        let (mut holes, mut values) = (0, 0);
        for form in blocks[0]["forms"].as_array().unwrap() {
            let name = form["form"].as_str().unwrap();
            let found = column(&numbers, &format!("outer_diameter_predicted_{}_mm", name.replace('-', "_")));
            for (found, expected) in found.iter().zip(form["predicted_si"].as_array().unwrap()) {
                match expected.as_f64() {
                    Some(si) => assert_eq!(mm.to_si(*found).to_bits(), si.to_bits(), "{format} {name}"),
                    None => assert!(found.is_nan(), "{format} {name}: {found}"),
                }
                *(if found.is_nan() { &mut holes } else { &mut values }) += 1;
            }
        }
        assert!(holes >= 2 && values >= 6, "{holes} {values}");
    }
}

#[test]
fn calibrated_forms_are_those_that_validate_judges() {
    let fit = |form: &str, hold_out: &str| {
        format!(
            "\n[[comparison]]\nquantity = \"outer-diameter\"\nform = \"{form}\"\nmodel = \"consistent\"\n\
             fit = {{ to = \"measured\", parameters = [\"C10\"], hold_out = \"{hold_out}\" }}\n"
        )
    };
    let more = fit("all", "none") + &fit("odd", "odd-pressures") + &fit("one-out", "one-pressure");
    let sitting = gripper(&[0.0, 5.0, 10.0, 15.0, 20.0], &more);
    let mut text = "t;pressure (kPa);stroke [mm];b\n".to_owned();
    for (i, d) in [30.0, 31.2, 32.3, 33.1, 33.9].iter().enumerate() {
        writeln!(text, "{};{};{d};0", 10 * i, 5 * i).unwrap();
    }
    sitting.write("log.csv", &text.replace('.', ","));
    assert_eq!(sitting.validate().code, 3);
    let results = sitting.results();
    let said = export(sitting.path(), "csv");
    assert_eq!(said.code, 0, "{}", said.err);
    let told: Value = serde_json::from_str(&said.out).unwrap();
    let (numbers, _) = back(&sitting.path().join("csv/monday/log.csv"));
    let (points, _) = back(&sitting.path().join("csv/monday/points.csv"));
    let mm = Unit::parse("mm").unwrap();
    for (index, form) in ["all", "odd", "one_out"].iter().enumerate() {
        let of = |key: &str| -> Vec<f64> {
            let points = results["comparisons"][index]["points"].as_array().unwrap();
            let value = |point: &Value| point[key].get(0).unwrap_or(&point[key]).as_f64().unwrap();
            points.iter().map(|point| mm.to_written(value(point))).collect()
        };
        assert_same(&points[&format!("outer_diameter_predicted_{form}_mm")], &of("predicted"), form);
        assert_same(&points[&format!("outer_diameter_residual_{form}_mm")], &of("residual"), form);
        if *form != "one_out" {
            // Every sample is a point, so the curve goes through them.
            assert_same(&numbers[&format!("outer_diameter_predicted_{form}_mm")], &of("predicted"), form);
        }
    }
    // One fit for each pressure is none between them.
    assert!(!numbers.keys().any(|name| name.contains("one_out")), "{:?}", numbers.keys());
    let left = &told["data"][0]["left_out"][0];
    assert_eq!(left["what"], "one-out of outer-diameter at every sample");
    assert!(left["why"].as_str().unwrap().contains("a fit of its own"), "{left}");
    let shown = pneuval(sitting.path(), &["export", ".", "--out", "csv", "--format", "csv"]);
    assert!(shown.out.contains("Left out: one-out of outer-diameter"), "{}", shown.out);
    // What was fitted says so wherever it goes, and a point in a fit is no validation.
    let text = fs::read_to_string(sitting.path().join("csv/pneuval_export.json")).unwrap();
    assert!(text.contains("C10 fitted to monday/outer-diameter measured"), "{text}");
    let points = fs::read_to_string(sitting.path().join("csv/monday/points.csv")).unwrap();
    assert!(points.contains("in_fit") && points.contains("zero_reference"), "{points}");
}

#[test]
fn a_fit_that_fails_is_left_out_and_a_wrong_form_is_an_error() {
    let comparison =
        |form: &str, fit: &str| format!("\n[[comparison]]\nquantity = \"outer-diameter\"\nform = \"{form}\"\n{fit}");
    let fit = "model = \"consistent\"\nfit = { to = \"measured\", parameters = [\"C10\", \"C20\"] }\n";
    let sitting = gripper(&[0.0, 5.0], &(comparison("fitted", fit) + &comparison("consistent", "")));
    let said = pneuval(sitting.path(), &["export", ".", "--out", "out", "--format", "csv"]);
    assert_eq!(said.code, 0, "{}", said.err);
    assert!(
        said.out.contains("Left out: fitted of outer-diameter: ") && said.out.contains("the fit of `fitted` failed"),
        "{}",
        said.out
    );
    assert!(said.out.contains("outer_diameter_predicted_consistent_mm"), "{}", said.out);
    let sitting = gripper(&[0.0, 5.0], &comparison("consistant", ""));
    let said = pneuval(sitting.path(), &["export", ".", "--out", "out"]);
    assert_eq!(said.code, 2);
    assert!(said.err.contains("session.toml:") && said.err.contains("did you mean `consistent`?"), "{}", said.err);
    assert!(!sitting.path().join("out").exists());
}

#[test]
fn conditions_are_those_of_the_sample() {
    let sitting = Sitting::new();
    sitting.write(
        "session.toml",
        &SESSION
            .replace("my-bellows", "fruit-finger")
            .replace("[[run]]", "[[channel]]\nid = \"held\"\ncolumn = \"h\"\nunit = \"deg\"\n\n[clock]\nrate = { value = 10, unit = \"Hz\" }\n\n[[run]]")
            .replace("id = \"stroke\"\ncolumn = \"stroke [mm]\"", "id = \"force\"\ncolumn = \"f\"\nunit = \"N\"")
            .replace("{ id = \"stroke\", title = \"Stroke\", unit = \"mm\" }", "{ id = \"tip-force\", title = \"Tip force\", unit = \"N\" }")
            .replace("chamber = \"air\" }]", "chamber = \"chamber\" }]\ncondition = [{ channel = \"held\", id = \"held_angle\", title = \"held at\" }]")
            .replace("channel = \"stroke\"", "channel = \"force\""),
    );
    fs::remove_file(sitting.path().join("actuator.toml")).unwrap();
    sitting.write("log.csv", "pressure (kPa),f,h\n20,0.1,0\n20,0.1,15\n40,0.5,15\n40,,30\n,0.2,30\n40,0.3,\n");
    let said = export(sitting.path(), "parquet");
    assert_eq!(said.code, 3, "holes in two of six samples: {}", said.err);
    let (numbers, _) = back(&sitting.path().join("parquet/monday/log.parquet"));
    let found = column(&numbers, "tip_force_predicted_consistent_proportional_N");
    for (row, (p, h)) in
        [("20 kPa", "0 deg"), ("20 kPa", "15 deg"), ("40 kPa", "15 deg"), ("40 kPa", "30 deg")].iter().enumerate()
    {
        let with = format!("held_angle = {h}");
        let arguments =
            ["predict", "fruit-finger", "--form", "consistent-proportional", "--at", p, "--with", &with, "--json"];
        let blocks: Value = serde_json::from_str(&pneuval(sitting.path(), &arguments).out).unwrap();
        // A hole in what was measured does not hide what is predicted.
        assert_eq!(Some(found[row]), blocks[0]["forms"][0]["predicted_si"][0].as_f64(), "{p} {h}");
    }
    assert!(found[4].is_nan() && found[5].is_nan(), "{found:?}");
    assert_same(column(&numbers, "time_s"), &[0.0, 0.1, 0.2, 0.3, 0.4, 0.5], "a stated rate");
    assert!(column(&numbers, "force_N")[3].is_nan());
}

#[test]
fn what_rounding_leaves_of_zero_is_zero_as_in_validate() {
    let sitting = gripper(&[90.02, 100.02, 110.02], "");
    sitting.change("session.toml", "reference = \"gauge\"", "reference = \"absolute\"");
    sitting.change(
        "session.toml",
        "file = \"log.csv\"",
        "file = \"log.csv\"\natmosphere = { value = 90.02000000000001, unit = \"kPa\" }",
    );
    assert_eq!(export(sitting.path(), "csv").code, 0);
    let (numbers, _) = back(&sitting.path().join("csv/monday/log.csv"));
    let (pressure, predicted) =
        (column(&numbers, "pressure_kPa"), column(&numbers, "outer_diameter_predicted_consistent_mm"));
    assert!(pressure[0] < 0.0 && pressure[0] > -1e-9 && predicted[0] == 30.0, "{pressure:?} {predicted:?}");
}

#[test]
fn a_synthetic_session_is_marked_in_every_file_and_no_other() {
    const MARK: &[u8] = b"SYNTHETIC: written by a program, not by an instrument";
    let sitting = clocked();
    let is_marked = |path: &Path| fs::read(path).unwrap().windows(MARK.len()).any(|window| window == MARK);
    for synthetic in [false, true] {
        for format in FORMATS {
            let told = told(sitting.path(), format);
            assert_eq!(told["data"][0]["synthetic"], synthetic);
            let files = told["data"][0]["files"].as_array().unwrap();
            assert!(files.len() == if format == "mcap" { 1 } else { 2 });
            for file in files {
                let path = sitting.path().join(format).join(file["file"].as_str().unwrap());
                assert_eq!(is_marked(&path), synthetic, "{}", path.display());
            }
        }
        let text = fs::read_to_string(sitting.path().join("csv/monday/log.csv")).unwrap();
        assert_eq!(text.starts_with("# SYNTHETIC: "), synthetic);
        let bag = recording(&sitting.path().join("mcap/monday/log.mcap"));
        let mark = format!("pneuval: warning = {}", String::from_utf8_lossy(MARK));
        assert_eq!(bag.metadata.contains(&mark), synthetic);
        assert_eq!(bag.metadata.iter().any(|line| line.contains("frame_id `SYNTHETIC`")), synthetic);
        let said = pneuval(sitting.path(), &["export", ".", "--out", "csv", "--format", "csv"]);
        assert_eq!(said.out.contains("monday: SYNTHETIC"), synthetic, "{}", said.out);
        sitting.change("session.toml", "id = \"monday\"", "id = \"monday\"\nsynthetic = true");
        if synthetic {
            break;
        }
    }
}

/// Names that end in what is no word, differ in case, or are those of other files of the export.
#[test]
fn runs_may_be_called_anything() {
    let names =
        ["a.csv", "A.csv", "a;b $(rm -rf).csv", "Läuf 1.csv", "points.csv", "--.csv", "2026-05-04.csv", "con.log"];
    let sitting = clocked();
    let runs = names.map(|name| format!("[[run]]\nfile = \"{name}\"\n")).concat();
    sitting.change("session.toml", "[[run]]\nfile = \"log.csv\"\n", &runs);
    for (i, name) in names.iter().enumerate() {
        let mut pressures = vec![0.0, 10.0, 20.0];
        pressures.push(i as f64);
        sitting.write(name, &log(&pressures));
    }
    for format in FORMATS {
        let told = told(sitting.path(), format);
        let files = told["data"][0]["files"].as_array().unwrap();
        let paths: Vec<&str> = files.iter().map(|file| file["file"].as_str().unwrap()).collect();
        let mut folded: Vec<String> = paths.iter().map(|path| path.to_lowercase()).collect();
        folded.sort();
        folded.dedup();
        assert_eq!(folded.len(), names.len() + usize::from(format != "mcap"), "{paths:?}");
        for path in paths {
            let name = path.strip_prefix("monday/").unwrap();
            assert!(
                name.chars().all(|c| c.is_ascii_alphanumeric() || "-_.".contains(c)) && !name.starts_with('.'),
                "{name}"
            );
            assert!(sitting.path().join(format).join(path).is_file());
        }
        for (i, name) in names.iter().enumerate() {
            let file = files.iter().find(|file| file["run"] == *name).unwrap();
            let path = sitting.path().join(format).join(file["file"].as_str().unwrap());
            assert_eq!(column(&back(&path).0, "pressure_kPa")[3], i as f64, "{name}");
            if let Some(topic) = file["tables"][0]["topic"].as_str() {
                // What Foxglove and ROS take for a name.
                let token = topic.strip_prefix('/').unwrap();
                assert!(token.starts_with(|c: char| c.is_ascii_alphabetic()), "{topic}");
                assert!(
                    token.chars().all(|c| c.is_ascii_alphanumeric() || c == '_') && !token.contains("__"),
                    "{topic}"
                );
            }
        }
    }
}

#[test]
fn the_same_data_make_the_same_bytes_and_take_the_place_of_an_earlier_export() {
    let sitting = clocked();
    for format in FORMATS {
        let first = told(sitting.path(), format);
        assert_eq!(told(sitting.path(), format), first, "digests of every file");
        let file = &first["data"][0]["files"][0];
        let bytes = fs::read(sitting.path().join(format).join(file["file"].as_str().unwrap())).unwrap();
        assert_eq!(file["sha256"], pneuval_ingest::digest::sha256(&bytes));
        assert_eq!(file["bytes"], bytes.len());
    }
    // Another format in the same folder leaves nothing of the first.
    assert_eq!(pneuval(sitting.path(), &["export", ".", "--out", "csv", "--format", "parquet"]).code, 0);
    assert!(
        !sitting.path().join("csv/monday/log.csv").exists() && sitting.path().join("csv/monday/log.parquet").is_file()
    );
    // Something of somebody else's stays, and so does a report.
    sitting.write("csv/monday/mine.txt", "mine");
    let said = pneuval(sitting.path(), &["export", ".", "--out", "csv"]);
    assert_eq!(said.code, 2);
    assert!(said.err.contains("an earlier export") && said.err.contains("`monday/mine.txt`"), "{}", said.err);
    assert!(sitting.path().join("csv/monday/log.parquet").is_file());
    sitting.validate();
    let said = pneuval(sitting.path(), &["export", ".", "--out", "report"]);
    assert!(said.code == 2 && said.err.contains("no export of this program"), "{}", said.err);
    assert!(sitting.path().join("report/index.html").is_file());
}

#[test]
fn printed_tables_are_tables_and_have_no_time() {
    let lab = Lab::new();
    let said = pneuval(lab.path(), &["export", ".", "--out", "out"]);
    assert_eq!(said.code, 2);
    assert!(
        said.err.contains("balloon: printed tables have no time") && said.err.contains("--format csv"),
        "{}",
        said.err
    );
    assert!(!lab.path().join("out").exists());
    lab.change("size.csv", "28.000000", "");
    for format in ["csv", "parquet"] {
        let said = export(lab.path(), format);
        assert_eq!(said.code, 0, "{}", said.err);
        let (numbers, _) = back(&lab.path().join(format).join(format!("balloon/size.{format}")));
        assert_same(&numbers["pressure_air_kPa"], &[0.0, 10.0, 20.0, 30.0], format);
        assert_same(&numbers["size_measured_mm"], &[10.0, 20.0, 30.0, 40.0], format);
        assert_same(&numbers["size_predicted_model_mm"], &[10.5, 21.0, f64::NAN, 43.0], format);
        let residual = &numbers["size_residual_model_mm"];
        assert!((residual[1] - 1.0).abs() < 1e-12 && residual[2].is_nan(), "{residual:?}");
        // Half a unit of the last printed digit.
        assert!((numbers["size_half_width_mm"][1] - 5e-7).abs() < 1e-15);
    }
    // A printed column that nothing is compared with is exported all the same.
    let text = fs::read_to_string(lab.path().join("dataset.toml")).unwrap();
    lab.write("dataset.toml", text.split("[[comparison]]").next().unwrap());
    assert_eq!(export(lab.path(), "csv").code, 0);
    assert_same(
        &back(&lab.path().join("csv/balloon/size.csv")).0["size_predicted_model_mm"],
        &[10.5, 21.0, f64::NAN, 43.0],
        "uncompared",
    );
}

#[test]
fn the_embedded_papers_export_and_keep_their_conditions() {
    let folder = tempfile::tempdir().unwrap();
    let said = pneuval(folder.path(), &["export", "--out", "out", "--format", "csv"]);
    assert_eq!(said.code, 0, "{}", said.err);
    let text = fs::read_to_string(folder.path().join("out/fruit-finger/tip-force.csv")).unwrap();
    assert!(text.starts_with("pressure_chamber_kPa,held_angle_deg,tip_force_measured_N,"), "{text}");
    let (numbers, _) = back(&folder.path().join("out/fruit-finger/tip-force.csv"));
    assert_eq!((numbers["held_angle_deg"].len(), numbers["held_angle_deg"][2]), (27, 15.0));
    // The fit of each pressure to the others, at that pressure.
    assert!(numbers["tip_force_predicted_leave_one_pressure_out_N"].iter().all(|v| v.is_finite()));
    let (numbers, _) = back(&folder.path().join("out/internal-support/outer-diameter.csv"));
    assert_same(&numbers["outer_diameter_measured_mm"][..3], &[30.0, 33.44, 35.67], "as printed");
}

#[test]
fn a_session_and_a_dataset_in_one_folder() {
    let sitting = clocked();
    fs::create_dir(sitting.path().join("paper")).unwrap();
    let lab = Lab::new();
    for name in ["actuator.toml", "dataset.toml", "size.csv"] {
        fs::copy(lab.path().join(name), sitting.path().join("paper").join(name)).unwrap();
    }
    let said = pneuval(sitting.path(), &["export", ".", "--out", "out"]);
    assert_eq!(said.code, 0, "{}", said.err);
    assert!(
        said.out.contains("monday/log.mcap") && said.out.contains("Left out: balloon: printed tables have no time"),
        "{}",
        said.out
    );
    assert!(!sitting.path().join("out/balloon").exists());
}

#[test]
fn dates_are_the_stamps_of_messages_and_other_clocks_begin_in_1970() {
    let sitting = clocked();
    let stamps = |path: &str| {
        let bag = recording(&sitting.path().join(path));
        let table = bag.tables[0].clone();
        (bag.origin.unwrap(), of_table(&table)["header.stamp"].clone(), bag.metadata)
    };
    assert_eq!(export(sitting.path(), "mcap").code, 0);
    let (origin, times, metadata) = stamps("mcap/monday/log.mcap");
    assert_eq!((origin.as_str(), &times[..]), ("1970-01-01T00:00:00Z", &[0.0, 0.01, 0.02, 0.03, 0.04][..]));
    assert!(metadata.iter().any(|line| line.contains("no date is known")), "{metadata:?}");

    sitting.change("session.toml", "unit = \"ms\"\n", "");
    let mut text = "t;pressure (kPa);stroke [mm];b\n".to_owned();
    for i in 0..3 {
        writeln!(text, "22.11.2026 09:13:0{i},250;{};0;0", 10 * i).unwrap();
    }
    sitting.write("log.csv", &text);
    assert_eq!(export(sitting.path(), "mcap").code, 0);
    let (origin, times, metadata) = stamps("mcap/monday/log.mcap");
    assert_eq!((origin.as_str(), &times[..]), ("2026-11-22T09:13:00Z", &[0.25, 1.25, 2.25][..]));
    let time = metadata.iter().find(|line| line.starts_with("pneuval: time = ")).unwrap();
    assert!(time.contains("2026-11-22T09:13:00") && time.contains("zone is not stated"), "{time}");

    // A clock that begins below zero, and one whose stamps are no moments.
    sitting.write(
        "log.csv",
        "t;pressure (kPa);stroke [mm];b\n-1,5;0;0;0\n-0,5;10;1;0\n0,5;20;2;0\n0,2;20;2;0\n1e12;20;2;0\n",
    );
    sitting.change("session.toml", "column = \"t\"", "column = \"t\"\nunit = \"s\"");
    let told = told(sitting.path(), "mcap");
    let (origin, times, metadata) = stamps("mcap/monday/log.mcap");
    assert_eq!((origin.as_str(), &times[..]), ("1970-01-01T00:00:00Z", &[0.5, 1.5, 2.5][..]));
    assert!(metadata.iter().any(|line| line.contains("time_s 0 is 2 s after 1970")), "{metadata:?}");
    let left = told["data"][0]["left_out"][1]["what"].as_str().unwrap();
    assert_eq!(left, "2 of 5 samples of /log of run log.csv of monday");
    export(sitting.path(), "csv");
    assert_same(
        &back(&sitting.path().join("csv/monday/log.csv")).0["time_s"],
        &[-1.5, -0.5, 0.5, f64::NAN, 1e12],
        "all samples",
    );
}

#[test]
fn samples_without_a_clock_are_states_and_no_messages() {
    let sitting = Sitting::new();
    let said = pneuval(sitting.path(), &["export", ".", "--out", "out"]);
    assert_eq!(said.code, 2);
    assert!(said.err.contains("run log.csv of monday: it has no clock"), "{}", said.err);
    assert_eq!(export(sitting.path(), "csv").code, 0);
    let text = fs::read_to_string(sitting.path().join("csv/monday/log.csv")).unwrap();
    assert!(
        text.starts_with("pressure_kPa,stroke_mm,stroke_predicted_abaqus_mm\nkPa,mm,mm\n0.0,0.0,0.0\n10.0,5.2,5.0\n"),
        "{text}"
    );
}

#[test]
fn every_clock_has_a_topic_and_predictions_stand_where_the_pressure_is() {
    let rows = 40;
    let numbers = |f: &dyn Fn(usize) -> f64| Cells::Numbers((0..rows).map(f).collect());
    let stamped = |name: &str, delay: f64, columns: Vec<Column>| {
        let stamp = Column::new("log_time", Some("s"), numbers(&|i| i as f64 / 100.0 + delay));
        let columns = [vec![stamp], columns].concat();
        let (lines, decimal) = (LineMap::default(), Decimal::Point);
        Table { name: name.to_owned(), schema: None, columns, rows, lines, clock: None, decimal }
    };
    let pressure = |i: usize| 10e3 * (i / 10) as f64;
    let tables = [
        stamped(
            "/rig",
            0.0,
            vec![
                Column::new("p", None, numbers(&pressure)),
                Column::new("stroke", None, numbers(&|i| 1e-6 * pressure(i))),
            ],
        ),
        stamped("/pose", 0.003, vec![Column::new("x", None, numbers(&|i| i as f64))]),
    ];
    let mut bytes = Cursor::new(vec![]);
    let options = mcap::WriteOptions { origin_s: 1_763_800_000, ..mcap::WriteOptions::default() };
    mcap::write(&mut bytes, &tables, &options).unwrap();
    let session = SESSION
        .replace("column = \"pressure (kPa)\"", "column = \"/rig.p\"\nunit = \"Pa\"\ncommanded = true")
        .replace("column = \"stroke [mm]\"", "column = \"/rig.stroke\"\nunit = \"m\"")
        .replace("[[run]]", "[[channel]]\nid = \"pose\"\ncolumn = \"/pose.x\"\nunit = \"m\"\n\n[[run]]")
        .replace("log.csv", "run.mcap");
    let folder = common::sitting::with_log(&session, "run.mcap", bytes.get_ref());
    assert_eq!(export(folder.path(), "mcap").code, 0);
    let bag = recording(&folder.path().join("mcap/monday/run.mcap"));
    assert_eq!(bag.origin.as_deref(), Some("2025-11-22T08:26:40Z"), "the origin of the log");
    let topics: Vec<_> = bag.tables.iter().map(|t| (t.name.as_str(), t.schema.as_deref().unwrap())).collect();
    assert_eq!(topics, [("/run/pose", "pneuval_msgs/msg/MondayPose"), ("/run/rig", "pneuval_msgs/msg/MondayRig")]);
    let (pose, rig) = (of_table(&bag.tables[0]), of_table(&bag.tables[1]));
    assert!(!pose.keys().any(|name| name.contains("predicted")), "{:?}", pose.keys());
    // At the same moment, in the same message: asked-for pressure, what was measured, what is predicted.
    assert_eq!((rig["pressure_commanded_pa"][25], rig["stroke_predicted_abaqus_mm"][25]), (20e3, 10.0));
    assert!((pose["header.stamp"][0] - 0.003).abs() < 1e-12);
    assert_eq!(export(folder.path(), "csv").code, 0);
    assert!(
        folder.path().join("csv/monday/run.pose.csv").is_file()
            && folder.path().join("csv/monday/run.rig.csv").is_file()
    );
    let points = fs::read_to_string(folder.path().join("csv/pneuval_export.json")).unwrap();
    assert!(points.contains("\"commanded\""), "{points}");
}

#[test]
fn several_responses_share_the_table_of_points() {
    let sitting = clocked();
    let text = fs::read_to_string(sitting.path().join("session.toml")).unwrap();
    let more = "\n[[response]]\nquantity = { id = \"bend\", title = \"Bend\", unit = \"deg\" }\n\
                pressure = [{ channel = \"pressure\", chamber = \"air\" }]\nmeasured = { channel = \"bend\" }\n";
    sitting.write("session.toml", &(text + more));
    assert_eq!(export(sitting.path(), "parquet").code, 0);
    let path = sitting.path().join("parquet/monday/points.parquet");
    let columns: BTreeMap<String, Series> = read_parquet(&path).unwrap().into_iter().collect();
    let words = |name: &str| match &columns[name] {
        Series::Text(words) => words.clone(),
        Series::Number(_) => panic!("{name}"),
    };
    assert_eq!((words("quantity")[4].as_str(), words("quantity")[5].as_str()), ("stroke", "bend"));
    let numbers = back(&path).0;
    assert_same(&numbers["pressure_air_kPa"], &[0.0, 10.0, 20.0, 30.0, 40.0, 0.0, 10.0, 20.0, 30.0, 40.0], "pressures");
    assert_same(&numbers["bend_measured_deg"][4..7], &[f64::NAN, 7.3, 7.5], "what one lacks is a hole");
    assert!(numbers["stroke_predicted_abaqus_mm"][5..].iter().all(|v| v.is_nan()));
    // One repeat of an instrument that declares nothing: no interval, not one of no width.
    assert!(numbers["stroke_half_width_mm"].iter().all(|v| v.is_nan()));
}

#[test]
fn holes_stay_holes_and_lost_data_are_told() {
    let sitting = clocked();
    sitting.change("log.csv", ";15,7;", ";ERR;");
    let expected = [0.1, f64::NAN, 31.4, 7.3, 4.35];
    for format in FORMATS {
        let said = export(sitting.path(), format);
        assert_eq!(said.code, 3, "one of five samples is more than a session allows: {}", said.err);
        assert!(said.err.contains("excluded: monday, log.csv: ") && said.err.contains("`ERR`"), "{}", said.err);
        let (numbers, _) = back(&sitting.path().join(format).join(format!("monday/log.{format}")));
        assert_same(column(&numbers, "stroke_mm"), &expected, format);
    }
    let text = fs::read_to_string(sitting.path().join("csv/monday/log.csv")).unwrap();
    assert!(text.contains("\n0.01,10.0,,7.5,5.0\n"), "{text}");
    sitting.write("log.csv", "no sensor\n");
    let said = export(sitting.path(), "csv");
    assert_eq!(said.code, 4, "{}", said.err);
    assert!(sitting.path().join("csv/monday/log.csv").is_file(), "the earlier export stays");
}

#[test]
fn an_actuator_of_ones_own_needs_no_response() {
    let sitting = clocked();
    let text = fs::read_to_string(sitting.path().join("session.toml")).unwrap();
    sitting.write("session.toml", text.split("[[response]]").next().unwrap());
    sitting.write("actuator.toml", ACTUATOR.split("[[model]]").next().unwrap());
    for format in FORMATS {
        let told = told(sitting.path(), format);
        assert_eq!(told["data"][0]["files"].as_array().unwrap().len(), 1, "channels alone, and no points");
        assert_eq!(told["data"][0]["left_out"], serde_json::json!([]));
    }
}
