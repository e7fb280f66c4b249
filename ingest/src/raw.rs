//! A raw file: bytes that are read from front to back, as often as needed, and never held whole.
//!
//! A bag of ROS 2 is a folder, and so are photographs; its files are [`parts`](RawFile::parts), and each of them a raw file.

use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use crate::IngestError;
use crate::digest::Digest;
use crate::formats::pictures::has_name_of_picture;
use crate::limits::FOLDER_FILES_MAX;

/// A raw file, or bytes that stand for one.
#[derive(Debug, Clone)]
pub struct RawFile<'a> {
    name: String,
    source: Source<'a>,
    bytes: u64,
}

#[derive(Debug, Clone)]
enum Source<'a> {
    Path(PathBuf),
    Bytes(&'a [u8]),
    Owned(Arc<[u8]>),
    Folder(PathBuf, Vec<RawFile<'a>>),
    Through(&'a RawFile<'a>, Through),
}

/// Gives the bytes of a file otherwise than they stand there: fewer of them.
pub(crate) type Through = for<'r> fn(&'r RawFile<'r>) -> Result<Box<dyn Read + 'r>, IngestError>;

impl<'a> RawFile<'a> {
    /// A file on disk, or a folder with the files of a bag, one that holds `metadata.yaml` or `*.mcap`, or with pictures. `name` is what messages
    /// call it.
    ///
    /// # Errors
    /// [`IngestError::Read`] if it is neither: a pipe would wait for whoever writes to it. [`IngestError::TooLarge`] beyond
    /// `limit` bytes.
    pub fn open(path: &Path, name: &str, limit: u64) -> Result<Self, IngestError> {
        let failed = |source| IngestError::read(path, source);
        let metadata = std::fs::metadata(path).map_err(failed)?;
        if metadata.is_dir() {
            return Self::folder(path, name, limit);
        }
        if !metadata.is_file() {
            return Err(failed(std::io::Error::other("it is not a file")));
        }
        let bytes = metadata.len();
        if bytes > limit {
            return Err(IngestError::TooLarge { path: path.to_owned(), bytes, limit });
        }
        Ok(Self { name: name.to_owned(), source: Source::Path(path.to_owned()), bytes })
    }

    /// The regular files of a folder by name; what lies in folders below is not looked at.
    fn folder(path: &Path, name: &str, limit: u64) -> Result<Self, IngestError> {
        let failed = |source| IngestError::read(path, source);
        let mut names = Vec::new();
        for entry in std::fs::read_dir(path).map_err(failed)? {
            let entry = entry.map_err(failed)?;
            // Names that are no text belong to no bag.
            if let Ok(file) = entry.file_name().into_string()
                && entry.path().is_file()
            {
                names.push(file);
            }
            if names.len() > FOLDER_FILES_MAX {
                return Err(failed(std::io::Error::other(format!("it holds more than {FOLDER_FILES_MAX} files"))));
            }
        }
        names.sort();
        if !names.iter().any(|file| is_of_bag(file)) {
            // Of a folder of pictures they are its files, and nothing else that lies there.
            names.retain(|file| has_name_of_picture(file));
        }
        if names.is_empty() {
            return Err(failed(std::io::Error::other(
                "it is a folder, and neither one of a ROS 2 bag nor one of pictures",
            )));
        }
        let open = |file: &String| Self::open(&path.join(file), &format!("{name}/{file}"), limit);
        Self::of_parts(path, name, names.iter().map(open).collect::<Result<_, _>>()?, limit)
    }

    fn of_parts(path: &Path, name: &str, parts: Vec<Self>, limit: u64) -> Result<Self, IngestError> {
        let bytes = parts.iter().fold(0, |sum: u64, part| sum.saturating_add(part.bytes));
        if bytes > limit {
            return Err(IngestError::TooLarge { path: path.to_owned(), bytes, limit });
        }
        Ok(Self { name: name.to_owned(), source: Source::Folder(path.to_owned(), parts), bytes })
    }

    /// Files that stand for those of a folder, in the order of their names.
    pub fn of_files(name: &str, files: &[(&str, &'a [u8])]) -> Self {
        let mut parts: Vec<Self> =
            files.iter().map(|(file, bytes)| Self::of_bytes(&format!("{name}/{file}"), bytes)).collect();
        parts.sort_by(|a, b| a.name.cmp(&b.name));
        let bytes = parts.iter().map(|part| part.bytes).sum();
        Self { name: name.to_owned(), source: Source::Folder(name.into(), parts), bytes }
    }

    /// The files of a folder, by name; `None` for a single file.
    pub fn parts(&self) -> Option<&[Self]> {
        match &self.source {
            Source::Folder(_, parts) => Some(parts),
            Source::Path(_) | Source::Bytes(_) | Source::Owned(_) | Source::Through(..) => None,
        }
    }

    /// The name of a part within its folder.
    pub fn file_name(&self) -> &str {
        self.name.rsplit('/').next().unwrap_or(&self.name)
    }

    /// Bytes under a name.
    pub fn of_bytes(name: &str, bytes: &'a [u8]) -> Self {
        Self { name: name.to_owned(), source: Source::Bytes(bytes), bytes: bytes.len() as u64 }
    }

    /// Bytes under a name, kept with the file.
    pub fn owned(name: &str, bytes: Arc<[u8]>) -> Self {
        Self { name: name.to_owned(), bytes: bytes.len() as u64, source: Source::Owned(bytes) }
    }

    /// A file as `through` gives its bytes. Its length stays that of the file, which is the most that may come.
    pub(crate) fn through(raw: &'a Self, through: Through) -> Self {
        Self { name: raw.name.clone(), source: Source::Through(raw, through), bytes: raw.bytes }
    }

    /// What messages call it.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Its length when it was opened; of a folder that of all its files.
    pub fn len(&self) -> u64 {
        self.bytes
    }

    /// Whether there is nothing in it.
    pub fn is_empty(&self) -> bool {
        self.bytes == 0
    }

    /// From its first byte, up to the length it had when it was opened: a log that is still being written gives a prefix.
    ///
    /// # Errors
    /// [`IngestError::Read`] if it cannot be opened any more, and for folders.
    pub fn reader(&self) -> Result<Box<dyn Read + '_>, IngestError> {
        Ok(match &self.source {
            Source::Bytes(bytes) => Box::new(*bytes),
            Source::Owned(bytes) => Box::new(&bytes[..]),
            Source::Through(raw, through) => through(raw)?,
            Source::Folder(..) => return Err(self.failed(std::io::Error::other("it is a folder, not a file"))),
            Source::Path(path) => {
                let file = File::open(path).map_err(|source| IngestError::read(path, source))?;
                Box::new(file.take(self.bytes))
            }
        })
    }

    /// The first bytes, at most `count` of them.
    ///
    /// # Errors
    /// [`IngestError::Read`] if they cannot be read.
    pub fn head(&self, count: u64) -> Result<Vec<u8>, IngestError> {
        let mut head = Vec::new();
        self.reader()?.take(count).read_to_end(&mut head).map_err(|source| self.failed(source))?;
        Ok(head)
    }

    /// Its SHA-256; of a folder that of the list of its files, as `sha256sum *` prints it there.
    ///
    /// # Errors
    /// [`IngestError::Read`] if it cannot be read.
    pub fn sha256(&self) -> Result<String, IngestError> {
        if let Source::Bytes(bytes) = &self.source {
            return Ok(crate::digest::sha256(bytes));
        }
        let mut digest = Digest::default();
        if let Source::Folder(_, parts) = &self.source {
            for part in parts {
                digest.update(format!("{}  {}\n", part.sha256()?, part.file_name()).as_bytes());
            }
            return Ok(digest.finish());
        }
        let mut reader = self.reader()?;
        let mut block = vec![0; 1 << 18];
        loop {
            match reader.read(&mut block) {
                Ok(0) => return Ok(digest.finish()),
                Ok(count) => digest.update(&block[..count]),
                Err(error) if error.kind() == std::io::ErrorKind::Interrupted => {}
                Err(error) => return Err(self.failed(error)),
            }
        }
    }

    /// What the system said while it was read, as an error of this file; an error of this crate that went through a reader as it is.
    pub fn failed(&self, source: std::io::Error) -> IngestError {
        let source = match source.downcast::<IngestError>() {
            Ok(own) => return own,
            Err(source) => source,
        };
        let path = match &self.source {
            Source::Path(path) | Source::Folder(path, _) => path.clone(),
            Source::Bytes(_) | Source::Owned(_) => PathBuf::from(&self.name),
            Source::Through(raw, _) => return raw.failed(source),
        };
        IngestError::Read { path, source }
    }
}

/// Whether a file of this name makes a folder one of a bag.
fn is_of_bag(name: &str) -> bool {
    let extension = Path::new(name).extension();
    name == "metadata.yaml" || extension.is_some_and(|extension| extension == "mcap" || extension == "db3")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_and_its_bytes_are_read_alike() {
        let file = tempfile::NamedTempFile::new().unwrap();
        let bytes: Vec<u8> = (0..600_000_u32).flat_map(u32::to_le_bytes).collect();
        std::fs::write(file.path(), &bytes).unwrap();
        let raw = RawFile::open(file.path(), "r.bin", u64::MAX).unwrap();
        assert_eq!(raw.sha256().unwrap(), RawFile::of_bytes("r.bin", &bytes).sha256().unwrap());
        assert_eq!(raw.head(5).unwrap(), bytes[..5]);
        // What is written later does not belong to it.
        std::fs::write(file.path(), [&bytes[..], b"more"].concat()).unwrap();
        let mut read = Vec::new();
        raw.reader().unwrap().read_to_end(&mut read).unwrap();
        assert_eq!(read, bytes);
    }

    #[test]
    fn neither_a_device_nor_a_file_over_the_limit_is_opened() {
        let file = tempfile::NamedTempFile::new().unwrap();
        std::fs::write(file.path(), [0; 10]).unwrap();
        assert!(matches!(RawFile::open(file.path(), "r", 9), Err(IngestError::TooLarge { bytes: 10, limit: 9, .. })));
        assert!(matches!(RawFile::open(Path::new("/dev/zero"), "r", 100), Err(IngestError::Read { .. })));
    }
    #[test]
    fn a_folder_of_a_bag_is_its_files() {
        let folder = tempfile::tempdir().unwrap();
        let open = || RawFile::open(folder.path(), "bag", 100);
        std::fs::write(folder.path().join("notes.txt"), "x").unwrap();
        assert!(open().unwrap_err().to_string().contains("neither one of a ROS 2 bag nor one of pictures"));
        std::fs::write(folder.path().join("b_1.mcap"), "bb").unwrap();
        std::fs::write(folder.path().join("b_0.mcap"), "aaa").unwrap();
        std::fs::create_dir(folder.path().join("below")).unwrap();
        let raw = open().unwrap();
        let names: Vec<_> = raw.parts().unwrap().iter().map(|p| (p.name(), p.file_name())).collect();
        assert_eq!(names, [("bag/b_0.mcap", "b_0.mcap"), ("bag/b_1.mcap", "b_1.mcap"), ("bag/notes.txt", "notes.txt")]);
        assert_eq!(raw.len(), 6);
        assert!(matches!(raw.reader(), Err(IngestError::Read { .. })));
        // sha256sum * | sha256sum
        let files = [("b_0.mcap", &b"aaa"[..]), ("b_1.mcap", b"bb"), ("notes.txt", b"x")];
        assert_eq!(raw.sha256().unwrap(), RawFile::of_files("bag", &files).sha256().unwrap());
        assert_eq!(raw.sha256().unwrap(), "ace94cefb311b831e641df5f4c599576025b662c6a65f22a53e732f43ed427ca");
        assert!(matches!(RawFile::open(folder.path(), "bag", 5), Err(IngestError::TooLarge { .. })));
    }
}
