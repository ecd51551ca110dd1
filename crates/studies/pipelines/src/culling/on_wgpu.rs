// SPDX-License-Identifier: MIT OR Apache-2.0
//! Culling on wgpu: by compute or on the CPU. It has no geometry shaders; its mesh shaders, an experiment, draw grids alone.

use super::culls::{Culls, Kept, Sent, Shown, constants, listed};
use super::ground::Ground;
use super::way::{CullStage, CullWay};
use crate::draws::{Counted, Times};
use crate::on_wgpu::{
    bind, compute_pipeline, draw_pipeline, heights, storage_type, texture_type, uniform_type,
};
use std::rc::Rc;
use std::sync::Arc;
use terrafill_contract::{CpuStopwatch, DeviceError};
use terrafill_gpu::{Gpu, RenderTargets, read_buffer};
use terrafill_scene::ImageSize;
use terrafill_shapes::grid::GridCamera;

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
    view: GridCamera,
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
        view: &GridCamera,
        size: ImageSize,
    ) -> Result<Self, DeviceError> {
        let (gpu, ground) = (&shared.gpu, &shared.ground);
        let entry_point = match way.place {
            CullStage::TilesAlone => "of_tiles",
            CullStage::Cpu | CullStage::Compute => "of_list",
            CullStage::Geometry => {
                return Err(DeviceError::unsupported("geometry shaders", "WebGPU"));
            }
            CullStage::Task => return Err(DeviceError::unsupported("task shaders", "WebGPU")),
        };
        let constants = constants(ground, view, way.test);
        let bytes = bytemuck::bytes_of(&constants);
        let constants = gpu.upload("ground", bytes, wgpu::BufferUsages::UNIFORM)?;
        let storage = wgpu::BufferUsages::STORAGE;
        let buffer = |label, count: usize, usage| {
            let copied = wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::COPY_SRC;
            gpu.unwritten(label, 4 * count as u64, usage | copied)
        };
        let tiles = buffer("tiles", ground.tile_boxes.len(), storage);
        let kept = buffer("patches", ground.patch_boxes.len(), storage);
        let arguments = storage | wgpu::BufferUsages::INDIRECT;
        let arguments = buffer("draw arguments", 4, arguments);
        let base = |stage| {
            [
                (stage | wgpu::ShaderStages::FRAGMENT, uniform_type()),
                (stage, texture_type(wgpu::TextureViewDimension::D2)),
                (stage, storage_type(true)),
                (stage, storage_type(true)),
            ]
        };
        let resources = [
            constants.as_entire_binding(),
            wgpu::BindingResource::TextureView(&shared.heights),
            shared.boxes.as_entire_binding(),
            tiles.as_entire_binding(),
            kept.as_entire_binding(),
            arguments.as_entire_binding(),
        ];
        let vertex = wgpu::ShaderStages::VERTEX;
        let types = base(vertex)
            .into_iter()
            .chain([(vertex, storage_type(true))]);
        let (layout, bound) = bind(gpu, types, resources[..5].iter().cloned());
        let pipeline = draw_pipeline(gpu, "pipelines/culled.wgsl", entry_point, &layout)?;
        let compute = match way.place {
            CullStage::Compute => {
                let stage = wgpu::ShaderStages::COMPUTE;
                let own = [(stage, storage_type(false)); 2];
                let (layout, bound) = bind(gpu, base(stage).into_iter().chain(own), resources);
                let path = "pipelines/cull.wgsl";
                let compute = compute_pipeline(gpu, path, "compute_main", &[Some(&layout)])?;
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

    /// Culls tiles, sends what is sent, tests and draws.
    fn frame(&mut self) -> Result<Sent, DeviceError> {
        let gpu = &self.shared.gpu;
        let sent = Sent::new(&self.shared.ground, &self.view, self.way.place);
        gpu.write_buffer(&self.tiles, 0, bytemuck::cast_slice(&sent.tiles));
        if let Some(patches) = &sent.patches {
            gpu.write_buffer(&self.kept, 0, bytemuck::cast_slice(patches));
        }
        if let Some(arguments) = &sent.arguments {
            gpu.write_buffer(&self.arguments, 0, bytemuck::cast_slice(arguments));
        }
        let mut frame = self.targets.direct_frame();
        if let Some((compute, bound)) = &self.compute {
            let mut pass = frame.encoder.begin_compute_pass(&Default::default());
            pass.set_pipeline(compute);
            pass.set_bind_group(0, bound, &[]);
            pass.dispatch_workgroups(sent.in_tiles.div_ceil(GROUP), 1, 1);
        }
        let mut pass = self.targets.cleared_pass(&mut frame);
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, &self.bound, &[]);
        pass.draw_indirect(&self.arguments, 0);
        drop(pass);
        gpu.queue.submit([frame.encoder.finish()]);
        gpu.wait()?;
        Ok(sent)
    }
}

impl Culls for OnWgpu {
    fn draw(&mut self) -> Result<Shown, DeviceError> {
        let sent = self.frame()?;
        let gpu = &self.shared.gpu;
        let words = |buffer: &wgpu::Buffer| -> Result<Vec<u32>, DeviceError> {
            Ok(bytemuck::pod_collect_to_vec(&read_buffer(gpu, buffer)?))
        };
        Ok(Shown {
            picture: self.targets.read()?,
            sent_bytes: sent.bytes(),
            kept: match (self.way.place, &sent.patches) {
                (CullStage::Compute, _) => listed(&words(&self.arguments)?, words(&self.kept)?),
                (_, Some(patches)) => Kept::List(patches.clone()),
                (_, None) => Kept::List(sent.of_tiles(&self.shared.ground)),
            },
            counted: Counted::default(),
        })
    }

    fn time(&mut self) -> Result<Times, DeviceError> {
        let watch = CpuStopwatch::start();
        self.frame()?;
        let times = Times::since(&watch, None);
        let gpu_ms = self.targets.direct_ms()?;
        Ok(Times { gpu_ms, ..times })
    }
}
