// SPDX-License-Identifier: MIT OR Apache-2.0
//! The contract between scenes and backends: what goes in, what comes out, what may fail.
//!
//! A backend gets a [`FrameInput`] and gives a [`Frame`]. It may read anything in the input, and
//! nothing else: then "same input" means the same bytes, and a difference in the output is the
//! backend's own. The reference is a backend like the others, but judges from the parsed regions,
//! never from the meshes.

mod backend;
mod frame;
mod input;
mod palette;

pub use backend::{Backend, BackendError, Capabilities, TimedBackend};
pub use frame::{Counters, Frame, FrameTimes, MemoryUse, NO_REGION};
pub use input::{FrameInput, PreparedScene};
pub use palette::{paint, region_colour};
