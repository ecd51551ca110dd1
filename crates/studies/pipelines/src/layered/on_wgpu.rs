// SPDX-License-Identifier: MIT OR Apache-2.0
//! Layers on wgpu: a pass each, or all of them added up in one.

use super::listed::Listed;
use crate::draws::{Counted, FrameTimes, Looked, LooksUp, Times, count};
use crate::on_wgpu::{bind, draw_pipeline, storage_type, texture_type, uniform_type};
use std::sync::Arc;
use terrafill_contract::{CpuStopwatch, DeviceError};
use terrafill_gpu::{Gpu, RenderTargets, read_texture};

/// Where layers are drawn, by a pass each.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum DrawnInto {
    /// A layer each of one image of depths.
    Maps,
    /// The same layer, which a second pass adds to a sum by blending.
    Sum(Accumulator),
}

terrafill_results::named! {
    /// What layers are added up in.
    all pub(crate) enum Accumulator {
        F32 = "blended-f32",
        F16 = "blended-f16",
        Eight = "blended-8-bit",
    }
}

impl Accumulator {
    fn format(self) -> wgpu::TextureFormat {
        match self {
            Self::F32 => wgpu::TextureFormat::R32Float,
            Self::F16 => wgpu::TextureFormat::R16Float,
            Self::Eight => wgpu::TextureFormat::R8Unorm,
        }
    }

    /// Largest rounding of a sum of so many layers that is at most 1.
    pub(crate) fn rounding(self, layers: u32) -> f64 {
        // Half the widest step between numbers up to 1.
        let half_step = match self {
            Self::F32 => 0.25 * f64::from(f32::EPSILON),
            Self::F16 => (-12_f64).exp2(),
            Self::Eight => 0.5 / 255.0,
        };
        // One rounding of the sum a layer; those of what is added are together at most two more.
        (f64::from(layers) + 2.0) * half_step
    }
}

/// What adds a layer to a sum.
struct Adding {
    sum: wgpu::TextureView,
    pipeline: wgpu::RenderPipeline,
    looked_up: wgpu::BindGroup,
}

/// Layers and their picture.
pub(super) struct OnWgpu {
    gpu: Arc<Gpu>,
    maps: wgpu::Texture,
    /// Of each layer of the maps.
    views: Vec<wgpu::TextureView>,
    /// Vertices and layers.
    counts: [u32; 2],
    adding: Option<Adding>,
    pipeline: wgpu::RenderPipeline,
    bound: wgpu::BindGroup,
    picture: wgpu::RenderPipeline,
    looked_up: wgpu::BindGroup,
    targets: RenderTargets,
    bytes: u64,
}

