// SPDX-License-Identifier: MIT OR Apache-2.0
//! Textured covers on wgpu: the picture on the device, its samplers, the constants of a view, and one
//! pipeline for each kind of cover that a scene needs.
//!
//! A textured cover stands where a plain one would: a triangle over the screen, cut by scissor and
//! stencil. It reads the depth that the surface left through a second view of the texture that is
//! attached, which is allowed while neither depth nor stencil is written: so no depth is copied, and
//! covers that take the stencil back to 0 cannot be textured.

use crate::readback::read_texture;
use crate::{COLOUR_FORMAT, DEPTH_STENCIL_FORMAT, Gpu, Stage};
use std::collections::HashMap;
use terrafill_frame::{BackendError, StencilTest, TexturedRegion};
use terrafill_scene::ImageSize;
use terrafill_shaders::{TEXTURED_COVER, TexturedParts};

/// Format of the probe's targets: what the shader computes, unrounded.
pub const PROBE_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba32Float;

/// How one region is covered.
#[derive(Debug, Clone, PartialEq)]
pub struct TexturedCover {
    /// Its shader, an index into the parts given with it.
    pub parts: usize,
    /// Which copy of the picture.
    pub image: usize,
    /// What the sampler does beyond the picture, in u and in v.
    pub address: [wgpu::AddressMode; 2],
    /// Whether nothing is drawn beyond the picture's edges.
    pub ends_at_edges: bool,
    /// Whether it fades with the distance.
    pub fades: bool,
    /// Whether anything of what lies under it can show.
    pub is_translucent: bool,
    /// Fixed part of its constants.
    pub region: TexturedRegion,
    /// The position route's constants.
    pub position: Vec<[f32; 4]>,
    /// The coordinate route's constants.
    pub route: Vec<[f32; 4]>,
}

/// One level of a picture.
#[derive(Debug, Clone, Copy)]
pub struct ImageLevel<'a> {
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// sRGB and straight alpha, row 0 at the top.
    pub rgba: &'a [u8],
}

/// What a cover is drawn for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum CoverPurpose {
    /// The picture's colours.
    Colour,
    /// Where the picture's texels came from, into the targets of a [`Probe`].
    Probe,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
struct CoverKey {
    shader: usize,
    test: StencilTest,
    purpose: CoverPurpose,
    ends_at_edges: bool,
    fades: bool,
    blends: bool,
}

/// Textured covers of one scene and view.
#[derive(Debug)]
pub struct TexturedFill {
    constant_bindings: wgpu::BindGroupLayout,
    image_bindings: wgpu::BindGroupLayout,
    layout: wgpu::PipelineLayout,
    shaders: Vec<(TexturedParts, wgpu::ShaderModule)>,
    pipelines: HashMap<CoverKey, wgpu::RenderPipeline>,
    images: Vec<wgpu::Texture>,
    image_groups: HashMap<(usize, [wgpu::AddressMode; 2]), wgpu::BindGroup>,
    view: Option<TexturedView>,
}

#[derive(Debug)]
struct TexturedView {
    constants: wgpu::Buffer,
    written: Vec<[f32; 4]>,
    bind_group: wgpu::BindGroup,
    covers: Vec<TexturedCover>,
    /// Of each of the parts given: its place in `TexturedFill::shaders`.
    shaders: Vec<usize>,
}

