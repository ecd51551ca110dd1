// SPDX-License-Identifier: MIT OR Apache-2.0
//! What shipped scenes read from the data folder.

use crate::file::scene_needs;
use crate::shipped::{BY_PATH, SCENES};
use crate::{SceneError, SceneNeeds};

/// What each scene of `bench-scenes/` reads from the data folder; those of subfolders by their path.
///
/// # Errors
/// [`SceneError::Syntax`] if a scene is no scene file, which a test rules out.
pub fn shipped_scene_needs() -> Result<Vec<SceneNeeds>, SceneError> {
    let by_name = SCENES
        .iter()
        .map(|scene| (scene, scene.0.trim_end_matches(".toml").to_owned()));
    let by_path = BY_PATH
        .iter()
        .map(|scene| (scene, format!("bench-scenes/{}", scene.0)));
    by_name
        .chain(by_path)
        .map(|((file, text), scene)| {
            let files = scene_needs(text, &format!("bench-scenes/{file}"))?;
            Ok(SceneNeeds { scene, files })
        })
        .collect()
}
