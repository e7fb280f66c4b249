//! Rehearsed photographs: rendered bodies against the reader's own measurement, and sessions of pictures with their truth.

// Helpers of tests may unwrap and panic, as tests do.
#![allow(clippy::unwrap_used, clippy::panic)]

use std::collections::BTreeMap;
use std::path::Path;

use pneuval_datasets::rehearse::photo::{Body, Camera, Light, Profile, Settings, body};
use pneuval_datasets::rehearse::{Rehearsal, Request};
use pneuval_ingest::camera::decode::decode;
use pneuval_ingest::camera::scale::{Length, Scale};
use pneuval_ingest::camera::task::{Setup, Task};
use pneuval_ingest::document::Document;
use pneuval_ingest::error::IngestError;
use pneuval_ingest::formats::Format;

/// All files of a rehearsal.
fn rehearsed(plan: &str, request: Request) -> Result<BTreeMap<String, Vec<u8>>, String> {
    let rehearsal = Rehearsal::find(plan, Path::new("."), request).map_err(|error| error.to_string())?;
    let mut files = BTreeMap::new();
    let mut sink = |name: &str, bytes: &[u8]| -> Result<(), IngestError> {
        files.insert(name.to_owned(), bytes.to_vec());
        Ok(())
    };
    rehearsal.write(&mut sink).map_err(|error| error.to_string())?;
    Ok(files)
}

fn truth(files: &BTreeMap<String, Vec<u8>>) -> serde_json::Value {
    serde_json::from_slice(&files["truth.json"]).unwrap()
}

fn text<'f>(files: &'f BTreeMap<String, Vec<u8>>, name: &str) -> &'f str {
    std::str::from_utf8(&files[name]).unwrap()
}

/// A barrel of R = 20 mm at Z = 300 mm, 0.1 mm a px.
fn diameter_mm(camera: &Camera, settings: &Settings, setup: Setup, seed: u64) -> (f64, f64) {
    let profile = Profile::Barrel { middle_radius_m: 0.02, end_radius_m: 0.016, length_m: 0.03 };
    let shot = body(&Body { profile, rod_radius_m: 0.006, foot_m: 0.0 }, camera, settings, seed).unwrap();
    assert!((shot.truth.diameter_m - 0.04).abs() < 1e-15);
    let value = Task::Diameter(setup).measure(&shot.picture).unwrap().values[0];
    (value.value, value.std)
}

#[test]
fn the_reader_measures_what_was_rendered_and_without_a_distance_what_it_looks_like() {
    let camera = Camera::facing(720, 540, 1e-4, 0.3);
    let settings = Settings::default();
    let scale = Some(Scale { metre_per_px: 1e-4, std: 0.0 });
    let near = Setup { scale, distance: Some(Length { metre: 0.3, std: 0.0 }), ..Setup::default() };
    for seed in 0..3 {
        let (value, std) = diameter_mm(&camera, &settings, near, seed);
        assert!((value - 40.0).abs() < 0.005 && (value - 40.0).abs() < 4.0 * std, "{seed}: {value} {std}");
    }
    // R = 20 mm at Z = 300 mm seems larger by 0.089 mm.
    let (value, _) = diameter_mm(&camera, &settings, Setup { scale, ..Setup::default() }, 1);
    assert!((value - 40.089).abs() < 0.005, "{value}");
    // Turned, aside, in uneven light, with a cable.
    let aside = Camera { roll_rad: 0.02, shift_m: [0.003, -0.002], ..camera };
    let light = Light { slope: [0.1, -0.05], fall_off: 0.05 };
    let (value, _) = diameter_mm(&aside, &Settings { light, clutter: true, ..settings }, near, 1);
    assert!((value - 40.0).abs() < 0.03, "{value}");
    // Behind a lens that is known.
    let mut bent = camera;
    bent.lens.radial = [-0.1, 0.05, 0.0];
    let (value, _) = diameter_mm(&bent, &settings, Setup { lens: Some(bent.lens), ..near }, 1);
    assert!((value - 40.0).abs() < 0.03, "{value}");
    let (wrong, _) = diameter_mm(&bent, &settings, near, 1);
    assert!((wrong - 40.0).abs() > 0.01, "a lens that is not taken into account shows: {wrong}");
}

#[test]
fn one_photograph_stands_for_each_state_and_shows_the_true_diameter() {
    let request = Request { repeats: 1, ..Request::default() };
    let files = rehearsed("internal-support-photographs", request.clone()).unwrap();
    assert_eq!(
        files,
        rehearsed("internal-support-photographs", request.clone()).unwrap(),
        "the same seed, the same bytes"
    );
    let pictures: Vec<(&String, &Vec<u8>)> = files.iter().filter(|(name, _)| name.starts_with("run-1/")).collect();
    let truth = truth(&files);
    let told = truth["runs"][0]["pictures"].as_array().unwrap();
    assert_eq!((pictures.len(), told.len()), (6, 6));
    for ((name, bytes), told) in pictures.iter().zip(told) {
        assert_eq!(name.strip_prefix("run-1/").unwrap(), told["name"].as_str().unwrap());
        let number = |key: &str| told[key].as_f64().unwrap();
        // With the true camera, the true value.
        let setup = Setup {
            scale: Some(Scale { metre_per_px: number("metre_per_px"), std: 0.0 }),
            distance: Some(Length { metre: number("distance_m"), std: 0.0 }),
            ..Setup::default()
        };
        // The outline has kinks where the wall meets its plates: no smooth curve follows them closely.
        let value = Task::Diameter(setup).measure(&decode(bytes).unwrap()).unwrap().values[0];
        assert!((value.value - 1e3 * number("value_si")).abs() < 0.15, "{name}: {value:?} {}", number("value_si"));
    }
    let session = text(&files, "session.toml");
    for words in ["measure = \"diameter\"", "names = \"{n}_pressure_{pressure:kPa}.png\"", "from = \"samples\""] {
        assert!(session.contains(words), "{words}\n{session}");
    }
    let other = rehearsed("internal-support-photographs", Request { seed: 2, ..request }).unwrap();
    let scale = |truth: &serde_json::Value| truth["runs"][0]["pictures"][0]["metre_per_px"].as_f64().unwrap();
    let off = scale(&self::truth(&other)) / scale(&truth) - 1.0;
    assert!(off.abs() > 1e-6 && off.abs() < 2e-3, "another seed is another camera: {off}");
}

