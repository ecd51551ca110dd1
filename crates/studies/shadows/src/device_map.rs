// SPDX-License-Identifier: MIT OR Apache-2.0
//! The shadow map of [`crate::maps`] on wgpu: drawn from the sun, then asked by every fragment of sea and casters.
//!
//! Column, row and height in the map are computed in `f64` for each vertex, and interpolated in `f32`. The map's
//! depth grows towards the sun, and 0 is where nothing was drawn.

use crate::maps::{Bias, Frame};
use crate::work::Scene;
use glam::DVec3;
use std::ops::Range;
use std::sync::Arc;
use terrafill_contract::{CpuStopwatch, DeviceError, Devices, FrameTimes};
use terrafill_core::nearest_f32;
use terrafill_gpu::{Gpu, PassTimer, TimedPass, read_texture};
use terrafill_shadow_views::{DeckCamera, Light, Positions, sum_of, surface};
use terrafill_study::Failure;

const SHADER: &str = "casters/map.wgsl";
const DEPTH: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;
const ANSWER: wgpu::TextureFormat = wgpu::TextureFormat::R8Unorm;

/// Place from the eye, place in the map, cosine to the sun.
type Vertex = [f32; 7];

/// A map and the views that ask it, ready to be drawn.
pub(crate) struct DeviceMap {
    gpu: Arc<Gpu>,
    map: wgpu::TextureView,
    channels: Vec<Channel>,
    casters: u32,
    pipelines: [wgpu::RenderPipeline; 2],
    timer: Option<PassTimer>,
    answer: wgpu::Texture,
    depth: wgpu::TextureView,
}

struct Channel {
    vertices: wgpu::Buffer,
    count: u32,
    asking: wgpu::Buffer,
    bound: wgpu::BindGroup,
    /// As the shader has it, with a bias of 0.
    numbers: [f32; 20],
}

/// Words of `Asking` that a bias takes: metres, and metres times the slope.
const BIAS_WORDS: [usize; 2] = [15, 16];

impl Scene {
    /// The map's frame as a device has it, over all channels.
    ///
    /// # Errors
    /// Of the device; [`Failure::Unable`] for a map that is larger than its textures.
    pub(crate) fn device_map(
        &self,
        devices: &Devices,
        frame: &Frame,
    ) -> Result<DeviceMap, Failure> {
        let gpu = terrafill_gpu::shared_gpu(devices)?;
        let allowed = gpu.device.limits().max_texture_dimension_2d;
        let found = frame.columns.max(frame.rows);
        if found > allowed as usize {
            let texels = format!(
                "a map of texels of {} m on wgpu: found {found} of them along a side, allowed: {allowed}",
                frame.texel_m
            );
            return Err(Failure::Unable(texels));
        }
        let sizes = [frame.columns, frame.rows].map(|side| u32::try_from(side).unwrap_or(allowed));
        let size = self.views.first().map(|view| view.size);
        let size = size.ok_or_else(|| "no channel".to_owned())?;
        let texture = |[width, height]: [u32; 2], format, usage| {
            gpu.texture("shadow map", [width, height, 1], 1, format, usage)
        };
        let used = wgpu::TextureUsages::RENDER_ATTACHMENT;
        let read = wgpu::TextureUsages::TEXTURE_BINDING;
        let map = texture(sizes, DEPTH, used | read);
        let map = map.create_view(&Default::default());
        let depth = texture(size, DEPTH, used);
        let answer = texture(size, ANSWER, used | wgpu::TextureUsages::COPY_SRC);
        let layout = layout(&gpu);
        let heights = frame.heights(self.mesh());
        let mut channels = Vec::new();
        for view in &self.views {
            channels.push(self.channel(&gpu, &layout, (view, frame, heights), &map)?);
        }
        Ok(DeviceMap {
            pipelines: pipelines(&gpu, &layout)?,
            timer: PassTimer::new(&gpu),
            casters: u32::try_from(3 * self.mesh().triangles.len()).unwrap_or(u32::MAX),
            channels,
            map,
            answer,
            depth: depth.create_view(&Default::default()),
            gpu,
        })
    }

