// SPDX-License-Identifier: MIT OR Apache-2.0
//! Triangles over the screen that bring colours: covers of marked pixels, and the lookup of
//! accumulated numbers. The one place where they are made and bound.

use crate::{
    Buffer, BufferUse, Gpu, Pipeline, PipelineDescriptor, PipelineState, Topology, VertexFormat,
    VertexStage, VolumePass,
};
use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::ops::Range;
use std::sync::Arc;
use terrafill_contract::{DeviceError, Feature};
use terrafill_stencil::{CoverDraw, CoverInstance, FaceSet, Holding, StencilTest, VolumeState};

/// Corners of a rectangle, in a strip.
const CORNERS: u32 = 4;

/// Pipelines on one device, made when first asked for.
#[derive(Debug, Default)]
pub(crate) struct Covers {
    /// Those of one step are instances of one draw.
    are_merged: bool,
    made: HashMap<PipelineState, Pipeline>,
}

impl Covers {
    /// - `are_merged`: covers of one step are instances of one draw
    pub(crate) fn new(are_merged: bool) -> Self {
        Self {
            are_merged,
            ..Self::default()
        }
    }

    /// Makes a cover's pipeline unless it is there.
    pub(crate) fn ensure_cover(
        &mut self,
        gpu: &Arc<Gpu>,
        test: StencilTest,
    ) -> Result<(), DeviceError> {
        let state = cover(test);
        let path = "vertex/cover.wgsl";
        let descriptor = if self.are_merged {
            rectangles(path, state)
        } else {
            full_screen(path, state)
        };
        self.ensure(gpu, descriptor)
    }

    /// Makes the lookup's pipeline unless it is there.
    pub(crate) fn ensure_resolve(&mut self, gpu: &Arc<Gpu>) -> Result<(), DeviceError> {
        let descriptor = full_screen("vertex/resolve.wgsl", PipelineState::Resolve);
        self.ensure(gpu, descriptor)
    }

    fn ensure(
        &mut self,
        gpu: &Arc<Gpu>,
        descriptor: PipelineDescriptor,
    ) -> Result<(), DeviceError> {
        if let Entry::Vacant(place) = self.made.entry(descriptor.state) {
            place.insert(Pipeline::new(gpu, descriptor)?);
        }
        Ok(())
    }

    /// Its pipelines.
    pub(crate) fn holdings(&self) -> impl Iterator<Item = Holding> {
        Holding::pipelines(std::iter::repeat_n(Feature::Covers, self.made.len()))
    }

    /// Covers marked pixels in the colours of volumes, in this order.
    pub(crate) fn draw_covers<'a>(
        &'a self,
        pass: &mut VolumePass<'a, '_, '_>,
        draw: CoverDraw<'_>,
    ) {
        let Some(pipeline) = self.made.get(&cover(draw.test)) else {
            return;
        };
        pass.at_sky(draw.test.skips_sky);
        for &volume in draw.volumes {
            pass.cut(volume, draw.scissor);
            pass.draw(pipeline, 3, volume);
        }
    }

    /// Covers marked pixels by one draw of `range` among `list`.
    pub(crate) fn draw_merged<'a>(
        &'a self,
        pass: &mut VolumePass<'a, '_, '_>,
        test: StencilTest,
        list: &'a CoverList,
        range: Range<u32>,
    ) {
        if let Some(pipeline) = self.made.get(&cover(test)) {
            pass.at_sky(test.skips_sky);
            pass.cut(0, false);
            pass.draw_covers(pipeline, &list.buffer, CORNERS, range);
        }
    }

    /// Looks up the colours of accumulated numbers.
    pub(crate) fn draw_resolve<'a>(&'a self, pass: &mut VolumePass<'a, '_, '_>) {
        if let Some(pipeline) = self.made.get(&PipelineState::Resolve) {
            pass.at_sky(false);
            pass.cut(0, false);
            pass.draw(pipeline, 3, 0);
        }
    }
}

/// Covers of a program as instances.
#[derive(Debug)]
pub(crate) struct CoverList {
    buffer: Buffer,
    bytes: Vec<u8>,
}

impl CoverList {
    /// Those of `instances` in the buffer of `before`, where it has room for as many.
    ///
    /// # Errors
    /// [`DeviceError::OverCapacity`], [`DeviceError::OutOfMemory`].
    pub(crate) fn new(
        gpu: &Arc<Gpu>,
        instances: &[CoverInstance],
        before: Option<Self>,
    ) -> Result<Self, DeviceError> {
        let bytes: Vec<u8> = bytemuck::cast_slice(instances).to_vec();
        let buffer = match before {
            Some(before) if before.buffer.size() >= bytes.len() as u64 => {
                before.buffer.rewrite_changed(&before.bytes, &bytes)?;
                before.buffer
            }
            _ => Buffer::upload(
                gpu,
                "covers",
                &CoverInstance::bytes_with_room(instances),
                BufferUse::Vertex,
            )?,
        };
        Ok(Self { buffer, bytes })
    }

    pub(crate) fn holding(&self) -> Holding {
        Holding::constants(Feature::Covers, self.bytes.len() as u64, self.buffer.size())
    }
}

fn cover(test: StencilTest) -> PipelineState {
    PipelineState::Volumes(VolumeState::Colour {
        is_before_surface: false,
        test,
        faces: FaceSet::Both,
    })
}

/// The pipeline of one triangle over the screen.
fn full_screen(path: &'static str, state: PipelineState) -> PipelineDescriptor {
    PipelineDescriptor::of_shader(path, VertexFormat::Number, state)
}

/// The pipeline of rectangles, one for each [`CoverInstance`].
fn rectangles(path: &'static str, state: PipelineState) -> PipelineDescriptor {
    let triangle = full_screen(path, state);
    PipelineDescriptor {
        vertex: VertexStage {
            entry_point: "rectangle_main",
            ..triangle.vertex
        },
        format: VertexFormat::Cover,
        topology: Topology::Strips,
        ..triangle
    }
}
