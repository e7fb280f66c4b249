//! Photographs through the binary: `measure`, and sessions whose channel is what is measured in pictures.

// In a test a panic is how a failure is told.
#![allow(clippy::unwrap_used, clippy::panic)]

mod common;
#[path = "common/photo.rs"]
mod photo;

use std::fs;
use std::path::Path;

use common::pneuval;
use image::ImageFormat;
use photo::Photo;
use serde_json::Value;

fn measured(folder: &Path, arguments: &[&str]) -> (i32, Vec<Value>, String) {
    let said = pneuval(folder, &[&["measure", "diameter"], arguments, &["--json"]].concat());
    (said.code, serde_json::from_str(&said.out).unwrap_or_default(), said.err)
}

fn number(told: &Value, name: &str) -> (f64, f64) {
    let value = told["values"].as_array().unwrap().iter().find(|v| v["name"] == name).unwrap();
    (value["value"].as_f64().unwrap(), value["std"].as_f64().unwrap_or(f64::NAN))
}

#[test]
fn a_round_body_is_as_wide_as_it_is_where_the_distance_is_given_and_its_error_is_told_where_it_is_not() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, format| fs::write(folder.path().join(name), Photo::default().bytes(format)).unwrap();
    for (name, format) in [("a.png", ImageFormat::Png), ("b.jpg", ImageFormat::Jpeg), ("c.tif", ImageFormat::Tiff)] {
        write(name, format);
    }
    // R = 20 mm at Z = 300 mm: 0.089 mm.
    let (code, told, _) = measured(folder.path(), &[".", "--scale", "0.1mm", "--distance", "300mm+-1"]);
    assert_eq!((code, told.len()), (0, 3), "{told:?}");
    for one in &told {
        let (value, std) = number(one, "diameter");
        assert!((value - 40.0).abs() < 0.03 && (value - 40.0).abs() < 4.0 * std && std < 0.01, "{one}");
    }
    let (code, told, said) = measured(folder.path(), &["a.png", "--scale", "0.1mm"]);
    let (value, _) = number(&told[0], "diameter");
    assert!(code == 0 && (value - 40.089).abs() < 0.01, "{told:?}");
    assert!(said.contains("by 0.089 mm") && said.contains("give `distance`"), "{said}");
    // A scale that lies 10 mm before the axis is that of a nearer plane: a px is longer on the axis.
    let (_, told, _) =
        measured(folder.path(), &["a.png", "--scale", "0.1mm", "--distance", "300mm", "--offset", "10mm+-0.5"]);
    let (value, std) = number(&told[0], "diameter");
    assert!((value - 41.36).abs() < 0.05, "{told:?}");
    assert!((std - 41.4 * 0.5 / 290.0).abs() < 0.01, "{std}");
    // Without a scale it is px.
    let (_, told, said) = measured(folder.path(), &["a.png"]);
    assert!((number(&told[0], "diameter").0 - 400.89).abs() < 0.1 && told[0]["values"][0]["unit"] == "px");
    assert!(said.contains("no scale is given"), "{said}");
}