impl OnWgpu {
    pub(super) fn new(
        gpu: &Arc<Gpu>,
        listed: &Listed,
        into: DrawnInto,
    ) -> Result<Self, DeviceError> {
        let layer_count = count(&listed.layers);
        let (sum_format, kept) = match into {
            DrawnInto::Maps => (None, layer_count),
            DrawnInto::Sum(accumulator) => (Some(accumulator.format()), 1),
        };
        check(gpu, sum_format, kept)?;
        let uniform = wgpu::BufferUsages::UNIFORM;
        let storage = wgpu::BufferUsages::STORAGE;
        let places = gpu.upload("places", bytemuck::cast_slice(&listed.places), storage)?;
        let constants = gpu.upload("layers", &listed.layer_bytes(), uniform)?;
        let of_picture = gpu.upload("picture", &listed.constants, uniform)?;
        let values = gpu.upload("values", bytemuck::cast_slice(&listed.values), storage)?;
        let image = |label, layers, format| {
            let usage = wgpu::TextureUsages::RENDER_ATTACHMENT
                | wgpu::TextureUsages::TEXTURE_BINDING
                | wgpu::TextureUsages::COPY_SRC;
            gpu.texture(label, [listed.side, listed.side, layers], 1, format, usage)
        };
        let maps = image("layers", kept, wgpu::TextureFormat::Depth32Float);
        let fragment = wgpu::ShaderStages::FRAGMENT;
        let types = [
            (fragment, uniform_type()),
            (wgpu::ShaderStages::VERTEX, storage_type(true)),
            (wgpu::ShaderStages::VERTEX_FRAGMENT, uniform_type()),
            (fragment, texture_type(wgpu::TextureViewDimension::D2Array)),
            (fragment, storage_type(true)),
        ];
        let buffers = [&of_picture, &places, &constants].map(wgpu::Buffer::as_entire_binding);
        // What is drawn into is not looked up by the same pass.
        let (of_layers, bound) = bind(gpu, types.into_iter().take(3), buffers.clone());
        let look_up = |texels: &wgpu::Texture| {
            let all = texels.create_view(&wgpu::TextureViewDescriptor {
                dimension: Some(wgpu::TextureViewDimension::D2Array),
                ..Default::default()
            });
            let behind = [
                wgpu::BindingResource::TextureView(&all),
                values.as_entire_binding(),
            ];
            bind(gpu, types, buffers.iter().cloned().chain(behind))
        };
        let (layout, of_maps) = look_up(&maps);
        let texel_bytes = sum_format.and_then(|format| format.block_copy_size(None));
        let (adding, looked_up) = match sum_format {
            None => (None, of_maps),
            Some(format) => {
                let sum = image("sum", 1, format);
                let adding = Adding {
                    sum: one_layer(&sum, 0),
                    pipeline: adding_pipeline(gpu, listed.picture, &layout, format)?,
                    looked_up: of_maps,
                };
                (Some(adding), look_up(&sum).1)
            }
        };
        Ok(Self {
            pipeline: layer_pipeline(gpu, &of_layers)?,
            picture: draw_pipeline(gpu, listed.picture, "vertex_main", &layout)?,
            looked_up,
            targets: RenderTargets::new(gpu, listed.size)?,
            gpu: Arc::clone(gpu),
            views: (0..kept).map(|layer| one_layer(&maps, layer)).collect(),
            maps,
            counts: [count(&listed.places), layer_count],
            adding,
            bound,
            bytes: u64::from(listed.side).pow(2) * u64::from(4 * kept + texel_bytes.unwrap_or(0)),
        })
    }

    fn draw_layers(&self) -> Result<(), DeviceError> {
        let [vertices, layers] = self.counts;
        let mut encoder = self.gpu.device.create_command_encoder(&Default::default());
        for (layer, view) in (0..layers).zip(self.views.iter().cycle()) {
            let depth = wgpu::RenderPassDepthStencilAttachment {
                view,
                depth_ops: Some(wgpu::Operations {
                    load: wgpu::LoadOp::Clear(0.0),
                    store: wgpu::StoreOp::Store,
                }),
                stencil_ops: None,
            };
            let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                label: Some("layer"),
                depth_stencil_attachment: Some(depth),
                ..Default::default()
            });
            pass.set_pipeline(&self.pipeline);
            pass.set_bind_group(0, &self.bound, &[]);
            pass.draw(0..vertices, layer..layer + 1);
            drop(pass);
            if let Some(adding) = &self.adding {
                adding.record(&mut encoder, layer == 0);
            }
        }
        self.gpu.queue.submit([encoder.finish()]);
        self.gpu.wait()
    }

    fn draw_picture(&self) -> Result<(), DeviceError> {
        let mut frame = self.targets.direct_frame();
        let mut pass = self.targets.cleared_pass(&mut frame);
        pass.set_pipeline(&self.picture);
        pass.set_bind_group(0, &self.looked_up, &[]);
        pass.draw(0..3, 0..1);
        drop(pass);
        self.gpu.queue.submit([frame.encoder.finish()]);
        self.gpu.wait()
    }
}

impl Adding {
    /// Adds what the layer holds, to nothing where it is the first.
    fn record(&self, encoder: &mut wgpu::CommandEncoder, is_first: bool) {
        let before = if is_first {
            wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT)
        } else {
            wgpu::LoadOp::Load
        };
        let colours = [Some(wgpu::RenderPassColorAttachment {
            view: &self.sum,
            depth_slice: None,
            resolve_target: None,
            ops: wgpu::Operations {
                load: before,
                store: wgpu::StoreOp::Store,
            },
        })];
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("adding"),
            color_attachments: &colours,
            ..Default::default()
        });
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, &self.looked_up, &[]);
        pass.draw(0..3, 0..1);
    }
}

/// A layer to draw into.
fn one_layer(of: &wgpu::Texture, layer: u32) -> wgpu::TextureView {
    of.create_view(&wgpu::TextureViewDescriptor {
        dimension: Some(wgpu::TextureViewDimension::D2),
        base_array_layer: layer,
        array_layer_count: Some(1),
        ..Default::default()
    })
}