    fn channel(
        &self,
        gpu: &Gpu,
        layout: &wgpu::BindGroupLayout,
        (view, frame, [low, high]): (&DeckCamera, &Frame, [f64; 2]),
        map: &wgpu::TextureView,
    ) -> Result<Channel, Failure> {
        let mesh = self.mesh();
        let seen = surface(Positions::Eye, view, mesh);
        let mut vertices: Vec<Vertex> = Vec::with_capacity(3 * seen.triangles.len());
        for (at, corners) in seen.triangles.iter().enumerate() {
            // Casters come first, in their own order.
            let normal = match mesh.planes.get(at) {
                Some(plane) => mesh.normals[*plane as usize].normalize_or_zero(),
                None => DVec3::Z,
            };
            for &corner in corners {
                let relative = seen.vertices_rte[corner as usize];
                let place = match mesh.vertices.get(corner as usize) {
                    Some(place) => *place,
                    None => view.eye + DVec3::from(relative.map(f64::from)),
                };
                let texel = frame.place(place);
                let height = (place.dot(self.to_light) - low) / (high - low);
                let [x, y, z] = relative;
                let in_map = [texel.x / frame.columns as f64, texel.y / frame.rows as f64];
                let [column, row] = in_map.map(nearest_f32);
                let cosine = nearest_f32(normal.dot(self.to_light));
                vertices.push([x, y, z, column, row, nearest_f32(height), cosine]);
            }
        }
        let axis = |axis: DVec3, over: f64| (axis / over).as_vec3().extend(0.0).to_array();
        let axes = [
            axis(view.right, view.tan[0]),
            axis(view.up, view.tan[1]),
            axis(view.forward, 1.0),
        ];
        let mut numbers = [0.0; 20];
        numbers[..12].copy_from_slice(&axes.concat());
        numbers[12] = frame.columns as f32;
        numbers[13] = frame.rows as f32;
        numbers[14] = nearest_f32(high - low);
        numbers[17] = nearest_f32(view.near);
        let asking = bytemuck::cast_slice(&numbers);
        let asking = gpu.upload("asking", asking, wgpu::BufferUsages::UNIFORM)?;
        let map = wgpu::BindingResource::TextureView(map);
        let bound = gpu.bind("map", layout, [asking.as_entire_binding(), map]);
        let bytes = bytemuck::cast_slice(&vertices);
        Ok(Channel {
            count: u32::try_from(vertices.len()).unwrap_or(u32::MAX),
            vertices: gpu.upload("receivers", bytes, wgpu::BufferUsages::VERTEX)?,
            asking,
            bound,
            numbers,
        })
    }
}

impl DeviceMap {
    /// Masks of all channels by a step of a bias.
    pub(crate) fn masks(
        &self,
        bias: Bias,
        step: f64,
        texel_m: f64,
    ) -> Result<Vec<Vec<bool>>, DeviceError> {
        let mut masks = Vec::new();
        for (at, channel) in self.channels.iter().enumerate() {
            let mut numbers = channel.numbers;
            let metres = nearest_f32(bias.metres(step, texel_m, 1.0));
            numbers[BIAS_WORDS[usize::from(bias == Bias::Slope)]] = metres;
            let numbers = bytemuck::cast_slice(&numbers);
            self.gpu.write_buffer(&channel.asking, 0, numbers);
            self.submit(at, at == 0, false);
            let pixels = read_texture(&self.gpu, &self.answer, wgpu::TextureAspect::All)?;
            masks.push(pixels.iter().map(|answer| *answer > 127).collect());
        }
        Ok(masks)
    }

    /// Draws the map once, and asks it for every channel.
    pub(crate) fn time(&self) -> Result<FrameTimes, DeviceError> {
        let mut sum = FrameTimes::default();
        for channel in 0..self.channels.len() {
            let watch = CpuStopwatch::start();
            let is_first = channel == 0;
            self.submit(channel, is_first, true);
            self.gpu.wait()?;
            let mut times = FrameTimes {
                fill_cpu_ms: watch.cpu_ms(),
                fill_wall_ms: watch.wall_ms(),
                ..FrameTimes::default()
            };
            if let Some(timer) = &self.timer {
                let first = if is_first {
                    TimedPass::Stencil
                } else {
                    TimedPass::Colour
                };
                let stamps = timer.read(&self.gpu, first, TimedPass::Colour)?;
                times.stencil_gpu_ms = stamps.pass_ms(first).filter(|_| is_first);
                times.fill_gpu_ms = stamps.span_ms(first, TimedPass::Colour);
            }
            sum = if is_first {
                times
            } else {
                sum_of(&sum, &times)
            };
        }
        Ok(sum)
    }

