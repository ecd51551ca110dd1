// SPDX-License-Identifier: MIT OR Apache-2.0
//! Culling on wgpu: by compute or on the CPU. It has no geometry shaders and, in WGSL, no mesh shaders.

use super::culls::{Culls, Kept, Shown};
use super::frustum::Frustum;
use super::ground::{Ground, GroundConstants, PATCH_TRIANGLES};
use super::way::{CullWay, Place};
use crate::draws::{Counted, Times};
use crate::grid::View;
use crate::on_wgpu::{bind, buffer_type, draw_pipeline, entry, heights};
use std::rc::Rc;
use std::sync::Arc;
use terrafill_fill::{CpuStopwatch, DeviceError};
use terrafill_gpu::{Gpu, RenderTargets, read_buffer};
use terrafill_scene::ImageSize;

const PATCH_VERTICES: u32 = 3 * PATCH_TRIANGLES;
/// Patches that a workgroup tests.
const GROUP: u32 = 64;

/// What all ways read of the ground.
pub(crate) struct WgpuGround {
    gpu: Arc<Gpu>,
    heights: wgpu::TextureView,
    boxes: wgpu::Buffer,
    ground: Rc<Ground>,
}

impl WgpuGround {
    pub(crate) fn new(gpu: &Arc<Gpu>, ground: &Rc<Ground>) -> Result<Self, DeviceError> {
        let boxes = bytemuck::cast_slice(&ground.patch_boxes);
        Ok(Self {
            gpu: Arc::clone(gpu),
            heights: heights(gpu, &ground.grid)?,
            boxes: gpu.upload("patches' boxes", boxes, wgpu::BufferUsages::STORAGE)?,
            ground: Rc::clone(ground),
        })
    }
}

/// Ground by one way.
pub(crate) struct OnWgpu {
    shared: Rc<WgpuGround>,
    way: CullWay,
    view: View,
    targets: RenderTargets,
    pipeline: wgpu::RenderPipeline,
    bound: wgpu::BindGroup,
    compute: Option<(wgpu::ComputePipeline, wgpu::BindGroup)>,
    tiles: wgpu::Buffer,
    kept: wgpu::Buffer,
    arguments: wgpu::Buffer,
}

