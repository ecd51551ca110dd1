// SPDX-License-Identifier: MIT OR Apache-2.0
//! Scenes: body, regions, surface and cameras, read from TOML and checked once.

mod camera;
mod choices;
mod data;
mod error;
mod file;
mod file_read;
mod generated;
mod needs;
mod procedural;
mod scene;
mod shipped;
mod suite;
mod texture;

pub use camera::{Camera, CameraPose, ImageSize};
pub use choices::choices;
pub use data::{
    DATA_DIR_VARIABLE, DEFAULT_DATA_DIR, DataFile, DataNeed, RegionLoadError, SceneNeeds, data_dir,
    data_dir_from_env, joined_data_dirs, load_regions, sha256_hex, split_data_dirs,
};
pub use error::SceneError;
pub use file::{names_files, scene_needs};
pub use file_read::FileRead;
pub use generated::{Cells, Coast, Nested};
pub use needs::shipped_scene_needs;
pub use procedural::Islands;
pub use scene::{LevelChoice, Overlap, Scene, SurfaceChoice, SurfaceFile, TexturedFills, View};
pub use shipped::{
    scene_names_in_folders, shipped_scene_names, shipped_scene_text, suite_names, suite_scenes,
};
pub use suite::{Expectation, SuiteScene, SuiteView};
pub use texture::{
    MipChain, MipLevel, Outside, SceneTexture, TextureAnchor, TexturePlacement, TextureShare,
    checker,
};
