// SPDX-License-Identifier: MIT OR Apache-2.0
//! Files that are whole or as they were.

use crate::GateError;
use std::path::Path;

/// Renamed into place, so that a full disk leaves the file as it was.
pub(crate) fn replace(path: &Path, contents: impl AsRef<[u8]>) -> Result<(), GateError> {
    let part = path.with_added_extension("new");
    std::fs::write(&part, contents).map_err(GateError::io(path))?;
    std::fs::rename(&part, path).map_err(GateError::io(path))
}
