//! The papers' numbers, embedded, and the way to find a user's own.
//!
//! | folder | holds |
//! |---|---|
//! | `published/<id>/` | `dataset.toml` and its tables: numbers as printed, holes left empty |
//! | `actuators/<id>.toml` | chambers, dimensions, material, each value with its place in the paper |
//! | `bounds/<actuator>.toml` | acceptance limits, each with its reason |
//!
//! Lookup of an actuator or of bounds: the dataset's folder, its parents, then what is embedded here; the nearest wins.

use std::path::{Path, PathBuf};

use thiserror::Error;

use pneuval_ingest::error::suggestion;
use pneuval_ingest::manifest::{Actuator, PublishedDataset};
use pneuval_ingest::{IngestError, limits};

/// The embedded files: path below `datasets/`, and content.
pub const EMBEDDED: &[(&str, &[u8])] = include!(concat!(env!("OUT_DIR"), "/embedded.rs"));

/// How deep a folder is searched for datasets.
const DEPTH_MAX: usize = 16;

/// Errors of finding data.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum DatasetError {
    /// A file is not what it should be.
    #[error(transparent)]
    Ingest(#[from] IngestError),
    /// A path the user named does not exist.
    #[error("{}: no such file or folder", path.display())]
    NotFound {
        /// The path.
        path: PathBuf,
    },
    /// A folder holds no dataset.
    #[error("{}: no dataset here\n  expected: a dataset.toml in this folder or below\n  next:     name a dataset's folder, or no path for the embedded papers", path.display())]
    NoDataset {
        /// The folder.
        path: PathBuf,
    },
    /// A dataset names an actuator that nobody describes.
    #[error(
        "{file}: key `actuator`\n  expected: an actuator.toml beside it, above it, or embedded\n  found:    `{actuator}`\n  next:     {next}"
    )]
    UnknownActuator {
        /// The dataset.
        file: String,
        /// The actuator it names.
        actuator: String,
        /// What to do.
        next: String,
    },
    /// Two datasets carry one id.
    #[error(
        "{file}: key `id`\n  expected: every dataset id once\n  found:    `{id}`, as in {other}\n  next:     rename one"
    )]
    DuplicateId {
        /// The second dataset.
        file: String,
        /// The first.
        other: String,
        /// The id.
        id: String,
    },
}

/// A file and where it was found.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Located {
    /// Its name for messages.
    pub file: String,
    /// Its path relative to the dataset's folder, for provenance.
    pub relative: String,
    /// Its content.
    pub bytes: Vec<u8>,
    /// Whether it is one of the embedded files.
    pub embedded: bool,
}

/// A dataset with its actuator and the bounds that apply to it.
#[derive(Debug, Clone)]
pub struct Found {
    /// `dataset.toml`, for messages.
    pub file: String,
    /// The dataset.
    pub dataset: PublishedDataset,
    /// The actuator, and its path relative to the dataset's folder.
    pub actuator: Actuator,
    /// That path.
    pub actuator_file: String,
    /// The bounds file, if any was found.
    pub bounds: Option<Located>,
}

/// A place where files lie: a folder on disk, or one embedded here.
enum Folder {
    Disk(PathBuf),
    Embedded(String),
}

/// Every dataset below the given paths, by id; without paths, the embedded papers.
///
/// # Errors
/// The first path that does not exist or holds no dataset, and the first file that cannot be read or is malformed.
pub fn find(paths: &[PathBuf]) -> Result<Vec<Found>, DatasetError> {
    let mut folders = Vec::new();
    if paths.is_empty() {
        let names = EMBEDDED.iter().filter_map(|(name, _)| name.strip_suffix("/dataset.toml"));
        folders.extend(names.map(|name| Folder::Embedded(name.to_owned())));
    }
    for path in paths {
        let before = folders.len();
        if path.is_file() && path.file_name().is_some_and(|name| name == "dataset.toml") {
            let parent = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
            folders.push(Folder::Disk(parent.to_owned()));
        } else if path.is_dir() {
            collect(path, DEPTH_MAX, &mut folders)?;
        } else if !path.exists() {
            return Err(DatasetError::NotFound { path: path.clone() });
        }
        if folders.len() == before {
            return Err(DatasetError::NoDataset { path: path.clone() });
        }
    }
    let mut found: Vec<Found> = Vec::new();
    for folder in &folders {
        let item = folder.load()?;
        if let Some(other) = found.iter().find(|f| f.dataset.id == item.dataset.id) {
            return Err(DatasetError::DuplicateId { file: item.file, other: other.file.clone(), id: item.dataset.id });
        }
        found.push(item);
    }
    found.sort_by(|a, b| a.dataset.id.cmp(&b.dataset.id));
    Ok(found)
}

/// An actuator by id: `actuator.toml` or `actuators/<id>.toml` in a folder or above it, or embedded.
///
/// # Errors
/// [`DatasetError::UnknownActuator`] with the nearest embedded id.
pub fn find_actuator(id: &str, from: &Path) -> Result<Actuator, DatasetError> {
    let folder = Folder::Disk(from.to_owned());
    match folder.actuator(id)? {
        Some((actuator, _)) => Ok(actuator),
        None => Err(unknown_actuator("actuator", id)),
    }
}

/// The embedded actuators' ids.
pub fn embedded_actuators() -> impl Iterator<Item = &'static str> {
    EMBEDDED.iter().filter_map(|(name, _)| name.strip_prefix("actuators/")?.strip_suffix(".toml"))
}

