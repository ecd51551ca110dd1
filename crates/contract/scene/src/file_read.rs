// SPDX-License-Identifier: MIT OR Apache-2.0
//! What a scene was read from, as reports name it.

use crate::sha256_hex;

/// A file with regions, heights or a picture as it was read.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FileRead {
    /// As the scene names it; of a file that ships with the program, its path in the repository.
    pub path: String,
    /// SHA-256 of its bytes, lower-case hexadecimal.
    pub sha256: String,
    /// What is remarkable about it as a whole.
    pub warnings: Vec<String>,
}

impl FileRead {
    /// A file of `bench-scenes/`, which ships with the program.
    pub(crate) fn shipped(name: &str, bytes: &[u8]) -> Self {
        Self {
            path: format!("bench-scenes/{name}"),
            sha256: sha256_hex(bytes),
            warnings: Vec::new(),
        }
    }
}
