// SPDX-License-Identifier: MIT OR Apache-2.0
//! What a frame of a scene draws and what it leaves out, by name and reason.
//!
//! A [`FramePlan`] looks at bounds of meshes, at the eye and at the heights of the surface as drawn. It decides
//! culling, the near plane, levels of detail, parts of large meshes, and whose the ground in view is. It knows
//! neither techniques nor devices.

mod boundary_pieces;
mod ground_rect;
mod interior;
mod lazy_mesh;
mod left_out;
mod level;
mod near_plane;
mod part_culling;
mod parts;
mod pixel_rect;
mod plan;
mod region_set;
mod scene_bounds;

pub use lazy_mesh::LazyMesh;
pub use left_out::LeftOutReason;
pub use level::{
    FEWEST_VERTICES_FOR_LEVELS, LEVEL_GROWTH, LEVEL_VERTEX_SHARE, Level, LevelTable, LeveledMeshes,
};
pub use near_plane::NearRectangle;
pub use parts::{MeshParts, PART_FACETS, PartOrder, SeenParts};
pub use pixel_rect::PixelRect;
pub use plan::{
    CAP_CLEARANCE_PX, DrawnAs, FramePlan, GLOBAL_HEIGHT_M, LeftOutRegion, PartCulling, PlacedMesh,
    PlanOptions, PlanView, PlannedRegion, SmallRings, WallHeights,
};
pub use region_set::{LazyParts, NoSuchRegion, RegionSet};
pub use scene_bounds::{RegionBounds, SceneBounds};