#[test]
fn a_film_has_its_pictures_at_their_times_and_an_imprint_its_area() {
    let ideal = Request { repeats: 1, ideal: true, ..Request::default() };
    let files = rehearsed("wave-finger-photographs", ideal.clone()).unwrap();
    let told = truth(&files);
    let pictures = told["runs"][0]["pictures"].as_array().unwrap();
    assert!(files.contains_key("run-1-rig.csv") && pictures.len() > 10);
    for (i, picture) in pictures.iter().enumerate() {
        assert!((picture["at_s"].as_f64().unwrap() - 0.5 * i as f64).abs() < 1e-12);
        let [along, across] = [0, 1].map(|k| picture["tip_m"][k].as_f64().unwrap());
        // An arc over 106 mm, and 9 mm straight.
        let angle = picture["value_si"].as_f64().unwrap();
        let chord = if angle.abs() < 1e-9 { 0.106 } else { 0.212 * (0.5 * angle).sin() / angle };
        let ends = |of: fn(f64) -> f64| chord * of(0.5 * angle) + 0.009 * of(angle);
        assert!((along - ends(f64::cos)).abs() < 1e-6 && (across - ends(f64::sin)).abs() < 1e-6, "{picture}");
    }
    let largest = pictures.iter().map(|p| p["value_si"].as_f64().unwrap()).fold(0.0, f64::max);
    assert!((largest.to_degrees() - 168.0).abs() < 0.01, "{largest}");
    assert!(text(&files, "session.toml").contains("camera = { measure = \"angle\""));
    let files = rehearsed("pdms-wall-photographs", ideal).unwrap();
    let told = truth(&files);
    let areas: Vec<f64> =
        [0, 1, 2].map(|run| told["runs"][run]["pictures"][0]["value_si"].as_f64().unwrap() * 1e6).into();
    assert!(areas.iter().zip([424.4, 498.5, 542.3]).all(|(area, printed)| (area - printed).abs() < 1e-3), "{areas:?}");
    // At rest there is no contact: one picture a run.
    let name = files.keys().find(|name| name.contains("1_pressure_34.47_wall_1.50_contact_pressure_")).unwrap();
    assert_eq!(told["runs"][0]["pictures"].as_array().unwrap().len(), 1);
    let picture = decode(&files[name]).unwrap();
    assert!(picture.is_colour());
    // Red paint, as far as it covers: at most a part of a pixel is not told.
    let is_paint = |i: usize| picture.rgb(i % 720, i / 720)[1] < 100.0;
    let painted = (0..720 * 600).filter(|i| is_paint(*i)).count() as f64 * 0.06 * 0.06;
    assert!(areas.iter().any(|area| (painted / area - 1.0).abs() < 0.01), "{name}: {painted} {areas:?}");
}

#[test]
fn what_a_camera_cannot_do_is_refused_with_its_line() {
    let plan = pneuval_datasets::rehearse::plan_text("internal-support-photographs", Path::new(".")).unwrap();
    assert!(Document::new("plan.toml", plan.as_bytes()).is_ok());
    let refused = |from: &str, to: &str| {
        assert!(plan.contains(from), "{from}");
        let request = Request { repeats: 1, ..Request::default() };
        let rehearsal = Rehearsal::of_text("plan.toml", &plan.replacen(from, to, 1), request);
        let written =
            rehearsal.map_err(|e| e.to_string()).and_then(|r| r.write(&mut |_, _| Ok(())).map_err(|e| e.to_string()));
        written.unwrap_err()
    };
    for (from, to, words) in [
        ("format = \"pictures\"", "format = \"csv\"", "[device.camera]"),
        ("channel = \"diameter\"", "channel = \"width\"", "seen in its pictures"),
        ("unit = \"mm\"\ndecimals = 6", "unit = \"kPa\"\ndecimals = 6", "a length"),
        ("moments = \"stations\"", "moments = \"film\"", "alone"),
        ("size = [960, 720]", "size = [9, 720]", "64 to 4000 px"),
        ("blur = 1.2", "blur = nan", "0 to 20"),
        ("distance = { value = 300", "distance = { value = 0", "distance"),
        ("length = { value = 28", "length = { value = -28", "-28"),
    ] {
        let error = refused(from, to);
        assert!(error.contains(words) && error.contains("plan.toml"), "{to}: {error}");
    }
    // Faults are those of logs; another format is none for a camera.
    let fault = Request { faults: vec!["flatline".parse().unwrap()], ..Request::default() };
    let error = rehearsed("internal-support-photographs", fault).unwrap_err();
    assert!(error.contains("faults are those of logs"), "{error}");
    let csv = Request { repeats: 1, format: Some(Format::Csv), ..Request::default() };
    let files = rehearsed("internal-support-photographs", csv).unwrap();
    assert!(files.keys().any(|name| name.starts_with("run-1/")) && !files.contains_key("run-1.csv"));
}