#[test]
fn a_picture_that_cannot_be_measured_is_told_and_the_others_go_on() {
    let folder = tempfile::tempdir().unwrap();
    let good = Photo::default().bytes(ImageFormat::Png);
    let write = |name: &str, bytes: &[u8]| fs::write(folder.path().join(name), bytes).unwrap();
    write("p10.png", &good);
    write("p2.png", &good);
    write("p3.png", &good[..good.len() / 2]);
    write("p4.png", b"no picture at all");
    let mut empty = std::io::Cursor::new(Vec::new());
    image::GrayImage::from_pixel(64, 48, image::Luma([180])).write_to(&mut empty, ImageFormat::Png).unwrap();
    write("p5.png", &empty.into_inner());
    write("note.txt", b"not asked");
    let (code, told, _) = measured(folder.path(), &[".", "--names", "p{pressure:kPa}.png"]);
    assert_eq!(code, 3);
    let files: Vec<&str> = told.iter().map(|t| t["file"].as_str().unwrap()).collect();
    assert_eq!(files, ["./p2.png", "./p3.png", "./p4.png", "./p5.png", "./p10.png"]);
    assert_eq!(told[4]["names"][0]["value"], 10.0);
    for (i, words) in [(1, "damaged"), (2, "no PNG, JPEG or TIFF"), (3, "no body")] {
        assert!(told[i]["refused"].as_str().unwrap().contains(words), "{}", told[i]);
    }
    assert!(told[0]["refused"].is_null() && told[4]["refused"].is_null());
    // Nothing at all: exit 4, with a reason.
    let (code, _, said) = measured(folder.path(), &["p4.png"]);
    assert!(code == 4 && said.contains("no PNG, JPEG or TIFF"), "{said}");
}

#[test]
fn overlays_lie_beside_the_pictures_and_never_among_them() {
    let folder = tempfile::tempdir().unwrap();
    fs::create_dir(folder.path().join("photos")).unwrap();
    let bytes = Photo::default().bytes(ImageFormat::Png);
    fs::write(folder.path().join("photos/a.png"), &bytes).unwrap();
    let said = pneuval(folder.path(), &["measure", "diameter", "photos", "--scale", "0.1mm", "--out", "seen"]);
    assert_eq!(said.code, 0, "{}", said.err);
    assert!(said.out.contains("diameter (mm)") && said.out.contains("1 of 1 pictures measured"), "{}", said.out);
    let drawn = image::open(folder.path().join("seen/a.png-measured.png")).unwrap().into_rgb8();
    assert_eq!(drawn.dimensions(), (640, 420));
    // The largest of the profile's widths is the diameter; the rod below is three tenths of its end.
    let profile = fs::read_to_string(folder.path().join("seen/a.png-profile.csv")).unwrap();
    assert!(profile.starts_with("along (mm),width (mm),std (mm)\n"), "{profile}");
    let widths: Vec<f64> = profile.lines().skip(1).map(|l| l.split(',').nth(1).unwrap().parse().unwrap()).collect();
    let widest = widths.iter().copied().fold(0.0, f64::max);
    assert!((widest - 40.089).abs() < 0.1 && widths.iter().all(|w| *w > 31.5) && widths.len() > 200, "{profile}");
    // The line of the width is green, from edge to edge.
    let green = drawn.enumerate_pixels().filter(|(_, _, p)| p.0 == [0x00, 0xb0, 0x73]).map(|(x, ..)| x);
    let (from, to) = green.fold((u32::MAX, 0), |(a, b), x| (a.min(x), b.max(x)));
    assert!((395..=415).contains(&(to - from)), "{from} {to}");
    let said = pneuval(folder.path(), &["measure", "diameter", "photos", "--out", "photos"]);
    assert!(said.code == 2 && said.err.contains("the folder of the pictures"), "{}", said.err);
    assert_eq!(fs::read(folder.path().join("photos/a.png")).unwrap(), bytes);
}

