// SPDX-License-Identifier: MIT OR Apache-2.0
//! Textured covers on wgpu: the picture on the device, its samplers, the constants of a view, and one
//! pipeline for each kind of cover that a scene needs.
//!
//! A textured cover stands where a plain one would: a triangle over the screen, cut by scissor and
//! stencil. It reads the depth that the surface left through a second view of the texture that is
//! attached. That is allowed while neither depth nor stencil is written. So no depth is copied, and
//! covers that take the stencil back to 0 cannot be textured.

use crate::picture::{bind_picture, bytes_of, picture_layout, upload_picture};
use crate::readback::read_texture;
use crate::render_pipeline::described;
use crate::route_table::RouteTable;
use crate::volume_pipeline::{colour_state, colour_target};
use crate::{Gpu, RenderTargets};
use std::collections::HashMap;
use terrafill_contract::{AddressMode, DeviceError};
use terrafill_scene::{ImageSize, MipChain};
use terrafill_shaders::{TEXTURED_COVER, TexturedParts};
use terrafill_stencil::{
    CoverLook, CoverPurpose, Holding, Probed, StencilTest, TexturedCover, TexturedPlan,
    textured_holdings,
};

/// Format of the probe's targets: what the shader computes, unrounded.
const PROBE_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba32Float;

#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
struct CoverKey {
    shader: usize,
    test: StencilTest,
    look: CoverLook,
}

/// Textured covers of one scene and view.
#[derive(Debug)]
pub struct TexturedFill {
    /// Groups 0, view; 1, depth and regions; 2, picture.
    bindings: [wgpu::BindGroupLayout; 3],
    shaders: Vec<Shader>,
    pipelines: HashMap<CoverKey, wgpu::RenderPipeline>,
    images: Vec<wgpu::Texture>,
    /// Whether the pictures hide what lies under them.
    images_are_opaque: bool,
    image_groups: HashMap<ImageKey, wgpu::BindGroup>,
    view: Option<TexturedView>,
}

/// A copy of the picture, and what is seen beyond it.
type ImageKey = (usize, [AddressMode; 2]);

/// A composed shader and what its route reads besides constants.
#[derive(Debug)]
struct Shader {
    parts: TexturedParts,
    module: wgpu::ShaderModule,
    layout: wgpu::PipelineLayout,
    table: Option<RouteTable>,
}

#[derive(Debug)]
struct TexturedView {
    constants: wgpu::Buffer,
    written: Vec<[f32; 4]>,
    /// Bytes from one region's constants to the next one's.
    stride: u32,
    bind_group: wgpu::BindGroup,
    /// By planned region, with the place of its shader in `TexturedFill::shaders`.
    covers: Vec<(TexturedCover, usize)>,
}

impl TexturedFill {
    /// Nothing uploaded and no pipeline made yet.
    ///
    /// - `frame_layout`: group 0, the view's constants at binding 0
    #[must_use]
    pub fn new(gpu: &Gpu, frame_layout: &wgpu::BindGroupLayout) -> Self {
        let group = |label, types: &[wgpu::BindingType]| gpu.fragment_layout(label, types);
        let texture = |sample_type| wgpu::BindingType::Texture {
            sample_type,
            view_dimension: wgpu::TextureViewDimension::D2,
            multisampled: false,
        };
        let regions = wgpu::BindingType::Buffer {
            ty: wgpu::BufferBindingType::Uniform,
            has_dynamic_offset: true,
            min_binding_size: None,
        };
        let depth = texture(wgpu::TextureSampleType::Depth);
        Self {
            bindings: [
                frame_layout.clone(),
                group("depth and textured regions", &[depth, regions]),
                picture_layout(gpu),
            ],
            shaders: Vec::new(),
            pipelines: HashMap::new(),
            images: Vec::new(),
            images_are_opaque: true,
            image_groups: HashMap::new(),
            view: None,
        }
    }

    /// Uploads `copies` of a picture with all its levels in place of those there were.
    ///
    /// # Errors
    /// [`DeviceError::OverCapacity`] when the device has no textures that large.
    pub fn upload_image(
        &mut self,
        gpu: &Gpu,
        image: &MipChain,
        copies: usize,
    ) -> Result<(), DeviceError> {
        let images = (0..copies).map(|_| upload_picture(gpu, image));
        let images = images.collect::<Result<Vec<_>, _>>()?;
        let texels = image.levels()[0].rgba.chunks_exact(4);
        self.images_are_opaque = texels.into_iter().all(|texel| texel[3] == u8::MAX);
        self.image_groups.clear();
        self.images = images;
        Ok(())
    }

    /// Pictures, constants, pipelines with their routes' tables, by what they are held for.
    #[must_use]
    pub fn holdings(&self) -> Vec<Holding> {
        let tables = self.shaders.iter().filter_map(|made| made.table.as_ref());
        textured_holdings(
            self.images.iter().map(bytes_of).sum(),
            tables.map(|table| table.bytes).sum(),
            self.pipelines.keys().map(|key| key.look),
            self.view
                .as_ref()
                .map(|view| [size_of_val(&*view.written) as u64, view.constants.size()]),
        )
    }