impl TexturedFill {
    /// Nothing uploaded and no pipeline made yet.
    ///
    /// - `frame_bindings`: group 0, the view's constants at binding 0
    #[must_use]
    pub fn new(gpu: &Gpu, frame_bindings: &wgpu::BindGroupLayout) -> Self {
        let device = &gpu.device;
        let group = |label, entries: &[wgpu::BindingType]| {
            let entries: Vec<_> = (0..).zip(entries).map(fragment_entry).collect();
            device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
                label: Some(label),
                entries: &entries,
            })
        };
        let texture = |sample_type| wgpu::BindingType::Texture {
            sample_type,
            view_dimension: wgpu::TextureViewDimension::D2,
            multisampled: false,
        };
        let constant_bindings = group(
            "depth and textured regions",
            &[
                texture(wgpu::TextureSampleType::Depth),
                wgpu::BindingType::Buffer {
                    ty: wgpu::BufferBindingType::Storage { read_only: true },
                    has_dynamic_offset: false,
                    min_binding_size: None,
                },
            ],
        );
        let image_bindings = group(
            "picture",
            &[
                texture(wgpu::TextureSampleType::Float { filterable: true }),
                wgpu::BindingType::Sampler(wgpu::SamplerBindingType::Filtering),
            ],
        );
        let groups = [
            Some(frame_bindings),
            Some(&constant_bindings),
            Some(&image_bindings),
        ];
        let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some("textured cover"),
            bind_group_layouts: &groups,
            immediate_size: 0,
        });
        Self {
            constant_bindings,
            image_bindings,
            layout,
            shaders: Vec::new(),
            pipelines: HashMap::new(),
            images: Vec::new(),
            image_groups: HashMap::new(),
            view: None,
        }
    }

    /// Uploads `copies` of a picture with all its levels in place of those there were.
    ///
    /// # Errors
    /// [`BackendError::OverCapacity`] when the device has no textures that large.
    pub fn upload_image(
        &mut self,
        gpu: &Gpu,
        levels: &[ImageLevel<'_>],
        copies: usize,
    ) -> Result<(), BackendError> {
        let Some(first) = levels.first() else {
            return Ok(());
        };
        let allowed = gpu.device.limits().max_texture_dimension_2d;
        let side = first.width.max(first.height);
        if side > allowed {
            return Err(BackendError::OverCapacity {
                what: "texels along a side of the picture".to_owned(),
                found: u64::from(side),
                allowed: u64::from(allowed),
            });
        }
        self.image_groups.clear();
        self.images = (0..copies).map(|_| picture(gpu, levels)).collect();
        Ok(())
    }

    /// Bytes of the pictures on the device.
    #[must_use]
    pub fn image_bytes(&self) -> u64 {
        self.images.iter().map(bytes_of).sum()
    }

    /// Bytes of the regions' constants.
    #[must_use]
    pub fn constant_bytes(&self) -> u64 {
        let written = self.view.as_ref().map(|view| size_of_val(&*view.written));
        written.unwrap_or(0) as u64
    }

    /// Takes over a view: constants are written where they changed, shaders and bind groups made
    /// where they are missing.
    ///
    /// - `covers`: by planned region; each names one of `parts`
    ///
    /// # Errors
    /// [`BackendError::Shader`], [`BackendError::OverCapacity`].
    pub fn set_view(
        &mut self,
        stage: &Stage,
        parts: &[TexturedParts],
        covers: Vec<TexturedCover>,
    ) -> Result<(), BackendError> {
        let gpu = stage.gpu();
        let shaders = parts.iter().map(|parts| self.shader(gpu, parts));
        let shaders: Vec<usize> = shaders.collect::<Result<_, _>>()?;
        let written = constants_of(&covers);
        for cover in &covers {
            self.ensure_image_group(gpu, (cover.image, cover.address));
        }
        let there = self.view.take();
        let (constants, bind_group) = match there {
            Some(view) if view.written.len() == written.len() => {
                if view.written != written {
                    gpu.write_buffer(&view.constants, 0, bytemuck::cast_slice(&written));
                }
                (view.constants, view.bind_group)
            }
            _ => {
                let bytes = bytemuck::cast_slice(&written);
                let usage = wgpu::BufferUsages::STORAGE;
                let constants = stage.upload("textured regions", bytes, usage)?;
                let bind_group = self.bind_constants(stage, &constants);
                (constants, bind_group)
            }
        };
        self.view = Some(TexturedView {
            constants,
            written,
            bind_group,
            covers,
            shaders,
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

    /// Covers one planned region within the scissor that is set; group 0 is bound by the caller.
    /// Nothing that is bound already is bound again: `bound` says what the last cover left.
    pub fn draw(
        &self,
        pass: &mut wgpu::RenderPass<'_>,
        test: StencilTest,
        purpose: CoverPurpose,
        planned: usize,
        bound: &mut BoundCover,
    ) {
        let Some((key, cover)) = self.cover(test, purpose, planned) else {
            return;
        };
        let image = (cover.image, cover.address);
        let found = self.pipelines.get(&key).zip(self.image_groups.get(&image));
        let (Some((pipeline, image_group)), Some(view)) = (found, &self.view) else {
            return;
        };
        if bound.key != Some(key) {
            pass.set_pipeline(pipeline);
            if bound.key.is_none() {
                pass.set_bind_group(1, &view.bind_group, &[]);
            }
            bound.key = Some(key);
        }
        if bound.image != Some(image) {
            pass.set_bind_group(2, image_group, &[]);
            bound.image = Some(image);
        }
        let instance = u32::try_from(planned).unwrap_or(u32::MAX - 1);
        pass.draw(0..3, instance..instance + 1);
    }

    fn cover(
        &self,
        test: StencilTest,
        purpose: CoverPurpose,
        planned: usize,
    ) -> Option<(CoverKey, &TexturedCover)> {
        let view = self.view.as_ref()?;
        let cover = view.covers.get(planned)?;
        let colours = purpose == CoverPurpose::Colour;
        let key = CoverKey {
            shader: *view.shaders.get(cover.parts)?,
            test,
            purpose,
            ends_at_edges: colours && cover.ends_at_edges,
            fades: colours && cover.fades,
            blends: colours && cover.is_translucent,
        };
        Some((key, cover))
    }

    fn shader(&mut self, gpu: &Gpu, parts: &TexturedParts) -> Result<usize, BackendError> {
        if let Some(there) = self.shaders.iter().position(|(made, _)| made == parts) {
            return Ok(there);
        }
        let failed = |error: terrafill_shaders::ShaderError| BackendError::Shader {
            name: TEXTURED_COVER.to_owned(),
            message: error.to_string(),
        };
        let composed = parts.compose().map_err(failed)?;
        // A route that does not compile is the caller's error to report, not the device's.
        terrafill_shaders::validate(TEXTURED_COVER, &composed).map_err(failed)?;
        let module = gpu
            .device
            .create_shader_module(wgpu::ShaderModuleDescriptor {
                label: Some(TEXTURED_COVER),
                source: wgpu::ShaderSource::Wgsl(composed.into()),
            });
        self.shaders.push((parts.clone(), module));
        Ok(self.shaders.len() - 1)
    }

    fn ensure_image_group(&mut self, gpu: &Gpu, key: (usize, [wgpu::AddressMode; 2])) {
        let Some(image) = self.images.get(key.0) else {
            return;
        };
        if self.image_groups.contains_key(&key) {
            return;
        }
        let [address_mode_u, address_mode_v] = key.1;
        let sampler = gpu.device.create_sampler(&wgpu::SamplerDescriptor {
            label: Some("trilinear"),
            address_mode_u,
            address_mode_v,
            mag_filter: wgpu::FilterMode::Linear,
            min_filter: wgpu::FilterMode::Linear,
            mipmap_filter: wgpu::MipmapFilterMode::Linear,
            ..Default::default()
        });
        let group = gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("picture"),
            layout: &self.image_bindings,
            entries: &[
                wgpu::BindGroupEntry {
                    binding: 0,
                    resource: wgpu::BindingResource::TextureView(
                        &image.create_view(&Default::default()),
                    ),
                },
                wgpu::BindGroupEntry {
                    binding: 1,
                    resource: wgpu::BindingResource::Sampler(&sampler),
                },
            ],
        });
        self.image_groups.insert(key, group);
    }

    fn bind_constants(&self, stage: &Stage, constants: &wgpu::Buffer) -> wgpu::BindGroup {
        let device = &stage.gpu().device;
        device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("depth and textured regions"),
            layout: &self.constant_bindings,
            entries: &[
                wgpu::BindGroupEntry {
                    binding: 0,
                    resource: wgpu::BindingResource::TextureView(&stage.depth_view()),
                },
                wgpu::BindGroupEntry {
                    binding: 1,
                    resource: constants.as_entire_binding(),
                },
            ],
        })
    }

    fn pipeline(&self, gpu: &Gpu, key: CoverKey) -> wgpu::RenderPipeline {
        let module = &self.shaders[key.shader].1;
        let written = |format, blend| {
            Some(wgpu::ColorTargetState {
                format,
                blend,
                write_mask: wgpu::ColorWrites::ALL,
            })
        };
        let blend = key.blends.then_some(wgpu::BlendState::ALPHA_BLENDING);
        let (entry_point, targets) = match key.purpose {
            CoverPurpose::Colour => ("fragment_main", vec![written(COLOUR_FORMAT, blend)]),
            CoverPurpose::Probe => ("probe_main", vec![written(PROBE_FORMAT, None); 2]),
        };
        let constants = [
            ("FADES", f64::from(u8::from(key.fades))),
            ("ENDS_AT_EDGES", f64::from(u8::from(key.ends_at_edges))),
        ];
        gpu.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some("textured cover"),
            layout: Some(&self.layout),
            vertex: wgpu::VertexState {
                module,
                entry_point: Some("vertex_main"),
                compilation_options: Default::default(),
                buffers: &[],
            },
            primitive: Default::default(),
            depth_stencil: Some(colour_state(key.test)),
            multisample: Default::default(),
            fragment: Some(wgpu::FragmentState {
                module,
                entry_point: Some(entry_point),
                compilation_options: wgpu::PipelineCompilationOptions {
                    constants: &constants,
                    ..Default::default()
                },
                targets: &targets,
            }),
            multiview_mask: None,
            cache: None,
        })
    }
}

