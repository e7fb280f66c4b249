//! Every embedded file reads, and says where its numbers come from.

// In a test a panic is how a failure is told; equality of floats is asked where it must be exact.
#![allow(clippy::unwrap_used, clippy::panic, clippy::float_cmp)]

use std::path::{Path, PathBuf};

use pneuval_datasets::{DatasetError, EMBEDDED, Found, FoundData, find, find_actuator};
use pneuval_ingest::document::Origin;
use pneuval_ingest::manifest::{Cell, PublishedDataset};
use pneuval_ingest::number::Printed;
use pneuval_models::catalogue;

/// The printed tables of what was found.
fn published(found: &Found) -> &PublishedDataset {
    match &found.data {
        FoundData::Published(dataset) => dataset,
        FoundData::Session(_) => panic!("{} is a session", found.file),
    }
}

#[test]
fn the_embedded_papers_and_the_folder_on_disk_are_the_same() {
    let embedded = find(&[]).unwrap();
    let disk = find(&[PathBuf::from(env!("CARGO_MANIFEST_DIR"))]).unwrap();
    let ids: Vec<&str> = embedded.iter().map(|f| f.data.id()).collect();
    assert_eq!(ids, ["dual-chamber-finger", "fruit-finger", "internal-support", "pdms-wall", "wave-finger"]);
    assert_eq!(disk.len(), embedded.len());
    for (a, b) in embedded.iter().zip(&disk) {
        assert_eq!(published(a), published(b));
        assert_eq!((&a.actuator.values, &a.actuator_file), (&b.actuator.values, &b.actuator_file));
        let (a, b) = (a.bounds.as_ref().unwrap(), b.bounds.as_ref().unwrap());
        assert_eq!((&a.bytes, &a.relative), (&b.bytes, &b.relative));
    }
}

/// What the papers leave out and a model needs: chosen or fitted, and said so.
const NOT_PUBLISHED: [(&str, &str, Origin); 10] = [
    ("dual-chamber-finger", "sheet_width", Origin::Assumed),
    ("fruit-finger", "chamber_radius", Origin::Assumed),
    ("fruit-finger", "finger_length", Origin::Assumed),
    ("fruit-finger", "rod_stiffness", Origin::Calibrated),
    ("fruit-finger", "free_rod_angle_per_pressure", Origin::Calibrated),
    ("fruit-finger", "affine_rod_stiffness", Origin::Calibrated),
    ("fruit-finger", "affine_free_rod_angle_per_pressure", Origin::Calibrated),
    ("fruit-finger", "affine_free_rod_angle_at_zero", Origin::Calibrated),
    ("wave-finger", "linear_full_pressure", Origin::Assumed),
    ("wave-finger", "linear_full_angle", Origin::Assumed),
];

#[test]
fn every_published_value_says_where_it_is_printed() {
    for found in find(&[]).unwrap() {
        for (name, value) in &found.actuator.values {
            let place = value.place.as_deref().unwrap_or_default();
            assert!(!place.is_empty(), "{} {name}", found.actuator.id);
            let id = found.actuator.id.as_str();
            let origin = NOT_PUBLISHED.iter().find(|(a, n, _)| (*a, *n) == (id, name)).map(|(.., origin)| *origin);
            assert_eq!(value.origin, origin.unwrap_or(Origin::Published), "{id} {name}");
        }
        let dataset = published(&found);
        for table in &dataset.tables {
            assert!(!table.place.is_empty() && !table.method.is_empty());
        }
        for statistic in &dataset.statistics {
            assert!(!statistic.place.is_empty() && !statistic.method.is_empty());
        }
        for listing in &dataset.listings {
            assert!(!listing.place.is_empty() && !listing.rows.is_empty(), "{}", listing.title);
        }
        for stated in &dataset.stated {
            assert!(stated.value.place.is_some() && stated.value.origin == Origin::Published, "{}", stated.title);
        }
    }
}