#[test]
fn mistakes_of_the_command_line_are_told_with_what_to_write() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("a.png"), Photo::default().bytes(ImageFormat::Png)).unwrap();
    fs::write(folder.path().join("lens.yml"), "%YAML:1.0\nfocal: 3\n").unwrap();
    for (flag, value, words) in [
        ("--scale", "0.1", "a unit of length"),
        ("--scale", "0mm", "above zero"),
        ("--scale", "1mm+-2", "above its uncertainty"),
        ("--distance", "300kPa", "a unit of length"),
        ("--region", "1,2,3", "left, top, width and height"),
        ("--names", "{a}{b}", "between two fields"),
        ("--lens", "lens.yml", "OpenCV or ROS"),
        ("--lens", "none.yml", "none.yml"),
        ("--tone", "log", "an exponent above 0"),
        ("--tone", "0", "an exponent above 0"),
    ] {
        let said = pneuval(folder.path(), &["measure", "diameter", "a.png", flag, value]);
        assert!(said.code == 2 && said.err.contains(words), "{flag} {value}: {}", said.err);
    }
    for (arguments, words) in [
        (&["angle", "a.png", "--root", "1"][..], "write it as 120,400"),
        (&["angle", "a.png", "--markers", "200,30,30", "--count", "5"], "--root"),
        (&["angle", "a.png", "--markers", "90,90,90", "--count", "5", "--root", "1,1"], "grey"),
        (&["angle", "a.png", "--markers", "200,30,30", "--count", "2", "--root", "1,1"], "3..=12"),
        (&["area", "a.png", "--paint", "1,2"], "red, green and blue"),
        (&["area", "a.png", "--paint", "1,2,300"], "0 to 255"),
        (&["area", "a.png", "--specks=-1"], "px²"),
    ] {
        let said = pneuval(folder.path(), &[&["measure"], arguments].concat());
        assert!(said.code == 2 && said.err.contains(words), "{arguments:?}: {}", said.err);
    }
}

/// The rehearsed photographs of a type, with the truth of each: name and value in SI, and how long a pixel is in mm.
fn rehearsed(folder: &Path, of: &str, run: &str) -> Vec<(String, f64, f64)> {
    let said = pneuval(folder, &["rehearse", of, "--photographs", "--repeats", "1", "--out", of]);
    assert_eq!(said.code, 0, "{}", said.err);
    let truth: Value = serde_json::from_slice(&fs::read(folder.join(of).join("truth.json")).unwrap()).unwrap();
    let of_run = truth["runs"].as_array().unwrap().iter().find(|r| r["id"] == run).unwrap();
    let one = |p: &Value| {
        let number = |key: &str| p[key].as_f64().unwrap();
        (p["name"].as_str().unwrap().to_owned(), number("value_si"), 1e3 * number("metre_per_px"))
    };
    of_run["pictures"].as_array().unwrap().iter().map(one).collect()
}

#[test]
fn angles_and_areas_of_rehearsed_photographs_are_told_with_their_profiles() {
    let folder = tempfile::tempdir().unwrap();
    let film = rehearsed(folder.path(), "wave-finger", "run-1");
    let scale = format!("{}mm", film[0].2);
    let files: Vec<String> =
        film.iter().step_by(6).map(|(name, ..)| format!("wave-finger/run-1-camera/{name}")).collect();
    let mut arguments: Vec<&str> = files.iter().map(String::as_str).collect();
    arguments.extend(["--scale", &scale, "--sense", "counterclockwise", "--tone", "linear", "--out", "seen"]);
    let said = pneuval(folder.path(), &[&["measure", "angle", "--json"], &arguments[..]].concat());
    assert!(said.code == 0 && said.err.is_empty(), "{}", said.err);
    let told: Vec<Value> = serde_json::from_str(&said.out).unwrap();
    for (one, (name, truth, _)) in told.iter().zip(film.iter().step_by(6)) {
        let (angle, std) = number(one, "angle");
        assert!((angle - truth.to_degrees()).abs() < 0.2 && std > 0.0, "{name}: {angle} {truth}");
        // The curvature from root to tip sums up to the angle.
        let profile = fs::read_to_string(folder.path().join(format!("seen/{name}-profile.csv"))).unwrap();
        let mut lines = profile.lines();
        assert_eq!(lines.next(), Some("along (mm),curvature (1/mm),std (1/mm)"));
        let rows: Vec<Vec<f64>> = lines.map(|l| l.split(',').map(|v| v.parse().unwrap()).collect()).collect();
        let turn: f64 = rows.windows(2).map(|w| 0.5 * (w[0][1] + w[1][1]) * (w[1][0] - w[0][0])).sum();
        assert!((turn.to_degrees() - angle).abs() < 0.3, "{name}: {turn} {angle}");
        assert!(folder.path().join(format!("seen/{name}-measured.png")).is_file());
    }
    let paint = rehearsed(folder.path(), "pdms-wall", "set-1-run-1");
    let (name, truth, scale) = &paint[0];
    let path = format!("pdms-wall/set-1-run-1/{name}");
    let scale = format!("{scale}mm");
    let area = |more: &[&str]| {
        let arguments = [&["measure", "area", "--json", &path, "--scale", &scale, "--tone", "linear"], more].concat();
        let said = pneuval(folder.path(), &arguments);
        assert!(said.code == 0, "{}", said.err);
        let told: Vec<Value> = serde_json::from_str(&said.out).unwrap();
        (number(&told[0], "area"), number(&told[0], "holes").0)
    };
    let ((value, std), holes) = area(&[]);
    assert!((value - 1e6 * truth).abs() < 0.005 * value && (value - 1e6 * truth).abs() < 4.0 * std, "{value} {truth}");
    let ((filled, _), none) = area(&["--fill-holes"]);
    assert!(holes > 1.0 && none.abs() < 1e-9 && (filled - value - holes).abs() < 0.1, "{filled} {value} {holes}");
}

