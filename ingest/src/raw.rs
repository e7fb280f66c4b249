//! A raw file: bytes that are read from front to back, as often as needed, and never held whole.

use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

use crate::IngestError;
use crate::digest::Digest;

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
}

impl<'a> RawFile<'a> {
    /// A file on disk; `name` is what messages call it.
    ///
    /// # Errors
    /// [`IngestError::Read`] if it is not a file: a pipe would wait for whoever writes to it. [`IngestError::TooLarge`] beyond
    /// `limit` bytes.
    pub fn open(path: &Path, name: &str, limit: u64) -> Result<Self, IngestError> {
        let failed = |source| IngestError::read(path, source);
        let metadata = std::fs::metadata(path).map_err(failed)?;
        if !metadata.is_file() {
            return Err(failed(std::io::Error::other("it is not a file")));
        }
        let bytes = metadata.len();
        if bytes > limit {
            return Err(IngestError::TooLarge { path: path.to_owned(), bytes, limit });
        }
        Ok(Self { name: name.to_owned(), source: Source::Path(path.to_owned()), bytes })
    }

    /// Bytes under a name.
    pub fn of_bytes(name: &str, bytes: &'a [u8]) -> Self {
        Self { name: name.to_owned(), source: Source::Bytes(bytes), bytes: bytes.len() as u64 }
    }

    /// What messages call it.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Its length when it was opened.
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
    /// [`IngestError::Read`] if it cannot be opened any more.
    pub fn reader(&self) -> Result<Box<dyn Read + '_>, IngestError> {
        Ok(match &self.source {
            Source::Bytes(bytes) => Box::new(*bytes),
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

    /// Its SHA-256.
    ///
    /// # Errors
    /// [`IngestError::Read`] if it cannot be read.
    pub fn sha256(&self) -> Result<String, IngestError> {
        if let Source::Bytes(bytes) = &self.source {
            return Ok(crate::digest::sha256(bytes));
        }
        let mut digest = Digest::default();
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

    /// What the system said while it was read, as an error of this file.
    pub fn failed(&self, source: std::io::Error) -> IngestError {
        let path = match &self.source {
            Source::Path(path) => path.clone(),
            Source::Bytes(_) => PathBuf::from(&self.name),
        };
        IngestError::Read { path, source }
    }
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
}
