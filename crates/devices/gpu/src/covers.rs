// SPDX-License-Identifier: MIT OR Apache-2.0
//! Triangles over the screen that bring colours: covers of marked pixels, and the lookup of
//! accumulated numbers. The one place where they are made and bound.

use crate::attachments::target;
use crate::render_pipeline::described;
use crate::volume_pipeline::{NUMBER_FORMAT, colour_state, colour_target, unchanged};
use crate::{Gpu, VolumePass};
use std::collections::HashMap;
use std::ops::Range;
use terrafill_contract::{DeviceError, Feature};
use terrafill_scene::ImageSize;
use terrafill_stencil::{CoverDraw, CoverInstance, Holding, NUMBER_BYTES, StencilTest};

/// Where covers that are instances are bound, behind whatever volumes bind.
const INSTANCES: u32 = 3;

/// Pipelines on one device, made when first asked for.
#[derive(Debug)]
pub(crate) struct Covers {
    /// Those of one step are instances of one draw.
    are_merged: bool,
    cover_shader: Option<wgpu::ShaderModule>,
    cover_layout: wgpu::PipelineLayout,
    /// By test, and whether they are blended over what lies under them.
    covers: HashMap<(StencilTest, bool), wgpu::RenderPipeline>,
    resolve_layout: wgpu::PipelineLayout,
    resolve: Option<wgpu::RenderPipeline>,
    number_layout: wgpu::BindGroupLayout,
}

impl Covers {
    /// - `frame_layout`: group 0, view and volumes' constants
    /// - `are_merged`: covers of one step are instances of one draw
    pub(crate) fn new(gpu: &Gpu, frame_layout: &wgpu::BindGroupLayout, are_merged: bool) -> Self {
        let number = wgpu::TextureSampleType::Float { filterable: false };
        let number_layout = gpu.texture_layout("accumulated numbers", number);
        let resolved = [Some(frame_layout), Some(&number_layout)];
        Self {
            are_merged,
            cover_shader: None,
            cover_layout: gpu.pipeline_layout("cover", &[Some(frame_layout)]),
            covers: HashMap::new(),
            resolve_layout: gpu.pipeline_layout("resolve", &resolved),
            resolve: None,
            number_layout,
        }
    }

    /// Makes a cover's pipeline unless it is there.
    pub(crate) fn ensure_cover(
        &mut self,
        gpu: &Gpu,
        test: StencilTest,
        blends: bool,
    ) -> Result<(), DeviceError> {
        let key = cover_key(test, blends);
        if self.covers.contains_key(&key) {
            return Ok(());
        }
        let shader = match self.cover_shader.take() {
            Some(shader) => shader,
            None => gpu.shader("vertex/cover.wgsl")?,
        };
        let (state, target) = (Some(colour_state(test)), colour_target(blends));
        let layout = &self.cover_layout;
        let made = if self.are_merged {
            rectangles(gpu, layout, &shader, state, target)
        } else {
            full_screen(gpu, "cover", layout, &shader, state, target)
        };
        self.covers.insert(key, made);
        self.cover_shader = Some(shader);
        Ok(())
    }

    /// Its pipelines.
    pub(crate) fn holdings(&self) -> impl Iterator<Item = Holding> {
        let pipelines = self.covers.len() + usize::from(self.resolve.is_some());
        Holding::pipelines(std::iter::repeat_n(Feature::Covers, pipelines))
    }

    /// Makes the lookup's pipeline unless it is there.
    pub(crate) fn ensure_resolve(&mut self, gpu: &Gpu) -> Result<(), DeviceError> {
        if self.resolve.is_none() {
            let shader = gpu.shader("vertex/resolve.wgsl")?;
            let state = Some(unchanged(wgpu::CompareFunction::Always));
            let target = colour_target(false);
            let layout = &self.resolve_layout;
            self.resolve = Some(full_screen(gpu, "resolve", layout, &shader, state, target));
        }
        Ok(())
    }

    /// Covers marked pixels in the colours of volumes, in this order.
    pub(crate) fn draw_covers(&self, pass: &mut VolumePass<'_>, draw: CoverDraw<'_>, blends: bool) {
        self.begin(pass, draw.test, blends);
        for &volume in draw.volumes {
            pass.cut(volume, draw.scissor);
            pass.draw(0..3, volume);
        }
    }

    /// Covers marked pixels by one draw of `range` among the instances that are bound.
    pub(crate) fn draw_merged(
        &self,
        pass: &mut VolumePass<'_>,
        test: StencilTest,
        blends: bool,
        range: Range<u32>,
    ) {
        self.begin(pass, test, blends);
        pass.cut(0, false);
        pass.draw_covers(4, range);
    }

    fn begin(&self, pass: &mut VolumePass<'_>, test: StencilTest, blends: bool) {
        if let Some(pipeline) = self.covers.get(&cover_key(test, blends)) {
            pass.raw.set_pipeline(pipeline);
        }
        pass.raw.set_stencil_reference(u32::from(test.reference));
        pass.at_sky(test.skips_sky);
    }