#[test]
fn light_that_is_stored_by_a_curve_moves_edges_and_that_is_told_and_taken_back() {
    let folder = tempfile::tempdir().unwrap();
    let linear = Photo::default().image().into_luma8();
    let stored = image::GrayImage::from_fn(linear.width(), linear.height(), |x, y| {
        let light = f64::from(linear.get_pixel(x, y).0[0]) / 255.0;
        let stored = if light <= 0.003_130_8 { 12.92 * light } else { 1.055 * light.powf(1.0 / 2.4) - 0.055 };
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        image::Luma([(255.0 * stored).round() as u8])
    });
    stored.save(folder.path().join("a.png")).unwrap();
    let common = ["a.png", "--scale", "0.1mm", "--distance", "300mm"];
    let (_, told, said) = measured(folder.path(), &common);
    let off = number(&told[0], "diameter").0 - 40.0;
    // Both edges of a dark body move inwards, as far as is told.
    assert!(off < -0.05 && said.contains("curve of sRGB"), "{off} {said}");
    let shift: f64 = said.split("up to ").nth(1).unwrap().split(' ').next().unwrap().parse().unwrap();
    assert!((off + 0.2 * shift).abs() < 0.02, "{off} {said}");
    let (_, told, said) = measured(folder.path(), &[&common[..], &["--tone", "srgb"]].concat());
    assert!((number(&told[0], "diameter").0 - 40.0).abs() < 0.03 && said.is_empty(), "{told:?} {said}");
}

/// The experimental column of the paper's table (MPa, mm).
const PAPER: [(&str, f64); 6] =
    [("0.00", 30.0), ("0.01", 33.44), ("0.02", 35.67), ("0.03", 37.72), ("0.04", 39.66), ("0.05", 41.45)];

