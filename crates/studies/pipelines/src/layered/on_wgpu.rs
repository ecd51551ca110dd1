// SPDX-License-Identifier: MIT OR Apache-2.0
//! Layers on wgpu: a pass each, or all of them added up in one.

use super::listed::Listed;
use crate::draws::{Counted, FrameTimes, Looked, LooksUp, Times, count};
use crate::on_wgpu::{bind, draw_pipeline, storage_type, texture_type, uniform_type};
use std::sync::Arc;
use terrafill_contract::{CpuStopwatch, DeviceError};
use terrafill_gpu::{Gpu, RenderTargets, read_texture};

/// Where layers are drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Into {
    /// A layer each of one image of depths, by a pass each.
    Maps,
    /// One image, by blending.
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
        let step = match self {
            Self::F32 => f64::from(f32::EPSILON),
            Self::F16 => (-10_f64).exp2(),
            Self::Eight => 1.0 / 255.0,
        };
        // Half a step of what is added, half a step of the sum, for every layer.
        (f64::from(layers) + 2.0) * step
    }
}

/// Layers and their picture.
pub(super) struct OnWgpu {
    gpu: Arc<Gpu>,
    layers: wgpu::Texture,
    /// Of each pass.
    views: Vec<wgpu::TextureView>,
    /// Vertices and layers.
    counts: [u32; 2],
    is_sum: bool,
    pipeline: wgpu::RenderPipeline,
    bound: wgpu::BindGroup,
    picture: wgpu::RenderPipeline,
    looked_up: wgpu::BindGroup,
    targets: RenderTargets,
    bytes: u64,
}

impl OnWgpu {
    pub(super) fn new(gpu: &Arc<Gpu>, listed: &Listed, into: Into) -> Result<Self, DeviceError> {
        let layer_count = count(&listed.layers);
        let (format, kept) = match into {
            Into::Maps => (wgpu::TextureFormat::Depth32Float, layer_count),
            Into::Sum(accumulator) => (accumulator.format(), 1),
        };
        check(gpu, format, kept)?;
        let uniform = wgpu::BufferUsages::UNIFORM;
        let storage = wgpu::BufferUsages::STORAGE;
        let places = gpu.upload("places", bytemuck::cast_slice(&listed.places), storage)?;
        let constants = gpu.upload("layers", &listed.layer_bytes(), uniform)?;
        let of_picture = gpu.upload("picture", &listed.constants, uniform)?;
        let values = gpu.upload("values", bytemuck::cast_slice(&listed.values), storage)?;
        let size = [listed.side, listed.side, kept];
        let usage = wgpu::TextureUsages::RENDER_ATTACHMENT
            | wgpu::TextureUsages::TEXTURE_BINDING
            | wgpu::TextureUsages::COPY_SRC;
        let layers = gpu.texture("layers", size, 1, format, usage);
        let view = |first: u32, count: u32, dimension| {
            layers.create_view(&wgpu::TextureViewDescriptor {
                dimension: Some(dimension),
                base_array_layer: first,
                array_layer_count: Some(count),
                ..Default::default()
            })
        };
        let all = view(0, kept, wgpu::TextureViewDimension::D2Array);
        let fragment = wgpu::ShaderStages::FRAGMENT;
        let texels = texture_type(wgpu::TextureViewDimension::D2Array);
        let types = [
            (fragment, uniform_type()),
            (wgpu::ShaderStages::VERTEX, storage_type(true)),
            (wgpu::ShaderStages::VERTEX_FRAGMENT, uniform_type()),
            (fragment, texels),
            (fragment, storage_type(true)),
        ];
        let resources = [
            of_picture.as_entire_binding(),
            places.as_entire_binding(),
            constants.as_entire_binding(),
            wgpu::BindingResource::TextureView(&all),
            values.as_entire_binding(),
        ];
        // What is drawn into is not looked up by the same pass.
        let own = resources[..3].iter().cloned();
        let (layout, bound) = bind(gpu, types.into_iter().take(3), own);
        let pipeline = layer_pipeline(gpu, &layout, into)?;
        let (layout, looked_up) = bind(gpu, types, resources);
        let texel_bytes = format.block_copy_size(None).unwrap_or(4);
        let views = (0..kept).map(|layer| view(layer, 1, wgpu::TextureViewDimension::D2));
        let views = views.collect();
        Ok(Self {
            picture: draw_pipeline(gpu, listed.picture, "vertex_main", &layout)?,
            looked_up,
            targets: RenderTargets::new(gpu, listed.size)?,
            gpu: Arc::clone(gpu),
            views,
            layers,
            counts: [count(&listed.places), layer_count],
            is_sum: into != Into::Maps,
            pipeline,
            bound,
            bytes: u64::from(listed.side).pow(2) * u64::from(kept * texel_bytes),
        })
    }