/// What the last cover of a pass left bound.
#[derive(Debug, Default)]
pub struct BoundCover {
    key: Option<CoverKey>,
    image: Option<(usize, [wgpu::AddressMode; 2])>,
}

/// Targets of the covers' probe.
#[derive(Debug)]
pub struct Probe {
    textures: [wgpu::Texture; 2],
}

/// What the probe found at a pixel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Probed {
    /// Texture coordinates; of a pattern, those for `k = 0`.
    pub uv: [f32; 2],
    /// Level of detail.
    pub level: f32,
    /// What the region's constants say it is.
    pub id: f32,
    /// The pattern's `k`; 0 without one.
    pub pattern_level: f32,
    /// Longer footprint, texels; of a pattern, for `k = 0`.
    pub footprint_texels: f32,
    /// Distance from the eye, metres.
    pub distance_m: f32,
}

impl Probe {
    /// Targets as large as the image.
    #[must_use]
    pub fn new(gpu: &Gpu, size: ImageSize) -> Self {
        let target = |label| {
            gpu.device.create_texture(&wgpu::TextureDescriptor {
                label: Some(label),
                size: wgpu::Extent3d {
                    width: size.width,
                    height: size.height,
                    depth_or_array_layers: 1,
                },
                mip_level_count: 1,
                sample_count: 1,
                dimension: wgpu::TextureDimension::D2,
                format: PROBE_FORMAT,
                usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC,
                view_formats: &[],
            })
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
    /// [`BackendError::DeviceLost`].
    pub fn read(&self, gpu: &Gpu) -> Result<Vec<Option<Probed>>, BackendError> {
        let read = |texture| -> Result<Vec<[f32; 4]>, BackendError> {
            let bytes = read_texture(gpu, texture, wgpu::TextureAspect::All)?;
            Ok(bytemuck::pod_collect_to_vec(&bytes))
        };
        let (places, sizes) = (read(&self.textures[0])?, read(&self.textures[1])?);
        let probed = |(place, size): ([f32; 4], [f32; 4])| {
            // Cleared to 0, which is no region's id.
            (place[3] != 0.0).then_some(Probed {
                uv: [place[0], place[1]],
                level: place[2],
                id: place[3],
                pattern_level: size[0],
                footprint_texels: size[1],
                distance_m: size[2],
            })
        };
        Ok(places.into_iter().zip(sizes).map(probed).collect())
    }
}

fn fragment_entry((binding, ty): (u32, &wgpu::BindingType)) -> wgpu::BindGroupLayoutEntry {
    wgpu::BindGroupLayoutEntry {
        binding,
        visibility: wgpu::ShaderStages::FRAGMENT,
        ty: *ty,
        count: None,
    }
}

/// All regions' constants one after the other, each as long as the longest.
fn constants_of(covers: &[TexturedCover]) -> Vec<[f32; 4]> {
    // A shader's array is never empty: see `TexturedParts::compose`.
    let room = |of: fn(&TexturedCover) -> usize| covers.iter().map(of).max().unwrap_or(0).max(1);
    let position_room = room(|cover| cover.position.len());
    let route_room = room(|cover| cover.route.len());
    let padded = |constants: &[[f32; 4]], room: usize| {
        let mut padded = constants.to_vec();
        padded.resize(room, [0.0; 4]);
        padded
    };
    let mut all = Vec::new();
    for cover in covers {
        all.extend_from_slice(bytemuck::cast_slice(&[cover.region]));
        all.extend(padded(&cover.position, position_room));
        all.extend(padded(&cover.route, route_room));
    }
    if all.is_empty() {
        // A storage binding may not be empty.
        all.resize(
            TexturedRegion::VECTORS + position_room + route_room,
            [0.0; 4],
        );
    }
    all
}

fn picture(gpu: &Gpu, levels: &[ImageLevel<'_>]) -> wgpu::Texture {
    let extent = |level: &ImageLevel<'_>| wgpu::Extent3d {
        width: level.width,
        height: level.height,
        depth_or_array_layers: 1,
    };
    let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: Some("picture"),
        size: extent(&levels[0]),
        mip_level_count: u32::try_from(levels.len()).unwrap_or(1),
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        // The sampler filters in linear light, as the levels were made.
        format: wgpu::TextureFormat::Rgba8UnormSrgb,
        usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
        view_formats: &[],
    });
    for (mip_level, level) in (0..).zip(levels) {
        gpu.count_upload(level.rgba.len() as u64);
        gpu.queue.write_texture(
            wgpu::TexelCopyTextureInfo {
                texture: &texture,
                mip_level,
                origin: wgpu::Origin3d::ZERO,
                aspect: wgpu::TextureAspect::All,
            },
            level.rgba,
            wgpu::TexelCopyBufferLayout {
                offset: 0,
                bytes_per_row: Some(4 * level.width),
                rows_per_image: None,
            },
            extent(level),
        );
    }
    texture
}

fn bytes_of(texture: &wgpu::Texture) -> u64 {
    let level = |i: u32| {
        let side = |size: u32| u64::from((size >> i).max(1));
        4 * side(texture.width()) * side(texture.height())
    };
    (0..texture.mip_level_count()).map(level).sum()
}

fn colour_state(test: StencilTest) -> wgpu::DepthStencilState {
    let face = wgpu::StencilFaceState {
        compare: if test.is_equal {
            wgpu::CompareFunction::Equal
        } else {
            wgpu::CompareFunction::NotEqual
        },
        ..wgpu::StencilFaceState::IGNORE
    };
    wgpu::DepthStencilState {
        format: DEPTH_STENCIL_FORMAT,
        depth_write_enabled: Some(false),
        depth_compare: Some(wgpu::CompareFunction::Always),
        stencil: wgpu::StencilState {
            front: face,
            back: face,
            read_mask: u32::from(test.read_mask),
            write_mask: 0,
        },
        bias: Default::default(),
    }
}