    /// Looks up the colours of accumulated numbers.
    pub(crate) fn draw_resolve(&self, pass: &mut VolumePass<'_>, numbers: &Numbers) {
        if let Some(pipeline) = &self.resolve {
            pass.raw.set_pipeline(pipeline);
        }
        pass.raw.set_bind_group(1, &numbers.bind_group, &[]);
        pass.at_sky(false);
        pass.cut(0, false);
        pass.draw(0..3, 0);
    }
}

/// The stencil reference is set by the pass: no pipeline differs in it alone.
fn cover_key(test: StencilTest, blends: bool) -> (StencilTest, bool) {
    let test = StencilTest {
        reference: 0,
        ..test
    };
    (test, blends)
}

/// Covers of a program as instances.
#[derive(Debug)]
pub(crate) struct CoverList {
    buffer: wgpu::Buffer,
    bytes: Vec<u8>,
}

impl CoverList {
    /// Those of `instances` in the buffer of `before`, where it has room for as many.
    ///
    /// # Errors
    /// [`DeviceError::OverCapacity`].
    pub(crate) fn new(
        gpu: &Gpu,
        instances: &[CoverInstance],
        before: Option<Self>,
    ) -> Result<Self, DeviceError> {
        let bytes: Vec<u8> = bytemuck::cast_slice(instances).to_vec();
        let buffer = match before {
            Some(before) if before.buffer.size() >= bytes.len() as u64 => {
                gpu.write_changed(&before.buffer, &before.bytes, &bytes);
                before.buffer
            }
            _ => gpu.upload(
                "covers",
                &CoverInstance::bytes_with_room(instances),
                wgpu::BufferUsages::VERTEX,
            )?,
        };
        Ok(Self { buffer, bytes })
    }

    pub(crate) fn bind(&self, pass: &mut wgpu::RenderPass<'_>) {
        pass.set_vertex_buffer(INSTANCES, self.buffer.slice(..));
    }

    pub(crate) fn holding(&self) -> Holding {
        Holding::constants(Feature::Covers, self.bytes.len() as u64, self.buffer.size())
    }
}

/// The accumulation target.
#[derive(Debug)]
pub(crate) struct Numbers {
    pub(crate) size: ImageSize,
    pub(crate) view: wgpu::TextureView,
    bind_group: wgpu::BindGroup,
}

impl Numbers {
    pub(crate) fn new(gpu: &Gpu, covers: &Covers, size: ImageSize) -> Self {
        let sampled = wgpu::TextureUsages::TEXTURE_BINDING;
        let texture = target(gpu, size, "accumulated numbers", NUMBER_FORMAT, sampled);
        gpu.work
            .count_texture(size.pixel_count() as u64 * NUMBER_BYTES);
        let view = texture.create_view(&Default::default());
        let layout = &covers.number_layout;
        let bind_group = gpu.bind_texture("accumulated numbers", layout, &view);
        Self {
            size,
            view,
            bind_group,
        }
    }

    pub(crate) fn bytes(&self) -> u64 {
        self.size.pixel_count() as u64 * NUMBER_BYTES
    }
}

/// A pipeline for one triangle over the screen, by the entry points `vertex_main` and `fragment_main`.
pub(crate) fn full_screen(
    gpu: &Gpu,
    label: &str,
    layout: &wgpu::PipelineLayout,
    shader: &wgpu::ShaderModule,
    depth_stencil: Option<wgpu::DepthStencilState>,
    target: wgpu::ColorTargetState,
) -> wgpu::RenderPipeline {
    let targets = [Some(target)];
    gpu.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        depth_stencil,
        ..described(label, layout, shader, &targets)
    })
}

/// A pipeline for rectangles of [`CoverInstance`].
fn rectangles(
    gpu: &Gpu,
    layout: &wgpu::PipelineLayout,
    shader: &wgpu::ShaderModule,
    depth_stencil: Option<wgpu::DepthStencilState>,
    target: wgpu::ColorTargetState,
) -> wgpu::RenderPipeline {
    let instances = [
        None,
        None,
        None,
        Some(wgpu::VertexBufferLayout {
            array_stride: CoverInstance::STRIDE,
            step_mode: wgpu::VertexStepMode::Instance,
            attributes: &wgpu::vertex_attr_array![0 => Float32x4, 1 => Uint32],
        }),
    ];
    let targets = [Some(target)];
    let mut described = described("covers", layout, shader, &targets);
    described.vertex.entry_point = Some("rectangle_main");
    described.vertex.buffers = &instances;
    described.primitive.topology = wgpu::PrimitiveTopology::TriangleStrip;
    described.depth_stencil = depth_stencil;
    gpu.create_render_pipeline(&described)
}
