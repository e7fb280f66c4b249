//! The papers' numbers, embedded, and the way to find a user's own.
//!
//! | folder | holds |
//! |---|---|
//! | `published/<id>/` | `dataset.toml` and its tables: numbers as printed, holes left empty |
//! | `actuators/<id>.toml` | chambers, dimensions, material, each value with its place in the paper |
//! | `bounds/<actuator>.toml` | acceptance limits, each with its reason |
//! | `claims/<paper>.toml` | what the papers say, and how it is recomputed |
//! | `rigs/<id>.toml` | instruments with their calibration |
//! | `rehearsals/<id>.toml` | what the rehearsal rig does: see [`rehearse`] |
//!
//! A user's own data are a `dataset.toml` (printed tables) or a `session.toml` (raw logs) in a folder.
//!
//! Lookup of an actuator, a rig or of bounds: the dataset's folder, its parents, then what is embedded here; the nearest wins.
//! An `actuator.toml` without an id describes the actuator of the data beside it once it holds anything; empty, it loses to any
//! other.
//!
//! What people wrote is read and checked before any log: [`describe`], then [`load`]. [`find`] is both.

pub mod rehearse;

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use thiserror::Error;

use pneuval_ingest::error::suggestion;
use pneuval_ingest::manifest::{Actuator, PublishedDataset, Rig, SessionManifest};
use pneuval_ingest::raw::RawFile;
use pneuval_ingest::session::Session;
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
    #[error("{}: no dataset here\n  expected: a dataset.toml or session.toml in this folder or below\n  next:     `pneuval init` writes a first session.toml from the logs in a folder; without a path the embedded papers are validated", path.display())]
    NoDataset {
        /// The folder.
        path: PathBuf,
    },
    /// Folders lie too deep to be searched.
    #[error("{}: folders below this one\n  expected: at most {DEPTH_MAX} levels of folders\n  next:     name a folder further down", path.display())]
    TooDeep {
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
    /// A session names a rig that nobody describes.
    #[error(
        "{file}: key `rig`\n  expected: a rig.toml of that id beside it, above it, or embedded\n  found:    `{rig}`\n  next:     {next}"
    )]
    UnknownRig {
        /// The session.
        file: String,
        /// The rig it names.
        rig: String,
        /// What to do.
        next: String,
    },
    /// A rehearsal is asked for that nobody describes.
    #[error(
        "no plan of a rehearsal\n  expected: rehearsals/{plan}.toml here or above, an embedded one, or a file\n  found:    `{plan}`\n  next:     {next}"
    )]
    UnknownPlan {
        /// What was asked for.
        plan: String,
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
    /// The folder it lies in.
    folder: Folder,
}

impl Located {
    /// A file that lies beside it.
    fn beside(&self, name: &str) -> Result<Vec<u8>, IngestError> {
        Ok(self.folder.read(name)?.1)
    }
}

/// What was found in a folder.
#[derive(Debug, Clone)]
pub enum FoundData {
    /// A paper's printed tables.
    Published(Box<PublishedDataset>),
    /// Raw logs.
    Session(Box<Session>),
}

impl FoundData {
    /// Its id.
    pub fn id(&self) -> &str {
        match self {
            Self::Published(dataset) => &dataset.id,
            Self::Session(session) => &session.manifest.id,
        }
    }
}

/// A dataset or session as it is written, with what it names; logs are not read yet.
#[derive(Debug)]
pub struct Described {
    /// `dataset.toml` or `session.toml`, for messages.
    pub file: String,
    /// The bounds file, if any was found.
    pub bounds: Option<Located>,
    data: Written,
    actuator: Actuator,
    actuator_file: String,
    folder: Folder,
}

/// What was written; a paper's tables are part of it.
#[derive(Debug)]
enum Written {
    Published(Box<PublishedDataset>),
    Session(Box<SessionManifest>, Option<Rig>),
}

impl Described {
    /// Its id.
    pub fn id(&self) -> &str {
        match &self.data {
            Written::Published(dataset) => &dataset.id,
            Written::Session(manifest, _) => &manifest.id,
        }
    }