/// Refuses what the device cannot hold or add up.
fn check(gpu: &Gpu, sum: Option<wgpu::TextureFormat>, layers: u32) -> Result<(), DeviceError> {
    let allowed = gpu.device.limits().max_texture_array_layers;
    DeviceError::check_capacity("layers of an array texture", layers, allowed)?;
    if sum == Some(wgpu::TextureFormat::R32Float) {
        gpu.require(
            wgpu::Features::FLOAT32_BLENDABLE,
            "blending of 32-bit floats",
        )?;
    }
    Ok(())
}

fn layer_pipeline(
    gpu: &Gpu,
    layout: &wgpu::BindGroupLayout,
) -> Result<wgpu::RenderPipeline, DeviceError> {
    let path = "pipelines/listed.wgsl";
    let module = gpu.shader(path)?;
    let depth_stencil = wgpu::DepthStencilState {
        format: wgpu::TextureFormat::Depth32Float,
        depth_write_enabled: Some(true),
        depth_compare: Some(wgpu::CompareFunction::Greater),
        stencil: Default::default(),
        bias: Default::default(),
    };
    Ok(gpu.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some(path),
        layout: Some(&gpu.pipeline_layout(path, &[Some(layout)])),
        vertex: vertices(&module, "listed"),
        primitive: Default::default(),
        depth_stencil: Some(depth_stencil),
        multisample: Default::default(),
        fragment: None,
        multiview_mask: None,
        cache: None,
    }))
}

/// Of the whole picture, added to a target.
///
/// - `path`: WGSL of the picture
fn adding_pipeline(
    gpu: &Gpu,
    path: &'static str,
    layout: &wgpu::BindGroupLayout,
    format: wgpu::TextureFormat,
) -> Result<wgpu::RenderPipeline, DeviceError> {
    let module = gpu.shader(path)?;
    let one = wgpu::BlendComponent {
        src_factor: wgpu::BlendFactor::One,
        dst_factor: wgpu::BlendFactor::One,
        operation: wgpu::BlendOperation::Add,
    };
    let targets = [Some(wgpu::ColorTargetState {
        format,
        blend: Some(wgpu::BlendState {
            color: one,
            alpha: one,
        }),
        write_mask: wgpu::ColorWrites::ALL,
    })];
    Ok(gpu.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some(path),
        layout: Some(&gpu.pipeline_layout(path, &[Some(layout)])),
        vertex: vertices(&module, "vertex_main"),
        primitive: Default::default(),
        depth_stencil: None,
        multisample: Default::default(),
        fragment: Some(wgpu::FragmentState {
            module: &module,
            entry_point: Some("added"),
            compilation_options: Default::default(),
            targets: &targets,
        }),
        multiview_mask: None,
        cache: None,
    }))
}

/// Vertices that have nothing but numbers.
fn vertices<'a>(module: &'a wgpu::ShaderModule, entry_point: &'a str) -> wgpu::VertexState<'a> {
    wgpu::VertexState {
        module,
        entry_point: Some(entry_point),
        compilation_options: Default::default(),
        buffers: &[],
    }
}

impl LooksUp for OnWgpu {
    fn draw(&mut self) -> Result<Looked, DeviceError> {
        self.draw_layers()?;
        self.draw_picture()?;
        let depths = if self.adding.is_some() {
            Vec::new()
        } else {
            let aspect = wgpu::TextureAspect::DepthOnly;
            bytemuck::pod_collect_to_vec(&read_texture(&self.gpu, &self.maps, aspect)?)
        };
        Ok(Looked {
            picture: self.targets.read()?,
            depths,
            counted: Counted::default(),
        })
    }

    fn time(&mut self) -> Result<FrameTimes, DeviceError> {
        let watch = CpuStopwatch::start();
        self.draw_layers()?;
        // The passes of the layers keep no GPU time.
        let maps = Times::since(&watch, None);
        self.draw_picture()?;
        let all = Times::since(&watch, None);
        Ok(FrameTimes { all, maps })
    }

    fn passes(&self) -> usize {
        // With sums, each layer is drawn and added.
        let each = 1 + usize::from(self.adding.is_some());
        self.counts[1] as usize * each + 1
    }

    fn bytes(&self) -> u64 {
        self.bytes
    }
}
