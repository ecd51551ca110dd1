// SPDX-License-Identifier: MIT OR Apache-2.0
//! The scenes of `bench-scenes/`, built into the program so that it works from any folder.

use crate::{SceneError, SceneNeeds, scene_needs};

/// One file of `bench-scenes/` with its name.
macro_rules! file {
    ($name:literal) => {
        (
            $name,
            include_str!(concat!("../../../../bench-scenes/", $name)),
        )
    };
}

/// Scenes that need nothing else first, then those that need data.
const SCENES: &[(&str, &str)] = &[
    file!("planet-134.toml"),
    file!("california.toml"),
    file!("square-10m.toml"),
    file!("square-200km.toml"),
    file!("hills.toml"),
    file!("countries-110m.toml"),
    file!("countries-50m.toml"),
    file!("us-states.toml"),
    file!("blue-marble.toml"),
    file!("fade.toml"),
    file!("hatching.toml"),
    file!("shared-picture.toml"),
    file!("window-west.toml"),
    file!("window-east.toml"),
];

/// Scenes that are named by their path and read data: known here for what they need alone.
const BY_PATH: &[(&str, &str)] = &[
    file!("terrain/countries-over-etopo.toml"),
    file!("terrain/everest.toml"),
    file!("terrain/grand-canyon.toml"),
    file!("terrain/san-francisco.toml"),
];

/// Region files that scenes name by `embedded`.
const DATA: &[(&str, &str)] = &[
    file!("california.geojson"),
    file!("square-10m.geojson"),
    file!("square-200km.geojson"),
    file!("window-west.geojson"),
    file!("window-east.geojson"),
];

/// Names of the scenes that ship with the program, those without need of data first.
#[must_use]
pub fn shipped_scene_names() -> Vec<&'static str> {
    SCENES
        .iter()
        .map(|(file, _)| file.trim_end_matches(".toml"))
        .collect()
}

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

pub(crate) fn scene_text(name: &str) -> Option<&'static str> {
    find(SCENES, &format!("{name}.toml"))
}

pub(crate) fn data_text(name: &str) -> Option<&'static str> {
    find(DATA, name)
}

pub(crate) fn data_names() -> Vec<&'static str> {
    DATA.iter().map(|(name, _)| *name).collect()
}

fn find(files: &[(&str, &'static str)], name: &str) -> Option<&'static str> {
    files
        .iter()
        .find(|(file, _)| *file == name)
        .map(|(_, text)| *text)
}
