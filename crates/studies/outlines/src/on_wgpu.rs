// SPDX-License-Identifier: MIT OR Apache-2.0
//! Models and their outlines on wgpu: numbers as colour, reversed depth, and a stencil of 8 bits.

use crate::contour::{from_eye, strokes};
use crate::fleet::{Fleet, VALUES, index};
use glam::DVec3;
use std::ops::Range;
use std::sync::Arc;
use terrafill_contract::DeviceError;
use terrafill_gpu::{
    DEPTH_STENCIL_FORMAT, Gpu, PassTimer, TimedPass, attached, described, read_texture, tested,
    vertex_layout,
};

const SHADER: &str = "casters/outlines.wgsl";
const NUMBERS: wgpu::TextureFormat = wgpu::TextureFormat::R32Uint;
/// A stencil without a model.
const NONE: u32 = 255;

terrafill_results::named! {
    /// How contours within a model are left out.
    all pub(crate) enum Way {
        /// The stencil is cleared for each model.
        Clear = "clear",
        /// A value for each model; strokes pass where the stencil differs from it.
        Value = "value",
        /// As printed: they pass where it is equal.
        ValueAsPrinted = "value as printed",
        /// Values that come round without a clear: a negative control.
        ValueNeverCleared = "value, never cleared",
    }
}

impl Way {
    /// What models write into the stencil, by their place, and before which of them it is cleared.
    fn value(self, model: usize) -> (u32, bool) {
        let value = index((model + 1) % VALUES);
        match self {
            Self::Clear => (0, true),
            Self::Value | Self::ValueAsPrinted => (value, model == 0 || value == 0),
            Self::ValueNeverCleared => (value, model == 0),
        }
    }
}

#[repr(C)]
#[derive(Debug, Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
pub(crate) struct OutlineConstants {
    pub(crate) right: [f32; 4],
    pub(crate) up: [f32; 4],
    pub(crate) forward: [f32; 4],
    pub(crate) size_px: [f32; 4],
}

/// What a frame took.
pub(crate) struct Drawn {
    pub(crate) gpu_ms: Option<f64>,
    pub(crate) clears: usize,
}

pub(crate) struct OnWgpu {
    gpu: Arc<Gpu>,
    numbers: wgpu::Texture,
    depth_stencil: wgpu::Texture,
    timer: Option<PassTimer>,
    faces: wgpu::RenderPipeline,
    /// Where the stencil is another value, and where it is equal.
    strokes: [wgpu::RenderPipeline; 2],
    bound: wgpu::BindGroup,
    constants: wgpu::Buffer,
    view: OutlineConstants,
    /// Of faces: vertices and indices; edges.
    buffers: [wgpu::Buffer; 3],
    /// Of each model: its indices and its edges.
    models: Vec<[Range<u32>; 2]>,
}

impl OnWgpu {
    pub(crate) fn new(gpu: &Arc<Gpu>, fleet: &Fleet) -> Result<Self, DeviceError> {
        let camera = &fleet.camera;
        let [columns, rows] = camera.size;
        let target = |label, format| {
            let usage = wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC;
            gpu.texture(label, [columns, rows, 1], 1, format, usage)
        };
        let uniform = wgpu::BufferBindingType::Uniform;
        let stages = wgpu::ShaderStages::VERTEX_FRAGMENT;
        let layout = gpu.buffer_layout("outlines", stages, &[uniform]);
        let usage = wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST;
        let bytes = size_of::<OutlineConstants>() as u64;
        let constants = gpu.unwritten("outline constants", bytes, usage);
        let (edges, ranges) = strokes(fleet);
        let vertices = 0..fleet.mesh.vertices.len();
        let vertices: Vec<[f32; 3]> = vertices.map(|at| from_eye(fleet, at)).collect();
        let models = ranges.into_iter().enumerate().map(|(model, edges)| {
            let triangles = fleet.of_model(model, |part| part.triangles.clone());
            [3 * index(triangles.start)..3 * index(triangles.end), edges]
        });
        let upload = |label, bytes: &[u8], usage| gpu.upload(label, bytes, usage);
        let (vertex, indexed) = (wgpu::BufferUsages::VERTEX, wgpu::BufferUsages::INDEX);
        let buffers = [
            upload("models", bytemuck::cast_slice(&vertices), vertex)?,
            upload(
                "faces",
                bytemuck::cast_slice(&fleet.mesh.triangles),
                indexed,
            )?,
            upload("contour edges", bytemuck::cast_slice(&edges), vertex)?,
        ];
        let axis = |axis: DVec3, w: f64| axis.extend(w).as_vec4().to_array();
        let [across, high] = camera.tan;
        let size = DVec3::new(f64::from(columns), f64::from(rows), 0.0);
        Ok(Self {
            numbers: target("numbers", NUMBERS),
            depth_stencil: target("depth and stencil", DEPTH_STENCIL_FORMAT),
            timer: PassTimer::new(gpu),
            faces: pipeline(gpu, &layout, None)?,
            strokes: [
                pipeline(gpu, &layout, Some(wgpu::CompareFunction::NotEqual))?,
                pipeline(gpu, &layout, Some(wgpu::CompareFunction::Equal))?,
            ],
            bound: gpu.bind_buffers("outlines", &layout, &[&constants]),
            constants,
            view: OutlineConstants {
                right: axis(camera.right / across, 0.0),
                up: axis(camera.up / high, 0.0),
                forward: axis(camera.forward, camera.near),
                size_px: axis(size, 0.0),
            },
            buffers,
            models: models.collect(),
            gpu: Arc::clone(gpu),
        })
    }