    /// The manifest and the rig, if it is a session.
    pub fn session(&self) -> Option<(&SessionManifest, Option<&Rig>)> {
        match &self.data {
            Written::Published(_) => None,
            Written::Session(manifest, rig) => Some((manifest, rig.as_ref())),
        }
    }

    /// Its folder; `None` for what is embedded.
    pub fn folder(&self) -> Option<&Path> {
        match &self.folder {
            Folder::Disk(folder) => Some(folder),
            Folder::Embedded(_) => None,
        }
    }

    /// A raw log that it names.
    ///
    /// # Errors
    /// [`IngestError::Read`] if it is not there, or a link leads out of the folder.
    pub fn open_log(&self, name: &str) -> Result<RawFile<'static>, IngestError> {
        self.folder.open_log(name)
    }

    /// Reads the logs.
    fn load(self) -> Result<Found, IngestError> {
        let data = match self.data {
            Written::Published(dataset) => FoundData::Published(dataset),
            Written::Session(manifest, rig) => {
                let open = |name: &str| self.folder.open_log(name);
                FoundData::Session(Box::new(Session::load(*manifest, rig, &open)?))
            }
        };
        let Self { file, bounds, actuator, actuator_file, .. } = self;
        Ok(Found { file, data, actuator, actuator_file, bounds })
    }
}

/// A dataset or session with its actuator and the bounds that apply to it.
#[derive(Debug, Clone)]
pub struct Found {
    /// `dataset.toml` or `session.toml`, for messages.
    pub file: String,
    /// The data.
    pub data: FoundData,
    /// The actuator, and its path relative to the dataset's folder.
    pub actuator: Actuator,
    /// That path.
    pub actuator_file: String,
    /// The bounds file, if any was found.
    pub bounds: Option<Located>,
}

/// A place where files lie: a folder on disk, or one embedded here.
#[derive(Debug, Clone, PartialEq, Eq)]
enum Folder {
    Disk(PathBuf),
    Embedded(String),
}

/// The files that make a folder one of data.
const MANIFESTS: [&str; 2] = ["dataset.toml", "session.toml"];

/// A manifest in a folder.
struct Place {
    folder: Folder,
    manifest: &'static str,
}

/// Every dataset below the given paths, by id; without paths, the embedded papers.
///
/// # Errors
/// As for [`describe`] and [`load`].
pub fn find(paths: &[PathBuf]) -> Result<Vec<Found>, DatasetError> {
    load(describe(paths)?, &mut || {})
}

/// Reads the logs of all that was described, and says after each that it is done.
///
/// # Errors
/// The first log that cannot be read or does not fit its manifest. One that holds nothing usable counts only where no other error
/// is found.
pub fn load(described: Vec<Described>, done: &mut dyn FnMut()) -> Result<Vec<Found>, DatasetError> {
    let (mut found, mut unusable) = (Vec::with_capacity(described.len()), None);
    for described in described {
        match described.load() {
            Ok(item) => found.push(item),
            Err(error @ IngestError::Unusable { .. }) => unusable = unusable.or(Some(error)),
            Err(error) => return Err(error.into()),
        }
        done();
    }
    unusable.map_or(Ok(found), |error| Err(error.into()))
}