#[test]
fn photographs_of_the_papers_diameters_give_the_papers_errors() {
    let folder = tempfile::tempdir().unwrap();
    for run in 1..=2_u64 {
        let photos = folder.path().join(format!("lab/photos-{run}"));
        fs::create_dir_all(&photos).unwrap();
        for (i, (pressure, diameter)) in PAPER.iter().enumerate() {
            let photo = Photo {
                diameter: *diameter,
                mm_per_px: 0.05,
                size: (960, 660),
                seed: 100 * run + u64::try_from(i).unwrap(),
                ..Photo::default()
            };
            fs::write(photos.join(format!("p{pressure}.png")), photo.bytes(ImageFormat::Png)).unwrap();
        }
    }
    // The actuator with the paper's own predictions, as a rehearsal has it.
    let said = pneuval(folder.path(), &["rehearse", "internal-support", "--out", "rehearsed"]);
    assert_eq!(said.code, 0, "{}", said.err);
    for entry in fs::read_dir(folder.path().join("rehearsed")).unwrap().filter_map(Result::ok) {
        let name = entry.file_name().into_string().unwrap();
        if !name.starts_with("run-")
            && name != "session.toml"
            && name != "rig.toml"
            && name != "bounds.toml"
            && entry.path().is_file()
        {
            fs::copy(entry.path(), folder.path().join("lab").join(name)).unwrap();
        }
    }
    let session = "schema = 1\nid = \"photos\"\nactuator = \"internal-support\"\nsynthetic = true\n\
        [reader]\nformat = \"pictures\"\n[reader.camera]\nmeasure = \"diameter\"\nnames = \"p{pressure:MPa}.png\"\n\
        scale = { value = 0.05, unit = \"mm\", std = 0.00001 }\ndistance = { value = 300, unit = \"mm\", std = 1 }\n\
        [[channel]]\nid = \"pressure\"\ncolumn = \"pressure\"\nreference = \"gauge\"\n\
        [[channel]]\nid = \"diameter\"\ncolumn = \"diameter\"\n\
        [[run]]\nfile = \"photos-1\"\n[[run]]\nfile = \"photos-2\"\n\
        [[response]]\nquantity = { id = \"outer-diameter\", title = \"Outer diameter\", unit = \"mm\" }\n\
        pressure = [{ channel = \"pressure\", chamber = \"chamber\" }]\nmeasured = { channel = \"diameter\", method = \"photographs\" }\n\
        [[comparison]]\nquantity = \"outer-diameter\"\nform = \"published-theory\"\n\
        [[comparison]]\nquantity = \"outer-diameter\"\nform = \"published-fea\"\n";
    fs::write(folder.path().join("lab/session.toml"), session).unwrap();
    let said = pneuval(folder.path(), &["validate", "lab", "--out", "report", "--no-figures"]);
    let results =
        fs::read(folder.path().join("report/results/results.json")).unwrap_or_else(|_| panic!("{}", said.err));
    let results: Value = serde_json::from_slice(&results).unwrap();
    let said_papers = pneuval(folder.path(), &["validate", "--out", "papers", "--no-figures"]);
    let papers =
        fs::read(folder.path().join("papers/results/results.json")).unwrap_or_else(|_| panic!("{}", said_papers.err));
    let papers: Value = serde_json::from_slice(&papers).unwrap();
    for form in ["published-theory", "published-fea"] {
        let of = |results: &Value| {
            let all = results["comparisons"].as_array().unwrap();
            let is = |c: &&Value| {
                c["actuator"] == "internal-support" && c["form"] == form && c["quantity"]["id"] == "outer-diameter"
            };
            all.iter().find(is).unwrap().clone()
        };
        let (ours, theirs) = (of(&results), of(&papers));
        let points = ours["points"].as_array().unwrap();
        assert_eq!(points.len(), PAPER.len(), "{}", said.err);
        for (point, (_, diameter)) in points.iter().zip(PAPER) {
            let (value, half) = (point["measured"][0].as_f64().unwrap() * 1e3, &point["measured_half_width"][0]);
            assert!((value - diameter).abs() < 0.03 && half.as_f64().unwrap() > 0.0, "{value} {diameter} {half}");
        }
        let metric = |of: &Value, id: &str| {
            let metrics = of["metrics"].as_array().unwrap();
            metrics.iter().find(|m| m["metric"] == id).unwrap()["value"].as_f64().unwrap()
        };
        for id in ["max_abs_error", "bias", "mae"] {
            let (a, b) = (metric(&ours, id), metric(&theirs, id));
            assert!((a - b).abs() < 0.03e-3, "{form} {id}: {a} {b}");
        }
    }
}

