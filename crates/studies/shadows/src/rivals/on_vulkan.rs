// SPDX-License-Identifier: MIT OR Apache-2.0
//! Rays to the sun, by ray queries in a compute shader on Vulkan.

use crate::casting::{Casting, mask_of};
use std::sync::Arc;
use terrafill_contract::{Counters, CpuStopwatch, DeviceError, Devices, FrameTimes, SurfaceView};
use terrafill_shadow_views::{Channel, Draws};
use terrafill_vulkan::{
    Buffer, BufferUse, ComputePipeline, Dispatch, Gpu, RenderTargets, Resource, Resources, Shader,
    StateStep, TriangleTree, advance, shared_gpu,
};

const SHADER: Shader = Shader::Wgsl {
    path: "casters/rays.wgsl",
    entry_point: "ask",
};
/// Pixels along a group.
const GROUP: u32 = 8;

/// Buffers, tree and pipeline for one view.
pub(super) struct Rays {
    gpu: Arc<Gpu>,
    pipeline: ComputePipeline,
    groups: [u32; 3],
    answers: Arc<Buffer>,
}

impl Rays {
    pub(super) fn open(
        devices: &Devices,
        seen: SurfaceView<'_>,
        casting: &Casting,
    ) -> Result<Channel, DeviceError> {
        let gpu = shared_gpu(devices)?;
        if !gpu.facts.features.ray_query {
            let what = "rays in shaders (VK_KHR_ray_query)";
            return Err(DeviceError::unsupported(what, &gpu.facts.name));
        }
        let mut targets = RenderTargets::new(&gpu, seen.size)?;
        targets.prepare(seen)?;
        targets.draw_surface()?;
        let depths = targets.read()?.depth;
        let places = casting.places.iter().map(|&[x, y, z, _]| [x, y, z]);
        let triangles = casting.triangles.iter().map(|&[a, b, c, _]| [a, b, c]);
        let (places, triangles): (Vec<_>, Vec<_>) = (places.collect(), triangles.collect());
        let tree = Arc::new(TriangleTree::new(&gpu, &places, &triangles)?);
        let upload = |label, bytes: &[u8], use_for| {
            Buffer::upload(&gpu, label, bytes, use_for).map(Arc::new)
        };
        let receivers = bytemuck::bytes_of(&casting.receivers);
        let receivers = upload("receivers", receivers, BufferUse::Uniform)?;
        let storage = BufferUse::Storage;
        let depths = upload("depths", bytemuck::cast_slice(&depths), storage)?;
        let places = upload("places", bytemuck::cast_slice(&casting.places), storage)?;
        let corners = bytemuck::cast_slice(&casting.triangles);
        let triangles = upload("triangles", corners, storage)?;
        let [width, height] = casting.receivers.size;
        let size = u64::from(width) * u64::from(height) * size_of::<u32>() as u64;
        let answers = Arc::new(Buffer::unwritten(&gpu, "answers", size, BufferUse::State)?);
        let held = [&receivers, &depths, &places, &triangles, &answers];
        let held: u64 = held.iter().map(|buffer| buffer.size()).sum();
        let (build_ms, of_tree) = (tree.build_ms(), tree.bytes());
        let resources = Resources::new(
            &gpu,
            vec![
                Resource::Uniform(receivers),
                Resource::Storage(depths),
                Resource::Storage(places),
                Resource::Storage(triangles),
                Resource::Triangles(tree),
                Resource::Storage(Arc::clone(&answers)),
            ],
        )?;
        let rays = Self {
            pipeline: ComputePipeline::new(&gpu, &resources, SHADER)?,
            groups: [width.div_ceil(GROUP), height.div_ceil(GROUP), 1],
            answers,
            gpu,
        };
        Ok(Channel {
            draws: Box::new(rays),
            // Another sun changes the direction alone.
            bytes: [held + of_tree, 16],
            build_ms,
            left_out: 0,
        })
    }

    /// Answers, and gives the GPU time.
    fn run(&self) -> Result<Option<f64>, DeviceError> {
        let dispatch = Dispatch {
            pipeline: &self.pipeline,
            groups: self.groups,
        };
        Ok(advance(&self.gpu, &[StateStep::Dispatch(dispatch)])?.gpu_ms)
    }
}

impl Draws for Rays {
    fn draw(&mut self) -> Result<(Counters, Vec<bool>), DeviceError> {
        self.run()?;
        let mask = mask_of(&self.answers.contents(&self.gpu)?);
        Ok((Counters::default(), mask))
    }

    fn time(&mut self) -> Result<FrameTimes, DeviceError> {
        let watch = CpuStopwatch::start();
        let fill_gpu_ms = self.run()?;
        Ok(FrameTimes {
            fill_cpu_ms: watch.cpu_ms(),
            fill_wall_ms: watch.wall_ms(),
            fill_gpu_ms,
            ..FrameTimes::default()
        })
    }
}
