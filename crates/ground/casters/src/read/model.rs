// SPDX-License-Identifier: MIT OR Apache-2.0
//! What readers make of a file, and how they say what is wrong in it.

/// An element of [`super::ReadError`] whose file is not named yet.
#[derive(Debug, PartialEq)]
pub(super) struct Wrong {
    pub(super) element: String,
    pub(super) found: String,
    pub(super) allowed: String,
}

pub(super) fn wrong(
    element: impl Into<String>,
    found: impl ToString,
    allowed: impl Into<String>,
) -> Wrong {
    Wrong {
        element: element.into(),
        found: found.to_string(),
        allowed: allowed.into(),
    }
}

/// Triangles of a model as the file indexes them; axes and units still the file's.
#[derive(Debug, Default, PartialEq)]
pub(super) struct Model {
    pub(super) name: String,
    pub(super) places: Vec<[f64; 3]>,
    pub(super) triangles: Vec<[u32; 3]>,
}

/// Everything in a file.
#[derive(Debug, Default, PartialEq)]
pub(super) struct Contents {
    pub(super) models: Vec<Model>,
    /// What was read otherwise than the file says, or not at all.
    pub(super) warnings: Vec<String>,
}

impl Contents {
    /// Says how many faces of a model were left out since they have no area.
    pub(super) fn warn_degenerate(&mut self, model: &str, faces: usize) {
        if faces > 0 {
            self.warnings.push(format!(
                "object {model:?}: {faces} faces that name a vertex twice have no area, and are left out"
            ));
        }
    }
}