/// Photographs of some pressures, and a session of them.
fn lab(folder: &Path) {
    fs::create_dir_all(folder.join("photos")).unwrap();
    for (i, diameter) in [30.0, 33.44, 35.67].into_iter().enumerate() {
        let photo = Photo { diameter, mm_per_px: 0.05, size: (960, 660), ..Photo::default() };
        fs::write(folder.join(format!("photos/p{i}.png")), photo.bytes(ImageFormat::Png)).unwrap();
    }
    fs::write(folder.join("photos/p3.png"), Photo { diameter: 80.0, ..Photo::default() }.bytes(ImageFormat::Png))
        .unwrap();
    fs::write(folder.join("photos/p4.png"), b"no picture").unwrap();
    let session = "schema = 1\nid = \"photos\"\nactuator = \"internal-support\"\n[reader]\nformat = \"pictures\"\n[reader.camera]\n\
        measure = \"diameter\"\nnames = \"p{pressure:kPa}.png\"\nscale = { value = 0.05, unit = \"mm\" }\n\
        distance = { value = 300, unit = \"mm\" }\n\
        [[channel]]\nid = \"pressure\"\ncolumn = \"pressure\"\nreference = \"gauge\"\n\
        [[channel]]\nid = \"diameter\"\ncolumn = \"diameter\"\n[[run]]\nfile = \"photos\"\n[[response]]\n\
        quantity = { id = \"outer-diameter\", title = \"Outer diameter\", unit = \"mm\" }\n\
        pressure = [{ channel = \"pressure\", chamber = \"chamber\" }]\n\
        measured = { channel = \"diameter\", method = \"photographs\" }\n\
        [[comparison]]\nquantity = \"outer-diameter\"\nform = \"consistent\"\n";
    fs::write(folder.join("session.toml"), session).unwrap();
}

#[test]
fn a_report_shows_its_photographs_and_is_drawn_again_from_them() {
    let folder = tempfile::tempdir().unwrap();
    lab(&folder.path().join("lab"));
    let said = pneuval(folder.path(), &["validate", "lab", "--out", "report"]);
    let page = |report: &str| fs::read_to_string(folder.path().join(report).join("internal-support.html")).unwrap();
    // The broken one has nothing to be shown; the others are files of their own and stand on the page.
    let files: Vec<String> = fs::read_dir(folder.path().join("report/results/photographs"))
        .unwrap_or_else(|_| panic!("{}", said.err))
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    assert_eq!(files.len(), 4, "{files:?}");
    let shown = page("report");
    assert_eq!(shown.matches("src=\"results/photographs&#x2f;photos-").count(), 4);
    assert!(!shown.contains("data:image/jpeg"));
    // On request the page is all there is.
    let alone = pneuval(folder.path(), &["report", "report", "--one-file", "--out", "alone"]);
    assert_eq!((alone.code, page("alone").matches("data:image/jpeg;base64").count()), (0, 4), "{}", alone.err);
    assert!(!page("alone").contains("results/photographs") && !page("alone").contains("results/figures/"));
    assert!(shown.contains("p1.png, run photos") && shown.contains("Not measured"), "{}", said.err);
    let drawn = image::open(folder.path().join("report/results/photographs/photos-1.jpg")).unwrap().into_rgb8();
    assert_eq!(drawn.width(), 480);
    // The line of the width, as JPEG leaves it: greener than anything grey.
    let green =
        drawn.pixels().filter(|p| p.0[1] > p.0[0].saturating_add(60) && p.0[1] > p.0[2].saturating_add(20)).count();
    assert!(green > 100, "{green}");
    let again = pneuval(folder.path(), &["report", "report", "--out", "again"]);
    assert_eq!(again.code, 0, "{}", again.err);
    assert_eq!(page("again"), shown);
    for file in &files {
        let of = |report: &str| fs::read(folder.path().join(report).join("results/photographs").join(file)).unwrap();
        assert_eq!(of("report"), of("again"));
    }
    // A photograph that was changed is none of this report's.
    fs::write(folder.path().join("again/results/photographs").join(&files[0]), b"another").unwrap();
    let changed = pneuval(folder.path(), &["report", "again"]);
    assert!(changed.code == 2 && changed.err.contains("SHA-256"), "{}", changed.err);
    // Without figures there are none, and none is named.
    pneuval(folder.path(), &["validate", "lab", "--out", "plain", "--no-figures"]);
    assert!(!folder.path().join("plain/results/photographs").exists() && !page("plain").contains("image/jpeg"));
}

