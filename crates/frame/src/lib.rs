// SPDX-License-Identifier: MIT OR Apache-2.0
//! The contract between scenes and backends: what goes in, what comes out, what may fail.
//!
//! A backend gets a [`FrameInput`] and gives a [`Frame`]. It may read anything in the input, and
//! nothing else: then "same input" means the same bytes, and a difference in the output is the
//! backend's own. The reference is a backend like the others, but judges from the parsed regions,
//! never from the meshes.

mod backend;
mod batches;
mod constants;
mod fixed_point;
mod frame;
mod input;
mod palette;
mod program;
mod switches;
mod texture;
mod textured;

pub use backend::{Backend, BackendError, Capabilities, Picture, TimedBackend, VolumeBackend};
pub use batches::{RegionClasses, XOR_NUMBERS, XorBatches, overlap_depth};
pub use constants::{RegionConstants, ViewConstants};
pub use fixed_point::{EyeInUnits, FixedPoint, PositionFormat, eye_relative_m};
pub use frame::{Counters, Frame, FrameTimes, MemoryUse, NO_REGION};
pub use input::{FrameInput, PreparedScene};
pub use palette::{MAX_REGIONS, id_rgba, ids_of, paint, palette_rgba, region_colour};
pub use program::{
    CoverShape, DepthRule, FaceSet, FillCommand, FillPass, FillProgram, StencilOperation,
    StencilRule, StencilTest,
};
pub use switches::{
    BottomCap, ColourWay, DepthRuleChoice, FacePasses, StencilClear, SwitchError, Switches,
};
pub use texture::{AddressMode, Pattern, PlannedTexture, TextureCoordinates, TexturePixel};
pub use textured::{RouteChoice, RouteNote, TexturedCover, TexturedPlan, TexturedRegion};
