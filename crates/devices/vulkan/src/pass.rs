// SPDX-License-Identifier: MIT OR Apache-2.0
//! Records the passes of a fill.
//!
//! A draw names everything that it uses. What is bound already is not bound again; what does not
//! fit is not recorded, and the fill fails with the reason of the first such draw.

use crate::pipeline::PassTarget;
use crate::queries::Queries;
use crate::targets::{Numbers, Targets};
use crate::{
    BindGroup, Buffer, BufferUse, DepthBindings, DepthCopy, Gpu, ImageBindings, Pipeline,
    PipelineState, Probe, TexturedPipeline, VertexFormat,
};
use ash::vk;
use bytemuck::{Pod, Zeroable};
use std::ops::Range;
use std::sync::Arc;
use terrafill_contract::DeviceError;
use terrafill_plan::PixelRect;
use terrafill_stencil::CoverInstance;

/// Width of an index.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum IndexWidth {
    /// 16 bits.
    Short,
    /// 32 bits.
    Long,
}

impl IndexWidth {
    /// Bytes of an index.
    #[must_use]
    pub fn bytes(self) -> u64 {
        match self {
            Self::Short => 2,
            Self::Long => 4,
        }
    }

    pub(crate) fn vulkan(self) -> vk::IndexType {
        match self {
            Self::Short => vk::IndexType::UINT16,
            Self::Long => vk::IndexType::UINT32,
        }
    }
}

/// An indexed draw as a buffer of commands holds it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Pod, Zeroable)]
#[repr(C)]
pub struct DrawCommand {
    /// How many.
    pub index_count: u32,
    /// Of the same.
    pub instance_count: u32,
    /// The first one.
    pub first_index: u32,
    /// Added to each index.
    pub vertex_offset: i32,
    /// Number of the first instance.
    pub first_instance: u32,
}

impl DrawCommand {
    /// Bytes from one to the next.
    #[allow(clippy::cast_possible_truncation, reason = "20 bytes")]
    pub const STRIDE: u32 = size_of::<Self>() as u32;

    /// One instance of nothing.
    pub const ONE: Self = Self {
        index_count: 0,
        instance_count: 1,
        first_index: 0,
        vertex_offset: 0,
        first_instance: 0,
    };
}

/// Vertices and indices of a draw.
#[derive(Debug, Clone, Copy)]
pub struct Geometry<'a> {
    /// Vertices.
    pub vertices: &'a Buffer,
    /// Indices.
    pub indices: &'a Buffer,
    /// Their width.
    pub width: IndexWidth,
}

/// What a draw uses.
#[derive(Debug, Clone, Copy)]
pub struct DrawState<'a> {
    /// Shaders and tests.
    pub pipeline: &'a Pipeline,
    /// Constants.
    pub bindings: &'a BindGroup,
    /// Vertices, unless the shader needs none.
    pub geometry: Option<Geometry<'a>>,
}

/// What the draw of a textured cover uses.
#[derive(Debug, Clone, Copy)]
pub struct CoverState<'a> {
    /// Shaders and tests.
    pub pipeline: &'a TexturedPipeline,
    /// Constants of the view.
    pub bindings: &'a BindGroup,
    /// The surface's depth and the regions' constants.
    pub depth: &'a DepthBindings,
    /// The picture.
    pub picture: &'a ImageBindings,
    /// The table of the route, if it reads one.
    pub table: Option<&'a ImageBindings>,
}

/// Records the passes of one fill. Whatever is drawn with outlives `'a`, and thereby the fill.
pub struct FillRecorder<'a> {
    gpu: &'a Arc<Gpu>,
    targets: &'a Targets,
    commands: vk::CommandBuffer,
    /// Statistics or samples, one query a pass: pool, flags and number.
    counted: Option<(vk::QueryPool, vk::QueryControlFlags, u32)>,
    /// Stamps: start, end of the first pass, end of all.
    stamps: Option<vk::QueryPool>,
    /// Accumulated in this fill.
    numbers: Option<&'a Numbers>,
    /// Of the probe that was cleared in this fill.
    probed: vk::Framebuffer,
    passes: u32,
    refused: Option<DeviceError>,
}