    /// Takes over a view: constants are written where they changed, shaders and bind groups made
    /// where they are missing.
    ///
    /// # Errors
    /// [`DeviceError::Shader`], [`DeviceError::OverCapacity`], and [`DeviceError::Unsupported`]
    /// for a route whose table the device cannot hold.
    pub fn set_view(
        &mut self,
        targets: &RenderTargets,
        plan: &TexturedPlan,
    ) -> Result<(), DeviceError> {
        let gpu = targets.gpu();
        let mut covers = Vec::with_capacity(plan.covers.len());
        for cover in &plan.covers {
            covers.push((cover.clone(), self.shader(gpu, plan, cover)?));
            self.ensure_image_group(gpu, (cover.texture.image, cover.texture.address));
        }
        let alignment = gpu.device.limits().min_uniform_buffer_offset_alignment;
        let (written, stride) = plan.aligned_constants(alignment as usize);
        let stride = u32::try_from(stride).unwrap_or(u32::MAX);
        let there = self.view.take();
        let (constants, bind_group) = match there {
            Some(view) if (view.written.len(), view.stride) == (written.len(), stride) => {
                if view.written != written {
                    gpu.write_buffer(&view.constants, 0, bytemuck::cast_slice(&written));
                }
                (view.constants, view.bind_group)
            }
            _ => {
                let bytes = bytemuck::cast_slice(&written);
                let usage = wgpu::BufferUsages::UNIFORM;
                let constants = gpu.upload("textured covers", bytes, usage)?;
                let bind_group = self.bind_constants(targets, &constants, stride);
                (constants, bind_group)
            }
        };
        self.view = Some(TexturedView {
            constants,
            written,
            stride,
            bind_group,
            covers,
        });
        Ok(())
    }

    /// Makes the pipelines that cover `regions` where they are missing.
    pub fn ensure(
        &mut self,
        gpu: &Gpu,
        test: StencilTest,
        purpose: CoverPurpose,
        regions: &[usize],
    ) {
        for &planned in regions {
            let Some((key, _)) = self.cover(test, purpose, planned) else {
                continue;
            };
            if !self.pipelines.contains_key(&key) {
                let pipeline = self.pipeline(gpu, key);
                self.pipelines.insert(key, pipeline);
            }
        }
    }

    /// Binds what covers one planned region with a triangle of three vertices; group 0 and the stencil reference are the caller's. What the pass has bound already stays: `bound`
    /// says what the last call left. False where [`TexturedFill::ensure`] was not called for it.
    pub fn bind(
        &self,
        pass: &mut wgpu::RenderPass<'_>,
        test: StencilTest,
        purpose: CoverPurpose,
        planned: usize,
        bound: &mut BoundCover,
    ) -> bool {
        let Some((key, cover)) = self.cover(test, purpose, planned) else {
            return false;
        };
        let image = (cover.texture.image, cover.texture.address);
        let found = self.pipelines.get(&key).zip(self.image_groups.get(&image));
        let (Some((pipeline, image_group)), Some(view)) = (found, &self.view) else {
            return false;
        };
        if bound.key != Some(key) {
            pass.set_pipeline(pipeline);
            if let Some(table) = &self.shaders[key.shader].table {
                pass.set_bind_group(3, &table.group, &[]);
            }
            bound.key = Some(key);
        }
        if bound.image != Some(image) {
            pass.set_bind_group(2, image_group, &[]);
            bound.image = Some(image);
        }
        if bound.planned != Some(planned) {
            let index = u32::try_from(planned).unwrap_or(u32::MAX);
            pass.set_bind_group(1, &view.bind_group, &[index.saturating_mul(view.stride)]);
            bound.planned = Some(planned);
        }
        true
    }

    fn cover(
        &self,
        test: StencilTest,
        purpose: CoverPurpose,
        planned: usize,
    ) -> Option<(CoverKey, &TexturedCover)> {
        let view = self.view.as_ref()?;
        let (cover, shader) = view.covers.get(planned)?;
        let key = CoverKey {
            shader: *shader,
            // Set by the pass: no pipeline differs in it alone.
            test: StencilTest {
                reference: 0,
                ..test
            },
            look: cover.look(purpose, self.images_are_opaque),
        };
        Some((key, cover))
    }