/// What people wrote of every dataset below the given paths, by id; without paths, the embedded papers. No log is read.
///
/// # Errors
/// The first path that does not exist or holds no dataset, and the first file that cannot be read or is malformed.
pub fn describe(paths: &[PathBuf]) -> Result<Vec<Described>, DatasetError> {
    let mut folders: Vec<Place> = Vec::new();
    if paths.is_empty() {
        let names = EMBEDDED.iter().filter_map(|(name, _)| name.strip_suffix("/dataset.toml"));
        let place = |name: &str| Place { folder: Folder::Embedded(name.to_owned()), manifest: MANIFESTS[0] };
        folders.extend(names.map(place));
    }
    for path in paths {
        let before = folders.len();
        let named = MANIFESTS.into_iter().find(|name| path.file_name().is_some_and(|n| n == *name));
        if let Some(manifest) = named.filter(|_| path.is_file()) {
            let parent = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
            folders.push(Place { folder: Folder::Disk(parent.to_owned()), manifest });
        } else if path.is_dir() {
            let mut linked = Vec::new();
            collect(path, DEPTH_MAX, &mut folders, &mut linked)?;
            // A link such as `latest` to a folder that is here anyway names nothing new.
            let mut known: BTreeSet<PathBuf> = folders.iter().filter_map(Place::real).collect();
            folders.extend(linked.into_iter().filter(|place| place.real().is_none_or(|real| known.insert(real))));
        } else if !path.exists() {
            return Err(DatasetError::NotFound { path: path.clone() });
        }
        if folders.len() == before {
            return Err(DatasetError::NoDataset { path: path.clone() });
        }
    }
    let mut found: Vec<Described> = Vec::new();
    for folder in folders {
        let item = folder.describe()?;
        if let Some(other) = found.iter().find(|f| f.id() == item.id()) {
            let id = item.id().to_owned();
            return Err(DatasetError::DuplicateId { file: item.file, other: other.file.clone(), id });
        }
        found.push(item);
    }
    found.sort_by(|a, b| a.id().cmp(b.id()));
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

/// The text of an actuator file, embedded or on disk, as [`Actuator::file`] names it.
///
/// # Errors
/// [`IngestError`] if it cannot be read, or is no text.
pub fn actuator_text(actuator: &Actuator) -> Result<String, DatasetError> {
    let bytes = match actuator.file.strip_prefix("embedded ").and_then(embedded) {
        Some(bytes) => bytes.to_vec(),
        None => limits::read(Path::new(&actuator.file), limits::WRITTEN_BYTES_MAX)?,
    };
    Ok(pneuval_ingest::document::utf8(&actuator.file, &bytes)?.to_owned())
}

/// The ids of the embedded datasets.
pub fn embedded_datasets() -> impl Iterator<Item = &'static str> {
    EMBEDDED.iter().filter_map(|(name, _)| name.strip_prefix("published/")?.strip_suffix("/dataset.toml"))
}

/// The embedded claims files: name for messages, and bytes.
pub fn embedded_claims() -> impl Iterator<Item = (String, &'static [u8])> {
    let claims = EMBEDDED.iter().filter(|(name, _)| name.starts_with("claims/"));
    claims.map(|(name, bytes)| (format!("embedded {name}"), *bytes))
}

/// The embedded actuators' ids.
pub fn embedded_actuators() -> impl Iterator<Item = &'static str> {
    EMBEDDED.iter().filter_map(|(name, _)| name.strip_prefix("actuators/")?.strip_suffix(".toml"))
}

/// The ids of the embedded rehearsals.
pub fn rehearsals() -> impl Iterator<Item = &'static str> {
    EMBEDDED.iter().filter_map(|(name, _)| name.strip_prefix("rehearsals/")?.strip_suffix(".toml"))
}

/// The embedded paper of an actuator, if there is one.
fn embedded_dataset(actuator: &str) -> Result<Option<PublishedDataset>, DatasetError> {
    let folder = Folder::Embedded(format!("published/{actuator}"));
    let Some(bytes) = embedded(&format!("published/{actuator}/dataset.toml")) else { return Ok(None) };
    let file = format!("embedded published/{actuator}/dataset.toml");
    Ok(Some(PublishedDataset::read(&file, bytes, &|name| folder.read(name))?))
}

fn unknown_actuator(file: &str, id: &str) -> DatasetError {
    let next = format!("{}; or write an actuator.toml of that id here or above", suggestion(id, embedded_actuators()));
    DatasetError::UnknownActuator { file: file.to_owned(), actuator: id.to_owned(), next }
}

