//! Files that other people's instruments wrote. They are not part of this repository: `PNEUVAL_REFERENCE_DATA` names their folder.

// Each test file takes what it needs.
#![allow(dead_code)]

use std::io::Write as _;
use std::path::{Path, PathBuf};

/// A file or folder of the reference data; `None`, told, where there are none.
pub fn reference(name: &str) -> Option<PathBuf> {
    let Some(root) = std::env::var_os("PNEUVAL_REFERENCE_DATA") else {
        // Not `println!`, which the test runner keeps to itself. Nobody is told less if the stream is closed.
        let _ = writeln!(std::io::stderr(), "{name}: not run, PNEUVAL_REFERENCE_DATA is not set");
        return None;
    };
    Some(Path::new(&root).join(name))
}

/// The files of a folder of the reference data that end so, by name.
pub fn files(folder: &str, ending: &str) -> Option<Vec<PathBuf>> {
    let folder = reference(folder)?;
    let entries = std::fs::read_dir(&folder).unwrap_or_else(|error| panic!("{}: {error}", folder.display()));
    let mut files: Vec<PathBuf> = entries.map(|entry| entry.unwrap().path()).collect();
    files.retain(|path| path.extension().is_some_and(|extension| extension == ending));
    files.sort();
    Some(files)
}
