// SPDX-License-Identifier: MIT OR Apache-2.0
//! Fills by volumes, on whatever interface: the engine between techniques that make volumes and devices that draw
//! them.
//!
//! A [`FillProgram`] says in which order volumes mark the stencil and covers colour what is marked. A device runs it
//! ([`StencilExecutor`]); a technique says how meshes become volumes ([`RegionVolumes`]); [`VolumeBackend`] is the
//! backend that the two make together. A program takes a list of volumes and does not know what a region is, so
//! shadows of objects are drawn by it too.

mod ablation;
mod batches;
mod constants;
mod cover_instances;
mod cover_tiles;
mod drawn_parts;
mod executor;
mod fixed_point;
mod footprint;
mod held_meshes;
mod index_lists;
mod laid_out;
mod matrix;
mod needs;
mod needs_ablation;
mod program;
mod steps;
mod textured;
mod textured_device;
mod textured_work;
mod uses;
mod volume_backend;
mod volumes;

pub use ablation::{AblationBuilder, LOD_PX};
pub use constants::{FootprintConstants, VolumeConstants, VolumePlace, changed_words};
pub use cover_instances::CoverInstance;
pub use drawn_parts::{DrawnOfMeshes, DrawnParts, WallIndices};
pub use executor::{StencilExecutor, StencilWork};
pub use fixed_point::{
    EyeInUnits, FixedPoint, PositionFormat, eye_relative_m, two_float, two_float_difference_m,
};
pub use held_meshes::HeldMeshes;
pub use index_lists::IndexLists;
pub use laid_out::LaidOut;
pub use matrix::matrix_row;
pub use needs::{COLOUR_BYTES, DEPTH_STENCIL_BYTES, Holding, IndexBytes};
pub use needs_ablation::needs_ablation;
pub use program::{
    CoverShape, DepthRule, FaceEffect, FaceSet, FillCommand, FillPass, FillProgram,
    StencilOperation, StencilRule, StencilTest,
};
pub use steps::{CoverDraw, FillStep, NUMBER_BYTES, VolumeDraw, VolumeState};
pub use textured::{
    CoverLook, CoverOverrides, CoverPurpose, RouteNote, TexturedCover, TexturedPlan, TexturedRegion,
};
pub use textured_device::{Probed, RouteTexelFormat, RouteTexels, textured_holdings};
pub use volume_backend::{RegionVolumes, VolumeBackend};
pub use volumes::{DepthRange, Volume, VolumeList};