    fn draw_layers(&self) -> Result<(), DeviceError> {
        let [vertices, layers] = self.counts;
        let mut encoder = self.gpu.device.create_command_encoder(&Default::default());
        for (layer, view) in (0..).zip(&self.views) {
            let store = wgpu::StoreOp::Store;
            let colours = [Some(wgpu::RenderPassColorAttachment {
                view,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations {
                    load: wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT),
                    store,
                },
            })];
            let depth = wgpu::RenderPassDepthStencilAttachment {
                view,
                depth_ops: Some(wgpu::Operations {
                    load: wgpu::LoadOp::Clear(0.0),
                    store,
                }),
                stencil_ops: None,
            };
            let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                label: Some("layer"),
                color_attachments: if self.is_sum { &colours } else { &[] },
                depth_stencil_attachment: (!self.is_sum).then_some(depth),
                ..Default::default()
            });
            pass.set_pipeline(&self.pipeline);
            pass.set_bind_group(0, &self.bound, &[]);
            let drawn = if self.is_sum {
                0..layers
            } else {
                layer..layer + 1
            };
            pass.draw(0..vertices, drawn);
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

/// Refuses what the device cannot hold or add up.
fn check(gpu: &Gpu, format: wgpu::TextureFormat, layers: u32) -> Result<(), DeviceError> {
    let allowed = gpu.device.limits().max_texture_array_layers;
    DeviceError::check_capacity("layers of an array texture", layers, allowed)?;
    if format == wgpu::TextureFormat::R32Float {
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
    into: Into,
) -> Result<wgpu::RenderPipeline, DeviceError> {
    let path = "pipelines/listed.wgsl";
    let module = gpu.shader(path)?;
    let layout = gpu.pipeline_layout(path, &[Some(layout)]);
    let one = wgpu::BlendComponent {
        src_factor: wgpu::BlendFactor::One,
        dst_factor: wgpu::BlendFactor::One,
        operation: wgpu::BlendOperation::Add,
    };
    let targets = match into {
        Into::Maps => [None],
        Into::Sum(accumulator) => [Some(wgpu::ColorTargetState {
            format: accumulator.format(),
            blend: Some(wgpu::BlendState {
                color: one,
                alpha: one,
            }),
            write_mask: wgpu::ColorWrites::ALL,
        })],
    };
    let depth_stencil = (into == Into::Maps).then(|| wgpu::DepthStencilState {
        format: wgpu::TextureFormat::Depth32Float,
        depth_write_enabled: Some(true),
        depth_compare: Some(wgpu::CompareFunction::Greater),
        stencil: Default::default(),
        bias: Default::default(),
    });
    let fragment = wgpu::FragmentState {
        module: &module,
        entry_point: Some("added"),
        compilation_options: Default::default(),
        targets: &targets,
    };
    Ok(gpu.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some(path),
        layout: Some(&layout),
        vertex: wgpu::VertexState {
            module: &module,
            entry_point: Some("listed"),
            compilation_options: Default::default(),
            buffers: &[],
        },
        primitive: Default::default(),
        depth_stencil,
        multisample: Default::default(),
        fragment: (into != Into::Maps).then_some(fragment),
        multiview_mask: None,
        cache: None,
    }))
}

impl LooksUp for OnWgpu {
    fn draw(&mut self) -> Result<Looked, DeviceError> {
        self.draw_layers()?;
        self.draw_picture()?;
        let depths = if self.is_sum {
            Vec::new()
        } else {
            let aspect = wgpu::TextureAspect::DepthOnly;
            bytemuck::pod_collect_to_vec(&read_texture(&self.gpu, &self.layers, aspect)?)
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
        self.views.len() + 1
    }

    fn bytes(&self) -> u64 {
        self.bytes
    }
}