/// Records the draws of one pass.
pub struct PassRecorder<'a, 'r> {
    fill: &'r mut FillRecorder<'a>,
    target: PassTarget,
    bound: Bound,
    bounds_set: bool,
    is_at_sky: bool,
}

/// Handles bound now.
#[derive(Default)]
struct Bound {
    pipeline: vk::Pipeline,
    set: vk::DescriptorSet,
    vertices: vk::Buffer,
    indices: vk::Buffer,
    scissor: Option<PixelRect>,
    /// Of textured covers: set 1 with the region's offset, and sets 2 and 3.
    region: Option<(vk::DescriptorSet, u32)>,
    images: [vk::DescriptorSet; 2],
}

impl<'a> FillRecorder<'a> {
    pub(crate) fn new(
        gpu: &'a Arc<Gpu>,
        targets: &'a Targets,
        counted: Option<&Queries>,
        stamps: Option<&Queries>,
    ) -> Self {
        Self {
            gpu,
            targets,
            commands: vk::CommandBuffer::null(),
            counted: counted.map(|queries| (queries.pool.raw, queries.flags(), queries.count)),
            stamps: stamps.map(|queries| queries.pool.raw),
            numbers: None,
            probed: vk::Framebuffer::null(),
            passes: 0,
            refused: None,
        }
    }

    /// Takes the command buffer that recording goes to.
    pub(crate) fn begin(&mut self, commands: vk::CommandBuffer) {
        self.commands = commands;
        let device = &self.gpu.device;
        // SAFETY: recording is under way; the pools are this device's and of these sizes.
        unsafe {
            if let Some((pool, _, count)) = self.counted {
                device.cmd_reset_query_pool(commands, pool, 0, count);
            }
            if let Some(stamps) = self.stamps {
                device.cmd_reset_query_pool(commands, stamps, 0, 3);
            }
        }
        self.stamp(vk::PipelineStageFlags::TOP_OF_PIPE, 0);
    }

    /// The last stamps.
    pub(crate) fn end(&mut self) {
        if self.passes == 0 {
            self.stamp(vk::PipelineStageFlags::BOTTOM_OF_PIPE, 1);
        }
        self.stamp(vk::PipelineStageFlags::BOTTOM_OF_PIPE, 2);
    }

    fn stamp(&self, stage: vk::PipelineStageFlags, query: u32) {
        if let Some(stamps) = self.stamps {
            let device = &self.gpu.device;
            // SAFETY: recording is under way, outside of a pass; the query was reset.
            unsafe { device.cmd_write_timestamp(self.commands, stage, stamps, query) };
        }
    }

    /// Number of passes, or why a draw could not be recorded.
    pub(crate) fn finish(self) -> Result<u32, DeviceError> {
        self.refused.map_or(Ok(self.passes), Err)
    }

    /// One pass over the targets' targets, depth read-only.
    pub fn pass(
        &mut self,
        clears_stencil: bool,
        has_colour: bool,
        record: impl FnOnce(&mut PassRecorder<'a, '_>),
    ) {
        let target = if has_colour {
            PassTarget::Colour
        } else {
            PassTarget::Stencil
        };
        let render_pass = self.gpu.fixtures.fill(clears_stencil, has_colour);
        let framebuffer = self.targets.framebuffer(has_colour);
        self.run(target, render_pass, framebuffer, record);
    }

    /// Copies depth as the surface left it, before the first pass.
    pub fn copy_depth(&mut self, copy: &'a DepthCopy) {
        if !self.targets.has(&copy.depth) {
            self.refuse("drawing: a copy of other targets' depth");
            return;
        }
        // SAFETY: recording is under way, outside of a pass; the surface or a fill has left depth as passes
        // leave it, and both images outlive the fill.
        unsafe { copy.record(self.commands) };
    }

    fn refuse(&mut self, what: &str) {
        self.refused.get_or_insert(self.gpu.lacks(what));
    }

    /// One pass over accumulated numbers, which it clears, depth read-only.
    pub fn accumulate(
        &mut self,
        numbers: &'a Numbers,
        record: impl FnOnce(&mut PassRecorder<'a, '_>),
    ) {
        if !self.targets.has(&numbers.depth) {
            self.refuse("drawing: numbers beside other targets");
            return;
        }
        let render_pass = self.gpu.fixtures.numbers;
        self.run(
            PassTarget::Numbers,
            render_pass,
            numbers.framebuffer.raw,
            record,
        );
        self.numbers = Some(numbers);
    }