#[test]
fn every_actuator_holds_what_its_models_need() {
    for found in find(&[]).unwrap() {
        let actuator = &found.actuator;
        let entries: Vec<_> = catalogue::entries().filter(|e| e.actuator == actuator.kind).collect();
        assert!(!entries.is_empty(), "{}", actuator.kind);
        for entry in entries {
            for parameter in entry.parameters {
                let value = actuator.values.get(parameter.name).unwrap_or_else(|| panic!("{}", parameter.name));
                assert_eq!(value.unit.dimension.si_symbol(), parameter.si_unit, "{}", parameter.name);
            }
            for chamber in entry.chambers {
                assert!(actuator.chambers.contains_key(*chamber), "{chamber}");
            }
            // A table of this quantity holds what the form needs beside the pressure.
            for condition in entry.conditions {
                let Some(table) = published(&found).table(entry.quantity) else { continue };
                let column = table.conditions.iter().find(|c| c.id == condition.name).unwrap();
                assert_eq!(column.unit.dimension.si_symbol(), condition.si_unit, "{}", condition.name);
            }
        }
    }
}

#[test]
fn numbers_are_those_of_the_papers() {
    let found = find(&[]).unwrap();
    let dataset = |id: &str| published(found.iter().find(|f| f.data.id() == id).unwrap());
    let diameter = dataset("internal-support").table("outer-diameter").unwrap();
    let single = |cell: &Cell| cell.as_ref().map(|values| <[Printed; 1]>::try_from(values.as_slice()).unwrap()[0]);
    let measured: Vec<f64> =
        diameter.measured.iter().filter_map(single).map(|m| (m.si * 1e5).round() / 100.0).collect();
    assert_eq!(measured, [30.0, 33.44, 35.67, 37.72, 39.66, 41.45]);
    assert_eq!(diameter.predicted.len(), 2);
    let tip = single(&dataset("dual-chamber-finger").table("tip-angle").unwrap().measured[0]).unwrap();
    assert!((tip.si.to_degrees() - 186.0).abs() < 1e-12 && (tip.half_width_si.to_degrees() - 0.5).abs() < 1e-12);

    // Table 1 of the fruit finger: how many forces are printed at each pressure, and the corners of its triangle.
    let force = dataset("fruit-finger").table("tip-force").unwrap();
    let at = |kpa: f64| {
        let here = |p: &&Vec<f64>| p[0] == kpa * 1e3;
        force.pressures_gauge_pa.iter().filter(here).count()
    };
    assert_eq!([10.0, 20.0, 30.0, 40.0, 50.0, 60.0].map(at), [1, 3, 5, 5, 6, 7]);
    let last = single(&force.measured[26]).unwrap();
    assert_eq!((last.si, last.half_width_si), (0.55, 0.005));
    assert!((force.conditions_si[26][0].si.to_degrees() - 90.0).abs() < 1e-12);
    assert_eq!((force.conditions.len(), force.conditions[0].id.as_str()), (1, "held_angle"));

    // No displacement of the wall is printed: three holes, not three zeros.
    let wall = dataset("pdms-wall");
    assert_eq!(wall.table("wall-displacement").unwrap().measured, [None, None, None]);
    let contact: Vec<f64> =
        wall.table("contact-force").unwrap().measured.iter().filter_map(single).map(|m| m.si).collect();
    assert_eq!(contact, [15.7, 18.4, 19.3]);

    let angle = single(&dataset("wave-finger").table("bending-angle").unwrap().measured[0]).unwrap();
    assert!((angle.si.to_degrees() - 168.0).abs() < 1e-12);
    let stated: Vec<(&str, f64)> = dataset("wave-finger")
        .statistics
        .iter()
        .flat_map(|s| &s.metrics)
        .map(|(id, value, _)| (id.as_str(), (value.si * 1e9).round() / 1e6))
        .collect();
    assert_eq!(stated, [("max_abs_error", 4.682), ("rmse", 0.962), ("max_abs_error", 1.753), ("rmse", 1.148)]);
}