    /// Draws all models with their outlines and waits.
    ///
    /// - `width_px`: of strokes
    pub(crate) fn frame(&self, way: Way, width_px: u32) -> Result<Drawn, DeviceError> {
        let mut view = self.view;
        view.size_px[2] = 0.5 * width_px as f32;
        let (gpu, timer) = (&self.gpu, self.timer.as_ref());
        gpu.write_buffer(&self.constants, 0, bytemuck::bytes_of(&view));
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        if let Some(timer) = timer {
            timer.begin(&mut encoder, TimedPass::Surface);
        }
        let count = self.models.len();
        let starts = (0..count).filter(|model| way.value(*model).1);
        let starts: Vec<usize> = starts.chain([count]).collect();
        // A pass for each clear: WebGPU clears nothing within one.
        for run in starts.windows(2) {
            self.pass(&mut encoder, way, run[0]..run[1]);
        }
        gpu.queue.submit([encoder.finish()]);
        gpu.wait()?;
        let gpu_ms = timer.map(|timer| timer.pass_ms(gpu, TimedPass::Surface));
        Ok(Drawn {
            gpu_ms: gpu_ms.transpose()?.flatten(),
            clears: starts.len() - 1,
        })
    }

    /// Models after a clear of the stencil.
    fn pass(&self, encoder: &mut wgpu::CommandEncoder, way: Way, models: Range<usize>) {
        let is_first = models.start == 0;
        let timer = self
            .timer
            .as_ref()
            .filter(|_| models.end == self.models.len());
        let numbers = self.numbers.create_view(&Default::default());
        let depth_stencil = self.depth_stencil.create_view(&Default::default());
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("outlines"),
            color_attachments: &[Some(attached(
                &numbers,
                loaded(is_first, wgpu::Color::TRANSPARENT),
            ))],
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: &depth_stencil,
                depth_ops: Some(wgpu::Operations {
                    load: loaded(is_first, 0.0),
                    store: wgpu::StoreOp::Store,
                }),
                stencil_ops: Some(wgpu::Operations {
                    load: wgpu::LoadOp::Clear(NONE),
                    store: wgpu::StoreOp::Store,
                }),
            }),
            timestamp_writes: timer.map(|timer| timer.writes(None, Some(TimedPass::Surface))),
            ..Default::default()
        });
        let [vertices, faces, edges] = &self.buffers;
        pass.set_bind_group(0, &self.bound, &[]);
        pass.set_index_buffer(faces.slice(..), wgpu::IndexFormat::Uint32);
        let strokes = &self.strokes[usize::from(way == Way::ValueAsPrinted)];
        for model in models {
            let [own, outline] = &self.models[model];
            let number = index(model);
            pass.set_stencil_reference(way.value(model).0);
            pass.set_pipeline(&self.faces);
            pass.set_vertex_buffer(0, vertices.slice(..));
            pass.draw_indexed(own.clone(), 0, number..number + 1);
            pass.set_pipeline(strokes);
            pass.set_vertex_buffer(0, edges.slice(..));
            pass.draw(0..6, outline.clone());
        }
    }

    /// Number that each pixel shows, row by row from the top.
    pub(crate) fn read(&self) -> Result<Vec<u32>, DeviceError> {
        let bytes = read_texture(&self.gpu, &self.numbers, wgpu::TextureAspect::All)?;
        Ok(bytemuck::pod_collect_to_vec(&bytes))
    }
}

/// What a pass begins with: the value that a frame begins with, or what the pass before left.
fn loaded<V>(is_first: bool, begins_with: V) -> wgpu::LoadOp<V> {
    if is_first {
        wgpu::LoadOp::Clear(begins_with)
    } else {
        wgpu::LoadOp::Load
    }
}

/// - `passes`: where strokes pass by the stencil; `None`: of faces, which write it
fn pipeline(
    gpu: &Gpu,
    layout: &wgpu::BindGroupLayout,
    passes: Option<wgpu::CompareFunction>,
) -> Result<wgpu::RenderPipeline, DeviceError> {
    let module = gpu.shader(SHADER)?;
    let corner = wgpu::vertex_attr_array![0 => Float32x3];
    let edge = wgpu::vertex_attr_array![0 => Float32x3, 1 => Float32x3, 2 => Uint32];
    let (entries, attributes) = match passes {
        None => (["face_vertex", "face_fragment"], &corner[..]),
        Some(_) => (["stroke_vertex", "stroke_fragment"], &edge[..]),
    };
    let buffer = vertex_layout(attributes).map(|buffer| wgpu::VertexBufferLayout {
        step_mode: match passes {
            None => wgpu::VertexStepMode::Vertex,
            Some(_) => wgpu::VertexStepMode::Instance,
        },
        ..buffer
    });
    let stencil = wgpu::StencilFaceState {
        compare: passes.unwrap_or(wgpu::CompareFunction::Always),
        pass_op: match passes {
            None => wgpu::StencilOperation::Replace,
            Some(_) => wgpu::StencilOperation::Keep,
        },
        ..Default::default()
    };
    let (layout, targets) = (
        gpu.pipeline_layout("outlines", &[Some(layout)]),
        [Some(NUMBERS.into())],
    );
    let (mut own, buffers) = (described("outlines", &layout, &module, &targets), [buffer]);
    own.vertex.entry_point = Some(entries[0]);
    own.vertex.buffers = &buffers;
    if let Some(fragment) = &mut own.fragment {
        fragment.entry_point = Some(entries[1]);
    }
    let stencil = wgpu::StencilState {
        front: stencil,
        back: stencil,
        read_mask: 0xff,
        write_mask: 0xff,
    };
    own.depth_stencil = Some(wgpu::DepthStencilState {
        depth_write_enabled: Some(true),
        ..tested(wgpu::CompareFunction::Greater, stencil)
    });
    Ok(gpu.create_render_pipeline(&own))
}
