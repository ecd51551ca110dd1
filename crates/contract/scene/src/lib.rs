// SPDX-License-Identifier: MIT OR Apache-2.0
//! Scenes: body, regions, surface and cameras, read from TOML and checked once; and the plan of
//! what a frame of a scene draws and leaves out.

mod boundary_pieces;
mod camera;
mod data;
mod error;
mod file;
mod generated;
mod ground_rect;
mod interior;
mod lazy_mesh;
mod left_out;
mod level;
mod near_plane;
mod needs;
mod part_culling;
mod parts;
mod pixel_rect;
mod plan;
mod procedural;
mod scene;
mod shipped;
mod suite;
mod texture;

pub use camera::{Camera, CameraPose, ImageSize};
pub use data::{
    DATA_DIR_VARIABLE, DEFAULT_DATA_DIR, DataFile, DataNeed, RegionLoadError, SceneNeeds, data_dir,
    data_dir_from_env, load_regions, sha256_hex,
};
pub use error::SceneError;
pub use file::scene_needs;
pub use generated::{Cells, Coast, Nested};
pub use lazy_mesh::LazyMesh;
pub use left_out::LeftOutReason;
pub use level::{
    FEWEST_VERTICES_FOR_LEVELS, LEVEL_GROWTH, LEVEL_VERTEX_SHARE, Level, LevelTable, LeveledMeshes,
};
pub use near_plane::NearRectangle;
pub use needs::shipped_scene_needs;
pub use parts::{MeshParts, PART_FACETS, PartOrder, SeenParts};
pub use pixel_rect::PixelRect;
pub use plan::{
    CAP_CLEARANCE_PX, DrawnAs, FramePlan, GLOBAL_HEIGHT_M, HeightRange, LeftOutRegion, MeshBounds,
    PartCulling, PlanOptions, PlannedRegion, RegionBounds, SmallRings, WallHeights,
};
pub use procedural::Islands;
pub use scene::{LevelChoice, Overlap, Scene, SurfaceChoice, SurfaceFile, TexturedFills, View};
pub use shipped::{shipped_scene_names, shipped_scene_text, suite_names, suite_scenes};
pub use suite::{Expectation, SuiteScene, SuiteView};
pub use terrafill_core::ShapeFamily;
pub use texture::{
    MipChain, MipLevel, Outside, SceneTexture, TextureAnchor, TexturePlacement, TextureShare,
    checker,
};