#[test]
fn a_lens_and_scales_come_from_pictures_and_are_printed_as_a_session_has_them() {
    let folder = tempfile::tempdir().unwrap();
    let photo = Photo { diameter: 40.0, mm_per_px: 0.1, ..Photo::default() };
    fs::write(folder.path().join("a.png"), photo.bytes(ImageFormat::Png)).unwrap();
    let length =
        ["measure", "scale", "length", "a.png", "--from", "100,50", "--to", "400,450", "--length", "50mm+-0.05"];
    let said = pneuval(folder.path(), &length);
    // 500 px, each end to half a px: 0.1 mm by √(0.001² + 0.00141²).
    assert!(
        said.code == 0 && said.out.contains("scale = { value = 0.10000, unit = \"mm\", std = 0.00017 }"),
        "{}",
        said.out
    );
    let said = pneuval(folder.path(), &[&length[..], &["--json"]].concat());
    let told: Value = serde_json::from_str(&said.out).unwrap();
    assert!((told["mm_per_px"].as_f64().unwrap() - 0.1).abs() < 1e-12, "{told}");
    for (arguments, code, words) in [
        (&["scale", "length", "a.png", "--from", "1,1", "--to", "1,1", "--length", "5mm"][..], 4, "two places"),
        (&["scale", "length", "a.png", "--from", "1", "--to", "1,1", "--length", "5mm"], 2, "write it as 120,400"),
        (&["scale", "length", "a.png", "--from", "1,1", "--to", "9,1", "--length", "0mm"], 2, "above zero"),
        (&["scale", "disc", "none.png", "--diameter", "5mm"], 2, "none.png"),
        (&["scale", "disc", ".", "--diameter", "5mm"], 4, "a folder"),
        (&["scale", "board", "a.png", "--corners", "9", "--square", "5mm"], 2, "write it as 9x6"),
        (&["scale", "board", "a.png", "--corners", "9x6", "--square", "5mm"], 4, "a.png"),
        (&["lens", "a.png", "--corners", "9x6", "--square", "5mm"], 4, "count inner corners"),
    ] {
        let said = pneuval(folder.path(), &[&["measure"], arguments].concat());
        assert!(said.code == code && said.err.contains(words), "{arguments:?}: {} {}", said.code, said.err);
    }
}