    /// - `draws_map`: before it is asked
    fn submit(&self, channel: usize, draws_map: bool, is_timed: bool) {
        let mut encoder = self.gpu.device.create_command_encoder(&Default::default());
        let timer = self.timer.as_ref().filter(|_| is_timed);
        let own = &self.channels[channel];
        let depth = |view| {
            Some(wgpu::RenderPassDepthStencilAttachment {
                view,
                depth_ops: Some(wgpu::Operations {
                    load: wgpu::LoadOp::Clear(0.0),
                    store: wgpu::StoreOp::Store,
                }),
                stencil_ops: None,
            })
        };
        if draws_map {
            let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                label: Some("shadow map"),
                depth_stencil_attachment: depth(&self.map),
                timestamp_writes: timer.map(|timer| timer.around(TimedPass::Stencil)),
                ..Default::default()
            });
            pass.set_pipeline(&self.pipelines[0]);
            pass.set_vertex_buffer(0, own.vertices.slice(..));
            pass.draw(0..self.casters, 0..1);
        }
        let answer = self.answer.create_view(&Default::default());
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("asking"),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: &answer,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations {
                    load: wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT),
                    store: wgpu::StoreOp::Store,
                },
            })],
            depth_stencil_attachment: depth(&self.depth),
            timestamp_writes: timer.map(|timer| timer.around(TimedPass::Colour)),
            ..Default::default()
        });
        pass.set_pipeline(&self.pipelines[1]);
        pass.set_bind_group(0, &own.bound, &[]);
        pass.set_vertex_buffer(0, own.vertices.slice(..));
        pass.draw(0..own.count, 0..1);
        drop(pass);
        self.gpu.queue.submit([encoder.finish()]);
    }
}

fn layout(gpu: &Gpu) -> wgpu::BindGroupLayout {
    let uniform = wgpu::BindingType::Buffer {
        ty: wgpu::BufferBindingType::Uniform,
        has_dynamic_offset: false,
        min_binding_size: None,
    };
    let map = wgpu::BindingType::Texture {
        sample_type: wgpu::TextureSampleType::Depth,
        view_dimension: wgpu::TextureViewDimension::D2,
        multisampled: false,
    };
    let types = [
        (wgpu::ShaderStages::VERTEX_FRAGMENT, uniform),
        (wgpu::ShaderStages::FRAGMENT, map),
    ];
    gpu.mixed_layout("map", types)
}

/// Of the map, and of those who ask it.
fn pipelines(
    gpu: &Gpu,
    layout: &wgpu::BindGroupLayout,
) -> Result<[wgpu::RenderPipeline; 2], DeviceError> {
    let module = gpu.shader(SHADER)?;
    let attributes = wgpu::vertex_attr_array![0 => Float32x3, 1 => Float32x3, 2 => Float32];
    let depth = wgpu::DepthStencilState {
        format: DEPTH,
        depth_write_enabled: Some(true),
        depth_compare: Some(wgpu::CompareFunction::Greater),
        stencil: Default::default(),
        bias: Default::default(),
    };
    let targets = [Some(wgpu::ColorTargetState {
        format: ANSWER,
        blend: None,
        write_mask: wgpu::ColorWrites::ALL,
    })];
    let asks = wgpu::FragmentState {
        module: &module,
        entry_point: Some("ask"),
        compilation_options: wgpu::PipelineCompilationOptions::default(),
        targets: &targets,
    };
    let none = gpu.pipeline_layout("shadow map", &[]);
    let own = gpu.pipeline_layout("asking", &[Some(layout)]);
    let of = |label, layout, entry_point, read: Range<usize>, fragment| {
        let buffers = [Some(wgpu::VertexBufferLayout {
            array_stride: size_of::<Vertex>() as u64,
            step_mode: wgpu::VertexStepMode::Vertex,
            attributes: &attributes[read],
        })];
        gpu.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some(label),
            layout: Some(layout),
            vertex: wgpu::VertexState {
                module: &module,
                entry_point: Some(entry_point),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                buffers: &buffers,
            },
            primitive: wgpu::PrimitiveState::default(),
            depth_stencil: Some(depth.clone()),
            multisample: wgpu::MultisampleState::default(),
            fragment,
            multiview_mask: None,
            cache: None,
        })
    };
    Ok([
        of("shadow map", &none, "from_sun", 1..2, None),
        of("asking", &own, "from_eye", 0..3, Some(asks)),
    ])
}

/// Pixels of receivers that two ways of asking say otherwise of, over all channels.
pub(crate) fn differing(scene: &Scene, one: &[Vec<bool>], other: &[Vec<bool>]) -> usize {
    let channels = scene.truths().iter().zip(one.iter().zip(other));
    channels
        .map(|(truth, (one, other))| {
            let pixels = truth.light.iter().zip(one.iter().zip(other));
            pixels
                .filter(|(light, (one, other))| {
                    matches!(light, Light::Lit | Light::Shadow) && one != other
                })
                .count()
        })
        .sum()
}
