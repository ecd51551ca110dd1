// SPDX-License-Identifier: MIT OR Apache-2.0
//! Standard input in place of a file.

use crate::outcome::Failure;
use std::io::Read as _;
use std::path::Path;

/// Whether `path` stands for standard input, or for standard output where something is written.
pub(crate) fn is_standard(path: &Path) -> bool {
    path.as_os_str() == "-"
}

/// `path` in messages.
pub(crate) fn shown(path: &Path) -> String {
    if is_standard(path) {
        "standard input".to_owned()
    } else {
        path.display().to_string()
    }
}

/// Everything that standard input holds.
pub(crate) fn read_standard_input() -> Result<Vec<u8>, Failure> {
    let mut bytes = Vec::new();
    let read = std::io::stdin().lock().read_to_end(&mut bytes);
    read.map_err(|error| Failure::bad_input(format!("standard input: cannot be read: {error}")))?;
    Ok(bytes)
}