/// Table 3 of the fruit finger is damaged in our text: what cannot be read is empty, never guessed.
#[test]
fn damaged_cells_stay_empty() {
    let found = find(&[]).unwrap();
    let fruit = published(found.iter().find(|f| f.data.id() == "fruit-finger").unwrap());
    let rows: Vec<Vec<&str>> =
        fruit.listings[0].rows.iter().map(|row| row.iter().map(String::as_str).collect()).collect();
    assert_eq!((rows[0][0], &rows[2][1..], rows[4][1]), ("", &["", ""][..], ""));
    assert_eq!(rows[5], ["60", "2.13", "5.8"]);
}

#[test]
fn the_nearest_file_wins_and_a_stranger_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let session = folder.path().join("lab/monday");
    std::fs::create_dir_all(&session).unwrap();
    let text = EMBEDDED.iter().find(|(n, _)| *n == "actuators/internal-support.toml").unwrap().1;
    let mine = String::from_utf8(text.to_vec()).unwrap().replace("Internal-support gripper", "My gripper");
    std::fs::write(folder.path().join("lab/actuator.toml"), mine).unwrap();
    assert_eq!(find_actuator("internal-support", &session).unwrap().title, "My gripper");
    assert_eq!(find_actuator("dual-chamber-finger", &session).unwrap().title, "Dual-chamber steel-sheet finger");
    let error = find_actuator("internal-suport", &session).unwrap_err();
    assert!(matches!(error, DatasetError::UnknownActuator { .. }));
    assert!(error.to_string().contains("did you mean `internal-support`?"), "{error}");
}

#[test]
fn paths_that_hold_nothing_are_errors() {
    assert!(matches!(find(&[PathBuf::from("/nowhere/at/all")]), Err(DatasetError::NotFound { .. })));
    let empty = tempfile::tempdir().unwrap();
    assert!(matches!(find(&[empty.path().to_owned()]), Err(DatasetError::NoDataset { .. })));
    let published = Path::new(env!("CARGO_MANIFEST_DIR")).join("published/internal-support");
    let twice = find(&[published.clone(), published.join("dataset.toml")]);
    assert!(matches!(twice, Err(DatasetError::DuplicateId { .. })));
}

#[cfg(unix)]
#[test]
fn links_are_looked_into_but_not_followed_down_and_depth_ends_with_an_error() {
    use std::fs;
    use std::os::unix::fs::symlink;

    let place = tempfile::tempdir().unwrap();
    let published = Path::new(env!("CARGO_MANIFEST_DIR")).join("published");
    let ids =
        |path: &Path| find(&[path.to_owned()]).map(|f| f.iter().map(|f| f.data.id().to_owned()).collect::<Vec<_>>());
    let root = place.path().join("root");
    fs::create_dir(&root).unwrap();
    symlink(published.join("pdms-wall"), root.join("elsewhere")).unwrap();
    symlink(&root, root.join("circle")).unwrap();
    symlink(place.path().join("nowhere"), root.join("dangling")).unwrap();
    assert_eq!(ids(&root).unwrap(), ["pdms-wall"]);
    // The link to a folder of folders is not followed down; `latest` names what is here already.
    symlink(&published, root.join("many")).unwrap();
    let wave = root.join("z-wave");
    fs::create_dir(&wave).unwrap();
    for entry in fs::read_dir(published.join("wave-finger")).unwrap() {
        let entry = entry.unwrap();
        fs::copy(entry.path(), wave.join(entry.file_name())).unwrap();
    }
    symlink(&wave, root.join("latest")).unwrap();
    assert_eq!(ids(&root).unwrap(), ["pdms-wall", "wave-finger"]);

    let mut deep = root.join("d");
    for _ in 0..15 {
        deep.push("d");
    }
    fs::create_dir_all(&deep).unwrap();
    assert_eq!(ids(&root).unwrap().len(), 2);
    fs::create_dir(deep.join("d")).unwrap();
    let error = ids(&root).unwrap_err();
    assert!(matches!(&error, DatasetError::TooDeep { path } if *path == deep), "{error}");
}