    /// One pass over the targets' targets for textured covers, which writes neither depth nor stencil.
    pub fn textured(&mut self, record: impl FnOnce(&mut PassRecorder<'a, '_>)) {
        let render_pass = self.gpu.fixtures.textured;
        let framebuffer = self.targets.textured_framebuffer();
        self.run(PassTarget::Textured, render_pass, framebuffer, record);
    }

    /// One pass over the probe's targets in place of one over the targets'; the first clears them.
    pub fn probe(&mut self, probe: &'a Probe, record: impl FnOnce(&mut PassRecorder<'a, '_>)) {
        if !self.targets.has(&probe.depth) {
            self.refuse("drawing: a probe of other targets");
            return;
        }
        let render_pass = self
            .gpu
            .fixtures
            .probe(self.probed != probe.framebuffer.raw);
        self.run(
            PassTarget::Probe,
            render_pass,
            probe.framebuffer.raw,
            record,
        );
        self.probed = probe.framebuffer.raw;
        probe.is_drawn.set(true);
    }

    fn run(
        &mut self,
        target: PassTarget,
        render_pass: vk::RenderPass,
        framebuffer: vk::Framebuffer,
        record: impl FnOnce(&mut PassRecorder<'a, '_>),
    ) {
        let device = &self.gpu.device;
        let query = self.counted.filter(|(_, _, count)| self.passes < *count);
        // All bits 0, whatever an attachment is.
        let clears = [vk::ClearValue::default(); 3];
        let begin = vk::RenderPassBeginInfo::default()
            .render_pass(render_pass)
            .framebuffer(framebuffer)
            .render_area(self.targets.area())
            .clear_values(&clears);
        // SAFETY: recording is under way (the targets begin it), framebuffer and pass are
        // compatible, and no pass is open: passes are closed below.
        unsafe {
            if let Some((pool, flags, _)) = query {
                device.cmd_begin_query(self.commands, pool, self.passes, flags);
            }
            device.cmd_begin_render_pass(self.commands, &begin, vk::SubpassContents::INLINE);
            device.cmd_set_viewport(self.commands, 0, &[self.targets.viewport()]);
        }
        let mut pass = PassRecorder {
            fill: self,
            target,
            bound: Bound::default(),
            bounds_set: false,
            is_at_sky: false,
        };
        record(&mut pass);
        let device = &self.gpu.device;
        // SAFETY: closes what was opened above.
        unsafe {
            device.cmd_end_render_pass(self.commands);
            if let Some((pool, _, _)) = query {
                device.cmd_end_query(self.commands, pool, self.passes);
            }
        }
        if self.passes == 0 {
            self.stamp(vk::PipelineStageFlags::BOTTOM_OF_PIPE, 1);
        }
        self.passes += 1;
    }
}

