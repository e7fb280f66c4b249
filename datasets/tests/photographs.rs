//! Rehearsed photographs: rendered bodies against the reader's own measurement, and sessions of pictures with their truth.

// Helpers of tests may unwrap and panic, as tests do.
#![allow(clippy::unwrap_used, clippy::panic)]

use std::collections::BTreeMap;
use std::path::Path;

use pneuval_datasets::rehearse::photo::{
    Bending, Body, Camera, Finger, Light, Marker, Profile, Settings, body, finger as rehearsed_finger,
};
use pneuval_datasets::rehearse::{Rehearsal, Request};
use pneuval_ingest::camera::area::SoughtArea;
use pneuval_ingest::camera::bending::SoughtBending;
use pneuval_ingest::camera::bending::markers::SoughtMarkers;
use pneuval_ingest::camera::decode::decode;
use pneuval_ingest::camera::picture::{Picture, Place};
use pneuval_ingest::camera::scale::{Length, Scale};
use pneuval_ingest::camera::silhouette::Sought;
use pneuval_ingest::camera::task::{Sense, Setup, Task, What};
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

fn diameter(setup: Setup) -> Task {
    Task { what: What::Diameter(Sought::default()), setup }
}

/// A barrel of R = 20 mm at Z = 300 mm, 0.1 mm a px.
fn diameter_mm(camera: &Camera, settings: &Settings, setup: Setup, seed: u64) -> (f64, f64) {
    let profile = Profile::Barrel { middle_radius_m: 0.02, end_radius_m: 0.016, length_m: 0.03 };
    let shot = body(&Body { profile, rod_radius_m: 0.006, foot_m: 0.0 }, camera, settings, seed).unwrap();
    assert!((shot.truth.diameter_m - 0.04).abs() < 1e-15);
    let value = diameter(setup).measure(&shot.picture).unwrap().values[0];
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
    // Wider than long, between sharp corners: its width lies between them.
    let profile = Profile::Barrel { middle_radius_m: 0.02, end_radius_m: 0.02, length_m: 0.012 };
    let shot = body(&Body { profile, rod_radius_m: 0.006, foot_m: 0.0 }, &camera, &settings, 1).unwrap();
    let value = diameter(near).measure(&shot.picture).unwrap().values[0];
    assert!((value.value - 40.0).abs() < 0.02, "{value:?}");
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
    let mut tilts = vec![];
    for ((name, bytes), told) in pictures.iter().zip(told) {
        assert_eq!(name.strip_prefix("run-1/").unwrap(), told["name"].as_str().unwrap());
        let number = |key: &str| told[key].as_f64().unwrap();
        // With the true camera, the true value.
        let setup = Setup {
            scale: Some(Scale { metre_per_px: number("metre_per_px"), std: 0.0 }),
            distance: Some(Length { metre: number("distance_m"), std: 0.0 }),
            ..Setup::default()
        };
        let values = diameter(setup).measure(&decode(bytes).unwrap()).unwrap().values;
        let value = values[0];
        tilts.push(values[1]);
        // Half a pixel is 0.025 mm; the outline has kinks where the wall meets its plates.
        assert!((value.value - 1e3 * number("value_si")).abs() < 0.01, "{name}: {value:?} {}", number("value_si"));
    }
    // The camera hangs where it hangs, whatever the pressure: the first picture, of a cylinder, knows its tilt best.
    for tilt in &tilts[1..] {
        assert!((tilt.value - tilts[0].value).abs() < 4.0 * tilt.std.hypot(tilts[0].std), "{tilts:?}");
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

/// What is told of each picture, beside the picture.
fn pictures_of(files: &BTreeMap<String, Vec<u8>>) -> Vec<(serde_json::Value, Picture)> {
    let truth = truth(files);
    let told: Vec<_> =
        truth["runs"].as_array().unwrap().iter().flat_map(|run| run["pictures"].as_array().unwrap().clone()).collect();
    let picture =
        |name: &str| decode(files.iter().find(|(path, _)| path.ends_with(&format!("/{name}"))).unwrap().1).unwrap();
    told.into_iter()
        .map(|told| {
            let picture = picture(told["name"].as_str().unwrap());
            (told, picture)
        })
        .collect()
}

/// A camera as it truly was.
fn true_setup(told: &serde_json::Value) -> Setup {
    let number = |key: &str| told[key].as_f64().unwrap();
    let scale = Scale { metre_per_px: number("metre_per_px"), std: 0.0 };
    let distance = Length { metre: number("distance_m"), std: 0.0 };
    Setup { scale: Some(scale), distance: Some(distance), ..Setup::default() }
}

#[test]
fn angles_and_tips_of_a_film_are_measured_to_a_fifth_of_a_degree_and_of_a_pixel() {
    let ideal = Request { repeats: 1, ideal: true, ..Request::default() };
    let films = rehearsed("wave-finger-photographs", ideal).unwrap();
    for (told, picture) in pictures_of(&films) {
        let what = What::Angle(SoughtBending::default(), Sense::Counterclockwise);
        let setup = true_setup(&told);
        let seen = Task { what, setup }.measure(&picture).unwrap_or_else(|why| panic!("{told}: {why}")).values;
        let angle = seen[0].value - told["value_si"].as_f64().unwrap().to_degrees();
        let px = |i: usize| {
            1e-3 * seen[i + 1].value / setup.scale.unwrap().metre_per_px
                - told["tip_m"][i].as_f64().unwrap() / told["metre_per_px"].as_f64().unwrap()
        };
        let tip = px(0).hypot(px(1));
        assert!(angle.abs() < 0.2 && tip < 0.2, "{told}: {angle} {tip} {seen:?}");
    }
}

#[test]
fn markers_on_a_finger_tell_its_angle_and_tip_too() {
    let camera = Camera { shift_m: [-0.03, -0.04], ..Camera::facing(560, 480, 2.5e-4, 0.5) };
    let red = [0.75, 0.08, 0.06];
    let mut finger = Finger {
        bending: Bending::Constant(0.0),
        length_m: 0.1,
        width_m: 0.014,
        waves: (0, 0.0),
        markers: [0.0, 0.022, 0.045, 0.07, 0.093].map(|at_m| Marker { at_m, radius_m: 0.002, light: red }).into(),
    };
    let settings =
        Settings { noise: 2.0, blur_px: 1.4, glare: 0.3, clutter: true, is_colour: true, ..Settings::default() };
    let scale = Some(Scale { metre_per_px: 2.5e-4, std: 0.0 });
    let mut held = 0;
    for (seed, degrees) in [(1_u32, 5.0_f64), (2, 60.0), (3, 120.0), (4, 170.0), (5, -40.0)] {
        finger.bending = Bending::Constant(degrees.to_radians());
        let shot = rehearsed_finger(&finger, &camera, &settings, u64::from(seed)).unwrap();
        let sought = SoughtMarkers {
            colour: red.map(|light: f32| f64::from(255.0 * light)),
            count: 5,
            root: shot.truth.root_px + Place::new(4.0, -3.0),
            region: None,
            heading_rad: None,
        };
        let what = What::Markers(sought, Sense::Counterclockwise);
        let seen = Task { what, setup: Setup { scale, ..Setup::default() } }.measure(&shot.picture).unwrap();
        let [along, across] = shot.truth.markers[4].0;
        let angle = seen.values[0].value - degrees;
        let tip = (1e-3 * seen.values[1].value - along).hypot(1e-3 * seen.values[2].value - across) / 2.5e-4;
        assert!(angle.abs() < 0.2 && tip < 0.1, "{degrees}: {angle} {tip} {:?}", seen.values);
        held += usize::from(angle.abs() < 1.96 * seen.values[0].std);
        // One hidden, one too many: said, not measured.
        let of = |count: usize| Task {
            what: What::Markers(SoughtMarkers { count, ..sought }, Sense::Clockwise),
            setup: Setup::default(),
        };
        let why = [4, 6].map(|count| of(count).measure(&shot.picture).unwrap_err());
        assert!(why[0].contains("5 spots") && why[1].contains("5 of 6"), "{why:?}");
    }
    assert!(held >= 3, "{held} of 5");
}

#[test]
fn areas_of_imprints_are_measured_to_half_a_percent_and_their_intervals_hold() {
    let ideal = Request { repeats: 3, ideal: true, ..Request::default() };
    let imprints = rehearsed("pdms-wall-photographs", ideal).unwrap();
    let (mut held, mut all) = (0, 0);
    for (told, picture) in pictures_of(&imprints) {
        let seen = Task { what: What::Area(SoughtArea::default()), setup: true_setup(&told) }
            .measure(&picture)
            .unwrap()
            .values;
        let area = told["value_si"].as_f64().unwrap() * 1e6;
        assert!((seen[0].value / area - 1.0).abs() < 0.005, "{told}: {seen:?}");
        held += usize::from((seen[0].value - area).abs() < 1.96 * seen[0].std);
        all += 1;
    }
    assert!(all >= 3 && held + 1 >= all, "{held} of {all}");
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