#[test]
fn mistakes_in_a_camera_are_told_by_key_and_next_step() {
    let folder = tempfile::tempdir().unwrap();
    fs::create_dir_all(folder.path().join("photos")).unwrap();
    fs::write(folder.path().join("photos/p1.png"), Photo::default().bytes(ImageFormat::Png)).unwrap();
    let session = "schema = 1\nid = \"photos\"\nactuator = \"internal-support\"\n[reader]\nformat = \"pictures\"\n[reader.camera]\n\
        measure = \"diameter\"\nnames = \"p{pressure:kPa}.png\"\nscale = { value = 0.1, unit = \"mm\" }\nfps = 10\n\
        [[channel]]\nid = \"pressure\"\ncolumn = \"pressure\"\nreference = \"gauge\"\n[[channel]]\nid = \"diameter\"\ncolumn = \"diameter\"\n\
        [[run]]\nfile = \"photos\"\n[[response]]\n\
        quantity = { id = \"outer-diameter\", title = \"Outer diameter\", unit = \"mm\" }\n\
        pressure = [{ channel = \"pressure\", chamber = \"chamber\" }]\nmeasured = { channel = \"diameter\", method = \"photographs\" }\n\
        [[comparison]]\nquantity = \"outer-diameter\"\nform = \"published-theory\"\n";
    for (from, to, words) in [
        ("measure = \"diameter\"", "measure = \"volume\"", "diameter"),
        ("p{pressure:kPa}.png", "p{pressure:furlong}.png", "is no unit"),
        ("{ value = 0.1, unit = \"mm\" }", "{ value = 0, unit = \"mm\" }", "a length > 0"),
        ("{ value = 0.1, unit = \"mm\" }", "{ value = 0.1, unit = \"kPa\" }", "a unit of length"),
        ("fps = 10", "fps = 0", "pictures in a second"),
        ("fps = 10", "fsp = 10", "did you mean `fps`"),
        ("fps = 10", "start = { value = 1, unit = \"s\" }", "`fps` beside `start`"),
        ("fps = 10", "lens = { focal = [0, 1], centre = [0, 0] }", "focal lengths in px > 0"),
        ("format = \"pictures\"", "format = \"csv\"", "`camera` with format = \"pictures\""),
        ("fps = 10", "tone = \"log\"", "or { gamma = 2.2 }"),
        ("fps = 10", "tone = { gamma = 0 }", "an exponent > 0"),
        ("fps = 10", "tone = { gama = 2 }", "tone"),
        ("fps = 10", "sense = \"clockwise\"", "found:    `sense`"),
        ("fps = 10", "paint = [1, 2, 3]", "found:    `paint`"),
        ("measure = \"diameter\"", "measure = \"area\"\nholes = \"through\"", "holes"),
        ("measure = \"diameter\"", "measure = \"area\"\npaint = [1, 2, 256]", "0 to 255"),
        ("measure = \"diameter\"", "measure = \"area\"\nspecks = -1", "an area in px²"),
        ("measure = \"diameter\"", "measure = \"angle\"\naxis = \"vertical\"", "found:    `axis`"),
        ("measure = \"diameter\"", "measure = \"angle\"\nroot = [nan, 1]", "a place in px"),
        (
            "measure = \"diameter\"",
            "measure = \"angle\"\nmarkers = { colour = [200, 30, 30], count = 5 }",
            "`root` beside `markers`",
        ),
        (
            "measure = \"diameter\"",
            "measure = \"angle\"\nroot = [1, 1]\nmarkers = { colour = [90, 90, 90], count = 5 }",
            "grey tells no marker",
        ),
        (
            "measure = \"diameter\"",
            "measure = \"angle\"\nroot = [1, 1]\nmarkers = { colour = [200, 30, 30], count = 2 }",
            "3 to 12 markers",
        ),
        ("fps = 10", "topic = \"/camera\"", "no `names` and no `fps` beside `topic`"),
        ("names = \"p{pressure:kPa}.png\"\n", "topic = \"/camera\"\n", "no `names` and no `fps` beside `topic`"),
        ("column = \"pressure\"", "column = \"pressur\"", "pressure"),
    ] {
        assert!(session.contains(from));
        fs::write(folder.path().join("session.toml"), session.replacen(from, to, 1)).unwrap();
        let said = pneuval(folder.path(), &["validate", ".", "--no-report"]);
        assert!(said.code == 2 && said.err.contains(words), "{to}: {}{}", said.out, said.err);
    }
    // As it stands it is read; without a distance that is told with the size of the error.
    fs::write(folder.path().join("session.toml"), session).unwrap();
    let said = pneuval(folder.path(), &["ingest", "."]);
    assert!(said.code == 0 && (said.err.clone() + &said.out).contains("by 0.089 mm"), "{}{}", said.out, said.err);
}