impl<'a> PassRecorder<'a, '_> {
    /// Cuts the following draws to `rect`, as far as it lies in the image.
    pub fn scissor(&mut self, rect: PixelRect) {
        if self.bound.scissor == Some(rect) {
            return;
        }
        let full = self.fill.targets.area().extent;
        let left = rect.left.min(full.width);
        let top = rect.top.min(full.height);
        let scissor = vk::Rect2D {
            offset: vk::Offset2D {
                x: i32::try_from(left).unwrap_or(i32::MAX),
                y: i32::try_from(top).unwrap_or(i32::MAX),
            },
            extent: vk::Extent2D {
                width: rect.right.clamp(left, full.width) - left,
                height: rect.bottom.clamp(top, full.height) - top,
            },
        };
        let device = &self.fill.gpu.device;
        // SAFETY: within a pass, inside its area.
        unsafe { device.cmd_set_scissor(self.fill.commands, 0, &[scissor]) };
        self.bound.scissor = Some(rect);
    }

    /// Gives all fragments of the following draws the sky's depth, 0, or with `is_at_sky` off their own.
    pub fn at_sky(&mut self, is_at_sky: bool) {
        if is_at_sky == self.is_at_sky {
            return;
        }
        let mut viewport = self.fill.targets.viewport();
        if is_at_sky {
            viewport.max_depth = viewport.min_depth;
        }
        let device = &self.fill.gpu.device;
        // SAFETY: within a pass; depths of a viewport may be equal.
        unsafe { device.cmd_set_viewport(self.fill.commands, 0, &[viewport]) };
        self.is_at_sky = is_at_sky;
    }

    /// Drops fragments of the following draws where the surface's depth is outside `low..=high`;
    /// for pipelines that test depth bounds.
    pub fn depth_bounds(&mut self, low: f32, high: f32) {
        if !(0.0..=1.0).contains(&low) || !(low..=1.0).contains(&high) {
            self.refuse("depth bounds that are not 0 ≤ low ≤ high ≤ 1");
            return;
        }
        let device = &self.fill.gpu.device;
        // SAFETY: within a pass; 0 ≤ low ≤ high ≤ 1.
        unsafe { device.cmd_set_depth_bounds(self.fill.commands, low, high) };
        self.bounds_set = true;
    }

    /// Draws `vertices` vertices that the shader makes up, as instance number `instance`.
    pub fn draw(&mut self, state: &DrawState<'a>, vertices: u32, instance: u32) {
        if self.bind(state) {
            let device = &self.fill.gpu.device;
            // SAFETY: all state is bound and fits.
            unsafe { device.cmd_draw(self.fill.commands, vertices, 1, 0, instance) };
        }
    }

    /// Draws `vertices` vertices for each of `instances`, which are read from `buffer`.
    pub fn draw_instances(
        &mut self,
        state: &DrawState<'a>,
        buffer: &'a Buffer,
        vertices: u32,
        instances: Range<u32>,
    ) {
        let end = u64::from(instances.end) * CoverInstance::STRIDE;
        if state.pipeline.descriptor.format != VertexFormat::Cover || end > buffer.size() {
            self.refuse("instances that are not there, or a pipeline that reads none");
            return;
        }
        if self.bind_state(state) && self.bind_vertices(buffer) {
            let (first, count) = (instances.start, instances.end - instances.start);
            let device = &self.fill.gpu.device;
            // SAFETY: all state is bound and fits, and the instances are there.
            unsafe { device.cmd_draw(self.fill.commands, vertices, count, 0, first) };
        }
    }

    /// Draws indices `first..first + count`, each plus `base_vertex`, as instance number
    /// `instance`.
    pub fn draw_indexed(
        &mut self,
        state: &DrawState<'a>,
        first: u32,
        count: u32,
        base_vertex: i32,
        instance: u32,
    ) {
        let Some(geometry) = &state.geometry else {
            self.refuse("an indexed draw without indices");
            return;
        };
        let end = (u64::from(first) + u64::from(count)) * geometry.width.bytes();
        let holds = self.holds("bytes of indices that a draw reads", end, geometry.indices);
        if holds && self.bind(state) {
            let device = &self.fill.gpu.device;
            // SAFETY: all state is bound and fits, and the indices are there; what they point at is
            // checked by the device (`robustBufferAccess`).
            unsafe {
                device.cmd_draw_indexed(self.fill.commands, count, 1, first, base_vertex, instance);
            }
        }
    }

    /// Draws what commands of `list` say, by number: each as an indexed draw of `state`.
    pub fn draw_listed(&mut self, state: &DrawState<'a>, list: &'a Buffer, numbers: Range<u32>) {
        let features = self.fill.gpu.facts.features;
        if state.geometry.is_none() || !features.draws_listed {
            self.refuse("listed draws without indices, or on a device that has none");
            return;
        }
        let end = u64::from(numbers.end) * u64::from(DrawCommand::STRIDE);
        if !self.holds("bytes of commands that a draw reads", end, list) || !self.bind(state) {
            return;
        }
        let gpu = self.fill.gpu;
        let most = gpu.limits.max_draw_indirect_count.max(1);
        let mut first = numbers.start;
        while first < numbers.end {
            let count = (numbers.end - first).min(most);
            let offset = u64::from(first) * u64::from(DrawCommand::STRIDE);
            // SAFETY: all state is bound and fits, the device has the feature and the commands are there; what
            // their indices point at is checked by the device (`robustBufferAccess`).
            unsafe {
                gpu.device.cmd_draw_indexed_indirect(
                    self.fill.commands,
                    list.raw,
                    offset,
                    count,
                    DrawCommand::STRIDE,
                );
            }
            first += count;
        }
    }

    /// Covers one planned region with a picture: a triangle over the screen.
    pub fn cover(&mut self, state: &CoverState<'a>, planned: usize) {
        if self.bind_cover(state, planned) {
            let device = &self.fill.gpu.device;
            // SAFETY: all state is bound and fits; the region's constants are bound at its offset.
            unsafe { device.cmd_draw(self.fill.commands, 3, 1, 0, 0) };
        }
    }

    fn bind_cover(&mut self, state: &CoverState<'a>, planned: usize) -> bool {
        let pipeline = state.pipeline;
        let wanted = if pipeline.is_probe {
            PassTarget::Probe
        } else {
            PassTarget::Textured
        };
        let gpu = self.fill.gpu;
        if !pipeline.owned.is_on(gpu) || wanted != self.target {
            return self
                .refuse("a textured cover of another device or made for another kind of pass");
        }
        let images_fit = state.picture.set.is_on(gpu)
            && state.picture.is_sampled()
            && state.table.is_none_or(|table| table.set.is_on(gpu))
            && pipeline.takes_table(state.table);
        if !images_fit || !self.fill.targets.has(&state.depth.depth) {
            return self.refuse("a picture, table or depth that a textured cover cannot read");
        }
        let Some(offset) = state.depth.offset(planned) else {
            return self.refuse("a textured cover of a region without constants");
        };
        self.ensure_scissor();
        let point = vk::PipelineBindPoint::GRAPHICS;
        let (device, commands) = (&gpu.device, self.fill.commands);
        if pipeline.owned.raw != self.bound.pipeline {
            // SAFETY: made on this device for a compatible pass.
            unsafe { device.cmd_bind_pipeline(commands, point, pipeline.owned.raw) };
            self.bound.pipeline = pipeline.owned.raw;
        }
        if state.bindings.set.raw != self.bound.set && !self.bind_constants(state.bindings) {
            return false;
        }
        let layout = pipeline.layout;
        let region = Some((state.depth.set.raw, offset));
        if self.bound.region != region {
            // SAFETY: of this device and of the layout that every textured cover has there; the
            // offset is one of a region inside the buffer.
            unsafe {
                let sets = [state.depth.set.raw];
                device.cmd_bind_descriptor_sets(commands, point, layout, 1, &sets, &[offset]);
            }
            self.bound.region = region;
        }
        let images = [Some(state.picture), state.table];
        for (number, (image, bound)) in (2..).zip(images.iter().zip(&mut self.bound.images)) {
            if let Some(image) = image.filter(|image| image.set.raw != *bound) {
                let sets = [image.set.raw];
                // SAFETY: of this device and of the layout that the pipeline has there.
                unsafe {
                    device.cmd_bind_descriptor_sets(commands, point, layout, number, &sets, &[]);
                }
                *bound = image.set.raw;
            }
        }
        true
    }

    /// False: what is refused is not drawn.
    fn refuse(&mut self, what: &str) -> bool {
        self.fill.refuse(&format!("drawing: {what}"));
        false
    }

    /// Whether a buffer has as many bytes as a draw reads of it.
    fn holds(&mut self, what: &str, end: u64, buffer: &Buffer) -> bool {
        let checked = DeviceError::check_capacity(what, end, buffer.size());
        let is_ok = checked.is_ok();
        self.fill.refused = self.fill.refused.take().or(checked.err());
        is_ok
    }

    /// Binds what is not bound yet; false when something does not fit.
    fn bind(&mut self, state: &DrawState<'a>) -> bool {
        if !self.bind_state(state) {
            return false;
        }
        match &state.geometry {
            Some(geometry) => self.bind_geometry(geometry),
            None if state.pipeline.descriptor.format != VertexFormat::Number => {
                self.refuse("a pipeline that reads vertices without any")
            }
            None => true,
        }
    }

    /// The same of pipeline and constants.
    fn bind_state(&mut self, state: &DrawState<'a>) -> bool {
        if state.pipeline.owned.raw != self.bound.pipeline && !self.bind_pipeline(state.pipeline) {
            return false;
        }
        if state.pipeline.descriptor.depth_bounds && !self.bounds_set {
            return self.refuse("depth bounds are tested and not set");
        }
        self.ensure_scissor();
        state.bindings.set.raw == self.bound.set || self.bind_constants(state.bindings)
    }

    /// The whole image, unless draws were cut to something.
    fn ensure_scissor(&mut self) {
        if self.bound.scissor.is_none() {
            let extent = self.fill.targets.area().extent;
            self.scissor(PixelRect {
                left: 0,
                top: 0,
                right: extent.width,
                bottom: extent.height,
            });
        }
    }

    fn bind_pipeline(&mut self, pipeline: &Pipeline) -> bool {
        let fits = pipeline.owned.is_on(self.fill.gpu)
            && !matches!(pipeline.descriptor.state, PipelineState::Surface(_))
            && pipeline.descriptor.state.target() == self.target
            && (self.fill.numbers.is_some() || !pipeline.reads_numbers());
        if !fits {
            return self.refuse("a pipeline of another device or made for another kind of pass");
        }
        if let (true, Some(numbers)) = (pipeline.reads_numbers(), self.fill.numbers) {
            // SAFETY: of the layout that every pipeline has; a pass of this fill has left the image
            // to be read.
            unsafe { self.bind_set(1, numbers.set.raw) };
        }
        let device = &self.fill.gpu.device;
        let point = vk::PipelineBindPoint::GRAPHICS;
        // SAFETY: made on this device for a compatible pass.
        unsafe { device.cmd_bind_pipeline(self.fill.commands, point, pipeline.owned.raw) };
        self.bound.pipeline = pipeline.owned.raw;
        true
    }

    fn bind_constants(&mut self, bindings: &BindGroup) -> bool {
        if !bindings.set.is_on(self.fill.gpu) || !bindings.has_regions {
            return self.refuse("constants of another device or without regions");
        }
        // SAFETY: of this device and of the layout that every pipeline here has.
        unsafe { self.bind_set(0, bindings.set.raw) };
        self.bound.set = bindings.set.raw;
        true
    }

    /// Binds a set under a number.
    ///
    /// # Safety
    /// The set is the device's, of the layout that every pipeline has there, and may be read.
    unsafe fn bind_set(&self, number: u32, set: vk::DescriptorSet) {
        let gpu = self.fill.gpu;
        // SAFETY: recording is under way; the rest is the caller's promise.
        unsafe {
            gpu.device.cmd_bind_descriptor_sets(
                self.fill.commands,
                vk::PipelineBindPoint::GRAPHICS,
                gpu.fixtures.pipeline_layout,
                number,
                &[set],
                &[],
            );
        }
    }

    /// Whether a buffer is this device's and made for a use.
    fn is_for(&self, buffer: &Buffer, use_for: BufferUse) -> bool {
        buffer.is_for(self.fill.gpu, use_for)
    }

    fn bind_vertices(&mut self, vertices: &'a Buffer) -> bool {
        if vertices.raw != self.bound.vertices {
            if !self.is_for(vertices, BufferUse::Vertex) {
                return self.refuse("vertices of another device or made for another use");
            }
            let device = &self.fill.gpu.device;
            let buffers = [vertices.raw];
            // SAFETY: a vertex buffer of this device.
            unsafe { device.cmd_bind_vertex_buffers(self.fill.commands, 0, &buffers, &[0]) };
            self.bound.vertices = vertices.raw;
        }
        true
    }

    fn bind_geometry(&mut self, geometry: &Geometry<'a>) -> bool {
        if !self.bind_vertices(geometry.vertices) {
            return false;
        }
        if geometry.indices.raw != self.bound.indices {
            if !self.is_for(geometry.indices, BufferUse::Index) {
                return self.refuse("indices of another device or made for another use");
            }
            let device = &self.fill.gpu.device;
            let kind = geometry.width.vulkan();
            // SAFETY: an index buffer of this device.
            unsafe {
                device.cmd_bind_index_buffer(self.fill.commands, geometry.indices.raw, 0, kind);
            }
            self.bound.indices = geometry.indices.raw;
        }
        true
    }
}
