// SPDX-License-Identifier: MIT OR Apache-2.0
//! What is in the data folder under a file's name.

use serde::Serialize;
use std::io;
use std::path::{Path, PathBuf};
use terrafill_scene::sha256_hex;

/// A file of the data folder with what it must be.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PinnedFile<'a> {
    /// Path in the data folder.
    pub path: &'a str,
    /// SHA-256, lower-case hexadecimal.
    pub sha256: &'a str,
    /// Size, bytes, where it is known.
    pub bytes: Option<u64>,
}

/// What is there.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case", tag = "state")]
pub enum FileState {
    /// The file, with its hash.
    Here,
    /// Nothing.
    Missing,
    /// A transfer that was broken off.
    Begun {
        /// Bytes that have arrived.
        arrived_bytes: u64,
    },
    /// A file with other bytes.
    Different {
        /// Their SHA-256.
        found: String,
    },
    /// Something that cannot be read.
    Unreadable {
        /// The system's words.
        why: String,
    },
}

impl PinnedFile<'_> {
    /// What is in `folder` under this file's name. Reads the whole file.
    #[must_use]
    pub fn state_in(&self, folder: &Path) -> FileState {
        let path = folder.join(self.path);
        match std::fs::read(&path) {
            Ok(bytes) => {
                let found = sha256_hex(&bytes);
                if found == self.sha256 {
                    FileState::Here
                } else {
                    FileState::Different { found }
                }
            }
            Err(error) if error.kind() == io::ErrorKind::NotFound => {
                let part = std::fs::metadata(part_path(&path));
                let arrived_bytes = part.map_or(0, |part| part.len());
                if arrived_bytes > 0 {
                    FileState::Begun { arrived_bytes }
                } else {
                    FileState::Missing
                }
            }
            Err(error) => FileState::Unreadable {
                why: error.to_string(),
            },
        }
    }
}

/// Where the bytes of `path` are until they are all there: a name that no scene reads.
pub(crate) fn part_path(path: &Path) -> PathBuf {
    let mut name = path.file_name().unwrap_or_default().to_owned();
    name.push(".part");
    path.with_file_name(name)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_state_is_told_from_the_others() {
        let folder = tempfile::tempdir().expect("a folder");
        let sha256 = sha256_hex(b"abc");
        let file = PinnedFile {
            path: "a/f",
            sha256: &sha256,
            bytes: Some(3),
        };
        let state = || file.state_in(folder.path());
        assert_eq!(state(), FileState::Missing);
        std::fs::create_dir(folder.path().join("a")).expect("writable");
        std::fs::write(folder.path().join("a/f.part"), "ab").expect("writable");
        assert_eq!(state(), FileState::Begun { arrived_bytes: 2 });
        std::fs::write(folder.path().join("a/f"), "abd").expect("writable");
        let found = sha256_hex(b"abd");
        assert_eq!(state(), FileState::Different { found });
        std::fs::write(folder.path().join("a/f"), "abc").expect("writable");
        assert_eq!(state(), FileState::Here);
        std::fs::remove_file(folder.path().join("a/f")).expect("writable");
        std::fs::create_dir(folder.path().join("a/f")).expect("writable");
        assert!(matches!(state(), FileState::Unreadable { .. }));
    }
}
