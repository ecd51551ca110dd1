// SPDX-License-Identifier: MIT OR Apache-2.0
//! Why a scene cannot be loaded.

use crate::{RegionLoadError, choices};
use serde::de::DeserializeOwned;
use std::io;
use std::path::PathBuf;

/// Why a scene cannot be used.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SceneError {
    /// No shipped scene has this name.
    #[error("scene {name:?} is not shipped, allowed: {allowed}")]
    Unknown {
        /// Name asked for.
        name: String,
        /// Names there are.
        allowed: String,
    },
    /// Regions alone, where a scene is wanted.
    #[error(
        "{path}: is a file of regions, allowed: a scene or a scene file; `terrafill scene init {path}` makes one"
    )]
    RegionFile {
        /// The path.
        path: String,
    },
    /// The scene file cannot be read.
    #[error("{}: cannot be read: {source}", path.display())]
    Unreadable {
        /// The path.
        path: PathBuf,
        /// The system's words.
        source: io::Error,
    },
    /// Not TOML, a key that means nothing, a missing key or a value of the wrong type.
    #[error("{file}:{line}:{column}: {message}")]
    Syntax {
        /// The scene file.
        file: String,
        /// From 1.
        line: usize,
        /// From 1, in bytes.
        column: usize,
        /// The parser's words.
        message: String,
    },
    /// A value outside what is allowed.
    #[error("{file}: {key}: found {found}, allowed: {allowed}")]
    Value {
        /// The scene file.
        file: String,
        /// Path of the key, such as `views[2].latitude_deg`.
        key: String,
        /// The value.
        found: String,
        /// What it may be.
        allowed: String,
    },
    /// The scene is right, but its data is not here: to be skipped, not failed.
    #[error("scene {scene} needs {file} (sha256 {sha256}), but {why}; {how}")]
    DataMissing {
        /// Name of the scene.
        scene: String,
        /// Path relative to the data folder.
        file: String,
        /// Hash the file must have.
        sha256: String,
        /// What is the matter.
        why: String,
        /// How to get the file.
        how: String,
    },
    /// The texture's file is here, with the right bytes, and is no picture that can be used.
    #[error("{file}: is no picture that can be used: {message}")]
    Image {
        /// Path relative to the data folder.
        file: String,
        /// What is the matter.
        message: String,
    },
    /// The regions' file is here and is wrong.
    #[error(transparent)]
    Regions(#[from] RegionLoadError),
}

/// What the text of a scene file holds.
///
/// # Errors
/// [`SceneError::Syntax`].
pub(crate) fn parsed<T: DeserializeOwned>(text: &str, file: &str) -> Result<T, SceneError> {
    toml::from_str(text).map_err(|error| syntax_error(text, file, &error))
}

/// The parser's complaint with its place, on one line.
fn syntax_error(text: &str, file: &str, error: &toml::de::Error) -> SceneError {
    let start = error.span().map_or(0, |span| span.start.min(text.len()));
    let before = &text.as_bytes()[..start];
    let line_start = before
        .iter()
        .rposition(|&b| b == b'\n')
        .map_or(0, |i| i + 1);
    SceneError::Syntax {
        file: file.to_owned(),
        line: before.iter().filter(|&&b| b == b'\n').count() + 1,
        column: start - line_start + 1,
        message: one_line(error),
    }
}

/// The parser's words on one line; of the keys that there are, as many as one reads.
pub(crate) fn one_line(error: &toml::de::Error) -> String {
    let message = error.message().replace('\n', ", ");
    let Some((problem, keys)) = message.split_once(", expected one of ") else {
        return message;
    };
    let found = problem.split('`').nth(1).unwrap_or_default();
    let keys = keys.split(", ").map(|key| key.trim_matches('`'));
    format!("{problem}, allowed: {}", choices(found, keys))
}
