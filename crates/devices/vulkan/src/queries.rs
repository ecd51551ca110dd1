// SPDX-License-Identifier: MIT OR Apache-2.0
//! Timestamps, pipeline statistics and sample counts.
//!
//! A pair of stamps that is zero, or runs backwards, was not measured: drivers produce such values
//! (wgpu #6406, #9414), and a difference of them is no time.

use crate::Gpu;
use crate::failure::failure;
use crate::owned::Owned;
use ash::vk;
use std::sync::Arc;
use terrafill_contract::DeviceError;

/// Pipeline statistics of one fill, its passes added up.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct PassStatistics {
    /// Vertices shaded.
    pub vertex_shader_invocations: u64,
    /// Primitives that geometry shaders were given; none where the device has no such shaders.
    pub geometry_shader_invocations: Option<u64>,
    /// Primitives that geometry shaders made; none where the device has no such shaders.
    pub geometry_shader_primitives: Option<u64>,
    /// Primitives that reached clipping.
    pub clipper_invocations: u64,
    /// Primitives that left it.
    pub clipper_primitives_out: u64,
    /// Fragments shaded.
    pub fragment_shader_invocations: u64,
}

/// What a pool of queries counts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum QueryKind {
    Timestamps,
    Statistics,
    Samples,
}

/// A pool of queries.
#[derive(Debug)]
pub(crate) struct Queries {
    pub(crate) pool: Owned<vk::QueryPool>,
    pub(crate) kind: QueryKind,
    pub(crate) count: u32,
}

/// In the order of their bits, which is that of the results.
fn statistics(gpu: &Gpu) -> vk::QueryPipelineStatisticFlags {
    let counted = vk::QueryPipelineStatisticFlags::VERTEX_SHADER_INVOCATIONS
        | vk::QueryPipelineStatisticFlags::CLIPPING_INVOCATIONS
        | vk::QueryPipelineStatisticFlags::CLIPPING_PRIMITIVES
        | vk::QueryPipelineStatisticFlags::FRAGMENT_SHADER_INVOCATIONS;
    if gpu.facts.features.geometry_shader {
        counted
            | vk::QueryPipelineStatisticFlags::GEOMETRY_SHADER_INVOCATIONS
            | vk::QueryPipelineStatisticFlags::GEOMETRY_SHADER_PRIMITIVES
    } else {
        counted
    }
}

impl Queries {
    /// `None` where the device cannot count that, or none are asked for.
    pub(crate) fn new(
        gpu: &Arc<Gpu>,
        kind: QueryKind,
        count: u32,
    ) -> Result<Option<Self>, DeviceError> {
        let features = gpu.facts.features;
        let base = vk::QueryPoolCreateInfo::default().query_count(count);
        let (is_there, info) = match kind {
            QueryKind::Timestamps => (
                features.timestamps,
                base.query_type(vk::QueryType::TIMESTAMP),
            ),
            QueryKind::Statistics => (
                features.pipeline_statistics,
                base.query_type(vk::QueryType::PIPELINE_STATISTICS)
                    .pipeline_statistics(statistics(gpu)),
            ),
            QueryKind::Samples => (
                features.occlusion_query_precise,
                base.query_type(vk::QueryType::OCCLUSION),
            ),
        };
        if !is_there || count == 0 {
            return Ok(None);
        }
        // SAFETY: the count is not 0, and the kinds that need a feature were asked for it above.
        let pool = unsafe {
            let made = gpu.device.create_query_pool(&info, None);
            Owned::new(gpu, "queries", made)
        }?;
        Ok(Some(Self { pool, kind, count }))
    }

    /// How one is begun.
    pub(crate) fn flags(&self) -> vk::QueryControlFlags {
        match self.kind {
            QueryKind::Samples => vk::QueryControlFlags::PRECISE,
            QueryKind::Statistics | QueryKind::Timestamps => vk::QueryControlFlags::empty(),
        }
    }

    /// # Safety
    /// Recording is under way on their device, outside of a pass, and no other submission uses them.
    pub(crate) unsafe fn reset(&self, commands: vk::CommandBuffer) {
        let device = &self.pool.gpu().device;
        // SAFETY: the caller's promise; the pool has so many.
        unsafe { device.cmd_reset_query_pool(commands, self.pool.raw, 0, self.count) };
    }

    /// # Safety
    /// Recording is under way on their device; the query was reset, and none of its kind is open.
    pub(crate) unsafe fn begin(&self, commands: vk::CommandBuffer, query: u32) {
        let device = &self.pool.gpu().device;
        // SAFETY: the caller's promise.
        unsafe { device.cmd_begin_query(commands, self.pool.raw, query, self.flags()) };
    }

    /// # Safety
    /// As [`Queries::begin`], after it.
    pub(crate) unsafe fn end(&self, commands: vk::CommandBuffer, query: u32) {
        let device = &self.pool.gpu().device;
        // SAFETY: the caller's promise.
        unsafe { device.cmd_end_query(commands, self.pool.raw, query) };
    }

    /// Results of queries `first..first + count`, which have been written and waited for.
    pub(crate) fn read(&self, first: u32, count: u32) -> Result<Vec<u64>, DeviceError> {
        if count == 0 {
            return Ok(Vec::new());
        }
        let words_per_query = match self.kind {
            QueryKind::Statistics => statistics(self.pool.gpu()).as_raw().count_ones() as usize,
            QueryKind::Timestamps | QueryKind::Samples => 1,
        };
        let flags = vk::QueryResultFlags::TYPE_64 | vk::QueryResultFlags::WAIT;
        let raw = self.pool.raw;
        let device = &self.pool.gpu().device;
        // The stride is taken from the size of an element.
        let read = match words_per_query {
            1 => read_as::<1>(device, raw, first, count, flags),
            4 => read_as::<4>(device, raw, first, count, flags),
            _ => read_as::<6>(device, raw, first, count, flags),
        };
        read.map_err(|error| failure(error, "reading queries", 0))
    }

