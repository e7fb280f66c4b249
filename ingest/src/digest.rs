//! SHA-256 as lower-case hexadecimal, as `sha256sum` prints it.

use std::fmt::Write;

use sha2::{Digest as _, Sha256};

/// The digest of bytes.
///
/// ```
/// let empty = pneuval_ingest::digest::sha256(b"");
/// assert_eq!(empty, "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
/// ```
pub fn sha256(bytes: &[u8]) -> String {
    let mut digest = Digest::default();
    digest.update(bytes);
    digest.finish()
}

/// The digest of bytes that come in blocks.
#[derive(Debug, Default, Clone)]
pub struct Digest(Sha256);

impl Digest {
    /// Adds a block.
    pub fn update(&mut self, block: &[u8]) {
        self.0.update(block);
    }

    /// The digest of all blocks.
    pub fn finish(self) -> String {
        self.0.finalize().iter().fold(String::with_capacity(64), |mut text, byte| {
            // Writing to a String cannot fail.
            let _ = write!(text, "{byte:02x}");
            text
        })
    }
}
