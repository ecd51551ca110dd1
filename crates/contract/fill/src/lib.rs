// SPDX-License-Identifier: MIT OR Apache-2.0
//! The contract between scenes and backends: what goes in, what comes out, what may fail.
//!
//! A backend gets a [`FillInput`] and gives a [`Frame`]. It may read anything in the input, and
//! nothing else: then "same input" means the same bytes, and a difference in the output is the
//! backend's own. Backends are opened by techniques ([`Technique`]), which say what there is to
//! measure. The reference is none: it judges from the parsed regions, never from the meshes.

mod adapter;
mod backend;
mod batches;
mod bottom_caps;
mod clock;
mod constants;
mod cover_instances;
mod cover_tiles;
mod depth_range;
mod devices;
mod drawn_parts;
mod error;
mod executor;
mod fingerprint;
mod fixed_point;
mod footprint;
mod frame;
mod geometry;
mod held_meshes;
mod identity;
mod input;
mod ladder;
mod laid_out;
mod matrix;
mod needs;
mod needs_ladder;
mod palette;
mod picture;
mod program;
mod route_choice;
mod scene_bounds;
mod steps;
mod surface_view;
mod switch;
mod switches;
mod targets;
mod technique;
mod texture;
mod textured;
mod textured_device;
mod textured_work;
mod uses;
mod variant;
mod volume_backend;
mod volumes;
mod work;

pub use adapter::{
    DeviceFacts, DeviceType, SKY, THIS_MACHINE, check_target_size, choose_adapter, count_u32,
    device_for_test,
};
pub use backend::{Capabilities, FillBackend, Uploaded};
pub use batches::{VolumeClasses, XOR_NUMBERS, XorBatches, overlap_depth};
pub use bottom_caps::BottomCaps;
pub use clock::CpuStopwatch;
pub use constants::{
    FootprintConstants, ViewConstants, VolumeConstants, VolumePlace, changed_words,
};
pub use cover_instances::CoverInstance;
pub use depth_range::DepthRange;
pub use devices::{DeviceLoss, Devices};
pub use drawn_parts::{DrawnOfMeshes, DrawnParts, WallIndices};
pub use error::DeviceError;
pub use executor::{StencilExecutor, StencilWork};
pub use fingerprint::{ids_hash, mask_hash};
pub use fixed_point::{
    EyeInUnits, FixedPoint, PositionFormat, eye_relative_m, two_float, two_float_difference_m,
};
pub use frame::{Counters, Frame, FrameTimes, MemoryUse};
pub use geometry::{GeometryBytes, IndexLists, boundary_edges};
pub use identity::{NoSuchRegion, RegionSet, ViewId};
pub use input::{FillInput, LazyParts, PreparedScene};
pub use ladder::{Climb, LOD_PX, Rung};
pub use laid_out::LaidOut;
pub use matrix::matrix_row;
pub use needs::{COLOUR_BYTES, DEPTH_STENCIL_BYTES, Feature, Holding, Need, Needs};
pub use needs_ladder::needs_ladder;
pub use palette::{Colours, paint, region_colour};
pub use picture::{MAX_REGIONS, NO_REGION, Picture, ids_of};
pub use program::{
    CoverShape, DepthRule, FaceEffect, FaceSet, FillCommand, FillPass, FillProgram,
    StencilOperation, StencilRule, StencilTest,
};
pub use route_choice::RouteChoice;
pub use scene_bounds::SceneBounds;
pub use steps::{FillStep, NUMBER_BYTES, VolumeDraw, VolumeState};
pub use surface_view::{SurfaceLook, SurfaceView};
pub use switch::{Switch, SwitchError, Values, pick};
pub use switches::{
    BottomCap, ColourWay, CoverArea, DepthRuleChoice, FacePasses, FirstPass, StencilClear, Switches,
};
pub use targets::{Api, SurfaceInterface, SurfaceTargets, Targets};
pub use technique::{Role, Technique, layouts};
pub use texture::{AddressMode, Pattern, PlannedTexture, TextureCoordinates, TexturePixel};
pub use textured::{
    CoverLook, CoverOverrides, CoverPurpose, RouteNote, TexturedCover, TexturedPlan, TexturedRegion,
};
pub use textured_device::{Probed, RouteTexelFormat, RouteTexels, textured_holdings};
pub use variant::{Parameter, Variant};
pub use volume_backend::{RegionVolumes, VolumeBackend};
pub use volumes::{Volume, VolumeList};
pub use work::{WorkCounters, WorkDone};