    /// Statistics of the first `passes` queries added up.
    pub(crate) fn read_statistics(&self, passes: u32) -> Result<PassStatistics, DeviceError> {
        let values = self.read(0, passes)?;
        let has_geometry = self.pool.gpu().facts.features.geometry_shader;
        Ok(sum_statistics(&values, has_geometry))
    }
}

fn read_as<const N: usize>(
    device: &ash::Device,
    pool: vk::QueryPool,
    first: u32,
    count: u32,
    flags: vk::QueryResultFlags,
) -> Result<Vec<u64>, vk::Result> {
    let mut results = vec![[0_u64; N]; count as usize];
    // SAFETY: the slice has room for that many results of N words each.
    unsafe { device.get_query_pool_results(pool, first, &mut results, flags)? };
    Ok(results.into_flattened())
}

fn sum_statistics(values: &[u64], has_geometry: bool) -> PassStatistics {
    let words = if has_geometry { 6 } else { 4 };
    let sum = |which: usize| values.iter().skip(which).step_by(words).sum();
    let after = words - 4;
    PassStatistics {
        vertex_shader_invocations: sum(0),
        geometry_shader_invocations: has_geometry.then(|| sum(1)),
        geometry_shader_primitives: has_geometry.then(|| sum(2)),
        clipper_invocations: sum(1 + after),
        clipper_primitives_out: sum(2 + after),
        fragment_shader_invocations: sum(3 + after),
    }
}

/// GPU time of what is recorded between its begin and its end; nothing without stamps.
#[derive(Clone, Copy)]
pub(crate) struct Span<'a> {
    stamps: Option<&'a Queries>,
    /// Of its two stamps.
    first: u32,
}

impl<'a> Span<'a> {
    /// - `first`: number of its first stamp; the other one follows
    pub(crate) fn new(stamps: Option<&'a Queries>, first: u32) -> Self {
        Self { stamps, first }
    }

    /// # Safety
    /// Recording is under way on the stamps' device, outside of a pass, and no other submission uses them.
    pub(crate) unsafe fn begin(self, commands: vk::CommandBuffer) {
        if let Some(stamps) = self.stamps {
            let device = &stamps.pool.gpu().device;
            let start = vk::PipelineStageFlags::TOP_OF_PIPE;
            // SAFETY: the caller's promise.
            unsafe {
                device.cmd_reset_query_pool(commands, stamps.pool.raw, self.first, 2);
                device.cmd_write_timestamp(commands, start, stamps.pool.raw, self.first);
            }
        }
    }

    /// # Safety
    /// As [`Span::begin`], after it.
    pub(crate) unsafe fn end(self, commands: vk::CommandBuffer) {
        if let Some(stamps) = self.stamps {
            let end = vk::PipelineStageFlags::BOTTOM_OF_PIPE;
            let device = &stamps.pool.gpu().device;
            // SAFETY: the caller's promise.
            unsafe { device.cmd_write_timestamp(commands, end, stamps.pool.raw, self.first + 1) };
        }
    }

    /// Milliseconds, once the submission was waited for.
    pub(crate) fn ms(self) -> Result<Option<f64>, DeviceError> {
        let Some(stamps) = self.stamps else {
            return Ok(None);
        };
        let ticks = stamps.read(self.first, 2)?;
        Ok(span_ms(
            ticks[0],
            ticks[1],
            stamps.pool.gpu().timestamp_period_ns(),
        ))
    }
}

/// Milliseconds from one stamp to another.
pub(crate) fn span_ms(begin: u64, end: u64, period_ns: f32) -> Option<f64> {
    let is_valid = begin != 0 && end >= begin;
    is_valid.then(|| (end - begin) as f64 * f64::from(period_ns) * 1e-6)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn zero_and_backward_stamps_are_not_measured() {
        assert_eq!(span_ms(10, 2_000_010, 1.0), Some(2.0));
        assert_eq!(span_ms(0, 5, 1.0), None);
        assert_eq!(span_ms(9, 8, 1.0), None);
        assert_eq!(span_ms(7, 7, 1.0), Some(0.0));
    }

    #[test]
    fn passes_are_added_up_each_counter_on_its_own() {
        let six = [1, 6, 2, 3, 4, 5, 10, 60, 20, 30, 40, 50];
        let summed = sum_statistics(&six, true);
        assert_eq!(summed.vertex_shader_invocations, 11);
        assert_eq!(summed.geometry_shader_invocations, Some(66));
        assert_eq!(summed.geometry_shader_primitives, Some(22));
        assert_eq!(summed.clipper_invocations, 33);
        assert_eq!(summed.clipper_primitives_out, 44);
        assert_eq!(summed.fragment_shader_invocations, 55);
        let four = sum_statistics(&[1, 2, 3, 4, 10, 20, 30, 40], false);
        assert_eq!(four.geometry_shader_invocations, None);
        assert_eq!(four.geometry_shader_primitives, None);
        assert_eq!(four.clipper_invocations, 22);
        assert_eq!(four.fragment_shader_invocations, 44);
    }
}
