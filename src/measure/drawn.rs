//! What `--out` writes: each picture with what was measured drawn on it, and its profile.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use pneuval_analysis::report::overlay;
use pneuval_ingest::IngestError;
use pneuval_ingest::camera::picture::Picture;
use pneuval_ingest::camera::task::{Profile, Reading};
use pneuval_ingest::raw::RawFile;

use crate::exit::Failure;

/// Names of what is written, without what they end in: those of the pictures, with a number before those that several have.
pub fn names(all: &[&RawFile]) -> Vec<String> {
    let mut counts: BTreeMap<&str, usize> = BTreeMap::new();
    for raw in all {
        *counts.entry(raw.file_name()).or_default() += 1;
    }
    let is_shared = |raw: &RawFile| counts.get(raw.file_name()).is_some_and(|count| *count > 1);
    let name = |(i, raw): (usize, &&RawFile)| match raw.file_name() {
        name if is_shared(raw) => format!("{}-{name}", i + 1),
        name => name.to_owned(),
    };
    all.iter().enumerate().map(name).collect()
}

/// What is drawn does not lie among the pictures: there it would be measured the next time.
pub fn check_out(out: &Path, pictures: &[PathBuf]) -> Result<(), Failure> {
    let real = |path: &Path| std::fs::canonicalize(path).unwrap_or_else(|_| path.to_owned());
    match pictures.iter().find(|path| path.is_dir() && real(path) == real(out)) {
        None => Ok(()),
        Some(path) => Err(Failure::Flag {
            flag: "--out",
            found: format!("`{}`, the folder of the pictures", path.display()),
            expected: "another folder: what is drawn would be measured as a picture the next time".to_owned(),
            next: "name a folder beside it".to_owned(),
        }),
    }
}

/// `NAME-measured.png`, and `NAME-profile.csv` where there is one.
pub fn write(picture: &Picture, reading: &Reading, name: &Path) -> Result<(), Failure> {
    let written = |ending: &str, bytes: &[u8]| {
        let mut path = name.as_os_str().to_owned();
        path.push(ending);
        std::fs::write(&path, bytes).map_err(|source| IngestError::write(Path::new(&path), source))
    };
    let png = overlay(picture, &reading.marks, usize::MAX)
        .map_err(|why| IngestError::write(name, std::io::Error::other(why)))?;
    written("-measured.png", &png)?;
    if let Some(profile) = &reading.profile {
        written("-profile.csv", csv(profile).as_bytes())?;
    }
    Ok(())
}

/// Numbers under headers that need no quotes.
fn csv(profile: &Profile) -> String {
    let (name, unit) = profile.name;
    let mut text = format!("along ({}),{name} ({unit}),std ({unit})\n", profile.along_unit);
    for (along, there) in &profile.points {
        // Writing to a String cannot fail.
        let _ = writeln!(text, "{along:.8},{:.8},{:.8}", there.value, there.std);
    }
    text
}