    fn shader(
        &mut self,
        gpu: &Gpu,
        plan: &TexturedPlan,
        cover: &TexturedCover,
    ) -> Result<usize, DeviceError> {
        let parts = parts(plan, cover);
        let there = self.shaders.iter().position(|made| made.parts == parts);
        if let Some(there) = there {
            return Ok(there);
        }
        let failed = |error: terrafill_shaders::ShaderError| DeviceError::Shader {
            name: format!("{TEXTURED_COVER} with {}", cover.route.name()),
            message: error.to_string(),
        };
        let composed = parts.compose().map_err(failed)?;
        // A route that does not compile is an error to report, not one to stop the device.
        terrafill_shaders::validate(TEXTURED_COVER, &composed).map_err(failed)?;
        let module = gpu
            .device
            .create_shader_module(wgpu::ShaderModuleDescriptor {
                label: Some(TEXTURED_COVER),
                source: wgpu::ShaderSource::Wgsl(composed.into()),
            });
        let texels = cover.route_texels();
        let stage = wgpu::ShaderStages::FRAGMENT;
        let table = texels.map(|texels| RouteTable::new(gpu, &texels, stage));
        let table = table.transpose()?;
        let groups: Vec<_> = self
            .bindings
            .iter()
            .chain(table.as_ref().map(|table| &table.layout))
            .map(Some)
            .collect();
        let layout = gpu.pipeline_layout("textured cover", &groups);
        self.shaders.push(Shader {
            parts,
            module,
            layout,
            table,
        });
        Ok(self.shaders.len() - 1)
    }

    fn ensure_image_group(&mut self, gpu: &Gpu, key: ImageKey) {
        let Some(image) = self.images.get(key.0) else {
            return;
        };
        if self.image_groups.contains_key(&key) {
            return;
        }
        let group = bind_picture(gpu, &self.bindings[2], image, key.1);
        self.image_groups.insert(key, group);
    }

    fn bind_constants(
        &self,
        targets: &RenderTargets,
        constants: &wgpu::Buffer,
        stride: u32,
    ) -> wgpu::BindGroup {
        let depth = targets.depth_view();
        let resources = [
            wgpu::BindingResource::TextureView(&depth),
            wgpu::BindingResource::Buffer(wgpu::BufferBinding {
                buffer: constants,
                offset: 0,
                size: std::num::NonZeroU64::new(u64::from(stride)),
            }),
        ];
        let label = "depth and textured regions";
        targets.gpu().bind(label, &self.bindings[1], resources)
    }

    fn pipeline(&self, gpu: &Gpu, key: CoverKey) -> wgpu::RenderPipeline {
        let Shader { module, layout, .. } = &self.shaders[key.shader];
        let targets = match key.look.purpose {
            CoverPurpose::Colour => vec![Some(colour_target(key.look.blends))],
            CoverPurpose::Probe => vec![Some(PROBE_FORMAT.into()); 2],
        };
        let constants = key.look.overrides.constants();
        let mut described = described("textured cover", layout, module, &targets);
        described.depth_stencil = Some(colour_state(key.test));
        if let Some(fragment) = &mut described.fragment {
            fragment.entry_point = Some(key.look.entry_point());
            fragment.compilation_options.constants = &constants;
        }
        gpu.create_render_pipeline(&described)
    }
}

/// What the last cover of a pass left bound.
#[derive(Debug, Default)]
pub struct BoundCover {
    key: Option<CoverKey>,
    image: Option<ImageKey>,
    planned: Option<usize>,
}

/// Targets of the covers' probe.
#[derive(Debug)]
pub struct Probe {
    textures: [wgpu::Texture; 2],
}

impl Probe {
    /// Targets as large as the image.
    #[must_use]
    pub fn new(gpu: &Gpu, size: ImageSize) -> Self {
        let target = |label| {
            let usage = wgpu::TextureUsages::COPY_SRC;
            crate::attachments::target(gpu, size, label, PROBE_FORMAT, usage)
        };
        Self {
            textures: [target("probed places"), target("probed sizes")],
        }
    }

    /// The targets, in the order of the shader's locations.
    #[must_use]
    pub fn views(&self) -> [wgpu::TextureView; 2] {
        [0, 1].map(|i| self.textures[i].create_view(&Default::default()))
    }

    /// Reads the targets back; `None` where nothing was covered.
    ///
    /// # Errors
    /// [`DeviceError::DeviceLost`].
    pub fn read(&self, gpu: &Gpu) -> Result<Vec<Option<Probed>>, DeviceError> {
        let read = |texture| -> Result<Vec<[f32; 4]>, DeviceError> {
            let bytes = read_texture(gpu, texture, wgpu::TextureAspect::All)?;
            Ok(bytemuck::pod_collect_to_vec(&bytes))
        };
        let [places, sizes] = &self.textures;
        Ok(Probed::of_targets(&read(places)?, &read(sizes)?))
    }
}

/// The shader of one cover; what tells it from the others of its plan is its route.
fn parts(plan: &TexturedPlan, cover: &TexturedCover) -> TexturedParts {
    TexturedParts::new(
        (plan.position_wgsl(), cover.position_constants.len()),
        (cover.route_wgsl(), cover.route_constants.len()),
        cover.texture.pattern.is_some(),
    )
}