fn unknown_actuator(file: &str, id: &str) -> DatasetError {
    let next = format!("{}; or write an actuator.toml of that id here or above", suggestion(id, embedded_actuators()));
    DatasetError::UnknownActuator { file: file.to_owned(), actuator: id.to_owned(), next }
}

/// Datasets below a folder, in the order of their names; hidden folders and links are left out.
fn collect(folder: &Path, depth: usize, found: &mut Vec<Folder>) -> Result<(), IngestError> {
    if folder.join("dataset.toml").is_file() {
        found.push(Folder::Disk(folder.to_owned()));
    }
    if depth == 0 {
        return Ok(());
    }
    let entries = std::fs::read_dir(folder).map_err(|source| IngestError::read(folder, source))?;
    let mut below = Vec::new();
    for entry in entries {
        let entry = entry.map_err(|source| IngestError::read(folder, source))?;
        let kind = entry.file_type().map_err(|source| IngestError::read(&entry.path(), source))?;
        if kind.is_dir() && !entry.file_name().to_string_lossy().starts_with('.') {
            below.push(entry.path());
        }
    }
    below.sort();
    below.iter().try_for_each(|path| collect(path, depth - 1, found))
}

impl Folder {
    fn load(&self) -> Result<Found, DatasetError> {
        let (file, bytes) = self.read("dataset.toml")?;
        let dataset = PublishedDataset::read(&file, &bytes, &|name| self.read(name))?;
        let Some((actuator, actuator_file)) = self.actuator(&dataset.actuator)? else {
            return Err(unknown_actuator(&file, &dataset.actuator));
        };
        let bounds_name = format!("bounds/{}.toml", dataset.actuator);
        let bounds = self.lookup(&["bounds.toml", &bounds_name])?;
        Ok(Found { file, dataset, actuator, actuator_file, bounds })
    }

    /// A file of this folder: its name for messages, and its bytes.
    fn read(&self, name: &str) -> Result<(String, Vec<u8>), IngestError> {
        match self {
            Self::Disk(folder) => {
                let path = folder.join(name);
                let real = |path: &Path| path.canonicalize().map_err(|source| IngestError::read(path, source));
                if !real(&path)?.starts_with(real(folder)?) {
                    let outside = std::io::Error::other("it is a link that leads out of its folder");
                    return Err(IngestError::read(&path, outside));
                }
                let bytes = limits::read(&path, limits::WRITTEN_BYTES_MAX)?;
                Ok((path.display().to_string(), bytes))
            }
            Self::Embedded(folder) => {
                let path = format!("{folder}/{name}");
                match embedded(&path) {
                    Some(bytes) => Ok((format!("embedded {path}"), bytes.to_vec())),
                    None => Err(IngestError::read(Path::new(&path), std::io::ErrorKind::NotFound.into())),
                }
            }
        }
    }

    /// The nearest actuator of an id: at each level `actuator.toml`, if it is of this id, or `actuators/<id>.toml`.
    fn actuator(&self, id: &str) -> Result<Option<(Actuator, String)>, IngestError> {
        for located in self.candidates(&["actuator.toml", &format!("actuators/{id}.toml")])? {
            let located = located?;
            let actuator = Actuator::read(&located.file, &located.bytes)?;
            if actuator.id == id {
                return Ok(Some((actuator, located.relative)));
            }
        }
        Ok(None)
    }

    /// The nearest of the named files.
    fn lookup(&self, names: &[&str]) -> Result<Option<Located>, IngestError> {
        self.candidates(names)?.next().transpose()
    }

    /// The named files in this folder, its parents, then embedded, nearest first; read one by one.
    fn candidates<'a>(
        &self,
        names: &'a [&'a str],
    ) -> Result<impl Iterator<Item = Result<Located, IngestError>> + 'a, IngestError> {
        let mut levels: Vec<PathBuf> = Vec::new();
        if let Self::Disk(folder) = self {
            // `..` and links resolved, so that the same folder has the same parents from wherever it is named.
            let real = folder.canonicalize().map_err(|source| IngestError::read(folder, source))?;
            levels.extend(real.ancestors().map(Path::to_owned));
        }
        let shown = match self {
            Self::Disk(folder) => folder.clone(),
            Self::Embedded(_) => PathBuf::new(),
        };
        let on_disk = levels.into_iter().enumerate().flat_map(move |(level, ancestor)| {
            let shown = shown.clone();
            names.iter().filter_map(move |name| {
                let path = ancestor.join(name);
                path.is_file().then(|| {
                    let relative = format!("{}{name}", "../".repeat(level));
                    let bytes = limits::read(&path, limits::WRITTEN_BYTES_MAX)?;
                    Ok(Located { file: shown.join(&relative).display().to_string(), relative, bytes, embedded: false })
                })
            })
        });
        let embedded = names.iter().filter_map(|name| {
            let bytes = embedded(name)?.to_vec();
            // As seen from `published/<id>/`, where the embedded files lie in the repository.
            Some(Ok(Located {
                file: format!("embedded {name}"),
                relative: format!("../../{name}"),
                bytes,
                embedded: true,
            }))
        });
        Ok(on_disk.chain(embedded))
    }
}

fn embedded(name: &str) -> Option<&'static [u8]> {
    EMBEDDED.iter().find(|(file, _)| *file == name).map(|(_, bytes)| *bytes)
}
