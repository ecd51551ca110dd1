// SPDX-License-Identifier: MIT OR Apache-2.0
//! Pipeline statistics: exact counts of the work that a frame's passes gave the device.

use crate::volume_pipeline::{unchanged, unwritten_target};
use crate::{Gpu, read_buffer};
use terrafill_contract::{Counters, DeviceError};

/// Pipeline statistics of a frame's passes.
#[derive(Debug)]
pub(crate) struct Statistics {
    queries: wgpu::QuerySet,
    resolved: wgpu::Buffer,
    passes: u32,
}

/// Vertex shader, clipper in, clipper out, fragment shader: in the order of the bits.
const STATISTICS: usize = 4;

impl Statistics {
    pub(crate) fn new(gpu: &Gpu, passes: usize) -> Option<Self> {
        let passes = u32::try_from(passes).ok()?;
        if !gpu.facts.features.pipeline_statistics || passes == 0 {
            return None;
        }
        let types = wgpu::PipelineStatisticsTypes::VERTEX_SHADER_INVOCATIONS
            | wgpu::PipelineStatisticsTypes::CLIPPER_INVOCATIONS
            | wgpu::PipelineStatisticsTypes::CLIPPER_PRIMITIVES_OUT
            | wgpu::PipelineStatisticsTypes::FRAGMENT_SHADER_INVOCATIONS;
        let queries = gpu.device.create_query_set(&wgpu::QuerySetDescriptor {
            label: Some("pipeline statistics"),
            ty: wgpu::QueryType::PipelineStatistics(types),
            count: passes,
        });
        // Made on the device itself, not counted as the fill's: only measuring needs it.
        let resolved = gpu.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("pipeline statistics"),
            size: u64::from(passes) * STATISTICS as u64 * 8,
            usage: wgpu::BufferUsages::QUERY_RESOLVE | wgpu::BufferUsages::COPY_SRC,
            mapped_at_creation: false,
        });
        Some(Self {
            queries,
            resolved,
            passes,
        })
    }

    /// Begins the query of a pass.
    pub(crate) fn begin(&self, pass: &mut wgpu::RenderPass<'_>, index: usize) {
        let index = u32::try_from(index).unwrap_or(u32::MAX);
        pass.begin_pipeline_statistics_query(&self.queries, index);
    }

    /// Fragments of each query.
    pub(crate) fn fragments(&self, gpu: &Gpu) -> Result<Vec<u64>, DeviceError> {
        let values = self.read(gpu)?;
        Ok(values.into_iter().skip(3).step_by(STATISTICS).collect())
    }

    fn read(&self, gpu: &Gpu) -> Result<Vec<u64>, DeviceError> {
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        encoder.resolve_query_set(&self.queries, 0..self.passes, &self.resolved, 0);
        gpu.queue.submit([encoder.finish()]);
        let bytes = read_buffer(gpu, &self.resolved)?;
        Ok(bytemuck::pod_collect_to_vec(&bytes))
    }

    /// Sums the passes: geometry counts of the volumes, fragments of the covers (volumes have no
    /// fragment shader).
    pub(crate) fn read_into(&self, gpu: &Gpu, counters: &mut Counters) -> Result<(), DeviceError> {
        let values = self.read(gpu)?;
        let sum = |which: usize| values.iter().skip(which).step_by(STATISTICS).sum();
        counters.vertex_shader_invocations = Some(sum(0));
        counters.clipper_invocations = Some(sum(1));
        counters.clipper_primitives_out = Some(sum(2));
        counters.fragment_shader_invocations = Some(sum(3));
        Ok(())
    }
}

/// A triangle over the whole image that writes nothing, as volumes do where their fragments are counted. Only measuring
/// needs it, so that it is made uncounted.
pub(crate) fn whole_image(gpu: &Gpu) -> Result<wgpu::RenderPipeline, DeviceError> {
    let label = "whole image";
    let shader = gpu.shader("baseline/floor.wgsl")?;
    let target = [Some(unwritten_target())];
    Ok(gpu
        .device
        .create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some(label),
            layout: Some(&gpu.pipeline_layout(label, &[])),
            vertex: wgpu::VertexState {
                module: &shader,
                entry_point: Some("vertex_main"),
                compilation_options: Default::default(),
                buffers: &[],
            },
            fragment: Some(wgpu::FragmentState {
                module: &shader,
                entry_point: Some("fragment_main"),
                compilation_options: Default::default(),
                targets: &target,
            }),
            primitive: wgpu::PrimitiveState::default(),
            depth_stencil: Some(unchanged(wgpu::CompareFunction::Always)),
            multisample: wgpu::MultisampleState::default(),
            multiview_mask: None,
            cache: None,
        }))
}
