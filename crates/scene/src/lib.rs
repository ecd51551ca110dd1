// SPDX-License-Identifier: MIT OR Apache-2.0
//! Scenes: body, regions, surface and cameras, read from TOML and checked once; and the plan of
//! what a frame of a scene draws and leaves out.

mod camera;
mod plan;
mod scene;
mod surface;

pub use camera::{Camera, CameraPose, ImageSize};
pub use plan::{
    CAP_CLEARANCE_PX, FramePlan, LeftOutReason, LeftOutRegion, PixelRect, PlanOptions,
    PlannedRegion, TerrainRange,
};
pub use scene::{Overlap, Scene, View};
pub use surface::SurfaceMesh;