/// Datasets below a folder, in the order of their names; hidden folders are left out. A linked folder is looked into, for it may
/// be a sitting kept elsewhere, but not below: links may lead in circles and anywhere.
fn collect(folder: &Path, depth: usize, found: &mut Vec<Place>, linked: &mut Vec<Place>) -> Result<(), DatasetError> {
    let places = |folder: &Path| {
        let here = MANIFESTS.into_iter().filter(|name| folder.join(name).is_file());
        here.map(|manifest| Place { folder: Folder::Disk(folder.to_owned()), manifest }).collect::<Vec<_>>()
    };
    found.extend(places(folder));
    let failed = |source| IngestError::read(folder, source);
    let (mut below, mut links) = (Vec::new(), Vec::new());
    for entry in std::fs::read_dir(folder).map_err(failed)? {
        let entry = entry.map_err(failed)?;
        let kind = entry.file_type().map_err(|source| IngestError::read(&entry.path(), source))?;
        if entry.file_name().to_string_lossy().starts_with('.') {
            continue;
        }
        if kind.is_dir() {
            below.push(entry.path());
        } else if kind.is_symlink() {
            links.push(entry.path());
        }
    }
    if depth == 0 && !below.is_empty() {
        return Err(DatasetError::TooDeep { path: folder.to_owned() });
    }
    links.sort();
    linked.extend(links.iter().flat_map(|path| places(path)));
    below.sort();
    below.iter().try_for_each(|path| collect(path, depth - 1, found, linked))
}

impl Place {
    /// Where its manifest lies, links followed; `None` for an embedded one, and for one that is gone.
    fn real(&self) -> Option<PathBuf> {
        match &self.folder {
            Folder::Disk(folder) => folder.join(self.manifest).canonicalize().ok(),
            Folder::Embedded(_) => None,
        }
    }

    fn describe(self) -> Result<Described, DatasetError> {
        let folder = self.folder;
        let (file, bytes) = folder.read(self.manifest)?;
        let data = if self.manifest == MANIFESTS[0] {
            Written::Published(Box::new(PublishedDataset::read(&file, &bytes, &|name| folder.read(name))?))
        } else {
            let manifest = SessionManifest::read(&file, &bytes)?;
            let rig = manifest.rig.as_deref().map(|id| Ok::<_, DatasetError>(folder.rig(&file, id)?.0)).transpose()?;
            Written::Session(Box::new(manifest), rig)
        };
        let id = match &data {
            Written::Published(dataset) => &dataset.actuator,
            Written::Session(manifest, _) => &manifest.actuator,
        };
        let Some((actuator, Located { relative: actuator_file, .. })) = folder.actuator(id)? else {
            return Err(unknown_actuator(&file, id));
        };
        let bounds_name = format!("bounds/{id}.toml");
        let bounds = folder.lookup(&["bounds.toml", &bounds_name])?;
        Ok(Described { file, bounds, data, actuator, actuator_file, folder })
    }
}

/// Whether a first draft has been filled in with anything a model could use.
fn is_filled_in(draft: &Actuator) -> bool {
    let Actuator { chambers, values, materials, imported, .. } = draft;
    !(chambers.is_empty() && values.is_empty() && materials.is_empty() && imported.is_empty())
}

/// The path of a file in a folder, which no link may lead out of.
fn inside(folder: &Path, name: &str) -> Result<PathBuf, IngestError> {
    let path = folder.join(name);
    let real = |path: &Path| path.canonicalize().map_err(|source| IngestError::read(path, source));
    if real(&path)?.starts_with(real(folder)?) {
        return Ok(path);
    }
    let outside = std::io::Error::other("it is a link that leads out of its folder");
    Err(IngestError::read(&path, outside))
}

impl Folder {
    /// A file of this folder: its name for messages, and its bytes.
    fn read(&self, name: &str) -> Result<(String, Vec<u8>), IngestError> {
        self.read_up_to(name, limits::WRITTEN_BYTES_MAX)
    }

