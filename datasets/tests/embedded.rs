//! Every embedded file reads, and says where its numbers come from.

// In a test a panic is how a failure is told; equality of floats is asked where it must be exact.
#![allow(clippy::unwrap_used, clippy::panic, clippy::float_cmp)]

use std::path::{Path, PathBuf};

use pneuval_datasets::{DatasetError, EMBEDDED, find, find_actuator};
use pneuval_ingest::document::Origin;
use pneuval_models::catalogue;

#[test]
fn the_embedded_papers_and_the_folder_on_disk_are_the_same() {
    let embedded = find(&[]).unwrap();
    let disk = find(&[PathBuf::from(env!("CARGO_MANIFEST_DIR"))]).unwrap();
    let ids: Vec<&str> = embedded.iter().map(|f| f.dataset.id.as_str()).collect();
    assert_eq!(ids, ["dual-chamber-finger", "internal-support"]);
    for (a, b) in embedded.iter().zip(&disk) {
        assert_eq!(a.dataset, b.dataset);
        assert_eq!((&a.actuator.values, &a.actuator_file), (&b.actuator.values, &b.actuator_file));
        let (a, b) = (a.bounds.as_ref().unwrap(), b.bounds.as_ref().unwrap());
        assert_eq!((&a.bytes, &a.relative), (&b.bytes, &b.relative));
    }
}

#[test]
fn every_published_value_says_where_it_is_printed() {
    for found in find(&[]).unwrap() {
        for (name, value) in &found.actuator.values {
            let place = value.place.as_deref().unwrap_or_default();
            assert!(!place.is_empty(), "{} {name}", found.actuator.id);
            assert!(value.origin == Origin::Published || name == "sheet_width", "{name}");
        }
        for table in &found.dataset.tables {
            assert!(!table.place.is_empty() && !table.method.is_empty());
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
        }
    }
}

#[test]
fn numbers_are_those_of_the_papers() {
    let found = find(&[]).unwrap();
    let diameter = found[1].dataset.table("outer-diameter").unwrap();
    let measured: Vec<f64> = diameter.measured.iter().flatten().map(|m| (m.si * 1e5).round() / 100.0).collect();
    assert_eq!(measured, [30.0, 33.44, 35.67, 37.72, 39.66, 41.45]);
    assert_eq!(diameter.predicted.len(), 2);
    let tip = found[0].dataset.table("tip-angle").unwrap();
    assert!((tip.measured[0].unwrap().si.to_degrees() - 186.0).abs() < 1e-12);
    assert!((tip.measured[0].unwrap().half_width_si.to_degrees() - 0.5).abs() < 1e-12);
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
