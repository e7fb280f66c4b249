//! The seeds of the fuzz targets are read as what they are meant to be: a seed that stops at its first byte tries out nothing.

// In a test a panic is how a failure is told.
#![allow(clippy::unwrap_used, clippy::panic)]

use std::fs;
use std::path::Path;

use pneuval_ingest::finding::FindingKind;
use pneuval_ingest::formats::{Format, Options, read};
use pneuval_ingest::raw::RawFile;
use pneuval_ingest::recording::{Keep, Recording};

fn seeds(format: Format) -> Vec<(String, Recording)> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("fuzz/seeds").join(format.id());
    let options = Options { format: Some(format), ..Options::default() };
    let one = |path: &Path| {
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        let bytes = fs::read(path).unwrap();
        let recording = read(&RawFile::of_bytes(&name, &bytes), &options, Keep::All);
        (name.clone(), recording.unwrap_or_else(|error| panic!("{name}: {error}")))
    };
    fs::read_dir(&folder).unwrap().map(|entry| one(&entry.unwrap().path())).collect()
}

#[test]
fn every_seed_holds_a_sample() {
    for format in Format::ALL {
        let seeds = seeds(format);
        assert!(seeds.len() >= 2, "{}", format.id());
        for (name, seed) in seeds {
            assert!(seed.tables.iter().any(|table| table.rows >= 1), "{name}: {:?}", seed.findings);
        }
    }
}

#[test]
fn messages_of_every_encoding_are_decoded_and_no_checksum_stands_before_them() {
    for (name, seed) in seeds(Format::Mcap) {
        let kinds: Vec<FindingKind> = seed.findings.iter().map(|finding| finding.kind).collect();
        let unread = [FindingKind::UnreadMessage, FindingKind::UnreadTopic, FindingKind::BadRecord];
        assert!(!kinds.iter().any(|kind| unread.contains(kind)), "{name}: {:?}", seed.findings);
        let tables: Vec<(usize, bool)> = seed.tables.iter().map(|t| (t.rows, t.columns.len() > 3)).collect();
        let expected = if name == "whole.mcap" { 1 } else { 2 };
        assert_eq!(tables, vec![(4, true); expected], "{name}");
    }
}
