// SPDX-License-Identifier: MIT OR Apache-2.0
//! The contract between scenes and backends: what goes in, what comes out, what may fail.
//!
//! A backend gets a [`FillInput`] and gives a [`Frame`]. It may read anything in the input, and
//! nothing else: then "same input" means the same bytes, and a difference in the output is the
//! backend's own. Backends are opened by techniques ([`Technique`]), which say what there is to
//! measure. The reference is none: it judges from the parsed regions, never from the meshes.
//!
//! How volumes mark the stencil is no part of it: that is `terrafill-stencil`, which techniques of other kinds
//! never meet.

mod adapter;
mod backend;
mod clock;
mod devices;
mod error;
mod fingerprint;
mod frame;
mod identity;
mod input;
mod needs;
mod palette;
mod picture;
mod surface_renderer;
mod surface_view;
mod targets;
mod technique;
mod texture;
mod validation;
mod work;

pub use adapter::{
    DeviceFacts, DeviceType, SKY, THIS_MACHINE, check_target_size, choose_adapter, count_u32,
    device_for_test,
};
pub use backend::{FillBackend, Uploaded};
pub use clock::CpuStopwatch;
pub use devices::{DeviceLoss, DeviceOptions, Devices};
pub use error::DeviceError;
pub use fingerprint::{ids_hash, mask_hash, numbers_hash};
pub use frame::{Counters, Frame, FrameTimes, GeometryBytes, MemoryUse};
pub use identity::ViewId;
pub use input::{FillInput, PreparedScene};
pub use needs::{Feature, Need, Needs};
pub use palette::{Colours, paint, region_colour};
pub use picture::{NO_REGION, Picture, ids_of};
pub use surface_renderer::{SurfaceDevice, SurfaceDraw, SurfaceTriangles};
pub use surface_view::{SurfaceLook, SurfaceView, ViewConstants};
pub use targets::{Api, SurfaceInterface, SurfaceTargets, Targets};
pub use technique::{OpenedBackend, PlannedStep, Role, Technique, layouts};
pub use texture::{AddressMode, Pattern, PlannedTexture, TextureCoordinates, TexturePixel};
pub use validation::{POSITIVE_CONTROL, ValidationLog, ValidationMessage};
pub use work::{WorkCounters, WorkDone};
