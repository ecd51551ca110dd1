// SPDX-License-Identifier: MIT OR Apache-2.0
//! What runs stencil programs on a device: the promise of each device crate.
//!
//! An executor runs a [`FillProgram`] over a [`VolumeList`], on top of a surface. It knows where
//! volumes are seen and what their covers read; what they are made of is left to `V`, the device
//! crate's own trait of volumes. Regions stay with [`crate::VolumeBackend`].

use crate::{FillProgram, Holding, Probed, TexturedPlan, VolumeList};
use std::cell::RefCell;
use terrafill_contract::{
    Counters, DeviceError, Feature, FrameTimes, SurfaceTargets, ViewId, WorkDone,
};
use terrafill_scene::MipChain;
use terrafill_variant::Switches;

/// A stencil program and what it runs on.
#[derive(Debug, Clone, PartialEq)]
pub struct StencilWork {
    /// What is drawn.
    pub list: VolumeList,
    /// How.
    pub program: FillProgram,
    /// What shaders read of each volume, one after the other; not empty, even for an empty list.
    /// Covers and volumes in colour read [`crate::VolumeConstants::colour`].
    pub constants: Vec<u8>,
    /// Colours are blended over what lies under them.
    pub blends: bool,
}

impl StencilWork {
    /// What the buffer of the constants is held for; with no volumes, what is in it only fills a binding.
    ///
    /// - `buffer_bytes`: of the buffer itself
    #[must_use]
    pub fn constants_held(&self, buffer_bytes: u64) -> Holding {
        let constant_bytes = if self.list.volumes.is_empty() {
            0
        } else {
            self.constants.len() as u64
        };
        Holding::constants(Feature::RegionConstants, constant_bytes, buffer_bytes)
    }
}

/// Runs stencil programs over volumes of type `V`.
///
/// The order is `prepare` of the targets, `load`, `ensure`, `draw_surface` of the targets, then any number of
/// frames.
pub trait StencilExecutor<V>: Sized {
    /// Where it draws; several executors may share them.
    type Targets;

    /// An executor without a program.
    ///
    /// # Errors
    /// [`DeviceError::Unsupported`] when device or interface lack what the switches need;
    /// [`DeviceError::Shader`].
    fn new(targets: &Self::Targets, switches: &Switches) -> Result<Self, DeviceError>;

    /// Adapter and driver that it runs on.
    fn adapter(&self) -> String;

    /// What the device has made and written so far.
    fn work_done(&self) -> WorkDone;

    /// Where it draws: the view is prepared there, and the surface drawn.
    fn targets(&self) -> &RefCell<dyn SurfaceTargets>;

    /// Whether the targets hold the surface of this view.
    fn holds_surface(&self, view: ViewId) -> bool;

    /// Replaces the program and what it runs on. Buffers are made only where sizes differ, and
    /// written only where bytes do.
    ///
    /// # Errors
    /// [`DeviceError::OverCapacity`], [`DeviceError::OutOfMemory`]; [`DeviceError::Unsupported`]
    /// when the device cannot draw the program. None is loaded then.
    fn load(&mut self, work: StencilWork) -> Result<(), DeviceError>;

    /// Uploads `copies` of a picture for textured covers, in place of those there were.
    ///
    /// # Errors
    /// [`DeviceError::OverCapacity`], [`DeviceError::OutOfMemory`].
    fn set_picture(&mut self, picture: &MipChain, copies: usize) -> Result<(), DeviceError>;

    /// From the next [`StencilExecutor::load`] on, covers show the picture as planned: one cover
    /// for each volume.
    ///
    /// # Errors
    /// [`DeviceError::Missing`] before there is a picture; [`DeviceError::Shader`],
    /// [`DeviceError::OverCapacity`], [`DeviceError::Unsupported`].
    fn set_covers(&mut self, plan: &TexturedPlan) -> Result<(), DeviceError>;

    /// Makes the pipelines of the program unless they are there.
    ///
    /// # Errors
    /// [`DeviceError::Missing`], [`DeviceError::Unsupported`], [`DeviceError::Shader`].
    fn ensure(&mut self, volumes: &mut V) -> Result<(), DeviceError>;

    /// Runs the program once on top of the surface, and counts what it draws.
    ///
    /// # Errors
    /// [`DeviceError::Missing`], [`DeviceError::DeviceLost`].
    fn draw(&mut self, volumes: &mut V) -> Result<Counters, DeviceError>;

    /// Runs the program once on top of the surface, and measures how long that takes.
    ///
    /// # Errors
    /// As [`StencilExecutor::draw`].
    fn time(&mut self, volumes: &mut V) -> Result<FrameTimes, DeviceError>;

    /// Runs the program once with covers that write where their texels come from.
    ///
    /// # Errors
    /// As [`StencilExecutor::draw`], and [`DeviceError::Missing`] where covers have no picture.
    fn probe(&mut self, volumes: &mut V) -> Result<Vec<Option<Probed>>, DeviceError>;

    /// How many fragments the volumes of the stencil work have, by an extra pass that is never timed
    /// and draws into nothing. So fragments count whether or not the depth test lets them
    /// through. `None` where the device cannot count them. Volumes that are made per frame are those
    /// of the frame before.
    ///
    /// # Errors
    /// As [`StencilExecutor::draw`].
    fn count_fragments(&mut self, volumes: &mut V) -> Result<Option<u64>, DeviceError>;

    /// What it holds, the buffer of [`StencilWork::constants`] included.
    fn holdings(&self) -> Vec<Holding>;
}
