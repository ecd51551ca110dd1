// SPDX-License-Identifier: MIT OR Apache-2.0
//! Pipeline statistics: exact counts of the work that a frame's passes gave the device.

use crate::Gpu;
use crate::queries::Queries;
use crate::render_pipeline::described;
use crate::volume_pipeline::{unchanged, unwritten_target};
use terrafill_contract::{Counters, DeviceError};

/// Pipeline statistics of a frame's passes.
#[derive(Debug)]
pub(crate) struct Statistics {
    queries: Queries,
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
        let ty = wgpu::QueryType::PipelineStatistics(types);
        let queries = Queries::new(gpu, "pipeline statistics", ty, passes, STATISTICS as u64);
        Some(Self { queries, passes })
    }

    /// Begins the query of a pass.
    pub(crate) fn begin(&self, pass: &mut wgpu::RenderPass<'_>, index: usize) {
        let index = u32::try_from(index).unwrap_or(u32::MAX);
        pass.begin_pipeline_statistics_query(&self.queries.set, index);
    }

    /// Fragments of each query.
    pub(crate) fn fragments(&self, gpu: &Gpu) -> Result<Vec<u64>, DeviceError> {
        let values = self.queries.read(gpu, 0..self.passes)?;
        Ok(values.into_iter().skip(3).step_by(STATISTICS).collect())
    }

    /// Sums the passes: geometry counts of the volumes, fragments of the covers (volumes have no
    /// fragment shader).
    pub(crate) fn read_into(&self, gpu: &Gpu, counters: &mut Counters) -> Result<(), DeviceError> {
        let values = self.queries.read(gpu, 0..self.passes)?;
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
    let (shader, layout) = (
        gpu.shader("baseline/floor.wgsl")?,
        gpu.pipeline_layout(label, &[]),
    );
    let targets = [Some(unwritten_target())];
    let descriptor = wgpu::RenderPipelineDescriptor {
        depth_stencil: Some(unchanged(wgpu::CompareFunction::Always)),
        ..described(label, &layout, &shader, &targets)
    };
    Ok(gpu.device.create_render_pipeline(&descriptor))
}