    /// A raw log of this folder, which is read in blocks.
    fn open_log(&self, name: &str) -> Result<RawFile<'static>, IngestError> {
        match self {
            Self::Disk(folder) => {
                let path = inside(folder, name)?;
                RawFile::open(&path, &path.display().to_string(), limits::LOG_BYTES_MAX)
            }
            Self::Embedded(folder) => {
                let path = format!("{folder}/{name}");
                let found = embedded(&path).map(|bytes| RawFile::of_bytes(&format!("embedded {path}"), bytes));
                found.ok_or_else(|| IngestError::read(Path::new(&path), std::io::ErrorKind::NotFound.into()))
            }
        }
    }

    fn read_up_to(&self, name: &str, limit: u64) -> Result<(String, Vec<u8>), IngestError> {
        match self {
            Self::Disk(folder) => {
                let path = inside(folder, name)?;
                let bytes = limits::read(&path, limit)?;
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

    /// The nearest actuator of an id: at each level `actuator.toml`, if it is of this id, or `actuators/<id>.toml`. One without an
    /// id, which `pneuval init` writes, is of any id for the data beside it: filled in, as the nearest; empty, where there is no
    /// other.
    fn actuator(&self, id: &str) -> Result<Option<(Actuator, Located)>, IngestError> {
        let mut draft = None;
        for located in self.candidates(&["actuator.toml", &format!("actuators/{id}.toml")])? {
            let located = located?;
            let beside = |name: &str| located.folder.read(name);
            let actuator = Actuator::read(&located.file, &located.bytes, id, &beside)?;
            if actuator.draft {
                if located.relative == "actuator.toml" {
                    let found = Some((actuator, located));
                    if found.as_ref().is_some_and(|(actuator, _)| is_filled_in(actuator)) {
                        return Ok(found);
                    }
                    draft = found;
                }
            } else if actuator.id == id {
                return Ok(Some((actuator, located)));
            }
        }
        Ok(draft)
    }

    /// The nearest rig of an id: at each level `rig.toml`, if it is of this id, or `rigs/<id>.toml`.
    fn rig(&self, file: &str, id: &str) -> Result<(Rig, Located), DatasetError> {
        let mut seen = Vec::new();
        for located in self.candidates(&["rig.toml", &format!("rigs/{id}.toml")])? {
            let located = located?;
            let rig = Rig::read(&located.file, &located.bytes)?;
            if rig.id == id {
                return Ok((Rig { relative: located.relative.clone(), ..rig }, located));
            }
            seen.push(rig.id);
        }
        let embedded = EMBEDDED.iter().filter_map(|(name, _)| name.strip_prefix("rigs/")?.strip_suffix(".toml"));
        let next = suggestion(id, seen.iter().map(String::as_str).chain(embedded));
        Err(DatasetError::UnknownRig { file: file.to_owned(), rig: id.to_owned(), next })
    }

    /// A plan of a rehearsal: a file, or the nearest `rehearsals/<id>.toml`; and the folder where it looks for what it names.
    fn plan(name: &str, from: &Path) -> Result<(Located, Self), DatasetError> {
        let path = from.join(name);
        if path.is_file() {
            let bytes = limits::read(&path, limits::WRITTEN_BYTES_MAX)?;
            let folder = Self::Disk(path.parent().unwrap_or(from).to_owned());
            let file = Path::new(name).display().to_string();
            let located = Located { relative: file.clone(), file, bytes, embedded: false, folder: folder.clone() };
            return Ok((located, folder));
        }
        let folder = Self::Disk(from.to_owned());
        match folder.lookup(&[&format!("rehearsals/{name}.toml")])? {
            Some(located) => Ok((located, folder)),
            None => Err(DatasetError::UnknownPlan { plan: name.to_owned(), next: suggestion(name, rehearsals()) }),
        }
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
                    let file = shown.join(&relative);
                    let folder = Folder::Disk(file.parent().map(Path::to_owned).unwrap_or_default());
                    Ok(Located { file: file.display().to_string(), relative, bytes, embedded: false, folder })
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
                folder: Folder::Embedded(name.rsplit_once('/').map_or(String::new(), |(folder, _)| folder.to_owned())),
            }))
        });
        Ok(on_disk.chain(embedded))
    }
}

fn embedded(name: &str) -> Option<&'static [u8]> {
    EMBEDDED.iter().find(|(file, _)| *file == name).map(|(_, bytes)| *bytes)
}