impl OnWgpu {
    pub(crate) fn new(
        shared: &Rc<WgpuGround>,
        way: CullWay,
        view: &View,
        size: ImageSize,
    ) -> Result<Self, DeviceError> {
        let (gpu, ground) = (&shared.gpu, &shared.ground);
        let entry_point = match way.place {
            Place::TilesAlone => "of_tiles",
            Place::Cpu | Place::Compute => "of_list",
            Place::Geometry => return Err(DeviceError::unsupported("geometry shaders", "WebGPU")),
            Place::Task => return Err(DeviceError::unsupported("task shaders", "WebGPU")),
        };
        let tiles = Frustum::new(view).tiles(ground);
        #[allow(clippy::cast_possible_truncation, reason = "there are 256 tiles")]
        let listed = tiles.len() as u32;
        let constants = GroundConstants::new(ground, view, listed, way.test);
        let bytes = bytemuck::bytes_of(&constants);
        let constants = gpu.upload("ground", bytes, wgpu::BufferUsages::UNIFORM)?;
        let storage = wgpu::BufferUsages::STORAGE;
        let buffer = |label, count: usize, usage| {
            gpu.create_buffer(&wgpu::BufferDescriptor {
                label: Some(label),
                size: 4 * count as u64,
                usage: usage | wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::COPY_SRC,
                mapped_at_creation: false,
            })
        };
        let tiles = buffer("tiles", ground.tile_boxes.len(), storage);
        let kept = buffer("patches", ground.patch_boxes.len(), storage);
        let arguments = storage | wgpu::BufferUsages::INDIRECT;
        let arguments = buffer("draw arguments", 4, arguments);
        let uniform = buffer_type(wgpu::BufferBindingType::Uniform);
        let float = wgpu::BindingType::Texture {
            sample_type: wgpu::TextureSampleType::Float { filterable: false },
            view_dimension: wgpu::TextureViewDimension::D2,
            multisampled: false,
        };
        let array = |read_only| buffer_type(wgpu::BufferBindingType::Storage { read_only });
        let base = |stage| {
            vec![
                entry(0, stage | wgpu::ShaderStages::FRAGMENT, uniform),
                entry(1, stage, float),
                entry(2, stage, array(true)),
                entry(3, stage, array(true)),
            ]
        };
        let view_of = wgpu::BindingResource::TextureView(&shared.heights);
        let resources = [
            constants.as_entire_binding(),
            view_of,
            shared.boxes.as_entire_binding(),
            tiles.as_entire_binding(),
            kept.as_entire_binding(),
            arguments.as_entire_binding(),
        ];
        let resources: Vec<_> = (0..)
            .zip(resources)
            .map(|(binding, resource)| wgpu::BindGroupEntry { binding, resource })
            .collect();
        let vertex = wgpu::ShaderStages::VERTEX;
        let mut entries = base(vertex);
        entries.push(entry(4, vertex, array(true)));
        let (layout, bound) = bind(gpu, &entries, &resources[..5]);
        let pipeline = draw_pipeline(gpu, "pipelines/culled.wgsl", entry_point, &layout)?;
        let compute = match way.place {
            Place::Compute => {
                let stage = wgpu::ShaderStages::COMPUTE;
                let mut entries = base(stage);
                entries.push(entry(4, stage, array(false)));
                entries.push(entry(5, stage, array(false)));
                let (layout, bound) = bind(gpu, &entries, &resources);
                let layout = gpu.pipeline_layout("cull patches", &[Some(&layout)]);
                let compute = gpu.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
                    label: Some("cull patches"),
                    layout: Some(&layout),
                    module: &gpu.shader("pipelines/cull.wgsl")?,
                    entry_point: Some("compute_main"),
                    compilation_options: Default::default(),
                    cache: None,
                });
                Some((compute, bound))
            }
            _ => None,
        };
        Ok(Self {
            shared: Rc::clone(shared),
            way,
            view: *view,
            targets: RenderTargets::new(gpu, size)?,
            pipeline,
            bound,
            compute,
            tiles,
            kept,
            arguments,
        })
    }

    /// Culls tiles, sends what is sent, tests and draws; bytes sent, and patches where the CPU tests them.
    fn frame(&mut self) -> Result<(u64, Option<Vec<u32>>), DeviceError> {
        let (gpu, ground) = (&self.shared.gpu, &self.shared.ground);
        let frustum = Frustum::new(&self.view);
        let tiles = frustum.tiles(ground);
        gpu.write_buffer(&self.tiles, 0, bytemuck::cast_slice(&tiles));
        #[allow(clippy::cast_possible_truncation, reason = "there are 256 tiles")]
        let in_tiles = tiles.len() as u32 * ground.patches_a_tile();
        let patches = match self.way.place {
            Place::Cpu => Some(frustum.patches(ground, &tiles)),
            _ => None,
        };
        let mut sent_bytes = 4 * tiles.len() as u64 + 16;
        if let Some(patches) = &patches {
            gpu.write_buffer(&self.kept, 0, bytemuck::cast_slice(patches));
            sent_bytes += 4 * patches.len() as u64;
        }
        #[allow(clippy::cast_possible_truncation, reason = "patches are far fewer")]
        let instances = match (&patches, self.way.place) {
            (Some(patches), _) => patches.len() as u32,
            (None, Place::Compute) => 0,
            _ => in_tiles,
        };
        let words = [PATCH_VERTICES, instances, 0, 0];
        gpu.write_buffer(&self.arguments, 0, bytemuck::cast_slice(&words));
        let mut frame = self.targets.direct_frame();
        if let Some((compute, bound)) = &self.compute {
            let mut pass = frame.encoder.begin_compute_pass(&Default::default());
            pass.set_pipeline(compute);
            pass.set_bind_group(0, bound, &[]);
            pass.dispatch_workgroups(in_tiles.div_ceil(GROUP), 1, 1);
        }
        let mut pass = self.targets.cleared_pass(&mut frame);
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, &self.bound, &[]);
        pass.draw_indirect(&self.arguments, 0);
        drop(pass);
        gpu.queue.submit([frame.encoder.finish()]);
        gpu.wait()?;
        Ok((sent_bytes, patches))
    }
}

impl Culls for OnWgpu {
    fn draw(&mut self) -> Result<Shown, DeviceError> {
        let (sent_bytes, patches) = self.frame()?;
        let gpu = &self.shared.gpu;
        let words = |buffer: &wgpu::Buffer| -> Result<Vec<u32>, DeviceError> {
            Ok(bytemuck::pod_collect_to_vec(&read_buffer(gpu, buffer)?))
        };
        let kept = match (patches, self.way.place) {
            (Some(patches), _) => patches,
            (None, Place::Compute) => {
                let count = words(&self.arguments)?[1] as usize;
                let mut patches = words(&self.kept)?;
                patches.truncate(count);
                patches
            }
            _ => {
                let ground = &self.shared.ground;
                let tiles = Frustum::new(&self.view).tiles(ground);
                tiles
                    .into_iter()
                    .flat_map(|tile| ground.patches_of(tile))
                    .collect()
            }
        };
        Ok(Shown {
            picture: self.targets.read()?,
            sent_bytes,
            kept: Kept::List(kept),
            counted: Counted::default(),
        })
    }

    fn time(&mut self) -> Result<Times, DeviceError> {
        let watch = CpuStopwatch::start();
        self.frame()?;
        let (cpu_ms, wall_ms) = (watch.cpu_ms(), watch.wall_ms());
        let gpu_ms = self.targets.direct_ms()?;
        Ok(Times {
            cpu_ms,
            wall_ms,
            gpu_ms,
        })
    }
}
