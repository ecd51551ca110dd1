// SPDX-License-Identifier: MIT OR Apache-2.0
//! What shipped scenes read from the data folder.

use crate::file::scene_needs;
use crate::shipped::{SCENES, TERRAIN};
use crate::{SceneError, SceneNeeds};

/// What each scene of `bench-scenes/` reads from the data folder.
///
/// # Errors
/// [`SceneError::Syntax`] if a scene is no scene file, which a test rules out.
pub fn shipped_scene_needs() -> Result<Vec<SceneNeeds>, SceneError> {
    let scenes = SCENES.iter().chain(TERRAIN);
    scenes
        .map(|(file, text)| {
            let files = scene_needs(text, &format!("bench-scenes/{file}"))?;
            let scene = file.trim_end_matches(".toml").to_owned();
            Ok(SceneNeeds { scene, files })
        })
        .collect()
}
